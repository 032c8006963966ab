//! Words of a text with their lines, for files whose numbers are separated by white space.

use std::str::FromStr;

use super::text::shortened;
use crate::mesh::MeshError;
use crate::mesh::file_error::{FileError, FilePosition, FileProblem};

/// Words of a text, in their order.
pub(super) struct Words<'a> {
    rest: &'a str,
    line: usize,
    comment: char,
}

impl<'a> Words<'a> {
    /// Words of a text in which a character begins a comment up to the end of the line.
    pub fn new(text: &'a str, comment: char) -> Words<'a> {
        Words { rest: text, line: 1, comment }
    }

    /// Line of the next word.
    pub fn place(&mut self) -> FilePosition {
        self.skip();
        FilePosition::Line(self.line)
    }

    fn skip(&mut self) {
        loop {
            let trimmed = self.rest.trim_start();
            self.line += self.rest[..self.rest.len() - trimmed.len()].bytes().filter(|&byte| byte == b'\n').count();
            self.rest = trimmed;
            if !trimmed.starts_with(self.comment) {
                return;
            }
            self.rest = &trimmed[trimmed.find('\n').unwrap_or(trimmed.len())..];
        }
    }

    /// Next word, without consuming it.
    pub fn peek(&mut self) -> Option<&'a str> {
        self.skip();
        let end = self.rest.find(char::is_whitespace).unwrap_or(self.rest.len());
        (end > 0).then(|| &self.rest[..end])
    }

    /// Next word.
    pub fn next(&mut self) -> Option<&'a str> {
        let word = self.peek()?;
        self.rest = &self.rest[word.len()..];
        Some(word)
    }

    /// Next word as a number.
    ///
    /// # Errors
    /// Another word, or the end of the file.
    pub fn number<T: FromStr>(&mut self, expected: &'static str) -> Result<T, MeshError> {
        let at = self.place();
        let word = self.next();
        word.and_then(|word| word.parse().ok()).ok_or_else(|| malformed(at, expected, word.unwrap_or("the end of the file")))
    }
}

/// Error of a place with other content than expected.
pub(super) fn malformed(at: FilePosition, expected: &'static str, found: &str) -> MeshError {
    FileError { at, problem: FileProblem::Malformed { expected, found: shortened(found) } }.into()
}
