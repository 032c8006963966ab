//! Files at paths given by a script: below the run's output folder, with the extensions of their formats.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use super::failures::output_class;
use super::run_folder::RunFolder;
use super::shown::Pictures;
use crate::output::{Drawing, OutputError, png, svg};
use crate::script::language::prelude::*;
use crate::script::language::wording::joined;

/// Object whose files are written to its own folder.
pub trait Destination {
    /// Name of the simulation.
    fn name(&self) -> String;

    /// Writes a file to the folder; `None` if the session writes no files.
    fn put(&self, path: &str, bytes: &[u8]) -> Option<Result<(), OutputError>>;
}

/// Bytes of the file that the next call would write, for a caller that shows the file instead of writing it.
#[derive(Default)]
pub struct RequestedFile {
    is_asked: Cell<bool>,
    bytes: RefCell<Option<Vec<u8>>>,
}

impl RequestedFile {
    /// Keeps the bytes of the next file.
    pub fn ask(&self) {
        self.is_asked.set(true);
    }

    /// Takes the bytes of the file, if one was made.
    pub fn take(&self) -> Option<Vec<u8>> {
        self.is_asked.set(false);
        self.bytes.take()
    }

    /// Buffer for the bytes of the file that a call makes, if requested.
    pub fn of(call: &Call) -> Option<Rc<RequestedFile>> {
        let wanted: Rc<RequestedFile> = call.host.slots.get();
        wanted.is_asked.get().then_some(wanted)
    }

    /// Keeps the bytes of a file.
    pub fn put(&self, bytes: Vec<u8>) -> Dynamic {
        self.bytes.replace(Some(bytes));
        Dynamic::UNIT
    }
}

/// Writes a drawing below the output folder, as SVG or PNG according to the extension.
pub fn write_drawing(
    call: &Call,
    into: Option<&dyn Destination>,
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

/// Writes a file with one of the extensions into the folder of a simulation, or of the run; without an output folder, no file is written.
pub fn write(
    call: &Call,
    into: Option<&dyn Destination>,
    endings: &[&str],
    content: impl FnOnce() -> Result<Vec<u8>, Failure>,
) -> Result<Dynamic, Failure> {
    let path = checked_path(call, endings)?;
    if call.host.is_check() {
        call.host.findings.borrow_mut().push(format!("would write {path}"));
        return Ok(Dynamic::UNIT);
    }
    if let Some(wanted) = RequestedFile::of(call) {
        return Ok(wanted.put(content()?));
    }
    write_at(call, into, &path, &content()?)?;
    Ok(Dynamic::UNIT)
}

/// Returns the path in the call, which must have one of the extensions.
pub fn checked_path(call: &Call, endings: &[&str]) -> Result<String, Failure> {
    let argument = call.argument("path");
    let path = argument.text()?;
    if endings.iter().any(|ending| path.ends_with(ending)) {
        return Ok(path);
    }
    let quoted: Vec<String> = endings.iter().map(|ending| format!("`{ending}`")).collect();
    let failure = argument.wrong(causes::FILE, format!("must end with {}", joined(&quoted, "or")));
    // Another extension in the name is replaced.
    let stem = path.rsplit_once('.').filter(|(stem, ending)| !stem.is_empty() && !ending.contains('/')).map_or(&*path, |(stem, _)| stem);
    let is_video = [".mp4", ".webm", ".avi", ".mov", ".mkv"].iter().any(|ending| path.ends_with(ending));
    Err(match endings.contains(&".gif") && is_video {
        true => failure
            .label("a video, for which there is no encoder")
            .hint(format!("write \"{stem}.gif\", or \"{stem}.png\" (animated PNG), which video tools convert")),
        false => failure.label("another ending").hint(format!("write \"{stem}{}\"", endings[0])),
    })
}

/// Writes a file at `path`, which may differ from the path in the call; error messages show the path in the call.
pub fn write_at(call: &Call, into: Option<&dyn Destination>, path: &str, bytes: &[u8]) -> Result<(), Failure> {
    let written = match into {
        Some(destination) => destination.put(path, bytes),
        None => RunFolder::of(call.host).files(call.host).transpose().map(|files| files?.write(path, bytes).map(drop)),
    };
    note_picture(call, into.map(|destination| destination.name()), path, &written);
    told(call, path, written)
}

/// Adds a file that was written to the pictures of the run.
pub fn note_picture(call: &Call, simulation: Option<String>, path: &str, written: &Option<Result<(), OutputError>>) {
    if matches!(written, Some(Ok(()))) {
        Pictures::note(call.host, simulation, path);
    }
}

/// Converts the result of writing a file; prints a remark if the session writes no files (`None`).
pub fn told(call: &Call, path: &str, written: Option<Result<(), OutputError>>) -> Result<(), Failure> {
    let argument = call.argument("path");
    match written {
        Some(written) => written
            .map_err(|error| argument.fail(error.to_string()).code(error.code()).hint(error.hint()).of_class(output_class(&error)))?,
        None => call.host.observer.print(&format!("{path} is not written: this session has no output folder")),
    }
    Ok(())
}

/// A path below the output folder.
pub fn path_parameter(summary: &'static str) -> Parameter {
    Parameter::text("path", summary)
}
