//! Press fits between polygons: interference that is lost by straight facets in place of the curves through their nodes (for `checks.rs`).
//!
//! A polygon deviates from its curve by at most the sagitta `s = l theta/8` (facet length `l`, angle `theta` between adjacent facets), on
//! average by `2/3 s`: inwards on a convex body, outwards on a hollow one. If the sagittas of both sides differ, the interference of the
//! polygons differs from that of the curves. If the interference is much smaller than a sagitta, corners of the polygons interlock and
//! prevent sliding. Facets with height profiles (`profile.rs`) keep the full interference.

use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::facet_shape::FacetShape;
use super::profile::FacetCurves;
use super::surface::Surface;

/// Largest angle between adjacent facets of a curve, in radians: 50 degrees.
const CURVE: f64 = 0.9;

/// Largest difference of curvatures of matching surfaces, relative to the larger curvature.
const FIT: f64 = 0.5;

/// True if sides with the given curvatures, positive for convex bodies, match.
pub(super) fn fit_each_other([a, b]: [f64; 2]) -> bool {
    (a + b).abs() <= FIT * a.abs().max(b.abs())
}

/// Interference, in multiples of the sagitta, below which polygons interlock.
const LOST: f64 = 0.5;

/// Largest relative difference between the interferences of facets and curves.
pub(super) const DISTORTED: f64 = 0.1;

/// Distance beyond the ends of a facet, in facet lengths, up to which a node still counts as opposite, in the wedge between two facets.
const BESIDE: f64 = 0.1;

/// Smallest number of facets with opposite nodes for which a fit of curves is assessed.
pub(super) const FEW: usize = 3;

/// Relative error of nodal pressures (root mean square) of cells of constant strain, per ratio of their thickness to the radius of the
/// contact. Measured: 0.5 to 2.2 in fits of rings of `tri3` and 2 in fits of tubes of `tet4`, with four and eight cells across the wall, on
/// matching and other meshes (`docs/tasks/press-fits.md`).
const OF_CONSTANT_STRAIN: f64 = 2.0;

/// Expected relative error of nodal pressures between cells of constant strain under a curved contact, if it exceeds `DISTORTED`.
pub fn constant_strain_error(thickness: f64, curvature: f64) -> Option<f64> {
    Some(OF_CONSTANT_STRAIN * thickness * curvature).filter(|error| *error > DISTORTED)
}

/// Press fit between polygons on matching curves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolygonFit {
    /// Mean interference of the curves `[length]`.
    pub interference: f64,
    /// Mean sagitta of the facets, on the side with the larger one `[length]`.
    pub sagitta: f64,
    /// Mean interference lost by the facets, negative if the facets overlap more than the curves `[length]`.
    pub lost: f64,
    /// Mean curvature of the secondary curve `[1/length]`.
    pub curvature: f64,
}

impl PolygonFit {
    /// True if corners of the polygons interlock.
    pub fn interlocks(&self) -> bool {
        self.interference < LOST * self.sagitta
    }

    /// True if the interferences of facets and curves differ by more than `DISTORTED`.
    pub fn is_distorted(&self) -> bool {
        self.lost.abs() > DISTORTED * self.interference
    }
}

/// Facet of a curve.
struct Arc {
    from: [f64; 2],
    /// Unit vector along the facet.
    along: [f64; 2],
    /// Length of the facet `[length]`.
    length: f64,
    /// Mean angle to both adjacent facets, positive on a convex body.
    turn: f64,
    /// True if the facet has a height profile.
    is_followed: bool,
}

impl Arc {
    /// Height of the curve over the facet at the coordinate `s`, outwards `[length]`.
    fn rise(&self, s: f64) -> f64 {
        0.5 * s * (1.0 - s) * self.length * self.turn
    }

    /// Sagitta that the facet neglects, outwards `[length]`; 0 with a height profile.
    fn neglected_sagitta(&self) -> f64 {
        if self.is_followed { 0.0 } else { self.rise(0.5) }
    }
}

/// Press fit of two surfaces at `q`; `None` unless they are polygons on matching curves that overlap.
pub fn polygon_fit(secondary: &Surface, primary: &Surface, q: &[f64], facets: FacetShape) -> Option<PolygonFit> {
    let (own, others) = (arcs(secondary, q, facets), arcs(primary, q, facets));
    let at = |node: u32| [q[2 * node as usize], q[2 * node as usize + 1]];
    let middles = others.iter().flatten().map(|arc| GeomWithData::new([0, 1].map(|i| arc.from[i] + 0.5 * arc.length * arc.along[i]), arc));
    let tree = RTree::bulk_load(middles.collect());
    let mut overlaps = Vec::new();
    let (mut sagittas, mut curvature) = ([0.0; 2], 0.0);
    for (facet, arc) in own.iter().enumerate() {
        let Some(arc) = arc else { continue };
        let x = at(secondary.facets()[facet][0]);
        let Some((other, s, gap)) = opposite(x, arc, &tree) else { continue };
        if fit_each_other([arc, other].map(|arc| arc.turn / arc.length)) {
            overlaps.push(other.rise(s) - gap);
            curvature += (arc.turn / arc.length).abs();
            [arc, other].iter().zip(&mut sagittas).for_each(|(arc, sum)| *sum += arc.neglected_sagitta());
        }
    }
    let count = overlaps.len() as f64;
    let interference = overlaps.iter().sum::<f64>() / count;
    let sagitta = sagittas[0].abs().max(sagittas[1].abs()) / count;
    let lost = (sagittas[0] + sagittas[1]) * 2.0 / (3.0 * count);
    (overlaps.len() >= FEW && interference > 0.0).then_some(PolygonFit { interference, sagitta, lost, curvature: curvature / count })
}

/// Arcs represented by the facets of a surface; `None` for facets that do not follow a curve.
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

/// Nearest arc with a normal opposite to that of `own`, within whose length the point lies; with the coordinate of the point on the arc and
/// its gap to the facet `[length]`.
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

    /// Rings with the node radius 1 outside and `1 + fit` inside.
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

    /// Closed form: mean distance of a regular polygon of n sides from its circle of radius r, `r (1 - sin(2 pi/n)/(2 pi/n))/2` (difference
    /// of areas).
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
