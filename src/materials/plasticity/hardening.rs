//! Yield stress as a function of plastic strain and its rate.

use super::constants::{ElasticPlastic, Hardening, RateDependence};
use crate::math::lanes::{Lanes, Real, WIDTH};
use crate::math::tolerances::FIRST_PLASTIC_STRAIN;

/// Yield stress with its derivatives with respect to the plastic strain and to its rate.
#[derive(Clone, Copy)]
pub(super) struct Resistance<const FMA: bool> {
    /// Yield stress `[stress]`.
    pub(super) stress: Lanes<FMA>,
    /// Derivative with respect to the equivalent plastic strain `[stress]`.
    pub(super) by_strain: Lanes<FMA>,
    /// Derivative with respect to the rate of the equivalent plastic strain `[stress * time]`.
    pub(super) by_rate: Lanes<FMA>,
}

impl ElasticPlastic {
    /// Yield stress at zero rate, and its derivative.
    #[inline(always)]
    pub(super) fn at_rest<const FMA: bool>(&self, alpha: Lanes<FMA>) -> [Lanes<FMA>; 2] {
        match &self.hardening {
            Hardening::Saturating { modulus, saturation, exponent } => {
                // 1 - exp(-d alpha) with relative accuracy.
                let part = if *saturation == 0.0 { Lanes::ZERO } else { -(alpha * -exponent).exp_m1() };
                let stress = alpha.mul_add(Lanes::splat(*modulus), part * *saturation) + self.yield_stress;
                [stress, (-part + 1.0) * (saturation * exponent) + *modulus]
            }
            Hardening::Swift { strain, exponent } => by_lane(alpha, |alpha| {
                let stress = self.yield_stress * (1.0 + alpha / strain).powf(*exponent);
                [stress, stress * exponent / (strain + alpha)]
            }),
            Hardening::Ludwik { modulus, exponent } => by_lane(alpha, |alpha| {
                // The slope is infinite at first yielding; Newton's method uses a large finite slope.
                let start = alpha.max(FIRST_PLASTIC_STRAIN);
                [self.yield_stress + modulus * alpha.powf(*exponent), modulus * exponent * start.powf(exponent - 1.0)]
            }),
            Hardening::Table(points) => by_lane(alpha, |alpha| on_lines(points, alpha)),
        }
    }

    /// Yield stress at a rate of the plastic strain.
    #[inline(always)]
    pub(super) fn resistance<const FMA: bool>(&self, alpha: Lanes<FMA>, rate: Lanes<FMA>) -> Resistance<FMA> {
        let [stress, by_strain] = self.at_rest(alpha);
        match self.rate {
            RateDependence::None => Resistance { stress, by_strain, by_rate: Lanes::ZERO },
            RateDependence::Perzyna { viscosity } => {
                Resistance { stress: rate.mul_add(Lanes::splat(viscosity), stress), by_strain, by_rate: Lanes::splat(viscosity) }
            }
            RateDependence::JohnsonCook { factor, reference_rate } => {
                let [grown, slope] = by_lane(rate, |rate| {
                    let ratio = rate / reference_rate;
                    if ratio > 1.0 { [1.0 + factor * ratio.ln(), factor / rate] } else { [1.0, 0.0] }
                });
                Resistance { stress: stress * grown, by_strain: by_strain * grown, by_rate: stress * slope }
            }
        }
    }
}

#[inline(always)]
fn by_lane<const FMA: bool>(x: Lanes<FMA>, of: impl Fn(f64) -> [f64; 2]) -> [Lanes<FMA>; 2] {
    let mut both = [Lanes::ZERO; 2];
    for lane in 0..WIDTH {
        let [value, slope] = of(x.0[lane]);
        (both[0].0[lane], both[1].0[lane]) = (value, slope);
    }
    both
}

/// Value and slope of the polyline through points, the first of which is at 0; constant beyond the last.
fn on_lines(points: &[[f64; 2]], alpha: f64) -> [f64; 2] {
    let next = points.partition_point(|[strain, _]| *strain <= alpha).max(1);
    let [x, y] = points[next - 1];
    points.get(next).map_or([y, 0.0], |[to_x, to_y]| {
        let slope = (to_y - y) / (to_x - x);
        [y + slope * (alpha - x), slope]
    })
}
