//! Chambers of gas that boundaries of bodies enclose.

use std::sync::Arc;

use super::arguments::body_boundary;
use super::change::change;
use super::handle::{BoundaryHandle, ModelHandle};
use crate::dynamics::{BodyBoundary, ChamberDefinition, Gas};
use crate::script::api::examples::plate_example;
use crate::script::language::prelude::*;

/// Function `add_chamber` of scripts.
pub fn add_chamber() -> Function {
    let keys = vec![
        Parameter::new("boundaries", Kind::Either("a boundary of a Body, or an array of them"), "the boundaries that face the gas"),
        Parameter::number("pressure", "stress", Interval::Positive, "absolute pressure of the gas at the volume `volume`"),
        Parameter::number("volume", "volume", Interval::Positive, "the volume (plane: area) at which it has that pressure")
            .otherwise("that which the undeformed bodies enclose"),
        Parameter::number(
            "exponent",
            "1",
            Interval::Positive,
            "`n` of `p V^n`: 1 at constant temperature, 1.4 for air without exchange of heat",
        )
        .or(1.0),
        Parameter::number(
            "ambient",
            "stress",
            Interval::NonNegative,
            "the pressure outside, which acts on the same surface from the other side",
        )
        .or(0.0),
        Parameter::vector("rim_point", "where symmetry closes the surface: a point in the planes of all its rims, which supports hold")
            .of("length")
            .otherwise("the surface is closed"),
    ];
    method_of::<ModelHandle>(Topic::Model, "add_chamber")
        .summary(
            "encloses gas by boundaries: its pressure follows the surface and the volume by `p V^n`, its energy is part of `potential`; \
             the history has its `volume`, `pressure` and `energy`",
        )
        .parameters(vec![
            Parameter::text("name", "its name, unique among springs, dampers, chambers and masses"),
            Parameter::options("surface and gas").keys(keys),
        ])
        .see_also(&["pressure", "add_spring"])
        .example(plate_example(
            "let tube = press.add_body(\"tube\", ring(#{ inner_radius: 0.5, outer_radius: 0.6, cells: [1, 24], center: [4, 4] }), steel);\n\
             press.add_chamber(\"air\", #{ boundaries: tube.boundary(\"inner\"), pressure: 20.0, exponent: 1.4, ambient: 10.0 });",
        ))
        .body(|call, model| {
            let (name, options) = (call.name("name")?, call.options("options")?);
            let argument = options.argument("boundaries");
            let surfaces = boundaries_of(&argument, &model)?;
            let gas = Gas {
                pressure: options.number("pressure")?,
                volume: options.optional_number("volume")?.unwrap_or(0.0),
                exponent: options.number("exponent")?,
                ambient: options.number("ambient")?,
            };
            let (dimension, is_round) = (model.0.borrow().model.dimension(), model.0.borrow().model.is_axisymmetric());
            let rim_point = options.argument("rim_point").given(|given| given.vector(dimension))?;
            let facets = facets_of(&argument, &model, &surfaces)?;
            change(call, &model, |data| {
                data.model.parts.push(Arc::new(ChamberDefinition { name, facets, dimension, is_round, gas, rim_point }));
            })
        })
}

/// Returns one boundary, or an array of boundaries.
fn boundaries_of(argument: &Argument, model: &ModelHandle) -> Result<Vec<BodyBoundary>, Failure> {
    if !argument.is_given() {
        return Err(argument.missing());
    }
    let value = argument.value();
    let handles: Option<Vec<BoundaryHandle>> = if value.is::<BoundaryHandle>() {
        Some(vec![argument.handle()?])
    } else {
        value.read_lock::<rhai::Array>().and_then(|array| array.iter().map(|one| one.clone().try_cast::<BoundaryHandle>()).collect())
    };
    let Some(handles) = handles else {
        return Err(argument.wrong_type().hint("write `boundaries: body.boundary(\"inner\")`, or an array of boundaries"));
    };
    handles.into_iter().map(|handle| body_boundary(argument, handle, model)).collect()
}

/// Facets of boundaries, each once, by their bodies and nodes.
fn facets_of(argument: &Argument, model: &ModelHandle, surfaces: &[BodyBoundary]) -> Result<Vec<(usize, Vec<u32>)>, Failure> {
    let (data, mut facets) = (model.0.borrow(), Vec::new());
    for on in surfaces {
        let mesh = &data.model.bodies[on.body].mesh;
        for &facet in &on.boundary.facets {
            let nodes: (usize, Vec<u32>) = (on.body, mesh.facet_nodes(facet).collect());
            if facets.contains(&nodes) {
                let failure = argument
                    .refuse(causes::EMPTY, format!("the boundaries of a chamber have facets in common, of \"{}\"", on.boundary.name));
                return Err(failure.hint("name each part of the surface once"));
            }
            facets.push(nodes);
        }
    }
    if facets.is_empty() {
        return Err(argument
            .refuse(causes::EMPTY, "the boundaries of a chamber have no facets")
            .hint("choose boundaries that have facets"));
    }
    Ok(facets)
}
