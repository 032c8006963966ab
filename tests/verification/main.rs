//! Every row of the verification manual is within its tolerance, and `docs/verification.md` shows these rows.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

mod manual;

use manual::{Row, SCRIPTS, run};

/// Rows of all scripts, computed on two threads.
fn all() -> Vec<(&'static str, Vec<Row>)> {
    let folder = std::env::temp_dir().join(format!("conserva-verification-{}", std::process::id()));
    let next = AtomicUsize::new(0);
    let work = || {
        let mut done = Vec::new();
        while let Some(&(name, _)) = SCRIPTS.get(next.fetch_add(1, Ordering::Relaxed)) {
            done.push((name, run(name, &folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))));
        }
        done
    };
    let mut rows = std::thread::scope(|scope| {
        let other = scope.spawn(work);
        let mut rows = work();
        rows.extend(other.join().expect("the scripts run"));
        rows
    });
    rows.sort_by_key(|&(name, _)| name);
    std::fs::remove_dir_all(folder).expect("it is there");
    rows
}

#[test]
fn every_row_is_within_its_tolerance_and_in_the_manual() {
    let page = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/verification.md")).unwrap_or_default();
    let mut wrong = Vec::new();
    for ((name, rows), (_, least)) in all().iter().zip(SCRIPTS) {
        assert!(rows.len() >= *least, "{name} has {} rows", rows.len());
        for row in rows {
            if !row.holds() {
                wrong.push(format!("outside: {name}: {row:?}"));
            }
            if !page.contains(&row.head()) {
                wrong.push(format!("not in docs/verification.md: {}: run `cargo example verification`", row.head()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
