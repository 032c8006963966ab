//! Energy given as text, as a law for the element loop: variables, tape, stress and tangent.
//!
//! Blocks of points pass through three kernels: strains to variables, the tape, variables to stress and tangent. The remainder of the
//! discrete gradient follows from the energy change over the step, which the tape computes without cancellation.

use std::cell::RefCell;
use std::hint::black_box;

use super::graph::{Graph, Id};
use super::small_strain::{Sizes, simpson, work};
use super::spectrum::Spectrum;
use super::state::Variables;
use super::tape::{Block, POINTS, Tape};
use crate::materials::batched::{BatchedLaw, Components, IncrementResponse, Response};
use crate::math::lanes::{Lanes, Real, relabel, relabel_rows};
use crate::math::simd::{Kernel, dispatch};
use crate::math::tensor::Mandel;
use crate::math::tolerances::RESIDUAL_STRESS;

/// Buffers of a thread for tapes and principal stretches.
struct Scratch {
    registers: Vec<Block>,
    spectra: Vec<Spectrum<false>>,
}

thread_local! {
    static SCRATCH: RefCell<Scratch> = const { RefCell::new(Scratch { registers: Vec::new(), spectra: Vec::new() }) };
}

/// Runs a computation with `count` registers of a block, and buffers for principal stretches.
pub(super) fn with_scratch(count: usize, spectra: usize, compute: impl FnOnce(&mut [Block], &mut [Spectrum<false>])) {
    SCRATCH.with_borrow_mut(|scratch| {
        if scratch.registers.len() < count {
            scratch.registers.resize(count, [Lanes::ZERO; POINTS]);
        }
        if scratch.spectra.len() < spectra {
            scratch.spectra.resize(spectra, Spectrum::ZERO);
        }
        compute(&mut scratch.registers[..count], &mut scratch.spectra[..spectra]);
    });
}

/// Energy of a graph node as a law of strains with `S` components.
pub(crate) struct EnergyLaw<const S: usize> {
    variables: Variables<S>,
    /// Tape with the stages [`ENERGY`], [`SLOPES`] and [`RESPONSE`], whose roots are the energy and its first and second derivatives with
    /// respect to the variables.
    tape: Tape,
    /// Nonzero second derivatives: two variables and the root.
    seconds: Vec<(usize, usize, usize)>,
    /// Stress at zero strain beyond round-off, in Mandel components.
    residual: [f64; S],
}

/// Stage of the tape that computes the energy.
pub(super) const ENERGY: usize = 0;
/// Stage of the tape that computes energy and first derivatives.
pub(super) const SLOPES: usize = 1;
/// Stage of the tape that computes energy, first and second derivatives.
const RESPONSE: usize = 2;

impl<const S: usize> EnergyLaw<S> {
    pub(super) fn new(graph: &mut Graph, energy: Id, fibers: &[[f64; 3]]) -> Self {
        let all = graph.variables(energy);
        let slopes: Vec<Id> = all.iter().map(|&variable| graph.derivative(energy, variable)).collect();
        let (mut pairs, mut seconds) = (Vec::new(), Vec::new());
        for k in 0..all.len() {
            for l in k..all.len() {
                pairs.push((k, l, 1 + slopes.len() + seconds.len()));
                seconds.push(graph.derivative(slopes[k], all[l]));
            }
        }
        let tape = Tape::new(graph, &all, &[&[energy], &slopes, &seconds]);
        let variables = Variables::new(all, fibers);
        let seconds = pairs.into_iter().filter(|(.., root)| !tape.roots[*root].is_zero()).collect();
        let mut residual = [0.0; S];
        for s in 0..S {
            let terms = || tape.roots[1..].iter().zip(&variables.slopes_at_rest).map(|(root, slope)| root.rest * slope[s]);
            let (sum, size) = (terms().sum::<f64>(), terms().map(f64::abs).sum::<f64>());
            residual[s] = if sum.abs() > RESIDUAL_STRESS * size { sum } else { 0.0 };
        }
        EnergyLaw { variables, tape, seconds, residual }
    }
}

/// Runs a tape up to a stage, from its beginning or from an earlier stage.
pub(super) struct Run<'a> {
    pub(super) tape: &'a Tape,
    pub(super) stage: usize,
    pub(super) points: usize,
    pub(super) start: Option<&'a [Block]>,
    pub(super) registers: &'a mut [Block],
}

impl Kernel for Run<'_> {
    type Output = ();
    #[inline(always)]
    fn run<const FMA: bool>(self) {
        match self.start {
            None => self.tape.deviations::<FMA>(self.stage, self.points, self.registers),
            Some(start) => self.tape.changes::<FMA>(self.stage, self.points, start, self.registers),
        }
    }
}

/// Writes the variables of the energy (such as invariants) for a block of strains to the registers of its tape.
struct Load<'a, const S: usize> {
    law: &'a EnergyLaw<S>,
    strains: &'a [Components<S>],
    registers: &'a mut [Block],
    spectra: &'a mut [Spectrum<false>],
}

/// Writes the changes of the energy's variables between two blocks of strains to the registers of its tape.
struct LoadChanges<'a, const S: usize> {
    law: &'a EnergyLaw<S>,
    from: &'a [Components<S>],
    to: &'a [Components<S>],
    at_start: &'a [Block],
    spectra: &'a [Spectrum<false>],
    registers: &'a mut [Block],
}

/// Evaluated block of the tape, and the results assembled from it.
struct Finish<'a, 'b, const S: usize, T> {
    law: &'a EnergyLaw<S>,
    strains: &'a [Components<S>],
    spectra: &'a [Spectrum<false>],
    registers: &'a [Block],
    results: &'a mut [&'b mut T],
}

/// Principal stretches of a point, for laws that depend on them.
#[inline(always)]
fn spectrum_of<const FMA: bool>(spectra: &[Spectrum<false>], n: usize) -> Option<Spectrum<FMA>> {
    spectra.get(n).map(Spectrum::relabel)
}

macro_rules! law {
    ($size:literal) => {
        impl Kernel for Load<'_, $size> {
            type Output = ();
            #[inline(always)]
            fn run<const FMA: bool>(self) {
                let Load { law, strains, registers, spectra } = self;
                for n in 0..black_box(strains.len()).min(POINTS) {
                    let strain = Mandel(relabel(&strains[n]));
                    let state = law.variables.state::<FMA>(strain);
                    if law.variables.has_principal {
                        let spectrum = Spectrum::<FMA>::new(&strain);
                        spectra[n] = spectrum.relabel();
                        law.variables.deviations_into(&state, Some(&spectrum), registers, n);
                    } else {
                        law.variables.deviations_into(&state, None, registers, n);
                    }
                }
            }
        }

        impl Kernel for LoadChanges<'_, $size> {
            type Output = ();
            #[inline(always)]
            fn run<const FMA: bool>(self) {
                let LoadChanges { law, from, to, at_start, spectra, registers } = self;
                for n in 0..black_box(from.len()).min(POINTS) {
                    let start = law.variables.known_state::<FMA>(&from[n], at_start, n);
                    let end = law.variables.state::<FMA>(Mandel(relabel(&to[n])));
                    match spectrum_of::<FMA>(spectra, n) {
                        Some(from) => {
                            let to = Spectrum::<FMA>::new(&end.strain);
                            law.variables.changes_into([&start, &end], Some([&from, &to]), registers, n);
                        }
                        None => law.variables.changes_into([&start, &end], None, registers, n),
                    }
                }
            }
        }

        impl Kernel for Finish<'_, '_, $size, Components<$size>> {
            type Output = ();
            #[inline(always)]
            fn run<const FMA: bool>(self) {
                let Finish { law, strains, spectra, registers, results } = self;
                for n in 0..black_box(strains.len()).min(POINTS) {
                    let state = law.variables.known_state::<FMA>(&strains[n], registers, n);
                    let spectrum = spectrum_of::<FMA>(spectra, n);
                    let mut stress = law.stress_at_rest::<FMA>();
                    for k in 0..law.variables.all.len() {
                        let variation = law.variables.slope_variation(k, &state, spectrum.as_ref());
                        law.add_stress(k, variation.as_ref(), (registers, n), &mut stress);
                    }
                    *results[n] = relabel(&stress.0);
                }
            }
        }

        impl Kernel for Finish<'_, '_, $size, Response<$size>> {
            type Output = ();
            #[inline(always)]
            fn run<const FMA: bool>(self) {
                let Finish { law, strains, spectra, registers, results } = self;
                let count = law.variables.all.len();
                // Room for the derivatives of the variables that most laws have; others are computed again.
                let mut slopes = [Mandel([Lanes::<FMA>::ZERO; $size]); KEPT];
                for n in 0..black_box(strains.len()).min(POINTS) {
                    let state = law.variables.known_state::<FMA>(&strains[n], registers, n);
                    let spectrum = spectrum_of::<FMA>(spectra, n);
                    let (mut stress, mut tangent) = (law.stress_at_rest::<FMA>(), [[Lanes::<FMA>::ZERO; $size]; $size]);
                    for k in 0..count {
                        let variation = law.variables.slope_variation(k, &state, spectrum.as_ref());
                        law.add_stress(k, variation.as_ref(), (registers, n), &mut stress);
                        let slope = law.slope(k, variation);
                        let weight = law.tape.roots[1 + k].value(registers, n);
                        law.variables.add_curvature(k, (&state, spectrum.as_ref()), &slope, weight, &mut tangent);
                        if k < KEPT {
                            slopes[k] = slope;
                        }
                    }
                    for &(k, l, root) in &law.seconds {
                        let weight = law.tape.roots[root].value(registers, n);
                        let (mut a, mut b) = (slopes[k.min(KEPT - 1)], slopes[l.min(KEPT - 1)]);
                        if k >= KEPT {
                            a = law.slope(k, law.variables.slope_variation(k, &state, spectrum.as_ref()));
                        }
                        if l >= KEPT {
                            b = law.slope(l, law.variables.slope_variation(l, &state, spectrum.as_ref()));
                        }
                        add_product(&a, &b, weight, k == l, &mut tangent);
                    }
                    *results[n] = Response { stress: relabel(&stress.0), tangent: relabel_rows(&tangent) };
                }
            }
        }

        impl EnergyLaw<$size> {
            /// Runs the tape up to a stage at some strains.
            fn run_at<const N: usize>(
                &self,
                stage: usize,
                strains: &[Components<$size>; N],
                registers: &mut [Block],
                spectra: &mut [Spectrum<false>],
            ) {
                dispatch(Load { law: self, strains, registers, spectra });
                dispatch(Run { tape: &self.tape, stage, points: N, start: None, registers });
            }

            fn energy_block<const N: usize>(&self, strains: &[Components<$size>; N], energy: &mut [Lanes<false>; N]) {
                let sizes = Sizes::of([strains], self.tape.has_kinks_near_rest());
                if sizes.has_large() {
                    with_scratch(self.tape.registers(), self.spectra::<N>(), |registers, spectra| {
                        self.run_at(ENERGY, strains, registers, spectra);
                        for n in 0..N {
                            energy[n] = self.tape.roots[0].deviation(registers, n).unwrap_or(Lanes::ZERO);
                        }
                    });
                }
                if sizes.has_small() {
                    let half = strains.map(|strain| strain.map(|component| component * 0.5));
                    let [mut at_half, mut at_end] = [[[Lanes::ZERO; $size]; N]; 2];
                    self.stress_block(&half, &mut at_half);
                    self.stress_block(strains, &mut at_end);
                    for n in 0..N {
                        let at_rest = self.stress_at_rest().0;
                        let mean = std::array::from_fn(|s| simpson([at_rest[s], at_half[n][s], at_end[n][s]]));
                        energy[n] = sizes.select(n, work(&mean, &strains[n]), energy[n]);
                    }
                }
            }

            fn stress_block<const N: usize>(&self, strains: &[Components<$size>; N], results: &mut [Components<$size>; N]) {
                with_scratch(self.tape.registers(), self.spectra::<N>(), |registers, spectra| {
                    self.run_at(SLOPES, strains, registers, spectra);
                    dispatch(Finish { law: self, strains, spectra, registers, results: &mut results.each_mut() });
                });
            }

            fn response_block<const N: usize>(&self, strains: &[Components<$size>; N], results: &mut [Response<$size>; N]) {
                with_scratch(self.tape.registers(), self.spectra::<N>(), |registers, spectra| {
                    self.run_at(RESPONSE, strains, registers, spectra);
                    dispatch(Finish { law: self, strains, spectra, registers, results: &mut results.each_mut() });
                });
            }

            /// Stress and tangent at the mean strain, stress at the end, and energy change minus the work of the mean-strain stress. The
            /// change is computed from the end, where the tape has been run for the stress; for small strains, by the stress at the start.
            fn increment_block<const N: usize>(
                &self,
                strain_n: &[Components<$size>; N],
                strain_n1: &[Components<$size>; N],
                increments: &mut [IncrementResponse<$size>; N],
            ) {
                let (mut mid, mut step, sizes) = (*strain_n, *strain_n, Sizes::of([strain_n, strain_n1], self.tape.has_kinks_near_rest()));
                for n in 0..N {
                    for s in 0..$size {
                        mid[n][s] = (strain_n[n][s] + strain_n1[n][s]) * 0.5;
                        step[n][s] = strain_n1[n][s] - strain_n[n][s];
                    }
                }
                let count = self.tape.registers();
                with_scratch(2 * count, self.spectra::<N>(), |registers, spectra| {
                    let (registers, changes) = registers.split_at_mut(count);
                    self.run_at(RESPONSE, &mid, registers, spectra);
                    let results = &mut increments.each_mut().map(|increment| &mut increment.mean);
                    dispatch(Finish { law: self, strains: &mid, spectra, registers, results });
                    self.run_at(SLOPES, strain_n1, registers, spectra);
                    let results = &mut increments.each_mut().map(|increment| &mut increment.stress_end);
                    dispatch(Finish { law: self, strains: strain_n1, spectra, registers, results });
                    if sizes.has_large() {
                        let (from, to) = (strain_n1, strain_n);
                        dispatch(LoadChanges { law: self, from, to, at_start: registers, spectra, registers: changes });
                        dispatch(Run { tape: &self.tape, stage: ENERGY, points: N, start: Some(registers), registers: changes });
                        for n in 0..N {
                            let back = self.tape.roots[0].deviation(changes, n).unwrap_or(Lanes::ZERO);
                            increments[n].remainder = -work(&increments[n].mean.stress, &step[n]) - back;
                        }
                    }
                    if sizes.has_small() && !self.has_kinks() {
                        let mut at_start = [[Lanes::ZERO; $size]; N];
                        self.run_at(SLOPES, strain_n, registers, spectra);
                        dispatch(Finish { law: self, strains: strain_n, spectra, registers, results: &mut at_start.each_mut() });
                        for n in 0..N {
                            let IncrementResponse { mean: Response { stress, .. }, stress_end, remainder } = &increments[n];
                            let beyond = |s: usize| simpson([at_start[n][s] - stress[s], Lanes::ZERO, stress_end[s] - stress[s]]);
                            increments[n].remainder = sizes.select(n, work(&std::array::from_fn(beyond), &step[n]), *remainder);
                        }
                    }
                });
                // No quadrature along the step applies to a slope that jumps at zero strain; along rays from there it does.
                if sizes.has_small() && self.has_kinks() {
                    let [mut at_start, mut at_end] = [[Lanes::ZERO; N]; 2];
                    self.energy_block(strain_n, &mut at_start);
                    self.energy_block(strain_n1, &mut at_end);
                    for n in 0..N {
                        let remainder = at_end[n] - at_start[n] - work(&increments[n].mean.stress, &step[n]);
                        increments[n].remainder = sizes.select(n, remainder, increments[n].remainder);
                    }
                }
            }
        }

        impl BatchedLaw<$size> for EnergyLaw<$size> {
            fn energies_into(&self, strain: &[Components<$size>], energy: &mut [Lanes<false>]) {
                let ((strains, rest), (energies, last)) = (strain.as_chunks::<POINTS>(), energy.as_chunks_mut::<POINTS>());
                strains.iter().zip(energies).for_each(|(strain, energy)| self.energy_block(strain, energy));
                let (rest, last) = (rest.as_chunks::<1>().0, last.as_chunks_mut::<1>().0);
                rest.iter().zip(last).for_each(|(strain, energy)| self.energy_block(strain, energy));
            }

            fn stresses_into(&self, strain: &[Components<$size>], stress: &mut [Components<$size>]) {
                let ((strains, rest), (stresses, last)) = (strain.as_chunks::<POINTS>(), stress.as_chunks_mut::<POINTS>());
                strains.iter().zip(stresses).for_each(|(strain, stress)| self.stress_block(strain, stress));
                let (rest, last) = (rest.as_chunks::<1>().0, last.as_chunks_mut::<1>().0);
                rest.iter().zip(last).for_each(|(strain, stress)| self.stress_block(strain, stress));
            }

            fn responses_into(&self, strain: &[Components<$size>], responses: &mut [Response<$size>]) {
                let ((strains, rest), (answers, last)) = (strain.as_chunks::<POINTS>(), responses.as_chunks_mut::<POINTS>());
                strains.iter().zip(answers).for_each(|(strain, response)| self.response_block(strain, response));
                let (rest, last) = (rest.as_chunks::<1>().0, last.as_chunks_mut::<1>().0);
                rest.iter().zip(last).for_each(|(strain, response)| self.response_block(strain, response));
            }

            fn increments_into(
                &self,
                strain_n: &[Components<$size>],
                strain_n1: &[Components<$size>],
                increments: &mut [IncrementResponse<$size>],
            ) {
                let ((from, from_rest), (to, to_rest)) = (strain_n.as_chunks::<POINTS>(), strain_n1.as_chunks::<POINTS>());
                let (answers, last) = increments.as_chunks_mut::<POINTS>();
                from.iter().zip(to).zip(answers).for_each(|((n, n1), increment)| self.increment_block(n, n1, increment));
                let (from, to, last) = (from_rest.as_chunks::<1>().0, to_rest.as_chunks::<1>().0, last.as_chunks_mut::<1>().0);
                from.iter().zip(to).zip(last).for_each(|((n, n1), increment)| self.increment_block(n, n1, increment));
            }

            fn has_kinks(&self) -> bool {
                self.tape.has_kinks()
            }
        }
    };
}

/// Number of variables whose derivatives are stored during the assembly of a tangent.
const KEPT: usize = 4;

law!(3);
law!(4);
law!(6);

impl<const S: usize> EnergyLaw<S> {
    /// Number of buffers for principal stretches that a block needs.
    fn spectra<const N: usize>(&self) -> usize {
        if self.variables.has_principal { N } else { 0 }
    }

    #[inline(always)]
    fn stress_at_rest<const FMA: bool>(&self) -> Mandel<Lanes<FMA>, S> {
        let mut stress = [Lanes::ZERO; S];
        for s in 0..S {
            stress[s] = Lanes::splat(self.residual[s]);
        }
        Mandel(stress)
    }

    /// Derivative of a variable from its variation.
    #[inline(always)]
    fn slope<const FMA: bool>(&self, k: usize, variation: Option<Mandel<Lanes<FMA>, S>>) -> Mandel<Lanes<FMA>, S> {
        let mut slope = match variation {
            Some(variation) => variation,
            None => Mandel([Lanes::ZERO; S]),
        };
        for s in 0..S {
            slope.0[s] = slope.0[s] + self.variables.slopes_at_rest[k][s];
        }
        slope
    }

    /// Adds the contribution of a variable to the stress, without the stress at zero strain.
    #[inline(always)]
    fn add_stress<const FMA: bool>(
        &self,
        k: usize,
        variation: Option<&Mandel<Lanes<FMA>, S>>,
        (registers, n): (&[Block], usize),
        stress: &mut Mandel<Lanes<FMA>, S>,
    ) {
        let root = &self.tape.roots[1 + k];
        if let Some(variation) = variation {
            let weight = root.value::<FMA>(registers, n);
            for s in 0..S {
                stress.0[s] = variation.0[s].mul_add(weight, stress.0[s]);
            }
        }
        if let Some(deviation) = root.deviation::<FMA>(registers, n) {
            for s in 0..S {
                stress.0[s] = deviation.mul_add(Lanes::splat(self.variables.slopes_at_rest[k][s]), stress.0[s]);
            }
        }
    }
}

/// Adds `weight a a`, or `weight (a b + b a)` for two variables.
#[inline(always)]
fn add_product<const FMA: bool, const S: usize>(
    a: &Mandel<Lanes<FMA>, S>,
    b: &Mandel<Lanes<FMA>, S>,
    weight: Lanes<FMA>,
    is_square: bool,
    tangent: &mut [[Lanes<FMA>; S]; S],
) {
    for i in 0..S {
        let (left, right) = (a.0[i] * weight, b.0[i] * weight);
        for j in 0..S {
            tangent[i][j] = left.mul_add(b.0[j], tangent[i][j]);
            if !is_square {
                tangent[i][j] = right.mul_add(a.0[j], tangent[i][j]);
            }
        }
    }
}
