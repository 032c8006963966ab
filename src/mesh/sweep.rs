//! A plane mesh moved through space: what it sweeps over.
//!
//! Every node becomes a line of nodes, one on each place of the section, every cell a row of cells. The plane mesh's boundaries become the
//! sides under their names; the first and the last place are boundaries, too, unless the way closes.

use std::collections::HashMap;

use super::grid::limited;
use super::{Boundary, Facet, Mesh, MeshError};
use crate::elements::CellKind;

/// How a section moves.
pub(super) struct Sweep<'a> {
    /// Number of cells along the way.
    pub layers: usize,
    /// Whether the last place is the first one again.
    pub is_closed: bool,
    /// Whether the section moves against its normal.
    pub is_backward: bool,
    /// Names of the section at its first and last place.
    pub ends: [&'a str; 2],
}

impl Mesh {
    /// What the mesh of quad4 or tri3 cells sweeps over: hex8 cells, or prisms cut into three tet4 each. `place` gives where a node of
    /// the plane mesh is when the section has passed that many layers. Ends have an underscore behind where the plane mesh has such names.
    ///
    /// # Errors
    /// Cells of other kinds, too many cells, coordinates that are not finite, a section that sweeps over itself.
    pub(super) fn swept(&self, sweep: &Sweep, place: impl Fn(usize, usize) -> [f64; 3]) -> Result<Mesh, MeshError> {
        let &Sweep { layers, is_closed, is_backward, ends } = sweep;
        let (kind, per_cell) = match self.kind {
            CellKind::Quad4 => (CellKind::Hex8, 1),
            CellKind::Tri3 => (CellKind::Tet4, 3),
            other => return Err(MeshError::Extruded { kind: other.name() }),
        };
        limited(&[self.cell_count(), layers, per_cell as usize])?;
        let (count, cells) = (self.points.len() as u32, self.cell_count() as u32);
        let rows = if is_closed { layers } else { layers + 1 };
        let points = (0..rows).flat_map(|row| (0..self.points.len()).map(move |node| (row, node)));
        let points = points.map(|(row, node)| place(row, node)).collect();
        let mut connectivity = Vec::with_capacity(2 * self.connectivity.len() * layers);
        for layer in 0..layers {
            let row = |row: usize| (row % rows) as u32 * count;
            let [low, high] = if is_backward { [row(layer + 1), row(layer)] } else { [row(layer), row(layer + 1)] };
            let (below, above) = (|node: &u32| node + low, |node: &u32| node + high);
            for cell in self.cells() {
                match kind {
                    CellKind::Tet4 => connectivity.extend(
                        tetrahedra(cell).as_flattened().iter().map(|&(node, is_above)| if is_above { above(&node) } else { below(&node) }),
                    ),
                    _ => connectivity.extend(cell.iter().map(below).chain(cell.iter().map(above))),
                }
            }
        }
        let mut solid = Mesh { kind, points, connectivity, boundaries: Vec::new(), parts: Vec::new() };
        let hull = solid.hull();
        self.sides_into(&mut solid, &hull, rows as u32);
        for (name, row) in ends.into_iter().zip([0, layers as u32]).filter(|_| !is_closed) {
            let mut name = name.to_string();
            while solid.boundary(&name).is_some() {
                name.push('_');
            }
            let is_there = |facet: &&Facet| solid.facet_nodes(**facet).all(|node| node / count == row);
            let facets = hull.iter().filter(is_there).copied().collect();
            solid.boundaries.push(Boundary::of_facets(&name, facets));
        }
        let cells = cells * per_cell;
        let of_cell = |cell: u32| (0..per_cell).map(move |child| cell * per_cell + child);
        let all = |own: &Vec<u32>| {
            (0..layers as u32).flat_map(|layer| own.iter().flat_map(move |&c| of_cell(c).map(move |c| c + layer * cells))).collect()
        };
        solid.parts = self.parts.iter().map(|(name, own)| (name.clone(), all(own))).collect();
        match solid.checked() {
            Err(MeshError::InvertedCell { center, .. }) => Err(MeshError::SweptOver { center }),
            other => other,
        }
    }

    /// The boundaries of this mesh as sides of what it has swept over, whose hull is given.
    fn sides_into(&self, solid: &mut Mesh, hull: &[Facet], rows: u32) {
        let count = self.points.len() as u32;
        // facets of the solid by the nodes of the section that they stand on, each once
        let mut sides: HashMap<Vec<u32>, Vec<Facet>> = HashMap::new();
        for &facet in hull {
            let mut on: Vec<u32> = solid.facet_nodes(facet).map(|node| node % count).collect();
            on.sort_unstable();
            on.dedup();
            sides.entry(on).or_default().push(facet);
        }
        for boundary in &self.boundaries {
            let standing = boundary.facets.iter().filter_map(|&facet| {
                let mut on: Vec<u32> = self.facet_nodes(facet).collect();
                on.sort_unstable();
                sides.get(&on)
            });
            let facets = standing.flatten().copied().collect();
            let nodes = (0..rows).flat_map(|row| boundary.nodes.iter().map(move |node| node + row * count));
            solid.boundaries.push(Boundary { name: boundary.name.clone(), facets, nodes: nodes.collect() });
        }
    }
}

/// The three tetrahedra of a prism over a triangle: nodes of the triangle, each with whether it is the one above. The side over an edge is
/// cut from below the edge's lesser node to above the greater one, so that neighbors agree (J. Dompierre et al., 8th International Meshing
/// Roundtable, 1999).
fn tetrahedra(triangle: &[u32]) -> [[(u32, bool); 4]; 3] {
    let first = (0..3).min_by_key(|&k| triangle[k]).unwrap_or_default();
    let [a, b, c] = [0, 1, 2].map(|k| triangle[(first + k) % 3]);
    let (below, above) = (|node: u32| (node, false), |node: u32| (node, true));
    // counter-clockwise from the least node: the order of the other two decides the cut of the side over them
    if b < c {
        [[below(a), below(b), below(c), above(c)], [below(a), below(b), above(c), above(b)], [below(a), above(b), above(c), above(a)]]
    } else {
        [[below(a), below(b), below(c), above(b)], [below(a), above(b), below(c), above(c)], [below(a), above(b), above(c), above(a)]]
    }
}
