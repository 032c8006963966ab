//! Floor 5 of `ARCHITECTURE.md`: models, their equations, steps, runs. Dependencies have one direction: `run` uses `step`, `step` uses
//! `parts`, `parts` uses `model`.

mod model;
mod parts;
mod run;
mod step;

pub use model::amplitude::{Amplitude, Constant, Hat, Ramp, Rescaled, Sine, Table, TimeFunction, TimeFunctionError};
pub use model::couplings::{Coupling, CouplingKind, Sector};
pub use model::definitions::{BodyDefinition, Growth, InitialDisplacement, InitialVelocity, Load, LoadKind, Model, Support};
pub use model::error::ModelError;
pub use model::held::OverriddenDefinition;
pub use model::interactions::{
    BodyBoundary, Coefficient, Enforcement, Friction, Interaction, ObstacleRotation, Partner, PlaceFunction, obstacle_place,
};
pub use model::joints::{Anchor, Coordinate, Gear, JointDefinition, JointFriction, JointKind};
pub use model::locking::Locking;
pub use model::overlaps::{Overlap, OverlapKind};
pub use model::part::{Change, Iterate, Numbering, Part, PartDefinition, PartPlace, PartStepResult, Pose, Refusal, Sums};
pub use model::prescription::{AxisRotation, PrescribedMotion, Prescription};
pub use model::quantity::Quantity;
pub use model::remedy::{Remedy, SmallerIncrements};
pub use model::step_error::StepError;
pub use model::update_rules::{ActiveConstraints, GAP, PERSISTENCY, UPDATE_RULES, UpdateRule, VELOCITY, default_rule};
pub use parts::actuator::{ActuatorDefinition, ActuatorElement};
pub use parts::body_force::{BodyField, BodyForceDefinition};
pub use parts::bolt::{BoltDefinition, BoltElement};
pub use parts::bushing::BushingDefinition;
pub use parts::chamber::{ChamberDefinition, Gas};
pub use parts::damper::{DamperDefinition, DamperElement};
pub use parts::drag::{DragDefinition, DragTarget};
pub use parts::force_laws::{Elastic, Sides, SpringLaw, Viscous};
pub use parts::joint_ends::across;
pub use parts::line::{End, Line, LineDefinition, LineElement};
pub use parts::motor::MotorDefinition;
pub use parts::point_mass::PointMassDefinition;
pub use parts::rotating_frame::{RotatingFrameDefinition, Spin};
pub use parts::spring::{SpringDefinition, SpringElement};
pub use parts::torsion::TorsionDefinition;
pub use run::buckling::{Buckling, BucklingError};
pub use run::energy_account::EnergyAccount;
pub use run::fields::{
    BodyFields, BodyTotals, CellPlaces, CellStress, ContactFields, ContactSurface, JointFrictionLoad, JointLoad, NodeState, PlacedObstacle,
    RedundantConstraints, pressure, von_mises,
};
pub use run::halvings::Halving;
pub use run::harmonic::{Excitation, HarmonicError, HarmonicOptions, HarmonicResponse};
pub use run::ledger::{ContactTotals, JointTotals, LedgerRow, PartTotals, ProbeValues, Reaction};
pub use run::modes::{Mode, Modes, ModesError};
pub use run::node_fields::{NODE_FIELDS, NodeField, NodeValue};
pub use run::options::{Options, SettleReport, Statistics};
pub use run::pace::StepControl;
pub use run::paths::{CriticalKind, CriticalPoint, Path, PathEnd, PathError, PathOptions, PathPoint};
pub use run::point_fields::{LocalFrame, NODAL_FIELDS, POINT_FIELDS, PointField, PointValue, Principal, field_dimension, principal};
pub use run::present_state::PresentState;
pub use run::report::{CyclingNode, FailureCause, FailureReport, IterationReport, Missing, TryReport};
pub use run::rows::Rows;
pub use run::run_findings::{RunFinding, RunFindingKind};
pub use run::section_force::SectionForce;
pub use run::simulation::Simulation;
pub use run::stable_step::StableStep;
pub use run::state::State;
pub use run::tally::Tally;
pub use step::counters::PhaseTimes;
pub use step::large_motion::{LargeMotion, MotionKind};
