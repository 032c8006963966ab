//! `conserva info`: describes a file or a folder in a few lines.
//!
//! [`KINDS`] lists the known kinds, each with a test by name or first bytes and a description; a further kind of files is a row.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use clap::Args;
use serde_json::{Map, Value, json};

use super::columns::{aligned, short, visible};
use super::console::{Console, complain, ink};
use super::diff::Format;
use super::drawn_files;
use super::mesh_files;
use super::process::exit_code;
use crate::machine::files;
use crate::mesh::MESH_ENDINGS;
use crate::output::checkpoint::{Checkpoint, MAGIC};
use crate::output::{
    FieldsRead, ReadError, RunFolder, Section, Table, read_fields, read_frames, read_parquet, read_rows, read_summary, read_table,
    runs_below,
};
use crate::script::{Class, Diagnostic, Mode, Session, Settings, Silent, home};
use crate::studies::StudyFolder;

/// Arguments of `conserva info`.
#[derive(Args)]
pub struct Arguments {
    /// Folder of a run, one of its files, a mesh file or a script
    path: PathBuf,
    /// Output format
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Draw a mesh file with its boundaries in colors and their names into a PNG or SVG file
    #[arg(long, value_name = "FILE")]
    picture: Option<Option<PathBuf>>,
}

/// Properties of a file with their values, in the order of output.
type Facts = Vec<(&'static str, Value)>;

/// A kind of files.
struct Kind {
    name: &'static str,
    /// True if a file is of this kind, given its extension (in lower case) and its first bytes.
    fits: fn(&str, &[u8]) -> bool,
    describe: fn(&Path) -> Result<Facts, Box<Diagnostic>>,
}

/// Known kinds of files; the first match is used.
const KINDS: &[Kind] = &[
    Kind { name: "rows of a study", fits: |ending, head| ending == "csv" && is_study(head), describe: study_file },
    Kind { name: "table", fits: |ending, _| ending == "csv", describe: csv_file },
    Kind { name: "table (Parquet)", fits: |ending, head| ending == "parquet" || head.starts_with(b"PAR1"), describe: parquet_file },
    Kind { name: "summary of a run", fits: |ending, _| ending == "json", describe: summary_file },
    Kind { name: "series of fields (PVD)", fits: |ending, _| ending == "pvd", describe: series_file },
    Kind { name: "fields (VTU)", fits: |ending, head| ending == "vtu" && is_frame(head), describe: fields_file },
    Kind { name: "checkpoint", fits: |ending, head| ending == "checkpoint" || head.starts_with(MAGIC), describe: checkpoint_file },
    Kind { name: "log of a run", fits: |_, head| head.starts_with(b"{\"event\":"), describe: log_file },
    Kind { name: "report of a run", fits: |ending, _| ending == "html", describe: report_file },
    Kind {
        name: "picture",
        fits: |ending, head| ending == "svg" || head.starts_with(drawn_files::PNG) || head.starts_with(drawn_files::GIF),
        describe: picture_file,
    },
    Kind { name: "script", fits: |ending, _| ending == "rhai", describe: script_file },
    Kind {
        name: "mesh",
        fits: |ending, head| MESH_ENDINGS.contains(&ending) || head.starts_with(b"$MeshFormat") || head.starts_with(b"*"),
        describe: mesh_files::mesh,
    },
];

/// True for the first bytes of a frame of a run, with the name of its first part in a comment.
fn is_frame(head: &[u8]) -> bool {
    ["body", "obstacle", "contact"].iter().any(|kind| {
        let comment = format!("<!-- {kind} 0: ");
        head.windows(comment.len()).any(|window| window == comment.as_bytes())
    })
}

/// Number of bytes at the start of a file by which its kind is determined.
const HEAD: usize = 4096;

/// Describes a file or a folder; returns the exit code.
pub fn info(arguments: Arguments) -> u8 {
    let Arguments { path, format, picture } = arguments;
    let found = facts_of(&path).and_then(|(kind, mut facts)| {
        if let Some(picture) = picture {
            facts.push(("picture", mesh_files::draw(&path, kind, picture)?.display().to_string().into()));
        }
        Ok((kind, facts))
    });
    let (kind, facts) = match found {
        Ok(found) => found,
        Err(error) => {
            complain(&error.render(ink()));
            return exit_code(error.class);
        }
    };
    let console = Console::new(true);
    match format {
        Format::Json => {
            let mut all: Map<String, Value> = facts.into_iter().map(|(key, value)| (key.replace(' ', "_"), value)).collect();
            all.insert("kind".into(), kind.into());
            all.insert("path".into(), path.display().to_string().into());
            console.say(&serde_json::to_string_pretty(&all).unwrap_or_default());
        }
        Format::Text => {
            console.say(&visible(&format!("{}: {kind}", path.display())));
            facts.iter().for_each(|(key, value)| say(&console, key, value));
        }
    }
    0
}

fn facts_of(path: &Path) -> Result<(&'static str, Facts), Box<Diagnostic>> {
    let kind = std::fs::metadata(path).map_err(|error| refused(&ReadError::io(path, &error)))?;
    if kind.is_dir() {
        return if StudyFolder::is_study(path) { Ok(("study", study_folder(path)?)) } else { Ok(("run", run_folder(path)?)) };
    }
    // A table of a study is described by the study's plan; its rows contain words, too.
    if let Some(study) = path.parent().map(|folder| if folder.as_os_str().is_empty() { Path::new(".") } else { folder })
        && StudyFolder::is_study(study)
    {
        return Ok(("file of a study", study_folder(study)?));
    }
    if !kind.is_file() {
        return Err(refused(&ReadError::new(path, "is neither a file nor a folder", "name a file or the folder of a run")));
    }
    let mut head = Vec::new();
    let opened = files::open(path).and_then(|(file, _)| std::io::Read::read_to_end(&mut std::io::Read::take(file, HEAD as u64), &mut head));
    opened.map_err(|error| refused(&ReadError::io(path, &error)))?;
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
    let Some(kind) = KINDS.iter().find(|kind| (kind.fits)(&ending, &head)) else {
        let names: Vec<&str> = KINDS.iter().map(|kind| kind.name).collect();
        let error = Diagnostic::error(Class::Script, format!("\"{}\" is of no kind that is known here", path.display()));
        return Err(Box::new(error.hint(format!("known are the folder of a run, and: {}", names.join(", ")))));
    };
    Ok((kind.name, (kind.describe)(path)?))
}

/// Describes a study: script, parameters, number of points and their outcomes.
fn study_folder(path: &Path) -> Result<Facts, Box<Diagnostic>> {
    let study = StudyFolder::open(path)?;
    let plan = study.plan()?;
    let mut outcomes: BTreeMap<&str, usize> = BTreeMap::new();
    for point in &plan.points {
        *outcomes.entry(study.state(point).word()).or_default() += 1;
    }
    let fixed: Map<String, Value> = plan.scenario.fixed.iter().map(|(name, value)| (name.clone(), value.clone().into())).collect();
    let outcomes: Map<String, Value> = outcomes.into_iter().map(|(word, count)| (word.into(), count.into())).collect();
    Ok(vec![
        ("script", plan.scenario.script.display().to_string().into()),
        ("varied", plan.names.into()),
        ("fixed", fixed.into()),
        ("points", plan.points.len().into()),
        ("outcomes", outcomes.into()),
    ])
}

/// Writes a property: a list below its name, other values beside it.
fn say(console: &Console, key: &str, value: &Value) {
    let word = |value: &Value| match value {
        Value::Null => "-".to_string(),
        Value::String(text) => text.clone(),
        Value::Number(number) if number.is_f64() => short(number.as_f64().unwrap_or(f64::NAN)),
        value => value.to_string(),
    };
    let say = |line: &str| console.say(&visible(line));
    match value {
        Value::Array(all) if all.iter().any(Value::is_array) => {
            console.say(&format!("  {key}:"));
            let rows: Vec<Vec<String>> = all.iter().filter_map(Value::as_array).map(|row| row.iter().map(word).collect()).collect();
            aligned(&rows).iter().for_each(|line| console.say(&format!("    {line}")));
        }
        Value::Array(all) => say(&format!("  {key}: {}", all.iter().map(word).collect::<Vec<_>>().join(", "))),
        Value::Object(all) => {
            let pairs: Vec<String> = all.iter().map(|(name, value)| format!("{name}={}", word(value))).collect();
            say(&format!("  {key}: {}", pairs.join(" ")));
        }
        value => say(&format!("  {key}: {}", word(value))),
    }
}

fn refused(error: &ReadError) -> Box<Diagnostic> {
    let message = Diagnostic::error(Class::Script, error.to_string()).code(error.code());
    Box::new(error.cause.iter().fold(message, Diagnostic::cause).hint(&error.hint))
}

fn run_folder(path: &Path) -> Result<Facts, Box<Diagnostic>> {
    let run = RunFolder::open(path).map_err(|error| refused(&error))?;
    let mut facts = summary_facts(run.summary.as_ref());
    if run.summary.is_none() {
        facts.push(("outcome", run.outcome().into()));
    }
    if let Some(history) = run.file("history.csv") {
        let read = read_table(&history).map_err(|error| refused(&error))?;
        let last = read.table.column("time").and_then(|time| time.values.last().copied().flatten());
        facts.extend([
            ("rows of history.csv", read.table.rows().into()),
            ("columns", read.table.columns.len().into()),
            ("end time", last.into()),
        ]);
        if read.is_cut {
            facts.push(("note", "the last line of history.csv is cut: the run was killed while it wrote it".into()));
        }
    }
    for (name, key) in
        [("fields.pvd", "frames of the fields"), ("contacts.pvd", "frames of contact surfaces"), ("obstacles.pvd", "frames of obstacles")]
    {
        if let Some(list) = run.file(name) {
            facts.push((key, read_frames(&list).map_err(|error| refused(&error))?.len().into()));
        }
    }
    let further = run.further();
    if !further.is_empty() {
        facts.push(("further simulations", further.into()));
    }
    Ok(facts)
}

/// Describes a summary by the entries for users.
fn summary_facts(summary: Option<&Value>) -> Facts {
    const SHOWN: [&str; 20] = [
        "script",
        "parameters",
        "parameter_units",
        "results",
        "result_units",
        "units",
        "version",
        "outcome",
        "bodies",
        "unknowns",
        "steps",
        "newton_iterations",
        "halvings",
        "halvings_by_cause",
        "energy_drift",
        "momentum_drift",
        "angular_momentum_drift",
        "worst_energy_defect",
        "peak_memory_bytes",
        "findings",
    ];
    let Some(summary) = summary else { return Facts::new() };
    let mut facts = Facts::new();
    for key in SHOWN {
        let value = match (key, summary.get(key)) {
            ("findings", Some(Value::Array(all))) => all.iter().filter_map(|finding| finding.get("message")).cloned().collect(),
            (_, Some(value)) => value.clone(),
            (_, None) => continue,
        };
        let is_empty = value.as_array().is_some_and(Vec::is_empty) || value.as_object().is_some_and(Map::is_empty);
        if !is_empty {
            facts.push((key, value));
        }
    }
    if let Some(total) = summary.get("wall_seconds").and_then(|wall| wall.get("total")) {
        facts.push(("wall_seconds", total.clone()));
    }
    facts
}

fn summary_file(path: &Path) -> Result<Facts, Box<Diagnostic>> {
    let summary = read_summary(path).map_err(|error| refused(&error))?;
    if summary.get("outcome").is_none() {
        let error = ReadError::new(path, "is no summary of a run: it has no `outcome`", "name the summary.json of a run");
        return Err(refused(&error));
    }
    Ok(summary_facts(Some(&summary)))
}

fn csv_file(path: &Path) -> Result<Facts, Box<Diagnostic>> {
    let read = read_table(path).map_err(|error| refused(&error))?;
    let mut facts = table_facts(&read.table);
    if read.is_cut {
        facts.push(("note", "the last line is cut and was left out".into()));
    }
    Ok(facts)
}

/// True if the first line of a table ends with the column `failure`.
fn is_study(head: &[u8]) -> bool {
    head.split(|&byte| byte == b'\n').next().is_some_and(|line| line.ends_with(b",failure"))
}

fn study_file(path: &Path) -> Result<Facts, Box<Diagnostic>> {
    let (table, failures) = read_rows(path).map_err(|error| refused(&error))?;
    let failed = failures.iter().filter(|failure| !failure.is_empty()).count();
    let mut facts = table_facts(&table);
    facts.push(("failed", failed.into()));
    facts.extend(failures.into_iter().find(|failure| !failure.is_empty()).map(|first| ("first failure", first.into())));
    Ok(facts)
}

fn parquet_file(path: &Path) -> Result<Facts, Box<Diagnostic>> {
    Ok(table_facts(&read_parquet(path).map_err(|error| refused(&error))?))
}

/// Describes a table: number of rows, and for each column the number of values, minimum, maximum and last value.
fn table_facts(table: &Table) -> Facts {
    let mut rows = vec![json!(["column", "values", "smallest", "largest", "last"])];
    for column in &table.columns {
        let known = || column.values.iter().flatten().copied().filter(|value| !value.is_nan());
        let (least, most) = (known().reduce(f64::min), known().reduce(f64::max));
        rows.push(json!([column.name, known().count(), least, most, column.values.last().copied().flatten()]));
    }
    vec![("rows", table.rows().into()), ("columns", rows.into())]
}

fn series_file(path: &Path) -> Result<Facts, Box<Diagnostic>> {
    let frames = read_frames(path).map_err(|error| refused(&error))?;
    let missing: Vec<String> = frames.iter().filter(|frame| !frame.path.is_file()).map(|frame| frame.name.clone()).collect();
    let mut facts: Facts = vec![("frames", frames.len().into())];
    if let (Some(first), Some(last)) = (frames.first(), frames.last()) {
        facts.extend([("first time", first.time.into()), ("last time", last.time.into())]);
        if missing.is_empty() {
            facts.extend(frame_facts(&read_fields(&last.path).map_err(|error| refused(&error))?, "in the last frame"));
        } else {
            facts.push(("missing files", missing.into()));
        }
    }
    Ok(facts)
}

fn fields_file(path: &Path) -> Result<Facts, Box<Diagnostic>> {
    let frame = read_fields(path).map_err(|error| refused(&error))?;
    let mut facts: Facts = frame.time.map(|time| ("time", time.into())).into_iter().collect();
    facts.extend(frame_facts(&frame, "arrays"));
    Ok(facts)
}

fn frame_facts(frame: &FieldsRead, title: &'static str) -> Facts {
    let mut rows = vec![json!(["field", "of", "components", "smallest", "largest"])];
    for array in frame.arrays.iter().filter(|array| matches!(array.section, Section::PointData | Section::CellData)) {
        let known = || (0..array.numbers.len()).map(|index| array.numbers.at(index)).filter(|value| !value.is_nan());
        let of = if array.section == Section::PointData { "points" } else { "cells" };
        rows.push(json!([array.name, of, array.components, known().reduce(f64::min), known().reduce(f64::max)]));
    }
    let parts = match frame.kind.as_str() {
        "obstacle" => "obstacles",
        "contact" => "contacts",
        _ => "bodies",
    };
    vec![("points", frame.points.into()), ("cells", frame.cells.into()), (parts, frame.parts.clone().into()), (title, rows.into())]
}

/// Describes a log: number of events by kind, script, and outcome of the run.
fn log_file(path: &Path) -> Result<Facts, Box<Diagnostic>> {
    let text = files::read_text(path).map_err(|error| refused(&ReadError::io(path, &error)))?;
    let (mut counts, mut script, mut outcome) =
        (BTreeMap::<String, usize>::new(), Value::Null, Value::from("no end: killed, or still running"));
    for (number, line) in text.lines().enumerate() {
        let event = serde_json::from_str::<Value>(line).ok().filter(|event| event["event"].is_string());
        let Some(event) = event else {
            // A killed process may leave an incomplete line.
            if number + 1 == text.lines().count() && !text.ends_with('\n') {
                break;
            }
            return Err(refused(&ReadError::damaged(path, format!("line {} is no event", number + 1))));
        };
        match event["event"].as_str() {
            Some("start") => script = event["script"].clone(),
            Some("end") => outcome = event["outcome"].clone(),
            _ => {}
        }
        *counts.entry(event["event"].as_str().unwrap_or_default().into()).or_default() += 1;
    }
    let counts: Map<String, Value> = counts.into_iter().map(|(event, count)| (event, count.into())).collect();
    Ok(vec![("script", script), ("outcome", outcome), ("events", counts.into())])
}

fn picture_file(path: &Path) -> Result<Facts, Box<Diagnostic>> {
    let bytes = files::read(path).map_err(|error| refused(&ReadError::io(path, &error)))?;
    drawn_files::picture(&bytes).ok_or_else(|| refused(&ReadError::damaged(path, "it is no whole picture")))
}

fn report_file(path: &Path) -> Result<Facts, Box<Diagnostic>> {
    let bytes = files::read(path).map_err(|error| refused(&ReadError::io(path, &error)))?;
    drawn_files::report(&String::from_utf8_lossy(&bytes)).ok_or_else(|| refused(&ReadError::damaged(path, "it is no report of a run")))
}

fn checkpoint_file(path: &Path) -> Result<Facts, Box<Diagnostic>> {
    let Checkpoint { origin, simulations, journal, files } = Checkpoint::read(path).map_err(|error| {
        let message = Diagnostic::error(Class::Script, format!("the checkpoint \"{}\" is no good", path.display())).code(error.code());
        Box::new(message.cause(error.to_string()).hint("resume from the one before it, or run the script anew"))
    })?;
    let mut facts: Facts = vec![
        ("script", origin.script.into()),
        ("begun in", origin.folder.display().to_string().into()),
        ("version", origin.program.into()),
        ("instructions", origin.instructions.into()),
        ("computations", journal.events.into()),
        ("files", files.len().into()),
    ];
    for saved in simulations {
        let (step, time) = saved.reached;
        facts.push(("simulation", format!("\"{}\": step {step}, t = {time}, {} unknowns", saved.name, saved.unknowns).into()));
    }
    Ok(facts)
}

fn script_file(path: &Path) -> Result<Facts, Box<Diagnostic>> {
    let text = files::read_text(path).map_err(|error| refused(&ReadError::io(path, &error)))?;
    let settings = Settings { mode: Mode::Check, ..Settings::default() };
    let session = Session::new(settings, home(path), Rc::new(Silent))?;
    let outline = session.outline(&path.display().to_string(), &text)?;
    let about: Vec<&str> = text.lines().map_while(|line| line.trim().strip_prefix("//")).map(str::trim).collect();
    let mut facts: Facts = vec![("lines", text.lines().count().into())];
    if !about.is_empty() {
        facts.push(("about", about.join(" ").into()));
    }
    let (tests, functions): (Vec<_>, Vec<_>) =
        outline.functions.iter().map(|(name, ..)| name.clone()).partition(|name| name.starts_with("test_"));
    for (key, names) in [("functions", functions), ("tests", tests)] {
        if !names.is_empty() {
            facts.push((key, names.into()));
        }
    }
    let run = Path::new("out").join(path.file_stem().unwrap_or_default());
    if !runs_below(&run).is_empty() {
        facts.push(("last run", run.display().to_string().into()));
    }
    Ok(facts)
}
