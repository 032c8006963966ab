//! Energies as text against laws written by hand and against each other.

use super::*;
use crate::materials::{BatchedLaw, Components, IncrementResponse, NeoHookean, Response};
use crate::math::lanes::{Lanes, Real, WIDTH};
use crate::math::tolerances::SMALL_STRAIN;

const NEO_HOOKEAN: &str = "mu/2*(I1 - 3 - 2*ln(J))";

/// Reproducible strains and strain increments of every order of magnitude, different in each lane.
fn strains<const S: usize>() -> Vec<(f64, Components<S>, Components<S>)> {
    let mut seed = 11u64;
    let mut random = move || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    let mut all = Vec::new();
    for size in [1e-120, 1e-12, 1e-8, 1e-6, 2e-5, 1e-4, 1e-3, 1e-2, 0.1, 0.4] {
        for step in [1e-120, 1e-12, 1e-8, 1e-5, 1e-3, 0.1] {
            let mut lanes = |size: f64| -> Components<S> { std::array::from_fn(|_| Lanes(std::array::from_fn(|_| size * random()))) };
            let (n, d) = (lanes(size), lanes(step));
            all.push((size.max(step), n, std::array::from_fn(|k| n[k] + d[k])));
        }
    }
    all
}

fn text_against_hand<const S: usize>(text: &dyn BatchedLaw<S>, hand: &dyn BatchedLaw<S>, mu: f64) {
    let all = strains::<S>();
    let starts: Vec<Components<S>> = all.iter().map(|(_, n, _)| *n).collect();
    let ends: Vec<Components<S>> = all.iter().map(|(_, _, n1)| *n1).collect();
    let energies = |law: &dyn BatchedLaw<S>| {
        let mut energies = vec![Lanes::ZERO; ends.len()];
        law.energies_into(&ends, &mut energies);
        energies
    };
    let responses = |law: &dyn BatchedLaw<S>| {
        let mut responses = vec![Response::ZERO; ends.len()];
        law.responses_into(&ends, &mut responses);
        responses
    };
    let increments = |law: &dyn BatchedLaw<S>| {
        let mut increments = vec![IncrementResponse::ZERO; ends.len()];
        law.increments_into(&starts, &ends, &mut increments);
        increments
    };
    let (energy, response, increment) = (energies(text), responses(text), increments(text));
    let (energy_hand, response_hand, increment_hand) = (energies(hand), responses(hand), increments(hand));
    for (k, (size, n, n1)) in all.iter().enumerate() {
        for lane in 0..WIDTH {
            let at = |name: &str| format!("{name}, strain {size:e}, lane {lane}");
            let stress_size = size.min(1.0) * mu;
            for i in 0..S {
                let (a, b) = (response[k].stress[i].0[lane], response_hand[k].stress[i].0[lane]);
                // The tolerance is relative to the size of the stress, so that small stresses are compared to full accuracy, too.
                assert!((a - b).abs() < 2e-14 * stress_size, "{}: {a} {b}", at("stress"));
                let (a, b) = (increment[k].stress_end[i].0[lane], increment_hand[k].stress_end[i].0[lane]);
                assert!((a - b).abs() < 2e-14 * stress_size, "{}: {a} {b}", at("stress at the end"));
                let (a, b) = (increment[k].mean.stress[i].0[lane], increment_hand[k].mean.stress[i].0[lane]);
                assert!((a - b).abs() < 2e-14 * stress_size, "{}: {a} {b}", at("mean stress"));
                for j in 0..S {
                    let (a, b) = (response[k].tangent[i][j].0[lane], response_hand[k].tangent[i][j].0[lane]);
                    assert!((a - b).abs() < 1e-13 * mu.max(b.abs()), "{}: {a} {b}", at("tangent"));
                }
            }
            // Energies are of second order in the strain; above small strains deviations of first order leave their round-off.
            let norm = |of: &dyn Fn(usize) -> f64| (0..S).map(|i| of(i).powi(2)).sum::<f64>().sqrt();
            let (start, end) = (norm(&|i| n[i].0[lane]), norm(&|i| n1[i].0[lane]));
            let (a, b) = (energy[k].0[lane], energy_hand[k].0[lane]);
            // The error of Simpson's rule at the limit is 2e-13.
            let scale = if end < SMALL_STRAIN { 40.0 * end } else { 1.0 };
            assert!((a - b).abs() <= 1e-14 * mu * scale * end, "{}: {a} {b}", at("energy"));
            let d = norm(&|i| n1[i].0[lane] - n[i].0[lane]);
            let (a, b) = (increment[k].remainder.0[lane], increment_hand[k].remainder.0[lane]);
            let scale = if start.hypot(end) < SMALL_STRAIN { 40.0 * start.hypot(end) } else { 1.0 };
            assert!((a - b).abs() <= 1e-14 * mu * scale * d, "{}: {a} {b}", at("remainder"));
        }
    }
}

#[test]
fn neo_hookean_as_text_is_neo_hookean() {
    let (lambda, mu) = (1.5, 1.0);
    let (youngs_modulus, poisson_ratio) = (mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu), lambda / (2.0 * (lambda + mu)));
    let hand = NeoHookean { youngs_modulus, poisson_ratio, density: 1.0 }.material().unwrap();
    let stored = StoredEnergy::new(NEO_HOOKEAN, Some("lambda/2*ln(J)^2"), &[("mu", mu), ("lambda", lambda)]).unwrap();
    let laws = stored.laws().unwrap();
    text_against_hand::<3>(&*laws.plane, &*hand.plane(), mu);
    text_against_hand::<4>(&*laws.axisymmetric, &*hand.axisymmetric(), mu);
    text_against_hand::<6>(&*laws.space, &*hand.space(), mu);
    let (split, split_hand) = (laws.split.unwrap(), hand.split().unwrap());
    text_against_hand::<6>(&*split.space, &*split_hand.space, mu);
    for change in [1e-9, -1e-5, 0.01, -0.3, 2.0] {
        let (mut energies, mut responses) = ([Lanes::ZERO; 2], [[Lanes::ZERO; 2]; 2]);
        for (k, law) in [&split.volumetric, &split_hand.volumetric].into_iter().enumerate() {
            law.energies_into(&[Lanes::splat(change)], &mut energies[k..=k]);
            law.responses_into(&[Lanes::splat(change)], &mut responses[k..=k]);
        }
        let close = |a: Lanes<false>, b: Lanes<false>| assert!((a.0[0] - b.0[0]).abs() < 1e-15 * b.0[0].abs(), "{change}: {a:?} {b:?}");
        close(energies[0], energies[1]);
        (0..2).for_each(|k| close(responses[0][k], responses[1][k]));
    }
}
