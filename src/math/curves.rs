//! Difference of two sampled curves in the range where both are defined.
//!
//! Curves are linear between their points. The difference of two curves is linear between the points of both, so that its maximum, mean and
//! mean square are exact for any sampling.

/// A curve: points `[x, y]` with rising `x`.
pub type Points = [[f64; 2]];

/// Norms of the difference of two curves over a range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Difference of largest magnitude over the range, second curve minus first curve.
    pub largest: f64,
    /// Abscissa `x` of the largest difference.
    pub at: f64,
    /// Mean of the difference over the range.
    pub mean: f64,
    /// Mean square of the difference over the range.
    pub mean_square: f64,
    /// Mean square of the first curve over the range, the scale for relative differences.
    pub scale: f64,
    /// Range of the abscissa.
    pub range: [f64; 2],
}

/// Value of a curve at `x`; outside of its range that of the nearest end.
pub fn value(curve: &Points, x: f64) -> f64 {
    let after = curve.partition_point(|point| point[0] <= x);
    match (after.checked_sub(1).map(|before| curve[before]), curve.get(after)) {
        (Some([x0, y0]), Some([x1, y1])) if x > x0 => {
            let share = (x - x0) / (x1 - x0);
            y0 * (1.0 - share) + y1 * share
        }
        (Some([_, y]), _) | (None, Some(&[_, y])) => y,
        (None, None) => f64::NAN,
    }
}

/// Interval of `x` in which both curves are defined; `None` if it is empty.
pub fn overlap(a: &Points, b: &Points) -> Option<[f64; 2]> {
    let (first, last) = (a.first()?[0].max(b.first()?[0]), a.last()?[0].min(b.last()?[0]));
    (first <= last).then_some([first, last])
}

/// Norms of the difference of two curves in a range in which both are defined.
pub fn distance(a: &Points, b: &Points, range: [f64; 2]) -> Distance {
    let [first, last] = range;
    let inside = a.iter().chain(b).map(|point| point[0]).filter(|x| (first..last).contains(x));
    let mut places: Vec<f64> = inside.chain(range).collect();
    places.sort_by(f64::total_cmp);
    places.dedup();
    let values: Vec<[f64; 2]> = places.iter().map(|&x| (value(a, x), value(b, x))).map(|(a, b)| [a, b - a]).collect();
    let mut distance = Distance { largest: 0.0, at: first, mean: 0.0, mean_square: 0.0, scale: 0.0, range };
    for (x, [_, difference]) in places.iter().zip(&values) {
        if difference.is_nan() || difference.abs() > distance.largest.abs() {
            (distance.largest, distance.at) = (*difference, *x);
        }
    }
    let length = last - first;
    if length == 0.0 {
        let [a, difference] = values[0];
        return Distance { mean: difference, mean_square: difference * difference, scale: a * a, ..distance };
    }
    for (x, ends) in places.windows(2).zip(values.windows(2)) {
        let share = (x[1] - x[0]) / length;
        let square = |k: usize| (ends[0][k] * ends[0][k] + ends[0][k] * ends[1][k] + ends[1][k] * ends[1][k]) / 3.0;
        distance.mean += share * 0.5 * (ends[0][1] + ends[1][1]);
        distance.mean_square += share * square(1);
        distance.scale += share * square(0);
    }
    distance
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_exact_whatever_the_samples() {
        // y = x and y = 1 - x over [0, 1]: the difference 1 - 2 x has mean 0, mean square 1/3, and is 1 at the ends.
        let (rising, falling) = ([[0.0, 0.0], [0.3, 0.3], [1.0, 1.0]], [[-1.0, 2.0], [0.71, 0.29], [2.0, -1.0]]);
        let range = overlap(&rising, &falling).unwrap();
        assert_eq!(range, [0.0, 1.0]);
        let found = distance(&rising, &falling, range);
        assert!((found.largest.abs() - 1.0).abs() < 1e-15 && found.mean.abs() < 1e-15, "{found:?}");
        assert!((found.mean_square - 1.0 / 3.0).abs() < 1e-15 && (found.scale - 1.0 / 3.0).abs() < 1e-15, "{found:?}");
        // Over half of the range, [0, 1/2], the difference 1 - 2 x has mean 1/2 and mean square 1/3.
        let half = distance(&rising, &falling, [0.0, 0.5]);
        assert!((half.mean - 0.5).abs() < 1e-15 && (half.mean_square - 1.0 / 3.0).abs() < 1e-15);
        assert_eq!((half.largest, half.at), (1.0, 0.0));
    }

    #[test]
    fn curves_that_meet_at_one_place_are_compared_there() {
        let (a, b) = ([[0.0, 1.0], [1.0, 3.0]], [[1.0, 7.0], [2.0, 0.0]]);
        let found = distance(&a, &b, overlap(&a, &b).unwrap());
        assert_eq!((found.largest, found.at, found.mean, found.mean_square, found.scale), (4.0, 1.0, 4.0, 16.0, 9.0));
        assert_eq!(overlap(&a, &[[1.5, 0.0]]), None);
        assert_eq!((value(&a, -1.0), value(&a, 0.25), value(&a, 9.0)), (1.0, 1.5, 3.0));
    }
}
