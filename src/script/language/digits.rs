//! Numbers as text, for messages and `print`.

/// Returns the shortest text that reads back as the same number, with a decimal point or exponent only where needed.
pub fn number_text(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || (1e-4..1e16).contains(&size) || !value.is_finite() { format!("{value}") } else { format!("{value:e}") }
}

/// Returns a number with `digits` significant digits; with an exponent if that is shorter.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return number_text(value + 0.0); // without the sign of a zero
    }
    let scientific = format!("{value:.*e}", digits.saturating_sub(1));
    let exponent: i32 = scientific.split('e').nth(1).and_then(|text| text.parse().ok()).unwrap_or(0);
    if (-4..7).contains(&exponent) { format!("{value:.*}", (digits as i32 - 1 - exponent).max(0) as usize) } else { scientific }
}

/// Returns a number as text with at most six significant digits.
pub fn brief(value: f64) -> String {
    rounded(value, 6)
}

/// Returns a number as text with at most `digits` significant digits, without zeros at its end.
pub fn rounded(value: f64, digits: usize) -> String {
    let text = significant(value, digits);
    let (digits, exponent) = text.split_once('e').map_or((text.as_str(), None), |(digits, exponent)| (digits, Some(exponent)));
    let digits = if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits };
    let digits = if digits == "-0" { "0" } else { digits };
    exponent.map_or(digits.to_string(), |exponent| format!("{digits}e{exponent}"))
}

/// Returns a vector as text, such as `[1, 0.5]`.
pub fn vector_text(vector: &[f64]) -> String {
    let numbers: Vec<String> = vector.iter().map(|value| number_text(*value)).collect();
    format!("[{}]", numbers.join(", "))
}

/// Returns a vector as text with at most six significant digits.
pub fn brief_vector(vector: &[f64]) -> String {
    let numbers: Vec<String> = vector.iter().map(|value| brief(*value)).collect();
    format!("[{}]", numbers.join(", "))
}

#[cfg(test)]
mod tests {
    use super::{brief, significant};

    #[test]
    fn digits_are_significant_ones() {
        assert_eq!(significant(2.0 / 3.0, 3), "0.667");
        assert_eq!(significant(1234.5678, 6), "1234.57");
        assert_eq!(significant(123456.0, 3), "123456");
        assert_eq!(significant(1.23456e-9, 3), "1.23e-9");
        assert_eq!(significant(-0.00012345, 2), "-0.00012");
        assert_eq!(significant(0.0, 3), "0");
        assert_eq!(significant(-0.0, 3), "0");
        assert_eq!([2.0, -0.0, 0.25, 1e-9, 1.5e10, 100000.0].map(brief), ["2", "0", "0.25", "1e-9", "1.5e10", "100000"]);
    }
}
