//! One random body and one rigid obstacle of a twentieth of a facet to five facets, at rest or moving by up to five facets a step: depth of
//! each in the other, and whether they passed through each other.
//!
//! Evaluated from the positions of the nodes and the prescribed place of the obstacle alone.

use std::f64::consts::TAU;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use conserva::contact::Obstacle;
use conserva::dynamics::{
    Amplitude, BodyBoundary, BodyDefinition, InitialVelocity, Interaction, Model, Options, Partner, Ramp, Simulation, UPDATE_RULES,
    UpdateRule,
};
use conserva::integrators::ENERGY_MOMENTUM;
use conserva::mesh::Boundary;

use super::geometry::{Outline, Point, Segment, add, distance, dot, length, scaled, segments_cross, subtract, turned};
use super::{Body, hull};
use crate::common::{Random, material};

/// Shape of an obstacle around the origin.
#[derive(Clone, Debug, PartialEq)]
pub enum Form {
    /// Bodies are on the side of the normal.
    Plane { normal: Point },
    /// Bodies are outside.
    Disk { radius: f64 },
    /// Corners of a closed polyline, counter-clockwise; bodies are outside.
    Polygon { corners: Vec<Point> },
}

/// All data of a run.
#[derive(Clone, Debug)]
pub struct Case {
    pub seed: u64,
    pub body: Body,
    pub form: Form,
    /// Place of the obstacle at the start, and its velocity.
    pub place: Point,
    pub velocity: Point,
    pub rule: &'static UpdateRule,
    pub dt: f64,
    pub steps: usize,
}

/// Outcome of a case.
#[derive(Clone, Debug, Default)]
pub struct Verdict {
    /// Largest penetration after a step, over the facet concerned.
    pub depth: f64,
    /// Place of the largest penetration.
    pub place: String,
    /// Largest energy defect of a step, over the largest energy.
    pub defect: f64,
    /// True if the body and the obstacle touched.
    pub touched: bool,
    /// Step in which they passed through each other without a contact force.
    pub missed: Option<usize>,
    pub error: Option<String>,
    pub pieces: usize,
    pub iterations: usize,
}

impl Case {
    /// The case of a seed.
    pub fn random(seed: u64) -> Case {
        let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(2011));
        random.below(7);
        let radius = random.between(0.3, 0.8);
        let facet = radius * random.between(0.15, 0.5);
        let mut body = random.body(radius, facet, [1e3, 1e4]);
        let outline = body.outline().expect("generated shapes can be meshed");
        let size = facet * random.magnitude(0.05, 5.0);
        let form = random.form(size);
        let rule = UPDATE_RULES[random.below(UPDATE_RULES.len())];
        // The obstacle approaches from outside; a plane faces the body.
        let towards = match form {
            Form::Plane { normal } => normal,
            _ => random.direction(),
        };
        let aside = scaled(random.between(-0.7, 0.7) * radius, turned(0.25 * TAU, towards));
        let clearance = facet * random.between(0.05, 2.0);
        let mut place = add(scaled(-20.0, towards), aside);
        for _ in 0..300 {
            let left = form.clearance(place, &outline) - clearance;
            if left < 0.02 * clearance || dot(place, towards) > 20.0 {
                break;
            }
            place = add(place, scaled(left, towards));
        }
        let delicate = body.law == "saint_venant_kirchhoff" || matches!(body.shape, super::Shape::Ring { .. });
        let speed = body.wave_speed() * if delicate { 0.05 } else { 0.25 } * random.magnitude(0.04, 1.0);
        let heading = turned(random.between(-0.6, 0.6), towards);
        let (mut velocity, facets) = (scaled(speed, heading), random.magnitude(0.05, 5.0));
        if random.chance(0.4) {
            body.velocity = scaled(-1.0, velocity);
            velocity = [0.0; 2];
            body.spin = if random.chance(0.5) { random.between(-0.5, 0.5) * speed / radius } else { 0.0 };
        }
        let dt = facets * outline.shortest() / speed;
        let steps = ((clearance + 2.0 * radius) / (speed * dt)).ceil() as usize;
        Case { seed, body, form, place, velocity, rule, dt, steps: steps.clamp(4, 60) }
    }

    /// Place of the obstacle at a time.
    fn place_at(&self, time: f64) -> Point {
        add(self.place, scaled(time, self.velocity))
    }

    fn simulation(&self) -> Result<Simulation, String> {
        let mut model = Model { name: format!("obstacle {}", self.seed), ..Model::default() };
        let mut mesh = self.body.mesh().map_err(|error| error.to_string())?;
        let boundary = Boundary::of_facets("hull", mesh.hull());
        mesh.boundaries.push(boundary.clone());
        let definition = BodyDefinition {
            name: "body".into(),
            mesh: Arc::new(mesh),
            material: material(self.body.law, self.body.constants),
            formulation: Default::default(),
            rigid: None,
        };
        model.bodies.push(definition);
        let [x, y] = self.body.velocity;
        model.initial_velocities.push(InitialVelocity { body: 0, linear: [x, y, 0.0], angular: [0.0, 0.0, self.body.spin] });
        let pair = Interaction::obstacle("obstacle", BodyBoundary { body: 0, boundary }, self.form.obstacle(self.place));
        let Partner::Obstacle { shape, .. } = pair.partner else { return Err("no obstacle".into()) };
        let end = 2.0 * self.dt * self.steps as f64;
        let [vx, vy] = self.velocity;
        let motion = [vx, vy, 0.0].map(|v| (v != 0.0).then(|| Arc::new(Ramp { start: 0.0, end, value: v * end }) as Amplitude));
        let partner = Partner::Obstacle { shape, motion, turn: None };
        model.add_interaction(Interaction { update: Some(self.rule), partner, ..pair });
        Simulation::new(&model, Options::new(&ENERGY_MOMENTUM, self.dt)).map_err(|error| error.to_string())
    }

    /// Runs the case.
    pub fn run(&self) -> Verdict {
        let mut verdict = Verdict::default();
        if catch_unwind(AssertUnwindSafe(|| self.take(&mut verdict))).is_err() {
            verdict.error = Some("panicked".into());
        }
        verdict
    }

    fn take(&self, verdict: &mut Verdict) {
        let (mut sim, skin) = match (self.simulation(), Skin::new(&self.body)) {
            (Ok(sim), Some(skin)) => (sim, skin),
            (Err(error), _) => return verdict.error = Some(error),
            _ => return verdict.error = Some("no mesh".into()),
        };
        let mut energy = 0.0f64;
        let mass_speed = |v: &[f64]| v.chunks_exact(2).fold([0.0; 2], |sum, v| add(sum, [v[0], v[1]]));
        for step in 1..=self.steps {
            let before = sim.shared_state();
            let taken = sim.step(None, &mut |row| {
                verdict.pieces += 1;
                verdict.iterations += row.newton_iterations;
                verdict.touched |= row.active > 0;
                verdict.defect = verdict.defect.max(row.energy_defect.abs());
                energy = energy.max(row.kinetic + row.strain);
            });
            if let Err(error) = taken {
                return verdict.error = Some(error.to_string());
            }
            let state = sim.shared_state();
            let (depth, place) = skin.deepest(&state.positions, &self.form, self.place_at(state.row.time));
            if depth > verdict.depth {
                (verdict.depth, verdict.place) = (depth, format!("{place}, step {step} of {}", self.steps));
            }
            // Without contact forces the motion between two steps is known.
            let [old, new] = [&before, &state].map(|state| mass_speed(&state.velocities));
            let rest = length(self.velocity).max(length(self.body.velocity)) * (state.velocities.len() / 2) as f64;
            if length(subtract(new, old)) < 1e-9 * rest && verdict.missed.is_none() {
                let is_inside = (1..40).any(|k| {
                    let s = f64::from(k) / 40.0;
                    let q: Vec<f64> = before.positions.iter().zip(&*state.positions).map(|(a, b)| a + s * (b - a)).collect();
                    let time = before.row.time + s * (state.row.time - before.row.time);
                    skin.deepest(&q, &self.form, self.place_at(time)).0 > 0.15
                });
                verdict.missed = is_inside.then_some(step);
            }
        }
        // With a moving obstacle there is no energy before the first touch.
        verdict.defect /=
            energy.max(1e-12 * self.body.constants[2] * (dot(self.velocity, self.velocity) + dot(self.body.velocity, self.body.velocity)));
    }
}

impl Random {
    fn form(&mut self, size: f64) -> Form {
        match self.below(5) {
            0 => Form::Plane { normal: self.direction() },
            1 | 2 => Form::Disk { radius: size },
            3 => {
                let count = 3 + self.below(6);
                let corner = |k: usize| turned(TAU / count as f64 * (k as f64 + self.between(-0.3, 0.3)), [size, 0.0]);
                Form::Polygon { corners: (0..count).map(corner).collect() }
            }
            _ => {
                let (half, angle) = ([size, size * self.magnitude(0.05, 1.0)], self.between(0.0, TAU));
                let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
                Form::Polygon { corners: corners.map(|[x, y]| turned(angle, [x * half[0], y * half[1]])).into() }
            }
        }
    }
}

impl Form {
    fn sides(corners: &[Point], place: Point) -> Vec<Segment> {
        let at = |k: usize| add(corners[k % corners.len()], place);
        (0..corners.len()).map(|k| [at(k), at(k + 1)]).collect()
    }

    fn obstacle(&self, place: Point) -> Obstacle {
        match self {
            Form::Plane { normal } => Obstacle::HalfPlane { point: place, normal: *normal },
            Form::Disk { radius } => Obstacle::Disk { center: place, radius: *radius },
            Form::Polygon { corners } => {
                let closed = corners.iter().chain(&corners[..1]);
                Obstacle::Polyline { points: closed.map(|&corner| add(corner, place)).collect() }
            }
        }
    }

    fn clearance(&self, place: Point, outline: &Outline) -> f64 {
        match self {
            Form::Plane { normal } => outline.corners().map(|x| dot(*normal, subtract(x, place))).fold(f64::INFINITY, f64::min).max(0.0),
            Form::Disk { radius } => (outline.nearest(place).1 - radius).max(0.0),
            Form::Polygon { corners } => outline.clearance(&Outline::new(Form::sides(corners, place))),
        }
    }
}

/// The hull of a body.
struct Skin {
    facets: Vec<([usize; 2], f64)>,
    /// Nodes, each with its longer facet.
    rim: Vec<(usize, f64)>,
}

impl Skin {
    fn new(body: &Body) -> Option<Skin> {
        let mesh = body.mesh().ok()?;
        let at = |node: usize| super::plane(mesh.points[node]);
        let facets: Vec<_> = hull(&mesh).into_iter().map(|[a, b]| ([a, b], length(subtract(at(b), at(a))))).collect();
        let mut rim: Vec<(usize, f64)> = Vec::new();
        for (&node, size) in facets.iter().flat_map(|(ends, size)| ends.iter().map(move |node| (node, *size))) {
            match rim.iter_mut().find(|(known, _)| *known == node) {
                Some((_, longer)) => *longer = longer.max(size),
                None => rim.push((node, size)),
            }
        }
        Some(Skin { facets, rim })
    }

    /// Largest penetration over the facet concerned, and its place.
    fn deepest(&self, q: &[f64], form: &Form, place: Point) -> (f64, String) {
        let at = |node: usize| [q[2 * node], q[2 * node + 1]];
        let outline = Outline::new(self.facets.iter().map(|(ends, _)| ends.map(at)).collect());
        let mut deepest = (0.0, String::new());
        let mut raise = |depth: f64, size: f64, what: String| {
            if depth / size > deepest.0 {
                deepest = (depth / size, what);
            }
        };
        match form {
            Form::Plane { normal } => {
                for &(node, size) in &self.rim {
                    raise(dot(*normal, subtract(place, at(node))), size, format!("node {node}"));
                }
            }
            Form::Disk { radius } => {
                if outline.holds(place) {
                    let (facet, apart) = outline.nearest(place);
                    raise(radius + apart, self.facets[facet].1, "center".into());
                }
                for (k, (&segment, (_, size))) in outline.segments.iter().zip(&self.facets).enumerate() {
                    raise(radius - distance(place, segment), *size, format!("facet {k}"));
                }
            }
            Form::Polygon { corners } => {
                let sides = Outline::new(Form::sides(corners, place));
                for &(node, size) in self.rim.iter().filter(|&&(node, _)| sides.holds(at(node))) {
                    raise(sides.nearest(at(node)).1, size, format!("node {node}"));
                }
                for corner in sides.corners().filter(|&corner| outline.holds(corner)) {
                    let (facet, depth) = outline.nearest(corner);
                    raise(depth, self.facets[facet].1, format!("corner in facet {facet}"));
                }
                for (k, (&s, (_, size))) in outline.segments.iter().zip(&self.facets).enumerate() {
                    for &t in sides.segments.iter().filter(|&&t| segments_cross(s, t)) {
                        let ends = [distance(s[0], t), distance(s[1], t), distance(t[0], s), distance(t[1], s)];
                        raise(ends.into_iter().fold(f64::INFINITY, f64::min), *size, format!("facet {k} crossed"));
                    }
                }
            }
        }
        deepest
    }
}
