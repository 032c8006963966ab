//! Floor 5: model, numbering, supports, residual and tangent of one step, Newton, time loop, ledger.

mod accept;
mod amplitude;
mod balance;
mod contact_quantities;
mod diagnosis;
mod error;
mod failed;
mod fields;
mod findings;
mod halvings;
mod impact;
mod ledger;
mod loads;
mod model;
mod newton;
mod pairs;
mod predictor;
mod quantities;
mod report;
mod run_findings;
mod settle;
mod simulation;
mod system;
mod time_loop;

pub use amplitude::{Amplitude, Constant, Hat, Ramp, Sine, Table, TimeFunction};
pub use error::{ModelError, StepError};
pub use fields::{BodyFields, ContactFields};
pub use halvings::Halving;
pub use ledger::{ContactTotals, LedgerRow, ProbeValues};
pub use model::{
    BodyBoundary, BodyDefinition, ContactDefinition, ContactMethod, Enforcement, InitialVelocity, Load, LoadKind, Model,
    ObstacleDefinition, Prescription, SelfContactDefinition, Support, TieDefinition, UpdateRule,
};
pub use pairs::{LargeMotion, MotionKind};
pub use report::{CyclingNode, FailureCause, FailureReport, IterationReport, Missing, TryReport};
pub use run_findings::{RunFinding, RunFindingKind};
pub use simulation::{Options, PhaseTimes, SettleReport, Simulation, State, Statistics};
