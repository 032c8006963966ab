//! The list of a study's points and what they have in common; `study.json` of its folder.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::design::Rows;
use super::identifier::{digest, identifier};
use super::values::refusal;
use crate::machine::files;
use crate::output::csv_field;
use crate::script::Diagnostic;

/// Version of the file.
pub(super) const FORMAT: u32 = 1;

/// The script, and everything besides the varied parameters that results depend on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Scenario {
    /// The script as it was named.
    pub script: PathBuf,
    /// The folder in which it was named; paths are relative to it.
    pub folder: PathBuf,
    /// A digest of its text.
    pub digest: String,
    /// Parameters that do not vary.
    pub fixed: Vec<(String, String)>,
    /// Folders that the script may read besides its own.
    pub allow_read: Vec<PathBuf>,
    /// Operations after which it counts as endless.
    pub max_operations: u64,
}

impl Scenario {
    /// The digest of the script as it is now.
    ///
    /// # Errors
    /// It cannot be read.
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

/// What a point may take; results do not depend on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Wall time after which a point is given up `[s]`.
    pub seconds: Option<f64>,
    /// Threads of the element loop.
    pub threads: u16,
    /// Memory that the process of a point may take `[bytes]`.
    #[serde(default)]
    pub memory: Option<u64>,
}

/// A point.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Its name, and that of its folder.
    pub id: String,
    /// Values of the parameters that vary.
    pub values: Vec<String>,
}

/// A study: what is computed, and for which values.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Version of the file.
    pub format: u32,
    /// What is computed.
    pub scenario: Scenario,
    /// What a point may take.
    pub limits: Limits,
    /// Names of the parameters that vary.
    pub names: Vec<String>,
    /// The points.
    pub points: Vec<Point>,
}

impl Plan {
    /// A study of some points.
    ///
    /// # Errors
    /// A point twice; a parameter that is also fixed.
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

    /// Parameters of a point as `--set` takes them, those first that do not vary.
    pub fn overrides(&self, point: &Point) -> Vec<(String, String)> {
        let varied = self.names.iter().cloned().zip(point.values.iter().cloned());
        self.scenario.fixed.iter().cloned().chain(varied).collect()
    }

    /// The command that computes a point by itself.
    pub fn command(&self, point: &Point) -> String {
        let mut words = vec!["conserva run".to_string(), quoted(&self.scenario.script.to_string_lossy())];
        words.extend(self.overrides(point).iter().map(|(name, value)| format!("--set {}", quoted(&format!("{name}={value}")))));
        words.extend(self.scenario.allow_read.iter().map(|folder| format!("--allow-read {}", quoted(&folder.to_string_lossy()))));
        words.join(" ")
    }

    /// `points.csv`: the number, the name and the parameters of each.
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

/// A word as a shell takes it.
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
