//! Fields of the bodies and quantities of the contacts at the present state.

use super::fields::{BodyFields, ContactFields};
use super::pairs::PairKind;
use super::time_loop::TimeLoop;
use crate::bodies::{Elements, Space};
use crate::integrators::Integrator;
use crate::math::tolerances;

impl<const D: usize> TimeLoop<D>
where
    Space<D>: Elements<D>,
{
    pub(super) fn fields_at(&self, q: &[f64]) -> Vec<BodyFields> {
        let v = &self.state.velocities;
        let nodes = self.system.nodes();
        let mut stress = vec![[0.0; 6]; nodes];
        let mut weight = vec![0.0; nodes];
        for body in &self.system.bodies {
            body.elements.project_stress(q, &mut stress, &mut weight);
        }
        let (mut pressure, mut gap) = (vec![0.0; nodes], vec![f64::NAN; nodes]);
        for pair in self.system.pairs.iter().filter(|pair| pair.kind != PairKind::Tie) {
            let (gaps, coverage) = (pair.kernel.gap(q), pair.kernel.coverage(q));
            for (local, &node) in pair.kernel.secondary().nodes().iter().enumerate() {
                pressure[node as usize] += self.state.lambda[pair.rows.start + local];
                if coverage[local] > tolerances::SLIVER {
                    gap[node as usize] = gaps[local] / (coverage[local] * pair.kernel.weights()[local]);
                }
            }
        }
        let vector = |values: &[f64], node: usize| {
            let mut vector = [0.0; 3];
            vector[..D].copy_from_slice(&values[node * D..(node + 1) * D]);
            vector
        };
        let displacement: Vec<f64> = q.iter().zip(&self.system.reference).map(|(q, x)| q - x).collect();
        self.system
            .bodies
            .iter()
            .zip(&self.model.bodies)
            .map(|(body, definition)| BodyFields {
                name: body.name.clone(),
                mesh: definition.mesh.clone(),
                displacement: body.nodes.clone().map(|node| vector(&displacement, node)).collect(),
                velocity: body.nodes.clone().map(|node| vector(v, node)).collect(),
                stress: body.nodes.clone().map(|node| stress[node].map(|s| s / weight[node])).collect(),
                contact_pressure: pressure[body.nodes.clone()].to_vec(),
                contact_gap: gap[body.nodes.clone()].to_vec(),
            })
            .collect()
    }

    pub(super) fn contact_fields(&self, name: &str) -> Option<ContactFields> {
        let pair = self.system.pairs.iter().find(|pair| pair.name == name)?;
        let q = &self.state.positions;
        let rows = pair.kernel.rows_per_node();
        let (gaps, coverage) = (per_node(&pair.kernel.gap(q), rows), pair.kernel.coverage(q));
        let secondary = pair.kernel.secondary().nodes();
        let position = |node: u32| {
            let mut x = [0.0; 3];
            x[..D].copy_from_slice(&q[node as usize * D..(node as usize + 1) * D]);
            x
        };
        let mut force = [0.0; 3];
        let lambda = &self.state.lambda[pair.rows.clone()];
        let mut evaluation = Default::default();
        pair.kernel.evaluate(Integrator::Trapezoidal, q, lambda, &mut evaluation);
        let patches = pair.kernel.patches();
        for p in (0..patches.len()).filter(|&p| evaluation.live[p]) {
            let gradients = &evaluation.gradient_end[patches.gradient_range(p)];
            for (row, gradient) in patches.rows(p).iter().zip(gradients.chunks_exact(patches.unknowns(p))) {
                for (u, node) in patches.nodes(p).iter().enumerate() {
                    if secondary.binary_search(node).is_ok() {
                        for i in 0..D {
                            force[i] += lambda[*row as usize] * gradient[u * D + i];
                        }
                    }
                }
            }
        }
        Some(ContactFields {
            positions: secondary.iter().map(|&node| position(node)).collect(),
            pressure: per_node(lambda, rows),
            gap: (0..secondary.len())
                .map(|k| {
                    let (covered, weight) = (coverage[k * rows], pair.kernel.weights()[k * rows]);
                    if covered > tolerances::SLIVER { gaps[k] / (covered * weight) } else { f64::NAN }
                })
                .collect(),
            active: self.state.active[pair.rows.clone()].chunks_exact(rows).map(|rows| rows.contains(&true)).collect(),
            force,
        })
    }
}

/// One number for each node from its constraint rows: the row itself, or the length of the vector that several are.
fn per_node(values: &[f64], rows: usize) -> Vec<f64> {
    match rows {
        1 => values.to_vec(),
        _ => values.chunks_exact(rows).map(|vector| vector.iter().map(|x| x * x).sum::<f64>().sqrt()).collect(),
    }
}
