//! Division of cells into other cells: refinement, and conversion to another kind.
//!
//! A *template* gives the positions of the nodes of the children on the reference cell. A node is identified by the weights of the corners
//! of the cell, which are equal for two cells that share a facet, so that meshes stay conforming without a table of edges. A facet of a
//! child belongs to the parent's facet on which it lies; boundaries and parts follow.

use std::collections::HashMap;

use super::check::{between, determinant};
use super::grid::room_for;
use super::{Boundary, Facet, Mesh, MeshError};
use crate::elements::{CellKind, CellShape};

/// Bytes per node of a cell, including the table of nodes, while cells are divided (measured: 70).
const DIVIDED: usize = 75;

/// A place on a reference cell.
type ReferencePoint = [f64; 3];

/// For several places on a parent: weights of the parent's corners, and values of the shape functions of all its nodes.
type Weights = Vec<(Vec<f64>, Vec<f64>)>;

/// Division of a parent cell into children of one kind, given by the positions of their nodes on the parent's reference cell.
struct Template {
    children: Vec<Vec<ReferencePoint>>,
    /// For each facet of the parent: the facets `(child, local facet)` on it, beginning at its first corner.
    pieces: Vec<Vec<(u32, u8)>>,
}

/// Index of the template for a cell, given its nodes.
type Choice<'a> = Box<dyn Fn(&[u32]) -> usize + 'a>;

/// Division of the cells of a block.
struct Division<'a> {
    /// Kind of the children.
    child: CellKind,
    templates: Vec<Template>,
    choose: Choice<'a>,
}

impl Division<'_> {
    /// Division of all cells by the first template.
    fn into(child: CellKind, templates: Vec<Template>) -> Self {
        Division { child, templates, choose: Box::new(|_| 0) }
    }
}

/// Corners with nonzero weights of a node and the weights in 64ths; unused entries are equal.
type NodeKey = [(u32, u8); 8];

/// Weights of the corners of a reference cell at a point.
fn corner_weights(shape: CellShape, place: ReferencePoint) -> Vec<f64> {
    let linear = match shape {
        CellShape::Triangle => CellKind::Tri3,
        CellShape::Quadrilateral => CellKind::Quad4,
        CellShape::Tetrahedron => CellKind::Tet4,
        CellShape::Hexahedron => CellKind::Hex8,
        CellShape::Wedge => CellKind::Wedge6,
        CellShape::Pyramid => CellKind::Pyr5,
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

/// Midpoint of two points.
pub(super) fn mean(a: ReferencePoint, b: ReferencePoint) -> ReferencePoint {
    [0, 1, 2].map(|i| 0.5 * (a[i] + b[i]))
}

impl Template {
    /// Template with children of the kind `child` with these corners in a parent of the kind `parent`; other nodes follow by the child's
    /// shape functions.
    fn new(parent: CellKind, child: CellKind, corners: &[Vec<ReferencePoint>]) -> Template {
        let (shape, row) = (child.shape(), child.row());
        let node = |corners: &[ReferencePoint], place: ReferencePoint| {
            let weights = corner_weights(shape, place);
            [0, 1, 2].map(|i| corners.iter().zip(&weights).map(|(corner, weight)| weight * corner[i]).sum())
        };
        let children = corners.iter().map(|corners| row.node_places.iter().map(|&place| node(corners, place)).collect()).collect();
        Template::of(parent, child, children)
    }

    /// Template with children of the kind `child` whose nodes are at these points in a parent of the kind `parent`.
    fn of(parent: CellKind, child: CellKind, children: Vec<Vec<ReferencePoint>>) -> Template {
        let shape = child.shape();
        let weights = |place: ReferencePoint| corner_weights(parent.shape(), place);
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
fn corners(kind: CellKind) -> Vec<ReferencePoint> {
    kind.row().node_places[..kind.shape().corners()].to_vec()
}

/// Corners of the children of a refined cell, the first ones at the parent's corners.
pub(super) fn halves(kind: CellKind) -> Vec<Vec<ReferencePoint>> {
    let corners = corners(kind);
    let middle = |a: usize, b: usize| mean(corners[a], corners[b]);
    let mut children: Vec<Vec<ReferencePoint>> = (0..corners.len()).map(|a| (0..corners.len()).map(|b| middle(a, b)).collect()).collect();
    match kind.shape() {
        CellShape::Triangle => children.push(vec![middle(1, 2), middle(2, 0), middle(0, 1)]),
        CellShape::Tetrahedron => {
            // The remaining octahedron, divided along the line between the midpoints of 0-2 and 1-3.
            let around = [middle(0, 1), middle(1, 2), middle(2, 3), middle(0, 3)];
            for k in 0..4 {
                children.push(turned_out(vec![middle(0, 2), middle(1, 3), around[k], around[(k + 1) % 4]]));
            }
        }
        CellShape::Wedge => {
            let below = [middle(1, 2), middle(2, 0), middle(0, 1)];
            let above = [middle(4, 5), middle(5, 3), middle(3, 4)];
            let between = [0, 1, 2].map(|k| mean(below[k], above[k]));
            children.extend([[below, between].concat(), [between, above].concat()]);
        }
        CellShape::Quadrilateral | CellShape::Hexahedron | CellShape::Pyramid => {}
    }
    children
}

/// Tetrahedron reordered to a positive volume.
fn turned_out(mut corners: Vec<ReferencePoint>) -> Vec<ReferencePoint> {
    let edge = |k: usize| between(corners[0], corners[k]);
    if determinant([edge(1), edge(2), edge(3)]) < 0.0 {
        corners.swap(2, 3);
    }
    corners
}

/// Tetrahedra of a hexahedron: the cone from the corner `apex` over the three opposite facets, each divided from its first corner or, if
/// its bit of `turned` is set, from its second one.
fn cone(apex: usize, turned: usize) -> Vec<Vec<ReferencePoint>> {
    let places = corners(CellKind::Hex8);
    let away = CellKind::Hex8.facets().iter().filter(|facet| !facet.contains(&apex));
    let cut = away.enumerate().flat_map(|(bit, facet)| {
        let first = turned >> bit & 1;
        let at = |k: usize| facet[(first + k) % 4];
        [[at(0), at(1), at(2)], [at(0), at(2), at(3)]]
    });
    cut.map(|triangle| turned_out(vec![places[apex], places[triangle[0]], places[triangle[1]], places[triangle[2]]])).collect()
}

/// Index of the [`cone`] that divides every facet from its smallest node, so that neighbors agree.
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
    /// Uniform refinement: every cell is divided at the midpoints of its edges, quadrilaterals and triangles into 4, hexahedra, tetrahedra
    /// and wedges into 8; boundaries and parts are kept. The mesh covers the same set of points: nodes are not moved to curved boundaries.
    ///
    /// Old nodes keep their numbers. The children of a cell are consecutive, first those at its corners in their order.
    ///
    /// # Errors
    /// Pyramids, which cannot be divided into pyramids alone; more cells than [`CELL_LIMIT`](crate::mesh::CELL_LIMIT).
    pub fn refine(&self) -> Result<Mesh, MeshError> {
        if let Some(kind) = self.kinds().find(|kind| kind.shape() == CellShape::Pyramid) {
            return Err(MeshError::NotRefined { kind: kind.name() });
        }
        let halved = |kind| Division::into(kind, vec![Template::new(kind, kind, &halves(kind))]);
        self.divided(&self.kinds().map(halved).collect::<Vec<_>>())
    }

    /// Mesh with cells of another kind on the same corners: first-order cells as second-order ones of their shape, `quad4` as `tri3` or
    /// `tri6` (divided along the shorter diagonal), `hex8` as `tet4` or `tet10` (six each), `wedge6` or `wedge15` (two each, divided
    /// through the first and second facet), `pyr5` or `pyr13` (six each, about the center). New nodes lie on straight edges. Old nodes keep
    /// their numbers.
    ///
    /// In a mixed mesh, cells of other shapes become those of the same order.
    ///
    /// # Errors
    /// Kinds without such a conversion, hexahedra whose wedges would not match, more cells than [`CELL_LIMIT`](crate::mesh::CELL_LIMIT).
    pub fn with_cells(&self, kind: CellKind) -> Result<Mesh, MeshError> {
        if self.only_kind() == Some(kind) {
            return Ok(self.clone());
        }
        let refused = |from: CellKind| MeshError::NoConversion { from: from.name(), to: kind.name() };
        let targets: Vec<CellKind> = self.kinds().map(|from| self.target(from, kind)).collect::<Option<_>>().ok_or_else(|| {
            let strange = self.kinds().find(|&from| self.target(from, kind).is_none());
            strange.map_or(MeshError::NoConversion { from: kind.name(), to: kind.name() }, refused)
        })?;
        // Via first-order cells: the midpoint of a diagonal lies on the straight diagonal, not at the center of the cell.
        let cut = self.kinds().zip(&targets).find(|(from, target)| from.shape() != target.shape() && target.is_quadratic());
        if let Some((_, target)) = cut {
            let linear = CellKind::ALL.iter().find(|kind| kind.shape() == target.shape() && kind.is_first_order());
            return self.with_cells(linear.copied().unwrap_or(CellKind::Tri3))?.with_cells(kind);
        }
        let divisions: Option<Vec<Division>> = self.kinds().zip(&targets).map(|(from, &to)| self.division(from, to)).collect();
        let mesh = self.divided(&divisions.ok_or_else(|| refused(self.kinds().next().unwrap_or(kind)))?)?;
        mesh.unmatched().map_or(Ok(mesh), Err)
    }

    /// Kind of the cells after a conversion of the mesh to `kind`; `None` if there is none.
    fn target(&self, from: CellKind, kind: CellKind) -> Option<CellKind> {
        let is_finer = |to: CellKind| from == to || from.is_first_order();
        if from.shape() == kind.shape() {
            return Some(kind).filter(|&to| is_finer(to));
        }
        let is_cut = match self.only_kind() {
            None => from == CellKind::Quad4 && kind.shape() == CellShape::Triangle,
            Some(_) => match from {
                CellKind::Quad4 => kind.shape() == CellShape::Triangle,
                CellKind::Hex8 => matches!(kind.shape(), CellShape::Tetrahedron | CellShape::Wedge | CellShape::Pyramid),
                _ => false,
            },
        };
        let is_beside = self.kinds().any(|other| other.shape() == kind.shape());
        let alike = || CellKind::ALL.iter().copied().find(|to| to.shape() == from.shape() && to.is_quadratic() == kind.is_quadratic());
        if is_cut { Some(kind) } else { alike().filter(|&to| is_beside && is_finer(to)) }
    }

    /// Division of the cells of the kind `from` into cells of the kind `to`; where their shapes differ, both are of first order.
    fn division(&self, from: CellKind, to: CellKind) -> Option<Division<'_>> {
        let at = corners(from);
        let of_corners = |children: &[&[usize]]| {
            let children: Vec<Vec<ReferencePoint>> =
                children.iter().map(|child| child.iter().map(|&corner| at[corner]).collect()).collect();
            Template::new(from, to, &children)
        };
        Some(match (from, to) {
            _ if from.shape() == to.shape() => Division::into(to, vec![Template::of(from, to, vec![to.row().node_places.to_vec()])]),
            (CellKind::Quad4, CellKind::Tri3) => {
                let length = |a: u32, b: u32| {
                    let [a, b] = [a, b].map(|node| self.points[node as usize]);
                    (b[0] - a[0]).hypot(b[1] - a[1])
                };
                Division {
                    child: to,
                    templates: vec![of_corners(&[&[0, 1, 2], &[0, 2, 3]]), of_corners(&[&[1, 2, 3], &[1, 3, 0]])],
                    choose: Box::new(move |cell| usize::from(length(cell[1], cell[3]) < length(cell[0], cell[2]))),
                }
            }
            (CellKind::Hex8, CellKind::Tet4) => {
                let templates = (0..64).map(|index| Template::new(from, to, &cone(index / 8, index % 8))).collect();
                Division { child: to, templates, choose: Box::new(cone_of) }
            }
            (CellKind::Hex8, CellKind::Wedge6) => Division::into(to, vec![of_corners(&[&[0, 1, 2, 4, 5, 6], &[0, 2, 3, 4, 6, 7]])]),
            (CellKind::Hex8, CellKind::Pyr5) => {
                let center = [0.0; 3];
                let over = |facet: &&[usize]| facet.iter().rev().map(|&corner| at[corner]).chain([center]).collect();
                Division::into(to, vec![Template::new(from, to, &from.facets().iter().map(over).collect::<Vec<_>>())])
            }
            _ => return None,
        })
    }

    /// Mesh in which the cells of each block are divided by the chosen templates.
    fn divided(&self, divisions: &[Division]) -> Result<Mesh, MeshError> {
        let most = |division: &Division| division.templates.iter().map(|template| template.children.len()).max().unwrap_or_default();
        let counted = self.blocks.iter().zip(divisions).map(|(block, division)| block.count().saturating_mul(most(division)));
        let nodes = divisions.iter().map(|division| division.child.nodes()).max().unwrap_or_default();
        room_for(counted.sum(), DIVIDED * nodes)?;
        let mut finer = Mesh { points: self.points.clone(), blocks: Vec::new(), boundaries: Vec::new(), parts: Vec::new() };
        let mut known: HashMap<NodeKey, u32> = HashMap::new();
        // For each cell: its division and template, and the number of its first child in the block of the children's kind.
        let mut chosen_of = Vec::with_capacity(self.cell_count());
        for (block, division) in self.blocks.iter().zip(divisions) {
            let Division { child, templates, choose } = division;
            let (row, shape) = (block.kind.row(), block.kind.shape());
            let weigh = |places: &[ReferencePoint]| -> Weights {
                places.iter().map(|&place| (corner_weights(shape, place), (row.shape)(place))).collect()
            };
            let own = weigh(row.node_places);
            let weights: Vec<Vec<Weights>> =
                templates.iter().map(|template| template.children.iter().map(|places| weigh(places)).collect()).collect();
            let mut connectivity = Vec::with_capacity(block.count() * most(division) * child.nodes());
            let start = finer.add_cells(*child, []) as u32;
            for cell in block.cells() {
                let chosen = choose(cell);
                chosen_of.push((division, chosen, start + (connectivity.len() / child.nodes()) as u32));
                for ((corners, _), &node) in own.iter().zip(cell) {
                    known.insert(key(cell, corners), node);
                }
                for (corners, at) in weights[chosen].iter().flatten() {
                    let node = *known.entry(key(cell, corners)).or_insert_with(|| {
                        let sum = |i: usize| cell.iter().zip(at).map(|(&node, weight)| weight * self.points[node as usize][i]).sum();
                        finer.points.push([sum(0), sum(1), sum(2)]);
                        finer.points.len() as u32 - 1
                    });
                    connectivity.push(node);
                }
            }
            finer.add_cells(*child, connectivity);
        }
        let start = |kind: CellKind| finer.numbered_blocks().find(|(_, block)| block.kind == kind).map_or(0, |(first, _)| first as u32);
        let starts: HashMap<CellKind, u32> = finer.kinds().map(|kind| (kind, start(kind))).collect();
        let children_of = |cell: u32| {
            let (division, chosen, first) = chosen_of[cell as usize];
            (&division.templates[chosen], starts[&division.child] + first)
        };
        let pieces = |facet: &Facet| {
            let (template, first) = children_of(facet.cell);
            template.pieces[facet.local as usize].iter().map(move |&(child, local)| Facet { cell: first + child, local })
        };
        let divided = |b: &Boundary| Boundary { facets: b.facets.iter().flat_map(pieces).collect(), ..b.clone() };
        let offspring = |&cell: &u32| {
            let (template, first) = children_of(cell);
            first..first + template.children.len() as u32
        };
        let boundaries = self.boundaries.iter().map(divided).collect();
        let parts = self.parts.iter().map(|(name, cells)| (name.clone(), cells.iter().flat_map(offspring).collect())).collect();
        (finer.boundaries, finer.parts) = (boundaries, parts);
        Ok(finer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{block, rectangle, ring};

    /// Asserts equal measures and boundaries, and that the mesh is conforming: its hull consists of the boundaries.
    fn same(mesh: &Mesh, other: &Mesh) {
        let what = format!("{} as {}", mesh.kind_names(), other.kind_names());
        assert_eq!(other.defects(), [], "{what}");
        assert!((mesh.measure() - other.measure()).abs() < 1e-12 * mesh.measure(), "{what}");
        let mut named: Vec<Facet> = Vec::new();
        for (boundary, divided) in mesh.boundaries.iter().zip(&other.boundaries) {
            let (before, after) = (mesh.boundary_measure(boundary), other.boundary_measure(divided));
            // The area of a warped facet is no polynomial integral, so that meshes with different quadrature points agree less accurately.
            let is_alike = mesh.only_kind() == other.only_kind() && mesh.blocks.iter().all(|block| !block.kind.shape().has_triangles());
            let allowed = if mesh.dimension() == 2 || is_alike { 1e-12 } else { 1e-8 };
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
            // Warped faces, so that the choice of their diagonals, which depends on the node numbers, changes the volume.
            point[0] += 0.05 * point[1] * point[2];
        }
        let last = solid.points.len() as u32 - 1;
        let shuffled = |node: u32| (node * 7 + 3) % (last + 1);
        let mut other = solid.clone();
        other.renumber(shuffled);
        for (node, point) in solid.points.iter().enumerate() {
            other.points[shuffled(node as u32) as usize] = *point;
        }
        for solid in [solid, other] {
            for kind in [Hex20, Hex27] {
                let mesh = solid.with_cells(kind).unwrap();
                same(&solid, &mesh);
                same(&mesh, &mesh.refine().unwrap());
            }
            for kind in [Wedge6, Wedge15] {
                let mesh = solid.with_cells(kind).unwrap();
                same(&solid, &mesh);
                same(&mesh, &mesh.refine().unwrap());
            }
            for kind in [Pyr5, Pyr13] {
                same(&solid, &solid.with_cells(kind).unwrap());
            }
            let tets = solid.with_cells(Tet4).unwrap();
            assert_eq!(tets.cell_count(), 6 * 12);
            // Warped facets of hexahedra are divided into plane triangles.
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
