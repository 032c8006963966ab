//! What a point says, kept in `output.txt` of its folder.

use std::cell::RefCell;

use crate::output::{OutputError, RunFiles, Stream};
use crate::script::{Diagnostic, Ink, Observer, Progress};

/// Most bytes that are kept.
const MOST: u64 = 16 << 20;

/// Keeps lines, warnings and the error of a point.
pub struct Transcript(RefCell<Option<Stream>>);

impl Transcript {
    /// In the folder of a point.
    ///
    /// # Errors
    /// The file cannot be made.
    pub fn new(files: &RunFiles) -> Result<Self, OutputError> {
        files.stream("output.txt").map(|stream| Transcript(RefCell::new(Some(stream))))
    }

    /// Adds a text.
    pub fn say(&self, text: &str) {
        let mut stream = self.0.borrow_mut();
        // What cannot be kept is left unsaid; files that matter fail with an error.
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
        self.say(&warning.render(Ink::Plain));
    }

    fn advanced(&self, _: &Progress) {}
    fn began(&self, _: &str) {}
    fn ended(&self) {}
}
