//! Rigid obstacles of the plane as drawings: a border and a band behind it. Obstacles in space are in `obstacle_surfaces.rs`.
//!
//! A half plane has no ends and a circle no corners, so that drawn length and fineness depend on the bodies beside the obstacle.

use crate::contact::Obstacle;
use crate::dynamics::{BodyFields, PlacedObstacle};
use crate::math::tolerances::PICTURE_ROUNDNESS;

/// Thickness of the band relative to the largest extent of the bodies.
const THICKNESS: f64 = 0.03;
/// Largest distance between a corner of the border and the corner of its band, relative to the thickness.
const LONGEST_MITRE: f64 = 2.0;
/// Smallest and largest number of corners of a circle.
const CORNERS: [f64; 2] = [120.0, 4096.0];

/// Center and largest extent of the bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surroundings {
    /// Center `[length]`.
    pub middle: [f64; 3],
    /// Largest extent `[length]`.
    pub extent: f64,
}

impl Surroundings {
    /// Returns center and extent of points; those of the unit square centered at the origin if the points have no extent.
    pub fn of(points: impl Iterator<Item = [f64; 3]>) -> Self {
        let finite = points.filter(|point| point.iter().all(|x| x.is_finite()));
        let start = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        let wider =
            |(low, high): ([f64; 3], [f64; 3]), x: [f64; 3]| ([0, 1, 2].map(|d| low[d].min(x[d])), [0, 1, 2].map(|d| high[d].max(x[d])));
        let (low, high) = finite.fold(start, wider);
        let extent = (0..3).map(|d| high[d] - low[d]).fold(f64::NEG_INFINITY, f64::max);
        if extent > 0.0 && extent.is_finite() {
            Surroundings { middle: [0, 1, 2].map(|d| 0.5 * (low[d] + high[d])), extent }
        } else {
            Surroundings { middle: [0.0; 3], extent: 1.0 }
        }
    }

    /// Returns center and extent of the bodies in their current position.
    pub fn of_bodies(bodies: &[BodyFields]) -> Self {
        let points = |body: &'_ BodyFields| (0..body.mesh.points.len()).map(|node| body.position(node)).collect::<Vec<_>>();
        Surroundings::of(bodies.iter().flat_map(points))
    }
}

/// A drawn obstacle.
#[derive(Clone, Debug, PartialEq)]
pub struct Wall {
    /// Name of the contact.
    pub name: String,
    /// Points of the border; the obstacle is on the left of the path.
    pub border: Vec<[f64; 2]>,
    /// Points at the back of the band, one for each point of the border.
    pub back: Vec<[f64; 2]>,
    /// True if the border is closed; the first point is not repeated at the end.
    pub is_closed: bool,
}

impl Wall {
    /// Returns a drawn obstacle, `None` for obstacles in space; `reach` is half the length of a half plane's border, relative to the extent
    /// of the bodies.
    pub fn new(obstacle: &PlacedObstacle, around: &Surroundings, reach: f64) -> Option<Self> {
        let Surroundings { middle, extent } = *around;
        let place = |[x, y]: [f64; 2], of: &dyn Fn([f64; 3]) -> [f64; 3]| {
            let [x, y, _] = of([x, y, 0.0]);
            [x, y]
        };
        let placed = |point: [f64; 2]| place(point, &|point| obstacle.place.point(point));
        let thickness = THICKNESS * extent;
        let (border, is_closed, thickness) = match &obstacle.shape {
            Obstacle::InSpace(_) => return None,
            Obstacle::HalfPlane { point, normal } => {
                let normal = place(*normal, &|normal| obstacle.place.direction(normal));
                let (point, length) = (placed(*point), normal[0].hypot(normal[1]));
                let along = [-normal[1] / length, normal[0] / length];
                let place = along[0] * (middle[0] - point[0]) + along[1] * (middle[1] - point[1]);
                let end = |way: f64| [0, 1].map(|d| point[d] + (place + way * reach * extent) * along[d]);
                (vec![end(-1.0), end(1.0)], false, thickness)
            }
            Obstacle::Disk { center, radius } => (circle(placed(*center), *radius, 1.0, extent), true, *radius),
            Obstacle::Ring { center, radius } => (circle(placed(*center), *radius, -1.0, extent), true, thickness),
            Obstacle::Polyline { points } => {
                let is_closed = points.len() > 3 && points.first() == points.last();
                let count = points.len() - usize::from(is_closed);
                (points[..count].iter().map(|&point| placed(point)).collect(), is_closed, thickness)
            }
        };
        let back = behind(&border, is_closed, thickness);
        Some(Wall { name: obstacle.name.clone(), border, back, is_closed })
    }

    /// Quadrilaterals of the band, each between two neighboring points of the border: along the border, back behind it.
    pub fn pieces(&self) -> impl Iterator<Item = [[f64; 2]; 4]> + '_ {
        let count = self.border.len();
        (0..count - usize::from(!self.is_closed)).map(move |k| {
            let next = (k + 1) % count;
            [self.border[k], self.border[next], self.back[next], self.back[k]]
        })
    }

    /// Returns the points of the border nearest to the corners of a box, and the vertices of the border.
    pub fn landmarks(&self, low: [f64; 2], high: [f64; 2]) -> Vec<[f64; 2]> {
        let corners = [low, [high[0], low[1]], high, [low[0], high[1]], [0, 1].map(|d| 0.5 * (low[d] + high[d]))];
        let nearest = |[a, b, c, d]: [[f64; 2]; 4]| {
            let along = [b[0] - a[0], b[1] - a[1]];
            let square = along[0] * along[0] + along[1] * along[1];
            corners.map(|corner| {
                let share = ((corner[0] - a[0]) * along[0] + (corner[1] - a[1]) * along[1]) / square;
                let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 };
                let mut both = [[0.0; 2]; 2];
                for i in 0..2 {
                    both[0][i] = a[i] + share * along[i];
                    both[1][i] = d[i] + share * (c[i] - d[i]);
                }
                both
            })
        };
        self.pieces().flat_map(nearest).flatten().chain(self.border.iter().copied()).collect()
    }
}

/// Returns a circle as a polygon, fine enough to look smooth; counter-clockwise for `turn` 1, clockwise for -1.
fn circle(center: [f64; 2], radius: f64, turn: f64, extent: f64) -> Vec<[f64; 2]> {
    let corners = std::f64::consts::PI / (2.0 * PICTURE_ROUNDNESS * extent / radius).sqrt();
    let corners = corners.clamp(CORNERS[0], CORNERS[1]).ceil();
    let corner = |k: usize| {
        let angle = turn * std::f64::consts::TAU * k as f64 / corners;
        [center[0] + radius * angle.cos(), center[1] + radius * angle.sin()]
    };
    (0..corners as usize).map(corner).collect()
}

/// Returns the points at a distance on the left of a chain; at a corner, the intersection of the sides of the band, within
/// `LONGEST_MITRE`.
fn behind(chain: &[[f64; 2]], is_closed: bool, distance: f64) -> Vec<[f64; 2]> {
    let count = chain.len();
    let left = |a: usize, b: usize| {
        let along = [chain[b][0] - chain[a][0], chain[b][1] - chain[a][1]];
        let length = along[0].hypot(along[1]);
        if length > 0.0 { [-along[1] / length, along[0] / length] } else { [0.0; 2] }
    };
    (0..count)
        .map(|k| {
            let before = if k > 0 { Some(left(k - 1, k)) } else { is_closed.then(|| left(count - 1, 0)) };
            let after = if k + 1 < count { Some(left(k, k + 1)) } else { is_closed.then(|| left(count - 1, 0)) };
            let [before, after] = [before.or(after), after.or(before)].map(Option::unwrap_or_default);
            let sum = [before[0] + after[0], before[1] + after[1]];
            let square = sum[0] * sum[0] + sum[1] * sum[1];
            // The mitre `2 sum / sum.sum` has the length 2 / |sum|.
            let factor = if square > 0.0 { (2.0 / square).min(LONGEST_MITRE / square.sqrt()) } else { 0.0 };
            [0, 1].map(|d| chain[k][d] + distance * factor * sum[d])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{ObstaclePlacement, TurningAxis};

    fn wall(shape: Obstacle) -> Wall {
        let around = Surroundings { middle: [3.0, 5.0, 0.0], extent: 2.0 };
        Wall::new(&PlacedObstacle { name: "ground".into(), shape, place: moved([1.0, 0.5, 0.0]) }, &around, 2.0)
            .expect("it is of the plane")
    }

    fn moved(translation: [f64; 3]) -> ObstaclePlacement {
        ObstaclePlacement { translation, ..ObstaclePlacement::default() }
    }

    #[test]
    fn an_obstacle_is_drawn_where_it_has_turned() {
        let around = Surroundings { middle: [0.0; 3], extent: 2.0 };
        let place = TurningAxis::new([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]).place(std::f64::consts::FRAC_PI_2, [0.0, 0.25, 0.0]);
        let drawn = |shape| Wall::new(&PlacedObstacle { name: "paddle".into(), shape, place }, &around, 1.0).expect("it is of the plane");
        let blade = drawn(Obstacle::Polyline { points: vec![[1.0, 0.0], [3.0, 0.0]] });
        assert!(close(blade.border[0], [1.0, 0.25]) && close(blade.border[1], [1.0, 2.25]), "{blade:?}");
        let ground = drawn(Obstacle::HalfPlane { point: [0.0, 0.0], normal: [0.0, 1.0] });
        assert!(close(ground.border[0], [1.0, -2.0]) || close(ground.border[0], [1.0, 2.0]), "{ground:?}");
    }

    fn close(a: [f64; 2], b: [f64; 2]) -> bool {
        (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-12
    }

    #[test]
    fn a_half_plane_is_a_band_below_the_bodies() {
        let wall = wall(Obstacle::HalfPlane { point: [100.0, 0.0], normal: [0.0, 7.0] });
        assert!(close(wall.border[0], [7.0, 0.5]) && close(wall.border[1], [-1.0, 0.5]), "{wall:?}");
        assert!(close(wall.back[0], [7.0, 0.5 - 0.06]) && close(wall.back[1], [-1.0, 0.5 - 0.06]));
        assert_eq!(wall.pieces().count(), 1);
    }

    #[test]
    fn a_disk_is_filled_and_a_ring_lies_outside() {
        let disk = wall(Obstacle::Disk { center: [0.0, 0.0], radius: 0.5 });
        assert!(disk.border.iter().all(|&[x, y]| ((x - 1.0).hypot(y - 0.5) - 0.5).abs() < 1e-12));
        assert!(disk.back.iter().all(|&back| (back[0] - 1.0).hypot(back[1] - 0.5) < 2e-3), "up to the center");
        let ring = wall(Obstacle::Ring { center: [0.0, 0.0], radius: 4.0 });
        assert!(ring.back.iter().all(|&[x, y]| ((x - 1.0).hypot(y - 0.5) - 4.06).abs() < 1e-3), "outside");
        let large = wall(Obstacle::Disk { center: [0.0, -1e4], radius: 1e4 });
        assert_eq!(large.pieces().count(), large.border.len());
        assert!(large.border.len() > 1000, "a large circle is finer");
    }

    #[test]
    fn a_polyline_has_its_band_on_the_left_with_corners() {
        let stairs = wall(Obstacle::Polyline { points: vec![[4.0, 0.0], [2.0, 0.0], [2.0, 0.5], [0.0, 0.5]] });
        assert!(!stairs.is_closed && stairs.border.len() == 4);
        assert!(close(stairs.back[0], [5.0, 0.44]) && close(stairs.back[1], [3.0 - 0.06, 0.44]) && close(stairs.back[2], [2.94, 0.94]));
        let pit = vec![[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
        let pit = wall(Obstacle::Polyline { points: pit });
        assert!(pit.is_closed && pit.border.len() == 4 && close(pit.back[0], [0.94, 0.44]), "{pit:?}");
    }
}
