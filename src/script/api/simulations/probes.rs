//! Probes in scripts: material points that are followed, with columns of the history.
//!
//! A probe follows the node nearest to a point of the undeformed body.

use super::columns::{Probe, probe_columns};
use super::fields::{at_shares, name_parameter};
use super::handle::{SimulationHandle, busy};
use super::local_frames::{Geometry, frame_of, frame_parameters};
use crate::dynamics::{BodyDefinition, ProbeValues};
use crate::script::api::examples::flight_example;
use crate::script::api::models::handle::BodyHandle;
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::digits::{brief, vector_text};
use crate::script::language::prelude::*;

/// A probe of a simulation.
#[derive(Clone)]
pub struct ProbeHandle {
    simulation: SimulationHandle,
    index: usize,
}

impl Handle for ProbeHandle {
    const NAME: &'static str = "Probe";

    fn describe(&self) -> String {
        let (probe, values) = (self.probe(), self.values().unwrap_or_default());
        let data = &self.simulation.0.model.model;
        let dimension = data.dimension();
        let numbers = |vector: &[f64; 3]| vector[..dimension].iter().map(|value| brief(*value)).collect::<Vec<_>>().join(", ");
        let place = vector_text(&data.bodies[probe.body].mesh.points[probe.node][..dimension]);
        let (displacement, velocity) = (numbers(&values.displacement), numbers(&values.velocity));
        format!(
            "probe \"{}\" of body \"{}\" at {place}: displacement [{displacement}], velocity [{velocity}]",
            probe.name, data.bodies[probe.body].name
        )
    }
}

impl ProbeHandle {
    fn probe(&self) -> Probe {
        self.simulation.0.probes.borrow()[self.index].clone()
    }

    /// Returns the present values; `None` during a step.
    fn values(&self) -> Option<ProbeValues> {
        self.simulation.0.simulation.try_borrow().ok()?.row().probes.get(self.index).cloned()
    }
}

impl SimulationHandle {
    /// Follows a point from now on.
    pub fn add_probe(&self, call: &Call, probe: Probe) -> Result<(), Failure> {
        let data = &self.0;
        self.looked()?;
        let before: usize = data.model.model.bodies[..probe.body].iter().map(|body| body.mesh.points.len()).sum();
        let node = before + probe.node;
        let row = {
            let mut simulation = data.simulation.try_borrow_mut().map_err(|_| busy(call))?;
            simulation.watch(node);
            data.script_row(simulation.row().clone())
        };
        let known = data.probes.borrow().len();
        data.probes.borrow_mut().push(probe);
        if let Some(artifacts) = data.artifacts.borrow_mut().as_mut() {
            artifacts.add_columns(probe_columns(&data.model.model, &data.probes.borrow()[known..]))?;
        }
        let mut rows = data.history.borrow().clone();
        rows.replace_last(row);
        call.host.count_effect();
        self.replace_history(rows)
    }
}

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    let mut all = vec![probe(), field()];
    let property = |name: &'static str, summary: &'static str, read: fn(&ProbeValues, [f64; 3]) -> [f64; 3]| {
        property_of::<ProbeHandle>(Topic::Results, name)
            .summary(summary)
            .returns("Array")
            .see_also(&["probe", "history"])
            .example(flight_example(&format!("let tip = sim.probe(\"tip\", plate, [2.0, 1.0]);\nsim.step(3);\nprint(tip.{name});")))
            .body(move |call, handle| {
                // In `conserva check` there are no results.
                handle.simulation.with_row(call, |_| ())?;
                let (Some(values), probe) = (handle.values(), handle.probe()) else { return Err(busy(call).into()) };
                let model = &handle.simulation.0.model.model;
                let vector = read(&values, model.bodies[probe.body].mesh.points[probe.node]);
                Ok(array_of(vector[..model.dimension()].iter().copied()))
            })
    };
    all.extend([
        property("displacement", "the displacement of the probe's point now", |values, _| values.displacement),
        property("velocity", "the velocity of the probe's point now", |values, _| values.velocity),
        property(
            "acceleration",
            "the acceleration of the probe's point: change of its velocity in the last step over its size",
            |values, _| values.acceleration,
        ),
        property("position", "the position of the probe's point now", |values, rest| [0, 1, 2].map(|i| rest[i] + values.displacement[i])),
    ]);
    all
}

fn field() -> Function {
    method_of::<ProbeHandle>(Topic::Results, "field")
        .summary("a field of the body at the probe's point now: a number, or an array for a vector")
        .parameters(vec![
            name_parameter(),
            Parameter::options("the frame of `stress_rr`, `stress_along` and the like")
                .otherwise("the axes of the model")
                .keys(frame_parameters().into()),
        ])
        .returns("any")
        .see_also(&["probe", "field", "along"])
        .example(flight_example(
            "let tip = sim.probe(\"tip\", plate, [2.0, 1.0]);\nlet peaks = [];\nsim.on_step(|sim| peaks.push(tip.field(\"von_mises\")));\n\
             sim.step(3);\nprint(peaks);",
        ))
        .body_with_options(|call, handle, options| {
            let (simulation, probe, name) = (&handle.simulation, handle.probe(), call.text("name")?);
            let geometry = Geometry::of(&simulation.0.model.model);
            let frame = frame_of(&options, geometry)?;
            let fields = simulation.with(call, |simulation| simulation.fields().swap_remove(probe.body))?;
            let values = at_shares(&name, &fields, &frame, &[Some(vec![(probe.node as u32, 1.0)])], geometry.dimension());
            Ok(values.into_iter().next().unwrap_or_default())
        })
}

fn probe() -> Function {
    method_of::<SimulationHandle>(Topic::Results, "probe")
        .summary(
            "follows the node of a body nearest to a point at rest; the history gets the columns `name.ux`, `name.uy`, `name.vx`, \
             `name.vy`, `name.ax`, `name.ay`",
        )
        .parameters(vec![
            Parameter::text("name", "its name, unique in the simulation"),
            Parameter::object::<BodyHandle>("body", "the body"),
            Parameter::vector("point", "the point in the undeformed body").of("length"),
        ])
        .see_also(&["history", "contact"])
        .example(flight_example(
            "let tip = sim.probe(\"tip\", plate, [2.0, 1.0]);\nsim.step(3);\nprint(tip);\nprint(sim.history[\"tip.uy\"]);",
        ))
        .body(|call, handle| {
            let argument = call.argument("name");
            let (name, index) = (argument.name()?, handle.body_index(call)?);
            let model = &handle.0.model.model;
            let taken = handle.0.probes.borrow().iter().any(|probe| probe.name == name) || model.contact_names().contains(&name.as_str());
            if taken {
                let failure = argument.refuse(causes::NAME_TAKEN, format!("there is a probe or contact \"{name}\" already"));
                return Err(failure.hint("give the probe a name of its own: it names columns of the history").into());
            }
            let point = call.argument("point").vector(model.dimension())?;
            let distance = |at: &[f64; 3]| (0..3).map(|i| (at[i] - point[i]).powi(2)).sum::<f64>();
            let points = model.bodies[index].mesh.points.iter().map(distance).enumerate();
            let node = points.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(node, _)| node);
            warn_of_distance(call, &model.bodies[index], node, point);
            handle.add_probe(call, Probe { name, body: index, node })?;
            let index = handle.0.probes.borrow().len() - 1;
            Ok(ProbeHandle { simulation: handle, index })
        })
}

/// Warns of a point whose distance from its node exceeds the size of the adjacent cells.
fn warn_of_distance(call: &Call, body: &BodyDefinition, node: usize, point: [f64; 3]) {
    let mesh = &body.mesh;
    let distance = |other: &[f64; 3]| (0..3).map(|i| (mesh.points[node][i] - other[i]).powi(2)).sum::<f64>().sqrt();
    let around = mesh.cells().filter(|cell| cell.contains(&(node as u32))).flatten();
    let size = around.map(|&other| distance(&mesh.points[other as usize])).fold(0.0, f64::max);
    if distance(&point) > size {
        let (at, here) = (vector_text(&mesh.points[node][..mesh.dimension()]), brief(distance(&point)));
        let title = format!("the point of the probe lies outside of body \"{}\"", body.name);
        let warning = Diagnostic::warning(title, call.place(&Target::Argument(2)))
            .code("C0644")
            .cause(format!("its nearest node {at} is {here} away, and is followed"));
        call.host.warn(warning.hint("give a point of the undeformed body"));
    }
}
