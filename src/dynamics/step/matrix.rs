//! Matrix of a step: pattern, factors, and the rows and columns replaced for supports and inactive constraints.
//!
//! Vertices are the nodes with `D` components each, then the multipliers with one. All constraints are in the pattern; the equation of an
//! inactive one is `lambda = right`, so that the active set never changes the pattern.

use super::constraint_rows::ConstraintRows;
use crate::dynamics::model::part::Part;
use crate::dynamics::parts::contact_pair::{ContactPair, PairKind};
use crate::linear::{LinearError, LinearSolver, Pattern, SolverChoice, Vertex, solver_of};
use crate::math::workers::Workers;

/// The matrix of a model's steps.
pub struct Matrix {
    /// Sparsity pattern.
    pub pattern: Pattern,
    /// Linear solver.
    pub solver: Box<dyn LinearSolver>,
    /// Number of the pattern; values made for another pattern are discarded.
    pub generation: usize,
    /// True if pattern and factorization belong to an earlier list of candidate pairs.
    pub is_stale: bool,
    /// Entries set for supports and multipliers: diagonals of supports, other entries of these rows and columns, diagonals of multipliers.
    identities: Vec<u32>,
    zeros: Vec<u32>,
    diagonals: Vec<u32>,
}

impl Matrix {
    /// Matrix with a pattern, and the solver of a choice; block places are found by [`Self::place`].
    ///
    /// # Errors
    /// The pattern is too large.
    pub fn new(pattern: Pattern, choice: SolverChoice, positions: &[f64], workers: &Workers) -> Result<Self, LinearError> {
        let solver = solver_of(choice, &pattern, positions, workers)?;
        Ok(Matrix { pattern, solver, generation: 0, is_stale: false, identities: Vec::new(), zeros: Vec::new(), diagonals: Vec::new() })
    }

    /// Takes another pattern.
    ///
    /// # Errors
    /// The pattern is too large.
    pub fn renew(&mut self, pattern: Pattern) -> Result<(), LinearError> {
        self.pattern = pattern;
        self.solver.analyse(&self.pattern)?;
        self.generation += 1;
        self.is_stale = false;
        Ok(())
    }

    /// Finds the matrix positions of supports and multipliers.
    pub fn place<const D: usize>(&mut self, fixed: &[bool], multipliers: usize) {
        let (pattern, nodes) = (&self.pattern, fixed.len() / D);
        self.diagonals = (nodes..nodes + multipliers).map(|v| pattern.block(v as u32, v as u32).start).collect();
        (self.identities, self.zeros) = Default::default();
        for (unknown, _) in fixed.iter().enumerate().filter(|(_, fixed)| **fixed) {
            let (node, i) = ((unknown / D) as u32, unknown % D);
            for &other in pattern.neighbors(unknown / D) {
                let (row, column) = (pattern.block(node, other), pattern.block(other, node));
                for k in 0..pattern.size(other as usize) {
                    self.zeros.push(row.at(i, k) as u32);
                    self.zeros.push(column.at(k, i) as u32);
                }
            }
            self.identities.push(pattern.block(node, node).at(i, i) as u32);
        }
    }

    /// Writes the diagonals of the multipliers, and `identity` in place of supported unknowns.
    pub fn finish(&self, rows: &ConstraintRows, identity: f64, values: &mut [f64]) {
        for (place, row) in self.diagonals.iter().zip(&rows.0) {
            values[*place as usize] = row.diagonal;
        }
        for &place in &self.zeros {
            values[place as usize] = 0.0;
        }
        for &place in &self.identities {
            values[place as usize] = identity;
        }
    }
}

/// Pattern of the couplings of all force elements and pairs. A multiplier is eliminated after its anchor: its secondary node, if free and
/// not the anchor for another pair.
pub fn pattern_of<'a, const D: usize>(
    fixed: &[bool],
    multipliers: usize,
    parts: impl Iterator<Item = &'a dyn Part>,
    pairs: &[ContactPair],
) -> Pattern {
    let nodes = fixed.len() / D;
    let mut vertices = vec![Vertex::coordinates(D as u8); nodes];
    vertices.resize(nodes + multipliers, Vertex::multipliers(1));
    // In the plane, scaling for dependent nodes has no effect: few constraints act on one body.
    for pair in pairs.iter().filter(|pair| D == 3 && pair.kind == PairKind::Rigidity) {
        pair.kernel.row_nodes().iter().for_each(|&node| vertices[node as usize] = Vertex::carried(D as u8));
    }
    // One array for all groups of nodes, as many as cells.
    let (mut members, mut ends) = (Vec::new(), vec![0]);
    let mut add = |clique: &[u32]| {
        members.extend_from_slice(clique);
        ends.push(members.len());
    };
    parts.for_each(|part| part.for_each_coupling(&mut add));
    pairs.iter().for_each(|pair| pair.for_each_coupling(nodes, &mut add));
    let mut taken: Vec<bool> = fixed.chunks_exact(D).map(|components| components.contains(&true)).collect();
    let mut anchors = Vec::with_capacity(multipliers);
    // Nodes that follow the masters of a rigid body have no mass: their constraints precede the contact constraints at these nodes.
    let (carrying, others): (Vec<&ContactPair>, Vec<&ContactPair>) = pairs.iter().partition(|pair| pair.kind == PairKind::Rigidity);
    for pair in carrying.into_iter().chain(others) {
        // Several constraints of one node have different directions.
        let rows: Vec<usize> = pair.rows.clone().collect();
        for (rows, &node) in rows.chunks_exact(pair.kernel.rows_per_node()).zip(pair.kernel.row_nodes()) {
            if !std::mem::replace(&mut taken[node as usize], true) {
                anchors.extend(rows.iter().map(|row| ((nodes + row) as u32, node)));
                let groups = pair.friction.iter().flat_map(|friction| rows.iter().flat_map(|row| friction.group(row - pair.rows.start)));
                anchors.extend(groups.map(|row| ((nodes + row) as u32, node)));
            }
        }
    }
    Pattern::new(&vertices, ends.windows(2).map(|ends| &members[ends[0]..ends[1]])).with_anchors(anchors)
}
