//! Options of a picture.

use std::borrow::Cow;

use super::field::{Field, Vectors};
use super::section::CutPlane;
use super::view::{Bounds, View};
use crate::dynamics::{BodyFields, LocalFrame};

/// A field as one panel of a picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panel {
    /// Field that determines the colors.
    pub field: Field,
    /// Values at the ends of the color bar; `None` for the range of the field. Fixed values make pictures comparable.
    pub range: Option<[f64; 2]>,
    /// Unit of the values; empty if not given.
    pub unit: String,
    /// Frame to which components refer.
    pub frame: LocalFrame,
}

/// Indicator of lengths in a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Measure {
    /// A bar of a round length.
    #[default]
    Bar,
    /// Axes with numbers around a plane picture.
    Axes,
    /// No indicator.
    Nothing,
}

impl Measure {
    /// All indicators with their names in scripts.
    pub const ALL: &'static [(&'static str, Measure)] = &[("bar", Measure::Bar), ("axes", Measure::Axes), ("none", Measure::Nothing)];
}

/// Visible region of a picture, common to all pictures of a movie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureBounds {
    /// Bounding box of the visible region in the plane of the picture.
    pub(super) bounds: Bounds,
    /// Magnitude of the longest vector shown by an arrow.
    pub(super) longest: f64,
}

impl PictureBounds {
    /// Returns the union of two visible regions.
    pub fn with(self, other: PictureBounds) -> PictureBounds {
        let corners = [self.bounds.low, self.bounds.high(), other.bounds.low, other.bounds.high()];
        PictureBounds { bounds: Bounds::of(corners.iter()), longest: self.longest.max(other.longest) }
    }
}

/// Options of a picture: fields, size, view, annotations.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureOptions {
    /// The fields, each in a panel of its own.
    pub panels: Vec<Panel>,
    /// Text above the picture.
    pub title: String,
    /// Width in pixels, at least 240: below, there is no room for the bodies beside the color bar.
    pub width: f64,
    /// View of bodies in space.
    pub view: View,
    /// Section plane through bodies in space.
    pub section: Option<CutPlane>,
    /// Names of the bodies that are shown; all if empty.
    pub only: Vec<String>,
    /// True if cell edges are drawn where there is room for them.
    pub is_meshed: bool,
    /// True if outlines of the undeformed bodies are drawn.
    pub is_undeformed_shown: bool,
    /// Vector field shown by arrows, and its unit.
    pub vectors: Option<(Vectors, String)>,
    /// Indicator of lengths.
    pub measure: Measure,
    /// Unit of lengths; empty if not given.
    pub length_unit: String,
    /// Visible region; `None` to determine it from the bodies.
    pub sight: Option<PictureBounds>,
}

impl PictureOptions {
    /// Returns the bodies that are shown.
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
