//! What a picture shows and how.

use std::borrow::Cow;

use super::field::{Field, Vectors};
use super::section::CutPlane;
use super::view::{Bounds, View};
use crate::dynamics::BodyFields;

/// A field as one panel of a picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panel {
    /// The field that gives the colors.
    pub field: Field,
    /// Values at the ends of the color bar; those of the field where there is none. Give one to make pictures comparable.
    pub range: Option<[f64; 2]>,
    /// Unit of the values, empty where none is told.
    pub unit: String,
}

/// What tells lengths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Measure {
    /// A bar of a round length.
    #[default]
    Bar,
    /// Axes with numbers around a plane picture.
    Axes,
    /// Nothing.
    Nothing,
}

impl Measure {
    /// All of them with their names in a script.
    pub const ALL: &'static [(&'static str, Measure)] = &[("bar", Measure::Bar), ("axes", Measure::Axes), ("none", Measure::Nothing)];
}

/// What is in sight of a picture: the same for all pictures of a movie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// Box of what is seen, in the plane of the picture.
    pub(super) bounds: Bounds,
    /// Size of the longest vector that is shown by an arrow.
    pub(super) longest: f64,
}

impl Sight {
    /// What two pictures see.
    pub fn with(self, other: Sight) -> Sight {
        let corners = [self.bounds.low, self.bounds.high(), other.bounds.low, other.bounds.high()];
        Sight { bounds: Bounds::of(corners.iter()), longest: self.longest.max(other.longest) }
    }
}

/// What a picture shows and how.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureOptions {
    /// The fields, each in a panel of its own.
    pub panels: Vec<Panel>,
    /// Text above the picture.
    pub title: String,
    /// Width in pixels; below 240 there would be no room for the bodies beside the color bar, so 240 is taken.
    pub width: f64,
    /// From where bodies in space are seen.
    pub view: View,
    /// A plane that opens bodies in space.
    pub section: Option<CutPlane>,
    /// Names of the bodies that are shown; all of them where there is none.
    pub only: Vec<String>,
    /// Whether cell edges are drawn where there is room for them.
    pub is_meshed: bool,
    /// Whether the undeformed bodies are outlined.
    pub is_undeformed_shown: bool,
    /// What is shown by arrows, with its unit.
    pub vectors: Option<(Vectors, String)>,
    /// What tells lengths.
    pub measure: Measure,
    /// Unit of lengths, empty where none is told.
    pub length_unit: String,
    /// What is in sight, where it is not to be found from the bodies.
    pub sight: Option<Sight>,
}

impl PictureOptions {
    /// Those of the bodies that are shown.
    pub(super) fn shown_of<'a>(&self, bodies: &'a [BodyFields]) -> Cow<'a, [BodyFields]> {
        if self.only.is_empty() {
            return Cow::Borrowed(bodies);
        }
        bodies.iter().filter(|body| self.only.contains(&body.name)).cloned().collect()
    }
}

impl Default for PictureOptions {
    fn default() -> Self {
        PictureOptions {
            panels: vec![Panel::default()],
            title: String::new(),
            width: 720.0,
            view: View::default(),
            section: None,
            only: Vec::new(),
            is_meshed: true,
            is_undeformed_shown: false,
            vectors: None,
            measure: Measure::default(),
            length_unit: String::new(),
            sight: None,
        }
    }
}
