//! Bearing of Hesch and Betsch (PAMM 2007): the press fit is settled, spun up by a torque hat until 0.5, then free.
//!
//! Mesh, Young's modulus, Poisson's ratio, density, times and hat are those of the paper; radii, peak and step size are chosen here.
//! Expected energies come from an independent code, a prototype in NumPy, SciPy and JAX (`bearing.py --T 0.5`), written before this program
//! from the same formulas.

use conserva::contact::FacetShape;
use conserva::dynamics::{GAP, Hat, LedgerRow, LoadKind, Simulation};
use conserva::integrators::ENERGY_MOMENTUM;
use conserva::materials::NeoHookean;
use conserva::mesh::ring;

use crate::common::{Builder, run, worst};

/// Strain energy of the settled press fit, from the prototype.
const SETTLED_STRAIN: f64 = 3.063631052984e-01;
/// Total energy at t = 0.5, from the prototype.
const SPUN_TOTAL: f64 = 5.166057937835e-01;
/// Angular momentum at t = 0.5, from the prototype: the impulse minus the reaction of the fixed rim.
const SPUN_ANGULAR_MOMENTUM: f64 = 2.460185529e-02;
/// Impulse of the hat: half its peak times its width.
const IMPULSE: f64 = 0.5 * 0.1 * 0.5;

fn bearing(held: bool, dt: f64) -> Simulation {
    let steel = NeoHookean { youngs_modulus: 1e5, poisson_ratio: 0.1, density: 1e-3 }.material().expect("in range");
    let mut builder = Builder::default();
    let outer = builder.body("outer ring", ring(1.0, 1.5, [10, 48], [0.0; 2], 0.0).expect("the mesh is sound"), &steel);
    let inner = builder.body("inner ring", ring(0.5, 1.002, [10, 40], [0.0; 2], 0.0).expect("the mesh is sound"), &steel);
    if held {
        builder.fix(outer, "outer", [true; 3]);
    }
    builder.contact((inner, "outer"), (outer, "inner"));
    // Update rule of the prototype.
    builder.model.interactions[0].update = Some(&GAP);
    builder.model.interactions[0].facets = Some(FacetShape::Straight);
    builder.load(inner, "inner", LoadKind::Torque([0.0, 0.0, 1.0]), Hat { start: 0.0, end: 0.5, peak: 0.1 });
    builder.simulate(&ENERGY_MOMENTUM, dt)
}

fn relative(value: f64, expected: f64) -> f64 {
    (value / expected - 1.0).abs()
}

/// Requirements: defect of each step 1e-11 of the total energy, no halving, at most five iterations a step.
fn check_steps(rows: &[LedgerRow]) {
    let total = rows[rows.len() - 1].total();
    assert!(worst(rows, |row| row.energy_defect) < 1e-11 * total, "{:.1e}", worst(rows, |row| row.energy_defect));
    assert_eq!(rows.iter().map(|row| row.halvings).sum::<usize>(), 0);
    let iterations: usize = rows[1..].iter().map(|row| row.newton_iterations).sum();
    assert!(iterations <= 5 * (rows.len() - 1), "{iterations} iterations");
}

#[test]
fn held_bearing_agrees_with_the_prototype_and_keeps_its_energy() {
    let mut sim = bearing(true, 0.005);
    let settled = sim.settle().expect("there is an equilibrium");
    // Both codes iterate to equilibrium; the difference is due to Newton tolerances of 1e-8 of the force.
    assert!(relative(settled.strain, SETTLED_STRAIN) < 1e-6, "{:e}", settled.strain);
    assert_eq!(settled.active, 40);
    let rows = run(&mut sim, 0.5);
    let last = &rows[rows.len() - 1];
    // Both codes have the same scheme and steps; the difference is due to Newton's tolerances, in the prototype 1e-8 of the force.
    assert!(relative(last.total(), SPUN_TOTAL) < 1e-6, "{:e}", last.total());
    assert!(relative(last.angular_momentum[2], SPUN_ANGULAR_MOMENTUM) < 1e-6, "{:e}", last.angular_momentum[2]);
    check_steps(&rows);
    // Support reactions are booked. The defect is the residual of a converged step: round-off of 4e-11 (strains of 1e-16 times the modulus)
    // at a thousand nodes with random signs, times dt: 6e-12 for the sums and for the moments about a point at distance 1.
    assert!(worst(&rows, |row| row.angular_momentum_defect) < 6e-12);
    assert!(worst(&rows, |row| row.momentum_defect) < 6e-12);

    let free = run(&mut sim, 0.7);
    let drift = worst(&free, |row| row.total() / last.total() - 1.0);
    assert!(drift < 1e-10, "the energy drifts by {drift:.1e}");
    check_steps(&free);
}

#[test]
fn free_bearing_takes_the_whole_impulse() {
    let mut sim = bearing(false, 0.005);
    sim.settle().expect("there is an equilibrium");
    let mut rows = run(&mut sim, 0.5);
    rows.extend(run(&mut sim, 0.65).drain(1..));
    for row in rows.iter().filter(|row| row.time > 0.5 - 1e-9) {
        // Kinks of the hat are at ends of steps, so that the sum over mid-steps is the integral. Required: 1e-11.
        assert!((row.angular_momentum[2] - IMPULSE).abs() < 1e-11, "{:e}", row.angular_momentum[2]);
    }
    for row in &rows {
        assert!(row.momentum[0].abs().max(row.momentum[1].abs()) < 1e-12, "{:?}", row.momentum);
    }
    check_steps(&rows);
}
