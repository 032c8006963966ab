//! Heights of a curved surface inside of a facet of four nodes, from its nodes and the sagittas of its sides (for `profiles.rs`).
//!
//! The bilinear map of a facet is `x = x_m + xi u + eta v + xi eta d`, where `d` has the component `w` along the facet's normal, the warp.
//! Nodes of a sphere that do not lie on a circle are warped as much as their sides are curved. The surface is the height `f = w xi eta +
//! serendipity interpolation of the sagittas + b (1 - xi^2)(1 - eta^2)` over the mean plane. The facet itself consists of four flat
//! triangles about `x_m`; the profile is the height over these triangles, so that it contains the difference between the bilinear surface
//! and the four flat triangles.
//!
//! With the half lengths and sagittas of parallelograms, `f = -(A xi^2 + B eta^2 + 2 C xi eta) = -Q` up to the second degree, `2 C = -w`.
//! The terms of fourth degree of surfaces of constant curvature (spheres, cylinders) are `-Q |grad Q|^2/4`; `b` is their coefficient of
//! `xi^2 eta^2`, which does not follow from the sides.

use std::sync::LazyLock;

use nalgebra::{Matrix2, Vector2};

use super::forms::{Form, form};
use super::quartic::Quartic;
use crate::contact::faces::Vector;

/// Heights of a facet of four nodes over its four triangles `[length]`: `middle` over the mean point; `spokes`: sagittas along the lines
/// from the corners to the mean point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interior {
    pub middle: f64,
    pub spokes: [f64; 4],
    /// Coefficient `b` of the bubble function.
    pub bubble: f64,
    /// Terms of fourth degree along each side.
    pub quartics: [f64; 4],
}

/// Quadratic functions on the triangle of the corners `(-1, -1)`, `(1, -1)` and the mean point with the least mean square deviation from
/// `u(xi)`, from `u(eta)`, and from the difference between the bubble function and its representation by `middle` and `spokes`.
const ALONG: Form = [-27.0 / 70.0, -27.0 / 70.0, 17.0 / 70.0, 51.0 / 70.0, 0.1, 0.1];
const ACROSS: Form = [-1.0 / 14.0, -1.0 / 14.0, 29.0 / 70.0, -1.0 / 14.0, -0.3, -0.3];
const BUBBLE: Form = [-4.0 / 21.0, -4.0 / 21.0, 1.0 / 14.0, 13.0 / 42.0, 0.0, 0.0];

/// Terms of fourth degree on the triangle of the corners `(-1, -1)`, `(1, -1)` and the mean point, less those of second degree.
struct Fourth {
    /// `u(xi)`, `u(t) = t^4 - 6 t^2/5 + 1/5`: difference between a circle and the parabola with the area of its segment.
    along: Quartic,
    /// `u(eta)`.
    across: Quartic,
    /// Difference between the bubble function and its representation by `middle` and `spokes`.
    bubble: Quartic,
}

static FOURTH: LazyLock<Fourth> = LazyLock::new(|| {
    let coordinates = |[x, y]: [f64; 2]| [2.0 * x + y - 1.0, y - 1.0];
    let of_circle = |t: f64| (t * t - 1.2) * t * t + 0.2;
    let bubble = Quartic::projection(|at| coordinates(at).map(|t| 1.0 - t * t).iter().product());
    Fourth {
        along: Quartic::projection(|at| of_circle(coordinates(at)[0])),
        across: Quartic::projection(|at| of_circle(coordinates(at)[1])),
        bubble: bubble.plus(-1.0, &Quartic::of_form(&form([0.0, 0.0, 1.0], [0.0, 1.0 / 6.0, 1.0 / 6.0]))),
    }
});

/// Signs of the facet coordinates `xi` and `eta` at the corners.
const CORNERS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

impl Interior {
    /// Serendipity interpolation of heights over the corners and of sagittas along the sides, each at the index of the corner where the
    /// side starts, over a plane parallelogram.
    pub fn of_sides(corners: &[f64; 4], sagittas: &[f64; 4]) -> Self {
        let sum = sagittas.iter().sum::<f64>();
        // Height at a quarter of the diagonal from a corner: 3/4 (3/4 (s + s) + 1/4 (s + s)), first with the sagittas of the two adjacent
        // sides, then with those of the two other sides.
        let spoke = |k: usize| 0.375 * (sagittas[k] + sagittas[(k + 3) % 4]) - 0.0625 * sum;
        Interior { middle: corners.iter().sum::<f64>() / 4.0 + 0.5 * sum, spokes: [0, 1, 2, 3].map(spoke), bubble: 0.0, quartics: [0.0; 4] }
    }

    /// Heights over a facet with the given nodes and unit normal.
    pub fn of_facet(nodes: &[Vector; 4], normal: Vector, corners: &[f64; 4], sagittas: &[f64; 4]) -> Self {
        let mut interior = Self::of_sides(corners, sagittas);
        let along = |signs: [f64; 4]| (0..4).map(|k| nodes[k] * (0.25 * signs[k])).sum::<Vector>();
        let in_plane = |x: Vector| x - normal * normal.dot(&x);
        let [u, v] = [[-1.0, 1.0, 1.0, -1.0], [-1.0, -1.0, 1.0, 1.0]].map(|signs| in_plane(along(signs)));
        let skew = along([1.0, -1.0, 1.0, -1.0]);
        let warp = normal.dot(&skew) + 0.25 * (corners[0] - corners[1] + corners[2] - corners[3]);
        let Some(inverse) = Matrix2::new(u.dot(&u), u.dot(&v), u.dot(&v), v.dot(&v)).try_inverse() else { return interior };
        let skew = inverse * Vector2::new(u.dot(&skew), v.dot(&skew));
        let [a, b, c] = [0.5 * (sagittas[0] + sagittas[2]), 0.5 * (sagittas[1] + sagittas[3]), -0.5 * warp];
        // Q(xi, eta) = (xi, eta) q (xi, eta)
        let q = Matrix2::new(a, c, c, b);
        let slope = q * inverse * q;
        let bubble = -(a * slope.m22 + b * slope.m11 + 4.0 * c * slope.m12 + skew.dot(&(q * skew)));
        interior.middle += bubble;
        interior.bubble = bubble;
        for (spoke, at) in interior.spokes.iter_mut().zip(CORNERS) {
            let fall = skew.dot(&(q * Vector2::from(at)));
            // The mean of (1 - xi^2)(1 - eta^2) is 4/9.
            *spoke += bubble / 6.0 - 0.25 * at[0] * at[1] * (warp + fall);
        }
        interior
    }

    /// Coefficients of the terms of fourth degree along side `k` and across it.
    fn along_and_across(&self, k: usize) -> [f64; 2] {
        [k, k + 1].map(|k| 0.5 * (self.quartics[k % 4] + self.quartics[(k + 2) % 4]))
    }

    /// Height of fourth degree over triangle `k`, from its terms of second degree.
    pub fn quartic(&self, k: usize, form: &Form) -> Quartic {
        let ([along, across], fourth) = (self.along_and_across(k), &*FOURTH);
        Quartic::of_form(form).plus(self.bubble, &fourth.bubble).plus(-along, &fourth.along).plus(-across, &fourth.across)
    }

    /// Adds the terms of fourth degree in the mean square to the height over triangle `k`.
    pub fn even(&self, k: usize, form: &mut Form) {
        let [along, across] = self.along_and_across(k);
        for (term, height) in form.iter_mut().enumerate() {
            *height += self.bubble * BUBBLE[term] - along * ALONG[term] - across * ACROSS[term];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean height of the unit sphere along `normal` over a triangle.
    fn mean([a, b, c]: [Vector; 3], normal: Vector) -> f64 {
        const COUNT: u32 = 60;
        let height = |x: Vector| (x.dot(&normal).powi(2) + 1.0 - x.norm_squared()).sqrt() - x.dot(&normal);
        let (mut sum, mut count) = (0.0, 0.0);
        for i in 0..COUNT {
            for j in 0..COUNT - i {
                let [s, t] = [i, j].map(|k| (f64::from(k) + 1.0 / 3.0) / f64::from(COUNT));
                sum += height(a + (b - a) * s + (c - a) * t);
                count += 1.0;
                if i + j + 1 < COUNT {
                    let [s, t] = [i, j].map(|k| (f64::from(k) + 2.0 / 3.0) / f64::from(COUNT));
                    sum += height(a + (b - a) * s + (c - a) * t);
                    count += 1.0;
                }
            }
        }
        sum / count
    }

    /// Heights of second degree are those of fourth degree in the mean square: their projection on the fourth degree has no constant part.
    #[test]
    fn heights_of_second_degree_are_even() {
        let interior = Interior { middle: 0.1, spokes: [0.02; 4], bubble: 0.3, quartics: [0.7, -0.2, 0.5, 0.4] };
        for k in 0..4 {
            let plain = form([0.01, 0.02, 0.1], [0.05, 0.02, 0.02]);
            let (quartic, mut even) = (interior.quartic(k, &plain), plain);
            interior.even(k, &mut even);
            let difference = quartic.plus(-1.0, &Quartic::of_form(&even));
            for [i, j] in [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]] {
                // The projection of the product keeps its integral; that of x^i y^j over the triangle is i! j!/(i + j + 2)!.
                let product = Quartic::projection(|at| difference.at(at) * at[0].powi(i) * at[1].powi(j)).0;
                let shares = [2.0, 6.0, 6.0, 12.0, 24.0, 12.0, 20.0, 60.0, 60.0, 20.0, 30.0, 120.0, 180.0, 120.0, 30.0];
                let integral: f64 = product.iter().zip(shares).map(|(term, share)| term / share).sum();
                assert!(integral.abs() < 1e-10, "{k} {i} {j}: {integral}");
            }
        }
    }

    /// Closed form: mean heights of a sphere over the four triangles of a square, a rhombus, and a quadrilateral without symmetry.
    #[test]
    fn warped_facets_of_a_sphere_have_its_heights() {
        let root = 3.0_f64.sqrt();
        for shape in [
            [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]],
            [[-root, 0.0], [0.0, -1.0], [root, 0.0], [0.0, 1.0]],
            [[-1.2, -0.9], [0.7, -1.1], [1.3, 0.8], [-0.8, 0.9]],
        ] {
            for size in [0.16, 0.08] {
                let nodes = shape.map(|[x, y]| [size * x, size * y]).map(|[x, y]| Vector::new(x, y, (1.0 - x * x - y * y).sqrt()));
                let (middle, normal) =
                    (nodes.iter().sum::<Vector>() / 4.0, (nodes[2] - nodes[0]).cross(&(nodes[3] - nodes[1])).normalize());
                let height = |x: Vector| (x.dot(&normal).powi(2) + 1.0 - x.norm_squared()).sqrt() - x.dot(&normal);
                let side = |k: usize| {
                    let along = |s: f64| height(nodes[k].lerp(&nodes[(k + 1) % 4], s));
                    1.5 * (0..1000).map(|i| along((f64::from(i) + 0.5) / 1000.0)).sum::<f64>() / 1000.0
                };
                let sagittas = [0, 1, 2, 3].map(side);
                let Interior { middle: found, spokes, .. } = Interior::of_facet(&nodes, normal, &[0.0; 4], &sagittas);
                let of = |k: usize| {
                    let next = (k + 1) % 4;
                    (found + sagittas[k] + spokes[k] + spokes[next]) / 3.0 - mean([nodes[k], nodes[next], middle], normal)
                };
                let off = [0, 1, 2, 3].map(of);
                let worst = off.iter().fold(0.0, |worst: f64, off| worst.max(off.abs()));
                assert!(worst < 3e-4 * found, "{shape:?} {size}: {off:?} of {found}");
            }
        }
    }
}
