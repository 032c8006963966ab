//! Materials in scripts: laws of the catalogue, energies as text, their behavior, fits.

mod behavior;
pub mod energies;
mod fitting;
mod flow_text;
mod handle;
mod laws;
mod plasticity;
mod viscosity;

use crate::script::language::function::Function;

pub use handle::MaterialHandle;

/// Script functions of this topic.
pub fn functions() -> Vec<Function> {
    let mut all = laws::functions();
    all.extend(energies::functions());
    all.extend(behavior::functions());
    all.extend(viscosity::functions());
    all.extend(plasticity::functions());
    all.push(fitting::fit_function());
    all
}
