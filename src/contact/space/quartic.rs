//! Heights of fourth degree over triangles, and polynomials of the gap that they close over a tilted facet (for `closing.rs`).
//!
//! A curve at the height `B` over a facet with the slope `m` in the plane of projection, `c^2 = 1 + |m|^2`, projects to `x + m B/c` and
//! closes the gap there by `c B`. By Lagrange's inversion, with `q_i = m.grad M_i` and derivatives `B_i` with respect to the second and
//! third shape function of the triangle, to second order in `m`,
//!
//! ```text
//! C(x) = c B - sum_i q_i B B_i + sum_ij q_i q_j (B B_i B_j + B^2 B_ij/2)/c        [length]
//! ```
//!
//! The products of `B` do not depend on the configuration but for the stretch of the facet (`stretch.rs`): they are replaced once by the
//! polynomials of fourth degree with the least mean square deviation over the triangle. Heights of second degree leave a circle by
//! `l^4/(3300 r^3)` (root mean square), those of fourth degree by less than `l^6/(4e5 r^5)`; without the terms of second order in `m`
//! tubes with 7 on 5 cells in a quarter have errors as large as with heights of second degree.

use std::sync::LazyLock;

use nalgebra::DMatrix;

use super::forms::{Form, Quadratic};
use crate::contact::numbers::Number;

/// Number of terms of a polynomial of fourth degree in two variables.
pub const TERMS: usize = 15;

/// Number of Gauss points per direction; products of three heights times a polynomial of fourth degree are integrated exactly.
const GAUSS: usize = 8;

/// Polynomial of fourth degree in the second (`x`) and third shape function (`y`) of a triangle: coefficients of
/// `1, x, y, x^2, x y, y^2, x^3, x^2 y, x y^2, y^3, x^4, x^3 y, x^2 y^2, x y^3, y^4`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quartic(pub [f64; TERMS]);

/// Powers of `x` and `y` of the terms of a [`Quartic`].
const POWERS: [[i32; 2]; TERMS] =
    [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2], [3, 0], [2, 1], [1, 2], [0, 3], [4, 0], [3, 1], [2, 2], [1, 3], [0, 4]];

/// Polynomials of a height `B` that close the gap over a tilted triangle: `B`, `B B_1`, `B B_2`, and `B B_i B_j + B^2 B_ij/2` for
/// `ij = 11, 12, 22`.
pub type Closed = [Quartic; 6];

/// Powers of the height in each of the polynomials [`Closed`].
pub const DEGREES: [f64; 6] = [1.0, 2.0, 2.0, 3.0, 3.0, 3.0];

/// Polynomials of a flat triangle.
pub static FLAT: Closed = [Quartic::ZERO; 6];

/// Point of a triangle, and the coefficients of the projection on polynomials of fourth degree that a value there adds.
struct Sample {
    at: [f64; 2],
    by: [f64; TERMS],
}

static SAMPLES: LazyLock<Vec<Sample>> = LazyLock::new(|| {
    let line = gauss();
    let both = line.iter().flat_map(|a| line.iter().map(move |b| (a, b)));
    let at = both.map(|(&(u, of_u), &(v, of_v))| ([u, v * (1.0 - u)], (of_u * of_v * (1.0 - u)).sqrt()));
    let (points, roots): (Vec<[f64; 2]>, Vec<f64>) = at.unzip();
    let terms = DMatrix::from_fn(points.len(), TERMS, |k, term| {
        let ([x, y], [i, j]) = (points[k], POWERS[term]);
        roots[k] * x.powi(i) * y.powi(j)
    });
    let factors = terms.qr();
    let mut operator = factors.q().transpose();
    // The triangular factor of linearly independent terms is regular.
    factors.r().solve_upper_triangular_mut(&mut operator);
    let of = |((at, root), column): ((&[f64; 2], &f64), nalgebra::DVectorView<f64>)| Sample {
        at: *at,
        by: std::array::from_fn(|term| root * column[term]),
    };
    points.iter().zip(&roots).zip(operator.column_iter()).map(of).collect()
});

/// Gauss points on [0, 1] with their weights, by Newton's method for the roots of Legendre's polynomial.
fn gauss() -> Vec<(f64, f64)> {
    let count = GAUSS as f64;
    let legendre = |x: f64| {
        let (mut last, mut value) = (1.0, x);
        for k in 2..=GAUSS {
            let k = k as f64;
            (last, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * last) / k);
        }
        (value, count * (x * value - last) / (x * x - 1.0))
    };
    let of = |k: usize| {
        let mut x = (std::f64::consts::PI * (k as f64 + 0.75) / (count + 0.5)).cos();
        for _ in 0..GAUSS {
            let (value, slope) = legendre(x);
            x -= value / slope;
        }
        let (_, slope) = legendre(x);
        (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..GAUSS).map(of).collect()
}

impl Quartic {
    /// The constant 0.
    pub const ZERO: Self = Quartic([0.0; TERMS]);

    /// Height of second degree.
    pub fn of_form(form: &Form) -> Self {
        let mut of = Quartic::ZERO;
        of.0[..6].copy_from_slice(&Quadratic::of_form(form).0);
        of
    }

    /// Polynomial with the least mean square deviation from a function of `x` and `y` over the triangle; `None` where the function has no
    /// value.
    pub fn projected(of: impl Fn([f64; 2]) -> Option<f64>) -> Option<Self> {
        let mut found = Quartic::ZERO;
        for sample in &*SAMPLES {
            found.add(of(sample.at)?, &sample.by);
        }
        Some(found)
    }

    /// Adds a multiple of these terms.
    #[inline(always)]
    fn add(&mut self, by: f64, terms: &[f64; TERMS]) {
        for term in 0..TERMS {
            self.0[term] += by * terms[term];
        }
    }

    /// Projection of a function that has a value everywhere, see [`Quartic::projected`].
    pub fn projection(of: impl Fn([f64; 2]) -> f64) -> Self {
        Self::projected(|at| Some(of(at))).unwrap_or(Quartic::ZERO)
    }

    /// Sum with a multiple of another polynomial.
    pub fn plus(mut self, by: f64, other: &Quartic) -> Self {
        self.add(by, &other.0);
        self
    }

    /// Value of the polynomial.
    #[inline(always)]
    pub fn at<T: Number>(&self, [x, y]: [T; 2]) -> T {
        let c = &self.0;
        let constant = (((x * c[10] + c[6]) * x + c[3]) * x + c[1]) * x + c[0];
        let linear = ((x * c[11] + c[7]) * x + c[4]) * x + c[2];
        let square = (x * c[12] + c[8]) * x + c[5];
        (((y * c[14] + x * c[13] + c[9]) * y + square) * y + linear) * y + constant
    }

    /// Derivatives with respect to `x` and `y`: coefficients of the terms up to the third degree.
    #[inline(always)]
    pub fn rises(&self) -> [[f64; 10]; 2] {
        let c = &self.0;
        [
            [c[1], 2.0 * c[3], c[4], 3.0 * c[6], 2.0 * c[7], c[8], 4.0 * c[10], 3.0 * c[11], 2.0 * c[12], c[13]],
            [c[2], c[4], 2.0 * c[5], c[7], 2.0 * c[8], 3.0 * c[9], c[11], 2.0 * c[12], 3.0 * c[13], 4.0 * c[14]],
        ]
    }

    /// Derivatives with respect to `x` and `y`.
    fn slopes(&self) -> [Self; 2] {
        self.rises().map(|rises| {
            let mut slope = Quartic::ZERO;
            slope.0[..10].copy_from_slice(&rises);
            slope
        })
    }

    /// Polynomials that close the gap over a tilted triangle with this height, for the triangle with its first two corners exchanged.
    pub fn closed(&self) -> Closed {
        let mut closed = FLAT;
        if *self == Quartic::ZERO {
            return closed;
        }
        let slopes = self.slopes();
        let [[xx, xy], [_, yy]] = [slopes[0].slopes(), slopes[1].slopes()];
        for sample in &*SAMPLES {
            // `x` of the exchanged corners is the first shape function, so that derivatives with respect to it change their sign.
            let [x, y] = sample.at;
            let at = [1.0 - x - y, y];
            let (height, [of_x, of_y]) = (self.at(at), [slopes[0].at(at), slopes[1].at(at)]);
            let [by_x, by_y] = [-of_x, of_y - of_x];
            let [of_xx, of_xy, of_yy] = [xx.at(at), xy.at(at), yy.at(at)];
            let [by_xx, by_xy, by_yy] = [of_xx, of_xx - of_xy, of_yy - 2.0 * of_xy + of_xx];
            let square = 0.5 * height * height;
            let values = [
                height,
                height * by_x,
                height * by_y,
                height * by_x * by_x + square * by_xx,
                height * by_x * by_y + square * by_xy,
                height * by_y * by_y + square * by_yy,
            ];
            closed.iter_mut().zip(values).for_each(|(polynomial, value)| polynomial.add(value, &sample.by));
        }
        closed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Polynomials of fourth degree are reproduced, also with the corners exchanged; derivatives are those of differences.
    #[test]
    fn polynomials_are_reproduced() {
        let of = Quartic(std::array::from_fn(|k| (1.7 * k as f64 + 0.3).sin()));
        let found = Quartic::projection(|at| of.at(at));
        assert!(found.0.iter().zip(of.0).all(|(a, b)| (a - b).abs() < 1e-11), "{found:?}");
        let ([x, y], step): ([f64; 2], f64) = ([0.3, 0.2], 1e-5);
        assert!((of.closed()[0].at([0.5, 0.2]) - of.at([x, y])).abs() < 1e-12);
        for (i, slope) in of.slopes().into_iter().enumerate() {
            let [more, less] = [step, -step].map(|step| of.at(if i == 0 { [x + step, y] } else { [x, y + step] }));
            assert!((slope.at([x, y]) - (more - less) / (2.0 * step)).abs() < 1e-9);
        }
    }

    /// Closed form: the curve `B = b x (1 - x)` over a facet with the slope `m` along `x` closes the gap by `c B` where it projects to.
    #[test]
    fn tilted_parabolas_close_the_gap_of_their_projection() {
        let height = |x: f64| 0.1 * x * (1.0 - x);
        let of = Quartic::projection(|[x, _]| height(x)).closed();
        for m in [0.05f64, -0.1] {
            let root = m.hypot(1.0);
            // The shape function decreases by `m B/c` times its gradient -1 from the point to the foot of its normal.
            let foot = (0..30).fold(0.4, |foot, _| 0.4 - m * height(foot) / root);
            let at = of.map(|of| of.at([1.0 - 0.4 - 0.3, 0.3]));
            let found = root * at[0] + m * at[1] + m * m * at[3] / root;
            assert!((found - root * height(foot)).abs() < 1e-6, "{found} {}", root * height(foot));
        }
    }
}
