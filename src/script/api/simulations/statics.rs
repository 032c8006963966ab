//! Statics as an integrator in scripts.

use rhai::Dynamic;

use super::integrators::IntegratorHandle;
use crate::integrators::STATICS;
use crate::script::api::examples::plate_example;
use crate::script::language::function::{Form, Function, Topic, body};
use crate::script::language::handle::Handle;

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![Function {
        name: STATICS.name,
        form: Form::Function,
        topic: Topic::Simulation,
        summary: STATICS.summary,
        parameters: Vec::new(),
        returns: IntegratorHandle::NAME,
        example: plate_example(
            "press.fix(plate.boundary(\"left\"));\npress.force(plate.boundary(\"right\"), [0.0, -1e3], |t| t);\n\
             let sim = simulate(press, #{ integrator: statics(), dt: 0.25 });\nsim.run_to(1.0);\nprint(sim.history.strain);",
        ),
        see_also: &["simulate", "settle", "follow_load"],
        body: body(|_| Ok(Dynamic::from(IntegratorHandle(STATICS)))),
    }]
}
