//! Meshes of simple shapes, from a few numbers.

use super::handle::{MeshHandle, made_of, vector_or_zero};
use super::kinds::{PLANE, SOLID, element, kind_of};
use super::layers;
use crate::mesh::{self, Round};
use crate::script::language::digits::number_text;
use crate::script::language::prelude::*;
use crate::script::language::values::describe;

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![rectangle(), block(), ring(), arc(), disk(), polygon(), half_disk()]
}

fn rectangle() -> Function {
    function(Topic::Meshes, "rectangle")
        .summary("a rectangle with the boundaries `left`, `right`, `bottom`, `top`")
        .parameters(vec![Parameter::options("shape and cells").keys(vec![
            Parameter::vector("size", "width and height").of("length").within(Interval::Positive),
            Parameter::counts("cells", "the number of cells along the width and the height"),
            origin("[0, 0]"),
            grading(
                "the ratio of the last to the first cell, along the width and the height; cells grow in geometric progression",
                "[1, 1], even cells",
            ),
            element(PLANE),
        ])])
        .returns(MeshHandle::NAME)
        .see_also(&["ring", "block", "read_mesh"])
        .example("let plate = rectangle(#{ size: [2.0, 1.0], cells: [8, 4] });")
        .body(|call| {
            let options = call.options("options")?;
            let kind = kind_of(&options)?;
            let (size, cells) = (options.argument("size").numbers_of(2)?, options.argument("cells").counts(2)?);
            let origin = vector_or_zero(&options, "origin", 2)?;
            let grading = ratios(&options, 2)?;
            let (size, origin) = ([size[0], size[1]], [origin[0], origin[1]]);
            made_of(call, &cells.clone(), move || {
                mesh::graded_rectangle(size, pair(&cells), origin, [grading[0], grading[1]])?.with_cells(kind)
            })
        })
}

fn block() -> Function {
    function(Topic::Meshes, "block")
        .summary("a block with the boundaries `left`, `right` (x), `bottom`, `top` (y), `back`, `front` (z)")
        .parameters(vec![Parameter::options("shape and cells").keys(vec![
            Parameter::vector("size", "width, height and depth").of("length").within(Interval::Positive),
            Parameter::counts("cells", "the number of cells along the width, the height and the depth"),
            origin("[0, 0, 0]"),
            grading("the ratio of the last to the first cell, along the width, the height and the depth", "[1, 1, 1], even cells"),
            element(SOLID),
        ])])
        .returns(MeshHandle::NAME)
        .see_also(&["rectangle", "rounded_block", "extrude"])
        .example("let brick = block(#{ size: [2.0, 1.0, 1.0], cells: [4, 2, 2] });")
        .body(|call| {
            let options = call.options("options")?;
            let kind = kind_of(&options)?;
            let (size, cells) = (options.argument("size").numbers_of(3)?, options.argument("cells").counts(3)?);
            let origin = vector_or_zero(&options, "origin", 3)?;
            let (size, grading) = ([size[0], size[1], size[2]], ratios(&options, 3)?);
            made_of(call, &cells.clone(), move || {
                mesh::graded_block(size, [cells[0], cells[1], cells[2]], origin, grading)?.with_cells(kind)
            })
        })
}

fn ring() -> Function {
    function(Topic::Meshes, "ring")
        .summary("a closed ring with the boundaries `inner` and `outer`")
        .parameters(vec![Parameter::options("shape and cells").keys(vec![
                Parameter::number("inner_radius", "length", Interval::Positive, "the radius of the hole"),
                Parameter::number("outer_radius", "length", Interval::Positive, "the radius outside"),
                Parameter::counts("cells", "the number of cells along the radius and around"),
                Parameter::vector("center", "the center of both circles").of("length").otherwise("[0, 0]"),
                Parameter::number("start_angle", "rad", Interval::Finite, "the direction of the first row of nodes")
                    .or(0.0),
                Parameter::number("grading", "1", Interval::Positive, "the ratio of the outermost to the innermost cell, along the radius")
                    .or(1.0),
                element(PLANE),
            ])])
        .returns(MeshHandle::NAME)
        .see_also(&["rectangle", "read_mesh"])
        .example("let tire = ring(#{ inner_radius: 1.0, outer_radius: 1.5, cells: [4, 48] });")
        .body(|call| {
            let options = call.options("options")?;
            let kind = kind_of(&options)?;
            let (inner, outer) = (options.number("inner_radius")?, options.number("outer_radius")?);
            radii_in_order(&options, inner, outer)?;
            let cells = options.argument("cells").counts(2)?;
            let (center, start) = (vector_or_zero(&options, "center", 2)?, options.number("start_angle")?);
            let (center, grading) = ([center[0], center[1]], options.number("grading")?);
            made_of(call, &cells.clone(), move || {
                mesh::graded_ring(inner, outer, pair(&cells), center, start, grading)?.with_round_cells(kind, Round::About(center))
            })
        })
}

fn arc() -> Function {
    function(Topic::Meshes, "arc")
        .summary("a sector of a ring with the boundaries `inner`, `outer`, and `start` and `end` of the arc")
        .parameters(vec![Parameter::options("shape and cells").keys(vec![
            Parameter::number("inner_radius", "length", Interval::Positive, "the radius inside"),
            Parameter::number("outer_radius", "length", Interval::Positive, "the radius outside"),
            Parameter::number("end_angle", "rad", Interval::Finite, "the direction of its end, counter-clockwise from the start"),
            Parameter::counts("cells", "the number of cells along the radius and along the arc"),
            Parameter::number("start_angle", "rad", Interval::Finite, "the direction of its start").or(0.0),
            Parameter::vector("center", "the center of both circles").of("length").otherwise("[0, 0]"),
            grading("the ratio of the last to the first cell, along the radius and along the arc", "[1, 1], even cells"),
            element(PLANE),
        ])])
        .returns(MeshHandle::NAME)
        .see_also(&["ring", "region", "deg"])
        .example("let shoe = arc(#{ inner_radius: 1.0, outer_radius: 1.3, start_angle: deg(30), end_angle: deg(150), cells: [4, 24] });")
        .body(|call| {
            let options = call.options("options")?;
            let kind = kind_of(&options)?;
            let (inner, outer) = (options.number("inner_radius")?, options.number("outer_radius")?);
            radii_in_order(&options, inner, outer)?;
            let cells = options.argument("cells").counts(2)?;
            let (angles, grading) = ([options.number("start_angle")?, options.number("end_angle")?], ratios(&options, 2)?);
            let [x, y, _] = vector_or_zero(&options, "center", 2)?;
            made_of(call, &cells.clone(), move || {
                let arc = mesh::arc([inner, outer], angles, pair(&cells), [x, y], [grading[0], grading[1]])?;
                arc.with_round_cells(kind, Round::About([x, y]))
            })
        })
}

fn disk() -> Function {
    function(Topic::Meshes, "disk")
        .summary("a disk with the boundary `outer`: a square core in a ring of layers")
        .parameters(vec![Parameter::options("shape and cells").keys(vec![
            Parameter::number("radius", "length", Interval::Positive, "the radius"),
            Parameter::counts("cells", "the number of layers around the core, and of cells around (a multiple of 4)"),
            Parameter::vector("center", "the center").of("length").otherwise("[0, 0]"),
            element(PLANE),
        ])])
        .returns(MeshHandle::NAME)
        .see_also(&["half_disk", "ring"])
        .example("let wheel = disk(#{ radius: 1.0, cells: [4, 32] });")
        .body(|call| {
            let options = call.options("options")?;
            let kind = kind_of(&options)?;
            let (radius, cells) = (options.number("radius")?, options.argument("cells").counts(2)?);
            let [x, y, _] = vector_or_zero(&options, "center", 2)?;
            made_of(call, &cells.clone(), move || {
                mesh::disk(radius, pair(&cells), [x, y])?.with_round_cells(kind, Round::On([x, y], radius))
            })
        })
}

fn polygon() -> Function {
    function(Topic::Meshes, "polygon")
        .summary("a polygon of unstructured cells with the boundaries `outer` and `side 1`, `side 2`, … or the names given")
        .parameters(vec![Parameter::options("shape and cells").keys(vec![
                Parameter::array("points", "the corners `[x, y]` in their order around it, the first one once").of("length"),
                Parameter::number("size", "length", Interval::Positive, "the approximate length of a cell's edges"),
                Parameter::array("names", "a name for each side, from the first corner to the second and so on")
                    .otherwise("`side 1`, `side 2`, …"),
                Parameter::array("holes", "holes, each an array of its corners; their boundaries are `hole 1`, `hole 2`, …")
                    .of("length")
                    .otherwise("none"),
                layers::parameter(),
                element(PLANE),
            ])])
        .returns(MeshHandle::NAME)
        .see_also(&["rectangle", "read_mesh", "boundary_where"])
        .example(
            "let wedge = polygon(#{ points: [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]], size: 0.1, names: [\"floor\", \"wall\", \"slope\"] });",
        )
        .body(|call| {
            let options = call.options("options")?;
            let kind = kind_of(&options)?;
            let corners = options.argument("points").points()?;
            let argument = options.argument("names");
            let names: Vec<String> = if argument.is_given() {
                let names: Option<Vec<String>> = argument.array()?.into_iter().map(|name| name.into_string().ok()).collect();
                names.filter(|names| names.len() == corners.len() && !names.iter().any(|name| name.contains(char::is_control))).ok_or_else(
                    || {
                        let failure = argument.wrong(causes::COUNT, format!("must be a name for each of the {} sides", corners.len()));
                        failure
                            .label(format!("this is {}", describe(call.engine(), &argument.value())))
                            .hint("write `[\"floor\", \"wall\", …]`")
                    },
                )?
            } else {
                (1..=corners.len()).map(|side| format!("side {side}")).collect()
            };
            let holes = options.argument("holes").given(|given| given.lists_of_points())?.unwrap_or_default();
            let layers = layers::layers_of(&options)?;
            let size = options.number("size")?;
            let made = call.host.watched(move || mesh::layered_polygon(kind, &corners, &holes, size, &names, layers.as_ref()))?;
            made.map(|mesh| Dynamic::from(MeshHandle::new(mesh))).map_err(|error| layers::failure(&options, &error).into())
        })
}

fn half_disk() -> Function {
    function(Topic::Meshes, "half_disk")
        .summary("the lower half of a disk with the boundaries `arc` and `flat`, finer towards its lowest point")
        .parameters(vec![Parameter::options("shape and cells").keys(vec![
                Parameter::number("radius", "length", Interval::Positive, "the radius"),
                Parameter::counts("cells", "the number of layers around the core, and of cells around (a multiple of 4)"),
                Parameter::vector("center", "the middle of the flat side").of("length").otherwise("[0, 0]"),
                Parameter::number(
                    "finest",
                    "length",
                    Interval::Positive,
                    "the length of the facets at the lowest point; they grow away from it in geometric progression",
                )
                .otherwise("even facets"),
                element(PLANE),
            ])])
        .returns(MeshHandle::NAME)
        .see_also(&["disk", "map"])
        .example("let punch = half_disk(#{ radius: 1.0, cells: [8, 48], center: [0.0, 1.0], finest: 0.01 });")
        .body(|call| {
            let options = call.options("options")?;
            let kind = kind_of(&options)?;
            let (radius, cells) = (options.number("radius")?, options.argument("cells").counts(2)?);
            let (center, finest) = (vector_or_zero(&options, "center", 2)?, options.optional_number("finest")?);
            let center = [center[0], center[1]];
            made_of(call, &cells.clone(), move || {
                mesh::half_disk(radius, pair(&cells), center, finest)?.with_round_cells(kind, Round::On(center, radius))
            })
        })
}

/// Checks that the outer radius is larger than the inner one.
pub(super) fn radii_in_order(options: &Options, inner: f64, outer: f64) -> Result<(), Failure> {
    if inner >= outer {
        let argument = options.argument("outer_radius");
        let failure = argument.wrong(causes::ORDER, "must be greater than `inner_radius`");
        let failure = failure.label(format!("this is {}", number_text(outer))).cause(format!("`inner_radius` is {}", number_text(inner)));
        return Err(failure.hint("swap the two radii, or make the wall thicker"));
    }
    Ok(())
}

pub(super) fn grading(summary: &'static str, absent: &'static str) -> Parameter {
    Parameter::array("grading", summary).of("1").within(Interval::Positive).otherwise(absent)
}

/// Returns the ratios of the option `grading`; 1 by default.
pub(super) fn ratios(options: &Options, count: usize) -> Result<[f64; 3], Failure> {
    let argument = options.argument("grading");
    let mut ratios = [1.0; 3];
    if argument.is_given() {
        ratios[..count].copy_from_slice(&argument.numbers_of(count)?);
    }
    Ok(ratios)
}

pub(super) fn pair(counts: &[usize]) -> [usize; 2] {
    [counts[0], counts[1]]
}

fn origin(dimensions: &'static str) -> Parameter {
    Parameter::vector("origin", "the corner of least coordinates").of("length").otherwise(dimensions)
}
