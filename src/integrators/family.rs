//! Time integrators that differ in numbers.

use super::scheme::Scheme;
use crate::math::catalogue::Parameter;

/// Schemes that numbers tell apart; the one without numbers stands in the catalogue.
pub struct Family {
    /// That with the defaults of all parameters.
    pub default: &'static Scheme,
    /// The numbers, at most two, each with a default.
    pub parameters: &'static [Parameter],
    /// The scheme for values in their ranges; 0 for what there is no parameter for.
    pub make: fn([f64; 2]) -> Scheme,
}
