//! Cells with repeated nodes, read as cells of a smaller kind: hexahedra as wedges, pyramids or tetrahedra, wedges as pyramids or
//! tetrahedra, quadrilaterals as triangles.
//!
//! Edges between equal nodes vanish, and so do facets with fewer than three corners left (two in the plane). The cell is of the kind whose
//! oriented facets are the remaining ones. A hexahedron with one collapsed edge has seven corners and corresponds to no supported kind.

use std::collections::HashMap;

use crate::elements::CellKind;
use crate::mesh::check::repeated;

/// Kind of a cell with repeated nodes.
#[derive(Clone)]
pub(super) struct Collapse {
    /// Kind as which the cell is written.
    pub written: CellKind,
    /// Kind that the cell is of.
    pub kind: CellKind,
    /// Place of each node of `kind` among the nodes as written.
    pub places: Vec<usize>,
    /// Local facet of `kind` for each facet of `written`; `None` for a facet that has become an edge or a point.
    pub facets: Vec<Option<u8>>,
}

/// For each entry of a cell's node list, the position of the first entry with the same node number.
pub(super) fn first_places(nodes: &[u64]) -> Vec<usize> {
    nodes.iter().map(|node| nodes.iter().position(|other| other == node).unwrap_or_default()).collect()
}

/// Kinds of fewer corners that a cell of a kind may collapse to.
pub(super) fn smaller_kinds(written: CellKind) -> impl Iterator<Item = CellKind> {
    let has_middles_alone = |kind: &CellKind| kind.nodes() == kind.shape().corners() + kind.shape().edges().len();
    let of_order = move |kind: &CellKind| if written.is_quadratic() { has_middles_alone(kind) } else { !kind.is_quadratic() };
    let is_smaller = move |kind: &CellKind| kind.dimension() == written.dimension() && kind.shape().corners() < written.shape().corners();
    CellKind::ALL.iter().copied().filter(move |kind| of_order(kind) && is_smaller(kind))
}

/// Corners of a facet in their cyclic order from the smallest on, without repetition of neighbors; `None` if another node is repeated.
/// Edges of plane cells keep their direction.
fn cycle(mut corners: Vec<usize>) -> Option<Vec<usize>> {
    corners.dedup();
    if corners.len() > 1 && corners.first() == corners.last() {
        corners.pop();
    }
    if corners.len() > 2 {
        let smallest = (0..corners.len()).min_by_key(|&k| corners[k])?;
        corners.rotate_left(smallest);
    }
    repeated(&corners).is_none().then_some(corners)
}

/// Corners of each facet of a kind, renumbered.
fn facets(kind: CellKind, number: impl Fn(usize) -> usize) -> Option<Vec<Vec<usize>>> {
    let count = |facet: &[usize]| if kind.dimension() == 2 { 2 } else { CellKind::of_face(facet.len()).shape().corners() };
    kind.facets().iter().map(|facet| cycle(facet[..count(facet)].iter().map(|&corner| number(corner)).collect())).collect()
}

/// Permutes the items from index `fixed` on until `fits` holds; returns false if no permutation satisfies it.
fn arrange(items: &mut [usize], fixed: usize, fits: &impl Fn(&[usize]) -> bool) -> bool {
    if fixed == items.len() {
        return fits(items);
    }
    (fixed..items.len()).any(|next| {
        items.swap(fixed, next);
        let is_found = arrange(items, fixed + 1, fits);
        if !is_found {
            items.swap(fixed, next);
        }
        is_found
    })
}

impl Collapse {
    /// Kind of a cell whose nodes are equal as [`first_places`] says; `None` if there is no such kind.
    pub fn new(written: CellKind, first: &[usize]) -> Option<Collapse> {
        let corners = written.shape().corners();
        let remaining = facets(written, |corner| first[corner])?;
        let is_facet = |facet: &&Vec<usize>| facet.len() >= written.dimension();
        let mut own: Vec<usize> = (0..corners).filter(|&corner| first[corner] == corner).collect();
        let kind = smaller_kinds(written).find(|kind| {
            let is_it = |order: &[usize]| {
                let wanted = facets(*kind, |corner| order[corner]).unwrap_or_default();
                wanted.len() == remaining.iter().filter(is_facet).count() && wanted.iter().all(|facet| remaining.contains(facet))
            };
            kind.shape().corners() == own.len() && arrange(&mut own, 0, &is_it)
        })?;
        let middles = middles(written, first)?;
        let mut places = own;
        if kind.is_quadratic() {
            let ends = kind.shape().edges().iter().map(|&[a, b]| [places[a].min(places[b]), places[a].max(places[b])]);
            let own: Option<Vec<usize>> = ends.map(|ends| middles.get(&ends).copied()).collect();
            places.extend(own?);
        }
        if repeated(&places).is_some() {
            return None;
        }
        let wanted = facets(kind, |corner| places[corner])?;
        let local = |facet: &Vec<usize>| wanted.iter().position(|other| other == facet).map(|local| local as u8);
        Some(Collapse { written, kind, facets: remaining.iter().map(local).collect(), places })
    }
}

/// Mid-side node of each edge between two remaining corners; `None` if a collapsed edge has a separate mid-side node, or if two merged
/// edges have different ones.
fn middles(written: CellKind, first: &[usize]) -> Option<HashMap<[usize; 2], usize>> {
    let mut middles = HashMap::new();
    if written.is_quadratic() {
        let corners = written.shape().corners();
        for (&[a, b], middle) in written.shape().edges().iter().zip(&first[corners..]) {
            let (a, b) = (first[a], first[b]);
            let is_sound = if a == b { *middle == a } else { *middles.entry([a.min(b), a.max(b)]).or_insert(*middle) == *middle };
            if !is_sound {
                return None;
            }
        }
    }
    Some(middles)
}
