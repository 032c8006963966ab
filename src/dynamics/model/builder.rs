//! Construction of a model line by line, as a program writes it. Further properties are set in the fields of [`Model`].

use std::sync::Arc;

use super::amplitude::TimeFunction;
use super::definitions::{BodyDefinition, InitialVelocity, Load, LoadKind, Model, Support};
use super::error::ModelError;
use super::interactions::{BodyBoundary, Interaction};
use crate::bodies::Formulation;
use crate::materials::Material;
use crate::mesh::Mesh;

impl Model {
    /// An empty model.
    pub fn new(name: &str) -> Self {
        Model { name: name.into(), ..Model::default() }
    }

    /// Adds a body; returns its index.
    pub fn add_body(&mut self, name: &str, mesh: Mesh, material: &Material) -> usize {
        self.add_formulated_body(name, mesh, material, Formulation::default())
    }

    /// Adds a body with a formulation; returns its index.
    pub fn add_formulated_body(&mut self, name: &str, mesh: Mesh, material: &Material, formulation: Formulation) -> usize {
        self.bodies.push(BodyDefinition { name: name.into(), mesh: Arc::new(mesh), material: material.clone(), formulation, rigid: None });
        self.bodies.len() - 1
    }

    /// Boundary of a body by name.
    ///
    /// # Errors
    /// [`ModelError::UnknownBoundary`].
    ///
    /// # Panics
    /// When there is no body of that index.
    pub fn boundary(&self, body: usize, name: &str) -> Result<BodyBoundary, ModelError> {
        let BodyDefinition { name: owner, mesh, .. } = &self.bodies[body];
        let unknown = || ModelError::UnknownBoundary {
            body: owner.clone(),
            boundary: name.into(),
            available: mesh.boundaries.iter().map(|boundary| boundary.name.clone()).collect(),
        };
        Ok(BodyBoundary { body, boundary: mesh.boundary(name).ok_or_else(unknown)?.clone() })
    }

    /// Supports a boundary: zero displacement of the selected components (x, y, z).
    pub fn fix(&mut self, on: BodyBoundary, components: [bool; 3]) {
        self.supports.push(Support { on, components });
    }

    /// Loads a boundary.
    pub fn load(&mut self, on: BodyBoundary, kind: LoadKind, amplitude: impl TimeFunction + 'static) {
        self.loads.push(Load { kind, on, amplitude: Arc::new(amplitude) });
    }

    /// Adds a contact pair ([`Interaction::contact`]), whose fields may be changed.
    pub fn add_contact(&mut self, name: &str, secondary: BodyBoundary, primary: BodyBoundary) -> &mut Interaction {
        self.add_interaction(Interaction::contact(name, secondary, primary))
    }

    /// Sets the initial velocity of a body: linear velocity of its center of mass, and angular velocity.
    pub fn set_initial_velocity(&mut self, body: usize, linear: [f64; 3], angular: [f64; 3]) {
        self.initial_velocities.push(InitialVelocity { body, linear, angular });
    }
}
