//! Distances and discrete gradients of obstacles for the round parts of rigid bodies, in the plane and in space.

use nalgebra::{SMatrix, SVector};

/// Distance from an obstacle of a point, its gradient and second derivative.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local<const D: usize> {
    pub gap: f64,
    pub normal: SVector<f64, D>,
    pub curvature: SMatrix<f64, D, D>,
    /// True where the point is opposite the obstacle.
    pub covered: bool,
}

impl<const D: usize> Local<D> {
    /// Distance where the obstacle has no surface: zero, without a gradient.
    pub fn none() -> Self {
        Local { gap: 0.0, normal: SVector::zeros(), curvature: SMatrix::zeros(), covered: false }
    }
}

/// A rigid obstacle, or a side of it, as the rows of round parts feel it. Points are in the frame of the obstacle.
pub(super) trait Felt<const D: usize>: Clone + Send + Sync {
    /// Largest number of sides of the obstacle that a round part touches at once.
    fn sides(&self) -> usize;
    /// The sides that a round part of this radius about `x` may touch: at most [`Self::sides`], in an order that does not depend on which
    /// is nearer.
    fn near(&self, x: SVector<f64, D>, radius: f64, spare: f64) -> Vec<Self>;
    /// Distance at a point.
    fn at(&self, x: SVector<f64, D>) -> Local<D>;
    /// Discrete gradient between two points and its derivative with respect to the second; `size` is that of facets.
    fn between(&self, x_0: SVector<f64, D>, x_1: SVector<f64, D>, size: f64) -> (SVector<f64, D>, SMatrix<f64, D, D>);
    /// True if rims of cylinders touch it where a plane in its place would.
    fn takes_rims(&self) -> bool;
    /// By how much the distance changes on the way between two points, in lengths of `near`, and whether the way leads through it.
    fn passage(&self, x_0: SVector<f64, D>, x_1: SVector<f64, D>, near: f64) -> (f64, bool);
}
