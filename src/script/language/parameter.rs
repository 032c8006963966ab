//! Parameters of functions of the language: kind, dimension, range and default.
//!
//! A [`Parameter`] is a description; values given by a script are read in `arguments.rs`.

use super::digits::number_text;
use super::handle::Handle;
use super::wording::{joined, with_article};
use crate::math::catalogue::{self, Interval};

/// Kind of values that a parameter accepts.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// A number, whole or not.
    Number,
    /// A whole number.
    Integer,
    /// `true` or `false`.
    Flag,
    /// A string.
    Text,
    /// One of several strings.
    Choice(&'static [&'static str]),
    /// An array of as many numbers as the space has dimensions.
    Vector,
    /// An array of whole numbers.
    Counts,
    /// An array.
    Array,
    /// A number, a time function or a closure of time.
    Amplitude,
    /// A closure with the given parameters.
    Closure(&'static str),
    /// An object of the named type.
    Handle(&'static str),
    /// An object map with these keys.
    Options(Vec<Parameter>),
    /// An object map with these keys and further ones, which the function checks itself.
    OpenOptions(Vec<Parameter>),
    /// One of several kinds, in words with their articles.
    Either(&'static str),
    /// Anything.
    Any,
}

impl Kind {
    /// Returns the keys if the kind is an object map.
    pub fn keys(&self) -> Option<&[Parameter]> {
        match self {
            Kind::Options(keys) | Kind::OpenOptions(keys) => Some(keys),
            _ => None,
        }
    }

    /// Returns the kind with its article, for messages.
    pub(crate) fn phrase(&self) -> String {
        match self {
            Kind::Number => "a number".into(),
            Kind::Integer => "a whole number".into(),
            Kind::Flag => "`true` or `false`".into(),
            Kind::Text => "a string".into(),
            Kind::Choice(words) => {
                let quoted: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
                joined(&quoted, "or")
            }
            Kind::Vector => "an array of numbers, such as `[1.0, 0.0]`".into(),
            Kind::Counts => "an array of whole numbers, such as `[10, 40]`".into(),
            Kind::Array => "an array".into(),
            Kind::Amplitude => "a number, a time function such as `hat(0.0, 1.0, 5.0)`, or a closure `|t| …`".into(),
            Kind::Closure(parameters) => format!("a closure `{parameters} …`"),
            Kind::Handle(name) => with_article(name),
            Kind::Options(_) | Kind::OpenOptions(_) => "an object map `#{ … }`".into(),
            Kind::Either(words) => (*words).into(),
            Kind::Any => "a value".into(),
        }
    }

    /// Returns the kind as one word, for signatures.
    pub fn word(&self) -> &'static str {
        match self {
            Kind::Number => "number",
            Kind::Integer => "int",
            Kind::Flag => "bool",
            Kind::Text | Kind::Choice(_) => "String",
            Kind::Vector | Kind::Counts | Kind::Array => "Array",
            Kind::Amplitude => "Amplitude",
            Kind::Closure(_) => "Fn",
            Kind::Handle(name) => name,
            Kind::Options(_) | Kind::OpenOptions(_) => "Map",
            Kind::Either(_) | Kind::Any => "any",
        }
    }
}

/// Default of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Absent {
    /// The parameter is required.
    Refused,
    /// Behavior without the parameter, in words.
    Means(&'static str),
    /// A number.
    Number(f64),
    /// A whole number.
    Integer(i64),
    /// A truth value.
    Flag(bool),
    /// A string.
    Text(&'static str),
}

impl From<f64> for Absent {
    fn from(value: f64) -> Self {
        Absent::Number(value)
    }
}

impl From<i64> for Absent {
    fn from(value: i64) -> Self {
        Absent::Integer(value)
    }
}

impl From<bool> for Absent {
    fn from(value: bool) -> Self {
        Absent::Flag(value)
    }
}

impl From<&'static str> for Absent {
    fn from(value: &'static str) -> Self {
        Absent::Text(value)
    }
}

impl std::fmt::Display for Absent {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Absent::Refused => write!(out, "required"),
            Absent::Means(words) => write!(out, "{words}"),
            Absent::Number(value) => write!(out, "{}", number_text(*value)),
            Absent::Integer(value) => write!(out, "{value}"),
            Absent::Flag(value) => write!(out, "{value}"),
            Absent::Text(value) => write!(out, "\"{value}\""),
        }
    }
}

/// A parameter of a function or a key of an options map.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name.
    pub name: &'static str,
    /// Kind of values.
    pub kind: Kind,
    /// Physical dimension: `1` for a pure number, `any` if it depends on the use, empty for values other than numbers.
    pub dimension: &'static str,
    /// Admissible values of a number.
    pub range: Interval,
    /// Default.
    pub absent: Absent,
    /// Summary, one sentence.
    pub summary: &'static str,
}

impl Parameter {
    /// A required parameter.
    pub fn new(name: &'static str, kind: Kind, summary: &'static str) -> Self {
        Parameter { name, kind, dimension: "", range: Interval::Finite, absent: Absent::Refused, summary }
    }

    /// Returns a required number with its dimension and range.
    pub fn number(name: &'static str, dimension: &'static str, range: Interval, summary: &'static str) -> Self {
        Parameter { dimension, range, ..Parameter::new(name, Kind::Number, summary) }
    }

    /// A required truth value.
    pub fn flag(name: &'static str, summary: &'static str) -> Self {
        Parameter::new(name, Kind::Flag, summary)
    }

    /// A required string.
    pub fn text(name: &'static str, summary: &'static str) -> Self {
        Parameter::new(name, Kind::Text, summary)
    }

    /// A required whole number.
    pub fn integer(name: &'static str, summary: &'static str) -> Self {
        Parameter::new(name, Kind::Integer, summary)
    }

    /// A required array of as many numbers as the space has dimensions.
    pub fn vector(name: &'static str, summary: &'static str) -> Self {
        Parameter::new(name, Kind::Vector, summary)
    }

    /// A required array of whole numbers.
    pub fn counts(name: &'static str, summary: &'static str) -> Self {
        Parameter::new(name, Kind::Counts, summary)
    }

    /// A required array.
    pub fn array(name: &'static str, summary: &'static str) -> Self {
        Parameter::new(name, Kind::Array, summary)
    }

    /// A required number, time function or closure of time.
    pub fn amplitude(name: &'static str, summary: &'static str) -> Self {
        Parameter::new(name, Kind::Amplitude, summary)
    }

    /// A required value of any kind.
    pub fn any(name: &'static str, summary: &'static str) -> Self {
        Parameter::new(name, Kind::Any, summary)
    }

    /// A required object of the type `T`.
    pub fn object<T: Handle>(name: &'static str, summary: &'static str) -> Self {
        Parameter::new(name, Kind::Handle(T::NAME), summary)
    }

    /// A required object map, without keys.
    pub fn map(name: &'static str, summary: &'static str) -> Self {
        Parameter::new(name, Kind::Options(Vec::new()), summary)
    }

    /// A required object map `options`, without keys.
    pub fn options(summary: &'static str) -> Self {
        Parameter::map("options", summary)
    }

    /// Returns the object map with these keys.
    pub fn keys(self, keys: Vec<Parameter>) -> Self {
        Parameter { kind: Kind::Options(keys), ..self }
    }

    /// Returns the key of an options map for a parameter of a catalogue's row.
    pub(crate) fn of_catalogue(row: &catalogue::Parameter) -> Self {
        let key = Parameter::number(row.name, row.dimension, row.range, row.summary);
        match row.default {
            Some(value) => key.or(Absent::Number(value)),
            None => key,
        }
    }

    /// Returns the parameter with a value as its default.
    pub fn or(self, absent: impl Into<Absent>) -> Self {
        Parameter { absent: absent.into(), ..self }
    }

    /// Returns the parameter as optional; `behavior` describes in words what holds without it.
    pub fn otherwise(self, behavior: &'static str) -> Self {
        Parameter { absent: Absent::Means(behavior), ..self }
    }

    /// Returns the parameter with a dimension.
    pub fn of(self, dimension: &'static str) -> Self {
        Parameter { dimension, ..self }
    }

    /// Returns the parameter with a range.
    pub fn within(self, range: Interval) -> Self {
        Parameter { range, ..self }
    }

    /// True if the parameter is optional.
    pub(crate) fn is_optional(&self) -> bool {
        self.absent != Absent::Refused
    }

    /// Returns a description of accepted values, such as `a number greater than 0 [length]`.
    pub(crate) fn requirement(&self) -> String {
        let mut text = self.kind.phrase();
        if matches!(self.kind, Kind::Number | Kind::Integer) && self.range != Interval::Finite {
            text = format!("{text} {}", self.range);
        }
        if !matches!(self.dimension, "" | "1" | "any") {
            text = format!("{text} [{}]", self.dimension);
        }
        text
    }
}
