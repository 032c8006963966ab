//! Bodies of a model and their boundaries.

use std::sync::Arc;

use super::arguments::node_at;
use super::handle::{BodyHandle, BoundaryHandle};
use super::properties::member;
use crate::bodies::Plane;
use crate::mesh::Boundary;
use crate::script::api::examples::plate_example;
use crate::script::api::materials::MaterialHandle;
use crate::script::api::meshes::boundaries::{condition_parameters, named_boundary, with_boundary_where};
use crate::script::api::meshes::handle::MeshHandle;
use crate::script::language::prelude::*;

/// Functions of bodies.
pub fn functions() -> Vec<Function> {
    vec![
        boundary_of_body(),
        node(),
        boundary_of_mesh(),
        boundary_where(),
        member("plate", "name", "the name of the body", "String", |body: BodyHandle| body.definition().name.into()),
        member("plate", "mesh", "the mesh of the body at rest", MeshHandle::NAME, |body: BodyHandle| {
            Dynamic::from(MeshHandle::shared(body.definition().mesh))
        }),
        member("plate", "material", "the material of the body", MaterialHandle::NAME, |body: BodyHandle| {
            Dynamic::from(MaterialHandle(body.definition().material))
        }),
        member(
            "plate",
            "mass",
            "the mass of the body with those that `add_mass` adds (per thickness in the plane, of the whole circumference around an axis)",
            "number",
            |handle: BodyHandle| {
                let body = handle.definition();
                let added: f64 = handle.model.0.borrow().model.parts.iter().map(|part| part.mass_on(handle.index)).sum();
                if let Some(inertia) = body.rigid {
                    return Dynamic::from(inertia.mass + added);
                }
                let is_axisymmetric = body.formulation.plane == Plane::Axisymmetric;
                let measure = if is_axisymmetric { body.mesh.volume_of_revolution() } else { body.mesh.measure() };
                Dynamic::from(measure * body.material.density() + added)
            },
        ),
    ]
}

/// Properties of boundaries.
pub fn boundary_functions() -> Vec<Function> {
    vec![
        of_boundary("name", "the name of the boundary", "String", |boundary| boundary.boundary.name.clone().into()),
        of_boundary("facets", "the number of facets of the boundary", "int", |boundary| {
            Dynamic::from(boundary.boundary.facets.len() as i64)
        }),
        of_boundary("measure", "the length of the boundary at rest (in space: its area)", "number", |boundary| {
            Dynamic::from(boundary.mesh.boundary_measure(&boundary.boundary))
        }),
    ]
}

fn boundary_of_body() -> Function {
    method_of::<BodyHandle>(Topic::Model, "boundary")
        .summary("a boundary of the body, or several as one, for supports, loads and contact")
        .parameters(vec![Parameter::new(
            "name",
            Kind::Either("a String or an array of them"),
            "the name of the boundary, or several names",
        )])
        .see_also(&["boundary_where", "node", "fix"])
        .example(plate_example("print(plate.boundary(\"left\"));\nprint(plate.boundary([\"left\", \"top\"]));"))
        .body(|call, body| {
            let mesh = body.definition().mesh;
            let boundary = named_boundary(call, &mesh)?;
            Ok(BoundaryHandle { body: Some(body), mesh, boundary })
        })
}

fn node() -> Function {
    method_of::<BodyHandle>(Topic::Model, "node")
        .summary("the node of the body nearest to a point, as a boundary that can be held, moved or loaded with a force")
        .parameters(vec![Parameter::vector("point", "the point in the undeformed body").of("length")])
        .see_also(&["boundary", "fix", "force"])
        .example(plate_example("press.fix(plate.node([0.0, 0.0]));\npress.force(plate.node([2.0, 1.0]), [0.0, -5.0]);"))
        .body(|call, body| {
            let boundary = Boundary::of_node(node_at(&call.argument("point"), &body)?);
            let mesh = body.definition().mesh;
            Ok(BoundaryHandle { body: Some(body), mesh, boundary })
        })
}

fn boundary_of_mesh() -> Function {
    method_of::<MeshHandle>(Topic::Meshes, "boundary")
        .summary("a boundary of the mesh, for inspection; supports, loads and contact take boundaries of bodies")
        .parameters(vec![name_parameter()])
        .see_also(&["boundary_where"])
        .example("print(rectangle(#{ size: [2.0, 1.0], cells: [4, 2] }).boundary(\"left\"));")
        .body(|call, handle| {
            let mesh = handle.mesh();
            let boundary = named_boundary(call, &mesh)?;
            Ok(BoundaryHandle { body: None, mesh, boundary })
        })
}

fn boundary_where() -> Function {
    method_of::<BodyHandle>(Topic::Model, "boundary_where")
        .summary("a new boundary of the body: all facets of its hull at whose nodes a condition holds")
        .parameters(condition_parameters())
        .see_also(&["boundary"])
        .example(plate_example("press.fix(plate.boundary_where(\"foot\", |x, y| x < 0.51 && y < 0.01));"))
        .body(|call, body| {
            let mesh = Arc::new(with_boundary_where(call, &body.definition().mesh)?);
            body.model.0.borrow_mut().model.bodies[body.index].mesh = mesh.clone();
            let boundary = named_boundary(call, &mesh)?;
            Ok(BoundaryHandle { body: Some(body), mesh, boundary })
        })
}

fn of_boundary(name: &'static str, summary: &'static str, returns: &'static str, read: fn(&BoundaryHandle) -> Dynamic) -> Function {
    property_of::<BoundaryHandle>(Topic::Meshes, name)
        .summary(summary)
        .returns(returns)
        .see_also(&["boundary"])
        .example(format!("print(rectangle(#{{ size: [2.0, 1.0], cells: [4, 2] }}).boundary(\"left\").{name});"))
        .body(move |_, boundary| Ok(read(&boundary)))
}

fn name_parameter() -> Parameter {
    Parameter::text("name", "the name of the boundary")
}
