//! Numbers without round-off, as findings tell them.

/// Step size without the round-off of subtracted times.
pub(super) fn rounded(dt: f64) -> f64 {
    format!("{dt:.6e}").parse().unwrap_or(dt)
}
