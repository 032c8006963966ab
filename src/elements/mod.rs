//! Floor 1: reference cells. A cell kind knows its shape functions, quadrature and facets; nothing of meshes or materials.
//!
//! Node order of every kind is the one that Gmsh and VTK share. Facets are listed so that the cell lies to the left (2D) or the
//! normal points outward (3D) when a cell is positively oriented. A new kind is one file with its row, and a line in each list below.

mod hex8;
mod quad4;
mod reference_cell;

pub use hex8::Hex8;
pub use quad4::Quad4;
pub use reference_cell::{CellRow, ReferenceCell};

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

    /// The kind's row of the catalogue.
    pub fn row(self) -> &'static CellRow {
        match self {
            CellKind::Quad4 => &quad4::ROW,
            CellKind::Hex8 => &hex8::ROW,
        }
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

    /// Local node numbers of each facet (codimension one), outward oriented.
    pub fn facets(self) -> &'static [&'static [usize]] {
        self.row().facets
    }
}
