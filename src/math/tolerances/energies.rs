//! Tolerances of energies given as text.

/// Size of strains up to which energies given as text, and their changes, are integrals of the stress by Simpson's rule: their terms of
/// first order cancel, and leave round-off of `1e-16/|E|` of the energy. The error of the rule is `1e-16/2880` times the fourth derivative
/// of the stress over its first one.
pub const SMALL_STRAIN: f64 = 1e-4;

/// Value at zero strain of an operation's argument below which its sign may change at a small strain.
pub const KINK_NEAR_REST: f64 = 1e-2;
