//! Behavior of a material: checks of its law, stresses in homogeneous tests, curves of these.

use super::handle::MaterialHandle;
use crate::materials::{HomogeneousTest, Material, path};
use crate::output::{Curve, Plot, PlotAxis};
use crate::script::api::files::writing::{path_parameter, write_drawing};
use crate::script::language::digits::number_text;
use crate::script::language::failure::Class;
use crate::script::language::prelude::*;

const RUBBER: &str = "let rubber = mooney_rivlin(#{ c10: 0.16, c01: 0.02, bulk_modulus: 100.0, density: 1e-9 });\n";

/// Default range of stretches in a plot.
const STRETCHES: [f64; 2] = [0.5, 3.0];
/// Number of points of a plot on each side of the stretch 1.
const POINTS: usize = 60;

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    let stresses = [
        ("uniaxial", HomogeneousTest::Uniaxial, "nominal stress (force per undeformed area) of a bar pulled to a stretch, its sides free"),
        ("equibiaxial", HomogeneousTest::Equibiaxial, "nominal stress of a sheet pulled alike in two directions, its thickness free"),
        ("pure_shear", HomogeneousTest::PureShear, "nominal stress of a wide strip pulled along its short side, its thickness free"),
    ];
    let mut all: Vec<Function> = stresses.into_iter().map(|(name, piece, summary)| stress(name, piece, summary)).collect();
    all.extend([uniaxial_path(), check(), plot()]);
    all
}

fn stress(name: &'static str, piece: HomogeneousTest, summary: &'static str) -> Function {
    method_of::<MaterialHandle>(Topic::Materials, name)
        .summary(summary)
        .parameters(vec![Parameter::number("stretch", "1", Interval::Positive, "length over undeformed length")])
        .returns("number")
        .see_also(&["uniaxial", "equibiaxial", "pure_shear", "plot", "check"])
        .example(format!("{RUBBER}print(rubber.{name}(1.5));"))
        .body(move |call, MaterialHandle(material)| {
            let stretch = call.number("stretch")?;
            let way = way(stretch, 1);
            let states = path(&material, piece, &way);
            match states.last().filter(|_| states.len() == way.len()) {
                Some(state) => Ok(Dynamic::from(state.nominal_stress)),
                None => Err(unreached(call, &material, stretch, states.last().map_or(1.0, |state| state.stretch)).into()),
            }
        })
}

fn uniaxial_path() -> Function {
    method_of::<MaterialHandle>(Topic::Materials, "uniaxial_path")
        .summary(
            "nominal stresses of a bar whose sides are free at stretches that it goes through one after the other, at rest: loading, \
             unloading and cycles of an elastic-plastic material; the path between two is divided into steps of a few percent",
        )
        .parameters(vec![Parameter::array("stretches", "lengths over the undeformed length")])
        .returns("Array")
        .see_also(&["uniaxial", "back_stress"])
        .example(
            "let steel = elastic_plastic(#{ youngs_modulus: 210e3, poisson_ratio: 0.3, density: 7.85e-9, yield_stress: 235.0 });\n\
                  print(steel.uniaxial_path([1.002, 1.0, 0.998, 1.002]));",
        )
        .body(move |call, MaterialHandle(material)| {
            let argument = call.argument("stretches");
            let stretches = argument.numbers()?;
            if let Some(stretch) = stretches.iter().find(|stretch| **stretch <= 0.0 || !stretch.is_finite()) {
                return Err(argument
                    .refuse(causes::OUT_OF_RANGE, format!("a stretch is {}, not greater than 0", number_text(*stretch)))
                    .into());
            }
            let (mut all, mut ends, mut last) = (Vec::new(), Vec::new(), 1.0);
            for &stretch in &stretches {
                all.extend(way(stretch / last, 1).into_iter().map(|part| last * part));
                ends.push(all.len() - 1);
                last = stretch;
            }
            let states = path(&material, HomogeneousTest::Uniaxial, &all);
            match ends.iter().position(|&end| end >= states.len()) {
                None => Ok(Dynamic::from(ends.iter().map(|&end| Dynamic::from(states[end].nominal_stress)).collect::<Array>())),
                Some(missing) => {
                    let reached = states.last().map_or(1.0, |state| state.stretch);
                    Err(unreached(call, &material, stretches[missing], reached).into())
                }
            }
        })
}

fn unreached(call: &Call, material: &Material, stretch: f64, last: f64) -> Failure {
    let title = format!("`{}` has no state at a stretch of {}", material.name(), number_text(stretch));
    let failure = Failure::new(Class::Numerics, title).in_method(call.function.form.receiver().is_some());
    let failure = failure.code("C0324").cause(format!("the last state that was found has a stretch of {last:.3}"));
    failure.hint("choose a stretch nearer to 1; `material.check()` reports where the law fails")
}

/// Returns stretches from 1 to `stretch`, both included, in steps of a few percent, at least `points` values.
fn way(stretch: f64, points: usize) -> Vec<f64> {
    let steps = ((stretch.ln().abs() / 0.05).ceil() as usize).clamp(points, 1000);
    (1..=steps).map(|k| if k == steps { stretch } else { (stretch.ln() * k as f64 / steps as f64).exp() }).collect()
}

fn check() -> Function {
    method_of::<MaterialHandle>(Topic::Materials, "check")
        .summary(
            "the faults of a material's law, an array of sentences, empty for a sound law: stress or energy at rest, stiffness at rest \
             that is not positive, ellipticity that is lost on the way to a stretch of 4 or 1/4 in uniaxial, equibiaxial and pure-shear \
             tests",
        )
        .returns("Array")
        .see_also(&["hyperelastic", "plot"])
        .example(
            "let soft = hyperelastic(#{ energy: \"mu/2*(I1 - 3)\", volumetric: \"10*mu*(J - 1)^2\", mu: 1.0, density: 1.0 });\n\
                  print(soft.check());",
        )
        .body(|_, MaterialHandle(material)| {
            let sentences: Array = material.weaknesses().iter().map(|weakness| Dynamic::from(weakness.to_string())).collect();
            Ok(Dynamic::from(sentences))
        })
}

fn plot() -> Function {
    let keys = vec![
        Parameter::array("stretches", "least and greatest stretch, around 1").otherwise("[0.5, 3]"),
        Parameter::text("title", "the text above").otherwise("name of the law"),
        Parameter::text("y_label", "the label of the vertical axis, with your unit").or("nominal stress"),
    ];
    method_of::<MaterialHandle>(Topic::Materials, "plot")
        .summary(
            "plots nominal stress over stretch in uniaxial, equibiaxial and pure-shear tests with free faces, as SVG or PNG; a curve ends \
             where the law has no state",
        )
        .parameters(vec![
            path_parameter("an `.svg` or `.png` file below the output folder"),
            Parameter::options("stretches and labels").otherwise("stretches from 0.5 to 3").keys(keys),
        ])
        .see_also(&["uniaxial", "equibiaxial", "pure_shear", "check"])
        .example(format!("{RUBBER}rubber.plot(\"rubber.svg\", #{{ stretches: [0.7, 2.0], y_label: \"nominal stress [MPa]\" }});"))
        .body_with_options(|call, MaterialHandle(material), options| {
            let given = options.argument("stretches");
            let [low, high] = match given.is_given() {
                false => STRETCHES,
                true => match given.numbers_of(2)?[..] {
                    [low, high] if 0.0 < low && low <= 1.0 && 1.0 <= high && low < high => [low, high],
                    _ => {
                        let failure = given.wrong(causes::ORDER, "must go from at most 1 to at least 1");
                        return Err(failure.label("not around 1").hint("write `stretches: [0.5, 3.0]`").into());
                    }
                },
            };
            let title = options.argument("title").given(Argument::text)?.unwrap_or_else(|| material.name().replace('_', " "));
            let y = PlotAxis { included: Some(0.0), ..PlotAxis::new(options.text("y_label")?) };
            let curves = HomogeneousTest::ALL.into_iter().map(|(name, piece)| curve(&material, name, piece, [low, high])).collect();
            let plot = Plot { title, x: PlotAxis::new("stretch"), y, curves, ..Plot::default() };
            Ok(write_drawing(call, None, || Ok(plot.draw()))?)
        })
}

/// Nominal stress over stretch, from the least stretch to the greatest.
fn curve(material: &Material, name: &str, piece: HomogeneousTest, [low, high]: [f64; 2]) -> Curve {
    let side = |stretch: f64| if stretch == 1.0 { Vec::new() } else { path(material, piece, &way(stretch, POINTS)) };
    let states = side(low).into_iter().rev().map(|state| (state.stretch, state.nominal_stress));
    let states = states.chain([(1.0, 0.0)]).chain(side(high).into_iter().map(|state| (state.stretch, state.nominal_stress)));
    let (x, y) = states.unzip();
    Curve { label: name.into(), x, y, ..Curve::default() }
}
