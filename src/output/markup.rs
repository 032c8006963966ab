//! Texts in XML and HTML.

/// Escapes a text as the content of an element or attribute; characters that XML 1.0 does not allow become the replacement character.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            letter => out.push(permitted(letter)),
        }
    }
    out
}

/// A text inside a comment, on one line.
pub fn comment(text: &str) -> String {
    // Two hyphens, or a hyphen at the end, would end the comment.
    let text: String = text.chars().map(|letter| if letter.is_control() { permitted_in_line(letter) } else { permitted(letter) }).collect();
    text.replace("--", "\u{2013}")
}

fn permitted_in_line(letter: char) -> char {
    if letter.is_whitespace() { ' ' } else { char::REPLACEMENT_CHARACTER }
}

fn permitted(letter: char) -> char {
    let is_lost = letter.is_control() && !matches!(letter, '\n' | '\t') || matches!(letter, '\u{fffe}' | '\u{ffff}');
    if is_lost { char::REPLACEMENT_CHARACTER } else { letter }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_and_control_characters_are_replaced() {
        assert_eq!(escaped("a<b> & \"c\"\u{1b}[1m\n"), "a&lt;b&gt; &amp; &quot;c&quot;\u{fffd}[1m\n");
        assert_eq!(comment("a --> b\r\n\u{1}<x>"), "a \u{2013}> b  \u{fffd}<x>");
    }
}
