//! Products of the catalogues: random ones, and every allowed pair of rows, in small models that are judged from their files.
//!
//! More random products, with reduction of failing ones: `cargo example products -- 1000 --shrink-all`. Known refusals are
//! listed in `products/refused.txt`, so that their causes need not be searched; `--cover` rewrites this table. Known violations that are to
//! be repaired are listed in `products/known.txt` and, for the array of all pairs, in `products/known_of_pairs.txt`.

#[path = "common/mod.rs"]
mod common;
#[path = "common/scenes/geometry.rs"]
#[allow(dead_code)]
mod plane;
#[path = "common/products/mod.rs"]
mod products;
#[path = "common/run_files.rs"]
mod run_files;
#[path = "common/solids.rs"]
mod solids;
#[path = "common/splitmix.rs"]
mod splitmix;

use std::path::{Path, PathBuf};

use products::cover::Cover;
use products::oracle;
use products::run::{Bench, Manner, Verdict, run};
use products::script::{Variant, text};
use products::study::{Known, Study};
use products::{Catalogue, Named};

/// Known refusals, one per line: code, rows, title.
const REFUSED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/products/refused.txt");

/// Known violations, one per line: kinds of faults, rows of the product, name of the fault. A line without an occurrence fails the test.
const KNOWN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/products/known.txt");

/// Known violations of the array of all pairs, in the form of [`KNOWN`].
const KNOWN_OF_PAIRS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/products/known_of_pairs.txt");

/// Known violations of the products of an elastic-plastic material, in the form of [`KNOWN`].
const KNOWN_OF_FLOW: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/products/known_of_flow.txt");

/// Number of random products.
const RANDOM: u64 = 300;

/// Number of random products of an elastic-plastic material.
const FLOWING: u64 = 200;

/// Smallest fraction of the meaningful pairs that are drawn; the others are refused.
const DRAWN: f64 = 0.8;

fn home(name: &str) -> PathBuf {
    let home = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("products-{name}"));
    let _ = std::fs::remove_dir_all(&home);
    std::fs::create_dir_all(&home).expect("the folder can be made");
    home.canonicalize().expect("it is there")
}

fn program() -> &'static Path {
    Path::new(env!("CARGO_BIN_EXE_conserva"))
}

#[test]
fn every_row_of_the_catalogues_is_drawn() {
    let strangers = Catalogue::new().strangers();
    assert!(strangers.is_empty(), "tests/common/products/script.rs has no script for {strangers:?}");
}

/// Asserts that all violations are known, and that all known violations occur.
fn judge(catalogue: &Catalogue, study: &Study, known: &[Known]) {
    study.met.iter().for_each(|(place, count)| println!("{count} times: {}", known[*place].fault));
    let wrong = study.wrong.iter().map(|(product, verdict)| format!("{}: {verdict:?}", Named { catalogue, product }));
    let wrong: Vec<String> = wrong.collect();
    assert!(wrong.is_empty(), "{} violations:\n{}", wrong.len(), wrong.join("\n"));
    let gone = known.iter().enumerate().filter(|(place, _)| !study.met.contains_key(place)).map(|(_, known)| known);
    let gone: Vec<&Known> = gone.collect();
    assert!(gone.is_empty(), "known violations that are met no more: take them out of the table: {gone:?}");
}

/// Tables of refusals and of known violations.
fn tables(known: &str) -> (String, Vec<Known>) {
    let [refused, known] = [REFUSED, known].map(|path| std::fs::read_to_string(path).expect("the table is there"));
    (refused, Known::read(&known))
}

#[test]
fn random_products_keep_what_holds_for_all() {
    let (catalogue, (refused, known)) = (Catalogue::new(), tables(KNOWN));
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let study = Study::random(&catalogue, &home("random"), program(), threads, &refused, &known, 0..RANDOM);
    println!("{} sound, {} refused, {} with a known fault", study.sound, study.refused, study.known);
    judge(&catalogue, &study, &known);
    assert!(3 * study.refused < study.times.len(), "{} of {} are refused", study.refused, study.times.len());
}

#[test]
fn random_products_that_flow_keep_what_holds_for_all() {
    let (catalogue, (refused, known)) = (Catalogue::flowing(), tables(KNOWN_OF_FLOW));
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let study = Study::random(&catalogue, &home("flow"), program(), threads, &refused, &known, 0..FLOWING);
    println!("{} sound, {} refused, {} with a known fault", study.sound, study.refused, study.known);
    judge(&catalogue, &study, &known);
    assert!(3 * study.refused < study.times.len(), "{} of {} are refused", study.refused, study.times.len());
}

/// The array for the known refusals contains every pair of rows except those with a known reason. No product is run.
#[test]
fn every_pair_of_rows_is_drawn_or_refused_for_a_reason() {
    let (catalogue, (refused, _)) = (Catalogue::new(), tables(KNOWN));
    let mut cover = Cover::new(&catalogue);
    cover.learn(&refused);
    let products = cover.all();
    let drawn = cover.meant - cover.excluded.len();
    println!("{drawn} of {} pairs in {} products, the rest refused", cover.meant, products.len());
    let unexplained = cover.excluded.iter().filter(|(_, why)| !why.starts_with('C'));
    let unexplained: Vec<String> =
        unexplained.map(|((first, second), why)| format!("{}: {why}", cover.words(&[*first, *second]))).collect();
    assert!(unexplained.is_empty(), "{} pairs are left out without a reason:\n{}", unexplained.len(), unexplained.join("\n"));
    assert!(drawn as f64 >= DRAWN * cover.meant as f64, "{drawn} of {} pairs are drawn", cover.meant);
}

#[test]
fn every_pair_of_rows_that_is_allowed_together_keeps_what_holds_for_all() {
    let (catalogue, (refused, known)) = (Catalogue::new(), tables(KNOWN_OF_PAIRS));
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let (study, cover) = Study::array(&catalogue, &home("array"), program(), threads, &refused, &known);
    let drawn = cover.meant - cover.open();
    println!(
        "{drawn} of {} pairs in {} products: {} sound, {} refused, {} with a known fault",
        cover.meant,
        study.times.len(),
        study.sound,
        study.refused,
        study.known
    );
    judge(&catalogue, &study, &known);
    assert!(drawn as f64 >= DRAWN * cover.meant as f64, "{drawn} of {} pairs are drawn", cover.meant);
}

/// The oracle detects changes by hand in the history of a sliding body.
#[test]
fn the_oracle_finds_what_is_wrong_in_the_files() {
    let catalogue = Catalogue::new();
    let product = catalogue.product("partner=rigid_plane friction=number");
    let named = Named { catalogue: &catalogue, product: &product };
    let home = home("oracle");
    assert_eq!(Bench { home: home.join("bench"), program: program().into() }.judge(named), Verdict::Sound);
    let (script, out) = (home.join("main.rhai"), home.join("out"));
    std::fs::write(&script, text(named, Variant::Plain)).expect("the script can be written");
    let ended = run(&script, &out, Manner::default());
    assert_eq!(oracle::judge(named, &ended, &out), []);
    let place = out.join("history.csv");
    let history = std::fs::read_to_string(&place).expect("it was written");
    let header: Vec<&str> = history.lines().next().expect("a header").split(',').collect();
    for (column, kind) in [
        ("friction_work", "friction_gives"),
        ("energy_defect", "energy_defect"),
        ("total", "sum_of_energies"),
        ("contact_work", "ledger_formula"),
    ] {
        let index = header.iter().position(|name| *name == column).expect("the history has the column");
        let mut lines: Vec<String> = history.lines().map(String::from).collect();
        let last = lines.len() - 1;
        let mut fields: Vec<String> = lines[last].split(',').map(String::from).collect();
        fields[index] = "0.001".into();
        lines[last] = fields.join(",");
        std::fs::write(&place, lines.join("\n") + "\n").expect("it can be written");
        let faults = oracle::judge(named, &ended, &out);
        assert!(faults.iter().any(|fault| fault.kind == kind), "{column}: {faults:?}");
    }
    std::fs::write(&place, &history).expect("it can be written");
    let mut told = ended.clone();
    told.printed.iter_mut().filter(|line| line.starts_with("@shear")).for_each(|line| *line = line.replacen("0.0", "1e9", 1));
    told.printed.iter_mut().filter(|line| line.starts_with("@displacement")).for_each(|line| *line = line.replacen('1', "2", 1));
    let kinds: Vec<&str> = oracle::judge(named, &told, &out).iter().map(|fault| fault.kind).collect();
    assert!(kinds.contains(&"frame"), "{kinds:?}");
}
