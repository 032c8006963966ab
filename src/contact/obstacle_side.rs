//! Signed distances and discrete gradients of rigid obstacles for round parts of rigid bodies (`rolling.rs`, `space/rolling.rs`).

use nalgebra::{SMatrix, SVector};

/// Signed distance of a point from an obstacle, with gradient and Hessian.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local<const D: usize> {
    pub gap: f64,
    pub normal: SVector<f64, D>,
    pub curvature: SMatrix<f64, D, D>,
    /// True if the point is opposite the obstacle.
    pub covered: bool,
}

impl<const D: usize> Local<D> {
    /// Value at points that are not opposite the obstacle's surface: distance zero, without a gradient.
    pub fn none() -> Self {
        Local { gap: 0.0, normal: SVector::zeros(), curvature: SMatrix::zeros(), covered: false }
    }
}

/// A rigid obstacle, or one of its sides, for constraints of round parts. Points are in the frame of the obstacle.
pub(super) trait ObstacleSide<const D: usize>: Clone + Send + Sync {
    /// Largest number of sides of the obstacle that a round part touches simultaneously.
    fn sides(&self) -> usize;
    /// Sides that a round part of this radius about `x` may touch: at most [`Self::sides`], in an order independent of their distances.
    fn near(&self, x: SVector<f64, D>, radius: f64, spare: f64) -> Vec<Self>;
    /// Signed distance at a point.
    fn at(&self, x: SVector<f64, D>) -> Local<D>;
    /// Discrete gradient between two points, and its derivative with respect to the second one; `size` is the facet size `[length]`.
    fn between(&self, x_0: SVector<f64, D>, x_1: SVector<f64, D>, size: f64) -> (SVector<f64, D>, SMatrix<f64, D, D>);
    /// True if rims of cylinders touch the obstacle like a plane.
    fn takes_rims(&self) -> bool;
    /// Change of the distance on the straight path between two points, in units of `near`; and true if the path crosses the obstacle.
    fn passage(&self, x_0: SVector<f64, D>, x_1: SVector<f64, D>, near: f64) -> (f64, bool);
}
