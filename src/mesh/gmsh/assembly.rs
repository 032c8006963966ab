//! From the tables of a file to a mesh: numbers become indices, physical groups become parts and boundaries.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::tables::{Element, Tables};
use crate::elements::CellKind;
use crate::math::tolerances::PLANE;
use crate::mesh::check::repeated;
use crate::mesh::topology::{FacetKey, facet_key};
use crate::mesh::{Boundary, Facet, Mesh, MeshError};

/// The mesh of a file.
pub(super) fn assemble(tables: Tables) -> Result<Mesh, MeshError> {
    let numbering = Numbering::new(&tables)?;
    let mut mesh;
    let origins;
    if tables.hexes.is_empty() {
        if tables.quads.is_empty() {
            return Err(MeshError::NoCells { line: tables.elements_line, lines: tables.lines.len() });
        }
        (mesh, origins) = cells(CellKind::Quad4, &tables, &tables.quads, &numbering)?;
        attach_boundaries(&mut mesh, &tables, &tables.lines, &numbering)?;
    } else {
        (mesh, origins) = cells(CellKind::Hex8, &tables, &tables.hexes, &numbering)?;
        attach_boundaries(&mut mesh, &tables, &tables.quads, &numbering)?;
    }
    let used = take_used_nodes(&mut mesh, &tables);
    attach_points(&mut mesh, &tables, &numbering, &used)?;
    if mesh.dimension() == 2 {
        flatten(&mut mesh, &tables, &used)?;
    }
    match mesh.defects().into_iter().next() {
        Some(defect) => Err(placed(defect, &origins, &tables, &used)),
        None => Ok(mesh),
    }
}

/// Where a cell stands in the file.
struct Origin {
    number: u64,
    line: u32,
}

/// From the numbers of nodes in the file to indices of the node table.
enum Numbering {
    /// Index by number, `u32::MAX` for none: for numbers without great gaps.
    Dense(Vec<u32>),
    /// Any numbers.
    Sparse(HashMap<u64, u32>),
}

impl Numbering {
    fn new(tables: &Tables) -> Result<Numbering, MeshError> {
        let numbers = &tables.node_numbers;
        let greatest = numbers.iter().max().copied().unwrap_or(0);
        // the table is bounded by what the file really holds, not by the numbers in it
        let mut numbering = match usize::try_from(greatest) {
            Ok(greatest) if greatest / 4 <= numbers.len() => Numbering::Dense(vec![u32::MAX; greatest + 1]),
            _ => Numbering::Sparse(HashMap::new()),
        };
        for (index, (&node, &line)) in numbers.iter().zip(&tables.node_lines).enumerate() {
            let before = match &mut numbering {
                Numbering::Dense(table) => match std::mem::replace(&mut table[node as usize], index as u32) {
                    u32::MAX => None,
                    before => Some(before),
                },
                Numbering::Sparse(table) => table.insert(node, index as u32),
            };
            if let Some(before) = before {
                return Err(MeshError::DuplicateNode { line: line as usize, node, first: tables.node_lines[before as usize] as usize });
            }
        }
        Ok(numbering)
    }

    fn index(&self, number: u64) -> Option<u32> {
        match self {
            Numbering::Dense(table) => usize::try_from(number).ok().and_then(|n| table.get(n)).copied().filter(|&index| index != u32::MAX),
            Numbering::Sparse(table) => table.get(&number).copied(),
        }
    }

    /// Indices of the nodes of an element, which must be there and differ.
    fn indices<const N: usize>(&self, element: &Element<N>) -> Result<[u32; N], MeshError> {
        let mut indices = [0; N];
        for (index, &node) in indices.iter_mut().zip(&element.nodes) {
            let Some(known) = self.index(node) else {
                return Err(MeshError::MissingNode { line: element.line as usize, element: element.number, node });
            };
            *index = known;
        }
        match repeated(&element.nodes) {
            Some(node) => Err(MeshError::RepeatedNode { line: Some(element.line as usize), cell: element.number, node }),
            None => Ok(indices),
        }
    }
}

/// Name of a physical group: as in the file, or its number.
fn name(tables: &Tables, dimension: usize, group: u64) -> String {
    tables.names.get(&(dimension, group)).cloned().unwrap_or_else(|| group.to_string())
}

/// Cells and parts, with indices of the node table; points come later.
fn cells<const N: usize>(
    kind: CellKind,
    tables: &Tables,
    elements: &[Element<N>],
    numbering: &Numbering,
) -> Result<(Mesh, Vec<Origin>), MeshError> {
    let mut mesh = Mesh { kind, points: Vec::new(), connectivity: Vec::new(), boundaries: Vec::new(), parts: Vec::new() };
    let mut origins: Vec<Origin> = Vec::new();
    let mut parts: BTreeMap<u64, Vec<u32>> = BTreeMap::new();
    // version 2.2 writes a cell once for each of its physical groups
    let mut known: HashMap<[u32; N], u32> = HashMap::with_capacity(elements.len());
    let mut members: HashSet<(u64, u32)> = HashSet::new();
    for element in elements {
        let indices = numbering.indices(element)?;
        let mut key = indices;
        key.sort_unstable();
        let next = origins.len() as u32;
        let cell = *known.entry(key).or_insert(next);
        let groups = &tables.groups[element.groups as usize];
        if cell == next {
            mesh.connectivity.extend(indices);
            origins.push(Origin { number: element.number, line: element.line });
        } else if groups.is_empty() || groups.iter().any(|&group| members.contains(&(group, cell))) {
            let first = origins[cell as usize].number;
            return Err(MeshError::DuplicateCell { line: element.line as usize, cell: element.number, first });
        }
        for &group in groups {
            members.insert((group, cell));
            parts.entry(group).or_default().push(cell);
        }
    }
    mesh.parts = parts.into_iter().map(|(group, cells)| (name(tables, kind.dimension(), group), cells)).collect();
    Ok((mesh, origins))
}

/// Boundaries from the elements one dimension below the cells, in the order of the file.
fn attach_boundaries<const N: usize>(
    mesh: &mut Mesh,
    tables: &Tables,
    elements: &[Element<N>],
    numbering: &Numbering,
) -> Result<(), MeshError> {
    let mut keys: Vec<FacetKey> = Vec::with_capacity(elements.len());
    let mut sides: HashMap<FacetKey, [Option<Facet>; 2]> = HashMap::new();
    for element in elements {
        let key = facet_key(numbering.indices(element)?.into_iter());
        keys.push(key);
        sides.entry(key).or_default();
    }
    if sides.is_empty() {
        return Ok(());
    }
    for facet in mesh.facets() {
        if let Some(found) = sides.get_mut(&facet_key(mesh.facet_nodes(facet))) {
            // a third side is found when the mesh is checked
            if let Some(free) = found.iter_mut().find(|side| side.is_none()) {
                *free = Some(facet);
            }
        }
    }
    let below = mesh.dimension() - 1;
    let mut touched: Option<HashSet<u32>> = None;
    let mut boundaries: BTreeMap<u64, (Vec<Facet>, HashSet<FacetKey>)> = BTreeMap::new();
    for (element, key) in elements.iter().zip(keys) {
        let groups = &tables.groups[element.groups as usize];
        let facets = sides[&key].into_iter().flatten();
        if facets.clone().next().is_none() {
            if mesh.dimension() == 3 {
                let touched = touched.get_or_insert_with(|| mesh.connectivity.iter().copied().collect());
                if key.iter().all(|node| !touched.contains(node)) {
                    return Err(MeshError::MixedKinds { line: element.line as usize, element: element.number });
                }
            }
            if let Some(&group) = groups.first() {
                let boundary = name(tables, below, group);
                return Err(MeshError::StrayFacet { line: element.line as usize, element: element.number, boundary });
            }
        }
        for &group in groups {
            let (list, seen) = boundaries.entry(group).or_default();
            if seen.insert(key) {
                list.extend(facets.clone());
            }
        }
    }
    mesh.boundaries = boundaries.into_iter().map(|(group, (facets, _))| Boundary::of_facets(&name(tables, below, group), facets)).collect();
    Ok(())
}

/// Boundaries of single points from groups of points, in the order of the file. Points that no cell uses, such as centers of arcs, are left
/// out. A name that a boundary of facets has already gets ` points` behind it.
fn attach_points(mesh: &mut Mesh, tables: &Tables, numbering: &Numbering, used: &[u32]) -> Result<(), MeshError> {
    let mut boundaries: BTreeMap<u64, Vec<u32>> = BTreeMap::new();
    for element in &tables.single_points {
        let [index] = numbering.indices(element)?;
        let Ok(node) = used.binary_search(&index) else { continue };
        for &group in &tables.groups[element.groups as usize] {
            let nodes = boundaries.entry(group).or_default();
            if !nodes.contains(&(node as u32)) {
                nodes.push(node as u32);
            }
        }
    }
    for (group, nodes) in boundaries {
        let mut name = name(tables, 0, group);
        if mesh.boundary(&name).is_some() {
            name += " points";
        }
        mesh.boundaries.push(Boundary { name, facets: Vec::new(), nodes });
    }
    Ok(())
}

/// Takes over the nodes that cells use, in their order; returns their indices in the node table.
fn take_used_nodes(mesh: &mut Mesh, tables: &Tables) -> Vec<u32> {
    let mut new_index = vec![u32::MAX; tables.points.len()];
    mesh.connectivity.iter().for_each(|&node| new_index[node as usize] = 0);
    let mut used = Vec::new();
    for (old, slot) in new_index.iter_mut().enumerate().filter(|(_, slot)| **slot == 0) {
        *slot = used.len() as u32;
        used.push(old as u32);
    }
    mesh.points = used.iter().map(|&old| tables.points[old as usize]).collect();
    mesh.connectivity.iter_mut().for_each(|node| *node = new_index[*node as usize]);
    used
}

/// The third coordinate of plane meshes must be zero but for round-off, and is exactly zero then.
fn flatten(mesh: &mut Mesh, tables: &Tables, used: &[u32]) -> Result<(), MeshError> {
    let size = mesh.points.iter().flat_map(|p| [p[0], p[1]]).fold(0.0, |size: f64, x| size.max(x.abs()));
    for (point, &old) in mesh.points.iter_mut().zip(used) {
        if point[2].abs() > PLANE * size {
            let old = old as usize;
            return Err(MeshError::NotPlane { line: tables.node_lines[old] as usize, node: tables.node_numbers[old], z: point[2] });
        }
        point[2] = 0.0;
    }
    Ok(())
}

/// A defect in the numbers and lines of the file.
fn placed(mut defect: MeshError, origins: &[Origin], tables: &Tables, used: &[u32]) -> MeshError {
    use MeshError::*;
    match &mut defect {
        InvertedCell { line, cell, .. } | DegenerateCell { line, cell, .. } | CrowdedFacet { line, cell, .. } => {
            let origin = &origins[*cell as usize];
            *line = Some(origin.line as usize);
            *cell = origin.number;
        }
        RepeatedNode { line, cell, node } => {
            let origin = &origins[*cell as usize];
            *line = Some(origin.line as usize);
            *cell = origin.number;
            *node = tables.node_numbers[used[*node as usize] as usize];
        }
        _ => {}
    }
    defect
}
