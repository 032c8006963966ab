//! `conserva sweep`: plans a study, computes its points and collects their results, together or one after the other.

mod arguments;
mod engines;
mod opening;
mod planning;
mod points;
mod progress;

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use super::columns::{aligned, short};
use super::console::{Console, complain, ink};
use super::process::exit_code;
use crate::script::{Class, Diagnostic};
use crate::studies::{Collected, Plan, PointState, StudyColumn, collect};
pub use arguments::Arguments;
use arguments::{CollectArguments, Part, PlanArguments, WholeArguments};
use opening::{enter, interrupted, opened};

/// Largest number of rows of a table on the terminal.
const SHOWN: usize = 40;
/// Largest number of points whose failure is explained at the end.
const TOLD: usize = 10;

/// Executes `conserva sweep`; returns the exit code.
pub fn sweep(arguments: Arguments) -> u8 {
    let done = match arguments.part {
        Some(Part::Plan(arguments)) => plan(&arguments),
        Some(Part::Point(arguments)) => points::compute(&arguments),
        Some(Part::Collect(arguments)) => collect_again(&arguments),
        None => whole(arguments.whole),
    };
    done.unwrap_or_else(|error| {
        complain(&error.render(ink()));
        exit_code(error.class)
    })
}

fn plan(arguments: &PlanArguments) -> Result<u8, Box<Diagnostic>> {
    let planned = planning::planned(&arguments.design)?;
    let console = Console::new(false);
    let (count, last) = (counted(planned.plan.points.len(), "point"), planned.plan.points.len() - 1);
    let folder = planned.shown.display();
    console.note(&format!("{count} planned in {folder}, with the numbers 0 to {last} (points.csv)"));
    console.note(&format!("compute them with `conserva sweep point {folder} --index K`, then `conserva sweep collect {folder}`"));
    Ok(0)
}

fn collect_again(arguments: &CollectArguments) -> Result<u8, Box<Diagnostic>> {
    let (study, plan) = opened(&arguments.folder)?;
    let collected = collect(&study, &plan)?;
    Ok(tell(&plan, &collected, &arguments.folder, &Console::new(arguments.quiet), &[]))
}

fn whole(arguments: WholeArguments) -> Result<u8, Box<Diagnostic>> {
    let interrupt = interrupted()?;
    let planned = planning::planned(&arguments.design)?;
    planning::retry(&planned, arguments.design.retry)?;
    enter(&planned.plan)?;
    let console = Console::new(arguments.compute.quiet);
    let computed = engines::compute(&planned, &arguments.compute, &interrupt, &console);
    let collected = collect(&planned.study, &planned.plan);
    let told = computed?;
    let code = tell(&planned.plan, &collected?, &planned.shown, &console, &told);
    if interrupt.load(Ordering::Relaxed) {
        console.note(&format!("go on with `conserva sweep {}`", planned.shown.display()));
        return Ok(exit_code(Class::Interrupted));
    }
    Ok(code)
}

/// Reports the state of a study, without points reported before; returns the exit code.
fn tell(plan: &Plan, collected: &Collected, shown: &Path, console: &Console, told: &[usize]) -> u8 {
    if !console.is_quiet() {
        small_table(plan, collected).iter().for_each(|line| console.say(line));
    }
    let (completed, failed) = (collected.completed(), collected.failed());
    let troubles = collected.states.iter().enumerate().filter_map(|(index, state)| match state {
        PointState::Done(record) if record.outcome.is_completed() => None,
        PointState::Done(record) => Some((index, record.outcome.word().to_string(), record.cause.clone().unwrap_or_default())),
        PointState::Stopped(who) => Some((index, "stopped".into(), format!("begun and not finished by {who}"))),
        PointState::UnderWay | PointState::Missing => None,
    });
    let troubles: Vec<(usize, String, String)> = troubles.filter(|(index, ..)| !told.contains(index)).collect();
    for (index, outcome, cause) in troubles.iter().take(TOLD) {
        let point = &plan.points[*index];
        let cause: String = cause.chars().take(progress::LONGEST).collect();
        complain(&format!("point {index} ({}) {outcome}: {cause}\n", point.id));
    }
    if troubles.len() > TOLD {
        complain(&format!("and {} more that did not come to their end\n", troubles.len() - TOLD));
    }
    let warned = collected.states.iter().filter(|state| matches!(state, PointState::Done(record) if record.warnings > 0)).count();
    if warned > 0 {
        let who = if warned == 1 { "a point was".into() } else { format!("{warned} points were") };
        console.note(&format!("{who} warned of something: see `warnings` in the table and `output.txt` in the folder of a point"));
    }
    collected.remarks.iter().for_each(|remark| complain(&format!("warning: {remark}\n")));
    let table: PathBuf = shown.join("table.csv");
    if failed > 0 {
        console.note("`command` in the table repeats a point by itself; `--retry failed` computes them again");
    }
    console.note(&format!(
        "{}: {}; table in {}, page in {}",
        counted(plan.points.len(), "point"),
        collected.tally(),
        table.display(),
        shown.join("study.html").display()
    ));
    u8::from(completed < plan.points.len())
}

/// Returns parameters, results and outcomes of a study with few points.
fn small_table(plan: &Plan, collected: &Collected) -> Vec<String> {
    let table = &collected.table;
    if plan.points.len() > SHOWN {
        return Vec::new();
    }
    let columns: Vec<&StudyColumn> =
        table.columns[table.parameters.start..table.results.end].iter().chain(table.column("outcome")).collect();
    let mut rows = vec![columns.iter().map(|column| table.titled(column)).collect::<Vec<_>>()];
    for row in 0..table.rows() {
        let word = |column: &&StudyColumn| match column.numbers() {
            Some(values) => values[row].map_or("-".into(), short),
            None => {
                let cell = column.cell(row);
                if cell.is_empty() { "-".into() } else { cell.chars().take(40).collect() }
            }
        };
        rows.push(columns.iter().map(word).collect());
    }
    aligned(&rows)
}

fn counted(count: usize, word: &str) -> String {
    format!("{count} {word}{}", if count == 1 { "" } else { "s" })
}
