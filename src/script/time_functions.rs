//! Time functions: the built-in ones, numbers, and closures of time that the solver calls.

use std::cell::Cell;
use std::rc::Rc;

use rhai::{Dynamic, FnPtr};

use super::arguments::{Arguments, Call, as_number, describe};
use super::callback::Callback;
use super::failure::Failure;
use super::registry::{Form, Function, Handle, Kind, Parameter, Topic, body, number_text};
use crate::dynamics::{Constant, Hat, Ramp, Sine, Table, TimeFunction};
use crate::math::catalogue::Interval;

/// A time function in a script.
#[derive(Clone)]
pub struct TimeFunctionHandle(pub Rc<dyn TimeFunction>);

impl Handle for TimeFunctionHandle {
    const NAME: &'static str = "TimeFunction";

    fn describe(&self) -> String {
        self.0.describe()
    }
}

/// The same value at all times.
pub fn constant(value: f64) -> TimeFunctionHandle {
    TimeFunctionHandle(Rc::new(Constant(value)))
}

/// A closure of time.
pub fn closure(call: &Call, function: FnPtr) -> TimeFunctionHandle {
    TimeFunctionHandle(Rc::new(ScriptFunction { callback: Callback::new(call, function), host: call.host.clone() }))
}

struct ScriptFunction {
    callback: Callback,
    host: Rc<super::host::Host>,
}

impl TimeFunction for ScriptFunction {
    fn value(&self, time: f64) -> Result<f64, Box<dyn std::error::Error>> {
        let value = self.callback.call([Dynamic::from(time)]).map_err(|error| self.callback.wrap(*error))?;
        match as_number(&value) {
            Some(number) if number.is_finite() => Ok(number),
            _ => {
                let given = self.host.engine().map_or(String::new(), |engine| describe(&engine.borrow(), &value));
                let failure = Failure::script(format!("the closure must give a finite number at t = {}", number_text(time)))
                    .label("given here")
                    .cause(format!("it gives {given}"))
                    .hint("let its last expression be the number");
                Err(Box::new(self.callback.refuse(failure)))
            }
        }
    }

    fn describe(&self) -> String {
        "|t| …".into()
    }
}

/// A time function that remembers whether it was ever asked and ever different from zero.
pub struct Watched {
    inner: Rc<dyn TimeFunction>,
    /// Whether it was asked.
    pub asked: Cell<bool>,
    /// Whether it was different from zero when asked.
    pub acted: Cell<bool>,
}

impl Watched {
    /// Watches a time function.
    pub fn new(inner: Rc<dyn TimeFunction>) -> Self {
        Watched { inner, asked: Cell::new(false), acted: Cell::new(false) }
    }
}

impl TimeFunction for Watched {
    fn value(&self, time: f64) -> Result<f64, Box<dyn std::error::Error>> {
        let value = self.inner.value(time)?;
        self.asked.set(true);
        self.acted.set(self.acted.get() || value != 0.0);
        Ok(value)
    }

    fn describe(&self) -> String {
        self.inner.describe()
    }
}

/// The functions of this topic.
pub fn functions() -> Vec<Function> {
    let window = || {
        [
            Parameter::number("start", "time", Interval::Finite, "the time at which it leaves zero"),
            Parameter::number("end", "time", Interval::Finite, "the time at which it arrives"),
        ]
    };
    let window_of = |call: &Call| -> Result<(f64, f64), Failure> {
        let (start, end) = (call.number("start")?, call.number("end")?);
        if start < end {
            return Ok((start, end));
        }
        let failure = call.argument("end").fail(format!("{} must be greater than `start`", call.argument("end").title()));
        Err(failure
            .label(format!("this is {}", number_text(end)))
            .cause(format!("`start` is {}", number_text(start)))
            .hint("swap the two times, or move one of them"))
    };
    let [start, end] = window();
    let hat = Function {
        name: "hat",
        form: Form::Function,
        topic: Topic::TimeFunctions,
        summary: "zero, up to `peak` in the middle between `start` and `end`, and back to zero, linearly",
        parameters: vec![start, end, Parameter::number("peak", "any", Interval::Finite, "the largest value")],
        returns: TimeFunctionHandle::NAME,
        example: "let spin_up = hat(0.0, 0.5, 0.1);".into(),
        see_also: &["ramp", "sine", "table"],
        body: body(move |call| {
            let (start, end) = window_of(call)?;
            Ok(Dynamic::from(TimeFunctionHandle(Rc::new(Hat { start, end, peak: call.number("peak")? }))))
        }),
    };
    let [start, end] = window();
    let ramp = Function {
        name: "ramp",
        form: Form::Function,
        topic: Topic::TimeFunctions,
        summary: "zero until `start`, linear to `value` at `end`, constant afterwards",
        parameters: vec![start, end, Parameter::number("value", "any", Interval::Finite, "the final value")],
        returns: TimeFunctionHandle::NAME,
        example: "let push = ramp(0.0, 1.0, 50.0);".into(),
        see_also: &["hat", "sine", "table"],
        body: body(move |call| {
            let (start, end) = window_of(call)?;
            Ok(Dynamic::from(TimeFunctionHandle(Rc::new(Ramp { start, end, value: call.number("value")? }))))
        }),
    };
    let sine = Function {
        name: "sine",
        form: Form::Function,
        topic: Topic::TimeFunctions,
        summary: "`amplitude * sin(2 pi frequency t)`",
        parameters: vec![
            Parameter::number("amplitude", "any", Interval::Finite, "the largest value"),
            Parameter::number("frequency", "1/time", Interval::Finite, "cycles per time"),
        ],
        returns: TimeFunctionHandle::NAME,
        example: "let shake = sine(2.0, 5.0);".into(),
        see_also: &["hat", "ramp", "table"],
        body: body(|call| {
            let (amplitude, frequency) = (call.number("amplitude")?, call.number("frequency")?);
            Ok(Dynamic::from(TimeFunctionHandle(Rc::new(Sine { amplitude, frequency }))))
        }),
    };
    let table = Function {
        name: "table",
        form: Form::Function,
        topic: Topic::TimeFunctions,
        summary: "linear between given points `[time, value]`, constant before the first and after the last",
        parameters: vec![Parameter::new("points", Kind::Array, "an array of `[time, value]` pairs with increasing times")],
        returns: TimeFunctionHandle::NAME,
        example: "let history = table([[0.0, 0.0], [0.1, 5.0], [0.4, 1.0]]);".into(),
        see_also: &["hat", "ramp", "sine"],
        body: body(|call| {
            let argument = call.argument("points");
            let mut points = Vec::new();
            for entry in argument.array()? {
                let pair: Option<Vec<f64>> = entry.read_lock::<rhai::Array>().and_then(|pair| pair.iter().map(as_number).collect());
                match pair.as_deref() {
                    Some([time, value]) if time.is_finite() && value.is_finite() => points.push((*time, *value)),
                    _ => {
                        let given = describe(call.engine(), &entry);
                        let failure = argument.fail("every point of `table` must be a pair `[time, value]`");
                        return Err(failure.label(format!("this contains {given}")).hint("write `[[0.0, 0.0], [1.0, 5.0]]`").into());
                    }
                }
            }
            match points.windows(2).find(|pair| pair[0].0 >= pair[1].0) {
                Some(pair) => Err(argument
                    .fail("the times of `table` must increase")
                    .label(format!("{} comes after {}", number_text(pair[1].0), number_text(pair[0].0)))
                    .hint("sort the points; a jump needs two times close to each other")
                    .into()),
                None => match Table::new(points) {
                    Some(table) => Ok(Dynamic::from(TimeFunctionHandle(Rc::new(table)))),
                    None => Err(argument.fail("`table` needs at least one point").hint("write `[[0.0, 0.0], [1.0, 5.0]]`").into()),
                },
            }
        }),
    };
    let value = Function {
        name: "value",
        form: Form::Method(TimeFunctionHandle::receiver()),
        topic: Topic::TimeFunctions,
        summary: "the value of a time function at a time",
        parameters: vec![Parameter::number("time", "time", Interval::Finite, "the time")],
        returns: "number",
        example: "print(hat(0.0, 1.0, 8.0).value(0.25)); // 4.0".into(),
        see_also: &["hat", "ramp", "sine", "table"],
        body: body(|call| {
            let time = call.number("time")?;
            let value = call.receiver::<TimeFunctionHandle>().0.value(time);
            value.map(Dynamic::from).map_err(|error| call.fail(error.to_string()).into())
        }),
    };
    vec![hat, ramp, sine, table, value]
}
