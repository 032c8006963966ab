//! Contact of the nodes of a surface in space with a rigid obstacle (`contact/rigid.rs`): slip.

use std::convert::Infallible;

use nalgebra::Vector3;

use super::obstacle::{ObstacleInSpace, Shape};
use super::slip::{self, Carrier, Group, SlipsInSpace};
use super::vectors::Vec3;
use super::vertices::NODES;
use crate::contact::numbers::Number;
use crate::contact::obstacle_side::{Distance, ObstacleSide};
use crate::contact::patches::Evaluation;
use crate::contact::rigid::{NodeCurve, NodesOnObstacle, RigidContact, Row, RowGradient};
use crate::contact::slip::{SlipStep, Slips};
use crate::contact::surface::Surface;

/// Contact of nodes in space; no curves touch in place of nodes.
pub(in crate::contact) type RigidInSpace = RigidContact<3, Shape, Infallible>;

impl RigidInSpace {
    /// Contact of a surface with an obstacle, sized in the reference positions.
    pub fn of_nodes(surface: Surface, obstacle: &ObstacleInSpace, reference: &[f64], nodes: NodesOnObstacle) -> Self {
        RigidContact::new(surface, Shape::new(obstacle), reference, nodes, Vec::new())
    }
}

impl NodeCurve<3, Shape> for Infallible {
    fn nodes(&self) -> &[usize] {
        match *self {}
    }

    fn nearest_to(&self, _obstacle: &Shape, _z: &[Vector3<f64>]) -> (Distance<3>, Row) {
        match *self {}
    }

    fn plain(&self, _obstacle: &Shape, _z: &[Vector3<f64>], _share: f64) -> RowGradient {
        match *self {}
    }

    fn between(&self, _obstacle: &Shape, _z_0: &[Vector3<f64>], _z_1: &[Vector3<f64>], _size: f64) -> RowGradient {
        match *self {}
    }
}

/// Slip of a node relative to the translating and rotating obstacle.
impl SlipsInSpace for RigidInSpace {
    fn groups<T: Number>(&self, p: usize, z: &[Vec3<T>]) -> Vec<Group<T>> {
        let x = Vector3::from(z[0].map(|x| x.re())) - self.moved(1);
        let group = |(place, obstacle_side): (usize, &Option<Shape>)| {
            let shape = obstacle_side.as_ref()?;
            let Distance { normal, curvature, covered, .. } = shape.at(x);
            let axis = slip::farthest_axis(shape.at(self.begins(p)).normal.into());
            let normal = std::array::from_fn(|i| slip::linear(normal[i], &[0, 1, 2].map(|k| curvature[(i, k)]), z));
            let mut weights = [T::from(0.0); NODES];
            weights[0] = T::from(self.weight(p));
            covered.then(|| Group { place, weights, tangents: slip::tangents(normal, axis), covered: 1.0, normal: None })
        };
        self.sides_near(p).iter().enumerate().filter_map(group).collect()
    }

    fn carrier(&self) -> Option<Carrier> {
        Some(self.shape.carrier(self.carried, self.translations[2]))
    }
}

impl Slips for RigidInSpace {
    fn slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        slip::evaluate(self, &self.sides, step, lambda, out);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::super::facets::Facets;
    use super::*;
    use crate::contact::fixtures::{difference, evaluated, product};
    use crate::contact::{CandidateSearch, PatchFunctions, PredictedMotion, RigidObstacle};
    use crate::integrators::Derivative;

    fn obstacles() -> Vec<ObstacleInSpace> {
        let (center, axis) = ([0.1, -0.2, 0.3], [1.0, 2.0, -1.0]);
        let mut all = vec![
            ObstacleInSpace::Plane { point: center, normal: axis },
            ObstacleInSpace::FiniteCylinder { center, axis, radius: 0.7, length: 1.1, edge: 0.1 },
        ];
        for is_hollow in [false, true] {
            all.extend([
                ObstacleInSpace::Sphere { center, radius: 0.7, axis: [0.0, 0.0, 1.0], is_hollow },
                ObstacleInSpace::Cylinder { point: center, axis, radius: 0.7, is_hollow },
                ObstacleInSpace::Cone { tip: center, axis, angle: 0.6, is_hollow },
                ObstacleInSpace::Torus { center, axis, radius: 1.2, tube: 0.4, is_hollow },
            ]);
        }
        let cube = Facets::cuboid([-0.8, -0.5, -0.4], [0.3, 0.6, 0.7]).and_then(|cube| cube.turned([0.0; 3], axis, 0.4));
        all.extend([cube.expect("it has a volume"), tray()].map(|facets| ObstacleInSpace::Facets(facets.into())));
        all
    }

    /// Three faces of a corner that is open towards positive coordinates.
    fn tray() -> Facets {
        let points = [[0.0; 3], [3.0, 0.0, 0.0], [3.0, 3.0, 0.0], [0.0, 3.0, 0.0], [0.0, 3.0, 3.0], [0.0, 0.0, 3.0], [3.0, 0.0, 3.0]];
        let triangles = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 6], [0, 6, 1]];
        Facets::new(&points, &triangles).expect("it is a surface")
    }

    /// Contact of one facet with a moving obstacle.
    fn contact(obstacle: &ObstacleInSpace, q_0: &[f64], translations: &[[f64; 3]; 3]) -> RigidInSpace {
        let mut kernel = RigidInSpace::of_nodes(Surface::in_space([&[0, 1, 2][..]]), obstacle, q_0, Default::default());
        kernel.move_obstacle(translations);
        assert!(!kernel.update_candidates(&PredictedMotion::within(q_0, 1.0)));
        kernel.begin_step(q_0);
        kernel
    }

    fn multipliers(kernel: &RigidInSpace) -> Vec<f64> {
        (0..kernel.rows()).map(|row| 1.5 - 0.7 * row as f64).collect()
    }

    fn step() -> impl Strategy<Value = ([f64; 9], [f64; 9], [[f64; 3]; 3])> {
        let places = prop::collection::vec(-1.5..1.5f64, 9).prop_map(|all| std::array::from_fn(|i| all[i]));
        let motion = prop::collection::vec(-1.0..1.0f64, 9);
        let size = prop::sample::select(vec![1e-9, 1e-3, 0.1, 1.0]);
        let translations = prop::array::uniform3(prop::array::uniform3(-0.3..0.3f64));
        (places, motion, translations, size).prop_map(|(q_0, motion, translations, size): ([f64; 9], Vec<f64>, _, f64)| {
            (q_0, std::array::from_fn(|i| q_0[i] + size * motion[i]), translations)
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 500, rng_seed: RngSeed::Fixed(2007), failure_persistence: None, ..Default::default() })]

        /// The work of the forces equals multipliers times changes of the gaps plus the work of the obstacle's motion.
        #[test]
        fn work_is_what_the_gaps_and_the_motion_say((q_0, q_1, translations) in step()) {
            for obstacle in obstacles() {
                let kernel = contact(&obstacle, &q_0, &translations);
                let lambda = multipliers(&kernel);
                let out = evaluated(&kernel, Derivative::DiscreteGradient, &q_1, &lambda);
                let (mut force, none) = (vec![0.0; 9], vec![0.0; lambda.len()]);
                let by_motion = kernel.obstacle_force_into(Derivative::DiscreteGradient, &q_1, &none, &lambda, &mut force);
                let by_gaps = product(&lambda, &difference(&out.gap, &kernel.start_gap()));
                let work = product(&force, &difference(&q_1, &q_0));
                let size: f64 = 1.0 + force.iter().map(|f| f.abs()).sum::<f64>();
                prop_assert!((work - by_gaps - by_motion).abs() < 4e-14 * size, "{obstacle:?}: {work} {by_gaps} {by_motion}");
                for row in kernel.present_constraints().map(|(row, ..)| row) {
                    let node = row / kernel.rows_per_node();
                    for i in 0..3 {
                        force[3 * node + i] -= lambda[row] * out.gradient_bar[3 * row + i];
                    }
                }
                prop_assert!(force.iter().all(|f| f.abs() < 1e-14 * size), "{force:?}");
            }
        }

        /// Conservation by symmetry of the obstacle: momentum along a plane, angular momentum about a center and about an axis.
        #[test]
        fn symmetries_of_the_obstacle_are_kept((q_0, q_1, _) in step()) {
            for obstacle in obstacles() {
                let kernel = contact(&obstacle, &q_0, &[[0.0; 3]; 3]);
                let lambda = multipliers(&kernel);
                let (mut force, none) = (vec![0.0; 9], vec![0.0; lambda.len()]);
                kernel.obstacle_force_into(Derivative::DiscreteGradient, &q_1, &none, &lambda, &mut force);
                for node in 0..3 {
                    let at = |q: &[f64]| Vector3::from_column_slice(&q[3 * node..3 * node + 3]);
                    let (f, middle) = (at(&force), 0.5 * (at(&q_0) + at(&q_1)));
                    match &kernel.shape {
                        Shape::Plane { normal, .. } => prop_assert!(normal.cross(&f).norm() < 1e-14),
                        Shape::Sphere { center, .. } => prop_assert!((middle - center).cross(&f).norm() < 1e-14),
                        Shape::Revolved { origin, axis, .. } => {
                            prop_assert!(axis.dot(&(middle - origin).cross(&f)).abs() < 1e-13, "{obstacle:?}");
                        }
                        _ => {}
                    }
                }
            }
        }

        #[test]
        fn tangents_agree_with_differences((q_0, q_1, translations) in step(), direction in prop::array::uniform9(-1.0..1.0f64)) {
            let step = 1e-5;
            // Increments of nodes that are too short for difference quotients.
            let is_short = [0, 3, 6].map(|k| (k..k + 3).map(|i| (q_1[i] - q_0[i]).powi(2)).sum::<f64>() < 0.0025);
            if is_short == [true; 3] {
                return Ok(());
            }
            for obstacle in obstacles() {
                let kernel = contact(&obstacle, &q_0, &translations);
                let lambda = multipliers(&kernel);
                for derivative in Derivative::ALL {
                    let out = evaluated(&kernel, derivative, &q_1, &lambda);
                    // Forces on nodes with all of them displaced along the direction: each depends on its own node alone.
                    let at = |shift: f64| -> [f64; 9] {
                        let moved: [f64; 9] = std::array::from_fn(|i| q_1[i] + shift * direction[i]);
                        let bar = evaluated(&kernel, derivative, &moved, &lambda).gradient_bar;
                        let rows = |node: usize| kernel.rows_per_node() * node..kernel.rows_per_node() * (node + 1);
                        std::array::from_fn(|i| rows(i / 3).map(|row| lambda[row] * bar[3 * row + i % 3]).sum())
                    };
                    let [fine, coarse] = [step, 2.0 * step].map(|h| difference(&at(h), &at(-h)).into_iter().map(move |d| d / (2.0 * h)));
                    for (i, (fine, coarse)) in fine.zip(coarse).enumerate() {
                        let own = 3 * (i / 3)..3 * (i / 3) + 3;
                        // At kinks (edges, tips, axes) difference quotients of different widths disagree.
                        if !is_short[i / 3] && (fine - coarse).abs() < 1e-7 {
                            let ours = product(&out.tangent[3 * i..3 * i + 3], &direction[own]);
                            prop_assert!((ours - fine).abs() < 1e-6, "{obstacle:?} {derivative:?}: {ours} {fine}");
                        }
                    }
                }
            }
        }
    }

    fn gap(obstacle: ObstacleInSpace, x: [f64; 3]) -> f64 {
        Shape::new(&obstacle).at(Vector3::from(x)).gap
    }

    /// Closed forms of the signed distances.
    #[test]
    fn distances() {
        let (origin, up) = ([0.0; 3], [0.0, 0.0, 2.0]);
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} {b}");
        near(gap(ObstacleInSpace::Plane { point: [5.0, 5.0, 1.0], normal: up }, [7.0, 0.0, 1.5]), 0.5);
        near(gap(ObstacleInSpace::Sphere { center: origin, radius: 3.0, axis: [0.0, 0.0, 1.0], is_hollow: false }, [2.0, 3.0, 6.0]), 4.0);
        near(gap(ObstacleInSpace::Sphere { center: origin, radius: 3.0, axis: [0.0, 0.0, 1.0], is_hollow: true }, [0.0, 1.0, 0.0]), 2.0);
        near(gap(ObstacleInSpace::Cylinder { point: origin, axis: up, radius: 3.0, is_hollow: false }, [3.0, 4.0, 9.0]), 2.0);
        let cylinder = ObstacleInSpace::FiniteCylinder { center: origin, axis: up, radius: 3.0, length: 4.0, edge: 1.0 };
        near(gap(cylinder.clone(), [3.0, 4.0, 0.5]), 2.0);
        near(gap(cylinder.clone(), [1.0, 0.0, -5.0]), 3.0);
        near(gap(cylinder.clone(), [5.0, 0.0, 5.0]), 4.0);
        near(gap(cylinder, [0.0, 0.5, 1.5]), -0.5);
        let cone = |is_hollow| ObstacleInSpace::Cone { tip: origin, axis: up, angle: std::f64::consts::FRAC_PI_4, is_hollow };
        near(gap(cone(false), [2.0, 0.0, 0.0]), 2f64.sqrt());
        near(gap(cone(false), [0.0, 0.0, -2.0]), 2.0);
        near(gap(cone(true), [0.0, 0.0, 2.0]), 2f64.sqrt());
        let torus = |is_hollow| ObstacleInSpace::Torus { center: origin, axis: up, radius: 3.0, tube: 1.0, is_hollow };
        near(gap(torus(false), [0.0, 3.0, 2.0]), 1.0);
        near(gap(torus(false), [0.0, 0.0, 0.0]), 2.0);
        near(gap(torus(true), [0.0, -3.5, 0.0]), 0.5);
    }

    /// Closed form of the distance from the faces, edges and vertices of a box.
    #[test]
    fn a_box_is_as_far_as_its_closed_form_says() {
        let half = [0.5, 1.0, 1.5];
        let cube = Facets::cuboid(half.map(|x| -x), half).expect("it has a volume");
        let cube = ObstacleInSpace::Facets(cube.into());
        let mut seed = 1.0f64;
        for _ in 0..500 {
            let x: [f64; 3] = std::array::from_fn(|_| {
                seed = (seed * 16807.0) % 2147483647.0;
                5.0 * (seed / 2147483647.0) - 2.5
            });
            let beyond = [0, 1, 2].map(|i| x[i].abs() - half[i]);
            let outside = beyond.map(|x| x.max(0.0)).iter().map(|x| x * x).sum::<f64>().sqrt();
            let expected = outside + beyond.into_iter().fold(f64::NEG_INFINITY, f64::max).min(0.0);
            let ours = gap(cube.clone(), x);
            assert!((ours - expected).abs() < 1e-14, "{x:?}: {ours} {expected}");
        }
    }

    /// In a corner of a tray a node has one constraint per side, away from it one for the nearest side.
    #[test]
    fn a_pocket_has_a_row_for_each_side() {
        let obstacle = ObstacleInSpace::Facets(tray().into());
        let gaps_at = |x: [f64; 3]| {
            let q: Vec<f64> = [x, [x[0] + 1.0, x[1], x[2]], [x[0], x[1] + 1.0, x[2]]].concat();
            let kernel = contact(&obstacle, &q, &[[0.0; 3]; 3]);
            let gaps: Vec<f64> =
                kernel.present_constraints().filter(|&(_, node, _)| node == 0).map(|(row, ..)| kernel.start_gap()[row]).collect();
            gaps.into_iter().map(|gap| gap / kernel.weights()[0]).collect::<Vec<f64>>()
        };
        let mut three = gaps_at([0.1, 0.2, 0.3]);
        three.sort_by(f64::total_cmp);
        assert!(three.iter().zip([0.1, 0.2, 0.3]).all(|(a, b)| (a - b).abs() < 1e-15) && three.len() == 3, "{three:?}");
        assert_eq!(gaps_at([2.5, 2.5, 0.25]).len(), 1);
        // A node outside of two sides penetrates both.
        let out = gaps_at([-0.05, 1.0, -0.1]);
        assert!(out.len() == 2 && out.iter().all(|gap| *gap < 0.0), "{out:?}");
    }

    #[test]
    fn triangles_that_look_to_opposite_sides_are_refused() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        assert!(Facets::new(&points, &[[0, 1, 2], [1, 3, 2]]).is_ok());
        assert!(Facets::new(&points, &[[0, 1, 2], [1, 2, 3]]).is_err());
        assert!(Facets::new(&points, &[[0, 1, 1]]).is_err());
    }

    #[test]
    fn a_node_that_comes_through_a_thin_plate_is_told() {
        let plate = Facets::cuboid([-1.0, -1.0, -0.01], [1.0, 1.0, 0.01]).expect("it has a volume");
        let q_0 = [0.1, 0.1, 0.3, 0.6, 0.1, 0.3, 0.1, 0.6, 0.3];
        let kernel = contact(&ObstacleInSpace::Facets(plate.into()), &q_0, &[[0.0; 3]; 3]);
        let at = |z: f64| q_0.iter().enumerate().map(|(i, x)| if i % 3 == 2 { z } else { *x }).collect::<Vec<f64>>();
        assert!(kernel.passage(&at(-0.3))[1] > 0.0 && kernel.passage(&at(0.02))[1] == 0.0);
    }
}
