//! Arcs at the nodes of a convex curve in the plane: a node touches a rigid obstacle (`rigid.rs`) with the point of its arc nearest to the
//! obstacle, so that a deformable disk rolls on its circle instead of from node to node.
//!
//! The arc of node `A` belongs to the circle of radius `R` through `A` and its neighbors `P` (before) and `N` (after) in the reference
//! positions, and extends by the angle `phi` to the middles of both arcs between the nodes. With `J v = (-v_y, v_x)`
//!
//! ```text
//! c(phi) = x_A + R (sin phi + (1 - cos phi) J) t,    t = w_N (x_N - x_A) + w_P (x_A - x_P)
//!        = sum_k (a_k(phi) + b_k(phi) J) x_k,        sum a_k = 1,  sum b_k = 0
//! ```
//!
//! `t` is the tangent: the unit tangent of the circle in the reference positions. `c` is linear in the positions and follows rigid motions.
//! On a flattened surface the nearest point of the arc is the node itself. The gap is the least signed distance `g` on the arc,
//!
//! ```text
//! G = min g(c(phi) - u),    grad_k G = (a_k + b_k J)^T n    at the nearest point
//! ```
//!
//! Let `phi_0` and `phi_1` be the nearest points at the start and at the end of a step, and `F(phi)` the change of the distance of the
//! material point `phi`. Then `F(phi_0) >= G_1 - G_0 >= F(phi_1)`, because both gaps are least values, and there is a point between both
//! with `F(phi) = G_1 - G_0`. The discrete gradient is that of the distance of this point: energy is exact, and the force has the
//! symmetries of the obstacle like the force on a node.

use nalgebra::{Matrix2, SMatrix, Vector2};

use super::numbers::Number;
use super::obstacle_side::{Distance, ObstacleSide, StepGradient};
use super::profile::FacetCurves;
use super::rigid::{NodeCurve, Row, RowGradient};
use super::rigid_shape::PlaneOutline;
use super::surface::Surface;
use crate::math::tolerances::{PROJECTED_INCREMENT, REMAINDER};

/// Positions of the own node, the node before and the node after.
type Nodes = [Vector2<f64>; 3];

/// Least ratio of the curvature of an arc relative to an obstacle to its own curvature. Inside of a ring of nearly equal radius the nearest
/// point is undetermined, and nodes touch instead.
const LEAST_CURVATURE: f64 = 0.5;

/// Bisections and Newton iterations for a point of an arc. Newton's method needs five, bisections reach round-off.
const ITERATIONS: usize = 60;

/// Part of the circle that belongs to a node.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct NodeArc {
    /// Indices of the own node, the node before and the node after.
    pub nodes: [usize; 3],
    /// Factors `w_P` and `w_N` of the facet vectors in the tangent `[1/length]`.
    factors: [f64; 2],
    /// Radius `[length]`.
    radius: f64,
    /// Angles of the first and the last point `[rad]`.
    ends: [f64; 2],
}

/// Point of an arc with the least distance from an obstacle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest {
    /// Angle of the point on the arc `[rad]`.
    pub angle: f64,
    /// Signed distance, its gradient and its Hessian.
    pub local: Distance<2>,
    /// Gradient of the distance with respect to the positions of the nodes.
    pub gradient: Row,
    /// Derivative of the angle with respect to the positions of the nodes; zero at the ends of the arc.
    pub turn: Row,
}

/// `J v`: `v` turned to the left by a right angle.
fn left(v: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-v.y, v.x)
}

/// Arcs of the nodes of a surface that lie on convex curves, against an obstacle; `q` are the reference positions. `None` for nodes that
/// touch the obstacle themselves.
pub(super) fn node_arcs(surface: &Surface, q: &[f64], radius: Option<f64>, obstacle: &PlaneOutline) -> Vec<Option<NodeArc>> {
    let curves = FacetCurves::new(surface, q);
    let arc = |node: usize| NodeArc::new(&curves, node, radius).filter(|arc| arc.is_curved_against(obstacle));
    (0..surface.nodes().len()).map(arc).collect()
}

impl NodeArc {
    /// Arc of a node of convex curves; `radius` is that of the exact shape, if it is known.
    fn new(curves: &FacetCurves, node: usize, radius: Option<f64>) -> Option<Self> {
        let bend = curves.bend(node, radius.is_some())?;
        let [before, after] = bend.lengths;
        let on_curve = bend.is_curved.map(|is_curved| is_curved || radius.is_some());
        let radius = radius.unwrap_or_else(|| match on_curve {
            [true, true] => bend.span / (2.0 * bend.turn.sin()),
            [true, false] => before / (2.0 * bend.turn.sin()),
            _ => after / (2.0 * bend.turn.sin()),
        });
        // Half the angle that each facet subtends at the center.
        let [of_before, of_after] = [before, after].map(|length| (0.5 * length / radius).min(1.0).asin());
        let (factors, ends) = match on_curve {
            [true, true] => {
                let scale = 1.0 / (of_before.cos() / before + of_after.cos() / after);
                ([scale / (before * before), scale / (after * after)], [-of_before, of_after])
            }
            // The tangent is that of the adjacent straight facet.
            [true, false] => ([0.0, 1.0 / after], [-of_before, 0.0]),
            [false, true] => ([1.0 / before, 0.0], [0.0, of_after]),
            [false, false] => return None,
        };
        Some(NodeArc { nodes: [node, bend.neighbors[0], bend.neighbors[1]], factors, radius, ends })
    }

    /// True if the arc is curved against the obstacle, so that its nearest point is determined.
    fn is_curved_against(&self, obstacle: &PlaneOutline) -> bool {
        match obstacle {
            PlaneOutline::HalfPlane { .. } => true,
            PlaneOutline::Circle { radius, sign, .. } => *sign > 0.0 || self.radius <= (1.0 - LEAST_CURVATURE) * radius,
            // Nearest points of an arc and a polyline jump from side to side.
            PlaneOutline::Polyline { .. } => false,
        }
    }

    /// Tangent vector `t` for nodes at `z`.
    fn tangent(&self, [own, before, after]: &Nodes) -> Vector2<f64> {
        (after - own) * self.factors[1] + (own - before) * self.factors[0]
    }

    /// Point of the arc.
    pub fn point(&self, angle: f64, z: &Nodes) -> Vector2<f64> {
        let t = self.tangent(z);
        z[0] + (t * angle.sin() + left(t) * (1.0 - angle.cos())) * self.radius
    }

    /// Derivative of the point with respect to the angle.
    fn along(&self, angle: f64, z: &Nodes) -> Vector2<f64> {
        let t = self.tangent(z);
        (t * angle.cos() + left(t) * angle.sin()) * self.radius
    }

    /// Second derivative of the point with respect to the angle.
    fn bent(&self, angle: f64, z: &Nodes) -> Vector2<f64> {
        let t = self.tangent(z);
        (left(t) * angle.cos() - t * angle.sin()) * self.radius
    }

    /// Coefficients `a_k` and `b_k` of the node positions in `x + R (u + v J) t`, `x` with the factor `whole`.
    fn coefficients(&self, whole: f64, u: f64, v: f64) -> [[f64; 2]; 3] {
        let [before, after] = self.factors.map(|factor| self.radius * factor);
        [[whole + u * (before - after), v * (before - after)], [-u * before, -v * before], [u * after, v * after]]
    }

    /// Coefficients of a point of the arc.
    fn shares(&self, angle: f64) -> [[f64; 2]; 3] {
        self.coefficients(1.0, angle.sin(), 1.0 - angle.cos())
    }

    /// Coefficients of the derivative of a point with respect to the angle.
    fn shares_along(&self, angle: f64) -> [[f64; 2]; 3] {
        self.coefficients(0.0, angle.cos(), angle.sin())
    }

    /// Point of the arc that is nearest to the obstacle, for nodes at `z` relative to it.
    pub fn nearest(&self, obstacle: &PlaneOutline, z: &Nodes) -> Nearest {
        let rise = |angle: f64| {
            let local = obstacle.at(self.point(angle, z));
            (local, local.normal.dot(&self.along(angle, z)))
        };
        let ends = self.ends.map(|angle| (angle, rise(angle)));
        let [(first, (at_first, rise_first)), (last, (at_last, rise_last))] = ends;
        // Beside the center of a ring both ends are least values.
        let is_first_nearer = rise_first >= 0.0 && (rise_last > 0.0 || at_first.gap <= at_last.gap);
        if is_first_nearer || rise_last <= 0.0 {
            let (angle, local) = if is_first_nearer { (first, at_first) } else { (last, at_last) };
            return Nearest { angle, local, gradient: pull(&self.shares(angle), local.normal), turn: Row::zeros() };
        }
        let (mut low, mut high, mut angle) = (first, last, 0.5 * (first + last));
        for _ in 0..ITERATIONS {
            let (local, rise) = rise(angle);
            if rise > 0.0 {
                high = angle;
            } else {
                low = angle;
            }
            let next = angle - rise / self.curvature(&local, angle, z);
            let next = if next > low && next < high { next } else { 0.5 * (low + high) };
            let is_found = (next - angle).abs() <= f64::EPSILON;
            angle = next;
            if is_found {
                break;
            }
        }
        let local = obstacle.at(self.point(angle, z));
        let turn = -self.gradient_of_rise(&local, angle, z) / self.curvature(&local, angle, z);
        Nearest { angle, local, gradient: pull(&self.shares(angle), local.normal), turn }
    }

    /// Second derivative of the distance with respect to the angle.
    fn curvature(&self, local: &Distance<2>, angle: f64, z: &Nodes) -> f64 {
        let along = self.along(angle, z);
        along.dot(&(local.curvature * along)) + local.normal.dot(&self.bent(angle, z))
    }

    /// Gradient, with respect to the positions of the nodes, of the derivative of the distance with respect to the angle.
    fn gradient_of_rise(&self, local: &Distance<2>, angle: f64, z: &Nodes) -> Row {
        pull(&self.shares_along(angle), local.normal) + pull(&self.shares(angle), local.curvature * self.along(angle, z))
    }

    /// Coefficients `a_k` and `b_k` of the nearest point for nodes at `z` relative to the obstacle, with the derivatives of `T`.
    pub fn shares_at<T: Number>(&self, obstacle: &PlaneOutline, z: &[[T; 2]; 3]) -> [[T; 2]; 3] {
        let at = self.nearest(obstacle, &z.map(|x| Vector2::new(x[0].re(), x[1].re())));
        let mut change = T::from(0.0);
        for (k, turn) in at.turn.iter().enumerate() {
            let x = z[k / 2][k % 2];
            change += (x - x.re()) * *turn;
        }
        let (shares, along) = (self.shares(at.angle), self.shares_along(at.angle));
        std::array::from_fn(|k| [0, 1].map(|i| change * along[k][i] + shares[k][i]))
    }

    /// Position of a point with these coefficients.
    pub fn combined<T: Number>(shares: &[[T; 2]; 3], z: &[[T; 2]; 3]) -> [T; 2] {
        let mut x = [T::from(0.0); 2];
        for ([a, b], z) in shares.iter().zip(z) {
            x[0] += *a * z[0] - *b * z[1];
            x[1] += *a * z[1] + *b * z[0];
        }
        x
    }
}

/// Positions of the own node, the node before and the node after.
fn nodes_at(z: &[Vector2<f64>]) -> Nodes {
    [z[0], z[1], z[2]]
}

impl NodeCurve<2, PlaneOutline> for NodeArc {
    fn nodes(&self) -> &[usize] {
        &self.nodes
    }

    fn nearest_to(&self, obstacle: &PlaneOutline, z: &[Vector2<f64>]) -> (Distance<2>, Row) {
        let Nearest { local, gradient, .. } = self.nearest(obstacle, &nodes_at(z));
        (local, gradient)
    }

    fn plain(&self, obstacle: &PlaneOutline, z: &[Vector2<f64>], share: f64) -> RowGradient {
        let z = &nodes_at(z);
        let Nearest { angle, local, gradient, turn } = self.nearest(obstacle, z);
        let tangent = squared(&self.shares(angle), &local.curvature) + self.gradient_of_rise(&local, angle, z) * turn.transpose();
        RowGradient { bar: gradient, tangent: tangent * share }
    }

    fn between(&self, obstacle: &PlaneOutline, z_0: &[Vector2<f64>], z_1: &[Vector2<f64>], size: f64) -> RowGradient {
        let [z_0, z_1] = &[nodes_at(z_0), nodes_at(z_1)];
        let (start, end) = (self.nearest(obstacle, z_0), self.nearest(obstacle, z_1));
        let change = end.local.gap - start.local.gap;
        let at = |angle: f64| [z_0, z_1].map(|z| obstacle.at(self.point(angle, z)));
        let error = |[before, after]: &[Distance<2>; 2]| after.gap - before.gap - change;
        let mut angle = 0.5 * (start.angle + end.angle);
        let rise = |[before, after]: &[Distance<2>; 2], angle: f64| {
            after.normal.dot(&self.along(angle, z_1)) - before.normal.dot(&self.along(angle, z_0))
        };
        let reach = size.max(self.point(angle, z_1).amax());
        if error(&at(angle)).abs() > REMAINDER * reach {
            let (mut low, mut high) = (start.angle, end.angle);
            for _ in 0..ITERATIONS {
                let found = at(angle);
                let error = error(&found);
                // The error is at least zero at the start, at most zero at the end.
                if error > 0.0 {
                    low = angle;
                } else {
                    high = angle;
                }
                let next = angle - error / rise(&found, angle);
                let is_between = next > low.min(high) && next < low.max(high);
                let next = if is_between { next } else { 0.5 * (low + high) };
                let is_found = (next - angle).abs() <= f64::EPSILON;
                angle = next;
                if is_found {
                    break;
                }
            }
        }
        // Derivative of the angle with respect to the end positions; between nearly equal points their mean.
        let turn = if (end.angle - start.angle).abs() > PROJECTED_INCREMENT {
            let found = at(angle);
            (end.gradient - pull(&self.shares(angle), found[1].normal)) / rise(&found, angle)
        } else {
            end.turn * 0.5
        };
        let [x_0, x_1] = [z_0, z_1].map(|z| self.point(angle, z));
        let StepGradient { bar: normal, tangent: by_end } = obstacle.step_gradient(x_0, x_1, size);
        // The discrete gradients of planes and circles are symmetric in both points.
        let by_start = obstacle.step_gradient(x_1, x_0, size).tangent;
        let shares = self.shares(angle);
        let turned = by_start * self.along(angle, z_0) + by_end * self.along(angle, z_1);
        let by_angle = pull(&self.shares_along(angle), normal) + pull(&shares, turned);
        RowGradient { bar: pull(&shares, normal), tangent: squared(&shares, &by_end) + by_angle * turn.transpose() }
    }
}

/// `(a_k + b_k J)^T v` for each node.
pub(super) fn pull(shares: &[[f64; 2]; 3], v: Vector2<f64>) -> Row {
    Row::from_fn(|i, _| {
        let [a, b] = shares[i / 2];
        a * v[i % 2] - b * left(v)[i % 2]
    })
}

/// `C^T m C` for the coefficients `C` of a point.
fn squared(shares: &[[f64; 2]; 3], m: &Matrix2<f64>) -> SMatrix<f64, 6, 6> {
    let columns = [m.column(0).into_owned(), m.column(1).into_owned()].map(|column| pull(shares, column));
    // Column `k` of `m C` is a combination of the columns of `m`.
    SMatrix::from_fn(|i, k| {
        let [a, b] = shares[k / 2];
        if k % 2 == 0 { a * columns[0][i] + b * columns[1][i] } else { a * columns[1][i] - b * columns[0][i] }
    })
}
