//! How large the cells of an unstructured mesh are wanted.

use super::MeshError;

/// About how long the edges of cells are `[length]`.
pub enum CellSize<'a, E> {
    /// The same everywhere.
    Even(f64),
    /// By place.
    At(&'a mut dyn FnMut([f64; 2]) -> Result<f64, E>),
}

impl<E: From<MeshError>> CellSize<'_, E> {
    /// The length wanted at a point.
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
