//! Loads and prescribed motion: what time functions do to the nodes of a boundary.

use super::amplitude::Amplitude;
use super::error::StepError;
use super::model::LoadKind;
use super::system::System;
use crate::bodies::{Elements, Space, torque_forces};
use crate::linear::Block;

/// A load with its nodal weights.
pub(super) struct NodalLoad {
    pub(super) kind: LoadKind,
    pub(super) weights: Vec<(u32, f64)>,
    /// Facets of a pressure with the places of their blocks, row by row.
    pub(super) facets: Vec<([u32; 2], [Block; 4])>,
    pub(super) amplitude: Amplitude,
    pub(super) name: String,
}

/// A displacement component that follows a time function.
pub(super) struct PrescribedUnknown {
    pub(super) unknown: usize,
    /// Index of the time function in [`System::prescriptions`].
    pub(super) function: usize,
}

impl<const D: usize> System<D>
where
    Space<D>: Elements<D>,
{
    /// What the time function of a load gives; it may fail.
    pub(super) fn amplitude(&self, load: &NodalLoad, time: f64) -> Result<f64, StepError> {
        let failed = |source| StepError::Amplitude { boundary: load.name.clone(), time, source };
        let amplitude = load.amplitude.value(time).map_err(failed)?;
        if amplitude.is_finite() { Ok(amplitude) } else { Err(failed(format!("the time function returned {amplitude}").into())) }
    }

    /// Adds the forces of a load with an amplitude.
    pub(super) fn load_into(&self, load: &NodalLoad, amplitude: f64, q: &[f64], force: &mut [f64]) {
        match load.kind {
            LoadKind::Pressure(pressure) => {
                for ([a, b], _) in &load.facets {
                    let (a, b) = (*a as usize * D, *b as usize * D);
                    // Against the outward normal, which is the facet's direction turned to the right.
                    let half = [-0.5 * amplitude * pressure * (q[b + 1] - q[a + 1]), 0.5 * amplitude * pressure * (q[b] - q[a])];
                    for node in [a, b] {
                        force[node] += half[0];
                        force[node + 1] += half[1];
                    }
                }
            }
            LoadKind::Torque => torque_forces::<D>(&load.weights, q, amplitude, force),
            LoadKind::Traction(vector) => spread::<D>(&load.weights, vector, amplitude, force),
            LoadKind::Force(vector) => {
                let area: f64 = load.weights.iter().map(|(_, weight)| weight).sum();
                spread::<D>(&load.weights, vector, amplitude / area, force);
            }
        }
    }

    /// Loads at a configuration and time, gravity not included; a time function may fail.
    pub(super) fn loads_into(&self, q: &[f64], time: f64, force: &mut [f64]) -> Result<bool, StepError> {
        let mut acted = false;
        for load in &self.loads {
            let amplitude = self.amplitude(load, time)?;
            acted |= amplitude != 0.0;
            self.load_into(load, amplitude, q, force);
        }
        Ok(acted)
    }

    /// Displacements and velocities of the prescribed unknowns at a time.
    pub(super) fn prescribed_motion(&self, time: f64) -> Result<(Vec<f64>, Vec<f64>), StepError> {
        let mut functions = Vec::with_capacity(self.prescriptions.len());
        for (function, boundary) in &self.prescriptions {
            let failed = |source| StepError::Amplitude { boundary: boundary.clone(), time, source };
            let (value, rate) = (function.value(time).map_err(failed)?, function.rate(time).map_err(failed)?);
            if !value.is_finite() || !rate.is_finite() {
                return Err(failed(format!("the time function returned {value} with rate {rate}").into()));
            }
            functions.push((value, rate));
        }
        Ok(self.prescribed.iter().map(|prescribed| functions[prescribed.function]).unzip())
    }

    /// Subtracts the derivative of the pressures' forces, which turn with their facets.
    pub(super) fn add_pressure_tangent(&mut self, time: f64, share: f64) -> Result<(), StepError> {
        for load in &self.loads {
            let LoadKind::Pressure(pressure) = load.kind else { continue };
            let failed = |source| StepError::Amplitude { boundary: load.name.clone(), time, source };
            let half = 0.5 * share * pressure * load.amplitude.value(time).map_err(failed)?;
            for (_, blocks) in &load.facets {
                for row in 0..2 {
                    for (column, sign) in [(0, -1.0), (1, 1.0)] {
                        let block = blocks[2 * row + column];
                        self.values[block.at(0, 1)] += sign * half;
                        self.values[block.at(1, 0)] -= sign * half;
                    }
                }
            }
        }
        Ok(())
    }
}

fn spread<const D: usize>(weights: &[(u32, f64)], vector: [f64; 3], factor: f64, force: &mut [f64]) {
    for &(node, weight) in weights {
        for i in 0..D {
            force[node as usize * D + i] += factor * weight * vector[i];
        }
    }
}
