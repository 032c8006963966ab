//! Warnings of suspicious numbers in a model, of units and degrees, and of stresses that are incomplete.

use std::ops::{Range, RangeInclusive};

use super::handle::SimulationHandle;
use crate::dynamics::{JointKind, Model};
use crate::math::norms::length;
use crate::output::{Unit, UnitSet};
use crate::script::api::units::DeclaredUnits;
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::digits::{brief, number_text};
use crate::script::language::prelude::*;

/// Densities of solids in kg/m^3, from wood to gold.
const KILOGRAMS: Range<f64> = 300.0..20_000.0;

/// Speed of sound in metres per second below which a body of [`LARGE`] metres or more is implausible: steel in N/mm^2 and kg/m^3 has 5.
const SLOW: f64 = 12.0;

/// Extent from which a length is probably in millimetres instead of metres, if sound is that slow.
const LARGE: f64 = 4.0;

/// Angles in degrees that are hardly meant in radians if a prescribed rotation ends at exactly this value.
const DEGREES: [f64; 9] = [30.0, 45.0, 60.0, 90.0, 120.0, 135.0, 180.0, 270.0, 360.0];

/// Young's moduli of solids in Pa, from the softest gels to diamond.
const MODULI: RangeInclusive<f64> = 1e3..=1.3e12;

/// Densities of solids in kg/m^3, from foams to osmium.
const DENSITIES: RangeInclusive<f64> = 10.0..=25_000.0;

/// Gravity of the earth in m/s^2, from the equator to the poles, including rounded values.
const GRAVITY: RangeInclusive<f64> = 9.7..=9.9;

/// Kilograms per cubic meter in a tonne per cubic millimeter.
const DENSE: f64 = 1e12;

/// Young's modulus above which stresses are in Pa where densities are in t/mm^3: diamond has 1.2e6 N/mm^2.
const PASCALS: f64 = 1e8;

/// Units of stress that are suggested if a number is implausible in the declared unit.
const OF_STRESS: [&str; 6] = ["GPa", "MPa", "kPa", "Pa", "psi", "ksi"];
const OF_DENSITY: [&str; 4] = ["kg/m^3", "g/cm^3", "t/mm^3", "kg/mm^3"];
const OF_GRAVITY: [&str; 6] = ["m/s^2", "mm/s^2", "cm/s^2", "in/s^2", "ft/s^2", "mm/ms^2"];

/// Warns of numbers that indicate wrong units: with declared units of implausible values, without declared units of inconsistent values.
/// `has_inertia`: densities matter.
pub(super) fn warn_of_numbers(call: &Call, model: &Model, has_inertia: bool) {
    match DeclaredUnits::set(call.host) {
        Some(units) => warn_of_impossible_numbers(call, model, &units),
        None => {
            warn_of_gravity(call, model);
            if has_inertia {
                warn_of_mixed_units(call, model);
            }
        }
    }
}

/// Warns of moduli, densities and gravity that are implausible in the declared units.
fn warn_of_impossible_numbers(call: &Call, model: &Model, units: &UnitSet) {
    let warn = |title: String, code: &str, cause: String, hint: String| {
        call.host.warn(Diagnostic::warning(title, call.place(&Target::Call)).code(code).cause(cause).hint(hint));
    };
    let read = |name: &str| Unit::parse(name).unwrap_or(Unit::ONE);
    // The first unit in which the number would be plausible, in the form to be written.
    let meant = |number: f64, names: &[&str], range: &RangeInclusive<f64>, declared: &str| {
        let in_si = |name: &&&str| range.contains(&read(name).scale.of(number));
        names.iter().find(in_si).map_or_else(
            || format!("the declared unit is {declared}: `quantity(…, \"{}\")` converts to it", names[0]),
            |name| format!("if it is meant in {name}, write `quantity({}, \"{name}\")`; the declared unit is {declared}", brief(number)),
        )
    };
    for body in model.bodies.iter().filter(|body| body.rigid.is_none()) {
        let (density, modulus) = (body.material.density(), body.material.youngs_modulus());
        let (of_stress, of_density) = (units.unit("stress"), units.unit("mass/volume"));
        let in_si = units.value_in(modulus, &read("Pa"));
        if !MODULI.contains(&in_si) {
            let title = format!("no solid has the stiffness of body \"{}\": Young's modulus {} {of_stress}", body.name, brief(modulus));
            let cause = format!("that is {} Pa; solids have 1 kPa to 1 TPa", brief(in_si));
            warn(title, "C0335", cause, meant(modulus, &OF_STRESS, &(1e6..=1e12), &of_stress));
        }
        let in_si = units.value_in(density, &read("kg/m^3"));
        if !DENSITIES.contains(&in_si) {
            let title = format!("no solid has the density of body \"{}\": {} {of_density}", body.name, brief(density));
            let cause = format!("that is {} kg/m^3; solids have 10 to 25000", brief(in_si));
            warn(title, "C0336", cause, meant(density, &OF_DENSITY, &(100.0..=25_000.0), &of_density));
        }
    }
    let size = length(model.gravity);
    let of_gravity = units.unit("length/time^2");
    let in_si = units.value_in(size, &read("m/s^2"));
    let other = OF_GRAVITY.iter().find(|name| GRAVITY.contains(&read(name).scale.of(size)));
    if let Some(name) = other.filter(|_| !GRAVITY.contains(&in_si)) {
        let title = format!("gravity {} is that of the earth in {name}, and the declared unit is {of_gravity}", brief(size));
        let cause = format!("that is {} m/s^2", brief(in_si));
        warn(title, "C0337", cause, "write `quantity(9.81, \"m/s^2\")` for its size".into());
    }
}

/// Warns of the earth's gravity in m/s^2 together with densities in t/mm^3, and in mm/s^2 together with densities in kg/m^3.
fn warn_of_gravity(call: &Call, model: &Model) {
    let size = length(model.gravity);
    let densities =
        || model.bodies.iter().filter(|body| body.rigid.is_none()).map(|body| (body.material.density(), body.material.youngs_modulus()));
    let is_in_meters = GRAVITY.contains(&size) && densities().any(|(density, _)| DENSITIES.contains(&(DENSE * density)));
    // Solids of these densities are stiffer than a megapascal if stresses are in Pa.
    let is_in_millimeters =
        GRAVITY.contains(&(size / 1000.0)) && densities().any(|(density, modulus)| KILOGRAMS.contains(&density) && modulus > 1e6);
    let (unit, other, right) = match (is_in_meters, is_in_millimeters) {
        (true, _) => ("m/s^2", "t/mm^3", "9810"),
        (_, true) => ("mm/s^2", "kg/m^3", "9.81"),
        _ => return,
    };
    let title = format!("gravity {} may be one of other units", brief(size));
    let cause = format!("it is that of the earth in {unit}, and a density of the model is one in {other}");
    let hint = format!("write {right} in these units, or declare them with `units`: then `quantity(9.81, \"m/s^2\")` converts");
    call.host.warn(Diagnostic::warning(title, call.place(&Target::Call)).code("C0338").cause(cause).hint(hint));
}

/// Warns of densities in kg/m^3 together with lengths in mm and stresses in N/mm^2 in a model whose inertia matters, and of densities in
/// t/mm^3 together with stresses in Pa.
fn warn_of_mixed_units(call: &Call, model: &Model) {
    for body in model.bodies.iter().filter(|body| body.rigid.is_none()) {
        let (density, modulus) = (body.material.density(), body.material.youngs_modulus());
        let extent = |i: usize| {
            let places = body.mesh.points.iter().map(|point| point[i]);
            places.clone().fold(f64::NEG_INFINITY, f64::max) - places.fold(f64::INFINITY, f64::min)
        };
        let (size, speed) = ((0..3).map(extent).fold(0.0, f64::max), (modulus / density).sqrt());
        let (title, cause, hint) = if DENSITIES.contains(&(DENSE * density)) && modulus > PASCALS {
            (
                format!("Young's modulus {} of body \"{}\" may be one of other units", number_text(modulus), body.name),
                format!("its density {} is that of a solid in t/mm^3, and no solid has that modulus in N/mm^2", number_text(density)),
                "with N and mm stresses are in N/mm^2: steel has 2.1e5; `units(\"mm-N-t\")` converts",
            )
        } else if KILOGRAMS.contains(&density) && speed < SLOW && size > LARGE {
            let seconds = brief(size / speed);
            (
                format!("the density {} of body \"{}\" may be one of other units", number_text(density), body.name),
                format!(
                    "sound would need {seconds} to cross the body, at a speed of {}: that of steel in kg/m^3 and N/mm^2 is 5",
                    brief(speed)
                ),
                "with N and mm take t and s: steel has 7.85e-9 t/mm^3, and stresses are in N/mm^2; `units(\"mm-N-t\")` converts",
            )
        } else {
            continue;
        };
        call.host.warn(Diagnostic::warning(title, call.place(&Target::Call)).code("C0334").cause(cause).hint(hint));
    }
}

impl SimulationHandle {
    /// Warns of prescribed rotations that end at a typical number of degrees.
    pub(super) fn warn_of_degrees(&self, host: &Host) {
        let (model, Ok(simulation)) = (&self.0.model.model, self.0.simulation.try_borrow()) else { return };
        let time = simulation.time();
        let turns = model.prescriptions.iter().filter_map(|one| one.turn.as_ref()).map(|turn| &turn.angle);
        let hinges = model.joints.iter().filter(|joint| matches!(joint.kind, JointKind::Point | JointKind::Hinge(_)));
        for angle in turns.chain(hinges.filter_map(|joint| joint.drive.as_ref())) {
            let Ok(angle) = angle.value(time) else { continue };
            if DEGREES.contains(&angle.abs()) {
                let title = format!("a prescribed angle ends at {} radians, which may be degrees", number_text(angle));
                let cause = format!("that is {} turns", brief(angle.abs() / std::f64::consts::TAU));
                let warning = Diagnostic::warning(title, self.0.place.clone()).code("C0656").cause(cause);
                host.warn(warning.hint(format!("write `deg({})` for degrees", number_text(angle))));
            }
        }
    }
}
