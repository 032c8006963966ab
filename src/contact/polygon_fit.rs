//! Press fits of polygons: what straight facets make of the interference of the curves that they stand for.
//!
//! Between its nodes a polygon stands off its curve by up to the sagitta `s = l theta/8` of its facets (length `l`, turn `theta` from one
//! to the next), in the mean by `2/3 s`: inwards where the body is convex, outwards where it is hollow. Where the sagittas of the two sides
//! differ, the polygons overlap by another amount than the curves. Where the interference is much smaller than a sagitta, corners sit in
//! each other, and what should slide is held. Facets with height profiles (`profile.rs`) lose nothing of the fit.

use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::facet_shape::FacetShape;
use super::profile::FacetCurves;
use super::surface::Surface;

/// Turn from one facet to the next in radians up to which they follow a curve: 50 degrees.
const CURVE: f64 = 0.9;

/// Difference of curvatures, as a share of the larger one, up to which surfaces fit each other.
const FIT: f64 = 0.5;

/// Whether sides with these curvatures, positive where a body is convex, fit each other.
pub(super) fn fit_each_other([a, b]: [f64; 2]) -> bool {
    (a + b).abs() <= FIT * a.abs().max(b.abs())
}

/// Press fit in sagittas below which polygons interlock.
const LOST: f64 = 0.5;

/// Share of a press fit by which that of the facets may differ.
pub(super) const DISTORTED: f64 = 0.1;

/// How far beyond the ends of a facet, in its lengths, a node may lie opposite: in the wedge between two of them.
const BESIDE: f64 = 0.1;

/// Facets of a curve, and nodes of the other one that lie opposite, from which on it is one.
pub(super) const FEW: usize = 3;

/// A press fit between polygons on curves that fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolygonFit {
    /// Mean overlap of the curves `[length]`.
    pub interference: f64,
    /// Mean sagitta of the facets, of the side on which it is larger `[length]`.
    pub sagitta: f64,
    /// By how much less the facets overlap than the curves in the mean; negative where they overlap by more `[length]`.
    pub lost: f64,
}

impl PolygonFit {
    /// Whether corners of one polygon sit in those of the other.
    pub fn interlocks(&self) -> bool {
        self.interference < LOST * self.sagitta
    }

    /// Whether the facets overlap by much less, or more, than the curves.
    pub fn is_distorted(&self) -> bool {
        self.lost.abs() > DISTORTED * self.interference
    }
}

/// A facet of a curve.
struct Arc {
    from: [f64; 2],
    /// Unit vector along it, and its length `[length]`.
    along: [f64; 2],
    length: f64,
    /// Turn from half of the facet before it to half of the one behind it, positive where the body is convex.
    turn: f64,
    /// True where the facet has a height profile.
    is_followed: bool,
}

impl Arc {
    /// By how much the curve stands off the facet at the share `s`, outwards `[length]`.
    fn rise(&self, s: f64) -> f64 {
        0.5 * s * (1.0 - s) * self.length * self.turn
    }

    /// Sagitta that contact neglects, outwards `[length]`.
    fn neglected_sagitta(&self) -> f64 {
        if self.is_followed { 0.0 } else { self.rise(0.5) }
    }
}

/// The press fit of two surfaces at `q`, where they are polygons on curves that fit and overlap.
pub fn polygon_fit(secondary: &Surface, primary: &Surface, q: &[f64], facets: FacetShape) -> Option<PolygonFit> {
    let (own, others) = (arcs(secondary, q, facets), arcs(primary, q, facets));
    let at = |node: u32| [q[2 * node as usize], q[2 * node as usize + 1]];
    let middles = others.iter().flatten().map(|arc| GeomWithData::new([0, 1].map(|i| arc.from[i] + 0.5 * arc.length * arc.along[i]), arc));
    let tree = RTree::bulk_load(middles.collect());
    let mut overlaps = Vec::new();
    let mut sagittas = [0.0; 2];
    for (facet, arc) in own.iter().enumerate() {
        let Some(arc) = arc else { continue };
        let x = at(secondary.facets()[facet][0]);
        let Some((other, s, gap)) = opposite(x, arc, &tree) else { continue };
        if fit_each_other([arc, other].map(|arc| arc.turn / arc.length)) {
            overlaps.push(other.rise(s) - gap);
            [arc, other].iter().zip(&mut sagittas).for_each(|(arc, sum)| *sum += arc.neglected_sagitta());
        }
    }
    let count = overlaps.len() as f64;
    let interference = overlaps.iter().sum::<f64>() / count;
    let sagitta = sagittas[0].abs().max(sagittas[1].abs()) / count;
    let lost = (sagittas[0] + sagittas[1]) * 2.0 / (3.0 * count);
    (overlaps.len() >= FEW && interference > 0.0).then_some(PolygonFit { interference, sagitta, lost })
}

/// The facets of a surface that follow a curve.
fn arcs(surface: &Surface, q: &[f64], facets: FacetShape) -> Vec<Option<Arc>> {
    let profiles = FacetCurves::new(surface, q).profiles();
    let at = |node: u32| [q[2 * node as usize], q[2 * node as usize + 1]];
    let along = |facet: u32| {
        let [a, b] = surface.facets()[facet as usize].map(at);
        let t = [b[0] - a[0], b[1] - a[1]];
        let length = t[0].hypot(t[1]);
        (t.map(|t| t / length), length)
    };
    let turn = |before: [f64; 2], after: [f64; 2]| {
        let angle = (before[0] * after[1] - before[1] * after[0]).atan2(before[0] * after[0] + before[1] * after[1]);
        (angle.abs() <= CURVE).then_some(angle)
    };
    let arc = |facet: u32| {
        let (t, length) = along(facet);
        let [before, after] = surface.neighbors(facet as usize);
        let turn = 0.5 * (turn(along(before?).0, t)? + turn(t, along(after?).0)?);
        let is_followed = facets == FacetShape::Curved && !profiles[facet as usize].is_flat();
        Some(Arc { from: at(surface.facets()[facet as usize][0]), along: t, length, turn, is_followed })
    };
    (0..surface.facets().len() as u32).map(arc).collect()
}

/// The arc that looks back at the point's own and has the point within its length on either side, of the nearest ones: with the point's
/// share of the arc and its gap from the facet `[length]`.
fn opposite<'a>(x: [f64; 2], own: &Arc, others: &RTree<GeomWithData<[f64; 2], &'a Arc>>) -> Option<(&'a Arc, f64, f64)> {
    let seen = others.nearest_neighbor_iter(x).take(FEW).filter_map(|found| {
        let (arc, d) = (found.data, [x[0] - found.data.from[0], x[1] - found.data.from[1]]);
        let s = (arc.along[0] * d[0] + arc.along[1] * d[1]) / arc.length;
        let gap = arc.along[1] * d[0] - arc.along[0] * d[1];
        let looks_back = arc.along[0] * own.along[0] + arc.along[1] * own.along[1] < 0.0;
        ((-BESIDE..=1.0 + BESIDE).contains(&s) && gap.abs() < arc.length && looks_back).then_some((arc, s, gap))
    });
    seen.min_by(|a, b| a.2.abs().total_cmp(&b.2.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rings of the node radius 1 outside and `1 + fit` inside.
    fn found(inner: u32, outer: u32, fit: f64) -> Option<PolygonFit> {
        let circle = |count: u32, radius: f64| {
            (0..count).flat_map(move |i| {
                let angle = std::f64::consts::TAU * f64::from(i) / f64::from(count);
                [radius * angle.cos(), radius * angle.sin()]
            })
        };
        let q: Vec<f64> = circle(inner, 1.0 + fit).chain(circle(outer, 1.0)).collect();
        let own: Vec<[u32; 2]> = (0..inner).map(|i| [i, (i + 1) % inner]).collect();
        let other: Vec<[u32; 2]> = (0..outer).map(|i| [inner + (i + 1) % outer, inner + i]).collect();
        polygon_fit(&Surface::new(&own), &Surface::new(&other), &q, FacetShape::Straight)
    }

    /// Closed form: a regular polygon of n sides through a circle of radius r has the sagitta r (1 - cos(pi/n)).
    #[test]
    fn press_fits_below_the_sagitta_are_found() {
        let sagitta = 1.002 * (1.0 - (std::f64::consts::PI / 20.0).cos());
        let lost = found(20, 24, 0.002).expect("the circles overlap");
        assert!((lost.interference / 0.002 - 1.0).abs() < 0.1 && (lost.sagitta / sagitta - 1.0).abs() < 0.02, "{lost:?}");
        let interlocks = |inner, outer, fit| found(inner, outer, fit).is_some_and(|fit| fit.interlocks());
        assert!(interlocks(20, 24, 0.002) && !interlocks(20, 24, 0.02) && !interlocks(200, 240, 0.002));
        assert_eq!(found(20, 24, -0.1), None);
    }

    /// Closed form: mean distance of a regular polygon of n sides from its circle of radius r, `r (1 - sin(2 pi/n)/(2 pi/n))/2` from the
    /// areas of both.
    #[test]
    fn what_facets_take_from_a_press_fit_is_found() {
        let off = |n: f64, radius: f64| {
            let turn = std::f64::consts::TAU / n;
            0.5 * radius * (1.0 - turn.sin() / turn)
        };
        for (inner, outer) in [(40, 48), (48, 40), (48, 48)] {
            let fit = found(inner, outer, 0.002).expect("the circles overlap");
            let lost = off(f64::from(inner), 1.002) - off(f64::from(outer), 1.0);
            assert!((fit.lost - lost).abs() < 1e-2 * lost.abs() + 2e-5, "{inner} on {outer}: {fit:?} against {lost}");
            assert_eq!(fit.is_distorted(), inner != outer);
        }
    }

    #[test]
    fn straight_sides_do_not_interlock() {
        let q = [0.0, 0.0, 1.0, 0.0, 2.0, 0.0, 3.0, 0.0, 4.0, 0.0, 4.0, -0.01, 3.0, -0.01, 2.0, -0.01, 1.0, -0.01, 0.0, -0.01];
        let [own, other] = [0, 5].map(|first| Surface::new(&[0, 1, 2, 3].map(|i| [first + i, first + i + 1])));
        assert_eq!(polygon_fit(&own, &other, &q, FacetShape::Straight), None);
    }
}
