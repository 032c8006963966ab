//! Conversion of the tables of a file to a mesh: numbers become indices, groups become parts and boundaries. Clockwise plane cells are
//! reversed.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use super::numbering::Numbering;
use super::options::{FileNote, ReadOptions, Shells, Structural};
use super::sets::{attach_node_sets, attach_surfaces, free_name};
use super::tables::{Elements, Shape, Tables};
use crate::elements::CellKind;
use crate::math::tolerances::PLANE;
use crate::mesh::file_error::{FileError, FilePosition, FileProblem};
use crate::mesh::topology::{FacetKey, facet_key};
use crate::mesh::{Boundary, Facet, Mesh, MeshError};

/// The mesh of a file, and the changes made to the content.
pub(super) fn assemble(mut tables: Tables, options: &ReadOptions) -> Result<(Mesh, Vec<FileNote>), MeshError> {
    tables.match_face_nodes();
    let collapsed = tables.collapse()?;
    if let Some(part) = &options.part {
        tables.keep_part(part)?;
    }
    settle_structural(&mut tables, options)?;
    let numbering = Numbering::new(&tables)?;
    let kinds = kinds_of(&tables)?;
    let (mut mesh, origins, turned) = cells(&kinds, &tables, &numbering)?;
    let strays = attach_boundaries(&mut mesh, &tables, &numbering)?;
    let tables = &leave_out_strays(tables, &strays, options)?;
    let used = take_used_nodes(&mut mesh, tables);
    attach_edges_and_points(&mut mesh, tables, &numbering, &used)?;
    if mesh.dimension() == 2 {
        flatten(&mut mesh, tables, &used)?;
    }
    if let Some(defect) = mesh.defects().into_iter().next() {
        return Err(placed(defect, &origins, tables, &used));
    }
    if !tables.surfaces.is_empty() {
        let cells = origins.iter().zip(0..).map(|(origin, cell)| (origin.number, cell)).collect();
        attach_surfaces(&mut mesh, tables, &cells, &turned)?;
    }
    let completed = attach_node_sets(&mut mesh, tables, |number| {
        let index = numbering.index(number)?;
        Some(used.binary_search(&index).ok().map(|node| node as u32))
    })?;
    let mut notes = Vec::new();
    if !tables.left_out.is_empty() {
        notes.push(FileNote::Skipped(tables.left_out.iter().map(|(name, &(count, _))| (name.clone(), count)).collect()));
    }
    if let Some(&first) = turned.iter().min() {
        notes.push(FileNote::Turned { count: turned.len(), first: tables.written_element(origins[first as usize].number) });
    }
    if let Some((count, first)) = tables.without_face_nodes {
        notes.push(FileNote::FaceNodes { count, first });
    }
    notes.extend(collapsed);
    if !completed.is_empty() {
        notes.push(FileNote::CornerSets(completed));
    }
    Ok((mesh, notes))
}

/// Decides the treatment of shells: on solid cells they are facets, beside plane cells they are left out, and without other cells they are
/// refused or read as plane cells, by the options.
fn settle_structural(tables: &mut Tables, options: &ReadOptions) -> Result<(), MeshError> {
    let [has_plane, has_solid] = [2, 3].map(|dimension| {
        tables.elements.iter().any(|(shape, elements)| {
            let is_cell = matches!(shape, Shape::Cell(kind) if kind.dimension() == dimension);
            is_cell && !elements.numbers.iter().all(|number| tables.structural.contains(number))
        })
    });
    let is_surface = |shape: &Shape| matches!(shape, Shape::Cell(kind) if kind.dimension() == 2);
    let shells: Vec<Shape> = tables.structural_types.keys().copied().filter(is_surface).collect();
    if !has_solid && !shells.is_empty() {
        if has_plane {
            shells.iter().for_each(|&shape| tables.leave_out_structural(shape));
        } else if options.shells == Shells::Plane {
            shells.iter().for_each(|shape| drop(tables.structural_types.remove(shape)));
            tables.structural.clear();
        } else if let Some((name, at)) = tables.structural_types.get(&shells[0]).cloned() {
            let count = shells.iter().filter_map(|shape| tables.elements.get(shape)).map(|elements| elements.numbers.len()).sum();
            return Err(FileError { at, problem: FileProblem::Shells { name, count } }.into());
        }
    }
    if has_solid && tables.has_beams {
        [Shape::Line(2), Shape::Line(3)].into_iter().for_each(|shape| tables.leave_out_structural(shape));
    }
    Ok(())
}

/// Tables after elements that are neither cells nor facets were counted as left out; an error if the options refuse such elements.
fn leave_out_strays(mut tables: Tables, strays: &[(Shape, FilePosition)], options: &ReadOptions) -> Result<Tables, MeshError> {
    strays.iter().for_each(|&(shape, at)| tables.leave_out(shape, 1, at));
    match tables.left_out.iter().next() {
        Some((name, &(count, at))) if options.structural == Structural::Refused => {
            Err(FileError { at, problem: FileProblem::Structural { name: name.clone(), count } }.into())
        }
        _ => Ok(tables),
    }
}

/// Kinds of the cells, all of one order: solid ones if there are any.
fn kinds_of(tables: &Tables) -> Result<Vec<CellKind>, MeshError> {
    let kinds = |dimension: usize| {
        tables.elements.iter().filter_map(move |(shape, elements)| match shape {
            Shape::Cell(kind) if kind.dimension() == dimension && !elements.numbers.is_empty() => Some((*kind, elements)),
            _ => None,
        })
    };
    let dimension = if kinds(3).next().is_some() { 3 } else { 2 };
    let Some((kind, most)) = kinds(dimension).max_by_key(|(_, elements)| elements.numbers.len()) else {
        let lines = tables.elements.iter().filter(|(shape, _)| shape.dimension() == 1).map(|(_, elements)| elements.numbers.len()).sum();
        let at = tables.elements_begin.unwrap_or(FilePosition::Line(1));
        return Err(FileError { at, problem: FileProblem::NoCells { lines } }.into());
    };
    match kinds(dimension).find(|(other, _)| other.is_quadratic() != kind.is_quadratic()) {
        None => Ok(kinds(dimension).map(|(kind, _)| kind).collect()),
        Some((other, elements)) => {
            let (count, others, element) = (most.numbers.len(), elements.numbers.len(), tables.written_element(elements.numbers[0]));
            let problem = FileProblem::MixedCells { kind: kind.name(), count, other: other.name(), others, element };
            Err(FileError { at: tables.element_place(elements, 0), problem }.into())
        }
    }
}

/// Origin of a cell in the file.
struct Origin {
    number: u64,
    at: FilePosition,
}

/// Sorted corners of a cell, padded.
type CellKey = [u32; 8];

/// Reverses the node order of a plane cell, keeping the first node.
fn reverse(nodes: &mut [u32], corners: usize) {
    nodes[1..corners].reverse();
    let middles = corners..(2 * corners).min(nodes.len());
    nodes[middles].reverse();
}

/// True if the corners of a plane cell run clockwise, by the sign of their polygon's area.
fn is_clockwise(corners: &[u32], points: &[[f64; 3]]) -> bool {
    let at = |k: usize| points[corners[k % corners.len()] as usize];
    let doubled: f64 = (0..corners.len()).map(|k| (at(k), at(k + 1))).map(|(a, b)| (a[0] - b[0]) * (a[1] + b[1])).sum();
    doubled < 0.0
}

/// Cells and parts with indices of the node table, places of the cells in the file, and reversed cells; points are added later.
fn cells(kinds: &[CellKind], tables: &Tables, numbering: &Numbering) -> Result<(Mesh, Vec<Origin>, HashSet<u32>), MeshError> {
    let mut mesh = Mesh { points: Vec::new(), blocks: Vec::new(), boundaries: Vec::new(), parts: Vec::new() };
    let (mut origins, mut turned) = (Vec::<Origin>::new(), HashSet::new());
    let mut parts: BTreeMap<u64, Vec<u32>> = BTreeMap::new();
    let blocks = || kinds.iter().filter_map(|&kind| Some((kind, tables.elements.get(&Shape::Cell(kind))?)));
    // MSH 2.2 lists a cell once for each of its physical groups.
    let mut known: HashMap<CellKey, u32> = HashMap::with_capacity(blocks().map(|(_, elements)| elements.numbers.len()).sum());
    let mut members: HashSet<(u64, u32)> = HashSet::new();
    let mut indices = Vec::new();
    let elements = blocks().flat_map(|(kind, elements)| (0..elements.numbers.len()).map(move |element| (kind, elements, element)));
    for (kind, elements, element) in elements {
        let number = elements.numbers[element];
        indices.resize(kind.nodes(), 0);
        numbering.indices_into(tables, elements, element, &mut indices)?;
        let (mut key, corners) = ([u32::MAX; 8], kind.shape().corners());
        key[..corners].copy_from_slice(&indices[..corners]);
        key.sort_unstable();
        let next = origins.len() as u32;
        let cell = *known.entry(key).or_insert(next);
        let groups = &tables.groups[elements.groups[element] as usize];
        let at = tables.element_place(elements, element);
        if cell == next {
            if kind.dimension() == 2 && is_clockwise(&indices[..corners], &tables.points) {
                reverse(&mut indices, corners);
                turned.insert(cell);
            }
            mesh.add_cells(kind, indices.iter().copied());
            origins.push(Origin { number, at });
        } else if groups.is_empty() || groups.iter().any(|&group| members.contains(&(group, cell))) {
            let first = tables.written_element(origins[cell as usize].number);
            let problem = FileProblem::DuplicateCell { cell: tables.written_element(number), first };
            return Err(FileError { at, problem }.into());
        }
        for &group in groups {
            members.insert((group, cell));
            parts.entry(group).or_default().push(cell);
        }
    }
    mesh.parts = parts.into_iter().map(|(group, cells)| (tables.name(mesh.dimension(), group), cells)).collect();
    Ok((mesh, origins, turned))
}

/// Element that represents a facet.
struct FacetElement<'a> {
    shape: Shape,
    elements: &'a Elements,
    index: usize,
    key: FacetKey,
}

/// Elements one dimension below the cells in the order of the file.
fn facet_elements<'a>(mesh: &Mesh, tables: &'a Tables, numbering: &Numbering) -> Result<Vec<FacetElement<'a>>, MeshError> {
    let mut found = Vec::new();
    for (&shape, elements) in tables.elements.iter().filter(|(shape, _)| shape.dimension() + 1 == mesh.dimension()) {
        let mut indices = vec![0; shape.nodes()];
        for index in 0..elements.numbers.len() {
            numbering.indices_into(tables, elements, index, &mut indices)?;
            found.push(FacetElement { shape, elements, index, key: facet_key(indices.iter().copied()) });
        }
    }
    Ok(found)
}

/// Adds boundaries from the elements one dimension below the cells, in the order of the file; returns elements that are neither cells nor
/// facets.
fn attach_boundaries(mesh: &mut Mesh, tables: &Tables, numbering: &Numbering) -> Result<Vec<(Shape, FilePosition)>, MeshError> {
    let elements = facet_elements(mesh, tables, numbering)?;
    let mut sides: HashMap<FacetKey, [Option<Facet>; 2]> = elements.iter().map(|element| (element.key, [None; 2])).collect();
    let mut strays = Vec::new();
    if sides.is_empty() {
        return Ok(strays);
    }
    for facet in mesh.facets() {
        if let Some(found) = sides.get_mut(&facet_key(mesh.facet_nodes(facet))) {
            // A third cell at a facet is reported later by the check of the mesh.
            if let Some(free) = found.iter_mut().find(|side| side.is_none()) {
                *free = Some(facet);
            }
        }
    }
    let below = mesh.dimension() - 1;
    let mut touched: Option<HashSet<u32>> = None;
    let mut boundaries: BTreeMap<u64, (Vec<Facet>, HashSet<FacetKey>)> = BTreeMap::new();
    for element in &elements {
        let FacetElement { shape, elements, index, key } = element;
        let groups = &tables.groups[elements.groups[*index] as usize];
        let facets = sides[key].into_iter().flatten();
        if facets.clone().next().is_none() {
            let at = tables.element_place(elements, *index);
            if tables.structural.contains(&elements.numbers[*index]) {
                strays.push((*shape, at));
                continue;
            }
            let number = tables.written_element(elements.numbers[*index]);
            if let Shape::Cell(kind) = shape {
                let touched = touched.get_or_insert_with(|| mesh.connectivity().collect());
                if key.iter().all(|node| !touched.contains(node)) {
                    let problem = FileProblem::MixedDimensions { kind: kind.name(), solid: mesh.blocks[0].kind.name(), element: number };
                    return Err(FileError { at, problem }.into());
                }
            }
            if let Some(&group) = groups.first() {
                let boundary = tables.name(below, group);
                return Err(FileError { at, problem: FileProblem::StrayFacet { element: number, boundary } }.into());
            }
        }
        for &group in groups {
            let (list, seen) = boundaries.entry(group).or_default();
            if seen.insert(*key) {
                list.extend(facets.clone());
            }
        }
    }
    let named = |(group, (facets, _)): (u64, (Vec<Facet>, _))| Boundary::of_facets(&tables.name(below, group), facets);
    mesh.boundaries = boundaries.into_iter().map(named).collect();
    Ok(strays)
}

/// Adds boundaries of single nodes from groups of points and, in space, of lines on cells, in the order of the file. Nodes without cells,
/// such as centers of arcs, are left out. If a boundary of facets has the name of a group, its missing nodes are added to it; a group
/// without a name gets a boundary of its own.
fn attach_edges_and_points(mesh: &mut Mesh, tables: &Tables, numbering: &Numbering, used: &[u32]) -> Result<(), MeshError> {
    let shapes = [Shape::Line(2), Shape::Line(3), Shape::Point].into_iter().filter(|shape| shape.dimension() + 1 < mesh.dimension());
    let mut boundaries: BTreeMap<(bool, u64), (BTreeSet<u32>, Vec<u32>)> = BTreeMap::new();
    for shape in shapes {
        let Some(elements) = tables.elements.get(&shape) else { continue };
        let mut indices = vec![0; shape.nodes()];
        for element in 0..elements.numbers.len() {
            numbering.indices_into(tables, elements, element, &mut indices)?;
            let nodes: Option<Vec<usize>> = indices.iter().map(|index| used.binary_search(index).ok()).collect();
            let Some(nodes) = nodes else { continue };
            for &group in &tables.groups[elements.groups[element] as usize] {
                let (seen, list) = boundaries.entry((shape == Shape::Point, group)).or_default();
                list.extend(nodes.iter().map(|&node| node as u32).filter(|&node| seen.insert(node)));
            }
        }
    }
    for ((is_point, group), (_, mut nodes)) in boundaries {
        let dimension = usize::from(!is_point);
        let mut name = tables.name(dimension, group);
        if !tables.names.contains_key(&(dimension, group)) {
            name = free_name(mesh, &name, if is_point { "point" } else { "edge" });
        }
        match mesh.boundaries.iter().position(|boundary| boundary.name == name) {
            Some(known) => {
                let facets = mesh.boundary_nodes(&mesh.boundaries[known]);
                nodes.retain(|node| facets.binary_search(node).is_err());
                mesh.boundaries[known].nodes.extend(nodes);
            }
            None => mesh.boundaries.push(Boundary { name, facets: Vec::new(), nodes }),
        }
    }
    Ok(())
}

/// Copies the nodes that cells use into the mesh, in the order of the table; returns their indices in the node table.
fn take_used_nodes(mesh: &mut Mesh, tables: &Tables) -> Vec<u32> {
    let mut new_index = vec![u32::MAX; tables.points.len()];
    mesh.connectivity().for_each(|node| new_index[node as usize] = 0);
    let mut used = Vec::new();
    for (old, slot) in new_index.iter_mut().enumerate().filter(|(_, slot)| **slot == 0) {
        *slot = used.len() as u32;
        used.push(old as u32);
    }
    mesh.points = used.iter().map(|&old| tables.points[old as usize]).collect();
    mesh.renumber(|node| new_index[node as usize]);
    used
}

/// Checks that the third coordinates of a plane mesh are zero up to round-off, and sets them to zero.
fn flatten(mesh: &mut Mesh, tables: &Tables, used: &[u32]) -> Result<(), MeshError> {
    let size = mesh.points.iter().flat_map(|p| [p[0], p[1]]).fold(0.0, |size: f64, x| size.max(x.abs()));
    for (point, &old) in mesh.points.iter_mut().zip(used) {
        if point[2].abs() > PLANE * size {
            let node = tables.written_node(tables.node_numbers[old as usize]);
            return Err(FileError { at: tables.node_place(old as usize), problem: FileProblem::NotPlane { node, z: point[2] } }.into());
        }
        point[2] = 0.0;
    }
    Ok(())
}

/// Converts a defect to the numbers and places of the file.
fn placed(mut defect: MeshError, origins: &[Origin], tables: &Tables, used: &[u32]) -> MeshError {
    use MeshError::*;
    match &mut defect {
        InvertedCell { at, cell, .. } | DegenerateCell { at, cell, .. } | CrowdedFacet { at, cell, .. } | Unmatched { at, cell, .. } => {
            let origin = &origins[*cell as usize];
            *at = Some(origin.at);
            *cell = tables.written_element(origin.number);
        }
        RepeatedNode { at, cell, node } => {
            let origin = &origins[*cell as usize];
            *at = Some(origin.at);
            *cell = tables.written_element(origin.number);
            *node = tables.written_node(tables.node_numbers[used[*node as usize] as usize]);
        }
        _ => {}
    }
    defect
}
