//! Options for the local frame (axis and direction) of stress and strain components.

use crate::dynamics::{LocalFrame, Model};
use crate::script::language::causes;
use crate::script::language::prelude::*;

/// The keys of a local frame.
pub(super) fn frame_parameters() -> [Parameter; 3] {
    let optional = |name, summary, absent| Parameter::vector(name, summary).otherwise(absent);
    [
        optional("center", "a point of the axis of radial, tangential and axial components", "the origin").of("length"),
        optional("axis", "the direction of that axis, in space", "[0, 0, 1]").of("1"),
        optional("direction", "the direction of `stress_along` and `strain_along`, the normal of the plane of `traction`", "along x")
            .of("1"),
    ]
}

/// Geometry of a model, which determines the axes that a local frame may have.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Geometry {
    /// Plane strain or plane stress: the axis is normal to the plane.
    Plane,
    /// Bodies of revolution: the axis is the second coordinate axis.
    Revolution,
    /// Bodies in space.
    Space,
}

impl Geometry {
    /// Geometry of a model.
    pub(super) fn of(model: &Model) -> Self {
        match model.dimension() {
            _ if model.is_axisymmetric() => Geometry::Revolution,
            2 => Geometry::Plane,
            _ => Geometry::Space,
        }
    }

    /// Number of coordinates.
    pub(super) fn dimension(self) -> usize {
        if self == Geometry::Space { 3 } else { 2 }
    }
}

/// The local frame that options give.
///
/// # Errors
/// A vector of the wrong length or without a direction, an axis in the plane, or an axis or center of bodies of revolution.
pub(super) fn frame_of(options: &Options, geometry: Geometry) -> Result<LocalFrame, Failure> {
    let (mut frame, dimension) = (LocalFrame::default(), geometry.dimension());
    let [center, axis, direction] = ["center", "axis", "direction"].map(|name| options.argument(name));
    if geometry == Geometry::Revolution {
        frame.axis = [0.0, 1.0, 0.0];
        if let Some(argument) = [&center, &axis].into_iter().find(|argument| argument.is_given()) {
            let failure =
                argument.refuse(causes::DIMENSION, format!("bodies of revolution have their own axis, and take no {}", argument.title()));
            return Err(failure.hint("leave it out: radial is along x, axial along y, tangential around the axis"));
        }
    }
    if center.is_given() {
        frame.center = center.vector(dimension)?;
    }
    if axis.is_given() && dimension == 2 {
        let failure = axis.wrong(causes::DIMENSION, "is for bodies in space").label("these bodies are plane");
        return Err(failure.hint("leave it out: radial and tangential components are those about `center`"));
    }
    if axis.is_given() {
        frame.axis = axis.vector(3)?;
    }
    if direction.is_given() {
        frame.direction = direction.vector(dimension)?;
    }
    for (argument, vector) in [(&axis, frame.axis), (&direction, frame.direction)] {
        if vector == [0.0; 3] {
            return Err(argument.wrong(causes::NO_DIRECTION, "has no direction").hint("write one such as `[1, 0, 0]`"));
        }
    }
    Ok(frame)
}
