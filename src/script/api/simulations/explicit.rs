//! Explicit steps in scripts: `central_differences`, and `stable_step`, the largest stable time step size.

use super::handle::{SimulationHandle, busy};
use super::integrators::IntegratorHandle;
use super::simulate::kernels;
use crate::dynamics::{Options, StableStep};
use crate::integrators::{CENTRAL_DIFFERENCES, Lumping, central_differences};
use crate::script::api::examples::FLIGHT;
use crate::script::api::models::handle::ModelHandle;
use crate::script::language::arguments::Options as Given;
use crate::script::language::prelude::*;

/// Names of the lumping methods.
const MASSES: &[&str] = &[Lumping::ALL[0].0, Lumping::ALL[1].0, Lumping::ALL[2].0];

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![integrator(), stable_step(), stable_step_now()]
}

fn mass_parameter() -> Parameter {
    let summary = "the distribution of a cell's mass among its nodes: by `row_sum`, by its diagonal (`hrz`, always positive), or by row \
                   sums where all of these are positive, else by the diagonal";
    Parameter::new("mass", Kind::Choice(MASSES), summary).or(MASSES[0])
}

fn options_parameter() -> Parameter {
    Parameter::map("options", "its mass").otherwise("its defaults").keys(vec![mass_parameter()])
}

fn lumping_of(options: &Given) -> Result<Lumping, Failure> {
    let name = options.text("mass")?;
    Ok(Lumping::ALL.iter().find(|(known, _)| *known == name).map_or(Lumping::Suitable, |(_, lumping)| *lumping))
}

fn integrator() -> Function {
    function(Topic::Simulation, CENTRAL_DIFFERENCES.name)
        .summary(CENTRAL_DIFFERENCES.summary)
        .parameters(vec![options_parameter()])
        .see_also(&["simulate", "stable_step"])
        .example(format!(
            "{FLIGHT}let sim = simulate(flight, #{{ integrator: central_differences(), dt: 0.9 * stable_step(flight) }});\n\
             sim.run_to(0.01);\nprint(sim.steps);"
        ))
        .body(|call| Ok(IntegratorHandle(central_differences(lumping_of(&call.options("options")?)?))))
}

fn stable_step() -> Function {
    function(Topic::Simulation, "stable_step")
        .summary(
            "the longest step of `central_differences` that is stable for a model as it begins, 2 over the largest angular frequency; take \
             a tenth less: cells that are compressed need shorter steps",
        )
        .parameters(vec![Parameter::object::<ModelHandle>("model", "the model"), options_parameter()])
        .see_also(&["central_differences", "simulate"])
        .example(format!("{FLIGHT}print(stable_step(flight));\nprint(stable_step(flight, #{{ mass: \"hrz\" }}));"))
        .body(|call| {
            let (model, lumping) = (call.handle::<ModelHandle>("model")?, lumping_of(&call.options("options")?)?);
            let mut options = Options::new(&central_differences(lumping), 1.0);
            options.threads = call.host.settings.threads;
            options.interrupt = Some(call.host.settings.interrupt.clone());
            let model = model.0.borrow().clone();
            let mut simulation = kernels(call, &model.model, None, options)?;
            let found = simulation.stable_step().map_err(|error| call.fail(error.to_string()).code(error.code()).hint(error.hint()))?;
            Ok(found.dt)
        })
}

fn stable_step_now() -> Function {
    method_of::<SimulationHandle>(Topic::Simulation, "stable_step")
        .summary(
            "the longest stable step of `central_differences` about the present state, as a map: `dt`, `frequency` (the largest angular \
             one), `bound` (the step by the fastest cell alone, which costs next to nothing), `body` and `cell` (that cell)",
        )
        .returns("Map")
        .see_also(&["central_differences", "modes"])
        .example(format!(
            "{FLIGHT}let sim = simulate(flight, #{{ integrator: central_differences(), dt: 0.001 }});\nprint(sim.stable_step());"
        ))
        .body(|call, _| Ok(Dynamic::from(now(call)?)))
}

fn now(call: &Call) -> Result<Map, Failure> {
    let handle = call.receiver::<SimulationHandle>();
    handle.looked()?;
    let mut simulation = handle.0.simulation.try_borrow_mut().map_err(|_| busy(call))?;
    if simulation.options().integrator.lumping().is_none() {
        let name = simulation.options().integrator.name;
        let failure = call.refuse(causes::BODY_KIND, format!("`{name}` has no longest stable step: its steps solve equations"));
        return Err(failure.hint("`stable_step(model)` returns that of `central_differences` for a model"));
    }
    let found = simulation.stable_step();
    drop(simulation);
    let StableStep { dt, frequency, bound, body, cell, .. } = found.map_err(|error| handle.step_failure(call, error))?;
    let unit = handle.0.kernel_time(1.0);
    let entries: [(&str, Dynamic); 5] = [
        ("dt", (dt / unit).into()),
        ("frequency", (frequency * unit).into()),
        ("bound", (bound / unit).into()),
        ("body", body.into()),
        ("cell", (cell as i64).into()),
    ];
    Ok(entries.into_iter().map(|(name, value)| (name.into(), value)).collect())
}
