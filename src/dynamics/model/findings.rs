//! Suspicious properties of a model's contacts in the undeformed bodies.
//!
//! Findings are warnings, unlike the errors of [`Model::check`]: the model can be simulated, but hardly as intended.

use super::boundaries::{boundary_faces, boundary_facets, constant_strain_thickness, facets_of_all, tie_reach, tied_in_space};
use super::definitions::Model;
use super::depths::Depths;
use super::interactions::{BodyBoundary, Interaction, Partner};
use crate::contact::{
    ContactMethod, FacetShape, Finding, NamedSurface, PatchFunctions, Surface, Tie, check_surfaces, constant_strain_error,
    facets_of_coarse_circle, facing_away, has_unlike_nodes, polygon_fit, press_fit, uneven_fit,
};

impl Model {
    /// Suspicious properties of contacts, obstacles and ties, each with the name of the first interaction concerned; in space only sides
    /// that face away from each other or from obstacles, ties and press fits.
    pub fn findings(&self) -> Vec<(String, Finding)> {
        let dimension = self.dimension();
        let counts = self.bodies.iter().map(|body| body.mesh.points.len());
        let first: Vec<usize> = counts.scan(0, |sum, count| Some(std::mem::replace(sum, *sum + count))).collect();
        let reference = self.start_positions();
        if dimension != 2 {
            return self.findings_in_space(&first, &reference);
        }
        let facets = |on: &BodyBoundary| boundary_facets(self, on, first[on.body]);
        let check = |secondary: &BodyBoundary, primary: &[BodyBoundary]| {
            let together: Vec<String> = primary.iter().map(|on| self.boundary_name(on)).collect();
            let names = [self.boundary_name(secondary), together.join("\" and \"")];
            let surfaces = [Surface::new(&facets(secondary)), Surface::new(&facets_of_all(primary, facets))];
            let side = |k: usize| NamedSurface { name: &names[k], surface: &surfaces[k] };
            check_surfaces(side(0), side(1), &reference)
        };
        let is_curved = |on: &BodyBoundary| self.bodies[on.body].mesh.is_quadratic();
        let press_fits = |secondary: &BodyBoundary, primary: &[BodyBoundary], shape: FacetShape| {
            let primary: Vec<&BodyBoundary> = primary.iter().filter(|on| !is_curved(on) && !is_curved(secondary)).collect();
            let found = primary.into_iter().filter_map(|on| {
                let of = polygon_fit(&Surface::new(&facets(secondary)), &Surface::new(&facets(on)), &reference, shape)?;
                let (secondary_name, primary_name) = (self.boundary_name(secondary), self.boundary_name(on));
                if of.interlocks() {
                    return Some(Finding::Interlocking { secondary: secondary_name, primary: primary_name, of });
                }
                if of.is_distorted() {
                    return Some(Finding::DistortedFit { secondary: secondary_name, primary: primary_name, of });
                }
                self.constant_strain([secondary, on], of.curvature)
            });
            found.collect()
        };
        let mut findings: Vec<(String, Finding)> = Vec::new();
        let mut add = |name: &String, found: Vec<Finding>| findings.extend(found.into_iter().map(|finding| (name.clone(), finding)));
        for (index, interaction) in self.interactions.iter().enumerate() {
            let Interaction { name, secondary, partner, .. } = interaction;
            let primary = match partner {
                Partner::Surfaces(primary) => primary,
                Partner::Itself | Partner::Obstacle { .. } => std::slice::from_ref(secondary),
                Partner::Tied { to, .. } => std::slice::from_ref(to),
            };
            let mut found = check(secondary, primary);
            // Deep mutual penetration also puts the sides behind each other: that finding is dropped.
            if found.iter().any(Finding::is_behind) && !Depths::of(self).at(&reference, 0.0, &|depth| depth.contact == index).is_empty() {
                found.retain(|finding| !finding.is_behind());
            }
            if self.is_guided(secondary, primary) {
                found.retain(|finding| !matches!(finding, Finding::FacingAway { .. }));
            }
            add(name, found);
            let is_exact = interaction.shapes.iter().any(Option::is_some);
            if let (false, Partner::Surfaces(primary)) = (is_exact, partner) {
                add(name, press_fits(secondary, primary, interaction.facet_shape(2)));
            }
            add(name, self.nodes_in_fits(interaction, &first, &reference));
            add(name, self.coarse_circles(interaction, |on| Surface::new(&facets(on)), &reference));
            add(name, self.away_from_obstacle(&self.interactions[index]).into_iter().collect());
            let Partner::Tied { to, reach } = partner else { continue };
            let secondary = facets(secondary);
            let reach = reach.unwrap_or_else(|| tie_reach(&Surface::new(&secondary), &reference));
            let tied = Tie::new(&secondary, &facets(to), &reference, reach);
            add(name, untied(name, &tied, reach));
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

    /// True if joints guide a side of a contact, so that it may face the other side later.
    pub(super) fn is_guided(&self, secondary: &BodyBoundary, primary: &[BodyBoundary]) -> bool {
        let is_joined = |on: &BodyBoundary| self.joints.iter().any(|joint| joint.bodies().any(|body| body == on.body));
        std::iter::once(secondary).chain(primary).any(is_joined)
    }

    /// Findings for plane press fits of nodes on facets of unlike meshes.
    fn nodes_in_fits(&self, interaction: &Interaction, first: &[usize], reference: &[f64]) -> Vec<Finding> {
        let Interaction { secondary, partner: Partner::Surfaces(primary), method: ContactMethod { is_nodal: true, .. }, .. } = interaction
        else {
            return Vec::new();
        };
        let surface = |on: &BodyBoundary| Surface::new(&boundary_facets(self, on, first[on.body]));
        let side = surface(secondary);
        let is_unlike = |on: &&BodyBoundary| {
            let other = surface(on);
            polygon_fit(&side, &other, reference, FacetShape::Straight).is_some() && has_unlike_nodes(&side, &other, reference)
        };
        primary.iter().filter(is_unlike).map(|on| self.unlike_nodes([secondary, on])).collect()
    }

    /// Findings for rigid sides of a contact whose nodes lie on a circle with too few facets for a round body.
    fn coarse_circles(&self, interaction: &Interaction, surface: impl Fn(&BodyBoundary) -> Surface, reference: &[f64]) -> Vec<Finding> {
        if interaction.is_tie() || interaction.equality || interaction.facet_shape(self.dimension()) != FacetShape::Curved {
            return Vec::new();
        }
        let is_rigid = |on: &&BodyBoundary| self.bodies[on.body].rigid.is_some() && !self.bodies[on.body].mesh.is_quadratic();
        let found = |on: &BodyBoundary| {
            let facets = facets_of_coarse_circle(&surface(on), reference)?;
            Some(Finding::CoarseCircle { surface: self.boundary_name(on), facets })
        };
        std::iter::once(&interaction.secondary).chain(interaction.primary()).filter(is_rigid).filter_map(found).collect()
    }

    /// Finding for a press fit of nodes on facets of an unlike mesh.
    fn unlike_nodes(&self, sides: [&BodyBoundary; 2]) -> Finding {
        let [secondary, primary] = sides.map(|on| self.boundary_name(on));
        Finding::UnlikeNodes { secondary, primary }
    }

    /// Finding for a press fit of sides with cells of constant strain, whose secondary side has this curvature `[1/length]`.
    fn constant_strain(&self, sides: [&BodyBoundary; 2], curvature: f64) -> Option<Finding> {
        let thickness = sides.iter().filter_map(|on| constant_strain_thickness(self, on)).reduce(f64::max)?;
        let [secondary, primary] = sides.map(|on| self.boundary_name(on));
        constant_strain_error(thickness, curvature).map(|error| Finding::ConstantStrain { secondary, primary, thickness, error })
    }

    /// Findings in space: sides that face away from each other, nodes that ties leave out, press fits of coarse or uneven facets.
    fn findings_in_space(&self, first: &[usize], reference: &[f64]) -> Vec<(String, Finding)> {
        let is_flat = |on: &BodyBoundary| !self.bodies[on.body].mesh.is_quadratic();
        let surface = |on: &BodyBoundary| {
            let faces = boundary_faces(self, on, first[on.body]);
            Surface::in_space(faces.iter().map(|face| &face[..]))
        };
        let fits = |interaction: &Interaction, on: &BodyBoundary| {
            let side = &interaction.secondary;
            let (secondary, primary) = (self.boundary_name(side), self.boundary_name(on));
            let shape = interaction.facet_shape(3);
            let of_facets = if is_flat(side) && is_flat(on) { press_fit(&surface(side), &surface(on), reference, shape) } else { None };
            if let Some(of) = of_facets.filter(|of| of.is_coarse() && interaction.shapes.iter().all(Option::is_none)) {
                return Some(Finding::CoarseFit { secondary, primary, of });
            }
            let faces = [side, on].map(|on| boundary_faces(self, on, first[on.body]));
            let uneven = uneven_fit(&interaction.proxy_surfaces_in_space(&faces, reference), reference);
            let is_nodal = interaction.method.is_nodal && (of_facets.is_some() || uneven.is_some());
            if is_nodal && has_unlike_nodes(&surface(side), &surface(on), reference) {
                return Some(self.unlike_nodes([side, on]));
            }
            match uneven.filter(|of| of.is_distorted()) {
                Some(of) => Some(Finding::UnevenFit { secondary, primary, of }),
                None => self.constant_strain([side, on], of_facets?.curvature),
            }
        };
        let away = |secondary: &BodyBoundary, primary: &[BodyBoundary]| {
            let together: Vec<String> = primary.iter().map(|on| self.boundary_name(on)).collect();
            let names = [self.boundary_name(secondary), together.join("\" and \"")];
            let faces = facets_of_all(primary, |on| boundary_faces(self, on, first[on.body]));
            let surfaces = [surface(secondary), Surface::in_space(faces.iter().map(|face| &face[..]))];
            let side = |k: usize| NamedSurface { name: &names[k], surface: &surfaces[k] };
            if self.is_guided(secondary, primary) { None } else { facing_away(side(0), side(1), reference) }
        };
        let of = |interaction: &Interaction| {
            let Interaction { name, secondary, partner, .. } = interaction;
            let found: Vec<Finding> = match partner {
                Partner::Tied { to, reach } => {
                    let (_, tied, reach) = tied_in_space(self, [secondary, to], *reach, |body| first[body], reference);
                    untied(name, &tied, reach)
                }
                Partner::Surfaces(primary) => {
                    away(secondary, primary).into_iter().chain(primary.iter().filter_map(|on| fits(interaction, on))).collect()
                }
                Partner::Obstacle { .. } => self.away_from_obstacle(interaction).into_iter().collect(),
                Partner::Itself => Vec::new(),
            };
            let coarse = self.coarse_circles(interaction, surface, reference);
            found.into_iter().chain(coarse).map(|finding| (name.clone(), finding)).collect::<Vec<_>>()
        };
        self.interactions.iter().flat_map(of).collect()
    }
}

/// Finding for the nodes of a tie without a partner, if there are any.
fn untied(name: &str, tied: &Tie, reach: f64) -> Vec<Finding> {
    let (nodes, of) = (tied.untied().len(), tied.sides().secondary.nodes().len());
    if nodes == 0 { Vec::new() } else { vec![Finding::Untied { tie: name.into(), nodes, of, reach }] }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::definitions::BodyDefinition;
    use super::*;
    use crate::elements::CellKind;
    use crate::materials::NeoHookean;
    use crate::mesh::{Round, rectangle, ring};

    /// A block on the ground block, both 1 x 1.
    fn blocks() -> Model {
        let mut model = Model::default();
        for (name, height, cells) in [("lower", 0.0, 2), ("upper", 1.0, 8)] {
            let mesh = rectangle([1.0, 1.0], [cells, 1], [0.0, height]).expect("the mesh is sound");
            let material =
                NeoHookean { youngs_modulus: 1.0, poisson_ratio: 0.3, density: 1.0 }.material().expect("the constants are in their ranges");
            model.bodies.push(BodyDefinition {
                name: name.into(),
                mesh: Arc::new(mesh),
                material,
                formulation: Default::default(),
                rigid: None,
            });
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
        let contact = |secondary, primary| vec![Interaction::contact("contact", secondary, primary)];
        model.interactions = contact(boundary(&model, 1, "bottom"), boundary(&model, 0, "top"));
        assert_eq!(found(&model), []);
        model.interactions = contact(boundary(&model, 0, "top"), boundary(&model, 1, "bottom"));
        assert!(matches!(found(&model)[..], [Finding::CoarseSecondary { .. }]));
        model.interactions = contact(boundary(&model, 1, "bottom"), boundary(&model, 0, "top"));
        let left = boundary(&model, 0, "left");
        let top = boundary(&model, 0, "top");
        model.interactions[0].partner = Partner::Surfaces(vec![top, left]);
        assert_eq!(found(&model), [], "one of several primaries looks back");
        model.interactions = contact(boundary(&model, 1, "top"), boundary(&model, 0, "top"));
        assert!(matches!(found(&model)[..], [Finding::FacingAway { .. }]));
    }

    /// Press fit of two rings: cells of a quarter of the radius have errors of about twice this ratio.
    #[test]
    fn triangles_in_a_press_fit_are_found() {
        let of = |kind: CellKind, layers: usize| {
            let mut model = blocks();
            for (body, radii) in model.bodies.iter_mut().zip([[0.5, 1.001], [1.0, 1.5]]) {
                let mesh = ring(radii[0], radii[1], [layers, 48], [0.0; 2], 1.0).expect("it is a mesh");
                body.mesh = Arc::new(mesh.with_round_cells(kind, Round::About([0.0; 2])).expect("cells are round"));
            }
            let [shaft, hub] = [boundary(&model, 0, "outer"), boundary(&model, 1, "inner")];
            model.interactions = vec![Interaction::contact("fit", shaft, hub)];
            found(&model)
        };
        let errors = |found: Vec<Finding>| -> Vec<f64> {
            found.iter().filter_map(|of| if let Finding::ConstantStrain { error, .. } = of { Some(*error) } else { None }).collect()
        };
        let coarse = errors(of(CellKind::Tri3, 2));
        assert!(coarse.len() == 1 && (coarse[0] - 0.5).abs() < 0.05, "{coarse:?}");
        assert!(errors(of(CellKind::Tri3, 20)).is_empty() && errors(of(CellKind::Quad4, 2)).is_empty());
    }

    #[test]
    fn a_tie_that_holds_nothing_is_found() {
        let mut model = blocks();
        let tie = |secondary, primary| vec![Interaction::tie("seam", secondary, primary)];
        model.interactions = tie(boundary(&model, 1, "bottom"), boundary(&model, 0, "top"));
        assert_eq!(found(&model), []);
        model.interactions = tie(boundary(&model, 1, "bottom"), boundary(&model, 0, "bottom"));
        let found = found(&model);
        assert!(matches!(found[..], [Finding::FacingAway { .. }, Finding::Untied { nodes: 9, of: 9, .. }]), "{found:?}");
        assert!(found[1].to_string().starts_with("none of the 9 nodes"));
    }
}
