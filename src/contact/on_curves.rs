//! Contact method on points that are linear combinations of nodes (`quadratic.rs`), with the interface of a method on the nodes.
//!
//! With points `y = P q` and multipliers `lambda' = S lambda` of the inner method, its functions `Phi'(y)` become `Phi(q) = S^T Phi'(P q)`,
//! its gradients `S^T G' P` and its tangent `P^T K' P`. Directionality is preserved: `G (q_1 - q_0) = S^T G' (y_1 - y_0)`. The coefficients
//! of a point sum to one: points follow rigid motions, and momenta are conserved as by the inner method.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, PoisonError};

use super::combinations::Combinations;
use super::kernel::{CandidateSearch, ContactKernel, PatchFunctions, RigidObstacle, TangentSink};
use super::patches::{Evaluation, Patches};
use super::search::Candidates;
use super::slip::SlipStep;
use super::surface::Sides;
use super::window::{MappedMotion, PredictedMotion};
use crate::integrators::Derivative;

/// Contact method on points (the inner method), presented as a method on the nodes.
pub(super) struct OnCurves {
    /// Inner method; its node numbers are point numbers.
    inner: Box<dyn ContactKernel>,
    /// Surfaces between nodes of the model, with contact elements that couple these nodes.
    sides: Sides,
    /// Points as combinations of nodes, `P`.
    points: Combinations,
    /// Inner constraints as combinations of outer ones, `S`.
    rows: Combinations,
    row_nodes: Vec<u32>,
    /// Home nodes of each point: the nodes whose multipliers the point interpolates. Inner contact elements with equal home nodes are
    /// merged.
    homes: Combinations,
    /// Inner contact elements merged into each outer one.
    members: Vec<Vec<Member>>,
    /// Coefficients of each inner node in the nodes of its outer contact element.
    patch_nodes: Combinations,
    /// Coefficients of each inner constraint in the constraints of its outer contact element.
    patch_rows: Combinations,
    scratch: Mutex<Scratch>,
}

/// Inner contact element as a part of an outer one.
#[derive(Clone, Copy)]
struct Member {
    patch: usize,
    /// Index of the first inner node in [`OnCurves::patch_nodes`].
    node: usize,
    /// Index of the first inner constraint in [`OnCurves::patch_rows`].
    row: usize,
}

/// Buffers of an evaluation.
#[derive(Default)]
struct Scratch {
    inner: Evaluation,
    proxies: Vec<f64>,
    lambda: Vec<f64>,
    /// Half-transformed tangent `K' P`: only its columns belong to nodes.
    half: Vec<f64>,
}

impl OnCurves {
    /// Makes the outer method for the inner method `inner` on `points`. `rows`: inner constraints as combinations of outer constraints;
    /// `homes`: home nodes of the points; `sides`: surfaces between nodes; `row_nodes`: nodes to which constraints belong, if any.
    pub fn new(inner: Box<dyn ContactKernel>, sides: Sides, [points, rows, homes]: [Combinations; 3], row_nodes: Vec<u32>) -> Self {
        let mut weights = vec![0.0; if row_nodes.is_empty() { inner.rows() } else { inner.rows_per_node() * row_nodes.len() }];
        rows.add_values_back(inner.weights(), &mut weights);
        let mut curved = OnCurves {
            inner,
            sides: Sides { weights, ..sides },
            points,
            rows,
            row_nodes,
            homes,
            members: Vec::new(),
            patch_nodes: Combinations::default(),
            patch_rows: Combinations::default(),
            scratch: Mutex::default(),
        };
        curved.list();
        curved
    }

    /// Merges the inner contact elements into outer ones.
    fn list(&mut self) {
        let inner = self.inner.patches();
        let mut places = BTreeMap::new();
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for p in 0..inner.len() {
            let homes = inner.nodes(p).iter().flat_map(|&point| self.homes.parts(point as usize)).map(|(node, _)| *node);
            let homes: BTreeSet<u32> =
                homes.chain(inner.rows(p).iter().flat_map(|&row| self.rows.parts(row as usize)).map(|(row, _)| *row)).collect();
            let group = *places.entry(homes).or_insert(groups.len());
            if group == groups.len() {
                groups.push(Vec::new());
            }
            groups[group].push(p);
        }
        self.sides.patches = Patches::new(inner.dimension());
        self.patch_nodes.clear();
        self.patch_rows.clear();
        self.members.clear();
        let (mut nodes, mut rows) = (Vec::new(), Vec::new());
        for group in groups {
            nodes.clear();
            rows.clear();
            let member = |patch: usize| {
                let member = Member { patch, node: self.patch_nodes.len(), row: self.patch_rows.len() };
                for (of, own, made, list) in [
                    (inner.nodes(patch), &self.points, &mut self.patch_nodes, &mut nodes),
                    (inner.rows(patch), &self.rows, &mut self.patch_rows, &mut rows),
                ] {
                    for &entry in of {
                        made.push(own.parts(entry as usize).iter().map(|&(k, share)| (place(list, k), share)));
                    }
                }
                member
            };
            let members = group.into_iter().map(member).collect();
            self.members.push(members);
            self.sides.patches.push(&nodes, &rows);
        }
        if self.sides.patches.dimension() == 3 {
            self.sides.list_slips();
        }
    }

    /// Positions `P q` of the points.
    fn proxies(&self, q: &[f64]) -> Vec<f64> {
        self.points.points(self.sides.patches.dimension(), q)
    }

    /// Predicted motion of the points.
    fn motion<'a>(&self, of_nodes: &PredictedMotion<'a>) -> MappedMotion<'a> {
        of_nodes.mapped(self.proxies(of_nodes.q), |sizes| self.points.bounds(sizes), |u| self.proxies(u))
    }

    /// Sums `S^T values` of inner values, per outer constraint.
    fn gathered(&self, values: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.sides.weights.len()];
        self.rows.add_values_back(values, &mut sums);
        sums
    }

    /// Adds the covered fractions of the inner constraints to those of the outer constraints, `sums`. `each`: tangential constraints per
    /// normal constraint, or 1 for normal constraints.
    fn cover(&self, each: usize, coverage: &[f64], sums: &mut [f64]) {
        for (entry, share) in coverage.iter().enumerate().filter(|(_, share)| **share != 0.0) {
            let weight = self.inner.weights()[entry / each];
            for &(row, part) in self.rows.parts(entry / each) {
                sums[each * row as usize + entry % each] += part * weight * share / self.sides.weights[row as usize];
            }
        }
    }

    /// Number of tangential constraints per normal constraint.
    fn tangents(&self) -> usize {
        self.sides.patches.dimension() - 1
    }

    /// Adds the gradient blocks of an inner contact element to those of the outer one, `S^T G' P`.
    fn gradients_into(&self, [patches, own]: [&Patches; 2], p: usize, Member { patch, node, row }: Member, from: &[f64], to: &mut [f64]) {
        let (few, many, d) = (patches.unknowns(patch), own.unknowns(p), patches.dimension());
        let each = patches.rows(patch).len() / self.inner.patches().rows(patch).len();
        for (entry, from) in from.chunks_exact(few).enumerate() {
            for &(row, by) in self.patch_rows.parts(row + entry / each) {
                let row = each * row as usize + entry % each;
                let to = &mut to[row * many..(row + 1) * many];
                for (entry, g) in from.chunks_exact(d).enumerate() {
                    for &(place, share) in self.patch_nodes.parts(node + entry) {
                        (0..d).for_each(|i| to[d * place as usize + i] += by * share * g[i]);
                    }
                }
            }
        }
    }

    /// Adds the tangent block of an inner contact element to that of the outer one, `P^T K' P`.
    fn tangent_into(&self, p: usize, Member { patch, node, .. }: Member, from: &[f64], half: &mut Vec<f64>, to: &mut [f64]) {
        let patches = self.inner.patches();
        let (few, many, d) = (patches.unknowns(patch), self.sides.patches.unknowns(p), patches.dimension());
        half.clear();
        half.resize(few * many, 0.0);
        for (half, from) in half.chunks_exact_mut(many).zip(from.chunks_exact(few)) {
            for (entry, k) in from.chunks_exact(d).enumerate() {
                for &(place, share) in self.patch_nodes.parts(node + entry) {
                    (0..d).for_each(|i| half[d * place as usize + i] += share * k[i]);
                }
            }
        }
        for (entry, rows) in half.chunks_exact(d * many).enumerate() {
            for &(place, share) in self.patch_nodes.parts(node + entry) {
                let to = &mut to[d * place as usize * many..d * (place as usize + 1) * many];
                to.iter_mut().zip(rows).for_each(|(to, from)| *to += share * from);
            }
        }
    }

    /// Transforms an evaluation of the inner method to the nodes, for normal constraints (`each` = 1) or `each` tangential constraints per
    /// normal one. `inner_lambda` are the inner multipliers.
    fn on_nodes(
        &self,
        [of, own]: [&Patches; 2],
        each: usize,
        inner: &Evaluation,
        inner_lambda: Option<&[f64]>,
        half: &mut Vec<f64>,
        out: &mut Evaluation,
    ) {
        out.begin_live(own, each * self.sides.weights.len());
        for (entry, gap) in inner.gap.iter().enumerate() {
            self.rows.parts(entry / each).iter().for_each(|&(row, part)| out.gap[each * row as usize + entry % each] += part * gap);
        }
        self.cover(each, &inner.coverage, &mut out.coverage);
        let is_pressed = |member: &Member| {
            inner_lambda.is_some_and(|inner_lambda| of.rows(member.patch).iter().any(|&row| inner_lambda[row as usize] != 0.0))
        };
        for (p, members) in self.members.iter().enumerate() {
            let live = || members.iter().filter(|member| inner.live[member.patch]);
            if live().next().is_none() {
                continue;
            }
            let place = out.open(own, p, live().any(is_pressed));
            for &member in live() {
                let range = inner.gradient_range(of, member.patch);
                self.gradients_into([of, own], p, member, &inner.gradient_end[range.clone()], place.gradient_end);
                self.gradients_into([of, own], p, member, &inner.gradient_bar[range], place.gradient_bar);
                if is_pressed(&member) {
                    self.tangent_into(p, member, &inner.tangent[inner.tangent_range(of, member.patch)], half, place.tangent);
                }
            }
        }
    }

    /// Values and gradients of a step, with or without the tangent.
    fn evaluate_inner(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], wants_tangent: bool, out: &mut Evaluation) {
        let mut scratch = self.scratch.lock().unwrap_or_else(PoisonError::into_inner);
        let Scratch { inner, proxies, lambda: inner_lambda, half } = &mut *scratch;
        self.points.points_into(self.sides.patches.dimension(), q_1, proxies);
        self.rows.values_into(lambda, inner_lambda);
        if wants_tangent {
            self.inner.evaluate(derivative, proxies, inner_lambda, inner);
        } else {
            self.inner.linearize(derivative, proxies, inner_lambda, inner, None);
        }
        self.on_nodes([self.inner.patches(), &self.sides.patches], 1, inner, wants_tangent.then_some(inner_lambda), half, out);
        inner.drop_tangent();
    }
}

/// Index of an item in a list, to which it is appended if missing.
fn place(list: &mut Vec<u32>, item: u32) -> u32 {
    let known = list.iter().position(|&other| other == item);
    known.unwrap_or_else(|| {
        list.push(item);
        list.len() - 1
    }) as u32
}

impl PatchFunctions for OnCurves {
    fn sides(&self) -> &Sides {
        &self.sides
    }

    fn inner(&self) -> Option<&dyn ContactKernel> {
        Some(&*self.inner)
    }

    fn inner_mut(&mut self) -> Option<&mut dyn ContactKernel> {
        Some(&mut *self.inner)
    }

    fn row_nodes(&self) -> &[u32] {
        &self.row_nodes
    }

    fn owns(&self, p: usize, node: u32) -> bool {
        self.members[p].iter().any(|member| {
            let mut owners = self.inner.patches().nodes(member.patch).iter().filter(|&&owner| self.inner.owns(member.patch, owner));
            owners.any(|&owner| self.points.parts(owner as usize).iter().any(|&(part, _)| part == node))
        })
    }

    fn begin_step(&mut self, q_0: &[f64]) {
        self.inner.begin_step(&self.proxies(q_0));
    }

    fn start_gap(&self) -> Vec<f64> {
        self.gathered(&self.inner.start_gap())
    }

    fn bytes(&self) -> u64 {
        self.sides.patches.gradient_bytes().saturating_add(self.inner.bytes())
    }

    fn evaluate(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation) {
        self.evaluate_inner(derivative, q_1, lambda, true, out);
    }

    fn linearize(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation, tangent: Option<&mut TangentSink>) {
        self.evaluate_inner(derivative, q_1, lambda, tangent.is_some(), out);
        if let Some(tangent) = tangent {
            out.hand_tangents_over(&self.sides.patches, tangent);
        }
    }

    fn evaluate_slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        let mut scratch = self.scratch.lock().unwrap_or_else(PoisonError::into_inner);
        let Scratch { inner, lambda: inner_lambda, half, .. } = &mut *scratch;
        let [q_0, q_1, moved] = [step.q_0, step.q_1, step.moved].map(|values| self.proxies(values));
        let mut live = vec![false; self.inner.patches().len()];
        let lives = self.members.iter().zip(step.live).filter(|(_, live)| **live);
        lives.flat_map(|(members, _)| members).for_each(|member| live[member.patch] = true);
        let each = self.tangents();
        let of = |row: usize| {
            self.rows.parts(row / each).iter().map(|&(node, part)| part * lambda[each * node as usize + row % each]).sum::<f64>()
        };
        inner_lambda.clear();
        inner_lambda.extend((0..each * self.inner.rows()).map(of));
        self.inner.evaluate_slips(SlipStep { q_0: &q_0, q_1: &q_1, moved: &moved, live: &live, ..step }, inner_lambda, inner);
        self.on_nodes([self.inner.slip_patches(), self.sides.slip_patches()], each, inner, Some(inner_lambda), half, out);
        inner.drop_tangent();
    }

    fn gap(&self, q: &[f64]) -> Vec<f64> {
        self.gathered(&self.inner.gap(&self.proxies(q)))
    }

    fn slacks(&self) -> Vec<f64> {
        let weights = self.inner.weights();
        let weighted: Vec<f64> = weights.iter().zip(self.inner.slacks()).map(|(weight, slack)| weight * slack).collect();
        self.gathered(&weighted).iter().zip(&self.sides.weights).map(|(weighted, weight)| weighted / weight).collect()
    }

    fn coverage(&self, q: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.sides.weights.len()];
        self.cover(1, &self.inner.coverage(&self.proxies(q)), &mut sums);
        sums
    }
}

impl CandidateSearch for OnCurves {
    fn update_candidates(&mut self, predicted_motion: &PredictedMotion) -> bool {
        let motion = self.motion(predicted_motion);
        let changed = self.inner.update_candidates(&motion.of_points());
        if changed {
            self.list();
        }
        changed
    }

    fn margin(&self, predicted_motion: &PredictedMotion) -> f64 {
        self.inner.margin(&self.motion(predicted_motion).of_points())
    }

    fn overlooks(&self, q_0: &[f64], q_1: &[f64], tolerance: f64) -> bool {
        self.inner.overlooks(&self.proxies(q_0), &self.proxies(q_1), tolerance)
    }

    fn for_each_participant(&self, p: usize, visit: &mut dyn FnMut(u32)) {
        let mut parts = |point: u32| self.points.parts(point as usize).iter().for_each(|&(node, _)| visit(node));
        self.members[p].iter().for_each(|member| self.inner.for_each_participant(member.patch, &mut parts));
    }

    fn restore_candidates(&mut self, candidates: &Candidates, q: &[f64]) {
        self.inner.restore_candidates(candidates, &self.proxies(q));
        self.list();
    }

    fn deepest(&self, q: &[f64]) -> f64 {
        self.inner.deepest(&self.proxies(q))
    }

    fn crossing(&self, q: &[f64]) -> f64 {
        self.inner.crossing(&self.proxies(q))
    }
}

impl RigidObstacle for OnCurves {
    fn passage(&self, q_1: &[f64]) -> [f64; 2] {
        self.inner.passage(&self.proxies(q_1))
    }

    fn obstacle_force_into(&self, derivative: Derivative, q_1: &[f64], before: &[f64], lambda: &[f64], force: &mut [f64]) -> f64 {
        let d = self.sides.patches.dimension();
        let [mut pressed, mut inner_lambda, mut proxies] = [Vec::new(), Vec::new(), vec![0.0; d * self.points.len()]];
        self.rows.values_into(before, &mut pressed);
        self.rows.values_into(lambda, &mut inner_lambda);
        let work = self.inner.obstacle_force_into(derivative, &self.proxies(q_1), &pressed, &inner_lambda, &mut proxies);
        self.points.add_vectors_back(d, &proxies, force);
        work
    }
}
