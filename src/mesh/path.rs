//! Positions and directions along a path in space: rotation-minimizing frames.
//!
//! The frame is transported from point to point by two reflections (W. Wang, B. Jüttler, D. Zheng, Y. Liu, ACM Transactions on Graphics 27,
//! 2008, 2:1-2:18, section 4), exactly along straight lines and circles.

use super::MeshError;
use super::check::{between, cross, dot, norm};
use crate::math::tolerances::SAME_PLACE;

type Vector = [f64; 3];

/// A section's place and directions.
pub(super) struct SectionFrame {
    /// Position of the origin of the plane `[length]`.
    pub at: Vector,
    /// Share of the path length up to this position.
    pub share: f64,
    /// Unit vectors along x and y of the section.
    pub along: [Vector; 2],
}

/// Frames at the points of a path, and true if the path is closed; the last point of a closed path equals the first one and has no frame of
/// its own.
///
/// # Errors
/// Fewer than two points (closed: four), coincident points, turns of 90 degrees and more.
pub(super) fn frames(path: &[Vector]) -> Result<(Vec<SectionFrame>, bool), MeshError> {
    if let Some(&value) = path.as_flattened().iter().find(|x| !x.is_finite()) {
        return Err(MeshError::NotFinite { what: "a coordinate of a path", value });
    }
    let extent = path.as_flattened().iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let is_same = |a: Vector, b: Vector| norm(between(a, b)) <= SAME_PLACE * extent;
    let is_closed = path.len() > 2 && is_same(path[0], path[path.len() - 1]);
    let least = if is_closed { 4 } else { 2 };
    if path.len() < least {
        return Err(MeshError::PathPoints { count: path.len(), least });
    }
    if let Some(first) = path.windows(2).position(|pair| is_same(pair[0], pair[1])) {
        return Err(MeshError::CoincidentPathPoints { point: first + 1, at: path[first] });
    }
    let points = &path[..path.len() - usize::from(is_closed)];
    let tangents = tangents(points, is_closed)?;
    let mut length = vec![0.0];
    length.extend(path.windows(2).scan(0.0, |sum, pair| {
        *sum += norm(between(pair[0], pair[1]));
        Some(*sum)
    }));
    let share = |k: usize| length[k] / length[path.len() - 1];
    let mut across = vec![first_across(tangents[0])];
    for k in 1..path.len() {
        let from = k - 1;
        let across_next = carried(across[from], tangents[from], between(path[from], path[k]), tangents[k % points.len()]);
        across.push(across_next);
    }
    // the angle by which a closed path rotates the frame is distributed over its length
    let [x, y] = [across[0], cross(tangents[0], across[0])];
    let end = across[path.len() - 1];
    let turn = if is_closed { dot(end, y).atan2(dot(end, x)) } else { 0.0 };
    let frame = |k: usize| {
        let (x, y) = (across[k], cross(tangents[k], across[k]));
        let (sine, cosine) = (-turn * share(k)).sin_cos();
        let turned = |a: f64, b: f64| [0, 1, 2].map(|i| a * x[i] + b * y[i]);
        SectionFrame { at: points[k], share: share(k), along: [turned(cosine, sine), turned(-sine, cosine)] }
    };
    Ok(((0..points.len()).map(frame).collect(), is_closed))
}

/// Unit vectors along the path at its points: along the circle through each and its neighbors.
fn tangents(points: &[Vector], is_closed: bool) -> Result<Vec<Vector>, MeshError> {
    let count = points.len();
    let unit = |v: Vector| v.map(|x| x / norm(v));
    let step = |from: usize| between(points[from % count], points[(from + 1) % count]);
    let inner = |k: usize| {
        let [before, after] = [step(k + count - 1), step(k)];
        let (a, b) = (unit(before), unit(after));
        let cosine = dot(a, b);
        if cosine <= SAME_PLACE {
            return Err(MeshError::PathTurns { point: k + 1, at: points[k], degrees: cosine.clamp(-1.0, 1.0).acos().to_degrees() });
        }
        let (far, near) = (norm(after), norm(before));
        Ok(unit([0, 1, 2].map(|i| far * a[i] + near * b[i])))
    };
    if is_closed {
        return (0..count).map(inner).collect();
    }
    let mut tangents = vec![[0.0; 3]];
    for k in 1..count - 1 {
        tangents.push(inner(k)?);
    }
    // at an end the circle of the neighboring point continues: reflection of its direction
    let mirrored = |tangent: Vector, chord: Vector| [0, 1, 2].map(|i| 2.0 * dot(tangent, chord) * chord[i] - tangent[i]);
    let [first, last] = [unit(step(0)), unit(step(count - 2))];
    tangents[0] = tangents.get(1).map_or(first, |&next| unit(mirrored(next, first)));
    let end = if count > 2 { unit(mirrored(tangents[count - 2], last)) } else { last };
    tangents.push(end);
    Ok(tangents)
}

/// Direction of the x axis after the smallest rotation of z to the tangent; a half turn is about x.
fn first_across(tangent: Vector) -> Vector {
    let [x, y, z] = tangent;
    if 1.0 + z <= SAME_PLACE {
        return [1.0, 0.0, 0.0];
    }
    [1.0 - x * x / (1.0 + z), -x * y / (1.0 + z), -x]
}

/// Vector normal to the path, transported from one point to the next.
fn carried(across: Vector, tangent: Vector, step: Vector, next: Vector) -> Vector {
    let reflected = |v: Vector, about: Vector| {
        let square = dot(about, about);
        let factor = if square > 0.0 { 2.0 * dot(about, v) / square } else { 0.0 };
        [0, 1, 2].map(|i| v[i] - factor * about[i])
    };
    let (across, tangent) = (reflected(across, step), reflected(tangent, step));
    let carried = reflected(across, between(tangent, next));
    // unit vector normal to the path in spite of round-off
    let along = dot(carried, next);
    let clean = [0, 1, 2].map(|i| carried[i] - along * next[i]);
    clean.map(|x| x / norm(clean))
}
