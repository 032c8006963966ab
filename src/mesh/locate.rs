//! Cells at points of a mesh, with the values of their shape functions.

use nalgebra::{Matrix3, Vector3};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use super::Mesh;
use crate::elements::CellShape;
use crate::math::tolerances::{INSIDE_CELL, LOCATED};

/// Largest number of iterations: valid cells need fewer than ten.
const ITERATIONS: usize = 30;

/// Largest distance of a point from its cell, relative to the cell, for which the nearest point of the cell is used: chords of a round side
/// with facets of 30 degrees lie this far inside of the arc.
const BESIDE: f64 = 0.05;

/// Spatial index of the cells of a mesh.
pub struct CellFinder<'a> {
    mesh: &'a Mesh,
    tree: RTree<GeomWithData<Rectangle<[f64; 3]>, usize>>,
}

impl<'a> CellFinder<'a> {
    /// Index of the cells of the undeformed mesh.
    pub fn new(mesh: &'a Mesh) -> Self {
        let boxes = mesh.cells().enumerate().map(|(index, cell)| {
            let end = |pick: fn(f64, f64) -> f64| -> [f64; 3] {
                std::array::from_fn(|i| cell.iter().map(|&node| mesh.points[node as usize][i]).reduce(pick).unwrap_or_default())
            };
            let (low, high) = (end(f64::min), end(f64::max));
            let reach = BESIDE * (0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max);
            // The bounding box is enlarged, because the nodes of a curved cell do not bound it exactly.
            GeomWithData::new(Rectangle::from_corners(low.map(|x| x - reach), high.map(|x| x + reach)), index)
        });
        CellFinder { mesh, tree: RTree::bulk_load(boxes.collect()) }
    }

    /// Nodes of the cell at a point with the values of its shape functions; `None` outside of the mesh. A point at a small distance from
    /// the mesh counts as the nearest point of the cell.
    pub fn shares(&self, point: [f64; 3]) -> Option<Vec<(u32, f64)>> {
        let mut best: Option<(f64, Vec<(u32, f64)>)> = None;
        let mut found: Vec<usize> = self.tree.locate_in_envelope_intersecting(AABB::from_point(point)).map(|found| found.data).collect();
        found.sort_unstable();
        for cell in found {
            let (distance, shares) = self.in_cell(cell, point);
            if best.as_ref().is_none_or(|(least, _)| distance < *least) {
                best = Some((distance, shares));
            }
        }
        best.filter(|(distance, _)| *distance <= BESIDE).map(|(_, shares)| shares)
    }

    /// Distance of a point from a cell relative to its size, 0 inside, and the shape functions at the nearest point of the cell.
    fn in_cell(&self, cell: usize, point: [f64; 3]) -> (f64, Vec<(u32, f64)>) {
        let (kind, nodes) = self.mesh.kind_and_cell(cell);
        let row = kind.row();
        let places: Vec<Vector3<f64>> = nodes.iter().map(|&node| Vector3::from(self.mesh.points[node as usize])).collect();
        let size = places.iter().map(|x| (x - places[0]).norm()).fold(0.0, f64::max);
        let position = |xi: [f64; 3]| (row.shape)(xi).iter().zip(&places).map(|(shape, x)| x * *shape).sum::<Vector3<f64>>();
        let simplex = simplex_dimension(row.cell_shape);
        let mut xi: [f64; 3] = std::array::from_fn(|i| if i < simplex { 1.0 / (1.0 + simplex as f64) } else { 0.0 });
        for _ in 0..ITERATIONS {
            let off = Vector3::from(point) - position(xi);
            if off.norm() <= LOCATED * size {
                break;
            }
            let mut jacobian = Matrix3::zeros();
            for (gradient, x) in (row.gradients)(xi).iter().zip(&places) {
                jacobian += x * Vector3::from(*gradient).transpose();
            }
            (row.dimension..3).for_each(|i| jacobian[(i, i)] = 1.0);
            let Some(step) = jacobian.lu().solve(&off) else { break };
            (0..row.dimension).for_each(|i| xi[i] += step[i].clamp(-1.0, 1.0));
        }
        let inside = clamped(xi, simplex);
        let moved = (0..3).map(|i| (inside[i] - xi[i]).abs()).fold(0.0, f64::max);
        let distance = if moved <= INSIDE_CELL { 0.0 } else { (Vector3::from(point) - position(inside)).norm() / size };
        (distance, nodes.iter().copied().zip((row.shape)(inside)).collect())
    }
}

/// Number of leading reference coordinates that are nonnegative with a sum of at most 1; the others lie between -1 and 1.
fn simplex_dimension(shape: CellShape) -> usize {
    match shape {
        CellShape::Triangle | CellShape::Wedge => 2,
        CellShape::Tetrahedron => 3,
        CellShape::Quadrilateral | CellShape::Hexahedron | CellShape::Pyramid => 0,
    }
}

/// Nearest reference point within the reference cell, coordinate by coordinate.
fn clamped(xi: [f64; 3], simplex: usize) -> [f64; 3] {
    let mut inside: [f64; 3] = std::array::from_fn(|i| if i < simplex { xi[i].max(0.0) } else { xi[i].clamp(-1.0, 1.0) });
    let sum: f64 = inside[..simplex].iter().sum();
    if sum > 1.0 {
        inside[..simplex].iter_mut().for_each(|x| *x /= sum);
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::CellKind;
    use crate::mesh::{block, rectangle};

    #[test]
    fn shape_functions_give_the_point_back() {
        let plane = rectangle([2.0, 1.0], [4, 3], [0.0, 0.0]).unwrap();
        let solid = block([2.0, 1.0, 1.5], [3, 2, 2], [0.0, 0.0, -0.5]).unwrap();
        for (mesh, depth) in [(&plane, 0.0), (&solid, 0.3)] {
            let finder = CellFinder::new(mesh);
            for point in [[0.3, 0.7, depth], [2.0, 1.0, depth], [1.0, 0.0, depth]] {
                let shares = finder.shares(point).unwrap();
                let back: [f64; 3] = [0, 1, 2].map(|i| shares.iter().map(|&(node, share)| share * mesh.points[node as usize][i]).sum());
                assert!((0..3).all(|i| (back[i] - point[i]).abs() < 1e-13), "{back:?}");
            }
            assert!(finder.shares([2.1, 0.5, depth]).is_none() && finder.shares([0.5, 3.0, depth]).is_none());
        }
    }

    /// A wedge, and a pyramid up to its apex, where its reference coordinates are undetermined.
    #[test]
    fn points_in_wedges_and_pyramids_are_found() {
        for kind in [CellKind::Wedge6, CellKind::Pyr5] {
            let points = kind.row().node_places.to_vec();
            let apex = points[points.len() - 1];
            let mesh = Mesh::new(kind, points, (0..kind.nodes() as u32).collect());
            let finder = CellFinder::new(&mesh);
            for point in [[0.2, 0.1, -0.4], [0.3, 0.3, -1.0], apex] {
                let shares = finder.shares(point).unwrap();
                let back: [f64; 3] = [0, 1, 2].map(|i| shares.iter().map(|&(node, share)| share * mesh.points[node as usize][i]).sum());
                assert!((0..3).all(|i| (back[i] - point[i]).abs() < 1e-9), "{kind:?} {point:?}: {back:?}");
            }
            assert!(finder.shares([0.9, 0.9, 0.8]).is_none());
        }
    }
}
