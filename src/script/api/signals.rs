//! Curves as arrays of numbers: places of extremes, differences, sums, integrals, interpolation, percentiles, spectra and filters.

use rhai::EvalAltResult;

use super::arrays::{numbers, numbers_of};
use crate::math::signals::{channel_filter, fourier, interpolated, percentile};
use crate::script::language::digits::{brief, number_text};
use crate::script::language::prelude::*;
use crate::script::language::values::as_number;

type Value = Result<Dynamic, Box<EvalAltResult>>;

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![argmax("argmax", 1.0), argmax("argmin", -1.0), diff(), cumsum(), integrate(), interpolate(), percentiles(), fft(), cfc_filter()]
}

fn of_array(
    name: &'static str,
    summary: &'static str,
    further: Vec<Parameter>,
    returns: &'static str,
    example: &'static str,
    compute: impl Fn(&Call, Array) -> Value + 'static,
) -> Function {
    let values = Parameter::array("values", "the numbers");
    function(Topic::Arrays, name)
        .summary(summary)
        .parameters([values].into_iter().chain(further).collect())
        .returns(returns)
        .see_also(&["max", "diff", "cumsum", "integrate", "interpolate", "percentile", "fft", "cfc_filter"])
        .example(example)
        .body(move |call| compute(call, numbers_of(call, "values")?))
}

/// Argument that is an array of numbers.
fn array(call: &Call, name: &str) -> Result<Vec<f64>, Box<EvalAltResult>> {
    Ok(numbers(&numbers_of(call, name)?).collect())
}

/// The failure of an array that is too short.
fn too_short(call: &Call, least: &str) -> Box<EvalAltResult> {
    call.argument("values").refuse(causes::COUNT, format!("{} needs {least}", call.function.title())).into()
}

fn array_of(values: impl IntoIterator<Item = f64>) -> Array {
    values.into_iter().map(Dynamic::from).collect()
}

fn argmax(name: &'static str, sign: f64) -> Function {
    let (summary, example) = match name {
        "argmax" => (
            "the place of the largest entry of an array, the first of equal ones, counted from 0; NaN left out",
            "let force = [0.0, 3.0, 1.0];\nlet time = [0.0, 0.1, 0.2];\nprint(time[argmax(force)]);",
        ),
        _ => (
            "the place of the least entry of an array, the first of equal ones, counted from 0; NaN left out",
            "print([2.0, -3.0, 1.0].argmin());",
        ),
    };
    of_array(name, summary, Vec::new(), "int", example, move |call, values| {
        let known = numbers(&values).enumerate().filter(|(_, x)| !x.is_nan());
        let best = known.reduce(|best, next| if sign * next.1 > sign * best.1 { next } else { best });
        best.map(|(place, _)| Dynamic::from(place as i64)).ok_or_else(|| too_short(call, "at least one number"))
    })
}

fn diff() -> Function {
    let summary = "the differences of neighboring entries, one less than there are entries: `diff(y) / diff(x)` is the slope of a curve";
    of_array("diff", summary, Vec::new(), "Array", "print(diff([1.0, 4.0, 9.0])); // [3.0, 5.0]", |_, values| {
        let values: Vec<f64> = numbers(&values).collect();
        Ok(array_of(values.windows(2).map(|ends| ends[1] - ends[0])).into())
    })
}

fn cumsum() -> Function {
    of_array("cumsum", "the sums of an array up to each entry", Vec::new(), "Array", "print(cumsum([1.0, 2.0, 3.0]));", |_, values| {
        let sums = numbers(&values).scan(0.0, |sum, x| {
            *sum += x;
            Some(*sum)
        });
        Ok(array_of(sums).into())
    })
}

fn integrate() -> Function {
    let x = Parameter::new("x", Kind::Either("an array of numbers or a number"), "where the values are, or their equal distance");
    of_array(
        "integrate",
        "the integral of a curve by the trapezoidal rule",
        vec![x],
        "float",
        "let t = linspace(0.0, PI, 1001);\nprint(fmt(integrate(sin(t), t), 4)); // 2.000",
        |call, values| {
            let (values, argument) = (numbers(&values).collect::<Vec<f64>>(), call.argument("x"));
            if let Some(step) = as_number(&argument.value()) {
                return Ok((step * values.windows(2).map(|ends| 0.5 * (ends[0] + ends[1])).sum::<f64>()).into());
            }
            let x = array(call, "x")?;
            same_length(call, &values, &x)?;
            Ok(values.windows(2).zip(x.windows(2)).map(|(y, x)| 0.5 * (y[0] + y[1]) * (x[1] - x[0])).sum::<f64>().into())
        },
    )
}

fn same_length(call: &Call, values: &[f64], x: &[f64]) -> Result<(), Box<EvalAltResult>> {
    if values.len() == x.len() {
        return Ok(());
    }
    let failure = call.argument("x").refuse(causes::COUNT, format!("`values` and `x` have {} and {} entries", values.len(), x.len()));
    Err(failure.hint("give one place for each value").into())
}

fn interpolate() -> Function {
    function(Topic::Arrays, "interpolate")
        .summary(
            "the value of a curve at a place or at an array of places, linear between its points; beyond its ends it stays as it is there",
        )
        .parameters(vec![
            Parameter::new("at", Kind::Either("a number or an array of numbers"), "where"),
            Parameter::array("x", "the places of the points, ascending"),
            Parameter::array("y", "their values"),
        ])
        .returns("number")
        .see_also(&["integrate", "diff", "table"])
        .example(
            "let t = [0.0, 1.0, 3.0];\nlet force = [0.0, 2.0, 6.0];\nprint(interpolate(2.0, t, force));\n\
                  print(interpolate([0.5, 1.5], t, force));",
        )
        .body(|call| {
            let (x, y, at) = (array(call, "x")?, array(call, "y")?, call.argument("at"));
            if x.len() != y.len() || x.is_empty() {
                let failure = call.argument("y").refuse(causes::COUNT, format!("`x` and `y` have {} and {} entries", x.len(), y.len()));
                return Err(failure.hint("give one `y` for each `x`, and at least one point").into());
            }
            if let Some(ends) = x.windows(2).find(|ends| ends[0].partial_cmp(&ends[1]) != Some(std::cmp::Ordering::Less)) {
                let failure = call.argument("x").refuse(causes::ORDER, "the places `x` of a curve must increase");
                let failure = failure.label(format!("{} follows {}", number_text(ends[1]), number_text(ends[0])));
                return Err(failure.hint("sort the points, and give each `x` once").into());
            }
            match as_number(&at.value()) {
                Some(at) => Ok(Dynamic::from(interpolated(at, &x, &y))),
                None if at.value().is_array() => Ok(array_of(array(call, "at")?.into_iter().map(|at| interpolated(at, &x, &y))).into()),
                None => Err(at.wrong_type().into()),
            }
        })
}

fn percentiles() -> Function {
    let percent = Parameter::number("percent", "1", Interval::Closed(0.0, 100.0), "the percentage, 50 for the median");
    of_array(
        "percentile",
        "the value below which so many percent of the entries of an array are, linear between entries; NaN left out",
        vec![percent],
        "float",
        "print(percentile([1.0, 2.0, 4.0, 8.0], 50)); // 3.0",
        |call, values| {
            let mut known: Vec<f64> = numbers(&values).filter(|x| !x.is_nan()).collect();
            known.sort_by(f64::total_cmp);
            if known.is_empty() {
                return Err(too_short(call, "at least one number"));
            }
            Ok(percentile(&known, call.number("percent")? / 100.0).into())
        },
    )
}

fn step_parameter() -> Parameter {
    Parameter::number("dt", "time", Interval::Positive, "the time between two values")
}

fn fft() -> Function {
    of_array(
        "fft",
        "the spectrum of values at equal distances of time, by the discrete Fourier transform: an object with `frequency`, from 0 to half \
         of that of the values, `amplitude` of the oscillation of each frequency, its `phase` as a cosine, and `real` and `imaginary` part \
         of the transform. Of any length",
        vec![step_parameter().or(1.0)],
        "Map",
        "let t = linspace(0.0, 0.99, 100);\nlet spectrum = fft(3.0 * sin(2.0 * PI * 5.0 * t), 0.01);\n\
         let peak = argmax(spectrum.amplitude);\nprint(`${spectrum.frequency[peak]}: ${spectrum.amplitude[peak]}`);",
        |call, values| {
            let (values, dt): (Vec<f64>, f64) = (numbers(&values).collect(), call.number("dt")?);
            if values.is_empty() {
                return Err(too_short(call, "at least one number"));
            }
            let (n, spectrum) = (values.len(), fourier(&values));
            // Every spectral line represents a conjugate pair, except the first and, for an even number of values, the last.
            let pairs = |k: usize| if k == 0 || 2 * k == n { 1.0 } else { 2.0 };
            let mut found = Map::new();
            let mut put = |name: &str, values: Array| found.insert(name.into(), values.into());
            put("frequency", array_of((0..spectrum.len()).map(|k| k as f64 / (n as f64 * dt))));
            put("amplitude", array_of(spectrum.iter().enumerate().map(|(k, [re, im])| pairs(k) * re.hypot(*im) / n as f64)));
            put("phase", array_of(spectrum.iter().map(|[re, im]| im.atan2(*re))));
            put("real", array_of(spectrum.iter().map(|part| part[0])));
            put("imaginary", array_of(spectrum.iter().map(|part| part[1])));
            Ok(found.into())
        },
    )
}

fn cfc_filter() -> Function {
    let class = Parameter::number("class", "1", Interval::Positive, "the channel frequency class in hertz: 60, 180, 600 or 1000");
    of_array(
        "cfc_filter",
        "values at equal distances of time filtered by the channel frequency class (CFC) of SAE J211: a Butterworth filter of fourth order \
         without a phase. Times are in seconds",
        vec![step_parameter(), class],
        "Array",
        "let t = linspace(0.0, 0.1, 1001);\nlet noisy = sin(40.0 * t) + 0.1 * sin(6000.0 * t);\nprint(cfc_filter(noisy, 1e-4, 60).max());",
        |call, values| {
            let (values, dt, class): (Vec<f64>, f64, f64) = (numbers(&values).collect(), call.number("dt")?, call.number("class")?);
            let failure =
                if class * dt > HIGHEST {
                    let failure = call.argument("class").refuse(causes::OUT_OF_RANGE, "the values are too far apart for this class");
                    Some(failure.cause(format!(
                        "SAE J211 asks for ten values in a period of the class: a `dt` of at most {} s",
                        brief(0.1 / class)
                    )))
                } else {
                    values
                        .iter()
                        .any(|x| !x.is_finite())
                        .then(|| call.argument("values").refuse(causes::OUT_OF_RANGE, "a filter needs finite numbers"))
                };
            match failure {
                Some(failure) => Err(failure.hint("give `dt` in seconds, and values at each step").into()),
                None => Ok(array_of(channel_filter(&values, dt, class)).into()),
            }
        },
    )
}

/// Largest filter class times sampling interval: the filter frequency, 2.0775 times the class, is then 0.83 of half the sampling frequency.
/// SAE J211 requires 0.1 at most.
const HIGHEST: f64 = 0.2;
