//! Surface normal at a border between two facets of four nodes, for height profiles (`profiles.rs`).
//!
//! The formula of Max for the edge vectors `r_k` from a node to its neighbors, `n ~ sum r_k x r_k+1/(|r_k|^2 |r_k+1|^2)`, is exact for
//! spheres if facets surround the node. At a border with the neighbors `r_1`, `r_3` along it and `r_2` inside, it gives the direction
//! perpendicular to `u = r_3/|r_3|^2 - r_1/|r_1|^2`, which is tangential to the sphere, and to `r_2`, which is not. Along the arc of a
//! circle from the border to the inner node with the normal `m`, the angles between normals and chord are equal instead:
//!
//! ```text
//! n.u = 0,    n.r_2 = -m.r_2
//! ```
//!
//! On cylinders along their axis `m.r_2` is zero. Without this condition the force of a fit of octants of hollow spheres (6 on 4 cells of
//! first order, interference 1e-3) was 16 % too large (`tests/scripts/curved_in_space.rhai`).

use crate::contact::faces::Vector;
use crate::math::tolerances::STRAIGHT;

/// Largest sine of the angle by which the normal at a border is turned: half of the largest angle of a curve (0.22), with a margin.
const MOST_TURNED: f64 = 0.3;

/// Normal at a node of the border from the normal `fitted` of Max's formula, the vectors `along` to the neighbors on the border, the vector
/// `inward` to the inner neighbor, and the normal `inner` there.
pub fn border_normal(fitted: Vector, along: [Vector; 2], inward: Vector, inner: Vector) -> Vector {
    let [first, last] = along.map(|way| way / way.norm_squared());
    let (Some(tangent), Some(chord)) = ((last - first).try_normalize(0.0), inward.try_normalize(0.0)) else { return fitted };
    let (across, rise) = (fitted.cross(&tangent), inner.dot(&chord));
    let sine = -rise / across.dot(&chord);
    // On cylinders the rise is round-off.
    if rise.abs() < STRAIGHT || !sine.is_finite() || sine.abs() > MOST_TURNED {
        return fitted;
    }
    fitted * (1.0 - sine * sine).sqrt() + across * sine
}
