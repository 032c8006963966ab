//! Signed distances and discrete gradients of rigid obstacles in the plane and in space, for the nodes of a surface (`rigid.rs`), arcs
//! about them (`node_arcs.rs`) and round parts of rigid bodies (`rolling.rs`).

use nalgebra::{SMatrix, SVector};

use super::edge_plane::{AtEdge, NodeAtEdge};
use crate::integrators::{Configuration, Derivative};
use crate::math::tolerances::PASSING;

/// Smallest and largest number of samples on a straight path at which its distance is evaluated.
const LOOKS: [f64; 2] = [8.0, 64.0];

/// Signed distance of a point from an obstacle, with gradient and Hessian.
#[derive(Clone, Copy, Debug)]
pub(super) struct Distance<const D: usize> {
    pub gap: f64,
    pub normal: SVector<f64, D>,
    pub curvature: SMatrix<f64, D, D>,
    /// True if the point is opposite the obstacle.
    pub covered: bool,
}

impl<const D: usize> Distance<D> {
    /// Value at points that are not opposite the obstacle's surface: distance zero, without a gradient.
    pub fn none() -> Self {
        Distance { gap: 0.0, normal: SVector::zeros(), curvature: SMatrix::zeros(), covered: false }
    }

    /// Distance from a plane with the given normal.
    pub fn flat(gap: f64, normal: SVector<f64, D>, covered: bool) -> Self {
        Distance { gap, normal, curvature: SMatrix::zeros(), covered }
    }
}

/// Discrete gradient of a distance, and its derivative with respect to the end point.
#[derive(Clone, Copy, Debug)]
pub(super) struct StepGradient<const D: usize> {
    pub bar: SVector<f64, D>,
    pub tangent: SMatrix<f64, D, D>,
}

impl<const D: usize> StepGradient<D> {
    /// Gradient that does not depend on the end point.
    pub fn fixed(bar: SVector<f64, D>) -> Self {
        StepGradient { bar, tangent: SMatrix::zeros() }
    }
}

/// A rigid obstacle, or one of its sides. Points are in the frame of the obstacle.
pub(super) trait ObstacleSide<const D: usize>: Clone + Send + Sync {
    /// Signed distance of a point; `None` where the function vanishes identically.
    fn distance(&self, x: SVector<f64, D>) -> Option<Distance<D>>;

    /// Signed distance of a point, see [`Distance::none`].
    fn at(&self, x: SVector<f64, D>) -> Distance<D> {
        self.distance(x).unwrap_or_else(Distance::none)
    }

    /// Discrete gradient between two points, not corrected for increments below `PROJECTED_INCREMENT * size`; `size` is the facet size
    /// `[length]`.
    fn step_gradient(&self, x_0: SVector<f64, D>, x_1: SVector<f64, D>, size: f64) -> StepGradient<D>;

    /// Algorithmic gradient of a step, and its derivative, for positions at the start, in the middle and at the end.
    fn gradient_of(&self, derivative: Derivative, [start, middle, end]: [SVector<f64, D>; 3], size: f64) -> StepGradient<D> {
        let (at, x) = match derivative {
            Derivative::DiscreteGradient => return self.step_gradient(start, end, size),
            Derivative::Gradient(at @ Configuration::Middle) => (at, middle),
            Derivative::Gradient(at @ Configuration::End) => (at, end),
        };
        let Distance { normal, curvature, .. } = self.at(x);
        StepGradient { bar: normal, tangent: curvature * at.share() }
    }

    /// Largest number of sides of the obstacle that a node touches simultaneously.
    fn sides_of_node(&self) -> usize {
        1
    }

    /// Sides that a node at `x` may touch if there are several within `near`: at most [`Self::sides_of_node`], in an order independent of
    /// their distances. Empty where a node touches the obstacle as a whole.
    fn pocket(&self, _x: SVector<f64, D>, _near: f64) -> Vec<Self> {
        Vec::new()
    }

    /// Largest number of sides of the obstacle that a round part touches simultaneously.
    fn sides(&self) -> usize {
        self.sides_of_node()
    }

    /// Sides that a round part of this radius about `x` may touch: at most [`Self::sides`], in an order independent of their distances.
    fn near(&self, x: SVector<f64, D>, radius: f64, spare: f64) -> Vec<Self> {
        Some(self.pocket(x, radius + spare)).filter(|sides| !sides.is_empty()).unwrap_or_else(|| vec![self.clone()])
    }

    /// Sharp edge or convex corner of the obstacle within `near` of a point.
    fn at_edge(&self, x: SVector<f64, D>, near: f64) -> Option<AtEdge<D>>;

    /// Plane in place of the obstacle for a node that starts a step at a sharp edge; `None` if the edge remains its obstacle.
    fn plane_at_edge(&self, node: &NodeAtEdge<D>) -> Option<Self>;

    /// True if rims of cylinders touch the obstacle like a plane.
    fn takes_rims(&self) -> bool;

    /// True for obstacles without a far side to which a node could cross.
    fn is_one_sided(&self) -> bool;

    /// True if the straight path between two outer points crosses the obstacle's surface; `None` for shapes that are sampled instead.
    fn crosses_surface(&self, x_0: SVector<f64, D>, x_1: SVector<f64, D>) -> Option<bool>;

    /// Range of the signed distance on the straight path between two points, with distances above `near` replaced by `near`.
    fn direction_change(&self, x_0: SVector<f64, D>, x_1: SVector<f64, D>, near: f64) -> f64 {
        // The distance changes by at most the path length, so that short paths need no samples.
        if self.is_one_sided() || (x_1 - x_0).norm() <= near * PASSING {
            return 0.0;
        }
        let gaps = looks(self, x_0, x_1, near).map(|gap| gap.min(near));
        let [low, high] = gaps.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], gap| [low.min(gap), high.max(gap)]);
        (high - low).max(0.0)
    }

    /// True if the straight path between two outer points crosses the obstacle to its other side.
    fn is_crossed(&self, x_0: SVector<f64, D>, x_1: SVector<f64, D>, near: f64) -> bool {
        if self.is_one_sided() {
            return false;
        }
        let [start, end] = [x_0, x_1].map(|x| self.at(x));
        if start.normal.dot(&end.normal) >= 0.0 || start.gap < 0.0 || end.gap < 0.0 {
            return false;
        }
        self.crosses_surface(x_0, x_1).unwrap_or_else(|| looks(self, x_0, x_1, near).any(|gap| gap < 0.0))
    }
}

/// Signed distances at samples of the straight path between two points.
fn looks<const D: usize, S: ObstacleSide<D>>(side: &S, x_0: SVector<f64, D>, x_1: SVector<f64, D>, near: f64) -> impl Iterator<Item = f64> {
    let count = (4.0 * (x_1 - x_0).norm() / near).ceil().clamp(LOOKS[0], LOOKS[1]);
    (0..=count as usize).filter_map(move |k| side.distance(x_0.lerp(&x_1, k as f64 / count)).map(|at| at.gap))
}
