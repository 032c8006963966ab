//! Contributions of a special stress that the common element loop lacks: hoop forces of bodies of revolution, and the derivatives of the
//! pressures of a cell dilatation. Formulas: `special.rs`.

use std::iter;

use super::batch::{MOST_POINTS, Table, cast};
use super::dilatation::{MOST_MODES, Modes};
use super::special::{Answer, SpecialPoints};
use super::sums::{add_force, finish_force};
use super::workspace::Workspace;
use crate::integrators::{Configuration, Derivative, Placement};
use crate::materials::Response;
use crate::math::lanes::{Lanes, Real};
use crate::math::tensor::{mandel_index, mandel_place, mandel_scale};

/// Weights of the added forces in a step, and options of their derivative.
#[derive(Clone, Copy)]
pub(super) struct AddedForce {
    pub(super) derivative: Derivative,
    /// Weight of the force.
    pub(super) weight: f64,
    /// True if the derivative of the force is also computed.
    pub(super) with_tangent: bool,
    /// Derivative of the configuration in which the forces act with respect to the end of the step; 0 omits geometric terms.
    pub(super) geometric: f64,
}

impl<const FMA: bool, const D: usize, const S: usize, const A: usize, const Q: usize> Workspace<FMA, D, S, A, Q> {
    /// Adds all contributions of the special stress to force and tangent.
    #[inline(always)]
    pub(super) fn complete<const L: usize>(
        &mut self,
        answer: &Answer<L>,
        points: &SpecialPoints<D>,
        table: &Table<D, A, Q>,
        is_axisymmetric: bool,
        share: AddedForce,
    ) {
        let is_axisymmetric = D == 2 && is_axisymmetric;
        let Placement { test, trial, .. } = share.derivative.placement();
        let stretch = |q: usize, at: Configuration| match at {
            Configuration::Middle => self.frame_around((points.hoop[0][q] + points.hoop[1][q]) * 0.5),
            Configuration::End => self.frame_around(points.hoop[1][q]),
        };
        let (mut around, mut at_end) = ([[Lanes::<FMA>::ZERO; 2]; Q], [[Lanes::<FMA>::ZERO; 2]; Q]);
        for q in 0..self.counts.points() {
            if is_axisymmetric {
                around[q] = [stretch(q, test), stretch(q, trial)];
                at_end[q] = [around[q][0], stretch(q, Configuration::End)];
            }
        }
        if is_axisymmetric {
            let rates = answer.rates.as_ref().filter(|_| share.with_tangent);
            let of_rates = rates.map(|rates| (&**rates, &at_end, (AddedForce { geometric: 0.0, ..share }, Configuration::End)));
            for (responses, around, share) in iter::once((&answer.responses, &around, (share, trial))).chain(of_rates) {
                self.add_around(responses, table, around, share);
            }
        }
        if share.with_tangent
            && let Some((modes, slopes)) = &answer.dilatation
        {
            self.add_pressure(answer, table, &around, share, (modes, slopes));
        }
    }

    /// Adds the hoop forces with their derivative, and the derivative of the in-plane forces with respect to the hoop stretch.
    #[inline(always)]
    fn add_around<const L: usize>(
        &mut self,
        responses: &[Response<L>; MOST_POINTS],
        table: &Table<D, A, Q>,
        around: &[[Lanes<FMA>; 2]; Q],
        (share, trial): (AddedForce, Configuration),
    ) {
        let Placement { test, .. } = share.derivative.placement();
        let count = self.counts.nodes();
        for q in 0..self.counts.points() {
            let (response, [around_test, around_trial]) = (&responses[q], around[q]);
            let (volume, curvature) = (self.points[q].volume * share.weight, self.points[q].curvature);
            let stress = cast::<FMA>(response.stress[2]);
            let pull = stress * around_test * volume * curvature;
            for a in 0..count {
                self.force[a][0] = pull.mul_add(Lanes::splat(table.shapes[q][a]), self.force[a][0]);
            }
            if !share.with_tangent {
                continue;
            }
            let mut gradients = self.points[q].gradients;
            finish_force(count, &mut gradients);
            let (f_test, f_trial) = (self.deformation_gradient(q, test), self.deformation_gradient(q, trial));
            // Derivatives of the stress in the plane with respect to the hoop stretch, and of the hoop stress with respect to the strain in
            // the plane.
            let (mut to_plane, mut from_plane) = ([[Lanes::<FMA>::ZERO; D]; D], [[Lanes::<FMA>::ZERO; D]; D]);
            for i in 0..D {
                for j in 0..D {
                    for m in 0..D {
                        let (c, scale) = (mandel_place::<S>(mandel_index::<D>(m, j)), mandel_scale(m, j));
                        to_plane[i][j] = (f_test[i][m] * scale).mul_add(cast(response.tangent[c][2]), to_plane[i][j]);
                        from_plane[i][j] = (f_trial[i][m] * scale).mul_add(cast(response.tangent[2][c]), from_plane[i][j]);
                    }
                }
            }
            let stiffness = (around_test * cast(response.tangent[2][2]) * around_trial + stress * share.geometric) * volume;
            for a in 0..count {
                for b in 0..count {
                    let (near_a, near_b) = (curvature * table.shapes[q][a], curvature * table.shapes[q][b]);
                    for i in 0..D {
                        let (mut down, mut across) = (Lanes::<FMA>::ZERO, Lanes::<FMA>::ZERO);
                        for j in 0..D {
                            down = gradients[a][j].mul_add(to_plane[i][j], down);
                            across = gradients[b][j].mul_add(from_plane[i][j], across);
                        }
                        self.tangent[b][0][a][i] = (down * around_trial * volume).mul_add(near_b, self.tangent[b][0][a][i]);
                        self.tangent[b][i][a][0] = (across * around_test * volume).mul_add(near_a, self.tangent[b][i][a][0]);
                    }
                    self.tangent[b][0][a][0] = (stiffness * near_a).mul_add(near_b, self.tangent[b][0][a][0]);
                }
            }
        }
    }

    /// Adds the derivative with respect to the pressures of the cell dilatation, a matrix whose rank is the number of modes.
    #[inline(always)]
    fn add_pressure<const L: usize>(
        &mut self,
        answer: &Answer<L>,
        table: &Table<D, A, Q>,
        around: &[[Lanes<FMA>; 2]; Q],
        share: AddedForce,
        (modes, slopes): (&Modes, &[[Lanes<false>; MOST_MODES]; MOST_MODES]),
    ) {
        let Placement { test, trial, .. } = share.derivative.placement();
        let count = self.counts.nodes();
        // Factors of this low-rank derivative: forces on the test side, derivatives of the dilatation on the trial side.
        let mut sides = [[[[Lanes::ZERO; D]; A]; MOST_MODES]; 2];
        for (side, (at, factor)) in [(test, share.weight), (trial, 1.0)].into_iter().enumerate() {
            for i in 0..modes.count {
                let sums = &mut sides[side][i];
                for q in 0..self.counts.points() {
                    let mut ratio = [Lanes::<FMA>::ZERO; S];
                    for k in 0..S {
                        ratio[k] = cast(answer.ratios[q][side][mandel_place::<S>(k)]);
                    }
                    let volume = self.points[q].volume * cast::<FMA>(modes.values[i][q]) * factor;
                    add_force(count, &self.points[q].gradients, &self.deformation_gradient(q, at), &ratio, volume, sums);
                }
                finish_force(count, sums);
                for q in 0..self.counts.points() {
                    let volume = self.points[q].volume * cast::<FMA>(modes.values[i][q]) * factor;
                    let pull = cast::<FMA>(answer.ratios[q][side][2]) * around[q][side] * self.points[q].curvature * volume;
                    for a in 0..count {
                        sums[a][0] = pull.mul_add(Lanes::splat(table.shapes[q][a]), sums[a][0]);
                    }
                }
            }
        }
        for i in 0..modes.count {
            for b in 0..count {
                for k in 0..D {
                    let mut right = Lanes::<FMA>::ZERO;
                    for j in 0..modes.count {
                        right = cast::<FMA>(slopes[i][j]).mul_add(sides[1][j][b][k], right);
                    }
                    for a in 0..count {
                        for l in 0..D {
                            self.tangent[b][k][a][l] = sides[0][i][a][l].mul_add(right, self.tangent[b][k][a][l]);
                        }
                    }
                }
            }
        }
    }
}
