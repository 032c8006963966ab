//! Results that a script asks for by name: plots, pictures, fields. All are written below the run's output folder.

use std::sync::LazyLock;

use rhai::{Array, Dynamic};

use super::handle::SimulationHandle;
use super::history::unknown_column;
use crate::math::catalogue::Interval;
use crate::output::{Field, Frame, PictureOptions, braille_plot, picture, plot};
use crate::script::api::examples::flight_example;
use crate::script::language::arguments::Arguments;
use crate::script::language::diagnostics::Ink;
use crate::script::language::digits::brief;
use crate::script::language::failure::Failure;
use crate::script::language::function::{Call, Form, Function, Topic, body};
use crate::script::language::handle::Handle;
use crate::script::language::parameter::{Absent, Kind, Parameter};
use crate::script::language::scan::Target;
use crate::script::language::values::describe;

/// Columns of a history that are energies, as one axis of a plot says.
const ENERGIES: [&str; 4] = ["kinetic", "strain", "potential", "total"];

/// The functions of this file.
pub fn functions() -> Vec<Function> {
    vec![write_fields(), plot_function(), show(), picture_function()]
}

fn write_fields() -> Function {
    Function {
        name: "write_fields",
        form: Form::Method(SimulationHandle::receiver()),
        topic: Topic::Results,
        summary: "writes displacement, velocity, stress, contact pressure and gap of all bodies as they are now as VTU",
        parameters: vec![path_parameter("a `.vtu` file below the output folder")],
        returns: "",
        example: flight_example("sim.write_fields(\"start.vtu\");"),
        see_also: &["picture", "simulate"],
        body: body(|call| {
            let handle = call.receiver::<SimulationHandle>();
            let content = || handle.with(call, |simulation| Frame::new(simulation.time(), &simulation.fields()).encode());
            Ok(write(call, &handle, ".vtu", content)?)
        }),
    }
}

fn plot_function() -> Function {
    Function {
        name: "plot",
        form: Form::Method(SimulationHandle::receiver()),
        topic: Topic::Results,
        summary: "plots columns of the history over time as SVG",
        parameters: vec![
            path_parameter("an `.svg` file below the output folder"),
            Parameter::new("columns", Kind::Any, "the name of a column, or an array of names"),
        ],
        returns: "",
        example: flight_example("sim.run_to(0.05);\nsim.plot(\"energy.svg\", [\"kinetic\", \"strain\", \"total\"]);"),
        see_also: &["history"],
        body: body(|call| {
            let handle = call.receiver::<SimulationHandle>();
            let columns = chosen_columns(call, &handle)?;
            let time = handle.column("time").unwrap_or_default();
            let curves: Vec<(&str, &[f64])> = columns.iter().map(|(name, values)| (name.as_str(), values.as_slice())).collect();
            let label = match columns.as_slice() {
                [(only, _)] => only.as_str(),
                several if several.iter().all(|(name, _)| ENERGIES.contains(&name.as_str())) => "energy",
                _ => "",
            };
            Ok(write(call, &handle, ".svg", || Ok(plot(&handle.0.name, ["time", label], &time, &curves).into_bytes()))?)
        }),
    }
}

fn show() -> Function {
    Function {
        name: "show",
        form: Form::Method(SimulationHandle::receiver()),
        topic: Topic::Results,
        summary: "draws columns of the history over time right here, with letters",
        parameters: vec![Parameter::new("columns", Kind::Any, "the name of a column, or an array of names").or(Absent::Means("\"total\""))],
        returns: "",
        example: flight_example("sim.run_to(0.05);\nsim.show([\"kinetic\", \"strain\", \"total\"]);"),
        see_also: &["plot", "history"],
        body: body(|call| {
            let handle = call.receiver::<SimulationHandle>();
            let columns = chosen_columns(call, &handle)?;
            if call.host.is_check() {
                return Ok(Dynamic::UNIT);
            }
            let time = handle.column("time").unwrap_or_default();
            let curves: Vec<(&str, &[f64])> = columns.iter().map(|(name, values)| (name.as_str(), values.as_slice())).collect();
            let is_colored = call.host.observer.ink() == Ink::Colored;
            call.host.observer.print(&braille_plot(&handle.0.name, "time", &time, &curves, is_colored));
            Ok(Dynamic::UNIT)
        }),
    }
}

fn picture_function() -> Function {
    Function {
        name: "picture",
        form: Form::Method(SimulationHandle::receiver()),
        topic: Topic::Results,
        summary: "draws the deformed bodies as SVG, colored by a field, with a color bar",
        parameters: vec![
            path_parameter("an `.svg` file below the output folder"),
            Parameter::new(
                "options",
                Kind::Options(vec![
                    Parameter::new("field", Kind::Choice(field_names()), "the field that gives the colors").or(Absent::Text("von_mises")),
                    Parameter::new("range", Kind::Array, "the values at the two ends of the color bar")
                        .or(Absent::Means("those of the field")),
                    Parameter::new("title", Kind::Text, "the text above").or(Absent::Means("name of the simulation and time")),
                    Parameter::number("width", "pixels", Interval::Closed(240.0, 10000.0), "the width").or(Absent::Number(720.0)),
                ]),
                "what is shown",
            )
            .or(Absent::Means("#{ field: \"von_mises\" }")),
        ],
        returns: "",
        example: flight_example("sim.picture(\"start.svg\", #{ field: \"velocity\" });"),
        see_also: &["plot", "write_fields"],
        body: body(|call| {
            let (handle, options) = (call.receiver::<SimulationHandle>(), call.options("options")?);
            let field = Field::from_name(&options.text("field")?).unwrap_or_default();
            let range = options.argument("range");
            let range = if range.is_given() { range.numbers_of(2).map(|ends| Some([ends[0], ends[1]]))? } else { None };
            let title = options.argument("title");
            let title = if title.is_given() { Some(title.text()?) } else { None };
            let width = options.number("width")?;
            let content = || {
                handle.with(call, |simulation| {
                    let title = title.unwrap_or_else(|| format!("{} at t = {}", handle.0.name, brief(simulation.time())));
                    picture(&simulation.fields(), &PictureOptions { field, title, range, width }).into_bytes()
                })
            };
            Ok(write(call, &handle, ".svg", content)?)
        }),
    }
}

/// Writes a file below the output folder, with the ending it must have; without an output folder nothing is written.
pub fn write(
    call: &Call,
    handle: &SimulationHandle,
    ending: &str,
    content: impl FnOnce() -> Result<Vec<u8>, Failure>,
) -> Result<Dynamic, Failure> {
    let argument = call.argument("path");
    let path = argument.text()?;
    if !path.ends_with(ending) {
        let failure = argument.fail(format!("{} must end with `{ending}`", argument.title()));
        return Err(failure.label("another ending").hint(format!("write \"{path}{ending}\"")));
    }
    if call.host.is_check() {
        call.host.findings.borrow_mut().push(format!("would write {path}"));
        return Ok(Dynamic::UNIT);
    }
    let bytes = content()?;
    match handle.0.artifacts.borrow_mut().as_mut() {
        Some(artifacts) => artifacts.write(&path, &bytes).map_err(|error| argument.fail(error.to_string()).hint(error.cure()))?,
        None => call.host.observer.print(&format!("{path} is not written: this session has no output folder")),
    }
    Ok(Dynamic::UNIT)
}

/// The columns of the history that the argument `columns` names.
fn chosen_columns(call: &Call, handle: &SimulationHandle) -> Result<Vec<(String, Vec<f64>)>, Failure> {
    let argument = call.argument("columns");
    let value = if argument.is_given() { argument.value() } else { Dynamic::from("total") };
    let names: Option<Vec<String>> = match value.read_lock::<Array>() {
        Some(array) => array.iter().map(|name| name.clone().into_string().ok()).collect(),
        None => value.clone().into_string().ok().map(|name| vec![name]),
    };
    let Some(names) = names.filter(|names| !names.is_empty()) else {
        let failure = argument.fail(format!("{} must be a column's name or an array of names", argument.title()));
        let given = describe(call.engine(), &value);
        return Err(failure.label(format!("this is {given}")).hint("write `[\"kinetic\", \"total\"]`"));
    };
    let place = call.function.parameters.iter().position(|parameter| parameter.name == "columns").unwrap_or(0);
    let column = |name: String| match handle.column(&name) {
        Some(values) => Ok((name, values)),
        None => Err(unknown_column(call, handle, &name).at(Target::Argument(place))),
    };
    names.into_iter().map(column).collect()
}

/// Names of the fields.
fn field_names() -> &'static [&'static str] {
    static NAMES: LazyLock<Vec<&str>> = LazyLock::new(|| Field::ALL.iter().map(|row| row.0).collect());
    &NAMES
}

fn path_parameter(summary: &'static str) -> Parameter {
    Parameter::new("path", Kind::Text, summary)
}
