//! Norms of vectors.

/// Number of partial maxima that are computed independently, so that a comparison does not wait for the one before it.
const SIDE_BY_SIDE: usize = 8;

/// Maximum norm: largest absolute value of a component, at least 0; NaN components are ignored.
pub fn largest_size(values: &[f64]) -> f64 {
    let mut largest = [0.0f64; SIDE_BY_SIDE];
    let (groups, rest) = values.as_chunks::<SIDE_BY_SIDE>();
    for group in groups {
        for (largest, value) in largest.iter_mut().zip(group) {
            let size = value.abs();
            *largest = if size > *largest { size } else { *largest };
        }
    }
    largest.iter().chain(rest).fold(0.0, |largest, value| largest.max(value.abs()))
}

/// Sum norm: sum of the absolute values of all components.
pub fn sum_of_sizes(values: &[f64]) -> f64 {
    values.iter().map(|value| value.abs()).sum()
}

/// Euclidean length of a vector in space.
pub fn length(vector: [f64; 3]) -> f64 {
    vector.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Twice the largest distance of points from their mean: a size that does not change when the points are turned; 0 without points.
pub fn diameter<'a>(points: impl Iterator<Item = &'a [f64; 3]> + Clone) -> f64 {
    let mut sum = [0.0; 3];
    for point in points.clone() {
        sum = std::array::from_fn(|i| sum[i] + point[i]);
    }
    let count = points.clone().count() as f64;
    2.0 * points.map(|x| length(std::array::from_fn(|i| x[i] - sum[i] / count))).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_size_is_found_wherever_it_stands() {
        assert_eq!(largest_size(&[]), 0.0);
        for length in [1, 7, 8, 9, 30] {
            for place in 0..length {
                let mut values = vec![0.5; length];
                values[place] = -2.0;
                values[(place + 1) % length] = f64::NAN;
                let expected = if length == 1 { 0.0 } else { 2.0 };
                assert_eq!(largest_size(&values), expected, "{place} of {length}");
                values[(place + 1) % length] = f64::NEG_INFINITY;
                assert_eq!(largest_size(&values), f64::INFINITY);
            }
        }
    }
}
