//! What results have in common: paths below the run's output folder, the formats of drawings, columns by their names.

use rhai::{Array, Dynamic};

use super::artifacts::output_class;
use super::handle::SimulationHandle;
use super::history::unknown_column;
use super::run_folder::RunFolder;
use crate::output::{Drawing, OutputError, png, svg};
use crate::script::language::arguments::Arguments;
use crate::script::language::failure::Failure;
use crate::script::language::function::Call;
use crate::script::language::parameter::{Kind, Parameter};
use crate::script::language::scan::Target;
use crate::script::language::values::describe;
use crate::script::language::wording::joined;

/// Writes a drawing below the output folder, as SVG or PNG as the ending says.
pub fn write_drawing(
    call: &Call,
    into: Option<&SimulationHandle>,
    draw: impl FnOnce() -> Result<Drawing, Failure>,
) -> Result<Dynamic, Failure> {
    let is_png = call.text("path")?.ends_with(".png");
    let content = || {
        let drawing = draw()?;
        let bytes = call.host.watched(move || if is_png { png(&drawing) } else { Some(svg(&drawing).into_bytes()) })?;
        bytes.ok_or_else(|| call.fail("there is no memory for a picture of this size").hint("choose a smaller `width`"))
    };
    write(call, into, &[".svg", ".png"], content)
}

/// Writes a file with one of the endings into the folder of a simulation, or of the run; without an output folder nothing is written.
pub fn write(
    call: &Call,
    into: Option<&SimulationHandle>,
    endings: &[&str],
    content: impl FnOnce() -> Result<Vec<u8>, Failure>,
) -> Result<Dynamic, Failure> {
    let path = checked_path(call, endings)?;
    if call.host.is_check() {
        call.host.findings.borrow_mut().push(format!("would write {path}"));
        return Ok(Dynamic::UNIT);
    }
    write_at(call, into, &path, &content()?)?;
    Ok(Dynamic::UNIT)
}

/// The same for what shows the run so far: while steps come from the journal, the file is that which an earlier program has written.
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
    if into.0.artifacts.borrow().as_ref().is_some_and(|artifacts| artifacts.has_written(&path)) {
        return Ok(Dynamic::UNIT);
    }
    let bytes = content()?;
    let written = into.0.artifacts.borrow_mut().as_mut().map(|artifacts| artifacts.write_counted(&path, &bytes));
    told(call, &path, written)?;
    Ok(Dynamic::UNIT)
}

/// The path of the call, which must have one of the endings.
fn checked_path(call: &Call, endings: &[&str]) -> Result<String, Failure> {
    let argument = call.argument("path");
    let path = argument.text()?;
    if endings.iter().any(|ending| path.ends_with(ending)) {
        return Ok(path);
    }
    let quoted: Vec<String> = endings.iter().map(|ending| format!("`{ending}`")).collect();
    let failure = argument.fail(format!("{} must end with {}", argument.title(), joined(&quoted, "or")));
    // What looks like another ending gives way.
    let stem = path.rsplit_once('.').filter(|(stem, ending)| !stem.is_empty() && !ending.contains('/')).map_or(&*path, |(stem, _)| stem);
    let is_video = [".mp4", ".webm", ".avi", ".mov", ".mkv"].iter().any(|ending| path.ends_with(ending));
    Err(match endings.contains(&".gif") && is_video {
        true => failure
            .label("a video, for which there is no encoder")
            .hint(format!("write \"{stem}.gif\", or \"{stem}.png\" (animated PNG), which video tools convert")),
        false => failure.label("another ending").hint(format!("write \"{stem}{}\"", endings[0])),
    })
}

/// Writes a file at a path that may not be the one of the call; a failure points at that one.
pub fn write_at(call: &Call, into: Option<&SimulationHandle>, path: &str, bytes: &[u8]) -> Result<(), Failure> {
    let written = match into {
        Some(handle) => handle.0.artifacts.borrow_mut().as_mut().map(|artifacts| artifacts.write(path, bytes)),
        None => RunFolder::of(call.host).files(call.host).transpose().map(|files| files?.write(path, bytes).map(drop)),
    };
    told(call, path, written)
}

/// What became of a file; `None` where the session writes none.
fn told(call: &Call, path: &str, written: Option<Result<(), OutputError>>) -> Result<(), Failure> {
    let argument = call.argument("path");
    match written {
        Some(written) => written.map_err(|error| argument.fail(error.to_string()).hint(error.cure()).of_class(output_class(&error)))?,
        None => call.host.observer.print(&format!("{path} is not written: this session has no output folder")),
    }
    Ok(())
}

/// The columns of the history that the argument `columns` names.
pub fn chosen_columns(call: &Call, handle: &SimulationHandle) -> Result<Vec<(String, Vec<f64>)>, Failure> {
    let argument = call.argument("columns");
    let value = if argument.is_given() { argument.value() } else { Dynamic::from("total") };
    let names: Option<Vec<String>> = match value.read_lock::<Array>() {
        Some(array) => array.iter().map(|name| name.clone().into_string().ok()).collect(),
        None => value.clone().into_string().ok().map(|name| vec![name]),
    };
    let Some(names) = names.filter(|names| !names.is_empty()) else {
        let failure = argument.fail(format!("{} must be a column's name or an array of names", argument.title()));
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

/// A path below the output folder.
pub fn path_parameter(summary: &'static str) -> Parameter {
    Parameter::new("path", Kind::Text, summary)
}
