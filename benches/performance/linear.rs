//! The linear solver compared with faer's sparse LU, for systems like those of the bearing: two rings of quadrilaterals tied by
//! multipliers.
//!
//! Milliseconds of processor time of one thread, the minimum of several repetitions, both solvers in one run: ratios are valid on a loaded
//! machine.

use std::time::Instant;

use conserva::linear::{Factorization, Pattern};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::lu::{LuRef, LuSymbolicParams, NumericLu, factorize_symbolic_lu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par};

use crate::fixtures::{System, saddle_point};

/// Processor time of this thread if the system reports it, otherwise wall-clock time `[s]`.
pub fn seconds(start: Instant) -> f64 {
    // The system updates the processor time of a thread when the thread yields.
    std::thread::yield_now();
    let of_thread = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = of_thread.and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| start.elapsed().as_secs_f64(), |x| 1e-9 * x)
}

/// Minimum time of some repetitions `[ms]`.
pub fn least(repetitions: usize, mut run: impl FnMut()) -> f64 {
    let start = Instant::now();
    let times = (0..repetitions).map(|_| {
        let before = seconds(start);
        run();
        seconds(start) - before
    });
    1e3 * times.fold(f64::INFINITY, f64::min)
}

/// Pattern and values of the rings; the outer one is rotated by `slide` of its elements.
fn rings(refine: usize, slide: usize) -> System {
    let (outer, inner, layers) = (48 * refine, 40 * refine, 10 * refine);
    let mut cells: Vec<Vec<u32>> = Vec::new();
    let mut first = 0;
    for around in [outer, inner] {
        let node = |i: usize, j: usize| (first + i * around + j % around) as u32;
        for i in 0..layers {
            cells.extend((0..around).map(|j| vec![node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)]));
        }
        first += (layers + 1) * around;
    }
    let nodes = first;
    let surface = (layers + 1) * outer + layers * inner;
    let constraints: Vec<Vec<(u32, f64)>> = (0..inner)
        .map(|m| {
            // The node itself comes first.
            let own = [(0, 2.0 / 3.0), (inner - 1, 1.0 / 6.0), (1, 1.0 / 6.0)].map(|(d, w)| ((surface + (m + d) % inner) as u32, w));
            let opposite = m * outer / inner + slide;
            let other = [(outer - 1, -0.1), (0, -0.4), (1, -0.4), (2, -0.1)].map(|(d, w)| (((opposite + d) % outer) as u32, w));
            own.into_iter().chain(other).collect()
        })
        .collect();
    saddle_point::<2>(nodes, &cells, &constraints, 0.01)
}

/// Milliseconds of the phases and the relative residual.
struct Row {
    unknowns: f64,
    structure: f64,
    factor: f64,
    solve: f64,
    residual: f64,
}

/// Largest component of the residual over that of the right-hand side.
pub fn residual(pattern: &Pattern, values: &[f64], x: &[f64], right: &[f64]) -> f64 {
    let mut product = vec![0.0; x.len()];
    pattern.multiply_into(values, x, &mut product);
    let largest = |x: f64, y: f64| x.max(y.abs());
    product.iter().zip(right).map(|(a, b)| a - b).fold(0.0, largest) / right.iter().copied().fold(0.0, largest)
}

fn ours(refine: usize, right: &[f64], repetitions: usize) -> Row {
    let System { pattern, values, nodes } = rings(refine, 0);
    let mut factorization = Factorization::new(&pattern).expect("it fits into memory");
    // The first matrix also determines the order and the structure.
    let first = least(1, || factorization.factorize(&values).expect("values are finite"));
    let factor = least(repetitions, || factorization.factorize(&values).expect("values are finite"));
    let (order, account) = (factorization.order().clone(), factorization.account());
    let structure = least(repetitions, || {
        factorization.restore_order(&order, account);
        factorization.renew(&pattern).expect("it fits into memory");
    });
    factorization.factorize(&values).expect("values are finite");
    let mut x = right.to_vec();
    let solve = least(repetitions, || {
        x.copy_from_slice(right);
        factorization.solve(&values, &mut x).expect("the matrix is regular");
    });
    let unknowns = pattern.unknowns() as f64;
    let operations = factorization.operations();
    let System { pattern: slid, values: slid_values, .. } = rings(refine, 1);
    factorization.renew(&slid).expect("it fits into memory");
    factorization.factorize(&slid_values).expect("values are finite");
    println!(
        "refine {refine}: {unknowns} unknowns, {} of them multipliers, order {:.1} ms, {:.1} Mflop at {:.1} Gflop/s, \
         {:.2} times as many when slid, {:.0} bytes per unknown",
        pattern.vertices() - nodes,
        first - factor - structure,
        1e-6 * operations,
        1e-6 * operations / factor,
        factorization.operations() / operations,
        factorization.bytes() as f64 / unknowns,
    );
    Row { unknowns, structure, factor, solve, residual: residual(&pattern, &values, &x, right) }
}

fn faer_lu(refine: usize, right: &[f64], repetitions: usize) -> Row {
    let System { pattern, values, .. } = rings(refine, 0);
    let (starts, rows, _) = pattern.compressed_columns();
    let n = pattern.unknowns();
    let structure = SymbolicSparseColMatRef::new_checked(n, n, &starts, None, &rows);
    let parameters = || LuSymbolicParams { supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL, ..Default::default() };
    let mut symbolic = factorize_symbolic_lu(structure, parameters()).expect("it fits into memory");
    let symbolic_time = least(repetitions, || symbolic = factorize_symbolic_lu(structure, parameters()).expect("it fits into memory"));
    let mut numeric = NumericLu::<usize, f64>::new();
    let scratch = symbolic.factorize_numeric_lu_scratch::<f64>(Par::Seq, Default::default());
    let mut memory = MemBuffer::new(scratch.or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq)));
    let matrix = SparseColMatRef::new(structure, &values[..]);
    let factor = least(repetitions, || {
        let stack = MemStack::new(&mut memory);
        symbolic.factorize_numeric_lu(&mut numeric, matrix, Par::Seq, stack, Default::default()).expect("the matrix is regular");
    });
    let mut x = right.to_vec();
    let solve = least(repetitions, || {
        x.copy_from_slice(right);
        let vector = MatMut::from_column_major_slice_mut(&mut x, n, 1);
        LuRef::new_unchecked(&symbolic, &numeric).solve_in_place_with_conj(Conj::No, vector, Par::Seq, MemStack::new(&mut memory));
    });
    Row { unknowns: n as f64, structure: symbolic_time, factor, solve, residual: residual(&pattern, &values, &x, right) }
}

/// Prints the comparison; returns the milliseconds of faer's factorization and solution at each size.
pub fn compare(sizes: &[usize]) -> Vec<f64> {
    println!(
        "linear solver: ms of processor time, one thread: structure for a known order, factorization, solution with residual and refinement"
    );
    let mut last: Option<Row> = None;
    let mut others = Vec::new();
    for &refine in sizes {
        let System { pattern, values, .. } = rings(refine, 0);
        let exact: Vec<f64> = (0..pattern.unknowns()).map(|i| (i as f64 * 0.7).sin()).collect();
        let mut right = vec![0.0; exact.len()];
        pattern.multiply_into(&values, &exact, &mut right);
        let repetitions = [100, 25, 6, 3][refine.ilog2().min(3) as usize];
        let own = ours(refine, &right, repetitions);
        let other = faer_lu(refine, &right, (repetitions / 4).max(2));
        for (name, row) in [("ours", &own), ("faer", &other)] {
            println!(
                "  {name}  structure {:8.3}  factor {:9.3}  solve {:8.3}  residual {:.1e}",
                row.structure, row.factor, row.solve, row.residual
            );
        }
        let both = other.factor + other.solve;
        println!("  ours / faer: factor {:.3}, factor + solve {:.3}", own.factor / other.factor, (own.factor + own.solve) / both);
        if let Some(last) = last.filter(|last| last.unknowns < own.unknowns) {
            let exponent = |now: f64, before: f64| (now / before).ln() / (own.unknowns / last.unknowns).ln();
            println!(
                "  growth with the unknowns: structure {:.2}, factor {:.2}, solve {:.2}",
                exponent(own.structure, last.structure),
                exponent(own.factor, last.factor),
                exponent(own.solve, last.solve)
            );
        }
        others.push(other.factor);
        last = Some(own);
    }
    others
}
