//! Rigid obstacles in space: shapes, and signed distance, normal, curvature and discrete gradient at points in the obstacle's frame.
//!
//! Distances of smooth shapes are exact, not those of facets. With the position `r` of a point, the discrete gradient of its distance
//! satisfies `Gbar.(r_1 - r_0) = g(r_1) - g(r_0)`:
//!
//! ```text
//! plane        n                                      momentum along it is kept
//! sphere       +-(r_0 + r_1)/(|r_0| + |r_1|)          the moment about the center is zero
//! revolved     G_rho (p_0 + p_1)/(rho_0 + rho_1) + G_z a
//! facets       n_mid + (g_1 - g_0 - n_mid.dr)/dr.dr dr
//! ```
//!
//! (Gonzalez, CMAME 190, 2000.) Cylinders, cones and tori are bodies of revolution about an axis `a`: the distance is a function of the
//! distance `rho = |p|` from the axis and the height `z` along it. `(G_rho, G_z)` is the discrete gradient of that function by the formula
//! of facets, so that nodal forces have no moment about the axis. For a cylinder without ends `G = (+-1, 0)`.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use super::facets::Facets;
use super::slip::Carrier;
use crate::contact::edge_plane::{AtEdge, NodeAtEdge};
use crate::contact::obstacle_side::{Distance, ObstacleSide, StepGradient};
use crate::contact::surface::Surface;
use crate::math::tolerances::{PROJECTED_INCREMENT, REMAINDER};

/// Ratio of the radius of a round obstacle to the longest facet above which nodal constraints suffice: between two nodes on such an
/// obstacle even a facet stretched by half penetrates by less than a tenth of its length.
const LARGE: f64 = 3.0;

/// Largest number of sides of an obstacle with pockets that a node or a round part touches simultaneously: three meet in a corner.
const SIDES: usize = 3;

/// Shape of a rigid obstacle in space at its undisplaced position. Directions have any nonzero length.
#[derive(Clone, Debug, PartialEq)]
pub enum ObstacleInSpace {
    /// Points `x` with `normal.(x - point) <= 0`.
    Plane {
        /// Point of the border `[length]`.
        point: [f64; 3],
        /// Outward normal.
        normal: [f64; 3],
    },
    /// Ball, or complement of a ball.
    Sphere {
        /// Center `[length]`.
        center: [f64; 3],
        /// Radius `[length]`.
        radius: f64,
        /// Direction of the axis through the center about which it rotates.
        axis: [f64; 3],
        /// True if bodies are inside.
        is_hollow: bool,
    },
    /// Cylinder without ends, or its complement.
    Cylinder {
        /// Point of the axis `[length]`.
        point: [f64; 3],
        /// Direction of the axis.
        axis: [f64; 3],
        /// Radius `[length]`.
        radius: f64,
        /// True if bodies are inside.
        is_hollow: bool,
    },
    /// Cylinder with flat ends and rounded edges between ends and side.
    FiniteCylinder {
        /// Middle of the axis `[length]`.
        center: [f64; 3],
        /// Direction of the axis.
        axis: [f64; 3],
        /// Radius `[length]`.
        radius: f64,
        /// Distance between the ends `[length]`.
        length: f64,
        /// Radius of the edges, at most the radius and half the length `[length]`.
        edge: f64,
    },
    /// Infinite cone, or its complement (a funnel).
    Cone {
        /// Tip `[length]`.
        tip: [f64; 3],
        /// Direction of the axis, from the tip into the cone.
        axis: [f64; 3],
        /// Angle between axis and side, between 0 and a right angle `[rad]`.
        angle: f64,
        /// True if bodies are inside.
        is_hollow: bool,
    },
    /// Torus, or its complement (the inside of a tube).
    Torus {
        /// Center `[length]`.
        center: [f64; 3],
        /// Direction of the axis.
        axis: [f64; 3],
        /// Radius of the center circle of the tube `[length]`.
        radius: f64,
        /// Radius of the tube, smaller than that of the center circle `[length]`.
        tube: f64,
        /// True if bodies are inside the tube.
        is_hollow: bool,
    },
    /// Flat facets with normals towards the bodies.
    Facets(Arc<Facets>),
}

impl ObstacleInSpace {
    /// Largest coordinate in the differences that define distances, for their round-off `[length]`; 0 for a plane, whose distance has no
    /// such difference.
    pub fn reach(&self) -> f64 {
        let size = |x: &[f64; 3]| Vector3::from(*x).norm();
        match self {
            ObstacleInSpace::Plane { .. } => 0.0,
            ObstacleInSpace::Sphere { center, radius, .. } => size(center) + radius,
            ObstacleInSpace::Cylinder { point, radius, .. } => size(point) + radius,
            ObstacleInSpace::FiniteCylinder { center, radius, length, .. } => size(center) + radius + length,
            ObstacleInSpace::Cone { tip, .. } => size(tip),
            ObstacleInSpace::Torus { center, radius, tube, .. } => size(center) + radius + tube,
            ObstacleInSpace::Facets(facets) => facets.points().iter().map(size).fold(0.0, f64::max),
        }
    }

    /// True for a round obstacle with bodies outside that is small enough to penetrate facets between their nodes.
    pub fn is_small(&self, surface: &Surface, reference: &[f64], facet_size: f64) -> bool {
        let radius = match *self {
            ObstacleInSpace::Sphere { radius, is_hollow: false, .. } | ObstacleInSpace::Cylinder { radius, is_hollow: false, .. } => radius,
            ObstacleInSpace::Torus { tube, is_hollow: false, .. } => tube,
            ObstacleInSpace::FiniteCylinder { edge, .. } => edge,
            ObstacleInSpace::Cone { is_hollow: false, .. } => 0.0,
            _ => return false,
        };
        let longest = (0..surface.count()).map(|facet| surface.facet_size(facet, reference)).fold(0.0, f64::max);
        radius <= LARGE * longest * longest / facet_size
    }
}

/// Obstacle prepared for evaluation. `sign` is +1 if the deformable body is outside of the sphere, -1 if it is inside.
#[derive(Clone, Debug)]
pub(in crate::contact) enum Shape {
    Plane {
        point: Vector3<f64>,
        normal: Vector3<f64>,
    },
    Sphere {
        center: Vector3<f64>,
        radius: f64,
        axis: Vector3<f64>,
        sign: f64,
    },
    Revolved {
        origin: Vector3<f64>,
        axis: Vector3<f64>,
        profile: Profile,
    },
    Facets(Arc<Facets>),
    /// One side of a triangulated surface, by its index.
    Side(Arc<Facets>, usize),
}

/// Rigid motions that map an obstacle to itself: rotations about axes through a center, and translations.
#[derive(Clone, Debug, Default)]
pub(super) struct Symmetries {
    pub center: Vector3<f64>,
    pub rotations: Vec<Vector3<f64>>,
    pub translations: Vec<Vector3<f64>>,
}

/// Meridian of a body of revolution, a function of the distance from the axis and the height along it.
#[derive(Clone, Copy, Debug)]
pub(in crate::contact) enum Profile {
    Cylinder {
        radius: f64,
        sign: f64,
    },
    /// Cylinder with ends: radius and half length without the rounded edges, and radius of the edges.
    FiniteCylinder {
        inner: [f64; 2],
        edge: f64,
    },
    Cone {
        sine: f64,
        cosine: f64,
        sign: f64,
    },
    Torus {
        radius: f64,
        tube: f64,
        sign: f64,
    },
}

/// Value, gradient and Hessian of a function of `N` variables.
#[derive(Clone, Copy, Debug)]
struct Local<const N: usize> {
    value: f64,
    slope: [f64; N],
    curvature: [[f64; N]; N],
}

/// Discrete gradient of a function between two points with the difference `d`, and its derivative with respect to the end point; not
/// corrected for increments below `PROJECTED_INCREMENT * size`.
fn corrected<const N: usize>(start: f64, middle: &Local<N>, end: &Local<N>, d: [f64; N], size: f64) -> ([f64; N], [[f64; N]; N]) {
    let dot = |a: &[f64; N]| a.iter().zip(&d).map(|(a, b)| a * b).sum::<f64>();
    let square = dot(&d);
    let (mut bar, mut tangent) = (middle.slope, middle.curvature.map(|row| row.map(|h| 0.5 * h)));
    let remainder = end.value - start - dot(&middle.slope);
    // For small increments the remainder of the discrete gradient is round-off, unless a corner lies between both points.
    let is_doubtful = square <= (PROJECTED_INCREMENT * size).powi(2);
    if square > 0.0 && !(is_doubtful && remainder.abs() <= REMAINDER * size) {
        let e = remainder / square;
        let turned = middle.curvature.each_ref().map(|row| 0.5 * dot(row));
        for i in 0..N {
            bar[i] += e * d[i];
            for k in 0..N {
                tangent[i][k] += d[i] * (end.slope[k] - middle.slope[k] - turned[k] - 2.0 * e * d[k]) / square;
            }
            tangent[i][i] += e;
        }
    }
    (bar, tangent)
}

impl Profile {
    fn at(&self, [rho, z]: [f64; 2]) -> Local<2> {
        let none = [[0.0; 2]; 2];
        match *self {
            Profile::Cylinder { radius, sign } => Local { value: sign * (rho - radius), slope: [sign, 0.0], curvature: none },
            Profile::FiniteCylinder { inner, edge } => {
                let ([x, y], up) = ([rho - inner[0], z.abs() - inner[1]], z.signum());
                if x > 0.0 && y > 0.0 {
                    let Local { value, slope, curvature: [[xx, xy], [yx, yy]] } = around([x, y], edge, 1.0);
                    return Local { value, slope: [slope[0], up * slope[1]], curvature: [[xx, up * xy], [up * yx, yy]] };
                }
                let (value, slope) = if x >= y { (x, [1.0, 0.0]) } else { (y, [0.0, up]) };
                Local { value: value - edge, slope, curvature: none }
            }
            Profile::Cone { sine, cosine, sign } => {
                if rho * sine + z * cosine >= 0.0 {
                    return Local { value: sign * (rho * cosine - z * sine), slope: [sign * cosine, -sign * sine], curvature: none };
                }
                around([rho, z], 0.0, sign)
            }
            Profile::Torus { radius, tube, sign } => around([rho - radius, z], tube, sign),
        }
    }
}

/// Signed distance from a circle about the origin.
fn around([x, y]: [f64; 2], radius: f64, sign: f64) -> Local<2> {
    let length = x.hypot(y);
    let [a, b] = if length > 0.0 { [x / length, y / length] } else { [0.0; 2] };
    let bend = if length > 0.0 { sign / length } else { 0.0 };
    let curvature = [[b * b * bend, -a * b * bend], [-a * b * bend, a * a * bend]];
    Local { value: sign * (length - radius), slope: [sign * a, sign * b], curvature }
}

impl Shape {
    pub fn new(obstacle: &ObstacleInSpace) -> Self {
        let unit = |vector: &[f64; 3]| Vector3::from(*vector).normalize();
        let sign = |is_hollow: bool| if is_hollow { -1.0 } else { 1.0 };
        match obstacle {
            ObstacleInSpace::Plane { point, normal } => Shape::Plane { point: Vector3::from(*point), normal: unit(normal) },
            ObstacleInSpace::Sphere { center, radius, axis, is_hollow } => {
                Shape::Sphere { center: Vector3::from(*center), radius: *radius, axis: unit(axis), sign: sign(*is_hollow) }
            }
            ObstacleInSpace::Cylinder { point, axis, radius, is_hollow } => {
                let profile = Profile::Cylinder { radius: *radius, sign: sign(*is_hollow) };
                Shape::Revolved { origin: Vector3::from(*point), axis: unit(axis), profile }
            }
            ObstacleInSpace::FiniteCylinder { center, axis, radius, length, edge } => {
                let profile = Profile::FiniteCylinder { inner: [radius - edge, 0.5 * length - edge], edge: *edge };
                Shape::Revolved { origin: Vector3::from(*center), axis: unit(axis), profile }
            }
            ObstacleInSpace::Cone { tip, axis, angle, is_hollow } => {
                let (sine, cosine) = angle.sin_cos();
                Shape::Revolved {
                    origin: Vector3::from(*tip),
                    axis: unit(axis),
                    profile: Profile::Cone { sine, cosine, sign: sign(*is_hollow) },
                }
            }
            ObstacleInSpace::Torus { center, axis, radius, tube, is_hollow } => {
                let profile = Profile::Torus { radius: *radius, tube: *tube, sign: sign(*is_hollow) };
                Shape::Revolved { origin: Vector3::from(*center), axis: unit(axis), profile }
            }
            ObstacleInSpace::Facets(facets) => Shape::Facets(facets.clone()),
        }
    }

    /// Largest number of local minima of the distance along an edge of the surface: 2 for an edge across the hole of a torus.
    pub fn rows_per_edge(&self) -> usize {
        if matches!(self, Shape::Revolved { profile: Profile::Torus { .. }, .. }) { 2 } else { 1 }
    }

    /// True if the edge comes nearer to the axis of a torus, between its ends, than the center circle of the tube.
    pub fn is_across_hole(&self, ends: [Vector3<f64>; 2]) -> bool {
        let Shape::Revolved { origin, axis, profile: Profile::Torus { radius, .. } } = self else { return false };
        let share = self.nearest_to_axis(ends);
        0.0 < share && share < 1.0 && axis.cross(&(ends[0].lerp(&ends[1], share) - origin)).norm() < *radius
    }

    /// Edge coordinate of the point nearest to the axis of revolution; 0 for other shapes and for edges parallel to the axis.
    pub fn nearest_to_axis(&self, [a, b]: [Vector3<f64>; 2]) -> f64 {
        let Shape::Revolved { origin, axis, .. } = self else { return 0.0 };
        let [from, along] = [axis.cross(&(a - origin)), axis.cross(&(b - a))];
        let square = along.norm_squared();
        if square > 0.0 { (-from.dot(&along) / square).clamp(0.0, 1.0) } else { 0.0 }
    }

    /// True for shapes with sharp edges, at which the distance has a kink inside of the obstacle.
    pub fn has_edges(&self) -> bool {
        matches!(self, Shape::Revolved { profile: Profile::FiniteCylinder { .. }, .. })
    }

    /// True if a point is opposite the rounded edge of a cylinder with ends.
    pub fn is_at_rim(&self, x: Vector3<f64>) -> bool {
        let Shape::Revolved { origin, axis, profile: Profile::FiniteCylinder { inner, .. } } = self else { return false };
        let ([rho, z], _) = polar(x - origin, *axis);
        rho > inner[0] && z.abs() > inner[1]
    }

    /// Motion of the obstacle's surface, for a displacement `shift` and a rotation angle about its axis (of a plane: its normal). `end` is
    /// the translation at the end of the step.
    pub fn carrier(&self, (shift, angle): ([f64; 3], f64), end: [f64; 3]) -> Carrier {
        let (origin, axis) = match self {
            Shape::Revolved { origin, axis, .. } => (origin, axis),
            Shape::Sphere { center, axis, .. } => (center, axis),
            Shape::Plane { point, normal } => (point, normal),
            _ => return Carrier { shift, ..Carrier::default() },
        };
        let center = origin + Vector3::from(end) - Vector3::from(shift) * 0.5;
        Carrier { shift, turn: (axis * (2.0 * (0.5 * angle).tan())).into(), center: center.into() }
    }

    /// Rotations and translations that map a round obstacle to itself; empty for other shapes.
    pub(super) fn symmetries(&self) -> Symmetries {
        match self {
            Shape::Sphere { center, .. } => {
                Symmetries { center: *center, rotations: vec![Vector3::x(), Vector3::y(), Vector3::z()], translations: Vec::new() }
            }
            Shape::Revolved { origin, axis, profile } => {
                let translations = if matches!(profile, Profile::Cylinder { .. }) { vec![*axis] } else { Vec::new() };
                Symmetries { center: *origin, rotations: vec![*axis], translations }
            }
            _ => Symmetries::default(),
        }
    }
}

impl ObstacleSide<3> for Shape {
    fn distance(&self, x: Vector3<f64>) -> Option<Distance<3>> {
        Some(self.at(x))
    }

    fn at(&self, x: Vector3<f64>) -> Distance<3> {
        match self {
            Shape::Plane { point, normal } => Distance::flat(normal.dot(&(x - point)), *normal, true),
            Shape::Sphere { center, radius, sign, .. } => {
                let r = x - center;
                let length = r.norm();
                let n = r.try_normalize(0.0).unwrap_or_default();
                let curvature = if length > 0.0 { (Matrix3::identity() - n * n.transpose()) * (sign / length) } else { Matrix3::zeros() };
                Distance { gap: sign * (length - radius), normal: n * *sign, curvature, covered: true }
            }
            Shape::Revolved { origin, axis, profile } => {
                let ([rho, z], out) = polar(x - origin, *axis);
                let Local { value, slope, curvature } = profile.at([rho, z]);
                let mut sum = Matrix3::zeros();
                for (i, a) in [out, *axis].iter().enumerate() {
                    for (k, b) in [out, *axis].iter().enumerate() {
                        sum += a * b.transpose() * curvature[i][k];
                    }
                }
                if rho > 0.0 {
                    sum += (Matrix3::identity() - axis * axis.transpose() - out * out.transpose()) * (slope[0] / rho);
                }
                Distance { gap: value, normal: out * slope[0] + axis * slope[1], curvature: sum, covered: true }
            }
            Shape::Facets(facets) => facets.distance(x),
            Shape::Side(facets, side) => facets.side_distance(*side, x),
        }
    }

    fn step_gradient(&self, x_0: Vector3<f64>, x_1: Vector3<f64>, size: f64) -> StepGradient<3> {
        match self {
            Shape::Plane { normal, .. } => StepGradient::fixed(*normal),
            Shape::Sphere { center, sign, .. } => mean_direction(x_0 - center, x_1 - center, *sign),
            Shape::Revolved { origin, axis, profile } => {
                let [r_0, r_1] = [x_0 - origin, x_1 - origin];
                let ((from, _), (to, out)) = (polar(r_0, *axis), polar(r_1, *axis));
                let middle = profile.at([0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1])]);
                let d = [to[0] - from[0], to[1] - from[1]];
                let (flat, slopes) = corrected(profile.at(from).value, &middle, &profile.at(to), d, size);
                let across = |r: Vector3<f64>| r - axis * axis.dot(&r);
                let around = mean_direction(across(r_0), across(r_1), 1.0);
                let mut tangent = flat[0] * (around.tangent - around.tangent * axis * axis.transpose());
                for (i, to) in [around.bar, *axis].iter().enumerate() {
                    tangent += to * (out * slopes[i][0] + axis * slopes[i][1]).transpose();
                }
                StepGradient { bar: around.bar * flat[0] + axis * flat[1], tangent }
            }
            Shape::Facets(_) | Shape::Side(..) => {
                let at = |x: Vector3<f64>| {
                    let Distance { gap, normal, curvature, .. } = self.at(x);
                    Local { value: gap, slope: normal.into(), curvature: curvature.into() }
                };
                let (start, middle, end) = (at(x_0).value, at(0.5 * (x_0 + x_1)), at(x_1));
                let (bar, tangent) = corrected(start, &middle, &end, (x_1 - x_0).into(), size);
                StepGradient { bar: bar.into(), tangent: Matrix3::from_fn(|i, k| tangent[i][k]) }
            }
        }
    }

    fn sides_of_node(&self) -> usize {
        if matches!(self, Shape::Facets(facets) if facets.has_pockets()) { SIDES } else { 1 }
    }

    fn pocket(&self, x: Vector3<f64>, near: f64) -> Vec<Self> {
        let Shape::Facets(facets) = self else { return Vec::new() };
        let mut sides = facets.around(x, near);
        sides.truncate(SIDES);
        // Sides are in an order independent of their distances, so that multipliers stay with their sides.
        sides.sort_unstable();
        sides.into_iter().map(|side| Shape::Side(facets.clone(), side)).collect()
    }

    fn at_edge(&self, x: Vector3<f64>, near: f64) -> Option<AtEdge<3>> {
        if let Shape::Facets(facets) = self { facets.at_edge(x, near) } else { None }
    }

    /// Plane of a face in front of which the surface next to the node lies, or a plane through the edge.
    fn plane_at_edge(&self, node: &NodeAtEdge<3>) -> Option<Self> {
        let mut planes = node.at.points.iter().zip(&node.at.normals).map(|(point, normal)| [*point, *normal]);
        let of_face = planes.find(|[_, normal]| node.is_on_edge() && node.is_in_front(*normal));
        let through_edge = || node.plane_through().filter(|_| node.is_beside_corners && !node.is_on_edge());
        of_face.or_else(through_edge).map(|[point, normal]| Shape::Plane { point, normal })
    }

    fn takes_rims(&self) -> bool {
        match self {
            Shape::Plane { .. } | Shape::Facets(_) | Shape::Side(..) => true,
            Shape::Revolved { profile, .. } => matches!(profile, Profile::Cylinder { .. }),
            Shape::Sphere { .. } => false,
        }
    }

    fn is_one_sided(&self) -> bool {
        match self {
            Shape::Plane { .. } => true,
            Shape::Sphere { sign, .. } => *sign < 0.0,
            Shape::Revolved { profile: Profile::Cylinder { sign, .. } | Profile::Cone { sign, .. }, .. } => *sign < 0.0,
            _ => false,
        }
    }

    fn crosses_surface(&self, x_0: Vector3<f64>, x_1: Vector3<f64>) -> Option<bool> {
        if let Shape::Facets(facets) = self { Some(facets.is_crossed(x_0, x_1)) } else { None }
    }
}

/// Distance from an axis, height along it, and unit vector away from the axis.
fn polar(r: Vector3<f64>, axis: Vector3<f64>) -> ([f64; 2], Vector3<f64>) {
    let z = axis.dot(&r);
    let across = r - axis * z;
    ([across.norm(), z], across.try_normalize(0.0).unwrap_or_default())
}

/// Discrete gradient of the length of a vector times `sign`, parallel to the vector at mid-step.
fn mean_direction(r_0: Vector3<f64>, r_1: Vector3<f64>, sign: f64) -> StepGradient<3> {
    let lengths = r_0.norm() + r_1.norm();
    if lengths == 0.0 {
        return StepGradient::fixed(Vector3::zeros());
    }
    let bar = (r_0 + r_1) * (sign / lengths);
    let toward = r_1.try_normalize(0.0).unwrap_or_default();
    StepGradient { bar, tangent: (Matrix3::identity() * sign - bar * toward.transpose()) / lengths }
}
