//! Constraints of sharp vertices and edges of two bodies in space, whose penetration the weighted gaps of their surfaces do not detect.
//!
//! The penetration of convex bodies is the largest gap over the faces of their Minkowski difference: a vertex of one body on a facet of the
//! other, or two crossing edges. A vertex on a sharp edge or bump therefore has constraints against the facets opposite it, and a sharp
//! edge against sharp edges that it crosses, if all material next to the feature recedes along the constraint's normal: then the pair is
//! such a face. Constraints and signs are selected at the start of a step, for its start and predicted end. An overlapping constraint is
//! dropped for a shallower one nearby that separates the bodies in another direction (`found.rs`). Each feature has a few slots, filled in
//! the order of the opposite facets and edges. Weights are the square of the smallest facet.

use std::collections::BTreeSet;

use super::features::{self, Features};
use super::found::{ALIKE, Found};
use super::gaps::{Measure, UNKNOWNS};
use super::profiles::{NodalRows, Profiles};
use super::second_order::ProxySurfacesInSpace;
use super::slip::{self, Group, SlipsInSpace};
use super::vectors::Vec3;
use crate::contact::faces::{self, Vector};
use crate::contact::kernel::{CandidateSearch, ContactKernel, PatchFunctions, RigidObstacle};
use crate::contact::numbers::Number;
use crate::contact::patches::{ElementBlocks, Evaluation};
use crate::contact::search::Candidates;
use crate::contact::slip::SlipStep;
use crate::contact::surface::{Sides, Surface};
use crate::contact::window::PredictedMotion;
use crate::integrators::{Configuration, Derivative, PatchFunction, Projection};

/// Largest number of constraints of a feature, such as a vertex in a pocket.
pub(super) const SLOTS: usize = 3;
/// Number of constraints of a ball, for all facets around a node, and its largest radius in facet sizes.
pub(super) const OF_BALL: (usize, f64) = (6, 3.0);

/// Search distance beyond the required one, in smallest facets.
const SEARCH_MARGIN: f64 = 1.0;

/// Largest penetration at which a constraint is considered, in smallest facets.
const DEEP: f64 = 0.55;
/// Largest opening at which a constraint is considered, in smallest facets.
const OPEN: f64 = 0.25;

/// Sine of the smallest angle between two edges with a constraint; nearly parallel edges are constrained by their vertices.
const CROSSING: f64 = 0.05;

/// Largest cosine of the angle between the constraint's normal and the directions into the material next to a feature, which must recede.
const CONE: f64 = 0.1;
/// Value of [`CONE`] for constraints that dominate others.
const STRICT: f64 = 0.01;

/// Pair of features of a contact element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    /// Vertex of `side` (0: secondary) and facet of the other side.
    Vertex { side: usize, vertex: usize, facet: usize },
    /// Sharp edges of the secondary and of the primary side.
    Edges([usize; 2]),
}

/// Constraints of the sharp vertices and edges of two surfaces.
#[derive(Clone, Debug)]
pub struct CornersInSpace {
    pub(super) sides: Sides,
    features: [Features; 2],
    /// Points and edges that own constraints, as a surface for the search.
    pub(super) owners: Surface,
    /// Opposite facets and edges, as a surface for the search.
    pub(super) partners: Surface,
    candidates: Candidates,
    /// One node of each feature with constraints, to which output assigns them.
    row_nodes: Vec<u32>,
    pub(super) kinds: Vec<Kind>,
    /// Constraint slot of each contact element and its gap function in this step; `None` without a constraint.
    pub(super) rows: Vec<Option<(usize, Measure)>>,
    start: Vec<Vec<f64>>,
    /// True if another kernel constrains the vertices of the secondary side.
    pub(super) has_nodal_rows: bool,
    /// Radius of a ball, whose center is the only point of the primary side `[length]`.
    pub(super) radius: f64,
    pub(super) slots: usize,
    /// Height profiles of the facets of both sides.
    profiles: [Profiles; 2],
    /// Height by which each facet of both sides stands out: half the height difference of its nodes (0 on curved surfaces), against
    /// obstacles its height over a surface of second order `[length]`.
    pub(super) heights: [Vec<f64>; 2],
    /// Unevenness of the points (`ProxySurfacesInSpace::unevenness`).
    uneven: f64,
    /// Offset added to the gap of each contact element `[length]`.
    clearances: Vec<f64>,
    /// Data of constraints for all secondary nodes (node-to-segment method, `nodes.rs`); `None` if only sharp features have constraints.
    pub(super) of_nodes: Option<NodalRows>,
}

impl CornersInSpace {
    /// Constraints of two surfaces; `None` without sharp features on either side.
    pub fn kernel(seen: &ProxySurfacesInSpace) -> Option<Box<dyn ContactKernel>> {
        let ProxySurfacesInSpace { secondary, primary, reference, curve, .. } = seen;
        let profiles = [secondary, primary].map(|surface| Profiles::new(surface, curve));
        let of = |(side, profiles): (&Surface, &Profiles)| Features::with_bumps(side, curve, profiles).raised(side, reference, curve);
        let features = [(secondary, &profiles[0]), (primary, &profiles[1])].map(of);
        if features.iter().all(|features| features.vertices.is_empty()) {
            return None;
        }
        let facet_size = secondary.shortest_facet(reference).min(primary.shortest_facet(reference));
        // Gaps to facets of a curved surface are measured to the curve. A curved surface can be a pure twist within a facet, with zero
        // height over it; such facets are recognized by the heights of their neighbors.
        let heights = [(secondary, &profiles[0]), (primary, &profiles[1])].map(|(side, profiles)| {
            let is_flat = |node: u32| {
                let around = side.index(node).map_or(&[][..], |index| side.adjacent_facets(index));
                around.iter().all(|&facet| profiles.height(facet as usize) == 0.0)
            };
            let warp = |nodes: &[u32]| if nodes.iter().all(|&node| is_flat(node)) { faces::warp(nodes, reference) } else { 0.0 };
            (0..side.count()).map(|facet| warp(side.facet(facet))).collect()
        });
        let made = CornersInSpace::new(secondary.clone(), primary.clone(), features, reference, facet_size);
        Some(Box::new(CornersInSpace { profiles, heights, uneven: seen.unevenness(), ..made }))
    }

    pub(super) fn new(secondary: Surface, primary: Surface, features: [Features; 2], reference: &[f64], facet_size: f64) -> Self {
        let mut sides = Sides::of(secondary, primary, reference);
        let points = features.iter().flat_map(|features| &features.vertices).map(|vertex| std::slice::from_ref(&vertex.node));
        let owners = Surface::in_space(points.chain(features[0].edges.iter().map(|edge| &edge.nodes[..])));
        let facets =
            [&sides.primary, &sides.secondary].into_iter().flat_map(|surface| (0..surface.count()).map(|facet| surface.facet(facet)));
        let partners = Surface::in_space(facets.chain(features[1].edges.iter().map(|edge| &edge.nodes[..])));
        let row_nodes: Vec<u32> = (0..owners.count()).map(|owner| owners.facet(owner)[0]).collect();
        sides.facet_size = facet_size;
        sides.weights = vec![facet_size * facet_size; SLOTS * owners.count()];
        let candidates = Candidates::new(SEARCH_MARGIN * facet_size);
        CornersInSpace {
            sides,
            features,
            owners,
            partners,
            candidates,
            row_nodes,
            kinds: Vec::new(),
            rows: Vec::new(),
            start: Vec::new(),
            has_nodal_rows: false,
            radius: 0.0,
            slots: SLOTS,
            profiles: Default::default(),
            heights: Default::default(),
            uneven: 0.0,
            clearances: Vec::new(),
            of_nodes: None,
        }
    }

    fn surface(&self, side: usize) -> &Surface {
        if side == 0 { &self.sides.secondary } else { &self.sides.primary }
    }

    /// Features of a candidate pair; `None` for pairs without a contact function, such as an edge and a facet.
    fn kind(&self, owner: usize, partner: usize) -> Option<Kind> {
        let vertices = [0, 1].map(|side| self.features[side].vertices.len());
        let facets = [self.sides.primary.count(), self.sides.secondary.count()];
        let (side, vertex) = if owner < vertices[0] { (0, owner) } else { (1, owner - vertices[0]) };
        if vertex < vertices[side] {
            let facet = if side == 0 { Some(partner) } else { partner.checked_sub(facets[0]) };
            // A ball is represented by a point and has no facets.
            let is_facet = |facet: usize| facet < facets[side] && self.surface(1 - side).facet(facet).len() > 2;
            return facet.filter(|&facet| is_facet(facet)).map(|facet| Kind::Vertex { side, vertex, facet });
        }
        let other = partner.checked_sub(facets[0] + facets[1])?;
        Some(Kind::Edges([owner - vertices[0] - vertices[1], other]))
    }

    fn list_patches(&mut self) {
        self.sides.patches.clear();
        self.kinds.clear();
        for &[owner, partner] in self.candidates.pairs() {
            let Some(kind) = self.kind(owner as usize, partner as usize) else { continue };
            let nodes = [self.owners.facet(owner as usize), self.partners.facet(partner as usize)].concat();
            self.sides.patches.push(&nodes, &Vec::from_iter((0..self.slots as u32).map(|slot| self.slots as u32 * owner + slot)));
            self.kinds.push(kind);
        }
        self.rows = vec![None; self.kinds.len()];
        self.clearances = self.kinds.iter().map(|kind| self.clearance(*kind)).collect();
        self.sides.list_slips();
    }

    /// Overlap of the features of touching curved surfaces `[length]`. Middles of facets lie above a hollow surface by up to 1.5 mean
    /// heights; points of a convex surface are raised by its mean height, those of second order unevenly, and meet hollow vertices.
    fn clearance(&self, kind: Kind) -> f64 {
        // Coarse facets, as on a sphere with four facets around, stand out farther than by their profiles, or have none.
        let raised = |profiles: &Profiles, facets: &[u32], points: f64| profiles.raised_by(facets).max(points);
        match kind {
            Kind::Vertex { vertex, .. } if let Some(rows) = &self.of_nodes => -rows.heights[vertex],
            Kind::Vertex { side, vertex, facet } => {
                let (surface, vertex) = (self.surface(side), &self.features[side].vertices[vertex]);
                let around = surface.index(vertex.node).filter(|_| !vertex.is_bump).map_or(&[][..], |index| surface.adjacent_facets(index));
                let (hollow, other) = (self.profiles[side].hollow(around), &self.profiles[1 - side]);
                let is_hollow = self.uneven > 0.0 && hollow > 0.0;
                let met = if is_hollow { self.uneven * hollow + other.raised_points(facet as u32) } else { 0.0 };
                let of_facet = self.heights[1 - side].get(facet).copied().unwrap_or(0.0) + other.hollow(&[facet as u32]);
                of_facet + raised(&self.profiles[side], around, vertex.raised) + met
            }
            Kind::Edges(edges) => {
                let of = |side: usize| {
                    let edge = &self.features[side].edges[edges[side]];
                    let facets: Vec<u32> = edge.facets.into_iter().flatten().collect();
                    self.profiles[side].hollow(&facets).max(raised(&self.profiles[side], &facets, edge.raised))
                };
                of(0) + of(1)
            }
        }
    }

    /// Index of the feature to which the constraints of a contact element belong.
    pub(super) fn owner(&self, patch: usize) -> usize {
        self.sides.patches.rows(patch)[0] as usize / self.slots
    }

    /// Gap of a contact element by the gap function `measure`, with its offset.
    fn gap_of(&self, patch: usize, measure: Measure, z: &[f64]) -> f64 {
        measure.gap(z.as_chunks().0) + self.clearances[patch] - self.radius
    }

    /// Selects the constraints of a step from the states of all feature pairs in `configurations`: the start and the predicted end of the
    /// step. `last` are nodes with the facets that they keep.
    fn choose(&mut self, configurations: &[&[f64]], predicted_motion: &PredictedMotion, last: &BTreeSet<Kind>) {
        let mut chosen: Vec<Option<Found>> = vec![None; self.kinds.len()];
        for q in configurations {
            let found: Vec<Found> = (0..self.kinds.len()).filter_map(|patch| self.find(patch, q, predicted_motion)).collect();
            let found = if self.slots > SLOTS { found } else { self.nearest_facets(self.kept_facets(found, last)) };
            let is_elsewhere = |row: &Found| self.has_nodal_rows && matches!(self.kinds[row.patch], Kind::Vertex { side: 0, .. });
            let settled = self.settled(&chosen);
            let is_settled = |row: &Found| settled.get(self.owner(row.patch)).is_some_and(|settled| *settled);
            let found: Vec<Found> = found.into_iter().filter(|row| !is_settled(row)).collect();
            for row in found.iter().filter(|row| !is_elsewhere(row) && !row.is_dominated(&found, self.sides.facet_size)) {
                let known = &mut chosen[row.patch];
                if known.is_none_or(|known| row.gap < known.gap) {
                    *known = Some(*row);
                }
            }
        }
        let mut chosen_rows = vec![None; self.kinds.len()];
        let mut of_owner: Vec<Found> = chosen.into_iter().flatten().collect();
        of_owner.sort_by_key(|row| (self.owner(row.patch), row.patch));
        for rows in of_owner.chunk_by_mut(|a, b| self.owner(a.patch) == self.owner(b.patch)) {
            // The constraints with the deepest penetration fill the slots.
            rows.sort_by(|a, b| a.gap.total_cmp(&b.gap));
            let mut kept: Vec<Found> = rows.iter().take(self.slots).copied().collect();
            kept.sort_by_key(|row| row.patch);
            for (slot, row) in kept.iter().enumerate() {
                chosen_rows[row.patch] = Some((slot, row.measure));
            }
        }
        self.rows = chosen_rows;
    }

    /// For each vertex, keeps only the nearest one of facets with nearly equal normals.
    fn nearest_facets(&self, mut found: Vec<Found>) -> Vec<Found> {
        found.sort_by_key(|row| (self.owner(row.patch), row.patch));
        let distance = |row: &Found| row.distance(self.sides.facet_size);
        let mut kept: Vec<Found> = Vec::with_capacity(found.len());
        for rows in found.chunk_by(|a, b| self.owner(a.patch) == self.owner(b.patch)) {
            let is_beaten = |row: &Found| {
                !matches!(row.measure, Measure::Edges(_))
                    && rows.iter().any(|other| {
                        let order = distance(other).total_cmp(&distance(row)).then(other.patch.cmp(&row.patch));
                        order.is_lt() && other.normal.dot(&row.normal) > ALIKE
                    })
            };
            kept.extend(rows.iter().filter(|row| !is_beaten(row)));
        }
        kept
    }

    /// Penetration of a constraint. For a vertex near an edge of the other body, the smallest penetration behind the facets adjacent to
    /// that edge.
    fn depth(&self, row: &Found, q: &[f64]) -> f64 {
        let size = self.sides.facet_size;
        let predicted_motion = PredictedMotion::within(q, size);
        let others =
            (0..self.kinds.len()).filter(|&patch| self.owner(patch) == self.owner(row.patch) && !matches!(row.measure, Measure::Edges(_)));
        let beside = others.filter_map(|patch| self.find(patch, q, &predicted_motion)).filter(|other| row.is_beside(other, size));
        -beside.map(|other| other.gap).fold(row.gap, f64::max)
    }

    /// Constraint of a contact element at a configuration; `None` if absent there.
    pub(super) fn find(&self, patch: usize, q: &[f64], predicted_motion: &PredictedMotion) -> Option<Found> {
        let nodes = self.sides.patches.nodes(patch);
        let own = self.owners_nodes(patch);
        let motion_bound = predicted_motion.motion_bound::<3>(&nodes[..own], &nodes[own..]);
        let size = self.sides.facet_size;
        let is_near = |gap: f64| gap > -(DEEP * size).max(predicted_motion.depth) && gap < OPEN * size + motion_bound;
        match self.kinds[patch] {
            Kind::Vertex { side, vertex, facet } => {
                let on = self.surface(1 - side).facet(facet);
                let (v, normal) = (faces::at(nodes[0], q), faces::normal(on, q));
                let height = normal.dot(&(v - faces::middle(on, q)));
                let laps = &self.features[1 - side].laps[facet];
                let (measure, height) = self.measure(facet, nodes, q).unwrap_or((Measure::Facet(on.len()), height));
                let gap = height + self.clearances[patch] - self.radius;
                if !is_near(gap) || !self.faces(vertex, normal, q) || !features::is_inside(v, on, normal, laps, q) {
                    return None;
                }
                let rise = |&end: &u32| (faces::at(end, q) - v).try_normalize(0.0).map_or(0.0, |along| normal.dot(&along));
                let least = self.features[side].vertices[vertex].spokes.iter().map(rise).fold(1.0, f64::min);
                let foot = v - normal * height;
                let (normal, at) = if side == 0 { (normal, [v, foot]) } else { (-normal, [foot, v]) };
                let is_strict = least >= -STRICT;
                (least >= -CONE).then_some(Found { patch, measure, gap, normal, at, is_strict })
            }
            Kind::Edges([own, other]) => {
                let edges = [&self.features[0].edges[own], &self.features[1].edges[other]];
                let z: Vec<[f64; 3]> = edges.iter().flat_map(|edge| edge.nodes).map(|node| faces::at(node, q).into()).collect();
                let (feet, sine) = Measure::feet(&z);
                if sine.is_nan() || sine < CROSSING {
                    return None;
                }
                let is_on = |foot: f64, [start, end]: [f64; 2]| foot >= -start && foot <= 1.0 + end;
                if !is_on(feet[0], edges[0].laps) || !is_on(feet[1], edges[1].laps) {
                    return None;
                }
                let at: [Vector; 2] = std::array::from_fn(|k| Vector::from(z[2 * k]).lerp(&Vector::from(z[2 * k + 1]), feet[k]));
                let across = |k: usize| Vector::from(z[2 * k + 1]) - Vector::from(z[2 * k]);
                let out = across(0).cross(&across(1)).try_normalize(0.0)?;
                let looks = [0, 1].map(|side| features::outward(edges[side], self.surface(side), q));
                let sign = if out.dot(&(looks[0] - looks[1])) >= 0.0 { 1.0 } else { -1.0 };
                let out = out * sign;
                let measure = Measure::Edges(sign);
                let gap = measure.gap(&z) + self.clearances[patch];
                let rise = |side: usize| features::into_facets(edges[side], self.surface(side), q).into_iter().map(move |b| out.dot(&b));
                let highest = rise(0).chain(rise(1).map(|rise| -rise)).fold(-1.0, f64::max);
                let is_strict = highest <= STRICT;
                (is_near(gap) && highest <= CONE).then_some(Found { patch, measure, gap, normal: -out, at, is_strict })
            }
        }
    }

    /// Number of nodes that the owning feature contributes to a contact element.
    fn owners_nodes(&self, patch: usize) -> usize {
        if matches!(self.kinds[patch], Kind::Vertex { .. }) { 1 } else { 2 }
    }

    /// Constraint of a contact element in this step, with its gap function.
    fn row(&self, patch: usize) -> Option<(usize, Measure)> {
        let (slot, measure) = self.rows[patch]?;
        Some((self.sides.patches.rows(patch)[slot] as usize, measure))
    }

    /// Constraints of this step that are present at `q`, with their state there.
    fn rows_at(&self, q: &[f64]) -> Vec<(usize, Found)> {
        let predicted_motion = PredictedMotion::within(q, self.sides.facet_size);
        (0..self.kinds.len()).filter_map(|patch| Some((self.row(patch)?.0, self.find(patch, q, &predicted_motion)?))).collect()
    }
}

impl PatchFunctions for CornersInSpace {
    fn sides(&self) -> &Sides {
        &self.sides
    }

    fn rows_per_node(&self) -> usize {
        self.slots
    }

    fn is_nodal(&self) -> bool {
        true
    }

    fn row_nodes(&self) -> &[u32] {
        &self.row_nodes
    }

    fn owns(&self, p: usize, node: u32) -> bool {
        self.sides.patches.nodes(p)[..self.owners_nodes(p)].contains(&node)
    }

    fn begin_step(&mut self, q_0: &[f64]) {
        let start = |patch: usize| {
            let mut z = Vec::new();
            if self.rows[patch].is_some() {
                self.sides.patches.gather_into(patch, q_0, &mut z);
            }
            z
        };
        self.start = (0..self.kinds.len()).map(start).collect();
    }

    fn start_gap(&self) -> Vec<f64> {
        let gap = |(patch, z): (usize, &Vec<f64>)| self.row(patch).map(|(row, measure)| (row, self.gap_of(patch, measure, z)));
        self.sides.weighted(self.start.iter().enumerate().filter_map(gap))
    }

    fn evaluate(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation) {
        assert_eq!(self.start.len(), self.sides.patches.len(), "begin_step follows a change of the candidates");
        out.begin_live(&self.sides.patches, self.sides.weights.len());
        let (mut end, mut projection) = (Vec::with_capacity(UNKNOWNS), Projection::<3>::default());
        for (patch, start) in self.start.iter().enumerate() {
            let Some((row, measure)) = self.row(patch) else { continue };
            self.sides.patches.gather_into(patch, q_1, &mut end);
            let weight = self.sides.weights[row];
            let end_gap = self.gap_of(patch, measure, &end);
            (out.gap[row], out.coverage[row]) = (weight * end_gap, 1.0);
            let (width, slot, pressure) = (end.len(), self.rows[patch].map_or(0, |(slot, _)| slot), lambda[row]);
            let ElementBlocks { gradient_end, gradient_bar, tangent } = out.open(&self.sides.patches, patch, pressure != 0.0);
            let place = slot * width..(slot + 1) * width;
            measure.gradient_into(&end, weight, &mut gradient_end[place.clone()]);
            let middle: Vec<f64> = start.iter().zip(&end).map(|(a, b)| 0.5 * (a + b)).collect();
            if derivative == Derivative::DiscreteGradient {
                projection.set(start, &end);
                let mut of_middle = vec![0.0; width];
                measure.gradient_into(&middle, weight, &mut of_middle);
                let change = weight * (end_gap - self.gap_of(patch, measure, start));
                projection.gradient_into(&of_middle, change, &mut gradient_bar[place.clone()]);
                if pressure != 0.0 {
                    let mut hessian = vec![0.0; width * width];
                    measure.hessian_into(&middle, weight, &mut hessian);
                    let function =
                        PatchFunction { gradient_mid: &of_middle, gradient_end: &gradient_end[place], hessian_mid: &hessian, change };
                    projection.tangent_into(pressure, &function, tangent);
                }
            } else {
                let placement = derivative.placement();
                let z = if placement.test == Configuration::End { &end } else { &middle };
                measure.gradient_into(z, weight, &mut gradient_bar[place]);
                if pressure != 0.0 {
                    measure.hessian_into(z, placement.share * weight * pressure, tangent);
                }
            }
        }
    }

    fn evaluate_slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        slip::evaluate(self, &self.sides, step, lambda, out);
    }

    fn gap(&self, q: &[f64]) -> Vec<f64> {
        self.sides.weighted(self.rows_at(q).into_iter().map(|(row, found)| (row, found.gap)))
    }

    fn coverage(&self, q: &[f64]) -> Vec<f64> {
        self.sides.per_row(self.rows_at(q).into_iter().map(|(row, _)| (row, 1.0)))
    }
}

/// Slip of a vertex relative to the opposite point of a facet, and of two edges at their crossing.
impl SlipsInSpace for CornersInSpace {
    fn groups<T: Number>(&self, p: usize, z: &[Vec3<T>]) -> Vec<Group<T>> {
        let Some((place, measure)) = self.rows[p] else { return Vec::new() };
        let Some(tangents) = measure.tangents(z) else { return Vec::new() };
        let row = self.sides.patches.rows(p)[place] as usize;
        let (of_gap, weight) = (measure.weights(z), self.sides.weights[row]);
        let weights = std::array::from_fn(|k| of_gap.get(k).map_or(T::from(0.0), |w| *w * weight));
        vec![Group { place, weights, normal: measure.normal_part(z, &tangents, weight), tangents, covered: 1.0 }]
    }
}

impl CandidateSearch for CornersInSpace {
    fn update_candidates(&mut self, predicted_motion: &PredictedMotion) -> bool {
        let last = if predicted_motion.is_continued() { self.nodal_kinds() } else { BTreeSet::new() };
        let changed = self.candidates.update(
            &self.owners,
            &self.partners,
            predicted_motion.q,
            predicted_motion.search_margin(&self.sides) + self.radius,
        );
        if changed {
            self.list_patches();
        }
        match predicted_motion.end() {
            Some(end) => self.choose(&[predicted_motion.q, &end], predicted_motion, &last),
            None => self.choose(&[predicted_motion.q], predicted_motion, &last),
        }
        changed
    }

    fn for_each_participant(&self, p: usize, visit: &mut dyn FnMut(u32)) {
        if self.rows[p].is_some() {
            self.sides.patches.nodes(p).iter().copied().for_each(visit);
        }
    }

    fn candidates(&self) -> Option<&Candidates> {
        Some(&self.candidates)
    }

    fn restore_candidates(&mut self, candidates: &Candidates, q: &[f64]) {
        self.candidates = candidates.clone();
        self.list_patches();
        self.choose(&[q], &PredictedMotion::within(q, 0.0), &BTreeSet::new());
        self.begin_step(q);
    }

    fn overlooks(&self, q_0: &[f64], q_1: &[f64], tolerance: f64) -> bool {
        self.of_nodes.is_some() && self.comes_through(q_0, q_1, tolerance)
    }

    fn deepest(&self, q: &[f64]) -> f64 {
        let deeper = |deepest: f64, (_, row): (usize, Found)| if -row.gap > deepest { self.depth(&row, q).max(deepest) } else { deepest };
        self.rows_at(q).into_iter().fold(0.0, deeper)
    }
}

impl RigidObstacle for CornersInSpace {}
