//! Variables of an energy at a strain and their derivatives, and the assembly of stress and tangent from these.
//!
//! With the derivative `W_k` of the energy by the variable `z_k`: `S = sum W_k z_k'`, `dS/dE = sum W_kl z_k' z_l' + sum W_k z_k''`.
//! Derivatives of variables are split into their value at rest and a variation: the contribution of values at rest with `W_k` at rest is
//! the stress at rest, known to be zero and omitted, so that small stresses are accurate.

use super::spectrum::{Principal, Spectrum};
use super::tape::Block;
use super::variable::Variable;
use crate::materials::batched::Components;
use crate::materials::volume::growth;
use crate::math::lanes::{Lanes, Real, relabel};
use crate::math::tensor::{Mandel, Tensor, mandel_pairs, mandel_scale};
use crate::math::tolerances::STRAIN_QUOTIENT;

/// Tensor of `S` Mandel components on lanes, a [`Tensor`] for each supported `S`.
pub(super) trait Strain<const FMA: bool, const S: usize>: Tensor<Scalar = Lanes<FMA>, Tangent = [[Lanes<FMA>; S]; S]> {}

impl<const FMA: bool> Strain<FMA, 3> for Mandel<Lanes<FMA>, 3> {}
impl<const FMA: bool> Strain<FMA, 4> for Mandel<Lanes<FMA>, 4> {}
impl<const FMA: bool> Strain<FMA, 6> for Mandel<Lanes<FMA>, 6> {}

/// The variables of an energy.
#[derive(Debug)]
pub(super) struct Variables<const S: usize> {
    pub(super) all: Vec<Variable>,
    /// Derivative of each variable with respect to the strain, at zero strain.
    pub(super) slopes_at_rest: Vec<[f64; S]>,
    /// Function of the principal stretches for each such variable; `None` for other variables.
    principal: Vec<Option<Principal>>,
    /// Index of the variable `J`, if present.
    volume: Option<usize>,
    /// True if at least one variable is a function of the principal stretches.
    pub(super) has_principal: bool,
}

/// Strain with its volume ratio.
#[derive(Clone, Copy)]
pub(super) struct State<const FMA: bool, const S: usize> {
    pub(super) strain: Mandel<Lanes<FMA>, S>,
    /// Change `J - 1` of the volume ratio.
    change: Lanes<FMA>,
    /// Inverse `1/J` of the volume ratio.
    inverse: Lanes<FMA>,
}

/// Function of the principal stretches of a variable; `None` for other variables.
fn principal(variable: Variable) -> Option<Principal> {
    match variable {
        Variable::StretchPower(exponent) => Some(Principal::Power(exponent.value())),
        Variable::LogStrainSquared => Some(Principal::LogSquared),
        _ => None,
    }
}

impl<const S: usize> Variables<S> {
    pub(super) fn new(all: Vec<Variable>, fibers: &[[f64; 3]]) -> Self {
        let pairs = mandel_pairs::<S>();
        let identity = |factor: f64| pairs.map(|(i, j)| if i == j { factor } else { 0.0 });
        let slope = |variable: &Variable| match *variable {
            Variable::I1 => identity(2.0),
            Variable::I2 => identity(4.0),
            Variable::J => identity(1.0),
            Variable::Fiber(index) => pairs.map(|(i, j)| 2.0 * fibers[index][i] * fibers[index][j] / mandel_scale(i, j)),
            Variable::Strain(component) => {
                let (i, j) = mandel_pairs::<6>()[component];
                pairs.map(|pair| if pair == (i, j) { mandel_scale(i, j) } else { 0.0 })
            }
            Variable::StretchPower(_) | Variable::LogStrainSquared => identity(principal(*variable).map_or(0.0, Principal::slope_at_rest)),
        };
        Variables {
            slopes_at_rest: all.iter().map(slope).collect(),
            volume: all.iter().position(|variable| *variable == Variable::J),
            has_principal: all.iter().any(|variable| principal(*variable).is_some()),
            principal: all.iter().map(|variable| principal(*variable)).collect(),
            all,
        }
    }

    /// Returns the state of a strain, computing its volume ratio if the energy depends on `J`.
    #[inline(always)]
    pub(super) fn state<const FMA: bool>(&self, strain: Mandel<Lanes<FMA>, S>) -> State<FMA, S>
    where
        Mandel<Lanes<FMA>, S>: Strain<FMA, S>,
    {
        let (mut change, mut inverse) = (Lanes::ZERO, Lanes::ZERO);
        if self.volume.is_some() {
            // J = sqrt(1 + x): J - 1 = x/(J + 1). One division for this and 1/J.
            let growth = growth(&strain);
            let root = (growth + 1.0).sqrt();
            let both = Lanes::splat(1.0) / (root * (root + 1.0));
            (change, inverse) = (growth * root * both, (root + 1.0) * both);
        }
        State { strain, change, inverse }
    }

    /// Returns the state of a strain whose variables are already in the registers of a tape.
    #[inline(always)]
    pub(super) fn known_state<const FMA: bool>(&self, strain: &Components<S>, registers: &[Block], n: usize) -> State<FMA, S> {
        let (mut change, mut inverse) = (Lanes::ZERO, Lanes::ZERO);
        if let Some(volume) = self.volume {
            (change, inverse) = (Lanes(registers[volume][n].0), Lanes(registers[self.all.len()][n].0) + 1.0);
        }
        State { strain: Mandel(relabel(strain)), change, inverse }
    }

    /// Writes the differences of all variables from their values at zero strain, followed by that of `1/J`.
    #[inline(always)]
    pub(super) fn deviations_into<const FMA: bool>(
        &self,
        state: &State<FMA, S>,
        spectrum: Option<&Spectrum<FMA>>,
        registers: &mut [Block],
        n: usize,
    ) where
        Mandel<Lanes<FMA>, S>: Strain<FMA, S>,
    {
        for k in 0..self.all.len() {
            registers[k][n] = Lanes(self.deviation(k, state, spectrum).0);
        }
        if self.volume.is_some() {
            registers[self.all.len()][n] = Lanes((-state.change * state.inverse).0);
        }
    }

    /// Writes the changes of all variables over a step, followed by that of `1/J`.
    #[inline(always)]
    pub(super) fn changes_into<const FMA: bool>(
        &self,
        states: [&State<FMA, S>; 2],
        spectra: Option<[&Spectrum<FMA>; 2]>,
        registers: &mut [Block],
        n: usize,
    ) where
        Mandel<Lanes<FMA>, S>: Strain<FMA, S>,
    {
        for k in 0..self.all.len() {
            registers[k][n] = Lanes(self.change(k, states, spectra).0);
        }
        if let Some(volume) = self.volume {
            let change = Lanes::<FMA>(registers[volume][n].0);
            registers[self.all.len()][n] = Lanes((-change * (states[0].inverse * states[1].inverse)).0);
        }
    }

    /// Difference of a variable from its value at zero strain.
    #[inline(always)]
    fn deviation<const FMA: bool>(&self, k: usize, state: &State<FMA, S>, spectrum: Option<&Spectrum<FMA>>) -> Lanes<FMA>
    where
        Mandel<Lanes<FMA>, S>: Strain<FMA, S>,
    {
        match (self.all[k], self.principal[k], spectrum) {
            (_, Some(function), Some(spectrum)) => spectrum.sum(function),
            (Variable::J, ..) => state.change,
            (Variable::I2, ..) => state.strain.trace().mul_add(Lanes::splat(4.0), state.strain.second_invariant() * 4.0),
            _ => self.linear(k, &state.strain),
        }
    }

    /// Value of a variable that is linear in the strain.
    #[inline(always)]
    fn linear<const FMA: bool>(&self, k: usize, strain: &Mandel<Lanes<FMA>, S>) -> Lanes<FMA> {
        let mut sum = Lanes::ZERO;
        for s in 0..S {
            sum = strain.0[s].mul_add(Lanes::splat(self.slopes_at_rest[k][s]), sum);
        }
        sum
    }

    /// Change of a variable over a step, without cancellation: products at the mean strain, a quadrature for functions of principal
    /// stretches where the step is small.
    #[inline(always)]
    fn change<const FMA: bool>(&self, k: usize, [start, end]: [&State<FMA, S>; 2], spectra: Option<[&Spectrum<FMA>; 2]>) -> Lanes<FMA>
    where
        Mandel<Lanes<FMA>, S>: Strain<FMA, S>,
    {
        let (mid, d) = ((start.strain + end.strain) * 0.5, end.strain - start.strain);
        let second = mid.trace() * d.trace() - mid.dot(&d);
        match (self.all[k], self.principal[k], spectra) {
            (_, Some(function), Some(spectra)) => change_of_principal(function, spectra, &mid, &d),
            (Variable::J, ..) => {
                let third = mid.cofactor().dot(&d) + d.determinant() * 0.25;
                let growth = d.trace() * 2.0 + second * 4.0 + third * 8.0;
                growth / (start.change + end.change + 2.0)
            }
            (Variable::I2, ..) => d.trace() * 4.0 + second * 4.0,
            _ => self.linear(k, &d),
        }
    }

    /// Variation of the derivative of a variable from its value at zero strain; `None` if the derivative is constant.
    #[inline(always)]
    pub(super) fn slope_variation<const FMA: bool>(
        &self,
        k: usize,
        state: &State<FMA, S>,
        spectrum: Option<&Spectrum<FMA>>,
    ) -> Option<Mandel<Lanes<FMA>, S>>
    where
        Mandel<Lanes<FMA>, S>: Strain<FMA, S>,
    {
        let strain = &state.strain;
        match (self.all[k], self.principal[k], spectrum) {
            (_, Some(function), Some(spectrum)) => Some(spectrum.slope_variation(function)),
            // cof C / J - I
            (Variable::J, ..) => {
                let plane = (*strain * -2.0).plus_identity(strain.trace() * 2.0 - state.change);
                let all = if <Mandel<Lanes<FMA>, S> as Tensor>::PLANE { plane } else { plane + strain.cofactor() * 4.0 };
                Some(all * state.inverse)
            }
            (Variable::I2, ..) => Some((*strain * -4.0).plus_identity(strain.trace() * 4.0)),
            _ => None,
        }
    }

    /// Adds `weight` times the second derivative of a variable with the derivative `slope`.
    #[inline(always)]
    pub(super) fn add_curvature<const FMA: bool>(
        &self,
        k: usize,
        (state, spectrum): (&State<FMA, S>, Option<&Spectrum<FMA>>),
        slope: &Mandel<Lanes<FMA>, S>,
        weight: Lanes<FMA>,
        tangent: &mut [[Lanes<FMA>; S]; S],
    ) where
        Mandel<Lanes<FMA>, S>: Strain<FMA, S>,
    {
        match (self.all[k], self.principal[k], spectrum) {
            (_, Some(function), Some(spectrum)) => spectrum.add_curvature(function, weight, tangent),
            // With J' = J C^-1: (J' J' - 2 I_J') / J.
            (Variable::J, ..) => {
                let weight = weight * state.inverse;
                let added = Mandel::isotropic_tangent(weight, weight * -2.0, slope);
                for i in 0..S {
                    for j in 0..S {
                        tangent[i][j] = tangent[i][j] + added[i][j];
                    }
                }
            }
            // 4 (I I - identity of symmetric tensors)
            (Variable::I2, ..) => {
                let (weight, pairs) = (weight * 4.0, mandel_pairs::<S>());
                for i in 0..S {
                    for j in 0..S {
                        let is_direct = pairs[i].0 == pairs[i].1 && pairs[j].0 == pairs[j].1;
                        if is_direct && i != j {
                            tangent[i][j] = tangent[i][j] + weight;
                        } else if !is_direct && i == j {
                            tangent[i][j] = tangent[i][j] - weight;
                        }
                    }
                }
            }
            _ => {}
        }
    }
}

/// Change of `sum f(e_i)` from one spectrum to another: Gauss' rule of three points for the line integral of its derivative below a
/// change of the strain of 5e-3, the plain difference above.
#[inline(always)]
fn change_of_principal<const FMA: bool, const S: usize>(
    function: Principal,
    [from, to]: [&Spectrum<FMA>; 2],
    mid: &Mandel<Lanes<FMA>, S>,
    d: &Mandel<Lanes<FMA>, S>,
) -> Lanes<FMA>
where
    Mandel<Lanes<FMA>, S>: Strain<FMA, S>,
{
    let s = 0.5 * 0.6f64.sqrt();
    let mut line = d.trace() * function.slope_at_rest();
    for (place, weight) in [(-s, 5.0 / 18.0), (0.0, 8.0 / 18.0), (s, 5.0 / 18.0)] {
        line = line + Spectrum::new(&(*mid + *d * place)).slope_variation::<S>(function).dot(d) * weight;
    }
    let difference = to.sum(function) - from.sum(function);
    line + d.dot(d).if_above(STRAIN_QUOTIENT * STRAIN_QUOTIENT, difference - line)
}
