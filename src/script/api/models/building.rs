//! Construction of a model: bodies, gravity, initial velocities, the check of the model.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

use super::arguments::body_of;
use super::change::{change, change_without_bodies};
use super::data::ModelData;
use super::handle::{BodyHandle, ModelHandle};
use crate::bodies::{Dilatation, Formulation, Inertia, Plane};
use crate::contact::Finding;
use crate::dynamics::{BodyDefinition, InitialDisplacement, InitialVelocity, Model};
use crate::materials::Material;
use crate::mesh::{Mesh, MeshError};
use crate::script::api::examples::plate_example;
use crate::script::api::materials::MaterialHandle;
use crate::script::api::meshes::handle::MeshHandle;
use crate::script::api::meshes::transforms::vector_from;
use crate::script::api::remedies::ScriptWords;
use crate::script::api::time_functions::amplitude_of;
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::prelude::*;

/// `model`: an empty model.
pub fn model() -> Function {
    function(Topic::Model, "model")
        .summary("an empty model")
        .parameters(vec![Parameter::text("name", "its name, for messages and files")])
        .see_also(&["add_body", "simulate"])
        .example("let bearing = model(\"bearing\");")
        .body(|call| {
            let data = ModelData { model: Model { name: call.name("name")?, ..Model::default() }, ..ModelData::default() };
            Ok(ModelHandle(Rc::new(RefCell::new(data))))
        })
}

/// `add_body`: a mesh with its material.
pub fn add_body() -> Function {
    method_of::<ModelHandle>(Topic::Model, "add_body")
        .summary("adds a body to the model")
        .parameters(vec![
            Parameter::text("name", "its name, unique in the model"),
            Parameter::object::<MeshHandle>("mesh", "its mesh at rest"),
            Parameter::object::<MaterialHandle>("material", "its material"),
            Parameter::map("formulation", "its formulation").otherwise("as written there").keys(formulation_keys()),
        ])
        .see_also(&["model", "fix", "add_contact"])
        .example(plate_example(
            "let seal = rectangle(#{ size: [1.0, 1.0], cells: [4, 4], origin: [3.0, 0.0] });\n\
             let rubber = neo_hookean(#{ youngs_modulus: 1.0, poisson_ratio: 0.4999, density: 1.0 });\n\
             press.add_body(\"seal\", seal, rubber, #{ dilatation: \"mean\" });",
        ))
        .body(|call, model| {
            let (name, mut mesh) = (call.name("name")?, call.handle::<MeshHandle>("mesh")?.mesh());
            let MaterialHandle(material) = call.handle("material")?;
            let formulation = formulation_of(&call.options("formulation")?, &mesh, &material)?;
            let mut points = mesh.points.clone();
            if formulation.put_on_axis(&mut points) {
                mesh = Arc::new(Mesh { points, ..(*mesh).clone() });
            }
            if let Err(error) = mesh.check() {
                let failure = call.argument("mesh").fail(error.to_string()).code(error.code()).label("the mesh cannot be computed with");
                return Err(failure.hint(error.remedy()).into());
            }
            refuse_or_warn_of_surface(call, &mesh)?;
            if let Err(error) = formulation.check(&mesh, &material) {
                return Err(call.argument("formulation").fail(error.to_string()).code(error.code()).hint(error.remedy()).into());
            }
            let rigid = rigid_of(&call.options("formulation")?, &mesh, &material, formulation)?;
            let definition = BodyDefinition { name, mesh, material, formulation, rigid };
            change(call, &model, |data| data.model.bodies.push(definition))?;
            let index = model.0.borrow().model.bodies.len() - 1;
            Ok(BodyHandle { model, index })
        })
}

/// Refuses a mesh whose surface intersects itself, and warns of other faults of the surface.
pub(super) fn refuse_or_warn_of_surface(call: &Call, mesh: &Mesh) -> Result<(), Failure> {
    for defect in mesh.surface_defects() {
        if matches!(defect, MeshError::CrossingSurface { .. }) {
            return Err(call
                .argument("mesh")
                .fail(defect.to_string())
                .code(defect.code())
                .label("the mesh cannot be computed with")
                .hint(defect.remedy()));
        }
        call.host.warn(Diagnostic::warning(defect.to_string(), call.place(&Target::Argument(1))).code(defect.code()).hint(defect.remedy()));
    }
    Ok(())
}

/// Names of [`Plane`] in scripts, the default first.
const PLANES: [&str; 3] = ["strain", "stress", "axisymmetric"];

/// Names of [`Dilatation`] in scripts.
const DILATATIONS: [&str; 3] = ["pointwise", "mean", "linear"];

fn formulation_keys() -> Vec<Parameter> {
    vec![
        Parameter::new(
            "plane",
            Kind::Choice(&PLANES),
            "plane strain or plane stress (forces are per thickness), or a body of revolution about the y axis with x as its radius \
             (forces are those of the whole circumference)",
        )
        .or(PLANES[0]),
        Parameter::new(
            "dilatation",
            Kind::Choice(&DILATATIONS),
            "the change of volume at every point, or one mean for each cell, which does not lock where the material hardly changes its \
             volume; of `quad9` and `hex27` cells also linear in each cell, which is more accurate",
        )
        .otherwise(
            "where Poisson's ratio is 0.49 or more or the material flows plastically, and the law has a volumetric part, `\"linear\"` for \
             `quad9` and `hex27` and `\"mean\"` for all others but `tri3` and `tet4`; otherwise `\"pointwise\"`",
        ),
        Parameter::flag("rigid", "whether it is rigid: of its material only the density is used").or(false),
    ]
}

/// Mass and inertia of a rigid body in the options.
fn rigid_of(options: &Options, mesh: &Mesh, material: &Material, formulation: Formulation) -> Result<Option<Inertia>, Failure> {
    if !options.flag("rigid")? {
        return Ok(None);
    }
    let inertia = Inertia::of_mesh(mesh, material, formulation);
    inertia.map(Some).map_err(|inverted| options.argument("rigid").fail(format!("cell {} of the mesh is inside out", inverted.cell)))
}

fn formulation_of(options: &Options, mesh: &Mesh, material: &Material) -> Result<Formulation, Failure> {
    let plane = match options.text("plane")?.as_str() {
        "stress" => Plane::Stress,
        "axisymmetric" => Plane::Axisymmetric,
        _ => Plane::Strain,
    };
    if !options.argument("dilatation").is_given() {
        return Ok(Formulation::suited(plane, mesh, material));
    }
    let dilatation = match options.text("dilatation")?.as_str() {
        "mean" => Dilatation::Mean,
        "linear" => Dilatation::Linear,
        _ => Dilatation::Pointwise,
    };
    Ok(Formulation { plane, dilatation })
}

/// `gravity`: the acceleration of all bodies.
pub fn gravity() -> Function {
    method_of::<ModelHandle>(Topic::Model, "gravity")
        .summary("sets the acceleration of gravity of all bodies; one that varies has no potential, its work is that of a load")
        .parameters(vec![
            Parameter::vector("acceleration", "the acceleration").of("length/time^2"),
            Parameter::amplitude("amplitude", "its size over time, as a factor").otherwise("constant"),
        ])
        .see_also(&["traction", "force"])
        .example(plate_example("press.gravity([0.0, -9.81]);\npress.gravity([0.0, -9.81], ramp(0.0, 0.1, 1.0));"))
        .body(|call, model| {
            let argument = call.argument("acceleration");
            let undecided =
                model.0.borrow().model.bodies.is_empty() && argument.value().read_lock::<Array>().is_some_and(|array| array.len() == 3);
            let dimension = if undecided { 3 } else { model.0.borrow().model.dimension() };
            let gravity = argument.vector(dimension)?;
            let amplitude = call.argument("amplitude").given(amplitude_of)?;
            change_without_bodies(call, &model, |data| {
                data.model.gravity = gravity;
                data.model.gravity_amplitude = amplitude;
            })
        })
}

/// `initial_velocity`: initial translation and rotation of a body.
pub fn initial_velocity() -> Function {
    method_of::<ModelHandle>(Topic::Model, "initial_velocity")
        .summary("lets a body start with a velocity and a spin about its center of mass")
        .parameters(vec![Parameter::object::<BodyHandle>("body", "the body"), Parameter::map("velocity", "the velocities")])
        .keys(vec![
            Parameter::vector("linear", "the velocity of the center of mass").of("length/time").otherwise("at rest"),
            Parameter::new("angular", Kind::Number, "the angular velocity, counter-clockwise; in space a vector is allowed too")
                .of("1/time")
                .otherwise("no spin"),
        ])
        .see_also(&["add_body"])
        .example(plate_example("press.initial_velocity(plate, #{ linear: [1.0, 0.0], angular: 2.0 });"))
        .body(|call, model| {
            let body = body_of(&call.argument("body"), &model)?;
            let options = call.options("velocity")?;
            let dimension = model.0.borrow().model.dimension();
            let linear = options.argument("linear").given(|given| given.vector(dimension))?.unwrap_or([0.0; 3]);
            let angular = angular(&options, dimension)?;
            change(call, &model, |data| data.model.initial_velocities.push(InitialVelocity { body: body.index, linear, angular }))
        })
}

/// `initial_displacement`: displaces a body at the start.
pub fn initial_displacement() -> Function {
    method_of::<ModelHandle>(Topic::Model, "initial_displacement")
        .summary("lets the nodes of a body start displaced from its mesh, which stays without stress: the body is strained from the start")
        .parameters(vec![
            Parameter::object::<BodyHandle>("body", "the body"),
            Parameter::new("displacement", Kind::Closure("|x, y|"), "the displacement of a point as an array, with z in space")
                .of("length"),
        ])
        .see_also(&["initial_velocity", "map"])
        .example(plate_example("press.initial_displacement(plate, |x, y| [0.1 * x, 0.0]);"))
        .body(|call, model| {
            let (body, closure) = (body_of(&call.argument("body"), &model)?, call.callback("displacement")?);
            let mesh = body.definition().mesh;
            let displacement = mesh.points.iter().map(|point| vector_from(call, &closure, "displacement", &point[..mesh.dimension()]));
            let displacement = displacement.collect::<Result<_, _>>()?;
            let initial = InitialDisplacement { body: body.index, displacement };
            change(call, &model, |data| data.model.initial_displacements.push(initial))
        })
}

/// `check`: errors and suspicious properties of a model that are found without a computation.
pub fn check() -> Function {
    method_of::<ModelHandle>(Topic::Model, "check")
        .summary("checks the model without computing a step; gives an array of sentences about suspicious contacts and bodies that lock")
        .see_also(&["simulate", "add_contact"])
        .example(plate_example("for finding in press.check() { print(finding); }"))
        .body(|call, model| {
            let model = &model.0.borrow().model;
            model.check().map_err(|error| call.fail(error.to_string()).code(error.code()).hint(error.remedy()))?;
            let sentence = |(contact, finding): (String, Finding)| format!("contact \"{contact}\": {finding}; {}", finding.hint());
            let locking = model.locking().into_iter().map(|body| format!("{body}; {}", body.remedy()));
            Ok(model.findings().into_iter().map(sentence).chain(locking).map(Dynamic::from).collect::<Array>())
        })
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
