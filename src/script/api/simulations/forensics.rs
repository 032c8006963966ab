//! Report on a failed step: its iterations as a table, the cause, and the last iterate as a file.

use std::rc::Rc;

use super::handle::SimulationHandle;
use crate::dynamics::{FailureCause, FailureReport, IterationReport, TryReport};
use crate::output::Frame;
use crate::script::api::examples::flight_example;
use crate::script::api::files::writing::write;
use crate::script::language::digits::{brief, number_text, significant};
use crate::script::language::prelude::*;
use crate::script::language::tables::table;

/// Report on the last failed step.
#[derive(Clone)]
pub struct FailedStepHandle {
    report: Option<Rc<FailureReport>>,
    simulation: String,
    hint: String,
}

impl Handle for FailedStepHandle {
    const NAME: &'static str = "FailedStep";

    fn describe(&self) -> String {
        let Some(report) = &self.report else { return format!("no step of simulation \"{}\" has failed", self.simulation) };
        let what = if report.dt > 0.0 {
            let times = if report.halvings == 1 { "halving" } else { "halvings" };
            format!(
                "step {} of simulation \"{}\" failed at t = {} with dt = {} after {} {times}: {}",
                report.step,
                self.simulation,
                number_text(report.time),
                brief(report.dt),
                report.halvings,
                name_of(&report.cause)
            )
        } else {
            format!(
                "simulation \"{}\" found no equilibrium at t = {}: {}",
                self.simulation,
                number_text(report.time),
                name_of(&report.cause)
            )
        };
        let number = |value: f64| significant(value, 3);
        let rows: Vec<Vec<String>> = report
            .iterations
            .iter()
            .enumerate()
            .map(|(index, iteration)| {
                vec![
                    index.to_string(),
                    number(iteration.residual),
                    number(iteration.target),
                    number(iteration.energy),
                    number(iteration.gap_violation),
                    iteration.changes.to_string(),
                    iteration.active.to_string(),
                    format!("{} of \"{}\"", iteration.node, iteration.body),
                    iteration.contact.as_ref().map_or(String::new(), |contact| format!("\"{contact}\"")),
                ]
            })
            .collect();
        let header = ["iteration", "residual", "target", "energy", "gap", "set changes", "active", "worst node", "worst contact"];
        let mut parts = vec![what];
        if report.tries.len() > 1 {
            let tries = report.tries.iter();
            let row = |tried: &TryReport| {
                vec![number(tried.dt), tried.iterations.to_string(), number(tried.residual), number(tried.target), tried.outcome.into()]
            };
            parts.push(table(&["tried dt", "iterations", "residual", "target", "outcome"], &tries.map(row).collect::<Vec<_>>()));
        }
        if !rows.is_empty() {
            parts.push(table(&header, &rows));
            parts.push(
                "energy: what the residual can still move over what is tolerated; gap: violation of contact over what is tolerated".into(),
            );
        }
        parts.push(format!("cause: {}", report.explanation()));
        if !self.hint.is_empty() {
            parts.push(format!("hint:  {}", self.hint));
        }
        parts.join("\n")
    }
}

/// Short name of a cause.
fn name_of(cause: &FailureCause) -> &'static str {
    match cause {
        FailureCause::CyclingContact { is_slip: true, .. } => "cycling friction",
        FailureCause::CyclingContact { .. } => "cycling contact",
        FailureCause::SlowConvergence => "slow convergence",
        FailureCause::Divergence => "divergence",
        FailureCause::InvertedCell { .. } => "inverted cell",
        FailureCause::SingularSystem { .. } => "singular system",
        FailureCause::TooFast { .. } => "motion too fast",
        FailureCause::LoadTooFast { .. } => "load too fast",
        FailureCause::StepLimit { .. } => "step limit",
        FailureCause::NoEquilibrium { .. } => "no equilibrium",
    }
}

/// Iteration of Newton's method as an object map of the script.
fn iteration_map(iteration: &IterationReport) -> Map {
    let entries: [(&str, Dynamic); 9] = [
        ("residual", iteration.residual.into()),
        ("target", iteration.target.into()),
        ("energy", iteration.energy.into()),
        ("gap_violation", iteration.gap_violation.into()),
        ("changes", (iteration.changes as i64).into()),
        ("active", (iteration.active as i64).into()),
        ("body", iteration.body.clone().into()),
        ("node", (iteration.node as i64).into()),
        ("contact", iteration.contact.clone().unwrap_or_default().into()),
    ];
    entries.into_iter().map(|(name, value)| (name.into(), value)).collect()
}

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![why(), write_failed(), failed(), iterations(), cause()]
}

fn why() -> Function {
    method_of::<SimulationHandle>(Topic::Simulation, "why")
        .summary(
            "the report of the last failed step: its iterations with residual, gap violation and changes of the contact set, the worst \
             node, the cause, and a remedy",
        )
        .see_also(&["write_failed", "cycling", "set"])
        .example(flight_example("print(sim.why());"))
        .body(|call, handle| {
            let report = handle.with(call, |simulation| simulation.failure().cloned().map(Rc::new))?;
            let (simulation, hint) = (handle.0.name.clone(), handle.0.hint.borrow().clone());
            Ok(FailedStepHandle { report, simulation, hint })
        })
}

fn write_failed() -> Function {
    method_of::<SimulationHandle>(Topic::Results, "write_failed")
        .summary("writes the fields of the iterate at which the last failed step was given up as VTU")
        .parameters(vec![Parameter::text("path", "a `.vtu` file below the output folder")])
        .see_also(&["why", "write_fields"])
        .example(flight_example("if sim.why().failed { sim.write_failed(\"failed.vtu\"); }"))
        .body(|call, handle| {
            let failed = handle.with(call, |simulation| (simulation.time(), simulation.failed_fields()))?;
            let (time, Some(fields)) = failed else {
                let failure = call.refuse(causes::NO_SUCH, format!("no step of simulation \"{}\" has failed", handle.0.name));
                return Err(failure.hint("`sim.write_fields(path)` writes the state as it is").into());
            };
            Ok(write(call, Some(&handle), &[".vtu"], || Ok(Frame::new(time, &fields).encode()))?)
        })
}

fn failed() -> Function {
    property_of::<FailedStepHandle>(Topic::Simulation, "failed")
        .summary("whether a step has failed at all")
        .see_also(&["why"])
        .example(flight_example("print(sim.why().failed);"))
        .body(|_, failed_step| Ok(failed_step.report.is_some()))
}

fn iterations() -> Function {
    property_of::<FailedStepHandle>(Topic::Simulation, "iterations")
        .summary(
            "the iterations of the last try as maps with `residual`, `target`, `energy` and `gap_violation` (both over what is tolerated), \
             `changes` and `active` (contact nodes), `body` and `node` of the residual, `contact`; empty when no step has failed",
        )
        .see_also(&["why", "cause"])
        .example(flight_example("for iteration in sim.why().iterations { print(iteration.residual / iteration.target); }"))
        .body(|_, handle| {
            let iterations = handle.report.iter().flat_map(|report| &report.iterations);
            Ok(iterations.map(|iteration| Dynamic::from(iteration_map(iteration))).collect::<Array>())
        })
}

fn cause() -> Function {
    property_of::<FailedStepHandle>(Topic::Simulation, "cause")
        .summary("the cause in two words, such as `cycling contact`; empty when no step has failed")
        .see_also(&["why", "iterations"])
        .example(flight_example("print(sim.why().cause);"))
        .body(|_, handle| Ok(handle.report.as_ref().map_or("", |report| name_of(&report.cause)).to_string()))
}
