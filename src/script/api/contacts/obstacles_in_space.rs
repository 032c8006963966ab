//! Rigid obstacles in space.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use super::obstacles::{Moves, direction, point, radius, shape};
use crate::contact::{Facets, FacetsError, Mending, Obstacle, ObstacleInSpace};
use crate::mesh::{MeshError, read_surface};
use crate::script::api::meshes::boundaries::boundary_named;
use crate::script::api::meshes::handle::MeshHandle;
use crate::script::api::meshes::reader::{read_failure, readable};
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::prelude::*;

/// Radius of a finite cylinder's edges relative to its radius, or to half its length if smaller.
const EDGE: f64 = 0.01;

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![rigid_sphere(), rigid_cylinder(), rigid_cone(), rigid_torus(), rigid_box(), rigid_surface()]
}

fn axis(summary: &'static str) -> Parameter {
    Parameter::vector("axis", summary).of("1")
}

fn inside(summary: &'static str) -> Parameter {
    Parameter::flag("inside", summary).or(false)
}

fn in_space(obstacle: ObstacleInSpace) -> Result<Obstacle, Failure> {
    Ok(Obstacle::InSpace(obstacle))
}

fn rigid_sphere() -> Function {
    shape(
        "rigid_sphere",
        "a rigid sphere as the other side of a contact of bodies in space",
        vec![
            point("center", "its center"),
            radius("its radius"),
            axis("the axis through its center about which it turns").otherwise("along z"),
            inside("whether bodies are inside of it, as in a bowl"),
        ],
        Moves::AboutAxis,
        "let bowl = rigid_sphere(#{ center: [0.0, 0.0, 2.0], radius: 2.0, inside: true });",
        |options| {
            let (center, radius) = (options.argument("center").vector(3)?, options.number("radius")?);
            let axis = options.argument("axis").given(direction)?.unwrap_or([0.0, 0.0, 1.0]);
            in_space(ObstacleInSpace::Sphere { center, radius, axis, is_hollow: options.flag("inside")? })
        },
    )
}

fn rigid_cylinder() -> Function {
    shape(
        "rigid_cylinder",
        "a rigid round cylinder, without ends or with flat ones, as the other side of a contact of bodies in space",
        vec![
            point("point", "a point of its axis; with a `length` its middle"),
            axis("the direction of its axis, of any length"),
            radius("its radius"),
            Parameter::number("length", "length", Interval::Positive, "how long it is between flat ends").otherwise("without ends"),
            Parameter::number("edge_radius", "length", Interval::Positive, "the radius of the edges between its side and its ends")
                .otherwise("a hundredth of `radius`, or of half the `length` where that is less"),
            inside("whether bodies are inside of it, as in a pipe"),
        ],
        Moves::AboutAxis,
        "let roller = rigid_cylinder(#{ point: [0.0, 0.0, 1.5], axis: [0.0, 1.0, 0.0], radius: 0.5, motion: #{ z: 0.1 } });",
        |options| {
            let (point, radius) = (options.argument("point").vector(3)?, options.number("radius")?);
            let (axis, is_hollow) = (direction(&options.argument("axis"))?, options.flag("inside")?);
            if options.argument("length").is_given() {
                return finite_cylinder(options, (point, axis, radius));
            }
            let edge = options.argument("edge_radius");
            if edge.is_given() {
                let failure = edge.wrong(causes::OPTIONS_TOGETHER, "has no meaning without a `length`");
                return Err(failure.label("this cylinder has no ends").hint("give its `length`, or leave this out"));
            }
            in_space(ObstacleInSpace::Cylinder { point, axis, radius, is_hollow })
        },
    )
}

/// Returns a cylinder with ends from its center, axis and radius.
fn finite_cylinder(options: &Options, (center, axis, radius): ([f64; 3], [f64; 3], f64)) -> Result<Obstacle, Failure> {
    let inside = options.argument("inside");
    if options.flag("inside")? {
        let failure = inside.refuse(causes::OPTIONS_TOGETHER, "bodies are outside of a cylinder with ends");
        return Err(failure.hint("leave out `length`, and close the pipe with a `rigid_plane` in a contact of its own"));
    }
    let (length, argument) = (options.number("length")?, options.argument("edge_radius"));
    let most = radius.min(0.5 * length);
    let edge = if argument.is_given() { options.number("edge_radius")? } else { EDGE * most };
    if edge > most {
        let failure = argument.wrong(causes::ORDER, "must be no larger than the radius and half the length");
        return Err(failure.label(format!("at most {most} fits")).hint("write a smaller one, or leave it out"));
    }
    in_space(ObstacleInSpace::FiniteCylinder { center, axis, radius, length, edge })
}

fn rigid_cone() -> Function {
    let angle = Interval::Open(0.0, FRAC_PI_2);
    shape(
        "rigid_cone",
        "a rigid round cone without an end as the other side of a contact of bodies in space",
        vec![
            point("tip", "its tip"),
            axis("the direction of its axis from the tip into the cone, of any length"),
            Parameter::number("half_angle", "rad", angle, "the angle between its axis and its side"),
            inside("whether bodies are inside of it, as in a funnel"),
        ],
        Moves::AboutAxis,
        "let funnel = rigid_cone(#{ tip: [0.0, 0.0, 0.0], axis: [0.0, 0.0, 1.0], half_angle: deg(40), inside: true });",
        |options| {
            let (tip, axis) = (options.argument("tip").vector(3)?, direction(&options.argument("axis"))?);
            let (angle, is_hollow) = (options.number("half_angle")?, options.flag("inside")?);
            in_space(ObstacleInSpace::Cone { tip, axis, angle, is_hollow })
        },
    )
}

fn rigid_torus() -> Function {
    shape(
        "rigid_torus",
        "a rigid torus, a ring of a round tube, as the other side of a contact of bodies in space",
        vec![
            point("center", "its center"),
            axis("the direction of its axis, of any length"),
            radius("the radius of the circle in the middle of the tube"),
            Parameter::number("tube_radius", "length", Interval::Positive, "the radius of the tube, smaller than that"),
            inside("whether bodies are inside of the tube"),
        ],
        Moves::AboutAxis,
        "let ring = rigid_torus(#{ center: [0.0, 0.0, 0.0], axis: [0.0, 0.0, 1.0], radius: 2.0, tube_radius: 0.5 });",
        |options| {
            let (center, axis) = (options.argument("center").vector(3)?, direction(&options.argument("axis"))?);
            let (radius, tube, is_hollow) = (options.number("radius")?, options.number("tube_radius")?, options.flag("inside")?);
            if tube >= radius {
                let argument = options.argument("tube_radius");
                let failure = argument.wrong(causes::ORDER, "must be smaller than the radius of the ring");
                return Err(failure
                    .label(format!("the ring has the radius {radius}"))
                    .hint("else the torus has no hole, and crosses itself"));
            }
            in_space(ObstacleInSpace::Torus { center, axis, radius, tube, is_hollow })
        },
    )
}

fn rigid_box() -> Function {
    shape(
        "rigid_box",
        "a rigid box as the other side of a contact of bodies in space; bodies are outside of it",
        vec![
            Parameter::vector("size", "its edges along x, y and z before it is turned").of("length"),
            point("origin", "its lowest corner before it is turned"),
            axis("the axis about which it is turned, through its middle").otherwise("along z"),
            Parameter::new("angle", Kind::Number, "the angle by which it is turned").of("rad").or(0.0),
        ],
        Moves::Box,
        "let anvil = rigid_box(#{ size: [1.0, 1.0, 0.5], origin: [-0.5, -0.5, -0.5], axis: [0.0, 0.0, 1.0], angle: deg(45) });",
        |options| {
            let (argument, origin) = (options.argument("size"), options.argument("origin").vector(3)?);
            let size = argument.vector(3)?;
            if size.iter().any(|&edge| edge <= 0.0) {
                let failure = argument.wrong(causes::OUT_OF_RANGE, "must have three numbers greater than 0");
                return Err(failure.hint("`origin` is the lowest corner"));
            }
            let high = [0, 1, 2].map(|i| origin[i] + size[i]);
            let axis = options.argument("axis").given(direction)?.unwrap_or([0.0, 0.0, 1.0]);
            let angle = options.number("angle")?;
            let middle = [0, 1, 2].map(|i| origin[i] + 0.5 * size[i]);
            faceted(Facets::cuboid(origin, high).and_then(|facets| facets.turned(middle, axis, angle)), &argument)
        },
    )
}

fn rigid_surface() -> Function {
    shape(
        "rigid_surface",
        "a rigid surface of flat facets as the other side of a contact of bodies in space: from an STL or OBJ file or a mesh; bodies are \
         on the side that its facets face. Faults of triangles with a unique repair are repaired, with a warning",
        vec![
            Parameter::text("file", "an `.stl` or `.obj` file, below the script's folder or a folder that `--allow-read` names")
                .otherwise("a mesh is given"),
            Parameter::object::<MeshHandle>("mesh", "a mesh in space").otherwise("a file is given"),
            Parameter::text("boundary", "the boundary of the mesh").otherwise("all of its hull"),
            Parameter::number("scale", "1", Interval::Positive, "factor of all lengths, such as 1e-3 for a file in millimeters").or(1.0),
            Parameter::vector("offset", "where its origin is put, after it is scaled").of("length").otherwise("the origin"),
            Parameter::flag("inside", "whether bodies are on the other side, inside of a closed surface").or(false),
        ],
        Moves::Surface,
        "let die = rigid_surface(#{ mesh: block(#{ size: [1.0, 1.0, 0.2], cells: [4, 4, 1] }), boundary: \"top\" });",
        |options| {
            let (file, mesh) = (options.argument("file"), options.argument("mesh"));
            if file.is_given() == mesh.is_given() {
                let failure = file.refuse(causes::OPTIONS_TOGETHER, "`rigid_surface` takes either a `file` or a `mesh`");
                return Err(failure.hint("write `rigid_surface(#{ file: \"die.stl\" })`"));
            }
            let argument = if file.is_given() { &file } else { &mesh };
            let (points, triangles) = if file.is_given() { of_file(&file)? } else { of_mesh(options, &mesh)? };
            let (scale, given) = (options.number("scale")?, options.argument("offset"));
            let offset = if given.is_given() { given.vector(3)? } else { [0.0; 3] };
            let points: Vec<[f64; 3]> = points.iter().map(|x| [0, 1, 2].map(|i| offset[i] + scale * x[i])).collect();
            let is_turned = options.flag("inside")?;
            let turned = |[a, b, c]: [u32; 3]| if is_turned { [a, c, b] } else { [a, b, c] };
            let triangles: Vec<[u32; 3]> = triangles.into_iter().map(turned).collect();
            let mended = Facets::mended(&points, &triangles);
            if let Ok((_, mending)) = &mended
                && *mending != Mending::default()
            {
                let call = argument.call();
                let warning = Diagnostic::warning("the surface was mended: its triangles did not fit", call.place(&Target::Argument(0)));
                let warning = warning.code("C0284").cause(mending.to_string());
                call.host.warn(warning.hint("check that its facets face the bodies; `inside: true` reverses all of them"));
            }
            faceted(mended.map(|(facets, _)| facets), argument)
        },
    )
}

type Triangles = (Vec<[f64; 3]>, Vec<[u32; 3]>);

fn of_file(argument: &Argument) -> Result<Triangles, Failure> {
    let path = argument.text()?;
    let file = readable(argument, &path)?;
    read_surface(&file).map_err(|error: MeshError| read_failure(argument, &path, &file, &error))
}

fn of_mesh(options: &Options, argument: &Argument) -> Result<Triangles, Failure> {
    let mesh = argument.handle::<MeshHandle>()?.mesh();
    if mesh.dimension() != 3 {
        let failure = argument.refuse(causes::DIMENSION, "a rigid surface needs a mesh in space");
        return Err(failure.label("this mesh is plane").hint("`extrude` makes a mesh in space of it"));
    }
    let name = options.argument("boundary");
    let facets = if name.is_given() { boundary_named(&name, &mesh)?.facets } else { mesh.hull() };
    let fan = |nodes: Vec<u32>| -> Vec<[u32; 3]> { (2..nodes.len()).map(|k| [nodes[0], nodes[k - 1], nodes[k]]).collect() };
    let triangles = facets.iter().flat_map(|&facet| fan(mesh.facet_nodes(facet).collect())).collect();
    Ok((mesh.points.clone(), triangles))
}

fn faceted(made: Result<Facets, FacetsError>, argument: &Argument) -> Result<Obstacle, Failure> {
    let hint = |error: &FacetsError| match error {
        FacetsError::Empty => "give a surface with an area",
        FacetsError::NotFinite(_) => "repair the file",
        FacetsError::Turned(_) => {
            "more than two triangles share the edge, or it is not clear which of them look the wrong way: mend the surface there where it \
             was made"
        }
    };
    let made = made.map_err(|error| argument.fail(error.to_string()).code(error.code()).hint(hint(&error)))?;
    in_space(ObstacleInSpace::Facets(Arc::new(made)))
}
