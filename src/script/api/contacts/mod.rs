//! Contact in a model: methods, rigid obstacles, pairs. Results on contact are in `simulations/contact_state.rs`.

use crate::script::language::function::Function;

pub mod friction;
pub mod methods;
pub mod obstacles;
pub mod obstacles_in_space;
pub mod pairs;

/// Script functions of this topic.
pub fn functions() -> Vec<Function> {
    let mut all = methods::functions();
    all.extend(friction::functions());
    all.extend(obstacles::functions());
    all.extend(obstacles_in_space::functions());
    all.extend(pairs::functions());
    all
}
