//! Exact joints between bodies, rigid or not, and to the ground.

use super::amplitude::Amplitude;
use crate::math::norms::length;
use crate::math::tolerances::{EQUAL, SMALL_TIME, TIME_DIFFERENCE};

/// One end of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchor {
    /// Index of the body; `None`: the ground.
    pub body: Option<usize>,
    /// The point at rest: any of a rigid body, the nearest node of one that deforms `[length]`.
    pub point: [f64; 3],
}

/// What a joint leaves free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointKind {
    /// One point in common: a hinge in the plane, a ball joint in space.
    Point,
    /// Turning about an axis in space, given at rest.
    Hinge([f64; 3]),
    /// Moving along a line of the first end, without turning; the direction at rest.
    Slider([f64; 3]),
    /// A point of the second end on a line of the first; the direction at rest.
    Slot([f64; 3]),
    /// Nothing.
    Weld,
    /// All but the distance of both points.
    Link,
    /// All, up to this distance of both points `[length]`: a cable that is slack or taut.
    Cable(f64),
    /// All but a sum of the coordinates of two joints before it, angles or travels: `s_1 + ratio s_2` stays. Its ends are those of the
    /// first.
    Gear(Gear),
}

/// Two joints whose coordinates change in a fixed ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gear {
    /// Their indices in the model.
    pub joints: [usize; 2],
    /// Factor of the second coordinate: positive where wheels turn against each other.
    pub ratio: f64,
}

/// What a joint leaves free, as one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinate {
    /// By how much the second end has turned against the first, from rest on, about the axis `[rad]`.
    Angle,
    /// How far the second point has moved along the direction of the first end, from rest on `[length]`.
    Travel,
    /// Distance of both points `[length]`.
    Distance,
}

impl Coordinate {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Coordinate::Angle => "angle",
            Coordinate::Travel => "travel",
            Coordinate::Distance => "distance",
        }
    }

    /// The power of a length that it is.
    pub fn lengths(self) -> i32 {
        if self == Coordinate::Angle { 0 } else { 1 }
    }
}

impl JointKind {
    /// The coordinate that it leaves free and that may be prescribed or limited, if there is one.
    pub fn coordinate(self, dimension: usize) -> Option<Coordinate> {
        match self {
            JointKind::Point if dimension == 2 => Some(Coordinate::Angle),
            JointKind::Hinge(_) => Some(Coordinate::Angle),
            JointKind::Slider(_) | JointKind::Slot(_) => Some(Coordinate::Travel),
            JointKind::Link | JointKind::Cable(_) => Some(Coordinate::Distance),
            JointKind::Point | JointKind::Weld | JointKind::Gear(_) => None,
        }
    }

    /// Its name.
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

    /// Its axis or direction.
    pub fn direction(self) -> Option<[f64; 3]> {
        match self {
            JointKind::Hinge(direction) | JointKind::Slider(direction) | JointKind::Slot(direction) => Some(direction),
            JointKind::Point | JointKind::Weld | JointKind::Link | JointKind::Cable(_) | JointKind::Gear(_) => None,
        }
    }

    /// The same with another direction, if it has one.
    pub fn along(self, turned: impl Fn([f64; 3]) -> [f64; 3]) -> JointKind {
        match self {
            JointKind::Hinge(direction) => JointKind::Hinge(turned(direction)),
            JointKind::Slider(direction) => JointKind::Slider(turned(direction)),
            JointKind::Slot(direction) => JointKind::Slot(turned(direction)),
            JointKind::Point | JointKind::Weld | JointKind::Link | JointKind::Cable(_) | JointKind::Gear(_) => self,
        }
    }

    /// Whether an end must have directions, which a node of a deformable body has not.
    pub(super) fn turns(self, end: usize) -> bool {
        match self {
            JointKind::Point | JointKind::Link | JointKind::Cable(_) | JointKind::Gear(_) => false,
            JointKind::Slot(_) => end == 0,
            JointKind::Hinge(_) | JointKind::Slider(_) | JointKind::Weld => true,
        }
    }
}

/// An exact joint: constraints, no stiffness.
#[derive(Clone)]
pub struct JointDefinition {
    /// Name, unique among joints.
    pub name: String,
    /// What it leaves free.
    pub kind: JointKind,
    /// What it joins.
    pub ends: [Anchor; 2],
    /// What its coordinate is over time, if a motor prescribes it; of a cable its length.
    pub drive: Option<Amplitude>,
    /// The least and the largest value of its coordinate, if stops limit it.
    pub limits: Option<[f64; 2]>,
}

impl JointDefinition {
    /// The bodies that it joins.
    pub fn bodies(&self) -> impl Iterator<Item = usize> {
        self.ends.iter().filter_map(|end| end.body)
    }

    /// The first time after the start at which the rate of its drive jumps, as far as that tells its corners.
    pub fn jump(&self) -> Option<f64> {
        let drive = self.drive.as_ref()?;
        // Beyond the differences by which a rate is found at a corner.
        let beside = |time: f64, side: f64| drive.rate(time + side * 4.0 * TIME_DIFFERENCE * time.abs().max(SMALL_TIME)).unwrap_or(0.0);
        let jumps = |time: &f64| {
            let [before, after] = [beside(*time, -1.0), beside(*time, 1.0)];
            (after - before).abs() > EQUAL * before.abs().max(after.abs())
        };
        drive.corners().into_iter().filter(|time| *time > 0.0).find(jumps)
    }

    /// Its coordinate where the bodies are at rest.
    pub fn at_rest(&self) -> f64 {
        match self.kind {
            JointKind::Cable(longest) => longest,
            JointKind::Link => length(self.distance()),
            _ => 0.0,
        }
    }

    /// Whether it has rows that press and do not pull.
    pub(crate) fn holds_one_way(&self) -> bool {
        self.limits.is_some() || matches!(self.kind, JointKind::Cable(_))
    }

    /// Whether the ground is one end.
    pub fn is_grounded(&self) -> bool {
        self.ends.iter().any(|end| end.body.is_none())
    }

    /// From the first point to the second at rest `[length]`.
    pub fn distance(&self) -> [f64; 3] {
        std::array::from_fn(|i| self.ends[1].point[i] - self.ends[0].point[i])
    }
}
