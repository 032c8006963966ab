//! Conversion of meshes to arrays and back.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use conserva::elements::CellKind;
use conserva::mesh::{Block, Boundary, Facet, Mesh};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};

use crate::arrays::{array, shared};
use crate::convert::to_python;
use crate::raise::{diagnostic_error, script_error};
use crate::state::{self, Live};

/// Names with numbers, as bytes.
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

/// Boundary as arrays: sides, single nodes, and for each number of nodes of a facet the facets with their places in the boundary.
fn boundary_arrays<'py>(py: Python<'py>, mesh: &Mesh, boundary: &Boundary) -> PyResult<Bound<'py, PyDict>> {
    let facets = &boundary.facets;
    let sides: Vec<u32> = facets.iter().flat_map(|facet| [facet.cell, facet.local.into()]).collect();
    let sizes: BTreeSet<usize> = facets.iter().map(|facet| mesh.facet_nodes(*facet).count()).collect();
    let arrays = PyList::empty(py);
    for size in sizes {
        let own = || facets.iter().zip(0..).filter(|(facet, _)| mesh.facet_nodes(**facet).count() == size);
        let nodes: Vec<u32> = own().flat_map(|(facet, _)| mesh.facet_nodes(*facet)).collect();
        let places: Vec<u32> = own().map(|(_, place)| place).collect();
        arrays.append((array(py, nodes, Some(places.len()))?, array(py, places, None)?))?;
    }
    let entry = PyDict::new(py);
    entry.set_item("sides", array(py, sides, Some(facets.len()))?)?;
    entry.set_item("facets", arrays)?;
    entry.set_item("nodes", array(py, boundary.nodes.clone(), None)?)?;
    Ok(entry)
}

/// `mesh(object)`: blocks of cells, each with its kind and node numbers; boundaries, parts.
pub fn mesh<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let (py, mesh) = (arguments.py(), mesh_of(arguments)?);
    let entries = PyDict::new(py);
    entries.set_item("dimension", mesh.dimension())?;
    let blocks = PyList::empty(py);
    for (place, block) in mesh.blocks.iter().enumerate() {
        blocks.append((block.kind.name(), shared(py, &mesh, |mesh| &mesh.blocks[place].connectivity[..], block.count())?))?;
    }
    entries.set_item("blocks", blocks)?;
    let boundaries = PyDict::new(py);
    for boundary in &mesh.boundaries {
        boundaries.set_item(&boundary.name, boundary_arrays(py, &mesh, boundary)?)?;
    }
    entries.set_item("boundaries", boundaries)?;
    let parts = PyDict::new(py);
    for (name, cells) in &mesh.parts {
        parts.set_item(name, array(py, cells.clone(), None)?)?;
    }
    entries.set_item("parts", parts)?;
    Ok(entries.into_any())
}

/// `make_mesh(points, blocks, parts, boundaries, facet_sets, node_sets)`: makes a mesh from arrays given as bytes. A block has a kind and
/// the node numbers of its cells. Boundaries consist of pairs of cells and sides, and of single nodes; a facet set has the corners of
/// facets with a number of corners per facet, a node set the nodes of a boundary.
pub fn make_mesh<'py>(arguments: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    type Given = (Vec<u8>, Named, Named, Vec<(String, Vec<u8>, Vec<u8>)>, Vec<(String, usize, Vec<u8>)>, Named);
    let py = arguments.py();
    let (points, blocks, parts, boundaries, facet_sets, node_sets): Given = arguments.extract()?;
    let coordinates: Vec<f64> = points.as_chunks().0.iter().map(|bytes| f64::from_ne_bytes(*bytes)).collect();
    let points = coordinates.as_chunks().0.to_vec();
    let parts = parts.into_iter().map(|(name, cells)| (name, numbers(&cells))).collect();
    let blocks = blocks.into_iter().map(|(element, cells)| block_of(py, &element, &cells)).collect::<PyResult<_>>()?;
    let mut mesh = Mesh { points, blocks, boundaries: Vec::new(), parts };
    for (name, sides, nodes) in boundaries {
        let sides = numbers(&sides);
        let facets = sides.as_chunks().0.iter().map(|[cell, local]| Facet { cell: *cell, local: *local as u8 }).collect();
        mesh.boundaries.push(Boundary { name, facets, nodes: numbers(&nodes) });
    }
    if mesh.check().is_ok() && !(facet_sets.is_empty() && node_sets.is_empty()) {
        let sides = sides_by_corners(&mesh);
        for (name, count, corners) in facet_sets {
            let facets = facets_of(&sides, &numbers(&corners), count).map_err(|missing| no_facet(py, &name, missing))?;
            match mesh.boundaries.iter_mut().find(|known| known.name == name) {
                Some(known) => known.facets.extend(facets),
                None => mesh.boundaries.push(Boundary::of_facets(&name, facets)),
            }
        }
        for (name, nodes) in node_sets {
            let boundary = boundary_of_nodes(&sides, name, numbers(&nodes).into_iter().collect());
            // A facet set extends the boundary of the same name.
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

/// A block of cells of a kind, whose node numbers are given as bytes.
fn block_of(py: Python, element: &str, cells: &[u8]) -> PyResult<Block> {
    let Some(&kind) = CellKind::ALL.iter().find(|kind| kind.name() == element) else {
        let cause = format!("the mesh types are {}", CellKind::ALL.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(", "));
        return Err(script_error(py, &format!("there is no mesh type `{element}`"), &cause, "convert the cells first"));
    };
    let connectivity = numbers(cells);
    match connectivity.len().is_multiple_of(kind.nodes()) {
        true => Ok(Block { kind, connectivity }),
        false => Err(PyValueError::new_err(format!("a {element} has {} nodes", kind.nodes()))),
    }
}

fn no_facet(py: Python, name: &str, nodes: Vec<u32>) -> PyErr {
    let title = format!("the set \"{name}\" has a facet that is no side of the hull");
    script_error(py, &title, &format!("no cell has the nodes {nodes:?} on the hull"), "leave the set out, or mend the mesh")
}

fn numbers(bytes: &[u8]) -> Vec<u32> {
    bytes.as_chunks().0.iter().map(|bytes| u32::from_ne_bytes(*bytes)).collect()
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

/// Facets with these corners; the error has the corners of a missing facet.
fn facets_of(sides: &HashMap<Vec<u32>, Facet>, corners: &[u32], count: usize) -> Result<Vec<Facet>, Vec<u32>> {
    let facet = |corners: &[u32]| {
        let mut key = corners.to_vec();
        key.sort_unstable();
        sides.get(&key).copied().ok_or(key)
    };
    corners.chunks_exact(count.max(1)).map(facet).collect()
}

/// Boundary of the facets with all corners in a set, and of the remaining nodes of the set.
fn boundary_of_nodes(sides: &HashMap<Vec<u32>, Facet>, name: String, nodes: BTreeSet<u32>) -> Boundary {
    let within = || sides.iter().filter(|(corners, _)| corners.iter().all(|corner| nodes.contains(corner)));
    let mut facets: Vec<Facet> = within().map(|(_, facet)| *facet).collect();
    facets.sort_unstable();
    let covered: BTreeSet<u32> = within().flat_map(|(corners, _)| corners).copied().collect();
    Boundary { name, facets, nodes: nodes.difference(&covered).copied().collect() }
}
