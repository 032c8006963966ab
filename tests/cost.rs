//! Cost of a run in counts that do not depend on the speed of the machine, compared with a record: a change that makes the program slower
//! is found even if times are unreliable.
//!
//! The counts of the bearing (refine 1, 30 steps after `settle`) are Newton iterations, assemblies, structures, operations of the
//! factorizations, allocations per step, and bytes of a stored state beside its neighbors. Further counts are operations and memory of the
//! solver on larger meshes; for every cell kind bytes of a cell and allocations of an assembly; for every contact method contact elements
//! of a constraint, bytes of an element and allocations of an evaluation.
//!
//! A count may differ by a tenth from the record in `tests/cost.txt`. An improvement fails, too, until it is recorded, so that it cannot be
//! lost unnoticed. If a change is intended, the record is renewed by
//!
//! ```text
//! CONSERVA_RENEW_COST="why it changed" cargo test --release --test cost
//! ```
//!
//! which writes the counts and adds the note. Not counted are instructions and the work of the operating system.

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::fmt::Write as _;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use common::Builder;
use conserva::bodies::{BodyCells, Elements, Formulation, Space, Step};
use conserva::contact::{AveragedMortar, ContactKernel, Evaluation, METHODS, Mortar, NodeToSegment, PredictedMotion};
use conserva::dynamics::{Hat, LoadKind, Simulation};
use conserva::elements::CellKind;
use conserva::integrators::{Derivative, ENERGY_MOMENTUM};
use conserva::linear::{Pattern, Vertex};
use conserva::materials::NeoHookean;
use conserva::math::workers::Workers;
use conserva::mesh::{Mesh, block, rectangle, ring};

/// Factor of a count that needs no note: round-off differs between processors, and thus the number of iterations.
const ALLOWED: f64 = 1.1;

/// Allocator that counts calls and bytes.
struct Counting;

static CALLS: AtomicU64 = AtomicU64::new(0);
static BYTES: AtomicU64 = AtomicU64::new(0);
static FREED: AtomicU64 = AtomicU64::new(0);

// SAFETY: every call goes to the system's allocator as it came; the counters do not touch the memory.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        CALLS.fetch_add(1, Ordering::Relaxed);
        BYTES.fetch_add(layout.size() as u64, Ordering::Relaxed);
        // SAFETY: as the caller promised.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        FREED.fetch_add(layout.size() as u64, Ordering::Relaxed);
        // SAFETY: as the caller promised.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// The bearing after `settle`; at every size a step slides by the same fraction of a facet.
fn bearing(refine: usize) -> Simulation {
    let mut builder = Builder::default();
    let steel = NeoHookean { youngs_modulus: 1e5, poisson_ratio: 0.1, density: 1e-3 }.material().expect("in range");
    let mesh = |inner, outer, around: usize| ring(inner, outer, [10 * refine, around * refine], [0.0; 2], 0.0).expect("radii are in order");
    let outer = builder.body("outer ring", mesh(1.0, 1.5, 48), &steel);
    let inner = builder.body("inner ring", mesh(0.5, 1.002, 40), &steel);
    builder.fix(outer, "outer", [true; 3]);
    builder.contact((inner, "outer"), (outer, "inner"));
    builder.load(inner, "inner", LoadKind::Torque([0.0, 0.0, 1.0]), Hat { start: 0.0, end: 0.5, peak: 0.1 });
    let mut sim = builder.simulate(&ENERGY_MOMENTUM, 0.005 / refine as f64);
    sim.settle().expect("it comes to rest");
    sim
}

/// Calls and bytes that some work allocates.
fn allocated<T>(work: impl FnOnce() -> T) -> (T, f64, f64) {
    let (calls, bytes) = (CALLS.load(Ordering::Relaxed), BYTES.load(Ordering::Relaxed));
    let result = work();
    let (calls, bytes) = (CALLS.load(Ordering::Relaxed) - calls, BYTES.load(Ordering::Relaxed) - bytes);
    (result, calls as f64, bytes as f64)
}

/// Bytes per cell of the element loop and its part of the matrix, and allocations of an assembly.
fn count_cells<const D: usize>(kind: CellKind, mesh: &Mesh, count: &mut impl FnMut(&str, f64))
where
    Space<D>: Elements<D>,
{
    assert_eq!((kind, kind.dimension()), (mesh.blocks[0].kind, D));
    let steel = NeoHookean { youngs_modulus: 1e5, poisson_ratio: 0.1, density: 1e-3 }.material().expect("in range");
    let make = || {
        let mut elements = Space::<D>::elements(&BodyCells::new(mesh, &steel, Formulation::default())).expect("no cell is inside out");
        let pattern =
            Pattern::new(&vec![Vertex::coordinates(D as u8); mesh.points.len()], elements.cliques().iter().map(|clique| &clique[..]));
        elements.place(&pattern);
        (elements, pattern)
    };
    let ((elements, pattern), _, bytes) = allocated(make);
    let u = vec![0.0; D * mesh.points.len()];
    let (mut force, mut values) = (vec![0.0; u.len()], vec![0.0; pattern.values()]);
    let step = Step { derivative: Derivative::DiscreteGradient, weight: 1.0, inertia: 0.0, u_0: &u, u_1: &u, history: &[], dt: 0.0 };
    let workers = Workers::new(1);
    let ((), calls, _) = allocated(|| {
        elements.assemble(&step, &mut force, Some(&mut values), &workers).expect("no cell turns inside out");
    });
    let cells = mesh.cell_count() as f64;
    count(&format!("bytes_per_cell_{}", kind.name()), (bytes / cells).round());
    count(&format!("matrix_values_per_cell_{}", kind.name()), (pattern.values() as f64 / cells).round());
    count(&format!("allocations_per_assembly_{}", kind.name()), calls);
}

/// Contact elements per constraint of a contact method for two nested rings, bytes of an element, and allocations of an evaluation after
/// its buffers exist.
fn count_patches(name: &str, kernel: &mut dyn ContactKernel, q: &[f64], count: &mut impl FnMut(&str, f64)) {
    let mut out = Evaluation::default();
    let lambda = vec![1.0; kernel.rows()];
    let ((), _, bytes) = allocated(|| {
        kernel.update_candidates(&PredictedMotion::within(q, 0.1));
        kernel.begin_step(q);
        kernel.evaluate(Derivative::DiscreteGradient, q, &lambda, &mut out);
    });
    let ((), calls, _) = allocated(|| kernel.evaluate(Derivative::DiscreteGradient, q, &lambda, &mut out));
    let patches = kernel.patches().len() as f64;
    count(&format!("patches_per_row_{name}"), patches / kernel.rows() as f64);
    count(&format!("bytes_per_patch_{name}"), (bytes / patches).round());
    count(&format!("allocations_per_evaluation_{name}"), calls);
}

/// Facets of the two surfaces of the bearing, whose nodes lie on circles, and positions.
fn surfaces() -> ([Vec<[u32; 2]>; 2], Vec<f64>) {
    let (inner, outer) = (80u32, 96u32);
    let circle = |count: u32, radius: f64| {
        let angle = move |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(count);
        (0..count).flat_map(move |i| [radius * angle(i).cos(), radius * angle(i).sin()])
    };
    let facets = [(0..inner).map(|i| [i, (i + 1) % inner]).collect(), (0..outer).map(|i| [inner + (i + 1) % outer, inner + i]).collect()];
    (facets, circle(inner, 1.002).chain(circle(outer, 1.0)).collect())
}

fn counts() -> Vec<(String, f64)> {
    let mut counts = Vec::new();
    let mut count = |name: &str, value: f64| counts.push((name.to_string(), value));
    const STEPS: usize = 30;
    let mut sim = bearing(1);
    let before = sim.statistics();
    let ((), calls, bytes) = allocated(|| (0..STEPS).for_each(|_| sim.step(None, &mut |_| ()).expect("the bearing turns")));
    let after = sim.statistics();
    count("settle_iterations", before.newton_iterations as f64);
    count("iterations", (after.newton_iterations - before.newton_iterations) as f64);
    count("halvings", after.halvings as f64);
    count("assemblies", (after.assemblies - before.assemblies) as f64);
    count("factorizations", (after.linear.factorizations - before.linear.factorizations) as f64);
    count("factorization_operations", after.linear.operations - before.linear.operations);
    count("structures", (after.linear.structures - before.linear.structures) as f64);
    count("dissections", after.linear.dissections as f64);
    count("allocations_per_step", (calls / STEPS as f64).round());
    count("allocated_bytes_per_step", (bytes / STEPS as f64).round());
    let in_use = || BYTES.load(Ordering::Relaxed) - FREED.load(Ordering::Relaxed);
    let mut kept = Vec::new();
    for _ in 0..STEPS {
        sim.step(None, &mut |_| ()).expect("the bearing turns");
        kept.push(sim.shared_state());
    }
    let with_states = in_use();
    drop(kept);
    count("bytes_per_kept_state", ((with_states - in_use()) as f64 / STEPS as f64).round());
    for refine in [2, 4] {
        let mut sim = bearing(refine);
        for _ in 0..2 {
            sim.step(None, &mut |_| ()).expect("the bearing turns");
        }
        let linear = sim.statistics().linear;
        count(&format!("operations_per_factorization_refine_{refine}"), (linear.operations / linear.factorizations as f64).round());
        count(&format!("factor_bytes_refine_{refine}"), sim.statistics().factor_bytes as f64);
    }
    for &kind in CellKind::ALL {
        match kind.dimension() {
            2 => {
                let mesh = rectangle([4.0, 2.0], [40, 20], [0.0; 2]).and_then(|mesh| mesh.with_cells(kind));
                count_cells::<2>(kind, &mesh.expect("the mesh is sound"), &mut count);
            }
            _ => {
                let mesh = block([2.0, 1.0, 1.0], [12, 8, 8], [0.0; 3]).and_then(|mesh| mesh.with_cells(kind));
                count_cells::<3>(kind, &mesh.expect("the mesh is sound"), &mut count);
            }
        }
    }
    let ([inner, outer], q) = surfaces();
    let kernels: [(&str, Box<dyn ContactKernel>); 4] = [
        ("mortar", Box::new(Mortar::new(&inner, &outer, &q))),
        ("dual_mortar", Box::new(Mortar::new(&inner, &outer, &q).with_dual_multipliers())),
        ("averaged_mortar", Box::new(AveragedMortar::new(&inner, &outer, &q))),
        ("node_to_segment", Box::new(NodeToSegment::new(&inner, &outer, &q))),
    ];
    assert!(METHODS.iter().all(|method| kernels.iter().any(|(name, _)| *name == method.name)), "every method is counted");
    for (name, mut kernel) in kernels {
        count_patches(name, &mut *kernel, &q, &mut count);
    }
    counts
}

#[test]
fn the_work_of_a_run_is_what_the_record_says() {
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
            Some(recorded) if *value <= ALLOWED * recorded && recorded <= ALLOWED * value => {}
            Some(recorded) => {
                let _ = writeln!(complaints, "  {name}: {value} where the record says {recorded} ({:.2} times as much)", value / recorded);
            }
            None => {
                let _ = writeln!(complaints, "  {name}: {value}, and the record says nothing");
            }
        }
    }
    for (name, _) in record.lines().filter(|line| !line.starts_with('#')).filter_map(|line| line.split_once(' ')) {
        if !counts.iter().any(|(counted, _)| counted == name) {
            let _ = writeln!(complaints, "  {name}: in the record, but not counted");
        }
    }
    assert!(
        complaints.is_empty(),
        "the work of a run is off by more than a tenth:\n{complaints}If that is meant, or a gain, renew the record with a note:\n  \
         CONSERVA_RENEW_COST=\"why it changed\" cargo test --release --test cost"
    );
}
