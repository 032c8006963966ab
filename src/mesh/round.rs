//! Structured meshes with round sides: ring, arc, disk and half disk.
//!
//! Each is a mapped grid of cells; the names of its boundaries are fixed. Boundaries are traversed with the body on the left, so that each
//! facet begins at the end of the previous one.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, FRAC_PI_4, PI, TAU};

use super::grid::{at_least, boundary, graded, grid, limited, positive, progression};
use super::{Facet, Mesh, MeshError};
use crate::elements::CellKind;

/// A closed ring of quad4 cells between two circles around `center` `[length]`, `cells` radially and around; boundaries `inner outer`.
///
/// All nodes lie on circles: layers from the inside out, counter-clockwise in each from `start_angle` `[rad]`.
///
/// # Errors
/// Radii that are not positive or not in order, no cell radially, fewer than 3 around, numbers that are not finite, too many cells.
pub fn ring(inner_radius: f64, outer_radius: f64, cells: [usize; 2], center: [f64; 2], start_angle: f64) -> Result<Mesh, MeshError> {
    graded_ring(inner_radius, outer_radius, cells, center, start_angle, 1.0)
}

/// [`ring`] with cells that grow in geometric progression: along the radius the outermost is `grading` times the innermost.
///
/// # Errors
/// Errors of [`ring`]; a ratio that is not positive, or so far from 1 that cells vanish.
pub fn graded_ring(
    inner_radius: f64,
    outer_radius: f64,
    cells: [usize; 2],
    center: [f64; 2],
    start_angle: f64,
    grading: f64,
) -> Result<Mesh, MeshError> {
    positive("the inner radius of a ring", inner_radius)?;
    positive("the outer radius of a ring", outer_radius)?;
    if inner_radius >= outer_radius {
        return Err(MeshError::Radii { inner: inner_radius, outer: outer_radius });
    }
    at_least("along the radius", cells[0], 1)?;
    at_least("around", cells[1], 3)?;
    limited(&cells)?;
    if !start_angle.is_finite() {
        return Err(MeshError::NotFinite { what: "the start angle of a ring", value: start_angle });
    }
    let [radial, around] = cells;
    // Sine and cosine are computed once per spoke, so that the nodes of a spoke are exactly collinear.
    let spokes: Vec<(f64, f64)> = (0..around).map(|j| (start_angle + TAU * j as f64 / around as f64).sin_cos()).collect();
    let points = graded(radial, grading)?
        .iter()
        .flat_map(|share| {
            // This form gives both radii exactly, for shares of 0 and 1.
            let radius = inner_radius * (1.0 - share) + outer_radius * share;
            spokes.iter().map(move |&(sine, cosine)| [center[0] + radius * cosine, center[1] + radius * sine, 0.0])
        })
        .collect();
    let node = |layer: usize, j: usize| (layer * around + j % around) as u32;
    let connectivity =
        (0..radial).flat_map(|i| (0..around).flat_map(move |j| [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)])).collect();
    let facet = |layer: usize, j: usize, local: u8| Facet { cell: (layer * around + j) as u32, local };
    let boundaries =
        vec![boundary("inner", (0..around).rev().map(|j| facet(0, j, 3))), boundary("outer", (0..around).map(|j| facet(radial - 1, j, 1)))];
    Mesh { boundaries, ..Mesh::new(CellKind::Quad4, points, connectivity) }.checked()
}

/// A sector of a ring of quad4 cells around `center` `[length]` between two angles `[rad]`, counter-clockwise, `cells` radially and around;
/// boundaries `inner outer start end`.
///
/// Nodes lie on circles: layers from the inside out, counter-clockwise in each. Along the radius the outermost cell is `grading[0]` times
/// the innermost, along the arc the last one `grading[1]` times the first.
///
/// # Errors
/// Radii that are not positive or not in order, an end that is not behind the start by less than a full turn, cells of more than 120
/// degrees, numbers that are not finite, too many cells.
pub fn arc(radii: [f64; 2], angles: [f64; 2], cells: [usize; 2], center: [f64; 2], grading: [f64; 2]) -> Result<Mesh, MeshError> {
    let [inner, outer] = radii;
    positive("the inner radius of an arc", inner)?;
    positive("the outer radius of an arc", outer)?;
    if inner >= outer {
        return Err(MeshError::Radii { inner, outer });
    }
    let turn = angles[1] - angles[0];
    if !(turn > 0.0 && turn < TAU) {
        return Err(MeshError::Turn { start: angles[0], end: angles[1] });
    }
    at_least("along the radius", cells[0], 1)?;
    // a cell of 180 degrees has no area
    at_least("around", cells[1], (turn / (TAU / 3.0)).ceil().max(1.0) as usize)?;
    limited(&cells)?;
    let [radial, around] = cells;
    let spokes: Vec<(f64, f64)> = graded(around, grading[1])?.iter().map(|share| (angles[0] + turn * share).sin_cos()).collect();
    let mut points = Vec::with_capacity((radial + 1) * (around + 1));
    for share in graded(radial, grading[0])? {
        let radius = inner * (1.0 - share) + outer * share;
        points.extend(spokes.iter().map(|&(sine, cosine)| [center[0] + radius * cosine, center[1] + radius * sine, 0.0]));
    }
    let node = |layer: usize, j: usize| (layer * (around + 1) + j) as u32;
    let connectivity =
        (0..radial).flat_map(|i| (0..around).flat_map(move |j| [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)])).collect();
    let facet = |layer: usize, j: usize, local: u8| Facet { cell: (layer * around + j) as u32, local };
    let boundaries = vec![
        boundary("inner", (0..around).rev().map(|j| facet(0, j, 3))),
        boundary("outer", (0..around).map(|j| facet(radial - 1, j, 1))),
        boundary("start", (0..radial).map(|i| facet(i, 0, 0))),
        boundary("end", (0..radial).rev().map(|i| facet(i, around - 1, 2))),
    ];
    Mesh { boundaries, ..Mesh::new(CellKind::Quad4, points, connectivity) }.checked()
}

/// Distance of the corners of a disk's square core from its center, relative to the radius: angles of the cells there stay near 120
/// degrees.
const CORE: f64 = 0.55;

/// A disk of quad4 cells around `center` `[length]`: a square core in a ring of `cells[0]` layers with `cells[1]` cells around; boundary
/// `outer`.
///
/// Nodes: the core row by row from below, then the layers from the inside out, counter-clockwise in each from the lower left.
///
/// # Errors
/// A radius that is not positive, a number of cells around that is no multiple of 4, numbers that are not finite, too many cells.
pub fn disk(radius: f64, cells: [usize; 2], center: [f64; 2]) -> Result<Mesh, MeshError> {
    positive("the radius of a disk", radius)?;
    let [radial, around] = checked_round(cells)?;
    let side = around / 4;
    let half = CORE * radius * FRAC_1_SQRT_2;
    let at = |x: f64, y: f64| [center[0] + x, center[1] + y, 0.0];
    let mut points: Vec<[f64; 3]> =
        grid(side).flat_map(|y| grid(side).map(move |x| [half * (2.0 * x - 1.0), half * (2.0 * y - 1.0)])).map(|[x, y]| at(x, y)).collect();
    let core = |i: usize, j: usize| (j * (side + 1) + i) as u32;
    // Around the core counter-clockwise from its lower left corner.
    let rim = |k: usize| match (k / side % 4, k % side) {
        (0, i) => core(i, 0),
        (1, j) => core(side, j),
        (2, i) => core(side - i, side),
        (_, j) => core(0, side - j),
    };
    let first = points.len();
    for layer in 1..=radial {
        let share = layer as f64 / radial as f64;
        for k in 0..around {
            let inside = points[rim(k) as usize];
            let (sine, cosine) = (-0.75 * PI + TAU * k as f64 / around as f64).sin_cos();
            let outside = at(radius * cosine, radius * sine);
            points.push([0, 1, 2].map(|i| inside[i] * (1.0 - share) + outside[i] * share));
        }
    }
    let node = |layer: usize, k: usize| if layer == 0 { rim(k % around) } else { (first + (layer - 1) * around + k % around) as u32 };
    let mut connectivity = core_cells(side, side);
    connectivity.extend(
        (0..radial).flat_map(|i| (0..around).flat_map(move |k| [(i, k), (i + 1, k), (i + 1, k + 1), (i, k + 1)])).map(|(i, k)| node(i, k)),
    );
    let facet = |k: usize| Facet { cell: (side * side + (radial - 1) * around + k) as u32, local: 1 };
    let boundaries = vec![boundary("outer", (0..around).map(facet))];
    Mesh { boundaries, ..Mesh::new(CellKind::Quad4, points, connectivity) }.checked()
}

/// Lower half of a disk around `center` `[length]`, of quad4 cells: a core below the diameter, and `cells[0]` layers with `cells[1]` cells
/// around it; boundaries `arc` and `flat`.
///
/// `finest` `[length]` is the facet length at the lowest point, from which facets grow in geometric progression along the arc and into the
/// body; without it, or if uniform facets are smaller, facets are uniform.
///
/// # Errors
/// Lengths that are not positive, a number of cells around that is no multiple of 4, numbers that are not finite, too many cells.
pub fn half_disk(radius: f64, cells: [usize; 2], center: [f64; 2], finest: Option<f64>) -> Result<Mesh, MeshError> {
    positive("the radius of a half disk", radius)?;
    if let Some(finest) = finest {
        positive("the finest facet of a half disk", finest)?;
    }
    let [radial, around] = checked_round(cells)?;
    let (width, side) = (around / 2, around / 4);
    let half = CORE * radius * FRAC_1_SQRT_2;
    let at = |x: f64, y: f64| [center[0] + x, center[1] + y, 0.0];
    // Positions along the lower quarter of the arc, -1 to 1, and across the layers, 0 to 1 at the arc.
    let along = progression(side, FRAC_PI_4 * radius, finest);
    let along: Vec<f64> = along.iter().rev().map(|s| -s).chain(along[1..].iter().copied()).collect();
    let across: Vec<f64> = progression(radial, radius - half, finest).iter().rev().map(|s| 1.0 - s).collect();
    let mut points: Vec<[f64; 3]> =
        grid(side).flat_map(|y| along.iter().map(move |x| [half * x, half * (y - 1.0)])).map(|[x, y]| at(x, y)).collect();
    let core = |i: usize, j: usize| (j * (width + 1) + i) as u32;
    // Around the core counter-clockwise from its upper left corner to the upper right one.
    let rim = |k: usize| match k {
        _ if k <= side => core(0, side - k),
        _ if k <= side + width => core(k - side, 0),
        _ => core(width, k - side - width),
    };
    let angle = |k: usize| match k {
        _ if k <= side => -PI + FRAC_PI_4 * k as f64 / side as f64,
        _ if k <= side + width => -FRAC_PI_2 + FRAC_PI_4 * along[k - side],
        _ => FRAC_PI_4 * (k as f64 - around as f64) / side as f64,
    };
    let first = points.len();
    for share in &across[1..] {
        for k in 0..=around {
            let inside = points[rim(k) as usize];
            // The ends of the arc lie exactly on the diameter.
            let (sine, cosine) = if k == 0 {
                (0.0, -1.0)
            } else if k == around {
                (0.0, 1.0)
            } else {
                angle(k).sin_cos()
            };
            let outside = at(radius * cosine, radius * sine);
            points.push([0, 1, 2].map(|i| inside[i] * (1.0 - share) + outside[i] * share));
        }
    }
    let node = |layer: usize, k: usize| if layer == 0 { rim(k) } else { (first + (layer - 1) * (around + 1) + k) as u32 };
    let mut connectivity = core_cells(width, side);
    connectivity.extend(
        (0..radial).flat_map(|i| (0..around).flat_map(move |k| [(i, k), (i + 1, k), (i + 1, k + 1), (i, k + 1)])).map(|(i, k)| node(i, k)),
    );
    let facet = |layer: usize, k: usize, local: u8| Facet { cell: (width * side + layer * around + k) as u32, local };
    let top = (0..width).rev().map(|i| Facet { cell: ((side - 1) * width + i) as u32, local: 2 });
    let flat = (0..radial).rev().map(|layer| facet(layer, around - 1, 2)).chain(top).chain((0..radial).map(|layer| facet(layer, 0, 0)));
    let boundaries = vec![boundary("arc", (0..around).map(|k| facet(radial - 1, k, 1))), boundary("flat", flat)];
    Mesh { boundaries, ..Mesh::new(CellKind::Quad4, points, connectivity) }.checked()
}

/// Cells of a core of `width` times `height`, row by row.
fn core_cells(width: usize, height: usize) -> Vec<u32> {
    let node = |i: usize, j: usize| (j * (width + 1) + i) as u32;
    (0..height).flat_map(|j| (0..width).flat_map(move |i| [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)])).collect()
}

/// Checked counts of cells across the layers of a disk and around it.
fn checked_round(cells: [usize; 2]) -> Result<[usize; 2], MeshError> {
    at_least("along the radius", cells[0], 1)?;
    limited(&cells)?;
    let core = cells[1] / 4;
    limited(&[core, core])?;
    if cells[1] == 0 || !cells[1].is_multiple_of(4) {
        return Err(MeshError::NotMultiple { direction: "around", count: cells[1], of: 4 });
    }
    Ok(cells)
}
