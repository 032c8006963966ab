//! A running simulation, independent of the space dimension.

use std::ops::{Deref, DerefMut};
use std::sync::Arc;

use super::engine::Engine;
use super::ledger::LedgerRow;
use super::options::{Options, SettleReport};
use super::pace::StepControl;
use super::present_state::PresentState;
use super::rows::Rows;
use super::run_findings::{RunFinding, RunFindingKind, run_findings};
use super::solver_findings::taken_over;
use super::state::State;
use super::steps::Steps;
use super::tally::Tally;
use super::validity::{ExcessKind, OutOfValidity, SPURIOUS};
use crate::dynamics::model::bounds::{BodyPastObstacle, ObstacleBounds};
use crate::dynamics::model::definitions::Model;
use crate::dynamics::model::error::ModelError;
use crate::dynamics::model::hulls::{ALLOWED, MutualPenetration};
use crate::dynamics::model::step_error::StepError;
use crate::dynamics::model::unpaired::{Names, UnpairedBodies};
use crate::math::digits::{percent, three_digits};
use crate::math::tolerances::{AT_REST, COARSE, CRUSHED, DEPTH, TURNED};

/// A running simulation.
pub struct Simulation {
    steps: Box<dyn Steps>,
    unpaired: UnpairedBodies,
    bounds: ObstacleBounds,
    passed: Option<BodyPastObstacle>,
}

impl Deref for Simulation {
    type Target = dyn PresentState;

    fn deref(&self) -> &Self::Target {
        &*self.steps
    }
}

impl DerefMut for Simulation {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut *self.steps
    }
}

impl Simulation {
    /// Builds the kernels of a model in its initial configuration.
    ///
    /// # Errors
    /// A model that cannot be simulated ([`Model::check`], inverted cells).
    pub fn new(model: &Model, options: Options) -> Result<Self, ModelError> {
        let steps: Box<dyn Steps> = match model.dimension() {
            3 => Box::new(Engine::<3>::new(model, options)?),
            _ => Box::new(Engine::<2>::new(model, options)?),
        };
        Ok(Simulation { steps, unpaired: UnpairedBodies::of(model), bounds: ObstacleBounds::of(model), passed: None })
    }

    /// Changes the parameters of the next steps: nominal size `[time]`, Newton's tolerance, largest number of halvings. States contain none
    /// of them.
    pub fn set_steps(&mut self, dt: f64, tolerance: f64, max_halvings: usize) {
        let options = self.steps.options_mut();
        *options = Options { dt, tolerance, max_halvings, ..options.clone() };
    }

    /// Sets or removes the step size control; without it steps have the nominal size. States contain the size of the next step.
    pub fn set_control(&mut self, control: Option<StepControl>) {
        self.steps.options_mut().control = control;
    }

    /// Size of the next step without an event before its end `[time]`.
    pub fn next_step(&self) -> f64 {
        let Options { control, dt, .. } = self.options();
        control.as_ref().map_or(*dt, |control| self.steps.state().pace.size(control, *dt))
    }

    /// Current time `[time]`.
    pub fn time(&self) -> f64 {
        self.row().time
    }

    /// The ledger's row of the current state.
    pub fn row(&self) -> &LedgerRow {
        &self.steps.state().row
    }

    /// Takes one nominal step (shorter when `end` comes first, so that it ends exactly at `end`), in substeps if it must be halved.
    /// `accepted` is called with the ledger's row of every accepted substep.
    ///
    /// # Errors
    /// The step that failed; the simulation is then at its last accepted substep, and continues from there like a restored state.
    pub fn step(&mut self, end: Option<f64>, accepted: &mut dyn FnMut(&LedgerRow)) -> Result<(), StepError> {
        let taken = self.steps.step(end, accepted);
        self.watch_obstacles();
        taken
    }

    /// Brings the model to static equilibrium by damped steps at constant time; velocities are unchanged.
    ///
    /// # Errors
    /// No equilibrium was found; the simulation is unchanged.
    pub fn settle(&mut self) -> Result<SettleReport, StepError> {
        self.settled(self.time(), true)
    }

    /// Settles at a time without inertia: equilibrium under the loads, supports and obstacles at that time.
    ///
    /// # Errors
    /// No equilibrium was found; the simulation is unchanged.
    pub fn settle_at(&mut self, time: f64) -> Result<SettleReport, StepError> {
        self.settled(time, true)
    }

    /// Settles at a time without friction: surfaces slide freely.
    ///
    /// # Errors
    /// No equilibrium was found; the simulation is unchanged.
    pub fn settle_without_friction(&mut self, time: f64) -> Result<SettleReport, StepError> {
        self.settled(time, false)
    }

    fn settled(&mut self, time: f64, with_friction: bool) -> Result<SettleReport, StepError> {
        let report = self.steps.settle(time, with_friction);
        self.watch_obstacles();
        report
    }

    /// Stores the deepest penetration of a body into a rigid obstacle so far.
    fn watch_obstacles(&mut self) {
        if self.bounds.is_empty() {
            return;
        }
        let (step, time) = (self.row().step, self.row().time);
        let now = self.bounds.deepest(&self.steps.state().positions, time, step);
        if let Some(now) = now.filter(|now| self.passed.as_ref().is_none_or(|known| now.facets > known.facets)) {
            self.passed = Some(now);
        }
    }

    /// The current state as a value.
    pub fn state(&self) -> State {
        State::clone(self.steps.state())
    }

    /// The current state as a value that is shared, not copied.
    pub fn shared_state(&self) -> Arc<State> {
        self.steps.state().clone()
    }

    /// Counters of the simulation.
    pub fn tally(&self) -> Tally {
        Tally { passed: self.passed.clone(), ..self.steps.tally() }
    }

    /// Continues the counters of a simulation of the same model.
    pub fn count_from(&mut self, tally: &Tally) {
        self.steps.count_from(tally);
        self.passed.clone_from(&tally.passed);
    }

    /// True if a state, possibly from a file, belongs to this model and refers to existing entities.
    pub fn fits(&self, state: &State) -> bool {
        state.has_shape_of(self.steps.state())
    }

    /// Findings on a run of this simulation with the rows `rows` of its ledger.
    pub fn findings<R: Rows + ?Sized>(&self, rows: &R) -> Vec<RunFinding> {
        let mut found = run_findings(rows, &self.steps.measures());
        found.extend(self.passed_through());
        found.extend(self.passed_obstacle());
        found.extend(self.excessive());
        found.extend(self.coarse());
        found.extend(taken_over(self.statistics().taken_over, !self.rank_bytes().is_empty(), self.row()));
        found
    }

    /// Bodies whose laws are used beyond their range.
    fn excessive(&self) -> Vec<RunFinding> {
        let row = self.row();
        let of = |OutOfValidity { body, kind, value, cell, angle }: OutOfValidity| {
            let cell = format!("cell {cell} of body \"{body}\"");
            let (share, angle) = (percent(value), three_digits(angle));
            let (kind, limit, is_beyond, explanation) = match kind {
                ExcessKind::Turned => (RunFindingKind::Turned, TURNED, value > TURNED, format!("{cell} has turned by {value:.2} rad")),
                ExcessKind::SpuriousStrain => {
                    let what =
                        format!("a support turns body \"{body}\" by {angle} rad, which counts as a strain of {share} of the largest one");
                    (RunFindingKind::Turned, SPURIOUS, value > SPURIOUS, what)
                }
                ExcessKind::SpuriousMoment => {
                    let what = format!(
                        "stresses do not turn with body \"{body}\", which has turned by {angle} rad: their moment about it is {share} of \
                         that of the support that turns"
                    );
                    (RunFindingKind::Turned, SPURIOUS, value > SPURIOUS, what)
                }
                ExcessKind::BeyondTable => {
                    let what =
                        format!("{cell} has a plastic strain {value:.2} times that of the last point of its hardening table, {angle}");
                    (RunFindingKind::BeyondTable, 1.0, value > 1.0, what)
                }
                ExcessKind::Crushed => (RunFindingKind::Crushed, CRUSHED, value < CRUSHED, format!("{cell} has a stretch of {value:.2}")),
            };
            is_beyond.then_some(RunFinding { kind, contact: None, value, limit, step: row.step, time: row.time, explanation })
        };
        self.steps.excesses().into_iter().filter_map(of).collect()
    }

    /// Finding on the body with the least accurate stresses at rest. In motion, waves as short as cells dominate the estimated error.
    fn coarse(&self) -> Option<RunFinding> {
        let row = self.row();
        if row.strain <= 0.0 || row.kinetic > AT_REST * row.strain {
            return None;
        }
        let errors = self.steps.stress_errors();
        let &(name, value) = errors.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let explanation = format!(
            "the estimated error of the stresses of body \"{name}\" is {} of their size, and its square, {}, about that of the stiffness",
            percent(value),
            percent(value * value)
        );
        let (kind, step, time) = (RunFindingKind::CoarseCells, row.step, row.time);
        (value > COARSE).then_some(RunFinding { kind, contact: None, value, limit: COARSE, step, time, explanation })
    }

    /// Finding on bodies that penetrate each other without an interaction between them.
    fn passed_through(&self) -> Option<RunFinding> {
        let inside = self.unpaired.inside(&self.steps.state().positions);
        let depth = |(_, inside): &(Names, MutualPenetration)| inside.depth / inside.size;
        let worst = inside.iter().max_by(|a, b| depth(a).total_cmp(&depth(b)))?;
        let ([first, second], MutualPenetration { at, .. }) = worst;
        let (row, facets) = (self.row(), depth(worst));
        let at: Vec<String> = at.iter().map(|x| format!("{x:.3}")).collect();
        let explanation = format!(
            "\"{first}\" and \"{second}\" overlap by {facets:.2} facets at ({}), and no contact is defined between them",
            at.join(", ")
        );
        let (kind, step, time) = (RunFindingKind::PassedThrough, row.step, row.time);
        Some(RunFinding { kind, contact: None, value: facets, limit: ALLOWED, step, time, explanation })
    }

    /// Finding on a body that was inside a rigid obstacle with a part outside its contact definition.
    fn passed_obstacle(&self) -> Option<RunFinding> {
        let BodyPastObstacle { contact, body, facets, at, step, time } = self.passed.as_ref()?;
        let at: Vec<String> = at.iter().map(|x| format!("{x:.3}")).collect();
        let explanation = format!("\"{body}\" was {facets:.2} facets deep in it at ({}), where it has no secondary surface", at.join(", "));
        let (kind, contact) = (RunFindingKind::PassedObstacle, Some(contact.clone()));
        Some(RunFinding { kind, contact, value: *facets, limit: DEPTH, step: *step, time: *time, explanation })
    }

    /// End of the last step in which a load acted, 0 without one `[time]`.
    pub fn loads_ended(&self) -> f64 {
        self.steps.state().loads_ended
    }
}
