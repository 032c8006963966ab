//! Semantics of the names and functions of an energy's text: from the syntax tree to a graph of variables and numbers.
//!
//! Constants are replaced by numbers. Terms without a value or derivative at rest (`ln 0`, `1/0`, `sqrt 0`) are refused with their place.

use std::ops::Range;

use super::error::EnergyError;
use super::graph::{Graph, Id};
use super::syntax::{Expression, Form, Operator};
use super::variable::{Bits, Variable};

/// Quantities that an energy may contain, with descriptions for messages and the reference.
pub(super) const QUANTITIES: &[(&str, &str)] = &[
    ("I1", "first invariant of `C = F^T F`, its trace"),
    ("I2", "second invariant of `C`"),
    ("I3", "third invariant of `C`, `J^2`"),
    ("J", "volume ratio `det F`"),
    ("I1bar", "`J^(-2/3) I1`"),
    ("I2bar", "`J^(-4/3) I2`"),
    ("I4", "squared stretch of the first fiber"),
    ("I6", "squared stretch of the second fiber"),
    ("I4bar", "`J^(-2/3) I4`"),
    ("I6bar", "`J^(-2/3) I6`"),
    ("E11", "component of the Green-Lagrange strain; so are `E22`, `E33`, `E12`, `E23`, `E13`"),
    ("log_strain_squared", "`(ln l1)^2 + (ln l2)^2 + (ln l3)^2` of the principal stretches"),
];

/// Functions that an energy may call, with description and number of arguments.
pub(super) const FUNCTIONS: &[(&str, &str, usize)] = &[
    ("ln", "natural logarithm", 1),
    ("exp", "exponential function", 1),
    ("sqrt", "square root", 1),
    ("pow", "`pow(x, p)` is `x^p`, with a fixed `p`", 2),
    ("sinh", "hyperbolic sine", 1),
    ("cosh", "hyperbolic cosine", 1),
    ("tanh", "hyperbolic tangent", 1),
    ("abs", "magnitude", 1),
    ("pos", "`x` where it is positive, 0 elsewhere: a fiber that does not push", 1),
    ("max", "the greater of two", 2),
    ("min", "the smaller of two", 2),
    ("stretch_power", "`stretch_power(a)` is `l1^a + l2^a + l3^a` of the principal stretches, with a fixed `a`", 1),
];

/// Ambiguous name of a logarithm: natural in other programs, to base 10 in scripts.
const AMBIGUOUS: &str = "log";

/// Components of the strain in the order of the Mandel components in space.
const STRAINS: [[&str; 2]; 6] = [["E11", "E11"], ["E22", "E22"], ["E33", "E33"], ["E12", "E21"], ["E23", "E32"], ["E13", "E31"]];

/// Available components of the strain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Setting {
    /// Plane strain: no strain in the third direction.
    Plane,
    /// The third direction is stretched but not sheared.
    Axisymmetric,
    /// Space: all components.
    Space,
}

/// True if `name` is a quantity in any setting; constants need other names.
pub(super) fn is_quantity(name: &str) -> bool {
    QUANTITIES.iter().any(|(quantity, _)| *quantity == name) || STRAINS.iter().flatten().any(|strain| *strain == name) || name == "pi"
}

/// Names in a text that are neither quantities nor functions, that is constants, each with its first position.
pub(super) fn constants_of(expression: &Expression) -> Vec<(String, Range<usize>)> {
    fn collect(expression: &Expression, found: &mut Vec<(String, Range<usize>)>) {
        match &expression.form {
            Form::Number(_) => {}
            Form::Name(name) => {
                if !is_quantity(name) && !found.iter().any(|(known, _)| known == name) {
                    found.push((name.clone(), expression.span.clone()));
                }
            }
            Form::Negative(inner) => collect(inner, found),
            Form::Binary(_, a, b) => [a, b].into_iter().for_each(|part| collect(part, found)),
            Form::Call(name, arguments) => {
                // An unknown function such as in `mu (I1 - 3)` is a constant with a missing multiplication sign.
                let is_function = name == AMBIGUOUS || FUNCTIONS.iter().any(|(function, ..)| function == name);
                if !is_function && !is_quantity(name) && !found.iter().any(|(known, _)| known == name) {
                    found.push((name.clone(), expression.span.start..expression.span.start + name.len()));
                }
                arguments.iter().for_each(|argument| collect(argument, found));
            }
        }
    }
    let mut found = Vec::new();
    collect(expression, &mut found);
    found
}

/// Translates texts into a graph.
pub(super) struct Translation<'a> {
    pub(super) graph: &'a mut Graph,
    pub(super) text: &'a str,
    pub(super) setting: Setting,
    pub(super) fibers: usize,
    pub(super) constants: &'a [(String, f64)],
}

impl Translation<'_> {
    fn error(&self, span: &Range<usize>, title: impl Into<String>, label: impl Into<String>) -> EnergyError {
        EnergyError::new(self.text, span.clone(), title, label)
    }

    /// The node of an expression.
    pub(super) fn node(&mut self, expression: &Expression) -> Result<Id, EnergyError> {
        let id = match &expression.form {
            Form::Number(value) => self.graph.constant(*value),
            Form::Name(name) => self.named(name, &expression.span)?,
            Form::Negative(inner) => {
                let inner = self.node(inner)?;
                self.graph.scaled(-1.0, inner)
            }
            Form::Binary(operator, left, right) => {
                let (a, b) = (self.node(left)?, self.node(right)?);
                match operator {
                    Operator::Plus => self.graph.sum(a, b),
                    Operator::Minus => self.graph.difference(a, b),
                    Operator::Times => self.graph.product(a, b),
                    Operator::Over => {
                        if self.graph.rest(b) == 0.0 {
                            let error = self.error(&right.span, "the energy divides by what is zero at rest", "zero at rest");
                            return Err(error.cause("at rest `I1 = I2 = 3`, `J = I4 = 1`, and strains are 0"));
                        }
                        let reciprocal = self.graph.reciprocal(b);
                        self.graph.product(a, reciprocal)
                    }
                    Operator::Power => self.power(a, b, left)?,
                }
            }
            Form::Call(name, arguments) => self.call(name, arguments, &expression.span)?,
        };
        if self.graph.rest(id).is_finite() {
            return Ok(id);
        }
        Err(self
            .error(&expression.span, "the energy has no finite value at rest", "not finite at rest")
            .hint("check the constants' values"))
    }

    fn named(&mut self, name: &str, span: &Range<usize>) -> Result<Id, EnergyError> {
        if let Some(component) = STRAINS.iter().position(|names| names.contains(&name)) {
            let is_there = match self.setting {
                Setting::Plane => component != 2 && component < 4,
                Setting::Axisymmetric => component < 4,
                Setting::Space => true,
            };
            return Ok(if is_there { self.graph.variable(Variable::Strain(component)) } else { self.graph.constant(0.0) });
        }
        Ok(match name {
            "pi" => self.graph.constant(std::f64::consts::PI),
            "I1" => self.graph.variable(Variable::I1),
            "I2" => self.second_invariant(),
            "J" => self.graph.variable(Variable::J),
            "I3" => self.volume_power(2.0),
            "I1bar" => self.isochoric(Variable::I1, -2.0 / 3.0),
            "I2bar" => {
                let (second, volume) = (self.second_invariant(), self.volume_power(-4.0 / 3.0));
                self.graph.product(second, volume)
            }
            "I4" | "I6" | "I4bar" | "I6bar" => {
                let fiber = usize::from(name.starts_with("I6"));
                if fiber >= self.fibers {
                    let (title, needs) = match fiber {
                        0 => ("the energy names a fiber, but none is given", "needs a fiber"),
                        _ => ("the energy names a second fiber, but none is given", "needs a second fiber"),
                    };
                    let hint =
                        if fiber == 0 { "give its direction, `fiber: [1, 0]`" } else { "give both directions, `fibers: [[1, 0], [0, 1]]`" };
                    return Err(self.error(span, title, needs).hint(hint));
                }
                let variable = Variable::Fiber(fiber);
                if name.ends_with("bar") { self.isochoric(variable, -2.0 / 3.0) } else { self.graph.variable(variable) }
            }
            "log_strain_squared" => self.graph.variable(Variable::LogStrainSquared),
            _ => match self.constants.iter().find(|(known, _)| known == name) {
                Some((_, value)) => self.graph.constant(*value),
                None => return Err(self.unknown(name, span)),
            },
        })
    }

    fn unknown(&self, name: &str, span: &Range<usize>) -> EnergyError {
        let error = self.error(span, format!("the energy names `{name}`, which has no value"), "no value");
        let quantities: Vec<String> = QUANTITIES.iter().map(|(name, _)| format!("`{name}`")).collect();
        let error = error.cause(format!("known without a value are {}", quantities.join(", ")));
        if FUNCTIONS.iter().any(|(function, ..)| *function == name) {
            return error.hint(format!("`{name}` is a function: write `{name}(…)`"));
        }
        error.hint(format!("give the constant its value, `{name}: 1.0`"))
    }

    /// In plane strain `I2 = I1 + J^2 - 1`, which saves a variable.
    fn second_invariant(&mut self) -> Id {
        if self.setting != Setting::Plane {
            return self.graph.variable(Variable::I2);
        }
        let (first, third, minus) = (self.graph.variable(Variable::I1), self.volume_power(2.0), self.graph.constant(-1.0));
        let sum = self.graph.sum(first, third);
        self.graph.sum(sum, minus)
    }

    fn volume_power(&mut self, p: f64) -> Id {
        let volume = self.graph.variable(Variable::J);
        self.graph.power(volume, p)
    }

    fn isochoric(&mut self, variable: Variable, p: f64) -> Id {
        let (variable, volume) = (self.graph.variable(variable), self.volume_power(p));
        self.graph.product(variable, volume)
    }

    fn power(&mut self, a: Id, b: Id, base: &Expression) -> Result<Id, EnergyError> {
        let Some(p) = self.graph.as_constant(b) else {
            // a^b = exp(b ln a)
            let logarithm = self.logarithm(a, base)?;
            let product = self.graph.product(b, logarithm);
            return Ok(self.graph.exponential(product));
        };
        let rest = self.graph.rest(a);
        let is_whole = p.fract() == 0.0 && p.abs() <= 32.0;
        if rest < 0.0 && !is_whole || rest == 0.0 && (p < 0.0 || !is_whole) {
            let sign = if rest == 0.0 { "zero" } else { "negative" };
            let error =
                self.error(&base.span, format!("the energy raises to the power {p:?} what is {sign} at rest"), format!("{sign} at rest"));
            return Err(error.hint(format!("only powers 0, 1, 2, … to 32 of `{}` have derivatives there", &self.text[base.span.clone()])));
        }
        Ok(self.graph.power(a, p))
    }

    fn logarithm(&mut self, a: Id, argument: &Expression) -> Result<Id, EnergyError> {
        if self.graph.rest(a) > 0.0 {
            return Ok(self.graph.logarithm(a));
        }
        let label = format!("{:?} at rest", self.graph.rest(a));
        let error = self.error(&argument.span, "the energy takes the logarithm of what is not positive at rest", label);
        Err(error.hint("apply it to a quantity that is about 1 in the undeformed state, as in `ln(J)`"))
    }

    fn call(&mut self, name: &str, arguments: &[Expression], span: &Range<usize>) -> Result<Id, EnergyError> {
        let name_span = span.start..span.start + name.len();
        let Some((_, _, count)) = FUNCTIONS.iter().find(|(known, ..)| *known == name) else {
            return Err(self.not_a_function(name, &name_span));
        };
        if arguments.len() != *count {
            let title = format!("`{name}` takes {count} argument{}", if *count == 1 { "" } else { "s" });
            return Err(self.error(span, title, format!("{} given", arguments.len())));
        }
        let ids = arguments.iter().map(|argument| self.node(argument)).collect::<Result<Vec<Id>, _>>()?;
        let a = ids[0];
        Ok(match name {
            "ln" => self.logarithm(a, &arguments[0])?,
            "exp" => self.graph.exponential(a),
            "sqrt" => self.square_root(a, &arguments[0])?,
            "pow" => self.power(a, ids[1], &arguments[0])?,
            "sinh" => self.hyperbolic(a, -0.5),
            "cosh" => self.hyperbolic(a, 0.5),
            "tanh" => self.tangent(a),
            "abs" => {
                let negative = self.graph.scaled(-1.0, a);
                let (up, down) = (self.graph.positive(a), self.graph.positive(negative));
                self.graph.sum(up, down)
            }
            "pos" => self.graph.positive(a),
            "max" | "min" => {
                // max(a, b) = b + pos(a - b), min(a, b) = b - pos(b - a)
                let difference = if name == "max" { self.graph.difference(a, ids[1]) } else { self.graph.difference(ids[1], a) };
                let positive = self.graph.positive(difference);
                if name == "max" { self.graph.sum(ids[1], positive) } else { self.graph.difference(ids[1], positive) }
            }
            _ => self.stretch_power(a, &arguments[0])?,
        })
    }

    fn not_a_function(&self, name: &str, span: &Range<usize>) -> EnergyError {
        if name == AMBIGUOUS {
            let error = self.error(span, "the energy has a logarithm without its base", "natural, or to base 10?");
            let error = error.cause("`log(x)` of a script is the logarithm to base 10, that of many papers the natural one");
            return error.hint("write `ln(x)` for the natural logarithm, `ln(x)/ln(10)` for that to base 10");
        }
        if is_quantity(name) || self.constants.iter().any(|(known, _)| known == name) {
            let error = self.error(span, format!("`{name}` is called like a function, but is none"), "not a function");
            return error.hint(format!("write a product with `*`: `{name}*(…)`"));
        }
        let known: Vec<String> = FUNCTIONS.iter().map(|(name, ..)| format!("`{name}`")).collect();
        let error = self.error(span, format!("the energy has no function `{name}`"), "unknown function");
        error.cause(format!("its functions are {}", known.join(", "))).hint("write a product with `*`")
    }

    fn square_root(&mut self, a: Id, argument: &Expression) -> Result<Id, EnergyError> {
        if self.graph.rest(a) > 0.0 || self.graph.as_constant(a) == Some(0.0) {
            return Ok(self.graph.root(a));
        }
        let label = format!("{:?} at rest", self.graph.rest(a));
        let error = self.error(&argument.span, "the energy takes the square root of what is not positive at rest", label);
        Err(error.hint("keep it above zero, as in `sqrt(1 + x)`: the root of zero has no slope"))
    }

    /// Hyperbolic cosine (`sign` 1/2) or sine (-1/2): `exp(a)/2 + sign exp(-a)`.
    fn hyperbolic(&mut self, a: Id, sign: f64) -> Id {
        let negative = self.graph.scaled(-1.0, a);
        let (up, down) = (self.graph.exponential(a), self.graph.exponential(negative));
        let (up, down) = (self.graph.scaled(0.5, up), self.graph.scaled(sign, down));
        self.graph.sum(up, down)
    }

    /// Hyperbolic tangent, `1 - 2/(exp(2a) + 1)`.
    fn tangent(&mut self, a: Id) -> Id {
        let (double, one) = (self.graph.scaled(2.0, a), self.graph.constant(1.0));
        let exponential = self.graph.exponential(double);
        let above = self.graph.sum(exponential, one);
        let reciprocal = self.graph.reciprocal(above);
        let twice = self.graph.scaled(-2.0, reciprocal);
        self.graph.sum(one, twice)
    }

    fn stretch_power(&mut self, a: Id, argument: &Expression) -> Result<Id, EnergyError> {
        let Some(exponent) = self.graph.as_constant(a) else {
            let error = self.error(&argument.span, "`stretch_power` takes a fixed exponent", "not fixed");
            return Err(error.hint("write a number or a constant"));
        };
        // The sums of l_i^2 (I1) and l_i^-2 (I2/J^2) need no principal stretches.
        Ok(if exponent == 0.0 {
            self.graph.constant(3.0)
        } else if exponent == 2.0 {
            self.graph.variable(Variable::I1)
        } else if exponent == -2.0 {
            let (second, volume) = (self.second_invariant(), self.volume_power(-2.0));
            self.graph.product(second, volume)
        } else {
            self.graph.variable(Variable::StretchPower(Bits::of(exponent)))
        })
    }
}
