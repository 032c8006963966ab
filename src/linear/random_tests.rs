//! Random saddle-point matrices: nodes, directors and scalars of any size, and groups of several constraints.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, DVector};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;

use super::ordering::{Order, anchored, candidates};
use super::symbolic::Symbolic;
use super::{Block, Factorization, InterruptWatch, LinearError, Pattern, Role, Vertex};
use crate::math::workers::Workers;

/// Largest condition number of the scaled matrix for which the solution is compared.
const CONDITION: f64 = 1e7;

/// A graph: number of coordinates of each vertex, cells as lists of vertices, and groups of constraints, each with the number of
/// constraints and the coupled vertices.
#[derive(Clone, Debug)]
struct Graph {
    sizes: Vec<u8>,
    cells: Vec<Vec<u32>>,
    groups: Vec<(u8, Vec<u32>)>,
    noise: Vec<f64>,
    stiffness: f64,
}

fn graphs() -> impl Strategy<Value = Graph> {
    let members = |most: usize| vec(any::<Index>(), 1..most);
    let shape = (vec(1..=6u8, 1..24), vec(members(6), 0..40), vec((1..=4u8, members(5)), 0..12));
    (shape, vec(-1.0..1.0, 97), -6..9).prop_map(|((sizes, cells, groups), noise, power)| {
        let chosen = |members: Vec<Index>| -> Vec<u32> {
            members.iter().map(|index| index.index(sizes.len()) as u32).collect::<BTreeSet<u32>>().into_iter().collect()
        };
        let cells = cells.into_iter().map(chosen).collect();
        let groups = groups.into_iter().map(|(rows, members)| (rows, chosen(members))).collect();
        Graph { sizes, cells, groups, noise, stiffness: 10f64.powi(power) }
    })
}

impl Graph {
    fn pattern(&self) -> Pattern {
        let free = self.sizes.iter().map(|&size| Vertex::coordinates(size));
        let vertices: Vec<Vertex> = free.chain(self.groups.iter().map(|&(rows, _)| Vertex::multipliers(rows))).collect();
        let couplings: Vec<Vec<u32>> =
            self.groups.iter().enumerate().flat_map(|(m, (_, nodes))| nodes.iter().map(move |&node| vec![node, self.group(m)])).collect();
        let mut taken = BTreeSet::new();
        let anchors: Vec<(u32, u32)> = self
            .groups
            .iter()
            .enumerate()
            .filter_map(|(m, (rows, nodes))| {
                let is_good = |node: &&u32| self.sizes[**node as usize] >= *rows && !taken.contains(*node);
                let anchor = *nodes.iter().find(is_good)?;
                taken.insert(anchor);
                Some((self.group(m), anchor))
            })
            .collect();
        Pattern::new(&vertices, self.cells.iter().chain(&couplings).map(Vec::as_slice)).with_anchors(anchors)
    }

    fn group(&self, m: usize) -> u32 {
        (self.sizes.len() + m) as u32
    }

    /// Diagonally dominant and unsymmetric among the coordinates; random between coordinates and multipliers; zero or small among
    /// multipliers.
    fn values(&self, pattern: &Pattern) -> Vec<f64> {
        let mut values = vec![0.0; pattern.values()];
        let mut place = 0;
        let mut noise = || {
            place += 1;
            self.noise[(place * place) % self.noise.len()] * (1.0 + 0.1 * (place as f64).sin())
        };
        for v in 0..pattern.vertices() as u32 {
            for &u in pattern.neighbors(v as usize) {
                let (block, [rows, columns]) = (pattern.block(u, v), [u, v].map(|w| pattern.size(w as usize)));
                let multipliers = [u, v].map(|w| pattern.is_multiplier(w as usize));
                for (i, k) in (0..rows).flat_map(|i| (0..columns).map(move |k| (i, k))) {
                    values[block.at(i, k)] = match multipliers {
                        [false, false] if u == v && i == k => 30.0 * self.stiffness,
                        [false, false] => self.stiffness * noise(),
                        [true, true] => 0.0,
                        _ => noise(),
                    };
                }
            }
        }
        values
    }
}

fn dense(pattern: &Pattern, values: &[f64]) -> DMatrix<f64> {
    let (starts, rows, places) = pattern.compressed_columns();
    let mut matrix = DMatrix::zeros(pattern.unknowns(), pattern.unknowns());
    for column in 0..pattern.unknowns() {
        for k in starts[column]..starts[column + 1] {
            matrix[(rows[k], column)] = places[k].map_or(0.0, |place| values[place]);
        }
    }
    matrix
}

proptest! {
    #[test]
    fn a_pattern_couples_what_the_graph_does(graph in graphs()) {
        let pattern = graph.pattern();
        let mut pairs: BTreeSet<(u32, u32)> = (0..pattern.vertices() as u32).map(|v| (v, v)).collect();
        for cell in &graph.cells {
            pairs.extend(cell.iter().flat_map(|&a| cell.iter().map(move |&b| (a, b))));
        }
        for (m, (rows, nodes)) in graph.groups.iter().enumerate() {
            prop_assert_eq!(pattern.vertex(graph.group(m) as usize), Vertex { role: Role::Multipliers, size: *rows });
            pairs.extend(nodes.iter().flat_map(|&node| [(node, graph.group(m)), (graph.group(m), node)]));
        }
        let found = (0..pattern.vertices() as u32).flat_map(|v| pattern.neighbors(v as usize).iter().map(move |&u| (u, v)));
        prop_assert_eq!(found.collect::<BTreeSet<_>>(), pairs);
        // Every value corresponds to exactly one matrix position.
        let (.., places) = pattern.compressed_columns();
        prop_assert!(places.into_iter().eq((0..pattern.values()).map(Some)));
        // Zero blocks, and no others, are left out of the structure.
        let mut values = graph.values(&pattern);
        for v in 0..pattern.vertices() as u32 {
            for &u in pattern.neighbors(v as usize).iter().filter(|&&u| u != v && (u + v) % 3 == 0) {
                let block: Block = pattern.block(u, v);
                let zeros = (0..pattern.size(u as usize)).flat_map(|i| (0..pattern.size(v as usize)).map(move |k| (i, k)));
                zeros.for_each(|(i, k)| values[block.at(i, k)] = 0.0);
            }
        }
        let present = pattern.present(&values);
        let mut is_out = vec![false; values.len()];
        pattern.left_out(&present).into_iter().flatten().for_each(|place| is_out[place as usize] = true);
        prop_assert!(values.iter().zip(&is_out).all(|(&value, &is_out)| !is_out || value == 0.0));
        let restricted = pattern.restricted(&present);
        prop_assert_eq!(dense(&restricted, &values), dense(&pattern, &values));
        let x: Vec<f64> = (0..pattern.unknowns()).map(|k| (k as f64).cos()).collect();
        let mut y = vec![0.0; x.len()];
        pattern.multiply_into(&values, &x, &mut y);
        let expected = dense(&pattern, &values) * DVector::from_vec(x);
        prop_assert!((DVector::from_vec(y) - &expected).amax() <= 1e-13 * 30.0 * graph.stiffness.max(1.0) * 300.0);
    }

    #[test]
    fn orders_have_every_vertex_once_and_multipliers_behind_their_anchors(graph in graphs()) {
        let pattern = graph.pattern();
        for order in candidates(&pattern, &InterruptWatch::default()) {
            let vertices = anchored(&pattern, &order);
            let symbolic = Symbolic::new(&pattern, &vertices);
            let order = Order::new(vertices.clone(), symbolic.parents.clone());
            prop_assert!(order.is_sound());
            let repaired = order.repaired(&pattern);
            prop_assert_eq!(&repaired, &vertices);
            let mut place = vec![0; vertices.len()];
            vertices.iter().enumerate().for_each(|(k, &v)| place[v as usize] = k);
            for m in 0..graph.groups.len() {
                if let Some(anchor) = pattern.anchor(graph.group(m) as usize) {
                    prop_assert!(place[anchor as usize] < place[graph.group(m) as usize]);
                }
            }
        }
    }

    #[test]
    fn the_solution_is_that_of_the_dense_matrix(graph in graphs(), threads in 1..3usize) {
        let pattern = graph.pattern();
        let values = graph.values(&pattern);
        let matrix = dense(&pattern, &values);
        let x = DVector::from_fn(pattern.unknowns(), |k, _| {
            let is_multiplier = pattern.is_multiplier(pattern.vertex_of(k));
            (1.0 + 0.7 * k as f64).sin() * if is_multiplier { graph.stiffness } else { 1.0 }
        });
        let mut right: Vec<f64> = (&matrix * &x).iter().copied().collect();
        // Scaled like a change of units: coordinates unchanged, multipliers as forces divided by a stiffness.
        let root = graph.stiffness.sqrt();
        let scale = |k: usize| if pattern.is_multiplier(pattern.vertex_of(k)) { root } else { root.recip() };
        let scaled = DMatrix::from_fn(x.len(), x.len(), |i, k| scale(i) * matrix[(i, k)] * scale(k));
        let singular = scaled.singular_values();
        let is_good = singular.max() < CONDITION * singular.min();
        let mut factorization = Factorization::new(&pattern).unwrap().with_workers(&Workers::new(threads));
        factorization.factorize(&values).unwrap();
        match factorization.solve(&values, &mut right) {
            Ok(_) if is_good => {
                let error = (0..x.len()).map(|k| ((right[k] - x[k]) / scale(k)).abs()).fold(0.0, f64::max);
                let size = (0..x.len()).map(|k| (x[k] / scale(k)).abs()).fold(0.0, f64::max);
                prop_assert!(error <= 1e-13 * CONDITION * size, "error {error:e} of {size:e}, {:e}", singular.max() / singular.min());
            }
            Err(error) if is_good => prop_assert!(false, "{error} at {:e}", singular.max() / singular.min()),
            // A nearly singular matrix may be refused or solved.
            Ok(_) | Err(LinearError::Singular { .. } | LinearError::Inaccurate { .. }) => {}
            Err(error) => prop_assert!(false, "{error}"),
        }
    }
}
