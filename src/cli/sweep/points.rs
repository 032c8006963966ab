//! `conserva sweep point`: computes points of a planned study, as any engine calls it.

use super::arguments::PointArguments;
use super::opening::{enter, interrupted, opened};
use crate::cli::console::{Console, complain, write_out};
use crate::cli::process::exit_code;
use crate::machine::memory;
use crate::script::{Class, Diagnostic};
use crate::studies::{Plan, PointOutcome, Watchdog, compute as compute_point, here};

/// Computes points; returns the exit code: 0 all completed, 1 one failed, 130 interrupted.
///
/// # Errors
/// A folder without a study, unknown indices, files that cannot be written.
pub fn compute(arguments: &PointArguments) -> Result<u8, Box<Diagnostic>> {
    let interrupt = interrupted()?;
    let (study, plan) = opened(&arguments.folder)?;
    let from_input = arguments.index.trim() == "-";
    let indices = if from_input { Vec::new() } else { numbers(arguments, &plan)? };
    enter(&plan)?;
    plan.limits.memory.into_iter().for_each(memory::set_limit);
    let watchdog = Watchdog::new(interrupt.clone(), || std::process::exit(1)).map_err(|error| {
        let refused = Diagnostic::error(Class::Internal, "no thread could be started");
        Box::new(refused.cause(error.to_string()))
    })?;
    if from_input {
        let mut say = |word: &str| write_out(&format!("{word}\n"));
        here::serve(&study, &plan, &interrupt, &watchdog, &mut say)?;
        return Ok(if watchdog.is_interrupted() { exit_code(Class::Interrupted) } else { 0 });
    }
    let console = Console::new(false);
    let mut is_well = true;
    for index in indices {
        let point = &plan.points[index];
        match compute_point(&study, &plan, point, &watchdog)? {
            PointOutcome::Computed(record) | PointOutcome::Kept(record) => {
                is_well &= record.outcome.is_completed();
                let cause = record.cause.map(|cause| format!(": {cause}")).unwrap_or_default();
                console.say(&format!("point {index} ({}) {}{cause}, {:.2} s", point.id, record.outcome.word(), record.wall_seconds));
            }
            PointOutcome::UnderWay => console.say(&format!("point {index} ({}) is under way elsewhere", point.id)),
            PointOutcome::Interrupted => {
                complain(&format!("point {index} ({}) interrupted; the same command goes on with it\n", point.id));
                return Ok(exit_code(Class::Interrupted));
            }
        }
    }
    Ok(u8::from(!is_well))
}

/// Parses the indices of points in the arguments.
fn numbers(arguments: &PointArguments, plan: &Plan) -> Result<Vec<usize>, Box<Diagnostic>> {
    let mut numbers = parsed(&arguments.index).ok_or_else(|| {
        let error = Diagnostic::error(Class::Script, format!("`--index {}` names no points", arguments.index));
        Box::new(error.hint("write a number (3), or numbers and ranges (0-9,12)"))
    })?;
    if let Some(count) = arguments.count {
        let first = numbers.first().copied().unwrap_or(0);
        numbers = (first..plan.points.len().min(first.saturating_add(count as usize))).collect();
        // A task behind the last point of a study has nothing to do.
        return Ok(numbers);
    }
    match numbers.iter().find(|&&number| number >= plan.points.len()) {
        None => Ok(numbers),
        Some(number) => {
            let error = Diagnostic::error(Class::Script, format!("the study has no point {number}"));
            Err(Box::new(error.cause(format!("its points have the numbers 0 to {}", plan.points.len() - 1)).hint("points.csv lists them")))
        }
    }
}

/// Parses indices such as `3`, `0-9`, `0-9,12`.
fn parsed(text: &str) -> Option<Vec<usize>> {
    let mut all = Vec::new();
    for part in text.split(',') {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        let (first, last) = (first.trim().parse::<usize>().ok()?, last.trim().parse::<usize>().ok()?);
        if first > last || last - first > 1_000_000 {
            return None;
        }
        all.extend(first..=last);
    }
    Some(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_ranges() {
        assert_eq!(parsed("3"), Some(vec![3]));
        assert_eq!(parsed("0-2, 7"), Some(vec![0, 1, 2, 7]));
        for odd in ["", "x", "3-1", "-1", "1-", "1,,2"] {
            assert_eq!(parsed(odd), None, "{odd}");
        }
    }
}
