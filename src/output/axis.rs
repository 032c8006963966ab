//! Round numbers along an axis: ticks at 1, 2 or 5 times a power of ten, with one factor for all where numbers are very large or small.
//!
//! Values are scaled by the factor first, so that the spacing is found among numbers of ordinary size. A logarithmic axis is an axis over
//! the logarithms to the base 10, with ticks at powers of ten, and at 2 and 5 times these if there are few.

use crate::math::tolerances::{FLAT, NOTHING};

/// Ticks and labels for an interval of values.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    /// Lower end of the axis, in values divided by `10^exponent`.
    pub low: f64,
    /// Upper end of the axis, in values divided by `10^exponent`.
    pub high: f64,
    /// Ticks inside the axis, divided by `10^exponent`.
    pub ticks: Vec<f64>,
    exponent: i32,
    decimals: usize,
    is_logarithmic: bool,
}

/// Powers of ten from which a label is written as a power.
const LONG: f64 = 4.0;

impl Axis {
    /// Returns a linear axis over the finite `values`, with about `count` ticks. A constant gets an interval around it; without any value,
    /// [0, 1].
    pub fn over(values: impl IntoIterator<Item = f64>, count: usize) -> Self {
        let (low, high) = values
            .into_iter()
            .filter(|value| value.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        Axis::new(if low <= high { [low, high] } else { [0.0, 1.0] }, count)
    }

    fn new([low, high]: [f64; 2], count: usize) -> Self {
        let size = Some(low.abs().max(high.abs())).filter(|&size| size > NOTHING).unwrap_or(0.0);
        // A range that vanishes in any units is drawn as zero.
        let [low, high] = if size == 0.0 { [0.0; 2] } else { [low, high] };
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
        // Whole multiples divided by a power of ten are correctly rounded, sums of steps are not.
        let tick = |multiple: f64| {
            let whole = multiple * f64::from(digit);
            if power < 0 { whole / 10f64.powi(-power) } else { whole * 10f64.powi(power) }
        };
        let step = tick(1.0);
        let first = (low / step - FLAT).ceil() as i64;
        let last = (high / step + FLAT).floor() as i64;
        // `+ 0.0` turns a negative zero into zero.
        let ticks = (first..=last).map(|multiple| tick(multiple as f64) + 0.0).collect();
        Axis { low, high, ticks, exponent, decimals: (-power).max(0) as usize, is_logarithmic: false }
    }

    /// Returns a logarithmic axis over the positive `values`, with about `count` ticks. A constant gets a decade around it; without any
    /// value, 1 to 10.
    pub fn logarithmic(values: impl IntoIterator<Item = f64>, count: usize) -> Self {
        let positive = values.into_iter().filter(|value| value.is_finite() && *value > 0.0).map(f64::log10);
        let (low, high) = positive.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        let (mut low, mut high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        if high - low < FLAT * low.abs().max(1.0) {
            (low, high) = (low - 0.5, high + 0.5);
        }
        let decades = (low - FLAT).ceil() as i64..=(high + FLAT).floor() as i64;
        let between: &[f64] = if high - low < 1.5 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let every = ((high - low) / count as f64).ceil().max(1.0) as i64;
        let first = decades.start() - i64::from(between.len() > 1);
        let ticks = (first..=*decades.end()).filter(|decade| decade % every == 0);
        let ticks = ticks.flat_map(|decade| between.iter().map(move |digit| decade as f64 + digit.log10()));
        let ticks: Vec<f64> = ticks.filter(|tick| (low - FLAT..=high + FLAT).contains(tick)).collect();
        // An interval of less than a decade may contain no such tick.
        let ticks = if ticks.len() < 2 { vec![low, high] } else { ticks };
        Axis { low, high, ticks, exponent: 0, decimals: 0, is_logarithmic: true }
    }

    /// Returns the position of a value between the ends, 0 to 1; NaN for a value that a logarithmic axis cannot show.
    pub fn share(&self, value: f64) -> f64 {
        (self.scaled(value) - self.low) / (self.high - self.low)
    }

    /// Returns the interval widened by a margin on both sides, but not across zero.
    pub fn widened(mut self, share: f64) -> Self {
        let margin = share * (self.high - self.low);
        if self.is_logarithmic {
            (self.low, self.high) = (self.low - margin, self.high + margin);
            return self;
        }
        self.low = if self.low >= 0.0 { (self.low - margin).max(0.0) } else { self.low - margin };
        self.high = if self.high <= 0.0 { (self.high + margin).min(0.0) } else { self.high + margin };
        self
    }

    /// Returns a value in the scale of the axis.
    pub fn scaled(&self, value: f64) -> f64 {
        match self.is_logarithmic {
            true if value > 0.0 => value.log10(),
            true => f64::NAN,
            false => value / 10f64.powi(self.exponent),
        }
    }

    /// Inverse of [`Axis::scaled`].
    pub fn unscaled(&self, value: f64) -> f64 {
        if self.is_logarithmic { 10f64.powf(value) } else { value * 10f64.powi(self.exponent) }
    }

    /// Label of a tick.
    pub fn label(&self, tick: f64) -> String {
        if self.is_logarithmic {
            return power_label(tick);
        }
        format!("{tick:.*}", self.decimals).replace('-', "\u{2212}")
    }

    /// Label of the axis with its factor, such as `energy (×10⁻⁶)`.
    pub fn name(&self, name: &str) -> String {
        if self.exponent == 0 {
            return name.into();
        }
        format!("{name} (×10{})", raised(self.exponent.into())).trim_start().into()
    }
}

/// Label of a tick of a logarithmic axis, such as `0.02`, `10⁻⁷` or `5·10⁻⁷`.
fn power_label(tick: f64) -> String {
    let decade = (tick + FLAT).floor();
    let digit = 10f64.powf(tick - decade);
    let is_digit = (digit - digit.round()).abs() < 0.01;
    if decade.abs() < LONG {
        let decimals = (-decade).max(0.0) as usize + if is_digit { 0 } else { 2 };
        return format!("{:.decimals$}", 10f64.powf(tick));
    }
    let power = format!("10{}", raised(decade as i64));
    match is_digit {
        true if digit.round() == 1.0 => power,
        true => format!("{}·{power}", digit.round()),
        false => format!("{digit:.2}·{power}"),
    }
}

fn raised(exponent: i64) -> String {
    exponent.to_string().chars().map(superscript).collect()
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
    fn logarithmic_ticks_are_powers_of_ten() {
        let labels = |low: f64, high: f64| {
            let axis = Axis::logarithmic([low, high, -1.0, 0.0, f64::NAN], 6);
            axis.ticks.iter().map(|&tick| axis.label(tick)).collect::<Vec<_>>()
        };
        assert_eq!(labels(0.01, 100.0), ["0.01", "0.1", "1", "10", "100"]);
        assert_eq!(labels(1e-16, 1e-4), ["10⁻¹⁶", "10⁻¹⁴", "10⁻¹²", "10⁻¹⁰", "10⁻⁸", "10⁻⁶", "10⁻⁴"]);
        assert_eq!(labels(1.0, 10.0), ["1", "2", "5", "10"]);
        assert_eq!(labels(1e-7, 1e-6), ["10⁻⁷", "2·10⁻⁷", "5·10⁻⁷", "10⁻⁶"]);
        assert_eq!(labels(0.3, 30.0), ["1", "10"]);
        assert_eq!(labels(3.0, 4.0), ["3", "4"]);
        for range in [[5e-324, f64::MAX], [1.0, 1.0], [f64::MAX, f64::MAX], [5e-324, 5e-324], [-1.0, -1.0]] {
            let axis = Axis::logarithmic(range, 6);
            assert!((2..=12).contains(&axis.ticks.len()) && axis.low < axis.high, "{range:?}: {axis:?}");
        }
        assert!(Axis::logarithmic([1.0, 100.0], 5).share(0.0).is_nan());
        assert!((Axis::logarithmic([1.0, 100.0], 5).share(10.0) - 0.5).abs() < 1e-15);
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
