//! Nodes of boundaries that linear equations couple: planes of symmetry, periodic pairs.

use nalgebra::{Rotation3, Unit, Vector3};

use super::amplitude::Amplitude;
use super::interactions::BodyBoundary;

/// A named set of linear equations between nodes.
#[derive(Clone)]
pub struct Coupling {
    /// Name, unique among couplings.
    pub name: String,
    /// What it couples.
    pub kind: CouplingKind,
}

/// What a coupling holds.
#[derive(Clone)]
pub enum CouplingKind {
    /// Nodes stay in the planes in which they are at rest, as in a plane of symmetry or on rollers: `n . (x - X) = 0`.
    Plane {
        /// The nodes.
        on: BodyBoundary,
        /// Normal of the planes, of any length.
        normal: [f64; 3],
    },
    /// Each node of one boundary moves as the node opposite to it moves, turned: `x_b - R x_a = X_b - R X_a + d(t) + x_h - X_h`.
    Periodic {
        /// Boundary of the nodes `a`.
        from: BodyBoundary,
        /// Boundary of the nodes `b`.
        to: BodyBoundary,
        /// The turn that carries the first onto the second; `None`: it is moved.
        turn: Option<Sector>,
        /// How the second moves against the first, along each axis over time, from zero on `[length]`: a mean strain. `None`: not at all.
        offset: [Option<Amplitude>; 3],
        /// A rigid body as whose center `h` the second moves against the first: its place is the mean strain, forces on it the mean
        /// stress. `None`: there is none.
        follows: Option<usize>,
    },
}

/// A turn about an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sector {
    /// A point of the axis `[length]`.
    pub center: [f64; 3],
    /// Its direction, of length 1.
    pub axis: [f64; 3],
    /// The angle `[rad]`.
    pub angle: f64,
}

impl Sector {
    /// The rotation.
    pub fn rotation(&self) -> Rotation3<f64> {
        Rotation3::from_axis_angle(&Unit::new_unchecked(Vector3::from(self.axis)), self.angle)
    }

    /// Where it carries a point.
    pub fn carried(&self, point: [f64; 3]) -> [f64; 3] {
        let center = Vector3::from(self.center);
        (center + self.rotation() * (Vector3::from(point) - center)).into()
    }
}

impl CouplingKind {
    /// The boundaries that it couples.
    pub fn boundaries(&self) -> Vec<&BodyBoundary> {
        match self {
            CouplingKind::Plane { on, .. } => vec![on],
            CouplingKind::Periodic { from, to, .. } => vec![from, to],
        }
    }

    /// The bodies that it joins.
    pub fn bodies(&self) -> Vec<usize> {
        let follows = match self {
            CouplingKind::Plane { .. } => None,
            CouplingKind::Periodic { follows, .. } => *follows,
        };
        self.boundaries().into_iter().map(|on| on.body).chain(follows).collect()
    }

    /// What it prescribes over time.
    pub fn functions(&self) -> impl Iterator<Item = &Amplitude> {
        let offset = match self {
            CouplingKind::Plane { .. } => None,
            CouplingKind::Periodic { offset, .. } => Some(offset.iter().flatten()),
        };
        offset.into_iter().flatten()
    }

    /// What it is.
    pub fn name(&self) -> &'static str {
        match self {
            CouplingKind::Plane { .. } => "symmetry",
            CouplingKind::Periodic { .. } => "periodic pair",
        }
    }
}
