//! `sim.buckling`: load factors of linear buckling as an object, with the shapes.

use std::rc::Rc;

use super::handle::SimulationHandle;
use super::modes;
use crate::dynamics::{Buckling, BucklingError};
use crate::math::tolerances::{LINEAR_PATH, LINEAR_STATE};
use crate::script::api::examples::plate_example;
use crate::script::api::models::handle::BodyHandle;
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::digits::brief;
use crate::script::language::prelude::*;

/// Largest number of factors.
const MOST: f64 = 200.0;

/// Linear buckling of a simulation under the load of a state.
#[derive(Clone)]
pub struct BucklingHandle {
    buckling: Rc<Buckling>,
    simulation: SimulationHandle,
}

impl Handle for BucklingHandle {
    const NAME: &'static str = "Buckling";
    const MAKER: &'static str = "make one with `sim.buckling(#{ count: 1 })`";

    fn describe(&self) -> String {
        let factors: Vec<String> = self.buckling.factors.iter().map(|factor| brief(*factor)).collect();
        let time = brief(self.simulation.0.script_time(self.buckling.time));
        format!("\"{}\" at t = {time} buckles under its load times {}", self.simulation.0.name, factors.join(", "))
    }
}

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![buckling(), factors(), shape()]
}

fn buckling_example(line: &str) -> std::borrow::Cow<'static, str> {
    plate_example(&format!(
        "press.fix(plate.boundary(\"bottom\"));\npress.force(plate.boundary(\"top\"), [0.0, -1.0]);\n\
         let sim = simulate(press, #{{ integrator: energy_momentum(), dt: 0.001 }});\nsim.settle();\n\
         let buckling = sim.buckling(#{{ count: 1 }});\n{line}"
    ))
}

fn buckling() -> Function {
    let count = Parameter::integer("count", "how many, the smallest first").within(Interval::Closed(1.0, MOST));
    method_of::<SimulationHandle>(Topic::Results, "buckling")
        .summary(
            "linear buckling of a settled state: the factors of its load at which a small motion meets no resistance, as if stresses and \
             displacements grew with the load; settle under a small part of the load, for the way beyond is taken for straight; loads that \
             turn with their boundary are refused; the state stays as it is",
        )
        .parameters(vec![Parameter::options("how many").otherwise("#{ count: 1 }").keys(vec![count.or(1)])])
        .see_also(&["settle", "follow_load", "modes"])
        .example(buckling_example("print(buckling);\nprint(buckling.factors[0]);"))
        .body_with_options(|call, handle, options| {
            let count = options.argument("count").integer()?;
            handle.refuse_in_check(call)?;
            handle.looked()?;
            let found = handle.found(call, "buckling", |simulation| simulation.buckling(count as usize))?;
            let buckling = found.map_err(|error| refused(call, &handle, error))?;
            warn(call, &buckling);
            Ok(BucklingHandle { buckling: Rc::new(buckling), simulation: handle })
        })
}

/// Warns of load factors that may be missing, and of a nonlinear path to the state, or from there to the first factor.
fn warn(call: &Call, buckling: &Buckling) {
    let warning = |title: String| Diagnostic::warning(title, call.place(&Target::Call));
    if !buckling.is_complete {
        let title = "load factors may be missing: those below the last could not be counted".to_string();
        call.host.warn(warning(title).code("C0726").hint("request a few more with `count`"));
    }
    let off = buckling.nonlinearity;
    if off > LINEAR_STATE {
        let title = format!("the state is not that of a linear model: its strain energy is off by {}", brief(off));
        call.host.warn(warning(title).code("C0727").hint("settle under a smaller part of the load"));
    } else if off * buckling.factors[0] > LINEAR_PATH {
        let title = "the way to the buckling load is not straight: the load factor is an estimate".to_string();
        call.host.warn(warning(title).code("C0728").hint("`sim.follow_load` follows equilibria up to where stability is lost"));
    }
}

/// Error message of a refused `buckling`.
fn refused(call: &Call, handle: &SimulationHandle, error: BucklingError) -> Failure {
    let (title, code) = (error.to_string(), error.code());
    let failure = match error {
        BucklingError::Matrix(error) => modes::refused(call, handle, error),
        BucklingError::Follows { .. } => call.fail(title).hint("`sim.follow_load` finds where stability is lost under such loads"),
        BucklingError::Unloaded => call.fail(title).hint("load the model and call `sim.settle()` before"),
        BucklingError::Loose => call.fail(title).hint("hold every body with `fix` or by closed contacts"),
        BucklingError::NotFound { .. } => call.fail(title).hint("reverse the load, or request fewer with `count`"),
    };
    failure.code(code)
}

fn factors() -> Function {
    property_of::<BucklingHandle>(Topic::Results, "factors")
        .summary("the factors of the load, the smallest first")
        .returns("Array")
        .see_also(&["buckling", "shape"])
        .example(buckling_example("print(buckling.factors);"))
        .body(|_, buckling| Ok(array_of(buckling.buckling.factors.iter().copied())))
}

fn shape() -> Function {
    method_of::<BucklingHandle>(Topic::Results, "shape")
        .summary("the motion of the nodes of a body in which the model buckles, the largest displacement of all bodies of length 1")
        .parameters(vec![
            Parameter::integer("mode", "its number, from 0 on").within(Interval::Closed(0.0, MOST)),
            Parameter::object::<BodyHandle>("body", "the body"),
        ])
        .returns("Array")
        .see_also(&["buckling", "factors"])
        .example(buckling_example("print(buckling.shape(0, plate)[2]);"))
        .body(|call, handle| {
            let (argument, index) = (call.argument("mode"), handle.simulation.body_index(call)?);
            let number = argument.integer()?;
            let shapes = &handle.buckling.shapes;
            let Some(shape) = usize::try_from(number).ok().and_then(|number| shapes.get(number)) else {
                let failure = argument
                    .refuse(causes::NO_SUCH, format!("there is no shape {number}: they are numbered from 0 to {}", shapes.len() - 1));
                return Err(failure.hint("request more with `count` of `sim.buckling`").into());
            };
            let dimension = handle.simulation.0.model.model.dimension();
            Ok(modes::shape_array(&shape[index], dimension))
        })
}
