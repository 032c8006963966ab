//! A node opposite a chain of facets in one step: which nodes of its patch take part, and how their vectors stand in the patch.

use super::chain::{Chain, Measure};
use crate::integrators::Projection;

/// What a patch keeps of the start of the step.
#[derive(Clone, Debug, Default)]
pub struct Start {
    /// Places in the patch of the nodes that take part: the secondary node, and those of the admitted facets, their neighbors and theirs.
    pub places: Vec<u32>,
    /// These facets, in indices of `places`, and which of them may be the closest: not the last ones, which are there for their corners. A
    /// neighbor looks another way, perhaps, but round a sharp corner it is what the node has in front of it.
    pub chain: Chain,
    pub closest: Vec<bool>,
    /// Positions of the nodes that take part.
    pub positions: Vec<f64>,
    pub measures: [Option<Measure>; 2],
    /// The facets of the concave corner that the node is in, each with the end at which they meet and with a row of its own in this step.
    pub pocket: Option<[[u32; 2]; 2]>,
}

/// Storage of one evaluation, used again from patch to patch.
#[derive(Default)]
pub struct Scratch {
    pub end: Vec<f64>,
    pub middle: Vec<f64>,
    pub gradient: Vec<f64>,
    pub gradient_end: Vec<f64>,
    pub bar: Vec<f64>,
    pub hessian: Vec<f64>,
    pub tangent: Vec<f64>,
    pub part: Vec<f64>,
    pub projection: Projection<2>,
}

impl Start {
    /// Positions of the nodes that take part into `z`, `nodes` those of the patch.
    pub fn gather_into(&self, nodes: &[u32], q: &[f64], z: &mut Vec<f64>) {
        z.clear();
        z.extend(self.places.iter().map(|&place| 2 * nodes[place as usize] as usize).flat_map(|x| [q[x], q[x + 1]]));
    }

    /// What measures the gap of each row.
    pub fn measures(&self, z: &[f64]) -> [Option<Measure>; 2] {
        match self.pocket {
            Some(branches) => branches.map(|branch| self.chain.measure_branch(branch, z, &self.closest)),
            None => [self.chain.measure(z, &self.closest), None],
        }
    }

    /// Writes a vector over the nodes that take part as one over all nodes of the patch.
    pub fn spread_into(&self, values: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for (&place, value) in self.places.iter().zip(values.chunks_exact(2)) {
            out[2 * place as usize..][..2].copy_from_slice(value);
        }
    }

    /// Writes a matrix over the nodes that take part as one over all nodes of the patch, row by row.
    pub fn spread_matrix_into(&self, values: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        let (width, own) = (out.len().isqrt(), 2 * self.places.len());
        for (row, values) in values.chunks_exact(own).enumerate() {
            let at = width * (2 * self.places[row / 2] as usize + row % 2);
            for (&place, value) in self.places.iter().zip(values.chunks_exact(2)) {
                out[at + 2 * place as usize..][..2].copy_from_slice(value);
            }
        }
    }
}
