//! Forces of couplings of nodes, and the check of redundant equations that steps omit.

use super::engine::Engine;
use super::ledger::Reaction;
use crate::bodies::{Elements, Space};
use crate::dynamics::model::step_error::StepError;
use crate::dynamics::parts::contact_pair::{ContactPair, PairKind};
use crate::dynamics::parts::nodal::{add_force, add_moment};
use crate::dynamics::step::iterate::Linearization;

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Forces of couplings on the nodes of their symmetry planes and second boundaries at `q`, with the multipliers `lambda`.
    ///
    /// # Errors
    /// [`StepError::Contradiction`]: redundant equations, which at rest follow from others and from supports and are omitted, do not hold.
    pub fn coupling_reactions(
        &self,
        q: impl Fn(usize) -> f64,
        at: &Linearization,
        lambda: &[f64],
        time: f64,
    ) -> Result<Vec<Reaction>, StepError> {
        self.check_left_out(at, time)?;
        let mut sums = vec![Reaction::default(); self.model.couplings.len()];
        for pair in &self.system.pairs {
            let PairKind::Coupling(coupled) = &pair.kind else { continue };
            let sum = &mut sums[coupled.coupling];
            for (&node, &pressure) in coupled.nodes.iter().zip(&lambda[pair.rows.clone()]) {
                let force: [f64; D] = std::array::from_fn(|i| pressure * coupled.along[i]);
                add_force(&mut sum.force, &force);
                add_moment(&mut sum.moment, &std::array::from_fn::<f64, D, _>(|i| q(node as usize * D + i)), &force);
            }
        }
        let is_pushed = |pair: &&ContactPair| matches!(&pair.kind, PairKind::Coupling(coupled) if !coupled.pushed.is_empty());
        if self.system.pairs.iter().any(|pair| is_pushed(&pair)) {
            self.system.for_each_end_gradient([&at.pairs, &at.slips], |pair, row, k, gradient| {
                let PairKind::Coupling(coupled) = &pair.kind else { return };
                if coupled.pushed.binary_search(&((k / D) as u32)).is_ok() {
                    let (sum, mut force) = (&mut sums[coupled.coupling], [0.0; D]);
                    force[k % D] = lambda[row] * gradient;
                    add_force(&mut sum.force, &force);
                    add_moment(&mut sum.moment, &std::array::from_fn::<f64, D, _>(|i| q(k / D * D + i)), &force);
                }
            });
        }
        Ok(sums)
    }

    /// Checks that the omitted equations of couplings, ties, joints and rigid bodies, redundant at rest, hold.
    ///
    /// # Errors
    /// [`StepError::Contradiction`]: an equation does not hold.
    fn check_left_out(&self, at: &Linearization, time: f64) -> Result<(), StepError> {
        for (pair, evaluation) in self.system.pairs.iter().zip(&at.pairs) {
            if !matches!(pair.kind, PairKind::Coupling(_) | PairKind::Joint | PairKind::Rigidity | PairKind::Tie) {
                continue;
            }
            let left_out = pair.rows.clone().zip(&evaluation.gap).filter(|(row, _)| self.system.redundant[*row]);
            let gap = left_out.map(|(_, gap)| gap.abs()).fold(0.0, f64::max);
            if gap > pair.closed {
                return Err(StepError::Contradiction { coupling: pair.name.clone(), time, gap });
            }
        }
        Ok(())
    }
}
