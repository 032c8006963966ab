//! The elastic-plastic law behind [`HistoryLaw`]: stress and tangent of a step, history variables and heat at its end.

use std::hint::black_box;

use super::constants::{ElasticPlastic, MOST_BACK_STRESSES};
use super::flow::{Flow, FlowStep, Rule, Slopes};
use super::frame::{PlasticPoint, Stretches, variables};
use super::logarithm::{
    Matrix, adjoint, applied, applied_back, congruence, curvature, deviator, dot, first_difference, place, plus, product,
    product_with_transpose, rows, symmetric_map, times, trace,
};
use crate::materials::batched::{Components, Response};
use crate::materials::history::{Heat, HistoryLaw, PointHistory, StrainStep, StressOf};
use crate::math::lanes::{Lanes, Real, relabel, relabel_rows};
use crate::math::principal::matrix;
use crate::math::simd::{Kernel, dispatch};
use crate::math::tensor::{mandel_pairs, mandel_scale};

/// Elastic-plastic law; its bulk modulus is 0 if the cells have a volumetric energy of their own.
#[derive(Clone)]
pub(crate) struct PlasticLaw {
    constants: ElasticPlastic,
    /// Bulk modulus `[stress]`.
    bulk: f64,
    /// Shear modulus `[stress]`.
    shear: f64,
}

/// Step in the principal directions of its end configuration.
struct Step<const FMA: bool, const S: usize> {
    kept: PlasticPoint<FMA, S>,
    /// Stretches at start and end.
    ends: [Stretches<FMA>; 2],
    /// Rotation between principal directions, `R_ij = n_1i . n_0j`, `n_1` at the end, `n_0` at the start.
    turn: Matrix<FMA>,
    /// Logarithmic strains.
    strains: [[Lanes<FMA>; S]; 2],
    back: [[Lanes<FMA>; S]; MOST_BACK_STRESSES],
    flow: Flow<FMA, S>,
}

impl PlasticLaw {
    /// Law of checked constants; its bulk modulus is 0 if `has_volume` is false, for cells with a volumetric energy of their own.
    pub(crate) fn new(constants: &ElasticPlastic, has_volume: bool) -> Self {
        let bulk = if has_volume { constants.bulk_modulus() } else { 0.0 };
        PlasticLaw { constants: constants.clone(), bulk, shear: constants.shear_modulus() }
    }

    fn back_stresses(&self) -> usize {
        self.constants.back_stresses.len()
    }

    /// Stress of Hencky's law for a logarithmic strain.
    #[inline(always)]
    fn elastic<const FMA: bool, const S: usize>(&self, strain: &[Lanes<FMA>; S]) -> [Lanes<FMA>; S] {
        let pressure = trace(strain) * self.bulk;
        let mut stress = times(&deviator(strain), Lanes::splat(2.0 * self.shear));
        stress.iter_mut().take(3).for_each(|component| *component = *component + pressure);
        stress
    }

    /// Strains and flow of a step between two Green-Lagrange strains.
    #[inline(always)]
    fn step<const FMA: bool, const S: usize>(
        &self,
        strains: [&Components<S>; 2],
        history: &[Lanes<false>],
        (dt, rule): (f64, Rule),
        with_slopes: bool,
    ) -> Step<FMA, S> {
        let kept = PlasticPoint::<FMA, S>::read(history, self.back_stresses());
        let mut ends = [Stretches::ZERO; 2];
        // Prevents unrolling of the loop: the spectral decomposition is a large part of what is compiled.
        for k in 0..black_box(2).min(2) {
            ends[k] = kept.stretches(strains[k]);
        }
        let mut turn = [[Lanes::ZERO; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                for k in 0..3 {
                    turn[i][j] = ends[1].directions[i][k].mul_add(ends[0].directions[j][k], turn[i][j]);
                }
            }
        }
        let (mut start, mut end) = ([Lanes::ZERO; S], [Lanes::ZERO; S]);
        for (row, &(i, k)) in mandel_pairs::<S>().iter().enumerate() {
            for j in 0..3 {
                start[row] = (ends[0].logarithms[j] * turn[i][j]).mul_add(turn[k][j], start[row]);
            }
            start[row] = start[row] * (1.0 / mandel_scale(i, k));
        }
        end[..3].copy_from_slice(&ends[1].logarithms);
        let back = kept.turned_back(&ends[1].directions, self.back_stresses());
        let deviators = [deviator(&start), deviator(&end)];
        let flow =
            FlowStep { law: &self.constants, rule, shear: self.shear, dt, strains: deviators, back, alpha: kept.alpha }.flow(with_slopes);
        Step { kept, ends, turn, strains: [start, end], back, flow }
    }

    /// Stresses at the start of the flow and at the end of the step.
    #[inline(always)]
    fn stresses<const FMA: bool, const S: usize>(&self, step: &Step<FMA, S>) -> [[Lanes<FMA>; S]; 2] {
        let change = plus(&step.strains[0], Lanes::splat(-1.0), &step.strains[1]);
        let before = plus(&change, step.flow.share, &step.strains[0]);
        [self.elastic(&before), self.elastic(&plus(&step.flow.strain, Lanes::splat(-1.0), &step.strains[1]))]
    }

    /// Stress of a step of the kind `of`, and its derivative with respect to the strain at the end.
    #[inline(always)]
    fn respond<const FMA: bool, const S: usize>(&self, of: StressOf, step: &Step<FMA, S>) -> Response<S> {
        let [before, after] = self.stresses(step);
        let (stress, tangent) = if of == StressOf::Step { self.of_step(step, &before, &after) } else { self.at_end(step, &after) };
        let map = congruence::<FMA, S>(&step.kept.reference_map(&step.ends[1].directions));
        let (stress, mut tangent) = (applied(&map, &stress), product_with_transpose(&product(&map, &tangent), &map));
        // dS/dE = 2 dS/dC.
        let factor = if of == StressOf::Middle { 1.0 } else { 2.0 };
        tangent.iter_mut().flatten().for_each(|entry| *entry = *entry * factor);
        Response { stress: relabel(&stress), tangent: relabel_rows(&tangent) }
    }

    /// Mean stress of the step, and its derivative with respect to `C_1`, in the principal directions of the end.
    #[inline(always)]
    fn of_step<const FMA: bool, const S: usize>(
        &self,
        step: &Step<FMA, S>,
        before: &[Lanes<FMA>; S],
        after: &[Lanes<FMA>; S],
    ) -> ([Lanes<FMA>; S], [[Lanes<FMA>; S]; S]) {
        let share = step.flow.share;
        let mut mean = plus(&self.elastic(&step.strains[0]), share, before);
        mean = times(&plus(after, -share + 1.0, &mean), Lanes::splat(0.5));
        let stretches = [&step.ends[0].squares, &step.ends[1].squares];
        let adjoint = symmetric_map::<FMA, S>(&adjoint::<FMA, S>(stretches, &step.turn));
        let slopes = self.mean_slopes(step);
        let mut tangent = product(&adjoint, &by_square(&slopes, stretches[1]));
        let curved = symmetric_map::<FMA, S>(&curvature::<FMA, S>(stretches, &step.turn, &matrix(&mean)));
        for k in 0..S {
            tangent[k] = plus(&curved[k], Lanes::splat(1.0), &tangent[k]);
        }
        (applied(&adjoint, &mean), tangent)
    }

    /// Derivative of the mean stress with respect to the logarithmic strain at the end.
    #[inline(always)]
    fn mean_slopes<const FMA: bool, const S: usize>(&self, step: &Step<FMA, S>) -> [[Lanes<FMA>; S]; S] {
        let Some(Slopes { share: share_slope, by_end, by_start, .. }) = &step.flow.slopes else { return [[Lanes::ZERO; S]; S] };
        let (share, left) = (step.flow.share, -step.flow.share + 1.0);
        let along = times(&self.along_share(step), left);
        let along = plus(&step.flow.strain, Lanes::splat(2.0 * self.shear), &along);
        let mut slopes = [[Lanes::ZERO; S]; S];
        for k in 0..rows::<S>() {
            for l in 0..S {
                let plastic = left * (share.mul_add(by_start[k][l], by_end[k][l]));
                slopes[k][l] = (along[k].mul_add(share_slope[l], self.modulus(k, l) - plastic)) * 0.5;
            }
        }
        slopes
    }

    /// Derivative of the stress at the end with respect to the elastic fraction of the step.
    #[inline(always)]
    fn along_share<const FMA: bool, const S: usize>(&self, step: &Step<FMA, S>) -> [Lanes<FMA>; S] {
        let change = plus(&step.strains[0], Lanes::splat(-1.0), &step.strains[1]);
        if let Some(slopes) = &step.flow.slopes { slopes.along_share(&change) } else { [Lanes::ZERO; S] }
    }

    /// The stress at the end on `C`, and its derivative with respect to `C_1`, in principal directions of the end.
    #[inline(always)]
    fn at_end<const FMA: bool, const S: usize>(
        &self,
        step: &Step<FMA, S>,
        after: &[Lanes<FMA>; S],
    ) -> ([Lanes<FMA>; S], [[Lanes<FMA>; S]; S]) {
        let squares = &step.ends[1].squares;
        let (mut slopes, mut stress) = ([[Lanes::ZERO; S]; S], *after);
        if let Some(Slopes { share: share_slope, by_end, by_start, .. }) = &step.flow.slopes {
            let along = self.along_share(step);
            for k in 0..rows::<S>() {
                for l in 0..S {
                    let plastic = step.flow.share.mul_add(by_start[k][l], by_end[k][l]);
                    slopes[k][l] = along[k].mul_add(share_slope[l], self.modulus(k, l) - plastic);
                }
            }
        }
        let mut tangent = by_square(&slopes, squares);
        let (one, zero) = (Lanes::splat(1.0), Lanes::ZERO);
        let still = [[one, zero, zero], [zero, one, zero], [zero, zero, one]];
        let curved = symmetric_map::<FMA, S>(&curvature::<FMA, S>([squares, squares], &still, &matrix(after)));
        for (row, &(i, j)) in mandel_pairs::<S>().iter().enumerate() {
            let quotient = first_difference(squares[i], squares[j]);
            stress[row] = stress[row] * quotient;
            for l in 0..S {
                tangent[row][l] = quotient.mul_add(tangent[row][l], curved[row][l] + curved[l][row]);
            }
        }
        (stress, tangent)
    }

    /// Entry `(k, l)` of the elastic stiffness of Hencky's law.
    #[inline(always)]
    fn modulus<const FMA: bool>(&self, k: usize, l: usize) -> Lanes<FMA> {
        let direct = if k < 3 && l < 3 { self.bulk - 2.0 / 3.0 * self.shear } else { 0.0 };
        Lanes::splat(direct + if k == l { 2.0 * self.shear } else { 0.0 })
    }

    /// History variables after a step, and its heat.
    #[inline(always)]
    fn advance<const FMA: bool, const S: usize>(
        &self,
        of: StressOf,
        step: &Step<FMA, S>,
        history: &[Lanes<false>],
        after: &mut [Lanes<false>],
    ) -> Lanes<false> {
        let Step { kept, ends: [_, stretches], flow, .. } = step;
        if flow.multiplier.0.iter().all(|multiplier| *multiplier == 0.0) {
            after.copy_from_slice(history);
            return Lanes::ZERO;
        }
        let [before, last] = self.stresses(step);
        // Stress that does the plastic work: the mean of the stresses at the start and end of the flow or, with [`StressOf::End`], the
        // stress at the end.
        let of_start = if of == StressOf::End { 0.0 } else { 0.5 };
        let acting = plus(&before, Lanes::splat(of_start), &times(&last, Lanes::splat(1.0 - of_start)));
        let mut heat = dot(&acting, &flow.strain);
        for (k, constants) in self.constants.back_stresses.iter().enumerate() {
            let gained = plus(&step.back[k], Lanes::splat(-1.0), &flow.back[k]);
            let acting = plus(&step.back[k], Lanes::splat(of_start), &times(&flow.back[k], Lanes::splat(1.0 - of_start)));
            heat = heat - dot(&acting, &gained) * constants.factor();
        }
        let elastic = plus(&flow.strain, Lanes::splat(-1.0), &step.strains[1]);
        let mut moved = PlasticPoint {
            frame: kept.moved_frame(stretches, &elastic),
            alpha: flow.multiplier.mul_add(Lanes::splat(super::flow::ROOT), kept.alpha),
            heat: kept.heat + heat,
            back: kept.back,
        };
        if self.back_stresses() > 0 {
            let map = congruence::<FMA, S>(&stretches.directions);
            moved.back.iter_mut().zip(&flow.back).take(self.back_stresses()).for_each(|(back, turned)| *back = applied_back(&map, turned));
        }
        moved.write(after);
        for lane in 0..heat.0.len() {
            if flow.multiplier.0[lane] == 0.0 {
                heat.0[lane] = 0.0;
                after.iter_mut().zip(history).for_each(|(after, before)| after.0[lane] = before.0[lane]);
            }
        }
        Lanes(heat.0)
    }

    /// Stored energy at a strain with history variables.
    #[inline(always)]
    fn energy<const FMA: bool, const S: usize>(&self, strain: &Components<S>, history: &[Lanes<false>]) -> Lanes<false> {
        let kept = PlasticPoint::<FMA, S>::read(history, self.back_stresses());
        let Stretches { logarithms, .. } = kept.stretches(strain);
        let volume = trace(&logarithms);
        let shape = deviator(&logarithms);
        let mut energy = volume * volume * (0.5 * self.bulk) + dot(&shape, &shape) * self.shear;
        for (back, constants) in kept.back.iter().zip(&self.constants.back_stresses) {
            energy = energy + dot(back, back) * (0.5 * constants.factor());
        }
        Lanes(energy.0)
    }

    /// Second Piola-Kirchhoff stress at a strain with history variables.
    #[inline(always)]
    fn stress<const FMA: bool, const S: usize>(&self, strain: &Components<S>, history: &[Lanes<false>]) -> Components<S> {
        let kept = PlasticPoint::<FMA, S>::read(history, self.back_stresses());
        let stretches = kept.stretches(strain);
        let mut logarithm = [Lanes::ZERO; S];
        logarithm[..3].copy_from_slice(&stretches.logarithms);
        let mut stress = self.elastic(&logarithm);
        for i in 0..3 {
            stress[i] = stress[i] / stretches.squares[i];
        }
        relabel(&applied(&congruence::<FMA, S>(&kept.reference_map(&stretches.directions)), &stress))
    }
}

/// Converts a derivative with respect to the logarithmic strain into one with respect to `C_1`, in the principal directions of `C_1`: `d
/// eps_ij = ln[c_i, c_j]/2 dC_ij`.
#[inline(always)]
fn by_square<const FMA: bool, const S: usize>(slopes: &[[Lanes<FMA>; S]; S], squares: &[Lanes<FMA>; 3]) -> [[Lanes<FMA>; S]; S] {
    let mut result = *slopes;
    for &(i, j) in &mandel_pairs::<S>() {
        let half = first_difference(squares[i], squares[j]) * 0.5;
        for row in &mut result {
            row[place(i, j)] = row[place(i, j)] * half;
        }
    }
    result
}

/// Results of the steps of all points. One kernel computes both, because strains and flow are most of what is compiled.
enum Results<'a, const S: usize> {
    /// Stresses with their derivatives.
    Responses(&'a mut [Response<S>]),
    /// History variables after the steps, and heat.
    After(&'a mut [Lanes<false>], &'a mut [Heat]),
}

struct Steps<'a, 'b, const S: usize>(&'a PlasticLaw, &'a StrainStep<'b, S>, Results<'a, S>);
struct Energies<'a, const S: usize>(&'a PlasticLaw, &'a [Components<S>], &'a [Lanes<false>], &'a mut [Lanes<false>]);
struct Stresses<'a, const S: usize>(&'a PlasticLaw, &'a [Components<S>], &'a [Lanes<false>], &'a mut [Components<S>]);

impl<const S: usize> Kernel for Steps<'_, '_, S> {
    type Output = ();
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Steps(law, at, mut results) = self;
        let variables = variables::<S>(law.back_stresses());
        let (count, with_slopes) = match &results {
            Results::Responses(responses) => (responses.len(), true),
            Results::After(_, heat) => (heat.len(), false),
        };
        for point in 0..count {
            let history = at.history_of(point, variables);
            let (end, dt) = match at.stress {
                StressOf::Middle if with_slopes => (&at.middle[point], 0.5 * at.dt),
                _ => (&at.end[point], at.dt),
            };
            let rule = if at.stress == StressOf::End { Rule::RadialReturn } else { Rule::Fitted };
            let step = law.step::<FMA, S>([&at.start[point], end], history, (dt, rule), with_slopes);
            match &mut results {
                Results::Responses(responses) => responses[point] = law.respond(at.stress, &step),
                Results::After(after, heat) => {
                    let after = &mut after[point * variables..][..variables];
                    heat[point].plastic = law.advance(at.stress, &step, history, after);
                }
            }
        }
    }
}

impl<const S: usize> Kernel for Energies<'_, S> {
    type Output = ();
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Energies(law, strains, history, energies) = self;
        let histories = history.chunks_exact(variables::<S>(law.back_stresses()));
        for ((strain, history), energy) in strains.iter().zip(histories).zip(energies) {
            *energy = law.energy::<FMA, S>(strain, history);
        }
    }
}

impl<const S: usize> Kernel for Stresses<'_, S> {
    type Output = ();
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Stresses(law, strains, history, stresses) = self;
        let histories = history.chunks_exact(variables::<S>(law.back_stresses()));
        for ((strain, history), stress) in strains.iter().zip(histories).zip(stresses) {
            *stress = law.stress::<FMA, S>(strain, history);
        }
    }
}

macro_rules! history_law {
    ($size:literal) => {
        impl HistoryLaw<$size> for PlasticLaw {
            fn variables(&self) -> usize {
                variables::<$size>(self.back_stresses())
            }
            fn responses_into(&self, step: &StrainStep<$size>, responses: &mut [Response<$size>]) {
                dispatch(Steps(self, step, Results::Responses(responses)));
            }
            fn advance_into(&self, step: &StrainStep<$size>, after: &mut [Lanes<false>], heat: &mut [Heat]) {
                dispatch(Steps(self, step, Results::After(after, heat)));
            }
            fn energies_into(&self, strain: &[Components<$size>], history: &[Lanes<false>], energies: &mut [Lanes<false>]) {
                dispatch(Energies(self, strain, history, energies));
            }
            fn stresses_into(&self, strain: &[Components<$size>], history: &[Lanes<false>], stresses: &mut [Components<$size>]) {
                dispatch(Stresses(self, strain, history, stresses));
            }
            fn shown(&self, history: &[Lanes<false>], lane: usize) -> Option<PointHistory> {
                let kept = PlasticPoint::<false, $size>::read(history, self.back_stresses());
                let mut back = [0.0; $size];
                for (strain, constants) in kept.back.iter().zip(&self.constants.back_stresses) {
                    back.iter_mut().zip(strain).for_each(|(sum, component)| *sum += constants.factor() * component.0[lane]);
                }
                let back_stress = (1.5 * back.iter().map(|x| x * x).sum::<f64>()).sqrt();
                Some(PointHistory { plastic_strain: kept.alpha.0[lane], heat: kept.heat.0[lane], back_stress })
            }
        }
    };
}

history_law!(4);
history_law!(6);
