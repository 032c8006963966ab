//! Weighted gaps of one facet pair in space as continuous functions of its six to eight nodes, with gradient and Hessian.
//!
//! Both facets are projected along the normal `n` of the secondary facet, parallel to `(x_3 - x_1) x (x_4 - x_2)`, on the plane through its
//! mean point. Nodes have plane coordinates `p` and heights `h`; a facet of four nodes consists of four flat triangles about its mean
//! point, a quarter of each node. Each primary triangle is clipped by each secondary one, and over the polygons (`polygon.rs`)
//!
//! ```text
//! Phi_A = sum int N_A (h_primary - h_secondary) dA          [length^3], > 0 when open
//! ```
//!
//! is integrated exactly: the integrand is a product of two affine functions. (Puso and Laursen, CMAME 193, 2004, use an average plane and
//! quadrature; a value that depends on the subdivision of a polygon jumps where a vertex appears.) The value is continuous everywhere, the
//! gradient also where vertices appear and vanish; it has kinks where edges of both facets coincide.
//!
//! Height profiles of facets (`profiles.rs`) close a part of the gap (`closing.rs`) and follow the stretches of the facets (`stretch.rs`).
//! The projection rotates with the secondary facet: with the moment `m` of the derivatives with respect to plane coordinates and heights,
//! taken as forces, the rotation of `n` adds `d N.b`, `b = -m x n / |N|`.
//!
//! `stiffness.rs` has the Hessian.

use super::clipping::VERTICES;
use super::curve_slip::{DifferentiatedNormalTerms, NormalTerms, NormalWeights};
use super::facet_profile::Profile;
use super::polygon::Polygon;
use super::products::Products;
use super::stiffness::Hessian;
use super::vectors::Vec3;
use super::vertices::{CORNERS, Forces, NODES, OfNodes};
use super::view::{Curves, POINTS, View, are_apart, triangles};
use super::weights::MortarWeights;
use crate::contact::numbers::{Each, Number};
use crate::math::simd::{Kernel, dispatch};

/// Facet pair, projected along the secondary normal.
pub struct Pair<T> {
    view: View<T>,
    polygons: Vec<Polygon<T>>,
}

impl<T: Number> Pair<T> {
    /// Pair at the positions of its nodes, secondary ones first; `counts` are the numbers of nodes of both facets. `None` if the secondary
    /// facet has no area.
    #[inline(always)]
    pub fn new(x: &[Vec3<T>], counts: [usize; 2]) -> Option<Self> {
        let (view, mut polygons, [own, other]) = (View::new(x, counts)?, Vec::new(), counts);
        if are_apart(&view.bounds(0..own), &view.bounds(own..own + other)) {
            return Some(Pair { view, polygons });
        }
        polygons.reserve(own * other);
        let mut polygon = Polygon::empty();
        let (mut primary, mut count) = ([([0; 3], [(0.0, 0.0); 2]); CORNERS], 0);
        for [a, b, c] in triangles(other, own, NODES + 1) {
            // Projected primary triangles have the opposite orientation, so that two corners are exchanged.
            primary[count] = ([b, a, c], view.bounds([b, a, c].into_iter()));
            count += 1;
        }
        for secondary in triangles(own, 0, NODES) {
            let bounds = view.bounds(secondary.into_iter());
            for (triangle, others) in &primary[..count] {
                let corners = [secondary, *triangle];
                if !are_apart(&bounds, others) && polygon.set(corners, &view.places(&corners)) {
                    polygons.push(polygon.clone());
                }
            }
        }
        Some(Pair { view, polygons })
    }

    /// True if the projected facets overlap.
    pub fn overlaps(&self) -> bool {
        !self.polygons.is_empty()
    }

    /// Plane axes and normal of the secondary facet.
    pub fn axes(&self) -> [Vec3<T>; 3] {
        self.view.frame.axes
    }

    /// Covered area of each secondary node, `int N_A dA` over the overlap `[length^2]`.
    pub fn covered(&self) -> [f64; CORNERS] {
        let mut covered = [0.0; CORNERS];
        for polygon in &self.polygons {
            let integrals = polygon.integrals(&polygon.counting(&[T::from(1.0); VERTICES]), 0);
            for (integral, point) in integrals.into_iter().zip(polygon.corners[0]) {
                let (nodes, share) = self.view.shares(point);
                nodes.for_each(|node| covered[node] += integral.re() * share);
            }
        }
        covered
    }

    /// Mortar integrals over the overlap for each secondary node: `int N_A N_B dA` of secondary nodes, `-int N_A M_C dA` of primary ones.
    pub fn mortar_weights(&self) -> [[T; NODES]; CORNERS] {
        let mut weights = [[T::from(0.0); NODES]; CORNERS];
        for polygon in &self.polygons {
            for a in 0..3 {
                let mut own = [T::from(0.0); VERTICES];
                own.iter_mut().zip(polygon.vertices()).for_each(|(own, vertex)| *own = vertex.of_secondary[a]);
                let counts = polygon.counting(&own);
                let (rows, share) = self.view.shares(polygon.corners[0][a]);
                for (side, sign) in [(0, 1.0), (1, -1.0)] {
                    for (integral, point) in polygon.integrals(&counts, side).into_iter().zip(polygon.corners[side]) {
                        let (nodes, part) = self.view.shares(point);
                        for row in rows.clone() {
                            nodes.clone().for_each(|node| weights[row][node] += integral * (sign * share * part));
                        }
                    }
                }
            }
        }
        weights
    }
}

/// Gradients of all weighted gaps of a pair, computed simultaneously.
pub type Gradients = [Vec3<Each<CORNERS>>; NODES];

impl Pair<f64> {
    /// Pair at the positions of its nodes, compiled for the instruction set of the processor, see [`Pair::new`].
    pub fn at(x: &[Vec3<f64>], counts: [usize; 2]) -> Option<Self> {
        dispatch(Overlap { x, counts })
    }

    /// Adds the height profiles of both facets.
    #[inline(always)]
    pub fn curved(mut self, profiles: [&Profile; 2]) -> Self {
        if profiles.iter().any(|profile| !profile.is_flat()) {
            let (arms, [own, other]) = (&self.view.arms, self.view.counts);
            let [first, second] = [profiles[0].stretched(&arms[..own]), profiles[1].stretched(&arms[own..own + other])];
            let closed = (!profiles[1].is_flat()).then(|| profiles[1].closing());
            let of_nodes = profiles.map(|profile| profile.stretch);
            self.view.curves = Some(Curves { forms: [first.0, second.0], closed, of_nodes, stretches: [first.1, second.1] });
        }
        self
    }

    /// Weighted gaps `Phi_A` of the secondary nodes `[length^3]`.
    pub fn values(&self) -> [f64; CORNERS] {
        dispatch(Values(self))
    }

    #[inline(always)]
    fn sums(&self) -> [f64; CORNERS] {
        let mut values = [0.0; CORNERS];
        for polygon in &self.polygons {
            let (places, heights) = (self.view.places(&polygon.corners), self.view.heights(&polygon.corners));
            let mut integrals = polygon.integrals(&polygon.counting(&polygon.gaps(&heights)), 0);
            if let Some(curved) = self.view.curved(&polygon.corners) {
                let (closing, _) = polygon.closing(&places, &heights, curved);
                let closed = closing.closed(&Products::new(polygon.vertices()));
                for j in 0..3 {
                    integrals[j] -= closed[j];
                }
            }
            for j in 0..3 {
                let (nodes, share) = self.view.shares(polygon.corners[0][j]);
                for node in nodes {
                    values[node] += integrals[j] * share;
                }
            }
        }
        values
    }

    /// Largest absolute gap over the overlap.
    pub fn farthest(&self) -> f64 {
        let gaps = |polygon: &Polygon<f64>| polygon.gaps(&self.view.heights(&polygon.corners));
        self.polygons.iter().flat_map(gaps).fold(0.0, |largest, gap| largest.max(gap.abs()))
    }

    /// Gradient of `sum w_A Phi_A` with respect to the node positions, and [`Pair::values`]. Forces on nearly coinciding edges pass from
    /// one facet to the other within a band, as a fraction of a triangle's height. With band 0 it is the exact gradient, including its
    /// kinks.
    #[inline(always)]
    fn gradient<R: Number>(&self, weights: &[R; CORNERS], band: f64) -> ([Vec3<R>; NODES], [f64; CORNERS]) {
        let zero = R::from(0.0);
        let (mut of_p, mut of_h, mut values) = ([[zero; 2]; POINTS], [zero; POINTS], [0.0; CORNERS]);
        let mut of_stretches = [zero; 2];
        for polygon in &self.polygons {
            let corners = &polygon.corners;
            let (places, heights) = (self.view.places(corners), self.view.heights(corners));
            let weights = self.view.weights(corners[0], weights);
            // No closures, which would be compiled without the wide registers.
            let (mut closing, mut tilted) = (None, [[R::from(0.0); 3]; 3]);
            if let Some(curved) = self.view.curved(corners) {
                let (profiles, tilt) = polygon.closing(&places, &heights, curved);
                let moments = profiles.moments(&Products::new(polygon.vertices()), &weights);
                let tilting = profiles.tilting(&moments);
                tilted = tilt.forces(&tilting);
                of_stretches[0] -= profiles.secondary(&moments);
                of_stretches[1] -= tilt.closed(&tilting, 1);
                closing = Some((profiles, moments));
            }
            let mut forces: Forces<R> = polygon.forces(&places, &heights, &closing, &weights, band);
            for j in 0..3 {
                forces.of_p[1][j][0] += tilted[j][0];
                forces.of_p[1][j][1] += tilted[j][1];
                forces.of_h[1][j] += tilted[j][2];
            }
            for j in 0..3 {
                let (nodes, share) = self.view.shares(corners[0][j]);
                nodes.for_each(|node| values[node] += forces.open[j] * share);
            }
            for side in 0..2 {
                for j in 0..3 {
                    let (point, [x, y]) = (corners[side][j], forces.of_p[side][j]);
                    of_p[point][0] += x;
                    of_p[point][1] += y;
                    of_h[point] += forces.of_h[side][j];
                }
            }
        }
        for point in [NODES, NODES + 1] {
            let (nodes, share) = self.view.shares(point);
            let ([x, y], h) = (of_p[point], of_h[point]);
            for node in nodes {
                of_p[node][0] += x * share;
                of_p[node][1] += y * share;
                of_h[node] += h * share;
            }
        }
        let mut gradient = self.view.spread(&of_p, &of_h);
        if let Some(Curves { stretches, .. }) = &self.view.curves {
            for (side, (first, count)) in [(0, self.view.counts[0]), (self.view.counts[0], self.view.counts[1])].into_iter().enumerate() {
                for k in 0..count {
                    for i in 0..3 {
                        gradient[first + k][i] += of_stretches[side] * stretches[side].rises[k][i];
                    }
                }
            }
        }
        (gradient, values)
    }

    /// Gradients of all weighted gaps with a band of the width `band`, see [`Pair::gradient`], and the gaps.
    pub fn gradients(&self, band: f64) -> (Gradients, [f64; CORNERS]) {
        dispatch(OfEach { pair: self, band })
    }

    /// Mortar weights, see [`Pair::mortar_weights`], with their derivatives with respect to the node positions.
    pub fn differentiated_weights(&self) -> [[OfNodes; NODES]; CORNERS] {
        dispatch(MortarWeights { view: &self.view, polygons: &self.polygons })
    }

    /// Weights along the normal in the slips, see `curve_slip.rs`; `None` between flat facets.
    pub fn normal_weights(&self) -> Option<NormalWeights<f64>> {
        self.view.curves.is_some().then(|| dispatch(NormalTerms { view: &self.view, polygons: &self.polygons }))
    }

    /// [`Pair::normal_weights`] with their derivatives with respect to the node positions; `first` is the first plane axis with its
    /// derivatives.
    pub fn differentiated_normal_weights(&self, first: &Vec3<OfNodes>) -> Option<NormalWeights<OfNodes>> {
        let terms = || dispatch(DifferentiatedNormalTerms { view: &self.view, polygons: &self.polygons, first });
        self.view.curves.is_some().then(terms)
    }

    /// Writes `share` times the derivatives of [`Pair::gradient`], row-major over the unknowns of the nodes.
    pub fn hessian_into(&self, weights: &[f64; CORNERS], band: f64, share: f64, out: &mut [f64]) {
        dispatch(Hessian { view: &self.view, polygons: &self.polygons, weights, band, share, out });
    }
}

/// Computation of the overlap of a pair.
struct Overlap<'a> {
    x: &'a [Vec3<f64>],
    counts: [usize; 2],
}

impl Kernel for Overlap<'_> {
    type Output = Option<Pair<f64>>;

    #[inline(always)]
    fn run<const FMA: bool>(self) -> Option<Pair<f64>> {
        Pair::new(self.x, self.counts)
    }
}

/// Computation of the weighted gaps of a pair, compiled for the instruction set of the processor.
struct Values<'a>(&'a Pair<f64>);

impl Kernel for Values<'_> {
    type Output = [f64; CORNERS];

    #[inline(always)]
    fn run<const FMA: bool>(self) -> Self::Output {
        self.0.sums()
    }
}

/// Computation of the gradients of a pair, compiled for the instruction set of the processor.
struct OfEach<'a> {
    pair: &'a Pair<f64>,
    band: f64,
}

impl Kernel for OfEach<'_> {
    type Output = (Gradients, [f64; CORNERS]);

    #[inline(always)]
    fn run<const FMA: bool>(self) -> Self::Output {
        let weights = std::array::from_fn(|row| Each(std::array::from_fn(|lane| if lane == row { 1.0 } else { 0.0 })));
        self.pair.gradient(&weights, self.band)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::strategy::ValueTree;
    use proptest::test_runner::RngSeed;

    use super::super::vectors::{FacetFrame, cross, dot, jets};
    use super::*;
    use crate::math::tolerances::EDGES_MEET;

    /// Two facets of three or four nodes that face each other, randomly warped, tilted and displaced.
    fn nodes(counts: [usize; 2]) -> impl Strategy<Value = Vec<Vec3<f64>>> {
        let noise = prop::collection::vec(-0.2..0.2f64, 3 * (counts[0] + counts[1]));
        (noise, -0.8..0.8f64, -0.8..0.8f64).prop_map(move |(noise, x, y)| {
            let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            let own = square[..counts[0]].iter().map(|&[x, y]| [x, y, 0.0]);
            let other = (0..counts[1]).map(|k| square[counts[1] - 1 - k]).map(|[a, b]| [a + x, b + y, 0.1]);
            own.chain(other).enumerate().map(|(k, at)| std::array::from_fn(|i| at[i] + noise[3 * k + i])).collect()
        })
    }

    /// Height profiles of both facets, by kind: flat, convex, or hollow against convex.
    fn profiles(kind: usize, counts: [usize; 2]) -> [Profile; 2] {
        let made = |side: usize, by: f64| {
            let (corners, sagittas) = ([0.02, -0.01, 0.03, 0.0], [0.1, 0.02, 0.06, 0.04]);
            let of = |values: [f64; 4]| values.map(|value| by * value)[..counts[side]].to_vec();
            let square = [[0.0, 0.0, 0.0], [0.9, 0.1, 0.0], [1.0, 1.0, 0.0], [0.0, 0.8, 0.0]];
            Profile::new(&of(corners), &of(sagittas)).on_facet(&square[..counts[side]])
        };
        match kind {
            0 => Default::default(),
            1 => [made(0, 1.0), Profile::default()],
            _ => [made(0, 1.0), made(1, -0.8)],
        }
    }

    fn pair(x: &[Vec3<f64>], counts: [usize; 2], kind: usize) -> Pair<f64> {
        Pair::new(x, counts).expect("facets have areas").curved(profiles(kind, counts).each_ref())
    }

    fn values(x: &[Vec3<f64>], counts: [usize; 2], kind: usize) -> [f64; CORNERS] {
        Pair::new(x, counts).map_or([0.0; CORNERS], |pair| pair.curved(profiles(kind, counts).each_ref()).values())
    }

    /// Random direction in the space of all coordinates.
    fn direction() -> impl Strategy<Value = Vec<f64>> {
        prop::collection::vec(-1.0..1.0f64, 3 * NODES)
    }

    fn moved(x: &[Vec3<f64>], direction: &[f64], step: f64) -> Vec<Vec3<f64>> {
        x.iter().zip(direction.as_chunks::<3>().0).map(|(x, d)| std::array::from_fn(|i| x[i] + step * d[i])).collect()
    }

    fn kinds() -> impl Strategy<Value = usize> {
        prop::sample::select(vec![0, 1, 2])
    }

    /// Exact gradient of the weighted sum of the functions, including kinks.
    fn gradient(pair: &Pair<f64>, weights: &[f64; CORNERS]) -> [Vec3<f64>; NODES] {
        let of_each = |each: Each<CORNERS>| each.0.iter().zip(weights).map(|(slope, weight)| slope * weight).sum();
        let (gradients, values) = pair.gradients(0.0);
        assert_eq!(values, pair.values());
        gradients.map(|node| node.map(of_each))
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 500, rng_seed: RngSeed::Fixed(2007), failure_persistence: None, ..Default::default() })]

        #[test]
        fn gradients_agree_with_differences(
            (counts, x) in prop::sample::select(vec![[4, 4], [4, 3], [3, 4], [3, 3]])
                .prop_flat_map(|counts| nodes(counts).prop_map(move |x| (counts, x))),
            kind in kinds(),
            direction in direction(),
        ) {
            let pair = pair(&x, counts, kind);
            let at = |step: f64| values(&moved(&x, &direction, step), counts, kind);
            let [fine, coarse] = [1e-5, 2e-5].map(|step| {
                let (more, less) = (at(step), at(-step));
                [0, 1, 2, 3].map(|row| (more[row] - less[row]) / (2.0 * step))
            });
            for row in 0..counts[0] {
                let mut weights = [0.0; CORNERS];
                weights[row] = 1.0;
                let gradient = gradient(&pair, &weights);
                let along: f64 = gradient.as_flattened().iter().zip(&direction).take(3 * x.len()).map(|(g, d)| g * d).sum();
                // At kinks difference quotients of different widths disagree.
                if (fine[row] - coarse[row]).abs() < 1e-7 {
                    prop_assert!((along - fine[row]).abs() < 1e-6, "{row}: {along} {}", fine[row]);
                }
            }
        }

        #[test]
        fn hessians_agree_with_differences(
            (counts, x) in prop::sample::select(vec![[4, 4], [4, 3], [3, 4], [3, 3]])
                .prop_flat_map(|counts| nodes(counts).prop_map(move |x| (counts, x))),
            band in prop::sample::select(vec![0.0, EDGES_MEET, 0.3]),
            kind in kinds(),
            direction in direction(),
        ) {
            let weights = [1.0, -0.5, 2.0, 0.25];
            let (at, unknowns) = (|x: &[Vec3<f64>]| pair(x, counts, kind), 3 * x.len());
            let mut hessian = vec![0.0; unknowns * unknowns];
            at(&x).hessian_into(&weights, band, 2.0, &mut hessian);
            let gradient = |step: f64| at(&moved(&x, &direction, step)).gradient(&weights, band).0;
            let differences = [1e-5, 2e-5].map(|step| {
                let (more, less) = (gradient(step), gradient(-step));
                let slope = |(more, less): (&f64, &f64)| (more - less) / step;
                more.as_flattened().iter().zip(less.as_flattened()).map(slope).collect::<Vec<f64>>()
            });
            for (row, derivatives) in hessian.chunks_exact(unknowns).enumerate() {
                let [fine, coarse] = [differences[0][row], differences[1][row]];
                let along: f64 = derivatives.iter().zip(&direction).map(|(h, d)| h * d).sum();
                if (fine - coarse).abs() < 1e-6 {
                    prop_assert!((along - fine).abs() < 1e-5, "{row}: {along} {fine}");
                }
            }
        }

        /// Zero resultant and moment of the gradients; values are invariant under rigid motion and renumbering of a facet.
        #[test]
        fn values_do_not_change_with_rigid_motions(
            x in nodes([4, 4]),
            angles in prop::array::uniform3(-3.0..3.0f64),
            kind in kinds(),
        ) {
            let counts = [4, 4];
            let before = values(&x, counts, kind);
            let rotation = nalgebra::Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
            let turned: Vec<Vec3<f64>> = x.iter().map(|x| (rotation * nalgebra::Vector3::from(*x)).add_scalar(3.0).into()).collect();
            for (a, b) in before.iter().zip(values(&turned, counts, kind)) {
                prop_assert!((a - b).abs() < 1e-14, "{a} {b}");
            }
            let order = [1, 2, 3, 0, 6, 7, 4, 5];
            let renumbered: Vec<Vec3<f64>> = order.iter().map(|&k| x[k]).collect();
            let after = values(&renumbered, counts, 0);
            for (k, a) in values(&x, counts, 0).iter().enumerate() {
                prop_assert!((a - after[(k + 3) % 4]).abs() < 1e-14);
            }
            let (pair, weights) = (pair(&x, counts, kind), [1.0, -0.5, 2.0, 0.25]);
            for gradient in [gradient(&pair, &weights), pair.gradient(&weights, EDGES_MEET).0] {
                let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
                for (x, g) in x.iter().zip(gradient) {
                    (0..3).for_each(|i| force[i] += g[i]);
                    let turn = cross(*x, g);
                    (0..3).for_each(|i| moment[i] += turn[i]);
                }
                prop_assert!(force.iter().chain(&moment).all(|sum| sum.abs() < 1e-14), "{force:?} {moment:?}");
            }
        }

        /// With a band the gradient is continuous where edges coincide, its slope grows as the band becomes narrower, and it is exact
        /// elsewhere.
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
                [gradient(&pair, &[1.0; CORNERS]), pair.gradient(&[1.0; CORNERS], EDGES_MEET).0]
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

        /// The value is continuous along lines through configurations with coinciding edges.
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
                values(&x, [4, 4], 2)
            };
            let there = at(0.0);
            for size in [1e-2, 1e-4, 1e-6, 1e-8] {
                for (a, b) in at(size).iter().zip(there) {
                    prop_assert!((a - b).abs() < 10.0 * size, "{size:e}: {a} {b}");
                }
            }
        }
    }

    /// Closed form: a circle of radius 1 in one of radius 1.001 with different facets: the mean gap is 0.001 at any angle.
    #[test]
    fn concentric_cylinders_have_the_gap_of_their_radii() {
        let facet = |radius: f64, from: f64, to: f64| {
            let at = |angle: f64, z: f64| [radius * angle.cos(), radius * angle.sin(), z];
            [at(from, 0.0), at(to, 0.0), at(to, 1.0), at(from, 1.0)]
        };
        let profile = |radius: f64, width: f64, out: f64| {
            let segment = 0.375 * radius * (width - width.sin()) / (0.5 * width).sin() * out;
            Profile::new(&[0.0; 4], &[segment, 0.0, segment, 0.0])
        };
        for (inner, outer, tolerance) in [(7, 5, 0.02), (12, 10, 0.004), (24, 20, 0.001)] {
            let widths = [inner, outer].map(|count| std::f64::consts::FRAC_PI_2 / f64::from(count));
            let profiles = [profile(1.0, widths[0], 1.0), profile(1.001, widths[1], -1.0)];
            for shift in [0.0, 0.3, 0.7] {
                let (mut volume, mut area) = (0.0, 0.0);
                for k in -3..=3 {
                    let from = (shift + f64::from(k)) * widths[1];
                    let mut other = facet(1.001, from, from + widths[1]);
                    other.reverse();
                    let x: Vec<Vec3<f64>> = facet(1.0, 0.0, widths[0]).into_iter().chain(other).collect();
                    let pair = Pair::new(&x, [4, 4]).expect("it has an area").curved(profiles.each_ref());
                    volume += pair.values().iter().sum::<f64>();
                    area += pair.covered().iter().sum::<f64>();
                }
                let error = volume / area / 0.001 - 1.0;
                assert!(error.abs() < tolerance, "{inner}/{outer} at {shift}: {error}");
            }
        }
    }

    /// Closed form: two equal squares displaced by half, constant gap: weights of the published overlap.
    /// Derivatives of the weights against those of the same polygons from numbers that carry derivatives.
    #[test]
    fn weights_have_the_derivatives_of_the_clipped_polygons() {
        let mut runner = proptest::test_runner::TestRunner::deterministic();
        let mut overlaps = 0;
        for counts in [[4, 4], [3, 4], [4, 3], [3, 3]].repeat(20) {
            let x = nodes(counts).new_tree(&mut runner).unwrap().current();
            let Some(pair) = Pair::at(&x, counts).filter(Pair::overlaps) else { continue };
            overlaps += 1;
            let jets = Pair::new(&jets::<24>(x.as_flattened(), 0), counts).unwrap().mortar_weights();
            for (own, other) in pair.differentiated_weights().as_flattened().iter().zip(jets.as_flattened()) {
                assert!((own.re - other.re).abs() < 1e-14);
                assert!(own.eps.iter().zip(&other.eps).all(|(a, b)| (a - b).abs() < 1e-12 * (1.0 + b.abs())), "{own:?} {other:?}");
            }
        }
        assert!(overlaps > 40);
        // Squares with two coinciding edges, or all four: corners move with the sides that define them.
        for shift in [0.0, 0.25] {
            let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            let own = square.iter().map(|&[x, y]| [x, y, 0.0]);
            let other = square.iter().rev().map(|&[x, y]| [x + shift, y, 0.125]);
            let x: Vec<Vec3<f64>> = own.chain(other).collect();
            let pair = Pair::at(&x, [4, 4]).unwrap();
            let jets = Pair::new(&jets::<24>(x.as_flattened(), 0), [4, 4]).unwrap().mortar_weights();
            for (own, other) in pair.differentiated_weights().as_flattened().iter().zip(jets.as_flattened()) {
                assert!((own.re - other.re).abs() < 1e-14);
                assert!(own.eps.iter().zip(&other.eps).all(|(a, b)| (a - b).abs() < 1e-12), "{shift}: {own:?} {other:?}");
            }
        }
    }

    /// Weights along the normal have zero sum, and their derivatives are those of their difference quotients.
    #[test]
    fn normal_weights_agree_with_differences() {
        let mut runner = proptest::test_runner::TestRunner::deterministic();
        let (mut overlaps, mut smooth) = (0, 0);
        for (counts, kind) in [[4, 4], [3, 4], [4, 3], [3, 3]].repeat(20).into_iter().zip([1, 2, 2].into_iter().cycle()) {
            let x = nodes(counts).new_tree(&mut runner).unwrap().current();
            let direction: Vec<f64> = (0..3 * x.len()).map(|k| (1.7 * k as f64 + 0.4).sin()).collect();
            let plain = |h: f64| {
                let moved: Vec<Vec3<f64>> =
                    x.iter().enumerate().map(|(k, x)| std::array::from_fn(|i| x[i] + h * direction[3 * k + i])).collect();
                pair(&moved, counts, kind).normal_weights().expect("facets are curved")
            };
            let at = pair(&x, counts, kind);
            if !at.overlaps() {
                continue;
            }
            overlaps += 1;
            let frame = FacetFrame::new(&jets::<24>(x[..counts[0]].as_flattened(), 0)).unwrap();
            let weights = at.differentiated_normal_weights(&frame.axes[0]).unwrap();
            let quotient = |h: f64| {
                let (above, below) = (plain(h), plain(-h));
                let parts = above.as_flattened().as_flattened().iter().zip(below.as_flattened().as_flattened());
                parts.map(|(a, b)| (a - b) / (2.0 * h)).collect::<Vec<f64>>()
            };
            let (fine, coarse) = (quotient(1e-5), quotient(2e-5));
            let values = plain(0.0);
            for (k, (own, value)) in weights.as_flattened().as_flattened().iter().zip(values.as_flattened().as_flattened()).enumerate() {
                assert!((own.re - value).abs() < 1e-15);
                let slope = own.eps.iter().zip(&direction).map(|(a, b)| a * b).sum::<f64>();
                // Differences across a kink, where edges coincide, depend on their width.
                if (fine[k] - coarse[k]).abs() < 1e-8 {
                    smooth += 1;
                    assert!((slope - fine[k]).abs() < 1e-6, "{counts:?} {kind}: {slope} {}", fine[k]);
                }
            }
            for list in values.as_flattened() {
                assert!(list.iter().sum::<f64>().abs() < 1e-15, "{list:?}");
            }
        }
        assert!(overlaps > 40 && smooth > 50 * overlaps, "{overlaps} {smooth}");
    }

    /// Concentric cylinders that turn against each other slide by the angle times the radius, measured by the area of the cylinder.
    #[test]
    fn concentric_cylinders_slide_by_the_angle_times_their_radius() {
        for angle in [0.15_f64, 0.075] {
            let at = |phi: f64, y: f64| [phi.sin(), y, phi.cos() - 1.0];
            let own = [at(-angle, 0.0), at(angle, 0.0), at(angle, 1.0), at(-angle, 1.0)];
            let other = [at(-angle, 1.2), at(angle, 1.2), at(angle, -0.2), at(-angle, -0.2)];
            let x: Vec<Vec3<f64>> = own.into_iter().chain(other).collect();
            // Height that preserves the area of the circular segment, along two sides of the facets.
            let sagitta = 0.5 * angle.sin() * angle * (1.0 + 2.0 / 15.0 * angle * angle);
            let curved = |sign: f64| Profile::new(&[0.0; 4], &[sign * sagitta, 0.0, sign * sagitta, 0.0]);
            let pair = Pair::new(&x, [4, 4]).unwrap().curved([&curved(1.0), &curved(-1.0)]);
            let ([first, _, normal], weights, along) = (pair.axes(), pair.mortar_weights(), pair.normal_weights().unwrap());
            // Displacement of the secondary nodes in a rotation about the axis by a unit angle.
            let motion = |x: &Vec3<f64>| [x[2] + 1.0, 0.0, -x[0]];
            let (mut flat, mut curve) = (0.0, 0.0);
            for (a, k) in (0..4).flat_map(|a| (0..4).map(move |k| (a, k))) {
                flat += weights[a][k] * dot(first, motion(&x[k]));
                curve += along[0][a][k] * dot(normal, motion(&x[k]));
            }
            let square = angle * angle;
            assert!((flat + curve - 2.0 * angle).abs() < 0.02 * square * angle, "{angle}: {flat} {curve}");
            assert!((flat - 2.0 * angle).abs() > 0.5 * square * angle, "{angle}: {flat}");
        }
    }

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
        // Facets with equal normals have no overlap.
        let same: Vec<Vec3<f64>> = [0, 1, 2, 3, 7, 6, 5, 4].iter().map(|&k| x[k]).collect();
        assert!(!Pair::new(&same, [4, 4]).expect("it has an area").overlaps());
    }
}
