//! Nodes of boundaries that equations couple: planes of symmetry, periodic pairs, reference bodies.

use nalgebra::{Rotation3, Unit, Vector3};

use super::amplitude::Amplitude;
use super::interactions::BodyBoundary;

/// A named set of equations between nodes.
#[derive(Clone)]
pub struct Coupling {
    /// Name, unique among couplings.
    pub name: String,
    /// Kind of the coupling.
    pub kind: CouplingKind,
}

/// Kind of a coupling: its equations.
#[derive(Clone)]
pub enum CouplingKind {
    /// Nodes stay in their initial planes, as in a plane of symmetry or on rollers: `n . (x - X) = 0`.
    Plane {
        /// Boundary of the nodes.
        on: BodyBoundary,
        /// Normal of the planes, of any length.
        normal: [f64; 3],
    },
    /// Each node of one boundary has the rotated motion of its counterpart: `x_b - R x_a = X_b - R X_a + d(t) + x_h - X_h`.
    Periodic {
        /// Boundary of the nodes `a`.
        from: BodyBoundary,
        /// Boundary of the nodes `b`.
        to: BodyBoundary,
        /// Rotation that maps the first boundary onto the second; `None`: a translation.
        turn: Option<Sector>,
        /// Relative displacement of the second boundary along each axis over time, zero at the start `[length]`: a mean strain. `None`:
        /// zero.
        offset: [Option<Amplitude>; 3],
        /// Index of a rigid body whose center `h` gives the relative displacement of the second boundary: its displacement is the mean
        /// strain, the force on it the mean stress. `None` without such a body.
        follows: Option<usize>,
    },
    /// A boundary of a deformable body moves with a rigid body, which stands for a reference point.
    Reference {
        /// The boundary, with nodes `a`.
        on: BodyBoundary,
        /// Index of the rigid body.
        to: usize,
        /// True if each node moves as a point of the rigid body, so that the boundary stays as it is; false if only its mean motion is that
        /// of the rigid body, `sum w_a (x_a - X_a(R, t)) = 0` and `sum w_a R r_a x x_a = 0` with the shares `w_a` of the area and the arms
        /// `r_a` from the centroid at rest: the boundary deforms freely, and the force on the rigid body is distributed.
        is_rigid: bool,
    },
}

/// Rotation about an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sector {
    /// A point of the axis `[length]`.
    pub center: [f64; 3],
    /// Unit vector of the axis.
    pub axis: [f64; 3],
    /// Angle of the rotation `[rad]`.
    pub angle: f64,
}

impl Sector {
    /// Linear part of the rotation, about the direction of the axis.
    pub fn rotation(&self) -> Rotation3<f64> {
        Rotation3::from_axis_angle(&Unit::new_unchecked(Vector3::from(self.axis)), self.angle)
    }

    /// Image of a point under the rotation.
    pub fn carried(&self, point: [f64; 3]) -> [f64; 3] {
        let center = Vector3::from(self.center);
        (center + self.rotation() * (Vector3::from(point) - center)).into()
    }
}

impl CouplingKind {
    /// Boundaries joined by the coupling.
    pub fn boundaries(&self) -> Vec<&BodyBoundary> {
        match self {
            CouplingKind::Plane { on, .. } => vec![on],
            CouplingKind::Periodic { from, to, .. } => vec![from, to],
            CouplingKind::Reference { on, .. } => vec![on],
        }
    }

    /// Bodies joined by the coupling.
    pub fn bodies(&self) -> Vec<usize> {
        let follows = match self {
            CouplingKind::Plane { .. } => None,
            CouplingKind::Periodic { follows, .. } => *follows,
            CouplingKind::Reference { to, .. } => Some(*to),
        };
        self.boundaries().into_iter().map(|on| on.body).chain(follows).collect()
    }

    /// Time functions of the coupling.
    pub fn functions(&self) -> impl Iterator<Item = &Amplitude> {
        let offset = match self {
            CouplingKind::Plane { .. } | CouplingKind::Reference { .. } => None,
            CouplingKind::Periodic { offset, .. } => Some(offset.iter().flatten()),
        };
        offset.into_iter().flatten()
    }

    /// Name of the kind in messages.
    pub fn name(&self) -> &'static str {
        match self {
            CouplingKind::Plane { .. } => "symmetry",
            CouplingKind::Periodic { .. } => "periodic pair",
            CouplingKind::Reference { .. } => "reference coupling",
        }
    }
}
