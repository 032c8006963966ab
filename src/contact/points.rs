//! Bilateral constraints between points: rigid bodies, nodes carried by rigid bodies, joints, couplings.
//!
//! Each function is at most quadratic in vectors `y_k = sum_n c_kn q_n + o_k`: points of bodies, or directions fixed to bodies,
//!
//! ```text
//! Phi = sum w_ab y_a . y_b + sum g_a . y_a + c          [length]
//! ```
//!
//! so that the gradient at mid-step is a discrete gradient: `grad Phi(q_1/2) . (q_1 - q_0) = Phi(q_1) - Phi(q_0)`. Forces of a function
//! that is invariant under rigid motions of all its nodes have zero resultant and moment.

use super::kernel::{CandidateSearch, PatchFunctions, RigidObstacle};
use super::patches::Evaluation;
use super::surface::{Sides, Surface};
use super::window::PredictedMotion;
use crate::integrators::Derivative;

/// Linear combination of nodes plus a constant: a point (coefficients sum to one), a direction or a distance vector.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointVector {
    /// Model nodes with their coefficients.
    pub parts: Vec<(u32, f64)>,
    /// Constant part `[length]`.
    pub offset: [f64; 3],
}

impl PointVector {
    /// Difference of two vectors.
    pub fn minus(&self, other: &PointVector) -> PointVector {
        let mut parts = self.parts.clone();
        for &(node, factor) in &other.parts {
            match parts.iter_mut().find(|(known, _)| *known == node) {
                Some((_, sum)) => *sum -= factor,
                None => parts.push((node, -factor)),
            }
        }
        PointVector { parts, offset: std::array::from_fn(|i| self.offset[i] - other.offset[i]) }
    }

    /// Components at the node positions `q`.
    pub fn at(&self, dimension: usize, q: &[f64]) -> [f64; 3] {
        let mut sum = self.offset;
        for &(node, factor) in &self.parts {
            (0..dimension).for_each(|i| sum[i] += factor * q[dimension * node as usize + i]);
        }
        sum
    }
}

/// Constraint function: quadratic polynomial of the vectors of its group.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointFunction {
    /// Scalar products of two vectors (indices), with their coefficients `[1/length]`.
    pub products: Vec<(usize, usize, f64)>,
    /// Linear terms: index of a vector, and the vector `g_a` by which it is multiplied.
    pub linear: Vec<(usize, [f64; 3])>,
    /// Constant term `[length]`.
    pub constant: f64,
}

/// Constraint function for a given value of a prescribed coordinate, such as an angle.
pub type DrivenFunction = Box<dyn Fn(f64) -> PointFunction + Send + Sync>;

/// Prescribed coordinate of a group's function.
struct Drive {
    function: DrivenFunction,
    /// Function for the coordinate at the start of the step.
    start: PointFunction,
    /// Function for the coordinate in the middle of the step.
    middle: PointFunction,
}

/// Functions of the same vectors and nodes, which form one contact element.
struct Group {
    nodes: Vec<u32>,
    vectors: Vec<PointVector>,
    /// Functions of the group; a function with a prescribed coordinate is that at the end of the step.
    functions: Vec<PointFunction>,
    /// Prescribed coordinate, if the group has one and a single function.
    drive: Option<Drive>,
    first_row: usize,
    /// True if the ground is one of the joined bodies: the functions are not invariant under rigid motions of all nodes.
    is_grounded: bool,
}

impl Group {
    /// Functions of the group for the coordinate at the start of the step.
    fn at_start(&self) -> &[PointFunction] {
        self.drive.as_ref().map_or(&self.functions, |drive| std::slice::from_ref(&drive.start))
    }

    /// Functions of the group for the coordinate in the middle of the step.
    fn in_middle(&self) -> &[PointFunction] {
        self.drive.as_ref().map_or(&self.functions, |drive| std::slice::from_ref(&drive.middle))
    }
}

/// Bilateral constraints between points of bodies.
pub struct PointConstraints {
    sides: Sides,
    groups: Vec<Group>,
    dimension: usize,
    row_nodes: Vec<u32>,
    start: Vec<f64>,
    q_0: Vec<f64>,
}

impl PointConstraints {
    /// Empty set of constraints; `size` is the size of the joined parts `[length]`, for tolerances.
    pub fn new(dimension: usize, size: f64) -> Self {
        let surface = || if dimension == 2 { Surface::new(&[]) } else { Surface::in_space(std::iter::empty()) };
        let mut sides = Sides::of(surface(), surface(), &[]);
        sides.facet_size = size;
        PointConstraints { sides, groups: Vec::new(), dimension, row_nodes: Vec::new(), start: Vec::new(), q_0: Vec::new() }
    }

    /// Adds a group of functions of some vectors. `owner` is a node whose displacement components the functions determine, if all groups
    /// have one. `is_grounded`: the functions change with rigid motions of all nodes, because the ground is one of the joined bodies.
    pub fn add(&mut self, vectors: Vec<PointVector>, functions: Vec<PointFunction>, owner: Option<u32>, is_grounded: bool) {
        self.add_group(vectors, functions, None, owner, is_grounded);
    }

    /// Adds a function of some vectors that depends on a prescribed coordinate, initially `value`.
    pub fn add_driven(&mut self, vectors: Vec<PointVector>, function: DrivenFunction, value: f64, is_grounded: bool) {
        let now = function(value);
        let drive = Drive { function, start: now.clone(), middle: now.clone() };
        self.add_group(vectors, vec![now], Some(drive), None, is_grounded);
    }

    fn add_group(
        &mut self,
        vectors: Vec<PointVector>,
        functions: Vec<PointFunction>,
        drive: Option<Drive>,
        owner: Option<u32>,
        is_grounded: bool,
    ) {
        let mut nodes: Vec<u32> = vectors.iter().flat_map(|vector| vector.parts.iter().map(|(node, _)| *node)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let first_row = self.sides.weights.len();
        self.sides.weights.resize(first_row + functions.len(), 1.0);
        self.row_nodes.extend(owner);
        self.groups.push(Group { nodes, vectors, functions, drive, first_row, is_grounded });
    }

    /// True without constraints.
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    /// Adds `by` times the gradient of a function at vectors `y`, with respect to the nodes of the group.
    fn gradient_into(&self, group: &Group, function: &PointFunction, y: &[[f64; 3]], out: &mut [f64]) {
        let mut add = |vector: usize, along: [f64; 3], by: f64| {
            for &(node, factor) in &group.vectors[vector].parts {
                let place = group.nodes.binary_search(&node).unwrap_or(0) * self.dimension;
                (0..self.dimension).for_each(|i| out[place + i] += by * factor * along[i]);
            }
        };
        for &(a, b, by) in &function.products {
            add(a, y[b], by);
            add(b, y[a], by);
        }
        function.linear.iter().for_each(|&(a, along)| add(a, along, 1.0));
    }

    /// Adds `by` times the Hessian of a function.
    fn hessian_into(&self, group: &Group, function: &PointFunction, by: f64, out: &mut [f64]) {
        let count = group.nodes.len() * self.dimension;
        let place = |node: u32| group.nodes.binary_search(&node).unwrap_or(0) * self.dimension;
        for &(a, b, weight) in &function.products {
            for &(n, of_n) in &group.vectors[a].parts {
                for &(m, of_m) in &group.vectors[b].parts {
                    let value = by * weight * of_n * of_m;
                    for i in 0..self.dimension {
                        out[(place(n) + i) * count + place(m) + i] += value;
                        out[(place(m) + i) * count + place(n) + i] += value;
                    }
                }
            }
        }
    }

    /// Values of the functions of all groups.
    fn values(&self, q: &[f64], functions: impl Fn(&Group) -> &[PointFunction]) -> Vec<f64> {
        let mut values = Vec::with_capacity(self.sides.weights.len());
        for group in &self.groups {
            let y = self.vectors_at(group, q);
            values.extend(functions(group).iter().map(|function| value(function, &y)));
        }
        values
    }

    /// Values, gradients and tangent of a step from `q_0` to `q_1`; without a step `q_0` is empty.
    pub fn evaluate_from(&self, q_0: &[f64], derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation) {
        let patches = &self.sides.patches;
        out.prepare(patches, self.sides.weights.len());
        let placement = derivative.placement();
        for (p, group) in self.groups.iter().enumerate().take(patches.len()) {
            out.clear_patch(patches, p);
            out.live[p] = true;
            let end = self.vectors_at(group, q_1);
            let is_mean = placement.share < 1.0 && !q_0.is_empty();
            let tested = if is_mean { group.in_middle() } else { &group.functions };
            let test = if is_mean {
                let mean = |(a, b): (&[f64; 3], &[f64; 3])| std::array::from_fn(|i| 0.5 * (a[i] + b[i]));
                self.vectors_at(group, q_0).iter().zip(&end).map(mean).collect()
            } else {
                end.clone()
            };
            let count = patches.unknowns(p);
            let (gradients, tangent) = (patches.gradient_range(p), patches.tangent_range(p));
            for (m, (function, tested)) in group.functions.iter().zip(tested).enumerate() {
                let range = gradients.start + m * count..gradients.start + (m + 1) * count;
                self.gradient_into(group, function, &end, &mut out.gradient_end[range.clone()]);
                self.gradient_into(group, tested, &test, &mut out.gradient_bar[range]);
                let row = group.first_row + m;
                self.hessian_into(group, tested, placement.share * lambda[row], &mut out.tangent[tangent.clone()]);
                out.gap[row] = value(function, &end);
            }
        }
        out.coverage.fill(1.0);
    }

    fn vectors_at(&self, group: &Group, q: &[f64]) -> Vec<[f64; 3]> {
        group.vectors.iter().map(|vector| vector.at(self.dimension, q)).collect()
    }
}

/// Value of a function for the vectors `y`.
fn value(function: &PointFunction, y: &[[f64; 3]]) -> f64 {
    let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let products: f64 = function.products.iter().map(|&(a, b, by)| by * dot(&y[a], &y[b])).sum();
    products + function.linear.iter().map(|(a, along)| dot(&y[*a], along)).sum::<f64>() + function.constant
}

impl PatchFunctions for PointConstraints {
    fn sides(&self) -> &Sides {
        &self.sides
    }

    fn rows_per_node(&self) -> usize {
        if self.row_nodes.is_empty() { 1 } else { self.dimension }
    }

    fn row_nodes(&self) -> &[u32] {
        &self.row_nodes
    }

    fn begin_step(&mut self, q_0: &[f64]) {
        self.start = self.values(q_0, Group::at_start);
        self.q_0.clear();
        self.q_0.extend_from_slice(q_0);
    }

    fn start_gap(&self) -> Vec<f64> {
        if self.start.is_empty() { vec![0.0; self.sides.weights.len()] } else { self.start.clone() }
    }

    fn evaluate(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation) {
        self.evaluate_from(&self.q_0, derivative, q_1, lambda, out);
    }

    fn gap(&self, q: &[f64]) -> Vec<f64> {
        self.values(q, |group| &group.functions)
    }
}

impl CandidateSearch for PointConstraints {
    fn update_candidates(&mut self, _outlook: &PredictedMotion) -> bool {
        let is_first = self.sides.patches.is_empty() && !self.groups.is_empty();
        if is_first {
            for group in &self.groups {
                let rows: Vec<u32> = (0..group.functions.len()).map(|k| (group.first_row + k) as u32).collect();
                self.sides.patches.push(&group.nodes, &rows);
            }
        }
        is_first
    }
}

impl RigidObstacle for PointConstraints {
    fn drive(&mut self, [start, end]: [f64; 2]) {
        for group in &mut self.groups {
            let Some(drive) = &mut group.drive else { continue };
            (drive.start, drive.middle) = ((drive.function)(start), (drive.function)(0.5 * (start + end)));
            group.functions = vec![(drive.function)(end)];
        }
    }

    fn obstacle_force_into(&self, derivative: Derivative, q_1: &[f64], before: &[f64], lambda: &[f64], force: &mut [f64]) -> f64 {
        if self.groups.iter().all(|group| !group.is_grounded && group.drive.is_none()) {
            return 0.0;
        }
        let mut out = Evaluation::default();
        self.evaluate(derivative, q_1, lambda, &mut out);
        let d = self.dimension;
        let patches = &self.sides.patches;
        let mut work = 0.0;
        for (p, group) in self.groups.iter().enumerate().take(patches.len()) {
            let (first, count) = (patches.gradient_range(p).start, patches.unknowns(p));
            for row in group.first_row..group.first_row + group.functions.len() {
                let pressure = before[row] + lambda[row];
                let gradients = &out.gradient_bar[first + (row - group.first_row) * count..][..count];
                let place = |entry: usize| group.nodes[entry / d] as usize * d + entry % d;
                if group.is_grounded {
                    // Forces on grounded constraints are external: the reaction acts on the ground, which has no nodes.
                    gradients.iter().enumerate().for_each(|(entry, gradient)| force[place(entry)] += pressure * gradient);
                }
                if group.drive.is_some() && !self.q_0.is_empty() {
                    let moved = |entry: usize| q_1[place(entry)] - self.q_0[place(entry)];
                    let change: f64 = gradients.iter().enumerate().map(|(entry, gradient)| gradient * moved(entry)).sum();
                    work += pressure * (change - (out.gap[row] - self.start[row]));
                }
            }
        }
        work
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Constraints between four nodes in space: a distance, and a scalar product of two directions.
    fn joint() -> PointConstraints {
        let vector = |parts: &[(u32, f64)]| PointVector { parts: parts.to_vec(), offset: [0.0; 3] };
        let vectors = vec![vector(&[(0, 0.5), (1, 0.5), (3, -1.0)]), vector(&[(0, 1.0), (1, -1.0)]), vector(&[(2, 1.0), (3, -1.0)])];
        let functions = vec![
            PointFunction { products: vec![(0, 0, 0.5)], linear: Vec::new(), constant: -0.2 },
            PointFunction { products: vec![(1, 2, 0.7)], linear: vec![(0, [0.1, 0.0, -0.3])], constant: 0.0 },
        ];
        let mut kernel = PointConstraints::new(3, 1.0);
        kernel.add(vectors, functions, None, false);
        let q: Vec<f64> = (0..12).map(|k| (1.7 * k as f64).sin()).collect();
        kernel.update_candidates(&PredictedMotion::within(&q, 0.0));
        kernel.begin_step(&q);
        kernel
    }

    #[test]
    fn the_gradient_in_the_middle_is_discrete_and_tangents_are_derivatives() {
        let kernel = joint();
        let (q_1, lambda): (Vec<f64>, _) = ((0..12).map(|k| (1.9 * k as f64).cos()).collect(), [0.8, -1.3]);
        let evaluated = |derivative, q: &[f64]| {
            let mut out = Evaluation::default();
            kernel.evaluate(derivative, q, &lambda, &mut out);
            out
        };
        let at = evaluated(Derivative::DiscreteGradient, &q_1);
        for row in 0..2 {
            let moved = q_1.iter().zip(&kernel.q_0).map(|(a, b)| a - b);
            let work: f64 = at.gradient_bar[12 * row..12 * (row + 1)].iter().zip(moved).map(|(g, moved)| g * moved).sum();
            assert!((work - (at.gap[row] - kernel.start[row])).abs() < 1e-14);
        }
        for derivative in Derivative::ALL {
            let at = evaluated(derivative, &q_1);
            for k in 0..12 {
                let mut sides = [1e-6, -1e-6].map(|step| {
                    let mut q = q_1.clone();
                    q[k] += step;
                    evaluated(derivative, &q)
                });
                let [up, down] = &mut sides;
                for row in 0..2 {
                    let slope = (up.gap[row] - down.gap[row]) / 2e-6;
                    assert!((slope - at.gradient_end[12 * row + k]).abs() < 1e-8);
                }
                for i in 0..12 {
                    let force = |at: &Evaluation| lambda[0] * at.gradient_bar[i] + lambda[1] * at.gradient_bar[12 + i];
                    let slope = (force(up) - force(down)) / 2e-6;
                    assert!((slope - at.tangent[12 * i + k]).abs() < 1e-8);
                }
            }
        }
    }
}
