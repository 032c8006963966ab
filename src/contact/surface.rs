//! Contact surface: in the plane one or more chains of oriented straight facets, the body on the left; in space facets of three or four
//! nodes, counter-clockwise as seen from outside.
//!
//! Connectivity only; positions are arguments. Local node numbers ascend with the model numbers. A surface may be open, closed or in
//! several parts.

use super::faces;
use super::patches::Patches;

/// Oriented facets and their nodes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Surface {
    dimension: usize,
    nodes: Vec<u32>,
    /// Model numbers of the nodes of all facets, facet by facet.
    of_facets: Vec<u32>,
    /// Indices in `nodes` of the nodes of all facets, facet by facet.
    local_of_facets: Vec<u32>,
    /// Start of each facet's nodes in `of_facets`; at the end their number.
    starts: Vec<usize>,
    /// Start of each node's facets in `adjacent`; at the end their number.
    adjacent_start: Vec<u32>,
    /// Facets at each node, node by node.
    adjacent: Vec<u32>,
}

/// Data of every contact method for two surfaces: secondary and primary surface, contact elements, reference weights.
#[derive(Clone, Debug)]
pub struct Sides {
    /// Side with the multipliers.
    pub secondary: Surface,
    /// Side without multipliers.
    pub primary: Surface,
    /// Contact elements of the present candidates.
    pub patches: Patches,
    /// Contact elements with two tangential constraints for each normal one; used in space.
    pub tangential: Patches,
    /// Weights of the constraints: lengths in the plane, areas in space `[length^(D-1)]`.
    pub weights: Vec<f64>,
    /// Tributary lengths or areas of the secondary nodes in the reference positions `[length^(D-1)]`.
    pub lengths: Vec<f64>,
    /// Size of the smallest secondary facet `[length]`.
    pub facet_size: f64,
}

impl Sides {
    /// Two surfaces in the plane by their facets, without contact elements; one constraint per secondary node.
    pub fn new(secondary: &[[u32; 2]], primary: &[[u32; 2]], reference: &[f64]) -> Self {
        Sides::of(Surface::new(secondary), Surface::new(primary), reference)
    }

    /// Two surfaces without contact elements; one constraint per secondary node.
    pub fn of(secondary: Surface, primary: Surface, reference: &[f64]) -> Self {
        let weights = secondary.weights(reference);
        let (facet_size, patches) = (secondary.shortest_facet(reference), Patches::new(secondary.dimension));
        Sides { secondary, primary, tangential: patches.clone(), patches, lengths: weights.clone(), weights, facet_size }
    }

    /// Contact elements with tangential constraints.
    pub fn slip_patches(&self) -> &Patches {
        if self.secondary.dimension == 2 { &self.patches } else { &self.tangential }
    }

    /// Values of the given constraints, zero for others.
    pub(crate) fn per_row(&self, values: impl Iterator<Item = (usize, f64)>) -> Vec<f64> {
        let mut all = vec![0.0; self.weights.len()];
        values.for_each(|(row, value)| all[row] = value);
        all
    }

    /// Weighted gaps of the given constraints, zero for others.
    pub(crate) fn weighted(&self, gaps: impl Iterator<Item = (usize, f64)>) -> Vec<f64> {
        self.per_row(gaps.map(|(row, gap)| (row, self.weights[row] * gap)))
    }

    /// Lists the contact elements with tangential constraints in space.
    pub(crate) fn list_slips(&mut self) {
        self.tangential.clear();
        let mut groups = Vec::new();
        for p in 0..self.patches.len() {
            groups.clear();
            groups.extend(self.patches.rows(p).iter().flat_map(|row| [2 * row, 2 * row + 1]));
            self.tangential.push(self.patches.nodes(p), &groups);
        }
    }

    /// Converts covered areas of secondary nodes to fractions: divides by the tributary area at `q`. `covered` has one value per node, or
    /// one per constraint of each node.
    pub fn cover(&self, covered: &mut [f64], q: &[f64]) {
        let rows = covered.len() / self.secondary.nodes().len();
        for (row, share) in covered.iter_mut().enumerate().filter(|(_, share)| **share > 0.0) {
            *share /= self.secondary.node_measure(row / rows, q);
        }
    }
}

impl Surface {
    /// Plane surface with the given facets (model node numbers, the body on the left).
    pub fn new(facets: &[[u32; 2]]) -> Self {
        Surface::of_facets(2, facets.iter().map(|facet| &facet[..]))
    }

    /// Surface in space with the given facets (model node numbers, counter-clockwise as seen from outside).
    pub fn in_space<'a>(facets: impl IntoIterator<Item = &'a [u32]>) -> Self {
        Surface::of_facets(3, facets)
    }

    fn of_facets<'a>(dimension: usize, facets: impl IntoIterator<Item = &'a [u32]>) -> Self {
        let (mut of_facets, mut starts) = (Vec::new(), vec![0]);
        for facet in facets {
            of_facets.extend_from_slice(facet);
            starts.push(of_facets.len());
        }
        let mut nodes = of_facets.clone();
        nodes.sort_unstable();
        nodes.dedup();
        let local_of_facets: Vec<u32> = of_facets.iter().map(|&node| nodes.partition_point(|&other| other < node) as u32).collect();
        let of_facet = |facet: usize| local_of_facets[starts[facet]..starts[facet + 1]].iter().map(move |&node| (node, facet as u32));
        let mut incidence: Vec<(u32, u32)> = (0..starts.len() - 1).flat_map(of_facet).collect();
        incidence.sort_unstable();
        let adjacent_start = (0..=nodes.len() as u32).map(|node| incidence.partition_point(|&(other, _)| other < node) as u32).collect();
        let adjacent = incidence.into_iter().map(|(_, facet)| facet).collect();
        Surface { dimension, nodes, of_facets, local_of_facets, starts, adjacent_start, adjacent }
    }

    /// Space dimension.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Model numbers of the nodes, ascending.
    pub fn nodes(&self) -> &[u32] {
        &self.nodes
    }

    /// Number of facets.
    pub fn count(&self) -> usize {
        self.starts.len() - 1
    }

    /// Nodes of a facet in model numbers.
    pub fn facet(&self, facet: usize) -> &[u32] {
        &self.of_facets[self.starts[facet]..self.starts[facet + 1]]
    }

    /// Nodes of a facet as indices into [`nodes`](Self::nodes).
    pub fn local_facet(&self, facet: usize) -> &[u32] {
        &self.local_of_facets[self.starts[facet]..self.starts[facet + 1]]
    }

    /// Facets of a plane surface in model node numbers; empty in space.
    pub fn facets(&self) -> &[[u32; 2]] {
        if self.dimension == 2 { self.of_facets.as_chunks().0 } else { &[] }
    }

    /// Facets of a plane surface as indices into [`nodes`](Self::nodes); empty in space.
    pub fn local_facets(&self) -> &[[u32; 2]] {
        if self.dimension == 2 { self.local_of_facets.as_chunks().0 } else { &[] }
    }

    /// Index of a model node in [`nodes`](Self::nodes), if it lies on the surface.
    pub fn index(&self, node: u32) -> Option<usize> {
        self.nodes.binary_search(&node).ok()
    }

    /// Facets adjacent to the node of that index, ascending.
    pub fn adjacent_facets(&self, index: usize) -> &[u32] {
        &self.adjacent[self.adjacent_start[index] as usize..self.adjacent_start[index + 1] as usize]
    }

    /// Facets of a plane surface before and after a facet: the one that ends at its first node, and the one that starts at its second node.
    pub fn neighbors(&self, facet: usize) -> [Option<u32>; 2] {
        let ends = self.local_facets()[facet];
        [0, 1].map(|end| {
            let joins = |&&other: &&u32| other as usize != facet && self.local_facets()[other as usize][1 - end] == ends[end];
            self.adjacent_facets(ends[end] as usize).iter().find(joins).copied()
        })
    }

    /// Facets with their neighbors, ascending.
    pub fn with_neighbors(&self, facets: &[u32]) -> Vec<u32> {
        let mut all: Vec<u32> = facets.iter().flat_map(|&facet| self.neighbors(facet as usize)).flatten().collect();
        all.extend(facets);
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Ranks of the facets of this and of another surface, by which exactly one of the two orders of a pair of common facets is ascending.
    /// `None` without common facets.
    pub fn ranks(&self, other: &Surface) -> Option<[Vec<u32>; 2]> {
        let mut order: Vec<(&[u32], u32)> = (0..self.count()).map(|facet| self.facet(facet)).zip(1u32..).collect();
        order.sort_unstable();
        let rank = |facet: usize| order.binary_search_by(|(own, _)| own.cmp(&other.facet(facet))).ok().map(|index| order[index].1);
        let others: Vec<u32> = (0..other.count()).map(|facet| rank(facet).unwrap_or(u32::MAX)).collect();
        let mut own = vec![0; self.count()];
        for &rank in others.iter().filter(|&&rank| rank != u32::MAX) {
            own[rank as usize - 1] = rank;
        }
        others.iter().any(|&rank| rank != u32::MAX).then_some([own, others])
    }

    /// True for each node at which a plane surface is bent at the positions `q`: two facets make more than the angle of `cosine`, outwards
    /// or inwards, or a chain ends, where the body has a corner outside of the contact.
    pub fn bends(&self, q: &[f64], cosine: f64) -> Vec<bool> {
        let along = |facet: u32| {
            let [a, b] = self.facets()[facet as usize].map(|node| 2 * node as usize);
            [q[b] - q[a], q[b + 1] - q[a + 1]]
        };
        let is_bent = |index: usize| {
            let &[one, other] = self.adjacent_facets(index) else { return true };
            let (t, u) = (along(one), along(other));
            t[0] * u[0] + t[1] * u[1] < cosine * t[0].hypot(t[1]) * u[0].hypot(u[1])
        };
        (0..self.nodes.len()).map(is_bent).collect()
    }

    /// True if the body is convex or straight at the node of the given index, for the positions `q`.
    pub(crate) fn is_convex(&self, index: usize, q: &[f64]) -> bool {
        let along = |facet: u32| {
            let [a, b] = self.facets()[facet as usize].map(|node| 2 * node as usize);
            [q[b] - q[a], q[b + 1] - q[a + 1]]
        };
        let &[one, other] = self.adjacent_facets(index) else { return true };
        let (first, second) = if self.local_facets()[one as usize][1] as usize == index { (one, other) } else { (other, one) };
        let (t, u) = (along(first), along(second));
        t[0] * u[1] - t[1] * u[0] >= 0.0
    }

    /// Indices of all nodes in their order along the facets, chain by chain; a closed chain begins at its lowest node. In space: ascending.
    pub fn along(&self) -> Vec<usize> {
        if self.dimension == 3 {
            return (0..self.nodes.len()).collect();
        }
        let facets_of = |node: usize| self.adjacent_facets(node).iter().map(|&facet| &self.local_facets()[facet as usize]);
        let starts = (0..self.nodes.len()).filter(|&node| !facets_of(node).any(|facet| facet[1] as usize == node));
        let mut order = Vec::with_capacity(self.nodes.len());
        let mut is_met = vec![false; self.nodes.len()];
        for start in starts.chain(0..self.nodes.len()) {
            let mut next = Some(start);
            while let Some(node) = next.filter(|&node| !is_met[node]) {
                is_met[node] = true;
                order.push(node);
                next = facets_of(node).filter(|facet| facet[0] as usize == node).map(|facet| facet[1] as usize).find(|&node| !is_met[node]);
            }
        }
        order
    }

    /// True for each node of a plane surface at which a chain ends.
    pub fn ends(&self) -> Vec<bool> {
        (0..self.nodes.len()).map(|index| self.adjacent_facets(index).len() != 2).collect()
    }

    /// True if the surface has no ends (plane) or border edges (space).
    pub fn is_closed(&self) -> bool {
        if self.dimension == 2 { !self.ends().contains(&true) } else { self.edges().iter().all(|edge| edge.facets[1].is_some()) }
    }

    /// Edges of a surface in space with their adjacent facets, ascending by nodes.
    pub fn edges(&self) -> Vec<Edge> {
        let of_facet = |facet: usize| {
            let nodes = self.facet(facet);
            (0..nodes.len()).map(move |k| {
                let (a, b) = (nodes[k], nodes[(k + 1) % nodes.len()]);
                ([a.min(b), a.max(b)], facet as u32)
            })
        };
        let mut sides: Vec<([u32; 2], u32)> = (0..self.count()).flat_map(of_facet).collect();
        sides.sort_unstable();
        let edge = |sides: &[([u32; 2], u32)]| Edge { nodes: sides[0].0, facets: [Some(sides[0].1), sides.get(1).map(|side| side.1)] };
        sides.chunk_by(|a, b| a.0 == b.0).map(edge).collect()
    }

    /// Length of a facet in the plane, area in space, at the positions `q` `[length^(D-1)]`.
    pub fn facet_measure(&self, facet: usize, q: &[f64]) -> f64 {
        match *self.facet(facet) {
            [a, b] if self.dimension == 2 => {
                let [a, b] = [a, b].map(|node| 2 * node as usize);
                (q[b] - q[a]).hypot(q[b + 1] - q[a + 1])
            }
            ref nodes => faces::shares(nodes, q).iter().sum(),
        }
    }

    /// Outward normal of a facet, not normalized: in the plane its length is that of the facet.
    pub fn outward(&self, facet: usize, q: &[f64]) -> Vec<f64> {
        match *self.facet(facet) {
            [a, b] if self.dimension == 2 => {
                let [a, b] = [a, b].map(|node| 2 * node as usize);
                vec![q[b + 1] - q[a + 1], q[a] - q[b]]
            }
            ref nodes => faces::area_vector(nodes, q).as_slice().to_vec(),
        }
    }

    /// Outward unit normals of the facets of a plane surface at the node of that index, for the positions `q`.
    pub fn normals_at(&self, index: usize, q: &[f64]) -> Vec<[f64; 2]> {
        let normal = |&facet: &u32| {
            let outward = self.outward(facet as usize, q);
            let length = outward[0].hypot(outward[1]);
            [outward[0] / length, outward[1] / length]
        };
        self.adjacent_facets(index).iter().map(normal).collect()
    }

    /// Nodal shares `int N_A dA` of a facet at the positions `q` `[length^(D-1)]`.
    fn shares(&self, facet: usize, q: &[f64]) -> Vec<f64> {
        if self.dimension == 2 { vec![0.5 * self.facet_measure(facet, q); 2] } else { faces::shares(self.facet(facet), q) }
    }

    /// Tributary measure of the node of that index at the positions `q`: half the length of the adjacent facets in the plane, nodal share
    /// of their area in space `[length^(D-1)]`.
    pub fn node_measure(&self, index: usize, q: &[f64]) -> f64 {
        let of_facet = |&facet: &u32| {
            let facet = facet as usize;
            if self.dimension == 2 {
                return 0.5 * self.facet_measure(facet, q);
            }
            let place = self.local_facet(facet).iter().position(|&node| node as usize == index);
            place.map_or(0.0, |place| faces::shares(self.facet(facet), q)[place])
        };
        self.adjacent_facets(index).iter().map(of_facet).sum()
    }

    /// Tributary measures `w_A` of all nodes at the positions `q` `[length^(D-1)]`.
    pub fn weights(&self, q: &[f64]) -> Vec<f64> {
        let mut weights = vec![0.0; self.nodes.len()];
        for facet in 0..self.count() {
            for (&node, share) in self.local_facet(facet).iter().zip(self.shares(facet, q)) {
                weights[node as usize] += share;
            }
        }
        weights
    }

    /// Size of the smallest facet at the positions `q` `[length]`; infinite without facets.
    pub fn shortest_facet(&self, q: &[f64]) -> f64 {
        (0..self.count()).map(|facet| self.facet_size(facet, q)).fold(f64::INFINITY, f64::min)
    }

    /// Size of a facet at the positions `q`: length in the plane; in space the side of a square of equal area, for triangles of twice the
    /// area `[length]`.
    pub fn facet_size(&self, facet: usize, q: &[f64]) -> f64 {
        let measure = self.facet_measure(facet, q);
        match (self.dimension, self.facet(facet).len()) {
            (2, _) => measure,
            (_, 3) => (2.0 * measure).sqrt(),
            _ => measure.sqrt(),
        }
    }
}

/// An edge of a surface in space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// Model node numbers of the ends, ascending.
    pub nodes: [u32; 2],
    /// Adjacent facets; one at the border of an open surface.
    pub facets: [Option<u32>; 2],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_chain_of_a_square() {
        let surface = Surface::new(&[[9, 4], [4, 6], [6, 5], [5, 9]]);
        let mut q = vec![0.0; 20];
        for (node, x, y) in [(9, 0.0, 0.0), (4, 2.0, 0.0), (6, 2.0, 1.0), (5, 0.0, 1.0)] {
            (q[2 * node], q[2 * node + 1]) = (x, y);
        }
        assert_eq!(surface.nodes(), [4, 5, 6, 9]);
        assert_eq!(surface.along().len(), 4);
        let chain = Surface::new(&[[9, 2], [2, 7], [4, 9]]);
        assert_eq!(chain.along().into_iter().map(|index| chain.nodes()[index]).collect::<Vec<_>>(), [4, 9, 2, 7]);
        let closed = Surface::new(&[[9, 2], [2, 7], [7, 9]]);
        assert_eq!(closed.along().into_iter().map(|index| closed.nodes()[index]).collect::<Vec<_>>(), [2, 7, 9]);
        assert_eq!(surface.local_facets(), [[3, 0], [0, 2], [2, 1], [1, 3]]);
        assert_eq!(surface.adjacent_facets(0), [0, 1]);
        assert_eq!((surface.index(6), surface.index(7)), (Some(2), None));
        assert!(surface.is_closed());
        assert_eq!(surface.neighbors(0), [Some(3), Some(1)]);
        assert_eq!(surface.bends(&q, 0.1), [true; 4]);
        assert_eq!(surface.bends(&q, -0.1), [false; 4]);
        assert_eq!(surface.weights(&q), [1.5; 4]);
        assert_eq!(surface.shortest_facet(&q), 1.0);
    }

    #[test]
    fn open_chain_has_half_weights_at_its_ends() {
        let surface = Surface::new(&[[0, 1], [1, 2]]);
        assert!(!surface.is_closed());
        assert_eq!(surface.weights(&[0.0, 0.0, 3.0, 4.0, 3.0, 5.0]), [2.5, 3.0, 0.5]);
        assert_eq!(surface.bends(&[0.0, 0.0, 3.0, 4.0, 3.0, 5.0], 0.81), [true; 3]);
        assert_eq!(surface.bends(&[0.0, 0.0, 3.0, 4.0, 3.0, 5.0], 0.79), [true, false, true]);
    }
}
