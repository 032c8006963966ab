//! Forces, torques and positions of joints.

use super::handle::SimulationHandle;
use super::told::ScriptOutput;
use crate::dynamics::{JointFrictionLoad, JointLoad};
use crate::script::api::examples::plate_example;
use crate::script::language::prelude::*;

/// State of a joint at the time of its creation.
#[derive(Clone)]
pub struct JointHandle {
    name: String,
    time: f64,
    /// Time of force and moment.
    acting: f64,
    dimension: usize,
    load: JointLoad,
    told: ScriptOutput,
}

impl JointHandle {
    fn array(&self, vector: [f64; 3]) -> Dynamic {
        array_of(vector[..self.dimension].iter().copied())
    }

    fn moment(&self) -> Dynamic {
        if self.dimension == 2 { self.load.moment[2].into() } else { self.array(self.load.moment) }
    }
}

impl Handle for JointHandle {
    const NAME: &'static str = "Joint";
    const MAKER: &'static str = "take one of a simulation: `sim.joint(name)`";

    fn describe(&self) -> String {
        let JointHandle { name, time, dimension, load, told, .. } = self;
        let (place, force) = (told.vector(&load.place[..*dimension], "length"), told.vector(&load.force[..*dimension], "force"));
        let (time, moment) = (told.number(*time, "time"), told.moment(&load.moment, *dimension));
        format!("joint \"{name}\" at {place}, t = {time}: force {force}, moment {moment}")
    }
}

/// Summary of `time`.
const TIME: &str = "the time to which force and moment belong, which are means over the last step: its middle with integrators whose \
                    forces act there, such as `energy_momentum()`, else its end";

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![
        joint(),
        property("force", "Array", "the force that the joint exerts on the body `from`", |joint| joint.array(joint.load.force)),
        property(
            "moment",
            "",
            "its moment about the joint's point on `from`: a number in the plane, an array in space",
            JointHandle::moment,
        ),
        property("time", "float", TIME, |joint| joint.acting.into()),
        property("position", "Array", "where the joint's point on `from` is", |joint| joint.array(joint.load.place)),
        coordinate("angle", "the angle by which `from` has turned in a hinge, in the plane in a point joint, over whole turns `[rad]`"),
        coordinate("travel", "how far `from` has moved in a slider or a slot `[length]`"),
        coordinate("distance", "the distance of both points of a link or a cable `[length]`"),
        work(),
        rubbed(
            "friction",
            "friction of the joint on `from` along its angle, travel or distance, a mean over the last step: a moment or a force; of a \
             ball joint the size of the moment",
            |of| of.force,
        ),
        rubbed(
            "friction_work",
            "work of the joint's friction in the last step, part of the ledger's `friction_work`, never positive `[energy]`",
            |of| of.work,
        ),
    ]
}

/// Function `name` of scripts: a quantity that some kinds of joints have. For other kinds `read` returns the missing property and a hint
/// for the message.
fn reading(
    name: &'static str,
    summary: &'static str,
    [joint, options]: [&str; 2],
    read: impl Fn(&JointHandle) -> Result<f64, [String; 2]> + 'static,
) -> Function {
    property_of::<JointHandle>(Topic::Results, name)
        .summary(summary)
        .returns("float")
        .see_also(&["joint", "add_joint"])
        .example(rod_example(joint, options, name))
        .body(move |call, joint| {
            let failure =
                |[lacks, hint]: [String; 2]| call.refuse(causes::NO_SUCH, format!("joint \"{}\" has no {lacks}", joint.name)).hint(hint);
            Ok(Dynamic::from(read(&joint).map_err(failure)?))
        })
}

/// Function `name` of scripts: a quantity of the friction of a joint.
fn rubbed(name: &'static str, summary: &'static str, read: fn(JointFrictionLoad) -> f64) -> Function {
    let hint = "`add_joint` gives it friction: `friction`, `friction_moment`, `friction_force`";
    reading(name, summary, ["swing", "kind: \"point\", friction_moment: 0.5"], move |joint| {
        joint.load.friction.map(read).ok_or_else(|| ["friction".into(), hint.into()])
    })
}

/// Function `name` of scripts: the coordinate of a joint.
fn coordinate(name: &'static str, summary: &'static str) -> Function {
    let example = match name {
        "travel" => ["rail", "kind: \"slider\", axis: [1.0, 0.0], drive: |t| 0.5 * t * t"],
        "distance" => ["rope", "kind: \"cable\", to_point: [0.0, 3.0], drive: |t| 3.0 - 0.5 * t * t"],
        _ => ["swing", "kind: \"point\", drive: |t| 0.5 * t * t"],
    };
    reading(name, summary, example, move |joint| match joint.load.coordinate {
        Some((coordinate, value)) if coordinate.name() == name => Ok(value),
        other => {
            let has = other.map_or("neither angle, travel nor distance".into(), |(other, _)| format!("`{}`", other.name()));
            Err([name.into(), format!("it has {has}")])
        }
    })
}

/// Function `work` of scripts.
fn work() -> Function {
    let summary = "work of the joint's drive in the last step, part of `load_work` `[energy]`";
    reading("work", summary, ["swing", "kind: \"point\", drive: |t| 0.5 * t * t"], |joint| {
        joint.load.work.ok_or_else(|| ["drive".into(), "forces of joints without one do no work".into()])
    })
}

/// A rod with a joint that a motor moves, for examples.
fn rod_example(joint: &str, options: &str, property: &str) -> std::borrow::Cow<'static, str> {
    let lines = format!(
        "let machine = model(\"machine\");\n\
         let rod = machine.add_rigid_body(\"rod\", rectangle(#{{ size: [2.0, 0.1], cells: [4, 1] }}), #{{ density: 1.0 }});\n\
         machine.add_joint(\"{joint}\", #{{ from: rod, point: [0.0, 0.0], {options} }});\n\
         let sim = simulate(machine, #{{ integrator: energy_momentum(), dt: 0.001 }});\nsim.step();\n\
         print(sim.joint(\"{joint}\").{property});"
    );
    lines.into()
}

/// A model with a joint, for examples.
fn example(line: &str) -> std::borrow::Cow<'static, str> {
    plate_example(&format!(
        "let rod = press.add_rigid_body(\"rod\", rectangle(#{{ size: [2.0, 0.1], cells: [4, 1], origin: [2.0, 0.0] }}), #{{ density: 1.0 \
         }});\n\
         press.add_joint(\"hinge\", #{{ kind: \"point\", from: rod, to: plate, point: [2.0, 0.0] }});\npress.gravity([0.0, -9.81]);\n\
         let sim = simulate(press, #{{ integrator: energy_momentum(), dt: 0.001 }});\nsim.step();\n{line}"
    ))
}

fn joint() -> Function {
    method_of::<SimulationHandle>(Topic::Results, "joint")
        .summary("the action of a joint on the body `from` (a mean over the last step), and its position")
        .parameters(vec![Parameter::text("name", "its name")])
        .see_also(&["add_joint", "reaction"])
        .example(example("print(sim.joint(\"hinge\"));"))
        .body(|call, handle| {
            let name = call.text("name")?;
            let joints = &handle.0.model.model.joints;
            let known: Vec<&str> = joints.iter().map(|joint| joint.name.as_str()).collect();
            if !known.contains(&name.as_str()) {
                return Err(call.argument("name").unknown_name(format!("there is no joint \"{name}\""), &name, &known).into());
            }
            let found = handle.with(call, |simulation| (simulation.joint(&name), simulation.time(), simulation.dimension()))?;
            let (Some(load), time, dimension) = found else {
                return Err(call
                    .refuse(causes::NO_SUCH, format!("joint \"{name}\" has no values before the first step"))
                    .hint("take a step")
                    .into());
            };
            let acting = handle.0.script_time(load.time);
            Ok(JointHandle { name, time, acting, dimension, load, told: ScriptOutput::of(&handle) })
        })
}

fn property(name: &'static str, returns: &'static str, summary: &'static str, read: fn(&JointHandle) -> Dynamic) -> Function {
    property_of::<JointHandle>(Topic::Results, name)
        .summary(summary)
        .returns(returns)
        .see_also(&["joint"])
        .example(example(&format!("print(sim.joint(\"hinge\").{name});")))
        .body(move |_, joint| Ok(read(&joint)))
}
