//! The history of a simulation as columns.

use std::rc::Rc;

use super::columns::{further_values, history_columns, names};
use super::handle::SimulationHandle;
use super::known_columns::{CellPlaces, ColumnCells};
use crate::dynamics::{LedgerRow, Quantity, Rows};
use crate::output::is_count;
use crate::script::api::examples::flight_example;
use crate::script::language::failure::Class;
use crate::script::language::prelude::*;
use crate::script::language::wording::{did_you_mean, listed};

/// The columns of a simulation's history.
#[derive(Clone)]
pub struct HistoryHandle(pub SimulationHandle);

impl Handle for HistoryHandle {
    const NAME: &'static str = "History";

    fn describe(&self) -> String {
        let columns = self.0.columns();
        format!("history of {} rows with the columns {}", self.0.0.history.borrow().len(), columns.join(", "))
    }
}

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![history(), columns(), column()]
}

fn history() -> Function {
    property_of::<SimulationHandle>(Topic::Results, "history")
        .summary("the rows of all accepted steps, as columns: `sim.history.total`")
        .see_also(&["plot"])
        .example(flight_example("sim.step(3);\nprint(sim.history.total);"))
        .body(|call, _| Ok(HistoryHandle(call.receiver())))
}

fn columns() -> Function {
    property_of::<HistoryHandle>(Topic::Results, "columns")
        .summary("the names of the columns")
        .returns("Array")
        .see_also(&["history"])
        .example(flight_example("print(sim.history.columns);"))
        .body(|_, history| {
            let columns = history.0.columns();
            Ok(array_of(columns))
        })
}

fn column() -> Function {
    column_of::<HistoryHandle>(Topic::Results, "column")
        .summary("a column as an array, by its name")
        .parameters(vec![Parameter::text("name", "the name of the column")])
        .returns("Array")
        .see_also(&["history", "columns"])
        .example(flight_example("sim.step(3);\nprint(sim.history.energy_defect);"))
        .body(|call, HistoryHandle(handle)| {
            let name = call.text("name")?;
            handle.refuse_in_check(call)?;
            let values = handle.known_column(&name).ok_or_else(|| unknown_column(call, &handle, &name))?;
            handle.check_rows()?;
            if CellPlaces::has(call) {
                return Ok(Dynamic::from(ColumnCells::new(values, is_count(&name))));
            }
            // Counts are whole numbers, so that they index arrays and print as such.
            let entry = |value: &f64| if is_count(&name) { Dynamic::from(*value as i64) } else { Dynamic::from(*value) };
            Ok(values.iter().map(entry).collect::<Array>().into())
        })
}

impl SimulationHandle {
    /// Refuses a history whose older rows could not be read back from disk.
    ///
    /// # Errors
    /// Rows could not be read back.
    pub fn check_rows(&self) -> Result<(), Failure> {
        let Some(problem) = self.0.history.borrow().problem() else { return Ok(()) };
        let failure = Failure::new(Class::Output, "rows of the history cannot be read back from the disk").code("C0970").cause(problem);
        Err(failure.hint("see that the disk of the output folder is sound, and run the script again"))
    }

    /// Names of the columns of the history: those of the ledger, of each contact pair, and of each probe.
    pub fn columns(&self) -> Vec<String> {
        names(history_columns(&self.0.model.model, &self.0.probes.borrow()))
    }

    /// Returns a column of the history; NaN where it has no value.
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        self.column_of(&*self.0.history.borrow(), 0, name)
    }

    /// Returns a column of the history for a script, cached while the history grows.
    fn known_column(&self, name: &str) -> Option<Rc<Vec<f64>>> {
        let (history, mut known) = (self.0.history.borrow(), self.0.columns.borrow_mut());
        known.read(name, history.len(), |from| self.column_of(&*history, from, name))
    }

    /// Returns all columns of the history; NaN for missing values.
    pub(super) fn all_columns(&self) -> Vec<(String, Vec<f64>)> {
        let (names, model, history) = (self.columns(), &self.0.model.model, self.0.history.borrow());
        let own = Quantity::names(&LedgerRow::columns(model.dimension()));
        let mut columns = vec![Vec::with_capacity(history.len()); names.len()];
        history.visit(0, &mut |row| {
            let further = further_values(model, row).into_iter().chain(std::iter::repeat(f64::NAN));
            let values = own.iter().map(|name| row.column(name).unwrap_or(f64::NAN)).chain(further);
            columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        });
        names.into_iter().zip(columns).collect()
    }

    /// Returns a column of rows from index `from` on.
    pub(super) fn column_of<R: Rows + ?Sized>(&self, rows: &R, from: usize, name: &str) -> Option<Vec<f64>> {
        let columns = self.columns();
        let index = columns.iter().position(|column| column == name)?;
        let model = &self.0.model.model;
        let own = LedgerRow::columns(model.dimension()).len();
        let mut values = Vec::with_capacity(rows.count().saturating_sub(from));
        rows.visit(from, &mut |row| {
            let further = || further_values(model, row).get(index - own).copied();
            values.push(if index < own { row.column(name) } else { further() }.unwrap_or(f64::NAN));
        });
        Some(values)
    }
}

/// The failure of a column that does not exist.
pub fn unknown_column(call: &Call, handle: &SimulationHandle, name: &str) -> Failure {
    let columns = handle.columns();
    let failure = call
        .refuse(causes::NO_SUCH, format!("the history has no column `{name}`"))
        .cause(format!("its columns are {}", listed(&columns, "and")));
    failure.hint(did_you_mean(name, columns.iter().map(String::as_str)).unwrap_or_else(|| "use one of these names".into()))
}
