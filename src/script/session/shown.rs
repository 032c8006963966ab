//! Values as shown at the prompt: short ones as literals, long ones shortened, objects as small tables.

use rhai::{Array, Dynamic, Engine, Map};

use crate::script::api::meshes::handle::MeshHandle;
use crate::script::api::simulations::handle::SimulationHandle;
use crate::script::language::digits::{number_text, rounded};
use crate::script::language::registry::Registry;
use crate::script::language::tables::table;
use crate::script::language::values::as_number;

/// Default number of significant digits at the prompt.
pub const DIGITS: usize = 6;

/// Largest number of array entries shown.
const SHOWN: usize = 24;

/// Type of a value in terms of the language.
pub fn kind_of(engine: &Engine, value: &Dynamic) -> String {
    if value.is_fnptr() {
        return "closure".into();
    }
    if let Some(array) = value.read_lock::<Array>() {
        return format!("array of {}", array.len());
    }
    match engine.map_type_name(value.type_name()) {
        "i64" => "whole number".into(),
        "f64" => "number".into(),
        "bool" => "truth value".into(),
        "string" => "string".into(),
        other => other.to_string(),
    }
}

/// A value at the prompt; its numbers with at most `digits` digits, or with all of them.
pub fn shown(registry: &Registry, value: &Dynamic, digits: Option<usize>) -> String {
    if let Some(mesh) = value.clone().try_cast::<MeshHandle>() {
        return mesh.table();
    }
    if let Some(simulation) = value.clone().try_cast::<SimulationHandle>() {
        return simulation.table();
    }
    if let Some(map) = value.read_lock::<Map>() {
        if map.is_empty() {
            return "#{}".into();
        }
        let rows: Vec<Vec<String>> = map.iter().map(|(key, value)| vec![key.to_string(), short(registry, value, digits)]).collect();
        let width = rows.iter().map(|row| row[0].chars().count()).max().unwrap_or(0);
        return rows.iter().map(|row| format!("  {:<width$}  {}", row[0], row[1])).collect::<Vec<_>>().join("\n");
    }
    short(registry, value, digits)
}

/// Returns a value in one line if possible.
fn short(registry: &Registry, value: &Dynamic, digits: Option<usize>) -> String {
    if let Some(text) = registry.types().print(value) {
        return text;
    }
    if let Ok(text) = value.clone().into_string() {
        return format!("{text:?}");
    }
    if value.is_fnptr() {
        return "closure".into();
    }
    if let Some(array) = value.read_lock::<Array>() {
        let is_table = !array.is_empty()
            && array.iter().all(|row| row.read_lock::<Array>().is_some_and(|row| row.iter().all(|x| as_number(x).is_some())));
        if is_table && array.len() <= SHOWN && array.len() > 1 {
            let rows: Vec<Vec<String>> = array
                .iter()
                .filter_map(|row| row.read_lock::<Array>().map(|row| row.iter().map(|value| short(registry, value, digits)).collect()))
                .collect();
            return table(&vec![""; rows.iter().map(Vec::len).max().unwrap_or(0)], &rows);
        }
        let mut entries: Vec<String> = array.iter().take(SHOWN).map(|value| short(registry, value, digits)).collect();
        if array.len() > SHOWN {
            entries.push(format!("… {} entries in all", array.len()));
        }
        let joint = if entries.iter().any(|entry| entry.contains('\n')) { ",\n" } else { ", " };
        return format!("[{}]", entries.join(joint));
    }
    if let Some(map) = value.read_lock::<Map>() {
        let entries: Vec<String> = map.iter().map(|(key, value)| format!("{key}: {}", short(registry, value, digits))).collect();
        return format!("#{{ {} }}", entries.join(", "));
    }
    match value.as_float() {
        Ok(number) => {
            let text = digits.map_or_else(|| number_text(number), |digits| rounded(number, digits));
            if text.contains(['.', 'e', 'N', 'i']) { text } else { format!("{text}.0") }
        }
        Err(_) => value.to_string(),
    }
}
