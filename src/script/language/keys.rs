//! The keys of options maps, checked before the body of a function runs.
//!
//! Unknown keys are refused before missing ones are named, because a misspelt key is both.

use rhai::{EvalAltResult, Map};

use super::arguments::Arguments;
use super::causes;
use super::failure::Failure;
use super::function::Call;
use super::habits;
use super::parameter::{Kind, Parameter};
use super::scan::Target;
use super::values::describe;
use super::wording::{did_you_mean, listed};

impl Call<'_> {
    /// Checks the keys of options maps: unknown ones first, then missing ones.
    ///
    /// # Errors
    /// The first wrong key.
    pub fn check(&self) -> Result<(), Box<EvalAltResult>> {
        for (index, parameter) in self.function.parameters.iter().enumerate() {
            let (Some(keys), Some(value)) = (parameter.kind.keys(), self.value(index)) else { continue };
            let Some(map) = value.read_lock::<Map>() else { return Err(self.argument(parameter.name).wrong_type().into()) };
            if !matches!(parameter.kind, Kind::OpenOptions(_)) {
                self.check_unknown(index, keys, &map)?;
            }
            self.check_inner(index, keys, &map)?;
            self.check_missing(index, keys, &map)?;
        }
        Ok(())
    }

    fn check_unknown(&self, index: usize, keys: &[Parameter], map: &Map) -> Result<(), Failure> {
        let title = self.function.title();
        let names: Vec<&str> = keys.iter().map(|key| key.name).collect();
        let Some(unknown) = map.keys().find(|key| !names.contains(&key.as_str())) else { return Ok(()) };
        let free = names.iter().copied().filter(|name| !map.contains_key(*name));
        let suggestion = habits::option(unknown)
            .map(String::from)
            .or_else(|| did_you_mean(unknown, free))
            .or_else(|| did_you_mean(unknown, names.iter().copied()));
        let failure = self
            .refuse(causes::UNKNOWN_OPTION, format!("{title} has no option `{unknown}`"))
            .at(Target::Key { argument: index, key: unknown.to_string(), value: false })
            .label("unknown option")
            .cause(format!("its options are {}", listed(&names, "and")));
        Err(failure.hint(suggestion.unwrap_or_else(|| "remove the option, or look up its name in the list above".into())))
    }

    /// Checks the maps that are values of keys.
    fn check_inner(&self, index: usize, keys: &[Parameter], map: &Map) -> Result<(), Failure> {
        for key in keys {
            let (Kind::Options(inner), Some(value)) = (&key.kind, map.get(key.name)) else { continue };
            let target = Target::Key { argument: index, key: key.name.into(), value: true };
            match value.read_lock::<Map>() {
                Some(map) => self.check_nested(key, inner, &map, target)?,
                None => {
                    let (title, given) = (self.function.title(), describe(self.engine(), value));
                    let failure =
                        self.refuse(causes::WRONG_TYPE, format!("`{}` of {title} must be {}", key.name, key.requirement())).at(target);
                    return Err(failure
                        .code(causes::WRONG_TYPE)
                        .label(format!("this is {given}"))
                        .hint(format!("write `{}: #{{ name: value, … }}`", key.name)));
                }
            }
        }
        Ok(())
    }

    /// Checks the keys of a map inside an options map, all of which are optional.
    fn check_nested(&self, outer: &Parameter, keys: &[Parameter], map: &Map, target: Target) -> Result<(), Failure> {
        let names: Vec<&str> = keys.iter().map(|key| key.name).collect();
        let Some(unknown) = map.keys().find(|key| !names.contains(&key.as_str())) else { return Ok(()) };
        let failure =
            self.refuse(causes::NO_SUCH, format!("`{}` of {} has no entry `{unknown}`", outer.name, self.function.title())).at(target);
        let failure = failure
            .code(causes::UNKNOWN_OPTION)
            .label(format!("`{unknown}` is unknown"))
            .cause(format!("its entries are {}", listed(&names, "and")));
        Err(failure.hint(did_you_mean(unknown, names.iter().copied()).unwrap_or_else(|| "remove the entry".into())))
    }

    fn check_missing(&self, index: usize, keys: &[Parameter], map: &Map) -> Result<(), Failure> {
        let missing: Vec<&Parameter> = keys.iter().filter(|key| !key.is_optional() && !map.contains_key(key.name)).collect();
        let Some(first) = missing.first().copied() else { return Ok(()) };
        let names: Vec<&str> = missing.iter().map(|key| key.name).collect();
        let (title, plural) = (self.function.title(), if missing.len() == 1 { "" } else { "s" });
        let mut failure = self
            .refuse(causes::MISSING, format!("{title} needs the option{plural} {}", listed(&names, "and")))
            .at(Target::Argument(index))
            .label(format!("`{}` is missing", first.name));
        for key in missing {
            failure = failure.cause(format!("`{}`: {}, {}", key.name, key.summary, key.requirement()));
        }
        Err(failure.hint(format!("write `{}(#{{ {}: …, … }})`", self.function.name, first.name)))
    }
}
