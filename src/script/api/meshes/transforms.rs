//! New meshes from old ones: moved, turned, scaled, mapped, refined, or a part alone.

use rhai::EvalAltResult;

use super::handle::{MeshHandle, made, mesh_value};
use crate::mesh::SelectionError;
use crate::script::api::remedies::ScriptWords;
use crate::script::language::callback::Callback;
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::digits::brief;
use crate::script::language::prelude::*;
use crate::script::language::values::{as_number, describe};

/// Angle in radians above which degrees are assumed to be meant: slightly more than a full turn.
const MOST_TURNED: f64 = 1.001 * std::f64::consts::TAU;

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![translate(), rotate(), scale(), map_function(), refine(), part(), join()]
}

fn translate() -> Function {
    method_of::<MeshHandle>(Topic::Meshes, "translate")
        .summary("the mesh moved")
        .parameters(vec![Parameter::vector("offset", "how far it is moved").of("length")])
        .see_also(&["rotate", "scale"])
        .example("let plate = rectangle(#{ size: [2.0, 1.0], cells: [8, 4] }).translate([1.0, 0.0]);")
        .body(|call, handle| {
            let mesh = handle.mesh();
            let offset = call.argument("offset").vector(mesh.dimension())?;
            mesh_value(call, (*mesh).clone().translate(offset))
        })
}

fn rotate() -> Function {
    method_of::<MeshHandle>(Topic::Meshes, "rotate")
        .summary("the mesh turned counter-clockwise about a point (in space: about the axis through it)")
        .parameters(vec![
            Parameter::number("angle", "rad", Interval::Finite, "how far it is turned; `deg(30)` converts degrees"),
            Parameter::vector("center", "the point that stays").of("length").otherwise("the origin"),
            Parameter::vector("axis", "the direction of the axis, in space").of("1").otherwise("[0, 0, 1]"),
        ])
        .see_also(&["translate", "scale", "deg"])
        .example("let plate = rectangle(#{ size: [2.0, 1.0], cells: [8, 4] }).rotate(deg(30), [1.0, 0.5]);")
        .body(|call, handle| {
            let mesh = handle.mesh();
            let (angle, dimension) = (call.number("angle")?, mesh.dimension());
            let center = call.argument("center").given(|given| given.vector(dimension))?.unwrap_or([0.0; 3]);
            if angle.abs() > MOST_TURNED {
                let title = format!("the mesh is turned by {} rad, more than once around", brief(angle));
                let warning = Diagnostic::warning(title, call.place(&Target::Argument(0))).code("C0263");
                call.host.warn(warning.hint(format!("for degrees write `deg({})`", brief(angle))));
            }
            let axis = call.argument("axis").given(|given| given.vector(3))?.unwrap_or([0.0, 0.0, 1.0]);
            mesh_value(call, (*mesh).clone().rotate_about(angle, center, axis))
        })
}

fn scale() -> Function {
    method_of::<MeshHandle>(Topic::Meshes, "scale")
        .summary("the mesh scaled about the origin")
        .parameters(vec![Parameter::any("factor", "a number, or one number for each direction").within(Interval::Positive)])
        .see_also(&["translate", "rotate"])
        .example("let plate = rectangle(#{ size: [2.0, 1.0], cells: [8, 4] }).scale([1.0, 0.5]);")
        .body(|call, handle| {
            let mesh = handle.mesh();
            let argument = call.argument("factor");
            let factors = if argument.value().is_array() {
                let factors = argument.numbers_of(mesh.dimension()).map_err(not_mirrored)?;
                [factors[0], factors[1], factors.get(2).copied().unwrap_or(1.0)]
            } else {
                [argument.number().map_err(not_mirrored)?; 3]
            };
            mesh_value(call, (*mesh).clone().scale(factors))
        })
}

fn not_mirrored(failure: Failure) -> Failure {
    failure.hint("a mirror image would have its cells inside out: draw the outline mirrored before it is meshed")
}

fn map_function() -> Function {
    method_of::<MeshHandle>(Topic::Meshes, "map")
        .summary("the mesh with every node moved to where a closure puts it: graded, bent, curved")
        .parameters(vec![Parameter::new("place", Kind::Closure("|x, y|"), "gives the new place `[x, y]` of a node (with z in space)")])
        .see_also(&["translate", "rotate", "scale"])
        .example("let hill = rectangle(#{ size: [2.0, 1.0], cells: [16, 8] }).map(|x, y| [x, y + 0.1 * y * sin(x)]);")
        .body(|call, handle| {
            let (mesh, place) = (handle.mesh(), call.callback("place")?);
            let dimension = mesh.dimension();
            let moved = (*mesh).clone().mapped(|point| vector_from(call, &place, "place", &point[..dimension]));
            match moved {
                Ok(mesh) => mesh_value(call, Ok(mesh)),
                Err(SelectionError::Condition(error)) => Err(error),
                Err(SelectionError::Mesh(error)) => {
                    let failure =
                        call.argument("place").fail(error.to_string()).code(error.code()).label("the mapped mesh cannot be computed with");
                    Err(failure.hint("a map must neither mirror nor fold the mesh: each cell keeps its sense of rotation").into())
                }
            }
        })
}

fn join() -> Function {
    method_of::<MeshHandle>(Topic::Meshes, "join")
        .summary(
            "this mesh and another one that shares a side with it as one mesh: nodes at the same place become one, boundaries of one name \
             are joined, and the common side is no boundary any more",
        )
        .parameters(vec![Parameter::object::<MeshHandle>("other", "the other mesh, its nodes on the common side at the same places")])
        .see_also(&["part", "polygon", "tie"])
        .example(
            "let base = rectangle(#{ size: [4.0, 1.0], cells: [8, 2] });\n\
                  let tooth = rectangle(#{ size: [1.0, 1.0], cells: [2, 2], origin: [1.5, 1.0] });\nprint(base.join(tooth));",
        )
        .body(|call, handle| {
            let (mesh, other) = (handle.mesh(), call.handle::<MeshHandle>("other")?.mesh());
            mesh_value(call, mesh.joined(&other))
        })
}

/// Returns the vector that a closure gives for a point, with as many components as `point`.
///
/// # Errors
/// The closure fails, or gives another value.
pub fn vector_from(call: &Call, closure: &Callback, parameter: &str, point: &[f64]) -> Result<[f64; 3], Box<EvalAltResult>> {
    let value = closure.call(point.iter().map(|&coordinate| Dynamic::from(coordinate)))?;
    let numbers: Option<Vec<f64>> = value.read_lock::<Array>().and_then(|array| array.iter().map(as_number).collect());
    match numbers {
        Some(numbers) if numbers.len() == point.len() => {
            let mut vector = [0.0; 3];
            vector[..point.len()].copy_from_slice(&numbers);
            Ok(vector)
        }
        _ => {
            let failure = call
                .argument(parameter)
                .refuse(causes::CLOSURE, format!("the closure must give the {parameter} as an array of coordinates"));
            Err(failure.label(format!("this gives {}", describe(call.engine(), &value))).hint("write `|x, y| [2.0 * x, y]`").into())
        }
    }
}

fn refine() -> Function {
    method_of::<MeshHandle>(Topic::Meshes, "refine")
        .summary("the mesh with every cell split in two along each direction; curved sides stay as straight as they are")
        .parameters(vec![Parameter::integer("times", "how often it is split").within(Interval::Closed(0.0, 12.0)).or(1)])
        .see_also(&["refine_where", "quality"])
        .example("let plate = rectangle(#{ size: [2.0, 1.0], cells: [8, 4] }).refine();")
        .body(|call, handle| {
            let (mesh, times) = (handle.mesh(), call.integer("times")?);
            made(call, move || (0..times).try_fold((*mesh).clone(), |mesh, _| mesh.refine()))
        })
}

fn part() -> Function {
    method_of::<MeshHandle>(Topic::Meshes, "part")
        .summary("a part of a mesh (a physical group of its file) as a mesh of its own")
        .parameters(vec![Parameter::text("name", "the name of the part")])
        .see_also(&["read_mesh"])
        .example("let mesh = rectangle(#{ size: [2.0, 1.0], cells: [8, 4] }); expect_error(|| mesh.part(\"left half\"), \"no part\");")
        .body(|call, handle| {
            let mesh = handle.mesh();
            let argument = call.argument("name");
            let name = argument.text()?;
            match mesh.part(&name) {
                Ok(part) => Ok(MeshHandle::new(part)),
                Err(error) => Err(argument.fail(error.to_string()).code(error.code()).hint(error.remedy()).into()),
            }
        })
}
