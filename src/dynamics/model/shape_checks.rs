//! Checks of the exact shapes of contact sides: obstacles without corners, of the bodies' dimension, on which all nodes of the side lie.

use std::slice;

use super::definitions::Model;
use super::error::ModelError;
use super::interactions::{BodyBoundary, Interaction};
use crate::contact::{ExactShape, FacetShape, Obstacle};

impl Model {
    /// Checks the exact shapes of a contact.
    pub(super) fn check_shapes(&self, interaction: &Interaction) -> Result<(), ModelError> {
        let sides = [slice::from_ref(&interaction.secondary), interaction.primary()];
        let refused = |reason, remedy| Err(ModelError::NoShape { contact: interaction.name.clone(), reason, remedy });
        for (shape, side) in interaction.shapes.iter().zip(sides) {
            let Some(shape) = shape else { continue };
            if interaction.facets == Some(FacetShape::Straight) {
                return refused("its facets are straight", "leave the shape out, or let the facets be curved");
            }
            if matches!(shape, Obstacle::InSpace(_)) != (self.dimension() == 3) {
                return refused(
                    "the shape has another dimension than the bodies",
                    "take a circle or a line for plane bodies, a surface for bodies in space",
                );
            }
            let Some(shape) = ExactShape::new(shape) else {
                return refused("the shape has corners", "take a plane, circle, sphere, cylinder without ends, cone or torus");
            };
            side.iter().try_for_each(|on| self.check_on_shape(interaction, on, &shape))?;
        }
        Ok(())
    }

    /// Checks that the nodes of a boundary lie on a shape; the error names the node that is farthest from it.
    fn check_on_shape(&self, interaction: &Interaction, on: &BodyBoundary, shape: &ExactShape) -> Result<(), ModelError> {
        let mesh = &self.bodies[on.body].mesh;
        let nodes = on.boundary.facets.iter().flat_map(|&facet| mesh.facet_nodes(facet));
        let off = nodes.filter(|&node| !shape.contains(mesh.points[node as usize]));
        let farthest = off.map(|node| (shape.distance(mesh.points[node as usize]), node)).max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
        farthest.map_or(Ok(()), |(distance, node)| {
            Err(ModelError::OffShape {
                contact: interaction.name.clone(),
                boundary: self.boundary_name(on),
                node,
                place: mesh.points[node as usize][..self.dimension()].to_vec(),
                distance: distance.abs(),
            })
        })
    }
}
