//! Middle nodes of cells of second order put onto the curve or the surface that an edge stands for.

use super::{Mesh, MeshError};
use crate::elements::CellKind;

/// The circles that the edges of a round mesh stand for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Round {
    /// Every edge is part of a circle or of a ray about this center `[length]`: a ring.
    About([f64; 2]),
    /// Edges whose ends are both on the circle of this center and radius `[length]` are part of it: a disk.
    On([f64; 2], f64),
}

impl Round {
    /// The middle of an edge along its curve; nothing when it is straight.
    fn middle(self, [a, b]: [[f64; 3]; 2]) -> Option<[f64; 3]> {
        let (Round::About(center) | Round::On(center, _)) = self;
        let arm = |point: [f64; 3]| [point[0] - center[0], point[1] - center[1]];
        let (a, b) = (arm(a), arm(b));
        let [from, to] = [a, b].map(|arm| arm[0].hypot(arm[1]));
        if let Round::On(_, radius) = self
            && [from, to].iter().any(|length| (length / radius - 1.0).abs() > crate::math::tolerances::PLANE)
        {
            return None;
        }
        let toward = [0, 1].map(|i| a[i] / from + b[i] / to);
        let scale = 0.5 * (from + to) / toward[0].hypot(toward[1]);
        scale.is_finite().then(|| [center[0] + scale * toward[0], center[1] + scale * toward[1], 0.0])
    }
}

impl Mesh {
    /// [`Mesh::with_cells`] with the middle nodes of plane second-order cells on circles.
    ///
    /// # Errors
    /// As those of [`Mesh::with_cells`]; cells so coarse that they are inside out then.
    pub fn with_round_cells(&self, kind: CellKind, round: Round) -> Result<Mesh, MeshError> {
        self.with_cells(kind)?.curved(|_, ends| round.middle(ends))
    }

    /// The mesh with middle nodes of edges where `middle` puts them, given the nodes at the ends of an edge and their places; what stands
    /// within faces and cells follows as in cells that have nodes on their edges alone.
    ///
    /// # Errors
    /// Cells that are inside out then.
    pub(super) fn curved(mut self, middle: impl Fn([u32; 2], [[f64; 3]; 2]) -> Option<[f64; 3]>) -> Result<Mesh, MeshError> {
        if !self.kind.is_quadratic() {
            return Ok(self);
        }
        let (edges, corners) = (self.kind.shape().edges(), self.kind.shape().corners());
        for cell in 0..self.cell_count() {
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

    /// Puts the nodes within the faces and in the center of a cell where cells without them have these places.
    fn center(&mut self, cell: usize) {
        let nodes = self.cell(cell).to_vec();
        let mean = |points: &[[f64; 3]], (corners, edges): (&[u32], &[u32]), by: f64| {
            let sum = |nodes: &[u32], i: usize| nodes.iter().map(|&node| points[node as usize][i]).sum::<f64>();
            [0, 1, 2].map(|i| by * sum(edges, i) - 0.25 * sum(corners, i))
        };
        match self.kind {
            CellKind::Quad9 => self.points[nodes[8] as usize] = mean(&self.points, (&nodes[..4], &nodes[4..8]), 0.5),
            CellKind::Hex27 => {
                for facet in self.kind.facets() {
                    let face: Vec<u32> = facet.iter().map(|&local| nodes[local]).collect();
                    self.points[face[8] as usize] = mean(&self.points, (&face[..4], &face[4..8]), 0.5);
                }
                self.points[nodes[26] as usize] = mean(&self.points, (&nodes[..8], &nodes[8..20]), 0.25);
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::mesh::{arc, disk, half_disk, ring};

    const PLANE_KINDS: [CellKind; 5] = [CellKind::Tri3, CellKind::Quad4, CellKind::Tri6, CellKind::Quad8, CellKind::Quad9];

    #[test]
    fn round_meshes_of_every_kind_have_their_area_to_the_order_of_the_kind() {
        let center = [0.3, -0.2];
        type Maker<'a> = &'a dyn Fn(usize) -> Mesh;
        let make: [(&str, f64, Maker, Round); 4] = [
            ("ring", 0.75 * PI, &|n| ring(0.5, 1.0, [2 * n, 12 * n], center, 0.1).unwrap(), Round::About(center)),
            ("arc", 0.375, &|n| arc([0.5, 1.0], [0.2, 1.2], [2 * n, 4 * n], center, [1.0, 2.0]).unwrap(), Round::About(center)),
            ("disk", PI, &|n| disk(1.0, [2 * n, 16 * n], center).unwrap(), Round::On(center, 1.0)),
            ("half disk", 0.5 * PI, &|n| half_disk(1.0, [2 * n, 16 * n], center, None).unwrap(), Round::On(center, 1.0)),
        ];
        for (name, area, make, round) in make {
            for kind in PLANE_KINDS {
                let errors = [1, 2].map(|n| {
                    let mesh = make(n).with_round_cells(kind, round).unwrap_or_else(|error| panic!("{name} {kind:?}: {error}"));
                    assert_eq!(mesh.kind, kind);
                    assert_eq!(mesh.defects(), [], "{name} {kind:?}");
                    assert_eq!(mesh.boundaries.len(), make(n).boundaries.len());
                    (mesh.measure() - area).abs() / area
                });
                // half the size: a quarter of the error of chords, a sixteenth of that of parabolas
                let rate = (errors[0] / errors[1]).log2();
                let expected = if kind.is_quadratic() { 4.0 } else { 2.0 };
                assert!((rate - expected).abs() < 0.2, "{name} {kind:?}: {errors:?}, order {rate}");
            }
        }
    }
}
