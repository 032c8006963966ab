//! Tolerances of round parts of a surface.

/// Deviation from a circle or sphere, over its radius, up to which nodes lie on it: positions in files have six digits.
pub const ROUND_PART: f64 = 1e-6;

/// Smallest angle subtended by neighboring nodes at the center of a round part `[rad]`; flatter surfaces count as plane, since their fitted
/// radius is round-off.
pub const ROUND_PART_TURN: f64 = 1e-3;

/// Height of a tilted rim over its radius below which it lies flat, twelve degrees: its nodes hold it.
pub const RIM_FLAT: f64 = 0.2;

/// Least height over the radius of a rim that comes to lie flat within a step: at zero the height has a cusp.
pub const RIM_LEAST: f64 = 1e-3;
