//! Element loop over the cells of one body.
//!
//! Per point, with displacement gradient `H`, `F = I + H`, Green-Lagrange strain `E = (H + H^T + H^T H)/2` (relative accuracy at small
//! strain), algorithmic stress `S` and its derivative `T = dS/dE_1` from the step's `Derivative`,
//!
//! ```text
//! force    f_a   = w F_test S G_a
//! tangent  K_ab  = w G_a . A . G_b,   A_iJkL = (F_test)_iM T_MJNL (F_trial)_kN + share S_JL delta_ik
//! ```
//!
//! (Simo and Tarnow, ZAMP 43, 1992; Gonzalez 2000), plus the consistent mass with the weight of the time integrator. The computations for a
//! batch of eight cells are in `batch.rs` and `workspace.rs`, the sums in `assembly.rs`. Unused lanes of the last batch repeat its
//! first cell and are not assembled.

use std::ops::Range;

use super::batch::{Batch, Point, Table, cast, deformation_gradient, determinant_and_cofactor};
use super::completion::AddedForce;
use super::consistent_mass::{MassRule, summed};
use super::element_loop::{Advance, BodyState, ElementLoop, FastestCell, ForcePerMass, Inverted, PointStress, Step};
use super::physics::Physics;
use super::special::{Answer, BatchStep, SpecialPoints};
use super::workspace::Workspace;
use crate::elements::ReferenceCell;
use crate::integrators::{Derivative, Lumping};
use crate::linear::{Block, NodeMatrix, Pattern};
use crate::materials::Components;
use crate::math::lanes::{Lanes, WIDTH, relabel_rows};
use crate::math::rounds::{LEAST_WORK_FOR_THREADS, Run, pieces, rounds};
use crate::math::simd::{Kernel, dispatch};
use crate::math::workers::Workers;
use crate::mesh::{Block as MeshBlock, Mesh};

/// Places of the blocks of the cells in the array of values; empty before a matrix is placed.
#[derive(Default)]
pub(super) struct Places {
    /// Columns of the unknowns of each node, cell by cell: position of the first value, and length.
    columns: Vec<Block>,
    /// Position of the block of node `a` inside a column of node `b`, cell by cell, with `a` running fastest.
    rows: Vec<u32>,
}

impl Places {
    /// Columns, and positions of blocks inside them, of a cell with `count` nodes.
    #[inline(always)]
    pub(super) fn of(&self, cell: usize, count: usize) -> (&[Block], &[u32]) {
        (&self.columns[cell * count..][..count], &self.rows[cell * count * count..][..count * count])
    }
}

/// The cells of a body, of a kind with at most `A` nodes and `Q` quadrature points ([`Counts`](super::batch::Counts)).
pub(super) struct Cells<const D: usize, const S: usize, const L: usize, const A: usize, const Q: usize> {
    pub(super) physics: Physics<S, L>,
    cliques: Vec<Vec<u32>>,
    pub(super) table: Table<D, A, Q>,
    pub(super) batches: Vec<Batch<D>>,
    pub(super) places: Places,
    rounds: Vec<Vec<PlacedRun<D>>>,
}

/// Run of cells, with the range of its nodes' columns in the matrix values; ranges are empty before a matrix is placed.
pub(super) struct PlacedRun<const D: usize> {
    pub(super) run: Run,
    pub(super) values: Range<usize>,
    pub(super) fresh_values: Vec<Range<usize>>,
}

impl<const D: usize> PlacedRun<D> {
    fn unknowns(&self) -> Range<usize> {
        self.run.nodes.start * D..self.run.nodes.end * D
    }
}

impl<const D: usize, const S: usize, const L: usize, const A: usize, const Q: usize> Cells<D, S, L, A, Q> {
    /// Cells of a mesh whose nodes start at `first_node` in the model.
    ///
    /// # Errors
    /// The first inverted cell.
    pub(super) fn new<C: ReferenceCell<D, N, P>, const N: usize, const P: usize>(
        mesh: &Mesh,
        block: &MeshBlock,
        physics: Physics<S, L>,
        first_node: usize,
        touched: &mut Vec<Range<usize>>,
    ) -> Result<Self, Inverted> {
        let cells: Vec<&[u32]> = block.cells().collect();
        let cliques: Vec<Vec<u32>> = cells.iter().map(|cell| cell.iter().map(|&node| node + first_node as u32).collect()).collect();
        let unplaced = |run| PlacedRun { run, values: 0..0, fresh_values: Vec::new() };
        let mut elements = Cells {
            physics,
            rounds: rounds(&cliques, WIDTH, touched).into_iter().map(|round| round.into_iter().map(unplaced).collect()).collect(),
            cliques,
            table: Table::new::<C, N, P>(),
            batches: cells.chunks(WIDTH).map(|chunk| Batch::new(chunk, &mesh.points, first_node)).collect(),
            places: Places::default(),
        };
        for (index, batch) in elements.batches.iter().enumerate() {
            let volumes = elements.deform(batch, None).volumes;
            for lane in 0..batch.count {
                let smallest =
                    volumes[..P].iter().map(|volume| volume.0[lane]).fold(f64::INFINITY, |least, v| if v >= least { least } else { v });
                if smallest.is_nan() || smallest <= 0.0 {
                    return Err(Inverted { cell: index * WIDTH + lane, determinant: smallest });
                }
            }
        }
        let (rule, is_section) = (MassRule::new::<C, N, P>(block.kind.shape()), elements.is_axisymmetric());
        let mut room = Vec::new();
        for index in 0..elements.batches.len() {
            let volumes = elements.deform(&elements.batches[index], None).weighed;
            elements.batches[index].keep_mass(&rule, &elements.table, &volumes, is_section, &mut room);
        }
        Ok(elements)
    }

    /// Consistent mass matrix of a cell, row by row and per density, from the initial volumes of its points.
    pub(super) fn mass_products(&self, batch: &Batch<D>, volumes: &[Lanes<false>; Q], lane: usize) -> Vec<f64> {
        let nodes = 0..batch.nodes.len();
        let entry = |a: usize, b: usize| match batch.kept_mass(a, b) {
            Some(product) => product.0[lane],
            None => summed(&self.table, volumes, lane, [a, b]),
        };
        nodes.clone().flat_map(|a| nodes.clone().map(move |b| (a, b))).map(|(a, b)| entry(a, b)).collect()
    }

    /// Volumes, displacement gradients and strains of a batch at its points; those of the undeformed cells if `u` is `None`.
    /// Never inlined: the kernel would be compiled for each file that calls it.
    #[inline(never)]
    pub(super) fn deform(&self, batch: &Batch<D>, u: Option<&[f64]>) -> Deformation<D, S, Q> {
        dispatch(Deform { cells: self, batch, u })
    }

    /// Model node numbers of a cell, given its batch and lane.
    pub(super) fn nodes(&self, batch: usize, lane: usize) -> &[u32] {
        &self.cliques[batch * WIDTH + lane]
    }

    /// True for the cells of a body of revolution, which are plane.
    pub(super) fn is_axisymmetric(&self) -> bool {
        D == 2 && self.physics.is_axisymmetric()
    }

    /// Sets quadrature point `q` of a batch relative to the stress-free state; for bodies of revolution with the volume of the whole
    /// circumference.
    #[inline(always)]
    pub(super) fn set_point<const FMA: bool>(&self, batch: &Batch<D>, q: usize, point: &mut Point<FMA, D, A>) {
        let (table, edges) = (&self.table, &batch.edges[..self.table.counts.nodes()]);
        point.set(edges, &table.gradients[q], table.weights[q]);
        if self.is_axisymmetric() {
            point.revolve(batch.last, edges, &table.shapes[q]);
        }
        if let Some(factor) = batch.growth.get(q) {
            point.grow(cast(*factor), self.physics.directions::<D>());
        }
    }

    /// Computes the forces of a batch in a step and, with `geometric` times the geometric stiffness, the tangent; returns true if no cell
    /// is inverted.
    #[inline(always)]
    pub(super) fn respond<const FMA: bool>(
        &self,
        index: usize,
        step: &Step,
        work: &mut Workspace<FMA, D, S, A, Q>,
        answer: &mut Option<Box<Answer<L>>>,
        geometric: Option<f64>,
    ) -> bool {
        let (batch, table, physics) = (&self.batches[index], &self.table, &self.physics);
        let is_axisymmetric = self.is_axisymmetric();
        for q in 0..table.counts.points() {
            self.set_point(batch, q, &mut work.points[q]);
        }
        work.set_start(batch, step.u_0);
        work.set_end(batch, step.u_1);
        if work.is_inside_out() {
            return false;
        }
        let special = physics.special.as_ref().map(|special| {
            let around = [Some(step.u_0), Some(step.u_1)].map(|u| u.filter(|_| is_axisymmetric));
            let points = work.special_points(batch, table, around);
            let answer = answer.get_or_insert_with(|| Box::new(Answer::EMPTY));
            let kept = self.history_of(index, step.history);
            special.respond(&points, BatchStep { derivative: step.derivative, history: &kept, dt: step.dt }, answer);
            work.take(answer);
            points
        });
        if special.is_none() {
            work.respond(&*physics.law, step.derivative);
        }
        if let Some(geometric) = geometric {
            let rates = answer.as_ref().and_then(|answer| answer.rates.as_deref()).filter(|_| special.is_some());
            work.integrate(step.derivative, step.weight, geometric, rates);
            work.add_mass(batch, table, step.inertia * physics.density);
        } else {
            work.integrate_force(step.derivative, step.weight);
        }
        if let (Some(points), Some(answer)) = (special, answer) {
            // A nonpositive hoop stretch also counts as an inverted cell.
            if points.hoop[1][..points.count].iter().any(|hoop| hoop.0.iter().any(|hoop| *hoop <= -1.0)) {
                return false;
            }
            let share = geometric.unwrap_or_default() * work.geometric_share(step.derivative.placement().share);
            let Step { derivative, weight, .. } = *step;
            let share = AddedForce { derivative, weight, with_tangent: geometric.is_some(), geometric: share };
            work.complete(answer, &points, table, is_axisymmetric, share);
        }
        true
    }
}

/// Deformation of a batch at its points.
pub(super) struct Deformation<const D: usize, const S: usize, const Q: usize> {
    pub(super) volumes: [Lanes<false>; Q],
    /// Undeformed volumes, which carry the mass.
    pub(super) weighed: [Lanes<false>; Q],
    pub(super) gradient: [[[Lanes<false>; D]; D]; Q],
    pub(super) strain: [Components<S>; Q],
    /// Point data for a special stress (hoop strain, dilatation of the cell), if the body has one.
    pub(super) special: Option<Box<SpecialPoints<D>>>,
    pub(super) smallest_determinants: [f64; WIDTH],
}

struct Deform<'a, const D: usize, const S: usize, const L: usize, const A: usize, const Q: usize> {
    cells: &'a Cells<D, S, L, A, Q>,
    batch: &'a Batch<D>,
    u: Option<&'a [f64]>,
}

impl<const D: usize, const S: usize, const L: usize, const A: usize, const Q: usize> Kernel for Deform<'_, D, S, L, A, Q> {
    type Output = Deformation<D, S, Q>;

    #[inline(always)]
    fn run<const FMA: bool>(self) -> Deformation<D, S, Q> {
        let Deform { cells, batch, u } = self;
        let (table, strain, count) = (&cells.table, cells.physics.strain, cells.table.counts.nodes());
        let u = u.map(|u| batch.displacements::<FMA, A>(count, u));
        let mut deformation = Deformation {
            volumes: [Lanes::ZERO; Q],
            weighed: [Lanes::ZERO; Q],
            gradient: [[[Lanes::ZERO; D]; D]; Q],
            strain: [[Lanes::ZERO; S]; Q],
            smallest_determinants: [f64::INFINITY; WIDTH],
            special: cells.physics.special.is_some().then(|| Box::new(SpecialPoints::new(table.counts.points()))),
        };
        let mut point = Point::<FMA, D, A>::ZERO;
        for q in 0..table.counts.points() {
            cells.set_point(batch, q, &mut point);
            let gradient = u.as_ref().map_or([[Lanes::ZERO; D]; D], |u| point.displacement_gradient(count, u));
            deformation.volumes[q] = Lanes(point.volume.0);
            deformation.weighed[q] = Lanes(point.weighed.0);
            deformation.gradient[q] = relabel_rows(&gradient);
            deformation.strain[q] = strain.of(&gradient, Lanes::ZERO);
            let determinant = determinant_and_cofactor(&deformation_gradient(&gradient)).0;
            for (smallest, &determinant) in deformation.smallest_determinants.iter_mut().zip(&determinant.0) {
                // A NaN determinant replaces the minimum, so that the result is NaN.
                let keep = *smallest < determinant || smallest.is_nan();
                *smallest = if keep { *smallest } else { determinant };
            }
            if let Some(points) = &mut deformation.special {
                points.volume[q] = deformation.volumes[q];
                points.places[q] = table.place(batch, q);
                points.gradients[1][q] = deformation.gradient[q];
                if let Some(u) = u.as_ref().filter(|_| cells.is_axisymmetric()) {
                    points.hoop[1][q] = Lanes(point.hoop(count, u, &table.shapes[q]).0);
                }
            }
        }
        for hoop in deformation.special.iter().flat_map(|points| &points.hoop[1][..points.count]) {
            for (least, hoop) in deformation.smallest_determinants.iter_mut().zip(hoop.0) {
                // A body of revolution that crosses its axis also counts as inverted.
                *least = least.min(*least * (1.0 + hoop)).min(1.0 + hoop);
            }
        }
        deformation
    }
}

impl<const D: usize, const S: usize, const L: usize, const A: usize, const Q: usize> ElementLoop<D> for Cells<D, S, L, A, Q> {
    fn cliques(&self) -> &[Vec<u32>] {
        &self.cliques
    }

    fn place(&mut self, pattern: &Pattern) {
        let columns = |node: u32| pattern.block(pattern.neighbors(node as usize)[0], node);
        let (cells, count) = (self.cliques.len(), self.table.counts.nodes());
        let mut places = Places { columns: Vec::with_capacity(cells * count), rows: Vec::with_capacity(cells * count * count) };
        for nodes in &self.cliques {
            for &b in nodes {
                let column = columns(b);
                places.columns.push(column);
                places.rows.extend(nodes.iter().map(|&a| pattern.block(a, b).start - column.start));
            }
        }
        self.places = places;
        let before = |node: usize| columns(node as u32).start as usize;
        let after = |node: usize| before(node) + D * columns(node as u32).stride as usize;
        let values = |nodes: &Range<usize>| before(nodes.start)..after(nodes.end - 1);
        for placed in self.rounds.iter_mut().flatten() {
            placed.values = values(&placed.run.nodes);
            placed.fresh_values = placed.run.fresh.iter().map(values).collect();
        }
    }

    fn grow(&mut self, factor: &dyn Fn(u32) -> f64) -> f64 {
        let (Table { shapes, counts, .. }, mut least) = (&self.table, f64::INFINITY);
        for batch in &mut self.batches {
            let nodes = &batch.nodes;
            let at = |q: usize, lane: usize| (0..counts.nodes()).map(|a| shapes[q][a] * factor(nodes[a][lane])).sum::<f64>();
            batch.growth = (0..counts.points()).map(|q| Lanes(std::array::from_fn(|lane| at(q, lane)))).collect();
            least = batch.growth.iter().flat_map(|factors| factors.0).fold(least, f64::min);
        }
        least
    }

    fn add_mass(&self, mass: &mut NodeMatrix) {
        for (index, batch) in self.batches.iter().enumerate() {
            let volumes = self.deform(batch, None).weighed;
            for lane in 0..batch.count {
                let nodes = self.nodes(index, lane);
                let pairs = nodes.iter().flat_map(|&a| nodes.iter().map(move |&b| (a, b)));
                for ((a, b), product) in pairs.zip(self.mass_products(batch, &volumes, lane)) {
                    mass.add(a, b, self.physics.density * product);
                }
            }
        }
    }

    fn add_lumped_mass(&self, lumping: Lumping, mass: &mut [f64]) -> bool {
        self.lump_mass(lumping, mass)
    }

    fn fastest_cell(&self, lumping: Lumping, u: &[f64]) -> FastestCell {
        self.find_fastest(lumping, u)
    }

    fn assemble(&self, step: &Step, force: &mut [f64], mut values: Option<&mut [f64]>, workers: &Workers) -> Result<(), Inverted> {
        let work = self.cliques.len() * self.cliques.first().map_or(0, |cell| cell.len() * cell.len());
        let is_shared = workers.are_many() && work >= LEAST_WORK_FOR_THREADS;
        for round in &self.rounds {
            if !is_shared {
                for placed in round {
                    let values = values.as_deref_mut().map(|values| &mut values[placed.values.clone()]);
                    self.assemble_run(step, placed, &mut force[placed.unknowns()], values)?;
                }
                continue;
            }
            let forces = pieces(force, round.iter().map(PlacedRun::unknowns));
            let values = values.as_deref_mut().map(|values| pieces(values, round.iter().map(|placed| placed.values.clone())));
            let mut values = values.unwrap_or_default().into_iter();
            let mut tasks: Vec<_> = round.iter().zip(forces).map(|(placed, force)| (placed, force, values.next(), Ok(()))).collect();
            workers.for_each(&mut tasks, 1, |_, (placed, force, values, outcome)| {
                *outcome = self.assemble_run(step, placed, force, values.as_deref_mut());
            });
            tasks.into_iter().try_for_each(|(.., outcome)| outcome)?;
        }
        Ok(())
    }

    fn add_material_stiffness(&self, u: &[f64], factor: f64, values: &mut [f64]) {
        let step = Step { derivative: Derivative::AT_END, weight: factor, inertia: 1.0, u_0: u, u_1: u, history: &[], dt: 0.0 };
        self.add_all(&step, &mut vec![0.0; u.len()], Some(values), 0.0);
    }

    fn add_step(&self, step: &Step, force: &mut [f64], values: Option<&mut [f64]>) {
        self.add_all(step, force, values, 1.0);
    }

    fn history(&self) -> usize {
        self.batches.len() * self.history_per_batch()
    }

    fn relaxed(&self, at: BodyState) -> Vec<f64> {
        self.relaxed_history(at)
    }

    fn flows(&self) -> bool {
        let law = self.physics.special.as_ref().and_then(|special| special.law.history());
        law.is_some_and(|law| law.shown(&vec![Lanes::ZERO; law.variables()], 0).is_some())
    }

    fn advance(&self, step: &Step) -> Advance {
        self.advanced(step)
    }

    fn strain_energy(&self, BodyState { u, history }: BodyState) -> f64 {
        let mut sum = 0.0;
        for (index, batch) in self.batches.iter().enumerate() {
            let Deformation { volumes, strain, special: points, .. } = self.deform(batch, Some(u));
            if let (Some(special), Some(points)) = (&self.physics.special, points) {
                sum += special.energy(&points, &self.history_of(index, history)).0[..batch.count].iter().sum::<f64>();
                continue;
            }
            let (mut energy, points) = ([Lanes::ZERO; Q], self.table.counts.points());
            self.physics.law.energies_into(&strain[..points], &mut energy[..points]);
            for lane in 0..batch.count {
                sum += (0..points).map(|q| volumes[q].0[lane] * energy[q].0[lane]).sum::<f64>();
            }
        }
        sum
    }

    fn relaxing_energy(&self, history: &[f64]) -> f64 {
        self.relaxing_energy_of(history)
    }

    fn smallest_determinant(&self, u: &[f64]) -> Inverted {
        let mut least = Inverted { cell: 0, determinant: f64::INFINITY };
        for (index, batch) in self.batches.iter().enumerate() {
            let determinants = self.deform(batch, Some(u)).smallest_determinants;
            for (lane, &determinant) in determinants.iter().enumerate().take(batch.count) {
                if determinant.is_nan() || determinant < least.determinant {
                    least = Inverted { cell: index * WIDTH + lane, determinant };
                }
            }
        }
        least
    }

    fn visit_stresses(&self, at: BodyState, visit: &mut dyn FnMut(&PointStress)) {
        self.visit_points(at, visit);
    }

    fn visit_forces(&self, at: BodyState, field: &ForcePerMass, visit: &mut dyn FnMut(usize, &[[f64; 3]])) {
        self.visit_cell_forces(at, field, visit);
    }
}
