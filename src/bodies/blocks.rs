//! Element loop of a mixed mesh: one loop for each block of cells of a kind, evaluated in sequence.
//!
//! Numbers of cells and history variables follow each other block by block, as the cells of the mesh do.

use super::element_loop::{Advance, BodyState, ElementLoop, FastestCell, ForcePerMass, Inverted, PointStress, Step};
use crate::integrators::Lumping;
use crate::linear::{NodeMatrix, Pattern};
use crate::math::workers::Workers;

/// Element loop over cells of several kinds.
pub(super) struct Blocks<const D: usize> {
    /// Element loop of each block, with the number of its first cell.
    blocks: Vec<(usize, Box<dyn ElementLoop<D>>)>,
    cliques: Vec<Vec<u32>>,
}

impl<const D: usize> Blocks<D> {
    /// Combines the element loops of the blocks of a mesh.
    pub(super) fn new(loops: Vec<Box<dyn ElementLoop<D>>>) -> Self {
        let (mut blocks, mut cliques) = (Vec::with_capacity(loops.len()), Vec::new());
        for block in loops {
            let first = cliques.len();
            cliques.extend_from_slice(block.cliques());
            blocks.push((first, block));
        }
        Blocks { blocks, cliques }
    }

    fn loops(&self) -> impl Iterator<Item = &dyn ElementLoop<D>> {
        self.blocks.iter().map(|(_, block)| &**block)
    }

    /// Loops with their parts of the history variables; all parts are empty if `history` is empty.
    fn with_history<'a>(&'a self, history: &'a [f64]) -> impl Iterator<Item = (&'a dyn ElementLoop<D>, &'a [f64])> {
        self.loops().scan(0, move |start, block| {
            let own = *start..*start + block.history();
            *start = own.end;
            Some((block, if history.is_empty() { history } else { &history[own] }))
        })
    }
}

impl<const D: usize> ElementLoop<D> for Blocks<D> {
    fn cliques(&self) -> &[Vec<u32>] {
        &self.cliques
    }

    fn place(&mut self, pattern: &Pattern) {
        self.blocks.iter_mut().for_each(|(_, block)| block.place(pattern));
    }

    fn grow(&mut self, factor: &dyn Fn(u32) -> f64) -> f64 {
        self.blocks.iter_mut().map(|(_, block)| block.grow(factor)).fold(f64::INFINITY, f64::min)
    }

    fn add_mass(&self, mass: &mut NodeMatrix) {
        self.loops().for_each(|block| block.add_mass(mass));
    }

    fn add_lumped_mass(&self, lumping: Lumping, mass: &mut [f64]) -> bool {
        let mut are_positive = true;
        self.loops().for_each(|block| are_positive &= block.add_lumped_mass(lumping, mass));
        are_positive
    }

    fn fastest_cell(&self, lumping: Lumping, u: &[f64]) -> FastestCell {
        let of_blocks = self.blocks.iter().map(|(first, block)| {
            let fastest = block.fastest_cell(lumping, u);
            FastestCell { cell: first + fastest.cell, ..fastest }
        });
        let start = FastestCell { cell: 0, frequency_squared: 0.0 };
        of_blocks.fold(start, |so_far, own| if own.frequency_squared > so_far.frequency_squared { own } else { so_far })
    }

    fn assemble(&self, step: &Step, force: &mut [f64], mut values: Option<&mut [f64]>, workers: &Workers) -> Result<(), Inverted> {
        for ((first, _), (block, history)) in self.blocks.iter().zip(self.with_history(step.history)) {
            let outcome = block.assemble(&Step { history, ..*step }, force, values.as_deref_mut(), workers);
            outcome.map_err(|inverted| Inverted { cell: first + inverted.cell, ..inverted })?;
        }
        Ok(())
    }

    fn add_step(&self, step: &Step, force: &mut [f64], mut values: Option<&mut [f64]>) {
        for (block, history) in self.with_history(step.history) {
            block.add_step(&Step { history, ..*step }, force, values.as_deref_mut());
        }
    }

    fn add_material_stiffness(&self, u: &[f64], factor: f64, values: &mut [f64]) {
        self.loops().for_each(|block| block.add_material_stiffness(u, factor, values));
    }

    fn history(&self) -> usize {
        self.loops().map(ElementLoop::history).sum()
    }

    fn relaxed(&self, at: BodyState) -> Vec<f64> {
        self.with_history(at.history).flat_map(|(block, history)| block.relaxed(BodyState { history, ..at })).collect()
    }

    fn flows(&self) -> bool {
        self.loops().any(ElementLoop::flows)
    }

    fn advance(&self, step: &Step) -> Advance {
        let mut all = Advance { history: Vec::with_capacity(step.history.len()), plastic: 0.0, viscous: 0.0 };
        for (block, history) in self.with_history(step.history) {
            let Advance { history, plastic, viscous } = block.advance(&Step { history, ..*step });
            all.history.extend(history);
            all.plastic += plastic;
            all.viscous += viscous;
        }
        all
    }

    fn strain_energy(&self, at: BodyState) -> f64 {
        self.with_history(at.history).map(|(block, history)| block.strain_energy(BodyState { history, ..at })).sum()
    }

    fn relaxing_energy(&self, history: &[f64]) -> f64 {
        self.with_history(history).map(|(block, history)| block.relaxing_energy(history)).sum()
    }

    fn smallest_determinant(&self, u: &[f64]) -> Inverted {
        let mut least = Inverted { cell: 0, determinant: f64::INFINITY };
        for (first, block) in &self.blocks {
            let own = block.smallest_determinant(u);
            if own.determinant.is_nan() || own.determinant < least.determinant {
                least = Inverted { cell: first + own.cell, ..own };
            }
        }
        least
    }

    fn visit_stresses(&self, at: BodyState, visit: &mut dyn FnMut(&PointStress)) {
        for ((first, _), (block, history)) in self.blocks.iter().zip(self.with_history(at.history)) {
            block.visit_stresses(BodyState { history, ..at }, &mut |point| visit(&PointStress { cell: first + point.cell, ..*point }));
        }
    }

    fn visit_forces(&self, at: BodyState, field: &ForcePerMass, visit: &mut dyn FnMut(usize, &[[f64; 3]])) {
        for ((first, _), (block, history)) in self.blocks.iter().zip(self.with_history(at.history)) {
            block.visit_forces(BodyState { history, ..at }, field, &mut |cell, forces| visit(first + cell, forces));
        }
    }
}
