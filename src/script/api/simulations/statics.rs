//! Statics as an integrator in scripts.

use super::integrators::IntegratorHandle;
use crate::integrators::STATICS;
use crate::script::api::examples::plate_example;
use crate::script::language::prelude::*;

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![
        function(Topic::Simulation, STATICS.name)
            .summary(STATICS.summary)
            .see_also(&["simulate", "settle", "follow_load"])
            .example(plate_example(
                "press.fix(plate.boundary(\"left\"));\npress.force(plate.boundary(\"right\"), [0.0, -1e3], |t| t);\n\
             let sim = simulate(press, #{ integrator: statics(), dt: 0.25 });\nsim.run_to(1.0);\nprint(sim.history.strain);",
            ))
            .body(|_| Ok(IntegratorHandle(STATICS))),
    ]
}
