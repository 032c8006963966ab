//! Loads: forces on the nodes of a boundary whose magnitude follows a time function.

use super::time_values::value_of;
use crate::bodies::{Plane, face_pressure, face_pressure_arms, pressure_shares, round_pressure, torque_forces};
use crate::dynamics::model::amplitude::Amplitude;
use crate::dynamics::model::definitions::LoadKind;
use crate::dynamics::model::part::{Iterate, Part, Refusal, Sums};
use crate::dynamics::model::step_error::StepError;
use crate::linear::{Block, Pattern};

/// A load with its nodal weights.
pub struct NodalLoad<const D: usize> {
    /// Kind of the load.
    pub kind: LoadKind,
    /// Nodes with their shares of the boundary.
    pub weights: Vec<(u32, f64)>,
    /// Facets of a pressure by their nodes, each with its matrix blocks, row by row.
    pub facets: Vec<(Vec<u32>, Vec<Block>)>,
    /// True if a cell couples the nodes of each facet, as in deformable bodies.
    pub is_on_cells: bool,
    /// Plane strain, plane stress or axisymmetric.
    pub plane: Plane,
    /// Amplitude over time.
    pub amplitude: Amplitude,
    /// Name `body.boundary` of the loaded boundary.
    pub name: String,
}

impl<const D: usize> NodalLoad<D> {
    /// Value of the amplitude at a time.
    ///
    /// # Errors
    /// The time function failed or returned a value that is not finite.
    pub fn amplitude(&self, time: f64) -> Result<f64, StepError> {
        value_of(&self.name, &self.amplitude, time)
    }

    /// Adds the forces of the load with an amplitude.
    pub fn force_into(&self, amplitude: f64, q: &[f64], force: &mut [f64]) {
        match self.kind {
            LoadKind::Pressure(pressure) if self.plane == Plane::Axisymmetric => {
                let size = amplitude * pressure;
                for (nodes, _) in &self.facets {
                    for (&a, part) in nodes.iter().zip(round_pressure(&places::<2>(nodes, q)).0) {
                        (0..2).for_each(|i| force[a as usize * D + i] += size * part[i]);
                    }
                }
            }
            LoadKind::Pressure(pressure) if D == 3 => {
                let size = amplitude * pressure;
                for (nodes, _) in &self.facets {
                    for (&a, part) in nodes.iter().zip(face_pressure(&places::<3>(nodes, q))) {
                        (0..3).for_each(|i| force[a as usize * D + i] += size * part[i]);
                    }
                }
            }
            LoadKind::Pressure(pressure) => {
                let size = amplitude * pressure;
                for (nodes, _) in &self.facets {
                    for (&a, shares) in nodes.iter().zip(pressure_shares(nodes.len())) {
                        // The shares sum to zero: only differences of positions enter.
                        let at = |node: u32, i: usize| q[node as usize * D + i];
                        let along = |i: usize| {
                            nodes[1..].iter().zip(&shares[1..]).map(|(&b, share)| share * (at(b, i) - at(nodes[0], i))).sum::<f64>()
                        };
                        // Against the outward normal, the edge direction rotated to the right.
                        force[a as usize * D] -= size * along(1);
                        force[a as usize * D + 1] += size * along(0);
                    }
                }
            }
            LoadKind::Torque(axis) => torque_forces::<D>(&self.weights, q, axis.map(|x| amplitude * x), force),
            LoadKind::Traction(vector) => self.spread(vector, amplitude, force),
            LoadKind::Force(vector) => {
                let area: f64 = self.weights.iter().map(|(_, weight)| weight).sum();
                self.spread(vector, amplitude / area, force);
            }
        }
    }

    fn spread(&self, vector: [f64; 3], factor: f64, force: &mut [f64]) {
        for &(node, weight) in &self.weights {
            for i in 0..D {
                force[node as usize * D + i] += factor * weight * vector[i];
            }
        }
    }

    /// Subtracts the derivative of the forces of a pressure, which rotate with the facets; `share` is the derivative of the configuration
    /// with respect to `q_1`.
    fn tangent_into(&self, amplitude: f64, share: f64, q: &[f64], values: &mut [f64]) {
        let LoadKind::Pressure(pressure) = self.kind else { return };
        let size = share * pressure * amplitude;
        if self.plane == Plane::Axisymmetric {
            for (nodes, blocks) in &self.facets {
                let slope = round_pressure(&places::<2>(nodes, q)).1;
                for (k, block) in blocks.iter().enumerate() {
                    let slope = slope[k / nodes.len()][k % nodes.len()];
                    (0..4).for_each(|c| values[block.at(c / 2, c % 2)] -= size * slope[c / 2][c % 2]);
                }
            }
            return;
        }
        if D == 3 {
            for (nodes, blocks) in &self.facets {
                let arms = face_pressure_arms(&places::<3>(nodes, q));
                for (k, block) in blocks.iter().enumerate() {
                    let arm = arms[k / nodes.len()][k % nodes.len()];
                    for i in 0..3 {
                        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                        values[block.at(i, j)] += size * arm[k];
                        values[block.at(i, k)] -= size * arm[j];
                    }
                }
            }
            return;
        }
        for (nodes, blocks) in &self.facets {
            let shares = pressure_shares(nodes.len()).iter().copied().flatten();
            for (block, share) in blocks.iter().zip(shares) {
                values[block.at(0, 1)] += share * size;
                values[block.at(1, 0)] -= share * size;
            }
        }
    }
}

/// Positions of nodes.
fn places<const D: usize>(nodes: &[u32], q: &[f64]) -> Vec<[f64; D]> {
    nodes.iter().map(|&node| std::array::from_fn(|i| q[D * node as usize + i])).collect()
}

impl<const D: usize> Part for NodalLoad<D> {
    fn for_each_coupling(&self, visit: &mut dyn FnMut(&[u32])) {
        if !self.is_on_cells {
            self.facets.iter().for_each(|(nodes, _)| visit(nodes));
        }
    }

    fn place(&mut self, pattern: &Pattern) {
        for (facet, blocks) in &mut self.facets {
            *blocks = facet.iter().flat_map(|&a| facet.iter().map(move |&b| pattern.block(a, b))).collect();
        }
    }

    fn linearize(&self, at: &Iterate, _memory: &[f64], sums: &mut Sums) -> Result<(), Refusal> {
        let amplitude = self.amplitude(at.time).map_err(Refusal::Load)?;
        self.force_into(amplitude, at.q_test, sums.load);
        if let Some(values) = sums.tangent.as_deref_mut() {
            self.tangent_into(amplitude, at.derivative.placement().share * at.weight, at.q_test, values);
        }
        Ok(())
    }
}

/// Adds the forces of all loads at a configuration and time; returns true if a load acts.
///
/// # Errors
/// A time function failed.
pub fn loads_into<const D: usize>(loads: &[NodalLoad<D>], q: &[f64], time: f64, force: &mut [f64]) -> Result<bool, StepError> {
    let mut acted = false;
    for load in loads {
        let amplitude = load.amplitude(time)?;
        acted |= amplitude != 0.0;
        load.force_into(amplitude, q, force);
    }
    Ok(acted)
}
