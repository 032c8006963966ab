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
    /// Adds the loop over a block of cells.
    fn add<C: ReferenceCell<D, A, Q>, const S: usize, const L: usize, const A: usize, const Q: usize>(
        &mut self,
        (first, block): (usize, &Block),
        physics: Physics<S, L>,
    ) -> Result<(), Inverted> {
        let &BodyCells { mesh, first_node, .. } = self.body;
        let cells = Cells::<D, S, L, A, Q>::new::<C>(mesh, block, physics, first_node, &mut self.touched);
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
                CellKind::Tri3 => chosen.add::<Tri3, 3, 4, 3, 1>(block, physics),
                CellKind::Quad4 => chosen.add::<Quad4, 3, 4, 4, 4>(block, physics),
                CellKind::Tri6 => chosen.add::<Tri6, 3, 4, 6, 3>(block, physics),
                CellKind::Quad8 => chosen.add::<Quad8, 3, 4, 8, 9>(block, physics),
                CellKind::Quad9 => chosen.add::<Quad9, 3, 4, 9, 9>(block, physics),
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
                CellKind::Tet4 => chosen.add::<Tet4, 6, 6, 4, 1>(block, physics),
                CellKind::Hex8 => chosen.add::<Hex8, 6, 6, 8, 8>(block, physics),
                CellKind::Tet10 => chosen.add::<Tet10, 6, 6, 10, 4>(block, physics),
                CellKind::Hex20 => chosen.add::<Hex20, 6, 6, 20, 27>(block, physics),
                CellKind::Hex27 => chosen.add::<Hex27, 6, 6, 27, 27>(block, physics),
                CellKind::Wedge6 => chosen.add::<Wedge6, 6, 6, 6, 6>(block, physics),
                CellKind::Wedge15 => chosen.add::<Wedge15, 6, 6, 15, 9>(block, physics),
                CellKind::Pyr5 => chosen.add::<Pyr5, 6, 6, 5, 8>(block, physics),
                CellKind::Pyr13 => chosen.add::<Pyr13, 6, 6, 13, 27>(block, physics),
                _ => unreachable!("a model has bodies of one dimension"),
            }?;
        }
        Ok(chosen.together())
    }
}
