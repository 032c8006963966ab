//! Quadratic heights over triangles, of which height profiles in space consist (`profiles.rs`).

use nalgebra::{Matrix2, Vector2};

use crate::contact::numbers::Number;

/// Quadratic height over a triangle with the shape functions `L_i`, `sum b_ij L_i L_j`: `b_00, b_11, b_22, b_01, b_12, b_20` `[length]`,
/// outwards.
pub type Form = [f64; 6];

/// Form with the given heights over three corners and sagittas along the sides that start there.
pub fn form([a, b, c]: [f64; 3], [ab, bc, ca]: [f64; 3]) -> Form {
    [a, b, c, 2.0 * ab + 0.5 * (a + b), 2.0 * bc + 0.5 * (b + c), 2.0 * ca + 0.5 * (c + a)]
}

/// Form of the triangle with its first two corners exchanged.
pub fn turned(&[a, b, c, ab, bc, ca]: &Form) -> Form {
    [b, a, c, ab, ca, bc]
}

/// Derivatives of a form with respect to the shape functions.
#[inline(always)]
pub fn derivatives<T: Number>(form: &Form, l: &[T; 3]) -> [T; 3] {
    let [a, b, c, ab, bc, ca] = form.map(|coefficient| 2.0 * coefficient);
    [l[0] * a + l[1] * ab + l[2] * ca, l[0] * ab + l[1] * b + l[2] * bc, l[0] * ca + l[1] * bc + l[2] * c]
}

/// Value of a form from its derivatives.
#[inline(always)]
pub fn value<T: Number>(derivatives: &[T; 3], l: &[T; 3]) -> T {
    (derivatives[0] * l[0] + derivatives[1] * l[1] + derivatives[2] * l[2]) * 0.5
}

/// Second derivatives of a height over a triangle with the sides `a` and `b` from its first corner `[1/length]`.
pub fn curvature(&[of_0, of_1, of_2, of_01, of_12, of_20]: &Form, sides: [Vector2<f64>; 2]) -> Option<Matrix2<f64>> {
    let mixed = of_0 + of_12 - of_01 - of_20;
    let along = Matrix2::new(of_0 + of_1 - 2.0 * of_01, mixed, mixed, of_0 + of_2 - 2.0 * of_20) * 2.0;
    let duals = Matrix2::from_columns(&sides).try_inverse()?;
    Some(duals.transpose() * along * duals)
}

/// Polynomial of second degree in two of the shape functions of a triangle, the first of which follows: coefficients of
/// `1, x, y, x^2, x y, y^2`.
#[derive(Clone, Copy)]
pub struct Quadratic(pub [f64; 6]);

impl Quadratic {
    /// Height profile of a triangle.
    #[inline(always)]
    pub fn of_form(&[a, b, c, ab, bc, ca]: &Form) -> Self {
        Quadratic([a, 2.0 * (ab - a), 2.0 * (ca - a), a + b - 2.0 * ab, 2.0 * (a + bc - ab - ca), a + c - 2.0 * ca])
    }

    /// Value of the polynomial.
    #[inline(always)]
    pub fn at<T: Number>(&self, [x, y]: [T; 2]) -> T {
        let c = &self.0;
        (x * c[3] + y * c[4] + c[1]) * x + (y * c[5] + c[2]) * y + c[0]
    }

    /// Derivatives by `x` and by `y`: coefficients of `1, x, y`.
    #[inline(always)]
    pub fn rises(&self) -> [[f64; 3]; 2] {
        let c = &self.0;
        [[c[1], 2.0 * c[3], c[4]], [c[2], c[4], 2.0 * c[5]]]
    }

    /// Integral from moments of the terms, which are at `places`.
    #[inline(always)]
    pub fn integral<R: Number, const N: usize>(&self, moments: &[R; N], places: [usize; 6]) -> R {
        let mut sum = moments[places[0]] * self.0[0];
        for term in 1..6 {
            sum += moments[places[term]] * self.0[term];
        }
        sum
    }
}
