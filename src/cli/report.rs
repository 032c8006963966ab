//! `conserva report`: several runs side by side on one page.

use std::path::{Path, PathBuf};

use clap::Args;

use super::complaint::refuse;
use super::console::{Console, complain, ink};
use super::process::exit_code;
use crate::output::{OutputError, ReadError, ReportPage, RunFiles, RunFolder, labels, report_of_several};
use crate::script::{Class, Diagnostic};

/// Largest number of runs on a page: the number of clearly distinguishable colors.
const MOST: usize = 6;

/// Arguments of `conserva report`.
#[derive(Args)]
#[command(after_help = "Exit code: 0 done, 2 no run, or one without a page, 3 the page cannot be written.\n\
    The page of a single run is report.html in its folder. A run that failed has a page, too, which says how it ended. Of a run with \
    several simulations the first one is shown; the others are in folders of their own below it.")]
pub struct Arguments {
    /// Folders of two to six runs, or pages that `report` has written in a script
    #[arg(required = true)]
    runs: Vec<PathBuf>,
    /// The page
    #[arg(long, value_name = "PAGE", default_value = "comparison.html")]
    out: PathBuf,
}

/// Writes the page; returns the exit code.
pub fn report(arguments: Arguments) -> u8 {
    let Arguments { runs, out } = arguments;
    if let Some(error) = refused(&runs, &out) {
        return refuse(&error);
    }
    let mut pages = Vec::new();
    for (path, label) in runs.iter().zip(labels(&runs)) {
        match ReportPage::of_run(path) {
            Ok(page) => pages.push((label, page)),
            Err(error) => return refuse(&error),
        }
    }
    let console = Console::new(true);
    match written(&out, &report_of_several(pages)) {
        Ok(()) => {
            console.say(&out.display().to_string());
            further(&runs, &console);
            0
        }
        Err(error) => {
            let message = Diagnostic::error(Class::Numerics, error.to_string()).code(error.code());
            complain(&message.hint(error.hint()).render(ink()));
            exit_code(Class::Numerics)
        }
    }
}

/// Error of arguments from which no page can be made; `None` for valid ones.
fn refused(runs: &[PathBuf], out: &Path) -> Option<ReadError> {
    if let [only] = runs {
        let hint = format!("the page of this run is {}; name a second run to compare it with", only.join("report.html").display());
        return Some(ReadError::new(only, "is one run, and nothing to compare", hint));
    }
    if let Some(beyond) = runs.get(MOST) {
        let hint = "choose the runs that matter, or make a table of all by `conserva sweep` or `conserva list`";
        return Some(ReadError::new(beyond, format!("is one of {} runs, and a page has room for {MOST}", runs.len()), hint));
    }
    let place = |path: &PathBuf| path.canonicalize().unwrap_or_else(|_| path.clone());
    let is_twice = |(index, path): &(usize, &PathBuf)| runs[..*index].iter().any(|other| place(other) == place(path));
    if let Some((_, path)) = runs.iter().enumerate().find(is_twice) {
        return Some(ReadError::new(path, "is named twice", "name each run once"));
    }
    let is_page = out.extension().is_some_and(|ending| ending == "html" || ending == "htm");
    let hint = format!("write `--out {}`", out.with_extension("html").display());
    (!is_page).then(|| ReadError::new(out, "is no name of a page, which ends with `.html`", hint))
}

fn written(out: &Path, page: &[u8]) -> Result<(), OutputError> {
    let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = out.file_name().unwrap_or_default().to_string_lossy();
    RunFiles::create(folder)?.write(&name, page).map(drop)
}

/// Prints the further simulations in the folders of all runs, with the command for their page.
fn further(runs: &[PathBuf], console: &Console) {
    let names = |path: &PathBuf| RunFolder::open(path).map(|run| run.further()).unwrap_or_default();
    let mut common = names(&runs[0]);
    runs[1..].iter().for_each(|run| common.retain(|name| names(run).contains(name)));
    for name in common {
        let paths: Vec<String> = runs.iter().map(|run| run.join(&name).display().to_string()).collect();
        console.say(&format!("further simulation \"{name}\": conserva report {}", paths.join(" ")));
    }
}
