//! Local refinement of triangles, without hanging nodes.
//!
//! A selected cell is divided at the midpoints of its edges into four similar ones. Cells with a hanging node are bisected across their
//! longest edge until none is left (M.-C. Rivara, Int. J. Numer. Meth. Engng. 20, 1984). Repeated bisection of a triangle across its
//! longest edge gives finitely many shapes, without an angle below half the smallest one of the first triangle (I. Rosenberg, F. Stenger,
//! Math. Comp. 29, 1975); division into four gives no new shape. Refinement may therefore be repeated without limit. No state besides the
//! mesh is kept. Quadrilaterals and cells in space are not supported.

use std::collections::{HashMap, HashSet};

use super::division::{halves, mean};
use super::grid::{UNSTRUCTURED, room_for};
use super::{Boundary, Facet, Mesh, MeshError, SelectionError};
use crate::elements::{CellKind, CellShape};

/// A place on a reference cell.
type ReferencePoint = [f64; 3];

/// The two ends of an edge, the smaller number first.
type Edge = [u32; 2];

fn edge(a: u32, b: u32) -> Edge {
    [a.min(b), a.max(b)]
}

/// Part of a cell of the old mesh: its corners, and their positions on the reference cell of the old cell.
#[derive(Clone, Copy)]
struct ChildCell {
    cell: u32,
    nodes: [u32; 3],
    places: [ReferencePoint; 3],
}

/// Mesh during refinement.
struct Refinement<'a> {
    old: &'a Mesh,
    points: Vec<[f64; 3]>,
    /// Nodes at the midpoints of divided edges and, for second-order cells, of other edges.
    middles: HashMap<Edge, u32>,
    /// Divided edges.
    cut: HashSet<Edge>,
}

impl Refinement<'_> {
    /// Node at the midpoint of an edge of a child cell, from corner `k` to the next one.
    fn middle(&mut self, piece: &ChildCell, k: usize) -> u32 {
        let (from, to) = (k, (k + 1) % 3);
        let (old, points) = (self.old, &mut self.points);
        *self.middles.entry(edge(piece.nodes[from], piece.nodes[to])).or_insert_with(|| {
            let weights = (old.kind_of(piece.cell as usize).row().shape)(mean(piece.places[from], piece.places[to]));
            let nodes = old.cell(piece.cell as usize);
            let sum = |i: usize| nodes.iter().zip(&weights).map(|(&node, weight)| weight * old.points[node as usize][i]).sum();
            points.push([sum(0), sum(1), sum(2)]);
            points.len() as u32 - 1
        })
    }

    /// Division of a child cell into four.
    fn quartered(&mut self, piece: &ChildCell) -> Vec<ChildCell> {
        let middles = [0, 1, 2].map(|k| self.middle(piece, k));
        (0..3).for_each(|k| {
            self.cut.insert(edge(piece.nodes[k], piece.nodes[(k + 1) % 3]));
        });
        let children = halves(CellKind::Tri3);
        // child k keeps corner k, the last one has midpoints only
        let nodes = (0..3).map(|k| {
            let toward = |other: usize| if other == k { piece.nodes[k] } else { middles[if (k + 1) % 3 == other { k } else { other }] };
            [toward(0), toward(1), toward(2)]
        });
        let nodes = nodes.chain(std::iter::once([middles[1], middles[2], middles[0]]));
        let children = children.iter().zip(nodes);
        children.map(|(places, nodes)| ChildCell { nodes, places: [places[0], places[1], places[2]], ..*piece }).collect()
    }

    /// Index of the longest edge. Ties are decided by node numbers, so that both neighbors choose the same edge.
    fn longest(&self, piece: &ChildCell) -> usize {
        let length = |k: usize| {
            let ends = edge(piece.nodes[k], piece.nodes[(k + 1) % 3]);
            let [a, b] = ends.map(|node| self.points[node as usize]);
            ((b[0] - a[0]).hypot(b[1] - a[1]), ends)
        };
        let longer = |a: &usize, b: &usize| {
            let (a, b) = (length(*a), length(*b));
            a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
        };
        (0..3).max_by(longer).unwrap_or_default()
    }

    /// Bisects a child cell across its longest edge, and the halves likewise, until no edge has a hanging node; appends the resulting cells
    /// to `whole`.
    fn close(&mut self, piece: ChildCell, whole: &mut Vec<ChildCell>) {
        let is_cut = (0..3).any(|k| self.cut.contains(&edge(piece.nodes[k], piece.nodes[(k + 1) % 3])));
        if !is_cut {
            whole.push(piece);
            return;
        }
        let first = self.longest(&piece);
        let middle = self.middle(&piece, first);
        let [a, b] = [first, (first + 1) % 3];
        self.cut.insert(edge(piece.nodes[a], piece.nodes[b]));
        let place = mean(piece.places[a], piece.places[b]);
        for gone in [b, a] {
            let mut half = piece;
            (half.nodes[gone], half.places[gone]) = (middle, place);
            self.close(half, whole);
        }
    }

    /// Child cells of every cell; chosen cells are divided into four.
    fn pieces(&mut self, is_chosen: &[bool]) -> Result<Vec<ChildCell>, MeshError> {
        let corners = CellKind::Tri3.row().node_places;
        let mut pieces: Vec<ChildCell> = Vec::new();
        for (cell, nodes) in self.old.cells().enumerate() {
            let whole =
                ChildCell { cell: cell as u32, nodes: [nodes[0], nodes[1], nodes[2]], places: [corners[0], corners[1], corners[2]] };
            if is_chosen[cell] { pieces.extend(self.quartered(&whole)) } else { pieces.push(whole) }
        }
        loop {
            let edges = self.cut.len();
            let mut next = Vec::with_capacity(pieces.len());
            for piece in pieces {
                self.close(piece, &mut next);
            }
            pieces = next;
            room_for(pieces.len(), UNSTRUCTURED)?;
            // Repeat until no new edge is divided, since an edge divided in one cell must be divided in its neighbor.
            if self.cut.len() == edges {
                return Ok(pieces);
            }
        }
    }

    /// Refined mesh with the given children of the divided cells.
    fn mesh(mut self, pieces: &[ChildCell]) -> Mesh {
        let kind = if self.old.is_quadratic() { CellKind::Tri6 } else { CellKind::Tri3 };
        let mut connectivity = Vec::with_capacity(pieces.len() * kind.nodes());
        for piece in pieces {
            connectivity.extend(piece.nodes);
            if kind.is_quadratic() {
                connectivity.extend([0, 1, 2].map(|k| self.middle(piece, k)));
            }
        }
        let mut firsts: Vec<u32> = vec![0; self.old.cell_count() + 1];
        pieces.iter().for_each(|piece| firsts[piece.cell as usize + 1] += 1);
        (0..self.old.cell_count()).for_each(|cell| firsts[cell + 1] += firsts[cell]);
        let offspring = |cell: u32| firsts[cell as usize]..firsts[cell as usize + 1];
        let on_facet = |facet: &Facet| {
            // the corner opposite to a facet has zero weight at its points
            let [from, across] = [facet.local as usize, (facet.local as usize + 2) % 3];
            let share = |place: ReferencePoint, corner: usize| (CellKind::Tri3.row().shape)(place)[corner];
            let mut found: Vec<(f64, Facet)> = Vec::new();
            for cell in offspring(facet.cell) {
                let places = pieces[cell as usize].places;
                for local in 0..3 {
                    let ends = [places[local], places[(local + 1) % 3]];
                    if ends.iter().all(|&place| share(place, across) == 0.0) {
                        found.push((share(ends[0], from), Facet { cell, local: local as u8 }));
                    }
                }
            }
            found.sort_by(|a, b| b.0.total_cmp(&a.0));
            found.into_iter().map(|(_, facet)| facet)
        };
        let finer = |b: &Boundary| Boundary { facets: b.facets.iter().flat_map(on_facet).collect(), ..b.clone() };
        let boundaries = self.old.boundaries.iter().map(finer).collect();
        let part = |cells: &Vec<u32>| cells.iter().flat_map(|&cell| offspring(cell)).collect();
        let parts = self.old.parts.iter().map(|(name, cells)| (name.clone(), part(cells))).collect();
        Mesh { boundaries, parts, ..Mesh::new(kind, self.points, connectivity) }
    }
}

impl Mesh {
    /// Mesh of triangles in which every chosen cell is divided into four at the midpoints of its edges, and others are bisected so that
    /// there are no hanging nodes; boundaries and parts are kept. As with [`Mesh::refine`] the mesh covers the same set of points, and old
    /// nodes keep their numbers. After any number of refinements, no angle is smaller than half the smallest one of the first mesh.
    ///
    /// `is_chosen` has an entry for each cell.
    ///
    /// # Errors
    /// Cells that are no triangles, more cells than [`CELL_LIMIT`](crate::mesh::CELL_LIMIT).
    pub fn refined_cells(&self, is_chosen: &[bool]) -> Result<Mesh, MeshError> {
        self.refuse_others_than_triangles()?;
        // The number of cells is checked before memory is allocated.
        let cells = self.cell_count() + 3 * is_chosen.iter().filter(|chosen| **chosen).count();
        room_for(cells, UNSTRUCTURED)?;
        let mut middles = HashMap::new();
        if self.is_quadratic() {
            for nodes in self.cells() {
                middles.extend((0..3).map(|k| (edge(nodes[k], nodes[(k + 1) % 3]), nodes[k + 3])));
            }
        }
        let mut refinement = Refinement { old: self, points: self.points.clone(), middles, cut: HashSet::new() };
        let pieces = refinement.pieces(is_chosen)?;
        Ok(refinement.mesh(&pieces))
    }

    fn refuse_others_than_triangles(&self) -> Result<(), MeshError> {
        let other = self.kinds().find(|kind| kind.shape() != CellShape::Triangle);
        other.map_or(Ok(()), |kind| Err(MeshError::NotLocally { kind: kind.name() }))
    }

    /// [`Mesh::refined_cells`] for the cells whose centers satisfy `condition`.
    ///
    /// # Errors
    /// Errors of [`Mesh::refined_cells`]; an error of the condition.
    pub fn refined_where<E>(&self, mut condition: impl FnMut(&[f64]) -> Result<bool, E>) -> Result<Mesh, SelectionError<E>> {
        self.refuse_others_than_triangles()?;
        let chosen = (0..self.cell_count()).map(|cell| condition(&self.cell_center(cell)));
        let chosen: Vec<bool> = chosen.collect::<Result<_, E>>().map_err(SelectionError::Condition)?;
        Ok(self.refined_cells(&chosen)?)
    }

    /// [`Mesh::refined_cells`] of the cells that have a node of a boundary.
    ///
    /// # Errors
    /// Errors of [`Mesh::refined_cells`].
    pub fn refined_along(&self, boundary: &Boundary) -> Result<Mesh, MeshError> {
        let nodes: HashSet<u32> = self.boundary_nodes(boundary).into_iter().collect();
        let chosen: Vec<bool> = self.cells().map(|cell| cell.iter().any(|node| nodes.contains(node))).collect();
        self.refined_cells(&chosen)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::mesh::{polygon_of, rectangle, ring};

    /// Smallest angle of the corner triangles, in degrees.
    fn smallest_angle(mesh: &Mesh) -> f64 {
        let angle = |cell: &[u32], k: usize| {
            let [a, b, c] = [0, 1, 2].map(|i| mesh.points[cell[(k + i) % 3] as usize]);
            let (u, v) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
            (u[0] * v[1] - u[1] * v[0]).atan2(u[0] * v[0] + u[1] * v[1]).to_degrees()
        };
        mesh.cells().flat_map(|cell| [0, 1, 2].map(|k| angle(cell, k))).fold(f64::INFINITY, f64::min)
    }

    /// Asserts equal areas and boundaries, and that the mesh is conforming: its hull consists of the boundaries.
    fn is_same(mesh: &Mesh, finer: &Mesh) {
        assert_eq!(finer.defects(), []);
        assert!((mesh.measure() - finer.measure()).abs() < 1e-12 * mesh.measure());
        let mut named: Vec<Facet> = Vec::new();
        for (boundary, divided) in mesh.boundaries.iter().zip(&finer.boundaries) {
            let (before, after) = (mesh.boundary_measure(boundary), finer.boundary_measure(divided));
            assert!((before - after).abs() < 1e-5 * before, "{} {before} {after}", boundary.name);
            named.extend(&divided.facets);
            let ends: Vec<Vec<u32>> = divided.facets.iter().map(|&facet| finer.facet_nodes(facet).collect()).collect();
            assert!(ends.windows(2).all(|pair| pair[0][1] == pair[1][0]), "traversed with the body on the left");
        }
        named.sort_unstable();
        assert_eq!(finer.hull(), named);
        let area = |mesh: &Mesh, part: usize| {
            let mut mesh = mesh.clone();
            let cells = mesh.parts[part].1.clone();
            mesh.blocks[0].connectivity = cells.iter().flat_map(|&cell| mesh.cell(cell as usize).to_vec()).collect();
            mesh.measure()
        };
        for part in 0..mesh.parts.len() {
            assert!((area(mesh, part) - area(finer, part)).abs() < 1e-12, "{}", mesh.parts[part].0);
        }
    }

    fn circular(kind: CellKind) -> Mesh {
        let round = crate::mesh::Round::About([0.0, 0.0]);
        let mut mesh = ring(0.5, 1.0, [2, 12], [0.0, 0.0], 0.1).unwrap().with_round_cells(CellKind::Quad4, round).unwrap();
        mesh.parts = vec![("some".into(), vec![0, 3, 7]), ("all".into(), (0..mesh.cell_count() as u32).collect())];
        let mesh = mesh.with_cells(CellKind::Tri3).unwrap();
        mesh.with_cells(kind)
            .unwrap()
            .curved(|_, [a, b]| {
                let radii = [a, b].map(|p: [f64; 3]| p[0].hypot(p[1]));
                let middle = [0, 1].map(|i| 0.5 * (a[i] + b[i]));
                let scale = radii[0] / middle[0].hypot(middle[1]);
                ((radii[0] - radii[1]).abs() < 1e-9).then(|| [scale * middle[0], scale * middle[1], 0.0])
            })
            .unwrap()
    }

    #[test]
    fn all_cells_are_refined_as_by_the_uniform_one() {
        for kind in [CellKind::Tri3, CellKind::Tri6] {
            let mesh = circular(kind);
            let (finer, even) = (mesh.refined_where(|_| Ok::<bool, MeshError>(true)).unwrap(), mesh.refine().unwrap());
            is_same(&mesh, &finer);
            assert_eq!((finer.cell_count(), finer.points.len()), (even.cell_count(), even.points.len()));
            let mut places = [finer.points.clone(), even.points.clone()];
            places.iter_mut().for_each(|points| points.sort_by(|a, b| a.partial_cmp(b).unwrap()));
            let off = places[0].iter().zip(&places[1]).flat_map(|(a, b)| [0, 1].map(|i| (a[i] - b[i]).abs())).fold(0.0, f64::max);
            assert!(off < 1e-9, "{off}");
            assert_eq!(mesh.refined_where(|_| Ok::<bool, MeshError>(false)).unwrap().blocks, mesh.blocks);
        }
    }

    #[test]
    fn angles_stay_above_half_the_smallest_however_often_a_corner_is_refined() {
        let corners = [[0.0, 0.0], [2.0, 0.1], [1.7, 1.1], [0.3, 0.8]];
        let mut mesh = polygon_of(CellKind::Tri3, &corners, &[], 0.5, &[]).unwrap();
        let (coarse, angle) = (mesh.clone(), smallest_angle(&mesh));
        for level in 0..25 {
            mesh = mesh.refined_where(|at| Ok::<bool, MeshError>(at[0].hypot(at[1]) < 0.5f64.powi(level))).unwrap();
            assert!(smallest_angle(&mesh) > 0.5 * angle, "{level}: {} of {angle}", smallest_angle(&mesh));
        }
        is_same(&coarse, &mesh);
        // Repeated refinement reaches cells of size 2^-25 in a body of size 2 with few cells.
        assert!(mesh.quality().shortest_edge < 1e-7 && mesh.cell_count() < 5000, "{} {}", mesh.quality(), mesh.cell_count());
    }

    #[test]
    fn a_boundary_is_refined_along_and_quadrilaterals_are_refused() {
        let mesh = rectangle([2.0, 1.0], [4, 2], [0.0; 2]).unwrap();
        let refused = mesh.refined_along(mesh.boundary("top").unwrap()).unwrap_err();
        assert!(matches!(refused, MeshError::NotLocally { kind: "quad4" }) && refused.hint().contains("tri3"));
        let mut mesh = mesh.with_cells(CellKind::Tri6).unwrap();
        let coarse = mesh.clone();
        for _ in 0..3 {
            mesh = mesh.refined_along(mesh.boundary("top").unwrap()).unwrap();
        }
        is_same(&coarse, &mesh);
        assert_eq!((mesh.boundary("top").unwrap().facets.len(), mesh.boundary("bottom").unwrap().facets.len()), (32, 4));
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn what_is_refined_at_random_places_stays_whole(
            is_quadratic: bool,
            circles in prop::collection::vec((-1.0f64..1.0, -1.0f64..1.0, 0.02f64..0.5), 1..7),
        ) {
            let coarse = circular(if is_quadratic { CellKind::Tri6 } else { CellKind::Tri3 });
            let mut mesh = coarse.clone();
            for (x, y, radius) in circles {
                mesh = mesh.refined_where(|at| Ok::<bool, MeshError>((at[0] - x).hypot(at[1] - y) < radius)).unwrap();
            }
            is_same(&coarse, &mesh);
            // angles of the corner triangles: children on straight edges have the angles of the parent
            if !is_quadratic {
                prop_assert!(smallest_angle(&mesh) >= 0.5 * smallest_angle(&coarse) - 1e-9);
            }
        }
    }
}
