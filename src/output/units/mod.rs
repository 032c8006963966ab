//! Units of what scripts and files contain: names and expressions of units, consistent sets, the unit of a dimension in a set.

mod dimension;
mod expression;
mod listed;
mod scale;
mod set;
mod table;
mod unit;

pub use dimension::Dimension;
pub use expression::UnitError;
pub use listed::{ListedUnits, UNITS_FILE, read_units};
pub use scale::Scale;
pub use set::{ModelUnits, SETS, UnitSet, UnitSetError, pretty};
pub use unit::Unit;
