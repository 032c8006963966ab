//! Named boundaries of meshes, and new ones from a condition.

use rhai::EvalAltResult;

use super::handle::{MeshHandle, mesh_failure};
use crate::mesh::{Boundary, Mesh, SelectionError};
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::prelude::*;
use crate::script::language::values::describe;

/// Returns the boundary that a call names in a mesh, or the union of several.
///
/// # Errors
/// No boundary of that name; the message lists the existing ones.
pub fn named_boundary(call: &Call, mesh: &Mesh) -> Result<Boundary, Failure> {
    boundary_named(&call.argument("name"), mesh)
}

/// Returns the boundary that an argument names, or the union of several.
///
/// # Errors
/// As [`named_boundary`].
pub fn boundary_named(argument: &Argument, mesh: &Mesh) -> Result<Boundary, Failure> {
    let value = argument.value();
    let Some(entries) = value.read_lock::<Array>() else { return one_boundary(argument, argument.text()?, mesh) };
    let mut boundaries = Vec::new();
    for entry in entries.iter() {
        let Ok(name) = entry.clone().into_string() else {
            let failure = argument.refuse(causes::WRONG_TYPE, format!("every entry of {} must be a name", argument.title()));
            return Err(failure
                .label(format!("this contains {}", describe(argument.call().engine(), entry)))
                .hint("write `[\"left\", \"top\"]`"));
        };
        boundaries.push(one_boundary(argument, name, mesh)?);
    }
    match &boundaries[..] {
        [] => Err(argument.wrong(causes::EMPTY, "is empty").hint("name at least one boundary")),
        [one] => Ok(one.clone()),
        several => Ok(Boundary::union(several)),
    }
}

fn one_boundary(argument: &Argument, name: String, mesh: &Mesh) -> Result<Boundary, Failure> {
    let names: Vec<&str> = mesh.boundaries.iter().map(|boundary| boundary.name.as_str()).collect();
    mesh.boundary(&name).cloned().ok_or_else(|| {
        let mut failure = argument.unknown_name(format!("there is no boundary \"{name}\""), &name, &names);
        if failure.hints.is_empty() {
            failure = failure.hint("`print(mesh)` lists boundaries with their facets; `mesh.boundary_where(name, |x, y| …)` makes one");
        }
        failure
    })
}

/// Parameters of `boundary_where` of meshes and bodies.
pub fn condition_parameters() -> Vec<Parameter> {
    let condition = "evaluated at the nodes of the hull (with z in space); gives `true` or `false`";
    vec![Parameter::text("name", "the name of the new boundary"), Parameter::new("condition", Kind::Closure("|x, y|"), condition)]
}

/// Returns the truth value of a condition.
///
/// # Errors
/// The value is no truth value.
pub fn truth(argument: &Argument, value: &Dynamic) -> Result<bool, Box<EvalAltResult>> {
    value.as_bool().map_err(|_| {
        let failure = argument.refuse(causes::WRONG_TYPE, "the condition must give `true` or `false`");
        let given = describe(argument.call().engine(), value);
        failure.label(format!("this gives {given}")).hint("compare the coordinates, such as `|x, y| y > 0.99`").into()
    })
}

/// Adds a boundary to a mesh by the closure `condition` of a call. Warns if the boundary has no facets.
///
/// # Errors
/// The name is taken, or the closure fails or does not give a truth value.
pub fn with_boundary_where(call: &Call, mesh: &Mesh) -> Result<Mesh, Box<EvalAltResult>> {
    let (name, condition) = (call.name("name")?, call.callback("condition")?);
    let dimension = mesh.dimension();
    let found = mesh.clone().boundary_where(&name, |point| {
        let value = condition.call(point[..dimension].iter().map(|&coordinate| Dynamic::from(coordinate)))?;
        truth(&call.argument("condition"), &value)
    });
    let mesh = found.map_err(|error| match error {
        SelectionError::Condition(error) => error,
        SelectionError::Mesh(error) => mesh_failure(call, &error).into(),
    })?;
    if mesh.boundary(&name).is_some_and(|boundary| boundary.facets.is_empty()) {
        let target = Target::Argument(1);
        let warning = Diagnostic::warning(format!("boundary \"{name}\" has no facets"), call.place(&target))
            .code("C0262")
            .label("no facet of the hull has all its nodes here")
            .hint(
                "a facet belongs to the boundary when the condition holds at all its nodes: leave room for round-off, such as `y > 0.999`",
            );
        call.host.warn(warning);
    }
    Ok(mesh)
}

/// `boundary_where` of a mesh.
pub fn boundary_where() -> Function {
    method_of::<MeshHandle>(Topic::Meshes, "boundary_where")
        .summary("adds a boundary to the mesh: all facets of its hull at whose nodes a condition holds; gives the mesh itself")
        .parameters(condition_parameters())
        .see_also(&["boundary"])
        .example(
            "let plate = rectangle(#{ size: [2.0, 1.0], cells: [8, 4] });\nplate.boundary_where(\"foot\", |x, y| x < 0.51 && y < 0.01);",
        )
        .body(|call, handle| {
            let mesh = with_boundary_where(call, &handle.mesh())?;
            call.host.count_effect();
            handle.replace(mesh);
            Ok(handle)
        })
}
