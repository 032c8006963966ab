//! A plane mesh drawn out into space.
//!
//! Every node becomes a column of nodes along z, every cell a column of cells. The plane mesh's boundaries become the sides under their
//! names; `bottom` is the plane itself and `top` the plane that it was moved to.

use super::grid::{at_least, graded, limited, positive};
use super::{Boundary, Facet, Mesh, MeshError};
use crate::elements::CellKind;

impl Mesh {
    /// The mesh of quad4 cells drawn out along z from 0 to `height` `[length]` in `layers` of hex8 cells, of which the last is `grading`
    /// times the first; its boundaries as sides, and `bottom` and `top` (with an underscore behind where the plane mesh has such names).
    ///
    /// # Errors
    /// Cells of other kinds, a height or ratio that is not positive, no layers, too many cells.
    pub fn extruded(&self, height: f64, layers: usize, grading: f64) -> Result<Mesh, MeshError> {
        if self.kind != CellKind::Quad4 {
            return Err(MeshError::Extruded { kind: self.kind.name() });
        }
        positive("the height of an extrusion", height)?;
        at_least("along the height", layers, 1)?;
        limited(&[self.cell_count(), layers])?;
        let (count, cells) = (self.points.len() as u32, self.cell_count() as u32);
        let places = graded(layers, grading)?;
        let points = places.iter().flat_map(|share| self.points.iter().map(move |[x, y, _]| [*x, *y, height * share])).collect();
        let mut connectivity = Vec::with_capacity(2 * self.connectivity.len() * layers);
        for layer in 0..layers as u32 {
            for cell in self.cells() {
                connectivity.extend(cell.iter().map(|node| node + layer * count));
                connectivity.extend(cell.iter().map(|node| node + (layer + 1) * count));
            }
        }
        let mut solid = Mesh { kind: CellKind::Hex8, points, connectivity, boundaries: Vec::new(), parts: Vec::new() };
        // the side of a hexahedron that stands on a side of the quadrilateral below
        let standing = |edge: &[usize]| local_facet(&[edge[0], edge[1], edge[0] + 4, edge[1] + 4]);
        let standing: Vec<u8> = self.kind.facets().iter().filter_map(|edge| standing(edge)).collect();
        for boundary in &self.boundaries {
            let facets = (0..layers as u32).flat_map(|layer| {
                let standing = &standing;
                boundary.facets.iter().map(move |facet| Facet { cell: facet.cell + layer * cells, local: standing[facet.local as usize] })
            });
            let nodes = (0..=layers as u32).flat_map(|layer| boundary.nodes.iter().map(move |node| node + layer * count));
            solid.boundaries.push(Boundary { name: boundary.name.clone(), facets: facets.collect(), nodes: nodes.collect() });
        }
        for (name, corners, first) in [("bottom", [0, 1, 2, 3], 0), ("top", [4, 5, 6, 7], (layers as u32 - 1) * cells)] {
            let mut name = name.to_string();
            while solid.boundary(&name).is_some() {
                name.push('_');
            }
            let local = local_facet(&corners).unwrap_or_default();
            solid.boundaries.push(Boundary::of_facets(&name, (first..first + cells).map(|cell| Facet { cell, local }).collect()));
        }
        let all = |own: &Vec<u32>| (0..layers as u32).flat_map(|layer| own.iter().map(move |cell| cell + layer * cells)).collect();
        solid.parts = self.parts.iter().map(|(name, own)| (name.clone(), all(own))).collect();
        solid.checked()
    }
}

/// The facet of a hex8 with these corners.
fn local_facet(corners: &[usize; 4]) -> Option<u8> {
    CellKind::Hex8.facets().iter().position(|facet| corners.iter().all(|corner| facet.contains(corner))).map(|local| local as u8)
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
