//! The files of a simulation, written as it runs.
//!
//! The first simulation of a script writes into the run's output folder, every further one into a subfolder with the name of the simulation
//! (`bearing-2` for the second one of a model `bearing`). `history.csv` grows with every accepted step; files at the end of a run are
//! written in `ending.rs`.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::columns::{HistoryColumn, further_values, history_columns, model_columns, names};
use crate::dynamics::{LedgerRow, Model, Partner, Quantity, Rows, Simulation};
use crate::math::tolerances::SAME_MOMENT;
use crate::output::{
    FieldSeries, FieldWriter, Frame, History, HistoryCsv, ListedUnits, LiveSimulation, ModelUnits, OutputError, Recording, RunFiles, Still,
    StillOptions, Surroundings, UNITS_FILE,
};
use crate::script::api::files::failures::output_failure;
use crate::script::api::files::run_folder::RunFolder;
use crate::script::language::digits::brief;
use crate::script::language::prelude::*;

/// Limits for the recorded frames and stills (animation frames) of a run.
#[derive(Clone)]
pub struct RecordingLimits {
    /// Time between two frames of the fields.
    pub fields_every: Option<f64>,
    /// Content of the recording.
    pub stills: StillOptions,
}

/// Columns of probes at the start of a simulation, and the units of its results.
pub struct Columns {
    /// History columns of probes.
    pub probes: Vec<HistoryColumn>,
    /// Units of the results; `None` where the script declares none.
    pub units: Option<ModelUnits>,
}

/// The files of a simulation.
pub struct Artifacts {
    files: RunFiles,
    csv: HistoryCsv,
    series: FieldWriter,
    /// Frames of rigid obstacles, and the extent of the bodies; `None` without obstacles.
    obstacles: Option<(FieldSeries, Surroundings)>,
    /// Frames of the secondary surfaces of contacts; `None` without contacts.
    contacts: Option<FieldSeries>,
    recording: Recording,
    /// Live report that receives the rows and stills of the run.
    live: Option<LiveSimulation>,
    model: Model,
    every: Option<f64>,
    /// True while the steps come from the journal of an earlier process, which has written their frames.
    recalls: bool,
    spent: Duration,
    /// Units of the results with those of the columns and fields; `None` where the script declares none.
    units: Option<(Arc<ModelUnits>, ListedUnits)>,
}

/// Origin of the first steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FirstSteps {
    /// Steps computed by this process; files begin anew.
    Anew,
    /// Steps computed by an earlier process, which has written their files.
    Recalled,
}

impl Artifacts {
    /// Opens the files of a simulation, if the session writes any.
    ///
    /// # Errors
    /// A folder or file that cannot be written.
    pub fn create(
        host: &Host,
        name: Option<&str>,
        model: &Model,
        keeping: &RecordingLimits,
        row: &LedgerRow,
        further: Columns,
        start: FirstSteps,
    ) -> Result<Option<Self>, Failure> {
        let begun = Instant::now();
        let open = || {
            let Some(root) = RunFolder::of(host).files(host)? else { return Ok(None) };
            let files = name.map_or(Ok(root.clone()), |name| root.below(&file_name(name)))?;
            let recalls = start == FirstSteps::Recalled;
            let Columns { probes, units } = further;
            let columns = names(model_columns(model).into_iter().chain(probes.clone()).collect());
            let mut csv = if recalls {
                HistoryCsv::recalled(&files, model.dimension(), columns)
            } else {
                HistoryCsv::create(&files, model.dimension(), columns)?
            };
            csv.append(row, &further_values(model, row))?;
            let open = if recalls { FieldSeries::recalled } else { FieldSeries::create };
            let units = units.map(|units| {
                let (mut listed, ledger) = (ListedUnits::of(&units), history_columns(model, &[]).into_iter().chain(probes));
                add_columns(&mut listed, &ledger.collect::<Vec<_>>(), &units);
                (Arc::new(units), listed)
            });
            let series = FieldWriter::new(open(&files, "fields.pvd")?).in_units(units.as_ref().map(|(units, _)| units.clone()));
            let obstacles = obstacle_series(&files, model, open)?;
            let contacts = if has_surfaces(model) { Some(open(&files, "contacts.pvd")?) } else { None };
            let (recording, every, model) = (Recording::new(model, &keeping.stills), keeping.fields_every, model.clone());
            let (live, spent) = (None, begun.elapsed());
            let made = Artifacts { files, csv, series, obstacles, contacts, recording, live, model, every, recalls, spent, units };
            made.write_units()?;
            Ok(Some(made))
        };
        open().map_err(|error: OutputError| output_failure(&error))
    }

    /// Writes the first frame of the fields before steps that end at `end`, if known.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn begin(&mut self, simulation: &Simulation, end: Option<f64>) -> Result<(), Failure> {
        let begun = Instant::now();
        self.recording.begin(simulation, self.csv.rows() - 1);
        let options = simulation.options();
        let steps = end.map_or(0.0, |end| (end - simulation.time()) / options.dt);
        self.recording.expect(steps, options.integrator.lumping().is_some());
        self.show_stills();
        self.spent += begun.elapsed();
        if self.series.last().is_none() { self.frame(simulation) } else { Ok(()) }
    }

    /// Writes the row of an accepted step, and a frame if due.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn accepted(&mut self, row: &LedgerRow, simulation: &mut Simulation) -> Result<(), Failure> {
        let begun = Instant::now();
        let further = if self.csv.is_recalled() { Vec::new() } else { further_values(&self.model, row) };
        self.csv.append(row, &further).map_err(|error| output_failure(&error))?;
        self.show_row(self.csv.rows() - 1, row);
        self.series.check().map_err(|error| output_failure(&error))?;
        // Only the last of several substeps has fields, because the simulation is at its end.
        if row.time == simulation.time() && !self.recalls {
            self.recording.advanced(simulation, self.csv.rows() - 1);
            self.show_stills();
        }
        self.spent += begun.elapsed();
        if row.time == simulation.time() { self.frame_if_due(simulation) } else { Ok(()) }
    }

    /// Writes a frame after an equilibrium, whose row is in the history, if due.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn settled(&mut self, simulation: &mut Simulation) -> Result<(), Failure> {
        // The frame of the start is written with the first step, or at the end.
        if self.series.last().is_none() && simulation.row().step == 0 { Ok(()) } else { self.frame_if_due(simulation) }
    }

    fn frame_if_due(&mut self, simulation: &mut Simulation) -> Result<(), Failure> {
        let time = simulation.time();
        let is_due = self.every.is_some_and(|every| {
            let last = self.series.last().map_or(f64::NEG_INFINITY, |(time, _)| time);
            (time / every + SAME_MOMENT).floor() > (last / every + SAME_MOMENT).floor()
        });
        if !is_due {
            return Ok(());
        }
        if !self.recalls {
            simulation.look();
        }
        self.frame(simulation)
    }

    /// Replaces the history on disk; the state of `simulation` belongs to the last row.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn rewrite(&mut self, before: &History, after: &History, simulation: &Simulation) -> Result<(), Failure> {
        let begun = Instant::now();
        let same = before.common(after);
        let mut rewritten = self.csv.keep(same);
        after.visit(same, &mut |row| {
            if rewritten.is_ok() {
                rewritten = self.csv.append(row, &further_values(&self.model, row));
            }
        });
        rewritten.map_err(|error| output_failure(&error))?;
        // Adding a probe has changed the last row, but no field.
        let without = |row: &LedgerRow| LedgerRow { probes: Vec::new(), ..row.clone() };
        let shown = before.alike(after, same, |a, b| without(a) == without(b));
        self.each_series(|series| series.cut(shown)).map_err(|error| output_failure(&error))?;
        self.live.iter_mut().for_each(|live| live.cut(same));
        if self.live.is_some() {
            self.show_rows(after, same);
        }
        if !self.recalls && shown < before.len().max(after.len()) {
            self.recording.keep(shown);
            if after.len() > shown {
                self.recording.advanced(simulation, after.len() - 1);
            }
            self.show_stills();
        }
        self.spent += begun.elapsed();
        Ok(())
    }

    /// Adds columns to the history, with empty fields in existing rows.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add_columns(&mut self, columns: Vec<HistoryColumn>) -> Result<(), Failure> {
        if let Some((units, listed)) = &mut self.units {
            add_columns(listed, &columns, units);
        }
        let names = names(columns);
        self.live.iter_mut().for_each(|live| live.add_columns(&names));
        self.csv.add_columns(&names).and_then(|()| self.write_units()).map_err(|error| output_failure(&error))
    }

    /// Writes the units of columns and fields, if the script declares any.
    fn write_units(&self) -> Result<(), OutputError> {
        let Some((_, listed)) = self.units.as_ref().filter(|_| !self.recalls) else { return Ok(()) };
        self.files.write(UNITS_FILE, listed.to_json()).map(drop)
    }

    /// Units of the results, for frames.
    fn frame_units(&self) -> Option<Arc<ModelUnits>> {
        self.units.as_ref().map(|(units, _)| units.clone())
    }

    /// Files of the simulation's folder.
    pub fn files(&self) -> &RunFiles {
        &self.files
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

    /// Writes a file that shows earlier steps, which a resumed run does not compute again.
    ///
    /// # Errors
    /// The path leads outside, or the file cannot be written.
    pub fn write_counted(&mut self, path: &str, bytes: &[u8]) -> Result<(), OutputError> {
        let begun = Instant::now();
        self.files.write_counted(path, None, bytes)?;
        self.spent += begun.elapsed();
        Ok(())
    }

    /// Waits until all frames are written; otherwise they may be written later than the steps.
    ///
    /// # Errors
    /// A file that could not be written.
    pub fn wait(&mut self) -> Result<(), Failure> {
        let begun = Instant::now();
        let waited = self.series.wait().and(self.csv.verify()).map_err(|error| output_failure(&error));
        self.spent += begun.elapsed();
        waited
    }

    /// Calls `work` with the series of the fields, obstacles and contacts.
    fn each_series(&mut self, mut work: impl FnMut(&mut FieldSeries) -> Result<(), OutputError>) -> Result<(), OutputError> {
        self.series.with(&mut work)?;
        self.obstacles.iter_mut().map(|(series, _)| series).chain(&mut self.contacts).try_for_each(work)
    }

    /// Ends the replay of an earlier process: the rows so far are written as the history, and further frames are written.
    ///
    /// # Errors
    /// A file that cannot be written; a frame of another moment.
    pub fn go_on(&mut self, recording: Recording, history: &History, known: Option<(u64, u32)>) -> Result<(), Failure> {
        if !std::mem::take(&mut self.recalls) {
            return Ok(());
        }
        self.record_behind(recording);
        let model = &self.model;
        let last = known.zip(history.last());
        let taken = last.map_or(Ok(false), |(known, row)| self.csv.take_over(known, row, &further_values(model, row)));
        let begun = match taken {
            Ok(false) => self.csv.begin(history, |row| further_values(model, row)),
            taken => taken.map(drop),
        };
        let mut strange = None;
        let listed = self.each_series(|series| {
            strange = series.go_on()?.or(strange);
            Ok(())
        });
        begun.and(listed).and(self.write_units()).map_err(|error| output_failure(&error))?;
        let Some(time) = strange else { return Ok(()) };
        Err(Failure::script(format!("the frame of the fields at t = {} is not that of the run that is resumed", brief(time)))
            .code("C0954")
            .cause("what the script does must follow from its text, its parameters and the files that it reads")
            .hint("run the script anew with `conserva run`"))
    }

    /// Length and CRC-32 of the history on the disk.
    pub fn digest(&mut self) -> Option<(u64, u32)> {
        self.csv.digest()
    }

    /// True if the steps so far are those of an earlier process.
    pub fn recalls(&self) -> bool {
        self.recalls
    }

    /// True if an earlier process has written the file at this step or a later one. The steps shown in it are not available until steps are
    /// computed again.
    pub fn has_written(&self, path: &str) -> bool {
        self.recalls && self.files.place(path).is_ok_and(|place| place.is_file())
    }

    fn frame(&mut self, simulation: &Simulation) -> Result<(), Failure> {
        let (time, row, units) = (simulation.time(), self.csv.rows() - 1, self.frame_units());
        if self.recalls {
            let recall = |series: &mut FieldSeries| {
                series.recall(time, row);
                Ok(())
            };
            return self.each_series(recall).map_err(|error| output_failure(&error));
        }
        let begun = Instant::now();
        self.csv.verify().map_err(|error| output_failure(&error))?;
        self.series.append(time, row, &simulation.fields()).map_err(|error| output_failure(&error))?;
        if let Some((series, around)) = &mut self.obstacles {
            let frame = Frame::of_obstacles(time, &simulation.obstacles(), around).in_units(units.clone());
            series.append(&frame, row).map_err(|error| output_failure(&error))?;
        }
        if let Some(series) = &mut self.contacts {
            let frame = Frame::of_contacts(time, &simulation.contact_surfaces()).in_units(units);
            series.append(&frame, row).map_err(|error| output_failure(&error))?;
        }
        self.spent += begun.elapsed();
        Ok(())
    }

    /// Writes the frame of the present state unless written, and waits until all frames are written.
    ///
    /// # Errors
    /// A file that could not be written.
    pub fn complete(&mut self, simulation: &Simulation) -> Result<(), Failure> {
        if self.recalls {
            return Ok(());
        }
        // A frame that was refused during the run is reported first; the last frame is written all the same.
        let refused = self.wait();
        let last = self.series.last().map(|(_, row)| row);
        let frame = if last == Some(self.csv.rows() - 1) { Ok(()) } else { self.frame(simulation) };
        let waited = self.wait();
        let kept = self.each_series(|series| series.verify());
        refused.and(frame).and(waited).and(kept.map_err(|error| output_failure(&error)))
    }

    /// Continues a recording of the simulation from which this one branched off.
    pub fn record_behind(&mut self, recording: Recording) {
        self.recording = recording;
        self.show_stills();
    }

    /// Connects the files with the live report `live`, after `history` as the data so far.
    pub fn show_to(&mut self, live: LiveSimulation, history: &History) {
        self.live = Some(live);
        self.show_rows(history, 0);
        self.show_stills();
    }

    /// Returns the live report of the simulation.
    pub fn live(&mut self) -> Option<&mut LiveSimulation> {
        self.live.as_mut()
    }

    fn show_rows(&mut self, history: &History, from: usize) {
        let mut number = from;
        history.visit(from, &mut |row| {
            self.show_row(number, row);
            number += 1;
        });
    }

    fn show_row(&mut self, number: usize, row: &LedgerRow) {
        let Some(live) = &mut self.live else { return };
        let names = Quantity::names(&LedgerRow::columns(self.model.dimension()));
        let own = names.iter().map(|name| row.column(name).unwrap_or(f64::NAN));
        live.row(number, row, own.chain(further_values(&self.model, row)).collect());
    }

    fn show_stills(&mut self) {
        if let Some(live) = &mut self.live {
            live.stills(self.recording.stills());
        }
    }

    /// Returns the stills (recorded animation frames).
    pub fn recording(&self) -> &Recording {
        &self.recording
    }

    /// Returns the stills (animation frames), including one of the present state, whose row of the history is `row`.
    pub fn stills(&self, simulation: &Simulation, row: usize) -> Vec<Arc<Still>> {
        let mut stills = self.recording.stills().to_vec();
        if stills.last().is_none_or(|still| still.row != row) {
            stills.push(Arc::new(self.recording.still(simulation, row)));
        }
        stills
    }

    /// Adds time spent on writing a file.
    pub fn count(&mut self, spent: Duration) {
        self.spent += spent;
    }

    /// Time spent on writing files.
    pub fn spent(&self) -> Duration {
        self.spent
    }
}

/// Adds columns to the units of a run.
fn add_columns(listed: &mut ListedUnits, columns: &[HistoryColumn], units: &ModelUnits) {
    listed.add_columns(columns.iter().map(|(name, dimension)| (name.as_str(), *dimension)), units);
}

/// Function that opens a series of field files.
type Open = fn(&RunFiles, &str) -> Result<FieldSeries, OutputError>;

/// Returns the series of a model's rigid obstacles; `None` without obstacles.
fn obstacle_series(files: &RunFiles, model: &Model, open: Open) -> Result<Option<(FieldSeries, Surroundings)>, OutputError> {
    let has_any = model.interactions.iter().any(|interaction| matches!(interaction.partner, Partner::Obstacle { .. }));
    if !has_any {
        return Ok(None);
    }
    let points = model.bodies.iter().flat_map(|body| body.mesh.points.iter().copied());
    Ok(Some((open(files, "obstacles.pvd")?, Surroundings::of(points))))
}

/// True if a model has contacts, apart from ties, whose secondary surface is written.
pub fn has_surfaces(model: &Model) -> bool {
    model.interactions.iter().any(|interaction| !interaction.is_tie())
}

/// Converts a name into a folder name: characters other than letters, digits, `-`, `_` and `.` become `_`.
fn file_name(name: &str) -> String {
    let plain: String = name.chars().map(|letter| if letter.is_alphanumeric() || "-_".contains(letter) { letter } else { '_' }).collect();
    if plain.is_empty() { "simulation".into() } else { plain }
}
