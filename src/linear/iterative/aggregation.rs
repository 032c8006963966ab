//! Aggregates of strongly coupled nodes, and the prolongation that reproduces near-null vectors on each of them.

use super::blocks::{Block, BlockMatrix, frobenius};
use crate::math::tolerances::AGGREGATE_DEPENDENT;

/// Aggregate of a node without strong couplings.
pub(super) const NONE: u32 = u32::MAX;

/// Divides the leading `nodes` into aggregates: disjoint neighborhoods of strongly coupled nodes; each remaining node joins the
/// neighborhood to which it is coupled most strongly (Vanek, Mandel and Brezina 1996, algorithm 2). Nodes couple strongly if `|A_ij|^2 >
/// threshold^2 |A_ii| |A_jj|`. Returns the aggregate of every node, and their number.
pub(super) fn aggregates<const N: usize>(matrix: &BlockMatrix<N, N>, nodes: usize, threshold: f64) -> (Vec<u32>, usize) {
    let own: Vec<f64> = (0..nodes).map(|i| frobenius(&matrix.diagonal(i))).collect();
    let (mut starts, mut strong): (Vec<usize>, Vec<(u32, f64)>) = (vec![0], Vec::new());
    for i in 0..nodes {
        let (columns, blocks) = matrix.row(i);
        for (&j, block) in columns.iter().zip(blocks).filter(|(j, _)| **j != i as u32 && (**j as usize) < nodes) {
            let size = frobenius(block);
            if size > 0.0 && size * size > threshold * threshold * own[i] * own[j as usize] {
                strong.push((j, size / own[j as usize].sqrt()));
            }
        }
        starts.push(strong.len());
    }
    let near = |i: usize| &strong[starts[i]..starts[i + 1]];
    let (mut of, mut count) = (vec![NONE; nodes], 0);
    let is_free = |of: &[u32], i: usize| of[i] == NONE;
    for i in 0..nodes {
        if is_free(&of, i) && !near(i).is_empty() && near(i).iter().all(|&(j, _)| is_free(&of, j as usize)) {
            of[i] = count;
            near(i).iter().for_each(|&(j, _)| of[j as usize] = count);
            count += 1;
        }
    }
    let seeds = of.clone();
    for i in (0..nodes).filter(|&i| seeds[i] == NONE) {
        let nearest = near(i).iter().filter(|(j, _)| seeds[*j as usize] != NONE);
        // The first of equally strong couplings is chosen.
        if let Some((j, _)) = nearest.reduce(|best, other| if other.1 > best.1 { other } else { best }) {
            of[i] = seeds[*j as usize];
        }
    }
    for i in 0..nodes {
        if is_free(&of, i) && !near(i).is_empty() {
            of[i] = count;
            for &(j, _) in near(i) {
                if is_free(&of, j as usize) {
                    of[j as usize] = count;
                }
            }
            count += 1;
        }
    }
    (of, count as usize)
}

/// Tentative prolongation: near-null vectors restricted to each aggregate and orthonormalized there. Returns the prolongation and the
/// near-null vectors of the coarse matrix.
pub(super) fn tentative<const N: usize, const M: usize>(
    of: &[u32],
    count: usize,
    modes: &[Block<N, M>],
) -> (Vec<Block<N, M>>, Vec<Block<M, M>>) {
    let mut starts = vec![0usize; count + 1];
    of.iter().filter(|&&a| a != NONE).for_each(|&a| starts[a as usize + 1] += 1);
    for k in 0..count {
        starts[k + 1] += starts[k];
    }
    let (mut next, mut members) = (starts.clone(), vec![0usize; starts[count]]);
    for (node, &a) in of.iter().enumerate().filter(|(_, a)| **a != NONE) {
        members[next[a as usize]] = node;
        next[a as usize] += 1;
    }
    let (mut values, mut coarse) = (modes.to_vec(), vec![[[0.0; M]; M]; count]);
    of.iter().zip(&mut values).filter(|(a, _)| **a == NONE).for_each(|(_, block)| *block = [[0.0; M]; N]);
    for a in 0..count {
        let members = &members[starts[a]..starts[a + 1]];
        for m in 0..M {
            let length = |values: &[Block<N, M>]| members.iter().flat_map(|&i| values[i]).map(|row| row[m] * row[m]).sum::<f64>().sqrt();
            let before = length(&values);
            // Two orthogonalization passes suffice.
            for _ in 0..2 {
                for k in 0..m {
                    let product: f64 = members.iter().flat_map(|&i| values[i]).map(|row| row[k] * row[m]).sum();
                    coarse[a][k][m] += product;
                    members.iter().for_each(|&i| values[i].iter_mut().for_each(|row| row[m] -= product * row[k]));
                }
            }
            let after = length(&values);
            let is_dependent = after <= AGGREGATE_DEPENDENT * before;
            coarse[a][m][m] = if is_dependent { 0.0 } else { after };
            let factor = if is_dependent { 0.0 } else { 1.0 / after };
            members.iter().for_each(|&i| values[i].iter_mut().for_each(|row| row[m] *= factor));
        }
    }
    (values, coarse)
}
