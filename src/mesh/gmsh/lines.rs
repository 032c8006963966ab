//! The text of a mesh file line by line: line numbers, sections, numbers.
//!
//! Everything is read as it comes and kept only once it is there: a count that the file claims bounds a loop, never an allocation.

use std::str::{FromStr, SplitAsciiWhitespace};

use crate::mesh::MeshError;

/// Lines that are not blank, with their numbers.
pub(super) struct Lines<'a> {
    rest: &'a str,
    /// Number of the line that was given last, from 1.
    pub number: usize,
}

/// A section that is being read.
#[derive(Clone, Copy)]
pub(super) struct Section {
    /// Name without the dollar sign.
    pub name: &'static str,
    /// Line in which it begins.
    pub begin: usize,
    /// Entries that it announces.
    pub announced: usize,
    /// Entries read.
    pub found: usize,
}

/// The fields of one line.
pub(super) struct Fields<'a> {
    text: &'a str,
    rest: SplitAsciiWhitespace<'a>,
    line: usize,
    section: Section,
    /// Whether the file ends with this line, without a line break.
    last: bool,
}

impl<'a> Lines<'a> {
    pub fn new(text: &'a str) -> Lines<'a> {
        Lines { rest: text, number: 0 }
    }

    /// The next line that is not blank, without surrounding space.
    pub fn next(&mut self) -> Option<&'a str> {
        while !self.rest.is_empty() {
            let (line, rest) = self.rest.split_once('\n').unwrap_or((self.rest, ""));
            self.rest = rest;
            self.number += 1;
            let line = line.trim_ascii();
            if !line.is_empty() {
                return Some(line);
            }
        }
        None
    }

    /// The next line of a section; an error when the file or the section ends before.
    pub fn entry(&mut self, section: &Section) -> Result<Fields<'a>, MeshError> {
        match self.next() {
            None => Err(truncated(section, self.number)),
            // a closing line that is cut off, or that comes too early
            Some(text) if text.starts_with('$') && self.rest.is_empty() && text.strip_prefix("$End") != Some(section.name) => {
                Err(truncated(section, self.number))
            }
            Some(text) if text.starts_with('$') => {
                let Section { name, announced, found, .. } = *section;
                Err(MeshError::Count { line: self.number, section: name, announced, found })
            }
            Some(text) => {
                Ok(Fields { text, rest: text.split_ascii_whitespace(), line: self.number, section: *section, last: self.rest.is_empty() })
            }
        }
    }

    /// The closing line of a section.
    pub fn close(&mut self, section: &Section) -> Result<(), MeshError> {
        match self.next() {
            None => Err(truncated(section, self.number)),
            Some(text) if text.strip_prefix("$End") == Some(section.name) => Ok(()),
            Some(_) if self.rest.is_empty() => Err(truncated(section, self.number)),
            Some(text) if text.starts_with('$') => {
                Err(MeshError::Malformed { line: self.number, expected: "the closing line of the section", found: shortened(text) })
            }
            Some(_) => {
                let Section { name, announced, .. } = *section;
                Err(MeshError::Count { line: self.number, section: name, announced, found: announced.saturating_add(1) })
            }
        }
    }

    /// Passes over a section that is of no use here.
    pub fn skip(&mut self, name: &str) -> Result<(), MeshError> {
        let begin = self.number;
        let mut passed = 0;
        while let Some(text) = self.next() {
            if text.strip_prefix("$End") == Some(name) {
                return Ok(());
            }
            passed += 1;
        }
        Err(MeshError::Truncated { line: self.number, section: shortened(name), begin, found: passed, announced: passed })
    }
}

fn truncated(section: &Section, line: usize) -> MeshError {
    let Section { name, begin, announced, found } = *section;
    MeshError::Truncated { line, section: name.into(), begin, found, announced }
}

impl<'a> Fields<'a> {
    /// The next field as a number; `expected` says what the whole line should hold.
    pub fn number<T: FromStr>(&mut self, expected: &'static str) -> Result<T, MeshError> {
        match self.rest.next().map(str::parse) {
            Some(Ok(number)) => Ok(number),
            _ => Err(self.malformed(expected)),
        }
    }

    /// Several numbers.
    pub fn numbers<T: FromStr + Copy + Default, const N: usize>(&mut self, expected: &'static str) -> Result<[T; N], MeshError> {
        let mut numbers = [T::default(); N];
        for number in &mut numbers {
            *number = self.number(expected)?;
        }
        Ok(numbers)
    }

    /// Nothing may follow.
    pub fn end(&mut self, expected: &'static str) -> Result<(), MeshError> {
        if self.rest.next().is_some() { Err(self.malformed(expected)) } else { Ok(()) }
    }

    /// The line as a whole.
    pub fn text(&self) -> &'a str {
        self.text
    }

    /// The line does not hold what it should; when the file ends with it, it was cut off.
    pub fn malformed(&self, expected: &'static str) -> MeshError {
        if self.last {
            return truncated(&self.section, self.line);
        }
        MeshError::Malformed { line: self.line, expected, found: shortened(self.text) }
    }
}

/// The beginning of a text, for a message.
pub(super) fn shortened(text: &str) -> String {
    const LENGTH: usize = 60;
    let clean = |part: &str| part.chars().map(|c| if c.is_control() { '?' } else { c }).collect::<String>();
    match text.char_indices().nth(LENGTH) {
        Some((end, _)) => format!("{}…", clean(&text[..end])),
        None => clean(text),
    }
}
