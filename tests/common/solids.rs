//! Random scenes of bodies in space, judged by oracles that call no contact code: energies, momenta, and penetration of points by winding
//! number and distance.
//!
//! A scene has two bodies (boxes, plates, needles, balls, lumps of tetrahedra of any orientation) that are thrown at each other. The far
//! end of the second may be fixed, and gravity may act. A seed gives the same scene with every rule.

// Each program uses a part of this file.
#![allow(dead_code)]

use std::sync::Arc;

use conserva::contact::Coulomb;
use conserva::dynamics::{BodyBoundary, Coefficient, Friction, InitialVelocity, LedgerRow, Model, Options, Simulation, UpdateRule};
use conserva::elements::CellKind;
use conserva::integrators::ENERGY_MOMENTUM;
use conserva::mesh::{Boundary, Mesh, block};

use crate::common::{Random, material};

pub type Point = [f64; 3];

/// Parameters of a scene.
#[derive(Clone, Copy)]
pub struct Scene {
    /// Seed; it gives the same scene for every rule and friction.
    pub seed: u64,
    /// Update rule of the contact.
    pub rule: &'static UpdateRule,
    /// Friction coefficient; 0: none.
    pub friction: f64,
}

/// Results of a run.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Number of steps with contact, and of all steps.
    pub touching: usize,
    pub steps: usize,
    pub iterations: usize,
    pub halvings: usize,
    /// Largest defect of the ledger in a step, energy gained by contact, changes of momenta, each over its scale.
    pub defect: f64,
    pub gain: f64,
    pub momentum: f64,
    /// Largest friction work of a step over the energy scale, which must not be positive, and largest ratio of shear to pressure.
    pub friction: f64,
    pub ratio: f64,
    /// Largest penetration of a point, over the size of the coarser facet.
    pub depth: f64,
    /// Error of a failed step.
    pub failure: Option<String>,
}

fn minus(a: Point, b: Point) -> Point {
    std::array::from_fn(|i| a[i] - b[i])
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(a: Point) -> f64 {
    dot(a, a).sqrt()
}

/// Mesh of a random shape about the origin, and the radius of its enclosing ball.
fn shape(random: &mut Random) -> (Mesh, f64) {
    let kind = (random.between(0.0, 5.0) as usize).min(4);
    let mut size: Point = std::array::from_fn(|_| random.between(0.4, 1.0));
    match kind {
        1 => size[2] = 0.2,
        2 => (size[0], size[1]) = (0.25, 0.25),
        _ => {}
    }
    let cells = size.map(|size| ((size / random.between(0.25, 0.45)).round() as usize).clamp(1, 3));
    let mut mesh = block(size, cells, size.map(|size| -0.5 * size)).expect("the mesh is sound");
    if kind == 3 {
        // A ball: shells of the cube become spheres.
        for x in &mut mesh.points {
            let scaled: Point = std::array::from_fn(|i| 2.0 * x[i] / size[i]);
            let (far, norm) = (scaled.iter().fold(0.0, |far: f64, x| far.max(x.abs())), length(scaled));
            if norm > 0.0 {
                *x = scaled.map(|x| 0.4 * x * (0.6 * far / norm + 0.4 / 3f64.sqrt()));
            }
        }
    }
    if kind == 4 {
        mesh = mesh.with_cells(CellKind::Tet4).expect("hexahedra become tetrahedra");
    }
    turn(&mut mesh, random);
    let radius = mesh.points.iter().map(|x| length(*x)).fold(0.0, f64::max);
    (mesh, radius)
}

/// Rotates a mesh about the origin to a random orientation.
fn turn(mesh: &mut Mesh, random: &mut Random) {
    let quaternion: [f64; 4] = std::array::from_fn(|_| random.next());
    let size = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
    let [w, x, y, z] = quaternion.map(|x| x / size);
    for point in &mut mesh.points {
        let axis = [x, y, z];
        let first = cross(axis, *point);
        let second = cross(axis, std::array::from_fn(|i| first[i] + w * point[i]));
        *point = std::array::from_fn(|i| point[i] + 2.0 * second[i]);
    }
}

/// Model, step size and number of steps of a scene.
pub fn model_of(scene: Scene) -> (Model, f64, usize) {
    let Scene { seed, rule, friction } = scene;
    let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5eed);
    for _ in 0..3 {
        random.next();
    }
    let [(mut flier, own), (target, other)] = [shape(&mut random), shape(&mut random)];
    let away: Point = std::array::from_fn(|_| random.next());
    let away = away.map(|x| x / length(away));
    let aside: Point = std::array::from_fn(|_| 0.4 * other * random.next());
    let across = dot(aside, away);
    let aside: Point = std::array::from_fn(|i| aside[i] - across * away[i]);
    flier.points.iter_mut().for_each(|x| *x = std::array::from_fn(|i| x[i] + (own + other) * 1.02 * away[i] + aside[i]));
    let speed = random.between(0.5, 2.0);
    let mut model = Model::new("solids");
    for (name, mesh) in [("flier", flier), ("target", target)] {
        let modulus = 2e3 * 10f64.powf(random.next());
        let stuff = material("neo_hookean", [modulus, 0.3, 1.0]);
        let mut mesh = mesh;
        let skin = Boundary::of_facets("skin", mesh.hull());
        mesh.boundaries.push(skin);
        model.add_body(name, mesh, &stuff);
    }
    let skin = |body: usize| -> BodyBoundary { model.boundary(body, "skin").expect("it was added") };
    let (secondary, primary) = (skin(0), skin(1));
    let is_held = random.next() > 0.3;
    if is_held {
        let far = |x: &Point| dot(*x, away);
        let least = model.bodies[1].mesh.points.iter().map(far).fold(f64::INFINITY, f64::min);
        let nodes = model.bodies[1].mesh.points.iter().enumerate().filter(|(_, x)| far(x) < least + 0.3 * other);
        let nodes: Vec<Boundary> = nodes.map(|(node, _)| Boundary::of_node(node as u32)).collect();
        model.fix(BodyBoundary { body: 1, boundary: Boundary::union(&nodes) }, [true; 3]);
        if random.next() > 0.0 {
            model.gravity = away.map(|x| -10.0 * x);
        }
    }
    let contact = model.add_contact("touch", secondary, primary);
    contact.update = Some(rule);
    if friction > 0.0 {
        contact.friction = Some(Friction { law: Arc::new(Coulomb::default()), coefficient: Coefficient::Constant(friction) });
    }
    let spin: Point = std::array::from_fn(|_| 3.0 * random.next());
    model.initial_velocities.push(InitialVelocity { body: 0, linear: away.map(|x| -speed * x), angular: spin });
    (model, 0.005, 160)
}

/// Hull of a body as triangles, with four triangles about the center of each facet of four nodes.
pub struct Skin {
    /// Number of the body's first node.
    pub first: usize,
    /// Nodes of every facet in the numbers of the body, counter-clockwise from outside.
    pub facets: Vec<Vec<u32>>,
}

impl Skin {
    fn triangles(&self, q: &[f64]) -> Vec<[Point; 3]> {
        let mut triangles = Vec::new();
        for facet in &self.facets {
            let x: Vec<Point> = facet.iter().map(|&node| self.at(node, q)).collect();
            if let [a, b, c] = x[..] {
                triangles.push([a, b, c]);
                continue;
            }
            let middle = std::array::from_fn(|i| x.iter().map(|x| x[i]).sum::<f64>() / x.len() as f64);
            triangles.extend((0..x.len()).map(|k| [x[k], x[(k + 1) % x.len()], middle]));
        }
        triangles
    }

    fn at(&self, node: u32, q: &[f64]) -> Point {
        std::array::from_fn(|i| q[3 * (self.first + node as usize) + i])
    }

    /// Nodes and points on edges.
    fn points(&self, q: &[f64]) -> Vec<Point> {
        let of_facet = |facet: &Vec<u32>| -> Vec<Point> {
            let side = |k: usize| {
                let [a, b] = [facet[k], facet[(k + 1) % facet.len()]].map(|node| self.at(node, q));
                [0.0, 0.25, 0.5, 0.75].map(|s| std::array::from_fn(|i| a[i] + s * (b[i] - a[i])))
            };
            (0..facet.len()).flat_map(side).collect()
        };
        self.facets.iter().flat_map(of_facet).collect()
    }

    /// Size of the facets.
    pub fn size(&self, q: &[f64]) -> f64 {
        let area: f64 = self.triangles(q).iter().map(|[a, b, c]| 0.5 * length(cross(minus(*b, *a), minus(*c, *a)))).sum();
        (area / self.facets.len() as f64).sqrt()
    }
}

/// Solid angle of a triangle from a point over that of a sphere (Van Oosterom and Strackee, 1983).
fn winding(x: Point, triangle: &[Point; 3]) -> f64 {
    let [a, b, c] = triangle.map(|corner| minus(corner, x));
    let [u, v, w] = [a, b, c].map(length);
    let volume = dot(a, cross(b, c));
    2.0 * volume.atan2(u * v * w + dot(a, b) * w + dot(b, c) * u + dot(c, a) * v) / (4.0 * std::f64::consts::PI)
}

/// Distance of a point from a triangle: from its plane if the foot is inside, else from the nearest side.
fn distance(x: Point, [a, b, c]: &[Point; 3]) -> f64 {
    let normal = cross(minus(*b, *a), minus(*c, *a));
    let size = length(normal);
    let is_left = |from: &Point, to: &Point| dot(normal, cross(minus(*to, *from), minus(x, *from))) >= 0.0;
    if is_left(a, b) && is_left(b, c) && is_left(c, a) {
        return (dot(normal, minus(x, *a)) / size).abs();
    }
    let to_side = |from: &Point, to: &Point| {
        let (along, arm) = (minus(*to, *from), minus(x, *from));
        let s = (dot(along, arm) / dot(along, along)).clamp(0.0, 1.0);
        length(std::array::from_fn(|i| arm[i] - s * along[i]))
    };
    to_side(a, b).min(to_side(b, c)).min(to_side(c, a))
}

/// Largest penetration of a point of one skin in the other.
pub fn deepest(skins: &[Skin; 2], q: &[f64]) -> f64 {
    let mut deepest = 0.0f64;
    for own in 0..2 {
        let triangles = skins[1 - own].triangles(q);
        let bound = |pick: fn(f64, f64) -> f64, from: f64, i: usize| triangles.iter().flatten().fold(from, |best, x| pick(best, x[i]));
        let low: Point = std::array::from_fn(|i| bound(f64::min, f64::INFINITY, i));
        let high: Point = std::array::from_fn(|i| bound(f64::max, f64::NEG_INFINITY, i));
        for x in skins[own].points(q) {
            if (0..3).any(|i| x[i] <= low[i] || x[i] >= high[i]) {
                continue;
            }
            let depth = triangles.iter().map(|triangle| distance(x, triangle)).fold(f64::INFINITY, f64::min);
            if depth > deepest && triangles.iter().map(|triangle| winding(x, triangle)).sum::<f64>() > 0.5 {
                deepest = depth;
            }
        }
    }
    deepest
}

/// Runs a scene to its end or to its failure.
pub fn run(scene: Scene) -> Outcome {
    watched(scene, &mut |_, _| ())
}

/// Runs a scene; `watch` is called at the end of every step with the ledger and the penetration in facets.
pub fn watched(scene: Scene, watch: &mut dyn FnMut(&LedgerRow, f64)) -> Outcome {
    let (model, dt, steps) = model_of(scene);
    let mut outcome = Outcome::default();
    let firsts = [0, model.bodies[0].mesh.points.len()];
    let skins = [0, 1].map(|body| {
        let mesh = &model.bodies[body].mesh;
        Skin { first: firsts[body], facets: mesh.hull().into_iter().map(|facet| mesh.facet_nodes(facet).collect()).collect() }
    });
    let is_free = model.supports.is_empty();
    let gravity = length(model.gravity);
    let mut sim = match Simulation::new(&model, Options::new(&ENERGY_MOMENTUM, dt)) {
        Ok(sim) => sim,
        Err(error) => return Outcome { failure: Some(error.to_string()), ..outcome },
    };
    let start = sim.row().clone();
    let size = skins.iter().map(|skin| skin.size(&sim.shared_state().positions)).fold(0.0, f64::max);
    let energy = start.kinetic.max(if gravity > 0.0 { gravity * (2.0 * start.kinetic).sqrt() * 0.1 } else { 0.0 });
    let momentum = length(start.momentum).max((2.0 * energy).sqrt() * 0.1);
    let keeps_reserve = scene.rule.name == "velocity";
    let mut bound = start.total();
    for _ in 0..steps {
        let mut rows: Vec<LedgerRow> = Vec::new();
        let taken = sim.step(None, &mut |row: &LedgerRow| rows.push(row.clone()));
        for row in &rows {
            outcome.defect = outcome.defect.max(row.energy_defect.abs() / energy);
            let total = row.kinetic + row.strain + row.potential;
            outcome.gain = outcome.gain.max((total - bound) / energy);
            outcome.friction = outcome.friction.max(row.friction_work / energy);
            bound = if keeps_reserve { bound.max(total) } else { bound.min(total) };
            outcome.iterations += row.newton_iterations;
            outcome.halvings += row.halvings;
        }
        if let Err(error) = taken {
            outcome.failure = Some(error.to_string());
            break;
        }
        outcome.steps += 1;
        let row = sim.row();
        outcome.touching += usize::from(row.active > 0);
        let most = sim.friction_multipliers().iter().map(|[pressing, _]| *pressing).fold(0.0, f64::max);
        for [pressing, shear] in sim.friction_multipliers() {
            outcome.ratio = outcome.ratio.max(shear.abs() / pressing.max(1e-6 * most).max(f64::MIN_POSITIVE));
        }
        if is_free {
            let changes = [minus(row.momentum, start.momentum), minus(row.angular_momentum, start.angular_momentum)];
            outcome.momentum = changes.map(|change| length(change) / momentum).into_iter().fold(outcome.momentum, f64::max);
        }
        let depth = deepest(&skins, &sim.shared_state().positions) / size;
        outcome.depth = outcome.depth.max(depth);
        watch(sim.row(), depth);
    }
    outcome
}
