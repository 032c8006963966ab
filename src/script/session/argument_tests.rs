//! Reading of arguments by scripts: the title of the resulting error.

use std::path::Path;
use std::rc::Rc;

use super::session::Session;
use crate::script::language::observer::Silent;
use crate::script::language::settings::Settings;

/// Returns the title of the error with which a script ends, or `ok`.
fn title(text: &str) -> String {
    let mut session = Session::new(Settings::default(), Path::new("."), Rc::new(Silent)).unwrap();
    session.evaluate("test.rhai", text).map_or_else(|error| error.title, |_| "ok".into())
}

#[test]
fn whole_numbers_and_fractions_are_numbers() {
    for text in ["hat(0, 1, 5)", "hat(0.0, 1, 5.0)", "rectangle(#{ size: [2, 1.5], cells: [2.0, 1] })", "sqrt(2)", "deg(30)"] {
        assert_eq!(title(text), "ok", "{text}");
    }
}

#[test]
fn a_misspelt_key_is_not_called_missing() {
    assert_eq!(title("rectangle(#{ sise: [2, 1], cells: [2, 1] })"), "`rectangle` has no option `sise`");
    assert_eq!(title("rectangle(#{ cells: [2, 1] })"), "`rectangle` needs the option `size`");
    assert_eq!(title("rectangle(#{})"), "`rectangle` needs the options `size` and `cells`");
}

#[test]
fn ranges_and_types_are_checked() {
    for (text, expected) in [
        ("ramp(0, 1, \"5\")", "`value` of `ramp` must be a number"),
        ("ramp(0, 1, ())", "`value` of `ramp` must be a number"),
        ("ramp(0, 1, 1.0/0.0)", "`value` of `ramp` must be a finite number"),
        ("rectangle(#{ size: [2, 0], cells: [2, 1] })", "every entry of `size` of `rectangle` must be greater than 0"),
        ("rectangle(#{ size: 2, cells: [2, 1] })", "`size` of `rectangle` must be an array of numbers, such as `[1.0, 0.0]` [length]"),
        ("rectangle(#{ size: [2, \"1\"], cells: [2, 1] })", "`size` of `rectangle` must be an array of numbers"),
        ("rectangle(#{ size: [2, 1], cells: [2] })", "`cells` of `rectangle` must have 2 entries"),
        ("rectangle(#{ size: [2, 1], cells: [2, 1], element: \"hex8\" })", "`element` of `rectangle` cannot be \"hex8\""),
        ("rectangle([2, 1])", "`options` of `rectangle` must be an object map `#{ … }`"),
        ("model(5)", "`name` of `model` must be a string"),
        ("expect(1)", "`condition` of `expect` must be `true` or `false`"),
    ] {
        assert_eq!(title(text), expected, "{text}");
    }
}

#[test]
fn a_number_is_a_time_function() {
    let text = "let s = neo_hookean(#{ youngs_modulus: 1, poisson_ratio: 0, density: 1 }); let m = model(\"m\"); \
                let b = m.add_body(\"b\", rectangle(#{ size: [1, 1], cells: [1, 1] }), s); m.torque(b.boundary(\"top\"), ";
    for amplitude in ["5", "2.5", "hat(0, 1, 5)", "|t| 2 * t", "Fn(\"sin\")"] {
        assert_eq!(title(&format!("{text}{amplitude})")), "ok", "{amplitude}");
    }
    assert!(title(&format!("{text}[1.0])")).starts_with("`amplitude` of `torque` must be a number, a time function"));
}
