//! Numerical representation of the model: nodes, supports, bodies, loads, contact pairs, each with its places in the matrix.
//!
//! A [`Part`](super::model::part::Part) is a force element; a [`ContactPair`](contact_pair::ContactPair) is a constraint block.

pub mod actuator;
pub mod body;
pub mod body_force;
pub mod body_mass;
pub mod bolt;
pub mod bushing;
pub mod chamber;
pub mod contact_pair;
pub mod couplings;
pub mod damper;
pub mod drag;
pub mod force_laws;
pub mod force_shares;
pub mod free_motion;
pub mod friction_rows;
#[cfg(test)]
mod in_step;
pub mod joint_ends;
pub mod joint_reaction;
pub mod laws;
pub mod line;
pub mod loads;
pub mod motor;
pub mod nodal;
pub mod nodes;
pub mod obstacle_motion;
pub mod obstacle_velocity;
pub mod pairing;
pub mod point_mass;
pub mod rigid_bodies;
pub mod rigid_body;
pub mod rotating_frame;
pub mod round_contacts;
pub mod slip_group;
pub mod slip_vector;
pub mod spring;
pub mod step_damping;
pub mod supports;
pub mod time_values;
pub mod torsion;
