//! Exact shapes of boundaries: the shape that a boundary has by its definition (circle, sphere, cylinder, cone, torus, plane), from which
//! height profiles are computed instead of from the nodes. Used by contact in the plane (`quadratic.rs`) and in space
//! (`space/second_order.rs`).
//!
//! With the signed distance `g` of the shape, the height `z` over a point `x` of a facet with the unit normal `n` satisfies
//! `g(x + z n) = 0`, and its slope along the unit vector `t` of the facet is `-(grad g.t)/(grad g.n)`.

use nalgebra::{SVector, Vector2, Vector3};

use super::obstacle_side::ObstacleSide;
use super::profile::Profile;
use super::rigid_shape::{Obstacle, PlaneOutline};
use super::space::{ObstacleInSpace, ShapeInSpace};
use crate::math::tolerances::{ROUND_PART, STRAIGHT};

/// Newton iterations for a height. They converge since facets are inclined to the shape by less than 45 degrees.
const ITERATIONS: usize = 12;

/// Smallest component of the gradient along the facet's normal: steeper facets do not represent the shape.
const STEEP: f64 = 0.3;

/// Exact shape of a boundary.
#[derive(Clone, Debug)]
pub struct ExactShape {
    kind: Kind,
    /// Largest coordinate in the differences that define distances, for their round-off `[length]`.
    reach: f64,
}

#[derive(Clone, Debug)]
enum Kind {
    Plane(PlaneOutline),
    Space(ShapeInSpace),
}

/// Height over a point of a facet, and gradient of the distance there; `None` if the facet does not represent the shape.
fn height<const D: usize, S: ObstacleSide<D>>(shape: &S, x: SVector<f64, D>, normal: SVector<f64, D>) -> Option<(f64, SVector<f64, D>)> {
    let mut z = 0.0;
    for _ in 0..ITERATIONS {
        let local = shape.at(x + normal * z);
        let slope = local.normal.dot(&normal);
        if slope.abs() < STEEP {
            return None;
        }
        z -= local.gap / slope;
    }
    Some((z, shape.at(x + normal * z).normal))
}

impl ExactShape {
    /// Outline of an obstacle; `None` for obstacles with corners.
    pub fn new(obstacle: &Obstacle) -> Option<Self> {
        let size = |x: &[f64; 2]| x[0].hypot(x[1]);
        let (kind, reach) = match obstacle {
            Obstacle::InSpace(ObstacleInSpace::Facets(_) | ObstacleInSpace::FiniteCylinder { .. }) | Obstacle::Polyline { .. } => {
                return None;
            }
            Obstacle::InSpace(shape) => (Kind::Space(ShapeInSpace::new(shape)), shape.reach()),
            Obstacle::HalfPlane { .. } => (Kind::Plane(PlaneOutline::new(obstacle)), 0.0),
            Obstacle::Disk { center, radius } | Obstacle::Ring { center, radius } => {
                (Kind::Plane(PlaneOutline::new(obstacle)), size(center) + radius)
            }
        };
        Some(ExactShape { kind, reach })
    }

    /// Signed distance of a point from the shape `[length]`.
    pub fn distance(&self, x: [f64; 3]) -> f64 {
        match &self.kind {
            Kind::Plane(shape) => shape.at(Vector2::new(x[0], x[1])).gap,
            Kind::Space(shape) => shape.at(Vector3::from(x)).gap,
        }
    }

    /// True if a point lies on the shape, up to six digits of its coordinates.
    pub fn contains(&self, x: [f64; 3]) -> bool {
        self.distance(x).abs() <= ROUND_PART * self.reach.max(Vector3::from(x).norm())
    }

    /// Height profile over a facet in the plane; `None` where the facet does not represent the shape.
    pub(super) fn profile(&self, [a, b]: [[f64; 2]; 2]) -> Option<Profile> {
        let Kind::Plane(shape) = &self.kind else { return None };
        let [a, b] = [Vector2::from(a), Vector2::from(b)];
        let length = (b - a).norm();
        let along = (b - a) / length;
        let outward = Vector2::new(along.y, -along.x);
        let at = |xi: f64| {
            let (z, gradient) = height(shape, a + (b - a) * xi, outward)?;
            Some([z / length, -gradient.dot(&along) / gradient.dot(&outward)])
        };
        let [first, middle, last] = [at(0.0)?, at(0.5)?, at(1.0)?];
        // Simpson's rule with end derivatives, exact for polynomials of fifth degree.
        let mean = (7.0 * first[0] + 16.0 * middle[0] + 7.0 * last[0]) / 30.0 + (first[1] - last[1]) / 60.0;
        let is_flat = first.into_iter().chain(last).all(|value| value.abs() < STRAIGHT);
        Some(if is_flat { Profile::default() } else { Profile::new(first, last, mean) })
    }

    /// Height of the shape over a point `x` of a facet with the unit normal `normal` `[length]`; `None` where the facet does not represent
    /// the shape.
    pub fn height_in_space(&self, x: Vector3<f64>, normal: Vector3<f64>) -> Option<f64> {
        let Kind::Space(shape) = &self.kind else { return None };
        height(shape, x, normal).map(|(height, _)| height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: height of the unit circle over a chord, for facets of any size.
    #[test]
    fn profiles_are_those_of_the_circle() {
        let shape = ExactShape::new(&Obstacle::Disk { center: [0.5, -1.0], radius: 2.0 }).expect("a circle");
        for (from, to) in [(0.1_f64, 0.3_f64), (1.0, 1.8)] {
            let at = |angle: f64| [0.5 + 2.0 * angle.cos(), -1.0 + 2.0 * angle.sin()];
            let profile = shape.profile([at(from), at(to)]).expect("a chord");
            let half = 0.5 * (to - from);
            let (chord, apothem) = (4.0 * half.sin(), 2.0 * half.cos());
            for xi in [0.0, 0.2, 0.5, 0.9, 1.0_f64] {
                let exact = ((4.0 - (chord * (xi - 0.5)).powi(2)).sqrt() - apothem) / chord;
                assert!((profile.at(xi)[0] - exact).abs() < 0.02 * half.powi(5) + 1e-12, "{from} {xi}: {profile:?} {exact}");
            }
        }
        assert!(shape.contains([2.5, -1.0, 0.0]) && !shape.contains([2.501, -1.0, 0.0]));
        // A facet across the circle does not represent it.
        assert!(shape.profile([[0.5, 0.9], [0.5, 1.1]]).is_none());
    }

    #[test]
    fn obstacles_with_corners_are_no_shapes() {
        assert!(ExactShape::new(&Obstacle::Polyline { points: vec![[0.0, 0.0], [1.0, 0.0]] }).is_none());
        let cylinder = ObstacleInSpace::Cylinder { point: [0.0; 3], axis: [0.0, 0.0, 2.0], radius: 1.0, is_hollow: true };
        let shape = ExactShape::new(&Obstacle::InSpace(cylinder)).expect("a cylinder");
        // Over the middle of a chord of 60 degrees.
        let found = shape.height_in_space(Vector3::new(0.75_f64.sqrt(), 0.0, 3.0), Vector3::x()).expect("a chord");
        assert!((found - (1.0 - 0.75_f64.sqrt())).abs() < 1e-14);
    }
}
