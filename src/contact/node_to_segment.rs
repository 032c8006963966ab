//! Node-to-segment contact in the plane: one multiplier per secondary node, its constraint the node's gap to the primary chain.
//!
//! `Phi_A = w_A g_A` with the node's weight in the reference configuration, so that a multiplier is a pressure and `Phi` has the dimension of
//! the mortar method's weighted gap. A patch is a node with all primary facets within its reach: `g` is one continuous function of them
//! (`chain.rs`), and its projected discrete gradient keeps energy and momenta while the node slides over facet borders and corners (after
//! Hesch and Betsch, IUTAM Bookseries 3, 2007, whose formula for a single segment does not).
//!
//! Facets that look the same way as the node's own surface are no opposite (the far side of a thin body); that is decided with the
//! positions at the start of the step and kept in it. The method fails the contact patch test, and two polygons that are pressed
//! into each other lock with the nodes in the corners: mortar is the default for a reason.

use super::ContactKernel;
use super::chain::{Chain, Measure};
use super::patches::{Evaluation, Patches};
use super::search::{Candidates, within_the_body};
use super::surface::Surface;
use crate::integrators::{Configuration, Integrator, PatchFunction, Projection};
use crate::math::tolerances::SAME_WAY;

/// Margin beyond the need with which candidates are searched, in shortest secondary facets.
const SPARE: f64 = 1.0;

/// Node-to-segment contact of two surfaces.
#[derive(Clone, Debug)]
pub struct NodeToSegment {
    secondary: Surface,
    primary: Surface,
    /// The secondary nodes as facets of no length, for the search.
    points: Surface,
    candidates: Candidates,
    patches: Patches,
    chains: Vec<Chain>,
    weights: Vec<f64>,
    facet_size: f64,
    start: Vec<Start>,
}

/// What a patch keeps of the start of the step.
#[derive(Clone, Debug)]
struct Start {
    positions: Vec<f64>,
    admitted: Vec<bool>,
    measure: Option<Measure>,
}

/// Storage of one evaluation, used again from patch to patch.
#[derive(Default)]
struct Scratch {
    end: Vec<f64>,
    middle: Vec<f64>,
    gradient: Vec<f64>,
    hessian: Vec<f64>,
    projection: Projection<2>,
}

impl NodeToSegment {
    /// Contact of two surfaces given by their facets (node numbers of the model, the body on the left), sized in the reference positions.
    ///
    /// A surface that is on both sides touches itself: a node's own facets, their neighbors, and what lies behind it through the body are
    /// no opposite of it.
    pub fn new(secondary: &[[u32; 2]], primary: &[[u32; 2]], reference: &[f64]) -> Self {
        let (secondary, primary) = (Surface::new(secondary), Surface::new(primary));
        let points = Surface::new(&secondary.nodes().iter().map(|&node| [node, node]).collect::<Vec<_>>());
        let weights = secondary.weights(reference);
        let facet_size = secondary.shortest_facet(reference);
        let mut candidates = Candidates::new(SPARE * facet_size).without(points_within_the_body(&secondary, &primary, reference));
        if let Some([facets, others]) = secondary.ranks(&primary) {
            let lowest = |row: usize| secondary.adjacent_facets(row).iter().map(|&facet| facets[facet as usize]).min().unwrap_or(0);
            candidates = candidates.once((0..secondary.nodes().len()).map(lowest).collect(), others);
        }
        let patches = Patches::new(2);
        NodeToSegment { secondary, primary, points, candidates, patches, chains: Vec::new(), weights, facet_size, start: Vec::new() }
    }

    /// Positions of the nodes of patch `p` into `z`.
    fn gather_into(&self, p: usize, q: &[f64], z: &mut Vec<f64>) {
        z.clear();
        z.extend(self.patches.nodes(p).iter().flat_map(|&node| [q[2 * node as usize], q[2 * node as usize + 1]]));
    }

    /// Outward normal at a secondary node (mean of its facets, not of unit length) at `q`.
    fn normal(&self, row: usize, q: &[f64]) -> [f64; 2] {
        let mut normal = [0.0; 2];
        for &facet in self.secondary.adjacent_facets(row) {
            let [a, b] = self.secondary.facets()[facet as usize].map(|node| 2 * node as usize);
            let length = self.secondary.facet_length(facet as usize, q);
            normal[0] += (q[b + 1] - q[a + 1]) / length;
            normal[1] -= (q[b] - q[a]) / length;
        }
        normal
    }

    /// Which facets of patch `p` can be opposite its node at `q`.
    fn admitted(&self, p: usize, q: &[f64]) -> Vec<bool> {
        let normal = self.normal(self.patches.rows(p)[0] as usize, q);
        let size = normal[0].hypot(normal[1]);
        let nodes = self.patches.nodes(p);
        let facets = self.chains[p].facets().iter().map(|facet| {
            let [a, b] = facet.map(|local| 2 * nodes[local as usize] as usize);
            let t = [q[b] - q[a], q[b + 1] - q[a + 1]];
            normal[0] * t[1] - normal[1] * t[0] <= SAME_WAY * size * t[0].hypot(t[1])
        });
        facets.collect()
    }

    /// What measures each patch's gap at `q`: decided as in the present step, or afresh before there is one.
    fn measures(&self, q: &[f64]) -> Vec<Option<Measure>> {
        let mut z = Vec::new();
        let mut measure = |p: usize| {
            self.gather_into(p, q, &mut z);
            match self.start.get(p) {
                Some(start) => self.chains[p].measure(&z, &start.admitted),
                None => self.chains[p].measure(&z, &self.admitted(p, q)),
            }
        };
        (0..self.patches.len()).map(&mut measure).collect()
    }
}

/// Pairs (point, primary facet) that can never be a contact, ascending: those of the point's facets.
fn points_within_the_body(secondary: &Surface, primary: &Surface, reference: &[f64]) -> Vec<[u32; 2]> {
    let mut pairs = Vec::new();
    for [own, other] in within_the_body(secondary, primary, reference) {
        pairs.extend(secondary.local_facets()[own as usize].map(|node| [node, other]));
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

impl ContactKernel for NodeToSegment {
    fn dimension(&self) -> usize {
        2
    }

    fn secondary(&self) -> &Surface {
        &self.secondary
    }

    fn primary(&self) -> &Surface {
        &self.primary
    }

    fn weights(&self) -> &[f64] {
        &self.weights
    }

    fn facet_size(&self) -> f64 {
        self.facet_size
    }

    fn update_candidates(&mut self, q: &[f64], margin: f64) -> bool {
        let changed = self.candidates.update(&self.points, &self.primary, q, margin);
        if changed {
            self.patches.clear();
            self.chains.clear();
            self.start.clear();
            for pairs in self.candidates.pairs().chunk_by(|a, b| a[0] == b[0]) {
                let row = pairs[0][0];
                let mut nodes = vec![self.secondary.nodes()[row as usize]];
                let mut facets = Vec::with_capacity(pairs.len());
                for &[_, facet] in pairs {
                    facets.push(self.primary.facets()[facet as usize].map(|node| {
                        let known = nodes[1..].iter().position(|&other| other == node);
                        known.map_or_else(
                            || {
                                nodes.push(node);
                                nodes.len() as u32 - 1
                            },
                            |index| index as u32 + 1,
                        )
                    }));
                }
                self.patches.push(&nodes, &[row]);
                self.chains.push(Chain::new(facets));
            }
        }
        changed
    }

    fn patches(&self) -> &Patches {
        &self.patches
    }

    fn start_gap(&self) -> Vec<f64> {
        let mut gaps = vec![0.0; self.secondary.nodes().len()];
        for (p, start) in self.start.iter().enumerate() {
            let row = self.patches.rows(p)[0] as usize;
            gaps[row] = self.weights[row] * start.measure.map_or(0.0, |measure| measure.gap);
        }
        gaps
    }

    fn begin_step(&mut self, q_0: &[f64]) {
        self.start = (0..self.patches.len())
            .map(|p| {
                let mut positions = Vec::new();
                self.gather_into(p, q_0, &mut positions);
                let admitted = self.admitted(p, q_0);
                Start { measure: self.chains[p].measure(&positions, &admitted), positions, admitted }
            })
            .collect();
    }

    fn evaluate(&self, integrator: Integrator, q_1: &[f64], lambda: &[f64], out: &mut Evaluation) {
        assert_eq!(self.start.len(), self.patches.len(), "begin_step follows a change of the candidates");
        let placement = integrator.placement();
        out.prepare(&self.patches, self.secondary.nodes().len());
        let mut scratch = Scratch::default();
        let Scratch { end: z_1, middle: z_mid, gradient, hessian, projection } = &mut scratch;
        for (p, (start, chain)) in self.start.iter().zip(&self.chains).enumerate() {
            self.gather_into(p, q_1, z_1);
            z_mid.clear();
            z_mid.extend(start.positions.iter().zip(&*z_1).map(|(a, b)| 0.5 * (a + b)));
            let at_end = chain.measure(z_1, &start.admitted);
            let at_middle = chain.measure(z_mid, &start.admitted);
            if start.measure.is_none() && at_middle.is_none() && at_end.is_none() {
                out.clear_patch(&self.patches, p);
                continue;
            }
            out.live[p] = true;
            let row = self.patches.rows(p)[0] as usize;
            let weight = self.weights[row];
            let (places, square) = (self.patches.gradient_range(p), self.patches.tangent_range(p));

            let gradient_end = &mut out.gradient_end[places.clone()];
            gradient_end.fill(0.0);
            if let Some(Measure { facet, gap, covered }) = at_end {
                out.gap[row] = weight * gap;
                out.coverage[row] = f64::from(u8::from(covered));
                chain.add_gradient(facet, z_1, weight, gradient_end);
            }
            let pressure = lambda[row];
            let bar = &mut out.gradient_bar[places];
            let tangent = &mut out.tangent[square];
            if integrator == Integrator::EnergyMomentum {
                let change = weight * (at_end.map_or(0.0, |m| m.gap) - start.measure.map_or(0.0, |m| m.gap));
                gradient.clear();
                gradient.resize(bar.len(), 0.0);
                if let Some(middle) = at_middle {
                    chain.add_gradient(middle.facet, z_mid, weight, gradient);
                }
                projection.set(&start.positions, z_1);
                projection.gradient_into(gradient, change, bar);
                if pressure == 0.0 {
                    tangent.fill(0.0);
                    continue;
                }
                hessian.clear();
                hessian.resize(tangent.len(), 0.0);
                if let Some(middle) = at_middle {
                    chain.add_hessian(middle.facet, z_mid, weight, hessian);
                }
                let function = PatchFunction { gradient_mid: gradient, gradient_end, hessian_mid: hessian, change };
                projection.tangent_into(pressure, &function, tangent);
            } else {
                let (at, z) = match placement.test {
                    Configuration::Middle => (at_middle, &*z_mid),
                    Configuration::End => (at_end, &*z_1),
                };
                bar.fill(0.0);
                tangent.fill(0.0);
                if let Some(Measure { facet, .. }) = at {
                    chain.add_gradient(facet, z, placement.weight * weight, bar);
                    if pressure != 0.0 {
                        chain.add_hessian(facet, z, placement.weight * placement.share * weight * pressure, tangent);
                    }
                }
            }
        }
    }

    fn gap(&self, q: &[f64]) -> Vec<f64> {
        let mut gaps = vec![0.0; self.secondary.nodes().len()];
        for (p, measure) in self.measures(q).into_iter().enumerate() {
            let row = self.patches.rows(p)[0] as usize;
            gaps[row] = self.weights[row] * measure.map_or(0.0, |measure| measure.gap);
        }
        gaps
    }

    fn coverage(&self, q: &[f64]) -> Vec<f64> {
        let mut coverage = vec![0.0; self.secondary.nodes().len()];
        for (p, measure) in self.measures(q).into_iter().enumerate() {
            coverage[self.patches.rows(p)[0] as usize] = measure.map_or(0.0, |measure| f64::from(u8::from(measure.covered)));
        }
        coverage
    }
}
