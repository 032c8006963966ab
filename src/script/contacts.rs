//! Contact in scripts: methods, pairs of surfaces, rigid obstacles, surfaces that touch themselves, ties.
//!
//! Every call that adds a pair checks the model at once. What is only suspicious (a surface that faces away, a tie that holds nothing) is
//! told by `model.check()` and warned of by `simulate`.

use std::sync::LazyLock;

use rhai::{Array, Dynamic};

use super::arguments::{Argument, Arguments, Call, Options, describe};
use super::failure::Failure;
use super::models::{BoundaryHandle, ModelData, ModelHandle, PLATE, body_boundary, boundary_of, change, example, vector_text};
use super::registry::{Absent, Form, Function, Handle, Kind, Parameter, Topic, body, number_text};
use crate::contact::Obstacle;
use crate::dynamics::{
    Amplitude, BodyBoundary, ContactDefinition, ContactMethod, Enforcement, ObstacleDefinition, SelfContactDefinition, TieDefinition,
    UpdateRule,
};
use crate::math::catalogue::Interval;

/// A contact method.
#[derive(Clone)]
pub struct ContactMethodHandle(pub ContactMethod);

impl Handle for ContactMethodHandle {
    const NAME: &'static str = "ContactMethod";

    fn describe(&self) -> String {
        format!("{}()", self.0.name())
    }
}

/// A rigid obstacle with its motion.
#[derive(Clone)]
pub struct ObstacleHandle {
    obstacle: Obstacle,
    motion: [Option<Amplitude>; 2],
}

impl Handle for ObstacleHandle {
    const NAME: &'static str = "Obstacle";

    fn describe(&self) -> String {
        let shape = match &self.obstacle {
            Obstacle::HalfPlane { point, normal } => format!("plane through {} with normal {}", vector_text(point), vector_text(normal)),
            Obstacle::Disk { center, radius } => format!("disk of radius {} around {}", number_text(*radius), vector_text(center)),
            Obstacle::Ring { center, radius } => format!("ring of inner radius {} around {}", number_text(*radius), vector_text(center)),
            Obstacle::Polyline { points } => format!("polyline through {} points", points.len()),
        };
        let moved = ["x", "y"].iter().zip(&self.motion).filter_map(|(name, motion)| Some((name, motion.as_ref()?)));
        let moved: Vec<String> = moved.map(|(name, motion)| format!("{name}: {}", motion.describe())).collect();
        if moved.is_empty() { format!("rigid {shape}") } else { format!("rigid {shape}, moving by {}", moved.join(", ")) }
    }
}

/// A second body under that of the examples' model, and contact between the two.
const TOUCH: &str = "let table = press.add_body(\"table\", rectangle(#{ size: [4.0, 1.0], cells: [9, 2], origin: [-1.0, -1.0] }), steel);\n\
     press.add_contact(\"foot\", #{ secondary: plate.boundary(\"bottom\"), primary: table.boundary(\"top\"), method: mortar() });\n";

/// An example with a simulation of two bodies in contact.
pub fn contact_example(line: &str) -> std::borrow::Cow<'static, str> {
    format!("{PLATE}{TOUCH}let sim = simulate(press, #{{ integrator: energy_momentum(), dt: 0.001 }});\n{line}").into()
}

/// One line for each contact pair of a model, as its handle prints them.
pub fn describe_contacts(data: &ModelData) -> Vec<String> {
    let model = &data.model;
    let named = |on: &BodyBoundary| format!("\"{}\"", model.boundary_name(on));
    let mut lines = Vec::new();
    for contact in &model.contacts {
        let primary: Vec<String> = contact.primary.iter().map(named).collect();
        let kind = if contact.equality { "bilateral contact" } else { "contact" };
        let (secondary, primary) = (named(&contact.secondary), super::failure::joined(&primary, "and"));
        lines.push(format!("  {kind} \"{}\": secondary {secondary}, primary {primary}", contact.name));
    }
    lines.extend(
        model.self_contacts.iter().map(|contact| format!("  contact \"{}\": {} with itself", contact.name, named(&contact.surface))),
    );
    lines.extend(model.obstacles.iter().map(|contact| {
        let obstacle = ObstacleHandle { obstacle: contact.obstacle.clone(), motion: contact.motion.clone() };
        format!("  contact \"{}\": secondary {}, {}", contact.name, named(&contact.secondary), obstacle.describe())
    }));
    lines.extend(model.ties.iter().map(|tie| {
        let (secondary, primary) = (named(&tie.secondary), named(&tie.primary));
        format!("  tie \"{}\": secondary {secondary}, primary {primary}", tie.name)
    }));
    lines
}

/// Names of the update rules.
fn update_names() -> &'static [&'static str] {
    static NAMES: LazyLock<Vec<&str>> = LazyLock::new(|| UpdateRule::ALL.iter().map(|rule| rule.name()).collect());
    &NAMES
}

fn name_parameter() -> Parameter {
    Parameter::new("name", Kind::Text, "its name, unique in the model")
}

fn method_parameter() -> Parameter {
    Parameter::new("method", Kind::Handle(ContactMethodHandle::NAME), "how the conditions are discretized between two surfaces")
        .or(Absent::Means("`mortar()`"))
}

fn rule_parameters() -> [Parameter; 3] {
    [
        Parameter::new("update", Kind::Choice(update_names()), "the condition of a closed node over a step")
            .or(Absent::Text(UpdateRule::Gap.name())),
        Parameter::number("penalty", "1", Interval::Positive, "a stiffness, relative to a facet's, instead of multipliers")
            .or(Absent::Means("multipliers: the update rule holds exactly")),
        Parameter::number(
            "augmented_lagrange",
            "1",
            Interval::Positive,
            "an augmentation, relative to a node's stiffness in a step: multipliers found by iteration, 100 is a good value",
        )
        .or(Absent::Means("multipliers found by solving for them")),
    ]
}

fn method_of(options: &Options) -> Result<ContactMethod, Failure> {
    let method = options.argument("method");
    Ok(if method.is_given() { method.handle::<ContactMethodHandle>()?.0 } else { ContactMethod::Mortar })
}

fn rules_of(options: &Options) -> Result<(UpdateRule, Enforcement), Failure> {
    let name = options.text("update")?;
    let update = UpdateRule::ALL.iter().copied().find(|rule| rule.name() == name).unwrap_or(UpdateRule::Gap);
    let augmented = options.argument("augmented_lagrange");
    let enforcement = match (options.optional_number("penalty")?, options.optional_number("augmented_lagrange")?) {
        (None, None) => Enforcement::Multiplier,
        (Some(factor), None) => Enforcement::Penalty { factor },
        (None, Some(factor)) => Enforcement::AugmentedLagrange { factor },
        (Some(_), Some(_)) => {
            let failure = augmented.fail("`penalty` and `augmented_lagrange` exclude each other");
            return Err(failure.hint("leave one of them out: `penalty` allows a small penetration, `augmented_lagrange` none"));
        }
    };
    Ok((update, enforcement))
}

/// The other side of a contact.
enum Partner {
    Surfaces(Vec<BodyBoundary>),
    Obstacle(ObstacleHandle),
}

fn partner_of(call: &Call, argument: &Argument, model: &ModelHandle) -> Result<Partner, Failure> {
    let value = argument.value();
    if let Some(obstacle) = value.clone().try_cast::<ObstacleHandle>() {
        return Ok(Partner::Obstacle(obstacle));
    }
    if let Some(boundary) = value.clone().try_cast::<BoundaryHandle>() {
        return Ok(Partner::Surfaces(vec![body_boundary(argument, boundary, model)?]));
    }
    let Some(entries) = value.read_lock::<Array>() else { return Err(argument.wrong_type()) };
    let mut surfaces = Vec::new();
    for entry in entries.iter() {
        let Some(boundary) = entry.clone().try_cast::<BoundaryHandle>() else {
            let failure = argument.fail(format!("every entry of {} must be a Boundary", argument.title()));
            let failure = failure.label(format!("this contains {}", describe(call.engine(), entry)));
            return Err(failure.hint("write `[first.boundary(\"top\"), second.boundary(\"top\")]`; an obstacle is a contact of its own"));
        };
        surfaces.push(body_boundary(argument, boundary, model)?);
    }
    if surfaces.is_empty() {
        let failure = argument.fail(format!("{} is empty", argument.title()));
        return Err(failure.hint("name at least one boundary of a body"));
    }
    Ok(Partner::Surfaces(surfaces))
}

/// The functions of this topic that concern models; what a simulation says about contact stands with the simulations.
pub fn functions() -> Vec<Function> {
    let method = |method: &ContactMethod| {
        let method = *method;
        Function {
            name: method.name(),
            form: Form::Function,
            topic: Topic::Contact,
            summary: method.summary(),
            parameters: Vec::new(),
            returns: ContactMethodHandle::NAME,
            example: format!("print({}());", method.name()).into(),
            see_also: &["add_contact"],
            body: body(move |_| Ok(Dynamic::from(ContactMethodHandle(method)))),
        }
    };
    let mut all: Vec<Function> = ContactMethod::ALL.iter().map(method).collect();
    all.extend(obstacles());
    all.extend([add_contact(), add_self_contact(), tie()]);
    all
}

fn motion_parameter() -> Parameter {
    let component = |name| Parameter::new(name, Kind::Amplitude, "the displacement in this direction over time").of("length");
    let components = ["x", "y"].map(|name| component(name).or(Absent::Means("none"))).into();
    Parameter::new("motion", Kind::Options(components), "how the obstacle is displaced over time; it does not turn")
        .or(Absent::Means("at rest"))
}

fn obstacles() -> Vec<Function> {
    let function = |name: &'static str,
                    summary: &'static str,
                    mut keys: Vec<Parameter>,
                    example: &'static str,
                    make: fn(&Call, &Options) -> Result<Obstacle, Failure>| {
        keys.push(motion_parameter());
        Function {
            name,
            form: Form::Function,
            topic: Topic::Contact,
            summary,
            parameters: vec![Parameter::new("options", Kind::Options(keys), "shape, place and motion")],
            returns: ObstacleHandle::NAME,
            example: example.into(),
            see_also: &["add_contact", "rigid_plane", "rigid_disk", "rigid_ring", "rigid_polyline"],
            body: body(move |call| {
                let options = call.options("options")?;
                let obstacle = make(call, &options)?;
                let nested = options.nested("motion")?;
                let mut motion = [None, None];
                for (motion, name) in motion.iter_mut().zip(["x", "y"]) {
                    let argument = nested.argument(name);
                    if argument.is_given() {
                        *motion = Some(argument.amplitude()?.0);
                    }
                }
                Ok(Dynamic::from(ObstacleHandle { obstacle, motion }))
            }),
        }
    };
    let point = |name, summary| Parameter::new(name, Kind::Vector, summary).of("length");
    let radius = |summary| Parameter::number("radius", "length", Interval::Positive, summary);
    vec![
        function(
            "rigid_plane",
            "a rigid half plane as the other side of a contact",
            vec![
                point("point", "a point of its border"),
                Parameter::new("normal", Kind::Vector, "the outward normal of its border, of any length: bodies are on that side").of("1"),
            ],
            "let ground = rigid_plane(#{ point: [0.0, 0.0], normal: [0.0, 1.0] });",
            |_, options| {
                let (point, argument) = (options.argument("point").vector(2)?, options.argument("normal"));
                let normal = argument.vector(2)?;
                if normal == [0.0; 3] {
                    let failure = argument.fail(format!("{} has no direction", argument.title()));
                    return Err(failure.label("this has length 0").hint("give the direction away from the plane, such as `[0.0, 1.0]`"));
                }
                Ok(Obstacle::HalfPlane { point: [point[0], point[1]], normal: [normal[0], normal[1]] })
            },
        ),
        function(
            "rigid_disk",
            "a rigid disk as the other side of a contact; bodies are outside of it",
            vec![point("center", "its center"), radius("its radius")],
            "let roller = rigid_disk(#{ center: [0.0, 2.0], radius: 0.5, motion: #{ y: ramp(0.0, 1.0, -0.7) } });",
            |_, options| {
                let center = options.argument("center").vector(2)?;
                Ok(Obstacle::Disk { center: [center[0], center[1]], radius: options.number("radius")? })
            },
        ),
        function(
            "rigid_ring",
            "a rigid ring as the other side of a contact; bodies are inside of it",
            vec![point("center", "its center"), radius("its inner radius")],
            "let drum = rigid_ring(#{ center: [0.0, 0.0], radius: 2.0 });",
            |_, options| {
                let center = options.argument("center").vector(2)?;
                Ok(Obstacle::Ring { center: [center[0], center[1]], radius: options.number("radius")? })
            },
        ),
        function(
            "rigid_polyline",
            "straight rigid facets as the other side of a contact: the obstacle is on the left of the way through the points",
            vec![Parameter::new("points", Kind::Array, "an array of points `[x, y]`; closed when the last is the first").of("length")],
            "let stairs = rigid_polyline(#{ points: [[4.0, 0.0], [2.0, 0.0], [2.0, 0.5], [0.0, 0.5]] });",
            |_, options| {
                let argument = options.argument("points");
                let points = argument.points()?;
                if points.len() < 2 {
                    let failure = argument.fail(format!("{} must have at least 2 points", argument.title()));
                    return Err(failure.label(format!("this has {}", points.len())).hint("name the ends of at least one facet"));
                }
                if let Some(twice) = points.windows(2).find(|pair| pair[0] == pair[1]) {
                    let failure = argument.fail(format!("{} has a facet of length 0", argument.title()));
                    return Err(failure.label(format!("{} comes twice in a row", vector_text(&twice[0]))).hint("leave out one of the two"));
                }
                Ok(Obstacle::Polyline { points })
            },
        ),
    ]
}

fn add_contact() -> Function {
    let [update, penalty, augmented] = rule_parameters();
    Function {
        name: "add_contact",
        form: Form::Method(ModelHandle::receiver()),
        topic: Topic::Contact,
        summary: "lets a boundary touch others, or a rigid obstacle, without friction",
        parameters: vec![
            name_parameter(),
            Parameter::new(
                "options",
                Kind::Options(vec![
                    Parameter::new(
                        "secondary",
                        Kind::Handle(BoundaryHandle::NAME),
                        "the side that carries the contact pressure (slave, nonmortar)",
                    ),
                    Parameter::new(
                        "primary",
                        Kind::Either("a Boundary, an array of them, or an Obstacle"),
                        "the other side (master, mortar): one boundary, several of them as one surface, or a rigid obstacle",
                    ),
                    method_parameter(),
                    update,
                    penalty,
                    augmented,
                    Parameter::new(
                        "equality",
                        Kind::Flag,
                        "whether every covered node is closed and tension allowed (the bilateral constraints of the paper)",
                    )
                    .or(Absent::Flag(false)),
                ]),
                "sides and method",
            ),
        ],
        returns: "",
        example: example(&format!(
            "{TOUCH}press.add_contact(\"lid\", #{{ secondary: plate.boundary(\"top\"), primary: rigid_plane(#{{ point: [0.0, 1.1], \
             normal: [0.0, -1.0] }}) }});"
        )),
        see_also: &["mortar", "rigid_plane", "add_self_contact", "tie"],
        body: body(|call| {
            let model = call.receiver::<ModelHandle>();
            let (name, options) = (call.text("name")?, call.options("options")?);
            let secondary = boundary_of(&options.argument("secondary"), &model)?;
            let partner = partner_of(call, &options.argument("primary"), &model)?;
            let method = method_of(&options)?;
            let ((update, enforcement), equality) = (rules_of(&options)?, options.flag("equality")?);
            let note = (name.clone(), call.place(&Default::default()));
            match partner {
                Partner::Surfaces(primary) => change(call, &model, |data| {
                    data.model.contacts.push(ContactDefinition { name, secondary, primary, method, update, enforcement, equality });
                    data.contacts.push(note);
                })?,
                Partner::Obstacle(ObstacleHandle { obstacle, motion }) => {
                    let argument = options.argument("method");
                    if argument.is_given() {
                        let failure = argument.fail(format!("{} has no meaning for a rigid obstacle", argument.title()));
                        let failure = failure.cause("an obstacle has no facets to integrate over: the gap of a node is its distance");
                        return Err(failure.hint("leave the option out").into());
                    }
                    change(call, &model, |data| {
                        let definition = ObstacleDefinition { name, secondary, obstacle, motion, update, enforcement, equality };
                        data.model.obstacles.push(definition);
                        data.contacts.push(note);
                    })?;
                }
            }
            Ok(Dynamic::UNIT)
        }),
    }
}

fn add_self_contact() -> Function {
    let [update, penalty, augmented] = rule_parameters();
    Function {
        name: "add_self_contact",
        form: Form::Method(ModelHandle::receiver()),
        topic: Topic::Contact,
        summary: "lets a boundary touch itself without friction where it folds",
        parameters: vec![
            name_parameter(),
            Parameter::new(
                "options",
                Kind::Options(vec![
                    Parameter::new("surface", Kind::Handle(BoundaryHandle::NAME), "the boundary that may touch itself"),
                    method_parameter(),
                    update,
                    penalty,
                    augmented,
                ]),
                "surface and method",
            ),
        ],
        returns: "",
        example: example("press.add_self_contact(\"fold\", #{ surface: plate.boundary(\"top\") });"),
        see_also: &["add_contact"],
        body: body(|call| {
            let model = call.receiver::<ModelHandle>();
            let (name, options) = (call.text("name")?, call.options("options")?);
            let surface = boundary_of(&options.argument("surface"), &model)?;
            let (method, (update, enforcement)) = (method_of(&options)?, rules_of(&options)?);
            let note = (name.clone(), call.place(&Default::default()));
            change(call, &model, |data| {
                data.model.self_contacts.push(SelfContactDefinition { name, surface, method, update, enforcement });
                data.contacts.push(note);
            })?;
            Ok(Dynamic::UNIT)
        }),
    }
}

fn tie() -> Function {
    Function {
        name: "tie",
        form: Form::Method(ModelHandle::receiver()),
        topic: Topic::Contact,
        summary: "holds two boundaries together although their meshes do not match",
        parameters: vec![
            name_parameter(),
            Parameter::new(
                "options",
                Kind::Options(vec![
                    Parameter::new("secondary", Kind::Handle(BoundaryHandle::NAME), "the side with the multipliers, better the finer one"),
                    Parameter::new("primary", Kind::Handle(BoundaryHandle::NAME), "the other side"),
                    Parameter::number("reach", "length", Interval::Positive, "the distance at rest within which the two are tied")
                        .or(Absent::Means("half of the shortest secondary facet")),
                ]),
                "sides",
            ),
        ],
        returns: "",
        example: example(
            "let lid = press.add_body(\"lid\", rectangle(#{ size: [2.0, 0.5], cells: [7, 1], origin: [0.0, 1.0] }), steel);\n\
             press.tie(\"weld\", #{ secondary: lid.boundary(\"bottom\"), primary: plate.boundary(\"top\") });",
        ),
        see_also: &["add_contact"],
        body: body(|call| {
            let model = call.receiver::<ModelHandle>();
            let (name, options) = (call.text("name")?, call.options("options")?);
            let secondary = boundary_of(&options.argument("secondary"), &model)?;
            let primary = boundary_of(&options.argument("primary"), &model)?;
            let reach = options.optional_number("reach")?;
            let note = (name.clone(), call.place(&Default::default()));
            change(call, &model, |data| {
                data.model.ties.push(TieDefinition { name, secondary, primary, reach });
                data.contacts.push(note);
            })?;
            Ok(Dynamic::UNIT)
        }),
    }
}
