//! Triangulation of a region whose rim is given in pieces.
//!
//! Constrained Delaunay triangulation, refined to angles of at least about 30 degrees and to the requested size (J. Ruppert, J. Algorithms
//! 18, 1995). If the size varies, vertices are first inserted at the circumcenters of triangles that are too large, unless another vertex
//! is near.

use std::collections::HashMap;

use rstar::RTree;
use spade::{AngleLimit, ConstrainedDelaunayTriangulation, Point2, PositionInTriangulation, RefinementParameters, Triangulation};

use super::cell_size::CellSize;
use super::curves::Curve;
use super::grid::{UNSTRUCTURED, room_for};
use super::plane::cross;
use super::{CELL_LIMIT, MeshError};

/// Smallest angle of the refinement, in degrees; above 33 termination is not guaranteed.
const ANGLE: f64 = 28.0;
/// Ratio of area to squared requested edge length above which a triangle is too large; an equilateral one has 0.43.
const LARGE: f64 = 0.6;
/// Smallest distance of a new vertex from other vertices, relative to the requested edge length; nearer vertices are not inserted.
const NEAR: f64 = 0.6;

type Faces = std::collections::HashSet<spade::handles::FixedFaceHandle<spade::handles::InnerTag>>;
type Constrained = ConstrainedDelaunayTriangulation<Point2<f64>>;

/// Outline and holes in pieces of about one edge, with the body on their left.
#[derive(Default)]
pub(super) struct Rim {
    /// Start points of the rim segments `[length]`.
    pub vertices: Vec<[f64; 2]>,
    /// Next vertex of each vertex along its loop.
    pub next: Vec<usize>,
    /// Curve of each segment, and the curve parameters of its ends.
    pub pieces: Vec<(usize, [f64; 2])>,
    /// Curves of the boundary, on which the vertices of the rim lie.
    pub curves: Vec<Curve>,
    /// Names of the boundaries that each curve belongs to.
    pub names: Vec<Vec<String>>,
    /// Name of each curve in messages.
    pub labels: Vec<String>,
    /// First vertex of each closed loop, then the number of vertices.
    pub loops: Vec<usize>,
    /// Prescribed midpoints of segments that lie on no curve.
    pub middles: HashMap<usize, [f64; 2]>,
}

impl Rim {
    /// Adds a curve to the current loop, divided at curve parameters from 0 to 1.
    pub fn add_side(&mut self, curve: Curve, names: Vec<String>, label: String, places: &[f64]) {
        for pair in places.windows(2) {
            self.vertices.push(curve.at(pair[0]));
            self.pieces.push((self.curves.len(), [pair[0], pair[1]]));
            self.next.push(self.vertices.len());
        }
        self.curves.push(curve);
        self.names.push(names);
        self.labels.push(label);
    }

    /// Closes the loop that began with the vertex `first` and orients it counter-clockwise or clockwise.
    pub fn close_loop(&mut self, first: usize, is_counter_clockwise: bool) {
        if let Some(last) = self.next.last_mut() {
            *last = first;
        }
        if self.loops.is_empty() {
            self.loops.push(0);
        }
        self.loops.push(self.vertices.len());
        let own = &self.vertices[first..];
        let area: f64 = (0..own.len()).map(|k| cross(own[k], own[(k + 1) % own.len()])).sum();
        if (area > 0.0) != is_counter_clockwise {
            // The first vertex keeps its position in the list.
            self.vertices[first + 1..].reverse();
            self.pieces[first..].reverse();
            self.pieces[first..].iter_mut().for_each(|(_, ends)| ends.reverse());
        }
    }

    /// Point on the curve of a segment, for a share of the segment from 0 to 1; `None` for a straight segment.
    pub fn between(&self, piece: usize, share: f64) -> Option<[f64; 2]> {
        let (curve, [from, to]) = self.pieces[piece];
        match &self.curves[curve] {
            Curve::Line { .. } => None,
            curve => Some(curve.at(from * (1.0 - share) + to * share)),
        }
    }

    /// Midpoint of a segment on its curve; `None` for a straight segment.
    pub fn middle(&self, piece: usize) -> Option<[f64; 2]> {
        self.middles.get(&piece).copied().or_else(|| self.between(piece, 0.5))
    }

    /// Names of the boundaries of a piece.
    pub fn names(&self, piece: usize) -> &[String] {
        &self.names[self.pieces[piece].0]
    }

    /// Sides of a loop.
    pub fn sides_of_loop(&self, number: usize) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
        (self.loops[number]..self.loops[number + 1]).map(|k| [self.vertices[k], self.vertices[self.next[k]]])
    }

    /// A vertex of a loop.
    pub fn first_of_loop(&self, number: usize) -> [f64; 2] {
        self.vertices[self.loops[number]]
    }

    /// Area inside.
    fn area(&self) -> f64 {
        (0..self.vertices.len()).map(|k| cross(self.vertices[k], self.vertices[self.next[k]])).sum::<f64>() / 2.0
    }

    /// Empty rim with the curves of another rim, and one further curve with the label `front` for the inner ends of layers.
    pub fn of_curves(rim: &Rim, front: String) -> Rim {
        let mut rest = Rim { curves: rim.curves.clone(), names: rim.names.clone(), labels: rim.labels.clone(), ..Rim::default() };
        rest.curves.push(Curve::Line { from: [0.0; 2], to: [0.0; 2] });
        rest.names.push(Vec::new());
        rest.labels.push(front);
        rest
    }

    /// Index of the curve of fronts; the rim must have been made by [`Rim::of_curves`].
    pub fn front(&self) -> usize {
        self.curves.len() - 1
    }

    /// Adds a segment with the start point `from` to the current loop; returns its index.
    pub fn add_piece(&mut self, from: [f64; 2], piece: (usize, [f64; 2]), middle: Option<[f64; 2]>) -> usize {
        let number = self.vertices.len();
        self.vertices.push(from);
        self.next.push(number + 1);
        self.pieces.push(piece);
        self.middles.extend(middle.map(|middle| (number, middle)));
        number
    }

    /// Closes the loop that began with the vertex `first`, with the body on its left.
    pub fn end_loop(&mut self, first: usize) {
        if let Some(last) = self.next.last_mut() {
            *last = first;
        }
    }

    /// Point of a curve at a parameter.
    pub fn curve_at(&self, curve: usize, t: f64) -> [f64; 2] {
        self.curves[curve].at(t)
    }

    /// Point of a curve at a parameter; `None` for a straight curve.
    pub fn on_curve(&self, curve: usize, t: f64) -> Option<[f64; 2]> {
        (!matches!(self.curves[curve], Curve::Line { .. })).then(|| self.curves[curve].at(t))
    }

    /// Error of two pieces with a common point.
    fn crossing(&self, piece: usize, other: usize) -> MeshError {
        let label = |piece: usize| self.labels[self.pieces[piece].0].clone();
        MeshError::CrossingCurves { first: label(other), second: label(piece), near: self.vertices[piece] }
    }
}

/// Vertices, beginning with the rim vertices in the order of the rim, and counter-clockwise triangles.
pub(super) struct Triangles {
    pub vertices: Vec<[f64; 2]>,
    pub triangles: Vec<[usize; 3]>,
}

/// Triangulation with edges of about `factor` times the size.
pub(super) fn triangulate<E: From<MeshError>>(rim: &Rim, size: &mut CellSize<E>, factor: f64) -> Result<Triangles, E> {
    if let CellSize::Even(even) = size {
        // Estimate of the number of cells before memory is allocated.
        counted(rim.area() / (*even * *even))?;
    }
    let mut triangulation = constrained(rim)?;
    let mut parameters = RefinementParameters::<f64>::new()
        .exclude_outer_faces(true)
        .keep_constraint_edges()
        .with_angle_limit(AngleLimit::from_deg(ANGLE))
        .with_max_additional_vertices(CELL_LIMIT);
    match size {
        CellSize::Even(even) => {
            let edge = factor * *even;
            parameters = parameters.with_max_allowed_area(LARGE * edge * edge);
        }
        size => fill(&mut triangulation, size, factor)?,
    }
    let outside: Faces = triangulation.refine(parameters).excluded_faces.into_iter().collect();
    // Refinement only adds vertices, so that those of the rim stay at the beginning.
    let vertices: Vec<[f64; 2]> = triangulation.vertices().map(|vertex| [vertex.position().x, vertex.position().y]).collect();
    let inside = triangulation.inner_faces().filter(|face| !outside.contains(&face.fix()));
    let triangles: Vec<[usize; 3]> = inside.map(|face| face.vertices().map(|vertex| vertex.fix().index())).collect();
    if triangles.is_empty() { Err(MeshError::NoTriangulation.into()) } else { Ok(Triangles { vertices, triangles }) }
}

/// Refuses an estimated number of cells that exceeds the limit or the memory.
fn counted(cells: f64) -> Result<(), MeshError> {
    // NaN counts as infinity.
    room_for(if cells.is_nan() { usize::MAX } else { cells as usize }, UNSTRUCTURED)
}

/// Triangulation of the rim alone, with its pieces as constraints.
fn constrained(rim: &Rim) -> Result<Constrained, MeshError> {
    let mut triangulation = Constrained::new();
    let mut handles = Vec::with_capacity(rim.vertices.len());
    for (piece, &[x, y]) in rim.vertices.iter().enumerate() {
        let handle = triangulation.insert(Point2::new(x, y)).map_err(|_| MeshError::NoTriangulation)?;
        if handle.index() != piece {
            return Err(rim.crossing(piece, handle.index()));
        }
        handles.push(handle);
    }
    for piece in 0..handles.len() {
        let (from, to) = (handles[piece], handles[rim.next[piece]]);
        let crossed =
            triangulation.get_conflicting_edges_between_vertices(from, to).next().map(|edge| edge.vertices().map(|v| v.fix().index()));
        if let Some([a, b]) = crossed {
            let other = if rim.next[a] == b { a } else { b };
            return Err(rim.crossing(piece, other));
        }
        triangulation.add_constraint(from, to);
        if !triangulation.exists_constraint(from, to) {
            // The constraint does not exist if a vertex lies on it.
            let on = (0..handles.len()).find(|&k| triangulation.exists_constraint(from, handles[k]) && rim.next[k] != piece && k != piece);
            return Err(rim.crossing(piece, on.unwrap_or(piece)));
        }
    }
    Ok(triangulation)
}

/// Inserts vertices in the interior until no triangle is larger than the wanted size.
fn fill<E: From<MeshError>>(triangulation: &mut Constrained, size: &mut CellSize<E>, factor: f64) -> Result<(), E> {
    let mut tree: RTree<[f64; 2]> =
        RTree::bulk_load(triangulation.vertices().map(|vertex| [vertex.position().x, vertex.position().y]).collect());
    loop {
        let none = RefinementParameters::<f64>::new()
            .exclude_outer_faces(true)
            .with_max_additional_vertices(0)
            .with_angle_limit(AngleLimit::from_deg(0.0));
        let outside: Faces = triangulation.refine(none).excluded_faces.into_iter().collect();
        let mut wanted: Vec<(f64, [f64; 2], [f64; 2])> = Vec::new();
        let mut cells = 0.0;
        for face in triangulation.inner_faces().filter(|face| !outside.contains(&face.fix())) {
            let (center, area) = (face.center(), face.area());
            let edge = factor * size.at([center.x, center.y])?;
            let excess = area / (edge * edge);
            cells += factor * factor * excess;
            if excess > LARGE {
                let circle = face.circumcenter();
                // If the circumcenter is outside of the region, the centroid of the triangle is used.
                let is_inside = matches!(triangulation.locate(circle), PositionInTriangulation::OnFace(face) if !outside.contains(&face));
                let at = if is_inside { circle } else { center };
                wanted.push((excess, [at.x, at.y], [center.x, center.y]));
            }
        }
        counted(cells)?;
        wanted.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut is_finer = false;
        for (_, circle, center) in wanted {
            for point in [circle, center] {
                let near = NEAR * factor * size.at(point)?;
                let nearest = tree.nearest_neighbor(point).map_or(f64::INFINITY, |other| (other[0] - point[0]).hypot(other[1] - point[1]));
                if nearest >= near {
                    triangulation.insert(Point2::new(point[0], point[1])).map_err(|_| MeshError::NoTriangulation)?;
                    tree.insert(point);
                    is_finer = true;
                    break;
                }
            }
        }
        if !is_finer {
            return Ok(());
        }
    }
}
