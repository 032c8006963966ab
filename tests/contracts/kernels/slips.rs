//! Properties of the slips of every contact kernel in the plane, over the random steps of `plane.rs`.

use proptest::prelude::*;

use super::fixtures::{dense_rows, difference, evaluated, product, stored, tangent_along, unbalance};
use super::plane::{UNKNOWNS, chains, config, kernels, step};
use conserva::contact::{ContactKernel, Evaluation, Obstacle, PredictedMotion, Profile, Setting, SlipStep, Surface, rigid_contact};
use conserva::integrators::{Configuration, Derivative};

const SHEARS: [f64; 4] = [1.0, -0.5, 2.0, 0.25];

/// Height profiles of both sides, of the lengths `counts`.
fn profiles(counts: [usize; 2]) -> [Vec<Profile>; 2] {
    [vec![Profile([0.0, 0.12, -0.16, 0.05, -0.01]); counts[0]], vec![Profile([0.0, -0.1, 0.08, 0.03, -0.01]); counts[1]]]
}

/// Kernels with straight facets and with height profiles; one of each set that differs in the discrete gradient of gaps only.
fn all_kernels(q_0: &[f64]) -> impl Iterator<Item = (&'static str, Box<dyn ContactKernel>)> {
    let differs = |(name, _): &(&str, Box<dyn ContactKernel>)| !["shared correction", "steady ends"].contains(name);
    let mut curved: Vec<_> = kernels(q_0).into_iter().filter(differs).collect();
    for (_, kernel) in &mut curved {
        kernel.set(Setting::Profiles(profiles([3, 4])));
        kernel.update_candidates(&PredictedMotion::within(q_0, 10.0));
        kernel.begin_step(q_0);
    }
    kernels(q_0).into_iter().filter(differs).chain(curved)
}

fn slips(kernel: &dyn ContactKernel, q_0: &[f64], q_1: &[f64], test: Configuration) -> Evaluation {
    slips_of(&live_at(kernel, q_1), kernel, [q_0, q_1], test)
}

/// For each contact element, true if it is live at positions `q_1`.
fn live_at(kernel: &dyn ContactKernel, q_1: &[f64]) -> Vec<bool> {
    evaluated(kernel, Derivative::DiscreteGradient, q_1, &SHEARS).live
}

/// Slips of the live contact elements.
fn slips_of(live: &[bool], kernel: &dyn ContactKernel, [q_0, q_1]: [&[f64]; 2], test: Configuration) -> Evaluation {
    let (moved, mut out) = (difference(q_1, q_0), Evaluation::default());
    kernel.evaluate_slips(SlipStep { q_0, q_1, moved: &moved, test, live, wants_tangent: true }, &SHEARS, &mut out);
    stored(&out, kernel.slip_patches())
}

/// Positions rotated about a point.
fn turned(q: &[f64], angle: f64) -> Vec<f64> {
    let ((sin, cos), [a, b]) = (angle.sin_cos(), [0.7, -2.0]);
    q.chunks_exact(2).flat_map(|x| [cos * (x[0] - a) - sin * (x[1] - b), sin * (x[0] - a) + cos * (x[1] - b) + 3.0]).collect()
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn shear_forces_work_on_slips_alone_and_are_balanced((q_0, q_1) in step()) {
        let middle: Vec<f64> = q_0.iter().zip(&q_1).map(|(a, b)| 0.5 * (a + b)).collect();
        let moved = difference(&q_1, &q_0);
        for (name, kernel) in all_kernels(&q_0) {
            let out = slips(&*kernel, &q_0, &q_1, Configuration::Middle);
            let rows = dense_rows(&*kernel, &out.gradient_bar, UNKNOWNS);
            for (row, slip) in rows.iter().zip(&out.gap) {
                prop_assert!((product(row, &moved) - slip).abs() < 1e-14, "{name}");
            }
            prop_assert!(unbalance(&rows, &middle) < 1e-13, "{name}");
            let at_end = slips(&*kernel, &q_0, &q_1, Configuration::End);
            prop_assert!(unbalance(&dense_rows(&*kernel, &at_end.gradient_bar, UNKNOWNS), &q_1) < 1e-13, "{name}");
        }
    }

    /// A rigid motion of both sides, of any size, has no slip.
    #[test]
    fn a_rigid_motion_has_no_slip((q_0, _) in step(), angle in -2.0..2.0f64) {
        let q_1 = turned(&q_0, angle);
        for (name, kernel) in all_kernels(&q_0) {
            let out = slips(&*kernel, &q_0, &q_1, Configuration::Middle);
            let largest = out.gap.iter().fold(0.0f64, |largest, slip| largest.max(slip.abs()));
            prop_assert!(largest < 4e-15, "{name}: {largest:e}");
        }
    }

    /// Gradients and tangents along a random direction against difference quotients, except at kinks.
    #[test]
    fn gradients_and_tangents_are_derivatives((q_0, q_1) in step(), direction in prop::collection::vec(-1.0..1.0f64, UNKNOWNS)) {
        for (name, kernel) in all_kernels(&q_0) {
            let live = live_at(&*kernel, &q_1);
            for test in [Configuration::Middle, Configuration::End] {
                let out = slips_of(&live, &*kernel, [&q_0, &q_1], test);
                let at = |width: f64| {
                    let moved: Vec<f64> = q_1.iter().zip(&direction).map(|(q, d)| q + width * d).collect();
                    let out = slips_of(&live, &*kernel, [&q_0, &moved], test);
                    let rows = dense_rows(&*kernel, &out.gradient_bar, UNKNOWNS);
                    let force = (0..UNKNOWNS).map(|k| rows.iter().zip(SHEARS).map(|(row, shear)| shear * row[k]).sum());
                    out.gap.iter().copied().chain(force).collect::<Vec<f64>>()
                };
                let slope = |width: f64| -> Vec<f64> {
                    at(width).iter().zip(at(-width)).map(|(a, b)| (a - b) / (2.0 * width)).collect()
                };
                let (fine, coarse) = (slope(1e-4), slope(2e-4));
                let rows = dense_rows(&*kernel, &out.gradient_end, UNKNOWNS);
                let of_slips = rows.iter().map(|row| product(row, &direction));
                let exact: Vec<f64> = of_slips.chain(tangent_along(kernel.patches(), &out.tangent, &direction)).collect();
                for ((exact, fine), coarse) in exact.iter().zip(&fine).zip(&coarse) {
                    let scale = 1.0 + fine.abs();
                    prop_assert!((fine - coarse).abs() > 1e-4 * scale || (exact - fine).abs() < 2e-4 * scale, "{name}: {exact} {fine}");
                }
            }
        }
    }
}

/// Closed form: one side slides by a length along the other; each slip is that length times the weight.
#[test]
fn sliding_by_a_length_is_that_slip_for_all_methods() {
    let q_0 = chains().map(|x| if x == -0.05 { 0.0 } else { x });
    let q_1: [f64; UNKNOWNS] = std::array::from_fn(|k| q_0[k] - if k >= 8 && k % 2 == 0 { 0.1 } else { 0.0 });
    for (name, kernel) in kernels(&q_0) {
        let out = slips(&*kernel, &q_0, &q_1, Configuration::Middle);
        for row in 0..4 {
            let expected = 0.1 * kernel.weights()[row];
            assert!((out.gap[row] - expected).abs() < 1e-14, "{name}: {} {expected}", out.gap[row]);
            assert!((out.coverage[row] - 1.0).abs() < 1e-14, "{name}");
        }
    }
}

/// Nodes that move with an obstacle have no slip; the slip of a node is measured in the direction of the body's own surface.
#[test]
fn slips_on_an_obstacle_are_those_against_its_motion() {
    let reference = [0.0, 0.0, 1.0, 0.0];
    let plane = Obstacle::HalfPlane { point: [0.0, 0.0], normal: [0.0, 2.0] };
    let mut kernel = rigid_contact(Surface::new(&[[0, 1]]), &plane, &reference, Default::default());
    kernel.move_obstacle(&[[0.0; 3], [0.2, 0.0, 0.0], [0.4, 0.0, 0.0]]);
    kernel.carry([0.4, 0.0, 0.0], 0.0);
    kernel.begin_step(&reference);
    let moved = [0.4, 0.0, 1.5, 0.0];
    let out = slips(&*kernel, &reference, &moved, Configuration::Middle);
    assert!(out.gap[0].abs() < 1e-15 && (out.gap[1] - 0.5 * 0.1).abs() < 1e-15, "{:?}", out.gap);
}
