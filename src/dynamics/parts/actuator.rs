//! An actuator between two ends, such as a cylinder: it pushes them apart with a force that a time function gives.
//!
//! `f = F(t) e` on its head and `-f` on its tail, `e` the direction of the line between them where forces act in the step: momenta are
//! kept, but for an end on the ground, and its work is that of a load.

use std::sync::Arc;

use super::line::{End, Line, bodies_of, check_apart, is_grounded};
use super::time_values::value_of;
use crate::dynamics::model::amplitude::{Amplitude, Rescaled};
use crate::dynamics::model::error::ModelError;
use crate::dynamics::model::part::{Change, Iterate, Numbering, Part, PartDefinition, Pose, Refusal, Remembered, Sums};
use crate::linear::Pattern;

/// An actuator between two ends.
#[derive(Clone)]
pub struct ActuatorDefinition {
    /// Name, unique among the parts.
    pub name: String,
    /// Its ends.
    pub ends: [End; 2],
    /// Force that pushes them apart, over time `[force]` (per thickness in the plane).
    pub force: Amplitude,
}

impl PartDefinition for ActuatorDefinition {
    fn name(&self) -> &str {
        &self.name
    }

    fn bodies(&self) -> Vec<usize> {
        bodies_of(&self.ends)
    }

    fn is_grounded(&self) -> bool {
        is_grounded(&self.ends)
    }

    fn functions(&self) -> Vec<Amplitude> {
        vec![self.force.clone()]
    }

    fn readings(&self) -> &'static [&'static str] {
        &["length", "force", "work"]
    }

    fn check(&self, point: &dyn Fn(usize, u32) -> [f64; 3]) -> Result<(), ModelError> {
        check_apart(&self.name, &self.ends, point)
    }

    fn part(&self, numbering: &Numbering) -> Box<dyn Part> {
        Box::new(Actuator { name: self.name.clone(), line: Line::new(&self.ends, numbering), force: self.force.clone() })
    }

    fn changed(&self, change: &Change) -> Arc<dyn PartDefinition> {
        let [mass, length, time] = change.units;
        let value = mass * length / (time * time) / if change.is_plane { length } else { 1.0 };
        Arc::new(ActuatorDefinition {
            name: self.name.clone(),
            ends: [0, 1].map(|k| self.ends[k].changed(change)),
            force: Rescaled::of(&self.force, time, value),
        })
    }

    fn describe(&self) -> String {
        format!("actuator \"{}\": force {}", self.name, self.force.describe())
    }
}

/// An actuator in the numbering of the model.
struct Actuator {
    name: String,
    line: Line,
    force: Amplitude,
}

impl Part for Actuator {
    fn for_each_coupling(&self, visit: &mut dyn FnMut(&[u32])) {
        visit(&self.line.nodes());
    }

    fn place(&mut self, pattern: &Pattern) {
        self.line.place(pattern);
    }

    fn linearize(&self, at: &Iterate, _memory: &[f64], sums: &mut Sums) -> Result<(), Refusal> {
        let force = value_of(&self.name, &self.force, at.time).map_err(Refusal::Load)?;
        let (r, length) = self.line.vector(at.q_test);
        if length == 0.0 {
            return Ok(());
        }
        let (e, turning) = (r.map(|r| r / length), at.derivative.placement().share * force / length);
        self.line.push(e.map(|e| force * e), sums.load);
        let slope = |i: usize, j: usize| turning * (e[i] * e[j] - if i == j { 1.0 } else { 0.0 });
        self.line.add_slope(at.weight, slope, sums);
        Ok(())
    }

    fn energy(&self, _at: Pose, _memory: &[f64]) -> f64 {
        0.0
    }

    fn is_outside(&self) -> bool {
        true
    }

    fn readings(&self, at: Pose, _velocity: &[f64], memory: &[f64]) -> Vec<f64> {
        vec![self.line.vector(at.q).1, memory[0], memory[1]]
    }

    fn memory(&self) -> Vec<f64> {
        vec![0.0; 2]
    }

    fn remembered(&self, at: &Iterate, _memory: &[f64]) -> Remembered {
        let force = value_of(&self.name, &self.force, at.time).unwrap_or(f64::NAN);
        let ((r, length), (r_0, _), (r_1, _)) = (self.line.vector(at.q_test), self.line.vector(at.q_0), self.line.vector(at.q_1));
        let moved: f64 = if length > 0.0 { (0..3).map(|i| r[i] / length * (r_1[i] - r_0[i])).sum() } else { 0.0 };
        Remembered { memory: vec![force, force * moved], dissipated: 0.0 }
    }
}
