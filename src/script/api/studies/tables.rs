//! Rows as a table: as text to print, and as a CSV file.

use super::record::FAILURE;
use crate::output::rows_csv;
use crate::script::api::files::writing::{path_parameter, write};
use crate::script::language::digits::brief;
use crate::script::language::plain::Plain;
use crate::script::language::prelude::*;
use crate::script::language::tables::table;
use crate::script::language::values::describe;
use crate::script::language::wording::{did_you_mean, listed};

/// Largest number of letters of a text in a printed table.
const SHOWN: usize = 60;

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![format_table(), write_table()]
}

fn rows_parameter() -> Parameter {
    Parameter::array("rows", "an array of maps, such as `sweep` gives")
}

fn columns_parameter() -> Parameter {
    Parameter::array("columns", "names of columns, in their order").otherwise("all, as they come in the rows; `failure` where there is one")
}

fn format_table() -> Function {
    function(Topic::Studies, "format_table")
        .summary("rows as a table to print, with six digits")
        .parameters(vec![rows_parameter(), columns_parameter()])
        .see_also(&["sweep", "write_table"])
        .example("print(format_table([#{ dt: 0.1, defect: 1e-3 }, #{ dt: 0.05, defect: 2.5e-4 }], [\"dt\", \"defect\"]));")
        .body(|call| {
            let (names, rows) = rows_of(call)?;
            let cell = |value: &Plain| match value {
                Plain::Number(number) => brief(*number),
                other if other.field().chars().count() > SHOWN => other.field().chars().take(SHOWN - 1).chain(['…']).collect(),
                other => other.field(),
            };
            let rows: Vec<Vec<String>> = rows.iter().map(|row| row.iter().map(cell).collect()).collect();
            Ok(table(&names.iter().map(String::as_str).collect::<Vec<_>>(), &rows))
        })
}

fn write_table() -> Function {
    function(Topic::Studies, "write_table")
        .summary("writes rows as a CSV file, numbers with all digits")
        .parameters(vec![path_parameter("a `.csv` file below the output folder"), rows_parameter(), columns_parameter()])
        .see_also(&["sweep", "format_table", "read_csv"])
        .example("write_table(\"orders.csv\", [#{ dt: 0.1, defect: 1e-3 }, #{ dt: 0.05, defect: 2.5e-4 }]);")
        .body(|call| {
            let (names, rows) = rows_of(call)?;
            let rows: Vec<Vec<String>> = rows.iter().map(|row| row.iter().map(Plain::field).collect()).collect();
            Ok(write(call, None, &[".csv"], || Ok(rows_csv(&names, &rows)))?)
        })
}

/// The names of the columns, and the rows in their order.
fn rows_of(call: &Call) -> Result<(Vec<String>, Vec<Vec<Plain>>), Failure> {
    let argument = call.argument("rows");
    let entries = argument.array()?;
    let rows: Vec<Vec<(String, Plain)>> =
        entries.iter().enumerate().map(|(index, entry)| row(&argument, index, entry)).collect::<Result<_, _>>()?;
    let mut known: Vec<String> = Vec::new();
    for (name, _) in rows.iter().flatten() {
        if !known.contains(name) {
            known.push(name.clone());
        }
    }
    let value = |row: &Vec<(String, Plain)>, name: &String| {
        row.iter().find(|(known, _)| known == name).map_or(Plain::Nothing, |(_, value)| value.clone())
    };
    let chosen = call.argument("columns");
    let names = if chosen.is_given() {
        chosen_names(&chosen, &known)?
    } else {
        let fails = rows.iter().any(|row| !value(row, &FAILURE.to_string()).field().is_empty());
        let others = known.iter().filter(|name| *name != FAILURE).cloned();
        others.chain(fails.then(|| FAILURE.to_string())).collect()
    };
    let rows = rows.iter().map(|row| names.iter().map(|name| value(row, name)).collect()).collect();
    Ok((names, rows))
}

fn row(argument: &Argument, index: usize, entry: &Dynamic) -> Result<Vec<(String, Plain)>, Failure> {
    let given = || describe(argument.call().engine(), entry);
    let Some(map) = entry.read_lock::<Map>() else {
        let failure = argument.wrong(causes::WRONG_TYPE, "must be an array of maps");
        return Err(failure.label(format!("entry {index} is {}", given())).hint("write `[#{ dt: 0.1, defect: 1e-3 }]`"));
    };
    let field = |(name, value): (&rhai::Identifier, &Dynamic)| match Plain::of(value) {
        Some(plain) => Ok((name.to_string(), plain)),
        None => {
            let failure = argument.refuse(causes::WRONG_TYPE, format!("`{name}` of entry {index} of {} is no data", argument.title()));
            Err(failure.label(format!("this is {}", describe(argument.call().engine(), value))).hint("give a number of it"))
        }
    };
    map.iter().map(field).collect()
}

fn chosen_names(argument: &Argument, known: &[String]) -> Result<Vec<String>, Failure> {
    let name = |entry: &Dynamic| {
        let Ok(name) = entry.clone().into_string() else { return Err(argument.wrong_type()) };
        if known.contains(&name) {
            return Ok(name);
        }
        let failure = argument
            .refuse(causes::NO_SUCH, format!("the rows have no column `{name}`"))
            .cause(format!("their columns are {}", listed(known, "and")));
        Err(failure.hint(did_you_mean(&name, known.iter().map(String::as_str)).unwrap_or_else(|| "use one of these names".into())))
    };
    argument.array()?.iter().map(name).collect()
}
