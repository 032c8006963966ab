//! Press fits of facets in space that are too coarse (findings of `checks.rs`). Curves through nodes whose facets make too large angles
//! have no height profile (`profiles.rs`), and their height over the facets is missing in the fit.

use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::profiles::Profiles;
use crate::contact::faces::{self, Vector};
use crate::contact::facet_shape::FacetShape;
use crate::contact::polygon_fit::{DISTORTED, FEW, fit_each_other};
use crate::contact::surface::Surface;

/// Cosine of the largest angle between two facets of a curve: 50 degrees.
pub(super) const CURVE: f64 = 0.642_787_609_686_54;

/// Number of facets with the nearest middles among which the facet opposite a node is found.
const NEAREST: usize = 4;

/// Press fit of curves, and error of the facets that represent them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressFit {
    /// Interference of the curves `[length]`.
    pub interference: f64,
    /// Mean height of a curve over facets without a height profile, on the side where it is larger `[length]`.
    pub missed: f64,
    /// Mean sum of the principal curvatures of the secondary curve `[1/length]`.
    pub curvature: f64,
}

impl PressFit {
    /// True if the height error `missed` of the facets exceeds the fraction `DISTORTED` of the interference.
    pub fn is_coarse(&self) -> bool {
        self.missed > DISTORTED * self.interference
    }
}

/// Press fit of two surfaces at `q`; `None` unless their facets represent matching curves that overlap.
///
/// Secondary nodes lie on their curve. The depth behind a primary facet differs from that of the primary curve by zero at the corners and
/// by up to the facet's height elsewhere. The interference is therefore the least depth for a hollow primary side, the largest for other
/// ones.
///
/// Heights over facets of the shape `Straight` are missed.
pub fn press_fit(secondary: &Surface, primary: &Surface, q: &[f64], shape: FacetShape) -> Option<PressFit> {
    let of = |surface| [Profiles::of_curve(surface, q, CURVE), Profiles::new(surface, q)];
    let [own, other] = [of(secondary), of(primary)];
    let point = |x: Vector| [x.x, x.y, x.z];
    let middles = (0..primary.count()).map(|facet| GeomWithData::new(point(faces::middle(primary.facet(facet), q)), facet));
    let tree = RTree::bulk_load(middles.collect());
    let (mut depths, mut missed, mut heights, mut curvature) = (Vec::new(), [0.0; 2], 0.0, 0.0);
    for (index, &node) in secondary.nodes().iter().enumerate() {
        let facet = secondary.adjacent_facets(index)[0] as usize;
        let x = faces::at(node, q);
        let near = tree.nearest_neighbor_iter(point(x)).take(NEAREST).map(|found| (depth(x, primary.facet(found.data), q), found.data));
        let Some(((_, depth), nearest)) = near.max_by(|one, other| one.0.0.total_cmp(&other.0.0)) else { continue };
        let (normal, against) = (faces::normal(secondary.facet(facet), q), faces::normal(primary.facet(nearest), q));
        let [rises, seen] = [0, 1].map(|k| [own[k].height(facet), other[k].height(nearest)]);
        let seen = if shape == FacetShape::Straight { [0.0; 2] } else { seen };
        let sizes = [secondary.facet_size(facet, q), primary.facet_size(nearest, q)];
        let fits = fit_each_other([0, 1].map(|side| rises[side] / sizes[side].powi(2)));
        if rises[0] != 0.0 && fits && normal.dot(&against) < 0.0 && depth.abs() < sizes[1] {
            depths.push(depth);
            heights += rises[1];
            curvature += own[0].curvature(facet, sizes[0]);
            (0..2).for_each(|side| missed[side] += (rises[side] - seen[side]).abs());
        }
    }
    let [least, most] = depths.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], &depth| [a.min(depth), b.max(depth)]);
    let interference = if heights < 0.0 { least } else { most };
    let count = depths.len() as f64;
    let (missed, curvature) = (missed[0].max(missed[1]) / count, curvature / count);
    (depths.len() >= FEW && interference > 0.0).then_some(PressFit { interference, missed, curvature })
}

/// Least barycentric coordinate of a point in the triangle of a facet that is nearest to it in the plane of the facet, and its depth behind
/// this triangle `[length]`.
fn depth(x: Vector, facet: &[u32], q: &[f64]) -> (f64, f64) {
    let of_triangle = |[a, b, c]: [Vector; 3]| {
        let (area, arm) = ((b - a).cross(&(c - a)), x - c);
        let shares = [(b - c).cross(&arm), arm.cross(&(a - c))].map(|part| -part.dot(&area) / area.norm_squared());
        let least = shares[0].min(shares[1]).min(1.0 - shares[0] - shares[1]);
        (least, -arm.dot(&area) / area.norm())
    };
    let triangles = faces::triangles(facet, q).map(of_triangle);
    triangles.max_by(|one, other| one.0.total_cmp(&other.0)).unwrap_or((f64::NEG_INFINITY, 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quarter cylinders of length 1 with `inner` and `outer` facets, the inner one larger by `fit`.
    fn found(inner: u32, outer: u32, fit: f64) -> Option<PressFit> {
        let points = |count: u32, radius: f64| {
            (0..=count).flat_map(move |i| {
                let angle = std::f64::consts::FRAC_PI_2 * f64::from(i) / f64::from(count);
                [[radius * angle.cos(), radius * angle.sin(), 0.0], [radius * angle.cos(), radius * angle.sin(), 1.0]]
            })
        };
        let q: Vec<f64> = points(inner, 1.0 + fit).chain(points(outer, 1.0)).flatten().collect();
        let first = 2 * (inner + 1);
        let own: Vec<[u32; 4]> = (0..inner).map(|i| [2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1]).collect();
        let other: Vec<[u32; 4]> = (0..outer).map(|i| [2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2].map(|node| first + node)).collect();
        let of = |facets: &[[u32; 4]]| Surface::in_space(facets.iter().map(|facet| &facet[..]));
        press_fit(&of(&own), &of(&other), &q, FacetShape::Curved)
    }

    /// Closed form: the mean height of a circle of radius 1 over a chord with the half angle `a` is `(a - sin a cos a)/(2 sin a)`.
    #[test]
    fn fits_and_heights_are_those_of_cylinders() {
        let half = std::f64::consts::FRAC_PI_4 / 3.0;
        let exact = (half - half.sin() * half.cos()) / (2.0 * half.sin());
        let fit = found(4, 3, 0.0133).expect("they overlap");
        assert!((fit.missed / exact - 1.0).abs() < 0.05, "{fit:?} against {exact}");
        assert!((fit.interference / 0.0133 - 1.0).abs() < 0.1 && fit.is_coarse(), "{fit:?}");
        assert!(found(12, 10, 0.0133).is_some_and(|fit| !fit.is_coarse() && (fit.interference / 0.0133 - 1.0).abs() < 0.02));
        assert_eq!(found(12, 10, -0.05), None);
    }
}
