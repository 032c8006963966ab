//! Meshes without names: connected components, boundaries by normal, by a seed and by distance, parts by position.

use rhai::EvalAltResult;

use super::boundaries::truth;
use super::handle::{MeshHandle, mesh_failure};
use crate::math::tolerances::ON_SHAPE;
use crate::mesh::{Facet, Mesh};
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::prelude::*;

/// Largest angle between a normal and a direction, 5 degrees.
const SAME_DIRECTION: f64 = std::f64::consts::PI / 36.0;
/// Largest angle across an edge of a side, 20 degrees.
const SAME_SIDE: f64 = std::f64::consts::PI / 9.0;

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![pieces(), part_where(), boundary_by_normal(), boundary_from(), boundary_near()]
}

fn name() -> Parameter {
    Parameter::text("name", "the name of the new boundary")
}

fn angle(default: f64, summary: &'static str) -> Parameter {
    Parameter::number("angle", "rad", Interval::Closed(0.0, std::f64::consts::PI), summary).or(default)
}

fn pieces() -> Function {
    method_of::<MeshHandle>(Topic::Meshes, "pieces")
        .summary("the connected pieces of a mesh, each a mesh of its own, in the order of their first cells")
        .see_also(&["part", "part_where", "join"])
        .example("let one = rectangle(#{ size: [2.0, 1.0], cells: [8, 4] }); expect(one.pieces().len == 1);")
        .body(|_, handle| {
            let mesh = handle.mesh();
            let pieces = mesh.connected_cells();
            Ok(pieces.iter().map(|cells| Dynamic::from(MeshHandle::new(mesh.of_cells(cells)))).collect::<Array>())
        })
}

fn part_where() -> Function {
    method_of::<MeshHandle>(Topic::Meshes, "part_where")
        .summary("adds a part to the mesh: all cells at whose centers a condition holds; gives the mesh itself")
        .parameters(vec![
            Parameter::text("name", "the name of the new part"),
            Parameter::new("condition", Kind::Closure("|x, y|"), "evaluated at the centers of the cells (with z in space)"),
        ])
        .see_also(&["part", "pieces", "boundary_where"])
        .example(
            "let plate = rectangle(#{ size: [2.0, 1.0], cells: [8, 4] });\nplate.part_where(\"left half\", |x, y| x < 1.0);\n\
                  let left = plate.part(\"left half\");",
        )
        .body(|call, handle| {
            let (name, condition) = (call.name("name")?, call.callback("condition")?);
            let mut mesh = (*handle.mesh()).clone();
            if mesh.parts.iter().any(|(known, _)| *known == name) {
                return Err(call
                    .argument("name")
                    .refuse(causes::NAME_TAKEN, format!("the mesh already has a part \"{name}\""))
                    .hint("choose another name")
                    .into());
            }
            let mut cells = Vec::new();
            for cell in 0..mesh.cell_count() {
                let value = condition.call(mesh.cell_center(cell).into_iter().map(Dynamic::from))?;
                if truth(&call.argument("condition"), &value)? {
                    cells.push(cell as u32);
                }
            }
            if cells.is_empty() {
                let failure = call.argument("condition").refuse(causes::EMPTY, format!("the part \"{name}\" would have no cells"));
                return Err(failure
                    .hint("the condition is evaluated at the centers of the cells; `print(mesh.quality())` shows the mesh")
                    .into());
            }
            mesh.parts.push((name, cells));
            call.host.count_effect();
            handle.replace(mesh);
            Ok(handle)
        })
}

/// Adds a boundary of the facets found to the mesh of a call; warns if no facet is found.
fn added(call: &Call, find: impl FnOnce(&Mesh) -> Vec<Facet>, hint: &str) -> Result<MeshHandle, Box<EvalAltResult>> {
    let handle = call.receiver::<MeshHandle>();
    let (name, mesh) = (call.name("name")?, handle.mesh());
    let facets = find(&mesh);
    if facets.is_empty() {
        let warning = Diagnostic::warning(format!("boundary \"{name}\" has no facets"), call.place(&Target::Argument(1))).code("C0295");
        call.host.warn(warning.hint(hint));
    }
    let mesh = (*mesh).clone().with_boundary(&name, facets).map_err(|error| mesh_failure(call, &error))?;
    call.host.count_effect();
    handle.replace(mesh);
    Ok(handle)
}

fn boundary_by_normal() -> Function {
    method_of::<MeshHandle>(Topic::Meshes, "boundary_by_normal")
        .summary("adds a boundary to the mesh: all facets of its hull that face a direction; gives the mesh itself")
        .parameters(vec![
            name(),
            Parameter::vector("normal", "the direction, out of the body").of("1"),
            angle(SAME_DIRECTION, "the angle from the direction up to which facets belong to it"),
        ])
        .see_also(&["boundary_from", "boundary_near", "boundary_where"])
        .example("let ball = sphere(#{ radius: 0.5, cells: [2, 16] });\nball.boundary_by_normal(\"cap\", [0.0, 0.0, 1.0], deg(60));")
        .body(|call, mesh| {
            let argument = call.argument("normal");
            let (normal, angle) = (argument.vector(mesh.mesh().dimension())?, call.number("angle")?);
            if normal == [0.0; 3] {
                return Err(argument
                    .refuse(causes::NO_DIRECTION, "a normal needs a length")
                    .hint("write `[0.0, 1.0]` for the direction of y")
                    .into());
            }
            added(call, |mesh| mesh.facets_by_normal(normal, angle), "normals point out of the body; allow a larger `angle`")
        })
}

fn boundary_from() -> Function {
    method_of::<MeshHandle>(Topic::Meshes, "boundary_from")
        .summary(
            "adds a boundary to the mesh: the smooth side around the facet of the hull that is nearest to a point, up to sharp edges; \
             gives the mesh itself",
        )
        .parameters(vec![
            name(),
            Parameter::vector("point", "a place on the side or near it").of("length"),
            angle(SAME_SIDE, "the largest angle between neighboring facets of the side"),
        ])
        .see_also(&["boundary_by_normal", "boundary_near", "boundary_where"])
        .example(
            "let rod = cylinder(#{ radius: 0.5, height: 2.0, cells: [2, 32, 4], element: \"tet4\" });\n\
                  rod.boundary_from(\"round\", [0.5, 0.0, 1.0]);",
        )
        .body(|call, mesh| {
            let point = call.argument("point").vector(mesh.mesh().dimension())?;
            let angle = call.number("angle")?;
            added(call, |mesh| mesh.facets_from(point, angle), "the mesh has no hull")
        })
}

fn boundary_near() -> Function {
    let shape = vec![
        Parameter::vector("point", "a point of a plane (in the plane: of a line)").of("length").otherwise("no plane"),
        Parameter::vector("normal", "the normal of the plane").of("1").otherwise("no plane"),
        Parameter::vector("center", "the center of a sphere or circle, or a point of the axis of a cylinder")
            .of("length")
            .otherwise("no sphere or cylinder"),
        Parameter::number("radius", "length", Interval::Positive, "the radius of the sphere, circle or cylinder")
            .otherwise("no sphere or cylinder"),
        Parameter::vector("axis", "the direction of the axis of a cylinder").of("1").otherwise("a sphere"),
        Parameter::number("within", "length", Interval::Positive, "the distance up to which nodes are on it")
            .otherwise("1e-6 of the size of the mesh"),
    ];
    method_of::<MeshHandle>(Topic::Meshes, "boundary_near")
        .summary(
            "adds a boundary to the mesh: all facets of its hull whose nodes are on a plane (`point`, `normal`), a sphere or circle \
             (`center`, `radius`) or a cylinder (with `axis`); gives the mesh itself",
        )
        .parameters(vec![name(), Parameter::map("shape", "the plane, sphere or cylinder").keys(shape)])
        .see_also(&["boundary_by_normal", "boundary_from", "boundary_where"])
        .example(
            "let pipe = tube(#{ inner_radius: 0.5, outer_radius: 1.0, height: 1.0, cells: [2, 16, 2] });\n\
                  pipe.boundary_near(\"bore\", #{ center: [0.0, 0.0, 0.0], axis: [0.0, 0.0, 1.0], radius: 0.5, within: 0.01 });",
        )
        .body(|call, handle| {
            let (mesh, options) = (handle.mesh(), call.options("shape")?);
            let shape = Shape::of(&options, mesh.dimension())?;
            let size = mesh.points.as_flattened().iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let within = if options.argument("within").is_given() { options.number("within")? } else { ON_SHAPE * size };
            let is_on = |point: [f64; 3]| Ok::<_, std::convert::Infallible>(shape.distance(point) <= within);
            added(
                call,
                |mesh| match mesh.facets_where(is_on) {
                    Ok(facets) => facets,
                    Err(never) => match never {},
                },
                "all nodes of a facet must be on it: allow more with `within`",
            )
        })
}

/// Surface for the selection of nodes by distance.
enum Shape {
    Plane { point: [f64; 3], normal: [f64; 3] },
    Sphere { center: [f64; 3], radius: f64 },
    Cylinder { center: [f64; 3], axis: [f64; 3], radius: f64 },
}

impl Shape {
    fn of(options: &Options, dimension: usize) -> Result<Shape, Failure> {
        let is_given = |name: &str| options.argument(name).is_given();
        let unit = |name: &str, dimension: usize| {
            let argument = options.argument(name);
            let vector = argument.vector(dimension)?;
            let length = vector[0].hypot(vector[1]).hypot(vector[2]);
            if length > 0.0 {
                Ok(vector.map(|x| x / length))
            } else {
                Err(argument.refuse(causes::NO_DIRECTION, format!("`{name}` needs a length")))
            }
        };
        match (is_given("point") && is_given("normal"), is_given("center") && is_given("radius")) {
            (true, false) => Ok(Shape::Plane { point: options.argument("point").vector(dimension)?, normal: unit("normal", dimension)? }),
            (false, true) => {
                let (center, radius) = (options.argument("center").vector(dimension)?, options.number("radius")?);
                if is_given("axis") {
                    Ok(Shape::Cylinder { center, axis: unit("axis", 3)?, radius })
                } else {
                    Ok(Shape::Sphere { center, radius })
                }
            }
            _ => {
                let failure = options
                    .argument("point")
                    .refuse(causes::OPTIONS_TOGETHER, "`boundary_near` takes either a plane, or a sphere or cylinder");
                Err(failure.hint("write `#{ point: [0.0, 0.0], normal: [0.0, 1.0] }` or `#{ center: [0.0, 0.0], radius: 1.0 }`"))
            }
        }
    }

    /// Distance of a point from the surface `[length]`.
    fn distance(&self, x: [f64; 3]) -> f64 {
        let from = |center: &[f64; 3]| [0, 1, 2].map(|i| x[i] - center[i]);
        let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let length = |a: [f64; 3]| a[0].hypot(a[1]).hypot(a[2]);
        match self {
            Shape::Plane { point, normal } => dot(&from(point), normal).abs(),
            Shape::Sphere { center, radius } => (length(from(center)) - radius).abs(),
            Shape::Cylinder { center, axis, radius } => {
                let arm = from(center);
                let along = dot(&arm, axis);
                (length([0, 1, 2].map(|i| arm[i] - along * axis[i])) - radius).abs()
            }
        }
    }
}
