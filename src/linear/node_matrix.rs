//! Symmetric scalar matrix on the nodes, equal for all components: the consistent mass matrix.

use super::pattern::Pattern;

/// Compressed rows of a scalar matrix between nodes; `M (x) I_D` on the unknowns.
#[derive(Clone, Debug)]
pub struct NodeMatrix {
    starts: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f64>,
}

impl NodeMatrix {
    /// Zero matrix with the couplings of the first `nodes` vertices of a pattern.
    pub fn new(pattern: &Pattern, nodes: usize) -> Self {
        let mut starts = vec![0];
        let mut columns = Vec::new();
        for node in 0..nodes {
            columns.extend(pattern.neighbors(node).iter().copied().filter(|&other| (other as usize) < nodes));
            starts.push(columns.len());
        }
        NodeMatrix { starts, values: vec![0.0; columns.len()], columns }
    }

    /// Returns a diagonal matrix.
    pub fn diagonal(values: Vec<f64>) -> Self {
        NodeMatrix { starts: (0..=values.len()).collect(), columns: (0..values.len() as u32).collect(), values }
    }

    /// Adds to entry `(row, column)`.
    ///
    /// # Panics
    /// When the two nodes are not coupled.
    pub fn add(&mut self, row: u32, column: u32, value: f64) {
        let range = self.starts[row as usize]..self.starts[row as usize + 1];
        let place = self.columns[range.clone()].binary_search(&column).expect("the nodes are coupled in the pattern");
        self.values[range.start + place] += value;
    }

    /// `y = (M (x) I_D) x`.
    pub fn multiply_into<const D: usize>(&self, x: &[f64], y: &mut [f64]) {
        for (node, y) in y.chunks_exact_mut(D).enumerate() {
            let mut sum = [0.0; D];
            for k in self.starts[node]..self.starts[node + 1] {
                let (other, value) = (self.columns[k] as usize * D, self.values[k]);
                for i in 0..D {
                    sum[i] += value * x[other + i];
                }
            }
            y.copy_from_slice(&sum);
        }
    }

    /// Row sums, which are the lumped nodal masses.
    pub fn row_sums(&self) -> Vec<f64> {
        self.starts.windows(2).map(|range| self.values[range[0]..range[1]].iter().sum()).collect()
    }

    /// All entries `(row, column, value)`.
    pub fn entries(&self) -> impl Iterator<Item = (u32, u32, f64)> + '_ {
        (0..self.starts.len() - 1)
            .flat_map(move |row| (self.starts[row]..self.starts[row + 1]).map(move |k| (row as u32, self.columns[k], self.values[k])))
    }
}
