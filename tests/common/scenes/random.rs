//! Generator of scenes; a seed always gives the same scene.
//!
//! Bodies are added one by one: each moves in from far away as far as its clearance from all others permits (steps equal the remaining
//! distance, so bodies cannot pass through another one). Clearances are at most two facets, so that all bodies meet within the run.

use std::f64::consts::TAU;

use conserva::contact::MORTAR;
use conserva::dynamics::GAP;

use super::geometry::{Outline, Point, add, length, scaled, subtract, turned};
use super::{Body, Kind, Scene, Shape, Wall};
use crate::common::Random;

/// Largest speed of bodies over the wave speed of the slowest material: two colliding bodies have half the wave speed together.
const FASTEST: f64 = 0.25;

/// Largest speed for laws that are unsuitable for strong compression and for thin walls that would fold.
const FASTEST_DELICATE: f64 = 0.05;

impl Random {
    /// Random whole number below `count`.
    pub(super) fn below(&mut self, count: usize) -> usize {
        (self.between(0.0, count as f64) as usize).min(count - 1)
    }

    /// Random number, uniform in its logarithm.
    pub(super) fn magnitude(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    pub(super) fn chance(&mut self, probability: f64) -> bool {
        self.between(0.0, 1.0) < probability
    }

    pub(super) fn direction(&mut self) -> Point {
        turned(self.between(0.0, TAU), [1.0, 0.0])
    }

    /// A body around the origin with half its extent, the length of its facets and the range of its modulus.
    pub(super) fn body(&mut self, radius: f64, facet: f64, moduli: [f64; 2]) -> Body {
        let along = |extent: f64| ((extent / facet).round() as usize).clamp(1, 24);
        let shape = match self.below(5) {
            0 => {
                let size = [2.0 * radius * self.between(0.4, 1.0), 2.0 * radius * self.between(0.3, 1.0)];
                Shape::Rectangle { size, cells: size.map(along) }
            }
            1 => {
                let around = 4 * ((TAU * radius / facet / 4.0).round() as usize).clamp(2, 13);
                Shape::Disk { radius, cells: [along(0.4 * radius), around] }
            }
            2 => {
                let inner = radius * self.between(0.4, 0.8);
                let around = ((TAU * radius / facet).round() as usize).clamp(8, 60);
                Shape::Ring { radii: [inner, radius], cells: [along(radius - inner).clamp(1, 4), around] }
            }
            3 => {
                // Equal angles between the corners, each shifted by up to a third: the polygon on the circle is convex.
                let count = 3 + self.below(5);
                let corner = |k: usize| turned(TAU / count as f64 * (k as f64 + self.between(-0.3, 0.3)), [radius, 0.0]);
                Shape::Polygon { corners: (0..count).map(corner).collect(), size: facet.max(0.12 * radius) }
            }
            _ => {
                let (tips, waist) = (3 + self.below(4), radius * self.between(0.35, 0.6));
                let corner = |k: usize| {
                    let angle = TAU / (2 * tips) as f64 * (k as f64 + self.between(-0.2, 0.2));
                    turned(angle, [if k.is_multiple_of(2) { radius * self.between(0.8, 1.0) } else { waist }, 0.0])
                };
                Shape::Polygon { corners: (0..2 * tips).map(corner).collect(), size: facet.max(0.12 * radius) }
            }
        };
        let law = if self.chance(0.8) { "neo_hookean" } else { "saint_venant_kirchhoff" };
        let modulus = self.magnitude(moduli[0], moduli[1]);
        let density = self.between(0.5, 2.0);
        let constants = [modulus, self.between(0.0, 0.45), density];
        let angle = if self.chance(0.8) { self.between(0.0, TAU) } else { 0.0 };
        Body { shape, mirrored: false, angle, center: [0.0; 2], law, constants, velocity: [0.0; 2], spin: 0.0 }
    }
}

impl Scene {
    /// The scene of a seed, with the first method and rule.
    pub fn random(seed: u64) -> Scene {
        // Neighboring seeds of a linear congruential generator give similar first numbers; the product spreads them.
        let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(2007));
        random.below(7);
        let lot = random.between(0.0, 1.0);
        let kind = match lot {
            _ if lot < 0.32 => Kind::Collision,
            _ if lot < 0.40 => Kind::Nested,
            _ if lot < 0.57 => Kind::Box,
            _ if lot < 0.65 => Kind::FiniteCylinder,
            _ if lot < 0.85 => Kind::Fall,
            _ if lot < 0.95 => Kind::Stack,
            _ => Kind::Extreme,
        };
        let scene = Scene {
            seed,
            kind,
            bodies: Vec::new(),
            walls: Vec::new(),
            gravity: [0.0; 2],
            method: &MORTAR,
            rule: &GAP,
            friction: 0.0,
            dt: 0.0,
            steps: 60 + random.below(141),
        };
        let mut draft = Draft { random, scene, outlines: Vec::new() };
        draft.fill();
        draft.set_initial_velocity();
        draft.choose_step();
        let turn = if draft.random.chance(0.3) { draft.random.between(0.0, TAU) } else { 0.0 };
        if turn == 0.0 { draft.scene } else { draft.scene.turned(turn) }
    }
}

/// Scene under construction.
struct Draft {
    random: Random,
    scene: Scene,
    outlines: Vec<Outline>,
}

impl Draft {
    /// Adds the bodies and walls of the kind of scene.
    fn fill(&mut self) {
        match self.scene.kind {
            Kind::Collision => self.cluster(2, 6),
            Kind::Nested => {
                self.cluster(1, 3);
                self.enclose();
            }
            Kind::Box => {
                self.cluster(1, 5);
                self.box_in();
            }
            Kind::FiniteCylinder => {
                self.cluster(1, 4);
                let (center, radius) = self.circle();
                let clearance = self.random.between(0.02, 0.2);
                self.scene.walls.push(Wall::Ring { center, radius: radius + clearance });
            }
            Kind::Fall => self.drop_on_ground(),
            Kind::Stack => self.stack(),
            Kind::Extreme => self.cluster(2, 3),
        }
    }

    /// Adds bodies around the first one.
    fn cluster(&mut self, least: usize, most: usize) {
        let count = least + self.random.below(most - least + 1);
        for k in 0..count {
            let (radius, facet) = match (self.scene.kind, k) {
                (Kind::Extreme, 0) => (1.0, self.random.between(0.3, 0.5)),
                (Kind::Extreme, _) => {
                    let ratio = self.random.magnitude(2.0, 20.0);
                    (4.0 / ratio.max(8.0), 0.4 / ratio)
                }
                _ => self.size(),
            };
            let body = self.body(radius, facet);
            let direction = self.random.direction();
            let clearance = facet * self.random.between(0.05, 2.0);
            if k == 0 {
                self.put(body, [0.0; 2]);
            } else {
                self.fly_in(body, scaled(20.0, direction), scaled(-1.0, direction), clearance);
            }
        }
    }

    /// Half the extent of a body, and the length of its facets.
    fn size(&mut self) -> (f64, f64) {
        let radius = self.random.between(0.3, 0.8);
        (radius, radius * self.random.between(0.2, 0.5))
    }

    /// A body around the origin.
    fn body(&mut self, radius: f64, facet: f64) -> Body {
        let moduli = if self.scene.kind == Kind::Extreme { [1e2, 1e8] } else { [1e3, 1e4] };
        self.random.body(radius, facet, moduli)
    }

    /// Adds a body at a place.
    fn put(&mut self, mut body: Body, center: Point) {
        body.center = center;
        self.outlines.push(body.outline().expect("generated shapes can be meshed"));
        self.scene.bodies.push(body);
    }

    /// Distance from all bodies and walls so far.
    fn clearance(&self, outline: &Outline) -> f64 {
        let bodies = self.outlines.iter().map(|other| outline.clearance(other));
        bodies.chain(self.scene.walls.iter().map(|wall| wall.clearance(outline))).fold(f64::INFINITY, f64::min)
    }

    /// Moves a body from a place along a direction until it reaches a clearance from another object.
    fn fly_in(&mut self, body: Body, start: Point, direction: Point, clearance: f64) {
        let outline = body.outline().expect("generated shapes can be meshed");
        let mut traveled = 0.0;
        for _ in 0..300 {
            let left = self.clearance(&outline.moved(add(start, scaled(traveled, direction)))) - clearance;
            if left < 0.02 * clearance {
                break;
            }
            traveled += left;
        }
        self.put(body, add(start, scaled(traveled, direction)));
    }

    /// Smallest and largest coordinates of all bodies.
    fn bounds(&self) -> [Point; 2] {
        let corners: Vec<_> = self.outlines.iter().flat_map(Outline::corners).map(|x| [x, x]).collect();
        Outline::new(corners).bounds
    }

    /// A circle around all bodies.
    fn circle(&self) -> (Point, f64) {
        let [low, high] = self.bounds();
        let center = scaled(0.5, add(low, high));
        let radius = self.outlines.iter().flat_map(Outline::corners).map(|x| length(subtract(x, center))).fold(0.0, f64::max);
        (center, radius)
    }

    /// Adds a deformable ring around all bodies.
    fn enclose(&mut self) {
        let (center, radius) = self.circle();
        let around = 16 + self.random.below(33);
        // The chords of the inner side are nearer to the center than its nodes.
        let inner = (radius + self.random.between(0.02, 0.2)) / (0.5 * TAU / around as f64).cos();
        let outer = inner * self.random.between(1.15, 1.5);
        let mut body = self.body(1.0, 0.5);
        body.shape = Shape::Ring { radii: [inner, outer], cells: [1 + self.random.below(3), around] };
        self.put(body, center);
    }

    /// Adds four planes around all bodies.
    fn box_in(&mut self) {
        let [low, high] = self.bounds();
        for (corner, normal) in [(low, [1.0, 0.0]), (low, [0.0, 1.0]), (high, [-1.0, 0.0]), (high, [0.0, -1.0])] {
            let clearance = self.random.magnitude(0.005, 0.2);
            self.scene.walls.push(Wall::Plane { point: subtract(corner, scaled(clearance, normal)), normal });
        }
    }

    /// Adds a wall and the bodies that fall on it.
    fn drop_on_ground(&mut self) {
        let ground = match self.random.below(4) {
            0 => Wall::Plane { point: [0.0; 2], normal: [0.0, 1.0] },
            1 => Wall::Plane { point: [0.0; 2], normal: [self.random.between(-0.5, 0.5), 1.0] },
            2 => {
                let radius = self.random.between(0.3, 2.0);
                Wall::Disk { center: [0.0, -radius], radius }
            }
            _ => {
                let (mut points, mut x) = (vec![[12.0, 0.0]], 6.0);
                while x > -6.0 {
                    points.push([x, self.random.between(-0.4, 0.4)]);
                    x -= self.random.between(0.3, 1.2);
                }
                points.push([-12.0, 0.0]);
                Wall::Polyline { points }
            }
        };
        self.scene.walls.push(ground);
        for _ in 0..1 + self.random.below(4) {
            let (radius, facet) = self.size();
            let body = self.body(radius, facet);
            let (x, clearance) = (self.random.between(-0.6, 0.6), facet * self.random.between(0.05, 1.5));
            // Every body meets the disk, so that no body falls forever.
            let x = if matches!(self.scene.walls[0], Wall::Disk { .. }) { 0.3 * x } else { x };
            self.fly_in(body, [x, 20.0], [0.0, -1.0], clearance);
        }
        self.weigh();
    }

    /// Gravity with which a body that falls by one reaches a random fraction of the wave speed.
    fn weigh(&mut self) {
        let speed = self.slowest() * self.random.magnitude(0.01, 0.15);
        self.scene.gravity = [0.0, -0.5 * speed * speed];
    }

    /// Adds bodies one on another on a plane, with small gaps.
    fn stack(&mut self) {
        self.scene.walls.push(Wall::Plane { point: [0.0; 2], normal: [0.0, 1.0] });
        let count = 2 + self.random.below(4);
        let aligned = self.random.chance(0.3);
        for k in 0..count {
            let (radius, facet) = self.size();
            let mut body = self.body(radius, facet);
            let size = [2.0 * radius * self.random.between(0.7, 1.2), radius * self.random.between(0.5, 1.2)];
            let cells = size.map(|extent| ((extent / facet).round() as usize).max(1));
            if k + 1 < count || self.random.chance(0.6) {
                (body.shape, body.angle) = (Shape::Rectangle { size, cells }, 0.0);
            }
            let x = if aligned { 0.0 } else { self.random.between(-0.3, 0.3) * radius };
            let clearance = facet * self.random.magnitude(1e-3, 0.1);
            self.fly_in(body, [x, 20.0], [0.0, -1.0], clearance);
        }
        let [low, high] = self.bounds();
        let stress = self.random.magnitude(1e-4, 1e-2) * self.scene.bodies.iter().map(|body| body.constants[0]).fold(f64::MAX, f64::min);
        self.scene.gravity = [0.0, -stress / (high[1] - low[1])];
    }

    /// Wave speed of the slowest material.
    fn slowest(&self) -> f64 {
        self.scene.bodies.iter().map(Body::wave_speed).fold(f64::INFINITY, f64::min)
    }

    /// True if the scene has a law or a shape that is unsuitable for a strong impact.
    fn is_delicate(&self) -> bool {
        let delicate = |body: &Body| body.law == "saint_venant_kirchhoff" || matches!(body.shape, Shape::Ring { .. });
        self.scene.bodies.iter().any(delicate)
    }

    /// Sets random velocities and spins.
    fn set_initial_velocity(&mut self) {
        if self.scene.kind == Kind::Stack {
            return;
        }
        let limit = self.slowest() * if self.is_delicate() { FASTEST_DELICATE } else { FASTEST };
        let speed = limit * self.random.magnitude(0.04, 1.0);
        let (center, _) = self.circle();
        if self.scene.kind == Kind::FiniteCylinder && self.random.chance(0.5) {
            self.weigh();
        }
        let still = self.scene.kind == Kind::Fall && self.random.chance(0.5);
        for k in 0..self.scene.bodies.len() {
            let share = self.random.between(0.3, 1.0) * speed;
            let inwards = subtract(center, self.scene.bodies[k].center);
            let heading = match self.scene.kind {
                Kind::Collision | Kind::Extreme if k > 0 && length(inwards) > 0.0 => {
                    turned(self.random.between(-0.6, 0.6), scaled(1.0 / length(inwards), inwards))
                }
                Kind::Fall => turned(self.random.between(-1.0, 1.0), [0.0, -1.0]),
                _ => self.random.direction(),
            };
            let spins = self.random.chance(0.5);
            let [low, high] = self.outlines[k].bounds;
            let rim = self.random.between(-0.5, 0.5) * speed;
            if !still {
                self.scene.bodies[k].velocity = scaled(share, heading);
                self.scene.bodies[k].spin = if spins { 2.0 * rim / length(subtract(high, low)) } else { 0.0 };
            }
        }
    }

    /// Step size with which the fastest relative motion is a random fraction of the smallest facet per step.
    fn choose_step(&mut self) {
        let facet = self.outlines.iter().map(Outline::shortest).fold(f64::INFINITY, f64::min);
        let extent = |k: usize| 0.5 * length(subtract(self.outlines[k].bounds[1], self.outlines[k].bounds[0]));
        let bodies = self.scene.bodies.iter().enumerate();
        let mut speeds: Vec<f64> = bodies.map(|(k, body)| length(body.velocity) + body.spin.abs() * extent(k)).collect();
        speeds.sort_by(f64::total_cmp);
        let closing: f64 = speeds.iter().rev().take(2).sum();
        let drop = if self.scene.kind == Kind::Stack { facet } else { 0.5 };
        let fastest = closing + (2.0 * self.scene.gravity_size() * drop).sqrt();
        self.scene.dt = self.random.between(0.05, 0.5) * facet / fastest;
    }
}
