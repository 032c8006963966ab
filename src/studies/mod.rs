//! Floor 8 of `ARCHITECTURE.md`: studies: one script for many values of its parameters, with the complete state in a folder.
//!
//! A [`Plan`] lists the points of a [`Design`]; [`compute`] computes a point as a plain run with `--set`. It is called by a pool of
//! processes on this machine ([`here`]), a task of a cluster's scheduler ([`slurm`]), or a command in a shell. [`collect`] makes the table.
//! The three communicate through files only: a point is done when its record exists, and under way while its claim is locked.

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
