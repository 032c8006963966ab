//! Assembly of a front from its matrix entries and from the update matrices (Schur complements) of its children.

use pulp::{Simd, WithSimd};

use super::fronts::{Front, OffDiagonalBlock, PivotBlock, Run};
use super::panels::Blocks;
use super::pattern::Block;
use super::symbolic::Symbolic;
use super::waiting::UpdateLocation;
use crate::math::simd::with_registers;
use crate::math::workers::Workers;

/// Adds the matrix entries of a front, and the identity in the padding of its pivot block.
#[inline(always)]
pub(super) fn add_entries(symbolic: &Symbolic, front: &Front, values: &[f64], scale: &[f64], blocks: &mut Blocks) {
    let p = blocks.p;
    for k in blocks.pivots..p {
        blocks.diagonal[k * p + k] = 1.0;
    }
    let sizes = &symbolic.sizes;
    for entry in symbolic.places.inside[front.inside.clone()].iter().filter(|entry| entry.source != Block::NOWHERE) {
        let factor = scale[entry.row as usize] * scale[entry.column as usize];
        match (sizes[entry.row as usize], sizes[entry.column as usize]) {
            (2, 2) => add_inside(entry, 2, 2, factor, values, blocks),
            (3, 3) => add_inside(entry, 3, 3, factor, values, blocks),
            (rows, columns) => add_inside(entry, rows as usize, columns as usize, factor, values, blocks),
        }
    }
    for entry in symbolic.places.beside[front.beside.clone()].iter().filter(|entry| entry.lower != Block::NOWHERE) {
        let factor = scale[entry.pivot as usize] * scale[entry.other as usize];
        match (sizes[entry.pivot as usize], sizes[entry.other as usize]) {
            (2, 2) => add_beside(entry, 2, 2, factor, values, blocks),
            (3, 3) => add_beside(entry, 3, 3, factor, values, blocks),
            (pivots, others) => add_beside(entry, pivots as usize, others as usize, factor, values, blocks),
        }
    }
}

/// Adds a block inside the pivot block; inlined for common sizes, so that its loops unroll.
#[inline(always)]
fn add_inside(entry: &PivotBlock, rows: usize, columns: usize, factor: f64, values: &[f64], blocks: &mut Blocks) {
    for k in 0..columns {
        let source = &values[entry.source.at(0, k)..][..rows];
        let target = &mut blocks.diagonal[entry.target as usize + k * blocks.p..][..rows];
        for i in 0..rows {
            target[i] += factor * source[i];
        }
    }
}

/// Adds a block below the pivot block and its transposed counterpart to the right.
#[inline(always)]
fn add_beside(entry: &OffDiagonalBlock, pivots: usize, others: usize, factor: f64, values: &[f64], blocks: &mut Blocks) {
    let target = entry.target as usize;
    for k in 0..pivots {
        let source = &values[entry.lower.at(0, k)..][..others];
        let lower = &mut blocks.lower[target + k * blocks.u..][..others];
        for i in 0..others {
            lower[i] += factor * source[i];
        }
    }
    for i in 0..others {
        let source = &values[entry.upper.at(0, i)..][..pivots];
        for k in 0..pivots {
            blocks.upper[target + k * blocks.u + i] += factor * source[k];
        }
    }
}

/// Number of columns assembled at a time, so that they fit into a fast cache.
const COLUMNS: usize = 32;

/// Number of entries of a front above which threads share its columns.
const WORTH_SHARING: usize = 20_000;

/// Update matrices that a front receives from its children.
#[derive(Clone, Copy)]
pub(super) struct Received<'a> {
    pub(super) symbolic: &'a Symbolic,
    /// Stack locations of the update matrices of all fronts that are not yet assembled into their parents.
    pub(super) places: &'a [(UpdateLocation, usize)],
    pub(super) children: &'a [u32],
    /// Update matrices on the stacks, from index `start` of the buffer on.
    pub(super) waiting: &'a [f64],
    /// Index of the buffer at which `waiting` begins.
    pub(super) start: usize,
    /// Update matrices handed over by other tasks.
    pub(super) handed: &'a [f64],
}

/// Columns of some pivots: in the pivot block, below it and to its right.
struct PivotColumns<'a> {
    first: usize,
    count: usize,
    diagonal: &'a mut [f64],
    lower: &'a mut [f64],
    upper: &'a mut [f64],
}

/// Some columns of the remainder of a front, which becomes its update matrix.
struct RestColumns<'a> {
    first: usize,
    columns: &'a mut [f64],
}

impl<'a> Received<'a> {
    /// Adds the update matrices (Schur complements) of all children to the blocks of the front.
    #[inline(always)]
    pub(super) fn add_up<S: Simd>(self, simd: S, blocks: &mut Blocks, workers: &Workers) {
        let (p, u) = (blocks.p, blocks.u);
        let (mut diagonal, mut lower, mut upper) = (&mut *blocks.diagonal, &mut *blocks.lower, &mut *blocks.upper);
        let pivots = (0..p).step_by(COLUMNS).map(|first| {
            let count = COLUMNS.min(p - first);
            PivotColumns {
                first,
                count,
                diagonal: diagonal.split_off_mut(..count * p).unwrap_or_default(),
                lower: lower.split_off_mut(..count * u).unwrap_or_default(),
                upper: upper.split_off_mut(..count * u).unwrap_or_default(),
            }
        });
        let rest = blocks.rest.chunks_mut((COLUMNS * u).max(1)).enumerate();
        let rest = rest.map(|(k, columns)| RestColumns { first: k * COLUMNS, columns });
        if workers.are_many() && (p + u) * (p + u) >= WORTH_SHARING {
            let (mut pivots, mut rest) = (pivots.collect::<Vec<_>>(), rest.collect::<Vec<_>>());
            workers.for_each(&mut pivots, 1, |_, part| with_registers(AddUp { received: self, part, p, u }));
            workers.for_each(&mut rest, 1, |_, part| with_registers(AddUp { received: self, part, p, u }));
        } else {
            for mut part in pivots {
                self.add_to_pivots(simd, &mut part, p, u);
            }
            for mut part in rest {
                self.add_to_rest(simd, &mut part, u);
            }
        }
    }

    /// Child front and its update matrix.
    #[inline(always)]
    fn update(self, child: u32) -> (&'a Front, &'a [f64]) {
        let ((side, at), child) = (self.places[child as usize], &self.symbolic.fronts[child as usize]);
        let source = if side == UpdateLocation::Handed { &self.handed[at..] } else { &self.waiting[at - self.start..] };
        (child, &source[..child.u * child.u])
    }

    #[inline(always)]
    fn add_to_pivots<S: Simd>(self, simd: S, part: &mut PivotColumns, p: usize, u: usize) {
        let PivotColumns { first, count, diagonal, lower, upper } = part;
        diagonal.fill(0.0);
        lower.fill(0.0);
        upper.fill(0.0);
        for &child in self.children {
            let (child, update) = self.update(child);
            let (pivots, others) =
                (&self.symbolic.places.runs[child.to_pivots.clone()], &self.symbolic.places.runs[child.to_others.clone()]);
            for run in pivots {
                let Some(mine) = run.within(*first, *count) else { continue };
                let columns = &update[mine.source as usize * child.u..][..mine.length as usize * child.u];
                let target = mine.target as usize;
                for rows in pivots {
                    add_run(simd, rows, columns, child.u, &mut diagonal[target * p..], p);
                }
                for rows in others {
                    add_run(simd, rows, columns, child.u, &mut lower[target * u..], u);
                }
                for columns in others {
                    let source = &update[columns.source as usize * child.u..][..columns.length as usize * child.u];
                    for i in 0..mine.length as usize {
                        let target = &mut upper[(target + i) * u + columns.target as usize..][..columns.length as usize];
                        for (x, source) in target.iter_mut().zip(source[mine.source as usize + i..].iter().step_by(child.u)) {
                            *x += source;
                        }
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn add_to_rest<S: Simd>(self, simd: S, part: &mut RestColumns, u: usize) {
        part.columns.fill(0.0);
        for &child in self.children {
            let (child, update) = self.update(child);
            let others = &self.symbolic.places.runs[child.to_others.clone()];
            for run in others {
                let Some(mine) = run.within(part.first, COLUMNS) else { continue };
                let columns = &update[mine.source as usize * child.u..][..mine.length as usize * child.u];
                for rows in others {
                    add_run(simd, rows, columns, child.u, &mut part.columns[mine.target as usize * u..], u);
                }
            }
        }
    }
}

/// Columns of a front to which [`Received`] is added, divided among threads.
struct AddUp<'a, P> {
    received: Received<'a>,
    part: P,
    p: usize,
    u: usize,
}

impl WithSimd for AddUp<'_, &mut PivotColumns<'_>> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.received.add_to_pivots(simd, self.part, self.p, self.u);
    }
}

impl WithSimd for AddUp<'_, &mut RestColumns<'_>> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.received.add_to_rest(simd, self.part, self.u);
    }
}

/// Adds a contiguous run of rows of some columns of an update matrix to the corresponding rows of the parent front.
#[inline(always)]
fn add_run<S: Simd>(simd: S, rows: &Run, source: &[f64], source_stride: usize, target: &mut [f64], target_stride: usize) {
    let (length, from, to) = (rows.length as usize, rows.source as usize, rows.target as usize);
    for (source, target) in source.chunks_exact(source_stride).zip(target.chunks_mut(target_stride)) {
        let (sources, source_rest) = S::as_simd_f64s(&source[from..from + length]);
        let (targets, target_rest) = S::as_mut_simd_f64s(&mut target[to..to + length]);
        for (x, value) in targets.iter_mut().zip(sources) {
            *x = simd.add_f64s(*x, *value);
        }
        for (x, value) in target_rest.iter_mut().zip(source_rest) {
            *x += value;
        }
    }
}
