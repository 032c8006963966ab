//! Models: bodies, supports, loads. Contact is in `contacts/`.

use crate::script::language::function::Function;

pub mod arguments;
pub mod bodies;
pub mod body_forces;
pub mod bolts;
pub mod building;
pub mod bushings;
pub mod chambers;
pub mod change;
pub mod couplings;
pub mod dampers;
pub mod data;
pub mod description;
pub mod ends;
pub mod frames;
pub mod gears;
pub mod growth;
pub mod handle;
pub mod joint_friction;
pub mod loads;
pub mod masses;
pub mod motors;
pub mod properties;
pub mod rigid;
pub mod springs;
pub mod supports;

/// Script functions of this topic, in the order of the reference.
pub fn functions() -> Vec<Function> {
    let mut all = vec![
        building::model(),
        building::add_body(),
        rigid::add_rigid_body(),
        supports::fix(),
        supports::prescribe(),
        couplings::add_symmetry(),
        couplings::add_periodic(),
        couplings::add_coupling(),
        building::gravity(),
        frames::rotating_frame(),
        building::initial_velocity(),
        building::initial_displacement(),
        growth::grow(),
        building::check(),
    ];
    all.extend(properties::functions());
    all.extend(loads::functions());
    all.push(body_forces::body_force());
    all.extend([
        rigid::add_joint(),
        gears::add_gear(),
        motors::add_motor(),
        motors::add_actuator(),
        springs::add_spring(),
        bolts::add_bolt(),
        springs::add_torsion_spring(),
        dampers::add_damper(),
        bushings::add_bushing(),
        dampers::add_drag(),
        dampers::add_damping(),
        chambers::add_chamber(),
        masses::add_mass(),
    ]);
    all.extend(bodies::functions());
    all.extend(bodies::boundary_functions());
    all
}
