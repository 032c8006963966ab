//! Tilt of a primary triangle against the plane of projection, with the factors of the polynomials of the closed gap (`closing.rs`).

use std::ops::Mul;

use super::quartic::DEGREES;
use super::vertices::slope_of;
use crate::contact::numbers::Number;

/// Derivatives with respect to the polynomials of the closed gap.
pub type PerPolynomial<T> = [T; 6];

/// Tilt of a primary triangle against the plane of projection.
pub struct Tilt<T> {
    /// Gradients of the shape functions.
    gradients: [[T; 2]; 3],
    /// Slope `m`.
    slope: [T; 2],
    /// `1/(1 + |m|^2/2)`.
    per: T,
    /// Bounded function `mu` of the slope (`docs/theory.md`), and its square `t`.
    mu: [T; 2],
    square: T,
    q: [T; 3],
}

#[inline(always)]
fn plane_product<T: Copy, R: Number + Mul<T, Output = R>>(a: [R; 2], b: [T; 2]) -> R {
    a[0] * b[0] + a[1] * b[1]
}

impl<T: Number> Tilt<T> {
    /// Tilt of a primary triangle: gradients of its shape functions, heights of its corners.
    #[inline(always)]
    pub fn new(gradients: [[T; 2]; 3], heights: &[T; 3]) -> Self {
        let slope = slope_of(&gradients, heights);
        let per = (plane_product(slope, slope) * 0.5 + 1.0).recip();
        let mu = [slope[0] * per, slope[1] * per];
        let mut q = [T::from(0.0); 3];
        for k in 0..3 {
            q[k] = plane_product(mu, gradients[k]);
        }
        Tilt { gradients, slope, per, mu, square: plane_product(mu, mu), q }
    }

    /// Factor `k` of the terms of first order in the tilt.
    #[inline(always)]
    fn first(&self) -> T {
        (self.square * 0.5 + 0.5) * self.square + 1.0
    }

    /// Factors `f_u` of the polynomials of the closed gap.
    #[inline(always)]
    pub fn factors(&self) -> PerPolynomial<T> {
        let (t, first, [_, x, y]) = (self.square, self.first(), self.q);
        let upright = ((t * (7.0 / 16.0) + 0.375) * t + 0.5) * t + 1.0;
        [upright, -(first * x), -(first * y), x * x, x * y * 2.0, y * y]
    }

    /// Sum `sum_u n_u^order f_u A_u` over the integrals `A_u`: the integral of `W` times the primary part of `C` for the order 0, its first
    /// and second derivative with respect to `ln s_2` for the orders 1 and 2.
    #[inline(always)]
    pub fn closed<R: Number + Mul<T, Output = R>>(&self, integrals: &PerPolynomial<R>, order: i32) -> R {
        let (factors, mut sum) = (self.factors(), R::from(0.0));
        for u in 0..6 {
            sum += integrals[u] * factors[u] * DEGREES[u].powi(order);
        }
        sum
    }

    /// Derivatives of `Phi` by way of the tilt with respect to plane coordinates and height of the corners, from the integrals `A_u`.
    #[inline(always)]
    pub fn forces<R: Number + Mul<T, Output = R>>(&self, integrals: &PerPolynomial<R>) -> [[R; 3]; 3] {
        let ([_, b, c], mu, [_, x, y], t, first) = (self.gradients, self.mu, self.q, self.square, self.first());
        let [upright, by_x, by_y, by_xx, by_xy, by_yy] = *integrals;
        let of_x = (by_xx * x + by_xy * y) * 2.0 - by_x * first;
        let of_y = (by_xy * x + by_yy * y) * 2.0 - by_y * first;
        let tilt = [of_x * b[0] + of_y * c[0], of_x * b[1] + of_y * c[1]];
        let of_square = upright * ((t * 2.625 + 1.5) * t + 1.0) - (by_x * x + by_y * y) * (t * 2.0 + 1.0);
        let g = [of_square * mu[0] + tilt[0], of_square * mu[1] + tilt[1]];
        let along = plane_product(g, mu);
        let by_slope = [g[0] * self.per - along * mu[0], g[1] * self.per - along * mu[1]];
        let mut forces = [[R::from(0.0); 3]; 3];
        for j in 0..3 {
            let rise = plane_product(by_slope, self.gradients[j]);
            forces[j][2] = -rise;
            for i in 0..2 {
                forces[j][i] = rise * self.slope[i] + tilt[i] * self.q[j];
            }
        }
        forces
    }
}
