//! Exact joints between bodies, rigid or not, and to the ground.

use super::amplitude::Amplitude;
use super::quantity::Quantity;
use crate::math::norms::length;

/// One end of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchor {
    /// Index of the body; `None`: the ground.
    pub body: Option<usize>,
    /// Reference position `[length]`: any point of a rigid body, the nearest node of a deformable one.
    pub point: [f64; 3],
}

/// Kind of a joint: its free relative motions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointKind {
    /// Common point: a hinge in the plane, a ball joint in space.
    Point,
    /// Rotation about an axis in space, given in the reference positions.
    Hinge([f64; 3]),
    /// Translation along a line of the first end, without rotation, given by its initial direction.
    Slider([f64; 3]),
    /// A point of the second end on a line of the first, given by its initial direction.
    Slot([f64; 3]),
    /// No free motion.
    Weld,
    /// Constant distance between both points; all other motions are free.
    Link,
    /// Distance of both points up to this value `[length]`: a cable, slack or taut.
    Cable(f64),
    /// Constant sum `s_1 + ratio s_2` of the coordinates (angle or displacement) of two earlier joints. The ends are those of the first.
    Gear(Gear),
}

/// Two joints whose coordinates change in a fixed ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gear {
    /// Indices of the joints in the model.
    pub joints: [usize; 2],
    /// Factor of the second coordinate: positive for wheels that rotate in opposite directions.
    pub ratio: f64,
}

/// Free coordinate of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinate {
    /// Rotation of the second end relative to the first about the axis, zero in the reference positions `[rad]`.
    Angle,
    /// Displacement of the second point along the direction of the first end, zero in the reference positions `[length]`.
    Travel,
    /// Distance of both points `[length]`.
    Distance,
}

impl Coordinate {
    /// Name of the coordinate.
    pub fn name(self) -> &'static str {
        match self {
            Coordinate::Angle => "angle",
            Coordinate::Travel => "travel",
            Coordinate::Distance => "distance",
        }
    }

    /// Name and dimension of the coordinate.
    pub fn quantity(self) -> Quantity {
        Quantity::new(self.name(), if self == Coordinate::Angle { "rad" } else { "length" })
    }

    /// Power of length in the dimension of the coordinate: 0 for an angle.
    pub fn lengths(self) -> i32 {
        if self == Coordinate::Angle { 0 } else { 1 }
    }
}

impl JointKind {
    /// Free coordinate that can be prescribed or limited; `None` without one.
    pub fn coordinate(self, dimension: usize) -> Option<Coordinate> {
        match self {
            JointKind::Point if dimension == 2 => Some(Coordinate::Angle),
            JointKind::Hinge(_) => Some(Coordinate::Angle),
            JointKind::Slider(_) | JointKind::Slot(_) => Some(Coordinate::Travel),
            JointKind::Link | JointKind::Cable(_) => Some(Coordinate::Distance),
            JointKind::Point | JointKind::Weld | JointKind::Gear(_) => None,
        }
    }

    /// Number of leading constraints that are components of the transverse reaction, perpendicular to the free motion; 0 for a
    /// distance, and for joints without a free motion.
    pub fn reactions(self, dimension: usize) -> usize {
        match self.coordinate(dimension) {
            Some(Coordinate::Angle) => dimension,
            Some(Coordinate::Travel) => dimension - 1,
            None if self.is_ball(dimension) => dimension,
            Some(Coordinate::Distance) | None => 0,
        }
    }

    /// True for a ball joint: its ends rotate relative to each other about any axis.
    pub fn is_ball(self, dimension: usize) -> bool {
        dimension == 3 && self == JointKind::Point
    }

    /// True if the free motion is a rotation, whose friction is a moment.
    pub fn rotates(self, dimension: usize) -> bool {
        self.is_ball(dimension) || self.coordinate(dimension) == Some(Coordinate::Angle)
    }

    /// Name of the kind of joint.
    pub fn name(self) -> &'static str {
        match self {
            JointKind::Point => "point",
            JointKind::Hinge(_) => "hinge",
            JointKind::Slider(_) => "slider",
            JointKind::Slot(_) => "slot",
            JointKind::Weld => "weld",
            JointKind::Link => "link",
            JointKind::Cable(_) => "cable",
            JointKind::Gear(_) => "gear",
        }
    }

    /// Axis or direction of the joint; `None` for joints without one.
    pub fn direction(self) -> Option<[f64; 3]> {
        match self {
            JointKind::Hinge(direction) | JointKind::Slider(direction) | JointKind::Slot(direction) => Some(direction),
            JointKind::Point | JointKind::Weld | JointKind::Link | JointKind::Cable(_) | JointKind::Gear(_) => None,
        }
    }

    /// Returns the kind of joint with its direction, if any, replaced by `turned(direction)`.
    pub fn along(self, turned: impl Fn([f64; 3]) -> [f64; 3]) -> JointKind {
        match self {
            JointKind::Hinge(direction) => JointKind::Hinge(turned(direction)),
            JointKind::Slider(direction) => JointKind::Slider(turned(direction)),
            JointKind::Slot(direction) => JointKind::Slot(turned(direction)),
            JointKind::Point | JointKind::Weld | JointKind::Link | JointKind::Cable(_) | JointKind::Gear(_) => self,
        }
    }

    /// True if end `end` needs body-fixed directions, which nodes of deformable bodies do not have.
    pub(super) fn turns(self, end: usize) -> bool {
        match self {
            JointKind::Point | JointKind::Link | JointKind::Cable(_) | JointKind::Gear(_) => false,
            JointKind::Slot(_) => end == 0,
            JointKind::Hinge(_) | JointKind::Slider(_) | JointKind::Weld => true,
        }
    }
}

/// Dry friction of the free motion of a joint. The magnitude `L` of a friction force, or of a friction moment with the radius `r` of a
/// rotation (1 for a displacement or distance), is at most
///
/// ```text
/// L = mu r (|R| + P) + M
/// ```
///
/// with the transverse reaction `R` of the joint, the preload `P` and the friction `M` that does not depend on the reaction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointFriction {
    /// Friction coefficient `mu`.
    pub coefficient: f64,
    /// Radius `r` of the bearing surface of a rotation `[length]`.
    pub radius: f64,
    /// Preload `P`: normal force in addition to the reaction `[force]`.
    pub preload: f64,
    /// Constant friction `M`: a force or, of a rotation, a moment.
    pub constant: f64,
}

impl JointFriction {
    /// Coefficients `[a, b]` of the friction limit `L = a |R| + b`: moments for a rotation, forces otherwise.
    pub fn limit(&self, rotates: bool) -> [f64; 2] {
        let by_reaction = self.coefficient * if rotates { self.radius } else { 1.0 };
        [by_reaction, by_reaction * self.preload + self.constant]
    }
}

/// An exact joint: constraints, no stiffness.
#[derive(Clone)]
pub struct JointDefinition {
    /// Name, unique among joints.
    pub name: String,
    /// Kind of the joint.
    pub kind: JointKind,
    /// Connected points.
    pub ends: [Anchor; 2],
    /// Prescribed coordinate over time, or length of a cable; `None` without a drive.
    pub drive: Option<Amplitude>,
    /// Minimum and maximum of the coordinate; `None` without stops.
    pub limits: Option<[f64; 2]>,
    /// Dry friction of the free motion; `None` without friction.
    pub friction: Option<JointFriction>,
}

impl JointDefinition {
    /// Bodies connected by the joint.
    pub fn bodies(&self) -> impl Iterator<Item = usize> {
        self.ends.iter().filter_map(|end| end.body)
    }

    /// First time after the start at which the rate of the drive jumps, among the known kinks of its time function; `None` without one.
    pub fn jump(&self) -> Option<f64> {
        self.drive.as_ref()?.jump()
    }

    /// Value of the coordinate in the reference positions.
    pub fn at_rest(&self) -> f64 {
        match self.kind {
            JointKind::Cable(longest) => longest,
            JointKind::Link => length(self.distance()),
            _ => 0.0,
        }
    }

    /// True if the joint has unilateral constraints: stops or a cable.
    pub(crate) fn holds_one_way(&self) -> bool {
        self.limits.is_some() || matches!(self.kind, JointKind::Cable(_))
    }

    /// True if one end is fixed to the ground.
    pub fn is_grounded(&self) -> bool {
        self.ends.iter().any(|end| end.body.is_none())
    }

    /// Vector from the first point to the second in the undeformed model `[length]`.
    pub fn distance(&self) -> [f64; 3] {
        std::array::from_fn(|i| self.ends[1].point[i] - self.ends[0].point[i])
    }
}
