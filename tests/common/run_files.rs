//! Files of a run, for the comparison of two runs.

// Each program uses a part of this file.
#![allow(dead_code)]

use std::collections::BTreeMap;
use std::path::Path;

/// Files of a run by their paths; summaries without times and memory.
fn files(run: &Path) -> BTreeMap<String, Vec<u8>> {
    fn collect(folder: &Path, run: &Path, found: &mut BTreeMap<String, Vec<u8>>) {
        for entry in std::fs::read_dir(folder).into_iter().flatten() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(run).unwrap().to_string_lossy().into_owned();
            if path.is_dir() {
                collect(&path, run, found);
                continue;
            }
            let mut content = std::fs::read(&path).unwrap();
            if name.ends_with("summary.json") {
                let mut summary: serde_json::Value = serde_json::from_slice(&content).unwrap();
                let members = summary.as_object_mut().unwrap();
                assert!(members.remove("wall_seconds").is_some() && members.remove("peak_memory_bytes").is_some());
                content = serde_json::to_vec(&summary).unwrap();
            }
            found.insert(name, content);
        }
    }
    let mut found = BTreeMap::new();
    collect(run, run, &mut found);
    found
}

/// Difference between two runs: missing files, files with another content.
pub fn difference(expected: &Path, run: &Path) -> Option<String> {
    let (expected, found) = (files(expected), files(run));
    let lacking: Vec<&String> = expected.keys().filter(|name| !found.contains_key(*name)).collect();
    let further: Vec<&String> = found.keys().filter(|name| !expected.contains_key(*name)).collect();
    let differing: Vec<&String> =
        expected.iter().filter(|(name, content)| found.get(*name).is_some_and(|found| found != *content)).map(|(name, _)| name).collect();
    let is_same = lacking.is_empty() && further.is_empty() && differing.is_empty();
    (!is_same).then(|| format!("missing: {lacking:?}; too many: {further:?}; other content: {differing:?}"))
}

/// Fails if two runs differ, with the names of the files.
pub fn assert_same(expected: &Path, run: &Path, when: &str) {
    if let Some(difference) = difference(expected, run) {
        panic!("{when}: {difference}");
    }
}
