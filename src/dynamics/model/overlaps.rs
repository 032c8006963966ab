//! Overlaps of bodies and obstacles before the first step, from the undeformed meshes.
//!
//! Hulls that penetrate each other are an overlap for every contact definition between them.

use std::fmt;

use super::amplitude::Amplitude;
use super::boundaries::boundary_facets;
use super::definitions::{BodyDefinition, Model};
use super::hulls::{ALLOWED, BodyHull, Hull, MutualPenetration};
use super::interactions::{Interaction, ObstacleRotation, Partner};
use crate::contact::{ContactKernel, Evaluation, Obstacle, PredictedMotion, Surface, rigid_contact};
use crate::integrators::Derivative;
use crate::mesh::Facet;

/// Part of a facet by which corners of a body may be in front of a curved obstacle that has the whole body behind it.
const IN_FRONT: f64 = 0.25;

/// An overlap in the undeformed bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlap {
    /// Overlapping entities.
    pub kind: OverlapKind,
    /// Name of the interaction between the two objects; `None` without one.
    pub contact: Option<String>,
    /// Penetration at the deepest point `[length]`.
    pub depth: f64,
    /// Penetration relative to the facet length.
    pub facets: f64,
    /// Place of the deepest penetration `[length]`.
    pub at: Vec<f64>,
}

/// Entities that overlap.
#[derive(Clone, Debug, PartialEq)]
pub enum OverlapKind {
    /// Two bodies, by name.
    Bodies([String; 2]),
    /// Boundary and rigid obstacle.
    Obstacle {
        /// Name of the boundary, `body.boundary`.
        boundary: String,
        /// True if the whole body lies behind the obstacle and faces away from it: the obstacle has the wrong orientation.
        whole: bool,
    },
}

impl fmt::Display for Overlap {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        match &self.kind {
            OverlapKind::Bodies([first, second]) => write!(out, "bodies \"{first}\" and \"{second}\" overlap at the start"),
            OverlapKind::Obstacle { boundary, whole: false } => write!(out, "\"{boundary}\" is inside the rigid obstacle at the start"),
            OverlapKind::Obstacle { boundary, whole: true } => write!(out, "the body of \"{boundary}\" is behind the rigid obstacle"),
        }
    }
}

impl Overlap {
    /// Stable code of the overlap, explained by `conserva doc`.
    pub fn code(&self) -> &'static str {
        match self.kind {
            OverlapKind::Bodies(_) => "C0411",
            OverlapKind::Obstacle { whole: false, .. } => "C0412",
            OverlapKind::Obstacle { whole: true, .. } => "C0413",
        }
    }

    /// Suggested remedy in one sentence.
    pub fn hint(&self) -> &'static str {
        match (&self.kind, &self.contact) {
            (OverlapKind::Bodies(_), None) => "move one of them; no contact is defined between the two, so nothing would keep them apart",
            (OverlapKind::Obstacle { whole: false, .. }, _) => {
                "move one of them, or press them apart at rest before the first step; turn round an obstacle that looks the wrong way"
            }
            (OverlapKind::Obstacle { whole: true, .. }, _) => {
                "turn it round: the normal of a plane points to where the body is, the points of a polyline have the obstacle on their \
                 left, and other shapes are solid or hollow"
            }
            _ => "move one of them, or press them apart at rest before the first step",
        }
    }
}

impl Model {
    /// All overlaps in the undeformed bodies, with the deepest point of each pair.
    pub fn overlaps(&self) -> Vec<Overlap> {
        let dimension = self.dimension();
        let hull = |(body, definition): (usize, &BodyDefinition)| {
            let q: Vec<f64> = self.start(body).iter().flat_map(|point| &point[..dimension]).copied().collect();
            BodyHull::new(body, &definition.mesh, &q)
        };
        let hulls: Vec<BodyHull> = self.bodies.iter().enumerate().map(hull).collect();
        let mut found = Vec::new();
        for (first, one) in hulls.iter().enumerate() {
            for (second, other) in hulls.iter().enumerate().skip(first + 1) {
                let contact = self.between(first, second);
                if contact.is_none() && self.are_joined(first, second) {
                    continue;
                }
                let Some(MutualPenetration { depth, size, at }) = one.inside(other) else { continue };
                let names = [first, second].map(|body| self.bodies[body].name.clone());
                found.push(Overlap { kind: OverlapKind::Bodies(names), contact, depth, facets: depth / size, at });
            }
        }
        found.extend(self.interactions.iter().filter_map(|interaction| self.obstacle_overlap(interaction)));
        found
    }

    /// The hull of a body in the plane at the start.
    pub fn hull(&self, body: usize) -> Hull {
        let points = self.start(body);
        Hull::new(body, &self.bodies[body].mesh.outline(), &|node| [points[node as usize][0], points[node as usize][1]])
    }

    /// The interaction between two bodies.
    pub fn between(&self, first: usize, second: usize) -> Option<String> {
        let joins = |a: usize, b: usize| {
            let found = self.interactions.iter().find(|one| one.secondary.body == a && one.primary().iter().any(|on| on.body == b));
            found.map(|interaction| interaction.name.clone())
        };
        joins(first, second).or_else(|| joins(second, first))
    }

    /// Penetration of a boundary into its rigid obstacle at the start.
    fn obstacle_overlap(&self, interaction: &Interaction) -> Option<Overlap> {
        let Partner::Obstacle { shape, motion, turn } = &interaction.partner else { return None };
        let (body, dimension) = (interaction.secondary.body, self.dimension());
        let reference: Vec<f64> = self.start(body).iter().flat_map(|point| &point[..dimension]).copied().collect();
        // Errors of time functions are reported by the first step, which evaluates them again.
        let at = |function: &Amplitude| function.value(0.0).ok().unwrap_or(0.0);
        let translation = motion.each_ref().map(|function| function.as_ref().map_or(0.0, at));
        let placed = |kernel: Box<dyn ContactKernel>| {
            let mut kernel = ObstacleRotation::turning(turn.as_ref(), kernel, &reference);
            kernel.move_obstacle(&[translation; 3]);
            kernel.turn_obstacle([turn.as_ref().map_or(0.0, |turn| at(&turn.angle)); 2]);
            kernel
        };
        let surface = match shape {
            Obstacle::InSpace(_) => self.faces_of(&interaction.secondary.boundary.facets, body),
            _ => Surface::new(&boundary_facets(self, &interaction.secondary, 0)),
        };
        let mut kernel = placed(rigid_contact(surface, shape, &reference, Default::default()));
        kernel.update_candidates(&PredictedMotion::within(&reference, 0.0));
        kernel.begin_step(&reference);
        let size = kernel.facet_size();
        let (least, index) = covered_gaps(&*kernel, &reference).min_by(|a, b| a.0.total_cmp(&b.0))?;
        if least > IN_FRONT * size {
            return None;
        }
        // If the obstacle has the wrong orientation, its secondary surface is the foremost part of the body, and the deepest point is
        // elsewhere.
        let behind = self.behind(body, shape, &placed, size).filter(|_| looks_away(&*kernel, &reference, -least));
        let (least, node) = match behind {
            Some(deepest) if least >= -ALLOWED * size => deepest,
            _ => (least, kernel.secondary().nodes()[index] as usize),
        };
        let at = reference[dimension * node..dimension * (node + 1)].to_vec();
        (-least > ALLOWED * size).then(|| {
            let kind = OverlapKind::Obstacle { boundary: self.boundary_name(&interaction.secondary), whole: behind.is_some() };
            Overlap { kind, contact: Some(interaction.name.clone()), depth: -least, facets: -least / size, at }
        })
    }

    /// Facets of a body in space as a surface in local node numbers.
    fn faces_of(&self, facets: &[Facet], body: usize) -> Surface {
        let faces: Vec<Vec<u32>> = facets.iter().flat_map(|&facet| self.bodies[body].mesh.flat_pieces(facet)).collect();
        Surface::in_space(faces.iter().map(|face| &face[..]))
    }

    /// Gap and node of the deepest hull point behind an obstacle, if the whole hull lies behind it within [`IN_FRONT`] of `size`, and that
    /// point is deeper than [`ALLOWED`] of it; otherwise `None`.
    fn behind(
        &self,
        body: usize,
        shape: &Obstacle,
        placed: &dyn Fn(Box<dyn ContactKernel>) -> Box<dyn ContactKernel>,
        size: f64,
    ) -> Option<(f64, usize)> {
        let (mesh, dimension) = (&self.bodies[body].mesh, self.dimension());
        let reference: Vec<f64> = self.start(body).iter().flat_map(|point| &point[..dimension]).copied().collect();
        let surface = match shape {
            Obstacle::InSpace(_) => self.faces_of(&mesh.hull(), body),
            _ => Surface::new(&mesh.outline()),
        };
        let hull = placed(rigid_contact(surface, shape, &reference, Default::default()));
        let (mut deepest, mut highest) = ((0.0, 0), f64::NEG_INFINITY);
        for (gap, index) in covered_gaps(&*hull, &reference) {
            highest = highest.max(gap);
            if gap < deepest.0 {
                deepest = (gap, hull.secondary().nodes()[index] as usize);
            }
        }
        (highest <= IN_FRONT * size && deepest.0 < -ALLOWED * size).then_some(deepest)
    }
}

/// True if a surface behind an obstacle faces away from it, so that its body lies between the surface and the obstacle's boundary, unlike a
/// surface pressed in too far. Closed surfaces face both ways: they count from a penetration of one facet on.
fn looks_away(kernel: &dyn ContactKernel, q: &[f64], depth: f64) -> bool {
    let surface = kernel.secondary();
    if surface.is_closed() {
        return depth > kernel.facet_size();
    }
    let mut at = Evaluation::default();
    kernel.evaluate(Derivative::AT_END, q, &vec![0.0; kernel.rows()], &mut at);
    let (d, stride) = (surface.dimension(), kernel.rows_per_node());
    let along_obstacle = |facet: usize| {
        let outward = surface.outward(facet, q);
        let of_node = |&index: &u32| {
            let row = stride * index as usize;
            let gradient = &at.gradient_end[d * row..d * (row + 1)];
            outward.iter().zip(gradient).map(|(n, g)| n * g).sum::<f64>() / kernel.weights()[row]
        };
        surface.local_facet(facet).iter().map(of_node).sum::<f64>()
    };
    (0..surface.count()).map(along_obstacle).sum::<f64>() > 0.0
}

/// Distances of the nodes that are opposite an obstacle, each with the node's index.
fn covered_gaps(kernel: &dyn ContactKernel, q: &[f64]) -> impl Iterator<Item = (f64, usize)> {
    let (gaps, coverage, stride) = (kernel.gap(q), kernel.coverage(q), kernel.rows_per_node());
    let rows = (0..gaps.len()).step_by(stride).filter(move |&row| coverage[row] > 0.0);
    rows.map(move |row| (gaps[row] / kernel.weights()[row], row / stride))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::interactions::{BodyBoundary, Interaction};
    use super::*;
    use crate::materials::NeoHookean;
    use crate::mesh::{Mesh, disk, rectangle, ring};

    fn model(meshes: Vec<Mesh>) -> Model {
        let rubber = NeoHookean { youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 }.material().expect("in range");
        let body = |(k, mesh): (usize, Mesh)| BodyDefinition {
            name: format!("body {k}"),
            mesh: Arc::new(mesh),
            material: rubber.clone(),
            formulation: Default::default(),
            rigid: None,
        };
        Model { bodies: meshes.into_iter().enumerate().map(body).collect(), ..Model::default() }
    }

    #[test]
    fn overlaps_are_as_deep_as_they_are_and_touching_is_none() {
        let block = |x: f64, y: f64| rectangle([1.0, 1.0], [4, 4], [x, y]).expect("the mesh is sound");
        assert_eq!(model(vec![block(0.0, 0.0), block(1.0, 0.1)]).overlaps(), []);
        let found = model(vec![block(0.0, 0.0), block(0.95, 0.1)]).overlaps();
        assert!(found.len() == 1 && (found[0].depth - 0.05).abs() < 1e-12 && (found[0].facets - 0.2).abs() < 1e-12, "{found:?}");
        assert!(found[0].contact.is_none() && found[0].hint().contains("no contact"));
        // A cross of two bars has no node of one inside the other.
        let bars = [[4.0, 0.3], [0.3, 4.0]].map(|[w, h]| rectangle([w, h], [1, 1], [-0.5 * w, -0.5 * h]).expect("the mesh is sound"));
        let found = model(bars.to_vec()).overlaps();
        assert!(found.len() == 1 && found[0].depth > 0.3, "{found:?}");
        // A square inside of another one.
        let inner = rectangle([0.2, 0.2], [1, 1], [0.4, 0.4]).expect("the mesh is sound");
        assert_eq!(model(vec![block(0.0, 0.0), inner]).overlaps().len(), 1);
    }

    #[test]
    fn the_rise_of_coarse_curved_sides_is_no_overlap() {
        let race = ring(1.0, 1.5, [2, 14], [0.0; 2], 0.1).expect("the mesh is sound");
        for radius in [0.9, 1.0] {
            let journal = disk(radius, [2, 16], [0.0; 2]).expect("the mesh is sound");
            assert_eq!(model(vec![race.clone(), journal]).overlaps(), [], "{radius}");
        }
        let journal = disk(1.1, [2, 16], [0.0; 2]).expect("the mesh is sound");
        let found = model(vec![race, journal]).overlaps();
        assert!(found.len() == 1 && (found[0].depth - 0.1).abs() < 0.03, "{found:?}");
    }

    #[test]
    fn an_obstacle_that_looks_the_wrong_way_has_all_behind_it() {
        let found = |height: f64, normal: f64| {
            let mut model = model(vec![rectangle([1.0, 1.0], [4, 4], [0.0, 0.0]).expect("the mesh is sound")]);
            let boundary = model.bodies[0].mesh.boundary("bottom").expect("it has one").clone();
            let plane = Obstacle::HalfPlane { point: [0.0, height], normal: [0.0, normal] };
            model.interactions.push(Interaction::obstacle("ground", BodyBoundary { body: 0, boundary }, plane));
            model.overlaps()
        };
        assert_eq!(found(0.0, 1.0), []);
        assert_eq!(found(-0.5, 1.0), []);
        for (height, normal, is_whole) in [(0.1, 1.0, false), (-0.5, -1.0, true)] {
            let found = found(height, normal);
            assert!(matches!(found[..], [Overlap { kind: OverlapKind::Obstacle { whole, .. }, .. }] if whole == is_whole), "{found:?}");
            assert!((found[0].depth - height.abs()).abs() < 1e-12);
        }
    }
}
