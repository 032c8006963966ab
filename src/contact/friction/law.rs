//! Interface of friction laws. With the tangential multiplier `T`, whose nodal force is `T grad u`, and the slip `u` of the step:
//!
//! ```text
//! T = T_dry - F u,    |T_dry| <= L,    u = 0 where |T_dry| < L (stick),    T_dry = -L u/|u| where u != 0 (slip)
//! ```
//!
//! with the film constant `F`. The frictional work of the step is `T u <= 0` for every `L >= 0`. Used by `dynamics/parts/friction_rows.rs`.

use std::fmt;
use std::sync::Arc;

/// State of a contact point on which the friction limit depends.
#[derive(Clone, Copy, Debug)]
pub struct SlipState {
    /// Friction coefficient of the point; laws without a coefficient ignore it.
    pub coefficient: f64,
    /// Pressure `[stress]`, never negative.
    pub pressure: f64,
    /// Slip speed `[length/time]`; 0 at rest.
    pub speed: f64,
}

/// Largest shear stress of dry friction with its derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limit {
    /// Shear stress of a point that slips with the given speed; bound of the stress of a sticking point at speed 0 `[stress]`.
    pub shear: f64,
    /// Derivative of the shear stress with respect to the pressure.
    pub by_pressure: f64,
    /// Derivative of the shear stress with respect to the speed `[stress time/length]`.
    pub by_speed: f64,
}

/// Friction law: magnitude of the shear stress. Direction, stick and work are common to all laws.
pub trait FrictionLaw: fmt::Debug + Send + Sync {
    /// Largest shear stress, never negative.
    fn limit(&self, at: SlipState) -> Limit;

    /// Largest ratio of tangential to normal impulses of an impact with this positive pressure during a step. A shear stress that remains
    /// without pressure, as of adhesion, has no impulse.
    fn impulse_ratio(&self, at: SlipState) -> f64 {
        self.limit(at).shear / at.pressure
    }

    /// Film shear stress per slip speed, added to dry friction and opposite to the slip `[stress time/length]`.
    fn film(&self) -> f64 {
        0.0
    }

    /// True if a part of the shear stress does not grow with the pressure, as of adhesion or a film: its impulse is proportional to the
    /// time in contact.
    fn needs_time(&self) -> bool {
        self.film() > 0.0 || self.limit(SlipState { coefficient: 0.0, pressure: 1.0, speed: 0.0 }).shear > 0.0
    }

    /// True if the largest shear stress changes with the speed.
    fn depends_on_speed(&self) -> bool;

    /// Law in other units, with the conversion factors of stress and speed.
    fn in_units(&self, stress: f64, speed: f64) -> Arc<dyn FrictionLaw>;
}
