//! Laws beyond what they are made for: linear elasticity that turns, Saint Venant-Kirchhoff material that is crushed.
//!
//! Both go on to compute without a sign of it. What a cell has done follows from its nodes: the deformation gradient that fits their motion
//! best, `F = sum dx dX^T (sum dX dX^T)^-1`, split into rotation and stretches.

use nalgebra::SMatrix;

use super::engine::Engine;
use crate::bodies::{Elements, Space};
use crate::materials::Kinematics;

/// Name of the law that softens in compression.
const SOFTENS: &str = "saint_venant_kirchhoff";

/// A body whose law is used beyond its range.
#[derive(Clone, Debug, PartialEq)]
pub struct Excess {
    /// The body.
    pub body: String,
    /// What it has done.
    pub kind: ExcessKind,
    /// The angle of a rotation, or the least stretch.
    pub value: f64,
    /// The cell.
    pub cell: usize,
}

/// How a law is used beyond its range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExcessKind {
    /// A cell of a linear law has turned.
    Turned,
    /// A cell of Saint Venant-Kirchhoff material is crushed.
    Crushed,
}

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// The cell that has turned most of each body with a linear law, and the one that is crushed most of each with that of Saint Venant and
    /// Kirchhoff.
    pub fn excessive_cells(&self) -> Vec<Excess> {
        let mut found = Vec::new();
        for (body, definition) in self.system.bodies.iter().zip(&self.model.bodies) {
            let kind = match definition.material.kinematics() {
                _ if body.rigid.is_some() => continue,
                Kinematics::Linear => ExcessKind::Turned,
                _ if definition.material.name() == SOFTENS => ExcessKind::Crushed,
                Kinematics::GreenLagrange => continue,
            };
            let motions = body.elements.cliques().iter().map(|nodes| self.cell_motion(nodes));
            let values = motions.map(|(turned, least)| if kind == ExcessKind::Turned { turned } else { -least }).enumerate();
            if let Some((cell, value)) = values.max_by(|a, b| a.1.total_cmp(&b.1)) {
                found.push(Excess { body: body.name.clone(), kind, value: value.abs(), cell });
            }
        }
        found
    }

    /// Angle of the rotation of a cell, and its least stretch.
    fn cell_motion(&self, nodes: &[u32]) -> (f64, f64) {
        let place = |q: &[f64], node: u32| -> [f64; D] { std::array::from_fn(|i| q[node as usize * D + i]) };
        let mean = |q: &[f64]| -> [f64; D] {
            let sum = nodes.iter().map(|&node| place(q, node)).fold([0.0; D], |sum, x| std::array::from_fn(|i| sum[i] + x[i]));
            sum.map(|x| x / nodes.len() as f64)
        };
        let (before, now) = (&self.system.nodes.reference, &self.state.positions);
        let (center_before, center_now) = (mean(before), mean(now));
        // In space of three dimensions always: what is plane stays in its plane.
        let (mut moved, mut own) = (SMatrix::<f64, 3, 3>::zeros(), SMatrix::<f64, 3, 3>::zeros());
        for &node in nodes {
            let (x, y) = (place(before, node), place(now, node));
            for i in 0..D {
                for j in 0..D {
                    let arm = x[j] - center_before[j];
                    moved[(i, j)] += (y[i] - center_now[i]) * arm;
                    own[(i, j)] += (x[i] - center_before[i]) * arm;
                }
            }
        }
        for i in D..3 {
            (moved[(i, i)], own[(i, i)]) = (1.0, 1.0);
        }
        let Some(inverse) = own.try_inverse() else { return (0.0, 1.0) };
        let parts = (moved * inverse).svd(true, true);
        let (Some(u), Some(v)) = (parts.u, parts.v_t) else { return (0.0, 1.0) };
        let cosine = 0.5 * ((u * v).trace() - 1.0);
        (cosine.clamp(-1.0, 1.0).acos(), parts.singular_values.min())
    }
}
