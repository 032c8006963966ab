//! A point mass at a node: it has inertia and weight, but no extent.

use std::sync::Arc;

use crate::dynamics::model::error::ModelError;
use crate::dynamics::model::part::{Change, Iterate, Numbering, Part, PartDefinition, PartPlace, Refusal, Sums};
use crate::linear::Pattern;

/// A mass at a node of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct PointMassDefinition {
    /// Name, unique among the parts.
    pub name: String,
    /// Body and node of the body's mesh.
    pub node: (usize, u32),
    /// Mass `[mass]`; per thickness in the plane, of the whole circumference in axisymmetric models.
    pub mass: f64,
}

impl PartDefinition for PointMassDefinition {
    fn name(&self) -> &str {
        &self.name
    }

    fn bodies(&self) -> Vec<usize> {
        vec![self.node.0]
    }

    fn mass_on(&self, body: usize) -> f64 {
        if body == self.node.0 { self.mass } else { 0.0 }
    }

    fn check(&self, _point: &dyn Fn(usize, u32) -> [f64; 3]) -> Result<(), ModelError> {
        let is_mass = self.mass >= 0.0 && self.mass.is_finite();
        if is_mass { Ok(()) } else { Err(ModelError::NoMass { part: self.name.clone(), mass: self.mass }) }
    }

    fn places(&self) -> Vec<PartPlace> {
        vec![PartPlace::Nodes(self.node.0, vec![(self.node.1, 1.0)])]
    }

    fn part(&self, numbering: &Numbering) -> Box<dyn Part> {
        let (body, node) = self.node;
        Box::new(PointMass { node: numbering.first[body] as u32 + node, mass: self.mass })
    }

    fn changed(&self, change: &Change) -> Arc<dyn PartDefinition> {
        let [mass, length, _] = change.units;
        Arc::new(PointMassDefinition { mass: self.mass * mass / if change.is_plane { length } else { 1.0 }, ..self.clone() })
    }

    fn describe(&self) -> String {
        format!("mass \"{}\": {}", self.name, self.mass)
    }
}

/// A mass in global node numbers.
struct PointMass {
    node: u32,
    mass: f64,
}

impl Part for PointMass {
    fn for_each_coupling(&self, visit: &mut dyn FnMut(&[u32])) {
        visit(&[self.node]);
    }

    fn place(&mut self, _pattern: &Pattern) {}

    fn linearize(&self, _at: &Iterate, _memory: &[f64], _sums: &mut Sums) -> Result<(), Refusal> {
        Ok(())
    }

    fn point_masses(&self) -> Vec<(u32, f64)> {
        vec![(self.node, self.mass)]
    }
}
