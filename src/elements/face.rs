//! Faces of cells in space: shape functions and their slopes at points that integrate forces normal to a face exactly.

use std::sync::OnceLock;

use super::CellKind;

/// Largest number of nodes of a face.
pub const MOST_FACE_NODES: usize = 9;

/// A quadrature point of a face.
#[derive(Clone, Debug)]
pub struct FacePoint {
    /// Quadrature weight of the point.
    pub weight: f64,
    /// Values of the shape functions, one for each node of the face.
    pub shapes: Vec<f64>,
    /// Derivatives of the shape functions with respect to the two face coordinates.
    pub slopes: Vec<[f64; 2]>,
}

/// Six-point rule of a triangle, exact to degree four (Strang and Fix 1973; Dunavant 1985): for each of two sets of three points related by
/// permutation, the two equal coordinates and the weight.
const TRIANGLE: [(f64, f64); 2] =
    [(0.445_948_490_915_964_9, 0.111_690_794_839_005_73), (0.091_576_213_509_770_74, 0.054_975_871_827_660_934)];

/// Quadrature points of a face with a given number of nodes: exact for the product of normal and shape function, also on curved faces.
pub fn face_points(nodes: usize) -> &'static [FacePoint] {
    static POINTS: [OnceLock<Vec<FacePoint>>; MOST_FACE_NODES + 1] = [const { OnceLock::new() }; MOST_FACE_NODES + 1];
    POINTS[nodes].get_or_init(|| {
        let row = CellKind::of_face(nodes).row();
        let of_triangle = TRIANGLE.iter().flat_map(|&(a, weight)| [[a, a], [1.0 - 2.0 * a, a], [a, 1.0 - 2.0 * a]].map(|xi| (xi, weight)));
        let rule: Vec<([f64; 3], f64)> =
            if nodes == 6 { of_triangle.map(|([x, y], weight)| ([x, y, 0.0], weight)).collect() } else { (row.quadrature)() };
        let point = |(xi, weight)| FacePoint {
            weight,
            shapes: (row.shape)(xi),
            slopes: (row.gradients)(xi).into_iter().map(|[along, across, _]| [along, across]).collect(),
        };
        rule.into_iter().map(point).collect()
    })
}

impl FacePoint {
    /// Tangents of the face in its two directions at the point, for the node positions `nodes`.
    pub fn tangents(&self, nodes: &[[f64; 3]]) -> [[f64; 3]; 2] {
        let mut tangents = [[0.0; 3]; 2];
        for (x, slopes) in nodes.iter().zip(&self.slopes) {
            for (tangent, slope) in tangents.iter_mut().zip(slopes) {
                tangent.iter_mut().zip(x).for_each(|(sum, x)| *sum += slope * x);
            }
        }
        tangents
    }

    /// Outward normal of the face at the point; times the weight it is the area vector.
    pub fn normal(&self, nodes: &[[f64; 3]]) -> [f64; 3] {
        let [a, b] = self.tangents(nodes);
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    }
}
