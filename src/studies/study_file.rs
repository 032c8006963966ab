//! Study files (TOML), beside the scenario that they refer to.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::values::{Values, Varied, refusal};
use crate::machine::files;
use crate::script::Diagnostic;

/// Content of a study file; each key except `script` corresponds to an option of the command.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudyFile {
    /// Path of the scenario, relative to the folder of the file.
    pub script: PathBuf,
    /// Varied parameters: arrays of values, or texts as for `--vary`.
    #[serde(default)]
    vary: toml::Table,
    /// Fixed parameters.
    #[serde(default)]
    set: toml::Table,
    /// Path of a file of points, relative to the folder of the study file.
    pub values: Option<PathBuf>,
    /// Value of the option `--sample`.
    pub sample: Option<String>,
    /// Value of the option `--seed`.
    pub seed: Option<u32>,
    /// Value of the option `--zip`.
    #[serde(default)]
    pub zip: bool,
    /// Value of the option `--point-time`.
    pub point_time: Option<String>,
}

/// Reads a study file; its paths become relative to the current folder.
///
/// # Errors
/// A file that cannot be read, does not parse, or has unknown keys.
pub fn read_study_file(path: &Path) -> Result<StudyFile, Box<Diagnostic>> {
    let refused = |cause: String| Box::new(refusal(format!("the study file {} cannot be read", path.display())).cause(cause).hint(EXAMPLE));
    let text = files::read_text(path).map_err(|error| refused(error.to_string()))?;
    let mut file: StudyFile = toml::from_str(&text).map_err(|error| {
        let line = error.span().map(|span| format!("line {}: ", text[..span.start.min(text.len())].matches('\n').count() + 1));
        refused(format!("{}{}", line.unwrap_or_default(), error.message()))
    })?;
    let folder = path.parent().unwrap_or(Path::new(""));
    file.script = folder.join(&file.script);
    file.values = file.values.map(|values| folder.join(values));
    Ok(file)
}

const EXAMPLE: &str =
    "a study file is TOML: script = 'bearing.rhai', and below [vary] lines such as dt = [0.01, 0.005] or torque = '0.05..0.2:7'";

impl StudyFile {
    /// Returns the varied parameters, in the order of the file.
    ///
    /// # Errors
    /// A value is neither an array of plain values nor a text as accepted by `--vary`.
    pub fn varied(&self) -> Result<Vec<Varied>, Box<Diagnostic>> {
        let wrong =
            |name: &str, cause: String| Box::new(refusal(format!("the values of `{name}` in the study file")).cause(cause).hint(EXAMPLE));
        let one = |(name, value): (&String, &toml::Value)| {
            let values = match value {
                toml::Value::Array(all) => {
                    let listed = all.iter().map(plain).collect::<Option<Vec<String>>>().filter(|all| !all.is_empty());
                    Values::Listed(listed.ok_or_else(|| wrong(name, "an array of numbers, texts or truth values is wanted".into()))?)
                }
                toml::Value::String(text) => text.parse().map_err(|reason| wrong(name, reason))?,
                other => Values::Listed(vec![plain(other).ok_or_else(|| wrong(name, "an array or a text is wanted".into()))?]),
            };
            Ok(Varied { name: name.clone(), values })
        };
        self.vary.iter().map(one).collect()
    }

    /// Returns the fixed parameters.
    ///
    /// # Errors
    /// A value is not plain.
    pub fn fixed(&self) -> Result<Vec<(String, String)>, Box<Diagnostic>> {
        let one = |(name, value): (&String, &toml::Value)| {
            let text = plain(value).ok_or_else(|| {
                let refused = refusal(format!("the value of `{name}` in the study file"));
                Box::new(refused.cause("a number, a text or a truth value is expected").hint(EXAMPLE))
            })?;
            Ok((name.clone(), text))
        };
        self.set.iter().map(one).collect()
    }
}

/// Converts a value into a text for `--set`.
fn plain(value: &toml::Value) -> Option<String> {
    match value {
        toml::Value::String(text) => Some(text.clone()),
        toml::Value::Integer(whole) => Some(whole.to_string()),
        toml::Value::Float(number) => Some(number.to_string()),
        toml::Value::Boolean(flag) => Some(flag.to_string()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_file_says() {
        let text =
            "script = 'bearing.rhai'\nsample = 'sobol:8'\n[vary]\ntorque = '0..1:3'\ndt = [0.01, 1, true, 'x']\n[set]\nheld = false\n";
        let file: StudyFile = toml::from_str(text).unwrap();
        let varied = file.varied().unwrap();
        assert_eq!(varied[0].name, "torque");
        assert_eq!(varied[0].values, Values::Listed(["0", "0.5", "1"].map(String::from).to_vec()));
        assert_eq!(varied[1].values, Values::Listed(["0.01", "1", "true", "x"].map(String::from).to_vec()));
        assert_eq!(file.fixed().unwrap(), [("held".to_string(), "false".to_string())]);
        let nested: StudyFile = toml::from_str("script = \"x\"\n[vary]\na = [[1]]").unwrap();
        assert!(nested.varied().unwrap_err().contains("an array of numbers"));
    }

    #[test]
    fn a_mistyped_key_is_named_with_its_line() {
        let folder = std::env::temp_dir().join(format!("conserva study file {}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("x.toml");
        std::fs::write(&path, "script = \"x.rhai\"\nvarry = 1\n").unwrap();
        let error = read_study_file(&path).unwrap_err();
        assert!(error.contains("line 2: unknown field `varry`"), "{error:?}");
        assert!(read_study_file(&folder.join("none.toml")).is_err());
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
