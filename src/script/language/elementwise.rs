//! Arithmetic with arrays of numbers, entry by entry: `a + b`, `2.0 * a`, `-a`, for numbers inside arrays of arrays, too.
//!
//! Whole numbers stay whole, except for `/`, which gives fractions. `+` of arrays with entries other than numbers joins the arrays, as in
//! the engine. `a += b` appends, as in the engine. The engine's optimizer converts `a = a + b`, which means the sum, to `a += b`; the text
//! of the script distinguishes the two.

use std::rc::Rc;

use rhai::{Array, Dynamic, EvalAltResult, FuncRegistration, Module, NativeCallContext};

use super::causes;
use super::failure::Failure;
use super::host::Host;
use super::sources::offset;
use super::values::{as_number, describe};

/// Largest depth of nested arrays.
const MAX_DEPTH: usize = 8;

/// An operator between two numbers.
#[derive(Clone, Copy)]
struct Operator {
    sign: &'static str,
    /// Result for whole numbers, if the operator gives whole numbers; `None` on overflow.
    whole: Option<fn(i64, i64) -> Option<i64>>,
    fraction: fn(f64, f64) -> f64,
}

const OPERATORS: [Operator; 6] = [
    Operator { sign: "+", whole: Some(i64::checked_add), fraction: |a, b| a + b },
    Operator { sign: "-", whole: Some(i64::checked_sub), fraction: |a, b| a - b },
    Operator { sign: "*", whole: Some(i64::checked_mul), fraction: |a, b| a * b },
    Operator { sign: "/", whole: None, fraction: |a, b| a / b },
    Operator { sign: "%", whole: Some(i64::checked_rem), fraction: |a, b| a % b },
    Operator { sign: "**", whole: None, fraction: f64::powf },
];

type Value = Result<Dynamic, Box<EvalAltResult>>;

impl Operator {
    fn numbers(self, context: &NativeCallContext, a: &Dynamic, b: &Dynamic) -> Value {
        if let (Some(whole), Ok(a), Ok(b)) = (self.whole, a.as_int(), b.as_int()) {
            let result = whole(a, b).map(Dynamic::from);
            let failure = || Failure::script(format!("`{a} {} {b}` is no whole number that fits", self.sign)).code(causes::OUT_OF_RANGE);
            return result.ok_or_else(|| failure().hint("use numbers with a decimal point, such as `2.0`").into());
        }
        match (as_number(a), as_number(b)) {
            (Some(a), Some(b)) => Ok((self.fraction)(a, b).into()),
            (a_number, _) => {
                let wrong = describe(context.engine(), if a_number.is_none() { a } else { b });
                let failure = Failure::script(format!("`{}` works on arrays of numbers", self.sign)).code(causes::WRONG_TYPE);
                Err(failure.cause(format!("an entry is {wrong}")).hint("arrays inside arrays must agree in their lengths, too").into())
            }
        }
    }

    /// Applies the operator to two values of which at least one is an array.
    fn apply(self, context: &NativeCallContext, a: &Dynamic, b: &Dynamic, depth: usize) -> Value {
        if depth > MAX_DEPTH {
            return Err(Failure::script(format!("`{}` works on arrays of numbers, not on arrays nested so deeply", self.sign))
                .code(causes::WRONG_TYPE)
                .into());
        }
        match (a.read_lock::<Array>(), b.read_lock::<Array>()) {
            (Some(a), Some(b)) => {
                if a.len() != b.len() {
                    return Err(self.unequal(a.len(), b.len()).into());
                }
                // A point and a number at corresponding positions of two arrays cannot be combined.
                a.iter().zip(b.iter()).map(|(a, b)| self.pair(context, a, b, depth + 1)).collect::<Result<Array, _>>().map(Into::into)
            }
            (Some(a), None) => a.iter().map(|a| self.apply(context, a, b, depth + 1)).collect::<Result<Array, _>>().map(Into::into),
            (None, Some(b)) => b.iter().map(|b| self.apply(context, a, b, depth + 1)).collect::<Result<Array, _>>().map(Into::into),
            (None, None) => self.numbers(context, a, b),
        }
    }

    fn pair(self, context: &NativeCallContext, a: &Dynamic, b: &Dynamic, depth: usize) -> Value {
        if a.is_array() == b.is_array() { self.apply(context, a, b, depth) } else { self.numbers(context, a, b) }
    }

    fn unequal(self, a: usize, b: usize) -> Failure {
        let failure =
            Failure::script(format!("`{}` works entry by entry, and the arrays have {a} and {b} entries", self.sign)).code(causes::COUNT);
        match self.sign {
            "+" => failure.hint("`a.append(b)` puts the entries of `b` behind those of `a`; `a.push(x)` puts one value there"),
            _ => failure.hint("`a.len()` is the number of entries of an array; `a.extract(0, n)` gives the first `n`"),
        }
    }
}

/// True if an array consists of numbers and arrays of numbers.
fn has_numbers(array: &Array, depth: usize) -> bool {
    let inner = |value: &Dynamic| value.read_lock::<Array>().is_some_and(|array| depth < MAX_DEPTH && has_numbers(&array, depth + 1));
    array.iter().all(|value| as_number(value).is_some() || inner(value))
}

/// Result of `+` between two arrays: the sum entry by entry, or the joined array if there are entries other than numbers.
fn sum(context: &NativeCallContext, a: Array, b: Array) -> Value {
    if !(has_numbers(&a, 0) && has_numbers(&b, 0)) {
        let mut joined = a;
        joined.extend(b);
        return Ok(joined.into());
    }
    OPERATORS[0].apply(context, &a.into(), &b.into(), 0)
}

/// True if the operator of a call is written as `sign` in the script.
fn is_written(host: &Host, context: &NativeCallContext, sign: &str) -> bool {
    let source = context.fn_source().filter(|source| !source.is_empty()).map_or_else(|| host.main.borrow().clone(), String::from);
    let text = host.sources.text(&source);
    text.is_none_or(|text| offset(&text, context.call_position()).is_some_and(|start| text[start..].starts_with(sign)))
}

/// Registers `+=` of arrays, which appends; if the optimizer made it of `a = a + b`, it adds.
fn register_append(module: &mut Module, host: &Rc<Host>) {
    let of_entries = Rc::downgrade(host);
    let add = |b: &str| {
        let described = ["a: &mut Array".to_string(), format!("b: {b}"), "()".to_string()];
        FuncRegistration::new("+=").in_global_namespace().with_params_info(described)
    };
    let result = move |context: &NativeCallContext, a: &mut Array, b: Dynamic| -> Result<(), Box<EvalAltResult>> {
        if of_entries.upgrade().is_none_or(|host| is_written(&host, context, "+=")) {
            match b.try_cast_result::<Array>() {
                Ok(b) => a.extend(b),
                Err(b) => a.push(b),
            }
            return Ok(());
        }
        let before = std::mem::take(a);
        let sum = match b.try_cast_result::<Array>() {
            Ok(b) => sum(context, before, b),
            Err(b) => OPERATORS[0].apply(context, &before.into(), &b, 0),
        };
        *a = sum?.cast();
        Ok(())
    };
    let (of_array, of_float) = (result.clone(), result.clone());
    add("Array").set_into_module(module, move |context: NativeCallContext, a: &mut Array, b: Array| of_array(&context, a, b.into()));
    add("float").set_into_module(module, move |context: NativeCallContext, a: &mut Array, b: f64| of_float(&context, a, b.into()));
    add("int").set_into_module(module, move |context: NativeCallContext, a: &mut Array, b: i64| result(&context, a, b.into()));
}

/// Adds the operators to a module.
pub fn register(module: &mut Module, host: &Rc<Host>) {
    register_append(module, host);
    for operator in OPERATORS {
        let sign = operator.sign;
        let add = |a: &str, b: &str| {
            let described = [format!("a: {a}"), format!("b: {b}"), "Array".to_string()];
            FuncRegistration::new(sign).in_global_namespace().with_params_info(described)
        };
        add("Array", "Array").set_into_module(module, move |context: NativeCallContext, a: Array, b: Array| -> Value {
            if sign == "+" { sum(&context, a, b) } else { operator.apply(&context, &a.into(), &b.into(), 0) }
        });
        add("Array", "float").set_into_module(module, move |context: NativeCallContext, a: Array, b: f64| -> Value {
            operator.apply(&context, &a.into(), &b.into(), 0)
        });
        add("Array", "int").set_into_module(module, move |context: NativeCallContext, a: Array, b: i64| -> Value {
            operator.apply(&context, &a.into(), &b.into(), 0)
        });
        add("float", "Array").set_into_module(module, move |context: NativeCallContext, a: f64, b: Array| -> Value {
            operator.apply(&context, &a.into(), &b.into(), 0)
        });
        add("int", "Array").set_into_module(module, move |context: NativeCallContext, a: i64, b: Array| -> Value {
            operator.apply(&context, &a.into(), &b.into(), 0)
        });
    }
    let negative = FuncRegistration::new("-").in_global_namespace().with_params_info(["a: Array", "Array"]);
    // Multiplication by -1, because subtraction from 0 would make 0.0 of -0.0.
    negative.set_into_module(module, |context: NativeCallContext, a: Array| -> Value {
        OPERATORS[2].apply(&context, &a.into(), &(-1_i64).into(), 0)
    });
}
