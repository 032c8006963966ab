//! Time functions: the built-in ones, numbers, and closures of time that the solver calls.

use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rhai::FnPtr;

use crate::dynamics::{Amplitude, BodyField, Constant, Hat, PlaceFunction, Ramp, Sine, Table, TimeFunction, TimeFunctionError};
use crate::script::language::callback::Callback;
use crate::script::language::digits::{number_text, vector_text};
use crate::script::language::failure::ScriptError;
use crate::script::language::prelude::*;
use crate::script::language::thread_bound::ThreadBound;
use crate::script::language::values::{as_number, describe};

/// A time function in a script.
#[derive(Clone)]
pub struct TimeFunctionHandle(pub Amplitude);

impl Handle for TimeFunctionHandle {
    const NAME: &'static str = "TimeFunction";

    fn instead_of_operator() -> Option<&'static str> {
        Some("write a closure instead, such as `|t| 2.0 * f(t)`")
    }

    fn describe(&self) -> String {
        self.0.describe()
    }
}

/// Returns a constant function of time.
fn constant(value: f64) -> Amplitude {
    Arc::new(Constant(value))
}

/// A closure of time.
fn closure(call: &Call, function: FnPtr) -> Amplitude {
    Arc::new(kept(call, function))
}

fn kept(call: &Call, function: FnPtr) -> ScriptFunction {
    ScriptFunction(ThreadBound::new(Closure { callback: Callback::new(call, function), host: call.host.clone() }))
}

/// A closure of position in the plane.
pub fn place_function(call: &Call, function: FnPtr) -> Arc<dyn PlaceFunction> {
    Arc::new(kept(call, function))
}

/// Returns the time function in an argument: a number, a built-in function, or a closure of time.
///
/// # Errors
/// Any other value.
pub fn amplitude_of(argument: &Argument) -> Result<Amplitude, Failure> {
    if !argument.is_given() {
        return match argument.absent() {
            Absent::Number(value) => Ok(constant(value)),
            _ => Err(argument.missing()),
        };
    }
    let value = argument.value();
    if let Some(number) = as_number(&value) {
        return match number.is_finite() {
            true => Ok(constant(number)),
            false => Err(argument.out_of_range(Interval::Finite, &number_text(number))),
        };
    }
    if let Some(handle) = value.clone().try_cast::<TimeFunctionHandle>() {
        return Ok(handle.0);
    }
    match value.read_lock::<FnPtr>() {
        Some(function) => {
            argument.check_parameters(&function, "|t|")?;
            Ok(closure(argument.call(), function.clone()))
        }
        None => Err(argument.wrong_type()),
    }
}

/// Closure with the host of its script.
struct Closure {
    callback: Callback,
    host: Rc<Host>,
}

/// Error of a closure that is passed through the solver, which may send it to other threads.
#[derive(Debug)]
pub struct ClosureError {
    text: String,
    error: ThreadBound<ScriptError>,
}

impl ClosureError {
    fn boxed(error: ScriptError) -> TimeFunctionError {
        Box::new(ClosureError { text: error.to_string(), error: ThreadBound::new(error) })
    }

    /// Returns the error of the engine; `None` on another thread.
    pub fn error(&self) -> Option<ScriptError> {
        self.error.get().map(|error| ScriptError::clone(&error))
    }
}

impl std::fmt::Display for ClosureError {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "{}", self.text)
    }
}

impl std::error::Error for ClosureError {}

/// Closure of time, or of a position, as called by the solver.
struct ScriptFunction(ThreadBound<Closure>);

impl ScriptFunction {
    /// Returns the value at the arguments; `at` describes these for messages.
    fn number<const N: usize>(&self, arguments: [f64; N], at: impl Fn() -> String) -> Result<f64, TimeFunctionError> {
        let closure = self.0.get().ok_or("the closure belongs to another thread")?;
        let Closure { callback, host } = &*closure;
        let value = callback.call(arguments.map(Dynamic::from)).map_err(|error| ClosureError::boxed(callback.wrap(*error)))?;
        match as_number(&value) {
            Some(number) if number.is_finite() => Ok(number),
            _ => {
                let given = host.engine().map_or(String::new(), |engine| describe(&engine.borrow(), &value));
                let failure = Failure::script(format!("the closure must give a finite number at {}", at()))
                    .code(causes::CLOSURE)
                    .label("given here")
                    .cause(format!("it gives {given}"))
                    .hint("let its last expression be the number");
                Err(ClosureError::boxed(callback.refuse(failure)))
            }
        }
    }
}

/// Returns a vector field from a closure of position, velocity and time.
pub fn body_field(call: &Call, function: FnPtr, dimension: usize) -> Arc<dyn BodyField> {
    Arc::new(ScriptField { function: kept(call, function), dimension })
}

/// Closure of position, velocity and time, as called by the solver.
struct ScriptField {
    function: ScriptFunction,
    dimension: usize,
}

impl BodyField for ScriptField {
    fn value(&self, position: [f64; 3], velocity: [f64; 3], time: f64) -> Result<[f64; 3], TimeFunctionError> {
        let closure = self.function.0.get().ok_or("the closure belongs to another thread")?;
        let (Closure { callback, host }, d) = (&*closure, self.dimension);
        let array = |vector: [f64; 3]| Dynamic::from(vector[..d].iter().map(|&x| Dynamic::from(x)).collect::<rhai::Array>());
        let called = callback.call([array(position), array(velocity), Dynamic::from(time)]);
        let value = called.map_err(|error| ClosureError::boxed(callback.wrap(*error)))?;
        let numbers: Option<Vec<f64>> = value.read_lock::<rhai::Array>().and_then(|array| array.iter().map(as_number).collect());
        match numbers {
            Some(numbers) if numbers.len() == d && numbers.iter().all(|number| number.is_finite()) => {
                let mut vector = [0.0; 3];
                vector[..d].copy_from_slice(&numbers);
                Ok(vector)
            }
            _ => {
                let given = host.engine().map_or(String::new(), |engine| describe(&engine.borrow(), &value));
                let title = format!("the closure must give {d} finite numbers at t = {}", number_text(time));
                let failure = Failure::script(title).label("given here").cause(format!("it gives {given}"));
                let hint = "let its last expression be the force per mass, such as `[0.0, -9.81]`";
                Err(ClosureError::boxed(callback.refuse(failure.hint(hint))))
            }
        }
    }
}

impl TimeFunction for ScriptFunction {
    fn value(&self, time: f64) -> Result<f64, TimeFunctionError> {
        self.number([time], || format!("t = {}", number_text(time)))
    }

    fn describe(&self) -> String {
        "|t| …".into()
    }
}

impl PlaceFunction for ScriptFunction {
    fn value(&self, [x, y, _]: [f64; 3]) -> Result<f64, TimeFunctionError> {
        self.number([x, y], || vector_text(&[x, y]))
    }

    fn describe(&self) -> String {
        "|x, y| …".into()
    }
}

/// Time function that records whether it was evaluated and ever nonzero.
pub struct RecordedTimeFunction {
    inner: Arc<dyn TimeFunction>,
    asked: AtomicBool,
    acted: AtomicBool,
}

impl RecordedTimeFunction {
    /// Wraps a time function to record its evaluations.
    pub fn new(inner: Arc<dyn TimeFunction>) -> Self {
        RecordedTimeFunction { inner, asked: AtomicBool::new(false), acted: AtomicBool::new(false) }
    }

    /// True if the function has returned a value other than zero.
    pub fn has_acted(&self) -> bool {
        self.acted.load(Ordering::Relaxed)
    }

    /// True if the function was evaluated and was zero each time.
    pub fn never_acted(&self) -> bool {
        self.asked.load(Ordering::Relaxed) && !self.acted.load(Ordering::Relaxed)
    }
}

impl TimeFunction for RecordedTimeFunction {
    fn value(&self, time: f64) -> Result<f64, TimeFunctionError> {
        let value = self.inner.value(time)?;
        self.asked.store(true, Ordering::Relaxed);
        self.acted.fetch_or(value != 0.0, Ordering::Relaxed);
        Ok(value)
    }

    fn corners(&self) -> Vec<f64> {
        self.inner.corners()
    }

    fn describe(&self) -> String {
        self.inner.describe()
    }
}

/// Script functions of this topic.
pub fn functions() -> Vec<Function> {
    vec![hat(), ramp(), sine(), table(), value()]
}

/// Parameters of the interval in which a function changes from one constant to another.
fn window() -> [Parameter; 2] {
    [
        Parameter::number("start", "time", Interval::Finite, "the time at which it leaves zero"),
        Parameter::number("end", "time", Interval::Finite, "the time at which it arrives"),
    ]
}

fn window_of(call: &Call) -> Result<(f64, f64), Failure> {
    let (start, end) = (call.number("start")?, call.number("end")?);
    if start < end {
        return Ok((start, end));
    }
    let failure = call.argument("end").refuse(causes::ORDER, format!("{} must be greater than `start`", call.argument("end").title()));
    Err(failure
        .label(format!("this is {}", number_text(end)))
        .cause(format!("`start` is {}", number_text(start)))
        .hint("swap the two times, or move one of them"))
}

fn hat() -> Function {
    let [start, end] = window();
    function(Topic::TimeFunctions, "hat")
        .summary("zero, up to `peak` in the middle between `start` and `end`, and back to zero, linearly")
        .parameters(vec![start, end, Parameter::number("peak", "any", Interval::Finite, "the largest value")])
        .see_also(&["ramp", "sine", "table"])
        .example("let spin_up = hat(0.0, 0.5, 0.1);")
        .body(|call| {
            let (start, end) = window_of(call)?;
            Ok(TimeFunctionHandle(Arc::new(Hat { start, end, peak: call.number("peak")? })))
        })
}

fn ramp() -> Function {
    let [start, end] = window();
    function(Topic::TimeFunctions, "ramp")
        .summary("zero until `start`, linear to `value` at `end`, constant afterwards")
        .parameters(vec![start, end, Parameter::number("value", "any", Interval::Finite, "the final value")])
        .see_also(&["hat", "sine", "table"])
        .example("let push = ramp(0.0, 1.0, 50.0);")
        .body(|call| {
            let (start, end) = window_of(call)?;
            Ok(TimeFunctionHandle(Arc::new(Ramp { start, end, value: call.number("value")? })))
        })
}

fn sine() -> Function {
    function(Topic::TimeFunctions, "sine")
        .summary("`amplitude * sin(2 pi frequency t)`")
        .parameters(vec![
            Parameter::number("amplitude", "any", Interval::Finite, "the largest value"),
            Parameter::number("frequency", "1/time", Interval::Finite, "cycles per time"),
        ])
        .see_also(&["hat", "ramp", "table"])
        .example("let shake = sine(2.0, 5.0);")
        .body(|call| {
            let (amplitude, frequency) = (call.number("amplitude")?, call.number("frequency")?);
            Ok(TimeFunctionHandle(Arc::new(Sine { amplitude, frequency })))
        })
}

fn table() -> Function {
    function(Topic::TimeFunctions, "table")
        .summary(
            "linear between given points `[time, value]`, constant before the first and after the last; times and values may be two \
             arrays, such as columns of a measured record that `read_csv` gives",
        )
        .parameters(vec![
            Parameter::array("points", "an array of `[time, value]` pairs with increasing times, or the times"),
            Parameter::array("values", "the values at the times").otherwise("`points` are pairs"),
        ])
        .see_also(&["hat", "ramp", "sine", "read_csv"])
        .example("let history = table([[0.0, 0.0], [0.1, 5.0], [0.4, 1.0]]);\nlet same = table([0.0, 0.1, 0.4], [0.0, 5.0, 1.0]);")
        .body(|call| {
            let (argument, values) = (call.argument("points"), call.argument("values"));
            let points = if values.is_given() { pairs_of(&argument, &values)? } else { points_of(&argument, ["time", "value"])? };
            match Table::new(points) {
                Some(table) => Ok(TimeFunctionHandle(Arc::new(table))),
                None => {
                    Err(argument.refuse(causes::COUNT, "`table` needs at least one point").hint("write `[[0.0, 0.0], [1.0, 5.0]]`").into())
                }
            }
        })
}

/// Returns points in ascending order from an array of pairs; `first` and `second` name the numbers.
pub fn points_of(argument: &Argument, [first, second]: [&str; 2]) -> Result<Vec<(f64, f64)>, Failure> {
    let function = argument.call().function.name;
    let mut points = Vec::new();
    for entry in argument.array()? {
        let pair: Option<Vec<f64>> = entry.read_lock::<rhai::Array>().and_then(|pair| pair.iter().map(as_number).collect());
        match pair.as_deref() {
            Some([x, y]) if x.is_finite() && y.is_finite() => points.push((*x, *y)),
            _ => {
                let given = describe(argument.call().engine(), &entry);
                let failure =
                    argument.refuse(causes::WRONG_TYPE, format!("every point of `{function}` must be a pair `[{first}, {second}]`"));
                return Err(failure.label(format!("this contains {given}")).hint("write `[[0.0, 0.0], [1.0, 5.0]]`"));
            }
        }
    }
    increasing(argument, points, first)
}

/// Returns points in ascending order from two arrays of numbers.
fn pairs_of(times: &Argument, values: &Argument) -> Result<Vec<(f64, f64)>, Failure> {
    let numbers = |argument: &Argument| {
        let wrong = |entry: &Dynamic| {
            let failure = argument.refuse(causes::OUT_OF_RANGE, format!("every entry of {} must be a finite number", argument.title()));
            let failure = failure.label(format!("this contains {}", describe(argument.call().engine(), entry)));
            failure.hint("leave out lines without a value: `NaN` is what an empty field of a file gives")
        };
        let number = |entry: Dynamic| as_number(&entry).filter(|x| x.is_finite()).ok_or_else(|| wrong(&entry));
        argument.array()?.into_iter().map(number).collect::<Result<Vec<f64>, Failure>>()
    };
    let (at, of) = (numbers(times)?, numbers(values)?);
    if at.len() != of.len() {
        let failure = values.refuse(causes::COUNT, format!("there are {} times and {} values", at.len(), of.len()));
        return Err(failure.hint("give a value for each time: two columns of one file"));
    }
    increasing(times, at.into_iter().zip(of).collect(), "time")
}

/// Returns the points if their first numbers increase.
fn increasing(argument: &Argument, points: Vec<(f64, f64)>, first: &str) -> Result<Vec<(f64, f64)>, Failure> {
    match points.windows(2).find(|pair| pair[0].0 >= pair[1].0) {
        Some(pair) => Err(argument
            .refuse(causes::ORDER, format!("the {first}s of `{}` must increase", argument.call().function.name))
            .label(format!("{} comes after {}", number_text(pair[1].0), number_text(pair[0].0)))
            .hint(format!("sort the points; a jump needs two {first}s close to each other"))),
        None => Ok(points),
    }
}

fn value() -> Function {
    method_of::<TimeFunctionHandle>(Topic::TimeFunctions, "value")
        .summary("the value of a time function at a time")
        .parameters(vec![Parameter::number("time", "time", Interval::Finite, "the time")])
        .returns("number")
        .see_also(&["hat", "ramp", "sine", "table"])
        .example("print(hat(0.0, 1.0, 8.0).value(0.25)); // 4.0")
        .body(|call, time_function| {
            let time = call.number("time")?;
            let value = time_function.0.value(time);
            value.map(Dynamic::from).map_err(|error| call.fail(error.to_string()).into())
        })
}
