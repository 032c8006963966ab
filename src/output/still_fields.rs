//! Quantities that stills have beyond displacement, velocity, stress and contact pressure, where a script asks for them.

use super::picture::Field;
use crate::dynamics::{BodyFields, LocalFrame};

/// Tensor rank of a quantity at a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rank {
    /// A number.
    Number,
    /// A vector.
    Vector,
    /// A symmetric tensor, with the components of the recorded stress.
    Tensor,
}

/// Quantity that stills (recorded animation frames) may have beyond those of every run.
pub struct Further {
    /// Name, as [`Field::source`] gives it.
    pub name: &'static str,
    /// Number of components.
    pub rank: Rank,
    /// A component at a node.
    pub component: fn(&mut BodyFields, usize, usize) -> &mut f64,
    /// Value of a component at a node.
    pub value: fn(&BodyFields, usize, usize) -> f64,
}

/// Row of the catalogue for a list of numbers, vectors or tensors of [`BodyFields`].
macro_rules! further {
    ($name:ident, $rank:ident $(, $component:ident)?) => {
        Further {
            name: stringify!($name),
            rank: Rank::$rank,
            component: |body, node, _component| &mut body.$name[node]$([{ let $component = _component; $component }])?,
            value: |body, node, _component| body.$name[node]$([{ let $component = _component; $component }])?,
        }
    };
}

/// All quantities that stills may have beyond those of every run.
pub static FURTHER: &[Further] = &[
    further!(strain, Tensor, component),
    further!(energy_density, Number),
    further!(acceleration, Vector, component),
    further!(contact_force, Vector, component),
    further!(contact_state, Number),
    further!(back_stress, Number),
    further!(stress_error, Number),
];

impl Field {
    /// Index into `FURTHER` of the quantity from which the field follows; `None` if every recording has that quantity.
    pub fn further(self) -> Option<usize> {
        FURTHER.iter().position(|further| further.name == self.source())
    }
}

/// Content of a recording of animation frames (stills).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StillOptions {
    /// Largest number of stills (at least 2); by default 160, or fewer if memory would be exceeded.
    pub most: Option<usize>,
    /// True if stills include the inside of bodies in space.
    pub has_inside: bool,
    /// Fields for which a script asks.
    pub fields: Vec<Field>,
    /// Frame of the fields with local components in the report.
    pub frame: LocalFrame,
}

impl StillOptions {
    /// True if a recording has the quantity from which a field follows.
    pub fn keeps(&self, field: Field) -> bool {
        field.further().is_none_or(|further| self.further().contains(&further))
    }

    /// Quantities beyond those of every recording, as ascending indices into `FURTHER`.
    pub fn further(&self) -> Vec<usize> {
        let mut all: Vec<usize> = self.fields.iter().filter_map(|field| field.further()).collect();
        all.sort_unstable();
        all.dedup();
        all
    }
}
