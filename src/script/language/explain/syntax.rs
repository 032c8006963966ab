//! Messages on syntax errors.

use rhai::{LexError, ParseErrorType};

use super::context::Explainer;
use super::phrases::{count_of, lower, missing_hint, type_hint, type_phrase};
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::failure::Class;
use crate::script::language::habits;
use crate::script::language::sources::SourceSpan;

impl Explainer<'_> {
    /// Message on a syntax error.
    pub(super) fn reword_syntax(&self, kind: &ParseErrorType, source: &str, place: Option<&SourceSpan>) -> Diagnostic {
        let word = place.map_or("", |place| &place.text[place.range.clone()]);
        let script = |title: String| Diagnostic::error(Class::Script, title);
        match kind {
            ParseErrorType::UnexpectedEOF => {
                script("the script ends in the middle of something".into()).hint("close the open bracket, string or block")
            }
            ParseErrorType::BadInput(LexError::UnterminatedString) => {
                script("the string has no end".into()).hint("close it with `\"` in the same line")
            }
            ParseErrorType::BadInput(LexError::UnexpectedInput(text)) => unexpected(text),
            ParseErrorType::BadInput(LexError::MalformedChar(text)) => {
                script(format!("'{text}' is not a single character")).hint("write strings in double quotes")
            }
            ParseErrorType::BadInput(LexError::MalformedNumber(text)) => {
                script(format!("`{text}` is not a number")).hint("write numbers such as `12`, `0.5` or `1e-3`")
            }
            ParseErrorType::BadInput(LexError::ImproperSymbol(text, _)) if habits::operator(text).is_some() => {
                script(format!("there is no operator `{text}`")).hint(habits::operator(text).unwrap_or_default())
            }
            ParseErrorType::BadInput(error) if error.to_string().contains("typo of '=='") => {
                script("`=` gives a variable a value; it does not compare".into()).hint("write `==`")
            }
            ParseErrorType::BadInput(error) => script(lower(&error.to_string())),
            ParseErrorType::UnknownOperator(text) => {
                let error = script(format!("there is no operator `{text}`"));
                error.hint(habits::operator(text).unwrap_or("the operators are `+ - * / % **`, comparisons, `&&`, `||` and `!`"))
            }
            ParseErrorType::MissingToken(token, purpose) if token == "," && word == "for" && purpose.contains("array") => {
                script("an array is written with its values".into()).hint(habits::LIST_BY_LOOP)
            }
            ParseErrorType::MissingToken(token, purpose) if token == "," && ends_a_statement(word) => open_bracket(purpose),
            ParseErrorType::MissingToken(token, purpose) => {
                let hint = habits::instead_of(word).map(String::from).unwrap_or_else(|| missing_hint(token));
                script(format!("`{token}` is missing {}", lower(purpose))).hint(hint)
            }
            ParseErrorType::VariableExpected | ParseErrorType::PropertyExpected | ParseErrorType::FnMissingName
                if word.chars().all(char::is_alphabetic) && !word.is_empty() =>
            {
                script(format!("`{word}` is a word of the language and cannot be a name")).hint("choose another name")
            }
            ParseErrorType::PropertyExpected if follows_a_decimal_comma(place) => {
                script("a number has a decimal point, and this one a comma".into()).hint("write numbers such as `0.5`")
            }
            ParseErrorType::Reserved(word) => {
                script(format!("`{word}` is a reserved word")).hint(habits::instead_of(word).unwrap_or("choose another name"))
            }
            ParseErrorType::VariableUndefined(name) => self.unknown_variable(name, source, place),
            ParseErrorType::ModuleUndefined(name) => {
                script(format!("there is no module `{name}`")).hint(format!("import it first: `import \"path\" as {name};`"))
            }
            ParseErrorType::DuplicatedProperty(name) => script(format!("the map has two entries `{name}`")).hint("remove one of them"),
            ParseErrorType::DuplicatedVariable(name) => script(format!("the name `{name}` is there twice")).hint("choose another name"),
            ParseErrorType::AssignmentToConstant(name) => {
                script(format!("`{name}` is a constant and cannot be assigned to")).hint("declare it with `let` instead of `const`")
            }
            ParseErrorType::MismatchedType(expected, given) => {
                script(format!("this must be {}, not {}", type_phrase(expected), type_phrase(given))).hint(type_hint(expected, given))
            }
            ParseErrorType::FnDuplicatedDefinition(name, count) => {
                script(format!("there are two functions `{name}` with {}", count_of(*count, "parameter", "parameters")))
                    .hint("rename one of them")
            }
            ParseErrorType::WrongDocComment => {
                script("a `///` comment must stand in front of a function".into()).hint("write `//` for other comments")
            }
            ParseErrorType::WrongFnDefinition => script("a function cannot be defined inside a block or another function".into())
                .hint("move it to the top level, or use a closure: `let f = |x| …;`"),
            ParseErrorType::ExprTooDeep => script("the expression is nested too deeply".into()).hint("split it with `let`"),
            ParseErrorType::LoopBreak => script("`break` is not inside a loop".into()).hint("remove it"),
            ParseErrorType::LiteralTooLarge(what, limit) => {
                script(format!("{} is too large", lower(what))).cause(format!("the limit is {limit}"))
            }
            other => script(lower(&other.to_string())),
        }
    }
}

/// True if the text at a place is a whole number that follows a comma and another number, as in `0,5`.
fn follows_a_decimal_comma(place: Option<&SourceSpan>) -> bool {
    let Some(place) = place else { return false };
    let (before, word) = (place.text[..place.range.start].trim_end(), &place.text[place.range.clone()]);
    let is_number = |text: &str| text.chars().next_back().is_some_and(|last| last.is_ascii_digit());
    word.starts_with(|first: char| first.is_ascii_digit()) && before.strip_suffix(',').is_some_and(is_number)
}

/// True if a word can only follow a complete statement or begin the next one.
fn ends_a_statement(word: &str) -> bool {
    matches!(word, ";" | "let" | "const" | "fn" | "for" | "while" | "loop" | "return" | "import" | "")
}

/// Returns the message of a list that continues where its bracket should be closed.
fn open_bracket(purpose: &str) -> Diagnostic {
    let (bracket, what) = match purpose.split('\'').nth(1) {
        Some(function) => (")", format!("the call of `{function}`")),
        None if purpose.contains("map") => ("}", "the map".to_string()),
        None if purpose.contains("array") => ("]", "the array".to_string()),
        None => (")", "the list".to_string()),
    };
    let error = Diagnostic::error(Class::Script, format!("`{bracket}` is missing")).cause(format!("{what} is still open here"));
    error.hint(format!("close the bracket with `{bracket}`"))
}

/// Message on a symbol at an invalid position.
fn unexpected(text: &str) -> Diagnostic {
    let (title, hint) = match text {
        "fn" => ("`fn` means nothing here".into(), "write a closure as `|x| …`; `fn name(x) { … }` stands by itself"),
        _ if text.chars().all(char::is_alphabetic) => {
            (format!("`{text}` cannot stand in a name"), "names are letters of a to z, digits and `_`; any text may stand in quotes")
        }
        _ => (format!("`{text}` means nothing here"), "remove it; strings stand in double quotes"),
    };
    Diagnostic::error(Class::Script, title).hint(hint)
}
