//! Tolerances of what is round of a surface.

/// Deviation from a circle or sphere, over its radius, up to which nodes lie on it: positions in files have six digits.
pub const ROUND_PART: f64 = 1e-6;

/// Smallest angle between neighboring nodes as seen from the center of a round part `[rad]`: what is flatter is taken for a plane, of which
/// round-off makes any radius.
pub const ROUND_PART_TURN: f64 = 1e-3;

/// Height of a tilted rim over its radius below which it lies flat, twelve degrees: its nodes hold it.
pub const RIM_FLAT: f64 = 0.2;

/// Least height over the radius of a rim that comes to lie flat within a step: at zero the height has a cusp.
pub const RIM_LEAST: f64 = 1e-3;
