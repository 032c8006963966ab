//! Thousands of random scenes, judged by oracles that are independent of the kernels: growth of energy, closure of the ledger, momenta,
//! penetrations.
//!
//! One line for each run with a fault, then a table for each method and rule. A seed gives the same scene with every method and rule.
//!
//! `cargo example scenes -- [count] [--rule R] [--method M] [--first SEED] [--dt-factor F] [--kind K] [--threads
//! N]`; with `--reach F` every run is compared, to the last byte, with one whose contact search horizon is `F` times as large; or for one
//! scene `--seed N` (every step in numbers), `--script N` (as a script), `--shrink N` (reduced with the same kind of failure).

use std::collections::BTreeMap;
use std::error::Error;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::Parser;
use conserva::contact::{ContactMethod, METHODS};
use conserva::dynamics::{UPDATE_RULES, UpdateRule};

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../tests/common/scenes/mod.rs"]
mod scenes;

use scenes::Scene;
use scenes::run::{DEPTH, Fault, Outcome, Record, first_difference, run};
use scenes::shrink::shrink;

/// Random scenes, judged from positions and velocities alone.
#[derive(Parser)]
struct Arguments {
    /// Number of scenes
    #[arg(default_value_t = 40)]
    count: u64,
    /// Update rule: gap, persistency, velocity or all
    #[arg(long, default_value = "all")]
    rule: String,
    /// Contact method: mortar, dual_mortar, averaged_mortar, node_to_segment or all
    #[arg(long, default_value = "all")]
    method: String,
    /// Only scenes of this kind: collision, nested, box, drum, fall, stack or extreme
    #[arg(long)]
    kind: Option<String>,
    /// First seed
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Factor of the time step; the number of steps stays
    #[arg(long, default_value_t = 1.0)]
    dt_factor: f64,
    /// Coefficient of friction of everything
    #[arg(long, default_value_t = 0.0)]
    friction: f64,
    /// Threads, one scene on each
    #[arg(long)]
    threads: Option<usize>,
    /// Compares each run, to the last byte, with one in which the search for contact reaches so many times as far
    #[arg(long)]
    reach: Option<f64>,
    /// One scene, every step in numbers
    #[arg(long)]
    seed: Option<u64>,
    /// One scene as a script, with the first method and rule that are asked for
    #[arg(long)]
    script: Option<u64>,
    /// One scene, made smaller as long as it fails in the same way
    #[arg(long)]
    shrink: Option<u64>,
}

impl Arguments {
    /// Requested pairs of method and rule.
    fn axes(&self) -> Result<Vec<(&'static ContactMethod, &'static UpdateRule)>, Box<dyn Error>> {
        let methods = METHODS.iter().filter(|method| [method.name, "all"].contains(&self.method.as_str()));
        let rules = || UPDATE_RULES.iter().filter(|rule| [rule.name, "all"].contains(&self.rule.as_str()));
        let axes: Vec<_> = methods.flat_map(|&method| rules().map(move |&rule| (method, rule))).collect();
        if axes.is_empty() { Err("there is no such method or rule".into()) } else { Ok(axes) }
    }

    fn scene(&self, seed: u64, (method, rule): (&'static ContactMethod, &'static UpdateRule)) -> Scene {
        let mut scene = Scene::random(seed).with(method, rule).with_friction(self.friction);
        scene.dt *= self.dt_factor;
        scene
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let axes = arguments.axes()?;
    // A panic is a finding with its text.
    std::panic::set_hook(Box::new(|_| ()));
    if let Some(seed) = arguments.script {
        print!("{}", arguments.scene(seed, axes[0]).script());
    } else if let Some(seed) = arguments.seed {
        axes.iter().for_each(|&axis| trace(&arguments.scene(seed, axis)));
    } else if let Some(seed) = arguments.shrink {
        axes.iter().for_each(|&axis| reduce(&arguments.scene(seed, axis)));
    } else if let Some(reach) = arguments.reach {
        compare(&arguments, &axes, reach);
    } else {
        survey(&arguments, &axes);
    }
    Ok(())
}

/// One line about a scene.
fn title(scene: &Scene) -> String {
    format!("seed {} {:?} {} {}", scene.seed, scene.kind, scene.method.name, scene.rule.name)
}

/// The faults of a run, one line each.
fn faults(scene: &Scene, outcome: &Outcome) -> Vec<String> {
    let line = |finding: &scenes::run::Finding| {
        let value = if finding.worst.is_finite() { format!(" {:.2e}", finding.worst) } else { String::new() };
        let steps = if finding.first == finding.worst_step {
            format!("step {}", finding.first)
        } else {
            format!("from step {}, worst at {}", finding.first, finding.worst_step)
        };
        format!("{}: {}{value} at {steps} of {} {}", title(scene), finding.fault.name(), scene.steps, finding.text)
    };
    outcome.findings.iter().map(|finding| line(finding).trim_end().to_string()).collect()
}

/// Every step of a scene in numbers.
fn trace(scene: &Scene) {
    println!("{}: {} bodies, {} walls, dt {:.3e}", title(scene), scene.bodies.len(), scene.walls.len(), scene.dt);
    for (k, body) in scene.bodies.iter().enumerate() {
        println!("  body {k}: {body:?}");
    }
    scene.walls.iter().enumerate().for_each(|(k, wall)| println!("  wall {k}: {wall:?}"));
    println!("step  active iterations halvings     change       gain     defect   momentum   depth/h crossing/h   reported from positions");
    let outcome = run(scene, &mut |record: &Record| {
        let Record { step, active, iterations, halvings, change, gain, defect, momentum, .. } = record;
        let (depth, crossing) = (&record.depth, &record.crossing);
        println!(
            "{step:4} {active:7} {iterations:10} {halvings:8} {change:10.2e} {gain:10.2e} {defect:10.2e} {momentum:10.2e} {:9.3} {:10.3} \
             {:10.2e} {:10.2e} {}",
            depth.facets,
            crossing.facets,
            record.reported,
            depth.length,
            if depth.facets > DEPTH { &depth.place } else { "" }
        );
    });
    faults(scene, &outcome).iter().for_each(|line| println!("{line}"));
}

/// Prints the smallest scene for each kind of failure.
fn reduce(scene: &Scene) {
    let outcome = run(scene, &mut |_| ());
    for finding in &outcome.findings {
        println!("// {}: {}", title(scene), finding.fault.name());
        let small = shrink(scene, finding.fault, &mut |what| println!("//   {what}"));
        faults(&small, &run(&small, &mut |_| ())).iter().for_each(|line| println!("// {line}"));
        println!("{}", small.script());
    }
}

/// Sums over the runs of a method and rule.
#[derive(Default)]
struct Row {
    runs: usize,
    counts: BTreeMap<Fault, usize>,
    deeper: usize,
    touched: usize,
    worst: Outcome,
}

impl Row {
    fn add(&mut self, outcome: &Outcome) {
        self.runs += 1;
        outcome.findings.iter().for_each(|finding| *self.counts.entry(finding.fault).or_default() += 1);
        self.deeper += usize::from(outcome.deepest() > 1.5 * DEPTH);
        self.touched += usize::from(outcome.touching > 0);
        let worst = &mut self.worst;
        worst.steps += outcome.steps;
        worst.pieces += outcome.pieces;
        worst.iterations += outcome.iterations;
        worst.halvings += outcome.halvings;
        worst.touching += outcome.touching;
        worst.gain = worst.gain.max(outcome.gain);
        worst.cone = worst.cone.max(outcome.cone);
        worst.defect = worst.defect.max(outcome.defect);
        worst.momentum = worst.momentum.max(outcome.momentum);
        worst.depth = worst.depth.max(outcome.depth);
        worst.crossing = worst.crossing.max(outcome.crossing);
        worst.misread = worst.misread.max(outcome.misread);
        worst.lost += outcome.lost;
    }

    fn print(&self, name: &str) {
        let count = |fault| self.counts.get(&fault).copied().unwrap_or(0);
        let worst = &self.worst;
        println!(
            "{name:28} {:5} {:7} {:6} {:7} {:4} {:6} {:6} {:4} {:6} {:8} {:6} {:5} {:5} {:5}  {:8.1e} {:8.1e} {:8.1e} {:8.1e} {:8.1e} \
             {:6.2} {:8.2} {:7.2} {:6.2} {:8}",
            self.runs,
            self.touched,
            count(Fault::Failed),
            count(Fault::Crushed),
            count(Fault::Slow),
            count(Fault::Gained),
            count(Fault::Rubbed),
            count(Fault::Cone),
            count(Fault::Defect),
            count(Fault::Momentum),
            count(Fault::Ledger),
            count(Fault::Deep),
            self.deeper,
            count(Fault::Apart),
            worst.lost / self.runs.max(1) as f64,
            worst.gain,
            worst.cone,
            worst.defect,
            worst.momentum,
            worst.depth,
            worst.crossing,
            worst.misread,
            worst.iterations as f64 / worst.pieces.max(1) as f64,
            worst.halvings,
        );
    }
}

/// Columns of the table: runs, runs with contact, runs with each fault, runs with more than one and a half times the limit of penetration;
/// mean energy loss of contact over the energy; largest values; iterations of an accepted substep, halvings.
const HEADER: &str = "method, rule; kind            runs touched failed crushed slow gained rubbed cone defect momentum ledger  deep \
                      >0.15 apart      lost     gain     cone   defect momentum  depth crossing misread  iter. halvings";

/// Requested seeds and indices of axes, and number of threads.
fn jobs(arguments: &Arguments, axes: usize) -> (Vec<(u64, usize)>, usize) {
    let wanted = |seed: &u64| {
        let kind = format!("{:?}", Scene::random(*seed).kind);
        arguments.kind.as_ref().is_none_or(|wanted| kind.eq_ignore_ascii_case(wanted))
    };
    let seeds = (arguments.first..arguments.first + arguments.count).filter(wanted);
    let jobs = seeds.flat_map(|seed| (0..axes).map(move |axis| (seed, axis))).collect();
    (jobs, arguments.threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from)))
}

/// Prints the scenes that depend on the search horizon of contact.
fn compare(arguments: &Arguments, axes: &[(&'static ContactMethod, &'static UpdateRule)], reach: f64) {
    let (jobs, threads) = jobs(arguments, axes.len());
    let (next, differing) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let work = || {
        while let Some(&(seed, axis)) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
            let scene = arguments.scene(seed, axes[axis]);
            let outcome = std::panic::catch_unwind(|| first_difference(&scene, reach));
            let found = match outcome {
                Ok(Ok(None)) => continue,
                Ok(Ok(Some(step))) => format!("differs from step {step} of {} on", scene.steps),
                Ok(Err(error)) => error,
                Err(_) => "panicked".to_string(),
            };
            differing.fetch_add(1, Ordering::Relaxed);
            println!("{}: {found}", title(&scene));
        }
    };
    std::thread::scope(|scope| (0..threads).for_each(|_| drop(scope.spawn(work))));
    println!("{} of {} runs differ with {reach} times the reach", differing.into_inner(), jobs.len());
}

/// Runs all scenes with all methods and rules on all threads; lines are in the order of the seeds.
fn survey(arguments: &Arguments, axes: &[(&'static ContactMethod, &'static UpdateRule)]) {
    let (jobs, threads) = jobs(arguments, axes.len());
    let next = AtomicUsize::new(0);
    // Outcomes that wait for an earlier one, and the number of processed outcomes.
    let table = Mutex::new((BTreeMap::new(), 0, axes.iter().map(|_| Row::default()).collect::<Vec<_>>(), BTreeMap::<String, Row>::new()));
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    let Some(&(seed, axis)) = jobs.get(number) else { break };
                    let scene = arguments.scene(seed, axes[axis]);
                    let outcome = run(&scene, &mut |_| ());
                    let Ok(mut guard) = table.lock() else { break };
                    let (waiting, taken, rows, kinds) = &mut *guard;
                    waiting.insert(number, (faults(&scene, &outcome), scene.kind, outcome));
                    while let Some((lines, kind, outcome)) = waiting.remove(taken) {
                        lines.iter().for_each(|line| println!("{line}"));
                        rows[jobs[*taken].1].add(&outcome);
                        kinds.entry(format!("{kind:?}")).or_default().add(&outcome);
                        *taken += 1;
                    }
                }
            });
        }
    });
    let Ok((_, _, rows, kinds)) = table.into_inner() else { return };
    println!("{HEADER}");
    for ((method, rule), row) in axes.iter().zip(rows) {
        row.print(&format!("{}, {}", method.name, rule.name));
    }
    kinds.iter().for_each(|(kind, row)| row.print(kind));
}
