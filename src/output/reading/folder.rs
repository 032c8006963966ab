//! The folder of a run as a whole: its files, and the runs below a folder.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::error::{ReadError, bytes_of};
use crate::output::summary::SUMMARY;

/// Largest depth of folders searched for runs.
const DEPTH: usize = 32;

/// Folder of a simulation: that of the run for the first one, a folder below it for each further one.
#[derive(Clone, Debug)]
pub struct RunFolder {
    /// Path of the folder.
    pub path: PathBuf,
    /// Content of `summary.json`; `None` if the run was killed or is still running.
    pub summary: Option<Value>,
}

impl RunFolder {
    /// Opens a folder that a run has written.
    ///
    /// # Errors
    /// A folder that does not exist or holds no run; a summary that is damaged.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let kind = std::fs::metadata(path).map_err(|error| ReadError::io(path, &error))?;
        if !kind.is_dir() {
            return Err(ReadError::new(path, "is a file, not the folder of a run", "name the folder that it is in"));
        }
        if !is_run(path) {
            let hint = match runs_below(path).first() {
                Some(run) => {
                    format!("name one of the runs below it, such as {}; `conserva list {}` shows them", run.display(), path.display())
                }
                None => "name a folder that `conserva run` has written, such as out/bearing".into(),
            };
            return Err(ReadError::new(path, "holds no run: there is neither history.csv nor summary.json in it", hint));
        }
        let summary = path.join(SUMMARY);
        let summary = if summary.is_file() { Some(read_summary(&summary)?) } else { None };
        Ok(RunFolder { path: path.into(), summary })
    }

    /// Returns the path of a file of the run if it exists.
    pub fn file(&self, name: &str) -> Option<PathBuf> {
        Some(self.path.join(name)).filter(|path| path.is_file())
    }

    /// Names of the further simulations of the run, which are also names of folders.
    pub fn further(&self) -> Vec<String> {
        let names = folders_of(&self.path).into_iter().filter(|path| is_run(path));
        names.filter_map(|path| Some(path.file_name()?.to_string_lossy().into_owned())).collect()
    }

    /// An entry of the summary as text.
    pub fn text(&self, key: &str) -> Option<String> {
        self.summary.as_ref()?.get(key)?.as_str().map(String::from)
    }

    /// An entry of the summary as a number.
    pub fn number(&self, key: &str) -> Option<f64> {
        self.summary.as_ref()?.get(key)?.as_f64()
    }

    /// Parameters of the run by name.
    pub fn parameters(&self) -> Vec<(String, Value)> {
        let map = self.summary.as_ref().and_then(|summary| summary.get("parameters")).and_then(Value::as_object);
        map.into_iter().flatten().map(|(name, value)| (name.clone(), value.clone())).collect()
    }

    /// Outcome of the run in words.
    pub fn outcome(&self) -> String {
        self.text("outcome").unwrap_or_else(|| "no summary: killed, or still running".into())
    }
}

/// Reads a summary.
///
/// # Errors
/// A file that cannot be read or is no JSON object.
pub fn read_summary(path: &Path) -> Result<Value, ReadError> {
    let bytes = bytes_of(path)?;
    match serde_json::from_slice::<Value>(&bytes) {
        Ok(value) if value.is_object() => Ok(value),
        Ok(_) => Err(ReadError::damaged(path, "it is no JSON object")),
        Err(error) => Err(ReadError::damaged(path, format!("it is no JSON from line {}, column {} on", error.line(), error.column()))),
    }
}

/// True if a folder holds a run.
pub fn is_run(path: &Path) -> bool {
    ["history.csv", SUMMARY].iter().any(|name| path.join(name).is_file())
}

/// Returns the folders in a folder in the order of their names, without hidden ones and links.
fn folders_of(path: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
    let visible = entries.filter(|entry| !entry.file_name().to_string_lossy().starts_with('.'));
    let mut folders: Vec<PathBuf> =
        visible.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir())).map(|entry| entry.path()).collect();
    folders.sort();
    folders
}

/// The runs in a folder and below it, in the order of their paths.
pub fn runs_below(path: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    search(path, DEPTH, &mut found);
    found
}

fn search(path: &Path, depth: usize, found: &mut Vec<PathBuf>) {
    if is_run(path) {
        found.push(path.into());
    }
    if depth > 0 {
        folders_of(path).iter().for_each(|folder| search(folder, depth - 1, found));
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::samples::scratch;
    use super::*;

    #[test]
    fn runs_are_found_in_order_and_others_refused() {
        let (directory, files) = scratch("folder");
        for name in ["b/history.csv", "a/summary.json", "a/a-2/history.csv", ".hidden/history.csv", "a/fields/x.vtu"] {
            files.write(name, "{}").unwrap();
        }
        let below: Vec<PathBuf> = runs_below(&directory).iter().map(|path| path.strip_prefix(&*directory).unwrap().into()).collect();
        assert_eq!(below, [Path::new("a"), Path::new("a/a-2"), Path::new("b")]);
        let run = RunFolder::open(&directory.join("a")).unwrap();
        assert_eq!((run.further(), run.outcome()), (vec!["a-2".to_string()], "no summary: killed, or still running".into()));
        assert!(run.file("history.csv").is_none());
        let error = RunFolder::open(&directory).unwrap_err();
        assert!(error.to_string().contains("holds no run") && error.hint.contains("conserva list"), "{error} {}", error.hint);
        assert!(RunFolder::open(&directory.join("none")).unwrap_err().to_string().ends_with("does not exist"));
        assert!(RunFolder::open(&directory.join("b/history.csv")).unwrap_err().to_string().contains("is a file"));
        files.write("a/summary.json", "{\n  \"steps\": ").unwrap();
        assert!(RunFolder::open(&directory.join("a")).unwrap_err().to_string().contains("it is no JSON from line 2"));
    }
}
