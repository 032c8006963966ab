//! Mean stress of a step that the midpoint-like integrators take from a law, and the part of the energy that it misses.

use std::sync::Arc;

use conserva::materials::{BatchedLaw, CATALOGUE, Components, IncrementResponse, Material, MaterialRow, MeanValue};
use conserva::math::lanes::Lanes;

const START: [f64; 4] = [0.1, -0.05, 0.08, 0.03];
const ALONG: [f64; 4] = [0.2, 0.1, -0.12, 0.15];

fn strain(s: f64) -> Components<4> {
    std::array::from_fn(|k| Lanes([START[k] + s * ALONG[k]; 8]))
}

/// Difference of the law's mean stress over a step from a quadrature that is exact to round-off.
fn error(law: &Arc<dyn BatchedLaw<4>>, size: f64) -> f64 {
    let mut exact = [0.0; 4];
    let pieces = 200;
    for piece in 0..pieces {
        for share in [-0.5, 0.5].map(|side| 0.5 + side / 3.0_f64.sqrt()) {
            let mut stress = [[Lanes::ZERO; 4]];
            law.stresses_into(&[strain((f64::from(piece) + share) / f64::from(pieces) * size)], &mut stress);
            (0..4).for_each(|k| exact[k] += stress[0][k].0[0] / f64::from(2 * pieces));
        }
    }
    let mut increment = [IncrementResponse::ZERO];
    MeanValue(law.clone()).increments_into(&[strain(0.0)], &[strain(size)], &mut increment);
    (0..4).map(|k| (increment[0].mean.stress[k].0[0] - exact[k]).abs()).fold(0.0, f64::max)
}

#[test]
fn the_stress_is_the_mean_over_the_step_and_the_remainder_is_what_it_misses() {
    for row in CATALOGUE {
        let material = Material::new(row, &MaterialRow::example(row, 1.0, 1.0)).unwrap();
        let law = material.axisymmetric();
        let [coarse, fine] = [0.5, 0.25].map(|size| error(&law, size));
        // Error of fourth order: half the step gives a sixteenth of the error, except for laws whose stiffness jumps.
        assert!(law.has_kinks() || coarse < 1e-14 || (10.0..25.0).contains(&(coarse / fine)), "{}: {coarse:.1e} {fine:.1e}", row.name);
        let (mut increment, mut energy) = ([IncrementResponse::ZERO], [Lanes::ZERO; 2]);
        MeanValue(law.clone()).increments_into(&[strain(0.0)], &[strain(0.5)], &mut increment);
        law.energies_into(&[strain(0.0), strain(0.5)], &mut energy);
        let work: f64 = (0..4).map(|k| increment[0].mean.stress[k].0[0] * 0.5 * ALONG[k]).sum();
        let missed = energy[1].0[0] - energy[0].0[0] - work - increment[0].remainder.0[0];
        assert!(missed.abs() < 1e-14, "{}: {missed:.1e}", row.name);
    }
}
