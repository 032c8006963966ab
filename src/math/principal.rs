//! Principal values and directions of symmetric tensors by Jacobi's rotations (1846): one in the plane, a few sweeps in space.

use super::lanes::{Lanes, Real};
use super::tensor::{mandel_pairs, mandel_scale};
use super::tolerances::DIAGONAL;

/// Largest number of Jacobi sweeps; 3 x 3 matrices need four.
const SWEEPS: usize = 8;

/// Principal values of a symmetric tensor and the principal directions as matrix rows.
pub struct PrincipalAxes<const FMA: bool> {
    /// Principal values, in no order `[of the tensor]`.
    pub values: [Lanes<FMA>; 3],
    /// Row `k` is the unit vector of the value `k` `[1]`.
    pub directions: [[Lanes<FMA>; 3]; 3],
}

/// The matrix of a symmetric tensor in Mandel components.
#[inline(always)]
pub fn matrix<const FMA: bool, const S: usize>(tensor: &[Lanes<FMA>; S]) -> [[Lanes<FMA>; 3]; 3] {
    let mut matrix = [[Lanes::ZERO; 3]; 3];
    for (k, &(i, j)) in mandel_pairs::<S>().iter().enumerate() {
        let entry = tensor[k] * mandel_scale(i, j);
        (matrix[i][j], matrix[j][i]) = (entry, entry);
    }
    matrix
}

/// Principal values and directions of a tensor in Mandel components; for plane tensors the third value is 0.
#[inline(always)]
pub fn principal<const FMA: bool, const S: usize>(tensor: &[Lanes<FMA>; S]) -> PrincipalAxes<FMA> {
    let mut a = matrix(tensor);
    let (zero, one) = (Lanes::ZERO, Lanes::splat(1.0));
    let mut directions = [[one, zero, zero], [zero, one, zero], [zero, zero, one]];
    if S == 6 {
        sweep(&mut a, &mut directions);
    } else {
        rotate(&mut a, &mut directions, 0, 1);
    }
    PrincipalAxes { values: [a[0][0], a[1][1], a[2][2]], directions }
}

/// Rotates until the matrix is diagonal in all lanes.
#[inline(always)]
fn sweep<const FMA: bool>(a: &mut [[Lanes<FMA>; 3]; 3], directions: &mut [[Lanes<FMA>; 3]; 3]) {
    for _ in 0..SWEEPS {
        let off = a[0][1] * a[0][1] + a[1][2] * a[1][2] + a[0][2] * a[0][2];
        let size = a[0][0] * a[0][0] + a[1][1] * a[1][1] + a[2][2] * a[2][2];
        let mut done = true;
        for lane in 0..off.0.len() {
            done &= off.0[lane] <= DIAGONAL * size.0[lane];
        }
        if done {
            return;
        }
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            rotate(a, directions, p, q);
        }
    }
}

/// Jacobi rotation that zeroes entry `(p, q)`: with the tangent `t` of the angle, the diagonal becomes `a_pp - t a_pq`, `a_qq + t a_pq`.
#[inline(always)]
fn rotate<const FMA: bool>(a: &mut [[Lanes<FMA>; 3]; 3], directions: &mut [[Lanes<FMA>; 3]; 3], p: usize, q: usize) {
    let (common, difference) = (a[p][q], a[q][q] - a[p][p]);
    let twice = common * 2.0;
    let root = twice.mul_add(twice, difference * difference).sqrt();
    let size = difference.greater(-difference) + root;
    let t = size.unless_zero(difference.sign_to(Lanes::splat(1.0)) * twice / size, Lanes::ZERO);
    let cosine = Lanes::splat(1.0) / t.mul_add(t, Lanes::splat(1.0)).sqrt();
    let sine = t * cosine;
    a[p][p] = a[p][p] - t * common;
    a[q][q] = a[q][q] + t * common;
    (a[p][q], a[q][p]) = (Lanes::ZERO, Lanes::ZERO);
    let r = 3 - p - q;
    let (at_p, at_q) = (a[r][p], a[r][q]);
    let (new_p, new_q) = (cosine * at_p - sine * at_q, sine * at_p + cosine * at_q);
    (a[r][p], a[p][r], a[r][q], a[q][r]) = (new_p, new_p, new_q, new_q);
    for k in 0..3 {
        let (at_p, at_q) = (directions[p][k], directions[q][k]);
        directions[p][k] = cosine * at_p - sine * at_q;
        directions[q][k] = sine * at_p + cosine * at_q;
    }
}
