//! Mortar contact with dual multipliers in space.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::fixtures::{dense_rows, difference, evaluated, product, tangent_along};
use super::{in_space, unbalance_in_space};
use conserva::contact::{ContactKernel, Correction, DUAL_MORTAR, PredictedMotion, ProxySurfacesInSpace, Setting};
use conserva::integrators::{Configuration, Derivative};

/// Nodes 0 to 15 are the primary side, 3 x 3 facets facing up; nodes 16 to 20 a quadrilateral and a triangle above, facing down.
const SECONDARY: [&[u32]; 2] = [&[16, 17, 18, 19], &[19, 18, 20]];
const COUNT: usize = 21;
const UNKNOWNS: usize = 3 * COUNT;

fn base() -> Vec<f64> {
    let below = (0..16).flat_map(|k| [f64::from(k % 4), f64::from(k / 4), 0.0]);
    let above = [[0.5, 0.4], [0.6, 1.9], [1.9, 2.0], [1.7, 0.5], [2.6, 1.1]].into_iter().flat_map(|[x, y]| [x, y, 0.02]);
    below.chain(above).collect()
}

/// Positions on a surface that is curved along the first axis, so that facets have height profiles.
fn bent(q: &[f64], by: f64) -> Vec<f64> {
    q.chunks_exact(3).flat_map(|x| [x[0], x[1], x[2] - by * x[0] * x[0]]).collect()
}

fn kernel(reference: &[f64], q_0: &[f64]) -> Box<dyn ContactKernel> {
    let below = (0..9).map(|k| (k / 3) * 4 + k % 3).map(|k| vec![k, k + 1, k + 5, k + 4]).collect::<Vec<_>>();
    let above = SECONDARY.map(<[u32]>::to_vec);
    let mut kernel = in_space(&DUAL_MORTAR, &ProxySurfacesInSpace::new([&above, &below], reference));
    kernel.update_candidates(&PredictedMotion::within(q_0, 1.0));
    kernel.begin_step(q_0);
    kernel
}

fn steps() -> impl Strategy<Value = (Vec<f64>, Vec<f64>)> {
    let noise = || prop::collection::vec(-0.05..0.05f64, UNKNOWNS);
    let moved = |noise: &[f64], size: f64, shift: [f64; 3]| -> Vec<f64> {
        base().iter().enumerate().map(|(k, x)| x + size * noise[k] + if k >= 48 { shift[k % 3] } else { 0.0 }).collect()
    };
    (noise(), noise(), -0.3..0.3f64, -0.3..0.3f64)
        .prop_map(move |(first, second, x, y)| (moved(&first, 1.0, [0.0; 3]), moved(&second, 1.0, [x, y, -0.01])))
}

const PRESSURES: [f64; 5] = [1.0, -0.5, 2.0, 0.25, 1.5];

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, rng_seed: RngSeed::Fixed(2007), failure_persistence: None, ..Default::default() })]

    #[test]
    fn forces_are_balanced_and_conserve((q_0, q_1) in steps(), by in prop::sample::select(vec![0.0, 0.05, -0.05])) {
        let [q_0, q_1] = [q_0, q_1].map(|q| bent(&q, by));
        let middle: Vec<f64> = q_0.iter().zip(&q_1).map(|(a, b)| 0.5 * (a + b)).collect();
        let (mut kernel, moved) = (kernel(&bent(&base(), by), &q_0), difference(&q_1, &q_0));
        for correction in [Correction::PerPatch, Correction::SteadyEnds, Correction::PerNode] {
            kernel.set(Setting::Correction(correction));
            let out = evaluated(&*kernel, Derivative::DiscreteGradient, &q_1, &PRESSURES);
            let rows = dense_rows(&*kernel, &out.gradient_bar, UNKNOWNS);
            for ((row, end), start) in rows.iter().zip(&out.gap).zip(kernel.start_gap()) {
                prop_assert!((product(row, &moved) - (end - start)).abs() < 1e-14);
            }
            prop_assert!(unbalance_in_space(&rows, &middle) < 1e-13);
            prop_assert!(unbalance_in_space(&dense_rows(&*kernel, &out.gradient_end, UNKNOWNS), &q_1) < 1e-13);
            prop_assert_eq!((&out.gap, &out.coverage), (&kernel.gap(&q_1), &kernel.coverage(&q_1)));
        }
    }

    /// Gradients and tangents along a random direction against one-sided difference quotients that agree; with kinks in place of bands,
    /// since within a band the tangent of a discrete gradient is not exact.
    #[test]
    fn gradients_and_tangents_are_derivatives(
        (q_0, q_1) in steps(),
        direction in prop::collection::vec(-1.0..1.0f64, UNKNOWNS),
        by in prop::sample::select(vec![0.0, 0.05, -0.05]),
    ) {
        let [q_0, q_1] = [q_0, q_1].map(|q| bent(&q, by));
        let (mut kernel, mut compared) = (kernel(&bent(&base(), by), &q_0), 0);
        kernel.set(Setting::Correction(Correction::SteadyEnds));
        for derivative in Derivative::ALL {
            let out = evaluated(&*kernel, derivative, &q_1, &PRESSURES);
            let at = |width: f64| -> Vec<f64> {
                let moved: Vec<f64> = q_1.iter().zip(&direction).map(|(q, d)| q + width * d).collect();
                let out = evaluated(&*kernel, derivative, &moved, &PRESSURES);
                let rows = dense_rows(&*kernel, &out.gradient_bar, UNKNOWNS);
                let force = (0..UNKNOWNS).map(|k| rows.iter().zip(PRESSURES).map(|(row, by)| by * row[k]).sum());
                out.gap.iter().copied().chain(force).collect()
            };
            let [before, now, after] = [-1e-5, 0.0, 1e-5].map(at);
            let mut exact: Vec<f64> =
                dense_rows(&*kernel, &out.gradient_end, UNKNOWNS).iter().map(|row| product(row, &direction)).collect();
            exact.extend(tangent_along(kernel.patches(), &out.tangent, &direction));
            for (k, exact) in exact.iter().enumerate() {
                let [back, forth] = [(now[k] - before[k]) * 1e5, (after[k] - now[k]) * 1e5];
                let measured = 0.5 * (back + forth);
                let tolerance = 1e-5 * (1.0 + measured.abs()) + (forth - back).abs();
                prop_assert!((exact - measured).abs() < tolerance, "{derivative:?} {k}: {exact} {measured} {tolerance}");
                compared += usize::from(tolerance < 1e-4 * (1.0 + measured.abs()));
            }
        }
        prop_assert!(compared > 2 * UNKNOWNS, "{compared} are no kinks");
    }
}

/// Dual functions: the gradient of a constraint with respect to the secondary side is nonzero at its own node only.
#[test]
fn a_dual_multiplier_presses_its_own_node_alone() {
    let q = base();
    let kernel = kernel(&q, &q);
    let out = evaluated(&*kernel, Derivative::Gradient(Configuration::End), &q, &[0.0; 5]);
    for (node, row) in dense_rows(&*kernel, &out.gradient_end, UNKNOWNS).iter().enumerate() {
        for other in 0..5 {
            let expected = if other == node { kernel.weights()[node] } else { 0.0 };
            assert!((row[48 + 3 * other + 2] - expected).abs() < 1e-14, "{node} {other}: {}", row[48 + 3 * other + 2]);
        }
    }
}

/// A facet that is not fully covered and its neighbors have standard functions.
#[test]
fn facets_that_are_covered_in_part_have_standard_functions() {
    let q: Vec<f64> = base().iter().enumerate().map(|(k, x)| if k == 60 { 5.0 } else { *x }).collect();
    let kernel = kernel(&q, &q);
    let out = evaluated(&*kernel, Derivative::Gradient(Configuration::End), &q, &[0.0; 5]);
    let rows = dense_rows(&*kernel, &out.gradient_end, UNKNOWNS);
    assert!(rows.iter().flat_map(|row| row[50..].iter().step_by(3)).all(|entry| *entry > -1e-15), "all press the same way");
    assert!(rows[0][53] > 0.01, "a multiplier presses the neighbors of its node, too");
}
