//! Constraints of a surface against sharp features of rigid obstacles in space and small rigid balls (for `rigid_corners.rs`).

use super::corners::{CornersInSpace, OF_BALL, SLOTS};
use super::features::{Features, Vertex, rises};
use crate::contact::kernel::ContactKernel;
use crate::contact::surface::Surface;

impl CornersInSpace {
    /// Constraints of a surface against a rigid obstacle, whose nodes are part of `positions`; `None` for obstacles without sharp features.
    /// Vertices of the surface have constraints elsewhere. `curve` are the places of the surface's points without the rise that represents
    /// faces of second order; `facet_size` is that of the whole contact `[length]`.
    pub(crate) fn of_obstacle(
        surface: Surface,
        obstacle: Surface,
        positions: &[f64],
        curve: &[f64],
        facet_size: f64,
    ) -> Option<Box<dyn ContactKernel>> {
        let own = Features::with_smooth_edges(&surface, positions).raised(&surface, positions, curve);
        let features = [own, Features::new(&obstacle, positions)];
        if features[1].vertices.is_empty() {
            return None;
        }
        let rises = rises(&surface, positions, curve);
        let mut made = CornersInSpace::new(surface, obstacle, features, positions, facet_size);
        (made.has_nodal_rows, made.heights[0]) = (true, rises);
        Some(Box::new(made))
    }

    /// Constraints of a rigid ball against the facets of a surface; the tip of a cone is a ball of radius 0. `positions`, `curve` and
    /// `facet_size` as in [`Self::of_obstacle`].
    pub(crate) fn of_ball(
        surface: Surface,
        (center, radius): (u32, f64),
        positions: &[f64],
        curve: &[f64],
        facet_size: f64,
    ) -> Box<dyn ContactKernel> {
        let center_alone = Vertex { node: center, spokes: Vec::new(), is_bump: false, raised: 0.0 };
        let alone = Features { vertices: vec![center_alone], edges: Vec::new(), laps: vec![Vec::new()] };
        let features = [Features::new(&surface, positions), alone];
        let rises = rises(&surface, positions, curve);
        let mut made = CornersInSpace::new(surface, Surface::in_space([&[center][..]]), features, positions, facet_size);
        made.slots = if radius > 0.0 && radius <= OF_BALL.1 * facet_size { OF_BALL.0 } else { SLOTS };
        made.sides.weights.resize(made.slots * made.owners.count(), facet_size * facet_size);
        (made.has_nodal_rows, made.radius, made.heights[0]) = (true, radius, rises);
        Box::new(made)
    }
}
