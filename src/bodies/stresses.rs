//! Stresses and strains of a body: at quadrature points, as cell means, at nodes, with error estimates.
//!
//! Tensors have the components xx, yy, zz, xy, yz, xz; the stress is the Cauchy stress, the strain the Green-Lagrange strain.

use std::ops::Range;

use super::element_loop::{BodyState, ElementLoop, PointStress};
use super::recovery::Recovery;

/// Stress, strain and history values at a list of positions.
#[derive(Clone, Debug)]
pub struct Stresses {
    /// Cauchy stress `[stress]`.
    pub stress: Vec<[f64; 6]>,
    /// Green-Lagrange strain.
    pub strain: Vec<[f64; 6]>,
    /// Equivalent plastic strain, norm of the back stress `[stress]` and stored energy `[energy/volume]`, then three zeros: six entries, so
    /// that they are averaged like tensors.
    pub kept: Vec<[f64; 6]>,
}

impl Stresses {
    /// Zeros at `count` positions.
    pub fn zeros(count: usize) -> Self {
        Stresses { stress: vec![[0.0; 6]; count], strain: vec![[0.0; 6]; count], kept: vec![[0.0; 6]; count] }
    }

    fn add(&mut self, place: usize, share: f64, point: &PointStress) {
        let add = |sum: &mut [f64; 6], values: &[f64; 6]| sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += share * value);
        add(&mut self.stress[place], &point.stress);
        add(&mut self.strain[place], &point.strain);
        let kept = point.kept.unwrap_or_default();
        add(&mut self.kept[place], &[kept.plastic_strain, kept.back_stress, point.energy, 0.0, 0.0, 0.0]);
    }

    /// Values at the nodes of a body, whose node numbers in the model are `nodes`: recovered from nearby cells for first-order cells,
    /// otherwise extrapolated from the quadrature points of each cell and averaged by volume (Hinton and Campbell, International Journal
    /// for Numerical Methods in Engineering 8, 1974); NaN at nodes without cells.
    pub fn at_nodes<const D: usize>(elements: &dyn ElementLoop<D>, at: BodyState, nodes: Range<usize>, recovery: &Recovery) -> Self {
        let (mut values, mut weight) = (Stresses::zeros(nodes.len()), vec![0.0; nodes.len()]);
        let mut means = Stresses::zeros(elements.cliques().len());
        elements.visit_stresses(at, &mut |point| {
            means.add(point.cell, point.volume / point.cell_volume, point);
            for (&node, factor) in point.nodes.iter().zip(point.extrapolation) {
                let (node, share) = (node as usize - nodes.start, point.cell_volume * factor);
                weight[node] += share;
                values.add(node, share, point);
            }
        });
        let all = [(&mut values.stress, &means.stress), (&mut values.strain, &means.strain), (&mut values.kept, &means.kept)];
        for (values, means) in all {
            values.iter_mut().zip(&weight).for_each(|(value, weight)| *value = value.map(|value| value / weight));
            recovery.recovered(means).for_each(|(node, value)| values[node] = value);
        }
        // Extrapolation makes nonnegative values negative near the border of the plastic zone; they are set to 0.
        values.kept.iter_mut().flatten().for_each(|value| *value = value.max(0.0));
        values
    }
}

/// Difference of the stresses of cells from a continuous stress, as integrals of squares (Zienkiewicz and Zhu, International Journal for
/// Numerical Methods in Engineering 24, 1987).
pub struct StressError {
    /// Integral of the squared stress difference over all cells `[stress^2 volume]`.
    off: f64,
    /// Integral of the squared continuous stress `[stress^2 volume]`.
    size: f64,
    /// Integral of the squared stress difference over the cells at each node, and the volume of these cells.
    at_nodes: Vec<[f64; 2]>,
}

impl StressError {
    /// Returns the stress error of a body whose nodes have the range `nodes` in the model and the stresses `continuous`.
    pub fn new<const D: usize>(elements: &dyn ElementLoop<D>, at: BodyState, nodes: Range<usize>, continuous: &[[f64; 6]]) -> Self {
        let mut error = StressError { off: 0.0, size: 0.0, at_nodes: vec![[0.0; 2]; nodes.len()] };
        elements.visit_stresses(at, &mut |point| {
            let mut smooth = [0.0; 6];
            for (shape, &node) in point.shapes.iter().zip(point.nodes) {
                smooth.iter_mut().zip(continuous[node as usize - nodes.start]).for_each(|(sum, value)| *sum += shape * value);
            }
            let off: [f64; 6] = std::array::from_fn(|k| smooth[k] - point.stress[k]);
            let (off, size) = (point.volume * contracted(&off), point.volume * contracted(&smooth));
            error.off += off;
            error.size += size;
            for &node in point.nodes {
                let [sum, volume] = &mut error.at_nodes[node as usize - nodes.start];
                *sum += off;
                *volume += point.volume;
            }
        });
        error
    }

    /// Relative stress error, `sqrt(off/size)` of the integrals; 0 without stress.
    pub fn relative(&self) -> f64 {
        if self.size > 0.0 { (self.off / self.size).sqrt() } else { 0.0 }
    }

    /// Root mean square of the stress difference over the cells at each node `[stress]`.
    pub fn at_nodes(&self) -> Vec<f64> {
        self.at_nodes.iter().map(|&[off, volume]| if volume > 0.0 { (off / volume).sqrt() } else { 0.0 }).collect()
    }
}

/// Double contraction of a symmetric tensor with itself.
fn contracted(tensor: &[f64; 6]) -> f64 {
    let [direct, shear] = [&tensor[..3], &tensor[3..]].map(|part| part.iter().map(|x| x * x).sum::<f64>());
    direct + 2.0 * shear
}
