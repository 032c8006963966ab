//! The files of a simulation, written as it runs.
//!
//! The first simulation of a script writes into the run's output folder itself, every further one into a subfolder that has its name
//! (`bearing-2` for the second one of a model `bearing`). `history.csv` grows with every accepted step; what belongs to the end of a run
//! is written in `ending.rs`.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::columns::{further_values, model_columns};
use crate::dynamics::{LedgerRow, Model, Partner, Rows, Simulation};
use crate::math::tolerances::SAME_MOMENT;
use crate::output::{
    FieldSeries, FieldWriter, Frame, History, HistoryCsv, LiveSimulation, OutputError, Recording, RunFiles, Still, Surroundings,
};
use crate::script::api::files::failures::output_failure;
use crate::script::api::files::run_folder::RunFolder;
use crate::script::language::digits::brief;
use crate::script::language::failure::Failure;
use crate::script::language::host::Host;

/// What is kept of a run.
#[derive(Clone, Copy)]
pub struct Keeping {
    /// Time between two frames of the fields.
    pub fields_every: Option<f64>,
    /// Stills of the recording at most.
    pub stills: Option<usize>,
    /// Whether they have the inside of bodies in space.
    pub stills_inside: bool,
}

/// The files of a simulation.
pub struct Artifacts {
    files: RunFiles,
    csv: HistoryCsv,
    series: FieldWriter,
    /// Where there are rigid obstacles, their frames and the extent of the bodies beside them.
    obstacles: Option<(FieldSeries, Surroundings)>,
    /// Where there are contacts, the frames of their secondary surfaces.
    contacts: Option<FieldSeries>,
    recording: Recording,
    /// Those who follow the run.
    live: Option<LiveSimulation>,
    model: Model,
    every: Option<f64>,
    /// Whether the steps are those of an earlier program, which has written their frames.
    recalls: bool,
    spent: Duration,
}

/// Whose steps come first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// This program's: files begin anew.
    Anew,
    /// Those of an earlier program, which has written its files.
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
        keeping: Keeping,
        row: &LedgerRow,
        probes: Vec<String>,
        start: Start,
    ) -> Result<Option<Self>, Failure> {
        let begun = Instant::now();
        let open = || {
            let Some(root) = RunFolder::of(host).files(host)? else { return Ok(None) };
            let files = name.map_or(Ok(root.clone()), |name| root.below(&file_name(name)))?;
            let recalls = start == Start::Recalled;
            let columns = model_columns(model).into_iter().chain(probes).collect();
            let mut csv = if recalls {
                HistoryCsv::recalled(&files, model.dimension(), columns)
            } else {
                HistoryCsv::create(&files, model.dimension(), columns)?
            };
            csv.append(row, &further_values(model, row))?;
            let open = if recalls { FieldSeries::recalled } else { FieldSeries::create };
            let series = FieldWriter::new(open(&files, "fields.pvd")?);
            let obstacles = obstacle_series(&files, model, open)?;
            let contacts = if has_surfaces(model) { Some(open(&files, "contacts.pvd")?) } else { None };
            let (recording, every, model) =
                (Recording::new(model, keeping.stills, keeping.stills_inside), keeping.fields_every, model.clone());
            let (live, spent) = (None, begun.elapsed());
            Ok(Some(Artifacts { files, csv, series, obstacles, contacts, recording, live, model, every, recalls, spent }))
        };
        open().map_err(|error: OutputError| output_failure(&error))
    }

    /// Before steps, until `end` if that is known: the first frame of the fields.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn begin(&mut self, simulation: &Simulation, end: Option<f64>) -> Result<(), Failure> {
        let begun = Instant::now();
        self.recording.begin(simulation, self.csv.rows() - 1);
        self.recording.expect(end.map_or(0.0, |end| (end - simulation.time()) / simulation.options().dt));
        self.show_stills();
        self.spent += begun.elapsed();
        if self.series.last().is_none() { self.frame(simulation) } else { Ok(()) }
    }

    /// After an accepted step: its row, and a frame when its time has come.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn accepted(&mut self, row: &LedgerRow, simulation: &mut Simulation) -> Result<(), Failure> {
        let begun = Instant::now();
        let further = if self.csv.is_recalled() { Vec::new() } else { further_values(&self.model, row) };
        self.csv.append(row, &further).map_err(|error| output_failure(&error))?;
        self.show_row(self.csv.rows() - 1, row);
        self.series.check().map_err(|error| output_failure(&error))?;
        // Only the last of several pieces of a step has fields, because the simulation stands there.
        if row.time == simulation.time() && !self.recalls {
            self.recording.advanced(simulation, self.csv.rows() - 1);
            self.show_stills();
        }
        self.spent += begun.elapsed();
        if row.time == simulation.time() { self.frame_if_due(simulation) } else { Ok(()) }
    }

    /// After an equilibrium whose row is in the history: a frame when its time has come.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn settled(&mut self, simulation: &mut Simulation) -> Result<(), Failure> {
        // That of the start comes with the first step, or at the end.
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

    /// Puts another history in place of the one on disk; `simulation` stands at its last row.
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
        // A probe that was added has changed the last row, and no field.
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

    /// Adds columns to the history; rows that are there get empty fields.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add_columns(&mut self, names: &[String]) -> Result<(), Failure> {
        self.live.iter_mut().for_each(|live| live.add_columns(names));
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

    /// The same for a file that shows the steps so far, which a run that is resumed does not know.
    ///
    /// # Errors
    /// The path leads outside, or the file cannot be written.
    pub fn write_counted(&mut self, path: &str, bytes: &[u8]) -> Result<(), OutputError> {
        let begun = Instant::now();
        self.files.write_counted(path, None, bytes)?;
        self.spent += begun.elapsed();
        Ok(())
    }

    /// Waits until all frames are in their files; without that they may come a little later than the steps.
    ///
    /// # Errors
    /// A file that could not be written.
    pub fn wait(&mut self) -> Result<(), Failure> {
        let begun = Instant::now();
        let waited = self.series.wait().and(self.csv.verify()).map_err(|error| output_failure(&error));
        self.spent += begun.elapsed();
        waited
    }

    /// Does something with the series of the fields and those beside it.
    fn each_series(&mut self, mut work: impl FnMut(&mut FieldSeries) -> Result<(), OutputError>) -> Result<(), OutputError> {
        self.series.with(&mut work)?;
        self.obstacles.iter_mut().map(|(series, _)| series).chain(&mut self.contacts).try_for_each(work)
    }

    /// From here on steps are computed: the rows so far are written as the history, and frames are written again.
    ///
    /// # Errors
    /// A file that cannot be written; a frame that is not that of its moment.
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
        begun.and(listed).map_err(|error| output_failure(&error))?;
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

    /// Whether the steps so far are those of an earlier program.
    pub fn recalls(&self) -> bool {
        self.recalls
    }

    /// Whether a file is there that an earlier program has written at this step or a later one. What it shows of the course so far is not
    /// known before steps are computed again.
    pub fn has_written(&self, path: &str) -> bool {
        self.recalls && self.files.place(path).is_ok_and(|place| place.is_file())
    }

    fn frame(&mut self, simulation: &Simulation) -> Result<(), Failure> {
        let (time, row) = (simulation.time(), self.csv.rows() - 1);
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
            let frame = Frame::of_obstacles(time, &simulation.obstacles(), around);
            series.append(&frame, row).map_err(|error| output_failure(&error))?;
        }
        if let Some(series) = &mut self.contacts {
            let frame = Frame::of_contacts(time, &simulation.contact_surfaces());
            series.append(&frame, row).map_err(|error| output_failure(&error))?;
        }
        self.spent += begun.elapsed();
        Ok(())
    }

    /// Makes sure that the last frame is that of the simulation's state, and waits until every frame is in its file.
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

    /// Goes on from what was kept before: that of the simulation from which this one branched off.
    pub fn record_behind(&mut self, recording: Recording) {
        self.recording = recording;
        self.show_stills();
    }

    /// Shows everything from here on to those who follow the run; `history` is what there is so far.
    pub fn show_to(&mut self, live: LiveSimulation, history: &History) {
        self.live = Some(live);
        self.show_rows(history, 0);
        self.show_stills();
    }

    /// Those who follow the run.
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
        let names = LedgerRow::columns(self.model.dimension());
        let own = names.iter().map(|name| row.column(name).unwrap_or(f64::NAN));
        live.row(number, row, own.chain(further_values(&self.model, row)).collect());
    }

    fn show_stills(&mut self) {
        if let Some(live) = &mut self.live {
            live.stills(self.recording.stills());
        }
    }

    /// What is kept for the animation.
    pub fn recording(&self) -> &Recording {
        &self.recording
    }

    /// The stills so far, that of the present state included, whose row of the history is `row`.
    pub fn stills(&self, simulation: &Simulation, row: usize) -> Vec<Arc<Still>> {
        let mut stills = self.recording.stills().to_vec();
        if stills.last().is_none_or(|still| still.row != row) {
            stills.push(Arc::new(self.recording.still(simulation, row)));
        }
        stills
    }

    /// Counts time that was spent on a file before it was written.
    pub fn count(&mut self, spent: Duration) {
        self.spent += spent;
    }

    /// Time spent on them.
    pub fn spent(&self) -> Duration {
        self.spent
    }
}

/// How a series is opened.
type Open = fn(&RunFiles, &str) -> Result<FieldSeries, OutputError>;

/// The series of a model's rigid obstacles, if it has any.
fn obstacle_series(files: &RunFiles, model: &Model, open: Open) -> Result<Option<(FieldSeries, Surroundings)>, OutputError> {
    let has_any = model.interactions.iter().any(|interaction| matches!(interaction.partner, Partner::Obstacle { .. }));
    if !has_any {
        return Ok(None);
    }
    let points = model.bodies.iter().flat_map(|body| body.mesh.points.iter().copied());
    Ok(Some((open(files, "obstacles.pvd")?, Surroundings::of(points))))
}

/// Whether a model has contacts with a secondary surface to look at: all but ties.
pub fn has_surfaces(model: &Model) -> bool {
    model.interactions.iter().any(|interaction| !interaction.is_tie())
}

/// A name as a folder: what is no letter, digit, `-`, `_` or `.` becomes `_`.
fn file_name(name: &str) -> String {
    let plain: String = name.chars().map(|letter| if letter.is_alphanumeric() || "-_".contains(letter) { letter } else { '_' }).collect();
    if plain.is_empty() { "simulation".into() } else { plain }
}
