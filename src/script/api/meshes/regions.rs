//! Regions bounded by curves: lines, arcs and splines, and the function that fills the inside with cells.

use rhai::{EvalAltResult, FnPtr};

use super::handle::MeshHandle;
use super::kinds::{PLANE, element, kind_of};
use super::layers;
use crate::math::tolerances::SUM_OF_LENGTHS;
use crate::mesh::{self, CellSize, Curve, MeshError, OutlineSide, SelectionError};
use crate::script::api::remedies::ScriptWords;
use crate::script::language::callback::Callback;
use crate::script::language::digits::number_text;
use crate::script::language::prelude::*;
use crate::script::language::values::{as_number, describe};

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![region(), line_to(), arc_to(), spline_to(), circle()]
}

type Point = [f64; 2];

/// Kind of a boundary curve that starts at the end of the previous one.
#[derive(Clone)]
enum CurveKind {
    Line { to: Point },
    ArcAbout { to: Point, center: Point, is_clockwise: bool },
    ArcThrough { to: Point, through: Point },
    Spline { points: Vec<Point> },
    Circle { center: Point, radius: f64 },
}

/// A curve of an outline in a script.
#[derive(Clone)]
pub struct CurveHandle {
    kind: CurveKind,
    name: Option<String>,
}

impl Handle for CurveHandle {
    const NAME: &'static str = "Curve";
    const MAKER: &'static str = "make one with `line_to`, `arc_to`, `spline_to` or `circle`";

    fn describe(&self) -> String {
        let point = |[x, y]: &Point| format!("[{x}, {y}]");
        let kind = match &self.kind {
            CurveKind::Line { to } => format!("line to {}", point(to)),
            CurveKind::ArcAbout { to, center, .. } => format!("arc to {} about {}", point(to), point(center)),
            CurveKind::ArcThrough { to, through } => format!("arc to {} through {}", point(to), point(through)),
            CurveKind::Spline { points } => format!("spline through {} points", points.len()),
            CurveKind::Circle { center, radius } => format!("circle of radius {radius} about {}", point(center)),
        };
        self.name.iter().fold(kind, |kind, name| format!("{kind}, \"{name}\""))
    }
}

impl CurveHandle {
    /// Returns the curve from a point on; a circle has its own starting point.
    fn side(&self, from: Point) -> Result<OutlineSide, MeshError> {
        let curve = match &self.kind {
            CurveKind::Line { to } => Curve::line(from, *to),
            CurveKind::ArcAbout { to, center, is_clockwise } => Curve::arc(from, *to, *center, *is_clockwise),
            CurveKind::ArcThrough { to, through } => Curve::arc_through(from, *through, *to),
            CurveKind::Spline { points } => Curve::spline(std::iter::once(from).chain(points.iter().copied()).collect()),
            CurveKind::Circle { center, radius } => Curve::circle(*center, *radius),
        };
        Ok(OutlineSide { curve: curve?, name: self.name.clone() })
    }
}

fn region() -> Function {
    function(Topic::Meshes, "region")
        .summary(
            "unstructured cells inside an outline of lines, arcs and splines, with the boundaries `outer`, `hole 1`, … and the names of \
             curves",
        )
        .parameters(vec![Parameter::options("outline and size")])
        .keys(vec![
            Parameter::new(
                "outline",
                Kind::Either("an array that begins with a point `[x, y]`, then points and curves, or a `circle`"),
                "the start, then the curves; a point alone is a straight line to it, and a line closes an open outline",
            )
            .of("length"),
            Parameter::new(
                "size",
                Kind::Either("a number or a closure `|x, y| …`"),
                "the approximate length of a cell's edges; a closure gives it for each place",
            )
            .of("length"),
            Parameter::array("holes", "holes, each like an outline").of("length").otherwise("none"),
            layers::parameter(),
            element(PLANE),
        ])
        .see_also(&["polygon", "line_to", "arc_to", "spline_to", "circle", "refine_where", "read_mesh"])
        .example(
            "let cam = region(#{\n    outline: [\n        [0.0, -1.0],\n        arc_to(#{ to: [0.0, 1.0], center: [0.0, 0.0], name: \
                  \"base\" }),\n        spline_to([[-1.2, 0.7], [-1.8, 0.0], [-1.2, -0.7], [0.0, -1.0]], \"nose\"),\n    ],\n    holes: \
                  [circle(#{ center: [0.0, 0.0], radius: 0.3, name: \"bore\" })],\n    size: |x, y| 0.08 + 0.05 * abs(x + 0.9),\n});\n\
                  // six layers around a hole, each 1.3 times as thick as the one before it\n\
                  let plate = region(#{\n    outline: [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]],\n    \
                  holes: [circle(#{ center: [0.0, 0.0], radius: 0.3, name: \"bore\" })],\n    size: 0.15,\n    \
                  layers: #{ boundary: \"bore\", first: 0.005, count: 6, growth: 1.3, along: 0.05 },\n});",
        )
        .body_with_options(|call, options| {
            let (kind, layers) = (kind_of(&options)?, layers::layers_of(&options)?);
            let argument = options.argument("outline");
            if !argument.is_given() {
                return Err(argument.missing().into());
            }
            let outline = closed_loop(&argument, &argument.value())?;
            let argument = options.argument("holes");
            let holes = if argument.is_given() { argument.array()? } else { Array::new() };
            let holes: Vec<Vec<OutlineSide>> = holes.iter().map(|hole| closed_loop(&argument, hole)).collect::<Result<_, Failure>>()?;
            let even = as_number(&options.argument("size").value()).filter(|size| size.is_finite() && *size > 0.0);
            let made = match even {
                Some(size) => {
                    let make = move || {
                        let size = CellSize::<MeshError>::Even(size);
                        mesh::layered_region(&outline, &holes, size, kind, layers.as_ref())
                    };
                    let made = call.host.watched(make)?;
                    made.map_err(|error| layers::failure(&options, &error))?
                }
                // A closure belongs to this thread, and is called often enough to check the interrupt.
                None => with_size(&options, |size| mesh::layered_region(&outline, &holes, size, kind, layers.as_ref()))?,
            };
            Ok(MeshHandle::new(made))
        })
}

/// Error of a size function: the script's closure fails, or the mesh refuses the size.
type SizeError = SelectionError<Box<EvalAltResult>>;

/// Makes a mesh with the cell size given by an argument.
///
/// # Errors
/// Neither a number nor a closure, an error of the closure, or a refusal by the mesh generator.
fn with_size<T>(options: &Options, make: impl FnOnce(CellSize<SizeError>) -> Result<T, SizeError>) -> Result<T, Box<EvalAltResult>> {
    let argument = options.argument("size");
    if !argument.is_given() {
        return Err(argument.missing().into());
    }
    let (call, value) = (argument.call(), argument.value());
    let made = match value.read_lock::<FnPtr>() {
        Some(function) => {
            argument.check_parameters(&function, "|x, y|")?;
            let closure = Callback::new(call, function.clone());
            let mut size = |[x, y]: Point| {
                let value = closure.call([Dynamic::from(x), Dynamic::from(y)]).map_err(SelectionError::Condition)?;
                match as_number(&value) {
                    Some(size) if size.is_finite() && size > 0.0 => Ok(size),
                    _ => {
                        let failure = argument.wrong(causes::OUT_OF_RANGE, "must give a number greater than 0");
                        let given = format!("at [{x}, {y}] this gives {}", describe(call.engine(), &value));
                        let failure = failure.label(given).hint("write `|x, y| 0.05 + 0.1 * abs(x)`");
                        Err(SelectionError::Condition(failure.into()))
                    }
                }
            };
            make(CellSize::At(&mut size))
        }
        None => match as_number(&value) {
            Some(size) if size.is_finite() && size > 0.0 => make(CellSize::Even(size)),
            Some(size) => return Err(argument.out_of_range(Interval::Positive, &number_text(size)).into()),
            None => return Err(argument.wrong_type().into()),
        },
    };
    made.map_err(|error| match error {
        SelectionError::Condition(error) => error,
        SelectionError::Mesh(error) => layers::failure(options, &error).into(),
    })
}

/// The curves of an outline or a hole.
fn closed_loop(argument: &Argument, value: &Dynamic) -> Result<Vec<OutlineSide>, Failure> {
    let engine = argument.call().engine();
    let refused = |error: MeshError| argument.fail(error.to_string()).code(error.code()).hint(error.remedy());
    let is_circle = |curve: &CurveHandle| matches!(curve.kind, CurveKind::Circle { .. });
    if let Some(curve) = value.clone().try_cast::<CurveHandle>().filter(is_circle) {
        return Ok(vec![curve.side([0.0; 2]).map_err(refused)?]);
    }
    let wrong = |what: String| {
        let failure = argument.wrong(causes::WRONG_TYPE, "must begin with a point `[x, y]` and go on with points and curves");
        failure.label(what).hint("write `[[0.0, 0.0], line_to([1.0, 0.0], \"floor\"), [1.0, 1.0]]`, or a `circle` alone")
    };
    let Some(entries) = value.read_lock::<Array>() else { return Err(wrong(format!("this is {}", describe(engine, value)))) };
    let point_of = |entry: &Dynamic| -> Option<Point> {
        let numbers: Vec<f64> = entry.read_lock::<Array>()?.iter().map(as_number).collect::<Option<_>>()?;
        <Point>::try_from(numbers).ok()
    };
    let Some(start) = entries.first().and_then(point_of) else {
        return Err(wrong(entries.first().map_or("it is empty".into(), |entry| format!("it begins with {}", describe(engine, entry)))));
    };
    let mut sides: Vec<OutlineSide> = Vec::new();
    let mut first = None;
    let mut at = start;
    for entry in &entries[1..] {
        let curve = match (point_of(entry), entry.clone().try_cast::<CurveHandle>()) {
            (Some(to), _) => CurveHandle { kind: CurveKind::Line { to }, name: None },
            (None, Some(curve)) if !is_circle(&curve) => curve,
            _ => return Err(wrong(format!("it contains {}", describe(engine, entry)))),
        };
        let side = curve.side(at).map_err(refused)?;
        at = side.curve.end();
        sides.push(side);
        first.get_or_insert(curve);
    }
    let size = sides.iter().flat_map(|side| side.curve.end()).fold(0.0, |size: f64, x| size.max(x.abs()));
    let gap = (at[0] - start[0]).hypot(at[1] - start[1]);
    if let Some(first) = first.filter(|_| gap > 0.0 && gap <= SUM_OF_LENGTHS * size) {
        // closed but for round-off: a line in between would be a side of no length
        sides[0] = first.side(at).map_err(refused)?;
    } else if at != start {
        sides.push(OutlineSide { curve: Curve::line(at, start).map_err(refused)?, name: None });
    }
    Ok(sides)
}

/// Parameter for the name of a curve's boundary.
fn name_parameter() -> Parameter {
    Parameter::text("name", "the boundary that it becomes").otherwise("none of its own")
}

fn name_of(arguments: &impl Arguments) -> Result<Option<String>, Failure> {
    if arguments.argument("name").is_given() { arguments.name("name").map(Some) } else { Ok(None) }
}

fn plane_point(argument: &Argument) -> Result<Point, Failure> {
    argument.vector(2).map(|[x, y, _]| [x, y])
}

fn line_to() -> Function {
    function(Topic::Meshes, "line_to")
        .summary("a straight side of a `region`, from where the curve before it ends")
        .parameters(vec![Parameter::vector("to", "where it ends").of("length"), name_parameter()])
        .see_also(&["region", "arc_to", "spline_to"])
        .example("let floor = line_to([2.0, 0.0], \"floor\");")
        .body(|call| {
            let kind = CurveKind::Line { to: plane_point(&call.argument("to"))? };
            Ok(CurveHandle { kind, name: name_of(call)? })
        })
}

fn arc_to() -> Function {
    function(Topic::Meshes, "arc_to")
        .summary("a side of a `region` that is an arc of a circle, from where the curve before it ends: about a center, or through a point")
        .parameters(vec![Parameter::options("where it goes")])
        .keys(vec![
            Parameter::vector("to", "where it ends").of("length"),
            Parameter::vector("center", "the center, as far from the end as from the start")
                .of("length")
                .otherwise("follows from `through`"),
            Parameter::vector("through", "a point on the arc between its ends").of("length").otherwise("follows from `center`"),
            Parameter::flag("clockwise", "which way it goes about the center").or(false),
            name_parameter(),
        ])
        .see_also(&["region", "circle", "line_to", "spline_to"])
        .example(
            "let nose = arc_to(#{ to: [2.0, 2.0], center: [2.0, 1.0], name: \"nose\" });\n\
                  let arch = arc_to(#{ to: [0.0, 0.0], through: [1.0, 0.5] });",
        )
        .body_with_options(|call, options| {
            let (to, name) = (plane_point(&options.argument("to"))?, name_of(&options)?);
            let (center, through) = (options.argument("center"), options.argument("through"));
            let kind = match (center.is_given(), through.is_given()) {
                (true, false) => CurveKind::ArcAbout { to, center: plane_point(&center)?, is_clockwise: options.flag("clockwise")? },
                (false, true) => CurveKind::ArcThrough { to, through: plane_point(&through)? },
                (true, true) => {
                    let failure = through.refuse(causes::OPTIONS_TOGETHER, "an arc goes about a center or through a point, not both");
                    return Err(failure.hint("leave out `center` or `through`").into());
                }
                (false, false) => {
                    return Err(call
                        .refuse(causes::OPTIONS_TOGETHER, "an arc needs a `center` or a point `through` which it goes")
                        .hint("add one of the two")
                        .into());
                }
            };
            Ok(CurveHandle { kind, name })
        })
}

fn spline_to() -> Function {
    function(Topic::Meshes, "spline_to")
        .summary(
            "a smooth side of a `region` (a cubic spline) from where the curve before it ends through points to the last of them; one that \
             comes back to its start has no corner there",
        )
        .parameters(vec![Parameter::array("points", "the points `[x, y]` in their order").of("length"), name_parameter()])
        .see_also(&["region", "arc_to", "line_to"])
        .example("let back = spline_to([[1.5, 2.2], [0.8, 1.9], [0.0, 2.0]], \"back\");")
        .body(|call| {
            let kind = CurveKind::Spline { points: call.argument("points").points()? };
            Ok(CurveHandle { kind, name: name_of(call)? })
        })
}

fn circle() -> Function {
    function(Topic::Meshes, "circle")
        .summary("a whole circle as the outline or a hole of a `region`")
        .parameters(vec![Parameter::options("where and how large")])
        .keys(vec![
            Parameter::vector("center", "the center").of("length"),
            Parameter::number("radius", "length", Interval::Positive, "the radius"),
            name_parameter(),
        ])
        .see_also(&["region", "arc_to", "disk"])
        .example(
            "let bore = circle(#{ center: [0.2, 0.0], radius: 0.4, name: \"bore\" });\n\
                  let washer = region(#{ outline: circle(#{ center: [0.0, 0.0], radius: 1.0 }), holes: [bore], size: 0.1 });",
        )
        .body_with_options(|_, options| {
            let kind = CurveKind::Circle { center: plane_point(&options.argument("center"))?, radius: options.number("radius")? };
            Ok(CurveHandle { kind, name: name_of(&options)? })
        })
}
