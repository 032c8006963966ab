//! Shapes of rigid obstacles in the plane: signed distance, normal, curvature and discrete gradient at points in the obstacle's frame.

use nalgebra::{Matrix2, Vector2};
use rstar::primitives::{GeomWithData, Line};
use rstar::{AABB, RTree};

use super::chain::Chain;
use super::edge_plane::AtEdge;
use super::obstacle_side::{Local, ObstacleSide};
use super::slip::Carrier;
use super::space::ObstacleInSpace;
use crate::math::tolerances::{PASSING, PROJECTED_INCREMENT, REMAINDER};

/// Largest number of polyline sides that a round part touches simultaneously.
const SIDES: usize = 2;

/// Largest number of samples on a node's path at which its distance is evaluated.
const LOOKS: f64 = 64.0;

/// Outline of a rigid obstacle at its undisplaced position.
#[derive(Clone, Debug, PartialEq)]
pub enum Obstacle {
    /// Points `x` with `normal.(x - point) <= 0`.
    HalfPlane {
        /// Point of the border `[length]`.
        point: [f64; 2],
        /// Outward normal of any nonzero length.
        normal: [f64; 2],
    },
    /// Disk; bodies are outside.
    Disk {
        /// Center `[length]`.
        center: [f64; 2],
        /// Radius `[length]`.
        radius: f64,
    },
    /// Complement of a disk; bodies are inside.
    Ring {
        /// Center `[length]`.
        center: [f64; 2],
        /// Inner radius `[length]`.
        radius: f64,
    },
    /// Straight segments through the points, the obstacle on the left; closed if the last point equals the first.
    Polyline {
        /// Points in order, at least two `[length]`.
        points: Vec<[f64; 2]>,
    },
    /// Obstacle in space, for bodies in space.
    InSpace(ObstacleInSpace),
}

/// Signed distance, its gradient, and true if the point is opposite the obstacle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Distance {
    pub(super) gap: f64,
    pub(super) normal: [f64; 2],
    pub(super) covered: bool,
}

/// Discrete gradient, and its derivative with respect to the end point.
#[derive(Clone, Copy, Debug)]
pub(super) struct StepGradient {
    pub(super) bar: [f64; 2],
    pub(super) tangent: [[f64; 2]; 2],
}

/// Obstacle prepared for evaluation.
#[derive(Clone, Debug)]
pub(super) enum PlaneOutline {
    HalfPlane {
        point: [f64; 2],
        normal: [f64; 2],
    },
    /// Circle; `sign` is +1 for bodies outside, -1 inside.
    Circle {
        center: [f64; 2],
        radius: f64,
        sign: f64,
    },
    Polyline {
        tree: RTree<GeomWithData<Line<[f64; 2]>, usize>>,
        /// For each segment: the chain of the segment and its neighbors, and the coordinates of the chain's nodes after a placeholder for
        /// the point.
        corners: Vec<(Chain, Vec<f64>)>,
    },
}

impl PlaneOutline {
    pub(super) fn new(obstacle: &Obstacle) -> Self {
        match obstacle {
            Obstacle::HalfPlane { point, normal } => {
                let length = normal[0].hypot(normal[1]);
                PlaneOutline::HalfPlane { point: *point, normal: normal.map(|n| n / length) }
            }
            Obstacle::Disk { center, radius } => PlaneOutline::Circle { center: *center, radius: *radius, sign: 1.0 },
            Obstacle::Ring { center, radius } => PlaneOutline::Circle { center: *center, radius: *radius, sign: -1.0 },
            // Models with obstacles in space and plane bodies are refused before, so that this shape is never used.
            Obstacle::InSpace(_) => PlaneOutline::Polyline { tree: RTree::new(), corners: Vec::new() },
            Obstacle::Polyline { points } => {
                let count = points.len().saturating_sub(1);
                let closed = count > 2 && points[0] == points[count];
                let lines = (0..count).map(|k| GeomWithData::new(Line::new(points[k], points[k + 1]), k));
                let neighborhood = |k: usize| {
                    let before = if k > 0 { Some(points[k - 1]) } else { closed.then(|| points[count - 1]) };
                    let after = if k + 1 < count { Some(points[k + 2]) } else { closed.then(|| points[1]) };
                    let chain: Vec<[f64; 2]> = before.into_iter().chain([points[k], points[k + 1]]).chain(after).collect();
                    let facets = (1..chain.len() as u32).map(|i| [i, i + 1]).collect();
                    (Chain::new(facets), [[0.0; 2]].iter().chain(&chain).flatten().copied().collect())
                };
                PlaneOutline::Polyline { tree: RTree::bulk_load(lines.collect()), corners: (0..count).map(neighborhood).collect() }
            }
        }
    }

    /// Signed distance of a point in the obstacle's frame; `None` where the function vanishes identically.
    pub(super) fn distance(&self, x: [f64; 2]) -> Option<Distance> {
        match self {
            PlaneOutline::HalfPlane { point, normal } => {
                let gap = normal[0] * (x[0] - point[0]) + normal[1] * (x[1] - point[1]);
                Some(Distance { gap, normal: *normal, covered: true })
            }
            PlaneOutline::Circle { center, radius, sign } => {
                let r = [x[0] - center[0], x[1] - center[1]];
                let length = r[0].hypot(r[1]);
                let normal = if length > 0.0 { r.map(|r| sign * r / length) } else { [0.0; 2] };
                Some(Distance { gap: sign * (length - radius), normal, covered: true })
            }
            PlaneOutline::Polyline { tree, corners } => {
                let (chain, points) = &corners[tree.nearest_neighbor(x)?.data];
                let mut z = [0.0; 10];
                z[..points.len()].copy_from_slice(points);
                z[..2].copy_from_slice(&x);
                let z = &z[..points.len()];
                let measure = chain.measure(z, &[true; 3])?;
                let mut gradient = [0.0; 10];
                chain.add_gradient(&measure, z, 1.0, &mut gradient[..z.len()]);
                Some(Distance { gap: measure.gap, normal: [gradient[0], gradient[1]], covered: measure.covered })
            }
        }
    }

    /// Sides of a polyline at a convex corner within `near` of a point.
    pub(super) fn at_corner(&self, x: [f64; 2], near: f64) -> Option<AtEdge<2>> {
        let PlaneOutline::Polyline { tree, corners } = self else { return None };
        let (chain, points) = &corners[tree.nearest_neighbor(x)?.data];
        let z: Vec<f64> = x.iter().chain(&points[2..]).copied().collect();
        chain.at_corner(&chain.measure(&z, &[true; 3])?, &z, near)
    }

    /// Rigid motion of the obstacle's surface in a step, for friction: a displacement and, for a circle, a rotation about its center.
    /// `middle` is the obstacle's translation in mid-step `[length]`.
    pub(super) fn carrier(&self, (shift, angle): ([f64; 2], f64), middle: [f64; 2]) -> Carrier {
        let PlaneOutline::Circle { center, .. } = self else { return Carrier { shift, ..Carrier::default() } };
        Carrier { shift, turn: 2.0 * (0.5 * angle).tan(), center: std::array::from_fn(|i| center[i] + middle[i]) }
    }

    /// Sides of a polyline within `reach` of a point, at most two, as half planes in the order of the points. If the nearest point is a
    /// convex corner, a circle of zero radius represents it. For points behind the polyline or beyond its ends, the polyline itself.
    fn nearest_sides(&self, x: [f64; 2], reach: f64) -> Vec<PlaneOutline> {
        let PlaneOutline::Polyline { tree, .. } = self else { return vec![self.clone()] };
        let (Some(nearest), Some(distance)) = (tree.nearest_neighbor(x), self.distance(x)) else { return Vec::new() };
        if distance.gap <= 0.0 || !distance.covered {
            return vec![self.clone()];
        }
        let reach = reach.max(distance.gap * (1.0 + PROJECTED_INCREMENT));
        let mut sides: Vec<(f64, usize, PlaneOutline)> = Vec::new();
        for side in tree.locate_within_distance(x, reach * reach) {
            let Line { from, to } = *side.geom();
            let (along, arm) = ([to[0] - from[0], to[1] - from[1]], [x[0] - from[0], x[1] - from[1]]);
            let square = along[0] * along[0] + along[1] * along[1];
            let share = (arm[0] * along[0] + arm[1] * along[1]) / square;
            let gap = (arm[0] * along[1] - arm[1] * along[0]) / square.sqrt();
            if (0.0..=1.0).contains(&share) && gap > 0.0 {
                let normal = [along[1] / square.sqrt(), -along[0] / square.sqrt()];
                sides.push((gap, side.data, PlaneOutline::HalfPlane { point: from, normal }));
            } else if side.data == nearest.data {
                let center = if share < 0.0 { from } else { to };
                sides.push((0.0, side.data, PlaneOutline::Circle { center, radius: 0.0, sign: 1.0 }));
            }
        }
        sides.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        sides.truncate(SIDES);
        sides.sort_by_key(|side| side.1);
        sides.into_iter().map(|(.., shape)| shape).collect()
    }

    /// Hessian of the signed distance at a point.
    pub(super) fn curvature(&self, x: [f64; 2]) -> [[f64; 2]; 2] {
        match self {
            PlaneOutline::Circle { center, sign, .. } => {
                let r = [x[0] - center[0], x[1] - center[1]];
                let length = r[0].hypot(r[1]);
                if length > 0.0 {
                    let n = r.map(|r| r / length);
                    return [[n[1] * n[1], -n[0] * n[1]], [-n[0] * n[1], n[0] * n[0]]].map(|row| row.map(|h| sign * h / length));
                }
                [[0.0; 2]; 2]
            }
            _ => [[0.0; 2]; 2],
        }
    }

    /// Range of the signed distance on the straight path between two points, with distances above `near` replaced by `near`.
    pub(super) fn direction_change(&self, x_0: [f64; 2], x_1: [f64; 2], near: f64) -> f64 {
        let d = [x_1[0] - x_0[0], x_1[1] - x_0[1]];
        let length = d[0].hypot(d[1]);
        // The distance changes by at most the path length, so that short paths need no samples.
        if length <= near * PASSING {
            return 0.0;
        }
        let count = (4.0 * length / near).ceil().min(LOOKS);
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for k in 0..=count as usize {
            let s = k as f64 / count;
            let Some(distance) = self.distance([x_0[0] + s * d[0], x_0[1] + s * d[1]]) else { continue };
            let gap = distance.gap.min(near);
            range = [range[0].min(gap), range[1].max(gap)];
        }
        (range[1] - range[0]).max(0.0)
    }

    /// True if the straight path between two outer points crosses the obstacle to its other side.
    pub(super) fn is_crossed(&self, x_0: [f64; 2], x_1: [f64; 2]) -> bool {
        let ends = [x_0, x_1].map(|x| self.distance(x));
        let [Some(start), Some(end)] = ends else { return false };
        let is_other_side = start.normal[0] * end.normal[0] + start.normal[1] * end.normal[1] < 0.0;
        if !is_other_side || start.gap < 0.0 || end.gap < 0.0 {
            return false;
        }
        let d = [x_1[0] - x_0[0], x_1[1] - x_0[1]];
        match self {
            PlaneOutline::HalfPlane { .. } => false,
            PlaneOutline::Circle { center, radius, .. } => {
                // The line crosses the circle if the center is nearer to it than the radius.
                let r = [center[0] - x_0[0], center[1] - x_0[1]];
                (d[0] * r[1] - d[1] * r[0]).abs() < radius * d[0].hypot(d[1])
            }
            PlaneOutline::Polyline { tree, .. } => {
                let area = AABB::from_corners([x_0[0].min(x_1[0]), x_0[1].min(x_1[1])], [x_0[0].max(x_1[0]), x_0[1].max(x_1[1])]);
                let side = |from: [f64; 2], along: [f64; 2], x: [f64; 2]| along[0] * (x[1] - from[1]) - along[1] * (x[0] - from[0]);
                tree.locate_in_envelope_intersecting(area).any(|facet| {
                    let Line { from, to } = *facet.geom();
                    let along = [to[0] - from[0], to[1] - from[1]];
                    side(x_0, d, from) * side(x_0, d, to) < 0.0 && side(from, along, x_0) * side(from, along, x_1) < 0.0
                })
            }
        }
    }

    /// Discrete gradient between two points in the obstacle's frame, not corrected for increments below `PROJECTED_INCREMENT * size`.
    pub(super) fn step_gradient(&self, x_0: [f64; 2], x_1: [f64; 2], size: f64) -> StepGradient {
        match self {
            PlaneOutline::HalfPlane { normal, .. } => StepGradient { bar: *normal, tangent: [[0.0; 2]; 2] },
            PlaneOutline::Circle { center, sign, .. } => {
                let (r_0, r_1) = ([x_0[0] - center[0], x_0[1] - center[1]], [x_1[0] - center[0], x_1[1] - center[1]]);
                let end = r_1[0].hypot(r_1[1]);
                let lengths = r_0[0].hypot(r_0[1]) + end;
                if end == 0.0 {
                    return StepGradient { bar: [0.0; 2], tangent: [[0.0; 2]; 2] };
                }
                let bar: [f64; 2] = std::array::from_fn(|i| sign * (r_0[i] + r_1[i]) / lengths);
                let tangent =
                    std::array::from_fn(|i| std::array::from_fn(|k| (if i == k { *sign } else { 0.0 } - bar[i] * r_1[k] / end) / lengths));
                StepGradient { bar, tangent }
            }
            PlaneOutline::Polyline { .. } => {
                let at = |x: [f64; 2]| self.distance(x).unwrap_or(Distance { gap: 0.0, normal: [0.0; 2], covered: false });
                let (start, end) = (at(x_0), at(x_1));
                let middle = at([0.5 * (x_0[0] + x_1[0]), 0.5 * (x_0[1] + x_1[1])]);
                let d = [x_1[0] - x_0[0], x_1[1] - x_0[1]];
                let square = d[0] * d[0] + d[1] * d[1];
                let mut gradient = StepGradient { bar: middle.normal, tangent: [[0.0; 2]; 2] };
                let remainder = end.gap - start.gap - middle.normal[0] * d[0] - middle.normal[1] * d[1];
                // For small increments the remainder of the discrete gradient is round-off, unless a corner lies between both points.
                let is_doubtful = square <= (PROJECTED_INCREMENT * size).powi(2);
                if square > 0.0 && !(is_doubtful && remainder.abs() <= REMAINDER * size) {
                    let e = remainder / square;
                    for i in 0..2 {
                        gradient.bar[i] += e * d[i];
                        for k in 0..2 {
                            gradient.tangent[i][k] = d[i] * (end.normal[k] - middle.normal[k] - 2.0 * e * d[k]) / square;
                        }
                        gradient.tangent[i][i] += e;
                    }
                }
                gradient
            }
        }
    }
}

impl ObstacleSide<2> for PlaneOutline {
    fn sides(&self) -> usize {
        if matches!(self, PlaneOutline::Polyline { .. }) { SIDES } else { 1 }
    }

    fn near(&self, x: Vector2<f64>, radius: f64, spare: f64) -> Vec<Self> {
        self.nearest_sides(x.into(), radius + spare)
    }

    fn at(&self, x: Vector2<f64>) -> Local<2> {
        let of = |Distance { gap, normal, covered }: Distance| {
            let bend = self.curvature(x.into());
            Local { gap, normal: normal.into(), curvature: Matrix2::from_fn(|i, k| bend[i][k]), covered }
        };
        self.distance(x.into()).map_or_else(Local::none, of)
    }

    fn between(&self, x_0: Vector2<f64>, x_1: Vector2<f64>, size: f64) -> (Vector2<f64>, Matrix2<f64>) {
        let StepGradient { bar, tangent } = self.step_gradient(x_0.into(), x_1.into(), size);
        (bar.into(), Matrix2::from_fn(|i, k| tangent[i][k]))
    }

    fn takes_rims(&self) -> bool {
        false
    }

    fn passage(&self, x_0: Vector2<f64>, x_1: Vector2<f64>, near: f64) -> (f64, bool) {
        if matches!(self, PlaneOutline::HalfPlane { .. } | PlaneOutline::Circle { sign: -1.0, .. }) {
            // A half plane or the complement of a disk has no far side to which a node could cross.
            return (0.0, false);
        }
        (self.direction_change(x_0.into(), x_1.into(), near), self.is_crossed(x_0.into(), x_1.into()))
    }
}
