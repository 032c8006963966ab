//! Selection of the element loop: the one place that combines cell kinds, formulations and laws.

use super::cells::Cells;
use super::element_loop::{ElementLoop, Inverted};
use super::physics::{BodyCells, Physics};
use crate::elements::{CellKind, Hex8, Hex20, Hex27, Quad4, Quad8, Quad9, ReferenceCell, Tet4, Tet10, Tri3, Tri6};
use crate::mesh::Mesh;

/// Space dimension with implemented cells.
pub struct Space<const D: usize>;

/// Selects the element loop of a mesh by its cell kind.
pub trait Elements<const D: usize> {
    /// The loop over the cells of a body.
    ///
    /// # Errors
    /// The first cell that is inside out in the mesh.
    fn elements(body: &BodyCells) -> Result<Box<dyn ElementLoop<D>>, Inverted>;
}

/// Element loop over cells of one kind.
fn cells<C: ReferenceCell<D, A, Q>, const D: usize, const S: usize, const L: usize, const A: usize, const Q: usize>(
    mesh: &Mesh,
    physics: Physics<S, L>,
    first_node: usize,
) -> Result<Box<dyn ElementLoop<D>>, Inverted> {
    Ok(Box::new(Cells::<D, S, L, A, Q>::new::<C>(mesh, physics, first_node)?))
}

impl Elements<2> for Space<2> {
    fn elements(body: &BodyCells) -> Result<Box<dyn ElementLoop<2>>, Inverted> {
        let (&BodyCells { mesh, first_node, .. }, physics) = (body, Physics::of_plane(body));
        match mesh.kind {
            CellKind::Tri3 => cells::<Tri3, 2, 3, 4, 3, 1>(mesh, physics, first_node),
            CellKind::Quad4 => cells::<Quad4, 2, 3, 4, 4, 4>(mesh, physics, first_node),
            CellKind::Tri6 => cells::<Tri6, 2, 3, 4, 6, 3>(mesh, physics, first_node),
            CellKind::Quad8 => cells::<Quad8, 2, 3, 4, 8, 9>(mesh, physics, first_node),
            CellKind::Quad9 => cells::<Quad9, 2, 3, 4, 9, 9>(mesh, physics, first_node),
            _ => unreachable!("a model has bodies of one dimension"),
        }
    }
}

impl Elements<3> for Space<3> {
    fn elements(body: &BodyCells) -> Result<Box<dyn ElementLoop<3>>, Inverted> {
        let (&BodyCells { mesh, first_node, .. }, physics) = (body, Physics::of_space(body));
        match mesh.kind {
            CellKind::Tet4 => cells::<Tet4, 3, 6, 6, 4, 1>(mesh, physics, first_node),
            CellKind::Hex8 => cells::<Hex8, 3, 6, 6, 8, 8>(mesh, physics, first_node),
            CellKind::Tet10 => cells::<Tet10, 3, 6, 6, 10, 4>(mesh, physics, first_node),
            CellKind::Hex20 => cells::<Hex20, 3, 6, 6, 20, 27>(mesh, physics, first_node),
            CellKind::Hex27 => cells::<Hex27, 3, 6, 6, 27, 27>(mesh, physics, first_node),
            _ => unreachable!("a model has bodies of one dimension"),
        }
    }
}
