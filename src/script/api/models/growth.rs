//! Bodies that are larger or smaller without stress than where they are: shrink fits, uniform warming.

use std::sync::Arc;

use rhai::Dynamic;

use super::change::change;
use super::handle::BodyHandle;
use crate::bodies::Plane;
use crate::dynamics::InitialDisplacement;
use crate::math::catalogue::Interval;
use crate::script::api::examples::plate_example;
use crate::script::language::arguments::Arguments;
use crate::script::language::function::{Form, Function, Topic, body};
use crate::script::language::handle::Handle;
use crate::script::language::parameter::Parameter;

/// `grow`.
pub fn grow() -> Function {
    Function {
        name: "grow",
        form: Form::Method(BodyHandle::receiver()),
        topic: Topic::Model,
        summary: "makes the stress-free body larger or smaller by a factor while its nodes stay where they are, so that it starts \
                  strained: a shrink fit, or warming by `1 + alpha dT`; its mass is kept, `settle` finds the equilibrium",
        parameters: vec![Parameter::number("factor", "1", Interval::Positive, "stress-free length over the present one")],
        returns: "",
        example: plate_example(
            "plate.grow(1.002);\nlet sim = simulate(press, #{ integrator: energy_momentum(), dt: 0.01 });\nsim.settle();",
        ),
        see_also: &["initial_displacement", "settle"],
        body: body(|call| {
            let (body, factor) = (call.receiver::<BodyHandle>(), call.number("factor")?);
            let definition = body.definition();
            let (mesh, model) = (definition.mesh.clone(), body.model.clone());
            let dimension = mesh.dimension();
            // Around an axis the hoop grows with the radius, in the plane the thickness does not.
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
            })?;
            Ok(Dynamic::UNIT)
        }),
    }
}
