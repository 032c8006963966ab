//! Layout of a script text: indentation by open brackets, no white space at ends of lines, one line break at the end.
//!
//! Text inside of lines does not change, nor do lines that begin inside of a string or a comment.

use super::cursor::{TextTokenKind, pieces};

/// Columns per open bracket.
const WIDTH: usize = 4;

/// Returns a text with its lines indented.
pub fn formatted(text: &str) -> String {
    let pieces = pieces(text);
    let (mut depths, mut next): (Vec<usize>, usize) = (Vec::new(), 0);
    let (mut result, mut at) = (String::with_capacity(text.len()), 0);
    // Kind of the last token before the line.
    let mut last = None;
    for (number, line) in text.split_inclusive('\n').enumerate() {
        let end = at + line.len();
        let is_inside = next > 0 && pieces[next - 1].range.end > at;
        let content = line.trim();
        let first = pieces.get(next).filter(|piece| piece.range.start < end).map(|piece| piece.kind);
        if is_inside {
            // A line that begins inside of a string or comment does not change.
            result += line.trim_end_matches('\n');
        } else if !content.is_empty() {
            let is_closing = |letter: &char| matches!(letter, ')' | ']' | '}');
            let closing = content.chars().take_while(|letter| is_closing(letter) || *letter == ' ').filter(is_closing).count();
            let mut levels: Vec<usize> = depths.clone();
            let closed = levels.split_off(levels.len().saturating_sub(closing));
            // A closing bracket is aligned with the line of the opening one, which may have opened more.
            levels.retain(|opened| closed.first() != Some(opened));
            // Brackets that were opened in one line indent once.
            levels.dedup();
            let is_continued = closing == 0 && continues(last, first);
            result.extend(std::iter::repeat_n(' ', WIDTH * (levels.len() + usize::from(is_continued))));
            // White space at the end of a line may belong to a string.
            let begun = pieces[next..].iter().take_while(|piece| piece.range.start < end).last();
            let is_open = begun.is_some_and(|piece| piece.range.end >= end);
            result += if is_open { line.trim_start().trim_end_matches('\n') } else { content };
        }
        result.push('\n');
        while let Some(piece) = pieces.get(next).filter(|piece| piece.range.start < end) {
            match piece.kind {
                TextTokenKind::Open(_) => depths.push(number),
                TextTokenKind::Close(_) => drop(depths.pop()),
                _ => {}
            }
            if !matches!(piece.kind, TextTokenKind::Comment { .. }) {
                last = Some(piece.kind);
            }
            next += 1;
        }
        at = end;
    }
    // The text after an unclosed quote is part of the string.
    if pieces
        .last()
        .is_some_and(|last| matches!(last.kind, TextTokenKind::Text { closed: false } | TextTokenKind::Comment { closed: false }))
    {
        return text.to_string();
    }
    let kept = result.trim_end().len();
    result.truncate(kept);
    if !result.is_empty() {
        result.push('\n');
    }
    result
}

/// True if a statement continues in a line, judged from the last token before it and its first token.
fn continues(last: Option<TextTokenKind>, first: Option<TextTokenKind>) -> bool {
    let is_open = !matches!(last, None | Some(TextTokenKind::Sign(';' | ',') | TextTokenKind::Open(_) | TextTokenKind::Close('}')));
    let is_operator = matches!(first, Some(TextTokenKind::Dot)) || matches!(first, Some(TextTokenKind::Sign(sign)) if sign != ';');
    matches!(last, Some(TextTokenKind::Sign(sign)) if !matches!(sign, ';' | ',' | '|')) || is_open && is_operator
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_and_brackets_indent() {
        let text = "fn f(x) {\nlet a = g(#{\na: 1,\n  b: [1,\n2],\n});\n   if x {\n1\n} else {\n2 }\n}  \n\n\n";
        let expected = "fn f(x) {\n    let a = g(#{\n        a: 1,\n        b: [1,\n            2],\n    });\n    \
                        if x {\n        1\n    } else {\n        2 }\n}\n";
        assert_eq!(formatted(text), expected);
        assert_eq!(formatted(expected), expected);
    }

    #[test]
    fn strings_and_comments_stay() {
        let text = "let a = `x\n  y ${1}\n`;\n/* a\n   b */\nlet b = 1   // c\n+ 2;\n";
        assert_eq!(formatted(text), "let a = `x\n  y ${1}\n`;\n/* a\n   b */\nlet b = 1   // c\n    + 2;\n");
        assert_eq!(formatted("let a = `x\n y"), "let a = `x\n y");
        assert_eq!(formatted(""), "");
    }
}
