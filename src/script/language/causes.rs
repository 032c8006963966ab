//! Stable codes of calls that are not possible, one for each cause; `docs/errors.md` has a section for each.

/// Value of another type than the argument takes.
pub const WRONG_TYPE: &str = "C1021";
/// Number outside the range of the argument.
pub const OUT_OF_RANGE: &str = "C1022";
/// Missing argument or option.
pub const MISSING: &str = "C1023";
/// Option that the function does not have.
pub const UNKNOWN_OPTION: &str = "C1024";
/// Word that is not in the list of possible words.
pub const UNKNOWN_WORD: &str = "C1025";
/// Options that exclude or require each other.
pub const OPTIONS_TOGETHER: &str = "C1026";
/// Vector of length zero, or a boundary without a single normal.
pub const NO_DIRECTION: &str = "C1027";
/// Numbers in the wrong order.
pub const ORDER: &str = "C1028";
/// Wrong number of values.
pub const COUNT: &str = "C1029";
/// Name or number of an object that does not exist.
pub const NO_SUCH: &str = "C1030";
/// Name that is in use, or a second definition.
pub const NAME_TAKEN: &str = "C1032";
/// Call at a time or in a state of the simulation that does not permit it.
pub const TIME: &str = "C1033";
/// Object of another model, body or simulation.
pub const OTHER_OWNER: &str = "C1034";
/// Closure with other parameters or another result than expected.
pub const CLOSURE: &str = "C1035";
/// Function or option of another space dimension.
pub const DIMENSION: &str = "C1036";
/// Empty set of values, cells or facets.
pub const EMPTY: &str = "C1037";
/// File that cannot be read or has an unsuitable name.
pub const FILE: &str = "C1038";
/// Setting of the command line that does not fit the script.
pub const SETTING: &str = "C1039";
/// Quantity that this kind of object does not have.
pub const BODY_KIND: &str = "C1040";
