//! Dual multiplier shape functions in space: their coefficients, and the facets that use them in a step (dual mortar method).
//!
//! With the reference mass matrix of a facet, `M_jk = int N_j N_k dA`, and `D_j = int N_j dA`, the functions
//!
//! ```text
//! psi_j = sum_k C_jk N_k,      C = D M^-1,      int psi_j N_k dA = delta_jk D_j
//! ```
//!
//! are biorthogonal to the facet's shape functions, their sum is one, and their integrals are `D_j` (Wohlmuth, SIAM J. Numer. Anal. 38,
//! 2000). Affine deformations of the facet preserve this, other ones nearly. Constant coefficients keep a constraint that is closed at the
//! end of a step closed at the start of the next one. All quantities that are linear in the shape functions (`pair.rs`) are combined
//! accordingly: values and gradients by `C`, weights of second derivatives by its transpose. A constant `C` changes no conservation law.

use std::array;
use std::ops::{Add, Mul};

use super::pair::{Gradients, Pair};
use super::vectors::Vec3;
use super::vertices::CORNERS;
use crate::contact::faces;
use crate::contact::numbers::Each;
use crate::contact::search::PairSearch;
use crate::contact::surface::{Sides, Surface};

/// Range of the covered fraction of a facet in which standard functions are blended into dual ones. Facets at coinciding borders keep a
/// larger fraction than the upper value as bodies deform. Above the lower value all integrals are positive.
const PARTLY: [f64; 2] = [0.75, 0.9];

/// Multiplier shape functions of a facet as coefficients `C` of its standard shape functions; `None` for the identity.
#[derive(Clone, Debug, PartialEq)]
pub struct MultiplierFunctions(Option<[[f64; CORNERS]; CORNERS]>);

impl MultiplierFunctions {
    /// Standard shape functions of the facet.
    pub const STANDARD: MultiplierFunctions = MultiplierFunctions(None);

    /// Dual functions for the given positions of the nodes; standard functions for facets that are folded or have no area.
    fn dual(nodes: &[Vec3<f64>]) -> MultiplierFunctions {
        let of_pair = |both: &[Vec3<f64>]| {
            let mass = Pair::new(both, [nodes.len(); 2])?.mortar_weights();
            let mass = nalgebra::DMatrix::from_fn(nodes.len(), nodes.len(), |j, k| mass[j][k]);
            let (shares, inverse) = (mass.column_sum(), mass.cholesky()?.inverse());
            Some(array::from_fn(|j| array::from_fn(|k| if j.max(k) < nodes.len() { shares[j] * inverse[(j, k)] } else { 0.0 })))
        };
        // The mortar integrals of the facet with its own reverse are its mass matrix.
        MultiplierFunctions(of_pair(&nodes.iter().chain(nodes.iter().rev()).copied().collect::<Vec<_>>()))
    }

    /// Blend `share C + (1 - share) I` of the dual coefficients `C` and the standard shape functions (identity `I`).
    fn in_part(&self, share: f64) -> MultiplierFunctions {
        let of = |by: &[[f64; CORNERS]; CORNERS]| -> [[f64; CORNERS]; CORNERS] {
            array::from_fn(|j| array::from_fn(|k| share * by[j][k] + if j == k { 1.0 - share } else { 0.0 }))
        };
        if share > 0.0 { MultiplierFunctions(self.0.as_ref().map(of)) } else { MultiplierFunctions::STANDARD }
    }

    /// Transforms values for the standard shape functions into values for the multiplier shape functions, `C own`.
    #[inline(always)]
    pub fn of<T: Copy + Add<Output = T> + Mul<f64, Output = T>>(&self, own: [T; CORNERS]) -> [T; CORNERS] {
        let MultiplierFunctions(Some(by)) = self else { return own };
        by.map(|by| own[0] * by[0] + own[1] * by[1] + own[2] * by[2] + own[3] * by[3])
    }

    /// Transforms gradients for the standard shape functions into gradients for the multiplier shape functions.
    pub fn of_gradients(&self, own: Gradients) -> Gradients {
        if self.0.is_none() { own } else { own.map(|node| node.map(|each| Each(self.of(each.0)))) }
    }

    /// Transforms lists of values for the standard shape functions into lists for the multiplier shape functions.
    pub fn of_lists<T: Copy + Add<Output = T> + Mul<f64, Output = T>, const N: usize>(
        &self,
        mut own: [[T; N]; CORNERS],
    ) -> [[T; N]; CORNERS] {
        if self.0.is_none() {
            return own;
        }
        for k in 0..N {
            let each = self.of(array::from_fn(|j| own[j][k]));
            (0..CORNERS).for_each(|j| own[j][k] = each[j]);
        }
        own
    }

    /// Weights `C^T w` of the standard shape functions in a sum of the multiplier shape functions with the weights `w`.
    pub fn back(&self, weights: [f64; CORNERS]) -> [f64; CORNERS] {
        let MultiplierFunctions(Some(by)) = self else { return weights };
        array::from_fn(|k| (0..CORNERS).map(|j| by[j][k] * weights[j]).sum())
    }
}

/// Multiplier shape functions of a surface: dual where possible.
#[derive(Clone, Debug)]
pub struct Duals {
    /// Dual functions of each facet.
    dual: Vec<MultiplierFunctions>,
    /// Functions of each facet in this step.
    in_step: Vec<MultiplierFunctions>,
}

impl Duals {
    /// Dual functions of a surface for the given reference positions; standard functions are active until a step begins.
    pub fn new(surface: &Surface, reference: &[f64]) -> Self {
        let of = |facet: usize| {
            let nodes: Vec<Vec3<f64>> = surface.facet(facet).iter().map(|&node| faces::at(node, reference).into()).collect();
            MultiplierFunctions::dual(&nodes)
        };
        Duals { dual: (0..surface.count()).map(of).collect(), in_step: vec![MultiplierFunctions::STANDARD; surface.count()] }
    }

    /// Multiplier shape functions of a facet in this step.
    pub fn shape(&self, facet: u32) -> &MultiplierFunctions {
        &self.in_step[facet as usize]
    }

    /// Selects the functions for a step from `q_0`; `pair` returns pairs with overlapping facets.
    ///
    /// Dual functions are partly negative, so that an opening of a partly covered facet would count as penetration. They are used on facets
    /// covered by participating pairs whose neighbors have opposite facets within a facet's length. If the neighbors, too, had to be
    /// covered by participating pairs, functions, and thus active constraints, would change throughout rolling. As the covered fraction
    /// decreases, the functions are blended into the standard ones: a jump would change the forces with any small motion, without an
    /// equilibrium.
    pub fn choose(&mut self, search: &PairSearch, sides: &Sides, q_0: &[f64], pair: impl Fn(usize) -> Option<Pair<f64>>) {
        let secondary = &sides.secondary;
        // Covered area of each facet, projected along its normal: by participating pairs, and by participating and open pairs.
        let mut covered = vec![[0.0; 2]; secondary.count()];
        for (p, &[own, _]) in search.candidates.pairs().iter().enumerate() {
            if !search.near[p] && !search.is_beside(p, sides, q_0) {
                continue;
            }
            let Some(pair) = pair(p) else { continue };
            let area = pair.covered().iter().sum::<f64>();
            let [taking_part, seen] = &mut covered[own as usize];
            if search.near[p] {
                *taking_part += area;
                *seen += area;
            } else if pair.values().iter().sum::<f64>() > 0.0 {
                *seen += area;
            }
        }
        let share = |facet: usize, kind: usize| covered[facet][kind] / (0.5 * faces::area_vector(secondary.facet(facet), q_0).norm());
        let of = |(facet, dual): (usize, &MultiplierFunctions)| {
            let around = secondary.local_facet(facet).iter().flat_map(|&node| secondary.adjacent_facets(node as usize));
            let least = around.map(|&other| share(other as usize, 1)).fold(share(facet, 0), f64::min);
            dual.in_part(part(least))
        };
        self.in_step = self.dual.iter().enumerate().map(of).collect();
    }
}

/// Share of the dual functions in the blend, for a given covered fraction.
fn part(share: f64) -> f64 {
    ((share - PARTLY[0]) / (PARTLY[1] - PARTLY[0])).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::*;

    /// Facets of three and four nodes, distorted and warped at random.
    fn facets() -> impl Strategy<Value = Vec<Vec3<f64>>> {
        (prop::sample::select(vec![3, 4]), prop::collection::vec(-0.2..0.2f64, 12)).prop_map(|(count, noise)| {
            let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            (0..count).map(|k| [square[k][0] + noise[3 * k], square[k][1] + noise[3 * k + 1], noise[3 * k + 2]]).collect()
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, rng_seed: RngSeed::Fixed(2007), failure_persistence: None, ..Default::default() })]

        #[test]
        fn dual_functions_are_biorthogonal_to_those_of_the_facet(nodes in facets()) {
            let count = nodes.len();
            // Pair with a larger opposite facet, so that the facet is fully covered.
            let all = [[-9.0, 9.0, 1.0], [9.0, 9.0, 1.0], [9.0, -9.0, 1.0], [-9.0, -9.0, 1.0]];
            let x: Vec<Vec3<f64>> = nodes.iter().copied().chain(all).collect();
            let pair = Pair::new(&x, [count, 4]).expect("it has an area");
            let (shape, shares) = (MultiplierFunctions::dual(&nodes), pair.covered());
            prop_assert!(shape != MultiplierFunctions::STANDARD);
            for (j, row) in shape.of_lists(pair.mortar_weights()).iter().enumerate().take(count) {
                for (k, integral) in row[..count].iter().enumerate() {
                    let expected = if j == k { shares[j] } else { 0.0 };
                    prop_assert!((integral - expected).abs() < 1e-14, "{j} {k}: {integral} {expected}");
                }
            }
            // The integrals of dual functions equal those of the standard functions, and dual functions sum to one.
            for (dual, own) in shape.of(shares).iter().zip(shares) {
                prop_assert!((dual - own).abs() < 1e-14);
            }
            for (node, sum) in shape.back([1.0; CORNERS]).into_iter().enumerate().take(count) {
                prop_assert!((sum - 1.0).abs() < 1e-14, "{node}: {sum}");
            }
        }

        /// On a facet covered up to a straight border, no constraint function of a constant opening is negative.
        #[test]
        fn a_constant_opening_is_one_for_every_row(nodes in facets(), angle in 0.0..6.3f64, place in -0.8..0.8f64) {
            let count = nodes.len();
            let ((sin, cos), middle) = (angle.sin_cos(), [0, 1].map(|i| nodes.iter().map(|x| x[i]).sum::<f64>() / count as f64));
            let at = |along: f64, across: f64| [middle[0] + cos * along - sin * across, middle[1] + sin * along + cos * across, 1.0];
            let all = [at(-9.0, 9.0), at(9.0, 9.0), at(9.0, place), at(-9.0, place)];
            let covered = |other: [Vec3<f64>; 4]| {
                let x: Vec<Vec3<f64>> = nodes.iter().copied().chain(other).collect();
                Pair::new(&x, [count, 4]).map_or([0.0; CORNERS], |pair| pair.covered())
            };
            let (left, whole) = (covered(all), covered([at(-9.0, 9.0), at(9.0, 9.0), at(9.0, -9.0), at(-9.0, -9.0)]));
            let share = left.iter().sum::<f64>() / whole.iter().sum::<f64>();
            let shape = MultiplierFunctions::dual(&nodes).in_part(part(share));
            for (row, whole) in shape.of(left).iter().zip(whole) {
                prop_assert!(*row >= -1e-15 && *row <= 2.0 * whole + 1e-15, "{row} of {whole}, {share} is covered");
            }
        }
    }

    /// Closed form: each dual function of a triangle is three times its own shape function minus the two others.
    #[test]
    fn the_functions_of_triangles_are_known() {
        let shape = MultiplierFunctions::dual(&[[0.3, 0.1, 0.0], [2.0, 0.4, 0.7], [-0.5, 1.5, 0.2]]);
        for (k, of) in shape.of([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0; 4]].map(Each)).iter().enumerate() {
            for (j, by) in of.0.iter().enumerate() {
                let expected = if j == 3 || k == 3 {
                    0.0
                } else if j == k {
                    3.0
                } else {
                    -1.0
                };
                assert!((by - expected).abs() < 1e-13, "{j} {k}: {by}");
            }
        }
    }
}
