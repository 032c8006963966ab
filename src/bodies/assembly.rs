//! Assembly of the element loop: forces and tangents of batches of cells, added to sums over the nodes of the model or kept per cell.
//!
//! One kernel serves both, because it contains all the mechanics of a cell kind: it is the largest function of the program, and it is
//! compiled for each number of nodes and points that kinds have room for.

use std::ops::Range;

use super::cells::{Cells, PlacedRun};
use super::element_loop::{Inverted, Step};
use super::workspace::Workspace;
use crate::integrators::Derivative;
use crate::linear::Block;
use crate::math::lanes::{Lanes, WIDTH};
use crate::math::simd::{Kernel, dispatch};

/// Derivatives of forces on nodes of eight cells, as [`Workspace::tangent`].
pub(super) type Tangent<const D: usize, const A: usize> = [[[[Lanes<false>; D]; A]; D]; A];

/// Copies a tangent, block by block: the compiler would make a whole copy of it on the stack.
#[inline(always)]
fn copy<const FMA: bool, const D: usize, const A: usize>(count: usize, from: &[[[[Lanes<FMA>; D]; A]; D]; A], to: &mut Tangent<D, A>) {
    for b in 0..count {
        for k in 0..D {
            for a in 0..count {
                for i in 0..D {
                    to[b][k][a][i] = Lanes(from[b][k][a][i].0);
                }
            }
        }
    }
}

/// Accumulators for the forces and, if requested, matrix values of a span of nodes.
struct Sums<'a> {
    force: &'a mut [f64],
    values: Option<&'a mut [f64]>,
    first_unknown: usize,
    first_value: usize,
}

/// Destination of what the kernel computes.
enum Target<'a, const D: usize, const A: usize> {
    /// Sums over the nodes of the model.
    Sums(Sums<'a>),
    /// Tangent of the cells of one batch; unchanged if one of them is inverted.
    Cells(&'a mut Tangent<D, A>),
}

/// Force and tangent of a range of batches.
struct Assemble<'a, const D: usize, const S: usize, const L: usize, const A: usize, const Q: usize> {
    cells: &'a Cells<D, S, L, A, Q>,
    step: &'a Step<'a>,
    batches: Range<usize>,
    target: Target<'a, D, A>,
    /// Factor of the geometric stiffness in the tangent: 1, or 0 for the material stiffness only.
    geometric: f64,
}

impl<const D: usize, const S: usize, const L: usize, const A: usize, const Q: usize> Kernel for Assemble<'_, D, S, L, A, Q> {
    /// Fails with the index of the first batch that has an inverted cell.
    type Output = Result<(), usize>;

    #[inline(always)]
    fn run<const FMA: bool>(self) -> Result<(), usize> {
        let Assemble { cells, step, batches, mut target, geometric } = self;
        let with_tangent = !matches!(target, Target::Sums(Sums { values: None, .. }));
        let mut work = Workspace::<FMA, D, S, A, Q>::new(cells.physics.strain, cells.table.counts);
        let mut answer = None;
        for index in batches {
            if !cells.respond(index, step, &mut work, &mut answer, with_tangent.then_some(geometric)) {
                return Err(index);
            }
            match &mut target {
                Target::Sums(sums) => {
                    if let Some(values) = &mut sums.values {
                        cells.scatter_tangent(index, &work, values, sums.first_value);
                    }
                    cells.scatter_force(index, &work, sums);
                }
                Target::Cells(tangent) => copy(cells.table.counts.nodes(), &work.tangent, tangent),
            }
        }
        Ok(())
    }
}

impl<const D: usize, const S: usize, const L: usize, const A: usize, const Q: usize> Cells<D, S, L, A, Q> {
    /// Adds forces and matrix values of a run's cells to its span of nodes; parts without contributions of earlier rounds are zeroed first.
    pub(super) fn assemble_run(
        &self,
        step: &Step,
        placed: &PlacedRun<D>,
        force: &mut [f64],
        mut values: Option<&mut [f64]>,
    ) -> Result<(), Inverted> {
        let PlacedRun { run, values: places, fresh_values } = placed;
        let (first_unknown, first_value) = (run.nodes.start * D, places.start);
        for nodes in &run.fresh {
            force[nodes.start * D - first_unknown..nodes.end * D - first_unknown].fill(0.0);
        }
        if let Some(values) = &mut values {
            for places in fresh_values {
                values[places.start - first_value..places.end - first_value].fill(0.0);
            }
        }
        let sums = Sums { force, values, first_unknown, first_value };
        let batches = run.cells.start / WIDTH..run.cells.end.div_ceil(WIDTH);
        dispatch(Assemble { cells: self, step, batches, target: Target::Sums(sums), geometric: 1.0 }).map_err(|batch| {
            let determinants = self.deform(&self.batches[batch], Some(step.u_1)).smallest_determinants;
            let lane = (0..WIDTH).find(|&lane| determinants[lane].is_nan() || determinants[lane] <= 0.0).unwrap_or_default();
            Inverted { cell: batch * WIDTH + lane, determinant: determinants[lane] }
        })
    }

    /// Adds forces and tangent of a step with `geometric` times the geometric stiffness, for a configuration without inverted cells.
    pub(super) fn add_all(&self, step: &Step, force: &mut [f64], values: Option<&mut [f64]>, geometric: f64) {
        let sums = Sums { force, values, first_unknown: 0, first_value: 0 };
        let _ = dispatch(Assemble { cells: self, step, batches: 0..self.batches.len(), target: Target::Sums(sums), geometric });
    }

    /// Stiffness of the cells of a batch at displacements `u`, with elastic laws in place of those with history variables; zero if one of
    /// the cells is inverted.
    pub(super) fn stiffness(&self, index: usize, u: &[f64]) -> Box<Tangent<D, A>> {
        let step = Step { derivative: Derivative::AT_END, weight: 1.0, inertia: 0.0, u_0: u, u_1: u, history: &[], dt: 0.0 };
        let mut tangent = Box::new([[[[Lanes::ZERO; D]; A]; D]; A]);
        let target = Target::Cells(&mut tangent);
        let _ = dispatch(Assemble { cells: self, step: &step, batches: index..index + 1, target, geometric: 1.0 });
        tangent
    }

    /// Adds the force of the cells of a batch.
    #[inline(always)]
    fn scatter_force<const FMA: bool>(&self, index: usize, work: &Workspace<FMA, D, S, A, Q>, sums: &mut Sums) {
        let (batch, count) = (&self.batches[index], self.table.counts.nodes());
        let nodes = &batch.nodes[..count];
        for lane in 0..batch.count {
            for a in 0..count {
                let force = &mut sums.force[nodes[a][lane] as usize * D - sums.first_unknown..][..D];
                for i in 0..D {
                    force[i] += work.force[a][i].0[lane];
                }
            }
        }
    }

    /// Adds the tangent of a batch's cells to values that start at `first_value`.
    #[inline(always)]
    fn scatter_tangent<const FMA: bool>(&self, index: usize, work: &Workspace<FMA, D, S, A, Q>, values: &mut [f64], first_value: usize) {
        let count = self.table.counts.nodes();
        for lane in 0..self.batches[index].count {
            let (columns, rows) = self.places.of(index * WIDTH + lane, count);
            for b in 0..count {
                let Block { start, stride } = columns[b];
                for k in 0..D {
                    let column = &mut values[start as usize + k * stride as usize - first_value..][..stride as usize];
                    for a in 0..count {
                        let values = &mut column[rows[b * count + a] as usize..][..D];
                        for i in 0..D {
                            values[i] += work.tangent[b][k][a][i].0[lane];
                        }
                    }
                }
            }
        }
    }
}
