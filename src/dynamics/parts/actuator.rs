//! An actuator between two ends (hydraulic cylinder): a force element whose force, a time function, pushes the ends apart.
//!
//! `f = F(t) e` on the head and `-f` on the tail, with the direction `e` of the line between them where forces act in the step. Linear and
//! angular momentum are conserved unless an end is on the ground. The work is that of a load.

use super::line::{Line, LineDefinition, LineElement};
use super::time_values::value_of;
use crate::dynamics::model::amplitude::{Amplitude, Rescaled};
use crate::dynamics::model::part::{Change, Iterate, Part, PartStepResult, Pose, Refusal, Sums};
use crate::dynamics::model::quantity::Quantity;
use crate::dynamics::model::step_error::StepError;
use crate::linear::Pattern;

/// An actuator between two ends.
pub type ActuatorDefinition = LineDefinition<ActuatorElement>;

/// Force law of an actuator: the force that pushes its ends apart, over time `[force]` (per thickness in the plane).
#[derive(Clone)]
pub struct ActuatorElement(pub Amplitude);

impl LineElement for ActuatorElement {
    const READINGS: &'static [Quantity] =
        &[Quantity::new("length", "length"), Quantity::new("force", "force"), Quantity::new("work", "energy")];

    fn functions(&self) -> Vec<Amplitude> {
        vec![self.0.clone()]
    }

    fn part(&self, name: &str, line: Line, _: f64, _: bool) -> Box<dyn Part> {
        Box::new(Actuator { name: name.into(), line, force: self.0.clone() })
    }

    fn changed(&self, change: &Change) -> Self {
        ActuatorElement(Rescaled::of(&self.0, change.units[2], change.force()))
    }

    fn describe(&self, name: &str) -> String {
        format!("actuator \"{name}\": force {}", self.0.describe())
    }
}

/// An actuator in global node numbers.
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
        self.line.push_apart(force, at, sums);
        Ok(())
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

    fn after_step(&self, at: &Iterate, _memory: &[f64]) -> Result<PartStepResult, StepError> {
        let force = value_of(&self.name, &self.force, at.time)?;
        Ok(PartStepResult { memory: vec![force, self.line.work_apart(force, at)], ..PartStepResult::default() })
    }
}
