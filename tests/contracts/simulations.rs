//! Contract of simulations for every integrator, material and cell kind: constants of free flight, order in time, independence of the place
//! of the model, of the number of threads and of interruptions.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use conserva::dynamics::{LoadKind, Model, Options, Simulation, State, StepError, Tally, TimeFunction, TimeFunctionError};
use conserva::elements::CellKind;
use conserva::integrators::{self, ENERGY_MOMENTUM, Scheme};
use conserva::materials::{CATALOGUE, Material, MaterialRow, NeoHookean};
use conserva::mesh::{Mesh, block, rectangle, ring};

use crate::common::{Builder, difference, drift, run, worst};

/// Number of laws at the beginning of the catalogue whose pressure waves in the plane are as slow as shear waves, so that steps resolve
/// them; the other laws are nearly incompressible.
const SLOW: usize = 3;

/// A soft bar, 2 x 1 (x 1), that spins fast enough to stretch by some percent: waves travel at about 10 lengths per time.
fn bar(kind: CellKind) -> Mesh {
    let mesh = match kind.dimension() {
        2 if kind.is_quadratic() => rectangle([2.0, 1.0], [2, 1], [0.5, -1.0]),
        2 => rectangle([2.0, 1.0], [4, 2], [0.5, -1.0]),
        _ => block([2.0, 1.0, 1.0], [3, 2, 2], [0.5, -1.0, 0.2]),
    };
    mesh.and_then(|mesh| mesh.with_cells(kind)).expect("the mesh is sound")
}

fn soft(row: &'static MaterialRow) -> Material {
    Material::new(row, &row.example(100.0, 1.0)).expect("the values are in their ranges")
}

const LINEAR: [f64; 3] = [1.0, -0.5, 0.0];

fn thrown(kind: CellKind, row: &'static MaterialRow) -> Builder {
    let mut builder = Builder::default();
    let body = builder.body("bar", bar(kind), &soft(row));
    let (linear, angular) = if kind.dimension() == 2 { (LINEAR, [0.0, 0.0, 3.0]) } else { ([LINEAR[0], LINEAR[1], 0.7], [0.5, 3.0, 1.0]) };
    builder.set_initial_velocity(body, linear, angular);
    builder
}

/// Cell kinds without those that take seconds. Cells of second order in space are covered by the contract of bodies, since schemes use
/// forces only, and by script tests in free flight.
fn light_kinds() -> impl Iterator<Item = CellKind> {
    CellKind::ALL.iter().copied().filter(|kind| !(kind.dimension() == 3 && kind.is_quadratic()))
}

/// Every cell kind and every law with one scheme, and every scheme with one cell kind of each dimension and one law: a scheme uses forces
/// independently of their origin.
fn combinations() -> impl Iterator<Item = (CellKind, &'static MaterialRow, &'static Scheme)> {
    let of_kind = |kind: CellKind| CATALOGUE.iter().map(move |row| (kind, row, &ENERGY_MOMENTUM));
    light_kinds().flat_map(of_kind).chain(every_other_scheme())
}

/// Every scheme but the first with one cell kind of each dimension and one law.
fn every_other_scheme() -> impl Iterator<Item = (CellKind, &'static MaterialRow, &'static Scheme)> {
    let others = || integrators::CATALOGUE.iter().copied().filter(|scheme| **scheme != ENERGY_MOMENTUM);
    [CellKind::Quad4, CellKind::Hex8].into_iter().flat_map(move |kind| others().map(move |scheme| (kind, &CATALOGUE[0], scheme)))
}

fn for_all(check: impl Fn(CellKind, &'static MaterialRow, &'static Scheme, &str)) {
    for (kind, row, integrator) in combinations() {
        check(kind, row, integrator, &format!("{} {} {}", kind.name(), row.title(), integrator.name));
    }
}

#[test]
fn free_flight_keeps_what_each_integrator_promises() {
    for_all(|kind, row, integrator, name| {
        let mut sim = thrown(kind, row).simulate(integrator, 0.05);
        let rows = run(&mut sim, 2.0);
        assert_eq!(rows.len(), 41, "{name}: no step is halved");
        let energy = rows[0].total();
        let momentum = drift(&rows, |row| row.momentum);
        let angular_momentum = drift(&rows, |row| row.angular_momentum);
        let defect = worst(&rows, |row| row.energy_defect);
        let dissipated: f64 = rows.iter().map(|row| row.dissipation).sum();
        let gain = (rows[40].total() + dissipated - energy).abs();
        let least = rows.iter().map(|row| row.dissipation).fold(0.0, f64::min);
        assert!(least == 0.0 && (dissipated > 1e-6 * energy) != integrator.dissipation.is_none(), "{name}: dissipates {dissipated:.1e}");
        // All quantities are of order ten. The error of a step is set by Newton's tolerance, 1e-13 of the energy, and by round-off of the
        // solution.
        assert!(worst(&rows, |row| row.strain) > 1e-3 * energy, "{name}: the bar deforms");
        let integrators::ConservedQuantities {
            energy: keeps_energy,
            angular_momentum: keeps_angular_momentum,
            momentum: keeps_momentum,
            ..
        } = integrator.promises;
        assert_eq!(defect < 1e-11 * energy, keeps_energy, "{name}: energy defect {defect:.1e} of {energy}");
        assert_eq!(gain < 1e-10 * energy, keeps_energy, "{name}: energy gained {gain:.1e} of {energy}");
        assert_eq!(momentum < 1e-11, keeps_momentum, "{name}: linear momentum drifts by {momentum:.1e}");
        assert_eq!(angular_momentum < 1e-10, keeps_angular_momentum, "{name}: angular momentum drifts by {angular_momentum:.1e}");
    });
}

/// Positions at `t = 0.2` of a bar that spins and was stretched by a tenth, in `steps` steps.
fn stretched(kind: CellKind, row: &'static MaterialRow, integrator: &'static Scheme, steps: usize) -> Vec<f64> {
    let mut sim = thrown(kind, row).simulate(integrator, 0.2 / steps as f64);
    let mut state = sim.state();
    let dimension = kind.dimension();
    for x in state.positions.iter_mut().step_by(dimension) {
        *x += 0.1 * (*x - 1.5);
    }
    sim.restore(&state);
    run(&mut sim, 0.2);
    sim.state().positions
}

#[test]
fn every_integrator_is_of_the_promised_order_in_time() {
    // One reference for all schemes with the same bar, step size and law, which share the limit. Its error is 1/64 of that of the finest
    // run of a scheme of second order.
    let mut references: HashMap<(&str, String, usize), Vec<f64>> = HashMap::new();
    // The laws in turn over the kinds: a law and a kind enter a scheme by forces, which the contract of bodies compares with energies for
    // every law with every kind.
    let in_turn = light_kinds().enumerate().map(|(k, kind)| (kind, &CATALOGUE[k % SLOW], &ENERGY_MOMENTUM));
    for (kind, row, integrator) in in_turn.chain(every_other_scheme()) {
        // One reference is used for schemes of first and second order.
        if integrator.promises.order > 2 {
            continue;
        }
        // Cells of second order and thin tetrahedra vibrate faster.
        let resolved = if kind.is_quadratic() || kind == CellKind::Tet4 { 2 } else { 1 };
        // Damping schemes reach their order if steps resolve the vibrations.
        let finer = resolved * if integrator.is_long() { 4 } else { 1 };
        let reference =
            references.entry((kind.name(), row.title(), finer)).or_insert_with(|| stretched(kind, row, &ENERGY_MOMENTUM, 640 * finer));
        let finer = if integrator.promises.order == 1 { 32 * resolved } else { finer };
        let errors = [20, 40, 80].map(|steps| difference(&stretched(kind, row, integrator, steps * finer), reference));
        let rates = [errors[0] / errors[1], errors[1] / errors[2]].map(f64::log2);
        let name = format!("{} {} {}", kind.name(), row.title(), integrator.name);
        println!("{name}: errors {errors:.8?}, rates {rates:.3?}");
        // The reference's own error adds 0.02 to the rate, the next term of the error some hundredths.
        assert!((rates[1] - integrator.promises.order as f64).abs() < 0.1, "{name}: rates {rates:?}");
    }
}

#[test]
fn a_model_that_stands_elsewhere_behaves_the_same() {
    for_all(|kind, row, integrator, name| {
        let builder = thrown(kind, row);
        // Fibers turn with the body, in the plane of the first two axes.
        let material = soft(row);
        let is_plain = material.energy().is_none_or(|energy| energy.fibers.is_empty());
        let axis = if kind.dimension() == 3 && is_plain { [1.0, 2.0, -0.5] } else { [0.0, 0.0, 1.0] };
        let turned = if is_plain { material } else { material.turned(0.7f64.cos(), 0.7f64.sin()).expect("it turns") };
        let rotation = nalgebra::Rotation3::from_axis_angle(&nalgebra::Unit::new_normalize(nalgebra::Vector3::from(axis)), 0.7);
        let turn = |vector: [f64; 3]| -> [f64; 3] { (rotation * nalgebra::Vector3::from(vector)).into() };
        let shift = if kind.dimension() == 2 { [3.0, -2.0, 0.0] } else { [3.0, -2.0, 5.0] };
        let mesh = bar(kind).rotate_about(0.7, [0.0; 3], axis).expect("it turns").translate(shift).expect("it moves");
        let thrown = builder.model.initial_velocities[0];
        let mut moved = Builder::default();
        moved.body("bar", mesh, &turned);
        moved.set_initial_velocity(0, turn(thrown.linear), turn(thrown.angular));
        let (mut here, mut there) = (builder.simulate(integrator, 0.05), moved.simulate(integrator, 0.05));
        let (rows, others) = (run(&mut here, 1.0), run(&mut there, 1.0));
        let (positions, expected) = (there.state().positions, here.state().positions);
        let dimension = kind.dimension();
        for (node, (x, y)) in expected.chunks_exact(dimension).zip(positions.chunks_exact(dimension)).enumerate() {
            let image = turn(std::array::from_fn(|i| if i < dimension { x[i] } else { 0.0 }));
            for i in 0..dimension {
                // Newton's method stops at 1e-13 of the energy, an error of up to its root in the least stiff motions; observed: 1e-9.
                assert!((image[i] + shift[i] - y[i]).abs() < 1e-8, "{name}: node {node} {image:?} {y:?}");
            }
        }
        for (a, b) in rows.iter().zip(&others) {
            assert!((a.strain - b.strain).abs() < 1e-7 * rows[0].total(), "{name}: strain energies {} {}", a.strain, b.strain);
        }
    });
}

#[test]
fn one_and_two_threads_give_the_same_bytes() {
    let rubber = NeoHookean { youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 }.material().expect("in range");
    for mesh in [rectangle([2.0, 1.0], [32, 16], [0.0; 2]), block([2.0, 1.0, 1.0], [8, 6, 6], [0.0; 3])] {
        let mut builder = Builder::default();
        builder.body("bar", mesh.expect("the mesh is sound"), &rubber);
        builder.set_initial_velocity(0, [1.0, 0.0, 0.0], [0.0, 0.0, 3.0]);
        let states = [1, 2].map(|threads| {
            let options = Options { threads, ..Options::new(&ENERGY_MOMENTUM, 0.05) };
            let mut sim = Simulation::new(&builder.model, options).expect("the model is sound");
            run(&mut sim, 0.15);
            sim.state()
        });
        assert!(states[0] == states[1]);
    }
}

/// Models for states: a free body, and two rings in contact.
fn resumable() -> [Builder; 2] {
    let rubber = NeoHookean { youngs_modulus: 1e3, poisson_ratio: 0.3, density: 1.0 }.material().expect("in range");
    let mut alone = Builder::default();
    alone.body("ring", ring(0.5, 1.0, [2, 16], [0.0; 2], 0.0).expect("the mesh is sound"), &rubber);
    alone.set_initial_velocity(0, [1.0, 0.0, 0.0], [0.0, 0.0, 3.0]);
    alone.load(0, "inner", LoadKind::Torque([0.0, 0.0, 1.0]), conserva::dynamics::Sine { amplitude: 1.0, frequency: 2.0 });
    let mut touching = Builder::default();
    touching.body("left", ring(0.5, 1.0, [2, 16], [-1.02, 0.0], 0.0).expect("the mesh is sound"), &rubber);
    touching.body("right", ring(0.6, 1.0, [2, 20], [1.02, 0.3], 0.0).expect("the mesh is sound"), &rubber);
    touching.contact((0, "outer"), (1, "outer"));
    touching.set_initial_velocity(0, [4.0, 0.0, 0.0], [0.0, 0.0, 3.0]);
    [alone, touching]
}

#[test]
fn a_restored_state_goes_on_as_the_run_did() {
    for builder in resumable() {
        for &integrator in integrators::CATALOGUE {
            let mut sim = builder.simulate(integrator, 0.005);
            run(&mut sim, 0.05);
            let middle = sim.state();
            let rows = run(&mut sim, 0.1);
            let mut other = builder.simulate(integrator, 0.005);
            other.restore(&middle);
            assert!(other.state() == middle, "a state comes back as it was");
            let again = run(&mut other, 0.1);
            assert_eq!(rows, again, "{}: the same ledger", integrator.name);
            assert!(sim.state() == other.state(), "{}: the same bytes", integrator.name);
        }
    }
}

/// A ring that is pressed into another one and rotates in it.
fn sliding_rings() -> Builder {
    let steel = NeoHookean { youngs_modulus: 1e5, poisson_ratio: 0.1, density: 1e-3 }.material().expect("in range");
    let mut builder = Builder::default();
    let outer = builder.body("outer ring", ring(1.0, 1.5, [2, 48], [0.0; 2], 0.0).expect("the mesh is sound"), &steel);
    let inner = builder.body("inner ring", ring(0.5, 1.002, [2, 40], [0.0; 2], 0.0).expect("the mesh is sound"), &steel);
    builder.fix(outer, "outer", [true; 3]);
    builder.contact((inner, "outer"), (outer, "inner"));
    builder.set_initial_velocity(inner, [0.0; 3], [0.0, 0.0, 20.0]);
    builder
}

/// Sliding contact changes the search, the matrix pattern and the elimination order; all of them are part of the state.
#[test]
fn a_state_of_sliding_bodies_goes_on_to_the_same_bytes() {
    let builder = sliding_rings();
    for &integrator in integrators::CATALOGUE {
        // Two thirds of a facet a step.
        let mut sim = builder.simulate(integrator, 0.005);
        sim.settle().expect("there is an equilibrium");
        let advance = |sim: &mut Simulation, steps: usize| {
            (0..steps).for_each(|_| sim.step(None, &mut |_| ()).expect("the step converges"));
            sim.state()
        };
        let start = sim.state();
        let kept = advance(&mut sim, 8);
        let end = advance(&mut sim, 8);
        assert!(start.row.active > 0 && kept.row.active > 0, "{}: the rings touch", integrator.name);
        for (state, steps) in [(&kept, 8), (&start, 16)] {
            sim.restore(state);
            assert!(sim.state() == *state);
            assert!(advance(&mut sim, steps) == end, "{}: {steps} steps again", integrator.name);
            let mut branch = builder.simulate(integrator, 0.005);
            branch.restore(state);
            assert!(advance(&mut branch, steps) == end, "{}: {steps} steps of a branch", integrator.name);
            // A checkpoint is one call.
            let bytes = postcard::to_stdvec(state).expect("a state can be written");
            let read: State = postcard::from_bytes(&bytes).expect("and read");
            assert!(read == *state);
            branch.restore(&read);
            assert!(advance(&mut branch, steps) == end, "{}: {steps} steps from bytes", integrator.name);
        }
    }
}

#[test]
fn what_was_counted_goes_on_from_its_bytes() {
    let builder = sliding_rings();
    // Three facets a step: halved before it is tried.
    let mut sim = builder.simulate(&ENERGY_MOMENTUM, 0.02);
    sim.settle().expect("there is an equilibrium");
    sim.step(None, &mut |_| ()).expect("the step converges");
    assert!(!sim.halvings().is_empty(), "steps are halved");
    let bytes = postcard::to_stdvec(&sim.tally()).expect("it can be written");
    let tally: Tally = postcard::from_bytes(&bytes).expect("and read");
    let mut branch = builder.simulate(&ENERGY_MOMENTUM, 0.02);
    branch.restore(&sim.state());
    branch.count_from(&tally);
    for sim in [&mut sim, &mut branch] {
        sim.step(None, &mut |_| ()).expect("the step converges");
    }
    assert_eq!((branch.tally(), branch.halvings()), (sim.tally(), sim.halvings()));
}

/// Types of a simulation that can be sent to another thread.
const _: fn() = || {
    fn is_send<T: Send>() {}
    is_send::<Model>();
    is_send::<Simulation>();
    is_send::<State>();
    is_send::<StepError>();
};

#[test]
fn simulations_on_threads_of_their_own_give_the_same_bytes() {
    for builder in resumable() {
        let advanced = |model: Model| {
            let mut sim = Simulation::new(&model, Options::new(&ENERGY_MOMENTUM, 0.005)).expect("the model is sound");
            run(&mut sim, 0.05);
            sim
        };
        let sims = [0, 1].map(|_| builder.model.clone()).map(|model| std::thread::spawn(move || advanced(model)));
        let [first, second] = sims.map(|sim| sim.join().expect("the run ends").state());
        assert!(first == second && first == advanced(builder.model).state());
    }
}

/// Time function that is ended in one of its calls, by an interrupt or by an error.
struct CutShort {
    calls: Arc<AtomicUsize>,
    at: usize,
    interrupt: Option<Arc<AtomicBool>>,
}

impl TimeFunction for CutShort {
    fn value(&self, time: f64) -> Result<f64, TimeFunctionError> {
        if self.calls.fetch_add(1, Ordering::Relaxed) + 1 < self.at {
            return Ok(time);
        }
        if let Some(flag) = &self.interrupt {
            flag.store(true, Ordering::Relaxed);
        }
        Err("cut short".into())
    }

    fn describe(&self) -> String {
        "cut short".into()
    }
}

#[test]
fn an_interrupt_within_a_time_function_is_no_mistake_of_it() {
    for interrupted in [true, false] {
        let (flag, calls) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicUsize::new(0)));
        let mut builder = Builder::default();
        let body = builder.body(
            "bar",
            bar(CellKind::Quad4),
            &NeoHookean { youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 }.material().expect("in range"),
        );
        builder.fix(body, "left", [true; 3]);
        let interrupt = interrupted.then(|| flag.clone());
        builder.load(body, "right", LoadKind::Traction([1.0, 0.0, 0.0]), CutShort { calls: calls.clone(), at: 20, interrupt });
        let options = Options { interrupt: Some(flag), ..Options::new(&ENERGY_MOMENTUM, 0.05) };
        let mut sim = Simulation::new(&builder.model, options).expect("the model is sound");
        let error = (0..20).find_map(|_| sim.step(None, &mut |_| ()).err()).expect("the time function is cut short");
        assert!(calls.load(Ordering::Relaxed) == 20 && sim.time() > 0.0);
        match error {
            StepError::Interrupted { time } => assert!(interrupted && time == sim.time(), "{time}"),
            StepError::Amplitude { .. } => assert!(!interrupted),
            other => panic!("{other}"),
        }
    }
}
