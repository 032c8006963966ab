//! What a time integrator is: a row of data that says which force stands for a potential's in a step, how velocities and accelerations
//! follow from positions, what is remembered from step to step, and what is promised.
//!
//! A step solves the balance of momentum
//!
//! ```text
//! M (v_1 - v_0) / dt + w f + (1 - w) f_0 = 0
//! ```
//!
//! with the static forces `f` of the step (the scheme's [`Derivative`]) and `f_0` of the end of the step before, or, where forces act
//! longer, with what is left of those of all steps before ([`Lag`]). Velocity and acceleration at the end are affine in the motion `q_1 -
//! q_0` ([`Affine`]); the other terms are what is remembered ([`History`]). Whatever the coefficients, forces alone change momenta, so
//! that the ledger of every scheme closes.
//!
//! A step may consist of stages, each a scheme of its own, and coefficients may depend on the size of the step before ([`StepKind`]).
//!
//! Nobody asks which scheme runs: who needs to know something of it reads a field. A program beside this crate makes one in the same way
//! (`examples/newmark.rs`).

use super::derivative::Derivative;

/// A time integrator.
#[derive(Clone, Copy, Debug)]
pub struct Scheme {
    /// Name as written in a script.
    pub name: &'static str,
    /// One sentence for the reference.
    pub summary: &'static str,
    /// Which force stands for that of a potential.
    pub derivative: Derivative,
    /// What it remembers besides positions and velocities.
    pub remembers: &'static [History],
    /// Velocity at the end of a step.
    pub velocity: Affine,
    /// Acceleration there; read where it is remembered.
    pub acceleration: Affine,
    /// Share `w` of the forces of the step; the rest is that of the forces of the steps before.
    pub weight: f64,
    /// How forces act in the steps that follow.
    pub lag: Lag,
    /// How a step goes.
    pub step: StepKind,
    /// What it takes from vibrations of bodies besides.
    pub dissipation: Dissipation,
    /// Whether the discrete gradient of a body's energy begins with the mean of its stress over the step, not with the stress at its mean
    /// strain.
    pub averages_stress: bool,
    /// Numbers that a user has chosen, by their names.
    pub parameters: Parameters,
    /// What it keeps.
    pub promises: Promises,
    /// How far it is off where steps are short.
    pub error: LeadingError,
}

/// Error of a slow vibration with the frequency `omega`: the factor `z` of a step is off by
/// `|ln z - i omega dt| = first (omega dt)^2 + second (omega dt)^3`, so that the error of a motion `q` grows by
/// `first dt |q''| + second dt^2 |q'''|` in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeadingError {
    /// What makes a scheme one of first order, else 0.
    pub first: f64,
    /// What makes it one of second order.
    pub second: f64,
}

impl LeadingError {
    /// Of schemes that are the trapezoidal rule in small vibrations.
    pub const TRAPEZOIDAL: LeadingError = LeadingError { first: 0.0, second: 1.0 / 12.0 };
}

/// How the forces of a step act in the steps that follow.
///
/// The step's own forces are `w f`, what is remembered of those before `R = used m`. From them follow the force `phi_1` that the
/// acceleration at the end answers, `gamma phi_1 + (1 - gamma) phi_0 = w f + R`, and what is remembered next,
/// `m_1 = force f + inertia phi_1`. With `inertia = 0` that is the force at the end, and nothing older.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lag {
    /// Factor of what is remembered in this step.
    pub used: f64,
    /// Of the forces of this step in what the next one finds.
    pub force: f64,
    /// Of the force that the acceleration at the end answers there.
    pub inertia: f64,
    /// Share of the end in the mean acceleration of a step.
    pub gamma: f64,
}

impl Lag {
    /// Forces act in their own step, and by what is left of the whole of them in the next one.
    pub const fn once(weight: f64) -> Lag {
        Lag { used: 1.0, force: 1.0 - weight, inertia: 0.0, gamma: 1.0 }
    }

    /// Whether forces act longer than in the step that follows.
    pub fn is_long(&self) -> bool {
        self.inertia != 0.0
    }
}

/// What a step consists of.
#[derive(Clone, Copy, Debug)]
pub enum StepKind {
    /// At once, by the coefficients of the row.
    Whole,
    /// At once, by those of the row that belongs to the size of the step before over that of this one: 0 where none was. The row itself has
    /// those of equal steps.
    ByRatio(fn(f64) -> Scheme),
    /// In stages, one after the other: each has its share of the step, negative where it goes back, and is a scheme, which finds what the
    /// one before has left. What the row itself has is that of the last.
    Stages(&'static [(f64, Scheme)]),
    /// Without equations: positions follow from the forces at the start, with a mass at every node alone. No step may be longer than the
    /// fastest vibration admits.
    Explicit(Lumping),
    /// From equilibrium to equilibrium: nothing has a velocity, and the row has no coefficients that anybody reads.
    Equilibria,
}

/// How the mass of a cell is shared among its nodes, to be at the nodes alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lumping {
    /// By row sums where all are positive, else as [`Self::Diagonal`].
    Suitable,
    /// By the row sums of the consistent mass.
    RowSum,
    /// By its diagonal, scaled to the mass of the cell (Hinton, Rock and Zienkiewicz, Earthquake Eng. Struct. Dyn. 4, 1976).
    Diagonal,
}

impl Lumping {
    /// Every way with its name.
    pub const ALL: [(&'static str, Lumping); 3] =
        [("suitable", Lumping::Suitable), ("row_sum", Lumping::RowSum), ("hrz", Lumping::Diagonal)];

    /// Its name.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].0
    }
}

/// What a scheme takes from vibrations of bodies, in two parts, of which neither knows rigid motions: both momenta stay, the energy falls,
/// and the ledger has what it falls by (after Armero and Romero, Comput. Methods Appl. Mech. Engrg. 190, 2001).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dissipation {
    /// `chi` of the stress `chi/2 C (E_1 - E_0)` that acts in the middle of a step beside that of the law, from 0 to 1; `C` are the
    /// isotropic moduli of the law at rest.
    pub strain: f64,
    /// Share `k` of the velocities of the fastest vibrations that goes at the end of a step, from 0 to 1: `v - k (I - F)^2 v` with
    /// `F = (M + dt^2/4 K)^-1 M`, where `K` is the stiffness by `C` at the end of the step, without that of the stress.
    pub velocity: f64,
}

impl Dissipation {
    /// Nothing.
    pub const NONE: Dissipation = Dissipation { strain: 0.0, velocity: 0.0 };

    /// What leaves a share, from 0 to 1, of the amplitude of a vibration much faster than a step after each.
    pub const fn to_radius(radius: f64) -> Self {
        Dissipation { strain: (1.0 - radius) / (1.0 + radius), velocity: 1.0 - radius }
    }

    /// Whether it is nothing.
    pub fn is_none(&self) -> bool {
        self.strain == 0.0 && self.velocity == 0.0
    }
}

/// The numbers that make one row of a family, by their names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Names as written in a script.
    pub names: &'static [&'static str],
    /// Their values, 0 beyond the names.
    pub values: [f64; 2],
}

impl Parameters {
    /// Of a scheme that stands alone.
    pub const NONE: Parameters = Parameters { names: &[], values: [0.0; 2] };
}

/// A vector that steps find as the step before has left it. At the start, after `settle`, and for a state of another scheme it is computed
/// from positions and velocities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum History {
    /// Accelerations at the end of the step `[length/time^2]`: at the start those of the static forces, `M a_0 = -f_0`.
    Acceleration,
    /// Static forces there, those of contact among them, and what the [`Lag`] keeps of older ones `[force]`.
    Force,
    /// The static force that the acceleration answers, `M a_1 = -phi_1` at nodes that nothing holds `[force]`.
    Answered,
}

/// Coefficients, without dimension, of a quantity at the end of a step of size `dt`:
/// `moved (q_1 - q_0) + velocity dt v_0 + acceleration dt^2 a_0`, divided by `dt` for a velocity and by `dt^2` for an acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// Of the motion in the step.
    pub moved: f64,
    /// Of the velocity at its start.
    pub velocity: f64,
    /// Of the acceleration at its start, which is then remembered.
    pub acceleration: f64,
}

impl Affine {
    /// None of all: what nobody reads.
    pub const NONE: Affine = Affine { moved: 0.0, velocity: 0.0, acceleration: 0.0 };

    /// A component of a velocity after a step that moves it by `change` `[length/time]`; `a_0` is 0 where no accelerations are remembered.
    #[inline(always)]
    pub fn velocity(self, change: f64, v_0: f64, dt: f64) -> f64 {
        self.moved / dt * change + self.velocity * v_0
    }

    /// What the acceleration at the start adds to that.
    #[inline(always)]
    pub fn velocity_by(self, a_0: f64, dt: f64) -> f64 {
        self.acceleration * dt * a_0
    }

    /// A component of an acceleration `[length/time^2]`.
    #[inline(always)]
    pub fn acceleration(self, change: f64, v_0: f64, a_0: f64, dt: f64) -> f64 {
        (self.moved * change + dt * (self.velocity * v_0 + dt * self.acceleration * a_0)) / (dt * dt)
    }
}

/// What a scheme keeps in a motion without loads, for every step size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Promises {
    /// The total energy, but for what the ledger has as dissipation: it never grows.
    pub energy: bool,
    /// The linear momentum.
    pub momentum: bool,
    /// The angular momentum.
    pub angular_momentum: bool,
    /// Order of accuracy in the step size.
    pub order: usize,
}

impl Scheme {
    /// Whether a vector is remembered from step to step.
    pub fn remembers(&self, what: History) -> bool {
        self.remembers.contains(&what)
    }

    /// Names and values of its parameters.
    pub fn given(&self) -> impl Iterator<Item = (&'static str, f64)> {
        self.parameters.names.iter().copied().zip(self.parameters.values)
    }

    /// The scheme with its parameters.
    pub fn describe(&self) -> String {
        let mut given: Vec<String> = self.given().map(|(name, value)| format!("{name} = {value}")).collect();
        given.extend(self.lumping().filter(|lumping| *lumping != Lumping::Suitable).map(|lumping| format!("mass = {}", lumping.name())));
        if given.is_empty() { self.name.into() } else { format!("{}, {}", self.name, given.join(", ")) }
    }

    /// The row by which a step of a size goes after one of size `before`, 0 where none was.
    pub fn after(&self, before: f64, dt: f64) -> Scheme {
        match self.step {
            StepKind::ByRatio(row) => Scheme { step: self.step, ..row(before / dt) },
            StepKind::Whole | StepKind::Stages(_) | StepKind::Explicit(_) | StepKind::Equilibria => *self,
        }
    }

    /// The stages of a step; none where it goes at once.
    pub fn stages(&self) -> &'static [(f64, Scheme)] {
        match self.step {
            StepKind::Stages(stages) => stages,
            StepKind::Whole | StepKind::ByRatio(_) | StepKind::Explicit(_) | StepKind::Equilibria => &[],
        }
    }

    /// Whether it goes back in time in one of its stages.
    pub fn goes_back(&self) -> bool {
        self.stages().iter().any(|(share, _)| *share < 0.0)
    }

    /// How the mass is put to the nodes, of a scheme that solves no equations.
    pub fn lumping(&self) -> Option<Lumping> {
        if let StepKind::Explicit(lumping) = self.step { Some(lumping) } else { None }
    }

    /// Whether steps go from equilibrium to equilibrium, without inertia.
    pub fn is_static(&self) -> bool {
        matches!(self.step, StepKind::Equilibria)
    }

    /// Whether the forces of some step act longer than in the one that follows.
    pub fn is_long(&self) -> bool {
        self.lag.is_long() || self.stages().iter().any(|(_, stage)| stage.lag.is_long())
    }

    /// True if an impact may change the velocities at the end of a step: the scheme has no history and no stages.
    pub fn solves_impacts(&self) -> bool {
        self.remembers.is_empty() && matches!(self.step, StepKind::Whole)
    }

    /// What is remembered of forces that have been the same for long, over the force.
    pub fn left(&self) -> f64 {
        self.lag.force + self.lag.inertia
    }

    /// Factor of the mass in the derivative of the inertia force with respect to `q_1` `[1/time^2]`.
    #[inline(always)]
    pub fn inertia(&self, dt: f64) -> f64 {
        self.velocity.moved / (dt * dt)
    }

    /// The motion that changes no velocity, beside which [`Self::inertia`] takes all others: times of `v_0` and of `a_0` in it.
    #[inline(always)]
    pub fn drift(&self, dt: f64) -> [f64; 2] {
        let Affine { moved, velocity, acceleration } = self.velocity;
        [(1.0 - velocity) / moved * dt, -acceleration / moved * dt * dt]
    }

    /// The motion beyond that drift which changes a velocity by `change` `[length]`.
    #[inline(always)]
    pub fn motion(&self, change: f64, dt: f64) -> f64 {
        dt / self.velocity.moved * change
    }

    /// Velocity where the forces of a step act: at its end, or the mean of both ends.
    pub fn velocity_of_forces(&self) -> Affine {
        let share = self.derivative.placement().share;
        let Affine { moved, velocity, acceleration } = self.velocity;
        Affine { moved: share * moved, velocity: share * velocity + (1.0 - share), acceleration: share * acceleration }
    }

    /// Whether the row is a scheme at all: motion without forces and motion under a constant one are what they should be, and what it reads
    /// it remembers.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub fn check(&self) -> Result<(), &'static str> {
        let StepKind::Stages(stages) = self.step else { return self.check_row(self.left()) };
        let mut found = self.left();
        for (share, stage) in stages {
            if !share.is_normal() {
                return Err("a stage takes no time");
            }
            stage.check_row(found)?;
            found = stage.left();
        }
        let whole: f64 = stages.iter().map(|(share, _)| share).sum();
        let ends_as_the_row = stages.last().is_some_and(|(_, last)| last.left() == self.left() && last.remembers == self.remembers);
        if (whole - 1.0).abs() < 8.0 * f64::EPSILON && ends_as_the_row { Ok(()) } else { Err("the stages are no step together") }
    }

    /// Whether velocities may be changed at the end of a step, by the shares that it has.
    fn can_dissipate(&self) -> bool {
        let Dissipation { strain, velocity } = self.dissipation;
        let are_shares = [strain, velocity].iter().all(|share| (0.0..=1.0).contains(share));
        are_shares && self.remembers.is_empty() && matches!(self.step, StepKind::Whole)
    }

    /// Whether a row is a scheme where a steady force is remembered by a factor.
    fn check_row(&self, found: f64) -> Result<(), &'static str> {
        const ROUND_OFF: f64 = 8.0 * f64::EPSILON;
        let is = |value: f64, expected: f64| (value - expected).abs() <= ROUND_OFF * (1.0 + self.velocity.moved);
        let (v, a) = (self.velocity, self.acceleration);
        let asks = [
            (v.moved > 0.0 && v.moved.is_finite(), "the velocity does not grow with the motion"),
            (is(v.moved + v.velocity, 1.0), "a steady motion changes its velocity: `velocity.moved` + `velocity.velocity` is not 1"),
            (self.weight > 0.0 && self.weight <= 1.0, "the share of the forces is not in (0, 1]"),
            (
                (self.weight < 1.0) == self.remembers(History::Force),
                "forces are remembered exactly where their share `weight` is less than 1",
            ),
            (self.weight == 1.0 || is(self.weight + self.lag.used * found, 1.0), "a steady force does not act as a whole"),
            (
                self.lag.gamma > 0.0 && (self.lag.gamma == 1.0 || !self.lag.is_long() || self.remembers(History::Answered)),
                "the force that accelerations answer is read and not remembered",
            ),
            (v.acceleration == 0.0 || self.remembers(History::Acceleration), "the acceleration is read and not remembered"),
            (
                !self.remembers(History::Acceleration) || is(a.moved + a.velocity, 0.0) && is(0.5 * a.moved + a.acceleration, 1.0),
                "a steady motion has an acceleration, or a motion of constant acceleration has another one",
            ),
            (
                self.dissipation.is_none() || self.can_dissipate(),
                "shares that dissipate are in [0, 1], in whole steps that remember nothing",
            ),
        ];
        asks.into_iter().find(|(holds, _)| !holds).map_or(Ok(()), |(_, wrong)| Err(wrong))
    }
}

impl PartialEq for Scheme {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name && self.parameters == other.parameters && self.lumping() == other.lumping()
    }
}

impl Eq for Scheme {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrators::{BACKWARD_EULER, CATALOGUE, ENERGY_MOMENTUM, NEWMARK, TRAPEZOIDAL};

    #[test]
    fn every_row_of_the_catalogue_is_a_scheme() {
        assert!(CATALOGUE.iter().all(|scheme| scheme.check() == Ok(())));
        assert!(Scheme { weight: 0.5, ..ENERGY_MOMENTUM }.check().is_err(), "the other half is remembered by nobody");
    }

    /// The equations of the method, for any motion.
    #[test]
    fn velocity_and_acceleration_of_newmark_are_those_of_its_equations() {
        let (beta, gamma, dt) = (0.3025, 0.6, 0.07);
        let (change, v_0, a_0) = (0.3, -1.7, 4.1);
        let v_1 = NEWMARK.velocity.velocity(change, v_0, dt) + NEWMARK.velocity.velocity_by(a_0, dt);
        let a_1 = NEWMARK.acceleration.acceleration(change, v_0, a_0, dt);
        assert!((change - dt * v_0 - dt * dt * ((0.5 - beta) * a_0 + beta * a_1)).abs() < 1e-14);
        assert!((v_1 - v_0 - dt * ((1.0 - gamma) * a_0 + gamma * a_1)).abs() < 1e-13);
        // What changes a velocity is the motion beyond the drift.
        let [of_velocity, of_acceleration] = NEWMARK.drift(dt);
        let opposed = NEWMARK.inertia(dt) * (change - of_velocity * v_0 - of_acceleration * a_0);
        assert!((opposed - (v_1 - v_0) / dt).abs() < 1e-11);
        assert!((NEWMARK.motion(v_1 - v_0, dt) - opposed / NEWMARK.inertia(dt)).abs() < 1e-14);
    }

    #[test]
    fn forces_of_the_middle_act_at_the_mean_velocity() {
        assert_eq!(ENERGY_MOMENTUM.velocity_of_forces(), Affine { moved: 1.0, velocity: 0.0, acceleration: 0.0 });
        assert_eq!(TRAPEZOIDAL.velocity_of_forces(), TRAPEZOIDAL.velocity);
        assert_eq!(BACKWARD_EULER.velocity_of_forces(), BACKWARD_EULER.velocity);
    }
}
