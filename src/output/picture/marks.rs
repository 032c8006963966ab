//! Indicators of lengths and directions in a picture: a scale bar, or axes around a plane picture; a triad in space.

use super::arrows::number;
use super::scale::{INK, TEXT};
use super::view::{Camera, View};
use crate::output::axis::Axis;
use crate::output::drawing::{Anchor, Color, Drawing, Point, Stroke, text_width};

/// Largest length of the scale bar relative to the width of the picture.
const LONGEST: f64 = 0.3;
/// Approximate number of pixels between ticks.
const TICKS: f64 = 60.0;
/// Length of an axis of the triad in pixels.
const TRIAD: f64 = 30.0;
/// Customary colors of `x`, `y` and `z`.
const COLORS: [Color; 3] = [[192, 32, 32], [24, 132, 48], [32, 72, 200]];

/// Draws a bar of a round length with its left end at a point; returns its width with the label.
pub(super) fn bar_into(out: &mut Drawing, [x, y]: Point, zoom: f64, width: f64, unit: &str) -> f64 {
    let longest = LONGEST * width / zoom;
    let power = 10f64.powf(longest.log10().floor());
    let length = [5.0, 2.0, 1.0].into_iter().map(|digit| digit * power).find(|&length| length <= longest).unwrap_or(power);
    let (pixels, stroke) = (length * zoom, Stroke::new(INK, 1.6));
    out.line([[x, y], [x + pixels, y]], stroke);
    for end in [x, x + pixels] {
        out.line([[end, y - 4.0], [end, y + 4.0]], stroke);
    }
    let label = format!("{} {unit}", number(length));
    out.text([x + pixels + 8.0, y + 0.35 * TEXT], label.trim_end(), TEXT, Anchor::Start);
    pixels + 8.0 + text_width(label.trim_end(), TEXT)
}

/// Axes along the lower and the left side of a plane picture.
pub(super) struct Axes {
    x: Axis,
    y: Axis,
    names: [String; 2],
}

impl Axes {
    /// Returns axes for the region between `low` and `high`, with `zoom` pixels per length.
    pub fn over(low: Point, high: Point, zoom: f64, unit: &str) -> Self {
        let axis = |d: usize| Axis::over([low[d], high[d]], (((high[d] - low[d]) * zoom / TICKS) as usize).max(2));
        let (x, y) = (axis(0), axis(1));
        let unit = if unit.is_empty() { String::new() } else { format!(" [{unit}]") };
        let names = [x.name(&format!("x{unit}")), y.name(&format!("y{unit}"))];
        Axes { x, y, names }
    }

    /// Width of numbers and name on the left, in pixels.
    pub fn width(&self) -> f64 {
        self.y.ticks.iter().map(|&tick| text_width(&self.y.label(tick), TEXT)).fold(0.0, f64::max) + 10.0 + TEXT + 4.0
    }

    /// Height of numbers and name below, in pixels.
    pub const HEIGHT: f64 = 2.0 * TEXT + 14.0;

    /// Draws the axes around the visible region.
    pub fn draw_into(&self, out: &mut Drawing, camera: &Camera) {
        let (low, high) = (camera.pixel(camera.bounds.low), camera.pixel(camera.bounds.high()));
        let thin = Stroke::new(INK, 1.0);
        out.framed_box(low, high, thin);
        let mut end = f64::NEG_INFINITY;
        for &tick in &self.x.ticks {
            let [x, y] = camera.pixel([self.x.unscaled(tick), camera.bounds.low[1]]);
            out.line([[x, y], [x, y + 5.0]], thin);
            let label = self.x.label(tick);
            let half = 0.5 * text_width(&label, TEXT);
            if x - half > end {
                out.text([x, y + TEXT + 4.0], label, TEXT, Anchor::Middle);
                end = x + half + 6.0;
            }
        }
        for &tick in &self.y.ticks {
            let [x, y] = camera.pixel([camera.bounds.low[0], self.y.unscaled(tick)]);
            out.line([[x - 5.0, y], [x, y]], thin);
            out.text([x - 8.0, y + 0.35 * TEXT], self.y.label(tick), TEXT, Anchor::End);
        }
        out.text([0.5 * (low[0] + high[0]), low[1] + 2.0 * TEXT + 8.0], &*self.names[0], TEXT, Anchor::Middle);
        out.upward_text([low[0] - self.width() + TEXT, 0.5 * (low[1] + high[1])], &*self.names[1], TEXT, Anchor::Middle);
    }
}

/// Space for the triad on each side of its origin, in pixels.
pub(super) const TRIAD_ROOM: f64 = TRIAD + TEXT;

/// Draws the directions of `x`, `y` and `z` around a point.
pub(super) fn triad_into(out: &mut Drawing, origin: Point, view: &View) {
    let mut axes: [(usize, [f64; 3]); 3] = [0, 1, 2].map(|axis| {
        let along = |of: [f64; 3]| of[axis];
        (axis, [along(view.right), along(view.up), along(view.toward)])
    });
    axes.sort_by(|a, b| a.1[2].total_cmp(&b.1[2]));
    for (axis, [right, up, _]) in axes {
        let end = [origin[0] + TRIAD * right, origin[1] - TRIAD * up];
        let stroke = Stroke::new(COLORS[axis], 2.0);
        out.line([origin, end], stroke);
        let length = right.hypot(up);
        // An axis toward the viewer is a point; its name is placed beside it.
        let way = if length > 0.05 { [right / length, up / length] } else { [-0.7, -0.7] };
        let at = [end[0] + 0.6 * TEXT * way[0], end[1] - 0.6 * TEXT * way[1] + 0.3 * TEXT];
        out.text(at, ["x", "y", "z"][axis], TEXT, Anchor::Middle);
    }
}
