//! Tables of words for the terminal.

use std::borrow::Cow;

/// Returns a text of a file for display on a terminal, with control characters escaped (cursor, colors, text direction).
pub fn visible(text: &str) -> Cow<'_, str> {
    let is_hidden = |letter: char| letter.is_control() || matches!(letter, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    if !text.contains(is_hidden) {
        return text.into();
    }
    let shown = |letter: char| if is_hidden(letter) { letter.escape_default().to_string() } else { letter.to_string() };
    text.chars().map(shown).collect::<String>().into()
}

/// Returns lines with aligned columns, numbers to the right, words to the left. The first row is the header.
pub fn aligned(rows: &[Vec<String>]) -> Vec<String> {
    let rows: Vec<Vec<Cow<'_, str>>> = rows.iter().map(|row| row.iter().map(|word| visible(word)).collect()).collect();
    let count = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| rows.iter().filter_map(|row| row.get(column)).map(|word| word.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..count).map(width).collect();
    let is_number = |word: &Cow<'_, str>| word.is_empty() || word == "-" || word.parse::<f64>().is_ok();
    let right: Vec<bool> = (0..count).map(|column| rows.iter().skip(1).filter_map(|row| row.get(column)).all(is_number)).collect();
    let line = |row: &Vec<Cow<'_, str>>| {
        let word = |(column, word): (usize, &Cow<'_, str>)| match right[column] {
            true => format!("{word:>width$}", width = widths[column]),
            false => format!("{word:<width$}", width = widths[column]),
        };
        row.iter().enumerate().map(word).collect::<Vec<_>>().join("  ").trim_end().to_string()
    };
    rows.iter().map(line).collect()
}

/// Formats a number with few digits: `0.1`, `1.25e-9`.
pub fn short(value: f64) -> String {
    let exponent = value.abs().log10().floor();
    if value == 0.0 {
        "0".into()
    } else if (-3.0..6.0).contains(&exponent) {
        let digits = (5.0 - exponent).max(0.0) as usize;
        let text = format!("{value:.digits$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
    } else {
        format!("{value:.2e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_to_the_right() {
        let rows = [["run", "steps"], ["a", "5"], ["bearing", "400"]].map(|row| row.map(String::from).to_vec());
        assert_eq!(aligned(&rows), ["run      steps", "a            5", "bearing    400"]);
    }

    #[test]
    fn what_a_terminal_would_obey_is_written_out() {
        assert_eq!(visible("a\u{1b}[31mb\u{202e}c\n"), "a\\u{1b}[31mb\\u{202e}c\\n");
        assert_eq!(aligned(&[vec!["\u{7}".into(), "x".into()]]), ["\\u{7}  x"]);
        assert!(matches!(visible("größe √2"), Cow::Borrowed(_)));
    }

    #[test]
    fn few_digits() {
        assert_eq!(
            [0.0, 0.1, 1234.5678, 400.0, 1.25e-9, -0.005, 1e7].map(short),
            ["0", "0.1", "1234.57", "400", "1.25e-9", "-0.005", "1.00e7"]
        );
    }
}
