//! A running simulation, free of the space dimension.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use super::error::{ModelError, StepError};
use super::fields::BodyFields;
use super::ledger::LedgerRow;
use super::model::Model;
use crate::integrators::Integrator;

/// How a model is integrated.
#[derive(Clone, Debug)]
pub struct Options {
    /// Time integrator.
    pub integrator: Integrator,
    /// Nominal step size `[time]`.
    pub dt: f64,
    /// Newton's tolerance: the energy that the residual can still move, relative to the energy scale.
    pub tolerance: f64,
    /// How often a step may be halved.
    pub max_halvings: usize,
    /// Threads of the element loop; results do not depend on it.
    pub threads: usize,
    /// A flag that ends the run at the last accepted step when it becomes true.
    pub interrupt: Option<Arc<AtomicBool>>,
}

impl Options {
    /// Defaults for an integrator and a step size.
    pub fn new(integrator: Integrator, dt: f64) -> Self {
        Options { integrator, dt, tolerance: crate::math::tolerances::NEWTON_ENERGY, max_halvings: 7, threads: 1, interrupt: None }
    }
}

/// Wall-clock time by phase since the simulation was made.
#[derive(Clone, Copy, Debug, Default)]
pub struct PhaseTimes {
    /// Element loop: residual and tangent.
    pub assembly: Duration,
    /// Contact functions and their tangents.
    pub contact: Duration,
    /// Symbolic and numeric factorisation.
    pub factorization: Duration,
    /// Forward and backward substitution with refinement.
    pub solve: Duration,
    /// Search for candidate pairs.
    pub search: Duration,
}

/// Counters since the simulation was made.
#[derive(Clone, Copy, Debug, Default)]
pub struct Statistics {
    /// Accepted steps.
    pub steps: usize,
    /// Newton iterations, those of refused steps included.
    pub newton_iterations: usize,
    /// Halvings.
    pub halvings: usize,
    /// Numeric factorisations.
    pub factorizations: usize,
    /// Time by phase.
    pub times: PhaseTimes,
}

/// What `settle` did.
#[derive(Clone, Debug)]
pub struct SettleReport {
    /// Damped steps taken.
    pub steps: usize,
    /// Newton iterations in total.
    pub newton_iterations: usize,
    /// Strain energy of the equilibrium `[energy]`.
    pub strain: f64,
    /// Active contact nodes.
    pub active: usize,
}

/// Everything that the future of a simulation depends on. A value: keep it, restore it, branch from it.
#[derive(Clone, Debug)]
pub struct State {
    /// Time `[time]`.
    pub time: f64,
    /// The ledger's row of this state.
    pub row: LedgerRow,
    /// Positions of all nodes `[length]`.
    pub positions: Vec<f64>,
    /// Velocities of all nodes `[length/time]`.
    pub velocities: Vec<f64>,
}

/// A running simulation.
pub struct Simulation {}

impl Simulation {
    /// Builds the kernels of a model in its initial configuration.
    ///
    /// # Errors
    /// A model that cannot be simulated ([`Model::check`], inverted cells).
    pub fn new(model: &Model, options: Options) -> Result<Self, ModelError> {
        let _ = (model, options);
        todo!()
    }

    /// Space dimension.
    pub fn dimension(&self) -> usize {
        todo!()
    }

    /// Options it was made with.
    pub fn options(&self) -> &Options {
        todo!()
    }

    /// Number of free displacement components.
    pub fn unknowns(&self) -> usize {
        todo!()
    }

    /// Current time `[time]`.
    pub fn time(&self) -> f64 {
        todo!()
    }

    /// The ledger's row of the current state.
    pub fn row(&self) -> &LedgerRow {
        todo!()
    }

    /// Takes one nominal step (shorter when `end` comes first, so that `end` is hit exactly), in pieces where it must be halved.
    /// `accepted` is called with the ledger's row of every accepted piece.
    ///
    /// # Errors
    /// The step that failed; the simulation then stands at its last accepted piece.
    pub fn step(&mut self, end: Option<f64>, accepted: &mut dyn FnMut(&LedgerRow)) -> Result<(), StepError> {
        let _ = (end, accepted);
        todo!()
    }

    /// Brings the model to static equilibrium by damped steps, without letting time pass; velocities stay as they are.
    ///
    /// # Errors
    /// No equilibrium was found; the simulation is as it was before.
    pub fn settle(&mut self) -> Result<SettleReport, StepError> {
        todo!()
    }

    /// The current state as a value.
    pub fn state(&self) -> State {
        todo!()
    }

    /// Goes on from a state of this simulation (or of one of the same model).
    pub fn restore(&mut self, state: &State) {
        let _ = state;
        todo!()
    }

    /// Nodal fields of every body.
    pub fn fields(&self) -> Vec<BodyFields> {
        todo!()
    }

    /// Counters and times so far.
    pub fn statistics(&self) -> Statistics {
        todo!()
    }

    /// End of the last step in which a load acted, 0 when none did so far `[time]`.
    pub fn loads_ended(&self) -> f64 {
        todo!()
    }
}
