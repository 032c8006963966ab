//! Interface of a simulation in either dimension.

use std::sync::Arc;

use super::ledger::LedgerRow;
use super::options::{Options, SettleReport};
use super::present_state::PresentState;
use super::run_findings::Measures;
use super::state::State;
use super::tally::Tally;
use super::validity::OutOfValidity;
use crate::dynamics::model::step_error::StepError;

/// Steps of a simulation in either dimension.
pub trait Steps: PresentState + Send {
    fn options_mut(&mut self) -> &mut Options;
    fn state(&self) -> &Arc<State>;
    fn tally(&self) -> Tally;
    fn count_from(&mut self, tally: &Tally);
    fn step(&mut self, end: Option<f64>, accepted: &mut dyn FnMut(&LedgerRow)) -> Result<(), StepError>;
    fn settle(&mut self, time: f64, friction: bool) -> Result<SettleReport, StepError>;
    fn excesses(&self) -> Vec<OutOfValidity>;
    fn stress_errors(&self) -> Vec<(&str, f64)>;
    fn measures(&self) -> Measures<'_>;
}
