//! Tolerances of what surfaces are like.

/// Offset of the middle of an edge of second order from its chord, relative to the chord, below which the edge is straight: round-off of
/// meshes that are read from files with few digits, and no curve that anything could slide on.
pub const STRAIGHT: f64 = 1e-7;

/// Deviation from a circle or sphere, over its radius, up to which nodes lie on it: positions in files have six digits.
pub const ROUND_PART: f64 = 1e-6;
