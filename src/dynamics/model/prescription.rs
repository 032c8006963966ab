//! Nodes that move as time functions prescribe.

use nalgebra::Vector3;

use super::amplitude::{Amplitude, TimeFunctionError};
use super::interactions::BodyBoundary;

/// Prescribed displacement, rotation, or both, of the nodes of a boundary:
///
/// ```text
/// x(t) = X + d(t) + (R(angle(t)) - 1) (X - center)
/// ```
///
/// Without a turn the directions in which no displacement is given are free.
#[derive(Clone)]
pub struct Prescription {
    /// The nodes of this boundary.
    pub on: BodyBoundary,
    /// Displacement `d` in every direction over time `[length]`.
    pub displacement: [Option<Amplitude>; 3],
    /// Prescribed rotation, in addition to the displacements.
    pub turn: Option<AxisRotation>,
}

/// Rotation about an axis.
#[derive(Clone)]
pub struct AxisRotation {
    /// A point of the axis in the reference configuration `[length]`.
    pub center: [f64; 3],
    /// Unit vector of the axis.
    pub axis: [f64; 3],
    /// The angle over time `[rad]`.
    pub angle: Amplitude,
}

impl AxisRotation {
    /// Third axis, about which all rotations in the plane occur.
    pub const UPRIGHT: [f64; 3] = [0.0, 0.0, 1.0];
}

/// Prescribed motion at a given time.
pub struct PrescribedMotion<'a> {
    /// Displacement and velocity in each direction.
    shift: [[f64; 2]; 3],
    /// Rotation with its angle and the rate of the angle.
    turn: Option<(&'a AxisRotation, [f64; 2])>,
}

impl Prescription {
    /// Prescribed displacement in one direction (0, 1, 2: x, y, z); the others are free.
    pub fn along(on: BodyBoundary, component: usize, displacement: Amplitude) -> Self {
        let mut all = [const { None }; 3];
        all[component] = Some(displacement);
        Prescription { on, displacement: all, turn: None }
    }

    /// True if the prescription includes the displacement component `component`.
    pub fn moves(&self, component: usize) -> bool {
        self.turn.is_some() || self.displacement[component].is_some()
    }

    /// All time functions of the prescription.
    pub fn functions(&self) -> impl Iterator<Item = &Amplitude> {
        self.displacement.iter().flatten().chain(self.turn.as_ref().map(|turn| &turn.angle))
    }

    /// First time after the start at which the rate of the motion jumps, among the known kinks; `None` without one.
    pub fn jump(&self) -> Option<f64> {
        self.functions().filter_map(|function| function.jump()).min_by(f64::total_cmp)
    }

    /// The motion at a time; at time 0 with the rates after it.
    ///
    /// # Errors
    /// A time function failed, or returned no finite number.
    pub fn at(&self, time: f64) -> Result<PrescribedMotion<'_>, TimeFunctionError> {
        let mut shift = [[0.0; 2]; 3];
        for (values, function) in shift.iter_mut().zip(&self.displacement) {
            if let Some(function) = function {
                *values = at(function, time)?;
            }
        }
        let turn = self.turn.as_ref().map(|turn| at(&turn.angle, time).map(|values| (turn, values))).transpose()?;
        Ok(PrescribedMotion { shift, turn })
    }
}

/// Value and rate of a time function.
fn at(function: &Amplitude, time: f64) -> Result<[f64; 2], TimeFunctionError> {
    let (value, rate) = (function.value(time)?, function.rate_of_motion(time)?);
    match value.is_finite() && rate.is_finite() {
        true => Ok([value, rate]),
        false => Err(format!("the time function returned {value} with rate {rate}").into()),
    }
}

impl PrescribedMotion<'_> {
    /// Displacement `[length]` and velocity `[length/time]` in one direction, for a node initially at `place`.
    pub fn of(&self, place: [f64; 3], component: usize) -> (f64, f64) {
        let [value, rate] = self.shift[component];
        let Some((AxisRotation { center, axis, .. }, [angle, spin])) = self.turn else { return (value, rate) };
        let (axis, arm) = (Vector3::from(*axis), Vector3::from(place) - Vector3::from(center.to_owned()));
        let across = axis.cross(&arm);
        // Small for a small angle: (R - 1) r = sin a x r + (1 - cos) a x (a x r).
        let turned = across * angle.sin() + axis.cross(&across) * (2.0 * (0.5 * angle).sin().powi(2));
        let velocity = axis.cross(&(arm + turned)) * spin;
        (value + turned[component], rate + velocity[component])
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::dynamics::model::amplitude::Ramp;
    use crate::mesh::Boundary;

    /// A point goes around the axis, keeps its distance from it and its height, and moves with the speed of the circle.
    #[test]
    fn a_turn_is_a_rotation_about_its_axis() {
        let ramp = |value| Arc::new(Ramp { start: 0.0, end: 2.0, value }) as Amplitude;
        let axis = Vector3::new(1.0, 2.0, 2.0) / 3.0;
        let turn = AxisRotation { center: [0.3, -0.1, 0.2], axis: axis.into(), angle: ramp(3.0) };
        let on = BodyBoundary { body: 0, boundary: Boundary::of_facets("", Vec::new()) };
        let given = Prescription { on, displacement: [None, Some(ramp(0.5)), None], turn: Some(turn) };
        let place = [1.3, 0.4, -0.7];
        let arm = Vector3::from(place) - Vector3::new(0.3, -0.1, 0.2);
        for time in [1e-3, 0.7, 1.6] {
            let motion = given.at(time).unwrap();
            let (u, v): (Vec<f64>, Vec<f64>) = (0..3).map(|i| motion.of(place, i)).unzip();
            let turned = arm + Vector3::from_vec(u) - Vector3::new(0.0, 0.25 * time, 0.0);
            let exact = nalgebra::Rotation3::from_axis_angle(&nalgebra::Unit::new_normalize(axis), 1.5 * time) * arm;
            assert!((turned - exact).norm() < 1e-15 * (1.0 + 10.0 * time), "{turned} {exact}");
            let speed = Vector3::from_vec(v) - Vector3::new(0.0, 0.25, 0.0);
            assert!((speed - axis.cross(&exact) * 1.5).norm() < 1e-9);
        }
    }
}
