//! `settle` at a later time: in one increment or, if that fails, in several increments of time, from equilibrium to equilibrium.
//!
//! Loads, prescribed motions and obstacles follow their functions of time. Increments are reduced after a failure and enlarged after a
//! success; intermediate equilibria are less accurate than the last one. If even a small increment fails, a limit point may have been
//! reached: damped steps may then find an equilibrium beyond it (snap-through). Obstacles move by at most a facet per increment, or contact
//! with a body could be missed. Boundaries rotate by at most an eighth of a turn, because larger rotations could take the shorter
//! direction.

use std::sync::Arc;

use super::engine::Engine;
use super::ledger::LedgerRow;
use super::options::SettleReport;
use super::settle::STRIDE;
use super::settle_progress::SettleEffort;
use super::slip_memory::{SlipMemory, friction_work, joint_friction};
use super::state::{Clock, State};
use crate::bodies::{Elements, Space};
use crate::dynamics::model::step_error::StepError;
use crate::math::tolerances::{EIGHTH_TURN, PASSING};

/// Factors of an increment after a failed and after a successful one.
const SHORTER: f64 = 0.25;
const LONGER: f64 = 2.0;

/// First increment relative to the whole motion, after the whole motion at once has failed.
const FIRST: f64 = 0.25;
/// Least increment relative to the whole motion.
const LEAST: f64 = 1.0 / 512.0;

/// Increment over which damped steps may find an equilibrium if the quasi-static path has none.
const JUMP: f64 = 1.0 / 64.0;

/// Relative size of a remaining interval below which it is merged with the increment before it.
const REST: f64 = 0.01;

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Settles at a time: the present one, or a later one that the model reaches quasi-statically.
    pub fn settle_at(&mut self, time: f64) -> Result<SettleReport, StepError> {
        let (from, iterations, factorizations) =
            (self.state.row.time, self.statistics.newton_iterations, self.system.counters.factorizations);
        let (before, row_before) = (self.state.slipped.clone(), self.state.row.clone());
        Arc::make_mut(&mut self.state).slipped.iter_mut().for_each(|memory| memory.slip = 0.0);
        let settled = if time == from { self.settle_once(time, SettleEffort::Patient) } else { self.settle_later(from, time) };
        let mut report = settled?;
        report.newton_iterations = self.statistics.newton_iterations - iterations;
        let factorizations = self.system.counters.factorizations - factorizations;
        let State { row, slipped, .. } = Arc::make_mut(&mut self.state);
        if time == from {
            // The motion from the initial positions to the equilibrium is not a slip of a step.
            *slipped = before.iter().map(|memory| SlipMemory { slip: 0.0, ..*memory }).collect();
        }
        let frictional = friction_work(&self.system, &before, slipped);
        for (pair, work) in joint_friction(&self.system, &before, slipped) {
            let own = self.model.joints.iter().zip(&mut row.joints).filter(|(joint, _)| joint.name == pair.name);
            own.for_each(|(_, totals)| totals.friction_work = work);
        }
        row.contacts.iter_mut().zip(&frictional).for_each(|(contact, work)| contact.friction_work = *work);
        // The works of the previous step are not repeated; an equilibrium at another time is a step of its own.
        *row = LedgerRow {
            step: row.step + usize::from(time != from),
            dt: time - from,
            load_work: 0.0,
            contact_work: 0.0,
            damping: 0.0,
            energy_defect: 0.0,
            momentum_defect: 0.0,
            angular_momentum_defect: 0.0,
            newton_iterations: report.newton_iterations,
            factorizations,
            halvings: 0,
            ..std::mem::take(row)
        };
        row.book_friction(&frictional);
        row.book_flow_at_rest(&row_before);
        Ok(report)
    }

    /// Settles in one increment if the motions of obstacles and rotations permit, else in several; if these fail, in one with all remedies.
    fn settle_later(&mut self, from: f64, time: f64) -> Result<SettleReport, StepError> {
        let begun = self.state.clone();
        let may_be_at_once = !self.goes_far(from, time)?;
        if may_be_at_once {
            match self.settle_once(time, SettleEffort::Exact) {
                Err(StepError::NotConverged { .. } | StepError::StillOverlaps { .. }) => self.take_back(&begun),
                outcome => return outcome,
            }
        }
        match self.settle_in_increments(from, time) {
            Err(error @ StepError::NotConverged { .. }) if may_be_at_once => {
                self.take_back(&begun);
                self.settle_once(time, SettleEffort::Patient).map_err(|again| if again.is_interrupt() { again } else { error })
            }
            outcome => outcome,
        }
    }

    /// True if an obstacle or a prescribed rotation moves farther between two times than one increment allows.
    fn goes_far(&self, from: f64, to: f64) -> Result<bool, StepError> {
        Ok(self.system.equations.obstacle_motion(from, to, &self.state.positions)? > PASSING
            || self.system.supports.turned(from, to)?.0 > EIGHTH_TURN)
    }

    fn settle_in_increments(&mut self, from: f64, end: f64) -> Result<SettleReport, StepError> {
        let (mut done, mut share, mut steps) = (0.0, FIRST, 0);
        let mut reached = self.state.clone();
        loop {
            let is_jump = share < LEAST;
            share = if is_jump { JUMP } else { share };
            let time = |part: f64| if part == 1.0 { end } else { from + part * (end - from) };
            let after = |share: f64| if done + share * (1.0 + REST) >= 1.0 { 1.0 } else { done + share };
            while share >= LEAST && self.goes_far(time(done), time(after(share)))? {
                share *= 0.5;
            }
            let next = after(share);
            let care = if is_jump {
                SettleEffort::Patient
            } else if next == 1.0 {
                SettleEffort::Exact
            } else {
                SettleEffort::Coarse
            };
            match self.settle_once(time(next), care) {
                Ok(report) if next == 1.0 => return Ok(SettleReport { steps: steps + report.steps, ..report }),
                Ok(report) => {
                    (done, steps, reached) = (next, steps + report.steps, self.state.clone());
                    share = (LONGER * share).min(FIRST);
                }
                Err(error @ (StepError::NotConverged { .. } | StepError::StillOverlaps { .. })) if is_jump => {
                    return Err(error.after_equilibria_until(reached.row.time));
                }
                Err(StepError::NotConverged { .. } | StepError::StillOverlaps { .. }) => {
                    self.take_back(&reached);
                    share *= SHORTER;
                }
                Err(error) => return Err(error),
            }
        }
    }

    /// Equilibrium at a time, starting from the present state.
    pub(super) fn settle_once(&mut self, time: f64, care: SettleEffort) -> Result<SettleReport, StepError> {
        if time != self.state.row.time {
            let state = Arc::make_mut(&mut self.state);
            state.row.time = time;
            state.clock = Clock { origin: time, count: 0, dt: self.options.dt };
        }
        let begun = self.state.clone();
        self.count_turns();
        match self.settle_from_here(f64::INFINITY, care) {
            // A prescribed motion in one increment has pushed a body around a corner into the other side: it is repeated in small
            // increments.
            Err(StepError::StillOverlaps { .. }) if !self.system.supports.prescribed.is_empty() => {
                self.take_back(&begun);
                self.settle_from_here(STRIDE * self.shortest_facet(), care)
            }
            outcome => outcome,
        }
    }

    /// Length of the shortest facet of all contacts, or size of rigid or joined bodies; infinite without any.
    pub(super) fn shortest_facet(&self) -> f64 {
        self.system.pairs.iter().map(|pair| pair.kernel.facet_size()).fold(f64::INFINITY, f64::min)
    }

    pub(super) fn take_back(&mut self, state: &Arc<State>) {
        self.state = state.clone();
        self.restore_search();
    }
}
