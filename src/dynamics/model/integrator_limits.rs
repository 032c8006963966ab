//! Entities of a model that a time integrator does not support, checked before the first step.

use super::definitions::Model;
use super::error::ModelError;
use super::update_rules::GAP;
use crate::integrators::Scheme;

/// Refuses entities that an integrator does not support; `chooses_size`: the step size is adaptive.
///
/// # Errors
/// First unsupported entity of the model.
pub fn check_integrator(model: &Model, integrator: &Scheme, chooses_size: bool) -> Result<(), ModelError> {
    if let Some(interaction) = model.interactions.iter().find(|one| one.restitution.is_some() && !integrator.solves_impacts()) {
        return Err(ModelError::NotTaken {
            steps: if integrator.is_static() { "steps without inertia" } else { "steps of this integrator" },
            what: format!("the restitution of contact \"{}\"", interaction.name),
            reason: "velocities do not jump between its steps",
            instead: "take `energy_momentum`, `energy_decaying`, `midpoint` or `backward_euler`",
        });
    }
    if integrator.lumping().is_some() {
        return check_explicit(model, chooses_size);
    }
    if integrator.is_static() {
        return check_static(model, chooses_size);
    }
    if integrator.goes_back() {
        return check_backward(model, chooses_size);
    }
    Ok(())
}

/// Refuses entities without a meaning in statics: chosen step sizes and initial velocities.
fn check_static(model: &Model, chooses_size: bool) -> Result<(), ModelError> {
    let refused = |what: String, reason, instead| Err(ModelError::NotTaken { steps: "steps without inertia", what, reason, instead });
    if chooses_size {
        let reason = "every equilibrium is exact, and no error grows from step to step";
        return refused("an automatic step size".into(), reason, "give steps a size: one that fails is taken in increments");
    }
    if let Some(given) = model.initial_velocities.first() {
        let what = format!("the initial velocity of body \"{}\"", model.bodies[given.body].name);
        return refused(what, "nothing has a velocity in an equilibrium", "leave it out, or take an integrator with inertia");
    }
    Ok(())
}

/// Refuses dissipation for integrators with a stage backward in time, where it would supply energy.
fn check_backward(model: &Model, chooses_size: bool) -> Result<(), ModelError> {
    let refused = |what: String, reason| {
        Err(ModelError::NotTaken { steps: "steps with a stage back in time", what, reason, instead: "take `energy_momentum`" })
    };
    if chooses_size {
        return refused("an automatic step size".into(), "errors of fourth order are not estimated");
    }
    let reason = "back in time it would give back the energy that it takes";
    if let Some(body) = model.bodies.iter().find(|body| !body.material.viscosity().is_none()) {
        return refused(format!("the viscous material of body \"{}\"", body.name), reason);
    }
    if let Some(part) = model.parts.iter().find(|part| part.dissipates()) {
        return refused(format!("\"{}\"", part.name()), reason);
    }
    if let Some(interaction) = model.interactions.iter().find(|interaction| interaction.friction.is_some()) {
        return refused(format!("friction of contact \"{}\"", interaction.name), reason);
    }
    if let Some(joint) = model.joints.iter().find(|joint| joint.friction.is_some()) {
        return refused(format!("friction of joint \"{}\"", joint.name), reason);
    }
    if let Some(interaction) = model.interactions.iter().find(|interaction| interaction.update.is_some_and(|rule| *rule == GAP)) {
        return refused(format!("the update rule `gap` of contact \"{}\"", interaction.name), reason);
    }
    Ok(())
}

/// Refuses entities that explicit steps do not support, such as constraints by equations.
fn check_explicit(model: &Model, chooses_size: bool) -> Result<(), ModelError> {
    let refused = |what: String, reason, instead| Err(ModelError::NotTaken { steps: "explicit steps", what, reason, instead });
    if chooses_size {
        let reason = "what bounds their size is the fastest vibration, not the error";
        return refused("an automatic step size".into(), reason, "give steps a size, nine tenths of the stable one");
    }
    let implicit = "take an integrator that solves equations, such as `energy_momentum`";
    if let Some(body) = model.bodies.iter().find(|body| body.rigid.is_some()) {
        let reason = "the constraints of its nodes are equations to be solved";
        return refused(
            format!("the rigid body \"{}\"", body.name),
            reason,
            "let it deform, as stiff as its cells allow, or take a rigid obstacle",
        );
    }
    if let Some(joint) = model.joints.first() {
        return refused(
            format!("joint \"{}\"", joint.name),
            "its constraints are equations to be solved",
            "join the points by stiff springs",
        );
    }
    if let Some(coupling) = model.couplings.first() {
        let what = format!("{} \"{}\"", coupling.kind.name(), coupling.name);
        return refused(what, "its constraints are equations to be solved", implicit);
    }
    for interaction in &model.interactions {
        let name = &interaction.name;
        if interaction.is_tie() {
            return refused(
                format!("tie \"{name}\""),
                "its constraints are equations to be solved",
                "make one mesh of the parts, or take another integrator",
            );
        }
        if interaction.equality {
            return refused(format!("the contact \"{name}\" that also pulls"), "its constraints are equations to be solved", implicit);
        }
        if interaction.friction.is_some() {
            return refused(format!("friction of contact \"{name}\""), "stick and slip follow from equations to be solved", implicit);
        }
        if interaction.update.is_some_and(|rule| *rule != GAP) {
            let reason = "gaps are held at the end of every step, and a closing takes the energy of its nodes";
            return refused(format!("the update rule of contact \"{name}\""), reason, "leave `update` out, or write `gap`");
        }
    }
    Ok(())
}
