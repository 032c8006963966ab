//! Translation, rotation and scaling of a mesh; each takes the mesh and returns another one.
//!
//! Transforms move nodes only, so boundaries and parts do not change.

use super::{Mesh, MeshError};

impl Mesh {
    /// The mesh moved by `offset` `[length]`.
    ///
    /// # Errors
    /// Offsets that are not finite, or out of the plane of a plane mesh.
    pub fn translate(mut self, offset: [f64; 3]) -> Result<Mesh, MeshError> {
        all_finite("a component of the translation", &offset)?;
        if self.dimension() == 2 && offset[2] != 0.0 {
            return Err(MeshError::LeavesPlane { what: "the translation" });
        }
        for point in &mut self.points {
            *point = [0, 1, 2].map(|i| point[i] + offset[i]);
        }
        self.checked()
    }

    /// The mesh turned by `angle` `[rad]` about the line through `center` `[length]` along the z axis; in the plane: about the point,
    /// counter-clockwise.
    ///
    /// # Errors
    /// Numbers that are not finite.
    pub fn rotate(self, angle: f64, center: [f64; 3]) -> Result<Mesh, MeshError> {
        self.rotate_about(angle, center, [0.0, 0.0, 1.0])
    }

    /// The mesh turned by `angle` `[rad]` about the line through `center` `[length]` along `axis` (of any length), by the right-hand rule:
    /// `x' = u u.x + (x - u u.x) cos(angle) + u x x sin(angle)` with the unit vector `u` (O. Rodrigues, 1840).
    ///
    /// # Errors
    /// Numbers that are not finite, an axis of length 0, an axis other than z for a plane mesh.
    pub fn rotate_about(mut self, angle: f64, center: [f64; 3], axis: [f64; 3]) -> Result<Mesh, MeshError> {
        all_finite("the rotation angle", &[angle])?;
        all_finite("a coordinate of the center of rotation", &center)?;
        let length = axis[0].hypot(axis[1]).hypot(axis[2]);
        if !(length > 0.0 && length.is_finite()) {
            return Err(MeshError::NoAxis { axis });
        }
        let u = axis.map(|a| a / length);
        if self.dimension() == 2 && (u[0] != 0.0 || u[1] != 0.0) {
            return Err(MeshError::LeavesPlane { what: "the rotation" });
        }
        let (sine, cosine) = angle.sin_cos();
        for point in &mut self.points {
            let arm = [0, 1, 2].map(|i| point[i] - center[i]);
            let along: f64 = (0..3).map(|i| u[i] * arm[i]).sum();
            let across = [u[1] * arm[2] - u[2] * arm[1], u[2] * arm[0] - u[0] * arm[2], u[0] * arm[1] - u[1] * arm[0]];
            let turned = [0, 1, 2].map(|i| center[i] + u[i] * along + (arm[i] - u[i] * along) * cosine + across[i] * sine);
            // Rotation about z leaves the third coordinate exactly unchanged.
            *point = if u[0] == 0.0 && u[1] == 0.0 { [turned[0], turned[1], point[2]] } else { turned };
        }
        self.checked()
    }

    /// Mesh scaled by a factor per direction about the origin; the third has no effect on a plane mesh.
    ///
    /// # Errors
    /// Factors that are not finite and positive.
    pub fn scale(mut self, factors: [f64; 3]) -> Result<Mesh, MeshError> {
        if let Some(&value) = factors.iter().find(|f| !(f.is_finite() && **f > 0.0)) {
            return Err(MeshError::NotPositive { what: "a scale factor", value });
        }
        for point in &mut self.points {
            *point = [0, 1, 2].map(|i| point[i] * factors[i]);
        }
        self.checked()
    }
}

fn all_finite(what: &'static str, values: &[f64]) -> Result<(), MeshError> {
    match values.iter().find(|value| !value.is_finite()) {
        Some(&value) => Err(MeshError::NotFinite { what, value }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;
    use crate::mesh::{CELL_LIMIT, Facet, block, rectangle, ring};

    /// Round-off of sums of some hundred terms of order one.
    const ROUND_OFF: f64 = 1e-13;

    fn near(a: [f64; 3], b: [f64; 3]) -> bool {
        (0..3).all(|i| (a[i] - b[i]).abs() < ROUND_OFF)
    }

    #[test]
    fn translation_and_rotation_move_the_corners() {
        let mesh = rectangle([2.0, 1.0], [2, 1], [0.0; 2]).unwrap();
        let area = mesh.measure();
        let moved = mesh.translate([1.0, -1.0, 0.0]).unwrap().rotate(FRAC_PI_2, [1.0, -1.0, 0.0]).unwrap();
        assert!(near(moved.points[0], [1.0, -1.0, 0.0]) && near(moved.points[2], [1.0, 1.0, 0.0]));
        assert!(near(moved.points[5], [0.0, 1.0, 0.0]));
        assert!((moved.measure() - area).abs() < ROUND_OFF);
        assert!(moved.points.iter().all(|p| p[2] == 0.0));
    }

    #[test]
    fn rotation_in_space_follows_the_right_hand() {
        let mesh = block([1.0, 2.0, 3.0], [1, 1, 1], [0.0; 3]).unwrap();
        // a third of a turn about the space diagonal permutes the axes: x -> y -> z -> x
        let turned = mesh.clone().rotate_about(2.0 * PI / 3.0, [0.0; 3], [2.0, 2.0, 2.0]).unwrap();
        for (before, after) in mesh.points.iter().zip(&turned.points) {
            assert!(near(*after, [before[2], before[0], before[1]]), "{before:?} {after:?}");
        }
        assert_eq!(turned.defects(), []);
    }

    #[test]
    fn scaling_multiplies_lengths_and_area() {
        let mesh = rectangle([2.0, 1.0], [2, 2], [1.0, 1.0]).unwrap().scale([2.0, 3.0, 1.0]).unwrap();
        assert!((mesh.measure() - 12.0).abs() < ROUND_OFF);
        assert!((mesh.boundary_measure(mesh.boundary("left").unwrap()) - 3.0).abs() < ROUND_OFF);
        assert_eq!(mesh.points[0], [2.0, 3.0, 0.0]);
    }

    #[test]
    fn refinement_keeps_area_boundaries_and_parts() {
        let mut mesh = ring(0.5, 1.0, [2, 7], [1.0, 2.0], 0.1).unwrap();
        mesh.parts = vec![("inside".into(), (0..7).collect()), ("one".into(), vec![9])];
        let fine = mesh.refine().unwrap();
        assert_eq!((fine.cell_count(), fine.points.len()), (4 * 14, 5 * 14));
        assert!((fine.measure() - mesh.measure()).abs() < ROUND_OFF);
        assert_eq!(fine.defects(), []);
        for (coarse, fine_boundary) in mesh.boundaries.iter().zip(&fine.boundaries) {
            assert_eq!((fine_boundary.name.as_str(), fine_boundary.facets.len()), (coarse.name.as_str(), 14));
            assert!((fine.boundary_measure(fine_boundary) - mesh.boundary_measure(coarse)).abs() < ROUND_OFF);
            // The boundary is still traversed with the body on the left.
            let ends: Vec<Vec<u32>> = fine_boundary.facets.iter().map(|&f| fine.facet_nodes(f).collect()).collect();
            assert!(ends.windows(2).all(|pair| pair[0][1] == pair[1][0]));
        }
        for (name, share) in [("inside", 7), ("one", 1)] {
            let (part, whole) = (fine.part(name).unwrap(), mesh.part(name).unwrap());
            assert_eq!(part.cell_count(), 4 * share);
            assert!((part.measure() - whole.measure()).abs() < ROUND_OFF);
        }
        // The hull consists exactly of the facets of the boundaries.
        let mut named: Vec<Facet> = fine.boundaries.iter().flat_map(|b| b.facets.clone()).collect();
        named.sort_unstable();
        assert_eq!(fine.hull(), named);
    }

    #[test]
    fn a_refined_block_is_the_finer_block() {
        let fine = block([1.0, 2.0, 3.0], [2, 1, 1], [0.5; 3]).unwrap().refine().unwrap();
        let direct = block([1.0, 2.0, 3.0], [4, 2, 2], [0.5; 3]).unwrap();
        let sorted = |mesh: &Mesh| {
            let mut points = mesh.points.clone();
            points.sort_by(|a, b| a.partial_cmp(b).unwrap());
            points
        };
        assert_eq!(sorted(&fine), sorted(&direct));
        assert_eq!(fine.defects(), []);
        for name in ["left", "right", "bottom", "top", "back", "front"] {
            let [f, d] = [&fine, &direct].map(|mesh| {
                let boundary = mesh.boundary(name).unwrap();
                let mut points: Vec<_> = mesh.boundary_nodes(boundary).iter().map(|&n| mesh.points[n as usize]).collect();
                points.sort_by(|a, b| a.partial_cmp(b).unwrap());
                points
            });
            assert_eq!(f, d, "{name}");
        }
    }

    #[test]
    fn bad_transforms_are_refused() {
        let plane = rectangle([1.0, 1.0], [1, 1], [0.0; 2]).unwrap();
        let refused = [
            plane.clone().translate([0.0, 0.0, 1.0]),
            plane.clone().translate([f64::NAN, 0.0, 0.0]),
            plane.clone().rotate(f64::INFINITY, [0.0; 3]),
            plane.clone().rotate_about(1.0, [0.0; 3], [1.0, 0.0, 1.0]),
            plane.clone().rotate_about(1.0, [0.0; 3], [0.0; 3]),
            plane.clone().scale([-1.0, 1.0, 1.0]),
            plane.clone().scale([0.0, 1.0, 1.0]),
            plane.clone().scale([1e300, 1e300, 1.0]).and_then(|mesh| mesh.scale([1e300, 1.0, 1.0])),
        ];
        for (i, result) in refused.into_iter().enumerate() {
            assert!(!result.unwrap_err().hint().is_empty(), "{i}");
        }
        assert_eq!(
            plane.clone().scale([-1.0, 1.0, 1.0]).unwrap_err().hint(),
            "scale by positive numbers; a mirrored mesh would be inside out"
        );
        let mut many = plane;
        many.blocks[0].connectivity = vec![0; 4 * (CELL_LIMIT / 4 + 1)];
        assert!(matches!(many.refine(), Err(MeshError::TooManyCells { .. })));
    }
}
