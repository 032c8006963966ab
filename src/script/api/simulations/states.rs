//! States as values: save and restore, step back, branch, change options of the next steps.
//!
//! A simulation keeps the states before its last steps as far as memory allows. Continuing from a state gives byte-identical results.

use std::rc::Rc;
use std::sync::Arc;
use std::time::Instant;

use super::handle::{SimulationHandle, busy};
use super::recalling::go_on;
use super::simulate::{InitialHistory, create, kernels};
use super::step_control::{STEP_SIZE, StepSize};
use crate::dynamics::State;
use crate::output::History;
use crate::script::api::examples::flight_example;
use crate::script::language::digits::brief;
use crate::script::language::prelude::*;

/// A state of a simulation, kept as a value.
#[derive(Clone)]
pub struct StateHandle {
    /// Stored state of the simulation.
    pub state: Arc<State>,
    /// History up to the state.
    pub history: History,
    /// Name of its simulation.
    pub name: String,
    /// Simulation of the state; `None` for a state that another process has saved.
    pub simulation: Option<SimulationHandle>,
}

impl StateHandle {
    /// A state of a simulation.
    pub fn of(simulation: SimulationHandle, state: Arc<State>, history: History) -> Self {
        StateHandle { state, history, name: simulation.0.name.clone(), simulation: Some(simulation) }
    }

    /// Refuses the state of another simulation, and a state of another process whose model differs.
    fn refuse_for(&self, call: &Call, handle: &SimulationHandle) -> Result<(), Failure> {
        match &self.simulation {
            Some(own) if Rc::ptr_eq(&own.0, &handle.0) => Ok(()),
            Some(_) => {
                let failure = call.argument("state").refuse(causes::OTHER_OWNER, "the state belongs to another simulation");
                Err(failure.label(format!("this is a {}", self.describe())).hint("restore it where it was saved"))
            }
            None if handle.0.simulation.try_borrow().map_err(|_| busy(call))?.fits(&self.state) => Ok(()),
            None => {
                let failure = call.argument("state").refuse(causes::OTHER_OWNER, "the state does not fit this simulation");
                let failure = failure.cause("a model with other bodies, meshes, contacts or time integrator has saved it");
                Err(failure.hint("restore it in a simulation of an equal model"))
            }
        }
    }
}

impl Handle for StateHandle {
    const NAME: &'static str = "State";
    const MAKER: &'static str = "make one with `sim.save()`";

    fn describe(&self) -> String {
        format!("state of simulation \"{}\" at t = {}", self.name, brief(self.state.row.time))
    }
}

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![save(), restore(), back(), branch(), set(), dt()]
}

fn save() -> Function {
    method_of::<SimulationHandle>(Topic::Simulation, "save")
        .summary("the state of the simulation as a value, to go back to")
        .see_also(&["restore", "back", "branch"])
        .example(flight_example("let start = sim.save();\nsim.step(3);\nsim.restore(start);"))
        .body(|call, handle| {
            handle.looked()?;
            let state = match handle.0.simulation.try_borrow() {
                Ok(simulation) => simulation.shared_state(),
                Err(_) => return Err(busy(call).into()),
            };
            let history = handle.0.history.borrow().clone();
            Ok(StateHandle::of(handle, state, history))
        })
}

fn restore() -> Function {
    method_of::<SimulationHandle>(Topic::Simulation, "restore")
        .summary("goes back to a saved state; the history is what it was then")
        .parameters(vec![Parameter::object::<StateHandle>("state", "a state of this simulation")])
        .see_also(&["save", "back"])
        .example(flight_example("let start = sim.save();\nsim.step(3);\nsim.restore(start);"))
        .body(|call, handle| {
            let state = call.handle::<StateHandle>("state")?;
            state.refuse_for(call, &handle)?;
            handle.go_to(call, &state.state, state.history)?;
            Ok(())
        })
}

fn back() -> Function {
    method_of::<SimulationHandle>(Topic::Simulation, "back")
        .summary("goes back by one step, or by so many; the history is what it was then")
        .parameters(vec![Parameter::integer("count", "how many steps").within(Interval::NonNegative).or(1)])
        .see_also(&["save", "restore", "step"])
        .example(flight_example("sim.step(3);\nsim.back(2);\nprint(sim.steps);"))
        .body(|call, handle| {
            let count = call.integer("count")? as usize;
            if call.host.is_check() || count == 0 {
                return Ok(());
            }
            let kept = handle.0.past.borrow().len();
            if count > kept {
                let failure = call.argument("count").refuse(causes::TIME, format!("the simulation cannot go back by {count} steps"));
                let failure = failure.label(format!("{kept} are kept"));
                let failure = failure.cause("states are kept for the last steps since the simulation was made, settled or restored");
                return Err(failure.hint("keep a state with `sim.save()` and go back to it with `sim.restore(state)`").into());
            }
            let state = handle.past_state(call, kept - count)?;
            let rows = handle.0.past.borrow()[kept - count].rows;
            let history = handle.0.history.borrow().first(rows);
            handle.go_to(call, &state, history)?;
            Ok(())
        })
}

fn branch() -> Function {
    method_of::<SimulationHandle>(Topic::Simulation, "branch")
        .summary("an independent copy of the simulation as it is now, with its history; closures of `on_step` stay with the original")
        .see_also(&["save", "set"])
        .example(flight_example("sim.step(2);\nlet other = sim.branch();\nother.set(#{ dt: 0.005 });\nother.step(2);\nprint(sim.time);"))
        .body(|call, handle| {
            let begun = Instant::now();
            handle.looked()?;
            let (state, options) = match handle.0.simulation.try_borrow() {
                Ok(simulation) => (simulation.state(), simulation.options().clone()),
                Err(_) => return Err(busy(call).into()),
            };
            let model = handle.0.model.clone();
            let motion = handle.0.motion;
            let mut simulation = kernels(call, &model.model, motion, options)?;
            if let Ok(original) = handle.0.simulation.try_borrow() {
                original.watched().iter().for_each(|&node| simulation.watch(node));
            }
            simulation.restore(&state);
            let (history, probes) = (handle.0.history.borrow().clone(), handle.0.probes.borrow().clone());
            let so_far = InitialHistory { history, probes, spent: begun.elapsed() };
            let branch = create(call, model, simulation, motion, handle.0.keeping.clone(), so_far)?;
            if let (Some(own), Some(original)) = (branch.0.artifacts.borrow_mut().as_mut(), handle.0.artifacts.borrow().as_ref()) {
                own.record_behind(original.recording().clone());
            }
            *branch.0.closed_since.borrow_mut() = handle.0.closed_since.borrow().clone();
            Ok(branch)
        })
}

fn set() -> Function {
    method_of::<SimulationHandle>(Topic::Simulation, "set")
        .summary("changes how the next steps are taken; what is left out stays as it is")
        .parameters(vec![Parameter::options("what changes")])
        .keys(vec![
            Parameter::new("dt", STEP_SIZE, "the step size").of("time").within(Interval::Positive).otherwise("as before"),
            Parameter::number("tolerance", "1", Interval::Open(0.0, 1.0), "Newton's tolerance, see `simulate`").otherwise("as before"),
            Parameter::integer("max_halvings", "how often a step that fails may be halved")
                .within(Interval::Closed(0.0, 50.0))
                .otherwise("as before"),
        ])
        .see_also(&["simulate", "branch"])
        .example(flight_example("sim.step(2);\nsim.set(#{ dt: 0.002 });\nsim.step();\nprint(sim.time);"))
        .body_with_options(|call, handle, options| {
            let (dt, tolerance, halvings) =
                (options.argument("dt"), options.optional_number("tolerance")?, options.argument("max_halvings"));
            let size = if dt.is_given() { Some(StepSize::of(&dt)?) } else { None };
            let halvings = if halvings.is_given() { Some(halvings.integer()? as usize) } else { None };
            let mut simulation = handle.0.simulation.try_borrow_mut().map_err(|_| busy(call))?;
            let mut now = simulation.options().clone();
            if let Some(size) = size {
                size.on_clock(handle.0.kernel_time(1.0)).put_into(&mut now, simulation.next_step());
                simulation.set_control(now.control);
            }
            simulation.set_steps(now.dt, tolerance.unwrap_or(now.tolerance), halvings.unwrap_or(now.max_halvings));
            call.host.count_effect();
            Ok(())
        })
}

fn dt() -> Function {
    property_of::<SimulationHandle>(Topic::Simulation, "dt")
        .summary("the size of the next step, should nothing come first")
        .see_also(&["set"])
        .example(flight_example("print(sim.dt);"))
        .body(|call, handle| match handle.0.simulation.try_borrow() {
            Ok(simulation) => Ok(handle.0.script_time(simulation.next_step())),
            Err(_) => Err(busy(call).into()),
        })
}

impl SimulationHandle {
    /// Restores a state, with its history.
    pub fn go_to(&self, call: &Call, state: &State, history: History) -> Result<(), Failure> {
        self.refuse_nested(call)?;
        self.record_return(call.host)?;
        self.0.simulation.try_borrow_mut().map_err(|_| busy(call))?.restore(state);
        self.0.is_behind.set(false);
        self.0.is_known.set(true);
        call.host.count_effect();
        let common = self.0.history.borrow().common(&history);
        self.0.past.borrow_mut().retain(|past| past.rows < history.len() && past.rows <= common);
        self.replace_history(history)?;
        // After the last computation of an earlier process.
        go_on(call.host)
    }
}
