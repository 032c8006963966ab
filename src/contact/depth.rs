//! Penetration depth of nodes of either side in the other body, node by node: weighted gaps are mean values and do not bound the
//! penetration.

use super::faces;
use super::search::PairSearch;
use super::surface::{Sides, Surface};

/// Position of a node relative to a facet.
pub(super) struct NodePosition {
    /// Distances of the node from the facet and from the line of the facet `[length]`.
    pub(super) distance: f64,
    pub(super) gap: f64,
    /// Unit vector along the facet.
    pub(super) along: [f64; 2],
    /// End of the facet that is the closest point, if the closest point is an end.
    pub(super) end: Option<usize>,
    /// Facet coordinate of the closest point, 0 to 1.
    share: f64,
    /// Length of the facet `[length]`.
    length: f64,
}

impl NodePosition {
    /// Relative position of a node and a facet at the positions `q`.
    pub(super) fn new(node: u32, facet: [u32; 2], q: &[f64]) -> Self {
        let at = |node: u32| [q[2 * node as usize], q[2 * node as usize + 1]];
        let (x, [a, b]) = (at(node), facet.map(at));
        let (t, d) = ([b[0] - a[0], b[1] - a[1]], [x[0] - a[0], x[1] - a[1]]);
        let length = t[0].hypot(t[1]);
        let along = t.map(|t| t / length);
        let s = along[0] * d[0] + along[1] * d[1];
        let (gap, beyond) = (along[1] * d[0] - along[0] * d[1], s - s.clamp(0.0, length));
        let end = (beyond != 0.0).then_some(usize::from(beyond > 0.0));
        NodePosition { distance: gap.hypot(beyond), gap, along, end, share: s.clamp(0.0, length) / length, length }
    }

    /// Gap of the node to the surface near `facet`. At a corner the body is the intersection or the union of two half planes. `None`
    /// beyond the end of a chain.
    fn gap_to(&self, node: u32, surface: &Surface, facet: usize, q: &[f64]) -> Option<f64> {
        let Some(end) = self.end else { return Some(self.gap) };
        let neighbor = surface.neighbors(facet)[end]? as usize;
        let other = NodePosition::new(node, surface.facets()[neighbor], q);
        let turn = self.along[0] * other.along[1] - self.along[1] * other.along[0];
        let is_convex = if end == 1 { turn > 0.0 } else { turn < 0.0 };
        Some(if is_convex { self.gap.max(other.gap) } else { self.gap.min(other.gap) })
    }
}

impl PairSearch {
    /// Largest penetration `[length]` at `q` of a node of either side in the other body, over the facet pairs that take part in the step.
    pub fn deepest(&self, sides: &Sides, q: &[f64]) -> f64 {
        if sides.secondary.dimension() == 3 {
            return self.deepest_in_space(sides, q, |_, _, flat| flat);
        }
        let surfaces = [&sides.secondary, &sides.primary];
        let mut deepest = 0.0f64;
        for own in 0..2 {
            let (surface, other) = (surfaces[own], surfaces[1 - own]);
            let mut closest: Vec<Option<(u32, NodePosition)>> = std::iter::repeat_with(|| None).take(surface.nodes().len()).collect();
            for (pair, _) in self.candidates.pairs().iter().zip(&self.near).filter(|(_, near)| **near) {
                let (own_facet, facet) = (pair[own] as usize, pair[1 - own]);
                for &index in &surface.local_facets()[own_facet] {
                    let seen = NodePosition::new(surface.nodes()[index as usize], other.facets()[facet as usize], q);
                    let known = &mut closest[index as usize];
                    if known.as_ref().is_none_or(|(_, known)| seen.distance < known.distance) {
                        *known = Some((facet, seen));
                    }
                }
            }
            // Height of the curve over a facet of the other side, at the point closest to a node.
            let height = |facet: u32, seen: &NodePosition| {
                self.profiles[1 - own].get(facet as usize).map_or(0.0, |profile| seen.length * profile.at(seen.share)[0])
            };
            for (index, found) in closest.into_iter().enumerate() {
                let Some((facet, seen)) = found.filter(|(facet, seen)| height(*facet, seen) - seen.gap > deepest) else { continue };
                // At a sharp corner, the nearest facet may be a neighbor that forms no pair with the facets of this node.
                let node = surface.nodes()[index];
                let around = other.neighbors(facet as usize).into_iter().flatten();
                let around = around.map(|facet| (facet, NodePosition::new(node, other.facets()[facet as usize], q)));
                let nearer = |nearest: (u32, NodePosition), next: (u32, NodePosition)| {
                    if next.1.distance < nearest.1.distance { next } else { nearest }
                };
                let (facet, seen) = around.fold((facet, seen), nearer);
                let gap = seen.gap_to(node, other, facet as usize, q).map_or(0.0, |gap| gap - height(facet, &seen));
                if self.window.admits_depth(own, surface.adjacent_facets(index), facet, gap) {
                    deepest = deepest.max(-gap);
                }
            }
        }
        deepest
    }

    /// Largest penetration of a node in space `[length]`. A node whose closest point lies on the border of a facet is in front of an edge
    /// and does not count. `gap` corrects a gap to the flat facet by height profiles; its arguments are the node (side and index), the
    /// facet of the other side and the gap.
    pub(super) fn deepest_in_space(&self, sides: &Sides, q: &[f64], gap: impl Fn([usize; 2], u32, f64) -> f64) -> f64 {
        let surfaces = [&sides.secondary, &sides.primary];
        let mut deepest = 0.0f64;
        for own in 0..2 {
            let (surface, other) = (surfaces[own], surfaces[1 - own]);
            let mut closest: Vec<Option<(u32, faces::FacetDistance)>> = vec![None; surface.nodes().len()];
            for (pair, _) in self.candidates.pairs().iter().zip(&self.near).filter(|(_, near)| **near) {
                for &index in surface.local_facet(pair[own] as usize) {
                    let node = faces::at(surface.nodes()[index as usize], q);
                    let seen = faces::FacetDistance::new(node, other.facet(pair[1 - own] as usize), q);
                    let known = &mut closest[index as usize];
                    if known.is_none_or(|(_, known)| seen.distance < known.distance) {
                        *known = Some((pair[1 - own], seen));
                    }
                }
            }
            for (index, found) in closest.into_iter().enumerate() {
                let is_deep =
                    |&(facet, seen): &(u32, faces::FacetDistance)| !seen.is_beside && -gap([own, index], facet, seen.gap) > deepest;
                let Some((facet, seen)) = found.filter(is_deep) else { continue };
                // At a sharp edge, the nearest facet may be a neighbor that forms no pair with the facets of this node.
                let node = faces::at(surface.nodes()[index], q);
                let around = other.local_facet(facet as usize).iter().flat_map(|&corner| other.adjacent_facets(corner as usize));
                let around = around.map(|&facet| (facet, faces::FacetDistance::new(node, other.facet(facet as usize), q)));
                let (facet, seen) = around.fold((facet, seen), |near, next| if next.1.distance < near.1.distance { next } else { near });
                let gap = gap([own, index], facet, seen.gap);
                if self.window.admits_depth(own, surface.adjacent_facets(index), facet, gap) {
                    deepest = deepest.max(-gap);
                }
            }
        }
        deepest
    }

    /// Relative depth of the deepest crossing of facets of both sides at `q`: the least distance of an end of either facet from the other
    /// facet, divided by the longer facet. It is at most the depth of a node that has entered the other body, and positive where corners
    /// have crossed without a node inside. Plane only; 0 in space.
    pub fn crossing(&self, sides: &Sides, q: &[f64]) -> f64 {
        if sides.secondary.dimension() == 3 {
            return 0.0;
        }
        let at = |node: u32| [q[2 * node as usize], q[2 * node as usize + 1]];
        let mut worst = 0.0f64;
        for &[own, other] in self.candidates.pairs() {
            let (own, other) = (sides.secondary.facets()[own as usize], sides.primary.facets()[other as usize]);
            let seen = own.map(|node| NodePosition::new(node, other, q));
            if seen[0].gap * seen[1].gap >= 0.0 {
                continue;
            }
            let back = other.map(|node| NodePosition::new(node, own, q));
            if back[0].gap * back[1].gap < 0.0 {
                let least = seen.iter().chain(&back).map(|seen| seen.distance).fold(f64::INFINITY, f64::min);
                let length = |[a, b]: [u32; 2]| (at(b)[0] - at(a)[0]).hypot(at(b)[1] - at(a)[1]);
                worst = worst.max(least / length(own).max(length(other)));
            }
        }
        worst
    }
}
