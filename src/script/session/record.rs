//! The record of a session: its entries as a script that reproduces the results from scratch.
//!
//! Failed statements are left out unless they had made changes; of interrupted ones, the completed steps are kept, and the values of their
//! variables.

use std::ops::Range;

use rhai::{Dynamic, Token};

use super::session::Session;
use super::statements::{is_plain_stepping, literal, statements};
use crate::script::api::simulations::handle::{SimulationHandle, Simulations};
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::failure::Class;
use crate::script::language::scan::{self, Lexeme};

/// Name of the variable with the last value.
pub const ANSWER: &str = "ans";

/// Outcome of an entry.
#[derive(Clone, Debug, PartialEq)]
enum Fate {
    /// Completed without error; `value` is true if the entry had a value.
    Done { value: bool },
    /// Ended with an error after changes.
    Failed,
    /// Ended by the user; `steps` are statements that restore the state of the simulations.
    Interrupted { steps: Vec<String> },
}

/// An entry that belongs to the record.
struct Recorded {
    text: String,
    fate: Fate,
}

/// The entries of a session.
#[derive(Default)]
pub struct Record {
    entries: Vec<Recorded>,
}

impl Record {
    /// Number of recorded entries.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Drops the entries after the first `count`.
    pub fn truncate(&mut self, count: usize) {
        self.entries.truncate(count);
    }

    /// Keeps an entry that ended without an error.
    pub fn keep(&mut self, text: &str, has_value: bool) {
        self.entries.push(Recorded { text: text.trim().into(), fate: Fate::Done { value: has_value } });
    }

    /// Records an entry that ended with an error in the statement at `position`: earlier statements were completed.
    pub fn keep_part(
        &mut self,
        session: &Session,
        text: &str,
        position: usize,
        error: &Diagnostic,
        affected: bool,
        before: &[(usize, f64)],
    ) {
        let lexemes = lexemes(session, text);
        let statements = statements(&lexemes);
        let bytes = |statement: &Range<usize>| lexemes[statement.start].range.start..lexemes[statement.end - 1].range.end;
        let at = statements.iter().rposition(|statement| bytes(statement).start <= position).unwrap_or(0);
        let Some(failed) = statements.get(at).cloned() else { return };
        // Functions in later statements are kept too, because the engine finds functions independently of their position.
        let is_function = |statement: &&Range<usize>| matches!(lexemes[statement.start].token, Token::Fn | Token::Private);
        let later = statements[at + 1..].iter().filter(is_function);
        let done: Vec<&str> = statements[..at].iter().chain(later).map(|statement| &text[bytes(statement)]).collect();
        if !done.is_empty() {
            self.entries.push(Recorded { text: done.join(";\n"), fate: Fate::Done { value: false } });
        }
        let tokens = &lexemes[failed.clone()];
        let text = text[bytes(&failed)].to_string();
        if error.class == Class::Interrupted {
            let mut steps = Vec::new();
            if affected && !is_plain_stepping(tokens) {
                steps.push(format!("stop_after({}, || {{ {} }});", session.host.effects(), text.trim_end_matches(';')));
                steps.extend(values_of(session, tokens));
            } else {
                steps.extend(values_of(session, tokens));
                steps.extend(steps_since(session, before));
            }
            self.entries.push(Recorded { text, fate: Fate::Interrupted { steps } });
        } else if affected || (is_compound(tokens) && tokens.iter().any(|lexeme| assigns(&lexeme.token))) {
            self.entries.push(Recorded { text, fate: Fate::Failed });
        }
    }

    /// Returns the session as a script that reproduces its results from scratch.
    pub fn script(&self, session: &Session) -> String {
        let uses_answer = |text: &str| {
            lexemes(session, text).iter().any(|lexeme| matches!(&lexeme.token, Token::Identifier(name) if name.as_str() == ANSWER))
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
        let is_left_out =
            |entry: &Recorded, named: bool| entry.fate == Fate::Done { value: true } && !named && is_look(session, &entry.text);
        for (entry, named) in self.entries.iter().zip(named).filter(|(entry, named)| !is_left_out(entry, *named)) {
            lines.push(match &entry.fate {
                Fate::Done { .. } if named => with_named_value(session, &entry.text),
                Fate::Done { .. } => terminated(session, &entry.text),
                Fate::Failed => format!(
                    "try {{\n{}\n}} catch {{\n    // it failed at the prompt, after it had changed something\n}}",
                    terminated(session, &entry.text)
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
}

/// True if a token assigns.
fn assigns(token: &Token) -> bool {
    token.is_op_assignment() || matches!(token, Token::Equals)
}

/// True if a statement contains others, of which some may be completed when it fails.
fn is_compound(tokens: &[Lexeme]) -> bool {
    tokens.iter().any(|lexeme| matches!(lexeme.token, Token::LeftBrace))
}

/// True if a text only reads variables and properties.
fn is_look(session: &Session, text: &str) -> bool {
    let acts = |token: &Token| assigns(token) || matches!(token, Token::LeftParen | Token::LeftBrace | Token::Let | Token::Const);
    !lexemes(session, text).iter().any(|lexeme| acts(&lexeme.token))
}

/// Returns assignments of the present values to the variables named in an interrupted statement, where the values can be written.
fn values_of(session: &Session, tokens: &[Lexeme]) -> Vec<String> {
    let mut names: Vec<&str> = Vec::new();
    for lexeme in tokens {
        if let Token::Identifier(name) = &lexeme.token {
            names.push(name.as_str());
        }
    }
    names.sort_unstable();
    names.dedup();
    let written = |name: &&str| {
        let value = session.scope.get(name).filter(|_| session.scope.is_constant(name) == Some(false))?;
        Some(format!("{name} = {};", literal(value)?))
    };
    names.iter().filter_map(written).collect()
}

/// Returns step and time of every simulation.
pub fn positions(session: &Session) -> Vec<(usize, f64)> {
    let simulations = Simulations::of(&session.host);
    let simulations = simulations.0.borrow();
    simulations.iter().map(|simulation| simulation.position()).collect()
}

/// Returns statements that bring the simulations from an earlier to the present state.
fn steps_since(session: &Session, before: &[(usize, f64)]) -> Vec<String> {
    let simulations = Simulations::of(&session.host);
    let simulations = simulations.0.borrow();
    // A simulation that this entry made began at time zero.
    let before = before.iter().copied().chain(std::iter::repeat((0, 0.0)));
    let moved = simulations.iter().zip(before).filter(|(simulation, before)| simulation.position() != *before);
    moved
        .map(|(simulation, before)| {
            let (_, time) = simulation.position();
            let same = |value: &Dynamic| value.flatten_clone().try_cast::<SimulationHandle>().is_some_and(|other| other.is(simulation));
            match session.scope.iter_raw().find(|(name, _, value)| *name != ANSWER && same(value)) {
                Some((name, ..)) if time > before.1 => format!("{name}.run_to({time:?});"),
                _ => format!("// simulation \"{}\" came to t = {time:?}; no variable holds it any more", simulation.0.name),
            }
        })
        .collect()
}

/// Returns an entry with a semicolon at its end.
fn terminated(session: &Session, text: &str) -> String {
    match lexemes(session, text).last() {
        Some(last) if !matches!(last.token, Token::SemiColon) => {
            let (before, after) = text.split_at(last.range.end);
            format!("{before};{after}")
        }
        _ => text.to_string(),
    }
}

/// Returns an entry whose last value is assigned to `ANSWER`.
fn with_named_value(session: &Session, text: &str) -> String {
    let mut lexemes = lexemes(session, text);
    while lexemes.last().is_some_and(|last| matches!(last.token, Token::SemiColon)) {
        lexemes.pop();
    }
    let start = statements(&lexemes).last().map_or(0, |last| last.start);
    match (lexemes.get(start), lexemes.last()) {
        (Some(first), Some(last)) => {
            let (from, to) = (first.range.start, last.range.end);
            format!("{}let {ANSWER} = {};", &text[..from], &text[from..to])
        }
        _ => terminated(session, text),
    }
}

/// A text in tokens.
pub fn lexemes(session: &Session, text: &str) -> Vec<Lexeme> {
    scan::lexemes(&session.engine.borrow(), text)
}
