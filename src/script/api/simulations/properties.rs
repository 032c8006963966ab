//! Properties of a simulation's state: time, energy, linear and angular momentum, contact.

use std::cell::RefCell;
use std::rc::Rc;

use super::handle::{SimulationHandle, busy};
use crate::dynamics::Simulation;
use crate::script::api::examples::flight_example;
use crate::script::api::models::handle::{BodyHandle, ModelHandle};
use crate::script::language::prelude::*;

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![
        time(),
        property("steps", "the number of accepted steps", "int", |simulation| Dynamic::from(simulation.row().step as i64)),
        property("energy", "a map with `kinetic`, `strain`, `potential`, `total`", "Map", |simulation| {
            let row = simulation.row();
            let entries = [("kinetic", row.kinetic), ("strain", row.strain), ("potential", row.potential), ("total", row.total())];
            entries.into_iter().map(|(name, value)| (name.into(), Dynamic::from(value))).collect::<Map>().into()
        }),
        property("momentum", "the linear momentum, an array", "Array", |simulation| {
            let row = simulation.row();
            array_of(row.momentum[..simulation.dimension()].iter().copied())
        }),
        property("angular_momentum", "the angular momentum about the origin: a number, in space an array", "number", |simulation| {
            let row = simulation.row();
            if simulation.dimension() == 2 {
                return row.angular_momentum[2].into();
            }
            array_of(row.angular_momentum.iter().copied())
        }),
        property("active", "the number of closed contact nodes", "int", |simulation| Dynamic::from(simulation.row().active as i64)),
        unknowns(),
        name(),
        bodies(),
    ]
}

fn time() -> Function {
    property_of::<SimulationHandle>(Topic::Simulation, "time")
        .summary("the time reached")
        .see_also(&["history", "run_to"])
        .example(flight_example("print(sim.time);"))
        .body(|call, handle| {
            let time = handle.with_row(call, Simulation::time)?;
            Ok(handle.0.script_time(time))
        })
}

fn unknowns() -> Function {
    property_of::<SimulationHandle>(Topic::Simulation, "unknowns")
        .summary("the number of free displacement components")
        .returns("int")
        .see_also(&["bodies"])
        .example(flight_example("print(sim.unknowns);"))
        .body(|call, simulation| match simulation.0.simulation.try_borrow() {
            Ok(simulation) => Ok(Dynamic::from(simulation.unknowns() as i64)),
            Err(_) => Err(busy(call).into()),
        })
}

fn name() -> Function {
    property_of::<SimulationHandle>(Topic::Simulation, "name")
        .summary("the name of the simulation: that of its model")
        .see_also(&["simulate"])
        .example(flight_example("print(sim.name);"))
        .body(|_, simulation| Ok(simulation.0.name.clone()))
}

fn bodies() -> Function {
    property_of::<SimulationHandle>(Topic::Simulation, "bodies")
        .summary("the bodies of the simulation, as they were when it was made")
        .see_also(&["add_body"])
        .example(flight_example("for body in sim.bodies { print(body.name); }"))
        .body(|_, simulation| {
            let data = simulation.0.model.clone();
            let count = data.model.bodies.len();
            let model = ModelHandle(Rc::new(RefCell::new(data)));
            Ok((0..count).map(|index| Dynamic::from(BodyHandle { model: model.clone(), index })).collect::<Array>())
        })
}

fn property(name: &'static str, summary: &'static str, returns: &'static str, read: fn(&Simulation) -> Dynamic) -> Function {
    property_of::<SimulationHandle>(Topic::Simulation, name)
        .summary(summary)
        .returns(returns)
        .see_also(&["history"])
        .example(flight_example(&format!("print(sim.{name});")))
        .body(move |call, simulation| Ok(simulation.with_row(call, read)?))
}
