//! Gaps of a vertex against a facet, and of two crossing edges, as functions of four or five nodes (for `corners.rs`, `nodes.rs`).
//!
//! ```text
//! vertex v, facet y_1..y_k (mean point y):  g = n.(v - y),        n = N/|N|, N = (y_3 - y_1) x (y_4 - y_2)
//! vertex v, triangle with profile B:        g - s B at the projection of v; facets of four nodes have four triangles about y,
//!                                           s: stretch of the facet (`stretch.rs`)
//! edges a b, c d:                           g = sigma n.(c - a),  n = N/|N|, N = (b - a) x (d - c)
//! ```
//!
//! positive when open. The sign `sigma = +-1` is chosen at the start of a step so that `n` points out of the first edge's body. The
//! gradient of the edge gap is `-n (1 - s)`, `-n s`, `n (1 - t)`, `n t` with the feet `s`, `t` of the common perpendicular, where the terms
//! with the derivative of `n` vanish. All functions are generic in the number type, so that numbers with derivatives give the Hessian.

use super::curve_slip::NormalPart;
use super::facet_profile::Profile;
use super::forms::{Form, derivatives, value};
use super::stretch::{Stretch, Stretched};
use super::vectors::{self, FacetFrame, Gradient, Jet, Vec3, cross, diagonal_ends, diagonals, dot, scaled, sub};
use super::vertices;
use crate::contact::numbers::Number;

/// Largest number of nodes of a constraint.
pub const NODES: usize = 5;

/// Largest number of unknowns of a constraint.
pub const UNKNOWNS: usize = 3 * NODES;

/// Gap function of a constraint in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measure {
    /// Vertex against a flat facet with the given number of nodes.
    Facet(usize),
    /// Vertex against a triangle with a height profile that follows the stretch of its facet. The shape functions distribute the force.
    /// `None`: a facet of three nodes; `Some(k)`: the triangle of nodes `k`, `k + 1` and the mean point of a facet of four nodes.
    Over(Option<usize>, Form, Stretch),
    /// Two edges, with the sign `sigma` of their normal.
    Edges(f64),
}

/// Two vectors, with the length and direction of their cross product.
struct Spread<T> {
    first: Vec3<T>,
    second: Vec3<T>,
    length: T,
    normal: Vec3<T>,
}

impl<T: Number> Spread<T> {
    #[inline(always)]
    fn new([first, second]: [Vec3<T>; 2]) -> Self {
        let product = cross(first, second);
        let length = dot(product, product).sqrt();
        let inverse = length.recip();
        Spread { first, second, length, normal: product.map(|x| x * inverse) }
    }

    /// Vectors of two edges, given by their ends.
    #[inline(always)]
    fn of_edges(z: &[Vec3<T>]) -> Self {
        Spread::new([sub(z[1], z[0]), sub(z[3], z[2])])
    }

    /// Feet of the common perpendicular of two lines along both vectors; `from` leads from the start of the first to that of the second.
    #[inline(always)]
    fn feet(&self, from: Vec3<T>) -> [T; 2] {
        let square = (self.length * self.length).recip();
        let product = self.normal.map(|n| n * self.length);
        [dot(cross(from, self.second), product) * square, dot(cross(from, self.first), product) * square]
    }
}

impl Measure {
    /// Gap at the node positions `z` `[length]`.
    pub fn gap(self, z: &[Vec3<f64>]) -> f64 {
        match self {
            Measure::Facet(count) => {
                let (v, y) = (z[0], &z[1..]);
                let middle: Vec3<f64> = std::array::from_fn(|i| y.iter().map(|y| y[i]).sum::<f64>() / count as f64);
                dot(Spread::new(diagonals(y)).normal, sub(v, middle))
            }
            Measure::Over(first, form, stretch) => {
                let (flat, height, _) = over(triangle(z, first), &form, stretch.at(&z[1..]).by);
                flat - height
            }
            Measure::Edges(sign) => sign * dot(Spread::of_edges(z).normal, sub(z[2], z[0])),
        }
    }

    /// Gradient of the gap with respect to the nodes.
    #[inline(always)]
    pub fn gradient<T: Number>(self, z: &[Vec3<T>]) -> [Vec3<T>; NODES] {
        let mut gradient = [[T::from(0.0); 3]; NODES];
        match self {
            Measure::Facet(count) => {
                let (v, y) = (z[0], &z[1..]);
                let share = 1.0 / count as f64;
                let spread = Spread::new(diagonals(y));
                let n = spread.normal;
                let mut arm = v;
                y.iter().for_each(|y| (0..3).for_each(|i| arm[i] -= y[i] * share));
                let gap = dot(n, arm);
                let inverse = spread.length.recip();
                let lever: Vec3<T> = std::array::from_fn(|i| (arm[i] - n[i] * gap) * inverse);
                gradient[0] = n;
                (1..=count).for_each(|k| gradient[k] = n.map(|n| n * -share));
                // Derivative of the normal direction: d N.lever = d first.(second x lever) + d second.(lever x first).
                let (of_first, of_second) = (cross(spread.second, lever), cross(lever, spread.first));
                for ((from, to), force) in diagonal_ends(count).into_iter().zip([of_first, of_second]) {
                    for i in 0..3 {
                        gradient[1 + to][i] += force[i];
                        gradient[1 + from][i] -= force[i];
                    }
                }
            }
            Measure::Over(first, form, stretch) => {
                let Stretched { by, rises } = stretch.at(&z[1..]);
                let (_, height, of) = over(triangle(z, first), &form, by);
                if let Some(k) = first {
                    let [of_vertex, of_node, of_next, of_middle] = of;
                    (gradient[0], gradient[1 + k], gradient[1 + (k + 1) % 4]) = (of_vertex, of_node, of_next);
                    for gradient in &mut gradient[1..] {
                        for i in 0..3 {
                            gradient[i] += of_middle[i] * 0.25;
                        }
                    }
                } else {
                    gradient[..4].copy_from_slice(&of);
                }
                for (gradient, rise) in gradient[1..].iter_mut().zip(rises) {
                    for i in 0..3 {
                        gradient[i] -= height * rise[i];
                    }
                }
            }
            Measure::Edges(sign) => {
                let n = Spread::of_edges(z).normal.map(|n| n * -sign);
                for (gradient, weight) in gradient.iter_mut().zip(self.weights(z)) {
                    *gradient = n.map(|n| n * weight);
                }
            }
        }
        gradient
    }

    /// Writes `weight` times the gradient at the unknowns `z`.
    pub fn gradient_into(self, z: &[f64], weight: f64, out: &mut [f64]) {
        let gradient = self.gradient::<f64>(z.as_chunks().0);
        out.iter_mut().zip(gradient.as_flattened()).for_each(|(out, g)| *out = weight * g);
    }

    /// Writes `share` times the Hessian at the unknowns `z`.
    pub fn hessian_into(self, z: &[f64], share: f64, out: &mut [f64]) {
        vectors::hessian_into(z, share, out, &self);
    }

    /// Weights of the nodal displacements in the relative displacement at the contact point; their sum is zero.
    #[inline(always)]
    pub fn weights<T: Number>(self, z: &[Vec3<T>]) -> [T; NODES] {
        let mut weights = [T::from(0.0); NODES];
        match self {
            Measure::Facet(_) | Measure::Over(..) => {
                weights[0] = T::from(1.0);
                foot(z[0], &z[1..]).1.into_iter().take(z.len() - 1).enumerate().for_each(|(k, weight)| weights[1 + k] = -weight);
            }
            Measure::Edges(_) => {
                let [s, t] = Spread::of_edges(z).feet(sub(z[2], z[0]));
                (weights[0], weights[1], weights[2], weights[3]) = (-s + 1.0, s, t - 1.0, -t);
            }
        }
        weights
    }

    /// Two unit tangents perpendicular to the gap direction, which move with the facet or with the first edge.
    pub fn tangents<T: Number>(self, z: &[Vec3<T>]) -> Option<[Vec3<T>; 2]> {
        match self {
            Measure::Facet(_) | Measure::Over(..) => {
                FacetFrame::new(&z[1..]).map(|FacetFrame { axes: [first, second, _], .. }| [first, second])
            }
            Measure::Edges(_) => {
                let Spread { first, normal, .. } = Spread::of_edges(z);
                let first = scaled(first, dot(first, first).sqrt().recip());
                Some([first, cross(normal, first)])
            }
        }
    }

    /// Weights along the normal of a triangle with a height profile in the slips along both tangents, see `curve_slip.rs`, times the area
    /// of the vertex; `None` for flat facets and edges. With the height `B` and the gradient `b` of the profile they are `t.b` for the
    /// vertex and `B t.grad M_k - M_k t.b` for the corners of the triangle.
    pub fn normal_part<T: Number>(self, z: &[Vec3<T>], tangents: &[Vec3<T>; 2], area: f64) -> Option<NormalPart<T>> {
        let Measure::Over(first, form, stretch) = self else { return None };
        if form == [0.0; 6] {
            return None;
        }
        let [v, y_0, y_1, y_2] = triangle(z, first);
        let Plane { normal, duals, shares, .. } = Plane::new(v, [y_0, y_1, y_2]);
        let rises = scaled(derivatives(&form, &shares), stretch.at(&z[1..]).by);
        let height = value(&rises, &shares);
        let mut weights = [[T::from(0.0); vertices::NODES]; 2];
        for (weights, tangent) in weights.iter_mut().zip(tangents) {
            let along = [dot(*tangent, duals[0]) * area, dot(*tangent, duals[1]) * area];
            let rise = along[0] * (rises[1] - rises[0]) + along[1] * (rises[2] - rises[0]);
            let slopes = [-(along[0] + along[1]), along[0], along[1]];
            let corners: [T; 3] = std::array::from_fn(|k| height * slopes[k] - shares[k] * rise);
            weights[0] = rise;
            let Some(k) = first else {
                weights[1..4].copy_from_slice(&corners);
                continue;
            };
            (1..5).for_each(|node| weights[node] = corners[2] * 0.25);
            weights[1 + k] += corners[0];
            weights[1 + (k + 1) % 4] += corners[1];
        }
        Some(NormalPart { normal, weights })
    }

    /// Gap function of a vertex against the triangle of the facet below it.
    pub fn above(z: &[Vec3<f64>], profile: &Profile) -> Measure {
        let first = (z.len() > 4).then(|| foot(z[0], &z[1..]).0);
        Measure::Over(first, *profile.form(first.unwrap_or(0)), profile.stretch)
    }

    /// Feet of the common perpendicular of two edges, and sine of the angle between them.
    pub fn feet(z: &[Vec3<f64>]) -> ([f64; 2], f64) {
        let spread = Spread::of_edges(z);
        let sine = spread.length / (dot(spread.first, spread.first) * dot(spread.second, spread.second)).sqrt();
        (spread.feet(sub(z[2], z[0])), sine)
    }
}

impl Gradient<NODES> for Measure {
    #[inline(always)]
    fn at(&self, x: &[Vec3<Jet>]) -> [Vec3<Jet>; NODES] {
        self.gradient(x)
    }
}

/// Vertex and corners of a triangle: of a facet of three nodes (`None`), or of the triangle of a facet of four nodes that starts at node
/// `first`.
#[inline(always)]
fn triangle<T: Number>(z: &[Vec3<T>], first: Option<usize>) -> [Vec3<T>; 4] {
    let y = &z[1..];
    let Some(k) = first else { return [z[0], y[0], y[1], y[2]] };
    let middle = std::array::from_fn(|i| (y[0][i] + y[1][i] + y[2][i] + y[3][i]) * 0.25);
    [z[0], y[k], y[(k + 1) % 4], middle]
}

/// Plane of a triangle below a vertex.
struct Plane<T> {
    normal: Vec3<T>,
    /// Dual vectors of the sides from the first corner: gradients of the second and third shape function.
    duals: [Vec3<T>; 2],
    /// Shape functions at the projection of the vertex.
    shares: [T; 3],
    /// Distance of the vertex from the plane `[length]`.
    distance: T,
}

impl<T: Number> Plane<T> {
    #[inline(always)]
    fn new(v: Vec3<T>, [y_0, y_1, y_2]: [Vec3<T>; 3]) -> Self {
        let [first, second, arm] = [sub(y_1, y_0), sub(y_2, y_0), sub(v, y_0)];
        let spread = Spread::new([first, second]);
        let (n, inverse) = (spread.normal, spread.length.recip());
        let duals = [scaled(cross(second, n), inverse), scaled(cross(n, first), inverse)];
        let [of_first, of_second] = [dot(arm, duals[0]), dot(arm, duals[1])];
        let shares = [-(of_first + of_second) + 1.0, of_first, of_second];
        Plane { normal: n, duals, shares, distance: dot(arm, n) }
    }
}

/// Gap `g` of a vertex over a triangle, height of the profile there, and the gradient of their difference for a constant factor `by` of
/// the profile. With the dual vectors `e_a` of the sides `d_a` and the gradient `b` of the profile it is
/// `(n - b).(dv - sum M_k dy_k) - g sum (b.e_a) n.dd_a`.
#[inline(always)]
fn over<T: Number>([v, y_0, y_1, y_2]: [Vec3<T>; 4], form: &Form, by: T) -> (T, T, [Vec3<T>; 4]) {
    let Plane { normal: n, duals, shares, distance: flat } = Plane::new(v, [y_0, y_1, y_2]);
    let rises = scaled(derivatives(form, &shares), by);
    let slopes = [rises[1] - rises[0], rises[2] - rises[0]];
    let (mut slope, mut push) = ([T::from(0.0); 3], n);
    for i in 0..3 {
        slope[i] = duals[0][i] * slopes[0] + duals[1][i] * slopes[1];
        push[i] -= slope[i];
    }
    let mut gradient = [push; 4];
    for k in 0..3 {
        gradient[k + 1] = scaled(push, -shares[k]);
    }
    for a in 0..2 {
        let turn = scaled(n, flat * dot(slope, duals[a]));
        for i in 0..3 {
            gradient[1][i] += turn[i];
            gradient[2 + a][i] -= turn[i];
        }
    }
    (flat, value(&rises, &shares), gradient)
}

/// Triangle of a facet about its mean point into which `v` projects along the facet's normal, and piecewise linear coefficients of the
/// facet's nodes in that point.
#[inline(always)]
fn foot<T: Number>(v: Vec3<T>, y: &[Vec3<T>]) -> (usize, [T; 4]) {
    let (count, zero) = (y.len(), T::from(0.0));
    let [first, second] = diagonals(y);
    let normal = cross(first, second);
    let part = 1.0 / count as f64;
    let middle: Vec3<T> = std::array::from_fn(|i| y.iter().fold(zero, |sum, y| sum + y[i] * part));
    let (mut triangle, mut shares) = (0, [zero; 4]);
    let mut least = f64::NEG_INFINITY;
    for k in 0..count {
        let next = (k + 1) % count;
        let (a, b, r) = (sub(y[k], middle), sub(y[next], middle), sub(v, middle));
        let inverse = dot(cross(a, b), normal).recip();
        let (of_a, of_b) = (dot(cross(r, b), normal) * inverse, dot(cross(a, r), normal) * inverse);
        // The triangle that contains the point, or else the one that it misses by the smallest area coordinate.
        let within = of_a.re().min(of_b.re());
        if within > least {
            (least, triangle) = (within, k);
            shares = std::array::from_fn(|node| if node < count { (-of_a - of_b + 1.0) * part } else { zero });
            shares[k] += of_a;
            shares[next] += of_b;
        }
    }
    (triangle, shares)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 300, rng_seed: RngSeed::Fixed(2007), failure_persistence: None, ..Default::default() })]

        #[test]
        fn gradients_agree_with_differences(noise in prop::collection::vec(-0.25..0.25f64, 15)) {
            let facet = [[0.4, 0.5, 0.3], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
            let edges = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, -0.5, 0.2], [0.5, 0.5, 0.2], [0.0; 3]];
            let form = [0.1, -0.05, 0.02, 0.2, 0.1, 0.15];
            let stretch = |profile: Profile, count: usize| profile.on_facet(&facet[1..=count]).stretch;
            let [of_four, of_three] = [stretch(Profile::new(&[0.0; 4], &[0.1, 0.0, 0.2, 0.0]), 4), stretch(Profile::of_form(form), 3)];
            let of_facets =
                [Measure::Facet(4), Measure::Facet(3), Measure::Over(Some(3), form, of_four), Measure::Over(None, form, of_three)];
            let of_facets = of_facets.map(|measure| (measure, facet));
            for (measure, base) in of_facets.into_iter().chain([(Measure::Edges(-1.0), edges)]) {
                let count = match measure { Measure::Facet(count) => count + 1, Measure::Over(Some(_), ..) => 5, _ => 4 };
                let z: Vec<Vec3<f64>> =
                    base[..count].iter().enumerate().map(|(k, x)| std::array::from_fn(|i| x[i] + noise[3 * k + i])).collect();
                let gradient = measure.gradient(&z);
                for k in 0..count {
                    for i in 0..3 {
                        let at = |step: f64| { let mut moved = z.clone(); moved[k][i] += step; measure.gap(&moved) };
                        let slope = (at(1e-5) - at(-1e-5)) / 2e-5;
                        prop_assert!((gradient[k][i] - slope).abs() < 1e-7, "{measure:?} {k} {i}: {} {slope}", gradient[k][i]);
                    }
                }
                let mut hessian = vec![0.0; 9 * count * count];
                measure.hessian_into(z.as_flattened(), 2.0, &mut hessian);
                for column in 0..3 * count {
                    let at = |step: f64| { let mut moved = z.clone(); moved[column / 3][column % 3] += step; measure.gradient(&moved) };
                    let (more, less) = (at(1e-5), at(-1e-5));
                    for row in 0..3 * count {
                        let slope = (more[row / 3][row % 3] - less[row / 3][row % 3]) / 1e-5;
                        let exact = hessian[3 * count * row + column];
                        prop_assert!((exact - slope).abs() < 1e-6 * (1.0 + slope.abs()), "{measure:?} {row} {column}: {exact} {slope}");
                    }
                }
            }
        }
    }

    #[test]
    fn feet_are_where_edges_cross() {
        let z = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.5, -1.0, 0.3], [0.5, 3.0, 0.3]];
        let ([s, t], sine) = Measure::feet(&z);
        assert!((s - 0.25).abs() < 1e-15 && (t - 0.25).abs() < 1e-15 && (sine - 1.0).abs() < 1e-15);
        assert!((Measure::Edges(1.0).gap(&z) - 0.3).abs() < 1e-15);
    }
}
