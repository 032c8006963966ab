//! A gas chamber enclosed by surfaces of bodies: a follower pressure with a potential.
//!
//! The energy is a function of the enclosed volume, `U(V) = p_a (V - V_r) - int p dV` with the gas law `p (V/V_r)^n = p_r` and the ambient
//! pressure `p_a`. The volume is a polynomial of the positions, of degree two in the plane (area per thickness) and three in space and
//! around an axis; its gradient `g` are the forces of a unit pressure. Over a step with `d = q_1 - q_0`
//!
//! ```text
//! V_1 - V_0 = Gbar.d     Gbar = g(q_mid)                        in the plane
//!                        Gbar = g(q_mid) + g(d)/12              around an axis: the integral of g along the step, by Simpson's rule exact
//!                        Gbar = g(q_mid) + V(d)/4 p/(p.p)       in space, p = d without its rigid motion of q_mid (Gonzalez 2000)
//! force = P Gbar         P = -(U(V_1) - U(V_0)) / (V_1 - V_0)
//! ```
//!
//! with `V(d)` and `g(d)` for the increment in place of positions. `P` is computed with `ln_1p` and `exp_m1`, without cancellation. The
//! work of the forces equals the change of `U`, and forces of a closed surface conserve linear and angular momentum. The volume couples all
//! nodes of the surface: they have a full block in the matrix.

use std::collections::HashMap;
use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use crate::bodies::{face_pressure, face_pressure_arms, pressure_shares, round_pressure};
use crate::dynamics::model::error::ModelError;
use crate::dynamics::model::part::{Change, Iterate, Numbering, Part, PartDefinition, Pose, Refusal, Sums};
use crate::dynamics::model::quantity::Quantity;
use crate::integrators::{Configuration, Derivative};
use crate::linear::{Block, Pattern};
use crate::math::tolerances::{PROJECTED_INCREMENT, VOLUME_CHANGE};

/// Polytropic gas: `p (V/V_r)^n = p_r`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gas {
    /// Pressure `p_r` at the volume `V_r` `[stress]`.
    pub pressure: f64,
    /// Volume `V_r` `[volume]` (area in the plane).
    pub volume: f64,
    /// Exponent `n`: 1 at constant temperature, the ratio of the heat capacities for adiabatic changes.
    pub exponent: f64,
    /// Ambient pressure `[stress]`.
    pub ambient: f64,
}

impl Gas {
    /// Pressure at a volume `[stress]`.
    pub(crate) fn pressure_at(&self, volume: f64) -> f64 {
        self.pressure * (-self.exponent * (volume / self.volume).ln()).exp()
    }

    /// Stored energy at the volume `V_r + change`, including the work against the ambient pressure `[energy]`.
    pub fn energy(&self, change: f64) -> f64 {
        let (growth, a) = ((change / self.volume).ln_1p(), 1.0 - self.exponent);
        let expanded = if a == 0.0 { growth } else { (a * growth).exp_m1() / a };
        self.ambient * change - self.pressure * self.volume * expanded
    }

    /// Mean pressure above the ambient one between a volume and one larger by `change`, and its derivative with respect to the latter.
    fn mean(&self, volume: f64, change: f64) -> (f64, f64) {
        let (x, a) = (change / volume, 1.0 - self.exponent);
        let at_start = self.pressure_at(volume);
        let share = if x == 0.0 {
            1.0
        } else if a == 0.0 {
            x.ln_1p() / x
        } else {
            (a * x.ln_1p()).exp_m1() / (a * x)
        };
        let mean = at_start * share;
        let slope = if x.abs() > VOLUME_CHANGE {
            (self.pressure_at(volume + change) - mean) / change
        } else {
            // int s p'(V + s dV) ds: the mean of s is at two thirds.
            0.5 * self.slope_at(volume + 2.0 / 3.0 * change)
        };
        (mean - self.ambient, slope)
    }

    fn slope_at(&self, volume: f64) -> f64 {
        -self.exponent * self.pressure_at(volume) / volume
    }
}

/// A chamber of gas.
#[derive(Clone, Debug, PartialEq)]
pub struct ChamberDefinition {
    /// Name, unique among the parts.
    pub name: String,
    /// Facets around the chamber: body, and nodes of its mesh.
    pub facets: Vec<(usize, Vec<u32>)>,
    /// Space dimension of the bodies.
    pub dimension: usize,
    /// True if the bodies are axisymmetric.
    pub is_round: bool,
    /// Gas law; a volume of 0 stands for the volume in the undeformed bodies.
    pub gas: Gas,
    /// For open surfaces: a point in the planes (in the plane: lines) of all rims, which must stay in them; `None` for closed ones.
    pub rim_point: Option<[f64; 3]>,
}

impl ChamberDefinition {
    /// Number of corners of a facet with `count` nodes.
    fn corners(&self, count: usize) -> usize {
        match (self.dimension, count) {
            (2, _) => 2,
            (_, 3 | 6) => 3,
            _ => 4,
        }
    }

    /// Node of a rim, at which the surface is open; `None` for closed surfaces.
    fn open_at(&self, point: &dyn Fn(usize, u32) -> [f64; 3]) -> Option<[f64; 3]> {
        let mut balance: HashMap<(usize, u32, u32), i32> = HashMap::new();
        let mut order = Vec::new();
        for (body, nodes) in &self.facets {
            let corners = self.corners(nodes.len());
            for k in 0..corners {
                let (a, b) = (nodes[k], nodes[(k + 1) % corners]);
                // Ends of edges in the plane, edges of faces in space.
                let (key, sign) = match self.dimension {
                    2 => ((*body, a, a), if k == 0 { 1 } else { -1 }),
                    _ => ((*body, a.min(b), a.max(b)), if a < b { 1 } else { -1 }),
                };
                order.push(key);
                *balance.entry(key).or_insert(0) += sign;
            }
        }
        let is_open = |key: &&(usize, u32, u32)| {
            let is_on_axis = self.is_round && point(key.0, key.1)[0].abs() <= PROJECTED_INCREMENT;
            balance[key] != 0 && !is_on_axis
        };
        order.iter().find(is_open).map(|key| point(key.0, key.1))
    }

    fn kernel(&self, numbering: &Numbering) -> Chamber {
        let (mut nodes, mut number): (Vec<u32>, HashMap<u32, usize>) = (Vec::new(), HashMap::new());
        let mut facets = Vec::with_capacity(self.facets.len());
        for (body, of_mesh) in &self.facets {
            let local = of_mesh.iter().map(|&node| {
                let node = numbering.first[*body] as u32 + node;
                *number.entry(node).or_insert_with(|| {
                    nodes.push(node);
                    nodes.len() - 1
                })
            });
            facets.push(local.collect());
        }
        let (dimension, is_round) = (numbering.dimension, self.is_round);
        let (gas, rim_point, places) = (self.gas, self.rim_point, Vec::new());
        let mut chamber = Chamber { dimension, is_round, nodes, facets, gas, rim_point, rest: Vec::new(), rest_volume: 0.0, places };
        chamber.rest = chamber.own(numbering.reference);
        chamber.rest_volume = chamber.polynomial(&chamber.rest);
        if self.gas.volume == 0.0 {
            chamber.gas.volume = chamber.rest_volume;
        }
        chamber
    }
}

impl PartDefinition for ChamberDefinition {
    fn name(&self) -> &str {
        &self.name
    }

    fn bodies(&self) -> Vec<usize> {
        let mut bodies: Vec<usize> = self.facets.iter().map(|(body, _)| *body).collect();
        bodies.dedup();
        bodies
    }

    fn readings(&self) -> &'static [Quantity] {
        const READINGS: &[Quantity] =
            &[Quantity::new("volume", "volume"), Quantity::new("pressure", "stress"), Quantity::new("energy", "energy")];
        READINGS
    }

    fn check(&self, point: &dyn Fn(usize, u32) -> [f64; 3]) -> Result<(), ModelError> {
        let dimension = self.dimension;
        if let (None, Some(place)) = (self.rim_point, self.open_at(point)) {
            return Err(ModelError::OpenChamber { chamber: self.name.clone(), place });
        }
        let most = self.facets.iter().map(|(body, nodes)| (*body, nodes.iter().max().copied().unwrap_or(0)));
        let (mut first, mut reference) = (Vec::new(), Vec::new());
        let bodies = most.clone().map(|(body, _)| body).max().map_or(0, |body| body + 1);
        for body in 0..bodies {
            first.push(reference.len() / dimension);
            let count = most.clone().filter(|(other, _)| *other == body).map(|(_, node)| node + 1).max().unwrap_or(0);
            (0..count).for_each(|node| reference.extend_from_slice(&point(body, node)[..dimension]));
        }
        let chamber = self.kernel(&Numbering { dimension, first: &first, reference: &reference });
        let volume = chamber.rest_volume;
        if volume > 0.0 { Ok(()) } else { Err(ModelError::ChamberOfNoVolume { chamber: self.name.clone(), volume }) }
    }

    fn part(&self, numbering: &Numbering) -> Box<dyn Part> {
        Box::new(self.kernel(numbering))
    }

    fn changed(&self, change: &Change) -> Arc<dyn PartDefinition> {
        let [mass, length, time] = change.units;
        let (stress, volume) = (mass / (length * time * time), if change.is_plane { length * length } else { length.powi(3) });
        let Gas { pressure, volume: of_gas, exponent, ambient } = self.gas;
        Arc::new(ChamberDefinition {
            gas: Gas { pressure: pressure * stress, volume: of_gas * volume, exponent, ambient: ambient * stress },
            rim_point: self.rim_point.map(|point| (change.point)(point)),
            ..self.clone()
        })
    }

    fn describe(&self) -> String {
        let Gas { pressure, exponent, ambient, .. } = self.gas;
        format!(
            "gas chamber \"{}\": {} facets, pressure {pressure}, exponent {exponent}, pressure outside {ambient}",
            self.name,
            self.facets.len()
        )
    }
}

/// A chamber in global node numbers.
struct Chamber {
    dimension: usize,
    is_round: bool,
    /// Nodes of the surface.
    nodes: Vec<u32>,
    /// Facets as indices into `nodes`.
    facets: Vec<Vec<usize>>,
    gas: Gas,
    rim_point: Option<[f64; 3]>,
    /// Positions of the chamber's nodes in the undeformed bodies `[length]`.
    rest: Vec<f64>,
    /// Volume in the undeformed bodies.
    rest_volume: f64,
    /// Blocks of the nodes, row by row.
    places: Vec<Block>,
}

/// Visitor of the entries of a gradient's derivative: indices of both nodes, components, value.
type Visit<'a> = &'a mut dyn FnMut([usize; 2], [usize; 2], f64);

/// Discrete gradient of the volume over a step.
struct VolumeStep {
    gradient: Vec<f64>,
    change: f64,
    /// In space the increment without its rigid motion, `e = V(d)/4/(p.p)`, and `1/(p.p)`.
    projected: Option<(Vec<f64>, f64, f64)>,
}

impl Chamber {
    /// Positions of the chamber's nodes, collected from all positions.
    fn own(&self, q: &[f64]) -> Vec<f64> {
        let d = self.dimension;
        self.nodes.iter().flat_map(|&node| q[node as usize * d..(node as usize + 1) * d].iter().copied()).collect()
    }

    fn points<const D: usize>(&self, facet: &[usize], x: &[f64]) -> Vec<[f64; D]> {
        facet.iter().map(|&node| std::array::from_fn(|i| x[node * D + i])).collect()
    }

    /// Gradient of the volume: forces of a unit pressure on the surface, for these positions of its nodes.
    fn gradient(&self, x: &[f64]) -> Vec<f64> {
        let (d, mut sum) = (self.dimension, vec![0.0; x.len()]);
        for facet in &self.facets {
            if d == 3 {
                let forces = face_pressure(&self.points::<3>(facet, x));
                facet.iter().zip(forces).for_each(|(&node, force)| (0..3).for_each(|i| sum[node * 3 + i] += force[i]));
            } else if self.is_round {
                let forces = round_pressure(&self.points::<2>(facet, x)).0;
                facet.iter().zip(forces).for_each(|(&node, force)| (0..2).for_each(|i| sum[node * 2 + i] += force[i]));
            } else {
                for (&node, shares) in facet.iter().zip(pressure_shares(facet.len())) {
                    let first = facet[0];
                    let along = |i: usize| -> f64 {
                        facet[1..].iter().zip(&shares[1..]).map(|(&other, share)| share * (x[other * 2 + i] - x[first * 2 + i])).sum()
                    };
                    sum[node * 2] -= along(1);
                    sum[node * 2 + 1] += along(0);
                }
            }
        }
        sum
    }

    /// Visits the entries of the derivative of the volume gradient.
    fn slopes(&self, x: &[f64], visit: Visit) {
        for facet in &self.facets {
            let pairs = || (0..facet.len()).flat_map(|a| (0..facet.len()).map(move |b| (a, b)));
            if self.dimension == 3 {
                let arms = face_pressure_arms(&self.points::<3>(facet, x));
                for (a, b) in pairs() {
                    let (arm, nodes) = (arms[a][b], [facet[a], facet[b]]);
                    for i in 0..3 {
                        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                        visit(nodes, [i, j], -arm[k]);
                        visit(nodes, [i, k], arm[j]);
                    }
                }
            } else if self.is_round {
                let slope = round_pressure(&self.points::<2>(facet, x)).1;
                for (a, b) in pairs() {
                    (0..4).for_each(|c| visit([facet[a], facet[b]], [c / 2, c % 2], slope[a][b][c / 2][c % 2]));
                }
            } else {
                let shares = pressure_shares(facet.len());
                for (a, b) in pairs() {
                    visit([facet[a], facet[b]], [0, 1], -shares[a][b]);
                    visit([facet[a], facet[b]], [1, 0], shares[a][b]);
                }
            }
        }
    }

    /// Enclosed volume at given positions of the chamber's nodes, with the accuracy of its change from the initial volume.
    fn volume(&self, x: &[f64]) -> f64 {
        self.rest_volume + self.change(&self.rest, x)
    }

    /// Change of the volume between two configurations, accurate relative to its own size.
    fn change(&self, x_0: &[f64], x_1: &[f64]) -> f64 {
        let middle: Vec<f64> = x_0.iter().zip(x_1).map(|(a, b)| 0.5 * (a + b)).collect();
        let moved: Vec<f64> = x_0.iter().zip(x_1).map(|(a, b)| b - a).collect();
        let along = |gradient: &[f64]| gradient.iter().zip(&moved).map(|(g, d)| g * d).sum::<f64>();
        let linear = along(&self.gradient(&middle));
        if self.dimension == 2 && !self.is_round { linear } else { linear + along(&self.gradient(&moved)) / 12.0 }
    }

    /// Enclosed volume by Gauss's theorem.
    fn polynomial(&self, x: &[f64]) -> f64 {
        let (d, g) = (self.dimension, self.gradient(x));
        if self.is_round {
            return 0.5 * x.iter().zip(&g).step_by(2).map(|(r, g)| r * g).sum::<f64>();
        }
        // For a closed surface any point serves; one in the middle loses no digits.
        let mut middle = [0.0; 3];
        match self.rim_point {
            Some(point) => middle = point,
            None => x.chunks_exact(d).for_each(|x| (0..d).for_each(|i| middle[i] += x[i] / self.nodes.len() as f64)),
        }
        x.iter().zip(&g).enumerate().map(|(k, (x, g))| (x - middle[k % d]) * g).sum::<f64>() / d as f64
    }

    /// Discrete gradient of the volume between two configurations of the chamber's nodes.
    fn step(&self, x_0: &[f64], x_1: &[f64]) -> VolumeStep {
        let middle: Vec<f64> = x_0.iter().zip(x_1).map(|(a, b)| 0.5 * (a + b)).collect();
        let moved: Vec<f64> = x_0.iter().zip(x_1).map(|(a, b)| b - a).collect();
        let (mut gradient, mut projected) = (self.gradient(&middle), None);
        if self.dimension == 3 && self.rim_point.is_none() {
            let (p, size) = without_rigid_motion(&middle, &moved);
            let square: f64 = p.iter().map(|p| p * p).sum();
            let of_increment = moved.iter().zip(self.gradient(&moved)).map(|(d, g)| d * g).sum::<f64>() / 3.0;
            if square > PROJECTED_INCREMENT * PROJECTED_INCREMENT * size {
                let e = 0.25 * of_increment / square;
                gradient.iter_mut().zip(&p).for_each(|(g, p)| *g += e * p);
                projected = Some((p, e, 1.0 / square));
            }
        } else if self.dimension == 3 || self.is_round {
            gradient.iter_mut().zip(self.gradient(&moved)).for_each(|(g, of_moved)| *g += of_moved / 12.0);
        }
        let change = gradient.iter().zip(&moved).map(|(g, d)| g * d).sum();
        VolumeStep { gradient, change, projected }
    }

    /// Adds the derivative `-P dGbar/dq_1` of the forces of a step at a fixed pressure `P`.
    fn slopes_of_step(&self, x_0: &[f64], x_1: &[f64], step: &VolumeStep, pressure: f64, add: Visit) {
        let middle: Vec<f64> = x_0.iter().zip(x_1).map(|(a, b)| 0.5 * (a + b)).collect();
        self.slopes(&middle, &mut |nodes, components, slope| add(nodes, components, -0.5 * pressure * slope));
        if self.dimension == 2 && !self.is_round {
            return;
        }
        let moved: Vec<f64> = x_0.iter().zip(x_1).map(|(a, b)| b - a).collect();
        let Some((p, e, inverse)) = &step.projected else {
            if self.rim_point.is_some() || self.is_round {
                self.slopes(&moved, &mut |nodes, components, slope| add(nodes, components, -pressure / 12.0 * slope));
            }
            return;
        };
        // Derivative of p with respect to its own node only; contributions of mean and rotation are of higher order in the step.
        let of_moved = self.gradient(&moved);
        let de: Vec<f64> = of_moved.iter().zip(p).map(|(g, p)| inverse * (0.25 * g - 2.0 * e * p)).collect();
        self.add_product(p, &de, -pressure, add);
        (0..self.nodes.len()).for_each(|node| (0..3).for_each(|i| add([node, node], [i, i], -pressure * e)));
    }

    /// Adds the product `factor a (x) b` of nodal vectors.
    fn add_product(&self, a: &[f64], b: &[f64], factor: f64, add: Visit) {
        let (d, count) = (self.dimension, self.nodes.len());
        for (row, column) in (0..count).flat_map(|row| (0..count).map(move |column| (row, column))) {
            for i in 0..d {
                (0..d).for_each(|j| add([row, column], [i, j], factor * a[row * d + i] * b[column * d + j]));
            }
        }
    }
}

/// Increments of nodes without the rigid motion that fits them best, and sum of the squared distances of the nodes from their mean.
fn without_rigid_motion(x: &[f64], moved: &[f64]) -> (Vec<f64>, f64) {
    let share = 3.0 / x.len() as f64;
    let vector = |x: &[f64]| Vector3::new(x[0], x[1], x[2]);
    let mean = |all: &[f64]| all.chunks_exact(3).map(vector).sum::<Vector3<f64>>() * share;
    let (center, drift) = (mean(x), mean(moved));
    let (mut inertia, mut moment, mut size) = (Matrix3::zeros(), Vector3::zeros(), 0.0);
    let pairs = || x.chunks_exact(3).zip(moved.chunks_exact(3)).map(|(x, d)| (vector(x) - center, vector(d) - drift));
    for (r, d) in pairs() {
        size += r.norm_squared();
        inertia += Matrix3::from_diagonal_element(r.norm_squared()) - r * r.transpose();
        moment += r.cross(&d);
    }
    let spin = inertia.try_inverse().unwrap_or_default() * moment;
    (pairs().flat_map(|(r, d)| <[f64; 3]>::from(d - spin.cross(&r))).collect(), size)
}

impl Part for Chamber {
    fn for_each_coupling(&self, visit: &mut dyn FnMut(&[u32])) {
        visit(&self.nodes);
    }

    fn place(&mut self, pattern: &Pattern) {
        let nodes = &self.nodes;
        self.places = nodes.iter().flat_map(|&a| nodes.iter().map(move |&b| pattern.block(a, b))).collect();
    }

    fn linearize(&self, at: &Iterate, _memory: &[f64], sums: &mut Sums) -> Result<(), Refusal> {
        let (d, [x_0, x_1]) = (self.dimension, [at.q_0, at.q_1].map(|q| self.own(q)));
        let mut step = None;
        let (pressure, slope, gradient, x) = match at.derivative {
            Derivative::DiscreteGradient => {
                let of_step = self.step(&x_0, &x_1);
                let (pressure, slope) = self.gas.mean(self.volume(&x_0), of_step.change);
                let gradient = of_step.gradient.clone();
                step = Some(of_step);
                (pressure, slope, gradient, Vec::new())
            }
            Derivative::Gradient(configuration) => {
                let mut x = Vec::new();
                configuration.positions_into(&x_0, &x_1, &mut x);
                let (volume, share) = (self.volume(&x), configuration.share());
                (self.gas.pressure_at(volume) - self.gas.ambient, share * self.gas.slope_at(volume), self.gradient(&x), x)
            }
        };
        for (&node, force) in self.nodes.iter().zip(gradient.chunks_exact(d)) {
            (0..d).for_each(|i| sums.internal[node as usize * d + i] -= at.weight * pressure * force[i]);
        }
        let Some(values) = sums.tangent.as_deref_mut() else { return Ok(()) };
        let count = self.nodes.len();
        let mut add = |nodes: [usize; 2], [i, j]: [usize; 2], value: f64| {
            values[self.places[nodes[0] * count + nodes[1]].at(i, j)] += at.weight * value;
        };
        match &step {
            Some(of_step) => {
                self.add_product(&gradient, &self.gradient(&x_1), -slope, &mut add);
                self.slopes_of_step(&x_0, &x_1, of_step, pressure, &mut add);
            }
            None => {
                let share = if at.derivative == Derivative::AT_END { Configuration::End } else { Configuration::Middle }.share();
                self.add_product(&gradient, &gradient, -slope, &mut add);
                self.slopes(&x, &mut |nodes, components, slope| add(nodes, components, -share * pressure * slope));
            }
        }
        Ok(())
    }

    fn energy(&self, at: Pose, _memory: &[f64]) -> f64 {
        self.gas.energy(self.rest_volume - self.gas.volume + self.change(&self.rest, &self.own(at.q)))
    }

    fn is_outside(&self) -> bool {
        self.rim_point.is_some()
    }

    fn readings(&self, at: Pose, _velocity: &[f64], memory: &[f64]) -> Vec<f64> {
        let volume = self.volume(&self.own(at.q));
        vec![volume, self.gas.pressure_at(volume), self.energy(at, memory)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::Vertex;
    use crate::math::workers::Workers;

    /// Dimension, `is_round`, facets, positions.
    type Case = (usize, bool, Vec<Vec<u32>>, Vec<f64>);

    /// Chambers: a square and one with edges of second order in the plane, a cone around an axis, a tetrahedron in space. The normals of
    /// the facets point into the gas, as those of the surrounding bodies.
    fn chambers() -> Vec<Case> {
        vec![
            (2, false, vec![vec![1, 0], vec![2, 1], vec![3, 2], vec![0, 3]], vec![0.0, 0.0, 1.0, 0.1, 1.2, 1.0, 0.0, 0.9]),
            (2, false, vec![vec![1, 0, 2], vec![0, 1, 3]], vec![0.0, 0.0, 1.0, 0.1, 0.5, -0.4, 0.6, 0.7]),
            (2, true, vec![vec![1, 0], vec![2, 1]], vec![0.0, -0.5, 0.8, 0.1, 0.0, 0.9]),
            (
                3,
                false,
                vec![vec![0, 1, 2], vec![0, 3, 1], vec![1, 3, 2], vec![0, 2, 3]],
                vec![0.0, 0.0, 0.0, 1.0, 0.1, 0.0, 0.2, 1.1, 0.1, 0.1, 0.2, 0.9],
            ),
        ]
    }

    fn definition(dimension: usize, is_round: bool, facets: &[Vec<u32>], exponent: f64) -> ChamberDefinition {
        let gas = Gas { pressure: 3.0, volume: 0.0, exponent, ambient: 1.0 };
        let facets = facets.iter().map(|nodes| (0, nodes.clone())).collect();
        ChamberDefinition { name: "gas".into(), facets, dimension, is_round, gas, rim_point: None }
    }

    #[test]
    fn its_forces_do_the_work_of_the_gas_and_its_tangent_is_their_derivative() {
        for (d, is_round, facets, q_0) in chambers() {
            for (exponent, size) in [(1.0, 0.1), (1.4, 0.1), (1.4, 1e-7), (3.0, 0.0)] {
                let definition = definition(d, is_round, &facets, exponent);
                let point = |_: usize, node: u32| std::array::from_fn(|i| if i < d { q_0[node as usize * d + i] } else { 0.0 });
                assert!(definition.check(&point).is_ok(), "{:?}", definition.check(&point).map_err(|error| error.to_string()));
                let mut chamber = definition.kernel(&Numbering { dimension: d, first: &[0], reference: &q_0 });
                let count = q_0.len() / d;
                let all: Vec<u32> = (0..count as u32).collect();
                let pattern = Pattern::new(&vec![Vertex::coordinates(d as u8); count], [&all[..]].into_iter());
                chamber.place(&pattern);
                let q_1: Vec<f64> = q_0
                    .iter()
                    .enumerate()
                    .map(|(k, q)| q + if is_round && *q == 0.0 && k % 2 == 0 { 0.0 } else { size * (1.7 * k as f64).sin() })
                    .collect();
                for derivative in Derivative::ALL {
                    let linearized = |q_1: &[f64]| {
                        let at = Iterate::between(derivative, &q_0, q_1);
                        let (mut internal, mut load) = (vec![0.0; q_0.len()], vec![0.0; q_0.len()]);
                        let mut values = vec![0.0; pattern.values()];
                        let workers = Workers::new(1);
                        let mut sums = Sums { internal: &mut internal, load: &mut load, tangent: Some(&mut values), workers: &workers };
                        assert!(chamber.linearize(&at, &[], &mut sums).is_ok());
                        (internal, values)
                    };
                    let (force, values) = linearized(&q_1);
                    let is_exact = derivative == Derivative::DiscreteGradient;
                    let work: f64 = force.iter().zip(q_1.iter().zip(&q_0)).map(|(f, (b, a))| f * (b - a)).sum();
                    let energy = |q: &[f64]| chamber.energy(Pose { q, u: q }, &[]);
                    assert!(!is_exact || (work - energy(&q_1) + energy(&q_0)).abs() < 1e-15, "{d} {is_round} {exponent} {size}");
                    if is_exact && !is_round {
                        let middle = |k: usize| 0.5 * (q_0[k] + q_1[k]);
                        let moment: f64 = (0..count).map(|a| middle(a * d) * force[a * d + 1] - middle(a * d + 1) * force[a * d]).sum();
                        let resultant: f64 = (0..count).map(|a| force[a * d]).sum();
                        assert!(moment.abs() < 1e-15 && resultant.abs() < 1e-15, "{moment} {resultant}");
                    }
                    for column in 0..q_0.len() {
                        let moved = |h: f64| {
                            let mut q = q_1.clone();
                            q[column] += h;
                            linearized(&q).0
                        };
                        let (up, down) = (moved(1e-6), moved(-1e-6));
                        for row in 0..q_0.len() {
                            let entry = values[pattern.block((row / d) as u32, (column / d) as u32).at(row % d, column % d)];
                            let difference = (up[row] - down[row]) / 2e-6;
                            // In space the derivative of the increment's rotation is omitted.
                            let tolerance = if is_exact && d == 3 { 2.0 * size * size + 1e-6 } else { 1e-7 };
                            assert!((difference - entry).abs() < tolerance, "{d} {is_round} {derivative:?} {size} {difference} {entry}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn open_chambers_and_those_of_the_wrong_side_are_refused() {
        let (d, is_round, mut facets, q) = chambers().swap_remove(0);
        let point = |_: usize, node: u32| std::array::from_fn(|i| if i < d { q[node as usize * d + i] } else { 0.0 });
        facets.iter_mut().for_each(|facet| facet.reverse());
        assert!(matches!(definition(d, is_round, &facets, 1.0).check(&point), Err(ModelError::ChamberOfNoVolume { .. })));
        facets.pop();
        assert!(matches!(definition(d, is_round, &facets, 1.0).check(&point), Err(ModelError::OpenChamber { .. })));
    }
}
