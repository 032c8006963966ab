//! What a time integrator remembers from step to step, by the names of its [`History`].

use serde::{Deserialize, Serialize};

use crate::integrators::{History, Scheme};

/// What a time integrator remembers besides positions and velocities; a vector that it does not remember is empty.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SchemeMemory {
    /// Its share of the static forces at the end of the step.
    pub force: Vec<f64>,
    /// Accelerations there.
    pub acceleration: Vec<f64>,
}

impl SchemeMemory {
    /// Whether it is what a scheme remembers of so many unknowns.
    pub fn is_of(&self, scheme: &Scheme, unknowns: usize) -> bool {
        let fits = |vector: &[f64], what| vector.len() == if scheme.remembers(what) { unknowns } else { 0 };
        fits(&self.force, History::Force) && fits(&self.acceleration, History::Acceleration)
    }

    /// Whether every vector has so many components or none.
    pub fn has_length(&self, unknowns: usize) -> bool {
        [&self.force, &self.acceleration].into_iter().all(|vector| vector.is_empty() || vector.len() == unknowns)
    }

    /// Numbers that it keeps.
    pub fn len(&self) -> usize {
        self.force.len() + self.acceleration.len()
    }
}
