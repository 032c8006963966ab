//! Updates for readers who follow a run, besides rows and stills of the simulations.

use super::columns::{history_columns, names};
use super::handle::SimulationHandle;
use super::reports::{findings, parameters, placed, scripts, tables};
use crate::output::{LiveModel, LiveOutcome, LiveProblem, LiveSimulation, marks};
use crate::script::language::host::Host;

/// Adds a new simulation to the live report, if there is one.
pub fn begin(host: &Host, handle: &SimulationHandle) {
    let data = &handle.0;
    let (Some(live), mut artifacts) = (&host.settings.live, data.artifacts.borrow_mut()) else { return };
    let Some(artifacts) = artifacts.as_mut() else { return };
    let model = &data.model.model;
    let skins = artifacts.recording().bodies().to_vec();
    let shown = LiveModel {
        name: data.name.clone(),
        contacts: model.contact_names().into_iter().map(String::from).collect(),
        bodies: model.bodies.clone(),
        obstacles: placed(model),
        units: data.listed_units(),
        marks: marks(model, &skins),
        skins,
        shown: data.keeping.stills.clone(),
    };
    let columns = names(history_columns(model, &data.probes.borrow()));
    artifacts.show_to(LiveSimulation::begin(live, shown, columns), &data.history.borrow());
    tell_problem(host, handle, artifacts.live());
}

/// Updates the description of the problem in the live report, unless it was updated a moment ago.
pub fn tell_now_and_then(host: &Host, handle: &SimulationHandle) {
    if let Some(artifacts) = handle.0.artifacts.borrow_mut().as_mut() {
        tell_problem(host, handle, artifacts.live().filter(|live| live.wants_problem()));
    }
}

/// Updates the description of the problem in the live report: the script may have read a parameter or a module since.
pub fn tell(host: &Host, handle: &SimulationHandle) {
    if let Some(artifacts) = handle.0.artifacts.borrow_mut().as_mut() {
        tell_problem(host, handle, artifacts.live());
    }
}

fn tell_problem(host: &Host, handle: &SimulationHandle, live: Option<&mut LiveSimulation>) {
    if let (Some(live), Ok(simulation)) = (live, handle.0.simulation.try_borrow()) {
        let tables = tables(&handle.0, &simulation);
        live.tell(LiveProblem { scripts: scripts(host), parameters: parameters(host), tables });
    }
}

/// Passes the outcome of a simulation to the live report.
pub fn end(host: &Host, handle: &SimulationHandle, outcome: &str, is_well: bool) {
    let data = &handle.0;
    let (Ok(simulation), mut artifacts) = (data.simulation.try_borrow(), data.artifacts.borrow_mut()) else { return };
    let Some(artifacts) = artifacts.as_mut().filter(|_| host.settings.live.is_some()) else { return };
    let history = data.history.borrow();
    let (found, stills) = (findings(host, data, &simulation, &history), artifacts.stills(&simulation, history.len() - 1));
    if let Some(live) = artifacts.live() {
        live.stills(&stills);
        live.tell(LiveProblem { scripts: scripts(host), parameters: parameters(host), tables: tables(data, &simulation) });
        live.end(LiveOutcome { words: outcome.into(), is_well }, found);
    }
}
