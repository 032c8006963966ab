//! Checks of values and of failures: `expect`, `expect_close`, `expect_error`.

use rhai::EvalAltResult;

use super::verdicts::{failed, only_listed, passed};
use crate::math::tolerances::CLOSE;
use crate::script::language::digits::{number_text, significant};
use crate::script::language::explain::explain;
use crate::script::language::prelude::*;
use crate::script::language::values::{as_number, describe};

/// `expect`: a condition.
pub fn expect() -> Function {
    function(Topic::Checks, "expect")
        .summary("ends the script with an error when a condition does not hold")
        .parameters(vec![
            Parameter::flag("condition", "the condition"),
            Parameter::text("message", "what is wrong when it does not hold").or("the condition does not hold"),
        ])
        .see_also(&["expect_close", "expect_conserved", "expect_error"])
        .example("let x = 3.0; expect(x > 0.0, `x must be positive, but is ${x}`);")
        .body(|call| {
            let (condition, message) = (call.flag("condition")?, call.text("message")?);
            let text =
                call.place(&Target::Argument(0)).map(|place| place.text[place.range].split_whitespace().collect::<Vec<_>>().join(" "));
            let text = text.unwrap_or_else(|| "the condition".into());
            if only_listed(call, &text) {
                return Ok(());
            }
            if condition {
                passed(call, &format!("ok  {text}"))
            } else {
                Err(failed(call, message).at(Target::Argument(0)).label("this is false").into())
            }
        })
}

/// `expect_close`: two numbers, or two arrays of numbers.
pub fn expect_close() -> Function {
    function(Topic::Checks, "expect_close")
        .summary("ends the script with an error when two numbers (or arrays of numbers) differ by more than a tolerance")
        .parameters(vec![
            Parameter::any("a", "a number or an array of numbers"),
            Parameter::any("b", "what it should be"),
            Parameter::map("tolerances", "the tolerances; one that holds is enough").otherwise("#{ relative: 1e-9 }"),
        ])
        .keys(vec![
            Parameter::number("relative", "1", Interval::NonNegative, "the largest difference, relative to the larger of the two")
                .otherwise("1e-9 when `absolute` is not given either"),
            Parameter::number("absolute", "any", Interval::NonNegative, "the largest difference").otherwise("no absolute tolerance"),
        ])
        .see_also(&["expect"])
        .example("expect_close(0.1 + 0.2, 0.3, #{ relative: 1e-12 });")
        .body(compare)
}

fn compare(call: &Call) -> Result<(), Box<EvalAltResult>> {
    let options = call.options("tolerances")?;
    let (relative, absolute) = (options.optional_number("relative")?, options.optional_number("absolute")?);
    let relative = if relative.is_none() && absolute.is_none() { Some(CLOSE) } else { relative };
    let (a, b) = (numbers(call, "a")?, numbers(call, "b")?);
    let tolerance = match (relative, absolute) {
        (Some(relative), Some(absolute)) => {
            format!("relative tolerance {}, absolute {}", number_text(relative), number_text(absolute))
        }
        (Some(relative), None) => format!("relative tolerance {}", number_text(relative)),
        (None, absolute) => format!("absolute tolerance {}", number_text(absolute.unwrap_or(0.0))),
    };
    let texts =
        [0, 1].map(|index| call.place(&Target::Argument(index)).map(|place| place.text[place.range].to_string()).unwrap_or_default());
    if only_listed(call, &format!("{} is {} ({tolerance})", texts[0], texts[1])) {
        return Ok(());
    }
    if a.len() != b.len() {
        let failure = failed(call, "the two arrays have different lengths").label("compared here");
        return Err(failure.cause(format!("{} and {} entries", a.len(), b.len())).hint("compare arrays of one length").into());
    }
    let mut worst = (0.0, 0.0, 0);
    for (index, (x, y)) in a.iter().zip(&b).enumerate() {
        let (difference, size) = ((x - y).abs(), x.abs().max(y.abs()));
        let share = if difference == 0.0 { 0.0 } else { difference / size };
        let holds = difference == 0.0 || relative.is_some_and(|limit| share <= limit) || absolute.is_some_and(|limit| difference <= limit);
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
}

fn numbers(call: &Call, name: &str) -> Result<Vec<f64>, Failure> {
    let argument = call.argument(name);
    let value = argument.value();
    if let Some(number) = as_number(&value) {
        return Ok(vec![number]);
    }
    let entries: Option<Vec<f64>> = value.read_lock::<rhai::Array>().and_then(|array| array.iter().map(as_number).collect());
    entries.ok_or_else(|| {
        let failure = argument.wrong(causes::WRONG_TYPE, "must be a number or an array of numbers");
        failure.label(format!("this is {}", describe(call.engine(), &value)))
    })
}

/// `expect_error`: requires that a closure fails.
pub fn expect_error() -> Function {
    function(Topic::Checks, "expect_error")
        .summary("ends the script with an error unless a closure fails with a message that contains a text")
        .parameters(vec![
            Parameter::new("action", Kind::Closure("||"), "what should fail"),
            Parameter::text("text", "a part of the message").or(""),
        ])
        .see_also(&["expect"])
        .example("expect_error(|| ring(#{ inner_radius: -1.0, outer_radius: 2.0, cells: [2, 12] }), \"greater than 0\");")
        .body(must_fail)
}

fn must_fail(call: &Call) -> Result<(), Box<EvalAltResult>> {
    let (action, text) = (call.callback("action")?, call.text("text")?);
    let source = call.place(&Target::Argument(0)).map(|place| place.text[place.range].split_whitespace().collect::<Vec<_>>().join(" "));
    let source = source.unwrap_or_default();
    if only_listed(call, &format!("`{source}` fails with \"{text}\"")) {
        return Ok(());
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
    let failure = failed(call, format!("the closure fails, but not with \"{text}\"")).at(Target::Argument(0)).label("this fails otherwise");
    Err(failure.cause(format!("it fails with: {}", diagnostic.title)).into())
}
