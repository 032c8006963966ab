//! Pictures and movies of a script in the page of a run.

use super::artifacts::Artifacts;
use crate::machine::files;
use crate::output::{ReportPicture, RunFiles};
use crate::script::api::files::run_folder::RunFolder;
use crate::script::api::files::shown::Pictures;
use crate::script::language::host::Host;

/// Largest size of all pictures in a page `[bytes]`; further ones are listed by name only, so that the page stays small.
const SIZE: usize = 4 << 20;

/// Returns the pictures in the folder of a simulation and those in the folder of the run.
pub fn pictures(host: &Host, name: &str, artifacts: &Artifacts) -> Vec<ReportPicture> {
    let run = RunFolder::of(host).files(host).ok().flatten();
    let mut left = SIZE;
    let shown = |(simulation, path): (Option<String>, String)| {
        let files = match &simulation {
            Some(simulation) if simulation == name => artifacts.files(),
            Some(_) => return None,
            None => run.as_ref()?,
        };
        let bytes = content(files, &path, left);
        left -= bytes.as_ref().map_or(0, Vec::len);
        Some(ReportPicture { path, bytes })
    };
    Pictures::of(host).into_iter().filter_map(shown).collect()
}

/// Returns the content of a file; `None` for a file that is missing or larger than `most` bytes.
fn content(files: &RunFiles, path: &str, most: usize) -> Option<Vec<u8>> {
    let place = files.place(path).ok()?;
    let length = std::fs::metadata(&place).ok()?.len();
    if length > most as u64 { None } else { files::read(&place).ok() }
}
