//! Run of a scene, with the evaluation of the oracles after every nominal step.

use std::panic::{AssertUnwindSafe, catch_unwind};

use conserva::dynamics::{FailureCause, LedgerRow, Options, Simulation, VELOCITY};
use conserva::integrators::ENERGY_MOMENTUM;

use super::Scene;
use super::geometry::{length, subtract};
use super::oracle::{Depth, Oracle, Sums};

/// Largest gain of energy over the energy scale: two hundred steps with Newton's tolerance of 1e-13, and round-off of positions.
pub const GAIN: f64 = 1e-10;

/// Largest excess of shear over the friction limit, over the largest limit so far.
pub const CONE: f64 = 1e-9;

/// Largest energy defect of a step, over the energy scale.
pub const DEFECT: f64 = 1e-11;

/// Largest change of the momenta over a whole run without external forces, over their scales.
pub const MOMENTUM: f64 = 1e-10;

/// Difference between the energies of the ledger and of the oracle, over the energy scale: both sum some hundred terms of the same
/// positions.
pub const DISAGREEMENT: f64 = 1e-12;

/// Largest penetration of a node and of crossing facets, over the coarser facet.
pub const DEPTH: f64 = 0.1;

/// Number of iterations, including refused steps, after which a run is abandoned: a mean of thirty in two hundred steps.
const ITERATIONS: usize = 6000;

/// Kinds of faults of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fault {
    /// The model was refused, a step failed, or the code panicked.
    Failed,
    /// A cell of a Saint Venant-Kirchhoff body is inverted: in strong compression this law loses its stiffness, and the scene has no
    /// solution. This is no fault of contact.
    Crushed,
    /// The run was abandoned because of its many iterations.
    Slow,
    /// The energy has grown: above the smallest value so far, with the rule `velocity` (which stores impact energy) above the largest.
    Gained,
    /// Friction has created energy.
    Rubbed,
    /// The friction force exceeds its limit.
    Cone,
    /// The ledger does not close.
    Defect,
    /// Linear or angular momentum has changed without external forces.
    Momentum,
    /// The energies of the ledger and of the oracle differ.
    Ledger,
    /// The penetration of a node or of crossing facets is too large.
    Deep,
    /// An open contact stores energy, or has a force.
    Apart,
}

impl Fault {
    pub const ALL: [Fault; 11] = [
        Fault::Failed,
        Fault::Crushed,
        Fault::Slow,
        Fault::Gained,
        Fault::Rubbed,
        Fault::Cone,
        Fault::Defect,
        Fault::Momentum,
        Fault::Ledger,
        Fault::Deep,
        Fault::Apart,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Fault::Failed => "FAILED",
            Fault::Crushed => "CRUSHED",
            Fault::Slow => "SLOW",
            Fault::Gained => "GAINED",
            Fault::Rubbed => "RUBBED",
            Fault::Cone => "CONE",
            Fault::Defect => "DEFECT",
            Fault::Momentum => "MOMENTUM",
            Fault::Ledger => "LEDGER",
            Fault::Deep => "DEEP",
            Fault::Apart => "APART",
        }
    }
}

/// A fault of a run with its first occurrence and its largest value.
#[derive(Clone, Debug)]
pub struct Finding {
    pub fault: Fault,
    /// Nominal step of the first occurrence.
    pub first: usize,
    /// Nominal step of the largest value.
    pub worst_step: usize,
    /// Largest value of the violated quantity.
    pub worst: f64,
    /// Message of the error, or place of the violation.
    pub text: String,
}

/// Figures of a nominal step; energies over the energy scale.
#[derive(Clone, Debug, Default)]
pub struct Record {
    pub step: usize,
    pub time: f64,
    pub sums: Sums,
    /// Change of the total energy since the start.
    pub change: f64,
    /// Energy gained so far.
    pub gain: f64,
    /// Largest defect of the rows of the ledger.
    pub defect: f64,
    /// Change of linear and angular momentum since the start, over their scales.
    pub momentum: f64,
    /// Difference between the energies of the ledger and of the oracle.
    pub disagreement: f64,
    pub depth: Depth,
    pub crossing: Depth,
    /// Stored impact energy of closed contacts, from the ledger.
    pub reserve: f64,
    /// Largest friction work of a substep, which must not be positive.
    pub friction_gain: f64,
    /// Excess of the shear of a constraint over the friction limit, over the largest limit so far.
    pub cone: f64,
    /// Energy dissipated by contact since the start, from the ledger.
    pub lost: f64,
    /// Stored impact energy at the end of a substep at which no contact is closed.
    pub reserve_when_open: f64,
    /// Largest force of a contact in a substep at whose start and end it is open, over the largest force of any contact.
    pub across: f64,
    /// Largest penetration in the ledger.
    pub reported: f64,
    pub iterations: usize,
    pub halvings: usize,
    pub active: usize,
}

/// Figures of a run.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    pub findings: Vec<Finding>,
    /// Number of nominal steps taken.
    pub steps: usize,
    /// Number of accepted substeps.
    pub pieces: usize,
    pub iterations: usize,
    pub halvings: usize,
    /// Number of steps that ended in contact.
    pub touching: usize,
    pub cells: usize,
    /// Largest values of the run, as in a nominal step.
    pub gain: f64,
    pub friction_gain: f64,
    pub cone: f64,
    pub defect: f64,
    pub momentum: f64,
    pub disagreement: f64,
    pub depth: f64,
    pub crossing: f64,
    /// Largest difference between the reported penetration and that from positions, over a facet.
    pub misread: f64,
    /// Energy dissipated by contact.
    pub lost: f64,
}

impl Outcome {
    pub fn has(&self, fault: Fault) -> bool {
        self.findings.iter().any(|finding| finding.fault == fault)
    }

    /// Largest penetration of nodes and of crossing facets.
    pub fn deepest(&self) -> f64 {
        self.depth.max(self.crossing)
    }

    fn find(&mut self, fault: Fault, step: usize, value: f64, text: &str) {
        match self.findings.iter_mut().find(|finding| finding.fault == fault) {
            Some(finding) if value > finding.worst || value.is_nan() => {
                (finding.worst, finding.worst_step, finding.text) = (value, step, text.into());
            }
            Some(_) => {}
            None => self.findings.push(Finding { fault, first: step, worst_step: step, worst: value, text: text.into() }),
        }
    }

    fn fail(&mut self, step: usize, text: &str) {
        self.find(Fault::Failed, step, f64::INFINITY, text);
    }

    /// Adds a step and judges it.
    fn add(&mut self, record: &Record) {
        let step = record.step;
        self.steps = step;
        self.touching += usize::from(record.active > 0);
        let mut judge = |fault: Fault, largest: fn(&mut Outcome) -> &mut f64, value: f64, limit: f64, text: &str| {
            let known = largest(self);
            *known = if value.is_nan() { value } else { known.max(value) };
            if value > limit || value.is_nan() {
                self.find(fault, step, value, text);
            }
        };
        judge(Fault::Gained, |outcome| &mut outcome.gain, record.gain, GAIN, "");
        judge(Fault::Rubbed, |outcome| &mut outcome.friction_gain, record.friction_gain, DEFECT, "");
        judge(Fault::Cone, |outcome| &mut outcome.cone, record.cone, CONE, "");
        judge(Fault::Defect, |outcome| &mut outcome.defect, record.defect, DEFECT, "");
        judge(Fault::Momentum, |outcome| &mut outcome.momentum, record.momentum, MOMENTUM, "");
        judge(Fault::Ledger, |outcome| &mut outcome.disagreement, record.disagreement, DISAGREEMENT, "");
        judge(Fault::Deep, |outcome| &mut outcome.depth, record.depth.facets, DEPTH, &record.depth.place);
        judge(Fault::Deep, |outcome| &mut outcome.crossing, record.crossing.facets, DEPTH, &record.crossing.place);
        if record.reserve_when_open > 0.0 {
            self.find(Fault::Apart, step, record.reserve_when_open, "of the energy kept");
        }
        if record.across > 0.0 {
            self.find(Fault::Apart, step, record.across, "of the force across a gap");
        }
        self.lost = record.lost;
        let facet = if record.depth.facets > 0.0 { record.depth.length / record.depth.facets } else { f64::INFINITY };
        self.misread = self.misread.max((record.reported - record.depth.length).abs() / facet);
    }
}

/// Scales of energies and momenta of a scene.
#[derive(Clone, Copy, Debug)]
struct Scales {
    energy: f64,
    momentum: f64,
    angular_momentum: f64,
}

impl Scales {
    /// Scales: the kinetic energy at the start plus the energy of a fall through the height of the scene, and the momentum of the total
    /// mass with this energy.
    fn new(scene: &Scene, oracle: &Oracle, start: &Sums) -> Scales {
        let (mass, gravity) = (oracle.mass(), scene.gravity_size());
        let height = if gravity > 0.0 { oracle.extent(scene.gravity.map(|g| g / gravity)) } else { 0.0 };
        let energy = start.kinetic + mass * gravity * height;
        // A scene without energy stays at rest; any gain is too much.
        let energy = if energy > 0.0 { energy } else { f64::MIN_POSITIVE };
        let momentum = (2.0 * mass * energy).sqrt();
        Scales { energy, momentum, angular_momentum: momentum * oracle.reach() }
    }
}

/// Runs a scene to its end or to its failure; `watch` is called with every nominal step. A panic is a finding.
pub fn run(scene: &Scene, watch: &mut dyn FnMut(&Record)) -> Outcome {
    let mut outcome = Outcome::default();
    if let Err(payload) = catch_unwind(AssertUnwindSafe(|| take(scene, &mut outcome, watch))) {
        let text = payload.downcast_ref::<String>().map(String::as_str).or_else(|| payload.downcast_ref::<&str>().copied());
        let step = outcome.steps + 1;
        outcome.fail(step, &format!("panicked: {}", text.unwrap_or("without a word")));
    }
    outcome
}

/// A simulation of the scene.
///
/// # Errors
/// Errors of the kernels for the model.
pub fn simulate(scene: &Scene) -> Result<Simulation, String> {
    simulate_with_reach(scene, 1.0)
}

/// Simulation of the scene with a larger search horizon of contact.
fn simulate_with_reach(scene: &Scene, reach: f64) -> Result<Simulation, String> {
    let model = scene.model().map_err(|error| error.to_string())?;
    let options = Options { reach, ..Options::new(&ENERGY_MOMENTUM, scene.dt) };
    Simulation::new(&model, options).map_err(|error| error.to_string())
}

/// First step in which positions, velocities or rows of the ledger change a byte if the search horizon of contact is `reach` times as
/// large; a failed step is compared by its error.
///
/// # Errors
/// Errors of the kernels for the model.
pub fn first_difference(scene: &Scene, reach: f64) -> Result<Option<usize>, String> {
    let mut sims = [simulate(scene)?, simulate_with_reach(scene, reach)?];
    let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    for step in 1..=scene.steps {
        let [ours, theirs] = sims.each_mut().map(|sim| {
            // As text a number has all its digits, and zero its sign.
            let mut rows = String::new();
            let taken = sim.step(None, &mut |row: &LedgerRow| rows += &format!("{row:?}"));
            let state = sim.shared_state();
            (bits(&state.positions), bits(&state.velocities), rows, taken.map_err(|error| error.to_string()))
        });
        if ours != theirs {
            return Ok(Some(step));
        }
        if ours.3.is_err() || sims[0].statistics().newton_iterations > ITERATIONS {
            break;
        }
    }
    Ok(None)
}

fn take(scene: &Scene, outcome: &mut Outcome, watch: &mut dyn FnMut(&Record)) {
    let (mut sim, oracle) = match (simulate(scene), Oracle::new(scene)) {
        (Ok(sim), Ok(oracle)) => (sim, oracle),
        (Err(error), _) => return outcome.fail(0, &error),
        (_, Err(error)) => return outcome.fail(0, &error.to_string()),
    };
    outcome.cells = oracle.cells();
    let state = sim.shared_state();
    let start = oracle.sums(&state.positions, &state.velocities);
    let scales = Scales::new(scene, &oracle, &start);
    let is_alone = scene.walls.is_empty() && scene.gravity_size() == 0.0;
    let offset = start.total() - sim.row().total();
    // Reference of the energy gain: with the rule `velocity` the greatest energy so far, with the others the least.
    let mut bound = start.total();
    // State of each contact at the end of the previous substep; energy dissipated so far; largest force of a contact; largest friction
    // limit.
    let (mut was_closed, mut lost, mut force, mut borne) = (Vec::new(), 0.0, 0.0f64, 0.0f64);
    for step in 1..=scene.steps {
        let mut record = Record { step, ..Record::default() };
        let mut pieces = 0;
        let taken = sim.step(None, &mut |row: &LedgerRow| {
            pieces += 1;
            record.iterations += row.newton_iterations;
            record.halvings += row.halvings;
            record.defect = worse(record.defect, row.energy_defect.abs() / scales.energy);
            lost -= (row.contact_work + row.friction_work) / scales.energy;
            record.friction_gain = worse(record.friction_gain, row.friction_work / scales.energy);
            if row.active == 0 {
                record.reserve_when_open = record.reserve_when_open.max(row.reserve / scales.energy);
            }
            for (k, contact) in row.contacts.iter().enumerate() {
                force = force.max(contact.normal_force);
                if contact.active == 0 && !was_closed.get(k).is_some_and(|closed| *closed) && contact.normal_force > 0.0 {
                    record.across = record.across.max(contact.normal_force / force);
                }
            }
            was_closed = row.contacts.iter().map(|contact| contact.active > 0).collect();
        });
        outcome.pieces += pieces;
        outcome.iterations += record.iterations;
        outcome.halvings += record.halvings;
        if let Err(error) = taken {
            let fault = if is_crushed(scene, &sim) { Fault::Crushed } else { Fault::Failed };
            return outcome.find(fault, step, f64::INFINITY, &error.to_string());
        }
        let multipliers = sim.friction_multipliers();
        borne = multipliers.iter().map(|[pressing, _]| scene.friction * pressing).fold(borne, f64::max);
        let beyond = multipliers.iter().map(|[pressing, shear]| shear.abs() - scene.friction * pressing.max(0.0));
        record.cone = beyond.fold(0.0, worse) / borne.max(f64::MIN_POSITIVE);
        let (state, row) = (sim.shared_state(), sim.row());
        record.sums = oracle.sums(&state.positions, &state.velocities);
        let total = record.sums.total();
        (record.time, record.active, record.reported, record.reserve) = (row.time, row.active, row.max_penetration, row.reserve);
        record.lost = lost;
        record.change = (total - start.total()) / scales.energy;
        record.gain = (total - bound) / scales.energy;
        bound = if scene.rule == &VELOCITY { bound.max(total) } else { bound.min(total) };
        // The stored impact energy is not part of the energy of the bodies.
        record.disagreement = (total - (row.total() - row.reserve) - offset).abs() / scales.energy;
        if is_alone {
            let linear = length(subtract(record.sums.momentum, start.momentum)) / scales.momentum;
            record.momentum = worse(linear, (record.sums.angular_momentum - start.angular_momentum).abs() / scales.angular_momentum);
        }
        (record.depth, record.crossing) = (oracle.deepest(&state.positions), oracle.crossing(&state.positions));
        outcome.add(&record);
        watch(&record);
        if sim.statistics().newton_iterations > ITERATIONS {
            return outcome.find(Fault::Slow, step, sim.statistics().newton_iterations as f64, "iterations so far");
        }
    }
}

/// True if the last step failed because a cell of a law that permits it was inverted.
fn is_crushed(scene: &Scene, sim: &Simulation) -> bool {
    let Some(FailureCause::InvertedCell { body, .. }) = sim.failure().map(|report| &report.cause) else { return false };
    scene.bodies.iter().enumerate().any(|(k, other)| *body == format!("body {k}") && other.law == "saint_venant_kirchhoff")
}

/// The larger number; NaN if one is NaN.
fn worse(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}
