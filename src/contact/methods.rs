//! The catalogue of contact methods.

use super::averaged::AVERAGED_MORTAR;
use super::method::ContactMethod;
use super::mortar::{DUAL_MORTAR, MORTAR};
use super::node_to_segment::NODE_TO_SEGMENT;

/// All contact methods, in the order of the reference.
pub static METHODS: &[&ContactMethod] = &[&MORTAR, &DUAL_MORTAR, &AVERAGED_MORTAR, &NODE_TO_SEGMENT];
