//! Meshes of triangles refined in places.

use rhai::{EvalAltResult, FnPtr};

use super::boundaries::{boundary_named, truth};
use super::handle::{MeshHandle, mesh_failure};
use crate::mesh::{Mesh, SelectionError};
use crate::script::language::callback::Callback;
use crate::script::language::prelude::*;

/// `refine_where` of a mesh.
pub fn refine_where() -> Function {
    method_of::<MeshHandle>(Topic::Meshes, "refine_where")
        .summary(
            "the mesh of triangles (`tri3`, `tri6`) with cells cut into four where a condition holds at their centers, or where they touch \
             a boundary; beside them cells are bisected so that no node hangs on an edge. Curved sides stay as they are, and no angle \
             falls below half the smallest, however often it is done",
        )
        .parameters(vec![
            Parameter::new(
                "where",
                Kind::Either("a closure `|x, y| …`, a boundary's name or an array of names"),
                "the condition, evaluated at the centers of the cells, or the boundary that they touch",
            ),
            Parameter::integer("times", "the number of times, each with the cells of the previous one")
                .within(Interval::Closed(0.0, 40.0))
                .or(1),
        ])
        .see_also(&["refine", "region", "with_elements", "quality"])
        .example(
            "let plate = rectangle(#{ size: [2.0, 1.0], cells: [8, 4], element: \"tri3\" });\n\
                  let fine = plate.refine_where(|x, y| hypot(x - 1.0, y - 1.0) < 0.3, 2);\nlet edge = plate.refine_where(\"top\", 3);",
        )
        .body(|call, mesh| {
            let mut mesh = (*mesh.mesh()).clone();
            let argument = call.argument("where");
            for _ in 0..call.integer("times")? {
                mesh = refined(call, &argument, &mesh)?;
            }
            Ok(MeshHandle::new(mesh))
        })
}

/// The mesh refined once.
fn refined(call: &Call, argument: &Argument, mesh: &Mesh) -> Result<Mesh, Box<EvalAltResult>> {
    let value = argument.value();
    let Some(function) = value.read_lock::<FnPtr>() else {
        if !value.is_string() && !value.is_array() {
            return Err(argument.wrong_type().into());
        }
        let boundary = boundary_named(argument, mesh)?;
        let coarse = mesh.clone();
        let refined = call.host.watched(move || coarse.refined_along(&boundary))?;
        return refined.map_err(|error| mesh_failure(call, &error).into());
    };
    argument.check_parameters(&function, "|x, y|")?;
    let closure = Callback::new(call, function.clone());
    let refined = mesh.refined_where(|center| {
        let value = closure.call(center.iter().map(|&coordinate| Dynamic::from(coordinate)))?;
        truth(argument, &value)
    });
    refined.map_err(|error| match error {
        SelectionError::Condition(error) => error,
        SelectionError::Mesh(error) => mesh_failure(call, &error).into(),
    })
}
