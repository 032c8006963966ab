//! A simulation as an object of the language: the kernels with what the script layer keeps beside them.
//!
//! The kernels are borrowed for as long as a step lasts, so whoever asks in the middle of one (a closure of time) is refused by [`busy`].

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use super::artifacts::{Artifacts, Keeping};
use super::columns::Probe;
use super::integrators::title;
use super::journal::Journal;
use super::known_columns::KnownColumns;
use super::step_control::step_size;
use crate::dynamics::{EnergyAccount, LedgerRow, Overlap, Simulation, State};
use crate::output::History;
use crate::script::api::models::data::ModelData;
use crate::script::api::models::handle::BodyHandle;
use crate::script::api::motion::Motion;
use crate::script::api::remedies::explained;
use crate::script::language::arguments::Arguments;
use crate::script::language::callback::Callback;
use crate::script::language::digits::{brief, brief_vector};
use crate::script::language::failure::{Class, Failure};
use crate::script::language::function::Call;
use crate::script::language::handle::Handle;
use crate::script::language::host::Host;
use crate::script::language::scan::Target;
use crate::script::language::sources::Place;

/// A running simulation with what the script layer keeps about it.
pub struct SimulationData {
    /// The model as it was when the simulation was made.
    pub model: ModelData,
    /// Name of the simulation: that of the model, with a number when there are several.
    pub name: String,
    /// Where it was made.
    pub place: Option<Place>,
    /// What overlaps at the start, until `settle` has pressed it apart or the script has accepted it.
    pub overlaps: RefCell<Vec<Overlap>>,
    /// Whether the script has accepted it.
    pub accepts_overlap: Cell<bool>,
    /// The kernels.
    pub simulation: RefCell<Simulation>,
    /// One row for each accepted step, after the row of the beginning.
    pub history: RefCell<History>,
    /// Columns of the history that the script has read.
    pub columns: RefCell<KnownColumns>,
    /// Files of the run.
    pub artifacts: RefCell<Option<Artifacts>>,
    /// For each contact pair of the model: the time at which it was first seen closed.
    pub closed_since: RefCell<Vec<Option<f64>>>,
    /// How the model was moved when the simulation was made; only a check that compares moved runs does that.
    pub motion: Option<Motion>,
    /// Time spent in the kernels.
    pub spent: Cell<Duration>,
    /// What is kept of its run.
    pub keeping: Keeping,
    /// How the failure of the last step that failed is mended.
    pub hint: RefCell<String>,
    /// States before the last steps, to go back to.
    pub past: RefCell<VecDeque<Past>>,
    /// Points that are followed.
    pub probes: RefCell<Vec<Probe>>,
    /// Closures that run after every step.
    pub callbacks: RefCell<Vec<Callback>>,
    /// Number of causes of halvings when they were last looked at.
    pub causes_seen: Cell<usize>,
    /// Largest energy so far that defects are related to.
    pub scale: Cell<f64>,
    /// How often equilibrium was asked for since anything has changed.
    pub standing: Cell<u32>,
    /// Whether it takes steps now.
    pub advancing: Cell<bool>,
    /// Whether the kernels know the row of the last step alone, because an earlier program has computed it.
    pub is_behind: Cell<bool>,
    /// The journal of the run and the number of the simulation in it; none for those of a check for itself.
    pub journal: Option<(Rc<Journal>, usize)>,
    /// Whether a run that is resumed knows the state as it is now.
    pub is_known: Cell<bool>,
}

/// A state before a step, with the rows that the history had.
#[derive(Clone)]
pub struct Past {
    /// The state; none where an earlier program has computed it.
    pub state: Option<Arc<State>>,
    /// Rows of the history.
    pub rows: usize,
    /// Whether a run that is resumed knows the state.
    pub is_known: bool,
}

/// The simulations of a script, in the order in which it made them; those of a check for itself are not among them.
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
        // What cannot be looked at is told by whoever asks for more.
        let _ = self.looked();
        let data = &self.0;
        let Ok(simulation) = data.simulation.try_borrow() else {
            return format!("simulation \"{}\" in the middle of a step", data.name);
        };
        let row = simulation.row();
        let (options, number) = (simulation.options(), brief);
        let mut lines = vec![
            format!("simulation \"{}\" at t = {}, step {}", data.name, brief(row.time), row.step),
            format!("  {}, dt = {}, {} unknowns", title(&options.integrator), step_size(options), simulation.unknowns()),
            format!(
                "  energy {}: kinetic {}, strain {}, potential {}",
                number(row.total()),
                number(row.kinetic),
                number(row.strain),
                number(row.potential)
            ),
            format!(
                "  momentum {}, angular momentum {}",
                brief_vector(&row.momentum[..simulation.dimension()]),
                angular_text(row, simulation.dimension())
            ),
        ];
        if !data.model.model.contact_names().is_empty() {
            let rubs = data.model.model.interactions.iter().any(|interaction| interaction.friction.is_some());
            let sliding: usize = row.contacts.iter().map(|contact| contact.sliding).sum();
            let sliding = if rubs { format!(" ({sliding} slide)") } else { String::new() };
            lines.push(format!("  contact: {} active nodes{sliding}, largest penetration {}", row.active, number(row.max_penetration)));
        }
        lines.extend(data.remarks(&simulation));
        lines.join("\n")
    }
}

/// The angular momentum of a row: a number in the plane, in space a vector.
pub fn angular_text(row: &LedgerRow, dimension: usize) -> String {
    if dimension == 2 { brief(row.angular_momentum[2]) } else { brief_vector(&row.angular_momentum[..3]) }
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

    /// Where energy came from and went to so far, and what else is remarkable about the run, a line each.
    pub fn remarks(&self, simulation: &Simulation) -> Vec<String> {
        let history = self.history.borrow();
        let account = EnergyAccount::of(&*history).to_string();
        let energy = (!account.is_empty()).then(|| format!("  energy since the start: {account}"));
        let found = simulation.findings(&*history);
        energy.into_iter().chain(found.iter().map(|finding| format!("  found: {finding}: {}", explained(finding)))).collect()
    }

    /// A row of the kernels with the times of the script.
    pub fn script_row(&self, row: LedgerRow) -> LedgerRow {
        match self.motion {
            Some(motion) => motion.on_script_clock(row),
            None => row,
        }
    }
}

impl SimulationHandle {
    /// Whether both are the same simulation.
    pub fn is(&self, other: &SimulationHandle) -> bool {
        Rc::ptr_eq(&self.0, &other.0)
    }

    /// Step and time reached.
    pub fn position(&self) -> (usize, f64) {
        self.0.simulation.try_borrow().map_or((0, f64::NAN), |simulation| (simulation.row().step, simulation.time()))
    }

    /// Index of the body that the argument `body` means.
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

    /// What is found about the present state, which the user sees going on as `what` of the simulation, unless a step is running.
    ///
    /// # Errors
    /// A step is running, or the user has interrupted.
    pub fn found<T>(&self, call: &Call, what: &str, search: impl FnOnce(&mut Simulation) -> T) -> Result<T, Failure> {
        call.host.go_on()?;
        call.host.observer.began(&format!("{what} of \"{}\"", self.0.name));
        let found = self.0.simulation.try_borrow_mut().map_err(|_| busy(call)).map(|mut simulation| search(&mut simulation));
        call.host.observer.ended();
        // A closure of time that an interrupt ended may have been taken for one without a value.
        call.host.go_on()?;
        found
    }

    /// What the kernels say, unless a step is running.
    ///
    /// # Errors
    /// A step is running; or this is `conserva check`, which has no results.
    pub fn with<T>(&self, call: &Call, read: impl FnOnce(&Simulation) -> T) -> Result<T, Failure> {
        self.refuse_in_check(call)?;
        self.looked()?;
        self.with_row(call, read)
    }

    /// The same for what is read from the row of the last step alone, which a run that is resumed always knows.
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

    /// Notes which contact pairs are closed now.
    pub fn note_contact(&self) {
        let Ok(simulation) = self.0.simulation.try_borrow() else { return };
        self.note_closed(self.0.script_time(simulation.time()), simulation.closed_nodes());
    }

    /// Notes which contact pairs are closed at a time, from the number of closed nodes of each.
    pub fn note_closed(&self, time: f64, nodes: impl IntoIterator<Item = usize>) {
        for (since, nodes) in self.0.closed_since.borrow_mut().iter_mut().zip(nodes) {
            if nodes > 0 && since.is_none() {
                *since = Some(time);
            }
        }
    }

    /// Refuses steps inside a closure that runs after every step: they would never end.
    ///
    /// # Errors
    /// The simulation takes steps now.
    pub fn refuse_nested(&self, call: &Call) -> Result<(), Failure> {
        if !self.0.advancing.get() {
            return Ok(());
        }
        let failure = call.fail(format!("{} cannot be called while the simulation advances", call.function.title()));
        Err(failure
            .cause("a closure given to `on_step` runs between two steps of a `step` or `run_to` that goes on")
            .hint("look at the state in the closure; take further steps after that call"))
    }

    /// Puts another history in place, in memory and on disk.
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
    call.fail("the simulation is in the middle of a step")
        .cause("a time function is asked while the step is computed, so there is no state to look at")
        .hint("compute with the parameter `t` only; `sim.on_step(|sim| …)` runs between steps")
}
