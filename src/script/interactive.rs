//! The session behind the prompt: entries one after another in a scope that lasts. No terminal here.
//!
//! The engine runs whole scripts. Three things make a session of it: the functions of all entries are merged into one tree; imports are
//! written again into the blank lines in front of each entry; and every entry is compiled below as many blank lines as the session has, so
//! that a position means one place in the whole session ([`Sources::append`](super::sources::Sources::append)).
//!
//! What was entered can be written as a script that runs from scratch to the same results. Statements that failed are left out, unless they
//! had changed something before; of those that were interrupted the steps are kept that were taken, and the values of their variables.

use std::collections::BTreeMap;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::rc::Rc;
use std::time::{Duration, Instant};

use rhai::{AST, Dynamic, FnAccess, ParseErrorType, Token};

use super::completion::{Candidate, KEYWORDS, Words};
use super::cursor::{Cursor, Kind};
use super::diagnostics::Diagnostic;
use super::failure::Class;
use super::help;
use super::host::{Observer, Settings};
use super::sandbox::reason;
use super::scan::{self, Lexeme};
use super::session::{Report, Session, defect};
use super::simulations::SimulationHandle;
use super::sources::offset;
use super::values::{kind_of, shown};

/// Name of the source in which all entries stand.
const SOURCE: &str = "prompt";
/// The variable that holds the last value.
const ANSWER: &str = "ans";

/// How an entry ended.
#[derive(Clone, Debug, PartialEq)]
enum Fate {
    /// Without an error; whether it had a value.
    Done { value: bool },
    /// With an error, after it had changed something.
    Failed,
    /// By the user, with what brings the simulations to where it left them.
    Interrupted { steps: Vec<String> },
}

/// An entry that belongs to the record.
struct Entry {
    text: String,
    fate: Fate,
}

/// An import that lasts.
struct Import {
    /// Its line and column, from 0, in the whole session.
    line: usize,
    column: usize,
    text: String,
    alias: String,
}

/// What an entry gave.
#[derive(Clone, Debug, Default)]
pub struct Answer {
    /// The value as the prompt shows it; nothing after a semicolon or without a value.
    pub shown: Option<String>,
    /// How long it took.
    pub elapsed: Duration,
}

/// A variable of the session.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// The kind of its value.
    pub kind: String,
    /// Its value in one line.
    pub value: String,
}

/// How a stretch of a text is colored.
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
    session: Session,
    functions: AST,
    imports: Vec<Import>,
    modules: BTreeMap<String, Vec<String>>,
    entries: Vec<Entry>,
    count: usize,
}

impl Interactive {
    /// A session for files below a folder.
    ///
    /// # Errors
    /// A folder that does not exist.
    pub fn new(settings: Settings, home: &Path, observer: Rc<dyn Observer>) -> Result<Self, Box<Diagnostic>> {
        let mut session = Session::new(settings, home, observer)?;
        session.scope.push(ANSWER, ());
        Ok(Interactive { session, functions: AST::empty(), imports: Vec::new(), modules: BTreeMap::new(), entries: Vec::new(), count: 0 })
    }

    /// Evaluates what was typed.
    ///
    /// # Errors
    /// What is wrong with it; all that was complete before stays.
    pub fn evaluate(&mut self, text: &str) -> Result<Answer, Box<Diagnostic>> {
        self.count += 1;
        let name = format!("{SOURCE} {}", self.count);
        self.enter(&name, text)
    }

    /// Evaluates the text of a file as an entry.
    ///
    /// # Errors
    /// A file that cannot be read; what is wrong with it.
    pub fn load(&mut self, path: &Path) -> Result<Answer, Box<Diagnostic>> {
        let name = path.display().to_string();
        let text = match std::fs::read(path).map(String::from_utf8) {
            Ok(Ok(text)) => text,
            Ok(Err(_)) => return Err(unreadable(&name, "it is not text (UTF-8)")),
            Err(error) => return Err(unreadable(&name, &reason(&error))),
        };
        self.enter(&name, &text)
    }

    fn enter(&mut self, name: &str, text: &str) -> Result<Answer, Box<Diagnostic>> {
        let host = self.session.host.clone();
        let begun = Instant::now();
        let (effects, before) = (host.effects(), self.positions());
        let outcome = catch_unwind(AssertUnwindSafe(|| self.run(name, text))).unwrap_or_else(|panic| Err((Some(0), defect(&*panic))));
        let lexemes = self.lexemes(text);
        match outcome {
            Ok(value) => {
                let has_value = !value.is_unit();
                if !lexemes.is_empty() {
                    self.entries.push(Entry { text: text.trim().into(), fate: Fate::Done { value: has_value } });
                }
                let quiet = lexemes.last().is_some_and(|last| matches!(last.token, Token::SemiColon));
                let shown = if quiet || !has_value { None } else { Some(shown(&host.registry.borrow(), &value)) };
                if has_value {
                    self.session.scope.set_value(ANSWER, value);
                }
                Ok(Answer { shown, elapsed: begun.elapsed() })
            }
            Err((None, error)) => Err(error),
            Err((Some(position), error)) => {
                self.keep_part(text, &lexemes, position, &error, host.effects() != effects || self.positions() != before, &before);
                Err(error)
            }
        }
    }

    /// Records an entry that ended with an error in the statement at `position`: what stood before that statement was done.
    fn keep_part(&mut self, text: &str, lexemes: &[Lexeme], position: usize, error: &Diagnostic, affected: bool, before: &[(usize, f64)]) {
        let statements = statements(lexemes);
        let bytes = |statement: &Range<usize>| lexemes[statement.start].range.start..lexemes[statement.end - 1].range.end;
        let at = statements.iter().rposition(|statement| bytes(statement).start <= position).unwrap_or(0);
        let Some(failed) = statements.get(at).cloned() else { return };
        // Functions mean the same wherever they stand.
        let is_function = |statement: &&Range<usize>| matches!(lexemes[statement.start].token, Token::Fn | Token::Private);
        let later = statements[at + 1..].iter().filter(is_function);
        let done: Vec<&str> = statements[..at].iter().chain(later).map(|statement| &text[bytes(statement)]).collect();
        if !done.is_empty() {
            self.entries.push(Entry { text: done.join(";\n"), fate: Fate::Done { value: false } });
        }
        let tokens = &lexemes[failed.clone()];
        let text = text[bytes(&failed)].to_string();
        if error.class == Class::Interrupted {
            let mut steps = Vec::new();
            if affected && !is_plain_stepping(tokens) {
                steps.push(format!("stop_after({}, || {{ {} }});", self.session.host.effects(), text.trim_end_matches(';')));
                steps.extend(self.values_of(tokens));
            } else {
                steps.extend(self.values_of(tokens));
                steps.extend(self.steps_since(before));
            }
            self.entries.push(Entry { text, fate: Fate::Interrupted { steps } });
        } else if affected || tokens.iter().any(|lexeme| lexeme.token.is_op_assignment() || matches!(lexeme.token, Token::Equals)) {
            self.entries.push(Entry { text, fate: Fate::Failed });
        }
    }

    /// Assignments that give the variables named in an interrupted statement the values they have now, where these can be written.
    fn values_of(&self, tokens: &[Lexeme]) -> Vec<String> {
        let mut names: Vec<&str> = Vec::new();
        for lexeme in tokens {
            if let Token::Identifier(name) = &lexeme.token {
                names.push(name.as_str());
            }
        }
        names.sort_unstable();
        names.dedup();
        let written = |name: &&str| {
            let value = self.session.scope.get(name).filter(|_| self.session.scope.is_constant(name) == Some(false))?;
            Some(format!("{name} = {};", literal(value)?))
        };
        names.iter().filter_map(written).collect()
    }

    /// Compiles and runs an entry; an error comes with where in the entry it was raised, unless nothing ran at all.
    fn run(&mut self, name: &str, text: &str) -> Result<Dynamic, (Option<usize>, Box<Diagnostic>)> {
        let host = self.session.host.clone();
        let engine_cell = self.session.engine.clone();
        let engine = engine_cell.borrow();
        let first_line = host.sources.text(SOURCE).map_or(0, |whole| whole.matches('\n').count());
        let start = host.sources.text(SOURCE).map_or(0, |whole| whole.len());
        host.sources.append(SOURCE, name, text);
        *host.main.borrow_mut() = SOURCE.to_string();
        host.lint(&engine, SOURCE);
        let explained = |error: &rhai::EvalAltResult| Box::new(super::explain::explain(&host, &engine, error, SOURCE));
        let padded = format!("{}{text}", self.padding(first_line));
        let tree = engine.compile_with_scope(&self.session.scope, &padded).map_err(|error| (None, explained(&error.into())))?;
        let mut tree = self.functions.merge(&tree);
        tree.set_source(SOURCE);
        let outcome = engine.eval_ast_with_scope::<Dynamic>(&mut self.session.scope, &tree);
        match outcome {
            Ok(value) => {
                tree.clear_statements();
                self.functions = tree;
                self.keep_imports(&engine, first_line, text);
                Ok(value)
            }
            Err(error) => {
                let position = host.sources.text(SOURCE).and_then(|whole| offset(&whole, error.position()));
                let position = position.map_or(0, |position| position.saturating_sub(start).min(text.len()));
                // Its functions and closures may be in use already.
                tree.clear_statements();
                self.functions = tree;
                self.keep_imports(&engine, first_line, &text[..position]);
                Err((Some(position), explained(&error)))
            }
        }
    }

    /// Blank lines with the imports in their places.
    fn padding(&self, lines: usize) -> String {
        let mut text = String::new();
        let (mut line, mut column) = (0, 0);
        for import in &self.imports {
            if import.line > line {
                text.extend(std::iter::repeat_n('\n', import.line - line));
                (line, column) = (import.line, 0);
            }
            text.extend(std::iter::repeat_n(' ', import.column.saturating_sub(column)));
            text += &import.text;
            column = import.column + import.text.chars().count();
        }
        text.extend(std::iter::repeat_n('\n', lines - line));
        text
    }

    /// Remembers the imports of an entry, outside of any block.
    fn keep_imports(&mut self, engine: &rhai::Engine, first_line: usize, text: &str) {
        let lexemes = scan::lexemes(engine, text);
        let mut depth = 0usize;
        for (index, lexeme) in lexemes.iter().enumerate() {
            match &lexeme.token {
                Token::LeftBrace | Token::MapStart => depth += 1,
                Token::RightBrace => depth = depth.saturating_sub(1),
                Token::Import if depth == 0 => {
                    let Some([path, word, alias]) = lexemes.get(index + 1..index + 4) else { continue };
                    let (Token::StringConstant(path), Token::As, Token::Identifier(alias)) = (&path.token, &word.token, &alias.token)
                    else {
                        continue;
                    };
                    let before = &text[..lexeme.range.start];
                    let line = first_line + before.matches('\n').count();
                    let column = before[before.rfind('\n').map_or(0, |newline| newline + 1)..].chars().count();
                    self.imports.retain(|import| import.alias != alias.as_str());
                    let text = format!("import {path:?} as {alias};");
                    self.imports.push(Import { line, column, text, alias: alias.to_string() });
                    self.modules.insert(alias.to_string(), module_functions(engine, &self.session, path));
                }
                _ => {}
            }
        }
    }

    fn lexemes(&self, text: &str) -> Vec<Lexeme> {
        scan::lexemes(&self.session.engine.borrow(), text)
    }

    /// Where every simulation stands.
    fn positions(&self) -> Vec<(usize, f64)> {
        let simulations = self.session.host.simulations.borrow();
        simulations.iter().map(|simulation| simulation.position()).collect()
    }

    /// Statements that bring the simulations from where they stood to where they are.
    fn steps_since(&self, before: &[(usize, f64)]) -> Vec<String> {
        let simulations = self.session.host.simulations.borrow();
        // A simulation of this very entry stood at zero.
        let before = before.iter().copied().chain(std::iter::repeat((0, 0.0)));
        let moved = simulations.iter().zip(before).filter(|(simulation, before)| simulation.position() != *before);
        moved
            .map(|(simulation, before)| {
                let (_, time) = simulation.position();
                let same = |value: &Dynamic| value.flatten_clone().try_cast::<SimulationHandle>().is_some_and(|other| other.is(simulation));
                match self.session.scope.iter_raw().find(|(name, _, value)| *name != ANSWER && same(value)) {
                    Some((name, ..)) if time > before.1 => format!("{name}.run_to({time:?});"),
                    _ => format!("// simulation \"{}\" came to t = {time:?}; no variable holds it any more", simulation.0.name),
                }
            })
            .collect()
    }

    /// Whether a text is the beginning of an entry that needs more lines.
    pub fn is_incomplete(&self, text: &str) -> bool {
        let cursor = Cursor::new(text);
        if cursor.in_comment && !text.trim_end().ends_with('\n') && text.rfind("/*") > text.rfind("//") {
            return true;
        }
        if cursor.is_crossed {
            return false;
        }
        if let Some(start) = cursor.in_string() {
            return text[..start].ends_with('`');
        }
        if !cursor.levels.is_empty() {
            return true;
        }
        let engine = self.session.engine.borrow();
        let imports: String = self.imports.iter().map(|import| import.text.as_str()).collect();
        let whole = format!("{imports}\n{text}");
        let Err(error) = engine.compile_with_scope(&self.session.scope, &whole) else { return false };
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
        let registry = self.session.host.registry.borrow();
        ask(&Words {
            engine: &engine,
            scope: &self.session.scope,
            registry: &registry,
            functions: &self.functions,
            modules: &self.modules,
            home: self.session.host.sandbox.home(),
        })
    }

    /// Where the completed word begins, and what can be written at the cursor, which stands at the end of `before`.
    pub fn complete(&self, before: &str) -> (usize, Vec<Candidate>) {
        match before.strip_prefix('?') {
            Some(name) => {
                let registry = self.session.host.registry.borrow();
                let names = registry.functions().iter().map(|function| function.name.to_string());
                let names = names.chain(help::topics()).chain(registry.types().iter().map(ToString::to_string));
                let mut names: Vec<String> = names.filter(|known| known.starts_with(name)).collect();
                names.sort();
                names.dedup();
                (1, names.into_iter().map(|name| Candidate { text: name.clone(), display: name }).collect())
            }
            None => self.words(|words| words.complete(before)),
        }
    }

    /// The rest of the signature of the call at the cursor, which stands at the end of `before`.
    pub fn hint(&self, before: &str) -> Option<String> {
        self.words(|words| words.hint(before))
    }

    /// Help on a name: of a topic, a function, a type, or a variable of the session.
    pub fn help(&self, name: &str) -> String {
        let registry = self.session.host.registry.borrow();
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
        let (engine, registry) = (self.session.engine.borrow(), self.session.host.registry.borrow());
        let mut all: Vec<(&str, bool, &Dynamic)> = self.session.scope.iter_raw().collect();
        // The engine lists the newest first.
        all.reverse();
        let mut found: Vec<Variable> = Vec::new();
        // The newest of a name is the one that counts.
        for (name, is_constant, value) in all {
            found.retain(|variable| variable.name != name);
            if name == "PI" || value.is_unit() {
                continue;
            }
            let kind = format!("{}{}", if is_constant { "const " } else { "" }, kind_of(&engine, value));
            let text = shown(&registry, &value.flatten_clone());
            let line: String = text.lines().next().unwrap_or("").chars().take(90).collect();
            found.push(Variable { name: name.into(), kind, value: line });
        }
        found
    }

    /// Stretches of a text to be colored.
    pub fn styles(&self, text: &str) -> Vec<(Range<usize>, Style)> {
        let registry = self.session.host.registry.borrow();
        let style = |piece: &super::cursor::Piece| {
            let word = &text[piece.range.clone()];
            Some(match piece.kind {
                Kind::Name if KEYWORDS.contains(&word) => Style::Keyword,
                Kind::Name if registry.named(word).next().is_some() => Style::Function,
                Kind::Number => Style::Number,
                Kind::Text { .. } => Style::Text,
                Kind::Comment { .. } => Style::Comment,
                _ => return None,
            })
        };
        super::cursor::pieces(text).iter().filter_map(|piece| Some((piece.range.clone(), style(piece)?))).collect()
    }

    /// The session as a script that runs from scratch to the same results.
    pub fn script(&self) -> String {
        let uses_answer = |text: &str| {
            self.lexemes(text).iter().any(|lexeme| matches!(&lexeme.token, Token::Identifier(name) if name.as_str() == ANSWER))
        };
        // Values that a later entry refers to as the last value.
        let mut named = vec![false; self.entries.len()];
        let mut starts_with_none = false;
        for (index, _) in self.entries.iter().enumerate().filter(|(_, entry)| uses_answer(&entry.text)) {
            match (0..index).rev().find(|&earlier| self.entries[earlier].fate == (Fate::Done { value: true })) {
                Some(earlier) => named[earlier] = true,
                None => starts_with_none = true,
            }
        }
        let mut lines = vec!["// A session at the prompt of conserva, to run again: failed statements are left out.".to_string()];
        if starts_with_none {
            lines.push(format!("let {ANSWER} = ();"));
        }
        for (entry, named) in self.entries.iter().zip(named) {
            lines.push(match &entry.fate {
                Fate::Done { .. } if named => self.with_named_value(&entry.text),
                Fate::Done { .. } => self.terminated(&entry.text),
                Fate::Failed => format!(
                    "try {{\n{}\n}} catch {{\n    // it failed at the prompt, after it had changed something\n}}",
                    self.terminated(&entry.text)
                ),
                Fate::Interrupted { steps } => {
                    let repeated = steps.iter().any(|step| step.starts_with("stop_after("));
                    let text: Vec<String> = entry.text.lines().map(|line| format!("//   {line}")).collect();
                    let text = if repeated { String::new() } else { format!("{}\n", text.join("\n")) };
                    format!("// interrupted at the prompt:\n{text}{}", steps.join("\n")).trim_end().to_string()
                }
            });
        }
        lines.push(String::new());
        lines.join("\n")
    }

    /// An entry with a semicolon at its end.
    fn terminated(&self, text: &str) -> String {
        match self.lexemes(text).last() {
            Some(last) if !matches!(last.token, Token::SemiColon) => {
                let (before, after) = text.split_at(last.range.end);
                format!("{before};{after}")
            }
            _ => text.to_string(),
        }
    }

    /// An entry whose last value gets the name of the last value.
    fn with_named_value(&self, text: &str) -> String {
        let mut lexemes = self.lexemes(text);
        while lexemes.last().is_some_and(|last| matches!(last.token, Token::SemiColon)) {
            lexemes.pop();
        }
        let start = statements(&lexemes).last().map_or(0, |last| last.start);
        match (lexemes.get(start), lexemes.last()) {
            (Some(first), Some(last)) => {
                let (from, to) = (first.range.start, last.range.end);
                format!("{}let {ANSWER} = {};", &text[..from], &text[from..to])
            }
            _ => self.terminated(text),
        }
    }

    /// Ends the session: writes the files of its simulations.
    pub fn finish(&mut self) -> Report {
        self.session.finish(None)
    }
}

/// Whether a statement is `object.run_to(…)` or `object.step(…)` without a call inside: a `run_to` repeats as much of it as was done.
fn is_plain_stepping(tokens: &[Lexeme]) -> bool {
    let name = |lexeme: &Lexeme| matches!(&lexeme.token, Token::Identifier(name) if matches!(name.as_str(), "run_to" | "step"));
    matches!(tokens, [object, dot, method, open, ..]
        if matches!((&object.token, &dot.token, &open.token), (Token::Identifier(_), Token::Period, Token::LeftParen)) && name(method))
        && tokens.iter().filter(|lexeme| matches!(lexeme.token, Token::LeftParen | Token::LeftBrace)).count() == 1
}

/// The statements of a text outside of any bracket, as ranges of lexemes without the semicolons between them.
fn statements(lexemes: &[Lexeme]) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let (mut start, mut blocks) = (0, Vec::new());
    for (index, lexeme) in lexemes.iter().enumerate() {
        match lexeme.token {
            Token::LeftParen | Token::LeftBracket | Token::MapStart => blocks.push(false),
            Token::LeftBrace => blocks.push(true),
            Token::RightParen | Token::RightBracket => drop(blocks.pop()),
            Token::RightBrace => {
                let is_block = blocks.pop() == Some(true);
                if blocks.is_empty() && is_block && lexemes.get(index + 1).is_some_and(|next| begins_a_statement(&next.token)) {
                    found.push(start..index + 1);
                    start = index + 1;
                }
            }
            Token::SemiColon if blocks.is_empty() => {
                found.push(start..index);
                start = index + 1;
            }
            _ => {}
        }
    }
    found.push(start..lexemes.len());
    found.retain(|statement| !statement.is_empty());
    found
}

fn begins_a_statement(token: &Token) -> bool {
    use Token::*;
    matches!(
        token,
        Identifier(_)
            | IntegerConstant(_)
            | FloatConstant(_)
            | StringConstant(_)
            | InterpolatedString(_)
            | Let
            | Const
            | Fn
            | Private
            | If
            | For
            | While
            | Loop
            | Do
            | Switch
            | Import
            | Export
            | Return
            | Throw
            | Try
            | True
            | False
    )
}

/// A value as it would be written, if it is short and consists of numbers, truth values and strings.
fn literal(value: &Dynamic) -> Option<String> {
    const LONGEST: usize = 10_000;
    if value.is_unit() {
        return Some("()".into());
    }
    if let Ok(flag) = value.as_bool() {
        return Some(flag.to_string());
    }
    if let Ok(whole) = value.as_int() {
        return Some(whole.to_string());
    }
    if let Ok(number) = value.as_float() {
        return number.is_finite().then(|| format!("{number:?}"));
    }
    if let Some(array) = value.read_lock::<rhai::Array>() {
        let entries: Option<Vec<String>> = array.iter().take(LONGEST).map(literal).collect();
        return entries.filter(|_| array.len() <= LONGEST).map(|entries| format!("[{}]", entries.join(", ")));
    }
    let text = value.clone().into_string().ok()?;
    (text.chars().all(|letter| !letter.is_control()) && text.len() <= LONGEST)
        .then(|| format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\"")))
}

/// Signatures of the functions of a module's file.
fn module_functions(engine: &rhai::Engine, session: &Session, path: &str) -> Vec<String> {
    let path = path.strip_suffix(".rhai").unwrap_or(path);
    let text = session.host.sandbox.module(path).ok().and_then(|file| std::fs::read_to_string(file).ok());
    let Some(Ok(tree)) = text.map(|text| engine.compile_with_scope(&super::constants(), text)) else { return Vec::new() };
    let named = tree.iter_functions().filter(|function| !function.name.starts_with("anon$") && function.access == FnAccess::Public);
    named.map(|function| format!("{}({})", function.name, function.params.join(", "))).collect()
}

fn unreadable(name: &str, cause: &str) -> Box<Diagnostic> {
    let error = Diagnostic::error(Class::Script, format!("the script {name} cannot be read"));
    Box::new(error.cause(cause).hint("check the path of the script"))
}

#[cfg(test)]
mod tests;
