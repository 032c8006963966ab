//! Introductory scenes of examples; every example is a whole script, and a test runs it.

use std::borrow::Cow;

/// A model with one body for examples.
const PLATE: &str = "let steel = neo_hookean(#{ youngs_modulus: 1e5, poisson_ratio: 0.3, density: 1e-3 });\n\
     let press = model(\"press\");\n\
     let plate = press.add_body(\"plate\", rectangle(#{ size: [2.0, 1.0], cells: [4, 2] }), steel);\n";

/// Returns an example that continues from a model with one body.
pub fn plate_example(line: &str) -> Cow<'static, str> {
    format!("{PLATE}{line}").into()
}

/// A second body under the body of `PLATE`, and contact between the two.
pub const TOUCH: &str = "let table = press.add_body(\"table\", \
     rectangle(#{ size: [4.0, 1.0], cells: [9, 2], origin: [-1.0, -1.0] }), steel);\n\
     press.add_contact(\"foot\", #{ secondary: plate.boundary(\"bottom\"), primary: table.boundary(\"top\"), method: mortar() });\n";

/// An example with a simulation of two bodies in contact.
pub fn contact_example(line: &str) -> Cow<'static, str> {
    format!("{PLATE}{TOUCH}let sim = simulate(press, #{{ integrator: energy_momentum(), dt: 0.001 }});\n{line}").into()
}

/// A small simulation for examples.
pub const FLIGHT: &str = "let rubber = neo_hookean(#{ youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 });\n\
     let flight = model(\"flight\");\n\
     let plate = flight.add_body(\"plate\", rectangle(#{ size: [2.0, 1.0], cells: [4, 2] }), rubber);\n\
     flight.initial_velocity(plate, #{ linear: [1.0, 0.0], angular: 2.0 });\n";

/// Returns an example with a simulation.
pub fn flight_example(line: &str) -> Cow<'static, str> {
    format!("{FLIGHT}let sim = simulate(flight, #{{ integrator: energy_momentum(), dt: 0.01 }});\n{line}").into()
}
