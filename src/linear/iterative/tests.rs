//! Tests of the iterative solver against the direct one, on elastic blocks of hexahedra.

use super::Iterative;
use crate::linear::{Factorization, InterruptWatch, LinearSolver, Pattern, SolverChoice, Vertex, solver_of};
use crate::math::tolerances::LINEAR_REFINED;
use crate::math::workers::Workers;

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

/// Stacked blocks of `counts` bricks each, numbered block by block; the lowest face is fixed. Multipliers tie the pairs of facing nodes:
/// with one pair each, or if `is_standard` with a pair and its neighbors, like standard multiplier shape functions.
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
    // Normal contact constrains the third direction; ground springs support the lateral directions of the upper blocks.
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

/// Number of iterations and solution of the iterative solver.
fn iterated(model: &Model, threads: usize) -> (usize, Vec<f64>) {
    let (mut solver, workers) = (Iterative::default(), Workers::new(threads));
    assert_eq!(solver.prepare(&model.pattern, &model.positions, &model.values, &workers, &InterruptWatch::default()), Ok(()));
    let mut x = model.right.clone();
    let error = solver.solve(&model.pattern, &model.values, &mut x, &workers, &InterruptWatch::default());
    assert!(error.is_ok_and(|error| error <= LINEAR_REFINED), "{error:?}");
    (solver.iterations, x)
}

/// Largest difference from the solution of the direct solver, over the largest component.
fn difference(model: &Model, x: &[f64]) -> f64 {
    let mut direct = Factorization::new(&model.pattern).unwrap();
    direct.factorize(&model.values).unwrap();
    let mut y = model.right.clone();
    direct.solve(&model.values, &mut y).unwrap();
    let size = y.iter().fold(0.0f64, |size, y| size.max(y.abs()));
    x.iter().zip(&y).fold(0.0f64, |off, (x, y)| off.max((x - y).abs())) / size
}

const CUBE: [f64; 3] = [1.0; 3];

#[test]
fn iterations_do_not_grow_with_the_mesh() {
    // 2 187, 10 125 and 27 783 unknowns; 15 to 17 iterations for a residual of 1e-13 are a factor of 0.15 each.
    let counts = [8, 14, 20].map(|n| iterated(&stack([n; 3], CUBE, 0.3, 1, false), 1).0);
    assert!(counts.iter().all(|&count| count <= 20) && counts[2] <= counts[0] + 3, "{counts:?}");
}

#[test]
fn constraints_take_as_many_iterations_on_every_mesh() {
    // Two blocks with multipliers of nine pairs of nodes each, 11 000 to 57 000 unknowns.
    let counts = [11, 14, 20].map(|n| iterated(&stack([n; 3], CUBE, 0.3, 2, true), 1).0);
    assert!(counts.iter().all(|&count| count <= 28), "{counts:?}");
}

#[test]
fn solutions_are_those_of_the_direct_solver() {
    for (counts, size, poisson, blocks, is_standard, most) in [
        ([10, 10, 10], CUBE, 0.3, 1, false, 20),
        ([8, 8, 8], CUBE, 0.3, 2, false, 20),
        ([8, 8, 8], CUBE, 0.3, 3, true, 20),
        ([14, 14, 14], CUBE, 0.3, 2, false, 28),
        ([14, 14, 14], CUBE, 0.3, 2, true, 28),
        ([10, 10, 10], CUBE, 0.49, 1, false, 100),
        ([40, 40, 2], [40.0, 40.0, 0.4], 0.3, 1, false, 60),
    ] {
        let model = stack(counts, size, poisson, blocks, is_standard);
        let (count, x) = iterated(&model, 1);
        let off = difference(&model, &x);
        assert!(off < 1e-10, "{counts:?}, {poisson}, {blocks} blocks: off by {off:.1e}");
        assert!(count <= most, "{counts:?}, {poisson}, {blocks} blocks: {count} iterations");
    }
}

#[test]
fn rows_of_prescribed_nodes_couple_with_nothing_while_their_columns_do() {
    let mut model = stack([3, 3, 3], CUBE, 0.3, 2, true);
    let Model { pattern, values, right, .. } = &mut model;
    // Nodes of the contact whose displacements are prescribed: rows of the unit matrix.
    let multiplier = (0..pattern.vertices()).find(|&v| pattern.is_multiplier(v)).unwrap();
    for &node in pattern.neighbors(multiplier).iter().filter(|&&v| pattern.size(v as usize) == 3).take(4) {
        for &other in pattern.neighbors(node as usize) {
            let block = pattern.block(node, other);
            for k in 0..pattern.size(other as usize) {
                (0..3).for_each(|i| values[block.at(i, k)] = if other == node && i == k { 1.0 } else { 0.0 });
            }
        }
        right[3 * node as usize..][..3].fill(1e-3);
    }
    let (count, x) = iterated(&model, 1);
    assert!(difference(&model, &x) < 1e-10 && count <= 40, "{count} iterations, off by {:.1e}", difference(&model, &x));
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let model = stack([12, 10, 8], CUBE, 0.3, 2, false);
    assert_eq!(iterated(&model, 1), iterated(&model, 3));
}

/// Solver of a choice after it has solved the system, its solution, and that of the direct solver.
fn chosen(choice: SolverChoice, model: &Model) -> (Box<dyn LinearSolver>, [Vec<f64>; 2]) {
    let solutions = [choice, SolverChoice::Direct].map(|choice| {
        let mut solver = solver_of(choice, &model.pattern, &model.positions, &Workers::default()).unwrap();
        solver.factorize(&model.values).unwrap();
        let mut x = model.right.clone();
        solver.solve(&model.values, &mut x).unwrap();
        (solver, x)
    });
    let [(solver, x), (_, y)] = solutions;
    (solver, [x, y])
}

#[test]
fn the_direct_solver_takes_over_where_the_iteration_does_not_converge() {
    // Unsymmetric couplings between nodes, far larger than the diagonal blocks: smoothing amplifies errors.
    let mut model = stack([8, 8, 8], CUBE, 0.3, 1, false);
    for v in 0..model.pattern.vertices() as u32 {
        for &u in model.pattern.neighbors(v as usize).iter().filter(|&&u| u > v) {
            let (block, mirrored) = (model.pattern.block(u, v), model.pattern.block(v, u));
            for i in 0..3 {
                let twist = 30.0 * (f64::from(u) * 1.3 + f64::from(v) * 0.7 + i as f64).sin();
                model.values[block.at(i, i)] += twist;
                model.values[mirrored.at(i, i)] -= twist;
            }
        }
    }
    let (mut solver, [x, y]) = chosen(SolverChoice::Iterative, &model);
    assert!(x == y);
    assert_eq!((solver.taken_over().unconverged, solver.work().factorizations, solver.work().hierarchies), (1, 1, 1));
    // The iteration is tried for three matrices in total, then no more; a restored state keeps this count.
    for _ in 0..4 {
        solver.factorize(&model.values).unwrap();
        solver.solve(&model.values, &mut model.right.clone()).unwrap();
    }
    assert_eq!((solver.taken_over().unconverged, solver.work().factorizations, solver.work().hierarchies), (3, 5, 3));
    let mut restored = solver_of(SolverChoice::Iterative, &model.pattern, &model.positions, &Workers::default()).unwrap();
    restored.recall(&solver.memory());
    restored.factorize(&model.values).unwrap();
    let mut z = model.right.clone();
    restored.solve(&model.values, &mut z).unwrap();
    assert_eq!((restored.work().hierarchies, restored.work().dissections), (0, 0));
    assert!(z == x);
}

#[test]
fn unknowns_without_rigid_motions_belong_to_the_coarsest_level() {
    // A block, with springs from all nodes of its upper face to one additional unknown, such as the displacement of a rigid body.
    let block = stack([8, 8, 8], CUBE, 0.3, 1, false);
    let nodes = block.pattern.vertices() as u32;
    let mut vertices: Vec<Vertex> = (0..nodes as usize).map(|v| block.pattern.vertex(v)).collect();
    vertices.push(Vertex::coordinates(1));
    let pairs: Vec<[u32; 2]> = (0..nodes).flat_map(|v| block.pattern.neighbors(v as usize).iter().map(move |&u| [v, u])).collect();
    let springs: Vec<[u32; 2]> = (nodes - 81..nodes).map(|v| [v, nodes]).collect();
    let pattern = Pattern::new(&vertices, pairs.iter().chain(&springs).map(|pair| &pair[..]));
    let mut values = vec![0.0; pattern.values()];
    for [u, v] in pairs {
        let (from, to) = (block.pattern.block(u, v), pattern.block(u, v));
        (0..3).for_each(|i| (0..3).for_each(|k| values[to.at(i, k)] = block.values[from.at(i, k)]));
    }
    for [v, carrier] in springs {
        let (own, there, back) = (pattern.block(v, v), pattern.block(v, carrier), pattern.block(carrier, v));
        values[own.at(1, 1)] += 0.1;
        values[there.at(1, 0)] -= 0.1;
        values[back.at(0, 1)] -= 0.1;
        values[pattern.block(carrier, carrier).at(0, 0)] += 0.11;
    }
    let right = block.right.iter().copied().chain([0.01]).collect();
    let model = Model { positions: block.positions, values, right, pattern };
    let (count, x) = iterated(&model, 1);
    assert!(count <= 20 && difference(&model, &x) < 1e-10, "{count} iterations");
}

#[test]
fn where_most_nodes_have_constraints_the_direct_solver_takes_over() {
    // Plates of one layer of cells, in which every free node is in contact with the neighboring plate.
    let (solver, [x, y]) = chosen(SolverChoice::Iterative, &stack([20, 20, 1], [20.0, 20.0, 1.0], 0.3, 3, true));
    assert!(x == y && solver.taken_over().is_unsuited && solver.work().iterations == 0);
}

#[test]
fn small_systems_are_solved_directly_unless_iteration_is_wanted() {
    let model = stack([3, 3, 3], CUBE, 0.3, 1, false);
    let (solver, [x, y]) = chosen(SolverChoice::Auto, &model);
    assert_eq!((solver.work().iterations, x), (0, y));
    let (mut solver, [x, y]) = chosen(SolverChoice::Iterative, &model);
    assert!(solver.work().iterations > 0 && solver.work().factorizations == 0 && solver.negative_eigenvalues().is_none());
    assert!(x.iter().zip(&y).all(|(x, y)| (x - y).abs() < 1e-12));
    // The inertia requires factors, so that the direct solver is used.
    solver.factorize_directly(&model.values).unwrap();
    assert_eq!(solver.negative_eigenvalues(), Some(0));
    // Several right-hand sides one after another.
    let mut rights = model.right.repeat(2);
    solver.factorize(&model.values).unwrap();
    solver.solve(&model.values, &mut rights).unwrap();
    assert!(rights.chunks_exact(x.len()).all(|solution| solution == x));
}
