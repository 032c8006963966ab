//! Cauchy stress, strain and history of the quadrature points of a body.

use super::cells::Cells;
use super::element_loop::{PointStress, Present};
use crate::math::lanes::{Lanes, WIDTH};
use crate::math::tensor::{mandel_index, mandel_scale};

impl<const D: usize, const S: usize, const L: usize, const A: usize, const Q: usize> Cells<D, S, L, A, Q> {
    /// Implements [`ElementLoop::visit_stresses`](super::ElementLoop::visit_stresses).
    pub(super) fn visit_points(&self, Present { u, history }: Present, visit: &mut dyn FnMut(&PointStress)) {
        for (index, batch) in self.batches.iter().enumerate() {
            let deformation = self.deform(batch, Some(u));
            let special = self.physics.special.as_ref().zip(deformation.special.as_ref());
            let pressures = special.map(|(special, points)| special.pressures(points));
            let cell_volume: [f64; WIDTH] = std::array::from_fn(|lane| deformation.volumes.iter().map(|volume| volume.0[lane]).sum());
            let kept = self.history_of(index, history);
            for point in 0..Q {
                let around = special.map_or(Lanes::ZERO, |(_, points)| points.hoop[1][point]);
                let seen = self.physics.seen(&deformation.strain[point], around, &kept, point);
                for lane in 0..batch.count {
                    let f = self.physics.strain.spatial_frame(&deformation.gradient[point], &seen.strain, lane);
                    let s = nalgebra::Matrix3::from_fn(|i, j| seen.stress[mandel_index::<3>(i, j)].0[lane] * mandel_scale(i, j));
                    let pressure = nalgebra::Matrix3::identity() * pressures.map_or(0.0, |pressures| pressures[point].0[lane]);
                    let cauchy = f * s * f.transpose() / f.determinant() + pressure;
                    let green = |i: usize, j: usize| seen.strain[mandel_index::<3>(i, j)].0[lane] * mandel_scale(i, j);
                    visit(&PointStress {
                        cell: index * WIDTH + lane,
                        nodes: self.nodes(index, lane),
                        shapes: &self.table.shapes[point],
                        extrapolation: &self.table.extrapolation[point],
                        volume: deformation.volumes[point].0[lane],
                        cell_volume: cell_volume[lane],
                        stress: [cauchy.m11, cauchy.m22, cauchy.m33, cauchy.m12, cauchy.m23, cauchy.m13],
                        strain: [green(0, 0), green(1, 1), green(2, 2), green(0, 1), green(1, 2), green(0, 2)],
                        kept: self.physics.shown(&kept, point, lane),
                    });
                }
            }
        }
    }
}
