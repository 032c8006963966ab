//! Facet pairs of ties in space: the mortar average of the gap vector vanishes (`tie.rs`).
//!
//! ```text
//! Phi_A = int N_A (sum_B N_B x_B - sum_C M_C y_C) dA - sum_k alpha_Ak (y_k - y_0)          [length^3], a vector
//! ```
//!
//! over the overlap of each facet pair in the reference positions, projected along the secondary facet's normal. The second term is the
//! reference value of the first one (polyhedra on one curved surface, bridged gaps), expressed by two edges of the primary facet and the
//! vector to a node `y_3` inside of the primary body, in the cell behind the facet. The coefficients are constant, so that an affine map of
//! all positions maps `Phi_A` linearly: it stays zero, forces have zero resultant, and zero moment while `Phi = 0`. For offsets at
//! round-off level the inner node takes no part.

use nalgebra::Matrix3;

use super::pair::Pair;
use super::vertices::{CORNERS, NODES};
use crate::contact::faces;
use crate::contact::search::Candidates;
use crate::contact::surface::{Sides, Surface};
use crate::contact::tie::{Tie, TiedPair};
use crate::math::tolerances::TIE_OFFSET;

impl Tie {
    /// Ties points of both surfaces within `reach` `[length]` of each other in the reference positions; `inner`: a node inside of the body
    /// behind each primary facet.
    pub fn in_space(secondary: Surface, primary: Surface, inner: &[u32], reference: &[f64], reach: f64) -> Self {
        let mut candidates = Candidates::new(0.0);
        candidates.update(&secondary, &primary, reference, reach);
        let tied = |&[own, other]: &[u32; 2]| {
            let sides = [secondary.facet(own as usize), primary.facet(other as usize)];
            tied_pair(sides, secondary.local_facet(own as usize), inner[other as usize], reference, reach)
        };
        let pairs = candidates.pairs().iter().filter_map(tied).collect();
        Tie::of(Sides::of(secondary, primary, reference), pairs)
    }
}

/// Data of a tied facet pair; `None` without overlap within reach.
fn tied_pair([own, other]: [&[u32]; 2], rows: &[u32], inner: u32, q: &[f64], reach: f64) -> Option<TiedPair> {
    let mut nodes: Vec<u32> = own.iter().chain(other).copied().collect();
    let places: Vec<[f64; 3]> = nodes.iter().map(|&node| faces::at(node, q).into()).collect();
    let pair = Pair::new(&places, [own.len(), other.len()]).filter(Pair::overlaps)?;
    if pair.farthest() > reach {
        return None;
    }
    let (weights, covered) = (pair.mortar_weights(), pair.covered());
    let mut shares: Vec<[f64; NODES + 1]> = Vec::new();
    // Edges of the primary facet, and vector to the inner node.
    let (first, at) = (own.len(), |node: u32| faces::at(node, q));
    let ends = [other[1], other[other.len() - 1], inner];
    let frame = Matrix3::from_columns(&ends.map(|end| at(end) - at(other[0])));
    let inverse = frame.try_inverse()?;
    for of_node in weights.iter().take(own.len()) {
        let mut share = [0.0; NODES + 1];
        share[..NODES].copy_from_slice(of_node);
        let offset: faces::Vector = nodes.iter().zip(of_node).map(|(&node, weight)| at(node) * *weight).sum();
        let [along, beside, within]: [f64; 3] = (inverse * offset).into();
        for (place, part) in [(first + 1, along), (first + other.len() - 1, beside), (nodes.len(), within)] {
            share[place] -= part;
            share[first] += part;
        }
        shares.push(share);
    }
    let size = covered.iter().take(own.len()).fold(0.0, |largest: f64, part| largest.max(*part));
    if shares.iter().any(|share| share[nodes.len()].abs() > TIE_OFFSET * size) {
        nodes.push(inner);
    }
    let line = |share: &[f64; NODES + 1], i: usize| -> Vec<f64> {
        (0..3 * nodes.len()).map(|unknown| if unknown % 3 == i { share[unknown / 3] } else { 0.0 }).collect()
    };
    let gradient = shares.iter().flat_map(|share| (0..3).flat_map(move |i| line(share, i))).collect();
    Some(TiedPair { nodes, secondary: rows.to_vec(), gradient, covered: covered[..rows.len().min(CORNERS)].to_vec() })
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3};

    use super::*;
    use crate::contact::fixtures::{dense_rows, difference, evaluated, product};
    use crate::contact::{CandidateSearch, PatchFunctions, PredictedMotion};
    use crate::integrators::Derivative;

    fn largest(values: &[f64]) -> f64 {
        values.iter().fold(0.0, |largest, value| largest.max(value.abs()))
    }

    /// Facet of four nodes at a distance `rise` over two triangles with a common diagonal, and a node below them.
    fn facets(rise: f64) -> (Tie, Vec<f64>) {
        let mut q = vec![0.1, 0.0, rise, 0.2, 0.9, rise, 1.1, 1.0, 1.2 * rise, 1.0, 0.1, rise];
        q.extend([0.0, 0.0, 0.0, 1.2, 0.0, 0.0, 1.2, 1.2, 0.0, 0.0, 1.2, 0.0, 0.3, 0.4, -1.0]);
        let secondary = Surface::in_space([&[0u32, 1, 2, 3][..]]);
        let primary = Surface::in_space([&[4u32, 5, 6][..], &[4, 6, 7]]);
        let mut tie = Tie::in_space(secondary, primary, &[8, 8], &q, 0.5);
        assert!(tie.update_candidates(&PredictedMotion::within(&q, 0.0)));
        tie.begin_step(&q);
        (tie, q)
    }

    /// Constraints are linear in positions and invariant under affine maps; forces have zero resultant, and zero moment at rest.
    #[test]
    fn affine_motions_keep_the_constraints() {
        for rise in [0.0, 0.2] {
            let (tie, q) = facets(rise);
            assert!(tie.untied().is_empty() && largest(&tie.gap(&q)) < 1e-16, "{:?}", tie.gap(&q));
            assert!((0..2).all(|p| tie.sides().patches.nodes(p).contains(&8) == (rise > 0.0)), "the node within carries the offset");
            let turn = Rotation3::from_euler_angles(0.4, -1.1, 0.7);
            let stretch = nalgebra::Matrix3::new(1.1, 0.2, 0.0, -0.1, 0.9, 0.3, 0.0, 0.1, 1.2);
            let moved: Vec<f64> = q
                .chunks_exact(3)
                .flat_map(|x| <[f64; 3]>::from(turn * (stretch * Vector3::from_row_slice(x)) + Vector3::new(3.0, -2.0, 1.0)))
                .collect();
            assert!(largest(&tie.gap(&moved)) < 1e-15);
            // If the upper body alone moves by 0.1, the gap opens by displacement times covered area.
            let alone: Vec<f64> = q.iter().enumerate().map(|(k, x)| if k < 12 && k % 3 == 1 { x + 0.1 } else { *x }).collect();
            let covered: f64 = tie.sides().weights.iter().step_by(3).sum();
            let opened: f64 = tie.gap(&alone).iter().skip(1).step_by(3).sum();
            assert!((opened - 0.1 * covered).abs() < if rise == 0.0 { 1e-15 } else { 0.02 }, "{opened} {covered}");
        }
    }

    /// Linear constraints are directional without correction; unit multipliers have zero resultant and moment.
    #[test]
    fn forces_are_balanced_and_directional() {
        let (tie, q) = facets(0.2);
        let out = evaluated(&tie, Derivative::DiscreteGradient, &q, &[1.0; 12]);
        let rows = dense_rows(&tie, &out.gradient_bar, q.len());
        let moved: Vec<f64> = q.iter().enumerate().map(|(k, x)| x + 0.1 * (7.3 * k as f64).sin()).collect();
        for (row, (end, start)) in rows.iter().zip(tie.gap(&moved).iter().zip(tie.start_gap())) {
            assert!((product(row, &difference(&moved, &q)) - (end - start)).abs() < 1e-15);
            let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
            for (x, f) in q.chunks_exact(3).zip(row.chunks_exact(3)) {
                let (x, f) = (Vector3::from_row_slice(x), Vector3::from_row_slice(f));
                force += f;
                moment += x.cross(&f);
            }
            assert!(force.norm() < 1e-15 && moment.norm() < 1e-15, "{force} {moment}");
        }
    }

    /// Pairs beyond the reach or without overlap are excluded.
    #[test]
    fn only_what_lies_opposite_within_reach_is_tied() {
        let (_, q) = facets(0.2);
        let surfaces = || (Surface::in_space([&[0u32, 1, 2, 3][..]]), Surface::in_space([&[4u32, 5, 6][..]]));
        let (secondary, primary) = surfaces();
        assert_eq!(Tie::in_space(secondary, primary, &[8], &q, 0.1).untied(), [0, 1, 2, 3]);
        let (secondary, primary) = surfaces();
        let half = Tie::in_space(secondary, primary, &[8], &q, 0.5);
        assert!(half.coverage(&q).iter().step_by(3).all(|share| *share < 1.0));
    }
}
