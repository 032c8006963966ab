//! Reactions of supports: forces and torques of `fix` and `prescribe` on a boundary.

use rhai::ImmutableString;

use super::handle::SimulationHandle;
use super::told::ScriptOutput;
use crate::dynamics::Reaction;
use crate::script::api::examples::contact_example;
use crate::script::api::models::handle::BoundaryHandle;
use crate::script::language::prelude::*;

/// Reaction of a boundary's supports at the time of its creation.
#[derive(Clone)]
pub struct ReactionHandle {
    boundary: String,
    time: f64,
    dimension: usize,
    reaction: Reaction,
    told: ScriptOutput,
}

impl ReactionHandle {
    fn moment(&self) -> Dynamic {
        match self.dimension {
            2 => self.reaction.moment[2].into(),
            _ => array_of(self.reaction.moment.iter().copied()),
        }
    }
}

impl Handle for ReactionHandle {
    const NAME: &'static str = "Reaction";
    const MAKER: &'static str = "take one of a simulation: `sim.reaction(boundary)`";

    fn describe(&self) -> String {
        let ReactionHandle { boundary, time, dimension, reaction, told } = self;
        let (force, moment) = (told.vector(&reaction.force[..*dimension], "force"), told.moment(&reaction.moment, *dimension));
        format!("reaction of \"{boundary}\" at t = {}: force {force}, moment {moment}", told.number(*time, "time"))
    }
}

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![
        reaction(),
        property("force", "Array", "the resultant of the support forces on the boundary, a mean over the last step", |reaction| {
            array_of(reaction.reaction.force[..reaction.dimension].iter().copied())
        }),
        property("moment", "", "its moment about the origin: a number in the plane, an array in space", ReactionHandle::moment),
    ]
}

fn reaction() -> Function {
    method_of::<SimulationHandle>(Topic::Results, "reaction")
        .summary(
            "the forces of `fix` and `prescribe` on a boundary, in the history as columns `body.boundary.reaction.force_x` and so on, or a \
             symmetry on its nodes, a periodic pair on its second boundary",
        )
        .parameters(vec![Parameter::new(
            "boundary",
            Kind::Either("a boundary or the name of a symmetry or a periodic pair"),
            "a boundary that a support holds or moves, or the name of what couples nodes",
        )])
        .see_also(&["fix", "prescribe", "contact", "history"])
        .example(contact_example(
            "let below = table.boundary(\"bottom\");\npress.fix(below);\npress.gravity([0.0, -10.0]);\n\
             let held = simulate(press, #{ integrator: energy_momentum(), dt: 0.001 });\nheld.step();\nprint(held.reaction(below));",
        ))
        .body(|call, handle| {
            let boundary = match call.argument("boundary").value().try_cast::<ImmutableString>() {
                Some(name) => name.to_string(),
                None => call.handle::<BoundaryHandle>("boundary")?.title(),
            };
            let names = handle.0.model.model.reaction_names();
            let Some(index) = names.iter().position(|name| *name == boundary) else {
                let names: Vec<&str> = names.iter().map(String::as_str).collect();
                return Err(call.argument("boundary").unknown_name(format!("nothing holds \"{boundary}\""), &boundary, &names).into());
            };
            let found = handle
                .with_row(call, |simulation| (simulation.row().reactions.get(index).copied(), simulation.time(), simulation.dimension()))?;
            let (Some(reaction), time, dimension) = found else {
                let failure = call.refuse(causes::TIME, format!("the reaction of \"{boundary}\" is not known before the first step"));
                return Err(failure.hint("take a step, or compute an equilibrium by `sim.settle()`").into());
            };
            Ok(ReactionHandle { boundary, time, dimension, reaction, told: ScriptOutput::of(&handle) })
        })
}

fn property(name: &'static str, returns: &'static str, summary: &'static str, read: fn(&ReactionHandle) -> Dynamic) -> Function {
    property_of::<ReactionHandle>(Topic::Results, name)
        .summary(summary)
        .returns(returns)
        .see_also(&["reaction"])
        .example(contact_example(&format!(
            "let below = table.boundary(\"bottom\");\npress.fix(below);\n\
             let held = simulate(press, #{{ integrator: energy_momentum(), dt: 0.001 }});\nheld.step();\n\
             print(held.reaction(below).{name});"
        )))
        .body(move |_, reaction| Ok(read(&reaction)))
}
