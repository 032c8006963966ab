//! The viscous stress of a body, a part beside the element loop.
//!
//! Its stress is symmetric and acts on the body in the middle of a step, so momenta are kept; its work on the step's strain, which
//! `B(q_mid) (q_1 - q_0)` is exactly, is what its branches store and what is dissipated (formulas: [`crate::materials::Viscosity`]). At
//! rest, in `settle`, everything has relaxed.
//!
//! Across the plane the strain stays zero, or it is that around the axis, which the positions give, or no stress acts there: then it is a
//! variable of each point, and what is stored by its distance from that of the elastic law is booked here (`bodies/thickness.rs`).

use std::ops::Range;

use nalgebra::{Matrix4, Matrix4x2, SVector, Vector4};

use super::viscous_points::{Contribution, Deformation, Frame, Matrix, Point, Strain, points_of};
use crate::bodies::{Plane, PlaneGradients, Resistance, Thickness};
use crate::dynamics::model::definitions::BodyDefinition;
use crate::dynamics::model::part::{Iterate, Part, Pose, Refusal, Remembered, Sums};
use crate::dynamics::model::step_error::StepError;
use crate::integrators::Configuration;
use crate::linear::{Block, Pattern};
use crate::materials::{Kinematics, Viscosity};
use crate::math::lanes::{Lanes, WIDTH};
use crate::math::tensor::mandel_index;

/// A viscous body in the numbering of the model.
pub struct ViscousBody {
    dimension: usize,
    viscosity: Viscosity,
    /// Which strain it is.
    kinematics: Kinematics,
    across: Across,
    /// Nodes of the cells.
    cells: Vec<Vec<u32>>,
    /// Points of the cells, cell by cell.
    points: Vec<Vec<Point>>,
    /// Blocks of the cells, node pairs row by row.
    places: Vec<Vec<Block>>,
}

/// The strain across the plane.
enum Across {
    /// Zero, or there is no such direction.
    Kept,
    /// Around the axis.
    Around,
    /// Free of stress.
    Free(Thickness),
}

/// What the strain across the plane does in a step where no stress acts there.
struct FreeStep {
    change: f64,
    distance: f64,
    /// Elastic stress in the plane beyond that of the body's own law.
    stress: Vector4<f64>,
    /// Derivatives of the stress with respect to the strain at the end, as the viscosity and as the law take it.
    tangents: [Matrix4<f64>; 2],
}

/// A place of the three components in the plane among four.
const PLACES: [usize; 3] = [0, 1, 3];

impl ViscousBody {
    /// The viscous part of a body whose nodes are numbered from `first`; `None` for a body without viscosity.
    pub fn new(body: &BodyDefinition, first: usize) -> Option<Self> {
        let viscosity = body.material.viscosity().clone();
        (!viscosity.is_none()).then(|| ViscousBody::with(body, first, body.formulation.plane, viscosity))
    }

    /// The part of a body with another viscosity and another completion to space than its own.
    pub fn with(body: &BodyDefinition, first: usize, plane: Plane, viscosity: Viscosity) -> Self {
        let mesh = &body.mesh;
        let across = match plane {
            Plane::Strain => Across::Kept,
            Plane::Axisymmetric => Across::Around,
            Plane::Stress => Across::Free(Thickness::new(&body.material)),
        };
        let cells = mesh.cells().map(|cell| cell.iter().map(|&node| node + first as u32).collect()).collect();
        let (points, kinematics) = (points_of(mesh, plane), body.material.kinematics());
        ViscousBody { dimension: mesh.dimension(), viscosity, kinematics, across, cells, points, places: Vec::new() }
    }

    /// Components of a strain that are remembered.
    fn components(&self) -> usize {
        self.dimension * (self.dimension + 1) / 2 + usize::from(!matches!(self.across, Across::Kept))
    }

    /// Numbers of the stress on the rate of strain that are remembered for fields: all components, where there is such a stress.
    fn of_rate(&self) -> usize {
        let resists = self.viscosity.shear != 0.0 || self.viscosity.bulk != 0.0;
        if resists { self.dimension * (self.dimension + 1) / 2 + 1 } else { 0 }
    }

    /// Numbers that a point remembers: strains of the branches, the stress on the rate in the last step, and the distance of a free strain
    /// across from that of the law.
    fn remembered_by_point(&self) -> usize {
        self.viscosity.branches.len() * self.components() + self.of_rate() + usize::from(matches!(self.across, Across::Free(_)))
    }

    /// Stress at the end of a step at a point that remembers this, xx, yy, zz, xy, yz, xz.
    fn stress_of<const D: usize>(&self, memory: &[f64]) -> [f64; 6] {
        let (branches, rest) = memory.split_at(self.viscosity.branches.len() * self.components());
        let mut sum = if self.of_rate() > 0 { Strain::<D>::unpacked(rest) } else { Strain { inner: Matrix::zeros(), across: 0.0 } };
        for (strain, branch) in branches.chunks_exact(self.components()).zip(&self.viscosity.branches) {
            sum = sum.sum(&Strain::<D>::unpacked(strain).times(2.0 * branch.shear_modulus));
        }
        let mut stress = [0.0; 6];
        for i in 0..D {
            (i..D).for_each(|j| stress[mandel_index::<3>(i, j)] = sum.inner[(i, j)]);
        }
        if D == 2 {
            stress[2] = sum.across;
        }
        stress
    }

    fn point_count(&self) -> usize {
        self.points.iter().map(Vec::len).sum()
    }

    /// What a point remembers, of the memory of all.
    fn memory_of<'a>(&self, index: usize, memory: &'a [f64]) -> &'a [f64] {
        let size = self.remembered_by_point();
        memory.get(index * size..(index + 1) * size).unwrap_or_default()
    }

    /// Deformation of a point by displacements.
    fn deformation<const D: usize>(&self, cell: usize, point: &Point, u: &[f64]) -> Deformation<D> {
        let mut h = Matrix::<D>::zeros();
        let last = self.cells[cell].len() - 1;
        let origin = self.cells[cell][last] as usize * D;
        for (&node, gradient) in self.cells[cell].iter().zip(&point.gradients) {
            for i in 0..D {
                // Relative to one node: gradients sum to zero.
                let along = u[node as usize * D + i] - u[origin + i];
                (0..D).for_each(|j| h[(i, j)] += along * gradient[j]);
            }
        }
        let stretch = |(&node, share): (&u32, &f64)| u[node as usize * D] * share;
        Deformation { inner: h, around: self.cells[cell].iter().zip(&point.around).map(stretch).sum() }
    }

    /// Change of the strain between two deformations; a free strain across is left out.
    fn strain_change<const D: usize>(&self, f_0: &Deformation<D>, f_1: &Deformation<D>) -> Strain<D> {
        if self.kinematics == Kinematics::Linear { f_0.linear_strain_to(f_1) } else { f_0.strain_to(f_1) }
    }

    /// The deformation by which a force is pulled forward and strains are varied: that of a strain of small displacements stands still.
    fn frame<const D: usize>(&self, at: Configuration, f_0: &Deformation<D>, f_1: &Deformation<D>) -> Frame<D> {
        match (self.kinematics, at) {
            (Kinematics::Linear, _) => Frame::rest(),
            (_, Configuration::Middle) => f_0.mean(f_1).frame(),
            (_, Configuration::End) => f_1.frame(),
        }
    }

    /// Share of the end of the step in the frame of the forces.
    fn geometric_share(&self, share: f64) -> f64 {
        if self.kinematics == Kinematics::Linear { 0.0 } else { share }
    }

    /// Calls `visit` for every point with its cell, its deformations at start and end, and the strains of its branches.
    fn for_each_point<const D: usize>(
        &self,
        at: &Iterate,
        memory: &[f64],
        mut visit: impl FnMut(usize, &Point, [Deformation<D>; 2], &[Strain<D>]),
    ) {
        let (count, mut strains, mut index) = (self.viscosity.branches.len(), Vec::new(), 0);
        for (cell, points) in self.points.iter().enumerate() {
            for point in points {
                strains.clear();
                strains.extend(self.memory_of(index, memory).chunks_exact(self.components()).take(count).map(Strain::<D>::unpacked));
                let f = [at.u_0, at.u_1].map(|u| self.deformation::<D>(cell, point, u));
                visit(cell, point, f, &strains);
                index += 1;
            }
        }
    }

    fn linearize_in<const D: usize>(&self, at: &Iterate, memory: &[f64], sums: &mut Sums) {
        let placement = at.derivative.placement();
        self.for_each_point::<D>(at, memory, |cell, point, [f_0, f_1], before| {
            let change = self.strain_change(&f_0, &f_1);
            let Contribution { stress, moduli: [a, b], .. } = Contribution::new(&self.viscosity, &change, before, at.dt);
            let (test, stress) = (self.frame(placement.test, &f_0, &f_1).inner, stress.inner);
            let f_1 = self.frame(Configuration::End, &f_0, &f_1).inner;
            let (weight, nodes) = (point.volume * at.weight, &self.cells[cell]);
            let piola = test * stress * weight;
            let gradient = |a: usize| SVector::<f64, D>::from_fn(|i, _| point.gradients[a][i]);
            for (k, &node) in nodes.iter().enumerate() {
                let force = piola * gradient(k);
                (0..D).for_each(|i| sums.internal[node as usize * D + i] += force[i]);
            }
            let Some(values) = sums.tangent.as_deref_mut() else { return };
            let (across, weighted, share) = (test * f_1.transpose(), stress * weight, self.geometric_share(placement.share));
            for k in 0..nodes.len() {
                let (g, left) = (gradient(k), test * gradient(k));
                for l in 0..nodes.len() {
                    let (h, right) = (gradient(l), f_1 * gradient(l));
                    // dE_1 = sym(F_1^T dx (x) G), so 2 (F_test dE_1 G) = F_test (F_1^T dx (G_l . G) + G_l (F_1 G . dx)).
                    let around = g.dot(&h);
                    let other = test * h;
                    let geometric = share * g.dot(&(weighted * h));
                    let block = self.places[cell][k * nodes.len() + l];
                    let ahead = f_1 * g;
                    for i in 0..D {
                        for j in 0..D {
                            let slope = 0.5 * a * (across[(i, j)] * around + other[i] * ahead[j]) + b * left[i] * right[j];
                            values[block.at(i, j)] += weight * slope + if i == j { geometric } else { 0.0 };
                        }
                    }
                }
            }
        });
    }

    /// The same where a plane body is strained across its plane: in four Mandel components, xx, yy, across, xy.
    fn linearize_completed(&self, at: &Iterate, memory: &[f64], sums: &mut Sums) {
        let placement = at.derivative.placement();
        let mut free = self.free_steps(at, memory).into_iter();
        self.for_each_point::<2>(at, memory, |cell, point, [f_0, f_1], before| {
            let (mut change, free) = (self.strain_change(&f_0, &f_1), free.next());
            change.across += free.as_ref().map_or(0.0, |step| step.change);
            let Contribution { stress, moduli: [a, b], .. } = Contribution::new(&self.viscosity, &change, before, at.dt);
            let root = std::f64::consts::SQRT_2;
            let mut stress = Vector4::new(stress.inner[(0, 0)], stress.inner[(1, 1)], stress.across, root * stress.inner[(0, 1)]);
            let trace = Vector4::new(1.0, 1.0, 1.0, 0.0);
            let mut tangents = [Matrix4::identity() * a + trace * trace.transpose() * b, Matrix4::zeros()];
            if let Some(step) = free {
                stress += step.stress;
                stress[2] = 0.0;
                tangents = step.tangents;
            }
            let (weight, nodes) = (point.volume * at.weight, &self.cells[cell]);
            let test = self.frame(placement.test, &f_0, &f_1);
            for (k, &node) in nodes.iter().enumerate() {
                let force = variation(point, k, &test).transpose() * stress * weight;
                (0..2).for_each(|i| sums.internal[node as usize * 2 + i] += force[i]);
            }
            let Some(values) = sums.tangent.as_deref_mut() else { return };
            let trial = [Configuration::End, placement.trial].map(|at| self.frame(at, &f_0, &f_1));
            let share = weight * self.geometric_share(placement.share);
            for l in 0..nodes.len() {
                let right = (tangents[0] * variation(point, l, &trial[0]) + tangents[1] * variation(point, l, &trial[1])) * weight;
                for k in 0..nodes.len() {
                    let slope = variation(point, k, &test).transpose() * right;
                    let ([g, h, _], [c, d, _]) = (point.gradients[k], point.gradients[l]);
                    let geometric = share * (stress[0] * g * c + stress[1] * h * d + stress[3] / root * (g * d + h * c));
                    let around = if point.around.is_empty() { 0.0 } else { share * stress[2] * point.around[k] * point.around[l] };
                    let block = self.places[cell][k * nodes.len() + l];
                    for i in 0..2 {
                        for j in 0..2 {
                            let stiff = if i == j { geometric } else { 0.0 } + if i + j == 0 { around } else { 0.0 };
                            values[block.at(i, j)] += slope[(i, j)] + stiff;
                        }
                    }
                }
            }
        });
    }

    /// What the strain across does in a step at each point, where no stress acts across the plane; otherwise none.
    fn free_steps(&self, at: &Iterate, memory: &[f64]) -> Vec<FreeStep> {
        let Across::Free(thickness) = &self.across else { return Vec::new() };
        // Deformations, and what the viscosity answers across while the strain there stays.
        let mut all: Vec<([Deformation<2>; 2], f64)> = Vec::with_capacity(self.point_count());
        let mut moduli = [0.0; 2];
        self.for_each_point::<2>(at, memory, |_, _, f, before| {
            let held = Contribution::new(&self.viscosity, &self.strain_change(&f[0], &f[1]), before, at.dt);
            all.push((f, held.stress.across));
            moduli = held.moduli;
        });
        let mut steps = Vec::with_capacity(all.len());
        for (number, some) in all.chunks(WIDTH).enumerate() {
            let gradients = [0, 1].map(|time| plane_gradients(some.len(), |lane| &some[lane].0[time]));
            let stress = lanes(some.len(), |lane| some[lane].1);
            let resistance = Resistance { stress, moduli };
            let step = thickness.step(gradients, self.distances(number, some.len(), memory), &resistance, at.derivative);
            steps.extend((0..some.len()).map(|lane| {
                let mut free = FreeStep {
                    change: step.change.0[lane],
                    distance: step.distance.0[lane],
                    stress: Vector4::zeros(),
                    tangents: [Matrix4::zeros(); 2],
                };
                for (k, &row) in PLACES.iter().enumerate() {
                    free.stress[row] = step.stress[k].0[lane];
                    for (l, &column) in PLACES.iter().enumerate() {
                        free.tangents[0][(row, column)] = step.viscous_tangent[k][l].0[lane];
                        free.tangents[1][(row, column)] = step.elastic_tangent[k][l].0[lane];
                    }
                }
                free
            }));
        }
        steps
    }

    /// Distances of the strain across from that of the law, of some points that follow each other.
    fn distances(&self, group: usize, count: usize, memory: &[f64]) -> Lanes<false> {
        lanes(count, |lane| self.memory_of(group * WIDTH + lane, memory).last().copied().unwrap_or_default())
    }

    /// What is remembered and what has been dissipated at the end of a step.
    fn outcome<const D: usize>(&self, at: &Iterate, before: &[f64]) -> Remembered {
        let (mut memory, mut dissipated) = (Vec::with_capacity(before.len()), 0.0);
        let mut free = self.free_steps(at, before).into_iter();
        self.for_each_point::<D>(at, before, |_, point, [f_0, f_1], before| {
            let (mut change, free) = (self.strain_change(&f_0, &f_1), free.next());
            change.across += free.as_ref().map_or(0.0, |step| step.change);
            let end = Contribution::new(&self.viscosity, &change, before, at.dt);
            dissipated += point.volume * end.dissipated;
            end.remembered.iter().for_each(|strain| strain.pack(self.components(), &mut memory));
            end.of_rate.pack(self.of_rate(), &mut memory);
            memory.extend(free.map(|step| step.distance));
        });
        Remembered { memory, dissipated }
    }

    /// Energy of the branches per volume at a point that remembers this.
    fn stored_by<const D: usize>(&self, memory: &[f64]) -> f64 {
        let branches = memory.chunks_exact(self.components()).zip(&self.viscosity.branches);
        branches.map(|(strain, branch)| branch.shear_modulus * Strain::<D>::unpacked(strain).norm_squared()).sum()
    }

    /// Energy that a free strain across stores by its distance from that of the law.
    fn stored_across(&self, u: &[f64], memory: &[f64]) -> f64 {
        let Across::Free(thickness) = &self.across else { return 0.0 };
        let points = self.points.iter().enumerate().flat_map(|(cell, points)| points.iter().map(move |point| (cell, point)));
        let all: Vec<_> = points.map(|(cell, point)| (point.volume, self.deformation::<2>(cell, point, u))).collect();
        let of_group = |(number, some): (usize, &[(f64, Deformation<2>)])| -> f64 {
            let gradient = plane_gradients(some.len(), |lane| &some[lane].1);
            let energy = thickness.energy(&gradient, self.distances(number, some.len(), memory));
            some.iter().zip(energy.0).map(|((volume, _), energy)| volume * energy).sum()
        };
        all.chunks(WIDTH).enumerate().map(of_group).sum()
    }
}

/// Values of some points as lanes, of which those that are left over repeat the first.
fn lanes(count: usize, value: impl Fn(usize) -> f64) -> Lanes<false> {
    Lanes(std::array::from_fn(|lane| value(if lane < count { lane } else { 0 })))
}

/// Displacement gradients of some points.
fn plane_gradients<'a>(count: usize, deformation: impl Fn(usize) -> &'a Deformation<2>) -> PlaneGradients {
    let entry = |i: usize, j: usize| lanes(count, |lane| deformation(lane).inner[(i, j)]);
    std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
}

/// Variation of the strain at a point with the position of a node of its cell, in Mandel components xx, yy, around, xy.
fn variation(point: &Point, node: usize, frame: &Frame<2>) -> Matrix4x2<f64> {
    let ([g, h, _], f, root) = (point.gradients[node], &frame.inner, std::f64::consts::SQRT_2);
    let mut variation = Matrix4x2::zeros();
    for i in 0..2 {
        variation[(0, i)] = f[(i, 0)] * g;
        variation[(1, i)] = f[(i, 1)] * h;
        variation[(3, i)] = (f[(i, 0)] * h + f[(i, 1)] * g) / root;
    }
    variation[(2, 0)] = point.around.get(node).map_or(0.0, |near| frame.around * near);
    variation
}

impl Part for ViscousBody {
    fn for_each_coupling(&self, _visit: &mut dyn FnMut(&[u32])) {
        // The nodes of a cell are coupled by the body.
    }

    fn place(&mut self, pattern: &Pattern) {
        let blocks = |nodes: &Vec<u32>| nodes.iter().flat_map(|&a| nodes.iter().map(move |&b| pattern.block(a, b))).collect();
        self.places = self.cells.iter().map(blocks).collect();
    }

    fn linearize(&self, at: &Iterate, memory: &[f64], sums: &mut Sums) -> Result<(), Refusal> {
        match (&self.across, at.dt > 0.0, self.dimension) {
            (_, false, _) => {}
            (Across::Kept, _, 2) => self.linearize_in::<2>(at, memory, sums),
            (Across::Kept, ..) => self.linearize_in::<3>(at, memory, sums),
            (Across::Around | Across::Free(_), ..) => self.linearize_completed(at, memory, sums),
        }
        Ok(())
    }

    fn energy(&self, at: Pose, memory: &[f64]) -> f64 {
        if memory.is_empty() {
            return 0.0;
        }
        let of_point = |(index, point): (usize, &Point)| {
            let memory = self.memory_of(index, memory);
            point.volume * if self.dimension == 2 { self.stored_by::<2>(memory) } else { self.stored_by::<3>(memory) }
        };
        self.points.iter().flatten().enumerate().map(of_point).sum::<f64>() + self.stored_across(at.u, memory)
    }

    fn stresses_of(&self, nodes: &Range<usize>, memory: &[f64]) -> Option<Vec<[f64; 6]>> {
        let is_its = self.cells.first().is_some_and(|cell| nodes.contains(&(cell[0] as usize)));
        // In plane stress the law's own stress is another one, too, at the thickness that both have together.
        if !is_its || memory.is_empty() || matches!(self.across, Across::Free(_)) {
            return None;
        }
        let of = |point: usize| {
            let memory = self.memory_of(point, memory);
            if self.dimension == 2 { self.stress_of::<2>(memory) } else { self.stress_of::<3>(memory) }
        };
        Some((0..self.point_count()).map(of).collect())
    }

    fn memory(&self) -> Vec<f64> {
        vec![0.0; self.point_count() * self.remembered_by_point()]
    }

    fn remembered(&self, at: &Iterate, memory: &[f64]) -> Result<Remembered, StepError> {
        Ok(self.after(at, memory))
    }
}

impl ViscousBody {
    /// Internal variables after a converged step, and its dissipation.
    pub(super) fn after(&self, at: &Iterate, memory: &[f64]) -> Remembered {
        match (at.dt > 0.0, self.dimension) {
            (false, _) => Remembered { memory: self.memory(), dissipated: 0.0 },
            (true, 2) => self.outcome::<2>(at, memory),
            (true, _) => self.outcome::<3>(at, memory),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::bodies::{Dilatation, Formulation};
    use crate::elements::CellKind;
    use crate::integrators::Derivative;
    use crate::linear::Vertex;
    use crate::materials::{Branch, LINEAR, Material, NeoHookean};
    use crate::math::workers::Workers;
    use crate::mesh::{block, rectangle};

    /// A viscous body of few cells, and positions near rest that differ from each other by some percent.
    fn body(plane: Plane, kind: CellKind, law: &Material) -> (ViscousBody, Pattern, [Vec<f64>; 2]) {
        let mesh = if kind.dimension() == 2 { rectangle([2.0, 1.0], [2, 1], [0.5, 0.0]) } else { block([1.0; 3], [1; 3], [0.0; 3]) };
        let mesh = mesh.and_then(|mesh| mesh.with_cells(kind)).unwrap();
        let branches = [(30.0, 0.05), (7.0, 0.4)].map(|(shear_modulus, relaxation_time)| Branch { shear_modulus, relaxation_time });
        let material = law.clone().with_viscosity(Viscosity { shear: 0.4, bulk: 0.1, branches: branches.to_vec() });
        let formulation = Formulation { plane, dilatation: Dilatation::Pointwise };
        let dimension = mesh.dimension();
        let rest: Vec<f64> = mesh.points.iter().flat_map(|point| point[..dimension].to_vec()).collect();
        let mut seed = 11u64;
        let q = [0.04, 0.08].map(|size| {
            let mut random = || {
                seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                size * ((seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0)
            };
            rest.iter().map(|_| random()).collect::<Vec<f64>>()
        });
        let mut body =
            ViscousBody::new(&BodyDefinition { name: "b".into(), mesh: Arc::new(mesh), material, formulation, rigid: None }, 0).unwrap();
        let pattern =
            Pattern::new(&vec![Vertex::coordinates(dimension as u8); rest.len() / dimension], body.cells.iter().map(|cell| &cell[..]));
        body.place(&pattern);
        (body, pattern, q)
    }

    /// Only displacements matter.
    fn iterate<'a>(derivative: Derivative, u_0: &'a [f64], u_1: &'a [f64]) -> Iterate<'a> {
        Iterate { weight: 0.7, dt: 0.05, ..Iterate::between(derivative, u_0, u_1) }
    }

    fn forces(body: &ViscousBody, at: &Iterate, memory: &[f64], values: Option<&mut [f64]>) -> Vec<f64> {
        let (mut internal, mut load) = (vec![0.0; at.q_1.len()], vec![0.0; at.q_1.len()]);
        let mut sums = Sums { internal: &mut internal, load: &mut load, tangent: values, workers: &Workers::new(1) };
        assert!(body.linearize(at, memory, &mut sums).is_ok());
        internal
    }

    fn cases() -> Vec<(Plane, CellKind, Material)> {
        let large = NeoHookean { youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 }.material().unwrap();
        let linear = Material::new(&LINEAR[0], &[100.0, 0.3, 1.0]).unwrap();
        let planes = [Plane::Strain, Plane::Stress, Plane::Axisymmetric];
        let plane = planes.map(|plane| [CellKind::Quad4, CellKind::Tri6].map(|kind| (plane, kind))).concat();
        let all = [plane, vec![(Plane::Strain, CellKind::Hex8)]].concat();
        [large, linear].iter().flat_map(|law| all.iter().map(|(plane, kind)| (*plane, *kind, law.clone()))).collect()
    }

    #[test]
    fn the_tangent_is_the_derivative_of_the_force() {
        for (plane, kind, law) in cases() {
            let (body, pattern, [q_0, q_1]) = body(plane, kind, &law);
            // What a step before has left.
            let memory = body.after(&iterate(Derivative::DiscreteGradient, &q_1, &q_0), &body.memory()).memory;
            for derivative in Derivative::ALL {
                let mut values = vec![0.0; pattern.values()];
                forces(&body, &iterate(derivative, &q_0, &q_1), &memory, Some(&mut values));
                let (size, h) = (body.dimension, 1e-6);
                for unknown in 0..q_1.len() {
                    let [up, down] = [h, -h].map(|h| {
                        let mut q = q_1.clone();
                        q[unknown] += h;
                        forces(&body, &iterate(derivative, &q_0, &q), &memory, None)
                    });
                    for &node in pattern.neighbors(unknown / size) {
                        let block = pattern.block(node, (unknown / size) as u32);
                        for i in 0..size {
                            let difference = (up[node as usize * size + i] - down[node as usize * size + i]) / (2.0 * h);
                            let value = values[block.at(i, unknown % size)];
                            // Of some hundreds, around the axis some thousands: truncation h^2, round-off 1e-16/h.
                            assert!((difference - value).abs() < 1e-5, "{plane:?} {kind:?} {law:?} {derivative:?}: {difference} {value}");
                        }
                    }
                }
            }
        }
    }

    /// The work of the force is what is stored beyond what the body's own law stores, and what is dissipated.
    #[test]
    fn the_work_of_a_step_is_stored_or_heat() {
        for (plane, kind, law) in cases() {
            let (body, _, [q_0, q_1]) = body(plane, kind, &law);
            let (mut from, mut memory) = (q_0.clone(), body.memory());
            let (mut stored, mut q) = (body.energy(Pose { q: &q_0, u: &q_0 }, &memory), q_1);
            assert_eq!(stored, 0.0);
            for _ in 0..3 {
                let at = iterate(Derivative::DiscreteGradient, &from, &q);
                let work: f64 = forces(&body, &at, &memory, None).iter().zip(q.iter().zip(&from)).map(|(f, (a, b))| f * (a - b)).sum();
                let Remembered { memory: after, dissipated } = body.after(&at, &memory);
                let energy = body.energy(Pose { q: &q, u: &q }, &after);
                let scale = work.abs() + energy + dissipated;
                assert!(dissipated > 0.0 && energy > 0.0, "{plane:?} {kind:?} {law:?}");
                let defect = work / at.weight - (energy - stored) - dissipated;
                // Round-off of energies of a hundred times a volume.
                assert!(defect.abs() < 1e-13 * scale.max(10.0), "{plane:?} {kind:?} {law:?}: {defect:e} of {scale}");
                (stored, memory) = (energy, after);
                std::mem::swap(&mut from, &mut q);
            }
        }
    }
}
