//! Points of a study and their common data; `study.json` in the folder of the study.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::design::Rows;
use super::identifier::{digest, identifier};
use super::values::refusal;
use crate::machine::files;
use crate::output::csv_field;
use crate::script::Diagnostic;

/// Version of the file format.
pub(super) const FORMAT: u32 = 1;

/// Script, and all data besides the varied parameters on which results depend.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Scenario {
    /// Path of the script as given.
    pub script: PathBuf,
    /// Folder to which paths are relative.
    pub folder: PathBuf,
    /// Digest of the script's text.
    pub digest: String,
    /// Parameters that do not vary.
    pub fixed: Vec<(String, String)>,
    /// Folders that the script may read besides its own.
    pub allow_read: Vec<PathBuf>,
    /// Number of operations after which the script counts as endless.
    pub max_operations: u64,
}

impl Scenario {
    /// Returns the digest of the present script.
    ///
    /// # Errors
    /// The script cannot be read.
    pub(crate) fn digest_now(folder: &Path, script: &Path) -> Result<String, Box<Diagnostic>> {
        match files::read(&folder.join(script)) {
            Ok(text) => Ok(digest([&text[..]])),
            Err(error) => {
                let refused = refusal(format!("the script {} cannot be read", script.display())).cause(error.to_string());
                Err(Box::new(refused.hint("check the path of the script")))
            }
        }
    }
}

/// Limits of time, threads and memory per point; results do not depend on these.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Wall time after which a point is stopped `[s]`.
    pub seconds: Option<f64>,
    /// Threads of the element loop.
    pub threads: u16,
    /// Memory limit of the process of a point `[bytes]`.
    #[serde(default)]
    pub memory: Option<u64>,
}

/// A point of a study: one set of parameter values.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Name of the point and of its folder.
    pub id: String,
    /// Values of the varied parameters.
    pub values: Vec<String>,
}

/// A study: the scenario and its parameter values.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Version of the file format.
    pub format: u32,
    /// Script and fixed parameters.
    pub scenario: Scenario,
    /// Limits of time, threads and memory per point.
    pub limits: Limits,
    /// Names of the varied parameters.
    pub names: Vec<String>,
    /// Points of the study, in the order of computation.
    pub points: Vec<Point>,
}

impl Plan {
    /// Returns the plan of a study with the given points.
    ///
    /// # Errors
    /// A point twice; a parameter that is both varied and fixed.
    pub fn new(scenario: Scenario, limits: Limits, rows: Rows) -> Result<Self, Box<Diagnostic>> {
        if let Some((name, _)) = scenario.fixed.iter().find(|(name, _)| rows.names.contains(name)) {
            let error = refusal(format!("the parameter `{name}` both varies and is set"));
            return Err(Box::new(error.hint(format!("leave out `--set {name}=…`, or do not vary it"))));
        }
        let name = |values: Vec<String>| Point { id: identifier(&rows.names, &values), values };
        let points: Vec<Point> = rows.rows.into_iter().map(name).collect();
        let mut ids: Vec<&str> = points.iter().map(|point| point.id.as_str()).collect();
        ids.sort_unstable();
        if let Some(twice) = ids.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(Box::new(refusal(format!("the point {} stands twice in the study", twice[0])).hint("name each value once")));
        }
        Ok(Plan { format: FORMAT, scenario, limits, names: rows.names, points })
    }

    /// Returns the parameters of a point for `--set`, fixed ones first.
    pub fn overrides(&self, point: &Point) -> Vec<(String, String)> {
        let varied = self.names.iter().cloned().zip(point.values.iter().cloned());
        self.scenario.fixed.iter().cloned().chain(varied).collect()
    }

    /// Returns the command that computes a single point.
    pub fn command(&self, point: &Point) -> String {
        let mut words = vec!["conserva run".to_string(), quoted(&self.scenario.script.to_string_lossy())];
        words.extend(self.overrides(point).iter().map(|(name, value)| format!("--set {}", quoted(&format!("{name}={value}")))));
        words.extend(self.scenario.allow_read.iter().map(|folder| format!("--allow-read {}", quoted(&folder.to_string_lossy()))));
        words.join(" ")
    }

    /// Returns `points.csv`: index, name and parameters of each point.
    pub fn to_csv(&self) -> Vec<u8> {
        let head = ["index", "id"].into_iter().chain(self.names.iter().map(String::as_str));
        let mut lines = vec![head.map(csv_field).collect::<Vec<_>>().join(",")];
        for (index, point) in self.points.iter().enumerate() {
            let fields = [index.to_string(), csv_field(&point.id)].into_iter().chain(point.values.iter().map(|value| csv_field(value)));
            lines.push(fields.collect::<Vec<_>>().join(","));
        }
        (lines.join("\n") + "\n").into_bytes()
    }
}

/// Quotes a word for a shell.
pub(super) fn quoted(word: &str) -> String {
    let is_plain = !word.is_empty() && word.chars().all(|sign| sign.is_ascii_alphanumeric() || "._+-=,/:@%".contains(sign));
    if is_plain { word.into() } else { format!("'{}'", word.replace('\'', r"'\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(fixed: &[(&str, &str)], rows: &[&[&str]]) -> Result<Plan, Box<Diagnostic>> {
        let fixed = fixed.iter().map(|(name, value)| (name.to_string(), value.to_string())).collect();
        let scenario = Scenario { script: "a b.rhai".into(), fixed, ..Scenario::default() };
        let rows = rows.iter().map(|row| row.iter().map(ToString::to_string).collect()).collect();
        Plan::new(scenario, Limits::default(), Rows { names: vec!["dt".into(), "law".into()], rows })
    }

    #[test]
    fn a_point_tells_the_command_that_repeats_it() {
        let plan = plan(&[("held", "true")], &[&["0.01", "it's, hard"]]).unwrap();
        let command = plan.command(&plan.points[0]);
        assert_eq!(command, r"conserva run 'a b.rhai' --set held=true --set dt=0.01 --set 'law=it'\''s, hard'");
        let text = String::from_utf8(plan.to_csv()).unwrap();
        assert!(text.starts_with("index,id,dt,law\n0,\"dt=0.01,law=it-s- hard~") || text.contains("\"it's, hard\""), "{text}");
    }

    #[test]
    fn a_point_twice_and_a_parameter_fixed_and_varied_are_refused() {
        assert!(plan(&[], &[&["1", "a"], &["1", "a"]]).unwrap_err().contains("dt=1,law=a stands twice"));
        assert!(plan(&[("dt", "2")], &[&["1", "a"]]).unwrap_err().contains("`dt` both varies and is set"));
    }
}
