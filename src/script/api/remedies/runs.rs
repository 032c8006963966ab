//! Hints on runs: failed steps, and findings.

use super::words::ScriptWords;
use crate::dynamics::{Remedy, RunFinding, RunFindingKind, SmallerIncrements, StepError};
use crate::script::language::digits::brief;

impl ScriptWords for StepError {
    fn remedy(&self) -> String {
        match self {
            StepError::NotConverged { remedy, .. } => remedy.remedy(),
            StepError::StillOverlaps { .. } => {
                "see that the boundaries of the contact face each other where the bodies overlap; start with a smaller overlap, or let it \
                 grow over several calls of `settle` with times; in motion, try a smaller `dt`"
                    .into()
            }
            StepError::TooLong { stable, penalty_share, .. } if *penalty_share > 0.5 => format!(
                "take `dt` of {} or less, or a smaller `penalty` of contacts, which is most of the stiffness; multipliers shorten no steps",
                brief(0.9 * stable)
            ),
            StepError::TooLong { stable, body, cell, .. } => format!(
                "take `dt` of {} or less; the fastest cell by itself is cell {cell} of body \"{body}\": larger, softer or heavier cells \
                 there admit longer steps",
                brief(0.9 * stable)
            ),
            _ => self.hint(),
        }
    }
}

impl ScriptWords for Remedy {
    fn remedy(&self) -> String {
        match self {
            Remedy::Guide => {
                "guide the body with `fix`, such as `fix(body.boundary(\"left\"), \"x\")`, or let contacts hold it from all sides".into()
            }
            Remedy::HoldBeforeRest => "hold every body with `fix` or by contact against the loads on it before `settle`".into(),
            Remedy::HoldAgainstLoads => {
                "hold every body against the loads on it with `fix` or by contact; rigid motion under a load has no equilibrium".into()
            }
            Remedy::HoldOnce => {
                "hold every body against rigid motion with `fix`, and name each contact pair and each support only once".into()
            }
            Remedy::Ease(ease, besides) => format!("{}{besides}", ease.remedy()),
            Remedy::FollowPath => "check supports and loads; past a limit point of the load `sim.follow_load` goes on".into(),
            Remedy::LoadSlowly(ease) => format!("apply the load more slowly, such as with `ramp`, or {}", ease.remedy()),
        }
    }
}

impl ScriptWords for SmallerIncrements {
    fn remedy(&self) -> String {
        match self {
            SmallerIncrements::SmallerStep(dt) => format!("use a smaller step than dt = {dt}, or allow more `max_halvings`"),
            SmallerIncrements::LargerStep(dt) => format!(
                "halving the step down to dt = {dt} came no nearer to a solution: try a larger dt, or `penalty` in the options of contacts"
            ),
            SmallerIncrements::SupportsAndLoads => self.to_string(),
        }
    }
}

impl ScriptWords for RunFinding {
    fn remedy(&self) -> String {
        let words = match self.kind {
            RunFindingKind::NotConserved => "`energy_momentum()` conserves; with this integrator a smaller dt changes less",
            RunFindingKind::Leap => {
                "with a smaller `dt` a leap at a limit point stays, and `sim.follow_load` goes on past it; an error of the step goes; \
                 where loads do not begin at 0 call `sim.settle()` first"
            }
            RunFindingKind::PassedThrough => "define what touches with `model.add_contact(…)`, or move the bodies apart",
            RunFindingKind::PassedObstacle => {
                "name all of the body that can touch the obstacle as `secondary`, and turn round an obstacle that is the wrong way"
            }
            RunFindingKind::Depth => {
                "an overlap at the start is never driven apart: start without, or begin with `settle`; one that came later is less with a \
                 smaller dt, or a larger `penalty`; corners between nodes are held without `penalty`, by multipliers"
            }
            RunFindingKind::EnergyTaken => {
                "`update: \"persistency\"` keeps the energy, `\"velocity\"` all but what slides off its contact; with `\"gap\"` or \
                 explicit steps finer facets lose less"
            }
            RunFindingKind::TooFast(_) => "results are not accurate there: use a smaller dt, or allow more `max_halvings`",
            RunFindingKind::CoarseCells => {
                "use smaller cells, or cells of second order (`mesh.with_elements(\"quad8\")`, in space `\"hex20\"` or `\"tet10\"`); \
                 `sim.field(\"stress_error\", body)` shows where"
            }
            _ => self.hint(),
        };
        words.into()
    }
}

/// Describes a finding by its numbers, with integrators named as in scripts.
pub fn explained(finding: &RunFinding) -> String {
    match (finding.kind, finding.explanation.split_once(' ')) {
        (RunFindingKind::NotConserved, Some((integrator, rest))) => format!("{integrator}() {rest}"),
        _ => finding.explanation.clone(),
    }
}
