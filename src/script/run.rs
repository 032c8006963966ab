//! The files of a run: one folder for each simulation of a script, written as the run goes.
//!
//! The first simulation writes into the run's output folder itself, every further one into a subfolder that has its name (`bearing-2`
//! for the second one of a model `bearing`). `history.csv` grows with every accepted step; `history.svg`, the last frame of the fields and
//! `summary.json` are written at the end, however the run ends.

use std::time::{Duration, Instant};

use super::failure::Failure;
use super::host::{Host, Mode};
use super::results::output_failure;
use super::simulations::{SimulationHandle, contact_columns, further_values};
use crate::dynamics::{LedgerRow, Model, PhaseTimes, Simulation};
use crate::output::{
    FieldSeries, FieldWriter, HistoryCsv, Inertia, OutputError, RunFiles, Summary, WallSeconds, drifts, energies, peak_memory_bytes,
};

/// The files of a simulation.
pub struct Artifacts {
    files: RunFiles,
    csv: HistoryCsv,
    series: FieldWriter,
    model: Model,
    every: Option<f64>,
    frames: usize,
    spent: Duration,
}

impl Artifacts {
    /// Opens the files of a simulation, if the session writes any.
    ///
    /// # Errors
    /// A folder or file that cannot be written.
    pub fn create(
        host: &Host,
        model: &Model,
        name: &str,
        every: Option<f64>,
        row: &LedgerRow,
        probes: Vec<String>,
    ) -> Result<Option<Self>, Failure> {
        let wanted = host.settings.mode == Mode::Run && !host.is_study();
        let Some(folder) = host.settings.output.as_ref().filter(|_| wanted) else { return Ok(None) };
        let begun = Instant::now();
        let first = host.simulations.borrow().is_empty();
        let folder = if first { folder.clone() } else { folder.join(file_name(name)) };
        let open = || {
            let files = RunFiles::create(folder)?;
            let mut csv =
                HistoryCsv::create(&files, "history.csv", model.dimension(), contact_columns(model).into_iter().chain(probes).collect())?;
            csv.append(row, &further_values(model, row))?;
            let series = FieldWriter::new(FieldSeries::create(&files, "fields.pvd")?);
            Ok(Artifacts { files, csv, series, model: model.clone(), every, frames: 0, spent: begun.elapsed() })
        };
        open().map(Some).map_err(|error: OutputError| output_failure(&error))
    }

    /// Before the first step: the first frame of the fields.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn begin(&mut self, simulation: &Simulation) -> Result<(), Failure> {
        if self.frames == 0 { self.frame(simulation) } else { Ok(()) }
    }

    /// After an accepted step: its row, and a frame when its time has come.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn accepted(&mut self, row: &LedgerRow, simulation: &Simulation) -> Result<(), Failure> {
        let begun = Instant::now();
        self.csv.append(row, &further_values(&self.model, row)).map_err(|error| output_failure(&error))?;
        self.series.check().map_err(|error| output_failure(&error))?;
        self.spent += begun.elapsed();
        // The simulation stands at the last of several pieces of a step; earlier ones have no fields any more.
        let due = self.every.is_some_and(|every| {
            let last = self.series.last().unwrap_or(f64::NEG_INFINITY);
            row.time == simulation.time() && (row.time / every + 1e-9).floor() > (last / every + 1e-9).floor()
        });
        if due { self.frame(simulation) } else { Ok(()) }
    }

    /// Puts another history in place of the one on disk.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn rewrite(&mut self, before: &[LedgerRow], after: &[LedgerRow]) -> Result<(), Failure> {
        let begun = Instant::now();
        let same = before.iter().zip(after).take_while(|(a, b)| a == b).count();
        let mut rewrite = || {
            self.csv.keep(same)?;
            after[same..].iter().try_for_each(|row| self.csv.append(row, &further_values(&self.model, row)))
        };
        rewrite().map_err(|error| output_failure(&error))?;
        self.spent += begun.elapsed();
        Ok(())
    }

    /// Adds columns to the history; rows that are there get empty fields.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add_columns(&mut self, names: &[String]) -> Result<(), Failure> {
        self.csv.add_columns(names).map_err(|error| output_failure(&error))
    }

    /// Writes a file below the simulation's folder.
    ///
    /// # Errors
    /// The path leads outside, or the file cannot be written.
    pub fn write(&mut self, path: &str, bytes: &[u8]) -> Result<(), OutputError> {
        let begun = Instant::now();
        self.files.write(path, bytes)?;
        self.spent += begun.elapsed();
        Ok(())
    }

    /// Waits until all frames are in their files; without that they may come a little later than the steps.
    ///
    /// # Errors
    /// A file that could not be written.
    pub fn wait(&mut self) -> Result<(), Failure> {
        let begun = Instant::now();
        let waited = self.series.wait().map_err(|error| output_failure(&error));
        self.spent += begun.elapsed();
        waited
    }

    fn frame(&mut self, simulation: &Simulation) -> Result<(), Failure> {
        let begun = Instant::now();
        self.series.append(simulation.time(), &simulation.fields()).map_err(|error| output_failure(&error))?;
        self.frames += 1;
        self.spent += begun.elapsed();
        Ok(())
    }
}

/// A name as a folder: what is no letter, digit, `-`, `_` or `.` becomes `_`.
fn file_name(name: &str) -> String {
    let plain: String = name.chars().map(|letter| if letter.is_alphanumeric() || "-_".contains(letter) { letter } else { '_' }).collect();
    if plain.is_empty() { "simulation".into() } else { plain }
}

/// Writes the last frames of all simulations and waits until every frame is in its file.
///
/// # Errors
/// The first file that could not be written.
pub fn last_frames(host: &Host) -> Result<(), Failure> {
    let write = |handle: &SimulationHandle| {
        let (Ok(simulation), mut artifacts) = (handle.0.simulation.try_borrow(), handle.0.artifacts.borrow_mut()) else { return Ok(()) };
        let Some(artifacts) = artifacts.as_mut() else { return Ok(()) };
        // What was refused in the midst of the run is told first, and keeps no later frame from its file.
        let refused = artifacts.wait();
        let frame = if artifacts.series.last() == Some(simulation.time()) { Ok(()) } else { artifacts.frame(&simulation) };
        refused.and(frame).and(artifacts.wait())
    };
    host.simulations.borrow().iter().map(write).fold(Ok(()), Result::and)
}

/// Writes what belongs to the end of a run after the last frames: the picture of the energies, the summaries.
///
/// `begun`: when the program began; `outcome`: `completed`, `interrupted` or the title of the error.
///
/// # Errors
/// A file that cannot be written.
pub fn finish(host: &Host, begun: Instant, outcome: &str) -> Result<(), Failure> {
    let Some(folder) = host.settings.output.as_ref().filter(|_| host.settings.mode == Mode::Run) else { return Ok(()) };
    let simulations = host.simulations.borrow();
    for handle in simulations.iter() {
        finish_simulation(host, handle, begun, outcome, &simulations)?;
    }
    if simulations.is_empty() {
        let summary = Summary { wall_seconds: wall(begun, &[]), ..common(host, outcome) };
        let files = RunFiles::create(folder).map_err(|error| output_failure(&error))?;
        files.write("summary.json", summary.to_json()).map_err(|error| output_failure(&error))?;
    }
    Ok(())
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
    {
        let mut artifacts = data.artifacts.borrow_mut();
        let Some(artifacts) = artifacts.as_mut() else { return Ok(()) };
        let picture = energies(&data.name, &history);
        artifacts.write("history.svg", picture.as_bytes()).map_err(|error| output_failure(&error))?;
    }
    let mut summary = Summary {
        bodies: data.model.model.bodies.len(),
        unknowns: simulation.unknowns(),
        wall_seconds: wall(begun, all),
        peak_memory_bytes: peak_memory_bytes(),
        ..common(host, outcome)
    };
    summary.count(&simulation.statistics());
    summary.tell(&simulation.findings(&history), simulation.halvings());
    summary.judge(&drifts(&history, simulation.loads_ended(), Some(Inertia::of(&data.model.model))));
    let mut artifacts = data.artifacts.borrow_mut();
    let Some(artifacts) = artifacts.as_mut() else { return Ok(()) };
    artifacts.write("summary.json", summary.to_json().as_bytes()).map_err(|error| output_failure(&error))
}

fn common(host: &Host, outcome: &str) -> Summary {
    let json = |value: rhai::Dynamic| match (value.as_bool(), value.as_int(), value.as_float()) {
        (Ok(flag), ..) => flag.into(),
        (_, Ok(whole), _) => whole.into(),
        (.., Ok(number)) => number.into(),
        _ => value.to_string().into(),
    };
    Summary {
        script: host.main.borrow().clone(),
        parameters: host.overrides.parameters().into_iter().map(|(name, value)| (name, json(value))).collect(),
        version: env!("CARGO_PKG_VERSION").into(),
        outcome: outcome.into(),
        ..Summary::default()
    }
}

/// Where the time of the whole program went.
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
        output += handle.0.artifacts.borrow().as_ref().map_or(Duration::ZERO, |artifacts| artifacts.spent);
    }
    let kernels: Duration = simulations.iter().map(|handle| handle.0.spent.get()).sum();
    let total = begun.elapsed();
    WallSeconds::new(total, &phases, output, total.saturating_sub(kernels + output))
}
