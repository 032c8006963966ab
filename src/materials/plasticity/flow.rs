//! Plastic flow of a quadrature point in a step: elastic fraction, flow direction, plastic multiplier, and their derivatives.
//!
//! The path is straight in the logarithmic strain. The fraction `s` of the step is elastic, the larger root of
//! `|xi_0 + s d| = sqrt(2/3) k(alpha_0)` with `d = 2 mu dev(eps_1 - eps_0)`. In the rest the point flows by `dep = g N` with
//!
//! ```text
//! N    along (1 - theta) xi_s + theta xi_1,   theta = 1/(1 - exp(-x)) - 1/x,   x = |2 mu dev(eps_1 - eps_s)|/(sqrt(2/3) k(alpha_0))
//! g    of  |xi_1| = sqrt(2/3) k(alpha_0 + sqrt(2/3) g, sqrt(2/3) g/((1 - s) dt)) at the end of the step
//! a_1  = ((1 - (1 - t) b' g) a_0 + g N)/(1 + t b' g),   b' = sqrt(2/3) b      of each back strain, t = 1/2
//! ```
//!
//! `theta` is that of the exact solution for a constant yield stress: 1/2 for small steps, which are then second order accurate, and 1 for
//! large ones, which avoids oscillations of the direction. Radial return is `s = 0`, `theta = t = 1`.

use super::constants::{ElasticPlastic, MOST_BACK_STRESSES};
use super::logarithm::{applied, applied_back, dot, plus, rows, times};
use crate::math::lanes::{Lanes, Real, WIDTH};
use crate::math::tolerances::{LEAST_FLOW_SHARE, ON_THE_YIELD_SURFACE, OUTSIDE_THE_YIELD_SURFACE, PLASTIC_MULTIPLIER, SMALL_PLASTIC_STEP};

/// `sqrt(2/3)`.
pub(super) const ROOT: f64 = 0.816_496_580_927_726;

/// Largest number of iterations for the multiplier: Newton's method needs three to six, each bisection halves the interval.
const ITERATIONS: usize = 80;

/// Rule of flow of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    /// Elastic fraction first, then flow in the fitted direction: second order.
    Fitted,
    /// Radial return over the whole step: first order, depends on the end state only.
    RadialReturn,
}

/// A step on the logarithmic strain.
pub(super) struct FlowStep<'a, const FMA: bool, const S: usize> {
    pub(super) law: &'a ElasticPlastic,
    pub(super) rule: Rule,
    /// Shear modulus `[stress]`.
    pub(super) shear: f64,
    /// Size of the step `[time]`, 0 at rest.
    pub(super) dt: f64,
    /// Deviators of the strains at start and end.
    pub(super) strains: [[Lanes<FMA>; S]; 2],
    /// Back strains, as many as the law has back stresses.
    pub(super) back: [[Lanes<FMA>; S]; MOST_BACK_STRESSES],
    pub(super) alpha: Lanes<FMA>,
}

/// Result of the flow in a step.
pub(super) struct Flow<const FMA: bool, const S: usize> {
    /// Elastic share `s` of the step.
    pub(super) share: Lanes<FMA>,
    /// Plastic multiplier `g`, 0 in elastic lanes.
    pub(super) multiplier: Lanes<FMA>,
    /// Plastic strain increment `dep`.
    pub(super) strain: [Lanes<FMA>; S],
    /// Back strains at the end.
    pub(super) back: [[Lanes<FMA>; S]; MOST_BACK_STRESSES],
    /// Derivatives; `None` if not requested.
    pub(super) slopes: Option<Slopes<FMA, S>>,
}

/// Derivatives of the elastic fraction of the step, and of `2 mu` times the plastic strain increment `[stress]`.
pub(super) struct Slopes<const FMA: bool, const S: usize> {
    /// Derivative of the elastic fraction with respect to the strain at the end.
    pub(super) share: [Lanes<FMA>; S],
    /// Derivative of the plastic strain with respect to the strain at the end, for a fixed start of the flow.
    pub(super) by_end: [[Lanes<FMA>; S]; S],
    /// Derivative of the plastic strain with respect to the strain at which the flow starts.
    pub(super) by_start: [[Lanes<FMA>; S]; S],
    /// Derivative of minus the plastic strain with respect to the elastic fraction, by the remaining time of the flow.
    pub(super) by_time: [Lanes<FMA>; S],
}

/// Coefficients of a back strain for a given multiplier: back strain `(A a_0 + g N)/B` at the end, and back stress `q a_0 + g c/B N`.
struct Recovery<const FMA: bool> {
    a: Lanes<FMA>,
    b: Lanes<FMA>,
    q: Lanes<FMA>,
    dq: Lanes<FMA>,
    push: Lanes<FMA>,
    dpush: Lanes<FMA>,
}

/// Iterate of Newton's method for the plastic multiplier.
struct Iterate<const FMA: bool, const S: usize> {
    normal: [Lanes<FMA>; S],
    /// Derivative of the normal with respect to the multiplier.
    turning: [Lanes<FMA>; S],
    size: Lanes<FMA>,
    /// Direction of the relative stress at the end.
    outward: [Lanes<FMA>; S],
    /// `2 mu` plus the contribution of the back stresses.
    stiffness: Lanes<FMA>,
    residual: Lanes<FMA>,
    slope: Lanes<FMA>,
    /// Derivative of the right side of the yield condition with respect to the remaining time of the flow.
    by_time: Lanes<FMA>,
}

impl<const FMA: bool, const S: usize> FlowStep<'_, FMA, S> {
    /// Plastic flow of the step, with its derivatives if `with_slopes`.
    #[inline(always)]
    pub(super) fn flow(&self, with_slopes: bool) -> Flow<FMA, S> {
        let two_mu = Lanes::splat(2.0 * self.shear);
        let radius = self.law.at_rest(self.alpha)[0] * ROOT;
        let change = plus(&self.strains[0], Lanes::splat(-1.0), &self.strains[1]);
        let (share, share_slope) = self.elastic_share(radius, &change);
        let left = (-share + 1.0).greater(Lanes::splat(LEAST_FLOW_SHARE));
        let stress_1 = times(&self.strains[1], two_mu);
        let stress_s = times(&plus(&change, share, &self.strains[0]), two_mu);
        let driven = plus(&stress_s, Lanes::splat(-1.0), &stress_1);
        let (theta, theta_slope) = self.fitted(radius, &driven);
        let trial = plus(&driven, theta, &stress_s);

        let mut outside = stress_1;
        for (back, constants) in self.back.iter().zip(&self.law.back_stresses) {
            outside = plus(back, Lanes::splat(-constants.factor()), &outside);
        }
        let beyond = dot(&outside, &outside).sqrt();
        let mut yields = [false; WIDTH];
        for lane in 0..WIDTH {
            yields[lane] = beyond.0[lane] > radius.0[lane] * (1.0 + ON_THE_YIELD_SURFACE);
        }
        let (multiplier, at) = self.multiplier([&stress_1, &trial], theta, left, (&yields, radius + beyond));

        let mut flow = Flow { share, multiplier, strain: times(&at.normal, multiplier), back: self.back, slopes: None };
        for (k, constants) in self.law.back_stresses.iter().enumerate() {
            let Recovery { a, b, .. } = self.recovery(constants.factor(), constants.recovery, multiplier);
            let kept = times(&self.back[k], a / b);
            flow.back[k] = plus(&at.normal, multiplier / b, &kept);
        }
        if with_slopes {
            let mask = Lanes(std::array::from_fn(|lane| f64::from(u8::from(yields[lane]))));
            let by_time = at.by_time * self.dt;
            flow.slopes = Some(self.slopes(&at, (multiplier, mask), (theta, &theta_slope), (&driven, by_time), share_slope));
        }
        flow
    }

    /// Elastic fraction of the step, and its derivative with respect to the strain at the end.
    #[inline(always)]
    fn elastic_share(&self, radius: Lanes<FMA>, change: &[Lanes<FMA>; S]) -> (Lanes<FMA>, [Lanes<FMA>; S]) {
        if self.rule == Rule::RadialReturn {
            return (Lanes::ZERO, [Lanes::ZERO; S]);
        }
        let two_mu = Lanes::splat(2.0 * self.shear);
        let mut start = times(&self.strains[0], two_mu);
        for (back, constants) in self.back.iter().zip(&self.law.back_stresses) {
            start = plus(back, Lanes::splat(-constants.factor()), &start);
        }
        let way = times(change, two_mu);
        let (a, b, square) = (dot(&way, &way), dot(&start, &way), radius * radius);
        let c = dot(&start, &start) - square;
        let mut share = Lanes::ZERO;
        for lane in 0..WIDTH {
            let (a, b, c, square) = (a.0[lane].max(f64::MIN_POSITIVE), b.0[lane], c.0[lane], square.0[lane]);
            let inside = c.min(0.0);
            let root = (b * b - a * inside).max(0.0).sqrt();
            let exit = if b > 0.0 { -inside / (b + root) } else { (root - b) / a };
            share.0[lane] = if c > OUTSIDE_THE_YIELD_SURFACE * square { 0.0 } else { exit.clamp(0.0, 1.0) };
        }
        let exit = plus(&way, share, &start);
        let outward = dot(&exit, &way);
        let mut factor = Lanes::ZERO;
        for lane in 0..WIDTH {
            // For tiny steps on the yield surface the elastic fraction is round-off, and its derivative would be unbounded.
            let least = OUTSIDE_THE_YIELD_SURFACE * square.0[lane];
            let is_resolved = a.0[lane] > least || c.0[lane].abs() > least;
            let is_inner = is_resolved && share.0[lane] > 0.0 && share.0[lane] < 1.0 && outward.0[lane] > 0.0;
            factor.0[lane] = if is_inner { -2.0 * self.shear * share.0[lane] / outward.0[lane] } else { 0.0 };
        }
        (share, times(&exit, factor))
    }

    /// `theta` and its derivative with respect to the strain at the end.
    #[inline(always)]
    fn fitted(&self, radius: Lanes<FMA>, driven: &[Lanes<FMA>; S]) -> (Lanes<FMA>, [Lanes<FMA>; S]) {
        if self.rule == Rule::RadialReturn {
            return (Lanes::splat(1.0), [Lanes::ZERO; S]);
        }
        let size = dot(driven, driven).sqrt();
        let (mut theta, mut slope) = (Lanes::ZERO, Lanes::ZERO);
        for lane in 0..WIDTH {
            let (size, radius) = (size.0[lane], radius.0[lane]);
            let x = size / radius;
            // d theta/dx, and times dx/d|d|.
            let (value, by_x) = if x < SMALL_PLASTIC_STEP {
                (0.5 + x / 12.0 - x.powi(3) / 720.0, 1.0 / 12.0 - x * x / 240.0)
            } else {
                let (grown, left) = (-(-x).exp_m1(), (-x).exp());
                (1.0 / grown - 1.0 / x, 1.0 / (x * x) - left / (grown * grown))
            };
            theta.0[lane] = value;
            slope.0[lane] = if x > f64::EPSILON { by_x * 2.0 * self.shear / (size * radius) } else { 0.0 };
        }
        (theta, times(driven, slope))
    }

    /// Weight `t` of the end of the step in the evolution law of the back strains: 1 for radial return, otherwise 1/2.
    fn weight(&self) -> f64 {
        if self.rule == Rule::RadialReturn { 1.0 } else { 0.5 }
    }

    #[inline(always)]
    fn recovery(&self, factor: f64, recovery: f64, multiplier: Lanes<FMA>) -> Recovery<FMA> {
        let (t, rate) = (self.weight(), recovery * ROOT);
        let a = multiplier * (-rate * (1.0 - t)) + 1.0;
        let b = multiplier * (rate * t) + 1.0;
        let inverse = Lanes::splat(1.0) / b;
        let q = a * inverse * factor;
        let dq = (b * (-rate * (1.0 - t)) - a * (rate * t)) * inverse * inverse * factor;
        let push = inverse * factor;
        Recovery { a, b, q, dq, push, dpush: push * inverse * (-rate * t) }
    }

    /// Solves for the multiplier by Newton's method within a bracket.
    #[inline(always)]
    fn multiplier(
        &self,
        stresses: [&[Lanes<FMA>; S]; 2],
        theta: Lanes<FMA>,
        left: Lanes<FMA>,
        (yields, stress): (&[bool; WIDTH], Lanes<FMA>),
    ) -> (Lanes<FMA>, Iterate<FMA, S>) {
        let (mut low, mut high) = (Lanes::<FMA>::ZERO, Lanes::<FMA>::splat(f64::INFINITY));
        let mut g = Lanes::<FMA>::ZERO;
        let mut remaining = ITERATIONS;
        // One call in the text: what it does is large, and is compiled at each of its calls.
        loop {
            let at = self.look(stresses, theta, left, g);
            let mut is_done = true;
            let mut next = g;
            for lane in 0..WIDTH {
                let residual = at.residual.0[lane];
                if !yields[lane] || residual.abs() <= PLASTIC_MULTIPLIER * stress.0[lane] {
                    continue;
                }
                let before = g.0[lane];
                if residual > 0.0 {
                    low.0[lane] = before;
                } else {
                    high.0[lane] = before;
                }
                let newton = before - residual / at.slope.0[lane];
                let (least, most) = (low.0[lane], high.0[lane]);
                let bisected = if most.is_finite() { 0.5 * (least + most) } else { 2.0 * least + 0.1 * stress.0[lane] / self.shear };
                let candidate = if newton > least && newton < most { newton } else { bisected };
                // The iteration ends when no floating-point number lies between both bounds.
                if candidate != before && candidate != least {
                    next.0[lane] = candidate;
                    is_done = false;
                }
            }
            if is_done || remaining == 0 {
                return (g, at);
            }
            remaining -= 1;
            g = next;
        }
    }

    /// Evaluates the yield condition at the multiplier `g`.
    #[inline(always)]
    fn look(&self, [stress_1, trial]: [&[Lanes<FMA>; S]; 2], theta: Lanes<FMA>, left: Lanes<FMA>, g: Lanes<FMA>) -> Iterate<FMA, S> {
        let (mut v, mut dv, mut y, mut dy) = (*trial, [Lanes::ZERO; S], *stress_1, [Lanes::ZERO; S]);
        let (mut stiffness, mut dstiffness) = (Lanes::splat(2.0 * self.shear), Lanes::ZERO);
        for (back, constants) in self.back.iter().zip(&self.law.back_stresses) {
            let Recovery { q, dq, push, dpush, .. } = self.recovery(constants.factor(), constants.recovery, g);
            let mean = theta.mul_add(q, (-theta + 1.0) * constants.factor());
            v = plus(back, -mean, &v);
            dv = plus(back, -(theta * dq), &dv);
            y = plus(back, -q, &y);
            dy = plus(back, -dq, &dy);
            stiffness = stiffness + push;
            dstiffness = dstiffness + dpush;
        }
        let size = dot(&v, &v).sqrt().greater(Lanes::splat(f64::MIN_POSITIVE));
        let inverse = Lanes::splat(1.0) / size;
        let normal = times(&v, inverse);
        let along = dot(&normal, &dv);
        let turning = times(&plus(&normal, -along, &dv), inverse);
        y = plus(&normal, -(stiffness * g), &y);
        // Signed norm of the relative stress, negative beyond the center of the yield surface.
        let reach = dot(&y, &normal).sign_to(dot(&y, &y).sqrt().greater(Lanes::splat(f64::MIN_POSITIVE)));
        let outward = times(&y, Lanes::splat(1.0) / reach);
        dy = plus(&normal, -dstiffness.mul_add(g, stiffness), &dy);
        dy = plus(&turning, -(stiffness * g), &dy);
        let alpha = g.mul_add(Lanes::splat(ROOT), self.alpha);
        let per_time = if self.dt > 0.0 { Lanes::splat(ROOT / self.dt) / left } else { Lanes::ZERO };
        let resistance = self.law.resistance(alpha, g * per_time);
        let residual = reach - resistance.stress * ROOT;
        let slope = dot(&outward, &dy) - (resistance.by_strain * ROOT + resistance.by_rate * per_time) * ROOT;
        let lost = if self.dt > 0.0 { per_time / (left * self.dt) } else { Lanes::ZERO };
        let by_time = -(resistance.by_rate * g * lost) * ROOT;
        Iterate { normal, turning, size, outward, stiffness, residual, slope, by_time }
    }

    /// Derivatives of the flow; `mask` is 1 in yielding lanes.
    #[inline(always)]
    fn slopes(
        &self,
        at: &Iterate<FMA, S>,
        (g, mask): (Lanes<FMA>, Lanes<FMA>),
        (theta, theta_slope): (Lanes<FMA>, &[Lanes<FMA>; S]),
        (driven, by_time): (&[Lanes<FMA>; S], Lanes<FMA>),
        share: [Lanes<FMA>; S],
    ) -> Slopes<FMA, S> {
        let Iterate { normal, turning, size, outward, stiffness, slope, .. } = at;
        let two_mu = Lanes::splat(2.0 * self.shear);
        // Derivative of `v` with respect to `theta`: relative stress at the end minus that at the start of the flow.
        let mut weighed = *driven;
        for (back, constants) in self.back.iter().zip(&self.law.back_stresses) {
            let Recovery { q, .. } = self.recovery(constants.factor(), constants.recovery, g);
            weighed = plus(back, -(q + -constants.factor()), &weighed);
        }
        weighed = plus(normal, -dot(&weighed, normal), &weighed);
        let inverse = Lanes::splat(1.0) / or_one(*size, mask);
        let slope = or_one(*slope, mask);
        let flowed = plus(turning, g, normal);
        let turned = Turned { normal, weighed: times(&weighed, inverse), inverse: two_mu * inverse };
        let of = Multiplied { outward, flowed, push: *stiffness * g, pull: mask * g * two_mu, slope: mask * two_mu / slope };
        let (one, fixed) = (Lanes::splat(1.0), Lanes::ZERO);
        let by_end = of.derivative(&turned.derivative(theta, one, theta_slope), one * two_mu);
        let by_start = of.derivative(&turned.derivative(-theta + 1.0, -one, theta_slope), fixed);
        Slopes { share, by_end, by_start, by_time: times(&flowed, mask * two_mu * by_time / slope) }
    }
}

/// Terms of the derivative of the flow direction `N = v/|v|` with respect to a strain.
struct Turned<'a, const FMA: bool, const S: usize> {
    normal: &'a [Lanes<FMA>; S],
    /// Derivative of `v` with respect to `theta`, without its component along `N`, over `|v|`.
    weighed: [Lanes<FMA>; S],
    /// Twice the shear modulus over `|v|`: `2 mu/|v|`.
    inverse: Lanes<FMA>,
}

impl<const FMA: bool, const S: usize> Turned<'_, FMA, S> {
    /// Derivative of the flow direction with respect to the strain that has the weight `share` in `v`; `sign` is that of `theta'`:
    /// `share 2 mu (I_dev - N N)/|v| + sign weighed theta'`.
    #[inline(always)]
    fn derivative(&self, share: Lanes<FMA>, sign: Lanes<FMA>, theta_slope: &[Lanes<FMA>; S]) -> [[Lanes<FMA>; S]; S] {
        let own = share * self.inverse;
        let mut turned = [[Lanes::<FMA>::ZERO; S]; S];
        for k in 0..rows::<S>() {
            let (along, weighed) = (own * self.normal[k], self.weighed[k] * sign);
            for l in 0..S {
                let mut entry = -(along * self.normal[l]);
                if k == l {
                    entry = entry + own;
                }
                if k < 3 && l < 3 {
                    entry = entry - own * (1.0 / 3.0);
                }
                turned[k][l] = weighed.mul_add(theta_slope[l], entry);
            }
        }
        turned
    }
}

/// Terms of the derivative of the plastic strain `g N` with respect to a strain.
struct Multiplied<'a, const FMA: bool, const S: usize> {
    outward: &'a [Lanes<FMA>; S],
    /// Derivative of `g N` with respect to `g`.
    flowed: [Lanes<FMA>; S],
    push: Lanes<FMA>,
    pull: Lanes<FMA>,
    slope: Lanes<FMA>,
}

impl<const FMA: bool, const S: usize> Multiplied<'_, FMA, S> {
    /// `2 mu` times the derivative of the plastic strain, from the derivative of the flow direction; `direct` is the derivative of the
    /// stress at the end with respect to the same strain.
    #[inline(always)]
    fn derivative(&self, turned: &[[Lanes<FMA>; S]; S], direct: Lanes<FMA>) -> [[Lanes<FMA>; S]; S] {
        let back = times(&applied_back(turned, self.outward), -self.push);
        let multiplier = times(&plus(self.outward, direct, &back), -self.slope);
        let mut result = [[Lanes::ZERO; S]; S];
        for k in 0..rows::<S>() {
            for l in 0..S {
                result[k][l] = self.flowed[k].mul_add(multiplier[l], turned[k][l] * self.pull);
            }
        }
        result
    }
}

impl<const FMA: bool, const S: usize> Slopes<FMA, S> {
    /// Derivative of minus `2 mu` times the plastic strain with respect to the elastic fraction, without its effect through the start.
    #[inline(always)]
    pub(super) fn along_share(&self, change: &[Lanes<FMA>; S]) -> [Lanes<FMA>; S] {
        plus(&applied(&self.by_start, change), Lanes::splat(-1.0), &self.by_time)
    }
}

/// `divisor` in yielding lanes, 1 in others.
#[inline(always)]
fn or_one<const FMA: bool>(divisor: Lanes<FMA>, mask: Lanes<FMA>) -> Lanes<FMA> {
    mask.unless_zero(divisor, Lanes::splat(1.0))
}
