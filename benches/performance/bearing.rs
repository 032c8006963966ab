//! Milliseconds per Newton iteration of the bearing by phase, and growth of each phase with the unknowns.
//!
//! A run is deterministic: step k costs the same work in every repetition. Each phase of each step is timed in every repetition, and the
//! minimum over the repetitions is summed over the steps. The influence of other programs on single steps is removed if one repetition of
//! the step is undisturbed; the machine need not be idle all the time. The processor time of whole steps is measured in the same way.

use std::error::Error;
use std::sync::Arc;
use std::time::{Duration, Instant};

use conserva::contact::Coulomb;
use conserva::dynamics::{Coefficient, Friction, Hat, LoadKind, Model, Options, Simulation, Statistics};
use conserva::integrators::ENERGY_MOMENTUM;
use conserva::materials::NeoHookean;
use conserva::mesh::{Change, Mesh, MeshError, ring};

use crate::linear::seconds;

/// Printed phases; the last one is the remainder.
const PHASES: [&str; 6] = ["assembly", "contact", "factorization", "solve", "search", "other"];

/// Kind of bearings, constructed from size and number of threads; Gauss points of a cell, and the lower bound in nanoseconds per point of
/// all variants of the element loop on a Zen 4 core.
pub struct Kind {
    name: &'static str,
    make: fn(usize, usize) -> Result<Simulation, Box<dyn Error>>,
    points: usize,
    floor: Option<f64>,
}

/// Plane bearing; the size multiplies all cell counts.
pub const IN_PLANE: Kind = Kind { name: "bearing", make: in_plane, points: 4, floor: Some(32.0) };

/// Bearing extruded along its axis; the size is the number of layers.
pub const IN_SPACE: Kind = Kind { name: "bearing in space", make: in_space, points: 8, floor: None };

/// Bearing extruded along its axis with a friction coefficient of 0.1.
pub const WITH_FRICTION: Kind = Kind { name: "bearing in space with friction 0.1", make: with_friction, points: 8, floor: None };

fn in_plane(refine: usize, threads: usize) -> Result<Simulation, Box<dyn Error>> {
    let steel = NeoHookean { youngs_modulus: 1e5, poisson_ratio: 0.1, density: 1e-3 }.material()?;
    let mut model = Model::new("bearing");
    let mesh = |inner, outer, around: usize| ring(inner, outer, [10 * refine, around * refine], [0.0; 2], 0.0);
    let outer = model.add_body("outer ring", mesh(1.0, 1.5, 48)?, &steel);
    let inner = model.add_body("inner ring", mesh(0.5, 1.002, 40)?, &steel);
    model.fix(model.boundary(outer, "outer")?, [true; 3]);
    model.add_contact("race", model.boundary(inner, "outer")?, model.boundary(outer, "inner")?);
    model.load(model.boundary(inner, "inner")?, LoadKind::Torque([0.0, 0.0, 1.0]), Hat { start: 0.0, end: 0.5, peak: 0.1 });
    // At every size a step slides by the same fraction of a facet.
    let options = Options { threads, ..Options::new(&ENERGY_MOMENTUM, 0.005 / refine as f64) };
    let mut sim = Simulation::new(&model, options)?;
    sim.settle()?;
    Ok(sim)
}

/// 14 520 unknowns with four layers; both rings are free.
fn in_space(layers: usize, threads: usize) -> Result<Simulation, Box<dyn Error>> {
    extruded(layers, threads, None)
}

fn with_friction(layers: usize, threads: usize) -> Result<Simulation, Box<dyn Error>> {
    let coefficient = Coefficient::Constant(0.1);
    extruded(layers, threads, Some(Friction { law: Arc::new(Coulomb::default()), coefficient }))
}

fn extruded(layers: usize, threads: usize, friction: Option<Friction>) -> Result<Simulation, Box<dyn Error>> {
    let steel = NeoHookean { youngs_modulus: 1e5, poisson_ratio: 0.1, density: 1e-3 }.material()?;
    let mut model = Model::new("bearing in space");
    let mesh = |inner, outer, around| -> Result<Mesh, MeshError> {
        ring(inner, outer, [10, around], [0.0; 2], 0.0)?.extruded(0.5, layers, 1.0, Change::NONE)
    };
    let outer = model.add_body("outer ring", mesh(1.0, 1.5, 48)?, &steel);
    let inner = model.add_body("inner ring", mesh(0.5, 1.002, 40)?, &steel);
    model.add_contact("race", model.boundary(inner, "outer")?, model.boundary(outer, "inner")?).friction = friction;
    model.load(model.boundary(inner, "inner")?, LoadKind::Torque([0.0, 0.0, 1.0]), Hat { start: 0.0, end: 0.2, peak: 0.05 });
    let options = Options { threads, ..Options::new(&ENERGY_MOMENTUM, 0.01) };
    let mut sim = Simulation::new(&model, options)?;
    sim.settle()?;
    Ok(sim)
}

fn phases(statistics: &Statistics) -> [Duration; 5] {
    let times = statistics.times;
    [times.assembly, times.contact, times.factorization, times.solve, times.search]
}

struct Timing {
    unknowns: usize,
    steps: usize,
    iterations: usize,
    factorizations: usize,
    cells: usize,
    /// Seconds of all steps by phase, and processor time of this thread.
    seconds: [f64; 6],
    processor: f64,
}

/// Minimum time of each phase of each step over all repetitions, summed.
fn measure(kind: &Kind, size: usize, steps: usize, repetitions: usize, threads: usize) -> Result<Timing, Box<dyn Error>> {
    let mut least = vec![[f64::INFINITY; 7]; steps];
    let start = Instant::now();
    let (mut unknowns, mut iterations, mut factorizations, mut cells) = (0, 0, 0, 0);
    for _ in 0..repetitions {
        let mut sim = (kind.make)(size, threads)?;
        // After the start-up: the pattern has been rebuilt and the active set has changed before timing begins.
        for _ in 0..5 {
            sim.step(None, &mut |_| ())?;
        }
        let before = sim.statistics();
        let mut counted = before;
        for least in &mut least {
            let (clock, processor) = (Instant::now(), seconds(start));
            sim.step(None, &mut |_| ())?;
            let whole = clock.elapsed();
            let now = sim.statistics();
            let mut parts = [0.0; 7];
            for (part, (a, b)) in parts.iter_mut().zip(phases(&counted).iter().zip(&phases(&now))) {
                *part = (*b - *a).as_secs_f64();
            }
            parts[5] = whole.as_secs_f64() - parts.iter().sum::<f64>();
            parts[6] = seconds(start) - processor;
            for (least, part) in least.iter_mut().zip(parts) {
                *least = least.min(part);
            }
            counted = now;
        }
        unknowns = sim.unknowns();
        iterations = counted.newton_iterations - before.newton_iterations;
        factorizations = counted.factorizations - before.factorizations;
        cells = counted.cells;
    }
    let sum = |part: usize| least.iter().map(|step| step[part]).sum();
    Ok(Timing { unknowns, steps, iterations, factorizations, cells, seconds: std::array::from_fn(sum), processor: sum(6) })
}

/// Prints the phases for each size; `others` are the milliseconds of faer's LU for a system of each size.
pub fn phases_of_an_iteration(
    kind: &Kind,
    sizes: &[usize],
    others: &[f64],
    repetitions: usize,
    threads: usize,
) -> Result<(), Box<dyn Error>> {
    println!(
        "{}, {threads} thread(s): ms per Newton iteration, per step the minimum over {repetitions} repetitions, summed over the steps",
        kind.name
    );
    let titles = PHASES.map(|name| format!("{name:>14}")).concat();
    println!(
        "{:>6} {:>9} {:>6} {:>6} {:>6}{titles}{:>10} {:>10} {:>13} {:>18}",
        "size", "unknowns", "steps", "its", "factor", "sum", "processor", "over faer LU", "assembly ns/point"
    );
    let mut timings = Vec::new();
    for (k, &refine) in sizes.iter().enumerate() {
        let steps = if refine == 1 { 40 } else { 12 / refine.min(4) + 2 };
        let timing = measure(kind, refine, steps, repetitions, threads)?;
        let per_iteration = timing.seconds.map(|seconds| 1e3 * seconds / timing.iterations as f64);
        let sum: f64 = per_iteration.iter().sum();
        // For one thread the processor time is less affected by other programs than the wall-clock time; for several threads only the
        // latter is available.
        let used = if threads == 1 { 1e3 * timing.processor / timing.iterations as f64 } else { sum };
        let points = (timing.cells * kind.points) as f64;
        println!(
            "{refine:>6} {:>9} {:>6} {:>6} {:>6}{}{sum:>10.3} {used:>10.3} {:>13} {:>7.0}{}",
            timing.unknowns,
            timing.steps,
            timing.iterations,
            timing.factorizations,
            per_iteration.map(|ms| format!("{ms:>14.3}")).concat(),
            others.get(k).map(|other| format!("{:.3}", used / other)).unwrap_or_default(),
            1e6 * per_iteration[0] / points,
            kind.floor.map(|floor| format!(" (floor {floor})")).unwrap_or_default(),
        );
        timings.push((timing.unknowns as f64, per_iteration));
    }
    let exponents = |first: &(f64, [f64; 6]), last: &(f64, [f64; 6]), pick: &dyn Fn(&[f64; 6]) -> f64| {
        (pick(&last.1) / pick(&first.1)).ln() / (last.0 / first.0).ln()
    };
    if let [first, .., last] = &timings[..] {
        let linear = exponents(first, last, &|times| times[2] + times[3]);
        let rest = exponents(first, last, &|times| times[0] + times[1] + times[4] + times[5]);
        println!("  growth with the unknowns, first size to last: factorization and solve {linear:.2}, everything else {rest:.2}");
    }
    Ok(())
}
