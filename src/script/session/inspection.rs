//! Errors that are found without running a text: calls of unknown functions, unknown keys of options maps.
//!
//! Only certain errors are reported: names that exist neither in the language, nor in its engine, nor in the text. Types of expressions are
//! inferred from calls and members.

use std::collections::BTreeSet;

use rhai::Engine;

use super::completion::{KEYWORDS, Known, Words};
use super::cursor::{Cursor, TextTokenKind};
use super::declarations::Declarations;
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::function::{Form, Function};
use crate::script::language::habits;
use crate::script::language::parameter::Kind;
use crate::script::language::registry::Registry;
use crate::script::language::sources::SourceSpan;
use crate::script::language::wording::did_you_mean;

/// Largest number of reported errors of a kind: a suggestion takes a millisecond.
const MOST: usize = 50;

/// Functions built into the parser of the engine.
const OF_THE_PARSER: [&str; 9] = ["print", "debug", "type_of", "is_def_fn", "is_def_var", "is_shared", "Fn", "call", "curry"];

/// Names of the functions of the engine itself.
pub fn engine_functions(engine: &Engine) -> BTreeSet<String> {
    let names = engine.collect_fn_metadata(None, |function| Some(function.metadata.name.to_string()), true);
    names.into_iter().chain(OF_THE_PARSER.map(String::from)).collect()
}

/// Calls of unknown names.
pub fn unknown_calls(registry: &Registry, of_engine: &BTreeSet<String>, declared: &Declarations, place: &SourceSpan) -> Vec<Diagnostic> {
    let text: &str = &place.text;
    let is_known = |name: &str| of_engine.contains(name) || registry.named(name).next().is_some();
    // A map may contain a closure under any key.
    let is_key =
        |name: &str| text.contains(&format!("{name}:")) || text.contains(&format!("\"{name}\"")) || text.contains(&format!("{name} ="));
    let mut found = Vec::new();
    for range in &declared.unknown_calls {
        let (name, before) = (&text[range.clone()], text[..range.start].trim_end());
        let is_member = before.ends_with('.');
        if found.len() == MOST {
            break;
        }
        if is_known(name) || before.ends_with("::") || is_member && is_key(name) || name.is_empty() {
            continue;
        }
        let is_variable = !is_member && declared.meaning(name, range.start).is_some();
        let title = match () {
            () if is_variable => format!("`{name}` is a variable, and no function of that name is defined"),
            () if is_member => format!("no object has a function `{name}`"),
            () => format!("there is no function `{name}`"),
        };
        let names = registry.functions().iter().filter(|function| is_member != (function.form == Form::Function));
        let own = declared.all.iter().map(|declaration| declaration.name.as_str()).filter(|_| !is_member);
        let names = names.map(|function| function.name).chain(own).chain(of_engine.iter().map(String::as_str));
        let hint = match habits::instead_of_call(name) {
            _ if is_variable => Some(format!("a function in a variable is called by `call`: `{name}.call(…)`")),
            Some(habit) => Some(habit.to_string()),
            None => did_you_mean(name, names),
        };
        let warning = Diagnostic::warning(title, Some(SourceSpan { range: range.clone(), ..place.clone() }));
        found.push(hint.into_iter().fold(warning, Diagnostic::hint));
    }
    found
}

impl Words<'_> {
    /// Unknown keys in literal options maps.
    pub fn unknown_keys(&self, place: &SourceSpan) -> Vec<Diagnostic> {
        let mut cursor = Cursor::at_start(&place.text);
        let mut found = Vec::new();
        for index in 0..cursor.pieces.len() {
            cursor.enter(index);
            if cursor.kind(index) == Some(TextTokenKind::Sign(':'))
                && let Some((function, key, names)) = self.unknown_key(&cursor)
            {
                let range = cursor.pieces[index - 1].range.clone();
                let warning =
                    Diagnostic::warning(format!("{} has no option `{key}`", function.title()), Some(SourceSpan { range, ..place.clone() }));
                let hint = habits::option(&key).map(String::from).or_else(|| did_you_mean(&key, names));
                found.push(hint.into_iter().fold(warning.label("unknown option"), Diagnostic::hint));
            }
        }
        found
    }

    /// Called function, unknown key at the end of the cursor's brackets, and the valid keys of the function.
    fn unknown_key(&self, cursor: &Cursor) -> Option<(&Function, String, Vec<&'static str>)> {
        let [.., call, map] = cursor.levels.as_slice() else { return None };
        let key = map.key.clone().filter(|_| map.bracket == '#')?;
        // Only a map that is the whole argument is checked.
        let before = map.piece.checked_sub(1).and_then(|before| cursor.kind(before));
        let is_argument = matches!(before, Some(TextTokenKind::Open('(') | TextTokenKind::Sign(',')));
        let function = self.called_at(cursor, call).filter(|_| is_argument)?;
        let has = |other: &Function| match other.parameters.get(call.commas).map(|parameter| &parameter.kind) {
            Some(Kind::Options(keys)) => keys.iter().any(|known| known.name == key),
            _ => true,
        };
        let named: Vec<_> = self.registry.named(function.name).collect();
        let receivers = function.form.receiver().is_some();
        if named.iter().any(|other| other.form.receiver().is_some() == receivers && has(other)) {
            return None;
        }
        let keys = function.parameters.get(call.commas)?.kind.keys()?;
        Some((function, key, keys.iter().map(|known| known.name).collect()))
    }
}

impl Words<'_> {
    /// Type of an expression of calls and members, as far as known without evaluation.
    pub fn type_of(&self, text: &str) -> Option<&'static str> {
        let cursor = Cursor::new(text);
        let mut depth = 0usize;
        for piece in &cursor.pieces {
            match piece.kind {
                TextTokenKind::Open(_) => depth += 1,
                TextTokenKind::Close(_) => depth = depth.saturating_sub(1),
                TextTokenKind::Sign(_) if depth == 0 => return None,
                TextTokenKind::Name if depth == 0 && KEYWORDS.contains(&&text[piece.range.clone()]) => return None,
                _ => {}
            }
        }
        self.type_name(&cursor, cursor.pieces.len())
    }

    /// Type of the expression that ends before a token.
    pub fn type_name(&self, cursor: &Cursor, end: usize) -> Option<&'static str> {
        match self.resolve(cursor, end) {
            Known::Value(value) => self.registry.types().name_of(&value),
            Known::Type(name) => Some(name).filter(|name| !name.is_empty()),
            Known::Nothing => None,
        }
    }
}
