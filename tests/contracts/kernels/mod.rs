//! Contact kernels, each evaluated for random steps by itself.

// The packages' own tests use further functions.
#[allow(dead_code)]
#[path = "../../../src/contact/fixtures.rs"]
mod fixtures;

mod arcs;
mod depths;
mod dual_in_space;
mod plane;
mod round_in_space;
mod slips;
mod slips_in_space;
mod uneven_fits;

use conserva::contact::{ContactKernel, ContactMethod, Evaluation, Patches, ProxySurfacesInSpace};

/// Kernel of a method between two surfaces in space.
fn in_space(method: &ContactMethod, surfaces: &ProxySurfacesInSpace) -> Box<dyn ContactKernel> {
    (method.in_space.expect("the method exists in space"))(surfaces)
}

/// Largest resultant force and moment (about the origin, arms `q`) of constraint gradients in space, each taken as nodal forces.
fn unbalance_in_space(rows: &[Vec<f64>], q: &[f64]) -> f64 {
    let of = |row: &Vec<f64>| {
        let mut sums = [0.0; 6];
        for ([x, y, z], [f, g, h]) in q.as_chunks::<3>().0.iter().zip(row.as_chunks::<3>().0) {
            let entries = [*f, *g, *h, y * h - z * g, z * f - x * h, x * g - y * f];
            sums.iter_mut().zip(entries).for_each(|(sum, entry)| *sum += entry);
        }
        sums.iter().fold(0.0, |largest: f64, sum| largest.max(sum.abs()))
    };
    rows.iter().map(of).fold(0.0, f64::max)
}
