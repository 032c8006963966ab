//! Meaning of the stable codes of messages: the page `docs/errors.md`, in which every section explains one code.

use serde_json::{Value, json};

/// The page, which is compiled into the program.
const PAGE: &str = include_str!("../../../docs/errors.md");

/// Meaning, cause and remedy of a code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Explanation {
    /// Code, such as `C0123`.
    pub code: &'static str,
    /// Title of the code, a few words.
    pub title: &'static str,
    /// The explanation in Markdown.
    pub text: &'static str,
}

/// The explanations of all codes, in their order.
pub fn explanations() -> impl Iterator<Item = Explanation> {
    PAGE.split("\n### ").skip(1).filter_map(|section| {
        let section = section.split("\n## ").next()?;
        let (heading, text) = section.split_once('\n')?;
        let (code, title) = heading.split_once(": ")?;
        Some(Explanation { code, title, text: text.trim() })
    })
}

/// Returns the number of a code `C…`; `None` if the name is not a code.
fn number_of(name: &str) -> Option<i32> {
    name.strip_prefix(['C', 'c']).filter(|digits| digits.len() >= 2)?.parse().ok()
}

/// Returns the explanation of a code, or the nearest code if it has none. `None` if the name is not a code.
pub(super) fn explanation(name: &str) -> Option<Result<Explanation, String>> {
    let number = number_of(name)?;
    let distance = |known: &Explanation| number_of(known.code).map_or(u32::MAX, |known| known.abs_diff(number));
    let nearest = explanations().min_by_key(distance)?;
    Some(if distance(&nearest) == 0 { Ok(nearest) } else { Err(nearest.code.into()) })
}

impl Explanation {
    /// The explanation for a terminal.
    pub(super) fn terminal(&self) -> String {
        let lines: Vec<String> = self.text.lines().filter(|line| !line.starts_with("```")).map(|line| format!("  {line}")).collect();
        let lines: Vec<&str> = lines.iter().map(|line| line.trim_end()).collect();
        format!("{}: {}\n{}", self.code, self.title, lines.join("\n"))
    }

    /// Returns the explanation as a section of the page.
    pub(super) fn markdown(&self) -> String {
        format!("### {}: {}\n\n{}\n", self.code, self.title, self.text)
    }

    /// The explanation for programs.
    pub(super) fn json(&self) -> Value {
        json!({ "name": self.code, "form": "code", "title": self.title, "text": self.text })
    }
}
