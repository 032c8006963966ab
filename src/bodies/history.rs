//! History variables at the quadrature points of a body, and their change in a step.
//!
//! Memory order: batch after batch, point after point, variable after variable, and for each variable the values of the eight cells of the
//! batch. Unused lanes of the last batch repeat its first cell.

use super::batch::MOST_POINTS;
use super::cells::Cells;
use super::element_loop::{Advance, BodyState, Step};
use super::special::stress_of;
use crate::materials::{Heat, StrainStep};
use crate::math::lanes::{Lanes, WIDTH};

impl<const D: usize, const S: usize, const L: usize, const A: usize, const Q: usize> Cells<D, S, L, A, Q> {
    /// Number of history variables of a batch.
    pub(super) fn history_per_batch(&self) -> usize {
        self.physics.special.as_ref().map_or(0, |special| special.law.variables() * self.table.counts.points() * WIDTH)
    }

    /// History variables of batch `index` from those of all batches; empty if the law has none or `history` is empty.
    pub(super) fn history_of(&self, index: usize, history: &[f64]) -> Vec<Lanes<false>> {
        let size = self.history_per_batch();
        let own = history.get(index * size..(index + 1) * size).unwrap_or_default();
        own.as_chunks::<WIDTH>().0.iter().map(|lanes| Lanes(*lanes)).collect()
    }

    /// Implements [`ElementLoop::advance`](super::ElementLoop::advance).
    pub(super) fn advanced(&self, step: &Step) -> Advance {
        let mut advance = Advance { history: Vec::with_capacity(step.history.len()), plastic: 0.0, viscous: 0.0 };
        let Some((special, law)) = self.physics.special.as_ref().and_then(|special| Some((special, special.law.history()?))) else {
            return advance;
        };
        let points = self.table.counts.points();
        for (index, batch) in self.batches.iter().enumerate() {
            let kept = self.history_of(index, step.history);
            let mut after = kept.clone();
            let [start, end] = [step.u_0, step.u_1].map(|u| self.deform(batch, Some(u)));
            let (Some(start), Some(end)) = (&start.special, &end.special) else { continue };
            let strains = [start, end].map(|points| special.strains(points));
            let [first, last] = strains.each_ref().map(|strains| &strains[..points]);
            let (changes, dt, stress) = (special.changes(start, end), step.dt, stress_of(step.derivative));
            let middles = special.middles(start, end);
            let (change, middle) = (&changes[..points], &middles[..points]);
            let step = StrainStep { start: first, end: last, middle, change, history: &kept, dt, stress };
            let mut heat = [Heat::ZERO; MOST_POINTS];
            law.advance_into(&step, &mut after, &mut heat[..points]);
            for lane in 0..batch.count {
                let sum = |of: fn(&Heat) -> Lanes<false>| (0..points).map(|q| end.volume[q].0[lane] * of(&heat[q]).0[lane]).sum::<f64>();
                advance.plastic += sum(|heat| heat.plastic);
                advance.viscous += sum(|heat| heat.viscous);
            }
            advance.history.extend(after.iter().flat_map(|lanes| lanes.0));
        }
        advance
    }

    /// Implements [`ElementLoop::relaxed`](super::ElementLoop::relaxed).
    pub(super) fn relaxed_history(&self, BodyState { u, history }: BodyState) -> Vec<f64> {
        let Some((special, law)) = self.physics.special.as_ref().and_then(|special| Some((special, special.law.history()?))) else {
            return Vec::new();
        };
        let mut relaxed = Vec::with_capacity(history.len());
        for (index, batch) in self.batches.iter().enumerate() {
            let mut kept = self.history_of(index, history);
            if let Some(points) = &self.deform(batch, Some(u)).special {
                law.relax(&special.strains(points)[..points.count], &mut kept);
            }
            relaxed.extend(kept.iter().flat_map(|lanes| lanes.0));
        }
        relaxed
    }

    /// Implements [`ElementLoop::relaxing_energy`](super::ElementLoop::relaxing_energy).
    pub(super) fn relaxing_energy_of(&self, history: &[f64]) -> f64 {
        let Some(law) = self.physics.special.as_ref().and_then(|special| special.law.history()).filter(|law| law.variables() > 0) else {
            return 0.0;
        };
        let (mut sum, points) = (0.0, self.table.counts.points());
        for (index, batch) in self.batches.iter().enumerate() {
            let mut energies = [Lanes::ZERO; MOST_POINTS];
            law.add_relaxing_energies(&self.history_of(index, history), &mut energies[..points]);
            if energies[..points].iter().flat_map(|energy| energy.0).all(|energy| energy == 0.0) {
                continue;
            }
            let volumes = self.deform(batch, None).volumes;
            for lane in 0..batch.count {
                sum += (0..points).map(|q| volumes[q].0[lane] * energies[q].0[lane]).sum::<f64>();
            }
        }
        sum
    }
}
