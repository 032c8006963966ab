//! Meshes of round solids, from a few numbers.

use super::generators::{generator, grading, radii, ratios};
use super::handle::{made_of, point_or_origin};
use super::kinds::{SOLID, element, kind_of};
use crate::mesh::{self, Round};
use crate::script::language::prelude::*;

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![tube(), cylinder(), sphere(), hollow_sphere(), torus(), rounded_block()]
}

fn length(name: &'static str, summary: &'static str) -> Parameter {
    Parameter::number(name, "length", Interval::Positive, summary)
}

fn cells(summary: &'static str) -> Parameter {
    Parameter::counts("cells", summary)
}

fn place(name: &'static str, summary: &'static str) -> Parameter {
    Parameter::vector(name, summary).of("length").otherwise("[0, 0, 0]")
}

fn growth(summary: &'static str) -> Parameter {
    Parameter::number("grading", "1", Interval::Positive, summary).or(1.0)
}

fn tube() -> Function {
    generator("tube", "a tube along z with the boundaries `inner`, `outer`, `bottom`, `top`")
        .keys(vec![
            length("inner_radius", "the radius of the hole"),
            length("outer_radius", "the radius outside"),
            length("height", "the length along z"),
            cells("the number of cells along the radius, around and along the height"),
            place("base", "the center of its bottom"),
            grading("the ratio of the last to the first cell, along the radius outward and along the height", "[1, 1], even cells"),
            element(SOLID),
        ])
        .see_also(&["ring", "cylinder", "extrude", "rotate"])
        .example("let pipe = tube(#{ inner_radius: 1.0, outer_radius: 1.2, height: 4.0, cells: [2, 32, 16] });")
        .body_with_options(|call, options| {
            let (kind, radii, height) = (kind_of(&options)?, radii(&options)?, options.number("height")?);
            let (cells, base) = (options.argument("cells").counts()?, point_or_origin(&options, "base")?);
            let grading = ratios(&options)?;
            made_of(call, &cells, move || {
                let round = Round::About([base[0], base[1]]);
                mesh::tube(radii, height, cells, base, grading)?.with_round_cells(kind, round)
            })
        })
}

fn cylinder() -> Function {
    generator("cylinder", "a solid cylinder along z with the boundaries `outer`, `bottom`, `top`: a square core in a ring of layers")
        .keys(vec![
            length("radius", "the radius"),
            length("height", "the length along z"),
            cells("the number of layers around the core, of cells around (a multiple of 4), and of cells along the height"),
            place("base", "the center of its bottom"),
            growth("the ratio of the last to the first cell, along the height"),
            element(SOLID),
        ])
        .see_also(&["disk", "tube", "sphere", "rotate"])
        .example("let pin = cylinder(#{ radius: 0.5, height: 3.0, cells: [3, 24, 12] }).rotate(deg(90), [0.0, 0.0, 0.0], [0.0, 1.0, 0.0]);")
        .body_with_options(|call, options| {
            let (kind, radius, height) = (kind_of(&options)?, options.number("radius")?, options.number("height")?);
            let (cells, base) = (options.argument("cells").counts()?, point_or_origin(&options, "base")?);
            let grading = options.number("grading")?;
            made_of(call, &cells, move || {
                let round = Round::On([base[0], base[1]], radius);
                mesh::cylinder(radius, height, cells, base, grading)?.with_round_cells(kind, round)
            })
        })
}

fn sphere() -> Function {
    generator("sphere", "a solid sphere with the boundary `outer`: six blocks of layers round a core, without poles")
        .keys(vec![
            length("radius", "the radius"),
            cells("the number of layers around the core, and of cells around (a multiple of 4)"),
            place("center", "the center"),
            growth("the ratio of the outermost to the innermost layer"),
            element(SOLID),
        ])
        .see_also(&["hollow_sphere", "rounded_block", "cylinder"])
        .example("let ball = sphere(#{ radius: 0.5, cells: [3, 24], center: [0.0, 0.0, 0.5] });")
        .body_with_options(|call, options| {
            let (kind, radius, cells) = (kind_of(&options)?, options.number("radius")?, options.argument("cells").counts()?);
            let (center, grading) = (point_or_origin(&options, "center")?, options.number("grading")?);
            made_of(call, &cells, move || {
                mesh::sphere(radius, cells, center, grading)?.with_round_cells(kind, Round::OnBlock([center; 2], radius))
            })
        })
}

fn hollow_sphere() -> Function {
    generator("hollow_sphere", "a hollow sphere with the boundaries `inner` and `outer`: six blocks, without poles")
        .keys(vec![
            length("inner_radius", "the radius of the hollow"),
            length("outer_radius", "the radius outside"),
            cells("the number of cells along the radius, and around (a multiple of 4)"),
            place("center", "the center"),
            growth("the ratio of the outermost to the innermost cell, along the radius"),
            element(SOLID),
        ])
        .see_also(&["sphere", "tube"])
        .example("let balloon = hollow_sphere(#{ inner_radius: 0.9, outer_radius: 1.0, cells: [2, 32] });")
        .body_with_options(|call, options| {
            let (kind, radii, cells) = (kind_of(&options)?, radii(&options)?, options.argument("cells").counts()?);
            let (center, grading) = (point_or_origin(&options, "center")?, options.number("grading")?);
            made_of(call, &cells, move || {
                mesh::hollow_sphere(radii, cells, center, grading)?.with_round_cells(kind, Round::AboutPoint(center))
            })
        })
}

fn torus() -> Function {
    generator("torus", "a solid ring about the z axis with the boundary `outer`, such as an O-ring")
        .keys(vec![
            length("ring_radius", "the distance of the middle of the section from the axis"),
            length("section_radius", "the radius of the section, less than that"),
            cells("the number of layers around the core of the section, of cells around it (a multiple of 4), and of cells along the ring"),
            place("center", "the center"),
            element(SOLID),
        ])
        .see_also(&["disk", "revolve", "tube", "rotate"])
        .example("let seal = torus(#{ ring_radius: 2.0, section_radius: 0.3, cells: [2, 16, 48] });")
        .body_with_options(|call, options| {
            let (kind, ring, section) = (kind_of(&options)?, options.number("ring_radius")?, options.number("section_radius")?);
            let (cells, center) = (options.argument("cells").counts()?, point_or_origin(&options, "center")?);
            made_of(call, &cells, move || {
                mesh::torus(ring, section, cells, center)?.with_round_cells(kind, Round::Ring(center, [ring, section]))
            })
        })
}

fn rounded_block() -> Function {
    generator(
        "rounded_block",
        "a block whose edges and corners are round, with the boundaries `left`, `right`, `bottom`, `top`, `back`, `front` (its flat sides) \
         and `edges` (all that is round)",
    )
    .keys(vec![
        Parameter::vector("size", "width, height and depth").of("length").within(Interval::Positive),
        length("radius", "the radius of its edges and corners, less than half the least size"),
        cells("the number of cells along the flat part of the width, the height and the depth"),
        Parameter::integer("layers", "the number of layers below the surface").within(Interval::Closed(1.0, 1e6)),
        Parameter::integer("edge_cells", "the number of cells across an edge, even").within(Interval::Closed(2.0, 1e6)),
        place("origin", "the corner of least coordinates, which is rounded off"),
        element(SOLID),
    ])
    .see_also(&["block", "sphere"])
    .example("let die = rounded_block(#{ size: [1.0, 1.0, 1.0], radius: 0.2, cells: [4, 4, 4], layers: 2, edge_cells: 4 });")
    .body_with_options(|call, options| {
        let (kind, size, radius) = (kind_of(&options)?, options.argument("size").tuple::<3>()?, options.number("radius")?);
        let (cells, origin) = (options.argument("cells").counts()?, point_or_origin(&options, "origin")?);
        let around = [options.integer("layers")? as usize, options.integer("edge_cells")? as usize];
        made_of(call, &[&cells[..], &around].concat(), move || {
            let within = [[0, 1, 2].map(|i| origin[i] + radius), [0, 1, 2].map(|i| origin[i] + size[i] - radius)];
            let mesh = mesh::rounded_block(size, radius, cells, around, origin)?;
            mesh.with_round_cells(kind, Round::OnBlock(within, radius))
        })
    })
}
