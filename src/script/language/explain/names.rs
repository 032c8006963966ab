//! Unknown names of variables and properties, with similar known ones.

use super::context::Explainer;
use super::phrases::{distinct, lower, type_phrase};
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::failure::Class;
use crate::script::language::function::Form;
use crate::script::language::habits;
use crate::script::language::registry::Registry;
use crate::script::language::scan;
use crate::script::language::sources::SourceSpan;
use crate::script::language::wording::{did_you_mean, listed};

impl Explainer<'_> {
    /// Returns the message of a variable that is not declared where it is used.
    pub(super) fn unknown_variable(&self, name: &str, source: &str, place: Option<&SourceSpan>) -> Diagnostic {
        let mut diagnostic = Diagnostic::error(Class::Script, format!("there is no variable `{name}`"));
        let declared = self.lexemes(source).map(|lexemes| scan::declared(&lexemes)).unwrap_or_default();
        let registry = Registry::of(self.host);
        let meant = place.and_then(|place| habits::meant(&place.text[..place.range.start], name, &place.text[place.range.end..]));
        // All names of one letter are near to each other, so none is suggested.
        let near = did_you_mean(name, declared.iter().map(String::as_str)).filter(|_| name.chars().count() > 1);
        let is_variable = || self.lexemes(source).is_some_and(|lexemes| scan::has_variable(&lexemes, name));
        if let Some(hint) = meant {
            diagnostic = diagnostic.hint(hint);
        } else if let Some(hint) = habits::instead_of(name) {
            diagnostic = diagnostic.hint(hint);
        } else if registry.named(name).any(|function| function.form == Form::Function) && !is_variable() {
            diagnostic = diagnostic.cause(format!("`{name}` is a function")).hint(format!("call it: `{name}(…)`"));
        } else if let Some(suggestion) = near {
            diagnostic = diagnostic.hint(suggestion);
        } else if self.host.settings.interactive && place.is_some_and(|place| !is_in_function(&place.text[..place.range.start])) {
            if is_variable() {
                diagnostic = diagnostic.cause(format!("the entry that declares `{name}` failed before it did, or was taken back"));
            }
            diagnostic = diagnostic.hint(format!("declare it: `let {name} = …;`; `:vars` lists the variables"));
        } else if is_variable() {
            diagnostic = diagnostic
                .cause("a function sees its parameters and constants of its own, not the variables around it")
                .hint(format!("pass `{name}` as a parameter"));
        } else {
            diagnostic = diagnostic.hint(format!("declare it first: `let {name} = …;`"));
        }
        diagnostic
    }

    /// Message on a property that a type does not have, or that cannot be assigned to.
    pub(super) fn unknown_property(&self, text: &str) -> Diagnostic {
        let mut words = text.split('\'').skip(1).step_by(2);
        let (Some(name), Some(type_name)) = (words.next(), words.next()) else {
            return Diagnostic::error(Class::Script, lower(text));
        };
        let registry = Registry::of(self.host);
        if text.contains("setter") {
            let title = format!("`{name}` of {} cannot be assigned to", type_phrase(type_name));
            return Diagnostic::error(Class::Script, title).hint("give the value when the object is made");
        }
        let members: Vec<&str> = registry
            .members(type_name)
            .filter(|function| !matches!(function.form, Form::Column(_)))
            .map(|function| function.name)
            .collect();
        let diagnostic = Diagnostic::error(Class::Script, format!("{} has no property `{name}`", type_phrase(type_name)));
        if members.contains(&name) {
            return diagnostic.cause(format!("`{name}` is a function")).hint(format!("call it: `.{name}(…)`"));
        }
        let diagnostic =
            if members.is_empty() { diagnostic } else { diagnostic.cause(format!("it has {}", listed(&distinct(&members), "and"))) };
        let is_function = || self.builtin_functions().iter().any(|(function, types)| function == name && types.len() == 1);
        match did_you_mean(name, members.iter().copied()) {
            Some(suggestion) => diagnostic.hint(suggestion),
            None => match registry.types().instead_of_property(type_name, name) {
                Some(hint) => diagnostic.hint(hint),
                None if members.is_empty() && is_function() => diagnostic.hint(format!("call it: `{name}(x)` or `x.{name}()`")),
                None => diagnostic,
            },
        }
    }
}

/// True if a text ends inside the braces of a function.
fn is_in_function(before: &str) -> bool {
    let Some(start) = before.rfind("fn ") else { return false };
    let body = &before[start..];
    body.matches('{').count() > body.matches('}').count()
}
