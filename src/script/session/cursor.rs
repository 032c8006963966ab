//! Context of the cursor in unfinished text: enclosing brackets, the call, the key, inside of a string or not.
//!
//! The engine's tokenizer stops at the first incomplete token, so unfinished input is split by a small scanner.

use std::ops::Range;

/// Kinds of tokens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PieceKind {
    /// A name or a word of the language.
    Name,
    /// A number.
    Number,
    /// A string, possibly incomplete.
    Text {
        /// True if the closing quote is present.
        closed: bool,
    },
    /// A comment, possibly incomplete.
    Comment {
        /// True if the comment is closed.
        closed: bool,
    },
    /// An opening bracket: `(`, `[`, `{`, or `#` for `#{`.
    Open(char),
    /// A closing bracket.
    Close(char),
    /// `.` or `?.`.
    Dot,
    /// `::`.
    Path,
    /// Any other sign.
    Sign(char),
}

/// A token of a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    /// Kind of the token.
    pub kind: PieceKind,
    /// Range of bytes.
    pub range: Range<usize>,
}

/// Cuts a text into pieces; white space is left out.
pub fn pieces(text: &str) -> Vec<Piece> {
    let mut found = Vec::new();
    let mut at = 0;
    let is_word = |letter: char| letter.is_alphanumeric() || letter == '_';
    while let Some(first) = text[at..].chars().next() {
        let rest = &text[at..];
        let until = |end: Option<usize>, length: usize| (end.map_or(rest.len(), |end| end + length), end.is_some());
        let (kind, length) = match first {
            _ if first.is_whitespace() => {
                at += first.len_utf8();
                continue;
            }
            '/' if rest.starts_with("//") => {
                let (length, closed) = until(rest.find('\n'), 0);
                (PieceKind::Comment { closed }, length)
            }
            '/' if rest.starts_with("/*") => {
                let (length, closed) = until(rest[2..].find("*/"), 4);
                (PieceKind::Comment { closed }, length)
            }
            '"' | '`' => {
                let end = string_end(&rest[1..], first);
                let (length, closed) = until(end, 2);
                (PieceKind::Text { closed }, length)
            }
            '#' if rest.starts_with("#{") => (PieceKind::Open('#'), 2),
            '(' | '[' | '{' => (PieceKind::Open(first), 1),
            ')' | ']' | '}' => (PieceKind::Close(first), 1),
            '?' if rest.starts_with("?.") => (PieceKind::Dot, 2),
            '.' if !rest.starts_with("..") => (PieceKind::Dot, 1),
            ':' if rest.starts_with("::") => (PieceKind::Path, 2),
            _ if first.is_ascii_digit() => {
                let fraction = |index: usize| rest[index + 1..].starts_with(|next: char| next.is_ascii_digit());
                let end = rest.char_indices().find(|&(index, letter)| !(is_word(letter) || letter == '.' && fraction(index)));
                (PieceKind::Number, end.map_or(rest.len(), |(index, _)| index))
            }
            _ if is_word(first) => (PieceKind::Name, rest.find(|letter| !is_word(letter)).unwrap_or(rest.len())),
            other => (PieceKind::Sign(other), other.len_utf8()),
        };
        found.push(Piece { kind, range: at..at + length });
        at += length;
    }
    found
}

/// Returns the position of the closing quote in the text after the opening quote.
fn string_end(text: &str, quote: char) -> Option<usize> {
    let mut escaped = false;
    for (index, letter) in text.char_indices() {
        match letter {
            _ if escaped => escaped = false,
            '\\' if quote == '"' => escaped = true,
            _ if letter == quote => return Some(index),
            _ => {}
        }
    }
    None
}

/// A bracket that is open at the cursor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Level {
    /// `(`, `[`, `{`, or `#` for `#{`.
    pub bracket: char,
    /// Index of the bracket's token.
    pub piece: usize,
    /// Number of commas inside so far.
    pub commas: usize,
    /// For a map: the keys written so far.
    pub keys: Vec<String>,
    /// For a map: the key at whose value the cursor is.
    pub key: Option<String>,
}

/// The text in front of a cursor.
pub struct Cursor<'a> {
    /// The text.
    pub text: &'a str,
    /// Tokens without comments.
    pub pieces: Vec<Piece>,
    /// Open brackets, the outermost first.
    pub levels: Vec<Level>,
    /// True if the cursor is in a comment.
    pub in_comment: bool,
    /// True if a closing bracket does not match the opening one.
    pub is_crossed: bool,
}

impl<'a> Cursor<'a> {
    /// Reads a text up to the cursor.
    pub fn new(text: &'a str) -> Self {
        let mut pieces = pieces(text);
        let in_comment = pieces.last().is_some_and(|last| matches!(last.kind, PieceKind::Comment { closed: false }));
        pieces.retain(|piece| !matches!(piece.kind, PieceKind::Comment { .. }));
        let mut cursor = Cursor { text, pieces, levels: Vec::new(), in_comment, is_crossed: false };
        for index in 0..cursor.pieces.len() {
            cursor.enter(index);
        }
        cursor
    }

    fn enter(&mut self, index: usize) {
        let name = |index: usize| match self.pieces.get(index).map(|piece| piece.kind) {
            Some(PieceKind::Name) => Some(self.slice(index).to_string()),
            Some(PieceKind::Text { closed: true }) => Some(self.slice(index).trim_matches('"').to_string()),
            _ => None,
        };
        match self.pieces[index].kind {
            PieceKind::Open(bracket) => self.levels.push(Level { bracket, piece: index, commas: 0, keys: Vec::new(), key: None }),
            PieceKind::Close(bracket) => {
                let expected = match self.levels.pop().map(|level| level.bracket) {
                    Some('(') => ')',
                    Some('[') => ']',
                    Some(_) => '}',
                    None => '\0',
                };
                self.is_crossed |= expected != bracket;
            }
            PieceKind::Sign(',') => {
                if let Some(level) = self.levels.last_mut() {
                    level.commas += 1;
                    level.key = None;
                }
            }
            PieceKind::Sign(':') if index > 0 => {
                let key = name(index - 1);
                if let (Some(level), Some(key)) = (self.levels.last_mut().filter(|level| level.bracket == '#'), key) {
                    level.keys.push(key.clone());
                    level.key = Some(key);
                }
            }
            _ => {}
        }
    }

    /// Text of a piece.
    pub fn slice(&self, index: usize) -> &'a str {
        &self.text[self.pieces[index].range.clone()]
    }

    /// The kind of a piece.
    pub fn kind(&self, index: usize) -> Option<PieceKind> {
        self.pieces.get(index).map(|piece| piece.kind)
    }

    /// Returns the start of the content of the string at the cursor.
    pub fn in_string(&self) -> Option<usize> {
        let last = self.pieces.last()?;
        (last.kind == PieceKind::Text { closed: false }).then_some(last.range.start + 1)
    }

    /// Returns the token with the name of the function whose call is open at a level.
    pub fn callee(&self, level: &Level) -> Option<usize> {
        let before = level.piece.checked_sub(1)?;
        (level.bracket == '(' && self.kind(before) == Some(PieceKind::Name)).then_some(before)
    }

    /// True if the token is a name behind a dot.
    pub fn is_member(&self, index: usize) -> bool {
        index > 0 && self.kind(index - 1) == Some(PieceKind::Dot)
    }

    /// Returns the name that ends at the cursor, with its start; empty in front of a name.
    pub fn word(&self) -> (usize, &'a str) {
        match self.pieces.last() {
            Some(last) if last.kind == PieceKind::Name && last.range.end == self.text.len() => {
                (last.range.start, &self.text[last.range.clone()])
            }
            _ => (self.text.len(), ""),
        }
    }

    /// Returns the index of the bracket that matches a closing one.
    pub fn opening(&self, close: usize) -> Option<usize> {
        let mut depth = 0usize;
        for index in (0..=close).rev() {
            match self.pieces[index].kind {
                PieceKind::Close(_) => depth += 1,
                PieceKind::Open(_) => {
                    depth -= 1;
                    if depth == 0 {
                        return Some(index);
                    }
                }
                _ => {}
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_innermost_call_and_its_keys_are_known() {
        let cursor = Cursor::new("let r = f(1, ring(#{ inner_radius: 1.5, \"cells\": [1, 2], outer");
        let brackets: String = cursor.levels.iter().map(|level| level.bracket).collect();
        assert_eq!(brackets, "((#");
        assert_eq!(cursor.levels[0].commas, 1);
        assert_eq!(cursor.callee(&cursor.levels[1]).map(|index| cursor.slice(index)), Some("ring"));
        assert_eq!((cursor.levels[2].keys.len(), &cursor.levels[2].key), (2, &None));
        assert_eq!(cursor.word().1, "outer");
        assert_eq!(Cursor::new("ring(#{ a: ").levels[1].key.as_deref(), Some("a"));
    }

    #[test]
    fn strings_and_comments_hide_brackets() {
        assert!(Cursor::new("f(\"a)\\\"(\", `)`").levels.len() == 1);
        assert_eq!(Cursor::new("b.boundary(\"in").in_string(), Some(12));
        assert!(Cursor::new("1 /* (").in_comment && Cursor::new("1 // (\n").levels.is_empty());
        assert!(Cursor::new("f(]").is_crossed && !Cursor::new("#{ a: [1..2, 3.5e3] }").is_crossed);
    }
}
