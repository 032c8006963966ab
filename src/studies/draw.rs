//! Pictures of a study: each result over the varied parameters.
//!
//! With one parameter a curve; with more parameters a family of curves if there are few, markers over each parameter if there are many; for
//! exactly two numbers the response as colors over both.

use crate::output::{Curve, CurveStyle, Drawing, Plot, PlotAxis, Response};

use super::table::{StudyColumn, StudyTable};

/// A picture of a study.
pub struct StudyPicture {
    /// Name of the file without extension.
    pub name: String,
    /// Title of the picture.
    pub title: String,
    /// Drawing of the picture.
    pub drawing: Drawing,
}

/// Largest number of curves of a family, the number of different colors.
const FAMILY: usize = 7;
/// Largest number of pictures; more results are only in the table.
const MOST: usize = 60;
/// Ratio of the largest to the smallest value above which an axis is logarithmic.
const WIDE: f64 = 30.0;

/// A column of numbers by its name.
struct Named<'a> {
    name: &'a str,
    /// Name with the unit.
    title: String,
    values: &'a [Option<f64>],
}

/// Pictures of all results that are numbers.
pub fn pictures(table: &StudyTable) -> Vec<StudyPicture> {
    let numbers = |column: &'_ StudyColumn| column.numbers().is_some();
    let parameters: Vec<&StudyColumn> = table.columns[table.parameters.clone()].iter().collect();
    let axes: Vec<usize> =
        (0..parameters.len()).filter(|&place| numbers(parameters[place]) && count_different(parameters[place]) > 1).collect();
    let mut all = Vec::new();
    for result in table.columns[table.results.clone()].iter() {
        let Some(values) = result.numbers().filter(|values| values.iter().flatten().any(|value| value.is_finite())) else { continue };
        let result = Named { name: result.name(), title: table.titled(result), values };
        if let Some(&first) = axes.iter().max_by_key(|&&axis| (count_different(parameters[axis]), std::cmp::Reverse(axis))) {
            match family(table, first, &result) {
                Some(curves) => all.push(curve_picture(table, parameters[first], &result, curves)),
                None => all.extend(axes.iter().map(|&axis| scatter(table, parameters[axis], &result))),
            }
        }
        if let ([a, b], 2) = (&axes[..], parameters.len()) {
            all.extend(response(table, [parameters[*a], parameters[*b]], &result));
        }
    }
    all.truncate(MOST);
    all
}

fn count_different(column: &StudyColumn) -> usize {
    let mut words: Vec<String> = (0..column.numbers().map_or(0, <[_]>::len)).map(|row| column.cell(row)).collect();
    words.sort();
    words.dedup();
    words.len()
}

/// Returns a curve over one parameter for each combination of the others; `None` if there are too many combinations.
fn family(table: &StudyTable, axis: usize, result: &Named) -> Option<Vec<Curve>> {
    let parameters = &table.columns[table.parameters.clone()];
    let xs = parameters[axis].numbers()?;
    // Each curve with its first row.
    let mut curves: Vec<(usize, Vec<[f64; 2]>)> = Vec::new();
    let others = || parameters.iter().enumerate().filter(|(place, _)| *place != axis).map(|(_, column)| column);
    for (row, (x, y)) in xs.iter().zip(result.values).enumerate() {
        let (Some(x), Some(y)) = (*x, *y) else { continue };
        match curves.iter().position(|&(first, _)| others().all(|column| column.cell(first) == column.cell(row))) {
            Some(place) => curves[place].1.push([x, y]),
            None if curves.len() == FAMILY => return None,
            None => curves.push((row, vec![[x, y]])),
        }
    }
    let is_family = curves.iter().any(|(_, points)| points.len() > 1);
    let curve = |(row, mut points): (usize, Vec<[f64; 2]>)| {
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let label = others().map(|column| table.assigned(column, row)).collect::<Vec<_>>().join(", ");
        let label = if label.is_empty() { result.name.to_string() } else { label };
        Curve {
            label,
            x: points.iter().map(|point| point[0]).collect(),
            y: points.iter().map(|point| point[1]).collect(),
            ..Curve::default()
        }
    };
    is_family.then(|| curves.into_iter().map(curve).collect())
}

fn curve_picture(table: &StudyTable, parameter: &StudyColumn, result: &Named, curves: Vec<Curve>) -> StudyPicture {
    let title = format!("{} over {}", result.name, parameter.name());
    // Lines with markers, so that computed points are visible.
    let markers = curves.iter().map(|curve| Curve { style: CurveStyle::Points, label: String::new(), ..curve.clone() }).collect::<Vec<_>>();
    let plot = Plot {
        x: axis(&table.titled(parameter), parameter.numbers().unwrap_or_default()),
        y: axis(&result.title, result.values),
        ..Plot::default()
    };
    let is_few = curves.len() == 1;
    let plot = Plot { title: title.clone(), curves: if is_few { [curves, markers].concat() } else { curves }, ..plot };
    StudyPicture { name: file_name(&title), title, drawing: plot.draw() }
}

fn scatter(table: &StudyTable, parameter: &StudyColumn, result: &Named) -> StudyPicture {
    let xs = parameter.numbers().unwrap_or_default();
    let known: Vec<[f64; 2]> = xs.iter().zip(result.values).filter_map(|(x, y)| Some([(*x)?, (*y)?])).collect();
    let title = format!("{} over {}", result.name, parameter.name());
    let curve = Curve {
        label: result.name.into(),
        x: known.iter().map(|point| point[0]).collect(),
        y: known.iter().map(|point| point[1]).collect(),
        style: CurveStyle::Points,
        ..Curve::default()
    };
    let plot = Plot {
        title: title.clone(),
        x: axis(&table.titled(parameter), xs),
        y: axis(&result.title, result.values),
        curves: vec![curve],
        ..Plot::default()
    };
    StudyPicture { name: file_name(&title), title, drawing: plot.draw() }
}

fn response(table: &StudyTable, [a, b]: [&StudyColumn; 2], result: &Named) -> Option<StudyPicture> {
    let (xs, ys) = (a.numbers()?, b.numbers()?);
    let points = xs
        .iter()
        .zip(ys)
        .zip(result.values)
        .filter_map(|((x, y), value)| Some([(*x)?, (*y)?, (*value).filter(|value| value.is_finite())?]));
    let points: Vec<[f64; 3]> = points.collect();
    if points.len() < 3 {
        return None;
    }
    let title = format!("{} over {} and {}", result.name, a.name(), b.name());
    let (x, y) = (axis(&table.titled(a), xs), axis(&table.titled(b), ys));
    let drawing = Response { title: title.clone(), x, y, label: result.title.clone(), points }.draw();
    Some(StudyPicture { name: file_name(&title), title, drawing })
}

/// Returns an axis, logarithmic if the values differ by orders of magnitude.
fn axis(name: &str, values: &[Option<f64>]) -> PlotAxis {
    let finite = || values.iter().flatten().copied().filter(|value| value.is_finite());
    let (low, high) = finite().fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
    PlotAxis { is_logarithmic: low > 0.0 && high >= WIDE * low, ..PlotAxis::new(name) }
}

/// Converts a title into a file name.
fn file_name(title: &str) -> String {
    let plain = |sign: char| if sign.is_alphanumeric() || "-+.".contains(sign) { sign } else { '_' };
    title.chars().take(100).map(plain).collect::<String>().trim_matches(['_', '.']).into()
}
