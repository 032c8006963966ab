//! Accumulated slip, slip path and heat of tangential constraints.

use serde::{Deserialize, Serialize};

use crate::contact::Evaluation;
use crate::dynamics::parts::contact_pair::{ContactPair, PairKind};
use crate::dynamics::parts::laws::RowState;
use crate::dynamics::step::contact_set::slips_at;
use crate::dynamics::step::equations::Equations;
use crate::dynamics::step::iterate::Linearization;
use crate::math::tolerances;

/// Accumulated slip of a tangential constraint; the path of a group is stored in its first one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SlipMemory {
    /// Slip in the last step, while active `[length]`.
    pub slip: f64,
    /// Sum of the magnitudes of slips since the start `[length]`.
    pub path: f64,
    /// Heat since the start `[energy]`.
    pub heat: f64,
}

/// Accumulated slips after a step that ends at an iterate, with the tangential multipliers `shear` in the step and the states `active` at
/// its end. `kept` is the factor of earlier slips in the last slip: 0, or 1 if the step is a substep.
pub fn slipped<const D: usize>(
    equations: &Equations<D>,
    before: &[SlipMemory],
    at: &Linearization,
    kept: f64,
    (shear, active): (&[f64], &[RowState]),
) -> Vec<SlipMemory> {
    let mut after = before.to_vec();
    for (pair, slips) in equations.pairs.iter().zip(&at.slips) {
        let Some(friction) = &pair.friction else { continue };
        for (local, normal_row) in pair.rows.clone().enumerate() {
            let group = friction.group(local);
            let own = group.start - friction.rows.start..group.end - friction.rows.start;
            let length = slips.coverage[own.start] * pair.kernel.weights()[local];
            let is_pressed = active[normal_row].is_closed() && length > 0.0;
            let memories = &mut after[group.start - equations.normal_count..group.end - equations.normal_count];
            let mut path = 0.0f64;
            let (shear, weighted) = (&shear[group], &slips.gap[own]);
            let has_heat = pair.friction_work(shear, weighted) != 0.0;
            for ((memory, weighted), shear) in memories.iter_mut().zip(weighted).zip(shear) {
                let slip = if is_pressed { weighted / length } else { 0.0 };
                memory.slip = kept * memory.slip + slip;
                path = path.hypot(slip);
                if has_heat {
                    memory.heat -= shear * weighted;
                }
            }
            memories[0].path += path;
        }
    }
    after
}

/// Adds the heat of friction in impacts, as its work on each tangential constraint.
pub fn add_heat(slipped: &mut [SlipMemory], work: &[f64]) {
    slipped.iter_mut().zip(work).for_each(|(memory, work)| memory.heat -= work);
}

/// Work of friction in each contact between two states of the accumulated slips `[energy]`.
pub fn friction_work<const D: usize>(equations: &Equations<D>, before: &[SlipMemory], after: &[SlipMemory]) -> Vec<f64> {
    let taken = |row: usize| before[row - equations.normal_count].heat - after[row - equations.normal_count].heat;
    equations.by_contact(|_, pair| pair.tangential().map(|(row, _)| taken(row)).sum())
}

/// Constraint blocks of joints with friction, and its work between two states of the accumulated slips `[energy]`.
pub fn joint_friction<'a, const D: usize>(
    equations: &'a Equations<D>,
    before: &'a [SlipMemory],
    after: &'a [SlipMemory],
) -> impl Iterator<Item = (&'a ContactPair, f64)> {
    let taken = move |row: usize| before[row - equations.normal_count].heat - after[row - equations.normal_count].heat;
    let joints = equations.pairs.iter().filter(|pair| pair.kind == PairKind::JointFriction);
    joints.map(move |pair| (pair, pair.tangential().map(|(row, _)| taken(row)).sum::<f64>() + 0.0))
}

/// Tangential constraints of a pair.
#[derive(Clone, Copy)]
pub struct Tangential<'a> {
    pub evaluation: &'a Evaluation,
    pub lambda: &'a [f64],
    pub active: &'a [RowState],
    pub slipped: &'a [SlipMemory],
    /// Number of tangential constraints per normal constraint.
    pub count: usize,
}

impl Tangential<'_> {
    /// Tangential multiplier of each normal constraint: the value, or the norm of several components.
    pub fn multipliers(&self) -> Vec<f64> {
        self.lambda.chunks_exact(self.count).map(size).collect()
    }

    /// Accumulated slip for each normal constraint.
    pub fn memories(&self) -> impl Iterator<Item = SlipMemory> {
        let of = |group: &[SlipMemory]| {
            let slips: Vec<f64> = group.iter().map(|memory| memory.slip).collect();
            SlipMemory { slip: size(&slips), path: group[0].path, heat: group.iter().map(|memory| memory.heat).sum() }
        };
        self.slipped.chunks_exact(self.count).map(of)
    }
}

/// Size of a group of tangential constraints: its single value, or the norm of several.
pub fn size(rows: &[f64]) -> f64 {
    match rows {
        [only] => *only,
        _ => rows.iter().map(|value| value * value).sum::<f64>().sqrt(),
    }
}

/// States of the constraints at the end of a step, in which tangential constraints without slip count as sticking. Where something else
/// prevents the slip, as a stop does in a joint, it is round-off which of the two a step ends with.
pub fn rested<const D: usize>(equations: &Equations<D>, at: &Linearization, mut active: Vec<RowState>) -> Vec<RowState> {
    for place in slips_at(equations, at) {
        let has_slipped = size(place.slips()).abs() > tolerances::CLEARLY * place.pair.gap_tolerance;
        if active[place.rows.start].slides() && !has_slipped {
            active[place.rows.clone()].fill(RowState::Closed);
        }
    }
    active
}
