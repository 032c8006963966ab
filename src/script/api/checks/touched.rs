//! `expect_contact`: requires that a contact pair was ever active, or is active now.

use rhai::EvalAltResult;

use super::verdicts::{failed, only_listed, passed};
use crate::script::api::examples::contact_example;
use crate::script::api::simulations::handle::SimulationHandle;
use crate::script::language::digits::brief;
use crate::script::language::prelude::*;

/// `expect_contact`: requires that a pair was or is closed.
pub fn expect_contact() -> Function {
    function(Topic::Checks, "expect_contact")
        .summary("ends the script with an error unless a contact pair was closed after some step (or is closed now)")
        .parameters(vec![
            Parameter::object::<SimulationHandle>("simulation", "the simulation"),
            Parameter::text("name", "the name of the contact pair"),
            Parameter::new("when", Kind::Choice(&["ever", "now"]), "whether it must have been closed at any time, or must be closed now")
                .or("ever"),
        ])
        .see_also(&["contact", "add_contact"])
        .example(contact_example(
            "press.initial_velocity(plate, #{ linear: [0.0, -1.0] });\nlet sim = simulate(press, #{ integrator: energy_momentum(), \
                                                 dt: 0.001 });\nsim.step(3);\nexpect_contact(sim, \"foot\");",
        ))
        .body(closed)
}

fn closed(call: &Call) -> Result<(), Box<EvalAltResult>> {
    let (handle, argument, when) = (call.handle::<SimulationHandle>("simulation")?, call.argument("name"), call.text("when")?);
    let name = argument.text()?;
    let names = handle.0.model.model.contact_names();
    let Some(index) = names.iter().position(|contact| *contact == name) else {
        return Err(argument.unknown_name(format!("there is no contact \"{name}\""), &name, &names).into());
    };
    if only_listed(call, &format!("contact \"{name}\" of \"{}\" closes", handle.0.name)) {
        return Ok(());
    }
    let (nodes, time) = handle.with(call, |simulation| (simulation.closed_nodes()[index], simulation.time()))?;
    let time = handle.0.history.borrow().last().map_or(time, |row| row.time);
    let since = handle.0.closed_since.borrow()[index];
    match (when.as_str(), since) {
        ("now", _) if nodes > 0 => passed(call, &format!("ok  contact \"{name}\" is closed at {nodes} nodes at t = {}", brief(time))),
        ("now", Some(since)) => Err(failed(call, format!("contact \"{name}\" is open at t = {}", brief(time)))
            .cause(format!("it was first closed at t = {}", brief(since)))
            .hint("check whether it was closed at any time with \"ever\"")
            .into()),
        (_, Some(since)) => passed(call, &format!("ok  contact \"{name}\" closed, first seen at t = {}", brief(since))),
        (_, None) => {
            let failure = failed(call, format!("contact \"{name}\" never closed until t = {}", brief(time)));
            let gaps = handle.with(call, |simulation| simulation.contact(&name))?.map(|fields| fields.gap).unwrap_or_default();
            let least = gaps.into_iter().filter(|gap| gap.is_finite()).reduce(f64::min);
            let failure = failure.cause(match least {
                Some(least) => format!("the smallest gap at this time is {}", brief(least)),
                None => "no node of its secondary side lies opposite its primary side".into(),
            });
            Err(failure.hint("check the positions and velocities of the two bodies, and how far the simulation runs").into())
        }
    }
}
