//! A running simulation, free of the space dimension.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::time::Duration;

use super::error::{ModelError, StepError};
use super::fields::{BodyFields, ContactFields};
use super::halvings::Halving;
use super::ledger::LedgerRow;
use super::model::Model;
use super::report::FailureReport;
use super::run_findings::{Measures, RunFinding, run_findings};
use super::system::SearchHistory;
use super::time_loop::TimeLoop;
use crate::integrators::Integrator;
use crate::linear::Work;

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
    /// Multiple of the usual reach of the search for contact. Results do not depend on it: what takes part in a step is decided afterwards.
    pub reach: f64,
    /// Threads of the element loop and of the factorisation; results do not depend on it.
    pub threads: usize,
    /// A flag that ends the run at the last accepted step when it becomes true.
    pub interrupt: Option<Arc<AtomicBool>>,
    /// A number that tells how far a long factorisation is, in thousandths; 0 while none runs.
    pub progress: Option<Arc<AtomicU32>>,
}

impl Options {
    /// Defaults for an integrator and a step size.
    pub fn new(integrator: Integrator, dt: f64) -> Self {
        let tolerance = crate::math::tolerances::NEWTON_ENERGY;
        Options { integrator, dt, tolerance, max_halvings: 7, reach: 1.0, threads: 1, interrupt: None, progress: None }
    }

    /// Whether the user wants the run to end.
    pub(super) fn interrupted(&self) -> bool {
        self.interrupt.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
    }

    /// An error, or the end of the run at `time` where the error is that of a time function: an interrupt also ends a script's closure
    /// that is just running.
    pub(super) fn or_interrupted(&self, error: StepError, time: f64) -> StepError {
        match error {
            StepError::Amplitude { .. } if self.interrupted() => StepError::Interrupted { time },
            error => error,
        }
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
    /// Halvings of steps that were tried; [`Simulation::halvings`] counts all, by their causes.
    pub halvings: usize,
    /// Numeric factorisations.
    pub factorizations: usize,
    /// What the linear solver has done, factorisations of refused steps included.
    pub linear: Work,
    /// Times that residual and tangent of all cells were computed.
    pub assemblies: usize,
    /// Cells of all bodies.
    pub cells: usize,
    /// Bytes of the factors.
    pub factor_bytes: usize,
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
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// The ledger's row of this state.
    pub row: LedgerRow,
    /// Positions of all nodes `[length]`, component by component, body after body.
    pub positions: Vec<f64>,
    /// Velocities of all nodes `[length/time]`.
    pub velocities: Vec<f64>,
    /// Multipliers of all contact pairs `[stress]`.
    pub(super) lambda: Vec<f64>,
    /// Weighted gaps as penalty potentials felt them at the end of the step.
    pub(super) felt: Vec<f64>,
    /// Energy that closed constraints of the `velocity` rule keep until they open `[energy]`.
    pub(super) reserve: Vec<f64>,
    /// Active contact nodes.
    pub(super) active: Vec<bool>,
    /// Half of the forces that are not inertial (trapezoidal rule).
    pub(super) half_force: Arc<Vec<f64>>,
    /// Counts steps.
    pub(super) clock: Clock,
    /// What the search for contact takes over from the steps before.
    pub(super) search: Arc<SearchHistory>,
    /// Halvings with which the next nominal step begins.
    pub(super) level: usize,
    /// End of the last step in which a load acted.
    pub(super) loads_ended: f64,
}

/// Times are products of a step size, not sums of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Clock {
    /// Time from which steps are counted `[time]`.
    pub(super) origin: f64,
    /// Steps since then.
    pub(super) count: usize,
    /// Their size `[time]`.
    pub(super) dt: f64,
}

/// A running simulation.
pub struct Simulation {
    steps: Box<dyn Steps>,
}

/// What a simulation of either dimension can do.
pub(super) trait Steps {
    fn dimension(&self) -> usize;
    fn options(&self) -> &Options;
    fn options_mut(&mut self) -> &mut Options;
    fn unknowns(&self) -> usize;
    fn state(&self) -> &Arc<State>;
    fn restore(&mut self, state: &State);
    fn step(&mut self, end: Option<f64>, accepted: &mut dyn FnMut(&LedgerRow)) -> Result<(), StepError>;
    fn settle(&mut self, time: f64) -> Result<SettleReport, StepError>;
    fn watch(&mut self, node: usize);
    fn watched(&self) -> &[usize];
    fn fields(&self) -> Vec<BodyFields>;
    fn contact(&self, name: &str) -> Option<ContactFields>;
    fn closed_nodes(&self) -> Vec<usize>;
    fn failure(&self) -> Option<&FailureReport>;
    fn failed_fields(&self) -> Option<Vec<BodyFields>>;
    fn halvings(&self) -> &[Halving];
    fn measures(&self) -> Measures<'_>;
    fn findings_at_start(&self) -> Vec<RunFinding>;
    fn statistics(&self) -> Statistics;
}

impl Simulation {
    /// Builds the kernels of a model in its initial configuration.
    ///
    /// # Errors
    /// A model that cannot be simulated ([`Model::check`], inverted cells).
    pub fn new(model: &Model, options: Options) -> Result<Self, ModelError> {
        let steps: Box<dyn Steps> = match model.dimension() {
            3 => Box::new(TimeLoop::<3>::new(model, options)?),
            _ => Box::new(TimeLoop::<2>::new(model, options)?),
        };
        Ok(Simulation { steps })
    }

    /// Space dimension.
    pub fn dimension(&self) -> usize {
        self.steps.dimension()
    }

    /// Options it was made with.
    pub fn options(&self) -> &Options {
        self.steps.options()
    }

    /// Changes how the next steps are taken: nominal size `[time]`, Newton's tolerance, halvings at most. States keep none of the three.
    pub fn set_steps(&mut self, dt: f64, tolerance: f64, max_halvings: usize) {
        let options = self.steps.options_mut();
        *options = Options { dt, tolerance, max_halvings, ..options.clone() };
    }

    /// Number of free displacement components.
    pub fn unknowns(&self) -> usize {
        self.steps.unknowns()
    }

    /// Current time `[time]`.
    pub fn time(&self) -> f64 {
        self.row().time
    }

    /// The ledger's row of the current state.
    pub fn row(&self) -> &LedgerRow {
        &self.steps.state().row
    }

    /// Bytes that a state takes.
    pub fn state_size(&self) -> usize {
        let state = self.steps.state();
        let rows = 3 * state.lambda.len();
        8 * (state.positions.len() + state.velocities.len() + state.half_force.len() + rows) + state.active.len()
    }

    /// Takes one nominal step (shorter when `end` comes first, so that `end` is hit exactly), in pieces where it must be halved.
    /// `accepted` is called with the ledger's row of every accepted piece.
    ///
    /// # Errors
    /// The step that failed; the simulation then stands at its last accepted piece, and goes on from there as a restored state does.
    pub fn step(&mut self, end: Option<f64>, accepted: &mut dyn FnMut(&LedgerRow)) -> Result<(), StepError> {
        self.steps.step(end, accepted)
    }

    /// Brings the model to static equilibrium by damped steps, without letting time pass; velocities stay as they are.
    ///
    /// # Errors
    /// No equilibrium was found; the simulation is as it was before.
    pub fn settle(&mut self) -> Result<SettleReport, StepError> {
        self.steps.settle(self.time())
    }

    /// Goes to a time without inertia: equilibrium under what loads, supports and obstacles are then.
    ///
    /// # Errors
    /// No equilibrium was found; the simulation is as it was before.
    pub fn settle_at(&mut self, time: f64) -> Result<SettleReport, StepError> {
        self.steps.settle(time)
    }

    /// Lets every row of the ledger tell the motion of a node (bodies one after the other) from now on.
    pub fn watch(&mut self, node: usize) {
        self.steps.watch(node);
    }

    /// The watched nodes.
    pub fn watched(&self) -> &[usize] {
        self.steps.watched()
    }

    /// The current state as a value.
    pub fn state(&self) -> State {
        State::clone(self.steps.state())
    }

    /// The current state as a value that is shared, not copied.
    pub fn shared_state(&self) -> Arc<State> {
        self.steps.state().clone()
    }

    /// Goes on from a state of this simulation (or of one of the same model).
    ///
    /// # Panics
    /// When the state is of another model (other numbers of nodes or multipliers).
    pub fn restore(&mut self, state: &State) {
        self.steps.restore(state);
    }

    /// Nodal fields of every body.
    pub fn fields(&self) -> Vec<BodyFields> {
        self.steps.fields()
    }

    /// Quantities of the contact pair of that name; `None` when there is none.
    pub fn contact(&self, name: &str) -> Option<ContactFields> {
        self.steps.contact(name)
    }

    /// Number of closed nodes of each contact pair, in the order of the model.
    pub fn closed_nodes(&self) -> Vec<usize> {
        self.steps.closed_nodes()
    }

    /// Why the last step that failed for good did so; `None` when none has failed.
    pub fn failure(&self) -> Option<&FailureReport> {
        self.steps.failure()
    }

    /// Nodal fields of the iterate at which that step was given up (velocities are those of the last accepted state).
    pub fn failed_fields(&self) -> Option<Vec<BodyFields>> {
        self.steps.failed_fields()
    }

    /// Counters and times so far.
    pub fn statistics(&self) -> Statistics {
        self.steps.statistics()
    }

    /// Why steps were halved since the simulation was made, those included that were not even tried.
    pub fn halvings(&self) -> &[Halving] {
        self.steps.halvings()
    }

    /// What is remarkable about a run of this simulation with these rows of its ledger.
    pub fn findings(&self, rows: &[LedgerRow]) -> Vec<RunFinding> {
        run_findings(rows, &self.steps.measures())
    }

    /// What the velocities say of the steps to come: contacts whose sides slide so fast that steps would be halved.
    pub fn findings_at_start(&self) -> Vec<RunFinding> {
        self.steps.findings_at_start()
    }

    /// End of the last step in which a load acted, 0 when none did so far `[time]`.
    pub fn loads_ended(&self) -> f64 {
        self.steps.state().loads_ended
    }
}
