//! Tolerances of round parts of a surface.

/// Relative deviation from a circle or sphere up to which nodes lie on it: positions in files have six digits.
pub const ROUND_PART: f64 = 1e-6;

/// Smallest angle subtended by neighboring nodes at the center of a round part `[rad]`; flatter surfaces count as plane, since their fitted
/// radius is round-off.
pub const ROUND_PART_TURN: f64 = 1e-3;

/// Height of a tilted cylinder rim over an obstacle, relative to the radius (sine of the tilt), below which the end face counts as lying
/// flat, twelve degrees: contact then acts at its nodes.
pub const RIM_FLAT: f64 = 0.2;

/// Smallest height, relative to the radius, of a cylinder rim that becomes flat within a step: the height as a function of the axis
/// direction has a cusp at zero.
pub const RIM_LEAST: f64 = 1e-3;

/// Difference of two gaps, relative to the facet size, below which they are equal up to round-off. No round number, at whose multiples gaps
/// of round coordinates would be rounded both up and down.
pub const EQUAL_GAPS: f64 = 7.31e-11;
