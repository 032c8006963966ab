//! Names that nearly every file of `api/` uses: the declaration of a function, its arguments, values and errors.

pub use rhai::{Array, Dynamic, Map};

pub use super::arguments::{Argument, Arguments, Options};
pub use super::causes;
pub use super::declaration::{column_of, function, method_of, property_of};
pub use super::failure::Failure;
pub use super::function::{Call, Function, Topic};
pub use super::handle::Handle;
pub use super::host::Host;
pub use super::parameter::{Absent, Kind, Parameter};
pub use super::scan::Target;
pub use super::values::{array_of, map_of};
pub use crate::math::catalogue::Interval;
