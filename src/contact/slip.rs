//! Slip of constraints in a step, with gradients and tangent: the kinematics of friction in the plane (in space: `space/slip.rs`).
//!
//! The slip of constraint `A` is *linear* in the displacement `d = q_1 - q_0` of the step, with the weights of its gap:
//!
//! ```text
//! u_A = G_A(q_mid) d,    G_A = sum_patches P g_A,    g_A d = int psi_A t.(dx - dy) ds          [length^2]
//! ```
//!
//! `dx - dy` is the displacement of the secondary relative to the primary side, `t` the tangent. `P` removes the rigid motions about
//! `q_mid` from the row of a contact element, which changes terms of the size of the gap. For every friction law the force `G_A^T tau_A`
//! therefore has zero resultant and moment about `q_mid`, and it does the work `tau_A u_A`. Rigid motions of any size have no slip: their
//! displacement is an infinitesimal rigid motion of `q_mid` (Cayley: `R - 1 = W (R + 1)/2`).
//!
//! Each kernel defines `g_A` ([`SlipRows`]); projection and derivatives (by dual numbers) are common.

use super::numbers::{self, Number};
use super::patches::{Evaluation, Patches};
use crate::integrators::Configuration;

/// Number of derivatives computed in one pass.
const LANES: usize = 8;

/// Number with its derivatives with respect to [`LANES`] unknowns.
type Jet = numbers::Jet<LANES>;

/// Step in which slips are evaluated.
#[derive(Clone, Copy)]
pub struct SlipStep<'a> {
    /// Positions at the start.
    pub q_0: &'a [f64],
    /// Positions at the end.
    pub q_1: &'a [f64],
    /// Displacement in the step, computed without the cancellation in `q_1 - q_0`.
    pub moved: &'a [f64],
    /// Configuration in which the friction forces act.
    pub test: Configuration,
    /// True for each live contact element; others have no slip.
    pub live: &'a [bool],
    /// True if the tangent is required.
    pub wants_tangent: bool,
}

/// Slip gradients `g_A` of a kernel's contact elements.
pub trait SlipRows {
    /// Appends the indices of those nodes of contact element `p` that take part in its slip, for the positions `z` of all its nodes;
    /// `false` if it has no slip.
    fn places(&self, p: usize, z: &[f64], places: &mut Vec<usize>) -> bool;

    /// Writes the slip gradients of contact element `p` into `rows`, which are zero before, for the positions `z` of the nodes at
    /// `places`, see [`SlipRows::places`], and the covered measure of each constraint into `covered`; `false` if it has no slip.
    fn rows<T: Number>(&self, p: usize, places: &[usize], z: &[T], rows: &mut [T], covered: &mut [f64]) -> bool;

    /// True if rigid motions of the contact element have no slip; false if the other side is an obstacle.
    fn is_relative(&self, _p: usize) -> bool {
        true
    }

    /// Motion in the step of the other side, if it is an obstacle; zero by default.
    fn other_side(&self) -> Carrier {
        Carrier::default()
    }

    /// Slip of a constraint of contact element `p` that does not depend on the nodes, such as by rotation of a disk `[length^2]`.
    fn own_slip(&self, _p: usize, _row: usize) -> f64 {
        0.0
    }
}

/// Evaluation of slips by a kernel that is generic in the dimension.
pub(super) trait Slips {
    /// Writes the slips of a step to `out`, as [`PatchFunctions::evaluate_slips`](super::PatchFunctions::evaluate_slips).
    fn slips(&self, step: SlipStep, lambda: &[f64], out: &mut Evaluation);
}

/// Rigid motion in a step: displacement `o(x) = shift + turn k x (x - center)` of a point `x` in mid-step.
///
/// With `turn = 2 tan(angle/2)` points of a rotating circle move by the chords of their arcs.
#[derive(Clone, Copy, Default)]
pub struct Carrier {
    /// Displacement of the center `[length]`.
    pub shift: [f64; 2],
    /// Twice the tangent of half the rotation angle.
    pub turn: f64,
    /// Center in mid-step `[length]`.
    pub center: [f64; 2],
}

impl Carrier {
    fn at(&self, x: &[f64]) -> [f64; 2] {
        let Carrier { shift, turn, center } = self;
        [shift[0] - turn * (x[1] - center[1]), shift[1] + turn * (x[0] - center[0])]
    }
}

/// Buffers of one evaluation, reused for all contact elements.
#[derive(Default)]
struct Scratch {
    places: Vec<usize>,
    patch: Vec<f64>,
    middle: Vec<f64>,
    end: Vec<f64>,
    moved: Vec<f64>,
    carrier: Carrier,
    covered: Vec<f64>,
    jets: Vec<Jet>,
    rows: Vec<Jet>,
    values: Vec<f64>,
    /// Derivatives of the slip gradients, one block per unknown.
    slopes: Vec<f64>,
}

/// Evaluates slips (as gaps of `out`), their gradients at the end of the step, the gradients that transmit forces, and the tangent for the
/// multipliers `lambda`; coverage is the covered measure in mid-step.
pub fn evaluate(kernel: &impl SlipRows, patches: &Patches, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
    out.prepare(patches, lambda.len());
    let mut scratch = Scratch::default();
    for p in 0..patches.len() {
        out.clear_patch(patches, p);
        if step.live[p] && scratch.begin(kernel, patches, p, step) && scratch.differentiate(kernel, p, Configuration::Middle) {
            out.live[p] = true;
            scratch.write(kernel, patches, p, step, lambda, out);
        }
    }
}

impl Scratch {
    /// Collects mid-step positions and displacements of the nodes of a contact element; `false` if it has no slip.
    fn begin(&mut self, kernel: &impl SlipRows, patches: &Patches, p: usize, step: SlipStep) -> bool {
        let nodes = patches.nodes(p);
        self.carrier = kernel.other_side();
        self.patch.clear();
        self.patch.extend(nodes.iter().flat_map(|&node| [0, 1].map(|i| 2 * node as usize + i)).map(|k| 0.5 * (step.q_0[k] + step.q_1[k])));
        self.places.clear();
        if !kernel.places(p, &self.patch, &mut self.places) {
            return false;
        }
        for vector in [&mut self.middle, &mut self.end, &mut self.moved] {
            vector.clear();
        }
        for &place in &self.places {
            let node = 2 * nodes[place] as usize;
            self.middle.extend_from_slice(&self.patch[2 * place..2 * place + 2]);
            self.end.extend_from_slice(&step.q_1[node..node + 2]);
            let by = self.carrier.at(&self.patch[2 * place..2 * place + 2]);
            self.moved.extend([step.moved[node] - by[0], step.moved[node + 1] - by[1]]);
        }
        self.covered.clear();
        self.covered.resize(patches.rows(p).len(), 0.0);
        true
    }

    /// Computes slip gradients and their derivatives at a configuration; `false` if there is no slip.
    fn differentiate(&mut self, kernel: &impl SlipRows, p: usize, at: Configuration) -> bool {
        let z = if at == Configuration::Middle { &self.middle } else { &self.end };
        let (unknowns, count) = (z.len(), z.len() * self.covered.len());
        self.values.clear();
        self.slopes.clear();
        self.slopes.resize(unknowns * count, 0.0);
        for first in (0..unknowns).step_by(LANES) {
            self.jets.clear();
            self.jets.extend(z.iter().enumerate().map(|(k, &z)| Jet::unknown(z, k.checked_sub(first))));
            let lanes = LANES.min(unknowns - first);
            self.rows.clear();
            self.rows.resize(count, Jet::from(0.0));
            self.covered.fill(0.0);
            if !projected(kernel, p, &self.places, &self.jets, &mut self.rows, &mut self.covered) {
                return false;
            }
            for (entry, jet) in self.rows.iter().enumerate() {
                (0..lanes).for_each(|lane| self.slopes[(first + lane) * count + entry] = jet.eps[lane]);
            }
        }
        self.values.extend(self.rows.iter().map(|jet| jet.re));
        true
    }

    /// Adds the results at mid-step to the blocks of a contact element, in which a node may occur several times.
    fn write(&mut self, kernel: &impl SlipRows, patches: &Patches, p: usize, step: SlipStep, lambda: &[f64], out: &mut Evaluation) {
        let (unknowns, width) = (self.middle.len(), patches.unknowns(p));
        let column = |k: usize, places: &[usize]| 2 * places[k / 2] + k % 2;
        let count = unknowns * self.covered.len();
        let (range, rows) = (patches.gradient_range(p), patches.rows(p));
        for (m, &row) in rows.iter().enumerate() {
            let values = &self.values[m * unknowns..(m + 1) * unknowns];
            let of_nodes: f64 = values.iter().zip(&self.moved).map(|(g, d)| g * d).sum();
            out.gap[row as usize] += of_nodes + kernel.own_slip(p, m);
            out.coverage[row as usize] += self.covered[m];
            for (k, value) in values.iter().enumerate() {
                let slopes = &self.slopes[k * count + m * unknowns..][..unknowns];
                let turn: f64 = slopes.iter().zip(&self.moved).map(|(slope, d)| slope * d).sum();
                // Derivative of the obstacle's displacement at the mid-step position, which moves by half of the node's displacement.
                let carried = if k % 2 == 0 { -values[k + 1] } else { values[k - 1] } * self.carrier.turn;
                out.gradient_end[range.start + m * width + column(k, &self.places)] += value + 0.5 * (turn + carried);
            }
        }
        if step.test == Configuration::End && !self.differentiate(kernel, p, Configuration::End) {
            return;
        }
        let tangent = &mut out.tangent[patches.tangent_range(p)];
        for (m, tau) in rows.iter().map(|&row| step.test.share() * lambda[row as usize]).enumerate() {
            for k in 0..unknowns {
                let to = column(k, &self.places);
                out.gradient_bar[range.start + m * width + to] += self.values[m * unknowns + k];
                let slopes = &self.slopes[k * count + m * unknowns..][..unknowns];
                for (j, slope) in slopes.iter().enumerate().filter(|_| tau != 0.0) {
                    tangent[column(j, &self.places) * width + to] += tau * slope;
                }
            }
        }
    }
}

/// Slip gradients of a contact element without rigid motions, `P g_A`.
fn projected<T: Number>(kernel: &impl SlipRows, p: usize, places: &[usize], z: &[T], rows: &mut [T], covered: &mut [f64]) -> bool {
    if !kernel.rows(p, places, z, rows, covered) {
        return false;
    }
    if kernel.is_relative(p) {
        let share = 2.0 / z.len() as f64;
        let mut center = [T::from(0.0); 2];
        z.chunks_exact(2).for_each(|z| (0..2).for_each(|i| center[i] += z[i] * share));
        let mut square = T::from(0.0);
        let arm = |z: &[T]| [z[0] - center[0], z[1] - center[1]];
        for z in z.chunks_exact(2) {
            let [x, y] = arm(z);
            square += x * x + y * y;
        }
        for row in rows.chunks_exact_mut(z.len()) {
            let mut moment = T::from(0.0);
            for (z, g) in z.chunks_exact(2).zip(row.chunks_exact(2)) {
                let [x, y] = arm(z);
                moment += x * g[1] - y * g[0];
            }
            let turn = moment / square;
            for (z, g) in z.chunks_exact(2).zip(row.chunks_exact_mut(2)) {
                let [x, y] = arm(z);
                g[0] += turn * y;
                g[1] -= turn * x;
            }
        }
    }
    true
}

/// Slip gradient of a point `x` that slides on a facet `y_1 y_2` of the other side: `weight` times its displacement relative to the
/// opposite point of the facet, along the facet's tangent with the orientation of the point's side. If the point is beside the facet, the
/// opposite point is the facet's end; a round body then slides perpendicular to the direction to this end.
pub fn point_on_facet<T: Number>(z: &[T], weight: f64, is_round: bool, rows: &mut [T; 6]) {
    let at = |k: usize| [z[2 * k], z[2 * k + 1]];
    let [x, y_1, y_2] = [0, 1, 2].map(at);
    let t = [y_1[0] - y_2[0], y_1[1] - y_2[1]];
    let square = t[0] * t[0] + t[1] * t[1];
    let share = ((x[0] - y_2[0]) * t[0] + (x[1] - y_2[1]) * t[1]) / square;
    let end = if share.re() < 0.0 { Some(y_2) } else { (share.re() > 1.0).then_some(y_1) };
    let (along, share) = match end {
        None => (t, share),
        Some(end) => {
            let across = [end[1] - x[1], x[0] - end[0]];
            let turned = if (across[0] * t[0] + across[1] * t[1]).re() < 0.0 { across.map(|x| -x) } else { across };
            (if is_round { turned } else { t }, T::from(if share.re() < 0.0 { 0.0 } else { 1.0 }))
        }
    };
    let unit = (along[0] * along[0] + along[1] * along[1]).sqrt().recip() * weight;
    for i in 0..2 {
        let along = along[i] * unit;
        (rows[i], rows[2 + i], rows[4 + i]) = (along, -(along * share), along * share - along);
    }
}
