//! Context of the cursor in unfinished text: enclosing brackets, the call, the key, inside of a string or not.
//!
//! The engine's tokenizer stops at the first incomplete token, so unfinished input is split by a small scanner.

use std::ops::Range;

/// Kinds of tokens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextTokenKind {
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
pub struct TextToken {
    /// Kind of the token.
    pub kind: TextTokenKind,
    /// Byte range of the token in the text.
    pub range: Range<usize>,
}

/// Largest depth of nested interpolations that are split into tokens; deeper ones count as text.
const INTERPOLATIONS: usize = 4;

/// Splits a text into tokens; white space is left out.
pub fn pieces(text: &str) -> Vec<TextToken> {
    let (mut found, mut at) = (Vec::new(), 0);
    while let Some(piece) = piece_from(text, at, INTERPOLATIONS) {
        at = piece.range.end;
        found.push(piece);
    }
    found
}

/// Splits a text into tokens; the code of interpolations `${ … }` follows the token of its string.
pub fn pieces_with_interpolations(text: &str) -> Vec<TextToken> {
    let mut found = Vec::new();
    add_pieces(text, 0..text.len(), INTERPOLATIONS, &mut found);
    found
}

fn add_pieces(text: &str, range: Range<usize>, depth: usize, found: &mut Vec<TextToken>) {
    let mut at = range.start;
    while let Some(piece) = piece_from(&text[..range.end], at, depth) {
        at = piece.range.end;
        let is_interpolated = depth > 0 && text[piece.range.clone()].starts_with('`');
        let (mut from, content_end) = (piece.range.start, piece.range.end);
        found.push(piece);
        while is_interpolated && let Some(start) = text[from..content_end].find("${").map(|found| from + found + 1) {
            let end = block_end(&text[..content_end], start, depth - 1).unwrap_or(content_end);
            let brace = |kind, at: usize| TextToken { kind, range: at..at + 1 };
            found.push(brace(TextTokenKind::Open('{'), start));
            add_pieces(text, start + 1..end.max(start + 1), depth - 1, found);
            if end < content_end {
                found.push(brace(TextTokenKind::Close('}'), end));
            }
            from = (end + 1).min(content_end);
        }
    }
}

/// Returns the first token of a text from a byte on.
fn piece_from(text: &str, from: usize, depth: usize) -> Option<TextToken> {
    let at = from + text[from..].find(|letter: char| !letter.is_whitespace())?;
    let (rest, is_word) = (&text[at..], |letter: char| letter.is_alphanumeric() || letter == '_');
    let first = rest.chars().next()?;
    let until = |end: Option<usize>, length: usize| (end.map_or(rest.len(), |end| end + length), end.is_some());
    let (kind, length) = match first {
        '/' if rest.starts_with("//") => {
            let (length, closed) = until(rest.find('\n'), 0);
            (TextTokenKind::Comment { closed }, length)
        }
        '/' if rest.starts_with("/*") => {
            let (length, closed) = until(comment_end(rest), 0);
            (TextTokenKind::Comment { closed }, length)
        }
        '"' | '`' => {
            let (length, closed) = until(string_end(text, at, depth).map(|end| end - at), 1);
            (TextTokenKind::Text { closed }, length)
        }
        '\'' => match letter_length(rest) {
            Some(length) => (TextTokenKind::Text { closed: true }, length),
            None => (TextTokenKind::Sign(first), 1),
        },
        '#' if rest.starts_with("#{") => (TextTokenKind::Open('#'), 2),
        '(' | '[' | '{' => (TextTokenKind::Open(first), 1),
        ')' | ']' | '}' => (TextTokenKind::Close(first), 1),
        '?' if rest.starts_with("?.") => (TextTokenKind::Dot, 2),
        '.' if !rest.starts_with("..") => (TextTokenKind::Dot, 1),
        '.' => (TextTokenKind::Sign('.'), if rest.starts_with("..=") { 3 } else { 2 }),
        ':' if rest.starts_with("::") => (TextTokenKind::Path, 2),
        _ if first.is_ascii_digit() => {
            let fraction = |index: usize| rest[index + 1..].starts_with(|next: char| next.is_ascii_digit());
            let end = rest.char_indices().find(|&(index, letter)| !(is_word(letter) || letter == '.' && fraction(index)));
            (TextTokenKind::Number, end.map_or(rest.len(), |(index, _)| index))
        }
        _ if is_word(first) => (TextTokenKind::Name, rest.find(|letter| !is_word(letter)).unwrap_or(rest.len())),
        other => (TextTokenKind::Sign(other), other.len_utf8()),
    };
    Some(TextToken { kind, range: at..at + length })
}

/// Returns the byte after a comment `/* … */`, which may contain nested comments.
fn comment_end(text: &str) -> Option<usize> {
    let (mut depth, mut at) = (0usize, 0);
    loop {
        let next = at + text[at..].find(['/', '*'])?;
        let step = match text.as_bytes().get(next..next + 2)? {
            b"/*" => (depth + 1, 2),
            b"*/" => (depth - 1, 2),
            _ => (depth, 1),
        };
        (depth, at) = (step.0, next + step.1);
        if depth == 0 {
            return Some(at);
        }
    }
}

/// Returns the length of a character in single quotes at the beginning of a text.
fn letter_length(text: &str) -> Option<usize> {
    let inside = &text[1..];
    let length = match inside.strip_prefix('\\') {
        Some(escaped) => 1 + escaped[escaped.chars().next()?.len_utf8()..].find('\'')? + escaped.chars().next()?.len_utf8(),
        None => inside.chars().next().filter(|letter| *letter != '\n')?.len_utf8(),
    };
    // The longest escape is `\U` with eight digits.
    (length <= 10 && inside[length..].starts_with('\'')).then_some(length + 2)
}

/// Returns the position of the closing quote of the string that begins at a byte.
fn string_end(text: &str, start: usize, depth: usize) -> Option<usize> {
    let quote = text[start..].chars().next()?;
    let mut at = start + 1;
    while let Some(letter) = text[at..].chars().next() {
        at += match letter {
            _ if letter == quote => return Some(at),
            '\\' if quote == '"' => 1 + text[at + 1..].chars().next().map_or(0, char::len_utf8),
            '$' if quote == '`' && depth > 0 && text[at + 1..].starts_with('{') => block_end(text, at + 1, depth - 1)? + 1 - at,
            _ => letter.len_utf8(),
        };
    }
    None
}

/// Returns the position of the brace that closes the one at a byte.
fn block_end(text: &str, open: usize, depth: usize) -> Option<usize> {
    let (mut at, mut braces) = (open, 0usize);
    while let Some(piece) = piece_from(text, at, depth) {
        match piece.kind {
            TextTokenKind::Open('{' | '#') => braces += 1,
            TextTokenKind::Close('}') => braces -= 1,
            _ => {}
        }
        if braces == 0 {
            return Some(piece.range.start);
        }
        at = piece.range.end;
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
    /// Text in front of the cursor.
    pub text: &'a str,
    /// Tokens without comments.
    pub pieces: Vec<TextToken>,
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
        let in_comment = pieces.last().is_some_and(|last| matches!(last.kind, TextTokenKind::Comment { closed: false }));
        pieces.retain(|piece| !matches!(piece.kind, TextTokenKind::Comment { .. }));
        let mut cursor = Cursor { text, pieces, levels: Vec::new(), in_comment, is_crossed: false };
        for index in 0..cursor.pieces.len() {
            cursor.enter(index);
        }
        cursor
    }

    /// Cursor at the start of a text; [`Self::enter`] advances by tokens.
    pub fn at_start(text: &'a str) -> Self {
        let mut pieces = pieces(text);
        pieces.retain(|piece| !matches!(piece.kind, TextTokenKind::Comment { .. }));
        Cursor { text, pieces, levels: Vec::new(), in_comment: false, is_crossed: false }
    }

    /// Advances over a token and updates the open brackets.
    pub fn enter(&mut self, index: usize) {
        let name = |index: usize| match self.pieces.get(index).map(|piece| piece.kind) {
            Some(TextTokenKind::Name) => Some(self.slice(index).to_string()),
            Some(TextTokenKind::Text { closed: true }) => Some(self.slice(index).trim_matches('"').to_string()),
            _ => None,
        };
        match self.pieces[index].kind {
            TextTokenKind::Open(bracket) => self.levels.push(Level { bracket, piece: index, commas: 0, keys: Vec::new(), key: None }),
            TextTokenKind::Close(bracket) => {
                let expected = match self.levels.pop().map(|level| level.bracket) {
                    Some('(') => ')',
                    Some('[') => ']',
                    Some(_) => '}',
                    None => '\0',
                };
                self.is_crossed |= expected != bracket;
            }
            TextTokenKind::Sign(',') => {
                if let Some(level) = self.levels.last_mut() {
                    level.commas += 1;
                    level.key = None;
                }
            }
            TextTokenKind::Sign(':') if index > 0 => {
                let key = name(index - 1);
                if let (Some(level), Some(key)) = (self.levels.last_mut().filter(|level| level.bracket == '#'), key) {
                    level.keys.push(key.clone());
                    level.key = Some(key);
                }
            }
            _ => {}
        }
    }

    /// Text of a token.
    pub fn slice(&self, index: usize) -> &'a str {
        &self.text[self.pieces[index].range.clone()]
    }

    /// Kind of a token.
    pub fn kind(&self, index: usize) -> Option<TextTokenKind> {
        self.pieces.get(index).map(|piece| piece.kind)
    }

    /// Returns the start of the content of the string at the cursor.
    pub fn in_string(&self) -> Option<usize> {
        let last = self.pieces.last()?;
        (last.kind == TextTokenKind::Text { closed: false }).then_some(last.range.start + 1)
    }

    /// Returns the token with the name of the function whose call is open at a level.
    pub fn callee(&self, level: &Level) -> Option<usize> {
        let before = level.piece.checked_sub(1)?;
        (level.bracket == '(' && self.kind(before) == Some(TextTokenKind::Name)).then_some(before)
    }

    /// True if the token is a name behind a dot.
    pub fn is_member(&self, index: usize) -> bool {
        index > 0 && self.kind(index - 1) == Some(TextTokenKind::Dot)
    }

    /// Returns the name that ends at the cursor, with its start; empty in front of a name.
    pub fn word(&self) -> (usize, &'a str) {
        match self.pieces.last() {
            Some(last) if last.kind == TextTokenKind::Name && last.range.end == self.text.len() => {
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
                TextTokenKind::Close(_) => depth += 1,
                TextTokenKind::Open(_) => {
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
