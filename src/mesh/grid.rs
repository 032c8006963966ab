//! Grid lines, cell counts and sizes of structured meshes.

use super::{Boundary, CELL_LIMIT, Facet, MeshError};
use crate::machine::memory;

/// `count + 1` numbers from 0 to 1, including both exactly, with steps in geometric progression from `first / length`; uniform without
/// `first`, or if uniform steps are smaller.
pub(super) fn progression(count: usize, length: f64, first: Option<f64>) -> Vec<f64> {
    let Some(first) = first.map(|first| first / length).filter(|first| first * (count as f64) < 1.0 && count > 1) else {
        return grid(count).collect();
    };
    let sum = |ratio: f64| (0..count).fold(0.0, |sum: f64, _| sum * ratio + first);
    let (mut low, mut high) = (1.0, 1.0 / first);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if sum(middle) < 1.0 { low = middle } else { high = middle }
    }
    let mut places: Vec<f64> = vec![0.0];
    let mut step = first;
    for _ in 1..count {
        places.push(places[places.len() - 1] + step);
        step *= low;
    }
    places.push(1.0);
    places
}

/// `count + 1` numbers from 0 to 1, including both exactly, with steps in geometric progression; the last step is `ratio` times the first.
///
/// # Errors
/// A ratio that is not positive, or so far from 1 that steps vanish.
pub(super) fn graded(count: usize, ratio: f64) -> Result<Vec<f64>, MeshError> {
    positive("a ratio of the last to the first cell", ratio)?;
    if ratio == 1.0 || count < 2 {
        return Ok(grid(count).collect());
    }
    let growth = ratio.ln() / (count - 1) as f64;
    let sums: Vec<f64> = (0..count)
        .scan(0.0, |sum, i| {
            *sum += (growth * i as f64).exp();
            Some(*sum)
        })
        .collect();
    let whole = sums[count - 1];
    let mut places = vec![0.0];
    places.extend(sums[..count - 1].iter().map(|sum| sum / whole));
    places.push(1.0);
    match places.windows(2).all(|pair| pair[0] < pair[1]) {
        true => Ok(places),
        false => Err(MeshError::Grading { ratio, count }),
    }
}

/// `count + 1` uniform numbers from 0 to 1, including both exactly.
pub(super) fn grid(count: usize) -> impl Iterator<Item = f64> {
    (0..=count).map(move |i| i as f64 / count as f64)
}

pub(super) fn boundary(name: &str, facets: impl Iterator<Item = Facet>) -> Boundary {
    Boundary::of_facets(name, facets.collect())
}

pub(super) fn positive(what: &'static str, value: f64) -> Result<(), MeshError> {
    if value.is_finite() && value > 0.0 { Ok(()) } else { Err(MeshError::NotPositive { what, value }) }
}

pub(super) fn at_least(direction: &'static str, count: usize, least: usize) -> Result<(), MeshError> {
    if count >= least { Ok(()) } else { Err(MeshError::TooFewCells { direction, count, least }) }
}

pub(super) fn limited(cells: &[usize]) -> Result<(), MeshError> {
    let total = cells.iter().fold(1, |product: usize, &count| product.saturating_mul(count));
    room_for(total, STRUCTURED)
}

/// Memory of a cell with its part of the nodes during the construction of a structured mesh (measured: 93 for a quad4, 170 for a hex8)
/// `[bytes]`.
const STRUCTURED: usize = 180;

/// Bytes per cell of an unstructured mesh (measured: 180 for a quad4 in a region, where each triangle is split into three).
pub(super) const UNSTRUCTURED: usize = 550;

/// Refuses more cells than a mesh may have, or than fit into memory with `bytes` bytes each.
pub(super) fn room_for(cells: usize, bytes: usize) -> Result<(), MeshError> {
    if cells > CELL_LIMIT {
        return Err(MeshError::TooManyCells { cells, limit: CELL_LIMIT });
    }
    memory::ensure((cells * bytes) as u64).map_err(|shortage| MeshError::Memory { cells, shortage })
}
