//! `fit`: constants of a law from measured stresses, with a plot of both.

use super::energies::refused;
use crate::machine::files;
use crate::materials::{CATALOGUE, EnergyError, EnergyText, Fit, FitError, HYPERELASTIC, HomogeneousTest, Measured, StoredEnergy, fit};
use crate::output::{Curve, CurveStyle, Plot, PlotAxis};
use crate::script::api::files::writing::{path_parameter, write_drawing};
use crate::script::language::failure::Details;
use crate::script::language::prelude::*;
use crate::script::language::sandbox::reason;
use crate::script::language::values::{as_number, describe};
use crate::script::language::wording::{did_you_mean, listed};

/// Options of the tests, with names for plots.
const TESTS: [(&str, &str, HomogeneousTest); 3] = [
    ("uniaxial", "uniaxial", HomogeneousTest::Uniaxial),
    ("equibiaxial", "equibiaxial", HomogeneousTest::Equibiaxial),
    ("pure_shear", "pure shear", HomogeneousTest::PureShear),
];

/// Points of a curve.
const POINTS: usize = 100;

/// Function `fit` of scripts.
pub fn fit_function() -> Function {
    let test = |name, summary| {
        Parameter::new(name, Kind::Either("a file's path or an array of pairs `[stretch, stress]`"), summary).otherwise("none")
    };
    let map = |name, summary| Parameter::any(name, summary).otherwise("none");
    let keys = vec![
        test("uniaxial", "a table of stretch and nominal stress (force per undeformed area) of a bar that is pulled or pressed"),
        test("equibiaxial", "the same of a sheet that is pulled alike in two directions"),
        test("pure_shear", "the same of a wide strip that is pulled along its short side"),
        map("start", "values of constants to begin with, `#{ alpha1: 2.0 }`; moduli need none"),
        map("fixed", "values of constants that are known, `#{ mu3: 0.0 }`"),
    ];
    function(Topic::Materials, "fit")
        .summary(
            "constants of a law by least squares of measured nominal stresses, the material being incompressible: a map with the \
             `constants`, the root-mean-square difference `rms` and `r_squared`. A table is a file with a line for each point, stretch \
             (strain, if the header says so) and stress; a plot shows both",
        )
        .parameters(vec![
            Parameter::text("law", "name of a law with a `bulk_modulus`, or an energy as text as for `hyperelastic`"),
            Parameter::map("tests", "what was measured").keys(keys),
            path_parameter("an `.svg` or `.png` file below the output folder for the plot").otherwise("no plot"),
        ])
        .returns("Map")
        .see_also(&["hyperelastic", "ogden", "yeoh", "uniaxial"])
        .example(
            "let tests = #{ uniaxial: [[1.2, 0.17], [1.5, 0.36], [2.0, 0.57], [3.0, 0.87]] };\n\
                  let found = fit(\"mooney_rivlin\", tests, \"fit.svg\");\n\
                  let rubber = mooney_rivlin(found.constants + #{ bulk_modulus: 100.0, density: 1e-9 });\n\
                  print(found.rms);",
        )
        .body(|call| {
            let options = call.options("tests")?;
            let measured = measured(call, &options)?;
            let law = Law::new(call)?;
            let (start, fixed) = (known(&options, "start", &law)?, known(&options, "fixed", &law)?);
            let free: Vec<&String> = law.names.iter().filter(|name| !fixed.iter().any(|(known, _)| known == *name)).collect();
            if free.is_empty() {
                return Err(call
                    .argument("law")
                    .refuse(causes::NO_SUCH, "the law has no constant to find")
                    .hint("name constants in the energy")
                    .into());
            }
            let energy = |values: &[f64]| {
                let found = free.iter().map(|name| name.to_string()).zip(values.iter().copied());
                law.energy(&found.chain(fixed.iter().cloned()).collect::<Vec<_>>())
            };
            let value = |name: &&String| start.iter().find(|(known, _)| known == *name).map(|(_, value)| *value);
            let found = fit(energy, &free.iter().map(value).collect::<Vec<_>>(), &measured).map_err(|error| failed(call, error))?;
            if call.argument("path").is_given() {
                let plot = plot(call, &law, &found, &energy, &measured)?;
                drop(write_drawing(call, None, || Ok(plot.draw()))?);
            }
            Ok(Dynamic::from(described(&free, &fixed, &found)))
        })
}

fn described(free: &[&String], fixed: &[(String, f64)], found: &Fit) -> Map {
    let constants = free.iter().map(|name| name.as_str()).zip(found.constants.iter().copied());
    let constants = constants.chain(fixed.iter().map(|(name, value)| (name.as_str(), *value)));
    let constants: Map = constants.map(|(name, value)| (name.into(), Dynamic::from(value))).collect();
    Map::from([
        ("constants".into(), Dynamic::from(constants)),
        ("rms".into(), Dynamic::from(found.rms)),
        ("r_squared".into(), Dynamic::from(found.r_squared)),
    ])
}

/// Law to be fitted, and the names of its constants.
struct Law {
    title: String,
    names: Vec<String>,
    form: Source,
}

/// Origin of the stored energy of the law: catalogue or text.
enum Source {
    Row(&'static crate::materials::MaterialRow),
    Text(EnergyText),
}

impl Law {
    fn new(call: &Call) -> Result<Self, Failure> {
        let argument = call.argument("law");
        let text = argument.text()?;
        if let Some(row) = CATALOGUE.iter().find(|row| row.name == text) {
            if !row.is_incompressible() {
                let failure = argument.fail(format!("`{text}` cannot be fitted: its constants also enter the energy of the volume"));
                return Err(failure.hint("write its energy, such as `\"mu/2*(I1bar - 3)\"`"));
            }
            let names = row.parameters.iter().map(|parameter| parameter.name).filter(|name| !["bulk_modulus", "density"].contains(name));
            return Ok(Law { title: text.replace('_', " "), names: names.map(String::from).collect(), form: Source::Row(row) });
        }
        let is_word = text.chars().all(|letter| letter.is_ascii_lowercase() || letter == '_');
        if is_word {
            let names: Vec<&str> = CATALOGUE.iter().filter(|row| row.is_incompressible()).map(|row| row.name).collect();
            return Err(argument.unknown_name(format!("there is no law \"{text}\" to fit"), &text, &names));
        }
        let energy = EnergyText::parse(&text).map_err(|error| refused(&argument, &error))?;
        let names = energy.constants().into_iter().map(|(name, _)| name).collect();
        Ok(Law { title: HYPERELASTIC.into(), names, form: Source::Text(energy) })
    }

    fn energy(&self, constants: &[(String, f64)]) -> Result<StoredEnergy, EnergyError> {
        match &self.form {
            Source::Row(row) => row.energy(|name| constants.iter().find(|(known, _)| known == name).map(|(_, value)| *value)),
            Source::Text(energy) => Ok(StoredEnergy {
                energy: energy.clone(),
                volumetric: None,
                fibers: Vec::new(),
                constants: constants.to_vec(),
                factor: 1.0,
            }),
        }
    }
}

fn failed(call: &Call, error: FitError) -> Failure {
    match error {
        FitError::Energy(error) => refused(&call.argument("law"), &error),
        FitError::Points { .. } => {
            call.fail(error.to_string()).code(error.code()).hint("give more points, or values for some constants in `fixed`")
        }
        _ => call.fail(error.to_string()).code(error.code()).hint("give values to begin with in `start`"),
    }
}

/// Values of constants in a map.
fn known(options: &Options, key: &str, law: &Law) -> Result<Vec<(String, f64)>, Failure> {
    let argument = options.argument(key);
    if !argument.is_given() {
        return Ok(Vec::new());
    }
    let value = argument.value();
    let Some(map) = value.read_lock::<Map>() else {
        return Err(argument.wrong(causes::WRONG_TYPE, "must be an object map").hint("write `#{ name: value }`"));
    };
    let entry = |(name, value): (&rhai::Identifier, &Dynamic)| {
        if !law.names.iter().any(|known| known == name.as_str()) {
            let failure = argument.refuse(causes::NO_SUCH, format!("the law has no constant `{name}`"));
            let failure = failure.cause(format!("its constants are {}", listed(&law.names, "and")));
            return Err(failure.hint(did_you_mean(name, law.names.iter().map(String::as_str)).unwrap_or_else(|| "remove it".into())));
        }
        match as_number(value).filter(|number| number.is_finite()) {
            Some(number) => Ok((name.to_string(), number)),
            None => Err(argument.refuse(causes::OUT_OF_RANGE, format!("`{name}` of {} must be a finite number", argument.title()))),
        }
    };
    map.iter().map(entry).collect()
}

/// Measurements of all tests in the options.
fn measured(call: &Call, options: &Options) -> Result<Vec<Measured>, Failure> {
    let mut all = Vec::new();
    for (name, _, piece) in TESTS {
        let argument = options.argument(name);
        if argument.is_given() {
            let points = if argument.value().is_string() { read(call, &argument)? } else { pairs(&argument)? };
            all.push(Measured { piece, points });
        }
    }
    if all.is_empty() {
        return Err(call.refuse(causes::EMPTY, "`fit` has no test to fit to").hint("give a table, `#{ uniaxial: \"uniaxial.csv\" }`"));
    }
    Ok(all)
}

fn sound(argument: &Argument, points: Vec<[f64; 2]>) -> Result<Vec<[f64; 2]>, Failure> {
    match points.iter().find(|point| point[0] <= 0.0 || !point.iter().all(|x| x.is_finite())) {
        Some([stretch, _]) => {
            let failure = argument.wrong(causes::OUT_OF_RANGE, "must have positive stretches").label(format!("this has {stretch}"));
            Err(failure.hint("a stretch is the length over the undeformed length; write strains under a header with `strain`"))
        }
        None => Ok(points),
    }
}

/// Points given in the script.
fn pairs(argument: &Argument) -> Result<Vec<[f64; 2]>, Failure> {
    let value = argument.value();
    let pair = |entry: &Dynamic| {
        let numbers: Option<Vec<f64>> = entry.read_lock::<Array>()?.iter().map(as_number).collect();
        <[f64; 2]>::try_from(numbers?).ok()
    };
    let points: Option<Vec<[f64; 2]>> = value.read_lock::<Array>().and_then(|entries| entries.iter().map(pair).collect());
    match points.filter(|points| !points.is_empty()) {
        Some(points) => sound(argument, points),
        None => {
            let failure = argument.wrong(causes::WRONG_TYPE, "must be a file's path or an array of pairs of numbers");
            Err(failure.label(format!("this is {}", describe(argument.call().engine(), &value))).hint("write `[[1.1, 0.14], [1.5, 0.36]]`"))
        }
    }
}

/// Reads points from a file: two numbers per line, separated by a comma, a semicolon or blanks; `#` begins a comment.
fn read(call: &Call, argument: &Argument) -> Result<Vec<[f64; 2]>, Failure> {
    let path = argument.text()?;
    let again = |failure: Failure| {
        let Details { title, causes, hints, .. } = &*failure;
        let failure = causes.iter().fold(argument.fail(title.clone()), |failure, cause| failure.cause(cause.clone()));
        hints.iter().fold(failure, |failure, hint| failure.hint(hint.clone()))
    };
    let file = call.host.sandbox.readable(&path).map_err(again)?;
    let text =
        files::read_text(&file).map_err(|error| argument.refuse(causes::FILE, format!("\"{path}\" cannot be read: {}", reason(&error))))?;
    let (mut points, mut is_strain) = (Vec::new(), false);
    for (index, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or("").trim();
        let fields: Vec<&str> = line.split([',', ';', ' ', '\t']).filter(|field| !field.is_empty()).collect();
        let numbers: Option<Vec<f64>> = fields.iter().map(|field| field.parse().ok()).collect();
        match numbers {
            _ if fields.is_empty() => {}
            Some(numbers) if numbers.len() == 2 => points.push([numbers[0] + if is_strain { 1.0 } else { 0.0 }, numbers[1]]),
            None if points.is_empty() && !is_strain => is_strain = line.to_lowercase().contains("strain"),
            _ => {
                let failure = argument.refuse(causes::FILE, format!("line {} of \"{path}\" has no two numbers", index + 1));
                return Err(failure.cause(format!("it reads `{line}`")).hint("write a stretch and a nominal stress in each line"));
            }
        }
    }
    if points.is_empty() {
        return Err(argument
            .refuse(causes::EMPTY, format!("\"{path}\" has no points"))
            .hint("write a stretch and a nominal stress in each line"));
    }
    sound(argument, points)
}

/// Points and curves of all tests.
fn plot(
    call: &Call,
    law: &Law,
    found: &Fit,
    energy: &impl Fn(&[f64]) -> Result<StoredEnergy, EnergyError>,
    measured: &[Measured],
) -> Result<Plot, Failure> {
    let fitted = energy(&found.constants).map_err(|error| refused(&call.argument("law"), &error))?;
    let mut curves = Vec::new();
    for test in measured {
        let name = TESTS.iter().find(|(_, _, piece)| *piece == test.piece).map_or("", |(_, name, _)| name);
        let (x, y): (Vec<f64>, Vec<f64>) = test.points.iter().map(|[stretch, stress]| (*stretch, *stress)).unzip();
        let [low, high] = [x.iter().copied().fold(1.0, f64::min), x.iter().copied().fold(1.0, f64::max)];
        curves.push(Curve { label: format!("{name}, measured"), x, y, style: CurveStyle::Points, ..Curve::default() });
        let stretches: Vec<f64> = (0..=POINTS).map(|k| low + (high - low) * k as f64 / POINTS as f64).collect();
        let y = fitted.incompressible_stresses(test.piece, &stretches).map_err(|error| refused(&call.argument("law"), &error))?;
        curves.push(Curve { label: format!("{name}, fitted"), x: stretches, y, ..Curve::default() });
    }
    let y = PlotAxis { included: Some(0.0), ..PlotAxis::new("nominal stress") };
    Ok(Plot { title: law.title.clone(), x: PlotAxis::new("stretch"), y, curves, ..Plot::default() })
}
