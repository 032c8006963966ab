//! Eigenstrain of bodies: shrink fits, uniform thermal expansion.

use std::sync::Arc;

use rhai::{EvalAltResult, FnPtr};

use super::change::change;
use super::handle::BodyHandle;
use crate::bodies::Plane;
use crate::dynamics::{Growth, InitialDisplacement};
use crate::script::api::examples::plate_example;
use crate::script::language::callback::Callback;
use crate::script::language::digits::number_text;
use crate::script::language::prelude::*;
use crate::script::language::values::{as_number, describe};

/// Function `grow` of scripts.
pub fn grow() -> Function {
    method_of::<BodyHandle>(Topic::Model, "grow")
        .summary(
            "makes the stress-free body larger or smaller by a factor while its nodes stay where they are, so that it starts strained: a \
             shrink fit, or warming by `1 + alpha dT`, uniform or, by a closure of position, nonuniform; its mass is kept, `settle` finds \
             the equilibrium",
        )
        .parameters(vec![
            Parameter::new(
                "factor",
                Kind::Either("a number greater than 0 or a closure `|x, y| …`"),
                "stress-free length over the present one; a closure, of z too in space, is evaluated once at the nodes of the mesh",
            )
            .of("1"),
        ])
        .see_also(&["initial_displacement", "settle"])
        .example(plate_example(
            "plate.grow(1.002);\nplate.grow(|x, y| 1.0 + 1e-3 * y);\n\
             let sim = simulate(press, #{ integrator: energy_momentum(), dt: 0.01 });\nsim.settle();",
        ))
        .body(|call, body| {
            let argument = call.argument("factor");
            if !argument.is_given() {
                return Err(argument.missing().into());
            }
            let value = argument.value();
            if let Some(function) = value.read_lock::<FnPtr>() {
                argument.check_parameters(&function, "|x, y|")?;
                return grow_by(call, &body, &Callback::new(call, function.clone()));
            }
            match as_number(&value) {
                Some(factor) if factor.is_finite() && factor > 0.0 => grow_evenly(call, &body, factor),
                Some(factor) => Err(argument.out_of_range(Interval::Positive, &number_text(factor)).into()),
                None => Err(argument.wrong_type().into()),
            }
        })
}

/// Applies a swelling factor, given by a closure at the nodes of a body, in addition to earlier swelling.
fn grow_by(call: &Call, body: &BodyHandle, closure: &Callback) -> Result<(), Box<EvalAltResult>> {
    let (mesh, model) = (body.definition().mesh, body.model.clone());
    let before = model.0.borrow().model.growth(body.index).map(<[f64]>::to_vec);
    let mut factors = before.unwrap_or_else(|| vec![1.0; mesh.points.len()]);
    for (factor, point) in factors.iter_mut().zip(&mesh.points) {
        let value = closure.call(point[..mesh.dimension()].iter().map(|&coordinate| Dynamic::from(coordinate)))?;
        let Some(number) = as_number(&value) else {
            let failure = call.argument("factor").refuse(causes::CLOSURE, "the closure must give the factor as a number");
            return Err(failure
                .label(format!("this gives {}", describe(call.engine(), &value)))
                .hint("write `|x, y| 1.0 + 1e-3 * y`")
                .into());
        };
        *factor *= number;
    }
    change(call, &model, |data| data.model.growths.push(Growth { body: body.index, factors }))
}

/// Scales the stress-free mesh of a body about its center.
fn grow_evenly(call: &Call, body: &BodyHandle, factor: f64) -> Result<(), Box<EvalAltResult>> {
    let definition = body.definition();
    let (mesh, model) = (definition.mesh.clone(), body.model.clone());
    let dimension = mesh.dimension();
    // In axial symmetry the hoop direction is scaled, too; in other plane models the thickness is not.
    let is_round = definition.formulation.plane == Plane::Axisymmetric;
    let mut center = [0.0; 3];
    mesh.points.iter().for_each(|x| (0..dimension).for_each(|i| center[i] += x[i] / mesh.points.len() as f64));
    if is_round {
        center[0] = 0.0;
    }
    let swell = factor.powi(if dimension == 3 || is_round { 3 } else { 2 });
    let present = model.0.borrow().model.initial_displacement(body.index);
    let mut grown = (*mesh).clone();
    let mut displacement = Vec::with_capacity(mesh.points.len());
    for (x, u) in grown.points.iter_mut().zip(present) {
        let before = *x;
        (0..dimension).for_each(|i| x[i] = center[i] + factor * (x[i] - center[i]));
        displacement.push([0, 1, 2].map(|i| before[i] + u[i] - x[i]));
    }
    let lighter = |of: &str| Some(if of == "mass/volume" { 1.0 / swell } else { 1.0 });
    let material = definition.material.rescaled(lighter).map_err(|error| call.fail(error))?;
    change(call, &model, |data| {
        (data.model.bodies[body.index].mesh, data.model.bodies[body.index].material) = (Arc::new(grown), material);
        data.model.initial_displacements.push(InitialDisplacement { body: body.index, displacement });
    })
}
