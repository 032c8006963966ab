//! Stored energies as text: `mu/2*(I1bar - 3) + ...`, evaluated as fast and as accurately as hand-written laws.
//!
//! Text → tree (`syntax.rs`) → graph (`meaning.rs`, `graph.rs`) → derivatives → tape of operations on lanes (`tape.rs`); variables as
//! functions of the strain: `variable.rs`, `state.rs`, `spectrum.rs`; the law for the element loop: `law.rs`.

mod error;
mod graph;
mod law;
mod meaning;
#[cfg(test)]
mod property_tests;
mod scalar;
mod small_strain;
mod spectrum;
mod state;
mod stored;
mod syntax;
mod tape;
#[cfg(test)]
mod tests;
mod variable;
mod volumetric;

pub use error::EnergyError;
pub use scalar::{Jet, ScalarText};
pub use stored::{EnergyText, StoredEnergy, functions_of_energies, quantities_of_energies};
