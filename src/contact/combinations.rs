//! Linear combinations `y_i = sum_k a_ik x_k` of numbers or points, and their transpose; used for facets between points that are defined by
//! nodes.

/// Sparse matrix `a` of combinations `y_i = sum_k a_ik x_k`, row by row.
#[derive(Clone, Debug)]
pub(super) struct Combinations {
    parts: Vec<(u32, f64)>,
    starts: Vec<usize>,
}

impl Default for Combinations {
    fn default() -> Self {
        Combinations { parts: Vec::new(), starts: vec![0] }
    }
}

impl Combinations {
    /// Appends a combination and returns its index; repeated entries are added.
    pub fn push(&mut self, parts: impl IntoIterator<Item = (u32, f64)>) -> u32 {
        let first = self.starts[self.len()];
        for (index, share) in parts {
            match self.parts[first..].iter_mut().find(|(known, _)| *known == index) {
                Some((_, sum)) => *sum += share,
                None => self.parts.push((index, share)),
            }
        }
        self.starts.push(self.parts.len());
        self.len() as u32 - 1
    }

    /// Removes all combinations.
    pub fn clear(&mut self) {
        self.parts.clear();
        self.starts.truncate(1);
    }

    /// Number of combinations.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Indices `k` and coefficients `a_ik` of combination `i`.
    pub fn parts(&self, entry: usize) -> &[(u32, f64)] {
        &self.parts[self.starts[entry]..self.starts[entry + 1]]
    }

    /// Combinations of numbers, `y_i = sum_k a_ik x_k`.
    pub fn values_into(&self, x: &[f64], y: &mut Vec<f64>) {
        y.clear();
        y.extend((0..self.len()).map(|entry| self.parts(entry).iter().map(|&(k, share)| share * x[k as usize]).sum::<f64>()));
    }

    /// Combinations of points with `dimension` coordinates each, into `y`.
    pub fn points_into(&self, dimension: usize, x: &[f64], y: &mut Vec<f64>) {
        y.clear();
        for entry in 0..self.len() {
            let mut sum = [0.0; 3];
            for &(k, share) in self.parts(entry) {
                (0..dimension).for_each(|i| sum[i] += share * x[dimension * k as usize + i]);
            }
            y.extend(&sum[..dimension]);
        }
    }

    /// Combinations of points with `dimension` coordinates each.
    pub fn points(&self, dimension: usize, x: &[f64]) -> Vec<f64> {
        let mut y = Vec::with_capacity(dimension * self.len());
        self.points_into(dimension, x, &mut y);
        y
    }

    /// Bounds `sum_k |a_ik| x_k` of the combinations, given bounds `x_k` of the entries.
    pub fn bounds(&self, x: &[f64]) -> Vec<f64> {
        (0..self.len()).map(|entry| self.parts(entry).iter().map(|&(k, share)| share.abs() * x[k as usize]).sum()).collect()
    }

    /// Transposed product for numbers, `x_k += sum_i a_ik y_i`.
    pub fn add_values_back(&self, y: &[f64], x: &mut [f64]) {
        for (entry, value) in y.iter().enumerate() {
            self.parts(entry).iter().for_each(|&(k, share)| x[k as usize] += share * value);
        }
    }

    /// Transposed product for vectors with `dimension` components, `x_k += sum_i a_ik y_i`.
    pub fn add_vectors_back(&self, dimension: usize, y: &[f64], x: &mut [f64]) {
        for (entry, value) in y.chunks_exact(dimension).enumerate() {
            for &(k, share) in self.parts(entry) {
                (0..dimension).for_each(|i| x[dimension * k as usize + i] += share * value[i]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forth_and_back_are_transposed() {
        let mut made = Combinations::default();
        assert_eq!((made.push([(0, 0.25), (2, 0.5), (0, 0.25)]), made.push([(1, -1.0)])), (0, 1));
        assert_eq!(made.parts(0), [(0, 0.5), (2, 0.5)]);
        let mut values = Vec::new();
        made.values_into(&[1.0, 2.0, 4.0], &mut values);
        assert_eq!(values, [2.5, -2.0]);
        assert_eq!(made.points(2, &[1.0, 0.0, 2.0, 0.0, 4.0, 8.0]), [2.5, 4.0, -2.0, 0.0]);
        assert_eq!(made.bounds(&[1.0, 2.0, 4.0]), [2.5, 2.0]);
        let (mut numbers, mut vectors) = ([0.0; 3], [0.0; 6]);
        made.add_values_back(&[2.0, 3.0], &mut numbers);
        made.add_vectors_back(2, &[2.0, 0.0, 0.0, 3.0], &mut vectors);
        assert_eq!(numbers, [1.0, -3.0, 1.0]);
        assert_eq!(vectors, [1.0, 0.0, 0.0, -3.0, 1.0, 0.0]);
    }
}
