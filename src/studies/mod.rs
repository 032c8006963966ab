//! Floor 8: studies: one script for many values of its parameters, in a folder that is all of their state.
//!
//! A [`Plan`] lists the points that a [`Design`] asks for; [`compute`] computes one of them as a plain run with `--set`, and whoever wants
//! a point computed calls that: a pool of processes on this machine ([`here`]), a task of a cluster's scheduler ([`slurm`]), or a line of
//! a shell. [`collect`] makes the table. Nothing but files joins the three: a point is done when its record is there, and it is under way
//! while somebody holds the lock on its claim.

mod collect;
mod collected;
mod design;
mod draw;
mod folder;
pub mod here;
mod identifier;
mod page;
mod plan;
mod point;
mod record;
mod samples;
pub mod slurm;
mod study_file;
mod table;
mod transcript;
mod values;
mod watchdog;

pub use collect::collect;
pub use collected::Collected;
pub use design::{Design, Pairing, Rows};
pub use folder::{PointState, StudyFolder};
pub use plan::{Limits, Plan, Point, Scenario};
pub use point::{PointOutcome, compute};
pub use record::{Record, RecordOutcome};
pub use samples::{Sampling, SamplingMethod};
pub use study_file::{StudyFile, read_study_file};
pub use table::{StudyColumn, StudyTable};
pub use values::{Scale, Values, Varied};
pub use watchdog::Watchdog;
