//! Mortar contact in the plane: one multiplier per secondary node, whose constraint is the weighted gap summed over facet pairs.
//!
//! There is no list of overlap segments: each candidate pair contributes its clamped functions (`pair.rs`) at every configuration of the
//! step, which conserves energy and momenta while facets slide (Hesch and Betsch 2007, equations 4 to 10). A contact element is a candidate
//! pair: nodes `(x_1, x_2, y_1, y_2)`, constraints of `(x_1, x_2)`.
//!
//! The discrete gradient is corrected in each pair. At vertices of both meshes that coincide at rest, kinks of neighboring pairs cancel in
//! the sum, but not in their corrections. [`Correction::PerNode`] removes this at the price of coupling all pairs of a node.

use super::kernel::{CandidateSearch, Correction, PatchFunctions, RigidObstacle, Setting};
use super::method::ContactMethod;
use super::multiplier_shapes::{DUAL, MultiplierFunctions, STANDARD, dual_around_axis};
use super::numbers::Number;
use super::pair::{Invariants, Offsets, Overlap, PerNode, invariants, offsets, overlaps, pull_back, slip_weights, tangent_into};
use super::pair_step::{
    Differentiated, Functions, PairStart, combined, covered_length, dot, is_doubtful, remainder, round_off, value, value_and_gradient,
};
use super::patches::Evaluation;
use super::profile::PairProfiles;
use super::search::PairSearch;
use super::slip::{self, SlipRows, SlipStep};
use super::slip_on_curves;
use super::space::MortarInSpace;
use super::surface::Sides;
use crate::integrators::{Configuration, Derivative, LEAST_SQUARE};
use crate::math::norms::largest_size;
use crate::math::tolerances::{POSITION, WHOLE};

/// Mortar method with standard Lagrange multipliers on the secondary nodes.
pub static MORTAR: ContactMethod = ContactMethod {
    name: "mortar",
    summary: "mortar method: pressures at the secondary nodes, gaps integrated over the common surface",
    kernel: |secondary, primary, reference| Box::new(Mortar::new(secondary, primary, reference)),
    in_space: Some(MortarInSpace::kernel),
    is_nodal: false,
    passes_patch_test: true,
};

/// Mortar method with dual (biorthogonal) multiplier shape functions (Wohlmuth, SIAM J. Numer. Anal. 38, 2000).
pub static DUAL_MORTAR: ContactMethod = ContactMethod {
    name: "dual_mortar",
    summary: "mortar method with dual shape functions: each multiplier loads its own node only",
    kernel: |secondary, primary, reference| Box::new(Mortar::new(secondary, primary, reference).with_dual_multipliers()),
    in_space: Some(MortarInSpace::dual_kernel),
    is_nodal: false,
    passes_patch_test: true,
};

/// Search distance beyond the required one, in shortest secondary facets. Larger values give fewer new matrix patterns and more stored
/// zeros.
const SEARCH_MARGIN: f64 = 2.0;

/// Number of displacement unknowns of a facet pair: two facets of two nodes with two components each.
const UNKNOWNS: usize = 8;
/// Number of entries in the gradient block of a facet pair: gaps of two secondary nodes by the displacement unknowns.
const GRADIENTS: usize = 2 * UNKNOWNS;

/// Mortar contact of two surfaces in the plane.
#[derive(Clone, Debug)]
pub struct Mortar {
    sides: Sides,
    search: PairSearch,
    dual: bool,
    /// True for bodies of revolution: multipliers are pressure times circumference, so that a uniform pressure is linear in the radius.
    is_around_axis: bool,
    start: Vec<PairStart>,
    /// Round-off of positions at the start of the step `[length]`.
    round_off: f64,
    correction: Correction,
    /// Height profiles of each candidate pair; `None` where both facets are straight.
    pair_profiles: Vec<Option<PairProfiles>>,
}

impl Mortar {
    /// Contact of two surfaces given by their facets (model node numbers, the body on the left), sized in the reference positions.
    ///
    /// Facets on both sides define self-contact: each pair of them is listed once (the facet named first is the secondary one), without
    /// neighbors and without facets that have the body between them.
    pub fn new(secondary: &[[u32; 2]], primary: &[[u32; 2]], reference: &[f64]) -> Self {
        let sides = Sides::new(secondary, primary, reference);
        let search = PairSearch::new(&sides, reference, SEARCH_MARGIN * sides.facet_size);
        Mortar {
            sides,
            search,
            dual: false,
            is_around_axis: false,
            start: Vec::new(),
            round_off: 0.0,
            correction: Correction::PerPatch,
            pair_profiles: Vec::new(),
        }
    }

    /// Height profiles of the facets of pair `p`; `None` where both are straight.
    #[inline(always)]
    fn profiles(&self, p: usize) -> Option<&PairProfiles> {
        self.pair_profiles.get(p).and_then(Option::as_ref)
    }

    /// Uses dual multiplier shape functions: each multiplier loads its own secondary node only.
    ///
    /// Dual functions are partly negative, so that an opening of a partly covered facet would count as penetration. Facets that are not
    /// fully covered at the start of a step, or are next to an end of the opposite side, have standard functions in that step.
    pub fn with_dual_multipliers(self) -> Self {
        Mortar { dual: true, ..self }
    }

    /// Multiplier shape functions of each pair's secondary facet in a step from `q_0`. They are dual if the facet is fully covered by
    /// participating pairs and its neighbors have opposite facets within a facet's length. If the neighbors, too, had to be covered by
    /// participating pairs, shape functions, and thus active constraints, would change throughout rolling.
    fn shapes(&self, overlaps: &[Option<Overlap>], q_0: &[f64]) -> Vec<MultiplierFunctions> {
        let (pairs, secondary) = (self.search.candidates.pairs(), &self.sides.secondary);
        // Covered fraction of each facet: by participating pairs, and by participating and open pairs.
        let mut covered = vec![[0.0; 2]; secondary.facets().len()];
        for (p, (pair, overlap)) in pairs.iter().zip(overlaps).enumerate().filter(|_| self.dual) {
            let Some(overlap) = overlap else { continue };
            let share = overlap.coverage().iter().sum::<f64>();
            let is_open = || overlap.value().iter().sum::<f64>() > 0.0 && self.search.is_beside(p, &self.sides, q_0);
            let [taking_part, seen] = &mut covered[pair[0] as usize];
            if self.search.near[p] {
                *taking_part += share;
                *seen += share;
            } else if is_open() {
                *seen += share;
            }
        }
        let is_whole = |share: f64| share > 1.0 - WHOLE;
        let inside = |facet: u32| {
            let around = secondary.local_facets()[facet as usize].into_iter().flat_map(|node| secondary.adjacent_facets(node as usize));
            is_whole(covered[facet as usize][0]) && around.into_iter().all(|&other| is_whole(covered[other as usize][1]))
        };
        let shape = |(p, pair): (usize, &[u32; 2])| {
            if !inside(pair[0]) {
                return STANDARD;
            }
            let nodes = self.sides.patches.nodes(p);
            if self.is_around_axis { dual_around_axis([0, 1].map(|k| q_0[2 * nodes[k] as usize])) } else { DUAL }
        };
        pairs.iter().enumerate().map(shape).collect()
    }

    /// Multiplier shape functions of a pair in this step.
    fn shape(&self, p: usize) -> &MultiplierFunctions {
        self.start.get(p).map_or(&STANDARD, |start| &start.shape)
    }

    /// Correction of the discrete gradient shared by all pairs of secondary node `A`,
    /// `a_A = sum (Phi_1 - Phi_0 - grad Phi(pi_mid).d) / sum d.d`; 0 for increments near round-off.
    fn shared_corrections(&self, q_1: &[f64]) -> Vec<f64> {
        /// Sums over the pairs of a node: remainder and its round-off, squared increment of the invariants, squared invariants.
        #[derive(Clone, Copy, Default)]
        struct Sums {
            remainder: f64,
            round_off: f64,
            square: f64,
            size: f64,
        }
        let mut sums = vec![Sums::default(); self.sides.secondary.nodes().len()];
        for (p, start) in self.start.iter().enumerate().filter(|(p, _)| self.search.near[*p]) {
            let end_pi = invariants(&self.offsets(p, q_1));
            let middle_pi: Invariants = std::array::from_fn(|k| 0.5 * (start.invariants[k] + end_pi[k]));
            if !(start.overlaps || overlaps(&middle_pi) || overlaps(&end_pi)) {
                continue;
            }
            let d: Invariants = std::array::from_fn(|k| end_pi[k] - start.invariants[k]);
            let profiles = self.profiles(p);
            let (_, middle_gradient) = value_and_gradient(&start.shape, &Overlap::new(&middle_pi, profiles));
            let end_value = value(&start.shape, &Overlap::new(&end_pi, profiles));
            for k in 0..2 {
                let sums = &mut sums[self.sides.patches.rows(p)[k] as usize];
                let of_invariants = self.round_off * end_pi[0].sqrt();
                let values = [start.value[k], end_value[k]];
                sums.remainder += remainder(values, &middle_gradient[k], &d);
                sums.round_off += round_off(values, &middle_gradient[k], &d, of_invariants);
                sums.square += dot(&d, &d);
                sums.size += dot(&end_pi, &end_pi);
            }
        }
        let quotient = |of: &Sums| {
            let is_round_off = is_doubtful(of.square, of.size) && of.remainder.abs() <= of.round_off;
            if is_round_off || of.square <= LEAST_SQUARE { 0.0 } else { of.remainder / of.square }
        };
        sums.iter().map(quotient).collect()
    }

    /// Candidate pairs (secondary facet, primary facet), in the order of the contact elements.
    pub fn pairs(&self) -> &[[u32; 2]] {
        self.search.candidates.pairs()
    }

    /// Offsets of pair `p` at the positions `q`.
    #[inline(always)]
    fn offsets(&self, p: usize, q: &[f64]) -> Offsets {
        let at = |node: u32| [q[2 * node as usize], q[2 * node as usize + 1]];
        let nodes = self.sides.patches.nodes(p);
        offsets(at(nodes[0]), at(nodes[1]), at(nodes[2]), at(nodes[3]))
    }

    /// Sum over all overlapping pairs at `q` of `contribution(p, pi, overlap)`, per secondary node.
    fn sum(&self, q: &[f64], contribution: impl Fn(usize, &Invariants, &Overlap) -> PerNode<f64>) -> Vec<f64> {
        let mut sums = vec![0.0; self.sides.secondary.nodes().len()];
        for p in (0..self.sides.patches.len()).filter(|&p| self.search.near[p]) {
            let pi = invariants(&self.offsets(p, q));
            if let Some(overlap) = Overlap::new(&pi, self.profiles(p)) {
                for (&row, part) in self.sides.patches.rows(p).iter().zip(contribution(p, &pi, &overlap)) {
                    sums[row as usize] += part;
                }
            }
        }
        sums
    }
}

impl PatchFunctions for Mortar {
    fn sides(&self) -> &Sides {
        &self.sides
    }

    fn set(&mut self, setting: Setting) {
        match setting {
            Setting::Correction(correction) => self.correction = correction,
            Setting::AboutAxis => self.is_around_axis = true,
            Setting::Profiles(profiles) => {
                self.search.profiles = profiles;
                self.pair_profiles = self.search.pair_profiles();
            }
            Setting::BesideCorners | Setting::Workers(_) => {}
        }
    }

    fn start_gap(&self) -> Vec<f64> {
        self.search.summed(&self.sides, self.start.iter().map(|start| start.value))
    }

    fn begin_step(&mut self, q_0: &[f64]) {
        self.round_off = POSITION * largest_size(q_0);
        let mut start = std::mem::take(&mut self.start);
        start.clear();
        let offsets: Vec<Offsets> = (0..self.sides.patches.len()).map(|p| self.offsets(p, q_0)).collect();
        let overlap = |(p, offsets): (usize, &Offsets)| Overlap::new(&invariants(offsets), self.profiles(p));
        let overlaps: Vec<Option<Overlap>> = offsets.iter().enumerate().map(overlap).collect();
        let shapes = self.shapes(&overlaps, q_0);
        start.extend(offsets.into_iter().zip(overlaps).zip(shapes).map(|((offsets, overlap), shape)| PairStart {
            offsets,
            invariants: invariants(&offsets),
            value: value(&shape, &overlap),
            overlaps: overlap.is_some(),
            steady_ends: overlap.as_ref().map(Overlap::clearly_moving_ends),
            shape,
        }));
        self.start = start;
    }

    fn evaluate(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation) {
        assert_eq!(self.start.len(), self.sides.patches.len(), "begin_step follows a change of the candidates");
        let placement = derivative.placement();
        let conserving = derivative == Derivative::DiscreteGradient;
        out.prepare(&self.sides.patches, self.sides.secondary.nodes().len());
        let shared = (conserving && self.correction == Correction::PerNode).then(|| self.shared_corrections(q_1));
        for (p, start) in self.start.iter().enumerate() {
            if !self.search.near[p] {
                out.clear_patch(&self.sides.patches, p);
                continue;
            }
            let end_z = self.offsets(p, q_1);
            let end_pi = invariants(&end_z);
            let middle_z: Offsets = std::array::from_fn(|i| 0.5 * (start.offsets[i] + end_z[i]));
            // The discrete gradient uses the mean of the invariants, the midpoint rule the invariants of the mean positions.
            let middle_pi =
                if conserving { std::array::from_fn(|k| 0.5 * (start.invariants[k] + end_pi[k])) } else { invariants(&middle_z) };
            if !(start.overlaps || overlaps(&middle_pi) || overlaps(&end_pi)) {
                out.clear_patch(&self.sides.patches, p);
                continue;
            }
            out.live[p] = true;

            let rows = [self.sides.patches.rows(p)[0] as usize, self.sides.patches.rows(p)[1] as usize];
            let profiles = self.profiles(p);
            let middle = match start.steady_ends {
                Some(moves) if conserving && self.correction == Correction::SteadyEnds => Overlap::with_ends(&middle_pi, moves, profiles),
                _ => Overlap::new(&middle_pi, profiles),
            };
            let end = Overlap::new(&end_pi, profiles);
            let (end_value, end_gradient) = value_and_gradient(&start.shape, &end);
            if let Some(end) = &end {
                for ((row, value), length) in rows.into_iter().zip(end_value).zip(covered_length(&start.shape, &end_pi, end)) {
                    out.gap[row] += value;
                    out.coverage[row] += length;
                }
            }
            let place = p * GRADIENTS..(p + 1) * GRADIENTS;
            for (block, g) in out.gradient_end[place.clone()].chunks_exact_mut(UNKNOWNS).zip(&end_gradient) {
                block.copy_from_slice(&pull_back(&end_z, g));
            }

            let weights = rows.map(|row| lambda[row]);
            let pressed = weights != [0.0; 2];
            let (trial, overlap) = match placement.trial {
                Configuration::Middle => (&middle_z, &middle),
                Configuration::End => (&end_z, &end),
            };
            let test = match placement.test {
                Configuration::Middle => &middle_z,
                Configuration::End => &end_z,
            };
            let round_off = self.round_off * end_pi[0].sqrt();
            let functions =
                Functions { start, end_pi: &end_pi, end_value, end_gradient: &end_gradient, middle: &middle, weights, round_off };
            let Differentiated { bar, weighted_bar, slope } = match (&shared, derivative) {
                (Some(shared), _) => functions.with_correction(rows.map(|row| shared[row])),
                (None, Derivative::DiscreteGradient) => functions.with_own_correction(),
                (None, Derivative::Gradient(_)) => functions.plain(overlap, placement),
            };
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
        self.sides.cover(&mut out.coverage, q_1);
    }

    fn evaluate_slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        slip::evaluate(self, &self.sides.patches, step, lambda, out);
        self.sides.cover(&mut out.coverage, step.q_1);
    }

    fn gap(&self, q: &[f64]) -> Vec<f64> {
        self.sum(q, |p, _, overlap| combined(self.shape(p), &overlap.value()))
    }

    fn coverage(&self, q: &[f64]) -> Vec<f64> {
        let mut covered = self.sum(q, |p, pi, overlap| covered_length(self.shape(p), pi, overlap));
        self.sides.cover(&mut covered, q);
        covered
    }
}

impl CandidateSearch for Mortar {
    fn search(&self) -> Option<&PairSearch> {
        Some(&self.search)
    }

    fn search_mut(&mut self) -> Option<(&mut PairSearch, &Sides)> {
        Some((&mut self.search, &self.sides))
    }

    fn list_patches(&mut self) {
        self.search.list_into(&mut self.sides);
        self.pair_profiles = self.search.pair_profiles();
    }
}

impl RigidObstacle for Mortar {}

/// Slip with the weights of the gap: shape functions of the secondary facet times those of the opposite facet, over the overlap.
impl SlipRows for Mortar {
    fn places(&self, _p: usize, _z: &[f64], places: &mut Vec<usize>) -> bool {
        places.extend(0..4);
        true
    }

    fn rows<T: Number>(&self, p: usize, _places: &[usize], z: &[T], rows: &mut [T], covered: &mut [f64]) -> bool {
        let shapes = self.shape(p);
        if let Some(profiles) = self.profiles(p) {
            let Some((standard, lengths)) = slip_on_curves::slip_rows(z, profiles) else { return false };
            for (k, shape) in shapes.iter().enumerate() {
                let row = rows[8 * k..8 * k + 8].iter_mut().zip(standard[0].iter().zip(&standard[1]));
                row.for_each(|(row, (first, second))| *row = *first * shape[0] + *second * shape[1]);
                covered[k] = shape[0] * lengths[0].re() + shape[1] * lengths[1].re();
            }
            return true;
        }
        let Some((standard, t)) = slip_weights(z) else { return false };
        let length = (t[0] * t[0] + t[1] * t[1]).re().sqrt();
        for (k, shape) in shapes.iter().enumerate() {
            for node in 0..4 {
                let weight = standard[0][node] * shape[0] + standard[1][node] * shape[1];
                (0..2).for_each(|i| rows[8 * k + 2 * node + i] = t[i] * weight);
            }
            let area = |standard: &[T; 4]| (standard[0] + standard[1]).re();
            covered[k] = length * (shape[0] * area(&standard[0]) + shape[1] * area(&standard[1]));
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::super::PredictedMotion;
    use super::super::fixtures::{Rings, dense_rows, difference, evaluated, product, rings, turned, unbalance};
    use super::*;

    /// Positions of a single pair `(x_1, x_2, y_1, y_2)`.
    type Nodes = [f64; 8];

    /// Facets away from the origin that roughly face each other, with all kinds of overlap.
    fn nodes() -> impl Strategy<Value = Nodes> {
        (prop::array::uniform8(-0.3..0.3), -1.3..1.3).prop_map(|(noise, slide)| {
            let base = [3.0, -2.0, 4.0, -2.0, 4.0 + slide, -2.0, 3.0 + slide, -2.0];
            std::array::from_fn(|i| base[i] + noise[i])
        })
    }

    /// Random step with displacements of random size, in which segments appear, vanish and change ends.
    fn step() -> impl Strategy<Value = (Nodes, Nodes)> {
        (nodes(), prop::array::uniform8(-1.0..1.0), prop::sample::select(vec![1e-3, 1e-2, 0.1, 0.5]))
            .prop_map(|(q_0, noise, size)| (q_0, std::array::from_fn(|i| q_0[i] + size * noise[i])))
    }

    fn lone_pair(q_0: &[f64]) -> Mortar {
        let mut mortar = Mortar::new(&[[0, 1]], &[[2, 3]], q_0);
        mortar.update_candidates(&PredictedMotion::within(q_0, 100.0));
        mortar.begin_step(q_0);
        mortar
    }

    /// True for pairs so near a limit of overlap, or so steep, that difference quotients are inaccurate.
    fn rough(pi: &Invariants) -> bool {
        let near = |x: f64, limit: f64| (x - limit).abs() < 0.01;
        near(pi[1], 0.0) || near(pi[2], 0.0) || near(pi[1], pi[0]) || near(pi[2], pi[0]) || pi[1] - pi[2] < 0.2 || pi[0] < 0.2
    }

    fn invariants_of(q: &[f64]) -> Invariants {
        invariants(&offsets([q[0], q[1]], [q[2], q[3]], [q[4], q[5]], [q[6], q[7]]))
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 3000, rng_seed: RngSeed::Fixed(2007), failure_persistence: None, ..Default::default() })]

        #[test]
        fn the_discrete_gradient_is_directional((q_0, q_1) in step()) {
            let mortar = lone_pair(&q_0);
            let out = evaluated(&mortar, Derivative::DiscreteGradient, &q_1, &[1.0, 2.0]);
            let (gap_0, moved) = (mortar.gap(&q_0), difference(&q_1, &q_0));
            for (k, row) in out.gradient_bar.chunks_exact(8).enumerate() {
                // Scale of the round-off: positions up to 4, and gradients, which grow as facets become perpendicular.
                let size: f64 = 1.0 + row.iter().map(|g| g.abs()).sum::<f64>();
                let defect = product(row, &moved) - (out.gap[k] - gap_0[k]);
                prop_assert!(defect.abs() < 4e-15 * size, "{defect:e} of {size}");
            }
        }

        #[test]
        fn contact_forces_have_no_resultant_and_no_moment((q_0, q_1) in step()) {
            let mortar = lone_pair(&q_0);
            let middle: Vec<f64> = q_0.iter().zip(&q_1).map(|(a, b)| 0.5 * (a + b)).collect();
            for derivative in Derivative::ALL {
                let arms = if derivative.placement().test == Configuration::End { &q_1[..] } else { &middle[..] };
                let out = evaluated(&mortar, derivative, &q_1, &[1.0, 2.0]);
                for blocks in [(&out.gradient_bar, arms), (&out.gradient_end, &q_1)] {
                    let size = 1.0 + blocks.0.iter().map(|g| g.abs()).sum::<f64>();
                    let defect = unbalance(&dense_rows(&mortar, blocks.0, 8), blocks.1);
                    prop_assert!(defect < 4e-15 * size, "{derivative:?} {defect:e} of {size}");
                }
            }
        }

        #[test]
        fn tangents_agree_with_differences((q_0, q_1) in step(), lambda in prop::array::uniform2(-1.0..2.0)) {
            // The correction varies within the size of the increment, so that difference quotients must be finer.
            let width = q_0.iter().zip(&q_1).fold(0.0, |largest: f64, (a, b)| largest.max((b - a).abs()));
            let step = f64::min(2e-4, 0.01 * width);
            let middle: Nodes = std::array::from_fn(|i| 0.5 * (q_0[i] + q_1[i]));
            let (pi_0, pi_1) = (invariants_of(&q_0), invariants_of(&q_1));
            let mean: Invariants = std::array::from_fn(|k| 0.5 * (pi_0[k] + pi_1[k]));
            prop_assume!(![mean, pi_1, invariants_of(&middle)].iter().any(rough));
            let mortar = lone_pair(&q_0);
            for derivative in Derivative::ALL {
                let out = evaluated(&mortar, derivative, &q_1, &lambda);
                let force = |shift: f64, unknown: usize, blocks: fn(&Evaluation) -> &[f64]| -> [f64; 8] {
                    let mut moved = q_1;
                    moved[unknown] += shift;
                    let out = evaluated(&mortar, derivative, &moved, &lambda);
                    let bar = blocks(&out);
                    std::array::from_fn(|i| lambda[0] * bar[i] + lambda[1] * bar[8 + i])
                };
                for unknown in 0..8 {
                    let at = |shift: f64| force(shift * step, unknown, |out| &out.gradient_bar);
                    let (a, b, c, d) = (at(-2.0), at(-1.0), at(1.0), at(2.0));
                    for i in 0..8 {
                        let expected = (a[i] - 8.0 * b[i] + 8.0 * c[i] - d[i]) / (12.0 * step);
                        let ours = out.tangent[8 * i + unknown];
                        prop_assert!((ours - expected).abs() < 1e-7, "{derivative:?} [{i}][{unknown}]: {ours} {expected}");
                    }
                }
                // Gradients at a configuration against difference quotients of the gap.
                for unknown in 0..8 {
                    let at = |shift: f64| {
                        let mut moved = q_1;
                        moved[unknown] += shift * step;
                        mortar.gap(&moved)
                    };
                    let (a, b, c, d) = (at(-2.0), at(-1.0), at(1.0), at(2.0));
                    for k in 0..2 {
                        let expected = (a[k] - 8.0 * b[k] + 8.0 * c[k] - d[k]) / (12.0 * step);
                        prop_assert!((out.gradient_end[8 * k + unknown] - expected).abs() < 1e-9);
                    }
                }
            }
        }

        #[test]
        fn storage_used_again_gives_the_same_numbers((q_0, q_1) in step(), before in nodes()) {
            let mortar = lone_pair(&q_0);
            let mut out = evaluated(&mortar, Derivative::Gradient(Configuration::Middle), &before, &[1.0, 2.0]);
            mortar.evaluate(Derivative::DiscreteGradient, &q_1, &[0.0, 2.0], &mut out);
            let fresh = evaluated(&mortar, Derivative::DiscreteGradient, &q_1, &[0.0, 2.0]);
            prop_assert_eq!((&out.gap, &out.coverage, &out.live), (&fresh.gap, &fresh.coverage, &fresh.live));
            prop_assert_eq!((&out.gradient_end, &out.gradient_bar), (&fresh.gradient_end, &fresh.gradient_bar));
            prop_assert_eq!(&out.tangent, &fresh.tangent);
        }
    }

    #[test]
    fn rings_that_slide_by_several_facets_keep_energy_and_momenta() {
        for (clearance, secondary_inside, shared) in
            [(-0.002, true, false), (0.01, true, true), (0.01, false, false), (-0.002, false, true)]
        {
            let Rings { inner, outer, q } = rings(40, 48, clearance);
            let mut mortar = if secondary_inside { Mortar::new(&inner, &outer, &q) } else { Mortar::new(&outer, &inner, &q) };
            mortar.set(Setting::Correction(if shared { Correction::PerNode } else { Correction::PerPatch }));
            let q_0 = turned(&q, 40, 0.3, 1e-3);
            let q_1 = turned(&q_0, 40, 0.4, 2e-3); // 2.5 facets
            assert!(mortar.update_candidates(&PredictedMotion::within(&q_0, 0.5)));
            mortar.begin_step(&q_0);
            let lambda: Vec<f64> = (0..mortar.secondary().nodes().len()).map(|node| 1.0 + 0.5 * (node as f64).sin()).collect();
            let out = evaluated(&mortar, Derivative::DiscreteGradient, &q_1, &lambda);
            let rows = dense_rows(&mortar, &out.gradient_bar, q.len());
            let (gap_0, moved) = (mortar.gap(&q_0), difference(&q_1, &q_0));
            for (node, row) in rows.iter().enumerate() {
                // A constraint is the sum of a few pairs with gradient entries of about 0.1.
                assert!((product(row, &moved) - (out.gap[node] - gap_0[node])).abs() < 1e-15, "node {node}");
            }
            let middle: Vec<f64> = q_0.iter().zip(&q_1).map(|(a, b)| 0.5 * (a + b)).collect();
            assert!(unbalance(&rows, &middle) < 1e-15);
            assert_eq!((&out.gap, &out.coverage), (&mortar.gap(&q_1), &mortar.coverage(&q_1)));
        }
    }

    /// Closed form: a closed chain inside of a closed chain is fully covered.
    #[test]
    fn every_node_of_concentric_rings_is_wholly_covered() {
        for (inner, outer) in [(40, 48), (160, 192), (48, 40), (12, 12)] {
            let Rings { inner: facets, outer, q } = rings(inner, outer, 0.005);
            let mut mortar = Mortar::new(&facets, &outer, &q);
            for angle in [0.0, 0.1, 0.234] {
                let q = turned(&q, inner as usize, angle, 0.0);
                mortar.update_candidates(&PredictedMotion::within(&q, mortar.facet_size()));
                assert!(mortar.coverage(&q).iter().all(|share| (share - 1.0).abs() < 1e-14));
            }
        }
    }

    /// Closed form: three secondary facets of lengths 1, 1, 2 over primary facets from 0.3 to 2.2 at distance 0.25.
    #[test]
    fn a_constant_gap_over_part_of_the_surface_is_integrated_exactly() {
        let (distance, from, to) = (0.25, 0.3, 2.2);
        let q = [0.0, 0.0, 1.0, 0.0, 2.0, 0.0, 4.0, 0.0, to, -distance, 1.1, -distance, from, -distance];
        let mut mortar = Mortar::new(&[[0, 1], [1, 2], [2, 3]], &[[4, 5], [5, 6]], &q);
        mortar.update_candidates(&PredictedMotion::within(&q, 1.0));
        // Integrals of the hat functions over [0.3, 2.2].
        let hats = [0.7 * 0.7 / 2.0, 0.5 - 0.3 * 0.3 / 2.0 + 0.5, 0.5 + 0.2 * (1.0 + 0.9) / 2.0, 0.2 * 0.1 / 2.0];
        let weights = [0.5, 1.0, 1.5, 1.0];
        assert_eq!(mortar.weights(), weights);
        assert_eq!(mortar.facet_size(), 1.0);
        for (node, (gap, share)) in mortar.gap(&q).into_iter().zip(mortar.coverage(&q)).enumerate() {
            assert!((gap - distance * hats[node]).abs() < 1e-15, "gap of {node}: {gap}");
            assert!((share - hats[node] / weights[node]).abs() < 1e-15, "share of {node}: {share}");
        }
    }

    /// A flattened hose touches itself inside: opposite facets form one pair each, none through the wall.
    #[test]
    fn a_surface_that_touches_itself_has_each_pair_once() {
        // Boundary of a U, counter-clockwise, the body on the left: outer side down, along, up; inner side back.
        let corners: &[[f64; 2]] = &[[0.0, 0.0], [6.0, 0.0], [6.0, 1.0], [1.0, 1.0], [1.0, 1.5], [6.0, 1.5], [6.0, 2.5], [0.0, 2.5]];
        let mut q: Vec<f64> = Vec::new();
        for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            let count = ((to[0] - from[0]).abs() + (to[1] - from[1]).abs()) / 0.5;
            for k in 0..count as usize {
                let s = k as f64 / count;
                q.extend([from[0] + s * (to[0] - from[0]), from[1] + s * (to[1] - from[1])]);
            }
        }
        let count = q.len() as u32 / 2;
        let loop_of: Vec<[u32; 2]> = (0..count).map(|i| [i, (i + 1) % count]).collect();
        let mut mortar = Mortar::new(&loop_of, &loop_of, &q);
        mortar.update_candidates(&PredictedMotion::within(&q, 1.5));
        let pairs = mortar.pairs();
        assert!(pairs.iter().all(|[own, other]| own < other));
        // The two inner faces have the gap 1/2. They form pairs in one order only, so that half of the nodes are covered.
        let (gap, coverage) = (mortar.gap(&q), mortar.coverage(&q));
        let covered: Vec<usize> = (0..count as usize).filter(|&node| coverage[node] > 0.0).collect();
        assert!(covered.iter().all(|&node| q[2 * node + 1] == 1.0 && q[2 * node] >= 1.0), "{covered:?}");
        let length: f64 = covered.iter().map(|&node| coverage[node] * mortar.weights()[node]).sum();
        let area: f64 = covered.iter().map(|&node| gap[node]).sum();
        // Facets next to the end of the notch are neighbors of its short side and nevertheless form pairs with each other.
        assert!((area / length - 0.5).abs() < 1e-14 && length > 3.9, "{area} {length}");
    }

    /// Several primary surfaces act as one surface of all their facets.
    #[test]
    fn two_primary_pieces_act_as_one_surface() {
        let q = [0.0, 0.0, 1.0, 0.0, 2.0, 0.0, 1.0, -0.25, 0.0, -0.25, 2.0, -0.5, 1.0, -0.5];
        let (left, right) = ([[3, 4]], [[5, 6]]);
        let gap = |primary: &[[u32; 2]]| {
            let mut mortar = Mortar::new(&[[0, 1], [1, 2]], primary, &q);
            mortar.update_candidates(&PredictedMotion::within(&q, 1.0));
            mortar.gap(&q)
        };
        let both = gap(&[left, right].concat());
        for (node, (left, right)) in gap(&left).into_iter().zip(gap(&right)).enumerate() {
            assert!((both[node] - left - right).abs() < 1e-16);
        }
        assert!((both[1] - (0.5 * 0.25 + 0.5 * 0.5)).abs() < 1e-16);
    }

    /// A node without overlap has zero constraint functions and is not covered.
    #[test]
    fn bodies_apart_have_zero_functions() {
        let q_0 = [0.0, 0.0, 1.0, 0.0, 3.0, -0.1, 2.0, -0.1];
        let mortar = lone_pair(&q_0);
        let out = evaluated(&mortar, Derivative::DiscreteGradient, &q_0, &[1.0, 1.0]);
        assert_eq!(mortar.patches().len(), 1);
        assert!(!out.live[0] && out.gap == [0.0; 2] && out.coverage == [0.0; 2]);
        assert!(out.gradient_bar.iter().chain(&out.gradient_end).chain(&out.tangent).all(|x| *x == 0.0));
    }

    /// Reference values of an independent code: automatic differentiation of the prototype's `phi` and `through_invariants`. The tangent is
    /// weighted with lambda = (1.5, 0.7) and applied to [`DIRECTION`].
    struct Oracle {
        q_0: Nodes,
        q_1: Nodes,
        gap: [f64; 2],
        bar: [[f64; 8]; 2],
        tangent: [f64; 8],
    }

    const DIRECTION: Nodes = [1.0, -2.0, 0.5, 3.0, -1.0, 2.0, 0.25, -0.75];

    #[rustfmt::skip]
    const ORACLE: &[Oracle] = &[
        Oracle {
            q_0: [3.0, -1.994, 3.995, -1.918, 3.891, -2.0, 3.101, -2.023],
            q_1: [2.926, -2.087, 4.068, -1.864, 3.907, -2.139, 3.097, -1.919],
            gap: [0.005245226379668136, 0.03500553458888746],
            bar: [
                [-0.019201652981680462, 0.2259316692651519, 0.00416223998538346, 0.1615229870151875, 0.0028703700067990597, -0.14813589467026725, 0.012169042989497942, -0.23931876161007218],
                [-0.03623279814925571, 0.16676299873988495, -0.0544551481601385, 0.20236750759261585, 0.1033079522219592, -0.22255249834598817, -0.012620005912564987, -0.14657800798651266],
            ],
            tangent: [-1.072157024738679, -0.2773088365125356, -0.8877245633043233, -1.026243185264692, 0.7282343245320178, 0.5942078841298584, 1.2316472635109852, 0.7093441376473693],
        },
        Oracle {
            q_0: [2.973, -2.009, 3.962, -1.926, 4.263, -1.925, 2.775, -2.045],
            q_1: [2.997, -2.037, 3.584, -2.007, 4.256, -1.908, 2.545, -2.116],
            gap: [0.0030021525258501786, -0.0010296984912548067],
            bar: [
                [-0.03424869724608928, 0.26416517943574447, -0.004491526636410184, 0.1290929481760969, 0.014179893091592588, -0.14360110428120818, 0.024560330790906883, -0.24965702333063322],
                [-0.015125858145565326, 0.12211684503571751, -0.023309709772037238, 0.2711150771865269, 0.020790699705356717, -0.21353949643695927, 0.017644868212245847, -0.1796924257852851],
            ],
            tangent: [-0.04229355671847925, -0.020186666835426782, -0.2778700330304227, -0.1517971594893615, 0.1618928688157362, -0.15249577553607008, 0.15827072093316522, 0.32447960186085834],
        },
        Oracle {
            q_0: [2.98, -2.016, 4.021, -2.116, 3.699, -2.042, 2.588, -1.932],
            q_1: [2.997, -2.007, 3.837, -2.105, 3.903, -2.274, 2.717, -1.914],
            gap: [0.018220996896489594, 0.03973471113825605],
            bar: [
                [0.0448873719341259, 0.3049410771110465, 0.03859058730885354, 0.14581953719717197, -0.04256788090898832, -0.25233230880667795, -0.04091007833399112, -0.1984283055015405],
                [-0.003541982201443424, 0.14454616507724619, 0.032448362213145426, 0.18809913796839955, -0.009806400623924755, -0.2543684452992003, -0.01909997938777725, -0.07827685774644551],
            ],
            tangent: [-0.24410998383028895, -0.24571764022518, -1.6308049605051116, -0.5741170678701868, 1.2924067577271456, 0.21882684961352583, 0.5825081866082553, 0.6010078584818412],
        },
        Oracle {
            q_0: [2.987, -1.96, 4.015, -1.974, 4.501, -1.888, 3.946, -1.926],
            q_1: [2.977, -1.86, 4.231, -2.075, 4.532, -1.958, 3.965, -2.104],
            gap: [0.0009116791237459287, 0.003154831553863091],
            bar: [
                [0.0006961888468192404, 0.0010938737407739422, -9.679439822080504e-06, 0.011638419853994653, 0.00017591050187719588, -0.0014174219057640528, -0.0008624199088743555, -0.011314871689004543],
                [0.012032236106838868, 0.008537762229022009, -0.02158693395083354, 0.15125382544988222, 0.003096097306905345, -0.027219612507871596, 0.006458600537089346, -0.13257197517103264],
            ],
            tangent: [0.17072122240410162, 0.013852035092021271, 0.723549901082346, -0.23232832977975143, 0.032114944349987615, 0.007061838756350761, -0.926386067836436, 0.21141445593137942],
        },
        Oracle {
            q_0: [2.988, -2.004, 4.018, -1.927, 3.014, -2.006, 2.213, -2.01],
            q_1: [3.088, -2.004, 4.118, -1.927, 3.014, -2.006, 2.213, -2.01],
            gap: [0.0, 0.0],
            bar: [
                [-0.00045741121917893007, 0.00010699573779863503, -0.00031394778359240084, -4.996844691868036e-05, 0.00038567950138566464, -2.8513645439977394e-05, 0.00038567950138566627, -2.8513645439977272e-05],
                [-6.35896812540212e-06, 1.4874634851255169e-06, -4.364527727344122e-06, -6.946654299431158e-07, 5.36174792637311e-06, -3.963990275912014e-07, 5.361747926373133e-06, -3.963990275911997e-07],
            ],
            tangent: [0.0025820970558423605, 0.1576879126896831, 0.017092475851521804, -0.04835752410103906, -0.006217245001198723, -0.04833277052291753, -0.013457327906165434, -0.0609976180657265],
        },
    ];

    #[test]
    fn agrees_with_an_independent_code() {
        for oracle in ORACLE {
            let mortar = lone_pair(&oracle.q_0);
            let out = evaluated(&mortar, Derivative::DiscreteGradient, &oracle.q_1, &[1.5, 0.7]);
            let close = |ours: f64, theirs: f64, tolerance: f64| {
                assert!((ours - theirs).abs() < tolerance, "{ours:e} against {theirs:e}");
            };
            (0..2).for_each(|k| close(out.gap[k], oracle.gap[k], 1e-15));
            // Both codes divide the same difference, which has cancellation, by |dpi|^2, at least about 1e-2.
            (0..16).for_each(|i| close(out.gradient_bar[i], oracle.bar[i / 8][i % 8], 1e-14));
            (0..8).for_each(|i| close(product(&out.tangent[8 * i..8 * i + 8], &DIRECTION), oracle.tangent[i], 1e-12));
        }
    }

    /// Below `INVARIANT_INCREMENT` the correction is dropped. With aligned vertices of both meshes, where every pair has a kink, the error
    /// would be depth times slide (3e-9 at an angle of 1e-5) if the kinks of neighboring pairs did not cancel in the sum.
    #[test]
    fn tiny_slides_from_aligned_vertices_keep_the_energy() {
        let Rings { inner, outer, q: q_0 } = rings(40, 48, -0.002);
        let mut mortar = Mortar::new(&inner, &outer, &q_0);
        mortar.update_candidates(&PredictedMotion::within(&q_0, 0.5));
        mortar.begin_step(&q_0);
        let gap_0 = mortar.gap(&q_0);
        for angle in [1e-3, 1e-4, 1e-5, 1e-6, 1e-7] {
            let q_1 = turned(&q_0, 40, angle, 0.0);
            let out = evaluated(&mortar, Derivative::DiscreteGradient, &q_1, &[1.0; 40]);
            let moved = difference(&q_1, &q_0);
            for (node, row) in dense_rows(&mortar, &out.gradient_bar, q_0.len()).iter().enumerate() {
                // Round-off of positions up to 1, times gradients of about 0.1.
                assert!((product(row, &moved) - (out.gap[node] - gap_0[node])).abs() < 1e-17, "angle {angle:e}, node {node}");
            }
        }
    }

    #[test]
    fn facets_that_have_moved_apart_do_not_meet_through_their_bodies() {
        // Facets face to face at a distance of 0.1; then the lower one far above, as after half a turn of two disks.
        let q_0 = [0.0, 0.0, 1.0, 0.0, 1.0, -0.1, 0.0, -0.1];
        let mut mortar = Mortar::new(&[[0, 1]], &[[2, 3]], &q_0);
        assert!(mortar.update_candidates(&PredictedMotion::within(&q_0, 0.5)));
        assert!((mortar.gap(&q_0)[0] - 0.05).abs() < 1e-15);
        let q_1 = [0.0, 0.0, 1.0, 0.0, 1.0, 5.0, 0.0, 5.0];
        assert!(!mortar.update_candidates(&PredictedMotion::within(&q_1, 0.5)), "the list is kept");
        mortar.begin_step(&q_1);
        assert_eq!(mortar.gap(&q_1), [0.0; 2]);
        assert_eq!(mortar.coverage(&q_1), [0.0; 2]);
        let out = evaluated(&mortar, Derivative::DiscreteGradient, &q_1, &[1.0; 2]);
        assert!(!out.live[0] && out.gap == [0.0; 2]);
    }
}
