//! Numbers in messages.

/// Number with three significant digits in its shortest form: `2.1`, `-0.5`, `1.23e-7`.
pub fn three_digits(value: f64) -> String {
    let digits = format!("{value:.2e}");
    match digits.parse::<f64>() {
        Ok(rounded) if rounded == 0.0 || (0.0001..100_000.0).contains(&rounded.abs()) => rounded.to_string(),
        Ok(rounded) => format!("{rounded:e}"),
        Err(_) => digits,
    }
}

/// Fraction in percent, with two or three significant digits.
pub fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent >= 0.01 { format!("{percent:.2} %") } else { format!("{percent:.0e} %") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_as_short_as_they_can_be() {
        let written = [2.1, -0.5, 0.0, 1.0e-7, 1.234e-7, 123_456.0, 0.12345].map(three_digits);
        assert_eq!(written, ["2.1", "-0.5", "0", "1e-7", "1.23e-7", "1.23e5", "0.123"]);
    }
}
