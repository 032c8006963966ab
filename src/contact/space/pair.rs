//! The weighted gap functions of one facet pair in space, with gradient and Hessian, as one continuous function of its six to eight nodes.
//!
//! Everything is seen along one direction: the normal `n` of the secondary facet, along `(x_3 - x_1) x (x_4 - x_2)`, through its mean
//! point. Nodes have plane coordinates `p` and heights `h`; a facet of four nodes is four flat triangles about its mean point, which has a
//! quarter of each node. Each primary triangle is clipped by each secondary one, and on the polygons
//!
//! ```text
//! Phi_A = sum int N_A (h_primary - h_secondary) dA          [length^3], > 0 when open
//! ```
//!
//! is integrated exactly: the integrand is a product of two affine functions (Puso and Laursen, CMAME 193, 2004, take an average plane and
//! quadrature instead; a value that depends on how a polygon is cut jumps where a vertex appears). The value is continuous everywhere, the
//! gradient where vertices come and go; it has kinks where edges of the two facets coincide.
//!
//! The gradient is that of a domain that moves: with `W = sum w_A N_A`, gap `g`, shape functions `N_j` and `M_m` of the triangles,
//!
//! ```text
//! d/dh_m =  int W M_m dA               d/dp_m = - grad h_primary   int W M_m dA                       + sum_edges nu int W g M_m ds
//! d/dh_j = -int W N_j dA               d/dp_j =   grad h_secondary int W N_j dA - grad W int g N_j dA + sum_edges nu int W g N_j ds
//! ```
//!
//! over the edges of the polygon that lie on the triangle's own border. Where edges of both triangles nearly coincide, these forces go from
//! one to the other gradually, so that the gradient that acts has no kink; a discrete gradient is exact whatever gradient it corrects.
//! Heights may have constants added (`bulge.rs`), which change gaps
//! and no derivatives of heights. The frame turns with the secondary facet: with the moment `m` of
//! these forces the turn of `n` adds `b = -m x n / |N|`, `d N.b`. All is generic in its numbers, so that one pass with derivatives gives
//! the Hessian.

use std::ops::Mul;

use super::bulge::Raised;
use super::polygon::{Bearer, Polygon, VERTICES, Vertex};
use super::vectors::{Frame, Vec3, cross, dot, scaled, sub};
use crate::contact::numbers::{Each, Number};
use crate::math::simd::{Kernel, dispatch};

/// Nodes of a facet, at most.
pub const CORNERS: usize = 4;

/// Nodes of a pair, at most.
pub const NODES: usize = 2 * CORNERS;

/// A pair as it is seen along the secondary normal.
pub struct Pair<T> {
    /// Nodes of the secondary and of the primary facet.
    counts: [usize; 2],
    /// Axes of the plane, and the normal.
    axes: [Vec3<T>; 3],
    /// Diagonals of the secondary facet, or two sides of a triangle, and the length of their product.
    diagonals: [Vec3<T>; 2],
    length: T,
    /// Positions from the mean point of the secondary facet.
    arms: [Vec3<T>; NODES],
    /// Plane coordinates and heights of the nodes, then of the mean points.
    p: [[T; 2]; NODES + 2],
    h: [T; NODES + 2],
    polygons: Vec<Polygon<T>>,
}

/// Corners of the triangles of a facet, whose nodes begin at `first` and whose mean point is at `middle`, in the list of points.
#[inline(always)]
fn triangles(count: usize, first: usize, middle: usize) -> impl Iterator<Item = [usize; 3]> {
    (0..if count == 3 { 1 } else { count })
        .map(move |k| if count == 3 { [first, first + 1, first + 2] } else { [first + k, first + (k + 1) % count, middle] })
}

impl<T: Number> Pair<T> {
    /// The pair at the positions of its nodes, secondary ones first; `counts` how many either facet has. Nothing where the secondary facet
    /// has no area.
    #[inline(always)]
    pub fn new(x: &[Vec3<T>], counts: [usize; 2]) -> Option<Self> {
        let [own, other] = counts;
        let Frame { axes, diagonals, length } = Frame::new(&x[..own])?;
        let normal = axes[2];
        let zero = T::from(0.0);
        let mut middle = [zero; 3];
        x[..own].iter().for_each(|x| (0..3).for_each(|i| middle[i] += x[i] * (1.0 / own as f64)));
        let mut pair = Pair {
            counts,
            axes,
            diagonals,
            length,
            arms: [[zero; 3]; NODES],
            p: [[zero; 2]; NODES + 2],
            h: [zero; NODES + 2],
            polygons: Vec::new(),
        };
        for (k, x) in x.iter().enumerate() {
            let arm = sub(*x, middle);
            pair.arms[k] = arm;
            pair.p[k] = [dot(arm, axes[0]), dot(arm, axes[1])];
            pair.h[k] = dot(arm, normal);
        }
        for (place, range) in [(NODES, 0..own), (NODES + 1, own..own + other)] {
            let share = 1.0 / range.len() as f64;
            for k in range {
                let (p, h) = (pair.p[k], pair.h[k]);
                (0..2).for_each(|i| pair.p[place][i] += p[i] * share);
                pair.h[place] += h * share;
            }
        }
        pair.cut();
        Some(pair)
    }

    /// The pair between surfaces that lie above the facets by so much.
    #[inline(always)]
    pub fn raised(mut self, sides: [&Raised; 2]) -> Self {
        let [own, other] = self.counts;
        // Outwards is up on the secondary side and down on the other one.
        for (raised, first, count, middle, up) in [(sides[0], 0, own, NODES, 1.0), (sides[1], own, other, NODES + 1, -1.0)] {
            for (k, raised) in raised[..count].iter().enumerate() {
                self.h[first + k] += T::from(up * raised);
                self.h[middle] += T::from(up * raised / count as f64);
            }
            self.h[middle] += T::from(up * raised[CORNERS]);
        }
        self
    }

    /// Finds the polygons.
    #[inline(always)]
    fn cut(&mut self) {
        let [own, other] = self.counts;
        for secondary in triangles(own, 0, NODES) {
            for [a, b, c] in triangles(other, own, NODES + 1) {
                // The other facet looks the other way.
                let primary = [b, a, c];
                if self.are_boxes_apart(secondary, primary) {
                    continue;
                }
                let places = [secondary, primary].map(|corners| corners.map(|k| &self.p[k]));
                self.polygons.extend(Polygon::new([secondary, primary], places));
            }
        }
    }

    #[inline(always)]
    fn are_boxes_apart(&self, secondary: [usize; 3], primary: [usize; 3]) -> bool {
        (0..2).any(|axis| {
            let range = |of: [usize; 3]| {
                let at = of.map(|k| self.p[k][axis].re());
                (at[0].min(at[1]).min(at[2]), at[0].max(at[1]).max(at[2]))
            };
            let (own, other) = (range(secondary), range(primary));
            own.0 >= other.1 || other.0 >= own.1
        })
    }

    /// Whether the facets are opposite each other anywhere.
    pub fn overlaps(&self) -> bool {
        !self.polygons.is_empty()
    }

    /// The part of a point's value that a node of its facet has.
    #[inline(always)]
    fn shares(&self, point: usize) -> (std::ops::Range<usize>, f64) {
        let [own, other] = self.counts;
        match point {
            NODES => (0..own, 1.0 / own as f64),
            _ if point == NODES + 1 => (own..own + other, 1.0 / other as f64),
            _ => (point..point + 1, 1.0),
        }
    }

    /// Values of the weight `sum w_A N_A` at the corners of a secondary triangle.
    #[inline(always)]
    fn weights<W: Number>(&self, secondary: [usize; 3], weights: &[W; CORNERS]) -> [W; 3] {
        secondary.map(|point| {
            let (nodes, share) = self.shares(point);
            nodes.fold(W::from(0.0), |sum, node| sum + weights[node] * share)
        })
    }

    /// Gap at a corner of a polygon.
    #[inline(always)]
    fn gap(&self, polygon: &Polygon<T>, vertex: &Vertex<T>) -> T {
        self.height(polygon.primary, &vertex.of_primary) - self.height(polygon.secondary, &vertex.of_secondary)
    }

    /// Height of a triangle at a point with these shape functions.
    #[inline(always)]
    fn height(&self, corners: [usize; 3], shape: &[T; 3]) -> T {
        self.h[corners[0]] * shape[0] + self.h[corners[1]] * shape[1] + self.h[corners[2]] * shape[2]
    }

    /// `Phi_A` of the secondary nodes.
    pub fn values(&self) -> [T; CORNERS] {
        let mut values = [T::from(0.0); CORNERS];
        for polygon in &self.polygons {
            let gaps: Vec<T> = polygon.vertices.iter().map(|vertex| self.gap(polygon, vertex)).collect();
            for j in 0..3 {
                let integral = polygon.integral(|k| &polygon.vertices[k].of_secondary[j], |k| &gaps[k]);
                let (nodes, share) = self.shares(polygon.secondary[j]);
                nodes.for_each(|node| values[node] += integral * share);
            }
        }
        values
    }

    /// What is covered of each secondary node, `int N_A dA` over the overlap `[length^2]`.
    pub fn covered(&self) -> [f64; CORNERS] {
        let (mut covered, one) = ([0.0; CORNERS], T::from(1.0));
        for polygon in &self.polygons {
            for j in 0..3 {
                let integral = polygon.integral(|k| &polygon.vertices[k].of_secondary[j], |_| &one).re();
                let (nodes, share) = self.shares(polygon.secondary[j]);
                nodes.for_each(|node| covered[node] += integral * share);
            }
        }
        covered
    }

    /// Largest distance of the facets, on either side, along the normal.
    pub fn farthest(&self) -> f64 {
        let gaps = |polygon: &Polygon<T>| {
            polygon.vertices.iter().fold(0.0, |largest: f64, vertex| largest.max(self.gap(polygon, vertex).re().abs()))
        };
        self.polygons.iter().map(gaps).fold(0.0, f64::max)
    }

    /// Axes of the secondary facet.
    pub fn axes(&self) -> [Vec3<T>; 3] {
        self.axes
    }

    /// Mortar weights of the secondary nodes: `int N_A N_B dA` of secondary nodes, `-int N_A M_C dA` of primary ones, over the overlap.
    pub fn mortar_weights(&self) -> [[T; NODES]; CORNERS] {
        let mut weights = [[T::from(0.0); NODES]; CORNERS];
        for polygon in &self.polygons {
            let own = |k: usize, j: usize| &polygon.vertices[k].of_secondary[j];
            let other = |k: usize, j: usize| &polygon.vertices[k].of_primary[j];
            for a in 0..3 {
                for b in 0..3 {
                    let on_own = polygon.integral(|k| own(k, a), |k| own(k, b));
                    let on_other = polygon.integral(|k| own(k, a), |k| other(k, b));
                    let (rows, share) = self.shares(polygon.secondary[a]);
                    for (integral, point) in [(on_own, polygon.secondary[b]), (-on_other, polygon.primary[b])] {
                        let (nodes, part) = self.shares(point);
                        for row in rows.clone() {
                            nodes.clone().for_each(|node| weights[row][node] += integral * (share * part));
                        }
                    }
                }
            }
        }
        weights
    }

    /// Gradient of `sum w_A Phi_A` with respect to the positions of the nodes, in which forces on edges that nearly coincide pass from one
    /// facet to the other within a band, see [`Polygon::bearers`]; with none it is that of the function, kinks included.
    #[inline(always)]
    pub fn gradient<W: Number>(&self, weights: &[W; CORNERS], band: f64) -> [Vec3<T>; NODES]
    where
        T: Mul<W, Output = T>,
    {
        let zero = T::from(0.0);
        let (mut of_p, mut of_h) = ([[zero; 2]; NODES + 2], [zero; NODES + 2]);
        for polygon in &self.polygons {
            self.add_polygon(polygon, band, self.weights(polygon.secondary, weights), &mut of_p, &mut of_h);
        }
        for (place, point) in [NODES, NODES + 1].into_iter().enumerate() {
            let (nodes, share) = self.shares(NODES + place);
            for node in nodes {
                let (p, h) = (of_p[point], of_h[point]);
                (0..2).for_each(|i| of_p[node][i] += p[i] * share);
                of_h[node] += h * share;
            }
        }
        let [first, second, normal] = self.axes;
        let count = self.counts[0] + self.counts[1];
        let (mut gradient, mut moment) = ([[zero; 3]; NODES], [zero; 3]);
        for k in 0..count {
            gradient[k] = std::array::from_fn(|i| first[i] * of_p[k][0] + second[i] * of_p[k][1] + normal[i] * of_h[k]);
            let turn = cross(self.arms[k], gradient[k]);
            (0..3).for_each(|i| moment[i] += turn[i]);
        }
        let tilt = scaled(cross(normal, moment), self.length.recip());
        let [c, d] = self.diagonals;
        // d N.b = dc.(d x b) + dd.(b x c)
        let (of_c, of_d) = (cross(d, tilt), cross(tilt, c));
        let ends = if self.counts[0] == 3 { [(1, 0), (2, 0)] } else { [(2, 0), (3, 1)] };
        for ((to, from), force) in ends.into_iter().zip([of_c, of_d]) {
            for i in 0..3 {
                gradient[to][i] += force[i];
                gradient[from][i] -= force[i];
            }
        }
        gradient
    }

    /// Adds what one polygon gives to the derivatives with respect to plane coordinates and heights; `weights` at the corners of the
    /// secondary triangle.
    #[inline(always)]
    fn add_polygon<W: Number>(
        &self,
        polygon: &Polygon<T>,
        band: f64,
        weights: [W; 3],
        of_p: &mut [[T; 2]; NODES + 2],
        of_h: &mut [T; NODES + 2],
    ) where
        T: Mul<W, Output = T>,
    {
        let zero = T::from(0.0);
        let (mut weight, mut gap) = ([zero; VERTICES], [zero; VERTICES]);
        for (k, vertex) in polygon.vertices.iter().enumerate() {
            let shape = vertex.of_secondary;
            weight[k] = shape[0] * weights[0] + shape[1] * weights[1] + shape[2] * weights[2];
            gap[k] = self.gap(polygon, vertex);
        }
        let slopes = [polygon.secondary, polygon.primary].map(|corners| {
            // grad N_j = the opposite side turned by a quarter over twice the area.
            let [a, b, c] = corners.map(|k| self.p[k]);
            [sub(c, b), sub(a, c), sub(b, a)]
        });
        let inverse = polygon.areas.map(T::recip);
        let slope = |side: usize, sum: &dyn Fn(usize) -> T| -> [T; 2] { [-sum(1) * inverse[side], sum(0) * inverse[side]] };
        let sides = &slopes[0];
        let of_weight = slope(0, &|i| sides[0][i] * weights[0] + sides[1][i] * weights[1] + sides[2][i] * weights[2]);
        let rise = |side: usize, [a, b, c]: [usize; 3]| {
            let sides = &slopes[side];
            slope(side, &|i| sides[0][i] * self.h[a] + sides[1][i] * self.h[b] + sides[2][i] * self.h[c])
        };
        let rises = [rise(0, polygon.secondary), rise(1, polygon.primary)];
        for j in 0..3 {
            let (own, other) = (polygon.secondary[j], polygon.primary[j]);
            let on_own = polygon.integral(|k| &weight[k], |k| &polygon.vertices[k].of_secondary[j]);
            let on_other = polygon.integral(|k| &weight[k], |k| &polygon.vertices[k].of_primary[j]);
            let open = polygon.integral(|k| &gap[k], |k| &polygon.vertices[k].of_secondary[j]);
            of_h[own] -= on_own;
            of_h[other] += on_other;
            for i in 0..2 {
                of_p[own][i] += rises[0][i] * on_own - of_weight[i] * open;
                of_p[other][i] -= rises[1][i] * on_other;
            }
        }
        for k in 0..polygon.vertices.len() {
            let next = (k + 1) % polygon.vertices.len();
            let (a, b) = (&polygon.vertices[k], &polygon.vertices[next]);
            let outward = [b.p[1] - a.p[1], a.p[0] - b.p[0]];
            // Integrals of W g f over the edge for an affine f: one share for its value at either end.
            let (aa, bb) = (weight[k] * gap[k], weight[next] * gap[next]);
            let ab = weight[k] * gap[next] + weight[next] * gap[k];
            let (first, last) = ((aa * 3.0 + ab + bb) * (1.0 / 12.0), (aa + ab + bb * 3.0) * (1.0 / 12.0));
            for Bearer { share, corners, at } in polygon.bearers([k, next], band).into_iter().flatten() {
                for j in 0..3 {
                    let whole = first * at[0][j] + last * at[1][j];
                    let moved = share.map_or(whole, |share| whole * share);
                    (0..2).for_each(|i| of_p[corners[j]][i] += outward[i] * moved);
                }
            }
        }
    }
}

/// Gradients of the `Phi_A` of all secondary nodes, which are computed together.
pub type Gradients = [Vec3<Each<CORNERS>>; NODES];

impl Pair<f64> {
    /// The gradients of the functions, with this band: see [`Pair::gradient`].
    pub fn gradients(&self, band: f64) -> Gradients {
        dispatch(OfEach { pair: self, band })
    }

    /// The same pair for each secondary node.
    #[inline(always)]
    fn each(&self) -> Pair<Each<CORNERS>> {
        let flat = |p: [f64; 2]| p.map(Each::from);
        let vector = |x: Vec3<f64>| x.map(Each::from);
        let vertex = |v: &Vertex<f64>| Vertex {
            p: flat(v.p),
            of_secondary: vector(v.of_secondary),
            of_primary: vector(v.of_primary),
            border: v.border,
            fan: v.fan.into(),
        };
        let polygon = |of: &Polygon<f64>| Polygon {
            secondary: of.secondary,
            primary: of.primary,
            areas: flat(of.areas),
            vertices: of.vertices.iter().map(vertex).collect(),
        };
        Pair {
            counts: self.counts,
            axes: self.axes.map(vector),
            diagonals: self.diagonals.map(vector),
            length: self.length.into(),
            arms: self.arms.map(vector),
            p: self.p.map(flat),
            h: self.h.map(Each::from),
            polygons: self.polygons.iter().map(polygon).collect(),
        }
    }
}

/// The gradients of a pair's functions, with the instructions that the processor has.
struct OfEach<'a> {
    pair: &'a Pair<f64>,
    band: f64,
}

impl Kernel for OfEach<'_> {
    type Output = Gradients;

    #[inline(always)]
    fn run<const FMA: bool>(self) -> Gradients {
        let weights = std::array::from_fn(|row| Each(std::array::from_fn(|lane| if lane == row { 1.0 } else { 0.0 })));
        self.pair.each().gradient(&weights, self.band)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::*;
    use crate::math::tolerances::EDGES_MEET;

    /// Two facets of three or four nodes that face each other, warped, tilted and off each other at random.
    fn nodes(counts: [usize; 2]) -> impl Strategy<Value = Vec<Vec3<f64>>> {
        let noise = prop::collection::vec(-0.2..0.2f64, 3 * (counts[0] + counts[1]));
        (noise, -0.8..0.8f64, -0.8..0.8f64).prop_map(move |(noise, x, y)| {
            let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            let own = square[..counts[0]].iter().map(|&[x, y]| [x, y, 0.0]);
            let other = (0..counts[1]).map(|k| square[counts[1] - 1 - k]).map(|[a, b]| [a + x, b + y, 0.1]);
            own.chain(other).enumerate().map(|(k, at)| std::array::from_fn(|i| at[i] + noise[3 * k + i])).collect()
        })
    }

    fn values(x: &[Vec3<f64>], counts: [usize; 2]) -> [f64; CORNERS] {
        Pair::new(x, counts).map_or([0.0; CORNERS], |pair| pair.values())
    }

    /// Gradient of the weighted sum of the functions, kinks included.
    fn gradient(pair: &Pair<f64>, weights: &[f64; CORNERS]) -> [Vec3<f64>; NODES] {
        let of_each = |each: Each<CORNERS>| each.0.iter().zip(weights).map(|(slope, weight)| slope * weight).sum();
        pair.gradients(0.0).map(|node| node.map(of_each))
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 500, rng_seed: RngSeed::Fixed(2007), failure_persistence: None, ..Default::default() })]

        #[test]
        fn gradients_agree_with_differences(
            (counts, x) in prop::sample::select(vec![[4, 4], [4, 3], [3, 4], [3, 3]])
                .prop_flat_map(|counts| nodes(counts).prop_map(move |x| (counts, x))),
        ) {
            let pair = Pair::new(&x, counts).expect("facets have areas");
            for row in 0..counts[0] {
                let mut weights = [0.0; CORNERS];
                weights[row] = 1.0;
                let gradient = gradient(&pair, &weights);
                for node in 0..counts[0] + counts[1] {
                    for i in 0..3 {
                        let at = |step: f64| {
                            let mut moved = x.clone();
                            moved[node][i] += step;
                            values(&moved, counts)[row]
                        };
                        let [fine, coarse] = [1e-5, 2e-5].map(|step| (at(step) - at(-step)) / (2.0 * step));
                        // At a kink differences of different widths disagree.
                        if (fine - coarse).abs() < 1e-7 {
                            prop_assert!((gradient[node][i] - fine).abs() < 1e-6, "{node} {i}: {} {fine}", gradient[node][i]);
                        }
                    }
                }
            }
        }

        /// Invariant: no resultant and no moment, the same value after a rigid motion, and after renumbering a facet.
        #[test]
        fn values_do_not_change_with_rigid_motions(x in nodes([4, 4]), angles in prop::array::uniform3(-3.0..3.0f64)) {
            let counts = [4, 4];
            let before = values(&x, counts);
            let rotation = nalgebra::Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
            let turned: Vec<Vec3<f64>> = x.iter().map(|x| (rotation * nalgebra::Vector3::from(*x)).add_scalar(3.0).into()).collect();
            for (a, b) in before.iter().zip(values(&turned, counts)) {
                prop_assert!((a - b).abs() < 1e-14, "{a} {b}");
            }
            let order = [1, 2, 3, 0, 6, 7, 4, 5];
            let renumbered: Vec<Vec3<f64>> = order.iter().map(|&k| x[k]).collect();
            let after = values(&renumbered, counts);
            for (k, a) in before.iter().enumerate() {
                prop_assert!((a - after[(k + 3) % 4]).abs() < 1e-14);
            }
            let (pair, weights) = (Pair::new(&x, counts).expect("it has an area"), [1.0, -0.5, 2.0, 0.25]);
            for gradient in [gradient(&pair, &weights), pair.gradient(&weights, EDGES_MEET)] {
                let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
                for (x, g) in x.iter().zip(gradient) {
                    (0..3).for_each(|i| force[i] += g[i]);
                    let turn = cross(*x, g);
                    (0..3).for_each(|i| moment[i] += turn[i]);
                }
                prop_assert!(force.iter().chain(&moment).all(|sum| sum.abs() < 1e-14), "{force:?} {moment:?}");
            }
        }

        /// The gradient that acts is continuous where edges coincide, as steep as its band is narrow, and that of the function elsewhere.
        #[test]
        fn the_gradient_that_acts_has_no_kink(
            noise in prop::collection::vec(-1.0..1.0f64, 24),
            shift in prop::sample::select(vec![0.0, 0.25]),
        ) {
            let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            let at = |size: f64| -> [[Vec3<f64>; NODES]; 2] {
                let own = square.iter().map(|&[x, y]| [x, y, 0.0]);
                let other = square.iter().rev().map(|&[x, y]| [x + shift, y + shift, 0.3]);
                let x: Vec<Vec3<f64>> =
                    own.chain(other).enumerate().map(|(k, x)| std::array::from_fn(|i| x[i] + size * noise[3 * k + i])).collect();
                let pair = Pair::new(&x, [4, 4]).expect("it has an area");
                [gradient(&pair, &[1.0; CORNERS]), pair.gradient(&[1.0; CORNERS], EDGES_MEET)]
            };
            let apart = |a: &[Vec3<f64>; NODES], b: &[Vec3<f64>; NODES]| {
                a.as_flattened().iter().zip(b.as_flattened()).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
            };
            let [_, there] = at(0.0);
            for size in [1e-4, 1e-6, 1e-8] {
                let [exact, smooth] = at(size);
                prop_assert!(apart(&smooth, &there) < 10.0 * size / EDGES_MEET, "{size:e}: {}", apart(&smooth, &there));
                prop_assert!(shift > 0.0 || apart(&exact, &smooth) > 1e-3, "they differ where edges coincide");
            }
        }

        /// The value is continuous along lines through configurations whose edges coincide.
        #[test]
        fn values_are_continuous_where_edges_coincide(
            noise in prop::collection::vec(-1.0..1.0f64, 24),
            shift in prop::sample::select(vec![0.0, 0.5, 1.0]),
        ) {
            let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            let at = |size: f64| -> [f64; CORNERS] {
                let own = square.iter().map(|&[x, y]| [x, y, 0.0]);
                let other = square.iter().rev().map(|&[x, y]| [x + shift, y, 0.3]);
                let x: Vec<Vec3<f64>> =
                    own.chain(other).enumerate().map(|(k, x)| std::array::from_fn(|i| x[i] + size * noise[3 * k + i])).collect();
                values(&x, [4, 4])
            };
            let there = at(0.0);
            for size in [1e-2, 1e-4, 1e-6, 1e-8] {
                for (a, b) in at(size).iter().zip(there) {
                    prop_assert!((a - b).abs() < 10.0 * size, "{size:e}: {a} {b}");
                }
            }
        }
    }

    /// Closed form: two equal squares half off each other, a constant gap: the weights of the published overlap.
    #[test]
    fn weights_of_two_faces_that_overlap_by_a_quarter() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let own = square.iter().map(|&[x, y]| [x, y, 0.0]);
        let other = square.iter().rev().map(|&[x, y]| [x, y, 0.25]);
        let x: Vec<Vec3<f64>> = own.chain(other).collect();
        let pair = Pair::new(&x, [4, 4]).expect("it has an area");
        for (value, covered) in pair.values().into_iter().zip(pair.covered()) {
            assert!((value - 0.0625).abs() < 1e-15 && (covered - 0.25).abs() < 1e-15);
        }
        let away: Vec<Vec3<f64>> = x.iter().enumerate().map(|(k, x)| if k < 4 { *x } else { [x[0] + 2.0, x[1], x[2]] }).collect();
        assert!(!Pair::new(&away, [4, 4]).expect("it has an area").overlaps());
        // Facets that look the same way have nothing between them.
        let same: Vec<Vec3<f64>> = [0, 1, 2, 3, 7, 6, 5, 4].iter().map(|&k| x[k]).collect();
        assert!(!Pair::new(&same, [4, 4]).expect("it has an area").overlaps());
    }
}
