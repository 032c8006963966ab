//! Simulations: creation from models, steps, results, files.

use crate::script::language::function::Function;

pub mod artifacts;
pub mod buckling;
pub mod columns;
mod contact_hints;
pub mod contact_state;
pub mod doubts;
pub mod ending;
pub mod events;
pub mod explicit;
pub mod fields;
pub mod following;
pub mod forensics;
pub mod handle;
pub mod harmonic;
pub mod history;
pub mod integrators;
pub mod joints;
pub mod journal;
pub mod known_columns;
pub mod lines;
pub mod local_frames;
pub mod modes;
pub mod movies;
pub mod overview;
pub mod past;
pub mod paths;
pub mod pictures;
pub mod plots;
pub mod probes;
pub mod properties;
pub mod reactions;
pub mod recalling;
mod report_pictures;
pub mod reports;
pub mod results;
pub mod sections;
pub mod settling;
pub mod simulate;
pub mod states;
pub mod statics;
pub mod step_control;
pub mod step_failures;
pub mod stepping;
mod stills;
pub mod stop_after;
pub mod tables;
mod told;
pub mod warnings;
pub mod writing;

/// Script functions of this topic, in the order of the reference, with those of probes and results.
pub fn functions() -> Vec<Function> {
    let mut all = integrators::functions();
    all.extend(explicit::functions());
    all.extend(statics::functions());
    all.push(step_control::auto());
    all.extend(simulate::functions());
    all.extend([stepping::step(), stepping::run_to(), settling::settle(), stepping::on_step()]);
    all.extend(states::functions());
    all.extend(forensics::functions());
    all.extend(properties::functions());
    all.extend(history::functions());
    all.extend(contact_state::functions());
    all.extend(reactions::functions());
    all.extend(joints::functions());
    all.extend(fields::functions());
    all.extend(sections::functions());
    all.extend(lines::functions());
    all.extend(modes::functions());
    all.extend(harmonic::functions());
    all.extend(buckling::functions());
    all.extend(paths::functions());
    all
}
