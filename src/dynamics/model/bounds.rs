//! Rigid obstacles as bounds of whole bodies: parts of a body outside the contact definition would pass through an obstacle unhindered.
//!
//! Before the first step the secondary surface must face its obstacle. During a run penetration is checked at all points of the hull
//! outside of the obstacle's secondary surfaces. An obstacle that the hull penetrates deeply at the start bounds its secondary surface
//! only, like a plane that stops a flange but not the shaft.

use serde::{Deserialize, Serialize};

use super::amplitude::Amplitude;
use super::definitions::Model;
use super::hulls::ALLOWED;
use super::interactions::{Interaction, ObstacleRotation, Partner, obstacle_place};
use crate::contact::{Clearance, Finding, NamedSurface, Nearest, Obstacle, Surface, looks_away};
use crate::math::tolerances::DEPTH;
use crate::mesh::{Mesh, is_inside};

/// Depth of a facet's middle in an obstacle, in shortest edges of the facet, from which the obstacle counts as having passed between nodes:
/// above the sagitta of a facet on an obstacle of its own size.
const PASSED: f64 = 0.25;

/// Penetration at the start, in shortest edges, up to which an obstacle bounds a hull: less is an overlap by mistake.
const SLIGHT: f64 = 0.25;

/// Rigid obstacles, with the hulls of the bodies that must not penetrate them.
pub struct ObstacleBounds {
    bounds: Vec<Bound>,
}

struct Bound {
    contact: String,
    body: String,
    obstacle: Clearance,
    motion: [Option<Amplitude>; 3],
    turn: Option<ObstacleRotation>,
    dimension: usize,
    /// Number of the body's first node in the model.
    first: usize,
    nodes: usize,
    /// Flat parts of the hull, by node numbers of the body.
    pieces: Vec<Vec<u32>>,
    /// Nodes of the hull outside of all secondary surfaces of this obstacle, with the length of their shortest edge `[length]`.
    free: Vec<(u32, f64)>,
    /// True for every node on a secondary surface.
    is_named: Vec<bool>,
    /// Penetration at the start, in shortest edges.
    at_start: f64,
}

/// Body inside a rigid obstacle, at the deepest point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodyPastObstacle {
    /// Name of the contact with the obstacle.
    pub contact: String,
    /// Name of the body.
    pub body: String,
    /// Penetration relative to the length of the shortest edge at that point.
    pub facets: f64,
    /// Position of the deepest point, with one coordinate per dimension.
    pub at: Vec<f64>,
    /// Number of the step.
    pub step: usize,
    /// Time `[time]`.
    pub time: f64,
}

impl ObstacleBounds {
    /// Obstacles of a model that no hull penetrates by more than [`SLIGHT`] at the start.
    pub fn of(model: &Model) -> ObstacleBounds {
        let dimension = model.dimension();
        let mut firsts = vec![0];
        model.bodies.iter().for_each(|body| firsts.push(firsts[firsts.len() - 1] + body.mesh.points.len()));
        let mut known: Vec<(usize, &Obstacle)> = Vec::new();
        let mut bounds = Vec::new();
        for interaction in &model.interactions {
            let Partner::Obstacle { shape, motion, turn } = &interaction.partner else { continue };
            let body = interaction.secondary.body;
            if known.contains(&(body, shape)) {
                continue;
            }
            known.push((body, shape));
            let mesh = &model.bodies[body].mesh;
            let mut is_named = vec![false; mesh.points.len()];
            for other in model.interactions.iter().filter(|other| other.secondary.body == body) {
                if matches!(&other.partner, Partner::Obstacle { shape: of, .. } if of == shape) {
                    let facets = &other.secondary.boundary.facets;
                    facets.iter().flat_map(|&facet| mesh.facet_nodes(facet)).for_each(|node| is_named[node as usize] = true);
                }
            }
            let pieces = hull_pieces(mesh);
            let start = model.start(body);
            let mut sizes = vec![f64::INFINITY; mesh.points.len()];
            for piece in &pieces {
                let length = |k: usize| distance(start[piece[k] as usize], start[piece[(k + 1) % piece.len()] as usize]);
                let shortest = (0..piece.len()).map(length).fold(f64::INFINITY, f64::min);
                piece.iter().for_each(|&node| sizes[node as usize] = sizes[node as usize].min(shortest));
            }
            let of_hull = (0u32..).zip(&sizes).filter(|&(node, size)| size.is_finite() && !is_named[node as usize]);
            let mut bound = Bound {
                contact: interaction.name.clone(),
                body: model.bodies[body].name.clone(),
                obstacle: Clearance::new(shape),
                motion: motion.clone(),
                turn: turn.clone(),
                dimension,
                first: firsts[body],
                nodes: mesh.points.len(),
                free: of_hull.map(|(node, &size)| (node, size)).collect(),
                pieces,
                is_named,
                at_start: 0.0,
            };
            let at: Vec<f64> = start.iter().flat_map(|point| &point[..dimension]).copied().collect();
            bound.at_start = bound.deepest(&at, 0.0, ALLOWED).map_or(0.0, |(facets, _)| facets);
            if !bound.free.is_empty() && bound.at_start <= SLIGHT {
                bounds.push(bound);
            }
        }
        ObstacleBounds { bounds }
    }

    /// True if no obstacle bounds a body.
    pub fn is_empty(&self) -> bool {
        self.bounds.is_empty()
    }

    /// Body with the deepest penetration of an obstacle, in facets, for node positions `q` and obstacles at time `time`.
    pub fn deepest(&self, q: &[f64], time: f64, step: usize) -> Option<BodyPastObstacle> {
        let of = |bound: &Bound| {
            let own = &q[bound.dimension * bound.first..bound.dimension * (bound.first + bound.nodes)];
            let (facets, at) = bound.deepest(own, time, DEPTH).filter(|(facets, _)| *facets > bound.at_start + DEPTH)?;
            let (contact, body) = (bound.contact.clone(), bound.body.clone());
            Some(BodyPastObstacle { contact, body, facets, at: at[..bound.dimension].to_vec(), step, time })
        };
        self.bounds.iter().filter_map(of).max_by(|a, b| a.facets.total_cmp(&b.facets))
    }
}

impl Bound {
    /// Deepest point of the hull, if deeper than `allowed`: depth in facets and position.
    fn deepest(&self, q: &[f64], time: f64, allowed: f64) -> Option<(f64, [f64; 3])> {
        let place = obstacle_place(&self.motion, self.turn.as_ref(), time);
        let at = |node: u32| {
            place.in_frame(std::array::from_fn(|i| if i < self.dimension { q[self.dimension * node as usize + i] } else { 0.0 }))
        };
        let mut found: Option<(f64, [f64; 3])> = None;
        let mut add = |facets: f64, x: [f64; 3]| {
            if found.is_none_or(|(most, _)| facets > most) {
                found = Some((facets, place.point(x)));
            }
        };
        if self.obstacle.is_open() {
            self.crossings(&at, allowed, &mut add);
            return found;
        }
        for &(node, size) in &self.free {
            let x = at(node);
            let Nearest { gap, covered, .. } = self.obstacle.at(x);
            if covered && gap < -allowed * size {
                add(-gap / size, x);
            }
        }
        // An obstacle smaller than a facet can pass between the nodes, so that middles of facets are checked, too.
        for piece in self.pieces.iter().filter(|piece| piece.iter().any(|&node| !self.is_named[node as usize])) {
            let corners: Vec<[f64; 3]> = piece.iter().map(|&node| at(node)).collect();
            let middle = mean(&corners);
            let Nearest { gap, covered, .. } = self.obstacle.at(middle);
            if !covered || gap >= 0.0 {
                continue;
            }
            let size = (0..corners.len()).map(|k| distance(corners[k], corners[(k + 1) % corners.len()])).fold(f64::INFINITY, f64::min);
            if gap < -PASSED * size {
                add(-gap / size, middle);
            }
        }
        let center = mean(&self.free.iter().map(|&(node, _)| at(node)).collect::<Vec<_>>());
        for point in self.obstacle.inner_points(center) {
            if self.contains(point, &at) {
                let nearest = self.free.iter().min_by(|a, b| distance(at(a.0), point).total_cmp(&distance(at(b.0), point)));
                let size = nearest.map_or(1.0, |(_, size)| *size);
                add((-self.obstacle.at(point).gap / size).max(PASSED), point);
            }
        }
        found
    }

    /// Adds edges of the hull that cross an open surface, from a node in front of it to a node behind it outside of the secondary surfaces.
    fn crossings(&self, at: &dyn Fn(u32) -> [f64; 3], allowed: f64, add: &mut dyn FnMut(f64, [f64; 3])) {
        for piece in &self.pieces {
            let ends = (0..piece.len()).map(|k| [piece[k], piece[(k + 1) % piece.len()]]);
            for [front, behind] in ends.flat_map(|[a, b]| [[a, b], [b, a]]) {
                if self.is_named[behind as usize] {
                    continue;
                }
                let (x, y) = (at(behind), at(front));
                let [own, other] = [x, y].map(|x| self.obstacle.at(x));
                let size = distance(x, y);
                if own.covered && own.gap < -allowed * size && other.gap > 0.0 && self.obstacle.is_crossed(y, x) {
                    add(-own.gap / size, x);
                }
            }
        }
    }

    /// True if a point is inside the hull.
    fn contains(&self, x: [f64; 3], at: &dyn Fn(u32) -> [f64; 3]) -> bool {
        if self.dimension == 2 {
            let ends = self.pieces.iter().map(|piece| [piece[0], piece[1]].map(at).map(|[x, y, _]| [x, y]));
            return is_inside(ends, [x[0], x[1]]);
        }
        // Solid angle of the hull as seen from the point (van Oosterom and Strackee, IEEE TBME 30, 1983).
        let mut sum = 0.0;
        for piece in &self.pieces {
            for k in 1..piece.len() - 1 {
                let [a, b, c] =
                    [piece[0], piece[k], piece[k + 1]].map(|node| nalgebra::Vector3::from(at(node)) - nalgebra::Vector3::from(x));
                let (p, q, r) = (a.norm(), b.norm(), c.norm());
                let over = a.dot(&b.cross(&c));
                let under = p * q * r + a.dot(&b) * r + b.dot(&c) * p + c.dot(&a) * q;
                sum += 2.0 * over.atan2(under);
            }
        }
        sum > std::f64::consts::TAU
    }
}

impl Model {
    /// Finding for a secondary surface that faces away from its rigid obstacle; `None` also for surfaces that may rotate or move towards
    /// it.
    pub(super) fn away_from_obstacle(&self, interaction: &Interaction) -> Option<Finding> {
        let Partner::Obstacle { shape, motion, turn } = &interaction.partner else { return None };
        let (on, dimension) = (&interaction.secondary, self.dimension());
        let body = on.body;
        let turns = self.prescriptions.iter().any(|given| given.on.body == body && given.turn.is_some())
            || self.initial_velocities.iter().any(|given| given.body == body && given.angular != [0.0; 3]);
        let moves = self.prescriptions.iter().any(|given| given.on.body == body)
            || self.initial_velocities.iter().any(|given| given.body == body && given.linear != [0.0; 3])
            || motion.iter().any(Option::is_some);
        let is_flat = matches!(shape, Obstacle::HalfPlane { .. } | Obstacle::InSpace(crate::contact::ObstacleInSpace::Plane { .. }));
        let tilts = turn.as_ref().is_some_and(|turn| turn.about.is_some());
        if turns || tilts || (moves && !is_flat) || self.is_guided(on, &[]) {
            return None;
        }
        let mesh = &self.bodies[body].mesh;
        let q: Vec<f64> = self.start(body).iter().flat_map(|point| &point[..dimension]).copied().collect();
        let surface = if dimension == 2 {
            let pieces: Vec<[u32; 2]> = on.boundary.facets.iter().flat_map(|&facet| mesh.straight_pieces(facet)).collect();
            Surface::new(&pieces)
        } else {
            let pieces: Vec<Vec<u32>> = on.boundary.facets.iter().flat_map(|&facet| mesh.flat_pieces(facet)).collect();
            Surface::in_space(pieces.iter().map(|piece| &piece[..]))
        };
        let shift = motion.each_ref().map(|motion| motion.as_ref().and_then(|motion| motion.value(0.0).ok()).unwrap_or(0.0));
        let name = self.boundary_name(on);
        looks_away(NamedSurface { name: &name, surface: &surface }, &Clearance::new(shape), shift, &q)
    }
}

/// Flat or straight parts of the hull of a mesh.
fn hull_pieces(mesh: &Mesh) -> Vec<Vec<u32>> {
    if mesh.dimension() == 2 {
        return mesh.outline().iter().map(|ends| ends.to_vec()).collect();
    }
    mesh.hull().into_iter().flat_map(|facet| mesh.flat_pieces(facet)).collect()
}

fn mean(points: &[[f64; 3]]) -> [f64; 3] {
    let count = points.len() as f64;
    points.iter().fold([0.0; 3], |sum, x| std::array::from_fn(|i| sum[i] + x[i] / count))
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}
