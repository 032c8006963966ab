//! What the stable codes of messages mean: the page `docs/errors.md`, of which every section explains one code.

use serde_json::{Value, json};

/// The page, which is part of the program.
const PAGE: &str = include_str!("../../../docs/errors.md");

/// What a code means, why it comes and how it is mended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Explanation {
    /// The code, such as `C0123`.
    pub code: &'static str,
    /// What it stands for, a few words.
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

/// Whether a name is written as a code is.
fn number_of(name: &str) -> Option<i32> {
    name.strip_prefix(['C', 'c']).filter(|digits| digits.len() >= 2)?.parse().ok()
}

/// The explanation of a code; the nearest code, where it has none. `None` of a name that is no code.
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

    /// The explanation as its section of the page.
    pub(super) fn markdown(&self) -> String {
        format!("### {}: {}\n\n{}\n", self.code, self.title, self.text)
    }

    /// The explanation for programs.
    pub(super) fn json(&self) -> Value {
        json!({ "name": self.code, "form": "code", "title": self.title, "text": self.text })
    }
}
