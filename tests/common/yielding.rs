//! Random impacts of elastic-plastic bodies, in the plane, axisymmetric and in space, against each other and rigid obstacles: ledger of
//! every step, momenta, heat that never decreases, energy that never grows.
//!
//! A seed always gives the same scene: shapes, cells, law, speeds, update rule and contact method.

// Each test program uses a part of this file.
#![allow(dead_code)]

use std::f64::consts::PI;
use std::panic::{AssertUnwindSafe, catch_unwind};

use conserva::bodies::{Dilatation, Formulation, Plane};
use conserva::contact::{METHODS, Obstacle, ObstacleInSpace};
use conserva::dynamics::{Interaction, LedgerRow, Model, Options, Partner, Simulation, UPDATE_RULES};
use conserva::elements::CellKind;
use conserva::integrators::ENERGY_MOMENTUM;
use conserva::materials::{BackStress, ElasticPlastic, Hardening, Material, RateDependence};
use conserva::mesh::{Boundary, Mesh, block, disk, rectangle};

use crate::common::Random;

/// Largest defect of the ledger and largest change of the momenta in a step, over their scales.
pub const DEFECT: f64 = 1e-11;

/// Largest growth of the energy over its scale: round-off and Newton's tolerance of 1e-13 in each step.
pub const GAIN: f64 = 1e-11;

/// Dimension of a scene, with its assumption in the plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    Plane(Plane),
    Space,
}

/// Results of a run; energies over the energy at the start.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    pub place: Option<Place>,
    /// Description of the scene.
    pub title: String,
    pub steps: usize,
    pub touching: usize,
    pub iterations: usize,
    pub halvings: usize,
    /// Largest defect of the ledger in a step.
    pub defect: f64,
    /// Largest unexplained change of momenta in a step, over the momentum of the faster body.
    pub momentum: f64,
    /// Largest growth of kinetic, stored and potential energy above the smallest value so far (with `velocity` the largest).
    pub gain: f64,
    /// Largest decrease of the heat of a body in a step.
    pub cooled: f64,
    /// Heat at the end.
    pub heat: f64,
    pub failure: Option<String>,
}

impl Outcome {
    /// Violations of the bounds in any accepted step; empty without violations.
    pub fn faults(&self) -> String {
        let limits = [("defect", self.defect, DEFECT), ("momentum", self.momentum, DEFECT), ("gain", self.gain, GAIN)];
        let mut found: Vec<String> =
            limits.into_iter().filter(|(_, value, most)| value.is_nan() || value > most).map(|(n, v, _)| format!("{n} {v:.1e}")).collect();
        if self.cooled > 0.0 {
            found.push(format!("heat falls by {:.1e}", self.cooled));
        }
        found.join(", ")
    }
}

fn pick<T: Clone>(random: &mut Random, from: &[T]) -> T {
    let number = random.between(0.0, from.len() as f64) as usize;
    from[number.min(from.len() - 1)].clone()
}

/// A law with any hardening, without rate dependence, with which the heat may decrease in a large step.
fn law(random: &mut Random) -> ElasticPlastic {
    let modulus = 10f64.powf(random.between(2.5, 4.0));
    let yield_stress = modulus * 10f64.powf(random.between(-2.7, -1.5));
    let hardenings = [
        Hardening::NONE,
        Hardening::Saturating { modulus: 0.05 * modulus, saturation: 0.0, exponent: 0.0 },
        Hardening::Saturating { modulus: 0.0, saturation: 0.5 * yield_stress, exponent: 20.0 },
        Hardening::Swift { strain: 0.01, exponent: 0.2 },
        Hardening::Ludwik { modulus: yield_stress, exponent: 0.4 },
        Hardening::Table(vec![[0.0, yield_stress], [0.05, 1.3 * yield_stress], [0.3, 1.5 * yield_stress]]),
    ];
    let back = [
        vec![],
        vec![BackStress { modulus: 0.05 * modulus, recovery: 0.0 }],
        vec![BackStress { modulus: 0.1 * modulus, recovery: 20.0 }, BackStress { modulus: 0.01 * modulus, recovery: 0.0 }],
    ];
    ElasticPlastic {
        youngs_modulus: modulus,
        poisson_ratio: random.between(0.1, 0.45),
        density: 1.0,
        yield_stress,
        hardening: pick(random, &hardenings),
        back_stresses: pick(random, &back),
        rate: RateDependence::None,
    }
}

/// A body of size 1 about the origin; for a body of revolution the right half.
fn shape(random: &mut Random, place: Place) -> Mesh {
    let mut count = |most: f64| random.between(1.5, most) as usize;
    let (wide, high, deep) = (count(4.9), count(4.9), count(2.9));
    let mesh = match place {
        Place::Space => block([1.0, 1.0, 0.8], [wide.min(3), high.min(3), deep], [-0.5, -0.5, -0.4]),
        Place::Plane(Plane::Axisymmetric) => rectangle([0.5, 1.0], [wide, high], [if random.next() > 0.0 { 0.0 } else { 0.4 }, -0.5]),
        Place::Plane(_) if random.next() > 0.0 => disk(0.5, [2, 12], [0.0; 2]),
        Place::Plane(_) => rectangle([1.0, 0.8], [wide, high], [-0.5, -0.4]),
    };
    let kinds: &[CellKind] = if place == Place::Space {
        &[CellKind::Hex8, CellKind::Hex8, CellKind::Hex8, CellKind::Tet10]
    } else {
        &[CellKind::Quad4, CellKind::Quad4, CellKind::Quad8, CellKind::Quad9, CellKind::Tri6]
    };
    let mesh = mesh.expect("the mesh is sound");
    let kind = pick(random, kinds);
    if mesh.only_kind() == Some(kind) { mesh } else { mesh.with_cells(kind).expect("cells become others") }
}

/// Scene of a seed: model, step size, number of steps, formulation and description.
pub fn model_of(seed: u64) -> (Model, f64, usize, Place, String) {
    let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x71e1d);
    (0..3).for_each(|_| _ = random.next());
    let random = &mut random;
    let places = [Place::Plane(Plane::Strain), Place::Plane(Plane::Stress), Place::Plane(Plane::Axisymmetric), Place::Space];
    let place = places[(seed % 4) as usize];
    let is_round = place == Place::Plane(Plane::Axisymmetric);
    let has_partner = random.next() > 0.0;
    let mut model = Model::new("yielding");
    let (mut speed, mut facet, mut title) = (f64::INFINITY, f64::INFINITY, format!("{place:?}"));
    // A body of revolution moves along its axis.
    let angle = if is_round { 0.0 } else { random.between(-0.5, 0.5) };
    for number in 0..if has_partner { 2 } else { 1 } {
        let mut mesh = shape(random, place);
        let turn = if is_round { 0.0 } else { random.between(-PI, PI) };
        let (s, c) = turn.sin_cos();
        let away = if number == 0 { 0.0 } else { -1.45 };
        let aside = if is_round || number == 0 { 0.0 } else { random.between(-0.3, 0.3) };
        for point in &mut mesh.points {
            let [x, y, z] = *point;
            *point = [c * x - s * y + aside, s * x + c * y + away, z];
        }
        mesh.boundaries.push(Boundary::of_facets("hull", mesh.hull()));
        let constants = law(random);
        // The yield stress over the impedance is the impact speed at which a bar yields.
        let stiff = (constants.youngs_modulus * constants.density).sqrt();
        // Up to a fifth of the speed of sound: faster impacts crush cells.
        let own = constants.yield_stress / stiff * 10f64.powf(random.between(0.5, 1.5));
        speed = speed.min(own.min(0.2 * stiff));
        facet = facet.min(1.0 / (mesh.points.len() as f64).powf(1.0 / mesh.dimension() as f64));
        title +=
            &format!(", {} {:?} {:?} {} back", mesh.kind_names(), mesh.points.len(), constants.hardening, constants.back_stresses.len());
        let kind = mesh.blocks[0].kind;
        let body = model.add_body(&format!("body {number}"), mesh, &Material::elastic_plastic(&constants).expect("constants are sound"));
        let plane = if let Place::Plane(plane) = place { plane } else { Plane::Strain };
        let is_free = plane == Plane::Stress || matches!(kind, CellKind::Tet10 | CellKind::Tri6);
        let dilatation = if is_free { Dilatation::Pointwise } else { Dilatation::Mean };
        model.bodies[body].formulation = Formulation { plane, dilatation };
        if is_round {
            let axis: Vec<Boundary> = (model.bodies[body].mesh.points.iter().enumerate())
                .filter(|(_, x)| x[0].abs() < 1e-9)
                .map(|(node, _)| Boundary::of_node(node as u32))
                .collect();
            if !axis.is_empty() {
                let on = conserva::dynamics::BodyBoundary { body, boundary: Boundary::union(&axis) };
                model.fix(on, [true, false, false]);
            }
        }
    }
    let hull = |model: &Model, body: usize| model.boundary(body, "hull").expect("it was added");
    let rule = pick(random, UPDATE_RULES);
    let methods: Vec<_> = METHODS.iter().copied().filter(|method| place != Place::Space || method.in_space.is_some()).collect();
    let method = pick(random, &methods);
    let pair = if has_partner {
        let (secondary, primary) = (hull(&model, 0), hull(&model, 1));
        Interaction { method, ..Interaction::new("touch", secondary, Partner::Surfaces(vec![primary])) }
    } else {
        let shape = match place {
            Place::Space => Obstacle::InSpace(ObstacleInSpace::Plane { point: [0.0, -0.9, 0.0], normal: [angle.sin(), angle.cos(), 0.0] }),
            Place::Plane(_) if random.next() > 0.5 && !is_round => Obstacle::Disk { center: [0.1, -1.4], radius: 0.5 },
            Place::Plane(_) => Obstacle::HalfPlane { point: [0.0, -0.9], normal: [angle.sin(), angle.cos()] },
        };
        Interaction::obstacle("touch", hull(&model, 0), shape)
    };
    model.add_interaction(Interaction { update: Some(rule), ..pair });
    let spin = if is_round { 0.0 } else { random.between(-1.0, 1.0) * speed };
    model.set_initial_velocity(0, [0.0, -speed, 0.0], [0.0, 0.0, spin]);
    title += &format!(", {} {}, {}", method.name, rule.name, if has_partner { "two bodies" } else { "an obstacle" });
    let dt = random.between(0.02, 0.1) * facet / speed;
    (model, dt, (1.2 / (speed * dt)) as usize, place, title)
}

/// Runs the scene of a seed to its end or to its failure.
pub fn run(seed: u64) -> Outcome {
    let mut outcome = Outcome::default();
    if catch_unwind(AssertUnwindSafe(|| take(seed, &mut outcome, &mut |_| ()))).is_err() {
        outcome.failure = Some("panicked".into());
    }
    outcome
}

/// Runs the scene of a seed with results in `outcome`; `watch` is called with the rows of the ledger.
pub fn take(seed: u64, outcome: &mut Outcome, watch: &mut dyn FnMut(&LedgerRow)) {
    let (model, dt, steps, place, title) = model_of(seed);
    (outcome.place, outcome.title) = (Some(place), title);
    let mut sim = match Simulation::new(&model, Options::new(&ENERGY_MOMENTUM, dt)) {
        Ok(sim) => sim,
        Err(error) => return outcome.failure = Some(error.to_string()),
    };
    let start = sim.row().clone();
    let energy = start.kinetic;
    let momentum = start.momentum.iter().fold(0.0f64, |most, p| most.max(p.abs()));
    let keeps_reserve = model.interactions[0].update.is_some_and(|rule| rule.name == "velocity");
    let (mut bound, mut heat) = (start.total(), vec![0.0; model.bodies.len()]);
    for _ in 0..steps {
        let taken = sim.step(None, &mut |row: &LedgerRow| {
            outcome.defect = outcome.defect.max(row.energy_defect.abs() / energy);
            outcome.momentum = outcome.momentum.max(row.momentum_defect.max(row.angular_momentum_defect) / momentum);
            outcome.gain = outcome.gain.max((row.total() - bound) / energy);
            bound = if keeps_reserve { bound.max(row.total()) } else { bound.min(row.total()) };
            for (before, now) in heat.iter_mut().zip(&row.plastic_work) {
                outcome.cooled = outcome.cooled.max((*before - now) / energy);
                *before = *now;
            }
            outcome.iterations += row.newton_iterations;
            outcome.halvings += row.halvings;
            outcome.touching += usize::from(row.active > 0);
            watch(row);
        });
        if let Err(error) = taken {
            return outcome.failure = Some(error.to_string());
        }
        outcome.steps += 1;
    }
    outcome.heat = heat.iter().sum::<f64>() / energy;
}
