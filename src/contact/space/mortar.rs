//! Mortar contact in space: one multiplier per secondary node, whose constraint is the weighted gap summed over facet pairs (`pair.rs`).
//!
//! A contact element is a candidate pair with the nodes of both facets and the constraints of the secondary nodes. The discrete gradient of
//! each pair is projected orthogonally to the rigid motions of its nodes at mid-step, so that energy, linear and angular momentum are exact
//! while facets slide.

use super::curve_slip::PlaneTangents;
use super::dual::{Duals, MultiplierFunctions};
use super::facet_profile::Profile;
use super::gaps::Measure;
use super::pair::{Gradients, Pair};
use super::second_order::ProxySurfacesInSpace;
use super::slip;
use super::vectors::Vec3;
use super::vertices::{CORNERS, UNKNOWNS};
use crate::contact::faces;
use crate::contact::kernel::{CandidateSearch, ContactKernel, Correction, PatchFunctions, RigidObstacle, Setting, TangentSink};
use crate::contact::patches::{Evaluation, Patches};
use crate::contact::search::PairSearch;
use crate::contact::slip::SlipStep;
use crate::contact::surface::Sides;
use crate::integrators::{Configuration, Derivative, LEAST_SQUARE, PatchFunction, Projection};
use crate::math::tolerances::{EDGES_MEET, PROJECTED_INCREMENT};
use crate::math::workers::Workers;

/// Search distance beyond the required one, in smallest secondary facets.
const SEARCH_MARGIN: f64 = 0.5;

/// Number of pairs per task of a thread.
const SHARED: usize = 32;
const TURNS: usize = 16;

/// Mortar contact of two surfaces in space.
#[derive(Clone, Debug)]
pub struct MortarInSpace {
    sides: Sides,
    search: PairSearch,
    /// Positions of all nodes at the start of the step, and each pair there.
    q_0: Vec<f64>,
    start: Vec<PairStart>,
    /// Height profiles of the facets of both sides.
    profiles: [Vec<Profile>; 2],
    /// Heights of the curves above the nodes of both sides.
    heights: [Vec<f64>; 2],
    /// Tangents at each node of each secondary facet, in its axes.
    tangents: Vec<Vec<PlaneTangents>>,
    /// Threads that evaluate the pairs.
    workers: Workers,
    /// Variant of the discrete gradient.
    correction: Correction,
    /// Dual functions of the secondary side; `None` for standard multipliers.
    duals: Option<Duals>,
}

/// State of a facet pair at the start of the step.
#[derive(Clone, Debug)]
struct PairStart {
    values: [f64; CORNERS],
    overlaps: bool,
}

/// Buffers of one evaluation, reused for all pairs.
#[derive(Default)]
struct Scratch {
    live: Vec<Live>,
    /// Blocks of the live pairs, one after the other.
    gradient_end: Vec<f64>,
    gradient_bar: Vec<f64>,
    tangent: Vec<f64>,
    /// Positions of the nodes of a pair at the start, at the end and in the middle of the step.
    start: Vec<f64>,
    end: Vec<f64>,
    middle: Vec<f64>,
    /// Gradient of one function.
    row: Vec<f64>,
    /// Weighted Hessian.
    hessian: Vec<f64>,
    /// Gradients at mid-step and at the end, weighted by the multipliers.
    weighted: [Vec<f64>; 2],
    projection: Projection<3>,
}

/// Round-off of the remainder of a weighted gap, which is summed over the polygons of clipped facets, relative to that of a single product
/// of its gradient: with 1, blocks of like meshes between walls of symmetry need 2 to 3 times the steps (`tests/scripts/contacts.rhai`).
const CLIPPED: f64 = 30.0;

/// Live pair of facets (with nonzero functions), and its contributions to sums over all pairs of a constraint.
#[derive(Default)]
struct Live {
    pair: usize,
    has_tangent: bool,
    /// Weighted gaps and covered areas at the end of the step; `None` without overlap there.
    end: Option<[[f64; CORNERS]; 2]>,
    /// Data for a correction that is shared by all pairs of a constraint: remainders of the discrete gradient and their round-off,
    /// projected increment of the pair's nodes, squared size of the pair.
    remainders: [f64; CORNERS],
    round_offs: [f64; CORNERS],
    increment: Vec<f64>,
    size: f64,
}

/// Requested evaluation of a step.
#[derive(Clone, Copy)]
struct Asked<'a> {
    derivative: Derivative,
    q_1: &'a [f64],
    lambda: &'a [f64],
    wants_tangent: bool,
}

/// Destination of the tangent blocks of an evaluation.
enum Tangents<'a, 'b> {
    /// Tangent blocks are stored in the evaluation.
    Stay,
    /// Tangent blocks go to the receiver, one contact element after another.
    To(&'a mut TangentSink<'b>),
    /// No tangent is computed.
    LeftOut,
}

impl MortarInSpace {
    /// Contact of two surfaces with standard multipliers, sized in the reference positions. Self-contact lists each pair of facets once.
    pub fn kernel(surfaces: &ProxySurfacesInSpace) -> Box<dyn ContactKernel> {
        Box::new(Self::new(surfaces))
    }

    /// Contact of two surfaces with dual multiplier shape functions: each multiplier loads its own secondary node only.
    pub fn dual_kernel(surfaces: &ProxySurfacesInSpace) -> Box<dyn ContactKernel> {
        Box::new(MortarInSpace { duals: Some(Duals::new(&surfaces.secondary, &surfaces.reference)), ..Self::new(surfaces) })
    }

    fn new(surfaces: &ProxySurfacesInSpace) -> Self {
        let ProxySurfacesInSpace { secondary, primary, reference, .. } = surfaces;
        let sides = Sides::of(secondary.clone(), primary.clone(), reference);
        let search = PairSearch::new(&sides, reference, SEARCH_MARGIN * sides.facet_size);
        let profiles = [surfaces.secondary_profiles(), surfaces.primary_profiles()];
        let tangents = slip::plane_tangents(&sides.secondary, reference, &profiles[0]);
        MortarInSpace {
            sides,
            search,
            q_0: Vec::new(),
            start: Vec::new(),
            profiles,
            heights: [0, 1].map(|side| surfaces.heights(side)),
            tangents,
            workers: Workers::default(),
            correction: Correction::default(),
            duals: None,
        }
    }

    /// Height profiles of the facets of pair `p`.
    pub(super) fn profiles(&self, p: usize) -> [&Profile; 2] {
        let [own, other] = self.search.candidates.pairs()[p];
        [&self.profiles[0][own as usize], &self.profiles[1][other as usize]]
    }

    /// Multiplier shape functions of pair `p` in this step.
    pub(super) fn shape(&self, p: usize) -> &MultiplierFunctions {
        self.duals.as_ref().map_or(&MultiplierFunctions::STANDARD, |duals| duals.shape(self.search.candidates.pairs()[p][0]))
    }

    /// Tangents at the secondary nodes of pair `p`, in the axes of the secondary facet.
    pub(super) fn tangents(&self, p: usize) -> &[PlaneTangents] {
        &self.tangents[self.search.candidates.pairs()[p][0] as usize]
    }

    /// Numbers of nodes of both facets of pair `p`.
    pub(super) fn counts(&self, p: usize) -> [usize; 2] {
        let [own, other] = self.search.candidates.pairs()[p];
        [self.sides.secondary.facet(own as usize).len(), self.sides.primary.facet(other as usize).len()]
    }

    /// Pair `p` at the positions of its nodes; `None` without overlap.
    fn pair(&self, p: usize, z: &[f64]) -> Option<Pair<f64>> {
        Some(Pair::at(z.as_chunks().0, self.counts(p)).filter(Pair::overlaps)?.curved(self.profiles(p)))
    }

    /// Width of the band, relative to triangle heights, within which edge forces pass gradually from one facet to the other.
    fn band(&self) -> f64 {
        if self.correction == Correction::SteadyEnds { 0.0 } else { EDGES_MEET }
    }

    /// Adds corrections shared by the pairs of a constraint, `e_A = sum R / sum p.p` times each pair's projected increment `p`.
    fn correct(&self, shared: &[Live], out: &mut Evaluation) {
        let patches = &self.sides.patches;
        let mut of_rows = vec![[0.0; 4]; self.sides.weights.len()];
        for live in shared {
            let square = live.increment.iter().map(|p| p * p).sum::<f64>();
            for (&row, (remainder, round_off)) in patches.rows(live.pair).iter().zip(live.remainders.into_iter().zip(live.round_offs)) {
                let of_row = &mut of_rows[row as usize];
                [remainder, round_off, square, live.size].iter().zip(of_row).for_each(|(part, sum)| *sum += part);
            }
        }
        let threshold = PROJECTED_INCREMENT * PROJECTED_INCREMENT;
        for live in shared {
            let range = out.gradient_range(patches, live.pair);
            let blocks = out.gradient_bar[range].chunks_exact_mut(live.increment.len());
            for (block, &row) in blocks.zip(patches.rows(live.pair)) {
                let [remainder, round_off, square, size] = of_rows[row as usize];
                let is_round_off = square <= LEAST_SQUARE || square <= threshold * size && remainder.abs() <= CLIPPED * round_off;
                let e = if is_round_off { 0.0 } else { remainder / square };
                block.iter_mut().zip(&live.increment).for_each(|(g, p)| *g += e * p);
            }
        }
    }

    /// Values, gradients and tangent of a step, pair by pair in ascending order, so that results do not depend on the number of threads.
    fn evaluate_pairs(&self, asked: Asked, out: &mut Evaluation, mut tangents: Tangents) {
        let patches = &self.sides.patches;
        assert_eq!(self.start.len(), patches.len(), "begin_step follows a change of the candidates");
        out.begin_live(patches, self.sides.weights.len());
        let mut shared = Vec::new();
        let mut scratches: Vec<Scratch> = (0..TURNS * self.workers.count()).map(|_| Scratch::default()).collect();
        let together = SHARED * scratches.len();
        for first in (0..patches.len()).step_by(together) {
            self.workers.for_each(&mut scratches, 1, |k, scratch| {
                let [begin, end] = [k, k + 1].map(|k| (first + SHARED * k).min(patches.len()));
                scratch.evaluate_all(self, begin..end, asked);
            });
            scratches.iter_mut().for_each(|scratch| scratch.hand_over(patches, out, &mut tangents, &mut shared));
        }
        self.correct(&shared, out);
        self.sides.cover(&mut out.coverage, asked.q_1);
    }

    /// Sum over all participating pairs that overlap at `q` of `contribution`, per secondary node.
    fn sum(&self, q: &[f64], contribution: impl Fn(&Pair<f64>) -> [f64; CORNERS] + Sync + Send) -> Vec<f64> {
        let contributions = self.of_pairs(q, [0.0; CORNERS], |p, pair| self.shape(p).of(contribution(pair)));
        self.search.summed(&self.sides, contributions.into_iter())
    }

    /// Values of all pairs at `q`; `none` for those that do not participate or overlap.
    fn of_pairs<V: Clone + Send>(&self, q: &[f64], none: V, value: impl Fn(usize, &Pair<f64>) -> V + Sync + Send) -> Vec<V> {
        let mut values = vec![none; self.sides.patches.len()];
        self.workers.for_each(&mut values, SHARED, |p, of_pair| {
            if self.search.near[p] {
                let mut z = Vec::with_capacity(UNKNOWNS);
                self.sides.patches.gather_into(p, q, &mut z);
                self.pair(p, &z).iter().for_each(|pair| *of_pair = value(p, pair));
            }
        });
        values
    }
}

/// Writes the gradients for all secondary nodes, each with `unknowns` entries, one after another.
fn lists_into(gradients: Option<&Gradients>, unknowns: usize, out: &mut [f64]) {
    out.chunks_exact_mut(unknowns).enumerate().for_each(|(k, block)| list_into(gradients, k, block));
}

/// Writes the gradient for secondary node `k`; zeros without a pair.
fn list_into(gradients: Option<&Gradients>, k: usize, out: &mut [f64]) {
    match gradients {
        Some(gradients) => out.iter_mut().zip(gradients.as_flattened()).for_each(|(out, each)| *out = each.0[k]),
        None => out.fill(0.0),
    }
}

impl PatchFunctions for MortarInSpace {
    fn sides(&self) -> &Sides {
        &self.sides
    }

    fn start_gap(&self) -> Vec<f64> {
        self.search.summed(&self.sides, self.start.iter().map(|start| start.values))
    }

    fn begin_step(&mut self, q_0: &[f64]) {
        if let Some(mut duals) = self.duals.take() {
            duals.choose(&self.search, &self.sides, q_0, |p| {
                let mut z = Vec::new();
                self.sides.patches.gather_into(p, q_0, &mut z);
                self.pair(p, &z)
            });
            self.duals = Some(duals);
        }
        let none = PairStart { values: [0.0; CORNERS], overlaps: false };
        self.start = self.of_pairs(q_0, none, |p, pair| PairStart { values: self.shape(p).of(pair.values()), overlaps: true });
        self.q_0.clear();
        self.q_0.extend_from_slice(q_0);
    }

    fn set(&mut self, setting: Setting) {
        match setting {
            Setting::Correction(correction) => self.correction = correction,
            Setting::Workers(workers) => self.workers = workers.clone(),
            Setting::AboutAxis | Setting::BesideCorners | Setting::Profiles(_) => {}
        }
    }

    fn bytes(&self) -> u64 {
        self.sides.patches.gradient_bytes()
    }

    fn evaluate(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation) {
        self.evaluate_pairs(Asked { derivative, q_1, lambda, wants_tangent: true }, out, Tangents::Stay);
    }

    fn linearize(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation, tangent: Option<&mut TangentSink>) {
        let asked = Asked { derivative, q_1, lambda, wants_tangent: tangent.is_some() };
        self.evaluate_pairs(asked, out, tangent.map_or(Tangents::LeftOut, Tangents::To));
    }

    fn evaluate_slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        slip::evaluate(self, &self.sides, step, lambda, out);
        self.sides.cover(&mut out.coverage, step.q_1);
    }

    fn gap(&self, q: &[f64]) -> Vec<f64> {
        self.sum(q, Pair::values)
    }

    fn coverage(&self, q: &[f64]) -> Vec<f64> {
        let mut covered = self.sum(q, Pair::covered);
        self.sides.cover(&mut covered, q);
        covered
    }
}

impl Scratch {
    /// Evaluates a range of pairs.
    fn evaluate_all(&mut self, kernel: &MortarInSpace, pairs: std::ops::Range<usize>, asked: Asked) {
        self.live.clear();
        [&mut self.gradient_end, &mut self.gradient_bar, &mut self.tangent].into_iter().for_each(Vec::clear);
        pairs.filter(|&p| kernel.search.near[p]).for_each(|p| self.evaluate(kernel, p, asked));
    }

    /// Moves the results of the live pairs to an evaluation; pairs that share a correction are appended to `shared`.
    fn hand_over(&mut self, patches: &Patches, out: &mut Evaluation, tangents: &mut Tangents, shared: &mut Vec<Live>) {
        let (mut ends, mut bars, mut tangent) = (&self.gradient_end[..], &self.gradient_bar[..], &self.tangent[..]);
        for live in self.live.drain(..) {
            let p = live.pair;
            if let Some([values, areas]) = live.end {
                for ((&row, value), area) in patches.rows(p).iter().zip(values).zip(areas) {
                    out.gap[row as usize] += value;
                    out.coverage[row as usize] += area;
                }
            }
            let square = if live.has_tangent { patches.tangent_range(p).len() } else { 0 };
            let (block, rest) = tangent.split_at(square);
            tangent = rest;
            let place = out.open(patches, p, live.has_tangent && matches!(tangents, Tangents::Stay));
            for (to, from) in [(place.gradient_end, &mut ends), (place.gradient_bar, &mut bars)] {
                let (own, rest) = from.split_at(to.len());
                to.copy_from_slice(own);
                *from = rest;
            }
            match tangents {
                Tangents::Stay if live.has_tangent => place.tangent.copy_from_slice(block),
                Tangents::To(receiver) if live.has_tangent => receiver(p, block),
                _ => {}
            }
            if !live.increment.is_empty() {
                shared.push(live);
            }
        }
    }

    /// Evaluates pair `p`, unless its functions are zero at start, middle and end of the step.
    fn evaluate(&mut self, kernel: &MortarInSpace, p: usize, asked: Asked) {
        let Asked { derivative, q_1, lambda, wants_tangent } = asked;
        let (start, shape) = (&kernel.start[p], kernel.shape(p));
        let Scratch { gradient_end, gradient_bar, tangent, start: start_z, end: end_z, middle: middle_z, .. } = self;
        let patches = &kernel.sides.patches;
        patches.gather_into(p, &kernel.q_0, start_z);
        patches.gather_into(p, q_1, end_z);
        middle_z.clear();
        middle_z.extend(start_z.iter().zip(&*end_z).map(|(a, b)| 0.5 * (a + b)));
        let (end, middle) = (kernel.pair(p, end_z), kernel.pair(p, middle_z));
        if !start.overlaps && middle.is_none() && end.is_none() {
            return;
        }
        let (rows, unknowns) = (patches.rows(p), end_z.len());
        let weights: [f64; CORNERS] = std::array::from_fn(|k| rows.get(k).map_or(0.0, |&row| lambda[row as usize]));
        let has_tangent = wants_tangent && weights != [0.0; CORNERS];
        let mut found = Live { pair: p, has_tangent, ..Live::default() };
        let at_end = end.as_ref().map(|end| (end.gradients(0.0), end.covered()));
        found.end = at_end.as_ref().map(|((_, values), covered)| [shape.of(*values), shape.of(*covered)]);
        let firsts = [gradient_end.len(), gradient_bar.len(), tangent.len()];
        gradient_end.resize(firsts[0] + rows.len() * unknowns, 0.0);
        gradient_bar.resize(firsts[1] + rows.len() * unknowns, 0.0);
        tangent.resize(firsts[2] + if has_tangent { unknowns * unknowns } else { 0 }, 0.0);
        let at_end = at_end.map(|((gradients, _), _)| shape.of_gradients(gradients));
        lists_into(at_end.as_ref(), unknowns, &mut gradient_end[firsts[0]..]);
        let functions = Functions { kernel, start, shape, weights, middle, end };
        if derivative == Derivative::DiscreteGradient {
            self.by_discrete_gradient(&functions, &mut found, firsts);
        } else {
            let placement = derivative.placement();
            let pair = match placement.test {
                Configuration::Middle => &functions.middle,
                Configuration::End => &functions.end,
            };
            let band = kernel.band();
            let acting = pair.as_ref().map(|pair| shape.of_gradients(pair.gradients(band).0));
            lists_into(acting.as_ref(), unknowns, &mut gradient_bar[firsts[1]..]);
            if let Some(pair) = pair.as_ref().filter(|_| has_tangent) {
                pair.hessian_into(&shape.back(weights), band, placement.share, &mut tangent[firsts[2]..]);
            }
        }
        self.live.push(found);
    }

    /// Writes the discrete gradient of a pair and its derivative into the blocks that start at the given indices.
    fn by_discrete_gradient(&mut self, functions: &Functions, found: &mut Live, [first_end, first_bar, first_of_tangent]: [usize; 3]) {
        let &Functions { kernel, start, shape, weights, ref middle, .. } = functions;
        let Scratch { gradient_end, gradient_bar, tangent, start: start_z, end: end_z, row, hessian, weighted, projection, .. } = self;
        let (gradient_end, gradient_bar, tangent) =
            (&gradient_end[first_end..], &mut gradient_bar[first_bar..], &mut tangent[first_of_tangent..]);
        let (unknowns, band, pressed) = (end_z.len(), kernel.band(), shape.back(weights));
        let values = found.end.map_or([0.0; CORNERS], |[values, _]| values);
        projection.set(start_z, end_z);
        let [of_middle, of_end] = weighted;
        for vector in [&mut *of_middle, &mut *of_end, &mut *row] {
            vector.clear();
            vector.resize(unknowns, 0.0);
        }
        let in_middle = middle.as_ref().map(|middle| shape.of_gradients(middle.gradients(band).0));
        if kernel.correction == Correction::PerNode {
            lists_into(in_middle.as_ref(), unknowns, gradient_bar);
            for (k, bar) in gradient_bar.chunks_exact(unknowns).enumerate() {
                found.remainders[k] = projection.remainder(bar, values[k] - start.values[k]);
                found.round_offs[k] = projection.round_off(bar);
            }
            found.increment.extend(projection.increment());
            found.size = projection.size();
            if let Some(middle) = middle.as_ref().filter(|_| found.has_tangent) {
                middle.hessian_into(&pressed, band, 0.5, tangent);
            }
            return;
        }
        let blocks = gradient_bar.chunks_exact_mut(unknowns).zip(gradient_end.chunks_exact(unknowns));
        for (k, (bar, at_end)) in blocks.enumerate() {
            list_into(in_middle.as_ref(), k, row);
            projection.gradient_into(row, values[k] - start.values[k], bar);
            of_middle.iter_mut().zip(&*row).for_each(|(sum, g)| *sum += weights[k] * g);
            of_end.iter_mut().zip(at_end).for_each(|(sum, g)| *sum += weights[k] * g);
        }
        if found.has_tangent {
            hessian.resize(unknowns * unknowns, 0.0);
            match middle {
                Some(middle) => middle.hessian_into(&pressed, band, 1.0, hessian),
                None => hessian.fill(0.0),
            }
            let change = (0..CORNERS).map(|k| weights[k] * (values[k] - start.values[k])).sum();
            let function = PatchFunction { gradient_mid: of_middle, gradient_end: of_end, hessian_mid: hessian, change };
            projection.tangent_into(1.0, &function, tangent);
        }
    }
}

/// The functions of a pair in a step.
struct Functions<'a> {
    kernel: &'a MortarInSpace,
    start: &'a PairStart,
    shape: &'a MultiplierFunctions,
    /// Multipliers of the secondary nodes.
    weights: [f64; CORNERS],
    middle: Option<Pair<f64>>,
    end: Option<Pair<f64>>,
}

impl CandidateSearch for MortarInSpace {
    fn search(&self) -> Option<&PairSearch> {
        Some(&self.search)
    }

    fn search_mut(&mut self) -> Option<(&mut PairSearch, &Sides)> {
        Some((&mut self.search, &self.sides))
    }

    fn deepest(&self, q: &[f64]) -> f64 {
        let surfaces = [&self.sides.secondary, &self.sides.primary];
        self.search.deepest_in_space(&self.sides, q, |[side, index], facet, flat| {
            let profile = &self.profiles[1 - side][facet as usize];
            let own = self.heights[side][index];
            if profile.is_flat() {
                return flat - own;
            }
            let node = surfaces[side].nodes()[index];
            let nodes = std::iter::once(&node).chain(surfaces[1 - side].facet(facet as usize));
            let z: Vec<Vec3<f64>> = nodes.map(|&node| faces::at(node, q).into()).collect();
            Measure::above(&z, profile).gap(&z) - own
        })
    }

    fn list_patches(&mut self) {
        self.search.list_into(&mut self.sides);
        self.sides.list_slips();
    }
}

impl RigidObstacle for MortarInSpace {}
