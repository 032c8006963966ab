//! The state of a simulation as a value.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::ledger::LedgerRow;
use super::pace::StepSizeState;
use super::slip_memory::SlipMemory;
use crate::dynamics::model::part::Pose;
use crate::dynamics::parts::laws::RowState;
use crate::dynamics::step::attempts::PreferredAttempt;
use crate::dynamics::step::scheme_history::SchemeHistory;
use crate::dynamics::step::search_history::SearchHistory;

/// State of a simulation: all data on which later steps depend. States can be stored, restored and continued in several ways.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// The ledger's row of this state.
    pub row: LedgerRow,
    /// Positions of all nodes `[length]`, component by component, body after body.
    pub positions: Vec<f64>,
    /// Displacements of all nodes since rest, from which positions and strains follow `[length]`.
    pub displacements: Vec<f64>,
    /// Velocities of all nodes `[length/time]`.
    pub velocities: Vec<f64>,
    /// Accelerations of all nodes: change of the velocities in the last substep divided by its size, 0 at rest `[length/time^2]`.
    pub accelerations: Vec<f64>,
    /// Multipliers of all contact pairs `[stress]`.
    pub(super) lambda: Vec<f64>,
    /// Weighted gaps in the penalty potentials at the end of the step.
    pub(super) penalty_gap: Vec<f64>,
    /// Stored impact energy of active constraints under the `velocity` rule `[energy]`.
    pub(super) reserve: Vec<f64>,
    /// Contact state of every constraint.
    pub(super) active: Vec<RowState>,
    /// Accumulated slip of the tangential constraints.
    pub(super) slipped: Vec<SlipMemory>,
    /// History variables of the time integrator.
    #[serde(rename = "remembered")]
    pub(super) scheme_history: Arc<SchemeHistory>,
    /// History variables of every part, block by block; most are empty.
    pub(super) memory: Arc<Vec<Vec<f64>>>,
    /// Step counter.
    pub(super) clock: Clock,
    /// Search results and solver data for the next step.
    pub(super) search: Arc<SearchHistory>,
    /// Number of halvings with which the next nominal step begins.
    pub(super) level: usize,
    /// State of the step size controller.
    pub(super) pace: StepSizeState,
    /// Sum of the ledger's energy defects since the run began or was last settled: residuals within Newton's tolerance may have the same
    /// sign in every step `[energy]`.
    pub(super) drift: f64,
    /// Integral over time of the largest force component at a node: its mean works on the round-off of positions `[force * time]`.
    pub(super) pushed: f64,
    /// Attempt of Newton's method that the next step tries first.
    pub(super) preferred: PreferredAttempt,
    /// Time up to which the motion of obstacles is included in slips: that of the state, except while an equilibrium is computed.
    #[serde(rename = "carried")]
    pub(super) slips_until: f64,
    /// End of the last step in which a load acted.
    pub(super) loads_ended: f64,
}

impl State {
    /// Positions and displacements.
    pub(super) fn pose(&self) -> Pose<'_> {
        Pose { q: &self.positions, u: &self.displacements }
    }

    /// True if all vectors have the lengths of those in a state of the model, positions are finite, and all references are valid.
    pub(super) fn has_shape_of(&self, own: &State) -> bool {
        let lengths = |state: &State| {
            let nodal = [&state.positions, &state.displacements, &state.velocities, &state.accelerations].map(Vec::len);
            let rows = [state.lambda.len(), state.penalty_gap.len(), state.reserve.len(), state.active.len(), state.slipped.len()];
            (nodal, rows, state.memory.iter().map(Vec::len).collect::<Vec<_>>())
        };
        let remembers = self.scheme_history.has_length(self.positions.len());
        let nodal = [&self.positions, &self.displacements, &self.velocities, &self.accelerations];
        let is_somewhere = nodal.iter().all(|all| all.iter().all(|x| x.is_finite()));
        // Each halving doubles the number of substeps, which is an integer.
        lengths(self) == lengths(own)
            && is_somewhere
            && remembers
            && self.level < usize::BITS as usize - 1
            && self.preferred.is_sound()
            && self.search.is_sound_beside(&own.search)
    }

    /// Size in bytes, without the data that is shared with the state `before`.
    pub fn size(&self, before: Option<&State>) -> usize {
        let rows = size_of_val(&self.lambda[..]) + size_of_val(&self.penalty_gap[..]) + size_of_val(&self.reserve[..]);
        let slips = size_of_val(&self.active[..]) + size_of_val(&self.slipped[..]);
        let nodal = 8 * (self.positions.len() + self.displacements.len() + self.velocities.len() + self.accelerations.len());
        let is_shared = |same: fn(&State, &State) -> bool| before.is_some_and(|before| same(self, before));
        let mut size = size_of::<State>() + self.row.heap_size() + rows + slips + nodal;
        if !is_shared(|own, before| Arc::ptr_eq(&own.scheme_history, &before.scheme_history)) {
            size += 8 * self.scheme_history.len();
        }
        if !is_shared(|own, before| Arc::ptr_eq(&own.memory, &before.memory)) {
            size += self.memory.iter().map(|block| size_of_val(block) + size_of_val(&block[..])).sum::<usize>();
        }
        size + self.search.size(before.map(|before| &before.search))
    }
}

/// Step counter. Times are `origin + count * dt`, without the round-off of a sum of steps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Clock {
    /// Time from which steps are counted `[time]`.
    pub(super) origin: f64,
    /// Number of steps since `origin`.
    pub(super) count: usize,
    /// Size of the counted steps `[time]`.
    pub(super) dt: f64,
}
