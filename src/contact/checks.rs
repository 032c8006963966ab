//! Findings about the surfaces of a contact before the first step, with names, numbers and hints: reversed or repeated facets, surfaces
//! that face away, coarse secondary sides, coarse press fits, ties without a partner.
//!
//! A finding is a warning: the pair can be simulated, but hardly as intended.

use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::clearance::Clearance;
use super::polygon_fit::PolygonFit;
use super::space::{PressFit, UnevenFit};
use super::surface::Surface;
use crate::math::digits::three_digits;
use crate::math::norms::length;

/// Ratio of mean facet lengths, secondary over primary, above which the secondary surface counts as too coarse.
const COARSE: f64 = 3.0;

/// Largest `-cos` of the angle between the outward normals of a facet and of an obstacle at which the facet does not face the obstacle: 84
/// degrees. The vertical side of a block that stands on a plane, slightly tilted, does not face the plane.
const FACES: f64 = 0.1;

/// Surface and its name, for messages.
#[derive(Clone, Copy, Debug)]
pub struct NamedSurface<'a> {
    /// Name `body.boundary`.
    pub name: &'a str,
    /// Facets of the boundary.
    pub surface: &'a Surface,
}

/// Suspicious property of a contact pair.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Finding {
    /// Facets that meet in a node run in opposite directions: one normal is reversed.
    ReversedNormals {
        /// Name of the surface.
        surface: String,
        /// Number of nodes with opposite directions.
        nodes: usize,
        /// Model number of the first node with reversed facets.
        first: u32,
        /// Position of the first node with reversed facets `[length]`.
        at: [f64; 2],
    },
    /// A facet is listed twice.
    DuplicateFacets {
        /// Name of the surface.
        surface: String,
        /// Number of facets that repeat an earlier one.
        count: usize,
        /// Model node numbers of the first repeated facet.
        nodes: [u32; 2],
        /// Middle of the first repeated facet `[length]`.
        at: [f64; 2],
    },
    /// No secondary facet has a primary facet in front of it with an opposite normal.
    FacingAway {
        /// Name of the secondary surface.
        secondary: String,
        /// Name of the primary surface.
        primary: String,
        /// Mean cosine of the angle between the normals of nearest facets: -1 face to face, 1 equal directions.
        cosine: f64,
        /// Mean distance to the nearest primary facet along the secondary normal, negative behind `[length]`.
        distance: f64,
    },
    /// No secondary facet faces the rigid obstacle.
    LooksAway {
        /// Name of the secondary surface.
        secondary: String,
        /// Least cosine of the angle between the outward normals of a facet and of the obstacle: -1 face to face, 1 equal directions.
        cosine: f64,
    },
    /// The secondary surface is much coarser than the primary one.
    CoarseSecondary {
        /// Name of the secondary surface.
        secondary: String,
        /// Name of the primary surface.
        primary: String,
        /// Mean facet length of the secondary surface `[length]`.
        secondary_size: f64,
        /// Mean facet length of the primary surface `[length]`.
        primary_size: f64,
    },
    /// Polygons on matching curves whose interference is much smaller than the sagitta of their facets, so that their corners interlock.
    Interlocking {
        /// Name of the secondary surface.
        secondary: String,
        /// Name of the primary surface.
        primary: String,
        /// Interference of the curves, and sagitta of the facets.
        of: PolygonFit,
    },
    /// Polygons on matching curves whose interference differs much from that of the curves.
    DistortedFit {
        /// Name of the secondary surface.
        secondary: String,
        /// Name of the primary surface.
        primary: String,
        /// Interference of the curves, and the part that facets lose.
        of: PolygonFit,
    },
    /// Facets in space with bend angles too large for height profiles, of curves in a press fit.
    CoarseFit {
        /// Name of the secondary surface.
        secondary: String,
        /// Name of the primary surface.
        primary: String,
        /// Interference, and the height of the curves missing in flat facets.
        of: PressFit,
    },
    /// Press fit in space whose overlap differs too much from node to node, because curves deviate from their height profiles.
    UnevenFit {
        /// Name of the secondary surface.
        secondary: String,
        /// Name of the primary surface.
        primary: String,
        /// Interference, and its deviations.
        of: UnevenFit,
    },
    /// Press fit of cells of constant strain that are too thick for the curvature of the contact.
    ConstantStrain {
        /// Name of the secondary surface.
        secondary: String,
        /// Name of the primary surface.
        primary: String,
        /// Mean thickness of the cells under the contact `[length]`.
        thickness: f64,
        /// Expected relative error of nodal pressures.
        error: f64,
    },
    /// Press fit of nodes on facets between unlike meshes.
    UnlikeNodes {
        /// Name of the secondary surface.
        secondary: String,
        /// Name of the primary surface.
        primary: String,
    },
    /// Circle or cylinder of a rigid body with too few facets to touch as a round one.
    CoarseCircle {
        /// Name of the surface.
        surface: String,
        /// Number of facets around.
        facets: usize,
    },
    /// Secondary nodes of a tie without an opposite primary point.
    Untied {
        /// Name of the tie.
        tie: String,
        /// Number of secondary nodes without an opposite primary point.
        nodes: usize,
        /// Number of all secondary nodes.
        of: usize,
        /// Largest distance between tied points `[length]`.
        reach: f64,
    },
}

impl std::fmt::Display for Finding {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Finding::ReversedNormals { surface, nodes, at: [x, y], .. } => {
                write!(
                    out,
                    "facets of \"{surface}\" that meet run in opposite directions at {nodes} of its nodes, the first at ({x:.3}, {y:.3})"
                )
            }
            Finding::DuplicateFacets { surface, count, at: [x, y], .. } => {
                write!(out, "\"{surface}\" lists {count} facets more than once, the first at ({x:.3}, {y:.3})")
            }
            Finding::FacingAway { secondary, primary, cosine, .. } if *cosine >= 0.0 => {
                let angle = cosine.min(1.0).acos().to_degrees();
                write!(
                    out,
                    "no facet of \"{secondary}\" faces \"{primary}\": their outward normals are {angle:.0} degrees apart, and 180 is \
                     face to face"
                )
            }
            Finding::FacingAway { secondary, primary, distance, .. } => write!(
                out,
                "no facet of \"{secondary}\" faces \"{primary}\", which lies {} behind it, on the side of its own body",
                three_digits(distance.abs())
            ),
            Finding::LooksAway { secondary, cosine } => {
                let angle = cosine.clamp(-1.0, 1.0).acos().to_degrees();
                write!(
                    out,
                    "no facet of \"{secondary}\" faces the rigid obstacle: their outward normals are {angle:.0} degrees apart at most, and \
                     180 is face to face"
                )
            }
            Finding::CoarseSecondary { secondary, primary, secondary_size, primary_size } => write!(
                out,
                "facets of the secondary surface \"{secondary}\" are {:.1} times as long as those of \"{primary}\" ({} \
                 against {})",
                secondary_size / primary_size,
                three_digits(*secondary_size),
                three_digits(*primary_size)
            ),
            Finding::Interlocking { secondary, primary, of: PolygonFit { interference, sagitta, .. } } => write!(
                out,
                "\"{secondary}\" and \"{primary}\" are polygons whose corners hold each other: they are pressed into each other by \
                 {}, and their facets stand off the curve by {}",
                three_digits(*interference),
                three_digits(*sagitta)
            ),
            Finding::DistortedFit { secondary, primary, of: PolygonFit { interference, lost, .. } } => write!(
                out,
                "\"{secondary}\" and \"{primary}\" are polygons that overlap by {}, and the curves through their nodes by {}: the press \
                 fit is {:.0} % too {}",
                three_digits(interference - lost),
                three_digits(*interference),
                100.0 * lost.abs() / interference,
                if *lost > 0.0 { "loose" } else { "tight" }
            ),
            Finding::UnlikeNodes { secondary, primary } => write!(
                out,
                "nodes of \"{secondary}\" are pressed onto facets of \"{primary}\" beside its nodes: pressures oscillate from node to \
                 node, by about a tenth on flat sides and by as much as themselves on curved ones"
            ),
            Finding::CoarseCircle { surface, facets } => write!(
                out,
                "the nodes of \"{surface}\" lie on a circle with {facets} facets around: it rolls over their edges, as a prism of {facets} \
                 sides does, not as a round body"
            ),
            Finding::Untied { nodes, of, reach, .. } => {
                let many = if nodes == of {
                    format!("none of the {of} nodes has anything")
                } else {
                    format!("{nodes} of {of} nodes have nothing")
                };
                write!(out, "{many} opposite within the reach of {}", three_digits(*reach))
            }
            Finding::CoarseFit { .. } | Finding::UnevenFit { .. } | Finding::ConstantStrain { .. } => self.write_press_fit(out),
        }
    }
}

impl Finding {
    /// Writes the message about a press fit in space; nothing for other findings.
    fn write_press_fit(&self, out: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Finding::CoarseFit { secondary, primary, of: PressFit { interference, missed, .. } } => write!(
                out,
                "facets of \"{secondary}\" and \"{primary}\" are too coarse for their press fit: curves through their nodes overlap by {}, \
                 and rise {} above facets that are taken for straight, because they turn by more than 25 degrees or by option",
                three_digits(*interference),
                three_digits(*missed)
            ),
            Finding::UnevenFit { secondary, primary, of: UnevenFit { interference, deviation, pressure_error } } => write!(
                out,
                "nodal pressures between \"{secondary}\" and \"{primary}\" have errors of about {:.0} %: their facets do not match, and \
                 follow their curves so that they overlap by {}, but from node to node by {} more or less",
                100.0 * pressure_error,
                three_digits(*interference),
                three_digits(*deviation)
            ),
            Finding::ConstantStrain { secondary, primary, thickness, error } => write!(
                out,
                "nodal pressures between \"{secondary}\" and \"{primary}\" have errors of about {:.0} %, on matching meshes, too: their \
                 cells have constant strains, and are {} thick under a curved contact",
                100.0 * error,
                three_digits(*thickness)
            ),
            _ => Ok(()),
        }
    }

    /// Stable message code, which `conserva doc` explains.
    pub fn code(&self) -> &'static str {
        match self {
            Finding::ReversedNormals { .. } => "C0401",
            Finding::DuplicateFacets { .. } => "C0402",
            Finding::FacingAway { .. } => "C0403",
            Finding::LooksAway { .. } => "C0438",
            Finding::CoarseSecondary { .. } => "C0404",
            Finding::Interlocking { .. } => "C0405",
            Finding::DistortedFit { .. } => "C0406",
            Finding::CoarseFit { .. } => "C0407",
            Finding::UnevenFit { .. } => "C0409",
            Finding::ConstantStrain { .. } => "C0410",
            Finding::UnlikeNodes { .. } => "C0414",
            Finding::CoarseCircle { .. } => "C0415",
            Finding::Untied { .. } => "C0408",
        }
    }

    /// True for a cosine between the normals that is negative: the surfaces face each other, but the primary one lies behind the secondary
    /// one, on the side of its body.
    pub fn is_behind(&self) -> bool {
        matches!(self, Finding::FacingAway { cosine, .. } if *cosine < 0.0)
    }

    /// True for a tie in which no node is tied.
    pub fn is_void(&self) -> bool {
        matches!(self, Finding::Untied { nodes, of, .. } if nodes == of)
    }

    /// Suggested remedy, one sentence.
    pub fn hint(&self) -> String {
        match self {
            Finding::ReversedNormals { .. } => {
                "number the nodes of all cells counter-clockwise, so that the body is on each facet's left".into()
            }
            Finding::DuplicateFacets { .. } => "name each facet once, also where boundaries are joined".into(),
            Finding::FacingAway { .. } => "name the boundaries that can touch: each on the side of the other body".into(),
            Finding::LooksAway { .. } => {
                "name all of the body that can touch the obstacle, or turn the obstacle round if it is the wrong way: \
                                          other sides pass through it"
                    .into()
            }
            Finding::CoarseSecondary { secondary, primary, .. } => {
                format!("make \"{primary}\" the secondary surface, or refine \"{secondary}\": the finer side carries the multipliers")
            }
            Finding::Interlocking { .. } => {
                "let contact follow the curve, or take more facets: half as long stand off a quarter as much".into()
            }
            Finding::DistortedFit { .. } => {
                "let contact follow the curve, or take facets of one length on both sides, or more of them".into()
            }
            Finding::CoarseFit { .. } => "make facets half as long, which rise a quarter as much, or use cells of second order".into(),
            Finding::UnevenFit { .. } => {
                "make facets half as long, which follow the curve sixteen times as closely, use matching meshes, or make the coarser side \
                 the secondary one"
                    .into()
            }
            Finding::ConstantStrain { .. } => {
                "use cells of second order, quadrilaterals or hexahedra, or thinner cells under the contact; mean pressures have about \
                 half of the error, and the force is accurate"
                    .into()
            }
            Finding::UnlikeNodes { .. } => "use a mortar method, or matching meshes; finer facets do not help".into(),
            Finding::CoarseCircle { .. } => {
                "take at least twelve facets around for a round body; if a prism is meant, make the facets straight".into()
            }
            Finding::Untied { .. } => "name boundaries that lie on each other, or give a larger `reach`".into(),
        }
    }
}

/// Findings about a contact pair with nodes at `q`, in a fixed order. Self-contact (equal surfaces) is checked as one surface.
pub fn check_surfaces(secondary: NamedSurface, primary: NamedSurface, q: &[f64]) -> Vec<Finding> {
    let with_itself = secondary.surface == primary.surface;
    let mut findings = Vec::new();
    for side in if with_itself { vec![secondary] } else { vec![secondary, primary] } {
        findings.extend(reversed_normals(side, q));
        findings.extend(duplicate_facets(side, q));
    }
    if !with_itself {
        findings.extend(facing_away(secondary, primary, q));
        findings.extend(coarse_secondary(secondary, primary, q));
    }
    findings
}

fn reversed_normals(side: NamedSurface, q: &[f64]) -> Option<Finding> {
    let surface = side.surface;
    let clashes = |index: usize| {
        let adjacent = surface.adjacent_facets(index);
        let starting = adjacent.iter().filter(|&&facet| surface.local_facets()[facet as usize][0] as usize == index).count();
        // A node of two copies of one facet with opposite orientation is reported as `DuplicateFacets`.
        adjacent.len() == 2 && starting != 1 && distinct_facets(surface, adjacent)
    };
    let clashing: Vec<usize> = (0..surface.nodes().len()).filter(|&index| clashes(index)).collect();
    let first = surface.nodes()[*clashing.first()?];
    let at = [q[2 * first as usize], q[2 * first as usize + 1]];
    Some(Finding::ReversedNormals { surface: side.name.into(), nodes: clashing.len(), first, at })
}

fn distinct_facets(surface: &Surface, adjacent: &[u32]) -> bool {
    let sorted = |facet: u32| {
        let [a, b] = surface.facets()[facet as usize];
        [a.min(b), a.max(b)]
    };
    sorted(adjacent[0]) != sorted(adjacent[1])
}

fn duplicate_facets(side: NamedSurface, q: &[f64]) -> Option<Finding> {
    let mut facets: Vec<[u32; 2]> = side.surface.facets().iter().map(|&[a, b]| [a.min(b), a.max(b)]).collect();
    facets.sort_unstable();
    let repeated: Vec<[u32; 2]> = facets.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0]).collect();
    let nodes = *repeated.first()?;
    let [a, b] = nodes.map(|node| 2 * node as usize);
    let at = [0.5 * (q[a] + q[b]), 0.5 * (q[a + 1] + q[b + 1])];
    Some(Finding::DuplicateFacets { surface: side.name.into(), count: repeated.len(), nodes, at })
}

/// Center, unit outward normal and size of each facet; third components are zero in the plane.
fn frames(surface: &Surface, q: &[f64]) -> Vec<([f64; 3], [f64; 3], f64)> {
    let d = surface.dimension();
    let frame = |facet: usize| {
        let nodes = surface.facet(facet);
        let mut middle = [0.0; 3];
        for &node in nodes {
            (0..d).for_each(|i| middle[i] += q[d * node as usize + i] / nodes.len() as f64);
        }
        let mut normal = [0.0; 3];
        normal[..d].copy_from_slice(&surface.outward(facet, q));
        let size = length(normal);
        (middle, normal.map(|x| x / size), surface.facet_size(facet, q))
    };
    (0..surface.count()).map(frame).collect()
}

/// Finding [`Finding::FacingAway`] for two surfaces in the plane or in space with nodes at `q`.
pub fn facing_away(secondary: NamedSurface, primary: NamedSurface, q: &[f64]) -> Option<Finding> {
    let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let (own, others) = (frames(secondary.surface, q), frames(primary.surface, q));
    let tree = RTree::bulk_load(others.iter().enumerate().map(|(index, (middle, ..))| GeomWithData::new(*middle, index)).collect());
    let (mut cosines, mut distances) = (0.0, 0.0);
    for (middle, normal, size) in &own {
        let (nearest, other_normal, other_size) = others[tree.nearest_neighbor(*middle)?.data];
        let cosine = dot(normal, &other_normal);
        let ahead = dot(normal, &std::array::from_fn(|i| nearest[i] - middle[i]));
        // A facet that overlaps by less than its size counts as an initial penetration.
        if cosine < 0.0 && ahead > -size.max(other_size) {
            return None;
        }
        cosines += cosine;
        distances += ahead;
    }
    let count = own.len() as f64;
    Some(Finding::FacingAway {
        secondary: secondary.name.into(),
        primary: primary.name.into(),
        cosine: cosines / count,
        distance: distances / count,
    })
}

/// Finding [`Finding::LooksAway`] for a surface with nodes at `q` and an obstacle that is displaced by `shift`.
pub fn looks_away(secondary: NamedSurface, obstacle: &Clearance, shift: [f64; 3], q: &[f64]) -> Option<Finding> {
    let mut least = f64::INFINITY;
    for (middle, normal, size) in frames(secondary.surface, q) {
        // A facet that overlaps by less than its size counts as an initial penetration.
        let x = std::array::from_fn(|i| middle[i] - shift[i]);
        least = least.min(obstacle.least_cosine(x, normal, size));
        if least < -FACES {
            return None;
        }
    }
    least.is_finite().then(|| Finding::LooksAway { secondary: secondary.name.into(), cosine: least })
}

fn coarse_secondary(secondary: NamedSurface, primary: NamedSurface, q: &[f64]) -> Option<Finding> {
    let size = |surface: &Surface| {
        let count = surface.facets().len();
        (0..count).map(|facet| surface.facet_measure(facet, q)).sum::<f64>() / count as f64
    };
    let (secondary_size, primary_size) = (size(secondary.surface), size(primary.surface));
    (secondary_size > COARSE * primary_size).then(|| Finding::CoarseSecondary {
        secondary: secondary.name.into(),
        primary: primary.name.into(),
        secondary_size,
        primary_size,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chain of `count` facets of unit length along x at a height, the body above; model node numbers start with `first`.
    fn strip(first: u32, count: u32, height: f64, q: &mut Vec<f64>) -> Vec<[u32; 2]> {
        q.extend((0..=count).flat_map(|i| [f64::from(i), height]));
        (first..first + count).map(|node| [node + 1, node]).collect()
    }

    fn check(secondary: &[[u32; 2]], primary: &[[u32; 2]], q: &[f64]) -> Vec<Finding> {
        let (secondary, primary) = (Surface::new(secondary), Surface::new(primary));
        check_surfaces(NamedSurface { name: "upper.bottom", surface: &secondary }, NamedSurface { name: "lower.top", surface: &primary }, q)
    }

    fn reversed(facets: &[[u32; 2]]) -> Vec<[u32; 2]> {
        facets.iter().map(|&[a, b]| [b, a]).collect()
    }

    #[test]
    fn surfaces_that_face_each_other_have_no_findings() {
        let mut q = Vec::new();
        let lower = strip(0, 4, 0.0, &mut q);
        for height in [0.2, -0.1] {
            let mut q = q.clone();
            let upper = reversed(&strip(5, 4, height, &mut q));
            assert_eq!(check(&upper, &lower, &q), []);
        }
    }

    #[test]
    fn surfaces_on_the_wrong_sides_are_found() {
        let mut q = Vec::new();
        let lower = strip(0, 4, 0.0, &mut q);
        let top = strip(5, 4, 3.0, &mut q);
        let found = check(&top, &lower, &q);
        let same_way = Finding::FacingAway { secondary: "upper.bottom".into(), primary: "lower.top".into(), cosine: 1.0, distance: -3.0 };
        assert_eq!(found, [same_way]);
        // Both surfaces face away from each other.
        let found = check(&top, &reversed(&lower), &q);
        assert!(matches!(found[..], [Finding::FacingAway { cosine: -1.0, distance: -3.0, .. }]), "{found:?}");
        assert!(found[0].to_string().starts_with("no facet of \"upper.bottom\" faces \"lower.top\""));
    }

    #[test]
    fn a_reversed_and_a_doubled_facet_are_found() {
        let mut q = Vec::new();
        let mut lower = strip(0, 4, 0.0, &mut q);
        let upper = reversed(&strip(5, 4, 0.2, &mut q));
        lower[1] = [1, 2];
        let found = check(&upper, &lower, &q);
        assert_eq!(found, [Finding::ReversedNormals { surface: "lower.top".into(), nodes: 2, first: 1, at: [1.0, 0.0] }]);
        lower[1] = [2, 1];
        lower.push([3, 2]);
        let twice = Finding::DuplicateFacets { surface: "lower.top".into(), count: 1, nodes: [2, 3], at: [2.5, 0.0] };
        assert_eq!(check(&upper, &lower, &q), [twice]);
    }

    #[test]
    fn a_coarse_secondary_surface_is_found() {
        let mut q = Vec::new();
        let lower = strip(0, 16, 0.0, &mut q);
        q.extend([0.0, 0.1, 16.0, 0.1]);
        let found = check(&[[17, 18]], &lower, &q);
        let [Finding::CoarseSecondary { secondary_size, primary_size, .. }] = found[..] else { panic!("{found:?}") };
        assert_eq!((secondary_size, primary_size), (16.0, 1.0));
        assert!(found[0].hint().contains("make \"lower.top\" the secondary surface"));
    }
}
