//! PVD: the list of a simulation's VTU files with their times, for ParaView and PyVista.
//!
//! The list is replaced atomically after every frame, so that it is valid and complete however the run ends.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::files::{OutputError, RunFiles};
use super::markup::escaped;
use super::vtu::Frame;

/// Text of the list: times and paths of the frames, relative to the list.
pub fn pvd<'a>(frames: impl IntoIterator<Item = (f64, &'a str)>) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n  <Collection>\n",
    );
    for (time, path) in frames {
        let path = escaped(path);
        let _ = writeln!(text, "    <DataSet timestep=\"{time:?}\" part=\"0\" file=\"{path}\"/>");
    }
    text + "  </Collection>\n</VTKFile>\n"
}

/// Frame in the list.
#[derive(Debug)]
struct Listed {
    time: f64,
    /// Row of the history for the frame.
    row: usize,
    /// Path of the frame, relative to the list.
    path: String,
}

/// A growing series: `fields.pvd` and `fields/fields_000000.vtu`, `fields/fields_000001.vtu`, ...
#[derive(Debug)]
pub struct FieldSeries {
    files: RunFiles,
    name: String,
    stem: String,
    frames: Vec<Listed>,
    /// True if the frames of the series were written by an earlier process and are recalled: nothing is written.
    recalls: bool,
}

impl FieldSeries {
    /// Starts an empty series under the name of its list, such as `fields.pvd` (the ending may be left out).
    ///
    /// # Errors
    /// A bad name, or the operating system refused.
    pub fn create(files: &RunFiles, name: &str) -> Result<Self, OutputError> {
        let series = FieldSeries { recalls: false, ..Self::recalled(files, name)? };
        series.list()?;
        series.remove_further()?;
        Ok(series)
    }

    /// Returns a series whose frames an earlier process has written; list and frames are unchanged until [`Self::go_on`].
    ///
    /// # Errors
    /// An invalid name.
    pub fn recalled(files: &RunFiles, name: &str) -> Result<Self, OutputError> {
        let name = if name.ends_with(".pvd") { name.to_string() } else { format!("{name}.pvd") };
        let stem = files.place(&name)?.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        Ok(FieldSeries { files: files.clone(), name, stem, frames: Vec::new(), recalls: true })
    }

    /// Adds the next frame, which an earlier process has written for this time and row of the history, to the list.
    pub fn recall(&mut self, time: f64, row: usize) {
        self.frames.truncate(self.before(time));
        let path = self.path(self.frames.len());
        self.frames.push(Listed { time, row, path });
    }

    /// Ends recalling; further frames are written. Returns the time of the first recalled frame whose file is of another moment.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn go_on(&mut self) -> Result<Option<f64>, OutputError> {
        self.recalls = false;
        let is_strange = |frame: &&Listed| !self.files.counts_on(&self.below(&frame.path), frame.time);
        match self.frames.iter().find(is_strange) {
            Some(frame) => Ok(Some(frame.time)),
            None => self.list().and_then(|()| self.remove_further()).map(|()| None),
        }
    }

    /// Removes frames of an earlier process beyond the list: the frame of the interrupt, and frames after the last checkpoint.
    fn remove_further(&self) -> Result<(), OutputError> {
        let further = (self.frames.len()..).map(|number| self.below(&self.path(number)));
        further.take_while(|name| self.files.has_written(name)).try_for_each(|name| self.files.remove(&name))
    }

    /// Removes the frames behind the first `rows` rows of the history, when a simulation goes back.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn cut(&mut self, rows: usize) -> Result<(), OutputError> {
        let kept = self.frames.partition_point(|frame| frame.row < rows);
        let given_up = self.frames.split_off(kept);
        if self.recalls || given_up.is_empty() {
            return Ok(());
        }
        // The list is written first, so that it never contains a frame whose file is gone.
        self.list()?;
        given_up.iter().try_for_each(|frame| self.files.remove(&self.below(&frame.path)))
    }

    /// Writes the list.
    fn list(&self) -> Result<(), OutputError> {
        self.files.write(&self.name, pvd(self.frames.iter().map(|frame| (frame.time, frame.path.as_str())))).map(drop)
    }

    /// Checks that all frames of the list are still at their paths.
    ///
    /// # Errors
    /// A frame was removed.
    pub fn verify(&self) -> Result<(), OutputError> {
        for frame in &self.frames {
            let path = self.files.place(&self.below(&frame.path))?;
            if !path.is_file() {
                return Err(OutputError::Gone { path });
            }
        }
        Ok(())
    }

    /// Path of a frame, relative to the list.
    fn path(&self, number: usize) -> String {
        format!("{0}/{0}_{number:06}.vtu", self.stem)
    }

    /// Converts a path relative to the list into one relative to the output directory.
    fn below(&self, path: &str) -> String {
        Path::new(&self.name).with_file_name(path).to_string_lossy().into_owned()
    }

    /// Number of frames before a time.
    fn before(&self, time: f64) -> usize {
        self.frames.iter().rposition(|frame| frame.time < time).map_or(0, |last| last + 1)
    }

    /// Times of the frames.
    pub fn times(&self) -> impl Iterator<Item = f64> + '_ {
        self.frames.iter().map(|frame| frame.time)
    }

    /// Time of the last frame and the row of the history that belongs to it.
    pub fn last(&self) -> Option<(f64, usize)> {
        self.frames.last().map(|frame| (frame.time, frame.row))
    }

    /// Writes a frame with the row of the history that belongs to it, and returns the place of the frame. Times ascend in a series: frames
    /// at this time, left from before the simulation settled, are dropped.
    ///
    /// # Errors
    /// The operating system refused; the list then names what was written before.
    pub fn append(&mut self, frame: &Frame, row: usize) -> Result<PathBuf, OutputError> {
        let time = frame.time();
        let given_up = self.frames.split_off(self.before(time));
        let path = self.path(self.frames.len());
        let place = self.files.write_counted(&self.below(&path), Some(time), frame.encode())?;
        self.frames.push(Listed { time, row, path });
        self.list()?;
        given_up.iter().skip(1).try_for_each(|frame| self.files.remove(&self.below(&frame.path)))?;
        Ok(place)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::inputs::Inputs;
    use super::super::samples::{ring, scratch};
    use super::*;

    #[test]
    fn the_list_names_frames_and_times() {
        insta::assert_snapshot!(pvd([(0.0, "fields/fields_000000.vtu"), (0.1 + 0.2, "a&\"b\"/x.vtu")]), @r#"
        <?xml version="1.0"?>
        <VTKFile type="Collection" version="1.0" byte_order="LittleEndian">
          <Collection>
            <DataSet timestep="0.0" part="0" file="fields/fields_000000.vtu"/>
            <DataSet timestep="0.30000000000000004" part="0" file="a&amp;&quot;b&quot;/x.vtu"/>
          </Collection>
        </VTKFile>
        "#);
    }

    #[test]
    fn frames_are_numbered_and_the_list_is_complete_after_each() {
        let (directory, files) = scratch("series");
        let bodies = [ring("ring", [1.0, 1.5], [2, 12])];
        let mut series = FieldSeries::create(&files, "run/fields.pvd").unwrap();
        for (number, time) in [0.0, 0.1, 0.2].into_iter().enumerate() {
            series.append(&Frame::new(time, &bodies), number).unwrap();
            let text = fs::read_to_string(directory.join("run/fields.pvd")).unwrap();
            assert_eq!(text.matches("<DataSet").count(), number + 1);
            assert!(text.contains(&format!("file=\"fields/fields_{number:06}.vtu\"")));
            assert!(directory.join(format!("run/fields/fields_{number:06}.vtu")).exists());
        }
        // The simulation went back to the row of 0.0.
        series.cut(1).unwrap();
        assert_eq!(series.times().collect::<Vec<_>>(), [0.0]);
        assert_eq!(fs::read_dir(directory.join("run/fields")).unwrap().count(), 1);
        assert_eq!(fs::read_to_string(directory.join("run/fields.pvd")).unwrap().matches("<DataSet").count(), 1);
        // The simulation has settled without motion: the frame of the same time is replaced.
        series.append(&Frame::new(0.1, &bodies), 1).unwrap();
        series.append(&Frame::new(0.1, &bodies), 2).unwrap();
        assert_eq!((series.times().collect::<Vec<_>>(), series.last()), (vec![0.0, 0.1], Some((0.1, 2))));
    }

    #[test]
    fn a_new_run_removes_the_frames_of_the_old_one_and_nothing_else() {
        let (directory, _) = scratch("series again");
        let begin = || RunFiles::begin(&*directory, Inputs::default()).unwrap();
        let bodies = [ring("ring", [1.0, 1.5], [2, 12])];
        let mut series = FieldSeries::create(&begin(), "fields.pvd").unwrap();
        for step in 0..3 {
            series.append(&Frame::new(step as f64, &bodies), step).unwrap();
        }
        for kept in ["notes.txt", "fields_1.vtu", "fields_000009.vtu", "other_000001.vtu"] {
            fs::write(directory.join("fields").join(kept), "theirs").unwrap();
        }
        let mut series = FieldSeries::create(&begin(), "fields.pvd").unwrap();
        series.append(&Frame::new(0.0, &bodies), 0).unwrap();
        let mut left: Vec<_> = fs::read_dir(directory.join("fields")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        left.sort();
        assert_eq!(left, ["fields_000000.vtu", "fields_000009.vtu", "fields_1.vtu", "notes.txt", "other_000001.vtu"]);
    }
}
