//! Impacts between rigid bodies, and with rigid obstacles, at the end of a step (`step/impact_law.rs`), independent of the time of the
//! touch within the step.
//!
//! A step of `persistency` ends with the velocities before the impact. A step of `gap` or `velocity` closes gaps by multipliers, whose
//! impulses depend on the time of the touch: they are removed first, except impulses that keep earlier closed contacts closed. Restitution
//! returns energy relative to the loss up to the end of compression, including the work of the closing: with a coefficient of 1 and without
//! friction the energy is exact, whatever else acts in the step.

use super::engine::Engine;
use super::velocity_correction::VelocityCorrection;
use crate::bodies::{Elements, Space};
use crate::contact::{Evaluation, SlipState};
use crate::dynamics::parts::contact_pair::ContactPair;
use crate::dynamics::step::conditions::Conditions;
use crate::dynamics::step::failure::Failure;
use crate::dynamics::step::impact_law::{ImpactContact, ImpactLaw, ImpactSolution};
use crate::dynamics::step::impact_rows::Responses;
use crate::dynamics::step::newton::Solution;
use crate::dynamics::step::start::Motion;
use crate::math::tolerances;

/// Gap change in a step, relative to the gap tolerance, below which bodies count as not approaching: the midpoint rule doubles a remaining
/// gap error in its velocities.
const NOISE: f64 = 4.0;

/// Largest number of attempts to reach the energy that restitution returns.
const ATTEMPTS: usize = 20;

/// Normal constraint of a contact between rigid sides that is active at the end of the step.
struct ImpactConstraint {
    /// Index of its pair.
    pair: usize,
    /// Index among all constraints.
    row: usize,
    /// True if the contact was closed at the start of the step and did not open.
    was_closed: bool,
}

/// Impulses of the constraints in the impacts of a step, and their work.
struct Outcome {
    /// Impulses in addition to those of the step, in the order of all constraints.
    impulses: Vec<f64>,
    /// Energy lost to restitution.
    lost: f64,
    /// Work of friction in each contact, minus the friction work of the step in the contacts of the impact.
    friction: Vec<f64>,
    /// Sum of the momentum magnitudes exchanged by the contacts of the impact, in the step included: the scale of their round-off.
    exchanged: f64,
    /// Work of all impulses in the frame of the obstacles, with the work of closings in the step beyond their targets.
    work: f64,
}

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Adds impacts of rigid bodies to the velocity jump of a converged step; returns `jump` unchanged without an impact.
    ///
    /// # Errors
    /// Joints and ties depend on one another at these positions, so that impulses have no response; or the run was interrupted.
    pub fn rigid_impacts(
        &mut self,
        motion: &Motion,
        solution: &Solution,
        conditions: &Conditions,
        jump: Option<VelocityCorrection>,
    ) -> Result<Option<VelocityCorrection>, Failure> {
        if self.system.pairs.iter().all(|pair| pair.restitution.is_none()) {
            return Ok(jump);
        }
        let v = self.corrected_velocities(motion, solution, jump.as_ref());
        let slips = self.system.slips_at_rest(&solution.at.q_1, &solution.at.pairs);
        let evaluated = [&solution.at.pairs[..], &slips[..]];
        let rates = self.system.rates(evaluated, &solution.at.q_1, &v);
        let Some(touches) = self.touches(motion, solution, conditions, &rates) else { return Ok(jump) };
        let contacts = self.impact_contacts(&touches);
        let rows: Vec<usize> = touches.iter().flat_map(|touch| self.rows_of(touch)).collect();
        let solved = self.solved(solution, evaluated, &rows, &rates);
        let (responses, [response, powers]) = solved.map_err(|failure| failure.or_end(self.state.row.time))?;
        let mut law = ImpactLaw { contacts, response };
        let before: Vec<f64> = rows.iter().zip(&powers).map(|(&row, power)| rates[row] + power).collect();
        let multipliers = self.multipliers_of_step(motion, solution);
        let taken = closing_impulses(motion, &multipliers, &touches, &rows);
        self.set_friction(motion, solution, &touches, [&before, &taken], &mut law);
        let outcome = self.outcome(motion, solution, conditions, &law, &touches, [&multipliers, &taken], before);
        let push = self.system.response_to(&solution.at, evaluated, &responses, &rows, &outcome.impulses, &rates);
        let push = self.checked(motion, solution, push, tolerances::PUSH * outcome.exchanged)?;
        let mut jump = jump.unwrap_or_else(|| VelocityCorrection::none(v.len(), self.state.reserve.clone()));
        jump.add(1.0, &push, motion.dt);
        jump.impact += outcome.lost;
        jump.closed.extend(touches.iter().map(|touch| touch.row).filter(|&row| jump.lambda[row] > 0.0));
        jump.energy += outcome.work - outcome.friction.iter().sum::<f64>();
        for (contact, work) in law.contacts.iter().zip(&outcome.friction).filter(|(contact, _)| contact.tangents > 0) {
            jump.friction[rows[contact.first + 1]] += work;
        }
        Ok(Some(jump))
    }

    /// Normal constraints of rigid contacts that are closed at the end of the step; `None` if there is no impact.
    fn touches(&self, motion: &Motion, solution: &Solution, conditions: &Conditions, rates: &[f64]) -> Option<Vec<ImpactConstraint>> {
        let (mut touches, mut is_impact, held) = (Vec::new(), false, self.system.closed_gaps());
        let mut before = None;
        // Lower bound of the impact speed of closed contacts: after a short step the midpoint rule continues round-off of the positions as
        // an alternating speed.
        let floor = (2.0 * tolerances::IMPACT_FLOOR * self.state.row.energy_scale() / self.system.nodes.total_mass).sqrt();
        for (index, pair) in self.system.pairs.iter().enumerate().filter(|(_, pair)| pair.restitution.is_some()) {
            let at = &solution.at.pairs[index];
            for (local, row) in pair.rows.clone().enumerate() {
                let closed = held[row] + pair.closed;
                let acts = solution.active[row].is_closed() && solution.at.lambda[row] > 0.0;
                if at.coverage[local] <= tolerances::SLIVER || !(acts || at.gap[local] <= closed) {
                    continue;
                }
                // Speeds below `slow` may result from the gap tolerance.
                let mut was_closed = conditions.gap_n[row] <= closed;
                let carried_on = if was_closed { floor * at.coverage[local] * pair.kernel.weights()[local] } else { 0.0 };
                let slow = (NOISE * pair.gap_tolerance / motion.dt).max(carried_on);
                let approaches = rates[row] < -slow;
                if was_closed && acts && approaches {
                    let evaluated = [&solution.at.pairs[..], &solution.at.slips[..]];
                    let before = before.get_or_insert_with(|| self.system.rates(evaluated, &solution.at.q_1, motion.v_0));
                    was_closed = before[row] <= slow;
                }
                is_impact |= approaches || (acts && !was_closed);
                touches.push(ImpactConstraint { pair: index, row, was_closed });
            }
        }
        is_impact.then_some(touches)
    }

    /// Constraints of an impact contact: the normal one and its tangential ones.
    fn rows_of(&self, touch: &ImpactConstraint) -> Vec<usize> {
        let pair = &self.system.pairs[touch.pair];
        let slips = self.slips_of(pair, touch.row);
        std::iter::once(touch.row).chain(slips).collect()
    }

    fn slips_of(&self, pair: &ContactPair, row: usize) -> std::ops::Range<usize> {
        let friction = pair.friction.as_ref().filter(|_| pair.turn.is_none());
        friction.map_or(0..0, |friction| friction.group(row - pair.rows.start))
    }

    /// Contacts of an impact, without friction.
    fn impact_contacts(&self, touches: &[ImpactConstraint]) -> Vec<ImpactContact> {
        let mut first = 0;
        let made = touches.iter().map(|touch| {
            let pair = &self.system.pairs[touch.pair];
            let (weight, tangents) = (pair.kernel.weights()[touch.row - pair.rows.start], self.slips_of(pair, touch.row).len());
            let restitution = pair.restitution.unwrap_or(0.0);
            let contact = ImpactContact { first, tangents, friction: 0.0, restitution, weight };
            first += 1 + tangents;
            contact
        });
        made.collect()
    }

    /// Sets the friction coefficients of an impact at the slip speeds before it, and at the pressures of the same impact without friction
    /// that lasts a step. `before` are the rates of the constraints of `law` with the impulses `taken`, which are removed.
    fn set_friction(
        &self,
        motion: &Motion,
        solution: &Solution,
        touches: &[ImpactConstraint],
        [before, taken]: [&[f64]; 2],
        law: &mut ImpactLaw,
    ) {
        if law.contacts.iter().all(|contact| contact.tangents == 0) {
            return;
        }
        let mut rates = before.to_vec();
        law.answer(taken, &mut rates);
        let mut smooth = law.before(rates.clone());
        law.compress(&mut smooth, |_| true);
        for (touch, contact) in touches.iter().zip(&mut law.contacts) {
            let pair = &self.system.pairs[touch.pair];
            let Some(friction) = pair.friction.as_ref().filter(|_| contact.tangents > 0) else { continue };
            let local = touch.row - pair.rows.start;
            let around = pair.node_of(touch.row).map_or(1.0, |node| pair.circumference(node, &solution.at.q_1));
            let covered = (contact.weight * solution.at.pairs[touch.pair].coverage[local]).max(f64::MIN_POSITIVE);
            let speed = before[contact.slips()].iter().map(|rate| rate.powi(2)).sum::<f64>().sqrt() / covered;
            // A contact that others relieve has the impulse that would stop it alone.
            let (row, count) = (contact.first, rates.len());
            let alone = rates[row].abs() / law.response[row * count + row].max(f64::MIN_POSITIVE);
            let impulse = if smooth.impulses[row] > 0.0 { smooth.impulses[row] } else { alone };
            let pressure = (impulse / (motion.dt * around)).max(f64::MIN_POSITIVE);
            let at = SlipState { coefficient: friction.coefficients[local], pressure, speed };
            contact.friction = friction.law.impulse_ratio(at);
        }
    }

    /// Factorized masses, responses of the constraints, and power of the bilateral constraints at the rates `ending`.
    fn solved(
        &mut self,
        solution: &Solution,
        evaluated: [&[Evaluation]; 2],
        rows: &[usize],
        rates: &[f64],
    ) -> Result<(Responses, [Vec<f64>; 2]), Failure> {
        let hold = self.system.bilateral_rows(&solution.at.pairs, |_| true);
        let responses = self.system.responses(&solution.at, evaluated, &hold, rows)?;
        let mut held: Vec<f64> = rates.iter().zip(&hold).map(|(rate, hold)| if *hold { *rate } else { 0.0 }).collect();
        // Driven coordinates keep their rates.
        self.system.pairs.iter().filter(|pair| pair.drive.is_some()).for_each(|pair| held[pair.rows.clone()].fill(0.0));
        let response = self.system.response_matrix(&responses, &held)?;
        Ok((responses, response))
    }

    /// Multipliers of a step with their shares in its equations.
    fn multipliers_of_step(&self, motion: &Motion, solution: &Solution) -> Vec<f64> {
        let mut multipliers = solution.multipliers();
        for pair in &self.system.pairs {
            let share = if pair.forces_stay_in_step() { 1.0 } else { motion.scheme.weight };
            multipliers[pair.rows.clone()].iter_mut().for_each(|multiplier| *multiplier *= share);
        }
        multipliers
    }

    /// Solves the impacts of a step that ends with the rates `ending`; the impulses `taken` of its multipliers are removed first.
    #[allow(clippy::too_many_arguments)]
    fn outcome(
        &self,
        motion: &Motion,
        solution: &Solution,
        conditions: &Conditions,
        law: &ImpactLaw,
        touches: &[ImpactConstraint],
        [multipliers, taken]: [&[f64]; 2],
        ending: Vec<f64>,
    ) -> Outcome {
        let is_closing = taken.iter().any(|impulse| *impulse != 0.0);
        // Work of the closing, and its part beyond the targets: gaps are closed to a tolerance only, and multipliers are large in short
        // steps.
        let (mut closing, mut unbooked, mut slipped) = (0.0, 0.0, vec![0.0; touches.len()]);
        for (touch, slipped) in touches.iter().zip(&mut slipped).filter(|_| is_closing) {
            let pair = &self.system.pairs[touch.pair];
            let (lambda, gap) = (multipliers[touch.row], solution.at.pairs[touch.pair].gap[touch.row - pair.rows.start]);
            closing += lambda * (gap - conditions.gap_n[touch.row]);
            unbooked += lambda * (gap - conditions.targets[touch.row]);
            if let Some(friction) = &pair.friction {
                let of = |row: usize| multipliers[row] * solution.at.slips[touch.pair].gap[row - friction.rows.start];
                *slipped = self.slips_of(pair, touch.row).map(of).sum();
            }
        }
        let mut rates = ending.clone();
        law.answer(taken, &mut rates);
        let mut course = law.before(rates);
        if is_closing {
            law.compress(&mut course, |contact| touches[contact].was_closed);
        }
        let before_closing = std::mem::replace(&mut course.impulses, vec![0.0; taken.len()]);
        course.normal_work = 0.0;
        law.compress(&mut course, |_| true);
        let compressed = course;
        let total =
            |course: &ImpactSolution| -> Vec<f64> { (0..taken.len()).map(|i| taken[i] + before_closing[i] + course.impulses[i]).collect() };
        let work = |course: &ImpactSolution| -> f64 {
            total(course).iter().zip(ending.iter().zip(&course.rates)).map(|(p, (before, after))| 0.5 * p * (before + after)).sum()
        };
        // Friction of the impact replaces that of the step in these contacts.
        let lost =
            |course: &ImpactSolution| -> f64 { course.friction.iter().sum::<f64>() - slipped.iter().sum::<f64>() - closing - work(course) };
        let (available, nominal) = (lost(&compressed), -compressed.normal_work);
        let mut share = if nominal > 0.0 { (available.max(0.0) / nominal).sqrt() } else { 0.0 };
        let mut course = compressed.clone();
        for _ in 0..ATTEMPTS {
            course = compressed.clone();
            law.restore(&mut course, share);
            let given = course.normal_work - compressed.normal_work;
            let all = lost(&course) - course.friction.iter().sum::<f64>();
            if all >= -tolerances::IMPACT_ENERGY * nominal || given <= 0.0 {
                break;
            }
            share *= (available.max(0.0) / given).sqrt();
        }
        // If a slip reverses, restitution may return more energy than compression has taken: the difference is taken from the friction
        // work.
        let (rest, dissipated) = (lost(&course).min(0.0), course.friction.iter().sum::<f64>());
        // Where a contact jams, the multipliers of the step are indeterminate: without them, bodies would fly apart. They are kept.
        if is_closing && motion.scheme.remembers.is_empty() && rest < dissipated - tolerances::JAMMED * self.state.row.energy_scale() {
            return self.outcome(motion, solution, conditions, law, touches, [multipliers, &vec![0.0; taken.len()]], ending);
        }
        let kept = if dissipated < 0.0 { ((dissipated - rest) / dissipated).clamp(0.0, 1.0) } else { 1.0 };
        course.friction.iter_mut().for_each(|work| *work *= kept);
        let friction = course.friction.iter().zip(&slipped).map(|(work, slipped)| work - slipped).collect();
        let given = |contact: &ImpactContact| {
            let row = contact.first;
            contact.weight * (taken[row].abs() + before_closing[row].abs() + course.impulses[row].abs())
        };
        let exchanged = law.contacts.iter().map(given).sum();
        // Integrators with history variables do other work in a closing than that of its gap; the difference is an energy defect.
        let surplus = if motion.scheme.remembers.is_empty() { 0.0 } else { (-lost(&course)).max(0.0) };
        let work = work(&course) + unbooked - surplus;
        Outcome { impulses: total(&course), lost: lost(&course).max(0.0), friction, exchanged, work }
    }
}

/// Impulses of the constraints `rows` that remove those of a step's multipliers, if the step has closed a gap; zero otherwise.
fn closing_impulses(motion: &Motion, multipliers: &[f64], touches: &[ImpactConstraint], rows: &[usize]) -> Vec<f64> {
    let is_closing = touches.iter().any(|touch| !touch.was_closed && multipliers[touch.row] > 0.0);
    rows.iter().map(|&row| if is_closing { -motion.dt * multipliers[row] } else { 0.0 }).collect()
}
