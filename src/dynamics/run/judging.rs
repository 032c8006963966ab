//! Acceptance of a converged step by its accuracy, with step size control.

use super::engine::Engine;
use super::ledger::ContactTotals;
use super::pace::{FirstTouch, Measure, SlipEnd, Stepped};
use super::slip_memory::size;
use super::state::State;
use super::substeps::Substeps;
use crate::bodies::{BodyState, Elements, Space};
use crate::contact::SlipState;
use crate::dynamics::parts::body::Body;
use crate::dynamics::parts::contact_pair::ContactPair;
use crate::dynamics::step::counters::Counters;
use crate::dynamics::step::failure::Failure;
use crate::dynamics::step::system::System;
use crate::math::tolerances;

/// Open time after which a touch counts as a first one, in travel times of an elastic wave through a cell: nodes in contact chatter at mesh
/// frequency.
const BOUNCE: f64 = 10.0;

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Returns the state after an accepted step of size `dt` with the updated step size controller; `before` are the counters before the
    /// step.
    ///
    /// # Errors
    /// The error of the step is too large.
    pub fn judged(&mut self, state: State, dt: f64, substeps: &Substeps, before: Counters) -> Result<State, Failure> {
        let Some(control) = self.options.control else { return Ok(state) };
        let (old, options) = (&self.state, &self.options);
        let scheme = options.integrator.after(old.scheme_history.dt, dt);
        let chosen = old.pace.size(&control, options.dt);
        let is_cut = substeps.is_whole() && dt < chosen * (1.0 - tolerances::SAME_MOMENT);
        // Ties and bilateral contacts are closed from the start.
        let is_open = |(contact, (_, pair)): (usize, (usize, &ContactPair))| {
            !pair.law.is_bilateral() && old.pace.is_open(contact, BOUNCE * self.sound)
        };
        let open: Vec<bool> = self.system.contacts().enumerate().map(is_open).collect();
        let (u, v_0) = ([&old.displacements[..], &state.displacements], &old.velocities[..]);
        let reach = reach::<D>(&state.positions);
        let [round_off, touch_round_off] = if self.system.depends_on_positions() {
            [tolerances::STILL_AT, tolerances::TOUCH].map(|least| least * reach)
        } else {
            [0.0; 2]
        };
        let touch = first_touch(&old.row.contacts, &state.row.contacts, round_off, |contact| open[contact]);
        let plastic_strain = if control.plastic_strain.is_some() { self.plastic_strain(&state) } else { 0.0 };
        let (v_1, slip_end) = (&state.velocities[..], self.slip_end(&state, dt));
        let step = Stepped { scheme: &scheme, dt, u, v: [v_0, v_1], is_cut, touch, slip_end, round_off, touch_round_off, plastic_strain };
        match old.pace.after(&step, &control, options.dt, &self.system) {
            Ok(pace) => {
                let pace = pace.with_contacts(dt, state.row.contacts.iter().map(|contact| contact.active > 0));
                Ok(State { pace: if substeps.level() > 0 { pace.held(dt) } else { pace }, ..state })
            }
            Err(size) => {
                let counters = &mut self.system.counters;
                counters.discarded = before.discarded + (counters.factorizations - before.factorizations);
                self.restore_search();
                Err(Failure::Inexact { size })
            }
        }
    }

    /// Slip that ends or turns within a step of size `dt` in the contact or joint where it is largest. A contact that slips in one
    /// direction does the largest work that its law admits; missing work means that it slipped in a part of the step only.
    fn slip_end(&self, state: &State, dt: f64) -> Option<SlipEnd> {
        let (system, old) = (&self.system, &self.state);
        let mut sums = vec![[0.0f64; 3]; system.pairs.len()];
        for (index, pair) in system.pairs.iter().enumerate() {
            // Sticking penalty springs deform, with a shear below its limit: that is no slip that ends.
            let Some(friction) = pair.friction.as_ref().filter(|_| pair.has_multipliers()) else { continue };
            let sum = &mut sums[pair.corners.map_or(index, |corners| corners.pair)];
            for (local, row) in pair.rows.clone().enumerate() {
                // First touches have an error of their own.
                if !(old.active[row].is_closed() && state.active[row].is_closed()) {
                    continue;
                }
                let (group, weight) = (friction.group(local), pair.kernel.weights()[local]);
                let slips: Vec<f64> = group.clone().map(|row| state.slipped[row - system.normal_count].slip).collect();
                let slip = size(&slips).abs();
                let pressure = if pair.law.is_bilateral() { state.lambda[row].abs() } else { state.lambda[row].max(0.0) };
                let sliding = SlipState { coefficient: friction.coefficients[local], pressure, speed: slip / dt };
                let limit = weight * friction.law.limit(sliding).shear;
                // Where friction falls with the speed, surfaces stick and slip in turn: steps that end with each slip would be too many.
                if limit != weight * friction.law.limit(SlipState { speed: 0.0, ..sliding }).shear {
                    continue;
                }
                let work: f64 = group.zip(&slips).map(|(row, slip)| -weight * state.lambda[row] * slip).sum();
                let parts = [limit, limit * slip, work.min(limit * slip)];
                sum.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
            }
        }
        let of = |[limit, most, work]: &[f64; 3]| SlipEnd { slip: most / limit, share: work / most };
        let ends = sums.iter().filter(|[_, most, work]| *most > *work).map(of);
        ends.max_by(|a, b| a.missed().total_cmp(&b.missed()))
    }

    /// Largest increase of the equivalent plastic strain of a point from the present state to another.
    fn plastic_strain(&self, state: &State) -> f64 {
        let flowing = self.system.bodies.iter().filter(|body| body.elements.flows());
        let of_body = |body: &Body<D>| {
            let strains = |state: &State| {
                let (u, history) = (&state.displacements[..], &state.memory[body.number][..]);
                let mut strains = Vec::new();
                body.elements.visit_stresses(BodyState { u, history }, &mut |point| {
                    strains.push(point.kept.map_or(0.0, |kept| kept.plastic_strain));
                });
                strains
            };
            let changes = strains(state).into_iter().zip(strains(&self.state)).map(|(after, before)| after - before);
            changes.fold(0.0, f64::max)
        };
        flowing.map(of_body).fold(0.0, f64::max)
    }
}

impl<const D: usize> Measure for System<D>
where
    Space<D>: Elements<D>,
{
    fn size(&self, vector: &[f64], free: bool) -> f64 {
        // By the consistent mass: row sums at the masters of a rigid body depend on which nodes these are, and may be negative.
        let counts = |k: usize| !free || !self.supports.fixed[k];
        let counted: Vec<f64> = vector.iter().enumerate().map(|(k, value)| if counts(k) { *value } else { 0.0 }).collect();
        let momenta = self.nodes.momenta_of(&counted);
        let of_body = |nodes: std::ops::Range<usize>| {
            let sum: f64 = (nodes.start * D..nodes.end * D).map(|k| momenta[k] * counted[k]).sum();
            let mass: f64 = self.nodes.nodal_mass[nodes].iter().sum();
            if mass > 0.0 { (sum.max(0.0) / mass).sqrt() } else { 0.0 }
        };
        self.bodies.iter().map(|body| of_body(body.nodes.clone())).fold(0.0, f64::max)
    }
}

/// Largest distance of a model from the origin, in its radii, at which the round-off of its positions counts as that of a centered model.
const CENTERED: f64 = 4.0;

/// Measure of the distances of the nodes from the origin: the radius of the model times a power of two, at least one, at most [`CENTERED`]
/// times smaller than the largest distance. In contrast to the largest coordinate, the measure and the steps that depend on it are those
/// of the model in other axes and, unless it is far away, in other places.
fn reach<const D: usize>(q: &[f64]) -> f64 {
    let count = (q.len() / D).max(1) as f64;
    let mut mean = [0.0; D];
    q.chunks_exact(D).for_each(|x| (0..D).for_each(|i| mean[i] += x[i] / count));
    let farthest = |from: [f64; D]| {
        let squares = q.chunks_exact(D).map(|x| (0..D).map(|i| (x[i] - from[i]).powi(2)).sum::<f64>());
        squares.fold(0.0, f64::max).sqrt()
    };
    let (radius, distance) = (farthest(mean), farthest([0.0; D]));
    let ratio = distance / (CENTERED * radius);
    match radius {
        0.0 => distance,
        _ => radius * ratio.max(1.0).log2().ceil().exp2(),
    }
}

/// First touch of a contact within a step: the deepest among the contacts that have been open. A rule that closes the gap leaves a depth
/// of the size of `round_off` `[length]`, of either sign.
fn first_touch(before: &[ContactTotals], after: &[ContactTotals], round_off: f64, is_open: impl Fn(usize) -> bool) -> Option<FirstTouch> {
    let none = ContactTotals::default();
    let (mut depth, mut is_kept) = (0.0f64, false);
    for (index, now) in after.iter().enumerate() {
        let before = before.get(index).unwrap_or(&none);
        // A corner may overlap while the mean gap of its facets is open: the contact then counts as touched before.
        if before.active == 0 && before.penetration == 0.0 && is_open(index) {
            depth = depth.max(now.penetration);
            is_kept |= now.active > 0;
        }
    }
    let passed = (depth > round_off).then_some(FirstTouch::Passed(depth));
    passed.or(is_kept.then_some(FirstTouch::Kept))
}
