//! Frames of a simulation, encoded and written in order by a separate thread, in parallel with the solver.
//!
//! The queue holds [`AHEAD`] frames; further calls wait, so that memory is bounded. The thread runs while there are frames to write:
//! [`FieldWriter::wait`] and dropping the writer end it; the former returns the series. Errors of the operating system are returned by the
//! next call. Rows of the history are written directly: a row takes microseconds and is in its file when its step is accepted.

use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::{Builder, JoinHandle};

use super::files::OutputError;
use super::pvd::FieldSeries;
use super::units::ModelUnits;
use super::vtu::{Frame, Grid};
use crate::dynamics::BodyFields;

/// Largest number of waiting frames, besides the one being written.
const AHEAD: usize = 2;

/// Thread that writes frames; its result is the series and the first error.
struct Thread {
    frames: SyncSender<(Frame, usize)>,
    handle: JoinHandle<(FieldSeries, Result<(), OutputError>)>,
}

/// Writes the frames of one simulation in the background.
pub struct FieldWriter {
    /// Series of frames; `None` while a thread has it, or if lost by a panic.
    series: Option<FieldSeries>,
    thread: Option<Thread>,
    grid: Option<Arc<Grid>>,
    /// Units of the values; `None` where none are declared.
    units: Option<Arc<ModelUnits>>,
    /// Time of the last frame that was handed over or, after an error, written, and its row of the history.
    last: Option<(f64, usize)>,
    /// True if an error of the operating system has not been reported yet.
    refused: Arc<AtomicBool>,
}

impl FieldWriter {
    /// Returns a writer of a series.
    pub fn new(series: FieldSeries) -> Self {
        FieldWriter { last: series.last(), series: Some(series), thread: None, grid: None, units: None, refused: Arc::default() }
    }

    /// The writer with the units of the values.
    pub fn in_units(mut self, units: Option<Arc<ModelUnits>>) -> Self {
        self.units = units;
        self
    }

    /// Time of the last frame, and its row of the history.
    pub fn last(&self) -> Option<(f64, usize)> {
        self.last
    }

    /// Hands over all bodies at one time, with the row of the history. The bodies must be the same at each call.
    ///
    /// # Errors
    /// The operating system refused this frame or an earlier one.
    ///
    /// # Panics
    /// The thread panicked.
    pub fn append(&mut self, time: f64, row: usize, bodies: &[BodyFields]) -> Result<(), OutputError> {
        self.check()?;
        let grid = self.grid.get_or_insert_with(|| Arc::new(Grid::new(bodies)));
        let frame = Frame::on(grid.clone(), time, bodies).in_units(self.units.clone());
        if let Some(series) = self.series.take() {
            match start(series, self.refused.clone()) {
                Ok(thread) => self.thread = Some(thread),
                // If no thread can be started, the frame is written on this thread.
                Err(series) => {
                    let written = self.series.insert(*series).append(&frame, row);
                    self.last = self.series.as_ref().and_then(FieldSeries::last);
                    return written.map(drop);
                }
            }
        }
        self.last = Some((time, row));
        match self.thread.as_ref().map(|thread| thread.frames.send((frame, row))) {
            // A thread without a receiver has panicked.
            Some(Err(_)) => self.wait(),
            _ => Ok(()),
        }
    }

    /// Calls `work` with the series when all frames are written; `None` if a panic has lost the series.
    ///
    /// # Errors
    /// The operating system refused an earlier frame, or `work` fails.
    ///
    /// # Panics
    /// The thread panicked.
    pub fn with<T>(&mut self, work: impl FnOnce(&mut FieldSeries) -> Result<T, OutputError>) -> Result<Option<T>, OutputError> {
        self.wait()?;
        let Some(series) = &mut self.series else { return Ok(None) };
        let done = work(series);
        self.last = series.last();
        done.map(Some)
    }

    /// Returns errors so far, without waiting for further frames.
    ///
    /// # Errors
    /// The operating system refused a frame.
    ///
    /// # Panics
    /// The thread panicked.
    pub fn check(&mut self) -> Result<(), OutputError> {
        if self.refused.load(Ordering::Acquire) { self.wait() } else { Ok(()) }
    }

    /// Waits until all frames are written.
    ///
    /// # Errors
    /// The operating system refused a frame.
    ///
    /// # Panics
    /// The thread panicked.
    pub fn wait(&mut self) -> Result<(), OutputError> {
        let Some(Thread { frames, handle }) = self.thread.take() else { return Ok(()) };
        drop(frames);
        let (series, outcome) = handle.join().unwrap_or_else(|panic| resume_unwind(panic));
        self.refused.store(false, Ordering::Release);
        self.last = series.last();
        self.series = Some(series);
        outcome
    }
}

impl Drop for FieldWriter {
    fn drop(&mut self) {
        if let Some(Thread { frames, handle }) = self.thread.take() {
            drop(frames);
            // The writer is dropped, so the series that the thread returns is discarded.
            let _ = handle.join();
        }
    }
}

/// Starts the thread, or returns the series if the operating system cannot start one.
fn start(series: FieldSeries, refused: Arc<AtomicBool>) -> Result<Thread, Box<FieldSeries>> {
    let (frames, queue) = sync_channel::<(Frame, usize)>(AHEAD);
    // The series is sent through a separate channel: a thread that cannot be started would keep it.
    let (hand_over, receive) = sync_channel::<FieldSeries>(1);
    let work = move || {
        let Ok(mut series) = receive.recv() else { unreachable!("the series is sent before the first frame") };
        let mut outcome = Ok(());
        for (frame, row) in queue {
            let written = series.append(&frame, row).map(drop);
            if written.is_err() {
                outcome = outcome.and(written);
                refused.store(true, Ordering::Release);
            }
        }
        (series, outcome)
    };
    match Builder::new().name("output".into()).spawn(work) {
        Ok(handle) => match hand_over.send(series) {
            Ok(()) => Ok(Thread { frames, handle }),
            Err(back) => Err(Box::new(back.0)),
        },
        Err(_) => Err(Box::new(series)),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::samples::{ring, scratch};
    use super::*;

    fn writer(files: &super::super::RunFiles) -> FieldWriter {
        FieldWriter::new(FieldSeries::create(files, "fields.pvd").unwrap())
    }

    #[test]
    fn frames_are_those_of_a_series_in_its_order() {
        let (directory, files) = scratch("writer");
        let (expected_in, expected_files) = scratch("writer expected");
        let mut bodies = [ring("ring", [1.0, 1.5], [20, 60])];
        let (mut behind, mut series) = (writer(&files), FieldSeries::create(&expected_files, "fields.pvd").unwrap());
        // More frames than the queue holds, with a return from 0.3 to 0.2.
        for (row, time) in [0.0, 0.1, 0.2, 0.3, 0.2, 0.4, 0.5, 0.6].into_iter().enumerate() {
            bodies[0].displacement[7] = [time, -time, 0.0];
            behind.append(time, row, &bodies).unwrap();
            series.append(&Frame::new(time, &bodies), row).unwrap();
            assert_eq!(behind.last(), Some((time, row)));
        }
        behind.wait().unwrap();
        for file in (0..6).map(|number| format!("fields/fields_{number:06}.vtu")).chain(["fields.pvd".into()]) {
            assert!(fs::read(directory.join(&file)).unwrap() == fs::read(expected_in.join(&file)).unwrap(), "{file}");
        }
    }

    #[test]
    fn dropping_the_writer_writes_what_was_handed_over() {
        let (directory, files) = scratch("writer dropped");
        let bodies = [ring("ring", [1.0, 1.5], [20, 60])];
        let mut behind = writer(&files);
        for step in 0..4 {
            behind.append(f64::from(step), 0, &bodies).unwrap();
        }
        drop(behind);
        let list = fs::read_to_string(directory.join("fields.pvd")).unwrap();
        assert_eq!(list.matches("<DataSet").count(), 4);
        assert!(directory.join("fields/fields_000003.vtu").is_file());
    }

    #[test]
    fn a_refusal_is_told_once_and_later_frames_are_written() {
        let (directory, files) = scratch("writer refused");
        let bodies = [ring("ring", [1.0, 1.5], [2, 12])];
        let mut behind = writer(&files);
        behind.append(0.0, 0, &bodies).unwrap();
        behind.wait().unwrap();
        // A folder at the place of the frame.
        fs::create_dir(directory.join("fields/fields_000001.vtu")).unwrap();
        behind.append(0.1, 1, &bodies).unwrap();
        let error = behind.wait().unwrap_err();
        assert!(error.to_string().contains("fields_000001.vtu\" could not be written"), "{error}");
        assert_eq!(behind.last(), Some((0.0, 0)), "the frame that is missing is due again");
        behind.wait().unwrap();
        fs::remove_dir(directory.join("fields/fields_000001.vtu")).unwrap();
        behind.append(0.2, 2, &bodies).unwrap();
        behind.wait().unwrap();
        let list = fs::read_to_string(directory.join("fields.pvd")).unwrap();
        assert_eq!(list.matches("<DataSet").count(), 2);
        assert!(list.contains("timestep=\"0.2\" part=\"0\" file=\"fields/fields_000001.vtu\""), "{list}");
    }

    #[test]
    fn a_refusal_is_told_without_being_waited_for() {
        let (directory, files) = scratch("writer told");
        let bodies = [ring("ring", [1.0, 1.5], [2, 12])];
        let mut behind = writer(&files);
        fs::create_dir_all(directory.join("fields/fields_000000.vtu")).unwrap();
        let begun = std::time::Instant::now();
        let mut time = 0.0;
        // The queue is bounded, so that a few frames suffice; the time limit only ends a loop with a defect.
        while behind.append(time, 0, &bodies).is_ok() {
            assert!(begun.elapsed().as_secs() < 60, "the refusal is not told");
            time += 1.0;
        }
    }
}
