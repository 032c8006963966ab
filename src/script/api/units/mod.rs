//! Units: what a script declares, quantities with a unit, and models in other units.

mod conversion;
mod declared;
mod quantities;

pub use conversion::Units;
pub use declared::{DeclaredUnits, model_units, refused_unit};

use crate::script::language::function::Function;

/// Script functions of this topic.
pub fn functions() -> Vec<Function> {
    let mut all = vec![declared::units()];
    all.extend(quantities::functions());
    all
}
