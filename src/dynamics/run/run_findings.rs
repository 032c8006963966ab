//! Violations of the guarantees of a run, and limits of the reliability of its results, found from the rows of the ledger and the halved
//! steps.
//!
//! A finding is no error: the run continued. Energies are relative to the largest `kinetic + strain + |potential|` of the run, but not
//! below the effect of the positions' round-off. Findings before the first step are in `findings.rs`.

use super::halvings::Halving;
use super::ledger::LedgerRow;
use super::rounding::rounded;
use super::rows::Rows;
use crate::dynamics::step::failure::Failure;
use crate::dynamics::step::large_motion::{LargeMotion, MotionKind};
use crate::math::digits::{percent, three_digits};
use crate::math::tolerances::{APPROACH, CAME_THROUGH, CONSERVED, DEPTH, EQUAL, FORCE_FLOOR, GIVEN, HALVED, LEAP, LOST, PASSING, SLIDING};

/// Fraction of discarded factorizations from which a finding is reported, if there are more than a few.
const DISCARDED: f64 = 1.0 / 3.0;
const FEW: usize = 100;

/// Kind of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunFindingKind {
    /// The work of contact in a step was positive; the value is its share of the energy.
    PositiveContactWork,
    /// The energy balance of a step has an error larger than round-off explains; the value is the error as a share of the energy.
    EnergyDefect,
    /// The integrator does not conserve energy by design, and has not; the value is the largest relative energy added or removed so far.
    NotConserved,
    /// A static step jumped to another equilibrium, or was too large; the value is the unexplained share of the energy.
    Leap,
    /// Bodies without a defined interaction overlap; the value is the depth in facets.
    PassedThrough,
    /// A body entered a rigid obstacle outside its contact surface; the value is the depth in facets.
    PassedObstacle,
    /// The sides of a contact overlap by more than a tenth of a facet; the value is the largest depth in facets.
    Depth,
    /// Contact dissipated energy; the value is its share.
    EnergyTaken,
    /// Closed contacts of the `velocity` rule still store impact energy at the end; the value is its share.
    ReserveHeld,
    /// Steps were halved because of a too large motion of this kind; the value is its size in the first of these steps, in facets.
    Motion(MotionKind),
    /// Motions of this kind exceeded the limit in steps that could not be halved further; the value is the first such motion in facets.
    TooFast(MotionKind),
    /// Steps were halved because Newton's method failed, for this reason; the value is the number of halvings per accepted step.
    Failures(&'static str),
    /// A body of linear elasticity has rotated; the value is the angle of a cell, or the relative strain or moment caused by the rotation.
    Turned,
    /// A cell of Saint Venant-Kirchhoff material is crushed; the value is its least stretch.
    Crushed,
    /// A point has flowed beyond the last point of its hardening table.
    BeyondTable,
    /// Cells are too coarse for the static stress field; the value is the estimated stress error relative to the stresses.
    CoarseCells,
    /// A large part of the work was discarded, in failed attempts and undone steps; the value is the share of the factorizations.
    Discarded,
    /// The direct solver took matrices over from another one; the value is their number, 0 if no matrix of the run suits iteration.
    TakenOver,
}

impl RunFindingKind {
    /// Stable code of the finding, explained by `conserva doc`.
    pub fn code(self) -> &'static str {
        match self {
            RunFindingKind::PositiveContactWork => "C0601",
            RunFindingKind::EnergyDefect => "C0602",
            RunFindingKind::NotConserved => "C0603",
            RunFindingKind::Leap => "C0604",
            RunFindingKind::PassedThrough => "C0605",
            RunFindingKind::PassedObstacle => "C0631",
            RunFindingKind::Depth => "C0606",
            RunFindingKind::EnergyTaken => "C0607",
            RunFindingKind::ReserveHeld => "C0608",
            RunFindingKind::Motion(MotionKind::Sliding) => "C0609",
            RunFindingKind::Motion(MotionKind::Approach) => "C0610",
            RunFindingKind::Motion(MotionKind::CameThrough) => "C0611",
            RunFindingKind::Motion(MotionKind::Passing) => "C0612",
            RunFindingKind::TooFast(..) => "C0613",
            RunFindingKind::Failures(..) => "C0614",
            RunFindingKind::Turned => "C0615",
            RunFindingKind::Crushed => "C0616",
            RunFindingKind::BeyondTable => "C0619",
            RunFindingKind::CoarseCells => "C0617",
            RunFindingKind::Discarded => "C0618",
            RunFindingKind::TakenOver => "C0632",
        }
    }

    /// All kinds by their stable names, each with one sentence.
    pub const ALL: &'static [(&'static str, &'static str)] = &[
        ("positive_contact_work", "contact supplied energy in a step, a violation of all update rules: the largest share of the energy"),
        ("energy_defect", "energy appeared or vanished in a step beyond round-off: the largest share of the energy"),
        ("not_conserved", "the integrator, which does not conserve energy, added or removed energy: the largest share of the energy"),
        ("leap", "a step of statics leapt to another equilibrium, or was too large: the share of the energy that it does not explain"),
        ("depth", "the sides of a contact overlapped by more than a tenth of a facet: the largest depth in facets"),
        ("energy_taken", "closings under the update rule gap dissipated energy: its share of the energy"),
        ("reserve_held", "contacts of the update rule velocity store energy at the end: its share of the energy"),
        ("sliding", "steps were halved beforehand where surfaces would have slid too far: how far in the first one, in facets"),
        ("approach", "steps were halved beforehand where bodies would have come through: how far in the first one, in facets"),
        ("came_through", "steps were taken back and halved where bodies had come through: how far in the first one, in facets"),
        ("passing", "steps were halved where an obstacle and a body would pass into each other: how far in the first one, in facets"),
        (
            "motion_too_fast",
            "steps were taken in spite of fast motion, no more halvings being allowed: how far in the first one, in facets",
        ),
        ("passed_through", "bodies without a contact between them overlap at the end: the depth in facets"),
        ("passed_obstacle", "a side of a body that its contact does not name was inside a rigid obstacle: the largest depth in facets"),
        ("turned", "a body of linear elasticity has turned at the end: the angle, or the share of a strain or moment that it causes"),
        ("crushed", "a cell of Saint Venant-Kirchhoff material is crushed at the end, where the law softens: its least stretch"),
        ("beyond_table", "a point flowed beyond the last point of its hardening table: the largest plastic strain over the last one there"),
        ("coarse_cells", "cells are too coarse for the stress at rest: its estimated error over its size, of the worst body"),
        ("failed_steps", "steps were halved where Newton's method failed: halvings for this cause per accepted step"),
        ("work_discarded", "more than a third of the work went into attempts that failed: its share of the factorizations"),
        ("solver_taken_over", "the direct solver took over from the iterative or the distributed one: the number of matrices"),
    ];

    /// Stable name of the kind.
    pub fn name(self) -> &'static str {
        match self {
            RunFindingKind::PositiveContactWork => "positive_contact_work",
            RunFindingKind::EnergyDefect => "energy_defect",
            RunFindingKind::NotConserved => "not_conserved",
            RunFindingKind::Leap => "leap",
            RunFindingKind::PassedThrough => "passed_through",
            RunFindingKind::PassedObstacle => "passed_obstacle",
            RunFindingKind::Depth => "depth",
            RunFindingKind::EnergyTaken => "energy_taken",
            RunFindingKind::ReserveHeld => "reserve_held",
            RunFindingKind::Motion(motion) => motion.name(),
            RunFindingKind::TooFast(_) => "motion_too_fast",
            RunFindingKind::Failures(_) => "failed_steps",
            RunFindingKind::Discarded => "work_discarded",
            RunFindingKind::TakenOver => "solver_taken_over",
            RunFindingKind::Turned => "turned",
            RunFindingKind::Crushed => "crushed",
            RunFindingKind::BeyondTable => "beyond_table",
            RunFindingKind::CoarseCells => "coarse_cells",
        }
    }
}

/// Finding about a run: a violated guarantee, or a limit of the reliability of results.
#[derive(Clone, Debug, PartialEq)]
pub struct RunFinding {
    /// Kind of the finding.
    pub kind: RunFindingKind,
    /// Name of the contact concerned, if known.
    pub contact: Option<String>,
    /// Magnitude of the finding, in the unit of its kind.
    pub value: f64,
    /// Magnitude from which a finding is reported.
    pub limit: f64,
    /// Step at which the value occurred, or the step before the first halving.
    pub step: usize,
    /// Time at the end of the step `[time]`.
    pub time: f64,
    /// Numbers that show the finding; begins with the name of the integrator where energy is not conserved.
    pub explanation: String,
}

impl std::fmt::Display for RunFinding {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let contact = self.contact.as_ref().map_or("contact".into(), |name| format!("contact \"{name}\""));
        match self.kind {
            RunFindingKind::PositiveContactWork => write!(out, "{contact} gave energy"),
            RunFindingKind::EnergyDefect => write!(out, "energy is not kept to round-off"),
            RunFindingKind::NotConserved => write!(out, "energy is not conserved"),
            RunFindingKind::Leap => write!(out, "the way from equilibrium to equilibrium is not followed"),
            RunFindingKind::PassedThrough => write!(out, "bodies have passed into each other"),
            RunFindingKind::PassedObstacle => write!(out, "a body has passed into the rigid obstacle of {contact}"),
            RunFindingKind::Depth => write!(out, "the sides of {contact} overlap"),
            RunFindingKind::EnergyTaken => write!(out, "{contact} took energy"),
            RunFindingKind::ReserveHeld => write!(out, "{contact} keeps energy at the end"),
            RunFindingKind::Motion(MotionKind::CameThrough) => write!(out, "steps are taken back and halved: fast approach in {contact}"),
            RunFindingKind::Motion(motion) => write!(out, "steps are halved beforehand: fast {} in {contact}", motion.name()),
            RunFindingKind::TooFast(motion) => write!(out, "steps are too large: fast {} in {contact}", motion.name()),
            RunFindingKind::Failures(cause) => write!(out, "steps are taken back and halved: {cause}"),
            RunFindingKind::Turned => write!(out, "a body of linear elasticity has turned"),
            RunFindingKind::Crushed => write!(out, "a body of Saint Venant-Kirchhoff material is crushed"),
            RunFindingKind::BeyondTable => write!(out, "a hardening table ends before the plastic strain does"),
            RunFindingKind::CoarseCells => write!(out, "stresses are not accurate, and stiffness may not be"),
            RunFindingKind::Discarded => write!(out, "much of the work was for nothing"),
            RunFindingKind::TakenOver => write!(out, "the direct solver took over from the chosen one"),
        }
    }
}

impl RunFinding {
    /// Returns the stable code of the finding's kind, which `conserva doc` explains.
    pub fn code(&self) -> &'static str {
        self.kind.code()
    }

    /// Suggested remedy or interpretation in one sentence.
    pub fn hint(&self) -> &'static str {
        match self.kind {
            RunFindingKind::PositiveContactWork => "no update rule should do so: do not trust the run from there on, and try a smaller dt",
            RunFindingKind::EnergyDefect => "do not trust the run from there on, and try a smaller dt",
            RunFindingKind::NotConserved => "take an integrator that conserves energy, or a smaller dt, which changes less",
            RunFindingKind::Leap => "with a smaller dt a leap at a limit point stays, and an error of the step goes",
            RunFindingKind::PassedThrough => "define contacts between what touches, or move the bodies apart",
            RunFindingKind::PassedObstacle => {
                "name all of the body that can touch the obstacle as secondary surface, and turn round an obstacle that is the wrong way"
            }
            RunFindingKind::Depth => {
                "an overlap at the start is never driven apart: start without, or begin at rest; one that came later is less with a \
                 smaller dt, or a larger penalty; corners between nodes are held by multipliers, not by penalties"
            }
            RunFindingKind::EnergyTaken => {
                "the update rule `persistency` keeps the energy, `velocity` all but what slides off its contact; with `gap` or explicit \
                 steps finer facets lose less"
            }
            RunFindingKind::ReserveHeld => "nothing is lost: it is part of `potential` and becomes motion when the contact opens",
            RunFindingKind::Motion(MotionKind::Sliding) => {
                "results are right since such steps are halved, and only time is lost; a smaller dt or coarser facets avoid it"
            }
            RunFindingKind::Motion(_) => "nothing is lost but time; a smaller dt or coarser facets avoid it",
            RunFindingKind::TooFast(_) => "results are not accurate there: use a smaller dt, or allow more halvings",
            RunFindingKind::Failures(_) => "nothing is lost but time; a smaller dt avoids it",
            RunFindingKind::Turned => "take `neo_hookean`, whose small strains are the same, for bodies that turn",
            RunFindingKind::BeyondTable => {
                "the yield stress stays constant there: add points, such as a straight line through the last two"
            }
            RunFindingKind::Crushed => "take `neo_hookean` for large compression: this law softens there, down to no resistance",
            RunFindingKind::CoarseCells => "use smaller cells, or cells of second order; the field `stress_error` shows where",
            RunFindingKind::Discarded => {
                "results are right, and only time is lost; a smaller dt helps, or facets of about the same size on both sides of a contact"
            }
            RunFindingKind::TakenOver => "results are right, and only time and memory are lost; choose the direct solver from the start",
        }
    }

    /// Finding on a motion too large for steps of size `dt`, first after the step `step` at `time`.
    pub fn of_motion(kind_of: fn(MotionKind) -> RunFindingKind, motion: &LargeMotion, dt: f64, step: usize, time: f64) -> Self {
        let (LargeMotion { contact, kind, facets }, dt) = (motion, rounded(dt));
        let (limit, explanation) = match kind {
            MotionKind::Sliding => (
                SLIDING,
                format!(
                    "in a step of dt = {dt} its sides would slide by {facets:.2} facets, and a step that slides by one or more does not \
                     see each facet pass: motion goes into vibrations although the energy stays exact"
                ),
            ),
            MotionKind::Approach => (
                APPROACH,
                format!("in a step of dt = {dt} its sides would penetrate by {facets:.2} facets, and `persistency` would leave it so"),
            ),
            MotionKind::CameThrough => (
                CAME_THROUGH,
                format!("in a step of dt = {dt} its sides came to penetrate by {facets:.2} facets, and `persistency` would leave it so"),
            ),
            MotionKind::Passing => (
                PASSING,
                format!("in a step of dt = {dt} an obstacle and the body would pass each other by {facets:.2} facets before they touch"),
            ),
        };
        let (kind, contact) = (kind_of(*kind), Some(contact.clone()));
        RunFinding { kind, contact, value: *facets, limit, step, time, explanation }
    }
}

/// Scales and properties of a simulation by which findings are judged.
pub struct Measures<'a> {
    /// Names of the contacts in the order of the rows' totals, with the lengths of their shortest secondary facets `[length]`.
    pub contacts: Vec<(&'a str, f64)>,
    /// Young's modulus times the size of the model: the strain energy at strains of order one `[energy]`.
    pub stiffness: f64,
    /// Work that the mean of the largest forces does on the round-off of positions `[energy]`.
    pub round_off: f64,
    /// Admissible relative energy defect of a step; `None` for an integrator that does not conserve energy.
    pub defect: Option<f64>,
    /// Name of the time integrator.
    pub integrator: &'static str,
    /// True for explicit steps, whose contact returns in one step the energy taken in the next: sums over steps are judged.
    pub is_explicit: bool,
    /// True for statics, where works follow the trapezoidal rule.
    pub is_static: bool,
    /// Halvings by cause.
    pub halvings: &'a [Halving],
    /// Halvings by cause that were required but impossible, since the limit was reached.
    pub refused: &'a [Halving],
    /// True if the step size is controlled.
    pub chooses_steps: bool,
    /// Number of factorizations.
    pub factorizations: usize,
    /// Number of factorizations in failed attempts and undone steps.
    pub discarded: usize,
}

/// Value with the step and the time of its row.
#[derive(Clone, Copy, Default)]
struct At {
    value: f64,
    step: usize,
    time: f64,
}

impl At {
    /// Replaces the value by a larger one, beyond round-off; the first of equal values is kept.
    fn raise(&mut self, value: f64, row: &LedgerRow) {
        if value > self.value * (1.0 + EQUAL) {
            *self = At { value, step: row.step, time: row.time };
        }
    }
}

/// Sums and extrema of the rows on which findings are based.
struct Gathered {
    /// Largest energy `[energy]`.
    scale: f64,
    defect: At,
    /// Depth in facets for each contact.
    depths: Vec<At>,
    /// Largest relative energy that contact removed in a step; `given`: that it added.
    taken: At,
    given: At,
    /// Sums of the energy taken by contact, of the work of contact, and of energy defects.
    sums: [f64; 3],
    drift: Drift,
    /// Largest energy defect of a static step; the last one if several are equal.
    leap: At,
}

/// Largest share of the energy that the integrator has added or taken up to a step.
struct Drift {
    sum: f64,
    given: f64,
    worst: f64,
    growth: f64,
    most: At,
}

impl Gathered {
    /// Sums and extrema of the rows; `floor`: least energy scale.
    fn of<R: Rows + ?Sized>(rows: &R, last: &LedgerRow, floor: f64, measures: &Measures) -> Self {
        let end = At { value: 0.0, step: last.step, time: last.time };
        let mut drift: Option<Drift> = None;
        let (mut scale, mut defect, mut taken, mut given, mut leap) = (floor, end, end, end, None);
        let (mut depths, mut sums) = (vec![end; measures.contacts.len()], [0.0; 3]);
        let least = if measures.is_explicit { f64::NEG_INFINITY } else { 0.0 };
        rows.visit(0, &mut |row| {
            scale = scale.max(row.kinetic + row.strain.abs() + row.potential.abs());
            defect.raise(row.energy_defect.abs(), row);
            taken.raise(-row.contact_work, row);
            given.raise(row.contact_work, row);
            for (k, (depth, (_, size))) in depths.iter_mut().zip(&measures.contacts).enumerate() {
                depth.raise(row.contacts.get(k).map_or(0.0, |totals| totals.penetration / size), row);
            }
            let works = [(-row.contact_work).max(least), row.contact_work, row.energy_defect];
            sums.iter_mut().zip(works).for_each(|(sum, work)| *sum += work);
            let size = row.energy_defect.abs();
            if leap.is_none_or(|leap: At| size.total_cmp(&leap.value).is_ge()) {
                leap = Some(At { value: size, step: row.step, time: row.time });
            }
            match &mut drift {
                None => {
                    let most = At { value: 0.0, step: row.step, time: row.time };
                    drift = Some(Drift { sum: 0.0, given: row.total(), worst: 0.0, growth: 1.0, most });
                }
                Some(drift) => drift.take(row),
            }
        });
        let drift = drift.unwrap_or(Drift { sum: 0.0, given: 0.0, worst: 0.0, growth: 1.0, most: end });
        [&mut defect, &mut taken, &mut given].into_iter().for_each(|at| at.value /= scale);
        Gathered { scale, defect, depths, taken, given, sums, drift, leap: leap.unwrap_or_default() }
    }
}

impl Drift {
    fn take(&mut self, row: &LedgerRow) {
        self.sum += row.energy_defect;
        self.given += row.load_work + row.contact_work + row.friction_work - row.dissipation;
        if self.sum.abs() > self.most.value {
            self.most = At { value: self.sum.abs(), step: row.step, time: row.time };
            (self.worst, self.growth) = (self.sum, row.total() / self.given);
        }
    }

    /// Text for the finding, with the share of the energy.
    fn explained(&self, share: f64, integrator: &str) -> String {
        let verb = if self.worst > 0.0 { "added" } else { "took" };
        match self.growth {
            growth if growth > 2.0 && growth.is_finite() => format!("{integrator} made {growth:.1} times of it"),
            _ => format!("{integrator} {verb} {} of energy, {}", three_digits(self.most.value), percent(share)),
        }
    }
}

/// All findings on a run with these rows, in a fixed order.
pub fn run_findings<R: Rows + ?Sized>(rows: &R, measures: &Measures) -> Vec<RunFinding> {
    let Some(last) = rows.last_row() else { return Vec::new() };
    // Lower bound of the scale: the energy of a model at rest is round-off.
    let seen = Gathered::of(rows, &last, (FORCE_FLOOR * measures.stiffness).max(f64::MIN_POSITIVE), measures);
    let scale = seen.scale;
    // Relative work of force round-off, `FORCE_FLOOR * stiffness`, on strains of the size `sqrt(scale / stiffness)`.
    let round_off = FORCE_FLOOR * (measures.stiffness / scale).sqrt() + measures.round_off / scale;
    let only = match measures.contacts[..] {
        [(name, _)] => Some(name.to_string()),
        _ => None,
    };
    let mut found = Vec::new();
    let mut add = |kind, contact: Option<String>, limit: f64, At { value, step, time }: At, explanation: String| {
        if value > limit {
            found.push(RunFinding { kind, contact, value, limit, step, time, explanation });
        }
    };
    let end = |value: f64| At { value, step: last.step, time: last.time };

    // Without contacts, forces in rigid bodies do round-off work, which would be reported for a model at rest.
    if !measures.contacts.is_empty() {
        let (limit, given, explanation) = given(&seen, scale, measures.is_explicit, end);
        add(RunFindingKind::PositiveContactWork, only.clone(), limit.max(round_off), given, explanation);
    }

    if let Some(promised) = measures.defect {
        let explanation = format!("a step was off by {:.1e} of the energy, and {promised:.0e} is promised", seen.defect.value);
        add(RunFindingKind::EnergyDefect, None, promised.max(round_off), seen.defect, explanation);
    } else {
        let share = seen.drift.most.value / scale;
        let explanation = seen.drift.explained(share, measures.integrator);
        add(RunFindingKind::NotConserved, None, CONSERVED.max(round_off), At { value: share, ..seen.drift.most }, explanation);
    }

    for (depth, &(name, size)) in seen.depths.iter().zip(&measures.contacts) {
        let facets = depth.value;
        let explanation = format!("nodes lie {facets:.2} facets deep behind the other side, a length of {}", three_digits(facets * size));
        add(RunFindingKind::Depth, Some(name.into()), DEPTH, *depth, explanation);
    }

    let (taken, most) = (seen.sums[0], seen.taken.value);
    let share = taken / scale;
    let explanation = format!("it took {}, {} of the energy; most in one step: {}", three_digits(taken), percent(share), percent(most));
    add(RunFindingKind::EnergyTaken, only.clone(), LOST.max(round_off), At { value: share, ..seen.taken }, explanation);

    let held = last.reserve / scale;
    let explanation = format!("its reserve is {}, {} of the energy", three_digits(last.reserve), percent(held));
    add(RunFindingKind::ReserveHeld, only, LOST.max(round_off), end(held), explanation);

    found.extend(halved(measures, &last));
    if measures.is_static {
        use RunFindingKind::{EnergyTaken, NotConserved, PositiveContactWork};
        found.retain(|finding| !matches!(finding.kind, PositiveContactWork | NotConserved | EnergyTaken));
        found.extend(leap(seen.leap, scale));
    }
    let &Measures { factorizations, discarded, .. } = measures;
    let share = discarded as f64 / factorizations.max(1) as f64;
    if share > DISCARDED && factorizations > FEW {
        let explanation = format!(
            "of {factorizations} factorizations {discarded} belong to attempts of Newton's method that failed or to steps that were taken \
             back"
        );
        let (kind, step, time) = (RunFindingKind::Discarded, last.step, last.time);
        found.push(RunFinding { kind, contact: None, value: share, limit: DISCARDED, step, time, explanation });
    }
    found
}

/// Findings on halved steps, and on steps that could not be halved further.
fn halved(measures: &Measures, last: &LedgerRow) -> Vec<RunFinding> {
    let mut found = Vec::new();
    for Halving { motion, step, time, dt, .. } in measures.refused {
        found.extend(motion.iter().map(|motion| RunFinding::of_motion(RunFindingKind::TooFast, motion, *dt, *step, *time)));
    }
    for Halving { cause, motion, count, step, time, dt } in measures.halvings {
        match motion {
            Some(_) if measures.chooses_steps => (),
            Some(motion) => found.push(RunFinding::of_motion(RunFindingKind::Motion, motion, *dt, *step, *time)),
            None if *cause == Failure::INEXACT => (),
            None => {
                let value = *count as f64 / last.step.max(1) as f64;
                let explanation = format!("{count} halvings in {} accepted steps, the first at dt = {}", last.step, rounded(*dt));
                let kind = RunFindingKind::Failures(cause);
                if value > HALVED {
                    found.push(RunFinding { kind, contact: None, value, limit: HALVED, step: *step, time: *time, explanation });
                }
            }
        }
    }
    found
}

/// Finding on the static step with the largest unexplained share of the energy; `None` below the limit.
fn leap(At { value, step, time }: At, scale: f64) -> Option<RunFinding> {
    let (value, kind) = (value / scale, RunFindingKind::Leap);
    let explanation = format!("the forces at both ends of a step leave {} of the energy unexplained", percent(value));
    let found = RunFinding { kind, contact: None, value, limit: LEAP, step, time, explanation };
    (value > LEAP).then_some(found)
}

/// Relative energy added by contact, in the worst step or in all explicit steps together: its limit, the value, a description.
fn given(seen: &Gathered, scale: f64, is_explicit: bool, end: impl Fn(f64) -> At) -> (f64, At, String) {
    if is_explicit {
        // Explicit steps book contact work at both ends: energy that the integrator removes in these steps is subtracted.
        let [_, work, defects] = seen.sums;
        let net = (work + defects.min(0.0)) / scale;
        return (CONSERVED, end(net), format!("its work in all steps together was {net:.1e} of the energy"));
    }
    (GIVEN, seen.given, format!("its work in a step was {:.1e} of the energy", seen.given.value))
}

#[cfg(test)]
mod tests {
    use super::super::ledger::ContactTotals;
    use super::*;

    fn rows() -> Vec<LedgerRow> {
        let row = |step: usize| LedgerRow {
            step,
            time: 0.1 * step as f64,
            kinetic: 2.0,
            contacts: vec![ContactTotals::default(); if step == 0 { 0 } else { 2 }],
            ..LedgerRow::default()
        };
        (0..5).map(row).collect()
    }

    fn measures<'a>() -> Measures<'a> {
        Measures {
            contacts: vec![("race", 0.5), ("floor", 0.1)],
            stiffness: 1.0,
            round_off: 0.0,
            defect: Some(1e-11),
            integrator: "midpoint",
            is_explicit: false,
            is_static: false,
            halvings: &[],
            chooses_steps: false,
            refused: &[],
            factorizations: 1000,
            discarded: 10,
        }
    }

    #[test]
    fn a_run_as_it_should_be_has_no_findings() {
        assert_eq!(run_findings(&rows(), &measures()), []);
        assert_eq!(run_findings::<[LedgerRow]>(&[], &measures()), []);
        let mut rows = rows();
        rows[2].contact_work = 1e-12;
        rows[3].energy_defect = -1e-11;
        rows[3].contacts[0].penetration = 0.049;
        assert_eq!(run_findings(&rows, &measures()), [], "round-off, and a depth of 0.098 facets");
        for row in &mut rows {
            (row.kinetic, row.contact_work, row.energy_defect) = (1e-30, row.contact_work * 1e-19, row.energy_defect * 1e-19);
        }
        assert_eq!(run_findings(&rows, &measures()), [], "at rest all is round-off");
    }

    #[test]
    fn each_finding_tells_where_it_was_worst() {
        let mut rows = rows();
        rows[1].contact_work = 1e-9;
        rows[2].contact_work = 1e-6;
        rows[2].energy_defect = -4e-11;
        rows[3].contact_work = -0.4;
        rows[3].contacts[1].penetration = 0.03;
        rows[4].reserve = 0.1;
        let found = run_findings(&rows, &measures());
        let told: Vec<(&str, Option<&str>, usize)> =
            found.iter().map(|finding| (finding.kind.name(), finding.contact.as_deref(), finding.step)).collect();
        assert_eq!(
            told,
            [
                ("positive_contact_work", None, 2),
                ("energy_defect", None, 2),
                ("depth", Some("floor"), 3),
                ("energy_taken", None, 3),
                ("reserve_held", None, 4),
            ]
        );
        for (finding, value) in found.iter().zip([1e-6 / 2.0, 4e-11 / 2.0, 0.03 / 0.1, 0.4 / 2.0, 0.1 / 2.0]) {
            assert!((finding.value / value - 1.0).abs() < 1e-12, "{finding}: {}", finding.value);
        }
    }

    #[test]
    fn an_integrator_that_does_not_conserve_is_named() {
        let found = |defects: [f64; 4]| {
            let mut rows = rows();
            for (row, defect) in rows[1..].iter_mut().zip(defects) {
                row.energy_defect = defect;
                row.kinetic = 2.0 + defect;
            }
            run_findings(&rows, &Measures { defect: None, ..measures() })
        };
        assert_eq!(found([1e-12, -1e-10, 0.0, 1e-9]), []);
        let took = found([1e-4, -3e-4, 0.0, 1e-4]);
        assert_eq!((took[0].kind, took[0].step, took.len()), (RunFindingKind::NotConserved, 2, 1));
        assert!(took[0].explanation.starts_with("midpoint took 0.0002 of energy"), "{}", took[0].explanation);
        assert!(found([1e3, 0.0, 0.0, 0.0])[0].explanation.starts_with("midpoint made 501.0 times of it"));
    }

    #[test]
    fn halvings_are_told_with_their_cause() {
        let motion = LargeMotion { contact: "race".into(), kind: MotionKind::Sliding, facets: 1.5 };
        let sliding = Halving { cause: "sliding", motion: Some(motion), count: 1, step: 2, time: 0.2, dt: 0.1 };
        let failed = Halving { cause: "divergence", motion: None, count: 2, step: 3, time: 0.3, dt: 0.05 };
        let halvings = [sliding, failed];
        let found = run_findings(&rows(), &Measures { halvings: &halvings, ..measures() });
        let kinds: Vec<&str> = found.iter().map(|finding| finding.kind.name()).collect();
        assert_eq!(kinds, ["sliding", "failed_steps"]);
        assert_eq!((found[0].value, found[0].limit, found[0].contact.as_deref()), (1.5, SLIDING, Some("race")));
        assert_eq!((found[1].value, found[1].to_string().as_str()), (0.5, "steps are taken back and halved: divergence"));
        let refused = run_findings(&rows(), &Measures { refused: &halvings[..1], ..measures() });
        assert_eq!(refused[0].to_string(), "steps are too large: fast sliding in contact \"race\"");
        let mut long = rows();
        long[4].step = 400;
        assert_eq!(run_findings(&long, &Measures { halvings: &halvings[1..], ..measures() }), [], "2 halvings in 400 steps");
    }

    #[test]
    fn every_kind_is_listed() {
        use MotionKind::{Approach, CameThrough, Passing, Sliding};
        use RunFindingKind::{
            BeyondTable, CoarseCells, Crushed, Depth, Discarded, EnergyDefect, EnergyTaken, Failures, Leap, Motion, NotConserved,
            PassedObstacle, PassedThrough, PositiveContactWork, ReserveHeld, TakenOver, TooFast, Turned,
        };
        let kinds = [PositiveContactWork, EnergyDefect, NotConserved, Leap, Depth, EnergyTaken, ReserveHeld];
        let kinds = kinds.into_iter().chain([Sliding, Approach, CameThrough, Passing].map(Motion)).chain([
            TooFast(Sliding),
            PassedThrough,
            PassedObstacle,
            Turned,
            Crushed,
            BeyondTable,
            CoarseCells,
            Failures("divergence"),
            Discarded,
            TakenOver,
        ]);
        let names: Vec<&str> = kinds.map(RunFindingKind::name).collect();
        assert_eq!(names, RunFindingKind::ALL.iter().map(|(name, _)| *name).collect::<Vec<_>>());
    }
}
