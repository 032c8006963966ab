//! What is suspicious about a model's contacts in the undeformed bodies, before anything is computed.
//!
//! Unlike [`Model::check`] these are no errors: the model can be simulated, but it is hardly what was meant.

use super::model::{BodyBoundary, Model};
use super::pairs::{boundary_facets, facets_of_all, tie_reach};
use crate::contact::{Finding, NamedSurface, Surface, Tie, check_surfaces};

impl Model {
    /// Everything suspicious about contacts, obstacles and ties, each with the name of the first of them where it was found; empty for a
    /// model of bodies in space.
    pub fn findings(&self) -> Vec<(String, Finding)> {
        if self.dimension() != 2 {
            return Vec::new();
        }
        let mut first = Vec::with_capacity(self.bodies.len());
        let mut reference: Vec<f64> = Vec::new();
        for body in &self.bodies {
            first.push(reference.len() / 2);
            reference.extend(body.mesh.points.iter().flat_map(|point| [point[0], point[1]]));
        }
        let facets = |on: &BodyBoundary| boundary_facets(self, on, first[on.body]);
        let check = |secondary: &BodyBoundary, primary: &[BodyBoundary]| {
            let together: Vec<String> = primary.iter().map(|on| self.boundary_name(on)).collect();
            let names = [self.boundary_name(secondary), together.join("\" and \"")];
            let surfaces = [Surface::new(&facets(secondary)), Surface::new(&facets_of_all(primary, facets))];
            let side = |k: usize| NamedSurface { name: &names[k], surface: &surfaces[k] };
            check_surfaces(side(0), side(1), &reference)
        };
        let mut findings: Vec<(String, Finding)> = Vec::new();
        let mut add = |name: &String, found: Vec<Finding>| findings.extend(found.into_iter().map(|finding| (name.clone(), finding)));
        for contact in &self.contacts {
            add(&contact.name, check(&contact.secondary, &contact.primary));
        }
        for contact in &self.self_contacts {
            add(&contact.name, check(&contact.surface, std::slice::from_ref(&contact.surface)));
        }
        for obstacle in &self.obstacles {
            add(&obstacle.name, check(&obstacle.secondary, std::slice::from_ref(&obstacle.secondary)));
        }
        for tie in &self.ties {
            add(&tie.name, check(&tie.secondary, std::slice::from_ref(&tie.primary)));
            let secondary = facets(&tie.secondary);
            let reach = tie.reach.unwrap_or_else(|| tie_reach(&secondary, &reference));
            let tied = Tie::new(&secondary, &facets(&tie.primary), &reference, reach);
            let nodes = tied.untied().len();
            if nodes > 0 {
                let of = Surface::new(&secondary).nodes().len();
                add(&tie.name, vec![Finding::Untied { tie: tie.name.clone(), nodes, of, reach }]);
            }
        }
        // A boundary in several contacts is reported once.
        let mut unique: Vec<(String, Finding)> = Vec::new();
        for (name, finding) in findings {
            if unique.iter().all(|(_, known)| *known != finding) {
                unique.push((name, finding));
            }
        }
        unique
    }
}

#[cfg(test)]
mod tests {
    use std::rc::Rc;

    use super::super::model::{BodyDefinition, ContactDefinition, TieDefinition};
    use super::*;
    use crate::materials::{CATALOGUE, Material};
    use crate::mesh::rectangle;

    /// A block on the ground block, both 1 x 1.
    fn blocks() -> Model {
        let mut model = Model::default();
        for (name, height, cells) in [("lower", 0.0, 2), ("upper", 1.0, 8)] {
            let mesh = rectangle([1.0, 1.0], [cells, 1], [0.0, height]).expect("the mesh is sound");
            let material = Material::new(&CATALOGUE[0], &[1.0, 0.3, 1.0]);
            model.bodies.push(BodyDefinition { name: name.into(), mesh: Rc::new(mesh), material });
        }
        model
    }

    fn found(model: &Model) -> Vec<Finding> {
        model.findings().into_iter().map(|(_, finding)| finding).collect()
    }

    fn boundary(model: &Model, body: usize, name: &str) -> BodyBoundary {
        BodyBoundary { body, boundary: model.bodies[body].mesh.boundary(name).expect("the mesh has it").clone() }
    }

    #[test]
    fn the_wrong_side_and_a_coarse_secondary_surface_are_found() {
        let mut model = blocks();
        let contact = |secondary, primary| vec![ContactDefinition::new("contact", secondary, primary)];
        model.contacts = contact(boundary(&model, 1, "bottom"), boundary(&model, 0, "top"));
        assert_eq!(found(&model), []);
        model.contacts = contact(boundary(&model, 0, "top"), boundary(&model, 1, "bottom"));
        assert!(matches!(found(&model)[..], [Finding::CoarseSecondary { .. }]));
        model.contacts = contact(boundary(&model, 1, "bottom"), boundary(&model, 0, "top"));
        let left = boundary(&model, 0, "left");
        model.contacts[0].primary.push(left);
        assert_eq!(found(&model), [], "one of several primaries looks back");
        model.contacts = contact(boundary(&model, 1, "top"), boundary(&model, 0, "top"));
        assert!(matches!(found(&model)[..], [Finding::FacingAway { .. }]));
    }

    #[test]
    fn a_tie_that_holds_nothing_is_found() {
        let mut model = blocks();
        let tie = |secondary, primary| vec![TieDefinition { name: "seam".into(), secondary, primary, reach: None }];
        model.ties = tie(boundary(&model, 1, "bottom"), boundary(&model, 0, "top"));
        assert_eq!(found(&model), []);
        model.ties = tie(boundary(&model, 1, "bottom"), boundary(&model, 0, "bottom"));
        let found = found(&model);
        assert!(matches!(found[..], [Finding::FacingAway { .. }, Finding::Untied { nodes: 9, of: 9, .. }]), "{found:?}");
        assert!(found[1].to_string().starts_with("9 of 9 nodes of tie \"seam\""));
    }
}
