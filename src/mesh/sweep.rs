//! Sweep of a plane mesh through space.
//!
//! Every node becomes a line of nodes, one for each position of the section, and every cell a row of cells. The boundaries of the plane
//! mesh become sides of the same names; the first and the last section are boundaries, too, unless the sweep is closed.

use std::collections::HashMap;

use super::grid::limited;
use super::{Block, Boundary, Facet, Mesh, MeshError};
use crate::elements::{CellKind, CellShape};

/// Motion of a section along a sweep.
pub(super) struct Sweep<'a> {
    /// Number of layers of cells.
    pub layers: usize,
    /// True if the sweep is closed: the last section coincides with the first.
    pub is_closed: bool,
    /// True if the section moves against its normal.
    pub is_backward: bool,
    /// Names of the boundaries at the first and the last section.
    pub ends: [&'a str; 2],
    /// Division of the prisms over triangles: one wedge, or three tetrahedra.
    pub prisms: Prisms,
}

/// Solid cells that arise from a triangular cell of the section in each layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Prisms {
    /// Three tetrahedra.
    Cut,
    /// One wedge.
    Kept,
}

/// Kind of the solid cells extruded from a plane kind, and their number per plane cell and layer.
fn solid_kind(kind: CellKind, keeps_prisms: bool) -> Result<(CellKind, usize), MeshError> {
    Ok(match (kind, keeps_prisms) {
        (CellKind::Quad4, _) => (CellKind::Hex8, 1),
        (CellKind::Quad8, _) => (CellKind::Hex20, 1),
        (CellKind::Quad9, _) => (CellKind::Hex27, 1),
        (CellKind::Tri3, false) => (CellKind::Tet4, 3),
        (CellKind::Tri6, false) => (CellKind::Tet10, 3),
        (CellKind::Tri3, true) => (CellKind::Wedge6, 1),
        (CellKind::Tri6, true) => (CellKind::Wedge15, 1),
        (other, _) => return Err(MeshError::Extruded { kind: other.name() }),
    })
}

impl Mesh {
    /// Returns the solid mesh swept by the plane mesh.
    ///
    /// quad4 gives hex8, quad8 hex20, quad9 hex27, tri3 tet4 and tri6 tet10 (three tetrahedra in each prism). Triangles become wedges,
    /// wedge6 or wedge15, if `prisms` requires it and beside quadrilaterals. Nodes between two layers lie in the middle. `place(k, node)`
    /// is the position of a node of the plane mesh after `k` layers. Names of the ends get an underscore appended if the plane mesh has
    /// boundaries of these names.
    ///
    /// # Errors
    /// Cells in space, too many cells, coordinates that are not finite, a section that sweeps over itself.
    pub(super) fn swept(&self, sweep: &Sweep, place: impl Fn(usize, usize) -> [f64; 3]) -> Result<Mesh, MeshError> {
        let &Sweep { layers, is_closed, is_backward, ends, prisms } = sweep;
        let keeps_prisms = prisms == Prisms::Kept || self.blocks.len() > 1;
        let kinds: Vec<(CellKind, usize)> = self.kinds().map(|kind| solid_kind(kind, keeps_prisms)).collect::<Result<_, _>>()?;
        limited(&[self.numbered_blocks().zip(&kinds).map(|((_, block), (_, per_cell))| block.count() * per_cell).sum(), layers])?;
        let count = self.points.len() as u32;
        // Number of node levels: two for each layer of cells with mid-side nodes.
        let steps = if self.is_quadratic() { 2 } else { 1 };
        let levels = steps * layers;
        let rows = if is_closed { levels } else { levels + 1 };
        let at = |level: usize, node: usize| match level % steps {
            0 => place(level / steps, node),
            _ => {
                let [from, to] = [level / steps, level / steps + 1].map(|layer| place(layer, node));
                [0, 1, 2].map(|i| 0.5 * (from[i] + to[i]))
            }
        };
        let points = (0..rows).flat_map(|level| (0..self.points.len()).map(move |node| (level, node)));
        let points = points.map(|(level, node)| at(level, node)).collect();
        let node = |layer: usize, (node, level): (u32, u32)| {
            let level = if is_backward { steps - level as usize } else { level as usize };
            node + ((steps * layer + level) % rows) as u32 * count
        };
        let swept = self.blocks.iter().zip(&kinds).map(|(block, &(kind, per_cell))| {
            let mut connectivity = Vec::with_capacity(layers * block.count() * per_cell * kind.nodes());
            let on_corners = places_in(kind, block.kind);
            for (layer, cell) in (0..layers).flat_map(|layer| block.cells().map(move |cell| (layer, cell))) {
                match kind.shape() {
                    CellShape::Tetrahedron => tetrahedra(cell).iter().for_each(|corners| {
                        let corner = |&(corner, is_above): &(usize, bool)| (cell[corner], if is_above { steps as u32 } else { 0 });
                        connectivity.extend(corners.iter().map(|at| node(layer, corner(at))));
                        let edges = kind.shape().edges().iter().filter(|_| steps == 2);
                        connectivity.extend(edges.map(|ends| node(layer, between(cell, ends.map(|end| corners[end])))));
                    }),
                    _ => connectivity.extend(on_corners.iter().map(|&(local, level)| node(layer, (cell[local], level)))),
                }
            }
            Block { kind, connectivity }
        });
        let mut solid = Mesh { blocks: swept.collect(), points, boundaries: Vec::new(), parts: Vec::new() };
        let hull = solid.hull();
        self.sides_into(&mut solid, &hull, rows as u32);
        for (name, row) in ends.into_iter().zip([0, levels as u32]).filter(|_| !is_closed) {
            let mut name = name.to_string();
            while solid.boundary(&name).is_some() {
                name.push('_');
            }
            let is_there = |facet: &&Facet| solid.facet_nodes(**facet).all(|node| node / count == row);
            let facets = hull.iter().filter(is_there).copied().collect();
            solid.boundaries.push(Boundary::of_facets(&name, facets));
        }
        let blocks = self.numbered_blocks().zip(solid.numbered_blocks()).zip(&kinds);
        let blocks: Vec<(std::ops::Range<usize>, usize, usize)> =
            blocks.map(|(((first, block), (start, _)), &(_, per_cell))| (first..first + block.count(), start, per_cell)).collect();
        let of_cell = |layer: usize, cell: usize| {
            let found = blocks.iter().find(|(cells, ..)| cells.contains(&cell));
            found.into_iter().flat_map(move |(cells, start, per_cell)| {
                let first = start + (layer * cells.len() + cell - cells.start) * per_cell;
                (first..first + per_cell).map(|cell| cell as u32)
            })
        };
        let all = |own: &Vec<u32>| (0..layers).flat_map(|layer| own.iter().flat_map(move |&cell| of_cell(layer, cell as usize))).collect();
        let parts = self.parts.iter().map(|(name, own)| (name.clone(), all(own))).collect();
        solid.parts = parts;
        if solid.kinds().any(|kind| matches!(kind, CellKind::Hex20 | CellKind::Wedge15)) {
            solid.leave_out_unused();
        }
        if let Some(unmatched) = solid.unmatched() {
            return Err(unmatched);
        }
        match solid.checked() {
            Err(MeshError::InvertedCell { center, .. }) => Err(MeshError::SweptOver { center }),
            other => other,
        }
    }

    /// Adds the boundaries of this mesh as sides of the swept solid, whose hull is given.
    fn sides_into(&self, solid: &mut Mesh, hull: &[Facet], rows: u32) {
        let count = self.points.len() as u32;
        // Facets of the solid, grouped by the nodes of the section below them.
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

    /// Removes nodes without cells; the others keep their order.
    fn leave_out_unused(&mut self) {
        let mut numbers = vec![u32::MAX; self.points.len()];
        self.connectivity().for_each(|node| numbers[node as usize] = 0);
        numbers.iter_mut().filter(|number| **number == 0).zip(0..).for_each(|(number, next)| *number = next);
        self.renumber(|node| numbers[node as usize]);
        for boundary in &mut self.boundaries {
            boundary.nodes = boundary.nodes.iter().map(|&node| numbers[node as usize]).filter(|&node| node != u32::MAX).collect();
        }
        let mut is_used = numbers.iter().map(|&number| number != u32::MAX);
        self.points.retain(|_| is_used.next().unwrap_or(false));
    }
}

/// Node of the plane cell below each node of a hexahedron or wedge, and its level.
fn places_in(kind: CellKind, plane: CellKind) -> Vec<(usize, u32)> {
    let below = plane.row().node_places;
    let steps = if kind.is_quadratic() { 1.0 } else { 0.5 };
    let of_node = |[x, y, z]: [f64; 3]| below.iter().position(|at| at[..2] == [x, y]).map(|local| (local, (steps * (z + 1.0)) as u32));
    kind.row().node_places.iter().filter_map(|&place| of_node(place)).collect()
}

/// Mid-side node of the plane triangle, and its level, for the edge between two corners of the prism over the triangle.
fn between(cell: &[u32], [(a, a_above), (b, b_above)]: [(usize, bool); 2]) -> (u32, u32) {
    let level = u32::from(a_above) + u32::from(b_above);
    // Mid-side node `3 + k` lies between corner `k` and the next corner.
    let local = if a == b { a } else { 3 + if (a + 1) % 3 == b { a } else { b } };
    (cell[local], level)
}

/// Three tetrahedra of a prism over a triangle: corners of the triangle, each with true for the upper one. The side over an edge is divided
/// from the lower end at the edge's smaller node to the upper end at the larger one, so that neighbors agree (J. Dompierre et al., 8th
/// International Meshing Roundtable, 1999).
fn tetrahedra(triangle: &[u32]) -> [[(usize, bool); 4]; 3] {
    let first = (0..3).min_by_key(|&k| triangle[k]).unwrap_or_default();
    let [a, b, c] = [0, 1, 2].map(|k| (first + k) % 3);
    let (below, above) = (|node: usize| (node, false), |node: usize| (node, true));
    // Counter-clockwise from the smallest node; the order of the other two determines the division of the side above their edge.
    if triangle[b] < triangle[c] {
        [[below(a), below(b), below(c), above(c)], [below(a), below(b), above(c), above(b)], [below(a), above(b), above(c), above(a)]]
    } else {
        [[below(a), below(b), below(c), above(b)], [below(a), above(b), below(c), above(c)], [below(a), above(b), above(c), above(a)]]
    }
}
