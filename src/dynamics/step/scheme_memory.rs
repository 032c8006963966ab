//! What a time integrator remembers from step to step, by the names of its [`History`].

use serde::{Deserialize, Serialize};

use crate::integrators::{History, Scheme};

/// What a time integrator remembers besides positions and velocities; a vector that it does not remember is empty.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SchemeMemory {
    /// The integrator with its parameters, nothing where it remembers nothing.
    pub of: String,
    /// Size of the step that has led here, 0 where none of the integrator's own has `[time]`.
    pub dt: f64,
    /// Static forces.
    pub force: Lagging,
    /// External part of the static forces, which changes the momenta in the next step: loads, and forces of obstacles and of the ground.
    pub outside: [Lagging; 2],
    /// Accelerations at the end of the step.
    pub acceleration: Vec<f64>,
    /// Of explicit steps: the energy that there was at the start and that has come in since, by which they are judged `[energy]`.
    pub exchanged: f64,
}

/// What is left of forces `[force]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Lagging {
    /// What the next step finds of them ([`Lag`](crate::integrators::Lag)).
    pub left: Vec<f64>,
    /// What accelerations answer.
    pub answered: Vec<f64>,
}

impl Lagging {
    /// Of forces that have been the same for long.
    pub fn steady(scheme: &Scheme, force: &[f64]) -> Lagging {
        let left = scheme.left();
        let answered = if scheme.remembers(History::Answered) { force.to_vec() } else { Vec::new() };
        Lagging { left: force.iter().map(|force| left * force).collect(), answered }
    }

    /// After a step of whose forces the share of the step itself is `own`.
    pub fn after(&self, scheme: &Scheme, own: &[f64]) -> Lagging {
        let lag = scheme.lag;
        let factor = lag.force / scheme.weight;
        let mut left: Vec<f64> = own.iter().map(|own| factor * own).collect();
        let mut answered = Vec::new();
        if lag.is_long() || scheme.remembers(History::Answered) {
            let mean = own.iter().zip(&self.left).map(|(own, left)| own + lag.used * left);
            answered.extend(mean);
            // Where it is needed it is remembered.
            let before = self.answered.iter().map(|before| (1.0 - lag.gamma) * before);
            answered.iter_mut().zip(before).for_each(|(mean, before)| *mean -= before);
            answered.iter_mut().zip(&mut left).for_each(|(answered, left)| {
                *answered /= lag.gamma;
                *left += lag.inertia * *answered;
            });
        }
        if !scheme.remembers(History::Answered) {
            answered.clear();
        }
        Lagging { left, answered }
    }

    fn len(&self) -> usize {
        self.left.len() + self.answered.len()
    }
}

impl SchemeMemory {
    /// Whether it is what a scheme remembers.
    pub fn is_of(&self, scheme: &Scheme) -> bool {
        self.of.is_empty() == scheme.remembers.is_empty() && (self.of.is_empty() || self.of == scheme.describe())
    }

    /// Whether every vector has so many components or none.
    pub fn has_length(&self, unknowns: usize) -> bool {
        let [loads, obstacles] = &self.outside;
        let lagging = [&self.force, loads, obstacles].into_iter().flat_map(|lagging| [&lagging.left, &lagging.answered]);
        lagging.chain([&self.acceleration]).all(|vector| vector.is_empty() || vector.len() == unknowns)
    }

    /// Numbers that it keeps.
    pub fn len(&self) -> usize {
        self.force.len() + self.outside.iter().map(Lagging::len).sum::<usize>() + self.acceleration.len()
    }
}
