//! State of a contact pair at a time: forces, gaps, pressures, active nodes.

use std::rc::Rc;

use super::handle::SimulationHandle;
use super::told::ScriptOutput;
use crate::dynamics::{ContactFields, CyclingNode, FailureCause};
use crate::script::api::examples::contact_example;
use crate::script::language::prelude::*;

/// State of a contact pair at the time of its creation.
#[derive(Clone)]
pub struct ContactHandle {
    name: String,
    time: f64,
    dimension: usize,
    fields: Rc<ContactFields>,
    /// Nodes whose contact state cycled in the failed step.
    cycling: Vec<CyclingNode>,
    told: ScriptOutput,
}

impl Handle for ContactHandle {
    const NAME: &'static str = "ContactState";

    fn describe(&self) -> String {
        let active = self.fields.active.iter().filter(|active| **active).count();
        let largest = self.fields.pressure.iter().fold(0.0_f64, |largest, pressure| largest.max(*pressure));
        let sliding = if self.fields.sliding > 0 { format!(", {} sliding", self.fields.sliding) } else { String::new() };
        let cycling = match self.cycling.len() {
            0 => String::new(),
            count => format!("; {count} cycling in the step that failed"),
        };
        format!(
            "contact \"{}\" at t = {}: {active} of {} nodes active{sliding}, largest pressure {}, force {}{cycling}",
            self.name,
            self.told.number(self.time, "time"),
            self.fields.active.len(),
            self.told.number(largest, "stress"),
            self.told.vector(&self.fields.force[..self.dimension], "force")
        )
    }
}

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![
        contact(),
        power(),
        cycling(),
        number("normal_force", "the sum of the sizes of the nodal contact forces that press, for a surface with itself too", |fields| {
            fields.normal_force
        }),
        number(
            "area",
            "the size of the secondary surface in contact, to about half a facet at its border: a length in the plane, else an area",
            |fields| fields.area,
        ),
        array("pressure", "the contact pressure at each secondary node, in their order along the surface", |contact| {
            array_of(contact.fields.pressure.iter().copied())
        }),
        array(
            "mean_pressure",
            "the mean contact pressure on what is covered of each secondary node, its force over its area, in their order along the \
             surface: beside the edge of a contact it is smoother than `pressure`, the multipliers of a mortar method",
            |contact| array_of(contact.fields.mean_pressure.iter().copied()),
        ),
        array("gap", "the gap at each secondary node, in their order along the surface, NaN where nothing lies opposite", |contact| {
            array_of(contact.fields.gap.iter().copied())
        }),
        array("active", "whether each secondary node is in contact, in their order along the surface", |contact| {
            array_of(contact.fields.active.iter().copied())
        }),
        array(
            "state",
            "what each secondary node does, in their order along the surface: \"open\", \"stick\" where friction holds what is pressed, or \
             \"slip\"; without friction all that is pressed slips",
            |contact| array_of(contact.fields.state.iter().map(|state| state.name())),
        ),
        array(
            "shear",
            "the shear stress of friction at each secondary node, in their order along the surface: positive where it pulls that way, with \
             the body on the left; in space its size",
            |contact| array_of(contact.fields.shear.iter().copied()),
        ),
        array(
            "slip",
            "the slip of each secondary node in the last step, against the other side and in the direction of their order along the \
             surface, in space its size; 0 without friction and where nothing presses",
            |contact| array_of(contact.fields.slip.iter().copied()),
        ),
        array(
            "slip_path",
            "the sum of the sizes of the slips of each secondary node since the start, in their order along the surface: of steps, and of \
             `settle` at a later time",
            |contact| array_of(contact.fields.slip_path.iter().copied()),
        ),
        array(
            "heat",
            "the heat of friction at each secondary node since the start, over the present area, in their order along the surface",
            |contact| array_of(contact.fields.heat.iter().copied()),
        ),
        number("sliding", "the number of secondary nodes that slide against friction", |fields| fields.sliding as f64),
        array(
            "forces",
            "the contact force on each secondary node, friction included, in their order along the surface, an array of vectors",
            |contact| array_of(contact.fields.forces.iter().map(|force| array_of(force[..contact.dimension].iter().copied()))),
        ),
        array(
            "force",
            "the resultant of the contact forces on the secondary side, friction included (of a surface with itself: on one side of its \
             folds)",
            |contact| array_of(contact.fields.force[..contact.dimension].iter().copied()),
        ),
        array("positions", "the current position of each secondary node, in their order along the surface", |contact| {
            array_of(contact.fields.positions.iter().map(|position| array_of(position[..contact.dimension].iter().copied())))
        }),
    ]
}

fn contact() -> Function {
    method_of::<SimulationHandle>(Topic::Contact, "contact")
        .summary("a contact pair as it is now")
        .parameters(vec![Parameter::text("name", "the name of the contact pair")])
        .see_also(&["add_contact"])
        .example(contact_example("print(sim.contact(\"foot\"));"))
        .body(|call, handle| {
            let argument = call.argument("name");
            let name = argument.text()?;
            let found = handle.with(call, |simulation| {
                let cycling = match simulation.failure().map(|report| &report.cause) {
                    Some(FailureCause::CyclingContact { contact, cycling, .. }) if *contact == name => cycling.clone(),
                    _ => Vec::new(),
                };
                (simulation.contact(&name), simulation.time(), simulation.dimension(), cycling)
            })?;
            match found {
                (Some(fields), time, dimension, cycling) => {
                    Ok(ContactHandle { name, time, dimension, fields: Rc::new(fields), cycling, told: ScriptOutput::of(&handle) })
                }
                (None, ..) => {
                    let names = handle.0.model.model.contact_names();
                    Err(argument.unknown_name(format!("there is no contact \"{name}\""), &name, &names).into())
                }
            }
        })
}

fn power() -> Function {
    method_of::<SimulationHandle>(Topic::Contact, "power")
        .summary(
            "the power of friction in a contact pair, a mean over the last step: its work over the size of the step, never positive; the \
             work of every step is the column `name.friction_work` of the history",
        )
        .parameters(vec![Parameter::text("name", "the name of the contact pair")])
        .see_also(&["contact", "add_contact", "history"])
        .example(contact_example("sim.step();\nprint(sim.power(\"foot\"));"))
        .body(|call, handle| {
            let argument = call.argument("name");
            let name = argument.text()?;
            let names = handle.0.model.model.contact_names();
            let Some(index) = names.iter().position(|known| *known == name) else {
                return Err(argument.unknown_name(format!("there is no contact \"{name}\""), &name, &names).into());
            };
            let row = handle.0.script_row(handle.with_row(call, |simulation| simulation.row().clone())?);
            let work = row.contacts.get(index).map_or(0.0, |contact| contact.friction_work);
            // Before the first step and at rest, no time passes, and there is no slip.
            Ok(if work == 0.0 || row.dt == 0.0 { 0.0 } else { work / row.dt })
        })
}

fn cycling() -> Function {
    property_of::<ContactHandle>(Topic::Contact, "cycling")
        .summary(
            "the nodes whose contact state kept changing in the last iterations of the step that failed, as maps with `body`, `node` (its \
             number in the body's mesh) and `index` (its place in `positions`, `gap`, `pressure` and `active`)",
        )
        .returns("Array")
        .see_also(&["contact", "why"])
        .example(contact_example(
            "let race = sim.contact(\"foot\");\n\
             for node in race.cycling { print(`node ${node.node} at ${race.positions[node.index]}`); }",
        ))
        .body(|_, contact| {
            let map = |node: &CyclingNode| {
                let index = node.index.map_or(Dynamic::UNIT, |index| (index as i64).into());
                map_of([("body", node.body.clone().into()), ("node", (node.node as i64).into()), ("index", index)])
            };
            Ok(array_of(contact.cycling.iter().map(map)))
        })
}

fn number(name: &'static str, summary: &'static str, read: fn(&ContactFields) -> f64) -> Function {
    property_of::<ContactHandle>(Topic::Contact, name)
        .summary(summary)
        .see_also(&["contact", "history"])
        .example(contact_example(&format!("print(sim.contact(\"foot\").{name});")))
        .body(move |_, contact| Ok(read(&contact.fields)))
}

fn array(name: &'static str, summary: &'static str, read: fn(&ContactHandle) -> Dynamic) -> Function {
    property_of::<ContactHandle>(Topic::Contact, name)
        .summary(summary)
        .returns("Array")
        .see_also(&["contact"])
        .example(contact_example(&format!("print(sim.contact(\"foot\").{name});")))
        .body(move |_, contact| Ok(read(&contact)))
}
