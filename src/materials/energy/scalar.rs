//! Function of one variable as text, with two derivatives: stored energy of a spring over elongation, force of a damper over speed.
//!
//! The syntax is that of energies (`syntax.rs`), with the variable as the only quantity; all other names are constants. Derivatives are
//! computed with the value (forward mode).

use std::ops::Range;

use super::error::EnergyError;
use super::syntax::{Expression, Form, Operator, parse};

/// Functions that the text may call, with their numbers of arguments.
const FUNCTIONS: &[(&str, usize)] = &[
    ("ln", 1),
    ("exp", 1),
    ("sqrt", 1),
    ("pow", 2),
    ("sin", 1),
    ("cos", 1),
    ("atan", 1),
    ("sinh", 1),
    ("cosh", 1),
    ("tanh", 1),
    ("abs", 1),
    ("pos", 1),
    ("max", 2),
    ("min", 2),
];

/// A value with its first and second derivative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet {
    /// Value of the function.
    pub value: f64,
    /// Derivative with respect to the variable.
    pub slope: f64,
    /// Second derivative.
    pub curvature: f64,
}

impl Jet {
    fn constant(value: f64) -> Self {
        Jet { value, slope: 0.0, curvature: 0.0 }
    }

    /// `f(self)` by the chain rule, with value and derivatives of `f`.
    fn through(self, value: f64, slope: f64, curvature: f64) -> Self {
        // A constant argument gives a constant, even if the function has no finite slope there.
        if self.slope == 0.0 && self.curvature == 0.0 {
            return Jet::constant(value);
        }
        Jet { value, slope: slope * self.slope, curvature: curvature * self.slope * self.slope + slope * self.curvature }
    }

    fn plus(self, other: Jet) -> Jet {
        Jet { value: self.value + other.value, slope: self.slope + other.slope, curvature: self.curvature + other.curvature }
    }

    fn times(self, other: Jet) -> Jet {
        Jet {
            value: self.value * other.value,
            slope: self.slope * other.value + self.value * other.slope,
            curvature: self.curvature * other.value + 2.0 * self.slope * other.slope + self.value * other.curvature,
        }
    }

    fn scaled(self, factor: f64) -> Jet {
        Jet { value: factor * self.value, slope: factor * self.slope, curvature: factor * self.curvature }
    }

    fn reciprocal(self) -> Jet {
        let x = self.value;
        self.through(1.0 / x, -1.0 / (x * x), 2.0 / (x * x * x))
    }

    fn power(self, exponent: Jet) -> Jet {
        if exponent.slope != 0.0 || exponent.curvature != 0.0 {
            return self.call("ln").times(exponent).call("exp");
        }
        let (x, p) = (self.value, exponent.value);
        let power =
            |factor: f64, p: f64| if factor == 0.0 { 0.0 } else { factor * if p.fract() == 0.0 { x.powi(p as i32) } else { x.powf(p) } };
        self.through(power(1.0, p), power(p, p - 1.0), power(p * (p - 1.0), p - 2.0))
    }

    /// Applies the function `name` of one argument.
    fn call(self, name: &str) -> Jet {
        let x = self.value;
        match name {
            "ln" => self.through(x.ln(), 1.0 / x, -1.0 / (x * x)),
            "exp" => self.through(x.exp(), x.exp(), x.exp()),
            "sqrt" => self.through(x.sqrt(), 0.5 / x.sqrt(), -0.25 / (x * x.sqrt())),
            "sin" => self.through(x.sin(), x.cos(), -x.sin()),
            "cos" => self.through(x.cos(), -x.sin(), -x.cos()),
            "atan" => self.through(x.atan(), 1.0 / (1.0 + x * x), -2.0 * x / (1.0 + x * x).powi(2)),
            "sinh" => self.through(x.sinh(), x.cosh(), x.sinh()),
            "cosh" => self.through(x.cosh(), x.sinh(), x.cosh()),
            "tanh" => {
                let slope = 1.0 / x.cosh().powi(2);
                self.through(x.tanh(), slope, -2.0 * x.tanh() * slope)
            }
            "abs" if x < 0.0 => self.scaled(-1.0),
            "pos" if x <= 0.0 => Jet::constant(0.0),
            _ => self,
        }
    }
}

/// Function of one variable, defined by a text.
#[derive(Clone, Debug, PartialEq)]
pub struct ScalarText {
    text: String,
    expression: Expression,
    variable: String,
    constants: Vec<(String, f64)>,
}

impl ScalarText {
    /// Function of a text with values of its constants; `what` describes it in messages, such as `the energy`.
    ///
    /// # Errors
    /// A syntax error or an unknown name, with its place in the text.
    pub fn new(text: &str, variable: &str, constants: &[(String, f64)], what: &str) -> Result<Self, EnergyError> {
        let expression = parse(text).map_err(|error| EnergyError {
            title: error.title.replace("the energy", what),
            hint: error.hint.replace("mu*(I1 - 3)", &format!("2*({variable} + 3)")).replace("ln(J)", "exp(…)").into(),
            ..error
        })?;
        let function = ScalarText { text: text.into(), expression, variable: variable.into(), constants: constants.to_vec() };
        function.check(&function.expression, what)?;
        Ok(function)
    }

    /// Names of constants in a text, each with the bytes of its first occurrence; empty for a text with a syntax error.
    pub fn constants_of(text: &str, variable: &str) -> Vec<(String, Range<usize>)> {
        fn collect(expression: &Expression, variable: &str, found: &mut Vec<(String, Range<usize>)>) {
            match &expression.form {
                Form::Number(_) => {}
                Form::Name(name) => {
                    if name != variable && name != "pi" && !found.iter().any(|(known, _)| known == name) {
                        found.push((name.clone(), expression.span.clone()));
                    }
                }
                Form::Negative(inner) => collect(inner, variable, found),
                Form::Binary(_, a, b) => [a, b].into_iter().for_each(|part| collect(part, variable, found)),
                Form::Call(_, arguments) => arguments.iter().for_each(|argument| collect(argument, variable, found)),
            }
        }
        let mut found = Vec::new();
        if let Ok(expression) = parse(text) {
            collect(&expression, variable, &mut found);
        }
        found
    }

    /// Source text of the function.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Value and derivatives at `x`; NaN where undefined.
    pub fn at(&self, x: f64) -> Jet {
        self.evaluate(&self.expression, x)
    }

    /// First of the given points at which value or slope is not finite; `None` if both are finite at all points.
    pub fn is_undefined_at(&self, places: &[f64]) -> Option<f64> {
        let is_finite = |x: f64| self.at(x).value.is_finite() && self.at(x).slope.is_finite();
        places.iter().copied().find(|&x| !is_finite(x))
    }

    fn evaluate(&self, expression: &Expression, x: f64) -> Jet {
        match &expression.form {
            Form::Number(value) => Jet::constant(*value),
            Form::Name(name) if *name == self.variable => Jet { value: x, slope: 1.0, curvature: 0.0 },
            Form::Name(name) if name == "pi" => Jet::constant(std::f64::consts::PI),
            Form::Name(name) => {
                let known = self.constants.iter().find(|(known, _)| known == name);
                Jet::constant(known.map_or(f64::NAN, |(_, value)| *value))
            }
            Form::Negative(inner) => self.evaluate(inner, x).scaled(-1.0),
            Form::Binary(operator, left, right) => {
                let (a, b) = (self.evaluate(left, x), self.evaluate(right, x));
                match operator {
                    Operator::Plus => a.plus(b),
                    Operator::Minus => a.plus(b.scaled(-1.0)),
                    Operator::Times => a.times(b),
                    Operator::Over => a.times(b.reciprocal()),
                    Operator::Power => a.power(b),
                }
            }
            Form::Call(name, arguments) => {
                let values: Vec<Jet> = arguments.iter().map(|argument| self.evaluate(argument, x)).collect();
                match (name.as_str(), &values[..]) {
                    ("pow", [a, b]) => a.power(*b),
                    ("max", [a, b]) => {
                        if a.value >= b.value {
                            *a
                        } else {
                            *b
                        }
                    }
                    ("min", [a, b]) => {
                        if a.value <= b.value {
                            *a
                        } else {
                            *b
                        }
                    }
                    (name, [a]) => a.call(name),
                    _ => Jet::constant(f64::NAN),
                }
            }
        }
    }

    /// Checks that all names and functions are known.
    fn check(&self, expression: &Expression, what: &str) -> Result<(), EnergyError> {
        let error = |span: &Range<usize>, title: String, label: &str| EnergyError::new(&self.text, span.clone(), title, label);
        match &expression.form {
            Form::Number(_) => Ok(()),
            Form::Name(name) => {
                let is_known = *name == self.variable || name == "pi" || self.constants.iter().any(|(known, _)| known == name);
                if is_known {
                    return Ok(());
                }
                let error = error(&expression.span, format!("{what} names `{name}`, which has no value"), "no value");
                let error = error.cause(format!("its variable is `{}`, every other name is a constant", self.variable));
                Err(error.hint("give the constant its value"))
            }
            Form::Negative(inner) => self.check(inner, what),
            Form::Binary(_, a, b) => self.check(a, what).and_then(|()| self.check(b, what)),
            Form::Call(name, arguments) => {
                let span = expression.span.start..expression.span.start + name.len();
                let Some((_, count)) = FUNCTIONS.iter().find(|(known, _)| known == name) else {
                    let known: Vec<String> = FUNCTIONS.iter().map(|(name, _)| format!("`{name}`")).collect();
                    let error = error(&span, format!("{what} has no function `{name}`"), "unknown function");
                    let hint = if name == "log" { "write `ln(…)` for the natural logarithm" } else { "write a product with `*`" };
                    return Err(error.cause(format!("its functions are {}", known.join(", "))).hint(hint));
                };
                if arguments.len() != *count {
                    let title = format!("`{name}` takes {count} argument{}", if *count == 1 { "" } else { "s" });
                    return Err(error(&expression.span, title, "another number is given"));
                }
                arguments.iter().try_for_each(|argument| self.check(argument, what))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_the_value() {
        let constants = [("k".to_string(), 3.0)];
        let texts = [
            "k/2*x^2 + x^4/4 - x^3",
            "exp(-k*x)*sin(2*x) + cos(x)",
            "ln(1 + x^2)/sqrt(2 + x)",
            "tanh(k*x) + sinh(x) - cosh(x)*atan(x)",
            "pow(abs(x), 1.5) + max(x, x^2) + min(1, x)",
            "pos(x)^2 + 2^x + (1 + x^2)^x",
        ];
        for text in texts {
            let function = ScalarText::new(text, "x", &constants, "the energy").unwrap();
            for x in [-0.7, 0.3, 1.4] {
                let (h, at) = (1e-5, function.at(x));
                let (up, down) = (function.at(x + h), function.at(x - h));
                assert!(((up.value - down.value) / (2.0 * h) - at.slope).abs() < 1e-7, "{text} at {x}");
                assert!(((up.slope - down.slope) / (2.0 * h) - at.curvature).abs() < 1e-7, "{text} at {x}");
            }
        }
        let square = ScalarText::new("x^2", "x", &[], "the energy").unwrap();
        assert_eq!(square.at(0.0), Jet { value: 0.0, slope: 0.0, curvature: 2.0 });
    }

    #[test]
    fn what_is_not_known_is_refused_with_its_place() {
        let refused = |text: &str| ScalarText::new(text, "v", &[], "the force").unwrap_err();
        let error = refused("3*v + k*v");
        assert_eq!((&error.text[error.span.clone()], error.title.as_str()), ("k", "the force names `k`, which has no value"));
        assert!(refused("log(v)").hint.contains("ln"));
        assert!(refused("3*v)").title.contains("bracket"));
        assert!(refused("pow(v)").title.contains("2 arguments"));
        assert_eq!(ScalarText::constants_of("k*v + c*v^3 + k", "v").len(), 2);
    }
}
