//! Bodies and obstacles that are inside each other before anything is computed, from the undeformed meshes alone.
//!
//! One idea: a node of one body that lies inside the hull of another, and hull facets that cross far from all their nodes, are an overlap
//! whatever contact is defined between the two. Hulls are polygons, so a node of one curved side may lie behind the chord of the other by
//! its rise (sagitta): that much, and a hundredth of a facet, is allowed. In the plane only.

use std::fmt;

use super::boundaries::boundary_facets;
use super::definitions::Model;
use super::interactions::{Interaction, Partner};
use crate::contact::{ContactKernel, Outlook, RigidContact};

/// Part of a facet that may overlap besides the rise of curved sides.
const ALLOWED: f64 = 0.01;

/// Turn between neighboring facets, in degrees, beyond which a hull has a corner there and is not a curve.
const CORNER: f64 = 45.0;

/// An overlap in the undeformed bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlap {
    /// What is in the way of what.
    pub kind: OverlapKind,
    /// Name of the interaction between the two, if there is one.
    pub contact: Option<String>,
    /// How deep a node is inside, or how far from all nodes hulls cross `[length]`.
    pub depth: f64,
    /// The same over the facet there.
    pub facets: f64,
    /// Where.
    pub at: [f64; 2],
}

/// What overlaps.
#[derive(Clone, Debug, PartialEq)]
pub enum OverlapKind {
    /// Two bodies, by their names.
    Bodies([String; 2]),
    /// A boundary and a rigid obstacle; whether all that can touch the obstacle is behind it.
    Obstacle {
        /// `body.boundary`.
        boundary: String,
        /// Whether all of it is behind the obstacle, some of it by more than a facet.
        whole: bool,
    },
}

impl fmt::Display for Overlap {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        match &self.kind {
            OverlapKind::Bodies([first, second]) => write!(out, "bodies \"{first}\" and \"{second}\" overlap at the start"),
            OverlapKind::Obstacle { boundary, whole: false } => write!(out, "\"{boundary}\" is inside the rigid obstacle at the start"),
            OverlapKind::Obstacle { boundary, whole: true } => write!(out, "all of \"{boundary}\" is behind the rigid obstacle"),
        }
    }
}

impl Overlap {
    /// How to mend it, one sentence.
    pub fn cure(&self) -> &'static str {
        match (&self.kind, &self.contact) {
            (OverlapKind::Bodies(_), None) => "move one of them; no contact is defined between the two, so nothing would keep them apart",
            (OverlapKind::Obstacle { whole: true, .. }, _) => {
                "turn it round: the normal of a plane points to where the body is, the points of a polyline have the obstacle on their left"
            }
            _ => {
                "move one of them, press them apart by `sim.settle()` before the first step, or keep the overlap with `accept_overlap: \
                 true` in `simulate`"
            }
        }
    }
}

/// The hull of a body in the plane, the body on the left of its facets.
struct Hull {
    body: usize,
    facets: Vec<[[f64; 2]; 2]>,
    /// How far the curve that each facet stands for may rise above it, and besides a part of the facet.
    allowed: Vec<f64>,
    low: [f64; 2],
    high: [f64; 2],
}

impl Model {
    /// Everything that overlaps in the undeformed bodies, the deepest place of each two; empty for bodies in space.
    pub fn overlaps(&self) -> Vec<Overlap> {
        if self.dimension() != 2 {
            return Vec::new();
        }
        let hulls: Vec<Hull> = (0..self.bodies.len()).map(|body| self.hull(body)).collect();
        let mut found = Vec::new();
        for (index, first) in hulls.iter().enumerate() {
            for second in hulls[index + 1..].iter().filter(|second| first.meets(second)) {
                let inside = [deepest(first, second), deepest(second, first), crossing(first, second)];
                let Some((depth, size, at)) = inside.into_iter().flatten().max_by(|a, b| a.0.total_cmp(&b.0)) else { continue };
                let names = [first.body, second.body].map(|body| self.bodies[body].name.clone());
                let contact = self.between(first.body, second.body);
                found.push(Overlap { kind: OverlapKind::Bodies(names), contact, depth, facets: depth / size, at });
            }
        }
        found.extend(self.obstacle_overlaps());
        found
    }

    fn hull(&self, body: usize) -> Hull {
        let mesh = &self.bodies[body].mesh;
        let point = |node: u32| [mesh.points[node as usize][0], mesh.points[node as usize][1]];
        let ends: Vec<[u32; 2]> = mesh
            .hull()
            .into_iter()
            .map(|facet| {
                let nodes: Vec<u32> = mesh.facet_nodes(facet).collect();
                [nodes[0], nodes[1]]
            })
            .collect();
        let mut before = vec![None; mesh.points.len()];
        ends.iter().enumerate().for_each(|(facet, [_, end])| before[*end as usize] = Some(facet));
        let facets: Vec<[[f64; 2]; 2]> = ends.iter().map(|ends| ends.map(point)).collect();
        let direction = |facet: usize| {
            let [a, b] = facets[facet];
            f64::atan2(b[1] - a[1], b[0] - a[0])
        };
        // The turn at the first node of each facet, and at the last one: that of the facet behind it.
        let turn = |facet: usize| {
            let behind = before[ends[facet][0] as usize]?;
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

    /// The interaction between two bodies.
    fn between(&self, first: usize, second: usize) -> Option<String> {
        let joins = |a: usize, b: usize| {
            let found = self.interactions.iter().find(|one| one.secondary.body == a && one.primary().iter().any(|on| on.body == b));
            found.map(|interaction| interaction.name.clone())
        };
        joins(first, second).or_else(|| joins(second, first))
    }

    /// Boundaries that are inside their rigid obstacles at the start.
    fn obstacle_overlaps(&self) -> Vec<Overlap> {
        let overlap = |interaction: &Interaction| {
            let Partner::Obstacle { shape, motion } = &interaction.partner else { return None };
            let mesh = &self.bodies[interaction.secondary.body].mesh;
            let reference: Vec<f64> = mesh.points.iter().flat_map(|point| [point[0], point[1]]).collect();
            let facets = boundary_facets(self, &interaction.secondary, 0);
            let mut kernel = RigidContact::new(&facets, shape, &reference);
            // A time function that fails does so again, with its error, in the first step.
            let translation = motion.clone().map(|function| function.and_then(|function| function.value(0.0).ok()).unwrap_or(0.0));
            kernel.move_obstacle(&[translation; 3]);
            kernel.update_candidates(&Outlook::within(&reference, 0.0));
            kernel.begin_step(&reference);
            let (gaps, coverage, weights) = (kernel.gap(&reference), kernel.coverage(&reference), kernel.weights());
            let size = kernel.facet_size();
            let covered = || (0..gaps.len()).filter(|&row| coverage[row] > 0.0).map(|row| (gaps[row] / weights[row], row));
            let (least, row) = covered().min_by(|a, b| a.0.total_cmp(&b.0))?;
            let node = 2 * kernel.secondary().nodes()[row] as usize;
            let whole = -least > size && covered().all(|(gap, _)| gap < -ALLOWED * size);
            let kind = OverlapKind::Obstacle { boundary: self.boundary_name(&interaction.secondary), whole };
            let (contact, at) = (Some(interaction.name.clone()), [reference[node], reference[node + 1]]);
            (-least > ALLOWED * size).then(|| Overlap { kind, contact, depth: -least, facets: -least / size, at })
        };
        self.interactions.iter().filter_map(overlap).collect()
    }
}

impl Hull {
    /// Whether the boxes around two hulls overlap.
    fn meets(&self, other: &Hull) -> bool {
        (0..2).all(|i| self.low[i] < other.high[i] && other.low[i] < self.high[i])
    }

    fn contains(&self, [x, y]: [f64; 2]) -> bool {
        let crosses = |[[ax, ay], [bx, by]]: &[[f64; 2]; 2]| (*ay > y) != (*by > y) && x < ax + (y - ay) / (by - ay) * (bx - ax);
        self.facets.iter().filter(|facet| crosses(facet)).count() % 2 == 1
    }
}

/// The deepest node of one hull inside another: depth, size of the facet there, place.
fn deepest(of: &Hull, inside: &Hull) -> Option<(f64, f64, [f64; 2])> {
    let in_box = |x: &[f64; 2]| (0..2).all(|i| inside.low[i] < x[i] && x[i] < inside.high[i]);
    let depth = |(index, [x, _]): (usize, &[[f64; 2]; 2])| {
        let distances = inside.facets.iter().map(|facet| distance(*x, *facet)).enumerate();
        let (nearest, depth) = distances.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let allowed = inside.allowed[nearest] + of.allowed[index];
        (depth > allowed && inside.contains(*x)).then(|| (depth, length(inside.facets[nearest]).min(length(of.facets[index])), *x))
    };
    let found = of.facets.iter().enumerate().filter(|(_, [x, _])| in_box(x)).filter_map(depth);
    found.max_by(|a, b| a.0.total_cmp(&b.0))
}

/// The crossing of two hulls' facets that is farthest from all their nodes: bodies that pass through each other without a node inside.
fn crossing(first: &Hull, second: &Hull) -> Option<(f64, f64, [f64; 2])> {
    let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
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

fn distance(x: [f64; 2], [a, b]: [[f64; 2]; 2]) -> f64 {
    let (along, to) = ([b[0] - a[0], b[1] - a[1]], [x[0] - a[0], x[1] - a[1]]);
    let share = ((along[0] * to[0] + along[1] * to[1]) / (along[0] * along[0] + along[1] * along[1])).clamp(0.0, 1.0);
    (to[0] - share * along[0]).hypot(to[1] - share * along[1])
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::definitions::BodyDefinition;
    use super::super::interactions::{BodyBoundary, Interaction};
    use super::*;
    use crate::contact::Obstacle;
    use crate::materials::NeoHookean;
    use crate::mesh::{Mesh, disk, rectangle, ring};

    fn model(meshes: Vec<Mesh>) -> Model {
        let rubber = NeoHookean { youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 }.material().expect("in range");
        let body = |(k, mesh): (usize, Mesh)| BodyDefinition { name: format!("body {k}"), mesh: Arc::new(mesh), material: rubber.clone() };
        Model { bodies: meshes.into_iter().enumerate().map(body).collect(), ..Model::default() }
    }

    #[test]
    fn overlaps_are_as_deep_as_they_are_and_touching_is_none() {
        let block = |x: f64, y: f64| rectangle([1.0, 1.0], [4, 4], [x, y]).expect("the mesh is sound");
        assert_eq!(model(vec![block(0.0, 0.0), block(1.0, 0.1)]).overlaps(), []);
        let found = model(vec![block(0.0, 0.0), block(0.95, 0.1)]).overlaps();
        assert!(found.len() == 1 && (found[0].depth - 0.05).abs() < 1e-12 && (found[0].facets - 0.2).abs() < 1e-12, "{found:?}");
        assert!(found[0].contact.is_none() && found[0].cure().contains("no contact"));
        // A cross of two bars has no node of one inside the other.
        let bars = [[4.0, 0.3], [0.3, 4.0]].map(|[w, h]| rectangle([w, h], [1, 1], [-0.5 * w, -0.5 * h]).expect("the mesh is sound"));
        let found = model(bars.to_vec()).overlaps();
        assert!(found.len() == 1 && found[0].depth > 0.3, "{found:?}");
        // One inside the other.
        let inner = rectangle([0.2, 0.2], [1, 1], [0.4, 0.4]).expect("the mesh is sound");
        assert_eq!(model(vec![block(0.0, 0.0), inner]).overlaps().len(), 1);
    }

    #[test]
    fn the_rise_of_coarse_curved_sides_is_no_overlap() {
        let race = ring(1.0, 1.5, [2, 14], [0.0; 2], 0.1).expect("the mesh is sound");
        for radius in [0.9, 1.0] {
            let journal = disk(radius, [2, 16], [0.0; 2]).expect("the mesh is sound");
            assert_eq!(model(vec![race.clone(), journal]).overlaps(), [], "{radius}");
        }
        let journal = disk(1.1, [2, 16], [0.0; 2]).expect("the mesh is sound");
        let found = model(vec![race, journal]).overlaps();
        assert!(found.len() == 1 && (found[0].depth - 0.1).abs() < 0.03, "{found:?}");
    }

    #[test]
    fn an_obstacle_that_looks_the_wrong_way_has_all_behind_it() {
        let found = |height: f64, normal: f64| {
            let mut model = model(vec![rectangle([1.0, 1.0], [4, 4], [0.0, 0.0]).expect("the mesh is sound")]);
            let boundary = model.bodies[0].mesh.boundary("bottom").expect("it has one").clone();
            let plane = Obstacle::HalfPlane { point: [0.0, height], normal: [0.0, normal] };
            model.interactions.push(Interaction::obstacle("ground", BodyBoundary { body: 0, boundary }, plane));
            model.overlaps()
        };
        assert_eq!(found(0.0, 1.0), []);
        assert_eq!(found(-0.5, 1.0), []);
        for (height, normal, is_whole) in [(0.1, 1.0, false), (-0.5, -1.0, true)] {
            let found = found(height, normal);
            assert!(matches!(found[..], [Overlap { kind: OverlapKind::Obstacle { whole, .. }, .. }] if whole == is_whole), "{found:?}");
            assert!((found[0].depth - height.abs()).abs() < 1e-12);
        }
    }
}
