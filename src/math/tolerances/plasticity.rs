//! Tolerances of plastic flow.

/// Relative excess of a stress over the yield stress that is round-off: the point remains elastic.
pub const ON_THE_YIELD_SURFACE: f64 = 1e-13;

/// Relative excess of the squared stress over the squared yield stress above which a step starts outside the yield surface, as rate
/// dependence permits. Steps that ended on the surface have a far smaller round-off excess, which must not cause flow during unloading.
pub const OUTSIDE_THE_YIELD_SURFACE: f64 = 1e-9;

/// Residual of the yield condition, relative to the stresses, at which the iteration for the plastic multiplier ends.
pub const PLASTIC_MULTIPLIER: f64 = 1e-14;

/// Smallest fraction of a step with plastic flow; for smaller fractions no flow rate is defined.
pub const LEAST_FLOW_SHARE: f64 = 1e-12;

/// Strain increment relative to the yield strain below which the weight `theta` of `flow.rs` is a series: truncation error 1e-15.
pub const SMALL_PLASTIC_STEP: f64 = 1e-2;

/// Plastic strain below which a hardening law with infinite initial slope uses the slope at this strain.
pub const FIRST_PLASTIC_STRAIN: f64 = 1e-10;

/// Relative spread of squared stretches up to which five series terms give divided differences of logarithms.
pub const CLOSE_STRETCHES: f64 = 1e-3;

/// Relative spread of squared stretches up to which eight series terms give divided differences of logarithms.
pub const NEAR_STRETCHES: f64 = 1e-2;

/// Relative spread of squared stretches up to which a series gives divided differences of logarithms; above it plain differences are
/// accurate.
pub const WIDE_STRETCHES: f64 = 0.1;
