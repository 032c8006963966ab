//! Signals at equal distances of time: discrete Fourier transform, channel filter of crash tests; percentiles and interpolation of tables.

use std::f64::consts::{SQRT_2, TAU};

/// Discrete Fourier transform `X_k = sum_j x_j exp(-2 pi i j k / n)` of real values: real and imaginary part for `k = 0` to `n/2`.
///
/// Powers of two by the algorithm of Cooley and Tukey (Mathematics of Computation 19, 1965), other lengths as a convolution by Bluestein
/// (IEEE Transactions on Audio and Electroacoustics 18, 1970): `j k = (j^2 + k^2 - (k - j)^2) / 2`.
pub fn fourier(values: &[f64]) -> Vec<[f64; 2]> {
    let n = values.len();
    if n == 0 {
        return Vec::new();
    }
    let mut signal: Vec<[f64; 2]> = values.iter().map(|&x| [x, 0.0]).collect();
    if n.is_power_of_two() {
        transform(&mut signal);
    } else {
        // The angle of `j^2/2` turns. Whole turns are removed by integer arithmetic, so that the angle is exact for long signals.
        let chirp = |j: usize| turned(-0.5 * ((j as u128 * j as u128) % (2 * n as u128)) as f64 / n as f64);
        let length = (2 * n - 1).next_power_of_two();
        let (mut a, mut b) = (vec![[0.0; 2]; length], vec![[0.0; 2]; length]);
        for (j, x) in signal.iter().enumerate() {
            a[j] = times(*x, chirp(j));
            let back = [chirp(j)[0], -chirp(j)[1]];
            (b[j], b[(length - j) % length]) = (back, back);
        }
        transform(&mut a);
        transform(&mut b);
        // The inverse transform is the conjugate of the transform of the conjugate.
        a.iter_mut().zip(&b).for_each(|(a, b)| *a = conjugate(times(*a, *b)));
        transform(&mut a);
        let size = length as f64;
        signal = (0..n).map(|k| times(conjugate(a[k]).map(|x| x / size), chirp(k))).collect();
    }
    signal.truncate(n / 2 + 1);
    signal
}

fn times(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

fn conjugate([re, im]: [f64; 2]) -> [f64; 2] {
    [re, -im]
}

/// `exp(2 pi i turns)`.
fn turned(turns: f64) -> [f64; 2] {
    let (sin, cos) = (TAU * turns).sin_cos();
    [cos, sin]
}

/// Transform of a power of two in place.
fn transform(x: &mut [[f64; 2]]) {
    let n = x.len();
    if n == 1 {
        return;
    }
    let bits = n.trailing_zeros();
    for j in 0..n {
        let reversed = j.reverse_bits() >> (usize::BITS - bits);
        if j < reversed {
            x.swap(j, reversed);
        }
    }
    let roots: Vec<[f64; 2]> = (0..n / 2).map(|k| turned(-(k as f64) / n as f64)).collect();
    let mut half = 1;
    while half < n {
        for block in x.chunks_exact_mut(2 * half) {
            for k in 0..half {
                let (even, odd) = (block[k], times(block[k + half], roots[k * (n / (2 * half))]));
                block[k] = [even[0] + odd[0], even[1] + odd[1]];
                block[k + half] = [even[0] - odd[0], even[1] - odd[1]];
            }
        }
        half *= 2;
    }
}

/// Filters values at the constant time increment `dt` `[s]` with the channel frequency class `class` `[Hz]` of SAE J211-1 and ISO 6487: a
/// Butterworth filter of second order, run forward and backward so that no phase shift remains. The signal is continued beyond both ends by
/// point reflection.
pub fn channel_filter(values: &[f64], dt: f64, class: f64) -> Vec<f64> {
    let n = values.len();
    if n < 2 {
        return values.to_vec();
    }
    let angle = (0.5 * TAU * class * RATIO * dt).tan();
    let square = angle * angle;
    let whole = 1.0 + SQRT_2 * angle + square;
    let (a, b) = (square / whole, [-2.0 * (square - 1.0) / whole, (-1.0 + SQRT_2 * angle - square) / whole]);
    // The transient at the start of the filter decays within about one period of its frequency.
    let margin = ((PERIODS / (class * dt)).ceil() as usize).clamp(1, n - 1);
    let before = (1..=margin).rev().map(|k| 2.0 * values[0] - values[k]);
    let after = (1..=margin).map(|k| 2.0 * values[n - 1] - values[n - 1 - k]);
    let mut signal: Vec<f64> = before.chain(values.iter().copied()).chain(after).collect();
    for _ in 0..2 {
        let start = signal[0];
        let (mut x, mut y) = ([start; 2], [start; 2]);
        for value in &mut signal {
            let next = a * (*value + 2.0 * x[0] + x[1]) + b[0] * y[0] + b[1] * y[1];
            (x, y) = ([*value, x[0]], [next, y[0]]);
            *value = next;
        }
        signal.reverse();
    }
    signal[margin..margin + n].to_vec()
}

/// Cut-off frequency of each filter pass relative to the channel frequency class: both passes together attenuate by 3 dB at 1.65 times the
/// class.
const RATIO: f64 = 2.0775;

/// Length of the continuation of a signal beyond each end, in periods of the class frequency.
const PERIODS: f64 = 2.0;

/// Percentile: value below which the fraction `share` (0 to 1) of the ascending numbers lies, linear between neighboring numbers.
pub fn percentile(ascending: &[f64], share: f64) -> f64 {
    let Some(last) = ascending.len().checked_sub(1) else { return f64::NAN };
    let place = share * last as f64;
    let low = (place.floor() as usize).min(last);
    let part = place - low as f64;
    if part == 0.0 { ascending[low] } else { ascending[low] * (1.0 - part) + ascending[low + 1] * part }
}

/// Piecewise linear interpolation at `x` through points with ascending `xs`; constant beyond the first and last point.
pub fn interpolated(x: f64, xs: &[f64], ys: &[f64]) -> f64 {
    let above = xs.partition_point(|known| *known <= x);
    match above {
        0 => ys[0],
        above if above == xs.len() => ys[above - 1],
        above => {
            let share = (x - xs[above - 1]) / (xs[above] - xs[above - 1]);
            ys[above - 1] * (1.0 - share) + ys[above] * share
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_transform_of_any_length_is_the_sum_that_defines_it() {
        for n in [1, 2, 3, 5, 8, 12, 17, 64, 100, 243] {
            let x: Vec<f64> = (0..n).map(|j| (1.3 * j as f64).sin() + 0.1 * j as f64).collect();
            let found = fourier(&x);
            assert_eq!(found.len(), n / 2 + 1);
            for (k, found) in found.iter().enumerate() {
                let mut sum = [0.0; 2];
                for (j, x) in x.iter().enumerate() {
                    let [cos, sin] = turned(-(((j * k) % n) as f64) / n as f64);
                    sum = [sum[0] + x * cos, sum[1] + x * sin];
                }
                assert!((found[0] - sum[0]).hypot(found[1] - sum[1]) < 1e-12 * n as f64, "{n} {k}: {found:?} {sum:?}");
            }
        }
    }

    #[test]
    fn the_filter_of_class_60_passes_slow_and_stops_fast_and_has_3_db_at_100_hertz() {
        let gain = |frequency: f64| {
            let x: Vec<f64> = (0..20000).map(|j| (TAU * frequency * j as f64 * 1e-4).sin()).collect();
            let y = channel_filter(&x, 1e-4, 60.0);
            y[5000..15000].iter().fold(0.0, |most: f64, y| most.max(y.abs()))
        };
        assert!((gain(5.0) - 1.0).abs() < 1e-3 && gain(1000.0) < 0.01, "{} {}", gain(5.0), gain(1000.0));
        // SAE J211-1: -3 dB at 100 Hz for class 60.
        assert!((20.0 * gain(100.0).log10() + 3.0).abs() < 0.15, "{}", 20.0 * gain(100.0).log10());
        let line: Vec<f64> = (0..500).map(|j| 2.0 + 0.01 * j as f64).collect();
        let kept = channel_filter(&line, 1e-4, 600.0);
        assert!(line.iter().zip(&kept).all(|(a, b)| (a - b).abs() < 1e-3), "a line stays");
    }

    #[test]
    fn percentiles_and_tables_are_linear_between_their_points() {
        assert_eq!([0.0, 0.5, 0.25, 1.0].map(|share| percentile(&[1.0, 2.0, 4.0], share)), [1.0, 2.0, 1.5, 4.0]);
        let at = |x| interpolated(x, &[0.0, 1.0, 3.0], &[0.0, 2.0, -2.0]);
        assert_eq!([-1.0, 0.5, 1.0, 2.0, 9.0].map(at), [0.0, 1.0, 2.0, 0.0, -2.0]);
    }
}
