//! `result(name, value)`: results of a script, for the summary of the run and the table of a study.

use std::cell::RefCell;
use std::collections::BTreeMap;

use serde_json::Value;

use crate::output::{Dimension, Unit};
use crate::script::api::units::{DeclaredUnits, refused_unit};
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::digits::number_text;
use crate::script::language::prelude::*;
use crate::script::language::values::{as_number, describe};

/// Results of the script, in the order in which they were first named.
#[derive(Default)]
pub struct Results {
    named: RefCell<Vec<(String, Value)>>,
    units: RefCell<BTreeMap<String, String>>,
}

impl Results {
    /// Returns the results of a session.
    pub fn of(host: &Host) -> Vec<(String, Value)> {
        host.slots.get::<Results>().named.borrow().clone()
    }

    /// Returns the units of the results that have one, by name.
    pub fn units(host: &Host) -> BTreeMap<String, String> {
        host.slots.get::<Results>().units.borrow().clone()
    }

    fn note(&self, name: &str, value: Value, unit: String) {
        let mut units = self.units.borrow_mut();
        units.remove(name);
        if !unit.is_empty() {
            units.insert(name.to_string(), unit);
        }
        let mut all = self.named.borrow_mut();
        match all.iter_mut().find(|(known, _)| known == name) {
            Some((_, known)) => *known = value,
            None => all.push((name.to_string(), value)),
        }
    }
}

/// The function `result`.
pub fn result() -> Function {
    function(Topic::Parameters, "result")
        .summary("records a result of the script under a name: it is in `summary.json`, and a column of the table of `conserva sweep`")
        .parameters(vec![
            Parameter::text("name", "the result's name, with its unit if that helps; a further value of the same name replaces it"),
            Parameter::any("value", "a number, a text, `true` or `false`, or an array of these"),
            Parameter::text(
                "unit",
                "its unit, such as `\"MPa\"`, or its dimension, such as `\"stress\"` or `\"force / length\"`, whose unit is that of \
                 `units`: tables, pages and files of runs and studies name it",
            )
            .otherwise("no unit is named"),
        ])
        .see_also(&["param", "units"])
        .example("let peak = max([0.2, 0.7, 0.4]);\nresult(\"peak pressure\", peak, \"MPa\");")
        .body(|call| {
            let (name, value) = (call.name("name")?, call.argument("value"));
            if name.trim().is_empty() {
                let failure = call.argument("name").refuse(causes::WRONG_TYPE, "`name` of `result` must be a word or a few");
                return Err(failure.hint("write `result(\"peak pressure\", p)`, for example").into());
            }
            let Some(plain) = plain(&value.value()) else { return Err(refused(call, &value.value()).into()) };
            if as_number(&value.value()).is_some_and(|number| !number.is_finite()) {
                let title = format!("the result \"{name}\" is {}", number_text(as_number(&value.value()).unwrap_or_default()));
                let warning =
                    Diagnostic::warning(title, call.place(&Target::Call)).code("C1053").cause("tables of studies have it as a text");
                call.host.warn(warning.hint("look for a division by zero, or for a column that has no value yet"));
            }
            call.host.slots.get::<Results>().note(&name, plain, unit_of(call)?);
            Ok(())
        })
}

/// Unit in the argument `unit` of a result or parameter; empty where none is given, or where that of a dimension is not declared.
pub fn unit_of(call: &Call) -> Result<String, Failure> {
    let argument = call.argument("unit");
    if !argument.is_given() {
        return Ok(String::new());
    }
    let text = argument.text()?;
    if Dimension::parse(&text).is_some() {
        return Ok(DeclaredUnits::set(call.host).map_or(String::new(), |set| set.unit(&text)));
    }
    match Unit::parse(&text) {
        Ok(_) => Ok(text),
        Err(error) => Err(refused_unit(argument.wrong(causes::WRONG_TYPE, format!("cannot be \"{text}\": {error}")), &error)),
    }
}

fn refused(call: &Call, value: &Dynamic) -> Failure {
    let failure = call
        .argument("value")
        .refuse(causes::WRONG_TYPE, "`value` of `result` must be a number, a text, `true` or `false`, or an array of these");
    failure
        .label(format!("this is {}", describe(call.engine(), value)))
        .hint("give one number that represents it, such as the last of a column: `sim.history.total[-1]`")
}

/// Converts a value for a file; `None` for values that no file can hold. JSON has no numbers that are not finite: these are written as
/// words.
fn plain(value: &Dynamic) -> Option<Value> {
    if let Some(array) = value.read_lock::<Array>() {
        return array.iter().map(plain).collect::<Option<Vec<_>>>().map(Value::Array);
    }
    if let Ok(whole) = value.as_int() {
        return Some(whole.into());
    }
    if let Some(number) = as_number(value) {
        return Some(serde_json::Number::from_f64(number).map_or_else(|| format!("{number:?}").into(), Value::Number));
    }
    match (value.as_bool(), value.clone().into_string()) {
        (Ok(flag), _) => Some(flag.into()),
        (_, Ok(text)) => Some(text.into()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_keep_their_kinds_and_first_places() {
        let results = Results::default();
        for (name, value) in [("b", Dynamic::from(1_i64)), ("a", 0.5.into()), ("b", f64::NAN.into())] {
            results.note(name, plain(&value).unwrap(), if name == "a" { "mm".into() } else { String::new() });
        }
        assert_eq!(*results.units.borrow(), BTreeMap::from([("a".to_string(), "mm".to_string())]));
        assert_eq!(*results.named.borrow(), [("b".into(), Value::from("NaN")), ("a".into(), Value::from(0.5))]);
        let array: Array = vec![true.into(), "word".into(), Dynamic::from(2_i64)];
        assert_eq!(plain(&array.into()).unwrap().to_string(), "[true,\"word\",2]");
        assert!(plain(&Dynamic::UNIT).is_none());
    }
}
