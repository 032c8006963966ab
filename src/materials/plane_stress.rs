//! Law in plane stress: the strain across the plane follows from zero stress there.
//!
//! `W(E) = min over E_33 of W(E, E_33)`, so `S_33 = 0`; the stress is that of the law at this strain, and the tangent is condensed,
//! `T - T_3 (x) T_3 / T_33`. The minimum is a stored energy, so its discrete gradient conserves energy (after Simo and Taylor, IJNME 22,
//! 1986, who condense an elastoplastic law). The remainder is the default of [`Law::remainder`](super::Law::remainder) or, if the stiffness
//! may jump within a step so that no quadrature is exact, that of the law itself.

use std::sync::Arc;

use super::batched::{BatchedLaw, Components, IncrementResponse, Response};
use super::law::{lobatto, lobatto_place};
use crate::math::lanes::{Lanes, Real, WIDTH};
use crate::math::tensor::mandel_place;
use crate::math::tolerances::{STRAIN_QUOTIENT, THICKNESS_STRAIN};

/// Largest number of iterations for the strain across the plane: Newton's method needs four to six.
const ITERATIONS: usize = 40;

/// A law with `E_33` solved for.
pub struct PlaneStress(pub Arc<dyn BatchedLaw<4>>);

impl PlaneStress {
    /// Strain across the plane with zero stress there, for strains in the plane.
    pub fn thickness_strain(&self, strain: &Components<3>) -> Lanes<false> {
        self.solved(strain).0[2]
    }

    /// Strains including the one across the plane, and the response of the law to them.
    fn solved(&self, strain: &Components<3>) -> (Components<4>, Response<4>) {
        let mut all = [strain[0], strain[1], Lanes::ZERO, strain[2]];
        let mut response = [Response::ZERO];
        for _ in 0..ITERATIONS {
            self.0.responses_into(&[all], &mut response);
            let mut largest = 0.0f64;
            for lane in 0..WIDTH {
                let change = -response[0].stress[2].0[lane] / response[0].tangent[2][2].0[lane];
                // One iteration reduces the thickness to a fifth at most.
                let squared = 1.0 + 2.0 * all[2].0[lane];
                let change = change.max(-0.48 * squared);
                all[2].0[lane] += change;
                largest = largest.max(change.abs());
            }
            if largest <= THICKNESS_STRAIN || largest.is_nan() {
                break;
            }
        }
        self.0.responses_into(&[all], &mut response);
        (all, response[0])
    }

    fn energy(&self, strain: &Components<3>) -> Lanes<false> {
        let mut energy = [Lanes::ZERO];
        self.0.energies_into(&[self.solved(strain).0], &mut energy);
        energy[0]
    }

    fn response(&self, strain: &Components<3>) -> Response<3> {
        let (_, Response { stress, tangent }) = self.solved(strain);
        let mut condensed = Response::ZERO;
        for k in 0..3 {
            let row = mandel_place::<3>(k);
            condensed.stress[k] = stress[row];
            for l in 0..3 {
                let column = mandel_place::<3>(l);
                condensed.tangent[k][l] = tangent[row][column] - tangent[row][2] * tangent[2][column] / tangent[2][2];
            }
        }
        condensed
    }

    /// `W(E1) - W(E0) - S((E0 + E1)/2):(E1 - E0)` from the law's own increment in four components, whose stress at the mean strain is not
    /// `middle`, because the strain across is not its mean there.
    fn remainder_of_law(&self, n: &Components<3>, n1: &Components<3>, middle: &Components<3>) -> Lanes<false> {
        let ((start, _), (end, _)) = (self.solved(n), self.solved(n1));
        let mut increment = [IncrementResponse::ZERO];
        self.0.increments_into(&[start], &[end], &mut increment);
        let [IncrementResponse { mean, remainder, .. }] = increment;
        let mut sum = remainder + mean.stress[2] * (end[2] - start[2]);
        for k in 0..3 {
            sum = sum + (mean.stress[mandel_place::<3>(k)] - middle[k]) * (n1[k] - n[k]);
        }
        sum
    }

    /// `W(E1) - W(E0) - S((E0 + E1)/2):(E1 - E0)`; `end` is the stress at `E1`.
    fn remainder(&self, n: &Components<3>, n1: &Components<3>, middle: &Components<3>, end: &Components<3>) -> Lanes<false> {
        let at = |s: f64| {
            let mut strain = *n;
            for k in 0..3 {
                strain[k] = (n[k] + n1[k]) * 0.5 + (n1[k] - n[k]) * s;
            }
            strain
        };
        let work = |stress: &Components<3>, less: &Components<3>| {
            let mut sum = Lanes::ZERO;
            for k in 0..3 {
                sum = sum + (stress[k] - less[k]) * (n1[k] - n[k]);
            }
            sum
        };
        let s = lobatto_place();
        let slope = |s: f64| work(&self.response(&at(s)).stress, middle);
        let line = lobatto([slope(-0.5), slope(-s), slope(s), work(end, middle)]);
        let difference = self.energy(n1) - self.energy(n) - work(middle, &[Lanes::ZERO; 3]);
        let mut square = Lanes::ZERO;
        for k in 0..3 {
            square = square + (n1[k] - n[k]) * (n1[k] - n[k]);
        }
        line + square.if_above(STRAIN_QUOTIENT * STRAIN_QUOTIENT, difference - line)
    }
}

impl BatchedLaw<3> for PlaneStress {
    fn energies_into(&self, strain: &[Components<3>], energy: &mut [Lanes<false>]) {
        for (strain, energy) in strain.iter().zip(energy) {
            *energy = self.energy(strain);
        }
    }

    fn stresses_into(&self, strain: &[Components<3>], stress: &mut [Components<3>]) {
        for (strain, stress) in strain.iter().zip(stress) {
            *stress = self.response(strain).stress;
        }
    }

    fn responses_into(&self, strain: &[Components<3>], responses: &mut [Response<3>]) {
        for (strain, response) in strain.iter().zip(responses) {
            *response = self.response(strain);
        }
    }

    fn increments_into(&self, strain_n: &[Components<3>], strain_n1: &[Components<3>], increments: &mut [IncrementResponse<3>]) {
        for ((n, n1), increment) in strain_n.iter().zip(strain_n1).zip(increments) {
            let mut middle = *n;
            for k in 0..3 {
                middle[k] = (n[k] + n1[k]) * 0.5;
            }
            increment.mean = self.response(&middle);
            increment.stress_end = self.response(n1).stress;
            increment.remainder = if self.0.has_kinks() {
                self.remainder_of_law(n, n1, &increment.mean.stress)
            } else {
                self.remainder(n, n1, &increment.mean.stress, &increment.stress_end)
            };
        }
    }
}
