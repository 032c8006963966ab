//! Contact in space: facets of three and four nodes.

mod corners;
mod features;
mod gaps;
mod mortar;
mod pair;
mod slip;
mod vectors;

pub use corners::CornersInSpace;
pub use mortar::MortarInSpace;
