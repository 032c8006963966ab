//! Changes of a model: each is checked at once, so that a fault is reported where it was written.
//!
//! A simulation has the model as of `simulate`; later changes without a simulation are warned of at the end.

use std::cell::RefCell;
use std::rc::Rc;

use rhai::EvalAltResult;

use super::data::ModelData;
use super::handle::ModelHandle;
use crate::script::api::nested_runs::is_study;
use crate::script::api::remedies::ScriptWords;
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::prelude::*;

/// Changes the model and checks it; an invalid change is undone.
///
/// # Errors
/// The changed model is invalid.
pub fn change(call: &Call, handle: &ModelHandle, apply: impl FnOnce(&mut ModelData)) -> Result<(), Box<EvalAltResult>> {
    let before = handle.0.borrow().clone();
    apply(&mut handle.0.borrow_mut());
    let checked = handle.0.borrow().model.check();
    match checked {
        Ok(()) => {
            call.host.count_effect();
            let mut data = handle.0.borrow_mut();
            if data.is_simulated && data.unseen.is_none() {
                data.unseen = Some((call.function.name.into(), call.place(&Target::Call)));
            }
            Ok(())
        }
        Err(error) => {
            *handle.0.borrow_mut() = before;
            Err(call.fail(error.to_string()).code(error.code()).hint(error.remedy()).into())
        }
    }
}

/// Changes a model that may have no bodies yet.
pub fn change_without_bodies(call: &Call, handle: &ModelHandle, apply: impl FnOnce(&mut ModelData)) -> Result<(), Box<EvalAltResult>> {
    if handle.0.borrow().model.bodies.is_empty() {
        apply(&mut handle.0.borrow_mut());
        call.host.count_effect();
        return Ok(());
    }
    change(call, handle, apply)
}

/// Models of which a script made simulations.
#[derive(Default)]
struct Simulated(RefCell<Vec<ModelHandle>>);

/// Records that a simulation was made of the model as it is now.
pub fn keep_model(host: &Host, model: &ModelHandle) {
    let mut data = model.0.borrow_mut();
    (data.is_simulated, data.unseen) = (true, None);
    let simulated = host.slots.get::<Simulated>();
    let mut models = simulated.0.borrow_mut();
    if !is_study(host) && !models.iter().any(|known| Rc::ptr_eq(&known.0, &model.0)) {
        models.push(model.clone());
    }
}

/// Warns of changes of models that came after the last `simulate`.
pub fn warn_of_unseen_changes(host: &Host) {
    for model in host.slots.get::<Simulated>().0.borrow().iter() {
        let data = model.0.borrow();
        let Some((function, place)) = &data.unseen else { continue };
        let title = format!("`{function}` changes model \"{}\" after its simulation was made", data.model.name);
        let warning =
            Diagnostic::warning(title, place.clone()).code("C0176").cause("a simulation is one of the model as it was at `simulate`");
        host.warn(warning.hint("complete the model before `simulate`, or make another simulation after the change"));
    }
}
