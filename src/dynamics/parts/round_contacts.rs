//! Contacts of rigid bodies that touch as circles or spheres, not by their nodes: round parts on obstacles, and round bodies.

use crate::bodies::BarycentricMap;
use crate::contact::{Curvature, FacetShape, RoundBody, RoundPart, Surface, round_parts, whole_circle};
use crate::dynamics::model::boundaries::{boundary_faces, boundary_facets};
use crate::dynamics::model::definitions::Model;
use crate::dynamics::model::interactions::{BodyBoundary, Interaction, Partner};
use crate::mesh::pieces_of;

/// Round contacts of a model.
#[derive(Clone, Copy)]
pub struct RoundContacts<'a> {
    /// Model whose contacts are examined.
    pub model: &'a Model,
    /// First node of each body.
    pub first: &'a dyn Fn(usize) -> usize,
    /// Reference positions.
    pub reference: &'a [f64],
}

impl RoundContacts<'_> {
    /// Secondary surface of a contact with facets between its nodes.
    pub fn surface(&self, secondary: &BodyBoundary) -> Surface {
        if self.model.dimension() == 2 {
            return Surface::new(&boundary_facets(self.model, secondary, (self.first)(secondary.body)));
        }
        // Without the center nodes of nine-node faces, which are off the surface defined by the side nodes.
        let pieces: Vec<Vec<u32>> = boundary_faces(self.model, secondary, (self.first)(secondary.body))
            .iter()
            .flat_map(|face| pieces_of(&face[..face.len().min(8)]))
            .collect();
        Surface::in_space(pieces.iter().map(|piece| &piece[..]))
    }

    /// Round parts of a rigid body's boundary that roll on an obstacle; empty for straight facets, deformable bodies, and bilateral
    /// contacts.
    pub fn parts(&self, interaction: &Interaction) -> Vec<RoundPart> {
        let is_rigid = self.model.bodies[interaction.secondary.body].rigid.is_some();
        let is_curved = interaction.facet_shape(self.model.dimension()) == FacetShape::Curved;
        if !is_rigid || !is_curved || interaction.equality || !matches!(interaction.partner, Partner::Obstacle { .. }) {
            return Vec::new();
        }
        round_parts(&self.surface(&interaction.secondary), self.reference)
    }

    /// Secondary and primary sides of a contact between rigid bodies whose boundaries are whole circles or spheres, of which one of two is
    /// convex; `None` for other contacts. They touch as round bodies, not by their facets.
    pub fn bodies(&self, interaction: &Interaction) -> Option<(RoundBody, Vec<RoundBody>)> {
        let is_curved = interaction.facet_shape(self.model.dimension()) == FacetShape::Curved;
        let is_between = matches!(interaction.partner, Partner::Surfaces(_)) && self.model.is_rigid_contact(interaction);
        let has_shapes = interaction.shapes.iter().any(Option::is_some);
        if !is_between || !is_curved || has_shapes || interaction.equality || self.model.is_axisymmetric() {
            return None;
        }
        let round = |on: &BodyBoundary| {
            let (part, curvature) = whole_circle(&self.surface(on), self.reference)?;
            let frame = BarycentricMap::new(&self.model.bodies[on.body].mesh)?;
            let first = (self.first)(on.body) as u32;
            let masters = frame.masters.iter().map(|node| node + first).zip(frame.shares(part.center.into())).collect();
            Some(RoundBody { part, curvature, masters })
        };
        let secondary = round(&interaction.secondary)?;
        let primary: Vec<RoundBody> = interaction.primary().iter().map(round).collect::<Option<_>>()?;
        let is_convex = |body: &RoundBody| body.curvature == Curvature::Convex;
        let is_own = interaction.primary().iter().any(|on| on.body == interaction.secondary.body);
        let fit = |other: &RoundBody| is_convex(&secondary) || is_convex(other);
        (!is_own && primary.iter().all(fit)).then_some((secondary, primary))
    }

    /// Nodes inside of arcs and spheres of a rigid body, ascending, which round parts replace; rim nodes are kept for upright cylinders.
    pub fn nodes_inside(&self, interaction: &Interaction) -> Vec<u32> {
        let mut nodes: Vec<u32> =
            self.parts(interaction).into_iter().filter(|part| part.axis.is_none()).flat_map(|part| part.inside).collect();
        nodes.sort_unstable();
        nodes
    }

    /// Nodes of the sides of a contact that have constraints of their own, in the numbering of the model.
    pub fn constrained_nodes(&self, interaction: &Interaction) -> Vec<u32> {
        if self.bodies(interaction).is_some() {
            return Vec::new();
        }
        let inside = if self.is_free(interaction.secondary.body) { self.nodes_inside(interaction) } else { Vec::new() };
        let nodes = |on: &BodyBoundary| {
            let first = (self.first)(on.body) as u32;
            self.model.bodies[on.body].mesh.boundary_nodes(&on.boundary).into_iter().map(move |node| node + first)
        };
        let all =
            std::iter::once(&interaction.secondary).chain(interaction.primary()).filter(|on| self.model.bodies[on.body].rigid.is_some());
        all.flat_map(nodes).filter(|node| inside.binary_search(node).is_err()).collect()
    }

    /// True for a body without supports, joints and boundary loads. A body that is held has all nodes of its boundary as unknowns: with the
    /// masters alone, constraints of obstacles that press it depend on those that hold it, without a measure of their stiffness.
    fn is_free(&self, body: usize) -> bool {
        let Model { supports, prescriptions, loads, joints, .. } = self.model;
        let on = supports.iter().map(|support| &support.on).chain(prescriptions.iter().map(|given| &given.on));
        let is_loaded = on.chain(loads.iter().map(|load| &load.on)).any(|on| on.body == body);
        !is_loaded && !joints.iter().flat_map(|joint| joint.bodies()).any(|joined| joined == body)
    }
}
