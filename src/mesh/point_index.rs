//! Spatial index of points.

use rstar::RTree;
use rstar::primitives::GeomWithData;

/// Points in space with their numbers.
pub struct PointIndex(RTree<GeomWithData<[f64; 3], usize>>);

impl PointIndex {
    /// An index of points, numbered in their order.
    pub fn new(points: &[[f64; 3]]) -> Self {
        PointIndex(RTree::bulk_load(points.iter().enumerate().map(|(number, point)| GeomWithData::new(*point, number)).collect()))
    }

    /// The point nearest to a position, with its distance `[length]`; `None` without points.
    pub fn nearest(&self, place: [f64; 3]) -> Option<(usize, f64)> {
        let found = self.0.nearest_neighbor(place)?;
        let distance = (0..3).map(|i| (found.geom()[i] - place[i]).powi(2)).sum::<f64>().sqrt();
        Some((found.data, distance))
    }
}
