//! Quadric surface through the nodes of a face of second order (for `second_order.rs`), or of first order and its neighbors (for
//! `profiles.rs`).
//!
//! With the distance `z` from a plane along its unit normal and the coordinates `X` in it, the surface is
//!
//! ```text
//! z + k(X, X)/2 + c z^2/2 = 0,        c: principal curvature of k that is larger in magnitude
//! ```
//!
//! Three curvatures `k`, the normal and the offset of the plane are six unknowns for six nodes; eight or nine nodes determine them by least
//! squares. Spheres and cylinders have this form for every direction of the face on them; the quadratic shape functions of the face leave a
//! cylinder where edges are inclined to its axis.

use nalgebra::{DMatrix, DVector, Matrix2, Vector2};

use super::curved_face::has_own_center;
use crate::contact::faces::{self, Vector};
use crate::math::tolerances::STRAIGHT;

/// Largest number of corrections of the plane. Each one squares the error for the nodes of one face; for those around a facet that turns by
/// 20 degrees twelve are too few.
const CORRECTIONS: usize = 60;

/// Largest distance of a node of a face from its quadric, relative to `k l^2` with the edge length `l`: 8 % of the sagitta. Faces of other
/// surfaces have none.
const MISSED: f64 = 0.01;

/// [`MISSED`] for spheres and cylinders through the nodes of facets of first order and their neighbors.
const ROUND: f64 = 0.000_1;

/// Least number of nodes that show whether a surface with six unknowns passes through them.
const ENOUGH: usize = 8;

/// Surface through the nodes of a face.
pub(super) struct Quadric {
    /// Point of the surface under the middle of the face.
    at: Vector,
    /// Two unit vectors of the tangent plane there, and the unit normal.
    axes: [Vector; 3],
    /// Curvatures `k` in the tangent plane `[1/length]`.
    curvature: Matrix2<f64>,
    /// Coefficient `c` `[1/length]`.
    steepest: f64,
}

impl Quadric {
    /// Surface through the nodes of a face of second order: corners, mid-side nodes, and a center that does not follow from the others.
    /// `None` where they do not determine one.
    pub(super) fn through(face: &[u32], q: &[f64]) -> Option<Self> {
        let count = if face.len() == 9 && !has_own_center(face, q) { 8 } else { face.len() };
        let nodes: Vec<Vector> = face[..count].iter().map(|&node| faces::at(node, q)).collect();
        Self::through_points(&nodes, if count == 6 { 3 } else { 4 }, MISSED)
    }

    /// Sphere or cylinder through the nodes of a facet of first order and `others` around it; `None` for other surfaces, and where the
    /// nodes do not determine one.
    pub(super) fn around(facet: &[u32], others: &[u32], q: &[f64]) -> Option<Self> {
        let nodes: Vec<Vector> = facet.iter().chain(others).map(|&node| faces::at(node, q)).collect();
        (nodes.len() >= ENOUGH).then(|| Self::through_points(&nodes, facet.len(), ROUND)).flatten()
    }

    /// Surface through points, of which the first ones are the `corners` of a facet. `largest`: largest distance of a point, relative to
    /// `k l^2`.
    fn through_points(nodes: &[Vector], corners: usize, largest: f64) -> Option<Self> {
        let size = (nodes[1] - nodes[0]).norm();
        let at_corners = nodes[..corners].iter().sum::<Vector>() / corners as f64;
        let [first, second] = [nodes[2] - nodes[0], nodes[corners - 1] - nodes[1]];
        let (mut at, mut normal) = (at_corners, first.cross(&second));
        let mut steepest = 0.0;
        for _ in 0..CORRECTIONS {
            let normal_now = normal.try_normalize(0.0)?;
            let first = (nodes[1] - nodes[0]).cross(&normal_now).try_normalize(0.0)?;
            let surface = Quadric { at, axes: [first, normal_now.cross(&first), normal_now], curvature: Matrix2::zeros(), steepest };
            let ([offset, x, y, xx, yy, xy], missed) = surface.coefficients(nodes, size)?;
            let curvature = Matrix2::new(xx, xy, xy, yy);
            steepest = curvature.symmetric_eigenvalues().into_iter().fold(0.0, |most: f64, &k| if k.abs() > most.abs() { k } else { most });
            let change = (offset / size).abs() + x.abs() + y.abs() + size * (steepest - surface.steepest).abs();
            let [first, second, axis] = surface.axes;
            if change < STRAIGHT * STRAIGHT {
                return (missed <= largest * steepest.abs() * size * size).then_some(Quadric { curvature, steepest, ..surface });
            }
            (at, normal) = (at - axis * offset, axis + first * x + second * y);
        }
        None
    }

    /// Coefficients `offset, x, y, xx, yy, xy` for which `z + offset + x X + y Y + (xx X^2 + yy Y^2)/2 + xy X Y + c z^2/2` is smallest at
    /// the nodes, for the present plane and `c`, and its largest value there.
    fn coefficients(&self, nodes: &[Vector], size: f64) -> Option<([f64; 6], f64)> {
        let (mut matrix, mut right) = (DMatrix::zeros(nodes.len(), 6), DVector::zeros(nodes.len()));
        for (row, node) in nodes.iter().enumerate() {
            let (place, z) = self.coordinates(node - self.at);
            let [x, y] = [place.x / size, place.y / size];
            let terms = [1.0, x, y, 0.5 * x * x, 0.5 * y * y, x * y];
            (0..6).for_each(|column| matrix[(row, column)] = terms[column]);
            right[row] = -(z + 0.5 * self.steepest * z * z) / size;
        }
        let factors = matrix.clone().svd(true, true);
        if factors.singular_values.min() <= STRAIGHT * factors.singular_values.max() {
            return None;
        }
        let found = factors.solve(&right, 0.0).ok()?;
        let missed = size * (matrix * &found - right).amax();
        found.iter().all(|value| value.is_finite()).then(|| {
            let (offset, per_size) = (found[0] * size, |k: usize| found[k] / size);
            ([offset, found[1], found[2], per_size(3), per_size(4), per_size(5)], missed)
        })
    }

    /// Coordinates in the plane and along the normal of a vector.
    fn coordinates(&self, x: Vector) -> (Vector2<f64>, f64) {
        let [first, second, normal] = self.axes;
        (Vector2::new(first.dot(&x), second.dot(&x)), normal.dot(&x))
    }

    /// Distance from `x` to the surface along the unit vector `normal` `[length]`; `None` where this line does not meet it from below.
    pub(super) fn height(&self, x: Vector, normal: Vector) -> Option<f64> {
        let ((place, z), (along, up)) = (self.coordinates(x - self.at), self.coordinates(normal));
        let form = |a: Vector2<f64>, b: Vector2<f64>| a.dot(&(self.curvature * b));
        let square = 0.5 * (form(along, along) + self.steepest * up * up);
        let slope = up + form(place, along) + self.steepest * z * up;
        let value = z + 0.5 * (form(place, place) + self.steepest * z * z);
        let discriminant = slope * slope - 4.0 * square * value;
        (slope > 0.0 && discriminant >= 0.0).then(|| -2.0 * value / (slope + discriminant.sqrt()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nodes of a face whose corners and mid-side nodes are given by surface coordinates.
    fn face(of: impl Fn([f64; 2]) -> Vector) -> Vec<f64> {
        let corners = [[0.1, -0.2], [0.5, 0.1], [0.15, 0.4]];
        let middle = |k: usize| std::array::from_fn(|i| 0.5 * (corners[k][i] + corners[(k + 1) % 3][i]) + 0.01 * (k + i) as f64);
        corners.into_iter().chain([0, 1, 2].map(middle)).flat_map(|at| of(at).data.0[0]).collect()
    }

    /// Closed form: distance to a cylinder and a sphere of radius 2, outside and inside, along directions that are not normal to them.
    #[test]
    fn spheres_and_cylinders_are_exact() {
        let cylinder = |[s, y]: [f64; 2]| Vector::new(2.0 * f64::sin(s), y, 2.0 * f64::cos(s));
        let sphere = |[s, y]: [f64; 2]| Vector::new(s, y, (4.0 - s * s - y * y).sqrt());
        for sense in [1.0, -1.0] {
            for (points, on_axis) in [(face(cylinder), 0.0), (face(sphere), 1.0)] {
                let order = if sense > 0.0 { [0, 1, 2, 3, 4, 5] } else { [0, 2, 1, 5, 4, 3] };
                let surface = Quadric::through(&order, &points).unwrap();
                for k in 0..6 {
                    let (x, away) = (faces::at(k, &points) * 0.98, Vector::new(0.1 * f64::from(k), 0.05, 1.0).normalize() * sense);
                    let end = x + away * surface.height(x, away).unwrap();
                    assert!((end.x * end.x + on_axis * end.y * end.y + end.z * end.z - 4.0).abs() < 1e-12, "{sense} {on_axis} {end}");
                }
            }
        }
    }

    /// Closed form: faces of eight nodes on a cylinder and a sphere; the center of a face of nine nodes counts if it is no interpolation.
    #[test]
    fn quadrilaterals_are_exact() {
        let places: [[f64; 2]; 9] =
            [[0.0, -0.1], [0.4, 0.0], [0.45, 0.4], [0.05, 0.3], [0.2, -0.06], [0.43, 0.2], [0.25, 0.36], [0.02, 0.1], [0.22, 0.15]];
        let cylinder = |[s, y]: [f64; 2]| Vector::new(2.0 * f64::sin(s), y, 2.0 * f64::cos(s));
        let sphere = |[s, y]: [f64; 2]| Vector::new(s, y, (4.0 - s * s - y * y).sqrt());
        let of = |surface: &dyn Fn([f64; 2]) -> Vector| places.iter().flat_map(|&at| surface(at).data.0[0]).collect::<Vec<f64>>();
        for (points, on_axis) in [(of(&cylinder), 0.0), (of(&sphere), 1.0)] {
            for count in [8, 9] {
                let surface = Quadric::through(&(0..count).collect::<Vec<u32>>(), &points).expect("it is a quadric");
                let (x, away) = (faces::at(8, &points) * 0.98, Vector::new(0.1, 0.05, 1.0).normalize());
                let end = x + away * surface.height(x, away).expect("it is above");
                assert!((end.x * end.x + on_axis * end.y * end.y + end.z * end.z - 4.0).abs() < 1e-12, "{count} {on_axis} {end}");
            }
        }
        let mut bent = of(&sphere);
        bent[26] += 0.05;
        assert!(Quadric::through(&(0..9).collect::<Vec<u32>>(), &bent).is_none(), "no quadric has this center");
    }

    #[test]
    fn faces_that_are_no_surface_have_none() {
        let line: Vec<f64> = (0..6).flat_map(|k| [f64::from(k), 0.0, 0.0]).collect();
        assert!(Quadric::through(&[0, 1, 2, 3, 4, 5], &line).is_none());
        let flat = face(|[x, y]| Vector::new(x, y, 0.5 * x));
        let surface = Quadric::through(&[0, 1, 2, 3, 4, 5], &flat).unwrap();
        assert!(surface.height(faces::at(0, &flat), Vector::z()).unwrap().abs() < 1e-15);
    }
}
