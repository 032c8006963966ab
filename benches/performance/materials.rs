//! Cost of a law per point, by hand and as text, alone and within the assembly of a body; and cost of cells of every kind in the assembly.

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use conserva::bodies::{Dilatation, Formulation, Plane};
use conserva::dynamics::{InitialDisplacement, Model, Options, Simulation};
use conserva::elements::CellKind;
use conserva::integrators::ENERGY_MOMENTUM;
use conserva::materials::{CATALOGUE, Components, IncrementResponse, Material, NeoHookean, Response, StoredEnergy};
use conserva::math::lanes::{Lanes, WIDTH};
use conserva::mesh::{Mesh, block, rectangle};

const POINTS: usize = 4;
const ROUNDS: usize = 2000;

/// Minimum time per point of some repetitions `[ns]`.
fn per_point(repetitions: usize, mut call: impl FnMut()) -> f64 {
    let mut least = f64::INFINITY;
    for _ in 0..5 * repetitions {
        let start = Instant::now();
        (0..ROUNDS).for_each(|_| call());
        least = least.min(start.elapsed().as_secs_f64());
    }
    1e9 * least / (ROUNDS * POINTS * WIDTH) as f64
}

fn law(material: &Material, repetitions: usize) -> [f64; 2] {
    let law = material.plane();
    let strain = |size: f64| -> [Components<3>; POINTS] {
        std::array::from_fn(|q| std::array::from_fn(|s| Lanes(std::array::from_fn(|lane| size * ((q + 3 * s + 5 * lane) as f64).sin()))))
    };
    let (n, n1) = (strain(0.05), strain(0.06));
    let (mut responses, mut increments) = ([Response::ZERO; POINTS], [IncrementResponse::ZERO; POINTS]);
    let response = per_point(repetitions, || law.responses_into(black_box(&n), black_box(&mut responses)));
    let increment = per_point(repetitions, || law.increments_into(black_box(&n), black_box(&n1), black_box(&mut increments)));
    [response, increment]
}

/// Minimum time per point of the assembly in a step of a vibrating block `[ns]`.
fn assembly(mesh: &Mesh, formulation: Formulation, material: &Material, repetitions: usize) -> Result<f64, Box<dyn Error>> {
    let (mut least, points) = (f64::INFINITY, (mesh.blocks[0].kind.row().quadrature)().len());
    for _ in 0..repetitions {
        let mut model = Model::new("block");
        let body = model.add_formulated_body("block", mesh.clone(), material, formulation);
        let displacement = mesh.points.iter().map(|[x, y, _]| [0.02 * x * y, 0.01 * x, 0.0]).collect();
        model.initial_displacements.push(InitialDisplacement { body, displacement });
        let mut sim = Simulation::new(&model, Options { threads: 1, ..Options::new(&ENERGY_MOMENTUM, 0.01) })?;
        for _ in 0..10 {
            let before = sim.statistics();
            sim.step(None, &mut |_| ())?;
            let after = sim.statistics();
            let assemblies = (after.newton_iterations - before.newton_iterations) as f64;
            let time = (after.times.assembly - before.times.assembly).as_secs_f64();
            least = least.min(1e9 * time / (assemblies * (after.cells * points) as f64));
        }
    }
    Ok(least)
}

/// Prints the cost of laws.
pub fn costs(repetitions: usize) -> Result<(), Box<dyn Error>> {
    let (lambda, mu) = (1.5, 1.0);
    let (youngs_modulus, poisson_ratio) = (mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu), lambda / (2.0 * (lambda + mu)));
    let hand = NeoHookean { youngs_modulus, poisson_ratio, density: 1e-2 }.material()?;
    let text = StoredEnergy::new("mu/2*(I1 - 3 - 2*ln(J))", Some("lambda/2*ln(J)^2"), &[("mu", mu), ("lambda", lambda)])?;
    let text = Material::hyperelastic(text, 1e-2)?;
    println!("laws in plane strain, ns per point: stress and tangent, increment of a discrete gradient");
    let (by_hand, by_text) = (law(&hand, repetitions), law(&text, repetitions));
    let print = |name: &str, [response, increment]: [f64; 2]| println!("{name:>24} {response:>8.1} {increment:>8.1}");
    print("neo_hookean", by_hand);
    print("the same as text", by_text);
    println!("{:>24} {:>8.2} {:>8.2}", "ratio", by_text[0] / by_hand[0], by_text[1] / by_hand[1]);
    for row in CATALOGUE.iter().skip(1) {
        print(&row.title(), law(&Material::new(row, &row.example(1.0, 1.0))?, repetitions));
    }
    let (mesh, usual) = (rectangle([2.0, 1.0], [80, 40], [0.0; 2])?, Formulation::default());
    let (by_hand, by_text) = (assembly(&mesh, usual, &hand, repetitions)?, assembly(&mesh, usual, &text, repetitions)?);
    println!("assembly, ns per point: by hand {by_hand:.1}, as text {by_text:.1}, ratio {:.2}", by_text / by_hand);
    cells(&mesh, &hand, repetitions)
}

/// Prints the cost of cells, and of those with four nodes in each formulation.
fn cells(mesh: &Mesh, material: &Material, repetitions: usize) -> Result<(), Box<dyn Error>> {
    let usual = Formulation::default();
    println!("assembly of cells, ns per point");
    for &kind in CellKind::ALL {
        let mesh = if kind.dimension() == 2 { mesh.clone() } else { block([2.0, 1.0, 1.0], [12, 8, 8], [0.0; 3])? }.with_cells(kind)?;
        println!("{:>24} {:>8.1}", kind.name(), assembly(&mesh, usual, material, repetitions)?);
    }
    for (name, formulation) in [
        ("quad4, mean dilatation", Formulation { dilatation: Dilatation::Mean, ..usual }),
        ("quad4, plane stress", Formulation { plane: Plane::Stress, ..usual }),
        ("quad4, axisymmetric", Formulation { plane: Plane::Axisymmetric, ..usual }),
    ] {
        println!("{name:>24} {:>8.1}", assembly(mesh, formulation, material, repetitions)?);
    }
    Ok(())
}
