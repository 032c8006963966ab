//! Tolerances of step size control.

/// Growth of the relative position error in a step that round-off and Newton's tolerance cause alone.
pub const STILL: f64 = 1e-12;

/// Position error of a step, relative to the largest coordinate, that is round-off in models with contacts or rigid bodies: third
/// differences of a body held at rest by friction reach 1e-14.
pub const STILL_AT: f64 = 1e-13;

/// Default of the smallest adaptive step, relative to the first step: resolving an impact to this accuracy costs some twenty refused steps.
pub const SMALLEST_STEP: f64 = 1e-6;

/// Error of a first touch, relative to the size of the model or, far from the origin, to a part of its distance, below which no shorter
/// step is tried: the shorter the step, the larger the contact force of an impact and its work on the round-off of positions. Rigid rings
/// had energy defects up to 4e-11 with 2e-6, and one of three still more than 1e-11 with 8e-6.
pub const TOUCH: f64 = 1e-5;

/// Least energy scale of a step, relative to the geometric mean of the energy of its state and of that which forces of earlier stages would
/// give to its nodes: their round-off of 1e-16 does work of that share of it, and Newton's method demands 1e-13 of the scale.
pub const STOPPED: f64 = 1e-3;
