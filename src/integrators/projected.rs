//! Projected discrete gradient of a function of nodes (a contact element) that is invariant under rigid motions.
//!
//! With `P` the orthogonal projector onto the complement of the rigid motions of `q_mid = (q_0 + q_1)/2`, `dq = q_1 - q_0` and `p = P dq`,
//!
//! ```text
//! Gbar = grad f(q_mid) + e p,    e = R / p.p,    R = f(q_1) - f(q_0) - grad f(q_mid).dq
//! ```
//!
//! is directional, `Gbar.dq = f(q_1) - f(q_0)`, and does no work in rigid motions of `q_mid`, so that linear and angular momentum are
//! conserved for every step size and every `f`, kinks included (after Gonzalez, CMAME 190, 2000, whose gradient lacks the projector). It is
//! used for functions without a short list of quadratic invariants, and is linear in `f`. In a rigid motion `p` and `R` vanish.
//!
//! `P` removes the mean and the rotation: with `r` and `d` the nodes of `q_mid` and `dq` relative to their means, `p = d - omega x r`,
//! `J omega = sum r x d`, `J = sum (r.r I - r (x) r)`. In the plane only the third component of the rotation exists.

use nalgebra::{Matrix3, Vector3};

use crate::math::simd::{Kernel, dispatch};
use crate::math::tolerances::{PROJECTED_INCREMENT, REMAINDER};

/// Projected increment `p` of one contact element over a step, and data of its derivative, which depend on nodal positions only.
///
/// The projection depends on the nodes alone; storage is reused for the next contact element.
#[derive(Clone, Debug, Default)]
pub struct Projection<const D: usize> {
    arms: Vec<Vector3<f64>>,
    motion: Vec<f64>,
    centered: Vec<Vector3<f64>>,
    projected: Vec<Vector3<f64>>,
    spin: Vector3<f64>,
    inverse_inertia: Matrix3<f64>,
    /// `1 / p.p`, zero in a rigid motion.
    inverse_square: f64,
    /// Extent of the contact element if the increment is so small that a correction may be round-off; otherwise `None`.
    doubtful: Option<f64>,
}

/// Function of the contact element at the configurations of the step, as needed for the tangent.
#[derive(Clone, Copy, Debug)]
pub struct PatchFunction<'a> {
    /// Gradient at mid-step, `grad f(q_mid)`.
    pub gradient_mid: &'a [f64],
    /// Gradient at the end, `grad f(q_1)`.
    pub gradient_end: &'a [f64],
    /// Hessian at `q_mid`, row by row.
    pub hessian_mid: &'a [f64],
    /// Change `f(q_1) - f(q_0)` of the function in the step.
    pub change: f64,
}

impl<const D: usize> Projection<D> {
    /// Projection for a step of a contact element from `q_0` to `q_1`, node after node.
    pub fn set(&mut self, q_0: &[f64], q_1: &[f64]) {
        let count = q_0.len() / D;
        let share = 1.0 / count as f64;
        self.motion.clear();
        self.motion.extend(q_1.iter().zip(q_0).map(|(end, start)| end - start));
        let (mut center, mut drift) = (Vector3::zeros(), Vector3::zeros());
        self.arms.clear();
        self.centered.clear();
        for node in 0..count {
            let range = node * D..(node + 1) * D;
            let d = padded::<D>(&self.motion[range.clone()]);
            let r = padded::<D>(&q_0[range]) + 0.5 * d;
            center += share * r;
            drift += share * d;
            self.arms.push(r);
            self.centered.push(d);
        }
        let (mut inertia, mut moment, mut size) = (Matrix3::zeros(), Vector3::zeros(), 0.0);
        for (r, d) in self.arms.iter_mut().zip(&mut self.centered) {
            *r -= center;
            *d -= drift;
            let square = r.norm_squared();
            size += square;
            inertia += Matrix3::from_diagonal_element(square) - *r * r.transpose();
            moment += r.cross(d);
        }
        // In the plane the nodes may lie on a line; in space a contact element with its nodes on a line rotates about two axes only.
        self.inverse_inertia = if D == 2 {
            let about = inertia.m33;
            Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, if about > 0.0 { 1.0 / about } else { 0.0 }))
        } else {
            inertia.try_inverse().unwrap_or_default()
        };
        self.spin = self.inverse_inertia * moment;
        self.projected.clear();
        self.projected.extend(self.centered.iter().zip(&self.arms).map(|(d, r)| d - self.spin.cross(r)));
        let square: f64 = self.projected.iter().map(Vector3::norm_squared).sum();
        self.inverse_square = if square > 0.0 { 1.0 / square } else { 0.0 };
        self.doubtful = (square <= PROJECTED_INCREMENT * PROJECTED_INCREMENT * size).then(|| size.sqrt());
    }

    /// Remainder `R` of a function's change over the step beyond the part of its gradient at `q_mid`.
    pub fn remainder(&self, gradient_mid: &[f64], change: f64) -> f64 {
        change - gradient_mid.iter().zip(&self.motion).map(|(g, d)| g * d).sum::<f64>()
    }

    /// Round-off of [`Self::remainder`].
    pub fn round_off(&self, gradient_mid: &[f64]) -> f64 {
        round_off(self.size().sqrt(), gradient_mid)
    }

    /// The projected increment `p`, node after node.
    pub fn increment(&self) -> impl Iterator<Item = f64> {
        self.projected.iter().flat_map(|p| p.as_slice()[..D].iter().copied())
    }

    /// Sum of the squared distances of the nodes from their mean.
    pub fn size(&self) -> f64 {
        self.arms.iter().map(Vector3::norm_squared).sum()
    }

    /// Quotient `e` of a function with the gradient `gradient_mid` at `q_mid` and the change `change` over the step; `None` where the
    /// numerator is round-off, as for a smooth function in a small step, but not at a kink.
    fn quotient(&self, gradient_mid: &[f64], change: f64) -> Option<f64> {
        let remainder = self.remainder(gradient_mid, change);
        let is_round_off = self.doubtful.is_some_and(|size| remainder.abs() <= round_off(size, gradient_mid));
        (!is_round_off).then_some(remainder * self.inverse_square)
    }

    /// Discrete gradient of a function with the gradient `gradient_mid` at `q_mid` and the change `f(q_1) - f(q_0)` over the step.
    pub fn gradient_into(&self, gradient_mid: &[f64], change: f64, out: &mut [f64]) {
        let e = self.quotient(gradient_mid, change).unwrap_or(0.0);
        for (node, p) in self.projected.iter().enumerate() {
            for i in 0..D {
                out[node * D + i] = gradient_mid[node * D + i] + e * p[i];
            }
        }
    }

    /// `weight d Gbar / d q_1`, row by row; not symmetric.
    pub fn tangent_into(&self, weight: f64, f: &PatchFunction, out: &mut [f64]) {
        for (value, h) in out.iter_mut().zip(f.hessian_mid) {
            *value = 0.5 * weight * h;
        }
        let Some(e) = self.quotient(f.gradient_mid, f.change).filter(|_| self.inverse_square > 0.0) else { return };
        dispatch(Corrections { projection: self, weight, quotient: e, function: f, out });
    }
}

/// Round-off of the remainder of a function of the nodes of an element of a size `[length]`.
fn round_off(size: f64, gradient_mid: &[f64]) -> f64 {
    REMAINDER * size * gradient_mid.iter().map(|g| g.abs()).sum::<f64>()
}

/// Number of columns of a tangent that are computed together.
const TOGETHER: usize = 12;

/// Addition of the derivatives of the correction `e p`, compiled for the instruction set of the processor.
struct Corrections<'a, const D: usize> {
    projection: &'a Projection<D>,
    weight: f64,
    quotient: f64,
    function: &'a PatchFunction<'a>,
    out: &'a mut [f64],
}

impl<const D: usize> Kernel for Corrections<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Corrections { projection, weight, quotient: e, function, out } = self;
        let (count, unknowns) = (projection.arms.len(), projection.motion.len());
        let share = 1.0 / count as f64;
        for first in (0..unknowns).step_by(TOGETHER) {
            let wide = TOGETHER.min(unknowns - first);
            let (mut change, mut turn, mut push) = ([0.0; TOGETHER], [[0.0; TOGETHER]; 3], [[0.0; TOGETHER]; 3]);
            let bends = projection.bends(function.hessian_mid, first);
            for c in 0..wide {
                let (column, i) = (first + c, (first + c) % D);
                let node = column / D;
                let (r, d, p) = (projection.arms[node], projection.centered[node], projection.projected[node]);
                let mut unit = Vector3::zeros();
                unit[i] = 1.0;
                let half_turn = cross(&projection.spin, &unit) * 0.5;
                let slope = function.gradient_end[column] - function.gradient_mid[column] - 0.5 * bends[c];
                // d e along this unknown; p is orthogonal to the changes of mean and rotation, which contribute nothing to the derivative
                // of p.p / 2.
                change[c] = weight * projection.inverse_square * (slope - 2.0 * e * (p[i] - dot(&half_turn, &p)));
                let spin = &projection.spin;
                let inertia_change = r[i] * spin - 0.5 * dot(&r, spin) * unit - 0.5 * spin[i] * r;
                let moment = 0.5 * cross(&unit, &d) + cross(&r, &unit) - inertia_change;
                for k in 0..3 {
                    let row = [0, 1, 2].map(|j| projection.inverse_inertia[(k, j)]);
                    turn[k][c] = row[0] * moment[0] + row[1] * moment[1] + row[2] * moment[2];
                    push[k][c] = unit[k] - half_turn[k];
                }
            }
            for other in 0..count {
                let mut own = [-share; TOGETHER];
                for c in 0..wide {
                    if (first + c) / D == other {
                        own[c] = 1.0 - share;
                    }
                }
                let arm = &projection.arms[other];
                for k in 0..D {
                    let (a, b) = ((k + 1) % 3, (k + 2) % 3);
                    let (p, mut sums) = (projection.projected[other][k], [0.0; TOGETHER]);
                    for c in 0..TOGETHER {
                        let dp = own[c] * push[k][c] - (turn[a][c] * arm[b] - turn[b][c] * arm[a]);
                        sums[c] = p * change[c] + weight * e * dp;
                    }
                    let row = (other * D + k) * unknowns + first;
                    for c in 0..wide {
                        out[row + c] += sums[c];
                    }
                }
            }
        }
    }
}

impl<const D: usize> Projection<D> {
    /// Products of rows of a Hessian, from `first` on, with the motion of the nodes.
    #[inline(always)]
    fn bends(&self, hessian: &[f64], first: usize) -> [f64; TOGETHER] {
        let unknowns = self.motion.len();
        let mut bends = [-0.0; TOGETHER];
        for (four, bends) in bends.chunks_exact_mut(4).enumerate() {
            // Rows beyond the last one repeat it.
            let rows = [0, 1, 2, 3].map(|k| &hessian[(first + 4 * four + k).min(unknowns - 1) * unknowns..][..unknowns]);
            for j in 0..unknowns {
                for k in 0..4 {
                    bends[k] += rows[k][j] * self.motion[j];
                }
            }
        }
        bends
    }
}

#[inline(always)]
fn cross(a: &Vector3<f64>, b: &Vector3<f64>) -> Vector3<f64> {
    let [x, y, z] = [0, 1, 2].map(|k| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3]);
    Vector3::new(x, y, z)
}

#[inline(always)]
fn dot(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A vector of `D` components in space.
fn padded<const D: usize>(components: &[f64]) -> Vector3<f64> {
    let mut vector = Vector3::zeros();
    vector.as_mut_slice()[..D].copy_from_slice(components);
    vector
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::*;

    /// A rigid-motion invariant function of four nodes: cubes of squared distances, with value, gradient and Hessian.
    fn function<const D: usize>(q: &[f64]) -> (f64, Vec<f64>, Vec<f64>) {
        let unknowns = 4 * D;
        let (mut value, mut gradient, mut hessian) = (0.0, vec![0.0; unknowns], vec![0.0; unknowns * unknowns]);
        for a in 0..4 {
            for b in 0..a {
                let factor = 1.0 + a as f64 - 0.3 * b as f64;
                let d: Vec<f64> = (0..D).map(|i| q[a * D + i] - q[b * D + i]).collect();
                let s: f64 = d.iter().map(|x| x * x).sum();
                value += factor * s * s * s;
                for i in 0..D {
                    let g = factor * 6.0 * s * s * d[i];
                    gradient[a * D + i] += g;
                    gradient[b * D + i] -= g;
                    for k in 0..D {
                        let h = factor * (24.0 * s * d[i] * d[k] + if i == k { 6.0 * s * s } else { 0.0 });
                        for (m, n, sign) in [(a, a, 1.0), (b, b, 1.0), (a, b, -1.0), (b, a, -1.0)] {
                            hessian[(m * D + i) * unknowns + n * D + k] += sign * h;
                        }
                    }
                }
            }
        }
        (value, gradient, hessian)
    }

    fn middle(q_0: &[f64], q_1: &[f64]) -> Vec<f64> {
        q_0.iter().zip(q_1).map(|(a, b)| 0.5 * (a + b)).collect()
    }

    fn discrete_gradient<const D: usize>(q_0: &[f64], q_1: &[f64]) -> Vec<f64> {
        let mut projection = Projection::<D>::default();
        projection.set(q_0, q_1);
        let mut out = vec![0.0; q_0.len()];
        projection.gradient_into(&function::<D>(&middle(q_0, q_1)).1, function::<D>(q_1).0 - function::<D>(q_0).0, &mut out);
        out
    }

    fn properties<const D: usize>(q_0: &[f64], q_1: &[f64]) -> Result<(), TestCaseError> {
        let gradient = discrete_gradient::<D>(q_0, q_1);
        let size: f64 = 1.0 + gradient.iter().map(|g| g.abs()).sum::<f64>();
        let work: f64 = gradient.iter().zip(q_1.iter().zip(q_0)).map(|(g, (a, b))| g * (a - b)).sum();
        let change = function::<D>(q_1).0 - function::<D>(q_0).0;
        prop_assert!((work - change).abs() < 1e-14 * (size + function::<D>(q_0).0 + function::<D>(q_1).0), "{work} {change}");
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        for (x, g) in middle(q_0, q_1).chunks_exact(D).zip(gradient.chunks_exact(D)) {
            force += padded::<D>(g);
            moment += padded::<D>(x).cross(&padded::<D>(g));
        }
        prop_assert!(force.norm().max(moment.norm()) < 1e-14 * size, "{force} {moment} {size}");
        Ok(())
    }

    fn tangent<const D: usize>(q_0: &[f64], q_1: &[f64]) -> Result<(), TestCaseError> {
        let unknowns = 4 * D;
        let mut projection = Projection::<D>::default();
        projection.set(q_0, q_1);
        let ((_, gradient_mid, hessian_mid), (end, gradient_end, _)) = (function::<D>(&middle(q_0, q_1)), function::<D>(q_1));
        let f = PatchFunction {
            gradient_mid: &gradient_mid,
            gradient_end: &gradient_end,
            hessian_mid: &hessian_mid,
            change: end - function::<D>(q_0).0,
        };
        let mut ours = vec![0.0; unknowns * unknowns];
        projection.tangent_into(1.5, &f, &mut ours);
        let size = ours.iter().fold(1.0, |largest: f64, t| largest.max(t.abs()));
        let step = 1e-3;
        for column in 0..unknowns {
            let at = |shift: f64| {
                let mut moved = q_1.to_vec();
                moved[column] += shift * step;
                discrete_gradient::<D>(q_0, &moved)
            };
            let (a, b, c, d) = (at(-2.0), at(-1.0), at(1.0), at(2.0));
            for row in 0..unknowns {
                let expected = 1.5 * (a[row] - 8.0 * b[row] + 8.0 * c[row] - d[row]) / (12.0 * step);
                let difference = (ours[row * unknowns + column] - expected).abs();
                // Fourth order in a step of 1e-3 against increments about 0.3.
                prop_assert!(difference < 1e-8 * size, "[{row}][{column}] {} {expected} of {size}", ours[row * unknowns + column]);
            }
        }
        Ok(())
    }

    fn step<const N: usize>() -> impl Strategy<Value = (Vec<f64>, Vec<f64>)> {
        (prop::collection::vec(-1.0..1.0f64, N), prop::collection::vec(-0.5..0.5f64, N)).prop_map(|(noise, motion)| {
            let q_0: Vec<f64> = noise.iter().map(|x| 3.0 + x).collect();
            let q_1 = q_0.iter().zip(&motion).map(|(q, d)| q + d).collect();
            (q_0, q_1)
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 300, rng_seed: RngSeed::Fixed(2007), failure_persistence: None, ..Default::default() })]

        #[test]
        fn directional_and_blind_to_rigid_motions_in_the_plane((q_0, q_1) in step::<8>()) {
            properties::<2>(&q_0, &q_1)?;
        }

        #[test]
        fn directional_and_blind_to_rigid_motions_in_space((q_0, q_1) in step::<12>()) {
            properties::<3>(&q_0, &q_1)?;
        }

        #[test]
        fn tangents_agree_with_differences((plane_0, plane_1) in step::<8>(), (space_0, space_1) in step::<12>()) {
            tangent::<2>(&plane_0, &plane_1)?;
            tangent::<3>(&space_0, &space_1)?;
        }
    }

    /// A rotation by 90 degrees is a rigid motion of its own middle: no correction, and the plain gradient does no work in it.
    #[test]
    fn a_finite_rotation_leaves_no_correction() {
        let q_0 = [1.0, 0.0, 3.0, 1.0, 2.0, 2.0, 0.0, -1.0];
        let q_1: Vec<f64> = q_0.chunks_exact(2).flat_map(|x| [5.0 - x[1], x[0]]).collect();
        let mut projection = Projection::<2>::default();
        projection.set(&q_0, &q_1);
        assert_eq!(projection.inverse_square, 0.0);
        assert!(projection.projected.iter().all(|p| p.norm() < 1e-15));
    }
}
