//! Shapes of rigid obstacles in the plane: signed distance, normal, curvature and discrete gradient at points in the obstacle's frame.

use std::sync::Arc;

use nalgebra::{Matrix2, Vector2};
use rstar::primitives::{GeomWithData, Line};
use rstar::{AABB, RTree};

use super::chain::Chain;
use super::edge_plane::{AtEdge, NodeAtEdge};
use super::obstacle_side::{Distance, ObstacleSide, StepGradient};
use super::slip::Carrier;
use super::space::ObstacleInSpace;
use crate::math::tolerances::{PROJECTED_INCREMENT, REMAINDER};

/// Largest number of polyline sides that a round part touches simultaneously.
const SIDES: usize = 2;

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

/// Obstacle prepared for evaluation.
#[derive(Clone, Debug)]
pub(super) enum PlaneOutline {
    HalfPlane {
        point: Vector2<f64>,
        normal: Vector2<f64>,
    },
    /// Circle; `sign` is +1 for bodies outside, -1 inside.
    Circle {
        center: Vector2<f64>,
        radius: f64,
        sign: f64,
    },
    Polyline(Arc<Segments>),
}

/// Segments of a polyline.
#[derive(Debug)]
pub(super) struct Segments {
    tree: RTree<GeomWithData<Line<[f64; 2]>, usize>>,
    /// For each segment: the chain of the segment and its neighbors, and the coordinates of the chain's nodes after a placeholder for the
    /// point.
    corners: Vec<(Chain, Vec<f64>)>,
}

impl Segments {
    /// Chain of the segment nearest to a point, and the coordinates of the point and the chain's nodes.
    fn nearest(&self, x: Vector2<f64>) -> Option<(&Chain, Vec<f64>)> {
        let (chain, points) = &self.corners[self.tree.nearest_neighbor(x.into())?.data];
        Some((chain, x.iter().chain(&points[2..]).copied().collect()))
    }
}

impl PlaneOutline {
    pub(super) fn new(obstacle: &Obstacle) -> Self {
        match obstacle {
            Obstacle::HalfPlane { point, normal } => {
                let length = normal[0].hypot(normal[1]);
                PlaneOutline::HalfPlane { point: Vector2::from(*point), normal: Vector2::from(*normal) / length }
            }
            Obstacle::Disk { center, radius } => PlaneOutline::Circle { center: Vector2::from(*center), radius: *radius, sign: 1.0 },
            Obstacle::Ring { center, radius } => PlaneOutline::Circle { center: Vector2::from(*center), radius: *radius, sign: -1.0 },
            // Models with obstacles in space and plane bodies are refused before, so that this shape is never used.
            Obstacle::InSpace(_) => PlaneOutline::Polyline(Arc::new(Segments { tree: RTree::new(), corners: Vec::new() })),
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
                let corners = (0..count).map(neighborhood).collect();
                PlaneOutline::Polyline(Arc::new(Segments { tree: RTree::bulk_load(lines.collect()), corners }))
            }
        }
    }

    /// Rigid motion of the obstacle's surface in a step, for friction: a displacement and, for a circle, a rotation about its center.
    /// `middle` is the obstacle's translation in mid-step `[length]`.
    pub(super) fn carrier(&self, ([x, y, _], angle): ([f64; 3], f64), middle: [f64; 3]) -> Carrier {
        let shift = [x, y];
        let PlaneOutline::Circle { center, .. } = self else { return Carrier { shift, ..Carrier::default() } };
        Carrier { shift, turn: 2.0 * (0.5 * angle).tan(), center: std::array::from_fn(|i| center[i] + middle[i]) }
    }
}

impl ObstacleSide<2> for PlaneOutline {
    fn distance(&self, x: Vector2<f64>) -> Option<Distance<2>> {
        match self {
            PlaneOutline::HalfPlane { point, normal } => {
                Some(Distance::flat(normal[0] * (x[0] - point[0]) + normal[1] * (x[1] - point[1]), *normal, true))
            }
            PlaneOutline::Circle { center, radius, sign } => {
                let r = x - center;
                let length = r[0].hypot(r[1]);
                let gap = sign * (length - radius);
                if length == 0.0 {
                    return Some(Distance { gap, covered: true, ..Distance::none() });
                }
                let n = r / length;
                let curvature = Matrix2::new(n[1] * n[1], -n[0] * n[1], -n[0] * n[1], n[0] * n[0]).map(|h| sign * h / length);
                Some(Distance { gap, normal: r.map(|r| sign * r / length), curvature, covered: true })
            }
            PlaneOutline::Polyline(segments) => {
                let (chain, z) = segments.nearest(x)?;
                let measure = chain.measure(&z, &[true; 3])?;
                let mut gradient = vec![0.0; z.len()];
                chain.add_gradient(&measure, &z, 1.0, &mut gradient);
                Some(Distance::flat(measure.gap, Vector2::new(gradient[0], gradient[1]), measure.covered))
            }
        }
    }

    fn step_gradient(&self, x_0: Vector2<f64>, x_1: Vector2<f64>, size: f64) -> StepGradient<2> {
        match self {
            PlaneOutline::HalfPlane { normal, .. } => StepGradient::fixed(*normal),
            PlaneOutline::Circle { center, sign, .. } => {
                let (r_0, r_1) = (x_0 - center, x_1 - center);
                let end = r_1[0].hypot(r_1[1]);
                let lengths = r_0[0].hypot(r_0[1]) + end;
                if end == 0.0 {
                    return StepGradient::fixed(Vector2::zeros());
                }
                let bar = (r_0 + r_1).map(|r| sign * r / lengths);
                let tangent = Matrix2::from_fn(|i, k| (if i == k { *sign } else { 0.0 } - bar[i] * r_1[k] / end) / lengths);
                StepGradient { bar, tangent }
            }
            PlaneOutline::Polyline(_) => {
                let (start, middle, end) = (self.at(x_0), self.at(0.5 * (x_0 + x_1)), self.at(x_1));
                let d = x_1 - x_0;
                let square = d[0] * d[0] + d[1] * d[1];
                let mut gradient = StepGradient::fixed(middle.normal);
                let remainder = end.gap - start.gap - middle.normal[0] * d[0] - middle.normal[1] * d[1];
                // For small increments the remainder of the discrete gradient is round-off, unless a corner lies between both points.
                let is_doubtful = square <= (PROJECTED_INCREMENT * size).powi(2);
                if square > 0.0 && !(is_doubtful && remainder.abs() <= REMAINDER * size) {
                    let e = remainder / square;
                    gradient.bar += d * e;
                    gradient.tangent = Matrix2::from_fn(|i, k| {
                        d[i] * (end.normal[k] - middle.normal[k] - 2.0 * e * d[k]) / square + if i == k { e } else { 0.0 }
                    });
                }
                gradient
            }
        }
    }

    fn sides(&self) -> usize {
        if matches!(self, PlaneOutline::Polyline(_)) { SIDES } else { 1 }
    }

    /// Sides of a polyline within reach of a round part, as half planes in the order of the points. If the nearest point is a convex
    /// corner, a circle of zero radius represents it. For points behind the polyline or beyond its ends, the polyline itself.
    fn near(&self, x: Vector2<f64>, radius: f64, spare: f64) -> Vec<Self> {
        let PlaneOutline::Polyline(segments) = self else { return vec![self.clone()] };
        let (Some(nearest), Some(distance)) = (segments.tree.nearest_neighbor(x.into()), self.distance(x)) else { return Vec::new() };
        if distance.gap <= 0.0 || !distance.covered {
            return vec![self.clone()];
        }
        let reach = (radius + spare).max(distance.gap * (1.0 + PROJECTED_INCREMENT));
        let mut sides: Vec<(f64, usize, PlaneOutline)> = Vec::new();
        for side in segments.tree.locate_within_distance(x.into(), reach * reach) {
            let Line { from, to } = *side.geom();
            let (along, arm) = ([to[0] - from[0], to[1] - from[1]], [x[0] - from[0], x[1] - from[1]]);
            let square = along[0] * along[0] + along[1] * along[1];
            let share = (arm[0] * along[0] + arm[1] * along[1]) / square;
            let gap = (arm[0] * along[1] - arm[1] * along[0]) / square.sqrt();
            if (0.0..=1.0).contains(&share) && gap > 0.0 {
                let normal = Vector2::new(along[1] / square.sqrt(), -along[0] / square.sqrt());
                sides.push((gap, side.data, PlaneOutline::HalfPlane { point: from.into(), normal }));
            } else if side.data == nearest.data {
                let center = if share < 0.0 { from } else { to }.into();
                sides.push((0.0, side.data, PlaneOutline::Circle { center, radius: 0.0, sign: 1.0 }));
            }
        }
        sides.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        sides.truncate(SIDES);
        sides.sort_by_key(|side| side.1);
        sides.into_iter().map(|(.., shape)| shape).collect()
    }

    fn at_edge(&self, x: Vector2<f64>, near: f64) -> Option<AtEdge<2>> {
        let PlaneOutline::Polyline(segments) = self else { return None };
        let (chain, z) = segments.nearest(x)?;
        chain.at_corner(&chain.measure(&z, &[true; 3])?, &z, near)
    }

    /// Line through the corner, or that of the node's side.
    fn plane_at_edge(&self, node: &NodeAtEdge<2>) -> Option<Self> {
        let at = &node.at;
        let through_corner = node.plane_through().filter(|_| node.is_beside_corners);
        let line = through_corner.or_else(|| node.is_on_edge().then(|| [at.points[0], at.normals[0]]));
        line.map(|[point, normal]| PlaneOutline::HalfPlane { point, normal })
    }

    fn takes_rims(&self) -> bool {
        false
    }

    fn is_one_sided(&self) -> bool {
        matches!(self, PlaneOutline::HalfPlane { .. } | PlaneOutline::Circle { sign: -1.0, .. })
    }

    fn crosses_surface(&self, x_0: Vector2<f64>, x_1: Vector2<f64>) -> Option<bool> {
        let d = x_1 - x_0;
        let segments = match self {
            PlaneOutline::HalfPlane { .. } => return Some(false),
            // The line crosses the circle if the center is nearer to it than the radius.
            PlaneOutline::Circle { center, radius, .. } => return Some(d.perp(&(center - x_0)).abs() < radius * d.norm()),
            PlaneOutline::Polyline(segments) => segments,
        };
        let area = AABB::from_corners(x_0.inf(&x_1).into(), x_0.sup(&x_1).into());
        let side = |from: Vector2<f64>, along: Vector2<f64>, x: Vector2<f64>| along.perp(&(x - from));
        Some(segments.tree.locate_in_envelope_intersecting(area).any(|facet| {
            let [from, to] = [facet.geom().from, facet.geom().to].map(Vector2::from);
            let along = to - from;
            side(x_0, d, from) * side(x_0, d, to) < 0.0 && side(from, along, x_0) * side(from, along, x_1) < 0.0
        }))
    }
}
