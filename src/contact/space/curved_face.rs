//! Curved surface of a quadrilateral of second order: its normals and its center (for `second_order.rs`).
//!
//! Tangents along the lines of three nodes of a face are those of circles. For points of a circle at `u` and `v` from a third one, the
//! vectors `u/|u|^2` and `v/|v|^2` differ by a vector along the tangent there. Parabolas would leave the circle by the angle `l^3/(32 r^3)`
//! at their ends.

use nalgebra::{Matrix2, Vector2};

use crate::contact::faces::{self, Vector};
use crate::math::tolerances::STRAIGHT;
use crate::mesh::flat_pieces;

/// Tangent at a point to the circle through two others of which the first is between, or through one behind and one before it; any length.
fn tangent([other, last]: [Vector; 2], at: Vector) -> Vector {
    let inverted = |x: Vector| (x - at) / (x - at).norm_squared();
    inverted(other) - inverted(last)
}

/// Normals of a quadrilateral of second order at the corners of its facets, in the order of its flat pieces; `None` for other faces and
/// where the face has no normal.
pub fn corner_normals(face: &[u32], q: &[f64]) -> Vec<Option<[Vector; 4]>> {
    let pieces = flat_pieces(if face.len() == 8 { 9 } else { face.len() });
    if face.len() <= 6 {
        return vec![None; pieces.len()];
    }
    let x: Vec<Vector> = face[..8].iter().map(|&node| faces::at(node, q)).collect();
    let edge = |k: usize| [x[k % 4], x[4 + k % 4], x[(k + 1) % 4]];
    let center = center(face, q);
    let of_corner = |k: usize| {
        let ([from, next, end], [start, last, _]) = (edge(k), edge(k + 3));
        tangent([next, end], from).cross(&tangent([last, start], from))
    };
    let of_middle = |k: usize| {
        let [from, middle, end] = edge(k);
        tangent([end, from], middle).cross(&tangent([center, x[4 + (k + 2) % 4]], middle))
    };
    let mut normals: Vec<Vector> = (0..4).map(of_corner).chain((0..4).map(of_middle)).collect();
    normals.push(tangent([x[5], x[7]], center).cross(&tangent([x[6], x[4]], center)));
    let normals: Vec<Option<Vector>> = normals.iter().map(|normal| normal.try_normalize(0.0)).collect();
    let of_piece = |piece: &&[usize]| {
        let mut corners = [Vector::zeros(); 4];
        for (corner, &node) in corners.iter_mut().zip(*piece) {
            *corner = normals[node]?;
        }
        Some(corners)
    };
    pieces.iter().map(of_piece).collect()
}

/// Center of a face of eight or nine nodes by the serendipity interpolation of the other nodes.
fn of_edges(face: &[u32], q: &[f64]) -> Vector {
    let sum = |nodes: &[u32]| nodes.iter().map(|&node| faces::at(node, q)).sum::<Vector>();
    0.5 * sum(&face[4..8]) - 0.25 * sum(&face[..4])
}

/// True for a face of nine nodes whose center does not follow from the other nodes.
pub fn has_own_center(face: &[u32], q: &[f64]) -> bool {
    let diagonal = (faces::at(face[2], q) - faces::at(face[0], q)).norm();
    face.get(8).is_some_and(|&ninth| (faces::at(ninth, q) - of_edges(face, q)).norm() > STRAIGHT * diagonal)
}

/// Center of the surface through the nodes of a face of eight or nine nodes: the ninth node, unless it is the center of the serendipity
/// interpolation of the eight others, which is then corrected.
///
/// The positions of eight nodes do not determine terms `xi^2 eta^2`. Over the mean plane, with the coordinates `X` from the center,
/// surfaces of constant curvature (spheres, cylinders) have the height `z = -Q (1 + |grad Q|^2/4)` up to the fourth degree, `Q` quadratic
/// in `X`. At the center `z` is zero, but its serendipity interpolation is not: this error is subtracted.
pub fn center(face: &[u32], q: &[f64]) -> Vector {
    if has_own_center(face, q) {
        return faces::at(face[8], q);
    }
    let at = |k: usize| faces::at(face[k], q);
    let (corners, middles) = ([0, 1, 2, 3].map(at), [4, 5, 6, 7].map(at));
    let (place, diagonal) = (of_edges(face, q), corners[2] - corners[0]);
    let Some(normal) = diagonal.cross(&(corners[3] - corners[1])).try_normalize(0.0) else { return place };
    let first = (diagonal - normal * normal.dot(&diagonal)).normalize();
    let in_plane = |x: Vector| Vector2::new(first.dot(&x), normal.cross(&first).dot(&x));
    let along = |signs: [f64; 4]| (0..4).map(|k| corners[k] * (0.25 * signs[k])).sum::<Vector>();
    let [u, v, skew] = [[-1.0, 1.0, 1.0, -1.0], [-1.0, -1.0, 1.0, 1.0], [1.0, -1.0, 1.0, -1.0]].map(along);
    let Some(inverse) = Matrix2::from_columns(&[in_plane(u), in_plane(v)]).try_inverse() else { return place };
    let sagitta = |k: usize| (middles[k] - 0.5 * (corners[k] + corners[(k + 1) % 4])).dot(&normal);
    let [a, b, c] = [0.5 * (sagitta(0) + sagitta(2)), 0.5 * (sagitta(1) + sagitta(3)), -0.5 * normal.dot(&skew)];
    let form = inverse.transpose() * Matrix2::new(a, c, c, b) * inverse;
    let height = |x: &Vector| {
        let at = in_plane(x - place);
        let slope = form * at;
        -at.dot(&slope) * (1.0 + slope.norm_squared())
    };
    place + normal * (0.25 * corners.iter().map(height).sum::<f64>() - 0.5 * middles.iter().map(height).sum::<f64>())
}
