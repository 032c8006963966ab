//! What a cell kind gives: functions of the reference coordinates for the element loop, and a row of the catalogue for everyone else.
//!
//! The element loop knows the numbers of dimensions, nodes and points when it is compiled ([`ReferenceCell`]). Who does not need the speed
//! asks the row, where points and gradients have three components and those beyond the dimension are zero.

/// A reference cell in `D` dimensions with `A` nodes and `Q` quadrature points.
pub trait ReferenceCell<const D: usize, const A: usize, const Q: usize>: Send + Sync + 'static {
    /// Quadrature points in reference coordinates and their weights.
    fn quadrature() -> [([f64; D], f64); Q];
    /// Values of the shape functions at a reference point.
    fn shape(xi: [f64; D]) -> [f64; A];
    /// Gradients of the shape functions with respect to the reference coordinates, `[node][direction]`.
    fn gradients(xi: [f64; D]) -> [[f64; D]; A];
}

/// A row of the catalogue of cell kinds.
#[derive(Debug)]
pub struct CellRow {
    /// Name as written in a script.
    pub name: &'static str,
    /// One sentence for the reference.
    pub summary: &'static str,
    /// Space dimension.
    pub dimension: usize,
    /// Number of nodes of a cell.
    pub nodes: usize,
    /// Local node numbers of each facet (codimension one), outward oriented.
    pub facets: &'static [&'static [usize]],
    /// Largest power of a coordinate that the quadrature integrates exactly.
    pub exact_power: usize,
    /// Number of the kind in VTK's files.
    pub vtk_type: u8,
    /// Quadrature points and their weights.
    pub quadrature: fn() -> Vec<([f64; 3], f64)>,
    /// Values of the shape functions at a reference point, one for each node.
    pub shape: fn([f64; 3]) -> Vec<f64>,
    /// Gradients of the shape functions at a reference point, one for each node.
    pub gradients: fn([f64; 3]) -> Vec<[f64; 3]>,
}

/// Three components of a vector in `D` dimensions.
fn padded<const D: usize>(vector: [f64; D]) -> [f64; 3] {
    std::array::from_fn(|i| if i < D { vector[i] } else { 0.0 })
}

/// The first `D` components of a vector.
fn cut<const D: usize>(vector: [f64; 3]) -> [f64; D] {
    std::array::from_fn(|i| vector[i])
}

/// [`ReferenceCell::quadrature`] for a row.
pub(super) fn quadrature<C: ReferenceCell<D, A, Q>, const D: usize, const A: usize, const Q: usize>() -> Vec<([f64; 3], f64)> {
    C::quadrature().map(|(xi, weight)| (padded(xi), weight)).to_vec()
}

/// [`ReferenceCell::shape`] for a row.
pub(super) fn shape<C: ReferenceCell<D, A, Q>, const D: usize, const A: usize, const Q: usize>(xi: [f64; 3]) -> Vec<f64> {
    C::shape(cut(xi)).to_vec()
}

/// [`ReferenceCell::gradients`] for a row.
pub(super) fn gradients<C: ReferenceCell<D, A, Q>, const D: usize, const A: usize, const Q: usize>(xi: [f64; 3]) -> Vec<[f64; 3]> {
    C::gradients(cut(xi)).map(padded).to_vec()
}
