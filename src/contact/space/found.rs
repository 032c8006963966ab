//! Rows that sharp vertices and edges may have at a configuration, and which of them go because of others (*dominance*).

use super::features;
use super::gaps::Measure;
use crate::contact::faces::Vector;

/// Cosine of the angle between the normals of two facets from which on a vertex has a row against the nearer one alone: 10 degrees.
pub const ALIKE: f64 = features::SMOOTH;

/// How far, in smallest facets, a body may reach beyond a row's plane and still recede along it.
const RECEDES: f64 = 0.02;

/// A row that may be there at a configuration.
#[derive(Clone, Copy)]
pub struct Found {
    pub patch: usize,
    pub measure: Measure,
    pub gap: f64,
    /// Direction in which the secondary side has to go to part them.
    pub normal: Vector,
    /// Points of the secondary and of the primary side that touch.
    pub at: [Vector; 2],
    /// Whether all that is next to it strictly recedes.
    pub is_strict: bool,
}

impl Found {
    /// Whether it overlaps and goes, because a shallower one near by parts the bodies along another direction.
    pub fn is_dominated(&self, found: &[Found], facet_size: f64) -> bool {
        self.gap < 0.0 && found.iter().any(|other| other.is_strict && self.is_beside(other, facet_size))
    }

    /// Whether another one near by is shallower and parts the bodies along another direction, behind which both recede.
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
