//! Milliseconds per Newton iteration of the bearing by phase, one thread, at refine 1, 2 and 4, and how each phase grows with the unknowns.
//!
//! A run is deterministic: step k costs the same work in every repetition. So each phase of each step is timed in every repetition and the
//! least time is kept: what other programs on the machine took from single steps drops out as soon as one repetition of that step was
//! left alone. What is summed up is `per step the minimum over repetitions`; it needs no quiet machine, only one that is quiet now and
//! then.
//!
//! `cargo bench --bench bearing -- [--refine 8] [--repetitions 5]` (`--refine n` adds a size)

use std::error::Error;
use std::rc::Rc;
use std::time::{Duration, Instant};

use conserva::dynamics::{
    BodyBoundary, BodyDefinition, ContactDefinition, Hat, Load, LoadKind, Model, Options, Simulation, Statistics, Support,
};
use conserva::integrators::Integrator;
use conserva::materials::{CATALOGUE, Material};
use conserva::mesh::ring;

/// Phases as they are printed; the last is what no other counts.
const PHASES: [&str; 6] = ["assembly", "contact", "factorization", "solve", "search", "other"];

fn bearing(refine: usize) -> Result<Simulation, Box<dyn Error>> {
    let row = CATALOGUE.iter().find(|row| row.name == "neo_hookean").ok_or("no such material")?;
    let steel = Material::new(row, &[1e5, 0.1, 1e-3]);
    let mut model = Model { name: "bearing".into(), ..Model::default() };
    for (name, inner, outer, around) in [("outer ring", 1.0, 1.5, 48), ("inner ring", 0.5, 1.002, 40)] {
        let mesh = Rc::new(ring(inner, outer, [10 * refine, around * refine], [0.0; 2], 0.0)?);
        model.bodies.push(BodyDefinition { name: name.into(), mesh, material: steel.clone() });
    }
    let boundary = |body: usize, name: &str| -> Result<BodyBoundary, Box<dyn Error>> {
        Ok(BodyBoundary { body, boundary: model.bodies[body].mesh.boundary(name).ok_or("a ring has inner and outer")?.clone() })
    };
    let (rim, race, journal, bore) = (boundary(0, "outer")?, boundary(0, "inner")?, boundary(1, "outer")?, boundary(1, "inner")?);
    model.supports.push(Support { on: rim, components: [true; 3] });
    model.contacts.push(ContactDefinition::new("race", journal, race));
    model.loads.push(Load { kind: LoadKind::Torque, on: bore, amplitude: Rc::new(Hat { start: 0.0, end: 0.5, peak: 0.1 }) });
    // At every size a step slides by the same part of a facet.
    let mut sim = Simulation::new(&model, Options::new(Integrator::EnergyMomentum, 0.005 / refine as f64))?;
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
    /// Seconds of all steps by phase.
    seconds: [f64; 6],
}

/// Least time of each phase of each step over all repetitions, summed.
fn measure(refine: usize, steps: usize, repetitions: usize) -> Result<Timing, Box<dyn Error>> {
    let mut least = vec![[f64::INFINITY; 6]; steps];
    let (mut unknowns, mut iterations, mut factorizations) = (0, 0, 0);
    for _ in 0..repetitions {
        let mut sim = bearing(refine)?;
        // Spun up already: the pattern has been made anew and the set has moved on before the clock starts.
        for _ in 0..5 {
            sim.step(None, &mut |_| ())?;
        }
        let before = sim.statistics();
        let mut counted = before;
        for least in &mut least {
            let clock = Instant::now();
            sim.step(None, &mut |_| ())?;
            let whole = clock.elapsed();
            let now = sim.statistics();
            let mut parts = [0.0; 6];
            for (part, (a, b)) in parts.iter_mut().zip(phases(&counted).iter().zip(&phases(&now))) {
                *part = (*b - *a).as_secs_f64();
            }
            parts[5] = whole.as_secs_f64() - parts.iter().sum::<f64>();
            for (least, part) in least.iter_mut().zip(parts) {
                *least = least.min(part);
            }
            counted = now;
        }
        unknowns = sim.unknowns();
        iterations = counted.newton_iterations - before.newton_iterations;
        factorizations = counted.factorizations - before.factorizations;
    }
    let seconds = std::array::from_fn(|phase| least.iter().map(|step| step[phase]).sum());
    Ok(Timing { unknowns, steps, iterations, factorizations, seconds })
}

fn main() -> Result<(), Box<dyn Error>> {
    // Cargo adds `--bench`.
    let arguments: Vec<String> = std::env::args().skip(1).filter(|text| text != "--bench").collect();
    let (mut sizes, mut repetitions) = (vec![1, 2, 4], 3);
    for pair in arguments.chunks(2) {
        match pair {
            [name, value] if name == "--refine" => sizes.push(value.parse()?),
            [name, value] if name == "--repetitions" => repetitions = value.parse()?,
            other => return Err(format!("unknown arguments {other:?}; known are `--refine n` and `--repetitions n`").into()),
        }
    }
    println!("bearing, one thread, ms per Newton iteration: per step the minimum over {repetitions} repetitions, summed over the steps");
    println!(
        "{:>6} {:>9} {:>6} {:>6} {:>7}{}",
        "refine",
        "unknowns",
        "steps",
        "its",
        "LU/it",
        PHASES.map(|name| format!("{name:>14}")).concat()
    );
    let mut timings = Vec::new();
    for refine in sizes {
        let steps = if refine == 1 { 40 } else { 12 / refine.min(4) + 2 };
        let timing = measure(refine, steps, repetitions)?;
        let per_iteration = timing.seconds.map(|seconds| 1e3 * seconds / timing.iterations as f64);
        println!(
            "{refine:>6} {:>9} {:>6} {:>6} {:>7.2}{}   sum {:.3}",
            timing.unknowns,
            timing.steps,
            timing.iterations,
            timing.factorizations as f64 / timing.iterations as f64,
            per_iteration.map(|ms| format!("{ms:>14.3}")).concat(),
            per_iteration.iter().sum::<f64>()
        );
        timings.push((timing.unknowns as f64, per_iteration));
    }
    for pair in timings.windows(2) {
        let ratio = (pair[1].0 / pair[0].0).ln();
        let exponents: [f64; 6] = std::array::from_fn(|phase| (pair[1].1[phase] / pair[0].1[phase]).ln() / ratio);
        println!("growth with unknowns to the power of{:>2}{}", "", exponents.map(|x| format!("{x:>14.2}")).concat());
    }
    let (_, first) = timings[0];
    let sum: f64 = first.iter().sum();
    println!("refine 1: assembly + contact {:.3} ms (required: 2, goal: 0.4)", first[0] + first[1]);
    println!("refine 1: search {:.2} %, outside all phases {:.2} % of the time", 100.0 * first[4] / sum, 100.0 * first[5] / sum);
    Ok(())
}
