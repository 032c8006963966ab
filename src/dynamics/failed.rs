//! From a step that failed to what a user is told.

use super::error::StepError;
use super::newton::Failure;
use super::report::{FailureCause, FailureReport, IterationReport};
use super::time_loop::TimeLoop;
use crate::bodies::{Elements, Space};

impl<const D: usize> TimeLoop<D>
where
    Space<D>: Elements<D>,
{
    /// The error that a user sees when a step failed for good; its report is kept.
    pub(super) fn failed(&mut self, failure: &Failure, dt: f64, halvings: usize) -> StepError {
        let report = self.report(failure, dt, halvings);
        let smaller = if dt > 0.0 {
            format!("use a smaller step than dt = {}, or allow more `max_halvings`", self.options.dt)
        } else {
            "check supports and loads".into()
        };
        let (time, step) = (report.time, report.step);
        let (cause, cure) = (report.explanation(), report.cure(&smaller));
        self.failure = Some((report, self.trace.q_1.clone()));
        StepError::NotConverged { time, step, dt, halvings, cause, cure }
    }

    fn report(&self, failure: &Failure, dt: f64, halvings: usize) -> FailureReport {
        let contact_of = |row: usize| self.system.pairs.iter().find(|pair| pair.rows.contains(&row));
        let iterations: Vec<IterationReport> = self
            .trace
            .iterations
            .iter()
            .map(|iteration| {
                let (body, node) = self.system.owner(iteration.worst / D);
                IterationReport {
                    residual: iteration.residual,
                    target: iteration.target,
                    gap_violation: iteration.violation,
                    changes: iteration.changes,
                    active: iteration.active,
                    body: body.into(),
                    node,
                    contact: contact_of(iteration.worst_row).map(|pair| pair.name.clone()),
                }
            })
            .collect();
        let cause = match failure {
            Failure::Iterations => {
                let last = &self.trace.iterations[self.trace.iterations.len().saturating_sub(6)..];
                let cycling = last.iter().rev().skip(1).map(|iteration| iteration.changes).min().unwrap_or(0);
                match last.last().and_then(|iteration| contact_of(iteration.worst_row)) {
                    Some(pair) if cycling > 0 => {
                        FailureCause::CyclingContact { contact: pair.name.clone(), changing: cycling, nodes: pair.rows.len() }
                    }
                    _ => FailureCause::SlowConvergence,
                }
            }
            Failure::Inverted { body, inverted } => {
                let index = self.system.bodies.iter().position(|other| other.name == *body).unwrap_or(0);
                let mesh = &self.model.bodies[index].mesh;
                let corners = mesh.cell(inverted.cell);
                let mut center = [0.0; 3];
                for &node in corners {
                    for i in 0..3 {
                        center[i] += mesh.points[node as usize][i] / corners.len() as f64;
                    }
                }
                FailureCause::InvertedCell { body: body.clone(), cell: inverted.cell, determinant: inverted.determinant, center }
            }
            Failure::Linear(error) => FailureCause::SingularSystem { reason: self.system.explain(error) },
            Failure::Diverged => FailureCause::Divergence,
            Failure::BeyondSearch { pair } => FailureCause::TooFast { contact: pair.clone() },
            Failure::Fatal(error) => FailureCause::SingularSystem { reason: error.to_string() },
        };
        FailureReport { time: self.state.row.time, step: self.state.row.step + 1, dt, halvings, cause, iterations }
    }
}
