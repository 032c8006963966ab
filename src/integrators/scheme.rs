//! What a time integrator is: a row of data that says which force stands for a potential's in a step, how velocities follow from positions,
//! what is remembered from step to step, and what is promised.
//!
//! A step solves
//!
//! ```text
//! M a + w f + (1 - w) f_0 = 0,    a = (v_1 - v_0) / dt,    v_1 = v_0 + c/dt (q_1 - q_0 - dt v_0)
//! ```
//!
//! with the static forces `f` of the step (the scheme's [`Derivative`]) and `f_0` of the end of the step before, if `w < 1`.
//! Nobody asks which scheme runs: who needs to know something of it reads a field.

use super::derivative::Derivative;

/// A time integrator.
#[derive(Debug)]
pub struct Scheme {
    /// Name as written in a script.
    pub name: &'static str,
    /// One sentence for the reference.
    pub summary: &'static str,
    /// Which force stands for that of a potential.
    pub derivative: Derivative,
    /// Share `w` of that force; the rest is the force at the end of the step before, which the scheme then remembers.
    pub weight: f64,
    /// How velocities follow from positions.
    pub kinematics: Kinematics,
    /// What it keeps.
    pub promises: Promises,
}

/// Velocities that are linear in the positions: `v_1 = v_0 + c/dt (q_1 - q_0 - dt v_0)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kinematics {
    /// `c`: 2 where the mean of the velocities moves the positions, 1 where the last one does.
    pub slope: f64,
}

impl Kinematics {
    /// Velocity at the end of a step of size `dt` that moves a component by `change` `[length/time]`.
    #[inline(always)]
    pub fn velocity(self, change: f64, v_0: f64, dt: f64) -> f64 {
        self.slope / dt * change + (1.0 - self.slope) * v_0
    }

    /// Factor of the mass in the derivative of the inertia force with respect to `q_1` `[1/time^2]`.
    #[inline(always)]
    pub fn inertia(self, dt: f64) -> f64 {
        self.slope / (dt * dt)
    }

    /// The motion beyond the drift `dt v_0` that changes a velocity by `change` `[length]`.
    #[inline(always)]
    pub fn motion(self, change: f64, dt: f64) -> f64 {
        dt / self.slope * change
    }
}

/// What a scheme keeps in a motion without loads, for every step size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Promises {
    /// The total energy.
    pub energy: bool,
    /// The linear momentum.
    pub momentum: bool,
    /// The angular momentum.
    pub angular_momentum: bool,
    /// Order of accuracy in the step size.
    pub order: usize,
}

impl Scheme {
    /// Whether the force at the end of a step is remembered for the next one.
    pub fn remembers_force(&self) -> bool {
        self.weight < 1.0
    }
}

impl PartialEq for Scheme {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for Scheme {}
