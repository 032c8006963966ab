//! Contact of the arcs between nodes with moving obstacles in the plane.

use std::f64::consts::TAU;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::fixtures::{dense_rows, difference, evaluated, product, tangent_along};
use conserva::contact::Obstacle;
use conserva::contact::{ContactKernel, Evaluation, NodesOnObstacle, PredictedMotion, SlipStep, Surface, TouchingPoints, rigid_contact};
use conserva::integrators::{Configuration, Derivative};

const COUNT: u32 = 20;
const UNKNOWNS: usize = 2 * COUNT as usize;

/// Nodes of the unit disk about the origin, turned by an angle.
fn disk(angle: f64) -> Vec<f64> {
    let at = |k: u32| (angle + TAU * f64::from(k) / f64::from(COUNT)).sin_cos();
    (0..COUNT).map(at).flat_map(|(sin, cos)| [cos, sin]).collect()
}

/// Disk on a moving obstacle, for a step that starts at `q_0`.
fn contact(obstacle: &Obstacle, radius: Option<f64>, q_0: &[f64], translations: &[[f64; 2]; 3]) -> Box<dyn ContactKernel> {
    let facets: Vec<[u32; 2]> = (0..COUNT).map(|k| [k, (k + 1) % COUNT]).collect();
    let nodes = NodesOnObstacle { points: TouchingPoints::Arcs { radius }, ..Default::default() };
    let mut kernel = rigid_contact(Surface::new(&facets), obstacle, &disk(0.0), nodes);
    kernel.move_obstacle(&translations.map(|[x, y]| [x, y, 0.0]));
    kernel.update_candidates(&PredictedMotion::within(q_0, 1.0));
    kernel.begin_step(q_0);
    kernel
}

fn obstacles() -> [Obstacle; 3] {
    [
        Obstacle::HalfPlane { point: [0.2, -1.0], normal: [0.3, 1.0] },
        Obstacle::Disk { center: [0.4, -1.7], radius: 0.7 },
        Obstacle::Ring { center: [0.1, 1.2], radius: 2.2 },
    ]
}

/// Start and end positions, multipliers and translations: nodes displaced at random, a turn, and a displacement.
type Step = (Vec<f64>, Vec<f64>, Vec<f64>, [[f64; 2]; 3]);

fn step() -> impl Strategy<Value = Step> {
    (
        prop::collection::vec(-0.02..0.02f64, UNKNOWNS),
        prop::collection::vec(-1.0..1.0f64, UNKNOWNS),
        prop::sample::select(vec![1e-6, 1e-3, 0.03]),
        (-1.0..1.0f64, -0.3..0.3f64),
        prop::collection::vec(0.0..2.0f64, COUNT as usize),
        prop::array::uniform3(prop::array::uniform2(-0.1..0.1f64)),
    )
        .prop_map(|(noise, motion, size, (angle, turn), lambda, translations)| {
            let add = |q: Vec<f64>, by: &[f64], size: f64| -> Vec<f64> { q.iter().zip(by).map(|(q, x)| q + size * x).collect() };
            let q_0 = add(disk(angle), &noise, 1.0);
            // A turn of many sizes, and further displacements.
            let turned = add(disk(angle + turn), &noise, 1.0);
            let q_1 = add(if size > 1e-4 { turned } else { q_0.clone() }, &motion, size);
            (q_0, q_1, lambda, translations)
        })
}

fn forces(kernel: &dyn ContactKernel, blocks: &[f64], lambda: &[f64]) -> Vec<f64> {
    let rows = dense_rows(kernel, blocks, UNKNOWNS);
    (0..UNKNOWNS).map(|k| rows.iter().zip(lambda).map(|(row, pressure)| pressure * row[k]).sum()).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, rng_seed: RngSeed::Fixed(2007), failure_persistence: None, ..Default::default() })]

    /// The work of the forces equals multipliers times changes of the gaps plus the work of the obstacle's motion. On a plane the
    /// forces have no tangential component, on a disk or ring at rest no moment about its center.
    #[test]
    fn forces_do_the_work_of_the_gaps_and_keep_the_symmetries((q_0, q_1, lambda, translations) in step()) {
        for (obstacle, at_rest) in obstacles().iter().flat_map(|obstacle| [(obstacle, false), (obstacle, true)]) {
            let translations = if at_rest { [[0.0; 2]; 3] } else { translations };
            let kernel = &*contact(obstacle, None, &q_0, &translations);
            let out = evaluated(kernel, Derivative::DiscreteGradient, &q_1, &lambda);
            let mut force = vec![0.0; UNKNOWNS];
            let none = vec![0.0; COUNT as usize];
            let by_motion = kernel.obstacle_force_into(Derivative::DiscreteGradient, &q_1, &none, &lambda, &mut force);
            let start = kernel.start_gap();
            let by_gaps: f64 = (0..COUNT as usize).map(|k| lambda[k] * (out.gap[k] - start[k])).sum();
            let work = product(&force, &difference(&q_1, &q_0));
            prop_assert!((work - by_gaps - by_motion).abs() < 1e-13, "{obstacle:?}: {work} {by_gaps} {by_motion}");
            let gap = kernel.gap(&q_1);
            prop_assert!(difference(&out.gap, &gap).iter().all(|error| error.abs() < 1e-15), "{obstacle:?}");
            let blocks = forces(kernel, &out.gradient_bar, &lambda);
            prop_assert!(difference(&blocks, &force).iter().all(|error| error.abs() < 1e-14), "{obstacle:?}");
            let sum = |i: usize| force.iter().skip(i).step_by(2).sum::<f64>();
            match obstacle {
                Obstacle::HalfPlane { normal, .. } => prop_assert!((sum(0) * normal[1] - sum(1) * normal[0]).abs() < 1e-13),
                Obstacle::Disk { center, .. } | Obstacle::Ring { center, .. } if at_rest => {
                    let moment: f64 = (0..COUNT as usize)
                        .map(|k| {
                            let arm = [0, 1].map(|i| 0.5 * (q_0[2 * k + i] + q_1[2 * k + i]) - center[i]);
                            arm[0] * force[2 * k + 1] - arm[1] * force[2 * k]
                        })
                        .sum();
                    prop_assert!(moment.abs() < 1e-13, "{obstacle:?}: {moment}");
                }
                _ => {}
            }
        }
    }

    /// Gradients are derivatives of the gaps, tangents derivatives of the forces, except at kinks, where quotients of two widths
    /// disagree: second derivatives jump where the nearest point reaches an end of its arc.
    #[test]
    fn gradients_and_tangents_are_derivatives(
        (q_0, q_1, lambda, translations) in step(),
        direction in prop::collection::vec(-1.0..1.0f64, UNKNOWNS),
    ) {
        // Differences of steps of 1e-6 are those of the corrections, which are not differentiable there to these digits.
        prop_assume!(difference(&q_1, &q_0).iter().any(|change| change.abs() > 1e-4));
        for obstacle in &obstacles() {
            let kernel = &*contact(obstacle, None, &q_0, &translations);
            let moved = |size: f64| -> Vec<f64> { q_1.iter().zip(&direction).map(|(q, d)| q + size * d).collect() };
            let quotient = |of: &dyn Fn(&[f64]) -> Vec<f64>, size: f64| -> Vec<f64> {
                of(&moved(size)).iter().zip(of(&moved(-size))).map(|(a, b)| (a - b) / (2.0 * size)).collect()
            };
            let check = |ours: Vec<f64>, of: &dyn Fn(&[f64]) -> Vec<f64>, what: &str| {
                let (fine, coarse) = (quotient(of, 1e-6), quotient(of, 3e-6));
                for ((ours, fine), coarse) in ours.iter().zip(&fine).zip(&coarse) {
                    let smooth = (fine - coarse).abs() < 1e-7;
                    prop_assert!(!smooth || (ours - fine).abs() < 1e-6, "{what} {obstacle:?}: {ours} {fine} {coarse}");
                }
                Ok(())
            };
            for derivative in Derivative::ALL {
                let out = evaluated(kernel, derivative, &q_1, &lambda);
                let gradients = dense_rows(kernel, &out.gradient_end, UNKNOWNS);
                check(gradients.iter().map(|row| product(row, &direction)).collect(), &|q| kernel.gap(q), "gap")?;
                let force = |q: &[f64]| forces(kernel, &evaluated(kernel, derivative, q, &lambda).gradient_bar, &lambda);
                check(tangent_along(kernel.patches(), &out.tangent, &direction), &force, &format!("{derivative:?}"))?;
            }
        }
    }
}

/// The least gap of a rigid disk is its distance for every angle, and a rigid turn has the slip of its circle.
#[test]
fn a_rigid_disk_rolls_on_its_circle() {
    let (shares, turn) = (TAU / f64::from(COUNT), 1e-3_f64);
    for angle in (0..40).map(|k| 0.013 + 0.025 * shares * f64::from(k)) {
        for (obstacle, distance) in
            obstacles().iter().zip([(0.3f64 * -0.2 + 1.0) / 1.09f64.sqrt() - 1.0, { 0.4f64.hypot(1.7) - 1.7 }, 1.2 - 0.1f64.hypot(1.2)])
        {
            let kernel = &*contact(obstacle, Some(1.0), &disk(angle), &[[0.0; 2]; 3]);
            let gaps: Vec<f64> = kernel.gap(&disk(angle)).iter().zip(kernel.weights()).map(|(gap, weight)| gap / weight).collect();
            let least = gaps.iter().copied().fold(f64::INFINITY, f64::min);
            assert!((least - distance).abs() < 1e-14, "{obstacle:?} {angle}: {least} {distance}");
            let (q_0, q_1) = (disk(angle - 0.5 * turn), disk(angle + 0.5 * turn));
            let moved = difference(&q_1, &q_0);
            let step = SlipStep {
                q_0: &q_0,
                q_1: &q_1,
                moved: &moved,
                test: Configuration::Middle,
                live: &[true; COUNT as usize],
                wants_tangent: false,
            };
            let mut out = Evaluation::default();
            kernel.evaluate_slips(step, &[0.0; COUNT as usize], &mut out);
            let touching = (0..gaps.len()).min_by(|&a, &b| gaps[a].total_cmp(&gaps[b])).unwrap_or(0);
            let slip = out.gap[touching] / kernel.weights()[touching];
            assert!((slip.abs() - turn).abs() < 1e-6 * turn, "{obstacle:?} {angle}: {slip}");
        }
    }
}

/// On a flattened surface each node touches by itself; beside a straight side the arc begins at the node.
#[test]
fn flat_surfaces_touch_at_their_nodes() {
    let floor = Obstacle::HalfPlane { point: [0.0, -0.5], normal: [0.0, 1.0] };
    let mut q = disk(0.0);
    (0..COUNT as usize).for_each(|k| q[2 * k + 1] = q[2 * k + 1].max(-0.5));
    let kernel = &*contact(&floor, None, &q, &[[0.0; 2]; 3]);
    let flat: Vec<usize> = (0..COUNT as usize).filter(|k| q[2 * k + 1] == -0.5).collect();
    assert_eq!(flat.len(), 7);
    let out = evaluated(kernel, Derivative::AT_END, &q, &[1.0; COUNT as usize]);
    let rows = dense_rows(kernel, &out.gradient_end, UNKNOWNS);
    for &node in &flat[1..6] {
        assert!(out.gap[node].abs() < 1e-15);
        let expected = |k: usize| if k == 2 * node + 1 { kernel.weights()[node] } else { 0.0 };
        assert!((0..UNKNOWNS).all(|k| (rows[node][k] - expected(k)).abs() < 1e-14), "{node}: {:?}", rows[node]);
    }
}
