//! Families of time integrators with parameters.

use super::scheme::Scheme;
use crate::math::catalogue::Parameter;

/// Family of schemes with parameters; the scheme with default values is in the catalogue.
pub struct Family {
    /// Scheme with the default values of all parameters.
    pub default: &'static Scheme,
    /// Parameters of the family, at most two, each with a default.
    pub parameters: &'static [Parameter],
    /// Makes the scheme for admissible values of the parameters; 0 for absent parameters.
    pub make: fn([f64; 2]) -> Scheme,
}

#[cfg(test)]
mod tests {
    use crate::integrators::FAMILIES;

    #[test]
    fn defaults_are_the_rows_of_the_catalogue_and_all_in_range_are_schemes() {
        for family in FAMILIES {
            let mut values = [0.0; 2];
            for (value, parameter) in values.iter_mut().zip(family.parameters) {
                *value = parameter.default.expect("families have defaults");
                assert!(parameter.range.contains(*value));
            }
            let made = (family.make)(values);
            assert_eq!(&made, family.default);
            assert_eq!((made.weight, made.velocity, made.lag), (family.default.weight, family.default.velocity, family.default.lag));
            for [first, second] in [[-1.0, 0.0], [-1.0 / 3.0, 0.0], [0.0; 2], [0.5, 0.0], [1.0, 0.0], [0.1, 0.5], [0.25, 0.5], [0.5, 1.0]] {
                let in_range = family.parameters.iter().zip([first, second]).all(|(parameter, value)| parameter.range.contains(value));
                let scheme = (family.make)([first, second]);
                assert!(!in_range || scheme.check() == Ok(()), "{}: {:?}", scheme.describe(), scheme.check());
            }
        }
    }
}
