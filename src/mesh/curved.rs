//! Mid-side nodes of second-order cells placed on the exact curve or surface of an edge.

use std::ops::Range;

use nalgebra::Vector3;

use super::{Mesh, MeshError};
use crate::elements::CellKind;
use crate::math::tolerances::SAME_PLACE;

/// Exact curve or surface that the edges of a round mesh approximate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Round {
    /// Every edge is part of a circle or of a ray about this center `[length]`: a ring; in space about an axis along z: a tube.
    About([f64; 2]),
    /// Edges with both ends on the circle of this center and radius `[length]` are part of the circle: a disk; in space a cylinder along z.
    On([f64; 2], f64),
    /// Every edge is part of a sphere or of a ray about this center `[length]`: a hollow sphere.
    AboutPoint([f64; 3]),
    /// Edges with both ends at the distance `radius` from the block between two corners lie on the surface at this distance `[length]`: a
    /// rounded block; a sphere if both corners are its center.
    OnBlock([[f64; 3]; 2], f64),
    /// Edges around the axis along z through a center; they lie on the torus if both ends do: center, ring radius and section radius
    /// `[length]`.
    Ring([f64; 3], [f64; 2]),
}

/// True if both lengths equal the radius up to round-off.
fn are_all(lengths: [f64; 2], radius: f64) -> bool {
    lengths.iter().all(|length| (length / radius - 1.0).abs() <= SAME_PLACE)
}

impl Round {
    /// Midpoint of an edge along its curve; `None` for a straight edge.
    fn middle(self, ends: [[f64; 3]; 2]) -> Option<[f64; 3]> {
        match self {
            Round::About(center) => about(center, ends),
            Round::On(center, radius) => {
                let radii = ends.map(|end| (end[0] - center[0]).hypot(end[1] - center[1]));
                if are_all(radii, radius) { about(center, ends) } else { None }
            }
            Round::AboutPoint(center) => {
                let arms = ends.map(|end| Vector3::from(end) - Vector3::from(center));
                let [from, to] = arms.map(|arm| arm.norm());
                let toward = arms[0] / from + arms[1] / to;
                let scale = 0.5 * (from + to) / toward.norm();
                scale.is_finite().then(|| (Vector3::from(center) + scale * toward).into())
            }
            Round::OnBlock([low, high], radius) => {
                let arm = |x: Vector3<f64>| x - x.sup(&low.into()).inf(&high.into());
                let [a, b] = ends.map(Vector3::from);
                let middle = 0.5 * (a + b);
                let out = arm(middle);
                let is_on = are_all([a, b].map(|end| arm(end).norm()), radius) && out.norm() > 0.5 * radius;
                is_on.then(|| (middle - out + out * (radius / out.norm())).into())
            }
            Round::Ring(center, [ring, section]) => {
                let [x, y, z] = about([center[0], center[1]], ends)?;
                let in_section = |[x, y, z]: [f64; 3]| [(x - center[0]).hypot(y - center[1]) - ring, z - center[2]];
                if !are_all(ends.map(in_section).map(|[out, up]| out.hypot(up)), section) {
                    return Some([x, y, z]);
                }
                let [out, up] = in_section([x, y, z]);
                let grown = section / out.hypot(up);
                let scale = (ring + out * grown) / (ring + out);
                Some([center[0] + (x - center[0]) * scale, center[1] + (y - center[1]) * scale, center[2] + up * grown])
            }
        }
    }
}

/// Midpoint of an edge on its arc about an axis along z.
fn about(center: [f64; 2], [a, b]: [[f64; 3]; 2]) -> Option<[f64; 3]> {
    let arm = |point: [f64; 3]| [point[0] - center[0], point[1] - center[1]];
    let height = 0.5 * (a[2] + b[2]);
    let (a, b) = (arm(a), arm(b));
    let [from, to] = [a, b].map(|arm| arm[0].hypot(arm[1]));
    let toward = [0, 1].map(|i| a[i] / from + b[i] / to);
    let scale = 0.5 * (from + to) / toward[0].hypot(toward[1]);
    scale.is_finite().then(|| [center[0] + scale * toward[0], center[1] + scale * toward[1], height])
}

impl Mesh {
    /// [`Mesh::with_cells`] with the mid-side nodes of second-order cells on the exact curves of their edges, and the centers of the faces
    /// of hexahedra with 27 nodes on the exact surfaces.
    ///
    /// # Errors
    /// Errors of [`Mesh::with_cells`]; cells so coarse that they are inverted.
    pub fn with_round_cells(&self, kind: CellKind, round: Round) -> Result<Mesh, MeshError> {
        let mut mesh = self.with_cells(kind)?.curved(|_, ends| round.middle(ends))?;
        for cell in 0..mesh.cell_count() {
            mesh.center_on(cell, round);
        }
        mesh.checked()
    }

    /// Mesh with the mid-side nodes of edges at the positions of `middle`, given the end nodes of an edge and their positions; nodes in
    /// faces and centers follow as in cells with nodes on edges only.
    ///
    /// # Errors
    /// Cells that are inverted by the new positions.
    pub(super) fn curved(mut self, middle: impl Fn([u32; 2], [[f64; 3]; 2]) -> Option<[f64; 3]>) -> Result<Mesh, MeshError> {
        if !self.is_quadratic() {
            return Ok(self);
        }
        for cell in 0..self.cell_count() {
            let shape = self.kind_of(cell).shape();
            let (edges, corners) = (shape.edges(), shape.corners());
            for (number, ends) in edges.iter().enumerate() {
                let [a, b, c] = [ends[0], ends[1], corners + number].map(|k| self.cell(cell)[k]);
                if let Some(place) = middle([a, b], [a, b].map(|node| self.points[node as usize])) {
                    self.points[c as usize] = place;
                }
            }
        }
        for cell in 0..self.cell_count() {
            self.center(cell);
        }
        self.checked()
    }

    /// Moves the centers of those faces of a hexahedron with 27 nodes whose middle lines are curves of the given shape to the point where
    /// the two lines cross, and the center of the cell to the position that follows from its faces.
    fn center_on(&mut self, cell: usize, round: Round) {
        let kind = self.kind_of(cell);
        if kind != CellKind::Hex27 {
            return;
        }
        let nodes = self.cell(cell).to_vec();
        for facet in kind.facets() {
            let point = |local: usize| self.points[nodes[facet[local]] as usize];
            let crossing = [[4, 6], [5, 7]].map(|ends| round.middle(ends.map(point)));
            if let [Some(a), Some(b)] = crossing
                && let Some(place) = round.middle([a, b])
            {
                self.points[nodes[facet[8]] as usize] = place;
            }
        }
        let sum = |range: Range<usize>, i: usize| nodes[range].iter().map(|&node| self.points[node as usize][i]).sum::<f64>();
        let center = [0, 1, 2].map(|i| 0.5 * sum(20..26, i) - 0.25 * sum(8..20, i) + 0.125 * sum(0..8, i));
        self.points[nodes[26] as usize] = center;
    }

    /// Moves the nodes in the faces and in the center of a cell to the positions that follow from its edges.
    fn center(&mut self, cell: usize) {
        let nodes = self.cell(cell).to_vec();
        let mean = |points: &[[f64; 3]], (corners, edges): (&[u32], &[u32]), by: f64| {
            let sum = |nodes: &[u32], i: usize| nodes.iter().map(|&node| points[node as usize][i]).sum::<f64>();
            [0, 1, 2].map(|i| by * sum(edges, i) - 0.25 * sum(corners, i))
        };
        let kind = self.kind_of(cell);
        match kind {
            CellKind::Quad9 => self.points[nodes[8] as usize] = mean(&self.points, (&nodes[..4], &nodes[4..8]), 0.5),
            CellKind::Hex27 => {
                for facet in kind.facets() {
                    let face: Vec<u32> = facet.iter().map(|&local| nodes[local]).collect();
                    self.points[face[8] as usize] = mean(&self.points, (&face[..4], &face[4..8]), 0.5);
                }
                self.points[nodes[26] as usize] = mean(&self.points, (&nodes[..8], &nodes[8..20]), 0.25);
            }
            _ => {}
        }
    }
}
