//! Floor 1 of `ARCHITECTURE.md`: reference cells. A cell kind has shape functions, quadrature and facets, independent of meshes and
//! materials.
//!
//! The node order of every kind is VTK's; that of `wedge6` is the order of VTK 9.6 and later (older versions list both triangles in
//! reverse). Facets are listed so that the cell lies to the left (2D) or the normal points outward (3D) when a cell is positively oriented.
//! A new kind is one file with its row, and a line in each list below.

mod edge;
mod face;
mod hex20;
mod hex27;
mod hex8;
mod mass_rule;
mod pyr13;
mod pyr5;
mod quad4;
mod quad8;
mod quad9;
mod reference_cell;
mod tet10;
mod tet4;
mod tri3;
mod tri6;
mod wedge;
mod wedge15;
mod wedge6;

pub use edge::{edge_points, edge_shapes};
pub use face::{FacePoint, MOST_FACE_NODES, face_points};
pub use hex8::Hex8;
pub use hex20::Hex20;
pub use hex27::Hex27;
pub use mass_rule::GAUSS;
pub use pyr5::Pyr5;
pub use pyr13::Pyr13;
pub use quad4::Quad4;
pub use quad8::Quad8;
pub use quad9::Quad9;
pub use reference_cell::{CellRow, CellShape, ReferenceCell};
pub use tet4::Tet4;
pub use tet10::Tet10;
pub use tri3::Tri3;
pub use tri6::Tri6;
pub use wedge6::Wedge6;
pub use wedge15::Wedge15;

/// The kinds of cells that bodies are made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum CellKind {
    /// Linear triangle, 3 nodes counter-clockwise, 1 point.
    Tri3,
    /// Bilinear quadrilateral, 4 nodes counter-clockwise, 2 x 2 Gauss points.
    Quad4,
    /// Quadratic triangle, 6 nodes, 3 points.
    Tri6,
    /// Quadratic serendipity quadrilateral, 8 nodes, 3 x 3 Gauss points.
    Quad8,
    /// Biquadratic quadrilateral, 9 nodes, 3 x 3 Gauss points.
    Quad9,
    /// Linear tetrahedron, 4 nodes, 1 point.
    Tet4,
    /// Trilinear hexahedron, 8 nodes, 2 x 2 x 2 Gauss points.
    Hex8,
    /// Quadratic tetrahedron, 10 nodes, 4 points.
    Tet10,
    /// Quadratic serendipity hexahedron, 20 nodes, 3 x 3 x 3 Gauss points.
    Hex20,
    /// Triquadratic hexahedron, 27 nodes, 3 x 3 x 3 Gauss points.
    Hex27,
    /// Linear wedge, 6 nodes, 3 x 2 points.
    Wedge6,
    /// Quadratic wedge, 15 nodes, 3 x 3 points.
    Wedge15,
    /// Linear pyramid, 5 nodes, 2 x 2 x 2 Gauss points.
    Pyr5,
    /// Quadratic pyramid, 13 nodes, 3 x 3 x 3 Gauss points.
    Pyr13,
}

impl CellKind {
    /// All kinds, in the order of the reference.
    pub const ALL: &'static [CellKind] = &[
        CellKind::Tri3,
        CellKind::Quad4,
        CellKind::Tri6,
        CellKind::Quad8,
        CellKind::Quad9,
        CellKind::Tet4,
        CellKind::Hex8,
        CellKind::Tet10,
        CellKind::Hex20,
        CellKind::Hex27,
        CellKind::Wedge6,
        CellKind::Wedge15,
        CellKind::Pyr5,
        CellKind::Pyr13,
    ];

    /// The kind's row of the catalogue.
    pub fn row(self) -> &'static CellRow {
        match self {
            CellKind::Tri3 => &tri3::ROW,
            CellKind::Quad4 => &quad4::ROW,
            CellKind::Tri6 => &tri6::ROW,
            CellKind::Quad8 => &quad8::ROW,
            CellKind::Quad9 => &quad9::ROW,
            CellKind::Tet4 => &tet4::ROW,
            CellKind::Hex8 => &hex8::ROW,
            CellKind::Tet10 => &tet10::ROW,
            CellKind::Hex20 => &hex20::ROW,
            CellKind::Hex27 => &hex27::ROW,
            CellKind::Wedge6 => &wedge6::ROW,
            CellKind::Wedge15 => &wedge15::ROW,
            CellKind::Pyr5 => &pyr5::ROW,
            CellKind::Pyr13 => &pyr13::ROW,
        }
    }

    /// True if the strain is constant in a cell: triangles and tetrahedra of first order.
    pub fn has_one_point(self) -> bool {
        matches!(self, CellKind::Tri3 | CellKind::Tet4)
    }

    /// True if all nodes are corners.
    pub fn is_first_order(self) -> bool {
        self.row().nodes == self.row().cell_shape.corners()
    }

    /// Name as written in a script.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// One sentence for the reference.
    pub fn summary(self) -> &'static str {
        self.row().summary
    }

    /// Space dimension.
    pub fn dimension(self) -> usize {
        self.row().dimension
    }

    /// Number of nodes of a cell.
    pub fn nodes(self) -> usize {
        self.row().nodes
    }

    /// Shape of the cell, which determines its corners.
    pub fn shape(self) -> CellShape {
        self.row().cell_shape
    }

    /// True if cells have mid-side nodes.
    pub fn is_quadratic(self) -> bool {
        self.nodes() > self.shape().corners()
    }

    /// Plane cell kind of a facet in space with a given number of nodes.
    pub fn of_face(nodes: usize) -> CellKind {
        let is_it = |kind: &&CellKind| kind.dimension() == 2 && kind.nodes() == nodes;
        CellKind::ALL.iter().find(is_it).copied().unwrap_or(CellKind::Quad4)
    }

    /// Local node numbers of each facet (codimension one), outward oriented: corners, middles of the edges, center.
    pub fn facets(self) -> &'static [&'static [usize]] {
        self.row().facets
    }
}
