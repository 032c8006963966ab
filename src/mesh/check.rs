//! Validity of a mesh and quality of its cells.
//!
//! Validity: a cell is refused if its Jacobian determinant is not positive at a quadrature point, because its integrals are then
//! meaningless; cells are never reoriented silently. Quality: the scaled Jacobian (P. Knupp, 2003; C. Stimpson et al., The Verdict Library
//! Reference Manual, 2007, sections 4.13 and 6.12), the smallest over the corners of a cell of the determinant of the edge vectors divided
//! by their lengths: 1 for right angles, 0 for an angle of 180 degrees, negative beyond. Triangles and tetrahedra are relative to the
//! equilateral cell, wedges to the right prism over an equilateral triangle; for pyramids the corners of the base are sampled. Unlike in
//! Verdict, the center of a hexahedron is not sampled.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::error::rounded;
use super::{Block, Boundary, Facet, Mesh, MeshError};
use crate::elements::{CellKind, CellShape, edge_points, edge_shapes};
use crate::math::tolerances::DEGENERATE_CELL;

/// Quality measures of the cells of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Quality {
    /// Number of cells.
    pub cells: usize,
    /// Number of nodes.
    pub nodes: usize,
    /// Area or volume by quadrature `[length^D]`.
    pub measure: f64,
    /// Smallest scaled Jacobian of all cells; a cell with an angle above 180 degrees has a negative one.
    pub smallest_scaled_jacobian: f64,
    /// Largest scaled Jacobian of all cells, at most 1.
    pub largest_scaled_jacobian: f64,
    /// Index of the cell with the smallest scaled Jacobian.
    pub worst_cell: usize,
    /// Mean of the nodes of `worst_cell`, one coordinate per dimension `[length]`.
    pub worst_place: Vec<f64>,
    /// Largest ratio of the longest to the shortest edge of a cell.
    pub aspect_ratio: f64,
    /// Shortest edge of all cells `[length]`; in the plane, edges are facets.
    pub shortest_edge: f64,
}

impl std::fmt::Display for Quality {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Quality { cells, nodes, .. } = self;
        let extent = if self.worst_place.len() == 3 { "volume" } else { "area" };
        let [measure, smallest, largest, ratio, edge] =
            [self.measure, self.smallest_scaled_jacobian, self.largest_scaled_jacobian, self.aspect_ratio, self.shortest_edge].map(rounded);
        write!(
            out,
            "{cells} cells, {nodes} nodes, {extent} {measure}, scaled Jacobian {smallest} to {largest}, aspect ratio up to {ratio}, \
             shortest edge {edge}"
        )
    }
}

/// Gradients of the shape functions, `[node][direction]`, with a third component of 0 in the plane.
type Gradients = Vec<[f64; 3]>;

/// Sampling points of the Jacobian of a cell kind.
struct Samples {
    quadrature: Vec<(f64, Gradients)>,
    corners: Vec<Gradients>,
}

impl Samples {
    fn new(kind: CellKind) -> Samples {
        let row = kind.row();
        Samples {
            quadrature: at_points(kind, &(row.quadrature)()),
            corners: row.node_places[..row.cell_shape.corners()].iter().map(|&place| (row.gradients)(place)).collect(),
        }
    }
}

/// Weights of points, and gradients of the shape functions there.
fn at_points(kind: CellKind, points: &[([f64; 3], f64)]) -> Vec<(f64, Gradients)> {
    points.iter().map(|&(xi, weight)| (weight, (kind.row().gradients)(xi))).collect()
}

/// Points of a quadrature that is exact for the volume of curved cells, also in axisymmetric bodies: those of the stiffness, except for
/// second-order cells with triangular faces.
fn exact_points(kind: CellKind) -> Vec<([f64; 3], f64)> {
    if kind.is_quadratic() && kind.shape().has_triangles() { kind.shape().mass_points() } else { (kind.row().quadrature)() }
}

/// Derivatives of the position in the reference directions; the third is the unit vector `e_z` in the plane.
fn tangents(points: &[[f64; 3]], gradients: &Gradients, dimension: usize) -> [[f64; 3]; 3] {
    let mut tangents = [[0.0; 3], [0.0; 3], [0.0, 0.0, if dimension == 2 { 1.0 } else { 0.0 }]];
    for (point, gradient) in points.iter().zip(gradients) {
        for (tangent, &slope) in tangents.iter_mut().zip(gradient).take(dimension) {
            for (component, &x) in tangent.iter_mut().zip(point) {
                *component += slope * x;
            }
        }
    }
    tangents
}

pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn norm(a: [f64; 3]) -> f64 {
    a[0].hypot(a[1]).hypot(a[2])
}

pub(super) fn determinant([a, b, c]: [[f64; 3]; 3]) -> f64 {
    dot(cross(a, b), c)
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    norm([0, 1, 2].map(|i| b[i] - a[i]))
}

pub(super) fn between(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| b[i] - a[i])
}

/// Length of a quadratic edge by three Gauss points.
fn edge_length(from: [f64; 3], to: [f64; 3], middle: [f64; 3]) -> f64 {
    let slope = |s: f64| {
        let (_, [a, b, c]) = edge_shapes(3, s);
        norm([0, 1, 2].map(|i| a * from[i] + b * to[i] + c * middle[i]))
    };
    edge_points().into_iter().map(|(s, weight)| weight * slope(s)).sum()
}

/// Smallest scaled Jacobian of a triangle or tetrahedron: the determinant of the edge vectors (equal at all corners) over the largest
/// product of the lengths of edges that meet, relative to the equilateral cell.
fn scaled_simplex(corners: &[[f64; 3]]) -> f64 {
    let edges = |k: usize| (0..corners.len()).filter(move |&other| other != k).map(move |other| between(corners[k], corners[other]));
    let largest = (0..corners.len()).map(|k| edges(k).map(norm).product::<f64>()).fold(0.0, f64::max);
    let first: Vec<[f64; 3]> = edges(0).collect();
    let (size, equilateral) = match first[..] {
        [a, b] => (determinant([a, b, [0.0, 0.0, 1.0]]), 0.75f64.sqrt()),
        [a, b, c] => (determinant([a, b, c]), 0.5f64.sqrt()),
        _ => (0.0, 1.0),
    };
    if largest > 0.0 { size / (largest * equilateral) } else { 0.0 }
}

/// Determinant of the tangents at a corner, divided by their lengths.
fn scaled_at(tangents: [[f64; 3]; 3]) -> f64 {
    let lengths: f64 = tangents.iter().map(|&t| norm(t)).product();
    // An edge of zero length has no angle; its quality is 0.
    if lengths > 0.0 { determinant(tangents) / lengths } else { 0.0 }
}

/// Smallest scaled Jacobian at the corners of a wedge, relative to the right prism over an equilateral triangle.
fn scaled_wedge(points: &[[f64; 3]]) -> f64 {
    let at = |k: usize| {
        let (base, [next, last]) = (k / 3 * 3, [(k + 1) % 3, (k + 2) % 3]);
        let [a, b] = if base == 0 { [next, last] } else { [last, next] };
        scaled_at([base + a, base + b, (k + 3) % 6].map(|other| between(points[k], points[other]))) / 0.75f64.sqrt()
    };
    (0..6).map(at).fold(f64::INFINITY, f64::min)
}

impl Mesh {
    /// Area or volume by quadrature, exact for curved cells `[length^D]`.
    pub fn measure(&self) -> f64 {
        let mut points = Vec::new();
        let mut of_block = |block: &Block| -> f64 {
            let samples = Samples { quadrature: at_points(block.kind, &exact_points(block.kind)), corners: Vec::new() };
            let of_cell = |nodes: &[u32]| {
                self.places_into(nodes, &mut points);
                self.weighted_determinants(&samples, &points).map(|(weight, determinant)| weight * determinant).sum::<f64>()
            };
            block.cells().map(of_cell).sum()
        };
        self.blocks.iter().map(&mut of_block).sum()
    }

    /// Volume of the body of revolution about the second axis with this mesh as its section, by quadrature, exact for curved cells
    /// `[length^3]`.
    pub fn volume_of_revolution(&self) -> f64 {
        let mut places = Vec::new();
        let mut of_block = |block: &Block| -> f64 {
            let (points, row) = (exact_points(block.kind), block.kind.row());
            let samples = Samples { quadrature: at_points(block.kind, &points), corners: Vec::new() };
            let shapes: Vec<Vec<f64>> = points.into_iter().map(|(xi, _)| (row.shape)(xi)).collect();
            let of_cell = |nodes: &[u32]| {
                self.places_into(nodes, &mut places);
                let radius = |shape: &Vec<f64>| shape.iter().zip(&places).map(|(share, point)| share * point[0]).sum::<f64>();
                let at_points = self.weighted_determinants(&samples, &places).zip(&shapes);
                at_points.map(|((weight, determinant), shape)| weight * determinant * TAU * radius(shape)).sum::<f64>()
            };
            block.cells().map(of_cell).sum()
        };
        self.blocks.iter().map(&mut of_block).sum()
    }

    /// Length or area of a boundary by quadrature `[length^(D-1)]`.
    pub fn boundary_measure(&self, boundary: &Boundary) -> f64 {
        let mut samples: BTreeMap<usize, Samples> = BTreeMap::new();
        let mut of_facet = |&facet: &Facet| {
            let nodes = self.facet_nodes(facet).count();
            self.facet_measure(facet, samples.entry(nodes).or_insert_with(|| Samples::new(CellKind::of_face(nodes))))
        };
        boundary.facets.iter().map(&mut of_facet).sum()
    }

    fn facet_measure(&self, facet: Facet, samples: &Samples) -> f64 {
        let points: Vec<[f64; 3]> = self.facet_nodes(facet).map(|node| self.points[node as usize]).collect();
        match points[..] {
            [from, to] => distance(from, to),
            [a, b, c] if self.dimension() == 3 => 0.5 * norm(cross(between(a, b), between(a, c))),
            [from, to, middle] => edge_length(from, to, middle),
            _ => samples
                .quadrature
                .iter()
                .map(|(weight, gradients)| {
                    let along = |i: usize| {
                        let sum = |c: usize| points.iter().zip(gradients).map(|(point, gradient)| gradient[i] * point[c]).sum();
                        [sum(0), sum(1), sum(2)]
                    };
                    weight * norm(cross(along(0), along(1)))
                })
                .sum(),
        }
    }

    /// Returns the quality measures of the mesh; without cells, all ratios are `NaN`.
    pub fn quality(&self) -> Quality {
        let mut quality = Quality {
            cells: self.cell_count(),
            nodes: self.points.len(),
            measure: 0.0,
            smallest_scaled_jacobian: f64::NAN,
            largest_scaled_jacobian: f64::NAN,
            worst_cell: 0,
            worst_place: vec![f64::NAN; self.dimension()],
            aspect_ratio: f64::NAN,
            shortest_edge: f64::NAN,
        };
        let mut points = Vec::new();
        let mut samples = (CellKind::Quad4, Samples::new(CellKind::Quad4));
        for (cell, (kind, nodes)) in self.cells_with_kinds().enumerate() {
            if samples.0 != kind {
                samples = (kind, Samples::new(kind));
            }
            let (samples, edges) = (&samples.1, kind.shape().edges());
            self.places_into(nodes, &mut points);
            quality.measure += self.weighted_determinants(samples, &points).map(|(weight, determinant)| weight * determinant).sum::<f64>();
            let scaled = samples.corners.iter().map(|gradients| scaled_at(tangents(&points, gradients, self.dimension())));
            let scaled = match kind.shape() {
                CellShape::Triangle | CellShape::Tetrahedron => scaled_simplex(&points[..samples.corners.len()]),
                CellShape::Wedge => scaled_wedge(&points),
                // Only the base corners of a pyramid count; at the apex more than three edges meet.
                CellShape::Pyramid => scaled.take(4).fold(f64::INFINITY, f64::min),
                CellShape::Quadrilateral | CellShape::Hexahedron => scaled.fold(f64::INFINITY, f64::min),
            };
            if quality.smallest_scaled_jacobian.is_nan() || scaled < quality.smallest_scaled_jacobian {
                quality.smallest_scaled_jacobian = scaled;
                quality.worst_cell = cell;
            }
            quality.largest_scaled_jacobian = quality.largest_scaled_jacobian.max(scaled);
            let lengths = edges.iter().map(|&[a, b]| distance(points[a], points[b]));
            let (shortest, longest) = lengths.fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), l| (low.min(l), high.max(l)));
            quality.aspect_ratio = quality.aspect_ratio.max(longest / shortest);
            quality.shortest_edge = quality.shortest_edge.min(shortest);
        }
        if quality.cells > 0 {
            quality.worst_place = self.cell_center(quality.worst_cell);
        }
        quality
    }

    /// Defects that prevent computations with the mesh: broken references, cells with a repeated node, inverted or degenerate cells, facets
    /// of more than two cells, nodes without cells. Empty for a valid mesh.
    ///
    /// Each inverted cell is listed with the number of all such cells. Broken references end the check.
    pub fn defects(&self) -> Vec<MeshError> {
        let broken = self.broken_references();
        if !broken.is_empty() {
            return broken;
        }
        let mut defects = self.coordinate_defects();
        defects.extend(self.cell_defects());
        for sides in self.sorted_facets().chunk_by(|a, b| a.0 == b.0).filter(|sides| sides.len() > 2) {
            defects.push(MeshError::CrowdedFacet { at: None, cell: sides[0].1.cell.into(), sharing: sides.len() });
        }
        defects.extend(self.unmatched());
        let mut used = vec![false; self.points.len()];
        self.connectivity().for_each(|node| used[node as usize] = true);
        if let Some(first) = used.iter().position(|used| !used) {
            let count = used.iter().filter(|used| !**used).count();
            defects.push(MeshError::UnusedNodes { count, node: first as u64 });
        }
        defects
    }

    /// First defect, if any.
    ///
    /// # Errors
    /// As listed by [`Mesh::defects`].
    pub fn check(&self) -> Result<(), MeshError> {
        self.defects().into_iter().next().map_or(Ok(()), Err)
    }

    /// The mesh if all coordinates are finite and all cells have a positive volume, which generators and transforms can violate.
    pub(super) fn checked(self) -> Result<Mesh, MeshError> {
        match self.coordinate_defects().into_iter().chain(self.cell_defects()).next() {
            Some(defect) => Err(defect),
            None => Ok(self),
        }
    }

    /// References to missing nodes, cells and facets.
    fn broken_references(&self) -> Vec<MeshError> {
        let mut broken = Vec::new();
        let mut refer = |what, index, target: usize, count: usize| {
            if target >= count {
                broken.push(MeshError::BrokenReference { what, index, target, count });
            }
        };
        let cells = self.cell_count();
        for (first, Block { kind, connectivity }) in self.numbered_blocks() {
            for (position, &node) in connectivity.iter().enumerate() {
                refer("cell", first + position / kind.nodes(), node as usize, self.points.len());
            }
            if !connectivity.len().is_multiple_of(kind.nodes()) {
                refer("cell", cells, connectivity.len(), connectivity.len());
            }
        }
        for (index, boundary) in self.boundaries.iter().enumerate() {
            for facet in &boundary.facets {
                refer("boundary", index, facet.cell as usize, cells);
                if (facet.cell as usize) < cells {
                    refer("boundary", index, facet.local as usize, self.kind_of(facet.cell as usize).facets().len());
                }
            }
        }
        for (index, (_, members)) in self.parts.iter().enumerate() {
            members.iter().for_each(|&cell| refer("part", index, cell as usize, cells));
        }
        broken
    }

    /// Coordinates that are not finite.
    fn coordinate_defects(&self) -> Vec<MeshError> {
        let infinite = self.points.iter().flatten().filter(|x| !x.is_finite());
        infinite.map(|&value| MeshError::NotFinite { what: "a coordinate of a node", value }).collect()
    }

    /// Cells with a repeated node, inverted cells and degenerate cells, with their indices.
    pub(super) fn cell_defects(&self) -> Vec<MeshError> {
        let mut defects = Vec::new();
        let mut inside_out = 0;
        let mut points = Vec::new();
        let mut samples = (CellKind::Quad4, Samples::new(CellKind::Quad4));
        for (index, (kind, nodes)) in self.cells_with_kinds().enumerate() {
            if samples.0 != kind {
                samples = (kind, Samples::new(kind));
            }
            let (samples, edges) = (&samples.1, kind.shape().edges());
            if let Some(node) = repeated(nodes) {
                defects.push(MeshError::RepeatedNode { at: None, cell: index as u64, node: node.into() });
                continue;
            }
            self.places_into(nodes, &mut points);
            let determinants = self.weighted_determinants(samples, &points).map(|(_, determinant)| determinant);
            let smallest = determinants.fold(f64::INFINITY, f64::min);
            let longest = edges.iter().map(|&[a, b]| distance(points[a], points[b])).fold(0.0, f64::max);
            let least = DEGENERATE_CELL * longest.powi(self.dimension() as i32);
            if smallest < -least {
                inside_out += 1;
                defects.push(MeshError::InvertedCell {
                    at: None,
                    cell: index as u64,
                    center: self.cell_center(index),
                    determinant: smallest,
                    inverted: 0,
                    cells: self.cell_count(),
                });
            } else if smallest <= least {
                let center = self.cell_center(index);
                defects.push(MeshError::DegenerateCell { at: None, cell: index as u64, center, determinant: smallest });
            }
        }
        for defect in &mut defects {
            if let MeshError::InvertedCell { inverted, .. } = defect {
                *inverted = inside_out;
            }
        }
        defects
    }

    /// Mean of the nodes of a cell, one coordinate per dimension `[length]`.
    pub fn cell_center(&self, cell: usize) -> Vec<f64> {
        let nodes = self.cell(cell);
        let mean = |i: usize| nodes.iter().map(|&node| self.points[node as usize][i]).sum::<f64>() / nodes.len() as f64;
        (0..self.dimension()).map(mean).collect()
    }

    fn places_into(&self, nodes: &[u32], points: &mut Vec<[f64; 3]>) {
        points.clear();
        points.extend(nodes.iter().map(|&node| self.points[node as usize]));
    }

    /// Weight and Jacobian determinant at each quadrature point.
    fn weighted_determinants<'a>(&self, samples: &'a Samples, points: &'a [[f64; 3]]) -> impl Iterator<Item = (f64, f64)> + 'a {
        let dimension = self.dimension();
        samples.quadrature.iter().map(move |(weight, gradients)| (*weight, determinant(tangents(points, gradients, dimension))))
    }
}

/// A repeated node.
pub(super) fn repeated<T: PartialEq + Copy>(nodes: &[T]) -> Option<T> {
    nodes.iter().enumerate().find(|(i, node)| nodes[..*i].contains(node)).map(|(_, &node)| node)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{block, rectangle, ring};

    fn quad(corners: [[f64; 2]; 4]) -> Mesh {
        Mesh::new(CellKind::Quad4, corners.map(|[x, y]| [x, y, 0.0]).to_vec(), vec![0, 1, 2, 3])
    }

    #[test]
    fn a_parallelogram_has_the_sine_of_its_angle() {
        let angle = 0.4f64;
        let (s, c) = angle.sin_cos();
        let quality = quad([[0.0, 0.0], [2.0, 0.0], [2.0 + c, s], [c, s]]).quality();
        // The tolerance is the round-off of a few operations.
        assert!((quality.smallest_scaled_jacobian - s).abs() < 1e-15);
        assert!((quality.largest_scaled_jacobian - s).abs() < 1e-15);
        assert!((quality.aspect_ratio - 2.0).abs() < 1e-15);
        assert!((quality.shortest_edge - 1.0).abs() < 1e-15);
        assert!((quality.measure - 2.0 * s).abs() < 1e-15);
    }

    #[test]
    fn a_sheared_cube_has_the_determinant_of_its_edges() {
        // Edges (1,0,0), (0,1,0), (1,0,1) at a corner: determinant 1, lengths 1, 1, sqrt 2.
        let mut mesh = block([1.0; 3], [1; 3], [0.0; 3]).unwrap();
        mesh.points.iter_mut().for_each(|p| p[0] += p[2]);
        let quality = mesh.quality();
        assert!((quality.smallest_scaled_jacobian - 0.5f64.sqrt()).abs() < 1e-15);
        assert!((quality.measure - 1.0).abs() < 1e-15);
        assert!((quality.aspect_ratio - 2f64.sqrt()).abs() < 1e-15);
        assert!((quality.shortest_edge - 1.0).abs() < 1e-15);
        assert_eq!(
            quality.to_string(),
            "1 cells, 8 nodes, volume 1, scaled Jacobian 0.707107 to 0.707107, aspect ratio up to 1.41421, shortest edge 1"
        );
    }

    #[test]
    fn the_quality_of_a_mesh_names_its_worst_cell() {
        let mut mesh = rectangle([3.0, 1.0], [3, 1], [0.0; 2]).unwrap();
        mesh.points[7] = [2.7, 0.9, 0.0];
        mesh.points[6] = [2.0, 1.0, 0.0];
        let quality = mesh.quality();
        assert_eq!((quality.worst_cell, quality.cells, quality.nodes), (2, 3, 8));
        assert!((quality.worst_place[0] - (2.0 + 3.0 + 2.7 + 2.0) / 4.0).abs() < 1e-15);
        assert!(quality.largest_scaled_jacobian == 1.0 && quality.smallest_scaled_jacobian < 1.0);
    }

    #[test]
    fn sound_meshes_have_no_defects() {
        assert_eq!(rectangle([1.0, 1.0], [3, 2], [0.0; 2]).unwrap().defects(), []);
        assert_eq!(ring(0.5, 1.0, [2, 9], [0.0; 2], 0.0).unwrap().defects(), []);
        assert_eq!(block([1.0, 2.0, 3.0], [2, 2, 2], [0.0; 3]).unwrap().defects(), []);
    }

    #[test]
    fn a_mesh_turned_inside_out_says_so_for_all_cells() {
        let mut mesh = rectangle([2.0, 1.0], [2, 1], [0.0; 2]).unwrap();
        mesh.blocks[0].connectivity = mesh.cells().flat_map(|c| [c[0], c[3], c[2], c[1]]).collect();
        let defects = mesh.defects();
        assert_eq!(defects.len(), 2);
        assert_eq!(defects[0].to_string(), "cell 0 at (0.5, 0.5) is inside out: its Jacobian determinant is -0.25 (2 of 2 cells are)");
        assert!(defects[0].hint().starts_with("mend the mesh there"));
        let mut solid = block([1.0; 3], [1; 3], [0.0; 3]).unwrap();
        solid.blocks[0].connectivity.rotate_left(4);
        assert!(matches!(solid.check(), Err(MeshError::InvertedCell { inverted: 1, .. })));
    }

    #[test]
    fn one_bad_cell_is_found_where_it_is() {
        // One corner of the middle cell is moved beyond the opposite corner.
        let mut mesh = rectangle([3.0, 3.0], [3, 3], [0.0; 2]).unwrap();
        mesh.points[5] = [2.4, 2.4, 0.0];
        let error = mesh.check().unwrap_err();
        assert!(matches!(error, MeshError::InvertedCell { inverted, cells: 9, .. } if inverted < 9), "{error}");
        assert!(error.hint().starts_with("mend the mesh there"));
    }

    #[test]
    fn a_flat_cell_and_a_triangle_are_told_apart() {
        let flat = quad([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]);
        assert_eq!(flat.check().unwrap_err().to_string(), "cell 0 at (1.5, 0) has no area: its Jacobian determinant is 0");
        // Quadrilateral with an angle of 180 degrees, which is valid but of quality 0.
        let triangle = quad([[0.0, 0.0], [1.0, 0.0], [0.5, 0.5], [0.0, 1.0]]);
        assert_eq!(triangle.defects(), []);
        assert_eq!(triangle.quality().smallest_scaled_jacobian, 0.0);
        let mut collapsed = quad([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 1.0]]);
        collapsed.points.truncate(3);
        collapsed.blocks[0].connectivity = vec![0, 1, 2, 2];
        assert_eq!(collapsed.check().unwrap_err().to_string(), "cell 0 names node 2 twice");
    }

    #[test]
    fn overlapping_cells_unused_nodes_and_broken_references_are_found() {
        let mut mesh = rectangle([2.0, 1.0], [2, 1], [0.0; 2]).unwrap();
        mesh.points.push([0.0, 5.0, 0.0]);
        assert_eq!(mesh.defects(), [MeshError::UnusedNodes { count: 1, node: 6 }]);
        mesh.points.extend([[1.5, 2.0, 0.0], [0.5, 2.0, 0.0]]);
        // A third cell is added on the facet between the two cells.
        mesh.blocks[0].connectivity.extend([4, 1, 7, 8]);
        assert!(mesh.defects().iter().any(|d| matches!(d, MeshError::CrowdedFacet { sharing: 3, cell: 0, .. })));
        mesh.blocks[0].connectivity[2] = 99;
        assert_eq!(mesh.check().unwrap_err().to_string(), "cell 0 refers to 99, but there are only 9");
    }

    #[test]
    fn a_mesh_without_cells_has_no_quality() {
        let mesh = Mesh::new(CellKind::Quad4, Vec::new(), Vec::new());
        let quality = mesh.quality();
        assert!(quality.smallest_scaled_jacobian.is_nan() && quality.shortest_edge.is_nan());
        assert_eq!((quality.cells, quality.measure), (0, 0.0));
    }
}
