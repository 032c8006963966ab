//! Models, bodies and boundaries as objects of the language.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

use super::data::ModelData;
use super::description::{describe_model, without_unit};
use crate::dynamics::BodyDefinition;
use crate::mesh::{Boundary, Mesh};
use crate::script::api::materials::MaterialHandle;
use crate::script::api::meshes::handle::describe_mesh;
use crate::script::language::digits::{number_text, vector_text};
use crate::script::language::handle::Handle;

/// A model in a script.
#[derive(Clone)]
pub struct ModelHandle(pub Rc<RefCell<ModelData>>);

/// A body of a model.
#[derive(Clone)]
pub struct BodyHandle {
    /// Model of the body.
    pub model: ModelHandle,
    /// Index of the body in the model.
    pub index: usize,
}

/// A boundary of a mesh or of a body.
#[derive(Clone)]
pub struct BoundaryHandle {
    /// Body of the boundary; `None` for the boundary of a mesh.
    pub body: Option<BodyHandle>,
    /// Mesh of the boundary.
    pub mesh: Arc<Mesh>,
    /// Name and facets.
    pub boundary: Boundary,
}

impl Handle for ModelHandle {
    const NAME: &'static str = "Model";
    const MAKER: &'static str = "make one with `model(name)`";

    fn describe(&self) -> String {
        describe_model(&self.0.borrow(), &without_unit)
    }
}

impl Handle for BodyHandle {
    const NAME: &'static str = "Body";
    const MAKER: &'static str = "give the value that `model.add_body(name, mesh, material)` returned, not its name";

    fn instead_of_property(name: &str) -> Option<String> {
        Some(format!("write `.boundary(\"{name}\")` for a boundary of that name"))
    }

    fn describe(&self) -> String {
        let body = self.definition();
        if let Some(inertia) = &body.rigid {
            return format!("rigid body \"{}\": {}; mass {}", body.name, describe_mesh(&body.mesh), number_text(inertia.mass));
        }
        format!("body \"{}\": {}; {}", body.name, describe_mesh(&body.mesh), MaterialHandle(body.material.clone()).describe())
    }
}

impl Handle for BoundaryHandle {
    const NAME: &'static str = "Boundary";
    const MAKER: &'static str = "take one of a body: `body.boundary(\"outer\")`";

    fn describe(&self) -> String {
        let measure = self.mesh.boundary_measure(&self.boundary);
        let (word, facets) = (if self.mesh.dimension() == 2 { "length" } else { "area" }, self.boundary.facets.len());
        if facets == 0 && !self.boundary.nodes.is_empty() {
            let places: Vec<String> = self.boundary.nodes.iter().take(3).map(|&node| self.place(node)).collect();
            let more = if self.boundary.nodes.len() > 3 { ", …" } else { "" };
            return format!("boundary \"{}\" of single points at {}{more}", self.title(), places.join(", "));
        }
        format!("boundary \"{}\" of {facets} facets and {word} {}", self.title(), number_text(measure))
    }
}

impl BoundaryHandle {
    fn place(&self, node: u32) -> String {
        vector_text(&self.mesh.points[node as usize][..self.mesh.dimension()])
    }
}

impl BodyHandle {
    /// Returns the definition of the body in the model.
    pub fn definition(&self) -> BodyDefinition {
        self.model.0.borrow().model.bodies[self.index].clone()
    }
}

impl BoundaryHandle {
    pub fn title(&self) -> String {
        match &self.body {
            Some(body) => format!("{}.{}", body.definition().name, self.boundary.name),
            None => self.boundary.name.clone(),
        }
    }
}
