//! Curves in a pair of axes: histories, columns against columns, arrays of a script.
//!
//! The legend is above the axes in as many rows as necessary, so that it never hides a curve. A long curve is thinned to the first, lowest,
//! highest and last value per column of pixels, which gives the same picture. Values that are not finite, or not positive on a logarithmic
//! axis, leave a gap.

use super::axis::Axis;
use super::drawing::{Anchor, Color, Drawing, Ink, Line, Point, Stroke, elided, text_width};

/// Colors of Okabe & Ito (2008), distinguishable with any color vision.
const COLORS: [Color; 7] = [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [230, 159, 0], [86, 180, 233], [120, 120, 120]];
const BLACK: Color = [0; 3];
const GRID: Color = [226; 3];
const INK: Color = [34; 3];
/// Sizes of text in pixels: readable where the picture is shown at half of its size.
const TITLE: f64 = 20.0;
const TEXT: f64 = 17.0;
/// Margin in pixels.
const MARGIN: f64 = 12.0;
/// Length of a sample in the legend, in pixels.
const SAMPLE: f64 = 26.0;
/// Radius of a marker in pixels.
const MARKER: f64 = 3.5;
/// Number of corners of a round marker.
const ROUND: usize = 12;
/// Least height of the axes in pixels.
const LEAST: f64 = 100.0;
/// Margin above and below the values relative to their range.
const FREE: f64 = 0.04;

/// Style of a curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CurveStyle {
    /// Joined by a line.
    #[default]
    Line,
    /// Joined by dashes.
    Dashed,
    /// A marker for each value.
    Points,
}

impl CurveStyle {
    /// All styles with their names in scripts.
    pub const ALL: &'static [(&'static str, CurveStyle)] =
        &[("line", CurveStyle::Line), ("dashed", CurveStyle::Dashed), ("points", CurveStyle::Points)];
}

/// A curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// Text in the legend.
    pub label: String,
    /// Values on the horizontal axis.
    pub x: Vec<f64>,
    /// Values on the vertical axis, as many as in `x`.
    pub y: Vec<f64>,
    /// Style of the curve.
    pub style: CurveStyle,
    /// True for a sum, drawn in black and slightly wider.
    pub is_sum: bool,
}

/// One of the two axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlotAxis {
    /// Label with the unit.
    pub label: String,
    /// Values at the ends of the axis; `None` for the range of the curves.
    pub range: Option<[f64; 2]>,
    /// True for a logarithmic scale.
    pub is_logarithmic: bool,
    /// Value that the axis must include.
    pub included: Option<f64>,
}

impl PlotAxis {
    /// Returns a linear axis.
    pub fn new(label: impl Into<String>) -> Self {
        PlotAxis { label: label.into(), ..PlotAxis::default() }
    }

    fn over<'a>(&self, values: impl Iterator<Item = &'a f64>, count: usize, free: f64) -> Axis {
        let values = values.copied().chain(self.included);
        match (self.range, self.is_logarithmic) {
            (Some(range), true) => Axis::logarithmic(range, count),
            (Some(range), false) => Axis::over(range, count),
            (None, true) => Axis::logarithmic(values, count).widened(free),
            (None, false) => Axis::over(values, count).widened(free),
        }
    }
}

/// Curves in a pair of axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// Title above the diagram.
    pub title: String,
    /// Horizontal axis.
    pub x: PlotAxis,
    /// Vertical axis.
    pub y: PlotAxis,
    /// Curves of the plot.
    pub curves: Vec<Curve>,
    /// Width and height in pixels.
    pub size: [f64; 2],
}

impl Default for Plot {
    fn default() -> Self {
        Plot { title: String::new(), x: PlotAxis::default(), y: PlotAxis::default(), curves: Vec::new(), size: [720.0, 420.0] }
    }
}

/// Axes with their labels, in a picture of a given height.
pub(super) struct PlotFrame {
    height: f64,
    pub low: Point,
    pub high: Point,
    x: Axis,
    y: Axis,
}

impl PlotFrame {
    /// Begins a group clipped to the box, extended by half of a line's width.
    pub fn clip_into(&self, out: &mut Drawing) {
        out.begin_clipped([self.low[0] - 2.0, self.low[1] - 2.0], [self.high[0] + 2.0, self.high[1] + 2.0]);
    }

    /// Returns the pixels of a value; NaN if an axis cannot show the value.
    pub fn place(&self, x: f64, y: f64) -> Point {
        let [right, up] = [self.x.share(x), self.y.share(y)];
        [self.low[0] + right * (self.high[0] - self.low[0]), self.high[1] - up * (self.high[1] - self.low[1])]
    }
}

impl Plot {
    /// The plot as a drawing.
    pub fn draw(&self) -> Drawing {
        let (mut out, frame) = self.framed(0.0);
        frame.clip_into(&mut out);
        for (curve, color) in self.colored() {
            curve_into(&mut out, curve, color, &frame);
        }
        out.end();
        out
    }

    /// Draws title, legend and axes, with `free` pixels left at the right.
    pub(super) fn framed(&self, free: f64) -> (Drawing, PlotFrame) {
        let [width, height] = self.size;
        let mut out = Drawing::new(self.size);
        let (count_x, count_y) = ((width / 80.0) as usize, (height / 65.0) as usize);
        // Leave room for whole markers at the ends.
        let aside = if self.curves.iter().any(|curve| curve.style == CurveStyle::Points) { FREE } else { 0.0 };
        let x = self.x.over(self.curves.iter().flat_map(|curve| &curve.x), count_x.max(2), aside);
        let y = self.y.over(self.curves.iter().flat_map(|curve| &curve.y), count_y.max(2), FREE);
        let widest = |axis: &Axis| axis.ticks.iter().map(|&tick| text_width(&axis.label(tick), TEXT)).fold(0.0, f64::max);
        let label_height = |axis: &PlotAxis, size: f64| if axis.label.is_empty() { 0.0 } else { size };
        let left = MARGIN + label_height(&self.y, TEXT + 10.0) + widest(&y) + 8.0;
        let right = width - free - MARGIN - (0.5 * widest(&x)).min(30.0);
        let top = self.head_into(&mut out, left, right);
        // A legend with many rows increases the height of the picture and does not reduce the axes.
        let below = MARGIN + label_height(&self.x, TEXT + 8.0) + TEXT + 4.0;
        let height = height.max(top + LEAST + below);
        out.set_height(height);
        let frame = PlotFrame { low: [left, top], high: [right, height - below], height, x, y };
        self.axes_into(&mut out, &frame);
        (out, frame)
    }

    fn colored(&self) -> impl Iterator<Item = (&Curve, Color)> {
        let mut colors = COLORS.iter().cycle();
        self.curves.iter().map(move |curve| (curve, if curve.is_sum { BLACK } else { colors.next().copied().unwrap_or(BLACK) }))
    }

    /// Draws title and legend; returns the vertical position below.
    fn head_into(&self, out: &mut Drawing, left: f64, right: f64) -> f64 {
        let mut y = MARGIN;
        if !self.title.is_empty() {
            y += TITLE;
            out.text([left, y - 2.0], elided(&self.title, TITLE, right - left), TITLE, Anchor::Start);
            y += 8.0;
        }
        let labelled: Vec<(&Curve, Color)> = self.colored().filter(|(curve, _)| !curve.label.is_empty()).collect();
        // A single curve is already described by the axis.
        if labelled.is_empty() || labelled.len() == 1 && self.curves.len() == 1 && labelled[0].0.label == self.y.label {
            return y + 4.0;
        }
        let mut x = left;
        y += 0.5 * TEXT;
        for (curve, color) in labelled {
            let label = elided(&curve.label, TEXT, right - left - SAMPLE - 8.0);
            let length = SAMPLE + 8.0 + text_width(&label, TEXT);
            if x > left && x + length > right {
                (x, y) = (left, y + TEXT + 6.0);
            }
            match curve.style {
                CurveStyle::Points => out.paint(vec![marker([x + 0.5 * SAMPLE, y])], Ink::Fill(color)),
                _ => out.line([[x, y], [x + SAMPLE, y]], stroke(curve, color)),
            }
            out.text([x + SAMPLE + 8.0, y + 0.35 * TEXT], label, TEXT, Anchor::Start);
            x += length + 22.0;
        }
        y + 0.5 * TEXT + 10.0
    }

    fn axes_into(&self, out: &mut Drawing, frame: &PlotFrame) {
        let (PlotFrame { low, high, x, y, height }, thin) = (frame, Stroke::new(GRID, 1.0));
        let at_x = |tick: f64| low[0] + (tick - x.low) / (x.high - x.low) * (high[0] - low[0]);
        let at_y = |tick: f64| high[1] - (tick - y.low) / (y.high - y.low) * (high[1] - low[1]);
        for &tick in &x.ticks {
            out.line([[at_x(tick), low[1]], [at_x(tick), high[1]]], thin);
        }
        for &tick in &y.ticks {
            out.line([[low[0], at_y(tick)], [high[0], at_y(tick)]], thin);
        }
        let solid = Stroke::new(INK, 1.0);
        out.line([*low, [low[0], high[1]], *high], solid);
        let mut end = f64::NEG_INFINITY;
        for &tick in &x.ticks {
            out.line([[at_x(tick), high[1]], [at_x(tick), high[1] + 5.0]], solid);
            let (label, middle) = (x.label(tick), at_x(tick));
            let half = 0.5 * text_width(&label, TEXT);
            // Long numbers would overlap.
            if middle - half > end {
                out.text([middle, high[1] + TEXT + 5.0], label, TEXT, Anchor::Middle);
                end = middle + half + 6.0;
            }
        }
        for &tick in &y.ticks {
            out.line([[low[0] - 5.0, at_y(tick)], [low[0], at_y(tick)]], solid);
            out.text([low[0] - 8.0, at_y(tick) + 0.35 * TEXT], y.label(tick), TEXT, Anchor::End);
        }
        let label = elided(&x.name(&self.x.label), TEXT, self.size[0] - 2.0 * MARGIN);
        let half = 0.5 * text_width(&label, TEXT);
        let middle = (0.5 * (low[0] + high[0])).clamp(half + MARGIN, (self.size[0] - half - MARGIN).max(half + MARGIN));
        out.text([middle, height - MARGIN], label, TEXT, Anchor::Middle);
        let label = elided(&y.name(&self.y.label), TEXT, height - 2.0 * MARGIN);
        let half = 0.5 * text_width(&label, TEXT);
        let middle = (0.5 * (low[1] + high[1])).clamp(half + MARGIN, (height - half - MARGIN).max(half + MARGIN));
        out.upward_text([MARGIN + TEXT - 2.0, middle], label, TEXT, Anchor::Middle);
    }
}

fn stroke(curve: &Curve, color: Color) -> Stroke {
    let dash = (curve.style == CurveStyle::Dashed).then_some(7.0);
    Stroke { dash, ..Stroke::new(color, if curve.is_sum { 2.4 } else { 2.0 }) }
}

fn marker([x, y]: Point) -> Line {
    let corner = |k: usize| {
        let angle = k as f64 / ROUND as f64 * std::f64::consts::TAU;
        [x + MARKER * angle.cos(), y + MARKER * angle.sin()]
    };
    Line::closed((0..ROUND).map(corner).collect::<Vec<_>>())
}

fn curve_into(out: &mut Drawing, curve: &Curve, color: Color, frame: &PlotFrame) {
    let places: Vec<Point> = curve.x.iter().zip(&curve.y).map(|(&x, &y)| frame.place(x, y)).collect();
    let mut markers = Vec::new();
    for run in places.split(|place| !place.iter().all(|x| x.is_finite())).filter(|run| !run.is_empty()) {
        let thinned = thinned(run);
        if curve.style == CurveStyle::Points || run.len() == 1 {
            markers.extend(thinned.into_iter().map(marker));
        } else {
            out.line(thinned, stroke(curve, color));
        }
    }
    out.paint(markers, Ink::Fill(color));
}

/// Returns the first, highest, lowest and last point of every section within one column of pixels, in their order.
fn thinned(points: &[Point]) -> Vec<Point> {
    let mut kept = Vec::new();
    for stretch in points.chunk_by(|a, b| a[0].floor() == b[0].floor()) {
        let extreme =
            |sign: f64| (0..stretch.len()).max_by(|&a, &b| (sign * stretch[a][1]).total_cmp(&(sign * stretch[b][1]))).unwrap_or(0);
        let mut chosen = [0, extreme(-1.0), extreme(1.0), stretch.len() - 1];
        chosen.sort_unstable();
        kept.extend(chosen.iter().enumerate().filter(|&(at, index)| at == 0 || chosen[at - 1] != *index).map(|(_, &index)| stretch[index]));
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::super::drawing::{png, svg};
    use super::super::samples::well_formed;
    use super::*;

    fn plot(title: &str, x: &[f64], curves: &[(&str, &[f64])]) -> Plot {
        let curve = |&(label, y): &(&str, &[f64])| Curve { label: label.into(), x: x.into(), y: y.into(), ..Curve::default() };
        let curves = curves.iter().map(curve).collect();
        Plot { title: title.into(), x: PlotAxis::new("time"), y: PlotAxis::new("value"), curves, ..Plot::default() }
    }

    /// Corners of the stroked paths that have more than three, in pixels.
    fn polylines(svg: &str) -> Vec<Vec<[f64; 2]>> {
        let corners = |line: &str| {
            let data = line.split('"').nth(1).unwrap().replace(['M', 'l'], " ").replace('-', " -");
            let numbers: Vec<f64> = data.split_whitespace().map(|word| word.parse().unwrap()).collect();
            let steps = numbers.chunks(2).scan([0.0, 0.0], |at: &mut [f64; 2], step| {
                *at = [at[0] + 0.1 * step[0], at[1] + 0.1 * step[1]];
                Some(*at)
            });
            steps.collect::<Vec<_>>()
        };
        let curves = svg.split("<g clip").nth(1).unwrap();
        curves.lines().filter(|line| line.starts_with("<path") && line.contains("fill=\"none\"")).map(corners).collect()
    }

    #[test]
    fn curves_have_the_values_heights() {
        let time: Vec<f64> = (0..=10).map(f64::from).collect();
        let values: Vec<f64> = time.iter().map(|t| t * t).collect();
        let curves = polylines(&svg(&plot("", &time, &[("square", &values)]).draw()));
        let place = |index: usize, d: usize| curves[0][index][d];
        for (index, value) in values.iter().enumerate() {
            let share = (place(0, 1) - place(index, 1)) / (place(0, 1) - place(10, 1));
            // Half a tenth of a pixel on a height of about 300.
            assert!((share - value / 100.0).abs() < 1e-3, "{share} for {value}");
            assert!((place(index, 0) - place(0, 0) - index as f64 / 10.0 * (place(10, 0) - place(0, 0))).abs() <= 0.1);
        }
    }

    #[test]
    fn a_power_is_straight_on_logarithmic_axes() {
        let x = [1.0, 10.0, 100.0, 1000.0];
        let mut plot = plot("", &x, &[("square", &[1e-4, 1e-2, 1.0, 1e2])]);
        (plot.x.is_logarithmic, plot.y.is_logarithmic) = (true, true);
        let curve = &polylines(&svg(&plot.draw()))[0];
        let slope = |k: usize| (curve[k + 1][1] - curve[k][1]) / (curve[k + 1][0] - curve[k][0]);
        assert!((slope(0) - slope(2)).abs() < 2e-3 && slope(0) < 0.0, "{curve:?}");
        // Values that are not positive leave a gap on a logarithmic axis.
        plot.curves[0].y = vec![1.0, 0.0, -1.0, 10.0];
        let text = svg(&plot.draw());
        well_formed(&text);
        assert!(polylines(&text).is_empty() && text.contains(">10<"), "two lonely values are dots");
    }

    #[test]
    fn a_chosen_range_cuts_the_curves_and_the_legend_is_in_words() {
        let mut plot =
            plot("", &[0.0, 1.0, 2.0], &[("kinetic energy of the long inner ring in words", &[0.0, 1e3, 0.0]), ("b", &[1.0; 3])]);
        plot.y.range = Some([0.0, 2.0]);
        let text = svg(&plot.draw());
        assert!(text.contains(">2.0<") && text.contains("<clipPath") && !text.contains(">1000<"));
        assert!(text.contains(">kinetic energy of the long inner ring in words<"));
        plot.curves[0].label = "very ".repeat(60);
        let text = svg(&plot.draw());
        assert!(text.contains("…</text>") && !text.contains(&"very ".repeat(30)), "what has no room is cut off");
    }

    #[test]
    fn a_legend_of_many_rows_makes_the_picture_higher() {
        let values: &[f64] = &[0.0, 1.0];
        let text = svg(&plot("", values, &[("a curve with a name of some length", values); 60]).draw());
        well_formed(&text);
        let height: f64 = text.split("height=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
        let axes = text.split("<clipPath").nth(1).unwrap().split(" y=\"").nth(1).unwrap().split('"').next().unwrap();
        // The lowest row of the legend is above the axes.
        let lowest = text
            .split("<text x=")
            .filter(|part| part.contains(">a curve"))
            .filter_map(|part| part.split("y=\"").nth(1)?.split('"').next()?.parse().ok());
        assert!(height > 600.0 && lowest.fold(0.0, f64::max) < axes.parse().unwrap(), "{height} {axes}");
    }

    #[test]
    fn odd_curves_make_a_picture_all_the_same() {
        let time: Vec<f64> = (0..100).map(f64::from).collect();
        let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308, -1e308, 0.0, 5e-324];
        let mixed: Vec<f64> = (0..100).map(|index| odd[index % odd.len()]).collect();
        for values in [vec![], vec![1.0], vec![3.25; 100], vec![0.0; 100], vec![f64::NAN; 100], mixed.clone()] {
            for is_logarithmic in [false, true] {
                let mut plot = plot("odd", &time, &[("x", &values)]);
                plot.y.is_logarithmic = is_logarithmic;
                let text = svg(&plot.draw());
                well_formed(&text);
                assert!(
                    polylines(&text).concat().iter().all(|&[x, y]| (0.0..720.0).contains(&x) && (0.0..420.0).contains(&y)),
                    "{values:?}"
                );
                assert!(png(&plot.draw()).is_some_and(|bytes| bytes.starts_with(b"\x89PNG")));
            }
        }
        well_formed(&svg(&plot("<&>\"", &[], &[]).draw()));
    }

    #[test]
    fn a_value_that_is_none_leaves_a_gap() {
        let time: Vec<f64> = (0..9).map(f64::from).collect();
        let text = svg(&plot("", &time, &[("x", &[1.0, 2.0, 3.0, f64::NAN, 5.0, f64::NAN, 1.0, 2.0, 3.0])]).draw());
        assert_eq!(polylines(&text).iter().filter(|points| points.len() == 3).count(), 2);
        let filled = text.split("<g clip").nth(1).unwrap().matches("fill=\"#").count();
        assert_eq!(filled, 1, "the lonely value is a dot");
    }

    #[test]
    fn a_long_history_is_thinned_without_losing_a_spike() {
        let count = 100_000;
        let time: Vec<f64> = (0..count).map(|i| i as f64 / count as f64).collect();
        let mut values: Vec<f64> = time.iter().map(|t| (500.0 * t).sin()).collect();
        values[31_416] = 40.0;
        values[77_777] = -40.0;
        let text = svg(&plot("long", &time, &[("x", &values)]).draw());
        assert!(text.len() < 60_000, "{} bytes", text.len());
        let points: Vec<Point> = time.iter().zip(&values).map(|(&x, &y)| [620.0 * x, y]).collect();
        let few = thinned(&points);
        assert!(few.len() <= 4 * 620 && few.is_sorted_by(|a, b| a[0] < b[0]));
        assert!(few.contains(&points[31_416]) && few.contains(&points[77_777]) && few.last() == points.last());
        assert_eq!(thinned(&[[0.0, 1.0], [1.5, 2.0], [0.2, 0.0]]).len(), 3, "a short curve is kept as it is");
    }
}
