//! Laws of friction, and friction as an option of a contact.

use std::sync::Arc;

use rhai::{EvalAltResult, FnPtr};

use crate::contact::{Coulomb, FrictionCurve, ROUGH};
use crate::dynamics::{Coefficient, Friction};
use crate::script::api::time_functions::{amplitude_of, place_function, points_of};
use crate::script::language::callback::Callback;
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::digits::number_text;
use crate::script::language::prelude::*;
use crate::script::language::values::{as_number, describe};

/// Powers of ten of the slip speeds at which a closure is sampled; 0 is added.
const DECADES: [i32; 2] = [-12, 12];
/// Number of samples per decade of slip speeds.
const SPEEDS: i32 = 128;

/// Largest coefficient of friction without a warning: clean metals in vacuum and soft rubber reach 2 to 3.
const LARGEST: f64 = 3.0;

/// Friction law with its coefficient.
#[derive(Clone)]
pub struct FrictionHandle {
    friction: Friction,
    /// Friction law as written in a script.
    written: String,
}

impl Handle for FrictionHandle {
    const NAME: &'static str = "FrictionLaw";
    const MAKER: &'static str = "make one with `coulomb`, `friction_curve` or `rough`";

    fn describe(&self) -> String {
        self.written.clone()
    }
}

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![coulomb(), friction_curve(), rough()]
}

fn coulomb() -> Function {
    let number = |name, dimension, range, summary, absent| Parameter::number(name, dimension, range, summary).otherwise(absent);
    function(Topic::Contact, "coulomb")
        .summary("Coulomb friction for a contact: the shear stress in sliding is `coefficient` times the pressure")
        .parameters(vec![Parameter::options("coefficient, and what else the shear stress depends on")])
        .keys(vec![
            Parameter::new(
                "coefficient",
                Kind::Either("a number, a time function, or a closure `|t| …` or `|x, y| …`"),
                "the kinetic coefficient, 0 or more",
            )
            .of("1"),
            number("at_rest", "1", Interval::Positive, "the ratio of the static to the kinetic coefficient, 1 or more", "1"),
            number("transition_speed", "length/time", Interval::Positive, "the speed of the transition to sliding", "no transition"),
            Parameter::number("exponent", "1", Interval::Positive, "the exponent of `exp(-(v/transition_speed)^exponent)`").or(1.0),
            Parameter::number("adhesion", "stress", Interval::NonNegative, "the shear stress of sticking surfaces without pressure")
                .or(0.0),
            number("most", "stress", Interval::Positive, "the maximum shear stress", "no bound"),
            Parameter::number("viscosity", "stress*time/length", Interval::NonNegative, "the shear stress per speed of a film").or(0.0),
        ])
        .see_also(&["friction_curve", "rough", "add_contact"])
        .example(
            "print(coulomb(#{ coefficient: 0.3 }));\nlet rubber = coulomb(#{ coefficient: 0.6, at_rest: 1.5, transition_speed: 0.01, \
                  viscosity: 20.0 });",
        )
        .body_with_options(|_, options| {
            let coefficient = coefficient_of(&options.argument("coefficient"))?;
            let static_ratio = options.optional_number("at_rest")?.unwrap_or(1.0);
            let transition = options.optional_number("transition_speed")?;
            if static_ratio < 1.0 {
                let argument = options.argument("at_rest");
                let failure = argument.wrong(causes::OUT_OF_RANGE, "must be 1 or more");
                return Err(failure
                    .label(format!("this is {}", number_text(static_ratio)))
                    .hint("static friction is at least as large as kinetic friction")
                    .into());
            }
            let adhesion = options.number("adhesion")?;
            if let Coefficient::Constant(sliding) = coefficient
                && sliding <= LARGEST
            {
                warn_of_percent(&options.argument("at_rest"), sliding * static_ratio);
            }
            if transition.is_none() && static_ratio != 1.0 {
                let failure = options.argument("at_rest").refuse(causes::OPTIONS_TOGETHER, "`at_rest` needs a `transition_speed`");
                return Err(failure
                    .hint("add the speed of the transition from static to kinetic friction, such as a hundredth of typical sliding speeds")
                    .into());
            }
            let law = Coulomb {
                static_ratio,
                transition_speed: transition.unwrap_or(f64::INFINITY),
                exponent: options.number("exponent")?,
                adhesion,
                most: options.optional_number("most")?.unwrap_or(f64::INFINITY),
                viscosity: options.number("viscosity")?,
            };
            let number = |name: &&str| Some(format!("{name}: {}", number_text(as_number(&options.argument(name).value())?)));
            let others = ["at_rest", "transition_speed", "exponent", "adhesion", "most", "viscosity"];
            let entries: Vec<String> =
                std::iter::once(format!("coefficient: {}", written(&coefficient))).chain(others.iter().filter_map(number)).collect();
            let written = format!("coulomb(#{{ {} }})", entries.join(", "));
            Ok(FrictionHandle { friction: Friction { law: Arc::new(law), coefficient }, written })
        })
}

/// Returns a coefficient as written in a script.
fn written(coefficient: &Coefficient) -> String {
    match coefficient {
        Coefficient::Constant(value) => number_text(*value),
        Coefficient::OverTime(function) => function.describe(),
        Coefficient::OverPlace(function) => function.describe(),
    }
}

fn friction_curve() -> Function {
    function(Topic::Contact, "friction_curve")
        .summary("friction for a contact whose coefficient is any function of the speed with which surfaces slide on each other")
        .parameters(vec![Parameter::new(
            "coefficient",
            Kind::Either("an array of `[speed, coefficient]` pairs or a closure `|v| …`"),
            "the coefficient: linear between pairs and constant beyond them; a closure is evaluated once at 128 speeds in every power of \
             ten",
        )])
        .see_also(&["coulomb", "rough", "add_contact"])
        .example(
            "let measured = friction_curve([[0.0, 0.45], [0.05, 0.32], [1.0, 0.3]]);
                  let stribeck = friction_curve(|v| 0.2 + 0.1 * exp(-v / 0.01) + 0.05 * v);",
        )
        .body(|call| {
            let argument = call.argument("coefficient");
            let value = argument.value();
            let (points, written) = match value.read_lock::<FnPtr>() {
                Some(function) => {
                    argument.check_parameters(&function, "|v|")?;
                    (sampled(&argument, &Callback::new(call, function.clone()))?, "friction_curve(|v| …)".to_string())
                }
                None => {
                    let points = points_of(&argument, ["speed", "coefficient"])?;
                    let count = points.len();
                    (points, format!("friction_curve([… {count} pairs …])"))
                }
            };
            let least = points.iter().map(|(_, coefficient)| *coefficient).fold(f64::INFINITY, f64::min);
            let Some(curve) = FrictionCurve::new(points) else {
                let failure = argument.refuse(
                    causes::OUT_OF_RANGE,
                    "speeds and coefficients of `friction_curve` must be 0 or more, and at least one pair is needed",
                );
                return Err(failure.hint("write `[[0.0, 0.45], [1.0, 0.3]]`").into());
            };
            warn_of_percent(&argument, if least.is_finite() { least } else { 0.0 });
            let friction = Friction { law: Arc::new(curve), coefficient: Coefficient::Constant(1.0) };
            Ok(FrictionHandle { friction, written })
        })
}

/// Samples a closure of the slip speed at many speeds, as a piecewise linear law.
fn sampled(argument: &Argument, closure: &Callback) -> Result<Vec<(f64, f64)>, Box<EvalAltResult>> {
    let powers = (DECADES[0] * SPEEDS..=DECADES[1] * SPEEDS).map(|k| 10f64.powf(f64::from(k) / f64::from(SPEEDS)));
    let coefficient = |speed: f64| {
        let value = closure.call([Dynamic::from(speed)])?;
        match as_number(&value) {
            Some(number) if number.is_finite() && number >= 0.0 => Ok((speed, number)),
            _ => {
                let failure = argument.wrong(causes::OUT_OF_RANGE, "must give a coefficient of 0 or more");
                let given = describe(argument.call().engine(), &value);
                Err(failure
                    .label(format!("at the speed {} this gives {given}", number_text(speed)))
                    .hint("write `|v| max(0.0, …)`: it is evaluated for speeds from 0 to 1e12")
                    .into())
            }
        }
    };
    std::iter::once(0.0).chain(powers).map(coefficient).collect()
}

fn rough() -> Function {
    function(Topic::Contact, "rough")
        .summary(
            "friction of a contact whose surfaces do not slide: a coefficient of 10, so that they slide only where the pressure is very \
             small",
        )
        .see_also(&["coulomb", "friction_curve", "add_contact"])
        .example("print(rough());")
        .body(|_| Ok(FrictionHandle { friction: plain(Coefficient::Constant(ROUGH)), written: "rough()".into() }))
}

/// Description of the option `friction` of a contact.
pub fn friction_parameter() -> Parameter {
    Parameter::new(
        "friction",
        Kind::Either("a coefficient, `coulomb(…)`, `friction_curve(…)`, `rough()` or `\"none\"`"),
        "the friction law: a number is the coefficient of Coulomb's law",
    )
    .otherwise("none: surfaces slide freely")
}

/// Returns the friction law in the options.
pub fn friction_of(options: &Options) -> Result<Option<Friction>, Failure> {
    let argument = options.argument("friction");
    if !argument.is_given() {
        return Ok(None);
    }
    let value = argument.value();
    if let Some(FrictionHandle { friction, .. }) = value.clone().try_cast::<FrictionHandle>() {
        return Ok(Some(friction));
    }
    if let Ok(word) = value.clone().into_string() {
        return match word.as_str() {
            "none" => Ok(None),
            "rough" => Ok(Some(plain(Coefficient::Constant(ROUGH)))),
            _ => Err(argument.wrong_type()),
        };
    }
    coefficient_of(&argument).map(plain).map(Some)
}

/// Returns Coulomb's law with a constant friction coefficient.
fn plain(coefficient: Coefficient) -> Friction {
    Friction { law: Arc::new(Coulomb::default()), coefficient }
}

/// Warns of an implausibly large coefficient, which may be a percentage.
fn warn_of_percent(argument: &Argument, coefficient: f64) {
    if coefficient > LARGEST {
        let title = format!("{} is a coefficient of friction that no surfaces have", number_text(coefficient));
        let warning = Diagnostic::warning(title, argument.call().place(&argument.target())).code("C0426");
        let (percent, ratio) = (number_text(coefficient), number_text(coefficient / 100.0));
        let cause = format!("a coefficient is shear stress over pressure, and {percent} per cent are {ratio}");
        argument
            .call()
            .host
            .warn(warning.cause(cause).hint("write the ratio, such as `0.3`, and `rough()` for surfaces that do not slide"));
    }
}

/// A coefficient of friction.
fn coefficient_of(argument: &Argument) -> Result<Coefficient, Failure> {
    let value = argument.value();
    if let Some(number) = as_number(&value) {
        return match number.is_finite() && number >= 0.0 {
            true => {
                warn_of_percent(argument, number);
                Ok(Coefficient::Constant(number))
            }
            false => Err(argument.out_of_range(Interval::NonNegative, &number_text(number))),
        };
    }
    if let Some(function) = value.read_lock::<FnPtr>()
        && argument.check_parameters(&function, "|x, y|").is_ok()
    {
        return Ok(Coefficient::OverPlace(place_function(argument.call(), function.clone())));
    }
    amplitude_of(argument).map(Coefficient::OverTime)
}
