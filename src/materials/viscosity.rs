//! Viscosity of a material besides its stored energy: Kelvin-Voigt stress on the strain rate, and Maxwell branches, whose stress relaxes.
//!
//! Kelvin and Voigt: a stress `2 eta dE/dt + zeta tr(dE/dt) I` on the rate of the Green-Lagrange strain. Maxwell: every branch stores
//! `mu |Y|^2` of its own strain `Y = E - A`, whose viscous part creeps, `dA/dt = Y/tau`, and adds the stress `2 mu Y` (finite linear
//! viscoelasticity with an internal strain: Simo and Hughes, Computational Inelasticity, 1998, section 10.2, on the Green-Lagrange strain).
//! With the midpoint rule for `A`, a step of size `h tau` gives
//!
//! ```text
//! Y_1 = ((1 - h/2) Y_0 + E_1 - E_0) / (1 + h/2),     stress 2 mu Y_mid,     Y_mid = (Y_0 + Y_1)/2
//! mu |Y_1|^2 - mu |Y_0|^2 = 2 mu Y_mid : (E_1 - E_0) - 2 mu h |Y_mid|^2
//! ```
//!
//! exactly: the work of the stress is stored or dissipated, and what is dissipated is never negative.

/// Relaxing (Maxwell) branch of a viscosity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Branch {
    /// Shear modulus `mu` of the branch, which resists sudden strains `[stress]`.
    pub shear_modulus: f64,
    /// Relaxation time `tau`, in which the stress falls to 1/e at constant strain `[time]`.
    pub relaxation_time: f64,
}

/// Viscosity of a material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Viscosity {
    /// Shear viscosity `eta` `[stress * time]`.
    pub shear: f64,
    /// Volumetric viscosity `zeta`, additional resistance to volume changes `[stress * time]`.
    pub bulk: f64,
    /// Relaxing (Maxwell) branches.
    pub branches: Vec<Branch>,
}

impl Branch {
    /// Factors `[(1 - h/2)/(1 + h/2), 1/(1 + h/2)]`, `h = dt/tau`: the branch strain at the end of a step is the first times the branch
    /// strain at the start plus the second times the strain increment.
    pub fn shares(&self, dt: f64) -> [f64; 2] {
        let half = 0.5 * dt / self.relaxation_time;
        [(1.0 - half) / (1.0 + half), 1.0 / (1.0 + half)]
    }
}

impl Viscosity {
    /// True if all viscosities are zero and there are no branches.
    pub fn is_none(&self) -> bool {
        self.shear == 0.0 && self.bulk == 0.0 && self.branches.is_empty()
    }

    /// Returns the viscosity in other units, given the factors of stress and time.
    pub fn rescaled(&self, stress: f64, time: f64) -> Self {
        let branch =
            |branch: &Branch| Branch { shear_modulus: branch.shear_modulus * stress, relaxation_time: branch.relaxation_time * time };
        Viscosity {
            shear: self.shear * stress * time,
            bulk: self.bulk * stress * time,
            branches: self.branches.iter().map(branch).collect(),
        }
    }
}
