//! A page of several runs side by side, made from their pages.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::assets::{COMPARISON, LAST_OF_SEVERAL, PROGRAM};
use super::page::LAYOUT;
use super::template::{TemplateParts, fill};
use crate::output::reading::error::{ReadError, bytes_of};
use crate::output::reading::folder::RunFolder;

/// Name of the page in the folder of a run.
const NAME: &str = "report.html";

/// Start of the element with the small data of a page.
const DATA: &str = "<script type=\"application/json\" id=\"data\">";
/// Start of an element with a packed array, up to its name.
const BLOB: &str = "<script type=\"text/plain\" id=\"";
const END: &str = "</script>";

/// Data of a run's page.
#[derive(Debug)]
pub struct ReportPage {
    data: Value,
    /// Packed arrays with their names.
    blobs: Vec<(String, String)>,
}

/// Cause why a page cannot be shown beside others.
#[derive(Clone, Debug, PartialEq, Eq)]
enum PageError {
    /// The file is no page of a run.
    NoReport,
    /// The page shows several runs.
    Several,
    /// The page was made by a version of the program with another layout.
    Version(String),
}

impl ReportPage {
    /// Reads the page of a run, given by its folder or by the page itself.
    ///
    /// # Errors
    /// A folder without a run or without a page; a file that is no page of a run.
    pub fn of_run(path: &Path) -> Result<Self, ReadError> {
        let place = if path.is_file() { path.to_path_buf() } else { page_in(path)? };
        ReportPage::read(&bytes_of(&place)?).map_err(|error| match error {
            PageError::NoReport => {
                ReadError::new(&place, "is no report of a run", "name the folder of a run, or a page that `report` has written")
            }
            PageError::Several => ReadError::new(&place, "shows several runs", "name the folders of those runs"),
            PageError::Version(version) => ReadError::new(
                &place,
                format!("was made by version {version} of the program, with other data"),
                "run its script again with this version",
            ),
        })
    }

    /// Data of a page.
    ///
    /// # Errors
    /// Cause why the page cannot be used.
    fn read(page: &[u8]) -> Result<Self, PageError> {
        let page = std::str::from_utf8(page).map_err(|_| PageError::NoReport)?;
        let start = page.find(DATA).ok_or(PageError::NoReport)? + DATA.len();
        let length = page[start..].find(END).ok_or(PageError::NoReport)?;
        let data: Value = serde_json::from_str(&page[start..start + length]).map_err(|_| PageError::NoReport)?;
        if data.get("runs").is_some() {
            return Err(PageError::Several);
        }
        if data.get("layout").and_then(Value::as_u64) != Some(LAYOUT) {
            let version = data.get("version").and_then(Value::as_str).ok_or(PageError::NoReport)?;
            return Err(PageError::Version(version.into()));
        }
        let mut blobs = Vec::new();
        let mut rest = &page[start + length..];
        while let Some(place) = rest.find(BLOB) {
            rest = &rest[place + BLOB.len()..];
            let Some((name, tail)) = rest.split_once("\">") else { return Err(PageError::NoReport) };
            let Some((text, tail)) = tail.split_once(END) else { return Err(PageError::NoReport) };
            blobs.push((name.to_string(), text.to_string()));
            rest = tail;
        }
        Ok(ReportPage { data, blobs })
    }

    /// Data of a page given by its bytes, such as that of a running simulation; `None` if the bytes are no page.
    pub fn of_bytes(page: &[u8]) -> Option<Self> {
        ReportPage::read(page).ok()
    }
}

/// Path of the page in the folder of a run.
fn page_in(path: &Path) -> Result<PathBuf, ReadError> {
    let run = RunFolder::open(path)?;
    run.file(NAME).ok_or_else(|| {
        let hint = format!("`conserva resume {}` goes on with it and writes the page; or leave it out", path.display());
        ReadError::new(path, format!("has no {NAME}: the run was cut off before its end, or still goes on"), hint)
    })
}

/// Returns distinct labels of runs: the ends of their paths, as short as possible.
pub fn labels(paths: &[PathBuf]) -> Vec<String> {
    let folder = |path: &PathBuf| if path.ends_with(NAME) { path.parent().unwrap_or(path).to_path_buf() } else { path.clone() };
    let parts =
        |path: &PathBuf| -> Vec<String> { folder(path).components().map(|part| part.as_os_str().to_string_lossy().into_owned()).collect() };
    let all: Vec<Vec<String>> = paths.iter().map(parts).collect();
    let end = |parts: &Vec<String>, count: usize| parts[parts.len().saturating_sub(count)..].join("/");
    let label = |parts: &Vec<String>| {
        let is_own = |count: &usize| all.iter().filter(|other| end(other, *count) == end(parts, *count)).count() == 1;
        end(parts, (1..=parts.len()).find(is_own).unwrap_or(parts.len()))
    };
    all.iter().map(label).collect()
}

/// Returns the page of several runs with their labels.
pub fn report_of_several(runs: Vec<(String, ReportPage)>) -> Vec<u8> {
    let title = runs.iter().map(|(label, _)| label.as_str()).collect::<Vec<_>>().join(", ");
    let (mut all, mut blobs) = (Vec::new(), Vec::new());
    for (number, (label, ReportPage { mut data, blobs: own })) in runs.into_iter().enumerate() {
        let prefix = format!("run-{number}-");
        data["label"] = label.into();
        data["prefix"] = prefix.clone().into();
        all.push(data);
        blobs.extend(own.into_iter().map(|(name, text)| (format!("{prefix}{name}"), text)));
    }
    let data = json!({ "version": env!("CARGO_PKG_VERSION"), "runs": all });
    let program: Vec<&str> = PROGRAM.into_iter().chain([LAST_OF_SEVERAL]).collect();
    fill(COMPARISON, &TemplateParts { title: &title, connections: "", program: &program, data: &data, blobs: &blobs })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_the_shortest_ends_that_differ() {
        let paths = ["out/a/run", "out/b/run/report.html", "out/c", "c.html"].map(PathBuf::from);
        assert_eq!(labels(&paths), ["a/run", "b/run", "c", "c.html"]);
    }

    #[test]
    fn files_that_are_no_page_are_refused() {
        assert_eq!(ReportPage::read(b"<html></html>").unwrap_err(), PageError::NoReport);
        assert_eq!(ReportPage::read(&[0xff, 0xfe]).unwrap_err(), PageError::NoReport);
        let page = |data: &str| ReportPage::read(format!("{DATA}{data}{END}").as_bytes()).map(|page| page.blobs.len());
        assert_eq!(page("{"), Err(PageError::NoReport));
        assert_eq!(page("{\"runs\": []}"), Err(PageError::Several));
        assert_eq!(page("{\"version\": \"0.1.0\"}"), Err(PageError::Version("0.1.0".into())));
        assert_eq!(page(&format!("{{\"layout\": {LAYOUT}}}")), Ok(0));
    }
}
