//! Press fits in space whose weighted gaps differ from node to node (findings of `checks.rs`).
//!
//! The overlap `D_A = -Phi_A/w_A` of a secondary node is the mean distance of both surfaces over the facets of the node, as contact sees
//! them. It differs from node to node because quadratic heights deviate from the curve.
//!
//! Pressures between nonmatching meshes follow its short waves: with its deviation `r_A` from the plane through the neighboring nodes'
//! overlaps, facets of the length `l` and curvatures with the sum `k`, the relative error of nodal pressures (root mean square) is
//!
//! ```text
//! RESPONSE mean(r^4)^(1/4)/(mean(D) k l)
//! ```
//!
//! Pressures of single nodes that deviate from all of their neighbors are the most sensitive ones: on spheres of six blocks where three
//! facets meet. The root mean square of `r` misses them (error of 5 % in spheres of `hex20`, 24 on 16 cells, estimated as 1 %).

use nalgebra::{DMatrix, DVector};

use super::mortar::MortarInSpace;
use super::profiles::Profiles;
use super::second_order::ProxySurfacesInSpace;
use crate::contact::faces::{self, Vector};
use crate::contact::kernel::ContactKernel;
use crate::contact::polygon_fit::FEW;
use crate::contact::surface::Surface;
use crate::contact::window::{MotionBound, PredictedMotion};
use crate::math::tolerances::STRAIGHT;

/// Expected relative error of nodal pressures from which a fit is reported. Measured in quarter tubes of `hex8`: estimates of at most 0.021
/// where pressures are accurate to 1 % (12 on 8 cells, interference 1e-4 of the radius).
const REPORTED: f64 = 0.022;

/// Relative error of nodal pressures per relative deviation of the overlap of neighboring nodes, times `k l`. Measured in fits of quarter
/// tubes of `hex8` where pressures are off by 2 to 50 %: 13 with 7 on 5 cells, 11 with 9, 12 and 10 on 5 and 4, 8 with 17 on 5, 5 and 9
/// with 9 on 6 and 6 on 9; interferences of 1e-4 to 1e-3 of the radius.
const RESPONSE: f64 = 12.0;

/// [`RESPONSE`] for faces of eight and nine nodes. Measured: 26 to 32 in tubes of `hex20` with 9, 10, 12 and 17 on 4 and 5 cells in a
/// quarter, 30 in spheres with 24 on 16 cells around.
const RESPONSE_OF_SECOND_ORDER: f64 = 30.0;

/// [`RESPONSE`] for faces of three or six nodes. Measured: 48 in fits of tubes of `tet4` with 28 on 20 cells around and an interference of
/// 1e-3 of the radius, 33 and 55 in fits of spheres of `tet10` with 24 on 16 cells around and interferences of 1e-5 and 1e-4.
const RESPONSE_OF_TRIANGLES: f64 = 45.0;

/// Covered share of a secondary node's weight function from which its overlap counts.
const COVERED: f64 = 0.9;

/// Singular value of the positions of neighbors, in facet sizes, below which they count as collinear.
const COLLINEAR: f64 = 0.1;

/// Overlap up to which pairs of facets count, in facet sizes.
const DEEP: f64 = 0.5;

/// Press fit of curved surfaces whose overlap is uneven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnevenFit {
    /// Mean overlap of the surfaces `[length]`.
    pub interference: f64,
    /// Deviation of the overlap of secondary nodes from that of their neighbors, fourth root of the mean fourth power `[length]`.
    pub deviation: f64,
    /// Expected relative error of nodal pressures, root mean square.
    pub pressure_error: f64,
}

impl UnevenFit {
    /// True if the expected error of nodal pressures exceeds `REPORTED`.
    pub fn is_distorted(&self) -> bool {
        self.pressure_error > REPORTED
    }
}

/// Evenness of the overlap of two surfaces between model nodes at `q`; `None` unless both are curved and overlap on average.
pub fn uneven_fit(surfaces: &ProxySurfacesInSpace, q: &[f64]) -> Option<UnevenFit> {
    let kernel = surfaces.on_nodes(MortarInSpace::kernel(surfaces), true);
    let size = kernel.facet_size();
    let curvature = curvature(kernel.secondary(), q);
    // Flat surfaces overlap evenly: no pairs of facets are searched for them.
    if curvature * size <= STRAIGHT {
        return None;
    }
    let surface = kernel.secondary().clone();
    let overlaps = overlaps(kernel, q);
    let interference = mean(&overlaps)?;
    if overlaps.iter().flatten().count() < FEW || interference <= STRAIGHT * STRAIGHT * size {
        return None;
    }
    let deviations: Vec<f64> =
        (0..overlaps.len()).filter_map(|node| Some(overlaps[node]? - around(&surface, node, &overlaps, q)?)).collect();
    let deviation = (deviations.iter().map(|r| r.powi(4)).sum::<f64>() / deviations.len().max(1) as f64).powf(0.25);
    let is_of_triangles = (0..surface.count()).all(|facet| surface.facet(facet).len() == 3);
    let response = if is_of_triangles {
        RESPONSE_OF_TRIANGLES
    } else if surfaces.is_on_faces() {
        RESPONSE_OF_SECOND_ORDER
    } else {
        RESPONSE
    };
    let pressure_error = response * deviation / (interference * curvature * size);
    (deviation > 0.0).then_some(UnevenFit { interference, deviation, pressure_error })
}

/// Overlap `D_A` of each secondary node at `q` `[length]`; `None` for nodes that are not covered.
fn overlaps(mut kernel: Box<dyn ContactKernel>, q: &[f64]) -> Vec<Option<f64>> {
    let depth = DEEP * kernel.facet_size();
    kernel.update_candidates(&PredictedMotion { q, motion_bound: MotionBound::UpTo(0.0), reach: 1.0, depth });
    kernel.begin_step(q);
    let gaps = kernel.start_gap().into_iter().zip(kernel.coverage(q)).zip(kernel.weights());
    gaps.map(|((gap, covered), weight)| (covered >= COVERED).then(|| -gap / (covered * weight))).collect()
}

/// Mean of the known values.
fn mean(values: &[Option<f64>]) -> Option<f64> {
    let known: Vec<f64> = values.iter().flatten().copied().collect();
    (!known.is_empty()).then(|| known.iter().sum::<f64>() / known.len() as f64)
}

/// Overlap at a node that follows linearly from those of its neighbors; `None` for nodes with too few of them.
fn around(surface: &Surface, node: usize, overlaps: &[Option<f64>], q: &[f64]) -> Option<f64> {
    let corners = faces_around(surface, node).flat_map(|facet| surface.local_facet(facet));
    let mut others: Vec<usize> = corners.map(|&other| other as usize).collect();
    others.sort_unstable();
    others.dedup();
    others.retain(|&other| other != node && overlaps[other].is_some());
    let at = |node: usize| faces::at(surface.nodes()[node], q);
    let size = others.iter().map(|&other| (at(other) - at(node)).norm()).sum::<f64>() / others.len() as f64;
    let normal = faces_around(surface, node).map(|facet| faces::normal(surface.facet(facet), q)).sum::<Vector>();
    let first = normal.cross(&(at(*others.first()?) - at(node))).try_normalize(0.0)?;
    let second = first.cross(&normal).try_normalize(0.0)?;
    let row = |&other: &usize| {
        let way = (at(other) - at(node)) / size;
        [1.0, first.dot(&way), second.dot(&way)]
    };
    let rows = DMatrix::from_row_iterator(others.len(), 3, others.iter().flat_map(row));
    let values = DVector::from_iterator(others.len(), others.iter().filter_map(|&other| overlaps[other]));
    let fit = rows.svd(true, true).solve(&values, COLLINEAR).ok()?;
    (others.len() >= FEW).then(|| fit[0])
}

/// Facets adjacent to a node.
fn faces_around(surface: &Surface, node: usize) -> impl Iterator<Item = usize> {
    surface.adjacent_facets(node).iter().map(|&facet| facet as usize)
}

/// Mean sum of the principal curvatures over the facets of a surface `[1/length]`.
fn curvature(surface: &Surface, q: &[f64]) -> f64 {
    let profiles = Profiles::of_curve(surface, q, super::press_fit::CURVE);
    let of = |facet: usize| profiles.curvature(facet, surface.facet_size(facet, q));
    (0..surface.count()).map(of).sum::<f64>() / surface.count() as f64
}
