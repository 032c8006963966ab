//! `auto`: adaptive time step size.

use crate::dynamics::{Options, StepControl};
use crate::math::tolerances::STEP_ERROR;
use crate::script::api::examples::FLIGHT;
use crate::script::language::digits::{brief, number_text};
use crate::script::language::prelude::*;

/// Kind of the argument `dt`.
pub const STEP_SIZE: Kind = Kind::Either("a number greater than 0, or `auto()` for steps that choose their size");

/// Control of the time step size as an object of the language, with the size of the first step if given.
#[derive(Clone)]
pub struct StepControlHandle {
    control: StepControl,
    first: Option<f64>,
}

impl Handle for StepControlHandle {
    const NAME: &'static str = "StepControl";
    const MAKER: &'static str = "make one with `auto(#{ tolerance: 1e-4 })`";

    fn describe(&self) -> String {
        let StepControl { tolerance, smallest, largest, plastic_strain } = self.control;
        let bounds = [("first", self.first), ("smallest", smallest), ("largest", largest), ("plastic_strain", plastic_strain)];
        let given = bounds.iter().filter_map(|(name, bound)| bound.map(|bound| format!(", {name}: {}", number_text(bound))));
        format!("auto(#{{ tolerance: {}{} }})", number_text(tolerance), given.collect::<String>())
    }
}

/// Time step size as given by a script.
#[derive(Clone)]
pub enum StepSize {
    /// Constant time step size.
    Fixed(f64),
    /// Chosen step by step.
    Chosen(StepControlHandle),
}

impl StepSize {
    /// Reads an argument of the kind [`STEP_SIZE`].
    ///
    /// # Errors
    /// The argument is of another type or out of range.
    pub fn of(argument: &Argument) -> Result<StepSize, Failure> {
        match argument.value().try_cast::<StepControlHandle>() {
            Some(handle) => Ok(StepSize::Chosen(handle)),
            None => argument.number().map(StepSize::Fixed),
        }
    }

    /// Returns the step size in other units of time, by the conversion factor `unit`.
    pub fn on_clock(self, unit: f64) -> StepSize {
        match self {
            StepSize::Fixed(dt) => StepSize::Fixed(unit * dt),
            StepSize::Chosen(StepControlHandle { control, first }) => {
                let scaled = |bound: Option<f64>| bound.map(|bound| unit * bound);
                let control = StepControl { smallest: scaled(control.smallest), largest: scaled(control.largest), ..control };
                StepSize::Chosen(StepControlHandle { control, first: scaled(first) })
            }
        }
    }

    /// Sets the step size in the options of a simulation; `first` is the default of the first step for adaptive step sizes.
    pub fn put_into(&self, options: &mut Options, first: f64) {
        (options.dt, options.control) = match self {
            StepSize::Fixed(dt) => (*dt, None),
            StepSize::Chosen(StepControlHandle { control, first: given }) => (given.unwrap_or(first), Some(*control)),
        };
    }
}

impl std::fmt::Display for StepSize {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            StepSize::Fixed(dt) => write!(out, "{}", brief(*dt)),
            StepSize::Chosen(handle) => write!(out, "{}", handle.describe()),
        }
    }
}

/// Describes the step size of a simulation; `told` adds the unit of a time.
pub fn step_size(options: &Options, told: impl Fn(String) -> String) -> String {
    let chosen = |control: StepControl| StepControlHandle { control, first: None }.describe();
    options.control.map_or_else(|| told(number_text(options.dt)), chosen)
}

/// Function `auto` of scripts.
pub fn auto() -> Function {
    function(Topic::Simulation, "auto")
        .summary(
            "steps that choose their size, for `dt` of `simulate`: the error of the positions grows by no more than `tolerance` times the \
             path length of the bodies, as far as it can be estimated (`docs/integrators.md`); steps end where a time function has a kink, \
             where frames of the fields are written and where `run_to` stops",
        )
        .parameters(vec![Parameter::options("how accurate steps are, and how long they may be").otherwise("the defaults")])
        .keys(vec![
            Parameter::number(
                "tolerance",
                "1",
                Interval::Open(0.0, 1.0),
                "the growth of the error relative to the path length of the fastest body, both as root mean squares over the mass \
                         of a body",
            )
            .or(STEP_ERROR),
            Parameter::number("first", "time", Interval::Positive, "the size of the first step")
                .otherwise("the root of `tolerance` times the time that sound takes across the smallest cells"),
            Parameter::number(
                "smallest",
                "time",
                Interval::Positive,
                "the smallest size; at this size steps with larger errors are accepted",
            )
            .otherwise("a millionth of the first step"),
            Parameter::number("largest", "time", Interval::Positive, "the largest size: a fraction of the shortest event to be resolved")
                .otherwise("no bound"),
            Parameter::number("plastic_strain", "1", Interval::Positive, "the largest plastic strain of a step at any point of a body")
                .otherwise("no bound"),
        ])
        .see_also(&["simulate", "run_to"])
        .example(format!(
            "{FLIGHT}let sim = simulate(flight, #{{ integrator: energy_momentum(), dt: auto(#{{ tolerance: 1e-4 }}) }});\n\
             sim.run_to(0.1);\nprint(sim.history.dt);"
        ))
        .body(|call| Ok(make(call)?))
}

fn make(call: &Call) -> Result<StepControlHandle, Failure> {
    let options = call.options("options")?;
    let control = StepControl {
        tolerance: options.number("tolerance")?,
        smallest: options.optional_number("smallest")?,
        largest: options.optional_number("largest")?,
        plastic_strain: options.optional_number("plastic_strain")?,
    };
    let first = options.optional_number("first")?;
    let bounds = [("smallest", control.smallest), ("first", first), ("largest", control.largest)];
    let given: Vec<(&str, f64)> = bounds.iter().filter_map(|(name, bound)| bound.map(|bound| (*name, bound))).collect();
    for pair in given.windows(2) {
        let [(less, a), (more, b)] = [pair[0], pair[1]];
        if a > b {
            let failure = options.argument(less).refuse(causes::ORDER, format!("`{less}` of `auto` must not be greater than `{more}`"));
            return Err(failure.label(format!("this is {}, and `{more}` is {}", number_text(a), number_text(b))));
        }
    }
    Ok(StepControlHandle { control, first })
}
