//! The table of a study: a row for each point, with its parameters, results and outcome.

use std::collections::BTreeMap;

use serde_json::Value;

use super::folder::{PointState, StudyFolder};
use super::plan::Plan;
use super::record::{BALANCE, Record};
use crate::output::{Column, TableField, TextColumn, csv_field, parquet_of, pretty_unit};

/// Column of numbers or texts.
#[derive(Clone, Debug, PartialEq)]
pub enum StudyColumn {
    /// Column of numbers.
    Numbers(Column),
    /// Column of texts.
    Texts(TextColumn),
}

impl StudyColumn {
    /// Name of the column.
    pub fn name(&self) -> &str {
        match self {
            StudyColumn::Numbers(column) => &column.name,
            StudyColumn::Texts(column) => &column.name,
        }
    }

    /// Returns a cell as in a CSV file.
    pub fn cell(&self, row: usize) -> String {
        match self {
            StudyColumn::Numbers(column) => match column.values[row] {
                Some(value) if column.is_count => format!("{value}"),
                Some(value) => format!("{value:?}"),
                None => String::new(),
            },
            StudyColumn::Texts(column) => column.values[row].as_deref().map_or_else(String::new, csv_field),
        }
    }

    /// Returns a cell for display, with few digits.
    pub fn shown(&self, row: usize) -> String {
        match self {
            StudyColumn::Numbers(column) => column.values[row].map_or_else(String::new, short),
            StudyColumn::Texts(column) => column.values[row].clone().unwrap_or_default(),
        }
    }

    /// Returns the values of a column of numbers; `None` for a column of texts.
    pub fn numbers(&self) -> Option<&[Option<f64>]> {
        match self {
            StudyColumn::Numbers(column) => Some(&column.values),
            StudyColumn::Texts(_) => None,
        }
    }
}

/// The table of a study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StudyTable {
    /// Columns: `index`, `id`, parameters, results, `outcome`, `cause`, `warnings`, `steps`, drifts of energy and of linear and angular
    /// momentum, `version`, `scripts`, `command`, `wall_seconds`.
    pub columns: Vec<StudyColumn>,
    /// Range of the columns of parameters.
    pub parameters: std::ops::Range<usize>,
    /// Range of the columns of results.
    pub results: std::ops::Range<usize>,
    /// Units of the columns that have one in all points, by name.
    pub units: BTreeMap<String, String>,
}

/// Names of the columns other than parameters and results.
const OWN: [&str; 10] = ["index", "id", "outcome", "cause", "warnings", "steps", "version", "scripts", "command", "wall_seconds"];

impl StudyTable {
    /// Returns the table of all points, and their states.
    pub fn of(study: &StudyFolder, plan: &Plan) -> (Self, Vec<PointState>) {
        let states: Vec<PointState> = plan.points.iter().map(|point| study.state(point)).collect();
        (Self::from_states(plan, &states), states)
    }

    fn from_states(plan: &Plan, states: &[PointState]) -> Self {
        let record = |state: &PointState| match state {
            PointState::Done(record) => Some(record.clone()),
            _ => None,
        };
        let records: Vec<Option<Record>> = states.iter().map(record).collect();
        let mut columns = vec![
            numbers("index", true, (0..plan.points.len()).map(|index| Some(index as f64)).collect()),
            texts("id", plan.points.iter().map(|point| Some(point.id.clone())).collect()),
        ];
        let parameters = columns.len()..columns.len() + plan.names.len();
        let mut units = BTreeMap::from([("wall_seconds".to_string(), "s".to_string())]);
        for (place, name) in plan.names.iter().enumerate() {
            let shown = own_name(name, "parameter");
            if let Some(unit) = records.iter().flatten().find_map(|record| record.parameter_units.get(name)) {
                units.insert(shown.clone(), unit.clone());
            }
            columns.push(parameter(&shown, plan.points.iter().map(|point| point.values[place].as_str()).collect()));
        }
        let mut names: Vec<&str> = Vec::new();
        for result in records.iter().flatten().flat_map(|record| &record.results) {
            if !names.contains(&result.name.as_str()) {
                names.push(&result.name);
            }
        }
        let results = columns.len()..columns.len() + names.len();
        for name in names {
            let shown =
                if plan.names.iter().any(|parameter| parameter == name) { format!("{name} (result)") } else { own_name(name, "result") };
            columns.push(result_column(&shown, records.iter().map(|record| value_of(record.as_ref(), name)).collect()));
            if let Some(unit) = unit_of(records.iter().flatten(), name) {
                units.insert(shown, unit);
            }
        }
        let (outcomes, causes) = states.iter().map(told).unzip();
        columns.push(texts("outcome", outcomes));
        columns.push(texts("cause", causes));
        let of = |value: &dyn Fn(&Record) -> Option<f64>| records.iter().map(|record| record.as_ref().and_then(value)).collect();
        columns.push(numbers("warnings", true, of(&|record| Some(record.warnings as f64))));
        columns.push(numbers("steps", true, of(&|record| record.steps.map(|steps| steps as f64))));
        for (place, name) in BALANCE.iter().enumerate() {
            columns.push(numbers(name, false, of(&|record| record.balance[place])));
        }
        let words = |word: &dyn Fn(&Record) -> Option<String>| records.iter().map(|record| record.as_ref().and_then(word)).collect();
        columns.push(texts("version", words(&|record| Some(record.version.clone()))));
        columns.push(texts("scripts", words(&|record| record.scripts.clone())));
        columns.push(texts("command", plan.points.iter().map(|point| Some(plan.command(point))).collect()));
        columns.push(numbers("wall_seconds", false, of(&|record| Some(record.wall_seconds))));
        StudyTable { columns, parameters, results, units }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        match self.columns.first() {
            Some(StudyColumn::Numbers(column)) => column.values.len(),
            Some(StudyColumn::Texts(column)) => column.values.len(),
            None => 0,
        }
    }

    /// Returns the column with a name.
    pub fn column(&self, name: &str) -> Option<&StudyColumn> {
        self.columns.iter().find(|column| column.name() == name)
    }

    /// Name of a column with its unit in brackets, if it has one.
    pub fn titled(&self, column: &StudyColumn) -> String {
        let name = column.name();
        self.units.get(name).map_or(name.to_string(), |unit| format!("{name} [{}]", pretty_unit(unit)))
    }

    /// Name of a column with its value in a row and the unit, such as `gap = 0.1 mm`.
    pub fn assigned(&self, column: &StudyColumn, row: usize) -> String {
        let (name, value) = (column.name(), column.shown(row));
        self.units.get(name).map_or(format!("{name} = {value}"), |unit| format!("{name} = {value} {}", pretty_unit(unit)))
    }

    /// Returns the text of `units.json`: the unit of each column that has one.
    pub fn units_json(&self) -> String {
        // A map of texts always has a JSON form.
        serde_json::to_string_pretty(&serde_json::json!({ "columns": self.units })).unwrap_or_default() + "\n"
    }

    /// Returns the text of `table.csv`.
    pub fn to_csv(&self) -> Vec<u8> {
        let mut text = self.columns.iter().map(|column| csv_field(column.name())).collect::<Vec<_>>().join(",") + "\n";
        for row in 0..self.rows() {
            let cells: Vec<String> = self.columns.iter().map(|column| column.cell(row)).collect();
            text += &(cells.join(",") + "\n");
        }
        text.into_bytes()
    }

    /// Encodes the table as `table.parquet`.
    ///
    /// # Errors
    /// The format refuses the table; the text gives the reason.
    pub(crate) fn to_parquet(&self) -> Result<Vec<u8>, String> {
        let fields: Vec<TableField> = self
            .columns
            .iter()
            .map(|column| match column {
                StudyColumn::Numbers(column) => TableField::Numbers(column),
                StudyColumn::Texts(column) => TableField::Texts(column),
            })
            .collect();
        parquet_of(&fields, &self.units)
    }
}

/// Returns a result of a point by its name.
fn value_of<'a>(record: Option<&'a Record>, name: &str) -> Option<&'a Value> {
    record?.results.iter().find(|result| result.name == name).map(|result| &result.value)
}

/// Returns the unit of a result; `None` without one, and where points name different ones.
fn unit_of<'a>(records: impl Iterator<Item = &'a Record>, name: &str) -> Option<String> {
    let mut units = records.flat_map(|record| &record.results).filter(|result| result.name == name).map(|result| &result.unit);
    let first = units.next().filter(|unit| !unit.is_empty())?;
    units.all(|unit| unit == first).then(|| first.clone())
}

/// Formats a number with six digits.
fn short(value: f64) -> String {
    let value: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    if value == 0.0 || (0.001..1e9).contains(&value.abs()) { format!("{value}") } else { format!("{value:e}") }
}

/// Returns a name for a column that differs from those of the program.
fn own_name(name: &str, kind: &str) -> String {
    if OWN.contains(&name) || BALANCE.contains(&name) { format!("{name} ({kind})") } else { name.into() }
}

fn numbers(name: &str, is_count: bool, values: Vec<Option<f64>>) -> StudyColumn {
    StudyColumn::Numbers(Column { name: name.into(), values, is_count })
}

fn texts(name: &str, values: Vec<Option<String>>) -> StudyColumn {
    StudyColumn::Texts(TextColumn { name: name.into(), values })
}

/// Returns the outcome of a point, and the cause if the point is not completed.
fn told(state: &PointState) -> (Option<String>, Option<String>) {
    let cause = match state {
        PointState::Done(record) => record.cause.clone(),
        PointState::UnderWay => None,
        PointState::Stopped(who) => Some(format!("begun and not finished by {who}")),
        PointState::Missing => Some("not begun".into()),
    };
    (Some(state.word().into()), cause)
}

/// Returns the column of a parameter: numbers if all values are numbers.
fn parameter(name: &str, values: Vec<&str>) -> StudyColumn {
    let parsed: Option<Vec<f64>> = values.iter().map(|value| value.trim().parse().ok().filter(|number: &f64| number.is_finite())).collect();
    match parsed {
        Some(parsed) => {
            let is_count = values.iter().all(|value| value.trim().parse::<i64>().is_ok_and(|whole| whole.unsigned_abs() < 1 << 53));
            numbers(name, is_count, parsed.into_iter().map(Some).collect())
        }
        None => texts(name, values.into_iter().map(|value| Some(value.to_string())).collect()),
    }
}

/// Returns the column of a result: numbers if all values are numbers, otherwise texts, with arrays as JSON.
fn result_column(name: &str, values: Vec<Option<&Value>>) -> StudyColumn {
    let number = |value: &Value| match value {
        Value::Number(number) => number.as_f64(),
        // Numbers that are not finite are words in JSON.
        Value::String(word) if ["NaN", "inf", "-inf"].contains(&word.as_str()) => word.parse().ok(),
        _ => None,
    };
    if values.iter().flatten().all(|value| number(value).is_some()) {
        let is_count = values.iter().flatten().all(|value| value.is_i64() || value.is_u64());
        return numbers(name, is_count, values.into_iter().map(|value| value.and_then(number)).collect());
    }
    let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), String::from);
    texts(name, values.into_iter().map(|value| value.map(text)).collect())
}

#[cfg(test)]
mod tests {
    use super::super::design::Rows;
    use super::super::plan::{Limits, Scenario};
    use super::super::record::{PointResult, RecordOutcome};
    use super::*;

    #[test]
    fn rows_of_all_kinds() {
        let rows = ["0.5", "1", "2", "3"].map(|value| vec![value.to_string()]).to_vec();
        let plan = Plan::new(Scenario::default(), Limits::default(), Rows { names: vec!["dt".into()], rows }).unwrap();
        let result = |name: &str, value: Value| PointResult { name: name.into(), value, unit: String::new() };
        let done = |index: usize, results| {
            PointState::Done(Record { cause: None, results, ..Record::of(&plan.points[index].id, RecordOutcome::Completed, "") })
        };
        let states = [
            done(0, vec![result("peak", 1.into()), result("dt", "NaN".into()), result("steps", serde_json::json!([1, 2.5]))]),
            done(1, vec![result("peak", 2.into()), result("dt", 0.25.into()), result("law", "soft, old".into())]),
            PointState::Done(Record::of(&plan.points[2].id, RecordOutcome::Failed, "x.rhai:3:1: no equilibrium")),
            PointState::Missing,
        ];
        let table = StudyTable::from_states(&plan, &states);
        let text = String::from_utf8(table.to_csv()).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert!(
            lines[0].starts_with("index,id,dt,peak,dt (result),steps (result),law,outcome,cause,warnings,steps,energy_drift"),
            "{text}"
        );
        assert!(lines[1].starts_with("0,dt=0.5,0.5,1,NaN,\"[1,2.5]\",,completed,,0,,"), "{text}");
        assert!(lines[2].starts_with("1,dt=1,1.0,2,0.25,,\"soft, old\",completed,,0,,"), "{text}");
        assert!(lines[3].starts_with("2,dt=2,2.0,,,,,failed,x.rhai:3:1: no equilibrium,0,,"), "{text}");
        assert!(lines[4].starts_with("3,dt=3,3.0,,,,,missing,not begun,,"), "{text}");
        let bytes = table.to_parquet().unwrap();
        assert_eq!((&bytes[..4], &bytes[bytes.len() - 4..]), (&b"PAR1"[..], &b"PAR1"[..]));
    }
}
