//! Reads and writes mesh files; messages on a faulty file show the line or byte.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use super::handle::MeshHandle;
use crate::mesh::{self, FileNote, FilePosition, MeshError, ReadOptions, Shells, Structural};
use crate::script::api::files::writing::{path_parameter, write};
use crate::script::api::remedies::ScriptWords;
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::failure::Details;
use crate::script::language::prelude::*;

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![reader(), writer()]
}

fn reader() -> Function {
    let mut parameters = reading_parameters();
    let part = "name of the only part that is read, with its boundaries, such as a body of a frame";
    parameters.push(Parameter::text("part", part).otherwise("the whole file"));
    function(Topic::Meshes, "read_mesh")
        .summary(
            "a mesh from a file. Gmsh (MSH 2.2 or 4.1, ASCII or binary): physical groups are parts and boundaries. Abaqus or CalculiX \
             (`.inp`): sets of elements are parts, surfaces and sets of nodes boundaries; several instances are parts, too, and their sets \
             have names such as `\"Block-1.top\"`. VTU and legacy VTK: arrays of whole numbers of cells are parts such as `\"ref 1\"`, and \
             `read_mesh` gives the bodies of frames of a run back by their names. Medit (`.mesh`), UNV, Nastran bulk data, SU2: \
             references, groups, properties and markers are parts and boundaries",
        )
        .parameters(vec![
            Parameter::text("path", "the file, below the script's folder or a folder that `--allow-read` names"),
            Parameter::options("how it is read").otherwise("its defaults").keys(parameters),
        ])
        .see_also(&["read_deck", "write", "part", "rectangle", "ring"])
        .example("expect_error(|| read_mesh(\"missing.msh\"), \"there is no file\");")
        .body(|call| {
            let argument = call.argument("path");
            let (path, options) = (argument.text()?, call.options("options")?);
            let file = readable(&argument, &path)?;
            let find = |name: &str| included(call, &file, name);
            let part = options.argument("part").given(Argument::text)?;
            let read = mesh::read_mesh_with(&file, ReadOptions { part, ..read_options(&options)? }, Some(&find));
            let (mesh, notes) = read.map_err(|error| read_failure(&argument, &path, &file, &error))?;
            notes_warned(call, &path, &notes);
            Ok(MeshHandle::new(mesh))
        })
}

/// Options of functions that read mesh files.
pub fn reading_parameters() -> Vec<Parameter> {
    let skip = "whether elements that are no cells (springs, masses, beams, shells beside cells) are left out with a warning or refused";
    let shells = "whether shells and membranes of a file without other cells are refused or read as plane cells";
    vec![
        Parameter::new("skip", Kind::Choice(&["warn", "error"]), skip).or("warn"),
        Parameter::new("shells", Kind::Choice(&["error", "plane"]), shells).or("error"),
    ]
}

/// Reading options from the values of [`reading_parameters`].
///
/// # Errors
/// Another word.
pub fn read_options(options: &Options) -> Result<ReadOptions, Failure> {
    let is = |name: &str, word: &str| options.text(name).map(|given| given == word);
    Ok(ReadOptions {
        structural: if is("skip", "error")? { Structural::Refused } else { Structural::Skipped },
        shells: if is("shells", "plane")? { Shells::Plane } else { Shells::Refused },
        part: None,
    })
}

/// Returns the path of a file that a mesh file includes, relative to the folder of the mesh file.
///
/// # Errors
/// The file does not exist, or the script may not read it.
pub fn included(call: &Call, file: &Path, name: &str) -> Result<PathBuf, String> {
    let beside = file.parent().unwrap_or(file).join(name);
    call.host.sandbox.readable(&beside.to_string_lossy()).map_err(|failure| failure.title.clone())
}

/// Warns of changes made to the content of a mesh file.
pub fn notes_warned(call: &Call, path: &str, notes: &[FileNote]) {
    for note in notes {
        let warning = Diagnostic::warning(note.to_string(), call.place(&Target::Argument(0))).code(note.code());
        let warning = warning.label(format!("in the file \"{path}\""));
        call.host.warn(match note {
            FileNote::Skipped(_) => warning.hint("`skip: \"error\"` refuses a file with such elements"),
            FileNote::Arrays(_) => warning.hint("fields of results are read by other programs, such as PyVista and meshio"),
            FileNote::WithoutCells(_) => warning.hint("a rigid body is an obstacle here, such as `rigid_sphere` or `rigid_surface`"),
            _ => warning,
        });
    }
}

/// Returns the file named by a path in an argument, if the script may read it.
///
/// # Errors
/// The script may not read the file, or it does not exist.
pub fn readable(argument: &Argument, path: &str) -> Result<PathBuf, Failure> {
    argument.call().host.sandbox.readable(path).map_err(|failure: Failure| {
        let Details { title, code, causes, hints, .. } = &*failure;
        let failure = causes.iter().fold(argument.fail(title.clone()).code(code), |failure, cause| failure.cause(cause.clone()));
        hints.iter().fold(failure, |failure, hint| failure.hint(hint.clone()))
    })
}

/// Returns the failure of reading a mesh file, with the place in the file.
pub fn read_failure(argument: &Argument, path: &str, file: &Path, error: &MeshError) -> Failure {
    let file = error.included_file().unwrap_or(file);
    let failure = argument.fail(error.to_string()).code(error.code()).label(format!("in the file \"{path}\""));
    let included = error.included_file().and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
    let failure =
        included.into_iter().fold(failure, |failure, name| failure.cause(format!("it is in the file \"{name}\" that is included")));
    let failure = match error.place() {
        None => failure,
        Some(FilePosition::Byte(byte)) => failure.cause(format!("it shows at byte {byte} of the file")),
        Some(FilePosition::Line(number)) => match file_line(file, number) {
            Some(text) => failure.cause(format!("line {number} of the file reads `{text}`")),
            None => failure.cause(format!("it shows in line {number} of the file")),
        },
    };
    failure.hint(error.remedy())
}

fn writer() -> Function {
    method_of::<MeshHandle>(Topic::Meshes, "write")
        .summary(
            "writes the mesh as a Gmsh file (MSH 4.1, ASCII); boundaries and parts become physical groups, and `read_mesh` gives the same \
             mesh again",
        )
        .parameters(vec![path_parameter("a `.msh` file below the output folder")])
        .see_also(&["read_mesh"])
        .example("rectangle(#{ size: [2.0, 1.0], cells: [8, 4] }).write(\"plate.msh\");")
        .body(|call, handle| {
            let mesh = handle.mesh();
            Ok(write(call, None, &[".msh"], || Ok(mesh.to_gmsh().into_bytes()))?)
        })
}

/// A line of a text file, counted from 1 and shortened.
fn file_line(file: &Path, number: usize) -> Option<String> {
    let lines = BufReader::new(File::open(file).ok()?).lines();
    let line = lines.map_while(Result::ok).nth(number.checked_sub(1)?)?;
    let shown: String = line.trim().chars().take(80).collect();
    (!shown.is_empty()).then_some(shown)
}
