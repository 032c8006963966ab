//! The equations of a step at an iterate, as a value: forces, contact functions, tangent.
//!
//! There is no stored "last iterate": every evaluation reads the linearization that it is given.

use super::start::IterateInputs;
use crate::contact::Evaluation;
use crate::dynamics::model::part::Pose;

/// The equations of a step at an iterate.
#[derive(Default)]
pub struct Linearization {
    /// Positions of the nodes at the end of the step.
    pub q_1: Vec<f64>,
    /// Displacements from the reference positions, accurate relative to their own size, from which strains are computed.
    pub u_1: Vec<f64>,
    /// Displacement in the step: `q_1 - q_0`, with the accuracy of its own size. Velocities follow from it, however short the step.
    pub moved: Vec<f64>,
    /// Multipliers.
    pub lambda: Vec<f64>,
    /// Forces at the iterate.
    pub forces: Forces,
    /// Constraints of every contact pair.
    pub pairs: Vec<Evaluation>,
    /// Tangential constraints of every contact pair: slips as gaps, and the covered share of each node in mid-step.
    pub slips: Vec<Evaluation>,
    /// True for each tangential constraint whose slip supports prevent.
    pub held: Vec<bool>,
    /// Slip of each tangential constraint with which its slip rate at the end of the step is zero.
    pub rests: Vec<f64>,
    /// Values of the matrix without the rows and columns of constraints.
    pub tangent: Vec<f64>,
    /// Pattern number of `tangent`; `None` while it is not computed.
    pub(super) tangent_of: Option<usize>,
    /// Pattern number of the storage: unwritten entries are zero.
    pub(super) storage_of: Option<usize>,
}

impl Linearization {
    /// Positions and displacements.
    pub fn pose(&self) -> Pose<'_> {
        Pose { q: &self.q_1, u: &self.u_1 }
    }
}

/// Forces of a step at one iterate.
#[derive(Default)]
pub struct Forces {
    /// Share of the static forces in the equations of the step.
    pub weight: f64,
    /// Residual without contact forces.
    pub without_contact: Vec<f64>,
    /// Contact forces `Gbar^T lambda`, weighted.
    pub contact: Vec<f64>,
    /// Loads, weighted, gravity not included.
    pub load: Vec<f64>,
    /// Work of the internal forces over the step, to measure energies with.
    pub internal_work: f64,
    /// Largest internal, inertial or external force component, the scale of residuals.
    pub scale: f64,
    /// Largest component of the inertial forces, or of the damping forces at rest.
    pub opposing: f64,
}

impl Forces {
    /// Residual at an unknown, equal to the reaction of its support `[force]`.
    pub fn residual(&self, unknown: usize) -> f64 {
        self.without_contact[unknown] - self.contact[unknown]
    }

    /// Force before weighting by the integrator's share `weight` `[force]`.
    pub fn whole(&self, weighted: f64) -> f64 {
        weighted / self.weight
    }
}

/// Storage of discarded iterates, for reuse, and number of iterates in a step.
#[derive(Default)]
pub struct IterateStore {
    gone: Vec<Linearization>,
    /// Internal forces.
    pub(super) internal: Vec<f64>,
    /// Displacement on which the mass acts in the equations of a step.
    pub(super) motion: Vec<f64>,
    /// Velocities, positions of loads and mass factors passed to parts.
    pub(super) told: IterateInputs,
    /// Number of iterates in this step, and in the previous one.
    iterates: [usize; 2],
}

impl IterateStore {
    /// Resets the iterate count at the start of a step.
    pub fn begin_step(&mut self) {
        self.iterates = [0, self.iterates[0]];
    }

    /// Storage for another iterate of the step; true if it is probably the last one, by the count of the previous step.
    pub fn next(&mut self) -> (Linearization, bool) {
        self.iterates[0] += 1;
        (self.gone.pop().unwrap_or_default(), self.iterates[0] == self.iterates[1])
    }

    /// Takes over the storage of a discarded iterate.
    pub fn recycle(&mut self, at: Linearization) {
        self.gone.push(at);
    }
}
