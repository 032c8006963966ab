//! Warnings of suspicious numbers in a model, of units and degrees, and of stresses that are incomplete.

use super::handle::SimulationHandle;
use crate::dynamics::{JointKind, Model};
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::digits::{brief, number_text};
use crate::script::language::function::Call;
use crate::script::language::host::Host;
use crate::script::language::scan::Target;

/// Densities of solids in kg/m^3, from wood to gold.
const KILOGRAMS: std::ops::Range<f64> = 300.0..20_000.0;

/// Speed of sound in metres per second below which a body of [`LARGE`] metres or more is implausible: steel in N/mm^2 and kg/m^3 has 5.
const SLOW: f64 = 12.0;

/// Extent from which a length is probably in millimetres instead of metres, if sound is that slow.
const LARGE: f64 = 4.0;

/// Angles in degrees that are hardly meant in radians if a prescribed rotation ends at exactly this value.
const DEGREES: [f64; 8] = [45.0, 60.0, 90.0, 120.0, 135.0, 180.0, 270.0, 360.0];

/// Warns of densities in kg/m^3 together with lengths in mm and stresses in N/mm^2, in a model whose inertia matters.
pub(super) fn warn_of_mixed_units(call: &Call, model: &Model) {
    for body in model.bodies.iter().filter(|body| body.rigid.is_none()) {
        let (density, modulus) = (body.material.density(), body.material.youngs_modulus());
        let extent = |i: usize| {
            let places = body.mesh.points.iter().map(|point| point[i]);
            places.clone().fold(f64::NEG_INFINITY, f64::max) - places.fold(f64::INFINITY, f64::min)
        };
        let (size, speed) = ((0..3).map(extent).fold(0.0, f64::max), (modulus / density).sqrt());
        if KILOGRAMS.contains(&density) && speed < SLOW && size > LARGE {
            let title = format!("the density {} of body \"{}\" may be one of other units", number_text(density), body.name);
            let cause = format!(
                "sound would need {} to cross the body, at a speed of {}: that of steel in kg/m^3 and N/mm^2 is 5",
                brief(size / speed),
                brief(speed)
            );
            let hint = "with N and mm take t and s: steel has 7.85e-9 t/mm^3, and stresses are in N/mm^2";
            call.host.warn(Diagnostic::warning(title, call.place(&Target::Call)).code("C0334").cause(cause).hint(hint));
        }
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
