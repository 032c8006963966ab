//! Preconditioner of a matrix with a border: smoothed aggregation inside of bodies, constraints exact on the coarsest level.
//!
//! Nodes with constraints (*kept* nodes) are unchanged on every level, and only nodes without constraints are smoothed. All constraints
//! therefore belong to the coarsest problem, which is factorized: its correction satisfies them exactly, and the cycle is multigrid in the
//! space of motions that satisfy the constraints. For every such motion there is a coarse one with the same values at the kept nodes. Their
//! difference is smoothed inside of a body, so that convergence depends neither on the mesh size nor on the kind of constraints.

use super::border::{Alone, Border, Scaled, rigid_motions, stiffness_of};
use super::coarsest::Coarsest;
use super::hierarchy::{Hierarchy, Last, SMALL};
use super::refusal::Refusal;
use crate::linear::watch::InterruptWatch;
use crate::math::workers::Workers;

/// The preconditioner of a scaled matrix.
pub(super) struct Saddle<const D: usize, const M: usize> {
    hierarchy: Hierarchy<D, M>,
    coarsest: Coarsest,
    /// First unknown of every node.
    firsts: Vec<usize>,
    /// Unknowns of the border vertices.
    unknowns: Vec<usize>,
    alone: Vec<Alone>,
    right: Vec<[f64; D]>,
    border: Vec<f64>,
}

impl<const D: usize, const M: usize> Saddle<D, M> {
    /// Preconditioner of a matrix; refused if most nodes have constraints, so that the coarsest problem would be the whole one.
    pub fn new(matrix: &Scaled, workers: &Workers, watch: &InterruptWatch) -> Result<Self, Refusal> {
        let pattern = matrix.pattern;
        let border = Border::new::<D>(matrix);
        let nodes: Vec<u32> = border.free.iter().chain(&border.kept).copied().collect();
        if border.free.len() <= border.kept.len() && D * nodes.len() > SMALL {
            return Err(Refusal::Unsuited);
        }
        let (hierarchy, last) = workers.together(|| {
            let stiffness = stiffness_of(matrix, &nodes);
            let modes = rigid_motions(matrix, &nodes, &stiffness);
            Hierarchy::<D, M>::new(stiffness, modes, border.free.len(), workers)
        });
        let coarsest = match &last {
            Last::Fine(level) => Coarsest::new(level, matrix, &border, workers, watch),
            Last::Coarse(level) => Coarsest::new(level, matrix, &border, workers, watch),
        }?;
        Ok(Saddle {
            hierarchy,
            coarsest,
            firsts: nodes.iter().map(|&v| pattern.first_unknown(v as usize)).collect(),
            unknowns: border
                .vertices
                .iter()
                .flat_map(|&v| pattern.first_unknown(v as usize)..pattern.first_unknown(v as usize + 1))
                .collect(),
            alone: border.alone.iter().map(|&v| Alone::new(matrix, v)).collect::<Option<_>>().ok_or(Refusal::Unsuited)?,
            right: vec![[0.0; D]; nodes.len()],
            border: vec![0.0; border.unknowns(pattern)],
        })
    }

    /// Bytes of the preconditioner.
    pub fn bytes(&self) -> usize {
        self.hierarchy.bytes() + self.coarsest.bytes()
    }

    /// Applies the preconditioner: `x := M^-1 b`, both for the scaled matrix.
    pub fn apply(&mut self, b: &[f64], x: &mut [f64], workers: &Workers) {
        let Saddle { hierarchy, coarsest, firsts, unknowns, alone, right, border } = self;
        let mut reduced;
        let mut b = b;
        if !alone.is_empty() {
            reduced = b.to_vec();
            alone.iter().for_each(|alone| alone.solve(&mut reduced, x));
            b = &reduced;
        }
        right.iter_mut().zip(&*firsts).for_each(|(right, &first)| right.copy_from_slice(&b[first..first + D]));
        border.iter_mut().zip(&*unknowns).for_each(|(border, &unknown)| *border = b[unknown]);
        hierarchy.cycle(right, border, coarsest, workers);
        firsts.iter().zip(&*right).for_each(|(&first, solution)| x[first..first + D].copy_from_slice(solution));
        unknowns.iter().zip(&*border).for_each(|(&unknown, lambda)| x[unknown] = *lambda);
    }
}
