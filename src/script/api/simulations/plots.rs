//! Plots: columns of a history over a column, and any arrays over arrays.
//!
//! Default labels are words; the zero of a potential energy is chosen so that no curve is flattened ([`above_lowest_potential`]).

use super::handle::SimulationHandle;
use super::history::unknown_column;
use super::writing::chosen_columns;
use crate::output::{Curve, CurveStyle, ENERGIES, Plot, PlotAxis, above_lowest_potential, pretty_unit};
use crate::script::api::examples::flight_example;
use crate::script::api::files::writing::{path_parameter, write_drawing};
use crate::script::language::prelude::*;
use crate::script::language::values::{as_number, describe};
use crate::script::language::wording::{did_you_mean, joined, listed};

/// Keys of a curve's map.
const CURVE_KEYS: [&str; 5] = ["of", "x", "y", "label", "style"];

fn optional(name: &'static str, kind: Kind, summary: &'static str, absent: &'static str) -> Parameter {
    Parameter::new(name, kind, summary).otherwise(absent)
}

/// Options common to all plots.
fn plot_options() -> Vec<Parameter> {
    let size = |name, default, summary| Parameter::number(name, "pixels", Interval::Closed(240.0, 10000.0), summary).or(default);
    vec![
        optional("title", Kind::Text, "the text above", "name of the simulation, or none"),
        optional("x_label", Kind::Text, "the label of the horizontal axis, with your unit: `\"time [ms]\"`", "the column in words"),
        optional("y_label", Kind::Text, "the label of the vertical axis, with your unit: `\"force [kN]\"`", "the column in words"),
        optional("x_range", Kind::Array, "the values at the ends of the horizontal axis", "those of the curves"),
        optional("y_range", Kind::Array, "the values at the ends of the vertical axis", "those of the curves"),
        Parameter::new("log", Kind::Choice(&["none", "x", "y", "xy"]), "the logarithmic axes; values that are not positive leave a gap")
            .or("none"),
        size("width", 720.0, "the width; a PNG has twice as many pixels"),
        size("height", 420.0, "the height; a PNG has twice as many pixels"),
    ]
}

/// Function `sim.plot` of scripts.
pub(super) fn plot() -> Function {
    let mut keys = vec![
        optional("x", Kind::Text, "the column of the horizontal axis", "\"time\""),
        optional("labels", Kind::Array, "the labels of the columns in the legend, one string each", "their names in words"),
    ];
    keys.extend(plot_options());
    method_of::<SimulationHandle>(Topic::Results, "plot")
        .summary(
            "plots columns of the history over time, or over another column, as SVG or PNG; a constant potential energy that would hide \
             the other energies is taken off, as the legend says",
        )
        .parameters(vec![
            path_parameter("an `.svg` or `.png` file below the output folder"),
            Parameter::any("columns", "the name of a column, or an array of names"),
            Parameter::options("axes, labels and size").otherwise("columns over time").keys(keys),
        ])
        .see_also(&["plot_curves", "history", "picture"])
        .example(flight_example(
            "sim.run_to(0.05);\nsim.plot(\"energy.svg\", [\"kinetic\", \"strain\", \"total\"]);\n\
             sim.plot(\"defect.png\", \"energy_defect\", #{ x: \"step\", y_label: \"defect [J]\", log: \"y\" });",
        ))
        .body_with_options(|call, handle, options| {
            let mut columns = chosen_columns(call, &handle)?;
            let over = options.argument("x");
            let x_name = if over.is_given() { over.text()? } else { "time".into() };
            let x = handle.column(&x_name).ok_or_else(|| unknown_column(call, &handle, &x_name).at(over.target()))?;
            let is_energies = columns.iter().all(|(name, _)| ENERGIES.contains(&name.as_str()));
            let label = match &columns[..] {
                [(only, _)] => words(only),
                _ if is_energies => "energy".into(),
                _ => String::new(),
            };
            let labels = labels(&options, columns.len())?;
            let is_said = labels.is_some();
            let known = handle.0.column_units();
            let unit = |name: &str| known.get(name).map_or(String::new(), |unit| format!(" [{}]", pretty_unit(unit)));
            let units: Vec<String> = columns.iter().map(|(name, _)| unit(name)).collect();
            // A common unit of all curves is shown at the axis, different units in the legend.
            let is_common = units.iter().all(|unit| *unit == units[0]);
            let label = if is_common { format!("{label}{}", units[0]).trim_start().to_string() } else { label };
            let curve = |(index, (name, y)): (usize, &mut (String, Vec<f64>))| Curve {
                label: match &labels {
                    Some(labels) => labels[index].clone(),
                    None if is_energies => name.clone(),
                    None if is_common => words(name),
                    None => format!("{}{}", words(name), units[index]),
                },
                is_sum: name == "total",
                x: x.clone(),
                y: std::mem::take(y),
                ..Curve::default()
            };
            let mut curves: Vec<Curve> = columns.iter_mut().enumerate().map(curve).collect();
            let mut plot = look(&options, &handle.0.name, [format!("{}{}", words(&x_name), unit(&x_name)), label])?;
            if is_energies && !is_said && plot.y.range.is_none() && !plot.y.is_logarithmic {
                above_lowest_potential(&mut curves);
            }
            if let ([only], false) = (&mut curves[..], is_said) {
                only.label.clone_from(&plot.y.label);
            }
            plot.curves = curves;
            Ok(write_drawing(call, Some(&handle), || Ok(plot.draw()))?)
        })
}

/// Function `plot_curves` of scripts.
pub(super) fn plot_curves() -> Function {
    function(Topic::Results, "plot_curves")
        .summary(
            "plots arrays over arrays, and columns of any simulations, in one pair of axes, as SVG or PNG. A curve is a map: `x` and `y` \
             are arrays, or names of columns of the simulation `of` (`x` is then `\"time\"` where it is left out); `label` is what the \
             legend says; `style` is `\"line\"`, `\"dashed\"` or `\"points\"`",
        )
        .parameters(vec![
            path_parameter("an `.svg` or `.png` file below the output folder"),
            Parameter::array("curves", "an array of curves `#{ x, y, label, style }` or `#{ of, x, y, label, style }`"),
            Parameter::options("axes, labels and size").otherwise("no title and labels").keys(plot_options()),
        ])
        .see_also(&["plot", "history"])
        .example(flight_example(
            "sim.run_to(0.05);\n\
             plot_curves(\"law.svg\", [\n\
             \x20   #{ of: sim, y: \"kinetic\", label: \"computed\" },\n\
             \x20   #{ x: [0.0, 0.05], y: [2.0, 2.0], label: \"exact\", style: \"dashed\" },\n\
             ], #{ x_label: \"time [s]\", y_label: \"energy [J]\" });",
        ))
        .body(|call| {
            let (argument, options) = (call.argument("curves"), call.options("options")?);
            let entries = argument.array()?;
            let curves: Vec<Curve> =
                entries.iter().enumerate().map(|(index, entry)| curve(call, &argument, index, entry)).collect::<Result<_, _>>()?;
            if curves.is_empty() {
                return Err(argument.wrong(causes::EMPTY, "has no curves").hint("write `[#{ x: […], y: […] }]`").into());
            }
            let plot = Plot { curves, ..look(&options, "", [String::new(), String::new()])? };
            Ok(write_drawing(call, None, || Ok(plot.draw()))?)
        })
}

/// Returns title, axes and size of a plot; `labels` are the default labels of the axes.
fn look(options: &Options, title: &str, labels: [String; 2]) -> Result<Plot, Failure> {
    let given = |name: &str, otherwise: String| Ok(options.argument(name).given(Argument::text)?.unwrap_or(otherwise));
    let log = options.text("log")?;
    let [x, y] = labels;
    let axis = |letter: &str, label: String| {
        let (range, is_logarithmic) = (options.argument(if letter == "x" { "x_range" } else { "y_range" }), log.contains(letter));
        let range_of = ascending(&range)?;
        match range_of {
            Some([low, _]) if is_logarithmic && low <= 0.0 => {
                let failure = range.wrong(causes::OUT_OF_RANGE, "must be positive on a logarithmic axis");
                Err(failure.label("this begins at or below 0").hint("begin at a positive number, such as `[1e-6, 1.0]`"))
            }
            range => Ok(PlotAxis { label, range, is_logarithmic, included: None }),
        }
    };
    let (x, y) = (axis("x", given("x_label", x)?)?, axis("y", given("y_label", y)?)?);
    let size = [options.number("width")?, options.number("height")?];
    Ok(Plot { title: given("title", title.into())?, x, y, curves: Vec::new(), size })
}

/// Returns two ascending numbers, if given.
pub(super) fn ascending(argument: &Argument) -> Result<Option<[f64; 2]>, Failure> {
    if !argument.is_given() {
        return Ok(None);
    }
    let numbers = argument.numbers()?;
    match numbers[..] {
        [low, high] if low < high => Ok(Some([low, high])),
        [_, _] => Err(argument
            .wrong(causes::ORDER, "must ascend")
            .label("the first is not less than the second")
            .hint("write `[least, greatest]`")),
        _ => {
            let failure = argument.wrong(causes::WRONG_TYPE, "must be two numbers");
            Err(failure.label(format!("this has {}", numbers.len())).hint("write `[least, greatest]`"))
        }
    }
}

/// Returns the labels of the legend, if given, one for each of `count` columns.
fn labels(options: &Options, count: usize) -> Result<Option<Vec<String>>, Failure> {
    let argument = options.argument("labels");
    if !argument.is_given() {
        return Ok(None);
    }
    let array = argument.array()?;
    let texts: Option<Vec<String>> = array.iter().map(|label| label.clone().into_string().ok()).collect();
    let Some(texts) = texts else {
        return Err(argument.wrong(causes::WRONG_TYPE, "must be an array of strings").hint("write `[\"inner ring\", \"outer ring\"]`"));
    };
    if texts.len() != count {
        let failure = argument.wrong(causes::COUNT, format!("must have one string for each of the {count} columns"));
        return Err(failure.label(format!("this has {}", texts.len())).hint("name every column, in the order of `columns`"));
    }
    Ok(Some(texts))
}

/// Returns a curve from its map.
fn curve(call: &Call, argument: &Argument, index: usize, entry: &Dynamic) -> Result<Curve, Failure> {
    let fail = |what: String| argument.fail(format!("curve {} of `plot_curves` {what}", index + 1));
    let Some(map) = entry.read_lock::<Map>() else {
        return Err(fail("must be a map".into())
            .label(format!("it is {}", describe(call.engine(), entry)))
            .hint("write `#{ x: […], y: […], label: \"…\" }`"));
    };
    if let Some(unknown) = map.keys().find(|key| !CURVE_KEYS.contains(&key.as_str())) {
        let failure = fail(format!("has no entry `{unknown}`")).cause(format!("its entries are {}", listed(&CURVE_KEYS, "and")));
        return Err(failure.hint(did_you_mean(unknown, CURVE_KEYS).unwrap_or_else(|| "remove the entry".into())));
    }
    let of = match map.get("of") {
        None => None,
        Some(value) => Some(value.clone().try_cast::<SimulationHandle>().ok_or_else(|| {
            fail("must name a simulation as `of`".into())
                .label(format!("it is {}", describe(call.engine(), value)))
                .hint("write `of: sim`, or leave it out and give arrays")
        })?),
    };
    let values = |name: &str| -> Result<Vec<f64>, Failure> {
        let default = (name == "x" && of.is_some()).then(|| Dynamic::from("time"));
        let Some(value) = map.get(name).cloned().or(default) else {
            return Err(fail(format!("needs `{name}`")).hint(format!("give `{name}: […]`, or `of: sim` and the name of a column")));
        };
        if let (Some(handle), Ok(column)) = (&of, value.clone().into_string()) {
            return handle.column(&column).ok_or_else(|| {
                let columns = handle.columns();
                let failure = fail(format!("names a column `{column}` that the history does not have"))
                    .cause(format!("its columns are {}", listed(&columns, "and")));
                failure.hint(did_you_mean(&column, columns.iter().map(String::as_str)).unwrap_or_else(|| "use one of these names".into()))
            });
        }
        let array = value.read_lock::<Array>().map(|array| array.clone());
        // NaN is admitted, because a missing value leaves a gap in the curve.
        let number = |value: &Dynamic| value.as_float().ok().or_else(|| as_number(value));
        let numbers: Option<Vec<f64>> = array.and_then(|array| array.iter().map(number).collect());
        numbers.ok_or_else(|| {
            let what = if of.is_some() { "a column's name or an array of numbers" } else { "an array of numbers" };
            let failure = fail(format!("must have {what} as `{name}`")).label(format!("it is {}", describe(call.engine(), &value)));
            failure.hint(if value.is_string() { "say whose column it is with `of: sim`" } else { "write `[0.0, 1.0]`" })
        })
    };
    let (x, y) = (values("x")?, values("y")?);
    if x.len() != y.len() {
        let failure = fail("must have as many values in `x` as in `y`".into());
        return Err(failure.label(format!("`x` has {}, `y` has {}", x.len(), y.len())).hint("give both arrays the same length"));
    }
    let text = |name: &str| match map.get(name) {
        None => Ok(None),
        Some(value) => value.clone().into_string().map(Some).map_err(|kind| {
            fail(format!("must have a string as `{name}`")).label(format!("it is of type {kind}")).hint("put it in quotes")
        }),
    };
    let label = match (text("label")?, &of, map.get("y")) {
        (Some(label), ..) => label,
        (None, Some(of), Some(y)) if y.is_string() => format!("{}: {}", of.0.name, words(&y.to_string())),
        _ => String::new(),
    };
    let names: Vec<String> = CurveStyle::ALL.iter().map(|row| format!("\"{}\"", row.0)).collect();
    let style = match text("style")? {
        None => CurveStyle::default(),
        Some(name) => CurveStyle::ALL.iter().find(|row| row.0 == name).map(|row| row.1).ok_or_else(|| {
            let failure = fail(format!("cannot have the style \"{name}\"")).cause(format!("there are {}", joined(&names, "and")));
            failure.hint(
                did_you_mean(&name, CurveStyle::ALL.iter().map(|row| row.0))
                    .map_or("use one of these".into(), |hint| hint.replace('`', "\"")),
            )
        })?,
    };
    Ok(Curve { label, x, y, style, is_sum: false })
}

/// Name of a column in words: `kinetic energy`, `foot, force x`, `tip, displacement y`.
fn words(column: &str) -> String {
    if let Some((owner, quantity)) = column.rsplit_once('.') {
        let letters: Vec<char> = quantity.chars().collect();
        let quantity = match letters[..] {
            ['u', axis @ ('x' | 'y' | 'z')] => format!("displacement {axis}"),
            ['v', axis @ ('x' | 'y' | 'z')] => format!("velocity {axis}"),
            _ => words(quantity),
        };
        return format!("{}, {quantity}", owner.replace(".reaction", ", reaction"));
    }
    match column {
        "dt" => "step size".into(),
        "halvings" => "halvings".into(),
        _ if ENERGIES.contains(&column) => format!("{column} energy"),
        "load_work" | "contact_work" | "friction_work" | "dissipation" => format!("{} per step", column.replace('_', " ")),
        _ => column.replace('_', " "),
    }
}
