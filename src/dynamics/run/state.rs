//! The state of a simulation as a value.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::ledger::LedgerRow;
use super::pace::Pace;
use super::slip_memory::SlipMemory;
use crate::dynamics::model::part::Pose;
use crate::dynamics::parts::laws::RowState;
use crate::dynamics::step::attempts::Preferred;
use crate::dynamics::step::scheme_memory::SchemeMemory;
use crate::dynamics::step::search_history::SearchHistory;

/// Everything that the future of a simulation depends on. A value: keep it, restore it, branch from it.
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
    /// Multipliers of all contact pairs `[stress]`.
    pub(super) lambda: Vec<f64>,
    /// Weighted gaps as penalty potentials felt them at the end of the step.
    pub(super) penalty_gap: Vec<f64>,
    /// Energy that closed constraints of the `velocity` rule keep until they open `[energy]`.
    pub(super) reserve: Vec<f64>,
    /// What every constraint row is.
    pub(super) active: Vec<RowState>,
    /// What the tangential rows have done so far.
    pub(super) slipped: Vec<SlipMemory>,
    /// What the time integrator remembers besides.
    pub(super) remembered: Arc<SchemeMemory>,
    /// What every part remembers, block by block; most remember nothing.
    pub(super) memory: Arc<Vec<Vec<f64>>>,
    /// Counts steps.
    pub(super) clock: Clock,
    /// What the search for contact takes over from the steps before.
    pub(super) search: Arc<SearchHistory>,
    /// Halvings with which the next nominal step begins.
    pub(super) level: usize,
    /// How long the next step is, where steps choose their size.
    pub(super) pace: Pace,
    /// Sum of the ledger's energy defects since the run began or was last settled: Newton's tolerance has a sign, which may be the same in
    /// every step `[energy]`.
    pub(super) drift: f64,
    /// Which attempt of Newton's method the next step tries first.
    pub(super) preferred: Preferred,
    /// Time up to which friction has felt the motion of obstacles: that of the state, but for an equilibrium that is being looked for.
    pub(super) carried: f64,
    /// End of the last step in which a load acted.
    pub(super) loads_ended: f64,
}

impl State {
    /// Where the nodes are.
    pub(super) fn pose(&self) -> Pose<'_> {
        Pose { q: &self.positions, u: &self.displacements }
    }

    /// Whether it has as many of everything as another state of the same model, is somewhere, and refers to nothing else.
    pub(super) fn has_shape_of(&self, own: &State) -> bool {
        let lengths = |state: &State| {
            let nodal = [state.positions.len(), state.displacements.len(), state.velocities.len()];
            let rows = [state.lambda.len(), state.penalty_gap.len(), state.reserve.len(), state.active.len(), state.slipped.len()];
            (nodal, rows, state.memory.iter().map(Vec::len).collect::<Vec<_>>())
        };
        let remembers = self.remembered.has_length(self.positions.len());
        let is_somewhere = [&self.positions, &self.displacements, &self.velocities].iter().all(|all| all.iter().all(|x| x.is_finite()));
        // A halving more doubles the pieces of a step, whose number is a whole one.
        lengths(self) == lengths(own)
            && is_somewhere
            && remembers
            && self.level < usize::BITS as usize - 1
            && self.preferred.is_sound()
            && self.search.is_sound_beside(&own.search)
    }

    /// Bytes that it takes, but for what it shares with others.
    pub fn size(&self) -> usize {
        let (rows, memory) = (3 * (self.lambda.len() + self.slipped.len()), self.memory.iter().map(Vec::len).sum::<usize>());
        8 * (2 * self.positions.len() + self.velocities.len() + self.remembered.len() + rows + memory) + self.active.len()
    }
}

/// Times are products of a step size, not sums of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Clock {
    /// Time from which steps are counted `[time]`.
    pub(super) origin: f64,
    /// Steps since then.
    pub(super) count: usize,
    /// Their size `[time]`.
    pub(super) dt: f64,
}
