//! Checkpoints of random models at random times: a continued run has the same bytes, and a damaged checkpoint is refused.

use std::sync::Arc;

use conserva::bodies::{Formulation, Inertia};
use conserva::contact::{Coulomb, METHODS};
use conserva::dynamics::{
    Anchor, Coefficient, End, Friction, Interaction, JointDefinition, JointKind, LedgerRow, Model, Options, Partner, Simulation,
    SpringDefinition, SpringElement, SpringLaw, State, StepControl, UPDATE_RULES,
};
use conserva::integrators::{BDF2, ENERGY_MOMENTUM, HHT, MIDPOINT, Scheme, TR_BDF2};
use conserva::materials::{Branch, Viscosity};
use conserva::mesh::{Mesh, block, rectangle};
use conserva::output::checkpoint::{Checkpoint, SavedSimulation};
use proptest::prelude::*;
use proptest::sample::{Index, select};
use proptest::strategy::ValueTree;
use proptest::test_runner::{RngSeed, TestRunner};

use crate::common::{Builder, material};

/// Kind of a model.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// Two blocks that are thrown at each other in the plane.
    Collision,
    /// Two blocks that are thrown at each other in space.
    CollisionInSpace,
    /// A rigid bar on a joint at the ground, pulled by a spring, that falls on a block.
    Hammer,
}

/// Model, integrator, and time of the checkpoint.
#[derive(Clone, Debug)]
struct Case {
    kind: Kind,
    scheme: &'static Scheme,
    method: usize,
    rule: usize,
    friction: f64,
    speed: f64,
    spin: f64,
    is_viscous: bool,
    chooses_steps: bool,
    steps: [usize; 2],
}

fn cases() -> impl Strategy<Value = Case> {
    let kinds = select(vec![Kind::Collision, Kind::Collision, Kind::CollisionInSpace, Kind::Hammer, Kind::Hammer]);
    let schemes = select(vec![&ENERGY_MOMENTUM, &ENERGY_MOMENTUM, &MIDPOINT, &HHT, &BDF2, &TR_BDF2]);
    let contact = (0..METHODS.len(), 0..UPDATE_RULES.len(), select(vec![0.0, 0.3]));
    let motion = (0.5..3.0f64, -2.0..2.0f64);
    (kinds, schemes, contact, motion, any::<[bool; 2]>(), (1..10usize, 1..10usize)).prop_map(
        |(kind, scheme, (method, rule, friction), (speed, spin), [is_viscous, chooses_steps], (before, after))| Case {
            kind,
            scheme,
            method,
            rule,
            friction,
            speed,
            spin,
            is_viscous,
            chooses_steps,
            steps: [before, after],
        },
    )
}

/// The node of a mesh that is nearest to a point.
fn nearest(mesh: &Mesh, point: [f64; 3]) -> u32 {
    let distance = |node: &usize| (0..3).map(|i| (mesh.points[*node][i] - point[i]).powi(2)).sum::<f64>();
    (0..mesh.points.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("it has nodes") as u32
}

impl Case {
    /// Model of the case.
    fn model(&self) -> Model {
        let branches = vec![Branch { shear_modulus: 20.0, relaxation_time: 0.1 }];
        let viscosity = Viscosity { shear: 0.05, bulk: 0.02, branches };
        let rubber = material("neo_hookean", [100.0, 0.3, 1.0]);
        let rubber = if self.is_viscous { rubber.with_viscosity(viscosity) } else { rubber };
        let mut builder = Builder::default();
        let (meshes, is_plane) = match self.kind {
            Kind::Collision => ([rectangle([1.0, 1.0], [3, 3], [0.0; 2]), rectangle([1.0, 1.0], [2, 2], [1.02, 0.1])], true),
            Kind::CollisionInSpace => ([block([1.0; 3], [2, 2, 2], [0.0; 3]), block([1.0; 3], [1, 1, 1], [1.02, 0.1, 0.05])], false),
            Kind::Hammer => ([rectangle([1.0, 0.5], [3, 2], [1.2, -0.52]), rectangle([2.0, 0.1], [8, 1], [0.0, 0.0])], true),
        };
        let [first, second] = meshes.map(|mesh| mesh.expect("the mesh is sound"));
        let ends = [(0, nearest(&first, [1.5, -0.02, 0.0])), (1, nearest(&second, [1.5, 0.1, 0.0]))];
        let inertia = Inertia::of_mesh(&second, &rubber, Formulation::default()).expect("no cell is inside out");
        builder.body("first", first, &rubber);
        builder.body("second", second, &rubber);
        let (secondary, primary) = match self.kind {
            Kind::Hammer => {
                builder.fix(0, "bottom", [true; 3]);
                builder.model.bodies[1].rigid = Some(inertia);
                let anchor = |body| Anchor { body, point: [0.0, 0.05, 0.0] };
                let ends = [anchor(None), anchor(Some(1))];
                builder.model.joints.push(JointDefinition {
                    name: "pivot".into(),
                    kind: JointKind::Point,
                    ends,
                    drive: None,
                    limits: None,
                    friction: None,
                });
                builder.set_initial_velocity(1, [0.0; 3], [0.0; 3]);
                builder.model.gravity = [0.0, -self.speed, 0.0];
                ("top", "bottom")
            }
            _ => {
                let turning = if is_plane { [0.0, 0.0, self.spin] } else { [0.5 * self.spin, 0.0, self.spin] };
                builder.set_initial_velocity(0, [self.speed, 0.0, 0.0], [0.0; 3]);
                builder.set_initial_velocity(1, [-self.speed, 0.0, 0.0], turning);
                ("right", "left")
            }
        };
        let pair = Interaction::new("pair", builder.boundary(0, secondary), Partner::Surfaces(vec![builder.boundary(1, primary)]));
        let friction = Friction { law: Arc::new(Coulomb::default()), coefficient: Coefficient::Constant(self.friction) };
        builder.model.interactions.push(Interaction {
            method: if is_plane { METHODS[self.method] } else { pair.method },
            update: Some(UPDATE_RULES[self.rule]),
            friction: (self.friction > 0.0).then_some(friction),
            ..pair
        });
        let law = SpringLaw::linear(20.0);
        let spring =
            SpringDefinition { name: "spring".into(), ends: ends.map(End::from), element: SpringElement { law, rest_length: Some(0.5) } };
        builder.model.parts.push(Arc::new(spring));
        builder.model
    }

    /// Simulation, or `None` if the integrator does not support the model.
    fn simulation(&self, model: &Model, threads: usize) -> Option<Simulation> {
        let control = self.chooses_steps.then_some(StepControl { tolerance: 1e-3, smallest: None, largest: None, plastic_strain: None });
        Simulation::new(model, Options { control, threads, ..Options::new(self.scheme, 0.01) }).ok()
    }
}

/// Takes steps; returns the rows of the accepted ones, and the error that ended them.
fn advance(simulation: &mut Simulation, steps: usize) -> (Vec<LedgerRow>, Option<String>) {
    let mut rows = Vec::new();
    let failed = (0..steps).find_map(|_| simulation.step(None, &mut |row| rows.push(row.clone())).err());
    (rows, failed.map(|error| error.to_string()))
}

/// The checkpoint of a simulation.
fn checkpoint(simulation: &Simulation) -> Checkpoint {
    let (state, tally) = (Some(simulation.shared_state()), simulation.tally());
    Checkpoint { simulations: vec![SavedSimulation { state, tally, ..SavedSimulation::default() }], ..Checkpoint::default() }
}

fn state_of(checkpoint: &Checkpoint) -> &State {
    checkpoint.simulations[0].state.as_ref().expect("it was saved")
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 30, rng_seed: RngSeed::Fixed(2007), failure_persistence: None, ..Default::default() })]

    #[test]
    fn what_goes_on_from_a_checkpoint_comes_to_the_same_bytes(case in cases()) {
        let model = case.model();
        let Some(mut simulation) = case.simulation(&model, 1) else { return Ok(()) };
        let [before, after] = case.steps;
        advance(&mut simulation, before);
        let bytes = checkpoint(&simulation).to_bytes();
        let read = Checkpoint::from_bytes(&bytes).expect("it is whole");
        prop_assert!(read == checkpoint(&simulation) && read.to_bytes() == bytes, "a checkpoint comes back as it was");
        let mut resumed = case.simulation(&model, 2).expect("the model is the same");
        prop_assert!(resumed.fits(state_of(&read)));
        resumed.restore(state_of(&read));
        resumed.count_from(&read.simulations[0].tally);
        prop_assert_eq!(advance(&mut simulation, after), advance(&mut resumed, after), "the same ledger");
        prop_assert!(checkpoint(&simulation).to_bytes() == checkpoint(&resumed).to_bytes(), "the same bytes");
    }

    #[test]
    fn a_damaged_checkpoint_is_refused(case in cases(), at in any::<Index>(), flipped in 1..=u8::MAX) {
        let Some(mut simulation) = case.simulation(&case.model(), 1) else { return Ok(()) };
        advance(&mut simulation, case.steps[0].min(3));
        let mut bytes = checkpoint(&simulation).to_bytes();
        let place = at.index(bytes.len());
        prop_assert!(Checkpoint::from_bytes(&bytes[..place]).is_err(), "its end is missing");
        bytes[place] ^= flipped;
        prop_assert!(Checkpoint::from_bytes(&bytes).is_err(), "byte {place} is another one");
    }

    /// A checkpoint written by hand can have a valid checksum: its content is refused, or the run continues, or a step fails.
    #[test]
    fn a_state_of_other_bytes_is_refused_or_gone_on_from(case in cases(), at in any::<Index>(), flipped in 1..=u8::MAX) {
        let Some(mut simulation) = case.simulation(&case.model(), 1) else { return Ok(()) };
        advance(&mut simulation, case.steps[0].min(3));
        let mut bytes = postcard::to_stdvec(&simulation.state()).expect("a state can be written");
        let place = at.index(bytes.len());
        bytes[place] ^= flipped;
        let Ok(state) = postcard::from_bytes::<State>(&bytes) else { return Ok(()) };
        if simulation.fits(&state) {
            simulation.restore(&state);
            advance(&mut simulation, 1);
        }
    }
}

#[test]
fn most_random_cases_are_models_that_run() {
    let mut runner = TestRunner::deterministic();
    let (mut stepped, mut touched) = (0, 0);
    for _ in 0..40 {
        let case = cases().new_tree(&mut runner).expect("there are cases").current();
        let Some(mut simulation) = case.simulation(&case.model(), 1) else { continue };
        let (rows, _) = advance(&mut simulation, 10);
        stepped += usize::from(!rows.is_empty());
        touched += usize::from(rows.iter().any(|row| row.active > 0));
    }
    assert!(stepped > 25 && touched > 10, "{stepped} of 40 take steps, {touched} touch");
}
