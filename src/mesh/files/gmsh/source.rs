//! Content of a Gmsh file, entry by entry: one line each in a text file, consecutive numbers in a binary file.
//!
//! Text and binary files have the same layout otherwise, so they share their readers. Section marks and names are lines of text in both.
//! Numbers are stored only after they were read: a count in the file limits a loop, but never determines an allocation.

use std::str::{FromStr, SplitAsciiWhitespace};

use super::super::text::shortened;
use crate::mesh::MeshError;
use crate::mesh::file_error::{FileError, FilePosition, FileProblem};

/// Encoding of numbers.
#[derive(Clone, Copy, PartialEq)]
enum Encoding {
    Text,
    Binary { is_little: bool, size_bytes: usize, nodes_are_sizes: bool },
}

/// A file that is being read.
pub(super) struct Source<'a> {
    rest: &'a [u8],
    length: usize,
    line: usize,
    encoding: Encoding,
}

/// A section that is being read.
#[derive(Clone, Copy)]
pub(super) struct Section {
    /// Name with its dollar sign.
    pub name: &'static str,
    /// Start of the section.
    pub begin: FilePosition,
    /// Announced number of entries.
    pub announced: usize,
    /// Entries read.
    pub found: usize,
}

impl Section {
    /// Section that begins at the current place.
    pub fn new(name: &'static str, source: &Source) -> Section {
        Section { name, begin: source.place(), announced: 0, found: 0 }
    }

    fn truncated(&self, at: FilePosition) -> MeshError {
        let Section { name, begin, announced, found } = *self;
        FileError { at, problem: FileProblem::Truncated { section: name.into(), begin, found, announced } }.into()
    }

    fn miscounted(&self, at: FilePosition, found: usize) -> MeshError {
        let Section { name, announced, .. } = *self;
        FileError { at, problem: FileProblem::Count { section: name, announced, found } }.into()
    }
}

impl<'a> Source<'a> {
    pub fn new(content: &'a [u8]) -> Source<'a> {
        let rest = content.strip_prefix("\u{feff}".as_bytes()).unwrap_or(content);
        Source { rest, length: content.len(), line: 0, encoding: Encoding::Text }
    }

    /// Current place: the line that was returned last, or the next byte.
    pub fn place(&self) -> FilePosition {
        match self.encoding {
            Encoding::Text => FilePosition::Line(self.line),
            Encoding::Binary { .. } => FilePosition::Byte(self.length - self.rest.len()),
        }
    }

    /// Error at the current place.
    pub fn fail<T>(&self, problem: FileProblem) -> Result<T, MeshError> {
        Err(FileError { at: self.place(), problem }.into())
    }

    pub fn is_binary(&self) -> bool {
        self.encoding != Encoding::Text
    }

    /// Continues in binary: the byte order follows from the number 1 at this place. Elements refer to nodes by four bytes or, from version
    /// 4 on, by sizes.
    pub fn begin_binary(&mut self, size_bytes: u64, nodes_are_sizes: bool) -> Result<(), MeshError> {
        self.encoding = Encoding::Binary { is_little: true, size_bytes: 8, nodes_are_sizes };
        if !matches!(size_bytes, 4 | 8) {
            return self.fail(FileProblem::NumberSize { bytes: size_bytes });
        }
        let is_little = match self.rest {
            [1, 0, 0, 0, ..] => true,
            [0, 0, 0, 1, ..] => false,
            _ => return self.fail(FileProblem::ByteOrder),
        };
        self.rest = &self.rest[4..];
        self.encoding = Encoding::Binary { is_little, size_bytes: size_bytes as usize, nodes_are_sizes };
        Ok(())
    }

    /// The next line that is not blank, without surrounding space.
    pub fn next(&mut self) -> Result<Option<&'a str>, MeshError> {
        while !self.rest.is_empty() {
            let end = self.rest.iter().position(|&byte| byte == b'\n');
            let (line, rest) = end.map_or((self.rest, &[][..]), |end| (&self.rest[..end], &self.rest[end + 1..]));
            self.line += 1;
            let line = line.trim_ascii();
            if !line.is_empty() {
                let Ok(text) = std::str::from_utf8(line) else { return self.fail(FileProblem::NotText) };
                self.rest = rest;
                return Ok(Some(text));
            }
            self.rest = rest;
        }
        Ok(None)
    }

    /// The next line of text of a section; an error when the file or the section ends before.
    pub fn line(&mut self, section: &Section) -> Result<Entry<'_, 'a>, MeshError> {
        match self.next()? {
            None => Err(section.truncated(self.place())),
            // A closing line that is incomplete (end of the file) or belongs to another section.
            Some(text) if text.starts_with('$') && self.rest.is_empty() && text.strip_prefix("$End") != section.name.strip_prefix('$') => {
                Err(section.truncated(self.place()))
            }
            Some(text) if text.starts_with('$') => Err(section.miscounted(self.place(), section.found)),
            Some(text) => Ok(Entry { words: text.split_ascii_whitespace(), at: self.place(), source: self, text, section: *section }),
        }
    }

    /// Next entry of a section: a line, or the place of the next numbers.
    pub fn entry(&mut self, section: &Section) -> Result<Entry<'_, 'a>, MeshError> {
        match self.encoding {
            Encoding::Text => self.line(section),
            Encoding::Binary { .. } => {
                Ok(Entry { words: "".split_ascii_whitespace(), at: self.place(), source: self, text: "", section: *section })
            }
        }
    }

    /// Reads the closing line of a section.
    pub fn close(&mut self, section: &Section) -> Result<(), MeshError> {
        let at = self.place();
        let is_binary = self.is_binary();
        match self.next() {
            // Bytes after the binary numbers that are no text are further numbers.
            Err(_) if is_binary => Err(section.miscounted(at, section.announced.saturating_add(1))),
            Err(error) => Err(error),
            Ok(None) => Err(section.truncated(self.place())),
            Ok(Some(text)) if text.strip_prefix("$End") == section.name.strip_prefix('$') => Ok(()),
            Ok(Some(_)) if self.rest.is_empty() => Err(section.truncated(self.place())),
            Ok(Some(text)) if text.starts_with('$') => {
                self.fail(FileProblem::Malformed { expected: "the closing line of the section", found: shortened(text) })
            }
            Ok(Some(_)) => Err(section.miscounted(if is_binary { at } else { self.place() }, section.announced.saturating_add(1))),
        }
    }

    /// Skips a section that is not needed.
    pub fn skip(&mut self, name: &str) -> Result<(), MeshError> {
        let begin = self.place();
        let mut passed = 0;
        if self.is_binary() {
            // Binary numbers may contain any bytes, so that only the closing mark ends the section.
            let mark = format!("$End{name}");
            return match self.rest.windows(mark.len()).position(|window| window == mark.as_bytes()) {
                Some(found) => {
                    self.rest = &self.rest[found + mark.len()..];
                    Ok(())
                }
                None => {
                    let at = FilePosition::Byte(self.length);
                    let section = shortened(&format!("${name}"));
                    Err(FileError { at, problem: FileProblem::Truncated { section, begin, found: 0, announced: 0 } }.into())
                }
            };
        }
        while let Some(text) = self.next()? {
            if text.strip_prefix("$End") == Some(name) {
                return Ok(());
            }
            passed += 1;
        }
        let section = shortened(&format!("${name}"));
        self.fail(FileProblem::Truncated { section, begin, found: passed, announced: passed })
    }
}

/// Entry: the fields of a line, or consecutive numbers.
pub(super) struct Entry<'s, 'a> {
    source: &'s mut Source<'a>,
    words: SplitAsciiWhitespace<'a>,
    text: &'a str,
    section: Section,
    at: FilePosition,
}

impl<'a> Entry<'_, 'a> {
    /// Start of the entry.
    pub fn place(&self) -> FilePosition {
        self.at
    }

    /// The next field of a line.
    pub fn word<T: FromStr>(&mut self, expected: &'static str) -> Result<T, MeshError> {
        match self.words.next().map(str::parse) {
            Some(Ok(number)) => Ok(number),
            _ => Err(self.malformed(expected)),
        }
    }

    /// The next bytes of a binary file, the least significant one first.
    fn bytes<const N: usize>(&mut self, is_little: bool) -> Result<[u8; N], MeshError> {
        let Some((&found, rest)) = self.source.rest.split_first_chunk::<N>() else {
            return Err(self.section.truncated(FilePosition::Byte(self.source.length)));
        };
        self.source.rest = rest;
        let mut found = found;
        if !is_little {
            found.reverse();
        }
        Ok(found)
    }

    /// A signed number of four bytes; `expected` describes the whole entry.
    pub fn int(&mut self, expected: &'static str) -> Result<i64, MeshError> {
        match self.source.encoding {
            Encoding::Text => self.word(expected),
            Encoding::Binary { is_little, .. } => Ok(i32::from_le_bytes(self.bytes(is_little)?).into()),
        }
    }

    /// Nonnegative number of four bytes.
    pub fn natural(&mut self, expected: &'static str) -> Result<u64, MeshError> {
        match self.source.encoding {
            Encoding::Text => self.word(expected),
            Encoding::Binary { .. } => {
                let at = self.source.place();
                let number = self.int(expected)?;
                let found = number.to_string();
                u64::try_from(number).map_err(|_| FileError { at, problem: FileProblem::Malformed { expected, found } }.into())
            }
        }
    }

    /// Nonnegative number with the size given by the file.
    pub fn size(&mut self, expected: &'static str) -> Result<u64, MeshError> {
        match self.source.encoding {
            Encoding::Text => self.word(expected),
            Encoding::Binary { is_little, size_bytes: 4, .. } => Ok(u32::from_le_bytes(self.bytes(is_little)?).into()),
            Encoding::Binary { is_little, .. } => Ok(u64::from_le_bytes(self.bytes(is_little)?)),
        }
    }

    /// The number of a node of an element.
    pub fn node(&mut self, expected: &'static str) -> Result<u64, MeshError> {
        match self.source.encoding {
            Encoding::Binary { nodes_are_sizes: false, .. } => self.natural(expected),
            _ => self.size(expected),
        }
    }

    /// [`Entry::size`] as a count.
    pub fn count(&mut self, expected: &'static str) -> Result<usize, MeshError> {
        match usize::try_from(self.size(expected)?) {
            Ok(count) => Ok(count),
            Err(_) => Err(self.malformed(expected)),
        }
    }

    /// Returns the next field as a real number; `expected` describes it for messages.
    pub fn real(&mut self, expected: &'static str) -> Result<f64, MeshError> {
        match self.source.encoding {
            Encoding::Text => self.word(expected),
            Encoding::Binary { is_little, .. } => Ok(f64::from_le_bytes(self.bytes(is_little)?)),
        }
    }

    /// Three real numbers.
    pub fn point(&mut self, expected: &'static str) -> Result<[f64; 3], MeshError> {
        Ok([self.real(expected)?, self.real(expected)?, self.real(expected)?])
    }

    /// Checks that the line has no further fields.
    pub fn end(&mut self, expected: &'static str) -> Result<(), MeshError> {
        if self.words.next().is_some() { Err(self.malformed(expected)) } else { Ok(()) }
    }

    /// The line as a whole.
    pub fn text(&self) -> &'a str {
        self.text
    }

    /// Returns the error of a malformed entry, or of a truncated file if the file ends with the entry.
    pub fn malformed(&self, expected: &'static str) -> MeshError {
        if self.source.rest.is_empty() {
            return self.section.truncated(self.source.place());
        }
        let found = if self.source.is_binary() { "other numbers".into() } else { shortened(self.text) };
        FileError { at: self.at, problem: FileProblem::Malformed { expected, found } }.into()
    }

    /// A problem of this entry.
    pub fn fail<T>(&self, problem: FileProblem) -> Result<T, MeshError> {
        Err(FileError { at: self.at, problem }.into())
    }
}
