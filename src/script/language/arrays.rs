//! Arguments that are arrays: vectors, numbers, points and counts.

use rhai::{Array, Dynamic};

use super::arguments::Argument;
use super::causes;
use super::digits::number_text;
use super::failure::Failure;
use super::values::{as_number, as_whole, describe};

impl Argument<'_> {
    /// Array of `dimension` numbers, padded with zeros to three.
    ///
    /// # Errors
    /// Not an array, not of that length, or not of finite numbers.
    pub fn vector(&self, dimension: usize) -> Result<[f64; 3], Failure> {
        let mut vector = [0.0; 3];
        vector[..dimension].copy_from_slice(&self.numbers_of(dimension)?);
        Ok(vector)
    }

    /// An array of `count` finite numbers.
    ///
    /// # Errors
    /// Not an array, not of that length, or not of finite numbers in range.
    pub fn numbers_of(&self, count: usize) -> Result<Vec<f64>, Failure> {
        let numbers = self.numbers()?;
        if numbers.len() == count {
            return Ok(numbers);
        }
        let failure = self.wrong(causes::COUNT, format!("must have {count} components")).label(format!("this has {}", numbers.len()));
        let failure = failure.cause(format!("`{}` is {}", self.parameter.name, self.parameter.summary));
        Err(failure.hint(if count == 2 { "write `[x, y]`" } else { "write `[x, y, z]`" }))
    }

    /// An array of `N` finite numbers.
    ///
    /// # Errors
    /// Not an array, not of that length, or not of finite numbers in range.
    pub fn tuple<const N: usize>(&self) -> Result<[f64; N], Failure> {
        let numbers = self.numbers_of(N)?;
        Ok(std::array::from_fn(|i| numbers[i]))
    }

    /// An array of finite numbers, of any length.
    ///
    /// # Errors
    /// Not an array, or not of finite numbers in range.
    pub fn numbers(&self) -> Result<Vec<f64>, Failure> {
        let array = self.array()?;
        let numbers: Option<Vec<f64>> = array.iter().map(as_number).collect();
        let numbers = numbers.ok_or_else(|| {
            let wrong = array.iter().find(|value| as_number(value).is_none());
            let what = wrong.map_or(String::new(), |value| describe(self.call.engine(), value));
            self.wrong(causes::WRONG_TYPE, "must be an array of numbers").label(format!("this contains {what}"))
        })?;
        match numbers.iter().find(|number| !self.parameter.range.contains(**number)) {
            Some(wrong) => Err(self
                .refuse(causes::OUT_OF_RANGE, format!("every entry of {} must be {}", self.title(), self.parameter.range))
                .label(format!("this contains {}", number_text(*wrong)))
                .cause(format!("`{}` is {}", self.parameter.name, self.parameter.summary))),
            None => Ok(numbers),
        }
    }

    /// Array of points `[x, y]`, in space `[x, y, z]`.
    ///
    /// # Errors
    /// Not an array, or not of as many finite numbers.
    pub fn points<const D: usize>(&self) -> Result<Vec<[f64; D]>, Failure> {
        self.points_in(&self.array()?)
    }

    /// An array of arrays of points `[x, y]`.
    ///
    /// # Errors
    /// Anything else.
    pub fn lists_of_points(&self) -> Result<Vec<Vec<[f64; 2]>>, Failure> {
        let list = |entry: &Dynamic| {
            let points = entry.read_lock::<Array>().map(|points| self.points_in(&points));
            let hint = "write `[[[0.2, 0.2], [0.4, 0.2], [0.3, 0.4]]]`: an array for each";
            points.unwrap_or_else(|| {
                Err(self.refuse(causes::WRONG_TYPE, format!("every entry of {} must be an array of points", self.title())).hint(hint))
            })
        };
        self.array()?.iter().map(list).collect()
    }

    fn points_in<const D: usize>(&self, entries: &[Dynamic]) -> Result<Vec<[f64; D]>, Failure> {
        let point = |entry: &Dynamic| -> Option<[f64; D]> {
            let numbers: Vec<f64> = entry.read_lock::<Array>()?.iter().map(as_number).collect::<Option<_>>()?;
            <[f64; D]>::try_from(numbers).ok().filter(|point| point.iter().all(|x| x.is_finite()))
        };
        let points: Option<Vec<[f64; D]>> = entries.iter().map(point).collect();
        points.ok_or_else(|| {
            let wrong = entries.iter().find(|entry| point(entry).is_none());
            let given = wrong.map_or(String::new(), |value| describe(self.call.engine(), value));
            let (form, example) = match D {
                2 => ("[x, y]", "[[1.0, 0.0], [0.0, 0.0]]"),
                _ => ("[x, y, z]", "[[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]"),
            };
            let failure = self.refuse(causes::WRONG_TYPE, format!("every entry of {} must be a point `{form}`", self.title()));
            failure.label(format!("this contains {given}")).hint(format!("write `{example}`"))
        })
    }

    /// An array of `N` positive whole numbers.
    ///
    /// # Errors
    /// Anything else.
    pub fn counts<const N: usize>(&self) -> Result<[usize; N], Failure> {
        let array = self.array()?;
        let whole: Option<Vec<i64>> = array.iter().map(as_whole).collect();
        let whole = whole.ok_or_else(|| {
            let wrong = array.iter().find(|value| as_whole(value).is_none());
            let given = wrong.map_or(String::new(), |value| describe(self.call.engine(), value));
            let failure = self.wrong(causes::WRONG_TYPE, "must be an array of whole numbers").label(format!("this contains {given}"));
            let failure = failure.cause(format!("`{}` is {}", self.parameter.name, self.parameter.summary));
            failure.hint("write whole numbers, such as `[10, 40]`; `x.to_int()` drops a fraction")
        })?;
        let Ok(counts) = <[i64; N]>::try_from(&whole[..]) else {
            return Err(self
                .wrong(causes::COUNT, format!("must have {N} entries"))
                .label(format!("this has {}", whole.len()))
                .cause(format!("`{}` is {}", self.parameter.name, self.parameter.summary)));
        };
        match whole.iter().find(|value| **value < 1) {
            Some(wrong) => Err(self
                .refuse(causes::OUT_OF_RANGE, format!("every entry of {} must be 1 or greater", self.title()))
                .label(format!("this contains {wrong}"))
                .cause(format!("`{}` is {}", self.parameter.name, self.parameter.summary))),
            None => Ok(counts.map(|value| value as usize)),
        }
    }

    /// An array.
    ///
    /// # Errors
    /// Another type.
    pub fn array(&self) -> Result<Array, Failure> {
        self.value.as_ref().and_then(|value| value.read_lock::<Array>().map(|array| array.clone())).ok_or_else(|| self.wrong_type())
    }
}
