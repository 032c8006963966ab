//! Revolution of a plane mesh about an axis in its plane.

use std::f64::consts::TAU;

use super::grid::{at_least, graded, limited};
use super::sweep::{Prisms, Sweep};
use super::{Mesh, MeshError};
use crate::math::tolerances::SAME_PLACE;

/// Axis in the plane of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// A point of the axis `[length]`.
    pub center: [f64; 2],
    /// Direction of the axis, of any length but 0.
    pub along: [f64; 2],
}

impl Axis {
    /// The axis of y.
    pub const Y: Axis = Axis { center: [0.0; 2], along: [0.0, 1.0] };
}

impl Mesh {
    /// Revolution of the plane mesh by `angle` `[rad]`, right-handed, about an axis in its plane, in `layers` of which the last is
    /// `grading` times the first: hexahedra, and over triangles wedges or three tetrahedra each. Its boundaries become sides; `start` is
    /// the plane mesh itself and `end` its copy at the end. A full turn is closed and has neither.
    ///
    /// # Errors
    /// Cells of other kinds, an angle of 0 or of more than a full turn, layers of more than 120 degrees, an axis without direction, a mesh
    /// that is not wholly on one side of the axis, too many cells.
    pub fn revolved(&self, angle: f64, layers: usize, about: Axis, grading: f64, prisms: Prisms) -> Result<Mesh, MeshError> {
        let (turn, Axis { center, along: axis }) = (angle.abs(), about);
        if !(turn > 0.0 && turn <= TAU * (1.0 + SAME_PLACE)) {
            return Err(MeshError::Revolution { angle });
        }
        let length = axis[0].hypot(axis[1]);
        if !(length > 0.0 && length.is_finite()) {
            return Err(MeshError::NoAxis { axis: [axis[0], axis[1], 0.0] });
        }
        // a layer of 180 degrees has no volume
        at_least("around", layers, (turn / (TAU / 3.0) * (1.0 - SAME_PLACE)).ceil().max(1.0) as usize)?;
        limited(&[self.cell_count(), layers])?;
        let is_closed = turn >= TAU * (1.0 - SAME_PLACE);
        if is_closed && grading != 1.0 {
            return Err(MeshError::ClosedChange);
        }
        let [along, across] = [[axis[0] / length, axis[1] / length], [axis[1] / length, -axis[0] / length]];
        let components = |point: &[f64; 3]| {
            let arm = [point[0] - center[0], point[1] - center[1]];
            [along, across].map(|way| way[0] * arm[0] + way[1] * arm[1])
        };
        let parts: Vec<[f64; 2]> = self.points.iter().map(components).collect();
        let extent = parts.as_flattened().iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let side = parts.first().map_or(1.0, |[_, radius]| radius.signum());
        if let Some(node) = parts.iter().position(|[_, radius]| radius * side <= SAME_PLACE * extent) {
            let [x, y, _] = self.points[node];
            return Err(MeshError::OnAxis { at: [x, y] });
        }
        let turns: Vec<(f64, f64)> = graded(layers, grading)?.iter().map(|share| (angle * share).sin_cos()).collect();
        let sweep = Sweep { layers, is_closed, is_backward: angle * side > 0.0, ends: ["start", "end"], prisms };
        self.swept(&sweep, |row, node| {
            let ([height, radius], (sine, cosine)) = (parts[node], turns[row]);
            let plane = |i: usize| center[i] + height * along[i] + radius * cosine * across[i];
            [plane(0), plane(1), 0.0 - radius * sine]
        })
    }
}
