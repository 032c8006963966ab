//! Projection of a facet pair in space along the secondary normal: plane coordinates and heights of its points.

use std::ops::Mul;
use std::sync::Arc;

use super::closing::Heights;
use super::forms::{Form, turned};
use super::quartic::{Closed, FLAT};
use super::stretch::{Stretch, Stretched};
use super::vectors::{FacetFrame, Vec3, cross, diagonal_ends, dot, scaled, sub};
use super::vertices::{CORNERS, NODES, PerTriangle};
use crate::contact::numbers::Number;

/// Largest number of points of a pair: its nodes, then the mean points of both facets.
pub const POINTS: usize = NODES + 2;

/// Projection of a facet pair along the secondary normal.
pub struct View<T> {
    /// Numbers of nodes of the secondary and of the primary facet.
    pub counts: [usize; 2],
    /// Plane axes, normal, and diagonals of the secondary facet.
    pub frame: FacetFrame<T>,
    /// Positions relative to the mean point of the secondary facet.
    pub arms: [Vec3<T>; NODES],
    /// Plane coordinates of the points.
    pub p: [[T; 2]; POINTS],
    /// Heights of the points.
    pub h: [T; POINTS],
    /// Height profiles of both facets; `None` if both are flat.
    pub curves: Option<Curves>,
}

/// Height profiles of both facets of a pair in a configuration, and the stretches of the facets.
pub struct Curves {
    /// Heights of second degree over the triangles of both facets.
    pub forms: [[Form; 4]; 2],
    /// Polynomials of the gap that the primary facet closes in the reference configuration; `None` for a flat facet.
    pub closed: Option<Arc<[Closed; 4]>>,
    /// Functions of the node positions that give the stretches of both facets.
    pub of_nodes: [Stretch; 2],
    pub stretches: [Stretched<f64>; 2],
}

/// Least and largest coordinates along both plane axes.
type Bounds = [(f64, f64); 2];

/// True if two boxes are disjoint.
#[inline(always)]
pub fn are_apart(a: &Bounds, b: &Bounds) -> bool {
    (0..2).any(|axis| a[axis].0 >= b[axis].1 || b[axis].0 >= a[axis].1)
}

/// Point indices of the corners of a facet's triangles. The facet's nodes start at index `first`; its mean point has the index `middle`.
#[inline(always)]
pub fn triangles(count: usize, first: usize, middle: usize) -> impl Iterator<Item = [usize; 3]> {
    (0..if count == 3 { 1 } else { count })
        .map(move |k| if count == 3 { [first, first + 1, first + 2] } else { [first + k, first + (k + 1) % count, middle] })
}

impl<T: Number> View<T> {
    /// Projection for the node positions `x`, secondary ones first; `None` if the secondary facet has no area.
    #[inline(always)]
    pub fn new(x: &[Vec3<T>], counts: [usize; 2]) -> Option<Self> {
        let [own, other] = counts;
        let frame = FacetFrame::new(&x[..own])?;
        let zero = T::from(0.0);
        let mut middle = [zero; 3];
        for x in &x[..own] {
            for i in 0..3 {
                middle[i] += x[i] * (1.0 / own as f64);
            }
        }
        let mut view = View { counts, frame, arms: [[zero; 3]; NODES], p: [[zero; 2]; POINTS], h: [zero; POINTS], curves: None };
        for (k, x) in x.iter().enumerate() {
            let arm = sub(*x, middle);
            let [first, second, normal] = view.frame.axes;
            view.arms[k] = arm;
            view.p[k] = [dot(arm, first), dot(arm, second)];
            view.h[k] = dot(arm, normal);
        }
        for (place, range) in [(NODES, 0..own), (NODES + 1, own..own + other)] {
            let share = 1.0 / range.len() as f64;
            for k in range {
                let (p, h) = (view.p[k], view.h[k]);
                view.p[place][0] += p[0] * share;
                view.p[place][1] += p[1] * share;
                view.h[place] += h * share;
            }
        }
        Some(view)
    }

    /// Range of the nodes whose mean is a point, and the coefficient of each node.
    #[inline(always)]
    pub fn shares(&self, point: usize) -> (std::ops::Range<usize>, f64) {
        let [own, other] = self.counts;
        match point {
            NODES => (0..own, 1.0 / own as f64),
            _ if point == NODES + 1 => (own..own + other, 1.0 / other as f64),
            _ => (point..point + 1, 1.0),
        }
    }

    /// Height profiles of a secondary and a primary triangle, given by their corners; `None` if both facets are flat.
    #[inline(always)]
    pub fn forms(&self, [[first, ..], [_, second, _]]: &PerTriangle<usize>) -> Option<[Form; 2]> {
        let [own, other] = &self.curves.as_ref()?.forms;
        // A triangle has the index of the facet's corner at which it starts; primary triangles are listed with this corner as the second
        // one.
        Some([own[*first], turned(&other[second - self.counts[0]])])
    }

    /// Heights in the gap between a secondary and a primary triangle, given by their corners; `None` if both facets are flat.
    #[inline(always)]
    pub fn curved(&self, [[first, ..], [_, second, _]]: &PerTriangle<usize>) -> Option<Heights<'_>> {
        let Curves { forms: [own, _], closed, stretches, .. } = self.curves.as_ref()?;
        let closed = match closed {
            Some(closed) => &closed[second - self.counts[0]],
            None => &FLAT,
        };
        Some(Heights { own: own[*first], closed, stretch: stretches[1].by })
    }

    /// Plane coordinates of the corners of both triangles.
    #[inline(always)]
    pub fn places(&self, corners: &PerTriangle<usize>) -> PerTriangle<[T; 2]> {
        let [[a, b, c], [d, e, f]] = *corners;
        [[self.p[a], self.p[b], self.p[c]], [self.p[d], self.p[e], self.p[f]]]
    }

    /// Heights of the corners of both triangles.
    #[inline(always)]
    pub fn heights(&self, corners: &PerTriangle<usize>) -> PerTriangle<T> {
        let [[a, b, c], [d, e, f]] = *corners;
        [[self.h[a], self.h[b], self.h[c]], [self.h[d], self.h[e], self.h[f]]]
    }

    /// Weight function `sum w_A N_A` at the corners of a secondary triangle.
    #[inline(always)]
    pub fn weights<W: Number>(&self, secondary: [usize; 3], weights: &[W; CORNERS]) -> [W; 3] {
        let mut at = [W::from(0.0); 3];
        for (at, point) in at.iter_mut().zip(secondary) {
            let (nodes, share) = self.shares(point);
            for node in nodes {
                *at += weights[node] * share;
            }
        }
        at
    }

    /// Least and largest plane coordinate of some points.
    #[inline(always)]
    fn range(&self, points: impl Iterator<Item = usize>, axis: usize) -> (f64, f64) {
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        for point in points {
            let at = self.p[point][axis].re();
            range = (at.min(range.0), at.max(range.1));
        }
        range
    }

    /// Least and largest plane coordinates of some points.
    #[inline(always)]
    pub fn bounds(&self, points: impl Iterator<Item = usize> + Clone) -> Bounds {
        [self.range(points.clone(), 0), self.range(points, 1)]
    }

    /// Transforms derivatives with respect to plane coordinates and heights to the node positions.
    #[inline(always)]
    pub fn spread<R: Number + Mul<T, Output = R>>(&self, of_p: &[[R; 2]], of_h: &[R]) -> [Vec3<R>; NODES] {
        self.spread_with(of_p, of_h, [R::from(0.0); 3])
    }

    /// Transforms derivatives to the node positions, with a further moment about the mean point of the secondary facet.
    #[inline(always)]
    pub fn spread_with<R: Number + Mul<T, Output = R>>(&self, of_p: &[[R; 2]], of_h: &[R], mut moment: Vec3<R>) -> [Vec3<R>; NODES] {
        let FacetFrame { axes: [first, second, normal], diagonals: [c, d], length } = self.frame;
        let mut gradient = [[R::from(0.0); 3]; NODES];
        for k in 0..self.counts[0] + self.counts[1] {
            for i in 0..3 {
                gradient[k][i] = of_p[k][0] * first[i] + of_p[k][1] * second[i] + of_h[k] * normal[i];
            }
            let turn = cross(gradient[k], self.arms[k]);
            for i in 0..3 {
                moment[i] -= turn[i];
            }
        }
        // Rotation `b` of the projection normal `N/|N|`, `N = c x d` with the diagonals: b = -m x n / |N|, d N.b = dc.(d x b) + dd.(b x c)
        let tilt = scaled(cross(moment, normal), -length.recip());
        let (of_c, of_d) = (cross(tilt, d), cross(tilt, c));
        let [on_c, on_d] = diagonal_ends(self.counts[0]);
        for i in 0..3 {
            gradient[on_c.1][i] -= of_c[i];
            gradient[on_c.0][i] += of_c[i];
            gradient[on_d.1][i] += of_d[i];
            gradient[on_d.0][i] -= of_d[i];
        }
        gradient
    }
}
