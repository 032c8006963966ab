//! Viscosity in addition to another law: stresses proportional to the strain rate of a step, and relaxing (Maxwell) branches.
//!
//! With the Green-Lagrange strain `E`, in a step from `E_0` to `E_1` of size `dt` (formulas: [`Viscosity`]):
//!
//! ```text
//! stress    2 eta D + zeta tr(D) I + sum 2 mu Y_mid,     D = (E_1 - E_0)/dt,   Y_mid = (Y_0 + Y_1)/2
//! tangent   a I_4 + b I (x) I,   a = 2 eta/dt + sum mu/(1 + h/2),   b = zeta/dt,   h = dt/tau
//! heat      dt (2 eta D:D + zeta tr(D)^2) + sum 2 mu h Y_mid:Y_mid
//! ```
//!
//! This stress is the same for every kind of stress that is requested of the base law. It acts in the configuration of the step's forces;
//! if that is mid-step, its work on the strain increment equals the energy stored by branches plus the heat. At rest the viscous stress is
//! zero.
//!
//! History variables of a point: those of the base law; the strain `Y` of each branch; the viscous stress, for fields.

use std::ops::Range;

use super::special::{PointLaw, law_responses};
use crate::materials::{BatchedLaw, Components, Heat, HistoryLaw, PointHistory, Response, StrainStep, StressOf, Viscosity};
use crate::math::lanes::Lanes;
use crate::math::simd::{Kernel, dispatch};

/// Viscosity in addition to a base law, or alone.
pub(super) struct ViscousLaw<const S: usize> {
    base: Option<PointLaw<S>>,
    viscosity: Viscosity,
}

/// Viscous stress, tangent and heat of a step at a point.
struct Contribution<const S: usize> {
    stress: Components<S>,
    /// Viscous stress due to the strain rate, without branches.
    of_rate: Components<S>,
    heat: Lanes<false>,
}

/// Coefficients `a` (`identity`) and `b` (`volume`) of the tangent `a I_4 + b I (x) I` `[stress]`.
struct Moduli {
    identity: f64,
    volume: f64,
}

impl<const S: usize> ViscousLaw<S> {
    /// Viscosity in addition to a base law.
    pub(super) fn new(base: PointLaw<S>, viscosity: &Viscosity) -> Self {
        ViscousLaw { base: Some(base), viscosity: viscosity.clone() }
    }

    /// Viscous stress without a base law and without history variables.
    pub(super) fn alone(viscosity: &Viscosity) -> Self {
        ViscousLaw { base: None, viscosity: Viscosity { branches: Vec::new(), ..*viscosity } }
    }

    /// Number of history variables of the base law.
    fn of_base(&self) -> usize {
        self.base.as_ref().map_or(0, PointLaw::variables)
    }

    /// Indices of the branch strains among the history variables of a point.
    fn branches(&self) -> Range<usize> {
        let first = self.of_base();
        first..first + S * self.viscosity.branches.len()
    }

    /// Indices of the viscous stress among the history variables; empty if it is not needed for fields.
    fn of_rate(&self) -> Range<usize> {
        let (first, resists) = (self.branches().end, self.viscosity.shear != 0.0 || self.viscosity.bulk != 0.0);
        first..first + if resists && self.base.is_some() { S } else { 0 }
    }

    /// Stress and heat of a step whose strain changes by `change`; updates the branch strains from start to end.
    fn contribution(&self, change: &Components<S>, branches: &mut [Lanes<false>], dt: f64) -> Contribution<S> {
        let Viscosity { shear, bulk, branches: constants } = &self.viscosity;
        let mut of_rate = change.map(|component| component * (2.0 * shear / dt));
        let volumetric = trace(change) * (bulk / dt);
        of_rate.iter_mut().take(3).for_each(|component| *component = *component + volumetric);
        let (mut stress, mut heat) = (of_rate, dot(&of_rate, change));
        for (branch, strain) in constants.iter().zip(branches.chunks_exact_mut(S)) {
            let [left, comes] = branch.shares(dt);
            let mut middle = [Lanes::ZERO; S];
            for k in 0..S {
                let end = strain[k] * left + change[k] * comes;
                middle[k] = (strain[k] + end) * 0.5;
                strain[k] = end;
                stress[k] = stress[k] + middle[k] * (2.0 * branch.shear_modulus);
            }
            heat = heat + dot(&middle, &middle) * (2.0 * branch.shear_modulus * dt / branch.relaxation_time);
        }
        Contribution { stress, of_rate, heat }
    }

    fn moduli(&self, dt: f64) -> Moduli {
        let Viscosity { shear, bulk, branches } = &self.viscosity;
        let of_branches: f64 = branches.iter().map(|branch| branch.shear_modulus * branch.shares(dt)[1]).sum();
        Moduli { identity: 2.0 * shear / dt + of_branches, volume: bulk / dt }
    }

    /// History variables of the base law at all points.
    fn base_history(&self, history: &[Lanes<false>]) -> Vec<Lanes<false>> {
        let own = self.of_base();
        if own == 0 { Vec::new() } else { history.chunks_exact(self.variables()).flat_map(|point| &point[..own]).copied().collect() }
    }

    /// Visits viscous stress, heat and final history variables at all points of a step of nonzero duration.
    fn for_each_point(&self, step: &StrainStep<S>, mut visit: impl FnMut(usize, &[Lanes<false>], Contribution<S>)) {
        let mut branches = Vec::with_capacity(self.branches().len());
        for (point, change) in step.change.iter().enumerate() {
            branches.clear();
            branches.extend_from_slice(&step.history_of(point, self.variables())[self.branches()]);
            let contribution = self.contribution(change, &mut branches, step.dt);
            visit(point, &branches, contribution);
        }
    }
}

impl Moduli {
    /// Adds `a I_4 + b I (x) I` to a tangent.
    fn add_to<const S: usize>(&self, tangent: &mut [Components<S>; S]) {
        for (k, row) in tangent.iter_mut().enumerate() {
            row[k] = row[k] + self.identity;
            if k < 3 {
                row.iter_mut().take(3).for_each(|component| *component = *component + self.volume);
            }
        }
    }
}

fn trace<const S: usize>(tensor: &Components<S>) -> Lanes<false> {
    tensor[0] + tensor[1] + tensor[2]
}

fn dot<const S: usize>(a: &Components<S>, b: &Components<S>) -> Lanes<false> {
    a.iter().zip(b).fold(Lanes::ZERO, |sum, (a, b)| sum + *a * *b)
}

/// Stresses and tangents of an elastic base law in a step.
struct OfElastic<'a, 'b, const S: usize> {
    law: &'a dyn BatchedLaw<S>,
    step: &'a StrainStep<'b, S>,
    responses: &'a mut [Response<S>],
}

impl<const S: usize> Kernel for OfElastic<'_, '_, S> {
    type Output = ();

    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let StrainStep { start, end, middle, stress, .. } = *self.step;
        law_responses::<FMA, S>(self.law, [start, end, middle], stress, self.responses);
    }
}

impl<const S: usize> HistoryLaw<S> for ViscousLaw<S> {
    fn variables(&self) -> usize {
        self.of_rate().end
    }

    fn responses_into(&self, step: &StrainStep<S>, responses: &mut [Response<S>]) {
        match &self.base {
            None => responses.fill(Response::ZERO),
            Some(PointLaw::Elastic(law)) => dispatch(OfElastic { law: &**law, step, responses }),
            Some(PointLaw::History(law)) => {
                law.responses_into(&StrainStep { history: &self.base_history(step.history), ..*step }, responses);
            }
        }
        if step.dt == 0.0 {
            return;
        }
        let moduli = self.moduli(step.dt);
        self.for_each_point(step, |point, _, Contribution { stress, .. }| {
            let response = &mut responses[point];
            response.stress.iter_mut().zip(stress).for_each(|(sum, more)| *sum = *sum + more);
            if step.stress != StressOf::Middle {
                moduli.add_to(&mut response.tangent);
            }
        });
    }

    fn rate_responses_into(&self, step: &StrainStep<S>, responses: &mut [Response<S>]) -> bool {
        let of_base = match &self.base {
            Some(PointLaw::History(law)) => {
                law.rate_responses_into(&StrainStep { history: &self.base_history(step.history), ..*step }, responses)
            }
            _ => false,
        };
        if !of_base {
            responses.fill(Response::ZERO);
        }
        if step.dt == 0.0 {
            return of_base;
        }
        let moduli = self.moduli(step.dt);
        responses.iter_mut().for_each(|response| moduli.add_to(&mut response.tangent));
        true
    }

    fn rest_responses_into(&self, strain: &[Components<S>], responses: &mut [Response<S>]) {
        match &self.base {
            None => responses.fill(Response::ZERO),
            Some(PointLaw::Elastic(law)) => law.responses_into(strain, responses),
            Some(PointLaw::History(law)) => law.rest_responses_into(strain, responses),
        }
    }

    fn advance_into(&self, step: &StrainStep<S>, after: &mut [Lanes<false>], heat: &mut [Heat]) {
        let (own, size) = (self.of_base(), self.variables());
        if let Some(PointLaw::History(law)) = &self.base {
            let before = self.base_history(step.history);
            let mut inner = before.clone();
            law.advance_into(&StrainStep { history: &before, ..*step }, &mut inner, heat);
            if own > 0 {
                after.chunks_exact_mut(size).zip(inner.chunks_exact(own)).for_each(|(after, inner)| after[..own].copy_from_slice(inner));
            }
        }
        if step.dt == 0.0 {
            self.relax(step.end, after);
            return;
        }
        self.for_each_point(step, |point, branches, contribution| {
            let after = &mut after[point * size..(point + 1) * size];
            after[self.branches()].copy_from_slice(branches);
            let shown = self.of_rate();
            if !shown.is_empty() {
                after[shown].copy_from_slice(&contribution.of_rate);
            }
            heat[point].viscous = heat[point].viscous + contribution.heat;
        });
    }

    fn relax(&self, strain: &[Components<S>], history: &mut [Lanes<false>]) {
        let (own, size) = (self.of_base(), self.variables());
        if let Some(PointLaw::History(law)) = &self.base {
            let mut inner = self.base_history(history);
            law.relax(strain, &mut inner);
            if own > 0 {
                history.chunks_exact_mut(size).zip(inner.chunks_exact(own)).for_each(|(all, inner)| all[..own].copy_from_slice(inner));
            }
        }
        if size > own {
            history.chunks_exact_mut(size).for_each(|point| point[own..].fill(Lanes::ZERO));
        }
    }

    fn energies_into(&self, strain: &[Components<S>], history: &[Lanes<false>], energies: &mut [Lanes<false>]) {
        match &self.base {
            None => energies.fill(Lanes::ZERO),
            Some(PointLaw::Elastic(law)) => law.energies_into(strain, energies),
            Some(PointLaw::History(law)) => law.energies_into(strain, &self.base_history(history), energies),
        }
    }

    fn add_relaxing_energies(&self, history: &[Lanes<false>], energies: &mut [Lanes<false>]) {
        if let Some(PointLaw::History(law)) = &self.base {
            law.add_relaxing_energies(&self.base_history(history), energies);
        }
        if self.viscosity.branches.is_empty() {
            return;
        }
        for (energy, point) in energies.iter_mut().zip(history.chunks_exact(self.variables())) {
            for (strain, branch) in point[self.branches()].as_chunks::<S>().0.iter().zip(&self.viscosity.branches) {
                *energy = *energy + dot(strain, strain) * branch.shear_modulus;
            }
        }
    }

    fn stresses_into(&self, strain: &[Components<S>], history: &[Lanes<false>], stresses: &mut [Components<S>]) {
        match &self.base {
            None => stresses.fill([Lanes::ZERO; S]),
            Some(PointLaw::Elastic(law)) => law.stresses_into(strain, stresses),
            Some(PointLaw::History(law)) => law.stresses_into(strain, &self.base_history(history), stresses),
        }
        for (stress, point) in stresses.iter_mut().zip(history.chunks_exact(self.variables().max(1))) {
            let branches = point[self.branches()].as_chunks::<S>().0.iter().zip(&self.viscosity.branches);
            for (strain, branch) in branches {
                stress.iter_mut().zip(strain).for_each(|(sum, y)| *sum = *sum + *y * (2.0 * branch.shear_modulus));
            }
            stress.iter_mut().zip(&point[self.of_rate()]).for_each(|(sum, more)| *sum = *sum + *more);
        }
    }

    fn across(&self, history: &[Lanes<false>]) -> Option<Lanes<false>> {
        let Some(PointLaw::History(law)) = &self.base else { return None };
        law.across(&history[..self.of_base()])
    }

    fn shown(&self, history: &[Lanes<false>], lane: usize) -> Option<PointHistory> {
        let Some(PointLaw::History(law)) = &self.base else { return None };
        law.shown(&history[..self.of_base()], lane)
    }
}
