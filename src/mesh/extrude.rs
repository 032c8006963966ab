//! A plane mesh drawn out into space.
//!
//! Every node becomes a column of nodes along z, every cell a column of cells. The plane mesh's boundaries become the sides under their
//! names; `bottom` is the plane itself and `top` the plane that it was moved to.

use std::collections::HashMap;

use super::grid::{at_least, graded, limited, positive};
use super::{Boundary, Facet, Mesh, MeshError};
use crate::elements::CellKind;

impl Mesh {
    /// The mesh of quad4 or tri3 cells drawn out along z from 0 to `height` `[length]` in `layers` of hex8 cells, or of prisms cut into
    /// three tet4 each, of which the last is `grading` times the first; its boundaries as sides, and
    /// `bottom` and `top` (with an underscore behind where the plane mesh has such names).
    ///
    /// # Errors
    /// Cells of other kinds, a height or ratio that is not positive, no layers, too many cells.
    pub fn extruded(&self, height: f64, layers: usize, grading: f64) -> Result<Mesh, MeshError> {
        let (kind, per_cell) = match self.kind {
            CellKind::Quad4 => (CellKind::Hex8, 1),
            CellKind::Tri3 => (CellKind::Tet4, 3),
            other => return Err(MeshError::Extruded { kind: other.name() }),
        };
        positive("the height of an extrusion", height)?;
        at_least("along the height", layers, 1)?;
        limited(&[self.cell_count(), layers, per_cell as usize])?;
        let (count, cells) = (self.points.len() as u32, self.cell_count() as u32);
        let places = graded(layers, grading)?;
        let points = places.iter().flat_map(|share| self.points.iter().map(move |[x, y, _]| [*x, *y, height * share])).collect();
        let mut connectivity = Vec::with_capacity(2 * self.connectivity.len() * layers);
        for layer in 0..layers as u32 {
            for cell in self.cells() {
                let (below, above) = (|node: &u32| node + layer * count, |node: &u32| node + (layer + 1) * count);
                match kind {
                    CellKind::Tet4 => connectivity.extend(
                        tetrahedra(cell).as_flattened().iter().map(|&(node, is_above)| if is_above { above(&node) } else { below(&node) }),
                    ),
                    _ => connectivity.extend(cell.iter().map(below).chain(cell.iter().map(above))),
                }
            }
        }
        let mut solid = Mesh { kind, points, connectivity, boundaries: Vec::new(), parts: Vec::new() };
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
            let nodes = (0..=layers as u32).flat_map(|layer| boundary.nodes.iter().map(move |node| node + layer * count));
            solid.boundaries.push(Boundary { name: boundary.name.clone(), facets, nodes: nodes.collect() });
        }
        for (name, layer) in [("bottom", 0), ("top", layers as u32)] {
            let mut name = name.to_string();
            while solid.boundary(&name).is_some() {
                name.push('_');
            }
            let is_there = |facet: &Facet| solid.facet_nodes(*facet).all(|node| node / count == layer);
            let facets = solid.hull().into_iter().filter(is_there).collect();
            solid.boundaries.push(Boundary::of_facets(&name, facets));
        }
        let cells = cells * per_cell;
        let of_cell = |cell: u32| (0..per_cell).map(move |child| cell * per_cell + child);
        let all = |own: &Vec<u32>| {
            (0..layers as u32).flat_map(|layer| own.iter().flat_map(move |&c| of_cell(c).map(move |c| c + layer * cells))).collect()
        };
        solid.parts = self.parts.iter().map(|(name, own)| (name.clone(), all(own))).collect();
        solid.checked()
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
