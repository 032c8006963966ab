//! Saddle-point matrices as in contact problems, for tests and benchmarks: cells with coupled nodes, unsymmetric perturbations, and
//! multipliers that tie nodes.

use super::{Pattern, Vertex};

/// Reproducible pseudorandom numbers between -1/2 and 1/2 (xorshift).
pub struct Noise(u64);

impl Noise {
    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }
}

impl Default for Noise {
    fn default() -> Self {
        Noise(88_172_645_463_325_252)
    }
}

/// A matrix with its pattern; vertices from `nodes` on are multipliers.
pub struct System {
    pub pattern: Pattern,
    pub values: Vec<f64>,
    pub nodes: usize,
}

/// Saddle-point matrix: nodes with `D` unknowns coupled by cells, and a multiplier for each list of `(node, weight)`, anchored at the first
/// node of the list. Matrix entries are perturbed by up to half of `disturbance`, constraint entries by a hundredth of that.
pub fn saddle_point<const D: usize>(nodes: usize, cells: &[Vec<u32>], constraints: &[Vec<(u32, f64)>], disturbance: f64) -> System {
    let mut noise = Noise::default();
    let mut vertices = vec![Vertex::coordinates(D as u8); nodes];
    vertices.resize(nodes + constraints.len(), Vertex::multipliers(1));
    let multiplier = |m: usize| (nodes + m) as u32;
    let couplings: Vec<[u32; 2]> =
        constraints.iter().enumerate().flat_map(|(m, row)| row.iter().map(move |(node, _)| [*node, multiplier(m)])).collect();
    let cliques = cells.iter().map(|cell| &cell[..]).chain(couplings.iter().map(|pair| &pair[..]));
    let pattern = Pattern::new(&vertices, cliques).with_anchors(constraints.iter().enumerate().map(|(m, row)| (multiplier(m), row[0].0)));
    let mut values = vec![0.0; pattern.values()];
    for cell in cells {
        let count = cell.len() as f64;
        for &a in cell {
            for &b in cell {
                let block = pattern.block(a, b);
                for i in 0..D {
                    for k in 0..D {
                        // A multiple of the graph's Laplacian with coupled components, plus a little mass.
                        let value = match (a == b, i == k) {
                            (true, true) => count - 1.0 + 0.2,
                            (false, true) => -1.0,
                            (true, false) => 0.3,
                            (false, false) => -0.3 / (count - 1.0),
                        };
                        values[block.at(i, k)] += 1e5 * value * (1.0 + disturbance * noise.next());
                    }
                }
            }
        }
    }
    for (m, row) in constraints.iter().enumerate() {
        for &(node, weight) in row {
            for i in 0..D {
                let entry = weight * (1.0 + 0.3 * i as f64);
                values[pattern.block(multiplier(m), node).at(0, i)] = entry * (1.0 + 0.02 * noise.next());
                values[pattern.block(node, multiplier(m)).at(i, 0)] = -entry * (1.0 + 0.02 * noise.next());
            }
        }
    }
    System { pattern, values, nodes }
}
