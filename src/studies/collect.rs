//! Collects table, pictures and page of a study from the records of its points.

use super::collected::Collected;
use super::draw::{StudyPicture, pictures};
use super::folder::{PointState, StudyFolder, unwritten};
use super::page::page;
use super::plan::Plan;
use super::record::RecordOutcome;
use super::table::StudyTable;
use crate::output::{OutputError, svg};
use crate::script::Diagnostic;

/// Writes `table.csv`, `units.json`, `table.parquet`, `pictures/` and `study.html` from the present points.
///
/// # Errors
/// A file that cannot be written.
pub fn collect(study: &StudyFolder, plan: &Plan) -> Result<Collected, Box<Diagnostic>> {
    let _lock = study.lock()?;
    let (table, states) = StudyTable::of(study, plan);
    let remarks = remarks(plan, &states);
    let pictures = pictures(&table);
    let collected = Collected { table, states, remarks };
    study.write("table.csv", &collected.table.to_csv())?;
    study.write("units.json", collected.table.units_json().as_bytes())?;
    match collected.table.to_parquet() {
        Ok(bytes) => drop(study.write("table.parquet", &bytes)?),
        Err(reason) => return Err(Box::new(super::values::refusal("the table cannot be written as Parquet").cause(reason))),
    }
    remove_pictures(study)?;
    for StudyPicture { name, drawing, .. } in &pictures {
        study.write(&format!("pictures/{name}.svg"), svg(drawing).as_bytes())?;
    }
    study.write("study.html", page(study, plan, &collected, &pictures).as_bytes())?;
    Ok(collected)
}

/// Removes the pictures of an earlier collection, some of which may show results that no longer exist.
fn remove_pictures(study: &StudyFolder) -> Result<(), Box<Diagnostic>> {
    let path = study.path().join("pictures");
    match std::fs::remove_dir_all(&path) {
        Err(source) if source.kind() != std::io::ErrorKind::NotFound => Err(unwritten(&OutputError::Write { path, source })),
        _ => Ok(()),
    }
}

/// Returns remarks on inconsistent points: computed by different versions, or from different scripts.
fn remarks(plan: &Plan, states: &[PointState]) -> Vec<String> {
    let records = || states.iter().filter_map(|state| if let PointState::Done(record) = state { Some(record) } else { None });
    let different = |mut all: Vec<String>| {
        all.sort();
        all.dedup();
        all
    };
    let mut remarks = Vec::new();
    let versions = different(records().map(|record| record.version.clone()).collect());
    if versions.len() > 1 {
        remarks.push(format!("points were computed by different versions of the program: {}", versions.join(", ")));
    }
    // A failed point may not have written all of its files.
    let ended = records().filter(|record| record.outcome == RecordOutcome::Completed);
    let scripts = different(ended.filter_map(|record| record.scripts.clone()).collect());
    let reads_others = scripts.len() > 1;
    if reads_others {
        remarks.push(format!(
            "points were computed from {} different texts of {} and of the files that it reads; `--retry all` computes all anew",
            scripts.len(),
            plan.scenario.script.display()
        ));
    }
    remarks
}
