//! Cauchy stress, strain, energy and history of the quadrature points of a body, and the internal forces of its cells.

use nalgebra::{Matrix3, Vector3};

use super::batch::{Batch, MOST_POINTS, Point};
use super::cells::{Cells, Deformation};
use super::element_loop::{BodyState, ForcePerMass, PointStress};
use crate::math::lanes::{Lanes, WIDTH};
use crate::math::tensor::{mandel_index, mandel_scale};

/// Deformation, energies and history of a batch in a given state.
struct Shown<const D: usize, const S: usize, const Q: usize> {
    deformation: Deformation<D, S, Q>,
    /// Pressures of the cell dilatation at the points, if the cells have one.
    pressures: Option<[Lanes<false>; MOST_POINTS]>,
    energies: [Lanes<false>; MOST_POINTS],
    /// History variables of the batch.
    kept: Vec<Lanes<false>>,
}

/// Stress and strain at a point of one cell.
struct AtPoint {
    /// Deformation gradient; the identity for linear kinematics.
    frame: Matrix3<f64>,
    cauchy: Matrix3<f64>,
    strain: Matrix3<f64>,
}

/// Components xx, yy, zz, xy, yz, xz of a symmetric matrix.
fn components(m: &Matrix3<f64>) -> [f64; 6] {
    [m.m11, m.m22, m.m33, m.m12, m.m23, m.m13]
}

impl<const D: usize, const S: usize, const L: usize, const A: usize, const Q: usize> Cells<D, S, L, A, Q> {
    fn shown(&self, index: usize, batch: &Batch<D>, BodyState { u, history }: BodyState) -> Shown<D, S, Q> {
        let (deformation, kept) = (self.deform(batch, Some(u)), self.history_of(index, history));
        let special = self.physics.special.as_ref().zip(deformation.special.as_ref());
        let (mut energies, points) = ([Lanes::ZERO; MOST_POINTS], self.table.counts.points());
        match special {
            Some((special, points)) => energies = special.densities(points, &kept),
            None => self.physics.law.energies_into(&deformation.strain[..points], &mut energies[..points]),
        }
        let pressures = special.map(|(special, points)| special.pressures(points));
        Shown { pressures, energies, kept, deformation }
    }

    /// Visits a point of all cells of a batch.
    fn for_each_lane(&self, batch: &Batch<D>, shown: &Shown<D, S, Q>, point: usize, visit: &mut dyn FnMut(usize, AtPoint)) {
        let Shown { deformation, pressures, kept, .. } = shown;
        let around = deformation.special.as_ref().map_or(Lanes::ZERO, |points| points.hoop[1][point]);
        let seen = self.physics.seen(&deformation.strain[point], around, kept, point);
        for lane in 0..batch.count {
            let frame = self.physics.strain.spatial_frame(&deformation.gradient[point], &seen.strain, lane);
            let s = Matrix3::from_fn(|i, j| seen.stress[mandel_index::<3>(i, j)].0[lane] * mandel_scale(i, j));
            let pressure = Matrix3::identity() * pressures.map_or(0.0, |pressures| pressures[point].0[lane]);
            let cauchy = frame * s * frame.transpose() / frame.determinant() + pressure;
            let strain = Matrix3::from_fn(|i, j| seen.strain[mandel_index::<3>(i, j)].0[lane] * mandel_scale(i, j));
            visit(lane, AtPoint { frame, cauchy, strain });
        }
    }

    /// Implements [`ElementLoop::visit_stresses`](super::ElementLoop::visit_stresses).
    pub(super) fn visit_points(&self, at: BodyState, visit: &mut dyn FnMut(&PointStress)) {
        let (nodes, points) = (self.table.counts.nodes(), self.table.counts.points());
        for (index, batch) in self.batches.iter().enumerate() {
            let shown = self.shown(index, batch, at);
            let volumes = &shown.deformation.volumes[..points];
            let cell_volume: [f64; WIDTH] = std::array::from_fn(|lane| volumes.iter().map(|volume| volume.0[lane]).sum());
            for point in 0..points {
                self.for_each_lane(batch, &shown, point, &mut |lane, here| {
                    visit(&PointStress {
                        cell: index * WIDTH + lane,
                        nodes: self.nodes(index, lane),
                        shapes: &self.table.shapes[point][..nodes],
                        extrapolation: &self.table.extrapolation[point][..nodes],
                        volume: volumes[point].0[lane],
                        cell_volume: cell_volume[lane],
                        stress: components(&here.cauchy),
                        strain: components(&here.strain),
                        energy: shown.energies[point].0[lane],
                        kept: self.physics.shown(&shown.kept, point, lane),
                    });
                });
            }
        }
    }

    /// Implements [`ElementLoop::visit_forces`](super::ElementLoop::visit_forces). With the first Piola-Kirchhoff stress `P = J sigma F^-T`
    /// at the points, the mass `m` of a point and the force per mass `b`, the nodal force is `f_a = sum V P G_a - m N_a b`; a body of
    /// revolution adds `V P_33 N_a / R` in radial direction.
    pub(super) fn visit_cell_forces(&self, at: BodyState, field: &ForcePerMass, visit: &mut dyn FnMut(usize, &[[f64; 3]])) {
        let counts = self.table.counts;
        let (nodes, points) = (counts.nodes(), counts.points());
        let mut place = Point::<false, D, A>::ZERO;
        for (index, batch) in self.batches.iter().enumerate() {
            let shown = self.shown(index, batch, at);
            let mut forces = [[[0.0; 3]; A]; WIDTH];
            for point in 0..points {
                self.set_point(batch, point, &mut place);
                let shapes = &self.table.shapes[point][..nodes];
                self.for_each_lane(batch, &shown, point, &mut |lane, AtPoint { frame, cauchy, .. }| {
                    let volume = shown.deformation.volumes[point].0[lane];
                    let inverse = frame.try_inverse().unwrap_or_else(Matrix3::identity);
                    let piola = cauchy * inverse.transpose() * (volume * frame.determinant());
                    let mut last = Vector3::zeros();
                    for (a, force) in forces[lane].iter_mut().enumerate().take(nodes - 1) {
                        let gradient = Vector3::from_fn(|i, _| if i < D { place.gradients[a][i].0[lane] } else { 0.0 });
                        let pull = piola * gradient;
                        last -= pull;
                        (0..3).for_each(|i| force[i] += pull[i]);
                    }
                    (0..3).for_each(|i| forces[lane][nodes - 1][i] += last[i]);
                    let mass = self.physics.density * shown.deformation.weighed[point].0[lane];
                    let on_mass = field(self.nodes(index, lane), shapes).map(|b| mass * b);
                    for (force, shape) in forces[lane].iter_mut().zip(shapes) {
                        (0..3).for_each(|i| force[i] -= shape * on_mass[i]);
                    }
                    if self.is_axisymmetric() {
                        let around = piola.m33 * place.curvature.0[lane];
                        forces[lane].iter_mut().zip(shapes).for_each(|(force, shape)| force[0] += around * shape);
                    }
                });
            }
            for (lane, forces) in forces.iter().enumerate().take(batch.count) {
                visit(index * WIDTH + lane, &forces[..nodes]);
            }
        }
    }
}
