//! Several tangential constraints beside a normal constraint in space: slip and multiplier with two components, of a ball joint three.
//!
//! With the dry multiplier `s = lambda + F u` (film constant `F`), its limit `L`, and the size `r` of the slip for which a constraint that
//! slipped before has zero slip rate at the end of the step (0 for others), the admissible slips and multipliers are
//!
//! ```text
//! |u| < r: s = 0 (turns)    |u| = r: s = -a u/r, 0 <= a <= L (stops)    |u| > r: s = -L u/|u| (slides)
//! ```
//!
//! and for `r = 0`, `u = 0` all `|s| <= L` (sticks), so that `lambda . u <= 0` always. Equivalently `s = N(z)` with the trial `z = s - c u`
//! for any `c > 0`: `N = z` up to `|z| = L` (sticks), or `0` up to `c r` (turns), `z - c r z/|z|` up to `c r + L` (stops), `L z/|z|` beyond
//! (slides). Newton's equations linearize this equation; `N` has the derivatives `n` along `z` and `m` perpendicular to it,
//!
//! ```text
//! (1 - N') (ds)/c + N' du = (N - s)/c,    N' = n z z/|z|^2 + m (1 - z z/|z|^2)
//! ```
//!
//! (Alart and Curnier, CMAME 92, 1991, for `r = 0`). With the stiffness `kappa` of the node in the step, a multiplier of `kappa`
//! corresponds to a unit slip. Along `z` and perpendicular to it the equation is divided by `n + (1 - n) kappa/c` with the derivative `n`
//! in that direction, so that equations of slipping constraints have entries of order one for every step size. The residual uses a constant
//! `c`; iterations use `max(c, 0.1 kappa)`, because with a small `c` relative to `kappa` the trial depends on multipliers only. To both the
//! film constant `F` is added: without it a slip `u` with `|F u| > |c u|` has a trial that sticks.

use super::friction_rows::NormalState;
use super::laws::{Equation, RowState};
use crate::contact::Limit;
use crate::math::tolerances;

/// Components of a slip or of its multipliers; zero beyond the number of tangential constraints.
type Vector = [f64; 3];

/// Tangential constraints of a group at an iterate, one for each component.
pub struct SlipVector<'a> {
    /// Data of the normal constraint.
    pub pressed: NormalState<'a>,
    /// Number of components, 2 or 3.
    pub count: usize,
    /// Tangential multipliers.
    pub lambda: Vector,
    /// Slip of the step.
    pub slip: Vector,
    /// Slip for which a constraint that slipped before has zero slip rate at the end of the step; 0 for others.
    pub rest: Vector,
}

/// Dry multiplier `N(z)` at a trial multiplier `z`, and its derivatives along `z` and perpendicular to it.
struct Map {
    value: Vector,
    along: f64,
    across: f64,
}

fn size(a: Vector) -> f64 {
    a.into_iter().fold(0.0, f64::hypot)
}

fn dot(a: Vector, b: Vector) -> f64 {
    a.into_iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Returns `a + s b`.
fn plus(a: Vector, s: f64, b: Vector) -> Vector {
    std::array::from_fn(|i| a[i] + s * b[i])
}

/// Direction of a vector; the first axis for a zero vector.
fn direction(a: Vector) -> Vector {
    let size = size(a);
    if size > 0.0 { a.map(|x| x / size) } else { std::array::from_fn(|i| if i == 0 { 1.0 } else { 0.0 }) }
}

impl SlipVector<'_> {
    /// Size of `rest`; 0 at round-off level.
    fn stop(&self) -> f64 {
        let size = size(self.rest);
        if self.pressed.is_clear(size) { size } else { 0.0 }
    }

    fn limit(&self, slip: Vector) -> Limit {
        self.pressed.limit(size(slip))
    }

    fn film(&self) -> f64 {
        self.pressed.film(size(self.slip))
    }

    /// Multiplier of dry friction: the tangential multiplier without the part of the lubricant film.
    fn dry(&self) -> Vector {
        plus(self.lambda, self.film(), self.slip)
    }

    /// Multiplier per slip `c` in the trial multiplier of an iteration.
    fn pace(&self) -> f64 {
        self.pressed.pace(size(self.slip))
    }

    /// Trial multiplier `z = s - c u`.
    fn trial(&self, c: f64) -> Vector {
        plus(self.dry(), -c, self.slip)
    }

    /// Friction state of the trial multiplier `z = s - c u`.
    fn nearest(&self, c: f64, limit: f64) -> RowState {
        let (size, stop) = (size(self.trial(c)), c * self.stop());
        match stop > 0.0 {
            true if size < stop => RowState::Turns,
            true if size <= stop + limit => RowState::Stops,
            false if size <= limit => RowState::Closed,
            _ => RowState::Forward,
        }
    }

    /// Dry multiplier `N(z)` in a state, at the trial multiplier `z = s - c u`.
    fn map(&self, c: f64, state: RowState, limit: f64) -> Map {
        let z = self.trial(c);
        let (size, stop) = (size(z), c * self.stop());
        let share = |part: f64| if size > part { part / size } else { 1.0 };
        match state {
            RowState::Turns | RowState::Open => Map { value: [0.0; 3], along: 0.0, across: 0.0 },
            RowState::Stops => {
                let rest = 1.0 - share(stop);
                Map { value: plus(z, -stop, direction(z)), along: 1.0, across: rest }
            }
            RowState::Forward | RowState::Backward => {
                Map { value: direction(z).map(|e| limit * e), along: 0.0, across: if limit > 0.0 { share(limit) } else { 0.0 } }
            }
            RowState::Closed => Map { value: z, along: 1.0, across: 1.0 },
        }
    }

    /// State at the first iteration.
    pub fn first_state(&self) -> RowState {
        let limit = self.limit(self.slip).shear;
        // Constraints without pressure and motion start sticking.
        let is_idle = self.pressed.normal <= 0.0 && self.trial(self.pace()) == [0.0; 3];
        if limit > 0.0 || is_idle { self.nearest(self.pace(), limit) } else { RowState::Forward }
    }

    /// True if the direction of the trial is above round-off of the limit; otherwise equations of slipping constraints have an arbitrary
    /// direction.
    pub fn is_directed(&self) -> bool {
        let trial = size(self.trial(self.pace()));
        trial > 0.0 && trial >= tolerances::UNDIRECTED * self.limit(self.slip).shear
    }

    /// Residual at an uncovered node: its multiplier divided by `c`, a slip, and the energy of that slip.
    pub fn excess(&self) -> (f64, f64) {
        (size(self.lambda) / self.pressed.c, dot(self.lambda, self.slip))
    }

    /// Natural residual as a slip, and its energy.
    pub fn residual(&self) -> (f64, f64) {
        let (c, limit) = (self.pressed.c + self.film(), self.limit(self.slip).shear);
        let off = plus(self.dry(), -1.0, self.map(c, self.nearest(c, limit), limit).value);
        let of_slip = tolerances::SLIP_ROUND_OFF * self.pressed.tolerance * self.pressed.stiffness;
        let noise = tolerances::SLIP_NOISE * (limit + size(self.lambda)) + of_slip;
        ((size(off) - noise).max(0.0) / self.pressed.c, dot(off, self.slip))
    }

    /// Equations of the constraints in a state; those beyond the number of constraints are inactive.
    pub fn equations(&self, state: RowState) -> [Equation; 3] {
        if state == RowState::Open {
            return [Equation::OPEN; 3];
        }
        let NormalState { stiffness, compliance, normal, .. } = self.pressed;
        let c = self.pace();
        let e = direction(self.trial(c));
        let slides = matches!(state, RowState::Forward | RowState::Backward);
        // Slip has the opposite direction of the multiplier; with the wrong sign its speed counts as zero.
        let at = if slides { (-dot(e, self.slip)).max(0.0) } else { size(self.slip) };
        let Limit { shear, by_pressure, by_speed } = self.pressed.limit(at);
        let (Map { value, along, across }, film, by) = (self.map(c, state, shear), self.film(), 1.0 / c);
        let scale = |n: f64| 1.0 / (n + (1.0 - n) * by * stiffness);
        let (scale_along, scale_across) = (scale(along), scale(across));
        let matrix = |along: f64, across: f64| -> [Vector; 3] {
            let (along, across) = (scale_along * along, scale_across * across);
            std::array::from_fn(|i| std::array::from_fn(|j| (along - across) * e[i] * e[j] + if i == j { across } else { 0.0 }))
        };
        // If the friction force decreases faster than the bodies' compliance, no solution exists near this one, only at a larger speed:
        // iterations move there.
        let weakening = if slides { by_speed.max(-c) } else { 0.0 };
        let gradient = matrix(along + by * ((1.0 - along) * film + weakening), across + by * (1.0 - across) * film);
        let diagonal = matrix(by * (1.0 - along) + compliance * along, by * (1.0 - across) + compliance * across);
        let by_normal = if slides { scale_along * by * by_pressure } else { 0.0 };
        let missed = plus(value, -1.0, self.dry());
        let scaled = plus(missed.map(|x| scale_across * x), (scale_along - scale_across) * dot(missed, e), e);
        std::array::from_fn(|i| {
            if i >= self.count {
                return Equation::OPEN;
            }
            let beside = |by: usize| {
                let j = (i + by) % self.count;
                if by < self.count { [gradient[i][j], diagonal[i][j]] } else { [0.0; 2] }
            };
            let right = by * scaled[i] + dot(diagonal[i], self.lambda) - by_normal * normal * e[i];
            Equation {
                acts: true,
                gradient: gradient[i][i],
                diagonal: diagonal[i][i],
                normal: -by_normal * self.pressed.sense * e[i],
                beside: [beside(1), beside(2)],
                right,
                compliance,
            }
        })
    }

    /// New state and magnitude of the violation that requires it, or `None`; `self` has the values of the frozen linearization at the
    /// iterate `iterate`.
    ///
    /// The frozen equations of slip have the direction `e` of the trial at the iterate and leave the multiplier across `e` to that of
    /// no slip across, so that stick and slip are decided along `e`: stick by `s . e <= L`, slip by `-u . e >= 0`. With `|s| <= L` no set
    /// would be a solution where the multiplier of a node at its limit turns: across `e` it exceeds the limit in both states.
    pub fn change(&self, state: RowState, iterate: &Self) -> Option<(RowState, f64)> {
        let (dry, stop, c) = (self.dry(), self.stop(), self.pressed.c);
        let most = self.limit([0.0; 3]).shear / c;
        let e = direction(iterate.trial(iterate.pace()));
        // Slip against the trial, and multiplier opposite to the slip.
        let (forward, against) = (-dot(e, self.slip), -dot(dry, direction(self.slip)) / c);
        let (next, off) = match state {
            RowState::Open | RowState::Closed if stop > 0.0 => (RowState::Turns, size(self.slip)),
            RowState::Open | RowState::Closed => (RowState::Forward, dot(e, dry) / c - most),
            RowState::Turns => (RowState::Stops, size(self.slip) - stop),
            RowState::Stops if against < 0.0 => (RowState::Turns, -against),
            RowState::Stops => (RowState::Forward, against - self.limit(self.rest).shear / c),
            // Without a friction limit slip is the only state.
            RowState::Forward | RowState::Backward if most <= 0.0 => return None,
            RowState::Forward | RowState::Backward => (if stop > 0.0 { RowState::Stops } else { RowState::Closed }, stop - forward),
        };
        self.pressed.is_clear(off).then_some((next, off))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::contact::{Coulomb, FrictionLaw};

    fn rows(law: &dyn FrictionLaw, normal: f64, lambda: Vector, slip: Vector, rest: Vector) -> SlipVector<'_> {
        let (coefficient, speed, around, compliance, c, tolerance) = (0.3, 2.0, 1.0, 0.0, 5.0, 1e-9);
        let pressed =
            NormalState { law, coefficient, normal, sense: 1.0, speed, lagged: None, around, compliance, c, stiffness: 3.0 * c, tolerance };
        SlipVector { pressed, count: 2, lambda, slip, rest }
    }

    /// Points on the graph of the friction law for a slip limit and a size of `rest`: multiplier, slip, state.
    fn places(limit: f64, r: f64) -> Vec<(Vector, Vector, RowState)> {
        let e = [0.6, -0.8, 0.0];
        let at = |slip: f64, s: f64| (e.map(|e| -s * e), e.map(|e| slip * e));
        let named = |(lambda, slip), state| (lambda, slip, state);
        if r == 0.0 {
            let stuck = (e.map(|e| 0.5 * limit * e), [0.0; 3], RowState::Closed);
            return vec![stuck, named(at(0.1, limit), RowState::Forward)];
        }
        vec![
            named(at(0.5 * r, 0.0), RowState::Turns),
            named(at(r, 0.4 * limit), RowState::Stops),
            named(at(r + 0.2, limit), RowState::Forward),
        ]
    }

    #[test]
    fn what_is_on_the_graph_has_no_residual_and_asks_for_nothing() {
        let law = Coulomb::default();
        for r in [0.0, 0.2] {
            for (lambda, slip, state) in places(0.6, r) {
                let at = rows(&law, 2.0, lambda, slip, [0.0, r, 0.0]);
                assert_eq!(at.first_state(), state);
                assert!(at.residual().0 < 1e-15 && dot(lambda, slip) <= 0.0, "{state:?}");
                assert_eq!(at.change(state, &at), None, "{state:?}");
                // The equations are satisfied there by a zero increment.
                for (k, equation) in at.equations(state).into_iter().take(2).enumerate() {
                    let Equation { diagonal, normal, beside, right, .. } = equation;
                    let left = diagonal * lambda[k] + beside[0][1] * lambda[1 - k] + normal * 2.0;
                    assert!((left - right).abs() < 1e-15, "{state:?}: {left} {right}");
                }
            }
        }
    }

    /// From every state the changes approach the solution along the graph.
    #[test]
    fn rows_change_their_state_along_the_graph() {
        let law = Coulomb::default();
        for r in [0.0, 0.2] {
            let places = places(0.6, r);
            for (index, (lambda, slip, _)) in places.iter().enumerate() {
                let at = rows(&law, 2.0, *lambda, *slip, [0.0, r, 0.0]);
                for (other, (.., wrong)) in places.iter().enumerate() {
                    let asked = at.change(*wrong, &at).map(|(next, _)| next);
                    let next = if other < index { other + 1 } else { other.saturating_sub(1) };
                    assert!(asked.is_none() || asked == Some(places[next].2), "{slip:?}: {wrong:?} asks for {asked:?}");
                }
            }
        }
    }

    /// Newton's equations have the derivatives of the map of the trial.
    #[test]
    fn equations_are_the_derivatives_of_the_map() {
        let law = Coulomb { static_ratio: 1.6, transition_speed: 0.4, exponent: 2.0, viscosity: 0.3, ..Coulomb::default() };
        let h = 1e-6;
        let cases = [
            (RowState::Closed, [0.2, 0.1, 0.0], [0.01, 0.02, 0.0], 0.0),
            (RowState::Forward, [0.9, -0.3, 0.0], [-0.12, 0.05, 0.0], 0.0),
            (RowState::Stops, [-0.1, 0.4, 0.0], [0.06, -0.2, 0.0], 0.2),
            (RowState::Turns, [0.01, 0.02, 0.0], [0.03, 0.05, 0.0], 0.2),
        ];
        for (state, lambda, slip, r) in cases {
            // Along the trial and perpendicular to it, divided by the scale that makes the entries of order one.
            let at = rows(&law, 1.7, lambda, slip, [r, 0.0, 0.0]);
            let (c, e) = (at.pace(), direction(at.trial(at.pace())));
            let Map { along, across, .. } = at.map(c, state, at.pressed.limit((-dot(e, slip)).max(0.0)).shear);
            let [along, across] = [along, across].map(|n| 1.0 / (n * c + (1.0 - n) * at.pressed.stiffness));
            let scaled = |off: Vector| plus(off.map(|x| across * x), (along - across) * dot(off, e), e);
            // Friction limit at the speed opposite to the trial, as in the equation.
            let missed = |normal: f64, lambda: Vector, slip: Vector| {
                let at = rows(&law, normal, lambda, slip, [r, 0.0, 0.0]);
                let speed = (-dot(direction(at.trial(c)), slip)).max(0.0);
                scaled(plus(at.dry(), -1.0, at.map(c, state, at.pressed.limit(speed).shear).value))
            };
            let equations = rows(&law, 1.7, lambda, slip, [r, 0.0, 0.0]).equations(state);
            for (i, Equation { gradient, diagonal, normal, beside, .. }) in equations.into_iter().take(2).enumerate() {
                let j = 1 - i;
                let unit = |k: usize, s: f64| -> Vector { std::array::from_fn(|l| if l == k { s } else { 0.0 }) };
                let slope = |f: &dyn Fn(f64) -> Vector| (f(h)[i] - f(-h)[i]) / (2.0 * h);
                let by_normal = slope(&|s| missed(1.7 + s, lambda, slip));
                let by_lambda = [i, j].map(|k| slope(&|s| missed(1.7, plus(lambda, 1.0, unit(k, s)), slip)));
                assert!((by_normal - normal).abs() < 1e-8, "{state:?} {by_normal} {normal}");
                assert!((by_lambda[0] - diagonal).abs() < 2e-3 && (by_lambda[1] - beside[0][1]).abs() < 2e-3, "{state:?} {by_lambda:?}");
                let by_slip = [i, j].map(|k| slope(&|s| missed(1.7, lambda, plus(slip, 1.0, unit(k, s)))));
                // A film also rotates the trial, and the speed depends on its direction; terms of that size are omitted.
                assert!((by_slip[0] - gradient).abs() < 0.05 && (by_slip[1] - beside[0][0]).abs() < 0.05, "{state:?} {by_slip:?}");
            }
        }
    }
}
