//! The verification manual: runs the scripts in `tests/verification` and writes `docs/verification.md` with their results.
//!
//! ```text
//! cargo example verification
//! ```
//!
//! The test `verification` compares every row.

use std::error::Error;
use std::path::Path;

#[path = "../tests/verification/manual.rs"]
mod manual;

fn main() -> Result<(), Box<dyn Error>> {
    let documents = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let pictures = documents.join("images/verification");
    std::fs::create_dir_all(&pictures)?;
    let results = std::env::temp_dir().join(format!("conserva-verification-{}", std::process::id()));
    let mut all = Vec::new();
    for &(name, least) in manual::SCRIPTS {
        let begun = std::time::Instant::now();
        let rows = manual::run(name, &results.join(name))?;
        std::fs::copy(results.join(name).join("picture.svg"), pictures.join(format!("{name}.svg")))?;
        println!("{name}: {} rows (at least {least}), {:.1} s", rows.len(), begun.elapsed().as_secs_f64());
        all.push((name, rows));
    }
    std::fs::remove_dir_all(results)?;
    std::fs::write(documents.join("verification.md"), manual::page(&all))?;
    Ok(())
}
