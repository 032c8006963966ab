//! Contracts: properties that every row of a catalogue must have, run over all rows, so that a new row is tested without a new test.

#[path = "../common/mod.rs"]
mod common;

mod bodies;
mod closed_forms;
mod contacts;
mod elements;
mod kernels;
mod laws;
mod masses;
mod materials;
mod mean_values;
mod plasticity;
mod rigid_bodies;
mod round_cells;
mod round_meshes;
mod simulations;
mod states;
mod torques;
mod viscous_bodies;

use conserva::integrators;
