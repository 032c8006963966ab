//! Numbers of a simulation as texts with their units, for the prompt and `print`.

use super::handle::{SimulationData, SimulationHandle};
use crate::output::{ModelUnits, pretty_unit};
use crate::script::language::digits::{brief, brief_vector};

/// Units for the numbers in a text; `None` if the script declares none.
#[derive(Clone)]
pub struct ScriptOutput(Option<ModelUnits>);

impl ScriptOutput {
    /// Units of a simulation.
    pub fn of(handle: &SimulationHandle) -> Self {
        ScriptOutput(handle.0.units.clone())
    }

    /// A number with the unit of its dimension.
    pub fn number(&self, value: f64, dimension: &str) -> String {
        self.with_unit(brief(value), dimension)
    }

    /// A vector with the unit of its dimension.
    pub fn vector(&self, values: &[f64], dimension: &str) -> String {
        self.with_unit(brief_vector(values), dimension)
    }

    /// A moment with its unit: in the plane its third component.
    pub fn moment(&self, moment: &[f64; 3], dimension: usize) -> String {
        if dimension == 2 { self.number(moment[2], "force * length") } else { self.vector(moment, "force * length") }
    }

    fn with_unit(&self, text: String, dimension: &str) -> String {
        match self.0.as_ref().map(|units| units.unit(dimension)).filter(|unit| !unit.is_empty()) {
            Some(unit) => format!("{text} {}", pretty_unit(&unit)),
            None => text,
        }
    }
}

/// Words that precede a number in sentences of the solver, which has no units, and the dimension of the number.
const NAMED: [(&str, &str); 9] = [
    ("t = ", "time"),
    ("dt = ", "time"),
    ("steps of ", "time"),
    ("in a step of ", "time"),
    ("stable step of ", "time"),
    ("a length of ", "length"),
    ("at rest at ", "length"),
    ("preload ", "force"),
    ("stiffness ", "force/length"),
];

impl SimulationData {
    /// Sentence of the solver with units appended to its times, lengths and forces, if the script declares units.
    pub fn with_units(&self, text: &str) -> String {
        let Some(units) = &self.units else { return text.to_string() };
        with_units(text, &|dimension| pretty_unit(&units.unit(dimension)))
    }
}

/// Sentence with a unit after each number that follows a word of [`NAMED`].
fn with_units(text: &str, unit: &dyn Fn(&str) -> String) -> String {
    let (mut told, mut rest) = (String::new(), text);
    while let Some((place, word, dimension)) = next_word(&told, rest) {
        let (before, number) = rest.split_at(place + word.len());
        let end = number_end(number);
        told.push_str(before);
        told.push_str(&number[..end]);
        let unit = unit(dimension);
        if end > 0 && !unit.is_empty() {
            told.push(' ');
            told.push_str(&unit);
        }
        rest = &number[end..];
    }
    told + rest
}

/// The first word of [`NAMED`] in `rest`, which follows `before`, at the beginning of a word.
fn next_word(before: &str, rest: &str) -> Option<(usize, &'static str, &'static str)> {
    let begins = |place: usize| {
        let last = if place == 0 { before.chars().last() } else { rest[..place].chars().last() };
        !last.is_some_and(char::is_alphanumeric)
    };
    let places = |word: &'static str| rest.match_indices(word).map(|(place, _)| place).find(|&place| begins(place));
    NAMED.iter().filter_map(|&(word, dimension)| Some((places(word)?, word, dimension))).min_by_key(|found| found.0)
}

/// Length of the number at the beginning of a text; 0 without one.
fn number_end(text: &str) -> usize {
    let end = text.find(|letter: char| !(letter.is_ascii_digit() || matches!(letter, '.' | '-' | '+' | 'e'))).unwrap_or(text.len());
    let number = text[..end].trim_end_matches(['.', 'e', '-', '+']);
    if number.parse::<f64>().is_ok() { number.len() } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::with_units;

    #[test]
    fn numbers_of_kernels_get_their_units() {
        let unit = |dimension: &str| if dimension == "time" { "ms".to_string() } else { "mm".to_string() };
        let told = |text: &str| with_units(text, &unit);
        assert_eq!(told("\"ball\" turns by 10 rad in a step of 0.1 at t = 0"), "\"ball\" turns by 10 rad in a step of 0.1 ms at t = 0 ms");
        assert_eq!(told("at t = 1.5e-3 (step 2, dt = 1e-4)."), "at t = 1.5e-3 ms (step 2, dt = 1e-4 ms).");
        assert_eq!(told("it ended at t = 0.5."), "it ended at t = 0.5 ms.");
        assert_eq!(told("sides lie 0.50 facets deep, a length of 0.02"), "sides lie 0.50 facets deep, a length of 0.02 mm");
        assert_eq!(told("take steps of half the size; t = none"), "take steps of half the size; t = none");
    }
}
