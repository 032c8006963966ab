//! Error of the text of an energy: place, cause and hint.

use std::ops::Range;

/// A mistake in the text of an energy.
#[derive(Clone, Debug, PartialEq)]
pub struct EnergyError {
    /// Text of the energy that contains the error.
    pub text: Box<str>,
    /// Bytes of the text at which the error was found.
    pub span: Range<usize>,
    /// Statement of the error, one sentence.
    pub title: String,
    /// A few words at the place.
    pub label: String,
    /// Evidence of the error; may be empty.
    pub cause: Box<str>,
    /// Hint on mending the text.
    pub hint: Box<str>,
}

impl EnergyError {
    /// Returns the stable code of the error, which `conserva doc` explains.
    pub fn code(&self) -> &'static str {
        "C0304"
    }

    pub(super) fn new(text: &str, span: Range<usize>, title: impl Into<String>, label: impl Into<String>) -> Self {
        EnergyError { text: text.into(), span, title: title.into(), label: label.into(), cause: "".into(), hint: "".into() }
    }

    pub(super) fn cause(self, cause: impl Into<String>) -> Self {
        EnergyError { cause: cause.into().into(), ..self }
    }

    pub(super) fn hint(self, hint: impl Into<String>) -> Self {
        EnergyError { hint: hint.into().into(), ..self }
    }
}

impl std::fmt::Display for EnergyError {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "{} in `{}`", self.title, self.text)
    }
}

impl std::error::Error for EnergyError {}
