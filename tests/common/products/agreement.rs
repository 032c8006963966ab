//! Agreement of printed values, history, frames and summary of a run.

use std::path::{Path, PathBuf};

use conserva::output::{read_frames, read_summary};

use super::geometry::Frame;
use super::oracle::{Fault, History};
use super::run::Ended;
use super::{Named, told};

/// Findings after which results are not to be trusted: the exit code is 4.
const DOUBTS: [&str; 2] = ["energy_defect", "positive_contact_work"];

/// Compares history, state, frames and summary.
pub fn agreement(product: Named, ended: &Ended, history: &History, out: &Path) -> Vec<Fault> {
    let mut faults = state(ended, history);
    faults.extend(summary(product, ended, history, out));
    faults.extend(frames(ended, out));
    faults
}

/// Compares the state printed by the script with the last row of the history.
fn state(ended: &Ended, history: &History) -> Vec<Fault> {
    let mut faults = Vec::new();
    for line in told::lines(&ended.printed, "column") {
        let Some((name, value)) = line.rsplit_once(": ") else { continue };
        let last = history.table.column(name).and_then(|column| column.values.last().copied().flatten());
        let same = match (value.parse::<f64>().ok().filter(|value| !value.is_nan()), last.filter(|value| !value.is_nan())) {
            (Some(told), Some(last)) => told == last,
            (None, None) => true,
            _ => false,
        };
        if !same {
            faults.push(Fault::new("history_told", format!("{name}: {value} told, {last:?} in history.csv")));
        }
    }
    let last = |name: &str| history.column(name).last().copied().unwrap_or(f64::NAN);
    let energy = told::first(&ended.printed, "energy");
    for (name, value) in ["kinetic", "strain", "potential", "total"].iter().zip(&energy) {
        if *value != last(name) {
            faults.push(Fault::new("state_told", format!("{name}: {value} told, {} in history.csv", last(name))));
        }
    }
    for (name, value) in ["momentum_x", "momentum_y", "momentum_z"].iter().zip(told::first(&ended.printed, "momentum")) {
        if history.table.column(name).is_some() && value != last(name) {
            faults.push(Fault::new("state_told", format!("{name}: {value} told, {} in history.csv", last(name))));
        }
    }
    let time = told::first(&ended.printed, "time").first().copied().unwrap_or(f64::NAN);
    if time != last("time") {
        faults.push(Fault::new("state_told", format!("time: {time} told, {} in history.csv", last("time"))));
    }
    if history.table.rows() == 0 {
        faults.push(Fault::new("no_history", "no row"));
    }
    faults
}

/// Compares the summary with the history and the exit code.
fn summary(product: Named, ended: &Ended, history: &History, out: &Path) -> Vec<Fault> {
    let mut faults = Vec::new();
    match read_summary(&out.join("summary.json")) {
        Ok(summary) => {
            let number = |key: &str| summary[key].as_f64().unwrap_or(f64::NAN);
            let outcome = summary["outcome"].as_str().unwrap_or_default();
            if !["completed", "not conserving"].contains(&outcome) {
                faults.push(Fault::new("outcome", format!("{outcome} with the exit code {}", ended.code)));
            }
            let steps = told::first(&ended.printed, "steps").first().copied().unwrap_or(f64::NAN);
            // Steps that `restore` has discarded are counted in the summary.
            let goes_back = product.is("task", &["restore", "back"]);
            let is_path = product.is("task", &["follow_load"]);
            if number("steps") != steps && !is_path && !(goes_back && number("steps") > steps) {
                faults.push(Fault::new("summary", format!("{} steps, told {steps}", number("steps"))));
            }
            // Iterations of a path search are counted in the rows of its points, not in those of the run, which it does not change.
            let iterations: f64 = history.column("newton_iterations").iter().sum();
            if number("newton_iterations") < iterations && !is_path {
                faults.push(Fault::new("summary", format!("{} iterations, {iterations} in history.csv", number("newton_iterations"))));
            }
            let kinds: Vec<&str> =
                summary["findings"].as_array().map(|all| all.iter().filter_map(|one| one["kind"].as_str()).collect()).unwrap_or_default();
            let doubtful = kinds.iter().any(|kind| DOUBTS.contains(kind));
            if doubtful != (ended.code == 4) {
                faults.push(Fault::new("exit_code", format!("{} with findings {kinds:?}", ended.code)));
            } else if doubtful {
                // The program reports the violation itself, exactly once.
                return vec![Fault::new("doubtful", format!("findings {kinds:?}"))];
            }
        }
        Err(error) => faults.push(Fault::new("summary", error.to_string())),
    }
    faults
}

/// Compares the frames with the state printed by the script.
fn frames(ended: &Ended, out: &Path) -> Vec<Fault> {
    let mut faults = Vec::new();
    let told: Vec<f64> = told::lines(&ended.printed, "displacement").into_iter().flat_map(told::numbers).collect();
    let frames = read_frames(&out.join("fields.pvd")).unwrap_or_default();
    let latest = frames.last().map(|frame| frame.path.clone());
    let places: Vec<PathBuf> = [Some(out.join("end.vtu")), latest].into_iter().flatten().collect();
    for place in places {
        match Frame::read(&place) {
            Ok(frame) => {
                let dimension = if frame.points.is_empty() { 1 } else { told.len() / frame.points.len() };
                let written: Vec<f64> = frame.displacement.iter().flat_map(|u| u[..dimension.min(3)].to_vec()).collect();
                if written != told {
                    let name = place.file_name().unwrap_or_default().to_string_lossy().into_owned();
                    faults.push(Fault::new("frame", format!("displacements of {name} are others than those told")));
                }
            }
            Err(error) => faults.push(Fault::new("frame", error)),
        }
    }
    faults
}
