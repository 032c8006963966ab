//! Thousands of random scripts, each run uninterrupted, and again killed at random moments (KILL, TERM, INT, HUP) and resumed, with further
//! kills of the resumed run: every file and every printed line must agree.
//!
//! One line for each script with a fault, then the sums.
//!
//! `cargo example kills -- [count] [--first SEED] [--threads N] [--folder DIR]`, or one script with `--script SEED`. The
//! program is the one beside this example.

use std::error::Error;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use clap::Parser;

#[path = "../tests/common/kills/mod.rs"]
mod kills;
#[path = "../tests/common/run_files.rs"]
mod run_files;
#[path = "../tests/common/splitmix.rs"]
mod splitmix;

use kills::course::course;
use kills::generator::script;

/// Random scripts that are killed and resumed.
#[derive(Parser)]
struct Arguments {
    /// Number of scripts
    #[arg(default_value_t = 20)]
    count: u64,
    /// First seed
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Scripts at a time
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Where they run; folders of scripts with a fault stay
    #[arg(long, default_value = "out/kills")]
    folder: PathBuf,
    /// Prints one script
    #[arg(long)]
    script: Option<u64>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let Arguments { count, first, threads, folder, script: shown } = Arguments::parse();
    if let Some(seed) = shown {
        print!("{}", script(seed));
        return Ok(());
    }
    let own = std::env::current_exe()?;
    let program = own.ancestors().nth(2).ok_or("the program is not beside this example")?.join("conserva");
    let (next, sums) = (AtomicU64::new(first), Mutex::new([0; 5]));
    std::thread::scope(|scope| {
        for _ in 0..threads.max(1) {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= first + count {
                        return;
                    }
                    let home = folder.join(seed.to_string());
                    let found = course(&program, &home, seed);
                    let mut sums = sums.lock().unwrap();
                    match &found.fault {
                        Some(fault) => println!("seed {seed}: {fault}"),
                        None => std::fs::remove_dir_all(&home).unwrap_or_default(),
                    }
                    let told =
                        [usize::from(found.fault.is_some()), found.kills, found.resumed, usize::from(found.code != Some(0)), found.doubled];
                    sums.iter_mut().zip(told).for_each(|(sum, one)| *sum += one);
                }
            });
        }
    });
    let [faults, kills, resumed, failed, doubled] = sums.into_inner()?;
    println!(
        "{count} scripts, {kills} kills ({doubled} by two signals in a moment), {resumed} programs that went on: {faults} with a fault \
         ({failed} scripts end with an error or doubt)"
    );
    if faults > 0 { Err("not all ended as if nobody had disturbed them".into()) } else { Ok(()) }
}
