//! Hints of the solver's refusals and findings in terms of the language.

/// A refusal or a finding of the solver.
pub trait ScriptWords {
    /// Returns a hint for scripts, one sentence.
    fn remedy(&self) -> String;
}
