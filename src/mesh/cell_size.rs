//! Size field of unstructured meshes.

use super::MeshError;

/// Approximate edge length of cells `[length]`.
pub enum CellSize<'a, E> {
    /// Uniform edge length `[length]`.
    Even(f64),
    /// Edge length as a function of the position.
    At(&'a mut dyn FnMut([f64; 2]) -> Result<f64, E>),
}

impl<E: From<MeshError>> CellSize<'_, E> {
    /// Cell size at a point.
    pub(super) fn at(&mut self, point: [f64; 2]) -> Result<f64, E> {
        let size = match self {
            CellSize::Even(size) => *size,
            CellSize::At(size) => size(point)?,
        };
        match size.is_finite() && size > 0.0 {
            true => Ok(size),
            false => Err(MeshError::NotPositive { what: "the cell size", value: size }.into()),
        }
    }
}
