//! Options of the integration, and counters of the work.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use serde::{Deserialize, Serialize};

use super::pace::StepControl;
use crate::dynamics::model::step_error::StepError;
use crate::dynamics::step::counters::PhaseTimes;
use crate::integrators::Scheme;
use crate::linear::{SolverCalls, SolverChoice, TakenOver, Work};

/// Options of the integration of a model.
#[derive(Clone, Debug)]
pub struct Options {
    /// Time integrator.
    pub integrator: Scheme,
    /// Nominal step size; initial size for adaptive steps, 0 to derive the size from the cells `[time]`.
    pub dt: f64,
    /// Step size control; `None`: constant nominal size.
    pub control: Option<StepControl>,
    /// Newton's tolerance of the energy error of a step (`step/convergence.rs`), relative to the energy scale.
    pub tolerance: f64,
    /// Linear solver; results agree within Newton's tolerance.
    pub solver: SolverChoice,
    /// Accept overlapping bodies: `settle` then does not check that bodies without contact forces are apart.
    pub accepts_overlap: bool,
    /// Largest number of halvings of a step.
    pub max_halvings: usize,
    /// Factor of the usual search horizon of contact. Results do not depend on it: pairs that take part in a step are selected afterwards.
    pub reach: f64,
    /// Threads of the element loop and of the factorisation; results do not depend on it.
    pub threads: usize,
    /// A flag that ends the run at the last accepted step when it becomes true.
    pub interrupt: Option<Arc<AtomicBool>>,
    /// Progress of a long factorization in thousandths; 0 while none runs.
    pub progress: Option<Arc<AtomicU32>>,
}

impl Options {
    /// Defaults for an integrator and a step size.
    pub fn new(integrator: &Scheme, dt: f64) -> Self {
        let tolerance = crate::math::tolerances::NEWTON_ENERGY;
        Options {
            integrator: *integrator,
            dt,
            control: None,
            tolerance,
            solver: SolverChoice::default(),
            accepts_overlap: false,
            max_halvings: 7,
            reach: 1.0,
            threads: 1,
            interrupt: None,
            progress: None,
        }
    }

    /// True if the user has interrupted the run.
    pub(super) fn interrupted(&self) -> bool {
        self.interrupt.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
    }

    /// Returns an interruption at `time` if the run was interrupted, else `error`: an interrupt also ends script closures, which may be the
    /// cause of `error`.
    pub(super) fn or_interrupted(&self, error: StepError, time: f64) -> StepError {
        if self.interrupted() { StepError::Interrupted { time } } else { error }
    }

    /// Refuses a result found while the run was interrupted: an interrupted time function may have returned no value.
    ///
    /// # Errors
    /// [`StepError::Interrupted`]: the run was interrupted.
    pub(super) fn undisturbed(&self, time: f64) -> Result<(), StepError> {
        if self.interrupted() { Err(StepError::Interrupted { time }) } else { Ok(()) }
    }
}

/// Counters since the simulation was made.
#[derive(Clone, Copy, Debug, Default)]
pub struct Statistics {
    /// Accepted steps.
    pub steps: usize,
    /// Newton iterations, including those of refused steps.
    pub newton_iterations: usize,
    /// Halvings of attempted steps; [`PresentState::halvings`](crate::dynamics::PresentState::halvings) counts all by cause.
    pub halvings: usize,
    /// Numeric factorisations.
    pub factorizations: usize,
    /// Factorizations of failed attempts and of undone steps.
    pub discarded: usize,
    /// Work of the linear solver since the program was started, including factorizations of refused steps.
    pub linear: Work,
    /// Calls of the two solvers, including those before a resume.
    pub solver_calls: SolverCalls,
    /// Matrices that the direct solver took over from the chosen one.
    pub taken_over: TakenOver,
    /// Evaluations of residual and tangent of all cells.
    pub assemblies: usize,
    /// Cells of all bodies.
    pub cells: usize,
    /// Memory of the matrix factors `[bytes]`.
    pub factor_bytes: usize,
    /// Time by phase.
    pub times: PhaseTimes,
}

/// Result of `settle`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
