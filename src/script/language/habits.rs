//! Words and operators of other languages, and their equivalents in this one.
//!
//! Used for unknown names, before the nearest name is suggested.

/// Words of other languages that are not functions, with hints.
const WORDS: &[(&[&str], &str)] = &[
    (&["null", "None", "nil", "undefined", "NULL"], "the empty value is written `()`"),
    (&["and"], "write `&&`"),
    (&["or"], "write `||`"),
    (&["not"], "write `!`"),
    (&["elif", "elsif", "elseif"], "write `else if`"),
    (&["True"], "write `true`"),
    (&["False"], "write `false`"),
    (&["def", "function", "func", "lambda"], "functions are written `fn name(x) { … }`, closures `|x| …`"),
    (&["var"], "write `let`"),
    (&["pi", "Pi"], "write `PI`"),
    (&["#"], "comments begin with `//`, and maps with `#{`"),
];

/// Functions of other languages, with hints.
const CALLS: &[(&[&str], &str)] = &[
    (&["pow", "power"], "write a power as `x ** y`"),
    (&["format", "sprintf"], "write values inside back-ticks, `` `t = ${t}` ``; `fmt(x, 3)` rounds a number"),
    (&["printf", "println", "echo", "disp", "puts"], "write `print(value)`"),
    (&["length", "size", "count"], "write `x.len()`"),
    (&["append", "add", "push_back"], "write `array.push(value)`"),
    (&["last", "back", "tail", "end"], "the last entry is `array[-1]`"),
    (&["first", "front", "head"], "the first entry is `array[0]`"),
    (&["slice", "subarray"], "write `array.extract(2..5)`"),
    (&["str", "string"], "write `x.to_string()`"),
    (&["int", "integer"], "write `x.to_int()`"),
    (&["float", "double"], "write `x.to_float()`"),
    (
        &["expect_equal", "assert_eq", "assert_equal", "assert", "check"],
        "write `expect(a == b)` or `expect_close(a, b, #{ relative: 1e-9 })`",
    ),
    (&["arange"], "write `linspace(0.0, 1.0, 11)`, or a loop over whole numbers: `for i in 0..10 { let t = 0.1 * i; }`"),
    (&["average", "avg"], "write `mean(array)`"),
    (&["maximum", "amax"], "write `max(array)`"),
    (&["minimum", "amin"], "write `min(array)`"),
    (&["optimize", "optimise", "fmin", "calibrate"], "write `minimize(|p| …, #{ bounds: #{ x: [0.0, 1.0] } })`"),
    (&["parallel", "study", "parameter_study"], "write `sweep(#{ vary: #{ x: [1.0, 2.0] }, run: |p| … })`"),
];

fn found(word: &str, among: &'static [(&[&str], &str)]) -> Option<&'static str> {
    among.iter().find(|(words, _)| words.contains(&word)).map(|(_, hint)| *hint)
}

/// Returns a hint for a word of another language.
pub fn instead_of(word: &str) -> Option<&'static str> {
    found(word, WORDS)
}

/// Returns a hint for a call of a function of another language.
pub fn instead_of_call(name: &str) -> Option<&'static str> {
    found(name, CALLS).or_else(|| found(name, WORDS))
}

/// Returns a hint for a construct of another language that begins with the name in front of `rest`.
pub fn meant(before: &str, name: &str, rest: &str) -> Option<String> {
    let (before, rest) = (before.trim_end(), rest.trim_start());
    if rest.starts_with("=>") || rest.starts_with("->") {
        return Some(format!("write a closure as `|{name}| …`"));
    }
    if is_comprehension(before, rest) {
        return Some(LIST_BY_LOOP.into());
    }
    if rest.starts_with('=') && !rest.starts_with("==") && before.ends_with(['(', ',']) {
        return Some(format!("options are a map: write `(#{{ {name}: … }})`, with `:` between name and value"));
    }
    let is_entry = rest.starts_with(':') && !rest.starts_with("::");
    if is_entry && before.ends_with(['(', '{', ',']) {
        return Some(format!("options are a map that begins with `#{{`, such as `#{{ {name}: … }}`"));
    }
    None
}

/// Hint how to make an array of computed values.
pub const LIST_BY_LOOP: &str = "fill the array in a loop: `let l = []; for i in 0..3 { l.push(2 * i); }`";

/// True if the name between these texts is part of a list comprehension `[… for … in …]`.
fn is_comprehension(before: &str, rest: &str) -> bool {
    let inside = rest.split([']', ';', '\n']).next().unwrap_or("");
    let opened = before.rsplit(['\n', ';']).next().unwrap_or("").contains('[');
    opened && inside.split_once(" for ").is_some_and(|(_, rest)| rest.contains(" in "))
}

/// Returns a hint for an option that other programs have.
pub fn option(name: &str) -> Option<&'static str> {
    match name {
        "mu" | "friction_coefficient" | "coefficient_of_friction" => Some("the coefficient of friction is the option `friction`"),
        "timestep" | "time_step" | "step_size" => Some("write `dt`"),
        "varies" | "parameters" | "params" | "grid" | "points" => Some("what differs between points is `vary: #{ name: [values] }`"),
        "jobs" | "workers" | "parallel" | "processes" => Some("how many points are computed at a time is `threads`"),
        "maxiter" | "max_iterations" | "max_evaluations" | "maxfun" => Some("how often a closure is called at most is `evaluations`"),
        _ => None,
    }
}

/// Returns a hint for an operator of another language, or between wrong values.
pub fn operator(sign: &str) -> Option<&'static str> {
    match sign {
        "++" => Some("write `i += 1`"),
        "--" => Some("write `i -= 1`"),
        "?" => Some("`if` gives a value: `let a = if condition { 1 } else { 2 };`"),
        "^" => Some("write a power as `x ** y`"),
        ".." | "..=" => Some("a range is one of whole numbers: `for i in 0..10 { let t = 0.1 * i; }`"),
        "===" => Some("write `==`"),
        "!==" | "<>" => Some("write `!=`"),
        "//" => Some("write `(a / b).floor()`"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_follows_a_name_tells_what_was_meant() {
        assert_eq!(meant("f(", "t", " => 2 * t)").unwrap(), "write a closure as `|t| …`");
        assert!(meant("rectangle({ ", "size", ": [2, 1] })").unwrap().contains("`#{ size: … }`"));
        assert!(meant("rectangle(size: 1, ", "cells", ": 2)").is_some());
        assert!(meant("rectangle(", "size", "=[4,1])").unwrap().contains("`(#{ size: … })`"));
        assert_eq!(meant("let l = [", "i", "*2 for i in 0..3];"), Some(LIST_BY_LOOP.into()));
        assert_eq!(meant("let l = [1]; x = ", "i", "; for i in 0..3 {}"), None);
        assert_eq!(meant("x = ", "rings", "::f()"), None);
        assert_eq!(meant("x = ", "a", " + 1"), None);
        assert_eq!(instead_of("and"), Some("write `&&`"));
        assert_eq!((instead_of("size"), instead_of_call("size")), (None, Some("write `x.len()`")));
    }
}
