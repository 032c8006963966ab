//! Common parts of results of a simulation: its folder, files that show the run so far, columns by name.

use super::handle::SimulationHandle;
use super::history::unknown_column;
use crate::output::OutputError;
use crate::script::api::files::writing::{Destination, RequestedFile, checked_path, note_picture, told, write};
use crate::script::language::prelude::*;
use crate::script::language::values::describe;

impl Destination for SimulationHandle {
    fn name(&self) -> String {
        self.0.name.clone()
    }

    fn put(&self, path: &str, bytes: &[u8]) -> Option<Result<(), OutputError>> {
        self.0.artifacts.borrow_mut().as_mut().map(|artifacts| artifacts.write(path, bytes))
    }
}

/// Writes a file that shows the run so far; while steps come from the journal, the file of an earlier process is kept.
pub fn write_course(
    call: &Call,
    into: &SimulationHandle,
    endings: &[&str],
    content: impl FnOnce() -> Result<Vec<u8>, Failure>,
) -> Result<Dynamic, Failure> {
    let path = checked_path(call, endings)?;
    if call.host.is_check() {
        return write(call, Some(into), endings, content);
    }
    into.looked()?;
    if let Some(wanted) = RequestedFile::of(call) {
        return Ok(wanted.put(content()?));
    }
    if into.0.artifacts.borrow().as_ref().is_some_and(|artifacts| artifacts.has_written(&path)) {
        note_picture(call, Some(into.name()), &path, &Some(Ok(())));
        return Ok(Dynamic::UNIT);
    }
    let bytes = content()?;
    let written = into.0.artifacts.borrow_mut().as_mut().map(|artifacts| artifacts.write_counted(&path, &bytes));
    note_picture(call, Some(into.name()), &path, &written);
    told(call, &path, written)?;
    Ok(Dynamic::UNIT)
}

/// Columns of the history named in the argument `columns`.
pub fn chosen_columns(call: &Call, handle: &SimulationHandle) -> Result<Vec<(String, Vec<f64>)>, Failure> {
    let argument = call.argument("columns");
    let value = if argument.is_given() { argument.value() } else { Dynamic::from("total") };
    let names: Option<Vec<String>> = match value.read_lock::<Array>() {
        Some(array) => array.iter().map(|name| name.clone().into_string().ok()).collect(),
        None => value.clone().into_string().ok().map(|name| vec![name]),
    };
    let Some(names) = names.filter(|names| !names.is_empty()) else {
        let failure = argument.wrong(causes::WRONG_TYPE, "must be a column's name or an array of names");
        let given = describe(call.engine(), &value);
        return Err(failure.label(format!("this is {given}")).hint("write `[\"kinetic\", \"total\"]`"));
    };
    let place = call.function.parameters.iter().position(|parameter| parameter.name == "columns").unwrap_or(0);
    let column = |name: String| match handle.column(&name) {
        Some(values) => Ok((name, values)),
        None => Err(unknown_column(call, handle, &name).at(Target::Argument(place))),
    };
    names.into_iter().map(column).collect()
}
