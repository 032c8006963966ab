//! Engines that compute the points of a study: processes on this machine, or Slurm.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use super::arguments::{ComputeArguments, Engine};
use super::planning::Planned;
use super::progress::StudyProgress;
use crate::cli::console::Console;
use crate::cli::process::program;
use crate::script::{Class, Diagnostic};
use crate::studies::{PointState, here, slurm};

/// Period at which Slurm and the folder of the study are queried.
const PERIOD: Duration = Duration::from_secs(1);
/// Period at which interrupts are checked.
const BLINK: Duration = Duration::from_millis(100);

/// Computes the points that are not done; returns the indices of failed points that were reported.
///
/// # Errors
/// An engine that is not available; files that cannot be written.
pub fn compute(
    planned: &Planned,
    arguments: &ComputeArguments,
    interrupt: &AtomicBool,
    console: &Console,
) -> Result<Vec<usize>, Box<Diagnostic>> {
    let program =
        program().map_err(|error| Box::new(Diagnostic::error(Class::Internal, "the program cannot be found").cause(error.to_string())))?;
    let open = here::open_points(&planned.study, &planned.plan);
    let kept = planned.plan.points.len() - open.len();
    if kept > 0 {
        console.note(&format!("{kept} of {} points are done already", planned.plan.points.len()));
    }
    if open.is_empty() {
        return Ok(Vec::new());
    }
    if arguments.engine == Engine::Slurm {
        let words = [("--time", &arguments.time), ("--mem", &arguments.mem), ("--partition", &arguments.partition)];
        let words = words.into_iter().filter_map(|(name, value)| value.as_ref().map(|value| format!("{name}={value}")));
        let job = slurm::Job {
            per_task: arguments.per_task as usize,
            at_once: arguments.at_once.map(|count| count as usize),
            options: words.chain(arguments.sbatch.iter().cloned()).collect(),
            program,
        };
        return by_slurm(planned, open, &job, interrupt, console);
    }
    let processors = std::thread::available_parallelism().map_or(1, usize::from) / usize::from(planned.plan.limits.threads.max(1));
    let jobs = arguments.jobs.map_or(processors.max(1), usize::from);
    let progress = StudyProgress::new(open.len(), arguments.quiet);
    let computed = here::compute_all((&planned.study, &planned.plan), open, (&program, jobs), interrupt, &mut |done| {
        progress.done(&planned.plan, done.index, &done.record);
    });
    progress.finish();
    computed.map(|()| progress.told())
}

/// Follows queued tasks of Slurm, then submits the remaining points and follows these until no task is left.
fn by_slurm(
    planned: &Planned,
    open: Vec<usize>,
    job: &slurm::Job,
    interrupt: &AtomicBool,
    console: &Console,
) -> Result<Vec<usize>, Box<Diagnostic>> {
    let (study, plan) = (&planned.study, &planned.plan);
    let progress = StudyProgress::new(open.len(), console.is_quiet());
    let (mut left, mut is_submitted) = (open, false);
    while !left.is_empty() && !is_submitted {
        let mut jobs = slurm::submitted(study);
        if slurm::tasks_left(&jobs)? > 0 {
            console.note("tasks of this study are with Slurm already: these are followed, and what they leave is submitted");
        } else {
            jobs = slurm::submit(study, plan, &left, job)?;
            is_submitted = true;
            console.note(&format!("submitted to Slurm: job {}", jobs.join(", ")));
        }
        let is_over = follow(planned, &mut left, &jobs, interrupt, &progress)?;
        if !is_over {
            progress.finish();
            let (all, shown) = (jobs.join(" "), planned.shown.display());
            console.note("the tasks go on without this program");
            console.note(&format!("follow them with `conserva sweep {shown} --engine slurm`, or end them with `scancel {all}`"));
            return Ok(progress.told());
        }
    }
    progress.finish();
    Ok(progress.told())
}

/// Follows jobs, and removes computed points from `left`. Returns true when no task or point is left, false on an interrupt.
fn follow(
    planned: &Planned,
    left: &mut Vec<usize>,
    jobs: &[String],
    interrupt: &AtomicBool,
    progress: &StudyProgress,
) -> Result<bool, Box<Diagnostic>> {
    let (study, plan) = (&planned.study, &planned.plan);
    loop {
        let is_over = slurm::tasks_left(jobs)? == 0;
        left.retain(|&index| match study.state(&plan.points[index]) {
            PointState::Done(record) => {
                progress.done(plan, index, &record);
                false
            }
            _ => true,
        });
        if is_over || left.is_empty() {
            return Ok(true);
        }
        for _ in 0..PERIOD.as_millis() / BLINK.as_millis() {
            std::thread::sleep(BLINK);
            if interrupt.load(Ordering::Relaxed) {
                return Ok(false);
            }
        }
    }
}
