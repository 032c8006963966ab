//! Checks: what a script expects of its results. One that holds says what it measured; one that does not ends the script.

use rhai::{Dynamic, EvalAltResult};

use super::arguments::{Arguments, Call, as_number, describe};
use super::explain::explain;
use super::failure::{Class, Failure};
use super::numbers::{brief, significant};
use super::registry::{Absent, Form, Function, Handle, Kind, Parameter, Topic, body, number_text};
use super::scan::Target;
use super::simulations::{SimulationHandle, example};
use crate::dynamics::LedgerRow;
use crate::math::catalogue::Interval;
use crate::output::Inertia;

/// The failure of a check.
pub fn failed(call: &Call, title: impl Into<String>) -> Failure {
    Failure::new(Class::Check, title).in_method(call.function.form.receiver().is_some())
}

/// Reports a check that holds.
pub fn passed(call: &Call, line: &str) -> Result<Dynamic, Box<EvalAltResult>> {
    call.host.passed(line, call.place(&Target::Call).as_ref());
    Ok(Dynamic::UNIT)
}

/// In `conserva check`: lists the check instead of evaluating it.
pub fn listed(call: &Call, line: &str) -> bool {
    if call.host.is_check() {
        let place = call.place(&Target::Call).map(|place| format!("{place}: ")).unwrap_or_default();
        call.host.findings.borrow_mut().push(format!("check: {place}{line}"));
    }
    call.host.is_check()
}

/// The functions of this topic.
pub fn functions() -> Vec<Function> {
    vec![expect(), expect_close(), expect_conserved(), expect_contact(), expect_error()]
}

fn expect() -> Function {
    Function {
        name: "expect",
        form: Form::Function,
        topic: Topic::Checks,
        summary: "ends the script with an error when a condition does not hold",
        parameters: vec![
            Parameter::new("condition", Kind::Flag, "the condition"),
            Parameter::new("message", Kind::Text, "what is wrong when it does not hold").or(Absent::Text("the condition does not hold")),
        ],
        returns: "",
        example: "let x = 3.0; expect(x > 0.0, `x must be positive, but is ${x}`);".into(),
        see_also: &["expect_close", "expect_conserved", "expect_error"],
        body: body(|call| {
            let (condition, message) = (call.flag("condition")?, call.text("message")?);
            let text =
                call.place(&Target::Argument(0)).map(|place| place.text[place.range].split_whitespace().collect::<Vec<_>>().join(" "));
            let text = text.unwrap_or_else(|| "the condition".into());
            if listed(call, &text) {
                return Ok(Dynamic::UNIT);
            }
            if condition {
                passed(call, &format!("ok  {text}"))
            } else {
                Err(failed(call, message).at(Target::Argument(0)).label("this is false").into())
            }
        }),
    }
}

fn expect_close() -> Function {
    Function {
        name: "expect_close",
        form: Form::Function,
        topic: Topic::Checks,
        summary: "ends the script with an error when two numbers (or arrays of numbers) differ by more than a tolerance",
        parameters: vec![
            Parameter::new("a", Kind::Any, "a number or an array of numbers"),
            Parameter::new("b", Kind::Any, "what it should be"),
            Parameter::new(
                "tolerances",
                Kind::Options(vec![
                    Parameter::number("relative", "1", Interval::NonNegative, "the largest difference, relative to the larger of the two")
                        .or(Absent::Means("1e-9 when `absolute` is not given either")),
                    Parameter::number("absolute", "any", Interval::NonNegative, "the largest difference")
                        .or(Absent::Means("no absolute tolerance")),
                ]),
                "the tolerances; one that holds is enough",
            )
            .or(Absent::Means("#{ relative: 1e-9 }")),
        ],
        returns: "",
        example: "expect_close(0.1 + 0.2, 0.3, #{ relative: 1e-12 });".into(),
        see_also: &["expect"],
        body: body(|call| {
            let options = call.options("tolerances")?;
            let (relative, absolute) = (options.optional_number("relative")?, options.optional_number("absolute")?);
            let relative = if relative.is_none() && absolute.is_none() { Some(1e-9) } else { relative };
            let (a, b) = (numbers(call, "a")?, numbers(call, "b")?);
            let tolerance = match (relative, absolute) {
                (Some(relative), Some(absolute)) => {
                    format!("relative tolerance {}, absolute {}", number_text(relative), number_text(absolute))
                }
                (Some(relative), None) => format!("relative tolerance {}", number_text(relative)),
                (None, absolute) => format!("absolute tolerance {}", number_text(absolute.unwrap_or(0.0))),
            };
            let texts = [0, 1]
                .map(|index| call.place(&Target::Argument(index)).map(|place| place.text[place.range].to_string()).unwrap_or_default());
            if listed(call, &format!("{} is {} ({tolerance})", texts[0], texts[1])) {
                return Ok(Dynamic::UNIT);
            }
            if a.len() != b.len() {
                let failure = failed(call, "the two arrays have different lengths").label("compared here");
                return Err(failure.cause(format!("{} and {} entries", a.len(), b.len())).hint("compare arrays of one length").into());
            }
            let mut worst = (0.0, 0.0, 0);
            for (index, (x, y)) in a.iter().zip(&b).enumerate() {
                let (difference, size) = ((x - y).abs(), x.abs().max(y.abs()));
                let share = if difference == 0.0 { 0.0 } else { difference / size };
                let holds =
                    difference == 0.0 || relative.is_some_and(|limit| share <= limit) || absolute.is_some_and(|limit| difference <= limit);
                if !holds {
                    let entry = if a.len() > 1 { format!(" in entry {index}") } else { String::new() };
                    return Err(failed(call, format!("{} is {}{entry}, but should be {}", texts[0], number_text(*x), number_text(*y)))
                        .label("not close enough")
                        .cause(format!("they differ by {}, relative {}; {tolerance}", significant(difference, 3), significant(share, 3)))
                        .into());
                }
                if share >= worst.0 {
                    worst = (share, difference, index);
                }
            }
            let share = relative.map_or(String::new(), |_| format!(", relative {}", significant(worst.0, 3)));
            passed(call, &format!("ok  {} = {}: largest difference {}{share}; {tolerance}", texts[0], texts[1], significant(worst.1, 3)))
        }),
    }
}

fn numbers(call: &Call, name: &str) -> Result<Vec<f64>, Failure> {
    let argument = call.argument(name);
    let value = argument.value();
    if let Some(number) = as_number(&value) {
        return Ok(vec![number]);
    }
    let entries: Option<Vec<f64>> = value.read_lock::<rhai::Array>().and_then(|array| array.iter().map(as_number).collect());
    entries.ok_or_else(|| {
        let failure = argument.fail(format!("{} must be a number or an array of numbers", argument.title()));
        failure.label(format!("this is {}", describe(call.engine(), &value)))
    })
}

/// What can be conserved, and what it is called.
const QUANTITIES: &[&str] = &["energy", "momentum", "angular_momentum", "ledger"];

fn expect_conserved() -> Function {
    Function {
        name: "expect_conserved",
        form: Form::Function,
        topic: Topic::Checks,
        summary: "ends the script with an error when a quantity drifts by more than a relative tolerance; \"ledger\" asks \
                  whether the energy balance of every step closes",
        parameters: vec![
            Parameter::new("simulation", Kind::Handle(SimulationHandle::NAME), "the simulation"),
            Parameter::new("quantity", Kind::Choice(QUANTITIES), "what should be conserved"),
            Parameter::new(
                "options",
                Kind::Options(vec![
                    Parameter::number("after", "time", Interval::Finite, "the time from which it should be constant")
                        .or(Absent::Number(0.0)),
                    Parameter::number("tolerance", "1", Interval::NonNegative, "the largest drift, relative to the size of the quantity"),
                ]),
                "from when and how well",
            ),
        ],
        returns: "",
        example: example("sim.run_to(0.05);\nexpect_conserved(sim, \"energy\", #{ after: 0.0, tolerance: 1e-10 });"),
        see_also: &["expect_close", "history"],
        body: body(|call| {
            let (handle, quantity, options) =
                (call.handle::<SimulationHandle>("simulation")?, call.text("quantity")?, call.options("options")?);
            let (after, tolerance) = (options.number("after")?, options.number("tolerance")?);
            let what = format!("{} of \"{}\" after t = {}", title(&quantity), handle.0.name, number_text(after));
            if listed(call, &format!("{what} drifts by at most {}", number_text(tolerance))) {
                return Ok(Dynamic::UNIT);
            }
            let rows = handle.0.history.borrow();
            // A time that steps of round sizes were to meet is met up to round-off.
            let last = rows.iter().rposition(|row| row.time <= after + 1e-9 * after.abs().max(row.dt)).unwrap_or(0);
            let window = &rows[last..];
            if window.len() < 2 {
                let failure = failed(call, format!("the simulation \"{}\" took no step after t = {}", handle.0.name, number_text(after)));
                let end = rows.last().map_or(0.0, |row| row.time);
                return Err(failure
                    .cause(format!("it ended at t = {}", number_text(end)))
                    .hint("run it longer, or choose an earlier `after`")
                    .into());
            }
            let drift = worst_drift(&quantity, window, &rows, Inertia::of(&handle.0.model.model));
            let measured =
                format!("{what} drifts by {} at most, at step {} (t = {})", significant(drift.size, 3), drift.step, brief(drift.time));
            if drift.size <= tolerance {
                return passed(call, &format!("ok  {measured}; tolerance {}", number_text(tolerance)));
            }
            let failure = failed(call, format!("{} of \"{}\" is not conserved", title(&quantity), handle.0.name))
                .label(format!("tolerance {}", number_text(tolerance)));
            let failure = failure.cause(measured).cause(format!(
                "relative to {}; its first value in this time is {}",
                brief(drift.scale),
                brief(drift.first)
            ));
            let hint = match quantity.as_str() {
                "energy" if window[1..].iter().any(|row| row.load_work != 0.0) => "a load does work in this time: choose a later `after`",
                "energy" if window[1..].iter().any(|row| row.contact_work != 0.0) => {
                    "closing contact costs energy under the update rule \"gap\"; \"ledger\" asks whether all of it is booked"
                }
                "energy" | "ledger" => "only `energy_momentum()` conserves the energy for every step size",
                _ => "supports and loads change momenta",
            };
            Err(failure.hint(hint).into())
        }),
    }
}

fn expect_contact() -> Function {
    Function {
        name: "expect_contact",
        form: Form::Function,
        topic: Topic::Checks,
        summary: "ends the script with an error unless a contact pair was closed after some step (or is closed now)",
        parameters: vec![
            Parameter::new("simulation", Kind::Handle(SimulationHandle::NAME), "the simulation"),
            Parameter::new("name", Kind::Text, "the name of the contact pair"),
            Parameter::new("when", Kind::Choice(&["ever", "now"]), "whether it must have been closed at any time, or must be closed now")
                .or(Absent::Text("ever")),
        ],
        returns: "",
        example: super::contacts::contact_example(
            "press.initial_velocity(plate, #{ linear: [0.0, -1.0] });\nlet sim = simulate(press, #{ integrator: energy_momentum(), \
                                                 dt: 0.001 });\nsim.step(3);\nexpect_contact(sim, \"foot\");",
        ),
        see_also: &["contact", "add_contact"],
        body: body(|call| {
            let (handle, argument, when) = (call.handle::<SimulationHandle>("simulation")?, call.argument("name"), call.text("when")?);
            let name = argument.text()?;
            let names = handle.0.model.model.contact_names();
            let Some(index) = names.iter().position(|contact| *contact == name) else {
                return Err(argument.unknown_name(format!("there is no contact \"{name}\""), &name, &names).into());
            };
            if listed(call, &format!("contact \"{name}\" of \"{}\" closes", handle.0.name)) {
                return Ok(Dynamic::UNIT);
            }
            let (nodes, time) = handle.with(call, |simulation| (simulation.closed_nodes()[index], simulation.time()))?;
            let time = handle.0.history.borrow().last().map_or(time, |row| row.time);
            let since = handle.0.closed_since.borrow()[index];
            match (when.as_str(), since) {
                ("now", _) if nodes > 0 => {
                    passed(call, &format!("ok  contact \"{name}\" is closed at {nodes} nodes at t = {}", brief(time)))
                }
                ("now", Some(since)) => Err(failed(call, format!("contact \"{name}\" is open at t = {}", brief(time)))
                    .cause(format!("it was first closed at t = {}", brief(since)))
                    .hint("ask whether it was closed at any time with \"ever\"")
                    .into()),
                (_, Some(since)) => passed(call, &format!("ok  contact \"{name}\" closed, first seen at t = {}", brief(since))),
                (_, None) => {
                    let failure = failed(call, format!("contact \"{name}\" never closed until t = {}", brief(time)));
                    let gaps = handle.with(call, |simulation| simulation.contact(&name))?.map(|fields| fields.gap).unwrap_or_default();
                    let least = gaps.into_iter().filter(|gap| gap.is_finite()).reduce(f64::min);
                    let failure = failure.cause(match least {
                        Some(least) => format!("the smallest gap at this time is {}", brief(least)),
                        None => "no node of its secondary side lies opposite its primary side".into(),
                    });
                    Err(failure.hint("check the positions and velocities of the two bodies, and how far the simulation runs").into())
                }
            }
        }),
    }
}

struct Drift {
    size: f64,
    scale: f64,
    first: f64,
    step: usize,
    time: f64,
}

fn title(quantity: &str) -> &'static str {
    match quantity {
        "energy" => "the energy",
        "momentum" => "the linear momentum",
        "angular_momentum" => "the angular momentum",
        _ => "the energy balance",
    }
}

fn length([x, y, z]: [f64; 3]) -> f64 {
    x.hypot(y).hypot(z)
}

/// The largest drift of a quantity over a window of rows, relative to its scale: the largest energy, or the momentum that the bodies
/// would have if all their kinetic energy were translation.
fn worst_drift(quantity: &str, window: &[LedgerRow], rows: &[LedgerRow], inertia: Inertia) -> Drift {
    let largest =
        |values: &mut dyn Iterator<Item = f64>| values.fold(0.0_f64, |largest, value| if value <= largest { largest } else { value });
    let kinetic = largest(&mut rows.iter().map(|row| row.kinetic));
    let bound = (2.0 * inertia.mass * kinetic).max(0.0).sqrt();
    let first = &window[0];
    let difference = |a: [f64; 3], b: [f64; 3]| length([a[0] - b[0], a[1] - b[1], a[2] - b[2]]);
    let energy = largest(&mut window.iter().map(|row| row.kinetic + row.strain + row.potential.abs()));
    let (scale, value, change): (f64, f64, Vec<f64>) = match quantity {
        "energy" => (energy, first.total(), window.iter().map(|row| (row.total() - first.total()).abs()).collect()),
        "momentum" => (
            largest(&mut window.iter().map(|row| length(row.momentum))).max(bound),
            length(first.momentum),
            window.iter().map(|row| difference(row.momentum, first.momentum)).collect(),
        ),
        "angular_momentum" => (
            largest(&mut window.iter().map(|row| length(row.angular_momentum))).max(bound * inertia.radius),
            length(first.angular_momentum),
            window.iter().map(|row| difference(row.angular_momentum, first.angular_momentum)).collect(),
        ),
        _ => (
            energy,
            first.total(),
            window.iter().enumerate().map(|(index, row)| if index == 0 { 0.0 } else { row.energy_defect.abs() }).collect(),
        ),
    };
    // In this order a value that is no number is the largest, so a broken run cannot pass.
    let worst = (0..change.len()).max_by(|&a, &b| change[a].total_cmp(&change[b])).unwrap_or(0);
    let size = if change[worst] == 0.0 { 0.0 } else { change[worst] / scale };
    Drift { size, scale, first: value, step: window[worst].step, time: window[worst].time }
}

fn expect_error() -> Function {
    Function {
        name: "expect_error",
        form: Form::Function,
        topic: Topic::Checks,
        summary: "ends the script with an error unless a closure fails with a message that contains a text",
        parameters: vec![
            Parameter::new("action", Kind::Closure("||"), "what should fail"),
            Parameter::new("text", Kind::Text, "a part of the message").or(Absent::Text("")),
        ],
        returns: "",
        example: "expect_error(|| ring(#{ inner_radius: -1.0, outer_radius: 2.0, cells: [2, 12] }), \"greater than 0\");".into(),
        see_also: &["expect"],
        body: body(|call| {
            let (action, text) = (call.callback("action")?, call.text("text")?);
            let source =
                call.place(&Target::Argument(0)).map(|place| place.text[place.range].split_whitespace().collect::<Vec<_>>().join(" "));
            let source = source.unwrap_or_default();
            if listed(call, &format!("`{source}` fails with \"{text}\"")) {
                return Ok(Dynamic::UNIT);
            }
            let error = match action.call([]) {
                Ok(_) => {
                    return Err(failed(call, "the closure did not fail")
                        .at(Target::Argument(0))
                        .label("this runs without an error")
                        .hint("remove the check, or let the closure do what must not work")
                        .into());
                }
                Err(error) if !error.is_catchable() => return Err(error),
                Err(error) => error,
            };
            let diagnostic = explain(call.host, call.engine(), &error, &call.source());
            if diagnostic.contains(&text) {
                return passed(call, &format!("ok  fails as expected: {}", diagnostic.title));
            }
            let failure =
                failed(call, format!("the closure fails, but not with \"{text}\"")).at(Target::Argument(0)).label("this fails otherwise");
            Err(failure.cause(format!("it fails with: {}", diagnostic.title)).into())
        }),
    }
}
