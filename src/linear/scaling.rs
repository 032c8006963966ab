//! Scales that are powers of two, so that scaling causes no round-off, and norms of vectors.

use super::pattern::Pattern;

/// Exponent of the largest power of two not above `x > 0`.
fn exponent(x: f64) -> i32 {
    (x.to_bits() >> 52) as i32 - 1023
}

/// `2^n`, limited to normal numbers.
fn power_of_two(n: i32) -> f64 {
    f64::from_bits(((n.clamp(-1022, 1023) + 1023) as u64) << 52)
}

/// A power of two near `1/sqrt(x)`; 1 for zero.
fn reciprocal_root(x: f64) -> f64 {
    if x > 0.0 { power_of_two(-exponent(x).div_euclid(2)) } else { 1.0 }
}

/// A power of two near `1/x`; 1 for zero.
fn reciprocal(x: f64) -> f64 {
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

/// Scale of every vertex: makes entries of the diagonal block of a node, and of the constraint of a multiplier, of order one.
pub(super) fn vertex_scales(pattern: &Pattern, values: &[f64], scales: &mut [f64]) {
    let own_block = |v: usize| {
        let (block, size) = (pattern.block(v as u32, v as u32), pattern.size(v));
        largest((0..size).flat_map(|k| &values[block.at(0, k)..][..size]).copied())
    };
    for v in (0..pattern.vertices()).filter(|&v| !pattern.is_multiplier(v)) {
        scales[v] = reciprocal_root(own_block(v));
    }
    // A massless node gets the scale of the nodes that carry it: otherwise pivots of contacts between rigid bodies are 1e-12 in small
    // steps.
    for v in (0..pattern.vertices()).filter(|&v| pattern.is_carried(v)) {
        let rows = pattern.neighbors(v).iter().filter(|&&u| pattern.anchor(u as usize) == Some(v as u32));
        let others = rows.flat_map(|&u| pattern.neighbors(u as usize)).map(|&w| w as usize);
        let carriers = others.filter(|&w| !pattern.is_multiplier(w) && !pattern.is_carried(w));
        scales[v] = carriers.map(|w| scales[w]).fold(scales[v], f64::min);
    }
    for v in (0..pattern.vertices()).filter(|&v| pattern.is_multiplier(v)) {
        let nodes = pattern.neighbors(v).iter().zip(pattern.column_blocks(v)).filter(|(u, _)| !pattern.is_multiplier(**u as usize));
        let constraint = largest(nodes.flat_map(|(&u, block)| {
            let (scale, rows) = (scales[u as usize], pattern.size(u as usize));
            (0..pattern.size(v)).flat_map(move |k| values[block.at(0, k)..][..rows].iter().map(move |value| scale * value))
        }));
        scales[v] = if constraint > 0.0 { reciprocal(constraint) } else { reciprocal_root(own_block(v)) };
    }
}

/// Scale of every unknown.
pub(super) fn spread(pattern: &Pattern, vertex_scales: &[f64], scales: &mut [f64]) {
    for v in 0..pattern.vertices() {
        scales[pattern.first_unknown(v)..][..pattern.size(v)].fill(vertex_scales[v]);
    }
}
