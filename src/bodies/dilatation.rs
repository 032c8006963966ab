//! Mean dilatation of an element in energy-momentum form.
//!
//! The energy of an element is `sum_g w_g W_d(C_g) + V U(theta)` with the mean volume ratio `theta = sum_g w_g J_g / V`. `J^2 = det C` is a
//! polynomial in the quadratic invariants `C`, so its discrete gradient is exact:
//!
//! ```text
//! plane  DG[J] = 2 cof(C_mid) / (J_0 + J_1)                                        C_mid = (C_0 + C_1)/2, with respect to E
//! space  DG[J] = 2 (cof C_0 + 4 cof C_mid + cof C_1) / (6 (J_0 + J_1))             Simpson's rule on a cubic
//! p = (U(theta_1) - U(theta_0)) / (theta_1 - theta_0),     S = DG[W_d] + p DG[J]
//! ```
//!
//! `S` is symmetric, so the angular momentum is kept, and `p` times the change of `theta` is that of `U`. (Mean dilatation: Nagtegaal,
//! Parks and Rice, CMAME 4, 1974; Simo, Taylor and Pister, CMAME 51, 1985. The conserving form is new here.)
//!
//! A linear dilatation is the same with more than one mode: `theta_g = sum_i phi_i(g) sum_h w_h phi_i(h) J_h / n_i` with polynomials
//! `phi_i` of degree 0 and 1 in the undeformed coordinates, orthogonal in the sums over the points of the cell, and `n_i = sum_h w_h
//! phi_i(h)^2`. The pressures that `theta` has at the points are projected likewise before they act, so that their work is that of `U`.
//! (Biquadratic displacements with a discontinuous linear pressure: Boffi and Gastaldi, International Journal for Numerical Methods in
//! Engineering 53, 2002.)

use super::batch::{MOST_POINTS, cast};
use crate::elements::GAUSS;
use crate::integrators::{Configuration, Derivative};
use crate::materials::{Components, VolumetricLaw};
use crate::math::lanes::{Lanes, Real, WIDTH};
use crate::math::tensor::mandel_place;
use crate::math::tolerances::{KINK_QUOTIENT, STRAIN_QUOTIENT};

/// Largest number of dilatation modes of a cell: a constant, and a slope in each direction.
pub(super) const MOST_MODES: usize = 4;

/// The modes of the dilatation of a batch of cells.
pub(super) struct Modes {
    /// Number of dilatation modes; 1 for the mean dilatation.
    pub(super) count: usize,
    /// Values of the dilatation modes at the quadrature points; the first mode is 1 everywhere.
    pub(super) values: [[Lanes<false>; MOST_POINTS]; MOST_MODES],
    /// Norms of the dilatation modes: sums of squared values times the volumes of the points.
    norms: [Lanes<false>; MOST_MODES],
}

impl Modes {
    /// Constant mode or, given the positions of the points (any origin), also a slope in each direction.
    pub(super) fn new<const D: usize>(volumes: &[Lanes<false>], places: Option<&[[Lanes<false>; D]]>) -> Self {
        let mut modes = Modes {
            count: 1,
            values: [[Lanes::splat(1.0); MOST_POINTS]; MOST_MODES],
            norms: [volumes.iter().fold(Lanes::ZERO, |sum, volume| sum + *volume); MOST_MODES],
        };
        // Gram-Schmidt orthogonalization: each coordinate minus its projections on the previous modes.
        for i in 0..places.map_or(0, |_| D) {
            let places = places.unwrap_or_default();
            let mut coordinate = [Lanes::ZERO; MOST_POINTS];
            (0..volumes.len()).for_each(|q| coordinate[q] = places[q][i]);
            let projected = modes.projected(volumes, |q| coordinate[q]);
            let mut norm = Lanes::ZERO;
            for q in 0..volumes.len() {
                modes.values[i + 1][q] = coordinate[q] - projected[q];
                norm = norm + volumes[q] * modes.values[i + 1][q] * modes.values[i + 1][q];
            }
            modes.norms[i + 1] = norm;
            modes.count = i + 2;
        }
        modes
    }

    /// Volume-weighted projection of a value at the points onto the modes, evaluated at the points.
    pub(super) fn projected(&self, volumes: &[Lanes<false>], value: impl Fn(usize) -> Lanes<false>) -> [Lanes<false>; MOST_POINTS] {
        let mut projected = [Lanes::ZERO; MOST_POINTS];
        for i in 0..self.count {
            let sum = (0..volumes.len()).fold(Lanes::ZERO, |sum, q| sum + volumes[q] * value(q) * self.values[i][q]);
            let factor = sum / self.norms[i];
            (0..volumes.len()).for_each(|q| projected[q] = projected[q] + factor * self.values[i][q]);
        }
        projected
    }

    /// Derivatives of the pressures of the modes with respect to their dilatations, from the derivatives `p'` at the points: `sum_h w_h
    /// p'_h phi_i(h) phi_j(h) / (n_i n_j)`.
    pub(super) fn slopes(
        &self,
        volumes: &[Lanes<false>],
        slopes: &[Lanes<false>; MOST_POINTS],
    ) -> [[Lanes<false>; MOST_MODES]; MOST_MODES] {
        let mut sums = [[Lanes::ZERO; MOST_MODES]; MOST_MODES];
        for i in 0..self.count {
            for j in 0..self.count {
                let product = |q: usize| volumes[q] * slopes[q] * self.values[i][q] * self.values[j][q];
                let sum = (0..volumes.len()).fold(Lanes::ZERO, |sum, q| sum + product(q));
                sums[i][j] = sum / (self.norms[i] * self.norms[j]);
            }
        }
        sums
    }
}

/// Pressure of a step, and its derivative with respect to `theta` at the configuration in which `theta` is evaluated.
#[derive(Clone, Copy)]
pub(super) struct Pressure {
    pub(super) value: Lanes<false>,
    pub(super) slope: Lanes<false>,
}

impl Pressure {
    pub(super) const ZERO: Self = Pressure { value: Lanes::ZERO, slope: Lanes::ZERO };

    /// `U'` and `U''` at a mean change of volume `theta - 1`.
    pub(super) fn at(law: &dyn VolumetricLaw, change: Lanes<false>) -> Self {
        let mut response = [[Lanes::ZERO; 2]];
        law.responses_into(&[change], &mut response);
        Pressure { value: response[0][0], slope: response[0][1] }
    }

    /// Discrete gradient of `U` and its derivative with respect to the end: Gauss quadrature of `U'` and `U''`, or the difference quotient
    /// in large steps or if `U''` may jump.
    pub(super) fn between(law: &dyn VolumetricLaw, from: Lanes<false>, to: Lanes<false>) -> Self {
        let step = to - from;
        let changes = GAUSS.map(|(s, _)| from + step * s);
        let mut responses = [[Lanes::ZERO; 2]; 5];
        law.responses_into(&changes, &mut responses);
        let mut pressure = Pressure { value: Lanes::ZERO, slope: Lanes::ZERO };
        for ((s, weight), [first, second]) in GAUSS.into_iter().zip(responses) {
            pressure.value = pressure.value + first * weight;
            pressure.slope = pressure.slope + second * (weight * s);
        }
        let least = if law.has_kinks() { KINK_QUOTIENT } else { STRAIN_QUOTIENT };
        if step.0.iter().any(|step| step.abs() > least) {
            let mut energies = [Lanes::ZERO; 2];
            law.energies_into(&[from, to], &mut energies);
            let end = Pressure::at(law, to).value;
            for lane in 0..WIDTH {
                let step = step.0[lane];
                let value = (energies[1].0[lane] - energies[0].0[lane]) / step;
                if step.abs() > least {
                    pressure.value.0[lane] = value;
                }
                if step.abs() > STRAIN_QUOTIENT {
                    pressure.slope.0[lane] = (end.0[lane] - value) / step;
                }
            }
        }
        pressure
    }
}

/// Discrete gradient `DG[J]` with respect to the strain, its derivative with respect to the strain at the trial configuration, and the
/// gradient `dJ/dE` there.
pub(super) struct VolumeRatio<const FMA: bool, const S: usize> {
    pub(super) gradient: [Lanes<FMA>; S],
    pub(super) hessian: [[Lanes<FMA>; S]; S],
    pub(super) trial: [Lanes<FMA>; S],
}

/// `C = I + 2 E`, all six components.
#[inline(always)]
fn stretch<const FMA: bool, const S: usize>(strain: &Components<S>) -> [Lanes<FMA>; 6] {
    let mut c = [Lanes::ZERO; 6];
    for k in 0..S {
        c[mandel_place::<S>(k)] = cast::<FMA>(strain[k]) * 2.0;
    }
    for component in c.iter_mut().take(3) {
        *component = *component + 1.0;
    }
    c
}

/// Cofactor of a symmetric tensor.
#[inline(always)]
fn cofactor<const FMA: bool, const S: usize>([xx, yy, zz, xy, yz, xz]: [Lanes<FMA>; 6]) -> [Lanes<FMA>; S] {
    let root = std::f64::consts::FRAC_1_SQRT_2;
    let all = [
        yy * zz - yz * yz * 0.5,
        xx * zz - xz * xz * 0.5,
        xx * yy - xy * xy * 0.5,
        xz * yz * root - xy * zz,
        xy * xz * root - yz * xx,
        xy * yz * root - xz * yy,
    ];
    let mut result = [Lanes::ZERO; S];
    for k in 0..S {
        result[k] = all[mandel_place::<S>(k)];
    }
    result
}

/// Derivative of the cofactor with respect to the tensor.
#[inline(always)]
fn cofactor_slope<const FMA: bool, const S: usize>([xx, yy, zz, xy, yz, xz]: [Lanes<FMA>; 6]) -> [[Lanes<FMA>; S]; S] {
    let (o, r) = (Lanes::ZERO, std::f64::consts::FRAC_1_SQRT_2);
    let all = [
        [o, zz, yy, o, -yz, o],
        [zz, o, xx, o, o, -xz],
        [yy, xx, o, -xy, o, o],
        [o, o, -xy, -zz, xz * r, yz * r],
        [-yz, o, o, xz * r, -xx, xy * r],
        [o, -xz, o, yz * r, xy * r, -yy],
    ];
    let mut result = [[Lanes::ZERO; S]; S];
    for k in 0..S {
        for l in 0..S {
            result[k][l] = all[mandel_place::<S>(k)][mandel_place::<S>(l)];
        }
    }
    result
}

impl<const FMA: bool, const S: usize> VolumeRatio<FMA, S> {
    /// Returns the volume ratio and its derivatives in a step: the discrete gradient between two strains with volume ratios less 1
    /// (`changes`), or the gradient at the strain in the `middle` or at the end.
    #[inline(always)]
    pub(super) fn new(
        derivative: Derivative,
        strains: [&Components<S>; 2],
        changes: [Lanes<FMA>; 2],
        middle: (&Components<S>, Lanes<FMA>),
    ) -> Self {
        match derivative {
            Derivative::DiscreteGradient => VolumeRatio::of_step(strains, changes),
            Derivative::Gradient(Configuration::Middle) => VolumeRatio::at(middle.0, middle.1, 0.5),
            Derivative::Gradient(Configuration::End) => VolumeRatio::at(strains[1], changes[1], 1.0),
        }
    }

    #[inline(always)]
    fn of_step(strains: [&Components<S>; 2], changes: [Lanes<FMA>; 2]) -> Self {
        let [c_0, c_1] = strains.map(stretch::<FMA, S>);
        let mut mid = c_0;
        for k in 0..6 {
            mid[k] = (c_0[k] + c_1[k]) * 0.5;
        }
        let inverse = Lanes::splat(1.0) / (changes[0] + changes[1] + 2.0);
        let per_end = Lanes::splat(1.0) / (changes[1] + 1.0);
        let (at_0, at_mid, at_1): ([_; S], [_; S], [_; S]) = (cofactor(c_0), cofactor(mid), cofactor(c_1));
        let (slope_mid, slope_1): ([[_; S]; S], [[_; S]; S]) = (cofactor_slope(mid), cofactor_slope(c_1));
        let (mut gradient, mut hessian, mut trial) = ([Lanes::ZERO; S], [[Lanes::ZERO; S]; S], [Lanes::ZERO; S]);
        for k in 0..S {
            gradient[k] = (at_0[k] + at_mid[k] * 4.0 + at_1[k]) * inverse * (1.0 / 3.0);
            trial[k] = at_1[k] * per_end;
        }
        for k in 0..S {
            for l in 0..S {
                // dC_mid = dE_1, dC_1 = 2 dE_1.
                let slope = (slope_mid[k][l] * 4.0 + slope_1[k][l] * 2.0) * inverse * (1.0 / 3.0);
                hessian[k][l] = slope - gradient[k] * trial[l] * inverse;
            }
        }
        VolumeRatio { gradient, hessian, trial }
    }

    /// Gradient at one strain; `share` is the derivative of this strain with respect to the strain at the end.
    #[inline(always)]
    fn at(strain: &Components<S>, change: Lanes<FMA>, share: f64) -> Self {
        let c = stretch::<FMA, S>(strain);
        let inverse = Lanes::splat(1.0) / (change + 1.0);
        let (cofactor, slope): ([_; S], [[_; S]; S]) = (cofactor(c), cofactor_slope(c));
        let (mut gradient, mut hessian, mut trial) = ([Lanes::ZERO; S], [[Lanes::ZERO; S]; S], [Lanes::ZERO; S]);
        for k in 0..S {
            gradient[k] = cofactor[k] * inverse;
            trial[k] = gradient[k] * share;
        }
        for k in 0..S {
            for l in 0..S {
                hessian[k][l] = (slope[k][l] * 2.0 - gradient[k] * gradient[l]) * inverse * share;
            }
        }
        VolumeRatio { gradient, hessian, trial }
    }
}
