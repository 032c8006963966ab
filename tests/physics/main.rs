//! Physics: named cases with a source, expected numbers and the reason of each tolerance, one module each.

#[path = "../common/mod.rs"]
mod common;

mod bar;
mod bar_on_wall;
mod bearing;
mod beginnings;
mod bouncing_ring;
mod colliding_rings;
mod contact_patch;
mod crushed_hose;
mod fields;
mod free_fall;
mod in_space;
mod node_to_segment;
mod point_masses;
mod reactions;
mod ring_on_ring;
mod schemes;
mod settle;
mod spectra;
mod springs;
mod tied_bodies;
mod torque_on_ring;
mod treloar;
mod tumbling_block;
