//! Height profiles in the slips of a facet pair in space (`slip.rs`): friction acts on the curved surfaces, not on the facets.
//!
//! With the plane axes and the normal `n` of the secondary facet, a unit vector `t` in its plane, and the height profiles `B_1`, `B_2`
//! (`profiles.rs`), to second order in the slopes, the tangent of the secondary curve and the displacements of opposite points are
//!
//! ```text
//! t + (t.grad B_1) n      dx = sum N_j d_j - B_1 sum grad N_j (n.d_j)      dy = sum M_k d_k + B_2 sum grad M_k (n.d_k)
//! ```
//!
//! so that the slip `int N_a (t + (t.grad B_1) n).(dx - dy) dA` has, besides the weights of flat facets along `t`, weights along `n`:
//!
//! ```text
//! t.v_aj,    v_aj = int N_a (N_j grad B_1 - B_1 grad N_j) dA,    v_ak = -int N_a (M_k grad B_1 + B_2 grad M_k) dA      [length^2]
//! ```
//!
//! The first part is the direction of the curve, the second one its distance from the facet: without both, the moment of friction between
//! rings is too small by the distance of the facets from their circle (1.5 % with 20 facets around). Weights of all nodes have zero sum.
//! `curve_integrals.rs` has the integrals over a polygon with their derivatives. Profiles are proportional to the stretches of their facets
//! (`stretch.rs`).

use super::clipping::area;
use super::curve_integrals::{CUBIC, CurveSlopes, parts};
use super::facet_profile::Profile;
use super::forms::derivatives;
use super::polygon::Polygon;
use super::vectors::{FacetFrame, Vec3, dot};
use super::vertices::{CORNERS, NODES, OfNodes, shape_gradients};
use super::view::{Curves, View};
use super::weights::{OfCorners, SHAPES, Sums, Values};
use crate::contact::numbers::{Each, Number};
use crate::math::simd::Kernel;

/// Weights along the normal of a facet pair: both plane components of the vectors `v`, for each secondary node and all nodes.
pub type NormalWeights<T> = [[[T; NODES]; CORNERS]; 2];

/// Computation of the vectors `v` of a facet pair with height profiles, without derivatives.
pub struct NormalTerms<'a> {
    pub view: &'a View<f64>,
    pub polygons: &'a [Polygon<f64>],
}

impl Kernel for NormalTerms<'_> {
    type Output = NormalWeights<f64>;

    #[inline(always)]
    fn run<const FMA: bool>(self) -> Self::Output {
        let mut sums = [Values::empty(), Values::empty()];
        for polygon in self.polygons {
            let Some(forms) = self.view.forms(&polygon.corners) else { continue };
            let parts = parts(polygon, &self.view.places(&polygon.corners), &forms);
            for i in 0..2 {
                let mut integrals = [[0.0; SHAPES]; 3];
                for a in 0..3 {
                    for s in 0..SHAPES {
                        integrals[a][s] = parts[0][i][a][s] + parts[1][i][a][s];
                    }
                }
                sums[i].add(&polygon.corners, &integrals);
            }
        }
        let mut weights = [[[0.0; NODES]; CORNERS]; 2];
        for a in 0..self.view.counts[0] {
            for i in 0..2 {
                weights[i][a] = sums[i].of_node(self.view, a);
            }
        }
        weights
    }
}

/// Computation of the vectors `v` of a facet pair with height profiles, with derivatives with respect to the node positions. `first` is the
/// first plane axis with its derivatives.
pub struct DifferentiatedNormalTerms<'a> {
    pub view: &'a View<f64>,
    pub polygons: &'a [Polygon<f64>],
    pub first: &'a Vec3<OfNodes>,
}

impl DifferentiatedNormalTerms<'_> {
    /// Adds a polygon to the sums of both components and to the derivatives with respect to the logarithms of both stretches.
    #[inline(always)]
    fn add(
        &self,
        polygon: &Polygon<f64>,
        buffers: &mut (CurveSlopes, Polygon<OfCorners>),
        sums: &mut [Sums; 2],
        by_stretch: &mut [[Values; 2]; 2],
    ) {
        let (Some(forms), (all, moving)) = (self.view.forms(&polygon.corners), buffers) else { return };
        all.set(polygon, &self.view.places(&polygon.corners), &forms, moving);
        for i in 0..2 {
            let mut integrals = [[0.0; SHAPES]; 3];
            for a in 0..3 {
                for s in 0..SHAPES {
                    integrals[a][s] = all.parts[0][i][a][s] + all.parts[1][i][a][s];
                }
            }
            sums[i].add_to_points(&polygon.corners, &integrals, &all.slopes[i]);
            for side in 0..2 {
                by_stretch[side][i].add(&polygon.corners, &all.parts[side][i]);
            }
        }
    }
}

impl Kernel for DifferentiatedNormalTerms<'_> {
    type Output = NormalWeights<OfNodes>;

    #[inline(always)]
    fn run<const FMA: bool>(self) -> Self::Output {
        let view = self.view;
        let mut weights = [[[OfNodes::from(0.0); NODES]; CORNERS]; 2];
        let Some(Curves { stretches, .. }) = &view.curves else { return weights };
        let mut sums = [Sums::empty(), Sums::empty()];
        let mut by_stretch = [[Values::empty(), Values::empty()], [Values::empty(), Values::empty()]];
        let mut buffers = (CurveSlopes::empty(), Polygon::empty());
        for polygon in self.polygons {
            self.add(polygon, &mut buffers, &mut sums, &mut by_stretch);
        }
        // Rotation of the axes in their plane, which changes the components of `v`.
        let second = view.frame.axes[1];
        let mut spin = [0.0; 3 * NODES];
        for i in 0..3 {
            for lane in 0..3 * NODES {
                spin[lane] += second[i] * self.first[i].eps[lane];
            }
        }
        for a in 0..view.counts[0] {
            for i in 0..2 {
                let (values, of_p) = sums[i].of_node(view, a);
                let slopes: [Vec3<Each<NODES>>; NODES] = view.spread(&of_p, &[Each([0.0; NODES]); NODES]);
                let turned = sums[1 - i].values.of_node(view, a);
                let sign = if i == 0 { 1.0 } else { -1.0 };
                for s in 0..NODES {
                    let weight = &mut weights[i][a][s];
                    weight.re = values[s];
                    for node in 0..NODES {
                        for axis in 0..3 {
                            let lane = 3 * node + axis;
                            weight.eps[lane] = slopes[node][axis].0[s] + sign * turned[s] * spin[lane];
                        }
                    }
                }
                for side in 0..2 {
                    let (by, begin) = (by_stretch[side][i].of_node(view, a), side * view.counts[0]);
                    for s in 0..NODES {
                        for node in 0..view.counts[side] {
                            for axis in 0..3 {
                                weights[i][a][s].eps[3 * (begin + node) + axis] += by[s] * stretches[side].rises[node][axis];
                            }
                        }
                    }
                }
            }
        }
        weights
    }
}

/// Two tangents of a secondary node in the axes of a facet.
pub type PlaneTangents = [[f64; 2]; 2];

/// Tangents at the nodes of a facet with the reference positions `nodes`, at angles with these cosines and sines from the first plane axis,
/// multiplied by the area of the curved surface per area of the facet.
///
/// The unit tangent `t` of the facet, rotated to the curved surface with the slope `g = grad B`, times its area is `F t + (t.g) n` with
/// `F = (1 + g.g/2) 1 - g x g/2` to second order; the mean of `F` over the facet stands for it here. Across the direction of the slope,
/// as in a pin that is pushed into its hole, friction acts on the arc length; along the slope `F` is one.
pub fn tangents(profile: &Profile, nodes: &[Vec3<f64>], turns: Vec<[f64; 2]>) -> Vec<PlaneTangents> {
    let [[xx, xy], [_, yy]] = mean_area(profile, nodes).unwrap_or([[1.0, 0.0], [0.0, 1.0]]);
    let of = |[x, y]: [f64; 2]| [xx * x + xy * y, xy * x + yy * y];
    turns.into_iter().map(|[cos, sin]| [of([cos, sin]), of([-sin, cos])]).collect()
}

/// Mean of `F` over a facet; `None` for a flat facet.
fn mean_area(profile: &Profile, nodes: &[Vec3<f64>]) -> Option<[[f64; 2]; 2]> {
    if profile.is_flat() {
        return None;
    }
    let [first, second, _] = FacetFrame::new(nodes)?.axes;
    let place = |x: &Vec3<f64>| [dot(*x, first), dot(*x, second)];
    let count = nodes.len();
    let middle: Vec3<f64> = std::array::from_fn(|i| nodes.iter().map(|x| x[i]).sum::<f64>() / count as f64);
    let (mut square, mut total) = ([0.0; 3], 0.0);
    for k in 0..if count == 3 { 1 } else { count } {
        let places = [&nodes[k], &nodes[(k + 1) % count], if count == 3 { &nodes[2] } else { &middle }].map(place);
        let twice = area(&places[0], &places[1], &places[2]);
        let gradients = shape_gradients(&places, twice);
        for (at, share) in &CUBIC {
            let slopes = derivatives(profile.form(k), at);
            let [x, y] = [0, 1].map(|i| (0..3).map(|j| slopes[j] * gradients[j][i]).sum::<f64>());
            square.iter_mut().zip([x * x, x * y, y * y]).for_each(|(sum, part)| *sum += twice * share * part);
        }
        total += twice;
    }
    let [xx, xy, yy] = square.map(|sum| 0.5 * sum / total);
    Some([[1.0 + yy, -xy], [-xy, 1.0 + xx]])
}

/// Weights along the normal of the facet, besides those along the tangents of a tangential constraint.
#[derive(Clone)]
pub struct NormalPart<T> {
    /// Normal of the secondary facet.
    pub normal: Vec3<T>,
    /// Weights of the nodal displacements for both tangents, with zero sum `[length^2]`.
    pub weights: [[T; NODES]; 2],
}

impl<T: Number> NormalPart<T> {
    /// Weights for two tangents in plane coordinates, from the vectors `v` of a secondary node.
    pub fn new(normal: Vec3<T>, [x, y]: [&[T; NODES]; 2], tangents: &PlaneTangents) -> Self {
        NormalPart { normal, weights: tangents.map(|[a, b]| std::array::from_fn(|node| x[node] * a + y[node] * b)) }
    }
}

impl NormalPart<OfNodes> {
    /// Values without derivatives.
    pub fn values(&self) -> NormalPart<f64> {
        NormalPart { normal: self.normal.map(|x| x.re), weights: self.weights.each_ref().map(|weights| weights.map(|w| w.re)) }
    }

    /// Adds the derivatives of the slip along tangent `k` for constant displacements `motion`.
    #[inline(always)]
    pub fn add_slopes<const N: usize>(&self, k: usize, motion: &[Vec3<f64>], slopes: &mut [f64; N]) {
        let normal = [self.normal[0].re, self.normal[1].re, self.normal[2].re];
        let mut sum = [0.0; 3];
        for (weight, moved) in self.weights[k].iter().zip(motion) {
            let out = dot(normal, *moved);
            for lane in 0..N {
                slopes[lane] += weight.eps[lane] * out;
            }
            for i in 0..3 {
                sum[i] += weight.re * moved[i];
            }
        }
        for i in 0..3 {
            for lane in 0..N {
                slopes[lane] += self.normal[i].eps[lane] * sum[i];
            }
        }
    }

    /// Adds the derivatives of the nodal forces of two shear multipliers.
    #[inline(always)]
    pub fn add_force_slopes<const N: usize>(&self, shear: &[f64; 2], slopes: &mut [[[f64; N]; 3]; NODES]) {
        for node in 0..NODES {
            let [first, second] = [&self.weights[0][node], &self.weights[1][node]];
            let value = first.re * shear[0] + second.re * shear[1];
            let mut by = [0.0; N];
            for lane in 0..N {
                by[lane] = first.eps[lane] * shear[0] + second.eps[lane] * shear[1];
            }
            for i in 0..3 {
                for lane in 0..N {
                    slopes[node][i][lane] += by[lane] * self.normal[i].re + value * self.normal[i].eps[lane];
                }
            }
        }
    }
}
