//! Meshes: generators, the reader, transforms, boundaries.

use crate::script::language::function::Function;

pub mod boundaries;
pub mod decks;
pub mod generators;
pub mod handle;
pub mod kinds;
pub mod layers;
pub mod local_refinement;
pub mod pieces;
pub mod properties;
pub mod reader;
pub mod regions;
pub mod solids;
pub mod sweeps;
pub mod transforms;

/// Script functions of this topic.
pub fn functions() -> Vec<Function> {
    let mut all = generators::functions();
    all.extend(solids::functions());
    all.extend(regions::functions());
    all.extend(reader::functions());
    all.push(decks::read_deck());
    all.extend(transforms::functions());
    all.extend(sweeps::functions());
    all.push(local_refinement::refine_where());
    all.push(kinds::with_elements());
    all.push(boundaries::boundary_where());
    all.extend(pieces::functions());
    all.extend(properties::functions());
    all
}
