//! Lanczos' method for the eigenvalues of largest magnitude of an operator that is symmetric in an inner product, with full
//! reorthogonalization.
//!
//! For `K x = lambda M x` the operator is `(K - sigma M)^-1 M`, symmetric in the product `x^T M y`, and its eigenvalues are `theta =
//! 1/(lambda - sigma)`: those next to the shift are found first and well separated (Ericsson and Ruhe, Math. Comp. 35, 1980). The iteration
//! starts from a block of vectors, because a single vector finds only one vector of each multiple eigenvalue. A caller that finds
//! eigenvalues missing restarts the iteration with a further vector in the existing space.

use nalgebra::DMatrix;

use crate::math::tolerances::LANCZOS_DEPENDENT;

/// Number of orthogonalization passes: twice is enough (Kahan; Parlett, The Symmetric Eigenvalue Problem, 1980).
const PASSES: usize = 2;

/// Operator of the Lanczos iteration.
pub trait Operator {
    /// Error of the linear solver.
    type Error;

    /// Solves with the shifted matrix: `(K - sigma M)^-1 image`.
    ///
    /// # Errors
    /// Error of the linear solver.
    fn solve(&mut self, image: Vec<f64>) -> Result<Vec<f64>, Self::Error>;

    /// Returns `M v`; the operator is symmetric in the inner product `x^T M y`.
    fn mass_times(&self, v: &[f64]) -> Vec<f64>;

    /// Right-hand side of the solve for a vector `v`; for vibrations `M v`.
    fn image(&self, v: &[f64]) -> Vec<f64> {
        self.mass_times(v)
    }
}

/// Ritz pair: eigenvalue and eigenvector of the operator projected on the basis.
#[derive(Clone, Debug)]
pub struct Ritz {
    /// Ritz value `theta`.
    pub theta: f64,
    /// Residual norm of the Ritz vector, in the operator's inner product.
    pub residual: f64,
    /// Components of the Ritz vector in the Lanczos basis.
    pub coefficients: Vec<f64>,
}

/// Lanczos basis, orthonormal in the operator's inner product, and the projected operator.
pub struct Lanczos {
    unknowns: usize,
    block: usize,
    vectors: Vec<Vec<f64>>,
    /// Components along the basis of the operator's image of each processed vector.
    projected: Vec<Vec<f64>>,
    random: u64,
}

impl Lanczos {
    /// Returns an empty basis for vectors of a given length, with the size of its first block.
    pub fn new(unknowns: usize, block: usize) -> Self {
        Lanczos { unknowns, block, vectors: Vec::new(), projected: Vec::new(), random: 1 }
    }

    /// Number of vectors to which the operator was applied.
    pub fn applied(&self) -> usize {
        self.projected.len()
    }

    /// Applies the operator to a further vector; returns true if a linearly independent one existed.
    ///
    /// # Errors
    /// Error of the operator.
    pub fn expand<O: Operator>(&mut self, operator: &mut O) -> Result<bool, O::Error> {
        let is_first = self.vectors.is_empty();
        if self.applied() == self.vectors.len() {
            (0..if is_first { self.block } else { 1 }).try_for_each(|_| self.begin(operator))?;
        }
        let Some(vector) = self.vectors.get(self.applied()) else { return Ok(false) };
        let image = operator.solve(operator.image(vector))?;
        let along = self.add(operator, image);
        self.projected.push(along);
        Ok(true)
    }

    /// Adds a given vector, and returns the norm of its component orthogonal to the basis, in the operator's product.
    pub fn begin_with<O: Operator>(&mut self, operator: &O, vector: Vec<f64>) -> f64 {
        let before = self.vectors.len();
        let along = self.add(operator, vector);
        along.get(before).copied().unwrap_or(0.0)
    }

    /// True if the operator was applied to all basis vectors, so that their space is invariant.
    pub fn is_exhausted(&self) -> bool {
        self.applied() == self.vectors.len()
    }

    /// Components of the operator's images of all processed vectors along the next, unprocessed basis vector; 0 if there is none.
    pub fn coupling(&self) -> Vec<f64> {
        let next = self.applied();
        self.projected.iter().map(|along| along.get(next).copied().unwrap_or(0.0)).collect()
    }

    /// The first vectors of the basis.
    pub fn into_vectors(mut self, count: usize) -> Vec<Vec<f64>> {
        self.vectors.truncate(count);
        self.vectors
    }

    /// Adds a pseudorandom start vector, after one application of the operator.
    ///
    /// # Errors
    /// Error of the operator.
    pub fn begin<O: Operator>(&mut self, operator: &mut O) -> Result<(), O::Error> {
        let any: Vec<f64> = (0..self.unknowns).map(|_| self.next_random()).collect();
        let image = operator.solve(operator.image(&any))?;
        self.add(operator, image);
        Ok(())
    }

    /// Reproducible pseudorandom number between -1 and 1 (xorshift; Marsaglia 2003).
    fn next_random(&mut self) -> f64 {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        (self.random >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Adds the component of a vector orthogonal to the basis, if above round-off; returns its components along the basis.
    fn add<O: Operator>(&mut self, operator: &O, mut vector: Vec<f64>) -> Vec<f64> {
        let mut along = vec![0.0; self.vectors.len()];
        let mut image = operator.mass_times(&vector);
        let size = product(&vector, &image).max(0.0).sqrt();
        for _ in 0..PASSES {
            for (own, along) in self.vectors.iter().zip(&mut along) {
                let component = product(own, &image);
                *along += component;
                vector.iter_mut().zip(own).for_each(|(x, own)| *x -= component * own);
            }
            image = operator.mass_times(&vector);
        }
        let left = product(&vector, &image).max(0.0).sqrt();
        if left > LANCZOS_DEPENDENT * size {
            vector.iter_mut().for_each(|x| *x /= left);
            self.vectors.push(vector);
            along.push(left);
        }
        along
    }

    /// Ritz pairs of the projection, the largest eigenvalue first.
    pub fn ritz(&self) -> Vec<Ritz> {
        let size = self.applied();
        if size == 0 {
            return Vec::new();
        }
        let entry = |i: usize, k: usize| self.projected[k].get(i).copied().unwrap_or(0.0);
        let eigen = DMatrix::from_fn(size, size, |i, k| 0.5 * (entry(i, k) + entry(k, i))).symmetric_eigen();
        let mut order: Vec<usize> = (0..size).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        let of = |k: usize| {
            let coefficients: Vec<f64> = eigen.eigenvectors.column(k).iter().copied().collect();
            let missed = (size..self.vectors.len()).map(|i| coefficients.iter().enumerate().map(|(k, s)| entry(i, k) * s).sum::<f64>());
            let residual = missed.map(|x| x * x).sum::<f64>().sqrt();
            Ritz { theta: eigen.eigenvalues[k], residual, coefficients }
        };
        order.into_iter().map(of).collect()
    }

    /// Vector from its components in the basis.
    pub fn vector(&self, coefficients: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.unknowns];
        for (own, coefficient) in self.vectors.iter().zip(coefficients) {
            sum.iter_mut().zip(own).for_each(|(sum, own)| *sum += coefficient * own);
        }
        sum
    }
}

/// Scalar product, summed in an order that allows vector instructions.
pub fn product(a: &[f64], b: &[f64]) -> f64 {
    const LANES: usize = 8;
    let mut sums = [0.0; LANES];
    let (left, right) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f64 = left.remainder().iter().zip(right.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in left.zip(right) {
        for k in 0..LANES {
            sums[k] += a[k] * b[k];
        }
    }
    sums.iter().sum::<f64>() + rest
}
