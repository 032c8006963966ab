//! Contact methods, and the rules by which contact is enforced, as options of a pair.

use std::sync::LazyLock;

use super::obstacles::ObstacleHandle;
use crate::contact::{ContactMethod, FacetShape, METHODS, MORTAR, Obstacle};
use crate::dynamics::{Enforcement, UPDATE_RULES, UpdateRule};
use crate::script::language::prelude::*;

/// A contact method.
#[derive(Clone)]
pub struct ContactMethodHandle(pub &'static ContactMethod);

impl Handle for ContactMethodHandle {
    const NAME: &'static str = "ContactMethod";
    const MAKER: &'static str = "make one with `mortar()`, `dual_mortar()`, `averaged_mortar()` or `node_to_segment()`";

    fn describe(&self) -> String {
        format!("{}()", self.0.name)
    }
}

/// Script functions that select the contact methods, one for each method.
pub fn functions() -> Vec<Function> {
    METHODS.iter().copied().map(method_function).collect()
}

fn method_function(method: &'static ContactMethod) -> Function {
    function(Topic::Contact, method.name)
        .summary(method.summary)
        .see_also(&["add_contact"])
        .example(format!("print({}());", method.name))
        .body(move |_| Ok(ContactMethodHandle(method)))
}

/// Names of the update rules.
fn update_names() -> &'static [&'static str] {
    static NAMES: LazyLock<Vec<&str>> = LazyLock::new(|| UPDATE_RULES.iter().map(|rule| rule.name).collect());
    &NAMES
}

/// Description of the option `method`.
pub fn method_parameter() -> Parameter {
    Parameter::object::<ContactMethodHandle>("method", "how the conditions are discretized between two surfaces").otherwise("`mortar()`")
}

/// Description of the option `facets`.
pub fn facets_parameter() -> Parameter {
    Parameter::new(
        "facets",
        Kind::Choice(&["curved", "straight"]),
        "the geometry between nodes: the curve, or curved surface, through them, or straight lines and flat facets; on obstacles, whether \
         arcs, spheres and cylinders of a rigid body roll as round or node by node, and whether curves of a deformable body in the plane \
         touch planes, disks and rings between the nodes, too; whether whole circles and spheres of two rigid bodies \
         touch as such",
    )
    .otherwise("`\"curved\"`; with `node_to_segment()` in the plane, and for deformable bodies on obstacles in the plane, `\"straight\"`")
}

/// Facet geometry named in the options.
pub fn facets_of(options: &Options) -> Result<Option<FacetShape>, Failure> {
    let shape = |word: String| if word == "straight" { FacetShape::Straight } else { FacetShape::Curved };
    if options.argument("facets").is_given() { options.text("facets").map(shape).map(Some) } else { Ok(None) }
}

/// Descriptions of the options `secondary_shape` and `primary_shape`.
pub fn shape_parameters() -> [Parameter; 2] {
    let secondary = "the exact shape of the secondary side, given as the obstacle with that border: `rigid_disk` or `rigid_ring` for a \
                     circle, `rigid_plane`, `rigid_sphere`, `rigid_cylinder`, `rigid_cone`, `rigid_torus`; all nodes of the side lie on it";
    let primary = "the exact shape of the primary side, as `secondary_shape`";
    [("secondary_shape", secondary), ("primary_shape", primary)]
        .map(|(name, summary)| Parameter::object::<ObstacleHandle>(name, summary).otherwise("the curve through the nodes"))
}

/// Exact shapes of both sides named in the options. An obstacle as partner has a shape already.
///
/// With an obstacle, only the shape of a secondary side whose nodes touch with arcs (`has_arcs`) has a meaning.
pub fn shapes_of(options: &Options, has_obstacle: bool, has_arcs: bool) -> Result<[Option<Obstacle>; 2], Failure> {
    let mut shapes = [None, None];
    for (shape, name) in shapes.iter_mut().zip(["secondary_shape", "primary_shape"]) {
        let argument = options.argument(name);
        if !argument.is_given() {
            continue;
        }
        if has_obstacle && !(has_arcs && name == "secondary_shape") {
            let failure = argument.wrong(causes::BODY_KIND, "has no meaning for a rigid obstacle");
            let failure = failure.cause("contact with an obstacle is at the nodes of the body, and the obstacle is exact");
            return Err(failure.hint("leave the option out"));
        }
        let ObstacleHandle { obstacle, motion, turn } = argument.handle::<ObstacleHandle>()?;
        if motion.iter().any(Option::is_some) || turn.is_some() {
            let failure = argument.fail(format!("{} moves", argument.title()));
            return Err(failure.hint("leave the motion out: the shape belongs to the undeformed body, and moves with it"));
        }
        *shape = Some(obstacle);
    }
    Ok(shapes)
}

/// Descriptions of the options `update`, `penalty` and `augmented_lagrange`.
pub fn rule_parameters() -> [Parameter; 3] {
    [
        Parameter::new(
            "update",
            Kind::Choice(update_names()),
            "the update rule: the condition on the gap of an active node at the end of a step",
        )
        .otherwise("`\"persistency\"` with an integrator that keeps the energy, `\"gap\"` with others"),
        Parameter::number(
            "penalty",
            "1",
            Interval::Positive,
            "a stiffness instead of multipliers: the pressure is `penalty * E / h` times the depth, with Young's modulus E and the \
             shortest facet h of the secondary body",
        )
        .otherwise("multipliers: the update rule holds exactly"),
        Parameter::number(
            "augmented_lagrange",
            "1",
            Interval::Positive,
            "an augmentation, relative to a node's stiffness in a step: multipliers found by iteration, 100 is a good value",
        )
        .otherwise("multipliers found by solving for them"),
    ]
}

/// Contact method named in the options.
pub fn chosen_method(options: &Options) -> Result<&'static ContactMethod, Failure> {
    let method = options.argument("method");
    Ok(if method.is_given() { method.handle::<ContactMethodHandle>()?.0 } else { &MORTAR })
}

/// Enforcement and update rule named in the options.
pub fn rules_of(options: &Options) -> Result<(Option<&'static UpdateRule>, Enforcement), Failure> {
    let given = options.argument("update");
    let name = if given.is_given() { options.text("update")? } else { String::new() };
    let update = UPDATE_RULES.iter().copied().find(|rule| rule.name == name);
    let augmented = options.argument("augmented_lagrange");
    let enforcement = match (options.optional_number("penalty")?, options.optional_number("augmented_lagrange")?) {
        (None, None) => Enforcement::Multiplier,
        (Some(factor), None) => Enforcement::Penalty { factor },
        (None, Some(factor)) => Enforcement::AugmentedLagrange { factor },
        (Some(_), Some(_)) => {
            let failure = augmented.refuse(causes::OPTIONS_TOGETHER, "`penalty` and `augmented_lagrange` exclude each other");
            return Err(failure.hint("leave one of them out: `penalty` allows a small penetration, `augmented_lagrange` none"));
        }
    };
    Ok((update, enforcement))
}
