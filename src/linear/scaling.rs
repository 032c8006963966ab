//! Scales that are powers of two, so that scaling causes no round-off, and norms of vectors.

/// Exponent of the largest power of two not above `x > 0`.
fn exponent(x: f64) -> i32 {
    (x.to_bits() >> 52) as i32 - 1023
}

/// `2^n`, limited to normal numbers.
fn power_of_two(n: i32) -> f64 {
    f64::from_bits(((n.clamp(-1022, 1023) + 1023) as u64) << 52)
}

/// A power of two near `1/sqrt(x)`; 1 for zero.
pub(super) fn reciprocal_root(x: f64) -> f64 {
    if x > 0.0 { power_of_two(-exponent(x).div_euclid(2)) } else { 1.0 }
}

/// A power of two near `1/x`; 1 for zero.
pub(super) fn reciprocal(x: f64) -> f64 {
    if x > 0.0 { power_of_two(-exponent(x)) } else { 1.0 }
}

/// Largest absolute value; NaN if any value is NaN.
pub(super) fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |largest: f64, x| if x.abs() <= largest { largest } else { x.abs() })
}

/// True if all values are finite; evaluated without a branch per value.
pub(super) fn all_finite(values: &[f64]) -> bool {
    let (groups, rest) = values.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for group in groups {
        for (sum, x) in sums.iter_mut().zip(group) {
            *sum += 0.0 * x;
        }
    }
    sums.iter().sum::<f64>() + rest.iter().map(|x| 0.0 * x).sum::<f64>() == 0.0
}
