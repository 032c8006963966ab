//! Overlap of two facets along averaged normals: limits, quadrature points, weighted gaps, generic in the number type (`averaged.rs`).

use super::numbers::Number;
use super::profile::{PairProfiles, Profile};
use crate::elements::GAUSS;
use crate::math::tolerances::FACING;

/// Number of difference vectors: facet before, facet, facet after, and both primary nodes relative to `x_1`.
pub(super) const DIFFERENCES: usize = 5;
/// Number of components of the difference vectors.
pub(super) const VARIABLES: usize = 2 * DIFFERENCES;

/// Three Gauss points on `[-1, 1]` with weights, for straight facets.
const THREE: [(f64, f64); 3] = [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];

/// Five Gauss points on `[-1, 1]` with weights, for facets with height profiles.
const FIVE: [(f64, f64); 5] = {
    let mut points = GAUSS;
    let mut k = 0;
    while k < points.len() {
        points[k] = (2.0 * points[k].0 - 1.0, 2.0 * points[k].1);
        k += 1;
    }
    points
};

/// One value per secondary node of the facet.
pub(super) type Values<T> = [T; 2];

/// Weighted gaps and covered lengths of a facet pair, per secondary node.
pub(super) struct WeightedGaps<T> {
    pub(super) gap: Values<T>,
    pub(super) covered: Values<T>,
}

pub(super) type Vector<T> = [T; 2];

pub(super) fn cross<T: Number>(a: Vector<T>, b: Vector<T>) -> T {
    a[0] * b[1] - a[1] * b[0]
}

pub(super) fn unit<T: Number>(a: Vector<T>) -> Vector<T> {
    let inverse = (a[0] * a[0] + a[1] * a[1]).sqrt().recip();
    [a[0] * inverse, a[1] * inverse]
}

/// Outward normal at the node between two facets with directions `own` and `other`: normalized mean of both facet normals. Without a
/// neighbor, or if both normals nearly cancel (folded surface), the normal of the own facet.
pub(super) fn normal<T: Number>(own: Vector<T>, other: Vector<T>, has_other: bool) -> Vector<T> {
    let own = unit(own);
    let mean = if has_other {
        let other = unit(other);
        [own[0] + other[0], own[1] + other[1]]
    } else {
        own
    };
    let folded = mean[0].re().hypot(mean[1].re()) < FACING;
    let [x, y] = if folded { own } else { unit(mean) };
    [y, -x]
}

/// Overlap of a secondary facet with a primary facet along the averaged normals.
pub(super) struct AveragedOverlap<T> {
    /// Secondary facet vector `x_2 - x_1`.
    pub(super) t: Vector<T>,
    /// Primary nodes relative to `x_1`.
    pub(super) y: [Vector<T>; 2],
    /// Normal at the first secondary node.
    pub(super) normal: Vector<T>,
    /// Change `n_2 - n_1` of the normal along the facet.
    pub(super) turn: Vector<T>,
    pub(super) length: T,
    /// Middle and half length of the overlap in the secondary coordinate `s`.
    pub(super) middle: T,
    pub(super) half: T,
}

/// Quadrature point of the overlap with its opposite primary point.
pub(super) struct Point<T> {
    /// Integration weight `[length]`.
    pub(super) measure: T,
    pub(super) shapes: Values<T>,
    /// Averaged normal `n(s)`, not normalized.
    pub(super) normal: Vector<T>,
    /// Distance of the opposite point along the normal, in units of `|n|`.
    pub(super) alpha: T,
    /// Coordinate of the opposite point on the primary facet, 0 to 1.
    pub(super) opposite: T,
}

impl<T: Number> AveragedOverlap<T> {
    /// Overlap from the difference vectors; `None` where the facets do not face each other or do not overlap.
    pub(super) fn new(z: &[T; VARIABLES], has: [bool; 2]) -> Option<Self> {
        let vector = |k: usize| [z[2 * k], z[2 * k + 1]];
        let [before, t, after, y_1, y_2] = std::array::from_fn(vector);
        let (n_1, n_2) = (normal(t, before, has[0]), normal(t, after, has[1]));
        let turn = [n_2[0] - n_1[0], n_2[1] - n_1[1]];
        // Condition `(y - s t) x (n_1 + s turn) = 0`, quadratic in `s`; the root that tends to the root of the linear equation as the
        // normals become parallel.
        let opposite = |y: Vector<T>| {
            let (a, b, c) = (-cross(t, turn), cross(y, turn) - cross(t, n_1), cross(y, n_1));
            let discriminant = b * b - (a * c) * 4.0;
            let admissible = b.re() > 0.0 && discriminant.re() > 0.0;
            admissible.then(|| -(c * 2.0) / (b + discriminant.sqrt()))
        };
        let (s_1, s_2) = (opposite(y_1)?, opposite(y_2)?);
        if s_1.re() - s_2.re() <= FACING {
            return None;
        }
        let a = if s_2.re() > 0.0 { s_2 } else { T::from(0.0) };
        let b = if s_1.re() < 1.0 { s_1 } else { T::from(1.0) };
        if b.re() <= a.re() {
            return None;
        }
        let length = (t[0] * t[0] + t[1] * t[1]).sqrt();
        Some(AveragedOverlap { t, y: [y_1, y_2], normal: n_1, turn, length, middle: (a + b) * 0.5, half: (b - a) * 0.5 })
    }

    /// Gauss points of the overlap: three between straight facets, five between curved ones, whose integrands have a higher degree.
    pub(super) fn points(&self, is_curved: bool) -> impl Iterator<Item = Point<T>> {
        let [y_1, y_2] = self.y;
        let along = [y_2[0] - y_1[0], y_2[1] - y_1[1]];
        let points = if is_curved { &FIVE[..] } else { &THREE };
        points.iter().map(move |&(place, weight)| {
            let s = self.middle + self.half * place;
            let n = [self.normal[0] + s * self.turn[0], self.normal[1] + s * self.turn[1]];
            let from = [y_1[0] - s * self.t[0], y_1[1] - s * self.t[1]];
            let facing = cross(n, along);
            Point {
                measure: (self.length * self.half) * weight,
                shapes: [T::from(1.0) - s, s],
                normal: n,
                // y(s) = x(s) + alpha n(s).
                alpha: cross(from, along) / facing,
                opposite: -cross(n, from) / facing,
            }
        })
    }
}

/// Components of `n` along a facet and outwards, relative to the facet vector. The body is on the left of `facet`.
fn components<T: Number>(facet: Vector<T>, n: Vector<T>) -> [T; 2] {
    let square = facet[0] * facet[0] + facet[1] * facet[1];
    [(n[0] * facet[0] + n[1] * facet[1]) / square, (n[0] * facet[1] - n[1] * facet[0]) / square]
}

/// Distance from a facet to its curve, starting at the facet point `xi` in the direction `n`, in units of `|n|`. `facet` is the facet
/// vector, with the body on its left.
fn distance_to_curve<T: Number>(profile: &Profile, facet: Vector<T>, xi: T, n: Vector<T>) -> T {
    let [along, outwards] = components(facet, n);
    profile.at(profile.seen_at(xi, along / outwards))[0] / outwards
}

/// Facet coordinate and relative height of the point of a curve in the direction `n` from the facet point `xi`.
fn point_of_curve<T: Number>(profile: &Profile, facet: Vector<T>, xi: T, n: Vector<T>) -> [T; 2] {
    let [along, outwards] = components(facet, n);
    let xi = profile.seen_at(xi, along / outwards);
    [xi, profile.at(xi)[0]]
}

impl<T: Number> AveragedOverlap<T> {
    /// Facet coordinates and relative heights of the points of both curves on the line of a quadrature point. The coordinate of the primary
    /// facet runs from its first node.
    pub(super) fn points_of_curves(&self, PairProfiles([own, other]): &PairProfiles, point: &Point<T>) -> [[T; 2]; 2] {
        let ([y_1, y_2], n) = (self.y, point.normal);
        let primary = [y_2[0] - y_1[0], y_2[1] - y_1[1]];
        let secondary = point_of_curve(own, self.t, point.shapes[1], n);
        [secondary, point_of_curve(&other.reversed(), primary, point.opposite, n.map(|x| -x))]
    }
}

/// Weighted gaps and covered lengths from the difference vectors; `None` where the facets do not face each other or do not overlap.
pub(super) fn weighted_gaps<T: Number>(z: &[T; VARIABLES], has: [bool; 2], profiles: Option<&PairProfiles>) -> Option<WeightedGaps<T>> {
    let zero = T::from(0.0);
    let mut gaps = WeightedGaps { gap: [zero; 2], covered: [zero; 2] };
    let overlap = AveragedOverlap::new(z, has)?;
    let [y_1, y_2] = overlap.y;
    let primary = [y_2[0] - y_1[0], y_2[1] - y_1[1]];
    // Along secondary normals the primary facet is traversed in reverse: profiles of primary facets begin at the second node.
    let curves = profiles.map(|PairProfiles([own, other])| [*own, other.reversed()]);
    for Point { measure, shapes, normal: n, mut alpha, opposite } in overlap.points(profiles.is_some()) {
        if let Some([own, other]) = &curves {
            alpha -= distance_to_curve(own, overlap.t, shapes[1], n);
            alpha -= distance_to_curve(other, primary, opposite, [-n[0], -n[1]]);
        }
        let gap = alpha * (n[0] * n[0] + n[1] * n[1]);
        for (k, shape) in shapes.into_iter().enumerate() {
            gaps.gap[k] += measure * shape * gap;
            gaps.covered[k] += measure * shape;
        }
    }
    Some(gaps)
}
