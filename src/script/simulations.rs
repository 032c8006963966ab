//! Simulations in scripts: stepping, results, states as values, and warnings of what a run did or never did.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::Rc;
use std::sync::Arc;
use std::time::{Duration, Instant};

use rhai::{Array, Dynamic, Engine, EvalAltResult, ImmutableString, Map};

use super::arguments::{Arguments, Call, interrupted};
use super::callback::Callback;
use super::diagnostics::Diagnostic;
use super::failure::{Class, Failure, ScriptError, did_you_mean, listed};
use super::host::{Host, Progress};
use super::models::{BodyHandle, ModelData, ModelHandle};
use super::motion::Motion;
use super::numbers::{brief, significant};
use super::registry::{Absent, Form, Function, Handle, Kind, Parameter, Topic, body, number_text};
use super::run::Artifacts;
use super::scan::Target;
use super::sources::Place;
use super::tables::table;
use crate::dynamics::{
    ContactDefinition, ContactFields, ContactMethod, ContactTotals, CyclingNode, FailureCause, LedgerRow, Missing, Model, Options,
    ProbeValues, RunFinding, RunFindingKind, Simulation, State, StepError,
};
use crate::integrators::Integrator;
use crate::math::catalogue::Interval;
use crate::math::tolerances::NEWTON_ENERGY;

/// A time integrator in a script.
#[derive(Clone)]
pub struct IntegratorHandle(pub Integrator);

impl Handle for IntegratorHandle {
    const NAME: &'static str = "Integrator";

    fn describe(&self) -> String {
        format!("{}()", self.0.name())
    }
}

/// A running simulation with what the script layer keeps about it.
pub struct SimulationData {
    /// The model as it was when the simulation was made.
    pub model: ModelData,
    /// Name of the simulation: that of the model, with a number when there are several.
    pub name: String,
    /// Where it was made.
    pub place: Option<Place>,
    /// The kernels.
    pub simulation: RefCell<Simulation>,
    /// One row for each accepted step, after the row of the beginning.
    pub history: RefCell<Vec<LedgerRow>>,
    /// Files of the run.
    pub artifacts: RefCell<Option<Artifacts>>,
    /// For each contact pair of the model: the time at which it was first seen closed.
    pub closed_since: RefCell<Vec<Option<f64>>>,
    /// How the model was moved when the simulation was made; only a check that compares moved runs does that.
    pub motion: Option<Motion>,
    /// Time spent in the kernels.
    pub spent: Cell<Duration>,
    /// Time between two frames of the fields.
    pub fields_every: Option<f64>,
    /// How the failure of the last step that failed is mended.
    pub cure: RefCell<String>,
    /// States before the last steps, to go back to.
    pub past: RefCell<VecDeque<Past>>,
    /// Points that are followed.
    pub probes: RefCell<Vec<Probe>>,
    callbacks: RefCell<Vec<Callback>>,
    /// Number of causes of halvings when they were last looked at.
    causes_seen: Cell<usize>,
    scale: Cell<f64>,
    advancing: Cell<bool>,
}

/// What a simulation has behind it when it is made.
pub struct Course {
    /// Its rows so far, that of the beginning at least.
    pub history: Vec<LedgerRow>,
    /// Points that are followed.
    pub probes: Vec<Probe>,
    /// Time spent in the kernels.
    pub spent: Duration,
}

/// A material point that is followed.
#[derive(Clone)]
pub struct Probe {
    /// Its name.
    pub name: String,
    /// Index of its body.
    pub body: usize,
    /// Its node in the body's mesh.
    pub node: usize,
}

/// A state before a step, with the rows that the history had.
#[derive(Clone)]
pub struct Past {
    /// The state.
    pub state: Arc<State>,
    /// Rows of the history.
    pub rows: usize,
}

/// Bytes of memory that the states before the last steps of a simulation may take, and how many there are at most.
const PAST_BYTES: usize = 64 << 20;
const PAST_STATES: usize = 1000;

/// A simulation in a script.
#[derive(Clone)]
pub struct SimulationHandle(pub Rc<SimulationData>);

impl Handle for SimulationHandle {
    const NAME: &'static str = "Simulation";

    fn describe(&self) -> String {
        let data = &self.0;
        let Ok(simulation) = data.simulation.try_borrow() else {
            return format!("simulation \"{}\" in the middle of a step", data.name);
        };
        let row = simulation.row();
        let (options, number) = (simulation.options(), brief);
        let mut lines = vec![
            format!("simulation \"{}\" at t = {}, step {}", data.name, brief(row.time), row.step),
            format!("  {}, dt = {}, {} unknowns", options.integrator.name(), number_text(options.dt), simulation.unknowns()),
            format!(
                "  energy {}: kinetic {}, strain {}, potential {}",
                number(row.total()),
                number(row.kinetic),
                number(row.strain),
                number(row.potential)
            ),
            format!(
                "  momentum {}, angular momentum {}",
                vector_of(row.momentum, simulation.dimension()),
                angular_text(row, simulation.dimension())
            ),
        ];
        if !data.model.model.contact_names().is_empty() {
            lines.push(format!("  contact: {} active nodes, largest penetration {}", row.active, number(row.max_penetration)));
        }
        lines.extend(data.found(&simulation));
        lines.join("\n")
    }
}

/// A state of a simulation, kept as a value.
#[derive(Clone)]
pub struct StateHandle {
    /// The state.
    pub state: Arc<State>,
    /// The history up to it.
    pub history: Rc<Vec<LedgerRow>>,
    /// Its simulation.
    pub simulation: SimulationHandle,
}

impl Handle for StateHandle {
    const NAME: &'static str = "State";

    fn describe(&self) -> String {
        format!("state of simulation \"{}\" at t = {}", self.simulation.0.name, brief(self.state.row.time))
    }
}

/// A contact pair of a simulation at the time when it was asked for.
#[derive(Clone)]
pub struct ContactHandle {
    name: String,
    time: f64,
    dimension: usize,
    fields: Rc<ContactFields>,
    /// Nodes whose state kept changing in the step that failed.
    cycling: Vec<CyclingNode>,
}

impl Handle for ContactHandle {
    const NAME: &'static str = "ContactState";

    fn describe(&self) -> String {
        let active = self.fields.active.iter().filter(|active| **active).count();
        let largest = self.fields.pressure.iter().fold(0.0_f64, |largest, pressure| largest.max(*pressure));
        let cycling = match self.cycling.len() {
            0 => String::new(),
            count => format!("; {count} cycling in the step that failed"),
        };
        format!(
            "contact \"{}\" at t = {}: {active} of {} nodes active, largest pressure {}, force {}{cycling}",
            self.name,
            brief(self.time),
            self.fields.active.len(),
            brief(largest),
            vector_of(self.fields.force, self.dimension)
        )
    }
}

/// The columns of a simulation's history.
#[derive(Clone)]
pub struct HistoryHandle(pub SimulationHandle);

impl Handle for HistoryHandle {
    const NAME: &'static str = "History";

    fn describe(&self) -> String {
        let columns = self.0.columns();
        format!("history of {} rows with the columns {}", self.0.0.history.borrow().len(), columns.join(", "))
    }
}

/// Names of the history's columns of all contact pairs.
pub fn contact_columns(model: &Model) -> Vec<String> {
    let columns = ContactTotals::columns(model.dimension());
    model.contact_names().iter().flat_map(|name| columns.iter().map(move |column| format!("{name}.{column}"))).collect()
}

fn probe_columns(model: &Model, probes: &[Probe]) -> Vec<String> {
    let columns = ProbeValues::columns(model.dimension());
    probes.iter().flat_map(|probe| columns.iter().map(move |column| format!("{}.{column}", probe.name))).collect()
}

/// Values of a row's columns behind those of the ledger.
pub fn further_values(model: &Model, row: &LedgerRow) -> Vec<f64> {
    let dimension = model.dimension();
    let mut values: Vec<f64> = row.contacts.iter().flat_map(|totals| totals.values(dimension)).collect();
    // Before the first step nothing is known of contact.
    values.resize(model.contact_names().len() * ContactTotals::columns(dimension).len(), f64::NAN);
    values.extend(row.probes.iter().flat_map(|probe| probe.values(dimension)));
    values
}

fn vector_of(vector: [f64; 3], dimension: usize) -> String {
    let numbers: Vec<String> = vector[..dimension].iter().map(|value| brief(*value)).collect();
    format!("[{}]", numbers.join(", "))
}

fn angular_text(row: &LedgerRow, dimension: usize) -> String {
    if dimension == 2 { brief(row.angular_momentum[2]) } else { vector_of(row.angular_momentum, 3) }
}

impl SimulationData {
    /// A time of the kernels on the clock of the script; they differ only in other units ([`Motion`]).
    pub fn script_time(&self, time: f64) -> f64 {
        self.motion.map_or(time, |motion| time / motion.units.time)
    }

    /// A time of the script on the clock of the kernels.
    pub fn kernel_time(&self, time: f64) -> f64 {
        self.motion.map_or(time, |motion| time * motion.units.time)
    }

    /// One line with what is remarkable about the run so far, if anything is.
    fn found(&self, simulation: &Simulation) -> Option<String> {
        let short = |finding: &RunFinding| format!("{finding} ({} against {})", significant(finding.value, 2), number_text(finding.limit));
        let found: Vec<String> = simulation.findings(&self.history.borrow()).iter().map(short).collect();
        (!found.is_empty()).then(|| format!("  found: {}", found.join("; ")))
    }

    fn script_row(&self, row: LedgerRow) -> LedgerRow {
        match self.motion {
            Some(motion) => motion.on_script_clock(row),
            None => row,
        }
    }
}

impl SimulationHandle {
    /// Names of the columns of its history: those of the ledger, of each contact pair, and of each probe.
    pub fn columns(&self) -> Vec<String> {
        let ledger = LedgerRow::columns(self.0.model.model.dimension()).into_iter().map(String::from);
        ledger.chain(contact_columns(&self.0.model.model)).chain(self.probe_columns(0)).collect()
    }

    /// A column of its history; NaN where it had no value yet.
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        let columns = self.columns();
        let index = columns.iter().position(|column| column == name)?;
        let (model, rows) = (&self.0.model.model, self.0.history.borrow());
        let own = LedgerRow::columns(model.dimension()).len();
        if index < own {
            return Some(rows.iter().filter_map(|row| row.column(name)).collect());
        }
        Some(rows.iter().map(|row| further_values(model, row).get(index - own).copied().unwrap_or(f64::NAN)).collect())
    }

    /// Follows a point from now on.
    pub fn add_probe(&self, call: &Call, probe: Probe) -> Result<(), Failure> {
        let data = &self.0;
        let before: usize = data.model.model.bodies[..probe.body].iter().map(|body| body.mesh.points.len()).sum();
        let node = before + probe.node;
        let row = {
            let mut simulation = data.simulation.try_borrow_mut().map_err(|_| busy(call))?;
            simulation.watch(node);
            data.script_row(simulation.row().clone())
        };
        let known = data.probes.borrow().len();
        data.probes.borrow_mut().push(probe);
        if let Some(artifacts) = data.artifacts.borrow_mut().as_mut() {
            artifacts.add_columns(&self.probe_columns(known))?;
        }
        let mut rows = data.history.borrow().clone();
        if let Some(last) = rows.last_mut() {
            *last = row;
        }
        call.host.count_effect();
        self.replace_history(rows)
    }

    /// Names of the columns of its probes from the one of that index on.
    fn probe_columns(&self, from: usize) -> Vec<String> {
        probe_columns(&self.0.model.model, &self.0.probes.borrow()[from..])
    }

    /// The kernels' simulation of a model, as an object of the language with its history so far.
    pub fn create(
        call: &Call,
        model: ModelData,
        simulation: Simulation,
        motion: Option<Motion>,
        fields_every: Option<f64>,
        Course { history, probes, spent }: Course,
    ) -> Result<Self, Failure> {
        let name = unique_name(call.host, &model.model.name);
        let mut artifacts =
            Artifacts::create(call.host, &model.model, &name, fields_every, &history[0], probe_columns(&model.model, &probes))?;
        if let Some(artifacts) = &mut artifacts {
            artifacts.rewrite(&history[..1], &history)?;
        }
        let data = SimulationData {
            place: call.place(&Target::Call),
            artifacts: RefCell::new(artifacts),
            model,
            name,
            closed_since: RefCell::new(vec![None; simulation.closed_nodes().len()]),
            motion,
            spent: Cell::new(spent),
            scale: Cell::new(simulation.row().total().abs()),
            simulation: RefCell::new(simulation),
            history: RefCell::new(history),
            fields_every,
            cure: RefCell::default(),
            past: RefCell::default(),
            probes: RefCell::new(probes),
            callbacks: RefCell::default(),
            causes_seen: Cell::default(),
            advancing: Cell::new(false),
        };
        let handle = SimulationHandle(Rc::new(data));
        if call.host.is_check() {
            call.host.findings.borrow_mut().push(finding(&handle));
            let at_start = handle.0.simulation.borrow().findings_at_start();
            at_start.iter().for_each(|finding| handle.warn_of(call.host, finding));
        }
        if !call.host.is_study() {
            call.host.simulations.borrow_mut().push(handle.clone());
        }
        call.host.count_effect();
        Ok(handle)
    }

    /// Whether both are the same simulation.
    pub fn is(&self, other: &SimulationHandle) -> bool {
        Rc::ptr_eq(&self.0, &other.0)
    }

    /// Step and time reached.
    pub fn position(&self) -> (usize, f64) {
        self.0.simulation.try_borrow().map_or((0, f64::NAN), |simulation| (simulation.row().step, simulation.time()))
    }

    /// Time, ledger and contacts as tables.
    pub fn table(&self) -> String {
        let data = &self.0;
        let Ok(simulation) = data.simulation.try_borrow() else { return self.describe() };
        let (row, options) = (simulation.row(), simulation.options());
        let title = format!("simulation \"{}\" at t = {}, step {}", data.name, brief(row.time), row.step);
        let method = format!("  {}, dt = {}, {} unknowns", options.integrator.name(), number_text(options.dt), simulation.unknowns());
        let history = data.history.borrow();
        let worst = history.iter().map(|row| row.energy_defect.abs()).fold(0.0, f64::max);
        let ledger = [
            ("kinetic", brief(row.kinetic)),
            ("strain", brief(row.strain)),
            ("potential", brief(row.potential)),
            ("total", brief(row.total())),
            ("largest energy defect", brief(worst)),
            ("momentum", vector_of(row.momentum, simulation.dimension())),
            ("angular momentum", angular_text(row, simulation.dimension())),
        ];
        let ledger: Vec<Vec<String>> = ledger.into_iter().map(|(name, value)| vec![name.to_string(), value]).collect();
        let mut parts = vec![title, method, table(&["ledger", ""], &ledger)];
        let contacts: Vec<Vec<String>> = data
            .model
            .model
            .contact_names()
            .into_iter()
            .filter_map(|name| {
                let fields = simulation.contact(name)?;
                let active = fields.active.iter().filter(|active| **active).count();
                let pressure = fields.pressure.iter().fold(0.0_f64, |largest, pressure| largest.max(*pressure));
                let force = vector_of(fields.force, simulation.dimension());
                Some(vec![name.into(), active.to_string(), fields.active.len().to_string(), brief(pressure), force])
            })
            .collect();
        if !contacts.is_empty() {
            parts.push(table(&["contact", "active", "nodes", "largest pressure", "force"], &contacts));
        }
        parts.extend(data.found(&simulation));
        parts.join("\n")
    }

    /// Goes to a state; the history is what it was then.
    pub fn go_to(&self, call: &Call, state: &State, history: Vec<LedgerRow>) -> Result<(), Failure> {
        self.refuse_nested(call)?;
        self.0.simulation.try_borrow_mut().map_err(|_| busy(call))?.restore(state);
        call.host.count_effect();
        let known =
            |past: &Past| past.rows < history.len() && history.get(past.rows - 1) == Some(&self.0.script_row(past.state.row.clone()));
        self.0.past.borrow_mut().retain(known);
        self.replace_history(history)
    }

    /// Keeps the state before a step, and forgets the oldest ones when they take too much memory.
    fn keep_past(&self, state: Arc<State>, rows: usize) {
        let mut past = self.0.past.borrow_mut();
        let size = self.0.simulation.try_borrow().map_or(0, |simulation| simulation.state_size());
        let most = (PAST_BYTES / size.max(1)).clamp(1, PAST_STATES);
        while past.len() >= most {
            past.pop_front();
        }
        past.push_back(Past { state, rows });
    }

    /// Warns of loads that never acted and contact that never closed.
    pub fn warn_of_idle_parts(&self, host: &Host) {
        let stepped = self.0.history.borrow().len() > 1;
        if !stepped {
            return;
        }
        for load in self.0.model.loads.iter().filter(|load| load.amplitude.asked.get() && !load.amplitude.acted.get()) {
            let warning = Diagnostic::warning(format!("the {} never acted", load.title), load.place.clone())
                .cause("its amplitude was zero at every step of the run")
                .hint("check its times and its size against the time that the simulation covers");
            host.warn(warning);
        }
        let closed = self.0.closed_since.borrow();
        let model = &self.0.model.model;
        let is_tie = |name: &str| model.ties.iter().any(|tie| tie.name == name);
        for (name, _) in model.contact_names().into_iter().zip(&*closed).filter(|(name, since)| since.is_none() && !is_tie(name)) {
            let place = self.0.model.place_of_contact(name);
            let warning = Diagnostic::warning(format!("contact \"{name}\" never closed"), place)
                .cause("no node of its secondary side was active in any step")
                .hint("check the positions and velocities of the two bodies, and how far the simulation runs");
            host.warn(warning);
        }
    }

    /// Warns of what is remarkable about the run so far.
    pub fn warn_of_findings(&self, host: &Host) {
        let found = self.0.simulation.try_borrow().map(|simulation| simulation.findings(&self.0.history.borrow()));
        found.iter().flatten().for_each(|finding| self.warn_of(host, finding));
    }

    fn warn_of(&self, host: &Host, finding: &RunFinding) {
        let RunFinding { contact, explanation, step, time, .. } = finding;
        let place = contact.as_ref().map_or(self.0.place.clone(), |name| self.0.model.place_of_contact(name));
        let which = if host.simulations.borrow().len() > 1 { format!("simulation \"{}\", ", self.0.name) } else { String::new() };
        let cause = format!("{explanation} ({which}t = {}, step {step})", brief(*time));
        host.warn(Diagnostic::warning(finding.to_string(), place).cause(cause).hint(finding.cure()));
    }

    /// Whatever is computed before a use of a result in `conserva check`.
    fn results(&self, call: &Call) -> Result<(), Failure> {
        if !call.host.is_check() {
            return Ok(());
        }
        Err(result_used(call.function.name).placed(call.place(&Target::Call)))
    }

    /// What the kernels say, unless a step is running.
    ///
    /// # Errors
    /// A step is running; or this is `conserva check`, which has no results.
    pub fn with<T>(&self, call: &Call, read: impl FnOnce(&Simulation) -> T) -> Result<T, Failure> {
        self.results(call)?;
        match self.0.simulation.try_borrow() {
            Ok(simulation) => Ok(read(&simulation)),
            Err(_) => Err(busy(call)),
        }
    }

    /// Notes which contact pairs are closed now.
    fn note_contact(&self) {
        let Ok(simulation) = self.0.simulation.try_borrow() else { return };
        self.note_closed(self.0.script_time(simulation.time()), simulation.closed_nodes());
    }

    /// Notes which contact pairs are closed at a time, from the number of closed nodes of each.
    fn note_closed(&self, time: f64, nodes: impl IntoIterator<Item = usize>) {
        for (since, nodes) in self.0.closed_since.borrow_mut().iter_mut().zip(nodes) {
            if nodes > 0 && since.is_none() {
                *since = Some(time);
            }
        }
    }

    /// Takes steps until `count` of them are taken or `end` is reached.
    fn advance(&self, call: &Call, end: Option<f64>, count: usize) -> Result<(), Box<EvalAltResult>> {
        if call.host.is_check() {
            return Ok(());
        }
        self.refuse_nested(call)?;
        let from = self.0.simulation.try_borrow().map_err(|_| busy(call))?.time();
        self.begin(call)?;
        self.0.advancing.set(true);
        call.host.begin_steps();
        let reached = || end.is_some_and(|end| self.0.simulation.borrow().time() >= end);
        let mut outcome = Ok(());
        let mut taken = 0;
        while outcome.is_ok() && taken < count && !reached() {
            outcome = self.take_step(call, from, end);
            taken += 1;
        }
        self.0.advancing.set(false);
        call.host.end_steps();
        call.host.observer.ended();
        if end.is_some() {
            // A loop of single steps need not wait for the frames; it is told of what was refused by its next step.
            let written = self.0.artifacts.borrow_mut().as_mut().map_or(Ok(()), Artifacts::wait);
            outcome = outcome.and(written.map_err(Into::into));
        }
        outcome
    }

    /// Steps inside a closure that runs after every step would never end.
    fn refuse_nested(&self, call: &Call) -> Result<(), Failure> {
        if !self.0.advancing.get() {
            return Ok(());
        }
        let failure = call.fail(format!("{} cannot be called while the simulation advances", call.function.title()));
        Err(failure
            .cause("a closure given to `on_step` runs between two steps of a `step` or `run_to` that goes on")
            .hint("look at the state in the closure; take further steps after that call"))
    }

    fn take_step(&self, call: &Call, from: f64, end: Option<f64>) -> Result<(), Box<EvalAltResult>> {
        let data = &self.0;
        let stopped = || {
            let time = data.simulation.borrow().time();
            interrupted(format!("interrupted at t = {}", brief(time))).hint("everything up to this time is kept")
        };
        if call.host.is_stopped() {
            return Err(stopped().into());
        }
        let mut rows = Vec::new();
        let begun = Instant::now();
        let (before, known) = (data.simulation.try_borrow().map_err(|_| busy(call))?.shared_state(), data.history.borrow().len());
        let stepped = data.simulation.try_borrow_mut().map_err(|_| busy(call))?.step(end, &mut |row| rows.push(row.clone()));
        data.spent.set(data.spent.get() + begun.elapsed());
        if matches!(stepped, Err(StepError::Interrupted { .. })) && !rows.is_empty() {
            // Stopped between two pieces of a step that had to be halved: whole steps only, so that it can be gone on with exactly.
            data.simulation.try_borrow_mut().map_err(|_| busy(call))?.restore(&before);
            let time = before.row.time;
            return Err(interrupted(format!("interrupted at t = {}", brief(time))).hint("everything up to this time is kept").into());
        }
        if !rows.is_empty() {
            call.host.count_effect();
            self.keep_past(before, known);
        }
        for row in rows {
            self.accept(call, row, from, end)?;
        }
        self.warn_of_large_motion(call.host);
        stepped.map_err(|error| self.step_failure(call, error))?;
        // Called without a borrow: a closure may look at everything, and hand over further closures.
        let callbacks = data.callbacks.borrow().clone();
        for callback in callbacks {
            let _ = callback.call([Dynamic::from(self.clone())]).map_err(|error| passed_on(&callback, error))?;
        }
        if call.host.is_interrupted() { Err(stopped().into()) } else { Ok(()) }
    }

    /// Warns at once of motion for which steps are halved: a run may take long from then on.
    fn warn_of_large_motion(&self, host: &Host) {
        let Ok(simulation) = self.0.simulation.try_borrow() else { return };
        let causes = simulation.halvings().len();
        if self.0.causes_seen.replace(causes) < causes {
            let found = simulation.findings(&self.0.history.borrow());
            let motions = found.iter().filter(|finding| matches!(finding.kind, RunFindingKind::Motion(_)));
            motions.for_each(|finding| self.warn_of(host, finding));
        }
    }

    /// What comes before the first step: the first frame of the fields.
    fn begin(&self, call: &Call) -> Result<(), Failure> {
        if let Some(artifacts) = self.0.artifacts.borrow_mut().as_mut() {
            let simulation = self.0.simulation.try_borrow().map_err(|_| busy(call))?;
            artifacts.begin(&simulation)?;
        }
        Ok(())
    }

    fn accept(&self, call: &Call, row: LedgerRow, from: f64, until: Option<f64>) -> Result<(), Failure> {
        let data = &self.0;
        let row = data.script_row(row);
        data.scale.set(data.scale.get().max(row.total().abs()));
        call.host.observer.advanced(&Progress { model: &data.name, from, until, row: &row, scale: data.scale.get() });
        if let Some(artifacts) = data.artifacts.borrow_mut().as_mut() {
            let simulation = data.simulation.try_borrow().map_err(|_| busy(call))?;
            artifacts.accepted(&row, &simulation)?;
        }
        // Every piece of a halved step counts: a contact may have opened again when the step is over.
        self.note_closed(row.time, row.contacts.iter().map(|contact| contact.active));
        data.history.borrow_mut().push(row);
        Ok(())
    }

    fn step_failure(&self, call: &Call, error: StepError) -> Failure {
        let (title, cure) = (error.to_string(), error.cure());
        match error {
            StepError::Interrupted { time } => interrupted(format!("interrupted at t = {}", brief(time))).hint(cure),
            StepError::Amplitude { source, .. } => match source.downcast::<ScriptError>() {
                Ok(inner) => call.fail(title).caused_by(*inner),
                Err(other) => call.fail(title).cause(other.to_string()).hint(cure),
            },
            // A failure without a step size comes from `settle`.
            StepError::NotConverged { dt: 0.0, cause, .. } => {
                *self.0.cure.borrow_mut() = cure.clone();
                let failure = Failure::new(Class::Numerics, "no static equilibrium was found").cause(cause).hint(cure);
                // Its gaps jump where a node passes the end of the other surface or settles in one of its corners.
                let by_nodes = |contact: &&ContactDefinition| self.is_lost() && contact.method == ContactMethod::NodeToSegment;
                match self.0.model.model.contacts.iter().find(by_nodes) {
                    Some(contact) => {
                        let name = &contact.name;
                        failure.hint(format!("`node_to_segment()` often has no equilibrium at rest: use `mortar()` for contact \"{name}\""))
                    }
                    None => failure,
                }
            }
            StepError::NotConverged { time, step, dt, halvings, cause, .. } => {
                *self.0.cure.borrow_mut() = cure.clone();
                let number = brief;
                let title = format!(
                    "Newton's method did not converge at t = {} (step {step}, dt = {}, after {halvings} halvings)",
                    number(time),
                    number(dt)
                );
                let failure = Failure::new(Class::Numerics, title).cause(cause).hint(cure);
                if call.host.settings.interactive { failure.hint("`sim.why()` shows the iterations") } else { failure }
            }
        }
    }

    /// Whether the iterations of the last failure went astray, while supports and loads seem to be in order.
    fn is_lost(&self) -> bool {
        use FailureCause::{CyclingContact, Divergence, InvertedCell, NoEquilibrium, SlowConvergence};
        let simulation = self.0.simulation.try_borrow();
        simulation.is_ok_and(|simulation| {
            let cause = simulation.failure().map(|report| &report.cause);
            let cycles = matches!(cause, Some(CyclingContact { .. } | NoEquilibrium { missing: None | Some(Missing::Guidance), .. }));
            cycles || matches!(cause, Some(Divergence | InvertedCell { .. } | SlowConvergence))
        })
    }

    fn settle(&self, call: &Call, time: Option<f64>) -> Result<Dynamic, Box<EvalAltResult>> {
        let data = &self.0;
        if call.host.is_check() {
            return Ok(Dynamic::from(SettleToCome));
        }
        self.refuse_nested(call)?;
        call.host.go_on()?;
        call.host.observer.began(&format!("settling \"{}\"", data.name));
        let begun = Instant::now();
        let mut simulation = data.simulation.try_borrow_mut().map_err(|_| busy(call))?;
        let time = time.unwrap_or_else(|| simulation.time());
        let settled = simulation.settle_at(time);
        drop(simulation);
        data.spent.set(data.spent.get() + begun.elapsed());
        call.host.observer.ended();
        let report = settled.map_err(|error| self.step_failure(call, error))?;
        call.host.count_effect();
        data.past.borrow_mut().clear();
        let row = data.script_row(data.simulation.borrow().row().clone());
        self.note_contact();
        data.scale.set(data.scale.get().max(row.total().abs()));
        let mut rows = data.history.borrow().clone();
        // An equilibrium takes the place of the start, which was none, and of one at the same time; others are rows of their own.
        if rows.len() == 1 && (rows[0].time == 0.0 || rows[0].time == row.time) {
            rows.clear();
        }
        rows.push(row);
        self.replace_history(rows)?;
        let entries: [(&str, Dynamic); 4] = [
            ("steps", (report.steps as i64).into()),
            ("newton_iterations", (report.newton_iterations as i64).into()),
            ("strain", report.strain.into()),
            ("active", (report.active as i64).into()),
        ];
        Ok(entries.into_iter().map(|(name, value)| (name.into(), value)).collect::<Map>().into())
    }

    /// Puts another history in place, in memory and on disk.
    fn replace_history(&self, rows: Vec<LedgerRow>) -> Result<(), Failure> {
        if let Some(artifacts) = self.0.artifacts.borrow_mut().as_mut() {
            artifacts.rewrite(&self.0.history.borrow(), &rows)?;
        }
        *self.0.history.borrow_mut() = rows;
        Ok(())
    }
}

/// What `settle` gives in `conserva check`: nothing is known of it, but most scripts do not ask.
#[derive(Clone)]
struct SettleToCome;

/// Lets a script ask what `settle` found in `conserva check`, which ends there.
pub fn register_settle_to_come(engine: &mut Engine) {
    engine.register_type_with_name::<SettleToCome>("Map");
    engine.register_indexer_get(|_: &mut SettleToCome, name: ImmutableString| -> Result<Dynamic, Box<EvalAltResult>> {
        Err(result_used(&name).into())
    });
}

fn result_used(name: &str) -> Failure {
    Failure::new(Class::ResultUsed, format!("the script uses `{name}` of the simulation"))
}

/// An error of a closure that a step called, with its own place first.
fn passed_on(callback: &Callback, error: Box<EvalAltResult>) -> Box<EvalAltResult> {
    if error.is_catchable() { Failure::script("in a step that this call took").caused_by(callback.wrap(*error)).into() } else { error }
}

/// The failure of a call in the middle of a step.
pub fn busy(call: &Call) -> Failure {
    call.fail("the simulation is in the middle of a step")
        .cause("a time function is asked while the step is computed, so there is no state to look at")
        .hint("compute with the parameter `t` only; `sim.on_step(|sim| …)` runs between steps")
}

/// The functions of this topic.
pub fn functions() -> Vec<Function> {
    let mut all: Vec<Function> = Integrator::ALL.iter().map(|&integrator| integrator_function(integrator)).collect();
    all.push(simulate());
    all.extend(methods());
    all.extend(super::states::functions());
    all.extend(super::forensics::functions());
    all.extend(properties());
    all.extend(contact());
    all
}

fn integrator_function(integrator: Integrator) -> Function {
    Function {
        name: integrator.name(),
        form: Form::Function,
        topic: Topic::Simulation,
        summary: integrator.summary(),
        parameters: Vec::new(),
        returns: IntegratorHandle::NAME,
        example: format!("print({}());", integrator.name()).into(),
        see_also: &["simulate"],
        body: body(move |_| Ok(Dynamic::from(IntegratorHandle(integrator)))),
    }
}

/// A small simulation for examples.
const FLIGHT: &str = "let rubber = neo_hookean(#{ youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 });\n\
     let flight = model(\"flight\");\n\
     let plate = flight.add_body(\"plate\", rectangle(#{ size: [2.0, 1.0], cells: [4, 2] }), rubber);\n\
     flight.initial_velocity(plate, #{ linear: [1.0, 0.0], angular: 2.0 });\n";

/// An example with a simulation in it.
pub fn example(line: &str) -> std::borrow::Cow<'static, str> {
    format!("{FLIGHT}let sim = simulate(flight, #{{ integrator: energy_momentum(), dt: 0.01 }});\n{line}").into()
}

fn simulate() -> Function {
    Function {
        name: "simulate",
        form: Form::Function,
        topic: Topic::Simulation,
        summary: "a simulation of the model as it is now, at time 0",
        parameters: vec![
            Parameter::new("model", Kind::Handle(ModelHandle::NAME), "the model"),
            Parameter::new(
                "options",
                Kind::Options(vec![
                    Parameter::new("integrator", Kind::Handle(IntegratorHandle::NAME), "the time integrator"),
                    Parameter::number("dt", "time", Interval::Positive, "the step size"),
                    Parameter::number(
                        "tolerance",
                        "1",
                        Interval::Open(0.0, 1.0),
                        "Newton's tolerance: the energy that the residual can still move, relative to the energy scale",
                    )
                    .or(Absent::Number(NEWTON_ENERGY)),
                    Parameter::new("max_halvings", Kind::Integer, "how often a step that fails may be halved")
                        .within(Interval::Closed(0.0, 50.0))
                        .or(Absent::Integer(7)),
                    Parameter::number(
                        "fields_every",
                        "time",
                        Interval::Positive,
                        "the time between two frames of the fields in `fields.pvd`",
                    )
                    .or(Absent::Means("the first and the last state only")),
                ]),
                "how it is integrated",
            ),
        ],
        returns: SimulationHandle::NAME,
        example: format!(
            "{FLIGHT}let sim = simulate(flight, #{{ integrator: energy_momentum(), dt: 0.01, fields_every: 0.1 }});\nprint(sim);"
        )
        .into(),
        see_also: &["run_to", "step", "settle"],
        body: body(|call| {
            let (ModelHandle(model), options) = (call.handle("model")?, call.options("options")?);
            let IntegratorHandle(integrator) = options.handle("integrator")?;
            let mut kernel = Options::new(integrator, options.number("dt")?);
            kernel.tolerance = options.number("tolerance")?;
            kernel.max_halvings = options.integer("max_halvings")? as usize;
            kernel.threads = call.host.settings.threads;
            kernel.interrupt = Some(call.host.settings.interrupt.clone());
            kernel.progress = Some(call.host.settings.factorization.clone());
            let fields_every = options.optional_number("fields_every")?;
            call.host.check_overrides(call.engine(), false)?;
            let original = model;
            let model = original.borrow().clone();
            let begun = Instant::now();
            let motion = call.host.motion();
            let moved = motion.map(|motion| motion.model(&model.model)).transpose().map_err(|cause| call.fail(cause))?;
            kernel.dt *= motion.map_or(1.0, |motion| motion.units.time);
            let simulation = Simulation::new(moved.as_ref().unwrap_or(&model.model), kernel);
            let simulation = simulation.map_err(|error| call.fail(error.to_string()).hint(error.cure()))?;
            for (contact, finding) in model.model.findings() {
                let warning = Diagnostic::warning(format!("contact \"{contact}\": {finding}"), model.place_of_contact(&contact));
                call.host.warn(warning.hint(finding.cure()));
            }
            let history = vec![simulation.row().clone()];
            let course = Course { history, probes: Vec::new(), spent: begun.elapsed() };
            let handle = SimulationHandle::create(call, model, simulation, motion, fields_every, course)?;
            handle.note_contact();
            call.host.keep_model(&ModelHandle(original));
            Ok(Dynamic::from(handle))
        }),
    }
}

/// The model's name, with a number when the script made simulations of that name before.
fn unique_name(host: &Host, model: &str) -> String {
    let taken: Vec<String> = host.simulations.borrow().iter().map(|simulation| simulation.0.name.clone()).collect();
    let numbered = (2..).map(|number| format!("{model}-{number}"));
    std::iter::once(model.to_string()).chain(numbered).find(|name| !taken.contains(name)).unwrap_or_default()
}

fn finding(handle: &SimulationHandle) -> String {
    let simulation = handle.0.simulation.borrow();
    let options = simulation.options();
    let model = ModelHandle(Rc::new(RefCell::new(handle.0.model.clone())));
    format!(
        "simulation \"{}\": {}, dt = {}, {} unknowns\n{}",
        handle.0.name,
        options.integrator.name(),
        number_text(options.dt),
        simulation.unknowns(),
        model.describe()
    )
}

fn methods() -> Vec<Function> {
    let receiver = SimulationHandle::receiver();
    vec![
        Function {
            name: "step",
            form: Form::Method(receiver),
            topic: Topic::Simulation,
            summary: "takes one step, or so many",
            parameters: vec![Parameter::new("count", Kind::Integer, "how many steps").within(Interval::NonNegative).or(Absent::Integer(1))],
            returns: "",
            example: example("sim.step();"),
            see_also: &["run_to"],
            body: body(|call| {
                let count = call.integer("count")?;
                call.receiver::<SimulationHandle>().advance(call, None, count as usize)?;
                Ok(Dynamic::UNIT)
            }),
        },
        Function {
            name: "run_to",
            form: Form::Method(receiver),
            topic: Topic::Simulation,
            summary: "takes steps until a time, which is met exactly",
            parameters: vec![Parameter::number("time", "time", Interval::Finite, "the time at which it stops")],
            returns: "",
            example: example("sim.run_to(0.05);"),
            see_also: &["step", "on_step"],
            body: body(|call| {
                let (handle, end) = (call.receiver::<SimulationHandle>(), call.number("time")?);
                let end = handle.0.kernel_time(end);
                let now = handle.0.simulation.try_borrow().map_err(|_| busy(call))?.time();
                if end < now {
                    let failure = call.argument("time").fail(format!("`run_to` goes forward, but {} has passed", number_text(end)));
                    let failure = failure.label(format!("the simulation is at t = {}", brief(now)));
                    return Err(failure.hint("keep a state with `sim.save()` and go back to it with `sim.restore(state)`").into());
                }
                handle.advance(call, Some(end), usize::MAX)?;
                Ok(Dynamic::UNIT)
            }),
        },
        Function {
            name: "settle",
            form: Form::Method(receiver),
            topic: Topic::Simulation,
            summary: "brings the model to static equilibrium, now or as it will be at a later time, without inertia; gives a map with \
                      `steps`, `newton_iterations`, `strain`, `active`",
            parameters: vec![
                Parameter::number(
                    "time",
                    "time",
                    Interval::Finite,
                    "the time of the equilibrium: loads, supports and obstacles are as then",
                )
                .or(Absent::Means("now")),
            ],
            returns: "Map",
            example: example("sim.settle();\nsim.settle(0.1);\nprint(sim.time);"),
            see_also: &["run_to"],
            body: body(|call| {
                let (handle, argument) = (call.receiver::<SimulationHandle>(), call.argument("time"));
                if !argument.is_given() || call.host.is_check() {
                    return handle.settle(call, None);
                }
                let (end, now) = (argument.number()?, handle.with(call, |simulation| simulation.time())?);
                let now = handle.0.script_time(now);
                if end < now {
                    let failure = argument.fail(format!("`settle` goes forward, but {} has passed", number_text(end)));
                    let failure = failure.label(format!("the simulation is at t = {}", brief(now)));
                    return Err(failure.hint("keep a state with `sim.save()` and go back to it with `sim.restore(state)`").into());
                }
                handle.settle(call, Some(handle.0.kernel_time(end)))
            }),
        },
        Function {
            name: "on_step",
            form: Form::Method(receiver),
            topic: Topic::Simulation,
            summary: "calls a closure with the simulation after every step from now on",
            parameters: vec![Parameter::new("action", Kind::Closure("|sim|"), "what is done after a step")],
            returns: "",
            example: example("sim.on_step(|s| if s.time > 0.03 { print(s.energy.total) });\nsim.run_to(0.04);"),
            see_also: &["run_to", "history"],
            body: body(|call| {
                let callback = call.callback("action")?;
                call.host.count_effect();
                call.receiver::<SimulationHandle>().0.callbacks.borrow_mut().push(callback);
                Ok(Dynamic::UNIT)
            }),
        },
        Function {
            name: "save",
            form: Form::Method(receiver),
            topic: Topic::Simulation,
            summary: "the state of the simulation as a value, to go back to",
            parameters: Vec::new(),
            returns: StateHandle::NAME,
            example: example("let start = sim.save();\nsim.step(3);\nsim.restore(start);"),
            see_also: &["restore", "back", "branch"],
            body: body(|call| {
                let handle = call.receiver::<SimulationHandle>();
                let state = match handle.0.simulation.try_borrow() {
                    Ok(simulation) => simulation.shared_state(),
                    Err(_) => return Err(busy(call).into()),
                };
                let history = Rc::new(handle.0.history.borrow().clone());
                Ok(Dynamic::from(StateHandle { state, history, simulation: handle }))
            }),
        },
        Function {
            name: "restore",
            form: Form::Method(receiver),
            topic: Topic::Simulation,
            summary: "goes back to a saved state; the history is what it was then",
            parameters: vec![Parameter::new("state", Kind::Handle(StateHandle::NAME), "a state of this simulation")],
            returns: "",
            example: example("let start = sim.save();\nsim.step(3);\nsim.restore(start);"),
            see_also: &["save", "back"],
            body: body(|call| {
                let (handle, state) = (call.receiver::<SimulationHandle>(), call.handle::<StateHandle>("state")?);
                if !Rc::ptr_eq(&state.simulation.0, &handle.0) {
                    let failure = call.argument("state").fail("the state belongs to another simulation");
                    let failure = failure.label(format!("this is a {}", state.describe()));
                    return Err(failure.hint("restore it where it was saved").into());
                }
                handle.go_to(call, &state.state, (*state.history).clone())?;
                Ok(Dynamic::UNIT)
            }),
        },
    ]
}

fn properties() -> Vec<Function> {
    let receiver = SimulationHandle::receiver();
    let property = |name: &'static str, summary: &'static str, returns: &'static str, read: fn(&Simulation) -> Dynamic| Function {
        name,
        form: Form::Property(receiver),
        topic: Topic::Simulation,
        summary,
        parameters: Vec::new(),
        returns,
        example: example(&format!("print(sim.{name});")),
        see_also: &["history"],
        body: body(move |call| Ok(call.receiver::<SimulationHandle>().with(call, read)?)),
    };
    vec![
        Function {
            name: "time",
            form: Form::Property(receiver),
            topic: Topic::Simulation,
            summary: "the time reached",
            parameters: Vec::new(),
            returns: "number",
            example: example("print(sim.time);"),
            see_also: &["history", "run_to"],
            body: body(|call| {
                let handle = call.receiver::<SimulationHandle>();
                let time = handle.with(call, Simulation::time)?;
                Ok(handle.0.script_time(time).into())
            }),
        },
        property("steps", "the number of accepted steps", "int", |simulation| Dynamic::from(simulation.row().step as i64)),
        property("energy", "a map with `kinetic`, `strain`, `potential`, `total`", "Map", |simulation| {
            let row = simulation.row();
            let entries = [("kinetic", row.kinetic), ("strain", row.strain), ("potential", row.potential), ("total", row.total())];
            entries.into_iter().map(|(name, value)| (name.into(), Dynamic::from(value))).collect::<Map>().into()
        }),
        property("momentum", "the linear momentum, an array", "Array", |simulation| {
            let row = simulation.row();
            row.momentum[..simulation.dimension()].iter().map(|&value| Dynamic::from(value)).collect::<Array>().into()
        }),
        property("angular_momentum", "the angular momentum about the origin: a number, in space an array", "number", |simulation| {
            let row = simulation.row();
            if simulation.dimension() == 2 {
                return row.angular_momentum[2].into();
            }
            row.angular_momentum.iter().map(|&value| Dynamic::from(value)).collect::<Array>().into()
        }),
        property("active", "the number of closed contact nodes", "int", |simulation| Dynamic::from(simulation.row().active as i64)),
        Function {
            name: "unknowns",
            form: Form::Property(receiver),
            topic: Topic::Simulation,
            summary: "the number of free displacement components",
            parameters: Vec::new(),
            returns: "int",
            example: example("print(sim.unknowns);"),
            see_also: &["bodies"],
            body: body(|call| match call.receiver::<SimulationHandle>().0.simulation.try_borrow() {
                Ok(simulation) => Ok(Dynamic::from(simulation.unknowns() as i64)),
                Err(_) => Err(busy(call).into()),
            }),
        },
        Function {
            name: "name",
            form: Form::Property(receiver),
            topic: Topic::Simulation,
            summary: "the name of the simulation: that of its model",
            parameters: Vec::new(),
            returns: "String",
            example: example("print(sim.name);"),
            see_also: &["simulate"],
            body: body(|call| Ok(call.receiver::<SimulationHandle>().0.name.clone().into())),
        },
        Function {
            name: "bodies",
            form: Form::Property(receiver),
            topic: Topic::Simulation,
            summary: "the bodies of the simulation, as they were when it was made",
            parameters: Vec::new(),
            returns: "Array",
            example: example("for body in sim.bodies { print(body.name); }"),
            see_also: &["add_body"],
            body: body(|call| {
                let data = call.receiver::<SimulationHandle>().0.model.clone();
                let count = data.model.bodies.len();
                let model = ModelHandle(Rc::new(RefCell::new(data)));
                Ok((0..count).map(|index| Dynamic::from(BodyHandle { model: model.clone(), index })).collect::<Array>().into())
            }),
        },
        Function {
            name: "history",
            form: Form::Property(receiver),
            topic: Topic::Results,
            summary: "what every accepted step did, as columns: `sim.history.total`",
            parameters: Vec::new(),
            returns: HistoryHandle::NAME,
            example: example("sim.step(3);\nprint(sim.history.total);"),
            see_also: &["plot"],
            body: body(|call| Ok(Dynamic::from(HistoryHandle(call.receiver())))),
        },
        Function {
            name: "columns",
            form: Form::Property(HistoryHandle::receiver()),
            topic: Topic::Results,
            summary: "the names of the columns",
            parameters: Vec::new(),
            returns: "Array",
            example: example("print(sim.history.columns);"),
            see_also: &["history"],
            body: body(|call| {
                let columns = call.receiver::<HistoryHandle>().0.columns();
                Ok(columns.into_iter().map(Dynamic::from).collect::<Array>().into())
            }),
        },
        Function {
            name: "column",
            form: Form::Column(HistoryHandle::receiver()),
            topic: Topic::Results,
            summary: "a column as an array, by its name",
            parameters: vec![Parameter::new("name", Kind::Text, "the name of the column")],
            returns: "Array",
            example: example("sim.step(3);\nprint(sim.history.energy_defect);"),
            see_also: &["history", "columns"],
            body: body(|call| {
                let (HistoryHandle(handle), name) = (call.receiver::<HistoryHandle>(), call.text("name")?);
                handle.results(call)?;
                match handle.column(&name) {
                    // Counts are whole numbers, so that they index arrays and print as such.
                    Some(values) if COUNTS.contains(&name.as_str()) => {
                        Ok(values.into_iter().map(|value| Dynamic::from(value as i64)).collect::<Array>().into())
                    }
                    Some(values) => Ok(values.into_iter().map(Dynamic::from).collect::<Array>().into()),
                    None => Err(unknown_column(call, &handle, &name).into()),
                }
            }),
        },
    ]
}

fn contact() -> Vec<Function> {
    let number = |name: &'static str, summary: &'static str, read: fn(&ContactFields) -> f64| Function {
        name,
        form: Form::Property(ContactHandle::receiver()),
        topic: Topic::Contact,
        summary,
        parameters: Vec::new(),
        returns: "number",
        example: super::contacts::contact_example(&format!("print(sim.contact(\"foot\").{name});")),
        see_also: &["contact", "history"],
        body: body(move |call| Ok(read(&call.receiver::<ContactHandle>().fields).into())),
    };
    let column = |name: &'static str, summary: &'static str, read: fn(&ContactHandle) -> Array| Function {
        name,
        form: Form::Property(ContactHandle::receiver()),
        topic: Topic::Contact,
        summary,
        parameters: Vec::new(),
        returns: "Array",
        example: super::contacts::contact_example(&format!("print(sim.contact(\"foot\").{name});")),
        see_also: &["contact"],
        body: body(move |call| Ok(read(&call.receiver::<ContactHandle>()).into())),
    };
    vec![
        Function {
            name: "contact",
            form: Form::Method(SimulationHandle::receiver()),
            topic: Topic::Contact,
            summary: "a contact pair as it is now",
            parameters: vec![Parameter::new("name", Kind::Text, "the name of the contact pair")],
            returns: ContactHandle::NAME,
            example: super::contacts::contact_example("print(sim.contact(\"foot\"));"),
            see_also: &["add_contact"],
            body: body(|call| {
                let (handle, argument) = (call.receiver::<SimulationHandle>(), call.argument("name"));
                let name = argument.text()?;
                let found = handle.with(call, |simulation| {
                    let cycling = match simulation.failure().map(|report| &report.cause) {
                        Some(FailureCause::CyclingContact { contact, cycling, .. }) if *contact == name => cycling.clone(),
                        _ => Vec::new(),
                    };
                    (simulation.contact(&name), simulation.time(), simulation.dimension(), cycling)
                })?;
                match found {
                    (Some(fields), time, dimension, cycling) => {
                        Ok(Dynamic::from(ContactHandle { name, time, dimension, fields: Rc::new(fields), cycling }))
                    }
                    (None, ..) => {
                        let names = handle.0.model.model.contact_names();
                        Err(argument.unknown_name(format!("there is no contact \"{name}\""), &name, &names).into())
                    }
                }
            }),
        },
        Function {
            name: "cycling",
            form: Form::Property(ContactHandle::receiver()),
            topic: Topic::Contact,
            summary: "the nodes whose contact state kept changing in the last iterations of the step that failed, as maps with `body`, \
                      `node` (its number in the body's mesh) and `index` (its place in `positions`, `gap`, `pressure` and `active`)",
            parameters: Vec::new(),
            returns: "Array",
            example: super::contacts::contact_example(
                "let race = sim.contact(\"foot\");\n\
                 for node in race.cycling { print(`node ${node.node} at ${race.positions[node.index]}`); }",
            ),
            see_also: &["contact", "why"],
            body: body(|call| {
                let map = |node: &CyclingNode| -> Dynamic {
                    let index = node.index.map_or(Dynamic::UNIT, |index| (index as i64).into());
                    let entries: [(&str, Dynamic); 3] =
                        [("body", node.body.clone().into()), ("node", (node.node as i64).into()), ("index", index)];
                    entries.into_iter().map(|(name, value)| (name.into(), value)).collect::<Map>().into()
                };
                Ok(call.receiver::<ContactHandle>().cycling.iter().map(map).collect::<Array>().into())
            }),
        },
        number("normal_force", "the sum of the sizes of the nodal contact forces, for a surface with itself too", |fields| {
            fields.normal_force
        }),
        number("area", "the length of the secondary surface that is in contact, to about half a facet at each end", |fields| fields.area),
        column("pressure", "the contact pressure at each secondary node", |contact| {
            contact.fields.pressure.iter().map(|&value| value.into()).collect()
        }),
        column("gap", "the gap at each secondary node, NaN where nothing lies opposite", |contact| {
            contact.fields.gap.iter().map(|&value| value.into()).collect()
        }),
        column("active", "whether each secondary node is in contact", |contact| {
            contact.fields.active.iter().map(|&value| value.into()).collect()
        }),
        column("forces", "the contact force on each secondary node, an array of vectors", |contact| {
            let vector = |force: &[f64; 3]| Dynamic::from(force[..contact.dimension].iter().map(|&value| value.into()).collect::<Array>());
            contact.fields.forces.iter().map(vector).collect()
        }),
        column(
            "force",
            "the resultant of the contact forces on the secondary side (of a surface with itself: on one side of its folds)",
            |contact| contact.fields.force[..contact.dimension].iter().map(|&value| value.into()).collect(),
        ),
        column("positions", "the current position of each secondary node", |contact| {
            let point =
                |position: &[f64; 3]| Dynamic::from(position[..contact.dimension].iter().map(|&value| value.into()).collect::<Array>());
            contact.fields.positions.iter().map(point).collect()
        }),
    ]
}

/// Columns of the history that hold whole numbers.
const COUNTS: &[&str] = &["step", "newton_iterations", "halvings", "active"];

/// The failure of a column that does not exist.
pub fn unknown_column(call: &Call, handle: &SimulationHandle, name: &str) -> Failure {
    let columns = handle.columns();
    let failure = call.fail(format!("the history has no column `{name}`")).cause(format!("its columns are {}", listed(&columns, "and")));
    failure.hint(did_you_mean(name, columns.iter().map(String::as_str)).unwrap_or_else(|| "use one of these names".into()))
}
