//! A time integrator as a row of data: the algorithmic gradient of potentials, the update coefficients of velocities and accelerations, the
//! history variables and the conservation properties.
//!
//! A step solves the balance of momentum
//!
//! ```text
//! M (v_1 - v_0) / dt + w f + (1 - w) f_0 = 0
//! ```
//!
//! with the static forces `f` of the step (evaluated by the scheme's [`Derivative`]) and `f_0` of the end of the step before. Where forces
//! act in more than one later step, a weighted sum of earlier forces takes the place of `f_0` ([`LagWeights`]). Velocity and acceleration
//! at the end are linear in the displacement `q_1 - q_0` ([`UpdateCoefficients`]); the constant terms come from the history variables
//! ([`History`]). For all coefficients momenta are changed by forces alone, so that the ledger of every scheme closes.
//!
//! A step may consist of stages, each a scheme of its own, and coefficients may depend on the size of the step before ([`StepKind`]).
//!
//! The solver branches on fields of the row and never on the name of a scheme. A program beside this crate defines a scheme in the same way
//! (`examples/newmark.rs`).

use super::derivative::Derivative;

/// A time integrator.
#[derive(Clone, Copy, Debug)]
pub struct Scheme {
    /// Name as written in a script.
    pub name: &'static str,
    /// Summary for the reference, one sentence.
    pub summary: &'static str,
    /// Algorithmic gradient that gives the force of a potential.
    pub derivative: Derivative,
    /// History variables of the scheme, besides positions and velocities.
    pub remembers: &'static [History],
    /// Update coefficients of the velocity at the end of a step.
    pub velocity: UpdateCoefficients,
    /// Update coefficients of the acceleration at the end of a step; used if accelerations are a history variable.
    pub acceleration: UpdateCoefficients,
    /// Weight `w` of the forces of the step; forces of earlier steps have the weight `1 - w`.
    pub weight: f64,
    /// Weights of the forces of a step in later steps.
    pub lag: LagWeights,
    /// Sequence of the step: whole, in stages, explicit or static.
    pub step: StepKind,
    /// Algorithmic dissipation of the vibrations of bodies.
    pub dissipation: Dissipation,
    /// True if the discrete gradient of a body's energy is built on the mean stress of the step, false if on the stress at the mean strain.
    pub averages_stress: bool,
    /// User-defined parameters by name.
    pub parameters: Parameters,
    /// Quantities that the scheme conserves, and its order.
    pub promises: ConservedQuantities,
    /// Leading error coefficients for small time step sizes.
    pub error: LeadingError,
}

/// Error of a slow vibration with the frequency `omega`: the factor `z` of a step is off by
/// `|ln z - i omega dt| = first (omega dt)^2 + second (omega dt)^3`, so that the error of a motion `q` grows by
/// `first dt |q''| + second dt^2 |q'''|` in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeadingError {
    /// Coefficient of `(omega dt)^2`; nonzero for schemes of first order.
    pub first: f64,
    /// Coefficient of `(omega dt)^3`.
    pub second: f64,
}

impl LeadingError {
    /// Leading error of schemes that reduce to the trapezoidal rule in small vibrations.
    pub const TRAPEZOIDAL: LeadingError = LeadingError { first: 0.0, second: 1.0 / 12.0 };
}

/// Weights of the forces of a step in later steps.
///
/// The forces of the step enter with `w f`, the force history `m` of earlier steps with `R = used m`. The force `phi_1` that balances the
/// inertia at the end follows from `gamma phi_1 + (1 - gamma) phi_0 = w f + R`, the next force history is `m_1 = force f + inertia phi_1`.
/// With `inertia = 0` it contains the forces of the last step alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LagWeights {
    /// Factor of the force history in this step.
    pub used: f64,
    /// Weight of this step's forces in the force history passed to the next step.
    pub force: f64,
    /// Weight of the force `phi_1` that balances the inertia at the end, in the force history passed to the next step.
    pub inertia: f64,
    /// Weight of the end in the mean acceleration of a step.
    pub gamma: f64,
}

impl LagWeights {
    /// Forces enter their own step and, with the remaining weight, only the next step.
    pub const fn once(weight: f64) -> LagWeights {
        LagWeights { used: 1.0, force: 1.0 - weight, inertia: 0.0, gamma: 1.0 }
    }

    /// True if forces enter more than one later step.
    pub fn is_long(&self) -> bool {
        self.inertia != 0.0
    }
}

/// Kind of a step: number of systems of equations, and their coefficients.
#[derive(Clone, Copy, Debug)]
pub enum StepKind {
    /// One system of equations with the coefficients of the scheme.
    Whole,
    /// One system of equations with coefficients that depend on the ratio of the previous to the present time step size, 0 without a
    /// previous step. The row itself holds the coefficients of equal steps.
    ByRatio(fn(f64) -> Scheme),
    /// Consecutive stages, each with its fraction of the step (negative backward in time) and its own scheme, which starts from the history
    /// variables of the stage before. The coefficients of the row itself are those of the last stage.
    Stages(&'static [(f64, Scheme)]),
    /// Explicit: positions follow from the forces at the start with a lumped mass. The time step size is bounded by the highest natural
    /// frequency.
    Explicit(Lumping),
    /// Static: from equilibrium to equilibrium without velocities; the update coefficients of the scheme are unused.
    Equilibria,
}

/// Lumping of the mass of a cell to its nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lumping {
    /// Row sums where all are positive, else [`Self::Diagonal`].
    Suitable,
    /// Row sums of the consistent mass matrix.
    RowSum,
    /// Diagonal of the consistent mass matrix, scaled to the mass of the cell (Hinton, Rock and Zienkiewicz, Earthquake Eng. Struct. Dyn.
    /// 4, 1976).
    Diagonal,
}

impl Lumping {
    /// Every lumping with its name in scripts.
    pub const ALL: [(&'static str, Lumping); 3] =
        [("suitable", Lumping::Suitable), ("row_sum", Lumping::RowSum), ("hrz", Lumping::Diagonal)];

    /// Name of the lumping in scripts.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].0
    }
}

/// Algorithmic dissipation of a scheme in two parts, both zero in rigid motions: linear and angular momentum are conserved, the energy
/// decreases, and the ledger books the decrease (after Armero and Romero, Comput. Methods Appl. Mech. Engrg. 190, 2001).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dissipation {
    /// `chi` of the stress `chi/2 C (E_1 - E_0)` that acts in the middle of a step beside that of the law, from 0 to 1; `C` are the
    /// isotropic moduli of the law at rest.
    pub strain: f64,
    /// Fraction `k` of the velocities of the fastest vibrations removed at the end of a step, from 0 to 1: `v - k (I - F)^2 v` with
    /// `F = (M + dt^2/4 K)^-1 M`, where `K` is the stiffness by `C` at the end of the step, without geometric stiffness.
    pub velocity: f64,
}

impl Dissipation {
    /// No algorithmic dissipation.
    pub const NONE: Dissipation = Dissipation { strain: 0.0, velocity: 0.0 };

    /// Returns the dissipation with the spectral radius `radius`, from 0 to 1, for vibrations much faster than the time step.
    pub const fn to_radius(radius: f64) -> Self {
        Dissipation { strain: (1.0 - radius) / (1.0 + radius), velocity: 1.0 - radius }
    }

    /// True if the scheme has no algorithmic dissipation.
    pub fn is_none(&self) -> bool {
        self.strain == 0.0 && self.velocity == 0.0
    }
}

/// Parameter values that determine a row of a family, by name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Names as written in a script.
    pub names: &'static [&'static str],
    /// Parameter values, 0 beyond the names.
    pub values: [f64; 2],
}

impl Parameters {
    /// No parameters, for schemes outside of families.
    pub const NONE: Parameters = Parameters { names: &[], values: [0.0; 2] };
}

/// A history variable: a vector that a step takes from the end of the previous one. At the start, after `settle`, and for a state of
/// another scheme it is computed from positions and velocities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum History {
    /// Accelerations at the end of the step `[length/time^2]`; at the start those of the static forces, `M a_0 = -f_0`.
    Acceleration,
    /// Static forces at the end of the step, including contact forces, and the older forces that [`LagWeights`] retains `[force]`.
    Force,
    /// Static force that balances the inertia, `M a_1 = -phi_1` at nodes without support `[force]`.
    Answered,
}

/// Coefficients, without dimension, of a quantity at the end of a step of size `dt`:
/// `moved (q_1 - q_0) + velocity dt v_0 + acceleration dt^2 a_0`, divided by `dt` for a velocity and by `dt^2` for an acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UpdateCoefficients {
    /// Coefficient `c_q` of the displacement in the step.
    pub moved: f64,
    /// Coefficient `c_v` of the velocity at the start.
    pub velocity: f64,
    /// Coefficient `c_a` of the acceleration at the start; nonzero only for schemes with accelerations as history variables.
    pub acceleration: f64,
}

impl UpdateCoefficients {
    /// Zero coefficients, for rows whose coefficients are unused.
    pub const NONE: UpdateCoefficients = UpdateCoefficients { moved: 0.0, velocity: 0.0, acceleration: 0.0 };

    /// Velocity component after a step with the displacement component `change` `[length/time]`, without the contribution of the
    /// acceleration.
    #[inline(always)]
    pub fn velocity(self, change: f64, v_0: f64, dt: f64) -> f64 {
        self.moved / dt * change + self.velocity * v_0
    }

    /// Contribution of the acceleration at the start to a component of the velocity `[length/time]`.
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

/// Quantities that a scheme conserves in a motion without loads, for every time step size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ConservedQuantities {
    /// Total energy; it decreases only by the dissipation in the ledger.
    pub energy: bool,
    /// Linear momentum.
    pub momentum: bool,
    /// Angular momentum.
    pub angular_momentum: bool,
    /// Order of accuracy in the step size.
    pub order: usize,
}

impl Scheme {
    /// True if the scheme has the history variable `what`.
    pub fn remembers(&self, what: History) -> bool {
        self.remembers.contains(&what)
    }

    /// Names and values of the scheme's parameters.
    pub fn given(&self) -> impl Iterator<Item = (&'static str, f64)> {
        self.parameters.names.iter().copied().zip(self.parameters.values)
    }

    /// Name of the scheme with its parameters.
    pub fn describe(&self) -> String {
        let mut given: Vec<String> = self.given().map(|(name, value)| format!("{name} = {value}")).collect();
        given.extend(self.lumping().filter(|lumping| *lumping != Lumping::Suitable).map(|lumping| format!("mass = {}", lumping.name())));
        if given.is_empty() { self.name.into() } else { format!("{}, {}", self.name, given.join(", ")) }
    }

    /// Row for a step of size `dt` after a step of size `before`, 0 for the first step.
    pub fn after(&self, before: f64, dt: f64) -> Scheme {
        match self.step {
            StepKind::ByRatio(row) => Scheme { step: self.step, ..row(before / dt) },
            StepKind::Whole | StepKind::Stages(_) | StepKind::Explicit(_) | StepKind::Equilibria => *self,
        }
    }

    /// Stages of a step; empty for a step without stages.
    pub fn stages(&self) -> &'static [(f64, Scheme)] {
        match self.step {
            StepKind::Stages(stages) => stages,
            StepKind::Whole | StepKind::ByRatio(_) | StepKind::Explicit(_) | StepKind::Equilibria => &[],
        }
    }

    /// True if a stage goes backward in time.
    pub fn goes_back(&self) -> bool {
        self.stages().iter().any(|(share, _)| *share < 0.0)
    }

    /// Lumping of the mass; `None` unless the scheme is explicit.
    pub fn lumping(&self) -> Option<Lumping> {
        if let StepKind::Explicit(lumping) = self.step { Some(lumping) } else { None }
    }

    /// True if steps go from equilibrium to equilibrium, without inertia.
    pub fn is_static(&self) -> bool {
        matches!(self.step, StepKind::Equilibria)
    }

    /// True if forces of a step enter more than one later step (HHT, generalized-alpha).
    pub fn is_long(&self) -> bool {
        self.lag.is_long() || self.stages().iter().any(|(_, stage)| stage.lag.is_long())
    }

    /// True if an impact may change the velocities at the end of a step: the scheme is implicit, and no stage goes backward in time.
    pub fn solves_impacts(&self) -> bool {
        !self.is_static() && self.lumping().is_none() && !self.goes_back()
    }

    /// True if forces of constraints that enter two steps oscillate from step to step without damping, so that the energy of rigid bodies
    /// and of joints would grow: the trapezoidal rule and the members of other families that equal it (Cardona and Géradin, Comput.
    /// Struct. 33, 1989).
    pub fn swings_at_constraints(&self) -> bool {
        let UpdateCoefficients { moved, velocity, .. } = self.velocity;
        self.remembers(History::Force) && matches!(self.step, StepKind::Whole) && moved == 2.0 && velocity == -1.0
    }

    /// Fraction of a step at whose configuration the forces of joints act.
    pub fn share_of_joints(&self) -> f64 {
        if self.swings_at_constraints() { 0.5 } else { self.derivative.placement().share }
    }

    /// Mean time of the forces that act in a step of a scheme with a force history, as a fraction of the step: in schemes of second order
    /// its middle.
    pub fn mean_time(&self) -> f64 {
        if self.promises.order > 1 { 0.5 } else { self.weight }
    }

    /// Force history of a constant force, relative to the force.
    pub fn left(&self) -> f64 {
        self.lag.force + self.lag.inertia
    }

    /// Factor of the mass in the derivative of the inertia force with respect to `q_1` `[1/time^2]`.
    #[inline(always)]
    pub fn inertia(&self, dt: f64) -> f64 {
        self.velocity.moved / (dt * dt)
    }

    /// Displacement without a change of velocity, relative to which [`Self::inertia`] applies: factors of `v_0` and of `a_0`.
    #[inline(always)]
    pub fn drift(&self, dt: f64) -> [f64; 2] {
        let UpdateCoefficients { moved, velocity, acceleration } = self.velocity;
        [(1.0 - velocity) / moved * dt, -acceleration / moved * dt * dt]
    }

    /// Displacement, in addition to [`Self::drift`], that changes a velocity by `change` `[length]`.
    #[inline(always)]
    pub fn motion(&self, change: f64, dt: f64) -> f64 {
        dt / self.velocity.moved * change
    }

    /// Velocity at which the forces of a step act: at its end, or the mean of both ends.
    pub fn velocity_of_forces(&self) -> UpdateCoefficients {
        let share = self.derivative.placement().share;
        let UpdateCoefficients { moved, velocity, acceleration } = self.velocity;
        UpdateCoefficients { moved: share * moved, velocity: share * velocity + (1.0 - share), acceleration: share * acceleration }
    }

    /// Checks that the row is a scheme: motion without forces and under a constant force is exact, and all history variables that are read
    /// are stored.
    ///
    /// # Errors
    /// The violated condition, in words.
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

    /// True if the dissipation can be applied: both factors are in `[0, 1]`, and the scheme has neither history variables nor stages.
    fn can_dissipate(&self) -> bool {
        let Dissipation { strain, velocity } = self.dissipation;
        let are_shares = [strain, velocity].iter().all(|share| (0.0..=1.0).contains(share));
        are_shares && self.remembers.is_empty() && matches!(self.step, StepKind::Whole)
    }

    /// Checks one row of coefficients; `found` is the force history of a constant unit force at its start.
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
    use crate::integrators::{BACKWARD_EULER, CATALOGUE, ENERGY_MOMENTUM, NEWMARK, TRAPEZOIDAL, generalized_alpha, hht, newmark, wbz};

    #[test]
    fn every_row_of_the_catalogue_is_a_scheme() {
        assert!(CATALOGUE.iter().all(|scheme| scheme.check() == Ok(())));
        assert!(Scheme { weight: 0.5, ..ENERGY_MOMENTUM }.check().is_err(), "the other half is remembered by nobody");
    }

    /// Velocity and acceleration satisfy the equations of the method for any motion.
    #[test]
    fn velocity_and_acceleration_of_newmark_are_those_of_its_equations() {
        let (beta, gamma, dt) = (0.3025, 0.6, 0.07);
        let (change, v_0, a_0) = (0.3, -1.7, 4.1);
        let v_1 = NEWMARK.velocity.velocity(change, v_0, dt) + NEWMARK.velocity.velocity_by(a_0, dt);
        let a_1 = NEWMARK.acceleration.acceleration(change, v_0, a_0, dt);
        assert!((change - dt * v_0 - dt * dt * ((0.5 - beta) * a_0 + beta * a_1)).abs() < 1e-14);
        assert!((v_1 - v_0 - dt * ((1.0 - gamma) * a_0 + gamma * a_1)).abs() < 1e-13);
        // The change of a velocity is proportional to the motion beyond the drift.
        let [of_velocity, of_acceleration] = NEWMARK.drift(dt);
        let opposed = NEWMARK.inertia(dt) * (change - of_velocity * v_0 - of_acceleration * a_0);
        assert!((opposed - (v_1 - v_0) / dt).abs() < 1e-11);
        assert!((NEWMARK.motion(v_1 - v_0, dt) - opposed / NEWMARK.inertia(dt)).abs() < 1e-14);
    }

    #[test]
    fn undamped_methods_of_newmarks_kind_swing_at_constraints() {
        let undamped = [TRAPEZOIDAL, newmark(0.25, 0.5), hht(0.0), wbz(0.0), generalized_alpha(1.0)];
        assert!(undamped.iter().all(Scheme::swings_at_constraints));
        assert!(CATALOGUE.iter().filter(|scheme| scheme.name != "trapezoidal").all(|scheme| !scheme.swings_at_constraints()));
    }

    #[test]
    fn forces_of_the_middle_act_at_the_mean_velocity() {
        assert_eq!(ENERGY_MOMENTUM.velocity_of_forces(), UpdateCoefficients { moved: 1.0, velocity: 0.0, acceleration: 0.0 });
        assert_eq!(TRAPEZOIDAL.velocity_of_forces(), TRAPEZOIDAL.velocity);
        assert_eq!(BACKWARD_EULER.velocity_of_forces(), BACKWARD_EULER.velocity);
    }
}
