//! Contact elements of points opposite chains of facets (`chain.rs`) in one step: participating nodes, gaps, gradients and tangents. Used
//! by node-to-segment contact, corners and disks.

use super::chain::{Chain, Line, Measure};
use super::numbers::Number;
use super::patches::Evaluation;
use super::profile::Profile;
use super::slip::{self, SlipRows};
use super::slip_on_curves;
use super::surface::Sides;
use crate::integrators::{Configuration, Derivative, PatchFunction, Projection};

/// Distance beyond an end of the chain, in lengths of the end facet, up to which it is decided at the start of a step whether a point is
/// opposite the chain.
const NEAR_END: f64 = 0.05;

/// Values of a contact element (point and facets) that are fixed at the start of the step.
#[derive(Clone, Debug, Default)]
pub struct PointStart {
    /// Participating nodes, as indices in the contact element: the point, and the nodes of admitted facets, of their neighbors and of the
    /// next neighbors.
    pub places: Vec<u32>,
    /// Chain of the facets between the participating nodes, in indices of `places`.
    pub chain: Chain,
    /// True for facets that can be the closest facet: all but the outermost neighbors, which only define corners. A neighbor may face away
    /// from the point and still be in front of it around a sharp corner.
    pub closest: Vec<bool>,
    /// Positions of the participating nodes at the start of the step.
    pub positions: Vec<f64>,
    pub measures: [Option<Measure>; 2],
    /// Both facets of the concave corner (pocket) that contains the point, each with its end at the corner; each has a separate constraint
    /// in this step.
    pub pocket: Option<[[u32; 2]; 2]>,
    /// Lines that define the gap in this step, for a corner that crosses a corner of the other side, or a point at a node.
    pub line: Option<Line>,
    /// True if the point has no constraint in this step although facets are opposite: another one keeps both sides apart.
    pub is_excluded: bool,
    /// Disk with its center at the point; `None` for a point of a surface.
    pub round: Option<Round>,
    /// Slack (admitted overlap) of the constraint, relative to that of the pair.
    pub slack: f64,
    /// Height of the curve of the point's own surface at the point, outwards `[length]`.
    pub own_height: f64,
}

/// A rigid disk opposite a single facet.
#[derive(Clone, Copy, Debug)]
pub struct Round {
    /// Radius `[length]`.
    pub radius: f64,
    /// True for each end of the facet at which the body has a concave corner.
    pub is_concave: [bool; 2],
}

/// Buffers of one evaluation, reused for all contact elements.
#[derive(Default)]
struct Scratch {
    end: Vec<f64>,
    middle: Vec<f64>,
    gradient: Vec<f64>,
    gradient_end: Vec<f64>,
    bar: Vec<f64>,
    hessian: Vec<f64>,
    tangent: Vec<f64>,
    part: Vec<f64>,
    projection: Projection<2>,
}

impl PointStart {
    /// Disk opposite a facet; `places` are the indices of the center and of the facet's nodes in the contact element.
    pub fn round(places: [u32; 3], round: Round) -> PointStart {
        PointStart {
            places: places.into(),
            chain: Chain::new(vec![[1, 2]]),
            closest: vec![true],
            round: Some(round),
            ..PointStart::default()
        }
    }

    /// Collects the positions of the participating nodes into `z`; `nodes` are those of the contact element.
    pub fn gather_into(&self, nodes: &[u32], q: &[f64], z: &mut Vec<f64>) {
        z.clear();
        z.extend(self.places.iter().map(|&place| 2 * nodes[place as usize] as usize).flat_map(|x| [q[x], q[x + 1]]));
    }

    /// Height profile of the facet between two nodes, given by their indices in the contact element; `None` for a straight facet.
    fn profile_between(&self, nodes: [usize; 2]) -> Option<&Profile> {
        let place = |node: u32| self.places[node as usize] as usize;
        let facet = self.chain.facets().iter().position(|facet| facet.map(place) == nodes)?;
        self.chain.profile(facet)
    }

    /// Gaps of the constraints at `z`, reduced by the height of the point's own surface.
    pub fn measures(&self, z: &[f64]) -> [Option<Measure>; 2] {
        let measures = match (self.line, self.pocket, self.round) {
            (Some(line), ..) => [Some(self.chain.distance_from(line, z)), None],
            (None, Some(branches), _) => branches.map(|branch| self.chain.measure_branch(branch, z, &self.closest)),
            (None, None, Some(Round { radius, is_concave })) => [self.chain.distance_of_disk(z, is_concave, radius), None],
            (None, None, None) => [self.chain.measure(z, &self.closest), None],
        };
        measures.map(|measure| measure.map(|measure| Measure { gap: measure.gap - self.own_height, ..measure }))
    }

    /// Stores the values at the start of the step; `nodes` are those of the contact element. `crossed` returns the lines that define the
    /// gap if the point is a corner that crosses another corner, or at a node (`Some(None)`: no gap). `pocket` returns the concave corner
    /// that contains the point. If `is_overlapped` holds (too deep), the pocket is removed; if it still holds, the gap is removed, too.
    pub fn begin(
        &mut self,
        nodes: &[u32],
        q_0: &[f64],
        crossed: impl Fn(&PointStart) -> Option<Option<Line>>,
        pocket: impl Fn(&PointStart) -> Option<[[u32; 2]; 2]>,
        is_overlapped: impl Fn(&PointStart) -> bool,
    ) {
        let mut positions = std::mem::take(&mut self.positions);
        self.gather_into(nodes, q_0, &mut positions);
        self.positions = positions;
        let crossed = crossed(self);
        if let Some(line) = crossed {
            self.line = line;
            self.is_excluded = line.is_none();
            if self.is_excluded {
                self.closest.fill(false);
            }
            self.measures = self.measures(&self.positions);
            return;
        }
        self.pocket = pocket(self);
        self.measures = self.measures(&self.positions);
        self.decide_end();
        if is_overlapped(self) {
            self.pocket = None;
            self.measures = self.measures(&self.positions);
        }
        if is_overlapped(self) {
            self.closest.fill(false);
            self.measures = [None; 2];
        }
    }

    /// Decides for the step whether a point near an end of the chain is opposite it. The ends of flush bodies move past each other, and the
    /// end facet tilts, from iterate to iterate: a gap that appears or disappears with them has no solution. In an overlap, which other
    /// nodes may have kept from an impact, it would have to close at once.
    fn decide_end(&mut self) {
        match self.chain.beyond_end(&self.positions, &self.closest) {
            Some(beyond) if self.measures[0].is_none() => self.is_excluded |= beyond <= NEAR_END,
            _ => self.chain.extension = if self.measures.iter().flatten().any(|measure| measure.covered) { NEAR_END } else { 0.0 },
        }
        if self.is_excluded {
            self.closest.fill(false);
        }
    }

    /// Scatters a vector over the participating nodes to all nodes of the contact element.
    pub fn spread_into(&self, values: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for (&place, value) in self.places.iter().zip(values.chunks_exact(2)) {
            out[2 * place as usize..][..2].copy_from_slice(value);
        }
    }

    /// Scatters a matrix over the participating nodes to all nodes of the contact element, row-major.
    pub fn spread_matrix_into(&self, values: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        let (width, own) = (out.len().isqrt(), 2 * self.places.len());
        for (row, values) in values.chunks_exact(own).enumerate() {
            let at = width * (2 * self.places[row / 2] as usize + row % 2);
            for (&place, value) in self.places.iter().zip(values.chunks_exact(2)) {
                out[at + 2 * place as usize..][..2].copy_from_slice(value);
            }
        }
    }
}

/// Calls `visit` with the index of each constraint and its gap at `q`.
fn for_each_measure(sides: &Sides, starts: &[PointStart], q: &[f64], mut visit: impl FnMut(usize, Measure)) {
    let mut z = Vec::new();
    for (p, start) in starts.iter().enumerate() {
        start.gather_into(sides.patches.nodes(p), q, &mut z);
        for (&row, measure) in sides.patches.rows(p).iter().zip(start.measures(&z)) {
            measure.into_iter().for_each(|measure| visit(row as usize, measure));
        }
    }
}

/// Constraint functions at `q`.
pub fn gaps(sides: &Sides, starts: &[PointStart], q: &[f64]) -> Vec<f64> {
    let mut gaps = vec![0.0; sides.weights.len()];
    for_each_measure(sides, starts, q, |row, measure| gaps[row] = sides.weights[row] * measure.gap);
    gaps
}

/// Constraint functions at the start of the step.
pub fn start_gaps(sides: &Sides, starts: &[PointStart]) -> Vec<f64> {
    let of_element = |(p, start): (usize, &PointStart)| sides.patches.rows(p).iter().zip(start.measures);
    let measures = starts.iter().enumerate().flat_map(of_element);
    sides.weighted(measures.map(|(&row, measure)| (row as usize, measure.map_or(0.0, |measure| measure.gap))))
}

/// Largest penetration of a covered point at `q` `[length]`.
pub fn deepest(sides: &Sides, starts: &[PointStart], q: &[f64]) -> f64 {
    let mut deepest = 0.0f64;
    for_each_measure(sides, starts, q, |_, measure| deepest = deepest.max(if measure.covered { -measure.gap } else { 0.0 }));
    deepest
}

/// Coverage of each constraint at `q`: 1 opposite a facet, else 0.
pub fn coverage(sides: &Sides, starts: &[PointStart], q: &[f64]) -> Vec<f64> {
    let mut coverage = vec![0.0; sides.weights.len()];
    for_each_measure(sides, starts, q, |row, measure| coverage[row] = f64::from(u8::from(measure.covered)));
    coverage
}

/// Slips of points relative to the facets that define their gaps at mid-step.
pub struct Slips<'a> {
    pub sides: &'a Sides,
    pub starts: &'a [PointStart],
    /// Rotation of round points in the step `[rad]`.
    pub turned: f64,
}

impl SlipRows for Slips<'_> {
    fn places(&self, p: usize, z: &[f64], places: &mut Vec<usize>) -> bool {
        let start = &self.starts[p];
        let z: Vec<f64> = start.places.iter().flat_map(|&place| z[2 * place as usize..][..2].iter().copied()).collect();
        // One slip per constraint: a point in a pocket slides along both of its facets.
        places.push(0);
        for measure in start.measures(&z).into_iter().take(self.sides.patches.rows(p).len()) {
            let Some(Measure { facet, covered: true, .. }) = measure else { return places.len() > 1 };
            places.extend(start.chain.facets()[facet as usize].map(|node| start.places[node as usize] as usize));
        }
        places.len() > 1
    }

    fn rows<T: Number>(&self, p: usize, places: &[usize], z: &[T], rows: &mut [T], covered: &mut [f64]) -> bool {
        let width = z.len();
        for (m, row) in self.sides.patches.rows(p).iter().enumerate().take((width / 2 - 1) / 2) {
            let at = |k: usize| [z[2 * k], z[2 * k + 1]];
            let of_row = &mut rows[m * width..(m + 1) * width];
            let mut own = [T::from(0.0); 6];
            let (nodes, weight) = ([at(0), at(1 + 2 * m), at(2 + 2 * m)], self.sides.weights[*row as usize]);
            match self.starts[p].profile_between([places[1 + 2 * m], places[2 + 2 * m]]) {
                Some(profile) => own = slip_on_curves::point_on_curve(nodes.as_flattened(), weight, profile),
                None => slip::point_on_facet(nodes.as_flattened(), weight, self.starts[p].round.is_some(), &mut own),
            }
            of_row[..2].copy_from_slice(&own[..2]);
            of_row[2 + 4 * m..6 + 4 * m].copy_from_slice(&own[2..]);
            covered[m] = 1.0;
        }
        true
    }

    fn own_slip(&self, p: usize, row: usize) -> f64 {
        let weight = self.sides.weights[self.sides.patches.rows(p)[row] as usize];
        self.starts[p].round.map_or(0.0, |round| weight * round.radius * self.turned)
    }

    fn is_relative(&self, p: usize) -> bool {
        // The slip of a disk does not depend on the rotation of the facets.
        self.starts[p].round.is_none()
    }
}

/// Values, gradients and tangent of a step that ends at `q_1`, into `out`.
pub fn evaluate(sides: &Sides, starts: &[PointStart], derivative: Derivative, q_1: &[f64], lambda: &[f64], out: &mut Evaluation) {
    assert_eq!(starts.len(), sides.patches.len(), "begin_step follows a change of the candidates");
    out.prepare(&sides.patches, sides.weights.len());
    let mut scratch = Scratch::default();
    for (p, start) in starts.iter().enumerate() {
        start.gather_into(sides.patches.nodes(p), q_1, &mut scratch.end);
        scratch.middle.clear();
        scratch.middle.extend(start.positions.iter().zip(&scratch.end).map(|(a, b)| 0.5 * (a + b)));
        let (ends, middles) = (start.measures(&scratch.end), start.measures(&scratch.middle));
        if start.measures[0].is_none() && middles[0].is_none() && ends[0].is_none() {
            out.clear_patch(&sides.patches, p);
            continue;
        }
        out.live[p] = true;
        scratch.projection.set(&start.positions, &scratch.end);
        let unknowns = scratch.end.len();
        scratch.tangent.clear();
        scratch.tangent.resize(unknowns * unknowns, 0.0);
        let (places, width) = (sides.patches.gradient_range(p), sides.patches.unknowns(p));
        for (m, &row) in sides.patches.rows(p).iter().enumerate() {
            let row = row as usize;
            if let Some(Measure { gap, covered, .. }) = ends[m] {
                out.gap[row] = sides.weights[row] * gap;
                out.coverage[row] = f64::from(u8::from(covered));
            }
            let measures = [start.measures[m], middles[m], ends[m]];
            scratch.add_row(&start.chain, measures, derivative, sides.weights[row], lambda[row]);
            let places = places.start + m * width..places.start + (m + 1) * width;
            start.spread_into(&scratch.gradient_end, &mut out.gradient_end[places.clone()]);
            start.spread_into(&scratch.bar, &mut out.gradient_bar[places]);
        }
        start.spread_matrix_into(&scratch.tangent, &mut out.tangent[sides.patches.tangent_range(p)]);
    }
}

impl Scratch {
    /// Gradients of one constraint from its gaps at the start, in the middle and at the end of the step; adds its tangent.
    fn add_row(&mut self, chain: &Chain, measures: [Option<Measure>; 3], derivative: Derivative, weight: f64, pressure: f64) {
        let Scratch { end, middle, gradient, gradient_end, bar, hessian, tangent, part, projection } = self;
        let [at_start, at_middle, at_end] = measures;
        for vector in [&mut *gradient, &mut *gradient_end, &mut *bar] {
            vector.clear();
            vector.resize(end.len(), 0.0);
        }
        if let Some(measure) = at_end {
            chain.add_gradient(&measure, end, weight, gradient_end);
        }
        if derivative == Derivative::DiscreteGradient {
            let change = weight * (at_end.map_or(0.0, |m| m.gap) - at_start.map_or(0.0, |m| m.gap));
            if let Some(measure) = at_middle {
                chain.add_gradient(&measure, middle, weight, gradient);
            }
            projection.gradient_into(gradient, change, bar);
            if pressure != 0.0 {
                for matrix in [&mut *hessian, &mut *part] {
                    matrix.clear();
                    matrix.resize(end.len() * end.len(), 0.0);
                }
                if let Some(measure) = at_middle {
                    chain.add_hessian(&measure, middle, weight, hessian);
                }
                let function = PatchFunction { gradient_mid: gradient, gradient_end, hessian_mid: hessian, change };
                projection.tangent_into(pressure, &function, part);
                tangent.iter_mut().zip(&*part).for_each(|(sum, part)| *sum += part);
            }
        } else {
            let placement = derivative.placement();
            let (at, z) = match placement.test {
                Configuration::Middle => (at_middle, &*middle),
                Configuration::End => (at_end, &*end),
            };
            if let Some(measure) = at {
                chain.add_gradient(&measure, z, weight, bar);
                if pressure != 0.0 {
                    chain.add_hessian(&measure, z, placement.share * weight * pressure, tangent);
                }
            }
        }
    }
}
