//! Speed of Conserva as ratios in one run: `cargo bench --bench performance [-- SIZE ...] [--threads N] [--repetitions N] [--materials |
//! --in-space | --editor | --solids [--write FOLDER]]`. The last four select the cost of laws, the bearing extruded along its axis without
//! and with friction, the response times of the language server, or the linear solver on cubes and plates (sizes: cells along the first
//! edge), whose matrices can be written for other solvers.
//!
//! Sizes multiply all cell counts of the bearing (1 2 4 8 without arguments; a few minutes). `docs/performance.md` has the figures and the
//! machine. Counts of work are not measured here; `tests/cost.rs` compares them with a record.

mod bearing;
mod editor;
#[path = "../../src/linear/fixtures.rs"]
mod fixtures;
mod linear;
mod materials;
mod solids;
mod startup;

use std::error::Error;
use std::path::PathBuf;

// For `fixtures`, which is shared with the tests of the linear solver.
use conserva::linear::{Pattern, Vertex};

fn main() -> Result<(), Box<dyn Error>> {
    let (mut sizes, mut threads, mut repetitions, mut only_materials, mut only_in_space) = (Vec::new(), 1, 3, false, false);
    let (mut only_solids, mut only_editor, mut folder) = (false, false, None);
    // Cargo adds `--bench`.
    let mut arguments = std::env::args().skip(1).filter(|text| text != "--bench");
    while let Some(argument) = arguments.next() {
        let mut number = || arguments.next().ok_or(format!("`{argument}` needs a number"));
        match argument.as_str() {
            "--threads" => threads = number()?.parse()?,
            "--repetitions" => repetitions = number()?.parse()?,
            "--materials" => only_materials = true,
            "--in-space" => only_in_space = true,
            "--solids" => only_solids = true,
            "--editor" => only_editor = true,
            "--write" => folder = Some(PathBuf::from(arguments.next().ok_or("`--write` needs a folder")?)),
            size => sizes.push(size.parse().map_err(|_| {
                let known = "sizes, --threads n, --repetitions n, --materials, --in-space, --editor, --solids, --write folder";
                format!("unknown argument `{size}`; known are {known}")
            })?),
        }
    }
    if only_materials {
        return materials::costs(repetitions);
    }
    if only_editor {
        return editor::times(repetitions);
    }
    if only_solids {
        return solids::compare(&sizes, repetitions, folder.as_deref());
    }
    if only_in_space {
        let layers = if sizes.is_empty() { vec![4] } else { sizes };
        // The plane bearing, for comparison in the same minute.
        bearing::phases_of_an_iteration(&bearing::IN_PLANE, &[2], &[], repetitions, 1)?;
        for threads in 1..=threads {
            bearing::phases_of_an_iteration(&bearing::IN_SPACE, &layers, &[], repetitions, threads)?;
            bearing::phases_of_an_iteration(&bearing::WITH_FRICTION, &layers, &[], repetitions, threads)?;
        }
        return Ok(());
    }
    if sizes.is_empty() {
        sizes = vec![1, 2, 4, 8];
    }
    let others = linear::compare(&sizes);
    bearing::phases_of_an_iteration(&bearing::IN_PLANE, &sizes, &others, repetitions, 1)?;
    if threads > 1 {
        bearing::phases_of_an_iteration(&bearing::IN_PLANE, &sizes, &others, repetitions, threads)?;
    }
    materials::costs(repetitions)?;
    startup::times(repetitions)
}
