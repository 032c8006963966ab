//! The text of an input file: keywords with their parameters, lines of data, comments.

use super::super::text::shortened;
use crate::mesh::MeshError;
use crate::mesh::file_error::{FileError, FilePosition, FileProblem};

/// A keyword line, with the lines that continue it.
pub(super) struct Keyword {
    /// Name in capitals, without the star, words separated by one space.
    pub name: String,
    parameters: Vec<(String, String)>,
    /// Line of the keyword.
    pub at: FilePosition,
}

impl Keyword {
    /// The value of a parameter, without quotation marks; empty for a parameter without value.
    pub fn value(&self, parameter: &str) -> Option<&str> {
        self.parameters.iter().find(|(name, _)| name == parameter).map(|(_, value)| value.as_str())
    }

    /// All parameters with their values.
    pub fn parameters(&self) -> impl Iterator<Item = (&str, &str)> {
        self.parameters.iter().map(|(name, value)| (name.as_str(), value.as_str()))
    }

    /// Value of a required parameter.
    pub fn required(&self, parameter: &'static str) -> Result<&str, MeshError> {
        match self.value(parameter) {
            Some(value) if !value.is_empty() => Ok(value),
            _ => self.fail(FileProblem::MissingParameter { keyword: self.name.clone(), parameter }),
        }
    }

    /// An error at this keyword.
    pub fn fail<T>(&self, problem: FileProblem) -> Result<T, MeshError> {
        Err(FileError { at: self.at, problem }.into())
    }
}

/// Item of an input file.
pub(super) enum Item<'a> {
    /// A keyword.
    Keyword(Keyword),
    /// A line of data.
    Data(Data<'a>),
}

/// A line of data.
#[derive(Clone, Copy)]
pub(super) struct Data<'a> {
    text: &'a str,
    /// Place of the line in the file.
    pub at: FilePosition,
}

impl<'a> Data<'a> {
    /// Comma-separated fields without surrounding space; a trailing comma adds no field.
    pub fn fields(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        let text = self.text.strip_suffix(',').unwrap_or(self.text);
        text.split(',').map(str::trim_ascii)
    }

    /// True if the line ends with a comma, so that the next line continues the record.
    pub fn goes_on(&self) -> bool {
        self.text.ends_with(',')
    }

    /// Returns the error of a malformed line, or of one with the value of a parameter of the deck, such as `<length>`.
    pub fn malformed<T>(&self, expected: &'static str) -> Result<T, MeshError> {
        if self.text.contains('<') && self.text.contains('>') {
            let problem = FileProblem::Keyword { keyword: "PARAMETER".into(), reason: "nodes, elements or sets take values from it" };
            return Err(FileError { at: self.at, problem }.into());
        }
        Err(FileError { at: self.at, problem: FileProblem::Malformed { expected, found: shortened(self.text) } }.into())
    }

    /// A field as a whole number from 0 on.
    pub fn number(&self, field: Option<&str>, expected: &'static str) -> Result<u64, MeshError> {
        match field.map(str::parse) {
            Some(Ok(number)) => Ok(number),
            _ => self.malformed(expected),
        }
    }

    /// Field as a real number, with exponents of Fortran, too; 0 for a missing field.
    pub fn real(&self, field: Option<&str>, expected: &'static str) -> Result<f64, MeshError> {
        match field {
            None | Some("") => Ok(0.0),
            Some(field) => match field.parse().or_else(|_| field.replace(['d', 'D'], "e").parse()) {
                Ok(number) => Ok(number),
                Err(_) => self.malformed(expected),
            },
        }
    }
}

/// The lines of a file.
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    line: usize,
}

impl<'a> Lines<'a> {
    pub fn new(content: &'a [u8]) -> Lines<'a> {
        Lines { rest: content.strip_prefix("\u{feff}".as_bytes()).unwrap_or(content), line: 0 }
    }

    /// Place of the line that was returned last.
    pub fn place(&self) -> FilePosition {
        FilePosition::Line(self.line)
    }

    /// The next line that is neither blank nor a comment.
    fn line(&mut self) -> Result<Option<&'a str>, MeshError> {
        while !self.rest.is_empty() {
            let end = self.rest.iter().position(|&byte| byte == b'\n');
            let (line, rest) = end.map_or((self.rest, &[][..]), |end| (&self.rest[..end], &self.rest[end + 1..]));
            self.rest = rest;
            self.line += 1;
            let line = line.trim_ascii();
            // Comment lines are skipped before decoding, since they may be in any encoding.
            if line.is_empty() || line.starts_with(b"**") {
                continue;
            }
            return match std::str::from_utf8(line) {
                Ok(text) => Ok(Some(text)),
                Err(_) => Err(FileError { at: self.place(), problem: FileProblem::NotText }.into()),
            };
        }
        Ok(None)
    }

    /// The next keyword or line of data.
    pub fn next(&mut self) -> Result<Option<Item<'a>>, MeshError> {
        let Some(text) = self.line()? else { return Ok(None) };
        let at = self.place();
        let Some(first) = text.strip_prefix('*') else { return Ok(Some(Item::Data(Data { text, at }))) };
        let mut whole = first.to_string();
        while whole.ends_with(',') {
            match self.line()? {
                Some(more) => whole.push_str(more),
                None => break,
            }
        }
        let mut fields = whole.split(',').map(str::trim_ascii);
        let words = |text: &str| text.split_ascii_whitespace().collect::<Vec<_>>().join(" ").to_ascii_uppercase();
        let name = words(fields.next().unwrap_or_default());
        let parameters = fields.filter(|field| !field.is_empty()).map(|field| {
            let (name, value) = field.split_once('=').unwrap_or((field, ""));
            (words(name), value.trim_ascii().trim_matches('"').to_string())
        });
        Ok(Some(Item::Keyword(Keyword { name, parameters: parameters.collect(), at })))
    }
}
