//! What steps without equations do not take, before the first one.

use super::definitions::Model;
use super::error::ModelError;
use super::update_rules::GAP;

/// Refuses what explicit steps cannot do; `chooses_size`: whether steps are to choose their size.
///
/// # Errors
/// The first such thing of the model.
pub fn check_explicit(model: &Model, chooses_size: bool) -> Result<(), ModelError> {
    let steps = "explicit steps";
    let refused = |what: String, reason: &'static str, instead: &'static str| Err(ModelError::NotTaken { steps, what, reason, instead });
    if chooses_size {
        let reason = "what bounds their size is the fastest vibration, not the error";
        return refused("steps that choose their size".into(), reason, "give steps a size, nine tenths of the stable one");
    }
    let implicit = "take an integrator that solves equations, such as `energy_momentum`";
    if let Some(body) = model.bodies.iter().find(|body| body.rigid.is_some()) {
        let reason = "what holds its nodes together are equations";
        return refused(
            format!("the rigid body \"{}\"", body.name),
            reason,
            "let it deform, as stiff as its cells allow, or take a rigid obstacle",
        );
    }
    if let Some(joint) = model.joints.first() {
        return refused(format!("joint \"{}\"", joint.name), "what it holds are equations", "join the points by stiff springs");
    }
    for interaction in &model.interactions {
        let name = &interaction.name;
        if interaction.is_tie() {
            return refused(
                format!("tie \"{name}\""),
                "what it holds are equations",
                "make one mesh of the parts, or take another integrator",
            );
        }
        if interaction.equality {
            return refused(format!("the contact \"{name}\" that also pulls"), "what it holds are equations", implicit);
        }
        if interaction.friction.is_some() {
            return refused(format!("friction of contact \"{name}\""), "whether nodes stick follows from equations of the step", implicit);
        }
        if interaction.update.is_some_and(|rule| *rule != GAP) {
            let reason = "gaps are held at the end of every step, and a closing takes the energy of its nodes";
            return refused(format!("the update rule of contact \"{name}\""), reason, "leave `update` out, or write `gap`");
        }
    }
    Ok(())
}
