//! `expect_order`: runs a closure with decreasing step sizes, and requires an order of convergence of its result.

use rhai::{Engine, EvalAltResult};

use super::worker_pool::{Results, WorkerPool};
use crate::math::tolerances::ORDER_ROUND_OFF;
use crate::script::api::checks::verdicts::{failed, only_listed, passed};
use crate::script::api::nested_runs::begin_study;
use crate::script::api::simulations::handle::SimulationHandle;
use crate::script::language::digits::{brief, number_text, significant};
use crate::script::language::failure::Class;
use crate::script::language::plain::Plain;
use crate::script::language::prelude::*;
use crate::script::language::values::{as_number, describe};
use crate::script::language::worker_pool::{Computed, Outcome};

/// The function `expect_order`.
pub fn expect_order() -> Function {
    function(Topic::Checks, "expect_order")
        .summary(
            "runs a closure with smaller and smaller steps and ends the script with an error unless its result converges with an order",
        )
        .parameters(vec![
            Parameter::new(
                "action",
                Kind::Closure("|dt|"),
                "computes with a step size; gives a number, an array of numbers, or a simulation, whose final positions are compared",
            ),
            Parameter::number("order", "1", Interval::Positive, "the order: halving the step divides the error by 2^order"),
            Parameter::options("the step sizes"),
        ])
        .keys(vec![
            Parameter::number("dt", "any", Interval::Positive, "the largest step size"),
            Parameter::integer("runs", "the number of step sizes, each half of the one before").within(Interval::Closed(2.0, 12.0)).or(4),
            Parameter::any("exact", "the exact result, a number or an array of numbers")
                .otherwise("results of successive step sizes are compared"),
            Parameter::number("tolerance", "1", Interval::Positive, "the largest deviation of the last order from the expected one")
                .or(0.2),
        ])
        .see_also(&["expect_close", "expect_invariant"])
        .example(
            "// the midpoint rule for y' = y, from 0 to 1\nfn exponential(dt) {\n    \
                      let y = 1.0;\n    \
                      for step in 0..round(1.0 / dt).to_int() { y *= (1.0 + dt / 2.0) / (1.0 - dt / 2.0); }\n    \
                      y\n\
                  }\n\
                  expect_order(|dt| exponential(dt), 2.0, #{ dt: 0.1, exact: exp(1.0) });",
        )
        .body(run_order)
}

fn run_order(call: &Call) -> Result<(), Box<EvalAltResult>> {
    let (order, options) = (call.number("order")?, call.options("options")?);
    let (largest, runs, tolerance) = (options.number("dt")?, options.integer("runs")?, options.number("tolerance")?);
    let exact = exact_of(&options)?;
    if exact.is_none() && runs < 3 {
        let failure = options.argument("runs").refuse(causes::COUNT, "an order needs three runs, or the exact result and two");
        return Err(failure.hint("give `runs: 4`, or `exact: …`").into());
    }
    if only_listed(call, &format!("the closure converges with order {}", number_text(order))) {
        return Ok(());
    }
    let sizes: Vec<f64> = (0..runs).map(|run| largest / f64::powi(2.0, run as i32)).collect();
    let mut results = side_by_side(call, &sizes, exact.as_ref().map(Vec::len))?;
    for &dt in &sizes[results.len()..] {
        results.push(result_of(call, dt, exact.as_deref().or(results.first().map(Vec::as_slice)))?);
    }
    let convergence = Convergence::of(sizes, &results, exact.as_deref());
    if (convergence.order() - order).abs() <= tolerance {
        let errors: Vec<String> = convergence.errors.iter().map(|error| significant(*error, 2)).collect();
        let orders = convergence.shown_orders().join(", ");
        return passed(call, &format!("ok  converges with order {orders} (errors {})", errors.join(", ")));
    }
    Err(convergence.failure(call, order, tolerance).into())
}

fn exact_of(options: &Options) -> Result<Option<Vec<f64>>, Failure> {
    let exact = options.argument("exact");
    if !exact.is_given() {
        return Ok(None);
    }
    let numbers = numbers_in(&exact.value());
    numbers.map(Some).ok_or_else(|| exact.refuse(causes::WRONG_TYPE, "`exact` of `expect_order` must be a number or an array of numbers"))
}

/// Results for decreasing step sizes, with errors and orders of convergence.
struct Convergence {
    sizes: Vec<f64>,
    /// Errors, or differences from the next result if the exact result is unknown.
    errors: Vec<f64>,
    orders: Vec<f64>,
    is_exact_known: bool,
    /// The largest number among the results.
    scale: f64,
}

impl Convergence {
    fn of(sizes: Vec<f64>, results: &[Vec<f64>], exact: Option<&[f64]>) -> Self {
        let errors: Vec<f64> = match exact {
            Some(exact) => results.iter().map(|result| distance(result, exact)).collect(),
            None => results.windows(2).map(|pair| distance(&pair[0], &pair[1])).collect(),
        };
        let orders = errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
        let scale = results.iter().flatten().fold(0.0_f64, |scale, value| scale.max(value.abs()));
        Convergence { sizes, errors, orders, is_exact_known: exact.is_some(), scale }
    }

    /// The order between the two smallest steps.
    fn order(&self) -> f64 {
        self.orders.last().copied().unwrap_or(f64::NAN)
    }

    fn shown_orders(&self) -> Vec<String> {
        self.orders.iter().map(|order| format!("{order:.2}")).collect()
    }

    /// Returns the failure if the order differs from the expected one.
    fn failure(&self, call: &Call, expected: f64, tolerance: f64) -> Failure {
        let (last, shown) = (self.order(), self.shown_orders());
        let title = format!("the closure converges with order {}, not {}", significant(last, 3), number_text(expected));
        let mut failure = failed(call, title).at(Target::Argument(0)).label(format!("tolerance {}", number_text(tolerance)));
        let word = if self.is_exact_known { "error" } else { "difference to the next" };
        for (index, error) in self.errors.iter().enumerate() {
            let order = index.checked_sub(1).map(|before| format!(", order {}", shown[before])).unwrap_or_default();
            failure = failure.cause(format!("dt = {}: {word} {}{order}", brief(self.sizes[index]), significant(*error, 3)));
        }
        failure.hint(if self.errors.iter().any(|error| *error <= ORDER_ROUND_OFF * self.scale) {
            "the results agree to round-off, where no order can be read: begin with a larger `dt`, or compare something else"
        } else if last < expected {
            "begin with a smaller `dt` if the orders still rise; loads with kinks and contact that opens or closes lower the order"
        } else {
            "begin with a smaller `dt` if the orders still fall; the result may be better than the method"
        })
    }
}

fn numbers_in(value: &Dynamic) -> Option<Vec<f64>> {
    match as_number(value) {
        Some(number) => Some(vec![number]),
        None => value.read_lock::<Array>().and_then(|array| array.iter().map(as_number).collect()),
    }
}

/// The largest difference of two results.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0_f64, |largest, (a, b)| largest.max((a - b).abs()))
}

/// Returns the results for the first step sizes, computed in parallel if possible, up to the first failed one.
fn side_by_side(call: &Call, sizes: &[f64], length: Option<usize>) -> Result<Vec<Vec<f64>>, Failure> {
    let mut worker_pool = WorkerPool::new(call, call.callback("action")?, read, call.host.settings.workers.min(sizes.len()));
    let mut found = Found { results: Vec::new(), length, is_over: false };
    if worker_pool.is_apart() {
        let points: Vec<Vec<Plain>> = sizes.iter().map(|&dt| vec![Plain::Number(dt)]).collect();
        match worker_pool.compute("expect_order", &points, &mut found) {
            Err(failure) if !found.is_over => return Err(failure),
            _ => {}
        }
    }
    Ok(found.results)
}

/// Results that were computed in parallel.
struct Found {
    results: Vec<Vec<f64>>,
    /// Expected length of the results, if known.
    length: Option<usize>,
    /// True after a failed result; the point is computed again in the session itself, where the error has its chain of calls.
    is_over: bool,
}

impl Found {
    fn numbers(&self, outcome: &Outcome) -> Option<Vec<f64>> {
        let Outcome::Done(Plain::Array(numbers)) = outcome else { return None };
        let numbers = numbers.iter().map(|number| number.number().filter(|number| number.is_finite())).collect::<Option<Vec<f64>>>()?;
        let length = self.length.or(self.results.first().map(Vec::len));
        length.is_none_or(|length| length == numbers.len()).then_some(numbers)
    }
}

impl Results for Found {
    fn known(&self, _: &[Plain]) -> Option<Computed> {
        None
    }

    fn computed(&mut self, _: &[Plain], _: &Computed) -> Result<(), Failure> {
        Ok(())
    }

    fn is_told(&self, outcome: &Outcome) -> bool {
        self.numbers(outcome).is_some()
    }

    fn take(&mut self, _: usize, outcome: Outcome) -> Result<(), Failure> {
        match self.numbers(&outcome) {
            Some(numbers) => self.results.push(numbers),
            None => {
                self.is_over = true;
                return Err(Failure::new(Class::Check, "a result has no numbers"));
            }
        }
        Ok(())
    }
}

/// Converts the value of a closure into numbers.
fn read(_: &Engine, value: &Dynamic) -> Result<Plain, Failure> {
    let positions = |handle: SimulationHandle| handle.0.simulation.try_borrow().ok().map(|simulation| simulation.state().positions);
    let numbers = value.clone().try_cast::<SimulationHandle>().and_then(positions).or_else(|| numbers_in(value));
    let numbers = numbers.ok_or_else(|| Failure::script("the closure gives no numbers").code(causes::CLOSURE))?;
    Ok(Plain::Array(numbers.into_iter().map(Plain::Number).collect()))
}

/// Returns the closure's result for a step size; its length must equal that of `like`.
fn result_of(call: &Call, dt: f64, like: Option<&[f64]>) -> Result<Vec<f64>, Box<EvalAltResult>> {
    let action = call.callback("action")?;
    let value = {
        let _aside = begin_study(call.host, None);
        action.call([Dynamic::from(dt)])?
    };
    let numbers = match value.clone().try_cast::<SimulationHandle>() {
        Some(handle) => Some(handle.with(call, |simulation| simulation.state().positions)?),
        None => numbers_in(&value),
    };
    let wrong = |title: &str, label: String| -> Box<EvalAltResult> {
        let failure = call.argument("action").fail(title).label(label);
        failure.hint("let the last expression of the closure, without a semicolon, be the result").into()
    };
    let Some(numbers) = numbers else {
        let given = describe(call.engine(), &value);
        return Err(wrong("the closure must give a number, an array of numbers, or a simulation", format!("this gives {given}")));
    };
    if numbers.iter().any(|number| !number.is_finite()) {
        return Err(wrong("the closure gives a number that is not finite", format!("at dt = {}", number_text(dt))));
    }
    if like.is_some_and(|like| like.len() != numbers.len()) {
        let (count, other) = (numbers.len(), like.map_or(0, <[f64]>::len));
        return Err(wrong("the results have different lengths", format!("{count} numbers at dt = {}, not {other}", number_text(dt))));
    }
    Ok(numbers)
}
