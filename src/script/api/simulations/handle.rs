//! Simulations as objects of the language: the simulation of the solver and the data of the script layer.
//!
//! The solver's simulation is borrowed during a step; access within a step (by a closure of time) is refused by [`busy`].

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, VecDeque};
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use super::artifacts::{Artifacts, RecordingLimits};
use super::columns::{Probe, history_columns};
use super::integrators::title;
use super::journal::Journal;
use super::known_columns::KnownColumns;
use super::step_control::step_size;
use crate::dynamics::{EnergyAccount, LedgerRow, Overlap, RunFinding, Simulation, State};
use crate::output::{History, ListedUnits, ModelUnits, pretty_unit};
use crate::script::api::models::data::ModelData;
use crate::script::api::models::handle::BodyHandle;
use crate::script::api::motion::Motion;
use crate::script::api::remedies::explained;
use crate::script::language::callback::Callback;
use crate::script::language::digits::{brief, brief_vector};
use crate::script::language::failure::Class;
use crate::script::language::prelude::*;
use crate::script::language::sources::SourceSpan;

/// A running simulation with the data of the script layer.
pub struct SimulationData {
    /// Model at the creation of the simulation.
    pub model: ModelData,
    /// Name of the simulation: that of the model, numbered if there are several.
    pub name: String,
    /// Position of the `simulate` call in the script.
    pub place: Option<SourceSpan>,
    /// Overlaps at the start, until `settle` has removed them or the script has accepted them.
    pub overlaps: RefCell<Vec<Overlap>>,
    /// True if the script has accepted the overlaps at the start.
    pub accepts_overlap: Cell<bool>,
    /// The simulation of the solver.
    pub simulation: RefCell<Simulation>,
    /// Rows of the start and of each accepted step.
    pub history: RefCell<History>,
    /// Columns of the history that the script has read.
    pub columns: RefCell<KnownColumns>,
    /// Files of the run.
    pub artifacts: RefCell<Option<Artifacts>>,
    /// Time at which each contact pair of the model was first active.
    pub closed_since: RefCell<Vec<Option<f64>>>,
    /// Motion applied to the model when the simulation was made; only used by checks that compare moved runs.
    pub motion: Option<Motion>,
    /// Computing time of the solver.
    pub spent: Cell<Duration>,
    /// Limits for the recorded frames and stills (animation frames) of the run.
    pub keeping: RecordingLimits,
    /// Hint for the last step that failed.
    pub hint: RefCell<String>,
    /// States before the last steps, for going back by steps; empty if the session never goes back.
    pub past: RefCell<VecDeque<PastState>>,
    /// Probes, with the points that they follow.
    pub probes: RefCell<Vec<Probe>>,
    /// Closures that run after every step.
    pub callbacks: RefCell<Vec<Callback>>,
    /// Number of causes of halvings at the last check.
    pub causes_seen: Cell<usize>,
    /// Largest energy so far, the scale of energy defects.
    pub scale: Cell<f64>,
    /// Number of `settle` calls since the last change of model, time or state.
    pub standing: Cell<u32>,
    /// True while steps are taken.
    pub advancing: Cell<bool>,
    /// True if an earlier process has computed the last step, so that the solver has its history row but not its state.
    pub is_behind: Cell<bool>,
    /// Journal of the run and index of the simulation in it; `None` for simulations of checks and studies.
    pub journal: Option<(Rc<Journal>, usize)>,
    /// True if the present state is available to a resumed run.
    pub is_known: Cell<bool>,
    /// Units of the results; `None` where the script declares none.
    pub units: Option<ModelUnits>,
    /// Findings and energy account as of their last evaluation.
    pub found: RefCell<Option<Rc<Found>>>,
}

/// Evaluation of the rows of a run.
pub struct Found {
    /// Findings on the run.
    pub findings: Vec<RunFinding>,
    /// Energy changes by cause.
    pub account: EnergyAccount,
    /// Number of rows, last row and number of factorizations at the evaluation, on which findings depend.
    of: (usize, LedgerRow, usize),
}

impl SimulationData {
    /// Evaluation of the rows so far. They are read back from the disk only if the run has changed since the last call.
    pub fn found(&self, simulation: &Simulation, history: &History) -> Rc<Found> {
        let of = (history.len(), simulation.row().clone(), simulation.statistics().factorizations);
        let mut found = self.found.borrow_mut();
        if let Some(known) = found.as_ref().filter(|known| known.of == of) {
            return known.clone();
        }
        let findings = simulation.findings(history);
        found.insert(Rc::new(Found { findings, account: EnergyAccount::of(history), of })).clone()
    }
}

/// State before a step, with the number of history rows.
#[derive(Clone)]
pub struct PastState {
    /// State; `None` if an earlier process has computed it.
    pub state: Option<Arc<State>>,
    /// Rows of the history.
    pub rows: usize,
    /// True if this state is available to a resumed run.
    pub is_known: bool,
    /// Size in bytes, without the data that is shared with the state before.
    pub size: usize,
}

/// Simulations of a script in the order of their creation, except those of checks and studies.
#[derive(Default)]
pub struct Simulations(pub RefCell<Vec<SimulationHandle>>);

impl Simulations {
    /// The simulations of a session.
    pub fn of(host: &Host) -> Rc<Simulations> {
        host.slots.get()
    }
}

/// A simulation in a script.
#[derive(Clone)]
pub struct SimulationHandle(pub Rc<SimulationData>);

impl Handle for SimulationHandle {
    const NAME: &'static str = "Simulation";
    const MAKER: &'static str = "make one with `simulate(model, #{ integrator, dt })`";

    fn describe(&self) -> String {
        // Errors are reported at the next access by the caller.
        let _ = self.looked();
        let data = &self.0;
        let Ok(simulation) = data.simulation.try_borrow() else {
            return format!("simulation \"{}\" in the middle of a step", data.name);
        };
        let row = simulation.row();
        let options = simulation.options();
        let told = |number: f64, dimension| data.told(brief(number), dimension);
        let energies = [row.total(), row.kinetic, row.strain, row.potential].map(|energy| told(energy, "energy"));
        let mut lines = vec![
            format!("simulation \"{}\" at t = {}, step {}", data.name, told(row.time, "time"), row.step),
            format!(
                "  {}, dt = {}, {} unknowns",
                title(&options.integrator),
                step_size(options, |dt| data.told(dt, "time")),
                simulation.unknowns()
            ),
            format!("  energy {}: kinetic {}, strain {}, potential {}", energies[0], energies[1], energies[2], energies[3]),
            format!(
                "  momentum {}, angular momentum {}",
                data.told(brief_vector(&row.momentum[..simulation.dimension()]), "mass * velocity"),
                data.told(angular_text(row, simulation.dimension()), "mass * area/time")
            ),
        ];
        if !data.model.model.contact_names().is_empty() {
            let rubs = data.model.model.interactions.iter().any(|interaction| interaction.friction.is_some());
            let sliding: usize = row.contacts.iter().map(|contact| contact.sliding).sum();
            let sliding = if rubs { format!(" ({sliding} slide)") } else { String::new() };
            lines.push(format!(
                "  contact: {} active nodes{sliding}, largest penetration {}",
                row.active,
                told(row.max_penetration, "length")
            ));
        }
        lines.extend(data.remarks(&simulation));
        lines.join("\n")
    }
}

/// Text of the angular momentum of a row: a number in the plane, a vector in space.
pub fn angular_text(row: &LedgerRow, dimension: usize) -> String {
    if dimension == 2 { brief(row.angular_momentum[2]) } else { brief_vector(&row.angular_momentum[..3]) }
}

impl SimulationData {
    /// Converts a time from the units of the solver to those of the script ([`Motion`]).
    pub fn script_time(&self, time: f64) -> f64 {
        self.motion.map_or(time, |motion| time / motion.units.time)
    }

    /// Unit of a dimension; empty for pure numbers and if the script declares no units.
    pub fn unit(&self, dimension: &str) -> String {
        self.units.as_ref().map_or(String::new(), |units| pretty_unit(&units.unit(dimension)))
    }

    /// Unit of a dimension in brackets with a space before, for labels; empty for pure numbers and if the script declares no units.
    pub fn bracketed(&self, dimension: &str) -> String {
        self.units.as_ref().map_or(String::new(), |units| units.bracketed(dimension))
    }

    /// A number as text, with the unit of its dimension if the script declares units.
    pub fn told(&self, number: String, dimension: &str) -> String {
        match self.units.as_ref().map(|units| units.unit(dimension)).filter(|unit| !unit.is_empty()) {
            Some(unit) => format!("{number} {}", pretty_unit(&unit)),
            None => number,
        }
    }

    /// Units of columns and fields; `None` where the script declares no units.
    pub fn listed_units(&self) -> Option<ListedUnits> {
        let units = self.units.as_ref()?;
        let mut listed = ListedUnits::of(units);
        let columns = history_columns(&self.model.model, &self.probes.borrow());
        listed.add_columns(columns.iter().map(|(name, dimension)| (name.as_str(), *dimension)), units);
        Some(listed)
    }

    /// Units of the columns of the history, by name.
    pub fn column_units(&self) -> BTreeMap<String, String> {
        self.listed_units().map_or(BTreeMap::new(), |listed| listed.columns)
    }

    /// Converts a time from the units of the script to those of the solver.
    pub fn kernel_time(&self, time: f64) -> f64 {
        self.motion.map_or(time, |motion| time * motion.units.time)
    }

    /// Describes the energy changes so far, and the findings of the run, one line each.
    pub fn remarks(&self, simulation: &Simulation) -> Vec<String> {
        let history = self.history.borrow();
        let found = self.found(simulation, &history);
        let account = found.account.to_string();
        let energy = (!account.is_empty()).then(|| format!("  energy since the start{}: {account}", self.bracketed("energy")));
        energy.into_iter().chain(found.findings.iter().map(|finding| format!("  found: {finding}: {}", explained(finding)))).collect()
    }

    /// Row of the solver with its times converted to the units of the script.
    pub fn script_row(&self, row: LedgerRow) -> LedgerRow {
        match self.motion {
            Some(motion) => motion.on_script_clock(row),
            None => row,
        }
    }
}

impl SimulationHandle {
    /// True if both handles refer to one simulation.
    pub fn is(&self, other: &SimulationHandle) -> bool {
        Rc::ptr_eq(&self.0, &other.0)
    }

    /// Step and time reached.
    pub fn position(&self) -> (usize, f64) {
        self.0.simulation.try_borrow().map_or((0, f64::NAN), |simulation| (simulation.row().step, simulation.time()))
    }

    /// Index of the body in the argument `body`.
    ///
    /// # Errors
    /// The simulation has no body of that name.
    pub fn body_index(&self, call: &Call) -> Result<usize, Failure> {
        let body = call.handle::<BodyHandle>("body")?.definition().name;
        let names: Vec<&str> = self.0.model.model.bodies.iter().map(|body| body.name.as_str()).collect();
        let unknown = || call.argument("body").unknown_name(format!("the simulation has no body \"{body}\""), &body, &names);
        names.iter().position(|known| *known == body).ok_or_else(unknown)
    }

    /// Refuses a use of results in `conserva check`, which has none.
    ///
    /// # Errors
    /// This is `conserva check`.
    pub fn refuse_in_check(&self, call: &Call) -> Result<(), Failure> {
        if !call.host.is_check() {
            return Ok(());
        }
        Err(result_used(call.function.name).placed(call.place(&Target::Call)))
    }

    /// Runs an analysis of the present state (`what` describes it for the user), which may be interrupted.
    ///
    /// # Errors
    /// A step is running, or the user has interrupted the search.
    pub fn found<T>(&self, call: &Call, what: &str, search: impl FnOnce(&mut Simulation) -> T) -> Result<T, Failure> {
        call.host.go_on()?;
        call.host.observer.began(&format!("{what} of \"{}\"", self.0.name));
        let found = self.0.simulation.try_borrow_mut().map_err(|_| busy(call)).map(|mut simulation| search(&mut simulation));
        call.host.observer.ended();
        // An interrupt inside a time function may have been mistaken for a missing value.
        call.host.go_on()?;
        found
    }

    /// Reads from the solver's simulation.
    ///
    /// # Errors
    /// A step is running; or this is `conserva check`, which has no results.
    pub fn with<T>(&self, call: &Call, read: impl FnOnce(&Simulation) -> T) -> Result<T, Failure> {
        self.refuse_in_check(call)?;
        self.looked()?;
        self.with_row(call, read)
    }

    /// Reads from the solver's simulation data that depend only on the row of the last step, which a resumed run always has.
    ///
    /// # Errors
    /// A step is running; or this is `conserva check`, which has no results.
    pub fn with_row<T>(&self, call: &Call, read: impl FnOnce(&Simulation) -> T) -> Result<T, Failure> {
        self.refuse_in_check(call)?;
        match self.0.simulation.try_borrow() {
            Ok(simulation) => Ok(read(&simulation)),
            Err(_) => Err(busy(call)),
        }
    }

    /// Records the contact pairs that are closed in the present state.
    pub fn note_contact(&self) {
        let Ok(simulation) = self.0.simulation.try_borrow() else { return };
        self.note_closed(self.0.script_time(simulation.time()), simulation.closed_nodes());
    }

    /// Records the contact pairs that are closed at a time, given the number of closed nodes of each pair.
    pub fn note_closed(&self, time: f64, nodes: impl IntoIterator<Item = usize>) {
        for (since, nodes) in self.0.closed_since.borrow_mut().iter_mut().zip(nodes) {
            if nodes > 0 && since.is_none() {
                *since = Some(time);
            }
        }
    }

    /// Refuses steps inside a closure that runs after every step: the recursion would never end.
    ///
    /// # Errors
    /// The simulation is taking steps.
    pub fn refuse_nested(&self, call: &Call) -> Result<(), Failure> {
        if !self.0.advancing.get() {
            return Ok(());
        }
        let failure = call.refuse(causes::TIME, format!("{} cannot be called while the simulation advances", call.function.title()));
        Err(failure
            .cause("a closure given to `on_step` runs between two steps of a `step` or `run_to` that goes on")
            .hint("look at the state in the closure; take further steps after that call"))
    }

    /// Replaces the history, in memory and on disk.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn replace_history(&self, rows: History) -> Result<(), Failure> {
        if let (Some(artifacts), Ok(simulation)) = (self.0.artifacts.borrow_mut().as_mut(), self.0.simulation.try_borrow()) {
            artifacts.rewrite(&self.0.history.borrow(), &rows, &simulation)?;
        }
        self.0.columns.borrow_mut().forget();
        *self.0.history.borrow_mut() = rows;
        Ok(())
    }
}

/// The failure of `conserva check` at the first use of a result.
pub fn result_used(name: &str) -> Failure {
    Failure::new(Class::ResultUsed, format!("the script uses `{name}` of the simulation"))
}

/// The failure of a call in the middle of a step.
pub fn busy(call: &Call) -> Failure {
    call.refuse(causes::TIME, "the simulation is in the middle of a step")
        .cause("a time function is evaluated while the step is computed, so there is no state to look at")
        .hint("compute with the parameter `t` only; `sim.on_step(|sim| …)` runs between steps")
}
