//! Rounded numbers for the texts of findings.

/// Step size without the round-off of a difference of times: seven significant digits.
pub(super) fn rounded(dt: f64) -> f64 {
    format!("{dt:.6e}").parse().unwrap_or(dt)
}
