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

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::mesh::{arc, cylinder, disk, half_disk, hollow_sphere, ring, rounded_block, sphere, torus, tube};

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
                    assert_eq!(mesh.only_kind(), Some(kind));
                    assert_eq!(mesh.defects(), [], "{name} {kind:?}");
                    assert_eq!(mesh.boundaries.len(), make(n).boundaries.len());
                    (mesh.measure() - area).abs() / area
                });
                // Halving the cell size reduces the error of chords to a quarter, that of parabolas to a sixteenth.
                let rate = (errors[0] / errors[1]).log2();
                let expected = if kind.is_quadratic() { 4.0 } else { 2.0 };
                assert!((rate - expected).abs() < 0.2, "{name} {kind:?}: {errors:?}, order {rate}");
            }
        }
    }

    #[test]
    fn centers_of_curved_faces_lie_on_the_exact_surface() {
        let round = Round::AboutPoint([0.0; 3]);
        let shell = hollow_sphere([0.5, 1.0], [1, 8], [0.0; 3], 1.0).unwrap().with_round_cells(CellKind::Hex27, round).unwrap();
        let base = Round::About([0.0; 2]);
        let pipe = tube([0.5, 1.0], 1.0, [1, 8, 1], [0.0; 3], [1.0; 2]).unwrap().with_round_cells(CellKind::Hex27, base).unwrap();
        let die = rounded_block([1.5; 3], 0.25, [2; 3], [1, 4], [0.0; 3]).unwrap();
        let [low, high] = [0.25, 1.25].map(|x| [x; 3]);
        let die = die.with_round_cells(CellKind::Hex27, Round::OnBlock([low, high], 0.25)).unwrap();
        let from_block = |x: [f64; 3]| (0..3).map(|i| (x[i] - x[i].clamp(low[i], high[i])).powi(2)).sum::<f64>().sqrt();
        let off = |mesh: &Mesh, sides: &[&str], distance: &dyn Fn([f64; 3]) -> f64, radius: f64| {
            let facets = sides.iter().flat_map(|side| &mesh.boundary(side).unwrap().facets);
            let nodes = facets.flat_map(|&facet| mesh.facet_nodes(facet));
            nodes.map(|node| (distance(mesh.points[node as usize]) - radius).abs()).fold(0.0, f64::max)
        };
        let norm = |x: [f64; 3]| Vector3::from(x).norm();
        let radius = |x: [f64; 3]| x[0].hypot(x[1]);
        for (side, r) in [("inner", 0.5), ("outer", 1.0)] {
            assert!(off(&shell, &[side], &norm, r) < 1e-15);
            assert!(off(&pipe, &[side], &radius, r) < 1e-15);
        }
        let sides: Vec<&str> = die.boundaries.iter().map(|boundary| boundary.name.as_str()).collect();
        assert!(off(&die, &sides, &from_block, 0.25) < 1e-15, "{}", off(&die, &sides, &from_block, 0.25));
    }

    #[test]
    fn round_solids_of_second_order_have_their_volume_to_the_fourth_order() {
        let (center, base) = ([0.1, 0.2, 0.3], [0.1, 0.2]);
        type Maker<'a> = &'a dyn Fn(usize) -> Mesh;
        let (low, high) = (center, [1.1, 1.2, 1.3]);
        let make: [(&str, f64, Maker, Round); 6] = [
            ("tube", 0.75 * PI, &|n| tube([0.5, 1.0], 1.0, [2, 12 * n, 2], center, [1.0; 2]).unwrap(), Round::About(base)),
            ("cylinder", PI, &|n| cylinder(1.0, 1.0, [2, 12 * n, 2], center, 1.0).unwrap(), Round::On(base, 1.0)),
            ("ball", 4.0 / 3.0 * PI, &|n| sphere(1.0, [2, 12 * n], center, 1.0).unwrap(), Round::OnBlock([center; 2], 1.0)),
            ("shell", 3.5 / 3.0 * PI, &|n| hollow_sphere([0.5, 1.0], [2, 12 * n], center, 1.0).unwrap(), Round::AboutPoint(center)),
            ("ring", 0.32 * PI * PI, &|n| torus(1.0, 0.4, [2, 12 * n, 12 * n], center).unwrap(), Round::Ring(center, [1.0, 0.4])),
            (
                "die",
                2.5 + 3.0 * PI * 0.0625 + PI / 48.0,
                &|n| rounded_block([1.5; 3], 0.25, [2; 3], [2, 4 * n], [-0.15, -0.05, 0.05]).unwrap(),
                Round::OnBlock([low, high], 0.25),
            ),
        ];
        for (name, volume, make, round) in make {
            for kind in [CellKind::Hex8, CellKind::Tet10, CellKind::Hex20, CellKind::Hex27] {
                let errors = [1, 2].map(|n| {
                    let mesh = make(n).with_round_cells(kind, round).unwrap_or_else(|error| panic!("{name} {kind:?}: {error}"));
                    assert_eq!(mesh.defects(), [], "{name} {kind:?}");
                    (mesh.measure() - volume).abs() / volume
                });
                let rate = (errors[0] / errors[1]).log2();
                let least = if kind.is_quadratic() { 3.5 } else { 1.8 };
                assert!(rate > least, "{name} {kind:?}: {errors:?}, order {rate}");
            }
        }
    }
}
