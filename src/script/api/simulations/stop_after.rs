//! `stop_after`: how the record of a session repeats an entry that was interrupted.
//!
//! The actions of an entry before an interrupt depend only on the script, so the number of changes to objects determines where the entry
//! stopped. A step is one change; making or changing a model or a simulation is one, too.

use rhai::EvalAltResult;

use crate::script::api::examples::flight_example;
use crate::script::language::callback::Callback;
use crate::script::language::failure::Class;
use crate::script::language::prelude::*;

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![
        function(Topic::Simulation, "stop_after")
            .summary(
                "runs a closure and stops it, as Ctrl-C does, after so many changes of objects since the script began; `:save` writes it \
                 for an entry that was interrupted at the prompt",
            )
            .parameters(vec![
                Parameter::integer("changes", "the changes since the script began: a step is one, and so is making an object")
                    .within(Interval::NonNegative),
                Parameter::new("action", Kind::Closure("||"), "what is stopped"),
            ])
            .see_also(&["run_to", "save"])
            .example(flight_example("stop_after(10, || sim.run_to(5.0));\nprint(sim.time < 5.0);"))
            .body(|call| {
                let (changes, action) = (call.integer("changes")?, call.callback("action")?);
                let before = call.host.stop_after(Some(changes as u64));
                let outcome = action.call([]);
                let is_reached = call.host.is_stopped();
                call.host.stop_after(before);
                match outcome {
                    Err(error) if is_reached && is_interrupt(&error) && !call.host.is_interrupted() => Ok(()),
                    Err(error) => Err(passed_on(call, &action, error)),
                    Ok(_) => Ok(()),
                }
            }),
    ]
}

/// True if an error is an interrupt, within any chain of calls.
fn is_interrupt(error: &EvalAltResult) -> bool {
    match error {
        EvalAltResult::ErrorInFunctionCall(_, _, inner, _) | EvalAltResult::ErrorInModule(_, inner, _) => is_interrupt(inner),
        EvalAltResult::ErrorTerminated(payload, _) => {
            payload.read_lock::<Failure>().is_some_and(|failure| failure.class == Class::Interrupted)
        }
        _ => false,
    }
}

/// Converts an error of the closure, with the closure's place first.
fn passed_on(call: &Call, action: &Callback, error: Box<EvalAltResult>) -> Box<EvalAltResult> {
    if error.is_catchable() { call.fail("in the closure of `stop_after`").caused_by(action.wrap(*error)).into() } else { error }
}
