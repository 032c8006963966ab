//! Damaged mesh files for some seconds: no panic, no hang, no exhausted memory.
//!
//! `cargo example fuzz_meshes -- 1800 [SEED]`. The content being read is in `fuzz_mesh_SEED` in the folder for temporary
//! files, so that it is available even if the process dies; a seed reproduces the files.

use std::time::{Duration, Instant};

#[path = "../tests/common/mesh_damage.rs"]
mod mesh_damage;

use conserva::output::peak_memory_bytes;
use mesh_damage::{SplitMix, damaged, judged, originals};

/// Time limit of reading one of these small files.
const SLOW: Duration = Duration::from_secs(2);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let seconds: u64 = arguments.next().map_or(Ok(10), |text| text.parse())?;
    let seed: u64 = arguments.next().map_or(Ok(1), |text| text.parse())?;
    let (originals, mut random) = (originals(), SplitMix(seed));
    let kept = std::env::temp_dir().join(format!("fuzz_mesh_{seed}"));
    let (begin, mut files, mut read, mut slowest) = (Instant::now(), 0u64, 0u64, Duration::ZERO);
    while begin.elapsed() < Duration::from_secs(seconds) {
        let content = damaged(&originals, &mut random);
        std::fs::write(&kept, &content)?;
        let start = Instant::now();
        read += u64::from(judged(&content));
        slowest = slowest.max(start.elapsed());
        files += 1;
        if slowest > SLOW {
            return Err(format!("file {files} of seed {seed} took {slowest:?}; it is {}", kept.display()).into());
        }
    }
    let memory = peak_memory_bytes().map_or(String::new(), |bytes| format!(", peak memory {} kB", bytes / 1024));
    println!(
        "{files} damaged files of {} originals in {seconds} s: {read} read, the rest refused; slowest {slowest:?}{memory}",
        originals.len()
    );
    Ok(())
}
