//! Messages for the user: fault, place, relevant numbers, hints.
//!
//! A diagnostic is plain data and can be sent to other threads; `annotate-snippets` renders it. The conversion of engine errors into
//! diagnostics is in `explain/`.

use annotate_snippets::renderer::DecorStyle;
use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet, normalize_untrusted_str};

use super::failure::Class;
use super::sources::SourceSpan;

/// Severity of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The run ends.
    Error,
    /// Warning; the run continues.
    Warning,
}

/// One link of the chain of calls around an error.
#[derive(Clone, Debug)]
pub struct CallFrame {
    /// Description of the call, such as ``in the call of `broken` ``.
    pub title: String,
    /// Place of the call.
    pub place: Option<SourceSpan>,
}

/// A message.
#[derive(Clone, Debug)]
pub struct Diagnostic {
    /// Error or warning.
    pub severity: Severity,
    /// Kind of failure.
    pub class: Class,
    /// Stable code of the message, such as `C0123`; empty without a code.
    pub code: String,
    /// Description of the fault, one sentence.
    pub title: String,
    /// Place of the fault.
    pub place: Option<SourceSpan>,
    /// A few words at the place.
    pub label: String,
    /// Numbers and causes that explain the fault.
    pub causes: Vec<String>,
    /// Hints how to mend the fault.
    pub hints: Vec<String>,
    /// The chain of calls, innermost first.
    pub frames: Vec<CallFrame>,
}

/// Rendering of a diagnostic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ink {
    /// Without escape codes.
    Plain,
    /// With the colors of a terminal.
    Colored,
}

/// Largest number of frames shown; a deep recursion repeats itself.
const FRAMES: usize = 6;

impl Diagnostic {
    /// An error without a place.
    pub fn error(class: Class, title: impl Into<String>) -> Self {
        Diagnostic {
            severity: Severity::Error,
            class,
            code: String::new(),
            title: title.into(),
            place: None,
            label: String::new(),
            causes: Vec::new(),
            hints: Vec::new(),
            frames: Vec::new(),
        }
    }

    /// A warning at a place.
    pub fn warning(title: impl Into<String>, place: Option<SourceSpan>) -> Self {
        Diagnostic { severity: Severity::Warning, place, ..Diagnostic::error(Class::Script, title) }
    }

    /// Returns the diagnostic with a stable code.
    pub fn code(mut self, code: impl Into<String>) -> Self {
        self.code = code.into();
        self
    }

    /// Returns the diagnostic with one more cause.
    pub fn cause(mut self, cause: impl Into<String>) -> Self {
        self.causes.push(cause.into());
        self
    }

    /// Returns the diagnostic with one more hint.
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hints.push(hint.into());
        self
    }

    /// Returns the diagnostic with a short text at the place.
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.label = label.into();
        self
    }

    /// True if a part of the message contains `text`.
    pub fn contains(&self, text: &str) -> bool {
        [&self.code, &self.title, &self.label].into_iter().chain(&self.causes).chain(&self.hints).any(|part| part.contains(text))
    }

    /// Renders the message, with a newline at its end.
    pub fn render(&self, ink: Ink) -> String {
        let title = normalize_untrusted_str(&self.title);
        let notes: Vec<(&str, String)> = self
            .causes
            .iter()
            .map(|cause| ("cause", normalize_untrusted_str(cause)))
            .chain(self.hints.iter().map(|hint| ("hint", normalize_untrusted_str(hint))))
            .collect();
        let level = match self.severity {
            Severity::Error => Level::ERROR,
            Severity::Warning => Level::WARNING,
        };
        let title = level.primary_title(title.as_str());
        let mut group = Group::with_title(if self.code.is_empty() { title } else { title.id(self.code.as_str()) });
        if let Some(place) = &self.place {
            group = group.element(snippet(place, &self.label, AnnotationKind::Primary));
        }
        for (name, text) in &notes {
            let level = if *name == "hint" { Level::HELP } else { Level::NOTE };
            group = group.element(level.with_name(*name).message(text.as_str()));
        }
        let mut report = vec![group];
        for frame in self.frames.iter().take(FRAMES) {
            let mut group = Group::with_title(Level::NOTE.no_name().secondary_title(frame.title.as_str()));
            if let Some(place) = &frame.place {
                group = group.element(snippet(place, "", AnnotationKind::Primary));
            }
            report.push(group);
        }
        let left_out = self.frames.len().saturating_sub(FRAMES);
        let more = format!("… and {left_out} more calls around it");
        if left_out > 0 {
            report.push(Group::with_title(Level::NOTE.secondary_title(more.as_str())));
        }
        let renderer = match ink {
            Ink::Plain => Renderer::plain(),
            Ink::Colored => Renderer::styled(),
        };
        let mut drawn = renderer.decor_style(DecorStyle::Ascii).render(&report);
        drawn.push('\n');
        drawn
    }
}

/// The message of a panic, which is a defect of the program.
pub fn defect(panic: &(dyn std::any::Any + Send)) -> Box<Diagnostic> {
    let what = panic.downcast_ref::<String>().cloned().or_else(|| panic.downcast_ref::<&str>().map(ToString::to_string));
    let error = Diagnostic::error(Class::Internal, "the program has a defect and had to stop")
        .cause(what.unwrap_or_else(|| "unknown".into()))
        .code(Class::Internal.usual_code())
        .hint("please report it together with the script; results up to the last accepted step are kept");
    Box::new(error)
}

fn snippet<'a>(place: &'a SourceSpan, label: &'a str, kind: AnnotationKind) -> Snippet<'a, annotate_snippets::Annotation<'a>> {
    let annotation = kind.span(place.range.clone());
    let annotation = if label.is_empty() { annotation } else { annotation.label(label) };
    Snippet::source(&*place.text).path(place.source.as_str()).annotation(annotation)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(text: &str, found: &str) -> SourceSpan {
        let start = text.find(found).unwrap();
        SourceSpan { source: "a.rhai".into(), text: text.into(), range: start..start + found.len() }
    }

    #[test]
    fn the_four_parts_and_the_chain_are_drawn() {
        let text = "let a = 1;\nlet r = ring(#{ innner: 1 });\n";
        let mut diagnostic =
            Diagnostic::error(Class::Script, "`ring` has no option `innner`").cause("its options are …").hint("did you mean …?");
        diagnostic.place = Some(place(text, "innner"));
        diagnostic.label = "unknown".into();
        diagnostic.frames = vec![CallFrame { title: "in the call of `f`".into(), place: Some(place(text, "ring")) }];
        insta::assert_snapshot!(diagnostic.render(Ink::Plain));
    }
}
