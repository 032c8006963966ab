//! Submeshes, and connected components.

use std::collections::HashMap;

use super::{Block, Boundary, Facet, Mesh};

impl Mesh {
    /// Mesh of some cells: cells in the given order, those of a kind together, their nodes renumbered in ascending order, with the
    /// boundaries and parts that lie in it.
    pub fn of_cells(&self, cells: &[u32]) -> Mesh {
        let mut new_node = vec![None; self.points.len()];
        for &cell in cells {
            self.cell(cell as usize).iter().for_each(|&node| new_node[node as usize] = Some(0));
        }
        let mut points = Vec::new();
        for (slot, &point) in new_node.iter_mut().zip(&self.points).filter(|(slot, _)| slot.is_some()) {
            *slot = Some(points.len() as u32);
            points.push(point);
        }
        let (mut blocks, mut new_cell): (Vec<Block>, HashMap<u32, u32>) = (Vec::new(), HashMap::new());
        for (first, block) in self.numbered_blocks() {
            let range = first as u32..(first + block.count()) as u32;
            let own = || cells.iter().copied().filter(|cell| range.contains(cell));
            if own().next().is_none() {
                continue;
            }
            let start = new_cell.len() as u32;
            new_cell.extend(own().zip(start..));
            let nodes = own().flat_map(|cell| self.cell(cell as usize)).filter_map(|&node| new_node[node as usize]);
            blocks.push(Block { kind: block.kind, connectivity: nodes.collect() });
        }
        if blocks.is_empty() {
            blocks.extend(self.kinds().next().map(|kind| Block { kind, connectivity: Vec::new() }));
        }
        let inside = |facet: &Facet| new_cell.get(&facet.cell).map(|&cell| Facet { cell, local: facet.local });
        let boundaries = self
            .boundaries
            .iter()
            .map(|b| Boundary {
                name: b.name.clone(),
                facets: b.facets.iter().filter_map(inside).collect(),
                nodes: b.nodes.iter().filter_map(|&node| new_node[node as usize]).collect(),
            })
            .filter(|b| !b.facets.is_empty() || !b.nodes.is_empty())
            .collect();
        let parts = self
            .parts
            .iter()
            .map(|(part, cells)| (part.clone(), cells.iter().filter_map(|cell| new_cell.get(cell).copied()).collect::<Vec<_>>()))
            .filter(|(_, cells)| !cells.is_empty())
            .collect();
        Mesh { points, blocks, boundaries, parts }
    }

    /// Connected components (cells with common nodes) in the order of their first cells, with cells in ascending order.
    pub fn connected_cells(&self) -> Vec<Vec<u32>> {
        let mut leader: Vec<u32> = (0..self.points.len() as u32).collect();
        for cell in self.cells() {
            let first = root(&mut leader, cell[0]);
            for &node in &cell[1..] {
                let other = root(&mut leader, node);
                leader[other as usize] = first;
            }
        }
        let mut piece_of: HashMap<u32, usize> = HashMap::new();
        let mut pieces: Vec<Vec<u32>> = Vec::new();
        for (cell, nodes) in (0..).zip(self.cells()) {
            let next = pieces.len();
            let piece = *piece_of.entry(root(&mut leader, nodes[0])).or_insert(next);
            if piece == next {
                pieces.push(Vec::new());
            }
            pieces[piece].push(cell);
        }
        pieces
    }
}

/// Representative of all nodes connected with a node (union-find with path compression).
fn root(leader: &mut [u32], node: u32) -> u32 {
    let mut node = node as usize;
    while leader[node] as usize != node {
        leader[node] = leader[leader[node] as usize];
        node = leader[node] as usize;
    }
    node as u32
}

#[cfg(test)]
mod tests {
    use crate::mesh::rectangle;

    #[test]
    fn pieces_are_connected_cells_in_the_order_of_the_mesh() {
        let one = rectangle([2.0, 1.0], [2, 1], [0.0; 2]).unwrap();
        let mut both = one.clone();
        both.points.extend(one.points.iter().map(|x| [x[0] + 5.0, x[1], 0.0]));
        // Cells of two separate bars in alternating order.
        let shifted: Vec<u32> = one.blocks[0].connectivity.iter().map(|node| node + 6).collect();
        both.blocks[0].connectivity =
            [&one.blocks[0].connectivity[..4], &shifted[..4], &one.blocks[0].connectivity[4..], &shifted[4..]].concat();
        both.boundaries.clear();
        assert_eq!(both.connected_cells(), [vec![0, 2], vec![1, 3]]);
        let second = both.of_cells(&both.connected_cells()[1]);
        assert_eq!((second.cell_count(), second.points.len()), (2, 6));
        assert!(second.points.iter().all(|point| point[0] >= 5.0));
    }
}
