//! The tangential rows of a contact pair: beside every row that presses one that friction holds.

use std::ops::Range;
use std::sync::Arc;

use super::laws::{Equation, RowState};
use crate::contact::{FrictionLaw, Limit, ROUGH, Sliding};
use crate::dynamics::model::amplitude::TimeFunctionError;
use crate::dynamics::model::interactions::{Coefficient, Friction};
use crate::linear::Block;
use crate::math::tolerances;

/// The tangential rows of a pair.
pub struct FrictionRows {
    /// How large the shear stress is.
    pub law: Arc<dyn FrictionLaw>,
    /// Coefficient that the law is given.
    pub coefficient: Coefficient,
    /// The same in this step, row by row.
    pub coefficients: Vec<f64>,
    /// Range of the rows among all rows.
    pub rows: Range<usize>,
    /// Multiplier per slip: compares the two.
    pub c: f64,
    /// Blocks of the rows, each with the row that presses.
    pub(super) couplings: Vec<Block>,
}

impl FrictionRows {
    /// Friction of `count` rows of a pair whose multipliers compare with gaps by `c`; the rows are numbered later.
    pub fn new(friction: &Friction, count: usize, c: f64) -> Self {
        let coefficients = match friction.coefficient {
            Coefficient::Constant(value) => vec![value; count],
            _ => vec![0.0; count],
        };
        FrictionRows {
            law: friction.law.clone(),
            coefficient: friction.coefficient.clone(),
            coefficients,
            rows: 0..count,
            c: tolerances::TANGENTIAL * c,
            couplings: Vec::new(),
        }
    }

    /// Writes the factors of the multipliers that press into values of the matrix.
    pub fn couple(&self, equations: &[Equation], values: &mut [f64]) {
        for (place, equation) in self.couplings.iter().zip(&equations[self.rows.clone()]) {
            values[place.at(0, 0)] = equation.normal;
        }
    }

    /// The coefficients of a step, for what depends on its time or on the places where it starts.
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

/// A tangential row at an iterate.
pub struct SlipRow<'a> {
    /// How large the shear stress is.
    pub law: &'a dyn FrictionLaw,
    /// Coefficient that the law is given.
    pub coefficient: f64,
    /// Multiplier of the row that presses.
    pub normal: f64,
    /// Tangential multiplier.
    pub lambda: f64,
    /// Slip of the step.
    pub slip: f64,
    /// Speed per slip.
    pub speed: f64,
    /// Multiplier per stress: one, or a circumference.
    pub around: f64,
    /// Slip per change of the multiplier within an iteration.
    pub compliance: f64,
    /// Multiplier per slip, which compares the two.
    pub c: f64,
    /// Slip that counts as zero.
    pub tolerance: f64,
    /// Whether supports keep it from sliding whatever presses: then its multiplier follows from its slip, and stays as it was without one.
    pub is_held: bool,
}

impl SlipRow<'_> {
    /// The largest multiplier at the speed of a slip, with its derivatives with respect to the pressing multiplier and to the slip's size.
    fn limit(&self, slip: f64) -> Limit {
        let (pressure, speed) = (self.normal.max(0.0) / self.around, slip.abs() * self.speed);
        let limit = self.law.limit(Sliding { coefficient: self.coefficient, pressure, speed });
        // A film that bears no more is as dry friction.
        let film = if self.is_film_at(slip) { 0.0 } else { ROUGH };
        Limit {
            shear: limit.shear * self.around + film * self.normal.max(0.0),
            by_pressure: limit.by_pressure + film,
            by_speed: limit.by_speed * self.around * self.speed,
        }
    }

    /// Multiplier of the film per slip, as long as the pressure bears it.
    fn film(&self) -> f64 {
        if self.is_film_at(self.slip) { self.law.film() * self.around * self.speed } else { 0.0 }
    }

    fn is_film_at(&self, slip: f64) -> bool {
        self.law.film() * self.around * self.speed * slip.abs() <= ROUGH * self.normal.max(0.0)
    }

    /// Multiplier without that of the film.
    fn dry(&self) -> f64 {
        self.lambda + self.film() * self.slip
    }

    /// Dry multiplier that the row would have if it stuck from here.
    fn trial(&self) -> f64 {
        self.dry() - self.c * self.slip
    }

    /// State of a row that supports hold.
    fn held(&self) -> RowState {
        if self.is_clear(self.slip.abs()) { RowState::sliding(-self.slip) } else { RowState::Closed }
    }

    /// The state with which an iteration begins.
    pub fn first_state(&self) -> RowState {
        let trial = self.trial();
        if self.is_held {
            return self.held();
        }
        let limit = self.limit(self.slip).shear;
        // What is pressed by nothing yet, and does not move, begins by sticking.
        let is_new = trial == 0.0 && self.normal <= 0.0;
        if trial.abs() <= limit && (limit > 0.0 || is_new) { RowState::Closed } else { RowState::sliding(trial) }
    }

    /// Natural residual: by how much the row is off, as a slip, and the energy that goes with it.
    pub fn residual(&self) -> (f64, f64) {
        let limit = self.limit(self.slip).shear;
        let off = match self.is_held {
            true if self.is_clear(self.slip.abs()) => self.dry() + limit * self.slip.signum(),
            true => self.lambda - self.lambda.clamp(-limit, limit),
            false => self.dry() - self.trial().clamp(-limit, limit),
        };
        (off / self.c, off * self.slip)
    }

    /// The equation of the row in a state.
    pub fn equation(&self, state: RowState) -> Equation {
        let Some(sense) = state.sense() else {
            return match state {
                RowState::Open => Equation::OPEN,
                _ if self.is_held => self.kept(),
                _ => Equation::held(self.compliance, self.compliance * self.lambda - self.slip),
            };
        };
        // Slip leads against the multiplier; one that does not yet has no speed.
        let Limit { shear, by_pressure, by_speed } = self.limit((-sense * self.slip).max(0.0));
        // Divided by `c`: then it is of the size of other rows.
        let by = 1.0 / self.c;
        Equation {
            acts: true,
            // What weakens faster than bodies give way has no solution beside this one, but one at a larger speed: iterations go there.
            gradient: by * (self.film() + by_speed.max(-self.c)),
            diagonal: by,
            normal: -by * sense * by_pressure,
            right: by * (sense * (shear - by_pressure * self.normal) - self.film() * self.slip),
        }
    }

    /// The multiplier as it was, as far as the pressure bears it.
    fn kept(&self) -> Equation {
        let limit = self.limit(0.0).shear;
        let (by, right) = (1.0 / self.c, self.lambda.clamp(-limit, limit) / self.c);
        Equation { acts: true, gradient: 0.0, diagonal: by, normal: 0.0, right }
    }

    /// Whether a slip is more than round-off.
    fn is_clear(&self, off: f64) -> bool {
        off > tolerances::CLEARLY * self.tolerance
    }

    /// The state that the row asks for, and how strongly, if it is another one; `self` is what the frozen linearization makes of it.
    pub fn change(&self, state: RowState) -> Option<(RowState, f64)> {
        if self.is_held {
            return (state != self.held()).then(|| (self.held(), self.slip.abs()));
        }
        match state.sense() {
            None => {
                let (dry, limit) = (self.dry(), self.limit(0.0).shear);
                let over = (dry.abs() - limit) / self.c;
                self.is_clear(over).then(|| (RowState::sliding(dry), over))
            }
            Some(sense) => {
                let back = sense * self.slip;
                (self.is_clear(back) && self.limit(0.0).shear > 0.0).then_some((RowState::Closed, back))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Coulomb;

    fn row(law: &dyn FrictionLaw, normal: f64, lambda: f64, slip: f64) -> SlipRow<'_> {
        let (coefficient, speed, around, compliance, c, tolerance) = (0.3, 2.0, 1.0, 0.0, 5.0, 1e-9);
        SlipRow { law, coefficient, normal, lambda, slip, speed, around, compliance, c, tolerance, is_held: false }
    }

    /// Where a row solves the equation of its state, nothing is left of its residual unless it asks for another state; and what slides
    /// loses energy.
    #[test]
    fn the_solution_of_the_equation_has_no_residual() {
        let laws = [
            Coulomb::default(),
            Coulomb { adhesion: 0.2, transition_speed: 0.1, static_ratio: 1.5, ..Coulomb::default() },
            Coulomb { most: 0.2, ..Coulomb::default() },
            Coulomb { viscosity: 0.7, ..Coulomb::default() },
        ];
        for law in &laws {
            for (normal, lambda, slip) in [(2.0, 0.1, 0.0), (2.0, 1.0, -0.3), (2.0, -1.0, 0.3), (0.5, 0.0, 0.1), (0.0, 0.0, 0.2)] {
                let at = row(law, normal, lambda, slip);
                let state = at.first_state();
                let Equation { gradient, diagonal, normal: by, right, .. } = at.equation(state);
                let solved = if state == RowState::Closed {
                    row(law, normal, lambda, slip + right / gradient)
                } else {
                    row(law, normal, (right - by * normal) / diagonal, slip)
                };
                let asks = solved.change(state).is_some();
                assert!(asks || solved.residual().0.abs() < 1e-14, "{law:?} {normal} {lambda} {slip}");
                assert!(asks || solved.lambda * solved.slip <= 0.0);
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
        let slope = |f: &dyn Fn(f64) -> f64| (f(h) - f(-h)) / (2.0 * h * 5.0);
        assert!((slope(&|x| missed(normal + x, lambda, slip)) - by).abs() < 1e-9);
        assert!((slope(&|x| missed(normal, lambda + x, slip)) - diagonal).abs() < 1e-9);
        assert!((slope(&|x| missed(normal, lambda, slip + x)) - gradient).abs() < 1e-9);
        assert!((missed(normal, lambda, slip) / 5.0 - (diagonal * lambda + by * normal - right)).abs() < 1e-14);
    }
}
