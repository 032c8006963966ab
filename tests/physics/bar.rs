//! A bar: static stretch, and its lowest axial and bending frequency.
//!
//! Closed forms. Static: Saint Venant-Kirchhoff in plane strain, free to narrow, `a E/(1 - nu^2) (a^2 - 1)/2 = t` for the stretch `a`.
//! Axial: `omega = pi/2 c/L`; the discrete bar (linear elements, consistent mass, a sine is its exact mode) has
//! `omega_h^2 = (6 c^2/h^2)(1 - cos kh)/(2 + cos kh)` (Hughes, The Finite Element Method, 2000, section 7.4). Bending: Euler-Bernoulli
//! cantilever, `omega = 1.8751041^2 sqrt(E I/(rho A L^4))`. In time a scheme that moves positions by the mean velocity turns a
//! frequency omega into `tan(w dt/2) = omega dt/2`; backward Euler damps it.

use std::f64::consts::FRAC_PI_2;

use conserva::dynamics::{Constant, LoadKind, Simulation};
use conserva::integrators::{BACKWARD_EULER, ENERGY_MOMENTUM, MIDPOINT, Scheme, TRAPEZOIDAL};
use conserva::materials::SaintVenantKirchhoff;
use conserva::mesh::rectangle;

use crate::common::Builder;

#[test]
fn dead_traction_stretches_by_the_root_of_the_cubic() {
    for (traction, poisson) in [(1.0, 0.3), (200.0, 0.3), (-100.0, 0.3), (500.0, 0.0)] {
        let mut builder = Builder::default();
        let mesh = rectangle([4.0, 1.0], [4, 2], [0.0; 2]).expect("the mesh is sound");
        let bar = builder.body(
            "bar",
            mesh,
            &SaintVenantKirchhoff { youngs_modulus: 1000.0, poisson_ratio: poisson, density: 1.0 }.material().expect("in range"),
        );
        builder.fix(bar, "left", [true, false, false]);
        builder.fix(bar, "bottom", [false, true, false]);
        builder.load(bar, "right", LoadKind::Traction([1.0, 0.0, 0.0]), Constant(traction));
        let mut sim = builder.simulate(&ENERGY_MOMENTUM, 0.01);
        let settled = sim.settle().unwrap_or_else(|error| panic!("{error}"));

        let modulus = 1000.0 / (1.0 - poisson * poisson);
        let mut a = 1.0f64;
        for _ in 0..50 {
            a -= (0.5 * modulus * a * (a * a - 1.0) - traction) / (0.5 * modulus * (3.0 * a * a - 1.0));
        }
        let across = (1.0 - poisson / (1.0 - poisson) * (a * a - 1.0)).sqrt();
        let fields = &sim.fields()[0];
        for (x, u) in fields.mesh.points.iter().zip(&fields.displacement) {
            // Required accuracy. `settle` balances every node to 1e-11 of the load; the error of displacements is larger by the number of
            // cells.
            assert!((u[0] - (a - 1.0) * x[0]).abs() < 1e-9 && (u[1] - (across - 1.0) * x[1]).abs() < 1e-9, "{traction}: {x:?} {u:?}");
        }
        // W = E' E_11^2 / 2 over the area 4, and the Cauchy stress t / across.
        let strain = 0.5 * (a * a - 1.0);
        let energy = 4.0 * 0.5 * modulus * strain * strain;
        assert!((settled.strain / energy - 1.0).abs() < 1e-9, "{traction}: {} {energy}", settled.strain);
        for stress in &fields.stress {
            assert!((stress[0] - traction / across).abs() < 1e-8 * traction.abs() && stress[1].abs() < 1e-8 * traction.abs(), "{stress:?}");
        }
    }
}

/// Frequency of a simulation that vibrates in one mode: `s_(n-1) + s_(n+1) = 2 cos(w dt) s_n` by least squares, freed from the error in
/// time.
fn frequency(sim: &mut Simulation, steps: usize, measure: impl Fn(&[f64]) -> f64) -> f64 {
    let dt = sim.options().dt;
    let mut samples = vec![measure(&sim.state().positions)];
    for _ in 0..steps {
        sim.step(None, &mut |_| ()).unwrap_or_else(|error| panic!("{error}"));
        samples.push(measure(&sim.state().positions));
    }
    let (mut product, mut square) = (0.0, 0.0);
    for s in samples.windows(3) {
        product += s[1] * (s[0] + s[2]);
        square += s[1] * s[1];
    }
    let angle = (0.5 * product / square).acos();
    2.0 / dt * (0.5 * angle).tan()
}

/// Period of a bar of length 1 with wave speed 10.
const PERIOD: f64 = 4.0 / 10.0;

/// Bar of length 1 in `cells` cells, in its lowest axial vibration; 40 steps a period.
fn axial_bar(cells: usize, integrator: &'static Scheme) -> Simulation {
    let mut builder = Builder::default();
    let mesh = rectangle([1.0, 0.2], [cells, 1], [0.0; 2]).expect("the mesh is sound");
    let points = mesh.points.clone();
    let bar = builder.body(
        "bar",
        mesh,
        &SaintVenantKirchhoff { youngs_modulus: 100.0, poisson_ratio: 0.0, density: 1.0 }.material().expect("in range"),
    );
    builder.fix(bar, "left", [true, false, false]);
    let mut sim = builder.simulate(integrator, PERIOD / 40.0);
    let mut state = sim.state();
    for (v, x) in state.velocities.chunks_exact_mut(2).zip(&points) {
        v[0] = 1e-5 * (FRAC_PI_2 * x[0]).sin();
    }
    sim.restore(&state);
    sim
}

/// Angular frequency of the lowest axial vibration of the bar in `cells` cells, with consistent mass and continuous time.
fn axial_frequency(cells: usize) -> f64 {
    let h = 1.0 / cells as f64;
    let cosine = (FRAC_PI_2 * h).cos();
    10.0 / h * (6.0 * (1.0 - cosine) / (2.0 + cosine)).sqrt()
}

#[test]
fn axial_frequency_is_the_discrete_one_and_converges_to_the_exact_one() {
    let exact = FRAC_PI_2 * 10.0;
    // Integrators with the period of the trapezoidal rule; the periods of others are in `spectra.rs`.
    for integrator in [&ENERGY_MOMENTUM, &MIDPOINT, &TRAPEZOIDAL] {
        let errors = [4, 8, 16].map(|cells| {
            let discrete = axial_frequency(cells);
            let measured = frequency(&mut axial_bar(cells, integrator), 60, |q| q[2 * cells] - 1.0);
            // Strains of 1e-6 are not quite linear: harmonics of this relative size. The difference between 4 and 8 cells is 5e-3.
            assert!((measured / discrete - 1.0).abs() < 1e-6, "{} cells {cells}: {measured} {discrete}", integrator.name);
            measured / exact - 1.0
        });
        println!("{}: axial frequency errors {errors:.6?}", integrator.name);
        let rate = (errors[1] / errors[2]).log2();
        // The next term is (kh)^2/40 of the first: one percent.
        assert!((rate - 2.0).abs() < 0.02, "{errors:?}");
    }
}

/// Closed form: a step of backward Euler multiplies the energy of a vibration by `1 / (1 + (omega dt)^2)`.
#[test]
fn backward_euler_damps_a_vibration_by_its_law() {
    let mut sim = axial_bar(8, &BACKWARD_EULER);
    let factor = 1.0 / (1.0 + (axial_frequency(8) * PERIOD / 40.0).powi(2));
    let mut before = f64::NAN;
    for step in 0..60 {
        sim.step(None, &mut |_| ()).unwrap_or_else(|error| panic!("{error}"));
        let after = sim.row().total();
        assert!(step == 0 || (after / before / factor - 1.0).abs() < 1e-5, "{} {factor}", after / before);
        before = after;
    }
}

/// Lowest bending frequency of a cantilever of length 1, height 0.1, in `cells` cells along its length, over that of Euler and Bernoulli.
fn bending(cells: usize) -> f64 {
    const ROOT: f64 = 1.875104068711961;
    let mut builder = Builder::default();
    let height = 0.1;
    let mesh = rectangle([1.0, height], [cells, 1], [0.0; 2]).expect("the mesh is sound");
    let points = mesh.points.clone();
    let bar = builder.body(
        "bar",
        mesh,
        &SaintVenantKirchhoff { youngs_modulus: 1e4, poisson_ratio: 0.0, density: 1.0 }.material().expect("in range"),
    );
    builder.fix(bar, "left", [true; 3]);
    let expected = ROOT * ROOT * (1e4 * height * height / 12.0f64).sqrt();
    let mut sim = builder.simulate(&ENERGY_MOMENTUM, std::f64::consts::TAU / expected / 40.0);
    let shape = |x: f64| {
        let ratio = (ROOT.cosh() + ROOT.cos()) / (ROOT.sinh() + ROOT.sin());
        let z = ROOT * x;
        z.cosh() - z.cos() - ratio * (z.sinh() - z.sin())
    };
    let mut state = sim.state();
    for (v, x) in state.velocities.chunks_exact_mut(2).zip(&points) {
        v[1] = 1e-4 * shape(x[0]);
    }
    sim.restore(&state);
    let measured = frequency(&mut sim, 60, |q| q.chunks_exact(2).zip(&points).map(|(q, x)| (q[1] - x[1]) * shape(x[0])).sum());
    measured / expected
}

#[test]
fn bending_frequency_converges_to_the_cantilever() {
    let ratios = [20, 40, 80].map(bending);
    let rate = ((ratios[0] - ratios[1]) / (ratios[1] - ratios[2])).log2();
    let limit = ratios[2] + (ratios[2] - ratios[1]) / 3.0;
    println!("bending: ratios {ratios:.5?}, rate {rate:.3}, limit {limit:.5}");
    // The parasitic shear of the bilinear cell stiffens by (cell length / height)^2 / 2: order two.
    assert!((rate - 2.0).abs() < 0.1, "{ratios:?}");
    // Shear and rotary inertia, which Euler and Bernoulli neglect, lower the frequency by about half a percent at this height.
    assert!(limit > 0.99 && limit < 1.0, "{limit}");
}
