//! Damaged files of every format that is read back, for some seconds: no panic (including caught ones), no hang, no exhausted memory.
//!
//! `cargo example fuzz_files -- 1800 [SEED]`. A small run makes one file of each kind; mesh files are those of the tests
//! (`examples/fuzz_meshes.rs` damages thousands of them). Checkpoints get the checksum of their damaged content, so that it is read, and
//! some are resumed. The file being read is in the folder `fuzz_files_SEED` in the folder for temporary files. A seed reproduces the files.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

#[path = "../tests/common/mesh_damage.rs"]
mod mesh_damage;

use conserva::mesh::read_mesh;
use conserva::output::checkpoint::{self, Checkpoint, FORMAT, MAGIC};
use conserva::output::{Exactness, RunFolder, RunLock};
use conserva::output::{
    compare, peak_memory_bytes, read_columns, read_fields, read_frames, read_parquet, read_rows, read_summary, read_table,
};
use conserva::script::{Checkpoints, Class, Session, Settings, Silent};
use conserva::studies::{Design, Limits, Plan, Record, RecordOutcome, Rows, Scenario, StudyFolder, StudyTable, read_study_file};
use mesh_damage::{SplitMix, damaged, originals};

/// Time limit of reading one of these small files.
const SLOW: Duration = Duration::from_secs(10);

/// Time after which a resumed run is stopped, as by Ctrl-C.
const PATIENCE: Duration = Duration::from_secs(2);

/// Every how many readable checkpoints one is resumed.
const RESUMED: usize = 8;

/// Two blocks that meet, with files of all kinds.
const SCRIPT: &str = "let law = neo_hookean(#{ youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 });\n\
    let m = model(\"press\");\n\
    let a = m.add_body(\"a\", rectangle(#{ size: [1.0, 0.5], cells: [3, 2] }), law);\n\
    let b = m.add_body(\"b\", rectangle(#{ size: [0.6, 0.4], cells: [2, 2], origin: [0.2, 0.505] }), law);\n\
    m.fix(a.boundary(\"bottom\"));\n\
    m.initial_velocity(b, #{ linear: [0.1, -1.0] });\n\
    m.add_contact(\"faces\", #{ secondary: b.boundary(\"bottom\"), primary: a.boundary(\"top\"), method: mortar() });\n\
    let sim = simulate(m, #{ integrator: energy_momentum(), dt: 0.01, fields_every: 0.02 });\n\
    sim.probe(\"tip\", b, [0.8, 0.9]);\n\
    sim.run_to(0.06);\n\
    sim.table(\"all.parquet\");\n\
    sweep(#{ vary: #{ x: [1.0, 2.0] }, run: |p| p.x });\n\
    result(\"end\", sim.time);\n";

/// Panics of this program, and of the Parquet crate, whose panics are caught and reported as damage.
static PANICS: [AtomicU64; 2] = [AtomicU64::new(0), AtomicU64::new(0)];
static PLACES: Mutex<BTreeMap<String, u64>> = Mutex::new(BTreeMap::new());

fn count_panics() {
    std::panic::set_hook(Box::new(|panic| {
        let place = panic.location().map(ToString::to_string).unwrap_or_default();
        let is_foreign = place.contains("/parquet-");
        PANICS[usize::from(is_foreign)].fetch_add(1, Ordering::Relaxed);
        if let Ok(mut places) = PLACES.lock() {
            if *places.entry(place.clone()).or_insert(0) == 0 {
                println!("a panic at {place}");
                if !is_foreign {
                    println!("{}", std::backtrace::Backtrace::force_capture());
                }
            }
            *places.entry(place).or_default() += 1;
        }
    }));
}

fn settings(folder: &Path, out: &str, until: Option<f64>) -> Settings {
    Settings { output: Some(folder.join(out)), until, checkpoints: Checkpoints::Steps(2), ..Settings::default() }
}

fn run(folder: &Path, out: &str, until: Option<f64>, from: Option<Checkpoint>) -> Option<Class> {
    let settings = settings(folder, out, until);
    let (interrupt, over) = (settings.interrupt.clone(), Arc::new(AtomicBool::new(false)));
    let is_over = over.clone();
    // A state with another step size may need many steps.
    let watch = std::thread::spawn(move || {
        let begun = Instant::now();
        while !is_over.load(Ordering::Relaxed) && begun.elapsed() < PATIENCE {
            std::thread::sleep(Duration::from_millis(5));
        }
        interrupt.store(true, Ordering::Relaxed);
    });
    let class = resumed(settings, folder, from);
    over.store(true, Ordering::Relaxed);
    let _ = watch.join();
    class
}

fn resumed(settings: Settings, folder: &Path, from: Option<Checkpoint>) -> Option<Class> {
    let mut session = Session::new(settings, folder, Rc::new(Silent)).ok()?;
    if let Some(checkpoint) = from {
        let run = folder.join("cut");
        let lock = RunLock::take(&run).ok()?;
        session.resume(&run, checkpoint, lock).ok()?;
    }
    session.run_file(&folder.join("main.rhai")).error.map(|error| error.class)
}

/// A format with its undamaged files and its reader.
struct Format {
    name: &'static str,
    file: PathBuf,
    originals: Vec<(PathBuf, Vec<u8>)>,
    read: fn(&Path, &mut SplitMix) -> bool,
}

fn formats(folder: &Path) -> Vec<Format> {
    std::fs::write(folder.join("main.rhai"), SCRIPT).unwrap_or_default();
    assert_eq!(run(folder, "whole", None, None), None, "the run that makes the files completes");
    assert_eq!(run(folder, "cut", Some(0.04), None), Some(Class::Interrupted));
    let study = folder.join("study");
    let rows = Design {
        rows: None,
        varied: vec!["a=1,2".parse().unwrap_or_else(|error| panic!("{error}"))],
        pairing: conserva::studies::Pairing::Grid,
        sampling: None,
    };
    let scenario = Scenario { script: "main.rhai".into(), folder: folder.into(), ..Scenario::default() };
    let plan = rows.points().and_then(|rows| Plan::new(scenario, Limits::default(), rows)).unwrap_or_else(|error| panic!("{error:?}"));
    let place = StudyFolder::create(&study).unwrap_or_else(|error| panic!("{error:?}"));
    place.write_plan(&plan).unwrap_or_else(|error| panic!("{error:?}"));
    let record = Record::of(&plan.points[0].id, RecordOutcome::Completed, "");
    place.write_record(&record).unwrap_or_else(|error| panic!("{error:?}"));
    std::fs::write(folder.join("a.toml"), "script = \"main.rhai\"\nsample = \"sobol:4\"\n[vary]\nh = \"0.1..0.4\"\nk = [1e4, 'x']\n")
        .unwrap_or_default();
    let of = |name: &'static str, from: &[PathBuf], read: fn(&Path, &mut SplitMix) -> bool| {
        let originals: Vec<_> = from
            .iter()
            .map(|path| (path.clone(), std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))))
            .collect();
        Format { name, file: from[0].clone(), originals, read }
    };
    let whole = |name: &str| folder.join("whole").join(name);
    let point = study.join("points").join(&plan.points[0].id).join("point.json");
    let checkpoint = checkpoint::places(&folder.join("cut")).pop().unwrap_or_default();
    let mut meshes = of("mesh", &[whole("history.csv")], |path, _| read_mesh(path).is_ok());
    (meshes.file, meshes.originals) = (folder.join("a.msh"), originals());
    vec![
        of("history.csv", &[whole("history.csv"), whole("studies/sweep.csv")], |path, _| {
            let _ = (read_columns(path).is_ok(), read_rows(path).is_ok(), Rows::read(path).is_ok());
            read_table(path).is_ok()
        }),
        of("summary.json", &[whole("summary.json")], |path, _| {
            let run = path.parent().unwrap_or(path);
            let same = compare(run, &run.with_file_name("cut"), &Exactness { tolerance: 0.0, ignored: Vec::new() });
            let folder = RunFolder::open(run).map(|run| (run.outcome(), run.parameters(), run.further())).is_ok();
            read_summary(path).is_ok() && folder && same.is_ok()
        }),
        of("list of frames", &[whole("fields.pvd"), whole("contacts.pvd")], |path, _| read_frames(path).is_ok()),
        of("frame", &[whole("fields/fields_000000.vtu"), whole("contacts/contacts_000001.vtu")], |path, _| read_fields(path).is_ok()),
        of("Parquet", &[whole("all.parquet")], |path, _| read_parquet(path).is_ok()),
        of("checkpoint", &[checkpoint], read_checkpoint),
        of("study.json", &[study.join("study.json")], |path, _| {
            let study = StudyFolder::open(path.parent().unwrap_or(path));
            study.and_then(|study| study.plan().map(|plan| StudyTable::of(&study, &plan).0.to_csv())).is_ok()
        }),
        of("point.json", &[point], |path, _| {
            let id = path.parent().and_then(Path::file_name).map(|id| id.to_string_lossy().into_owned()).unwrap_or_default();
            let study = path.ancestors().nth(3).map(StudyFolder::open);
            let table = study.map(|study| study.and_then(|study| study.plan().map(|plan| StudyTable::of(&study, &plan).0.to_csv())));
            Record::read(path, &id).is_some() && table.is_some()
        }),
        of("study file", &[folder.join("a.toml")], |path, _| {
            read_study_file(path).and_then(|file| Ok((file.varied()?, file.fixed()?))).is_ok()
        }),
        meshes,
    ]
}

/// Reads a checkpoint with damaged content and a matching header; resumes some.
fn read_checkpoint(path: &Path, random: &mut SplitMix) -> bool {
    let mut bytes = std::fs::read(path).unwrap_or_default();
    let header = MAGIC.len() + 16;
    if bytes.len() > header && random.below(4) > 0 {
        let (length, checksum) = ((bytes.len() - header) as u64, crc32fast_of(&bytes[header..]));
        bytes[..MAGIC.len()].copy_from_slice(MAGIC);
        bytes[MAGIC.len()..header].copy_from_slice(&[&FORMAT.to_le_bytes()[..], &length.to_le_bytes(), &checksum.to_le_bytes()].concat());
    }
    let Ok(checkpoint) = Checkpoint::from_bytes(&bytes) else { return false };
    if random.below(RESUMED) == 0 {
        let folder = path.ancestors().nth(3).unwrap_or(path);
        run(folder, "resumed", None, Some(checkpoint));
    }
    true
}

/// Checksum of the content of a checkpoint.
fn crc32fast_of(content: &[u8]) -> u32 {
    checkpoint::Origin::digest(content).1
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let seconds: u64 = arguments.next().map_or(Ok(10), |text| text.parse())?;
    let seed: u64 = arguments.next().map_or(Ok(1), |text| text.parse())?;
    let folder = std::env::temp_dir().join(format!("fuzz_files_{seed}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder)?;
    let formats = formats(&folder);
    count_panics();
    let (mut random, begin) = (SplitMix(seed), Instant::now());
    // Number of damaged files of each format, number of those that were readable, and the longest time.
    let mut counts = vec![(0u64, 0u64, Duration::ZERO); formats.len()];
    while begin.elapsed() < Duration::from_secs(seconds) {
        let index = random.below(formats.len());
        let format = &formats[index];
        let content = damaged(&format.originals, &mut random);
        std::fs::write(&format.file, &content)?;
        let before = PANICS[0].load(Ordering::Relaxed);
        let start = Instant::now();
        let read = catch_unwind(AssertUnwindSafe(|| (format.read)(&format.file, &mut random)));
        let took = start.elapsed();
        if PANICS[0].load(Ordering::Relaxed) > before && PANICS[0].load(Ordering::Relaxed) < 20 {
            let kept = folder.join(format!("panic_{}_{}", before, format.name.replace(' ', "_")));
            std::fs::write(&kept, &content)?;
            println!("a panic in {}: {}", format.name, kept.display());
        }
        let (files, good, slowest) = &mut counts[index];
        *files += 1;
        *good += u64::from(read.unwrap_or(false));
        *slowest = took.max(*slowest);
        if took > SLOW {
            return Err(format!("{} took {took:?}", format.file.display()).into());
        }
        // Other readers read this file, too.
        std::fs::write(&format.file, &format.originals[0].1)?;
    }
    for (format, (files, good, slowest)) in formats.iter().zip(&counts) {
        println!("{:<15} {files:>8} damaged, {good:>8} read all the same, slowest {slowest:?}", format.name);
    }
    let files: u64 = counts.iter().map(|count| count.0).sum();
    let memory = peak_memory_bytes().map_or(String::new(), |bytes| format!(", peak memory {} kB", bytes / 1024));
    let [own, foreign] = [0, 1].map(|index| PANICS[index].load(Ordering::Relaxed));
    println!("{files} files in {seconds} s{memory}; panics: {own}, and {foreign} of the Parquet crate that were told as damage");
    for (place, count) in PLACES.lock().unwrap_or_else(|error| error.into_inner()).iter() {
        println!("  {count:>6} {place}");
    }
    if own > 0 { Err("there were panics".into()) } else { Ok(()) }
}
