//! The history of a simulation as columns.

use rhai::{Array, Dynamic};

use super::columns::{further_values, model_columns, probe_columns};
use super::handle::SimulationHandle;
use crate::dynamics::LedgerRow;
use crate::output::is_count;
use crate::script::api::examples::flight_example;
use crate::script::language::arguments::Arguments;
use crate::script::language::failure::Failure;
use crate::script::language::function::{Call, Form, Function, Topic, body};
use crate::script::language::handle::Handle;
use crate::script::language::parameter::{Kind, Parameter};
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

/// The functions of this file.
pub fn functions() -> Vec<Function> {
    vec![history(), columns(), column()]
}

fn history() -> Function {
    Function {
        name: "history",
        form: Form::Property(SimulationHandle::receiver()),
        topic: Topic::Results,
        summary: "what every accepted step did, as columns: `sim.history.total`",
        parameters: Vec::new(),
        returns: HistoryHandle::NAME,
        example: flight_example("sim.step(3);\nprint(sim.history.total);"),
        see_also: &["plot"],
        body: body(|call| Ok(Dynamic::from(HistoryHandle(call.receiver())))),
    }
}

fn columns() -> Function {
    Function {
        name: "columns",
        form: Form::Property(HistoryHandle::receiver()),
        topic: Topic::Results,
        summary: "the names of the columns",
        parameters: Vec::new(),
        returns: "Array",
        example: flight_example("print(sim.history.columns);"),
        see_also: &["history"],
        body: body(|call| {
            let columns = call.receiver::<HistoryHandle>().0.columns();
            Ok(columns.into_iter().map(Dynamic::from).collect::<Array>().into())
        }),
    }
}

fn column() -> Function {
    Function {
        name: "column",
        form: Form::Column(HistoryHandle::receiver()),
        topic: Topic::Results,
        summary: "a column as an array, by its name",
        parameters: vec![Parameter::new("name", Kind::Text, "the name of the column")],
        returns: "Array",
        example: flight_example("sim.step(3);\nprint(sim.history.energy_defect);"),
        see_also: &["history", "columns"],
        body: body(|call| {
            let (HistoryHandle(handle), name) = (call.receiver::<HistoryHandle>(), call.text("name")?);
            handle.refuse_in_check(call)?;
            match handle.column(&name) {
                // Counts are whole numbers, so that they index arrays and print as such.
                Some(values) if is_count(&name) => {
                    Ok(values.into_iter().map(|value| Dynamic::from(value as i64)).collect::<Array>().into())
                }
                Some(values) => Ok(values.into_iter().map(Dynamic::from).collect::<Array>().into()),
                None => Err(unknown_column(call, &handle, &name).into()),
            }
        }),
    }
}

impl SimulationHandle {
    /// Names of the columns of its history: those of the ledger, of each contact pair, and of each probe.
    pub fn columns(&self) -> Vec<String> {
        let ledger = LedgerRow::columns(self.0.model.model.dimension()).into_iter().map(String::from);
        ledger.chain(model_columns(&self.0.model.model)).chain(self.probe_columns(0)).collect()
    }

    /// A column of its history; NaN where it had no value yet.
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        self.column_of(&self.0.history.borrow(), name)
    }

    /// A column of some rows of it.
    pub(super) fn column_of(&self, rows: &[LedgerRow], name: &str) -> Option<Vec<f64>> {
        let columns = self.columns();
        let index = columns.iter().position(|column| column == name)?;
        let model = &self.0.model.model;
        let own = LedgerRow::columns(model.dimension()).len();
        if index < own {
            return Some(rows.iter().filter_map(|row| row.column(name)).collect());
        }
        Some(rows.iter().map(|row| further_values(model, row).get(index - own).copied().unwrap_or(f64::NAN)).collect())
    }

    /// Names of the columns of its probes from the one of that index on.
    pub(super) fn probe_columns(&self, from: usize) -> Vec<String> {
        probe_columns(&self.0.model.model, &self.0.probes.borrow()[from..])
    }
}

/// The failure of a column that does not exist.
pub fn unknown_column(call: &Call, handle: &SimulationHandle, name: &str) -> Failure {
    let columns = handle.columns();
    let failure = call.fail(format!("the history has no column `{name}`")).cause(format!("its columns are {}", listed(&columns, "and")));
    failure.hint(did_you_mean(name, columns.iter().map(String::as_str)).unwrap_or_else(|| "use one of these names".into()))
}
