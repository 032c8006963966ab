//! Fields of a body as arrays, with their extremes, and bodies as a whole.

use std::sync::LazyLock;

use super::handle::SimulationHandle;
use super::local_frames::{Geometry, frame_of, frame_parameters};
use super::told::ScriptOutput;
use crate::dynamics::{
    BodyFields, BodyTotals, CellPlaces, CellStress, LocalFrame, NODE_FIELDS, NodeField, NodeValue, PointField, PointValue,
};
use crate::script::api::examples::flight_example;
use crate::script::api::models::handle::BodyHandle;
use crate::script::language::prelude::*;

/// Names of all fields.
static NAMES: LazyLock<Vec<&str>> = LazyLock::new(|| NODE_FIELDS.iter().map(|field| field.name).collect());

/// The field with this name (one of [`NAMES`]); positions for any other name.
fn named(name: &str) -> &'static NodeField {
    NODE_FIELDS.iter().find(|field| field.name == name).unwrap_or(&NODE_FIELDS[0])
}

/// Evaluation places of field values (nodes, cells, quadrature points) with their names in scripts.
static PLACES: &[(&str, Option<CellPlaces>)] = &[("nodes", None), ("cells", Some(CellPlaces::Cells)), ("points", Some(CellPlaces::Points))];

/// Values of a field with their positions.
enum Chosen {
    Numbers(Vec<([f64; 3], f64)>),
    Vectors(Vec<([f64; 3], [f64; 3])>),
}

impl Chosen {
    /// Numbers, or the lengths of vectors.
    fn sizes(self) -> Vec<([f64; 3], f64)> {
        match self {
            Chosen::Numbers(numbers) => numbers,
            Chosen::Vectors(vectors) => vectors.into_iter().map(|(position, [x, y, z])| (position, x.hypot(y).hypot(z))).collect(),
        }
    }
}

fn at_nodes(field: &NodeField, body: &BodyFields, frame: &LocalFrame) -> Chosen {
    let placed = |node: usize| body.position(node);
    let nodes = 0..body.displacement.len();
    match field.value {
        NodeValue::Number(read) => Chosen::Numbers(nodes.map(|node| (placed(node), read(body, node))).collect()),
        NodeValue::Vector(read) => Chosen::Vectors(nodes.map(|node| (placed(node), read(body, node))).collect()),
        NodeValue::Point(field) => of_points(field, nodes.map(|node| body.at(node)), frame),
    }
}

/// Returns the values inside of cells, where available.
fn in_cells(field: &NodeField, cells: &[CellStress], frame: &LocalFrame) -> Option<Chosen> {
    match field.value {
        NodeValue::Point(field) => Some(of_points(field, cells.iter().copied(), frame)),
        _ if field.name == "position" => Some(Chosen::Vectors(cells.iter().map(|cell| (cell.position, cell.position)).collect())),
        NodeValue::Number(_) | NodeValue::Vector(_) => None,
    }
}

fn of_points(field: &PointField, points: impl Iterator<Item = CellStress>, frame: &LocalFrame) -> Chosen {
    match field.value {
        PointValue::Number(read) => Chosen::Numbers(points.map(|point| (point.position, read(&point, frame))).collect()),
        PointValue::Vector(read) => Chosen::Vectors(points.map(|point| (point.position, read(&point, frame))).collect()),
    }
}

/// Values of a field at points, interpolated from the nodes with weights; NaN for points without weights.
pub(super) fn at_shares(name: &str, body: &BodyFields, frame: &LocalFrame, points: &[Option<Vec<(u32, f64)>>], dimension: usize) -> Array {
    let sum = |shares: &Option<Vec<(u32, f64)>>, read: &dyn Fn(usize) -> f64| {
        shares.as_ref().map_or(f64::NAN, |shares| shares.iter().map(|&(node, share)| share * read(node as usize)).sum())
    };
    match at_nodes(named(name), body, frame) {
        Chosen::Numbers(numbers) => points.iter().map(|point| sum(point, &|node| numbers[node].1).into()).collect(),
        Chosen::Vectors(vectors) => {
            let at = |point| -> [f64; 3] { std::array::from_fn(|i| sum(point, &|node| vectors[node].1[i])) };
            points.iter().map(|point| vector(&at(point), dimension)).collect()
        }
    }
}

pub(super) fn vector(values: &[f64; 3], dimension: usize) -> Dynamic {
    array_of(values[..dimension].iter().copied())
}

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    let mut all = vec![field(), extremes(), body_state()];
    let number = |name, summary, read: fn(&BodyTotals) -> f64| property(name, "", summary, move |state| read(&state.totals).into());
    all.extend([
        number("kinetic", "the kinetic energy of the body", |totals| totals.kinetic),
        number("strain", "the strain energy of the body", |totals| totals.strain),
        number("potential", "the potential energy of the body in gravity, zero at the origin", |totals| totals.potential),
        number(
            "stress_error",
            "the estimated error of its stresses over their size (Zienkiewicz and Zhu 1987); its square is about that of the stiffness",
            |totals| totals.stress_error,
        ),
        property("momentum", "Array", "the linear momentum of the body", |state| vector(&state.totals.momentum, state.dimension)),
        property("angular_momentum", "", "its angular momentum about the origin: a number in the plane, an array in space", |state| {
            match state.dimension {
                2 => state.totals.angular_momentum[2].into(),
                _ => vector(&state.totals.angular_momentum, 3),
            }
        }),
        property("center", "Array", "its center of mass", |state| vector(&state.totals.center, state.dimension)),
        property("velocity", "Array", "the velocity of its center of mass", |state| {
            vector(&state.totals.momentum.map(|momentum| momentum / state.totals.mass), state.dimension)
        }),
    ]);
    all
}

fn field() -> Function {
    method_of::<SimulationHandle>(Topic::Results, "field")
        .summary(
            "a field of a body now: an array with a number or a vector for each node, in the order of `position`; stress is Cauchy's, \
             strain Green and Lagrange's, both recovered at the nodes from the cells nearby, or as they are inside of the cells. \
             `stress_rr`, `stress_tt`, `stress_aa` are radial, tangential and axial about an axis, `stress_along` that along a direction, \
             `contact_state` is 1 where a node sticks and 2 where it slips",
        )
        .parameters(parameters())
        .see_also(&["extremes", "along", "section_force", "body", "picture", "write_fields"])
        .example(flight_example(
            "sim.run_to(0.05);\nlet stress = sim.field(\"von_mises\", plate);\nprint(stress.len());\n\
             print(sim.field(\"stress_xx\", plate, #{ at: \"points\" }).len());\n\
             print(sim.field(\"stress_tt\", plate, #{ center: [1.0, 0.5] }).max());",
        ))
        .body(|call, simulation| {
            let dimension = simulation.0.model.model.dimension();
            let values: Array = match chosen(call)? {
                Chosen::Numbers(numbers) => numbers.into_iter().map(|(_, number)| number.into()).collect(),
                Chosen::Vectors(vectors) => vectors.iter().map(|(_, value)| vector(value, dimension)).collect(),
            };
            Ok(values)
        })
}

fn extremes() -> Function {
    method_of::<SimulationHandle>(Topic::Results, "extremes")
        .summary(
            "the smallest and the largest value of a field of a body now, of a vector its length, with the positions: an object with \
             `min`, `min_at`, `max`, `max_at`",
        )
        .parameters(parameters())
        .see_also(&["field", "picture"])
        .example(flight_example(
            "sim.run_to(0.05);\nlet worst = sim.extremes(\"von_mises\", plate);\nprint(`${worst.max} at ${worst.max_at}`);",
        ))
        .body(|call, simulation| {
            let dimension = simulation.0.model.model.dimension();
            let sizes = chosen(call)?.sizes();
            // A gap is NaN where no surface lies opposite.
            let sizes = || sizes.iter().filter(|(_, size)| !size.is_nan());
            let ends = sizes().min_by(|a, b| a.1.total_cmp(&b.1)).zip(sizes().max_by(|a, b| a.1.total_cmp(&b.1)));
            let mut found = Map::new();
            let mut put = |size: &str, at: &str, (position, value): &([f64; 3], f64)| {
                found.insert(size.into(), (*value).into());
                found.insert(at.into(), vector(position, dimension));
            };
            let Some((least, most)) = ends else {
                let failure = call.refuse(causes::BODY_KIND, format!("\"{}\" has no value at any node of this body", call.text("name")?));
                return Err(failure.hint("contact gaps are known at the nodes of secondary sides alone").into());
            };
            put("min", "min_at", least);
            put("max", "max_at", most);
            Ok(found)
        })
}

/// The parameter that names a field.
pub(super) fn name_parameter() -> Parameter {
    Parameter::new("name", Kind::Choice(&NAMES), "which field")
}

fn parameters() -> Vec<Parameter> {
    static AT: LazyLock<Vec<&str>> = LazyLock::new(|| PLACES.iter().map(|row| row.0).collect());
    let at = Parameter::new(
        "at",
        Kind::Choice(&AT),
        "where: at the nodes, one mean for each cell at its centroid, or at the quadrature points of each cell; the last two for stress, \
         strain, what follows from them, and `position`",
    );
    let keys = [at.or("nodes")].into_iter().chain(frame_parameters()).collect();
    vec![
        name_parameter(),
        Parameter::object::<BodyHandle>("body", "the body"),
        Parameter::map("options", "where values are taken, and the frame of `stress_rr`, `stress_along` and the like")
            .otherwise("at the nodes")
            .keys(keys),
    ]
}

/// Values of the field and the body that a call names, at nodes, cells or quadrature points.
fn chosen(call: &Call) -> Result<Chosen, Failure> {
    let (handle, name, options) = (call.receiver::<SimulationHandle>(), call.text("name")?, call.options("options")?);
    let (index, at) = (handle.body_index(call)?, options.text("at")?);
    let (field, frame) = (named(&name), frame_of(&options, Geometry::of(&handle.0.model.model))?);
    let Some(places) = PLACES.iter().find(|row| row.0 == at).and_then(|row| row.1) else {
        return handle.with(call, |simulation| at_nodes(field, &simulation.fields()[index], &frame));
    };
    handle.with(call, |simulation| in_cells(field, &simulation.cell_stresses(index, places), &frame))?.ok_or_else(|| {
        let failure = options.argument("at").refuse(causes::BODY_KIND, format!("\"{name}\" is a field of the nodes"));
        failure.hint("inside of cells there are stresses, strains, what follows from them, and `position`")
    })
}

/// State of a body at the time of its creation.
#[derive(Clone)]
pub struct BodyStateHandle {
    name: String,
    time: f64,
    dimension: usize,
    totals: BodyTotals,
    told: ScriptOutput,
}

impl Handle for BodyStateHandle {
    const NAME: &'static str = "BodyState";
    const MAKER: &'static str = "take one of a simulation: `sim.body(body)`";

    fn describe(&self) -> String {
        let BodyStateHandle { name, time, dimension, totals, told } = self;
        let turning = match dimension {
            2 => told.number(totals.angular_momentum[2], "mass * length * velocity"),
            _ => told.vector(&totals.angular_momentum, "mass * length * velocity"),
        };
        let [kinetic, strain, potential] = [totals.kinetic, totals.strain, totals.potential].map(|energy| told.number(energy, "energy"));
        let (center, momentum) =
            (told.vector(&totals.center[..*dimension], "length"), told.vector(&totals.momentum[..*dimension], "mass * velocity"));
        format!(
            "body \"{name}\" at t = {}: center {center}\n  energy: kinetic {kinetic}, strain {strain}, potential {potential}\n  \
             momentum {momentum}, angular momentum {turning}",
            told.number(*time, "time")
        )
    }
}

fn body_state() -> Function {
    method_of::<SimulationHandle>(Topic::Results, "body")
        .summary("a body as a whole now: its energies, momenta and center of mass")
        .parameters(vec![Parameter::object::<BodyHandle>("body", "the body")])
        .see_also(&["field", "history", "reaction"])
        .example(flight_example("sim.run_to(0.05);\nprint(sim.body(plate));"))
        .body(|call, handle| {
            let index = handle.body_index(call)?;
            let name = handle.0.model.model.bodies[index].name.clone();
            let state = handle.with(call, |simulation| BodyStateHandle {
                name,
                time: simulation.time(),
                dimension: simulation.dimension(),
                totals: simulation.body(index),
                told: ScriptOutput::of(&handle),
            })?;
            Ok(state)
        })
}

fn property(
    name: &'static str,
    returns: &'static str,
    summary: &'static str,
    read: impl Fn(&BodyStateHandle) -> Dynamic + 'static,
) -> Function {
    property_of::<BodyStateHandle>(Topic::Results, name)
        .summary(summary)
        .returns(returns)
        .see_also(&["body"])
        .example(flight_example(&format!("sim.run_to(0.05);\nprint(sim.body(plate).{name});")))
        .body(move |_, state| Ok(read(&state)))
}
