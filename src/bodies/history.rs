//! What the points of a body keep: history variables, batch after batch, and what a step makes of them.
//!
//! Those of a batch stand point after point, variable after variable, the eight cells of each beside each other; what is left over in the
//! last batch repeats its first cell.

use super::batch::MOST_POINTS;
use super::cells::Cells;
use super::element_loop::{Advance, Step};
use super::special::Course;
use crate::materials::StrainStep;
use crate::math::lanes::{Lanes, WIDTH};

impl<const D: usize, const S: usize, const L: usize, const A: usize, const Q: usize> Cells<D, S, L, A, Q> {
    /// Number of history variables of a batch.
    pub(super) fn history_per_batch(&self) -> usize {
        self.physics.special.as_ref().map_or(0, |special| special.law.variables() * Q * WIDTH)
    }

    /// History variables of a batch, of those of all, into `kept`.
    pub(super) fn history_of(&self, index: usize, history: &[f64], kept: &mut Vec<Lanes<false>>) {
        kept.clear();
        let size = self.history_per_batch();
        if size > 0 && !history.is_empty() {
            kept.extend(history[index * size..][..size].as_chunks::<WIDTH>().0.iter().map(|lanes| Lanes(*lanes)));
        }
    }

    /// [`ElementLoop::advance`](super::ElementLoop::advance).
    pub(super) fn advanced(&self, step: &Step) -> Advance {
        let mut advance = Advance { history: Vec::with_capacity(step.history.len()), heat: 0.0 };
        let Some((special, law)) = self.physics.special.as_ref().and_then(|special| Some((special, special.law.history()?))) else {
            return advance;
        };
        let (mut kept, mut after) = (Vec::new(), Vec::new());
        for (index, batch) in self.batches.iter().enumerate() {
            self.history_of(index, step.history, &mut kept);
            after.clone_from(&kept);
            let [start, end] = [step.u_0, step.u_1].map(|u| self.deform(batch, Some(u)));
            let (Some(start), Some(end)) = (&start.special, &end.special) else { continue };
            let [start, strains] = [start, end].map(|points| special.strains(points));
            let course = Course { derivative: step.derivative, history: &kept, dt: step.dt };
            let step = StrainStep {
                start: &start[..Q],
                end: &strains[..Q],
                middle: &strains[..Q],
                history: course.history,
                dt: course.dt,
                stress: course.stress(),
            };
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
