//! Names that nearly every file of `api/` uses: the description of a function, its arguments, its errors.

pub use super::arguments::{Argument, Arguments, Options};
pub use super::causes;
pub use super::failure::Failure;
pub use super::function::{Call, Form, Function, Topic, body};
pub use super::handle::Handle;
pub use super::host::Host;
pub use super::parameter::{Absent, Kind, Parameter};
pub use super::scan::Target;
