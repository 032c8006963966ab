//! Meshes of simple shapes, from a few numbers.

use super::handle::{MeshHandle, made_of, point_or_origin};
use super::kinds::{PLANE, SOLID, element, kind_of};
use super::layers;
use crate::mesh::{self, Round};
use crate::script::language::declaration::Described;
use crate::script::language::digits::number_text;
use crate::script::language::prelude::*;
use crate::script::language::values::describe;

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![rectangle(), block(), ring(), arc(), disk(), polygon(), half_disk()]
}

fn rectangle() -> Function {
    generator("rectangle", "a rectangle with the boundaries `left`, `right`, `bottom`, `top`")
        .keys(vec![
            Parameter::vector("size", "width and height").of("length").within(Interval::Positive),
            Parameter::counts("cells", "the number of cells along the width and the height"),
            origin("[0, 0]"),
            grading(
                "the ratio of the last to the first cell, along the width and the height; cells grow in geometric progression",
                "[1, 1], even cells",
            ),
            element(PLANE),
        ])
        .see_also(&["ring", "block", "read_mesh"])
        .example("let plate = rectangle(#{ size: [2.0, 1.0], cells: [8, 4] });")
        .body_with_options(|call, options| {
            let kind = kind_of(&options)?;
            let (size, cells) = (options.argument("size").tuple()?, options.argument("cells").counts()?);
            let (origin, grading) = (point_or_origin(&options, "origin")?, ratios(&options)?);
            made_of(call, &cells, move || mesh::graded_rectangle(size, cells, origin, grading)?.with_cells(kind))
        })
}

fn block() -> Function {
    generator("block", "a block with the boundaries `left`, `right` (x), `bottom`, `top` (y), `back`, `front` (z)")
        .keys(vec![
            Parameter::vector("size", "width, height and depth").of("length").within(Interval::Positive),
            Parameter::counts("cells", "the number of cells along the width, the height and the depth"),
            origin("[0, 0, 0]"),
            grading("the ratio of the last to the first cell, along the width, the height and the depth", "[1, 1, 1], even cells"),
            element(SOLID),
        ])
        .see_also(&["rectangle", "rounded_block", "extrude"])
        .example("let brick = block(#{ size: [2.0, 1.0, 1.0], cells: [4, 2, 2] });")
        .body_with_options(|call, options| {
            let kind = kind_of(&options)?;
            let (size, cells) = (options.argument("size").tuple()?, options.argument("cells").counts()?);
            let (origin, grading) = (point_or_origin(&options, "origin")?, ratios(&options)?);
            made_of(call, &cells, move || mesh::graded_block(size, cells, origin, grading)?.with_cells(kind))
        })
}

fn ring() -> Function {
    generator("ring", "a closed ring with the boundaries `inner` and `outer`")
        .keys(vec![
            Parameter::number("inner_radius", "length", Interval::Positive, "the radius of the hole"),
            Parameter::number("outer_radius", "length", Interval::Positive, "the radius outside"),
            Parameter::counts("cells", "the number of cells along the radius and around"),
            Parameter::vector("center", "the center of both circles").of("length").otherwise("[0, 0]"),
            Parameter::number("start_angle", "rad", Interval::Finite, "the direction of the first row of nodes").or(0.0),
            Parameter::number("grading", "1", Interval::Positive, "the ratio of the outermost to the innermost cell, along the radius")
                .or(1.0),
            element(PLANE),
        ])
        .see_also(&["rectangle", "read_mesh"])
        .example("let tire = ring(#{ inner_radius: 1.0, outer_radius: 1.5, cells: [4, 48] });")
        .body_with_options(|call, options| {
            let kind = kind_of(&options)?;
            let ([inner, outer], cells) = (radii(&options)?, options.argument("cells").counts()?);
            let (center, start) = (point_or_origin(&options, "center")?, options.number("start_angle")?);
            let grading = options.number("grading")?;
            made_of(call, &cells, move || {
                mesh::graded_ring(inner, outer, cells, center, start, grading)?.with_round_cells(kind, Round::About(center))
            })
        })
}

fn arc() -> Function {
    generator("arc", "a sector of a ring with the boundaries `inner`, `outer`, and `start` and `end` of the arc")
        .keys(vec![
            Parameter::number("inner_radius", "length", Interval::Positive, "the radius inside"),
            Parameter::number("outer_radius", "length", Interval::Positive, "the radius outside"),
            Parameter::number("end_angle", "rad", Interval::Finite, "the direction of its end, counter-clockwise from the start"),
            Parameter::counts("cells", "the number of cells along the radius and along the arc"),
            Parameter::number("start_angle", "rad", Interval::Finite, "the direction of its start").or(0.0),
            Parameter::vector("center", "the center of both circles").of("length").otherwise("[0, 0]"),
            grading("the ratio of the last to the first cell, along the radius and along the arc", "[1, 1], even cells"),
            element(PLANE),
        ])
        .see_also(&["ring", "region", "deg"])
        .example("let shoe = arc(#{ inner_radius: 1.0, outer_radius: 1.3, start_angle: deg(30), end_angle: deg(150), cells: [4, 24] });")
        .body_with_options(|call, options| {
            let kind = kind_of(&options)?;
            let (radii, cells) = (radii(&options)?, options.argument("cells").counts()?);
            let (angles, grading) = ([options.number("start_angle")?, options.number("end_angle")?], ratios(&options)?);
            let center = point_or_origin(&options, "center")?;
            made_of(call, &cells, move || mesh::arc(radii, angles, cells, center, grading)?.with_round_cells(kind, Round::About(center)))
        })
}

fn disk() -> Function {
    generator("disk", "a disk with the boundary `outer`: a square core in a ring of layers")
        .keys(vec![
            Parameter::number("radius", "length", Interval::Positive, "the radius"),
            Parameter::counts("cells", "the number of layers around the core, and of cells around (a multiple of 4)"),
            Parameter::vector("center", "the center").of("length").otherwise("[0, 0]"),
            element(PLANE),
        ])
        .see_also(&["half_disk", "ring"])
        .example("let wheel = disk(#{ radius: 1.0, cells: [4, 32] });")
        .body_with_options(|call, options| {
            let kind = kind_of(&options)?;
            let (radius, cells) = (options.number("radius")?, options.argument("cells").counts()?);
            let center = point_or_origin(&options, "center")?;
            made_of(call, &cells, move || mesh::disk(radius, cells, center)?.with_round_cells(kind, Round::On(center, radius)))
        })
}

fn polygon() -> Function {
    generator("polygon", "a polygon of unstructured cells with the boundaries `outer` and `side 1`, `side 2`, … or the names given")
        .keys(vec![
            Parameter::array("points", "the corners `[x, y]` in their order around it, the first one once").of("length"),
            Parameter::number("size", "length", Interval::Positive, "the approximate length of a cell's edges"),
            Parameter::array("names", "a name for each side, from the first corner to the second and so on")
                .otherwise("`side 1`, `side 2`, …"),
            Parameter::array("holes", "holes, each an array of its corners; their boundaries are `hole 1`, `hole 2`, …")
                .of("length")
                .otherwise("none"),
            layers::parameter(),
            element(PLANE),
        ])
        .see_also(&["rectangle", "read_mesh", "boundary_where"])
        .example(
            "let wedge = polygon(#{ points: [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]], size: 0.1, names: [\"floor\", \"wall\", \"slope\"] });",
        )
        .body_with_options(|call, options| {
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
    generator("half_disk", "the lower half of a disk with the boundaries `arc` and `flat`, finer towards its lowest point")
        .keys(vec![
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
        ])
        .see_also(&["disk", "map"])
        .example("let punch = half_disk(#{ radius: 1.0, cells: [8, 48], center: [0.0, 1.0], finest: 0.01 });")
        .body_with_options(|call, options| {
            let kind = kind_of(&options)?;
            let (radius, cells) = (options.number("radius")?, options.argument("cells").counts()?);
            let (center, finest) = (point_or_origin(&options, "center")?, options.optional_number("finest")?);
            made_of(call, &cells, move || mesh::half_disk(radius, cells, center, finest)?.with_round_cells(kind, Round::On(center, radius)))
        })
}

/// Begins the declaration of a generator function.
pub(super) fn generator(name: &'static str, summary: &'static str) -> Described<()> {
    function(Topic::Meshes, name).summary(summary).parameters(vec![Parameter::options("shape and cells")]).returns(MeshHandle::NAME)
}

/// Returns the options `inner_radius` and `outer_radius`, the latter larger.
pub(super) fn radii(options: &Options) -> Result<[f64; 2], Failure> {
    let (inner, outer) = (options.number("inner_radius")?, options.number("outer_radius")?);
    if inner >= outer {
        let argument = options.argument("outer_radius");
        let failure = argument.wrong(causes::ORDER, "must be greater than `inner_radius`");
        let failure = failure.label(format!("this is {}", number_text(outer))).cause(format!("`inner_radius` is {}", number_text(inner)));
        return Err(failure.hint("swap the two radii, or make the wall thicker"));
    }
    Ok([inner, outer])
}

pub(super) fn grading(summary: &'static str, absent: &'static str) -> Parameter {
    Parameter::array("grading", summary).of("1").within(Interval::Positive).otherwise(absent)
}

/// Returns the ratios of the option `grading`; 1 by default.
pub(super) fn ratios<const N: usize>(options: &Options) -> Result<[f64; N], Failure> {
    Ok(options.argument("grading").given(Argument::tuple)?.unwrap_or([1.0; N]))
}

fn origin(dimensions: &'static str) -> Parameter {
    Parameter::vector("origin", "the corner of least coordinates").of("length").otherwise(dimensions)
}
