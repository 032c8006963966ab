//! The output folder of a run: where it is, and when it becomes this run's own.
//!
//! Until a run writes its first file, the folder keeps what an earlier one left there: a script that cannot be read, or fails before it has
//! simulated anything, destroys nothing. With the first file, the files of the earlier run go, and its checkpoints.

use std::cell::{Cell, RefCell};
use std::path::PathBuf;
use std::rc::Rc;

use crate::output::{OutputError, RunFiles, checkpoint};
use crate::script::api::asides::is_study;
use crate::script::language::host::Host;
use crate::script::language::settings::Mode;

/// The output folder of a session.
#[derive(Default)]
pub struct RunFolder {
    files: RefCell<Option<RunFiles>>,
    is_resumed: Cell<bool>,
}

impl RunFolder {
    /// That of a session.
    pub fn of(host: &Host) -> Rc<RunFolder> {
        host.slots.get()
    }

    /// Says that an earlier program has begun this run: its files stay.
    pub fn resume(&self) {
        self.is_resumed.set(true);
    }

    /// Whether this run has written into it.
    pub fn is_begun(&self) -> bool {
        self.files.borrow().is_some()
    }

    /// The files of the run; none where the session writes none. The first time, those of an earlier run are removed.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn files(&self, host: &Host) -> Result<Option<RunFiles>, OutputError> {
        let Some(folder) = output_folder(host) else { return Ok(None) };
        if !self.is_begun() {
            if !self.is_resumed.get() {
                checkpoint::remove_all(folder)?;
            }
            let files = if self.is_resumed.get() { RunFiles::resume(folder) } else { RunFiles::begin(folder) };
            self.files.replace(Some(files?));
        }
        Ok(self.files.borrow().clone())
    }

    /// Completes the record of the files, when all are written.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn end(&self) -> Result<(), OutputError> {
        self.files.borrow().as_ref().map_or(Ok(()), RunFiles::complete_record)
    }
}

/// The folder of the run, if the session writes files.
pub fn output_folder(host: &Host) -> Option<&PathBuf> {
    host.settings.output.as_ref().filter(|_| host.settings.mode == Mode::Run && !is_study(host))
}
