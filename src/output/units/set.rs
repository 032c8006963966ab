//! Consistent sets of units, in which equations of motion hold without factors, and the unit of a dimension in a set.

use std::fmt;

use super::dimension::{Dimension, product};
use super::expression::UnitError;
use super::scale::Scale;
use super::table::name_of;
use super::unit::Unit;

/// Sets by name, besides those of units joined by hyphens such as `mm-N-t`.
pub const SETS: &[(&str, &[&str])] =
    &[("SI", &["m", "kg", "s", "N", "Pa", "J"]), ("CGS", &["cm", "g", "s"]), ("US", &["in", "lbf", "s", "psi"])];

/// Base dimensions with their names.
const BASE: [(&str, Dimension); 3] = [("mass", Dimension([1, 0, 0])), ("length", Dimension([0, 1, 0])), ("time", Dimension([0, 0, 1]))];

/// Dimensions whose units have names.
const NAMED: [(&str, Dimension); 6] =
    [BASE[0], BASE[1], BASE[2], ("force", Dimension([1, 1, -2])), ("stress", Dimension([1, -1, -2])), ("energy", Dimension([1, 2, -2]))];

/// Consistent set of units.
#[derive(Clone, Debug, PartialEq)]
pub struct UnitSet {
    /// Declared units by their names.
    declared: Vec<(String, Unit)>,
    /// Sizes of the units of mass, length and time.
    base: [Scale; 3],
}

/// Units that make no consistent set.
#[derive(Clone, Debug, PartialEq)]
pub enum UnitSetError {
    /// A name that is no unit.
    Unit {
        /// Index of the refused name among the declared units.
        index: usize,
        /// Reason why the name is no unit.
        error: UnitError,
    },
    /// Two units of one dimension, such as `mm` and `m`.
    Twice {
        /// Indices of both.
        indices: [usize; 2],
        /// The dimension in words.
        dimension: String,
    },
    /// The units leave a base dimension open.
    Open {
        /// Base dimensions that are not determined.
        open: Vec<&'static str>,
    },
    /// A unit that does not fit the others.
    Inconsistent {
        /// Index of the unit.
        index: usize,
        /// The other units that determine it.
        others: Vec<String>,
        /// Unit that is consistent with the others.
        fitting: String,
        /// The dimension in words.
        dimension: String,
    },
}

impl fmt::Display for UnitSetError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            UnitSetError::Unit { error, .. } => write!(out, "{error}"),
            UnitSetError::Twice { dimension, .. } => write!(out, "two units of {dimension} are named"),
            UnitSetError::Open { open } => write!(out, "the units leave that of {} open", open.join(" and of ")),
            UnitSetError::Inconsistent { others, fitting, dimension, .. } => {
                write!(out, "with {} the unit of {dimension} is {fitting}", others.join(", "))
            }
        }
    }
}

impl UnitSet {
    /// The consistent set of units with these names: at least three from which mass, length and time follow.
    ///
    /// # Errors
    /// No such set.
    pub fn of<S: AsRef<str>>(names: &[S]) -> Result<Self, UnitSetError> {
        let mut declared: Vec<(String, Unit)> = Vec::new();
        for (index, name) in names.iter().enumerate() {
            let unit = Unit::parse(name.as_ref()).map_err(|error| UnitSetError::Unit { index, error })?;
            if let Some(first) = declared.iter().position(|(_, other)| other.dimension == unit.dimension) {
                return Err(UnitSetError::Twice { indices: [first, index], dimension: unit.dimension.words() });
            }
            declared.push((name.as_ref().trim().into(), unit));
        }
        // Of several units the inconsistent one is that without which most others agree; of two possible ones, that of mass.
        let is_of_mass = |k: usize| declared[k].1.dimension == BASE[0].1;
        let fits = |base: &[Scale; 3]| declared.iter().filter(|(_, unit)| size(unit.dimension, base).is(unit.scale)).count();
        let score = |(triple, base): &([usize; 3], [Scale; 3])| (fits(base), !triple.iter().any(|&k| is_of_mass(k)));
        let bases = triples(declared.len()).into_iter().filter_map(|triple| Some((triple, base_of(triple.map(|k| &declared[k].1))?)));
        let mut best: Option<([usize; 3], [Scale; 3])> = None;
        for base in bases {
            if best.as_ref().is_none_or(|known| score(&base) > score(known)) {
                best = Some(base);
            }
        }
        let Some((triple, base)) = best else { return Err(UnitSetError::Open { open: open(&declared) }) };
        let set = UnitSet { declared, base };
        let wrong = set.declared.iter().position(|(_, unit)| !set.scale(unit.dimension).is(unit.scale));
        let Some(index) = wrong else { return Ok(set) };
        let others = triple.map(|k| set.declared[k].0.clone()).to_vec();
        let dimension = set.declared[index].1.dimension;
        let right = UnitSet { declared: triple.map(|k| set.declared[k].clone()).to_vec(), base };
        Err(UnitSetError::Inconsistent { index, others, fitting: right.of_dimension(dimension), dimension: dimension.words() })
    }

    /// Units of the SI.
    pub fn si() -> Self {
        UnitSet { declared: Vec::new(), base: [Scale::ONE; 3] }
    }

    /// Names of the units in the name of a set; `None` for other texts.
    pub fn members(name: &str) -> Option<Vec<String>> {
        let known = SETS.iter().find(|(known, _)| known.eq_ignore_ascii_case(name));
        let joined = || name.contains('-').then(|| name.split('-').map(|unit| unit.trim().to_string()).collect());
        known.map(|(_, units)| units.iter().map(|unit| unit.to_string()).collect()).or_else(joined)
    }

    /// Names of the declared units.
    pub fn names(&self) -> Vec<&str> {
        self.declared.iter().map(|(name, _)| name.as_str()).collect()
    }

    /// Size of the unit of a dimension.
    pub fn scale(&self, dimension: Dimension) -> Scale {
        size(dimension, &self.base)
    }

    /// A value in the units of the set, given in a unit of any size.
    pub fn value(&self, value: f64, unit: &Unit) -> f64 {
        unit.scale.times(self.scale(unit.dimension), -1).of(value)
    }

    /// A value in a unit of any size, given in the units of the set.
    pub fn value_in(&self, value: f64, unit: &Unit) -> f64 {
        self.scale(unit.dimension).times(unit.scale, -1).of(value)
    }

    /// Unit of a dimension in words, such as `mass/volume`: `t/mm^3`; empty for pure numbers and for texts that are no dimension.
    pub fn unit(&self, dimension: &str) -> String {
        if dimension == "rad" {
            return dimension.into();
        }
        let Some(factors) = Dimension::factors(dimension) else { return String::new() };
        let mut units: Vec<(String, i32)> = Vec::new();
        for (name, power) in factors {
            let parts: &[(&str, i32)] = match name {
                "1" | "rad" => &[],
                "area" => &[("length", 2)],
                "volume" => &[("length", 3)],
                "velocity" => &[("length", 1), ("time", -1)],
                _ => &[(name, 1)],
            };
            for (part, times) in parts {
                let Some((_, of)) = NAMED.iter().find(|(known, _)| known == part) else { continue };
                let unit = self.of_dimension(*of);
                match units.iter_mut().find(|(known, _)| *known == unit) {
                    Some((_, known)) => *known += power * times,
                    None => units.push((unit, power * times)),
                }
            }
        }
        let text = product(&units);
        if text == "1" { String::new() } else { text }
    }

    /// Unit of a dimension: as declared, else one with a name, else a product of declared ones.
    fn of_dimension(&self, dimension: Dimension) -> String {
        let unit = Unit { dimension, scale: self.scale(dimension) };
        let declared = self.declared.iter().find(|(_, known)| known.dimension == dimension && known.scale.is(unit.scale));
        let composed = || {
            let of = |dimension: Dimension| name_of(&Unit { dimension, scale: self.scale(dimension) });
            let [mass, length, time] = BASE.map(|(_, dimension)| of(dimension));
            let [masses, lengths, times] = dimension.0;
            // Static quantities, such as an energy, are composed of forces.
            let of_forces = || Some(product(&[(of(NAMED[3].1)?, masses), (length.clone()?, lengths - masses)]));
            let of_masses = || Some(product(&[(mass.clone()?, masses), (length.clone()?, lengths), (time.clone()?, times)]));
            (times == -2 * masses).then(of_forces).flatten().or_else(of_masses)
        };
        let sized = || {
            let names = ["kg", "m", "s"].into_iter().zip(dimension.0).collect::<Vec<_>>();
            format!("{:?} {}", unit.scale.number(), product(&names))
        };
        declared.map(|(name, _)| name.clone()).or_else(|| name_of(&unit)).or_else(composed).unwrap_or_else(sized)
    }

    /// Units of all dimensions that have names: mass, length, time, force, stress, energy.
    pub fn overview(&self) -> Vec<(&'static str, String)> {
        NAMED.iter().map(|(name, dimension)| (*name, self.of_dimension(*dimension))).collect()
    }
}

/// Size of the unit of a dimension, from those of mass, length and time.
fn size(Dimension(powers): Dimension, base: &[Scale; 3]) -> Scale {
    powers.iter().zip(base).fold(Scale::ONE, |size, (power, of)| size.times(*of, *power))
}

/// All triples of indices below a number.
fn triples(count: usize) -> Vec<[usize; 3]> {
    let all = (0..count).flat_map(|i| (i + 1..count).flat_map(move |j| (j + 1..count).map(move |k| [i, j, k])));
    all.collect()
}

/// Sizes of the units of mass, length and time that follow from three units by Cramer's rule; `None` if these depend on one another.
fn base_of(units: [&Unit; 3]) -> Option<[Scale; 3]> {
    let d = units.map(|unit| unit.dimension.0);
    let minor = |i: usize, j: usize| {
        let [a, b] = [(i + 1) % 3, (i + 2) % 3];
        let [p, q] = [(j + 1) % 3, (j + 2) % 3];
        d[a][p] * d[b][q] - d[a][q] * d[b][p]
    };
    let determinant: i32 = (0..3).map(|j| d[0][j] * minor(0, j)).sum();
    if determinant == 0 {
        return None;
    }
    // Base dimension j is the product of the units i with the exponents minor(i, j) / determinant.
    let of = |j: usize| {
        let whole = (0..3).fold(Scale::ONE, |size, i| size.times(units[i].scale, determinant.signum() * minor(i, j)));
        whole.root(determinant.abs())
    };
    Some([of(0), of(1), of(2)])
}

/// Base dimensions that declared units do not determine.
fn open(declared: &[(String, Unit)]) -> Vec<&'static str> {
    let is_named = |dimension: Dimension| declared.iter().any(|(_, unit)| unit.dimension == dimension);
    BASE.into_iter().filter(|(_, dimension)| !is_named(*dimension)).map(|(name, _)| name).collect()
}

/// Unit for display: with superscripts and dots.
pub fn pretty(unit: &str) -> String {
    let mut text = String::new();
    let mut letters = unit.chars().peekable();
    while let Some(letter) = letters.next() {
        match (letter, letters.peek().and_then(|next| next.to_digit(10))) {
            ('^', Some(digit @ (2 | 3))) => {
                letters.next();
                text.push(if digit == 2 { '²' } else { '³' });
            }
            ('*', _) => text.push('·'),
            _ => text.push(letter),
        }
    }
    text
}

/// Units of the results of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelUnits {
    /// The set of units.
    pub set: UnitSet,
    /// True for plane models that are not axisymmetric: forces, energies and masses are those of a unit thickness.
    pub is_per_thickness: bool,
}

impl ModelUnits {
    /// Unit of a column or field with a dimension, such as `N/mm` of a force in the plane; empty for pure numbers.
    pub fn unit(&self, dimension: &str) -> String {
        if self.is_per_thickness && is_extensive(dimension) {
            self.set.unit(&format!("{dimension}/length"))
        } else {
            self.set.unit(dimension)
        }
    }

    /// Unit in brackets with a space before, for labels; empty for pure numbers.
    pub fn bracketed(&self, dimension: &str) -> String {
        let unit = self.unit(dimension);
        if unit.is_empty() { unit } else { format!(" [{}]", pretty(&unit)) }
    }
}

/// True for quantities that grow with the thickness of a body, such as `force` and `mass * velocity`, not `stress` or `mass/volume`.
fn is_extensive(dimension: &str) -> bool {
    let is_of_thickness = ["mass", "force", "energy", "area", "volume"].iter().any(|name| dimension.starts_with(name));
    is_of_thickness && !["/volume", "/area"].iter().any(|density| dimension.contains(density))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(text: &str) -> UnitSet {
        UnitSet::of(&UnitSet::members(text).unwrap()).unwrap()
    }

    #[test]
    fn sets_of_practice_are_consistent_and_name_their_units() {
        let overview = |text: &str| set(text).overview().into_iter().map(|(_, unit)| unit).collect::<Vec<_>>().join(" ");
        assert_eq!(overview("SI"), "kg m s N Pa J");
        assert_eq!(overview("mm-N-t"), "t mm s N MPa mJ");
        assert_eq!(overview("mm-kg-ms"), "kg mm ms kN GPa J");
        assert_eq!(overview("mm-kN-kg"), "kg mm ms kN GPa J");
        assert_eq!(overview("US"), "slinch in s lbf psi lbf*in");
        assert_eq!(overview("ft-lbf-s"), overview("ft-slug-s"));
        assert_eq!(set("mm-N-t").unit("mass/volume"), "t/mm^3");
        assert_eq!(set("mm-N-t").unit("force * length"), "N*mm");
        assert_eq!(set("mm-N-t").unit("length/time^2"), "mm/s^2");
        assert_eq!(set("SI").unit("mass * area/time"), "kg*m^2/s");
        assert_eq!([set("SI").unit("1"), set("SI").unit("any"), set("SI").unit("rad"), set("SI").unit("1/time")], ["", "", "rad", "1/s"]);
        assert_eq!(pretty("kg*m^2/s"), "kg·m²/s");
    }

    #[test]
    fn quantities_of_the_plane_are_those_of_a_unit_thickness() {
        let plane = ModelUnits { set: set("mm-N-t"), is_per_thickness: true };
        let of = |dimension: &str| plane.unit(dimension);
        assert_eq!([of("force"), of("energy"), of("force * length")], ["N/mm", "mJ/mm", "N"]);
        assert_eq!([of("stress"), of("mass/volume"), of("energy/area"), of("area")], ["MPa", "t/mm^3", "mJ/mm^2", "mm"]);
        assert_eq!(plane.bracketed("force"), " [N/mm]");
    }

    #[test]
    fn the_unit_that_does_not_fit_is_named_with_the_right_one() {
        let refused = |names: &[&str]| UnitSet::of(names).unwrap_err();
        let error = refused(&["mm", "N", "MPa", "kg", "s"]);
        assert!(matches!(&error, UnitSetError::Inconsistent { index: 3, fitting, .. } if fitting == "t"), "{error:?}");
        let error = refused(&["mm", "N", "Pa", "t", "s"]);
        assert!(matches!(&error, UnitSetError::Inconsistent { index: 2, fitting, .. } if fitting == "MPa"), "{error:?}");
        let error = refused(&["mm", "N", "kg", "s"]);
        assert!(matches!(&error, UnitSetError::Inconsistent { index: 2, fitting, .. } if fitting == "t"), "{error:?}");
        let error = refused(&["m", "kg", "s", "kN", "Pa"]);
        assert!(matches!(&error, UnitSetError::Inconsistent { index: 3, fitting, .. } if fitting == "N"), "{error:?}");
        assert!(matches!(refused(&["mm", "s"]), UnitSetError::Open { open } if open == ["mass"]));
        assert!(matches!(refused(&["mm", "N", "MPa"]), UnitSetError::Open { open } if open == ["mass", "time"]));
        assert!(matches!(refused(&["mm", "m", "kg", "s"]), UnitSetError::Twice { indices: [0, 1], .. }));
        assert!(matches!(refused(&["mm", "furlong"]), UnitSetError::Unit { index: 1, .. }));
    }

    #[test]
    fn quantities_are_converted_exactly_where_units_are_decimal() {
        let (si, mm, us) = (set("SI"), set("mm-N-t"), set("US"));
        let unit = |text: &str| Unit::parse(text).unwrap();
        assert_eq!([si.value(210.0, &unit("GPa")), mm.value(210.0, &unit("GPa"))], [210e9, 210e3]);
        assert_eq!([si.value(7850.0, &unit("kg/m^3")), mm.value(7850.0, &unit("kg/m^3"))], [7850.0, 7.85e-9]);
        assert_eq!([mm.value(9.81, &unit("m/s^2")), mm.value(5.0, &unit("mm"))], [9810.0, 5.0]);
        assert_eq!(mm.value_in(9810.0, &unit("m/s^2")), 9.81);
        assert!((us.value(9.80665, &unit("m/s^2")) - 386.088_582_677_165_36).abs() < 1e-10);
        assert!((us.value(1.0, &unit("slinch")) - 1.0).abs() < 1e-15);
    }
}
