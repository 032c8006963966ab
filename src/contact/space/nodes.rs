//! Node-to-segment method in space: one multiplier per secondary node, whose constraint is the gap of the node to one facet.
//!
//! `Phi_A = w_A g_A` with the reference weight of the node, so that multipliers are pressures. `g` is the height over the height profile of
//! the opposite triangle; facets of four nodes are triangles about their mean points. Within a step a node keeps the triangle opposite its
//! start, continued as a plane, or opposite its predicted end. Energy and momenta are exact (constraints of `corners.rs`), and a sliding
//! node is assigned to the next facet in the next step. Facets with normals like the surface at the node (far side of a thin body) are not
//! opposite.

use std::collections::BTreeSet;

use super::corners::{CornersInSpace, Kind};
use super::features::{Features, Vertex};
use super::found::Found;
use super::gaps::Measure;
use super::profiles::NodalRows;
use super::second_order::ProxySurfacesInSpace;
use super::vectors::Vec3;
use crate::contact::faces::{self, Vector};
use crate::contact::kernel::ContactKernel;
use crate::contact::surface::{Sides, Surface};
use crate::contact::window::PredictedMotion;

/// Distance beyond the border of a facet without smooth continuation, in facet sizes, up to which a node counts as opposite. Nodes exactly
/// above the border, as in matching meshes, must be constrained.
const RIM: f64 = 0.01;

impl CornersInSpace {
    /// Constraints of the nodes of a surface against the facets of another one.
    pub(crate) fn of_nodes(surfaces: &ProxySurfacesInSpace) -> Box<dyn ContactKernel> {
        let ProxySurfacesInSpace { secondary, primary, reference, .. } = surfaces;
        let vertex = |&node: &u32| Vertex { node, spokes: Vec::new(), is_bump: true, raised: 0.0 };
        let owned = Features { vertices: secondary.nodes().iter().map(vertex).collect(), ..Features::new(secondary, reference) };
        let mut opposite = Features { vertices: Vec::new(), ..Features::new(primary, reference) };
        opposite.laps.iter_mut().flatten().for_each(|lap| *lap = lap.max(RIM));
        let features = [owned, opposite].map(|features| Features { edges: Vec::new(), ..features });
        let Sides { weights, facet_size, .. } = Sides::of(secondary.clone(), primary.clone(), reference);
        let partners = Surface::in_space((0..primary.count()).map(|facet| primary.facet(facet)));
        let mut made = CornersInSpace::new(secondary.clone(), primary.clone(), features, reference, facet_size);
        (made.sides.weights, made.partners, made.slots) = (weights, partners, 1);
        made.of_nodes = Some(NodalRows { heights: surfaces.heights(0), profiles: surfaces.primary_profiles() });
        Box::new(made)
    }

    /// True for each node that already has a constraint from the start of the step; empty if only sharp features have constraints.
    pub(super) fn settled(&self, chosen: &[Option<Found>]) -> Vec<bool> {
        let mut settled = vec![false; if self.of_nodes.is_some() { self.owners.count() } else { 0 }];
        chosen.iter().flatten().filter(|_| self.of_nodes.is_some()).for_each(|row| settled[self.owner(row.patch)] = true);
        settled
    }

    /// Keeps for each node only the facet that it has among `last`, if that is opposite. At the border of two facets round-off would
    /// decide, anew in each step of a search for equilibrium.
    pub(super) fn kept_facets(&self, mut found: Vec<Found>, last: &BTreeSet<Kind>) -> Vec<Found> {
        let is_last = |row: &Found| last.contains(&self.kinds[row.patch]);
        let keeps: BTreeSet<usize> = found.iter().filter(|row| is_last(row)).map(|row| self.owner(row.patch)).collect();
        found.retain(|row| is_last(row) || !keeps.contains(&self.owner(row.patch)));
        found
    }

    /// Nodes with constraints, and their facets; empty if only sharp features have constraints.
    pub(super) fn nodal_kinds(&self) -> BTreeSet<Kind> {
        let rows = if self.of_nodes.is_some() { &self.rows[..] } else { &[] };
        self.kinds.iter().zip(rows).filter(|(_, row)| row.is_some()).map(|(kind, _)| *kind).collect()
    }

    /// Gap function of a node against the triangle below it, and the gap; `None` if only sharp features have constraints.
    pub(super) fn measure(&self, facet: usize, nodes: &[u32], q: &[f64]) -> Option<(Measure, f64)> {
        let rows = self.of_nodes.as_ref()?;
        let z: Vec<Vec3<f64>> = nodes.iter().map(|&node| faces::at(node, q).into()).collect();
        let measure = Measure::above(&z, &rows.profiles[facet]);
        Some((measure, measure.gap(&z)))
    }

    /// True if the surface at a vertex faces a facet with the given normal; always true for sharp features.
    pub(super) fn faces(&self, vertex: usize, normal: Vector, q: &[f64]) -> bool {
        let surface = &self.sides.secondary;
        let looks = || surface.adjacent_facets(vertex).iter().map(|&facet| faces::normal(surface.facet(facet as usize), q)).sum::<Vector>();
        self.of_nodes.is_none() || looks().dot(&normal) < 0.0
    }

    /// True if a node without a constraint penetrates a facet by more than `tolerance` at `q_1`, but not at `q_0`.
    pub(super) fn comes_through(&self, q_0: &[f64], q_1: &[f64], tolerance: f64) -> bool {
        let mut has_row = vec![false; self.owners.count()];
        (0..self.kinds.len()).filter(|&patch| self.rows[patch].is_some()).for_each(|patch| has_row[self.owner(patch)] = true);
        let is_deep =
            |patch: usize, q: &[f64]| self.find(patch, q, &PredictedMotion::within(q, 0.0)).is_some_and(|row| row.gap < -tolerance);
        (0..self.kinds.len()).any(|patch| !has_row[self.owner(patch)] && is_deep(patch, q_1) && !is_deep(patch, q_0))
    }
}
