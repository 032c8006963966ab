//! What a friction law is, and what it makes of the rows that slide: with `T` the tangential multiplier, which presses with `T grad u`, and
//! the slip `u` of the step,
//!
//! ```text
//! T = T_dry - F u,    |T_dry| <= L,    u = 0 where |T_dry| < L (stick),    T_dry = -L u/|u| where u != 0 (slip)
//! ```
//!
//! with `F` of the film, if there is one. The work of the step is `T u <= 0`, whatever `L >= 0` is.

use std::fmt;
use std::sync::Arc;

/// How a point is pressed and slides.
#[derive(Clone, Copy, Debug)]
pub struct Sliding {
    /// Coefficient of friction there, where the law has one.
    pub coefficient: f64,
    /// Pressure `[stress]`, never negative.
    pub pressure: f64,
    /// Speed of the slip `[length/time]`; 0 at rest.
    pub speed: f64,
}

/// The largest shear stress, with its derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limit {
    /// The dry shear stress with which a point slides at that speed, and up to which it sticks at none `[stress]`.
    pub shear: f64,
    /// Its derivative with respect to the pressure.
    pub by_pressure: f64,
    /// Its derivative with respect to the speed `[stress time/length]`.
    pub by_speed: f64,
}

/// A law of friction: how large a shear stress is. Its direction, its stick and its work are no matter of the law.
pub trait FrictionLaw: fmt::Debug + Send + Sync {
    /// The largest shear stress; it is never negative.
    fn limit(&self, at: Sliding) -> Limit;

    /// Shear stress per speed of a film between the surfaces, which opposes every slip besides `[stress time/length]`.
    fn film(&self) -> f64 {
        0.0
    }

    /// The same law in other units, by the factors of a stress and of a speed.
    fn in_units(&self, stress: f64, speed: f64) -> Arc<dyn FrictionLaw>;
}
