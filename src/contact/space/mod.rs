//! Contact in space: facets of three and four nodes.

mod mortar;
mod pair;

pub use mortar::MortarInSpace;
