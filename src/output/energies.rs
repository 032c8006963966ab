//! Energies of a run over time (Fig. 2 of Hesch & Betsch 2007).
//!
//! The zero of a potential energy is arbitrary. If it would flatten the curves, as gravity does far above its origin, the potential and the
//! total are drawn relative to the potential's lowest value, which the legend states.

use super::plot::{Curve, Plot, PlotAxis};
use crate::dynamics::{LedgerRow, Rows};

/// Names of the energy columns of a history.
pub const ENERGIES: [&str; 4] = ["kinetic", "strain", "potential", "total"];

/// Plot of kinetic, strain, potential (if any) and total energy over time.
pub fn energies<R: Rows + ?Sized>(title: &str, rows: &R) -> Plot {
    let points = points(rows, MOST_POINTS);
    let column = |place: usize| points.iter().map(|point| point[place]).collect::<Vec<f64>>();
    let time = column(0);
    let values = [column(1), column(2), column(3), column(4)];
    let curve = |(name, y): (&str, Vec<f64>)| Curve { label: name.into(), x: time.clone(), y, is_sum: name == "total", ..Curve::default() };
    let curves = ENERGIES.into_iter().zip(values).filter(|(name, values)| *name != "potential" || values.iter().any(|&value| value != 0.0));
    let mut curves: Vec<Curve> = curves.map(curve).collect();
    above_lowest_potential(&mut curves);
    // The axis includes zero, so that fractions of the total can be read off.
    let y = PlotAxis { included: Some(0.0), ..PlotAxis::new("energy") };
    Plot { title: title.into(), x: PlotAxis::new("time"), y, curves, ..Plot::default() }
}

/// Largest number of rows that are drawn one by one; longer runs are drawn by the extrema of intervals.
const MOST_POINTS: usize = 100_000;
/// Number of intervals of longer runs.
const STRETCHES: usize = 5_000;

/// Returns times and energies of all rows; of a long run, only the rows with the extrema of each energy in each interval.
fn points<R: Rows + ?Sized>(rows: &R, most: usize) -> Vec<[f64; 5]> {
    let point = |row: &LedgerRow| [row.time, row.kinetic, row.strain, row.potential, row.total()];
    let mut points = Vec::new();
    if rows.count() <= most {
        rows.visit(0, &mut |row| points.push(point(row)));
        return points;
    }
    let length = rows.count().div_ceil(STRETCHES);
    let mut stretch = Vec::with_capacity(length);
    let mut end = |stretch: &mut Vec<[f64; 5]>| {
        let places = || 0..stretch.len();
        let extrema = |energy: usize| {
            let value = |place: &usize| stretch[*place][energy];
            let by = |a: &usize, b: &usize| value(a).total_cmp(&value(b));
            [places().min_by(by), places().max_by(by)]
        };
        let mut kept: Vec<usize> = (1..5).flat_map(extrema).flatten().chain([0]).collect();
        kept.sort_unstable();
        kept.dedup();
        points.extend(kept.iter().filter_map(|&place| stretch.get(place)));
        stretch.clear();
    };
    rows.visit(0, &mut |row| {
        stretch.push(point(row));
        if stretch.len() == length {
            end(&mut stretch);
        }
    });
    end(&mut stretch);
    points.extend(rows.last_row().as_ref().map(point));
    points
}

/// Subtracts the lowest potential from the curves `potential` and `total` if it would take more than half of the height.
pub fn above_lowest_potential(curves: &mut [Curve]) {
    let Some(potential) = curves.iter().find(|curve| curve.label == "potential") else { return };
    let bounds = |curves: &mut dyn Iterator<Item = f64>| {
        curves.filter(|value| value.is_finite()).fold([0.0_f64; 2], |[low, high], value| [low.min(value), high.max(value)])
    };
    let lowest = potential.y.iter().copied().filter(|value| value.is_finite()).fold(f64::INFINITY, f64::min);
    let is_shifted = |curve: &Curve| matches!(curve.label.as_str(), "potential" | "total");
    let height = |offset: f64| {
        let values = |curve: &Curve| {
            let offset = if is_shifted(curve) { offset } else { 0.0 };
            curve.y.iter().map(move |value| value - offset).collect::<Vec<_>>()
        };
        let [low, high] = bounds(&mut curves.iter().flat_map(values));
        high - low
    };
    if !lowest.is_finite() || 2.0 * height(lowest) >= height(0.0) {
        return;
    }
    let number = format!("{:.3e}", lowest.abs());
    let number = if (0.01..1e4).contains(&lowest.abs()) { format!("{}", (lowest.abs() * 100.0).round() / 100.0) } else { number };
    let sign = if lowest < 0.0 { '+' } else { '\u{2212}' };
    for curve in curves.iter_mut().filter(|curve| is_shifted(curve)) {
        curve.y.iter_mut().for_each(|value| *value -= lowest);
        curve.label = format!("{} {sign} {number}", curve.label);
    }
}

#[cfg(test)]
mod tests {
    use super::super::drawing::svg;
    use super::super::samples::{rows, well_formed};
    use super::*;

    #[test]
    fn energies_are_named_and_potential_only_where_there_is_some() {
        let mut rows = rows();
        let text = svg(&energies("the bearing", &rows).draw());
        well_formed(&text);
        for words in ["the bearing", "kinetic", "strain", "total", "time", "energy"] {
            assert!(text.contains(&format!(">{words}</text>")), "{words} is text");
        }
        assert!(!text.contains("potential") && text.contains("width=\"720\" height=\"420\" viewBox=\"0 0 7200 4200\""));
        assert!(text.contains("stroke=\"#000000\""), "the total is black");
        rows[7].potential = -0.01;
        assert!(svg(&energies("the bearing", &rows).draw()).contains(">potential</text>"));
        well_formed(&svg(&energies::<[LedgerRow]>("<&>\"", &[]).draw()));
    }

    #[test]
    fn a_long_run_is_drawn_by_its_extrema() {
        let mut rows: Vec<LedgerRow> = (0..20_000).map(|step| LedgerRow { time: step as f64, ..LedgerRow::default() }).collect();
        (rows[777].kinetic, rows[12_345].strain, rows[12_346].potential) = (3.0, 2.0, -1.0);
        let points = points(&rows, 1000);
        assert!(points.len() <= 10_010 && points[0][0] == 0.0 && points[points.len() - 1][0] == 19_999.0);
        for (place, value) in [(777, 3.0), (12_345, 2.0), (12_346, -1.0)] {
            assert!(points.iter().any(|point| point[0] == f64::from(place) && point[4] == value), "{place}");
        }
        assert!(points.windows(2).all(|pair| pair[0][0] <= pair[1][0]));
    }

    #[test]
    fn a_constant_potential_does_not_hide_the_kinetic_energy() {
        let mut rows = rows();
        rows.iter_mut().for_each(|row| row.potential = -98.1);
        let plot = energies("falling", &rows);
        let labels: Vec<&str> = plot.curves.iter().map(|curve| curve.label.as_str()).collect();
        assert_eq!(labels, ["kinetic", "strain", "potential + 98.1", "total + 98.1"]);
        assert!(plot.curves[3].y.iter().all(|value| value.abs() < 1.0));
        // A potential that is exchanged with the kinetic energy is not shifted.
        rows.iter_mut().for_each(|row| row.potential = 0.05 - row.kinetic);
        assert_eq!(energies("falling", &rows).curves[2].label, "potential");
    }
}
