//! Bodies and boundaries as arguments: they must belong to the model of the call.

use std::rc::Rc;

use super::handle::{BodyHandle, BoundaryHandle, ModelHandle};
use crate::dynamics::BodyBoundary;
use crate::script::language::causes;
use crate::script::language::digits::{brief, vector_text};
use crate::script::language::prelude::*;

/// Returns the boundary in an argument, which must belong to a body of this model.
///
/// # Errors
/// Another type, a boundary of a mesh, or of another model.
pub fn boundary_of(argument: &Argument, model: &ModelHandle) -> Result<BodyBoundary, Failure> {
    body_boundary(argument, argument.handle()?, model)
}

/// Returns the boundary of a handle in an argument, which must belong to a body of this model.
///
/// # Errors
/// A boundary of a mesh, or of another model.
pub fn body_boundary(argument: &Argument, handle: BoundaryHandle, model: &ModelHandle) -> Result<BodyBoundary, Failure> {
    let Some(body) = &handle.body else {
        let failure = argument.wrong(causes::OTHER_OWNER, "must be a boundary of a body, not of a mesh");
        let failure = failure.label(format!("this is boundary \"{}\" of a mesh", handle.boundary.name));
        return Err(failure.hint(format!("take it from the body that `add_body` gave: `body.boundary(\"{}\")`", handle.boundary.name)));
    };
    check_model(argument, model, body)?;
    Ok(BodyBoundary { body: body.index, boundary: handle.boundary })
}

/// Returns the body in an argument, which must belong to this model.
///
/// # Errors
/// Another type, or a body of another model.
pub fn body_of(argument: &Argument, model: &ModelHandle) -> Result<BodyHandle, Failure> {
    let body: BodyHandle = argument.handle()?;
    check_model(argument, model, &body)?;
    Ok(body)
}

/// Returns the body in an argument, which must be deformable: forces are proportional to the mass of its cells.
///
/// # Errors
/// As [`body_of`], or a rigid body.
pub fn deformable_of(argument: &Argument, model: &ModelHandle) -> Result<BodyHandle, Failure> {
    let body = body_of(argument, model)?;
    let definition = body.definition();
    if definition.rigid.is_none() {
        return Ok(body);
    }
    let failure =
        argument.refuse(causes::BODY_KIND, format!("body \"{}\" is rigid, and its cells have no mass of their own", definition.name));
    Err(failure.hint("load a boundary of it with `force`, or damp it with `add_damper` or `add_bushing`; `gravity` is on all bodies"))
}

fn check_model(argument: &Argument, model: &ModelHandle, body: &BodyHandle) -> Result<(), Failure> {
    if Rc::ptr_eq(&body.model.0, &model.0) {
        return Ok(());
    }
    let (name, theirs) = (body.definition().name, body.model.0.borrow().model.name.clone());
    let ours = model.0.borrow().model.name.clone();
    Err(argument
        .refuse(causes::OTHER_OWNER, format!("body \"{name}\" belongs to another model"))
        .label(format!("this belongs to model \"{theirs}\""))
        .cause(format!("the call adds to model \"{ours}\""))
        .hint("add the mesh to this model too: `model.add_body(name, mesh, material)`"))
}

/// Returns the node of a body nearest to the point in an argument, at most one cell size away.
///
/// # Errors
/// No point, or a point outside the body.
pub fn node_at(argument: &Argument, body: &BodyHandle) -> Result<u32, Failure> {
    node_at_point(argument, body, argument.vector(body.definition().mesh.dimension())?)
}

/// Returns the node of a body nearest to a point in an argument.
///
/// # Errors
/// A point outside the body.
pub fn node_at_point(argument: &Argument, body: &BodyHandle, point: [f64; 3]) -> Result<u32, Failure> {
    let definition = body.definition();
    let (mesh, dimension) = (&definition.mesh, definition.mesh.dimension());
    let distance = |at: &[f64; 3]| (0..3).map(|i| (at[i] - point[i]).powi(2)).sum::<f64>().sqrt();
    let distances = mesh.points.iter().map(distance).enumerate();
    let (node, nearest) = distances.min_by(|a, b| a.1.total_cmp(&b.1)).expect("a mesh has nodes");
    let cell = (mesh.measure() / mesh.cell_count() as f64).powf(1.0 / dimension as f64);
    if nearest <= cell {
        return Ok(node as u32);
    }
    let place = vector_text(&mesh.points[node][..dimension]);
    Err(argument
        .wrong(causes::OTHER_OWNER, format!("is no point of body \"{}\"", definition.name))
        .label(format!("the nearest node is at {place}, {} away", brief(nearest)))
        .cause(format!("a cell of the body is about {} wide", brief(cell)))
        .hint("give a point of the undeformed body"))
}

/// A boundary as the first argument of a method.
pub fn boundary_parameter() -> Parameter {
    Parameter::object::<BoundaryHandle>("boundary", "a boundary of one of the model's bodies")
}
