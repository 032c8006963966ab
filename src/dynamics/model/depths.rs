//! How deep the sides of contacts are inside the bodies, or the obstacles inside the sides, at any positions. In the plane only.
//!
//! A node of one side counts that is inside the body of the other side, by its distance from the nearest facet of that side that looks at
//! it; so do corners of a rigid polyline inside a body. Unlike a contact's own gaps this looks however far, and through no body: a node in
//! the free has no depth, wherever facets behind it may be.

use super::amplitude::Amplitude;
use super::boundaries::{boundary_facets, facets_of_all};
use super::definitions::Model;
use super::hulls::hull_ends;
use super::interactions::{BodyBoundary, Partner};
use crate::contact::{Obstacle, Surface};
use crate::math::tolerances::{BESIDE, OPPOSITE};
use crate::mesh::is_inside;

/// Sides of the contacts of a model and hulls of their bodies.
pub struct Depths {
    meetings: Vec<Meeting>,
    /// Facets of the hull of each body.
    hulls: Vec<Vec<[u32; 2]>>,
}

/// Two surfaces that may be inside each other's bodies, or a surface and an obstacle's corners.
struct Meeting {
    contact: usize,
    first: Side,
    other: Other,
}

struct Side {
    body: usize,
    surface: Surface,
}

enum Other {
    Side(Side),
    Itself,
    Corners { points: Vec<[f64; 2]>, motion: [Option<Amplitude>; 2] },
}

/// The deepest place of a contact.
#[derive(Clone, Debug, PartialEq)]
pub struct Depth {
    /// Index of the contact among the interactions of the model.
    pub contact: usize,
    /// How deep `[length]`.
    pub depth: f64,
    /// Length of the longest facet there `[length]`.
    pub size: f64,
    /// Where.
    pub at: [f64; 2],
    /// Nodes of both sides there, in the numbers of the model.
    pub nodes: Vec<u32>,
    /// Whether a corner of an obstacle is inside a body.
    pub is_corner: bool,
}

/// A point of one side: where, which way its side looks there, how long its facets are, its node.
struct Point {
    at: [f64; 2],
    normal: Option<[f64; 2]>,
    size: f64,
    node: Option<u32>,
}

impl Depths {
    /// The contacts of a model; none in space.
    pub fn of(model: &Model) -> Depths {
        if model.dimension() != 2 {
            return Depths { meetings: Vec::new(), hulls: Vec::new() };
        }
        let mut firsts = vec![0];
        model.bodies.iter().for_each(|body| firsts.push(firsts[firsts.len() - 1] + body.mesh.points.len()));
        let facets = |on: &BodyBoundary| boundary_facets(model, on, firsts[on.body]);
        let side = |on: &[BodyBoundary], body: usize| {
            let own: Vec<BodyBoundary> = on.iter().filter(|on| on.body == body).cloned().collect();
            Side { body, surface: Surface::new(&facets_of_all(&own, facets)) }
        };
        let mut meetings = Vec::new();
        for (contact, interaction) in model.interactions.iter().enumerate() {
            let first = || side(std::slice::from_ref(&interaction.secondary), interaction.secondary.body);
            match &interaction.partner {
                Partner::Surfaces(primary) => {
                    let mut bodies: Vec<usize> = primary.iter().map(|on| on.body).collect();
                    bodies.sort_unstable();
                    bodies.dedup();
                    meetings.extend(bodies.into_iter().map(|body| {
                        let first = first();
                        // Two parts of one body: as a surface that touches itself.
                        Meeting { contact, first, other: Other::Side(side(primary, body)) }
                    }));
                }
                Partner::Itself => meetings.push(Meeting { contact, first: first(), other: Other::Itself }),
                Partner::Obstacle { shape: Obstacle::Polyline { points }, motion } => {
                    let other = Other::Corners { points: points.clone(), motion: motion.clone() };
                    meetings.push(Meeting { contact, first: first(), other });
                }
                Partner::Obstacle { .. } | Partner::Tied { .. } => {}
            }
        }
        let hull = |(body, first): (usize, &usize)| {
            let ends = hull_ends(&model.bodies[body].mesh);
            ends.into_iter().map(|ends| ends.map(|node| node + *first as u32)).collect()
        };
        let hulls = firsts.iter().enumerate().take(model.bodies.len()).map(hull).collect();
        Depths { meetings, hulls }
    }

    /// The deepest place of each contact that has one, with all nodes at `q` and obstacles as at a time, of those that count.
    pub fn at(&self, q: &[f64], time: f64, counts: &dyn Fn(&Depth) -> bool) -> Vec<Depth> {
        let mut found: Vec<Depth> = Vec::new();
        for meeting in &self.meetings {
            let deepest = |points: Vec<Point>, side: &Side| self.deepest(meeting.contact, points, side, q, counts);
            let depths = match &meeting.other {
                Other::Side(other) => {
                    [deepest(points(&meeting.first.surface, q), other), deepest(points(&other.surface, q), &meeting.first)]
                }
                Other::Itself => [deepest(points(&meeting.first.surface, q), &meeting.first), None],
                Other::Corners { points, motion } => {
                    // A time function that fails does so again, with its error, in the next step.
                    let by = motion.each_ref().map(|motion| motion.as_ref().and_then(|motion| motion.value(time).ok()).unwrap_or(0.0));
                    let at = |point: &[f64; 2]| Point { at: [point[0] + by[0], point[1] + by[1]], normal: None, size: 0.0, node: None };
                    [deepest(points.iter().map(at).collect(), &meeting.first), None]
                }
            };
            for depth in depths.into_iter().flatten() {
                match found.iter_mut().find(|known| known.contact == depth.contact && known.is_corner == depth.is_corner) {
                    Some(known) if known.depth < depth.depth => *known = depth,
                    Some(_) => {}
                    None => found.push(depth),
                }
            }
        }
        found
    }

    /// The deepest of some points inside the body of a side.
    fn deepest(&self, contact: usize, points: Vec<Point>, side: &Side, q: &[f64], counts: &dyn Fn(&Depth) -> bool) -> Option<Depth> {
        let at = |node: u32| [q[2 * node as usize], q[2 * node as usize + 1]];
        let hull: Vec<[[f64; 2]; 2]> = self.hulls[side.body].iter().map(|ends| ends.map(at)).collect();
        let bound = |pick: fn(f64, f64) -> f64, start: f64| [0, 1].map(|i| hull.iter().flatten().fold(start, |best, x| pick(best, x[i])));
        let (low, high) = (bound(f64::min, f64::INFINITY), bound(f64::max, f64::NEG_INFINITY));
        let mut deepest: Option<Depth> = None;
        for point in points {
            // A little outside of its own body, which may be the same one.
            let x = point.normal.map_or(point.at, |normal| [0, 1].map(|i| point.at[i] + BESIDE * point.size * normal[i]));
            if !(0..2).all(|i| low[i] < x[i] && x[i] < high[i]) {
                continue;
            }
            let Some((depth, facet)) = nearest(&point, &side.surface, q) else { continue };
            if deepest.as_ref().is_some_and(|known| known.depth >= depth) || !is_inside(hull.iter().copied(), x) {
                continue;
            }
            let nodes = point.node.into_iter().chain(side.surface.facets()[facet]).collect();
            let size = point.size.max(side.surface.facet_length(facet, q));
            let found = Depth { contact, depth, size, at: point.at, nodes, is_corner: point.node.is_none() };
            if counts(&found) {
                deepest = Some(found);
            }
        }
        deepest
    }
}

/// Nodes of a surface.
fn points(surface: &Surface, q: &[f64]) -> Vec<Point> {
    let at = |node: u32| [q[2 * node as usize], q[2 * node as usize + 1]];
    let point = |(index, &node): (usize, &u32)| {
        let (mut sum, mut size) = ([0.0; 2], 0.0f64);
        for &facet in surface.adjacent_facets(index) {
            let [a, b] = surface.facets()[facet as usize].map(at);
            let t = [b[0] - a[0], b[1] - a[1]];
            let length = t[0].hypot(t[1]);
            (sum[0], sum[1], size) = (sum[0] + t[1] / length, sum[1] - t[0] / length, size.max(length));
        }
        let length = sum[0].hypot(sum[1]);
        Point { at: at(node), normal: (length > 0.0).then(|| sum.map(|x| x / length)), size, node: Some(node) }
    };
    surface.nodes().iter().enumerate().map(point).collect()
}

/// The nearest facet of a surface that looks at a point from in front of it, and how far it is.
fn nearest(point: &Point, surface: &Surface, q: &[f64]) -> Option<(f64, usize)> {
    let at = |node: u32| [q[2 * node as usize], q[2 * node as usize + 1]];
    let distance = |(index, &facet): (usize, &[u32; 2])| {
        if point.node.is_some_and(|node| facet.contains(&node)) {
            return None;
        }
        let [a, b] = facet.map(at);
        let (t, d) = ([b[0] - a[0], b[1] - a[1]], [point.at[0] - a[0], point.at[1] - a[1]]);
        let length = t[0].hypot(t[1]);
        let outward = [t[1] / length, -t[0] / length];
        let looks_away = point.normal.is_some_and(|normal| normal[0] * outward[0] + normal[1] * outward[1] > OPPOSITE);
        // A node that lies on the facet, as those of equal meshes do, is as near as can be.
        if looks_away || outward[0] * d[0] + outward[1] * d[1] > 2.0 * BESIDE * length.max(point.size) {
            return None;
        }
        let share = ((t[0] * d[0] + t[1] * d[1]) / (length * length)).clamp(0.0, 1.0);
        Some(((d[0] - share * t[0]).hypot(d[1] - share * t[1]), index))
    };
    surface.facets().iter().enumerate().filter_map(distance).min_by(|a, b| a.0.total_cmp(&b.0))
}
