//! A bolt between two ends: tightened to a preload, then locked at its current length.
//!
//! Up to the time of locking it pulls the ends together with the preload `F(t)`, whatever their distance `l`; its work is that of a load.
//! Afterwards it is a spring of stiffness `k` with the preload at the length `L` of locking,
//!
//! ```text
//! V(l) = F (l - L) + k/2 (l - L)^2,     which is a linear spring of the rest length L - F/k up to a constant.
//! ```

use super::line::{Line, LineDefinition, LineElement};
use super::spring::linear_pull;
use crate::dynamics::model::amplitude::{Amplitude, Constant, Ramp};
use crate::dynamics::model::part::{Change, Iterate, Part, PartStepResult, Pose, Refusal, Sums};
use crate::dynamics::model::quantity::Quantity;
use crate::dynamics::model::step_error::StepError;
use crate::linear::Pattern;

/// A bolt between two ends.
pub type BoltDefinition = LineDefinition<BoltElement>;

/// Force law of a bolt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoltElement {
    /// Tension that tightening reaches `[force]` (per thickness in the plane).
    pub preload: f64,
    /// Stiffness of the locked bolt `[force/length]` (per thickness in the plane).
    pub stiffness: f64,
    /// Time until which the tension rises linearly, and at which the length is locked; 0: the preload acts from the start, and an
    /// equilibrium at the start finds the length `[time]`.
    pub locked_at: f64,
}

impl BoltElement {
    /// Tension of tightening at a time.
    fn tension(&self, time: f64) -> f64 {
        if self.locked_at > 0.0 { self.preload * (time / self.locked_at).clamp(0.0, 1.0) } else { self.preload }
    }

    /// True if the bolt is still tightened at a time.
    fn is_tightened(&self, time: f64) -> bool {
        // Times of steps are products, with a round-off of their own.
        time <= self.locked_at * (1.0 + 8.0 * f64::EPSILON)
    }
}

impl LineElement for BoltElement {
    const READINGS: &'static [Quantity] =
        &[Quantity::new("length", "length"), Quantity::new("force", "force"), Quantity::new("work", "energy")];

    fn functions(&self) -> Vec<Amplitude> {
        // Steps end at the time of locking.
        match self.locked_at > 0.0 {
            true => vec![std::sync::Arc::new(Ramp { start: 0.0, end: self.locked_at, value: self.preload })],
            false => vec![std::sync::Arc::new(Constant(self.preload))],
        }
    }

    fn part(&self, _: &str, line: Line, at_rest: f64, _: bool) -> Box<dyn Part> {
        Box::new(Bolt { line, law: *self, at_rest })
    }

    fn changed(&self, change: &Change) -> Self {
        BoltElement {
            preload: change.force() * self.preload,
            stiffness: change.stiffness() * self.stiffness,
            locked_at: change.units[2] * self.locked_at,
        }
    }

    fn describe(&self, name: &str) -> String {
        let BoltElement { preload, stiffness, locked_at } = self;
        format!("bolt \"{name}\": preload {preload}, locked at t = {locked_at}, stiffness {stiffness}")
    }
}

/// A bolt in global node numbers. History variables: length of locking, tension of tightening, 1 if it is locked, work of
/// tightening in the last step.
struct Bolt {
    line: Line,
    law: BoltElement,
    /// Distance of both ends in the undeformed bodies `[length]`.
    at_rest: f64,
}

impl Bolt {
    /// Rest length `L - F/k` of the locked bolt as a spring.
    fn rest_length(&self, memory: &[f64]) -> f64 {
        memory[0] - self.law.preload / self.law.stiffness
    }
}

impl Part for Bolt {
    fn for_each_coupling(&self, visit: &mut dyn FnMut(&[u32])) {
        visit(&self.line.nodes());
    }

    fn place(&mut self, pattern: &Pattern) {
        self.line.place(pattern);
    }

    fn linearize(&self, at: &Iterate, memory: &[f64], sums: &mut Sums) -> Result<(), Refusal> {
        if !self.law.is_tightened(at.time) {
            let vectors = [at.q_0, at.q_1].map(|q| self.line.vector(q));
            linear_pull(self.law.stiffness, self.rest_length(memory), at.derivative, vectors).add(&self.line, at.weight, sums);
            return Ok(());
        }
        self.line.push_apart(-self.law.tension(at.time), at, sums);
        Ok(())
    }

    fn energy(&self, at: Pose, memory: &[f64]) -> f64 {
        let moved = self.line.vector(at.q).1 - memory[0];
        memory[2] * (self.law.preload * moved + 0.5 * self.law.stiffness * moved * moved)
    }

    fn is_outside(&self) -> bool {
        true
    }

    fn readings(&self, at: Pose, _velocity: &[f64], memory: &[f64]) -> Vec<f64> {
        let length = self.line.vector(at.q).1;
        let locked = self.law.preload + self.law.stiffness * (length - memory[0]);
        vec![length, if memory[2] > 0.0 { locked } else { memory[1] }, memory[3]]
    }

    fn memory(&self) -> Vec<f64> {
        vec![self.at_rest, 0.0, 0.0, 0.0]
    }

    fn settled(&self, time: f64, at: Pose, memory: &[f64]) -> Vec<f64> {
        match self.law.is_tightened(time) {
            true => vec![self.line.vector(at.q).1, self.law.tension(time), 0.0, 0.0],
            false => vec![memory[0], memory[1], 1.0, 0.0],
        }
    }

    fn after_step(&self, at: &Iterate, memory: &[f64]) -> Result<PartStepResult, StepError> {
        let memory = if self.law.is_tightened(at.time) {
            let tension = self.law.tension(at.time);
            vec![self.line.vector(at.q_1).1, tension, 0.0, self.line.work_apart(-tension, at)]
        } else {
            vec![memory[0], memory[1], 1.0, 0.0]
        };
        Ok(PartStepResult { memory, ..PartStepResult::default() })
    }
}
