//! Surfaces of rigid obstacles in space for pictures, in facets whose size depends on that of the bodies.
//!
//! Unbounded obstacles, such as planes, are drawn slightly beyond the bodies; of a sphere or a cylinder that is much larger than the
//! bodies, the part beside the bodies is drawn.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::Vector3;

use super::obstacles::Surroundings;
use crate::contact::{Obstacle, ObstacleInSpace};
use crate::dynamics::PlacedObstacle;

type Vector = Vector3<f64>;

/// Ratio of the drawn distance to an obstacle's radius above which round obstacles are drawn as a whole.
const WHOLE: f64 = 0.2;

/// Number of subdivisions of flat or straight parts.
const PIECES: usize = 24;
/// Number of subdivisions of a circle.
const AROUND: usize = 64;
/// Number of subdivisions of a quarter of a small circle.
const CORNER: usize = 4;
/// Number of subdivisions of half a circle.
const HALF_AROUND: usize = 32;

/// Surface of a drawn obstacle.
#[derive(Clone, Debug, PartialEq)]
pub struct ObstacleSurface {
    /// Name of its contact.
    pub name: String,
    /// Vertices `[length]`.
    pub points: Vec<[f64; 3]>,
    /// Facets of three or four vertices, counter-clockwise as seen from the side of the bodies.
    pub facets: Vec<Vec<u32>>,
}

impl ObstacleSurface {
    /// Returns the surface of an obstacle, `None` for obstacles of the plane; `reach` is the drawn size from the center of the bodies,
    /// relative to their extent.
    pub fn new(obstacle: &PlacedObstacle, around: &Surroundings, reach: f64) -> Option<Self> {
        let Obstacle::InSpace(shape) = &obstacle.shape else { return None };
        let place = obstacle.place;
        let (middle, far) = (Vector::from(place.in_frame(around.middle)), reach * around.extent);
        let grid = match shape {
            ObstacleInSpace::Facets(facets) => {
                let points = facets.points().iter().map(|&point| place.point(point)).collect();
                let facets = facets.triangles().iter().map(|nodes| nodes.to_vec()).collect();
                return Some(ObstacleSurface { name: obstacle.name.clone(), points, facets });
            }
            ObstacleInSpace::Plane { point, normal } => {
                let (normal, point) = (unit(*normal), Vector::from(*point));
                let [u, v] = across(normal);
                let center = middle - normal * normal.dot(&(middle - point));
                Grid::over([PIECES, PIECES], [[-far, far]; 2], false, |s, t| center + u * s + v * t)
            }
            ObstacleInSpace::Sphere { center, radius, is_hollow, .. } => {
                let center = Vector::from(*center);
                let (pole, angle) = part(middle - center, Vector::z(), far / radius);
                let [u, v] = across(pole);
                let at = |s: f64, t: f64| center + (pole * t.cos() + (u * s.cos() + v * s.sin()) * t.sin()) * *radius;
                Grid::over([AROUND, HALF_AROUND], [[0.0, TAU], [angle, 0.0]], *is_hollow, at)
            }
            ObstacleInSpace::Cylinder { point, axis, radius, is_hollow } => {
                let (axis, point) = (unit(*axis), Vector::from(*point));
                let height = axis.dot(&(middle - point));
                let away = middle - point - axis * height;
                let (toward, angle) = part(away, across(axis)[0], far / radius);
                let other = axis.cross(&toward);
                let at = |s: f64, t: f64| point + axis * (height + t) + (toward * s.cos() + other * s.sin()) * *radius;
                Grid::over([AROUND, PIECES], [[-angle, angle], [-far, far]], *is_hollow, at)
            }
            ObstacleInSpace::FiniteCylinder { center, axis, radius, length, edge } => {
                let (axis, center) = (unit(*axis), Vector::from(*center));
                let [u, v] = across(axis);
                // Half of the profile, from the middle of the side to that of an end.
                let arc =
                    (0..=CORNER).map(|k| k as f64 / CORNER as f64 * FRAC_PI_2).map(|t| [edge * (t.cos() - 1.0), edge * (t.sin() - 1.0)]);
                let half = arc.map(|[out, up]| [radius + out, 0.5 * length + up]).chain([[0.0, 0.5 * length]]);
                let upper: Vec<[f64; 2]> = half.collect();
                let profile: Vec<[f64; 2]> = upper.iter().rev().map(|[rho, z]| [*rho, -z]).chain(upper.iter().copied()).collect();
                let at = |s: f64, t: f64| {
                    let [rho, z] = profile[t.round() as usize];
                    center + axis * z + (u * s.cos() + v * s.sin()) * rho
                };
                let last = profile.len() - 1;
                Grid::over([AROUND, last], [[0.0, TAU], [0.0, last as f64]], false, at)
            }
            ObstacleInSpace::Cone { tip, axis, angle, is_hollow } => {
                let (axis, tip) = (unit(*axis), Vector::from(*tip));
                let [u, v] = across(axis);
                let top = (axis.dot(&(middle - tip)) + far).max(far);
                let at = |s: f64, t: f64| tip + (axis + (u * s.cos() + v * s.sin()) * angle.tan()) * t;
                Grid::over([AROUND, PIECES], [[0.0, TAU], [0.0, top]], *is_hollow, at)
            }
            ObstacleInSpace::Torus { center, axis, radius, tube, is_hollow } => {
                let (axis, center) = (unit(*axis), Vector::from(*center));
                let [u, v] = across(axis);
                let at = |s: f64, t: f64| {
                    let out = u * s.cos() + v * s.sin();
                    center + out * *radius + (out * t.cos() + axis * t.sin()) * *tube
                };
                Grid::over([AROUND, HALF_AROUND], [[0.0, TAU], [0.0, TAU]], *is_hollow, at)
            }
        };
        let points = grid.points.into_iter().map(|point| place.point(point.into())).collect();
        Some(ObstacleSurface { name: obstacle.name.clone(), points, facets: grid.facets })
    }
}

/// Points over a rectangle of two parameters, and facets between the points.
struct Grid {
    points: Vec<Vector>,
    facets: Vec<Vec<u32>>,
}

impl Grid {
    /// Returns a grid of `m` times `n` facets; with `is_turned`, facets are oriented opposite to the cross product of the derivatives.
    fn over([m, n]: [usize; 2], [first, second]: [[f64; 2]; 2], is_turned: bool, at: impl Fn(f64, f64) -> Vector) -> Grid {
        let between = |[low, high]: [f64; 2], k: usize, count: usize| low + (high - low) * k as f64 / count as f64;
        let places = (0..=n).flat_map(|j| (0..=m).map(move |i| (i, j)));
        let points = places.map(|(i, j)| at(between(first, i, m), between(second, j, n))).collect();
        let facet = |i: usize, j: usize| {
            let corner = |i: usize, j: usize| (j * (m + 1) + i) as u32;
            let mut nodes = vec![corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            if is_turned {
                nodes.reverse();
            }
            nodes
        };
        let facets = (0..n).flat_map(|j| (0..m).map(move |i| (i, j))).map(|(i, j)| facet(i, j)).collect();
        Grid { points, facets }
    }
}

/// Returns the direction of the middle of the drawn part of a round obstacle, and half its angle: the whole angle for a small obstacle.
fn part(toward: Vector, otherwise: Vector, reach: f64) -> (Vector, f64) {
    if reach >= WHOLE { (otherwise, PI) } else { (toward.try_normalize(0.0).unwrap_or(otherwise), (2.0 * reach).min(PI)) }
}

fn unit(vector: [f64; 3]) -> Vector {
    Vector::from(vector).try_normalize(0.0).unwrap_or(Vector::z())
}

/// Returns two unit vectors that form a right-handed triad with `normal` as the third.
fn across(normal: Vector) -> [Vector; 2] {
    let least = if normal.x.abs() <= normal.y.abs() && normal.x.abs() <= normal.z.abs() {
        Vector::x()
    } else if normal.y.abs() <= normal.z.abs() {
        Vector::y()
    } else {
        Vector::z()
    };
    let u = least.cross(&normal).try_normalize(0.0).unwrap_or(Vector::x());
    [u, normal.cross(&u)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Facets;

    /// Facets face the bodies, and their corners are on the obstacle.
    #[test]
    fn facets_lie_on_the_obstacle_and_look_to_the_bodies() {
        let (axis, center) = ([0.0, 1.0, 2.0], [0.5, 0.0, -1.0]);
        let cube = Facets::cuboid([0.0; 3], [1.0, 2.0, 3.0]).expect("it has a volume");
        let out = |from: [f64; 3], x: Vector| x - Vector::from(from);
        let along = Vector::from(axis).normalize();
        let away = move |x: Vector| out(center, x) - along * along.dot(&out(center, x));
        type Outward = Box<dyn Fn(Vector) -> Vector>;
        let mut cases: Vec<(ObstacleInSpace, Outward)> = vec![
            (ObstacleInSpace::Plane { point: center, normal: axis }, Box::new(move |_| along)),
            (ObstacleInSpace::FiniteCylinder { center, axis, radius: 3.0, length: 2.0, edge: 0.1 }, Box::new(move |x| out(center, x))),
            (ObstacleInSpace::Facets(cube.into()), Box::new(move |x| out([0.5, 1.0, 1.5], x))),
        ];
        for is_hollow in [false, true] {
            let sign = if is_hollow { -1.0 } else { 1.0 };
            cases.extend([
                (ObstacleInSpace::Sphere { center, radius: 0.7, axis, is_hollow }, Box::new(move |x| out(center, x) * sign) as Outward),
                (ObstacleInSpace::Cylinder { point: center, axis, radius: 40.0, is_hollow }, Box::new(move |x| away(x) * sign)),
                (ObstacleInSpace::Cone { tip: center, axis, angle: 0.3, is_hollow }, Box::new(move |x| away(x) * sign)),
                (
                    ObstacleInSpace::Torus { center, axis, radius: 3.0, tube: 0.5, is_hollow },
                    Box::new(move |x| (out(center, x) - away(x).normalize() * 3.0) * sign),
                ),
            ]);
        }
        let around = Surroundings { middle: [1.0, 1.0, 1.0], extent: 2.0 };
        for (shape, outward) in cases {
            let placed = PlacedObstacle { name: "wall".into(), shape: Obstacle::InSpace(shape.clone()), place: Default::default() };
            let surface = ObstacleSurface::new(&placed, &around, 1.0).expect("it is in space");
            assert!(!surface.facets.is_empty());
            for facet in &surface.facets {
                let corners: Vec<Vector> = facet.iter().map(|&node| Vector::from(surface.points[node as usize])).collect();
                let last = corners.len() - 1;
                let area = (corners[2] - corners[0]).cross(&(corners[last] - corners[1]));
                let area = if last == 2 { (corners[1] - corners[0]).cross(&(corners[2] - corners[0])) } else { area };
                let middle = corners.iter().sum::<Vector>() / corners.len() as f64;
                assert!(area.dot(&outward(middle)) > 0.0, "{shape:?}: {corners:?}");
            }
        }
    }
}
