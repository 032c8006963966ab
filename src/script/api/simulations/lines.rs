//! Fields along a line through a body, and stresses linearized over a wall.

use std::rc::Rc;

use super::fields::{at_shares, name_parameter, vector};
use super::handle::SimulationHandle;
use super::local_frames::{Geometry, frame_of, frame_parameters};
use crate::dynamics::{BodyFields, principal, von_mises};
use crate::math::norms::length;
use crate::mesh::CellFinder;
use crate::script::api::examples::flight_example;
use crate::script::api::models::handle::BodyHandle;
use crate::script::language::digits::{brief, vector_text};
use crate::script::language::limits::MAX_ARRAY;
use crate::script::language::prelude::*;

/// Line through a body at the time of its creation.
#[derive(Clone)]
pub struct LineHandle(Rc<Line>);

struct Line {
    geometry: Geometry,
    time: f64,
    fields: BodyFields,
    /// Undeformed points at equal distances.
    points: Vec<[f64; 3]>,
    /// Nodes with their shares in the values at each point; `None` outside of the body.
    shares: Vec<Option<Vec<(u32, f64)>>>,
    /// Distance between the ends `[length]`.
    length: f64,
}

impl Handle for LineHandle {
    const NAME: &'static str = "BodyLine";
    const MAKER: &'static str = "take one of a simulation: `sim.along(body, from, to, 21)`";

    fn describe(&self) -> String {
        let Line { points, shares, fields, time, geometry, length } = &*self.0;
        let dimension = geometry.dimension();
        let outside = shares.iter().filter(|shares| shares.is_none()).count();
        let outside = if outside > 0 { format!(", {outside} of them outside of the body") } else { String::new() };
        let [from, to] = [points.first(), points.last()].map(|point| point.map_or(String::new(), |x| vector_text(&x[..dimension])));
        format!(
            "line through body \"{}\" at t = {} from {from} to {to}, length {}: {} points{outside}",
            fields.name,
            brief(*time),
            brief(*length),
            points.len()
        )
    }
}

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![along(), distance(), field(), linearized()]
}

const EXAMPLE: &str = "sim.run_to(0.05);\nlet line = sim.along(plate, [1.0, 0.0], [1.0, 1.0], 11);\n";

fn along() -> Function {
    method_of::<SimulationHandle>(Topic::Results, "along")
        .summary(
            "points at equal distances on a straight line through the undeformed body, with the fields of now: `line.field(name)` gives \
             the values of a field there, NaN outside of the body, `line.distance` the distances from the first point, `line.linearized()` \
             membrane and bending stress",
        )
        .parameters(vec![
            Parameter::object::<BodyHandle>("body", "the body"),
            Parameter::vector("from", "the first point, in the undeformed body").of("length"),
            Parameter::vector("to", "the last point").of("length"),
            Parameter::integer("count", "how many points, both ends among them").within(Interval::Closed(2.0, MAX_ARRAY as f64)).or(41),
        ])
        .see_also(&["field", "section_force", "probe", "plot_curves"])
        .example(flight_example(&format!("{EXAMPLE}print(line);\nprint(line.field(\"von_mises\").max());")))
        .body(|call, handle| {
            let index = handle.body_index(call)?;
            let (model, count) = (&handle.0.model.model, call.integer("count")? as usize);
            let (mesh, geometry) = (model.bodies[index].mesh.clone(), Geometry::of(model));
            let dimension = geometry.dimension();
            let [from, to] = ["from", "to"].map(|name| call.argument(name));
            let (a, b) = (from.vector(dimension)?, to.vector(dimension)?);
            if a == b {
                return Err(to
                    .refuse(causes::NO_DIRECTION, "the line has no length: both ends are the same point")
                    .hint("give two points")
                    .into());
            }
            let point = |k: usize| {
                let share = k as f64 / (count - 1) as f64;
                std::array::from_fn(|i| a[i] * (1.0 - share) + b[i] * share)
            };
            let (finder, points) = (CellFinder::new(&mesh), (0..count).map(point).collect::<Vec<[f64; 3]>>());
            let shares: Vec<_> = points.iter().map(|&point| finder.shares(point)).collect();
            if shares.iter().all(Option::is_none) {
                let failure = from.refuse(causes::OTHER_OWNER, format!("no point of the line is in body \"{}\"", model.bodies[index].name));
                return Err(failure.hint("give points of the undeformed body").into());
            }
            let (fields, time) = handle.with(call, |simulation| (simulation.fields().swap_remove(index), simulation.time()))?;
            let length = length(std::array::from_fn(|i| b[i] - a[i]));
            Ok(LineHandle(Rc::new(Line { geometry, time, fields, points, shares, length })))
        })
}

fn distance() -> Function {
    property_of::<LineHandle>(Topic::Results, "distance")
        .summary("the distances of the points of a line from its first one, in the undeformed body")
        .see_also(&["along"])
        .example(flight_example(&format!("{EXAMPLE}print(line.distance);")))
        .body(|_, handle| {
            let line = handle.0;
            let last = (line.points.len() - 1) as f64;
            Ok((0..line.points.len()).map(|k| Dynamic::from(line.length * (k as f64 / last))).collect::<Array>())
        })
}

fn field() -> Function {
    method_of::<LineHandle>(Topic::Results, "field")
        .summary("a field at the points of a line, interpolated between the nodes of the cells there; NaN outside of the body")
        .parameters(vec![
            name_parameter(),
            Parameter::options("the frame of `stress_rr`, `stress_along` and the like")
                .otherwise("the axes of the model")
                .keys(frame_parameters().into()),
        ])
        .see_also(&["along", "linearized"])
        .example(flight_example(&format!("{EXAMPLE}plot_curves(\"cut.svg\", [#{{ x: line.distance, y: line.field(\"stress_xx\") }}]);")))
        .body(|call, handle| {
            let (line, options) = (handle.0, call.options("options")?);
            let frame = frame_of(&options, line.geometry)?;
            Ok(at_shares(&call.text("name")?, &line.fields, &frame, &line.shares, line.geometry.dimension()))
        })
}

fn linearized() -> Function {
    method_of::<LineHandle>(Topic::Results, "linearized")
        .summary(
            "the stresses of a line through a wall, linearized as by ASME's code (section VIII, division 2, 5-A): of each component the \
             mean, `membrane`, and the part that is linear over the thickness, `bending`, as it is at the first point (at the last it is \
             opposite); `peak` is what both leave at the first and the last point. Components are xx, yy, zz, xy, yz, xz; \
             `membrane_von_mises` and `membrane_tresca` are numbers, `total_von_mises` and `total_tresca` those of membrane and bending at \
             both ends",
        )
        .see_also(&["along", "field"])
        .example(flight_example(&format!("{EXAMPLE}let wall = line.linearized();\nprint(wall.membrane);\nprint(wall.bending);")))
        .body(|call, handle| {
            let line = handle.0;
            let Some(stresses) = line.stresses() else {
                let failure = call.refuse(causes::OTHER_OWNER, "the line is partly outside of the body, and the stress there is not known");
                return Err(failure
                    .hint("give both ends on the surface of the wall or inside: `line.field(\"von_mises\")` is NaN outside")
                    .into());
            };
            Ok(Linearized::new(&stresses).map())
        })
}

impl Line {
    /// Stresses at the points; `None` where one is outside of the body.
    fn stresses(&self) -> Option<Vec<[f64; 6]>> {
        let stress = |shares: &Option<Vec<(u32, f64)>>| {
            let mut sum = [0.0; 6];
            for &(node, share) in shares.as_ref()? {
                sum.iter_mut().zip(self.fields.stress[node as usize]).for_each(|(sum, stress)| *sum += share * stress);
            }
            Some(sum)
        };
        self.shares.iter().map(stress).collect()
    }
}

/// Membrane, bending and peak stress.
struct Linearized {
    membrane: [f64; 6],
    bending: [f64; 6],
    peak: [[f64; 6]; 2],
}

impl Linearized {
    /// With the distance `s` along the wall of thickness `t`: `membrane = 1/t int sigma ds`, `bending = 6/t^2 int sigma (t/2 - s) ds`,
    /// exact for stresses linear between the points.
    fn new(stresses: &[[f64; 6]]) -> Self {
        let (mut membrane, mut bending) = ([0.0; 6], [0.0; 6]);
        let step = 1.0 / (stresses.len() - 1) as f64;
        for (k, ends) in stresses.windows(2).enumerate() {
            // Arms of both ends and of the middle, by Simpson's rule.
            let [first, last] = [k, k + 1].map(|k| 0.5 - k as f64 * step);
            for i in 0..6 {
                let (a, b) = (ends[0][i], ends[1][i]);
                membrane[i] += step * 0.5 * (a + b);
                bending[i] += step * (a * first + (a + b) * (first + last) + b * last);
            }
        }
        let left = |stress: &[f64; 6], sign: f64| std::array::from_fn(|i| stress[i] - membrane[i] - sign * bending[i]);
        let peak = [left(&stresses[0], 1.0), left(&stresses[stresses.len() - 1], -1.0)];
        Linearized { membrane, bending, peak }
    }

    fn map(&self) -> Map {
        let array = |values: &[f64; 6]| values.iter().map(|&value| value.into()).collect::<Array>();
        let tresca = |stress: &[f64; 6]| {
            let values = principal(stress).values;
            values[0] - values[2]
        };
        let total = [1.0, -1.0].map(|sign: f64| -> [f64; 6] { std::array::from_fn(|i| self.membrane[i] + sign * self.bending[i]) });
        let both = |of: &dyn Fn(&[f64; 6]) -> f64| vector(&[of(&total[0]), of(&total[1]), 0.0], 2);
        let mut map = Map::new();
        map.insert("membrane".into(), array(&self.membrane).into());
        map.insert("bending".into(), array(&self.bending).into());
        map.insert("peak".into(), self.peak.iter().map(|peak| array(peak).into()).collect::<Array>().into());
        map.insert("membrane_von_mises".into(), von_mises(&self.membrane).into());
        map.insert("membrane_tresca".into(), tresca(&self.membrane).into());
        map.insert("total_von_mises".into(), both(&von_mises));
        map.insert("total_tresca".into(), both(&tresca));
        map
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_stress_is_membrane_and_bending_and_a_cubic_leaves_a_peak() {
        let along =
            |of: &dyn Fn(f64) -> f64| -> Vec<[f64; 6]> { (0..=40).map(|k| [of(k as f64 / 40.0), 0.0, 0.0, 0.0, 0.0, 0.0]).collect() };
        let linear = Linearized::new(&along(&|s| 5.0 - 8.0 * s));
        assert!((linear.membrane[0] - 1.0).abs() < 1e-14 && (linear.bending[0] - 4.0).abs() < 1e-14);
        assert!(linear.peak.iter().all(|peak| peak[0].abs() < 1e-14));
        // 6 int s^3 (1/2 - s) ds = -0.45, int s^3 ds = 0.25.
        let cubic = Linearized::new(&along(&|s: f64| s.powi(3)));
        assert!((cubic.membrane[0] - 0.25).abs() < 1e-3 && (cubic.bending[0] + 0.45).abs() < 1e-3);
        assert!((cubic.peak[1][0] - 0.3).abs() < 2e-3, "{:?}", cubic.peak);
    }
}
