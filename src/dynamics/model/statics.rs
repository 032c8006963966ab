//! What steps from equilibrium to equilibrium do not take, before the first one.

use super::definitions::Model;
use super::error::ModelError;

/// Refuses what statics cannot do; `chooses_size`: whether steps are to choose their size.
///
/// # Errors
/// The first such thing of the model.
pub fn check_static(model: &Model, chooses_size: bool) -> Result<(), ModelError> {
    let steps = "steps of `statics`";
    let refused = |what: String, reason: &'static str, instead: &'static str| Err(ModelError::NotTaken { steps, what, reason, instead });
    if chooses_size {
        let reason = "every equilibrium is exact, and no error grows from step to step";
        return refused("a size that they choose".into(), reason, "give steps a size: one that fails is taken in increments");
    }
    if let Some(given) = model.initial_velocities.first() {
        let what = format!("the initial velocity of body \"{}\"", model.bodies[given.body].name);
        return refused(what, "nothing has a velocity in an equilibrium", "leave it out, or take an integrator with inertia");
    }
    Ok(())
}
