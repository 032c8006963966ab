//! `sim.movie`: the stills of a run as an animated PNG or GIF.

use super::handle::SimulationHandle;
use super::pictures::{keys, shown};
use super::writing::write_course;
use crate::output::{Drawing, Field, MovieFormat, PictureBounds, PictureOptions, Still, movie, picture, shapes, sight};
use crate::script::api::examples::flight_example;
use crate::script::api::files::writing::path_parameter;
use crate::script::language::digits::brief;
use crate::script::language::prelude::*;

/// Function `sim.movie` of scripts.
pub(super) fn movie_function() -> Function {
    let mut options = keys();
    let seconds = "how long it lasts; all pictures are shown equally long, and it repeats";
    options.push(Parameter::number("seconds", "seconds", Interval::Closed(0.1, 3600.0), seconds).or(8.0));
    method_of::<SimulationHandle>(Topic::Results, "movie")
        .summary(
            "draws the run so far as an animated PNG or GIF, with the options of `picture`, in one view and with one color range for all \
             of it; its pictures are those of the animation in `report.html` (`stills` of `simulate`)",
        )
        .parameters(vec![
            path_parameter("a `.png` or `.gif` file below the output folder"),
            Parameter::options("what is shown").otherwise("#{ field: \"von_mises\" }").keys(options),
        ])
        .see_also(&["picture", "report", "simulate"])
        .example(flight_example("sim.run_to(0.05);\nsim.movie(\"flight.gif\", #{ field: \"velocity\", seconds: 2, width: 400 });"))
        .body_with_options(|call, handle, options| {
            let title = options.argument("title").given(Argument::text)?;
            let shown = shown(&options, &handle.0)?;
            if shown.section.is_some() && !handle.0.keeping.stills.has_inside {
                let failure = options.argument("section").refuse(causes::BODY_KIND, "the stills of this run have no inside");
                let failure = failure.cause("of bodies in space the surface alone is recorded");
                return Err(failure.hint("write `stills_inside: true` into the options of `simulate`").into());
            }
            let colors = shown.panels.iter().map(|panel| ("field", panel.field));
            let arrows = shown.vectors.iter().filter_map(|(vectors, _)| Some(("vectors", vectors.field()?)));
            let keeping = &handle.0.keeping.stills;
            if let Some((option, field)) = colors.chain(arrows).find(|(_, field)| !keeping.keeps(*field)) {
                let failure = options
                    .argument(option)
                    .refuse(causes::NO_SUCH, format!("the stills of this run do not have the field \"{}\"", field.name()));
                let failure = failure.cause("displacement, velocity, stress and contact pressure are recorded, others on request");
                return Err(failure.hint(format!("write `stills_fields: [\"{}\"]` into the options of `simulate`", field.name())).into());
            }
            let seconds = options.number("seconds")?;
            Ok(write_course(call, &handle, &[".png", ".gif"], || drawn(call, &handle, shown, title.as_deref(), seconds))?)
        })
}

/// Returns the bytes of the movie; `None` if the session writes no files, so that there is no recording.
fn drawn(call: &Call, handle: &SimulationHandle, mut shown: PictureOptions, title: Option<&str>, seconds: f64) -> Result<Vec<u8>, Failure> {
    let format = if call.text("path")?.ends_with(".gif") { MovieFormat::Gif } else { MovieFormat::Png };
    let row = handle.0.history.borrow().len() - 1;
    let artifacts = handle.0.artifacts.borrow();
    let Some(artifacts) = artifacts.as_ref() else { return Ok(Vec::new()) };
    let stills = handle.with(call, |simulation| artifacts.stills(simulation, row))?;
    let model = &handle.0.model.model;
    let (skins, shapes) = (artifacts.recording().bodies(), shapes(model));
    let at = |still: &Still| (still.fields(&model.bodies, skins), still.placed(&shapes));
    for panel in &mut shown.panels {
        let place = Field::BASIC.iter().position(|name| *name == panel.field.name());
        let extremes = |still: &Still| match place {
            Some(place) => still.extremes[place],
            None => {
                let bodies = still.fields(&model.bodies, skins);
                let recorded = bodies.iter().zip(skins).flat_map(|(body, skin)| skin.nodes.iter().map(move |&node| (body, node as usize)));
                let values = recorded.map(|(body, node)| panel.field.value(body, node, &panel.frame));
                values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
            }
        };
        let ranges = stills.iter().map(|still| extremes(still));
        let [low, high] = ranges.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], [low, high]| [a.min(low), b.max(high)]);
        panel.range = panel.range.or((low <= high).then_some([low, high]));
    }
    let seen = |still: &Still| {
        let (bodies, obstacles) = at(still);
        sight(&bodies, &obstacles, &shown)
    };
    let all = stills.iter().map(|still| seen(still)).reduce(PictureBounds::with);
    shown.sight = all;
    let draw = |index: usize| {
        let still = &stills[index];
        let (bodies, obstacles) = at(still);
        let title = title.map_or_else(|| format!("{} at t = {}", handle.0.name, handle.0.told(brief(still.time), "time")), String::from);
        picture(&bodies, &obstacles, &PictureOptions { title, ..shown.clone() })
    };
    let count = stills.len();
    let bytes = call.host.consulted(move |ask: &dyn Fn(usize) -> Option<Drawing>| movie(count, ask, seconds, format), draw)?;
    bytes.ok_or_else(|| call.fail("there is no memory for pictures of this size").hint("choose a smaller `width`"))
}
