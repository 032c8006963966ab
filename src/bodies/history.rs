//! History variables at the quadrature points of a body, and their change in a step.
//!
//! Their order in memory: batch after batch, in it point after point, in it variable after variable, and of each variable the values of the
//! eight cells of the batch. Lanes that are left over in the last batch repeat its first cell.

use super::batch::MOST_POINTS;
use super::cells::Cells;
use super::element_loop::{Advance, Step};
use super::special::stress_of;
use crate::materials::StrainStep;
use crate::math::lanes::{Lanes, WIDTH};

impl<const D: usize, const S: usize, const L: usize, const A: usize, const Q: usize> Cells<D, S, L, A, Q> {
    /// Number of history variables of a batch.
    pub(super) fn history_per_batch(&self) -> usize {
        self.physics.special.as_ref().map_or(0, |special| special.law.variables() * Q * WIDTH)
    }

    /// History variables of a batch, of those of all batches; none where the law has none or `history` is empty.
    pub(super) fn history_of(&self, index: usize, history: &[f64]) -> Vec<Lanes<false>> {
        let size = self.history_per_batch();
        let own = history.get(index * size..(index + 1) * size).unwrap_or_default();
        own.as_chunks::<WIDTH>().0.iter().map(|lanes| Lanes(*lanes)).collect()
    }

    /// [`ElementLoop::advance`](super::ElementLoop::advance).
    pub(super) fn advanced(&self, step: &Step) -> Advance {
        let mut advance = Advance { history: Vec::with_capacity(step.history.len()), heat: 0.0 };
        let Some((special, law)) = self.physics.special.as_ref().and_then(|special| Some((special, special.law.history()?))) else {
            return advance;
        };
        for (index, batch) in self.batches.iter().enumerate() {
            let kept = self.history_of(index, step.history);
            let mut after = kept.clone();
            let [start, end] = [step.u_0, step.u_1].map(|u| self.deform(batch, Some(u)));
            let (Some(start), Some(end)) = (&start.special, &end.special) else { continue };
            let strains = [start, end].map(|points| special.strains(points));
            let [first, last] = strains.each_ref().map(|strains| &strains[..Q]);
            // What is kept follows from both ends alone.
            let (dt, stress) = (step.dt, stress_of(step.derivative));
            let step = StrainStep { start: first, end: last, middle: last, history: &kept, dt, stress };
            let mut heat = [Lanes::ZERO; MOST_POINTS];
            law.advance_into(&step, &mut after, &mut heat[..Q]);
            for lane in 0..batch.count {
                advance.heat += (0..Q).map(|q| end.volume[q].0[lane] * heat[q].0[lane]).sum::<f64>();
            }
            advance.history.extend(after.iter().flat_map(|lanes| lanes.0));
        }
        advance
    }
}
