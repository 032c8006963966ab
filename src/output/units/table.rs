//! Units by name, with prefixes.

use super::dimension::Dimension;
use super::scale::Scale;
use super::unit::Unit;

/// Row of the table of units.
struct Row {
    name: &'static str,
    dimension: [i32; 3],
    scale: Scale,
    /// True if the unit takes prefixes.
    takes_prefixes: bool,
}

const fn unit(name: &'static str, dimension: [i32; 3], scale: Scale) -> Row {
    Row { name, dimension, scale, takes_prefixes: false }
}

const fn metric(name: &'static str, dimension: [i32; 3], scale: Scale) -> Row {
    Row { name, dimension, scale, takes_prefixes: true }
}

const MASS: [i32; 3] = [1, 0, 0];
const LENGTH: [i32; 3] = [0, 1, 0];
const TIME: [i32; 3] = [0, 0, 1];
const RATE: [i32; 3] = [0, 0, -1];
const ANGLE: [i32; 3] = [0, 0, 0];
const FORCE: [i32; 3] = [1, 1, -2];
const STRESS: [i32; 3] = [1, -1, -2];
const ENERGY: [i32; 3] = [1, 2, -2];
const POWER: [i32; 3] = [1, 2, -3];
const VOLUME: [i32; 3] = [0, 3, 0];

/// A pound in kilograms times 1e8, a pound-force in newtons times 1e13: both are exact by definition.
const POUND: Scale = Scale::new(45_359_237.0, -8);
const POUND_FORCE: Scale = Scale::new(44_482_216_152_605.0, -13);

/// All units; of several units with equal size, messages and files use the first one.
const UNITS: &[Row] = &[
    metric("m", LENGTH, Scale::ONE),
    unit("in", LENGTH, Scale::new(254.0, -4)),
    unit("ft", LENGTH, Scale::new(3048.0, -4)),
    unit("kg", MASS, Scale::ONE),
    unit("t", MASS, Scale::new(1.0, 3)),
    metric("g", MASS, Scale::new(1.0, -3)),
    unit("lb", MASS, POUND),
    unit("lbm", MASS, POUND),
    unit("slug", MASS, Scale::new(44_482_216_152_605.0 / 3048.0, -9)),
    unit("slinch", MASS, Scale::new(44_482_216_152_605.0 / 254.0, -9)),
    metric("s", TIME, Scale::ONE),
    unit("min", TIME, Scale::new(60.0, 0)),
    unit("h", TIME, Scale::new(3600.0, 0)),
    metric("Hz", RATE, Scale::ONE),
    unit("rpm", RATE, Scale::new(std::f64::consts::TAU / 60.0, 0)),
    metric("rad", ANGLE, Scale::ONE),
    unit("deg", ANGLE, Scale::new(std::f64::consts::PI / 180.0, 0)),
    unit("°", ANGLE, Scale::new(std::f64::consts::PI / 180.0, 0)),
    unit("rev", ANGLE, Scale::new(std::f64::consts::TAU, 0)),
    unit("%", ANGLE, Scale::new(1.0, -2)),
    metric("N", FORCE, Scale::ONE),
    unit("lbf", FORCE, POUND_FORCE),
    unit("kip", FORCE, Scale::new(44_482_216_152_605.0, -10)),
    unit("kgf", FORCE, Scale::new(980_665.0, -5)),
    metric("Pa", STRESS, Scale::ONE),
    unit("psi", STRESS, Scale::new(44_482_216_152_605.0 / 64_516.0, -5)),
    unit("ksi", STRESS, Scale::new(44_482_216_152_605.0 / 64_516.0, -2)),
    metric("bar", STRESS, Scale::new(1.0, 5)),
    unit("atm", STRESS, Scale::new(101_325.0, 0)),
    metric("J", ENERGY, Scale::ONE),
    metric("W", POWER, Scale::ONE),
    metric("L", VOLUME, Scale::new(1.0, -3)),
    unit("g0", [0, 1, -2], Scale::new(980_665.0, -5)),
];

/// Prefixes in the order of preference for names.
const PREFIXES: &[(&str, i32)] =
    &[("k", 3), ("m", -3), ("M", 6), ("G", 9), ("u", -6), ("µ", -6), ("μ", -6), ("n", -9), ("T", 12), ("c", -2), ("d", -1), ("h", 2)];

fn of(row: &Row, power: i32) -> Unit {
    Unit { dimension: Dimension(row.dimension), scale: row.scale.times(Scale::new(1.0, 1), power) }
}

/// The unit with a name, such as `mm`.
pub(super) fn named(name: &str) -> Option<Unit> {
    let whole = UNITS.iter().find(|row| row.name == name).map(|row| of(row, 0));
    let prefixed = || {
        PREFIXES.iter().find_map(|(prefix, power)| {
            let rest = name.strip_prefix(prefix)?;
            UNITS.iter().find(|row| row.takes_prefixes && row.name == rest).map(|row| of(row, *power))
        })
    };
    whole.or_else(prefixed)
}

/// Name of the unit of a dimension and size.
pub(super) fn name_of(unit: &Unit) -> Option<String> {
    let fits = |row: &Row, power: i32| {
        let other = of(row, power);
        other.dimension == unit.dimension && other.scale.is(unit.scale)
    };
    let whole = UNITS.iter().find(|row| fits(row, 0)).map(|row| row.name.to_string());
    let prefixed = || {
        let all = PREFIXES.iter().flat_map(|prefix| UNITS.iter().map(move |row| (prefix, row)));
        let mut found = all.filter(|((_, power), row)| row.takes_prefixes && fits(row, *power));
        found.next().map(|((prefix, _), row)| format!("{prefix}{}", row.name))
    };
    whole.or_else(prefixed)
}

/// Names of all units without prefixes, and the usual ones with, for suggestions.
pub(super) fn names() -> Vec<&'static str> {
    let usual = ["mm", "cm", "km", "ms", "kN", "MN", "kPa", "MPa", "GPa", "kJ", "mJ", "kW", "kHz", "mrad"];
    UNITS.iter().map(|row| row.name).chain(usual).collect()
}
