//! Corners of plane surfaces: nodes at which a surface is bent so much that weighted gaps alone would let them in.

use super::surface::Surface;

/// Cosine of the turn of a surface above which it has a corner, 20 degrees: a constraint of a node at a smooth bend would keep the surfaces
/// apart that weighted gaps bring together.
const CORNER: f64 = 0.9397;

/// Cosine of the turn of a bend that weighted gaps let in too far where another one lies opposite, 12 degrees: two of 20 meet with a depth
/// of a seventh of a facet.
const BEND: f64 = 0.978;

/// Slack of the constraints of such bends over that of corners: they leave alone what weighted gaps let in at a single bend.
const BEND_SLACK: f64 = 3.5;

/// Cosine of the turn of a corner where the contact itself constrains single nodes, 10 degrees: no weighted gap sees nodes of its other
/// side.
const CORNER_BESIDE_NODES: f64 = 0.985;

/// Cosine of the turn down to which a corner in the reference positions stays one while the body yields, 2 degrees.
const BENT: f64 = 0.9994;

/// Corners of both sides of a contact.
#[derive(Clone, Debug)]
pub struct Bends {
    sharp: BentNodes,
    blunt: BentNodes,
}

impl Bends {
    /// Corners in the reference positions. `is_beside_nodes`: the contact constrains single nodes.
    pub fn new(sides: [&Surface; 2], reference: &[f64], is_beside_nodes: bool) -> Self {
        let cosines = if is_beside_nodes { [CORNER_BESIDE_NODES; 2] } else { [CORNER, BEND] };
        let [sharp, blunt] = cosines.map(|cosine| BentNodes::new(sides, reference, cosine));
        Bends { sharp, blunt }
    }

    /// True if a node of either side is bent in the reference positions that is no end of a chain.
    pub fn has_inner_corner(&self, sides: [&Surface; 2]) -> bool {
        let within = |(side, bends): (&Surface, &Vec<bool>)| bends.iter().zip(side.ends()).any(|(bent, end)| *bent && !end);
        sides.into_iter().zip(&self.blunt.reference).any(within)
    }

    /// Finds the corners at the positions `q`.
    pub fn find(&mut self, sides: [&Surface; 2], q: &[f64]) {
        self.sharp.find(sides, q);
        self.blunt.find(sides, q);
    }

    /// Slack of the constraint of a secondary node opposite these primary facets over that of a corner; `None` where neither side is bent.
    pub fn slack_beside(&self, point: usize, facets: &[u32], primary: &Surface) -> Option<f64> {
        if self.sharp.are_at(point, facets, primary) {
            return Some(1.0);
        }
        self.blunt.are_at(point, facets, primary).then_some(BEND_SLACK)
    }
}

/// Nodes of both sides at which the surfaces turn by more than an angle.
#[derive(Clone, Debug)]
struct BentNodes {
    /// Cosine of the angle.
    cosine: f64,
    /// Bent nodes in the reference positions.
    reference: [Vec<bool>; 2],
    /// Bent nodes at the start of the step.
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

    /// True if the secondary node, or a node of some primary facets, is bent.
    fn are_at(&self, point: usize, facets: &[u32], other: &Surface) -> bool {
        let [own, others] = &self.now;
        own[point] || facets.iter().any(|&facet| other.local_facets()[facet as usize].iter().any(|&node| others[node as usize]))
    }
}
