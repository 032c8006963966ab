//! Progress of `settle`: damping, increments and limits of the next step from the outcome of previous steps.

use std::sync::Arc;

use super::closing::Closing;
use super::state::State;

/// Decay of the damping after an accepted step.
const LESS_DAMPING: f64 = 0.1;

/// Growth of the increment of a prescribed motion after an accepted step.
const LONGER: f64 = 2.0;

/// Imbalance relative to its tolerance, 1e-8 of the forces, that is accepted after [`MAX_RIPPLES`] steps without a reduction to [`NEARER`]
/// of the least one: a ring in a smooth race without friction is balanced at any angle up to ripples of its facets, and Newton's method
/// does not converge.
const RIPPLE: f64 = 1e3;
/// Number of steps after which [`RIPPLE`] is accepted. With eight steps instead of forty the patch test of dual multipliers in space
/// reaches 5e-9.
const MAX_RIPPLES: usize = 40;

/// Ratio of imbalance to the least one below which a step counts as progress towards equilibrium.
const NEARER: f64 = 0.9;

/// Effort and accuracy of the search for an equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SettleEffort {
    /// Search with all remedies if a damped step is refused.
    Patient,
    /// Search that ends where a damped step is refused, because the caller has another method.
    Exact,
    /// Search like `Exact` with a larger tolerance, for an intermediate equilibrium on a load path.
    Coarse,
}

/// Damping, increments and counters that the damped steps so far determine for the next one.
pub(super) struct Progress {
    pub(super) care: SettleEffort,
    /// Number of accepted damped steps.
    pub(super) steps: usize,
    /// Number of steps that closed a part of an overlap or followed a part of a prescribed motion.
    pub(super) parts: usize,
    /// Closing of initial overlaps in parts.
    pub(super) closing: Closing,
    /// Share of the remaining prescribed motion in the next step.
    pub(super) share: f64,
    /// Largest displacement of a prescribed node in a step `[length]`.
    pub(super) stride: f64,
    /// Number of refused attempts at the present step.
    pub(super) tries: usize,
    /// Damping relative to the damping that the unbalanced forces require.
    pub(super) excess: f64,
    /// Factor of the search horizon over the predicted motion.
    pub(super) leeway: f64,
    /// Displacements of the last step `[length]`.
    pub(super) motion: Vec<f64>,
    /// Largest displacement of each connected component in the last step `[length]`.
    pub(super) travelled: Option<Vec<f64>>,
    /// Number of steps in which no component moved.
    pub(super) stood: usize,
    /// Least imbalance so far, relative to its tolerance.
    pub(super) least: f64,
    /// Number of steps with increased damping that did not reduce the least imbalance.
    pub(super) stuck: usize,
    /// Number of states with satisfied contacts and prescribed motions, within the ripple limit, that did not reduce the least imbalance.
    ripples: usize,
    /// Least imbalance of a state with satisfied contacts and prescribed motions within the ripple limit, relative to its tolerance.
    least_ripple: f64,
    /// State at which only round-off was left, and its imbalance of sums and of nodes.
    pub(super) best: Option<(Arc<State>, [f64; 2])>,
    /// Round-off of the first displacements: what remains of displacements that return to zero `[length]`.
    pub(super) returned: f64,
}

impl Progress {
    pub(super) fn new(unknowns: usize, closing: Closing, stride: f64, care: SettleEffort) -> Self {
        Progress {
            care,
            steps: 0,
            parts: 0,
            closing,
            share: 1.0,
            stride,
            tries: 0,
            excess: 1.0,
            leeway: 1.0,
            motion: vec![0.0; unknowns],
            travelled: None,
            stood: 0,
            least: f64::INFINITY,
            stuck: 0,
            ripples: 0,
            least_ripple: f64::INFINITY,
            best: None,
            returned: 0.0,
        }
    }

    /// Records a step accepted from a state with this imbalance, its motion and the largest displacements of the components.
    pub(super) fn accepted(&mut self, imbalance: f64, travelled: Vec<f64>, motion: Vec<f64>, stands: f64) {
        if imbalance < NEARER * self.least {
            (self.least, self.stuck) = (imbalance, 0);
        } else if self.excess > 1.0 {
            self.stuck += 1;
        }
        self.stood += usize::from(travelled.iter().all(|&travelled| travelled < stands));
        (self.travelled, self.motion) = (Some(travelled), motion);
        (self.steps, self.tries) = (self.steps + 1, 0);
        self.closing.succeeded();
        self.share = (LONGER * self.share).min(1.0);
        (self.excess, self.leeway) = ((LESS_DAMPING * self.excess).max(1.0), 1.0);
    }

    /// Counts a state with satisfied contacts and prescribed motions, and with this imbalance; returns true if states within the ripple
    /// limit no longer approach equilibrium.
    pub(super) fn has_only_ripples(&mut self, imbalance: f64) -> bool {
        if imbalance > RIPPLE {
            return false;
        }
        self.ripples += usize::from(imbalance > NEARER * self.least_ripple);
        self.least_ripple = self.least_ripple.min(imbalance);
        self.ripples > MAX_RIPPLES
    }
}
