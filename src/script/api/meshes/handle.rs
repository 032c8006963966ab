//! A mesh as an object of the language.
//!
//! Transforms return a new mesh and leave the original unchanged; only `boundary_where` changes its mesh.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

use rhai::EvalAltResult;

use crate::mesh::{Mesh, MeshError};
use crate::script::api::remedies::ScriptWords;
use crate::script::language::digits::brief;
use crate::script::language::prelude::*;
use crate::script::language::tables::table;

/// A mesh in a script.
#[derive(Clone)]
pub struct MeshHandle(Rc<RefCell<Arc<Mesh>>>);

impl MeshHandle {
    /// A handle of a mesh.
    pub fn new(mesh: Mesh) -> Self {
        Self::shared(Arc::new(mesh))
    }

    /// A handle of a shared mesh; [`Self::replace`] changes the handle alone.
    pub fn shared(mesh: Arc<Mesh>) -> Self {
        MeshHandle(Rc::new(RefCell::new(mesh)))
    }

    /// Returns the present mesh.
    pub fn mesh(&self) -> Arc<Mesh> {
        self.0.borrow().clone()
    }

    /// Counts, boundaries and parts as a table.
    pub fn table(&self) -> String {
        let mesh = self.mesh();
        let title = format!("mesh of {} and {} nodes", mesh.counted_cells(), mesh.points.len());
        let measure = if mesh.dimension() == 2 { "length" } else { "area" };
        let boundaries = mesh
            .boundaries
            .iter()
            .map(|boundary| vec![boundary.name.clone(), boundary.facets.len().to_string(), brief(mesh.boundary_measure(boundary))]);
        let parts = mesh.parts.iter().map(|(name, cells)| vec![name.clone(), cells.len().to_string()]);
        let (boundaries, parts): (Vec<_>, Vec<_>) = (boundaries.collect(), parts.collect());
        let tables = [(vec!["boundary", "facets", measure], boundaries), (vec!["part", "cells"], parts)];
        let tables = tables.iter().filter(|(_, rows)| !rows.is_empty()).map(|(header, rows)| table(header, rows));
        std::iter::once(title).chain(tables).collect::<Vec<_>>().join("\n")
    }

    /// Replaces the mesh for all holders of the handle.
    pub fn replace(&self, mesh: Mesh) {
        *self.0.borrow_mut() = Arc::new(mesh);
    }
}

impl Handle for MeshHandle {
    const NAME: &'static str = "Mesh";
    const MAKER: &'static str = "make one with `rectangle`, `ring`, `block` or `read_mesh`";

    fn instead_of_property(name: &str) -> Option<String> {
        Some(format!("write `.boundary(\"{name}\")` for a boundary of that name"))
    }

    fn describe(&self) -> String {
        describe_mesh(&self.mesh())
    }
}

/// Describes a mesh in one line: element type, counts, boundaries and parts.
pub fn describe_mesh(mesh: &Mesh) -> String {
    let boundaries: Vec<String> =
        mesh.boundaries.iter().map(|boundary| format!("\"{}\" {}", boundary.name, boundary.facets.len())).collect();
    let mut text = format!("mesh of {} and {} nodes", mesh.counted_cells(), mesh.points.len());
    if !boundaries.is_empty() {
        text = format!("{text}; boundaries (facets): {}", boundaries.join(", "));
    }
    if !mesh.parts.is_empty() {
        let parts: Vec<String> = mesh.parts.iter().map(|(name, cells)| format!("\"{name}\" {}", cells.len())).collect();
        text = format!("{text}; parts (cells): {}", parts.join(", "));
    }
    text
}

/// The failure of a mesh operation.
pub fn mesh_failure(call: &Call, error: &MeshError) -> Failure {
    call.fail(error.to_string()).code(error.code()).hint(error.remedy())
}

/// Converts a generated mesh to a value of a script.
pub fn mesh_value(call: &Call, made: Result<Mesh, MeshError>) -> Result<MeshHandle, Box<EvalAltResult>> {
    made.map(MeshHandle::new).map_err(|error| mesh_failure(call, &error).into())
}

/// Makes a mesh on a thread that is watched for interrupts; after an interrupt, the work is abandoned.
pub fn made(call: &Call, make: impl FnOnce() -> Result<Mesh, MeshError> + Send + 'static) -> Result<MeshHandle, Box<EvalAltResult>> {
    mesh_value(call, call.host.watched(make)?)
}

/// Number of cells below which a mesh is made on the calling thread, because starting a thread takes longer than the mesh.
const FEW_CELLS: f64 = 5e3;

/// Makes a mesh with `cells` cells along its directions: a small one on the calling thread, others as [`made`].
pub fn made_of(
    call: &Call,
    cells: &[usize],
    make: impl FnOnce() -> Result<Mesh, MeshError> + Send + 'static,
) -> Result<MeshHandle, Box<EvalAltResult>> {
    let count: f64 = cells.iter().map(|&count| count as f64).product();
    if count <= FEW_CELLS { mesh_value(call, make()) } else { made(call, make) }
}

/// Coordinates of a point among the options; the origin by default.
pub fn point_or_origin<const D: usize>(options: &Options, name: &str) -> Result<[f64; D], Failure> {
    Ok(options.argument(name).given(Argument::tuple)?.unwrap_or([0.0; D]))
}
