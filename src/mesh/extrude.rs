//! Extrusion of a plane mesh: along z or along a path, with twist and scale, or as a loft towards another plane mesh.

use std::f64::consts::FRAC_PI_2;

use super::grid::{at_least, graded, limited, positive};
use super::path::{SectionFrame, frames};
use super::sweep::{Prisms, Sweep};
use super::{Mesh, MeshError};
use crate::math::tolerances::SAME_PLACE;

/// Change of a section along an extrusion, and the cells over its triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// Rotation of the section at the end, counter-clockwise about the origin of the plane `[rad]`.
    pub twist: f64,
    /// Ratios of the sizes along x and y at the end to those at the start, about the origin of the plane.
    pub scale: [f64; 2],
    /// Solid cells over triangles; beside quadrilaterals these are always wedges.
    pub prisms: Prisms,
}

impl Change {
    /// Extrusion without twist and scale.
    pub const NONE: Change = Change { twist: 0.0, scale: [1.0; 2], prisms: Prisms::Cut };

    /// Returns the change if it is valid for a number of layers: a layer with a twist of more than a right angle would be pinched in its
    /// middle.
    fn checked(self, direction: &'static str, layers: usize) -> Result<Change, MeshError> {
        self.scale.into_iter().try_for_each(|scale| positive("the scale of an extrusion", scale))?;
        if !self.twist.is_finite() {
            return Err(MeshError::NotFinite { what: "the twist of an extrusion", value: self.twist });
        }
        let least = (self.twist.abs() / FRAC_PI_2 * (1.0 - SAME_PLACE)).ceil().max(1.0);
        at_least(direction, layers, least as usize)?;
        Ok(self)
    }

    /// Position of a point of the section in its plane after a fraction of the extrusion.
    fn at(self, share: f64, [x, y, _]: [f64; 3]) -> [f64; 2] {
        let grown = |scale: f64| 1.0 - share + scale * share;
        let (x, y) = (x * grown(self.scale[0]), y * grown(self.scale[1]));
        let (sine, cosine) = (self.twist * share).sin_cos();
        [cosine * x - sine * y, sine * x + cosine * y]
    }
}

impl Mesh {
    /// Extrusion along z from 0 to `height` `[length]` in `layers`, of which the last is `grading` times the first: quad4 as hex8, quad8 as
    /// hex20, quad9 as hex27, tri3 as tet4, tri6 as tet10 (three tetrahedra in each prism). Triangles become wedges if `change` requires it
    /// and beside quadrilaterals. Boundaries of the plane mesh become sides; `bottom` and `top` are added (with an underscore appended if
    /// the plane mesh has boundaries of these names).
    ///
    /// # Errors
    /// Cells in space, a height, ratio or scale that is not positive, no layers, too many cells, a twist of too few layers.
    pub fn extruded(&self, height: f64, layers: usize, grading: f64, change: Change) -> Result<Mesh, MeshError> {
        positive("the height of an extrusion", height)?;
        let change = change.checked("along the height", layers)?;
        limited(&[self.cell_count(), layers])?;
        let places = graded(layers, grading)?;
        self.swept(&Sweep { prisms: change.prisms, ..straight(layers) }, |row, node| {
            let [x, y] = change.at(places[row], self.points[node]);
            [x, y, height * places[row]]
        })
    }

    /// Extrusion along the path through these points `[length]`, with a layer between consecutive points; a path that ends at its first
    /// point closes. The section is normal to the path with the origin of its plane on the path. At the first point it is rotated from the
    /// plane by the smallest rotation; from there on it does not rotate about the path (a closed path distributes the remaining angle over
    /// its length). `bottom` is at the start of the path and `top` at its end.
    ///
    /// The direction of the path at a point is that of the circle through it and its neighbors, so that straight and circular paths are
    /// exact.
    ///
    /// # Errors
    /// Errors of [`Mesh::extruded`]; a path of fewer than two points, with coincident points, with a turn of more than 90 degrees at a
    /// point, or with bends so sharp that the section sweeps over itself; a section that changes along a closed path.
    pub fn extruded_along(&self, path: &[[f64; 3]], change: Change) -> Result<Mesh, MeshError> {
        let (frames, is_closed) = frames(path)?;
        let change = change.checked("along the path", path.len() - 1)?;
        if is_closed && (change.twist, change.scale) != (Change::NONE.twist, Change::NONE.scale) {
            return Err(MeshError::ClosedChange);
        }
        let sweep = Sweep { is_closed, prisms: change.prisms, ..straight(path.len() - 1) };
        self.swept(&sweep, |row, node| {
            let SectionFrame { at, share, along: [x, y] } = &frames[row];
            let [a, b] = change.at(*share, self.points[node]);
            [0, 1, 2].map(|i| at[i] + a * x[i] + b * y[i])
        })
    }

    /// Loft between this plane mesh at z = 0 and another one with the same cells at `height` `[length]`: every node moves straight to its
    /// counterpart, in `layers` of which the last is `grading` times the first, with the cells of an extrusion. Boundaries and parts are
    /// those of this mesh, `bottom` and `top`.
    ///
    /// # Errors
    /// Errors of [`Mesh::extruded`]; meshes whose cells do not name the same nodes.
    pub fn lofted(&self, other: &Mesh, height: f64, layers: usize, grading: f64, prisms: Prisms) -> Result<Mesh, MeshError> {
        positive("the height of a loft", height)?;
        at_least("along the height", layers, 1)?;
        if self.points.len() != other.points.len() || self.blocks != other.blocks {
            let told = |mesh: &Mesh| format!("{} and {} nodes", mesh.counted_cells(), mesh.points.len());
            return Err(MeshError::Lofted { first: told(self), second: told(other) });
        }
        limited(&[self.cell_count(), layers])?;
        let places = graded(layers, grading)?;
        self.swept(&Sweep { prisms, ..straight(layers) }, |row, node| {
            let (share, from, to) = (places[row], self.points[node], other.points[node]);
            let between = |i: usize| from[i] * (1.0 - share) + to[i] * share;
            [between(0), between(1), height * share]
        })
    }
}

/// Open sweep with two ends.
fn straight(layers: usize) -> Sweep<'static> {
    Sweep { layers, is_closed: false, is_backward: false, ends: ["bottom", "top"], prisms: Prisms::Cut }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::CellKind;
    use crate::mesh::{Boundary, Facet, block, rectangle, ring};

    #[test]
    fn a_ring_becomes_a_tube() {
        let mut plane = ring(0.5, 1.0, [2, 12], [0.0; 2], 0.0).unwrap();
        plane.parts = vec![("half".into(), (0..12).collect())];
        let tube = plane.extruded(3.0, 4, 2.0, Change::NONE).unwrap();
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
        let solid = plane.extruded(1.5, 2, 1.0, Change::NONE).unwrap();
        assert_eq!((solid.only_kind(), solid.cell_count()), (Some(CellKind::Tet4), 2 * 3 * 12));
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
            let tube = plane.extruded(3.0, 2, 2.0, Change::NONE).unwrap();
            assert_eq!((tube.only_kind(), tube.defects()), (Some(solid), Vec::new()));
            // Tetrahedra on curved sides have a quadrature error: three points for the area of a curved triangle, four for the volume.
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
        let solid = plane.extruded(4.0, 2, 1.0, Change::NONE).unwrap();
        let direct = block([1.0, 2.0, 4.0], [2, 3, 2], [0.0; 3]).unwrap();
        assert_eq!((solid.points, solid.blocks), (direct.points, direct.blocks.clone()));
        let names: Vec<&str> = solid.boundaries.iter().map(|b| b.name.as_str()).collect();
        assert_eq!(names, ["left", "right", "bottom", "top", "bottom_", "top_"]);
        assert!(matches!(direct_again(), Err(MeshError::Extruded { kind: "hex8" })));
        assert!(matches!(plane.extruded(0.0, 1, 1.0, Change::NONE), Err(MeshError::NotPositive { .. })));
        assert!(matches!(plane.extruded(1.0, 0, 1.0, Change::NONE), Err(MeshError::TooFewCells { .. })));
        assert!(matches!(plane.extruded(1.0, usize::MAX, 1.0, Change::NONE), Err(MeshError::TooManyCells { .. })));
    }

    fn direct_again() -> Result<Mesh, MeshError> {
        block([1.0; 3], [1, 1, 1], [0.0; 3])?.extruded(1.0, 1, 1.0, Change::NONE)
    }
}
