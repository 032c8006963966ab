//! Conversion of messages of the language to those of the protocol.

use std::time::Duration;

use super::positions::range_of;
use super::protocol::{self, Range};
use crate::script::{Diagnostic, Document, Severity, SourceSpan};

/// Severities of the protocol.
const ERROR: u8 = 1;
const WARNING: u8 = 2;
const INFORMATION: u8 = 3;
const HINT: u8 = 4;

/// Converts a message about a text: fault, causes and hints. Errors in a module are placed at its import or call.
pub fn published(document: &Document, finding: &Diagnostic) -> protocol::Diagnostic {
    let own = |place: &&SourceSpan| document.is_own(place);
    let frames = finding.frames.iter().filter_map(|frame| frame.place.as_ref());
    let place = finding.place.as_ref().filter(own).or_else(|| frames.into_iter().find(own));
    let elsewhere = finding.place.iter().filter(|place| !document.is_own(place)).map(|place| format!("at {place}"));
    let label = Some(finding.label.clone()).filter(|label| !label.is_empty());
    let lines = std::iter::once(finding.title.clone()).chain(elsewhere).chain(label).chain(finding.causes.iter().cloned());
    let lines: Vec<String> = lines.chain(finding.hints.iter().map(|hint| format!("hint: {hint}"))).collect();
    let severity = match finding.severity {
        Severity::Error => ERROR,
        Severity::Warning => WARNING,
    };
    let code = Some(finding.code.clone()).filter(|code| !code.is_empty());
    let range = place.map(|place| range_of(&place.text, &place.range)).unwrap_or_default();
    diagnostic(range, severity, code, lines.join("\n"))
}

fn diagnostic(range: Range, severity: u8, code: Option<String>, message: String) -> protocol::Diagnostic {
    protocol::Diagnostic { range, severity, code, source: "conserva", message }
}

/// Note at the first use of a result, after which only names are checked.
pub fn stopped_note(document: &Document, place: &SourceSpan) -> protocol::Diagnostic {
    let range = if document.is_own(place) { range_of(&place.text, &place.range) } else { Range::default() };
    let text = "a result is used here; what follows depends on it and is checked by a run only".into();
    diagnostic(range, HINT, None, text)
}

/// Note of a check that was stopped.
pub fn too_long_note(patience: Duration) -> protocol::Diagnostic {
    let text = format!("the check was stopped after {} s; `conserva check` takes the time that is needed", patience.as_secs());
    diagnostic(Range::default(), INFORMATION, None, text)
}
