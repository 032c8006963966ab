//! Height profiles of curved facets in the plane: the curve through the nodes of a surface as a height over each straight facet. Used by
//! all contact methods of the plane.
//!
//! A facet of length `l` has the height `l p(xi)` at the facet coordinate `xi` in [0, 1], positive outwards. The quartic `p` belongs to the
//! reference configuration and is constant in facet coordinates: displacements are linear on a facet, so that the curve moves with it, and
//! rigid motions leave it unchanged.
//!
//! The quartic has the heights and slopes of the curve at both ends, so that adjacent curves join smoothly, and its mean height `A`, which
//! preserves the interference of press fits. Edges of first order derive `p` from the neighboring facets. The circle through three
//! consecutive nodes leaves the facet at its end `i` by the angle `a_i = theta_i l/(l + l_neighbor)`, with the angle `theta_i` between both
//! facets:
//!
//! ```text
//! p(0) = p(1) = 0,    p'(0) = tan a_1,    p'(1) = -tan a_2,    A = (c_1 + c_2)/12,    c_i = a_i (1 + 2/15 a_i^2)
//! ```
//!
//! `A` is the area of the circular segment. Edges of second order follow the circle through their three nodes (`quadratic.rs`).

use std::f64::consts::PI;

use super::numbers::Number;
use super::surface::Surface;
use crate::math::tolerances::STRAIGHT;

/// Largest angle between two facets of a curve, 25 degrees: sixteen facets are a circle, twelve a polygon. Disks of twelve facets that
/// count as circles fail to separate in `tests/scripts/attack/energy.rhai`.
const LARGEST_TURN: f64 = 25.0 * PI / 180.0;

/// Largest ratio of the curvatures at neighboring nodes of a curve, and of the slopes at both ends of a facet.
const LARGEST_RATIO: f64 = 3.0;

/// Height of a curve over a facet, in facet lengths: `p(xi) = sum_k c_k xi^k`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Profile(pub [f64; 5]);

impl Profile {
    /// Profile with the height and slope at each end, and the mean height.
    pub fn new([a, rise]: [f64; 2], [b, fall]: [f64; 2], mean: f64) -> Self {
        // Cubic through the ends, plus the quartic xi^2 (1 - xi)^2 of mean height 1/30.
        let extra = 30.0 * (mean - 0.5 * (a + b) - (rise - fall) / 12.0);
        Profile([a, rise, 3.0 * (b - a) - 2.0 * rise - fall + extra, 2.0 * (a - b) + rise + fall - 2.0 * extra, extra])
    }

    /// Profile in the coordinate `1 - xi`.
    pub fn reversed(&self) -> Self {
        let Profile([a, b, c, d, e]) = self;
        Profile([a + b + c + d + e, -b - 2.0 * c - 3.0 * d - 4.0 * e, c + 3.0 * d + 6.0 * e, -d - 4.0 * e, *e])
    }

    /// True if the profile is zero: a straight facet.
    pub fn is_flat(&self) -> bool {
        self.0 == [0.0; 5]
    }

    /// Height `p(xi)` and its first two derivatives.
    #[inline(always)]
    pub fn at<T: Number>(&self, xi: T) -> [T; 3] {
        let [a, b, c, d, e] = self.0;
        [
            (((xi * e + d) * xi + c) * xi + b) * xi + a,
            ((xi * (4.0 * e) + 3.0 * d) * xi + 2.0 * c) * xi + b,
            (xi * (12.0 * e) + 6.0 * d) * xi + 2.0 * c,
        ]
    }

    /// Height of the curve, continued beyond the ends of the facet along its tangents.
    pub fn continued<T: Number>(&self, xi: T) -> T {
        let inside = xi.re().clamp(0.0, 1.0);
        if inside == xi.re() {
            return self.at(xi)[0];
        }
        let [height, slope, _] = self.at(inside);
        (xi - inside) * slope + height
    }

    /// Facet coordinate `xi = eta + tilt p(xi)` of the intersection of the curve with a straight line, which crosses the facet at `eta` and
    /// moves along it by `tilt` per unit of height.
    ///
    /// Three Newton iterations reach round-off for the value and for the derivatives of `T`, because slopes of profiles are below 0.3.
    #[inline(always)]
    pub fn seen_at<T: Number>(&self, eta: T, tilt: T) -> T {
        let mut xi = eta;
        for _ in 0..3 {
            let [height, slope, _] = self.at(xi);
            xi = xi - (xi - tilt * height - eta) / (-(tilt * slope) + 1.0);
        }
        xi
    }

    /// Height `p(xi)` and its first two derivatives at the point [`Profile::seen_at`]. A Taylor expansion about the second iterate replaces
    /// the third Newton iteration. It neglects the square of the last increment, which is below 1e-9 for tilts below 0.3.
    #[inline(always)]
    pub fn at_seen(&self, eta: f64, tilt: f64) -> [f64; 3] {
        let mut xi = eta;
        for _ in 0..2 {
            let [height, slope, _] = self.at(xi);
            xi -= (xi - tilt * height - eta) / (1.0 - tilt * slope);
        }
        let [height, slope, bend] = self.at(xi);
        let rest = (tilt * height + eta - xi) / (1.0 - tilt * slope);
        let third = 6.0 * self.0[3] + 24.0 * self.0[4] * xi;
        [height + rest * slope, slope + rest * bend, bend + rest * third]
    }
}

/// Height profiles of the secondary facet, and of the primary facet from its second node on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairProfiles(pub [Profile; 2]);

/// Shape of a plane surface at a node.
#[derive(Clone, Copy, Debug, PartialEq)]
enum NodeShape {
    /// Collinear facets.
    None,
    /// Node of a curve with the angle between its facets, positive on a convex body `[rad]`.
    Smooth(f64),
    /// Corner, isolated kink, end of a chain, or node of more than two facets.
    Sharp,
}

/// Convex curve at a node between two facets.
pub(super) struct Bend {
    /// Angle between the facets `[rad]`.
    pub turn: f64,
    /// Indices of the nodes before and after the node.
    pub neighbors: [usize; 2],
    /// Lengths of the facets before and after the node `[length]`.
    pub lengths: [f64; 2],
    /// Distance between the nodes before and after the node `[length]`.
    pub span: f64,
    /// True for each facet that follows a curve.
    pub is_curved: [bool; 2],
}

/// Curves that the facets of a plane surface follow at given positions.
pub struct FacetCurves<'a> {
    surface: &'a Surface,
    q: &'a [f64],
    turns: Vec<NodeShape>,
}

impl<'a> FacetCurves<'a> {
    /// Detects curves, corners and straight lines at the positions `q`.
    ///
    /// A node lies on a curve if the angle there is at most [`LARGEST_TURN`], and at one of the two neighboring nodes the surface bends to
    /// the same side with a curvature within a factor of [`LARGEST_RATIO`]. An isolated kink is a corner.
    pub fn new(surface: &'a Surface, q: &'a [f64]) -> Self {
        let mut curves = FacetCurves { surface, q, turns: Vec::new() };
        let count = surface.nodes().len();
        let turns: Vec<Option<(f64, [u32; 2])>> = (0..count).map(|node| curves.turn_at(node)).collect();
        let curvature = |node: usize| {
            let (turn, facets) = turns[node]?;
            (turn.abs() <= LARGEST_TURN).then(|| turn / facets.iter().map(|&facet| curves.length(facet)).sum::<f64>())
        };
        let turn_of = |node: usize| {
            let Some((turn, facets)) = turns[node] else { return NodeShape::Sharp };
            if turn.abs() <= STRAIGHT {
                return NodeShape::None;
            }
            let goes_on = |other: u32| {
                let (own, next) = (curvature(node), curvature(other as usize));
                own.zip(next).is_some_and(|(own, next)| {
                    own * next > 0.0 && own.abs() <= LARGEST_RATIO * next.abs() && next.abs() <= LARGEST_RATIO * own.abs()
                })
            };
            let neighbors = facets.into_iter().flat_map(|facet| surface.local_facets()[facet as usize]);
            if neighbors.into_iter().any(|other| other as usize != node && goes_on(other)) {
                NodeShape::Smooth(turn)
            } else {
                NodeShape::Sharp
            }
        };
        curves.turns = (0..count).map(turn_of).collect();
        curves
    }

    /// Angle at a node between its two facets `[rad]`, with the facets before and after it; `None` unless the node has two facets.
    fn turn_at(&self, node: usize) -> Option<(f64, [u32; 2])> {
        let &[one, other] = self.surface.adjacent_facets(node) else { return None };
        let [before, after] = if self.surface.local_facets()[one as usize][1] as usize == node { [one, other] } else { [other, one] };
        let (t, u) = (self.along(before), self.along(after));
        let joins = self.surface.local_facets()[after as usize][0] as usize == node;
        joins.then(|| ((t[0] * u[1] - t[1] * u[0]).atan2(t[0] * u[0] + t[1] * u[1]), [before, after]))
    }

    /// Convex curve at a node; `None` for corners, straight and concave sides. With `is_known`, every convex node with two facets lies on a
    /// curve.
    pub(super) fn bend(&self, node: usize, is_known: bool) -> Option<Bend> {
        let (turn, facets) = self.turn_at(node)?;
        let is_smooth = is_known || matches!(self.turns[node], NodeShape::Smooth(_));
        if !is_smooth || turn <= STRAIGHT {
            return None;
        }
        let [before, after] = facets.map(|facet| self.along(facet));
        Some(Bend {
            turn,
            neighbors: [
                self.surface.local_facets()[facets[0] as usize][0] as usize,
                self.surface.local_facets()[facets[1] as usize][1] as usize,
            ],
            lengths: facets.map(|facet| self.length(facet)),
            span: (before[0] + after[0]).hypot(before[1] + after[1]),
            is_curved: facets.map(|facet| self.is_curved(facet as usize)),
        })
    }

    /// Vector from the first to the last node of a facet `[length]`.
    fn along(&self, facet: u32) -> [f64; 2] {
        let [a, b] = self.surface.facets()[facet as usize].map(|node| 2 * node as usize);
        [self.q[b] - self.q[a], self.q[b + 1] - self.q[a + 1]]
    }

    fn length(&self, facet: u32) -> f64 {
        let [x, y] = self.along(facet);
        x.hypot(y)
    }

    /// True if a facet follows a curve: the surface bends to the same side at both of its nodes, or bends at one node while the other is
    /// sharp.
    fn is_curved(&self, facet: usize) -> bool {
        match self.surface.local_facets()[facet].map(|node| self.turns[node as usize]) {
            [NodeShape::Smooth(a), NodeShape::Smooth(b)] => a * b > 0.0,
            [NodeShape::Smooth(_), NodeShape::Sharp] | [NodeShape::Sharp, NodeShape::Smooth(_)] => true,
            _ => false,
        }
    }

    /// Height profiles of all facets.
    pub fn profiles(&self) -> Vec<Profile> {
        (0..self.surface.count()).map(|facet| self.profile(facet)).collect()
    }

    fn profile(&self, facet: usize) -> Profile {
        if !self.is_curved(facet) {
            return Profile::default();
        }
        let length = self.length(facet as u32);
        let (ends, neighbors) = (self.surface.local_facets()[facet], self.surface.neighbors(facet));
        // Next to a straight facet, the whole angle belongs to this facet.
        let angle = |end: usize| match (self.turns[ends[end] as usize], neighbors[end]) {
            (NodeShape::Smooth(turn), Some(other)) if self.is_curved(other as usize) => Some(turn * length / (length + self.length(other))),
            (NodeShape::Smooth(turn), _) => Some(turn),
            _ => None,
        };
        let [a, b] = match [0, 1].map(angle) {
            [Some(a), Some(b)] => {
                let largest = LARGEST_RATIO * a.abs().min(b.abs());
                [a.clamp(-largest, largest), b.clamp(-largest, largest)]
            }
            [Some(a), None] | [None, Some(a)] => [a, a],
            [None, None] => return Profile::default(),
        };
        let area = |angle: f64| angle * (1.0 + 2.0 / 15.0 * angle * angle) / 12.0;
        Profile::new([0.0, a.tan()], [0.0, -b.tan()], area(a) + area(b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profiles_are_polynomials() {
        let p = Profile([0.1, 0.2, -0.3, 0.4, 0.5]);
        for x in [0.0, 0.3, 1.0_f64] {
            assert!((p.at(x)[0] - p.reversed().at(1.0 - x)[0]).abs() < 1e-14);
            assert!((p.at(x)[1] + p.reversed().at(1.0 - x)[1]).abs() < 1e-14);
        }
        let mean = 0.1 + 0.2 / 2.0 - 0.3 / 3.0 + 0.4 / 4.0 + 0.5 / 5.0;
        let [a, b] = [0.0, 1.0_f64].map(|x| p.at(x));
        let q = Profile::new([a[0], a[1]], [b[0], b[1]], mean);
        assert!((0..5).all(|k| (p.0[k] - q.0[k]).abs() < 1e-13), "{q:?}");
    }

    /// Profiles of a chain of facets through the given points.
    fn of_chain(points: &[[f64; 2]], is_closed: bool) -> Vec<Profile> {
        let count = points.len() as u32;
        let facets: Vec<[u32; 2]> = (0..if is_closed { count } else { count - 1 }).map(|k| [k, (k + 1) % count]).collect();
        let q = points.as_flattened();
        FacetCurves::new(&Surface::new(&facets), q).profiles()
    }

    fn circle(count: u32, from: f64, to: f64) -> impl Iterator<Item = [f64; 2]> {
        (0..count).map(move |k| (from + (to - from) * f64::from(k) / f64::from(count)).sin_cos()).map(|(sin, cos)| [cos, sin])
    }

    /// Closed form: height of the unit circle over its chord.
    #[test]
    fn circles_are_followed_from_sixteen_facets_on() {
        for count in [16, 20, 48] {
            let half = PI / f64::from(count);
            let (chord, apothem) = (2.0 * half.sin(), half.cos());
            for profile in of_chain(&circle(count, 0.0, 2.0 * PI).collect::<Vec<_>>(), true) {
                let mut area = 0.0;
                for k in 0..100 {
                    let xi = (f64::from(k) + 0.5) / 100.0;
                    let height = ((1.0 - (chord * (xi - 0.5)).powi(2)).sqrt() - apothem) / chord;
                    assert!((profile.at(xi)[0] - height).abs() < 0.02 * half.powi(3), "{count}: {profile:?} {xi}");
                    area += 0.01 * (profile.at(xi)[0] - height);
                }
                // The midpoint rule with 100 points has an error of 1e-5.
                assert!(area.abs() < 0.05 * half.powi(5) + 1e-5 * half, "{count}: {area}");
                assert!((profile.at(0.0)[1] - half.tan()).abs() < 1e-12 && (profile.at(1.0)[1] + half.tan()).abs() < 1e-12);
            }
        }
        assert!(of_chain(&circle(12, 0.0, 2.0 * PI).collect::<Vec<_>>(), true).iter().all(Profile::is_flat));
    }

    /// A straight side, a tangent quarter circle, and another straight side: only the arc is curved, up to its ends.
    #[test]
    fn arcs_between_straight_sides_are_followed_to_their_ends() {
        let mut points = vec![[1.0, -2.0], [1.0, -1.0]];
        points.extend(circle(6, 0.0, 0.5 * PI));
        points.extend([[0.0, 1.0], [-1.0, 1.0], [-2.0, 1.0]]);
        let profiles = of_chain(&points, false);
        let curved: Vec<bool> = profiles.iter().map(|profile| !profile.is_flat()).collect();
        assert_eq!(curved, [false, false, true, true, true, true, true, true, false, false]);
        let half = PI / 24.0;
        for profile in &profiles[2..8] {
            assert!((profile.at(0.0)[1] - half).abs() < 1e-2 * half && (profile.at(1.0)[1] + half).abs() < 1e-2 * half, "{profile:?}");
        }
    }

    #[test]
    fn single_kinks_corners_and_waves_are_not_followed() {
        let kink = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.2], [3.0, 0.4]];
        let bevel = [[0.0, -1.0], [0.0, 0.0], [1.0, 0.2], [2.0, 0.2], [3.0, 0.2]];
        let wave = [[0.0, 0.0], [1.0, 0.1], [2.0, 0.0], [3.0, 0.1], [4.0, 0.0]];
        for chain in [&kink[..], &bevel, &wave] {
            assert!(of_chain(chain, false).iter().all(Profile::is_flat), "{chain:?}");
        }
    }
}
