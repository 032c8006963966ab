//! Pictures of the deformed bodies and the obstacles that they touch.

use std::sync::LazyLock;

use super::handle::{SimulationData, SimulationHandle};
use super::local_frames::{Geometry, frame_of, frame_parameters};
use super::plots::ascending;
use crate::dynamics::BodyFields;
use crate::output::{CutPlane, Field, Measure, Panel, PictureOptions, VIEWS, Vectors, View, picture};
use crate::script::api::examples::flight_example;
use crate::script::api::files::writing::{path_parameter, write_drawing};
use crate::script::api::models::{data::ModelData, handle::BodyHandle};
use crate::script::language::digits::brief;
use crate::script::language::prelude::*;
use crate::script::language::values::{as_number, describe};

/// Names of the axes that may point up.
const AXES: &[&str] = &["x", "y", "z"];

/// Option choices from the names in the first column of a table.
macro_rules! names {
    ($table:expr) => {{
        static NAMES: LazyLock<Vec<&str>> = LazyLock::new(|| $table.iter().map(|row| row.0).collect());
        &NAMES
    }};
}

pub(super) fn keys() -> Vec<Parameter> {
    let optional = |name, kind, summary, absent| Parameter::new(name, kind, summary).otherwise(absent);
    let mut keys = vec![
        Parameter::new(
            "field",
            Kind::Either("a field's name or an array of names"),
            "the field that gives the colors, or several, one panel each: `von_mises`, `pressure`, `contact_pressure`, `displacement`, \
             `velocity`, `slip` (which nodes stick and which slide against friction), and all of `sim.field` that have a size, such as \
             `stress_xx`, `principal_1`, `strain_tt`, `acceleration` or `energy_density`; `movie` needs some of them in `stills_fields` of \
             `simulate`",
        )
        .or("von_mises"),
        optional(
            "range",
            Kind::Array,
            "the values at the two ends of the color bar, `[least, greatest]`; an array of these for several fields",
            "those of the field",
        ),
        optional(
            "unit",
            Kind::Text,
            "your unit of the field, said at the color bar: `\"MPa\"`; for several fields with commas between",
            "that of `units`",
        ),
        optional("title", Kind::Text, "the text above", "name of the simulation and time"),
        Parameter::flag("mesh", "whether cell edges are drawn where there is room for them").or(true),
        Parameter::flag("undeformed", "whether the undeformed bodies are outlined").or(false),
        optional(
            "vectors",
            Kind::Choice(names!(Vectors::ALL)),
            "what is shown by arrows; those of contact end where it presses",
            "no arrows",
        ),
        optional("vector_unit", Kind::Text, "your unit of the arrows", "that of `units`"),
        Parameter::new(
            "scale",
            Kind::Choice(names!(Measure::ALL)),
            "the indicator of lengths: a scale bar, or axes with numbers (in the plane)",
        )
        .or("bar"),
        optional("length_unit", Kind::Text, "your unit of lengths: `\"mm\"`", "that of `units`"),
        optional(
            "view",
            Kind::Either("a direction's name or a vector from the bodies to the viewer"),
            "the direction from which bodies in space are seen: `\"iso\"`, `\"front\"`, `\"back\"`, `\"left\"`, `\"right\"`, `\"top\"`, \
             `\"bottom\"`, or a vector such as `[1, -2, 1]`",
            "\"iso\"",
        ),
        Parameter::new("up", Kind::Choice(AXES), "the axis that points up in pictures of bodies in space").or("z"),
        optional(
            "section",
            Kind::Options(vec![
                optional("normal", Kind::Vector, "the normal of the plane, on either side; it must be given", "required").of("1"),
                optional("point", Kind::Vector, "a point of the plane", "the middle of what is shown").of("length"),
            ]),
            "a plane that opens bodies in space: what is on the viewer's side of it is taken away, and the field is seen on the cut",
            "nothing is cut",
        ),
        optional(
            "bodies",
            Kind::Array,
            "the bodies that are shown, such as `[ball]`: what others hide is seen, such as where they touch it",
            "all",
        ),
        Parameter::number("width", "pixels", Interval::Closed(240.0, 10000.0), "the width; a PNG has twice as many pixels").or(720.0),
    ];
    keys.extend(frame_parameters());
    keys
}

/// Function `sim.picture` of scripts.
pub(super) fn picture_function() -> Function {
    method_of::<SimulationHandle>(Topic::Results, "picture")
        .summary(
            "draws the deformed bodies and their rigid obstacles as SVG or PNG, colored by one or several fields, with color bars, a \
             scale, and in space the directions of the axes",
        )
        .parameters(vec![
            path_parameter("an `.svg` or `.png` file below the output folder"),
            Parameter::options("what is shown").otherwise("#{ field: \"von_mises\" }").keys(keys()),
        ])
        .see_also(&["movie", "plot", "write_fields"])
        .example(flight_example(
            "sim.picture(\"start.svg\", #{ field: \"velocity\", vectors: \"velocity\", length_unit: \"m\" });\n\
             sim.picture(\"both.png\", #{ field: [\"von_mises\", \"pressure\"], mesh: false });",
        ))
        .body_with_options(|call, handle, options| {
            let title = options.argument("title").given(Argument::text)?;
            let mut shown = shown(&options, &handle.0)?;
            Ok(write_drawing(call, Some(&handle), || {
                handle.with(call, |simulation| {
                    shown.title =
                        title.unwrap_or_else(|| format!("{} at t = {}", handle.0.name, handle.0.told(brief(simulation.time()), "time")));
                    let fields = simulation.fields();
                    refuse_empty_section(&options, &fields, &shown)?;
                    Ok(picture(&fields, &simulation.obstacles(), &shown))
                })?
            })?)
        })
}

/// Refuses a section that removes all bodies.
fn refuse_empty_section(options: &Options, fields: &[BodyFields], shown: &PictureOptions) -> Result<(), Failure> {
    let Some(section) = &shown.section else { return Ok(()) };
    let is_shown = |body: &&BodyFields| shown.only.is_empty() || shown.only.contains(&body.name);
    let points = fields.iter().filter(is_shown).flat_map(|body| (0..body.displacement.len()).map(|node| body.position(node)));
    if !section.takes_all(points) {
        return Ok(());
    }
    let argument = options.argument("section");
    let failure = argument.wrong(causes::EMPTY, "takes away all that is shown");
    Err(failure.hint("give a `point` within the bodies: what is on the viewer's side of the plane is taken away"))
}

/// Reads the options of pictures of a model.
pub(super) fn shown(options: &Options, data: &SimulationData) -> Result<PictureOptions, Failure> {
    let model = &data.model;
    let geometry = Geometry::of(&model.model);
    let dimension = geometry.dimension();
    let unit = |name: &str, dimension: &str| Ok(options.argument(name).given(Argument::text)?.unwrap_or_else(|| data.unit(dimension)));
    let text = |name: &str| Ok(options.argument(name).given(Argument::text)?.unwrap_or_default());
    let measure = options.text("scale")?;
    let measure = Measure::ALL.iter().find(|row| row.0 == measure).map_or(Measure::default(), |row| row.1);
    if measure == Measure::Axes && dimension == 3 {
        let argument = options.argument("scale");
        let failure = argument
            .refuse(causes::DIMENSION, "bodies in space have no axes with numbers")
            .cause("lengths along the line of sight cannot be read off");
        return Err(failure.hint("use `scale: \"bar\"`; the triad shows the directions"));
    }
    let vectors = text("vectors")?;
    let vectors = Vectors::ALL.iter().find(|row| row.0 == vectors).map(|row| row.2);
    let view = view(options, dimension)?;
    Ok(PictureOptions {
        panels: panels(options, geometry, data)?,
        title: String::new(),
        width: options.number("width")?,
        view,
        section: section(options, &view, dimension)?,
        only: bodies(&options.argument("bodies"), model)?,
        is_meshed: options.flag("mesh")?,
        is_undeformed_shown: options.flag("undeformed")?,
        vectors: vectors.zip(Some(unit("vector_unit", vectors.map_or("1", Vectors::dimension))?)),
        measure,
        length_unit: unit("length_unit", "length")?,
        sight: None,
    })
}

/// The fields with their ranges and units.
fn panels(options: &Options, geometry: Geometry, data: &SimulationData) -> Result<Vec<Panel>, Failure> {
    let argument = options.argument("field");
    let value = if argument.is_given() { argument.value() } else { Dynamic::from("von_mises") };
    let names: Option<Vec<String>> = match value.clone().into_array() {
        Ok(array) => array.into_iter().map(|name| name.into_string().ok()).collect(),
        Err(_) => value.clone().into_string().ok().map(|name| vec![name]),
    };
    let names = names.filter(|names| !names.is_empty()).ok_or_else(|| argument.wrong_type())?;
    let known = Field::names();
    let fields: Vec<Field> =
        names.iter().map(|name| Field::from_name(name).ok_or_else(|| argument.unknown_choice(name, &known))).collect::<Result<_, _>>()?;
    let (ranges, frame) = (ranges(&options.argument("range"), fields.len())?, frame_of(options, geometry)?);
    let argument = options.argument("unit");
    let units = if argument.is_given() { argument.text()? } else { String::new() };
    let units: Vec<&str> = units.split(',').map(str::trim).collect();
    if fields.len() > 1 && argument.is_given() && units.len() != fields.len() {
        let failure = argument.wrong(causes::COUNT, format!("must name one unit for each of the {} fields", fields.len()));
        let example: Vec<String> = names.iter().map(|name| format!("<unit of {name}>")).collect();
        return Err(failure.label(format!("this names {}", units.len())).hint(format!("write `unit: \"{}\"`", example.join(", "))));
    }
    let unit = |index: usize, field: Field| match fields.len() {
        _ if !argument.is_given() => data.unit(field.dimension()),
        1 => units.join(", "),
        _ => units.get(index).unwrap_or(&"").to_string(),
    };
    Ok(fields
        .iter()
        .zip(ranges)
        .enumerate()
        .map(|(index, (&field, range))| Panel { field, range, unit: unit(index, field), frame })
        .collect())
}

/// Ranges of `count` fields.
fn ranges(argument: &Argument, count: usize) -> Result<Vec<Option<[f64; 2]>>, Failure> {
    if !argument.is_given() || count == 1 {
        return Ok(vec![ascending(argument)?; count]);
    }
    let entries = argument.array()?;
    let pair = |entry: &Dynamic| {
        let numbers: Vec<f64> = entry.clone().into_array().ok()?.iter().map(as_number).collect::<Option<_>>()?;
        <[f64; 2]>::try_from(numbers).ok().filter(|[low, high]| low < high)
    };
    let pairs: Option<Vec<[f64; 2]>> = entries.iter().map(pair).collect();
    match pairs.filter(|pairs| pairs.len() == count) {
        Some(pairs) => Ok(pairs.into_iter().map(Some).collect()),
        None => {
            let failure =
                argument.wrong(causes::COUNT, format!("must be an array with a range `[least, greatest]` for each of {count} fields"));
            Err(failure.hint("write `range: [[0.0, 1.0], [0.0, 5.0]]`, or leave it out"))
        }
    }
}

/// Section plane of bodies in space.
fn section(options: &Options, view: &View, dimension: usize) -> Result<Option<CutPlane>, Failure> {
    let argument = options.argument("section");
    if !argument.is_given() {
        return Ok(None);
    }
    if dimension == 2 {
        let failure = argument.wrong(causes::DIMENSION, "is for bodies in space").label("these bodies are plane");
        return Err(failure.hint("leave it out: pictures of the plane show the inside"));
    }
    let plane = options.nested("section")?;
    let (normal, point) = (plane.argument("normal"), plane.argument("point"));
    if !normal.is_given() {
        let failure = argument.wrong(causes::NO_DIRECTION, "has no normal").label("`normal` is missing");
        return Err(failure.hint("write `section: #{ normal: [0, 1, 0] }`, and `point: [x, y, z]` to cut elsewhere than in the middle"));
    }
    let point = if point.is_given() { Some(point.vector(3)?) } else { None };
    let direction = normal.vector(3)?;
    if direction == [0.0; 3] {
        return Err(normal.wrong(causes::NO_DIRECTION, "has no direction").hint("write the normal of the plane, such as `[0, 1, 0]`"));
    }
    let plane = CutPlane::new(point, direction, view).ok_or_else(|| {
        let failure =
            normal.refuse(causes::NO_DIRECTION, "the section is seen from its edge").cause("its plane contains the direction of sight");
        failure.hint("choose another `view`, such as the normal itself")
    })?;
    Ok(Some(plane))
}

/// Names of the bodies that are shown; empty for all.
fn bodies(argument: &Argument, model: &ModelData) -> Result<Vec<String>, Failure> {
    if !argument.is_given() {
        return Ok(Vec::new());
    }
    let wrong = || {
        let failure = argument.wrong(causes::OTHER_OWNER, "must be an array of bodies of this model");
        failure.hint("write `bodies: [body]` with what `add_body` gave, or leave it out to show all")
    };
    let name_of = |value: Dynamic| {
        let name = value.try_cast::<BodyHandle>()?.definition().name;
        model.model.bodies.iter().any(|body| body.name == name).then_some(name)
    };
    let names: Option<Vec<String>> = argument.array()?.into_iter().map(name_of).collect();
    names.filter(|names| !names.is_empty()).ok_or_else(wrong)
}

/// Returns the view of bodies in space.
fn view(options: &Options, dimension: usize) -> Result<View, Failure> {
    let (argument, up) = (options.argument("view"), options.argument("up"));
    for given in [&argument, &up] {
        if dimension == 2 && given.is_given() {
            let failure = given.wrong(causes::DIMENSION, "is for bodies in space").label("these bodies are plane");
            return Err(failure.cause("`x` points right and `y` up in pictures of the plane").hint("leave it out"));
        }
    }
    let axis = up.text()?;
    let axis = AXES.iter().position(|name| *name == axis).unwrap_or(2);
    if !argument.is_given() {
        return Ok(View::named("iso", axis).unwrap_or_default());
    }
    let value = argument.value();
    if let Ok(name) = value.clone().into_string() {
        return View::named(&name, axis).ok_or_else(|| argument.unknown_choice(&name, &VIEWS));
    }
    if !value.is_array() {
        return Err(argument.wrong_type());
    }
    View::from_direction(argument.vector(3)?, axis).ok_or_else(|| {
        let failure = argument
            .wrong(causes::NO_DIRECTION, "has no direction")
            .label(format!("this is {}", describe(argument.call().engine(), &value)));
        failure.hint("give the direction from the bodies to the viewer, such as `[1, -2, 1]`")
    })
}
