//! Constructor of the contact of round parts of a rigid body (`rolling.rs`) with obstacles, and their slip in the plane.

use super::kernel::ContactKernel;
use super::numbers::Number;
use super::patches::Evaluation;
use super::rigid_shape::{Obstacle, PlaneOutline};
use super::rollers::RoundBody;
use super::rolling::RollingContact;
use super::round_parts::{Curvature, RoundPart};
use super::slip::{self, SlipRows, SlipStep, Slips};
use super::space::{ObstacleInSpace, ShapeInSpace};
use super::surface::Surface;

/// Contact of round parts of a rigid body's surface with an obstacle. `shares_of` returns the body's masters (model node numbers) with
/// their coefficients in a given reference point.
pub fn rolling_contact(
    surface: Surface,
    parts: Vec<RoundPart>,
    obstacle: &Obstacle,
    shares_of: &dyn Fn([f64; 3]) -> Vec<(u32, f64)>,
    reference: &[f64],
) -> Box<dyn ContactKernel> {
    match obstacle {
        Obstacle::InSpace(shape) => Box::new(RollingContact::new(surface, parts, ShapeInSpace::new(shape), shares_of, reference)),
        _ => Box::new(RollingContact::new(surface, parts, PlaneOutline::new(obstacle), shares_of, reference)),
    }
}

/// Contact of a round rigid body, with the boundary `surface`, with others: circles in the plane, spheres in space.
pub fn round_contact(surface: Surface, secondary: &RoundBody, primary: Vec<RoundBody>, reference: &[f64]) -> Box<dyn ContactKernel> {
    if surface.dimension() == 2 {
        let shape = |radius: f64, curvature: Curvature| {
            let center = [0.0; 2];
            PlaneOutline::new(&match curvature {
                Curvature::Convex => Obstacle::Disk { center, radius },
                Curvature::Hollow => Obstacle::Ring { center, radius },
            })
        };
        return Box::new(RollingContact::<2, _>::between(surface, secondary, primary, &shape, reference));
    }
    let shape = |radius: f64, curvature: Curvature| {
        let is_hollow = curvature == Curvature::Hollow;
        ShapeInSpace::new(&ObstacleInSpace::Sphere { center: [0.0; 3], radius, axis: [0.0, 0.0, 1.0], is_hollow })
    };
    Box::new(RollingContact::<3, _>::between(surface, secondary, primary, &shape, reference))
}

/// Slip of round parts in the plane relative to the translating and rotating obstacle.
impl SlipRows for RollingContact<2, PlaneOutline> {
    fn places(&self, p: usize, _z: &[f64], places: &mut Vec<usize>) -> bool {
        places.extend(0..self.own_sides().patches.nodes(p).len());
        self.sides_near(p).iter().any(Option::is_some)
    }

    fn rows<T: Number>(&self, p: usize, _places: &[usize], z: &[T], rows: &mut [T], covered: &mut [f64]) -> bool {
        let (first, z) = (self.rows_of(p).start, z.as_chunks().0);
        for (m, obstacle_side) in self.sides_near(p).iter().enumerate() {
            let Some((obstacle_side, _)) = obstacle_side else { continue };
            let (shares, normal) = self.touching(p, obstacle_side, z);
            let weight = self.weight(first + m);
            for (k, share) in shares[..z.len()].iter().enumerate() {
                rows[2 * (m * z.len() + k)] = normal[1] * *share * weight;
                rows[2 * (m * z.len() + k) + 1] = -(normal[0] * *share * weight);
            }
            covered[m] = 1.0;
        }
        true
    }

    fn is_relative(&self, _p: usize) -> bool {
        !self.is_on_obstacle()
    }

    fn other_side(&self) -> slip::Carrier {
        match self.shape() {
            Some(shape) if self.is_on_obstacle() => shape.carrier(self.carried, self.translations[1]),
            _ => slip::Carrier::default(),
        }
    }
}

impl Slips for RollingContact<2, PlaneOutline> {
    fn slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        slip::evaluate(self, &self.own_sides().patches, step, lambda, out);
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::super::fixtures::{dense_rows_of, difference, product, stored, tangent_along};
    use super::super::{Evaluation, ObstacleInSpace, round_parts};
    use super::*;
    use crate::integrators::{Configuration, Derivative};

    /// Disk of twelve nodes on a circle; nodes 0, 4 and 8 are masters.
    fn disk() -> (Surface, Vec<f64>) {
        let at = |k: u32| (f64::from(k) * std::f64::consts::TAU / 12.0).sin_cos();
        let q = (0..12).flat_map(|k| [0.5 * at(k).1 + 0.2, 0.5 * at(k).0 - 0.1]).collect();
        let facets: Vec<[u32; 2]> = (0..12).map(|k| [k, (k + 1) % 12]).collect();
        (Surface::new(&facets), q)
    }

    /// Lateral surface of a cylinder with two rings of twelve nodes, and a node on its axis, so that masters in general position exist.
    fn cylinder() -> (Surface, Vec<f64>) {
        let at = |k: u32| (f64::from(k) * std::f64::consts::TAU / 12.0).sin_cos();
        let ring = |z: f64| (0..12).flat_map(move |k| [0.5 * at(k).1, 0.5 * at(k).0, z]);
        let facets: Vec<[u32; 4]> = (0..12).map(|k| [k, (k + 1) % 12, 12 + (k + 1) % 12, 12 + k]).collect();
        (Surface::in_space(facets.iter().map(|facet| &facet[..])), ring(0.0).chain(ring(0.8)).collect())
    }

    /// Coefficients of the masters 0, 4, 8 and, in space, 13 in a point, for the reference positions `q`.
    fn shares_of(q: &[f64], dimension: usize, point: [f64; 3]) -> Vec<(u32, f64)> {
        let masters = if dimension == 2 { vec![0, 4, 8] } else { vec![0, 4, 8, 13] };
        let at = |node: u32| Vector3::from_fn(|i, _| if i < dimension { q[dimension * node as usize + i] } else { 0.0 });
        let mut edges = nalgebra::Matrix3::identity();
        (1..masters.len()).for_each(|k| edges.set_column(k - 1, &(at(masters[k]) - at(0))));
        let b = edges.try_inverse().unwrap() * (Vector3::from(point) - at(0));
        let rest = 1.0 - (1..masters.len()).map(|k| b[k - 1]).sum::<f64>();
        std::iter::once((0, rest)).chain((1..masters.len()).map(|k| (masters[k], b[k - 1]))).collect()
    }

    /// Obstacles, each with a surface that touches it.
    fn cases() -> Vec<(Obstacle, Surface, Vec<f64>)> {
        let plane = [
            Obstacle::HalfPlane { point: [0.0, -0.7], normal: [0.1, 1.0] },
            Obstacle::Disk { center: [0.1, -1.8], radius: 1.1 },
            Obstacle::Ring { center: [0.3, 0.4], radius: 1.2 },
            Obstacle::Polyline { points: vec![[2.0, -0.6], [-0.2, -0.7], [-1.5, 0.4]] },
        ];
        let space = [
            ObstacleInSpace::Plane { point: [0.0, -0.6, 0.0], normal: [0.1, 1.0, 0.3] },
            ObstacleInSpace::Cylinder { point: [0.1, 0.3, 0.0], axis: [0.05, 0.0, 1.0], radius: 1.0, is_hollow: true },
        ];
        let of = |(surface, q): (Surface, Vec<f64>)| move |obstacle| (obstacle, surface.clone(), q.clone());
        plane.into_iter().map(of(disk())).chain(space.into_iter().map(Obstacle::InSpace).map(of(cylinder()))).collect()
    }

    const LAMBDA: [f64; 8] = [1.5, 0.7, -0.4, 1.1, 0.3, -0.8, 0.6, 0.9];

    /// The forces do the work of the multipliers on the gaps plus that of the obstacle's motion, and forces of two bodies have no resulting
    /// force or moment; gradients and tangents of gaps and slips are derivatives along a random direction.
    fn keeps_the_contract(
        kernel: &dyn ContactKernel,
        q_0: &[f64],
        motion: &[f64],
        direction: &[f64],
        name: &str,
    ) -> Result<(), TestCaseError> {
        let d = kernel.secondary().dimension();
        let lambda = &LAMBDA[..kernel.rows()];
        let q_1: Vec<f64> = q_0.iter().zip(motion).map(|(q, u)| q + u).collect();
        let evaluated = |derivative, q: &[f64]| {
            let mut out = Evaluation::default();
            kernel.evaluate(derivative, q, lambda, &mut out);
            out
        };
        let out = evaluated(Derivative::DiscreteGradient, &q_1);
        prop_assert!(out.live.contains(&true), "{name}");
        let patches = kernel.patches();
        let rows = |gradients: &[f64], patches, count| dense_rows_of(patches, count, gradients, q_0.len());
        let combined = |rows: Vec<Vec<f64>>, by: &[f64]| -> Vec<f64> {
            (0..q_0.len()).map(|k| rows.iter().zip(by).map(|(row, by)| by * row[k]).sum()).collect()
        };
        let of_gaps = |at: &Evaluation| combined(rows(&at.gradient_bar, patches, lambda.len()), lambda);
        let is_obstacle = kernel.shown_on_primary(0, q_0).is_none();
        let (force, none) = (of_gaps(&out), vec![0.0; lambda.len()]);
        let mut of_obstacle = vec![0.0; q_0.len()];
        let by_motion = kernel.obstacle_force_into(Derivative::DiscreteGradient, &q_1, &none, lambda, &mut of_obstacle);
        let expected = if is_obstacle { force.clone() } else { vec![0.0; q_0.len()] };
        prop_assert!(difference(&of_obstacle, &expected).iter().all(|off| off.abs() < 1e-13), "{name}");
        let work = product(&force, &difference(&q_1, q_0));
        let by_gaps = product(lambda, &difference(&out.gap, &kernel.start_gap()));
        prop_assert!((work - by_gaps - by_motion).abs() < 1e-13, "{name}: {work} {by_gaps} {by_motion}");
        let along = |width: f64| -> Vec<f64> { q_1.iter().zip(direction).map(|(q, u)| q + width * u).collect() };
        let slope = |of: &dyn Fn(&[f64]) -> Vec<f64>, width: f64| -> Vec<f64> {
            difference(&of(&along(width)), &of(&along(-width))).iter().map(|x| 0.5 * x / width).collect()
        };
        // The distance from a polyline has kinks, where difference quotients of two widths disagree.
        let agrees = |what: &str, exact: Vec<f64>, of: &dyn Fn(&[f64]) -> Vec<f64>| -> Result<(), TestCaseError> {
            for ((exact, fine), coarse) in exact.iter().zip(slope(of, 1e-5)).zip(slope(of, 2e-5)) {
                prop_assert!((fine - coarse).abs() > 1e-6 || (exact - fine).abs() < 1e-6, "{name} {what}: {exact} {fine}");
            }
            Ok(())
        };
        let gaps = rows(&out.gradient_end, patches, lambda.len()).iter().map(|row| product(row, direction)).collect();
        agrees("gap", gaps, &|q| evaluated(Derivative::DiscreteGradient, q).gap)?;
        for derivative in Derivative::ALL {
            let out = evaluated(derivative, &q_1);
            agrees("force", tangent_along(patches, &out.tangent, direction), &|q| of_gaps(&evaluated(derivative, q)))?;
        }
        let shears = &LAMBDA[..(d - 1) * lambda.len()];
        let slips = |q: &[f64]| {
            let (moved, mut slips) = (difference(q, q_0), Evaluation::default());
            let step = SlipStep { q_0, q_1: q, moved: &moved, test: Configuration::Middle, live: &out.live, wants_tangent: true };
            kernel.evaluate_slips(step, shears, &mut slips);
            stored(&slips, kernel.slip_patches())
        };
        let (at, count, of_slips) = (slips(&q_1), (d - 1) * lambda.len(), kernel.slip_patches());
        let exact = rows(&at.gradient_end, of_slips, count).iter().map(|row| product(row, direction)).collect();
        agrees("slip", exact, &|q| slips(q).gap)?;
        let pulls = |at: &Evaluation| combined(rows(&at.gradient_bar, of_slips, count), shears);
        agrees("friction", tangent_along(of_slips, &at.tangent, direction), &|q| pulls(&slips(q)))?;
        // The forces of an obstacle have a resultant, those between two bodies have none.
        if !is_obstacle {
            let middle: Vec<f64> = q_0.iter().zip(&q_1).map(|(a, b)| 0.5 * (a + b)).collect();
            for force in [force, pulls(&at)] {
                let of_point = |k: usize, v: &[f64]| Vector3::from_fn(|i, _| if i < d { v[d * k + i] } else { 0.0 });
                let nodes = 0..q_0.len() / d;
                let resultant: Vector3<f64> = nodes.clone().map(|k| of_point(k, &force)).sum();
                let moment: Vector3<f64> = nodes.map(|k| of_point(k, &middle).cross(&of_point(k, &force))).sum();
                prop_assert!(resultant.norm() < 1e-13 && moment.norm() < 1e-13, "{name}: {resultant} {moment}");
            }
        }
        Ok(())
    }

    /// Two bodies with twelve nodes on circles or cylinders, of which the first is round, the second round or hollow.
    fn two_bodies(is_hollow: bool, dimension: usize) -> (Box<dyn ContactKernel>, Vec<f64>) {
        let (surface, own) = if dimension == 2 { disk() } else { cylinder() };
        let nodes = (own.len() / dimension) as u32;
        let shift = if is_hollow { 0.05 } else { 1.0 };
        let other = own.chunks_exact(dimension).flat_map(|x| x.iter().enumerate().map(|(i, x)| if i == 0 { x + shift } else { *x }));
        let q: Vec<f64> = own.iter().copied().chain(other).collect();
        let center: Vec<f64> = if dimension == 2 { vec![0.2, -0.1] } else { vec![0.0, 0.0, 0.4] };
        let body = |first: u32, shift: f64, radius: f64, curvature: Curvature| {
            let point = std::array::from_fn(|i| center.get(i).copied().unwrap_or(0.0));
            let masters = shares_of(&own, dimension, point).into_iter().map(|(node, share)| (node + first, share)).collect();
            let inside = (first..first + nodes).collect();
            let center = Vector3::from(point) + Vector3::new(shift, 0.0, 0.0);
            RoundBody { part: RoundPart { center, radius, axis: None, inside, rim: Vec::new() }, curvature, masters }
        };
        let curvature = if is_hollow { Curvature::Hollow } else { Curvature::Convex };
        let radius = if is_hollow { 0.55 } else { 0.5 };
        let kernel = round_contact(surface, &body(0, 0.0, 0.5, Curvature::Convex), vec![body(nodes, shift, radius, curvature)], &q);
        (kernel, q)
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 100, rng_seed: RngSeed::Fixed(2007), failure_persistence: None, ..Default::default() })]

        #[test]
        fn rows_of_round_parts_keep_the_contract(
            motion in prop::collection::vec(-0.03..0.03f64, 150),
            direction in prop::collection::vec(-1.0..1.0f64, 150),
            shift in prop::array::uniform3(-0.05..0.05f64),
        ) {
            for (obstacle, surface, q_0) in cases() {
                let d = surface.dimension();
                let parts = round_parts(&surface, &q_0);
                prop_assert_eq!(parts.len(), d - 1);
                let mut kernel = rolling_contact(surface, parts, &obstacle, &|point| shares_of(&q_0, d, point), &q_0);
                let to: [f64; 3] = std::array::from_fn(|i| if i < d { shift[i] } else { 0.0 });
                kernel.move_obstacle(&[[0.0; 3], to.map(|x| 0.5 * x), to]);
                kernel.begin_step(&q_0);
                keeps_the_contract(&*kernel, &q_0, &motion, &direction[..q_0.len()], &format!("{obstacle:?}"))?;
            }
            for (is_hollow, dimension) in [(false, 2), (true, 2), (false, 3), (true, 3)] {
                let (mut kernel, q_0) = two_bodies(is_hollow, dimension);
                kernel.begin_step(&q_0);
                let name = format!("two bodies, hollow: {is_hollow}, dimension {dimension}");
                keeps_the_contract(&*kernel, &q_0, &motion, &direction[..q_0.len()], &name)?;
            }
        }
    }

    /// Closed form: a disk that rotates by an angle and advances by 2 r tan(angle/2) does not slip.
    #[test]
    fn a_disk_that_rolls_does_not_slip() {
        let (surface, q_0) = disk();
        let plane = Obstacle::HalfPlane { point: [0.0, -0.6], normal: [0.0, 1.0] };
        let parts = round_parts(&surface, &q_0);
        let mut kernel = rolling_contact(surface, parts, &plane, &|point| shares_of(&q_0, 2, point), &q_0);
        kernel.begin_step(&q_0);
        assert!(kernel.start_gap()[0].abs() < 1e-16);
        let (sin, cos) = (-0.3f64).sin_cos();
        let turned =
            |x: &[f64]| [0.2 + cos * (x[0] - 0.2) - sin * (x[1] + 0.1) + 0.15f64.tan(), sin * (x[0] - 0.2) + cos * (x[1] + 0.1) - 0.1];
        let q_1: Vec<f64> = q_0.chunks_exact(2).flat_map(turned).collect();
        let (moved, mut out) = (difference(&q_1, &q_0), Evaluation::default());
        kernel.evaluate_slips(
            SlipStep { q_0: &q_0, q_1: &q_1, moved: &moved, test: Configuration::Middle, live: &[true], wants_tangent: true },
            &[1.0],
            &mut out,
        );
        assert!(out.gap[0].abs() < 1e-16 && kernel.gap(&q_1)[0].abs() < 1e-16, "{:?}", out.gap);
    }
}
