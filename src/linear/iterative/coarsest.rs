//! Coarsest problem: nodes of the last level and all constraints, factorized with the multifrontal LU.

use super::blocks::BlockMatrix;
use super::border::{Border, Scaled};
use super::refusal::Refusal;
use crate::linear::factorization::Factorization;
use crate::linear::pattern::{Pattern, Vertex};
use crate::linear::watch::InterruptWatch;
use crate::math::workers::Workers;

/// Saddle-point matrix `[A B; C D]` of the last level with its factors. Vertices are the rows of `A` and then those of the border.
pub(super) struct Coarsest {
    pattern: Pattern,
    values: Vec<f64>,
    factors: Box<Factorization>,
    vector: Vec<f64>,
}

impl Coarsest {
    /// Factorizes the coarsest matrix together with the border. The last rows of the level are those of the kept nodes.
    pub fn new<const N: usize>(
        level: &BlockMatrix<N, N>,
        scaled: &Scaled,
        border: &Border,
        workers: &Workers,
        watch: &InterruptWatch,
    ) -> Result<Self, Refusal> {
        let rows = level.rows();
        let free = rows - border.kept.len();
        // Kept nodes have `dimension` unknowns; the others of their `N` numbers couple with nothing and are left out.
        let size = |row: usize| if row < free { N } else { N.min(border.dimension) };
        let mut index = vec![None; scaled.pattern.vertices()];
        border.kept.iter().enumerate().for_each(|(k, &v)| index[v as usize] = Some((free + k) as u32));
        border.vertices.iter().enumerate().for_each(|(k, &v)| index[v as usize] = Some((rows + k) as u32));
        let vertices: Vec<Vertex> = (0..rows)
            .map(|row| Vertex::coordinates(size(row) as u8))
            .chain(border.vertices.iter().map(|&v| scaled.pattern.vertex(v as usize)))
            .collect();
        let mut pairs: Vec<[u32; 2]> = Vec::new();
        for row in 0..rows {
            // Blocks may be zero, and left out, on one side of the diagonal alone, as in the rows of prescribed displacements.
            pairs.extend(level.row(row).0.iter().filter(|&&column| column as usize != row).map(|&column| [row as u32, column]));
        }
        for &v in &border.vertices {
            let others = scaled.pattern.neighbors(v as usize).iter().filter(|&&u| u != v && scaled.couples(u, v));
            pairs.extend(others.filter_map(|&u| Some([index[v as usize]?, index[u as usize]?])));
        }
        let anchor = |&v: &u32| Some((index[v as usize]?, index[scaled.pattern.anchor(v as usize)? as usize]?));
        let pattern = Pattern::new(&vertices, pairs.iter().map(|pair| &pair[..])).with_anchors(border.vertices.iter().filter_map(anchor));
        drop(pairs);
        if u32::try_from(pattern.values()).is_err() {
            return Err(Refusal::Unsuited);
        }
        let mut values = vec![0.0; pattern.values()];
        for row in 0..rows {
            let (columns, blocks) = level.row(row);
            for (&column, block) in columns.iter().zip(blocks) {
                let place = pattern.block(row as u32, column);
                for (i, numbers) in block.iter().enumerate().take(size(row)) {
                    numbers.iter().enumerate().take(size(column as usize)).for_each(|(k, number)| values[place.at(i, k)] = *number);
                }
            }
        }
        let mut copy = |[u, v]: [u32; 2]| {
            let (Some(row), Some(column)) = (index[u as usize], index[v as usize]) else { return };
            let Some(place) = pattern.find_block(row, column) else { return };
            let (from, scale) = (scaled.pattern.block(u, v), scaled.scale(u, v));
            for i in 0..scaled.pattern.size(u as usize) {
                for k in 0..scaled.pattern.size(v as usize) {
                    values[place.at(i, k)] = scale * scaled.values[from.at(i, k)];
                }
            }
        };
        for &v in &border.vertices {
            scaled.pattern.neighbors(v as usize).iter().for_each(|&u| [[u, v], [v, u]].into_iter().for_each(&mut copy));
        }
        let factors = Factorization::new(&pattern).map_err(Refusal::Error)?.with_workers(workers);
        let mut coarsest = Coarsest { vector: vec![0.0; pattern.unknowns()], pattern, values, factors: Box::new(factors) };
        coarsest.factors.set_watch(watch.clone());
        coarsest.factors.factorize(&coarsest.values).map_err(Refusal::Error)?;
        Ok(coarsest)
    }

    /// Solves for the right-hand sides of the level and of the border; both become the solution. NaN if the matrix is singular.
    pub fn solve<const N: usize>(&mut self, level: &mut [[f64; N]], border: &mut [f64]) {
        let Coarsest { pattern, values, factors, vector } = self;
        let sizes = |row: usize| pattern.first_unknown(row)..pattern.first_unknown(row + 1);
        for (row, numbers) in level.iter().enumerate() {
            let own = &mut vector[sizes(row)];
            own.copy_from_slice(&numbers[..own.len()]);
        }
        let first = pattern.unknowns() - border.len();
        vector[first..].copy_from_slice(border);
        if factors.solve(values, vector).is_err() {
            vector.fill(f64::NAN);
        }
        for (row, numbers) in level.iter_mut().enumerate() {
            let own = &vector[sizes(row)];
            numbers.fill(0.0);
            numbers[..own.len()].copy_from_slice(own);
        }
        border.copy_from_slice(&vector[first..]);
    }

    /// Bytes of the matrix and its factors.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.values[..]) + self.factors.bytes()
    }
}
