//! Free coordinate of a joint (angle, displacement or distance): its value, its prescription by a drive, its limits by stops.
//!
//! An angle `phi` between directions `b` of one end and `a`, `n` of the other one, unit vectors perpendicular to the axis and to each
//! other, is given by `b.a = cos phi`, `b.n = sin phi`, so that
//!
//! ```text
//! drive   Phi = h sin(phi - s)                                     = h (cos s b.n - sin s b.a)
//! stops   Phi = h (cos(phi - m) - cos w) / sin w >= 0              m: middle of the range, w: half its width
//! gear    Phi = h (phi_1 + ratio phi_2)                            over whole turns, see `contact/geared.rs`
//! ```
//!
//! A displacement is `r.t` with the vector `r` between the points and a direction `t` of the first end. A distance is `|r|`, prescribed or
//! limited as `(|r|^2 - s^2) / (2 l)`. All functions are quadratic in points and directions, so that their gradients at mid-step are
//! discrete gradients, and invariant under rigid motions of both ends: energy is exact, and momenta between two bodies are conserved.

use super::body::Body;
use super::joint_ends::{End, across};
use super::joint_reaction::JointReaction;
use crate::contact::{CoordinateKind, DrivenFunction, Geared, PointConstraints, PointFunction, PointVector};
use crate::dynamics::model::definitions::Model;
use crate::dynamics::model::joints::{Coordinate, JointDefinition, JointFriction, JointKind};

/// Free coordinate of a joint in global node numbers.
pub struct FreeMotion {
    dimension: usize,
    coordinate: Coordinate,
    /// Vectors `b, a, n` of an angle, `r, t` of a displacement, `r` of a distance.
    vectors: Vec<PointVector>,
    /// Reference value: `r.t` of a displacement, `l` of a distance.
    rest: f64,
    /// Length that converts an angle to a gap.
    size: f64,
    /// True if the coordinate may be less than the prescribed value.
    is_cable: bool,
    is_grounded: bool,
}

impl FreeMotion {
    /// Coordinate of a joint; `None` for joints without one. `size` converts angles to lengths.
    pub fn new<const D: usize>(model: &Model, bodies: &[Body<D>], joint: &JointDefinition, size: f64) -> Option<Self> {
        let coordinate = joint.kind.coordinate(D)?;
        let [a, b] = End::of(model, bodies, joint);
        let [t, n, m] = across(joint.kind.direction().unwrap_or([1.0, 0.0, 0.0]));
        let between = || b.point().minus(&a.point());
        let (vectors, rest) = match coordinate {
            Coordinate::Angle if D == 2 => (vec![b.direction(t), a.direction(t), a.direction(n)], 0.0),
            Coordinate::Angle => (vec![b.direction(n), a.direction(n), a.direction(m)], 0.0),
            Coordinate::Travel => {
                let rest = joint.distance().iter().zip(t).map(|(r, t)| r * t).sum();
                (vec![between(), a.direction(t)], rest)
            }
            Coordinate::Distance => (vec![between()], joint.at_rest()),
        };
        let (is_cable, is_grounded) = (matches!(joint.kind, JointKind::Cable(_)), joint.is_grounded());
        Some(FreeMotion { dimension: D, coordinate, vectors, rest, size, is_cable, is_grounded })
    }

    /// Value of the coordinate at the positions `q`; an angle is taken in the turn nearest to the value `before`.
    pub fn value(&self, q: &[f64], before: f64) -> f64 {
        let y: Vec<[f64; 3]> = self.vectors.iter().map(|vector| vector.at(self.dimension, q)).collect();
        let dot = |i: usize, j: usize| -> f64 { y[i].iter().zip(y[j]).map(|(a, b)| a * b).sum() };
        match self.coordinate {
            Coordinate::Angle => {
                let angle = dot(0, 2).atan2(dot(0, 1));
                angle + std::f64::consts::TAU * ((before - angle) / std::f64::consts::TAU).round()
            }
            Coordinate::Travel => dot(0, 1) - self.rest,
            Coordinate::Distance => dot(0, 0).sqrt(),
        }
    }

    /// Limit of the friction of the coordinate, whose joint has `components` components of the transverse reaction.
    pub fn limit_of(&self, components: usize, friction: &JointFriction, is_driven: bool) -> JointReaction {
        let rotates = self.coordinate == Coordinate::Angle;
        let arm = if rotates { self.size } else { 1.0 };
        JointReaction::new(components, friction.limit(rotates).map(|limit| limit / arm), self.is_grounded, is_driven)
    }

    /// Adds the constraint that prescribes the coordinate.
    pub fn drive_into(&self, kernel: &mut PointConstraints) {
        let (size, rest) = (self.size, self.rest);
        let sign = if self.is_cable { -1.0 } else { 1.0 };
        let function: DrivenFunction = match self.coordinate {
            Coordinate::Angle => Box::new(move |angle| {
                let (sine, cosine) = angle.sin_cos();
                PointFunction { products: vec![(0, 1, -size * sine), (0, 2, size * cosine)], ..PointFunction::default() }
            }),
            Coordinate::Travel => {
                Box::new(move |travel| PointFunction { products: vec![(0, 1, 1.0)], linear: Vec::new(), constant: -(rest + travel) })
            }
            Coordinate::Distance => Box::new(move |distance| distance_beyond(sign, distance, rest)),
        };
        let start = if self.coordinate == Coordinate::Distance { rest } else { 0.0 };
        kernel.add_driven(self.vectors.clone(), function, start, self.is_grounded);
    }

    /// Adds the constraints of stops that limit the coordinate to a range.
    pub fn limit_into(&self, [least, largest]: [f64; 2], kernel: &mut PointConstraints) {
        let functions = match self.coordinate {
            Coordinate::Angle => {
                let (middle, (sine, cosine)) = (0.5 * (least + largest), (0.5 * (largest - least)).sin_cos());
                let by = self.size / sine;
                let products = vec![(0, 1, by * middle.cos()), (0, 2, by * middle.sin())];
                vec![PointFunction { products, linear: Vec::new(), constant: -by * cosine }]
            }
            Coordinate::Travel => {
                let beyond = |sign: f64, travel: f64| PointFunction {
                    products: vec![(0, 1, sign)],
                    linear: Vec::new(),
                    constant: -sign * (self.rest + travel),
                };
                vec![beyond(1.0, least), beyond(-1.0, largest)]
            }
            Coordinate::Distance => {
                let shortest = (least > 0.0).then(|| distance_beyond(1.0, least, least));
                shortest.into_iter().chain([distance_beyond(-1.0, largest, largest)]).collect()
            }
        };
        kernel.add(self.vectors.clone(), functions, None, self.is_grounded);
    }
}

/// Constraint `s_1 + ratio s_2 = 0` of the coordinates of two joints, as a length; `size` converts angles.
pub fn geared(coupled: &[FreeMotion], ratio: f64, size: f64) -> Geared {
    let (mut vectors, mut functions, mut coordinates) = (Vec::new(), Vec::new(), Vec::new());
    let product = |a: usize, b: usize, constant: f64| PointFunction { products: vec![(a, b, 1.0)], linear: Vec::new(), constant };
    for (motion, factor) in coupled.iter().zip([1.0, ratio]) {
        let first = vectors.len();
        vectors.extend(motion.vectors.iter().cloned());
        let kind = match motion.coordinate {
            Coordinate::Angle => CoordinateKind::Angle,
            Coordinate::Travel => CoordinateKind::Travel,
            Coordinate::Distance => CoordinateKind::Distance,
        };
        match kind {
            CoordinateKind::Angle => functions.extend([product(first, first + 1, 0.0), product(first, first + 2, 0.0)]),
            CoordinateKind::Travel => functions.push(product(first, first + 1, -motion.rest)),
            CoordinateKind::Distance => functions.push(product(first, first, 0.0)),
        }
        coordinates.push((kind, factor));
    }
    // Scaled so that the coordinate with the larger coefficient has the coefficient 1 as a length.
    let arm = |(kind, factor): &(CoordinateKind, f64)| factor.abs() / if *kind == CoordinateKind::Angle { size } else { 1.0 };
    let largest = coordinates.iter().map(arm).fold(0.0, f64::max);
    coordinates.iter_mut().for_each(|(_, factor)| *factor /= largest);
    let dimension = coupled.first().map_or(2, |motion| motion.dimension);
    let mut inner = PointConstraints::new(dimension, size);
    inner.add(vectors, functions, None, coupled.iter().any(|motion| motion.is_grounded));
    Geared::new(inner, dimension, coordinates, size)
}

/// Function `sign (|r|^2 - distance^2) / (2 length)` of vector 0 of the group, `r`.
fn distance_beyond(sign: f64, distance: f64, length: f64) -> PointFunction {
    let by = 0.5 * sign / length;
    PointFunction { products: vec![(0, 0, by)], linear: Vec::new(), constant: -by * distance * distance }
}
