//! Force and tangent of eight cells, from their displacement gradients and the law's answers.

use super::batch::{Batch, Point, Table, cast, deformation_gradient, determinant_and_cofactor, mean, strain_of};
use crate::integrators::{Configuration, Derivative, Placement, discrete_gradient};
use crate::materials::{BatchedLaw, Components, IncrementResponse, Response};
use crate::math::lanes::{Lanes, Real, WIDTH, relabel, relabel_rows};
use crate::math::tensor::{mandel_index, mandel_scale};
use crate::math::tolerances::STRAIN_INCREMENT_SQUARED;

/// What is known of a batch at its points while it is computed: strains and the law's answers, force and tangent.
pub(super) struct Workspace<const FMA: bool, const D: usize, const S: usize, const A: usize, const Q: usize> {
    pub(super) points: [Point<FMA, D, A>; Q],
    /// Displacement gradients at the start and at the end of the step.
    gradient_0: [[[Lanes<FMA>; D]; D]; Q],
    pub(super) gradient_1: [[[Lanes<FMA>; D]; D]; Q],
    pub(super) strain_0: [Components<S>; Q],
    pub(super) strain_1: [Components<S>; Q],
    increments: [IncrementResponse<S>; Q],
    responses: [Response<S>; Q],
    /// Forces on the nodes.
    pub(super) force: [[Lanes<FMA>; D]; A],
    /// Tangent, column by column of the nodes: `tangent[b][k][a][i]` is the derivative of `force[a][i]` with respect to `q[b][k]`.
    pub(super) tangent: [[[[Lanes<FMA>; D]; A]; D]; A],
}

impl<const FMA: bool, const D: usize, const S: usize, const A: usize, const Q: usize> Workspace<FMA, D, S, A, Q> {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Workspace {
            points: [Point::ZERO; Q],
            gradient_0: [[[Lanes::ZERO; D]; D]; Q],
            gradient_1: [[[Lanes::ZERO; D]; D]; Q],
            strain_0: [[Lanes::ZERO; S]; Q],
            strain_1: [[Lanes::ZERO; S]; Q],
            increments: [IncrementResponse::ZERO; Q],
            responses: [Response::ZERO; Q],
            force: [[Lanes::ZERO; D]; A],
            tangent: [[[[Lanes::ZERO; D]; A]; D]; A],
        }
    }

    /// The points of a batch.
    #[inline(always)]
    pub(super) fn set_points(&mut self, batch: &Batch<D, A>, table: &Table<D, A, Q>) {
        for q in 0..Q {
            self.points[q] = Point::new(&batch.edges, &table.gradients[q], table.weights[q]);
        }
    }

    /// Displacement gradients and strains at the end of the step.
    #[inline(always)]
    pub(super) fn set_end(&mut self, batch: &Batch<D, A>, q_1: &[f64]) {
        let u = batch.displacements(q_1);
        for q in 0..Q {
            self.gradient_1[q] = self.points[q].displacement_gradient(&u);
            self.strain_1[q] = strain_of(&self.gradient_1[q]);
        }
    }

    /// Displacement gradients and strains at the start of the step.
    #[inline(always)]
    pub(super) fn set_start(&mut self, batch: &Batch<D, A>, q_0: &[f64]) {
        let u = batch.displacements(q_0);
        for q in 0..Q {
            self.gradient_0[q] = self.points[q].displacement_gradient(&u);
            self.strain_0[q] = strain_of(&self.gradient_0[q]);
        }
    }

    /// Smallest determinant of the deformation gradient at the end of the step, not a number where one is not.
    #[inline(always)]
    pub(super) fn smallest_determinants(&self) -> Lanes<FMA> {
        let mut smallest = Lanes::splat(f64::INFINITY);
        for h in &self.gradient_1 {
            let determinant = determinant_and_cofactor(&deformation_gradient(h)).0;
            for lane in 0..WIDTH {
                // Also takes the new one where the comparison has no answer.
                let keep = smallest.0[lane] < determinant.0[lane] || smallest.0[lane].is_nan();
                smallest.0[lane] = if keep { smallest.0[lane] } else { determinant.0[lane] };
            }
        }
        smallest
    }

    /// Whether some cell is inside out at the end of the step.
    #[inline(always)]
    pub(super) fn is_inside_out(&self) -> bool {
        let mut sound = true;
        for h in &self.gradient_1 {
            let determinant = determinant_and_cofactor(&deformation_gradient(h)).0;
            for lane in 0..WIDTH {
                sound &= determinant.0[lane] > 0.0;
            }
        }
        !sound
    }

    /// Stresses and their derivatives as the step wants them, between [`Self::set_end`] and [`Self::integrate`].
    #[inline(always)]
    pub(super) fn respond(&mut self, law: &dyn BatchedLaw<S>, derivative: Derivative) {
        match derivative {
            Derivative::DiscreteGradient => law.increments_into(&self.strain_0, &self.strain_1, &mut self.increments),
            Derivative::Gradient(Configuration::Middle) => {
                let mut strain = [[Lanes::ZERO; S]; Q];
                for q in 0..Q {
                    strain[q] = strain_of(&mean(&self.gradient_0[q], &self.gradient_1[q]));
                }
                law.responses_into(&strain, &mut self.responses);
            }
            Derivative::Gradient(Configuration::End) => law.responses_into(&self.strain_1, &mut self.responses),
        }
    }

    /// Algorithmic stress at a point and its derivative with respect to the strain at the end.
    #[inline(always)]
    fn stress_and_tangent(&self, q: usize, derivative: Derivative) -> ([Lanes<FMA>; S], [[Lanes<FMA>; S]; S]) {
        if derivative == Derivative::DiscreteGradient {
            let mut d = [Lanes::<FMA>::ZERO; S];
            for s in 0..S {
                d[s] = cast::<FMA>(self.strain_1[q][s]) - cast(self.strain_0[q][s]);
            }
            let IncrementResponse { mean, stress_end, remainder } = &self.increments[q];
            return discrete_gradient(
                &d,
                &relabel(&mean.stress),
                &relabel_rows(&mean.tangent),
                &relabel(stress_end),
                cast(*remainder),
                STRAIN_INCREMENT_SQUARED,
            );
        }
        let (stress, mut tangent) = (relabel(&self.responses[q].stress), relabel_rows(&self.responses[q].tangent));
        if derivative == Derivative::Gradient(Configuration::Middle) {
            for component in tangent.iter_mut().flatten() {
                *component = *component * 0.5;
            }
        }
        (stress, tangent)
    }

    /// Deformation gradient at a point.
    #[inline(always)]
    fn deformation_gradient(&self, q: usize, configuration: Configuration) -> [[Lanes<FMA>; D]; D] {
        match configuration {
            Configuration::Middle => deformation_gradient(&mean(&self.gradient_0[q], &self.gradient_1[q])),
            Configuration::End => deformation_gradient(&self.gradient_1[q]),
        }
    }

    /// Sums the weighted force alone over the points, to the same bytes as [`Self::integrate`].
    #[inline(always)]
    pub(super) fn integrate_force(&mut self, derivative: Derivative, weight: f64) {
        let Placement { test, .. } = derivative.placement();
        self.force = [[Lanes::ZERO; D]; A];
        for q in 0..Q {
            let (stress, _) = self.stress_and_tangent(q, derivative);
            let test = self.deformation_gradient(q, test);
            add_force(&self.points[q].gradients, &test, &stress, self.points[q].volume * weight, &mut self.force);
        }
        self.finish_force();
    }

    /// Sums weighted force and tangent over the points.
    #[inline(always)]
    pub(super) fn integrate(&mut self, derivative: Derivative, weight: f64) {
        let Placement { test, trial, share } = derivative.placement();
        self.clear();
        for q in 0..Q {
            let (stress, tangent) = self.stress_and_tangent(q, derivative);
            let (test, trial) = (self.deformation_gradient(q, test), self.deformation_gradient(q, trial));
            let Point { gradients, volume } = &self.points[q];
            add_point(gradients, &test, &trial, &stress, &tangent, *volume * weight, share, &mut self.force, &mut self.tangent);
        }
        self.finish();
    }

    /// Sums the material stiffness `int B^T D B dV` over the points; the responses are those at the strains at the end.
    #[inline(always)]
    pub(super) fn integrate_material_stiffness(&mut self, factor: f64) {
        self.clear();
        for q in 0..Q {
            let (stress, tangent) = (relabel(&self.responses[q].stress), relabel_rows(&self.responses[q].tangent));
            let f = deformation_gradient(&self.gradient_1[q]);
            let Point { gradients, volume } = &self.points[q];
            add_point(gradients, &f, &f, &stress, &tangent, *volume * factor, 0.0, &mut self.force, &mut self.tangent);
        }
        self.finish();
    }

    /// Sums begin.
    #[inline(always)]
    fn clear(&mut self) {
        self.force = [[Lanes::ZERO; D]; A];
        self.tangent = [[[[Lanes::ZERO; D]; A]; D]; A];
    }

    /// The last node takes what the others leave.
    #[inline(always)]
    fn finish_force(&mut self) {
        for i in 0..D {
            let mut last = Lanes::ZERO;
            for a in 0..A - 1 {
                last = last - self.force[a][i];
            }
            self.force[A - 1][i] = last;
        }
    }

    /// The same for force and tangent.
    #[inline(always)]
    fn finish(&mut self) {
        self.finish_force();
        for k in 0..D {
            for i in 0..D {
                for b in 0..A - 1 {
                    let mut last = Lanes::ZERO;
                    for a in 0..A - 1 {
                        last = last - self.tangent[b][k][a][i];
                    }
                    self.tangent[b][k][A - 1][i] = last;
                }
                for a in 0..A {
                    let mut last = Lanes::ZERO;
                    for b in 0..A - 1 {
                        last = last - self.tangent[b][k][a][i];
                    }
                    self.tangent[A - 1][k][a][i] = last;
                }
            }
        }
    }

    /// Adds `factor` times the consistent mass to the tangent.
    #[inline(always)]
    pub(super) fn add_mass(&mut self, table: &Table<D, A, Q>, factor: f64) {
        for a in 0..A {
            for b in 0..=a {
                let mut mass = Lanes::ZERO;
                for q in 0..Q {
                    mass = self.points[q].volume.mul_add(Lanes::splat(factor * table.products[q][a][b]), mass);
                }
                for i in 0..D {
                    self.tangent[b][i][a][i] = self.tangent[b][i][a][i] + mass;
                    if a != b {
                        self.tangent[a][i][b][i] = self.tangent[a][i][b][i] + mass;
                    }
                }
            }
        }
    }
}

/// Adds the force of a point, the last node left out: `f_a = P G_a` with the first Piola stress `P = w F_test S`.
#[inline(always)]
fn add_force<const FMA: bool, const D: usize, const S: usize, const A: usize>(
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
    for a in 0..A - 1 {
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
fn add_point<const FMA: bool, const D: usize, const S: usize, const A: usize>(
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
    add_force(gradients, test, stress, weight, force);
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
    for a in 0..A - 1 {
        for i in 0..D {
            let mut row = [[Lanes::<FMA>::ZERO; D]; D];
            for j in 0..D {
                for k in 0..D {
                    for l in 0..D {
                        row[k][l] = gradients[a][j].mul_add(moduli[i][j][k][l], row[k][l]);
                    }
                }
            }
            for b in 0..A - 1 {
                for k in 0..D {
                    for l in 0..D {
                        blocks[b][k][a][i] = row[k][l].mul_add(gradients[b][l], blocks[b][k][a][i]);
                    }
                }
            }
        }
    }
}
