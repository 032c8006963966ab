//! A single part in a step, for tests of parts.

use crate::dynamics::model::part::{Iterate, Part, Sums};
use crate::integrators::Derivative;
use crate::linear::Pattern;
use crate::math::workers::Workers;

/// Force, tangent values and heat of a force element in a step of size `dt` from `q_0` to `q_1`, with the mean velocity of the step.
pub(super) fn linearized(
    part: &dyn Part,
    pattern: &Pattern,
    derivative: Derivative,
    [q_0, q_1]: [&[f64]; 2],
    dt: f64,
) -> (Vec<f64>, Vec<f64>, f64) {
    let share = derivative.placement().share;
    let q_test: Vec<f64> = q_0.iter().zip(q_1).map(|(a, b)| a + share * (b - a)).collect();
    let velocity: Vec<f64> = q_0.iter().zip(q_1).map(|(a, b)| (b - a) / dt).collect();
    let at = Iterate {
        derivative,
        weight: 1.0,
        time: 0.0,
        dt,
        q_0,
        q_1,
        u_0: q_0,
        u_1: q_1,
        q_test: &q_test,
        velocity: &velocity,
        velocity_slope: 1.0 / dt,
        is_still: false,
        inertia: &[],
    };
    let (mut internal, mut load, mut values) = (vec![0.0; q_0.len()], vec![0.0; q_0.len()], vec![0.0; pattern.values()]);
    let mut sums = Sums { internal: &mut internal, load: &mut load, tangent: Some(&mut values), workers: &Workers::new(1) };
    assert!(part.linearize(&at, &[], &mut sums).is_ok());
    let heat = part.after_step(&at, &[]).unwrap().dissipated;
    (internal, values, heat)
}
