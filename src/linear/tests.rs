//! Tests of the factorization against dense LU, against sparse LU with partial pivoting, and against known solutions.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use nalgebra::{DMatrix, DVector};

use super::factorization::Factorization;
use super::fixtures::{System, saddle_point};
use super::multifrontal::Multifrontal;
use super::ordering::{Order, anchored, candidates};
use super::partial_pivoting::PartialPivoting;
use super::symbolic::Symbolic;
use super::{InterruptWatch, LinearError, Pattern, Vertex};
use crate::math::tolerances::LINEAR_RESIDUAL;
use crate::math::workers::Workers;

/// Two strips (boxes for `D = 3`) of cells, `along` cells long, tied along a side by one multiplier per node of the first strip.
fn tied<const D: usize>(along: usize, across: usize, shift: usize, disturbance: f64) -> System {
    let depth = if D == 3 { 2 } else { 1 };
    let (long, wide) = (along + 1, across + 1);
    let body = long * wide * depth;
    let node = |body_index: usize, i: usize, j: usize, k: usize| (body_index * body + (k * wide + j) * long + i) as u32;
    let mut cells: Vec<Vec<u32>> = Vec::new();
    for b in 0..2 {
        for j in 0..across {
            for i in 0..along {
                let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                cells.push((0..depth).flat_map(|k| corners.map(|(i, j)| node(b, i, j, k))).collect());
            }
        }
    }
    let constraints: Vec<Vec<(u32, f64)>> = (0..long * depth)
        .map(|m| {
            let (i, k) = (m % long, m / long);
            let other = (i + shift).min(along);
            let mut row = vec![(node(0, i, 0, k), 0.6), (node(0, (i + 1).min(along), 0, k), 0.6), (node(1, other, across, k), -0.5)];
            row.push((node(1, other.saturating_sub(1), across, k), -0.5));
            row.dedup_by_key(|(node, _)| *node);
            row
        })
        .collect();
    saddle_point::<D>(2 * body, &cells, &constraints, disturbance)
}

impl System {
    fn dense(&self) -> DMatrix<f64> {
        let (starts, rows, _) = self.pattern.compressed_columns();
        let mut matrix = DMatrix::zeros(self.pattern.unknowns(), self.pattern.unknowns());
        for column in 0..self.pattern.unknowns() {
            for k in starts[column]..starts[column + 1] {
                matrix[(rows[k], column)] = self.values[k];
            }
        }
        matrix
    }

    /// Exact solution with the typical sizes of displacements (1e-3) and multipliers (1e2), and its right-hand side.
    fn problem(&self) -> (Vec<f64>, Vec<f64>) {
        let exact: Vec<f64> = (0..self.pattern.unknowns())
            .map(|i| (i as f64 * 0.7).sin() * if i < self.pattern.first_unknown(self.nodes) { 1e-3 } else { 1e2 })
            .collect();
        let mut right = vec![0.0; exact.len()];
        self.pattern.multiply_into(&self.values, &exact, &mut right);
        (exact, right)
    }

    /// Replaces a row and its column by the identity.
    fn hold(&mut self, unknown: usize, diagonal: f64) {
        let (starts, rows, _) = self.pattern.compressed_columns();
        for column in 0..self.pattern.unknowns() {
            for k in starts[column]..starts[column + 1] {
                if rows[k] == unknown || column == unknown {
                    self.values[k] = if rows[k] == column { diagonal } else { 0.0 };
                }
            }
        }
    }

    /// Largest error of the solution relative to the largest displacement and multiplier, and the residual.
    fn error(&self, factorization: &mut Factorization) -> (f64, f64) {
        let (exact, mut right) = self.problem();
        factorization.factorize(&self.values).unwrap();
        let residual = factorization.solve(&self.values, &mut right).unwrap();
        let displacements = self.pattern.first_unknown(self.nodes);
        let error = right.iter().zip(&exact).enumerate().map(|(i, (x, e))| (x - e).abs() / if i < displacements { 1e-3 } else { 1e2 });
        (error.fold(0.0, f64::max), residual)
    }
}

/// Solution of the multifrontal LU without refinement, with the given scaling, and the number of replaced pivots.
fn multifrontal(system: &System, right: &[f64]) -> (Vec<f64>, usize) {
    let symbolic = Symbolic::new(&system.pattern, &anchored(&system.pattern, &candidates(&system.pattern, &InterruptWatch::default())[0]));
    let scale = |vertex: usize| if vertex < system.nodes { 2f64.powi(-9) } else { 2f64.powi(9) };
    let vertex_scale: Vec<f64> = (0..system.pattern.vertices()).map(scale).collect();
    let unknown_scale: Vec<f64> = (0..system.pattern.unknowns()).map(|i| scale(system.pattern.vertex_of(i))).collect();
    let mut factors = Multifrontal::default();
    factors.reserve(&symbolic, &Workers::default()).unwrap();
    factors.factorize(&symbolic, &system.values, &vertex_scale, &Workers::default(), &InterruptWatch::default());
    let mut x = right.to_vec();
    factors.solve(&symbolic, &unknown_scale, &mut x, &Workers::default());
    (x, factors.replaced().len())
}

#[test]
fn every_unknown_is_eliminated_once_and_every_multiplier_after_its_anchor() {
    let system = tied::<2>(30, 4, 2, 0.01);
    let order = anchored(&system.pattern, &candidates(&system.pattern, &InterruptWatch::default())[0]);
    let symbolic = Symbolic::new(&system.pattern, &order);
    let mut unknowns = symbolic.unknowns.clone();
    unknowns.sort_unstable();
    assert!(unknowns.iter().enumerate().all(|(k, &unknown)| unknown as usize == k));
    assert_eq!(unknowns.len(), system.pattern.unknowns());
    let mut place = vec![0; unknowns.len()];
    for (k, &unknown) in symbolic.unknowns.iter().enumerate() {
        place[unknown as usize] = k;
    }
    for m in system.nodes..system.pattern.vertices() {
        let anchor = system.pattern.anchor(m).unwrap() as usize;
        assert!(place[system.pattern.first_unknown(m)] > place[system.pattern.first_unknown(anchor)]);
    }
    // Every matrix entry has exactly one position.
    let inside: usize =
        symbolic.places.inside.iter().map(|e| system.pattern.size(e.row as usize) * system.pattern.size(e.column as usize)).sum();
    let beside: usize =
        symbolic.places.beside.iter().map(|e| 2 * system.pattern.size(e.pivot as usize) * system.pattern.size(e.other as usize)).sum();
    assert_eq!(inside + beside, system.pattern.values());
}

#[test]
fn unsymmetric_saddle_points_are_solved_like_by_dense_lu() {
    for (disturbance, along, across) in [(0.01, 12, 3), (0.3, 12, 3), (0.3, 1, 1), (0.0, 25, 6)] {
        let system = tied::<2>(along, across, 1, disturbance);
        let (_, right) = system.problem();
        let (x, replaced) = multifrontal(&system, &right);
        assert_eq!(replaced, 0);
        let dense = system.dense().lu().solve(&DVector::from_column_slice(&right)).unwrap();
        let displacements = system.pattern.first_unknown(system.nodes);
        for (i, (x, e)) in x.iter().zip(dense.iter()).enumerate() {
            // Relative accuracy in units of displacements and multipliers, in which the condition number is below 1e4.
            let size = if i < displacements { 1e-3 } else { 1e2 };
            assert!((x - e).abs() < 1e-11 * size, "unknown {i}: {x} against {e}");
        }
    }
}

#[test]
fn large_systems_agree_with_partial_pivoting_over_whole_columns() {
    for disturbance in [0.01, 0.3] {
        let system = tied::<2>(60, 12, 3, disturbance);
        let (_, right) = system.problem();
        let (x, replaced) = multifrontal(&system, &right);
        assert_eq!(replaced, 0);
        let mut other = PartialPivoting::new(&system.pattern).unwrap();
        let scale: Vec<f64> =
            (0..right.len()).map(|i| if system.pattern.vertex_of(i) < system.nodes { 2f64.powi(-9) } else { 2f64.powi(9) }).collect();
        other.factorize(&system.values, &scale).unwrap();
        let mut y = right.clone();
        other.solve(&scale, &mut y);
        let displacements = system.pattern.first_unknown(system.nodes);
        for (i, (x, y)) in x.iter().zip(&y).enumerate() {
            assert!((x - y).abs() < 1e-10 * if i < displacements { 1e-3 } else { 1e2 }, "unknown {i}: {x} against {y}");
        }
    }
}

#[test]
fn residual_is_at_round_off_for_plane_and_solid_blocks() {
    for system in [tied::<2>(40, 8, 1, 0.3), tied::<3>(12, 5, 1, 0.3)] {
        let mut factorization = Factorization::new(&system.pattern).unwrap();
        let (error, residual) = system.error(&mut factorization);
        assert!(residual < 1e-13 && error < 1e-10, "residual {residual}, error {error}");
        assert!(!factorization.has_fallen_back());
    }
}

#[test]
fn held_unknowns_and_inactive_multipliers_are_rows_of_the_identity() {
    let mut system = tied::<2>(20, 4, 1, 0.05);
    let multipliers = system.pattern.first_unknown(system.nodes);
    for i in 0..20 {
        system.hold(10 * i, 1e5);
    }
    for m in (0..21).step_by(3) {
        system.hold(multipliers + m, 1.0);
    }
    let mut factorization = Factorization::new(&system.pattern).unwrap();
    let (error, residual) = system.error(&mut factorization);
    assert!(residual < 1e-13 && error < 1e-10, "residual {residual}, error {error}");
    assert!(!factorization.has_fallen_back());
}

#[test]
fn a_multiplier_whose_anchor_is_held_is_solved_all_the_same() {
    let mut system = tied::<2>(20, 4, 1, 0.05);
    for m in [3, 9] {
        let anchor = system.pattern.anchor(system.nodes + m).unwrap() as usize;
        for i in 0..2 {
            system.hold(system.pattern.first_unknown(anchor) + i, 1e5);
        }
    }
    let mut factorization = Factorization::new(&system.pattern).unwrap();
    let (error, residual) = system.error(&mut factorization);
    assert!(residual < 1e-13 && error < 1e-10, "residual {residual}, error {error}");
    // Multipliers without anchors are eliminated last and need no fallback.
    system.pattern = system.pattern.clone().with_anchors([]);
    let mut factorization = Factorization::new(&system.pattern).unwrap();
    let (error, residual) = system.error(&mut factorization);
    assert!(residual < 1e-13 && error < 1e-10, "residual {residual}, error {error}");
    assert!(!factorization.has_fallen_back());
}

/// Saddle-point matrix in which some multipliers have `huge` diagonal entries. Their rows are scaled by the constraints, which are of order
/// one, so that the scaled diagonal entries are far above one.
fn badly_scaled(huge: f64) -> System {
    let mut system = tied::<3>(6, 3, 1, 0.05);
    for m in (system.nodes..system.pattern.vertices()).step_by(3) {
        let own = system.pattern.block(m as u32, m as u32).at(0, 0);
        system.values[own] = huge;
    }
    system
}

#[test]
fn rows_with_large_entries_are_judged_by_their_own_terms() {
    for huge in [1e2, 1e6, 1e10] {
        let system = badly_scaled(huge);
        let (exact, mut right) = system.problem();
        let mut factorization = Factorization::new(&system.pattern).unwrap();
        factorization.factorize(&system.values).unwrap();
        let error = factorization.solve(&system.values, &mut right).unwrap();
        assert!(error < 1e-10 && !factorization.has_fallen_back(), "{huge:e}: {error:e}");
        let size = |values: &[f64]| values.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
        let off: Vec<f64> = right.iter().zip(&exact).map(|(x, e)| x - e).collect();
        assert!(size(&off) < 1e-9 * size(&exact), "{huge:e}: {:e}", size(&off));
    }
}

/// Errors of a ten-thousandth of the largest displacement or multiplier are detected for any size of the entries in other rows.
#[test]
fn a_wrong_solution_beside_rows_with_large_entries_is_refused() {
    let system = badly_scaled(1e10);
    let (exact, right) = system.problem();
    let mut factorization = Factorization::new(&system.pattern).unwrap();
    factorization.factorize(&system.values).unwrap();
    assert!(factorization.error_of(&system.values, &exact, &right) < 1e-14);
    let displacements = system.pattern.first_unknown(system.nodes);
    for unknown in 0..exact.len() {
        let mut wrong = exact.clone();
        wrong[unknown] += 1e-4 * if unknown < displacements { 1e-3 } else { 1e2 };
        let error = factorization.error_of(&system.values, &wrong, &right);
        assert!(error > LINEAR_RESIDUAL, "{unknown}: {error:e}");
    }
}

#[test]
fn singular_matrices_are_refused_with_the_vertex_and_the_vector() {
    // Node without support.
    let mut system = tied::<2>(10, 3, 1, 0.05);
    let unknown = system.pattern.first_unknown(17);
    system.hold(unknown, 0.0);
    let mut factorization = Factorization::new(&system.pattern).unwrap();
    factorization.factorize(&system.values).unwrap();
    let mut right = vec![1.0; system.pattern.unknowns()];
    assert_eq!(factorization.solve(&system.values, &mut right), Err(LinearError::Singular { vertex: Some(17) }));
    let null = factorization.near_null_vector().unwrap();
    assert!(null.iter().enumerate().all(|(i, x)| i == unknown || x.abs() < 1e-13 * null[unknown].abs()));

    // Repeated constraint.
    let mut system = tied::<2>(10, 3, 1, 0.05);
    let (a, b) = (system.nodes as u32 + 4, system.nodes as u32 + 5);
    for other in 0..system.nodes as u32 {
        let coupled = |m: u32| system.pattern.neighbors(m as usize).contains(&other);
        for i in 0..if coupled(b) { 2 } else { 0 } {
            let copied = if coupled(a) { system.values[system.pattern.block(a, other).at(0, i)] } else { 0.0 };
            system.values[system.pattern.block(b, other).at(0, i)] = copied;
        }
        for i in 0..if coupled(a) && !coupled(b) { 2 } else { 0 } {
            system.values[system.pattern.block(a, other).at(0, i)] = 0.0;
        }
    }
    let mut factorization = Factorization::new(&system.pattern).unwrap();
    factorization.factorize(&system.values).unwrap();
    let mut right = vec![1.0; system.pattern.unknowns()];
    let outcome = factorization.solve(&system.values, &mut right);
    assert!(matches!(outcome, Err(LinearError::Singular { .. })), "{outcome:?}");
}

#[test]
fn matrices_that_are_not_finite_and_zero_matrices_are_refused() {
    let mut system = tied::<2>(4, 2, 1, 0.05);
    let mut factorization = Factorization::new(&system.pattern).unwrap();
    let mut right = vec![1.0; system.pattern.unknowns()];
    for place in [0, system.values.len() - 1] {
        let kept = std::mem::replace(&mut system.values[place], f64::NAN);
        assert_eq!(factorization.factorize(&system.values), Err(LinearError::NotFinite));
        system.values[place] = kept;
    }
    factorization.factorize(&system.values).unwrap();
    right[3] = f64::INFINITY;
    assert_eq!(factorization.solve(&system.values, &mut right), Err(LinearError::NotFinite));
    system.values.fill(0.0);
    right.fill(1.0);
    factorization.factorize(&system.values).unwrap();
    assert!(matches!(factorization.solve(&system.values, &mut right), Err(LinearError::Singular { .. })));
}

#[test]
fn a_changed_pattern_keeps_the_order_until_the_work_has_grown() {
    let mut factorization = Factorization::new(&tied::<2>(40, 6, 0, 0.05).pattern).unwrap();
    for shift in 1..20 {
        let system = tied::<2>(40, 6, shift, 0.05);
        factorization.renew(&system.pattern).unwrap();
        let (error, residual) = system.error(&mut factorization);
        assert!(residual < 1e-13 && error < 1e-9, "shift {shift}: residual {residual}, error {error}");
        assert!(!factorization.has_fallen_back());
        let mut fresh = Factorization::new(&system.pattern).unwrap();
        fresh.factorize(&system.values).unwrap();
        // A new order is made at 1.3 times the work of the last new order; orders also differ by the result of the dissection.
        assert!(factorization.operations() < 1.8 * fresh.operations(), "shift {shift}");
    }
    // A pattern with another number of vertices.
    let system = tied::<2>(10, 3, 0, 0.05);
    factorization.renew(&system.pattern).unwrap();
    assert!(system.error(&mut factorization).1 < 1e-13);
}

#[test]
fn blocks_that_are_zero_cost_nothing_until_they_are_not() {
    let dense = tied::<2>(40, 6, 1, 0.05);
    let mut sparse = tied::<2>(40, 6, 1, 0.05);
    // Without the couplings of the multipliers the strips are independent, and each multiplier has a separate equation.
    for m in sparse.nodes..sparse.pattern.vertices() {
        for &other in sparse.pattern.neighbors(m) {
            for (u, v) in [(m as u32, other), (other, m as u32)] {
                let block = sparse.pattern.block(u, v);
                let (rows, columns) = (sparse.pattern.size(u as usize), sparse.pattern.size(v as usize));
                for place in (0..columns).flat_map(|k| (0..rows).map(move |i| block.at(i, k))) {
                    sparse.values[place] = if u == v { 1.0 } else { 0.0 };
                }
            }
        }
    }
    let mut factorization = Factorization::new(&dense.pattern).unwrap();
    assert!(sparse.error(&mut factorization).1 < 1e-13);
    let apart = factorization.operations();
    // Couplings appear and vanish again: their blocks stay in the structure only while they are cheap.
    assert!(dense.error(&mut factorization).1 < 1e-13);
    let coupled = factorization.operations();
    assert!(coupled > 1.05 * apart, "{apart} {coupled}");
    assert!(sparse.error(&mut factorization).1 < 1e-13);
    // A restored order with its structure gives bitwise equal results.
    let (_, right) = dense.problem();
    let solve = |factorization: &mut Factorization| {
        let mut x = right.clone();
        factorization.factorize(&dense.values).unwrap();
        factorization.solve(&dense.values, &mut x).unwrap();
        x
    };
    let (order, account) = (factorization.order().clone(), factorization.account());
    let x = solve(&mut factorization);
    let mut other = Factorization::new(&dense.pattern).unwrap();
    other.restore_order(&order, account);
    other.renew(&dense.pattern).unwrap();
    assert_eq!(solve(&mut other), x);
}

/// Sliding surfaces increase the work of an order: factorizations add the excess to the account without a new order. A restored order with
/// its account continues identically, also at the choice of a new order.
#[test]
fn what_is_counted_leaves_the_order_as_it_is() {
    let systems: Vec<System> = (0..12).map(|shift| tied::<2>(40, 6, shift, 0.05)).collect();
    let mut factorization = Factorization::new(&systems[0].pattern).unwrap();
    let step = |factorization: &mut Factorization, system: &System| {
        factorization.renew(&system.pattern).unwrap();
        (0..4).for_each(|_| factorization.factorize(&system.values).unwrap());
        (factorization.order().clone(), factorization.account(), factorization.operations())
    };
    let mut kept: Vec<_> = systems.iter().map(|system| step(&mut factorization, system)).collect();
    let (order, account, _) = kept.pop().unwrap();
    assert!(kept.iter().any(|(_, account, _)| account.wasted > 0.0), "an order becomes worse than its best");
    for _ in 0..3 {
        factorization.factorize(&systems[11].values).unwrap();
        assert!(*factorization.order() == order && Arc::ptr_eq(&factorization.order().found, &order.found));
    }
    assert!(factorization.account() != account, "and what that costs is counted");
    for from in 0..kept.len() {
        let mut other = Factorization::new(&systems[from].pattern).unwrap();
        other.restore_order(&kept[from].0, kept[from].1);
        other.renew(&systems[from].pattern).unwrap();
        for at in from + 1..kept.len() {
            assert!(step(&mut other, &systems[at]) == kept[at], "from {from}, at {at}");
        }
    }
}

/// Returns the matrix of a system on a pattern with more couplings, whose blocks are zero.
fn widened(system: &System, more: impl Iterator<Item = [u32; 2]>) -> System {
    let old = &system.pattern;
    let vertices = 0..old.vertices() as u32;
    let all: Vec<Vertex> = vertices.clone().map(|v| old.vertex(v as usize)).collect();
    let known = vertices.clone().flat_map(|v| old.neighbors(v as usize).iter().map(move |&u| [v, u]));
    let pairs: Vec<[u32; 2]> = known.chain(more).collect();
    let anchors = vertices.clone().filter_map(|v| old.anchor(v as usize).map(|anchor| (v, anchor)));
    let pattern = Pattern::new(&all, pairs.iter().map(|pair| &pair[..])).with_anchors(anchors);
    let mut values = vec![0.0; pattern.values()];
    for v in vertices {
        for &u in old.neighbors(v as usize) {
            let (from, to) = (old.block(u, v), pattern.block(u, v));
            for (k, i) in (0..old.size(v as usize)).flat_map(|k| (0..old.size(u as usize)).map(move |i| (k, i))) {
                values[to.at(i, k)] = system.values[from.at(i, k)];
            }
        }
    }
    System { pattern, values, nodes: system.nodes }
}

/// Both for pivots inside fronts and for the fallback.
#[test]
fn couplings_that_are_always_zero_change_no_byte() {
    let mut factorizations = [(); 3].map(|()| Factorization::new(&tied::<2>(40, 6, 0, 0.05).pattern).unwrap());
    for shift in 0..12u32 {
        let mut system = tied::<2>(40, 6, shift as usize, 0.05);
        if shift % 4 == 3 {
            // Couplings of the multipliers with their anchors are nearly zero, and so are the pivots of the multipliers.
            for m in system.nodes as u32..system.pattern.vertices() as u32 {
                let anchor = system.pattern.anchor(m as usize).unwrap();
                let (row, column) = (system.pattern.block(m, anchor), system.pattern.block(anchor, m));
                (0..2).flat_map(|i| [row.at(0, i), column.at(i, 0)]).for_each(|place| system.values[place] *= 1e-30);
            }
        }
        let (_, right) = system.problem();
        let count = system.pattern.vertices() as u32;
        let more = [3 + shift / 3, 40].map(|many| (0..many).map(move |k| [17 * k % count, (31 * k + 200) % count]));
        let [some, many] = more.map(|more| widened(&system, more));
        let solutions = [&system, &some, &many].into_iter().zip(&mut factorizations).map(|(system, factorization)| {
            factorization.renew(&system.pattern).unwrap();
            let mut x = right.clone();
            factorization.factorize(&system.values).unwrap();
            factorization.solve(&system.values, &mut x).unwrap();
            (x.into_iter().map(f64::to_bits).collect::<Vec<_>>(), factorization.has_fallen_back(), factorization.order().clone())
        });
        let solutions: Vec<_> = solutions.collect();
        assert!(solutions[0] == solutions[1] && solutions[0] == solutions[2], "shift {shift}");
        assert_eq!(solutions[0].1, shift % 4 == 3, "shift {shift}: who has solved it");
    }
    assert!(factorizations.iter().all(|factorization| factorization.work() == factorizations[0].work()));
}

/// Blocks that became zero are removed from the structure even if no new blocks appear.
#[test]
fn blocks_that_have_gone_cost_nothing_in_the_end() {
    let coupled = tied::<2>(40, 6, 1, 0.05);
    let mut apart = tied::<2>(40, 6, 1, 0.05);
    let multipliers = apart.pattern.first_unknown(apart.nodes);
    (multipliers..apart.pattern.unknowns()).for_each(|unknown| apart.hold(unknown, 1.0));
    let mut factorization = Factorization::new(&coupled.pattern).unwrap();
    factorization.factorize(&coupled.values).unwrap();
    let before = factorization.operations();
    (0..60).for_each(|_| factorization.factorize(&apart.values).unwrap());
    assert!(factorization.operations() < before && factorization.work().structures == 2);
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    // Large enough for several tasks, and for fronts whose dense work is shared.
    let system = tied::<2>(220, 30, 1, 0.3);
    let (_, right) = system.problem();
    let solve = |threads: usize| {
        let mut factorization = Factorization::new(&system.pattern).unwrap().with_workers(&Workers::new(threads));
        factorization.factorize(&system.values).unwrap();
        let mut x = right.clone();
        assert!(factorization.solve(&system.values, &mut x).unwrap() < 1e-13);
        x
    };
    let alone = solve(1);
    for threads in [2, 3] {
        assert!(solve(threads).iter().zip(&alone).all(|(x, y)| x.to_bits() == y.to_bits()), "{threads} threads");
    }
}

#[test]
fn right_hand_sides_together_give_the_bytes_of_each_alone() {
    for threads in [1, 3] {
        let system = tied::<2>(220, 30, 1, 0.3);
        let mut factorization = Factorization::new(&system.pattern).unwrap().with_workers(&Workers::new(threads));
        factorization.factorize(&system.values).unwrap();
        // More right-hand sides than are substituted together; the third one is zero.
        let unknowns = system.pattern.unknowns();
        let mut rights: Vec<f64> = (0..19 * unknowns).map(|k| (0.7 * k as f64).sin()).collect();
        rights[2 * unknowns..3 * unknowns].fill(0.0);
        let mut each = rights.clone();
        let worst = each.chunks_exact_mut(unknowns).map(|right| factorization.solve(&system.values, right).unwrap()).fold(0.0, f64::max);
        assert_eq!(factorization.solve_all(&system.values, &mut rights), Ok(worst));
        assert!(rights == each);
    }
}

#[test]
fn an_interrupt_ends_a_factorization_and_leaves_the_next_one_alone() {
    let system = tied::<2>(120, 20, 1, 0.3);
    let flag = Arc::new(AtomicBool::new(true));
    let mut factorization = Factorization::new(&system.pattern).unwrap();
    factorization.set_watch(InterruptWatch { interrupt: Some(flag.clone()), progress: None });
    assert_eq!(factorization.factorize(&system.values), Err(LinearError::Interrupted));
    flag.store(false, Ordering::Relaxed);
    assert!(system.error(&mut factorization).1 < 1e-13);
}

#[test]
fn results_are_the_same_bits_every_time() {
    let (a, b) = (tied::<2>(30, 8, 1, 0.05), tied::<2>(30, 8, 1, 0.3));
    let (_, right) = a.problem();
    let mut factorization = Factorization::new(&a.pattern).unwrap();
    let mut solve = |system: &System| {
        let mut x = right.clone();
        factorization.factorize(&system.values).unwrap();
        factorization.solve(&system.values, &mut x).unwrap();
        x
    };
    let first = solve(&a);
    solve(&b);
    assert_eq!(solve(&a), first);
    let mut fresh = Factorization::new(&a.pattern).unwrap();
    fresh.factorize(&a.values).unwrap();
    let mut x = right.clone();
    fresh.solve(&a.values, &mut x).unwrap();
    assert_eq!(x, first);
}

#[test]
fn an_order_is_repaired_where_surfaces_have_slid() {
    let system = tied::<2>(60, 8, 0, 0.01);
    let vertices = anchored(&system.pattern, &candidates(&system.pattern, &InterruptWatch::default())[0]);
    let parents = Symbolic::new(&system.pattern, &vertices).parents;
    let order = Order::new(vertices, parents);
    assert_eq!(order.repaired(&system.pattern), order.vertices, "nothing has slid");
    for shift in [1, 5, 20] {
        let slid = tied::<2>(60, 8, shift, 0.01).pattern;
        let repaired = order.repaired(&slid);
        let mut sorted = repaired.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().copied().eq(0..slid.vertices() as u32), "every vertex once");
        let work = |order: &[u32]| Symbolic::new(&slid, &anchored(&slid, order)).operations;
        let (old, new, best) = (work(&order.vertices), work(&repaired), work(&candidates(&slid, &InterruptWatch::default())[0]));
        assert!(new < old && new < 1.5 * best, "shift {shift}: {old} unrepaired, {new} repaired, {best} anew");
    }
}
