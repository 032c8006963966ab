//! The verification manual: its scripts, the rows that they compute, and the page that shows them. Used by the test that runs the scripts
//! and by the example that writes `docs/verification.md`.

// Each program uses a part of this file.
#![allow(dead_code)]

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use conserva::script::{Ink, Session, Settings, Silent, home};

/// Names of the scripts beside this file, and the smallest number of rows of each.
pub const SCRIPTS: &[(&str, usize)] = &[
    ("01_bars_and_patches", 46),
    ("02_bending_and_membranes", 42),
    ("03_cylinders_and_spheres", 47),
    ("04_laws", 70),
    ("05_viscosity", 18),
    ("06_contact_at_rest", 48),
    ("07_hertz_and_punch", 36),
    ("08_rigid_motion", 28),
    ("09_conservation", 25),
    ("10_waves_and_impacts", 33),
    ("11_vibrations", 49),
    ("12_integrators", 26),
    ("13_friction", 7),
    ("14_solids_in_space", 30),
    ("15_paths_and_stability", 17),
    ("16_plasticity", 22),
];

/// A computed value with its reference value.
#[derive(Clone, Debug)]
pub struct Row {
    pub topic: String,
    pub what: String,
    pub source: String,
    pub expected: f64,
    pub got: f64,
    pub difference: f64,
    pub tolerance: f64,
    pub kind: String,
}

impl Row {
    /// True if the value is within its tolerance; false for NaN.
    pub fn holds(&self) -> bool {
        self.difference <= self.tolerance
    }

    /// Cells of the row in the page that do not depend on computed values.
    pub fn head(&self) -> String {
        format!("| {} | {} | {}", cell(&self.what), cell(&self.source), number(self.expected))
    }
}

fn scripts() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/verification")
}

/// Runs a script with results and picture in a folder; returns its rows.
pub fn run(name: &str, output: &Path) -> Result<Vec<Row>, String> {
    let script = scripts().join(name).with_extension("rhai");
    let settings = Settings { output: Some(output.to_path_buf()), ..Settings::default() };
    let mut session = Session::new(settings, home(&script), Rc::new(Silent)).map_err(|error| error.render(Ink::Plain))?;
    if let Some(error) = session.run_file(&script).error {
        return Err(error.render(Ink::Plain));
    }
    let mut reader = csv::Reader::from_path(output.join("verification.csv")).map_err(|error| error.to_string())?;
    let row = |record: csv::StringRecord| -> Option<Row> {
        let text = |k: usize| record.get(k).map(String::from);
        let value = |k: usize| record.get(k)?.parse().ok();
        let (topic, what, source, kind) = (text(0)?, text(1)?, text(2)?, text(7)?);
        Some(Row { topic, what, source, expected: value(3)?, got: value(4)?, difference: value(5)?, tolerance: value(6)?, kind })
    };
    let rows = reader.records().map(|record| record.ok().and_then(row)).collect::<Option<Vec<Row>>>();
    rows.ok_or_else(|| format!("{name}: a row of verification.csv cannot be read"))
}

/// The page: introduction, picture and rows of each script.
pub fn page(all: &[(&str, Vec<Row>)]) -> String {
    let count: usize = all.iter().map(|(_, rows)| rows.len()).sum();
    let held = all.iter().flat_map(|(_, rows)| rows).filter(|row| row.holds()).count();
    let mut page = format!(
        "# Verification manual\n\n{count} values that are known from closed forms and publications, and what Conserva computes: {held} are \
         within their tolerances. Differences are relative to what is expected, unless they are called absolute. The scripts are in \
         [`tests/verification`](../tests/verification); the tests run them and compare every row.\n\n\
         `cargo example verification` runs them and writes this page. Last digits depend on the processor.\n\n\
         | chapter | rows | largest share of a tolerance |\n|---|---|---|\n"
    );
    for (name, rows) in all {
        let share = rows.iter().map(|row| row.difference / row.tolerance).fold(0.0, f64::max);
        let _ = writeln!(page, "| [{}](#{}) | {} | {share:.2} |", title(name), title(name).to_lowercase().replace(' ', "-"), rows.len());
    }
    for (name, rows) in all {
        let _ = writeln!(page, "\n## {}\n\n{}\n\n![{name}](images/verification/{name}.svg)", title(name), about(name));
        let mut topics: Vec<&str> = rows.iter().map(|row| row.topic.as_str()).collect();
        topics.dedup();
        let mut told = Vec::new();
        for topic in topics {
            if told.contains(&topic) {
                continue;
            }
            told.push(topic);
            let _ =
                write!(page, "\n### {topic}\n\n| what | source | expected | got | difference | tolerance |\n|---|---|---|---|---|---|\n");
            for row in rows.iter().filter(|row| row.topic == topic) {
                let absolute = if row.kind == "absolute" { ", absolute" } else { "" };
                let (got, difference, tolerance) = (number(row.got), short(row.difference), short(row.tolerance));
                let mark = if row.holds() { "" } else { " **outside**" };
                let _ = writeln!(page, "{} | {got} | {difference}{mark} | {tolerance}{absolute} |", row.head());
            }
        }
    }
    page
}

/// `01_bars_and_patches` as a title.
fn title(name: &str) -> String {
    let words = name.split_once('_').map_or(name, |(_, words)| words).replace('_', " ");
    words[..1].to_uppercase() + &words[1..]
}

/// Initial comment of a script.
fn about(name: &str) -> String {
    let text = std::fs::read_to_string(scripts().join(name).with_extension("rhai")).unwrap_or_default();
    text.lines().map_while(|line| line.strip_prefix("//")).map(str::trim).collect::<Vec<_>>().join(" ")
}

fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('*', "\\*").replace('<', "&lt;")
}

/// Number with seven digits.
fn number(value: f64) -> String {
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) {
        let digits = if value == 0.0 { 0 } else { (6 - value.abs().log10().floor() as i32).max(0) as usize };
        let text = format!("{value:.digits$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
    } else {
        let text = format!("{value:.6e}");
        let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        let mantissa = if mantissa.contains('.') { mantissa.trim_end_matches('0').trim_end_matches('.') } else { mantissa };
        format!("{mantissa}e{exponent}")
    }
}

/// Number with two digits.
fn short(value: f64) -> String {
    if value == 0.0 { "0".into() } else { format!("{value:.1e}").replace(".0e", "e") }
}
