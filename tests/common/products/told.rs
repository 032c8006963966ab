//! Parser of the values that a script prints at its end.

/// Lines that begin with a word, without the word.
pub fn lines<'a>(printed: &'a [String], word: &str) -> Vec<&'a str> {
    let rest = |line: &'a String| line.strip_prefix('@')?.strip_prefix(word)?.strip_prefix(' ');
    printed.iter().filter_map(rest).collect()
}

/// All numbers of a text, in their order; `()`, `true` and similar words are left out.
pub fn numbers(text: &str) -> Vec<f64> {
    text.split(['[', ']', ',', ' ']).filter(|word| !word.is_empty()).filter_map(|word| word.parse().ok()).collect()
}

/// The numbers of the first line that begins with a word.
pub fn first(printed: &[String], word: &str) -> Vec<f64> {
    lines(printed, word).first().map(|text| numbers(text)).unwrap_or_default()
}
