//! Height profiles of exact shapes over facets in space (for `second_order.rs`).

use nalgebra::{Matrix6, Vector6};

use super::facet_profile::Profile;
use super::forms::Form;
use super::products::POINTS;
use super::quartic::Quartic;
use crate::contact::faces::{self, Vector};
use crate::math::tolerances;

/// Height profile of a shape over a facet between the points `q`; `None` where the facet does not represent the shape.
pub(super) fn exact_profile(height_of: impl Fn(Vector, Vector) -> Option<f64>, nodes: &[u32], q: &[f64]) -> Option<Profile> {
    let (normal, count) = (faces::normal(nodes, q), nodes.len());
    let height = |x: Vector| height_of(x, normal);
    let points: Vec<Vector> = nodes.iter().map(|&node| faces::at(node, q)).collect();
    let corners: Vec<f64> = points.iter().map(|&x| height(x)).collect::<Option<_>>()?;
    // Sagitta of the curve over a line: three halves of the mean height over the chord, as for a parabola; mean by Boole's rule.
    let sagitta = |from: Vector, to: Vector, [a, b]: [f64; 2]| {
        let inner = [(0.25, 32.0), (0.5, 12.0), (0.75, 32.0)].map(|(s, weight)| height(from.lerp(&to, s)).map(|z| weight * z));
        let mean = (7.0 * (a + b) + inner.into_iter().sum::<Option<f64>>()?) / 90.0;
        Some(1.5 * (mean - 0.5 * (a + b)))
    };
    let side = |k: usize| sagitta(points[k], points[(k + 1) % count], [corners[k], corners[(k + 1) % count]]);
    let sagittas: Vec<f64> = (0..count).map(side).collect::<Option<_>>()?;
    let least = tolerances::STRAIGHT * (points[1] - points[0]).norm();
    if corners.iter().chain(&sagittas).all(|height| height.abs() < least) {
        return Some(Profile::default());
    }
    if let &[a, b, c] = &points[..] {
        let quartic = quartic(height, [a, b, c])?;
        return Some(Profile::of_form(projected(height, [a, b, c])?).with_quartics([quartic, Quartic::ZERO, Quartic::ZERO, Quartic::ZERO]));
    }
    let corners = <[f64; 4]>::try_from(corners).ok()?;
    let center = faces::middle(nodes, q);
    let (mut forms, mut quartics) = ([Form::default(); 4], [Quartic::ZERO; 4]);
    for k in 0..4 {
        let triangle = [points[k], points[(k + 1) % 4], center];
        (forms[k], quartics[k]) = (projected(height, triangle)?, quartic(height, triangle)?);
    }
    Some(Profile::of_forms(forms, corners).with_quartics(quartics))
}

/// Quadratic height over a triangle with the least mean square deviation from a height: integrals with all quadratic functions are equal.
/// Heights that are equal on the sides have another mean; pressures between nonmatching meshes of triangles then have errors
/// ten times as large.
fn projected(height: impl Fn(Vector) -> Option<f64>, corners: [Vector; 3]) -> Option<Form> {
    let (mut matrix, mut right) = (Matrix6::zeros(), Vector6::zeros());
    for part in PARTS {
        for (at, weight) in &POINTS {
            let [a, b, c] = [0, 1, 2].map(|i| (0..3).map(|k| at[k] * part[k][i]).sum::<f64>());
            let terms = Vector6::from([a * a, b * b, c * c, 2.0 * a * b, 2.0 * b * c, 2.0 * c * a]);
            matrix += terms * terms.transpose() * *weight;
            right += terms * (*weight * height(corners[0] * a + corners[1] * b + corners[2] * c)?);
        }
    }
    matrix.cholesky().map(|factors| factors.solve(&right).into())
}

/// Height of fourth degree over a triangle with the least mean square deviation from a height.
fn quartic(height: impl Fn(Vector) -> Option<f64>, [a, b, c]: [Vector; 3]) -> Option<Quartic> {
    Quartic::projected(|[x, y]| height(a + (b - a) * x + (c - a) * y))
}

/// Area coordinates of the corners of the four equal triangles of a triangle.
const PARTS: [[[f64; 3]; 3]; 4] = [
    [[1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5]],
    [[0.0, 1.0, 0.0], [0.0, 0.5, 0.5], [0.5, 0.5, 0.0]],
    [[0.0, 0.0, 1.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]],
    [[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]],
];
