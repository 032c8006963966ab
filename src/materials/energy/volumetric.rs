//! Energy of the volume ratio, given as text, for formulations with a volume change of their own (`split.rs`).

use super::graph::{Graph, Id};
use super::law::{ENERGY, Run, SLOPES, with_scratch};
use super::small_strain::{Sizes, simpson};
use super::tape::{Block, Root, Tape};
use super::variable::Variable;
use crate::materials::split::VolumetricLaw;
use crate::math::lanes::Lanes;
use crate::math::simd::dispatch;

/// Energy that depends on `J` only, as a tape with two stages: [`ENERGY`], and [`SLOPES`] with the first and second derivative.
pub(super) struct VolumetricEnergy(Tape);

impl VolumetricEnergy {
    pub(super) fn new(graph: &mut Graph, energy: Id) -> Self {
        let slope = graph.derivative(energy, Variable::J);
        let curvature = graph.derivative(slope, Variable::J);
        VolumetricEnergy(Tape::new(graph, &[Variable::J], &[&[energy], &[slope, curvature]]))
    }

    /// Runs the tape up to a stage at a value of `J - 1`, and reads its registers.
    fn run_at(&self, stage: usize, change: &Lanes<false>, read: impl FnOnce(&[Root], &[Block])) {
        with_scratch(self.0.registers(), 0, |registers, _| {
            registers[0][0] = *change;
            registers[1][0] = -*change / (*change + 1.0);
            dispatch(Run { tape: &self.0, stage, points: 1, start: None, registers });
            read(&self.0.roots, registers);
        });
    }
}

impl VolumetricLaw for VolumetricEnergy {
    fn energies_into(&self, change: &[Lanes<false>], energy: &mut [Lanes<false>]) {
        for (change, energy) in change.iter().zip(energy) {
            let sizes = Sizes::of([&[[*change]]], self.0.has_kinks_near_rest());
            if sizes.has_large() {
                self.run_at(ENERGY, change, |roots, registers| *energy = roots[0].deviation(registers, 0).unwrap_or(Lanes::ZERO));
            }
            if sizes.has_small() {
                let mut at = [Lanes::ZERO; 3];
                for (share, slope) in [0.0, 0.5, 1.0].into_iter().zip(&mut at) {
                    self.run_at(SLOPES, &(*change * share), |roots, registers| *slope = roots[1].value(registers, 0));
                }
                *energy = sizes.select(0, simpson(at) * *change, *energy);
            }
        }
    }

    fn responses_into(&self, change: &[Lanes<false>], responses: &mut [[Lanes<false>; 2]]) {
        for (change, response) in change.iter().zip(responses) {
            self.run_at(SLOPES, change, |roots, registers| *response = [1, 2].map(|root| roots[root].value(registers, 0)));
        }
    }

    fn has_kinks(&self) -> bool {
        self.0.has_kinks()
    }
}
