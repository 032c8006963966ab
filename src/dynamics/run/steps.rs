//! Interface of a simulation in either dimension.

use std::sync::Arc;

use super::buckling::{Buckling, BucklingError};
use super::fields::{
    BodyFields, BodyTotals, CellPlaces, CellStress, ContactFields, ContactSurface, JointLoad, PlacedObstacle, RedundantConstraints,
};
use super::halvings::Halving;
use super::harmonic::{HarmonicError, HarmonicOptions, HarmonicResponse};
use super::ledger::LedgerRow;
use super::modes::{Modes, ModesError};
use super::options::{Options, SettleReport, Statistics};
use super::paths::{Path, PathError, PathOptions};
use super::report::FailureReport;
use super::run_findings::{Measures, RunFinding};
use super::section_force::SectionForce;
use super::stable_step::StableStep;
use super::state::State;
use super::tally::Tally;
use super::validity::OutOfValidity;
use crate::dynamics::model::step_error::StepError;

/// Interface of a simulation in either dimension.
pub trait Steps: Send {
    fn dimension(&self) -> usize;
    fn options(&self) -> &Options;
    fn options_mut(&mut self) -> &mut Options;
    fn unknowns(&self) -> usize;
    fn state(&self) -> &Arc<State>;
    fn restore(&mut self, state: &State);
    fn look(&mut self);
    fn recall(&mut self, row: &LedgerRow);
    fn tally(&self) -> Tally;
    fn count_from(&mut self, tally: &Tally);
    fn step(&mut self, end: Option<f64>, accepted: &mut dyn FnMut(&LedgerRow)) -> Result<(), StepError>;
    fn settle(&mut self, time: f64, friction: bool) -> Result<SettleReport, StepError>;
    fn modes(&mut self, count: usize) -> Result<Modes, ModesError>;
    fn harmonic_response(&mut self, options: &HarmonicOptions) -> Result<HarmonicResponse, HarmonicError>;
    fn buckling(&mut self, count: usize) -> Result<Buckling, BucklingError>;
    fn stable_step(&mut self) -> Result<StableStep, StepError>;
    fn path(&mut self, options: &PathOptions, told: &mut dyn FnMut(&LedgerRow)) -> Result<Path, PathError>;
    fn prescribed_jump(&self) -> Result<Option<(String, f64)>, StepError>;
    fn check_apart(&self) -> Result<(), StepError>;
    fn watch(&mut self, node: usize);
    fn watched(&self) -> &[usize];
    fn fields(&self) -> Vec<BodyFields>;
    fn body(&self, body: usize) -> BodyTotals;
    fn cell_stresses(&self, body: usize, places: CellPlaces) -> Vec<CellStress>;
    fn section_force(&self, body: usize, point: [f64; 3], normal: [f64; 3]) -> Option<SectionForce>;
    fn excesses(&self) -> Vec<OutOfValidity>;
    fn redundant_constraints(&self) -> Vec<RedundantConstraints>;
    fn stress_errors(&self) -> Vec<(&str, f64)>;
    fn loose_joints(&self) -> Vec<(String, f64)>;
    fn joint(&self, name: &str) -> Option<JointLoad>;
    fn obstacles(&self) -> Vec<PlacedObstacle>;
    fn contact(&self, name: &str) -> Option<ContactFields>;
    fn contact_surfaces(&self) -> Vec<ContactSurface>;
    fn closed_nodes(&self) -> Vec<usize>;
    fn friction_multipliers(&self) -> Vec<[f64; 2]>;
    fn failure(&self) -> Option<&FailureReport>;
    fn failed_fields(&self) -> Option<Vec<BodyFields>>;
    fn halvings(&self) -> &[Halving];
    fn measures(&self) -> Measures<'_>;
    fn findings_at_start(&self) -> Vec<RunFinding>;
    fn rank_bytes(&self) -> &[u64];
    fn statistics(&self) -> Statistics;
}
