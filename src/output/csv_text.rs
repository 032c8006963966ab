//! Texts as fields of CSV files (RFC 4180), and back.
//!
//! Spreadsheets evaluate text that looks like a formula, so that a name could run a command. A text that begins with `=`, `+`, `-`, `@`, or
//! with white space before one of them, is preceded by an apostrophe, which spreadsheets do not show; numbers are unchanged.

use std::borrow::Cow;

/// Characters with which formulas begin, and white space that programs skip before a formula.
const FORMULA: [char; 6] = ['=', '+', '-', '@', '\t', '\r'];
/// Prefix that marks a text which looks like a formula as text.
const MARK: char = '\'';

fn is_formula(text: &str) -> bool {
    text.trim_start_matches(MARK).starts_with(FORMULA)
}

/// Returns a text that spreadsheets do not interpret as a formula.
pub fn harmless(text: &str) -> Cow<'_, str> {
    if is_formula(text) && text.parse::<f64>().is_err() { format!("{MARK}{text}").into() } else { text.into() }
}

/// Inverse of `harmless`.
pub fn meant(field: &str) -> &str {
    field.strip_prefix(MARK).filter(|text| is_formula(text)).unwrap_or(field)
}

/// Returns a CSV field, quoted where necessary.
pub fn field(text: &str) -> String {
    let text = harmless(text);
    let needs_quotes = text.contains([',', '"', '\n', '\r', ';', '\t', '#']) || text.trim() != text;
    if needs_quotes { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into_owned() }
}

/// Returns a CSV line. A single field of a line is quoted if it is empty or contains blanks.
pub fn line<S: AsRef<str>>(fields: &[S]) -> Vec<u8> {
    let text = match fields {
        [only] if only.as_ref().is_empty() || only.as_ref().contains(char::is_whitespace) => {
            format!("\"{}\"", harmless(only.as_ref()).replace('"', "\"\""))
        }
        fields => fields.iter().map(|text| field(text.as_ref())).collect::<Vec<_>>().join(","),
    };
    (text + "\n").into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_text_is_a_formula_and_every_text_comes_back() {
        let texts =
            ["=1+1", "+x", "-cmd|' /c calc'!A0", "@SUM(A1)", "\t=1", "\r=1", "'=1", "''-x", "it's", "'quoted'", "", "a=b", "−1", " =1"];
        for text in texts {
            let written = harmless(text);
            assert!(!written.starts_with(FORMULA), "{text}");
            assert_eq!(meant(&written), text);
        }
        for number in ["-1.5", "+3", "1e-3", "-inf", "NaN"] {
            assert_eq!(field(number), number);
        }
        assert_eq!(field("=HYPERLINK(\"x\", 1)"), "\"'=HYPERLINK(\"\"x\"\", 1)\"");
        assert_eq!(line(&["two words"]), b"\"two words\"\n");
        assert_eq!(line(&["two words", "#1"]), b"two words,\"#1\"\n");
        assert_eq!(line(&[""]), b"\"\"\n");
    }
}
