//! Hints of the kernels' refusals and findings in terms of the language.

/// A refusal or a finding of the kernels.
pub trait ScriptWords {
    /// Returns a hint for scripts, one sentence.
    fn remedy(&self) -> String;
}
