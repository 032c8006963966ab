//! Files at the end of a run, whatever its outcome: the last frames, the picture of the energies, the summaries.

use std::time::{Duration, Instant};

use super::following;
use super::handle::{SimulationHandle, Simulations};
use super::recalling::go_on;
use super::reports::{Ending, json, write_at_end};
use crate::dynamics::PhaseTimes;
use crate::output::{
    COMPLETED, Inertia, NOT_CONSERVING, RunFiles, SUMMARY, Summary, WallSeconds, drifts, energies, peak_memory_bytes, svg,
};
use crate::script::api::files::failures::output_failure;
use crate::script::api::files::results::Results;
use crate::script::api::files::run_folder::{RunFolder, output_folder};
use crate::script::api::parameters::{Overrides, ParameterUnits};
use crate::script::language::prelude::*;

/// Writes the last frames of all simulations and waits until all frames are written.
///
/// # Errors
/// The first file that could not be written.
pub fn last_frames(host: &Host) -> Result<(), Failure> {
    go_on(host)?;
    let write = |handle: &SimulationHandle| {
        let (Ok(simulation), mut artifacts) = (handle.0.simulation.try_borrow(), handle.0.artifacts.borrow_mut()) else { return Ok(()) };
        let Some(artifacts) = artifacts.as_mut() else { return Ok(()) };
        artifacts.complete(&simulation).and_then(|()| handle.check_rows())
    };
    Simulations::of(host).0.borrow().iter().map(write).fold(Ok(()), Result::and)
}

/// Writes the picture of the energies and the summaries, after the last frames.
///
/// `begun` is the start of the program, `outcome` is `completed`, `interrupted` or the title of the error.
///
/// # Errors
/// A file that cannot be written.
pub fn finish(host: &Host, begun: Instant, outcome: &str) -> Result<(), Failure> {
    let Some(folder) = output_folder(host) else { return Ok(()) };
    let run = RunFolder::of(host);
    // A failure before the first file leaves the files of an earlier run, or of a run under way, unchanged.
    if outcome != COMPLETED && !run.is_begun() && RunFiles::are_in(folder) {
        return Ok(());
    }
    let simulations = Simulations::of(host);
    let simulations = simulations.0.borrow();
    // Remaining files are written even if some cannot be.
    let mut written = Ok(());
    for handle in simulations.iter() {
        written = written.and(finish_simulation(host, handle, begun, outcome, &simulations));
    }
    if simulations.is_empty() {
        let summary = Summary { wall_seconds: wall(begun, &[]), ..common(host, outcome) };
        let write = || run.files(host)?.map_or(Ok(()), |files| files.write(SUMMARY, summary.to_json()).map(drop));
        written = write().map_err(|error| output_failure(&error));
    }
    written
}

fn finish_simulation(
    host: &Host,
    handle: &SimulationHandle,
    begun: Instant,
    outcome: &str,
    all: &[SimulationHandle],
) -> Result<(), Failure> {
    let data = &handle.0;
    let (Ok(simulation), history) = (data.simulation.try_borrow(), data.history.borrow()) else { return Ok(()) };
    let drawn = {
        let mut artifacts = data.artifacts.borrow_mut();
        // While the steps of an earlier process are replayed from the journal, no files are written.
        let Some(artifacts) = artifacts.as_mut().filter(|artifacts| !artifacts.recalls()) else { return Ok(()) };
        let mut plot = energies(&data.name, &*history);
        plot.x.label += &data.bracketed("time");
        plot.y.label += &data.bracketed("energy");
        let picture = svg(&plot.draw());
        artifacts.write("history.svg", picture.as_bytes()).map_err(|error| output_failure(&error))
    };
    let found = data.found(&simulation, &history);
    let is_conserving = !found.findings.iter().any(|finding| finding.kind.breaks_conservation());
    let is_well = outcome == COMPLETED && is_conserving;
    let ended = if outcome == COMPLETED && !is_conserving { NOT_CONSERVING } else { outcome };
    let refused = drawn.and(write_at_end(host, handle, Ending { outcome: ended.into(), is_well })).err();
    let (ended, is_well) = match &refused {
        Some(failure) if outcome == COMPLETED => (&*failure.title, false),
        _ => (ended, is_well),
    };
    following::end(host, handle, ended, is_well);
    let mut summary = Summary {
        bodies: data.model.model.bodies.len(),
        unknowns: simulation.unknowns(),
        wall_seconds: wall(begun, all),
        peak_memory_bytes: peak_memory_bytes(),
        units: data.units.as_ref().map(|units| units.set.overview().into_iter().collect()),
        ..common(host, ended)
    };
    summary.book(&found.account);
    summary.count(&simulation.statistics(), simulation.rank_bytes());
    summary.tell(&found.findings, simulation.halvings());
    summary.judge(&drifts(&*history, simulation.loads_ended(), Some(Inertia::of(&data.model.model))));
    let mut artifacts = data.artifacts.borrow_mut();
    let Some(artifacts) = artifacts.as_mut() else { return Ok(()) };
    let summarized = artifacts.write(SUMMARY, summary.to_json().as_bytes()).map_err(|error| output_failure(&error));
    refused.map_or(summarized, Err)
}

fn common(host: &Host, outcome: &str) -> Summary {
    Summary {
        script: host.main.borrow().clone(),
        parameters: host.slots.get::<Overrides>().parameters().into_iter().map(|(name, value)| (name, json(&value))).collect(),
        parameter_units: ParameterUnits::of(host),
        results: Results::of(host),
        result_units: Results::units(host),
        version: env!("CARGO_PKG_VERSION").into(),
        outcome: outcome.into(),
        ..Summary::default()
    }
}

/// Returns the wall-clock time of the program by phase.
fn wall(begun: Instant, simulations: &[SimulationHandle]) -> WallSeconds {
    let (mut phases, mut output) = (PhaseTimes::default(), Duration::ZERO);
    for handle in simulations {
        if let Ok(simulation) = handle.0.simulation.try_borrow() {
            let times = simulation.statistics().times;
            phases.assembly += times.assembly;
            phases.contact += times.contact;
            phases.factorization += times.factorization;
            phases.solve += times.solve;
            phases.search += times.search;
        }
        output += handle.0.artifacts.borrow().as_ref().map_or(Duration::ZERO, |artifacts| artifacts.spent());
    }
    let kernels: Duration = simulations.iter().map(|handle| handle.0.spent.get()).sum();
    let total = begun.elapsed();
    WallSeconds::new(total, &phases, output, total.saturating_sub(kernels + output))
}
