//! Interface of a cell kind: functions of the reference coordinates for the element loop, and a catalogue row for all other callers.
//!
//! For the element loop the numbers of dimensions, nodes and points are constants of compilation ([`ReferenceCell`]). In the catalogue row
//! points and gradients have three components; those beyond the dimension are zero.

/// A reference cell in `D` dimensions with `A` nodes and `Q` quadrature points.
pub trait ReferenceCell<const D: usize, const A: usize, const Q: usize>: Send + Sync + 'static {
    /// Quadrature points in reference coordinates and their weights.
    fn quadrature() -> [([f64; D], f64); Q];
    /// Values of the shape functions at a reference point.
    fn shape(xi: [f64; D]) -> [f64; A];
    /// Gradients of the shape functions with respect to the reference coordinates, `[node][direction]`.
    fn gradients(xi: [f64; D]) -> [[f64; D]; A];
    /// Products `N_a N_b` at each quadrature point, from which the consistent mass is summed. Cell kinds whose mass needs more points than
    /// their stiffness return products whose sum is the exact mass for a constant Jacobian.
    fn products() -> [[[f64; A]; A]; Q] {
        let product = |shape: [f64; A]| shape.map(|a| shape.map(|b| a * b));
        Self::quadrature().map(|(xi, _)| product(Self::shape(xi)))
    }
    /// Factors `[point][node]` of the values at the points in the extrapolation to the nodes, by the polynomial through the points; the
    /// factors of each node sum to 1.
    fn extrapolation() -> [[f64; A]; Q];
}

/// Shape of a cell, which determines its corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellShape {
    /// Three corners.
    Triangle,
    /// Four corners in a plane.
    Quadrilateral,
    /// Four corners in space.
    Tetrahedron,
    /// Eight corners.
    Hexahedron,
    /// Six corners: a prism over a triangle.
    Wedge,
    /// Five corners: four of the base, then the apex.
    Pyramid,
}

impl CellShape {
    /// True if reference coordinates are nonnegative with a sum of at most 1, so that polynomial spaces are of total degree.
    pub fn is_simplex(self) -> bool {
        matches!(self, CellShape::Triangle | CellShape::Tetrahedron)
    }

    /// True if some facets are triangles; of plane cells, true for triangles.
    pub fn has_triangles(self) -> bool {
        !matches!(self, CellShape::Quadrilateral | CellShape::Hexahedron)
    }

    /// Position on the reference cell of a point in reference coordinates: equal to them except in a pyramid, whose reference coordinates
    /// are those of a cube with one face collapsed.
    pub fn place(self, [xi, eta, zeta]: [f64; 3]) -> [f64; 3] {
        match self {
            CellShape::Pyramid => [0.5 * xi * (1.0 - zeta), 0.5 * eta * (1.0 - zeta), zeta],
            _ => [xi, eta, zeta],
        }
    }

    /// Number of corners, which come first among the nodes.
    pub fn corners(self) -> usize {
        match self {
            CellShape::Triangle => 3,
            CellShape::Quadrilateral | CellShape::Tetrahedron => 4,
            CellShape::Hexahedron => 8,
            CellShape::Wedge => 6,
            CellShape::Pyramid => 5,
        }
    }

    /// Pairs of corners that an edge joins, in the order of the mid-side nodes of second-order cells.
    pub fn edges(self) -> &'static [[usize; 2]] {
        match self {
            CellShape::Triangle => &[[0, 1], [1, 2], [2, 0]],
            CellShape::Quadrilateral => &[[0, 1], [1, 2], [2, 3], [3, 0]],
            CellShape::Tetrahedron => &[[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]],
            CellShape::Hexahedron => &[[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]],
            CellShape::Wedge => &[[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3], [0, 3], [1, 4], [2, 5]],
            CellShape::Pyramid => &[[0, 1], [1, 2], [2, 3], [3, 0], [0, 4], [1, 4], [2, 4], [3, 4]],
        }
    }
}

/// A row of the catalogue of cell kinds.
#[derive(Debug)]
pub struct CellRow {
    /// Name as written in a script.
    pub name: &'static str,
    /// One sentence for the reference.
    pub summary: &'static str,
    /// Shape of the cell.
    pub cell_shape: CellShape,
    /// Space dimension.
    pub dimension: usize,
    /// Number of nodes of a cell.
    pub nodes: usize,
    /// Reference coordinates of the nodes; those beyond the dimension are zero.
    pub node_places: &'static [[f64; 3]],
    /// Local node numbers of each facet (codimension one), outward oriented, in the order of a cell with these nodes: corners, middles of
    /// the edges from the first corner on, center.
    pub facets: &'static [&'static [usize]],
    /// Largest power of each coordinate that the quadrature integrates exactly; for simplices and wedges the largest total degree.
    pub exact_power: usize,
    /// Number of the kind in VTK's files, which have the nodes in the same order.
    pub vtk_type: u8,
    /// Number and name of the kind in XDMF.
    pub xdmf: (i64, &'static str),
    /// Number of the kind in Gmsh's files.
    pub gmsh_type: u64,
    /// Place of each node among those of an element in Gmsh files; empty if the order is equal.
    pub gmsh_order: &'static [u8],
    /// Place of each node among those of an element in Abaqus files; empty if the order is equal.
    pub abaqus_order: &'static [u8],
    /// Quadrature points and their weights.
    pub quadrature: fn() -> Vec<([f64; 3], f64)>,
    /// Values of the shape functions at a reference point, one for each node.
    pub shape: fn([f64; 3]) -> Vec<f64>,
    /// Gradients of the shape functions at a reference point, one for each node.
    pub gradients: fn([f64; 3]) -> Vec<[f64; 3]>,
}

/// [`ReferenceCell::extrapolation`] for `n` Gauss points along each axis. The factor of the point `xi` with weight `w` at the node `x` is
/// `w` times the product over the axes of `sum_k (2k + 1)/2 P_k(x) P_k(xi)`, `k` from 0 to `n - 1`, with Legendre's polynomials `P_k`.
pub(super) fn extrapolation_of_products<const D: usize, const A: usize, const Q: usize>(
    places: &[[f64; 3]; A],
    points: [([f64; D], f64); Q],
) -> [[f64; A]; Q] {
    let legendre = |x: f64| [1.0, x, 0.5 * (3.0 * x * x - 1.0)];
    let along = (1..=legendre(0.0).len()).find(|n: &usize| n.pow(D as u32) == Q).unwrap_or(1);
    points.map(|(xi, weight)| {
        std::array::from_fn(|a| {
            let factor = |i: usize| {
                let (at_node, at_point) = (legendre(places[a][i]), legendre(xi[i]));
                (0..along).map(|k| (k as f64 + 0.5) * at_node[k] * at_point[k]).sum::<f64>()
            };
            weight * (0..D).map(factor).product::<f64>()
        })
    })
}

/// Three components of a vector in `D` dimensions.
fn padded<const D: usize>(vector: [f64; D]) -> [f64; 3] {
    std::array::from_fn(|i| if i < D { vector[i] } else { 0.0 })
}

/// The first `D` components of a vector.
fn cut<const D: usize>(vector: [f64; 3]) -> [f64; D] {
    std::array::from_fn(|i| vector[i])
}

/// [`ReferenceCell::quadrature`] with three components, for the catalogue row.
pub(super) fn quadrature<C: ReferenceCell<D, A, Q>, const D: usize, const A: usize, const Q: usize>() -> Vec<([f64; 3], f64)> {
    C::quadrature().map(|(xi, weight)| (padded(xi), weight)).to_vec()
}

/// [`ReferenceCell::shape`] of a point with three components, for the catalogue row.
pub(super) fn shape<C: ReferenceCell<D, A, Q>, const D: usize, const A: usize, const Q: usize>(xi: [f64; 3]) -> Vec<f64> {
    C::shape(cut(xi)).to_vec()
}

/// [`ReferenceCell::gradients`] with three components, for the catalogue row.
pub(super) fn gradients<C: ReferenceCell<D, A, Q>, const D: usize, const A: usize, const Q: usize>(xi: [f64; 3]) -> Vec<[f64; 3]> {
    C::gradients(cut(xi)).map(padded).to_vec()
}
