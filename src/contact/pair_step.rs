//! Weighted gaps of a facet pair (`pair.rs`) for standard or dual multiplier functions, and their discrete gradients (`mortar.rs`).

use super::multiplier_shapes::MultiplierFunctions;
use super::pair::{Invariants, Offsets, Overlap, PerNode};
use crate::integrators::{Configuration, Placement, discrete_gradient};
use crate::math::tolerances::{INVARIANT_INCREMENT, REMAINDER};

/// State of a facet pair at the start of the step.
#[derive(Clone, Copy, Debug)]
pub(super) struct PairStart {
    pub(super) offsets: Offsets,
    pub(super) invariants: Invariants,
    pub(super) value: PerNode<f64>,
    pub(super) overlaps: bool,
    /// True for each end of the overlap that is at a primary node at the start of the step; `None` without overlap.
    pub(super) steady_ends: Option<[bool; 2]>,
    pub(super) shape: MultiplierFunctions,
}

/// Scalar product.
#[inline(always)]
pub(super) fn dot(a: &Invariants, b: &Invariants) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4]
}

/// Covered length of each node's multiplier shape function `[length]`.
#[inline(always)]
pub(super) fn covered_length(shape: &MultiplierFunctions, pi: &Invariants, overlap: &Overlap) -> PerNode<f64> {
    combined(shape, &overlap.coverage()).map(|share| share * pi[0].sqrt())
}

/// Transforms values for the standard shape functions into values for the multiplier shape functions `shape`.
#[inline(always)]
pub(super) fn combined(shape: &MultiplierFunctions, of_standard: &PerNode<f64>) -> PerNode<f64> {
    shape.map(|row| row[0] * of_standard[0] + row[1] * of_standard[1])
}

/// Weighted gaps of an overlap; zero without overlap.
#[inline(always)]
pub(super) fn value(shape: &MultiplierFunctions, overlap: &Option<Overlap>) -> PerNode<f64> {
    overlap.as_ref().map_or([0.0; 2], |overlap| combined(shape, &overlap.value()))
}

/// Weighted gaps of an overlap and their gradients; zero without overlap.
#[inline(always)]
pub(super) fn value_and_gradient(shape: &MultiplierFunctions, overlap: &Option<Overlap>) -> (PerNode<f64>, PerNode<Invariants>) {
    overlap.as_ref().map_or(([0.0; 2], [[0.0; 5]; 2]), |overlap| {
        let (value, gradient) = overlap.value_and_gradient();
        (combined(shape, &value), shape.map(|row| weighted(&gradient, row)))
    })
}

/// Gradients of the weighted gaps of an overlap, and the Hessian of `weights[0] Phi_1 + weights[1] Phi_2`; zero without overlap. Without
/// weights the Hessian is not computed.
#[inline(always)]
fn derivatives(shape: &MultiplierFunctions, overlap: &Option<Overlap>, weights: PerNode<f64>) -> (PerNode<Invariants>, [Invariants; 5]) {
    if weights == [0.0; 2] {
        return (value_and_gradient(shape, overlap).1, [[0.0; 5]; 5]);
    }
    let standard = [0, 1].map(|k| shape[0][k] * weights[0] + shape[1][k] * weights[1]);
    overlap.as_ref().map_or(([[0.0; 5]; 2], [[0.0; 5]; 5]), |overlap| {
        let (gradient, hessian) = overlap.derivatives(standard);
        (shape.map(|row| weighted(&gradient, row)), hessian)
    })
}

/// Weighted sum `weights[0] f[0] + weights[1] f[1]`.
#[inline(always)]
pub(super) fn weighted(f: &PerNode<Invariants>, weights: PerNode<f64>) -> Invariants {
    std::array::from_fn(|k| weights[0] * f[0][k] + weights[1] * f[1][k])
}

/// Remainder of a discrete gradient: the change of a function from `start` to `end` less the product of its gradient at mid-step with the
/// increment `d` of the invariants.
#[inline(always)]
pub(super) fn remainder([start, end]: [f64; 2], gradient: &Invariants, d: &Invariants) -> f64 {
    end - start - dot(gradient, d)
}

/// Round-off of [`remainder`], for invariants with the round-off `of_invariants`.
#[inline(always)]
pub(super) fn round_off([start, end]: [f64; 2], gradient: &Invariants, d: &Invariants, of_invariants: f64) -> f64 {
    let sizes: f64 = gradient.iter().zip(d).map(|(g, d)| (g * d).abs()).sum();
    let steepness: f64 = gradient.iter().map(|g| g.abs()).sum();
    REMAINDER * (end.abs() + start.abs() + sizes) + of_invariants * steepness
}

/// True if the square of an increment of invariants is so small relative to the square of the invariants that the remainder of a discrete
/// gradient may be round-off, unless a kink lies between start and end.
#[inline(always)]
pub(super) fn is_doubtful(square: f64, of_invariants: f64) -> bool {
    square <= INVARIANT_INCREMENT * INVARIANT_INCREMENT * of_invariants
}

/// Values of a facet pair in a step from which the discrete gradients are computed.
pub(super) struct Functions<'a> {
    pub(super) start: &'a PairStart,
    pub(super) end_pi: &'a Invariants,
    pub(super) end_value: PerNode<f64>,
    pub(super) end_gradient: &'a PerNode<Invariants>,
    pub(super) middle: &'a Option<Overlap<'a>>,
    /// Multipliers of the normal constraints of both secondary nodes.
    pub(super) weights: PerNode<f64>,
    /// Round-off of the invariants `[length^2]`.
    pub(super) round_off: f64,
}

/// Weighted gaps of a facet pair, differentiated across a step with respect to the invariants.
pub(super) struct Differentiated {
    /// Algorithmic gradients of both functions.
    pub(super) bar: PerNode<Invariants>,
    /// Sum of the algorithmic gradients weighted by the multipliers.
    pub(super) weighted_bar: Invariants,
    /// Derivative of the weighted sum of the algorithmic gradients.
    pub(super) slope: [Invariants; 5],
}

impl Functions<'_> {
    /// Increment of the invariants.
    #[inline(always)]
    fn increment(&self) -> Invariants {
        std::array::from_fn(|k| self.end_pi[k] - self.start.invariants[k])
    }

    /// Discrete gradient with corrections `a` shared by all pairs of a node, whose derivatives are omitted.
    #[inline(always)]
    pub(super) fn with_correction(&self, a: PerNode<f64>) -> Differentiated {
        let (d, weights) = (self.increment(), self.weights);
        let (middle_gradient, mut slope) = derivatives(&self.start.shape, self.middle, weights.map(|weight| 0.5 * weight));
        let bar: PerNode<Invariants> = [0, 1].map(|k| std::array::from_fn(|l| middle_gradient[k][l] + a[k] * d[l]));
        for k in 0..5 {
            slope[k][k] += weights[0] * a[0] + weights[1] * a[1];
        }
        Differentiated { weighted_bar: weighted(&bar, weights), bar, slope }
    }

    /// Discrete gradient with the correction of this pair.
    #[inline(always)]
    pub(super) fn with_own_correction(&self) -> Differentiated {
        let (d, weights, end_value, start) = (self.increment(), self.weights, self.end_value, self.start);
        let (middle_gradient, hessian) = derivatives(&start.shape, self.middle, weights);
        let square = dot(&d, &d);
        let values = [0, 1].map(|k| [start.value[k], end_value[k]]);
        let remainder = [0, 1].map(|k| remainder(values[k], &middle_gradient[k], &d));
        let is_round_off = |k: usize| remainder[k].abs() <= round_off(values[k], &middle_gradient[k], &d, self.round_off);
        let is_dropped = is_doubtful(square, dot(self.end_pi, self.end_pi)) && is_round_off(0) && is_round_off(1);
        let threshold = if is_dropped { f64::INFINITY } else { 0.0 };
        let mut bar = middle_gradient;
        if square > threshold {
            for k in 0..2 {
                let a = remainder[k] / square;
                bar[k] = std::array::from_fn(|l| middle_gradient[k][l] + a * d[l]);
            }
        }
        let (weighted_bar, slope) = if weights != [0.0; 2] {
            discrete_gradient(
                &d,
                &weighted(&middle_gradient, weights),
                &hessian,
                &weighted(self.end_gradient, weights),
                weights[0] * remainder[0] + weights[1] * remainder[1],
                threshold,
            )
        } else {
            ([0.0; 5], [[0.0; 5]; 5])
        };
        Differentiated { bar, weighted_bar, slope }
    }

    /// Gradients at a single configuration, with the overlap there.
    #[inline(always)]
    pub(super) fn plain(&self, overlap: &Option<Overlap>, placement: Placement) -> Differentiated {
        let derivatives = || derivatives(&self.start.shape, overlap, self.weights.map(|weight| placement.share * weight));
        let (bar, slope) = match placement.trial {
            Configuration::End if self.weights == [0.0; 2] => (*self.end_gradient, [[0.0; 5]; 5]),
            Configuration::End => (*self.end_gradient, derivatives().1),
            _ => derivatives(),
        };
        Differentiated { weighted_bar: weighted(&bar, self.weights), bar, slope }
    }
}
