//! Meshes in scripts: generators, the reader, transforms, boundaries.
//!
//! Transforms give a new mesh and leave the old one as it is; only `boundary_where` adds to the mesh it is called on.

use std::cell::RefCell;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::rc::Rc;

use rhai::{Array, Dynamic, EvalAltResult, Map};

use super::arguments::{Arguments, Call, as_number, describe};
use super::diagnostics::Diagnostic;
use super::failure::{Details, Failure};
use super::numbers::brief;
use super::registry::{Absent, Form, Function, Handle, Kind, Parameter, Topic, body, number_text};
use super::scan::Target;
use super::tables::table;
use crate::math::catalogue::Interval;
use crate::mesh::{Boundary, Mesh, MeshError, SelectionError, block, disk, half_disk, polygon, read_mesh, rectangle, ring};

/// A mesh in a script.
#[derive(Clone)]
pub struct MeshHandle(Rc<RefCell<Rc<Mesh>>>);

impl MeshHandle {
    /// A handle of a mesh.
    pub fn new(mesh: Mesh) -> Self {
        MeshHandle(Rc::new(RefCell::new(Rc::new(mesh))))
    }

    /// The mesh as it is now.
    pub fn mesh(&self) -> Rc<Mesh> {
        self.0.borrow().clone()
    }

    /// Counts, boundaries and parts as a table.
    pub fn table(&self) -> String {
        let mesh = self.mesh();
        let title = format!("mesh of {} {} cells and {} nodes", mesh.cell_count(), mesh.kind.name(), mesh.points.len());
        let measure = if mesh.dimension() == 2 { "length" } else { "area" };
        let boundaries = mesh
            .boundaries
            .iter()
            .map(|boundary| vec![boundary.name.clone(), boundary.facets.len().to_string(), brief(mesh.boundary_measure(boundary))]);
        let parts = mesh.parts.iter().map(|(name, cells)| vec![name.clone(), cells.len().to_string()]);
        let (boundaries, parts): (Vec<_>, Vec<_>) = (boundaries.collect(), parts.collect());
        let tables = [(vec!["boundary", "facets", measure], boundaries), (vec!["part", "cells"], parts)];
        let tables = tables.iter().filter(|(_, rows)| !rows.is_empty()).map(|(header, rows)| table(header, rows));
        std::iter::once(title).chain(tables).collect::<Vec<_>>().join("\n")
    }
}

impl Handle for MeshHandle {
    const NAME: &'static str = "Mesh";

    fn describe(&self) -> String {
        describe_mesh(&self.mesh())
    }
}

/// Kind, counts, boundaries and parts of a mesh in one line.
pub fn describe_mesh(mesh: &Mesh) -> String {
    let boundaries: Vec<String> =
        mesh.boundaries.iter().map(|boundary| format!("\"{}\" {}", boundary.name, boundary.facets.len())).collect();
    let mut text = format!("mesh of {} {} cells and {} nodes", mesh.cell_count(), mesh.kind.name(), mesh.points.len());
    if !boundaries.is_empty() {
        text = format!("{text}; boundaries (facets): {}", boundaries.join(", "));
    }
    if !mesh.parts.is_empty() {
        let parts: Vec<String> = mesh.parts.iter().map(|(name, cells)| format!("\"{name}\" {}", cells.len())).collect();
        text = format!("{text}; parts (cells): {}", parts.join(", "));
    }
    text
}

/// The failure of a mesh operation.
pub fn mesh_failure(call: &Call, error: &MeshError) -> Failure {
    call.fail(error.to_string()).hint(error.cure())
}

/// The boundary of that name in a mesh.
///
/// # Errors
/// There is none of that name; the message lists those that there are.
pub fn named_boundary(call: &Call, mesh: &Mesh) -> Result<Boundary, Failure> {
    let argument = call.argument("name");
    let name = argument.text()?;
    let names: Vec<&str> = mesh.boundaries.iter().map(|boundary| boundary.name.as_str()).collect();
    mesh.boundary(&name).cloned().ok_or_else(|| {
        let mut failure = argument.unknown_name(format!("there is no boundary \"{name}\""), &name, &names);
        if failure.hints.is_empty() {
            failure = failure.hint("`print(mesh)` lists boundaries with their facets; `mesh.boundary_where(name, |x, y| …)` makes one");
        }
        failure
    })
}

/// What `boundary_where` of a mesh and of a body take.
pub fn condition_parameters() -> Vec<Parameter> {
    let condition = "asked at the nodes of the hull (with z in space); gives `true` or `false`";
    vec![
        Parameter::new("name", Kind::Text, "the name of the new boundary"),
        Parameter::new("condition", Kind::Closure("|x, y|"), condition),
    ]
}

/// A mesh with one more boundary, found by the closure `condition` of a call. Warns when it has no facets.
///
/// # Errors
/// The name is taken, or the closure fails or does not give a truth value.
pub fn with_boundary_where(call: &Call, mesh: &Mesh) -> Result<Mesh, Box<EvalAltResult>> {
    let (name, condition) = (call.text("name")?, call.callback("condition")?);
    let dimension = mesh.dimension();
    let found = mesh.clone().boundary_where(&name, |point| {
        let value = condition.call(point[..dimension].iter().map(|&coordinate| Dynamic::from(coordinate)))?;
        value.as_bool().map_err(|_| {
            let failure = call.argument("condition").fail("the condition must give `true` or `false`");
            let given = describe(call.engine(), &value);
            Box::<EvalAltResult>::from(
                failure.label(format!("this gives {given}")).hint("compare the coordinates, such as `|x, y| y > 0.99`"),
            )
        })
    });
    let mesh = found.map_err(|error| match error {
        SelectionError::Condition(error) => error,
        SelectionError::Mesh(error) => mesh_failure(call, &error).into(),
    })?;
    if mesh.boundary(&name).is_some_and(|boundary| boundary.facets.is_empty()) {
        let target = Target::Argument(1);
        let warning = Diagnostic::warning(format!("boundary \"{name}\" has no facets"), call.place(&target))
            .label("no facet of the hull has all its nodes here")
            .hint(
                "a facet belongs to the boundary when the condition holds at all its nodes: leave room for round-off, such as `y > 0.999`",
            );
        call.host.warn(warning);
    }
    Ok(mesh)
}

fn mesh_value(call: &Call, made: Result<Mesh, MeshError>) -> Result<Dynamic, Box<EvalAltResult>> {
    made.map(|mesh| Dynamic::from(MeshHandle::new(mesh))).map_err(|error| mesh_failure(call, &error).into())
}

fn pair(counts: &[usize]) -> [usize; 2] {
    [counts[0], counts[1]]
}

fn origin(dimensions: &'static str) -> Parameter {
    Parameter::new("origin", Kind::Vector, "the corner of least coordinates").of("length").or(Absent::Means(dimensions))
}

fn element(kinds: &'static [&'static str]) -> Parameter {
    Parameter::new("element", Kind::Choice(kinds), "the kind of its cells").or(Absent::Text(kinds[0]))
}

/// Components of a vector option, or zeros.
fn vector_or_zero(options: &impl Arguments, name: &str, dimension: usize) -> Result<[f64; 3], Failure> {
    let argument = options.argument(name);
    if argument.is_given() { argument.vector(dimension) } else { Ok([0.0; 3]) }
}

/// The functions of this topic.
pub fn functions() -> Vec<Function> {
    let mut all = generators();
    all.push(reader());
    all.extend(transforms());
    all.extend(members());
    all
}

fn generators() -> Vec<Function> {
    vec![
        Function {
            name: "rectangle",
            form: Form::Function,
            topic: Topic::Meshes,
            summary: "a rectangle of quadrilaterals with the boundaries `left`, `right`, `bottom`, `top`",
            parameters: vec![Parameter::new(
                "options",
                Kind::Options(vec![
                    Parameter::new("size", Kind::Vector, "width and height").of("length").within(Interval::Positive),
                    Parameter::new("cells", Kind::Counts, "the number of cells along the width and the height"),
                    origin("[0, 0]"),
                    element(&["quad4"]),
                ]),
                "shape and cells",
            )],
            returns: MeshHandle::NAME,
            example: "let plate = rectangle(#{ size: [2.0, 1.0], cells: [8, 4] });".into(),
            see_also: &["ring", "block", "read_mesh"],
            body: body(|call| {
                let options = call.options("options")?;
                options.text("element")?;
                let (size, cells) = (options.argument("size").numbers_of(2)?, options.argument("cells").counts(2)?);
                let origin = vector_or_zero(&options, "origin", 2)?;
                mesh_value(call, rectangle([size[0], size[1]], pair(&cells), [origin[0], origin[1]]))
            }),
        },
        Function {
            name: "block",
            form: Form::Function,
            topic: Topic::Meshes,
            summary: "a block of hexahedra with the boundaries `left`, `right` (x), `bottom`, `top` (y), `back`, `front` (z)",
            parameters: vec![Parameter::new(
                "options",
                Kind::Options(vec![
                    Parameter::new("size", Kind::Vector, "width, height and depth").of("length").within(Interval::Positive),
                    Parameter::new("cells", Kind::Counts, "the number of cells along the width, the height and the depth"),
                    origin("[0, 0, 0]"),
                    element(&["hex8"]),
                ]),
                "shape and cells",
            )],
            returns: MeshHandle::NAME,
            example: "let brick = block(#{ size: [2.0, 1.0, 1.0], cells: [4, 2, 2] });".into(),
            see_also: &["rectangle"],
            body: body(|call| {
                let options = call.options("options")?;
                options.text("element")?;
                let (size, cells) = (options.argument("size").numbers_of(3)?, options.argument("cells").counts(3)?);
                let origin = vector_or_zero(&options, "origin", 3)?;
                mesh_value(call, block([size[0], size[1], size[2]], [cells[0], cells[1], cells[2]], origin))
            }),
        },
        Function {
            name: "ring",
            form: Form::Function,
            topic: Topic::Meshes,
            summary: "a closed ring of quadrilaterals with the boundaries `inner` and `outer`",
            parameters: vec![Parameter::new(
                "options",
                Kind::Options(vec![
                    Parameter::number("inner_radius", "length", Interval::Positive, "the radius of the hole"),
                    Parameter::number("outer_radius", "length", Interval::Positive, "the radius outside"),
                    Parameter::new("cells", Kind::Counts, "the number of cells along the radius and around"),
                    Parameter::new("center", Kind::Vector, "the center of both circles").of("length").or(Absent::Means("[0, 0]")),
                    Parameter::number("start_angle", "rad", Interval::Finite, "the direction of the first row of nodes")
                        .or(Absent::Number(0.0)),
                    element(&["quad4"]),
                ]),
                "shape and cells",
            )],
            returns: MeshHandle::NAME,
            example: "let tire = ring(#{ inner_radius: 1.0, outer_radius: 1.5, cells: [4, 48] });".into(),
            see_also: &["rectangle", "read_mesh"],
            body: body(|call| {
                let options = call.options("options")?;
                options.text("element")?;
                let (inner, outer) = (options.number("inner_radius")?, options.number("outer_radius")?);
                if inner >= outer {
                    let argument = options.argument("outer_radius");
                    let failure = argument.fail(format!("{} must be greater than `inner_radius`", argument.title()));
                    let failure =
                        failure.label(format!("this is {}", number_text(outer))).cause(format!("`inner_radius` is {}", number_text(inner)));
                    return Err(failure.hint("swap the two radii, or make the ring thicker").into());
                }
                let cells = options.argument("cells").counts(2)?;
                let (center, start) = (vector_or_zero(&options, "center", 2)?, options.number("start_angle")?);
                mesh_value(call, ring(inner, outer, pair(&cells), [center[0], center[1]], start))
            }),
        },
        Function {
            name: "disk",
            form: Form::Function,
            topic: Topic::Meshes,
            summary: "a disk of quadrilaterals with the boundary `outer`: a square core in a ring of layers",
            parameters: vec![Parameter::new(
                "options",
                Kind::Options(vec![
                    Parameter::number("radius", "length", Interval::Positive, "the radius"),
                    Parameter::new("cells", Kind::Counts, "the number of layers around the core, and of cells around (a multiple of 4)"),
                    Parameter::new("center", Kind::Vector, "the center").of("length").or(Absent::Means("[0, 0]")),
                    element(&["quad4"]),
                ]),
                "shape and cells",
            )],
            returns: MeshHandle::NAME,
            example: "let wheel = disk(#{ radius: 1.0, cells: [4, 32] });".into(),
            see_also: &["half_disk", "ring"],
            body: body(|call| {
                let options = call.options("options")?;
                options.text("element")?;
                let (radius, cells) = (options.number("radius")?, options.argument("cells").counts(2)?);
                let center = vector_or_zero(&options, "center", 2)?;
                mesh_value(call, disk(radius, pair(&cells), [center[0], center[1]]))
            }),
        },
        Function {
            name: "polygon",
            form: Form::Function,
            topic: Topic::Meshes,
            summary: "a polygon of unstructured quadrilaterals with the boundaries `outer` and `side 1`, `side 2`, … or the names given",
            parameters: vec![Parameter::new(
                "options",
                Kind::Options(vec![
                    Parameter::new("points", Kind::Array, "the corners `[x, y]` in their order around it, the first one once").of("length"),
                    Parameter::number("size", "length", Interval::Positive, "the length of a cell's edges, about"),
                    Parameter::new("names", Kind::Array, "a name for each side, from the first corner to the second and so on")
                        .or(Absent::Means("`side 1`, `side 2`, …")),
                    element(&["quad4"]),
                ]),
                "shape and cells",
            )],
            returns: MeshHandle::NAME,
            example: "let wedge = polygon(#{ points: [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]], size: 0.1, names: [\"floor\", \"wall\", \
                      \"slope\"] });"
                .into(),
            see_also: &["rectangle", "read_mesh", "boundary_where"],
            body: body(|call| {
                let options = call.options("options")?;
                options.text("element")?;
                let corners = options.argument("points").points()?;
                let argument = options.argument("names");
                let names: Vec<String> = if argument.is_given() {
                    let names: Option<Vec<String>> = argument.array()?.into_iter().map(|name| name.into_string().ok()).collect();
                    names.filter(|names| names.len() == corners.len()).ok_or_else(|| {
                        let failure = argument.fail(format!("{} must be a name for each of the {} sides", argument.title(), corners.len()));
                        failure
                            .label(format!("this is {}", describe(call.engine(), &argument.value())))
                            .hint("write `[\"floor\", \"wall\", …]`")
                    })?
                } else {
                    (1..=corners.len()).map(|side| format!("side {side}")).collect()
                };
                mesh_value(call, polygon(&corners, options.number("size")?, &names))
            }),
        },
        Function {
            name: "half_disk",
            form: Form::Function,
            topic: Topic::Meshes,
            summary: "the lower half of a disk of quadrilaterals with the boundaries `arc` and `flat`, finer towards its lowest point",
            parameters: vec![Parameter::new(
                "options",
                Kind::Options(vec![
                    Parameter::number("radius", "length", Interval::Positive, "the radius"),
                    Parameter::new("cells", Kind::Counts, "the number of layers around the core, and of cells around (a multiple of 4)"),
                    Parameter::new("center", Kind::Vector, "the middle of the flat side").of("length").or(Absent::Means("[0, 0]")),
                    Parameter::number(
                        "finest",
                        "length",
                        Interval::Positive,
                        "the length of the facets at the lowest point; they grow away from it in geometric progression",
                    )
                    .or(Absent::Means("even facets")),
                    element(&["quad4"]),
                ]),
                "shape and cells",
            )],
            returns: MeshHandle::NAME,
            example: "let punch = half_disk(#{ radius: 1.0, cells: [8, 48], center: [0.0, 1.0], finest: 0.01 });".into(),
            see_also: &["disk", "map"],
            body: body(|call| {
                let options = call.options("options")?;
                options.text("element")?;
                let (radius, cells) = (options.number("radius")?, options.argument("cells").counts(2)?);
                let (center, finest) = (vector_or_zero(&options, "center", 2)?, options.optional_number("finest")?);
                mesh_value(call, half_disk(radius, pair(&cells), [center[0], center[1]], finest))
            }),
        },
    ]
}

/// A mesh from a Gmsh file, with the line of the file in the message when it is wrong.
fn reader() -> Function {
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
            match read_mesh(&file) {
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

fn transforms() -> Vec<Function> {
    let receiver = MeshHandle::receiver();
    vec![
        Function {
            name: "translate",
            form: Form::Method(receiver),
            topic: Topic::Meshes,
            summary: "the mesh moved",
            parameters: vec![Parameter::new("offset", Kind::Vector, "how far it is moved").of("length")],
            returns: MeshHandle::NAME,
            example: "let plate = rectangle(#{ size: [2.0, 1.0], cells: [8, 4] }).translate([1.0, 0.0]);".into(),
            see_also: &["rotate", "scale"],
            body: body(|call| {
                let mesh = call.receiver::<MeshHandle>().mesh();
                let offset = call.argument("offset").vector(mesh.dimension())?;
                mesh_value(call, (*mesh).clone().translate(offset))
            }),
        },
        Function {
            name: "rotate",
            form: Form::Method(receiver),
            topic: Topic::Meshes,
            summary: "the mesh turned counter-clockwise about a point (in space: about the axis through it)",
            parameters: vec![
                Parameter::number("angle", "rad", Interval::Finite, "how far it is turned; `deg(30)` converts degrees"),
                Parameter::new("center", Kind::Vector, "the point that stays").of("length").or(Absent::Means("the origin")),
                Parameter::new("axis", Kind::Vector, "the direction of the axis, in space").of("1").or(Absent::Means("[0, 0, 1]")),
            ],
            returns: MeshHandle::NAME,
            example: "let plate = rectangle(#{ size: [2.0, 1.0], cells: [8, 4] }).rotate(deg(30), [1.0, 0.5]);".into(),
            see_also: &["translate", "scale", "deg"],
            body: body(|call| {
                let mesh = call.receiver::<MeshHandle>().mesh();
                let (angle, center) = (call.number("angle")?, vector_or_zero(call, "center", mesh.dimension())?);
                let axis = call.argument("axis");
                let axis = if axis.is_given() { axis.vector(3)? } else { [0.0, 0.0, 1.0] };
                mesh_value(call, (*mesh).clone().rotate_about(angle, center, axis))
            }),
        },
        Function {
            name: "scale",
            form: Form::Method(receiver),
            topic: Topic::Meshes,
            summary: "the mesh scaled about the origin",
            parameters: vec![Parameter::new("factor", Kind::Any, "a number, or one number for each direction").within(Interval::Positive)],
            returns: MeshHandle::NAME,
            example: "let plate = rectangle(#{ size: [2.0, 1.0], cells: [8, 4] }).scale([1.0, 0.5]);".into(),
            see_also: &["translate", "rotate"],
            body: body(|call| {
                let mesh = call.receiver::<MeshHandle>().mesh();
                let argument = call.argument("factor");
                let factors = if argument.value().is_array() {
                    let factors = argument.numbers_of(mesh.dimension())?;
                    [factors[0], factors[1], factors.get(2).copied().unwrap_or(1.0)]
                } else {
                    [argument.number()?; 3]
                };
                mesh_value(call, (*mesh).clone().scale(factors))
            }),
        },
        Function {
            name: "map",
            form: Form::Method(receiver),
            topic: Topic::Meshes,
            summary: "the mesh with every node moved to where a closure puts it: graded, bent, curved",
            parameters: vec![Parameter::new("place", Kind::Closure("|x, y|"), "gives the new place `[x, y]` of a node (with z in space)")],
            returns: MeshHandle::NAME,
            example: "let hill = rectangle(#{ size: [2.0, 1.0], cells: [16, 8] }).map(|x, y| [x, y + 0.1 * y * sin(x)]);".into(),
            see_also: &["translate", "rotate", "scale"],
            body: body(|call| {
                let (mesh, place) = (call.receiver::<MeshHandle>().mesh(), call.callback("place")?);
                let dimension = mesh.dimension();
                let moved = (*mesh).clone().mapped(|point| {
                    let value = place.call(point[..dimension].iter().map(|&coordinate| Dynamic::from(coordinate)))?;
                    let numbers: Option<Vec<f64>> = value.read_lock::<Array>().and_then(|array| array.iter().map(as_number).collect());
                    match numbers {
                        Some(numbers) if numbers.len() == dimension => {
                            let mut moved = [0.0; 3];
                            moved[..dimension].copy_from_slice(&numbers);
                            Ok(moved)
                        }
                        _ => {
                            let failure = call.argument("place").fail("the closure must give the new place as an array of coordinates");
                            let failure = failure.label(format!("this gives {}", describe(call.engine(), &value)));
                            Err(Box::<EvalAltResult>::from(failure.hint("write `|x, y| [2.0 * x, y]`")))
                        }
                    }
                });
                match moved {
                    Ok(mesh) => mesh_value(call, Ok(mesh)),
                    Err(SelectionError::Condition(error)) => Err(error),
                    Err(SelectionError::Mesh(error)) => {
                        let failure = call.argument("place").fail(error.to_string()).label("the mapped mesh cannot be computed with");
                        Err(failure.hint("a map must neither mirror nor fold the mesh: each cell keeps its sense of rotation").into())
                    }
                }
            }),
        },
        Function {
            name: "refine",
            form: Form::Method(receiver),
            topic: Topic::Meshes,
            summary: "the mesh with every cell split in two along each direction; curved sides stay as straight as they are",
            parameters: vec![
                Parameter::new("times", Kind::Integer, "how often it is split").within(Interval::Closed(0.0, 12.0)).or(Absent::Integer(1)),
            ],
            returns: MeshHandle::NAME,
            example: "let plate = rectangle(#{ size: [2.0, 1.0], cells: [8, 4] }).refine();".into(),
            see_also: &["quality"],
            body: body(|call| {
                let mut mesh = (*call.receiver::<MeshHandle>().mesh()).clone();
                for _ in 0..call.integer("times")? {
                    mesh = mesh.refine().map_err(|error| mesh_failure(call, &error))?;
                }
                Ok(Dynamic::from(MeshHandle::new(mesh)))
            }),
        },
        Function {
            name: "part",
            form: Form::Method(receiver),
            topic: Topic::Meshes,
            summary: "a part of a mesh (a physical group of its file) as a mesh of its own",
            parameters: vec![Parameter::new("name", Kind::Text, "the name of the part")],
            returns: MeshHandle::NAME,
            example: "let mesh = rectangle(#{ size: [2.0, 1.0], cells: [8, 4] }); expect_error(|| mesh.part(\"left half\"), \"no part\");"
                .into(),
            see_also: &["read_mesh"],
            body: body(|call| {
                let mesh = call.receiver::<MeshHandle>().mesh();
                let argument = call.argument("name");
                let name = argument.text()?;
                match mesh.part(&name) {
                    Ok(part) => Ok(Dynamic::from(MeshHandle::new(part))),
                    Err(error) => Err(argument.fail(error.to_string()).hint(error.cure()).into()),
                }
            }),
        },
        Function {
            name: "boundary_where",
            form: Form::Method(receiver),
            topic: Topic::Meshes,
            summary: "adds a boundary to the mesh: all facets of its hull at whose nodes a condition holds; gives the mesh itself",
            parameters: condition_parameters(),
            returns: MeshHandle::NAME,
            example:
                "let plate = rectangle(#{ size: [2.0, 1.0], cells: [8, 4] });\nplate.boundary_where(\"foot\", |x, y| x < 0.51 && y < 0.01);"
                    .into(),
            see_also: &["boundary"],
            body: body(|call| {
                let handle = call.receiver::<MeshHandle>();
                let mesh = with_boundary_where(call, &handle.mesh())?;
                call.host.count_effect();
                *handle.0.borrow_mut() = Rc::new(mesh);
                Ok(Dynamic::from(handle))
            }),
        },
    ]
}

fn members() -> Vec<Function> {
    let receiver = MeshHandle::receiver();
    let property = |name: &'static str, summary: &'static str, returns: &'static str, read: fn(&Mesh) -> Dynamic| Function {
        name,
        form: Form::Property(receiver),
        topic: Topic::Meshes,
        summary,
        parameters: Vec::new(),
        returns,
        example: format!("let plate = rectangle(#{{ size: [2.0, 1.0], cells: [8, 4] }}); print(plate.{name});").into(),
        see_also: &["quality"],
        body: body(move |call| Ok(read(&call.receiver::<MeshHandle>().mesh()))),
    };
    vec![
        property("nodes", "the number of nodes", "int", |mesh| Dynamic::from(mesh.points.len() as i64)),
        property("cells", "the number of cells", "int", |mesh| Dynamic::from(mesh.cell_count() as i64)),
        property("dimension", "the dimension of its space, 2 or 3", "int", |mesh| Dynamic::from(mesh.dimension() as i64)),
        property("boundaries", "the names of its boundaries", "Array", |mesh| {
            mesh.boundaries.iter().map(|boundary| Dynamic::from(boundary.name.clone())).collect::<Array>().into()
        }),
        property("parts", "the names of its parts", "Array", |mesh| {
            mesh.parts.iter().map(|(name, _)| Dynamic::from(name.clone())).collect::<Array>().into()
        }),
        Function {
            name: "quality",
            form: Form::Method(receiver),
            topic: Topic::Meshes,
            summary: "a map with `cells`, `nodes`, `measure` (area or volume), `worst` (smallest scaled Jacobian, 1 for right \
                      angles), `worst_place`, `aspect_ratio`, `shortest_edge`",
            parameters: Vec::new(),
            returns: "Map",
            example: "let plate = rectangle(#{ size: [2.0, 1.0], cells: [8, 4] }); print(plate.quality().aspect_ratio);".into(),
            see_also: &["refine"],
            body: body(|call| {
                let quality = call.receiver::<MeshHandle>().mesh().quality();
                let place: Array = quality.worst_place.iter().map(|&coordinate| Dynamic::from(coordinate)).collect();
                let entries: [(&str, Dynamic); 7] = [
                    ("cells", (quality.cells as i64).into()),
                    ("nodes", (quality.nodes as i64).into()),
                    ("measure", quality.measure.into()),
                    ("worst", quality.smallest_scaled_jacobian.into()),
                    ("worst_place", place.into()),
                    ("aspect_ratio", quality.aspect_ratio.into()),
                    ("shortest_edge", quality.shortest_edge.into()),
                ];
                Ok(entries.into_iter().map(|(name, value)| (name.into(), value)).collect::<Map>().into())
            }),
        },
    ]
}
