//! What a function of the language takes: kind, dimension, range and default of each parameter.
//!
//! A [`Parameter`] describes; what a script gave for it is read in `arguments.rs`.

use super::digits::number_text;
use super::wording::{joined, with_article};
use crate::math::catalogue::{self, Interval};

/// What a parameter takes.
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
    /// One of some strings.
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
    /// An object map with these keys and others, which the function looks at itself.
    OpenOptions(Vec<Parameter>),
    /// One of several kinds, in words with their articles.
    Either(&'static str),
    /// Anything.
    Any,
}

impl Kind {
    /// The keys of an object map, if it is one.
    pub fn keys(&self) -> Option<&[Parameter]> {
        match self {
            Kind::Options(keys) | Kind::OpenOptions(keys) => Some(keys),
            _ => None,
        }
    }

    /// With its article, as messages name it.
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

    /// One word, as signatures name it.
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

/// What holds when a parameter is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Absent {
    /// It must not be left out.
    Refused,
    /// What is done instead, in words.
    Means(&'static str),
    /// This number.
    Number(f64),
    /// This whole number.
    Integer(i64),
    /// This truth value.
    Flag(bool),
    /// This string.
    Text(&'static str),
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
    /// What it takes.
    pub kind: Kind,
    /// Physical dimension, `1` for a pure number, `any` where it depends on the use, empty for what is no number.
    pub dimension: &'static str,
    /// Admissible values of a number.
    pub range: Interval,
    /// What holds when it is left out.
    pub absent: Absent,
    /// One sentence: what it is.
    pub summary: &'static str,
}

impl Parameter {
    /// A required parameter.
    pub fn new(name: &'static str, kind: Kind, summary: &'static str) -> Self {
        Parameter { name, kind, dimension: "", range: Interval::Finite, absent: Absent::Refused, summary }
    }

    /// A required number with its dimension and range.
    pub fn number(name: &'static str, dimension: &'static str, range: Interval, summary: &'static str) -> Self {
        Parameter { dimension, range, ..Parameter::new(name, Kind::Number, summary) }
    }

    /// The number that a row of a catalogue asks for, as a key of an options map.
    pub(crate) fn of_catalogue(row: &catalogue::Parameter) -> Self {
        let key = Parameter::number(row.name, row.dimension, row.range, row.summary);
        match row.default {
            Some(value) => key.or(Absent::Number(value)),
            None => key,
        }
    }

    /// The same, which may be left out.
    pub fn or(self, absent: Absent) -> Self {
        Parameter { absent, ..self }
    }

    /// The same with a dimension.
    pub fn of(self, dimension: &'static str) -> Self {
        Parameter { dimension, ..self }
    }

    /// The same with a range.
    pub fn within(self, range: Interval) -> Self {
        Parameter { range, ..self }
    }

    /// Whether it may be left out.
    pub(crate) fn is_optional(&self) -> bool {
        self.absent != Absent::Refused
    }

    /// What must be given, such as `a number greater than 0 [length]`.
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
