//! Findings on the linear solver of a run.

use super::ledger::LedgerRow;
use super::run_findings::{RunFinding, RunFindingKind};
use crate::linear::TakenOver;

/// Finding on matrices that the direct solver took over from the iterative or the distributed one.
pub(super) fn taken_over(taken_over: TakenOver, is_distributed: bool, last: &LedgerRow) -> Option<RunFinding> {
    let TakenOver { unconverged, is_unsuited } = taken_over;
    let explanation = match unconverged {
        0 if !is_unsuited => return None,
        0 => "half of the nodes or more have constraints, and no level of the iteration may join them".to_owned(),
        1 if is_distributed => "one matrix has null pivots, or no accurate solution".to_owned(),
        count if is_distributed => format!("{count} matrices have null pivots, or no accurate solution"),
        1 => "the iteration did not converge for one matrix".to_owned(),
        count => format!("the iteration did not converge for {count} matrices"),
    };
    let (kind, value) = (RunFindingKind::TakenOver, f64::from(unconverged));
    Some(RunFinding { kind, contact: None, value, limit: 0.0, step: last.step, time: last.time, explanation })
}
