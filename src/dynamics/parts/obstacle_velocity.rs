//! Mean velocity of a rigid obstacle in a step, for the rates of constraints.

use nalgebra::Vector3;

/// Mean velocity of a rigid obstacle in a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct ObstacleVelocity {
    /// Velocity of its translation `[length/time]`.
    pub linear: [f64; 3],
    /// Angular velocity of an obstacle that turns about an axis, `2 tan(d) / dt` for a half angle `d` of the step `[rad/time]`.
    pub angular: [f64; 3],
    /// Position of a point of the axis at the end of the step `[length]`.
    pub pivot: [f64; 3],
}

impl ObstacleVelocity {
    /// Velocity of the obstacle, along unknown `k` of a model in `D` dimensions, at the node of that unknown at the positions `q`.
    pub fn along<const D: usize>(&self, k: usize, q: &[f64]) -> f64 {
        let of_translation = self.linear[k % D];
        if self.angular == [0.0; 3] {
            return of_translation;
        }
        let first = k - k % D;
        let arm = Vector3::from_fn(|i, _| if i < D { q[first + i] - self.pivot[i] } else { 0.0 });
        of_translation + Vector3::from(self.angular).cross(&arm)[k % D]
    }
}
