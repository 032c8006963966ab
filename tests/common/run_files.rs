//! All files of a run, to compare two of them.

use std::collections::BTreeMap;
use std::path::Path;

/// All files of a run by their paths; of a summary all but times and memory.
fn files(run: &Path) -> BTreeMap<String, Vec<u8>> {
    fn collect(folder: &Path, run: &Path, found: &mut BTreeMap<String, Vec<u8>>) {
        for entry in std::fs::read_dir(folder).unwrap() {
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

/// Fails where two runs differ, with the name of the first file that does.
pub fn assert_same(expected: &Path, run: &Path, when: &str) {
    let (expected, found) = (files(expected), files(run));
    assert_eq!(expected.keys().collect::<Vec<_>>(), found.keys().collect::<Vec<_>>(), "{when}");
    let differing: Vec<&String> = expected.iter().filter(|(name, content)| found[*name] != **content).map(|(name, _)| name).collect();
    assert!(differing.is_empty(), "{when}: {differing:?}");
}
