//! The stress at which a point yields, by its plastic strain and the rate of that.

use super::constants::{ElasticPlastic, Hardening, RateDependence};
use crate::math::lanes::{Lanes, Real, WIDTH};
use crate::math::tolerances::FIRST_PLASTIC_STRAIN;

/// Yield stress with its derivatives with respect to the plastic strain and to its rate.
#[derive(Clone, Copy)]
pub(super) struct Resistance<const FMA: bool> {
    /// `[stress]`.
    pub(super) stress: Lanes<FMA>,
    /// `[stress]`.
    pub(super) by_strain: Lanes<FMA>,
    /// `[stress * time]`.
    pub(super) by_rate: Lanes<FMA>,
}

impl ElasticPlastic {
    /// Yield stress at rest and its derivative.
    #[inline(always)]
    pub(super) fn at_rest<const FMA: bool>(&self, alpha: Lanes<FMA>) -> [Lanes<FMA>; 2] {
        match &self.hardening {
            Hardening::Saturating { modulus, saturation, exponent } => {
                // 1 - exp(-d alpha) with relative accuracy.
                let part = if *saturation == 0.0 { Lanes::ZERO } else { -(alpha * -exponent).exp_m1() };
                let stress = alpha.mul_add(Lanes::splat(*modulus), part * *saturation) + self.yield_stress;
                [stress, (-part + 1.0) * (saturation * exponent) + *modulus]
            }
            hardening => by_lane(alpha, |alpha| hardening.at(self.yield_stress, alpha)),
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

impl Hardening {
    /// Yield stress and its derivative at a plastic strain.
    fn at(&self, yield_stress: f64, alpha: f64) -> [f64; 2] {
        match self {
            Hardening::Saturating { modulus, saturation, exponent } => {
                let left = (-exponent * alpha).exp();
                [yield_stress + modulus * alpha + saturation * (1.0 - left), modulus + saturation * exponent * left]
            }
            Hardening::Swift { strain, exponent } => {
                let stress = yield_stress * (1.0 + alpha / strain).powf(*exponent);
                [stress, stress * exponent / (strain + alpha)]
            }
            Hardening::Ludwik { modulus, exponent } => {
                // The slope is infinite at the first yielding; a large one serves Newton's method.
                let start = alpha.max(FIRST_PLASTIC_STRAIN);
                [yield_stress + modulus * alpha.powf(*exponent), modulus * exponent * start.powf(exponent - 1.0)]
            }
            Hardening::Table(points) => {
                let above = points.partition_point(|[strain, _]| *strain <= alpha);
                match (above.checked_sub(1).map(|below| points[below]), points.get(above)) {
                    (Some([x, y]), Some([to_x, to_y])) => {
                        let slope = (to_y - y) / (to_x - x);
                        [y + slope * (alpha - x), slope]
                    }
                    (Some([_, y]), None) => [y, 0.0],
                    (None, _) => [yield_stress, 0.0],
                }
            }
        }
    }
}
