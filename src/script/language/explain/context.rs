//! Sources of a message: the session's texts and functions, and the engine's own functions.

use rhai::{Engine, Position};

use super::phrases::short_type;
use crate::script::language::host::Host;
use crate::script::language::scan::{self, Target};
use crate::script::language::sources::SourceSpan;

/// Name of a function with its parameters, or with their types.
pub(super) type Signature = (String, Vec<String>);

/// Host and engine in which an error occurred.
pub(super) struct Explainer<'a> {
    pub(super) host: &'a Host,
    pub(super) engine: &'a Engine,
}

impl Explainer<'_> {
    /// Returns the source place of the call at a position.
    pub(super) fn place(&self, source: &str, position: Position) -> Option<SourceSpan> {
        self.host.place(self.engine, source, position, &Target::Call, false)
    }

    /// Tokens of a source.
    pub(super) fn lexemes(&self, source: &str) -> Option<Vec<scan::Lexeme>> {
        let source = if source.is_empty() { self.host.main.borrow().clone() } else { source.to_string() };
        self.host.sources.text(&source).map(|text| scan::lexemes(self.engine, &text))
    }

    /// Functions that a script defines: names and parameters.
    pub(super) fn defined_functions(&self, source: &str) -> Vec<Signature> {
        use rhai::Token::{Comma, Fn, Identifier, LeftParen, RightParen};
        let lexemes = self.lexemes(source).unwrap_or_default();
        let mut found = Vec::new();
        for (index, window) in lexemes.windows(2).enumerate() {
            if let (Fn, Identifier(name)) = (&window[0].token, &window[1].token) {
                let parameters = lexemes[index + 2..].iter().take_while(|lexeme| !matches!(lexeme.token, RightParen));
                let parameters = parameters.filter_map(|lexeme| match &lexeme.token {
                    LeftParen | Comma => None,
                    Identifier(parameter) => Some(parameter.to_string()),
                    _ => None,
                });
                found.push((name.to_string(), parameters.collect()));
            }
        }
        found
    }

    /// Functions of the engine: names and types of their parameters.
    pub(super) fn builtin_functions(&self) -> Vec<Signature> {
        self.engine.collect_fn_metadata(
            None,
            |function| {
                let name = function.metadata.name.to_string();
                let plain = name.chars().all(|letter| letter.is_alphanumeric() || letter == '_');
                let types =
                    function.metadata.params_info.iter().map(|parameter| parameter.split(": ").last().unwrap_or("").replace("&mut ", ""));
                plain.then(|| (name, types.map(|name| short_type(&name)).collect()))
            },
            true,
        )
    }
}
