//! The output folder of a run: its path, and the moment at which this run takes it over.
//!
//! Until a run writes its first file, the folder keeps the files of an earlier run: a script that cannot be read, or fails before any
//! simulation, removes no files. With the first file, the files and checkpoints of the earlier run are removed.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use crate::output::checkpoint::{self, Checkpoint};
use crate::output::{CountedFile, OutputError, RunFiles, RunLock};
use crate::script::api::nested_runs::is_study;
use crate::script::language::host::Host;
use crate::script::language::settings::Mode;

/// Output folder of a session.
#[derive(Default)]
pub struct RunFolder {
    files: RefCell<Option<RunFiles>>,
    lock: RefCell<Option<RunLock>>,
    /// Process that held the folder at the first request; a folder that was refused once stays refused for this run.
    refused: RefCell<Option<String>>,
    /// Files to which the checkpoints of an earlier process refer, if this run resumes it.
    resumed: RefCell<Option<Vec<Vec<CountedFile>>>>,
}

impl RunFolder {
    /// Returns the folder of a session.
    pub fn of(host: &Host) -> Rc<RunFolder> {
        host.slots.get()
    }

    /// Marks the run as resumed: files of the earlier process are kept. The folder is locked already.
    pub fn resume(&self, run: &Path, checkpoint: &Checkpoint, lock: RunLock) {
        self.lock.replace(Some(lock));
        self.resumed.replace(Some(checkpoint.promises(run)));
    }

    /// True if this run has written into the folder.
    pub fn is_begun(&self) -> bool {
        self.files.borrow().is_some()
    }

    /// Refuses a folder in which another process writes, without changing it.
    ///
    /// # Errors
    /// A run is under way in the folder.
    pub fn refuse_if_taken(&self, host: &Host) -> Result<(), OutputError> {
        let is_ours = self.lock.borrow().is_some();
        output_folder(host).filter(|_| !is_ours).map_or(Ok(()), |folder| RunLock::refuse_if_taken(folder))
    }

    /// Returns the files of the run; `None` if the session writes no files. On the first call, the folder is locked, and the files of an
    /// earlier run are removed.
    ///
    /// # Errors
    /// Another process writes to the folder; the operating system refused.
    pub fn files(&self, host: &Host) -> Result<Option<RunFiles>, OutputError> {
        let Some(folder) = output_folder(host) else { return Ok(None) };
        if !self.is_begun() {
            if let Some(process) = self.refused.borrow().clone() {
                return Err(OutputError::UnderWay { directory: folder.into(), process });
            }
            RunFiles::create(folder)?;
            if self.lock.borrow().is_none() {
                let taken = RunLock::take(folder).inspect_err(|error| {
                    if let OutputError::UnderWay { process, .. } = error {
                        self.refused.replace(Some(process.clone()));
                    }
                });
                self.lock.replace(Some(taken?));
            }
            let inputs = host.sandbox.inputs();
            let files = match self.resumed.take() {
                Some(promised) => RunFiles::resume(folder, inputs, promised)?,
                None => {
                    checkpoint::remove_all(folder)?;
                    RunFiles::begin(folder, inputs)?
                }
            };
            self.files.replace(Some(files));
        }
        Ok(self.files.borrow().clone())
    }

    /// Removes the checkpoints of this run at its end.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn remove_checkpoints(&self, host: &Host) -> Result<(), OutputError> {
        output_folder(host).filter(|_| self.is_begun()).map_or(Ok(()), |folder| checkpoint::remove_all(folder))
    }

    /// Completes the list of files when all are written, and releases the folder for other processes.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn end(&self) -> Result<(), OutputError> {
        let completed = self.files.borrow().as_ref().map_or(Ok(()), RunFiles::complete_record);
        self.lock.take();
        completed
    }
}

/// The folder of the run, if the session writes files.
pub fn output_folder(host: &Host) -> Option<&PathBuf> {
    host.settings.output.as_ref().filter(|_| host.settings.mode == Mode::Run && !is_study(host))
}
