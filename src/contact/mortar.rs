//! Mortar contact in the plane: one multiplier per secondary node, its constraint the weighted gap summed over facet pairs.
//!
//! The segments are never listed: every candidate pair contributes its clamped functions (`pair.rs`) at every configuration of the step,
//! which keeps energy and momenta exact while facets slide over each other (Hesch and Betsch 2007, equations 4 to 10). A patch is a
//! candidate pair: nodes `(x_1, x_2, y_1, y_2)`, rows `(x_1, x_2)`.
//!
//! The correction of the discrete gradient is taken per pair. Where vertices of both meshes meet at rest, kinks of neighbouring pairs cancel in
//! the sum but not in their corrections; one correction for each node would cure that, at the price of coupling all its pairs.

use super::ContactKernel;
use super::pair::{Invariants, Offsets, Overlap, PerNode, invariants, offsets, overlaps, pull_back, tangent_into};
use super::patches::{Evaluation, Patches};
use super::search::Candidates;
use super::surface::Surface;
use crate::integrators::{Configuration, Integrator, discrete_gradient};
use crate::math::tolerances::INVARIANT_INCREMENT;

/// Margin beyond the need with which candidates are searched, in shortest secondary facets: fewer new matrix patterns against more
/// stored zeros.
const SPARE: f64 = 2.0;

/// Unknowns of a pair and entries of its gradient block.
const UNKNOWNS: usize = 8;
const GRADIENTS: usize = 2 * UNKNOWNS;

/// Mortar contact of two surfaces.
#[derive(Clone, Debug)]
pub struct Mortar {
    secondary: Surface,
    primary: Surface,
    candidates: Candidates,
    patches: Patches,
    weights: Vec<f64>,
    facet_size: f64,
    start: Vec<Start>,
}

/// What a pair keeps of the start of the step.
#[derive(Clone, Copy, Debug)]
struct Start {
    offsets: Offsets,
    invariants: Invariants,
    value: PerNode<f64>,
    overlaps: bool,
}

impl Mortar {
    /// Contact of two surfaces given by their facets (node numbers of the model, the body on the left), sized in the reference positions.
    pub fn new(secondary: &[[u32; 2]], primary: &[[u32; 2]], reference: &[f64]) -> Self {
        let (secondary, primary) = (Surface::new(secondary), Surface::new(primary));
        let weights = secondary.weights(reference);
        let facet_size = secondary.shortest_facet(reference);
        let candidates = Candidates::new(SPARE * facet_size);
        Mortar { secondary, primary, candidates, patches: Patches::new(2), weights, facet_size, start: Vec::new() }
    }

    /// Searches candidates with this margin `[length]` beyond what a step needs, in place of two shortest secondary facets.
    pub fn with_spare(mut self, spare: f64) -> Self {
        self.candidates = Candidates::new(spare);
        self.patches.clear();
        self
    }

    /// The present candidate pairs (secondary facet, primary facet), in the order of the patches.
    pub fn pairs(&self) -> &[[u32; 2]] {
        self.candidates.pairs()
    }

    /// Offsets of the pair `p` at the positions `q`.
    #[inline(always)]
    fn offsets(&self, p: usize, q: &[f64]) -> Offsets {
        let at = |node: u32| [q[2 * node as usize], q[2 * node as usize + 1]];
        let nodes = self.patches.nodes(p);
        offsets(at(nodes[0]), at(nodes[1]), at(nodes[2]), at(nodes[3]))
    }

    /// Sums `contribution(pi, overlap)` of all overlapping pairs at `q` into their secondary nodes.
    fn sum(&self, q: &[f64], contribution: impl Fn(&Invariants, &Overlap) -> PerNode<f64>) -> Vec<f64> {
        let mut sums = vec![0.0; self.secondary.nodes().len()];
        for p in 0..self.patches.len() {
            let pi = invariants(&self.offsets(p, q));
            if let Some(overlap) = Overlap::new(&pi) {
                for (&row, part) in self.patches.rows(p).iter().zip(contribution(&pi, &overlap)) {
                    sums[row as usize] += part;
                }
            }
        }
        sums
    }

    /// Divides covered lengths by the node weights at `q`.
    fn normalize(&self, covered: &mut [f64], q: &[f64]) {
        for (node, share) in covered.iter_mut().enumerate().filter(|(_, share)| **share > 0.0) {
            let adjacent = self.secondary.adjacent_facets(node).iter();
            *share /= adjacent.map(|&facet| 0.5 * self.secondary.facet_length(facet as usize, q)).sum::<f64>();
        }
    }
}

/// Sum of products.
#[inline(always)]
fn dot(a: &Invariants, b: &Invariants) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4]
}

/// Covered length of each node's hat function in one pair.
#[inline(always)]
fn covered_length(pi: &Invariants, overlap: &Overlap) -> PerNode<f64> {
    overlap.coverage().map(|share| share * pi[0].sqrt())
}

/// Gradient at an overlap; zero without one.
#[inline(always)]
fn gradient(overlap: &Option<Overlap>) -> PerNode<Invariants> {
    overlap.as_ref().map_or([[0.0; 5]; 2], Overlap::gradient)
}

/// Weighted Hessian at an overlap; zero without one.
#[inline(always)]
fn hessian(overlap: &Option<Overlap>, weights: PerNode<f64>) -> [Invariants; 5] {
    overlap.as_ref().map_or([[0.0; 5]; 5], |overlap| overlap.hessian(weights))
}

/// `weights[0] f[0] + weights[1] f[1]`.
#[inline(always)]
fn weighted(f: &PerNode<Invariants>, weights: PerNode<f64>) -> Invariants {
    std::array::from_fn(|k| weights[0] * f[0][k] + weights[1] * f[1][k])
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

    fn begin_step(&mut self, q_0: &[f64]) {
        let mut start = std::mem::take(&mut self.start);
        start.clear();
        start.extend((0..self.patches.len()).map(|p| {
            let offsets = self.offsets(p, q_0);
            let invariants = invariants(&offsets);
            let overlap = Overlap::new(&invariants);
            Start { offsets, invariants, value: overlap.as_ref().map_or([0.0; 2], Overlap::value), overlaps: overlap.is_some() }
        }));
        self.start = start;
    }

    fn evaluate(&self, integrator: Integrator, q_1: &[f64], lambda: &[f64], out: &mut Evaluation) {
        assert_eq!(self.start.len(), self.patches.len(), "begin_step follows a change of the candidates");
        let placement = integrator.placement();
        let conserving = integrator == Integrator::EnergyMomentum;
        out.prepare(&self.patches, self.secondary.nodes().len());
        for (p, start) in self.start.iter().enumerate() {
            let end_z = self.offsets(p, q_1);
            let end_pi = invariants(&end_z);
            let middle_z: Offsets = std::array::from_fn(|i| 0.5 * (start.offsets[i] + end_z[i]));
            // The discrete gradient takes the mean of the invariants, the midpoint rule the invariants of the mean.
            let middle_pi =
                if conserving { std::array::from_fn(|k| 0.5 * (start.invariants[k] + end_pi[k])) } else { invariants(&middle_z) };
            if !(start.overlaps || overlaps(&middle_pi) || overlaps(&end_pi)) {
                out.clear_patch(&self.patches, p);
                continue;
            }
            out.live[p] = true;

            let rows = [self.patches.rows(p)[0] as usize, self.patches.rows(p)[1] as usize];
            let (end, middle) = (Overlap::new(&end_pi), Overlap::new(&middle_pi));
            let end_gradient = gradient(&end);
            let mut end_value = [0.0; 2];
            if let Some(end) = &end {
                end_value = end.value();
                for ((row, value), length) in rows.into_iter().zip(end_value).zip(covered_length(&end_pi, end)) {
                    out.gap[row] += value;
                    out.coverage[row] += length;
                }
            }
            let place = p * GRADIENTS..(p + 1) * GRADIENTS;
            for (block, g) in out.gradient_end[place.clone()].chunks_exact_mut(UNKNOWNS).zip(&end_gradient) {
                block.copy_from_slice(&pull_back(&end_z, g));
            }

            let weights = rows.map(|row| placement.weight * lambda[row]);
            let pressed = weights != [0.0; 2];
            let (trial, overlap) = match placement.trial {
                Configuration::Middle => (&middle_z, &middle),
                Configuration::End => (&end_z, &end),
            };
            let test = match placement.test {
                Configuration::Middle => &middle_z,
                Configuration::End => &end_z,
            };
            let mut bar;
            let (weighted_bar, slope);
            if conserving {
                let d: Invariants = std::array::from_fn(|k| end_pi[k] - start.invariants[k]);
                let middle_gradient = gradient(&middle);
                let threshold = INVARIANT_INCREMENT * INVARIANT_INCREMENT * dot(&end_pi, &end_pi);
                let square = dot(&d, &d);
                let remainder = [0, 1].map(|k| end_value[k] - start.value[k] - dot(&middle_gradient[k], &d));
                bar = middle_gradient;
                if square > threshold {
                    for k in 0..2 {
                        let a = remainder[k] / square;
                        bar[k] = std::array::from_fn(|l| middle_gradient[k][l] + a * d[l]);
                    }
                }
                (weighted_bar, slope) = if pressed {
                    discrete_gradient(
                        &d,
                        &weighted(&middle_gradient, weights),
                        &hessian(&middle, weights),
                        &weighted(&end_gradient, weights),
                        weights[0] * remainder[0] + weights[1] * remainder[1],
                        threshold,
                    )
                } else {
                    ([0.0; 5], [[0.0; 5]; 5])
                };
            } else {
                bar = if placement.trial == Configuration::End { end_gradient } else { gradient(overlap) };
                weighted_bar = weighted(&bar, weights);
                slope = hessian(overlap, weights.map(|weight| placement.share * weight));
                for g in bar.as_flattened_mut() {
                    *g *= placement.weight;
                }
            }
            for (block, g) in out.gradient_bar[place].chunks_exact_mut(UNKNOWNS).zip(&bar) {
                block.copy_from_slice(&pull_back(test, g));
            }
            let tangent = &mut out.tangent.as_chunks_mut::<{ UNKNOWNS * UNKNOWNS }>().0[p];
            if pressed {
                tangent_into(test, trial, placement.share, &weighted_bar, &slope, tangent);
            } else {
                tangent.fill(0.0);
            }
        }
        self.normalize(&mut out.coverage, q_1);
    }

    fn gap(&self, q: &[f64]) -> Vec<f64> {
        self.sum(q, |_, overlap| overlap.value())
    }

    fn coverage(&self, q: &[f64]) -> Vec<f64> {
        let mut covered = self.sum(q, covered_length);
        self.normalize(&mut covered, q);
        covered
    }
}
