//! Corners and bends of plane surfaces, at which weighted gaps admit too much penetration: their nodes get constraints by
//! `node_to_segment.rs`.

use super::surface::Surface;

/// Cosine of the smallest angle between adjacent facets at a corner, 20 degrees. Nodal constraints at smoother bends would separate
/// surfaces that weighted gaps bring into contact.
const CORNER: f64 = 0.9397;

/// Cosine of the smallest angle between adjacent facets at a bend, 12 degrees. With weighted gaps alone, two bends of 20 degrees that touch
/// penetrate by a seventh of a facet.
const BEND: f64 = 0.978;

/// Slack (admitted overlap) of constraints at bends, relative to that of corners. Larger than the penetration that weighted gaps leave at a
/// single bend.
const BEND_SLACK: f64 = 3.5;

/// Cosine of the smallest angle at a corner for methods with nodal constraints, 10 degrees: there no weighted gap constrains the primary
/// nodes.
pub(super) const CORNER_BESIDE_NODES: f64 = 0.985;

/// Cosine of the angle, 2 degrees, above which a corner of the reference positions remains a corner as the body deforms.
const BENT: f64 = 0.9994;

/// Corners and bends of both sides of a contact.
#[derive(Clone, Debug)]
pub struct Bends {
    sharp: BentNodes,
    blunt: BentNodes,
}

impl Bends {
    /// Corners and bends in the reference positions. `is_beside_nodes`: the contact method has nodal constraints.
    pub fn new(sides: [&Surface; 2], reference: &[f64], is_beside_nodes: bool) -> Self {
        let cosines = if is_beside_nodes { [CORNER_BESIDE_NODES; 2] } else { [CORNER, BEND] };
        let [sharp, blunt] = cosines.map(|cosine| BentNodes::new(sides, reference, cosine));
        Bends { sharp, blunt }
    }

    /// True if a node inside of a chain, of either side, is a corner or bend in the reference positions.
    pub fn has_inner_corner(&self, sides: [&Surface; 2]) -> bool {
        let within = |(side, bends): (&Surface, &Vec<bool>)| bends.iter().zip(side.ends()).any(|(bent, end)| *bent && !end);
        sides.into_iter().zip(&self.blunt.reference).any(within)
    }

    /// Updates corners and bends for the positions `q`.
    pub fn find(&mut self, sides: [&Surface; 2], q: &[f64]) {
        self.sharp.find(sides, q);
        self.blunt.find(sides, q);
    }

    /// Slack of the constraint of secondary node `point` opposite the primary `facets`, relative to that of a corner; `None` if neither
    /// side has a corner or bend there.
    pub fn slack_beside(&self, point: usize, facets: &[u32], primary: &Surface) -> Option<f64> {
        if self.sharp.are_at(point, facets, primary) {
            return Some(1.0);
        }
        self.blunt.are_at(point, facets, primary).then_some(BEND_SLACK)
    }
}

/// Nodes of both sides at which adjacent facets make more than a given angle.
#[derive(Clone, Debug)]
struct BentNodes {
    /// Cosine of the smallest angle of a bent node.
    cosine: f64,
    /// True for each bent node in the reference positions.
    reference: [Vec<bool>; 2],
    /// True for each bent node at the start of the step.
    now: [Vec<bool>; 2],
}

impl BentNodes {
    fn new(sides: [&Surface; 2], reference: &[f64], cosine: f64) -> Self {
        let bends = sides.map(|side| side.bends(reference, cosine));
        BentNodes { cosine, now: bends.clone(), reference: bends }
    }

    fn find(&mut self, sides: [&Surface; 2], q: &[f64]) {
        for (side, surface) in sides.into_iter().enumerate() {
            let [is_corner, is_bent] = [self.cosine, BENT].map(|cosine| surface.bends(q, cosine));
            self.now[side] = (0..is_bent.len()).map(|node| is_corner[node] || is_bent[node] && self.reference[side][node]).collect();
        }
    }

    /// True if secondary node `point`, or a node of the primary `facets`, is bent.
    fn are_at(&self, point: usize, facets: &[u32], other: &Surface) -> bool {
        let [own, others] = &self.now;
        own[point] || facets.iter().any(|&facet| other.local_facets()[facet as usize].iter().any(|&node| others[node as usize]))
    }
}
