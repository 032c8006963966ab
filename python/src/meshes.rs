//! Meshes as arrays, and arrays as meshes.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use conserva::elements::CellKind;
use conserva::mesh::{Boundary, Facet, Mesh};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::arrays::{array, shared};
use crate::convert::to_python;
use crate::raise::{diagnostic_error, script_error};
use crate::state::{self, Live};

/// Names with numbers as bytes.
type Named = Vec<(String, Vec<u8>)>;

/// The mesh of an object.
fn mesh_of(arguments: &Bound<'_, PyTuple>) -> PyResult<Arc<Mesh>> {
    let py = arguments.py();
    let (live, value): (std::rc::Rc<Live>, _) = state::with(|state| state.value(py, arguments.get_item(0)?.extract()?))?;
    let refused = || script_error(py, "the object is no mesh", "positions and cells are those of a `Mesh`", "use `body.mesh`");
    live.calls.mesh(&value).ok_or_else(refused)
}

/// `positions(object)`: positions of the nodes of a mesh, a row of three for each.
pub fn positions<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let mesh = mesh_of(arguments)?;
    shared(arguments.py(), &mesh, |mesh| mesh.points.as_flattened(), mesh.points.len())
}

/// Kind of all cells, whose facets have one number of nodes, so that cells and facets are arrays with rows of one length.
fn kind_of_arrays(py: Python, mesh: &Mesh) -> PyResult<CellKind> {
    let is_even = |kind: &CellKind| kind.facets().iter().all(|facet| facet.len() == kind.facets()[0].len());
    mesh.only_kind().filter(is_even).ok_or_else(|| {
        let cause = format!("it has {}, whose cells or facets differ in their number of nodes", mesh.counted_cells());
        script_error(
            py,
            "the mesh has no arrays of cells",
            &cause,
            "write the fields of a run, and read the VTU files with meshio or PyVista",
        )
    })
}

/// `mesh(object)`: kind of its cells, node numbers of cells, boundaries, parts.
pub fn mesh<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let (py, mesh) = (arguments.py(), mesh_of(arguments)?);
    let kind = kind_of_arrays(py, &mesh)?;
    let entries = PyDict::new(py);
    entries.set_item("element", kind.name())?;
    entries.set_item("dimension", mesh.dimension())?;
    entries.set_item("connectivity", shared(py, &mesh, |mesh| &mesh.blocks[0].connectivity[..], mesh.cell_count())?)?;
    let boundaries = PyDict::new(py);
    for Boundary { name, facets, nodes } in &mesh.boundaries {
        let sides: Vec<u32> = facets.iter().flat_map(|facet| [facet.cell, facet.local.into()]).collect();
        let facet_nodes: Vec<u32> = facets.iter().flat_map(|facet| mesh.facet_nodes(*facet)).collect();
        let entry = PyDict::new(py);
        entry.set_item("sides", array(py, sides, Some(facets.len()))?)?;
        entry.set_item("facets", array(py, facet_nodes, Some(facets.len()))?)?;
        entry.set_item("nodes", array(py, nodes.clone(), None)?)?;
        boundaries.set_item(name, entry)?;
    }
    entries.set_item("boundaries", boundaries)?;
    let parts = PyDict::new(py);
    for (name, cells) in &mesh.parts {
        parts.set_item(name, array(py, cells.clone(), None)?)?;
    }
    entries.set_item("parts", parts)?;
    Ok(entries.into_any())
}

/// `make_mesh(element, points, connectivity, parts, boundaries, facet_sets, node_sets)`: a mesh of arrays as bytes. Boundaries are pairs of
/// cells and sides with single nodes; a facet set has the corners of facets, a node set the nodes of a boundary.
pub fn make_mesh<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    type Given = (String, Vec<u8>, Vec<u8>, Named, Vec<(String, Vec<u8>, Vec<u8>)>, Named, Named);
    let py = arguments.py();
    let (element, points, connectivity, parts, boundaries, facet_sets, node_sets): Given = arguments.extract()?;
    let Some(&kind) = CellKind::ALL.iter().find(|kind| kind.name() == element) else {
        let cause = format!("the mesh types are {}", CellKind::ALL.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(", "));
        return Err(script_error(py, &format!("there is no mesh type `{element}`"), &cause, "convert the cells first"));
    };
    let coordinates: Vec<f64> = points.as_chunks().0.iter().map(|bytes| f64::from_ne_bytes(*bytes)).collect();
    let points = coordinates.as_chunks().0.to_vec();
    let parts = parts.into_iter().map(|(name, cells)| (name, numbers(&cells))).collect();
    let mut mesh = Mesh { parts, ..Mesh::new(kind, points, numbers(&connectivity)) };
    if !mesh.blocks[0].connectivity.len().is_multiple_of(kind.nodes()) {
        return Err(PyValueError::new_err(format!("a {element} has {} nodes", kind.nodes())));
    }
    for (name, sides, nodes) in boundaries {
        let sides = numbers(&sides);
        let facets = sides.as_chunks().0.iter().map(|[cell, local]| Facet { cell: *cell, local: *local as u8 }).collect();
        mesh.boundaries.push(Boundary { name, facets, nodes: numbers(&nodes) });
    }
    if mesh.check().is_ok() && !(facet_sets.is_empty() && node_sets.is_empty()) {
        let sides = sides_by_corners(&mesh);
        for (name, corners) in facet_sets {
            let facets = facets_of(&sides, &numbers(&corners), facet_corners(kind));
            mesh.boundaries.push(Boundary::of_facets(&name, facets.map_err(|missing| no_facet(py, &name, missing))?));
        }
        for (name, nodes) in node_sets {
            let boundary = boundary_of_nodes(&sides, name, numbers(&nodes).into_iter().collect());
            // A facet set of the same name is a part of the boundary.
            match mesh.boundaries.iter_mut().find(|known| known.name == boundary.name) {
                Some(known) => *known = Boundary { name: boundary.name.clone(), ..Boundary::union(&[known.clone(), boundary]) },
                None => mesh.boundaries.push(boundary),
            }
        }
    }
    let live = state::with(|state| state.current(py))?;
    let object = live.calls.mesh_object(mesh).map_err(|error| diagnostic_error(py, &error))?;
    to_python(py, &live, object)
}

fn no_facet(py: Python, name: &str, nodes: Vec<u32>) -> PyErr {
    let title = format!("the set \"{name}\" has a facet that is no side of the hull");
    script_error(py, &title, &format!("no cell has the nodes {nodes:?} on the hull"), "leave the set out, or mend the mesh")
}

fn numbers(bytes: &[u8]) -> Vec<u32> {
    bytes.as_chunks().0.iter().map(|bytes| u32::from_ne_bytes(*bytes)).collect()
}

/// Number of corners of a facet, which are its first nodes.
fn facet_corners(kind: CellKind) -> usize {
    match (kind.dimension(), kind.facets().len()) {
        (2, _) => 2,
        (_, 4) => 3,
        _ => 4,
    }
}

/// Facets of the hull by their corners in ascending order.
fn sides_by_corners(mesh: &Mesh) -> HashMap<Vec<u32>, Facet> {
    let corners = |facet: Facet| {
        let mut corners: Vec<u32> = mesh.facet_nodes(facet).take(mesh.facet_corners(facet)).collect();
        corners.sort_unstable();
        corners
    };
    mesh.hull().into_iter().map(|facet| (corners(facet), facet)).collect()
}

/// Facets with these corners; the corners of a facet that is not there as the error.
fn facets_of(sides: &HashMap<Vec<u32>, Facet>, corners: &[u32], count: usize) -> Result<Vec<Facet>, Vec<u32>> {
    let facet = |corners: &[u32]| {
        let mut key = corners.to_vec();
        key.sort_unstable();
        sides.get(&key).copied().ok_or(key)
    };
    corners.chunks_exact(count).map(facet).collect()
}

/// The boundary of the facets all of whose corners are in a set, and of the nodes of the set that are on none of these facets.
fn boundary_of_nodes(sides: &HashMap<Vec<u32>, Facet>, name: String, nodes: BTreeSet<u32>) -> Boundary {
    let within = || sides.iter().filter(|(corners, _)| corners.iter().all(|corner| nodes.contains(corner)));
    let mut facets: Vec<Facet> = within().map(|(_, facet)| *facet).collect();
    facets.sort_unstable();
    let covered: BTreeSet<u32> = within().flat_map(|(corners, _)| corners).copied().collect();
    Boundary { name, facets, nodes: nodes.difference(&covered).copied().collect() }
}
