//! Possible constraints of sharp features at a configuration, and their *dominance*: a shallower constraint replaces a deeper one
//! (`corners.rs`).

use super::features;
use super::gaps::Measure;
use crate::contact::faces::Vector;
use crate::math::tolerances::EQUAL_GAPS;

/// Cosine of the angle between the normals of two facets, 10 degrees, above which a vertex has a constraint against the nearer facet only.
pub const ALIKE: f64 = features::SMOOTH;

/// Distance, in smallest facets, by which a body may reach beyond the plane of a constraint and still count as receding behind it.
const RECEDES: f64 = 0.02;

/// Possible constraint at a configuration.
#[derive(Clone, Copy)]
pub struct Found {
    pub patch: usize,
    pub measure: Measure,
    pub gap: f64,
    /// Direction in which the secondary side must move to separate the bodies.
    pub normal: Vector,
    /// Contact points of the secondary and of the primary side.
    pub at: [Vector; 2],
    /// True if all material next to the feature recedes within the stricter tolerance.
    pub is_strict: bool,
}

impl Found {
    /// Size of the gap as a multiple of round-off: equal for gaps that differ by less, such as of a node above the border of two facets in
    /// a plane.
    pub fn distance(&self, facet_size: f64) -> f64 {
        (self.gap.abs() / (EQUAL_GAPS * facet_size)).round()
    }

    /// True if this constraint overlaps and a shallower strict constraint nearby separates the bodies in another direction.
    pub fn is_dominated(&self, found: &[Found], facet_size: f64) -> bool {
        self.gap < 0.0 && found.iter().any(|other| other.is_strict && self.is_beside(other, facet_size))
    }

    /// True if `other` is shallower and near, has another normal, and both bodies recede behind its plane.
    pub fn is_beside(&self, other: &Found, facet_size: f64) -> bool {
        let reach = RECEDES * facet_size;
        let middle = |row: &Found| 0.5 * (row.at[0] + row.at[1]);
        let beyond = [0, 1].map(|side| other.normal.dot(&(self.at[side] - other.at[side])));
        other.gap > self.gap
            && (middle(self) - middle(other)).norm() <= 2.0 * self.gap.abs()
            && self.normal.dot(&other.normal) < ALIKE
            && beyond[0] >= -reach
            && beyond[1] <= reach
    }
}
