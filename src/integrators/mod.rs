//! Floor 3: how a potential is differentiated across a step; one file per scheme.

/// A time integrator as a user chooses it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Integrator {
    /// Discrete gradients: energy and both momenta exact.
    EnergyMomentum,
    /// Implicit midpoint rule.
    Midpoint,
    /// Newmark's method with beta = 1/4, gamma = 1/2.
    Trapezoidal,
}

impl Integrator {
    /// All integrators, in the order of the reference.
    pub const ALL: &'static [Integrator] = &[Integrator::EnergyMomentum, Integrator::Midpoint, Integrator::Trapezoidal];

    /// Name as written in a script.
    pub fn name(self) -> &'static str {
        match self {
            Integrator::EnergyMomentum => "energy_momentum",
            Integrator::Midpoint => "midpoint",
            Integrator::Trapezoidal => "trapezoidal",
        }
    }

    /// One sentence for the reference.
    pub fn summary(self) -> &'static str {
        match self {
            Integrator::EnergyMomentum => "energy-momentum scheme: discrete gradients keep the energy and both momenta exactly, for every step size",
            Integrator::Midpoint => "implicit midpoint rule: keeps both momenta, but not the energy",
            Integrator::Trapezoidal => "trapezoidal rule (Newmark, beta = 1/4, gamma = 1/2): keeps neither the energy nor the angular momentum in large motions",
        }
    }
}
