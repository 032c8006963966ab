//! A plane mesh drawn out into space.
//!
//! Every node becomes a column of nodes along z, every cell a column of cells. The plane mesh's boundaries become the sides under their
//! names; `bottom` is the plane itself and `top` the plane that it was moved to.

use std::collections::HashMap;

use super::grid::{at_least, graded, limited, positive};
use super::{Boundary, Facet, Mesh, MeshError};
use crate::elements::{CellKind, CellShape};

impl Mesh {
    /// The plane mesh drawn out along z from 0 to `height` `[length]` in `layers` of hexahedra, or of prisms cut into three tetrahedra each,
    /// of which the last is `grading` times the first: quad4 as hex8, quad8 as hex20, quad9 as hex27, tri3 as tet4, tri6 as tet10. Its
    /// boundaries become sides, and there are `bottom` and `top` (with an underscore behind where the plane mesh has such names).
    ///
    /// # Errors
    /// Cells in space, a height or ratio that is not positive, no layers, too many cells.
    pub fn extruded(&self, height: f64, layers: usize, grading: f64) -> Result<Mesh, MeshError> {
        let (kind, per_cell) = match self.kind {
            CellKind::Quad4 => (CellKind::Hex8, 1),
            CellKind::Quad8 => (CellKind::Hex20, 1),
            CellKind::Quad9 => (CellKind::Hex27, 1),
            CellKind::Tri3 => (CellKind::Tet4, 3),
            CellKind::Tri6 => (CellKind::Tet10, 3),
            other => return Err(MeshError::Extruded { kind: other.name() }),
        };
        positive("the height of an extrusion", height)?;
        at_least("along the height", layers, 1)?;
        limited(&[self.cell_count(), layers, per_cell as usize])?;
        let (count, cells) = (self.points.len() as u32, self.cell_count() as u32);
        // Levels of nodes: two for each layer where there are nodes in the middle of edges.
        let steps = if kind.is_quadratic() { 2 } else { 1 };
        let (places, levels) = (graded(layers, grading)?, (steps * layers) as u32);
        let share = |level: u32| {
            let (below, above) = (level as usize / steps, (level as usize).div_ceil(steps));
            if below == above { places[below] } else { 0.5 * (places[below] + places[above]) }
        };
        let points = (0..=levels).flat_map(|level| self.points.iter().map(move |[x, y, _]| [*x, *y, height * share(level)])).collect();
        let mut connectivity = Vec::with_capacity(layers * self.cell_count() * per_cell as usize * kind.nodes());
        let on_corners = places_in(kind, self.kind);
        for layer in 0..layers as u32 {
            for cell in self.cells() {
                let node = |(node, level): (u32, u32)| node + (steps as u32 * layer + level) * count;
                match kind.shape() {
                    CellShape::Tetrahedron => tetrahedra(cell).iter().for_each(|corners| {
                        let corner = |&(corner, is_above): &(usize, bool)| (cell[corner], if is_above { steps as u32 } else { 0 });
                        connectivity.extend(corners.iter().map(|at| node(corner(at))));
                        let edges = kind.shape().edges().iter().filter(|_| steps == 2);
                        connectivity.extend(edges.map(|ends| node(between(cell, ends.map(|end| corners[end])))));
                    }),
                    _ => connectivity.extend(on_corners.iter().map(|&(local, level)| node((cell[local], level)))),
                }
            }
        }
        let mut solid = Mesh { kind, points, connectivity, boundaries: Vec::new(), parts: Vec::new() };
        self.sides_of(&mut solid, levels);
        let cells = cells * per_cell;
        let of_cell = |cell: u32| (0..per_cell).map(move |child| cell * per_cell + child);
        let all = |own: &Vec<u32>| {
            (0..layers as u32).flat_map(|layer| own.iter().flat_map(move |&c| of_cell(c).map(move |c| c + layer * cells))).collect()
        };
        solid.parts = self.parts.iter().map(|(name, own)| (name.clone(), all(own))).collect();
        if kind == CellKind::Hex20 {
            solid.leave_out_unused();
        }
        solid.checked()
    }

    /// Gives what was drawn out to so many levels the boundaries of this mesh, `bottom` and `top`.
    fn sides_of(&self, solid: &mut Mesh, levels: u32) {
        let count = self.points.len() as u32;
        // facets of the solid by their lowest layer and the nodes below them, each once
        let mut sides: HashMap<Vec<u32>, Vec<Facet>> = HashMap::new();
        for facet in solid.hull() {
            let mut below: Vec<u32> = solid.facet_nodes(facet).map(|node| node % count).collect();
            below.sort_unstable();
            below.dedup();
            sides.entry(below).or_default().push(facet);
        }
        for boundary in &self.boundaries {
            let standing = boundary.facets.iter().filter_map(|&facet| {
                let mut below: Vec<u32> = self.facet_nodes(facet).collect();
                below.sort_unstable();
                sides.get(&below)
            });
            let facets = standing.flatten().copied().collect();
            let nodes = (0..=levels).flat_map(|level| boundary.nodes.iter().map(move |node| node + level * count));
            solid.boundaries.push(Boundary { name: boundary.name.clone(), facets, nodes: nodes.collect() });
        }
        for (name, level) in [("bottom", 0), ("top", levels)] {
            let mut name = name.to_string();
            while solid.boundary(&name).is_some() {
                name.push('_');
            }
            let is_there = |facet: &Facet| solid.facet_nodes(*facet).all(|node| node / count == level);
            let facets = solid.hull().into_iter().filter(is_there).collect();
            solid.boundaries.push(Boundary::of_facets(&name, facets));
        }
    }

    /// Leaves out the nodes of no cell; the others keep their order.
    fn leave_out_unused(&mut self) {
        let mut numbers = vec![u32::MAX; self.points.len()];
        self.connectivity.iter().for_each(|&node| numbers[node as usize] = 0);
        let mut next = 0;
        for number in numbers.iter_mut().filter(|number| **number == 0) {
            *number = next;
            next += 1;
        }
        self.connectivity.iter_mut().for_each(|node| *node = numbers[*node as usize]);
        for boundary in &mut self.boundaries {
            boundary.nodes = boundary.nodes.iter().map(|&node| numbers[node as usize]).filter(|&node| node != u32::MAX).collect();
        }
        let mut is_used = numbers.iter().map(|&number| number != u32::MAX);
        self.points.retain(|_| is_used.next().unwrap_or(false));
    }
}

/// For each node of a hexahedron the node of the quadrilateral below it, and its level.
fn places_in(kind: CellKind, plane: CellKind) -> Vec<(usize, u32)> {
    let below = plane.row().node_places;
    let steps = if kind.is_quadratic() { 1.0 } else { 0.5 };
    let of_node = |[x, y, z]: [f64; 3]| below.iter().position(|at| at[..2] == [x, y]).map(|local| (local, (steps * (z + 1.0)) as u32));
    kind.row().node_places.iter().filter_map(|&place| of_node(place)).collect()
}

/// The node of a triangle of second order, and its level, in the middle between two corners of its prism.
fn between(cell: &[u32], [(a, a_above), (b, b_above)]: [(usize, bool); 2]) -> (u32, u32) {
    let level = u32::from(a_above) + u32::from(b_above);
    // the middle of the edge from a corner to the next one has its number, three further
    let local = if a == b { a } else { 3 + if (a + 1) % 3 == b { a } else { b } };
    (cell[local], level)
}

/// The three tetrahedra of a prism over a triangle: corners of the triangle, each with whether it is the one above. The side over an edge is
/// cut from below the edge's lesser node to above the greater one, so that neighbors agree (J. Dompierre et al., 8th International Meshing
/// Roundtable, 1999).
fn tetrahedra(triangle: &[u32]) -> [[(usize, bool); 4]; 3] {
    let first = (0..3).min_by_key(|&k| triangle[k]).unwrap_or_default();
    let [a, b, c] = [0, 1, 2].map(|k| (first + k) % 3);
    let (below, above) = (|node: usize| (node, false), |node: usize| (node, true));
    // counter-clockwise from the least node: the order of the other two decides the cut of the side over them
    if triangle[b] < triangle[c] {
        [[below(a), below(b), below(c), above(c)], [below(a), below(b), above(c), above(b)], [below(a), above(b), above(c), above(a)]]
    } else {
        [[below(a), below(b), below(c), above(b)], [below(a), above(b), below(c), above(c)], [below(a), above(b), above(c), above(a)]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{block, rectangle, ring};

    #[test]
    fn a_ring_becomes_a_tube() {
        let mut plane = ring(0.5, 1.0, [2, 12], [0.0; 2], 0.0).unwrap();
        plane.parts = vec![("half".into(), (0..12).collect())];
        let tube = plane.extruded(3.0, 4, 2.0).unwrap();
        assert_eq!((tube.cell_count(), tube.points.len()), (4 * 24, 5 * 36));
        assert!((tube.measure() - 3.0 * plane.measure()).abs() < 1e-13);
        assert_eq!(tube.defects(), []);
        for name in ["inner", "outer"] {
            let [solid, flat] = [&tube, &plane].map(|mesh| mesh.boundary_measure(mesh.boundary(name).unwrap()));
            assert!((solid - 3.0 * flat).abs() < 1e-13, "{name}");
        }
        for (name, z) in [("bottom", 0.0), ("top", 3.0)] {
            let boundary = tube.boundary(name).unwrap();
            assert!((tube.boundary_measure(boundary) - plane.measure()).abs() < 1e-13);
            assert!(tube.boundary_nodes(boundary).iter().all(|&node| tube.points[node as usize][2] == z));
        }
        let mut named: Vec<Facet> = tube.boundaries.iter().flat_map(|b| b.facets.clone()).collect();
        named.sort_unstable();
        assert_eq!(tube.hull(), named);
        assert_eq!(tube.part("half").unwrap().cell_count(), 48);
        assert!((tube.points[36][2] - 3.0 / (1.0 + 2f64.cbrt() + 2f64.cbrt().powi(2) + 2.0)).abs() < 1e-14);
    }

    #[test]
    fn triangles_become_tetrahedra_that_fit() {
        let plane = rectangle([2.0, 1.0], [3, 2], [0.0; 2]).unwrap().with_cells(CellKind::Tri3).unwrap();
        let solid = plane.extruded(1.5, 2, 1.0).unwrap();
        assert_eq!((solid.kind, solid.cell_count()), (CellKind::Tet4, 2 * 3 * 12));
        assert_eq!(solid.defects(), []);
        assert!((solid.measure() - 3.0).abs() < 1e-13);
        for (name, area) in [("left", 1.5), ("right", 1.5), ("bottom", 3.0), ("top", 3.0), ("bottom_", 2.0), ("top_", 2.0)] {
            assert!((solid.boundary_measure(solid.boundary(name).unwrap()) - area).abs() < 1e-13, "{name}");
        }
        let named: usize = solid.boundaries.iter().map(|boundary| boundary.facets.len()).sum();
        assert_eq!(named, solid.hull().len());
    }

    #[test]
    fn cells_of_second_order_keep_their_curved_sides() {
        use crate::mesh::Round;
        for (flat, solid) in [(CellKind::Quad8, CellKind::Hex20), (CellKind::Quad9, CellKind::Hex27), (CellKind::Tri6, CellKind::Tet10)] {
            let mut plane = ring(0.5, 1.0, [1, 8], [0.0; 2], 0.1).unwrap().with_round_cells(flat, Round::About([0.0; 2])).unwrap();
            plane.boundaries.push(Boundary { name: "points".into(), facets: Vec::new(), nodes: vec![0, plane.cell(0)[4]] });
            let tube = plane.extruded(3.0, 2, 2.0).unwrap();
            assert_eq!((tube.kind, tube.defects()), (solid, Vec::new()));
            // three points for a triangle's curved area, four for the volume of a tetrahedron
            let allowed = if solid == CellKind::Tet10 { 2e-3 } else { 1e-13 };
            assert!((tube.measure() / (3.0 * plane.measure()) - 1.0).abs() < allowed, "{solid:?}: {}", tube.measure());
            for name in ["inner", "outer"] {
                let [solid, flat] = [&tube, &plane].map(|mesh| mesh.boundary_measure(mesh.boundary(name).unwrap()));
                assert!((solid / (3.0 * flat) - 1.0).abs() < allowed, "{name}: {solid} {flat}");
            }
            let radius = |name: &'static str, node: u32| (name, tube.points[node as usize][0].hypot(tube.points[node as usize][1]));
            for (name, r) in [("inner", 0.5), ("outer", 1.0)] {
                let nodes = tube.boundary_nodes(tube.boundary(name).unwrap());
                assert!(nodes.iter().all(|&node| solid == CellKind::Hex27 || (radius(name, node).1 - r).abs() < 1e-14), "{solid:?} {name}");
            }
            let mut named: Vec<Facet> = tube.boundaries.iter().flat_map(|b| b.facets.clone()).collect();
            named.sort_unstable();
            assert_eq!(tube.hull(), named);
            let points = &tube.boundary("points").unwrap().nodes;
            assert!(
                points.len() >= 6
                    && points.iter().all(|&node| {
                        let [x, y, _] = tube.points[node as usize];
                        [0, plane.cell(0)[4]].iter().any(|&below| plane.points[below as usize][..2] == [x, y])
                    })
            );
        }
    }

    #[test]
    fn an_extruded_rectangle_is_a_block() {
        let plane = rectangle([1.0, 2.0], [2, 3], [0.0; 2]).unwrap();
        let solid = plane.extruded(4.0, 2, 1.0).unwrap();
        let direct = block([1.0, 2.0, 4.0], [2, 3, 2], [0.0; 3]).unwrap();
        assert_eq!((solid.points, solid.connectivity), (direct.points, direct.connectivity.clone()));
        let names: Vec<&str> = solid.boundaries.iter().map(|b| b.name.as_str()).collect();
        assert_eq!(names, ["left", "right", "bottom", "top", "bottom_", "top_"]);
        assert!(matches!(direct_again(), Err(MeshError::Extruded { kind: "hex8" })));
        assert!(matches!(plane.extruded(0.0, 1, 1.0), Err(MeshError::NotPositive { .. })));
        assert!(matches!(plane.extruded(1.0, 0, 1.0), Err(MeshError::TooFewCells { .. })));
        assert!(matches!(plane.extruded(1.0, usize::MAX, 1.0), Err(MeshError::TooManyCells { .. })));
    }

    fn direct_again() -> Result<Mesh, MeshError> {
        block([1.0; 3], [1, 1, 1], [0.0; 3])?.extruded(1.0, 1, 1.0)
    }
}
