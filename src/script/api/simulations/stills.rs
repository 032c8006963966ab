//! Options for the content of stills: recorded states of a run (animation frames), for movies and the report.

use super::local_frames::{Geometry, frame_of, frame_parameters};
use crate::dynamics::Model;
use crate::output::{Field, StillOptions};
use crate::script::language::prelude::*;

/// Keys of the options.
pub(super) fn still_parameters() -> [Parameter; 4] {
    [
        Parameter::integer(
            "stills",
            "how many pictures of the run are kept for movies and the animation of `report.html`; whenever there are more, every second \
             one is dropped",
        )
        .within(Interval::Closed(2.0, 5000.0))
        .otherwise("160, and fewer of large models"),
        Parameter::flag(
            "stills_inside",
            "whether these pictures have the inside of bodies in space, for movies with a `section` and for the colors of cuts in \
             `report.html`",
        )
        .or(false),
        Parameter::array(
            "stills_fields",
            "names of further fields for movies and the colors of `report.html`, of those that `picture` takes, such as \
             `[\"energy_density\", \"acceleration\", \"strain_xx\"]` (all strains) or `[\"stress_tt\"]`",
        )
        .otherwise("stress, displacement, velocity and contact pressure"),
        Parameter::map("stills_frame", "the axis and direction of `stress_tt`, `strain_along` and the like in `report.html`")
            .otherwise("about the third axis through the origin")
            .keys(frame_parameters().into()),
    ]
}

/// Content of the stills (recorded animation frames) that options request.
///
/// # Errors
/// An unknown field, or a frame that the model cannot have.
pub(super) fn still_options(options: &Options, model: &Model) -> Result<StillOptions, Failure> {
    let (most, named) = (options.argument("stills"), options.argument("stills_fields"));
    let most = if most.is_given() { Some(most.integer()? as usize) } else { None };
    let names = if named.is_given() { named.array()? } else { Vec::new() };
    let field_of = |name: Dynamic| {
        let name = name.into_string().map_err(|_| named.wrong_type())?;
        Field::from_name(&name).ok_or_else(|| named.unknown_choice(&name, &Field::names()))
    };
    let fields = names.into_iter().map(field_of).collect::<Result<_, Failure>>()?;
    let frame = frame_of(&options.nested("stills_frame")?, Geometry::of(model))?;
    Ok(StillOptions { most, has_inside: options.flag("stills_inside")?, fields, frame })
}
