//! Laws beyond their range of validity: linear elasticity with rotations, Saint Venant-Kirchhoff material in strong compression.
//!
//! Neither fails in the computation. The motion of a cell follows from its nodes: the deformation gradient that fits their motion best,
//! `F = sum dx dX^T (sum dX dX^T)^-1 = R U`. Where a support rotates by `theta`, linear elasticity takes `1 - cos theta` for a strain at
//! its nodes. Its stresses do not rotate with the body, and have a moment about it, of first order in the angle: with the mean stress
//! `V = int sigma dV` and the rotation vector `theta` of the body `V theta - tr(V) theta`. Rotations caused by strain, as in bending, are
//! within the range of the law: such moments are reported for rotating supports alone.

use nalgebra::{Matrix3, Rotation3, SMatrix, Vector3};

use super::engine::Engine;
use crate::bodies::{Elements, Space};
use crate::dynamics::parts::body::Body;
use crate::materials::{Kinematics, Material};
use crate::math::tolerances;

/// Name of the law whose stress decreases in strong compression.
const SOFTENS: &str = "saint_venant_kirchhoff";

/// Relative strain or moment due to the rotation of a linear elastic body from which a finding is reported.
pub const SPURIOUS: f64 = 0.01;

/// Rotation of a body of linear elasticity below which no finding is reported `[rad]`: its moment is less than a thousandth of the forces
/// times the size of the body, comparable to the error of small strains.
const LEAST_TURN: f64 = 0.001;

/// Body whose material law is used outside its range of validity.
#[derive(Clone, Debug, PartialEq)]
pub struct OutOfValidity {
    /// Name of the body.
    pub body: String,
    /// Kind of use outside the range of validity.
    pub kind: ExcessKind,
    /// Angle of a rotation `[rad]`, relative strain or moment, stretch, or ratio of plastic strains, depending on the kind.
    pub value: f64,
    /// The cell; for a rotated body the cell with the largest rotation.
    pub cell: usize,
    /// Rotation of the cell, of the support or of the body `[rad]`; for a hardening table its last plastic strain.
    pub angle: f64,
}

/// Kind of use of a law outside its range of validity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExcessKind {
    /// A cell of a linear elastic body has rotated; the value is the angle `[rad]`.
    Turned,
    /// Spurious strain caused by the rotation of a support, relative to the largest strain of the body.
    SpuriousStrain,
    /// Moment of the unrotated stresses about the body, relative to the moment of the rotating support.
    SpuriousMoment,
    /// A cell of Saint Venant-Kirchhoff material is crushed; the value is the least stretch.
    Crushed,
    /// Plastic flow beyond the last point of a hardening table; the value is the ratio of plastic strain to that of the last point.
    BeyondTable,
}

/// Motion of a cell.
struct CellMotion {
    rotation: Matrix3<f64>,
    stretch: Matrix3<f64>,
}

impl CellMotion {
    fn angle(&self) -> f64 {
        angle_of(&self.rotation)
    }

    /// Smallest principal stretch.
    fn least(&self) -> f64 {
        self.stretch.symmetric_eigenvalues().min()
    }

    /// Strain in the initial directions.
    fn strain(&self) -> Matrix3<f64> {
        self.stretch - Matrix3::identity()
    }
}

/// Angle of a rotation `[rad]`, accurate for small angles, where the cosine is 1 up to round-off.
fn angle_of(rotation: &Matrix3<f64>) -> f64 {
    Rotation3::from_matrix_unchecked(*rotation).scaled_axis().norm()
}

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Worst use of every linear or Saint Venant-Kirchhoff law beyond its range of validity.
    pub fn excessive_cells(&self) -> Vec<OutOfValidity> {
        let mut found = Vec::new();
        for (body, definition) in self.system.bodies.iter().zip(&self.model.bodies) {
            match definition.material.kinematics() {
                _ if body.rigid.is_some() => {}
                Kinematics::Linear => found.extend(self.turned(body)),
                _ if definition.material.name() == SOFTENS => {
                    let least = body.elements.cliques().iter().map(|nodes| self.motion_of(nodes).map_or(1.0, |motion| motion.least()));
                    let worst = least.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
                    let excess =
                        |(cell, value)| OutOfValidity { body: body.name.clone(), kind: ExcessKind::Crushed, value, cell, angle: 0.0 };
                    found.extend(worst.map(excess));
                }
                Kinematics::GreenLagrange => found.extend(self.beyond_table(body, &definition.material)),
            }
        }
        found
    }

    /// Point of a body with the largest plastic strain beyond the end of a tabulated hardening curve; `None` without one.
    fn beyond_table(&self, body: &Body<D>, material: &Material) -> Option<OutOfValidity> {
        let last = material.plasticity()?.hardening.last_strain()?;
        let (mut cell, mut value) = (0, 0.0);
        body.elements.visit_stresses(self.present(body), &mut |point| {
            let strain = point.kept.map_or(0.0, |kept| kept.plastic_strain) / last;
            if strain > value {
                (cell, value) = (point.cell, strain);
            }
        });
        Some(OutOfValidity { body: body.name.clone(), kind: ExcessKind::BeyondTable, value, cell, angle: last })
    }

    /// Worst effect of rotation on a linear elastic body: strain or moment where a support rotates, otherwise the angle.
    fn turned(&self, body: &Body<D>) -> Option<OutOfValidity> {
        let motions: Vec<CellMotion> = body.elements.cliques().iter().filter_map(|nodes| self.motion_of(nodes)).collect();
        let angles = motions.iter().map(CellMotion::angle).enumerate();
        let (cell, angle) = angles.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let excess = |kind, value, angle| OutOfValidity { body: body.name.clone(), kind, value, cell, angle };
        if angle > tolerances::TURNED {
            return Some(excess(ExcessKind::Turned, angle, angle));
        }
        let supports = self.system.supports.held.iter().zip(&self.state.row.reactions).enumerate();
        let on_body = supports.filter(|(_, (held, _))| held.first().is_some_and(|&k| body.nodes.contains(&(k / D))));
        let turned = on_body.map(|(number, (_, reaction))| (self.system.supports.turned_by(number, self.state.row.time), reaction));
        let (by, reaction) = turned.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(by, _)| *by > LEAST_TURN)?;
        let largest = motions.iter().map(|motion| motion.strain().norm()).fold(f64::MIN_POSITIVE, f64::max);
        let strain = (1.0 - by.cos()) / largest;
        if strain > SPURIOUS {
            return Some(excess(ExcessKind::SpuriousStrain, strain, by));
        }
        let nodes: Vec<u32> = body.nodes.clone().map(|node| node as u32).collect();
        let center = Vector3::from(self.center_of(&self.state.positions, &nodes));
        let moment = (Vector3::from(reaction.moment) - center.cross(&Vector3::from(reaction.force))).norm();
        let turn = Rotation3::from_matrix_unchecked(self.motion_of(&nodes)?.rotation).scaled_axis();
        Some(excess(ExcessKind::SpuriousMoment, self.spurious_moment(body, &turn) / moment.max(f64::MIN_POSITIVE), turn.norm()))
    }

    /// Moment about a body of stresses that have not rotated with it.
    fn spurious_moment(&self, body: &Body<D>, turn: &Vector3<f64>) -> f64 {
        let mut mean = Matrix3::zeros();
        body.elements.visit_stresses(self.present(body), &mut |point| {
            let [xx, yy, zz, xy, yz, zx] = point.stress;
            mean += Matrix3::new(xx, xy, zx, xy, yy, yz, zx, yz, zz) * point.volume;
        });
        if D == 2 {
            // In the plane no component of the moment is due to the normal stress across it.
            mean[(2, 2)] = 0.0;
        }
        (mean * turn - mean.trace() * turn).norm()
    }

    /// Mean place of some nodes.
    fn center_of(&self, q: &[f64], nodes: &[u32]) -> [f64; 3] {
        let mut center = [0.0; 3];
        nodes.iter().for_each(|&node| (0..D).for_each(|i| center[i] += q[node as usize * D + i] / nodes.len() as f64));
        center
    }

    /// Motion of some nodes: of a cell, or of a body.
    fn motion_of(&self, nodes: &[u32]) -> Option<CellMotion> {
        let (before, now) = (&self.system.nodes.reference, &self.state.positions);
        let (center_before, center_now) = (self.center_of(before, nodes), self.center_of(now, nodes));
        // Three dimensions in all cases: plane motions have no component across the plane.
        let (mut moved, mut own) = (SMatrix::<f64, 3, 3>::zeros(), SMatrix::<f64, 3, 3>::zeros());
        for &node in nodes {
            let place = |q: &[f64], center: [f64; 3]| -> [f64; D] { std::array::from_fn(|i| q[node as usize * D + i] - center[i]) };
            let (x, y) = (place(before, center_before), place(now, center_now));
            for i in 0..D {
                for j in 0..D {
                    moved[(i, j)] += y[i] * x[j];
                    own[(i, j)] += x[i] * x[j];
                }
            }
        }
        for i in D..3 {
            (moved[(i, i)], own[(i, i)]) = (1.0, 1.0);
        }
        let parts = (moved * own.try_inverse()?).svd(true, true);
        let (u, v_t) = (parts.u?, parts.v_t?);
        Some(CellMotion { rotation: u * v_t, stretch: v_t.transpose() * Matrix3::from_diagonal(&parts.singular_values) * v_t })
    }
}
