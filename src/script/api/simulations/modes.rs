//! `sim.modes`: natural vibrations as an object with arrays, pictures, movies and files of the shapes.

use std::f64::consts::TAU;
use std::rc::Rc;
use std::sync::Arc;

use super::handle::SimulationHandle;
use super::pictures::{keys, shown};
use crate::dynamics::{BodyFields, LedgerRow, LoadKind, Mode, Modes, ModesError, PlacedObstacle};
use crate::math::tolerances::EFFECTIVE_MASS;
use crate::output::{Field, Frame, MovieFormat, PictureBounds, PictureOptions, movie, picture, sight};
use crate::script::api::examples::plate_example;
use crate::script::api::files::writing::{path_parameter, write, write_drawing};
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::digits::brief;
use crate::script::language::prelude::*;

/// Largest number of modes: each needs several vectors of the model's size.
const MOST: f64 = 1000.0;

/// Default of the largest deflection in pictures of a mode, relative to the extent of the bodies.
const DEFLECTION: f64 = 0.1;

/// Number of pictures per period in a movie of a mode.
const PICTURES: usize = 24;

/// Natural vibrations of a simulation at a state.
pub struct ModesData {
    modes: Modes,
    /// Simulation, in whose folder files are written.
    simulation: SimulationHandle,
    /// Bodies in the state of the search, with zero displacement.
    bodies: Vec<BodyFields>,
    /// Obstacles in the state of the search.
    obstacles: Vec<PlacedObstacle>,
    /// Ratio of the script's unit of time to that of the solver.
    unit: f64,
}

/// Natural vibrations as an object of the language.
#[derive(Clone)]
pub struct ModesHandle(Rc<ModesData>);

impl Handle for ModesHandle {
    const NAME: &'static str = "Modes";
    const MAKER: &'static str = "take those of a simulation: `sim.modes(#{ count: 6 })`";

    fn describe(&self) -> String {
        let Modes { time, modes, mass, directions, .. } = &self.0.modes;
        let axes = directions.iter().map(|&i| format!("{:>12}", format!("mass_{}", ["x", "y", "z"][i]))).collect::<String>();
        let mut lines = vec![
            format!(
                "{} modes of \"{}\" at t = {}, mass {}",
                modes.len(),
                self.0.simulation.0.name,
                brief(time / self.0.unit),
                brief(*mass)
            ),
            format!("  mode   frequency     angular{axes}"),
        ];
        for (number, mode) in modes.iter().enumerate() {
            // Effective masses that vanish by symmetry have round-off values, which are printed as 0.
            let moved = |share: &f64| if *share > EFFECTIVE_MASS * mass { brief(*share) } else { "0".into() };
            let masses = mode.effective_mass.iter().map(|share| format!("{:>12}", moved(share))).collect::<String>();
            let [frequency, angular] = [mode.frequency(), mode.angular_frequency()].map(|value| brief(value * self.0.unit));
            let unstable =
                if mode.eigenvalue < 0.0 { format!("  grows with {}", brief(mode.growth() * self.0.unit)) } else { String::new() };
            lines.push(format!("  {number:>4}{frequency:>12}{angular:>12}{masses}{unstable}"));
        }
        lines.join("\n")
    }

    fn instead_of_property(name: &str) -> Option<String> {
        let instead = match name {
            "frequency" => "write `modes.frequencies[0]` for that of the first mode",
            "shapes" => "write `modes.shape(0, body)` for that of the first mode",
            "effective_mass" => "write `modes.effective_masses[0]` for those of the first mode along each axis",
            "len" => "write `modes.count` for their number",
            _ => return None,
        };
        Some(instead.into())
    }
}

impl ModesHandle {
    /// Mode selected by the argument or option `mode`.
    fn chosen(&self, call: &Call, options: Option<&Options>) -> Result<(usize, &Mode), Failure> {
        let argument = options.map_or_else(|| call.argument("mode"), |options| options.argument("mode"));
        let number = argument.integer()?;
        let modes = &self.0.modes.modes;
        match usize::try_from(number).ok().and_then(|index| Some((index, modes.get(index)?))) {
            Some(found) => Ok(found),
            None => {
                let failure =
                    argument.refuse(causes::NO_SUCH, format!("there is no mode {number}: they are numbered from 0 to {}", modes.len() - 1));
                Err(failure.hint("request more with `count` of `sim.modes`"))
            }
        }
    }

    /// Bodies displaced by a mode times a factor.
    fn moved(&self, mode: &Mode, factor: f64) -> Vec<BodyFields> {
        let with_shape = |(body, shape): (&BodyFields, &Vec<[f64; 3]>)| {
            let displacement = shape.iter().map(|x| x.map(|x| factor * x)).collect();
            BodyFields { displacement, ..body.clone() }
        };
        self.0.bodies.iter().zip(&mode.shape).map(with_shape).collect()
    }

    /// Returns the options of pictures, and the largest deflection in them.
    fn shown(&self, options: &Options) -> Result<(PictureOptions, f64), Failure> {
        let mut shown = shown(options, &self.0.simulation.0)?;
        // The size of a shape is arbitrary, and so are its units.
        if !options.argument("unit").is_given() {
            shown.panels.iter_mut().for_each(|panel| panel.unit.clear());
        }
        if !options.argument("vector_unit").is_given() {
            shown.vectors.iter_mut().for_each(|(_, unit)| unit.clear());
        }
        if let Some(displacement) = Field::from_name("displacement").filter(|_| !options.argument("field").is_given()) {
            shown.panels.iter_mut().for_each(|panel| panel.field = displacement);
        }
        let argument = options.argument("deflection");
        let extent = |i: usize| {
            let places = || self.0.bodies.iter().flat_map(|body| body.mesh.points.iter().map(move |point| point[i]));
            places().fold(f64::NEG_INFINITY, f64::max) - places().fold(f64::INFINITY, f64::min)
        };
        let deflection = if argument.is_given() { argument.number()? } else { DEFLECTION * (0..3).map(extent).fold(0.0, f64::max) };
        Ok((shown, deflection))
    }

    /// The text above pictures of a mode.
    fn title(&self, options: &Options, number: usize, mode: &Mode) -> Result<String, Failure> {
        let argument = options.argument("title");
        if argument.is_given() {
            return argument.text();
        }
        let what = if mode.eigenvalue < 0.0 {
            format!("grows with {}", brief(mode.growth() * self.0.unit))
        } else {
            format!("frequency {}", brief(mode.frequency() * self.0.unit))
        };
        Ok(format!("{}, mode {number}: {what}", self.0.simulation.0.name))
    }
}

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    let mut all = vec![modes()];
    all.extend(properties());
    all.extend([shape(), picture_function(), movie_function(), write_function()]);
    all
}

/// An example with the modes of a clamped plate.
fn modes_example(line: &str) -> std::borrow::Cow<'static, str> {
    plate_example(&format!(
        "press.fix(plate.boundary(\"left\"));\nlet sim = simulate(press, #{{ integrator: energy_momentum(), dt: 0.001 }});\n\
         let modes = sim.modes(#{{ count: 3 }});\n{line}"
    ))
}

fn modes() -> Function {
    let count = Parameter::integer("count", "how many, the slowest first").within(Interval::Closed(1.0, MOST));
    method_of::<SimulationHandle>(Topic::Results, "modes")
        .summary(
            "the slowest natural vibrations about the present state, undeformed or settled under load: with its stresses, with ties and \
             closed contacts as constraints, sticking friction held; viscosity and sliding friction are left out, prescribed nodes stand \
             still; the state stays as it is",
        )
        .parameters(vec![Parameter::options("how many").otherwise("#{ count: 6 }").keys(vec![count.or(6)])])
        .see_also(&["settle", "frequencies", "shape"])
        .example(modes_example("print(modes);\nprint(modes.frequencies[0]);"))
        .body_with_options(|call, handle, options| {
            let count = options.argument("count").integer()?;
            handle.refuse_in_check(call)?;
            handle.looked()?;
            let found = handle.found(call, "modes", |simulation| {
                let modes = simulation.modes(count as usize)?;
                let mut bodies = simulation.fields();
                bodies.iter_mut().for_each(at_place);
                Ok((modes, bodies, simulation.obstacles(), sliding(simulation.row())))
            })?;
            let (modes, bodies, obstacles, sliding) = found.map_err(|error| refused(call, &handle, error))?;
            warn(call, &handle, &modes, sliding);
            let unit = handle.0.motion.map_or(1.0, |motion| motion.units.time);
            Ok(ModesHandle(Rc::new(ModesData { modes, simulation: handle, bodies, obstacles, unit })))
        })
}

/// Number of sliding nodes in contacts with friction, by the history row of a state.
fn sliding(row: &LedgerRow) -> usize {
    row.contacts.iter().map(|contact| contact.sliding).sum()
}

/// Replaces the undeformed configuration of a body by its present one.
fn at_place(body: &mut BodyFields) {
    let mut mesh = (*body.mesh).clone();
    mesh.points = (0..mesh.points.len()).map(|node| body.position(node)).collect();
    body.displacement.fill([0.0; 3]);
    body.mesh = Arc::new(mesh);
}

/// Returns the failure of a search for modes, or of another analysis that uses the same matrix.
pub(super) fn refused(call: &Call, handle: &SimulationHandle, error: ModesError) -> Failure {
    let (title, code) = (error.to_string(), error.code());
    let failure = match error {
        ModesError::Step(error) => handle.step_failure(call, error),
        ModesError::Dependent => call
            .fail(title)
            .cause("supports, ties, closed contacts and sticking friction hold some nodes more than once")
            .hint("leave one of them out, or give the contact a `penalty`"),
        ModesError::TooMany { motions: 0, .. } => call.fail(title).hint("free some of the boundaries"),
        ModesError::TooMany { motions, .. } => call.fail(title).hint(format!("request at most {motions} with `count`")),
        ModesError::NotFound { .. } => call.fail(title).hint("request fewer with `count`, or refine the mesh"),
    };
    failure.code(code)
}

/// Warns of effects that the modes neglect.
fn warn(call: &Call, handle: &SimulationHandle, modes: &Modes, sliding: usize) {
    let warning = |title: String| Diagnostic::warning(title, call.place(&Target::Call));
    let unstable = modes.modes.iter().filter(|mode| mode.eigenvalue < 0.0).count();
    if unstable > 0 {
        let title = match unstable {
            1 => "the state is unstable: a small motion grows in the shape of mode 0".to_string(),
            many => format!("the state is unstable: small motions grow in the shapes of the first {many} modes"),
        };
        let cause = "the square of their frequency is negative, as where a structure buckles or is no equilibrium";
        call.host.warn(
            warning(title).code("C0705").cause(cause).hint("`growths` has the growth rates; for vibrations `settle` under a smaller load"),
        );
    }
    if !modes.is_complete {
        let title = "it could not be counted whether modes between these are missing".to_string();
        call.host.warn(
            warning(title).code("C0706").cause("the factors of the shifted matrix had replaced pivots").hint("request another `count`"),
        );
    }
    if modes.asymmetry > 0.0 {
        let title = format!("the stiffness is not symmetric, by {} of its size", brief(modes.asymmetry));
        let cause = "pressures on parts of a surface and friction have no potential; modes are those of the symmetric part";
        call.host.warn(warning(title).code("C0707").cause(cause).hint("a run with small steps shows what such forces do"));
    }
    let model = &handle.0.model.model;
    if let Some(load) = model.loads.iter().find(|load| matches!(load.kind, LoadKind::Torque(_))) {
        let title = format!("modes leave out how the torque on \"{}\" turns with it", model.boundary_name(&load.on));
        call.host.warn(
            warning(title).code("C0708").cause("its forces follow the boundary and have no potential").hint("a run shows what it does"),
        );
    }
    warn_of_turning(call, handle);
    warn_of_damping(call, handle, "modes are those of the undamped, relaxed model", "a run shows how vibrations decay");
    if sliding > 0 {
        let title = format!("{sliding} nodes slide against friction: they slide freely in the modes");
        call.host.warn(warning(title).code("C0741").hint("`settle` first where they should stick"));
    }
}

/// Warns of damping in the model that is neglected.
pub(super) fn warn_of_damping(call: &Call, handle: &SimulationHandle, cause: &str, hint: &str) {
    let model = &handle.0.model.model;
    let viscous = model.bodies.iter().find(|body| !body.material.viscosity().is_none());
    let viscous = viscous.map(|body| format!("the viscosity of body \"{}\" is left out", body.name));
    let damper = model.parts.iter().find(|part| part.dissipates()).map(|part| format!("what \"{}\" damps is left out", part.name()));
    for title in viscous.into_iter().chain(damper) {
        call.host.warn(Diagnostic::warning(title, call.place(&Target::Call)).code("C0742").cause(cause).hint(hint));
    }
}

/// Warns of neglected gyroscopic (Coriolis) forces.
pub(super) fn warn_of_turning(call: &Call, handle: &SimulationHandle) {
    if let Some(part) = handle.0.model.model.parts.iter().find(|part| part.is_gyroscopic()) {
        let title = format!("the Coriolis forces of the {} are left out", part.name());
        let cause = "they couple motions a quarter of an oscillation apart; what is there is its centrifugal force";
        call.host.warn(Diagnostic::warning(title, call.place(&Target::Call)).code("C0743").cause(cause).hint("a run shows what they do"));
    }
}

/// The displacements of the nodes of a body in a shape.
pub(super) fn shape_array(shape: &[[f64; 3]], dimension: usize) -> Dynamic {
    shape.iter().map(|x| array_of(x[..dimension].iter().copied())).collect::<Array>().into()
}

fn properties() -> Vec<Function> {
    let of_mode = |name, summary, read: fn(&Mode, f64) -> f64| {
        property(name, "Array", summary, move |data: &ModesData| array_of(data.modes.modes.iter().map(|mode| read(mode, data.unit))))
    };
    let along = |name, summary, read: fn(&Mode) -> &Vec<f64>| {
        let rows =
            move |data: &ModesData| data.modes.modes.iter().map(|mode| array_of(read(mode).iter().copied())).collect::<Array>().into();
        property(name, "Array", summary, rows)
    };
    vec![
        of_mode(
            "frequencies",
            "natural frequencies of all modes in oscillations per time (cycles, not radians), `omega / (2 pi)`, ascending; 0 of rigid \
             motions and of instabilities",
            |mode, unit| mode.eigenvalue.max(0.0).sqrt() * unit / TAU,
        ),
        of_mode("angular_frequencies", "natural frequencies of all modes in radians per time, `omega`", |mode, unit| {
            mode.angular_frequency() * unit
        }),
        of_mode("growths", "rates with which small motions grow in an unstable state; 0 of vibrations", |mode, unit| mode.growth() * unit),
        of_mode("modal_masses", "masses of all modes, `x^T M x` with shapes whose largest displacement is 1", |mode, _| mode.modal_mass),
        along(
            "participation",
            "participation factors of each mode, `x^T M e / x^T M x` along each axis; of bodies of revolution along theirs alone",
            |mode| &mode.participation,
        ),
        along(
            "effective_masses",
            "mass that each mode moves along each axis, `(x^T M e)^2 / x^T M x`; of all modes together the mass that is free to move",
            |mode| &mode.effective_mass,
        ),
        property("mass", "number", "mass of the model", |data| data.modes.mass.into()),
        property("count", "int", "how many modes there are", |data| (data.modes.modes.len() as i64).into()),
        property("work", "Array", "factorizations and solutions that the modes took", |data| {
            array_of(data.modes.work.iter().map(|&count| count as i64))
        }),
    ]
}

fn property(name: &'static str, returns: &'static str, summary: &'static str, read: impl Fn(&ModesData) -> Dynamic + 'static) -> Function {
    property_of::<ModesHandle>(Topic::Results, name)
        .summary(summary)
        .returns(returns)
        .see_also(&["modes"])
        .example(modes_example(&format!("print(modes.{name});")))
        .body(move |_, modes| Ok(read(&modes.0)))
}

/// Argument that selects a mode by its number.
fn mode_parameter() -> Parameter {
    Parameter::integer("mode", "number of the mode, from 0").within(Interval::Closed(0.0, MOST))
}

fn shape() -> Function {
    use crate::script::api::models::handle::BodyHandle;
    method_of::<ModesHandle>(Topic::Results, "shape")
        .summary(
            "the displacements of the nodes of a body in a mode, in the order of `sim.field(\"position\", body)`; the largest of the whole \
             model is of length 1",
        )
        .parameters(vec![mode_parameter(), Parameter::object::<BodyHandle>("body", "the body")])
        .returns("Array")
        .see_also(&["modes", "field"])
        .example(modes_example("print(modes.shape(0, plate)[2]);"))
        .body(|call, modes| {
            let (_, mode) = modes.chosen(call, None)?;
            let (index, dimension) = (modes.0.simulation.body_index(call)?, modes.0.simulation.0.model.model.dimension());
            Ok(shape_array(&mode.shape[index], dimension))
        })
}

/// Options of pictures of a mode.
fn picture_keys() -> Vec<Parameter> {
    let mut all = keys();
    for key in &mut all {
        match key.name {
            "field" => key.absent = Absent::Text("displacement"),
            "undeformed" => {
                (key.absent, key.summary) = (Absent::Flag(true), "whether the state about which they vibrate is outlined");
            }
            "title" => key.absent = Absent::Means("name of the simulation, number and frequency"),
            _ => {}
        }
    }
    let deflection = Parameter::number("deflection", "length", Interval::Positive, "the largest displacement that is drawn");
    all.splice(0..0, [mode_parameter().or(0), deflection.otherwise("a tenth of the extent of the bodies")]);
    all
}

fn picture_function() -> Function {
    method_of::<ModesHandle>(Topic::Results, "picture")
        .summary("draws the shape of a mode as SVG or PNG, with the options of `sim.picture`")
        .parameters(vec![
            path_parameter("an `.svg` or `.png` file below the output folder"),
            Parameter::options("what is shown").otherwise("#{ mode: 0 }").keys(picture_keys()),
        ])
        .see_also(&["modes", "movie", "picture"])
        .example(modes_example("modes.picture(\"bending.svg\", #{ mode: 1 });"))
        .body_with_options(|call, modes, options| {
            let (number, mode) = modes.chosen(call, Some(&options))?;
            let (mut shown, deflection) = modes.shown(&options)?;
            shown.title = modes.title(&options, number, mode)?;
            let draw = || Ok(picture(&modes.moved(mode, deflection), &modes.0.obstacles, &shown));
            Ok(write_drawing(call, Some(&modes.0.simulation), draw)?)
        })
}

fn movie_function() -> Function {
    let mut options = picture_keys();
    let seconds = "how long a period lasts; it repeats";
    options.push(Parameter::number("seconds", "seconds", Interval::Closed(0.1, 3600.0), seconds).or(2.0));
    method_of::<ModesHandle>(Topic::Results, "movie")
        .summary("draws a period of a mode as an animated PNG or GIF, with the options of `sim.picture`")
        .parameters(vec![
            path_parameter("a `.png` or `.gif` file below the output folder"),
            Parameter::options("what is shown").otherwise("#{ mode: 0 }").keys(options),
        ])
        .see_also(&["modes", "picture", "movie"])
        .example(modes_example("modes.movie(\"bending.gif\", #{ mode: 1, width: 300 });"))
        .body_with_options(|call, modes, options| {
            let (number, mode) = modes.chosen(call, Some(&options))?;
            let (mut shown, deflection) = modes.shown(&options)?;
            shown.title = modes.title(&options, number, mode)?;
            let seconds = options.number("seconds")?;
            let format = if call.text("path")?.ends_with(".gif") { MovieFormat::Gif } else { MovieFormat::Png };
            let content = || {
                let at = |index: usize| modes.moved(mode, deflection * (TAU * index as f64 / PICTURES as f64).cos());
                let extremes = [0, PICTURES / 2].map(|index| sight(&at(index), &modes.0.obstacles, &shown));
                shown.sight = extremes.into_iter().reduce(PictureBounds::with);
                for panel in shown.panels.iter_mut().filter(|panel| panel.field.name() == "displacement") {
                    panel.range = panel.range.or(Some([0.0, deflection]));
                }
                let draw = |index: usize| picture(&at(index), &modes.0.obstacles, &shown);
                let work = move |ask: &dyn Fn(usize) -> Option<crate::output::Drawing>| movie(PICTURES, ask, seconds, format);
                let bytes = call.host.consulted(work, draw)?;
                bytes.ok_or_else(|| call.fail("there is no memory for pictures of this size").hint("choose a smaller `width`"))
            };
            Ok(write(call, Some(&modes.0.simulation), &[".png", ".gif"], content)?)
        })
}

fn write_function() -> Function {
    let options = vec![mode_parameter().or(0)];
    method_of::<ModesHandle>(Topic::Results, "write_fields")
        .summary("writes the shape of a mode as VTU: the bodies as they are, with the shape as their `displacement`")
        .parameters(vec![
            path_parameter("a `.vtu` file below the output folder"),
            Parameter::options("which mode").otherwise("#{ mode: 0 }").keys(options),
        ])
        .see_also(&["modes", "picture", "write_fields"])
        .example(modes_example("modes.write_fields(\"bending.vtu\", #{ mode: 1 });"))
        .body_with_options(|call, modes, options| {
            let (_, mode) = modes.chosen(call, Some(&options))?;
            let content = || Ok(Frame::new(modes.0.modes.time, &modes.moved(mode, 1.0)).encode());
            Ok(write(call, Some(&modes.0.simulation), &[".vtu"], content)?)
        })
}
