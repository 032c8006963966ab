//! Redundant constraints, which depend on others and on supports: they would make the matrix singular and are excluded from all steps.
//!
//! Redundant constraints of ties and joints are found by elimination at rest without the supported unknowns: where a tie ends on a support
//! of both sides, or where two ties join equal surfaces. Constraints of obstacles at a node fixed by joints in all directions are
//! redundant, too: the joint then carries the force of the obstacle.

use std::collections::{BTreeMap, BTreeSet};

use super::constraint_rows::ConstraintRows;
use super::equations::Equations;
use crate::bodies::{Elements, Space};
use crate::contact::Evaluation;
use crate::dynamics::parts::contact_pair::{ContactPair, PairKind};
use crate::dynamics::parts::laws::Equation;
use crate::integrators::Derivative;
use crate::math::tolerances::{DEPENDENT, NEGLIGIBLE_ENTRY, ZERO_ROW};

/// Constraint gradient by unknowns.
type Row = BTreeMap<usize, f64>;

impl<const D: usize> Equations<D> {
    /// True for each constraint that depends on earlier constraints of ties and joints, and on supports.
    pub fn redundant_rows(&self) -> Vec<bool> {
        let mut redundant = vec![false; self.multipliers];
        if self.pairs.iter().all(|pair| !pair.kind.is_bilateral()) {
            return redundant;
        }
        let mut of_one_node: BTreeMap<u32, usize> = BTreeMap::new();
        self.eliminate(&self.nodes.reference, |pair, number, rest| {
            let Some(rest) = rest else {
                redundant[number] = true;
                return;
            };
            let node = rest.keys().next().map_or(0, |unknown| unknown / D);
            if pair.kind == PairKind::Joint && rest.keys().all(|other| other / D == node) {
                *of_one_node.entry(node as u32).or_default() += 1;
            }
        });
        let is_fixed = |(&node, &rows): (&u32, &usize)| (rows >= self.supports.free_components::<D>(node)).then_some(node);
        self.drop_obstacles_at(&of_one_node.iter().filter_map(is_fixed).collect(), &mut redundant);
        redundant
    }

    /// Eliminates the constraints of ties and joints at the positions `q`; `visit` gets each constraint with its remainder, or `None` for
    /// one that depends on earlier ones and on supports.
    fn eliminate(&self, q: &[f64], mut visit: impl FnMut(&ContactPair, usize, Option<&Row>)) -> Elimination<'_> {
        let mut elimination = Elimination::new(&self.supports.fixed);
        for pair in self.pairs.iter().filter(|pair| pair.kind.is_bilateral() && pair.law.is_bilateral()) {
            let mut evaluation = Evaluation::default();
            pair.kernel.evaluate(Derivative::AT_END, q, &vec![0.0; pair.rows.len()], &mut evaluation);
            // Nodes that are not tied may have entries of round-off, which would be taken for pivots.
            let is_covered = |(number, _): &(usize, Row)| evaluation.coverage[number - pair.rows.start] > ZERO_ROW;
            for (number, row) in self.rows_of(pair, &evaluation).into_iter().filter(is_covered) {
                visit(pair, number, elimination.take(row).as_ref());
            }
        }
        elimination
    }

    /// True for each active constraint of ties, joints and bilateral contacts that is independent of earlier ones, among pairs selected by
    /// `takes`. Bilateral contacts at more nodes of a rigid body than it has motions are dependent.
    pub fn bilateral_rows(&self, evaluations: &[Evaluation], takes: impl Fn(&ContactPair) -> bool) -> Vec<bool> {
        let mut holds = vec![false; self.multipliers];
        let pairs = || self.pairs.iter().zip(evaluations).filter(|(pair, _)| pair.law.is_bilateral() && takes(pair));
        let needs_elimination = pairs().any(|(pair, _)| !pair.kind.is_bilateral());
        let mut elimination = Elimination::new(&self.supports.fixed);
        for (pair, evaluation) in pairs() {
            for (row, coverage) in pair.rows.clone().zip(&evaluation.coverage) {
                holds[row] = !self.redundant[row] && *coverage > ZERO_ROW;
            }
            if needs_elimination {
                for (number, row) in self.rows_of(pair, evaluation) {
                    holds[number] = holds[number] && elimination.take(row).is_some();
                }
            }
        }
        holds
    }

    /// Opens each constraint without compliance (`diagonal`) that depends on earlier ones and on supports, such as friction that sticks in
    /// the joint of a taut cable. The normal constraints of contacts between surfaces are independent.
    pub fn open_dependent_rows(&self, [pairs, slips]: [&[Evaluation]; 2], rows: &mut ConstraintRows) {
        let is_held = |row: usize| rows.0[row].acts && rows.0[row].diagonal == 0.0;
        if self.pairs.iter().all(|pair| pair.kind == PairKind::Surfaces && pair.friction.is_none()) {
            return;
        }
        let mut gradients: BTreeMap<usize, Row> = BTreeMap::new();
        self.for_each_end_gradient([pairs, slips], |_, row, unknown, entry| {
            if is_held(row) {
                *gradients.entry(row).or_default().entry(unknown).or_insert(0.0) += entry;
            }
        });
        let mut elimination = Elimination::new(&self.supports.fixed);
        for (row, gradient) in gradients {
            if elimination.take(gradient).is_none() {
                rows.0[row] = Equation::OPEN;
            }
        }
    }

    /// Stop or cable whose gap at the positions `q` is at most `near` of its size, and whose coordinate constraints and supports determine.
    pub fn determined_stop(&self, q: &[f64], near: f64) -> Option<&ContactPair> {
        let is_stop = |pair: &&ContactPair| pair.kind == PairKind::Joint && !pair.law.is_bilateral();
        let closed = self.pairs.iter().filter(is_stop).filter_map(|pair| {
            let mut evaluation = Evaluation::default();
            pair.kernel.evaluate(Derivative::AT_END, q, &vec![0.0; pair.rows.len()], &mut evaluation);
            let is_near = |row: &usize| evaluation.gap[row - pair.rows.start] <= near * pair.kernel.facet_size();
            let rows: Vec<Row> =
                self.rows_of(pair, &evaluation).into_iter().filter(|(number, _)| is_near(number)).map(|(_, row)| row).collect();
            (!rows.is_empty()).then_some((pair, rows))
        });
        let closed: Vec<(&ContactPair, Vec<Row>)> = closed.collect();
        if closed.is_empty() {
            return None;
        }
        let elimination = self.eliminate(q, |_, _, _| {});
        let is_determined = |rows: Vec<Row>| rows.into_iter().any(|row| elimination.remainder(row).1.is_none());
        closed.into_iter().find_map(|(pair, rows)| is_determined(rows).then_some(pair))
    }

    /// True if coordinate constraints and supports determine a normal or tangential constraint at the positions `q`: no free motion changes
    /// its gap or slip.
    pub fn is_determined(&self, constraint: usize, q: &[f64]) -> bool
    where
        Space<D>: Elements<D>,
    {
        let [pairs, slips] = self.evaluated_at(q);
        let mut gradient = Row::new();
        self.for_each_end_gradient([&pairs, &slips], |_, row, unknown, entry| {
            if row == constraint {
                *gradient.entry(unknown).or_insert(0.0) += entry;
            }
        });
        !gradient.is_empty() && self.are_dependent(gradient, q)
    }

    /// True if coordinate constraints and supports carry nodal forces wholly at the positions `q`: they do no work in any free motion.
    pub fn carries(&self, forces: &[f64], q: &[f64]) -> bool {
        let acting = forces.iter().copied().enumerate().filter(|(_, force)| *force != 0.0).collect();
        self.are_dependent(acting, q)
    }

    /// True if a gradient, or forces, are a combination of the gradients of coordinate constraints and of forces on supported unknowns.
    fn are_dependent(&self, gradient: Row, q: &[f64]) -> bool {
        self.eliminate(q, |_, _, _| {}).remainder(gradient).1.is_none()
    }

    /// Marks the constraints of obstacles at these nodes as redundant, with their tangential constraints.
    fn drop_obstacles_at(&self, nodes: &BTreeSet<u32>, redundant: &mut [bool]) {
        for pair in self.pairs.iter().filter(|pair| pair.kind == PairKind::Obstacle) {
            for (local, row) in
                pair.rows.clone().enumerate().filter(|(_, row)| pair.node_of(*row).is_some_and(|node| nodes.contains(&node)))
            {
                redundant[row] = true;
                pair.friction.iter().for_each(|friction| redundant[friction.group(local)].fill(true));
            }
        }
    }

    /// Constraint gradients of a pair by unknown; none for nodes that do not face the other side.
    fn rows_of(&self, pair: &ContactPair, evaluation: &Evaluation) -> BTreeMap<usize, Row> {
        let mut rows: BTreeMap<usize, Row> = BTreeMap::new();
        for row in pair.live_rows(evaluation) {
            let entries = &evaluation.gradient_end[row.gradient.clone()];
            let sums = rows.entry(row.row).or_default();
            for (&node, entries) in row.nodes.iter().zip(entries.chunks_exact(D)) {
                for (i, &entry) in entries.iter().enumerate() {
                    *sums.entry(node as usize * D + i).or_insert(0.0) += entry;
                }
            }
        }
        rows
    }
}

/// Elimination of constraint gradients one after another, without supported unknowns.
struct Elimination<'a> {
    /// True for each supported unknown.
    fixed: &'a [bool],
    /// Remainders by their pivot, the largest unknown, each scaled so that its entry there is 1.
    pivots: BTreeMap<usize, Row>,
}

impl<'a> Elimination<'a> {
    fn new(fixed: &'a [bool]) -> Self {
        Elimination { fixed, pivots: BTreeMap::new() }
    }

    /// Remainder of a constraint gradient without supported unknowns and pivots, and its largest entry; `None` for a dependent constraint.
    fn remainder(&self, mut row: Row) -> (Row, Option<(usize, f64)>) {
        // Size before the removal of supported unknowns: the remaining entries may be round-off.
        let size = row.values().fold(0.0f64, |largest, value| largest.max(value.abs()));
        row.retain(|&unknown, value| !self.fixed[unknown] && value.abs() > NEGLIGIBLE_ENTRY * size);
        let rest = reduced(row, size, &self.pivots);
        let entry = rest.iter().map(|(&unknown, &value)| (unknown, value)).max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        (rest, entry.filter(|(_, value)| value.abs() > DEPENDENT * size))
    }

    /// Makes the remainder of a constraint gradient a pivot, and returns it; `None` for a dependent constraint.
    fn take(&mut self, row: Row) -> Option<Row> {
        let (rest, entry) = self.remainder(row);
        let (unknown, value) = entry?;
        self.pivots.insert(unknown, rest.iter().map(|(&other, &entry)| (other, entry / value)).collect());
        Some(rest)
    }
}

/// Remainder of a constraint gradient after the elimination of all pivot unknowns. Entries below round-off relative to `size` are dropped,
/// since couplings along a surface decay from node to node.
fn reduced(mut row: Row, size: f64, pivots: &BTreeMap<usize, Row>) -> Row {
    while let Some(unknown) = row.keys().copied().find(|unknown| pivots.contains_key(unknown)) {
        let factor = row[&unknown];
        for (&other, &entry) in &pivots[&unknown] {
            *row.entry(other).or_insert(0.0) -= factor * entry;
        }
        row.remove(&unknown);
        row.retain(|_, value| value.abs() > NEGLIGIBLE_ENTRY * size);
    }
    row
}
