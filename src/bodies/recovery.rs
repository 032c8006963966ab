//! Recovery of nodal values from values of nearby first-order cells.
//!
//! Means of four-node and eight-node cells are second-order accurate at the centers, and so are means of two neighboring triangles, whose
//! errors cancel. A linear polynomial is fitted to these samples around each node and evaluated there (superconvergent patch recovery:
//! Zienkiewicz and Zhu, International Journal for Numerical Methods in Engineering 33, 1992). At a surface the few cells at a node do not
//! determine the slope, so that the patch is extended by cells that share nodes with it.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use crate::elements::CellShape;
use crate::math::tolerances::RECOVERY_AMPLIFICATION;
use crate::mesh::Mesh;

/// Largest number of extensions of a patch by the cells that share nodes with it.
const GROWTHS: usize = 3;

/// Factors of nearby cells in the recovered value at each node of a mesh.
pub struct Recovery {
    /// First entry of each node in `cells`; at the end the number of entries.
    starts: Vec<usize>,
    /// Cells of every node, with their weights.
    cells: Vec<(u32, f64)>,
}

impl Recovery {
    /// Recovery factors for the nodes of a mesh; empty for second-order cells.
    pub fn new(mesh: &Mesh) -> Self {
        let mut recovery = Recovery { starts: vec![0], cells: Vec::new() };
        let patches = (!mesh.is_quadratic()).then(|| Patches::new(mesh));
        for node in 0..mesh.points.len() {
            recovery.cells.extend(patches.as_ref().and_then(|patches| patches.factors(node)).unwrap_or_default());
            recovery.starts.push(recovery.cells.len());
        }
        recovery
    }

    /// Recovered values at the nodes that have factors, from values of the cells.
    pub fn recovered<'a>(&'a self, cells: &'a [[f64; 6]]) -> impl Iterator<Item = (usize, [f64; 6])> + 'a {
        self.starts.windows(2).enumerate().filter(|(_, ends)| ends[0] < ends[1]).map(move |(node, ends)| {
            let mut value = [0.0; 6];
            for &(cell, factor) in &self.cells[ends[0]..ends[1]] {
                value.iter_mut().zip(cells[cell as usize]).for_each(|(sum, value)| *sum += factor * value);
            }
            (node, value)
        })
    }
}

/// Mean value of one or two cells, located at the mean of their centers.
struct Sample {
    cells: Vec<u32>,
    place: [f64; 3],
}

/// Mesh, samples and connectivity from which patches are built.
struct Patches<'a> {
    mesh: &'a Mesh,
    /// Cells at each node.
    around: Vec<Vec<u32>>,
    samples: Vec<Sample>,
    /// Indices of the samples whose first cell is the given cell.
    of_cell: Vec<Vec<usize>>,
}

impl<'a> Patches<'a> {
    fn new(mesh: &'a Mesh) -> Self {
        let mut patches = Patches {
            mesh,
            around: vec![Vec::new(); mesh.points.len()],
            samples: Vec::new(),
            of_cell: vec![Vec::new(); mesh.cell_count()],
        };
        let mut facets: BTreeMap<Vec<u32>, u32> = BTreeMap::new();
        for (index, (kind, cell)) in (0u32..).zip(mesh.cells_with_kinds()) {
            cell.iter().for_each(|&node| patches.around[node as usize].push(index));
            let is_wedge = kind.shape() == CellShape::Wedge;
            if !kind.has_one_point() && !is_wedge {
                patches.add_sample(&[index]);
                continue;
            }
            // Wedges are paired across quadrilateral sides, like the triangles of their bases.
            for facet in kind.facets().iter().filter(|facet| !is_wedge || facet.len() == 4) {
                let mut nodes: Vec<u32> = facet.iter().map(|&local| cell[local]).collect();
                nodes.sort_unstable();
                match facets.remove(&nodes) {
                    Some(neighbor) => patches.add_sample(&[neighbor, index]),
                    None => {
                        facets.insert(nodes, index);
                    }
                }
            }
        }
        patches
    }

    fn add_sample(&mut self, cells: &[u32]) {
        let nodes: Vec<u32> = cells.iter().flat_map(|&cell| self.mesh.cell(cell as usize)).copied().collect();
        let mean = |i: usize| nodes.iter().map(|&node| self.mesh.points[node as usize][i]).sum::<f64>() / nodes.len() as f64;
        let place = std::array::from_fn(mean);
        self.of_cell[cells[0] as usize].push(self.samples.len());
        self.samples.push(Sample { cells: cells.to_vec(), place });
    }

    /// Cells with their factors in the recovered value at a node; `None` if no patch determines a slope in every direction, as in a single
    /// layer of cells.
    fn factors(&self, node: usize) -> Option<BTreeMap<u32, f64>> {
        let mut patch = self.around[node].clone();
        for _ in 0..=GROWTHS {
            let is_inside = |sample: &&Sample| sample.cells.iter().all(|cell| patch.binary_search(cell).is_ok());
            let begun = patch.iter().flat_map(|&cell| &self.of_cell[cell as usize]);
            let samples: Vec<&Sample> = begun.map(|&sample| &self.samples[sample]).filter(is_inside).collect();
            if let Some(factors) = self.fitted(node, &samples) {
                let mut sums = BTreeMap::new();
                for (sample, factor) in samples.iter().zip(factors) {
                    let share = factor / sample.cells.len() as f64;
                    sample.cells.iter().for_each(|&cell| *sums.entry(cell).or_insert(0.0) += share);
                }
                return Some(sums);
            }
            patch = self.grown(&patch);
        }
        None
    }

    /// Cells of a patch, extended by all cells that share a node with it, in ascending order.
    fn grown(&self, patch: &[u32]) -> Vec<u32> {
        let nodes = patch.iter().flat_map(|&cell| self.mesh.cell(cell as usize));
        let mut cells: Vec<u32> = nodes.flat_map(|&node| self.around[node as usize].iter().copied()).collect();
        cells.sort_unstable();
        cells.dedup();
        cells
    }

    /// Factors of samples in the nodal value of the least-squares linear polynomial; `None` if they would amplify errors of the samples.
    /// With the matrix `P` of polynomial values at the samples, and polynomials of which only the first is nonzero at the node, the factors
    /// are `P (P^T P)^-1 e_1`, and the sum of their squares is the first entry of `(P^T P)^-1`.
    fn fitted(&self, node: usize, samples: &[&Sample]) -> Option<Vec<f64>> {
        let arm = |sample: &&Sample| -> [f64; 3] { std::array::from_fn(|i| sample.place[i] - self.mesh.points[node][i]) };
        let arms: Vec<[f64; 3]> = samples.iter().map(arm).collect();
        let reach = arms.iter().flatten().fold(0.0f64, |reach, x| reach.max(x.abs()));
        let count = self.mesh.dimension() + 1;
        let values = DMatrix::from_fn(arms.len(), count, |row, k| if k == 0 { 1.0 } else { arms[row][k - 1] / reach });
        let mut first = DVector::zeros(count);
        first[0] = 1.0;
        let coefficients = values.tr_mul(&values).cholesky()?.solve(&first);
        (coefficients[0] <= RECOVERY_AMPLIFICATION).then(|| (values * coefficients).iter().copied().collect())
    }
}
