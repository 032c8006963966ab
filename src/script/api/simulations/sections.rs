//! Cut forces of a body: force and moment that the material on one side of a plane exerts on the other.

use super::fields::vector;
use super::handle::SimulationHandle;
use super::told::ScriptOutput;
use crate::dynamics::SectionForce;
use crate::script::api::examples::flight_example;
use crate::script::api::models::handle::BodyHandle;
use crate::script::language::prelude::*;

/// Cut force of a body at the time of its creation.
#[derive(Clone)]
pub struct SectionHandle {
    body: String,
    time: f64,
    dimension: usize,
    section: SectionForce,
    told: ScriptOutput,
}

impl SectionHandle {
    /// A moment: a number in the plane, an array in space.
    fn moment(&self, moment: &[f64; 3]) -> Dynamic {
        if self.dimension == 2 { moment[2].into() } else { vector(moment, 3) }
    }
}

impl Handle for SectionHandle {
    const NAME: &'static str = "SectionForce";
    const MAKER: &'static str = "take one of a simulation: `sim.section_force(body, point, normal)`";

    fn describe(&self) -> String {
        let SectionForce { force, moment_at_center, center, area, .. } = &self.section;
        let (force, center) = (self.told.vector(&force[..self.dimension], "force"), self.told.vector(&center[..self.dimension], "length"));
        let moment = self.told.moment(moment_at_center, self.dimension);
        format!(
            "section of body \"{}\" at t = {}: force {force}, moment {moment} about its center {center}, area {}",
            self.body,
            self.told.number(self.time, "time"),
            self.told.number(*area, "area")
        )
    }
}

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![
        section_force(),
        property(
            "force",
            "Array",
            "the force of the material in front of the plane on that behind it, positive along the normal in tension",
            |section| vector(&section.section.force, section.dimension),
        ),
        property("moment", "", "its moment about the origin: a number in the plane, an array in space", |section| {
            section.moment(&section.section.moment)
        }),
        property(
            "moment_at_center",
            "",
            "its moment about the center of the section: a number in the plane, an array in space",
            |section| section.moment(&section.section.moment_at_center),
        ),
        property("center", "Array", "the centroid of the section now", |section| vector(&section.section.center, section.dimension)),
        property("area", "float", "the area of the section in the undeformed body, its length in the plane", |section| {
            section.section.area.into()
        }),
    ]
}

fn section_force() -> Function {
    method_of::<SimulationHandle>(Topic::Results, "section_force")
        .summary(
            "the cut force of a body across a plane of the undeformed body: the force of the cells in front of it, towards which the \
             normal points, on the others. A cell is in front if its centroid is, so that the section follows the sides of cells; its \
             force is the sum of their nodal forces of stress, weight and inertia, and balances loads and reactions of each part exactly. \
             Loads on nodes of the section act on the part behind it. A plane that cuts a body at several places gives their sum",
        )
        .parameters(vec![
            Parameter::object::<BodyHandle>("body", "the body"),
            Parameter::vector("point", "a point of the plane in the undeformed body").of("length"),
            Parameter::vector("normal", "the normal of the plane, of any length").of("1"),
        ])
        .see_also(&["reaction", "joint", "along", "field"])
        .example(flight_example("sim.run_to(0.05);\nlet cut = sim.section_force(plate, [1.0, 0.5], [1.0, 0.0]);\nprint(cut);"))
        .body(|call, handle| {
            let index = handle.body_index(call)?;
            let (definition, dimension) = (&handle.0.model.model.bodies[index], handle.0.model.model.dimension());
            let [point, normal] = ["point", "normal"].map(|name| call.argument(name));
            let (place, direction) = (point.vector(dimension)?, normal.vector(dimension)?);
            if definition.rigid.is_some() {
                let failure =
                    call.argument("body").refuse(causes::BODY_KIND, format!("body \"{}\" is rigid: it has no stresses", definition.name));
                return Err(failure
                    .hint("`sim.joint(name)`, `sim.contact(name)` and `sim.reaction(boundary)` have the forces on it")
                    .into());
            }
            if direction == [0.0; 3] {
                return Err(normal
                    .refuse(causes::NO_DIRECTION, "the normal has no direction")
                    .hint("write one such as `[1.0, 0.0]`")
                    .into());
            }
            let (section, time) = handle.with(call, |simulation| (simulation.section_force(index, place, direction), simulation.time()))?;
            let Some(section) = section else {
                let failure = point.refuse(causes::EMPTY, format!("the plane does not part the cells of body \"{}\"", definition.name));
                return Err(failure.hint("give a point within the undeformed body").into());
            };
            Ok(SectionHandle { body: definition.name.clone(), time, dimension, section, told: ScriptOutput::of(&handle) })
        })
}

fn property(name: &'static str, returns: &'static str, summary: &'static str, read: fn(&SectionHandle) -> Dynamic) -> Function {
    property_of::<SectionHandle>(Topic::Results, name)
        .summary(summary)
        .returns(returns)
        .see_also(&["section_force"])
        .example(flight_example(&format!("sim.run_to(0.05);\nprint(sim.section_force(plate, [1.0, 0.5], [1.0, 0.0]).{name});")))
        .body(move |_, section| Ok(read(&section)))
}
