//! Meshes from files, with the line of the file in the message when it is wrong.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use rhai::Dynamic;

use super::handle::MeshHandle;
use crate::mesh;
use crate::script::language::arguments::Arguments;
use crate::script::language::failure::{Details, Failure};
use crate::script::language::function::{Form, Function, Topic, body};
use crate::script::language::handle::Handle;
use crate::script::language::parameter::{Kind, Parameter};

/// `read_mesh`: a mesh from a Gmsh file, with the line of the file in the message when it is wrong.
pub fn reader() -> Function {
    Function {
        name: "read_mesh",
        form: Form::Function,
        topic: Topic::Meshes,
        summary: "a mesh from a Gmsh file (MSH 2.2 or 4.1, ASCII); its physical groups are parts and boundaries",
        parameters: vec![Parameter::new("path", Kind::Text, "the file, below the script's folder or a folder that `--allow-read` names")],
        returns: MeshHandle::NAME,
        example: "expect_error(|| read_mesh(\"missing.msh\"), \"there is no file\");".into(),
        see_also: &["part", "rectangle", "ring"],
        body: body(|call| {
            let argument = call.argument("path");
            let path = argument.text()?;
            let refused = |failure: Failure| {
                let Details { title, causes, hints, .. } = &*failure;
                let failure = causes.iter().fold(argument.fail(title.clone()), |failure, cause| failure.cause(cause.clone()));
                hints.iter().fold(failure, |failure, hint| failure.hint(hint.clone()))
            };
            let file = call.host.sandbox.readable(&path).map_err(refused)?;
            match mesh::read_mesh(&file) {
                Ok(mesh) => Ok(Dynamic::from(MeshHandle::new(mesh))),
                Err(error) => {
                    let failure = argument.fail(error.to_string()).label(format!("in the file \"{path}\""));
                    let failure = match error.line().and_then(|number| file_line(&file, number).map(|text| (number, text))) {
                        Some((number, text)) => failure.cause(format!("line {number} of the file reads `{text}`")),
                        None => failure,
                    };
                    Err(failure.hint(error.cure()).into())
                }
            }
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
