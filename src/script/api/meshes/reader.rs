//! Meshes from files and into files; when a file is wrong, with its line or byte in the message.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use rhai::Dynamic;

use super::handle::MeshHandle;
use crate::mesh::{self, MeshError, Place};
use crate::script::api::files::writing::{path_parameter, write};
use crate::script::api::remedies::ScriptWords;
use crate::script::language::arguments::{Argument, Arguments};
use crate::script::language::failure::{Details, Failure};
use crate::script::language::function::{Form, Function, Topic, body};
use crate::script::language::handle::Handle;
use crate::script::language::parameter::{Kind, Parameter};

/// The functions of this file.
pub fn functions() -> Vec<Function> {
    vec![reader(), writer()]
}

fn reader() -> Function {
    Function {
        name: "read_mesh",
        form: Form::Function,
        topic: Topic::Meshes,
        summary: "a mesh from a Gmsh file (MSH 2.2 or 4.1, ASCII or binary), whose physical groups are parts and boundaries, or from an \
                  Abaqus or CalculiX input file (`.inp`), whose sets of elements are parts, and surfaces and sets of nodes boundaries",
        parameters: vec![Parameter::new("path", Kind::Text, "the file, below the script's folder or a folder that `--allow-read` names")],
        returns: MeshHandle::NAME,
        example: "expect_error(|| read_mesh(\"missing.msh\"), \"there is no file\");".into(),
        see_also: &["write", "part", "rectangle", "ring"],
        body: body(|call| {
            let argument = call.argument("path");
            let path = argument.text()?;
            let file = readable(&argument, &path)?;
            let mesh = mesh::read_mesh(&file).map_err(|error| read_failure(&argument, &path, &file, &error))?;
            Ok(Dynamic::from(MeshHandle::new(mesh)))
        }),
    }
}

/// The file that an argument names by a path, if the script may read it.
///
/// # Errors
/// It may not, or there is none.
pub fn readable(argument: &Argument, path: &str) -> Result<PathBuf, Failure> {
    argument.call().host.sandbox.readable(path).map_err(|failure: Failure| {
        let Details { title, code, causes, hints, .. } = &*failure;
        let failure = causes.iter().fold(argument.fail(title.clone()).code(code), |failure, cause| failure.cause(cause.clone()));
        hints.iter().fold(failure, |failure, hint| failure.hint(hint.clone()))
    })
}

/// What is wrong with a file, with its place.
pub fn read_failure(argument: &Argument, path: &str, file: &Path, error: &MeshError) -> Failure {
    let failure = argument.fail(error.to_string()).code(error.code()).label(format!("in the file \"{path}\""));
    let failure = match error.place() {
        None => failure,
        Some(Place::Byte(byte)) => failure.cause(format!("it shows at byte {byte} of the file")),
        Some(Place::Line(number)) => match file_line(file, number) {
            Some(text) => failure.cause(format!("line {number} of the file reads `{text}`")),
            None => failure.cause(format!("it shows in line {number} of the file")),
        },
    };
    failure.hint(error.remedy())
}

fn writer() -> Function {
    Function {
        name: "write",
        form: Form::Method(MeshHandle::receiver()),
        topic: Topic::Meshes,
        summary: "writes the mesh as a Gmsh file (MSH 4.1, ASCII); boundaries and parts become physical groups, and `read_mesh` gives the \
                  same mesh again",
        parameters: vec![path_parameter("a `.msh` file below the output folder")],
        returns: "",
        example: "rectangle(#{ size: [2.0, 1.0], cells: [8, 4] }).write(\"plate.msh\");".into(),
        see_also: &["read_mesh"],
        body: body(|call| {
            let mesh = call.receiver::<MeshHandle>().mesh();
            Ok(write(call, None, &[".msh"], || Ok(mesh.to_gmsh().into_bytes()))?)
        }),
    }
}

/// A line of a text file, counted from 1 and shortened.
fn file_line(file: &Path, number: usize) -> Option<String> {
    let lines = BufReader::new(File::open(file).ok()?).lines();
    let line = lines.map_while(Result::ok).nth(number.checked_sub(1)?)?;
    let shown: String = line.trim().chars().take(80).collect();
    (!shown.is_empty()).then_some(shown)
}
