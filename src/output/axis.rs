//! Round numbers along an axis: ticks at 1, 2 or 5 times a power of ten, with one factor for all where numbers are very large or small.
//!
//! Everything is scaled by the factor first, so that the spacing is found among numbers of ordinary size.

use crate::math::tolerances::{FLAT, NOTHING};

/// Ticks and labels for an interval of values.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    /// The interval, in values divided by `10^exponent`.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
    /// Ticks inside the interval, divided by `10^exponent`.
    pub ticks: Vec<f64>,
    exponent: i32,
    decimals: usize,
}

impl Axis {
    /// An axis over the finite ones of `values`, with about `count` ticks. A constant gets an interval around it; no value at all, [0, 1].
    pub fn over(values: impl IntoIterator<Item = f64>, count: usize) -> Self {
        let (low, high) = values
            .into_iter()
            .filter(|value| value.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        Axis::new(if low <= high { [low, high] } else { [0.0, 1.0] }, count)
    }

    fn new([low, high]: [f64; 2], count: usize) -> Self {
        let size = Some(low.abs().max(high.abs())).filter(|&size| size > NOTHING).unwrap_or(0.0);
        let magnitude = size.log10().floor() as i32;
        let exponent = if size == 0.0 || (-3..5).contains(&magnitude) { 0 } else { magnitude };
        let factor = 10f64.powi(exponent);
        let (mut low, mut high) = (low / factor, high / factor);
        if high - low <= FLAT * (size / factor) {
            let margin = if size == 0.0 { 1.0 } else { 0.1 * size / factor };
            (low, high) = (0.5 * (low + high) - margin, 0.5 * (low + high) + margin);
        }
        let raw = (high - low) / count as f64;
        let mut power = raw.log10().floor() as i32;
        let mut digit = [1, 2, 5].into_iter().find(|&digit| f64::from(digit) * 10f64.powi(power) >= raw * (1.0 - FLAT)).unwrap_or(10);
        if digit == 10 {
            (digit, power) = (1, power + 1);
        }
        // Whole multiples over a power of ten are correctly rounded, sums of steps are not.
        let tick = |multiple: f64| {
            let whole = multiple * f64::from(digit);
            if power < 0 { whole / 10f64.powi(-power) } else { whole * 10f64.powi(power) }
        };
        let step = tick(1.0);
        let first = (low / step - FLAT).ceil() as i64;
        let last = (high / step + FLAT).floor() as i64;
        // `+ 0.0` turns a negative zero into zero.
        let ticks = (first..=last).map(|multiple| tick(multiple as f64) + 0.0).collect();
        Axis { low, high, ticks, exponent, decimals: (-power).max(0) as usize }
    }

    /// The interval widened by a margin on both sides, but not across zero.
    pub fn widened(mut self, share: f64) -> Self {
        let margin = share * (self.high - self.low);
        self.low = if self.low >= 0.0 { (self.low - margin).max(0.0) } else { self.low - margin };
        self.high = if self.high <= 0.0 { (self.high + margin).min(0.0) } else { self.high + margin };
        self
    }

    /// A value in the axis's scale.
    pub fn scaled(&self, value: f64) -> f64 {
        value / 10f64.powi(self.exponent)
    }

    /// A value of the axis's scale as it was.
    pub fn unscaled(&self, value: f64) -> f64 {
        value * 10f64.powi(self.exponent)
    }

    /// The text of a tick.
    pub fn label(&self, tick: f64) -> String {
        format!("{tick:.*}", self.decimals).replace('-', "\u{2212}")
    }

    /// The name of the axis with its factor, such as `energy (×10⁻⁶)`.
    pub fn name(&self, name: &str) -> String {
        if self.exponent == 0 {
            return name.into();
        }
        let exponent: String = self.exponent.to_string().chars().map(superscript).collect();
        format!("{name} (×10{exponent})")
    }
}

fn superscript(letter: char) -> char {
    match letter {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        _ => letter.to_digit(10).and_then(|digit| char::from_u32(0x2070 + digit)).unwrap_or(letter),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(low: f64, high: f64) -> Vec<String> {
        let axis = Axis::over([low, high], 5);
        axis.ticks.iter().map(|&tick| axis.label(tick)).collect()
    }

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(labels(0.0, 2.0), ["0.0", "0.5", "1.0", "1.5", "2.0"]);
        assert_eq!(labels(0.0, 0.064), ["0.00", "0.02", "0.04", "0.06"]);
        assert_eq!(labels(-3.0, 47.0), ["0", "10", "20", "30", "40"]);
        assert_eq!(labels(-0.3, 0.3), ["−0.2", "0.0", "0.2"]);
        assert_eq!(labels(0.0, 1.0), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
    }

    #[test]
    fn large_and_small_numbers_share_a_factor() {
        assert_eq!(labels(0.0, 3.1e7), ["0", "1", "2", "3"]);
        assert_eq!(Axis::over([0.0, 3.1e7], 5).name("stress"), "stress (×10⁷)");
        assert_eq!(Axis::over([-2e-15, 1e-16], 5).name("defect"), "defect (×10⁻¹⁵)");
        assert_eq!(Axis::over([0.0, 12345.0], 5).name("stress"), "stress");
    }

    #[test]
    fn odd_intervals_have_ticks_all_the_same() {
        let constants = [0.0, 1.0, -7.5e-9, 1e300, 5e-324, f64::MAX];
        let ranges =
            constants.map(|value| [value, value]).into_iter().chain([[1.0, 1.0 + 1e-15], [-f64::MAX, f64::MAX], [1e5, 1e5 + 1e-2]]);
        for range in ranges.chain([[f64::NAN, f64::NAN], [f64::NEG_INFINITY, 3.0]]) {
            let axis = Axis::over(range, 5);
            assert!((1..=11).contains(&axis.ticks.len()), "{range:?}: {axis:?}");
            assert!(axis.ticks.iter().all(|&tick| axis.low - 1e-6 <= tick && tick <= axis.high + 1e-6), "{range:?}: {axis:?}");
        }
        assert_eq!(Axis::over([], 5).ticks, [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]);
    }
}
