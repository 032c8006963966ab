//! What a script function fails with: everything a message needs except its place, which the engine adds.
//!
//! A failure travels through the engine as the payload of a run-time error, so that the engine fills in the position of the call and
//! the chain of script functions around it; the diagnostics unpack it at the end. Failures that a script must not catch (an interrupt,
//! the end of a check) travel as terminations.

use std::ops::Deref;
use std::rc::Rc;

use rhai::{Dynamic, EvalAltResult, Position};

use super::registry::Handle;
use super::scan::Target;
use super::sources::Place;

/// What kind of failure it is; decides the exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Class {
    /// A check of the script does not hold.
    Check,
    /// The script (or a file it reads, or an argument) is wrong.
    Script,
    /// The script is right, but the computation failed.
    Numerics,
    /// The user interrupted the run.
    Interrupted,
    /// `conserva check` came to the first use of a result.
    ResultUsed,
    /// A defect of the program itself.
    Internal,
}

/// An error raised by script code that the solver called, on its way through the kernels.
#[derive(Clone, Debug)]
pub struct ScriptError {
    /// The error as the engine gave it.
    pub error: Rc<EvalAltResult>,
    /// Source in which the outermost of its positions lies.
    pub source: String,
}

impl std::fmt::Display for ScriptError {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "{}", self.error)
    }
}

impl std::error::Error for ScriptError {}

/// The parts of a message.
#[derive(Clone, Debug)]
pub struct Details {
    /// Kind of failure.
    pub class: Class,
    /// What is wrong, one sentence.
    pub title: String,
    /// What the message points at within the call.
    pub target: Target,
    /// Whether the called function is a method.
    pub method: bool,
    /// A few words at the place itself.
    pub label: String,
    /// The numbers that show it.
    pub causes: Vec<String>,
    /// How to mend it.
    pub hints: Vec<String>,
    /// The error in script code that led to this one.
    pub inner: Option<ScriptError>,
    /// Where it happened, when that is known better than from the position the engine keeps.
    pub origin: Option<Place>,
}

/// A failure of a script function.
#[derive(Clone, Debug)]
pub struct Failure(Box<Details>);

impl Deref for Failure {
    type Target = Details;
    fn deref(&self) -> &Details {
        &self.0
    }
}

impl Failure {
    /// A failure of some class with its title.
    pub fn new(class: Class, title: impl Into<String>) -> Self {
        Failure(Box::new(Details {
            class,
            title: title.into(),
            target: Target::Call,
            method: false,
            label: String::new(),
            causes: Vec::new(),
            hints: Vec::new(),
            inner: None,
            origin: None,
        }))
    }

    /// The script is wrong.
    pub fn script(title: impl Into<String>) -> Self {
        Failure::new(Class::Script, title)
    }

    /// The same, pointing at a part of the call.
    pub fn at(mut self, target: Target) -> Self {
        self.0.target = target;
        self
    }

    /// The same, with a few words at the place.
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.0.label = label.into();
        self
    }

    /// The same with one more cause.
    pub fn cause(mut self, cause: impl Into<String>) -> Self {
        self.0.causes.push(cause.into());
        self
    }

    /// The same with one more hint.
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.0.hints.push(hint.into());
        self
    }

    /// The same, caused by an error in script code.
    pub fn caused_by(mut self, inner: ScriptError) -> Self {
        self.0.inner = Some(inner);
        self
    }

    /// The same, with a place that the engine must not choose.
    pub fn placed(mut self, place: Option<Place>) -> Self {
        self.0.origin = place;
        self
    }

    /// The same, raised in a method.
    pub fn in_method(mut self, method: bool) -> Self {
        self.0.method = method;
        self
    }

    /// The engine's error at a position.
    pub fn raise(self, position: Position) -> Box<EvalAltResult> {
        let catchable = matches!(self.class, Class::Check | Class::Script | Class::Numerics);
        let payload = Dynamic::from(self);
        Box::new(if catchable { EvalAltResult::ErrorRuntime(payload, position) } else { EvalAltResult::ErrorTerminated(payload, position) })
    }
}

impl Handle for Failure {
    const NAME: &'static str = "Error";

    fn describe(&self) -> String {
        let inner = self.inner.as_ref().map(|inner| inner.to_string()).unwrap_or_default();
        [self.title.as_str(), &inner]
            .into_iter()
            .chain(self.causes.iter().map(String::as_str))
            .filter(|part| !part.is_empty())
            .collect::<Vec<_>>()
            .join("; ")
    }
}

impl From<Failure> for Box<EvalAltResult> {
    fn from(failure: Failure) -> Self {
        failure.raise(Position::NONE)
    }
}

/// The names in `candidates` that `name` may have been meant to be, nearest first.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let lower = name.to_lowercase();
    let mut scored: Vec<(f64, &str)> = candidates
        .into_iter()
        .filter(|candidate| *candidate != name)
        .map(|candidate| {
            let other = candidate.to_lowercase();
            let similarity = strsim::jaro_winkler(&lower, &other);
            let distance = strsim::damerau_levenshtein(&lower, &other);
            let close = distance <= 1 + lower.chars().count().min(other.chars().count()) / 4;
            let (short, long) = (lower.len().min(other.len()), lower.len().max(other.len()));
            let inside = short >= 3 && 2 * short >= long && (other.contains(&lower) || lower.contains(&other));
            // `half_plane` for `rigid_plane`
            let shares_a_word = lower.split('_').any(|word| word.len() >= 4 && other.split('_').any(|own| own == word));
            let score = match (close, inside || shares_a_word) {
                (true, _) => 1.0 + similarity,
                (false, true) => 0.9 + 0.05 * similarity,
                (false, false) => similarity,
            };
            (score, candidate)
        })
        .filter(|(score, _)| *score >= 0.88)
        .collect();
    scored.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(b.1)));
    scored.dedup_by(|a, b| a.1 == b.1);
    let best = scored.first().map_or(0.0, |(score, _)| *score);
    scored.into_iter().filter(|(score, _)| *score > best - 0.3).take(3).map(|(_, candidate)| candidate).collect()
}

/// ``did you mean `a` or `b`?``, or nothing when no name is near.
pub fn did_you_mean<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let near = nearest(name, candidates);
    (!near.is_empty()).then(|| format!("did you mean {}?", listed(&near, "or")))
}

/// `` `a`, `b` and `c` ``.
pub fn listed<S: AsRef<str>>(names: &[S], joint: &str) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{}`", name.as_ref())).collect();
    joined(&quoted, joint)
}

/// `a, b and c`.
pub fn joined<S: AsRef<str>>(words: &[S], joint: &str) -> String {
    match words {
        [] => String::new(),
        [only] => only.as_ref().to_string(),
        [first @ .., last] => {
            format!("{} {joint} {}", first.iter().map(AsRef::as_ref).collect::<Vec<_>>().join(", "), last.as_ref())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_names_are_found_and_far_ones_are_not() {
        let names = ["inner_radius", "outer_radius", "cells", "center", "start_angle"];
        assert_eq!(nearest("outter_radius", names)[0], "outer_radius");
        assert_eq!(nearest("radius", names), ["inner_radius", "outer_radius"]);
        assert_eq!(nearest("Cells", names)[0], "cells");
        assert!(nearest("velocity", names).is_empty());
        assert_eq!(did_you_mean("cell", names).unwrap(), "did you mean `cells`?");
    }

    #[test]
    fn lists_read_like_sentences() {
        assert_eq!(listed(&["a"], "and"), "`a`");
        assert_eq!(listed(&["a", "b", "c"], "and"), "`a`, `b` and `c`");
    }
}
