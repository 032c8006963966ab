//! Automatic step size control: the error of a step, the admissible error, and the size of the next step.
//!
//! *Error of a step.* The error of a motion `q` grows by `first dt |q''| + second dt^2 |q'''|` in time, with the coefficients of the scheme
//! ([`LeadingError`]). The derivatives are divided differences of the positions of the last four states: for vibrations faster than the
//! steps they give the amplitude, not the accelerations.
//!
//! *Admissible error.* The error grows by at most `tolerance` times the largest mean speed of a body so far. Both are root mean squares
//! over the mass of a body, of the body where they are largest. Where velocities jump, as in impacts, no step is short enough for a rate:
//! the admissible error of such a step is that of a step of the usual size. An error at the round-off of the positions counts as zero: a
//! body at rest by friction has no other motion. The error of the first touch of a contact is the penetration at the end of the step or,
//! where a rule closes the gap within the step, half of the displacement in the step. The error of the end of a slip is the slip after its
//! end.
//!
//! *Plastic strain.* Where a bound is given, a step in which a point yields by more is repeated with a smaller size.
//!
//! *Step size.* A proportional-integral controller (Gustafsson, ACM TOMS 17, 1991; in the form of Soederlind, ACM TOMS 29, 2003),
//! `dt (aim/r)^(2/3p) (r_before/aim)^(1/3p)` with the ratio `r` of error and admissible error, and the order `p`. Factors of the step size
//! are rounded to a fraction of the tolerance: round-off of a solution, which differs between a model and the same model moved or numbered
//! otherwise, would change all later sizes, and grow from step to step.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::dynamics::model::definitions::{BodyDefinition, Model};
use crate::integrators::{LeadingError, Scheme};
use crate::math::tolerances;

/// Fraction of the tolerance that the controller aims at: errors of velocities become errors of positions and double them.
const AIM: f64 = 0.5;
/// Largest growth of the step size from one step to the next; `bdf2` is unstable for a growth beyond 2.4.
const LONGER: f64 = 2.0;
/// Largest reduction of the step size from one step to the next.
const SHORTER: f64 = 0.2;
/// Largest size of a repeated step relative to the refused one.
const LESS: f64 = 0.9;
/// Factors of the step size are multiples of a number between half and the whole of this share of the tolerance.
const ROUNDING: f64 = 0.125;
/// Exponent of the average step size for shorter steps: `usual (dt/usual)^(FORGETTING dt/usual)`.
const FORGETTING: f64 = 0.3;
/// Growth of the largest mean speed in a step, in units of the root of the tolerance, above which a motion counts as just begun: the error
/// relative to its small distance is not significant.
const BEGUN: f64 = 5.0;

/// Accuracy and bounds of the step size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepControl {
    /// Admissible growth of the position error relative to the distance that the positions move.
    pub tolerance: f64,
    /// Smallest size, by default a millionth of the first one; a step of this size is accepted with any error `[time]`.
    pub smallest: Option<f64>,
    /// Largest size `[time]`.
    pub largest: Option<f64>,
    /// Largest plastic strain of a step at a point; no bound by default.
    pub plastic_strain: Option<f64>,
}

impl StepControl {
    /// Increase of plastic strain in a step relative to its bound; 0 without a bound.
    fn plastic_ratio(&self, plastic_strain: f64) -> f64 {
        self.plastic_strain.map_or(0.0, |largest| plastic_strain / largest)
    }

    /// Factor of the step size, rounded to a share of the tolerance that is a power of two.
    fn rounded(&self, factor: f64) -> f64 {
        let unit = (ROUNDING * self.tolerance.min(1.0)).log2().floor().exp2();
        (factor / unit).round() * unit
    }

    /// Smallest step size, given the size `first` of the first step `[time]`.
    fn smallest(&self, first: f64) -> f64 {
        self.smallest.unwrap_or(tolerances::SMALLEST_STEP * first)
    }
}

/// State of the step size controller.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepSizeState {
    /// Size of the next step, 0 if not chosen yet `[time]`.
    dt: f64,
    /// Usual size of steps, in which short steps at impacts have little weight `[time]`.
    usual: f64,
    /// Error of the previous step relative to the admissible error, 0 if unknown.
    ratio: f64,
    /// Largest mean speed of a body so far `[length/time]`.
    speed: f64,
    /// Time for which each contact has been open, in the order of the model; empty before the first step `[time]`.
    open: Vec<f64>,
    /// The last two steps, the later one first.
    steps: Vec<PastStep>,
}

/// Earlier step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct PastStep {
    /// Time step size `[time]`.
    dt: f64,
    /// Mean velocities in the step `[length/time]`.
    velocity: Arc<Vec<f64>>,
}

/// Converged step, as judged by the controller.
pub struct Stepped<'a> {
    /// Time integrator of the step.
    pub scheme: &'a Scheme,
    /// Time step size `[time]`.
    pub dt: f64,
    /// Displacements at the start and the end of the step `[length]`.
    pub u: [&'a [f64]; 2],
    /// Velocities at the start and the end of the step `[length/time]`.
    pub v: [&'a [f64]; 2],
    /// True if the step is shorter than chosen, to end at an event.
    pub is_cut: bool,
    /// First touch of a contact at another time than the end of the step.
    pub touch: Option<FirstTouch>,
    /// Slip that ends within the step.
    pub slip_end: Option<SlipEnd>,
    /// Round-off of the positions if contacts or rigid bodies depend on them; otherwise 0 `[length]`.
    pub round_off: f64,
    /// Error of a first touch at which the work of its force on the round-off of the positions is as large as an admissible defect
    /// `[length]`.
    pub touch_round_off: f64,
    /// Largest plastic strain of the step at a point.
    pub plastic_strain: f64,
}

impl Stepped<'_> {
    /// Factor of the size of the next try if the error of a first touch or of the end of a slip is larger than `allowed`; `speed` is the
    /// largest mean speed so far.
    fn factor_at_event(&self, speed: f64, allowed: f64, measure: &impl Measure) -> Option<f64> {
        let &Stepped { dt, v: [v_0, v_1], touch, slip_end, touch_round_off, .. } = self;
        // A jump of the velocity acts from the touch on, not from the middle of the step.
        let jump = || measure.size(&v_1.iter().zip(v_0).map(|(v_1, v_0)| v_1 - v_0).collect::<Vec<f64>>(), true).min(speed);
        let (missed, rate) = match touch {
            Some(FirstTouch::Passed(depth)) => (depth, speed),
            Some(FirstTouch::Kept) => (0.5 * dt * jump(), jump()),
            None => (0.0, speed),
        };
        let most = allowed.max(touch_round_off);
        if missed > most {
            return Some((1.0 - (missed - AIM * most) / (rate * dt)).clamp(SHORTER, LESS));
        }
        let end = slip_end.filter(|end| end.missed() > allowed)?;
        Some((end.share + AIM * allowed / end.slip).clamp(SHORTER, LESS))
    }
}

/// First touch of a contact within a step, not at its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FirstTouch {
    /// Penetration of the sides at the end of the step `[length]`.
    Passed(f64),
    /// The update rule prevented penetration within the step.
    Kept,
}

/// Slip that ends within a step, as a mean over a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlipEnd {
    /// Slip in the step `[length]`.
    pub slip: f64,
    /// Share of the step in which the contact slips.
    pub share: f64,
}

impl SlipEnd {
    /// Slip after the end of the slip: a friction force below its limit has braked as if for the whole step `[length]`.
    pub fn missed(&self) -> f64 {
        self.slip * (1.0 - self.share)
    }
}

/// Root mean squares over the mass of bodies, the largest of all.
pub trait Measure {
    /// Root mean square of a vector of all unknowns, over all or over the free ones.
    fn size(&self, vector: &[f64], free: bool) -> f64;
}

impl StepSizeState {
    /// Size of the next step; `first` if none has been chosen `[time]`.
    pub fn size(&self, control: &StepControl, first: f64) -> f64 {
        let size = if self.dt > 0.0 { self.dt } else { first };
        size.max(control.smallest(first)).min(control.largest.unwrap_or(f64::INFINITY))
    }

    /// True if a contact has been open for the time `time`, or has never been closed.
    pub fn is_open(&self, contact: usize, time: f64) -> bool {
        self.open.get(contact).is_none_or(|open| *open >= time)
    }

    /// Returns the controller with the open times of contacts advanced by a step of size `dt`; `closed` are the contact states at its end.
    pub fn with_contacts(self, dt: f64, closed: impl Iterator<Item = bool>) -> StepSizeState {
        let so_far = |contact: usize| self.open.get(contact).copied().unwrap_or(f64::MAX);
        let open = closed.enumerate().map(|(contact, is_closed)| if is_closed { 0.0 } else { so_far(contact) + dt }).collect();
        StepSizeState { open, ..self }
    }

    /// Discards the history of the motion after a discontinuity.
    pub fn restart(&mut self) {
        self.steps.clear();
        self.ratio = 0.0;
    }

    /// Returns the controller after a failure of Newton's method: the next step is no longer than `dt`.
    pub fn held(&self, dt: f64) -> StepSizeState {
        StepSizeState { dt: self.dt.min(dt), ..self.clone() }
    }

    /// Returns the controller after a sufficiently accurate step.
    ///
    /// # Errors
    /// The step is not accurate enough: the size of the next try.
    pub fn after(&self, step: &Stepped, control: &StepControl, first: f64, measure: &impl Measure) -> Result<StepSizeState, f64> {
        let &Stepped { scheme, dt, u: [u_0, u_1], is_cut, round_off, .. } = step;
        let velocity: Vec<f64> = u_1.iter().zip(u_0).map(|(u_1, u_0)| (u_1 - u_0) / dt).collect();
        let speed = self.speed.max(measure.size(&velocity, false));
        let (order, smallest) = (scheme.promises.order as f64, control.smallest(first));
        // Admissible growth of the error in the step `[length]`.
        let still = (tolerances::STILL * measure.size(u_1, false)).max(round_off) + f64::MIN_POSITIVE;
        // A first touch shortens the first step, but not the usual size of steps.
        let usual = if self.usual > 0.0 { self.usual } else { self.size(control, first) };
        let allowed = control.tolerance * speed * usual.max(dt) + still;
        let growth = self.growth(step, &velocity).map(|growth| growth.iter().map(|part| measure.size(part, true)).sum::<f64>());
        // A motion below the round-off of the positions has no error; velocities of bodies that are held may alternate nevertheless.
        let is_still = dt * measure.size(&velocity, false) <= still;
        let ratio = growth.filter(|_| !is_still).map_or(0.0, |growth| growth * dt / allowed);
        let has_begun = speed <= self.speed * (1.0 + BEGUN * control.tolerance.sqrt());
        // A slightly smaller size would leave a tiny remainder of the step.
        let may_shrink = LESS * dt >= smallest;
        let shorter = |factor: f64| (dt * control.rounded(factor)).max(smallest);
        if ratio > 1.0 && may_shrink && has_begun {
            return Err(shorter((AIM / ratio).powf(1.0 / order).clamp(SHORTER, LESS)));
        }
        // Plastic strain grows in proportion to the step.
        let plastic_ratio = control.plastic_ratio(step.plastic_strain);
        if plastic_ratio > 1.0 && may_shrink {
            return Err(shorter((AIM / plastic_ratio).clamp(SHORTER, LESS)));
        }
        if let Some(factor) = step.factor_at_event(speed, allowed, measure).filter(|_| may_shrink) {
            return Err(shorter(factor));
        }
        // A motion that has just begun requires no shorter steps.
        let ratio = if has_begun { ratio } else { ratio.min(AIM) };
        let mut next = StepSizeState { speed, steps: vec![PastStep { dt, velocity: velocity.into() }], ..self.clone() };
        next.steps.extend(self.steps.first().cloned());
        if growth.is_none() {
            // First step, without an earlier error.
            (next.dt, next.usual) = (self.dt.max(dt), usual.max(dt));
        } else if !is_cut || ratio > AIM {
            let relative = (ratio / AIM).clamp(tolerances::EXACT, 1.0 / AIM);
            let before = if self.ratio > 0.0 { (self.ratio / AIM).max(tolerances::EXACT) } else { relative };
            let factor = (relative.powf(-2.0 / 3.0) * before.powf(1.0 / 3.0)).powf(1.0 / order);
            next.dt = dt * control.rounded(factor.clamp(SHORTER, LONGER));
            // Short steps that an event left and that only grow say nothing of the usual size: touches in quick succession would shorten
            // it, and with it the error admissible for the next one, to nothing.
            next.usual = match dt >= self.usual {
                true => dt,
                false if factor >= LONGER => self.usual,
                false => self.usual * (dt / self.usual).powf(FORGETTING * dt / self.usual),
            };
            next.ratio = ratio.min(1.0);
        }
        if plastic_ratio > AIM {
            next.dt = next.dt.min(dt * control.rounded((AIM / plastic_ratio).max(SHORTER)));
        }
        Ok(next)
    }

    /// Growth of the error in the step by second and by third differences, for each component; `None` if too few states are stored.
    fn growth(&self, step: &Stepped, velocity: &[f64]) -> Option<[Vec<f64>; 2]> {
        let &Stepped { scheme: Scheme { error, .. }, dt, v: [v_0, _], .. } = step;
        // Mean velocities over past intervals up to now, the last one first; the velocity itself for an interval of zero length.
        let stretches: [(f64, &[f64]); 3] = match &self.steps[..] {
            [] => return None,
            [before] => [(dt, velocity), (0.0, v_0), (before.dt, &before.velocity)],
            [before, first, ..] => [(dt, velocity), (before.dt, &before.velocity), (first.dt, &first.velocity)],
        };
        Some(differences(error, dt, stretches))
    }
}

/// Growth of the error by second and by third differences of the positions: vectors, whose sizes do not depend on the axes.
fn differences(error: &LeadingError, dt: f64, [last, middle, first]: [(f64, &[f64]); 3]) -> [Vec<f64>; 2] {
    let slope = |(h_1, v_1): (f64, f64), (h_0, v_0): (f64, f64)| 2.0 * (v_1 - v_0) / (h_1 + h_0);
    let all = last.0 + middle.0 + first.0;
    let mut growth = [Vec::with_capacity(last.1.len()), Vec::with_capacity(last.1.len())];
    for k in 0..last.1.len() {
        let at = |(h, v): (f64, &[f64])| (h, v[k]);
        let [later, earlier] = [slope(at(last), at(middle)), slope(at(middle), at(first))];
        growth[0].push(error.first * dt * later);
        growth[1].push(error.second * dt * dt * 3.0 * (later - earlier) / all);
    }
    growth
}

/// Shortest time in which an elastic wave crosses a cell `[time]`; `None` if all bodies are rigid.
pub fn time_of_sound(model: &Model) -> Option<f64> {
    let of_body = |body: &BodyDefinition| {
        let points = &body.mesh.points;
        let extent = |i: usize| {
            let ends = points.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], point| [a.min(point[i]), b.max(point[i])]);
            ends[1] - ends[0]
        };
        let dimension = body.mesh.dimension();
        let volume: f64 = (0..dimension).map(extent).product();
        let cell = (volume / points.len() as f64).powf(1.0 / dimension as f64);
        cell * (body.material.density() / body.material.stiffness()).sqrt()
    };
    model.bodies.iter().filter(|body| body.rigid.is_none()).map(of_body).reduce(f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Differences are third derivatives of a cubic motion, for all step sizes, and at the start, where a velocity takes the place of a
    /// step.
    #[test]
    fn differences_are_derivatives_of_a_cubic() {
        let error = LeadingError { first: 0.0, second: 1.0 };
        let position = |t: f64| 0.5 * t.powi(3) - t * t + 2.0 * t;
        let mean = |from: f64, h: f64| [(position(from + h) - position(from)) / h];
        for h in [0.3, 0.0] {
            let middle = if h > 0.0 { mean(0.1, h) } else { [1.5 * 0.1 * 0.1 - 2.0 * 0.1 + 2.0] };
            let found = differences(&error, 0.5, [(0.5, &mean(0.1 + h, 0.5)), (h, &middle), (0.1, &mean(0.0, 0.1))]);
            assert!(found[0][0] == 0.0 && (found[1][0] - 0.25 * 3.0).abs() < 1e-12, "{found:?}");
        }
    }
}
