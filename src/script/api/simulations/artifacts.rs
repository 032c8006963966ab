//! The files of a simulation, written as it runs.
//!
//! The first simulation of a script writes into the run's output folder itself, every further one into a subfolder that has its name
//! (`bearing-2` for the second one of a model `bearing`). `history.csv` grows with every accepted step; what belongs to the end of a run
//! is written in `ending.rs`.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::columns::{further_values, model_columns};
use crate::dynamics::{LedgerRow, Model, Partner, Simulation};
use crate::math::tolerances::SAME_MOMENT;
use crate::output::{FieldSeries, FieldWriter, Frame, HistoryCsv, OutputError, Recording, RunFiles, Still, Surroundings};
use crate::script::api::asides::is_study;
use crate::script::language::failure::Failure;
use crate::script::language::host::Host;
use crate::script::language::settings::Mode;

/// What is kept of a run.
#[derive(Clone, Copy)]
pub struct Keeping {
    /// Time between two frames of the fields.
    pub fields_every: Option<f64>,
    /// Stills of the recording at most.
    pub stills: Option<usize>,
}

/// The files of a simulation.
pub struct Artifacts {
    files: RunFiles,
    csv: HistoryCsv,
    series: FieldWriter,
    /// Where there are rigid obstacles, their frames and the extent of the bodies beside them.
    obstacles: Option<(FieldSeries, Surroundings)>,
    recording: Recording,
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
        is_first: bool,
        model: &Model,
        name: &str,
        keeping: Keeping,
        row: &LedgerRow,
        probes: Vec<String>,
    ) -> Result<Option<Self>, Failure> {
        let Some(folder) = output_folder(host) else { return Ok(None) };
        let begun = Instant::now();
        let folder = if is_first { folder.clone() } else { folder.join(file_name(name)) };
        let open = || {
            let files = RunFiles::create(folder)?;
            let mut csv =
                HistoryCsv::create(&files, "history.csv", model.dimension(), model_columns(model).into_iter().chain(probes).collect())?;
            csv.append(row, &further_values(model, row))?;
            let series = FieldWriter::new(FieldSeries::create(&files, "fields.pvd")?);
            let obstacles = obstacle_series(&files, model)?;
            let (recording, every) = (Recording::new(model, keeping.stills), keeping.fields_every);
            Ok(Artifacts { files, csv, series, obstacles, recording, model: model.clone(), every, frames: 0, spent: begun.elapsed() })
        };
        open().map(Some).map_err(|error: OutputError| output_failure(&error))
    }

    /// Before steps, until `end` if that is known: the first frame of the fields.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn begin(&mut self, simulation: &Simulation, end: Option<f64>) -> Result<(), Failure> {
        let begun = Instant::now();
        self.recording.begin(simulation, self.csv.rows() - 1);
        self.recording.expect(end.map_or(0.0, |end| (end - simulation.time()) / simulation.options().dt));
        self.spent += begun.elapsed();
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
        // Only the last of several pieces of a step has fields, because the simulation stands there.
        if row.time == simulation.time() {
            self.recording.advanced(simulation, self.csv.rows() - 1);
        }
        self.spent += begun.elapsed();
        let due = self.every.is_some_and(|every| {
            let last = self.series.last().unwrap_or(f64::NEG_INFINITY);
            row.time == simulation.time() && (row.time / every + SAME_MOMENT).floor() > (last / every + SAME_MOMENT).floor()
        });
        if due { self.frame(simulation) } else { Ok(()) }
    }

    /// Puts another history in place of the one on disk; `simulation` stands at its last row.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn rewrite(&mut self, before: &[LedgerRow], after: &[LedgerRow], simulation: &Simulation) -> Result<(), Failure> {
        let begun = Instant::now();
        let same = before.iter().zip(after).take_while(|(a, b)| a == b).count();
        let mut rewrite = || {
            self.csv.keep(same)?;
            after[same..].iter().try_for_each(|row| self.csv.append(row, &further_values(&self.model, row)))
        };
        rewrite().map_err(|error| output_failure(&error))?;
        self.recording.keep(same);
        if after.len() > same {
            self.recording.advanced(simulation, after.len() - 1);
        }
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
        if let Some((series, around)) = &mut self.obstacles {
            let frame = Frame::of_obstacles(simulation.time(), &simulation.obstacles(), around);
            series.append(&frame).map_err(|error| output_failure(&error))?;
        }
        self.frames += 1;
        self.spent += begun.elapsed();
        Ok(())
    }

    /// Makes sure that the last frame is that of the simulation's state, and waits until every frame is in its file.
    ///
    /// # Errors
    /// A file that could not be written.
    pub fn complete(&mut self, simulation: &Simulation) -> Result<(), Failure> {
        // A frame that was refused during the run is reported first; the last frame is written all the same.
        let refused = self.wait();
        let frame = if self.series.last() == Some(simulation.time()) { Ok(()) } else { self.frame(simulation) };
        refused.and(frame).and(self.wait())
    }

    /// Goes on from what was kept before: that of the simulation from which this one branched off.
    pub fn record_behind(&mut self, recording: Recording) {
        self.recording = recording;
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

/// The series of a model's rigid obstacles, if it has any; what an older run left is removed.
fn obstacle_series(files: &RunFiles, model: &Model) -> Result<Option<(FieldSeries, Surroundings)>, OutputError> {
    const NAME: &str = "obstacles.pvd";
    let has_any = model.interactions.iter().any(|interaction| matches!(interaction.partner, Partner::Obstacle { .. }));
    if !has_any && !files.place(NAME)?.exists() {
        return Ok(None);
    }
    let points = model.bodies.iter().flat_map(|body| body.mesh.points.iter().map(|&[x, y, _]| [x, y]));
    let series = FieldSeries::create(files, NAME)?;
    Ok(has_any.then(|| (series, Surroundings::of(points))))
}

/// The folder of the run, if the session writes files.
pub fn output_folder(host: &Host) -> Option<&PathBuf> {
    host.settings.output.as_ref().filter(|_| host.settings.mode == Mode::Run && !is_study(host))
}

/// A name as a folder: what is no letter, digit, `-`, `_` or `.` becomes `_`.
fn file_name(name: &str) -> String {
    let plain: String = name.chars().map(|letter| if letter.is_alphanumeric() || "-_".contains(letter) { letter } else { '_' }).collect();
    if plain.is_empty() { "simulation".into() } else { plain }
}

/// The failure of a file that could not be written.
pub fn output_failure(error: &OutputError) -> Failure {
    Failure::script(error.to_string()).hint(error.cure())
}
