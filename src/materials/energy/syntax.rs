//! Text of an energy as a tree: sums, products, powers, names and calls, each with its byte range.
//!
//! Precedence climbing (Richards 1979): `+ -` below `* /` below the sign below `^`, which is right-associative: `-x^2` is `-(x^2)`, `a^b^c`
//! is `a^(b^c)`. `**` equals `^`. Names and functions are interpreted in `meaning.rs`.

use std::ops::Range;

use super::error::EnergyError;

/// A part of the text.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Expression {
    pub(super) form: Form,
    pub(super) span: Range<usize>,
}

/// Form of an expression.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Form {
    Number(f64),
    Name(String),
    Negative(Box<Expression>),
    Binary(Operator, Box<Expression>, Box<Expression>),
    Call(String, Vec<Expression>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Operator {
    Plus,
    Minus,
    Times,
    Over,
    Power,
}

#[derive(Clone, Debug, PartialEq)]
enum Token {
    Number(f64),
    Name(String),
    Operator(Operator),
    Open,
    Close,
    Comma,
}

/// Largest depth of nested brackets and powers: above any real law, below stack exhaustion.
const DEEPEST: usize = 50;
/// Largest number of tokens: above any real law.
const LONGEST: usize = 1000;

/// The tree of a text.
pub(super) fn parse(text: &str) -> Result<Expression, EnergyError> {
    let tokens = tokens(text)?;
    if tokens.len() > LONGEST {
        let span = tokens[LONGEST].1.clone();
        return Err(EnergyError::new(
            text,
            span,
            "the text of the energy is too long",
            format!("more than {LONGEST} numbers, names and signs"),
        )
        .hint("write the energy with fewer terms"));
    }
    let mut parser = Parser { text, tokens: &tokens, next: 0, depth: 0 };
    let expression = parser.sum()?;
    match parser.peek() {
        None => Ok(expression),
        Some((Token::Close, span)) => {
            let error = EnergyError::new(text, span.clone(), "a bracket is closed that was not opened", "there is no `(` for it");
            Err(error.hint("remove it, or open one before"))
        }
        Some((_, span)) => {
            let error =
                EnergyError::new(text, span.clone(), "the energy goes on where it should end", "an operator is missing before this");
            Err(error.hint("write products with `*`: `mu*(I1 - 3)`"))
        }
    }
}

fn tokens(text: &str) -> Result<Vec<(Token, Range<usize>)>, EnergyError> {
    let mut found = Vec::new();
    let mut start = 0;
    while let Some(first) = text[start..].chars().next() {
        let rest = &text[start..];
        let (token, length) = if first.is_whitespace() {
            start += first.len_utf8();
            continue;
        } else if first.is_ascii_digit() || first == '.' {
            let length = number_length(rest);
            let number = rest[..length].parse::<f64>().ok().filter(|number| number.is_finite());
            let number = number.ok_or_else(|| {
                EnergyError::new(text, start..start + length, "the energy has a number that is none", "not a number")
                    .hint("write `1.5` or `1e-3`")
            })?;
            (Token::Number(number), length)
        } else if first.is_alphabetic() || first == '_' {
            let length = rest.find(|letter: char| !letter.is_alphanumeric() && letter != '_').unwrap_or(rest.len());
            (Token::Name(rest[..length].to_string()), length)
        } else if rest.starts_with("**") {
            (Token::Operator(Operator::Power), 2)
        } else {
            let token = match first {
                '+' => Token::Operator(Operator::Plus),
                '-' => Token::Operator(Operator::Minus),
                '*' => Token::Operator(Operator::Times),
                '/' => Token::Operator(Operator::Over),
                '^' => Token::Operator(Operator::Power),
                '(' => Token::Open,
                ')' => Token::Close,
                ',' => Token::Comma,
                _ => {
                    let span = start..start + first.len_utf8();
                    return Err(EnergyError::new(
                        text,
                        span,
                        format!("the energy has a sign `{first}` that means nothing here"),
                        "unknown sign",
                    )
                    .hint("an energy is written with `+ - * / ^`, round brackets, numbers, names and functions such as `ln(J)`"));
                }
            };
            (token, 1)
        };
        found.push((token, start..start + length));
        start += length;
    }
    Ok(found)
}

/// Length in bytes of the number at the beginning of a text: digits, a point, an exponent.
fn number_length(text: &str) -> usize {
    let digits = |from: usize| from + text[from..].bytes().take_while(|byte| byte.is_ascii_digit() || *byte == b'.').count();
    let mantissa = digits(0);
    let Some(b'e' | b'E') = text.as_bytes().get(mantissa) else { return mantissa };
    let sign = usize::from(matches!(text.as_bytes().get(mantissa + 1), Some(b'+' | b'-')));
    let exponent = digits(mantissa + 1 + sign);
    if exponent > mantissa + 1 + sign { exponent } else { mantissa }
}

struct Parser<'a> {
    text: &'a str,
    tokens: &'a [(Token, Range<usize>)],
    next: usize,
    depth: usize,
}

impl<'a> Parser<'a> {
    fn peek(&self) -> Option<&'a (Token, Range<usize>)> {
        self.tokens.get(self.next)
    }

    fn operator(&self) -> Option<Operator> {
        match self.peek() {
            Some((Token::Operator(operator), _)) => Some(*operator),
            _ => None,
        }
    }

    fn takes(&mut self, token: &Token) -> bool {
        let found = self.peek().is_some_and(|(next, _)| next == token);
        self.next += usize::from(found);
        found
    }

    /// Reads a nested expression, up to the largest depth.
    fn within<T>(&mut self, read: impl FnOnce(&mut Self) -> Result<T, EnergyError>) -> Result<T, EnergyError> {
        if self.depth == DEEPEST {
            let span = self.peek().map_or(self.text.len()..self.text.len(), |(_, span)| span.clone());
            let error = EnergyError::new(self.text, span, "the energy has too many brackets and signs within each other", "too deep");
            return Err(error.hint(format!("write it with at most {DEEPEST}")));
        }
        self.depth += 1;
        let found = read(self);
        self.depth -= 1;
        found
    }

    fn sum(&mut self) -> Result<Expression, EnergyError> {
        let mut left = self.product()?;
        while let Some(operator @ (Operator::Plus | Operator::Minus)) = self.operator() {
            self.next += 1;
            left = binary(operator, left, self.product()?);
        }
        Ok(left)
    }

    fn product(&mut self) -> Result<Expression, EnergyError> {
        let mut left = self.signed()?;
        while let Some(operator @ (Operator::Times | Operator::Over)) = self.operator() {
            self.next += 1;
            left = binary(operator, left, self.signed()?);
        }
        Ok(left)
    }

    fn signed(&mut self) -> Result<Expression, EnergyError> {
        let Some((Token::Operator(sign @ (Operator::Plus | Operator::Minus)), span)) = self.peek() else { return self.power() };
        self.next += 1;
        let inner = self.within(Self::signed)?;
        let span = span.start..inner.span.end;
        let form = if *sign == Operator::Minus { Form::Negative(Box::new(inner)) } else { inner.form };
        Ok(Expression { form, span })
    }

    fn power(&mut self) -> Result<Expression, EnergyError> {
        let base = self.single()?;
        if self.operator() != Some(Operator::Power) {
            return Ok(base);
        }
        self.next += 1;
        let exponent = self.within(Self::signed)?;
        Ok(binary(Operator::Power, base, exponent))
    }

    fn single(&mut self) -> Result<Expression, EnergyError> {
        let Some((token, span)) = self.peek() else {
            let end = self.text.len();
            let error = EnergyError::new(self.text, end..end, "the energy ends too early", "something is missing here");
            return Err(error.hint("give a number, a name or a bracket"));
        };
        self.next += 1;
        match token {
            Token::Number(value) => Ok(Expression { form: Form::Number(*value), span: span.clone() }),
            Token::Name(name) if self.takes(&Token::Open) => {
                let arguments = self.within(|parser| parser.arguments(span))?;
                let end = self.tokens[self.next - 1].1.end;
                Ok(Expression { form: Form::Call(name.clone(), arguments), span: span.start..end })
            }
            Token::Name(name) => Ok(Expression { form: Form::Name(name.clone()), span: span.clone() }),
            Token::Open => {
                let inner = self.within(Self::sum)?;
                if !self.takes(&Token::Close) {
                    return Err(self.unclosed(span));
                }
                Ok(Expression { span: span.start..self.tokens[self.next - 1].1.end, ..inner })
            }
            _ => Err(EnergyError::new(
                self.text,
                span.clone(),
                "the energy has an operator without what it works on",
                "something is missing here",
            )
            .hint("give a number, a name or a bracket before it")),
        }
    }

    /// Reads arguments after an opened bracket, up to the closing one.
    fn arguments(&mut self, name: &Range<usize>) -> Result<Vec<Expression>, EnergyError> {
        let mut arguments = Vec::new();
        if self.takes(&Token::Close) {
            return Ok(arguments);
        }
        loop {
            arguments.push(self.sum()?);
            if self.takes(&Token::Comma) {
                continue;
            }
            return if self.takes(&Token::Close) { Ok(arguments) } else { Err(self.unclosed(&(name.start..name.end + 1))) };
        }
    }

    fn unclosed(&self, opened: &Range<usize>) -> EnergyError {
        let error = EnergyError::new(self.text, opened.clone(), "a bracket is not closed", "opened here");
        match self.peek() {
            Some((_, span)) => error.hint(format!("close it before `{}`, or write an operator there", &self.text[span.clone()])),
            None => error.hint("close it with `)`"),
        }
    }
}

fn binary(operator: Operator, left: Expression, right: Expression) -> Expression {
    let span = left.span.start..right.span.end;
    Expression { form: Form::Binary(operator, Box::new(left), Box::new(right)), span }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(expression: &Expression) -> f64 {
        match &expression.form {
            Form::Number(value) => *value,
            Form::Name(_) | Form::Call(..) => f64::NAN,
            Form::Negative(inner) => -value(inner),
            Form::Binary(operator, a, b) => match operator {
                Operator::Plus => value(a) + value(b),
                Operator::Minus => value(a) - value(b),
                Operator::Times => value(a) * value(b),
                Operator::Over => value(a) / value(b),
                Operator::Power => value(a).powf(value(b)),
            },
        }
    }

    #[test]
    fn operators_bind_as_in_mathematics() {
        for (text, expected) in [
            ("1 - 2 - 3", -4.0),
            ("2 + 3*4", 14.0),
            ("24/4/2", 3.0),
            ("-2^2", -4.0),
            ("2^3^2", 512.0),
            ("2**-1", 0.5),
            ("2*-3", -6.0),
            ("--+3", 3.0),
            ("1.5e-1 + .5E+1", 5.15),
            ("(1 + 2)*(3)", 9.0),
        ] {
            assert_eq!(value(&parse(text).unwrap()), expected, "{text}");
        }
    }

    #[test]
    fn spans_cover_what_they_name() {
        let text = "mu/2*(I1 - 3) + f(J, 2)";
        let Form::Binary(Operator::Plus, left, right) = parse(text).unwrap().form else { panic!("a sum") };
        assert_eq!((&text[left.span], &text[right.span]), ("mu/2*(I1 - 3)", "f(J, 2)"));
    }

    #[test]
    fn mistakes_are_found_where_they_are() {
        for (text, at, title) in [
            ("mu*(I1 - 3", "(", "not closed"),
            ("mu*I1 - 3)", ")", "not opened"),
            ("mu (I1 - 3)", "mu (", ""),
            ("2 mu", "mu", "should end"),
            ("mu*", "", "ends too early"),
            ("", "", "ends too early"),
            ("mu*/2", "/", "operator without"),
            ("mu § 2", "§", "means nothing"),
            ("1.2.3", "1.2.3", "number that is none"),
            ("ln(J", "ln(", "not closed"),
        ] {
            match parse(text) {
                Ok(_) => assert_eq!(text, "mu (I1 - 3)", "a call, whose name is not known later"),
                Err(error) => assert!(error.title.contains(title) && text[error.span.clone()] == *at, "{text}: {error:?}"),
            }
        }
        let deep = format!("{}1{}", "(".repeat(60), ")".repeat(60));
        assert!(parse(&deep).unwrap_err().title.contains("within each other"));
        assert!(parse(&"-".repeat(60)).unwrap_err().title.contains("within each other"));
        assert!(parse(&"1+".repeat(600)).unwrap_err().title.contains("too long"));
    }
}
