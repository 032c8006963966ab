//! A script in an editor: errors, meanings of names, completions.
//!
//! The text is never run. A check builds the models, as `conserva check` does, without steps; completion and hover show the values of the
//! last check. Places are bytes of the text.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use rhai::{AST, Engine, Scope};

use super::compile::{compile, constants};
use super::completion::{Candidate, KEYWORDS, Words};
use super::cursor::{Cursor, TextToken, TextTokenKind};
use super::declarations::{Declaration, Declarations, Role};
use super::formatting::formatted;
use super::imports::module_functions;
use super::inspection::{engine_functions, unknown_calls};
use super::reference::{Entry, Reference};
use super::session::Session;
use super::shown::{DIGITS, kind_of, shown};
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::explain::explain;
use crate::script::language::function::Form;
use crate::script::language::lint::lint;
use crate::script::language::observer::Observer;
use crate::script::language::registry::Registry;
use crate::script::language::settings::{Mode, Settings};
use crate::script::language::sources::SourceSpan;

/// Largest number of lines shown of a value.
const LINES: usize = 12;

/// Variables without a known value, with the type if known.
type Unknown = BTreeMap<String, Option<&'static str>>;

/// Observer that keeps the warnings.
#[derive(Default)]
struct Warnings(RefCell<Vec<Diagnostic>>);

impl Observer for Warnings {
    fn warn(&self, warning: &Diagnostic) {
        self.0.borrow_mut().push(warning.clone());
    }
}

/// Result of a check.
#[derive(Clone, Debug, Default)]
pub struct Checked {
    /// Errors and warnings.
    pub findings: Vec<Diagnostic>,
    /// Place of the first use of a result, after which only names were checked.
    pub stopped: Option<SourceSpan>,
}

/// Explanation of a name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Explained {
    /// Bytes of the name.
    pub range: Range<usize>,
    /// Explanation in Markdown.
    pub text: String,
}

/// A call around a place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Signature {
    /// Signature of the called function.
    pub label: String,
    /// Names of the parameters.
    pub parameters: Vec<String>,
    /// Number of the parameter at the place.
    pub active: usize,
    /// Summary of the function.
    pub summary: String,
}

/// A script in an editor.
pub struct Document {
    name: String,
    home: PathBuf,
    settings: Settings,
    text: Arc<str>,
    declarations: Declarations,
    /// Functions of the last text that compiled.
    tree: AST,
    /// Session that compiles texts and describes names.
    reader: Session,
    /// Warnings of the reader.
    warnings: Rc<Warnings>,
    of_engine: BTreeSet<String>,
    imports: Vec<(String, String)>,
    modules: BTreeMap<String, Vec<String>>,
    /// Session of the last check, with the values of the variables.
    checked: Option<Session>,
}

impl Document {
    /// An empty document with a name for messages, and the folder `home` of the files that it may read.
    ///
    /// # Errors
    /// A folder that does not exist.
    pub fn new(name: &str, home: &Path, settings: Settings) -> Result<Self, Box<Diagnostic>> {
        let settings = Settings { mode: Mode::Check, output: None, ..settings };
        let warnings = Rc::new(Warnings::default());
        let reader = Session::new(settings.clone(), home, warnings.clone())?;
        let of_engine = engine_functions(&reader.engine.borrow());
        Ok(Document {
            name: name.into(),
            home: home.into(),
            settings,
            text: "".into(),
            declarations: Declarations::default(),
            tree: AST::empty(),
            reader,
            warnings,
            of_engine,
            imports: Vec::new(),
            modules: BTreeMap::new(),
            checked: None,
        })
    }

    /// Text of the open script.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// True for a place in this text.
    pub fn is_own(&self, place: &SourceSpan) -> bool {
        place.source == self.name
    }

    /// True for a word of the language.
    pub fn is_keyword(&self, name: &str) -> bool {
        KEYWORDS.contains(&name)
    }

    /// Help of the reference on a name, in Markdown.
    pub fn help(&self, name: &str) -> Option<String> {
        let reference = Reference::new(&self.reader.registry());
        let entries = reference.find(name).ok()?;
        let texts: Vec<String> = entries.iter().take(2).map(|entry| reference.entry_markdown(entry)).collect();
        Some(texts.join("\n\n"))
    }

    /// Replaces the text; returns the errors found without building its models, and true if the text can be compiled.
    pub fn set_text(&mut self, text: &str) -> (Vec<Diagnostic>, bool) {
        self.text = text.into();
        self.declarations = Declarations::of(text);
        self.read_imports();
        let host = self.reader.host.clone();
        *host.main.borrow_mut() = self.name.clone();
        host.sources.insert(&self.name, text);
        let error = {
            let engine = self.reader.engine.borrow();
            match compile(&engine, &self.reader.scope, &self.name, text) {
                Ok(tree) => {
                    self.tree = tree;
                    None
                }
                Err(error) => Some(explain(&host, &engine, &error, &self.name)),
            }
        };
        let is_compiled = error.is_none();
        (error.into_iter().chain(self.inspected()).collect(), is_compiled)
    }

    fn read_imports(&mut self) {
        let modules = self.declarations.all.iter().filter(|declaration| declaration.role == Role::Module);
        let imports: Vec<(String, String)> =
            modules.map(|module| (module.name.clone(), self.text[module.value.clone()].trim_matches(['"', '`']).to_string())).collect();
        if imports != self.imports {
            let engine = self.reader.engine.borrow();
            let functions = |path: &str| module_functions(&engine, &self.reader.host.sandbox, path);
            self.modules = imports.iter().map(|(alias, path)| (alias.clone(), functions(path))).collect();
            drop(engine);
            self.imports = imports;
        }
    }

    fn place(&self, range: Range<usize>) -> SourceSpan {
        SourceSpan { source: self.name.clone(), text: self.text.clone(), range }
    }

    /// Errors found in the text alone.
    fn inspected(&self) -> Vec<Diagnostic> {
        let place = self.place(0..0);
        let mut found = unknown_calls(&self.reader.registry(), &self.of_engine, &self.declarations, &place);
        found.extend(self.words(self.text.len(), |words| words.unknown_keys(&place)));
        found
    }

    /// Builds the models of the text; takes no step, and writes nothing.
    pub fn check(&mut self) -> Checked {
        let warnings = Rc::new(Warnings::default());
        let (name, text) = (self.name.clone(), self.text.clone());
        let mut session = match Session::new(self.settings.clone(), &self.home, warnings.clone()) {
            Ok(session) => session,
            Err(error) => return Checked { findings: vec![*error], stopped: None },
        };
        let report = session.run_test(&name, &text, None);
        self.checked = Some(session);
        let mut findings: Vec<Diagnostic> = report.error.into_iter().collect();
        findings.extend(warnings.0.take());
        // A finding of the text at a place that the check has reported, with values, is left out.
        let is_told = |other: &Diagnostic| {
            let begin = |of: &Diagnostic| of.place.as_ref().map(|place| place.range.start);
            findings.iter().any(|known| begin(known) == begin(other))
        };
        let more: Vec<Diagnostic> = self.inspected().into_iter().filter(|other| !is_told(other)).collect();
        findings.extend(more);
        Checked { findings, stopped: report.stopped }
    }

    /// Warnings of a text that is not checked.
    pub fn linted(&self) -> Vec<Diagnostic> {
        let host = &self.reader.host;
        host.take_reported();
        lint(host, &self.reader.engine.borrow(), &self.name);
        self.warnings.0.take()
    }

    /// Calls `ask` with the names that are visible at a byte position.
    fn words<T>(&self, byte: usize, ask: impl FnOnce(&Words) -> T) -> T {
        let (engine, registry) = (self.reader.engine.borrow(), self.reader.registry());
        let (scope, mut unknown) = (self.known_values(byte), BTreeMap::new());
        for declaration in self.declarations.visible(byte).filter(|of| matches!(of.role, Role::Variable | Role::Parameter)) {
            if scope.contains(&declaration.name) && self.is_last(declaration) {
                unknown.remove(&declaration.name);
                continue;
            }
            let kind = self.names(&engine, &registry, &scope, &unknown).type_of(&self.text[declaration.value.clone()]);
            unknown.insert(declaration.name.clone(), kind);
        }
        ask(&self.names(&engine, &registry, &scope, &unknown))
    }

    fn names<'a>(&'a self, engine: &'a Engine, registry: &'a Registry, scope: &'a Scope<'static>, unknown: &'a Unknown) -> Words<'a> {
        let home = self.reader.host.sandbox.home();
        Words { engine, scope, unknown, registry, functions: &self.tree, modules: &self.modules, home }
    }

    /// True for the last variable of its name outside of all blocks: its value is that in the scope at the end.
    fn is_last(&self, declaration: &Declaration) -> bool {
        let last =
            self.declarations.all.iter().rfind(|other| other.is_global && other.role == Role::Variable && other.name == declaration.name);
        last.is_some_and(|last| last.range == declaration.range)
    }

    /// Values of the variables that are visible at a byte, from the last check.
    fn known_values(&self, byte: usize) -> Scope<'static> {
        let mut scope = constants();
        let Some(session) = &self.checked else { return scope };
        for declaration in self.declarations.visible(byte).filter(|declaration| self.is_last(declaration)) {
            if let Some(value) = session.scope.get(&declaration.name) {
                scope.push_dynamic(declaration.name.clone(), value.flatten_clone());
            }
        }
        scope
    }

    /// Returns the start of the word that ends at a byte, and its completions.
    pub fn complete(&self, byte: usize) -> (usize, Vec<Candidate>) {
        let before = &self.text[..byte];
        let (start, found) = self.words(byte, |words| words.complete(before));
        if !found.is_empty() {
            return (start, found);
        }
        let cursor = Cursor::new(before);
        let (start, word) = cursor.word();
        let end = cursor.pieces.len() - usize::from(!word.is_empty());
        let is_member = end.checked_sub(1).and_then(|index| cursor.kind(index)) == Some(TextTokenKind::Dot);
        if cursor.in_comment || cursor.in_string().is_some() || !is_member {
            return (start, Vec::new());
        }
        // For an object of unknown type the members of all types are listed.
        let registry = self.reader.registry();
        let members = registry.functions().iter().filter(|function| matches!(function.form, Form::Method(_) | Form::Property(_)));
        let members = members.filter(|function| function.name.starts_with(word));
        let mut found: Vec<Candidate> =
            members.map(|function| Candidate { text: function.name.to_string(), display: function.signature() }).collect();
        found.sort_by(|a, b| (&a.text, &a.display).cmp(&(&b.text, &b.display)));
        found.dedup_by(|a, b| a.text == b.text);
        (start, found)
    }

    /// Explanation of the name at a byte.
    pub fn hover(&self, byte: usize) -> Option<Explained> {
        let cursor = Cursor::new(&self.text);
        let is_here = |piece: &TextToken| piece.kind == TextTokenKind::Name && piece.range.start <= byte && byte <= piece.range.end;
        let index = cursor.pieces.iter().position(is_here);
        if let Some(number) = self.declarations.at(byte).filter(|_| index.is_none_or(|index| !self.is_method(&cursor, index))) {
            let here = self.declarations.occurrences(number).into_iter().find(|here| here.start <= byte && byte <= here.end)?;
            return Some(Explained { range: here, text: self.declaration_text(&self.declarations.all[number]) });
        }
        let index = index?;
        let range = cursor.pieces[index].range.clone();
        let name = cursor.slice(index);
        let key = self.words(range.end, |words| {
            let before = Cursor::new(&self.text[..range.end]);
            let (function, keys, _) = words.options(&before)?;
            let is_key = cursor.kind(index + 1) == Some(TextTokenKind::Sign(':'));
            let key = keys.iter().find(|key| is_key && key.name == name)?;
            Some(format!("`{name}` of `{}`: {}\n\n{}; default: {}", function.name, key.summary, key.requirement(), key.absent))
        });
        if let Some(text) = key {
            return Some(Explained { range, text });
        }
        let registry = self.reader.registry();
        let reference = Reference::new(&registry);
        if cursor.is_member(index) {
            let receiver = self.words(range.start, |words| words.type_name(&cursor, index - 1));
            let named = || registry.named(name).filter(|function| function.form.receiver().is_some());
            let of_type = named().find(|function| function.form.receiver().is_some_and(|of| Some(of.name) == receiver));
            let function = of_type.or_else(|| named().next())?;
            return Some(Explained { range, text: reference.entry_markdown(&Entry::Function(function.clone())) });
        }
        Some(Explained { range, text: self.help(name)? })
    }

    /// True for a member name of the language, which takes precedence over a function of the script.
    fn is_method(&self, cursor: &Cursor, index: usize) -> bool {
        let registry = self.reader.registry();
        cursor.is_member(index) && registry.named(cursor.slice(index)).any(|function| function.form.receiver().is_some())
    }

    fn declaration_text(&self, declaration: &Declaration) -> String {
        let name = &declaration.name;
        match declaration.role {
            Role::Function => {
                let comments = self.text[..declaration.range.start].rsplit('\n').skip(1);
                let comments: Vec<&str> = comments.map_while(|line| line.trim().strip_prefix("///")).map(str::trim).collect();
                let comments: Vec<&str> = comments.into_iter().rev().collect();
                format!("```rhai\nfn {name}{}\n```\n\n{}", &self.text[declaration.value.clone()], comments.join("\n"))
            }
            Role::Module => {
                let functions = self.modules.get(name).map(|functions| functions.join("\n")).unwrap_or_default();
                format!("```rhai\nimport {} as {name}\n```\n\n```rhai\n{functions}\n```", &self.text[declaration.value.clone()])
            }
            Role::Variable | Role::Parameter => match self.value_of(declaration) {
                Some((kind, value)) => format!("`{name}`: {kind}\n\n```text\n{value}\n```"),
                None => {
                    let kind = self.words(declaration.value.end.max(declaration.visible.start), |words| {
                        words.unknown.get(name).copied().flatten().filter(|kind| !kind.is_empty())
                    });
                    format!("`{name}`{}", kind.map(|kind| format!(": {kind}")).unwrap_or_default())
                }
            },
        }
    }

    /// Type and text of the value of a variable in the last check.
    fn value_of(&self, declaration: &Declaration) -> Option<(String, String)> {
        let session = self.checked.as_ref().filter(|_| self.is_last(declaration))?;
        let value = session.scope.get(&declaration.name)?.flatten_clone();
        let text = shown(&session.registry(), &value, Some(DIGITS));
        let mut lines: Vec<String> = text.lines().take(LINES).map(|line| line.chars().take(100).collect()).collect();
        if text.lines().count() > LINES {
            lines.push("…".into());
        }
        let engine = self.reader.engine.borrow();
        Some((kind_of(&engine, &value), lines.join("\n")))
    }

    /// The call around a byte.
    pub fn signature(&self, byte: usize) -> Option<Signature> {
        let cursor = Cursor::new(&self.text[..byte]);
        let level = cursor.levels.iter().rev().find(|level| level.bracket == '(' && cursor.callee(level).is_some())?;
        let name = cursor.slice(cursor.callee(level)?);
        let signature =
            |label: String, parameters: Vec<String>, summary: String| Signature { label, parameters, active: level.commas, summary };
        let of_language = self.words(byte, |words| {
            let function = words.called_at(&cursor, level)?;
            let parameters = function.parameters.iter().map(|parameter| parameter.name.to_string()).collect();
            Some(signature(function.signature(), parameters, function.summary.to_string()))
        });
        let own = || {
            let function = self.tree.iter_functions().find(|function| function.name == name)?;
            let parameters: Vec<String> = function.params.iter().map(ToString::to_string).collect();
            Some(signature(format!("{name}({})", parameters.join(", ")), parameters, String::new()))
        };
        of_language.or_else(own)
    }

    /// File (of a module) and bytes in it where the name at a byte is declared.
    pub fn definition(&self, byte: usize) -> Option<(Option<PathBuf>, Range<usize>)> {
        if let Some(number) = self.declarations.at(byte) {
            let declaration = &self.declarations.all[number];
            let is_declaration = declaration.range.start <= byte && byte <= declaration.range.end;
            if declaration.role == Role::Module && is_declaration {
                return Some((Some(self.module_file(&declaration.name)?), 0..0));
            }
            return Some((None, declaration.range.clone()));
        }
        let cursor = Cursor::new(&self.text);
        let index = cursor.pieces.iter().position(|piece| piece.range.start <= byte && byte <= piece.range.end)?;
        let alias = index.checked_sub(2).filter(|_| cursor.kind(index - 1) == Some(TextTokenKind::Path))?;
        let file = self.module_file(cursor.slice(alias))?;
        let text = crate::machine::files::read_text(&file).ok()?;
        let of_module = Declarations::of(&text);
        let function = of_module.all.iter().find(|of| of.role == Role::Function && of.name == cursor.slice(index))?;
        Some((Some(file), function.range.clone()))
    }

    fn module_file(&self, alias: &str) -> Option<PathBuf> {
        let (_, path) = self.imports.iter().find(|(known, _)| known == alias)?;
        self.reader.host.sandbox.module(path.strip_suffix(".rhai").unwrap_or(path)).ok()
    }

    /// Bytes of the name at a byte wherever it is declared and used in the text.
    pub fn occurrences(&self, byte: usize) -> Vec<Range<usize>> {
        self.declarations.at(byte).map(|number| self.declarations.occurrences(number)).unwrap_or_default()
    }

    /// Places of the name at a byte, all of which are renamed.
    ///
    /// # Errors
    /// An invalid name, or one that would change the meaning of the text; as a text.
    pub fn rename(&self, byte: usize, name: &str) -> Result<Vec<Range<usize>>, String> {
        let number = self.declarations.at(byte).ok_or("only variables, functions and modules of the script can be renamed")?;
        let is_word = name.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_');
        if !is_word || !name.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_') || name.trim_matches('_').is_empty() {
            return Err(format!("`{name}` is no name: write letters of a to z, digits and `_`"));
        }
        if KEYWORDS.contains(&name) || ["this", "global", "private", "do", "until", "export", "eval"].contains(&name) {
            return Err(format!("`{name}` is a word of the language"));
        }
        let declaration = &self.declarations.all[number];
        if declaration.role == Role::Function && (self.of_engine.contains(name) || self.reader.registry().named(name).next().is_some()) {
            return Err(format!("`{name}` is a function of the language"));
        }
        let places = self.declarations.occurrences(number);
        let mut renamed = self.text.to_string();
        for range in places.iter().rev() {
            renamed.replace_range(range.clone(), name);
        }
        let after = Declarations::of(&renamed);
        let pairs = |of: &Declarations| -> Vec<(usize, usize)> {
            let place = |range: &Range<usize>| {
                of.uses
                    .iter()
                    .map(|(range, _)| range)
                    .chain(of.all.iter().map(|of| &of.range))
                    .filter(|other| other.start < range.start)
                    .count()
            };
            of.uses.iter().map(|(range, number)| (place(range), place(&of.all[*number].range))).collect()
        };
        if after.unknown_calls.len() != self.declarations.unknown_calls.len() || pairs(&after) != pairs(&self.declarations) {
            return Err(format!("another `{name}` would be meant in some places, or this one hide it"));
        }
        Ok(places)
    }

    /// Functions, variables and modules outside of blocks, in the order of the text.
    pub fn outline(&self) -> Vec<(&str, Role, Range<usize>)> {
        let all = self.declarations.all.iter().filter(|of| of.is_global || of.role == Role::Function);
        all.map(|of| (of.name.as_str(), of.role, of.range.clone())).collect()
    }

    /// Text of the script with corrected indentation.
    pub fn formatted(&self) -> String {
        formatted(&self.text)
    }
}

/// Paths of the modules that a text imports.
pub fn imports_of(text: &str) -> Vec<String> {
    let declared = Declarations::of(text).all.into_iter().filter(|declaration| declaration.role == Role::Module);
    declared.map(|module| text[module.value].trim_matches(['"', '`']).trim_end_matches(".rhai").to_string()).collect()
}
