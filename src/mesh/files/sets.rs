//! Boundaries from surfaces (sides of elements) and from sets of nodes.

use std::collections::{BTreeSet, HashMap, HashSet};

use super::tables::Tables;
use crate::elements::{CellKind, CellShape};
use crate::mesh::file_error::{FileError, FileProblem};
use crate::mesh::{Boundary, Facet, Mesh, MeshError};

/// Corners of the sides of a cell in Abaqus' order (Abaqus Analysis User's Guide, sections 28.1.3 and 28.1.4); those of plane cells and
/// pyramids are the facets in their order.
const TETRAHEDRON: [&[usize]; 4] = [&[0, 1, 2], &[0, 3, 1], &[1, 3, 2], &[2, 3, 0]];
const HEXAHEDRON: [&[usize]; 6] = [&[0, 1, 2, 3], &[4, 7, 6, 5], &[0, 4, 5, 1], &[1, 5, 6, 2], &[2, 6, 7, 3], &[3, 7, 4, 0]];
const WEDGE: [&[usize]; 5] = [&[0, 1, 2], &[3, 5, 4], &[0, 3, 4, 1], &[1, 4, 5, 2], &[2, 5, 3, 0]];

/// Number of the local facet of a side from 1.
fn facet_of_side(kind: CellKind, side: u8) -> Option<u8> {
    let place = usize::from(side).checked_sub(1)?;
    let facets = kind.facets();
    let sides: &[&[usize]] = match kind.shape() {
        CellShape::Tetrahedron => &TETRAHEDRON,
        CellShape::Hexahedron => &HEXAHEDRON,
        CellShape::Wedge => &WEDGE,
        CellShape::Triangle | CellShape::Quadrilateral | CellShape::Pyramid => facets,
    };
    let corners = sides.get(place)?;
    facets.iter().position(|facet| corners.iter().all(|corner| facet.contains(corner))).map(|local| local as u8)
}

/// Adds the boundaries of the surfaces, given the cells by their numbers in the tables, and the reversed cells.
pub(super) fn attach_surfaces(
    mesh: &mut Mesh,
    tables: &Tables,
    cells: &HashMap<u64, u32>,
    reversed: &HashSet<u32>,
) -> Result<(), MeshError> {
    let hull: BTreeSet<Facet> = mesh.hull().into_iter().collect();
    for surface in &tables.surfaces {
        let mut facets: Vec<Facet> = Vec::new();
        for &(number, side, at) in &surface.sides {
            let fail = |problem: FileProblem| Err(FileError { at, problem }.into());
            let Some(&cell) = cells.get(&number) else {
                let (name, number) = (surface.name.clone(), tables.written_element(number));
                return fail(FileProblem::UnknownMember { owner: "surface", name, kind: "element", number });
            };
            if side == 0 {
                facets.extend(hull.range(Facet { cell, local: 0 }..=Facet { cell, local: u8::MAX }));
                continue;
            }
            let (kind, collapse) = (mesh.kind_of(cell as usize), tables.collapsed.get(&number));
            let written = collapse.map_or(kind, |collapse| collapse.written);
            let Some(local) = facet_of_side(written, side) else {
                return fail(FileProblem::UnknownSide { name: surface.name.clone(), side: format!("S{side}"), kind: written.name() });
            };
            // A side that has collapsed to an edge or a point has no area and is left out.
            let Some(local) = collapse.map_or(Some(local), |collapse| collapse.facets[usize::from(local)]) else { continue };
            // A reversed plane cell has its sides in the opposite order.
            let last = kind.facets().len() as u8 - 1;
            facets.push(Facet { cell, local: if reversed.contains(&cell) { last - local } else { local } });
        }
        let mut seen = HashSet::new();
        facets.retain(|facet| seen.insert(*facet));
        let name = free_name(mesh, &surface.name, "surface");
        mesh.boundaries.push(Boundary::of_facets(&name, facets));
    }
    Ok(())
}

/// Adds the boundaries of the node sets: facets of the hull with all nodes in the set, and the remaining nodes. `node` returns the index of
/// a node, `Some(None)` for a node without cells, `None` for a missing one. If a set has no mid-side nodes, the corners of second-order
/// facets suffice; the names of such sets are returned.
pub(super) fn attach_node_sets(
    mesh: &mut Mesh,
    tables: &Tables,
    node: impl Fn(u64) -> Option<Option<u32>>,
) -> Result<Vec<String>, MeshError> {
    let mut completed = Vec::new();
    if tables.node_sets.is_empty() {
        return Ok(completed);
    }
    let hull = mesh.hull();
    let middles_of = |(kind, cell): (CellKind, &'_ [u32])| cell[kind.shape().corners()..].to_vec();
    let middles: BTreeSet<u32> = mesh.cells_with_kinds().flat_map(middles_of).collect();
    for set in &tables.node_sets {
        let mut members: BTreeSet<u32> = BTreeSet::new();
        for &number in &set.nodes {
            match node(number) {
                Some(Some(node)) => drop(members.insert(node)),
                Some(None) => {}
                None => {
                    let (name, number) = (set.name.clone(), tables.written_node(number));
                    let problem = FileProblem::UnknownMember { owner: "node set", name, kind: "node", number };
                    return Err(FileError { at: set.at, problem }.into());
                }
            }
        }
        let has_corners_alone = !middles.is_empty() && members.is_disjoint(&middles);
        let is_inside = |node: &u32| members.contains(node) || has_corners_alone && middles.contains(node);
        let facets: Vec<Facet> = hull.iter().filter(|&&facet| mesh.facet_nodes(facet).all(|node| is_inside(&node))).copied().collect();
        let covered: HashSet<u32> = facets.iter().flat_map(|&facet| mesh.facet_nodes(facet)).collect();
        let nodes: Vec<u32> = members.into_iter().filter(|node| !covered.contains(node)).collect();
        // Sets of nodes without cells, such as reference points, are left out.
        if facets.is_empty() && nodes.is_empty() {
            continue;
        }
        // Some programs repeat the nodes of an element group under the group's name; such a set is left out.
        let own = Boundary { name: set.name.clone(), facets, nodes };
        if mesh.boundary(&set.name).is_some_and(|known| mesh.boundary_nodes(known) == mesh.boundary_nodes(&own)) {
            continue;
        }
        let Boundary { facets, nodes, .. } = own;
        let name = free_name(mesh, &set.name, "nodes");
        if has_corners_alone && !facets.is_empty() {
            completed.push(name.clone());
        }
        mesh.boundaries.push(Boundary { name, facets, nodes });
    }
    Ok(completed)
}

/// Name that no boundary has: the given one, or with a word appended.
pub(super) fn free_name(mesh: &Mesh, name: &str, word: &str) -> String {
    let mut free = name.to_string();
    while mesh.boundary(&free).is_some() {
        free = format!("{free} {word}");
    }
    free
}
