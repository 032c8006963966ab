//! Slip between curves over facets in the plane: rows of `slip.rs` for facets with height profiles (`profile.rs`).
//!
//! The point of the curve at the coordinate `s` of a facet with the vector `t = x_2 - x_1` is linear in the node positions, and its
//! displacement is the same function of the nodal displacements. With the quarter turn `K t = (t_y, -t_x)`, outwards,
//!
//! ```text
//! c(s) = (1 - s) x_1 + s x_2 + p(s) K t,    c'(s) = t + p'(s) K t
//! g_A d = int psi_A c'.(dc_secondary - dc_primary) ds      [length^2]
//! ```
//!
//! `|c'| ds` is the arc length. The virtual work of the weighted gap has the same measure: a ring of facets transfers the normal force
//! pressure times circumference of the circle, and the moment of friction about its axis is coefficient times normal force times radius.
//! Slips and forces on the straight facets have their distance from the axis as lever arm and their direction and length (the moment of a
//! ring is 1.5 % less with 20 facets around, 0.4 % with 40).

use super::numbers::Number;
use super::pair::{PerNode, slip_overlap};
use super::profile::{PairProfiles, Profile};
use crate::elements::GAUSS;

/// Vector in the plane.
type Vector<T> = [T; 2];

/// Facet vector turned outwards, `K t`.
fn outwards<T: Number>([x, y]: Vector<T>) -> Vector<T> {
    [y, -x]
}

/// Derivative `t + p' K t` of the points of a curve by the coordinate of its facet with the vector `t`; `rise` is the slope `p'`.
fn tangent<T: Number>(t: Vector<T>, rise: T) -> Vector<T> {
    let [x, y] = outwards(t);
    [t[0] + rise * x, t[1] + rise * y]
}

/// Adds `tau` times the derivatives of the curve point at the coordinate `share` and the relative height `height` of a facet to the rows of
/// the facet's two nodes.
fn add_point<T: Number>(tau: Vector<T>, share: T, height: T, first: &mut [T], second: &mut [T]) {
    let turned = [-tau[1] * height, tau[0] * height];
    for i in 0..2 {
        first[i] += tau[i] * (-share + 1.0) - turned[i];
        second[i] += tau[i] * share + turned[i];
    }
}

/// Adds the gradient `tau.(dc_secondary - dc_primary)` of a facet pair with the nodes `(x_1, x_2, y_1, y_2)`, for points of the curves
/// given by facet coordinate and relative height.
pub fn add_points<T: Number>(tau: Vector<T>, own: [T; 2], other: [T; 2], row: &mut [T; 8]) {
    let (of_own, of_other) = row.split_at_mut(4);
    for (sign, [share, height], nodes) in [(1.0, own, of_own), (-1.0, other, of_other)] {
        let (first, second) = nodes.split_at_mut(2);
        add_point(tau.map(|x| x * sign), share, height, first, second);
    }
}

/// Slip gradients `int N_k c'.(dc_secondary - dc_primary) ds` of both secondary nodes of a facet pair with the node positions
/// `(x_1, x_2, y_1, y_2)`, and the covered lengths; `None` without overlap.
///
/// Opposite points lie on a line along the normal of the secondary facet, as in the weighted gaps (`pair_profiles.rs`).
pub fn slip_rows<T: Number>(z: &[T], PairProfiles([own, other]): &PairProfiles) -> Option<(PerNode<[T; 8]>, PerNode<T>)> {
    let overlap = slip_overlap(z)?;
    let (t, extent) = (overlap.t, overlap.projections[0] - overlap.projections[1]);
    let length = (t[0] * t[0] + t[1] * t[1]).sqrt();
    let u = [z[4] - z[6], z[5] - z[7]];
    let slope = bounded((t[0] * u[1] - t[1] * u[0]) / (t[0] * u[0] + t[1] * u[1]));
    let (mut rows, mut covered) = ([[T::from(0.0); 8]; 2], [T::from(0.0); 2]);
    for (place, weight) in GAUSS {
        let s = overlap.ends[0] + (overlap.ends[1] - overlap.ends[0]) * place;
        let measure = (overlap.ends[1] - overlap.ends[0]) * weight;
        let [height, rise, _] = own.at(s);
        let xi = other.seen_at((s - overlap.projections[1]) / extent, slope);
        let mut row = [T::from(0.0); 8];
        let tau = tangent(t, rise);
        add_points(tau, [s, height], [-xi + 1.0, other.at(xi)[0]], &mut row);
        for (k, shape) in [-s + 1.0, s].into_iter().enumerate() {
            let by = measure * shape;
            covered[k] += length * by;
            rows[k].iter_mut().zip(row).for_each(|(sum, part)| *sum += by * part);
        }
    }
    Some((rows, covered))
}

/// Slope `m` bounded as in the weighted gaps, `m (1 + m^8)^(-1/8)`.
fn bounded<T: Number>(m: T) -> T {
    let fourth = m * m * m * m;
    m / (fourth * fourth + 1.0).sqrt().sqrt().sqrt()
}

/// Slip gradient of a point that slides along the curve over a facet `y_1 y_2`: `weight` times its displacement relative to the curve point
/// above the foot of the point on the facet (beside the facet its end), along `(t + p' K t)/|t|`, for the positions `(x, y_1, y_2)`. The
/// gradient of the gap, `n - p' t/|t|`, has the same length.
pub fn point_on_curve<T: Number>(z: &[T], weight: f64, profile: &Profile) -> [T; 6] {
    let u = [z[4] - z[2], z[5] - z[3]];
    let square = u[0] * u[0] + u[1] * u[1];
    let foot = ((z[0] - z[2]) * u[0] + (z[1] - z[3]) * u[1]) / square;
    let inside = foot.re().clamp(0.0, 1.0);
    let share = if foot.re() == inside { foot } else { T::from(inside) };
    let [height, rise, _] = profile.at(share);
    // The secondary side traverses the facet in reverse.
    let tau = tangent(u, rise).map(|x| x * (square.sqrt().recip() * -weight));
    let mut row = [T::from(0.0); 6];
    let (own, other) = row.split_at_mut(2);
    let (first, second) = other.split_at_mut(2);
    own.copy_from_slice(&tau);
    add_point(tau.map(|x| -x), share, height, first, second);
    row
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Concentric circles with facets of unlike lengths: a unit rotation of the inner one has the slip radius times arc length, in all
    /// positions of the facets, and a rotation of both circles has no slip.
    #[test]
    fn circles_that_turn_slide_by_their_radius() {
        let (half, other_half) = (0.15, 0.12);
        let profile = |half: f64, sign: f64| {
            let (rise, mean) = (sign * half.tan(), sign * (half - half.sin() * half.cos()) / (4.0 * half.sin().powi(2)));
            Profile::new([0.0, rise], [0.0, -rise], mean)
        };
        let profiles = PairProfiles([profile(half, 1.0), profile(other_half, -1.0)]);
        for shift in [-0.2, -0.03, 0.0, 0.1, 0.21] {
            // Bodies on the left: the inner circle is traversed counterclockwise, the outer one clockwise.
            let at = |phi: f64| [-phi.sin(), phi.cos()];
            let nodes = [at(-half), at(half), at(shift + other_half), at(shift - other_half)];
            let (rows, _) = slip_rows(nodes.as_flattened(), &profiles).unwrap();
            let turned = |k: usize| [-nodes[k][1], nodes[k][0]];
            let slip = |of: std::ops::Range<usize>| -> f64 {
                rows.iter().map(|row| of.clone().map(|k| row[2 * k] * turned(k)[0] + row[2 * k + 1] * turned(k)[1]).sum::<f64>()).sum()
            };
            // Ends of the overlap on the circle: corners of the outer facet are projected along the normal of the inner one.
            let ends = [(shift - other_half).max(-half), (shift + other_half).min(half)];
            let (own, both) = (slip(0..2), slip(0..4));
            assert!((own / (ends[1] - ends[0]) - 1.0).abs() < 2e-4, "{shift}: {own} {ends:?}");
            assert!(both.abs() < 2e-4 * own, "{shift}: {both}");
        }
    }
}
