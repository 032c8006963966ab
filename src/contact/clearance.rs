//! Signed distance of single points from a rigid obstacle, independent of contact surfaces and constraints.
//!
//! Contact constrains the secondary nodes only. Checks of whole bodies, in the plane and in space, need the distance of any point, the
//! normals of the obstacle in front of a facet, and points inside of the obstacle.

use std::sync::Arc;

use super::obstacle_side::{Distance, ObstacleSide};
use super::rigid_shape::{Obstacle, PlaneOutline};
use super::space::{Facets, ObstacleInSpace, ShapeInSpace};

/// Number of points on the center circle of a torus that [`Clearance::inner_points`] returns.
const AROUND: usize = 8;

/// Signed distance function of a rigid obstacle at its undisplaced position; third components are zero in the plane.
pub struct Clearance {
    obstacle: Obstacle,
    made: Made,
}

enum Made {
    Plane(PlaneOutline),
    Space(ShapeInSpace),
}

/// Signed distance of a point from an obstacle.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    /// Signed distance, negative inside `[length]`.
    pub gap: f64,
    /// Gradient of the distance with respect to the point: a unit vector away from the obstacle.
    pub normal: [f64; 3],
    /// True if the point is opposite the obstacle; false beyond an end of an open surface.
    pub covered: bool,
}

impl Clearance {
    /// Prepares an obstacle for evaluation.
    pub fn new(obstacle: &Obstacle) -> Clearance {
        let made = match obstacle {
            Obstacle::InSpace(shape) => Made::Space(ShapeInSpace::new(shape)),
            _ => Made::Plane(PlaneOutline::new(obstacle)),
        };
        Clearance { obstacle: obstacle.clone(), made }
    }

    /// Distance of a point given in the frame of the obstacle.
    pub fn at(&self, x: [f64; 3]) -> Nearest {
        match &self.made {
            Made::Space(shape) => {
                let Distance { gap, normal, covered, .. } = shape.at(x.into());
                Nearest { gap, normal: normal.into(), covered }
            }
            Made::Plane(shape) => {
                let none = Nearest { gap: f64::INFINITY, normal: [0.0; 3], covered: false };
                let [x, y, _] = x;
                shape.distance([x, y].into()).map_or(none, |at| Nearest {
                    gap: at.gap,
                    normal: [at.normal[0], at.normal[1], 0.0],
                    covered: at.covered,
                })
            }
        }
    }

    /// True if the obstacle is an open surface, which encloses no volume.
    pub fn is_open(&self) -> bool {
        match &self.obstacle {
            Obstacle::Polyline { points } => points.first() != points.last(),
            Obstacle::InSpace(ObstacleInSpace::Facets(facets)) => facets.is_open(),
            _ => false,
        }
    }

    /// True if the segment between two points intersects a facet of a polyline or of a triangulated surface.
    pub fn is_crossed(&self, from: [f64; 3], to: [f64; 3]) -> bool {
        match &self.obstacle {
            Obstacle::Polyline { points } => {
                let side = |a: [f64; 2], b: [f64; 2], x: [f64; 2]| (b[0] - a[0]) * (x[1] - a[1]) - (b[1] - a[1]) * (x[0] - a[0]);
                let (p, q) = ([from[0], from[1]], [to[0], to[1]]);
                points.windows(2).any(|ends| {
                    let [a, b] = [ends[0], ends[1]];
                    side(p, q, a) * side(p, q, b) < 0.0 && side(a, b, p) * side(a, b, q) < 0.0
                })
            }
            Obstacle::InSpace(ObstacleInSpace::Facets(facets)) => facets.is_crossed(from.into(), to.into()),
            _ => false,
        }
    }

    /// Least cosine of the angle between the outward normal of a facet with its middle at `x` and the normals of the obstacle in front of
    /// the facet: -1 face to face. Segments and triangles are in front if a node lies above the plane of the facet, lowered by `slack`.
    pub fn least_cosine(&self, x: [f64; 3], outward: [f64; 3], slack: f64) -> f64 {
        let nearest = dot(self.at(x).normal, outward);
        let is_ahead = |points: &[[f64; 3]]| points.iter().any(|&point| dot(minus(point, x), outward) > -slack);
        let cosines: Vec<f64> = match &self.obstacle {
            Obstacle::Polyline { points } => {
                let normal = |ends: &[[f64; 2]]| {
                    let [a, b] = [ends[0], ends[1]];
                    let (along, length) = ([b[0] - a[0], b[1] - a[1]], (b[0] - a[0]).hypot(b[1] - a[1]));
                    is_ahead(&[[a[0], a[1], 0.0], [b[0], b[1], 0.0]]).then(|| dot([along[1] / length, -along[0] / length, 0.0], outward))
                };
                points.windows(2).filter_map(normal).collect()
            }
            Obstacle::InSpace(ObstacleInSpace::Facets(facets)) => {
                let normal = |corners: [[f64; 3]; 3]| {
                    let normal = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]));
                    is_ahead(&corners).then(|| dot(normal, outward) / dot(normal, normal).sqrt())
                };
                corners(facets).filter_map(normal).collect()
            }
            _ => Vec::new(),
        };
        // The distance has a kink inside of corners: the nearest side there need not be the side that the facet faces.
        cosines.into_iter().filter(|cosine| cosine.is_finite()).fold(nearest, f64::min)
    }

    /// Points inside of the obstacle: at least one for a bounded obstacle, the axis point nearest to `x` for an infinite cylinder.
    pub fn inner_points(&self, x: [f64; 3]) -> Vec<[f64; 3]> {
        let flat = |[x, y]: [f64; 2]| vec![[x, y, 0.0]];
        match &self.obstacle {
            Obstacle::Disk { center, .. } => flat(*center),
            Obstacle::Polyline { points } if !self.is_open() => self.inside(points.iter().map(|&[x, y]| [x, y, 0.0])),
            Obstacle::InSpace(shape) => match shape {
                ObstacleInSpace::Sphere { center, is_hollow: false, .. } => vec![*center],
                ObstacleInSpace::Cylinder { point, axis, is_hollow: false, .. } => {
                    let part = dot(minus(x, *point), *axis) / dot(*axis, *axis);
                    vec![std::array::from_fn(|i| point[i] + part * axis[i])]
                }
                ObstacleInSpace::FiniteCylinder { center, axis, radius, length, .. } => {
                    // Points of the axis that are at least as far from the ends as from the side.
                    let half = (0.5 * length - radius.min(0.5 * length)) / dot(*axis, *axis).sqrt();
                    let part = (dot(minus(x, *center), *axis) / dot(*axis, *axis)).clamp(-half, half);
                    vec![std::array::from_fn(|i| center[i] + part * axis[i])]
                }
                ObstacleInSpace::Torus { center, axis, radius, is_hollow: false, .. } => around(*center, *axis, *radius),
                ObstacleInSpace::Facets(facets) if !self.is_open() => self.inside(facets.points().iter().copied()),
                _ => Vec::new(),
            },
            _ => Vec::new(),
        }
    }

    /// Mean of the points if it lies inside of the obstacle.
    fn inside(&self, points: impl ExactSizeIterator<Item = [f64; 3]>) -> Vec<[f64; 3]> {
        let count = points.len() as f64;
        let mean = points.fold([0.0; 3], |sum, x| std::array::from_fn(|i| sum[i] + x[i] / count));
        if self.at(mean).gap < 0.0 { vec![mean] } else { Vec::new() }
    }
}

fn corners(facets: &Arc<Facets>) -> impl Iterator<Item = [[f64; 3]; 3]> {
    facets.triangles().iter().map(|nodes| nodes.map(|node| facets.points()[node as usize]))
}

/// Points on a circle about an axis.
fn around(center: [f64; 3], axis: [f64; 3], radius: f64) -> Vec<[f64; 3]> {
    let unit = |v: [f64; 3]| v.map(|x| x / dot(v, v).sqrt());
    let least = (0..3).min_by(|&i, &k| axis[i].abs().total_cmp(&axis[k].abs())).unwrap_or(0);
    let first = unit(cross(axis, std::array::from_fn(|i| f64::from(u8::from(i == least)))));
    let second = unit(cross(axis, first));
    let point = |k: usize| {
        let (sine, cosine) = (std::f64::consts::TAU * k as f64 / AROUND as f64).sin_cos();
        std::array::from_fn(|i| center[i] + radius * (cosine * first[i] + sine * second[i]))
    };
    (0..AROUND).map(point).collect()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3])
}
