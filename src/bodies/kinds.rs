//! Selection of the element loop: the one place that combines cell kinds, formulations and laws.

use std::ops::Range;

use super::blocks::Blocks;
use super::cells::Cells;
use super::element_loop::{ElementLoop, Inverted};
use super::physics::{BodyCells, Physics};
use crate::elements::{
    CellKind, Hex8, Hex20, Hex27, Pyr5, Pyr13, Quad4, Quad8, Quad9, ReferenceCell, Tet4, Tet10, Tri3, Tri6, Wedge6, Wedge15,
};
use crate::mesh::Block;

/// Marker type for a space dimension `D` for which cells are implemented.
pub struct Space<const D: usize>;

/// Selects the element loop of a mesh by its cell kind.
pub trait Elements<const D: usize> {
    /// Element loop over the cells of a body.
    ///
    /// # Errors
    /// The first inverted cell of the mesh.
    fn elements(body: &BodyCells) -> Result<Box<dyn ElementLoop<D>>, Inverted>;
}

/// Element loops of the blocks of a body, under construction.
struct Chosen<'a, const D: usize> {
    body: &'a BodyCells<'a>,
    loops: Vec<Box<dyn ElementLoop<D>>>,
    /// Node number ranges of the blocks processed so far; sums over these nodes already have contributions, to which later blocks add.
    touched: Vec<Range<usize>>,
}

impl<const D: usize> Chosen<'_, D> {
    /// Adds the loop over a block of cells with `N` nodes and `P` points, which is compiled for at most `A` nodes and `Q` points.
    fn add<C: ReferenceCell<D, N, P>, const A: usize, const Q: usize, const S: usize, const L: usize, const N: usize, const P: usize>(
        &mut self,
        (first, block): (usize, &Block),
        physics: Physics<S, L>,
    ) -> Result<(), Inverted> {
        let &BodyCells { mesh, first_node, .. } = self.body;
        let cells = Cells::<D, S, L, A, Q>::new::<C, N, P>(mesh, block, physics, first_node, &mut self.touched);
        let cells = cells.map_err(|inverted| Inverted { cell: first + inverted.cell, ..inverted })?;
        self.loops.push(Box::new(cells));
        Ok(())
    }

    /// Element loop over all blocks.
    fn together(mut self) -> Box<dyn ElementLoop<D>> {
        match self.loops.pop() {
            Some(only) if self.loops.is_empty() => only,
            last => Box::new(Blocks::new(self.loops.into_iter().chain(last).collect())),
        }
    }
}

impl Elements<2> for Space<2> {
    fn elements(body: &BodyCells) -> Result<Box<dyn ElementLoop<2>>, Inverted> {
        let mut chosen = Chosen { body, loops: Vec::new(), touched: Vec::new() };
        for block in body.mesh.numbered_blocks() {
            let physics = Physics::of_plane(body);
            match block.1.kind {
                CellKind::Tri3 => chosen.add::<Tri3, 3, 1, _, _, _, _>(block, physics),
                CellKind::Quad4 => chosen.add::<Quad4, 4, 4, _, _, _, _>(block, physics),
                CellKind::Tri6 => chosen.add::<Tri6, 9, 9, _, _, _, _>(block, physics),
                CellKind::Quad8 => chosen.add::<Quad8, 9, 9, _, _, _, _>(block, physics),
                CellKind::Quad9 => chosen.add::<Quad9, 9, 9, _, _, _, _>(block, physics),
                _ => unreachable!("a model has bodies of one dimension"),
            }?;
        }
        Ok(chosen.together())
    }
}

impl Elements<3> for Space<3> {
    fn elements(body: &BodyCells) -> Result<Box<dyn ElementLoop<3>>, Inverted> {
        let mut chosen = Chosen { body, loops: Vec::new(), touched: Vec::new() };
        for block in body.mesh.numbered_blocks() {
            let physics = Physics::of_space(body);
            match block.1.kind {
                CellKind::Tet4 => chosen.add::<Tet4, 4, 1, _, _, _, _>(block, physics),
                CellKind::Hex8 => chosen.add::<Hex8, 8, 8, _, _, _, _>(block, physics),
                CellKind::Tet10 => chosen.add::<Tet10, 10, 4, _, _, _, _>(block, physics),
                CellKind::Hex20 => chosen.add::<Hex20, 27, 27, _, _, _, _>(block, physics),
                CellKind::Hex27 => chosen.add::<Hex27, 27, 27, _, _, _, _>(block, physics),
                CellKind::Wedge6 => chosen.add::<Wedge6, 8, 8, _, _, _, _>(block, physics),
                CellKind::Wedge15 => chosen.add::<Wedge15, 27, 27, _, _, _, _>(block, physics),
                CellKind::Pyr5 => chosen.add::<Pyr5, 8, 8, _, _, _, _>(block, physics),
                CellKind::Pyr13 => chosen.add::<Pyr13, 27, 27, _, _, _, _>(block, physics),
                _ => unreachable!("a model has bodies of one dimension"),
            }?;
        }
        Ok(chosen.together())
    }
}
