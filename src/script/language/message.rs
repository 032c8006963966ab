//! Messages as plain data for storage: a [`Diagnostic`] whose place is a source name and a range of bytes instead of the whole text.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::diagnostics::{Diagnostic, Severity};
use super::failure::{Class, Failure};
use super::sources::{SourceSpan, Sources};

/// A message without the chain of calls around it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Message {
    /// Kind of failure.
    pub class: Class,
    /// True for a warning, after which the script continues.
    is_warning: bool,
    code: String,
    title: String,
    label: String,
    causes: Vec<String>,
    hints: Vec<String>,
    place: Option<(String, Range<usize>)>,
}

impl Message {
    /// Returns the message of a diagnostic.
    pub fn of(diagnostic: &Diagnostic) -> Self {
        Message {
            class: diagnostic.class,
            is_warning: diagnostic.severity == Severity::Warning,
            code: diagnostic.code.clone(),
            title: diagnostic.title.clone(),
            label: diagnostic.label.clone(),
            causes: diagnostic.causes.clone(),
            hints: diagnostic.hints.clone(),
            place: diagnostic.place.as_ref().map(|place| (place.source.clone(), place.range.clone())),
        }
    }

    fn place(&self, sources: &Sources) -> Option<SourceSpan> {
        let (source, range) = self.place.clone()?;
        let text = sources.text(&source).or_else(|| sources.appended(&source))?;
        (range.end <= text.len()).then_some(SourceSpan { source, text, range })
    }

    /// Returns the diagnostic; without a place if its text is not known.
    pub fn diagnostic(&self, sources: &Sources) -> Diagnostic {
        let severity = if self.is_warning { Severity::Warning } else { Severity::Error };
        let place = self.place(sources);
        let (code, label, causes, hints) = (self.code.clone(), self.label.clone(), self.causes.clone(), self.hints.clone());
        Diagnostic { severity, code, place, label, causes, hints, ..Diagnostic::error(self.class, self.title.clone()) }
    }

    /// Returns the failure with the texts of the message.
    pub fn failure(&self, sources: &Sources) -> Failure {
        let failure = self.failure_of(|title| Failure::new(self.class, title));
        if self.place.is_some() { failure.placed(self.place(sources)) } else { failure }
    }

    /// Returns a failure with the texts of the message; `begin` makes the failure from its title.
    pub fn failure_of(&self, begin: impl FnOnce(String) -> Failure) -> Failure {
        let failure = begin(self.title.clone()).code(self.code.clone()).label(self.label.clone());
        let failure = self.causes.iter().fold(failure, |failure, cause| failure.cause(cause.clone()));
        self.hints.iter().fold(failure, |failure, hint| failure.hint(hint.clone()))
    }

    /// Returns the message in one line: fault, numbers, and the line in its file.
    pub fn line(&self, sources: &Sources) -> String {
        let file = |place: SourceSpan| {
            let line = place.line_column().0;
            format!(" ({}:{line})", place.source.rsplit(['/', '\\']).next().unwrap_or_default())
        };
        let parts: Vec<&str> = std::iter::once(&self.title).chain(&self.causes).map(String::as_str).collect();
        format!("{}{}", parts.join("; "), self.place(sources).map(file).unwrap_or_default())
    }
}
