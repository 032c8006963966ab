//! Solid meshes from plane ones: extruded, revolved about an axis, or lofted between two.

use std::f64::consts::TAU;

use super::handle::{MeshHandle, made};
use crate::mesh::{Axis, Change, Prisms};
use crate::script::language::prelude::*;

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![extrude(), revolve(), loft()]
}

fn layers(summary: &'static str) -> Parameter {
    Parameter::integer("layers", summary).within(Interval::Closed(1.0, 1e6))
}

fn wedges() -> Parameter {
    let summary = "`true` for one wedge over each triangle in a layer, `false` for three tetrahedra; beside quadrilaterals always wedges";
    Parameter::flag("wedges", summary).or(false)
}

fn growth(summary: &'static str) -> Parameter {
    Parameter::number("grading", "1", Interval::Positive, summary).or(1.0)
}

/// Refuses options whose values follow from the points of a path.
fn refuse_beside_path(options: &Options) -> Result<(), Failure> {
    for name in ["height", "layers", "grading"] {
        let argument = options.argument(name);
        if argument.is_given() {
            let title = format!("{} does not go with `path`, whose points say where the layers are", argument.title());
            return Err(argument.refuse(causes::OPTIONS_TOGETHER, title).hint(format!("leave out `{name}` or `path`")));
        }
    }
    Ok(())
}

fn extrude() -> Function {
    method_of::<MeshHandle>(Topic::Meshes, "extrude")
        .summary(
            "the plane mesh drawn out as a solid one, along z or along a path: hexahedra from quadrilaterals, tetrahedra from triangles \
             (wedges beside quadrilaterals), of second order from such cells; its boundaries become sides, with `bottom` at the start and \
             `top` at the end (`bottom_`, `top_` where the plane mesh has these names). Along a path the section stands across it, its \
             origin on the path, and does not turn about it",
        )
        .parameters(vec![Parameter::options("the way and the layers")])
        .keys(vec![
            Parameter::number("height", "length", Interval::Positive, "how far it is drawn out along z").otherwise("the length of `path`"),
            layers("the number of cells along the height").otherwise("one from each point of `path` to the next"),
            growth("the ratio of the last to the first cell, along the height"),
            Parameter::array(
                "path",
                "in place of `height`, points `[x, y, z]` with a section at each; a path that ends at its first point closes",
            )
            .of("length")
            .otherwise("straight along z"),
            Parameter::number("twist", "rad", Interval::Finite, "the angle by which the section has turned at the end, about its origin")
                .or(0.0),
            Parameter::any("scale", "the ratio of the size of the section at the end to that at the start, a number or one for x and y")
                .of("1")
                .within(Interval::Positive)
                .otherwise("1"),
            wedges(),
        ])
        .see_also(&["revolve", "loft", "block", "tube", "refine"])
        .example(
            "let bar = rectangle(#{ size: [1.0, 1.0], cells: [4, 4], origin: [-0.5, -0.5] });\n\
                  let column = bar.extrude(#{ height: 4.0, layers: 16, twist: deg(90), scale: 0.5 });\n\
                  let hook = [];\n\
                  for k in 0..=12 { hook.push([2.0 * cos(deg(15) * k), 0.0, 2.0 * sin(deg(15) * k)]); }\n\
                  print(bar.extrude(#{ path: hook }));",
        )
        .body(|call, handle| {
            let mesh = handle.mesh();
            let options = call.options("options")?;
            let prisms = prisms_of(&options)?;
            let change = Change { twist: options.number("twist")?, scale: scale_of(&options)?, prisms };
            let path = options.argument("path");
            if path.is_given() {
                refuse_beside_path(&options)?;
                let points = path.points()?;
                return made(call, move || mesh.extruded_along(&points, change));
            }
            for name in ["height", "layers"] {
                let argument = options.argument(name);
                if !argument.is_given() {
                    let failure = call.refuse(causes::OPTIONS_TOGETHER, format!("`extrude` needs the option `{name}`, or a `path`"));
                    return Err(failure.hint("write `#{ height: 2.0, layers: 4 }`, or `#{ path: [[0.0, 0.0, 0.0], …] }`").into());
                }
            }
            let (height, layers, grading) = (options.number("height")?, options.integer("layers")? as usize, options.number("grading")?);
            made(call, move || mesh.extruded(height, layers, grading, change))
        })
}

/// Division of triangles into solid cells.
fn prisms_of(options: &Options) -> Result<Prisms, Failure> {
    Ok(if options.flag("wedges")? { Prisms::Kept } else { Prisms::Cut })
}

/// Scale factors of both directions, given as one number or two.
fn scale_of(options: &Options) -> Result<[f64; 2], Failure> {
    let argument = options.argument("scale");
    if !argument.is_given() {
        return Ok([1.0; 2]);
    }
    if argument.value().is_array() {
        return argument.tuple();
    }
    Ok([argument.number()?; 2])
}

fn revolve() -> Function {
    method_of::<MeshHandle>(Topic::Meshes, "revolve")
        .summary(
            "the plane mesh turned about an axis in its plane as a solid one: hexahedra from quadrilaterals, tetrahedra or wedges from \
             triangles; its boundaries become sides, with `start` and `end` (`start_`, `end_` where the plane mesh has these names) unless \
             the turn is a full one. The mesh must be on one side of the axis",
        )
        .parameters(vec![Parameter::options("turn and layers")])
        .keys(vec![
            layers("the number of cells around"),
            Parameter::number("angle", "rad", Interval::Finite, "how far it is turned, by the right-hand rule about the axis")
                .otherwise("a full turn"),
            Parameter::vector("center", "a point `[x, y]` of the axis").of("length").otherwise("[0, 0]"),
            Parameter::vector("axis", "the direction `[x, y]` of the axis").of("1").otherwise("[0, 1]"),
            growth("the ratio of the last to the first cell, around"),
            wedges(),
        ])
        .see_also(&["extrude", "torus", "tube"])
        .example(
            "let profile = rectangle(#{ size: [0.4, 1.0], cells: [2, 5], origin: [2.0, 0.0] });\n\
                  let hoop = profile.revolve(#{ layers: 48 });\n\
                  let bend = profile.revolve(#{ angle: deg(90), layers: 12 });",
        )
        .body(|call, handle| {
            let mesh = handle.mesh();
            let options = call.options("options")?;
            let (layers, grading) = (options.integer("layers")? as usize, options.number("grading")?);
            let angle = options.optional_number("angle")?.unwrap_or(TAU);
            let vector = |name, otherwise: [f64; 2]| -> Result<[f64; 2], Failure> {
                let argument = options.argument(name);
                if !argument.is_given() {
                    return Ok(otherwise);
                }
                let [x, y, _] = argument.vector(2)?;
                Ok([x, y])
            };
            let (center, along) = (vector("center", [0.0; 2])?, vector("axis", [0.0, 1.0])?);
            let prisms = prisms_of(&options)?;
            made(call, move || mesh.revolved(angle, layers, Axis { center, along }, grading, prisms))
        })
}

fn loft() -> Function {
    method_of::<MeshHandle>(Topic::Meshes, "loft")
        .summary(
            "the solid between the plane mesh and another one of the same cells above it: every node goes straight to the one of its \
             number; boundaries as of `extrude`",
        )
        .parameters(vec![
            Parameter::object::<MeshHandle>("top", "the mesh at the end, made with the same counts of cells"),
            Parameter::options("height and layers"),
        ])
        .keys(vec![
            Parameter::number("height", "length", Interval::Positive, "how far above it is, along z"),
            layers("the number of cells along the height"),
            growth("the ratio of the last to the first cell, along the height"),
            wedges(),
        ])
        .see_also(&["extrude", "map", "revolve"])
        .example(
            "let foot = rectangle(#{ size: [2.0, 2.0], cells: [4, 4], origin: [-1.0, -1.0] });\n\
                  let round = foot.map(|x, y| [x * sqrt(1.0 - 0.5 * y * y), y * sqrt(1.0 - 0.5 * x * x)]);\n\
                  print(foot.loft(round, #{ height: 3.0, layers: 6 }));",
        )
        .body(|call, handle| {
            let (mesh, top) = (handle.mesh(), call.handle::<MeshHandle>("top")?.mesh());
            let options = call.options("options")?;
            let (height, layers, grading) = (options.number("height")?, options.integer("layers")? as usize, options.number("grading")?);
            let prisms = prisms_of(&options)?;
            made(call, move || mesh.lofted(&top, height, layers, grading, prisms))
        })
}
