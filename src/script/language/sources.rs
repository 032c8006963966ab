//! The texts that scripts came from, so that every message can show the line it speaks of.
//!
//! One table, from the name of a source (the path as the user gave it, or the path of an import) to its text, shared by the engine,
//! the module resolver and the diagnostics.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use rhai::Position;

/// Texts by the name of their source.
#[derive(Clone, Default)]
pub struct Sources {
    texts: RefCell<BTreeMap<String, Arc<str>>>,
    segments: RefCell<Vec<Segment>>,
}

/// A text with a name of its own that was appended to a source.
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

    /// Appends a text with a name of its own to a source, on a new line: the engine numbers the lines of a session through, messages
    /// show each text by itself (see [`Self::relocate`]).
    pub fn append(&self, source: &str, name: &str, text: &str) {
        let whole = self.text(source).map_or(String::new(), |text| text.to_string());
        let start = whole.len();
        self.insert(source, &format!("{whole}{text}\n"));
        self.segments.borrow_mut().push(Segment { source: source.into(), start, name: name.into(), text: text.into() });
    }

    /// A place in the text that was appended there, if it was.
    pub fn relocate(&self, place: Place) -> Place {
        let segments = self.segments.borrow();
        let inside = |segment: &&Segment| segment.source == place.source && segment.start <= place.range.start;
        let Some(segment) = segments.iter().rev().find(inside) else { return place };
        let shifted = |byte: usize| (byte - segment.start).min(segment.text.len());
        let range = shifted(place.range.start)..shifted(place.range.end.max(place.range.start));
        Place { source: segment.name.clone(), text: segment.text.clone(), range }
    }

    /// The text that was appended under that name last.
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

    /// The text of that source.
    pub fn text(&self, name: &str) -> Option<Arc<str>> {
        self.texts.borrow().get(name).cloned()
    }
}

/// A stretch of a source's text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// Name of the source.
    pub source: String,
    /// Its text.
    pub text: Arc<str>,
    /// Bytes of the text.
    pub range: Range<usize>,
}

impl Place {
    /// Line and column (in characters), both from 1, of the beginning.
    pub fn line_column(&self) -> (usize, usize) {
        let before = &self.text[..self.range.start.min(self.text.len())];
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }
}

impl std::fmt::Display for Place {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (line, column) = self.line_column();
        write!(out, "{}:{line}:{column}", self.source)
    }
}

/// Byte offset of a position; the end of the last line with text when the position lies past the end.
pub fn offset(text: &str, position: Position) -> Option<usize> {
    let line = position.line()?;
    let column = position.position().unwrap_or(1);
    let mut start = 0;
    for _ in 1..line {
        match text[start..].find('\n') {
            Some(newline) => start += newline + 1,
            None => return Some(text.trim_end().len()),
        }
    }
    let rest = &text[start..];
    let end = rest.find('\n').unwrap_or(rest.len());
    let inside = rest[..end].char_indices().nth(column - 1).map_or(end, |(byte, _)| byte);
    let found = start + inside;
    Some(if text[found..].trim_start().is_empty() { text.trim_end().len() } else { found })
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
        let place = Place { source: "a.rhai".into(), text: text.into(), range: 19..20 };
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
        let place = sources.relocate(Place { source: "session".into(), text, range: start..start + 1 });
        assert_eq!((place.to_string().as_str(), &*place.text), ("entry 2:1:5", "a + x"));
        assert_eq!(sources.relocate(place.clone()), place);
    }
}
