//! Models in scripts: bodies, boundaries, supports, loads; contact pairs stand in `contacts`.
//!
//! Every call that adds something checks the model at once, so that a defect is reported where it was written. The handle keeps the
//! places of loads and contact pairs for the warnings at the end of a run.

use std::cell::RefCell;
use std::rc::Rc;

use rhai::{Array, Dynamic};

use super::arguments::{Argument, Arguments, Call, Options};
use super::failure::Failure;
use super::materials::MaterialHandle;
use super::meshes::{MeshHandle, condition_parameters, describe_mesh, named_boundary, with_boundary_where};
use super::registry::{Absent, Form, Function, Handle, Kind, Parameter, Receiver, Topic, body, number_text};
use super::scan::Target;
use super::sources::Place;
use super::time_functions::{TimeFunctionHandle, Watched};
use crate::contact::Finding;
use crate::dynamics::{Amplitude, BodyBoundary, BodyDefinition, InitialVelocity, Load, LoadKind, Model, Prescription, Support};
use crate::math::catalogue::Interval;
use crate::mesh::{Boundary, Mesh};

/// A load with its place in the script, for the warning that it never acted.
#[derive(Clone)]
pub struct LoadNote {
    /// What it is, such as `torque on "inner ring.inner"`.
    pub title: String,
    /// Where it was written.
    pub place: Option<Place>,
    /// Its time function.
    pub amplitude: Rc<Watched>,
}

/// A model under construction, with the places of what it consists of.
#[derive(Clone, Default)]
pub struct ModelData {
    /// The model.
    pub model: Model,
    /// One for each load.
    pub loads: Vec<LoadNote>,
    /// One for each contact pair: its name, and where it was written.
    pub contacts: Vec<(String, Option<Place>)>,
    /// Whether a simulation was made of it.
    pub is_simulated: bool,
    /// Name and place of the first change that no simulation has seen, once there is one.
    pub unseen: Option<(String, Option<Place>)>,
}

impl ModelData {
    /// Where the contact pair of that name was written.
    pub fn place_of_contact(&self, name: &str) -> Option<Place> {
        self.contacts.iter().find(|(known, _)| known == name).and_then(|(_, place)| place.clone())
    }
}

/// A model in a script.
#[derive(Clone)]
pub struct ModelHandle(pub Rc<RefCell<ModelData>>);

/// A body of a model.
#[derive(Clone)]
pub struct BodyHandle {
    /// Its model.
    pub model: ModelHandle,
    /// Its index there.
    pub index: usize,
}

/// A boundary of a mesh, or of a body when it belongs to one.
#[derive(Clone)]
pub struct BoundaryHandle {
    body: Option<BodyHandle>,
    mesh: Rc<Mesh>,
    boundary: Boundary,
}

impl Handle for ModelHandle {
    const NAME: &'static str = "Model";

    fn describe(&self) -> String {
        let data = self.0.borrow();
        let model = &data.model;
        let mut lines = vec![format!("model \"{}\"", model.name)];
        lines.extend(model.bodies.iter().map(|body| format!("  body \"{}\": {}", body.name, describe_mesh(&body.mesh))));
        lines.extend(model.supports.iter().map(|support| {
            let names = ["x", "y", "z"].into_iter().zip(support.components).take(model.dimension()).filter(|(_, held)| *held);
            format!("  fixed \"{}\" in {}", model.boundary_name(&support.on), names.map(|(name, _)| name).collect::<Vec<_>>().join(", "))
        }));
        lines.extend(model.prescriptions.iter().map(|prescription| {
            let (component, boundary) = (["x", "y", "z"][prescription.component], model.boundary_name(&prescription.on));
            format!("  prescribed {component} of \"{boundary}\": {}", prescription.displacement.describe())
        }));
        lines.extend(data.loads.iter().map(|load| format!("  {}", load.title)));
        if model.gravity != [0.0; 3] {
            lines.push(format!("  gravity {}", vector_text(&model.gravity[..model.dimension()])));
        }
        lines.extend(super::contacts::describe_contacts(&data));
        lines.join("\n")
    }
}

impl Handle for BodyHandle {
    const NAME: &'static str = "Body";

    fn describe(&self) -> String {
        let body = self.definition();
        format!("body \"{}\": {}; {}", body.name, describe_mesh(&body.mesh), MaterialHandle(body.material.clone()).describe())
    }
}

impl Handle for BoundaryHandle {
    const NAME: &'static str = "Boundary";

    fn describe(&self) -> String {
        let measure = self.mesh.boundary_measure(&self.boundary);
        let (word, facets) = (if self.mesh.dimension() == 2 { "length" } else { "area" }, self.boundary.facets.len());
        format!("boundary \"{}\" of {facets} facets and {word} {}", self.title(), number_text(measure))
    }
}

impl BodyHandle {
    /// The body as the model has it.
    pub fn definition(&self) -> BodyDefinition {
        self.model.0.borrow().model.bodies[self.index].clone()
    }
}

impl BoundaryHandle {
    fn title(&self) -> String {
        match &self.body {
            Some(body) => format!("{}.{}", body.definition().name, self.boundary.name),
            None => self.boundary.name.clone(),
        }
    }
}

/// `[1, 0.5]`.
pub fn vector_text(vector: &[f64]) -> String {
    let numbers: Vec<String> = vector.iter().map(|value| number_text(*value)).collect();
    format!("[{}]", numbers.join(", "))
}

/// The boundary an argument means, which must be one of a body of this model.
///
/// # Errors
/// Another type, a boundary of a mesh, or of another model.
pub fn boundary_of(argument: &Argument, model: &ModelHandle) -> Result<BodyBoundary, Failure> {
    body_boundary(argument, argument.handle()?, model)
}

/// A boundary that an argument contains, which must be one of a body of this model.
///
/// # Errors
/// A boundary of a mesh, or of another model.
pub fn body_boundary(argument: &Argument, handle: BoundaryHandle, model: &ModelHandle) -> Result<BodyBoundary, Failure> {
    let Some(body) = &handle.body else {
        let failure = argument.fail(format!("{} must be a boundary of a body, not of a mesh", argument.title()));
        let failure = failure.label(format!("this is boundary \"{}\" of a mesh", handle.boundary.name));
        return Err(failure.hint(format!("take it from the body that `add_body` gave: `body.boundary(\"{}\")`", handle.boundary.name)));
    };
    check_model(argument, model, body)?;
    Ok(BodyBoundary { body: body.index, boundary: handle.boundary })
}

fn body_of(argument: &Argument, model: &ModelHandle) -> Result<BodyHandle, Failure> {
    let body: BodyHandle = argument.handle()?;
    check_model(argument, model, &body)?;
    Ok(body)
}

fn check_model(argument: &Argument, model: &ModelHandle, body: &BodyHandle) -> Result<(), Failure> {
    if Rc::ptr_eq(&body.model.0, &model.0) {
        return Ok(());
    }
    let (name, theirs) = (body.definition().name, body.model.0.borrow().model.name.clone());
    let ours = model.0.borrow().model.name.clone();
    Err(argument
        .fail(format!("body \"{name}\" belongs to another model"))
        .label(format!("this belongs to model \"{theirs}\""))
        .cause(format!("the call adds to model \"{ours}\""))
        .hint("add the mesh to this model too: `model.add_body(name, mesh, material)`"))
}

/// Changes the model and checks it; a change that makes it wrong is taken back.
///
/// # Errors
/// What the change makes wrong.
pub fn change(call: &Call, handle: &ModelHandle, apply: impl FnOnce(&mut ModelData)) -> Result<(), Failure> {
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
            Err(call.fail(error.to_string()).hint(error.cure()))
        }
    }
}

fn add_load(call: &Call, kind: LoadKind, word: &str) -> Result<Dynamic, Failure> {
    let model = call.receiver::<ModelHandle>();
    let on = boundary_of(&call.argument("boundary"), &model)?;
    let TimeFunctionHandle(function) = call.argument("amplitude").amplitude()?;
    let title = format!("{word} on \"{}\" with amplitude {}", model.0.borrow().model.boundary_name(&on), function.describe());
    let amplitude = Rc::new(Watched::new(function));
    let note = LoadNote { title, place: call.place(&Default::default()), amplitude: amplitude.clone() };
    change(call, &model, |data| {
        let amplitude: Amplitude = amplitude;
        data.model.loads.push(Load { kind, on, amplitude });
        data.loads.push(note);
    })?;
    Ok(Dynamic::UNIT)
}

fn components(argument: &Argument, dimension: usize) -> Result<[bool; 3], Failure> {
    let mut held = [false; 3];
    if !argument.is_given() {
        held[..dimension].fill(true);
        return Ok(held);
    }
    let text = argument.text()?;
    let names = &["x", "y", "z"][..dimension];
    for letter in text.chars() {
        let Some(index) = names.iter().position(|name| name.chars().eq([letter])) else {
            let failure =
                argument.fail(format!("{} cannot be \"{text}\"", argument.title())).label(format!("`{letter}` is not a direction here"));
            let space = if dimension == 2 { "the model is plane" } else { "the model is spatial" };
            return Err(failure.cause(space).hint(format!("name the held directions, such as \"x\" or \"{}\"", names.concat())));
        };
        held[index] = true;
    }
    if held == [false; 3] {
        let failure = argument.fail(format!("{} names no direction", argument.title()));
        return Err(failure.hint("name the held directions, such as \"x\" or \"xy\", or leave the argument out to hold all"));
    }
    Ok(held)
}

/// An angular velocity: a number about the third axis, or in space a vector.
fn angular(options: &Options, dimension: usize) -> Result<[f64; 3], Failure> {
    let argument = options.argument("angular");
    match (argument.is_given(), dimension) {
        (false, _) => Ok([0.0; 3]),
        (true, 3) if argument.value().is_array() => argument.vector(3),
        (true, _) => Ok([0.0, 0.0, argument.number()?]),
    }
}

fn boundary_parameter() -> Parameter {
    Parameter::new("boundary", Kind::Handle(BoundaryHandle::NAME), "a boundary of one of the model's bodies")
}

fn amplitude_parameter() -> Parameter {
    Parameter::new("amplitude", Kind::Amplitude, "its size over time, as a factor").or(Absent::Number(1.0))
}

/// A model with one body for examples.
pub const PLATE: &str = "let steel = neo_hookean(#{ youngs_modulus: 1e5, poisson_ratio: 0.3, density: 1e-3 });\n\
     let press = model(\"press\");\n\
     let plate = press.add_body(\"plate\", rectangle(#{ size: [2.0, 1.0], cells: [4, 2] }), steel);\n";

/// An example that goes on from a model with one body.
pub fn example(line: &str) -> std::borrow::Cow<'static, str> {
    format!("{PLATE}{line}").into()
}

/// The functions of this topic.
pub fn functions() -> Vec<Function> {
    let mut all = model_functions();
    all.extend(loads());
    all.extend(body_functions());
    all
}

fn model_functions() -> Vec<Function> {
    let receiver = ModelHandle::receiver();
    vec![
        Function {
            name: "model",
            form: Form::Function,
            topic: Topic::Model,
            summary: "an empty model",
            parameters: vec![Parameter::new("name", Kind::Text, "its name, for messages and files")],
            returns: ModelHandle::NAME,
            example: "let bearing = model(\"bearing\");".into(),
            see_also: &["add_body", "simulate"],
            body: body(|call| {
                let data = ModelData { model: Model { name: call.text("name")?, ..Model::default() }, ..ModelData::default() };
                Ok(Dynamic::from(ModelHandle(Rc::new(RefCell::new(data)))))
            }),
        },
        Function {
            name: "add_body",
            form: Form::Method(receiver),
            topic: Topic::Model,
            summary: "adds a body to the model",
            parameters: vec![
                Parameter::new("name", Kind::Text, "its name, unique in the model"),
                Parameter::new("mesh", Kind::Handle(MeshHandle::NAME), "its mesh at rest"),
                Parameter::new("material", Kind::Handle(MaterialHandle::NAME), "its material"),
            ],
            returns: BodyHandle::NAME,
            example: example("print(plate);"),
            see_also: &["model", "fix", "add_contact"],
            body: body(|call| {
                let model = call.receiver::<ModelHandle>();
                let (name, mesh) = (call.text("name")?, call.handle::<MeshHandle>("mesh")?.mesh());
                let MaterialHandle(material) = call.handle("material")?;
                if let Err(error) = mesh.check() {
                    let failure = call.argument("mesh").fail(error.to_string()).label("the mesh cannot be computed with");
                    return Err(failure.hint(error.cure()).into());
                }
                change(call, &model, |data| data.model.bodies.push(BodyDefinition { name, mesh, material }))?;
                let index = model.0.borrow().model.bodies.len() - 1;
                Ok(Dynamic::from(BodyHandle { model, index }))
            }),
        },
        Function {
            name: "fix",
            form: Form::Method(receiver),
            topic: Topic::Model,
            summary: "holds the nodes of a boundary, in all directions or in some",
            parameters: vec![
                boundary_parameter(),
                Parameter::new("components", Kind::Text, "the held directions, such as \"x\" or \"xy\"")
                    .or(Absent::Means("all directions")),
            ],
            returns: "",
            example: example("press.fix(plate.boundary(\"left\"));\npress.fix(plate.boundary(\"bottom\"), \"y\");"),
            see_also: &["add_body"],
            body: body(|call| {
                let model = call.receiver::<ModelHandle>();
                let on = boundary_of(&call.argument("boundary"), &model)?;
                let dimension = model.0.borrow().model.dimension();
                let components = components(&call.argument("components"), dimension)?;
                change(call, &model, |data| data.model.supports.push(Support { on, components }))?;
                Ok(Dynamic::UNIT)
            }),
        },
        Function {
            name: "prescribe",
            form: Form::Method(receiver),
            topic: Topic::Model,
            summary: "moves the nodes of a boundary in given directions as time functions say",
            parameters: vec![
                boundary_parameter(),
                Parameter::new(
                    "displacements",
                    Kind::Options(
                        ["x", "y", "z"]
                            .map(|name| {
                                let free = Parameter::new(name, Kind::Amplitude, "the displacement in this direction over time");
                                free.of("length").or(Absent::Means("free"))
                            })
                            .into(),
                    ),
                    "displacements over time",
                ),
            ],
            returns: "",
            example: example("press.prescribe(plate.boundary(\"top\"), #{ y: ramp(0.0, 0.1, -0.05) });"),
            see_also: &["fix"],
            body: body(|call| {
                let model = call.receiver::<ModelHandle>();
                let (on, options) = (boundary_of(&call.argument("boundary"), &model)?, call.options("displacements")?);
                let dimension = model.0.borrow().model.dimension();
                let mut prescriptions = Vec::new();
                for (component, name) in ["x", "y", "z"].into_iter().enumerate() {
                    let argument = options.argument(name);
                    if !argument.is_given() {
                        continue;
                    }
                    if component >= dimension {
                        let failure = argument.fail("the model is plane: there is no direction `z`");
                        return Err(failure.hint("remove the option").into());
                    }
                    let displacement = argument.amplitude()?.0;
                    prescriptions.push(Prescription { on: on.clone(), component, displacement });
                }
                if prescriptions.is_empty() {
                    let failure = call.argument("displacements").fail("`prescribe` names no direction");
                    return Err(failure.hint("name one, such as `#{ y: ramp(0.0, 1.0, -0.1) }`; `fix` holds nodes where they are").into());
                }
                change(call, &model, |data| data.model.prescriptions.extend(prescriptions))?;
                Ok(Dynamic::UNIT)
            }),
        },
        Function {
            name: "gravity",
            form: Form::Method(receiver),
            topic: Topic::Model,
            summary: "sets the acceleration of gravity of all bodies",
            parameters: vec![Parameter::new("acceleration", Kind::Vector, "the acceleration").of("length/time^2")],
            returns: "",
            example: example("press.gravity([0.0, -9.81]);"),
            see_also: &["traction", "force"],
            body: body(|call| {
                let model = call.receiver::<ModelHandle>();
                let argument = call.argument("acceleration");
                let undecided =
                    model.0.borrow().model.bodies.is_empty() && argument.value().read_lock::<Array>().is_some_and(|array| array.len() == 3);
                let dimension = if undecided { 3 } else { model.0.borrow().model.dimension() };
                let gravity = argument.vector(dimension)?;
                change_without_bodies(call, &model, |data| data.model.gravity = gravity)?;
                Ok(Dynamic::UNIT)
            }),
        },
        Function {
            name: "initial_velocity",
            form: Form::Method(receiver),
            topic: Topic::Model,
            summary: "lets a body start with a velocity and a spin about its center of mass",
            parameters: vec![
                Parameter::new("body", Kind::Handle(BodyHandle::NAME), "the body"),
                Parameter::new(
                    "velocity",
                    Kind::Options(vec![
                        Parameter::new("linear", Kind::Vector, "the velocity of the center of mass")
                            .of("length/time")
                            .or(Absent::Means("at rest")),
                        Parameter::new(
                            "angular",
                            Kind::Number,
                            "the angular velocity, counter-clockwise; in space a vector is allowed too",
                        )
                        .of("1/time")
                        .or(Absent::Means("no spin")),
                    ]),
                    "the velocities",
                ),
            ],
            returns: "",
            example: example("press.initial_velocity(plate, #{ linear: [1.0, 0.0], angular: 2.0 });"),
            see_also: &["add_body"],
            body: body(|call| {
                let model = call.receiver::<ModelHandle>();
                let body = body_of(&call.argument("body"), &model)?;
                let options = call.options("velocity")?;
                let dimension = model.0.borrow().model.dimension();
                let linear = options.argument("linear");
                let linear = if linear.is_given() { linear.vector(dimension)? } else { [0.0; 3] };
                let angular = angular(&options, dimension)?;
                change(call, &model, |data| data.model.initial_velocities.push(InitialVelocity { body: body.index, linear, angular }))?;
                Ok(Dynamic::UNIT)
            }),
        },
        Function {
            name: "check",
            form: Form::Method(receiver),
            topic: Topic::Model,
            summary: "checks everything about the model that can be said without computing; gives what is suspicious about its \
                      contacts as an array of sentences",
            parameters: Vec::new(),
            returns: "Array",
            example: example("for finding in press.check() { print(finding); }"),
            see_also: &["simulate", "add_contact"],
            body: body(|call| {
                let model = call.receiver::<ModelHandle>();
                let model = &model.0.borrow().model;
                model.check().map_err(|error| call.fail(error.to_string()).hint(error.cure()))?;
                let sentence = |(contact, finding): (String, Finding)| format!("contact \"{contact}\": {finding}; {}", finding.cure());
                Ok(model.findings().into_iter().map(sentence).map(Dynamic::from).collect::<Array>().into())
            }),
        },
        member(receiver, "name", "the name of the model", "String", |call| {
            call.receiver::<ModelHandle>().0.borrow().model.name.clone().into()
        }),
        member(receiver, "bodies", "the bodies of the model, in the order in which they were added", "Array", |call| {
            let model = call.receiver::<ModelHandle>();
            let count = model.0.borrow().model.bodies.len();
            (0..count).map(|index| Dynamic::from(BodyHandle { model: model.clone(), index })).collect::<Array>().into()
        }),
    ]
}

/// A change that makes sense before there are bodies.
fn change_without_bodies(call: &Call, handle: &ModelHandle, apply: impl FnOnce(&mut ModelData)) -> Result<(), Failure> {
    if handle.0.borrow().model.bodies.is_empty() {
        apply(&mut handle.0.borrow_mut());
        call.host.count_effect();
        return Ok(());
    }
    change(call, handle, apply)
}

fn member(receiver: Receiver, name: &'static str, summary: &'static str, returns: &'static str, read: fn(&Call) -> Dynamic) -> Function {
    let object = if receiver == ModelHandle::receiver() { "press" } else { "plate" };
    Function {
        name,
        form: Form::Property(receiver),
        topic: Topic::Model,
        summary,
        parameters: Vec::new(),
        returns,
        example: example(&format!("print({object}.{name});")),
        see_also: &["add_body"],
        body: body(move |call| Ok(read(call))),
    }
}

fn loads() -> Vec<Function> {
    let receiver = ModelHandle::receiver();
    let directed =
        |name: &'static str, summary: &'static str, dimension: &'static str, what: &'static str, kind: fn([f64; 3]) -> LoadKind| Function {
            name,
            form: Form::Method(receiver),
            topic: Topic::Model,
            summary,
            parameters: vec![boundary_parameter(), Parameter::new("vector", Kind::Vector, what).of(dimension), amplitude_parameter()],
            returns: "",
            example: example(&format!("press.{name}(plate.boundary(\"right\"), [0.0, -5.0], ramp(0.0, 0.1, 1.0));")),
            see_also: &["torque", "gravity", "hat", "ramp", "sine", "table"],
            body: body(move |call| {
                let dimension = call.receiver::<ModelHandle>().0.borrow().model.dimension();
                let vector = call.argument("vector").vector(dimension)?;
                let word = format!("{name} {}", vector_text(&vector[..dimension]));
                Ok(add_load(call, kind(vector), &word)?)
            }),
        };
    vec![
        directed(
            "traction",
            "loads a boundary with a force per undeformed area that keeps its direction",
            "stress",
            "the force per area at amplitude 1",
            LoadKind::Traction,
        ),
        directed(
            "force",
            "loads a boundary with a force that keeps its direction, spread evenly",
            "force",
            "the whole force at amplitude 1",
            LoadKind::Force,
        ),
        Function {
            name: "pressure",
            form: Form::Method(receiver),
            topic: Topic::Model,
            summary: "loads a boundary with a pressure against its deformed surface, in the plane",
            parameters: vec![
                boundary_parameter(),
                Parameter::number("pressure", "stress", Interval::Finite, "the pressure at amplitude 1; positive pushes into the body"),
                amplitude_parameter(),
            ],
            returns: "",
            example: example("press.pressure(plate.boundary(\"top\"), 50.0, ramp(0.0, 0.1, 1.0));"),
            see_also: &["traction", "force"],
            body: body(|call| {
                let pressure = call.number("pressure")?;
                Ok(add_load(call, LoadKind::Pressure(pressure), &format!("pressure {}", number_text(pressure)))?)
            }),
        },
        Function {
            name: "torque",
            form: Form::Method(receiver),
            topic: Topic::Model,
            summary: "loads a boundary with a torque about the third axis, as nodal forces without resultant",
            parameters: vec![
                boundary_parameter(),
                Parameter::new("amplitude", Kind::Amplitude, "the torque over time, counter-clockwise").of("force * length"),
            ],
            returns: "",
            example: example("press.torque(plate.boundary(\"left\"), |t| if t < 0.1 { 5.0 } else { 0.0 });"),
            see_also: &["force", "traction", "hat"],
            body: body(|call| Ok(add_load(call, LoadKind::Torque, "torque")?)),
        },
    ]
}

fn body_functions() -> Vec<Function> {
    let (body_receiver, mesh_receiver) = (BodyHandle::receiver(), MeshHandle::receiver());
    let boundary_receiver = BoundaryHandle::receiver();
    let name = || Parameter::new("name", Kind::Text, "the name of the boundary");
    let mut all = vec![
        Function {
            name: "boundary",
            form: Form::Method(body_receiver),
            topic: Topic::Model,
            summary: "a boundary of the body, for supports, loads and contact",
            parameters: vec![name()],
            returns: BoundaryHandle::NAME,
            example: example("print(plate.boundary(\"left\"));"),
            see_also: &["boundary_where", "fix"],
            body: body(|call| {
                let body = call.receiver::<BodyHandle>();
                let mesh = body.definition().mesh;
                let boundary = named_boundary(call, &mesh)?;
                Ok(Dynamic::from(BoundaryHandle { body: Some(body), mesh, boundary }))
            }),
        },
        Function {
            name: "boundary",
            form: Form::Method(mesh_receiver),
            topic: Topic::Meshes,
            summary: "a boundary of the mesh, to look at; supports, loads and contact take boundaries of bodies",
            parameters: vec![name()],
            returns: BoundaryHandle::NAME,
            example: "print(rectangle(#{ size: [2.0, 1.0], cells: [4, 2] }).boundary(\"left\"));".into(),
            see_also: &["boundary_where"],
            body: body(|call| {
                let mesh = call.receiver::<MeshHandle>().mesh();
                let boundary = named_boundary(call, &mesh)?;
                Ok(Dynamic::from(BoundaryHandle { body: None, mesh, boundary }))
            }),
        },
        Function {
            name: "boundary_where",
            form: Form::Method(body_receiver),
            topic: Topic::Model,
            summary: "a new boundary of the body: all facets of its hull at whose nodes a condition holds",
            parameters: condition_parameters(),
            returns: BoundaryHandle::NAME,
            example: example("press.fix(plate.boundary_where(\"foot\", |x, y| x < 0.51 && y < 0.01));"),
            see_also: &["boundary"],
            body: body(|call| {
                let body = call.receiver::<BodyHandle>();
                let mesh = Rc::new(with_boundary_where(call, &body.definition().mesh)?);
                body.model.0.borrow_mut().model.bodies[body.index].mesh = mesh.clone();
                let boundary = named_boundary(call, &mesh)?;
                Ok(Dynamic::from(BoundaryHandle { body: Some(body), mesh, boundary }))
            }),
        },
        member(body_receiver, "name", "the name of the body", "String", |call| call.receiver::<BodyHandle>().definition().name.into()),
        member(body_receiver, "mesh", "the mesh of the body at rest", MeshHandle::NAME, |call| {
            Dynamic::from(MeshHandle::new((*call.receiver::<BodyHandle>().definition().mesh).clone()))
        }),
        member(body_receiver, "material", "the material of the body", MaterialHandle::NAME, |call| {
            Dynamic::from(MaterialHandle(call.receiver::<BodyHandle>().definition().material))
        }),
        member(body_receiver, "mass", "the mass of the body (per thickness in the plane)", "number", |call| {
            let body = call.receiver::<BodyHandle>().definition();
            Dynamic::from(body.mesh.measure() * body.material.density())
        }),
    ];
    let of_boundary = |name: &'static str, summary: &'static str, returns: &'static str, read: fn(&BoundaryHandle) -> Dynamic| Function {
        name,
        form: Form::Property(boundary_receiver),
        topic: Topic::Meshes,
        summary,
        parameters: Vec::new(),
        returns,
        example: format!("print(rectangle(#{{ size: [2.0, 1.0], cells: [4, 2] }}).boundary(\"left\").{name});").into(),
        see_also: &["boundary"],
        body: body(move |call| Ok(read(&call.receiver::<BoundaryHandle>()))),
    };
    all.extend([
        of_boundary("name", "the name of the boundary", "String", |boundary| boundary.boundary.name.clone().into()),
        of_boundary("facets", "the number of facets of the boundary", "int", |boundary| {
            Dynamic::from(boundary.boundary.facets.len() as i64)
        }),
        of_boundary("measure", "the length of the boundary at rest (in space: its area)", "number", |boundary| {
            Dynamic::from(boundary.mesh.boundary_measure(&boundary.boundary))
        }),
    ]);
    all
}
