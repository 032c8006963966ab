//! Tolerances of plastic flow.

/// Excess of a stress over the yield stress, relative to it, that is round-off: the point does not yield.
pub const ON_THE_YIELD_SURFACE: f64 = 1e-13;

/// Relative excess of a squared stress over the squared yield stress above which a step begins outside the yield surface, as rate
/// dependence permits. Round-off of a step that ended on the surface is far below; it would cause flow during unloading otherwise.
pub const OUTSIDE_THE_YIELD_SURFACE: f64 = 1e-9;

/// Residual of the yield condition, relative to the stresses in it, at which the plastic multiplier is found.
pub const PLASTIC_MULTIPLIER: f64 = 1e-14;

/// Smallest share of a step that is left for plastic flow: below it there is no rate.
pub const LEAST_FLOW_SHARE: f64 = 1e-12;

/// Step over the yield strain below which the direction of flow is fitted by a series: its first term left out is 1e-15.
pub const SMALL_PLASTIC_STEP: f64 = 1e-2;

/// Plastic strain below which a hardening law with infinite initial slope uses the slope at this strain.
pub const FIRST_PLASTIC_STRAIN: f64 = 1e-10;

/// Spread of the squares of stretches, relative to their mean, up to which five terms give divided differences of logarithms.
pub const CLOSE_STRETCHES: f64 = 1e-3;

/// Spread of the squares of stretches, relative to their mean, up to which eight terms give divided differences of logarithms.
pub const NEAR_STRETCHES: f64 = 1e-2;

/// Spread of the squares of stretches, relative to their mean, up to which a series gives divided differences of logarithms; beyond it
/// the differences themselves have enough digits.
pub const WIDE_STRETCHES: f64 = 0.1;
