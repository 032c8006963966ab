//! Options of a joint for dry friction.

use crate::dynamics::{Coordinate, JointDefinition, JointFriction};
use crate::script::language::causes;
use crate::script::language::digits::number_text;
use crate::script::language::prelude::*;

/// Parameters for the friction of a joint.
pub fn friction_options() -> Vec<Parameter> {
    vec![
        Parameter::number(
            "friction",
            "1",
            Interval::NonNegative,
            "the coefficient of dry friction: of a slider or a slot times the reaction across its line, of a hinge or a `point` times the \
             reaction and `radius`, of a link or a cable times `preload`",
        )
        .otherwise("no friction by the reaction"),
        Parameter::number(
            "radius",
            "length",
            Interval::Positive,
            "the radius of the bearing or ball at which the friction of a hinge or `point` acts",
        )
        .otherwise("the joint does not turn, or has no `friction`"),
        Parameter::number(
            "preload",
            "force",
            Interval::NonNegative,
            "the force that presses the sliding surfaces together in addition to the reaction, as in a clamped bearing; with `friction`",
        )
        .or(0.0),
        Parameter::number(
            "friction_moment",
            "force * length",
            Interval::NonNegative,
            "the constant dry friction of a hinge or a `point`, whatever the reaction, in space about any axis: a seal, `frictionloss` of \
             MuJoCo, the friction torque preload of Adams",
        )
        .or(0.0),
        Parameter::number(
            "friction_force",
            "force",
            Interval::NonNegative,
            "the constant dry friction of a slider or a slot, and along a cable or a link with `limits` or `drive`, whatever the reaction",
        )
        .or(0.0),
    ]
}

/// Friction of a joint; `None` if the options have none of the keys of friction.
pub fn friction_of(options: &Options, joint: &JointDefinition, dimension: usize) -> Result<Option<JointFriction>, Failure> {
    let given = |key: &str| options.argument(key).is_given();
    if !["friction", "radius", "preload", "friction_moment", "friction_force"].into_iter().any(given) {
        return Ok(None);
    }
    let refused = |key: &str, why: String, hint: &str| {
        let argument = options.argument(key);
        Err(argument.wrong(causes::OPTIONS_TOGETHER, why).hint(hint))
    };
    let rotates = joint.kind.rotates(dimension);
    let kind = joint.kind.name();
    match (rotates, joint.kind.coordinate(dimension)) {
        (true, _) if given("friction_force") => {
            return refused("friction_force", format!("is that of a travel, and a {kind} turns"), "give `friction_moment`");
        }
        (false, Some(Coordinate::Travel | Coordinate::Distance)) if given("friction_moment") => {
            return refused("friction_moment", format!("is that of an angle, and a {kind} moves along a line"), "give `friction_force`");
        }
        (false, _) if given("radius") => {
            return refused("radius", format!("has no meaning for a {kind}"), "leave it out: hinges and balls have a radius");
        }
        _ => {}
    }
    let number = |key: &str| Ok::<f64, Failure>(options.optional_number(key)?.unwrap_or(0.0));
    let friction = JointFriction {
        coefficient: number("friction")?,
        radius: number("radius")?,
        preload: number("preload")?,
        constant: number("friction_moment")? + number("friction_force")?,
    };
    if rotates && friction.coefficient > 0.0 && !given("radius") {
        let hint = "give the radius of the bearing, such as `radius: 0.01`; a friction moment that does not depend on the force is \
                    `friction_moment`";
        return refused("friction", "needs `radius`: the friction force acts at the radius of the bearing".into(), hint);
    }
    if let Some(key) = ["preload", "radius"].into_iter().find(|key| friction.coefficient == 0.0 && given(key)) {
        return refused(key, "needs `friction`, by which it is multiplied".into(), "give the coefficient, such as `friction: 0.2`");
    }
    Ok(Some(friction))
}

/// Friction of a joint in words, such as `friction 0.2 at the radius 0.01, constant 0.5`.
pub fn friction_text(friction: &JointFriction) -> String {
    let JointFriction { coefficient, radius, preload, constant } = *friction;
    let by_reaction = (coefficient > 0.0).then(|| format!("friction {}", number_text(coefficient)));
    let at = (coefficient > 0.0 && radius > 0.0).then(|| format!(" at the radius {}", number_text(radius)));
    let pressed = (preload > 0.0).then(|| format!(" with the preload {}", number_text(preload)));
    let first = by_reaction.map(|first| format!("{first}{}{}", at.unwrap_or_default(), pressed.unwrap_or_default()));
    let second = (constant > 0.0).then(|| format!("constant friction {}", number_text(constant)));
    first.into_iter().chain(second).collect::<Vec<_>>().join(", ")
}
