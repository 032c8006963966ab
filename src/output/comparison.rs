//! Comparison of two runs: parameters, outcome, columns of the history, fields of all frames.
//!
//! Rows and frames with equal times are compared, so that runs with different time steps are compared at common times. A number differs if
//! its deviation exceeds the tolerance times a scale, the largest value of its kind in both runs. Quantities of one kind are all energies,
//! the components of one force, of one momentum, and so on: a component that should be zero consists of round-off. Wall-clock times and
//! memory are not compared.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde::Serialize;
use serde_json::Value;

use super::reading::error::ReadError;
use super::reading::fields::{ArrayRead, FieldsRead, Section, read_fields};
use super::reading::folder::RunFolder;
use super::reading::frames::read_frames;
use super::reading::table::read_table;
use super::summary::{COMPLETED, NOT_CONSERVING};
use super::table::{Column, Table};
use super::units::{ListedUnits, Scale, Unit, read_units};
use crate::math::tolerances::SAME_MOMENT;

/// Tolerance of a comparison, and the columns and fields that are left out.
#[derive(Clone, Debug, Default)]
pub struct Exactness {
    /// Largest difference relative to the scale that counts as equal.
    pub tolerance: f64,
    /// Names of columns and fields that are left out; `*` matches any text.
    pub ignored: Vec<String>,
}

impl Exactness {
    fn ignores(&self, name: &str) -> bool {
        self.ignored.iter().any(|pattern| matches(pattern, name))
    }
}

/// True if `name` matches `pattern`, in which `*` matches any text.
fn matches(pattern: &str, name: &str) -> bool {
    match pattern.split_once('*') {
        None => pattern == name,
        Some((start, rest)) => name
            .strip_prefix(start)
            .is_some_and(|left| (0..=left.len()).any(|skip| left.is_char_boundary(skip) && matches(rest, &left[skip..]))),
    }
}

/// Difference between entries of the summaries.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EntryDifference {
    /// Name of the entry; `parameter dt` for a parameter.
    pub name: String,
    /// Value of the first run; null without a value.
    pub first: Value,
    /// Value of the second run; null without a value.
    pub second: Value,
    /// True if the difference makes the runs different; another path of the script or another program version does not.
    pub counts: bool,
}

/// Difference between columns of the histories.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ColumnDifference {
    /// Name of the column.
    pub column: String,
    /// Step of the first run at which the columns first differ.
    pub from_step: usize,
    /// Time of the first row with a difference.
    pub from_time: f64,
    /// Number of rows in which the columns differ.
    pub rows: usize,
    /// Largest difference; null if only one of the runs has a number.
    pub largest: Option<f64>,
    /// Largest difference relative to the scale of the column.
    pub relative: Option<f64>,
    /// Step of the first run at which the difference is largest.
    pub at_step: usize,
    /// Value of the first run at the step with the largest difference.
    pub first: Option<f64>,
    /// Value of the second run at the step with the largest difference.
    pub second: Option<f64>,
}

/// Difference between fields. Places and sizes refer to the frame with the largest difference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FieldDifference {
    /// Series of the frames.
    pub series: &'static str,
    /// Name of the field.
    pub field: String,
    /// Number of frames in which the field differs.
    pub frames: usize,
    /// Time of the first frame in which the field differs.
    pub from_time: f64,
    /// Time of the frame with the largest difference.
    pub at_time: f64,
    /// Number of points (or cells) at which the field differs.
    pub places: usize,
    /// Largest difference of a component; null if only one of the runs has a number.
    pub largest: Option<f64>,
    /// Largest difference relative to the largest component in both runs.
    pub relative: Option<f64>,
    /// Point (or cell) of the largest difference, counted from 0 over all bodies.
    pub at: usize,
}

/// Result of a comparison of two runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Comparison {
    /// Name of the simulation's folder below the folder of the run; empty for the first simulation.
    pub simulation: String,
    /// Common outcome of both runs if neither was completed: later steps of the script were not compared.
    pub unfinished: Option<String>,
    /// Entries of the summaries that differ.
    pub entries: Vec<EntryDifference>,
    /// Number of rows of the first history, of the second, and of rows with common times.
    pub rows: [usize; 3],
    /// Number of columns that both histories have.
    pub columns_compared: usize,
    /// Columns that differ.
    pub columns: Vec<ColumnDifference>,
    /// Columns, fields, files and simulations that only one run has, and frames that do not match, one sentence each.
    pub missing: Vec<String>,
    /// Number of frames that both runs have.
    pub frames_compared: usize,
    /// Number of fields that frames of both runs have.
    pub fields_compared: usize,
    /// Fields that differ.
    pub fields: Vec<FieldDifference>,
    /// Units of the differences: those of the first run; `None` where it declares none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units: Option<ListedUnits>,
}

impl Comparison {
    /// True if no difference counts: entries, columns, fields and numbers of rows agree, and nothing is missing.
    pub fn is_same(&self) -> bool {
        let entries = self.entries.iter().all(|entry| !entry.counts);
        entries && self.columns.is_empty() && self.missing.is_empty() && self.fields.is_empty() && self.rows[0] == self.rows[1]
    }
}

impl Comparison {
    /// Adds a sentence on data that only one run has, unless it was added before.
    fn miss(&mut self, sentence: String) {
        if !self.missing.contains(&sentence) {
            self.missing.push(sentence);
        }
    }

    /// Adds the difference of a field in a further frame.
    fn differ(&mut self, new: FieldDifference) {
        let Some(known) = self.fields.iter_mut().find(|known| (known.series, &known.field) == (new.series, &new.field)) else {
            return self.fields.push(new);
        };
        known.frames += 1;
        let size = |difference: &FieldDifference| difference.largest.unwrap_or(f64::INFINITY);
        if size(&new) > size(known) {
            *known = FieldDifference { frames: known.frames, from_time: known.from_time, ..new };
        }
    }
}

/// Entries of a summary that are compared; the others follow from the history, or are wall-clock times and memory.
const ENTRIES: [(&str, bool); 8] = [
    ("script", false),
    ("version", false),
    ("bodies", true),
    ("unknowns", true),
    ("steps", true),
    ("halvings", true),
    ("newton_iterations", true),
    ("outcome", true),
];

/// Lists of frames that a simulation may write.
const SERIES: [&str; 3] = ["fields.pvd", "contacts.pvd", "obstacles.pvd"];

/// Compares two runs, simulation by simulation.
///
/// # Errors
/// A folder without a run; a damaged file; histories that have no time in common.
pub fn compare(first: &Path, second: &Path, exactness: &Exactness) -> Result<Vec<Comparison>, ReadError> {
    let runs = [RunFolder::open(first)?, RunFolder::open(second)?];
    let mut all = vec![compare_simulations(&runs, exactness)?];
    let names: Vec<BTreeSet<String>> = runs.iter().map(|run| run.further().into_iter().collect()).collect();
    for name in names[0].union(&names[1]) {
        if let Some(lacking) = (0..2).find(|&run| !names[run].contains(name)) {
            all[0].missing.push(format!("the {} run has no simulation \"{name}\"", ORDINALS[lacking]));
            continue;
        }
        let further = [RunFolder::open(&first.join(name))?, RunFolder::open(&second.join(name))?];
        all.push(Comparison { simulation: name.clone(), ..compare_simulations(&further, exactness)? });
    }
    Ok(all)
}

/// Names of the two runs in messages.
const ORDINALS: [&str; 2] = ["first", "second"];

fn compare_simulations(runs: &[RunFolder; 2], exactness: &Exactness) -> Result<Comparison, ReadError> {
    let [first, second] = runs.each_ref().map(RunFolder::outcome);
    let unfinished = Some(first).filter(|first| *first == second && first != COMPLETED && first != NOT_CONSERVING);
    let mut found = Comparison { entries: entries(runs, exactness), unfinished, ..Comparison::default() };
    let units = [read_units(&runs[0].path)?, read_units(&runs[1].path)?];
    let declared = units.each_ref().map(|units| units.as_ref().map_or(Value::Null, |units| units.declared.join(", ").into()));
    let clock = match &units {
        [Some(first), Some(second)] => ratio(second.units.get("time"), first.units.get("time")),
        _ => None,
    };
    found.units.clone_from(&units[0]);
    if let [first, second] = declared
        && first != second
    {
        found.entries.push(EntryDifference { name: "units".into(), first, second, counts: false });
    }
    let histories = [0, 1].map(|run| runs[run].file("history.csv"));
    if let [Some(first), Some(second)] = &histories {
        let mut tables = [read_table(first)?.table, read_table(second)?.table];
        if let [Some(to), Some(from)] = &units {
            convert(&mut tables[1], &from.columns, &to.columns);
        }
        compare_tables(&tables, clock.is_some(), exactness, &mut found);
        if found.rows[2] == 0 && found.rows[..2].iter().all(|&rows| rows > 0) {
            let hint = "give runs of the same model over the same time";
            return Err(ReadError::new(second, format!("has no time in common with \"{}\"", first.display()), hint));
        }
    } else if let Some(lacking) = lacking(&histories) {
        found.missing.push(format!("the {lacking} run has no history.csv"));
    }
    for name in SERIES {
        let series = [0, 1].map(|run| runs[run].file(name));
        if let [Some(first), Some(second)] = &series {
            compare_frames(name, [first, second], clock, exactness, &mut found)?;
        } else if let Some(lacking) = lacking(&series) {
            found.missing.push(format!("the {lacking} run has no {name}"));
        }
    }
    Ok(found)
}

/// Ratio of two units; `None` for equal units, and if one is unknown.
fn ratio(from: Option<&String>, to: Option<&String>) -> Option<Scale> {
    let [from, to] = [from.filter(|from| to != Some(from))?, to?].map(|unit| Unit::parse(unit).ok());
    let (from, to) = (from?, to?);
    (from.dimension == to.dimension).then(|| from.scale.times(to.scale, -1))
}

/// Converts the columns of a table from units to others.
fn convert(table: &mut Table, from: &BTreeMap<String, String>, to: &BTreeMap<String, String>) {
    for column in &mut table.columns {
        if let Some(scale) = ratio(from.get(&column.name), to.get(&column.name)) {
            column.values.iter_mut().flatten().for_each(|value| *value = scale.of(*value));
        }
    }
}

/// Returns the name of the run that lacks data of the other.
fn lacking<T>(both: &[Option<T>; 2]) -> Option<&'static str> {
    match both {
        [None, Some(_)] => Some(ORDINALS[0]),
        [Some(_), None] => Some(ORDINALS[1]),
        _ => None,
    }
}

fn entries(runs: &[RunFolder; 2], exactness: &Exactness) -> Vec<EntryDifference> {
    let mut different = Vec::new();
    let mut put = |name: String, [first, second]: [Option<Value>; 2], counts: bool| {
        if first != second && !exactness.ignores(&name) {
            different.push(EntryDifference { name, first: first.unwrap_or_default(), second: second.unwrap_or_default(), counts });
        }
    };
    let parameters = [0, 1].map(|run| runs[run].parameters());
    let names: BTreeSet<&String> = parameters.iter().flatten().map(|(name, _)| name).collect();
    for name in names {
        let of = |run: usize| parameters[run].iter().find(|(known, _)| known == name).map(|(_, value)| value.clone());
        put(format!("parameter {name}"), [of(0), of(1)], true);
    }
    for (key, counts) in ENTRIES {
        let of = |run: usize| runs[run].summary.as_ref().and_then(|summary| summary.get(key)).cloned();
        put(key.into(), [of(0), of(1)], counts);
    }
    let findings = |run: usize| -> Option<Value> {
        let all = runs[run].summary.as_ref()?.get("findings")?.as_array()?;
        let kind = |finding: &Value| Some(format!("{} {}", finding.get("kind")?.as_str()?, finding.get("contact")?.as_str().unwrap_or("")));
        let kinds: Vec<Value> = all.iter().filter_map(kind).map(|kind| kind.trim().into()).collect();
        Some(kinds.into())
    };
    put("findings".into(), [findings(0), findings(1)], true);
    different
}

/// Returns pairs of rows with equal times, up to round-off where they were converted, in ascending order.
fn common_rows(times: [&[Option<f64>]; 2], is_converted: bool) -> Vec<[usize; 2]> {
    let is_same = |a: &Option<f64>, b: &Option<f64>| match (a, b) {
        (Some(a), Some(b)) => is_converted && (a - b).abs() <= SAME_MOMENT * a.abs(),
        _ => false,
    };
    let (mut common, mut i, mut j) = (Vec::new(), 0, 0);
    while let (Some(a), Some(b)) = (times[0].get(i), times[1].get(j)) {
        match a.partial_cmp(b).filter(|_| !is_same(a, b)) {
            Some(std::cmp::Ordering::Less) => i += 1,
            Some(std::cmp::Ordering::Greater) => j += 1,
            _ => {
                common.push([i, j]);
                (i, j) = (i + 1, j + 1);
            }
        }
    }
    common
}

fn compare_tables(tables: &[Table; 2], is_converted: bool, exactness: &Exactness, found: &mut Comparison) {
    let empty = Vec::new();
    let times = [0, 1].map(|run| tables[run].column("time").map_or(empty.as_slice(), |column| column.values.as_slice()));
    let rows = common_rows(times, is_converted);
    found.rows = [tables[0].rows(), tables[1].rows(), rows.len()];
    for run in 0..2 {
        let lacking = tables[1 - run].columns.iter().filter(|column| tables[run].column(&column.name).is_none());
        let lacking = lacking.filter(|column| !exactness.ignores(&column.name));
        found.missing.extend(lacking.map(|column| format!("the {} run has no column `{}`", ORDINALS[run], column.name)));
    }
    let pairs: Vec<[&Column; 2]> = tables[0]
        .columns
        .iter()
        .filter(|column| !exactness.ignores(&column.name))
        .filter_map(|column| Some([column, tables[1].column(&column.name)?]))
        .collect();
    found.columns_compared = pairs.len();
    let size = |kind: &str| {
        let of_kind = pairs.iter().flatten().filter(|column| kind_of(&column.name) == kind);
        of_kind
            .flat_map(|column| column.values.iter().flatten())
            .filter(|value| value.is_finite())
            .fold(0.0, |most: f64, v| most.max(v.abs()))
    };
    for pair in &pairs {
        let scale = size(kind_of(&pair[0].name));
        let mut difference = Difference::new(exactness.tolerance, scale);
        for (index, &[i, j]) in rows.iter().enumerate() {
            difference.see(index, pair[0].values[i], pair[1].values[j]);
        }
        let Some(first) = difference.first else { continue };
        let step = |index: usize| tables[0].column("step").and_then(|column| column.values[rows[index][0]]).unwrap_or(0.0) as usize;
        found.columns.push(ColumnDifference {
            column: pair[0].name.clone(),
            from_step: step(first),
            from_time: times[0][rows[first][0]].unwrap_or(f64::NAN),
            rows: difference.count,
            largest: Some(difference.largest).filter(|largest| largest.is_finite()),
            relative: difference.relative(),
            at_step: step(difference.at),
            first: pair[0].values[rows[difference.at][0]],
            second: pair[1].values[rows[difference.at][1]],
        });
    }
}

/// Returns the kind of a column; columns of one kind have a common scale.
fn kind_of(column: &str) -> &str {
    match column {
        "kinetic" | "strain" | "potential" | "total" | "load_work" | "contact_work" | "friction_work" | "energy_defect" | "reserve"
        | "dissipation" => "energy",
        _ if column.starts_with("angular_momentum") => "angular_momentum",
        _ if column.starts_with("momentum") => "momentum",
        _ if column.contains(".force_") || column.ends_with(".normal_force") => column.rsplit_once('.').map_or(column, |(owner, _)| owner),
        // Components of a probe's displacement and velocity: `tip.ux` and `tip.uy`.
        _ => match column.rsplit_once('.') {
            Some((_, "ux" | "uy" | "uz" | "vx" | "vy" | "vz")) => &column[..column.len() - 1],
            _ => column,
        },
    }
}

/// Difference of two sequences of numbers.
struct Difference {
    allowed: f64,
    scale: f64,
    first: Option<usize>,
    count: usize,
    largest: f64,
    at: usize,
}

impl Difference {
    fn new(tolerance: f64, scale: f64) -> Self {
        Difference { allowed: tolerance * scale, scale, first: None, count: 0, largest: 0.0, at: 0 }
    }

    fn see(&mut self, index: usize, a: Option<f64>, b: Option<f64>) {
        let same = match (a, b) {
            (Some(a), Some(b)) => a == b || a.is_nan() && b.is_nan() || (a - b).abs() <= self.allowed,
            (a, b) => a == b,
        };
        if same {
            return;
        }
        let size = match (a, b) {
            (Some(a), Some(b)) if a.is_finite() && b.is_finite() => (a - b).abs(),
            _ => f64::INFINITY,
        };
        self.count += 1;
        if self.first.is_none() || size > self.largest {
            (self.largest, self.at) = (size, index);
        }
        self.first = self.first.or(Some(index));
    }

    fn relative(&self) -> Option<f64> {
        Some(self.largest / self.scale).filter(|relative| relative.is_finite())
    }
}

fn compare_frames(
    series: &'static str,
    lists: [&Path; 2],
    clock: Option<Scale>,
    exactness: &Exactness,
    found: &mut Comparison,
) -> Result<(), ReadError> {
    let mut lists = [read_frames(lists[0])?, read_frames(lists[1])?];
    if let Some(clock) = clock {
        lists[1].iter_mut().for_each(|frame| frame.time = clock.of(frame.time));
    }
    let times = lists.each_ref().map(|list| list.iter().map(|frame| Some(frame.time)).collect::<Vec<_>>());
    let common = common_rows([&times[0], &times[1]], clock.is_some());
    let [first, second] = lists.each_ref().map(Vec::len);
    if first != second || common.len() < first {
        found.missing.push(format!("{series}: {first} | {second} frames, of which {} have the same time", common.len()));
    }
    let mut fields = 0;
    for [i, j] in common {
        let frames = [read_fields(&lists[0][i].path)?, read_fields(&lists[1][j].path)?];
        found.frames_compared += 1;
        let time = lists[0][i].time;
        let grid = |frame: &FieldsRead| (frame.points, frame.cells);
        if grid(&frames[0]) != grid(&frames[1]) {
            let [[p, c], [q, d]] = [0, 1].map(|run| [frames[run].points, frames[run].cells]);
            let meshes = format!("{p} nodes and {c} cells, {q} nodes and {d} cells");
            found.miss(format!("{series}: the meshes are others, so that fields are not compared: {meshes}"));
            continue;
        }
        let own: Vec<&ArrayRead> = frames[0].arrays.iter().filter(|array| !exactness.ignores(&array.name)).collect();
        let mut compared = 0;
        for array in own {
            match frames[1].array(array.section, &array.name) {
                Some(other) if other.components == array.components && other.numbers.len() == array.numbers.len() => {
                    compared += 1;
                    let difference = compare_arrays(array, other, exactness.tolerance);
                    difference.into_iter().for_each(|new| found.differ(FieldDifference { series, from_time: time, at_time: time, ..new }));
                }
                Some(_) => found.miss(format!("{series}: the field `{}` has another size in the second run", array.name)),
                None => found.miss(format!("{series}: the second run has no field `{}`", array.name)),
            }
        }
        fields = fields.max(compared);
        let new = frames[1].arrays.iter().filter(|array| frames[0].array(array.section, &array.name).is_none());
        let new = new.filter(|array| !exactness.ignores(&array.name));
        new.for_each(|array| found.miss(format!("{series}: the first run has no field `{}`", array.name)));
    }
    found.fields_compared += fields;
    Ok(())
}

fn compare_arrays(first: &ArrayRead, second: &ArrayRead, tolerance: f64) -> Option<FieldDifference> {
    let unit = ratio(Some(&second.unit), Some(&first.unit)).unwrap_or(Scale::ONE);
    let both = || (0..first.numbers.len()).map(|index| [first.numbers.at(index), unit.of(second.numbers.at(index))]);
    let scale = both().flatten().filter(|value| value.is_finite()).fold(0.0, |most: f64, value| most.max(value.abs()));
    let mut difference = Difference::new(if matches!(first.section, Section::Cells) { 0.0 } else { tolerance }, scale);
    let (mut places, mut last) = (0, None);
    for (index, [a, b]) in both().enumerate() {
        let before = difference.count;
        difference.see(index, Some(a), Some(b));
        let place = index / first.components;
        if difference.count > before && last.replace(place) != Some(place) {
            places += 1;
        }
    }
    difference.first?;
    Some(FieldDifference {
        series: "",
        field: first.name.clone(),
        frames: 1,
        from_time: 0.0,
        at_time: 0.0,
        places,
        largest: Some(difference.largest).filter(|largest| largest.is_finite()),
        relative: difference.relative(),
        at: difference.at / first.components,
    })
}

#[cfg(test)]
mod tests {
    use super::super::files::RunFiles;
    use super::super::pvd::FieldSeries;
    use super::super::samples::{ring, scratch};
    use super::super::vtu::Frame;
    use super::*;

    fn run(files: &RunFiles, name: &str, history: &str, dt: f64, push: f64) {
        let summary = format!(
            "{{\"script\": \"{name}.rhai\", \"version\": \"1\", \"parameters\": {{\"dt\": {dt}}}, \"outcome\": \"completed\", \
             \"wall_seconds\": {{\"total\": {push}}}, \"findings\": []}}"
        );
        files.write(&format!("{name}/summary.json"), summary).unwrap();
        files.write(&format!("{name}/history.csv"), history).unwrap();
        let mut bodies = [ring("ring", [1.0, 1.5], [2, 12])];
        bodies[0].displacement[7][1] += push;
        let mut series = FieldSeries::create(files, &format!("{name}/fields.pvd")).unwrap();
        series.append(&Frame::new(0.5, &bodies), 1).unwrap();
        bodies[0].displacement[7][1] -= 0.5 * push;
        series.append(&Frame::new(1.0, &bodies), 2).unwrap();
    }

    const HISTORY: &str =
        "step,time,kinetic,total,race.force_x,race.force_y\n0,0.0,0.0,8.0,,\n1,0.5,2.0,8.0,1e-17,4.0\n2,1.0,4.0,8.0,0.0,4.0\n";

    #[test]
    fn equal_runs_are_the_same_whatever_their_clock() {
        let (directory, files) = scratch("compare same");
        run(&files, "a", HISTORY, 0.5, 0.0);
        run(&files, "b", HISTORY, 0.5, 0.0);
        let found = compare(&directory.join("a"), &directory.join("b"), &Exactness::default()).unwrap();
        assert!(found.len() == 1 && found[0].is_same(), "{found:?}");
        assert_eq!((found[0].rows, found[0].columns_compared), ([3; 3], 6));
        let entry: Vec<_> = found[0].entries.iter().map(|entry| (entry.name.as_str(), entry.counts)).collect();
        assert_eq!(entry, [("script", false)]);
    }

    #[test]
    fn differences_have_a_step_and_a_size() {
        let (directory, files) = scratch("compare different");
        run(&files, "a", HISTORY, 0.5, 0.0);
        let other = HISTORY.replace("1,0.5,2.0,8.0,1e-17", "1,0.5,2.5,8.0,-1e-17").replace("2,1.0,4.0", "2,1.0,3.0");
        run(&files, "b", &other, 0.25, 0.125);
        let (a, b) = (directory.join("a"), directory.join("b"));
        let found = compare(&a, &b, &Exactness::default()).unwrap().remove(0);
        let kinetic = &found.columns[0];
        assert_eq!((kinetic.column.as_str(), kinetic.from_step, kinetic.from_time, kinetic.rows), ("kinetic", 1, 0.5, 2));
        // The scale is the largest energy, 8.
        assert_eq!((kinetic.largest, kinetic.relative, kinetic.at_step), (Some(1.0), Some(0.125), 2));
        assert_eq!((kinetic.first, kinetic.second), (Some(4.0), Some(3.0)));
        assert_eq!(found.columns.iter().map(|column| column.column.as_str()).collect::<Vec<_>>(), ["kinetic", "race.force_x"]);
        assert_eq!(found.entries[0].name, "parameter dt");
        // The frame before the last one has the larger difference.
        let field = &found.fields[0];
        assert_eq!((field.field.as_str(), field.places, field.at, field.frames), ("displacement", 1, 7, 2));
        assert_eq!((field.series, field.from_time, field.at_time, found.frames_compared), ("fields.pvd", 0.5, 0.5, 2));
        assert!((field.largest.unwrap() - 0.125).abs() < 1e-15);
        // With a tolerance, round-off beside a force of 4 is no difference; other differences remain.
        let rough = Exactness { tolerance: 1e-12, ignored: vec!["kin*".into()] };
        assert_eq!(compare(&a, &b, &rough).unwrap()[0].columns, []);
    }

    #[test]
    fn rows_meet_at_equal_times() {
        let (directory, files) = scratch("compare rows");
        run(&files, "a", HISTORY, 0.5, 0.0);
        let fine = "step,time,kinetic,total,race.force_x\n0,0.0,0.0,8.0,\n1,0.25,1.0,8.0,0\n2,0.5,2.0,8.0,1e-17\n\
                    3,0.75,9.0,8.0,0\n4,1.0,4.0,8.0,0\n";
        run(&files, "b", fine, 0.5, 0.0);
        let found = compare(&directory.join("a"), &directory.join("b"), &Exactness::default()).unwrap().remove(0);
        assert_eq!(found.rows, [3, 5, 3]);
        assert!(!found.is_same());
        assert_eq!(found.columns.iter().map(|column| column.column.as_str()).collect::<Vec<_>>(), ["step"]);
        assert_eq!(found.missing, ["the second run has no column `race.force_y`"]);
        files.write("b/history.csv", "step,time\n0,0.1\n").unwrap();
        let error = compare(&directory.join("a"), &directory.join("b"), &Exactness::default()).unwrap_err();
        assert!(error.to_string().contains("no time in common"), "{error}");
    }

    #[test]
    fn patterns() {
        let fits = [("a", "a"), ("*", ""), ("*.ux", "tip.ux"), ("race.*", "race.force_x"), ("m*m*x", "momentum_x"), ("*ü", "üü")];
        assert!(fits.iter().all(|(pattern, name)| matches(pattern, name)));
        assert!(![("a", "ab"), ("*.ux", "tip.uy"), ("", "a")].iter().any(|(pattern, name)| matches(pattern, name)));
    }
}
