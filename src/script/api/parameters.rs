//! `param(name, default)` and its values from `--set name=value`.
//!
//! The type of the default determines how a value is read: a number, a truth value or a string. A name without any `param` is an error,
//! reported when the script makes a simulation, before time is spent; a name whose `param` was never reached is an error at the end.

use std::cell::RefCell;
use std::collections::BTreeMap;

use rhai::Engine;

use crate::script::api::files::results::unit_of;
use crate::script::language::prelude::*;
use crate::script::language::scan;
use crate::script::language::sources::SourceSpan;
use crate::script::language::values::{as_number, describe};
use crate::script::language::wording::{did_you_mean, listed};

struct Override {
    name: String,
    text: String,
    used: bool,
}

/// Values from the command line, and the parameters that the script has read.
#[derive(Default)]
pub struct Overrides {
    given: RefCell<Vec<Override>>,
    asked: RefCell<Vec<(String, Dynamic)>>,
}

impl Overrides {
    /// Overrides from `name=value` pairs; the last of a name counts.
    pub fn new(pairs: &[(String, String)]) -> Self {
        let mut given: Vec<Override> = Vec::new();
        for (name, text) in pairs {
            given.retain(|earlier| earlier.name != *name);
            given.push(Override { name: name.clone(), text: text.clone(), used: false });
        }
        Overrides { given: RefCell::new(given), asked: RefCell::default() }
    }

    /// Returns the value of a parameter: from the command line if given, otherwise the default.
    ///
    /// # Errors
    /// A value that does not fit the type of the default.
    pub fn value(&self, name: &str, default: Dynamic) -> Result<Dynamic, Failure> {
        let mut given = self.given.borrow_mut();
        let value = match given.iter_mut().find(|given| given.name == name) {
            None => default,
            Some(given) => {
                given.used = true;
                parsed(&given.text, &default).ok_or_else(|| {
                    let kind = kind(&default);
                    Failure::script(format!("`--set {name}={}` must be {kind}", given.text))
                        .code(causes::SETTING)
                        .cause(format!("the script's default is {kind}, {default}"))
                        .hint(format!("write `--set {name}={default}`, for example"))
                })?
            }
        };
        drop(given);
        self.note(name, value.clone());
        Ok(value)
    }

    /// Records a parameter that this session or a worker session has read, with its value.
    pub fn note(&self, name: &str, value: Dynamic) {
        self.given.borrow_mut().iter_mut().filter(|given| given.name == name).for_each(|given| given.used = true);
        let mut asked = self.asked.borrow_mut();
        match asked.iter_mut().find(|(known, _)| known == name) {
            Some((_, known)) => *known = value,
            None => asked.push((name.to_string(), value)),
        }
    }

    /// Parameters that the script has read, with their values.
    pub fn parameters(&self) -> Vec<(String, Dynamic)> {
        self.asked.borrow().clone()
    }

    /// Names of values given by `--set` that the script has not read.
    pub fn unused(&self) -> Vec<String> {
        self.given.borrow().iter().filter(|given| !given.used).map(|given| given.name.clone()).collect()
    }

    fn text(&self, name: &str) -> String {
        self.given.borrow().iter().find(|given| given.name == name).map_or(String::new(), |given| given.text.clone())
    }

    /// Returns the failure of a name whose `param` call, at `place`, was not executed.
    pub fn unreached(&self, name: &str, place: Option<SourceSpan>) -> Failure {
        let failure = Failure::script(format!("`--set {name}={}`: the run ended before the script asked for `{name}`", self.text(name)))
            .code(causes::SETTING);
        failure
            .cause("the statement with this call of `param` was not reached, so the value had no effect")
            .hint("call `param` at the top of the script, outside of any condition and function")
            .placed(place)
    }

    /// Returns the failure of a name without a `param`; `written` are names that the script may still read.
    pub fn unknown(&self, name: &str, written: &[String]) -> Failure {
        let asked = self.asked.borrow();
        let mut names: Vec<&str> = asked.iter().map(|(name, _)| name.as_str()).collect();
        names.extend(written.iter().map(String::as_str).filter(|name| asked.iter().all(|(known, _)| known != name)));
        let failure =
            Failure::script(format!("`--set {name}={}`: the script has no parameter `{name}`", self.text(name))).code(causes::SETTING);
        let failure = match names.as_slice() {
            [] => failure.cause("the script has no parameters").hint(format!("write `param(\"{name}\", default)` in the script")),
            names => failure.cause(format!("its parameters are {}", listed(names, "and"))),
        };
        match did_you_mean(name, names.iter().copied()) {
            Some(suggestion) => failure.hint(suggestion),
            None => failure,
        }
    }
}

/// Units of the parameters for which `param` was given one.
#[derive(Default)]
pub struct ParameterUnits(RefCell<BTreeMap<String, String>>);

impl ParameterUnits {
    /// Returns the units of the parameters that have one, by name.
    pub fn of(host: &Host) -> BTreeMap<String, String> {
        host.slots.get::<ParameterUnits>().0.borrow().clone()
    }

    fn note(&self, name: &str, unit: String) {
        if !unit.is_empty() {
            self.0.borrow_mut().insert(name.to_string(), unit);
        }
    }
}

/// Refuses values of `--set` that the script has not read: at the end of the script all, before only those without any `param`.
///
/// # Errors
/// The first name that is refused.
pub fn check_overrides(host: &Host, engine: &Engine, is_over: bool) -> Result<(), Failure> {
    let overrides = host.slots.get::<Overrides>();
    let unused = overrides.unused();
    if unused.is_empty() {
        return Ok(());
    }
    let texts = host.sources.all();
    let (mut written, mut is_computed) = (Vec::new(), false);
    for (source, text) in &texts {
        let lexemes = scan::lexemes(engine, text);
        for (range, name) in scan::asked_parameters(&lexemes) {
            is_computed |= name.is_none();
            let place = SourceSpan { source: source.clone(), text: text.clone(), range };
            written.extend(name.map(|name| (name, place)));
        }
        let loaded = |path: &str| texts.iter().any(|(name, _)| name.trim_end_matches(".rhai") == path.trim_end_matches(".rhai"));
        is_computed |= scan::imports(&lexemes).iter().any(|path| path.as_deref().is_none_or(|path| !loaded(path)));
    }
    for name in unused {
        match written.iter().find(|(known, _)| *known == name) {
            Some((_, place)) if is_over => return Err(overrides.unreached(&name, Some(host.sources.relocate(place.clone())))),
            Some(_) => {}
            None if is_computed && !is_over => {}
            None => {
                let written: Vec<String> = written.into_iter().map(|(name, _)| name).collect();
                return Err(overrides.unknown(&name, &written));
            }
        }
    }
    Ok(())
}

fn kind(default: &Dynamic) -> &'static str {
    if default.is_bool() {
        "`true` or `false`"
    } else if default.is_string() {
        "a string"
    } else {
        "a number"
    }
}

fn parsed(text: &str, default: &Dynamic) -> Option<Dynamic> {
    let text = text.trim();
    if default.is_bool() {
        return text.parse::<bool>().ok().map(Dynamic::from);
    }
    if default.is_string() {
        let quoted = text.strip_prefix('"').and_then(|inner| inner.strip_suffix('"'));
        return Some(quoted.unwrap_or(text).to_string().into());
    }
    let plain = text.replace('_', "");
    if default.is_int()
        && let Ok(whole) = plain.parse::<i64>()
    {
        return Some(whole.into());
    }
    plain.parse::<f64>().ok().filter(|number| number.is_finite()).map(Dynamic::from)
}

/// Script functions of this topic.
pub fn functions() -> Vec<Function> {
    vec![
        function(Topic::Parameters, "param")
            .summary("the value that `--set name=value` gives on the command line, or else the default")
            .parameters(vec![
                Parameter::text("name", "the parameter's name"),
                Parameter::any("default", "its value when the command line gives none: a number, `true` or `false`, or a string"),
                Parameter::text(
                    "unit",
                    "its unit, such as `\"N/mm\"`, or its dimension, such as `\"force / length\"`, whose unit is that of `units`: \
                 reports, and tables and pages of studies name it",
                )
                .otherwise("no unit is named"),
            ])
            .returns("any")
            .see_also(&["result", "units"])
            .example("let dt = param(\"dt\", 0.005);\nlet stiffness = param(\"stiffness\", 200.0, \"N/mm\");")
            .body(|call| {
                let (name, default) = (call.name("name")?, call.argument("default"));
                let value = default.value();
                if as_number(&value).is_none() && !value.is_bool() && !value.is_string() {
                    return Err(default
                        .refuse(causes::WRONG_TYPE, "`default` of `param` must be a number, `true` or `false`, or a string")
                        .label(format!("this is {}", describe(call.engine(), &value)))
                        .hint("give the value that the parameter has without `--set`")
                        .into());
                }
                call.host.slots.get::<ParameterUnits>().note(&name, unit_of(call)?);
                Ok(call.host.slots.get::<Overrides>().value(&name, value)?)
            }),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn overrides(pairs: &[(&str, &str)]) -> Overrides {
        Overrides::new(&pairs.iter().map(|(name, text)| (name.to_string(), text.to_string())).collect::<Vec<_>>())
    }

    #[test]
    fn the_default_decides_how_a_value_is_read() {
        let given = overrides(&[("a", "0.5"), ("b", "2"), ("c", "true"), ("d", "midpoint"), ("e", "1e-3"), ("f", "4"), ("f", "5")]);
        assert_eq!(given.value("a", 1_i64.into()).unwrap().as_float().unwrap(), 0.5);
        assert_eq!(given.value("b", 1.0.into()).unwrap().as_float().unwrap(), 2.0);
        assert!(given.value("c", false.into()).unwrap().as_bool().unwrap());
        assert_eq!(given.value("d", "x".into()).unwrap().into_string().unwrap(), "midpoint");
        assert_eq!(given.value("e", 1.0.into()).unwrap().as_float().unwrap(), 1e-3);
        assert_eq!(given.value("f", 1_i64.into()).unwrap().as_int().unwrap(), 5);
        assert_eq!(given.value("g", 7_i64.into()).unwrap().as_int().unwrap(), 7);
        assert_eq!(given.unused(), [""; 0]);
        assert!(overrides(&[("a", "fast")]).value("a", 1.0.into()).is_err());
        assert!(overrides(&[("a", "1")]).value("a", true.into()).is_err());
    }

    #[test]
    fn names_that_nobody_asks_for_are_refused() {
        let given = overrides(&[("torqe", "1")]);
        assert!(given.value("torque", 1.0.into()).is_ok());
        assert_eq!(given.unused(), ["torqe"]);
        let failure = given.unknown("torqe", &["later".into()]);
        assert!(failure.title.contains("torqe"));
        assert_eq!(failure.causes, ["its parameters are `torque` and `later`"]);
        assert_eq!(failure.hints, ["did you mean `torque`?"]);
    }
}
