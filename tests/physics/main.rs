//! Physics: named cases with a source, expected numbers and the reason of each tolerance, one module each.

#[path = "../common/mod.rs"]
mod common;

mod bar;
mod bearing;
mod colliding_rings;
mod contact_patch;
mod free_fall;
mod ring_on_ring;
mod torque_on_ring;
mod tumbling_block;
