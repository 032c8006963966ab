//! Stretch of a facet along the directions in which its surface is curved, by which its height profile (`profiles.rs`) is multiplied.
//!
//! A ring that is pressed together by `e` stays a circle: its facets are shorter by the factor `1 - e`, and so are its heights over them,
//! as in the plane (`contact/profile.rs`). In space, with the curvature `k` of the height profile, its magnitude `|k|` (absolute principal
//! curvatures) and the Cauchy-Green tensor `C` of the facet in its plane,
//!
//! ```text
//! s^2 = |k| : C / tr |k|     C = sum (d_a.d_b) e_a x e_b,    e_a: dual vectors of the diagonals (two sides) d_a at rest
//! ```
//!
//! For a cylinder `s` is the hoop stretch, whatever the strain along the axis; for a sphere it is the quadratic mean of the stretches. It
//! is invariant under rotations and translations.

use nalgebra::{Matrix2, SymmetricEigen, Vector2};

use super::forms::{Form, curvature};
use super::vectors::{FacetFrame, Vec3, diagonal_ends, diagonals, dot, sub};
use super::vertices::CORNERS;
use crate::contact::numbers::Number;

/// Square of the stretch of a facet with the diagonals (or sides) `c` and `d`: `rest + of_c c.c + 2 mixed c.d + of_d d.d`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    rest: f64,
    of_c: f64,
    mixed: f64,
    of_d: f64,
}

/// Stretch of a facet in a configuration.
#[derive(Clone, Copy)]
pub struct Stretched<T> {
    /// Stretch `s`.
    pub by: T,
    /// Derivatives of `ln s` with respect to the nodes `[1/length]`.
    pub rises: [Vec3<T>; CORNERS],
}

impl Default for Stretch {
    /// The constant 1.
    fn default() -> Self {
        Stretch { rest: 1.0, of_c: 0.0, mixed: 0.0, of_d: 0.0 }
    }
}

impl Stretch {
    /// Stretch of a facet from its reference positions and the heights over its triangles there; the constant 1 for a facet without area.
    pub fn new(forms: &[Form; CORNERS], nodes: &[Vec3<f64>]) -> Self {
        Self::along_curvature(forms, nodes).unwrap_or_default()
    }

    fn along_curvature(forms: &[Form; CORNERS], nodes: &[Vec3<f64>]) -> Option<Self> {
        let FacetFrame { axes: [first, second, _], diagonals, .. } = FacetFrame::new(nodes)?;
        let place = |x: Vec3<f64>| Vector2::new(dot(x, first), dot(x, second));
        let count = nodes.len();
        let middle: Vec3<f64> = std::array::from_fn(|i| nodes.iter().map(|x| x[i]).sum::<f64>() / count as f64);
        let (third, triangles) = if count == 3 { (nodes[2], 1) } else { (middle, count) };
        let mut bend = Matrix2::zeros();
        for (k, form) in forms[..triangles].iter().enumerate() {
            let [a, b] = [nodes[(k + 1) % count], third].map(|x| place(sub(x, nodes[k])));
            bend += curvature(form, [a, b])? * a.perp(&b);
        }
        let SymmetricEigen { eigenvectors, eigenvalues } = bend.symmetric_eigen();
        let (sizes, total) = (eigenvalues.abs(), eigenvalues.abs().sum());
        let shares = if total > 0.0 { sizes / total } else { Vector2::repeat(0.5) };
        let magnitude = eigenvectors * Matrix2::from_diagonal(&shares) * eigenvectors.transpose();
        let duals = Matrix2::from_columns(&diagonals.map(place)).try_inverse()?;
        let of = duals * magnitude * duals.transpose();
        Some(Stretch { rest: 0.0, of_c: of[(0, 0)], mixed: of[(0, 1)], of_d: of[(1, 1)] })
    }

    /// Stretch at the positions of a facet's nodes.
    #[inline(always)]
    pub fn at<T: Number>(&self, nodes: &[Vec3<T>]) -> Stretched<T> {
        let [c, d] = diagonals(nodes);
        let (mut by_c, mut by_d) = ([T::from(0.0); 3], [T::from(0.0); 3]);
        for i in 0..3 {
            by_c[i] = c[i] * self.of_c + d[i] * self.mixed;
            by_d[i] = c[i] * self.mixed + d[i] * self.of_d;
        }
        let square = dot(c, by_c) + dot(d, by_d) + self.rest;
        let inverse = square.recip();
        let mut rises = [[T::from(0.0); 3]; CORNERS];
        for ((from, to), by) in diagonal_ends(nodes.len()).into_iter().zip([by_c, by_d]) {
            for i in 0..3 {
                rises[to][i] += by[i] * inverse;
                rises[from][i] -= by[i] * inverse;
            }
        }
        Stretched { by: square.sqrt(), rises }
    }

    /// Coefficients `b_ij` of `s^2 = rest + sum b_ij x_i.x_j` for a facet with `count` nodes `[1/length^2]`.
    #[inline(always)]
    pub fn coefficients(&self, count: usize) -> [[f64; CORNERS]; CORNERS] {
        let mut coefficients = [[0.0; CORNERS]; CORNERS];
        let [c, d] = diagonal_ends(count);
        for (a, b, of) in [(c, c, self.of_c), (c, d, self.mixed), (d, c, self.mixed), (d, d, self.of_d)] {
            coefficients[a.1][b.1] += of;
            coefficients[a.0][b.0] += of;
            coefficients[a.1][b.0] -= of;
            coefficients[a.0][b.1] -= of;
        }
        coefficients
    }
}
