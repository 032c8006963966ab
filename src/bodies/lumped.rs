//! Lumped nodal masses, and bounds of the eigenfrequencies of single cells with these masses.
//!
//! No vibration of a body is faster than the fastest vibration of a single cell (Hughes, The Finite Element Method, 1987, section 9.2),
//! which is bounded by norms of `m^-1/2 K_e m^-1/2`.

use super::batch::Batch;
use super::cells::Cells;
use super::element_loop::FastestCell;
use crate::integrators::Lumping;
use crate::math::lanes::WIDTH;

/// Row sum of a cell's mass, relative to the cell mass, below which it counts as zero: corners of straight quadratic triangles have row sum
/// 0, corners of `hex27` 1/216.
const LEAST_ROW_SUM: f64 = 1.0 / 5000.0;

/// Masses of the nodes of eight cells.
type NodalMasses = Vec<[f64; WIDTH]>;

impl<const D: usize, const S: usize, const L: usize, const A: usize, const Q: usize> Cells<D, S, L, A, Q> {
    /// True if the row sums of the mass of every cell are positive, beyond the effect of curved edges and round-off on a zero row sum.
    fn has_positive_row_sums(&self) -> bool {
        self.batches.iter().all(|batch| {
            let masses = self.nodal_masses(batch, true);
            let least = |lane: usize| LEAST_ROW_SUM * masses.iter().map(|mass| mass[lane]).sum::<f64>();
            (0..batch.count).all(|lane| masses.iter().all(|mass| mass[lane] > least(lane)))
        })
    }

    /// True if lumped masses are row sums of the consistent mass matrix; false for its scaled diagonal.
    fn takes_row_sums(&self, lumping: Lumping) -> bool {
        match lumping {
            Lumping::Suitable => self.has_positive_row_sums(),
            Lumping::RowSum => true,
            Lumping::Diagonal => false,
        }
    }

    fn nodal_masses(&self, batch: &Batch<D>, by_row_sums: bool) -> NodalMasses {
        let volumes = self.deform(batch, None).weighed;
        let count = batch.nodes.len();
        let mut masses = vec![[0.0; WIDTH]; count];
        for lane in 0..WIDTH {
            let entries = self.mass_products(batch, &volumes, lane);
            let whole: f64 = entries.iter().sum();
            let trace: f64 = (0..count).map(|a| entries[a * count + a]).sum();
            for (a, mass) in masses.iter_mut().enumerate() {
                let row = &entries[a * count..][..count];
                let share = if by_row_sums { row.iter().sum() } else { row[a] * whole / trace };
                mass[lane] = self.physics.density * share;
            }
        }
        masses
    }

    /// Implements [`ElementLoop::add_lumped_mass`](super::ElementLoop::add_lumped_mass).
    pub(super) fn lump_mass(&self, lumping: Lumping, mass: &mut [f64]) -> bool {
        let (by_row_sums, mut are_positive) = (self.takes_row_sums(lumping), true);
        for (index, batch) in self.batches.iter().enumerate() {
            let masses = self.nodal_masses(batch, by_row_sums);
            for lane in 0..batch.count {
                for (&node, own) in self.nodes(index, lane).iter().zip(&masses) {
                    mass[node as usize] += own[lane];
                    are_positive &= own[lane] > 0.0;
                }
            }
        }
        are_positive
    }

    /// Implements [`ElementLoop::fastest_cell`](super::ElementLoop::fastest_cell).
    pub(super) fn find_fastest(&self, lumping: Lumping, u: &[f64]) -> FastestCell {
        let by_row_sums = self.takes_row_sums(lumping);
        let mut fastest = FastestCell { cell: 0, frequency_squared: 0.0 };
        for (index, batch) in self.batches.iter().enumerate() {
            let (stiffness, masses) = (self.stiffness(index, u), self.nodal_masses(batch, by_row_sums));
            for lane in 0..batch.count {
                let (mut squares, mut largest) = (0.0, 0.0f64);
                for (a, i) in (0..masses.len()).flat_map(|a| (0..D).map(move |i| (a, i))) {
                    let mut sum = 0.0;
                    for (b, k) in (0..masses.len()).flat_map(|b| (0..D).map(move |k| (b, k))) {
                        let entry = stiffness[b][k][a][i].0[lane] / (masses[a][lane] * masses[b][lane]).sqrt();
                        squares += entry * entry;
                        sum += entry.abs();
                    }
                    largest = largest.max(sum);
                }
                let bound = largest.min(squares.sqrt());
                if bound > fastest.frequency_squared {
                    fastest = FastestCell { cell: index * WIDTH + lane, frequency_squared: bound };
                }
            }
        }
        fastest
    }
}
