//! Preconditioner of a saddle-point matrix: smoothed aggregation for the coordinates, small dense blocks for the multipliers.
//!
//! With coordinates `u` and multipliers `lambda` the matrix is `[K B; C D]`. The preconditioner is the inverse of
//!
//! ```text
//! [ K  B ]      E = D + diag(w) / WEIGHT,   w_r = - c_r diag(K)^-1 b_r
//! [ C  E ]
//! ```
//!
//! in which every constraint has about the compliance of its own nodes: `u = (K - B E^-1 C)^-1 (f - B E^-1 g)` by a V-cycle, and `lambda =
//! E^-1 (g - C u)`. Eigenvalues of the preconditioned matrix are those of `S / (S + E)`, `S = -C K^-1 B`, which is of size `w` for the
//! roughest multipliers and larger for all others: they are in an interval that does not depend on the mesh. Multipliers couple with few
//! others (the normal and tangential ones of a node), so `E` is inverted by groups. Aggregates do not reach across surfaces in contact,
//! because sides slide on each other.

use super::blocks::{BlockMatrix, TOGETHER, frobenius, in_parts, inverse, times};
use super::hierarchy::Hierarchy;
use crate::linear::pattern::Pattern;
use crate::math::workers::Workers;

/// Stiffness of a constraint in the preconditioner relative to that of its nodes. Larger ones need fewer multiplier corrections and more
/// smoothing.
const WEIGHT: f64 = 4.0;

/// Largest number of multipliers whose block of `E` is inverted; larger groups keep their diagonal alone.
const LARGEST_GROUP: usize = 12;

/// No node.
const NONE: u32 = u32::MAX;

/// A node with the column `b` and the gradient `c` of a multiplier.
struct Entry<const D: usize> {
    node: u32,
    column: [f64; D],
    gradient: [f64; D],
}

/// Multipliers that couple with each other.
struct Group {
    members: Vec<u32>,
    /// `E^-1` of the group, by rows.
    inverse: Vec<f64>,
}

/// The preconditioner of a scaled matrix.
pub(super) struct Saddle<const D: usize, const M: usize> {
    hierarchy: Hierarchy<D, M>,
    /// First unknown of every node, and the unknown of every multiplier.
    firsts: Vec<usize>,
    unknowns: Vec<usize>,
    /// Nodes of every multiplier.
    entries: Vec<Vec<Entry<D>>>,
    groups: Vec<Group>,
    right: Vec<[f64; D]>,
    solution: Vec<[f64; D]>,
    multipliers: Vec<f64>,
}

/// Scaled matrix from which a preconditioner is made.
pub(super) struct Scaled<'a> {
    pub pattern: &'a Pattern,
    pub values: &'a [f64],
    /// Scale of each vertex.
    pub scales: &'a [f64],
    /// Positions of the nodes, as many numbers for each of the leading vertices as it has unknowns.
    pub positions: &'a [f64],
}

impl Scaled<'_> {
    /// Scaled block in row `u` and column `v`.
    fn block<const R: usize, const C: usize>(&self, u: u32, v: u32) -> [[f64; C]; R] {
        let place = self.pattern.block(u, v);
        let scale = self.scales[u as usize] * self.scales[v as usize];
        std::array::from_fn(|i| std::array::from_fn(|k| scale * self.values[place.at(i, k)]))
    }
}

impl<const D: usize, const M: usize> Saddle<D, M> {
    /// Preconditioner of a matrix; `None` if it has vertices of other sizes, or nodes without stiffness.
    pub fn new(matrix: &Scaled, workers: &Workers) -> Option<Self> {
        let pattern = matrix.pattern;
        let (mut nodes, mut multipliers): (Vec<u32>, Vec<(u32, usize)>) = Default::default();
        let mut place = vec![NONE; pattern.vertices()];
        for v in 0..pattern.vertices() {
            if pattern.is_multiplier(v) {
                place[v] = multipliers.len() as u32;
                multipliers.extend((0..pattern.size(v)).map(|k| (v as u32, k)));
            } else {
                if pattern.size(v) != D || pattern.is_carried(v) {
                    return None;
                }
                place[v] = nodes.len() as u32;
                nodes.push(v as u32);
            }
        }
        let own: Vec<[[f64; D]; D]> = nodes.iter().map(|&v| matrix.block(v, v)).collect();
        if own.iter().any(|block| (0..D).any(|i| block[i][i] == 0.0)) || (nodes.len() * D) as u64 > matrix.positions.len() as u64 {
            return None;
        }
        let compliances: Vec<[[f64; D]; D]> = own.iter().map(inverse).collect();
        let entries: Vec<Vec<Entry<D>>> = multipliers.iter().map(|&row| entries_of(matrix, row, &place)).collect();
        let groups = groups_of(matrix, &multipliers, &place, &entries, &compliances);
        let augmented = augmented(matrix, &nodes, &place, &entries, &groups, workers);
        let modes = modes_of(matrix, &nodes, &augmented);
        let bodies = bodies_of(&augmented, &entries);
        let hierarchy = Hierarchy::new(augmented, &modes, bodies, workers);
        Some(Saddle {
            hierarchy,
            firsts: nodes.iter().map(|&v| pattern.first_unknown(v as usize)).collect(),
            unknowns: multipliers.iter().map(|&(v, k)| pattern.first_unknown(v as usize) + k).collect(),
            right: vec![[0.0; D]; nodes.len()],
            solution: vec![[0.0; D]; nodes.len()],
            multipliers: vec![0.0; multipliers.len()],
            entries,
            groups,
        })
    }

    /// Bytes of the preconditioner.
    pub fn bytes(&self) -> usize {
        self.hierarchy.bytes() + self.entries.iter().map(|entries| size_of_val(&entries[..])).sum::<usize>()
    }

    /// `x :=` preconditioner applied to `b`, both for the scaled matrix.
    pub fn apply(&mut self, b: &[f64], x: &mut [f64], workers: &Workers) {
        let Saddle { hierarchy, firsts, unknowns, entries, groups, right, solution, multipliers } = self;
        right.iter_mut().zip(&*firsts).for_each(|(right, &first)| right.copy_from_slice(&b[first..first + D]));
        let response = |multipliers: &mut [f64], gaps: &dyn Fn(usize) -> f64| {
            for group in groups.iter() {
                let gaps: Vec<f64> = group.members.iter().map(|&r| gaps(r as usize)).collect();
                for (row, &r) in group.inverse.chunks_exact(gaps.len()).zip(&group.members) {
                    multipliers[r as usize] = row.iter().zip(&gaps).map(|(e, gap)| e * gap).sum();
                }
            }
        };
        response(multipliers, &|r| b[unknowns[r]]);
        for (entries, lambda) in entries.iter().zip(&*multipliers).filter(|(_, lambda)| **lambda != 0.0) {
            for entry in entries {
                (0..D).for_each(|i| right[entry.node as usize][i] -= lambda * entry.column[i]);
            }
        }
        hierarchy.cycle(right, solution, workers);
        let along = |entry: &Entry<D>| (0..D).map(|i| entry.gradient[i] * solution[entry.node as usize][i]).sum::<f64>();
        response(multipliers, &|r| b[unknowns[r]] - entries[r].iter().map(along).sum::<f64>());
        firsts.iter().zip(&*solution).for_each(|(&first, solution)| x[first..first + D].copy_from_slice(solution));
        unknowns.iter().zip(&*multipliers).for_each(|(&unknown, lambda)| x[unknown] = *lambda);
    }
}

/// Nodes with nonzero entries in the row or the column of a multiplier.
fn entries_of<const D: usize>(matrix: &Scaled, (v, k): (u32, usize), place: &[u32]) -> Vec<Entry<D>> {
    let (pattern, mut entries) = (matrix.pattern, Vec::new());
    for &u in pattern.neighbors(v as usize).iter().filter(|&&u| !pattern.is_multiplier(u as usize)) {
        let scale = matrix.scales[u as usize] * matrix.scales[v as usize];
        let (column, row) = (pattern.block(u, v), pattern.block(v, u));
        let entry = Entry {
            node: place[u as usize],
            column: std::array::from_fn(|i| scale * matrix.values[column.at(i, k)]),
            gradient: std::array::from_fn(|i| scale * matrix.values[row.at(k, i)]),
        };
        if entry.column.iter().chain(&entry.gradient).any(|x| *x != 0.0) {
            entries.push(entry);
        }
    }
    entries
}

/// Groups of multipliers that couple with each other, with `E^-1`.
fn groups_of<const D: usize>(
    matrix: &Scaled,
    multipliers: &[(u32, usize)],
    place: &[u32],
    entries: &[Vec<Entry<D>>],
    compliances: &[[[f64; D]; D]],
) -> Vec<Group> {
    let pattern = matrix.pattern;
    let value = |(u, i): (u32, usize), (v, k): (u32, usize)| {
        let place = pattern.find_block(u, v);
        place.map_or(0.0, |place| matrix.scales[u as usize] * matrix.scales[v as usize] * matrix.values[place.at(i, k)])
    };
    // The first member of each multiplier's group; couplings lead from later to earlier ones and back.
    let mut leader: Vec<u32> = (0..multipliers.len() as u32).collect();
    fn root(leader: &[u32], mut r: u32) -> u32 {
        while leader[r as usize] != r {
            r = leader[r as usize];
        }
        r
    }
    for (r, &(v, k)) in multipliers.iter().enumerate() {
        for &u in pattern.neighbors(v as usize).iter().filter(|&&u| pattern.is_multiplier(u as usize)) {
            for i in 0..pattern.size(u as usize) {
                let other = place[u as usize] + i as u32;
                if (other as usize) < r && (value((v, k), (u, i)) != 0.0 || value((u, i), (v, k)) != 0.0) {
                    let (a, b) = (root(&leader, r as u32), root(&leader, other));
                    leader[a.max(b) as usize] = a.min(b);
                }
            }
        }
    }
    let mut members: Vec<Vec<u32>> = vec![Vec::new(); multipliers.len()];
    (0..multipliers.len() as u32).for_each(|r| members[root(&leader, r) as usize].push(r));
    let yielding = |r: usize| -> f64 {
        let terms = entries[r].iter().map(|entry| {
            let moved = times(&compliances[entry.node as usize], &entry.column);
            -(0..D).map(|i| entry.gradient[i] * moved[i]).sum::<f64>()
        });
        terms.sum::<f64>() / WEIGHT
    };
    let groups = members
        .into_iter()
        .filter(|members| !members.is_empty())
        .flat_map(|members| if members.len() <= LARGEST_GROUP { vec![members] } else { members.into_iter().map(|r| vec![r]).collect() });
    groups
        .map(|members| {
            let at = |r: u32| multipliers[r as usize];
            let size = members.len();
            let own = nalgebra::DMatrix::from_fn(size, size, |i, k| {
                value(at(members[i]), at(members[k])) + if i == k { yielding(members[i] as usize) } else { 0.0 }
            });
            let inverse = own.try_inverse().unwrap_or_else(|| nalgebra::DMatrix::identity(size, size));
            Group { members, inverse: inverse.transpose().as_slice().to_vec() }
        })
        .collect()
}

/// `K - B E^-1 C` in blocks.
fn augmented<const D: usize>(
    matrix: &Scaled,
    nodes: &[u32],
    place: &[u32],
    entries: &[Vec<Entry<D>>],
    groups: &[Group],
    workers: &Workers,
) -> BlockMatrix<D, D> {
    // Multipliers of each node with its columns, and the group and the place in it of each multiplier.
    let mut of_node: Vec<Vec<(u32, [f64; D])>> = vec![Vec::new(); nodes.len()];
    for (r, entries) in entries.iter().enumerate() {
        let columns = entries.iter().filter(|entry| entry.column.iter().any(|x| *x != 0.0));
        columns.for_each(|entry| of_node[entry.node as usize].push((r as u32, entry.column)));
    }
    let mut group_of = vec![(0, 0); entries.len()];
    for (g, group) in groups.iter().enumerate() {
        group.members.iter().enumerate().for_each(|(i, &r)| group_of[r as usize] = (g, i));
    }
    let pattern = matrix.pattern;
    in_parts(nodes.len(), TOGETHER, workers, |rows, part| {
        let mut position = vec![NONE; nodes.len()];
        let mut row: Vec<(u32, [[f64; D]; D])> = Vec::new();
        for node in rows {
            let v = nodes[node];
            row.clear();
            for &u in pattern.neighbors(v as usize).iter().filter(|&&u| !pattern.is_multiplier(u as usize)) {
                let block: [[f64; D]; D] = matrix.block(v, u);
                if u == v || frobenius(&block) > 0.0 {
                    position[place[u as usize] as usize] = row.len() as u32;
                    row.push((place[u as usize], block));
                }
            }
            for (r, column) in &of_node[node] {
                let (g, i) = group_of[*r as usize];
                let Group { members, inverse } = &groups[g];
                for (&s, e) in members.iter().zip(&inverse[i * members.len()..]).filter(|(_, e)| **e != 0.0) {
                    for entry in entries[s as usize].iter().filter(|entry| entry.gradient.iter().any(|x| *x != 0.0)) {
                        let at = &mut position[entry.node as usize];
                        if *at == NONE {
                            *at = row.len() as u32;
                            row.push((entry.node, [[0.0; D]; D]));
                        }
                        let block = &mut row[*at as usize].1;
                        for i in 0..D {
                            for k in 0..D {
                                block[i][k] -= e * column[i] * entry.gradient[k];
                            }
                        }
                    }
                }
            }
            row.iter().for_each(|(j, _)| position[*j as usize] = NONE);
            row.sort_unstable_by_key(|(j, _)| *j);
            part.push_row(row.drain(..));
        }
    })
}

/// Body of every node: nodes that are connected without constraints. Two nodes of one constraint may be on either side of it, and the
/// geometric stiffness of contact forces couples them; nodes of one body are connected through its inside, too.
fn bodies_of<const D: usize>(augmented: &BlockMatrix<D, D>, entries: &[Vec<Entry<D>>]) -> Vec<u32> {
    let mut rows: Vec<Vec<u32>> = vec![Vec::new(); augmented.rows()];
    for (r, entries) in entries.iter().enumerate() {
        entries.iter().for_each(|entry| rows[entry.node as usize].push(r as u32));
    }
    let share_a_row = |i: usize, j: usize| rows[i].iter().any(|row| rows[j].binary_search(row).is_ok());
    let (mut of, mut count, mut waiting) = (vec![NONE; augmented.rows()], 0, Vec::new());
    for start in 0..of.len() {
        if of[start] != NONE {
            continue;
        }
        of[start] = count;
        waiting.push(start);
        while let Some(i) = waiting.pop() {
            for &j in augmented.row(i).0 {
                if of[j as usize] == NONE && !share_a_row(i, j as usize) {
                    of[j as usize] = count;
                    waiting.push(j as usize);
                }
            }
        }
        count += 1;
    }
    of
}

/// Rigid motions of the nodes in scaled unknowns, zero in unknowns without couplings.
fn modes_of<const D: usize, const M: usize>(matrix: &Scaled, nodes: &[u32], augmented: &BlockMatrix<D, D>) -> Vec<[[f64; M]; D]> {
    let position = |v: u32| -> [f64; D] { std::array::from_fn(|i| matrix.positions[D * v as usize + i]) };
    let mut middle = [0.0; D];
    nodes.iter().for_each(|&v| (0..D).for_each(|i| middle[i] += position(v)[i] / nodes.len() as f64));
    let mode = |(node, &v): (usize, &u32)| {
        let at = position(v);
        let arm: [f64; D] = std::array::from_fn(|i| at[i] - middle[i]);
        let (columns, blocks) = augmented.row(node);
        std::array::from_fn(|i| {
            let couples = |(&j, block): (&u32, &[[f64; D]; D])| (0..D).any(|k| block[i][k] != 0.0 && (j != node as u32 || i != k));
            if !columns.iter().zip(blocks).any(couples) {
                return [0.0; M];
            }
            let mut row = [0.0; M];
            row[i] = 1.0;
            // A rotation for each pair of axes.
            let pairs = (0..D).flat_map(|a| (a + 1..D).map(move |b| (a, b)));
            for (m, (a, b)) in (D..M).zip(pairs) {
                row[m] = if i == a {
                    -arm[b]
                } else if i == b {
                    arm[a]
                } else {
                    0.0
                };
            }
            row.map(|x| x / matrix.scales[v as usize])
        })
    };
    nodes.iter().enumerate().map(mode).collect()
}
