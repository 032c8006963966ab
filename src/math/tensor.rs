//! Symmetric second-order tensors in Mandel components, so that stored-energy laws are written once for the plane and for space.
//!
//! Plane strain has the three components `(11, 22, sqrt2 12)`, with zero strain in the third direction; space has six,
//! `(11, 22, 33, sqrt2 12, sqrt2 23, sqrt2 13)`; a stretched, unsheared third direction (rotational symmetry, plane stress) has the first
//! four of these. Double contractions are dot products. Operations account for the missing components: for a plane strain `E`, `E_33 = 0`,
//! so that `cof E` has no plane components and `det E = 0`.

use std::ops::{Add, Mul, Sub};

use super::lanes::{Lanes, Real};

/// Components of a symmetric tensor; `S` is 3 (plane strain), 4 (third direction stretched, not sheared) or 6 (space).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mandel<R, const S: usize>(pub [R; S]);

/// Index and scale of the component `(i, j)` among the Mandel components in `D` dimensions.
///
/// `E_ij = scale * mandel[index]` with scale 1 on the diagonal and `1/sqrt2` off it.
#[inline(always)]
pub const fn mandel_index<const D: usize>(i: usize, j: usize) -> usize {
    if i == j {
        i
    } else if D == 2 {
        2
    } else {
        // 12 -> 3, 23 -> 4, 13 -> 5
        match i + j {
            1 => 3,
            3 => 4,
            _ => 5,
        }
    }
}

/// Scale of a Mandel component, corresponding to [`mandel_index`].
#[inline(always)]
pub const fn mandel_scale(i: usize, j: usize) -> f64 {
    if i == j { 1.0 } else { std::f64::consts::FRAC_1_SQRT_2 }
}

/// A symmetric tensor that represents a strain or a stress in stored-energy laws.
pub trait Tensor: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Self::Scalar, Output = Self> + Mul<f64, Output = Self> {
    /// Type of the components.
    type Scalar: Real;
    /// A symmetric fourth-order tensor: a matrix of Mandel components.
    type Tangent;
    /// True if the third direction has zero components; determinant and cofactor then vanish and are not computed.
    const PLANE: bool;

    /// Second-order identity tensor.
    fn identity() -> Self;
    /// Sum `A + s I`.
    fn plus_identity(&self, s: Self::Scalar) -> Self;
    /// Sum `s A + B`.
    fn mul_add(&self, s: Self::Scalar, b: &Self) -> Self;
    /// Double contraction `A:B`.
    fn dot(&self, other: &Self) -> Self::Scalar;
    /// Trace.
    fn trace(&self) -> Self::Scalar;
    /// Second principal invariant `((tr E)^2 - E:E) / 2`.
    fn second_invariant(&self) -> Self::Scalar;
    /// Determinant of the three-dimensional tensor: 0 for a plane strain.
    fn determinant(&self) -> Self::Scalar;
    /// Cofactor of the three-dimensional tensor, restricted to the components of `Self`; 0 for plane strain.
    fn cofactor(&self) -> Self;
    /// `a c (x) c + b I_c` with `(I_c)_ijkl = (c_ik c_jl + c_il c_jk) / 2`: the form that every isotropic tangent has.
    fn isotropic_tangent(a: Self::Scalar, b: Self::Scalar, c: &Self) -> Self::Tangent;
}

impl<R: Real, const S: usize> Mandel<R, S> {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(R, R) -> R) -> Self {
        let mut result = self;
        for k in 0..S {
            result.0[k] = f(self.0[k], other.0[k]);
        }
        result
    }

    #[inline(always)]
    fn plus_diagonal<const D: usize>(&self, s: R) -> Self {
        let mut result = *self;
        for k in 0..D {
            result.0[k] = self.0[k] + s;
        }
        result
    }

    #[inline(always)]
    fn product(&self, other: &Self) -> R {
        let mut sum = self.0[0] * other.0[0];
        for k in 1..S {
            sum = self.0[k].mul_add(other.0[k], sum);
        }
        sum
    }
}

impl<R: Real, const S: usize> Add for Mandel<R, S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl<R: Real, const S: usize> Sub for Mandel<R, S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl<R: Real, const S: usize> Mul<f64> for Mandel<R, S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        let mut result = self;
        for k in 0..S {
            result.0[k] = self.0[k] * factor;
        }
        result
    }
}

impl<const FMA: bool, const S: usize> Mul<Lanes<FMA>> for Mandel<Lanes<FMA>, S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: Lanes<FMA>) -> Self {
        let mut result = self;
        for k in 0..S {
            result.0[k] = self.0[k] * factor;
        }
        result
    }
}

/// Symmetric tensor type with `$size` Mandel components, the first `$direct` of them diagonal, and its size-dependent operations.
macro_rules! tensor {
    ($size:literal, $direct:literal, $($particular:item)*) => {
        impl<const FMA: bool> Tensor for Mandel<Lanes<FMA>, $size> {
            type Scalar = Lanes<FMA>;
            type Tangent = [[Lanes<FMA>; $size]; $size];
            const PLANE: bool = $direct == 2;

            #[inline(always)]
            fn identity() -> Self {
                Mandel([Lanes::ZERO; $size]).plus_diagonal::<$direct>(Lanes::splat(1.0))
            }
            #[inline(always)]
            fn plus_identity(&self, s: Lanes<FMA>) -> Self {
                self.plus_diagonal::<$direct>(s)
            }
            #[inline(always)]
            fn mul_add(&self, s: Lanes<FMA>, b: &Self) -> Self {
                self.zip(*b, |a, b| a.mul_add(s, b))
            }
            #[inline(always)]
            fn dot(&self, other: &Self) -> Lanes<FMA> {
                self.product(other)
            }
            #[inline(always)]
            fn trace(&self) -> Lanes<FMA> {
                let mut sum = self.0[0] + self.0[1];
                for component in &self.0[2..$direct] {
                    sum = sum + *component;
                }
                sum
            }
            $($particular)*
        }
    };
}

tensor! { 3, 2,
    #[inline(always)]
    fn second_invariant(&self) -> Lanes<FMA> {
        (self.0[2] * -0.5).mul_add(self.0[2], self.0[0] * self.0[1])
    }
    #[inline(always)]
    fn determinant(&self) -> Lanes<FMA> {
        Lanes::splat(0.0)
    }
    #[inline(always)]
    fn cofactor(&self) -> Self {
        Mandel([Lanes::splat(0.0); 3])
    }
    #[inline(always)]
    fn isotropic_tangent(a: Lanes<FMA>, b: Lanes<FMA>, c: &Self) -> [[Lanes<FMA>; 3]; 3] {
        let [c1, c2, c3] = c.0;
        let (half, b1, b2) = (c3 * c3 * 0.5, b * c1, b * c2);
        let ac = [a * c1, a * c2, a * c3];
        let m12 = ac[0].mul_add(c2, b * half);
        let (m13, m23) = (ac[0].mul_add(c3, b1 * c3), ac[1].mul_add(c3, b2 * c3));
        [[ac[0].mul_add(c1, b1 * c1), m12, m13], [m12, ac[1].mul_add(c2, b2 * c2), m23], [m13, m23, ac[2].mul_add(c3, b1 * c2 + b * half)]]
    }
}

tensor! { 4, 3,
    #[inline(always)]
    fn second_invariant(&self) -> Lanes<FMA> {
        let [xx, yy, zz, xy] = self.0;
        (xx + yy).mul_add(zz, (xy * -0.5).mul_add(xy, xx * yy))
    }
    #[inline(always)]
    fn determinant(&self) -> Lanes<FMA> {
        let [xx, yy, zz, xy] = self.0;
        (xy * -0.5).mul_add(xy, xx * yy) * zz
    }
    #[inline(always)]
    fn cofactor(&self) -> Self {
        let [xx, yy, zz, xy] = self.0;
        Mandel([yy * zz, xx * zz, (xy * -0.5).mul_add(xy, xx * yy), -(xy * zz)])
    }
    #[inline(always)]
    fn isotropic_tangent(a: Lanes<FMA>, b: Lanes<FMA>, c: &Self) -> [[Lanes<FMA>; 4]; 4] {
        let [c1, c2, c3, c4] = c.0;
        let (half, b1, b2, zero) = (c4 * c4 * 0.5, b * c1, b * c2, Lanes::splat(0.0));
        // b I_c; the third direction is not sheared.
        let sheared = [
            [b1 * c1, b * half, zero, b1 * c4],
            [b * half, b2 * c2, zero, b2 * c4],
            [zero, zero, b * c3 * c3, zero],
            [b1 * c4, b2 * c4, zero, (b1 * c2) + b * half],
        ];
        let mut tangent = sheared;
        for row in 0..4 {
            for column in 0..4 {
                tangent[row][column] = (a * c.0[row]).mul_add(c.0[column], sheared[row][column]);
            }
        }
        tangent
    }
}

tensor! { 6, 3,
    #[inline(always)]
    fn second_invariant(&self) -> Lanes<FMA> {
        let [xx, yy, zz, xy, yz, xz] = self.0;
        xx * yy + yy * zz + zz * xx - (xy * xy + yz * yz + xz * xz) * 0.5
    }
    #[inline(always)]
    fn determinant(&self) -> Lanes<FMA> {
        let [xx, yy, zz, xy, yz, xz] = self.0;
        xx * (yy * zz - yz * yz * 0.5) - xy * (xy * zz - yz * xz * std::f64::consts::FRAC_1_SQRT_2) * 0.5
            + xz * (xy * yz * std::f64::consts::FRAC_1_SQRT_2 - yy * xz) * 0.5
    }
    #[inline(always)]
    fn cofactor(&self) -> Self {
        let [xx, yy, zz, xy, yz, xz] = self.0;
        let root = std::f64::consts::FRAC_1_SQRT_2;
        Mandel([
            yy * zz - yz * yz * 0.5,
            xx * zz - xz * xz * 0.5,
            xx * yy - xy * xy * 0.5,
            xz * yz * root - xy * zz,
            xy * xz * root - yz * xx,
            xy * yz * root - xz * yy,
        ])
    }
    #[inline(always)]
    fn isotropic_tangent(a: Lanes<FMA>, b: Lanes<FMA>, c: &Self) -> [[Lanes<FMA>; 6]; 6] {
        let entry = |i: usize, j: usize| c.0[mandel_index::<3>(i, j)] * mandel_scale(i, j);
        let mut tangent = [[Lanes::splat(0.0); 6]; 6];
        for (row, &(i, j)) in PAIRS.iter().enumerate() {
            for (column, &(k, l)) in PAIRS.iter().enumerate() {
                let scale = 0.5 / (mandel_scale(i, j) * mandel_scale(k, l));
                let product = entry(i, k) * entry(j, l) + entry(i, l) * entry(j, k);
                tangent[row][column] = (a * c.0[row]).mul_add(c.0[column], b * product * scale);
            }
        }
        tangent
    }
}

/// Index of a component of a tensor with `S` Mandel components among the six of space; for `S` = 3 also among four without 13 and 23.
#[inline(always)]
pub const fn mandel_place<const S: usize>(component: usize) -> usize {
    if S == 3 && component == 2 { 3 } else { component }
}

/// Indices of the Mandel components in space.
const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)];

/// Index pairs `(i, j)` of the `S` Mandel components of a tensor.
#[inline(always)]
pub const fn mandel_pairs<const S: usize>() -> [(usize, usize); S] {
    let mut pairs = [(0, 1); S];
    let mut k = 0;
    while k < S {
        pairs[k] = PAIRS[mandel_place::<S>(k)];
        k += 1;
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::WIDTH;

    type Lane = Lanes<false>;

    fn space(e: [[f64; 3]; 3]) -> Mandel<Lane, 6> {
        let mut components = [Lane::ZERO; 6];
        for (i, row) in e.iter().enumerate() {
            for (j, &value) in row.iter().enumerate() {
                components[mandel_index::<3>(i, j)] = Lane::splat(value / mandel_scale(i, j));
            }
        }
        Mandel(components)
    }

    const E: [[f64; 3]; 3] = [[0.3, 0.1, -0.2], [0.1, -0.4, 0.25], [-0.2, 0.25, 0.6]];

    #[test]
    fn space_invariants_agree_with_the_matrix() {
        let matrix = nalgebra::Matrix3::from_fn(|i, j| E[i][j]);
        let tensor = space(E);
        assert!((tensor.determinant().0[0] - matrix.determinant()).abs() < 1e-15);
        assert!((tensor.second_invariant().0[0] - 0.5 * (matrix.trace().powi(2) - (matrix * matrix).trace())).abs() < 1e-15);
        let inverse = matrix.try_inverse().unwrap() * matrix.determinant();
        let cofactor = tensor.cofactor();
        for i in 0..3 {
            for j in 0..3 {
                let ours = cofactor.0[mandel_index::<3>(i, j)].0[0] * mandel_scale(i, j);
                assert!((ours - inverse[(i, j)]).abs() < 1e-15, "cofactor {i}{j}");
            }
        }
    }

    #[test]
    fn tangent_form_applied_to_a_tensor_is_the_tensor_expression() {
        // (a c (x) c + b I_c) : x = a (c:x) c + b c x c
        let (c, x) = (space(E), space([[1.0, 0.5, 0.2], [0.5, -2.0, 0.7], [0.2, 0.7, 0.4]]));
        let tangent = Mandel::<Lane, 6>::isotropic_tangent(Lane::splat(1.7), Lane::splat(-0.6), &c);
        let matrix = |t: &Mandel<Lane, 6>| nalgebra::Matrix3::from_fn(|i, j| t.0[mandel_index::<3>(i, j)].0[0] * mandel_scale(i, j));
        let (cm, xm) = (matrix(&c), matrix(&x));
        let expected = cm * (1.7 * (cm * xm).trace()) - cm * xm * cm * 0.6;
        for i in 0..3 {
            for j in 0..3 {
                let row = &tangent[mandel_index::<3>(i, j)];
                let ours: f64 = (0..6).map(|k| row[k].0[0] * x.0[k].0[0]).sum::<f64>() * mandel_scale(i, j);
                assert!((ours - expected[(i, j)]).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn plane_strain_is_space_with_a_zero_third_direction() {
        let plane = [[0.3, 0.1, 0.0], [0.1, -0.4, 0.0], [0.0, 0.0, 0.0]];
        let (s, p) = (space(plane), Mandel([0.3, -0.4, 0.1 * 2f64.sqrt()].map(|x| Lanes::<false>([x; WIDTH]))));
        assert!((s.second_invariant().0[0] - p.second_invariant().0[0]).abs() < 1e-16);
        assert_eq!(s.determinant().0[0].abs() + p.determinant().0[0].abs(), 0.0);
        // C^-1 of a plane strain state has 33 = 1, which must not appear in the plane block of the tangent.
        let c6 = space([[1.2, 0.1, 0.0], [0.1, 0.9, 0.0], [0.0, 0.0, 1.0]]);
        let c3 = Mandel([1.2, 0.9, 0.1 * 2f64.sqrt()].map(|x| Lanes::<false>([x; WIDTH])));
        let t6 = Mandel::<Lane, 6>::isotropic_tangent(Lane::splat(0.4), Lane::splat(1.3), &c6);
        let t3 = Mandel::<Lane, 3>::isotropic_tangent(Lane::splat(0.4), Lane::splat(1.3), &c3);
        for (i, &row) in [0, 1, 3].iter().enumerate() {
            for (j, &column) in [0, 1, 3].iter().enumerate() {
                assert!((t6[row][column].0[0] - t3[i][j].0[0]).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn a_third_direction_without_shear_is_space_with_two_zeros() {
        let matrix = [[0.3, 0.1, 0.0], [0.1, -0.4, 0.0], [0.0, 0.0, 0.6]];
        let (s, f) = (space(matrix), Mandel([0.3, -0.4, 0.6, 0.1 * 2f64.sqrt()].map(|x| Lanes::<false>([x; WIDTH]))));
        let close = |a: Lane, b: Lane| assert!((a.0[0] - b.0[0]).abs() < 1e-15, "{a:?} {b:?}");
        close(s.trace(), f.trace());
        close(s.second_invariant(), f.second_invariant());
        close(s.determinant(), f.determinant());
        close(s.dot(&s), f.dot(&f));
        let (a, b) = (Lane::splat(0.4), Lane::splat(1.3));
        let (t6, t4) = (Mandel::<Lane, 6>::isotropic_tangent(a, b, &s), Mandel::<Lane, 4>::isotropic_tangent(a, b, &f));
        for i in 0..4 {
            close(s.cofactor().0[i], f.cofactor().0[i]);
            close(s.plus_identity(a).0[i], f.plus_identity(a).0[i]);
            for j in 0..4 {
                close(t6[i][j], t4[i][j]);
            }
        }
    }
}
