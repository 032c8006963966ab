//! Cells cut into other cells: refinement, and cells of another kind.
//!
//! A *template* gives the positions of the children's nodes on the reference cell. A node is identified by the weights of the corners of
//! the cell, which are equal for two cells that share a facet, so that meshes stay conforming without a table of edges. A facet of a child
//! belongs to the parent's facet on which it lies; boundaries and parts follow.

use std::collections::HashMap;

use super::check::{between, determinant};
use super::grid::room_for;
use super::{Boundary, Facet, Mesh, MeshError};
use crate::elements::{CellKind, CellShape};

/// Bytes per node of a cell, including the table of nodes, while cells are divided (measured: 70).
const DIVIDED: usize = 75;

/// A place on a reference cell.
type Place = [f64; 3];

/// Weights of a parent's corners and of its nodes at several places.
type Weights = Vec<(Vec<f64>, Vec<f64>)>;

/// Children of one kind, by the places of their nodes on the parent's reference cell.
struct Template {
    children: Vec<Vec<Place>>,
    /// Per facet of the parent, the children's facets on it, from its first corner on.
    pieces: Vec<Vec<(u32, u8)>>,
}

/// The corners that a node stands between, and their weights in 64ths; the unused rest is the same for all.
type NodeKey = [(u32, u8); 8];

/// Weights of the corners of a reference cell at a place.
fn corner_weights(shape: CellShape, place: Place) -> Vec<f64> {
    let linear = match shape {
        CellShape::Triangle => CellKind::Tri3,
        CellShape::Quadrilateral => CellKind::Quad4,
        CellShape::Tetrahedron => CellKind::Tet4,
        CellShape::Hexahedron => CellKind::Hex8,
    };
    (linear.row().shape)(place)
}

fn key(cell: &[u32], weights: &[f64]) -> NodeKey {
    let mut key = [(u32::MAX, 0); 8];
    let present = weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0);
    for (slot, (corner, weight)) in key.iter_mut().zip(present) {
        *slot = (cell[corner], (64.0 * weight) as u8);
    }
    key.sort_unstable();
    key
}

/// The place half way between two.
pub(super) fn mean(a: Place, b: Place) -> Place {
    [0, 1, 2].map(|i| 0.5 * (a[i] + b[i]))
}

impl Template {
    /// Children of a kind with these corners, in a parent of a kind.
    fn new(parent: CellKind, child: CellKind, corners: &[Vec<Place>]) -> Template {
        let (shape, row) = (child.shape(), child.row());
        let node = |corners: &[Place], place: Place| {
            let weights = corner_weights(shape, place);
            [0, 1, 2].map(|i| corners.iter().zip(&weights).map(|(corner, weight)| weight * corner[i]).sum())
        };
        let children: Vec<Vec<Place>> =
            corners.iter().map(|corners| row.node_places.iter().map(|&place| node(corners, place)).collect()).collect();
        let weights = |place: Place| corner_weights(parent.shape(), place);
        let corners_of =
            |facet: &[usize], shape: CellShape| -> Vec<usize> { facet.iter().copied().filter(|&node| node < shape.corners()).collect() };
        let pieces = parent.facets().iter().map(|facet| {
            let facet = corners_of(facet, parent.shape());
            let mut pieces = Vec::new();
            for (number, nodes) in children.iter().enumerate() {
                for (local, ends) in child.facets().iter().enumerate() {
                    let ends: Vec<Vec<f64>> = corners_of(ends, shape).into_iter().map(|node| weights(nodes[node])).collect();
                    let is_on = ends.iter().flat_map(|at| at.iter().enumerate()).all(|(corner, at)| *at == 0.0 || facet.contains(&corner));
                    if is_on {
                        let nearness: f64 = ends.iter().map(|at| at[facet[0]]).sum();
                        pieces.push((nearness, (number as u32, local as u8)));
                    }
                }
            }
            pieces.sort_by(|a, b| b.0.total_cmp(&a.0));
            pieces.into_iter().map(|(_, piece)| piece).collect()
        });
        let pieces = pieces.collect();
        Template { children, pieces }
    }
}

/// Corners of a reference cell.
fn corners(kind: CellKind) -> Vec<Place> {
    kind.row().node_places[..kind.shape().corners()].to_vec()
}

/// Corners of the children of a refined cell, the first ones at the parent's corners.
pub(super) fn halves(kind: CellKind) -> Vec<Vec<Place>> {
    let corners = corners(kind);
    let middle = |a: usize, b: usize| mean(corners[a], corners[b]);
    let mut children: Vec<Vec<Place>> = (0..corners.len()).map(|a| (0..corners.len()).map(|b| middle(a, b)).collect()).collect();
    match kind.shape() {
        CellShape::Triangle => children.push(vec![middle(1, 2), middle(2, 0), middle(0, 1)]),
        CellShape::Tetrahedron => {
            // The octahedron that is left, cut along the line between the middles of 0-2 and 1-3.
            let around = [middle(0, 1), middle(1, 2), middle(2, 3), middle(0, 3)];
            for k in 0..4 {
                children.push(turned_out(vec![middle(0, 2), middle(1, 3), around[k], around[(k + 1) % 4]]));
            }
        }
        CellShape::Quadrilateral | CellShape::Hexahedron => {}
    }
    children
}

/// A tetrahedron whose volume is positive.
fn turned_out(mut corners: Vec<Place>) -> Vec<Place> {
    let edge = |k: usize| between(corners[0], corners[k]);
    if determinant([edge(1), edge(2), edge(3)]) < 0.0 {
        corners.swap(2, 3);
    }
    corners
}

/// Tetrahedra of a hexahedron: the cone from corner `apex` over the three facets that it is not on, each cut from its first corner or,
/// where its bit of `turned` is set, from its second one.
fn cone(apex: usize, turned: usize) -> Vec<Vec<Place>> {
    let places = corners(CellKind::Hex8);
    let away = CellKind::Hex8.facets().iter().filter(|facet| !facet.contains(&apex));
    let cut = away.enumerate().flat_map(|(bit, facet)| {
        let first = turned >> bit & 1;
        let at = |k: usize| facet[(first + k) % 4];
        [[at(0), at(1), at(2)], [at(0), at(2), at(3)]]
    });
    cut.map(|triangle| turned_out(vec![places[apex], places[triangle[0]], places[triangle[1]], places[triangle[2]]])).collect()
}

/// Index of the [`cone`] that cuts every facet from its smallest node, so that neighbors agree.
fn cone_of(cell: &[u32]) -> usize {
    let apex = (0..8).min_by_key(|&corner| cell[corner]).unwrap_or_default();
    let away = CellKind::Hex8.facets().iter().filter(|facet| !facet.contains(&apex));
    let turned = away.enumerate().map(|(bit, facet)| {
        let smallest = (0..4).min_by_key(|&k| cell[facet[k]]).unwrap_or_default();
        (smallest % 2) << bit
    });
    8 * apex + turned.sum::<usize>()
}

impl Mesh {
    /// The mesh with every cell cut at the middles of its edges: quadrilaterals and triangles into 4, hexahedra and tetrahedra into 8;
    /// boundaries and parts kept. It covers the same set of points: curved boundaries that the coarse mesh cut off are not recovered.
    ///
    /// Old nodes keep their numbers. The children of a cell follow each other, first those at its corners in their order.
    ///
    /// # Errors
    /// More cells than [`CELL_LIMIT`](crate::mesh::CELL_LIMIT).
    pub fn refine(&self) -> Result<Mesh, MeshError> {
        let template = Template::new(self.kind, self.kind, &halves(self.kind));
        self.divided(self.kind, &[template], |_| 0)
    }

    /// The mesh with cells of another kind on the same corners: `quad4` as `quad8`, `quad9`, `tri3` or `tri6` (cut along the shorter
    /// diagonal), `tri3` as `tri6`, `hex8` as `hex20`, `hex27`, `tet4` or `tet10` (six each), `tet4` as `tet10`. New nodes stand on
    /// straight edges. Old nodes keep their numbers.
    ///
    /// # Errors
    /// Kinds that do not follow from one another, more cells than [`CELL_LIMIT`](crate::mesh::CELL_LIMIT).
    pub fn with_cells(&self, kind: CellKind) -> Result<Mesh, MeshError> {
        let is_same_shape = self.kind.shape() == kind.shape();
        if self.kind == kind {
            return Ok(self.clone());
        }
        match (self.kind, kind) {
            (CellKind::Quad4 | CellKind::Tri3 | CellKind::Hex8 | CellKind::Tet4, _) if is_same_shape => {
                self.divided(kind, &[Template::new(self.kind, kind, &[corners(kind)])], |_| 0)
            }
            // By way of triangles: the middle of the diagonal stands on the straight diagonal, not at the place of the cell's centre.
            (CellKind::Quad4, CellKind::Tri6) => self.with_cells(CellKind::Tri3)?.with_cells(kind),
            (CellKind::Hex8, CellKind::Tet10) => self.with_cells(CellKind::Tet4)?.with_cells(kind),
            (CellKind::Quad4, CellKind::Tri3) => {
                let at = corners(self.kind);
                let cut = |[a, b, c]: [usize; 3]| vec![at[a], at[b], at[c]];
                let templates =
                    [[[0, 1, 2], [0, 2, 3]], [[1, 2, 3], [1, 3, 0]]].map(|children| Template::new(self.kind, kind, &children.map(cut)));
                let length = |a: u32, b: u32| {
                    let [a, b] = [a, b].map(|node| self.points[node as usize]);
                    (b[0] - a[0]).hypot(b[1] - a[1])
                };
                self.divided(kind, &templates, |cell| usize::from(length(cell[1], cell[3]) < length(cell[0], cell[2])))
            }
            (CellKind::Hex8, CellKind::Tet4) => {
                let templates: Vec<Template> = (0..64).map(|index| Template::new(self.kind, kind, &cone(index / 8, index % 8))).collect();
                self.divided(kind, &templates, cone_of)
            }
            _ => Err(MeshError::NoConversion { from: self.kind.name(), to: kind.name() }),
        }
    }

    /// The mesh with every cell divided by the template that is chosen for it.
    fn divided(&self, kind: CellKind, templates: &[Template], choose: impl Fn(&[u32]) -> usize) -> Result<Mesh, MeshError> {
        let most = templates.iter().map(|template| template.children.len()).max().unwrap_or_default();
        let cells = self.cell_count().saturating_mul(most);
        room_for(cells, DIVIDED * kind.nodes())?;
        let shape = self.kind.row().shape;
        let weigh = |places: &[Place]| -> Weights {
            places.iter().map(|&place| (corner_weights(self.kind.shape(), place), shape(place))).collect()
        };
        let own = weigh(self.kind.row().node_places);
        let weights: Vec<Vec<Weights>> =
            templates.iter().map(|template| template.children.iter().map(|places| weigh(places)).collect()).collect();
        let (mut points, mut connectivity) = (self.points.clone(), Vec::with_capacity(cells * kind.nodes()));
        let mut known: HashMap<NodeKey, u32> = HashMap::new();
        // Per cell, its template and its first child.
        let mut divisions = Vec::with_capacity(self.cell_count());
        for cell in self.cells() {
            let chosen = choose(cell);
            divisions.push((chosen, (connectivity.len() / kind.nodes()) as u32));
            for ((corners, _), &node) in own.iter().zip(cell) {
                known.insert(key(cell, corners), node);
            }
            for (corners, at) in weights[chosen].iter().flatten() {
                let node = *known.entry(key(cell, corners)).or_insert_with(|| {
                    let sum = |i: usize| cell.iter().zip(at).map(|(&node, weight)| weight * self.points[node as usize][i]).sum();
                    points.push([sum(0), sum(1), sum(2)]);
                    points.len() as u32 - 1
                });
                connectivity.push(node);
            }
        }
        let pieces = |facet: &Facet| {
            let (chosen, first) = divisions[facet.cell as usize];
            let pieces = &templates[chosen].pieces[facet.local as usize];
            pieces.iter().map(move |&(child, local)| Facet { cell: first + child, local })
        };
        let finer = |b: &Boundary| Boundary { facets: b.facets.iter().flat_map(pieces).collect(), ..b.clone() };
        let boundaries = self.boundaries.iter().map(finer).collect();
        let offspring = |&cell: &u32| {
            let (chosen, first) = divisions[cell as usize];
            first..first + templates[chosen].children.len() as u32
        };
        let parts = self.parts.iter().map(|(name, cells)| (name.clone(), cells.iter().flat_map(offspring).collect())).collect();
        Ok(Mesh { kind, points, connectivity, boundaries, parts })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{block, rectangle, ring};

    /// Same measure, same boundaries, conforming: the hull is the boundaries.
    fn same(mesh: &Mesh, other: &Mesh) {
        let what = format!("{:?} as {:?}", mesh.kind, other.kind);
        assert_eq!(other.defects(), [], "{what}");
        assert!((mesh.measure() - other.measure()).abs() < 1e-12 * mesh.measure(), "{what}");
        let mut named: Vec<Facet> = Vec::new();
        for (boundary, divided) in mesh.boundaries.iter().zip(&other.boundaries) {
            let (before, after) = (mesh.boundary_measure(boundary), other.boundary_measure(divided));
            // The area of a warped facet is no polynomial: more points see it better.
            let allowed = if mesh.dimension() == 3 && mesh.kind != other.kind { 1e-8 } else { 1e-12 };
            assert!((before - after).abs() < allowed * before, "{what}: {} {before} {after}", boundary.name);
            named.extend(&divided.facets);
            if mesh.dimension() == 2 {
                let ends: Vec<Vec<u32>> = divided.facets.iter().map(|&facet| other.facet_nodes(facet).collect()).collect();
                assert!(ends.windows(2).all(|pair| pair[0][1] == pair[1][0]), "{what}: traversed with the body on the left");
            }
        }
        named.sort_unstable();
        assert_eq!(other.hull(), named, "{what}");
    }

    #[test]
    fn every_kind_that_follows_from_another_covers_the_same_and_so_does_its_refinement() {
        use CellKind::*;
        let plane = ring(0.5, 1.0, [2, 7], [1.0, 2.0], 0.1).unwrap();
        for kind in [Tri3, Tri6, Quad8, Quad9] {
            let mesh = plane.with_cells(kind).unwrap();
            same(&plane, &mesh);
            same(&mesh, &mesh.refine().unwrap());
        }
        same(&plane.with_cells(Tri3).unwrap(), &plane.with_cells(Tri3).unwrap().with_cells(Tri6).unwrap());
        let mut solid = block([3.0, 1.0, 2.0], [3, 2, 2], [0.0; 3]).unwrap();
        same(&solid, &solid.refine().unwrap());
        for point in &mut solid.points {
            // Numbers in another order make other diagonals.
            point[0] += 0.05 * point[1] * point[2];
        }
        let last = solid.points.len() as u32 - 1;
        let shuffled = |node: u32| (node * 7 + 3) % (last + 1);
        let mut other = solid.clone();
        other.connectivity.iter_mut().for_each(|node| *node = shuffled(*node));
        for (node, point) in solid.points.iter().enumerate() {
            other.points[shuffled(node as u32) as usize] = *point;
        }
        for solid in [solid, other] {
            for kind in [Hex20, Hex27] {
                let mesh = solid.with_cells(kind).unwrap();
                same(&solid, &mesh);
                same(&mesh, &mesh.refine().unwrap());
            }
            let tets = solid.with_cells(Tet4).unwrap();
            assert_eq!(tets.cell_count(), 6 * 12);
            // Facets of hexahedra that are not plane are cut into plane triangles.
            let (hull, named) = (tets.hull().len(), tets.boundaries.iter().map(|b| b.facets.len()).sum::<usize>());
            assert_eq!((hull, named, tets.defects()), (named, hull, Vec::new()));
            same(&tets, &tets.refine().unwrap());
            let quadratic = tets.with_cells(Tet10).unwrap();
            same(&tets, &quadratic);
            same(&quadratic, &quadratic.refine().unwrap());
        }
        assert!(matches!(plane.with_cells(Hex8), Err(MeshError::NoConversion { from: "quad4", to: "hex8" })));
    }

    #[test]
    fn the_middle_of_a_diagonal_is_on_the_straight_diagonal() {
        let mut mesh = rectangle([1.0, 1.0], [1, 1], [0.0; 2]).unwrap();
        let corner = mesh.points.iter().position(|point| point[0] == 1.0 && point[1] == 1.0).unwrap();
        mesh.points[corner] = [1.6, 1.2, 0.0];
        assert!(mesh.with_cells(CellKind::Tri6).unwrap().points.contains(&[0.5, 0.5, 0.0]));
    }

    #[test]
    fn a_curved_edge_stays_curved_when_it_is_refined() {
        let mut mesh = rectangle([1.0, 1.0], [1, 1], [0.0; 2]).unwrap().with_cells(CellKind::Quad8).unwrap();
        mesh.points[4][1] = -0.2;
        let fine = mesh.refine().unwrap();
        assert!((fine.measure() - mesh.measure()).abs() < 1e-14);
        assert_eq!(fine.defects(), []);
    }
}
