//! Completions at the cursor: names, members by type, keys of options, names inside strings, files; and the signature of a call.
//!
//! Without side effects: reads the scope, the registry and the folder of the session, and evaluates only properties of existing objects.

use std::collections::BTreeMap;
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use rhai::{AST, Array, Dynamic, Engine, Map, Scope};

use super::cursor::{Cursor, Level, TextTokenKind};
use super::help::topics;
use crate::dynamics::LedgerRow;
use crate::mesh::{MESH_ENDINGS, Mesh};
use crate::output::{Field, SETS, Unit, VIEWS};
use crate::script::api::meshes::handle::MeshHandle;
use crate::script::api::models::handle::{BodyHandle, ModelHandle};
use crate::script::api::simulations::handle::SimulationHandle;
use crate::script::api::simulations::history::HistoryHandle;
use crate::script::language::function::{Form, Function};
use crate::script::language::parameter::{Kind, Parameter};
use crate::script::language::registry::Registry;

/// A completion at the cursor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Candidate {
    /// Text that is inserted.
    pub text: String,
    /// Text in the list of candidates.
    pub display: String,
}

/// Words of the language.
pub const KEYWORDS: [&str; 20] = [
    "let", "const", "fn", "if", "else", "for", "in", "while", "loop", "break", "continue", "return", "import", "as", "true", "false",
    "try", "catch", "throw", "switch",
];

/// Names that are known at the cursor.
pub struct Words<'a> {
    /// The engine.
    pub engine: &'a Engine,
    /// Variables.
    pub scope: &'a Scope<'static>,
    /// Variables without a known value, with the type if known.
    pub unknown: &'a BTreeMap<String, Option<&'static str>>,
    /// Functions of the language.
    pub registry: &'a Registry,
    /// Functions of the session.
    pub functions: &'a AST,
    /// Functions of imported modules by alias, each with its parameters.
    pub modules: &'a BTreeMap<String, Vec<String>>,
    /// The folder of the session.
    pub home: &'a Path,
}

/// Value or type of an expression, as far as known without evaluation.
pub(super) enum Known {
    /// A value.
    Value(Dynamic),
    /// The name of a type.
    Type(&'static str),
    /// Neither value nor type is known.
    Nothing,
}

impl Words<'_> {
    /// Returns the start of the completed word, and its completions.
    pub fn complete(&self, before: &str) -> (usize, Vec<Candidate>) {
        let cursor = Cursor::new(before);
        if cursor.in_comment {
            return (before.len(), Vec::new());
        }
        if let Some(start) = cursor.in_string() {
            let written = &before[start..];
            let folder = written.rfind('/').map_or(0, |slash| slash + 1);
            let names = self.in_string(&cursor, written);
            let is_file = names.iter().any(|name| name.contains('/')) || folder > 0;
            let matching = names.into_iter().filter(|name| name.starts_with(written));
            let listed = |name: &str| if is_file { name[folder.min(name.len())..].to_string() } else { name.to_string() };
            return (start, matching.map(|name| Candidate { display: listed(&name), text: name }).collect());
        }
        let (start, word) = cursor.word();
        let mut found = self.names(&cursor, !word.is_empty());
        found.retain(|candidate| candidate.text.starts_with(word));
        found.sort_by(|a, b| a.text.cmp(&b.text));
        found.dedup_by(|a, b| a.text == b.text);
        (start, found)
    }

    fn names(&self, cursor: &Cursor, has_word: bool) -> Vec<Candidate> {
        let end = cursor.pieces.len() - usize::from(has_word);
        let previous = end.checked_sub(1).and_then(|index| cursor.kind(index));
        if previous == Some(TextTokenKind::Dot) {
            return self.members(cursor, end - 1);
        }
        if previous == Some(TextTokenKind::Path) {
            let alias = end.checked_sub(2).map_or("", |index| cursor.slice(index));
            let functions = self.modules.get(alias).into_iter().flatten();
            return functions.map(|signature| script_function(signature)).collect();
        }
        if previous == Some(TextTokenKind::Number) && !has_word {
            return Vec::new();
        }
        if let Some((_, keys, level)) = self.options(cursor) {
            let is_key = level.key.is_none() && matches!(previous, Some(TextTokenKind::Open('#') | TextTokenKind::Sign(',')));
            if is_key {
                let free = keys.iter().filter(|key| !level.keys.iter().any(|written| written == key.name));
                return free
                    .map(|key| Candidate { text: format!("{}: ", key.name), display: format!("{}: {}", key.name, key.requirement()) })
                    .collect();
            }
        }
        let plain = |name: &str| Candidate { text: name.to_string(), display: name.to_string() };
        let variables = self.scope.iter_raw().map(|(name, _, _)| plain(name)).chain(self.unknown.keys().map(|name| plain(name)));
        let modules = self.modules.keys().map(|alias| Candidate { text: format!("{alias}::"), display: format!("{alias}::") });
        let own = self.functions.iter_functions().filter(|function| !function.name.starts_with("anon$"));
        let own = own.map(|function| script_function(&format!("{}({})", function.name, function.params.join(", "))));
        let language = self.registry.functions().iter().filter(|function| function.form == Form::Function).map(|f| called(f));
        let keywords = KEYWORDS.into_iter().map(plain);
        let builtin =
            ["print(", "debug(", "type_of("].into_iter().map(|name| Candidate { text: name.into(), display: format!("{name}value)") });
        variables.chain(modules).chain(own).chain(language).chain(builtin).chain(keywords).collect()
    }

    /// Returns the members of the expression in front of the dot.
    fn members(&self, cursor: &Cursor, dot: usize) -> Vec<Candidate> {
        let plain = |name: String| Candidate { text: name.clone(), display: name };
        let known = self.resolve(cursor, dot);
        let mut found = Vec::new();
        let type_name = match &known {
            Known::Value(value) => {
                if let Some(map) = value.read_lock::<Map>() {
                    found.extend(map.keys().map(|key| plain(key.to_string())));
                }
                if let Some(history) = value.clone().try_cast::<HistoryHandle>() {
                    found.extend(history.0.columns().into_iter().map(|name| plain(name.to_string())));
                }
                if !self.registry.types().contains(self.engine.map_type_name(value.type_name())) {
                    found.extend(self.builtin_members(value));
                }
                if value.is_array() {
                    found.extend(self.of_arrays());
                }
                self.engine.map_type_name(value.type_name()).to_string()
            }
            Known::Type(name) => name.to_string(),
            Known::Nothing => return Vec::new(),
        };
        if type_name == "History" && found.is_empty() {
            found.extend(LedgerRow::columns(2).into_iter().map(|column| plain(column.name.to_string())));
        }
        found.extend(self.registry.members(&type_name).filter(|function| !matches!(function.form, Form::Column(_))).map(|f| called(f)));
        found
    }

    /// Methods that the engine itself has for arrays, strings, maps and numbers.
    fn builtin_members(&self, value: &Dynamic) -> Vec<Candidate> {
        let id = value.type_id();
        let of_type = |function: rhai::FuncInfo| {
            let data = function.metadata;
            let is_name = data.name.starts_with(|first: char| first.is_ascii_lowercase());
            (is_name && !data.name.contains('$') && data.param_types.first() == Some(&id)).then(|| {
                let more = data.params_info.iter().skip(1).take(data.num_params.saturating_sub(1));
                let names: Vec<&str> = more.map(|parameter| parameter.split(':').next().unwrap_or("")).collect();
                (data.name.to_string(), names.join(", "))
            })
        };
        let functions: Vec<(String, String)> = self.engine.collect_fn_metadata(None, of_type, true);
        functions
            .into_iter()
            .map(|(name, names)| Candidate {
                text: if names.is_empty() { format!("{name}()") } else { format!("{name}(") },
                display: format!("{name}({names})"),
            })
            .collect()
    }

    /// Functions of the language with an array as only argument, which can be called as methods.
    fn of_arrays(&self) -> impl Iterator<Item = Candidate> {
        let takes_an_array = |function: &&Rc<Function>| {
            function.form == Form::Function && matches!(function.parameters.as_slice(), [only] if only.kind == Kind::Array)
        };
        let member = |function: &Rc<Function>| {
            let text = format!("{}()", function.name);
            Candidate { display: text.clone(), text }
        };
        self.registry.functions().iter().filter(takes_an_array).map(member)
    }

    /// Returns the value or type of the expression that ends before token `end`.
    pub(super) fn resolve(&self, cursor: &Cursor, end: usize) -> Known {
        let Some(last) = end.checked_sub(1) else { return Known::Nothing };
        match cursor.kind(last) {
            Some(TextTokenKind::Name) if cursor.is_member(last) => match self.resolve(cursor, last - 1) {
                Known::Value(value) => self.property_of(&value, cursor.slice(last)),
                Known::Type(name) => self.returned(name, cursor.slice(last)),
                Known::Nothing => Known::Nothing,
            },
            Some(TextTokenKind::Name) => match (self.scope.get(cursor.slice(last)), self.unknown.get(cursor.slice(last))) {
                (_, Some(kind)) => kind.map_or(Known::Nothing, Known::Type),
                (Some(value), None) => Known::Value(value.flatten_clone()),
                (None, None) => Known::Nothing,
            },
            Some(TextTokenKind::Text { closed: true }) => Known::Value("".into()),
            Some(TextTokenKind::Close(']')) => {
                let before = cursor.opening(last).and_then(|open| open.checked_sub(1)).and_then(|before| cursor.kind(before));
                let is_indexed = matches!(before, Some(TextTokenKind::Name | TextTokenKind::Close(_) | TextTokenKind::Text { .. }));
                if is_indexed { Known::Nothing } else { Known::Value(Dynamic::from(Array::new())) }
            }
            Some(TextTokenKind::Close(')')) => {
                let Some(name) = cursor.opening(last).and_then(|open| open.checked_sub(1)) else { return Known::Nothing };
                if cursor.kind(name) != Some(TextTokenKind::Name) {
                    return Known::Nothing;
                }
                if !cursor.is_member(name) {
                    let function = self.registry.named(cursor.slice(name)).find(|function| function.form == Form::Function);
                    return function.map_or(Known::Nothing, |function| Known::Type(function.returns));
                }
                match self.resolve(cursor, name - 1) {
                    Known::Value(value) => self.returned(self.engine.map_type_name(value.type_name()), cursor.slice(name)),
                    Known::Type(type_name) => self.returned(type_name, cursor.slice(name)),
                    Known::Nothing => Known::Nothing,
                }
            }
            _ => Known::Nothing,
        }
    }

    fn property_of(&self, value: &Dynamic, name: &str) -> Known {
        if let Some(map) = value.read_lock::<Map>() {
            return map.get(name).map_or(Known::Nothing, |entry| Known::Value(entry.flatten_clone()));
        }
        let type_name = self.engine.map_type_name(value.type_name());
        let is_property = |function: &&Rc<Function>| matches!(function.form, Form::Property(_)) && function.name == name;
        if !self.registry.members(type_name).any(|function| is_property(&function)) {
            return self.returned(type_name, name);
        }
        let mut scope = Scope::new();
        scope.push_dynamic("object", value.clone());
        match self.engine.eval_expression_with_scope::<Dynamic>(&mut scope, &format!("object.{name}")) {
            Ok(value) => Known::Value(value),
            Err(_) => self.returned(type_name, name),
        }
    }

    fn returned(&self, type_name: &str, member: &str) -> Known {
        let found = self.registry.members(type_name).find(|function| function.name == member);
        found.map_or(Known::Nothing, |function| Known::Type(function.returns))
    }

    /// Returns the function whose call is open at a level.
    pub(super) fn called_at(&self, cursor: &Cursor, level: &Level) -> Option<&Function> {
        let name = cursor.callee(level)?;
        let functions = self.registry.functions().iter().map(|function| &**function);
        let mut named = functions.filter(|function| function.name == cursor.slice(name));
        if !cursor.is_member(name) {
            return named.find(|function| function.form == Form::Function);
        }
        let type_name = match self.resolve(cursor, name - 1) {
            Known::Value(value) => self.engine.map_type_name(value.type_name()).to_string(),
            Known::Type(name) => name.to_string(),
            Known::Nothing => String::new(),
        };
        let methods: Vec<&Function> = named.filter(|function| matches!(function.form, Form::Method(_))).collect();
        let of_type = methods.iter().find(|function| function.form.receiver().is_some_and(|receiver| receiver.name == type_name));
        of_type.or(methods.first()).copied()
    }

    /// The function and the keys of the options map in which the cursor is.
    pub(super) fn options<'c>(&self, cursor: &'c Cursor) -> Option<(&Function, &[Parameter], &'c Level)> {
        let [.., call, map] = cursor.levels.as_slice() else { return None };
        let function = self.called_at(cursor, call).filter(|_| map.bracket == '#')?;
        function.parameters.get(call.commas)?.kind.keys().map(|keys| (function, keys, map))
    }

    fn objects<T: Clone + 'static>(&self) -> Vec<T> {
        self.scope.iter_raw().filter_map(|(_, _, value)| value.flatten_clone().try_cast::<T>()).collect()
    }

    /// Possible names in a string at the cursor.
    fn in_string(&self, cursor: &Cursor, written: &str) -> Vec<String> {
        let string = cursor.pieces.len() - 1;
        if string.checked_sub(1).is_some_and(|before| cursor.kind(before) == Some(TextTokenKind::Name) && cursor.slice(before) == "import")
        {
            return self.files(written, &["rhai"]).into_iter().map(|name| name.trim_end_matches(".rhai").to_string()).collect();
        }
        if let Some(columns) = self.columns_at(cursor, string) {
            return columns;
        }
        let choices = |kind: &Kind| match kind {
            Kind::Choice(words) => Some(words.iter().map(ToString::to_string).collect::<Vec<_>>()),
            _ => None,
        };
        if let Some((_, keys, level)) = self.options(cursor) {
            let key = level.key.as_ref().and_then(|written| keys.iter().find(|key| key.name == written));
            if let Some(words) = key.and_then(|key| choices(&key.kind)) {
                return words;
            }
        }
        // The innermost call determines the names, also for a string inside an array.
        let call = cursor.levels.iter().rev().find(|level| level.bracket == '(');
        let Some((level, function)) = call.and_then(|level| Some((level, self.called_at(cursor, level)?))) else { return self.all_names() };
        if let Some(words) = function.parameters.get(level.commas).and_then(|parameter| choices(&parameter.kind)) {
            return words;
        }
        let receiver = || match cursor.callee(level).filter(|&name| cursor.is_member(name)).map(|name| self.resolve(cursor, name - 1)) {
            Some(Known::Value(value)) => value,
            _ => Dynamic::UNIT,
        };
        match function.name {
            "help" => self.registry.functions().iter().map(|function| function.name.to_string()).chain(topics()).collect(),
            "read_mesh" => self.files(written, &MESH_ENDINGS),
            "boundary" => match mesh_of(&receiver()) {
                Some(mesh) => boundaries(&mesh),
                None => self.meshes().iter().flat_map(|(_, mesh)| boundaries(mesh)).collect(),
            },
            "part" => match mesh_of(&receiver()) {
                Some(mesh) => mesh.parts.iter().map(|(name, _)| name.clone()).collect(),
                None => Vec::new(),
            },
            "contact" | "expect_contact" => {
                let simulations = match receiver().try_cast::<SimulationHandle>() {
                    Some(simulation) => vec![simulation],
                    None => self.objects::<SimulationHandle>(),
                };
                simulations.iter().flat_map(|handle| handle.0.model.model.contact_names().into_iter().map(String::from)).collect()
            }
            // The last parameter of `quantity` and `in_unit`, any of `units`.
            "units" | "quantity" | "in_unit" => unit_names(written, function.name == "units"),
            "result" if level.commas == 2 => unit_names(written, false),
            "picture" if level.commas > 0 => Field::names().into_iter().chain(VIEWS).map(String::from).collect(),
            // Columns are named by the axes, too.
            "plot" | "plot_curves" | "show"
                if level.commas >= function.parameters.iter().take_while(|other| other.name == "path").count() =>
            {
                let columns = receiver().try_cast::<SimulationHandle>().map(|simulation| simulation.columns());
                columns.unwrap_or_else(|| LedgerRow::columns(2).iter().map(|column| column.name.to_string()).collect())
            }
            _ => self.all_names(),
        }
    }

    /// Columns of the history in whose brackets the string is: `history["`.
    fn columns_at(&self, cursor: &Cursor, string: usize) -> Option<Vec<String>> {
        let bracket = string.checked_sub(1).filter(|bracket| cursor.kind(*bracket) == Some(TextTokenKind::Open('[')))?;
        match self.resolve(cursor, bracket) {
            Known::Value(value) => {
                let history = value.try_cast::<HistoryHandle>()?;
                Some(history.0.columns().into_iter().map(|name| name.to_string()).collect())
            }
            Known::Type("History") => Some(LedgerRow::columns(2).iter().map(|column| column.name.to_string()).collect()),
            Known::Type(_) | Known::Nothing => None,
        }
    }

    /// Returns the meshes in scope, with the names of their bodies.
    fn meshes(&self) -> Vec<(String, Arc<Mesh>)> {
        let models = self.objects::<ModelHandle>();
        let mut found: Vec<_> = models
            .iter()
            .flat_map(|model| model.0.borrow().model.bodies.iter().map(|body| (body.name.clone(), body.mesh.clone())).collect::<Vec<_>>())
            .collect();
        found.extend(self.objects::<BodyHandle>().iter().map(|body| body.definition()).map(|body| (body.name, body.mesh)));
        found.extend(self.objects::<MeshHandle>().iter().map(|mesh| (String::new(), mesh.mesh())));
        found
    }

    /// Names of all bodies, boundaries and contacts.
    fn all_names(&self) -> Vec<String> {
        let meshes = self.meshes();
        let mut names: Vec<String> = meshes.iter().map(|(body, _)| body.clone()).filter(|name| !name.is_empty()).collect();
        names.extend(meshes.iter().flat_map(|(_, mesh)| boundaries(mesh)));
        for model in self.objects::<ModelHandle>() {
            names.extend(model.0.borrow().model.contact_names().into_iter().map(String::from));
        }
        names.sort();
        names.dedup();
        names
    }

    /// Returns files with an extension, and folders, below the session's folder, with paths as written in a script.
    fn files(&self, written: &str, endings: &[&str]) -> Vec<String> {
        let folder = written.rfind('/').map_or("", |slash| &written[..=slash]);
        let Ok(entries) = std::fs::read_dir(self.home.join(folder)) else { return Vec::new() };
        let mut names: Vec<String> = entries
            .flatten()
            .filter_map(|entry| {
                let name = entry.file_name().to_string_lossy().into_owned();
                match entry.path().is_dir() {
                    _ if name.starts_with('.') => None,
                    true => Some(format!("{folder}{name}/")),
                    false => name.rsplit('.').next().is_some_and(|ending| endings.contains(&ending)).then(|| format!("{folder}{name}")),
                }
            })
            .collect();
        names.sort();
        names
    }

    /// Returns the rest of the signature of the call at the end of the text `before`, or the description of values of a key.
    pub fn hint(&self, before: &str) -> Option<String> {
        let cursor = Cursor::new(before);
        if cursor.in_comment || cursor.in_string().is_some() {
            return None;
        }
        let last = cursor.pieces.last().map(|piece| piece.kind)?;
        let gap = if before.ends_with(' ') { "" } else { " " };
        if let Some((_, keys, level)) = self.options(&cursor) {
            if let Some(written) = &level.key {
                let key = keys.iter().find(|key| key.name == written)?;
                return (last == TextTokenKind::Sign(':')).then(|| format!("{gap}{}", key.requirement()));
            }
            let free = keys.iter().filter(|key| !level.keys.iter().any(|written| written == key.name)).map(parameter_name);
            let free = free.collect::<Vec<_>>().join(", ");
            return matches!(last, TextTokenKind::Open('#') | TextTokenKind::Sign(',')).then(|| format!("{gap}{free} }})"));
        }
        let level = cursor.levels.last()?;
        if !matches!(last, TextTokenKind::Open('(') | TextTokenKind::Sign(',')) {
            return None;
        }
        let gap = if last == TextTokenKind::Open('(') { "" } else { gap };
        if let Some(function) = self.called_at(&cursor, level) {
            let rest: Vec<String> = function.parameters.iter().skip(level.commas).map(parameter_name).collect();
            return Some(format!("{gap}{})", rest.join(", ")));
        }
        let name = cursor.callee(level).filter(|&name| !cursor.is_member(name)).map(|name| cursor.slice(name))?;
        let own = self.functions.iter_functions().find(|function| function.name == name)?;
        Some(format!("{gap}{})", own.params.into_iter().skip(level.commas).collect::<Vec<_>>().join(", ")))
    }
}

fn parameter_name(parameter: &Parameter) -> String {
    let name = match &parameter.kind {
        Kind::Options(keys) | Kind::OpenOptions(keys) => {
            format!("#{{ {} }}", keys.iter().map(parameter_name).collect::<Vec<_>>().join(", "))
        }
        _ => parameter.name.to_string(),
    };
    if parameter.is_optional() { format!("{name}?") } else { name }
}

/// Returns the completion of a function or property.
fn called(function: &Function) -> Candidate {
    let signature = function.signature();
    let display =
        if function.form.receiver().is_some() { signature.split_once('.').map_or("", |(_, rest)| rest).into() } else { signature };
    let text = match (function.form, function.parameters.first().map(|parameter| &parameter.kind)) {
        (Form::Property(_) | Form::Column(_), _) => function.name.to_string(),
        (_, None) => format!("{}()", function.name),
        (_, Some(Kind::Options(_) | Kind::OpenOptions(_))) => format!("{}(#{{ ", function.name),
        _ => format!("{}(", function.name),
    };
    Candidate { text, display }
}

fn script_function(signature: &str) -> Candidate {
    let name = signature.split('(').next().unwrap_or(signature);
    let text = if signature.ends_with("()") { signature.to_string() } else { format!("{name}(") };
    Candidate { text, display: signature.to_string() }
}

/// Units that may follow what is written of an expression of units, and the sets.
fn unit_names(written: &str, with_sets: bool) -> Vec<String> {
    let sets = SETS.iter().map(|(name, _)| name.to_string()).chain(["mm-N-t", "mm-kg-ms"].map(String::from)).filter(|_| with_sets);
    let begun = written.rfind(['*', '/', '(', '-']).map_or("", |last| &written[..=last]);
    sets.chain(Unit::names().into_iter().map(|name| format!("{begun}{name}"))).collect()
}

fn mesh_of(value: &Dynamic) -> Option<Arc<Mesh>> {
    let body = value.clone().try_cast::<BodyHandle>().map(|body| body.definition().mesh);
    body.or_else(|| value.clone().try_cast::<MeshHandle>().map(|mesh| mesh.mesh()))
}

fn boundaries(mesh: &Mesh) -> Vec<String> {
    mesh.boundaries.iter().map(|boundary| boundary.name.clone()).collect()
}
