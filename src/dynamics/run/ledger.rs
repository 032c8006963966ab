//! The ledger: changes of energy and momenta in a step, by cause.

use serde::{Deserialize, Serialize};

use crate::bodies::{Elements, Space};
use crate::dynamics::model::joints::{Coordinate, JointDefinition};
use crate::dynamics::model::part::{Part, PartDefinition, Pose};
use crate::dynamics::model::quantity::Quantity;
use crate::dynamics::parts::body::Body;
use crate::dynamics::step::system::System;
use crate::math::tolerances;

/// One accepted step in numbers; a row of `history.csv`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LedgerRow {
    /// Number of the accepted step, 0 for the initial state.
    pub step: usize,
    /// Time at the end of the step `[time]`.
    pub time: f64,
    /// Size of the step `[time]`, 0 for the initial state.
    pub dt: f64,
    /// Kinetic energy `[energy]`.
    pub kinetic: f64,
    /// Strain energy `[energy]`.
    pub strain: f64,
    /// Potential energy of gravity, of springs, viscous materials and penalty potentials, and the stored impact energy of closed contacts
    /// `[energy]`.
    pub potential: f64,
    /// Stored impact energy of active contacts under the `velocity` rule, taken at closing and returned at opening, part of the potential
    /// `[energy]`.
    pub reserve: f64,
    /// Work of loads in this step `[energy]`.
    pub load_work: f64,
    /// Work of contact in this step that the update rule loses or gains on purpose `[energy]`.
    pub contact_work: f64,
    /// Work of friction in contacts and joints in this step `[energy]`, never positive: heat.
    pub friction_work: f64,
    /// Part of the friction work in joints `[energy]`, never positive.
    pub joint_friction: f64,
    /// Energy dissipated in this step by viscous materials, dampers and drag, by plastic flow, by the time integrator's algorithmic
    /// dissipation, and in impacts of rigid bodies by restitution `[energy]`, never negative.
    pub dissipation: f64,
    /// Part of the dissipation in dampers and drag `[energy]`.
    pub damping: f64,
    /// Part of the dissipation by the time integrator `[energy]`.
    pub numerical: f64,
    /// Part of the dissipation in impacts of rigid bodies by restitution `[energy]`, never negative.
    pub impact: f64,
    /// Part of the dissipation by plastic flow `[energy]`, never negative.
    pub plastic: f64,
    /// `change of total - load_work - contact_work - friction_work + dissipation` of this step `[energy]`: round-off when the scheme
    /// conserves.
    pub energy_defect: f64,
    /// Work that the mean of the largest forces since the start does on the round-off of positions `[energy]`: changes of the energy
    /// below it mean nothing.
    pub work_round_off: f64,
    /// Linear momentum `[mass * length/time]`.
    pub momentum: [f64; 3],
    /// Angular momentum about the origin; in the plane only the third component.
    pub angular_momentum: [f64; 3],
    /// Largest component of the linear momentum's change that neither loads nor reactions explain.
    pub momentum_defect: f64,
    /// Largest component of the angular momentum's change that neither loads nor reactions explain.
    pub angular_momentum_defect: f64,
    /// Newton iterations of the step: those of the attempt that solved it, of attempts that failed before, and of steps that were refused
    /// and halved.
    pub newton_iterations: usize,
    /// Numeric factorisations of the step, including those of failed attempts and of refused steps.
    pub factorizations: usize,
    /// Number of halvings before the step was accepted.
    pub halvings: usize,
    /// Number of active contact nodes.
    pub active: usize,
    /// Largest penetration of a node of either side in the other body `[length]`, 0 without penetration.
    pub max_penetration: f64,
    /// Totals of each contact pair, in the order of the model; empty before the first step.
    pub contacts: Vec<ContactTotals>,
    /// Reactions of each boundary with supports, then of each coupling, in the order of
    /// [`Model::reaction_names`](crate::dynamics::Model::reaction_names); empty before the first step.
    pub reactions: Vec<Reaction>,
    /// Heat of plastic flow since the start of each body whose material flows, in the order of the model `[energy]`.
    pub plastic_work: Vec<f64>,
    /// Totals of each part of [`Model::parts`](crate::dynamics::Model::parts), in their order.
    pub parts: Vec<PartTotals>,
    /// Totals of each joint of the model, in their order; empty before the first step.
    pub joints: Vec<JointTotals>,
    /// Values of each watched node ([`PresentState::watch`](crate::dynamics::PresentState::watch)), in the order of the requests.
    pub probes: Vec<ProbeValues>,
}

/// Columns of the ledger for models in space, in the order of `history.csv`.
const COLUMNS: [Quantity; 27] = [
    Quantity::number("step"),
    Quantity::new("time", "time"),
    Quantity::new("dt", "time"),
    Quantity::new("kinetic", "energy"),
    Quantity::new("strain", "energy"),
    Quantity::new("potential", "energy"),
    Quantity::new("total", "energy"),
    Quantity::new("load_work", "energy"),
    Quantity::new("contact_work", "energy"),
    Quantity::new("energy_defect", "energy"),
    Quantity::new("momentum_x", "mass * velocity"),
    Quantity::new("momentum_y", "mass * velocity"),
    Quantity::new("momentum_z", "mass * velocity"),
    Quantity::new("angular_momentum", "mass * area/time"),
    Quantity::new("angular_momentum_x", "mass * area/time"),
    Quantity::new("angular_momentum_y", "mass * area/time"),
    Quantity::new("angular_momentum_z", "mass * area/time"),
    Quantity::new("momentum_defect", "mass * velocity"),
    Quantity::new("angular_momentum_defect", "mass * area/time"),
    Quantity::number("newton_iterations"),
    Quantity::number("halvings"),
    Quantity::number("active"),
    Quantity::new("max_penetration", "length"),
    Quantity::new("reserve", "energy"),
    Quantity::new("dissipation", "energy"),
    Quantity::number("factorizations"),
    Quantity::new("friction_work", "energy"),
];

/// Columns of a force.
const FORCE: [Quantity; 3] = [Quantity::new("force_x", "force"), Quantity::new("force_y", "force"), Quantity::new("force_z", "force")];

/// Columns of a moment in space.
const MOMENT: [Quantity; 3] =
    [Quantity::new("moment_x", "force * length"), Quantity::new("moment_y", "force * length"), Quantity::new("moment_z", "force * length")];

/// Sums over a contact pair; forces and pressures are means over the step, the velocity jump of the `velocity` rule included.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ContactTotals {
    /// Number of secondary nodes in contact.
    pub active: usize,
    /// Resultant of the contact forces on the secondary side, friction included `[force]`.
    pub force: [f64; 3],
    /// Sum of the magnitudes of the normal nodal forces `[force]`.
    pub normal_force: f64,
    /// Contact area of the secondary surface: a length in the plane, an area in space and around an axis.
    pub area: f64,
    /// Largest pressure at a secondary node `[stress]`.
    pub pressure: f64,
    /// Largest penetration of a node of either side in the other body `[length]`, 0 without penetration.
    pub penetration: f64,
    /// Work of friction in the step `[energy]`, never positive.
    pub friction_work: f64,
    /// Number of secondary nodes that slide against friction, of those that `active` counts.
    pub sliding: usize,
}

impl ContactTotals {
    /// Columns in a history for a space dimension.
    pub fn columns(dimension: usize) -> Vec<Quantity> {
        let further = [
            Quantity::new("normal_force", "force"),
            Quantity::new("area", "area"),
            Quantity::new("max_pressure", "stress"),
            Quantity::number("active"),
            Quantity::new("max_penetration", "length"),
            Quantity::new("friction_work", "energy"),
            Quantity::number("sliding"),
        ];
        FORCE[..dimension].iter().copied().chain(further).collect()
    }

    /// Values of the columns, in the order of [`Self::columns`].
    pub fn values(&self, dimension: usize) -> Vec<f64> {
        let counts = [self.active, self.sliding].map(|count| count as f64);
        let further = [self.normal_force, self.area, self.pressure, counts[0], self.penetration, self.friction_work, counts[1]];
        self.force[..dimension].iter().copied().chain(further).collect()
    }
}

/// Quantities of a part in the history.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PartTotals {
    /// Values by the names of [`PartDefinition::readings`](crate::dynamics::PartDefinition::readings), at the end of the step.
    pub readings: Vec<f64>,
    /// Dissipation of the part in the step `[energy]`.
    pub dissipated: f64,
}

impl PartTotals {
    /// History columns of a force element.
    pub fn columns(part: &dyn PartDefinition) -> impl Iterator<Item = Quantity> {
        part.readings().iter().copied().chain(part.dissipates().then_some(Quantity::new("dissipation", "energy")))
    }

    /// Values of the part's columns: readings, then dissipation.
    pub fn values(&self, part: &dyn PartDefinition) -> impl Iterator<Item = f64> {
        self.readings.iter().copied().chain(part.dissipates().then_some(self.dissipated))
    }
}

/// Forces of the supports of a boundary, as means over the step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reaction {
    /// Resultant `[force]`.
    pub force: [f64; 3],
    /// Moment about the origin `[force * length]`; in the plane only the third component.
    pub moment: [f64; 3],
}

impl Reaction {
    /// Columns in a history for a space dimension.
    pub fn columns(dimension: usize) -> Vec<Quantity> {
        if dimension == 2 { [&FORCE[..2], &[Quantity::new("moment", "force * length")]].concat() } else { [FORCE, MOMENT].concat() }
    }

    /// Values of the columns: force, then moment.
    pub fn values(&self, dimension: usize) -> Vec<f64> {
        let moment = if dimension == 2 { &self.moment[2..] } else { &self.moment[..] };
        self.force[..dimension].iter().chain(moment).copied().collect()
    }
}

/// Force and moment of a joint on its second body, means over the step, and its coordinate at the end of the step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct JointTotals {
    /// The force `[force]`.
    pub force: [f64; 3],
    /// The moment about the joint's point on that body `[force * length]`; in the plane the third component.
    pub moment: [f64; 3],
    /// Coordinate of the joint: an angle that counts whole turns `[rad]`, or a length; NaN for a joint without a coordinate.
    pub value: f64,
    /// Work of the drive in the step `[energy]`.
    pub work: f64,
    /// Friction along the coordinate on its second body, included in force and moment: a force or, of an angle, a moment; of a ball joint
    /// the size of the moment.
    pub friction: f64,
    /// Work of friction in the step `[energy]`, never positive.
    pub friction_work: f64,
}

impl JointTotals {
    /// Columns in a history.
    pub fn columns(joint: &JointDefinition, dimension: usize) -> Vec<Quantity> {
        let mut columns = Reaction::columns(dimension);
        columns.extend(joint.kind.coordinate(dimension).map(Coordinate::quantity));
        columns.extend(joint.drive.as_ref().map(|_| Quantity::new("work", "energy")));
        if joint.friction.is_some() {
            let dimension = if joint.kind.rotates(dimension) { "force * length" } else { "force" };
            columns.extend([Quantity::new("friction", dimension), Quantity::new("friction_work", "energy")]);
        }
        columns
    }

    /// Values of the joint's columns: force, moment, coordinate, work of the drive, friction and its work.
    pub fn values(&self, joint: &JointDefinition, dimension: usize) -> Vec<f64> {
        let mut values = Reaction { force: self.force, moment: self.moment }.values(dimension);
        values.extend(joint.kind.coordinate(dimension).map(|_| self.value));
        values.extend(joint.drive.as_ref().map(|_| self.work));
        values.extend(joint.friction.iter().flat_map(|_| [self.friction, self.friction_work]));
        values
    }
}

/// Motion of a watched node.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ProbeValues {
    /// Displacement `[length]`.
    pub displacement: [f64; 3],
    /// Velocity `[length/time]`.
    pub velocity: [f64; 3],
    /// Acceleration `[length/time^2]`: change of the velocity in the step divided by the step size, 0 at rest.
    pub acceleration: [f64; 3],
}

impl ProbeValues {
    /// Columns in a history for a space dimension.
    pub fn columns(dimension: usize) -> Vec<Quantity> {
        let names = [["ux", "uy", "uz"], ["vx", "vy", "vz"], ["ax", "ay", "az"]];
        let all = names.iter().zip(["length", "velocity", "length/time^2"]);
        all.flat_map(|(names, of)| names[..dimension].iter().map(move |name| Quantity::new(name, of))).collect()
    }

    /// Values of the columns: displacement, velocity, acceleration.
    pub fn values(&self, dimension: usize) -> Vec<f64> {
        [&self.displacement, &self.velocity, &self.acceleration].iter().flat_map(|vector| vector[..dimension].iter().copied()).collect()
    }
}

/// Total dissipation of parts and time integrator, the contribution of the model's own parts, and that of the integrator `[energy]`; no
/// negative zeros.
pub(super) fn heat(dissipated: &[f64], own: &[PartTotals], numerical: f64) -> [f64; 3] {
    let [all, own] = [dissipated.iter().sum(), own.iter().map(|part| part.dissipated).sum()].map(|sum: f64| sum + 0.0);
    [all + numerical, own, numerical]
}

impl LedgerRow {
    /// Heap memory of the row's lists `[bytes]`.
    pub(super) fn heap_size(&self) -> usize {
        let readings = self.parts.iter().map(|part| size_of_val(&part.readings[..])).sum::<usize>();
        let lists = size_of_val(&self.contacts[..]) + size_of_val(&self.reactions[..]) + size_of_val(&self.joints[..]);
        lists + size_of_val(&self.plastic_work[..]) + size_of_val(&self.parts[..]) + readings + size_of_val(&self.probes[..])
    }

    /// Adds the heat of plastic flow in a step after the row `before`, with that of each part, bodies first.
    pub(super) fn book_plastic<const D: usize>(&mut self, bodies: &[Body<D>], before: &LedgerRow, plastic: &[f64]) {
        let flowing = bodies.iter().enumerate().filter(|(_, body)| body.elements.flows());
        let heat: Vec<f64> = flowing.map(|(index, _)| plastic.get(index).copied().unwrap_or(0.0)).collect();
        self.plastic = heat.iter().sum::<f64>() + 0.0; // `+ 0.0` turns -0.0 into 0.0.
        self.plastic_work = before.plastic_work.clone();
        self.plastic_work.resize(heat.len(), 0.0);
        self.plastic_work.iter_mut().zip(heat).for_each(|(sum, heat)| *sum += heat);
    }

    /// Books the work of friction in each contact, and in the joints.
    pub(super) fn book_friction(&mut self, contacts: &[f64]) {
        self.joint_friction = self.joints.iter().map(|joint| joint.friction_work).sum::<f64>() + 0.0; // `+ 0.0` turns -0.0 into 0.0.
        self.friction_work = contacts.iter().sum::<f64>() + self.joint_friction;
    }

    /// Adds the heat of plastic flow since the row `before` as the dissipation of one step at rest.
    pub(super) fn book_flow_at_rest(&mut self, before: &LedgerRow) {
        let total = |row: &LedgerRow| row.plastic_work.iter().sum::<f64>() + 0.0; // `+ 0.0` turns -0.0 into 0.0.
        self.plastic = total(self) - total(before);
        self.dissipation = self.plastic;
    }
}

impl<const D: usize> System<D>
where
    Space<D>: Elements<D>,
{
    /// History values of the model's own parts; `dissipated` is the dissipation of every part in the last step, empty after a rest.
    pub(super) fn part_totals(&self, at: Pose, velocity: &[f64], memory: &[Vec<f64>], dissipated: &[f64]) -> Vec<PartTotals> {
        let before = self.bodies.len() + self.loads.len();
        let heat = |index: usize| dissipated.get(before + index).copied().unwrap_or(0.0);
        let totals = |(index, (part, memory)): (usize, (&dyn Part, &Vec<f64>))| PartTotals {
            readings: part.readings(at, velocity, memory),
            dissipated: heat(index),
        };
        self.own_parts(memory).enumerate().map(totals).collect()
    }
}

/// Largest component of the change of a momentum from `old` to `new` beyond the sum of its causes.
pub(super) fn unexplained([new, old]: [[f64; 3]; 2], [first, second]: [[f64; 3]; 2]) -> f64 {
    (0..3).map(|i| (new[i] - old[i] - first[i] - second[i]).abs()).fold(0.0, f64::max)
}

impl LedgerRow {
    /// Adds the earlier stages of a step to the row of a stage of size `own`: works are summed, forces are means over the elapsed part of
    /// the whole step of size `whole`. `before` is the row of the earlier stages, `first` the number of the step before the whole step.
    pub(super) fn join(&mut self, before: &LedgerRow, first: usize, own: f64, whole: f64) {
        let passed = if before.step > first { before.dt } else { 0.0 };
        self.step = first + 1;
        self.dt = if (passed + own - whole).abs() > tolerances::SAME_MOMENT * whole { passed + own } else { whole };
        if passed == 0.0 {
            return;
        }
        let sums = |row: &LedgerRow| [row.load_work, row.contact_work, row.friction_work, row.dissipation, row.damping, row.energy_defect];
        self.joint_friction += before.joint_friction;
        self.numerical += before.numerical;
        self.impact += before.impact;
        self.plastic += before.plastic;
        let [load, contact, friction, dissipation, damping, defect] = sums(before);
        self.load_work += load;
        self.contact_work += contact;
        self.friction_work += friction;
        self.dissipation += dissipation;
        self.damping += damping;
        self.energy_defect += defect;
        self.momentum_defect += before.momentum_defect;
        self.angular_momentum_defect += before.angular_momentum_defect;
        let share = own / (passed + own);
        let mean = |now: &mut f64, then: f64| *now = share * *now + (1.0 - share) * then;
        for (now, then) in self.contacts.iter_mut().zip(&before.contacts) {
            (0..3).for_each(|i| mean(&mut now.force[i], then.force[i]));
            mean(&mut now.normal_force, then.normal_force);
            mean(&mut now.pressure, then.pressure);
            now.friction_work += then.friction_work;
        }
        self.parts.iter_mut().zip(&before.parts).for_each(|(now, then)| now.dissipated += then.dissipated);
        let mean_of_all = |now: [&mut [f64; 3]; 2], then: [[f64; 3]; 2]| {
            now.into_iter().flatten().zip(then.into_iter().flatten()).for_each(|(now, then)| mean(now, then));
        };
        for (now, then) in self.joints.iter_mut().zip(&before.joints) {
            mean_of_all([&mut now.force, &mut now.moment], [then.force, then.moment]);
            mean(&mut now.friction, then.friction);
            now.work += then.work;
            now.friction_work += then.friction_work;
        }
        for (now, then) in self.reactions.iter_mut().zip(&before.reactions) {
            mean_of_all([&mut now.force, &mut now.moment], [then.force, then.moment]);
        }
    }

    /// `kinetic + strain + potential` `[energy]`.
    pub fn total(&self) -> f64 {
        self.kinetic + self.strain + self.potential
    }

    /// Reference energy of defects: `kinetic + strain + |potential|`, which does not vanish where the potential cancels the other terms
    /// `[energy]`.
    pub fn energy_scale(&self) -> f64 {
        self.kinetic + self.strain + self.potential.abs()
    }

    /// Columns of `history.csv` for a space dimension, in order.
    pub fn columns(dimension: usize) -> Vec<Quantity> {
        let is_of = |column: &&Quantity| match column.name {
            "momentum_z" | "angular_momentum_x" | "angular_momentum_y" | "angular_momentum_z" => dimension == 3,
            _ => true,
        };
        COLUMNS.iter().filter(is_of).copied().collect()
    }

    /// The value of a column; `None` for an unknown name. In space `angular_momentum` is the length of the vector.
    pub fn column(&self, name: &str) -> Option<f64> {
        Some(match name {
            "step" => self.step as f64,
            "time" => self.time,
            "dt" => self.dt,
            "kinetic" => self.kinetic,
            "strain" => self.strain,
            "potential" => self.potential,
            "total" => self.total(),
            "load_work" => self.load_work,
            "contact_work" => self.contact_work,
            "energy_defect" => self.energy_defect,
            "dissipation" => self.dissipation,
            "friction_work" => self.friction_work,
            "momentum_x" => self.momentum[0],
            "momentum_y" => self.momentum[1],
            "momentum_z" => self.momentum[2],
            "angular_momentum_x" => self.angular_momentum[0],
            "angular_momentum_y" => self.angular_momentum[1],
            "angular_momentum_z" => self.angular_momentum[2],
            "angular_momentum" => match self.angular_momentum {
                [0.0, 0.0, z] => z,
                [x, y, z] => x.hypot(y).hypot(z),
            },
            "momentum_defect" => self.momentum_defect,
            "angular_momentum_defect" => self.angular_momentum_defect,
            "newton_iterations" => self.newton_iterations as f64,
            "factorizations" => self.factorizations as f64,
            "halvings" => self.halvings as f64,
            "active" => self.active as f64,
            "max_penetration" => self.max_penetration,
            "reserve" => self.reserve,
            _ => return None,
        })
    }
}
