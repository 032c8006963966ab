//! `sim.table`: columns of the history as a file for other programs, CSV or Parquet according to the extension.

use super::handle::SimulationHandle;
use super::writing::chosen_columns;
use crate::dynamics::{LedgerRow, Quantity};
use crate::output::{Column, Table, parquet_in_units};
use crate::script::api::examples::flight_example;
use crate::script::api::files::writing::{path_parameter, write};
use crate::script::language::prelude::*;

/// `table`: selected columns of the present history.
pub fn table() -> Function {
    method_of::<SimulationHandle>(Topic::Results, "table")
        .summary(
            "writes columns of the history so far as a table, as CSV or Parquet as the ending says; a value that does not exist, such as a \
             force before the first step, is an empty field or a null",
        )
        .parameters(vec![
            path_parameter("a `.csv` or `.parquet` file below the output folder"),
            Parameter::any("columns", "the name of a column, or an array of names").otherwise("all columns"),
        ])
        .see_also(&["history", "plot", "probe"])
        .example(flight_example(
            "sim.run_to(0.05);\nsim.table(\"energies.csv\", [\"time\", \"kinetic\", \"strain\"]);\nsim.table(\"all.parquet\");",
        ))
        .body(|call, handle| {
            let table = columns(call, &handle)?;
            let is_parquet = call.text("path")?.ends_with(".parquet");
            let content = || match is_parquet {
                true => parquet_in_units(&table, &handle.0.column_units())
                    .map_err(|refused| call.fail("the table cannot be written as Parquet").cause(refused)),
                false => Ok(table.to_csv()),
            };
            Ok(write(call, Some(&handle), &[".csv", ".parquet"], content)?)
        })
}

/// Columns named in the call, each once.
fn columns(call: &Call, handle: &SimulationHandle) -> Result<Table, Failure> {
    let argument = call.argument("columns");
    let chosen = if argument.is_given() { chosen_columns(call, handle)? } else { handle.all_columns() };
    for (index, (name, _)) in chosen.iter().enumerate() {
        if chosen[..index].iter().any(|(other, _)| other == name) {
            let failure = argument.refuse(causes::NAME_TAKEN, format!("the column `{name}` is named twice"));
            return Err(failure.hint("a table has each column once"));
        }
    }
    let ledger = Quantity::names(&LedgerRow::columns(handle.0.model.model.dimension()));
    let column = |(name, values): (String, Vec<f64>)| Column::of_history(&name, values, ledger.contains(&name.as_str()));
    Ok(Table { columns: chosen.into_iter().map(column).collect() })
}
