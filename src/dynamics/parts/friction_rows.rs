//! Tangential constraints of a contact pair, one per component of slip: one beside each normal constraint in the plane, a group of two in
//! space, of three for a ball joint (`slip_vector.rs`).

use std::ops::Range;
use std::sync::Arc;

use super::laws::{Equation, RowState};
use crate::contact::{FrictionLaw, Limit, ROUGH, SlipState};
use crate::dynamics::model::amplitude::TimeFunctionError;
use crate::dynamics::model::interactions::{Coefficient, Friction};
use crate::linear::Block;
use crate::math::norms::length;
use crate::math::tolerances;

/// Tangential constraints of a pair.
pub struct FrictionRows {
    /// Friction law: shear stress as a function of pressure and slip rate.
    pub law: Arc<dyn FrictionLaw>,
    /// Friction coefficient.
    pub coefficient: Coefficient,
    /// Friction coefficient of each normal constraint in this step.
    pub coefficients: Vec<f64>,
    /// Range of the tangential constraints among all constraints; those of a group are contiguous.
    pub rows: Range<usize>,
    /// Number of tangential constraints in a group.
    pub tangents: usize,
    /// Multiplier per slip, which scales slips to multipliers.
    pub c: f64,
    /// Blocks of each tangential constraint with its normal constraint.
    pub(super) couplings: Vec<Block>,
    /// Blocks of each tangential constraint with the other constraints of its group.
    pub(super) partners: Vec<Block>,
}

impl FrictionRows {
    /// Friction of `count` normal constraints of a pair with `tangents` slip components each; `c` is the multiplier per gap. Constraint
    /// numbers are assigned later.
    pub fn new(friction: &Friction, count: usize, tangents: usize, c: f64) -> Self {
        let coefficients = match friction.coefficient {
            Coefficient::Constant(value) => vec![value; count],
            _ => vec![0.0; count],
        };
        FrictionRows {
            law: friction.law.clone(),
            coefficient: friction.coefficient.clone(),
            coefficients,
            rows: 0..tangents * count,
            tangents,
            c: tolerances::TANGENTIAL * c,
            couplings: Vec::new(),
            partners: Vec::new(),
        }
    }

    /// Tangential constraints of the normal constraint with the index `local` in the pair.
    pub fn group(&self, local: usize) -> Range<usize> {
        let first = self.rows.start + self.tangents * local;
        first..first + self.tangents
    }

    /// Other tangential constraints of the group of `row`, from the next one on and around.
    pub fn others(&self, row: usize) -> impl Iterator<Item = usize> + use<> {
        let (group, count) = (self.group(self.normal_row(row)), self.tangents);
        (1..count).map(move |by| group.start + (row - group.start + by) % count)
    }

    /// Each tangential constraint with each other one of its group.
    pub fn pairs(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        self.rows.clone().flat_map(|row| self.others(row).map(move |other| [row, other]))
    }

    /// Index in the pair of the normal constraint of the tangential constraint `row`.
    pub fn normal_row(&self, row: usize) -> usize {
        (row - self.rows.start) / self.tangents
    }

    /// Writes the factors of the normal multipliers, and of the multipliers of the other constraints of a group, into values of the matrix.
    pub fn couple(&self, equations: &[Equation], values: &mut [f64]) {
        let equations = &equations[self.rows.clone()];
        for (place, equation) in self.couplings.iter().zip(equations) {
            values[place.at(0, 0)] = equation.normal;
        }
        let beside = equations.iter().flat_map(|equation| equation.beside.into_iter().take(self.tangents - 1));
        for (place, [_, diagonal]) in self.partners.iter().zip(beside) {
            values[place.at(0, 0)] = diagonal;
        }
    }

    /// Evaluates the friction coefficients of a step that depend on time or place.
    ///
    /// # Errors
    /// A function failed, or returned no coefficient.
    pub fn begin_step(&mut self, time: f64, place: impl Fn(usize) -> [f64; 3]) -> Result<(), TimeFunctionError> {
        match &self.coefficient {
            Coefficient::Constant(_) => return Ok(()),
            Coefficient::OverTime(function) => {
                let value = function.value(time)?;
                self.coefficients.fill(value);
            }
            Coefficient::OverPlace(function) => {
                for (row, coefficient) in self.coefficients.iter_mut().enumerate() {
                    *coefficient = function.value(place(row))?;
                }
            }
        }
        match self.coefficients.iter().find(|value| !(value.is_finite() && **value >= 0.0)) {
            Some(value) => Err(format!("the coefficient of friction is {value}").into()),
            None => Ok(()),
        }
    }
}

/// Data of a normal constraint at an iterate, shared by its tangential constraints.
#[derive(Clone, Copy)]
pub struct NormalState<'a> {
    /// Friction law.
    pub law: &'a dyn FrictionLaw,
    /// Friction coefficient.
    pub coefficient: f64,
    /// Normal force per weight that bounds friction: the multiplier of the normal constraint, of bilateral contacts its magnitude.
    pub normal: f64,
    /// Derivative of `normal` with respect to the multiplier: 1, or -1 where a bilateral contact pulls.
    pub sense: f64,
    /// Slip rate per weighted slip: `1/dt` divided by the weight of the constraint.
    pub speed: f64,
    /// Slip speed at the start of the step, where the friction law is evaluated there; `None`: it is evaluated at the speed of the slip.
    pub lagged: Option<f64>,
    /// Multiplier per stress: 1, or a circumference in axisymmetric models.
    pub around: f64,
    /// Tangential compliance: slip per change of the multiplier within an iteration.
    pub compliance: f64,
    /// Augmentation parameter of friction: multiplier per slip in the trial multiplier `s - c slip`.
    pub c: f64,
    /// Stiffness `kappa` of the node in this step, multiplier per slip: its elastic stiffness and its inertia, which grows with `1/dt^2`.
    /// The equations of slipping constraints are divided by `kappa`, so that their entries are of order one for every step size.
    pub stiffness: f64,
    /// Slip below which slips count as zero.
    pub tolerance: f64,
}

impl NormalState<'_> {
    /// Largest dry multiplier at the speed of a slip of this size, with its derivatives with respect to the normal multiplier and to the
    /// size.
    pub fn limit(&self, slip: f64) -> Limit {
        let limit = self.law.limit(self.state(slip));
        let by_slip = if self.lagged.is_some() { 0.0 } else { self.around * self.speed };
        // Beyond the bearing limit of the lubricant film its shear stress is proportional to the pressure, like dry friction.
        let film = if self.is_film_at(slip) { 0.0 } else { ROUGH };
        // A node that comes into contact at this iterate will have a pressure of unknown size, likely beyond that of this limit.
        let by_pressure = if self.normal > 0.0 { film } else { 0.0 };
        Limit {
            shear: limit.shear * self.around + film * self.normal.max(0.0),
            by_pressure: limit.by_pressure + by_pressure,
            by_speed: limit.by_speed * by_slip,
        }
    }

    fn state(&self, slip: f64) -> SlipState {
        let speed = self.lagged.unwrap_or(slip * self.speed);
        SlipState { coefficient: self.coefficient, pressure: self.normal.max(0.0) / self.around, speed }
    }

    /// Ratios of tangential to normal impulses of an impact at the end of the step: as of these tangential multipliers, without the parts
    /// of film and adhesion.
    pub fn impulse_ratios(&self, lambda: [f64; 3], slip: f64) -> [f64; 3] {
        if self.normal <= 0.0 {
            return [0.0; 3];
        }
        let ratios = lambda.map(|lambda| lambda / self.normal);
        let most = self.law.impulse_ratio(self.state(slip)) / length(ratios).max(f64::MIN_POSITIVE);
        ratios.map(|ratio| ratio * most.min(1.0))
    }

    /// Multiplier per slip `c` in the trial multiplier of an iteration. With a small `c` relative to the stiffness of the node the trial
    /// depends on multipliers only, and the film would count as a force that makes the constraint stick.
    pub fn pace(&self, slip: f64) -> f64 {
        self.c.max(tolerances::TRIAL_STIFFNESS * self.stiffness) + self.film(slip)
    }

    /// Multiplier of the lubricant film (viscous friction) per slip of this size; 0 beyond the bearing limit of the film.
    pub fn film(&self, slip: f64) -> f64 {
        if self.is_film_at(slip) { self.law.film() * self.around * self.speed } else { 0.0 }
    }

    fn is_film_at(&self, slip: f64) -> bool {
        self.law.film() * self.around * self.speed * slip <= ROUGH * self.normal.max(0.0)
    }

    /// True if a slip exceeds round-off.
    pub fn is_clear(&self, off: f64) -> bool {
        off > tolerances::CLEARLY * self.tolerance
    }
}

/// Tangential constraint at an iterate in the plane.
pub struct SlipRow<'a> {
    /// Data of the normal constraint.
    pub pressed: NormalState<'a>,
    /// Tangential multiplier.
    pub lambda: f64,
    /// Slip of the step.
    pub slip: f64,
    /// Slip for which a constraint that slipped before has zero slip rate at the end of the step; 0 for others.
    pub rest: f64,
    /// True if supports prevent slip: the multiplier then follows from the prescribed slip, and remains constant without slip.
    pub is_held: bool,
}

/// Admissible pairs of slip and multiplier in a step: with `s` the dry multiplier against the direction of `rest`, a monotone graph,
///
/// ```text
/// slip < 0: s = -L    slip = 0: -L <= s <= 0    0 < slip < rest: s = 0    slip = rest: 0 <= s <= L    slip > rest: s = L
/// ```
///
/// so that no state supplies energy. Stick alone (`rest` = 0: `|s| <= L` at zero slip) would reverse the velocity of a node that comes to
/// rest, again in every step, by forces that exhaust the friction limit.
impl SlipRow<'_> {
    fn limit(&self, slip: f64) -> Limit {
        self.pressed.limit(slip.abs())
    }

    fn film(&self) -> f64 {
        self.pressed.film(self.slip.abs())
    }

    /// Multiplier of dry friction: the tangential multiplier without the part of the lubricant film.
    fn dry(&self) -> f64 {
        self.lambda + self.film() * self.slip
    }

    /// Direction and size of `rest`; size 0 at round-off level.
    fn stop(&self) -> (f64, f64) {
        let size = self.rest.abs();
        (1f64.copysign(self.rest), if self.pressed.is_clear(size) { size } else { 0.0 })
    }

    /// Dry trial multiplier `s - c slip`, for a constraint that sticks from the present iterate on.
    fn trial(&self, c: f64) -> f64 {
        self.dry() - c * self.slip
    }

    /// State and multiplier on the graph with this limit, at the point nearest to the present slip and multiplier in the metric of `c`.
    fn nearest(&self, c: f64, limit: f64) -> (RowState, f64) {
        let (sense, rest) = self.stop();
        let z = -sense * self.trial(c);
        let (state, s) = match z {
            _ if z < -limit => (RowState::sliding(sense), -limit),
            _ if rest == 0.0 && z <= limit => (RowState::Closed, z),
            _ if z <= 0.0 => (RowState::Closed, z),
            _ if z < c * rest => (RowState::Turns, 0.0),
            _ if z <= c * rest + limit => (RowState::Stops, z - c * rest),
            _ => (RowState::sliding(-sense), limit),
        };
        (state, -sense * s)
    }

    /// State of a constraint without free slip, because supports fix its nodes.
    fn held(&self) -> RowState {
        if self.pressed.is_clear(self.slip.abs()) { RowState::sliding(-self.slip) } else { RowState::Closed }
    }

    /// State at the first iteration.
    pub fn first_state(&self) -> RowState {
        if self.is_held {
            return self.held();
        }
        let (c, limit) = (self.pressed.pace(self.slip.abs()), self.limit(self.slip).shear);
        let trial = self.trial(c);
        // Constraints without pressure and motion start sticking.
        match limit > 0.0 || (trial == 0.0 && self.pressed.normal <= 0.0) {
            true => self.nearest(c, limit).0,
            false => RowState::sliding(trial),
        }
    }

    /// Natural residual as a slip, and its energy.
    pub fn residual(&self) -> (f64, f64) {
        let limit = self.limit(self.slip).shear;
        let off = match self.is_held {
            true if self.pressed.is_clear(self.slip.abs()) => self.dry() + limit * self.slip.signum(),
            true => self.lambda - self.lambda.clamp(-limit, limit),
            false => self.dry() - self.nearest(self.pressed.c + self.film(), limit).1,
        };
        (off / self.pressed.c, off * self.slip)
    }

    /// Equation of the constraint in a state.
    pub fn equation(&self, state: RowState) -> Equation {
        let Some(sense) = state.sense() else {
            return match state {
                RowState::Open => Equation::OPEN,
                RowState::Turns => {
                    let by = 1.0 / self.pressed.stiffness;
                    Equation {
                        acts: true,
                        gradient: by * self.film(),
                        diagonal: by,
                        right: -by * self.film() * self.slip,
                        compliance: self.pressed.compliance,
                        ..Equation::OPEN
                    }
                }
                _ if self.is_held => self.kept(),
                RowState::Stops => self.stuck(self.rest),
                _ => self.stuck(0.0),
            };
        };
        // Slip has the opposite direction of the multiplier; with the wrong sign its speed counts as zero.
        let Limit { shear, by_pressure, by_speed } = self.limit((-sense * self.slip).max(0.0));
        let by = 1.0 / self.pressed.stiffness;
        Equation {
            acts: true,
            // If the friction force decreases faster than the bodies' compliance, no solution exists near this one, only at a larger speed:
            // iterations move there.
            gradient: by * (self.film() + by_speed.max(-self.pressed.c)),
            diagonal: by,
            normal: -by * sense * by_pressure * self.pressed.sense,
            right: by * (sense * (shear - by_pressure * self.pressed.normal) - self.film() * self.slip),
            compliance: self.pressed.compliance,
            ..Equation::OPEN
        }
    }

    /// Equation `slip = at` of a constraint with a given slip.
    fn stuck(&self, at: f64) -> Equation {
        let compliance = self.pressed.compliance;
        Equation { compliance, ..Equation::held(compliance, compliance * self.lambda - self.slip + at) }
    }

    /// Equation of an unchanged multiplier, limited by the pressure.
    fn kept(&self) -> Equation {
        let limit = self.limit(0.0).shear;
        let by = 1.0 / self.pressed.stiffness;
        Equation { acts: true, diagonal: by, right: by * self.lambda.clamp(-limit, limit), ..Equation::OPEN }
    }

    /// New state and magnitude of the violation that requires it, or `None`; `self` has the values of the frozen linearization.
    pub fn change(&self, state: RowState) -> Option<(RowState, f64)> {
        if self.is_held {
            return (state != self.held()).then(|| (self.held(), self.slip.abs()));
        }
        let ((sense, rest), limit) = (self.stop(), self.limit(0.0).shear);
        let (s, slip) = (-sense * self.dry() / self.pressed.c, sense * self.slip);
        let (most, stopped) = (limit / self.pressed.c, self.limit(self.rest).shear / self.pressed.c);
        let slides = |s: f64| RowState::sliding(-sense * s);
        // Violation beyond each end of the state's part of the graph, and the adjacent state.
        let (below, above) = match state {
            RowState::Open | RowState::Closed if rest == 0.0 => ((-most - s, slides(-1.0)), (s - most, slides(1.0))),
            RowState::Open | RowState::Closed => ((-most - s, slides(-1.0)), (s, RowState::Turns)),
            RowState::Turns => ((-slip, RowState::Closed), (slip - rest, RowState::Stops)),
            RowState::Stops => ((-s, RowState::Turns), (s - stopped, slides(1.0))),
            // Without a friction limit slip is the only state, in either direction.
            RowState::Forward | RowState::Backward if limit <= 0.0 => return None,
            _ if state == slides(-1.0) => ((0.0, state), (slip, RowState::Closed)),
            _ if rest == 0.0 => ((-slip, RowState::Closed), (0.0, state)),
            _ => ((rest - slip, RowState::Stops), (0.0, state)),
        };
        let (off, next) = if below.0 > above.0 { below } else { above };
        self.pressed.is_clear(off).then_some((next, off))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Coulomb;

    fn row(law: &dyn FrictionLaw, normal: f64, lambda: f64, slip: f64) -> SlipRow<'_> {
        let (coefficient, speed, around, compliance, c, tolerance) = (0.3, 2.0, 1.0, 0.0, 5.0, 1e-9);
        let pressed =
            NormalState { law, coefficient, normal, sense: 1.0, speed, lagged: None, around, compliance, c, stiffness: 3.0 * c, tolerance };
        SlipRow { pressed, lambda, slip, rest: 0.0, is_held: false }
    }

    /// A constraint that solves the equation of its state has no residual unless its state must change; slip dissipates energy.
    #[test]
    fn the_solution_of_the_equation_has_no_residual() {
        let laws = [
            Coulomb::default(),
            Coulomb { adhesion: 0.2, transition_speed: 0.1, static_ratio: 1.5, ..Coulomb::default() },
            Coulomb { most: 0.2, ..Coulomb::default() },
            Coulomb { viscosity: 0.7, ..Coulomb::default() },
        ];
        for law in &laws {
            let rows = [(2.0, 0.1, 0.0), (2.0, 1.0, -0.3), (2.0, -1.0, 0.3), (0.5, 0.0, 0.1), (0.0, 0.0, 0.2), (1.0, -0.2, 0.05)];
            for ((normal, lambda, slip), rest) in rows.into_iter().flat_map(|row| [0.0, 0.1, -0.1, 0.4].map(|rest| (row, rest))) {
                let at = SlipRow { rest, ..row(law, normal, lambda, slip) };
                let state = at.first_state();
                let Equation { gradient, diagonal, normal: by, right, .. } = at.equation(state);
                let solved = if state.holds() {
                    SlipRow { slip: slip + right / gradient, ..at }
                } else {
                    SlipRow { lambda: (right - by * normal) / diagonal, ..at }
                };
                let asks = solved.change(state).is_some();
                assert!(asks || solved.residual().0.abs() < 1e-14, "{law:?} {normal} {lambda} {slip} {rest} {state:?}");
                assert!(asks || solved.lambda * solved.slip <= 0.0, "{law:?} {normal} {lambda} {slip} {rest} {state:?}");
            }
        }
    }

    /// For every slip and multiplier: a constraint whose state need not change lies on the graph, and has one state there.
    #[test]
    fn a_row_that_stops_changes_its_state_along_the_graph() {
        let law = Coulomb::default();
        for rest in [0.2_f64, -0.2] {
            let sense = rest.signum();
            let at = |slip: f64, s: f64| SlipRow { rest, ..row(&law, 2.0, -sense * s, sense * slip) };
            // Limit 0.6; along the graph from reverse to forward slip.
            let places = [
                (-0.1, -0.6, RowState::sliding(sense)),
                (0.0, -0.3, RowState::Closed),
                (0.1, 0.0, RowState::Turns),
                (0.2, 0.4, RowState::Stops),
                (0.3, 0.6, RowState::sliding(-sense)),
            ];
            for (index, (slip, s, state)) in places.into_iter().enumerate() {
                let found = at(slip, s);
                assert_eq!(found.first_state(), state, "{slip} {s}");
                assert!(found.residual().0.abs() < 1e-15);
                for (other, (.., wrong)) in places.into_iter().enumerate() {
                    let asked = found.change(wrong).map(|(next, _)| next);
                    // From every state the changes approach the solution along the graph; in the state of the solution no change is
                    // required.
                    let next = if other < index { other + 1 } else { other.saturating_sub(1) };
                    assert!(asked.is_none() || asked == Some(places[next].2), "{slip} {s}: {wrong:?} asks for {asked:?}");
                    assert!(other != index || asked.is_none());
                }
            }
        }
    }

    #[test]
    fn equations_have_the_derivatives_of_the_limit() {
        let law = Coulomb { static_ratio: 1.6, transition_speed: 0.4, exponent: 2.0, adhesion: 0.1, viscosity: 0.3, ..Coulomb::default() };
        let missed = |normal: f64, lambda: f64, slip: f64| {
            let at = row(&law, normal, lambda, slip);
            at.dry() - at.limit(slip).shear
        };
        let (normal, lambda, slip, h) = (1.7, 0.9, -0.12, 1e-6);
        let Equation { gradient, diagonal, normal: by, right, .. } = row(&law, normal, lambda, slip).equation(RowState::Forward);
        let slope = |f: &dyn Fn(f64) -> f64| (f(h) - f(-h)) / (2.0 * h * 15.0);
        assert!((slope(&|x| missed(normal + x, lambda, slip)) - by).abs() < 1e-9);
        assert!((slope(&|x| missed(normal, lambda + x, slip)) - diagonal).abs() < 1e-9);
        assert!((slope(&|x| missed(normal, lambda, slip + x)) - gradient).abs() < 1e-9);
        assert!((missed(normal, lambda, slip) / 15.0 - (diagonal * lambda + by * normal - right)).abs() < 1e-14);
    }
}
