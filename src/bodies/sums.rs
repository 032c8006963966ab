//! Contributions of a quadrature point to force and tangent of its cells, and those of the last node.
//!
//! The gradients of the shape functions sum to zero, so the last node is left out of sums and gets the negative sum of the others.

use crate::math::lanes::{Lanes, Real};
use crate::math::tensor::{mandel_index, mandel_scale};

/// Sets the force of the last node to the negative sum of the forces of the other nodes.
#[inline(always)]
pub(super) fn finish_force<const FMA: bool, const D: usize, const A: usize>(count: usize, force: &mut [[Lanes<FMA>; D]; A]) {
    for i in 0..D {
        let mut last = Lanes::ZERO;
        for a in 0..count - 1 {
            last = last - force[a][i];
        }
        force[count - 1][i] = last;
    }
}

/// Adds the force of a point, the last node left out: `f_a = P G_a` with the first Piola stress `P = w F_test S`.
#[inline(always)]
pub(super) fn add_force<const FMA: bool, const D: usize, const S: usize, const A: usize>(
    count: usize,
    gradients: &[[Lanes<FMA>; D]; A],
    test: &[[Lanes<FMA>; D]; D],
    stress: &[Lanes<FMA>; S],
    weight: Lanes<FMA>,
    force: &mut [[Lanes<FMA>; D]; A],
) {
    let mut piola = [[Lanes::<FMA>::ZERO; D]; D];
    for i in 0..D {
        for j in 0..D {
            for m in 0..D {
                let factor = test[i][m] * weight * mandel_scale(m, j);
                piola[i][j] = factor.mul_add(stress[mandel_index::<D>(m, j)], piola[i][j]);
            }
        }
    }
    for a in 0..count - 1 {
        for i in 0..D {
            for j in 0..D {
                force[a][i] = piola[i][j].mul_add(gradients[a][j], force[a][i]);
            }
        }
    }
}

/// Adds force and tangent of a point, the last node left out:
/// `K_ab = G_a . A . G_b` with `A_iJkL = w ((F_test)_iM T_MJNL (F_trial)_kN + share S_JL delta_ik)`.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "the names of the formula")]
pub(super) fn add_point<const FMA: bool, const D: usize, const S: usize, const A: usize>(
    count: usize,
    gradients: &[[Lanes<FMA>; D]; A],
    test: &[[Lanes<FMA>; D]; D],
    trial: &[[Lanes<FMA>; D]; D],
    stress: &[Lanes<FMA>; S],
    tangent: &[[Lanes<FMA>; S]; S],
    weight: Lanes<FMA>,
    share: f64,
    force: &mut [[Lanes<FMA>; D]; A],
    blocks: &mut [[[[Lanes<FMA>; D]; A]; D]; A],
) {
    add_force(count, gradients, test, stress, weight, force);
    // half[iJ][s] = w (F_test)_iM T_MJ,s
    let mut half = [[[Lanes::<FMA>::ZERO; S]; D]; D];
    for i in 0..D {
        for j in 0..D {
            for m in 0..D {
                let factor = test[i][m] * weight * mandel_scale(m, j);
                let component = mandel_index::<D>(m, j);
                for s in 0..S {
                    half[i][j][s] = factor.mul_add(tangent[component][s], half[i][j][s]);
                }
            }
        }
    }
    // moduli[i][J][k][L] = half[iJ][NL] (F_trial)_kN + share w S_JL delta_ik.
    let mut moduli = [[[[Lanes::<FMA>::ZERO; D]; D]; D]; D];
    for i in 0..D {
        for j in 0..D {
            for k in 0..D {
                for l in 0..D {
                    let mut sum = Lanes::<FMA>::ZERO;
                    for n in 0..D {
                        sum = (half[i][j][mandel_index::<D>(n, l)] * mandel_scale(n, l)).mul_add(trial[k][n], sum);
                    }
                    if i == k {
                        let geometric = stress[mandel_index::<D>(j, l)] * (mandel_scale(j, l) * share);
                        sum = geometric.mul_add(weight, sum);
                    }
                    moduli[i][j][k][l] = sum;
                }
            }
        }
    }
    for a in 0..count - 1 {
        for i in 0..D {
            let mut row = [[Lanes::<FMA>::ZERO; D]; D];
            for j in 0..D {
                for k in 0..D {
                    for l in 0..D {
                        row[k][l] = gradients[a][j].mul_add(moduli[i][j][k][l], row[k][l]);
                    }
                }
            }
            for b in 0..count - 1 {
                for k in 0..D {
                    for l in 0..D {
                        blocks[b][k][a][i] = row[k][l].mul_add(gradients[b][l], blocks[b][k][a][i]);
                    }
                }
            }
        }
    }
}
