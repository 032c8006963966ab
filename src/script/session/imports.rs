//! Imports at the prompt, which stay valid for the whole session.
//!
//! An import of the engine is limited to its text, so every import is repeated in the blank lines in front of each entry, at its own place.

use std::collections::BTreeMap;

use rhai::{Engine, FnAccess, Token};

use super::compile::constants;
use crate::machine::files;
use crate::script::language::sandbox::Sandbox;
use crate::script::language::scan;

/// An import of the session.
struct Import {
    /// Line and column (from 0) in the whole session.
    line: usize,
    column: usize,
    text: String,
    alias: String,
}

/// Imports of a session, and the functions of their modules.
#[derive(Default)]
pub struct Imports {
    imports: Vec<Import>,
    modules: BTreeMap<String, Vec<String>>,
}

impl Imports {
    /// Signatures of the functions of modules by alias.
    pub fn modules(&self) -> &BTreeMap<String, Vec<String>> {
        &self.modules
    }

    /// Returns all imports in one line.
    pub fn line(&self) -> String {
        self.imports.iter().map(|import| import.text.as_str()).collect()
    }

    /// Blank lines with the imports at their original places.
    pub fn padding(&self, lines: usize) -> String {
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

    /// Adds the imports of an entry outside of any block.
    pub fn keep(&mut self, engine: &Engine, sandbox: &Sandbox, first_line: usize, text: &str) {
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
                    self.modules.insert(alias.to_string(), module_functions(engine, sandbox, path));
                }
                _ => {}
            }
        }
    }
}

/// Signatures of the functions of a module's file.
pub(super) fn module_functions(engine: &Engine, sandbox: &Sandbox, path: &str) -> Vec<String> {
    let path = path.strip_suffix(".rhai").unwrap_or(path);
    let text = sandbox.module(path).ok().and_then(|file| files::read_text(&file).ok());
    let Some(Ok(tree)) = text.map(|text| engine.compile_with_scope(&constants(), text)) else { return Vec::new() };
    let named = tree.iter_functions().filter(|function| !function.name.starts_with("anon$") && function.access == FnAccess::Public);
    named.map(|function| format!("{}({})", function.name, function.params.join(", "))).collect()
}
