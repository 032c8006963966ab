//! Values of scripts as plain data, which may be sent to another thread and written to a file.
//!
//! Numbers, texts, truth values, arrays and maps are data; a mesh, a simulation or a closure belongs to the engine that made it.

use rhai::{Array, Dynamic, ImmutableString, Map};
use serde::{Deserialize, Serialize};

use super::values::as_number;

/// Largest depth of nested arrays and maps.
const DEPTH: usize = 64;

/// A value without anything that belongs to an engine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Plain {
    /// `()`.
    Nothing,
    /// `true` or `false`.
    Flag(bool),
    /// A whole number.
    Whole(i64),
    /// A number.
    Number(f64),
    /// A character.
    Letter(char),
    /// A string.
    Text(String),
    /// An array.
    Array(Vec<Plain>),
    /// Map, sorted by its keys.
    Map(Vec<(String, Plain)>),
}

impl Plain {
    /// Converts a value; `None` if it contains an object.
    pub fn of(value: &Dynamic) -> Option<Plain> {
        Plain::within(value, DEPTH)
    }

    fn within(value: &Dynamic, depth: usize) -> Option<Plain> {
        let deeper = depth.checked_sub(1)?;
        if value.is_unit() {
            return Some(Plain::Nothing);
        }
        if let Ok(flag) = value.as_bool() {
            return Some(Plain::Flag(flag));
        }
        if let Ok(whole) = value.as_int() {
            return Some(Plain::Whole(whole));
        }
        if let Ok(number) = value.as_float() {
            return Some(Plain::Number(number));
        }
        if let Ok(letter) = value.as_char() {
            return Some(Plain::Letter(letter));
        }
        if let Some(text) = value.read_lock::<ImmutableString>() {
            return Some(Plain::Text(text.to_string()));
        }
        if let Some(array) = value.read_lock::<Array>() {
            return array.iter().map(|entry| Plain::within(entry, deeper)).collect::<Option<_>>().map(Plain::Array);
        }
        let map = value.read_lock::<Map>()?;
        let entry = |(key, value): (&rhai::Identifier, &Dynamic)| Some((key.to_string(), Plain::within(value, deeper)?));
        map.iter().map(entry).collect::<Option<_>>().map(Plain::Map)
    }

    /// The value for an engine.
    pub fn value(&self) -> Dynamic {
        match self {
            Plain::Nothing => Dynamic::UNIT,
            Plain::Flag(flag) => (*flag).into(),
            Plain::Whole(whole) => (*whole).into(),
            Plain::Number(number) => (*number).into(),
            Plain::Letter(letter) => (*letter).into(),
            Plain::Text(text) => text.into(),
            Plain::Array(entries) => entries.iter().map(Plain::value).collect::<Array>().into(),
            Plain::Map(entries) => entries.iter().map(|(key, value)| (key.into(), value.value())).collect::<Map>().into(),
        }
    }

    /// A number, whole or not.
    pub fn number(&self) -> Option<f64> {
        as_number(&match self {
            Plain::Whole(whole) => Dynamic::from(*whole),
            Plain::Number(number) => Dynamic::from(*number),
            _ => return None,
        })
    }

    /// True if both values are bitwise equal.
    pub fn is_same(&self, other: &Plain) -> bool {
        match (self, other) {
            (Plain::Number(a), Plain::Number(b)) => a.to_bits() == b.to_bits(),
            (Plain::Array(a), Plain::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.is_same(b)),
            (Plain::Map(a), Plain::Map(b)) => {
                a.len() == b.len() && a.iter().zip(b).all(|((name, a), (other, b))| name == other && a.is_same(b))
            }
            (a, b) => a == b,
        }
    }

    /// Returns the value as a field of a table: numbers with the fewest digits that read back as the same number, arrays and maps as JSON.
    pub fn field(&self) -> String {
        match self {
            Plain::Nothing => String::new(),
            Plain::Flag(flag) => flag.to_string(),
            Plain::Whole(whole) => whole.to_string(),
            Plain::Number(number) => format!("{number:?}"),
            Plain::Letter(letter) => letter.to_string(),
            Plain::Text(text) => text.clone(),
            Plain::Array(_) | Plain::Map(_) => self.json().to_string(),
        }
    }

    fn json(&self) -> serde_json::Value {
        match self {
            Plain::Nothing => serde_json::Value::Null,
            Plain::Flag(flag) => (*flag).into(),
            Plain::Whole(whole) => (*whole).into(),
            Plain::Number(number) if number.is_finite() => (*number).into(),
            Plain::Number(number) => format!("{number:?}").into(),
            Plain::Letter(letter) => letter.to_string().into(),
            Plain::Text(text) => text.clone().into(),
            Plain::Array(entries) => entries.iter().map(Plain::json).collect(),
            Plain::Map(entries) => entries.iter().map(|(key, value)| (key.clone(), value.json())).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_comes_back_as_it_was_and_objects_are_none() {
        let engine = rhai::Engine::new();
        let value: Dynamic = engine.eval("#{ a: [1, 2.5, \"x\", 'y', true, ()], b: #{ c: -0.0 } }").unwrap();
        let plain = Plain::of(&value).unwrap();
        assert!(Plain::of(&plain.value()).unwrap().is_same(&plain));
        assert_eq!(plain.field(), r#"{"a":[1,2.5,"x","y",true,null],"b":{"c":-0.0}}"#);
        assert!(Plain::of(&engine.eval::<Dynamic>("[1, |x| x]").unwrap()).is_none());
        assert!(!Plain::Number(0.0).is_same(&Plain::Number(-0.0)));
        assert!(Plain::Number(f64::NAN).is_same(&Plain::Number(f64::NAN)));
        let mut deep = Dynamic::UNIT;
        for _ in 0..DEPTH {
            deep = vec![deep].into();
        }
        assert!(Plain::of(&deep).is_none());
    }
}
