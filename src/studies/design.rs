//! Varied parameters of a study, and the points that result.
//!
//! Rows of a file, listed values and samples are independent of each other: every combination is a point. Rows change slowest, then the
//! listed parameters in their order, samples fastest.

use std::path::Path;

use super::samples::Sampling;
use super::values::{Values, Varied, refusal};
use crate::machine::files;
use crate::output::csv_text;
use crate::script::Diagnostic;

/// Combination of the listed values of several parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pairing {
    /// All combinations of the values.
    #[default]
    Grid,
    /// Values at equal positions of the lists.
    Zip,
}

/// Points read from a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rows {
    /// Names of the parameters.
    pub names: Vec<String>,
    /// Values of each point.
    pub rows: Vec<Vec<String>>,
}

impl Rows {
    /// Reads a CSV file: a header with the names, and a row for each point.
    ///
    /// # Errors
    /// A file that cannot be read, has no rows, or rows of different lengths; a missing name or value.
    pub fn read(path: &Path) -> Result<Self, Box<Diagnostic>> {
        let refused = |cause: String| {
            let error = refusal(format!("the points in {} cannot be read", path.display())).cause(cause);
            Box::new(error.hint("a file of points is CSV: a first line with names of parameters, and a line with values for each point"))
        };
        let bytes = files::read(path).map_err(|error| refused(error.to_string()))?;
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(&bytes[..]);
        let names: Vec<String> =
            reader.headers().map_err(|error| refused(error.to_string()))?.iter().map(|name| csv_text(name).into()).collect();
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|error| refused(error.to_string()))?;
            let line = record.position().map_or(0, csv::Position::line);
            if record.iter().any(str::is_empty) {
                return Err(refused(format!("line {line}: a value is missing")));
            }
            rows.push(record.iter().map(|value| csv_text(value).into()).collect());
        }
        match (names.iter().any(String::is_empty), rows.is_empty()) {
            (true, _) => Err(refused("line 1: a name is missing".into())),
            (_, true) => Err(refused("there is no point in it".into())),
            _ => Ok(Rows { names, rows }),
        }
    }
}

/// Varied parameters of a study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Design {
    /// Points read from a file.
    pub rows: Option<Rows>,
    /// Varied parameters with their values.
    pub varied: Vec<Varied>,
    /// Combination of listed values.
    pub pairing: Pairing,
    /// Method of sampling of intervals.
    pub sampling: Option<Sampling>,
}

/// Largest number of points of a study.
const MOST: usize = 1_000_000;

impl Design {
    /// Returns the names of the parameters, and their values at every point.
    ///
    /// # Errors
    /// No varied parameter, a parameter or a point twice, an interval without sampling or sampling without intervals, lists of different
    /// lengths side by side, too many points.
    pub fn points(&self) -> Result<Rows, Box<Diagnostic>> {
        let mut points = self.rows.clone().unwrap_or_else(|| Rows { names: Vec::new(), rows: vec![Vec::new()] });
        for part in self.listed()?.into_iter().chain(self.sampled()?) {
            let count = points.rows.len().saturating_mul(part.rows.len());
            if count > MOST {
                return Err(Box::new(
                    refusal(format!("the study has {count} points, more than {MOST}")).hint("take fewer values, or sample them"),
                ));
            }
            let combined = points.rows.iter().flat_map(|before| part.rows.iter().map(move |after| [&before[..], &after[..]].concat()));
            points = Rows { rows: combined.collect(), names: [points.names.clone(), part.names].concat() };
        }
        if points.names.is_empty() {
            return Err(Box::new(refusal("nothing varies in this study").hint("name a parameter and its values: `--vary dt=0.01,0.005`")));
        }
        let mut names = points.names.clone();
        names.sort();
        if let Some(twice) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(Box::new(refusal(format!("the parameter `{}` varies twice", twice[0])).hint("give all its values at once")));
        }
        Ok(points)
    }

    fn listed(&self) -> Result<Vec<Rows>, Box<Diagnostic>> {
        let lists: Vec<(&String, &Vec<String>)> = self
            .varied
            .iter()
            .filter_map(|varied| match &varied.values {
                Values::Listed(values) => Some((&varied.name, values)),
                Values::Interval { .. } => None,
            })
            .collect();
        if self.pairing == Pairing::Grid || lists.is_empty() {
            let column = |(name, values): (&String, &Vec<String>)| Rows {
                names: vec![name.clone()],
                rows: values.iter().map(|value| vec![value.clone()]).collect(),
            };
            return Ok(lists.into_iter().map(column).collect());
        }
        let count = lists[0].1.len();
        if let Some((name, values)) = lists.iter().find(|(_, values)| values.len() != count) {
            let error = refusal("values side by side must be equally many");
            let error = error.cause(format!("`{}` has {count}, `{name}` has {}", lists[0].0, values.len()));
            return Err(Box::new(error.hint("give as many values to each, or leave `--zip` out for every combination")));
        }
        let rows = (0..count).map(|index| lists.iter().map(|(_, values)| values[index].clone()).collect()).collect();
        Ok(vec![Rows { names: lists.iter().map(|(name, _)| (*name).clone()).collect(), rows }])
    }

    fn sampled(&self) -> Result<Option<Rows>, Box<Diagnostic>> {
        let intervals: Vec<&Varied> = self.varied.iter().filter(|varied| matches!(varied.values, Values::Interval { .. })).collect();
        let sampling = match (intervals.first(), self.sampling) {
            (None, None) => return Ok(None),
            (Some(_), Some(sampling)) => sampling,
            (Some(first), None) => {
                let error = refusal(format!("`{}` is an interval, and nothing says which values of it to take", first.name));
                return Err(Box::new(error.hint("add a number of values, as in `0..1:11`, or sample it with `--sample sobol:64`")));
            }
            (None, Some(_)) => {
                let error = refusal("there is nothing to sample: no parameter varies in an interval");
                return Err(Box::new(error.hint("give the ends without a number of values, as in `--vary torque=0.05..0.2`")));
            }
        };
        let samples = sampling.draw(intervals.len()).map_err(|reason| Box::new(refusal(reason)))?;
        let row = |sample: &Vec<f64>| intervals.iter().zip(sample).map(|(varied, &share)| varied.values.at(share)).collect();
        Ok(Some(Rows { names: intervals.iter().map(|varied| varied.name.clone()).collect(), rows: samples.iter().map(row).collect() }))
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::SamplingMethod;
    use super::*;

    fn design(varied: &[&str]) -> Design {
        Design { varied: varied.iter().map(|text| text.parse().unwrap()).collect(), ..Design::default() }
    }

    #[test]
    fn every_combination_the_last_parameter_fastest() {
        let points = design(&["a=1,2", "b=x,y,z"]).points().unwrap();
        assert_eq!(points.names, ["a", "b"]);
        assert_eq!(points.rows, [["1", "x"], ["1", "y"], ["1", "z"], ["2", "x"], ["2", "y"], ["2", "z"]]);
    }

    #[test]
    fn side_by_side() {
        let zip = Design { pairing: Pairing::Zip, ..design(&["a=1,2", "b=x,y"]) };
        assert_eq!(zip.points().unwrap().rows, [["1", "x"], ["2", "y"]]);
        let uneven = Design { pairing: Pairing::Zip, ..design(&["a=1,2", "b=x"]) };
        assert!(uneven.points().unwrap_err().contains("`a` has 2, `b` has 1"));
    }

    #[test]
    fn samples_of_every_listed_value_and_row() {
        let sampling = Some(Sampling { method: SamplingMethod::Sobol, count: 8, seed: 1 });
        let rows = Some(Rows { names: vec!["kind".into()], rows: vec![vec!["soft".into()], vec!["hard".into()]] });
        let points = Design { sampling, rows, ..design(&["gap=0..0.5", "n=3,4"]) }.points().unwrap();
        assert_eq!((points.names, points.rows.len()), (vec!["kind".into(), "n".into(), "gap".into()], 32));
        // One sample lies in each eighth of the interval.
        let mut eighths: Vec<usize> = points.rows[..8].iter().map(|row| (row[2].parse::<f64>().unwrap() * 16.0) as usize).collect();
        eighths.sort_unstable();
        assert_eq!(eighths, [0, 1, 2, 3, 4, 5, 6, 7]);
    }

    #[test]
    fn what_makes_no_points_is_refused() {
        let sampling = Some(Sampling { method: SamplingMethod::Random, count: 2, seed: 1 });
        for (design, said) in [
            (Design::default(), "nothing varies"),
            (design(&["a=1,2", "a=3"]), "`a` varies twice"),
            (design(&["a=0..1"]), "`a` is an interval"),
            (Design { sampling, ..design(&["a=1,2"]) }, "nothing to sample"),
            (design(&["a=0..1:2000", "b=0..1:2000"]), "4000000 points"),
        ] {
            let error = design.points().unwrap_err();
            assert!(error.contains(said), "{error:?}");
        }
    }
}
