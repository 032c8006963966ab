//! Output of a point, kept in `output.txt` of its folder.

use std::cell::{Cell, RefCell};

use crate::output::{OutputError, RunFiles, Stream};
use crate::script::{Diagnostic, Ink, Observer};

/// Largest number of bytes that are kept.
const MOST: u64 = 16 << 20;

/// File of printed lines, warnings and the error of a point.
pub struct Transcript {
    stream: RefCell<Option<Stream>>,
    warnings: Cell<u64>,
}

impl Transcript {
    /// Creates the file in the folder of a point.
    ///
    /// # Errors
    /// The file cannot be created.
    pub fn new(files: &RunFiles) -> Result<Self, OutputError> {
        let stream = files.stream("output.txt")?;
        Ok(Transcript { stream: RefCell::new(Some(stream)), warnings: Cell::new(0) })
    }

    /// Number of warnings so far.
    pub fn warnings(&self) -> u64 {
        self.warnings.get()
    }

    /// Appends a text to the file, up to its largest size.
    pub fn say(&self, text: &str) {
        let mut stream = self.stream.borrow_mut();
        // Failed writes are ignored; important files have errors of their own.
        let kept = stream.as_mut().is_some_and(|stream| stream.length() < MOST && stream.append(text.as_bytes()).is_ok());
        if !kept {
            *stream = None;
        }
    }
}

impl Observer for Transcript {
    fn print(&self, line: &str) {
        self.say(&format!("{line}\n"));
    }

    fn passed(&self, line: &str) {
        self.say(&format!("{line}\n"));
    }

    fn warn(&self, warning: &Diagnostic) {
        self.warnings.set(self.warnings.get() + 1);
        self.say(&warning.render(Ink::Plain));
    }
}
