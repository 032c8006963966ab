//! Color scale of a field: bands between two values, and the color bar.

use crate::output::axis::Axis;
use crate::output::colormap::viridis;
use crate::output::drawing::{Anchor, Color, Drawing, Point, Stroke, elided, text_width};

/// Colors between the ends of the color bar. Odd, so that the round-off of a constant field stays inside the middle one.
pub(super) const BANDS: usize = 41;
/// Size of text beside the bar, in pixels.
pub(super) const TEXT: f64 = 16.0;
/// Color of outlines.
pub(super) const INK: Color = [34; 3];
/// Colors of categories, the first for none; distinguishable with any color vision.
const KINDS: [Color; 3] = [[222, 224, 228], [33, 102, 172], [230, 97, 1]];
/// Width of the bar in pixels.
const WIDTH: f64 = 18.0;

/// Color scale of a field.
pub(super) struct Scale {
    axis: Axis,
    low: f64,
    high: f64,
    label: String,
    /// Names of the values 1, 2, … of categories; empty for quantities.
    kinds: &'static [&'static str],
    /// True if no body has the field: there is no bar.
    is_blank: bool,
}

impl Scale {
    /// Returns the scale of a range of values.
    pub fn new(values: impl IntoIterator<Item = f64>, label: &str) -> Self {
        let axis = Axis::over(values, 6);
        let label = axis.name(label);
        Scale { low: axis.unscaled(axis.low), high: axis.unscaled(axis.high), axis, label, kinds: &[], is_blank: false }
    }

    /// Returns the scale of categories with these names.
    pub fn of_kinds(kinds: &'static [&'static str], label: &str) -> Self {
        Scale { kinds, ..Scale::new([], label) }
    }

    /// Returns the scale of a field that no body has.
    pub fn blank() -> Self {
        Scale { is_blank: true, ..Scale::new([], "") }
    }

    /// True if values are categories, not quantities.
    pub fn has_kinds(&self) -> bool {
        !self.kinds.is_empty()
    }

    /// Color of a category.
    pub fn kind_color(&self, kind: usize) -> Color {
        KINDS[kind.min(KINDS.len() - 1)]
    }

    /// Color of a band under a light intensity from 0 to 1.
    pub fn color(&self, band: usize, light: f64) -> Color {
        let color = if self.has_kinds() { KINDS[0].map(f64::from) } else { viridis((band as f64 + 0.5) / BANDS as f64) };
        color.map(|channel| (channel * light).round() as u8)
    }

    /// Lower end of a band.
    pub fn level(&self, band: usize) -> f64 {
        let share = band as f64 / BANDS as f64;
        self.low * (1.0 - share) + self.high * share
    }

    /// Returns the band of a value.
    pub fn band(&self, value: f64) -> usize {
        (1..BANDS).take_while(|&band| value >= self.level(band)).count()
    }

    /// Width of the bar with its numbers and the name of the field.
    pub fn width(&self) -> f64 {
        if self.is_blank {
            return 0.0;
        }
        let numbers = self.axis.ticks.iter().map(|&tick| text_width(&self.axis.label(tick), TEXT));
        let names = self.kinds.iter().map(|name| text_width(name, TEXT));
        let widest = if self.has_kinds() { names.fold(0.0, f64::max) } else { numbers.fold(0.0, f64::max) };
        WIDTH + 8.0 + widest + 10.0 + TEXT
    }

    /// Draws the bar with its upper left corner at a point.
    pub fn bar_into(&self, out: &mut Drawing, [x, y]: Point, height: f64) {
        if self.is_blank {
            return;
        }
        let label = elided(&self.label, TEXT, height + 40.0);
        out.upward_text([x + self.width() - 4.0, y + 0.5 * height], label, TEXT, Anchor::Middle);
        if self.has_kinds() {
            return self.names_into(out, [x, y + 0.5 * height]);
        }
        for band in 0..BANDS {
            // Each band extends to the end of the bar, so that there are no hairlines between bands.
            let size = height * (1.0 - band as f64 / BANDS as f64);
            out.filled_box([x, y], [x + WIDTH, y + size], self.color(band, 1.0));
        }
        let thin = Stroke::new(INK, 1.0);
        out.framed_box([x, y], [x + WIDTH, y + height], thin);
        for &tick in &self.axis.ticks {
            let at = y + height * (1.0 - (tick - self.axis.low) / (self.axis.high - self.axis.low));
            out.line([[x + WIDTH, at], [x + WIDTH + 4.0, at]], thin);
            out.text([x + WIDTH + 8.0, at + 0.35 * TEXT], self.axis.label(tick), TEXT, Anchor::Start);
        }
    }

    /// Draws the names of categories one below the other, centered at the height `middle`.
    fn names_into(&self, out: &mut Drawing, [x, middle]: Point) {
        let line = 1.5 * TEXT;
        for (index, name) in self.kinds.iter().enumerate() {
            let y = middle + line * (index as f64 - 0.5 * self.kinds.len() as f64);
            out.filled_box([x, y], [x + WIDTH, y + TEXT], self.kind_color(index + 1));
            out.text([x + WIDTH + 8.0, y + 0.85 * TEXT], *name, TEXT, Anchor::Start);
        }
    }
}
