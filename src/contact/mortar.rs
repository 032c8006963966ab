//! Mortar contact in the plane over the five invariants of each facet pair.

use super::ContactKernel;
use super::patches::{Evaluation, Patches};
use super::search::Candidates;
use super::surface::Surface;
use crate::integrators::Integrator;

/// Mortar contact of two surfaces with one multiplier per secondary node.
#[derive(Clone, Debug)]
pub struct Mortar {
    secondary: Surface,
    primary: Surface,
    candidates: Candidates,
    patches: Patches,
    weights: Vec<f64>,
    facet_size: f64,
}

impl Mortar {
    /// Contact of two surfaces given by their facets (node numbers of the model, the body on the left), sized in the reference positions.
    pub fn new(secondary: &[[u32; 2]], primary: &[[u32; 2]], reference: &[f64]) -> Self {
        let (secondary, primary) = (Surface::new(secondary), Surface::new(primary));
        let weights = secondary.weights(reference);
        let facet_size = secondary.shortest_facet(reference);
        Mortar { secondary, primary, candidates: Candidates::new(2.0 * facet_size), patches: Patches::new(2), weights, facet_size }
    }
}

impl ContactKernel for Mortar {
    fn dimension(&self) -> usize {
        2
    }

    fn secondary(&self) -> &Surface {
        &self.secondary
    }

    fn primary(&self) -> &Surface {
        &self.primary
    }

    fn weights(&self) -> &[f64] {
        &self.weights
    }

    fn facet_size(&self) -> f64 {
        self.facet_size
    }

    fn update_candidates(&mut self, q: &[f64], margin: f64) -> bool {
        let changed = self.candidates.update(&self.secondary, &self.primary, q, margin);
        if changed {
            self.patches.clear();
            for &[secondary, primary] in self.candidates.pairs() {
                let [x_1, x_2] = self.secondary.facets()[secondary as usize];
                let [y_1, y_2] = self.primary.facets()[primary as usize];
                self.patches.push(&[x_1, x_2, y_1, y_2], &self.secondary.local_facets()[secondary as usize]);
            }
        }
        changed
    }

    fn patches(&self) -> &Patches {
        &self.patches
    }

    fn begin_step(&mut self, _q_0: &[f64]) {}

    fn evaluate(&self, _integrator: Integrator, _q_1: &[f64], _lambda: &[f64], out: &mut Evaluation) {
        out.prepare(&self.patches, self.secondary.nodes().len());
    }

    fn gap(&self, _q: &[f64]) -> Vec<f64> {
        vec![0.0; self.secondary.nodes().len()]
    }

    fn coverage(&self, _q: &[f64]) -> Vec<f64> {
        vec![0.0; self.secondary.nodes().len()]
    }
}
