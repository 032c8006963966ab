//! A contact with its multipliers at a configuration, and the resulting nodal forces.

use super::slip_memory::{SlipMemory, Tangential};
use crate::contact::Evaluation;
use crate::dynamics::parts::contact_pair::{ContactPair, PatchRow, RowBlock};
use crate::dynamics::parts::laws::RowState;
use crate::dynamics::step::equations::Equations;
use crate::dynamics::step::iterate::Linearization;

/// Forces of a contact, evaluated at one configuration.
#[derive(Default)]
pub struct ContactForces {
    /// Normal force on each secondary node, by its own constraints and by corners `[force]`.
    pub(super) own: Vec<[f64; 3]>,
    /// Friction force on each secondary node `[force]`; empty without friction.
    pub(super) friction: Vec<[f64; 3]>,
    /// Tangential force of corners at each secondary node `[force]`; empty without friction.
    pub(super) corner_shears: Vec<f64>,
    /// Mean pressure of the constraints on the covered part of each secondary node `[stress]`.
    pub(super) mean: Vec<f64>,
    /// Sum of the magnitudes of corner forces on each secondary node `[force]`.
    pub(super) corner_forces: Vec<f64>,
    /// Forces on the nodes of both sides, by node number in the model, with repetitions `[force]`: normal forces, then friction.
    pub all: Vec<(u32, [f64; 3])>,
    /// Number of the forces in `all` that are normal forces.
    pub normal_count: usize,
}

/// A pair with its evaluation at a configuration and its multipliers.
#[derive(Clone, Copy)]
pub struct LoadedContact<'a> {
    pub pair: &'a ContactPair,
    /// Positions of the nodes `[length]`.
    pub q: &'a [f64],
    pub evaluation: &'a Evaluation,
    pub lambda: &'a [f64],
    pub active: &'a [RowState],
    /// Tangential constraints, if the contact has friction.
    pub tangential: Option<Tangential<'a>>,
}

/// Evaluated contact pairs with multipliers and states at a configuration.
pub struct EvaluatedContacts<'a> {
    /// Positions at which they are evaluated `[length]`.
    pub q: &'a [f64],
    /// Normal constraints of the pairs.
    pub evaluations: &'a [Evaluation],
    /// Tangential constraints of the pairs.
    pub slips: &'a [Evaluation],
    /// Multipliers of all constraints.
    pub lambda: &'a [f64],
    /// Contact state of every constraint.
    pub active: &'a [RowState],
    /// Accumulated slip of the tangential constraints.
    pub slipped: &'a [SlipMemory],
}

impl<'a> EvaluatedContacts<'a> {
    /// All pairs at the end of a step.
    pub(super) fn of(at: &'a Linearization, lambda: &'a [f64], active: &'a [RowState], slipped: &'a [SlipMemory]) -> Self {
        EvaluatedContacts { q: &at.q_1, evaluations: &at.pairs, slips: &at.slips, lambda, active, slipped }
    }

    /// A contact of the equations `system` and its corners.
    pub fn contact<const D: usize>(&self, system: &'a Equations<D>, index: usize) -> (LoadedContact<'a>, Vec<LoadedContact<'a>>) {
        let &EvaluatedContacts { q, evaluations, slips, lambda, active, slipped } = self;
        let of = |k: usize| {
            let pair = &system.pairs[k];
            let tangential = pair.friction.as_ref().map(|friction| Tangential {
                evaluation: &slips[k],
                lambda: &lambda[friction.rows.clone()],
                active: &active[friction.rows.clone()],
                slipped: &slipped[friction.rows.start - system.normal_count..friction.rows.end - system.normal_count],
                count: friction.tangents,
            });
            let (lambda, active) = (&lambda[pair.rows.clone()], &active[pair.rows.clone()]);
            LoadedContact { pair, q, evaluation: &evaluations[k], lambda, active, tangential }
        };
        let corners = (0..system.pairs.len()).filter(|&k| system.pairs[k].corners.is_some_and(|corners| corners.pair == index));
        (of(index), corners.map(of).collect())
    }
}

impl LoadedContact<'_> {
    /// Visits the force of every normal constraint with its multiplier on every node of its contact elements: the node, true if the node
    /// owns a constraint of the element, the multiplier, the force.
    pub(super) fn for_each_force<const D: usize>(&self, lambda: &[f64], visit: impl FnMut(u32, bool, f64, [f64; 3])) {
        self.visit::<D>(lambda, self.normal_rows(), &self.evaluation.gradient_end, false, visit);
    }

    /// Visits forces like [`Self::for_each_force`]; the force of a constraint of a facet or an edge is assigned to the node at which output
    /// shows it.
    pub(super) fn for_each_shown_force<const D: usize>(&self, lambda: &[f64], visit: impl FnMut(u32, bool, f64, [f64; 3])) {
        self.visit::<D>(lambda, self.normal_rows(), &self.evaluation.gradient_end, true, visit);
    }

    /// Calls `visit` with the force of every tangential constraint on every node of its facets, with the arguments of `for_each_force`.
    pub(super) fn for_each_shear<const D: usize>(&self, lambda: &[f64], visit: impl FnMut(u32, bool, f64, [f64; 3])) {
        self.shears_into::<D>(lambda, false, visit);
    }

    /// Visits forces like `for_each_shear`; the force of a constraint of a facet or an edge is assigned to the node at which output shows
    /// it.
    pub(super) fn for_each_shown_shear<const D: usize>(&self, lambda: &[f64], visit: impl FnMut(u32, bool, f64, [f64; 3])) {
        self.shears_into::<D>(lambda, true, visit);
    }

    fn shears_into<const D: usize>(&self, lambda: &[f64], is_shown: bool, mut visit: impl FnMut(u32, bool, f64, [f64; 3])) {
        let Some(Tangential { evaluation, count, .. }) = self.tangential else { return };
        for block in self.pair.blocks([self.evaluation, evaluation]).filter(RowBlock::is_slip) {
            let first = block.rows.start;
            let rows = block.live_rows().map(|row| (row.row - first, (row.row - first) / count, row));
            self.visit::<D>(lambda, rows, &evaluation.gradient_bar, is_shown, &mut visit);
        }
    }

    /// Normal constraints, with their indices in the pair.
    fn normal_rows(&self) -> impl Iterator<Item = (usize, usize, PatchRow<'_>)> {
        let first = self.pair.rows.start;
        self.pair.live_rows(self.evaluation).map(move |row| (row.row - first, row.row - first, row))
    }

    /// Visits forces of constraints, each with the index of its multiplier and the index of its normal constraint.
    fn visit<'a, const D: usize>(
        &self,
        lambda: &[f64],
        rows: impl Iterator<Item = (usize, usize, PatchRow<'a>)>,
        gradients: &[f64],
        is_shown: bool,
        mut visit: impl FnMut(u32, bool, f64, [f64; 3]),
    ) {
        for (multiplier, normal, row) in rows {
            let factor = lambda[multiplier];
            if factor == 0.0 {
                continue;
            }
            let kernel = &self.pair.kernel;
            let shown_at = if is_shown { [kernel.shown_at(normal, self.q), kernel.shown_on_primary(normal, self.q)] } else { [None; 2] };
            let mut whole = [[0.0; 3]; 2];
            for (&node, gradient) in row.nodes.iter().zip(gradients[row.gradient].chunks_exact(D)) {
                let mut force = [0.0; 3];
                (0..D).for_each(|i| force[i] = factor * gradient[i]);
                let is_own = self.pair.owns_row(row.patch, node);
                let side = usize::from(!is_own);
                match shown_at[side] {
                    Some(_) => (0..D).for_each(|i| whole[side][i] += force[i]),
                    None => visit(node, is_own, factor, force),
                }
            }
            for (side, node) in shown_at.iter().enumerate().filter_map(|(side, node)| Some((side, (*node)?))) {
                visit(node, side == 0, factor, whole[side]);
            }
        }
    }
}
