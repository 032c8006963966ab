//! Texts of scripts and modules, from which messages show lines.
//!
//! A table from the name of a source (the path as given by the user, or the path of an import) to its text, shared by the engine, the
//! module resolver and the diagnostics.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use rhai::Position;

/// Texts by source name.
#[derive(Clone, Default)]
pub struct Sources {
    texts: RefCell<BTreeMap<String, Arc<str>>>,
    segments: RefCell<Vec<Segment>>,
}

/// A text with its own name, appended to a source.
#[derive(Clone)]
struct Segment {
    source: String,
    start: usize,
    name: String,
    text: Arc<str>,
}

impl Sources {
    /// Adds or replaces a text.
    pub fn insert(&self, name: &str, text: &str) {
        self.texts.borrow_mut().insert(name.to_string(), text.into());
    }

    /// Appends a text with its own name to a source, on a new line: the engine numbers the lines of a session consecutively, messages show
    /// each text separately (see [`Self::relocate`]).
    pub fn append(&self, source: &str, name: &str, text: &str) {
        let whole = self.text(source).map_or(String::new(), |text| text.to_string());
        let start = whole.len();
        self.insert(source, &format!("{whole}{text}\n"));
        self.segments.borrow_mut().push(Segment { source: source.into(), start, name: name.into(), text: text.into() });
    }

    /// Converts a place in a source into a place in the appended text, if it lies in one.
    pub(crate) fn relocate(&self, place: SourceSpan) -> SourceSpan {
        let segments = self.segments.borrow();
        let inside = |segment: &&Segment| segment.source == place.source && segment.start <= place.range.start;
        let Some(segment) = segments.iter().rev().find(inside) else { return place };
        let shifted = |byte: usize| (byte - segment.start).min(segment.text.len());
        let range = shifted(place.range.start)..shifted(place.range.end.max(place.range.start));
        SourceSpan { source: segment.name.clone(), text: segment.text.clone(), range }
    }

    /// Last text appended under this name.
    pub fn appended(&self, name: &str) -> Option<Arc<str>> {
        self.segments.borrow().iter().rev().find(|segment| segment.name == name).map(|segment| segment.text.clone())
    }

    /// Takes over all texts of another session.
    pub fn take(&self, other: &Sources) {
        self.texts.borrow_mut().extend(other.all());
        self.segments.replace(other.segments.borrow().clone());
    }

    /// All texts with their names.
    pub fn all(&self) -> Vec<(String, Arc<str>)> {
        self.texts.borrow().iter().map(|(name, text)| (name.clone(), text.clone())).collect()
    }

    /// Number of stored source texts.
    pub fn count(&self) -> usize {
        self.texts.borrow().len()
    }

    /// Text of the source with this name.
    pub fn text(&self, name: &str) -> Option<Arc<str>> {
        self.texts.borrow().get(name).cloned()
    }
}

/// A stretch of a source's text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceSpan {
    /// Name of the source.
    pub source: String,
    /// Text of the source.
    pub text: Arc<str>,
    /// Bytes of the text.
    pub range: Range<usize>,
}

impl SourceSpan {
    /// Line and column (in characters), both from 1, of the beginning.
    pub(crate) fn line_column(&self) -> (usize, usize) {
        let before = &self.text[..self.range.start.min(self.text.len())];
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }
}

impl std::fmt::Display for SourceSpan {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (line, column) = self.line_column();
        write!(out, "{}:{line}:{column}", self.source)
    }
}

/// Byte offset of a position; the end of the last line with text when the position lies past the end.
pub fn offset(text: &str, position: Position) -> Option<usize> {
    Offsets::new(text).of(position)
}

/// Byte offsets of positions in a text. For ascending positions, each is found from the previous one.
pub struct Offsets<'a> {
    text: &'a str,
    line: usize,
    column: usize,
    byte: usize,
}

impl<'a> Offsets<'a> {
    /// Returns the offsets of positions in a text, from its beginning on.
    pub fn new(text: &'a str) -> Self {
        Offsets { text, line: 1, column: 1, byte: 0 }
    }

    /// Returns the offset of a position, as [`offset`].
    pub fn of(&mut self, position: Position) -> Option<usize> {
        let text = self.text;
        let (line, column) = (position.line()?, position.position().unwrap_or(1));
        if (line, column) < (self.line, self.column) {
            *self = Offsets::new(text);
        }
        while self.line < line {
            let Some(newline) = text[self.byte..].find('\n') else { return Some(text.trim_end().len()) };
            (self.line, self.column, self.byte) = (self.line + 1, 1, self.byte + newline + 1);
        }
        for letter in text[self.byte..].chars().take(column - self.column).take_while(|letter| *letter != '\n') {
            (self.column, self.byte) = (self.column + 1, self.byte + letter.len_utf8());
        }
        Some(if text[self.byte..].trim_start().is_empty() { text.trim_end().len() } else { self.byte })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_count_characters_and_stop_at_the_last_text() {
        let text = "let ä = 1;\n  ä + x\n\n";
        assert_eq!(offset(text, Position::new(1, 1)), Some(0));
        assert_eq!(&text[offset(text, Position::new(2, 7)).unwrap()..][..1], "x");
        assert_eq!(offset(text, Position::new(4, 1)), Some(text.trim_end().len()));
        assert_eq!(offset(text, Position::NONE), None);
        let mut offsets = Offsets::new(text);
        for (line, column) in [(1, 5), (1, 5), (1, 6), (2, 90), (2, 3), (1, 1), (3, 1), (9, 9)] {
            let position = Position::new(line, column);
            assert_eq!(offsets.of(position), offset(text, position), "{position}");
        }
        let place = SourceSpan { source: "a.rhai".into(), text: text.into(), range: 19..20 };
        assert_eq!(place.to_string(), "a.rhai:2:7");
    }

    #[test]
    fn appended_texts_are_shown_by_themselves() {
        let sources = Sources::default();
        sources.append("session", "entry 1", "let a = 1;\nlet b = 2;");
        sources.append("session", "entry 2", "a + x");
        let text = sources.text("session").unwrap();
        let start = text.find('x').unwrap();
        assert_eq!(offset(&text, Position::new(3, 5)), Some(start));
        let place = sources.relocate(SourceSpan { source: "session".into(), text, range: start..start + 1 });
        assert_eq!((place.to_string().as_str(), &*place.text), ("entry 2:1:5", "a + x"));
        assert_eq!(sources.relocate(place.clone()), place);
    }
}
