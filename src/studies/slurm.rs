//! Computes the points of a study as array jobs of Slurm: a batch script, its submission, and the number of remaining tasks.
//!
//! Tasks call `conserva sweep point`; the folder of the study records computed points. Slurm is queried only for remaining tasks. A
//! requeued task continues with the points that are not computed.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::folder::StudyFolder;
use super::plan::{Plan, quoted};
use super::values::refusal;
use crate::script::{Class, Diagnostic};

/// Distribution of points over the tasks of Slurm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Job {
    /// Number of points per task.
    pub per_task: usize,
    /// Largest number of simultaneous tasks.
    pub at_once: Option<usize>,
    /// Further options of `sbatch`, each a word such as `--partition=short`.
    pub options: Vec<String>,
    /// Program called by the tasks.
    pub program: PathBuf,
}

/// File with the numbers of submitted jobs.
const JOBS: &str = "slurm/jobs.txt";
/// Default of the largest number of tasks of an array, if Slurm does not report it.
const ARRAY: usize = 1001;

/// Runs a command of Slurm and returns its output.
fn ask(command: &mut Command) -> Result<String, Box<Diagnostic>> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command.output().map_err(|error| {
        let refused = Diagnostic::error(Class::Script, format!("`{name}` could not be started")).cause(error.to_string());
        Box::new(refused.hint("Slurm's commands must be installed where the study is submitted; without them, leave `--engine slurm` out"))
    })?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    let said = String::from_utf8_lossy(&output.stderr);
    let error = Diagnostic::error(Class::Script, format!("`{name}` refused"));
    let error = said.lines().filter(|line| !line.trim().is_empty()).fold(error, |error, line| error.cause(line));
    Err(Box::new(error.hint("options such as `--time`, `--mem`, `--partition` and `--sbatch` are passed on as they are")))
}

/// Returns the largest number of tasks of an array: indices are 0 to `MaxArraySize - 1`.
fn array_size() -> Result<usize, Box<Diagnostic>> {
    let settings = ask(Command::new("scontrol").args(["show", "config"]))?;
    let line = settings.lines().find_map(|line| line.trim().strip_prefix("MaxArraySize")).and_then(|rest| rest.split_once('='));
    Ok(line.and_then(|(_, size)| size.trim().parse().ok()).filter(|&size| size > 0).unwrap_or(ARRAY))
}

/// Submits points; returns the numbers of the jobs.
///
/// # Errors
/// Slurm refuses or is not available; files that cannot be written.
pub(crate) fn submit(study: &StudyFolder, plan: &Plan, points: &[usize], job: &Job) -> Result<Vec<String>, Box<Diagnostic>> {
    for path in [study.path(), &job.program] {
        refuse_control_characters(path)?;
    }
    let size = array_size()?;
    let tasks: Vec<&[usize]> = points.chunks(job.per_task.max(1)).collect();
    let mut jobs = Vec::new();
    for tasks in tasks.chunks(size) {
        let number = (0..).find(|number| !study.path().join(format!("slurm/job-{number}.sh")).exists()).unwrap_or(0);
        let lines: Vec<String> = tasks.iter().map(|points| ranges(points)).collect();
        let list = study.write(&format!("slurm/tasks-{number}.txt"), (lines.join("\n") + "\n").as_bytes())?;
        let script = study.write(&format!("slurm/job-{number}.sh"), batch(study, plan, job, tasks.len(), &list).as_bytes())?;
        let mut command = Command::new("sbatch");
        command.arg("--parsable").arg(format!("--output={}/slurm/%A_%a.txt", study.path().to_string_lossy().replace('%', "%%")));
        let answer = ask(command.args(&job.options).arg(&script))?;
        // `--parsable` gives the number, and the cluster's name behind a semicolon where there are several.
        let id = answer.trim().split(';').next().unwrap_or_default().to_string();
        if id.is_empty() || !id.bytes().all(|byte| byte.is_ascii_digit()) {
            return Err(Box::new(refusal("`sbatch` did not say the number of the job").cause(answer.trim())));
        }
        jobs.push(id);
        let all = [submitted(study), jobs.clone()].concat();
        study.write(JOBS, (deduplicated(all).join("\n") + "\n").as_bytes())?;
    }
    Ok(jobs)
}

/// Refuses a path with characters that Slurm or the shell of its nodes would misread.
fn refuse_control_characters(path: &Path) -> Result<(), Box<Diagnostic>> {
    // Behind a backslash, Slurm does not expand `%A`.
    if !path.to_string_lossy().contains(|sign: char| sign.is_control() || sign == '\\') {
        return Ok(());
    }
    let error =
        refusal(format!("Slurm cannot be given the path {path:?}")).cause("it has a backslash, a line break or another control character");
    Err(Box::new(error.hint("give the folder another name, or choose another one with `--out`")))
}

/// Returns the batch script of an array.
fn batch(study: &StudyFolder, plan: &Plan, job: &Job, tasks: usize, list: &Path) -> String {
    let throttle = job.at_once.map(|count| format!("%{count}")).unwrap_or_default();
    let name = plan.scenario.script.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let name: String = name.chars().map(|sign| if sign.is_ascii_alphanumeric() { sign } else { '-' }).collect();
    let words = |path: &Path| quoted(&path.to_string_lossy());
    format!(
        "#!/bin/sh\n\
         # Computes points of a study; each task has a line of the list.\n\
         #SBATCH --job-name=conserva-{name}\n\
         #SBATCH --array=0-{last}{throttle}\n\
         #SBATCH --cpus-per-task={threads}\n\
         #SBATCH --requeue\n\
         #SBATCH --open-mode=append\n\
         points=$(sed -n \"$((SLURM_ARRAY_TASK_ID + 1))p\" {list_word})\n\
         exec {program} sweep point {folder_word} --index \"$points\"\n",
        last = tasks - 1,
        threads = plan.limits.threads.max(1),
        list_word = words(list),
        program = words(&job.program),
        folder_word = words(study.path()),
    )
}

/// Formats indices for `--index`: `0-3,7`.
fn ranges(points: &[usize]) -> String {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for &point in points {
        match runs.last_mut().filter(|run| run[1] + 1 == point) {
            Some(run) => run[1] = point,
            None => runs.push([point, point]),
        }
    }
    runs.iter()
        .map(|&[first, last]| if first == last { first.to_string() } else { format!("{first}-{last}") })
        .collect::<Vec<_>>()
        .join(",")
}

fn deduplicated(mut all: Vec<String>) -> Vec<String> {
    all.sort_by_key(|id| id.parse::<u64>().unwrap_or(u64::MAX));
    all.dedup();
    all
}

/// Returns the numbers of all jobs that were submitted for a study.
pub fn submitted(study: &StudyFolder) -> Vec<String> {
    let text = std::fs::read_to_string(study.path().join(JOBS)).unwrap_or_default();
    text.lines().map(|line| line.trim().to_string()).filter(|line| !line.is_empty()).collect()
}

/// Returns the number of tasks of jobs that wait, run or are about to run again.
///
/// # Errors
/// Slurm is not available.
pub(crate) fn tasks_left(jobs: &[String]) -> Result<usize, Box<Diagnostic>> {
    if jobs.is_empty() {
        return Ok(0);
    }
    // Query all of the user's tasks: a query of a single job fails when Slurm no longer has the job.
    let mut command = Command::new("squeue");
    command.args(["--noheader", "--array", "--format=%A %F", "--states=PENDING,RUNNING,SUSPENDED,COMPLETING,CONFIGURING,REQUEUED"]);
    let answer = ask(command.arg("--me"))?;
    let is_ours = |line: &&str| line.split_whitespace().any(|id| jobs.iter().any(|job| job == id));
    Ok(answer.lines().filter(is_ours).count())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_a_folder_is_called_it_is_one_word_of_the_batch_script() {
        let root = std::env::temp_dir().join(format!("conserva-slurm-{}", std::process::id()));
        for name in ["plain", "it's \"two\" words", "50%A \\ $(touch hit)", "#SBATCH --wrap=x"] {
            let study = StudyFolder::create(&root.join(name)).unwrap();
            let job = Job { per_task: 1, program: study.path().join("conserva"), ..Job::default() };
            let script = batch(&study, &Plan::default(), &job, 3, &study.path().join("slurm/tasks-0.txt"));
            let lines: Vec<&str> = script.lines().collect();
            let (directives, commands) = lines.split_at(lines.len() - 2);
            assert!(directives.iter().all(|line| line.starts_with('#') && !line.contains(name)), "{script}");
            let word = quoted(&study.path().join("slurm/tasks-0.txt").to_string_lossy());
            assert!(commands[0].starts_with("points=$(sed -n ") && commands[0].ends_with(&format!(" {word})")), "{script}");
            assert!(commands[1].starts_with("exec ") && commands[1].ends_with(" --index \"$points\""), "{script}");
        }
        let error = refuse_control_characters(Path::new("out/a\ntouch hit\n")).unwrap_err();
        assert!(error.title.contains("\"out/a\\ntouch hit\\n\""), "{}", error.title);
        std::fs::remove_dir_all(root).unwrap();
    }

    #[test]
    fn numbers_in_a_row_are_written_as_ranges() {
        assert_eq!(ranges(&[0, 1, 2, 3, 7, 9, 10]), "0-3,7,9-10");
        assert_eq!(ranges(&[5]), "5");
        assert_eq!(deduplicated(["10", "9", "10"].map(String::from).to_vec()), ["9", "10"]);
    }
}
