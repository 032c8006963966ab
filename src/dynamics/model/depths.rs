//! Penetration of the sides of contacts into bodies, and of obstacles into sides, at any positions. In the plane only.
//!
//! A node of one side counts if it is inside the body of the other side, with its distance from the nearest facet that faces it; so do
//! corners of a rigid polyline inside a body. Behind the hull of another body, in any orientation, there is no penetration. Unlike for
//! contact gaps the search distance is unlimited, but the search does not pass through bodies: a node outside of all bodies has no
//! penetration.

use super::amplitude::Amplitude;
use super::boundaries::{boundary_facets, facets_of_all};
use super::definitions::Model;
use super::hulls::distance;
use super::interactions::{BodyBoundary, ObstacleRotation, Partner, obstacle_place};
use crate::contact::{Obstacle, Surface};
use crate::math::tolerances::{BESIDE, DEPTH, OPPOSITE};
use crate::mesh::is_inside;

/// Sides of the contacts of a model, with the hulls of their bodies.
pub struct Depths {
    meetings: Vec<Meeting>,
    /// Facets of the hull of each body.
    hulls: Vec<Vec<[u32; 2]>>,
}

/// Contact whose sides may penetrate each other's bodies: two surfaces, or a surface and an obstacle's corners.
struct Meeting {
    contact: usize,
    first: BodySide,
    other: Other,
}

struct BodySide {
    body: usize,
    surface: Surface,
}

enum Other {
    Side(BodySide),
    Itself,
    Corners { points: Vec<[f64; 2]>, motion: [Option<Amplitude>; 3], turn: Option<ObstacleRotation> },
}

/// The deepest place of a contact.
#[derive(Clone, Debug, PartialEq)]
pub struct Depth {
    /// Index of the contact among the interactions of the model.
    pub contact: usize,
    /// Penetration `[length]`.
    pub depth: f64,
    /// Length of the longest facet at the point `[length]`.
    pub size: f64,
    /// Place of the deepest penetration `[length]`.
    pub at: [f64; 2],
    /// Nodes of both sides at the point, by model numbers.
    pub nodes: Vec<u32>,
    /// True if a corner of an obstacle is inside a body.
    pub is_corner: bool,
}

/// Point of one side: position, normal of the side, facet length, node.
struct Point {
    at: [f64; 2],
    normal: Option<[f64; 2]>,
    size: f64,
    node: Option<u32>,
}

impl Depths {
    /// Depths of the contacts of a model; empty in space.
    pub fn of(model: &Model) -> Depths {
        if model.dimension() != 2 {
            return Depths { meetings: Vec::new(), hulls: Vec::new() };
        }
        let mut firsts = vec![0];
        model.bodies.iter().for_each(|body| firsts.push(firsts[firsts.len() - 1] + body.mesh.points.len()));
        let facets = |on: &BodyBoundary| boundary_facets(model, on, firsts[on.body]);
        let side = |on: &[BodyBoundary], body: usize| {
            let own: Vec<BodyBoundary> = on.iter().filter(|on| on.body == body).cloned().collect();
            BodySide { body, surface: Surface::new(&facets_of_all(&own, facets)) }
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
                        // Two boundaries of one body: like self-contact.
                        Meeting { contact, first, other: Other::Side(side(primary, body)) }
                    }));
                }
                Partner::Itself => meetings.push(Meeting { contact, first: first(), other: Other::Itself }),
                Partner::Obstacle { shape: Obstacle::Polyline { points }, motion, turn } => {
                    let other = Other::Corners { points: points.clone(), motion: motion.clone(), turn: turn.clone() };
                    meetings.push(Meeting { contact, first: first(), other });
                }
                Partner::Obstacle { .. } | Partner::Tied { .. } => {}
            }
        }
        let hull = |(body, first): (usize, &usize)| {
            let ends = model.bodies[body].mesh.outline();
            ends.into_iter().map(|ends| ends.map(|node| node + *first as u32)).collect()
        };
        let hulls = firsts.iter().enumerate().take(model.bodies.len()).map(hull).collect();
        Depths { meetings, hulls }
    }

    /// Deepest penetration of each contact, for node positions `q` and obstacles at time `time`, among depths accepted by `counts`.
    pub fn at(&self, q: &[f64], time: f64, counts: &dyn Fn(&Depth) -> bool) -> Vec<Depth> {
        let mut found: Vec<Depth> = Vec::new();
        for meeting in &self.meetings {
            let deepest = |own: Option<usize>, points: Vec<Point>, side: &BodySide| {
                // Nodes of this body lie on its hull and have zero distance from it.
                let asks_for_room = own != Some(side.body);
                self.deepest(points, side, q, asks_for_room, meeting.contact, counts)
            };
            let (first, body) = (&meeting.first, Some(meeting.first.body));
            let depths = match &meeting.other {
                Other::Side(other) => {
                    [deepest(body, points(&first.surface, q), other), deepest(Some(other.body), points(&other.surface, q), first)]
                }
                Other::Itself => [deepest(body, points(&first.surface, q), first), None],
                Other::Corners { points, motion, turn } => {
                    let place = obstacle_place(motion, turn.as_ref(), time);
                    let at = |point: &[f64; 2]| {
                        let [x, y, _] = place.point([point[0], point[1], 0.0]);
                        Point { at: [x, y], normal: None, size: 0.0, node: None }
                    };
                    [deepest(None, points.iter().map(at).collect(), first), None]
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

    /// Deepest of several points inside the body of a side, among depths accepted by `counts`; with `asks_for_room` only points farther
    /// from the hull than the fraction `DEPTH` of a facet.
    fn deepest(
        &self,
        points: Vec<Point>,
        side: &BodySide,
        q: &[f64],
        asks_for_room: bool,
        contact: usize,
        counts: &dyn Fn(&Depth) -> bool,
    ) -> Option<Depth> {
        let at = |node: u32| [q[2 * node as usize], q[2 * node as usize + 1]];
        let hull: Vec<[[f64; 2]; 2]> = self.hulls[side.body].iter().map(|ends| ends.map(at)).collect();
        let bound = |pick: fn(f64, f64) -> f64, start: f64| [0, 1].map(|i| hull.iter().flatten().fold(start, |best, x| pick(best, x[i])));
        let (low, high) = (bound(f64::min, f64::INFINITY), bound(f64::max, f64::NEG_INFINITY));
        let mut deepest: Option<Depth> = None;
        for point in points {
            // Test point slightly in front of the node, outside of the node's own body: the hull may be that of the same body.
            let x = point.normal.map_or(point.at, |normal| [0, 1].map(|i| point.at[i] + BESIDE * point.size * normal[i]));
            if !(0..2).all(|i| low[i] < x[i] && x[i] < high[i]) {
                continue;
            }
            let Some((depth, facet)) = nearest(&point, &side.surface, q) else { continue };
            if deepest.as_ref().is_some_and(|known| known.depth >= depth) || !is_inside(hull.iter().copied(), x) {
                continue;
            }
            let size = point.size.max(side.surface.facet_measure(facet, q));
            if asks_for_room && hull.iter().any(|&facet| distance(point.at, facet) <= DEPTH * size) {
                continue;
            }
            let nodes = point.node.into_iter().chain(side.surface.facets()[facet]).collect();
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

/// Nearest facet of a surface that the point is behind, and its distance.
fn nearest(point: &Point, surface: &Surface, q: &[f64]) -> Option<(f64, usize)> {
    let at = |node: u32| [q[2 * node as usize], q[2 * node as usize + 1]];
    let to_facet = |(index, &facet): (usize, &[u32; 2])| {
        if point.node.is_some_and(|node| facet.contains(&node)) {
            return None;
        }
        let [a, b] = facet.map(at);
        let (t, d) = ([b[0] - a[0], b[1] - a[1]], [point.at[0] - a[0], point.at[1] - a[1]]);
        let length = t[0].hypot(t[1]);
        let outward = [t[1] / length, -t[0] / length];
        let looks_away = point.normal.is_some_and(|normal| normal[0] * outward[0] + normal[1] * outward[1] > OPPOSITE);
        // A node on the facet up to round-off, as in matching meshes, has no penetration from a farther facet.
        if looks_away || outward[0] * d[0] + outward[1] * d[1] > 2.0 * BESIDE * length.max(point.size) {
            return None;
        }
        let share = ((t[0] * d[0] + t[1] * d[1]) / (length * length)).clamp(0.0, 1.0);
        Some(((d[0] - share * t[0]).hypot(d[1] - share * t[1]), index))
    };
    surface.facets().iter().enumerate().filter_map(to_facet).min_by(|a, b| a.0.total_cmp(&b.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::model::interactions::Interaction;
    use crate::materials::NeoHookean;
    use crate::mesh::rectangle;

    /// A block of 8 by 8 cells on a wider one of 16 by 4, its bottom at that height.
    fn blocks(height: f64, side: &str) -> (Model, Vec<f64>) {
        let rubber = NeoHookean { youngs_modulus: 1.0, poisson_ratio: 0.3, density: 1.0 }.material().expect("in range");
        let mut model = Model::new("blocks");
        let upper = model.add_body("upper", rectangle([1.0, 1.0], [8, 8], [0.5, height]).expect("the mesh is sound"), &rubber);
        let lower = model.add_body("lower", rectangle([2.0, 1.0], [16, 4], [0.0, -1.0]).expect("the mesh is sound"), &rubber);
        let sides = [model.boundary(upper, side), model.boundary(lower, "top")].map(|side| side.expect("it has one"));
        let [secondary, primary] = sides;
        model.add_interaction(Interaction::contact("touch", secondary, primary));
        let q = model.bodies.iter().flat_map(|body| body.mesh.points.iter().flat_map(|point| [point[0], point[1]])).collect();
        (model, q)
    }

    #[test]
    fn depth_is_that_of_sides_that_look_at_each_other() {
        for height in [-0.5, -0.3, -0.05] {
            let (model, q) = blocks(height, "bottom");
            let found = Depths::of(&model).at(&q, 0.0, &|_| true);
            assert!(found.len() == 1 && (found[0].depth + height).abs() < 1e-12 && (found[0].size - 0.125).abs() < 1e-12, "{found:?}");
        }
        // Touching blocks, separate blocks, and a contact side that faces away.
        for (height, side) in [(0.0, "bottom"), (0.2, "bottom"), (-0.3, "left"), (-0.3, "top")] {
            let (model, q) = blocks(height, side);
            let found = Depths::of(&model).at(&q, 0.0, &|_| true);
            assert!(found.iter().all(|found| found.depth < 1e-12), "{height} {side}: {found:?}");
        }
        let (model, q) = blocks(-0.3, "bottom");
        assert_eq!(Depths::of(&model).at(&q, 0.0, &|found| found.depth > 0.31), []);
    }

    /// Nodes of equal meshes on each other lie on the hull, on one side or the other by round-off.
    #[test]
    fn nodes_upon_nodes_are_not_a_facet_deep() {
        let (model, mut q) = blocks(0.0, "bottom");
        for shift in [-1e-15, 1e-15, -1e-9, 1e-9, -1e-7, 1e-7] {
            q.iter_mut().take(2 * 81).skip(1).step_by(2).for_each(|y| *y += shift);
            let found = Depths::of(&model).at(&q, 0.0, &|_| true);
            assert!(found.iter().all(|found| found.depth < 1e-6), "{shift}: {found:?}");
            q.iter_mut().take(2 * 81).skip(1).step_by(2).for_each(|y| *y -= shift);
        }
    }
}
