//! Conversion of a failed step to an error and a report.

use super::diagnosis::{Evidence, rigid_motion_of};
use super::engine::Engine;
use super::report::{FailureCause, FailureReport, TryReport};
use crate::bodies::{Elements, Space};
use crate::contact::ROUGH;
use crate::dynamics::model::remedy::SmallerIncrements;
use crate::dynamics::model::step_error::StepError;
use crate::dynamics::parts::contact_pair::ContactPair;
use crate::dynamics::parts::friction_rows::FrictionRows;
use crate::dynamics::step::failure::Failure;
use crate::dynamics::step::task::Trace;

/// Relative part of a damped step that may deviate from a rigid motion described as such: bodies deform where they touch.
const MOSTLY: f64 = 0.3;

/// Gap of a stop, relative to the size of the joined bodies, below which a step that fails has met it.
const AT_STOP: f64 = 0.001;

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Error for a finally failed step; its report is kept.
    pub fn failed(&mut self, failure: &Failure, dt: f64, halvings: usize) -> StepError {
        let report = self.evidence(dt, halvings).report(failure);
        self.given_up(report)
    }

    /// Error for a failure that smaller steps cannot avoid: a fatal one itself, otherwise with a report.
    pub fn error_of(&mut self, failure: Failure) -> StepError {
        match failure.or_end(self.state.row.time) {
            Failure::Fatal(error) => error,
            failure => self.failed(&failure, 0.0, 0),
        }
    }

    /// Data of the failed step, for the diagnosis.
    pub fn evidence(&self, dt: f64, halvings: usize) -> Evidence<'_, D> {
        let Engine { model, system, state, trace, tries, .. } = self;
        Evidence { model, system, state, trace, tries, dt, halvings }
    }

    /// Error for a failed step with its `report`, which is kept.
    pub fn given_up(&mut self, report: FailureReport) -> StepError {
        let FailureReport { time, step, dt, halvings, .. } = report;
        let ease = match dt > 0.0 {
            true if report.is_worse_when_smaller() => SmallerIncrements::LargerStep(dt),
            true => SmallerIncrements::SmallerStep(self.options.dt),
            false => SmallerIncrements::SupportsAndLoads,
        };
        let (cause, remedy) = (report.explanation(), report.remedy(ease));
        let is_slow = matches!(report.cause, FailureCause::SlowConvergence);
        // Round-off can make a singular system regular, with solutions that grow without bound.
        let is_singular = matches!(report.cause, FailureCause::SingularSystem { .. } | FailureCause::Divergence);
        let is_cycling = matches!(report.cause, FailureCause::CyclingContact { .. });
        let violated = self.trace.iterations.last().filter(|_| is_slow).map(|last| last.worst_row);
        let dependent = if let FailureCause::SingularSystem { constraint, .. } = &report.cause { *constraint } else { None };
        self.failure = Some((report, self.trace.u_1.clone()));
        // The constraint of a stop or a contact whose bodies are wholly prescribed has no free unknown: it stays violated, or the tangent
        // is singular.
        if is_slow || is_singular {
            if let Some(stop) = self.system.determined_stop(&self.state.positions, AT_STOP)
                && violated.is_none_or(|row| stop.rows.contains(&row))
            {
                return StepError::Blocked { joint: stop.name.clone(), time };
            }
            if let Some(pair) = self.unyielding(dependent) {
                return StepError::Unyielding { contact: pair.name.clone(), time };
            }
        }
        if is_cycling && let Some(jammed) = self.jammed() {
            return jammed;
        }
        StepError::NotConverged { time, step, dt, halvings, cause, remedy }
    }

    /// Contact with a constraint that no free motion can meet: the one at which elimination stopped, or the one violated most in the last
    /// attempt.
    fn unyielding(&self, dependent: Option<usize>) -> Option<&ContactPair> {
        let violated = self.trace.iterations.last().map(|last| last.worst_row);
        let of_contact = dependent.into_iter().chain(violated).filter_map(|row| Some((row, self.system.pair_of(row)?)));
        let mut holding = of_contact.filter(|(row, pair)| !pair.kind.is_bilateral() && always_holds(pair, *row));
        holding.find(|(row, _)| self.system.is_determined(*row, &self.state.positions)).map(|(_, pair)| pair)
    }

    /// Body that moves most in a nodal motion, and a description of its motion.
    pub fn moving_body(&self, motion: &[f64]) -> (String, String) {
        let largest = |nodes: &std::ops::Range<usize>| {
            let moved = motion[nodes.start * D..nodes.end * D].iter();
            moved.fold(0.0f64, |most, x| most.max(x.abs()))
        };
        let body = self.system.bodies.iter().max_by(|a, b| largest(&a.nodes).total_cmp(&largest(&b.nodes)));
        let Some(body) = body else { return Default::default() };
        let range = body.nodes.start * D..body.nodes.end * D;
        let rigid = rigid_motion_of::<D>(&self.state.positions[range.clone()], &motion[range], MOSTLY);
        (body.name.clone(), rigid.unwrap_or_else(|| "deform".into()))
    }
}

/// True for normal constraints of a contact, and for tangential ones of rough surfaces, which do not slip.
fn always_holds(pair: &ContactPair, row: usize) -> bool {
    let is_rough = |friction: &FrictionRows| friction.coefficients[friction.normal_row(row)] >= ROUGH;
    pair.rows.contains(&row) || pair.friction.as_ref().is_some_and(is_rough)
}

/// Report of one attempt at a step.
pub fn tried(failure: &Failure, dt: f64, trace: &Trace) -> TryReport {
    let last = trace.iterations.last();
    TryReport {
        dt,
        iterations: trace.iterations.len(),
        residual: last.map_or(f64::NAN, |iteration| iteration.residual),
        target: last.map_or(f64::NAN, |iteration| iteration.target),
        outcome: failure.name(),
    }
}
