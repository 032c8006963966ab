//! What a run costs in counts that do not depend on the machine's speed, against a record: a change that makes the program slower shows
//! here even where times cannot be trusted.
//!
//! Counted on the bearing (refine 1, 30 steps after `settle`): Newton iterations, assemblies, structures, operations of the factorisations,
//! allocations per step; and the solver's operations and memory on larger meshes. A count may grow by a tenth. `tests/cost.txt` holds the
//! record; where growth is meant, it is renewed by
//!
//! ```text
//! CONSERVA_RENEW_COST="why it grew" cargo test --release --test cost
//! ```
//!
//! which writes the counts and adds the note. Not counted: instructions, and what the operating system does.

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::fmt::Write as _;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use common::{Builder, material};
use conserva::dynamics::{Hat, LoadKind, Simulation};
use conserva::integrators::Integrator;
use conserva::mesh::ring;

/// Growth of a count that needs no note: round-off differs between processors, and with it an iteration now and then.
const ALLOWED: f64 = 1.1;

/// Counts what is asked of the system's allocator.
struct Counting;

static CALLS: AtomicU64 = AtomicU64::new(0);
static BYTES: AtomicU64 = AtomicU64::new(0);

// SAFETY: every call goes to the system's allocator as it came; the counters do not touch the memory.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        CALLS.fetch_add(1, Ordering::Relaxed);
        BYTES.fetch_add(layout.size() as u64, Ordering::Relaxed);
        // SAFETY: as the caller promised.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as the caller promised.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// The bearing after `settle`; at every size a step slides by the same part of a facet.
fn bearing(refine: usize) -> Simulation {
    let mut builder = Builder::default();
    let steel = material("neo_hookean", [1e5, 0.1, 1e-3]);
    let mesh = |inner, outer, around: usize| ring(inner, outer, [10 * refine, around * refine], [0.0; 2], 0.0).expect("radii are in order");
    let outer = builder.body("outer ring", mesh(1.0, 1.5, 48), &steel);
    let inner = builder.body("inner ring", mesh(0.5, 1.002, 40), &steel);
    builder.fix(outer, "outer", [true; 3]);
    builder.contact((inner, "outer"), (outer, "inner"));
    builder.load(inner, "inner", LoadKind::Torque, Hat { start: 0.0, end: 0.5, peak: 0.1 });
    let mut sim = builder.simulate(Integrator::EnergyMomentum, 0.005 / refine as f64);
    sim.settle().expect("it comes to rest");
    sim
}

fn counts() -> Vec<(String, f64)> {
    let mut counts = Vec::new();
    let mut count = |name: &str, value: f64| counts.push((name.to_string(), value));
    const STEPS: usize = 30;
    let mut sim = bearing(1);
    let before = sim.statistics();
    let (calls, bytes) = (CALLS.load(Ordering::Relaxed), BYTES.load(Ordering::Relaxed));
    for _ in 0..STEPS {
        sim.step(None, &mut |_| ()).expect("the bearing turns");
    }
    let (calls, bytes) = (CALLS.load(Ordering::Relaxed) - calls, BYTES.load(Ordering::Relaxed) - bytes);
    let after = sim.statistics();
    count("settle_iterations", before.newton_iterations as f64);
    count("iterations", (after.newton_iterations - before.newton_iterations) as f64);
    count("halvings", after.halvings as f64);
    count("assemblies", (after.assemblies - before.assemblies) as f64);
    count("factorizations", (after.linear.factorizations - before.linear.factorizations) as f64);
    count("factorization_operations", after.linear.operations - before.linear.operations);
    count("structures", (after.linear.structures - before.linear.structures) as f64);
    count("dissections", after.linear.dissections as f64);
    count("allocations_per_step", (calls as f64 / STEPS as f64).round());
    count("allocated_bytes_per_step", (bytes as f64 / STEPS as f64).round());
    for refine in [2, 4] {
        let mut sim = bearing(refine);
        for _ in 0..2 {
            sim.step(None, &mut |_| ()).expect("the bearing turns");
        }
        let linear = sim.statistics().linear;
        count(&format!("operations_per_factorization_refine_{refine}"), (linear.operations / linear.factorizations as f64).round());
        count(&format!("factor_bytes_refine_{refine}"), sim.statistics().factor_bytes as f64);
    }
    counts
}

#[test]
fn the_work_of_a_run_has_not_grown() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cost.txt");
    let record = std::fs::read_to_string(&path).unwrap_or_default();
    let counts = counts();
    if let Ok(note) = std::env::var("CONSERVA_RENEW_COST") {
        assert!(note.trim().len() > 10, "CONSERVA_RENEW_COST says in a sentence why the record changes");
        let notes: String = record.lines().filter(|line| line.starts_with('#')).map(|line| format!("{line}\n")).collect();
        let lines = counts.iter().fold(String::new(), |mut lines, (name, value)| {
            let _ = writeln!(lines, "{name} {value}");
            lines
        });
        std::fs::write(&path, format!("{notes}# {}\n{lines}", note.trim())).expect("the record can be written");
        return;
    }
    let mut complaints = String::new();
    for (name, value) in &counts {
        let recorded = record.lines().filter_map(|line| line.split_once(' ')).find(|(other, _)| other == name);
        match recorded.and_then(|(_, text)| text.parse::<f64>().ok()) {
            Some(recorded) if *value <= ALLOWED * recorded => {}
            Some(recorded) => {
                let _ = writeln!(complaints, "  {name}: {value} where the record says {recorded} ({:.2} times as much)", value / recorded);
            }
            None => {
                let _ = writeln!(complaints, "  {name}: {value}, and the record says nothing");
            }
        }
    }
    assert!(
        complaints.is_empty(),
        "the work of a run has grown by more than a tenth:\n{complaints}If that is meant, renew the record with a note:\n  \
         CONSERVA_RENEW_COST=\"why it grew\" cargo test --release --test cost"
    );
}
