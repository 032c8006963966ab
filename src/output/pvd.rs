//! PVD: the list of a simulation's VTU files with their times, as ParaView and PyVista open it.
//!
//! The list is replaced in one piece after every frame, so it is valid and complete however the run ends.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::files::{OutputError, RunFiles};
use super::markup::escaped;
use super::vtu::Frame;

/// The text of the list: times and paths of the frames, relative to the list.
pub fn pvd(frames: &[(f64, String)]) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n  <Collection>\n",
    );
    for (time, path) in frames {
        let path = escaped(path);
        let _ = writeln!(text, "    <DataSet timestep=\"{time:?}\" part=\"0\" file=\"{path}\"/>");
    }
    text + "  </Collection>\n</VTKFile>\n"
}

/// A growing series: `fields.pvd` and `fields/fields_000000.vtu`, `fields/fields_000001.vtu`, ...
#[derive(Debug)]
pub struct FieldSeries {
    files: RunFiles,
    name: String,
    stem: String,
    frames: Vec<(f64, String)>,
}

impl FieldSeries {
    /// Starts an empty series under the name of its list, such as `fields.pvd` (the ending may be left out). Frames that an older run of
    /// that name left are removed.
    ///
    /// # Errors
    /// A bad name, or the operating system refused.
    pub fn create(files: &RunFiles, name: &str) -> Result<Self, OutputError> {
        let name = if name.ends_with(".pvd") { name.to_string() } else { format!("{name}.pvd") };
        let path = files.place(&name)?;
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let series = FieldSeries { files: files.clone(), name, stem, frames: Vec::new() };
        files.write(&series.name, pvd(&[]))?;
        let first = files.place(&series.below(&series.frame(0)))?;
        for entry in first.parent().into_iter().flat_map(std::fs::read_dir).flatten().flatten() {
            let file = entry.file_name();
            let number = file.to_str().and_then(|file| file.strip_prefix(&series.stem)?.strip_prefix('_')?.strip_suffix(".vtu"));
            if number.is_some_and(|number| number.len() >= 6 && number.bytes().all(|byte| byte.is_ascii_digit())) {
                std::fs::remove_file(entry.path()).map_err(|source| OutputError::Write { path: entry.path(), source })?;
            }
        }
        Ok(series)
    }

    /// Opens a series whose frames are there already, to be recalled one by one or written anew; its list stays as it is until then.
    ///
    /// # Errors
    /// A bad name, or the operating system refused.
    pub fn reopen(files: &RunFiles, name: &str) -> Result<Self, OutputError> {
        let stem = files.place(name)?.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        Ok(FieldSeries { files: files.clone(), name: name.into(), stem, frames: Vec::new() })
    }

    /// Takes the next frame, which an earlier program has written for this time, into the list; whether it is there.
    ///
    /// # Errors
    /// A bad name.
    pub fn recall(&mut self, time: f64) -> Result<bool, OutputError> {
        while self.frames.last().is_some_and(|&(last, _)| last >= time) {
            self.frames.pop();
        }
        let path = self.frame(self.frames.len());
        let is_there = self.files.place(&self.below(&path))?.is_file();
        self.frames.push((time, path));
        Ok(is_there)
    }

    /// Writes the list.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn list(&self) -> Result<(), OutputError> {
        self.files.write(&self.name, pvd(&self.frames)).map(drop)
    }

    /// Makes sure that all frames of the list are still at their places.
    ///
    /// # Errors
    /// One was removed.
    pub fn verify(&self) -> Result<(), OutputError> {
        for (_, frame) in &self.frames {
            let path = self.files.place(&self.below(frame))?;
            if !path.is_file() {
                return Err(OutputError::Gone { path });
            }
        }
        Ok(())
    }

    /// Path of a frame, relative to the list.
    fn frame(&self, number: usize) -> String {
        format!("{0}/{0}_{number:06}.vtu", self.stem)
    }

    /// A path relative to the list as one relative to the output directory.
    fn below(&self, path: &str) -> String {
        Path::new(&self.name).with_file_name(path).to_string_lossy().into_owned()
    }

    /// Times of the frames.
    pub fn times(&self) -> impl Iterator<Item = f64> + '_ {
        self.frames.iter().map(|frame| frame.0)
    }

    /// Writes a frame and returns the place of the frame. Times ascend in a series: frames at or after this time, left
    /// from before the simulation settled or went back, are dropped from the list.
    ///
    /// # Errors
    /// The operating system refused; the list then names what was written before.
    pub fn append(&mut self, frame: &Frame) -> Result<PathBuf, OutputError> {
        let time = frame.time();
        while self.frames.last().is_some_and(|&(last, _)| last >= time) {
            self.frames.pop();
        }
        let path = self.frame(self.frames.len());
        let place = self.files.write(&self.below(&path), frame.encode())?;
        self.frames.push((time, path));
        self.list()?;
        Ok(place)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::samples::{ring, scratch};
    use super::*;

    #[test]
    fn the_list_names_frames_and_times() {
        insta::assert_snapshot!(pvd(&[(0.0, "fields/fields_000000.vtu".into()), (0.1 + 0.2, "a&\"b\"/x.vtu".into())]), @r#"
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
            series.append(&Frame::new(time, &bodies)).unwrap();
            let text = fs::read_to_string(directory.join("run/fields.pvd")).unwrap();
            assert_eq!(text.matches("<DataSet").count(), number + 1);
            assert!(text.contains(&format!("file=\"fields/fields_{number:06}.vtu\"")));
            assert!(directory.join(format!("run/fields/fields_{number:06}.vtu")).exists());
        }
        // The simulation went back to 0.1.
        series.append(&Frame::new(0.1, &bodies)).unwrap();
        assert_eq!(series.times().collect::<Vec<_>>(), [0.0, 0.1]);
    }

    #[test]
    fn a_new_run_removes_the_frames_of_the_old_one_and_nothing_else() {
        let (directory, files) = scratch("series again");
        let bodies = [ring("ring", [1.0, 1.5], [2, 12])];
        let mut series = FieldSeries::create(&files, "fields.pvd").unwrap();
        for step in 0..3 {
            series.append(&Frame::new(f64::from(step), &bodies)).unwrap();
        }
        for kept in ["notes.txt", "fields_1.vtu", "fields_final.vtu", "other_000001.vtu"] {
            files.write(&format!("fields/{kept}"), "theirs").unwrap();
        }
        let mut series = FieldSeries::create(&files, "fields.pvd").unwrap();
        series.append(&Frame::new(0.0, &bodies)).unwrap();
        let mut left: Vec<_> = fs::read_dir(directory.join("fields")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        left.sort();
        assert!(FieldSeries::create(&files, "fields").unwrap().times().next().is_none());
        assert_eq!(left, ["fields_000000.vtu", "fields_1.vtu", "fields_final.vtu", "notes.txt", "other_000001.vtu"]);
    }
}
