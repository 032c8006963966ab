//! Section plane through bodies in space.

use super::view::{View, dot, unit};
use crate::math::tolerances::{FLAT, ON_SECTION};

/// Section plane through bodies in space: the part on the viewer's side is removed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutPlane {
    /// Point of the plane `[length]`; `None` for the center of the visible region.
    point: Option<[f64; 3]>,
    /// Unit normal toward the viewer.
    pub(super) normal: [f64; 3],
}

impl CutPlane {
    /// Returns the plane through a point with a normal of either sign; `None` for a zero normal, or if the plane is seen edge-on.
    pub fn new(point: Option<[f64; 3]>, normal: [f64; 3], view: &View) -> Option<Self> {
        let normal = unit(normal)?;
        let facing = dot(normal, view.toward);
        (facing.abs() > FLAT).then(|| CutPlane { point, normal: normal.map(|x| x * facing.signum()) })
    }

    /// Returns the plane, through `middle` if it has no point.
    pub(super) fn through(self, middle: [f64; 3]) -> Self {
        CutPlane { point: Some(self.point.unwrap_or(middle)), ..self }
    }

    /// True if all points lie on the viewer's side of the section plane, so that the section removes them.
    pub fn takes_all(&self, mut points: impl Iterator<Item = [f64; 3]>) -> bool {
        self.point.is_some_and(|point| points.all(|x| dot(self.normal, [0, 1, 2].map(|d| x[d] - point[d])) > 0.0))
    }

    /// Returns the heights of points above the plane; zero below round-off.
    pub(super) fn heights(&self, points: &[[f64; 3]]) -> Vec<f64> {
        let point = self.point.unwrap_or([0.0; 3]);
        let height = |x: &[f64; 3]| dot(self.normal, [0, 1, 2].map(|d| x[d] - point[d]));
        let heights: Vec<f64> = points.iter().map(height).collect();
        let largest = heights.iter().copied().filter(|height| height.is_finite()).fold(0.0, |most: f64, height| most.max(height.abs()));
        heights.into_iter().map(|height| if height.abs() <= ON_SECTION * largest { 0.0 } else { height }).collect()
    }
}
