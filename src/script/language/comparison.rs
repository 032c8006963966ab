//! Comparisons of numbers.
//!
//! Fractions are equal if they differ by the round-off of one operation, 2e-16 of their size: `0.1 + 0.2 == 0.3`, and `while t < 1.0` ends
//! after ten steps of 0.1. The engine's own comparisons also take all differences below 2e-16 for zero, and infinity for equal to all
//! numbers: `1e-20 > 0.0` and `inf > 1.0` would be false. Densities in tonnes and lengths in metres can be that small.

use rhai::{FuncRegistration, Module};

/// A comparison of fractions.
type Comparison = fn(f64, f64) -> bool;

const COMPARISONS: [(&str, Comparison); 6] = [
    ("==", equal),
    ("!=", |a, b| !equal(a, b)),
    ("<", |a, b| a < b && !equal(a, b)),
    ("<=", |a, b| a < b || equal(a, b)),
    (">", |a, b| a > b && !equal(a, b)),
    (">=", |a, b| a > b || equal(a, b)),
];

fn equal(a: f64, b: f64) -> bool {
    let size = a.abs().max(b.abs());
    a == b || (size.is_finite() && (a - b).abs() <= f64::EPSILON * size)
}

/// Adds the comparisons to a module.
pub fn register(module: &mut Module) {
    for (sign, compare) in COMPARISONS {
        let add = |a: &str, b: &str| {
            let described = [format!("a: {a}"), format!("b: {b}"), "bool".to_string()];
            FuncRegistration::new(sign).in_global_namespace().with_params_info(described)
        };
        add("float", "float").set_into_module(module, move |a: f64, b: f64| compare(a, b));
        add("float", "int").set_into_module(module, move |a: f64, b: i64| compare(a, b as f64));
        add("int", "float").set_into_module(module, move |a: i64, b: f64| compare(a as f64, b));
    }
}

#[cfg(test)]
mod tests {
    use super::equal;

    #[test]
    fn round_off_is_relative() {
        assert!(equal(0.1 + 0.2, 0.3) && equal(1e-20 * 3.0, 3e-20) && equal(f64::INFINITY, f64::INFINITY) && equal(0.0, -0.0));
        assert!(!equal(1e-20, 0.0) && !equal(1e-200, 2e-200) && !equal(f64::INFINITY, 1.0) && !equal(f64::NAN, f64::NAN));
        assert!(!equal(f64::INFINITY, f64::NEG_INFINITY) && !equal(f64::NAN, f64::INFINITY));
    }
}
