//! Chambers of gas that boundaries of bodies enclose.

use std::sync::Arc;

use rhai::Dynamic;

use super::arguments::body_boundary;
use super::change::change;
use super::handle::{BoundaryHandle, ModelHandle};
use crate::dynamics::{BodyBoundary, ChamberDefinition, Gas};
use crate::math::catalogue::Interval;
use crate::script::api::examples::plate_example;
use crate::script::language::prelude::*;

/// Function `add_chamber` of scripts.
pub fn add_chamber() -> Function {
    let keys = vec![
        Parameter::new("boundaries", Kind::Either("a boundary of a Body, or an array of them"), "the boundaries that face the gas"),
        Parameter::number("pressure", "stress", Interval::Positive, "absolute pressure of the gas at the volume `volume`"),
        Parameter::number("volume", "volume", Interval::Positive, "the volume (plane: area) at which it has that pressure")
            .or(Absent::Means("that which the undeformed bodies enclose")),
        Parameter::number(
            "exponent",
            "1",
            Interval::Positive,
            "`n` of `p V^n`: 1 at constant temperature, 1.4 for air without exchange of heat",
        )
        .or(Absent::Number(1.0)),
        Parameter::number(
            "ambient",
            "stress",
            Interval::NonNegative,
            "the pressure outside, which acts on the same surface from the other side",
        )
        .or(Absent::Number(0.0)),
        Parameter::new(
            "rim_point",
            Kind::Vector,
            "where symmetry closes the surface: a point in the planes of all its rims, which supports hold",
        )
        .of("length")
        .or(Absent::Means("the surface is closed")),
    ];
    Function {
        name: "add_chamber",
        form: Form::Method(ModelHandle::receiver()),
        topic: Topic::Model,
        summary: "encloses gas by boundaries: its pressure follows the surface and the volume by `p V^n`, its energy is part of \
                  `potential`; the history has its `volume`, `pressure` and `energy`",
        parameters: vec![
            Parameter::new("name", Kind::Text, "its name, unique among springs, dampers, chambers and masses"),
            Parameter::new("options", Kind::Options(keys), "surface and gas"),
        ],
        returns: "",
        example: plate_example(
            "let tube = press.add_body(\"tube\", ring(#{ inner_radius: 0.5, outer_radius: 0.6, cells: [1, 24], center: [4, 4] }), steel);\n\
             press.add_chamber(\"air\", #{ boundaries: tube.boundary(\"inner\"), pressure: 20.0, exponent: 1.4, ambient: 10.0 });",
        ),
        see_also: &["pressure", "add_spring"],
        body: body(|call| {
            let model = call.receiver::<ModelHandle>();
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
            let rim_point = options.argument("rim_point");
            let rim_point = if rim_point.is_given() { Some(rim_point.vector(dimension)?) } else { None };
            let facets = facets_of(&argument, &model, &surfaces)?;
            change(call, &model, |data| {
                data.model.parts.push(Arc::new(ChamberDefinition { name, facets, dimension, is_round, gas, rim_point }));
            })?;
            Ok(Dynamic::UNIT)
        }),
    }
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
                    .fail(format!("the boundaries of a chamber have facets in common, of \"{}\"", on.boundary.name))
                    .code(causes::EMPTY);
                return Err(failure.hint("name each part of the surface once"));
            }
            facets.push(nodes);
        }
    }
    if facets.is_empty() {
        return Err(argument
            .fail("the boundaries of a chamber have no facets")
            .code(causes::EMPTY)
            .hint("choose boundaries that have facets"));
    }
    Ok(facets)
}
