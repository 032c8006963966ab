//! Tolerances of round parts of a surface.

/// Relative deviation from a circle or sphere up to which nodes lie on it: positions in files have six digits.
pub const ROUND_PART: f64 = 1e-6;

/// Smallest angle subtended by neighboring nodes at the center of a round part `[rad]`; flatter surfaces count as plane, since their fitted
/// radius is round-off.
pub const ROUND_PART_TURN: f64 = 1e-3;

/// Height of a tilted rim relative to its radius below which it lies flat, twelve degrees: contact is then at its nodes.
pub const RIM_FLAT: f64 = 0.2;

/// Least height relative to the radius of a rim that becomes flat within a step: at zero the height has a cusp.
pub const RIM_LEAST: f64 = 1e-3;
