//! `conserva diff`: differences between two runs.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::columns::{aligned, short, visible};
use super::complaint::refuse;
use super::console::Console;
use crate::output::{Comparison, Exactness, compare, pretty_unit};

/// Arguments of `conserva diff`.
#[derive(Args)]
#[command(
    after_help = "Exit code: 0 the runs are the same, 1 they differ, 2 they cannot be compared (no run, damage, no time in common).\n\
    Rows are compared where both runs have the same time. Wall-clock times and memory are never compared; another path of the script and \
    another version of the program are told, but make no difference, and so is that neither run was completed."
)]
pub struct Arguments {
    /// Folder of a run
    first: PathBuf,
    /// Folder of another run
    second: PathBuf,
    /// Largest difference that counts as equal, relative to the largest value of its kind (all energies are one kind, and so on)
    #[arg(long, value_name = "REL", default_value_t = 0.0, value_parser = tolerance, allow_negative_numbers = true)]
    tolerance: f64,
    /// Leave out a column or field (`*` stands for anything: `--ignore "race.*"`); may be given several times
    #[arg(long, value_name = "NAME")]
    ignore: Vec<String>,
    /// Output format
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

/// Output format of a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Text for a terminal
    Text,
    /// JSON for programs
    Json,
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value >= 0.0 && value.is_finite() => Ok(value),
        _ => Err("write a number that is not negative, such as --tolerance 1e-9".into()),
    }
}

/// Compares two runs; returns the exit code.
pub fn diff(arguments: Arguments) -> u8 {
    let Arguments { first, second, tolerance, ignore, format } = arguments;
    let all = match compare(&first, &second, &Exactness { tolerance, ignored: ignore }) {
        Ok(all) => all,
        Err(error) => return refuse(&error),
    };
    let same = all.iter().all(Comparison::is_same);
    let console = Console::new(true);
    match format {
        Format::Json => {
            let value = serde_json::json!({ "same": same, "tolerance": tolerance, "simulations": all });
            console.say(&serde_json::to_string_pretty(&value).unwrap_or_default());
        }
        Format::Text => {
            all.iter().flat_map(told).for_each(|line| console.say(&visible(&line)));
            let rows: usize = all.iter().map(|found| found.rows[2]).sum();
            let frames: usize = all.iter().map(|found| found.frames_compared).sum();
            let (columns, fields) = (all[0].columns_compared, all[0].fields_compared);
            let within = if tolerance > 0.0 { format!(" within {tolerance:e}") } else { String::new() };
            let verdict = if same { "same" } else { "different" };
            console.say(&format!(
                "{verdict}{within}: {rows} rows with {columns} columns and {frames} frames with {fields} arrays were compared"
            ));
            if let Some(outcome) = &all[0].unfinished {
                console.say(&visible(&format!("neither run was completed, and both ended so: {outcome}")));
            }
        }
    }
    u8::from(!same)
}

/// Returns a comparison as lines of text.
fn told(found: &Comparison) -> Vec<String> {
    let mut lines = Vec::new();
    let is_silent = found.is_same() && found.entries.is_empty();
    if !found.simulation.is_empty() && !is_silent {
        lines.push(format!("simulation \"{}\"", found.simulation));
    }
    for entry in &found.entries {
        let value = |value: &serde_json::Value| match value {
            serde_json::Value::Null => "none".to_string(),
            serde_json::Value::String(text) => text.clone(),
            value => value.to_string(),
        };
        let note = if entry.counts { "" } else { "  (makes no difference)" };
        lines.push(format!("{}: {} | {}{note}", entry.name, value(&entry.first), value(&entry.second)));
    }
    let [first, second, common] = found.rows;
    if first != second {
        lines.push(format!("rows of history.csv: {first} | {second}, of which {common} have the same time"));
    }
    lines.extend(found.missing.iter().cloned());
    let size = |value: Option<f64>| value.map_or("-".into(), short);
    let with_unit = |text: String, unit: Option<&String>| unit.map_or(text.clone(), |unit| format!("{text} {}", pretty_unit(unit)));
    let of_column = |name: &str| found.units.as_ref().and_then(|units| units.columns.get(name));
    let of_field = |name: &str| found.units.as_ref().and_then(|units| units.fields.get(name));
    let moment = |time: f64| with_unit(short(time), of_column("time"));
    if !found.columns.is_empty() {
        let mut rows = vec![["column", "from step", "t", "rows", "largest difference", "relative", "at step"].map(String::from).to_vec()];
        rows.extend(found.columns.iter().map(|column| {
            let (from, count, at) = (column.from_step.to_string(), column.rows.to_string(), column.at_step.to_string());
            let largest = with_unit(size(column.largest), of_column(&column.column));
            vec![column.column.clone(), from, moment(column.from_time), count, largest, size(column.relative), at]
        }));
        lines.extend(aligned(&rows));
    }
    if !found.fields.is_empty() {
        let head = ["field", "of", "from t", "frames", "largest difference", "relative", "at t", "at", "places"];
        let mut rows = vec![head.map(String::from).to_vec()];
        rows.extend(found.fields.iter().map(|field| {
            let (from, frames, at_time) = (moment(field.from_time), field.frames.to_string(), moment(field.at_time));
            let (at, places) = (field.at.to_string(), field.places.to_string());
            let (largest, relative) = (with_unit(size(field.largest), of_field(&field.field)), size(field.relative));
            vec![field.field.clone(), field.series.into(), from, frames, largest, relative, at_time, at, places]
        }));
        lines.extend(aligned(&rows));
    }
    lines
}
