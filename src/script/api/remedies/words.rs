//! What has a remedy in the words of the language.

/// A refusal or a finding of the kernels.
pub trait ScriptWords {
    /// How to mend it in a script, one sentence.
    fn remedy(&self) -> String;
}
