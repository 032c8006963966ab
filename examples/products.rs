//! Products of the catalogues: small models that combine a row of every catalogue, judged from their files.
//!
//! `cargo example products -- [count] [--first SEED] [--threads N]` runs random ones, one line for each with a fault, then
//! sums. `--cover` runs the covering array and lists refusals with their codes. `--product "ROWS"` runs one product (in the notation of the
//! lines) and prints its script, `--shrink "ROWS"` reduces it first.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::PathBuf;

use clap::Parser;

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../tests/common/scenes/geometry.rs"]
#[allow(dead_code)]
mod plane;
#[path = "../tests/common/products/mod.rs"]
mod products;
#[path = "../tests/common/run_files.rs"]
mod run_files;
#[path = "../tests/common/solids.rs"]
mod solids;
#[path = "../tests/common/splitmix.rs"]
mod splitmix;

use products::cover::Cover;
use products::run::{Bench, Verdict};
use products::script::{Variant, text};
use products::shrink::shrink;
use products::study::Study;
use products::{Catalogue, Named, Product};

/// Refusals of the program when the covering array was last generated.
const REFUSED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/products/refused.txt");

/// Random products of the catalogues.
#[derive(Parser)]
struct Arguments {
    /// Number of products
    #[arg(default_value_t = 200)]
    count: u64,
    /// First seed
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Products at a time
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Where they run
    #[arg(long, default_value = "out/products")]
    folder: PathBuf,
    /// Runs the covering array
    #[arg(long)]
    cover: bool,
    /// Runs one product and prints its script
    #[arg(long)]
    product: Option<String>,
    /// Makes a product smaller, and prints its script
    #[arg(long)]
    shrink: Option<String>,
    /// Makes each product with a fault smaller, and keeps its script in the folder
    #[arg(long)]
    shrink_all: bool,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    std::panic::set_hook(Box::new(|_| ()));
    let worker = std::thread::Builder::new().stack_size(conserva::script::STACK);
    worker.spawn(move || work(&arguments).map_err(|error| error.to_string()))?.join().map_err(|_| "a defect")??;
    Ok(())
}

fn work(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let own = std::env::current_exe()?;
    let program = own.ancestors().nth(2).ok_or("the program is not beside this example")?.join("conserva");
    std::fs::create_dir_all(&arguments.folder)?;
    let home = arguments.folder.canonicalize()?;
    let catalogue = Catalogue::new();
    let strangers = catalogue.strangers();
    if !strangers.is_empty() {
        return Err(format!("rows that nothing draws: {strangers:?}").into());
    }
    let bench = Bench { home: home.join("bench"), program: program.clone() };
    if let Some(words) = arguments.product.as_ref().or(arguments.shrink.as_ref()) {
        let mut product = catalogue.normalized(&catalogue.product(words));
        let mut verdict = bench.judge(Named { catalogue: &catalogue, product: &product });
        if arguments.shrink.is_some() {
            (product, verdict) = shrink(&catalogue, &bench, &product, &verdict);
        }
        let named = Named { catalogue: &catalogue, product: &product };
        println!("{}// {verdict:?}", text(named, Variant::Plain));
        return Ok(());
    }
    let table = std::fs::read_to_string(REFUSED).unwrap_or_default();
    let seeds = arguments.first..arguments.first + arguments.count;
    let (study, cover) = if arguments.cover {
        let (study, cover) = Study::cover(&catalogue, &home, &program, arguments.threads, &table, &[]);
        (study, Some(cover))
    } else {
        (Study::random(&catalogue, &home, &program, arguments.threads, &table, &[], seeds), None)
    };
    if let Some(cover) = &cover {
        tell_cover(cover);
        std::fs::write(home.join("refused.txt"), cover.table())?;
    }
    tell(arguments, &catalogue, &bench, &study)
}

/// Prints the refused rows and the pairs that the covering array left out.
fn tell_cover(cover: &Cover) {
    println!("refused rows:");
    for refusal in &cover.refusals {
        println!("  {} {} | {}", refusal.code, cover.words(&refusal.rows), refusal.title);
    }
    println!("refused pairs:");
    for ((first, second), why) in &cover.excluded {
        println!("  {} | {why}", cover.words(&[*first, *second]));
    }
    println!("{} pairs, {} refused, {} more without a meaning", cover.meant, cover.excluded.len(), cover.meaningless);
}

/// Prints faults and sums.
fn tell(arguments: &Arguments, catalogue: &Catalogue, bench: &Bench, study: &Study) -> Result<(), Box<dyn Error>> {
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    for (product, verdict) in &study.wrong {
        let Verdict::Wrong(faults) = verdict else { continue };
        faults.iter().for_each(|fault| *kinds.entry(fault.kind).or_default() += 1);
        println!("{}: {verdict:?}", Named { catalogue, product });
        if arguments.shrink_all {
            keep(catalogue, bench, product, verdict)?;
        }
    }
    let mut times = study.times.clone();
    times.sort();
    for (time, product) in times.iter().rev().take(5) {
        println!("slow: {time:.2?} {}", Named { catalogue, product });
    }
    let is_told = products::oracle::Fault::is_told;
    let told = |(_, verdict): &&(Product, Verdict)| matches!(verdict, Verdict::Wrong(faults) if faults.iter().all(is_told));
    let failed = study.wrong.iter().filter(told).count();
    println!(
        "{} products: {} sound, {} refused, {failed} failed, {} with silent violations; by kind {kinds:?}",
        study.times.len(),
        study.sound,
        study.refused,
        study.wrong.len() - failed
    );
    Ok(())
}

/// Stores the script of a reduced product.
fn keep(catalogue: &Catalogue, bench: &Bench, product: &Product, verdict: &Verdict) -> Result<(), Box<dyn Error>> {
    let (small, found) = shrink(catalogue, bench, product, verdict);
    let named = Named { catalogue, product: &small };
    let Verdict::Wrong(faults) = &found else { return Ok(()) };
    let fault = &faults[0];
    let words = named.to_string().replace(['=', ' ', ','], "_");
    let folder = arguments_folder(bench).join("found").join(fault.kind);
    std::fs::create_dir_all(&folder)?;
    let first = Named { catalogue, product };
    std::fs::write(
        folder.join(format!("{words}.rhai")),
        format!("{}// {}: {}\n// first: {first}\n", text(named, Variant::Plain), fault.kind, fault.found),
    )?;
    println!("shrunk: {named}: {}: {}", fault.kind, fault.found);
    Ok(())
}

fn arguments_folder(bench: &Bench) -> PathBuf {
    bench.home.parent().map(PathBuf::from).unwrap_or_default()
}
