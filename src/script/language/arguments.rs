//! Reads the arguments of a call: one place for conversion, ranges and defaults.
//!
//! Numbers may be written `1` or `1.0`, points are arrays (`arrays.rs`). Wrong types are described in terms of the language. The keys of
//! options maps are checked in `keys.rs` before a body runs.

use rhai::{Dynamic, Map};

use super::causes;
use super::digits::number_text;
use super::failure::Failure;
use super::function::Call;
use super::handle::{Handle, Types};
use super::parameter::{Absent, Kind, Parameter};
use super::scan::Target;
use super::values::{as_number, as_whole, describe};
use super::wording::{did_you_mean, joined};
use crate::math::catalogue::Interval;

/// Access to arguments by name: those of a call, or the keys of an options map.
pub trait Arguments {
    /// Returns the argument with a name, which may be missing.
    fn argument(&self, name: &str) -> Argument<'_>;

    /// Returns a number (or its default).
    fn number(&self, name: &str) -> Result<f64, Failure> {
        self.argument(name).number()
    }

    /// Returns a number, if given.
    fn optional_number(&self, name: &str) -> Result<Option<f64>, Failure> {
        self.argument(name).given(Argument::number)
    }

    /// Returns a whole number (or its default).
    fn integer(&self, name: &str) -> Result<i64, Failure> {
        self.argument(name).integer()
    }

    /// Returns a truth value (or its default).
    fn flag(&self, name: &str) -> Result<bool, Failure> {
        self.argument(name).flag()
    }

    /// Returns a string (or its default).
    fn text(&self, name: &str) -> Result<String, Failure> {
        self.argument(name).text()
    }

    /// Returns a name, on one line.
    fn name(&self, name: &str) -> Result<String, Failure> {
        self.argument(name).name()
    }

    /// Returns an object of the language of the type `T`.
    fn handle<T: Handle>(&self, name: &str) -> Result<T, Failure> {
        self.argument(name).handle()
    }
}

impl<'a> Call<'a> {
    /// Returns the value of the parameter with an index, if given.
    pub(super) fn value(&self, index: usize) -> Option<&Dynamic> {
        self.values.get(index + usize::from(self.function.form.receiver().is_some()))
    }

    /// Returns the options map with a name.
    ///
    /// # Errors
    /// The value is not a map.
    pub fn options(&self, name: &str) -> Result<Options<'_>, Failure> {
        self.options_at(self.index(name))
    }

    /// Returns the options map that is the last parameter.
    pub(super) fn last_options(&self) -> Result<Options<'_>, Failure> {
        self.options_at(self.function.parameters.len() - 1)
    }

    fn options_at(&self, index: usize) -> Result<Options<'_>, Failure> {
        let Parameter { name, kind, .. } = &self.function.parameters[index];
        let Some(keys) = kind.keys() else { panic!("`{name}` of `{}` is declared as options", self.function.name) };
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
    /// Key of an enclosing map whose value this map is.
    within: Option<&'static str>,
}

impl<'a> Options<'a> {
    /// Returns keys with their values that the script has given and the function does not declare.
    pub fn others(&self) -> Vec<(String, Dynamic)> {
        let declared = |name: &str| self.keys.iter().any(|key| key.name == name);
        let others = self.map.iter().filter(|(name, _)| !declared(name));
        others.map(|(name, value)| (name.to_string(), value.clone())).collect()
    }

    /// Returns the target of a message about an undeclared key: its value or its name.
    pub(crate) fn target_of(&self, key: &str, value: bool) -> Target {
        Target::Key { argument: self.argument, key: key.into(), value }
    }

    /// Returns the map that is the value of a key; empty if not given.
    ///
    /// # Errors
    /// The value is not a map.
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

/// Argument of a call, given or missing.
pub struct Argument<'a> {
    pub(super) call: &'a Call<'a>,
    pub(super) parameter: &'a Parameter,
    target: Target,
    pub(super) value: Option<Dynamic>,
}

impl Argument<'_> {
    /// True if the script has given the argument.
    pub fn is_given(&self) -> bool {
        self.value.is_some()
    }

    /// Reads the argument, if the script has given it.
    ///
    /// # Errors
    /// Errors of `read`.
    pub fn given<T>(&self, read: impl FnOnce(&Self) -> Result<T, Failure>) -> Result<Option<T>, Failure> {
        self.is_given().then(|| read(self)).transpose()
    }

    /// Returns the value as given.
    pub fn value(&self) -> Dynamic {
        self.value.clone().unwrap_or_default()
    }

    /// Call of the argument.
    pub fn call(&self) -> &Call<'_> {
        self.call
    }

    /// Returns the default of the parameter.
    pub fn absent(&self) -> Absent {
        self.parameter.absent
    }

    /// Failure that points at this argument.
    pub fn fail(&self, title: impl Into<String>) -> Failure {
        self.call.fail(title).at(self.target.clone())
    }

    /// Failure that points at this argument, with a stable code of [`causes`].
    pub fn refuse(&self, code: &'static str, title: impl Into<String>) -> Failure {
        self.fail(title).code(code)
    }

    /// Failure that points at this argument, with a title of the argument's [`Self::title`] and `requirement`, such as "must ascend".
    pub fn wrong(&self, code: &'static str, requirement: impl std::fmt::Display) -> Failure {
        self.refuse(code, format!("{} {requirement}", self.title()))
    }

    /// Place of the argument in the call.
    pub fn target(&self) -> Target {
        self.target.clone()
    }

    /// Title of the argument in messages, such as `` `dt` of `simulate` ``.
    pub fn title(&self) -> String {
        format!("`{}` of {}", self.parameter.name, self.call.function.title())
    }

    /// The failure of a value of the wrong type.
    pub fn wrong_type(&self) -> Failure {
        let given = self.value.as_ref().map_or("nothing".to_string(), |value| describe(self.call.engine(), value));
        let failure = self.wrong(causes::WRONG_TYPE, format!("must be {}", self.parameter.requirement()));
        let failure = failure.code(causes::WRONG_TYPE).label(format!("this is {given}"));
        let failure = failure.cause(format!("`{}` is {}", self.parameter.name, self.parameter.summary));
        match &self.parameter.kind {
            Kind::Number | Kind::Integer if self.value.as_ref().is_some_and(Dynamic::is_string) => failure.hint("leave out the quotes"),
            Kind::Handle(name) => failure.hint(self.call.host.slots.get::<Types>().maker(name)),
            Kind::Vector => failure.hint("write the components as an array, `[x, y]`"),
            Kind::Options(_) | Kind::OpenOptions(_) => {
                let function = self.call.function;
                let key = self.parameter.kind.keys().and_then(|keys| keys.first()).map_or("name", |key| key.name);
                let place = function.parameters.iter().position(|parameter| parameter.name == self.parameter.name);
                failure.hint(match place {
                    Some(0) => format!("write `{}(#{{ {key}: … }})`", function.name),
                    Some(_) => format!("write `{}(…, #{{ {key}: … }})`", function.name),
                    None => format!("write `{}: #{{ {key}: … }}`", self.parameter.name),
                })
            }
            kind => failure.hint(format!("give {}", kind.phrase())),
        }
    }

    /// Failure of a number outside the range of the parameter.
    pub fn out_of_range(&self, range: Interval, value: &str) -> Failure {
        self.wrong(causes::OUT_OF_RANGE, format!("must be {}", range))
            .label(format!("this is {value}"))
            .cause(format!("`{}` is {}", self.parameter.name, self.parameter.summary))
            .hint(format!("give {}", self.parameter.requirement()))
    }

    /// Failure of a missing argument without a default.
    pub fn missing(&self) -> Failure {
        self.call.refuse(causes::MISSING, format!("{} is missing", self.title())).hint(format!("give {}", self.parameter.requirement()))
    }

    /// Returns a number in its range.
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

    /// Returns a whole number in its range; `2.0` counts as a whole number.
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

    /// Returns a string; one of the choices if the parameter has choices.
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

    /// Returns the value as a name for files, folders and messages: on one line.
    ///
    /// # Errors
    /// Another type; a control character.
    pub fn name(&self) -> Result<String, Failure> {
        let name = self.text()?;
        if name.contains(char::is_control) {
            let failure = self.wrong(causes::WRONG_TYPE, "must be a name on one line");
            return Err(failure.label("it has a line break or another control character").hint("write letters, digits, signs and blanks"));
        }
        Ok(name)
    }

    /// Returns the failure of a word that is not one of the choices.
    pub fn unknown_choice(&self, word: &str, known: &[impl AsRef<str>]) -> Failure {
        self.unknown_name(format!("{} cannot be \"{word}\"", self.title()), word, known)
    }

    /// Returns the failure of an unknown name, with the known names and the nearest of these.
    pub fn unknown_name(&self, title: impl Into<String>, name: &str, known: &[impl AsRef<str>]) -> Failure {
        let quoted: Vec<String> = known.iter().map(|word| format!("\"{}\"", word.as_ref())).collect();
        let failure = self.refuse(causes::UNKNOWN_WORD, title).label("unknown name");
        let failure = match quoted.len() {
            0 => failure.cause("there is none to choose from"),
            _ => failure.cause(format!("there {} {}", if quoted.len() == 1 { "is" } else { "are" }, joined(&quoted, "and"))),
        };
        match did_you_mean(name, known.iter().map(AsRef::as_ref)) {
            Some(suggestion) => failure.hint(suggestion.replace('`', "\"")),
            None => failure,
        }
    }

    /// Returns an object of the language of the type `T`.
    ///
    /// # Errors
    /// Another type.
    pub fn handle<T: Handle>(&self) -> Result<T, Failure> {
        self.value.clone().and_then(|value| value.try_cast::<T>()).ok_or_else(|| self.wrong_type())
    }
}
