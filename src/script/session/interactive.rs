//! Session behind the prompt: entries are evaluated one after another in a lasting scope, independent of a terminal.
//!
//! The engine runs whole scripts. For a session, the functions of all entries are merged into one tree; imports are repeated in front of
//! each entry (`imports.rs`); and every entry is compiled behind as many blank lines as the session has, so that a position is unique in
//! the session ([`Sources::append`](crate::script::language::sources::Sources::append)).
//!
//! The entries can be written as a script (`record.rs`).

use std::collections::BTreeMap;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::rc::Rc;
use std::time::{Duration, Instant};

use rhai::{AST, Dynamic, ParseErrorType, Scope, ScriptFnMetadata, Token};

use super::completion::{Candidate, KEYWORDS, Words};
use super::cursor::{Cursor, TextToken, TextTokenKind, pieces};
use super::help;
use super::imports::Imports;
use super::pages::PAGES;
use super::record::{ANSWER, Record, lexemes, positions};
use super::session::{Report, Session};
use super::shown::{DIGITS, kind_of, shown};
use super::statements::statements;
use crate::machine::files;
use crate::script::language::diagnostics::{Diagnostic, defect};
use crate::script::language::explain::explain;
use crate::script::language::failure::Class;
use crate::script::language::lint::lint;
use crate::script::language::observer::Observer;
use crate::script::language::registry::Registry;
use crate::script::language::sandbox::reason;
use crate::script::language::scan::Lexeme;
use crate::script::language::settings::Settings;
use crate::script::language::sources::offset;
use crate::script::language::wording::listed;
use crate::script::language::worker_pool::{Program, Unit};

/// Name of the source of all entries.
const SOURCE: &str = "prompt";

/// Indentation of a new line per open bracket.
const INDENTATION: &str = "    ";

/// Result of an entry.
#[derive(Clone, Debug, Default)]
pub struct Answer {
    /// Value as shown at the prompt; `None` after a semicolon or without a value.
    pub shown: Option<String>,
    /// Time of the evaluation.
    pub elapsed: Duration,
}

/// A variable of the session.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Variable {
    /// Name of the variable.
    pub name: String,
    /// Type of the variable's value.
    pub kind: String,
    /// Value of the variable in one line.
    pub value: String,
}

/// Color class of a part of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// A word of the language.
    Keyword,
    /// A function of the language.
    Function,
    /// A number.
    Number,
    /// A string.
    Text,
    /// A comment.
    Comment,
}

/// A session at a prompt.
pub struct Interactive {
    pub(super) session: Session,
    functions: AST,
    imports: Imports,
    record: Record,
    count: usize,
    /// States of the session before the last entries, for undoing them.
    earlier: Vec<Earlier>,
    /// Moment at which the last entry was answered.
    answered: Instant,
    /// Number of digits of displayed numbers; `None`: all digits.
    pub digits: Option<usize>,
}

/// A session before an entry.
struct Earlier {
    scope: Scope<'static>,
    functions: AST,
    /// Number of texts with functions.
    units: usize,
    recorded: usize,
    effects: u64,
}

/// Entries that can be undone.
const UNDONE: usize = 10;

impl Interactive {
    /// A session for files below a folder.
    ///
    /// # Errors
    /// A folder that does not exist.
    pub fn new(settings: Settings, home: &Path, observer: Rc<dyn Observer>) -> Result<Self, Box<Diagnostic>> {
        let mut session = Session::new(settings, home, observer)?;
        session.scope.push(ANSWER, ());
        Ok(Interactive {
            session,
            functions: AST::empty(),
            imports: Imports::default(),
            record: Record::default(),
            count: 0,
            earlier: Vec::new(),
            answered: Instant::now(),
            digits: Some(DIGITS),
        })
    }

    /// Evaluates an entry.
    ///
    /// # Errors
    /// The entry is wrong; changes by statements completed before the error are kept.
    pub fn evaluate(&mut self, text: &str) -> Result<Answer, Box<Diagnostic>> {
        self.count += 1;
        let name = format!("{SOURCE} {}", self.count);
        self.enter(&name, text)
    }

    /// Evaluates the text of a file as an entry.
    ///
    /// # Errors
    /// A file that cannot be read; an error of the entry.
    pub fn load(&mut self, path: &Path) -> Result<Answer, Box<Diagnostic>> {
        let name = path.display().to_string();
        let text = files::read_text(path).map_err(|error| unreadable(&name, &reason(&error)))?;
        self.enter(&name, &text)
    }

    fn enter(&mut self, name: &str, text: &str) -> Result<Answer, Box<Diagnostic>> {
        let host = self.session.host.clone();
        let begun = Instant::now();
        self.session.idle += begun.duration_since(self.answered);
        let (effects, before) = (host.effects(), positions(&self.session));
        self.keep_earlier(effects);
        let outcome = catch_unwind(AssertUnwindSafe(|| self.run(name, text))).unwrap_or_else(|panic| Err((Some(0), defect(&*panic))));
        let lexemes = lexemes(&self.session, text);
        self.answered = Instant::now();
        match outcome {
            Ok(value) => {
                let has_value = !value.is_unit();
                if !lexemes.is_empty() {
                    self.record.keep(text, has_value);
                }
                let quiet = lexemes.last().is_some_and(|last| matches!(last.token, Token::SemiColon));
                let shown = if quiet || !has_value { None } else { Some(shown(&Registry::of(&host), &value, self.digits)) };
                if has_value {
                    self.session.scope.set_value(ANSWER, value);
                }
                Ok(Answer { shown, elapsed: begun.elapsed() })
            }
            Err((None, error)) => {
                // No statement ran, so nothing has to be undone.
                self.earlier.pop();
                Err(error)
            }
            Err((Some(position), error)) => {
                let affected = host.effects() != effects || positions(&self.session) != before;
                self.record.keep_part(&self.session, text, position, &error, affected, &before);
                Err(Box::new(self.told_what_stays(*error)))
            }
        }
    }

    fn keep_earlier(&mut self, effects: u64) {
        if self.earlier.len() == UNDONE {
            self.earlier.remove(0);
        }
        let (scope, functions) = (self.session.scope.clone(), self.functions.clone());
        let units = self.session.host.slots.get::<Program>().0.borrow().len();
        self.earlier.push(Earlier { scope, functions, units, recorded: self.record.len(), effects });
    }

    /// Undoes the last entry: variables and functions are restored.
    ///
    /// # Errors
    /// There is no entry, or it has changed objects, which cannot be restored; in words.
    pub fn undo(&mut self) -> Result<(), String> {
        let Some(earlier) = self.earlier.pop() else { return Err("there is no entry to take back".into()) };
        if earlier.effects != self.session.host.effects() {
            self.earlier.push(earlier);
            return Err("the last entry changed a model or a simulation, which is not taken back; `sim.back(n)` takes back steps".into());
        }
        self.session.scope = earlier.scope;
        self.functions = earlier.functions;
        self.session.host.slots.get::<Program>().0.borrow_mut().truncate(earlier.units);
        self.record.truncate(earlier.recorded);
        Ok(())
    }

    /// Adds to the error of an entry which of its changes remain in effect.
    fn told_what_stays(&self, error: Diagnostic) -> Diagnostic {
        let Some(earlier) = self.earlier.last() else { return error };
        let all: Vec<&str> = self.session.scope.iter_raw().map(|(name, ..)| name).collect();
        let mut new: Vec<&str> = all[..all.len() - earlier.scope.len().min(all.len())].to_vec();
        if new.is_empty() {
            return error;
        }
        new.reverse();
        error.cause(format!("the entry ended there; what it had declared before stays: {}", listed(&new, "and")))
    }

    /// Compiles and runs an entry; an error has its position in the entry, unless no statement ran.
    fn run(&mut self, name: &str, text: &str) -> Result<Dynamic, (Option<usize>, Box<Diagnostic>)> {
        let host = self.session.host.clone();
        let engine_cell = self.session.engine.clone();
        let engine = engine_cell.borrow();
        let first_line = host.sources.text(SOURCE).map_or(0, |whole| whole.matches('\n').count());
        let start = host.sources.text(SOURCE).map_or(0, |whole| whole.len());
        host.sources.append(SOURCE, name, text);
        *host.main.borrow_mut() = SOURCE.to_string();
        lint(&host, &engine, SOURCE);
        let explained = |error: &rhai::EvalAltResult| Box::new(explain(&host, &engine, error, SOURCE));
        let padded = format!("{}{text}", self.imports.padding(first_line));
        let tree = engine.compile_with_scope(&self.session.scope, &padded).map_err(|error| (None, explained(&error.into())))?;
        let mut tree = self.functions.merge(&tree);
        tree.set_source(SOURCE);
        let names = self.session.scope.iter_raw().map(|(name, ..)| name.to_string()).collect();
        host.slots.get::<Program>().0.borrow_mut().push(Unit { text: padded, names });
        let outcome = engine.eval_ast_with_scope::<Dynamic>(&mut self.session.scope, &tree);
        match outcome {
            Ok(value) => {
                tree.clear_statements();
                self.functions = tree;
                self.imports.keep(&engine, &host.sandbox, first_line, text);
                Ok(value)
            }
            Err(error) => {
                let position = host.sources.text(SOURCE).and_then(|whole| offset(&whole, error.position()));
                let position = position.map_or(0, |position| position.saturating_sub(start).min(text.len()));
                // Functions and closures of the entry are kept, because values may refer to them.
                tree.clear_statements();
                self.functions = tree;
                self.imports.keep(&engine, &host.sandbox, first_line, &text[..position]);
                Err((Some(position), explained(&error)))
            }
        }
    }

    /// True if a text is the beginning of an entry that needs more lines.
    pub fn is_incomplete(&self, text: &str) -> bool {
        let cursor = Cursor::new(text);
        if cursor.in_comment && !text.trim_end().ends_with('\n') && text.rfind("/*") > text.rfind("//") {
            return true;
        }
        if cursor.is_crossed {
            return false;
        }
        // A comment before the function to which it belongs.
        if text.trim_end().rsplit('\n').next().is_some_and(|last| last.trim_start().starts_with("///")) {
            return true;
        }
        if let Some(start) = cursor.in_string() {
            return text[..start].ends_with('`');
        }
        if !cursor.levels.is_empty() {
            return true;
        }
        let engine = self.session.engine.borrow();
        let imports = self.imports.line();
        let whole = format!("{imports}\n{text}");
        let Err(error) = engine.compile_with_scope(&self.session.scope, &whole) else {
            return may_go_on(&lexemes(&self.session, text), text);
        };
        if matches!(error.err_type(), ParseErrorType::VariableUndefined(_) | ParseErrorType::ModuleUndefined(_)) {
            return false;
        }
        let (lines, last) = (whole.matches('\n').count() + 1, whole.rsplit('\n').next().unwrap_or(""));
        let position = error.position();
        let line = position.line().unwrap_or(usize::MAX);
        line > lines || (line == lines && position.position().unwrap_or(0) > last.trim_end().chars().count())
    }

    fn words<T>(&self, ask: impl FnOnce(&Words) -> T) -> T {
        let engine = self.session.engine.borrow();
        let registry = Registry::of(&self.session.host);
        ask(&Words {
            engine: &engine,
            scope: &self.session.scope,
            unknown: &BTreeMap::new(),
            registry: &registry,
            functions: &self.functions,
            modules: self.imports.modules(),
            home: self.session.host.sandbox.home(),
        })
    }

    /// Returns the start of the completed word, and the completions at the end of `before`.
    pub fn complete(&self, before: &str) -> (usize, Vec<Candidate>) {
        match before.strip_prefix('?') {
            Some(name) => {
                let registry = Registry::of(&self.session.host);
                let names = registry.functions().iter().map(|function| function.name.to_string());
                let pages = PAGES.iter().flat_map(|page| page.names.iter().map(ToString::to_string));
                let own = self.functions.iter_functions().map(|function| function.name.to_string());
                let names =
                    names.chain(help::topics()).chain(pages).chain(own).chain(registry.types().names().iter().map(ToString::to_string));
                let mut names: Vec<String> = names.filter(|known| known.starts_with(name)).collect();
                names.sort();
                names.dedup();
                (1, names.into_iter().map(|name| Candidate { text: name.clone(), display: name }).collect())
            }
            None => self.words(|words| words.complete(before)),
        }
    }

    /// The rest of the signature of the call at the cursor; `before` is the text before the cursor.
    pub fn hint(&self, before: &str) -> Option<String> {
        self.words(|words| words.hint(before))
    }

    /// Returns help on a name: a topic, a function (also of the session), a type, or a variable of the session.
    pub fn help(&self, name: &str) -> String {
        let registry = Registry::of(&self.session.host);
        let own = name.trim().trim_end_matches("()");
        let own: Vec<String> =
            self.functions.iter_functions().filter(|function| function.name == own).map(|function| own_help(&function)).collect();
        if !own.is_empty() {
            return own.join("\n\n");
        }
        match self.session.scope.get(name.trim()) {
            Some(value) if registry.named(name.trim()).next().is_none() => {
                let engine = self.session.engine.borrow();
                help::of_type(&registry, engine.map_type_name(value.type_name()))
            }
            _ => help::help(&registry, name),
        }
    }

    /// The variables of the session, in the order of their declaration.
    pub fn variables(&self) -> Vec<Variable> {
        let (engine, registry) = (self.session.engine.borrow(), Registry::of(&self.session.host));
        let mut all: Vec<(&str, bool, &Dynamic)> = self.session.scope.iter_raw().collect();
        // The engine lists the newest first.
        all.reverse();
        let mut found: Vec<Variable> = Vec::new();
        // The newest of several variables with one name counts.
        for (name, is_constant, value) in all {
            found.retain(|variable| variable.name != name);
            if name == "PI" || value.is_unit() {
                continue;
            }
            let kind = format!("{}{}", if is_constant { "const " } else { "" }, kind_of(&engine, value));
            let text = shown(&registry, &value.flatten_clone(), self.digits);
            let line: String = text.lines().next().unwrap_or("").chars().take(90).collect();
            found.push(Variable { name: name.into(), kind, value: line });
        }
        found
    }

    /// Stretches of a text to be colored.
    pub fn styles(&self, text: &str) -> Vec<(Range<usize>, Style)> {
        let registry = Registry::of(&self.session.host);
        let style = |piece: &TextToken| {
            let word = &text[piece.range.clone()];
            Some(match piece.kind {
                TextTokenKind::Name if KEYWORDS.contains(&word) => Style::Keyword,
                TextTokenKind::Name if registry.named(word).next().is_some() => Style::Function,
                TextTokenKind::Number => Style::Number,
                TextTokenKind::Text { .. } => Style::Text,
                TextTokenKind::Comment { .. } => Style::Comment,
                _ => return None,
            })
        };
        pieces(text).iter().filter_map(|piece| Some((piece.range.clone(), style(piece)?))).collect()
    }

    /// Ends the session: writes the files of its simulations.
    pub fn finish(&mut self) -> Report {
        self.session.idle += self.answered.elapsed();
        self.session.finish(None)
    }

    /// Returns the session as a script that reproduces its results from scratch.
    pub fn script(&self) -> String {
        self.record.script(&self.session)
    }
}

/// Returns the indentation of the line after a text with open brackets; empty without open brackets, or inside of a string or comment.
pub fn indentation(text: &str) -> String {
    let cursor = Cursor::new(text);
    let is_plain = cursor.in_string().is_none() && !cursor.in_comment && !cursor.is_crossed;
    INDENTATION.repeat(if is_plain { cursor.levels.len() } else { 0 })
}

/// Returns the help of a function of the session: its signature and doc comments.
fn own_help(function: &ScriptFnMetadata) -> String {
    let comments = function.comments.iter().flat_map(|comment| comment.lines());
    let comments: Vec<String> = comments.map(|line| format!("\n  {}", line.trim().trim_start_matches('/').trim())).collect();
    let comments = if comments.is_empty() {
        "\n  a function of this session; `///` comments in front of it are its help".into()
    } else {
        comments.concat()
    };
    format!("{}({}){comments}", function.name, function.params.join(", "))
}

/// True if `else` may follow: the last statement is an `if` of several lines without `else`, and no empty line ends it.
fn may_go_on(lexemes: &[Lexeme], text: &str) -> bool {
    let Some(last) = statements(lexemes).pop().filter(|_| text.ends_with('}')) else { return false };
    let (statement, mut depth, mut has_else) = (&lexemes[last], 0usize, false);
    for (index, lexeme) in statement.iter().enumerate() {
        match lexeme.token {
            Token::LeftBrace | Token::MapStart => depth += 1,
            Token::RightBrace => depth = depth.saturating_sub(1),
            Token::Else if depth == 0 => has_else = !matches!(statement.get(index + 1).map(|next| &next.token), Some(Token::If)),
            _ => {}
        }
    }
    let begins = statement.first().filter(|first| matches!(first.token, Token::If));
    begins.is_some_and(|first| !has_else && text[first.range.start..].contains('\n'))
}

fn unreadable(name: &str, cause: &str) -> Box<Diagnostic> {
    let error = Diagnostic::error(Class::Script, format!("the script {name} cannot be read"));
    Box::new(error.cause(cause).hint("check the path of the script"))
}
