//! Mortar contact in the plane with averaged nodal normals (Yang, Laursen and Meng, IJNME 62, 2005): the normal is continuous along the
//! secondary side. At corners sharper than 45 degrees in the reference positions each facet keeps its own normal.
//!
//! Nodal normal: normalized mean of the unit normals of the adjacent facets. On a facet `n(s) = (1 - s) n_1 + s n_2`. The primary point
//! `y(s)` lies on the line through `x(s)` along `n(s)`. Weighted gap of node `k` over the overlap `[a, b]` of a facet pair:
//!
//! ```text
//! Phi_k = |t| int_a^b N_k(s) n(s).(y(s) - x(s)) ds        by Gauss points        [length^2], > 0 when open
//! ```
//!
//! with `x(s)` and `y(s)` moved along `n(s)` to the curves where facets have height profiles.
//!
//! The discrete gradient is the projected one, because the functions have no short list of invariants. Derivatives come from dual numbers.
//! A contact element is a candidate facet pair with the neighbors of its secondary facet, whose motion turns the normals.

use num_dual::{Dual2SVec64, DualSVec64};

use super::averaged_overlap::{AveragedOverlap, DIFFERENCES, Point, VARIABLES, Values, WeightedGaps, unit, weighted_gaps};
use super::kernel::{CandidateSearch, PatchFunctions, RigidObstacle, Setting};
use super::method::ContactMethod;
use super::numbers::Number;
use super::patches::Evaluation;
use super::profile::PairProfiles;
use super::search::PairSearch;
use super::slip::{self, SlipRows, SlipStep};
use super::slip_on_curves;
use super::surface::{Sides, Surface};
use crate::integrators::{Configuration, Derivative, PatchFunction, Projection};
use crate::math::tolerances::SMOOTH;

/// Mortar method with averaged nodal normals, interpolated along the secondary facets (Yang, Laursen and Meng, IJNME 62, 2005).
pub static AVERAGED_MORTAR: ContactMethod = ContactMethod {
    name: "averaged_mortar",
    summary: "mortar method with averaged nodal normals: the normal is continuous along the secondary side",
    kernel: |secondary, primary, reference| Box::new(AveragedMortar::new(secondary, primary, reference)),
    in_space: None,
    is_nodal: false,
    passes_patch_test: true,
};

/// Search distance beyond the required one, in shortest secondary facets.
const SEARCH_MARGIN: f64 = 1.0;

/// Nodes `x_0, x_1, x_2, x_3, y_1, y_2` of a contact element, and the coefficient of each in the difference vectors `[6 x 5]`.
const ROLES: usize = 6;
#[rustfmt::skip]
const SHARES: [[f64; DIFFERENCES]; ROLES] = [
    [-1.0,  0.0,  0.0,  0.0,  0.0],
    [ 1.0, -1.0,  0.0, -1.0, -1.0],
    [ 0.0,  1.0, -1.0,  0.0,  0.0],
    [ 0.0,  0.0,  1.0,  0.0,  0.0],
    [ 0.0,  0.0,  0.0,  1.0,  0.0],
    [ 0.0,  0.0,  0.0,  0.0,  1.0],
];

/// Mortar contact kernel of two surfaces with averaged nodal normals.
#[derive(Clone, Debug)]
pub struct AveragedMortar {
    sides: Sides,
    search: PairSearch,
    /// Nodes before and after each secondary facet, whose facets contribute to its nodal normals; `None` across a corner sharper than 45
    /// degrees and at ends of chains.
    neighbors: Vec<[Option<u32>; 2]>,
    pairs: Vec<Pair>,
    start: Vec<PairStart>,
}

/// Candidate facet pair: index of each of the six nodes in the contact element; `None` for a missing neighbor.
#[derive(Clone, Copy, Debug)]
struct Pair {
    roles: [Option<u8>; ROLES],
    /// Height profiles of both facets; `None` if both are straight.
    profiles: Option<PairProfiles>,
}

/// Positions, difference vectors and weighted gaps of a facet pair at the start of the step.
#[derive(Clone, Debug)]
struct PairStart {
    positions: Vec<f64>,
    value: Option<Values<f64>>,
}

/// Gradient and Hessian of a function of a contact element.
#[derive(Clone, Debug, Default)]
struct Derivatives {
    gradient: Vec<f64>,
    hessian: Vec<f64>,
}

impl AveragedMortar {
    /// Contact of two surfaces given by their facets (model node numbers, the body on the left), sized in the reference positions.
    pub fn new(secondary: &[[u32; 2]], primary: &[[u32; 2]], reference: &[f64]) -> Self {
        let sides = Sides::new(secondary, primary, reference);
        let search = PairSearch::new(&sides, reference, SEARCH_MARGIN * sides.facet_size);
        let neighbors = (0..sides.secondary.facets().len()).map(|facet| neighbors(&sides.secondary, facet, reference)).collect();
        AveragedMortar { sides, search, neighbors, pairs: Vec::new(), start: Vec::new() }
    }

    /// Positions of the nodes of contact element `p`.
    fn gather(&self, p: usize, q: &[f64]) -> Vec<f64> {
        self.sides.patches.nodes(p).iter().flat_map(|&node| [q[2 * node as usize], q[2 * node as usize + 1]]).collect()
    }

    /// Sum of `part` over all facet pairs that take part at `q`, for each secondary node.
    fn sum(&self, q: &[f64], part: impl Fn(Pair, &[f64]) -> Option<Values<f64>>) -> Vec<f64> {
        let mut sums = vec![0.0; self.sides.secondary.nodes().len()];
        for (p, pair) in self.pairs.iter().enumerate().filter(|(p, _)| self.search.near[*p]) {
            if let Some(parts) = part(*pair, &self.gather(p, q)) {
                self.sides.patches.rows(p).iter().zip(parts).for_each(|(&row, part)| sums[row as usize] += part);
            }
        }
        sums
    }
}

/// Nodes before and after a facet on its chain; `None` across sharp corners of the reference positions. A normal averaged over a sharp
/// corner is normal to neither facet, and points beside the corner would count as points in front of it.
fn neighbors(surface: &Surface, facet: usize, reference: &[f64]) -> [Option<u32>; 2] {
    let facets = surface.facets();
    let along = |facet: usize| {
        let [a, b] = facets[facet].map(|node| 2 * node as usize);
        [reference[b] - reference[a], reference[b + 1] - reference[a + 1]]
    };
    let neighbors = surface.neighbors(facet);
    [0, 1].map(|end| {
        let other = neighbors[end]? as usize;
        let (t, u) = (along(facet), along(other));
        let cosine = (t[0] * u[0] + t[1] * u[1]) / (t[0].hypot(t[1]) * u[0].hypot(u[1]));
        (cosine > SMOOTH).then(|| facets[other][end])
    })
}

impl Pair {
    /// Difference vectors of the contact element with the node positions `z`.
    fn differences<T: Number>(self, z: &[T]) -> [T; VARIABLES] {
        let mut differences = [T::from(0.0); VARIABLES];
        for (role, shares) in self.roles.iter().zip(SHARES) {
            let Some(place) = role else { continue };
            for (k, share) in shares.into_iter().enumerate() {
                for i in 0..2 {
                    differences[2 * k + i] += z[2 * *place as usize + i] * share;
                }
            }
        }
        differences
    }

    /// Existence of a neighbor before and after the secondary facet.
    fn has_neighbors(self) -> [bool; 2] {
        [self.roles[0].is_some(), self.roles[3].is_some()]
    }

    fn values(self, z: &[f64]) -> Option<Values<f64>> {
        weighted_gaps(&self.differences(z), self.has_neighbors(), self.profiles.as_ref()).map(|gaps| gaps.gap)
    }

    fn covered(self, z: &[f64]) -> Option<Values<f64>> {
        weighted_gaps(&self.differences(z), self.has_neighbors(), self.profiles.as_ref()).map(|gaps| gaps.covered)
    }

    /// Values of both weighted gaps, and their gradients, concatenated; `None` without overlap.
    fn gradients(self, z: &[f64]) -> Option<(WeightedGaps<f64>, Vec<f64>)> {
        let differences = self.differences(z);
        let variables = std::array::from_fn(|i| DualSVec64::<VARIABLES>::from_re(differences[i]).derivative(i));
        let gaps = weighted_gaps(&variables, self.has_neighbors(), self.profiles.as_ref())?;
        let mut gradients = vec![0.0; 2 * z.len()];
        for (gap, out) in gaps.gap.iter().zip(gradients.chunks_exact_mut(z.len())) {
            self.pull_back(gap.eps.0.as_ref().map_or(&[0.0; VARIABLES], |eps| &eps.data.0[0]), out);
        }
        Some((WeightedGaps { gap: gaps.gap.map(|gap| gap.re), covered: gaps.covered.map(|length| length.re) }, gradients))
    }

    /// Gradient and Hessian of `weights[0] Phi_1 + weights[1] Phi_2`; zero without overlap.
    fn weighted_into(self, z: &[f64], weights: Values<f64>, out: &mut Derivatives) {
        out.gradient.clear();
        out.gradient.resize(z.len(), 0.0);
        out.hessian.clear();
        out.hessian.resize(z.len() * z.len(), 0.0);
        let differences = self.differences(z);
        let variables = std::array::from_fn(|i| Dual2SVec64::<VARIABLES>::from_re(differences[i]).derivative(i));
        let Some(gaps) = weighted_gaps(&variables, self.has_neighbors(), self.profiles.as_ref()) else { return };
        let [first, second] = gaps.gap;
        let sum = first * weights[0] + second * weights[1];
        if let num_dual::Derivative(Some(gradient)) = sum.v1 {
            self.pull_back(&std::array::from_fn(|i| gradient[i]), &mut out.gradient);
        }
        let num_dual::Derivative(Some(hessian)) = sum.v2 else { return };
        // Chain rule `H = S^T H_d S` with the coefficients `S`: first the rows, then the columns.
        let width = z.len();
        for variable in 0..VARIABLES {
            let mut column = vec![0.0; width];
            self.pull_back(&std::array::from_fn(|i| hessian[(i, variable)]), &mut column);
            for (role, shares) in self.roles.iter().zip(SHARES) {
                let (Some(place), share) = (role, shares[variable / 2]) else { continue };
                for (row, value) in column.iter().enumerate() {
                    out.hessian[row * width + 2 * *place as usize + variable % 2] += share * value;
                }
            }
        }
    }

    /// Transforms a gradient with respect to the difference vectors to the node positions, and adds it to `out`.
    fn pull_back(self, gradient: &[f64; VARIABLES], out: &mut [f64]) {
        for (role, shares) in self.roles.iter().zip(SHARES) {
            let Some(place) = role else { continue };
            for (k, share) in shares.into_iter().enumerate() {
                for i in 0..2 {
                    out[2 * *place as usize + i] += share * gradient[2 * k + i];
                }
            }
        }
    }
}

/// Slip integrated over the overlap, along the tangent perpendicular to the averaged normal.
impl SlipRows for AveragedMortar {
    fn places(&self, p: usize, _z: &[f64], places: &mut Vec<usize>) -> bool {
        places.extend(0..self.sides.patches.nodes(p).len());
        self.search.near[p]
    }

    fn rows<T: Number>(&self, p: usize, _places: &[usize], z: &[T], rows: &mut [T], covered: &mut [f64]) -> bool {
        let (pair, width) = (self.pairs[p], z.len());
        let Some(overlap) = AveragedOverlap::new(&pair.differences(z), pair.has_neighbors()) else { return false };
        let places = [1, 2, 4, 5].map(|role| usize::from(pair.roles[role].expect("both facets have their nodes")));
        for point in overlap.points(pair.profiles.is_some()) {
            let Point { measure, shapes, normal: n, opposite, .. } = point;
            if let Some(profiles) = &pair.profiles {
                let [own, other] = overlap.points_of_curves(profiles, &point);
                let mut row = [T::from(0.0); 8];
                // Gaps have the measure `|n| dl`.
                slip_on_curves::add_points([-n[1], n[0]], own, other, &mut row);
                for (k, shape) in shapes.into_iter().enumerate() {
                    let weight = measure * shape;
                    covered[k] += weight.re();
                    for (place, part) in places.into_iter().zip(row.chunks_exact(2)) {
                        (0..2).for_each(|i| rows[k * width + 2 * place + i] += weight * part[i]);
                    }
                }
                continue;
            }
            let [x, y] = unit(n);
            let (along, shares) = ([-y, x], [shapes[0], shapes[1], opposite - 1.0, -opposite]);
            for (k, shape) in shapes.into_iter().enumerate() {
                let weight = measure * shape;
                covered[k] += weight.re();
                for (place, share) in places.into_iter().zip(shares) {
                    (0..2).for_each(|i| rows[k * width + 2 * place + i] += along[i] * weight * share);
                }
            }
        }
        true
    }
}

impl PatchFunctions for AveragedMortar {
    fn sides(&self) -> &Sides {
        &self.sides
    }

    fn set(&mut self, setting: Setting) {
        if let Setting::Profiles(profiles) = setting {
            self.search.profiles = profiles;
            self.list_patches();
        }
    }

    fn begin_step(&mut self, q_0: &[f64]) {
        let starts = self.pairs.iter().enumerate().map(|(p, pair)| {
            let positions = self.gather(p, q_0);
            PairStart { value: pair.values(&positions), positions }
        });
        self.start = starts.collect();
    }

    fn start_gap(&self) -> Vec<f64> {
        self.search.summed(&self.sides, self.start.iter().map(|start| start.value.unwrap_or_default()))
    }

    fn evaluate(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation) {
        assert_eq!(self.start.len(), self.pairs.len(), "begin_step follows a change of the candidates");
        let placement = derivative.placement();
        let patches = &self.sides.patches;
        out.prepare(patches, self.sides.secondary.nodes().len());
        let (mut projection, mut weighted) = (Projection::<2>::default(), Derivatives::default());
        for (p, (start, pair)) in self.start.iter().zip(&self.pairs).enumerate() {
            if !self.search.near[p] {
                out.clear_patch(patches, p);
                continue;
            }
            let z_1 = self.gather(p, q_1);
            let z_mid: Vec<f64> = start.positions.iter().zip(&z_1).map(|(a, b)| 0.5 * (a + b)).collect();
            let (at_end, at_middle) = (pair.gradients(&z_1), pair.gradients(&z_mid));
            if start.value.is_none() && at_middle.is_none() && at_end.is_none() {
                out.clear_patch(patches, p);
                continue;
            }
            out.live[p] = true;
            let width = z_1.len();
            let rows = [patches.rows(p)[0] as usize, patches.rows(p)[1] as usize];
            let gradient_end = &mut out.gradient_end[patches.gradient_range(p)];
            gradient_end.fill(0.0);
            let mut value = [0.0; 2];
            if let Some((gaps, gradients)) = &at_end {
                gradient_end.copy_from_slice(gradients);
                value = gaps.gap;
                for k in 0..2 {
                    out.gap[rows[k]] += gaps.gap[k];
                    out.coverage[rows[k]] += gaps.covered[k];
                }
            }
            let pressures = rows.map(|row| lambda[row]);
            let pressed = pressures != [0.0; 2];
            let bar = &mut out.gradient_bar[patches.gradient_range(p)];
            let tangent = &mut out.tangent[patches.tangent_range(p)];
            tangent.fill(0.0);
            if derivative == Derivative::DiscreteGradient {
                let before = start.value.unwrap_or_default();
                let change = [0, 1].map(|k| value[k] - before[k]);
                let nothing = vec![0.0; 2 * width];
                let middle = at_middle.as_ref().map_or(&nothing, |(_, gradients)| gradients);
                projection.set(&start.positions, &z_1);
                for (k, bar) in bar.chunks_exact_mut(width).enumerate() {
                    projection.gradient_into(&middle[k * width..(k + 1) * width], change[k], bar);
                }
                if pressed {
                    pair.weighted_into(&z_mid, pressures, &mut weighted);
                    let sum = |gradients: &[f64]| -> Vec<f64> {
                        (0..width).map(|i| pressures[0] * gradients[i] + pressures[1] * gradients[width + i]).collect()
                    };
                    let function = PatchFunction {
                        gradient_mid: &weighted.gradient,
                        gradient_end: &sum(gradient_end),
                        hessian_mid: &weighted.hessian,
                        change: pressures[0] * change[0] + pressures[1] * change[1],
                    };
                    projection.tangent_into(1.0, &function, tangent);
                }
            } else {
                let (at, z) = match placement.test {
                    Configuration::Middle => (&at_middle, &z_mid),
                    Configuration::End => (&at_end, &z_1),
                };
                bar.fill(0.0);
                if let Some((_, gradients)) = at {
                    bar.copy_from_slice(gradients);
                }
                if pressed {
                    pair.weighted_into(z, pressures, &mut weighted);
                    tangent.iter_mut().zip(&weighted.hessian).for_each(|(tangent, h)| *tangent = placement.share * h);
                }
            }
        }
        self.sides.cover(&mut out.coverage, q_1);
    }

    fn evaluate_slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        slip::evaluate(self, &self.sides.patches, step, lambda, out);
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

impl CandidateSearch for AveragedMortar {
    fn search(&self) -> Option<&PairSearch> {
        Some(&self.search)
    }

    fn search_mut(&mut self) -> Option<(&mut PairSearch, &Sides)> {
        Some((&mut self.search, &self.sides))
    }

    fn list_patches(&mut self) {
        self.sides.patches.clear();
        self.pairs.clear();
        for (&[own, other], profiles) in self.search.candidates.pairs().iter().zip(self.search.pair_profiles()) {
            let [x_1, x_2] = self.sides.secondary.facets()[own as usize];
            let [y_1, y_2] = self.sides.primary.facets()[other as usize];
            let [before, after] = self.neighbors[own as usize];
            let mut nodes: Vec<u32> = Vec::with_capacity(ROLES);
            let roles = [before, Some(x_1), Some(x_2), after, Some(y_1), Some(y_2)].map(|node| {
                let node = node?;
                let known = nodes.iter().position(|&other| other == node);
                Some(known.unwrap_or_else(|| {
                    nodes.push(node);
                    nodes.len() - 1
                }) as u8)
            });
            self.sides.patches.push(&nodes, &self.sides.secondary.local_facets()[own as usize]);
            self.pairs.push(Pair { roles, profiles });
        }
    }
}

impl RigidObstacle for AveragedMortar {}
