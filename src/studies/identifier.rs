//! Names of points, derived from their parameters alone, so that a growing study finds its finished points.

use hmac_sha256::Hash;

/// Longest name that is not shortened.
const LONGEST: usize = 80;
/// Number of characters kept of a longer name.
const BEGINNING: usize = 60;

/// Returns the name of a point's folder: `dt=0.01,torque=0.2`; if long or with special characters, shortened and followed by a digest.
pub fn identifier(names: &[String], values: &[String]) -> String {
    let pairs: Vec<String> = names.iter().zip(values).map(|(name, value)| format!("{name}={value}")).collect();
    let whole = pairs.join(",");
    let plain = |sign: char| sign.is_ascii_alphanumeric() || "._+-=,".contains(sign);
    let shown: String = whole.chars().map(|sign| if plain(sign) { sign } else { '-' }).collect();
    // A comma or an equality sign inside a value would make the names of two points equal.
    let is_plain = shown == whole && !values.iter().chain(names).any(|word| word.contains([',', '='])) && !shown.starts_with('.');
    if is_plain && shown.len() <= LONGEST {
        return shown;
    }
    let beginning: String = shown.trim_start_matches('.').chars().take(BEGINNING).collect();
    format!("{beginning}~{}", digest([whole.as_bytes(), pairs.len().to_string().as_bytes()]))
}

/// Returns a digest of sixteen digits.
pub fn digest<'a>(texts: impl IntoIterator<Item = &'a [u8]>) -> String {
    let mut sum = Hash::new();
    for text in texts {
        sum.update((text.len() as u64).to_le_bytes());
        sum.update(text);
    }
    sum.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(pairs: &[(&str, &str)]) -> String {
        let (names, values): (Vec<String>, Vec<String>) = pairs.iter().map(|(name, value)| (name.to_string(), value.to_string())).unzip();
        identifier(&names, &values)
    }

    #[test]
    fn short_ones_are_written_out_and_others_keep_apart() {
        assert_eq!(named(&[("dt", "0.01"), ("torque", "-2e-3")]), "dt=0.01,torque=-2e-3");
        let odd = [named(&[("a", "1,b=2")]), named(&[("a", "1"), ("b", "2")]), named(&[("a", "../x")]), named(&[("a", "..-x")])];
        assert!(odd.iter().enumerate().all(|(index, name)| !odd[..index].contains(name)), "{odd:?}");
        assert!(odd.iter().all(|name| !name.contains('/')));
        let long = "x".repeat(200);
        assert!(named(&[("a", &long)]).len() < 90);
        assert_ne!(named(&[("a", &long)]), named(&[("a", &(long.clone() + "y"))]));
    }
}
