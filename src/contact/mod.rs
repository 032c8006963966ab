//! Contact of surfaces with each other and with rigid obstacles (floor 4 of `ARCHITECTURE.md`): surfaces, search, and one file for each
//! method.
//!
//! The **secondary** side carries the multipliers and is the domain of integration (in the literature *slave* or *nonmortar*); the other
//! side is the **primary** one (*master*, *mortar*).
//!
//! Signs: a constraint function `Phi_A(q) > 0` is open, a multiplier `lambda_A >= 0` is a pressure. The force of a step is
//! `sum_A lambda_A Gbar_A`, its work `sum_A lambda_A (Phi_A(q_1) - Phi_A(q_0))`.
//!
//! A [`ContactMethod`] is a row of [`METHODS`]. Its [`ContactKernel`] evaluates constraint functions as sums over contact elements
//! ([`Patches`]): small groups of nodes. Active sets and multipliers belong to `dynamics/step/`, one floor higher.

mod averaged;
mod averaged_overlap;
mod ball_slip;
mod bends;
mod chain;
mod checks;
mod clearance;
mod combinations;
mod depth;
mod edge_plane;
mod exact;
mod faces;
mod facet_shape;
#[cfg(test)]
mod fixtures;
mod friction;
mod geared;
mod joint_slip;
mod kernel;
mod method;
mod methods;
mod mortar;
mod multiplier_shapes;
mod node_arcs;
mod node_patch;
mod node_to_segment;
mod numbers;
mod obstacle_side;
mod on_curves;
mod pair;
mod pair_profiles;
mod pair_step;
mod patches;
mod placement;
mod points;
mod polygon_fit;
mod profile;
mod quadratic;
mod rigid;
mod rigid_contact;
mod rigid_corners;
mod rigid_shape;
mod rollers;
mod rolling;
mod rolling_contact;
mod round;
mod round_parts;
mod search;
mod slip;
mod slip_on_curves;
mod slivers;
mod solid;
mod space;
mod surface;
mod tie;
mod tilt;
mod tips;
mod turning;
mod unlike_nodes;
mod window;

pub use averaged::{AVERAGED_MORTAR, AveragedMortar};
pub use ball_slip::BallSlip;
pub use checks::{Finding, NamedSurface, check_surfaces, facing_away, looks_away};
pub use clearance::{Clearance, Nearest};
pub use exact::ExactShape;
pub use facet_shape::FacetShape;
pub use friction::{Coulomb, FrictionCurve, FrictionLaw, Limit, ROUGH, SlipState};
pub use geared::{CoordinateKind, Geared};
pub use joint_slip::JointSlip;
pub use kernel::{CandidateSearch, ContactKernel, Correction, PatchFunctions, RigidObstacle, Setting, TangentSink};
pub use method::{ContactMethod, MakeKernel};
pub use methods::METHODS;
pub use mortar::{DUAL_MORTAR, MORTAR, Mortar};
pub use node_to_segment::{NODE_TO_SEGMENT, NodeToSegment};
pub use patches::{Evaluation, Patches};
pub use placement::{ObstaclePlacement, TurningAxis};
pub use points::{DrivenFunction, PointConstraints, PointFunction, PointVector};
pub use polygon_fit::{PolygonFit, constant_strain_error, polygon_fit};
pub use profile::Profile;
pub use quadratic::{ProxyNodes, ProxySurfaces, RowsOf};
pub use rigid::{NodesOnObstacle, TouchingPoints};
pub use rigid_contact::rigid_contact;
pub use rigid_corners::RigidCorners;
pub use rigid_shape::Obstacle;
pub use rollers::RoundBody;
pub use rolling_contact::{rolling_contact, round_contact};
pub use round_parts::{Curvature, RoundPart, facets_of_coarse_circle, round_parts, whole_circle};
pub use search::{Candidates, PairSearch};
pub use slip::SlipStep;
pub use solid::{HullPenetration, Solid};
pub use space::{
    CornersInSpace, Facets, FacetsError, Mending, ObstacleInSpace, PressFit, ProxySurfacesInSpace, RoundInSpace, UnevenFit, press_fit,
    uneven_fit,
};
pub use surface::{Edge, Sides, Surface};
pub use tie::Tie;
pub use turning::TurningContact;
pub use unlike_nodes::has_unlike_nodes;
pub use window::{MotionBound, PredictedMotion};
