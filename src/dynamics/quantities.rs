//! Fields of the bodies and quantities of the contacts at the present state.

use super::contact_quantities::{contact_fields, pair_forces, totals};
use super::fields::{BodyFields, ContactFields};
use super::ledger::{ContactTotals, ProbeValues};
use super::pairs::{Pair, PairKind};
use super::time_loop::TimeLoop;
use crate::bodies::{Elements, Space};
use crate::contact::Evaluation;
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
        let (mut contact_force, mut contact_active) = (vec![[0.0; 3]; nodes], vec![0.0; nodes]);
        for pair in self.system.pairs.iter().filter(|pair| pair.kind != PairKind::Tie) {
            let (gaps, coverage) = (pair.kernel.gap(q), pair.kernel.coverage(q));
            let lambda = &self.state.lambda[pair.rows.clone()];
            let mut evaluation = Evaluation::default();
            pair.kernel.evaluate(Integrator::Trapezoidal, q, lambda, &mut evaluation);
            for (node, force) in pair_forces::<D>(pair, &evaluation, lambda).all {
                (0..3).for_each(|i| contact_force[node as usize][i] += force[i]);
            }
            for (local, &node) in pair.kernel.secondary().nodes().iter().enumerate() {
                pressure[node as usize] += lambda[local];
                if self.state.active[pair.rows.start + local] {
                    contact_active[node as usize] = 1.0;
                }
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
                contact_force: contact_force[body.nodes.clone()].to_vec(),
                contact_active: contact_active[body.nodes.clone()].to_vec(),
            })
            .collect()
    }

    pub(super) fn contact_fields(&self, name: &str) -> Option<ContactFields> {
        let pair = self.system.pairs.iter().find(|pair| pair.name == name)?;
        Some(contact_fields::<D>(pair, &self.state))
    }

    /// Sums over each contact pair with what Newton's method evaluated last, at `q`.
    pub(super) fn contact_totals(&self, q: &[f64], lambda: &[f64], active: &[bool]) -> Vec<ContactTotals> {
        let of = |pair: &Pair| totals::<D>(pair, &pair.evaluation, &lambda[pair.rows.clone()], &active[pair.rows.clone()], q);
        self.system.pairs.iter().map(of).collect()
    }

    /// Displacement and velocity of the watched nodes.
    pub(super) fn probe_values(&self, q: &[f64], v: &[f64]) -> Vec<ProbeValues> {
        let values = |&node: &usize| {
            let mut values = ProbeValues::default();
            for i in 0..D {
                values.displacement[i] = q[node * D + i] - self.system.reference[node * D + i];
                values.velocity[i] = v[node * D + i];
            }
            values
        };
        self.probes.iter().map(values).collect()
    }
}
