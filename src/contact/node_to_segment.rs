//! Node-to-segment contact in the plane (in space: `space/nodes.rs`): one multiplier per secondary node, whose constraint is the gap of the
//! node to the primary chain. The same kernel constrains corners beside mortar methods.
//!
//! `Phi_A = w_A g_A` with the reference weight of the node: multipliers are pressures, and `Phi` has the dimension of a weighted gap. A
//! contact element is a node with all primary facets within its search horizon. `g` is one continuous function of them (`chain.rs`). Its
//! projected discrete gradient conserves energy and momenta while the node slides over nodes and corners, unlike the formula for a single
//! segment in Hesch and Betsch, IUTAM Bookseries 3, 2007.
//!
//! Opposite facets are selected at the start of a step: not those with normals like the node's own surface (far side of a thin body), nor
//! those the node would be too deep behind, nor those beyond the motion bound. Only these facets and their neighbors take part, so that the
//! search distance changes no gap. The method fails the contact patch test, and two polygons that are pressed into each other lock with the
//! nodes in the corners; mortar methods are the default.

use nalgebra::Vector2;

use super::bends::Bends;
use super::chain::{Chain, Line, Measure};
use super::depth::NodePosition;
use super::edge_plane::{ACROSS_EDGE, NodeAtEdge};
use super::kernel::{CandidateSearch, PatchFunctions, RigidObstacle, Setting};
use super::method::ContactMethod;
use super::node_patch::{self, PointStart};
use super::patches::Evaluation;
use super::profile::Profile;
use super::search::{Candidates, within_the_body};
use super::slip::{self, SlipStep};
use super::space::CornersInSpace;
use super::surface::{Sides, Surface};
use super::tips::{SeparatingSide, Tip};
use super::window::{MotionBound, PredictedMotion, Window};
use crate::integrators::Derivative;
use crate::math::tolerances::SAME_WAY;

/// Node-to-segment method: gap of each secondary node to the chain of primary facets, one multiplier per node.
pub static NODE_TO_SEGMENT: ContactMethod = ContactMethod {
    name: "node_to_segment",
    summary: "node-to-segment method: no secondary node penetrates the primary side; locks where one polygon encloses another. In two \
              passes: two \
              contacts with the sides swapped, both with `penalty` or `augmented_lagrange`",
    kernel: |secondary, primary, reference| Box::new(NodeToSegment::new(secondary, primary, reference)),
    in_space: Some(CornersInSpace::of_nodes),
    is_nodal: true,
    passes_patch_test: false,
};

/// Search distance beyond the required one, in shortest secondary facets.
const SEARCH_MARGIN: f64 = 1.0;

/// Cosine of the smallest angle at a corner of a rigid chain, 0.1 degrees: a corner between two nodes of the other surface has no other
/// constraint.
const RIGID_CORNER: f64 = 0.999_998;

/// Penetration, in shortest facets, beyond which a node has no corner constraint: initial overlaps are resolved by the constraints of the
/// surfaces, on which corner constraints would depend linearly.
const OVERLAP_OF_SURFACES: f64 = 0.15;

/// Smallest angle of a concave corner (pocket), in degrees.
const POCKET: f64 = 3.0;
/// Largest distance of a node from the vertex of a pocket, in shortest facets.
const POCKET_REACH: f64 = 0.25;

/// Node-to-segment contact of two surfaces.
#[derive(Clone, Debug)]
pub struct NodeToSegment {
    sides: Sides,
    /// Secondary nodes as facets of zero length, so that the facet search finds them.
    points: Surface,
    /// Selection of corners; `None`: contact of all secondary nodes.
    corners: Option<Corners>,
    /// True if the corners of the primary side have constraints of their own.
    is_beside_corners: bool,
    candidates: Candidates,
    window: Window,
    /// Primary facets of each contact element, ascending: candidates, their neighbors and next neighbors.
    facets: Vec<Vec<u32>>,
    start: Vec<PointStart>,
    /// Height profiles of the primary facets; empty for straight facets.
    profiles: Vec<Profile>,
    /// Heights of the secondary curves over the secondary nodes, outwards `[length]`; empty for straight facets.
    own_heights: Vec<f64>,
    /// Reference positions of the nodes `[length]`.
    reference: Vec<f64>,
}

/// Selection of the secondary nodes that count as corners.
#[derive(Clone, Debug)]
enum Corners {
    /// Nodes at bends of either side.
    Bends {
        bends: Bends,
        /// True if corners of the primary side also have constraints against the secondary side.
        is_mutual: bool,
    },
    /// True for each secondary node that is a corner.
    Points(Vec<bool>),
}

impl NodeToSegment {
    /// Contact of two surfaces given by their facets (model node numbers, the body on the left), sized in the reference positions.
    ///
    /// A surface on both sides defines self-contact: the facets of a node, their neighbors and facets on the far side of the body are
    /// excluded.
    pub fn new(secondary: &[[u32; 2]], primary: &[[u32; 2]], reference: &[f64]) -> Self {
        let mut contact = Self::between(Sides::new(secondary, primary, reference), reference);
        let (secondary, primary) = (&contact.sides.secondary, &contact.sides.primary);
        if let Some([facets, others]) = secondary.ranks(primary) {
            let lowest = |row: usize| secondary.adjacent_facets(row).iter().map(|&facet| facets[facet as usize]).min().unwrap_or(0);
            let ranks = (0..secondary.nodes().len()).map(lowest).collect();
            contact.candidates = contact.candidates.once(ranks, others);
        }
        contact
    }

    /// Contact of the corners of the secondary surface only, for penetration that the weighted gaps of a mortar method do not detect.
    /// Corners are nodes at or opposite a bend; if all corners are ends of chains, these ends. `facet_size` is that of the whole contact.
    /// `None` if neither side has a corner in the reference positions.
    ///
    /// Each node has two constraints: in a concave corner of the other side, such as its own imprint, it touches two facets. Two smooth
    /// distances replace one with a kink. Both facets are selected at the start of a step.
    pub fn of_corners([secondary, primary]: [&[[u32; 2]]; 2], reference: &[f64], facet_size: f64, is_beside_nodes: bool) -> Option<Self> {
        let sides = Sides { facet_size, ..Sides::new(secondary, primary, reference) };
        let both = [&sides.secondary, &sides.primary];
        let bends = Bends::new(both, reference, is_beside_nodes);
        let corners = if bends.has_inner_corner(both) {
            Corners::Bends { bends, is_mutual: !is_beside_nodes }
        } else if sides.secondary.is_closed() {
            return None;
        } else {
            Corners::Points(sides.secondary.ends())
        };
        Some(Self::between(sides, reference).with(corners))
    }

    /// Contact of the convex corners and ends of a rigid chain only: its segments have any length, and a corner between two nodes of the
    /// other surface is detected by no other constraint.
    pub fn of_points(chain: &[[u32; 2]], surface: &[[u32; 2]], reference: &[f64], facet_size: f64) -> Self {
        let sides = Sides { facet_size, ..Sides::new(chain, surface, reference) };
        let (bends, ends) = (sides.secondary.bends(reference, RIGID_CORNER), sides.secondary.ends());
        let stands_out = |point: usize| ends[point] || bends[point] && sides.secondary.is_convex(point, reference);
        let points = (0..bends.len()).map(stands_out).collect();
        Self::between(sides, reference).with(Corners::Points(points))
    }

    /// Restricts contact to the given corners, with two constraints each.
    fn with(mut self, corners: Corners) -> Self {
        self.corners = Some(corners);
        self.sides.weights = self.sides.weights.iter().flat_map(|&weight| [weight; 2]).collect();
        self
    }

    /// Contact of all secondary nodes, one constraint each.
    fn between(sides: Sides, reference: &[f64]) -> Self {
        let (secondary, primary) = (&sides.secondary, &sides.primary);
        let points = Surface::new(&secondary.nodes().iter().map(|&node| [node; 2]).collect::<Vec<_>>());
        let candidates = Candidates::new(SEARCH_MARGIN * sides.facet_size).without(points_within_the_body(secondary, primary, reference));
        let window = Window::new(&sides, reference);
        NodeToSegment {
            sides,
            points,
            corners: None,
            is_beside_corners: false,
            candidates,
            window,
            facets: Vec::new(),
            start: Vec::new(),
            profiles: Vec::new(),
            own_heights: Vec::new(),
            reference: reference.to_vec(),
        }
    }

    /// Lists the contact elements of the present candidates, one for each node with candidates.
    fn list_patches(&mut self) {
        self.sides.patches.clear();
        self.facets.clear();
        self.start.clear();
        let stride = self.rows_per_node() as u32;
        for pairs in self.candidates.pairs().chunk_by(|a, b| a[0] == b[0]) {
            let point = pairs[0][0];
            let primary = &self.sides.primary;
            let facets = primary.with_neighbors(&primary.with_neighbors(&pairs.iter().map(|pair| pair[1]).collect::<Vec<_>>()));
            let mut nodes: Vec<u32> = facets.iter().flat_map(|&facet| primary.facets()[facet as usize]).collect();
            nodes.sort_unstable();
            nodes.dedup();
            nodes.insert(0, self.points.nodes()[point as usize]);
            let rows: Vec<u32> = (stride * point..stride * (point + 1)).collect();
            self.sides.patches.push(&nodes, &rows);
            self.facets.push(facets);
        }
    }

    /// Updates corners and bends for the positions `q`.
    fn find_bends(&mut self, q: &[f64]) {
        if let Some(Corners::Bends { bends, .. }) = &mut self.corners {
            bends.find([&self.sides.secondary, &self.sides.primary], q);
        }
    }

    /// Slack of the constraint of a point opposite the given facets in this step, relative to that of a corner; `None` if the point has no
    /// constraint.
    fn slack_beside(&self, point: usize, facets: &[u32]) -> Option<f64> {
        match &self.corners {
            Some(Corners::Points(points)) if !points[point] => None,
            Some(Corners::Bends { bends, .. }) => bends.slack_beside(point, facets, &self.sides.primary),
            _ => Some(1.0),
        }
    }

    /// Index of the secondary node of contact element `p`.
    fn point(&self, p: usize) -> usize {
        self.sides.patches.rows(p)[0] as usize / self.rows_per_node()
    }

    /// Secondary facets adjacent to a point.
    fn own_facets(&self, point: usize) -> &[u32] {
        self.sides.secondary.adjacent_facets(point)
    }

    /// True if a primary facet may be opposite a point in this step.
    fn admits(&self, point: usize, facet: u32, normals: &[[f64; 2]], predicted_motion: &PredictedMotion) -> bool {
        let (node, ends) = (self.points.nodes()[point], self.sides.primary.facets()[facet as usize]);
        let seen = NodePosition::new(node, ends, predicted_motion.q);
        // At a sharp corner, such as a folded tip, it suffices that one of both adjacent facets has an opposite normal.
        let is_opposite = |normal: &[f64; 2]| normal[0] * seen.along[1] - normal[1] * seen.along[0] <= SAME_WAY;
        // If the closest point is an end of the facet, the distance from the facet's line is no measure of penetration.
        let depth = if seen.end.is_none() || seen.gap > 0.0 { seen.gap } else { -seen.distance };
        seen.distance <= self.sides.facet_size + predicted_motion.motion_bound::<2>(&[node], &ends) + predicted_motion.depth
            && normals.iter().any(is_opposite)
            && self.window.admits_depth(0, self.own_facets(point), facet, depth)
            && (self.corners.is_none() || seen.gap > -(OVERLAP_OF_SURFACES * self.sides.facet_size).max(self.window.depth()))
    }

    /// Participating facets and nodes of contact element `p` in this step.
    fn prepare(&self, p: usize, predicted_motion: &PredictedMotion) -> PointStart {
        let (point, nodes, primary) = (self.point(p), self.sides.patches.nodes(p), &self.sides.primary);
        let normals = self.sides.secondary.normals_at(point, predicted_motion.q);
        let is_admitted = |facet: u32| {
            self.candidates.pairs().binary_search(&[point as u32, facet]).is_ok() && self.admits(point, facet, &normals, predicted_motion)
        };
        let mut admitted: Vec<u32> = self.facets[p].iter().copied().filter(|&facet| is_admitted(facet)).collect();
        let slack = self.slack_beside(point, &admitted);
        if slack.is_none() {
            admitted.clear();
        }
        let mut closest = primary.with_neighbors(&admitted);
        let facets = primary.with_neighbors(&closest);
        closest.retain(|&facet| self.candidates.may_list([point as u32, facet]));
        let mut places = vec![0];
        let mut chain = Vec::with_capacity(facets.len());
        for &facet in &facets {
            chain.push(primary.facets()[facet as usize].map(|node| {
                // All nodes but the first of a contact element are in ascending order.
                let place = 1 + nodes[1..].partition_point(|&other| other < node) as u32;
                let known = places[1..].iter().position(|&other| other == place).map(|index| index + 1);
                known.unwrap_or_else(|| {
                    places.push(place);
                    places.len() - 1
                }) as u32
            }));
        }
        let closest = facets.iter().map(|facet| closest.binary_search(facet).is_ok()).collect();
        let profiles = facets.iter().filter_map(|&facet| self.profiles.get(facet as usize).copied()).collect();
        let own_height = self.own_heights.get(point).copied().unwrap_or(0.0);
        PointStart {
            places,
            chain: Chain::new(chain).with_profiles(profiles),
            closest,
            own_height,
            slack: slack.unwrap_or(1.0),
            ..PointStart::default()
        }
    }

    /// Concave corner (pocket) of the other side that contains the point, if the point is near its vertex.
    fn pocket(&self, start: &PointStart) -> Option<[[u32; 2]; 2]> {
        self.corners.as_ref()?;
        let measure = start.chain.measure(&start.positions, &start.closest)?;
        let is_near = measure.covered && start.chain.distance(measure.facet, &start.positions) <= POCKET_REACH * self.sides.facet_size;
        let pocket = start.chain.pocket(measure.facet, &start.positions, POCKET.to_radians().sin());
        pocket.filter(|branches| is_near && branches.iter().all(|[facet, _]| start.closest[*facet as usize]))
    }

    /// Lines that define the gap of a corner that crosses a corner of the other side, or of a node at a node; `Some(None)`: no gap; `None`:
    /// the chain defines it.
    fn crossed(&self, p: usize, start: &PointStart, q: &[f64]) -> Option<Option<Line>> {
        let measure = start.chain.measure(&start.positions, &start.closest)?;
        if self.corners.is_none() {
            if self.is_beside_corners && self.is_passed(self.point(p), &measure, start, q) {
                return Some(None);
            }
            return start.chain.touched_node(&measure, &start.positions).map(Some);
        }
        // If corners of the other side have no constraints, the usual gap applies, to one facet if the corner passes a node in this step.
        let Some(Corners::Bends { is_mutual, .. }) = self.corners else { return None };
        if !is_mutual {
            let facet = start.chain.facet_at_node(&measure, &start.positions, self.sides.facet_size);
            return facet.filter(|_| self.pocket(start).is_none()).map(|facet| Some(Line::Facet(facet)));
        }
        let tip = self.tip(self.point(p), q)?;
        let distance = |tip: &Tip| (tip.at[0] - start.positions[0]).hypot(tip.at[1] - start.positions[1]);
        let tips = start.chain.corners().filter(|(facets, _)| facets.contains(&measure.facet)).map(|(facets, nodes)| {
            let [before, at, after] = nodes.map(|node| [start.positions[2 * node as usize], start.positions[2 * node as usize + 1]]);
            (facets, Tip { before, at, after })
        });
        let (facets, other) = tips.min_by(|a, b| distance(&a.1).total_cmp(&distance(&b.1)))?;
        match tip.parting(&other)? {
            SeparatingSide::AtOther(side) => (facets[side] != measure.facet).then_some(Some(Line::Facet(facets[side]))),
            SeparatingSide::AtOwn { misleading } => {
                let side = usize::from(facets[1] == measure.facet);
                (misleading[side] && measure.gap < 0.0).then_some(None)
            }
        }
    }

    /// True if a corner of the other side passes a node: the constraint of the corner against the facets of the node acts, not the node's
    /// own one, which would push the node back from the side of the corner that lies ahead (`edge_plane.rs`).
    fn is_passed(&self, point: usize, measure: &Measure, start: &PointStart, q: &[f64]) -> bool {
        let (size, Some(tip)) = (self.sides.facet_size, self.tip(point, q)) else { return false };
        let Some(at) = start.chain.at_corner(measure, &start.positions, ACROSS_EDGE * size) else { return false };
        let around = [tip.before, tip.after].map(|node| Vector2::from(node) - Vector2::from(tip.at)).to_vec();
        let facing = self.sides.secondary.normals_at(point, q).into_iter().map(|normal| -Vector2::from(normal)).collect();
        NodeAtEdge { at, x: tip.at.into(), around, facing, size, is_beside_corners: true }.is_passed()
    }

    /// Corner at a secondary node, with both adjacent nodes.
    fn tip(&self, point: usize, q: &[f64]) -> Option<Tip> {
        let &[one, other] = self.own_facets(point) else { return None };
        let [one, other] = [one, other].map(|facet| self.sides.secondary.facets()[facet as usize]);
        let (first, second) = if one[1] == self.points.nodes()[point] { (one, other) } else { (other, one) };
        let [before, at, after] = [first[0], second[0], second[1]].map(|node| [q[2 * node as usize], q[2 * node as usize + 1]]);
        Some(Tip { before, at, after })
    }

    /// True if a corner is too deep for a constraint: the facets belong to the far side of the body, or to an initial overlap.
    fn is_overlapped(&self, start: &PointStart) -> bool {
        self.corners.is_some() && start.measures.iter().flatten().any(|measure| measure.gap <= -OVERLAP_OF_SURFACES * self.sides.facet_size)
    }

    /// Sets the height profiles of the facets of both sides.
    fn set_profiles(&mut self, [secondary, primary]: [Vec<Profile>; 2]) {
        let surface = &self.sides.secondary;
        let mean_height = |node: usize| {
            let facets = surface.adjacent_facets(node);
            let height = |&facet: &u32| {
                let end = if surface.local_facets()[facet as usize][0] as usize == node { 0.0 } else { 1.0 };
                surface.facet_measure(facet as usize, &self.reference) * secondary[facet as usize].at(end)[0]
            };
            facets.iter().map(height).sum::<f64>() / facets.len() as f64
        };
        self.own_heights = (0..surface.nodes().len()).map(mean_height).collect();
        self.profiles = primary;
    }
}

/// Pairs (point, primary facet) of self-contact that are excluded, ascending: pairs that are excluded for one of the facets adjacent to the
/// point.
fn points_within_the_body(secondary: &Surface, primary: &Surface, reference: &[f64]) -> Vec<[u32; 2]> {
    let mut pairs = Vec::new();
    for [own, other] in within_the_body(secondary, primary, reference) {
        pairs.extend(secondary.local_facets()[own as usize].map(|node| [node, other]));
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

impl PatchFunctions for NodeToSegment {
    fn sides(&self) -> &Sides {
        &self.sides
    }

    fn set(&mut self, setting: Setting) {
        match setting {
            Setting::Profiles(profiles) => self.set_profiles(profiles),
            Setting::BesideCorners => self.is_beside_corners = true,
            Setting::AboutAxis | Setting::Correction(_) | Setting::Workers(_) => {}
        }
    }

    fn is_nodal(&self) -> bool {
        true
    }

    fn rows_per_node(&self) -> usize {
        if self.corners.is_some() { 2 } else { 1 }
    }

    fn row_nodes(&self) -> &[u32] {
        self.points.nodes()
    }

    fn start_gap(&self) -> Vec<f64> {
        node_patch::start_gaps(&self.sides, &self.start)
    }

    fn slacks(&self) -> Vec<f64> {
        let mut slacks = vec![1.0; self.sides.weights.len()];
        for (p, start) in self.start.iter().enumerate() {
            self.sides.patches.rows(p).iter().for_each(|&row| slacks[row as usize] = start.slack);
        }
        slacks
    }

    fn begin_step(&mut self, q_0: &[f64]) {
        let mut starts = std::mem::take(&mut self.start);
        for (p, start) in starts.iter_mut().enumerate() {
            let crossed = |start: &PointStart| self.crossed(p, start, q_0);
            start.begin(self.sides.patches.nodes(p), q_0, crossed, |start| self.pocket(start), |start| self.is_overlapped(start));
        }
        self.start = starts;
    }

    fn evaluate(&self, derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation) {
        node_patch::evaluate(&self.sides, &self.start, derivative, q_1, lambda, out);
    }

    fn evaluate_slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        let slips = node_patch::Slips { sides: &self.sides, starts: &self.start, turned: 0.0 };
        slip::evaluate(&slips, &self.sides.patches, step, lambda, out);
    }

    fn gap(&self, q: &[f64]) -> Vec<f64> {
        node_patch::gaps(&self.sides, &self.start, q)
    }

    fn coverage(&self, q: &[f64]) -> Vec<f64> {
        node_patch::coverage(&self.sides, &self.start, q)
    }
}

impl CandidateSearch for NodeToSegment {
    fn update_candidates(&mut self, predicted_motion: &PredictedMotion) -> bool {
        let changed =
            self.candidates.update(&self.points, &self.sides.primary, predicted_motion.q, predicted_motion.search_margin(&self.sides));
        self.window.begin(&self.sides, predicted_motion.depth);
        self.find_bends(predicted_motion.q);
        if changed {
            self.list_patches();
        }
        self.start = (0..self.sides.patches.len()).map(|p| self.prepare(p, predicted_motion)).collect();
        changed
    }

    fn overlooks(&self, q_0: &[f64], q_1: &[f64], tolerance: f64) -> bool {
        let moved: Vec<f64> = q_1.iter().zip(q_0).map(|(a, b)| a - b).collect();
        let predicted_motion = PredictedMotion {
            q: q_0,
            motion_bound: MotionBound::Guessed { displacements: [&moved; 2], factor: 1.0 },
            reach: 1.0,
            depth: self.window.depth(),
        };
        let deepest = self.window.deepest(&self.sides, q_1);
        let at_end = self.candidates.pairs_within(&self.points, &self.sides.primary, q_1, deepest);
        at_end.iter().any(|&[point, facet]| {
            let (point, ends) = (point as usize, self.sides.primary.facets()[facet as usize]);
            let node = self.points.nodes()[point];
            let end = NodePosition::new(node, ends, q_1);
            let closed = end.end.is_none() && end.gap < -tolerance && self.window.admits_depth(0, self.own_facets(point), facet, end.gap);
            closed && NodePosition::new(node, ends, q_0).gap > 0.0 && {
                // Count only facets that would have been admitted if the motion had been known at the start.
                let p = self.facets.iter().enumerate().position(|(p, _)| self.point(p) == point);
                let was = p.is_some_and(|p| {
                    let (start, nodes) = (&self.start[p], self.sides.patches.nodes(p));
                    let is_it = |local: &[u32; 2]| local.map(|index| nodes[start.places[index as usize] as usize]) == ends;
                    start.chain.facets().iter().zip(&start.closest).any(|(local, closest)| *closest && is_it(local)) || start.is_excluded
                });
                !was && self.slack_beside(point, &[facet]).is_some()
                    && self.admits(point, facet, &self.sides.secondary.normals_at(point, q_0), &predicted_motion)
            }
        })
    }

    fn for_each_participant(&self, p: usize, visit: &mut dyn FnMut(u32)) {
        let nodes = self.sides.patches.nodes(p);
        self.start[p].places.iter().map(|&place| nodes[place as usize]).for_each(visit);
    }

    fn candidates(&self) -> Option<&Candidates> {
        Some(&self.candidates)
    }

    fn restore_candidates(&mut self, candidates: &Candidates, q: &[f64]) {
        self.candidates = candidates.clone();
        self.find_bends(q);
        self.list_patches();
        let predicted_motion = PredictedMotion::within(q, 0.0);
        self.window.begin(&self.sides, predicted_motion.depth);
        self.start = (0..self.sides.patches.len()).map(|p| self.prepare(p, &predicted_motion)).collect();
        self.begin_step(q);
    }

    fn deepest(&self, q: &[f64]) -> f64 {
        node_patch::deepest(&self.sides, &self.start, q)
    }
}

impl RigidObstacle for NodeToSegment {}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::super::fixtures::{Rings, dense_rows, difference, evaluated, product, rings, turned, unbalance};
    use super::*;
    use crate::integrators::Configuration;

    /// A node over a chain of three facets with random convex and concave corners, and a random step: nodes slide over facet borders,
    /// penetrate, and leave the chain at its ends.
    fn step() -> impl Strategy<Value = (Vec<f64>, Vec<f64>)> {
        let size = prop::sample::select(vec![1e-4, 1e-2, 0.1, 0.5]);
        (prop::array::uniform10(-0.3..0.3f64), -0.2..3.2f64, prop::array::uniform10(-1.0..1.0f64), size).prop_map(
            |(noise, at, motion, size)| {
                let base = [at, 0.0, 3.0, 0.0, 2.0, 0.0, 1.0, 0.0, 0.0, 0.0];
                let q_0: Vec<f64> = (0..10).map(|i| 5.0 + base[i] + noise[i]).collect();
                let q_1 = q_0.iter().zip(&motion).map(|(q, d)| q + size * d).collect();
                (q_0, q_1)
            },
        )
    }

    /// Node 0 in the middle of a surface that faces down, above the chain of nodes 1 to 4 with the body below.
    fn node_on_chain(q_0: &[f64]) -> NodeToSegment {
        let mut reference = q_0.to_vec();
        reference.extend([q_0[0] - 1.0, q_0[1], q_0[0] + 1.0, q_0[1]]);
        let mut kernel = NodeToSegment::new(&[[5, 0], [0, 6]], &[[1, 2], [2, 3], [3, 4]], &reference);
        kernel.update_candidates(&PredictedMotion::within(&reference, 100.0));
        kernel.begin_step(&reference);
        kernel
    }

    fn with_ends(q: &[f64], q_0: &[f64]) -> Vec<f64> {
        let mut all = q.to_vec();
        all.extend([q_0[0] - 1.0, q_0[1], q_0[0] + 1.0, q_0[1]]);
        all
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 3000, rng_seed: RngSeed::Fixed(2007), failure_persistence: None, ..Default::default() })]

        #[test]
        fn the_discrete_gradient_is_directional_and_balanced((q_0, q_1) in step()) {
            let kernel = node_on_chain(&q_0);
            let (from, to) = (with_ends(&q_0, &q_0), with_ends(&q_1, &q_0));
            let lambda = [1.0, 2.0, 3.0];
            let out = evaluated(&kernel, Derivative::DiscreteGradient, &to, &lambda);
            prop_assert_eq!(&out.gap, &kernel.gap(&to));
            let rows = dense_rows(&kernel, &out.gradient_bar, 14);
            let (start, moved) = (kernel.start_gap(), difference(&to, &from));
            for (row, gradient) in rows.iter().enumerate() {
                // Scale of the round-off: positions up to 5, and gradients, which are large where the function jumps at an end.
                let size: f64 = 1.0 + gradient.iter().map(|g| g.abs()).sum::<f64>();
                let defect = product(gradient, &moved) - (out.gap[row] - start[row]);
                prop_assert!(defect.abs() < 1e-14 * size, "{defect:e} of {size}");
            }
            let middle: Vec<f64> = from.iter().zip(&to).map(|(a, b)| 0.5 * (a + b)).collect();
            let size = 1.0 + out.gradient_bar.iter().map(|g| g.abs()).sum::<f64>();
            prop_assert!(unbalance(&rows, &middle) < 1e-14 * size);
            for (derivative, arms) in [(Derivative::Gradient(Configuration::Middle), &middle), (Derivative::AT_END, &to)] {
                let out = evaluated(&kernel, derivative, &to, &lambda);
                prop_assert!(unbalance(&dense_rows(&kernel, &out.gradient_bar, 14), arms) < 1e-13);
                prop_assert!(unbalance(&dense_rows(&kernel, &out.gradient_end, 14), &to) < 1e-13);
            }
        }

        #[test]
        fn tangents_agree_with_differences((q_0, q_1) in step(), direction in prop::collection::vec(-1.0..1.0f64, 14)) {
            let kernel = node_on_chain(&q_0);
            let (from, to) = (with_ends(&q_0, &q_0), with_ends(&q_1, &q_0));
            let width = q_0.iter().zip(&q_1).fold(0.0, |largest: f64, (a, b)| largest.max((b - a).abs()));
            if width < 1e-3 {
                // For tiny increments the round-off of the quotient (1e-15 over the increment) exceeds the compared difference.
                return Ok(());
            }
            let step = f64::min(2e-4, 0.005 * width);
            // All difference quotients must use one facet: no kink and no end of the chain near the evaluated configurations.
            let facet = |q: &[f64], row: usize| {
                let p = (0..kernel.patches().len()).find(|&p| kernel.patches().rows(p)[0] as usize == row).unwrap();
                kernel.start[p].measures(&{
                    let mut z = Vec::new();
                    kernel.start[p].gather_into(kernel.patches().nodes(p), q, &mut z);
                    z
                })[0]
                .map(|measure| measure.facet)
            };
            let middle = |end: &[f64]| -> Vec<f64> { from.iter().zip(end).map(|(a, b)| 0.5 * (a + b)).collect() };
            let row = kernel.secondary().index(0).unwrap();
            let seen = |end: &[f64]| [facet(&middle(end), row), facet(end, row)];
            let moved = |shift: f64| -> Vec<f64> { to.iter().zip(&direction).map(|(x, d)| x + shift * step * d).collect() };
            prop_assume!([-3.0, 3.0].into_iter().all(|shift| seen(&moved(shift)) == seen(&to)));
            let mut lambda = [0.0; 3];
            lambda[row] = 1.5;
            for derivative in Derivative::ALL {
                let out = evaluated(&kernel, derivative, &to, &lambda);
                let p = (0..kernel.patches().len()).find(|&p| kernel.patches().rows(p)[0] as usize == row).unwrap();
                let (nodes, unknowns) = (kernel.patches().nodes(p), kernel.patches().unknowns(p));
                let tangent = &out.tangent[kernel.patches().tangent_range(p)];
                let size = tangent.iter().fold(1.0, |largest: f64, t| largest.max(t.abs()));
                let own: Vec<f64> = (0..unknowns).map(|k| direction[2 * nodes[k / 2] as usize + k % 2]).collect();
                let at = |shift: f64| {
                    let out = evaluated(&kernel, derivative, &moved(shift), &lambda);
                    out.gradient_bar[kernel.patches().gradient_range(p)].iter().map(|g| 1.5 * g).collect::<Vec<_>>()
                };
                let (a, b, c, d) = (at(-2.0), at(-1.0), at(1.0), at(2.0));
                for i in 0..unknowns {
                    let expected = (a[i] - 8.0 * b[i] + 8.0 * c[i] - d[i]) / (12.0 * step);
                    let ours = product(&tangent[i * unknowns..(i + 1) * unknowns], &own);
                    // Error of difference quotients of width 5e-3 of the increment; round-off is 1e-13 over a step of at least 5e-6.
                    prop_assert!((ours - expected).abs() < 1e-6 * size, "{derivative:?} [{i}] {ours} {expected}");
                }
            }
        }
    }

    #[test]
    fn rings_that_slide_by_several_facets_keep_energy_and_momenta() {
        for (clearance, secondary_inside) in [(-0.002, true), (0.01, true), (0.01, false)] {
            let Rings { inner, outer, q } = rings(40, 48, clearance);
            let mut kernel = if secondary_inside { NodeToSegment::new(&inner, &outer, &q) } else { NodeToSegment::new(&outer, &inner, &q) };
            let q_0 = turned(&q, 40, 0.3, 1e-3);
            let q_1 = turned(&q_0, 40, 0.4, 2e-3); // 2.5 facets
            assert!(kernel.update_candidates(&PredictedMotion::within(&q_0, 0.5)));
            kernel.begin_step(&q_0);
            let count = kernel.secondary().nodes().len();
            let lambda: Vec<f64> = (0..count).map(|node| 1.0 + 0.5 * (node as f64).sin()).collect();
            let out = evaluated(&kernel, Derivative::DiscreteGradient, &q_1, &lambda);
            assert_eq!(out.coverage, vec![1.0; count]);
            let rows = dense_rows(&kernel, &out.gradient_bar, q.len());
            let (start, moved) = (kernel.start_gap(), difference(&q_1, &q_0));
            for (node, row) in rows.iter().enumerate() {
                assert!((product(row, &moved) - (out.gap[node] - start[node])).abs() < 1e-15, "node {node}");
            }
            let middle: Vec<f64> = q_0.iter().zip(&q_1).map(|(a, b)| 0.5 * (a + b)).collect();
            assert!(unbalance(&rows, &middle) < 1e-15);
        }
    }

    /// Facets that pass each other while the candidate list is kept are not opposite any more, as for mortar methods.
    #[test]
    fn facets_that_have_moved_apart_are_no_opposite() {
        let q_0 = [0.0, 0.0, 1.0, 0.0, 1.0, -0.1, 0.0, -0.1];
        let mut kernel = NodeToSegment::new(&[[0, 1]], &[[2, 3]], &q_0);
        assert!(kernel.update_candidates(&PredictedMotion::within(&q_0, 0.5)));
        assert!((kernel.gap(&q_0)[0] - 0.05).abs() < 1e-15);
        let q_1 = [0.0, 0.0, 1.0, 0.0, 1.0, 5.0, 0.0, 5.0];
        assert!(!kernel.update_candidates(&PredictedMotion::within(&q_1, 0.5)), "the list is kept");
        kernel.begin_step(&q_1);
        assert_eq!((kernel.gap(&q_1), kernel.coverage(&q_1)), (vec![0.0; 2], vec![0.0; 2]));
    }

    /// Nodes whose normals have the direction of the nearest facets' normals, as on the far side of a thin plate, have no opposite facet.
    #[test]
    fn the_back_of_a_thin_body_is_no_opposite() {
        // Chain along x with the body below; the surface above faces up.
        let q = [1.0, 0.0, 0.0, 0.0, 0.2, -0.1, 0.8, -0.1];
        let mut kernel = NodeToSegment::new(&[[3, 2]], &[[0, 1]], &q);
        kernel.update_candidates(&PredictedMotion::within(&q, 1.0));
        kernel.begin_step(&q);
        assert_eq!((kernel.coverage(&q), kernel.gap(&q)), (vec![0.0; 2], vec![0.0; 2]));
        let mut kernel = NodeToSegment::new(&[[2, 3]], &[[0, 1]], &q);
        kernel.update_candidates(&PredictedMotion::within(&q, 1.0));
        kernel.begin_step(&q);
        assert_eq!(kernel.coverage(&q), [1.0; 2]);
        assert!(kernel.gap(&q).iter().all(|gap| (gap + 0.3 * 0.1).abs() < 1e-16));
    }
}
