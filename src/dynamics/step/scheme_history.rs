//! History variables of a time integrator, by the names of [`History`].

use serde::{Deserialize, Serialize};

use crate::integrators::{History, Scheme};

/// History variables of a time integrator besides positions and velocities; a vector that the scheme does not need is empty.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SchemeHistory {
    /// Name of the integrator with its parameters; empty for a scheme without history variables.
    pub of: String,
    /// Time step size of the step that led here, 0 without a step of this integrator `[time]`.
    pub dt: f64,
    /// Static forces.
    pub force: ForceHistory,
    /// External part of the static forces, which changes the momenta in the next step: loads, and forces of obstacles and of the ground.
    pub outside: [ForceHistory; 2],
    /// Accelerations at the end of the step.
    pub acceleration: Vec<f64>,
    /// Initial energy plus the energy supplied since, the scale for judging explicit steps `[energy]`.
    pub exchanged: f64,
}

/// Force history of one kind of forces `[force]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ForceHistory {
    /// Force history passed to the next step ([`LagWeights`](crate::integrators::LagWeights)).
    pub left: Vec<f64>,
    /// Force that balances the inertia at the end of the step.
    pub answered: Vec<f64>,
}

impl ForceHistory {
    /// Force history of a constant force.
    pub fn steady(scheme: &Scheme, force: &[f64]) -> ForceHistory {
        let left = scheme.left();
        let answered = if scheme.remembers(History::Answered) { force.to_vec() } else { Vec::new() };
        ForceHistory { left: force.iter().map(|force| left * force).collect(), answered }
    }

    /// Force history after a step whose own contribution is `own`.
    pub fn after(&self, scheme: &Scheme, own: &[f64]) -> ForceHistory {
        let lag = scheme.lag;
        let factor = lag.force / scheme.weight;
        let mut left: Vec<f64> = own.iter().map(|own| factor * own).collect();
        let mut answered = Vec::new();
        if lag.is_long() || scheme.remembers(History::Answered) {
            let mean = own.iter().zip(&self.left).map(|(own, left)| own + lag.used * left);
            answered.extend(mean);
            // Schemes that need `answered` store it.
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
        ForceHistory { left, answered }
    }

    fn len(&self) -> usize {
        self.left.len() + self.answered.len()
    }
}

impl SchemeHistory {
    /// True if the history variables belong to `scheme`.
    pub fn is_of(&self, scheme: &Scheme) -> bool {
        self.of.is_empty() == scheme.remembers.is_empty() && (self.of.is_empty() || self.of == scheme.describe())
    }

    /// True if every vector is empty or has `unknowns` components.
    pub fn has_length(&self, unknowns: usize) -> bool {
        let [loads, obstacles] = &self.outside;
        let lagging = [&self.force, loads, obstacles].into_iter().flat_map(|lagging| [&lagging.left, &lagging.answered]);
        lagging.chain([&self.acceleration]).all(|vector| vector.is_empty() || vector.len() == unknowns)
    }

    /// Number of stored numbers.
    pub fn len(&self) -> usize {
        self.force.len() + self.outside.iter().map(ForceHistory::len).sum::<usize>() + self.acceleration.len()
    }
}
