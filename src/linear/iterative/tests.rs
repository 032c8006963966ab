//! Tests of the iterative solver against the direct one, on elastic blocks of hexahedra.

use super::{Iterative, Refusal};
use crate::linear::{Factorization, Pattern, Vertex, Watch};
use crate::math::workers::Workers;

/// Processor time.
struct Cpu(f64);
impl Cpu {
    fn read() -> f64 {
        std::fs::read_to_string("/proc/thread-self/schedstat").unwrap().split(' ').next().unwrap().parse::<f64>().unwrap() * 1e-9
    }
    fn now() -> Self {
        Cpu(Self::read())
    }
    fn elapsed(&self) -> f64 {
        Self::read() - self.0
    }
}

/// A matrix, its nodes' positions, and a right-hand side.
struct Model {
    pattern: Pattern,
    values: Vec<f64>,
    positions: Vec<f64>,
    right: Vec<f64>,
}

/// Stiffness of a trilinear brick with 2 x 2 x 2 Gauss points; nodes with the first axis fastest.
fn brick(size: [f64; 3], poisson: f64) -> Vec<[f64; 24]> {
    let corner = |node: usize| -> [f64; 3] { std::array::from_fn(|a| if node >> a & 1 == 1 { 1.0 } else { -1.0 }) };
    let (lambda, mu) = (poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)), 0.5 / (1.0 + poisson));
    let mut stiffness = vec![[0.0; 24]; 24];
    let weight = size.iter().product::<f64>() / 8.0;
    for point in 0..8 {
        let at = corner(point).map(|x| x / 3f64.sqrt());
        let gradient: Vec<[f64; 3]> = (0..8)
            .map(|node| {
                let c = corner(node);
                std::array::from_fn(|a| {
                    let others: f64 = (0..3).filter(|&b| b != a).map(|b| 1.0 + c[b] * at[b]).product();
                    0.125 * c[a] * others * 2.0 / size[a]
                })
            })
            .collect();
        for (m, g) in gradient.iter().enumerate() {
            for (n, h) in gradient.iter().enumerate() {
                let product: f64 = (0..3).map(|a| g[a] * h[a]).sum();
                for i in 0..3 {
                    for k in 0..3 {
                        let same = if i == k { mu * product } else { 0.0 };
                        stiffness[3 * m + i][3 * n + k] += weight * (lambda * g[i] * h[k] + mu * g[k] * h[i] + same);
                    }
                }
            }
        }
    }
    stiffness
}

/// Blocks of `counts` bricks one above the other, apart from each other in numbering; the lowest face is held. Pairs of nodes on facing
/// sides are tied by `ties`: the multipliers of one node each, or of a node and its neighbors as standard ones are.
fn stack(counts: [usize; 3], size: [f64; 3], poisson: f64, blocks: usize, is_standard: bool) -> Model {
    let per = (counts[0] + 1) * (counts[1] + 1) * (counts[2] + 1);
    let index = |block: usize, [i, j, k]: [usize; 3]| (block * per + i + (counts[0] + 1) * (j + (counts[1] + 1) * k)) as u32;
    let nodes = blocks * per;
    let side = (counts[0] + 1) * (counts[1] + 1);
    let ties = (blocks - 1) * side;
    let mut cells: Vec<Vec<u32>> = Vec::new();
    for block in 0..blocks {
        for k in 0..counts[2] {
            for j in 0..counts[1] {
                for i in 0..counts[0] {
                    cells.push((0..8).map(|n| index(block, [i + (n & 1), j + (n >> 1 & 1), k + (n >> 2)])).collect());
                }
            }
        }
    }
    let mut rows: Vec<Vec<(u32, f64)>> = Vec::new();
    for block in 1..blocks {
        for j in 0..=counts[1] {
            for i in 0..=counts[0] {
                let mut row = Vec::new();
                let reach = usize::from(is_standard);
                for b in j.saturating_sub(reach)..=(j + reach).min(counts[1]) {
                    for a in i.saturating_sub(reach)..=(i + reach).min(counts[0]) {
                        let weight = if a == i { 4.0 } else { 1.0 } * if b == j { 4.0 } else { 1.0 } / 36.0;
                        row.push((index(block, [a, b, 0]), weight));
                        row.push((index(block - 1, [a, b, counts[2]]), -weight));
                    }
                }
                rows.push(row);
            }
        }
    }
    let mut vertices = vec![Vertex::coordinates(3); nodes];
    vertices.resize(nodes + ties, Vertex::multipliers(1));
    let cliques: Vec<Vec<u32>> =
        rows.iter().enumerate().map(|(m, row)| row.iter().map(|(node, _)| *node).chain([(nodes + m) as u32]).collect()).collect();
    let pairs: Vec<[u32; 2]> = cliques.iter().flat_map(|c| c[..c.len() - 1].iter().map(|&n| [n, c[c.len() - 1]])).collect();
    let pattern = Pattern::new(&vertices, cells.iter().map(|c| &c[..]).chain(pairs.iter().map(|p| &p[..])))
        .with_anchors(rows.iter().enumerate().map(|(m, row)| ((nodes + m) as u32, row[0].0)));
    let cell: [f64; 3] = std::array::from_fn(|a| size[a] / counts[a] as f64);
    let stiffness = brick(cell, poisson);
    let mut values = vec![0.0; pattern.values()];
    let fixed = |node: u32| (node as usize) < side;
    for nodes in &cells {
        for (m, &u) in nodes.iter().enumerate() {
            for (n, &v) in nodes.iter().enumerate() {
                if fixed(u) || fixed(v) {
                    continue;
                }
                let block = pattern.block(u, v);
                (0..3).for_each(|i| (0..3).for_each(|k| values[block.at(i, k)] += stiffness[3 * m + i][3 * n + k]));
            }
        }
    }
    for node in (0..nodes as u32).filter(|&node| fixed(node)) {
        (0..3).for_each(|i| values[pattern.block(node, node).at(i, i)] = 1.0);
    }
    // Normal contact: in the third direction; the lateral ones of the upper blocks by ground springs.
    for (m, row) in rows.iter().enumerate() {
        for &(node, weight) in row {
            values[pattern.block((nodes + m) as u32, node).at(0, 2)] = weight;
            values[pattern.block(node, (nodes + m) as u32).at(2, 0)] = -1.01 * weight;
        }
    }
    for node in per as u32..nodes as u32 {
        (0..2).for_each(|i| values[pattern.block(node, node).at(i, i)] += 0.01 * cell[0]);
    }
    let mut positions = Vec::with_capacity(3 * nodes);
    for block in 0..blocks {
        for k in 0..=counts[2] {
            for j in 0..=counts[1] {
                for i in 0..=counts[0] {
                    positions.extend([i as f64 * cell[0], j as f64 * cell[1], k as f64 * cell[2] + block as f64 * size[2]]);
                }
            }
        }
    }
    let mut right: Vec<f64> = (0..pattern.unknowns()).map(|k| 1e-3 * (0.3 * k as f64).sin()).collect();
    (3 * side..3 * nodes).skip(2).step_by(3).for_each(|k| right[k] -= 1e-2);
    right[..3 * side].fill(0.0);
    Model { pattern, values, positions, right }
}

/// Iterations of a solve, after a check of its residual.
fn iterations(model: &Model, workers: &Workers) -> Result<(usize, Vec<f64>), Refusal> {
    let clock = Cpu::now();
    let mut solver = Iterative::default();
    solver.prepare(&model.pattern, &model.positions, &model.values, workers)?;
    let setup = clock.elapsed();
    let mut x = model.right.clone();
    let clock = Cpu::now();
    let outcome = solver.solve(&model.pattern, &model.values, &mut x, workers, &Watch::default());
    let sizes = match solver.preconditioner.as_ref().unwrap() {
        super::Preconditioner::Plane(s) => s.sizes().to_vec(),
        super::Preconditioner::Space(s) => s.sizes().to_vec(),
    };
    println!(
        "{} unknowns, levels {sizes:?}, {} MB: setup {setup:.2?}, {} iterations in {:.2?}: {outcome:?}",
        x.len(),
        solver.bytes() / 1_000_000,
        solver.iterations,
        clock.elapsed()
    );
    outcome?;
    Ok((solver.iterations, x))
}

#[test]
fn look() {
    let n: Vec<usize> = std::env::var("N").unwrap_or("8,8,8".into()).split(',').map(|x| x.parse().unwrap()).collect();
    let s: Vec<f64> = std::env::var("S").unwrap_or("1,1,1".into()).split(',').map(|x| x.parse().unwrap()).collect();
    let nu: f64 = std::env::var("NU").map_or(0.3, |x| x.parse().unwrap());
    let blocks: usize = std::env::var("B").map_or(1, |x| x.parse().unwrap());
    let model = stack([n[0], n[1], n[2]], [s[0], s[1], s[2]], nu, blocks, std::env::var("STD").is_ok());
    let workers = Workers::new(std::env::var("T").map_or(1, |x| x.parse().unwrap()));
    let found = iterations(&model, &workers);
    if std::env::var("DIRECT").is_ok() {
        let clock = Cpu::now();
        let mut direct = Factorization::new(&model.pattern).unwrap().with_workers(&workers);
        direct.factorize(&model.values).unwrap();
        let mut x = model.right.clone();
        println!("{:?}", direct.solve(&model.values, &mut x));
        println!("direct {:.2?}, {} MB", clock.elapsed(), direct.bytes() / 1_000_000);
        if let Ok((_, y)) = found {
            let size = x.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            println!("difference {:.1e}", x.iter().zip(&y).fold(0.0f64, |m, (x, y)| m.max((x - y).abs())) / size);
        }
    }
}
