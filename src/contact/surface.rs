//! A surface in the plane: a chain, or several, of oriented straight facets with the body on their left.
//!
//! Only the numbering is kept; positions come with every call. Nodes are numbered locally in ascending order of their global numbers.
//! Nothing is asked of the shape: open, closed, in several pieces.

use super::patches::Patches;

/// Oriented two-node facets and their nodes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Surface {
    nodes: Vec<u32>,
    facets: Vec<[u32; 2]>,
    local_facets: Vec<[u32; 2]>,
    adjacent_start: Vec<u32>,
    adjacent: Vec<u32>,
}

/// What every contact method has: two surfaces, the secondary one measured in the reference positions, and its patches.
#[derive(Clone, Debug)]
pub struct Sides {
    /// The side with the multipliers.
    pub secondary: Surface,
    /// The other side.
    pub primary: Surface,
    /// Patches of the present candidates.
    pub patches: Patches,
    /// Weights of the constraint rows `[length]`.
    pub weights: Vec<f64>,
    /// Lengths of the secondary nodes in the reference positions, half of their facets `[length]`.
    pub lengths: Vec<f64>,
    /// Length of the shortest secondary facet `[length]`.
    pub facet_size: f64,
}

impl Sides {
    /// Two surfaces by their facets, without patches; one constraint row for each secondary node.
    pub fn new(secondary: &[[u32; 2]], primary: &[[u32; 2]], reference: &[f64]) -> Self {
        let (secondary, primary) = (Surface::new(secondary), Surface::new(primary));
        let weights = secondary.weights(reference);
        let facet_size = secondary.shortest_facet(reference);
        Sides { secondary, primary, patches: Patches::new(2), lengths: weights.clone(), weights, facet_size }
    }

    /// Turns the covered length of each secondary node into its share of the node's length at `q`.
    pub fn cover(&self, covered: &mut [f64], q: &[f64]) {
        for (node, share) in covered.iter_mut().enumerate().filter(|(_, share)| **share > 0.0) {
            *share /= self.secondary.node_length(node, q);
        }
    }
}

impl Surface {
    /// The surface of these facets (node numbers of the model, the body on the left).
    pub fn new(facets: &[[u32; 2]]) -> Self {
        let mut nodes = facets.as_flattened().to_vec();
        nodes.sort_unstable();
        nodes.dedup();
        let local = |node: u32| nodes.partition_point(|&other| other < node) as u32;
        let local_facets: Vec<[u32; 2]> = facets.iter().map(|&[a, b]| [local(a), local(b)]).collect();
        let mut incidence: Vec<(u32, u32)> =
            local_facets.iter().zip(0u32..).flat_map(|(&[a, b], facet)| [(a, facet), (b, facet)]).collect();
        incidence.sort_unstable();
        let adjacent_start = (0..=nodes.len() as u32).map(|node| incidence.partition_point(|&(other, _)| other < node) as u32).collect();
        let adjacent = incidence.into_iter().map(|(_, facet)| facet).collect();
        Surface { nodes, facets: facets.to_vec(), local_facets, adjacent_start, adjacent }
    }

    /// Model numbers of the nodes, ascending.
    pub fn nodes(&self) -> &[u32] {
        &self.nodes
    }

    /// Facets in model node numbers.
    pub fn facets(&self) -> &[[u32; 2]] {
        &self.facets
    }

    /// Facets in indices into [`nodes`](Self::nodes).
    pub fn local_facets(&self) -> &[[u32; 2]] {
        &self.local_facets
    }

    /// Index of a model node in [`nodes`](Self::nodes), if it lies on the surface.
    pub fn index(&self, node: u32) -> Option<usize> {
        self.nodes.binary_search(&node).ok()
    }

    /// Facets that meet at the node of that index, ascending.
    pub fn adjacent_facets(&self, index: usize) -> &[u32] {
        &self.adjacent[self.adjacent_start[index] as usize..self.adjacent_start[index + 1] as usize]
    }

    /// The facet that ends where this one starts, and the facet that starts where this one ends.
    pub fn neighbors(&self, facet: usize) -> [Option<u32>; 2] {
        let ends = self.local_facets[facet];
        [0, 1].map(|end| {
            let joins = |&&other: &&u32| other as usize != facet && self.local_facets[other as usize][1 - end] == ends[end];
            self.adjacent_facets(ends[end] as usize).iter().find(joins).copied()
        })
    }

    /// For surfaces with common facets: ranks of this surface's facets and of the other's such that of the two ways round in which a pair
    /// of common facets can be taken, one has the lower rank first. `None` without common facets.
    pub fn ranks(&self, other: &Surface) -> Option<[Vec<u32>; 2]> {
        let mut order: Vec<([u32; 2], u32)> = self.facets.iter().copied().zip(1u32..).collect();
        order.sort_unstable();
        let rank = |facet: &[u32; 2]| order.binary_search_by(|(own, _)| own.cmp(facet)).ok().map(|index| order[index].1);
        let others: Vec<u32> = other.facets.iter().map(|facet| rank(facet).unwrap_or(u32::MAX)).collect();
        let mut own = vec![0; self.facets.len()];
        for &rank in others.iter().filter(|&&rank| rank != u32::MAX) {
            own[rank as usize - 1] = rank;
        }
        others.iter().any(|&rank| rank != u32::MAX).then_some([own, others])
    }

    /// For each node whether the surface is bent there at the positions `q`: whether two facets turn by more than an angle, outwards or
    /// inwards, or the chain ends, where the body has a corner that is not in the contact. `cosine` is that of the angle.
    pub fn bends(&self, q: &[f64], cosine: f64) -> Vec<bool> {
        let along = |facet: u32| {
            let [a, b] = self.facets[facet as usize].map(|node| 2 * node as usize);
            [q[b] - q[a], q[b + 1] - q[a + 1]]
        };
        let is_bent = |index: usize| {
            let &[one, other] = self.adjacent_facets(index) else { return true };
            let (t, u) = (along(one), along(other));
            t[0] * u[0] + t[1] * u[1] < cosine * t[0].hypot(t[1]) * u[0].hypot(u[1])
        };
        (0..self.nodes.len()).map(is_bent).collect()
    }

    /// Whether the body has a convex corner, or a straight side, at the node of that index at the positions `q`.
    pub fn is_convex(&self, index: usize, q: &[f64]) -> bool {
        let along = |facet: u32| {
            let [a, b] = self.facets[facet as usize].map(|node| 2 * node as usize);
            [q[b] - q[a], q[b + 1] - q[a + 1]]
        };
        let &[one, other] = self.adjacent_facets(index) else { return true };
        let (first, second) = if self.local_facets[one as usize][1] as usize == index { (one, other) } else { (other, one) };
        let (t, u) = (along(first), along(second));
        t[0] * u[1] - t[1] * u[0] >= 0.0
    }

    /// The indices of all nodes in the order in which they follow each other along the facets, chain by chain; a closed chain begins at the
    /// node with the lowest number.
    pub fn along(&self) -> Vec<usize> {
        let facets_of = |node: usize| self.adjacent_facets(node).iter().map(|&facet| &self.local_facets[facet as usize]);
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

    /// For each node whether a chain ends there.
    pub fn ends(&self) -> Vec<bool> {
        (0..self.nodes.len()).map(|index| self.adjacent_facets(index).len() != 2).collect()
    }

    /// Whether every node lies between two facets.
    pub fn is_closed(&self) -> bool {
        !self.ends().contains(&true)
    }

    /// Length of a facet at the positions `q` `[length]`.
    pub fn facet_length(&self, facet: usize, q: &[f64]) -> f64 {
        let [a, b] = self.facets[facet].map(|node| 2 * node as usize);
        (q[b] - q[a]).hypot(q[b + 1] - q[a + 1])
    }

    /// Half the lengths of the facets that meet at the node of that index, at the positions `q` `[length]`.
    pub fn node_length(&self, index: usize, q: &[f64]) -> f64 {
        self.adjacent_facets(index).iter().map(|&facet| 0.5 * self.facet_length(facet as usize, q)).sum()
    }

    /// Node weights `w_A` at the positions `q`: half the lengths of the adjacent facets `[length]`.
    pub fn weights(&self, q: &[f64]) -> Vec<f64> {
        let mut weights = vec![0.0; self.nodes.len()];
        for (facet, nodes) in self.local_facets.iter().enumerate() {
            let half = 0.5 * self.facet_length(facet, q);
            for &node in nodes {
                weights[node as usize] += half;
            }
        }
        weights
    }

    /// Length of the shortest facet at the positions `q` `[length]`; infinite without facets.
    pub fn shortest_facet(&self, q: &[f64]) -> f64 {
        (0..self.facets.len()).map(|facet| self.facet_length(facet, q)).fold(f64::INFINITY, f64::min)
    }
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
