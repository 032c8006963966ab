//! Contact of the curved boundary of a deformable body with a rigid obstacle in the plane, between its nodes: soft disks roll on their
//! curve, not from node to node.
//!
//! The curve over a facet is a cubic `x(xi) = sum_k w_k(xi) x_k` of its nodes and their neighbors. Its tangents at the ends are
//! combinations of three nodes each (`profile.rs`), whose coefficients belong to the reference configuration: adjacent cubics join
//! smoothly, circles are followed to the order of cubic arcs, and the curve moves and deforms with the nodes. With the obstacle's signed
//! distance `g` and translation `u`, the constraint of a facet is the distance of the nearest point of the curve over the facet and its
//! neighbors,
//!
//! ```text
//! Phi = w min_s g(x(s) - u),    dPhi/dx_k = w w_k n,    d2Phi/dx_k dx_l = w (w_k w_l K - b_k b_l/g_ss),    b_k = w_k' n + w_k K x'
//! ```
//!
//! with the normal `n` and the Hessian `K` of `g`. The discrete gradient is that at mid-step with the correction of Gonzalez (CMAME 190,
//! 2000) along the displacement, on half planes along its normal component, so that momentum along the plane is kept. Friction depends on
//! the slip of the material point that is nearest in mid-step.
//!
//! A constraint is present in a step if at its start the nearest point lies over the facet itself, and the contact is narrower than the
//! facet: where two nodes of the curve touch, the nodes' own constraints (`rigid.rs`) hold the contact.

use nalgebra::{Matrix2, Vector2};

use super::felt::Felt;
use super::kernel::{CandidateSearch, PatchFunctions, RigidObstacle};
use super::numbers::Number;
use super::patches::Evaluation;
use super::profile::FacetCurves;
use super::rigid_shape::{Obstacle, Shape};
use super::slip::{self, Carrier, SlipRows, SlipStep};
use super::surface::{Sides, Surface};
use crate::integrators::{Configuration, Derivative};
use crate::math::tolerances::{PROJECTED_INCREMENT, REMAINDER};

/// Samples per facet that bracket the nearest point.
const SAMPLES: usize = 6;

/// Iterations for the nearest point in its bracket.
const ITERATIONS: usize = 40;

/// Gap of a node in sagittas of the facet below which the node touches.
const TOUCHING: f64 = 0.1;

/// Second derivative of the distance along the curve, relative to its value on a plane in the reference configuration, below which the
/// nearest point is not differentiated: a flattened curve.
const FLATTENED: f64 = 0.05;

/// Curve over a facet and its neighbors.
#[derive(Clone, Debug)]
struct Strip {
    /// Nodes in model numbers.
    nodes: Vec<u32>,
    /// Polynomial coefficients of each node's weight, for each facet.
    spans: Vec<Vec<[f64; 4]>>,
    /// Index of the facet itself in `spans`.
    own: usize,
    /// Length of the facet times its turn `[length]`.
    bend: f64,
}

/// Nearest point of a curve to the obstacle.
#[derive(Clone, Debug)]
struct Near {
    /// Facet of the strip, and coordinate on it.
    span: usize,
    xi: f64,
    /// True unless the nearest point is an end of the strip.
    is_inside: bool,
    gap: f64,
    normal: Vector2<f64>,
    curvature: Matrix2<f64>,
    covered: bool,
}

/// Positions relative to the obstacle.
type Places = Vec<Vector2<f64>>;

impl Strip {
    fn weight<T: Number>([a, b, c, d]: [f64; 4], xi: T) -> T {
        ((xi * d + c) * xi + b) * xi + a
    }

    fn slope([_, b, c, d]: [f64; 4], xi: f64) -> f64 {
        (3.0 * d * xi + 2.0 * c) * xi + b
    }

    /// Point of the curve and its first two derivatives along a facet.
    fn point(&self, z: &Places, span: usize, xi: f64) -> [Vector2<f64>; 3] {
        let mut point = [Vector2::zeros(); 3];
        for (x, &of) in z.iter().zip(&self.spans[span]) {
            point[0] += x * Self::weight(of, xi);
            point[1] += x * Self::slope(of, xi);
            point[2] += x * (6.0 * of[3] * xi + 2.0 * of[2]);
        }
        point
    }

    /// Facet and coordinate of a place along the strip.
    fn locate(&self, s: f64) -> (usize, f64) {
        let span = (s.floor().max(0.0) as usize).min(self.spans.len() - 1);
        (span, s - span as f64)
    }

    /// Nearest point of the curve to a shape.
    fn nearest(&self, shape: &Shape, z: &Places) -> Near {
        let last = self.spans.len() as f64;
        let at = |s: f64| {
            let (span, xi) = self.locate(s);
            let [x, along, bend] = self.point(z, span, xi);
            let local = shape.at(x);
            (local, local.normal.dot(&along), local.normal.dot(&bend) + along.dot(&(local.curvature * along)))
        };
        let count = SAMPLES * self.spans.len();
        let place = |k: usize| last * k as f64 / count as f64;
        let best = (0..=count).min_by(|&a, &b| at(place(a)).0.gap.total_cmp(&at(place(b)).0.gap)).unwrap_or(0);
        let [mut from, mut to] = [place(best.saturating_sub(1)), place((best + 1).min(count))];
        let mut s = place(best);
        let is_inside = at(from).1 < 0.0 && at(to).1 > 0.0;
        if is_inside {
            for _ in 0..ITERATIONS {
                let (_, slope, bend) = at(s);
                if slope > 0.0 {
                    to = s
                } else {
                    from = s
                }
                let next = s - slope / bend;
                let next = if bend > 0.0 && next > from && next < to { next } else { 0.5 * (from + to) };
                let is_done = (next - s).abs() <= f64::EPSILON * last || slope == 0.0;
                s = next;
                if is_done {
                    break;
                }
            }
        }
        let (span, xi) = self.locate(s);
        let local = at(s).0;
        Near { span, xi, is_inside, gap: local.gap, normal: local.normal, curvature: local.curvature, covered: local.covered }
    }

    /// Gradient of the least distance with respect to the nodes.
    fn gradient(&self, near: &Near) -> Places {
        self.spans[near.span].iter().map(|&of| near.normal * Self::weight(of, near.xi)).collect()
    }

    /// Hessian of the least distance, block of the nodes `k` and `l`.
    fn hessian(&self, near: &Near, z: &Places) -> impl Fn(usize, usize) -> Matrix2<f64> {
        let [_, along, bend] = self.point(z, near.span, near.xi);
        let second = near.normal.dot(&bend) + along.dot(&(near.curvature * along));
        let inverse = if near.is_inside && second > FLATTENED * self.bend { 1.0 / second } else { 0.0 };
        let (weights, moved): (Vec<f64>, Places) = self.spans[near.span]
            .iter()
            .map(|&of| {
                let weight = Self::weight(of, near.xi);
                (weight, near.normal * Self::slope(of, near.xi) + near.curvature * along * weight)
            })
            .unzip();
        let curvature = near.curvature;
        move |k, l| curvature * (weights[k] * weights[l]) - moved[k] * moved[l].transpose() * inverse
    }
}

/// Algorithmic gradient of a step, and the blocks of its derivative.
struct OfStep {
    bar: Places,
    tangent: Vec<Matrix2<f64>>,
}

/// Contact of the curves of a surface with an obstacle; one constraint per curved facet.
#[derive(Clone, Debug)]
pub struct CurveContact {
    sides: Sides,
    strips: Vec<Strip>,
    shape: Shape,
    translations: [[f64; 3]; 3],
    /// Displacement of the obstacle `[length]` and rotation angle `[rad]` in the step.
    carried: ([f64; 2], f64),
    /// Positions at the start of the step, and the nearest points of present constraints.
    start: Vec<(Places, Option<Near>)>,
}

impl CurveContact {
    /// Contact of the curves of a surface (facets in model node numbers, the body on the left) with an obstacle; `None` without curves and
    /// for polylines.
    pub fn new(facets: &[[u32; 2]], obstacle: &Obstacle, reference: &[f64]) -> Option<Self> {
        if matches!(obstacle, Obstacle::Polyline { .. } | Obstacle::InSpace(_)) {
            return None;
        }
        let surface = Surface::new(facets);
        let curves = FacetCurves::new(&surface, reference);
        let strips: Vec<Strip> = (0..surface.count()).filter_map(|facet| strip(&surface, &curves, facet)).collect();
        let mut sides = Sides::new(facets, &[], reference);
        sides.weights = vec![sides.facet_size; strips.len()];
        for (row, strip) in (0u32..).zip(&strips) {
            sides.patches.push(&strip.nodes, &[row]);
        }
        let start = vec![(Vec::new(), None); strips.len()];
        let shape = Shape::new(obstacle);
        (!strips.is_empty()).then_some(CurveContact {
            sides,
            strips,
            shape,
            translations: [[0.0; 3]; 3],
            carried: Default::default(),
            start,
        })
    }

    /// Positions of a strip's nodes relative to the obstacle at the start (0), in the middle (1) or at the end (2) of the step.
    fn relative(&self, row: usize, q: &[f64], time: usize) -> Places {
        let [x, y, _] = self.translations[time];
        let at = |&node: &u32| Vector2::new(q[2 * node as usize] - x, q[2 * node as usize + 1] - y);
        self.strips[row].nodes.iter().map(at).collect()
    }

    /// Present constraints with their nearest points at the start of the step.
    fn present(&self) -> impl Iterator<Item = (usize, &Near)> {
        self.start.iter().enumerate().filter_map(|(row, (_, near))| near.as_ref().map(|near| (row, near)))
    }

    /// Algorithmic gradient of a present constraint for a step that ends at `q_1`, without weight.
    fn of_step(&self, row: usize, start: &Near, derivative: Derivative, q_1: &[f64]) -> OfStep {
        let (strip, z_0, z_1) = (&self.strips[row], &self.start[row].0, self.relative(row, q_1, 2));
        let plain = |z: &Places, share: f64| {
            let near = strip.nearest(&self.shape, z);
            let hessian = strip.hessian(&near, z);
            let count = z.len();
            let tangent = (0..count * count).map(|block| hessian(block / count, block % count) * share).collect();
            OfStep { bar: strip.gradient(&near), tangent }
        };
        let middle: Places = z_0.iter().zip(&z_1).map(|(a, b)| 0.5 * (a + b)).collect();
        match derivative {
            Derivative::Gradient(Configuration::End) => plain(&z_1, Configuration::End.share()),
            Derivative::Gradient(at @ Configuration::Middle) => {
                let z: Places = middle.iter().map(|x| x + self.shift_to_middle()).collect();
                plain(&z, at.share())
            }
            Derivative::DiscreteGradient => {
                let mut step = plain(&middle, 0.5);
                let end = strip.nearest(&self.shape, &z_1);
                let direction = |x: Vector2<f64>| match &self.shape {
                    Shape::HalfPlane { normal, .. } => Vector2::from(*normal) * Vector2::from(*normal).dot(&x),
                    _ => x,
                };
                let change: Places = z_1.iter().zip(z_0).map(|(b, a)| direction(b - a)).collect();
                let dot = |a: &Places| a.iter().zip(&change).map(|(a, b)| a.dot(b)).sum::<f64>();
                let square = dot(&change);
                let remainder = end.gap - start.gap - dot(&step.bar);
                let size = self.sides.facet_size;
                let is_doubtful = square <= (PROJECTED_INCREMENT * size).powi(2);
                if square > 0.0 && !(is_doubtful && remainder.abs() <= REMAINDER * size) {
                    let (e, count) = (remainder / square, z_1.len());
                    let at_end = strip.gradient(&end);
                    // Derivative of the remainder: that of the end, less the gradient at mid-step and half of its change.
                    let turned = |l: usize| (0..count).map(|k| step.tangent[k * count + l].transpose() * change[k]).sum::<Vector2<f64>>();
                    let slope: Places =
                        (0..count).map(|l| direction(at_end[l] - step.bar[l]) - turned(l) - change[l] * (2.0 * e)).collect();
                    for k in 0..count {
                        for l in 0..count {
                            step.tangent[k * count + l] += change[k] * slope[l].transpose() / square;
                        }
                        let along = Matrix2::from_columns(&[direction(Vector2::x()), direction(Vector2::y())]);
                        step.tangent[k * count + k] += along * e;
                        step.bar[k] += change[k] * e;
                    }
                }
                step
            }
        }
    }

    /// Difference between the obstacle's mean translation of a step and that in its middle.
    fn shift_to_middle(&self) -> Vector2<f64> {
        let [start, middle, end] = self.translations;
        Vector2::from_fn(|i, _| 0.5 * (start[i] + end[i]) - middle[i])
    }
}

/// Strip of a curved facet; `None` for straight facets.
fn strip(surface: &Surface, curves: &FacetCurves, facet: usize) -> Option<Strip> {
    let bend = curves.bend(facet)?;
    let [before, after] = surface.neighbors(facet).map(|other| other.filter(|&other| curves.bend(other as usize).is_some()));
    let facets: Vec<usize> = before.into_iter().chain([facet as u32]).chain(after).map(|facet| facet as usize).collect();
    let cubics: Vec<Vec<(u32, [f64; 4])>> = facets.iter().map(|&facet| cubic(surface, curves, facet)).collect::<Option<_>>()?;
    let mut nodes: Vec<u32> = cubics.iter().flatten().map(|(node, _)| *node).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let span = |cubic: &Vec<(u32, [f64; 4])>| {
        let mut span = vec![[0.0; 4]; nodes.len()];
        for (node, coefficients) in cubic {
            let place = nodes.partition_point(|other| other < node);
            (0..4).for_each(|k| span[place][k] += coefficients[k]);
        }
        span
    };
    let spans = cubics.iter().map(span).collect();
    Some(Strip { nodes, spans, own: usize::from(before.is_some()), bend })
}

/// Cubic over a facet: nodes with polynomial coefficients of their weights.
fn cubic(surface: &Surface, curves: &FacetCurves, facet: usize) -> Option<Vec<(u32, [f64; 4])>> {
    let [a, b] = surface.facets()[facet];
    let [rise, fall] = curves.tangents(facet)?;
    let ends = [(a, [1.0, 0.0, -3.0, 2.0]), (b, [0.0, 0.0, 3.0, -2.0])];
    let tangents = [(rise, [0.0, 1.0, -2.0, 1.0]), (fall, [0.0, 0.0, -1.0, 1.0])];
    let of = |(combination, hermite): (Vec<(u32, f64)>, [f64; 4])| {
        combination.into_iter().map(move |(node, share)| (node, hermite.map(|h| h * share)))
    };
    Some(ends.into_iter().chain(tangents.into_iter().flat_map(of)).collect())
}

impl PatchFunctions for CurveContact {
    fn sides(&self) -> &Sides {
        &self.sides
    }

    fn row_nodes(&self) -> &[u32] {
        // Constraints belong to facets.
        &[]
    }

    fn shown_at(&self, row: usize) -> Option<u32> {
        let strip = &self.strips[row];
        let Some(near) = &self.start[row].1 else { return strip.nodes.first().copied() };
        let weight = |k: usize| Strip::weight(strip.spans[near.span][k], near.xi);
        (0..strip.nodes.len()).max_by(|&a, &b| weight(a).total_cmp(&weight(b))).map(|k| strip.nodes[k])
    }

    fn carriers(&self, row: usize) -> &[u32] {
        &self.strips[row].nodes
    }

    fn begin_step(&mut self, q_0: &[f64]) {
        let begun = |row: usize| {
            let (strip, z) = (&self.strips[row], self.relative(row, q_0, 0));
            let near = strip.nearest(&self.shape, &z);
            let height = TOUCHING * strip.bend / 8.0;
            let touching = z.iter().filter(|x| self.shape.at(**x).gap < height).count();
            let is_present = near.is_inside && near.covered && near.span == strip.own && touching < 2;
            (z, is_present.then_some(near))
        };
        self.start = (0..self.strips.len()).map(begun).collect();
    }

    fn start_gap(&self) -> Vec<f64> {
        let mut gaps = vec![0.0; self.strips.len()];
        self.present().for_each(|(row, near)| gaps[row] = self.sides.weights[row] * near.gap);
        gaps
    }

    fn evaluate(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation) {
        let patches = &self.sides.patches;
        out.prepare(patches, self.strips.len());
        (0..patches.len()).for_each(|p| out.clear_patch(patches, p));
        for (row, start) in self.present() {
            let (weight, strip) = (self.sides.weights[row], &self.strips[row]);
            let end = strip.nearest(&self.shape, &self.relative(row, q_1, 2));
            let at_end = strip.gradient(&end);
            let step = self.of_step(row, start, derivative, q_1);
            out.live[row] = true;
            (out.gap[row], out.coverage[row]) = (weight * end.gap, f64::from(u8::from(end.covered)));
            let (first, block, count) = (patches.gradient_range(row).start, patches.tangent_range(row).start, strip.nodes.len());
            for k in 0..count {
                for i in 0..2 {
                    out.gradient_end[first + 2 * k + i] = weight * at_end[k][i];
                    out.gradient_bar[first + 2 * k + i] = weight * step.bar[k][i];
                    for l in 0..count {
                        for j in 0..2 {
                            out.tangent[block + (2 * k + i) * 2 * count + 2 * l + j] =
                                lambda[row] * weight * step.tangent[k * count + l][(i, j)];
                        }
                    }
                }
            }
        }
    }

    fn evaluate_slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        slip::evaluate(self, &self.sides.patches, step, lambda, out);
    }

    fn gap(&self, q: &[f64]) -> Vec<f64> {
        let mut gaps = vec![0.0; self.strips.len()];
        for (row, _) in self.present() {
            gaps[row] = self.sides.weights[row] * self.strips[row].nearest(&self.shape, &self.relative(row, q, 2)).gap;
        }
        gaps
    }

    fn coverage(&self, _q: &[f64]) -> Vec<f64> {
        let mut coverage = vec![0.0; self.strips.len()];
        self.present().for_each(|(row, _)| coverage[row] = 1.0);
        coverage
    }
}

/// Slip of the nearest material point relative to the obstacle.
impl SlipRows for CurveContact {
    fn places(&self, p: usize, _z: &[f64], places: &mut Vec<usize>) -> bool {
        places.extend(0..self.strips[p].nodes.len());
        self.start[p].1.is_some()
    }

    fn rows<T: Number>(&self, p: usize, z: &[T], rows: &mut [T], covered: &mut [f64]) -> bool {
        let (strip, [x, y, _]) = (&self.strips[p], self.translations[1]);
        let z: Vec<[T; 2]> = z.as_chunks::<2>().0.iter().map(|[a, b]| [*a - x, *b - y]).collect();
        let values: Places = z.iter().map(|[a, b]| Vector2::new(a.re(), b.re())).collect();
        let near = strip.nearest(&self.shape, &values);
        let of = &strip.spans[near.span];
        let [_, along, bend] = strip.point(&values, near.span, near.xi);
        let second = near.normal.dot(&bend) + along.dot(&(near.curvature * along));
        let normal_at = |x: [T; 2]| -> [T; 2] {
            let Shape::Circle { center, sign, .. } = &self.shape else { return [near.normal.x, near.normal.y].map(T::from) };
            let r: [T; 2] = std::array::from_fn(|i| x[i] - center[i]);
            let inverse = (r[0] * r[0] + r[1] * r[1]).sqrt().recip() * *sign;
            r.map(|r| r * inverse)
        };
        let combined = |weights: &dyn Fn([f64; 4]) -> T| -> [T; 2] {
            let add = |sum: [T; 2], (x, &of): (&[T; 2], &[f64; 4])| std::array::from_fn(|i| sum[i] + x[i] * weights(of));
            z.iter().zip(of).fold([T::from(0.0); 2], add)
        };
        let mut xi = T::from(near.xi);
        if near.is_inside && second > FLATTENED * strip.bend {
            // One Newton iteration from the nearest point gives its derivative.
            let normal = normal_at(combined(&|of| Strip::weight(of, xi)));
            let slope = combined(&|of| T::from(Strip::slope(of, near.xi)));
            xi = xi - (normal[0] * slope[0] + normal[1] * slope[1]) * (1.0 / second);
        }
        let normal = normal_at(combined(&|of| Strip::weight(of, xi)));
        for (k, &of) in of.iter().enumerate() {
            let weight = Strip::weight(of, xi) * self.sides.weights[p];
            (rows[2 * k], rows[2 * k + 1]) = (normal[1] * weight, -(normal[0] * weight));
        }
        covered[0] = 1.0;
        true
    }

    fn is_relative(&self, _p: usize) -> bool {
        false
    }

    fn other_side(&self) -> Carrier {
        let [x, y, _] = self.translations[1];
        self.shape.carrier(self.carried, [x, y])
    }
}

impl CandidateSearch for CurveContact {
    fn deepest(&self, q: &[f64]) -> f64 {
        let depth = |(row, _): (usize, &Near)| -self.strips[row].nearest(&self.shape, &self.relative(row, q, 2)).gap;
        self.present().map(depth).fold(0.0, f64::max)
    }
}

impl RigidObstacle for CurveContact {
    fn move_obstacle(&mut self, translations: &[[f64; 3]; 3]) {
        self.translations = *translations;
    }

    fn carry(&mut self, [x, y, _]: [f64; 3], angle: f64) {
        self.carried = ([x, y], angle);
    }

    fn obstacle_translation(&self) -> [f64; 3] {
        self.translations[2]
    }

    fn obstacle_force_into(&self, derivative: Derivative, q_1: &[f64], before: &[f64], lambda: &[f64], force: &mut [f64]) -> f64 {
        let way = Vector2::from_fn(|i, _| self.translations[2][i] - self.translations[0][i]);
        let mut work = 0.0;
        for (row, start) in self.present().filter(|&(row, _)| before[row] != 0.0 || lambda[row] != 0.0) {
            let (strip, weight) = (&self.strips[row], self.sides.weights[row]);
            let bar = self.of_step(row, start, derivative, q_1).bar;
            for ((&node, of_step), at_start) in strip.nodes.iter().zip(bar).zip(strip.gradient(start)) {
                let f = (of_step * lambda[row] + at_start * before[row]) * weight;
                (0..2).for_each(|i| force[2 * node as usize + i] += f[i]);
                work += f.dot(&way);
            }
        }
        work
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::super::fixtures::{dense_rows_of, difference, product, tangent_along};
    use super::*;

    const COUNT: u32 = 20;

    /// Circle of radius 1/2 about (0.2, -0.1).
    fn disk() -> (Vec<[u32; 2]>, Vec<f64>) {
        let at = |k: u32| (f64::from(k) * std::f64::consts::TAU / f64::from(COUNT)).sin_cos();
        let q = (0..COUNT).flat_map(|k| [0.5 * at(k).1 + 0.2, 0.5 * at(k).0 - 0.1]).collect();
        ((0..COUNT).map(|k| [k, (k + 1) % COUNT]).collect(), q)
    }

    /// Closed form: the distance of a circle from a line, whatever its angle.
    #[test]
    fn circles_are_followed() {
        let (facets, q) = disk();
        for k in 0..50 {
            let (sin, cos) = (0.02 + 0.013 * f64::from(k)).sin_cos();
            let plane = Obstacle::HalfPlane { point: [0.2 - 0.6 * cos, -0.1 - 0.6 * sin], normal: [cos, sin] };
            let mut kernel = CurveContact::new(&facets, &plane, &q).expect("a circle");
            kernel.begin_step(&q);
            let gaps: Vec<f64> = kernel.present().map(|(_, near)| near.gap).collect();
            assert!(gaps.len() == 1 && (gaps[0] - 0.1).abs() < 1e-7, "{k}: {gaps:?}");
        }
        let corners = Obstacle::Polyline { points: vec![[2.0, -0.6], [-0.2, -0.7]] };
        assert!(CurveContact::new(&facets, &corners, &q).is_none() && CurveContact::new(&facets[..3], &corners, &q).is_none());
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 100, rng_seed: RngSeed::Fixed(2007), failure_persistence: None, ..Default::default() })]

        /// The forces do the work of the multipliers on the gaps plus that of the obstacle's motion; gradients and tangents of gaps and
        /// slips are derivatives along a random direction.
        #[test]
        fn curves_keep_the_contract(
            motion in prop::collection::vec(-0.004..0.004f64, 2 * COUNT as usize),
            direction in prop::collection::vec(-1.0..1.0f64, 2 * COUNT as usize),
            shift in prop::array::uniform2(-0.02..0.02f64),
        ) {
            let (facets, q_0) = disk();
            let obstacles = [
                Obstacle::HalfPlane { point: [0.0, -0.62], normal: [0.1, 1.0] },
                Obstacle::Disk { center: [0.1, -1.8], radius: 1.2 },
                Obstacle::Ring { center: [0.3, 0.4], radius: 1.0 },
            ];
            for obstacle in obstacles {
                let mut kernel = CurveContact::new(&facets, &obstacle, &q_0).expect("a circle");
                let to = [shift[0], shift[1], 0.0];
                kernel.move_obstacle(&[[0.0; 3], to.map(|x| 0.5 * x), to]);
                kernel.begin_step(&q_0);
                let lambda: Vec<f64> = (0..kernel.rows()).map(|row| 0.5 + 0.1 * row as f64).collect();
                let q_1: Vec<f64> = q_0.iter().zip(&motion).map(|(q, u)| q + u).collect();
                let evaluated = |derivative, q: &[f64]| {
                    let mut out = Evaluation::default();
                    kernel.evaluate(derivative, q, &lambda, &mut out);
                    out
                };
                let out = evaluated(Derivative::DiscreteGradient, &q_1);
                prop_assert!(out.live.contains(&true), "{obstacle:?}");
                let (mut force, none) = (vec![0.0; q_0.len()], vec![0.0; lambda.len()]);
                let by_motion = kernel.obstacle_force_into(Derivative::DiscreteGradient, &q_1, &none, &lambda, &mut force);
                let by_gaps = product(&lambda, &difference(&out.gap, &kernel.start_gap()));
                let work = product(&force, &difference(&q_1, &q_0));
                prop_assert!((work - by_gaps - by_motion).abs() < 1e-13, "{obstacle:?}: {work} {by_gaps} {by_motion}");
                let along = |width: f64| -> Vec<f64> { q_1.iter().zip(&direction).map(|(q, u)| q + width * u).collect() };
                let agrees = |name: &str, exact: Vec<f64>, of: &dyn Fn(&[f64]) -> Vec<f64>| -> Result<(), TestCaseError> {
                    let slope = |width: f64| difference(&of(&along(width)), &of(&along(-width))).into_iter().map(move |x| 0.5 * x / width);
                    for ((exact, fine), coarse) in exact.iter().zip(slope(1e-6)).zip(slope(2e-6)) {
                        // Second derivatives of cubics jump at nodes.
                        prop_assert!((fine - coarse).abs() > 1e-5 || (exact - fine).abs() < 1e-4, "{obstacle:?} {name}: {exact} {fine}");
                    }
                    Ok(())
                };
                let patches = kernel.patches();
                let rows = |gradients: &[f64]| dense_rows_of(patches, lambda.len(), gradients, q_0.len());
                let gaps = rows(&out.gradient_end).iter().map(|row| product(row, &direction)).collect();
                agrees("gap", gaps, &|q| evaluated(Derivative::DiscreteGradient, q).gap)?;
                for derivative in Derivative::ALL {
                    let forces = |q: &[f64]| -> Vec<f64> {
                        let rows = rows(&evaluated(derivative, q).gradient_bar);
                        (0..q.len()).map(|k| rows.iter().zip(&lambda).map(|(row, lambda)| lambda * row[k]).sum()).collect()
                    };
                    agrees("force", tangent_along(patches, &evaluated(derivative, &q_1).tangent, &direction), &forces)?;
                }
                let slips = |q: &[f64]| {
                    let (moved, mut slips) = (difference(q, &q_0), Evaluation::default());
                    let step = SlipStep { q_0: &q_0, q_1: q, moved: &moved, test: Configuration::Middle, live: &out.live };
                    kernel.evaluate_slips(step, &lambda, &mut slips);
                    slips.with_room(kernel.slip_patches())
                };
                let exact = rows(&slips(&q_1).gradient_end).iter().map(|row| product(row, &direction)).collect();
                agrees("slip", exact, &|q| slips(q).gap)?;
            }
        }
    }
}
