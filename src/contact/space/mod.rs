//! Contact in space: facets of three and four nodes, faces of second order divided into them, and rigid obstacles.

mod clipping;
mod closing;
mod corners;
mod corners_of_obstacles;
mod curved_face;
#[cfg(test)]
mod depth_study;
mod dual;
mod exact_profile;
mod facets;
mod features;
mod found;
mod gaps;
mod interior;
mod mending;
mod mortar;
mod nodes;
mod obstacle;
mod pair;
mod polygon;
mod press_fit;
mod profiles;
mod quadric;
mod rigid;
mod rolling;
mod round;
mod second_order;
mod slip;
mod stiffness;
mod tied;
mod uneven_fit;
mod vectors;
mod vertices;
mod view;

pub use corners::CornersInSpace;
pub use facets::{Facets, FacetsError};
pub use mending::Mending;
pub use mortar::MortarInSpace;
pub use obstacle::ObstacleInSpace;
pub(super) use obstacle::Shape as ShapeInSpace;
pub use press_fit::{PressFit, press_fit};
pub use rigid::RigidInSpace;
pub use round::RoundInSpace;
pub use second_order::ProxySurfacesInSpace;
pub use uneven_fit::{UnevenFit, uneven_fit};
