//! Histories as a picture: curves over time, above all the energies (Fig. 2 of Hesch & Betsch 2007).
//!
//! Drawn with `plotters` (small, text stays text, any look) rather than `kuva`, whose picture is no better and which takes 15 times as long
//! to compile. Plotters rounds to whole units, so the drawing is made ten times as large as it is shown. A long history is thinned to the
//! first, lowest, highest and last value per column of the picture, which looks the same. Values that are not finite leave a gap.

use std::error::Error;

use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::axis::Axis;
use crate::dynamics::LedgerRow;

/// Size as shown, in pixels.
const SIZE: [i32; 2] = [720, 420];
/// Units of the drawing per pixel.
const UNIT: i32 = 10;
/// Okabe & Ito (2008): told apart by readers with any color vision.
const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(120, 120, 120),
];
const GRID: RGBColor = RGBColor(226, 226, 226);

/// One curve.
struct Curve<'a> {
    name: &'a str,
    values: &'a [f64],
    color: RGBColor,
    width: f64,
}

/// Kinetic, strain, potential (where there is any) and total energy over time as SVG.
pub fn energies(title: &str, rows: &[LedgerRow]) -> String {
    let column = |value: fn(&LedgerRow) -> f64| rows.iter().map(value).collect::<Vec<f64>>();
    let time = column(|row| row.time);
    let values = [column(|row| row.kinetic), column(|row| row.strain), column(|row| row.potential), column(LedgerRow::total)];
    let looks = [("kinetic", COLORS[0], 1.8), ("strain", COLORS[1], 1.8), ("potential", COLORS[2], 1.8), ("total", BLACK, 2.2)];
    let curves: Vec<Curve> = looks
        .into_iter()
        .zip(&values)
        .filter(|((name, ..), values)| *name != "potential" || values.iter().any(|&value| value != 0.0))
        .map(|((name, color, width), values)| Curve { name, values, color, width })
        .collect();
    // Zero belongs to the picture: shares of the total are read off it.
    draw(title, ["time", "energy"], &time, &curves, Some(0.0))
}

/// Columns over time as SVG, with a legend; `labels` are those of the two axes. The total energy looks as in [`energies`].
pub fn plot(title: &str, labels: [&str; 2], time: &[f64], columns: &[(&str, &[f64])]) -> String {
    let looks = |name: &str, color| if name == "total" { (BLACK, 2.2) } else { (color, 1.8) };
    let curve = |(&(name, values), &color)| {
        let (color, width) = looks(name, color);
        Curve { name, values, color, width }
    };
    let curves: Vec<Curve> = columns.iter().zip(COLORS.iter().cycle()).map(curve).collect();
    draw(title, labels, time, &curves, None)
}

impl Ranged for Axis {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let share = (value - self.low) / (self.high - self.low);
        limit.0 + (share * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.low..self.high
    }
}

fn draw(title: &str, labels: [&str; 2], time: &[f64], curves: &[Curve], included: Option<f64>) -> String {
    let mut text = String::new();
    let drawn = draw_into(&mut text, title, labels, time, curves, included);
    debug_assert!(drawn.is_ok(), "drawing into memory: {drawn:?}");
    // Shown at a tenth of the size it was drawn at.
    let [width, height] = SIZE;
    text.replacen(&format!("width=\"{}\" height=\"{}\"", width * UNIT, height * UNIT), &format!("width=\"{width}\" height=\"{height}\""), 1)
}

fn font(size: f64) -> TextStyle<'static> {
    ("sans-serif", size * f64::from(UNIT)).into_text_style(&(1, 1)).color(&RGBColor(34, 34, 34))
}

fn pixels(count: f64) -> i32 {
    (count * f64::from(UNIT)).round() as i32
}

fn draw_into(
    out: &mut String,
    title: &str,
    labels: [&str; 2],
    time: &[f64],
    curves: &[Curve],
    included: Option<f64>,
) -> Result<(), Box<dyn Error>> {
    let [width, height] = SIZE;
    let root = SVGBackend::with_string(out, ((width * UNIT) as u32, (height * UNIT) as u32)).into_drawing_area();
    root.fill(&WHITE)?;

    let x_axis = Axis::over(time.iter().copied(), 10);
    let y_axis = Axis::over(curves.iter().flat_map(|curve| curve.values.iter().copied()).chain(included), 6).widened(0.04);
    let widest = y_axis.ticks.iter().map(|&tick| y_axis.label(tick).chars().count()).max().unwrap_or(1);
    // Plotters knows no font, and nor do we: 0.55 em is a generous mean width of letters and digits.
    let label_width = widest as f64 * 0.55 * 14.0 + 40.0;

    // Title, and the legend below it in as many rows as it needs: it never hides a curve.
    let left = label_width + 8.0;
    if !title.is_empty() {
        root.draw_text(title, &font(20.0).pos(Pos::new(HPos::Left, VPos::Center)), (pixels(left), pixels(20.0)))?;
    }
    let (mut x, mut y) = (left, if title.is_empty() { 18.0 } else { 46.0 });
    for curve in curves {
        let length = 38.0 + 0.55 * 16.0 * curve.name.chars().count() as f64;
        if x > left && x + length > f64::from(width) {
            (x, y) = (left, y + 20.0);
        }
        let style = curve.color.stroke_width(pixels(curve.width) as u32);
        root.draw(&PathElement::new([(pixels(x), pixels(y)), (pixels(x + 22.0), pixels(y))], style))?;
        root.draw_text(curve.name, &font(17.0).pos(Pos::new(HPos::Left, VPos::Center)), (pixels(x + 28.0), pixels(y)))?;
        x += length + 14.0;
    }

    let mut chart = ChartBuilder::on(&root)
        .margin_left(pixels(8.0))
        .margin_right(pixels(20.0))
        .margin_bottom(pixels(8.0))
        .margin_top(pixels(y + 16.0))
        .x_label_area_size(pixels(46.0))
        .y_label_area_size(pixels(label_width))
        .build_cartesian_2d(x_axis.clone(), y_axis.clone())?;
    chart
        .configure_mesh()
        .bold_line_style(GRID.stroke_width(pixels(1.0) as u32))
        .light_line_style(TRANSPARENT)
        .axis_style(RGBColor(34, 34, 34).stroke_width(pixels(1.0) as u32))
        .set_all_tick_mark_size(pixels(5.0))
        .label_style(font(17.0))
        .axis_desc_style(font(18.0))
        .x_label_formatter(&|&tick| x_axis.label(tick))
        .y_label_formatter(&|&tick| y_axis.label(tick))
        .x_desc(x_axis.name(labels[0]))
        .y_desc(y_axis.name(labels[1]))
        .draw()?;

    let columns = chart.plotting_area().dim_in_pixel().0 as f64 / f64::from(UNIT);
    let column = |x: f64| ((x - x_axis.low) / (x_axis.high - x_axis.low) * columns) as i64;
    for curve in curves {
        let style = curve.color.stroke_width(pixels(curve.width) as u32);
        let points: Vec<_> = time.iter().zip(curve.values).map(|(&x, &y)| (x_axis.scaled(x), y_axis.scaled(y))).collect();
        for run in points.split(|(x, y)| !(x.is_finite() && y.is_finite())).filter(|run| !run.is_empty()) {
            if let [point] = run {
                chart.draw_series([Circle::new(*point, pixels(curve.width), curve.color.filled())])?;
            } else {
                chart.draw_series(LineSeries::new(thinned(run, column), style))?;
            }
        }
    }
    root.present()?;
    Ok(())
}

/// The first, lowest, highest and last point of every stretch that falls into one column, in their order.
fn thinned(points: &[(f64, f64)], column: impl Fn(f64) -> i64) -> Vec<(f64, f64)> {
    let mut kept = Vec::new();
    for stretch in points.chunk_by(|a, b| column(a.0) == column(b.0)) {
        let extreme = |sign: f64| (0..stretch.len()).max_by(|&a, &b| (sign * stretch[a].1).total_cmp(&(sign * stretch[b].1))).unwrap_or(0);
        let mut chosen = [0, extreme(-1.0), extreme(1.0), stretch.len() - 1];
        chosen.sort_unstable();
        kept.extend(chosen.iter().enumerate().filter(|&(at, index)| at == 0 || chosen[at - 1] != *index).map(|(_, &index)| stretch[index]));
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::super::samples::{rows, well_formed};
    use super::*;

    fn polylines(svg: &str) -> Vec<Vec<[i32; 2]>> {
        let points = |line: &str| {
            let list = line.split("points=\"").nth(1).and_then(|rest| rest.split('"').next()).unwrap();
            list.split_whitespace()
                .map(|pair| {
                    let (x, y) = pair.split_once(',').unwrap();
                    [x.parse().unwrap(), y.parse().unwrap()]
                })
                .collect()
        };
        svg.lines().filter(|line| line.contains("<polyline")).map(points).collect()
    }

    #[test]
    fn the_total_energy_is_black_in_every_picture() {
        let time = [0.0, 1.0];
        let black = |name| plot("", ["time", ""], &time, &[("strain", &[0.0, 1.0]), (name, &[1.0, 1.0])]).contains("stroke=\"#000000\"");
        assert!(black("total") && !black("kinetic"));
    }

    #[test]
    fn energies_are_named_and_potential_only_where_there_is_some() {
        let mut rows = rows();
        let svg = energies("the bearing", &rows);
        well_formed(&svg);
        for text in ["the bearing", "kinetic", "strain", "total", "time", "energy"] {
            assert!(svg.contains(&format!("\n{text}\n")), "{text} is text");
        }
        assert!(!svg.contains("potential") && svg.contains("width=\"720\" height=\"420\" viewBox=\"0 0 7200 4200\""));
        rows[7].potential = -0.01;
        assert!(energies("the bearing", &rows).contains("\npotential\n"));
    }

    #[test]
    fn curves_have_the_values_heights() {
        let time: Vec<f64> = (0..=10).map(f64::from).collect();
        let values: Vec<f64> = time.iter().map(|t| t * t).collect();
        let svg = plot("", ["t", "x"], &time, &[("square", &values)]);
        let curve = polylines(&svg).into_iter().find(|points| points.len() == 11).unwrap();
        let place = |index: usize, d: usize| f64::from(curve[index][d]);
        for (index, value) in values.iter().enumerate() {
            let share = (place(0, 1) - place(index, 1)) / (place(0, 1) - place(10, 1));
            // Half a unit of rounding on a height of about 3000.
            assert!((share - value / 100.0).abs() < 1e-3, "{share} for {value}");
            assert!((place(index, 0) - place(0, 0) - index as f64 / 10.0 * (place(10, 0) - place(0, 0))).abs() <= 1.0);
        }
    }

    #[test]
    fn odd_histories_make_a_picture_all_the_same() {
        let time: Vec<f64> = (0..100).map(f64::from).collect();
        let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308, -1e308, 0.0, 5e-324];
        let mixed: Vec<f64> = (0..100).map(|index| odd[index % odd.len()]).collect();
        for values in [vec![], vec![1.0], vec![3.25; 100], vec![0.0; 100], vec![f64::NAN; 100], mixed] {
            let svg = plot("odd", ["time", "value"], &time, &[("x", &values)]);
            well_formed(&svg);
            assert!(polylines(&svg).concat().iter().all(|&[x, y]| (0..7200).contains(&x) && (0..4200).contains(&y)), "{values:?}");
        }
        well_formed(&plot("", ["", ""], &[], &[]));
        well_formed(&energies("<&>\"", &[]));
    }

    #[test]
    fn a_value_that_is_none_leaves_a_gap() {
        let time: Vec<f64> = (0..9).map(f64::from).collect();
        let svg = plot("", ["t", "x"], &time, &[("x", &[1.0, 2.0, 3.0, f64::NAN, 5.0, f64::NAN, 1.0, 2.0, 3.0])]);
        let counts = well_formed(&svg);
        assert_eq!(polylines(&svg).iter().filter(|points| points.len() == 3).count(), 2);
        assert_eq!(counts["circle"], 1, "the lonely value is a dot");
    }

    #[test]
    fn a_long_history_is_thinned_without_losing_a_spike() {
        let count = 100_000;
        let time: Vec<f64> = (0..count).map(|i| i as f64 / count as f64).collect();
        let mut values: Vec<f64> = time.iter().map(|t| (500.0 * t).sin()).collect();
        values[31_416] = 40.0;
        values[77_777] = -40.0;
        let svg = plot("long", ["time", "value"], &time, &[("x", &values)]);
        assert!(svg.len() < 60_000, "{} bytes", svg.len());
        let points: Vec<(f64, f64)> = time.iter().copied().zip(values.iter().copied()).collect();
        let few = thinned(&points, |x| (x * 620.0) as i64);
        assert!(few.len() <= 4 * 620 && few.is_sorted_by(|a, b| a.0 < b.0));
        assert!(few.contains(&points[31_416]) && few.contains(&points[77_777]) && few.last() == points.last());
        assert_eq!(thinned(&points[..50], |x| (x * 1e9) as i64), points[..50], "a short history is kept as it is");
    }
}
