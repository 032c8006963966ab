//! Numeric multifrontal LU: every front is assembled from the matrix and its children's updates and eliminated; substitution runs along the
//! tree. Nothing is allocated once all buffers have their size.

use std::collections::TryReserveError;

use super::dense::{self, Blocks, WIDTH};
use super::symbolic::{Front, Run, Symbolic};
use crate::math::simd::{Kernel, dispatch};

/// Pivots below this, in a matrix scaled to entries of order one, are replaced by [`dense::REPLACEMENT`].
const TINY: f64 = 1e-10;

/// Numbers in a cache line.
const LINE: usize = 8;

/// Numbers that begin at a cache line.
#[derive(Debug, Default)]
struct AlignedBuffer {
    storage: Vec<f64>,
    offset: usize,
    length: usize,
}

impl AlignedBuffer {
    /// Makes room for at least `length` numbers, whose values are lost.
    fn resize(&mut self, length: usize) -> Result<(), TryReserveError> {
        if self.storage.len() < length + LINE {
            let mut storage = Vec::new();
            storage.try_reserve_exact(length + LINE)?;
            storage.resize(length + LINE, 0.0);
            self.offset = storage.as_ptr().align_offset(LINE * size_of::<f64>()).min(LINE);
            self.storage = storage;
        }
        self.length = length;
        Ok(())
    }

    fn all(&self) -> &[f64] {
        &self.storage[self.offset..][..self.length]
    }

    fn all_mut(&mut self) -> &mut [f64] {
        &mut self.storage[self.offset..][..self.length]
    }
}

/// The factors of a matrix, and room to compute them.
#[derive(Debug, Default)]
pub(super) struct Multifrontal {
    factors: AlignedBuffer,
    /// Per pivot, the row of its front that was exchanged with it.
    swaps: Vec<u32>,
    stack: AlignedBuffer,
    rows: Vec<[f64; WIDTH]>,
    /// Places in the order of elimination whose pivots were replaced.
    replaced: Vec<u32>,
    /// The vector in the order of elimination, and its part at a front.
    ordered: Vec<f64>,
    at_front: AlignedBuffer,
}

impl Multifrontal {
    /// Makes room for the factors of a structure.
    pub(super) fn reserve(&mut self, symbolic: &Symbolic) -> Result<(), TryReserveError> {
        self.factors.resize(symbolic.factors)?;
        self.stack.resize(symbolic.stack)?;
        self.at_front.resize(symbolic.largest)?;
        self.swaps.resize(symbolic.unknowns.len(), 0);
        self.replaced.clear();
        Ok(())
    }

    /// Factors `diag(scale) A diag(scale)`, with one scale per vertex; room was made before.
    pub(super) fn factorize(&mut self, symbolic: &Symbolic, values: &[f64], scale: &[f64]) {
        self.replaced.clear();
        dispatch(Elimination {
            symbolic,
            values,
            scale,
            factors: self.factors.all_mut(),
            stack: self.stack.all_mut(),
            swaps: &mut self.swaps,
            rows: &mut self.rows,
            replaced: &mut self.replaced,
        });
    }

    /// Places in the order of elimination where no usable pivot was found.
    pub(super) fn replaced(&self) -> &[u32] {
        &self.replaced
    }

    /// `x := A^-1 x`, with one scale per unknown.
    pub(super) fn solve(&mut self, symbolic: &Symbolic, scale: &[f64], x: &mut [f64]) {
        self.ordered.clear();
        self.ordered.extend(symbolic.unknowns.iter().map(|&unknown| scale[unknown as usize] * x[unknown as usize]));
        dispatch(Substitution {
            symbolic,
            factors: self.factors.all(),
            swaps: &self.swaps,
            ordered: &mut self.ordered,
            at_front: self.at_front.all_mut(),
        });
        for (&unknown, value) in symbolic.unknowns.iter().zip(&self.ordered) {
            x[unknown as usize] = scale[unknown as usize] * value;
        }
    }
}

struct Elimination<'a> {
    symbolic: &'a Symbolic,
    values: &'a [f64],
    scale: &'a [f64],
    factors: &'a mut [f64],
    stack: &'a mut [f64],
    swaps: &'a mut [u32],
    rows: &'a mut Vec<[f64; WIDTH]>,
    replaced: &'a mut Vec<u32>,
}

impl Kernel for Elimination<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Elimination { symbolic, values, scale, factors, stack, swaps, rows, replaced } = self;
        let mut top = 0;
        for front in &symbolic.fronts {
            let (p, u) = (front.p, front.u);
            let own = &mut factors[front.factors..][..front.length()];
            own.fill(0.0);
            let (diagonal, beside) = own.split_at_mut(p * p);
            let (lower, upper) = beside.split_at_mut(u * p);
            let (updates, free) = stack.split_at_mut(top);
            let rest = &mut free[..u * u];
            rest.fill(0.0);
            let mut blocks = Blocks { pivots: front.pivots, p, u, diagonal, lower, upper, rest };
            add_entries(symbolic, front, values, scale, &mut blocks);
            let mut bottom = top;
            for &child in symbolic.children[front.children.clone()].iter().rev() {
                let child = &symbolic.fronts[child as usize];
                bottom -= child.u * child.u;
                add_update(symbolic, child, &updates[bottom..], &mut blocks);
            }
            let swaps = &mut swaps[front.first..][..front.pivots];
            blocks.eliminate::<FMA>(TINY, swaps, rows, &mut |k| replaced.push((front.first + k) as u32));
            stack.copy_within(top..top + u * u, bottom);
            top = bottom + u * u;
        }
    }
}

/// Adds the entries of the matrix that belong to a front, and the identity where its pivot block is padded.
#[inline(always)]
fn add_entries(symbolic: &Symbolic, front: &Front, values: &[f64], scale: &[f64], blocks: &mut Blocks) {
    let (p, u) = (blocks.p, blocks.u);
    for k in blocks.pivots..p {
        blocks.diagonal[k * p + k] = 1.0;
    }
    for entry in &symbolic.inside[front.inside.clone()] {
        let factor = scale[entry.row as usize] * scale[entry.column as usize];
        let rows = symbolic.sizes[entry.row as usize] as usize;
        for k in 0..symbolic.sizes[entry.column as usize] as usize {
            let source = &values[entry.source.at(0, k)..][..rows];
            let target = &mut blocks.diagonal[entry.target as usize + k * p..][..rows];
            for (x, value) in target.iter_mut().zip(source) {
                *x = factor * value;
            }
        }
    }
    for entry in &symbolic.beside[front.beside.clone()] {
        let factor = scale[entry.pivot as usize] * scale[entry.other as usize];
        let others = symbolic.sizes[entry.other as usize] as usize;
        for k in 0..symbolic.sizes[entry.pivot as usize] as usize {
            let at = entry.target as usize + k * u;
            let lower = &mut blocks.lower[at..][..others];
            for (x, value) in lower.iter_mut().zip(&values[entry.lower.at(0, k)..][..others]) {
                *x = factor * value;
            }
            let upper = &mut blocks.upper[at..][..others];
            for (i, x) in upper.iter_mut().enumerate() {
                *x = factor * values[entry.upper.at(k, i)];
            }
        }
    }
}

/// Adds a child's update.
#[inline(always)]
fn add_update(symbolic: &Symbolic, child: &Front, update: &[f64], blocks: &mut Blocks) {
    let (p, u) = (blocks.p, blocks.u);
    let (pivots, others) = (&symbolic.runs[child.to_pivots.clone()], &symbolic.runs[child.to_others.clone()]);
    for columns in pivots {
        for k in 0..columns.length as usize {
            let source = &update[(columns.source as usize + k) * child.u..][..child.update];
            let column = columns.target as usize + k;
            add_runs(pivots, source, &mut blocks.diagonal[column * p..][..p]);
            add_runs(others, source, &mut blocks.lower[column * u..][..u]);
        }
    }
    for columns in others {
        for k in 0..columns.length as usize {
            let source = &update[(columns.source as usize + k) * child.u..][..child.update];
            let column = columns.target as usize + k;
            for run in pivots {
                let rows = blocks.upper[run.target as usize * u + column..].iter_mut().step_by(u);
                for (x, value) in rows.zip(&source[run.source as usize..][..run.length as usize]) {
                    *x += value;
                }
            }
            add_runs(others, source, &mut blocks.rest[column * u..][..u]);
        }
    }
}

/// Adds runs of `source` to where they go in `target`.
#[inline(always)]
fn add_runs(runs: &[Run], source: &[f64], target: &mut [f64]) {
    for run in runs {
        let length = run.length as usize;
        let (sources, source_rest) = source[run.source as usize..][..length].as_chunks::<WIDTH>();
        let (targets, target_rest) = target[run.target as usize..][..length].as_chunks_mut::<WIDTH>();
        for (x, value) in targets.iter_mut().zip(sources) {
            for l in 0..WIDTH {
                x[l] += value[l];
            }
        }
        for (x, value) in target_rest.iter_mut().zip(source_rest) {
            *x += value;
        }
    }
}

struct Substitution<'a> {
    symbolic: &'a Symbolic,
    factors: &'a [f64],
    swaps: &'a [u32],
    ordered: &'a mut [f64],
    at_front: &'a mut [f64],
}

impl Kernel for Substitution<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Substitution { symbolic, factors, swaps, ordered, at_front } = self;
        for front in &symbolic.fronts {
            let (pivots, others) = at_front[..front.p + front.u].split_at_mut(front.p);
            let own = &mut ordered[front.first..][..front.pivots];
            for (k, &other) in swaps[front.first..][..front.pivots].iter().enumerate() {
                own.swap(k, other as usize);
            }
            let (inside, padding) = pivots.split_at_mut(front.pivots);
            inside.copy_from_slice(own);
            padding.fill(0.0);
            others.fill(0.0);
            let factors = &factors[front.factors..][..front.length()];
            let (diagonal, beside) = factors.split_at(front.p * front.p);
            dense::substitute_lower::<FMA>(diagonal, &beside[..front.u * front.p], pivots, others);
            own.copy_from_slice(&pivots[..front.pivots]);
            for (&row, value) in symbolic.rows[front.rows.clone()].iter().zip(&*others) {
                ordered[row as usize] += value;
            }
        }
        for front in symbolic.fronts.iter().rev() {
            let (pivots, others) = at_front[..front.p + front.u].split_at_mut(front.p);
            let (known, padding) = others.split_at_mut(front.update);
            for (&row, value) in symbolic.rows[front.rows.clone()].iter().zip(known) {
                *value = ordered[row as usize];
            }
            padding.fill(0.0);
            let own = &mut ordered[front.first..][..front.pivots];
            let (inside, padding) = pivots.split_at_mut(front.pivots);
            inside.copy_from_slice(own);
            padding.fill(0.0);
            let factors = &factors[front.factors..][..front.length()];
            let (diagonal, beside) = factors.split_at(front.p * front.p);
            dense::substitute_upper::<FMA>(diagonal, &beside[front.u * front.p..], pivots, others);
            own.copy_from_slice(&pivots[..front.pivots]);
        }
    }
}
