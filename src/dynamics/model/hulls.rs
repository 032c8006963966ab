//! Hulls of bodies, and their mutual penetration.
//!
//! In the plane there are two cases: a node of one hull inside the other, and crossing facets far from all their nodes. Hulls are polygons,
//! so a node of one curved side may lie behind the chord of the other by the sagitta; this and a hundredth of a facet are admitted.

use std::collections::HashMap;

use crate::contact::{HullPenetration, Solid};
use crate::mesh::{Mesh, cross, is_inside};

/// Admitted overlap as a fraction of a facet, in addition to the sagitta of curved sides.
pub const ALLOWED: f64 = 0.01;

/// Angle between neighboring facets, in degrees, above which a node of the hull is a corner and not part of a curve.
const CORNER: f64 = 45.0;

/// Distance of a probe point behind the middle of a facet, relative to its length, to detect the overlap of hulls whose nodes coincide.
const BEHIND: f64 = 0.25;

/// Hull of a body in the plane, the body on the left of its facets.
pub struct Hull {
    /// Index of the body.
    pub body: usize,
    /// End points of the facets.
    pub facets: Vec<[[f64; 2]; 2]>,
    /// Admitted penetration per facet: the sagitta of the curve that the facet approximates, and a fraction of the facet length.
    allowed: Vec<f64>,
    low: [f64; 2],
    high: [f64; 2],
}

/// The hull of a body in the plane or in space.
pub enum BodyHull {
    /// Polygon of a body in the plane.
    Plane(Hull),
    /// Polyhedron of a body in space.
    Space(Box<Solid>),
}

/// Mutual penetration of two hulls.
pub struct MutualPenetration {
    /// Penetration `[length]`.
    pub depth: f64,
    /// Length of the penetrated facet `[length]`.
    pub size: f64,
    /// Position of the penetration, with one coordinate per dimension `[length]`.
    pub at: Vec<f64>,
}

impl BodyHull {
    /// Hull of a mesh with nodes at `q`.
    pub fn new(body: usize, mesh: &Mesh, q: &[f64]) -> BodyHull {
        if mesh.dimension() == 2 {
            return BodyHull::Plane(Hull::new(body, &mesh.outline(), &|node| [q[2 * node as usize], q[2 * node as usize + 1]]));
        }
        let facets: Vec<Vec<u32>> = mesh.hull().into_iter().flat_map(|facet| mesh.flat_pieces(facet)).collect();
        BodyHull::Space(Box::new(Solid::new(facets.iter().map(|facet| &facet[..]), q.to_vec())))
    }

    /// Deepest mutual penetration of two hulls; `None` without one.
    pub fn inside(&self, other: &BodyHull) -> Option<MutualPenetration> {
        match (self, other) {
            (BodyHull::Plane(own), BodyHull::Plane(other)) => own.inside(other),
            (BodyHull::Space(own), BodyHull::Space(other)) => {
                own.inside(other).map(|HullPenetration { depth, size, at }| MutualPenetration { depth, size, at: at.into() })
            }
            _ => None,
        }
    }
}

impl Hull {
    /// Hull of a body with these facets; `point` returns node positions.
    pub fn new(body: usize, ends: &[[u32; 2]], point: &dyn Fn(u32) -> [f64; 2]) -> Hull {
        let before: HashMap<u32, usize> = ends.iter().enumerate().map(|(facet, [_, end])| (*end, facet)).collect();
        let facets: Vec<[[f64; 2]; 2]> = ends.iter().map(|ends| ends.map(point)).collect();
        let direction = |facet: usize| {
            let [a, b] = facets[facet];
            f64::atan2(b[1] - a[1], b[0] - a[0])
        };
        // Angle between a facet and its predecessor at the first node of the facet; the angle at its last node is that of the successor.
        let turn = |facet: usize| {
            let behind = *before.get(&ends[facet][0])?;
            let turn = (direction(facet) - direction(behind)).rem_euclid(std::f64::consts::TAU);
            let turn = turn.min(std::f64::consts::TAU - turn);
            (turn < CORNER.to_radians()).then_some((behind, turn))
        };
        let mut largest = vec![0.0f64; facets.len()];
        for facet in 0..facets.len() {
            if let Some((behind, turn)) = turn(facet) {
                largest[facet] = largest[facet].max(turn);
                largest[behind] = largest[behind].max(turn);
            }
        }
        let allowed = facets.iter().zip(&largest).map(|(facet, turn)| length(*facet) * (ALLOWED + turn / 8.0)).collect();
        let bound = |pick: fn(f64, f64) -> f64, start: f64| [0, 1].map(|i| facets.iter().flatten().fold(start, |best, x| pick(best, x[i])));
        let (low, high) = (bound(f64::min, f64::INFINITY), bound(f64::max, f64::NEG_INFINITY));
        Hull { body, facets, allowed, low, high }
    }

    /// Deepest mutual penetration of two hulls; `None` without one.
    pub fn inside(&self, other: &Hull) -> Option<MutualPenetration> {
        if !self.meets(other) {
            return None;
        }
        let places = [deepest(self, other), deepest(other, self), crossing(self, other)];
        let (depth, size, at) = places.into_iter().flatten().max_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(MutualPenetration { depth, size, at: at.into() })
    }

    /// True if the bounding boxes of two hulls overlap.
    fn meets(&self, other: &Hull) -> bool {
        (0..2).all(|i| self.low[i] < other.high[i] && other.low[i] < self.high[i])
    }

    /// Fraction of `ray` at which it first leaves the hull from inside, starting at `x`; `None` if it never does. A hull that touches `x`
    /// counts.
    pub fn passed(&self, x: [f64; 2], ray: [f64; 2]) -> Option<f64> {
        let part = |[a, b]: &[[f64; 2]; 2]| {
            let (along, to) = ([b[0] - a[0], b[1] - a[1]], [a[0] - x[0], a[1] - x[1]]);
            let turn = cross(ray, along);
            let (part, share) = (cross(to, along) / turn, cross(to, ray) / turn);
            // The ray leaves where it crosses a facet from left to right: the body is on the left.
            (turn > 0.0 && part >= 0.0 && (0.0..=1.0).contains(&share)).then_some(part)
        };
        self.facets.iter().filter_map(part).min_by(f64::total_cmp)
    }

    fn contains(&self, point: [f64; 2]) -> bool {
        is_inside(self.facets.iter().copied(), point)
    }
}

/// Deepest point of one hull inside another: a node, or a probe point behind a facet for coinciding nodes. Returns depth, facet size and
/// position.
fn deepest(of: &Hull, inside: &Hull) -> Option<(f64, f64, [f64; 2])> {
    let in_box = |x: &[f64; 2]| (0..2).all(|i| inside.low[i] < x[i] && x[i] < inside.high[i]);
    let depth = |(index, x): (usize, [f64; 2])| {
        let distances = inside.facets.iter().map(|facet| distance(x, *facet)).enumerate();
        let (nearest, depth) = distances.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let allowed = inside.allowed[nearest] + of.allowed[index];
        (depth > allowed && inside.contains(x)).then(|| (depth, length(inside.facets[nearest]).min(length(of.facets[index])), x))
    };
    let behind = |[a, b]: &[[f64; 2]; 2]| [0, 1].map(|i| 0.5 * (a[i] + b[i]) + BEHIND * [a[1] - b[1], b[0] - a[0]][i]);
    let nodes = of.facets.iter().map(|[x, _]| *x).enumerate();
    let points = nodes.chain(of.facets.iter().map(behind).enumerate().filter(|(_, x)| of.contains(*x)));
    points.filter(|(_, x)| in_box(x)).filter_map(depth).max_by(|a, b| a.0.total_cmp(&b.0))
}

/// Crossing facets of two hulls with the largest distance from all their nodes: bodies that penetrate without a node inside.
fn crossing(first: &Hull, second: &Hull) -> Option<(f64, f64, [f64; 2])> {
    let minus = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
    let mut farthest: Option<(f64, f64, [f64; 2])> = None;
    for (k, a) in first.facets.iter().enumerate() {
        let along = minus(a[1], a[0]);
        for (l, b) in second.facets.iter().enumerate() {
            let other = minus(b[1], b[0]);
            // Signed distances of each facet's ends from the line of the other one.
            let of_b = [0, 1].map(|end| cross(along, minus(b[end], a[0])) / length(*a));
            let of_a = [0, 1].map(|end| cross(other, minus(a[end], b[0])) / length(*b));
            if of_b[0] * of_b[1] >= 0.0 || of_a[0] * of_a[1] >= 0.0 {
                continue;
            }
            let depth = of_a.iter().chain(&of_b).fold(f64::INFINITY, |least, x| least.min(x.abs()));
            if depth > first.allowed[k] + second.allowed[l] && farthest.is_none_or(|(most, ..)| depth > most) {
                let share = of_a[0] / (of_a[0] - of_a[1]);
                farthest = Some((depth, length(*a).min(length(*b)), [0, 1].map(|i| a[0][i] + share * along[i])));
            }
        }
    }
    farthest
}

fn length([a, b]: [[f64; 2]; 2]) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

/// Distance of a point from a facet.
pub fn distance(x: [f64; 2], [a, b]: [[f64; 2]; 2]) -> f64 {
    let (along, to) = ([b[0] - a[0], b[1] - a[1]], [x[0] - a[0], x[1] - a[1]]);
    let share = ((along[0] * to[0] + along[1] * to[1]) / (along[0] * along[0] + along[1] * along[1])).clamp(0.0, 1.0);
    (to[0] - share * along[0]).hypot(to[1] - share * along[1])
}
