//! The linear solver on matrices in space: cubes and plates of hexahedra with three unknowns per node, whose fronts are large, and single
//! large fronts compared with faer's matrix product.
//!
//! Milliseconds of processor time of one thread, the minimum of several repetitions. Matrices can be written, so that other solvers can be
//! timed on the same bytes.

use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use conserva::linear::Factorization;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};

use crate::fixtures::{System, saddle_point};
use crate::linear::{least, residual};

/// Cells of the solids in three directions.
const SOLIDS: [[usize; 3]; 6] = [[11; 3], [16; 3], [25; 3], [31; 3], [30, 30, 4], [80, 80, 4]];

/// Sides of single fronts.
const FRONTS: [usize; 4] = [900, 1500, 3000, 4500];

/// Number of right-hand sides that are solved together.
const TOGETHER: usize = 16;

/// Number of unknowns above which three repetitions suffice.
const LARGE: usize = 20_000;

/// Pattern and values of a block of hexahedra.
fn solid([a, b, c]: [usize; 3]) -> System {
    let node = |i: usize, j: usize, k: usize| ((k * (b + 1) + j) * (a + 1) + i) as u32;
    let corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
    let cell = |n: usize| {
        let (i, j, k) = (n % a, n / a % b, n / (a * b));
        corners.map(|[x, y, z]| node(i + x, j + y, k + z)).to_vec()
    };
    let cells: Vec<_> = (0..a * b * c).map(cell).collect();
    saddle_point::<3>((a + 1) * (b + 1) * (c + 1), &cells, &[], 0.01)
}

/// Matrix whose factors are three dense fronts of `side` unknowns: two with half as many pivots, and their common border.
fn fronts(side: usize) -> System {
    let part = side as u32 / 6;
    let shared = 2 * part..3 * part;
    let cells = [0..part, part..2 * part].map(|own| own.chain(shared.clone()).collect());
    saddle_point::<3>(3 * part as usize, &cells, &[], 0.01)
}

/// Writes a matrix in compressed columns as three arrays for NumPy: `NAME.starts.npy`, `NAME.rows.npy`, `NAME.values.npy`.
fn write(folder: &Path, name: &str, System { pattern, values, .. }: &System) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(folder)?;
    let (starts, rows, places) = pattern.compressed_columns();
    let array = |part: &str, kind: &str, count: usize, bytes: &mut dyn Iterator<Item = [u8; 8]>| -> std::io::Result<()> {
        let mut file = BufWriter::new(File::create(folder.join(format!("{name}.{part}.npy")))?);
        let header = format!("{{'descr': '<{kind}8', 'fortran_order': False, 'shape': ({count},)}}");
        // Magic bytes, version and length of the header: 128 bytes including the line end.
        file.write_all(b"\x93NUMPY\x01\x00\x76\x00")?;
        writeln!(file, "{header:<117}")?;
        for bytes in bytes {
            file.write_all(&bytes)?;
        }
        Ok(())
    };
    array("starts", "i", starts.len(), &mut starts.iter().map(|&x| (x as u64).to_le_bytes()))?;
    array("rows", "i", rows.len(), &mut rows.iter().map(|&x| (x as u64).to_le_bytes()))?;
    array("values", "f", rows.len(), &mut places.iter().map(|place| place.map_or(0.0, |place| values[place]).to_le_bytes()))?;
    Ok(())
}

/// Prints the times of a factorization and a solution.
fn time(name: &str, System { pattern, values, .. }: &System, repetitions: usize) -> Result<(), Box<dyn Error>> {
    let mut factorization = Factorization::new(pattern)?;
    let mut done = Ok(());
    // The first matrix also determines the order and the structure.
    let first = least(1, || done = factorization.factorize(values));
    let factor = least(repetitions, || done = factorization.factorize(values));
    done?;
    let exact: Vec<f64> = (0..pattern.unknowns()).map(|i| (i as f64 * 0.7).sin()).collect();
    let mut right = vec![0.0; exact.len()];
    pattern.multiply_into(values, &exact, &mut right);
    let mut x = right.clone();
    let mut done = Ok(0.0);
    let solve = least(repetitions, || {
        x.copy_from_slice(&right);
        done = factorization.solve(values, &mut x);
    });
    done?;
    let rights = right.repeat(TOGETHER);
    let mut several = rights.clone();
    let mut done = Ok(());
    let together = least(repetitions, || {
        several.copy_from_slice(&rights);
        done = factorization.solve_all(values, &mut several).map(drop);
    });
    let estimated = least(repetitions, || {
        several.copy_from_slice(&rights);
        done = factorization.estimate(values, &mut several);
    });
    done?;
    let each = [together, estimated].map(|time| time / TOGETHER as f64);
    let (operations, factors) = (1e-9 * factorization.operations(), factorization.factor_bytes());
    println!(
        "{name:10} {:7} unknowns, order {:7.0} ms, {operations:7.2} Gflop at {:4.1} Gflop/s, factor {factor:8.1} ms, solve {solve:6.1} ms \
         ({:.1} of {TOGETHER} at once, {:.1} without refinement), \
         factors {:5.0} MB, peak {:.2} times that, residual {:.0e}",
        pattern.unknowns(),
        first - factor,
        1e3 * operations / factor,
        each[0],
        each[1],
        1e-6 * factors as f64,
        factorization.bytes() as f64 / factors as f64,
        residual(pattern, values, &x, &right),
    );
    Ok(())
}

/// Prints the speed of faer's product of square matrices with half the size of a front.
fn product(side: usize, repetitions: usize) {
    let n = side / 2;
    let (a, b) = (Mat::from_fn(n, n, |i, j| (i + 2 * j) as f64), Mat::from_fn(n, n, |i, j| (i as f64) - j as f64));
    let mut c = Mat::<f64>::zeros(n, n);
    let taken = least(repetitions, || matmul(c.as_mut(), Accum::Add, a.as_ref(), b.as_ref(), -1.0, Par::Seq));
    println!("{:10} faer's product of matrices of side {n}: {:.1} Gflop/s", "", 2e-6 * (n * n * n) as f64 / taken);
}

/// Prints a line for each solid and for single fronts, or only for solids of `sizes` cells along the first edge; writes the matrices to a
/// folder, if one is given.
pub fn compare(sizes: &[usize], repetitions: usize, folder: Option<&Path>) -> Result<(), Box<dyn Error>> {
    let chosen = SOLIDS.iter().filter(|[along, ..]| sizes.is_empty() || sizes.contains(along));
    for cells in chosen {
        let system = solid(*cells);
        let name = cells.map(|count| count.to_string()).join("x");
        if let Some(folder) = folder {
            write(folder, &name, &system)?;
        }
        time(&name, &system, if system.pattern.unknowns() < LARGE { 3 * repetitions } else { repetitions })?;
    }
    for side in FRONTS.into_iter().filter(|_| sizes.is_empty()) {
        time(&format!("front {side}"), &fronts(side), repetitions)?;
        product(side, repetitions);
    }
    Ok(())
}
