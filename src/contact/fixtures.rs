//! Surfaces and measures for the tests of several contact kernels.

use super::{ContactKernel, Evaluation, Patches};
use crate::integrators::Derivative;

pub fn evaluated(kernel: &dyn ContactKernel, derivative: Derivative, q_1: &[f64], lambda: &[f64]) -> Evaluation {
    let mut out = Evaluation::default();
    kernel.evaluate(derivative, q_1, lambda, &mut out);
    stored(&out, kernel.patches())
}

/// Copy of an evaluation with storage for the blocks of all contact elements.
pub fn stored(out: &Evaluation, patches: &Patches) -> Evaluation {
    let mut all = Evaluation::default();
    all.prepare(patches, out.gap.len());
    (all.gap, all.coverage, all.live) = (out.gap.clone(), out.coverage.clone(), out.live.clone());
    for p in 0..patches.len() {
        let (gradient, tangent) = (out.gradient_range(patches, p), out.tangent_range(patches, p));
        let from = [(&out.gradient_end, gradient.clone()), (&out.gradient_bar, gradient), (&out.tangent, tangent)];
        let to = [
            &mut all.gradient_end[patches.gradient_range(p)],
            &mut all.gradient_bar[patches.gradient_range(p)],
            &mut all.tangent[patches.tangent_range(p)],
        ];
        for ((blocks, range), to) in from.into_iter().zip(to) {
            to.iter_mut().zip(&blocks[range]).for_each(|(to, from)| *to = *from);
        }
    }
    all
}

pub fn difference(b: &[f64], a: &[f64]) -> Vec<f64> {
    b.iter().zip(a).map(|(b, a)| b - a).collect()
}

pub fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Gradients `blocks` as one dense row per constraint.
pub(crate) fn dense_rows(kernel: &dyn ContactKernel, blocks: &[f64], unknowns: usize) -> Vec<Vec<f64>> {
    dense_rows_of(kernel.patches(), kernel.rows_per_node() * kernel.secondary().nodes().len(), blocks, unknowns)
}

/// Gradients `blocks` of `count` constraints as dense rows, in any dimension.
pub(crate) fn dense_rows_of(patches: &Patches, count: usize, blocks: &[f64], unknowns: usize) -> Vec<Vec<f64>> {
    let (mut rows, d) = (vec![vec![0.0; unknowns]; count], patches.dimension());
    for p in 0..patches.len() {
        let block = &blocks[patches.gradient_range(p)];
        for (&row, part) in patches.rows(p).iter().zip(block.chunks_exact(patches.unknowns(p))) {
            for (i, value) in part.iter().enumerate() {
                rows[row as usize][d * patches.nodes(p)[i / d] as usize + i % d] += value;
            }
        }
    }
    rows
}

/// Product of the assembled tangent blocks with a direction: the directional derivative of the forces.
pub(crate) fn tangent_along(patches: &Patches, tangent: &[f64], direction: &[f64]) -> Vec<f64> {
    let (mut change, d) = (vec![0.0; direction.len()], patches.dimension());
    for p in 0..patches.len() {
        let (nodes, width) = (patches.nodes(p), patches.unknowns(p));
        let place = |i: usize| d * nodes[i / d] as usize + i % d;
        for (entry, value) in tangent[patches.tangent_range(p)].iter().enumerate() {
            change[place(entry / width)] += value * direction[place(entry % width)];
        }
    }
    change
}

/// Largest resultant force and moment (about the origin, arms `q`) of constraint gradients in the plane, each taken as nodal forces.
pub(crate) fn unbalance(rows: &[Vec<f64>], q: &[f64]) -> f64 {
    rows.iter().fold(0.0, |largest: f64, row| {
        let force = |axis: usize| row.iter().skip(axis).step_by(2).sum::<f64>();
        let moment: f64 = row.chunks_exact(2).zip(q.chunks_exact(2)).map(|(f, x)| x[0] * f[1] - x[1] * f[0]).sum();
        largest.max(force(0).abs()).max(force(1).abs()).max(moment.abs())
    })
}

/// Two polygons, one inside the other; `q` begins with the nodes of the inner one.
pub struct Rings {
    pub inner: Vec<[u32; 2]>,
    pub outer: Vec<[u32; 2]>,
    pub q: Vec<f64>,
}

pub fn rings(inner: u32, outer: u32, clearance: f64) -> Rings {
    let circle = |count: u32, radius: f64| {
        (0..count).flat_map(move |i| {
            let angle = std::f64::consts::TAU * f64::from(i) / f64::from(count);
            [radius * angle.cos(), radius * angle.sin()]
        })
    };
    Rings {
        inner: (0..inner).map(|i| [i, (i + 1) % inner]).collect(),
        outer: (0..outer).map(|i| [inner + (i + 1) % outer, inner + i]).collect(),
        q: circle(inner, 1.0).chain(circle(outer, 1.0 + clearance)).collect(),
    }
}

/// Positions `q` with the first `count` nodes rotated about the origin, and all nodes perturbed by up to `shake`.
pub fn turned(q: &[f64], count: usize, angle: f64, shake: f64) -> Vec<f64> {
    let (sin, cos) = angle.sin_cos();
    let mut result = q.to_vec();
    for (node, x) in result.chunks_exact_mut(2).enumerate() {
        if node < count {
            (x[0], x[1]) = (cos * x[0] - sin * x[1], sin * x[0] + cos * x[1]);
        }
        // Bounded numbers without a pattern.
        x[0] += shake * (12.9898 * node as f64).sin();
        x[1] += shake * (78.233 * node as f64).cos();
    }
    result
}
