//! Repair of triangulated surfaces where it is unique: merges points that differ by round-off, removes doubled triangles and slivers, and
//! reverses triangles whose orientation differs from their neighbors (obstacles from files).

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Vector3;
use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::facets::{Facets, FacetsError};
use crate::math::tolerances::{FACING, SAME_POINT};

/// Numbers of repairs made to a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mending {
    /// Points merged with others.
    pub joined: usize,
    /// Removed triangles without area.
    pub slivers: usize,
    /// Removed triangles that coincide with others.
    pub doubled: usize,
    /// Reversed triangles.
    pub turned: usize,
}

impl std::fmt::Display for Mending {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Mending { joined, slivers, doubled, turned } = *self;
        let all = [
            (joined, "point joined with another", "points joined with others"),
            (slivers, "triangle without an area taken out", "triangles without an area taken out"),
            (doubled, "triangle on another taken out", "triangles on others taken out"),
            (turned, "triangle turned", "triangles turned"),
        ];
        let said = all.into_iter().filter(|(count, ..)| *count > 0);
        let words = said.map(|(count, one, several)| format!("{count} {}", if count == 1 { one } else { several }));
        write!(out, "{}", words.collect::<Vec<_>>().join(", "))
    }
}

type Triangle = [u32; 3];

impl Facets {
    /// Surface of triangles as in [`Facets::new`], with the repairs made. Triangles that [`Facets::new`] refuses for their orientation at
    /// an edge are repaired first.
    ///
    /// # Errors
    /// As in [`Facets::new`] after the repair: edges with more than two triangles, one-sided surfaces, equal areas of both orientations.
    pub fn mended(points: &[[f64; 3]], triangles: &[Triangle]) -> Result<(Self, Mending), FacetsError> {
        match Facets::new(points, triangles) {
            Err(FacetsError::Turned(_)) => {}
            other => return other.map(|facets| (facets, Mending::default())),
        }
        let mut mending = Mending::default();
        let (points, triangles) = join(points, triangles, &mut mending);
        let triangles = without_slivers(&points, triangles, &mut mending);
        let triangles = without_doubles(triangles, &mut mending);
        let triangles = turned(&points, triangles, &mut mending)?;
        Ok((Facets::new(&points, &triangles)?, mending))
    }
}

fn edges_of(triangle: &Triangle) -> [[u32; 2]; 3] {
    [0, 1, 2].map(|k| [triangle[k], triangle[(k + 1) % 3]])
}

fn ascending([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Triangles at each edge; the ends of edges are ascending.
fn around(triangles: &[Triangle]) -> BTreeMap<[u32; 2], Vec<usize>> {
    let mut found: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
    for (index, triangle) in triangles.iter().enumerate() {
        edges_of(triangle).into_iter().for_each(|edge| found.entry(ascending(edge)).or_default().push(index));
    }
    found
}

/// Merges points that are nearer to each other than the round-off of files.
fn join(points: &[[f64; 3]], triangles: &[Triangle], mending: &mut Mending) -> (Vec<[f64; 3]>, Vec<Triangle>) {
    let (low, high) = points.iter().fold(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |(low, high), x| {
        ([0, 1, 2].map(|i| f64::min(low[i], x[i])), [0, 1, 2].map(|i| f64::max(high[i], x[i])))
    });
    let near = SAME_POINT * (0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max);
    let mut kept: Vec<[f64; 3]> = Vec::new();
    let mut tree: RTree<GeomWithData<[f64; 3], u32>> = RTree::new();
    let mut number = |point: [f64; 3]| {
        if let Some(known) = tree.nearest_neighbor(point) {
            let square: f64 = (0..3).map(|i| (known.geom()[i] - point[i]).powi(2)).sum();
            if square <= near * near {
                mending.joined += usize::from(square > 0.0);
                return known.data;
            }
        }
        kept.push(point);
        tree.insert(GeomWithData::new(point, kept.len() as u32 - 1));
        kept.len() as u32 - 1
    };
    let numbers: Vec<u32> = points.iter().map(|&point| number(point)).collect();
    let triangles = triangles.iter().map(|triangle| triangle.map(|node| numbers[node as usize])).collect();
    (kept, triangles)
}

/// Removes triangles with collinear points. If two points are equal, nothing else changes; otherwise the middle point divides the triangle
/// on the other side of the longest edge, so that the surface stays closed.
fn without_slivers(points: &[[f64; 3]], triangles: Vec<Triangle>, mending: &mut Mending) -> Vec<Triangle> {
    let at = |node: u32| Vector3::from(points[node as usize]);
    let length = |[a, b]: [u32; 2]| (at(b) - at(a)).norm();
    let is_sliver = |&[a, b, c]: &Triangle| {
        let longest = edges_of(&[a, b, c]).map(length).into_iter().fold(0.0, f64::max);
        (at(b) - at(a)).cross(&(at(c) - at(a))).norm() <= FACING * FACING * longest * longest
    };
    let mut kept: Vec<Option<Triangle>> = triangles.into_iter().map(Some).collect();
    let most = kept.len();
    for index in 0..most {
        let Some(sliver) = kept[index].filter(is_sliver) else { continue };
        mending.slivers += 1;
        kept[index] = None;
        let [a, b, c] = sliver;
        if a == b || b == c || c == a {
            continue;
        }
        let longest = edges_of(&sliver).into_iter().max_by(|one, other| length(*one).total_cmp(&length(*other)));
        let Some([from, to]) = longest else { continue };
        let middle = sliver.into_iter().find(|node| ![from, to].contains(node)).unwrap_or(a);
        let beyond: Vec<usize> = (0..kept.len())
            .filter(|&other| {
                kept[other].is_some_and(|other| edges_of(&other).into_iter().any(|edge| ascending(edge) == ascending([from, to])))
            })
            .collect();
        if let [other] = beyond[..]
            && let Some(triangle) = kept[other]
        {
            let halves = [from, to].map(|end| triangle.map(|node| if node == end { middle } else { node }));
            kept[other] = Some(halves[0]);
            kept.push(Some(halves[1]));
        }
    }
    kept.into_iter().flatten().collect()
}

/// Keeps one of several triangles with the same points; none if both orientations are equally frequent.
fn without_doubles(triangles: Vec<Triangle>, mending: &mut Mending) -> Vec<Triangle> {
    let key = |triangle: &Triangle| {
        let mut key = *triangle;
        key.sort_unstable();
        key
    };
    let is_even = |[a, b, c]: &Triangle| (a < b) == ((b < c) == (a < c));
    let mut sides: BTreeMap<Triangle, [usize; 2]> = BTreeMap::new();
    for triangle in &triangles {
        sides.entry(key(triangle)).or_default()[usize::from(is_even(triangle))] += 1;
    }
    let mut seen = BTreeSet::new();
    let count = triangles.len();
    let kept: Vec<Triangle> = triangles
        .into_iter()
        .filter(|triangle| {
            let both = sides[&key(triangle)];
            let own = usize::from(is_even(triangle));
            both[own] > both[1 - own] && seen.insert(key(triangle))
        })
        .collect();
    mending.doubled += count - kept.len();
    kept
}

/// Reverses triangles so that neighbors have equal orientations; in each connected part the orientation with the larger area is kept.
fn turned(points: &[[f64; 3]], mut triangles: Vec<Triangle>, mending: &mut Mending) -> Result<Vec<Triangle>, FacetsError> {
    let at = |node: u32| Vector3::from(points[node as usize]);
    let around = around(&triangles);
    let failed = |edge: [u32; 2]| FacetsError::Turned(edge.map(|node| points[node as usize]));
    if let Some((edge, _)) = around.iter().find(|(_, sides)| sides.len() > 2) {
        return Err(failed(*edge));
    }
    let area = |[a, b, c]: Triangle| (at(b) - at(a)).cross(&(at(c) - at(a))).norm();
    let mut side: Vec<Option<bool>> = vec![None; triangles.len()];
    for start in 0..triangles.len() {
        if side[start].is_some() {
            continue;
        }
        side[start] = Some(false);
        let (mut piece, mut next) = (vec![start], 0);
        while let Some(&current) = piece.get(next) {
            next += 1;
            for edge in edges_of(&triangles[current]) {
                let Some(&other) = around[&ascending(edge)].iter().find(|&&other| other != current) else { continue };
                let runs_alike = edges_of(&triangles[other]).contains(&edge);
                let wanted = side[current].map(|side| side != runs_alike);
                match side[other] {
                    None => {
                        side[other] = wanted;
                        piece.push(other);
                    }
                    known if known == wanted => {}
                    // Contradictory orientations: a one-sided surface.
                    _ => return Err(failed(edge)),
                }
            }
        }
        let areas = [false, true].map(|of| piece.iter().filter(|&&k| side[k] == Some(of)).map(|&k| area(triangles[k])).sum::<f64>());
        let minority = areas[1] <= areas[0];
        let first = piece.iter().find(|&&k| side[k] != side[start]);
        if let Some(&first) = first
            && (areas[0] - areas[1]).abs() <= FACING * (areas[0] + areas[1])
        {
            return Err(failed(edges_of(&triangles[first])[0]));
        }
        for &k in piece.iter().filter(|&&k| side[k] == Some(minority)) {
            triangles[k].swap(1, 2);
            mending.turned += 1;
        }
    }
    Ok(triangles)
}
