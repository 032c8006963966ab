//! Place of a rigid obstacle that has moved and turned, and the axis about which it turns.

use nalgebra::{Rotation3, Unit, Vector3};

/// Axis about which a rigid obstacle turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurningAxis {
    /// A point of the axis at the undisplaced obstacle `[length]`.
    pub center: [f64; 3],
    /// Unit vector of the axis; the third axis in the plane.
    pub direction: [f64; 3],
}

impl TurningAxis {
    /// Axis through a point; the direction has any length but 0.
    pub fn new(center: [f64; 3], direction: [f64; 3]) -> Self {
        TurningAxis { center, direction: Vector3::from(direction).normalize().into() }
    }

    /// Rotation by an angle about the axis.
    pub(super) fn rotation(&self, angle: f64) -> Rotation3<f64> {
        Rotation3::from_axis_angle(&Unit::new_unchecked(Vector3::from(self.direction)), angle)
    }

    /// Place of the obstacle that has turned by an angle and moved by `translation`.
    pub fn place(&self, angle: f64, translation: [f64; 3]) -> ObstaclePlacement {
        let (rotation, center) = (self.rotation(angle), Vector3::from(self.center));
        let translation = center + Vector3::from(translation) - rotation * center;
        ObstaclePlacement { rotation: (Vector3::from(self.direction) * angle).into(), translation: translation.into() }
    }

    /// Largest distance of points from the axis `[length]`.
    pub fn reach(&self, points: impl Iterator<Item = [f64; 3]>) -> f64 {
        let (center, direction) = (Vector3::from(self.center), Vector3::from(self.direction));
        points.map(|x| direction.cross(&(Vector3::from(x) - center)).norm()).fold(0.0, f64::max)
    }
}

/// Rigid motion of an obstacle from its undisplaced place: `x = R X + translation`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ObstaclePlacement {
    /// Rotation vector of `R` about the origin, its length the angle `[rad]`.
    pub rotation: [f64; 3],
    /// Translation after the rotation `[length]`.
    pub translation: [f64; 3],
}

impl ObstaclePlacement {
    /// Direction of the obstacle in space.
    pub fn direction(&self, vector: [f64; 3]) -> [f64; 3] {
        (Rotation3::new(Vector3::from(self.rotation)) * Vector3::from(vector)).into()
    }

    /// Point of the obstacle in space.
    pub fn point(&self, point: [f64; 3]) -> [f64; 3] {
        let turned = self.direction(point);
        [0, 1, 2].map(|i| turned[i] + self.translation[i])
    }

    /// Point of space in the frame of the obstacle.
    pub fn in_frame(&self, point: [f64; 3]) -> [f64; 3] {
        let from = Vector3::from(point) - Vector3::from(self.translation);
        (Rotation3::new(-Vector3::from(self.rotation)) * from).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_placement_and_its_inverse() {
        let axis = TurningAxis::new([1.0, 2.0, 0.0], [0.0, 0.0, 3.0]);
        let place = axis.place(std::f64::consts::FRAC_PI_2, [0.5, 0.0, 0.25]);
        let there = place.point([2.0, 2.0, 0.0]);
        assert!((0..3).all(|i| (there[i] - [1.5, 3.0, 0.25][i]).abs() < 1e-15), "{there:?}");
        let back = place.in_frame(there);
        assert!((0..3).all(|i| (back[i] - [2.0, 2.0, 0.0][i]).abs() < 1e-15), "{back:?}");
    }
}
