//! Values over two parameters as colors: boxes for values on a grid, markers for scattered ones.
//!
//! Values are not interpolated, so the picture shows computed values only.

use super::axis::Axis;
use super::colormap::viridis;
use super::drawing::{Anchor, Color, Drawing, Ink, Line, Point, Stroke};
use super::plot::{Plot, PlotAxis, PlotFrame};

/// Values over two parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Response {
    /// Title above the diagram.
    pub title: String,
    /// Horizontal axis.
    pub x: PlotAxis,
    /// Vertical axis.
    pub y: PlotAxis,
    /// Label of the color bar.
    pub label: String,
    /// Positions with their values, finite.
    pub points: Vec<[f64; 3]>,
}

/// Space for the color bar at the right, in pixels.
const SCALE: f64 = 110.0;
/// Width of the color bar in pixels.
const BAR: f64 = 18.0;
/// Size of the color bar's text in pixels.
const TEXT: f64 = 15.0;
/// Radius of a marker in pixels.
const MARKER: f64 = 7.0;
/// Number of corners of a round marker.
const ROUND: usize = 16;
/// Number of boxes of the color bar.
const STEPS: usize = 64;
/// Margin around markers relative to the range.
const FREE: f64 = 0.05;

impl Response {
    /// Draws the picture.
    pub fn draw(&self) -> Drawing {
        let (columns, rows) = (different(&self.points, 0), different(&self.points, 1));
        let is_grid = columns.len() > 1 && rows.len() > 1 && columns.len() * rows.len() == self.points.len() && self.is_each_once();
        let borders = |values: &[f64], axis: &PlotAxis| {
            if is_grid { borders(values, axis.is_logarithmic) } else { free(values, axis.is_logarithmic) }
        };
        let (across, up) = (borders(&columns, &self.x), borders(&rows, &self.y));
        let ends = |borders: &[f64]| Some([borders[0], borders[borders.len() - 1]]);
        let plot = Plot {
            title: self.title.clone(),
            x: PlotAxis { range: ends(&across), ..self.x.clone() },
            y: PlotAxis { range: ends(&up), ..self.y.clone() },
            ..Plot::default()
        };
        let (mut out, frame) = plot.framed(SCALE);
        let values = Axis::over(self.points.iter().map(|point| point[2]), 6);
        let color = |value: f64| painted(values.share(value));
        frame.clip_into(&mut out);
        for &[x, y, value] in &self.points {
            if is_grid {
                let (i, j) = (columns.partition_point(|&other| other < x), rows.partition_point(|&other| other < y));
                let ([left, bottom], [right, top]) = (frame.place(across[i], up[j]), frame.place(across[i + 1], up[j + 1]));
                out.filled_box([left, top], [right, bottom], color(value));
            } else {
                let at = frame.place(x, y);
                out.paint(vec![round(at)], Ink::Fill(color(value)));
                out.paint(vec![round(at)], Ink::Stroke(Stroke::new([90; 3], 0.8)));
            }
        }
        out.end();
        self.scale_into(&mut out, &frame, &values);
        out
    }

    fn is_each_once(&self) -> bool {
        let mut places: Vec<[u64; 2]> = self.points.iter().map(|[x, y, _]| [x.to_bits(), y.to_bits()]).collect();
        places.sort_unstable();
        places.windows(2).all(|pair| pair[0] != pair[1])
    }

    /// Draws the color bar.
    fn scale_into(&self, out: &mut Drawing, frame: &PlotFrame, values: &Axis) {
        let (low, high) = (frame.low[1], frame.high[1]);
        let left = frame.high[0] + 24.0;
        let at = |share: f64| high - share * (high - low);
        for step in 0..STEPS {
            let [below, above] = [step, step + 1].map(|step| step as f64 / STEPS as f64);
            out.filled_box([left, at(above) - 0.3], [left + BAR, at(below)], painted(0.5 * (below + above)));
        }
        out.framed_box([left, low], [left + BAR, high], Stroke::new([120; 3], 1.0));
        for &tick in &values.ticks {
            let share = (tick - values.low) / (values.high - values.low);
            out.text([left + BAR + 6.0, at(share) + 0.35 * TEXT], values.label(tick), TEXT, Anchor::Start);
        }
        out.text([left + BAR, low - 10.0], values.name(&self.label), TEXT, Anchor::Middle);
    }
}

fn painted(share: f64) -> Color {
    viridis(share).map(|channel| channel.round() as u8)
}

/// Returns the different values of one coordinate, ascending.
fn different(points: &[[f64; 3]], axis: usize) -> Vec<f64> {
    let mut values: Vec<f64> = points.iter().map(|point| point[axis]).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// Returns the ends and the midpoints between values, the borders of their boxes.
fn borders(values: &[f64], is_logarithmic: bool) -> Vec<f64> {
    let scaled: Vec<f64> = values.iter().map(|&value| if is_logarithmic { value.ln() } else { value }).collect();
    let count = scaled.len();
    let mut borders: Vec<f64> = scaled.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
    borders.insert(0, 1.5 * scaled[0] - 0.5 * scaled[1]);
    borders.push(1.5 * scaled[count - 1] - 0.5 * scaled[count - 2]);
    borders.into_iter().map(|border| if is_logarithmic { border.exp() } else { border }).collect()
}

/// Returns the ends of values with a margin.
fn free(values: &[f64], is_logarithmic: bool) -> Vec<f64> {
    let scaled = |value: Option<&f64>| value.map_or(0.0, |&value| if is_logarithmic { value.ln() } else { value });
    let (low, high) = (scaled(values.first()), scaled(values.last()));
    let margin = FREE * (high - low);
    [low - margin, high + margin].map(|end| if is_logarithmic { end.exp() } else { end }).to_vec()
}

fn round(at: Point) -> Line {
    let corner = |k: usize| {
        let (sine, cosine) = (std::f64::consts::TAU * k as f64 / ROUND as f64).sin_cos();
        [at[0] + MARKER * cosine, at[1] + MARKER * sine]
    };
    Line::closed((0..ROUND).map(corner).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::super::drawing::svg;
    use super::*;

    fn response(points: Vec<[f64; 3]>, is_logarithmic: bool) -> String {
        let axis = |label: &str| PlotAxis { is_logarithmic, ..PlotAxis::new(label) };
        svg(&Response { title: "peak".into(), x: axis("gap"), y: axis("load"), label: "p".into(), points }.draw())
    }

    #[test]
    fn a_grid_is_boxes_and_samples_are_markers() {
        let grid = vec![[1.0, 1.0, 0.0], [2.0, 1.0, 1.0], [1.0, 3.0, 2.0], [2.0, 3.0, 3.0]];
        let boxes = response(grid.clone(), false);
        let scattered = response(grid[..3].to_vec(), false);
        assert!(boxes.contains("gap") && boxes.contains("load"));
        assert!(!boxes.contains("NaN") && !scattered.contains("NaN"));
        assert_ne!(boxes.matches("<path").count(), scattered.matches("<path").count());
        assert!(!response(grid, true).contains("NaN"));
    }

    #[test]
    fn each_value_has_its_interval() {
        assert_eq!(borders(&[1.0, 2.0, 4.0], false), [0.5, 1.5, 3.0, 5.0]);
        let factors = borders(&[1.0, 100.0], true);
        assert!(factors.iter().zip([0.1, 10.0, 1000.0]).all(|(border, expected)| (border / expected - 1.0).abs() < 1e-12));
    }
}
