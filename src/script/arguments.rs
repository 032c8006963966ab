//! Reads the arguments of a call: one place for conversion, ranges, unknown and missing keys.
//!
//! Numbers may be written `1` or `1.0`, points are arrays. Unknown keys are refused before missing ones are named, because a misspelt
//! key is both. A value of the wrong type is described in the words of the language.

use std::collections::BTreeSet;
use std::rc::Rc;

use rhai::{Array, Dynamic, Engine, EvalAltResult, FnPtr, Map, NativeCallContext, Position};

use super::callback::Callback;
use super::failure::{Class, Failure, did_you_mean, listed};
use super::host::Host;
use super::registry::{Absent, Function, Handle, Kind, Parameter, number_text};
use super::scan::Target;
use super::sources::Place;
use super::time_functions::{self, TimeFunctionHandle};
use crate::math::catalogue::Interval;

/// One call of a script function.
pub struct Call<'a> {
    /// The engine's context of the call.
    pub context: &'a NativeCallContext<'a>,
    /// The called function.
    pub function: &'a Function,
    /// What the script may reach.
    pub host: &'a Rc<Host>,
    values: Vec<Dynamic>,
}

/// Arguments by name: those of a call, or the keys of an options map.
pub trait Arguments {
    /// The argument of that name, given or not.
    fn argument(&self, name: &str) -> Argument<'_>;

    /// A number (or its default).
    fn number(&self, name: &str) -> Result<f64, Failure> {
        self.argument(name).number()
    }

    /// A number, if given.
    fn optional_number(&self, name: &str) -> Result<Option<f64>, Failure> {
        let argument = self.argument(name);
        if argument.is_given() { argument.number().map(Some) } else { Ok(None) }
    }

    /// A whole number (or its default).
    fn integer(&self, name: &str) -> Result<i64, Failure> {
        self.argument(name).integer()
    }

    /// A truth value (or its default).
    fn flag(&self, name: &str) -> Result<bool, Failure> {
        self.argument(name).flag()
    }

    /// A string (or its default).
    fn text(&self, name: &str) -> Result<String, Failure> {
        self.argument(name).text()
    }

    /// An object.
    fn handle<T: Handle>(&self, name: &str) -> Result<T, Failure> {
        self.argument(name).handle()
    }
}

impl<'a> Call<'a> {
    /// A call with its values, the object of a method first.
    pub fn new(context: &'a NativeCallContext<'a>, function: &'a Function, values: Vec<Dynamic>, host: &'a Rc<Host>) -> Self {
        Call { context, function, host, values }
    }

    /// The object of a method.
    pub fn receiver<T: Handle>(&self) -> T {
        self.values[0].clone().cast::<T>()
    }

    /// The engine.
    pub fn engine(&self) -> &Engine {
        self.context.engine()
    }

    /// A failure of this call.
    pub fn fail(&self, title: impl Into<String>) -> Failure {
        Failure::script(title).in_method(self.function.form.receiver().is_some())
    }

    /// Position of the call in its source.
    pub fn position(&self) -> Position {
        self.context.call_position()
    }

    /// Name of the source in which the call stands.
    pub fn source(&self) -> String {
        self.context.call_source().unwrap_or_default().to_string()
    }

    /// The place of the call, or of a part of it.
    pub fn place(&self, target: &Target) -> Option<Place> {
        self.host.place(self.engine(), &self.source(), self.position(), target, self.function.form.receiver().is_some())
    }

    /// A closure together with what is needed to call it after this call has returned.
    pub fn callback(&self, name: &str) -> Result<Callback, Failure> {
        let argument = self.argument(name);
        match argument.value.as_ref().and_then(|value| value.read_lock::<FnPtr>().map(|function| function.clone())) {
            Some(function) => Ok(Callback::new(self, function)),
            None => Err(argument.wrong_type()),
        }
    }

    /// Checks the keys of options maps: unknown ones first, then missing ones.
    ///
    /// # Errors
    /// The first wrong key.
    pub fn check(&self) -> Result<(), Box<EvalAltResult>> {
        for (index, parameter) in self.function.parameters.iter().enumerate() {
            let (Kind::Options(keys), Some(value)) = (&parameter.kind, self.value(index)) else { continue };
            let Some(map) = value.read_lock::<Map>() else { return Err(self.argument(parameter.name).wrong_type().into()) };
            self.check_keys(index, keys, &map)?;
        }
        Ok(())
    }

    fn check_keys(&self, index: usize, keys: &[Parameter], map: &Map) -> Result<(), Failure> {
        let title = self.function.title();
        let names: Vec<&str> = keys.iter().map(|key| key.name).collect();
        if let Some(unknown) = map.keys().find(|key| !names.contains(&key.as_str())) {
            let free = names.iter().copied().filter(|name| !map.contains_key(*name));
            let suggestion = did_you_mean(unknown, free).or_else(|| did_you_mean(unknown, names.iter().copied()));
            let failure = self
                .fail(format!("{title} has no option `{unknown}`"))
                .at(Target::Key { argument: index, key: unknown.to_string(), value: false })
                .label("unknown option")
                .cause(format!("its options are {}", listed(&names, "and")));
            return Err(match suggestion {
                Some(suggestion) => failure.hint(suggestion),
                None => failure.hint("remove the option, or look up its name in the list above"),
            });
        }
        for key in keys {
            if let (Kind::Options(inner), Some(value)) = (&key.kind, map.get(key.name)) {
                let target = Target::Key { argument: index, key: key.name.into(), value: true };
                match value.read_lock::<Map>() {
                    Some(map) => self.check_nested(key, inner, &map, target)?,
                    None => {
                        let given = describe(self.engine(), value);
                        let failure = self.fail(format!("`{}` of {title} must be {}", key.name, key.requirement())).at(target);
                        return Err(failure.label(format!("this is {given}")).hint(format!("write `{}: #{{ name: value, … }}`", key.name)));
                    }
                }
            }
        }
        let missing: Vec<&Parameter> = keys.iter().filter(|key| !key.is_optional() && !map.contains_key(key.name)).collect();
        let Some(first) = missing.first().copied() else { return Ok(()) };
        let missing_names: Vec<&str> = missing.iter().map(|key| key.name).collect();
        let mut failure = self
            .fail(format!("{title} needs the option{} {}", if missing.len() == 1 { "" } else { "s" }, listed(&missing_names, "and")))
            .at(Target::Argument(index))
            .label(format!("`{}` is missing", first.name));
        for key in missing {
            failure = failure.cause(format!("`{}`: {}, {}", key.name, key.summary, key.requirement()));
        }
        Err(failure.hint(format!("write `{}(#{{ {}: …, … }})`", self.function.name, first.name)))
    }

    /// Checks the keys of a map inside an options map; all of them are optional.
    fn check_nested(&self, outer: &Parameter, keys: &[Parameter], map: &Map, target: Target) -> Result<(), Failure> {
        let names: Vec<&str> = keys.iter().map(|key| key.name).collect();
        let Some(unknown) = map.keys().find(|key| !names.contains(&key.as_str())) else { return Ok(()) };
        let failure = self.fail(format!("`{}` of {} has no entry `{unknown}`", outer.name, self.function.title())).at(target);
        let failure = failure.label(format!("`{unknown}` is unknown")).cause(format!("its entries are {}", listed(&names, "and")));
        Err(failure.hint(did_you_mean(unknown, names.iter().copied()).unwrap_or_else(|| "remove the entry".into())))
    }

    fn value(&self, index: usize) -> Option<&Dynamic> {
        self.values.get(index + usize::from(self.function.form.receiver().is_some()))
    }

    /// The options map of that name.
    ///
    /// # Errors
    /// Something else was given.
    pub fn options(&self, name: &str) -> Result<Options<'_>, Failure> {
        let index = self.index(name);
        let Kind::Options(keys) = &self.function.parameters[index].kind else {
            panic!("`{name}` of `{}` is declared as options", self.function.name)
        };
        let map = match self.value(index) {
            None => Map::new(),
            Some(value) => value.read_lock::<Map>().map(|map| map.clone()).ok_or_else(|| self.argument(name).wrong_type())?,
        };
        Ok(Options { call: self, argument: index, keys, map, within: None })
    }

    fn index(&self, name: &str) -> usize {
        let found = self.function.parameters.iter().position(|parameter| parameter.name == name);
        found.unwrap_or_else(|| panic!("`{}` declares a parameter `{name}`", self.function.name))
    }
}

impl Arguments for Call<'_> {
    fn argument(&self, name: &str) -> Argument<'_> {
        let index = self.index(name);
        Argument {
            call: self,
            parameter: &self.function.parameters[index],
            target: Target::Argument(index),
            value: self.value(index).cloned(),
        }
    }
}

/// The keys of an options map.
pub struct Options<'a> {
    call: &'a Call<'a>,
    argument: usize,
    keys: &'a [Parameter],
    map: Map,
    /// The key whose value this map is, inside another.
    within: Option<&'static str>,
}

impl<'a> Options<'a> {
    /// The map that is the value of a key; empty when it is not given.
    ///
    /// # Errors
    /// Something else was given.
    pub fn nested(&self, name: &str) -> Result<Options<'a>, Failure> {
        let key = self.keys.iter().find(|key| key.name == name);
        let Some((key, Kind::Options(inner))) = key.map(|key| (key, &key.kind)) else {
            panic!("`{name}` of `{}` is declared as options", self.call.function.name)
        };
        let map = match self.map.get(name) {
            None => Map::new(),
            Some(value) => value.read_lock::<Map>().map(|map| map.clone()).ok_or_else(|| self.argument(name).wrong_type())?,
        };
        Ok(Options { call: self.call, argument: self.argument, keys: inner, map, within: Some(key.name) })
    }
}

impl Arguments for Options<'_> {
    fn argument(&self, name: &str) -> Argument<'_> {
        let parameter = self.keys.iter().find(|key| key.name == name);
        let parameter = parameter.unwrap_or_else(|| panic!("`{}` declares a key `{name}`", self.call.function.name));
        Argument {
            call: self.call,
            parameter,
            target: Target::Key { argument: self.argument, key: self.within.unwrap_or(name).to_string(), value: true },
            value: self.map.get(name).cloned(),
        }
    }
}

/// One argument, given or not.
pub struct Argument<'a> {
    call: &'a Call<'a>,
    parameter: &'a Parameter,
    target: Target,
    value: Option<Dynamic>,
}

impl Argument<'_> {
    /// Whether the script gave it.
    pub fn is_given(&self) -> bool {
        self.value.is_some()
    }

    /// The value as it was given.
    pub fn value(&self) -> Dynamic {
        self.value.clone().unwrap_or_default()
    }

    /// A failure that points at this argument.
    pub fn fail(&self, title: impl Into<String>) -> Failure {
        self.call.fail(title).at(self.target.clone())
    }

    /// `` `dt` of `simulate` ``.
    pub fn title(&self) -> String {
        format!("`{}` of {}", self.parameter.name, self.call.function.title())
    }

    /// The failure of a value of the wrong type.
    pub fn wrong_type(&self) -> Failure {
        let given = self.value.as_ref().map_or("nothing".to_string(), |value| describe(self.call.engine(), value));
        let failure = self.fail(format!("{} must be {}", self.title(), self.parameter.requirement())).label(format!("this is {given}"));
        let failure = failure.cause(format!("`{}` is {}", self.parameter.name, self.parameter.summary));
        match &self.parameter.kind {
            Kind::Number | Kind::Integer if self.value.as_ref().is_some_and(Dynamic::is_string) => failure.hint("leave out the quotes"),
            Kind::Handle(name) => failure.hint(maker(name)),
            Kind::Vector => failure.hint("write the components as an array, `[x, y]`"),
            Kind::Options(_) => failure.hint(format!("write `{}(#{{ name: value, … }})`", self.call.function.name)),
            kind => failure.hint(format!("give {}", kind.phrase())),
        }
    }

    fn out_of_range(&self, range: Interval, value: &str) -> Failure {
        self.fail(format!("{} must be {}", self.title(), range))
            .label(format!("this is {value}"))
            .cause(format!("`{}` is {}", self.parameter.name, self.parameter.summary))
            .hint(format!("give {}", self.parameter.requirement()))
    }

    fn missing(&self) -> Failure {
        self.call.fail(format!("{} is missing", self.title())).hint(format!("give {}", self.parameter.requirement()))
    }

    /// A number in its range.
    ///
    /// # Errors
    /// Another type, or out of range.
    pub fn number(&self) -> Result<f64, Failure> {
        let Some(value) = &self.value else {
            return match self.parameter.absent {
                Absent::Number(value) => Ok(value),
                Absent::Integer(value) => Ok(value as f64),
                _ => Err(self.missing()),
            };
        };
        let number = as_number(value).ok_or_else(|| self.wrong_type())?;
        if self.parameter.range.contains(number) { Ok(number) } else { Err(self.out_of_range(self.parameter.range, &number_text(number))) }
    }

    /// A whole number in its range; `2.0` counts as one.
    ///
    /// # Errors
    /// Another type, a fraction, or out of range.
    pub fn integer(&self) -> Result<i64, Failure> {
        let Some(value) = &self.value else {
            return match self.parameter.absent {
                Absent::Integer(value) => Ok(value),
                _ => Err(self.missing()),
            };
        };
        let whole = as_whole(value).ok_or_else(|| self.wrong_type())?;
        if self.parameter.range.contains(whole as f64) {
            Ok(whole)
        } else {
            Err(self.out_of_range(self.parameter.range, &whole.to_string()))
        }
    }

    /// A truth value.
    ///
    /// # Errors
    /// Another type.
    pub fn flag(&self) -> Result<bool, Failure> {
        match (&self.value, self.parameter.absent) {
            (Some(value), _) => value.as_bool().map_err(|_| self.wrong_type()),
            (None, Absent::Flag(value)) => Ok(value),
            (None, _) => Err(self.missing()),
        }
    }

    /// A string, one of the choices where the parameter has them.
    ///
    /// # Errors
    /// Another type or another word.
    pub fn text(&self) -> Result<String, Failure> {
        let Some(value) = &self.value else {
            return match self.parameter.absent {
                Absent::Text(value) => Ok(value.to_string()),
                _ => Err(self.missing()),
            };
        };
        let text = value.clone().into_string().map_err(|_| self.wrong_type())?;
        match &self.parameter.kind {
            Kind::Choice(words) if !words.contains(&text.as_str()) => Err(self.unknown_choice(&text, words)),
            _ => Ok(text),
        }
    }

    /// The failure of a word that is not one of the choices.
    pub fn unknown_choice(&self, word: &str, known: &[impl AsRef<str>]) -> Failure {
        self.unknown_name(format!("{} cannot be \"{word}\"", self.title()), word, known)
    }

    /// The failure of a name that does not exist, with those that do and the nearest of them.
    pub fn unknown_name(&self, title: impl Into<String>, name: &str, known: &[impl AsRef<str>]) -> Failure {
        let quoted: Vec<String> = known.iter().map(|word| format!("\"{}\"", word.as_ref())).collect();
        let failure = self.fail(title).label("unknown name");
        let failure = match quoted.len() {
            0 => failure.cause("there is none to choose from"),
            _ => {
                failure.cause(format!("there {} {}", if quoted.len() == 1 { "is" } else { "are" }, super::failure::joined(&quoted, "and")))
            }
        };
        match did_you_mean(name, known.iter().map(AsRef::as_ref)) {
            Some(suggestion) => failure.hint(suggestion.replace('`', "\"")),
            None => failure,
        }
    }

    /// An array of `dimension` numbers, the rest of the three filled with zeros.
    ///
    /// # Errors
    /// Not an array, not of that length, or not of finite numbers.
    pub fn vector(&self, dimension: usize) -> Result<[f64; 3], Failure> {
        let mut vector = [0.0; 3];
        vector[..dimension].copy_from_slice(&self.numbers_of(dimension)?);
        Ok(vector)
    }

    /// An array of `count` finite numbers.
    ///
    /// # Errors
    /// Not an array, not of that length, or not of finite numbers in range.
    pub fn numbers_of(&self, count: usize) -> Result<Vec<f64>, Failure> {
        let numbers = self.numbers()?;
        if numbers.len() == count {
            return Ok(numbers);
        }
        let failure = self.fail(format!("{} must have {count} components", self.title())).label(format!("this has {}", numbers.len()));
        let failure = failure.cause(format!("`{}` is {}", self.parameter.name, self.parameter.summary));
        Err(failure.hint(if count == 2 { "write `[x, y]`" } else { "write `[x, y, z]`" }))
    }

    /// An array of finite numbers, of any length.
    ///
    /// # Errors
    /// Not an array, or not of finite numbers in range.
    pub fn numbers(&self) -> Result<Vec<f64>, Failure> {
        let array = self.array()?;
        let numbers: Option<Vec<f64>> = array.iter().map(as_number).collect();
        let numbers = numbers.ok_or_else(|| {
            let wrong = array.iter().find(|value| as_number(value).is_none());
            let what = wrong.map_or(String::new(), |value| describe(self.call.engine(), value));
            self.fail(format!("{} must be an array of numbers", self.title())).label(format!("this contains {what}"))
        })?;
        match numbers.iter().find(|number| !self.parameter.range.contains(**number)) {
            Some(wrong) => Err(self
                .fail(format!("every entry of {} must be {}", self.title(), self.parameter.range))
                .label(format!("this contains {}", number_text(*wrong)))
                .cause(format!("`{}` is {}", self.parameter.name, self.parameter.summary))),
            None => Ok(numbers),
        }
    }

    /// An array of points `[x, y]`.
    ///
    /// # Errors
    /// Not an array, or not of pairs of finite numbers.
    pub fn points(&self) -> Result<Vec<[f64; 2]>, Failure> {
        let point = |entry: &Dynamic| -> Option<[f64; 2]> {
            let numbers: Vec<f64> = entry.read_lock::<Array>()?.iter().map(as_number).collect::<Option<_>>()?;
            <[f64; 2]>::try_from(numbers).ok().filter(|point| point.iter().all(|x| x.is_finite()))
        };
        let entries = self.array()?;
        let points: Option<Vec<[f64; 2]>> = entries.iter().map(point).collect();
        points.ok_or_else(|| {
            let wrong = entries.iter().find(|entry| point(entry).is_none());
            let given = wrong.map_or(String::new(), |value| describe(self.call.engine(), value));
            let failure = self.fail(format!("every entry of {} must be a point `[x, y]`", self.title()));
            failure.label(format!("this contains {given}")).hint("write `[[1.0, 0.0], [0.0, 0.0]]`")
        })
    }

    /// An array of `count` positive whole numbers.
    ///
    /// # Errors
    /// Anything else.
    pub fn counts(&self, count: usize) -> Result<Vec<usize>, Failure> {
        let array = self.array()?;
        let whole: Option<Vec<i64>> = array.iter().map(as_whole).collect();
        let whole = whole.ok_or_else(|| {
            let wrong = array.iter().find(|value| as_whole(value).is_none());
            let given = wrong.map_or(String::new(), |value| describe(self.call.engine(), value));
            let failure = self.fail(format!("{} must be an array of whole numbers", self.title())).label(format!("this contains {given}"));
            let failure = failure.cause(format!("`{}` is {}", self.parameter.name, self.parameter.summary));
            failure.hint("write whole numbers, such as `[10, 40]`; `x.to_int()` drops a fraction")
        })?;
        if whole.len() != count {
            return Err(self
                .fail(format!("{} must have {count} entries", self.title()))
                .label(format!("this has {}", whole.len()))
                .cause(format!("`{}` is {}", self.parameter.name, self.parameter.summary)));
        }
        match whole.iter().find(|value| **value < 1) {
            Some(wrong) => Err(self
                .fail(format!("every entry of {} must be 1 or greater", self.title()))
                .label(format!("this contains {wrong}"))
                .cause(format!("`{}` is {}", self.parameter.name, self.parameter.summary))),
            None => Ok(whole.into_iter().map(|value| value as usize).collect()),
        }
    }

    /// An array.
    ///
    /// # Errors
    /// Another type.
    pub fn array(&self) -> Result<Array, Failure> {
        self.value.as_ref().and_then(|value| value.read_lock::<Array>().map(|array| array.clone())).ok_or_else(|| self.wrong_type())
    }

    /// An object.
    ///
    /// # Errors
    /// Another type.
    pub fn handle<T: Handle>(&self) -> Result<T, Failure> {
        self.value.clone().and_then(|value| value.try_cast::<T>()).ok_or_else(|| self.wrong_type())
    }

    /// A time function: a number, one of the built-in ones, or a closure of time.
    ///
    /// # Errors
    /// Anything else.
    pub fn amplitude(&self) -> Result<TimeFunctionHandle, Failure> {
        let Some(value) = &self.value else {
            return match self.parameter.absent {
                Absent::Number(value) => Ok(time_functions::constant(value)),
                _ => Err(self.missing()),
            };
        };
        if let Some(number) = as_number(value) {
            return if number.is_finite() {
                Ok(time_functions::constant(number))
            } else {
                Err(self.out_of_range(Interval::Finite, &number_text(number)))
            };
        }
        if let Some(handle) = value.clone().try_cast::<TimeFunctionHandle>() {
            return Ok(handle);
        }
        match value.read_lock::<FnPtr>() {
            Some(function) => Ok(time_functions::closure(self.call, function.clone())),
            None => Err(self.wrong_type()),
        }
    }
}

/// A number from a whole number or a fraction.
pub fn as_number(value: &Dynamic) -> Option<f64> {
    value.as_float().ok().or_else(|| value.as_int().ok().map(|whole| whole as f64))
}

fn as_whole(value: &Dynamic) -> Option<i64> {
    let fraction = value.as_float().ok().filter(|number| number.fract() == 0.0 && number.abs() < 9e15);
    value.as_int().ok().or(fraction.map(|number| number as i64))
}

/// A value in the words of the language, such as `the string "abc"`.
pub fn describe(engine: &Engine, value: &Dynamic) -> String {
    if value.is_unit() {
        "nothing, `()`".into()
    } else if let Ok(whole) = value.as_int() {
        format!("the whole number {whole}")
    } else if let Ok(number) = value.as_float() {
        format!("the number {}", number_text(number))
    } else if let Ok(flag) = value.as_bool() {
        format!("`{flag}`")
    } else if let Some(text) = value.read_lock::<rhai::ImmutableString>() {
        let shown: String = text.chars().take(40).collect();
        format!("the string \"{shown}{}\"", if text.chars().count() > 40 { "…" } else { "" })
    } else if let Some(array) = value.read_lock::<Array>() {
        describe_array(engine, &array)
    } else if let Some(map) = value.read_lock::<Map>() {
        if map.is_empty() {
            "an empty map".into()
        } else {
            format!("a map with {}", listed(&map.keys().take(4).collect::<Vec<_>>(), "and"))
        }
    } else if value.is_fnptr() {
        "a closure".into()
    } else if value.is_char() {
        format!("the character '{}'", value)
    } else {
        super::registry::with_article(engine.map_type_name(value.type_name()))
    }
}

fn describe_array(engine: &Engine, array: &Array) -> String {
    let kinds: BTreeSet<String> = array
        .iter()
        .map(|value| match value {
            value if as_number(value).is_some() => "numbers".to_string(),
            value if value.is_string() => "strings".to_string(),
            value if value.is_array() => "arrays".to_string(),
            value => engine.map_type_name(value.type_name()).to_string(),
        })
        .collect();
    match (array.len(), kinds.len()) {
        (0, _) => "an empty array".into(),
        (count, 1) => format!("an array of {count} {}", kinds.first().map_or("", |kind| kind)),
        (count, _) => format!("an array of {count} values of different kinds"),
    }
}

/// How an object of a type is made.
fn maker(type_name: &str) -> String {
    match type_name {
        "Mesh" => "make one with `rectangle`, `ring`, `block` or `read_mesh`",
        "Material" => "make one with a material function such as `neo_hookean`",
        "Model" => "make one with `model(name)`",
        "Body" => "make one with `model.add_body(name, mesh, material)`",
        "Boundary" => "take one of a body: `body.boundary(\"outer\")`",
        "Integrator" => "make one with `energy_momentum()`, `midpoint()` or `trapezoidal()`",
        "ContactMethod" => "make one with `mortar()`, `dual_mortar()`, `averaged_mortar()` or `node_to_segment()`",
        "Obstacle" => "make one with `rigid_plane`, `rigid_disk`, `rigid_ring` or `rigid_polyline`",
        "Simulation" => "make one with `simulate(model, #{ integrator, dt })`",
        "State" => "make one with `sim.save()`",
        _ => "give an object of that type",
    }
    .into()
}

/// The failure of an interrupted call.
pub fn interrupted(title: impl Into<String>) -> Failure {
    Failure::new(Class::Interrupted, title)
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::rc::Rc;

    use crate::script::{Session, Settings, Silent};

    /// The title of the error that a script ends with, or `ok`.
    fn title(text: &str) -> String {
        let mut session = Session::new(Settings::default(), Path::new("."), Rc::new(Silent)).unwrap();
        session.evaluate("test.rhai", text).map_or_else(|error| error.title, |_| "ok".into())
    }

    #[test]
    fn whole_numbers_and_fractions_are_numbers() {
        for text in ["hat(0, 1, 5)", "hat(0.0, 1, 5.0)", "rectangle(#{ size: [2, 1.5], cells: [2.0, 1] })", "sqrt(2)", "deg(30)"] {
            assert_eq!(title(text), "ok", "{text}");
        }
    }

    #[test]
    fn a_misspelt_key_is_not_called_missing() {
        assert_eq!(title("rectangle(#{ sise: [2, 1], cells: [2, 1] })"), "`rectangle` has no option `sise`");
        assert_eq!(title("rectangle(#{ cells: [2, 1] })"), "`rectangle` needs the option `size`");
        assert_eq!(title("rectangle(#{})"), "`rectangle` needs the options `size` and `cells`");
    }

    #[test]
    fn ranges_and_types_are_checked() {
        for (text, expected) in [
            ("ramp(0, 1, \"5\")", "`value` of `ramp` must be a number"),
            ("ramp(0, 1, ())", "`value` of `ramp` must be a number"),
            ("ramp(0, 1, 1.0/0.0)", "`value` of `ramp` must be a finite number"),
            ("rectangle(#{ size: [2, 0], cells: [2, 1] })", "every entry of `size` of `rectangle` must be greater than 0"),
            ("rectangle(#{ size: 2, cells: [2, 1] })", "`size` of `rectangle` must be an array of numbers, such as `[1.0, 0.0]` [length]"),
            ("rectangle(#{ size: [2, \"1\"], cells: [2, 1] })", "`size` of `rectangle` must be an array of numbers"),
            ("rectangle(#{ size: [2, 1], cells: [2] })", "`cells` of `rectangle` must have 2 entries"),
            ("rectangle(#{ size: [2, 1], cells: [2, 1], element: \"tri3\" })", "`element` of `rectangle` cannot be \"tri3\""),
            ("rectangle([2, 1])", "`options` of `rectangle` must be an object map `#{ … }`"),
            ("model(5)", "`name` of `model` must be a string"),
            ("expect(1)", "`condition` of `expect` must be `true` or `false`"),
        ] {
            assert_eq!(title(text), expected, "{text}");
        }
    }

    #[test]
    fn a_number_is_a_time_function() {
        let text = "let s = neo_hookean(#{ youngs_modulus: 1, poisson_ratio: 0, density: 1 }); let m = model(\"m\"); \
                    let b = m.add_body(\"b\", rectangle(#{ size: [1, 1], cells: [1, 1] }), s); m.torque(b.boundary(\"top\"), ";
        for amplitude in ["5", "2.5", "hat(0, 1, 5)", "|t| 2 * t", "Fn(\"sin\")"] {
            assert_eq!(title(&format!("{text}{amplitude})")), "ok", "{amplitude}");
        }
        assert!(title(&format!("{text}[1.0])")).starts_with("`amplitude` of `torque` must be a number, a time function"));
    }
}
