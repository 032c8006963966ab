//! Floor 1: reference cells. A cell kind knows its shape functions, quadrature and facets; nothing of meshes or materials.
//!
//! Node order of every kind is the one that Gmsh and VTK share. Facets are listed so that the cell lies to the left (2D) or the
//! normal points outward (3D) when a cell is positively oriented.

mod hex8;
mod quad4;

pub use hex8::Hex8;
pub use quad4::Quad4;

/// A reference cell in `D` dimensions with `A` nodes and `Q` quadrature points.
pub trait ReferenceCell<const D: usize, const A: usize, const Q: usize>: Send + Sync + 'static {
    /// The kind this type implements.
    const KIND: CellKind;
    /// Quadrature points in reference coordinates and their weights.
    fn quadrature() -> [([f64; D], f64); Q];
    /// Values of the shape functions at a reference point.
    fn shape(xi: [f64; D]) -> [f64; A];
    /// Gradients of the shape functions with respect to the reference coordinates, `[node][direction]`.
    fn gradients(xi: [f64; D]) -> [[f64; D]; A];
}

/// The kinds of cells that bodies are made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum CellKind {
    /// Bilinear quadrilateral, 4 nodes counter-clockwise, 2 x 2 Gauss points.
    Quad4,
    /// Trilinear hexahedron, 8 nodes, 2 x 2 x 2 Gauss points.
    Hex8,
}

impl CellKind {
    /// All kinds, in the order of the reference.
    pub const ALL: &'static [CellKind] = &[CellKind::Quad4, CellKind::Hex8];

    /// Name as written in a script.
    pub fn name(self) -> &'static str {
        match self {
            CellKind::Quad4 => "quad4",
            CellKind::Hex8 => "hex8",
        }
    }

    /// One sentence for the reference.
    pub fn summary(self) -> &'static str {
        match self {
            CellKind::Quad4 => "bilinear quadrilateral with 4 nodes and 2 x 2 Gauss points, plane strain",
            CellKind::Hex8 => "trilinear hexahedron with 8 nodes and 2 x 2 x 2 Gauss points",
        }
    }

    /// Space dimension.
    pub fn dimension(self) -> usize {
        match self {
            CellKind::Quad4 => 2,
            CellKind::Hex8 => 3,
        }
    }

    /// Number of nodes of a cell.
    pub fn nodes(self) -> usize {
        match self {
            CellKind::Quad4 => 4,
            CellKind::Hex8 => 8,
        }
    }

    /// Local node numbers of each facet (codimension one), outward oriented.
    pub fn facets(self) -> &'static [&'static [usize]] {
        match self {
            CellKind::Quad4 => &quad4::FACETS,
            CellKind::Hex8 => &hex8::FACETS,
        }
    }
}
