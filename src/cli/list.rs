//! `conserva list`: the runs below a folder, with the parameters in which they differ.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::{Value, json};

use super::columns::{aligned, short};
use super::complaint::refuse;
use super::console::{Console, complain, ink};
use super::diff::Format;
use super::process::exit_code;
use crate::output::{ReadError, RunFolder, read_table, runs_below};
use crate::script::{Class, Diagnostic};

/// Arguments of `conserva list`.
#[derive(Args)]
pub struct Arguments {
    /// Folder to search
    #[arg(value_name = "DIR", default_value = "out")]
    folder: PathBuf,
    /// Output format
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

/// A run in the list.
struct Listed {
    folder: PathBuf,
    script: Option<String>,
    parameters: Vec<(String, Value)>,
    outcome: String,
    steps: Option<f64>,
    end_time: Option<f64>,
    energy_drift: Option<f64>,
    wall_seconds: Option<f64>,
}

/// Lists runs; returns the exit code.
pub fn list(arguments: Arguments) -> u8 {
    let Arguments { folder, format } = arguments;
    if let Err(error) = std::fs::read_dir(&folder) {
        return refuse(&ReadError::io(&folder, &error));
    }
    let runs: Vec<Listed> = runs_below(&folder).iter().map(|path| listed(path)).collect();
    let console = Console::new(true);
    if format == Format::Json {
        let all: Vec<Value> = runs.iter().map(json_of).collect();
        console.say(&serde_json::to_string_pretty(&all).unwrap_or_default());
        return 0;
    }
    if runs.is_empty() {
        let error = Diagnostic::error(Class::Script, format!("there is no run below {}", folder.display()));
        complain(&error.hint("`conserva run script.rhai` writes one into out/script").render(ink()));
        return exit_code(Class::Script);
    }
    let header = ["run", "script", "parameters that differ", "outcome", "steps", "end time", "energy drift", "wall s"];
    let number = |value: Option<f64>| value.map_or("-".into(), short);
    let mut rows = vec![header.map(String::from).to_vec()];
    for run in &runs {
        let shown = run.folder.strip_prefix(&folder).ok().filter(|path| !path.as_os_str().is_empty()).unwrap_or(&run.folder);
        let outcome: String = run.outcome.chars().take(60).collect();
        rows.push(vec![
            shown.display().to_string(),
            run.script.clone().unwrap_or_else(|| "-".into()),
            differing(run, &runs),
            outcome,
            number(run.steps),
            number(run.end_time),
            run.energy_drift.map_or("-".into(), |drift| format!("{drift:.1e}")),
            run.wall_seconds.map_or("-".into(), |seconds| format!("{seconds:.2}")),
        ]);
    }
    if rows[1..].iter().all(|row| row[2].is_empty()) {
        rows.iter_mut().for_each(|row| drop(row.remove(2)));
    }
    aligned(&rows).iter().for_each(|line| console.say(line));
    0
}

fn listed(path: &Path) -> Listed {
    let run = match RunFolder::open(path) {
        Ok(run) => run,
        Err(error) => {
            let nothing = (None, None, None, None, None);
            let (script, steps, end_time, energy_drift, wall_seconds) = nothing;
            return Listed {
                folder: path.into(),
                script,
                parameters: Vec::new(),
                outcome: error.to_string(),
                steps,
                end_time,
                energy_drift,
                wall_seconds,
            };
        }
    };
    let table = run.file("history.csv").map(|file| read_table(&file));
    let last = |name: &str| match &table {
        Some(Ok(read)) => read.table.column(name)?.values.last().copied().flatten(),
        _ => None,
    };
    let outcome = match &table {
        Some(Err(error)) => format!("{}; {error}", run.outcome()),
        _ => run.outcome(),
    };
    Listed {
        folder: path.into(),
        script: run.text("script"),
        parameters: run.parameters(),
        outcome,
        steps: run.number("steps").or_else(|| last("step")),
        end_time: last("time"),
        energy_drift: run.number("energy_drift"),
        wall_seconds: run.summary.as_ref().and_then(|summary| summary.get("wall_seconds")?.get("total")?.as_f64()),
    }
}

/// Returns the parameters of a run that differ in other runs of its script.
fn differing(run: &Listed, all: &[Listed]) -> String {
    let value = |other: &Listed, name: &str| other.parameters.iter().find(|(known, _)| known == name).map(|(_, value)| value.clone());
    let others = || all.iter().filter(|other| other.script == run.script && run.script.is_some());
    let differ = run.parameters.iter().filter(|(name, own)| others().any(|other| value(other, name).as_ref() != Some(own)));
    differ
        .map(|(name, value)| format!("{name}={}", value.as_str().map_or_else(|| value.to_string(), String::from)))
        .collect::<Vec<_>>()
        .join(" ")
}

fn json_of(run: &Listed) -> Value {
    json!({
        "run": run.folder.display().to_string(),
        "script": run.script,
        "parameters": run.parameters.iter().cloned().collect::<serde_json::Map<_, _>>(),
        "outcome": run.outcome,
        "steps": run.steps.map(|steps| steps as u64),
        "end_time": run.end_time,
        "energy_drift": run.energy_drift,
        "wall_seconds": run.wall_seconds,
    })
}
