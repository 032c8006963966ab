//! Values of the engine as numbers, and in the words of the language.

use std::collections::BTreeSet;

use rhai::{Array, Dynamic, Engine, Map};

use super::digits::number_text;
use super::wording::{listed, with_article};

/// A number from a whole number or a fraction.
pub fn as_number(value: &Dynamic) -> Option<f64> {
    value.as_float().ok().or_else(|| value.as_int().ok().map(|whole| whole as f64))
}

/// A whole number, which may be written with a decimal point.
pub fn as_whole(value: &Dynamic) -> Option<i64> {
    let fraction = value.as_float().ok().filter(|number| number.fract() == 0.0 && number.abs() < 9e15);
    value.as_int().ok().or(fraction.map(|number| number as i64))
}

/// Values as an array of the language.
pub fn array_of<T: Into<Dynamic>>(values: impl IntoIterator<Item = T>) -> Dynamic {
    values.into_iter().map(Into::into).collect::<Array>().into()
}

/// Entries as an object map of the language.
pub fn map_of<const N: usize>(entries: [(&str, Dynamic); N]) -> Dynamic {
    entries.into_iter().map(|(name, value)| (name.into(), value)).collect::<Map>().into()
}

/// Describes a value in terms of the language, such as `the string "abc"`.
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
        with_article(engine.map_type_name(value.type_name()))
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
