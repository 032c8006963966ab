//! Contact in space: facets of three and four nodes, and faces of second order that are split into them.

mod corners;
mod features;
mod gaps;
mod mortar;
mod pair;
mod second_order;
mod vectors;

pub use corners::CornersInSpace;
pub use mortar::MortarInSpace;
pub use second_order::SeenInSpace;
