//! Eight cells that are computed together, lane by lane: from positions of their nodes to strains at their points.
//!
//! Kept per batch is only what it costs least to read again, the cells' nodes and edges; gradients of the shape functions, volumes and
//! strains are computed anew in every pass, because a processor does that faster than it fetches them from beyond its caches.
//! Everything is relative to the last node of a cell: the gradients of the shape functions sum to zero, so it takes what the others leave.

use crate::elements::ReferenceCell;
use crate::materials::Components;
use crate::math::lanes::{Lanes, Real, WIDTH};
use crate::math::tensor::{mandel_index, mandel_scale};

/// Shape functions of a reference cell at its quadrature points.
pub(super) struct Table<const D: usize, const A: usize, const Q: usize> {
    /// Products of the shape functions, for the mass.
    pub(super) products: [[[f64; A]; A]; Q],
    /// Shares of the nodes in a value at a point, for smoothed fields.
    pub(super) smoothing: [[f64; A]; Q],
    pub(super) gradients: [[[f64; D]; A]; Q],
    pub(super) weights: [f64; Q],
}

impl<const D: usize, const A: usize, const Q: usize> Table<D, A, Q> {
    pub(super) fn new<C: ReferenceCell<D, A, Q>>() -> Self {
        let points = C::quadrature();
        Table {
            products: C::products(),
            smoothing: points.map(|(xi, _)| C::smoothing(xi)),
            gradients: points.map(|(xi, _)| C::gradients(xi)),
            weights: points.map(|(_, w)| w),
        }
    }
}

/// Eight cells. Where there are fewer, the first is repeated.
pub(super) struct Batch<const D: usize, const A: usize> {
    /// Node numbers in the model, node by node of the cells.
    pub(super) nodes: [[u32; WIDTH]; A],
    /// Number of cells.
    pub(super) count: usize,
    /// Vectors from the last node to each node, at rest.
    pub(super) edges: [[Lanes<false>; D]; A],
}

impl<const D: usize, const A: usize> Batch<D, A> {
    /// The batch of up to eight cells with such points, whose nodes are numbered from `first_node`.
    pub(super) fn new(cells: &[&[u32]], points: &[[f64; 3]], first_node: usize) -> Self {
        let mut batch = Batch { nodes: [[0; WIDTH]; A], count: cells.len(), edges: [[Lanes::ZERO; D]; A] };
        for lane in 0..WIDTH {
            let cell = cells.get(lane).unwrap_or(&cells[0]);
            for a in 0..A {
                batch.nodes[a][lane] = cell[a] + first_node as u32;
                for i in 0..D {
                    batch.edges[a][i].0[lane] = points[cell[a] as usize][i] - points[cell[A - 1] as usize][i];
                }
            }
        }
        batch
    }

    /// Displacements of the nodes relative to the last node of each cell.
    #[inline(always)]
    pub(super) fn displacements<const FMA: bool>(&self, q: &[f64]) -> [[Lanes<FMA>; D]; A] {
        let mut u = [[Lanes::ZERO; D]; A];
        for a in 0..A {
            for lane in 0..WIDTH {
                let position = &q[self.nodes[a][lane] as usize * D..][..D];
                for i in 0..D {
                    u[a][i].0[lane] = position[i];
                }
            }
        }
        for a in 0..A - 1 {
            for i in 0..D {
                u[a][i] = u[a][i] - u[A - 1][i] - cast(self.edges[a][i]);
            }
        }
        u
    }
}

/// A quadrature point of eight cells.
#[derive(Clone, Copy)]
pub(super) struct Point<const FMA: bool, const D: usize, const A: usize> {
    /// Gradients of the shape functions; that of the last node is left out.
    pub(super) gradients: [[Lanes<FMA>; D]; A],
    /// Volume that belongs to the point.
    pub(super) volume: Lanes<FMA>,
}

impl<const FMA: bool, const D: usize, const A: usize> Point<FMA, D, A> {
    pub(super) const ZERO: Self = Point { gradients: [[Lanes::ZERO; D]; A], volume: Lanes::ZERO };

    /// The point of cells with such edges, where the shape functions have these gradients on the reference cell.
    #[inline(always)]
    pub(super) fn new(edges: &[[Lanes<false>; D]; A], gradients: &[[f64; D]; A], weight: f64) -> Self {
        let mut jacobian = [[Lanes::<FMA>::ZERO; D]; D];
        for i in 0..D {
            for j in 0..D {
                for a in 0..A - 1 {
                    jacobian[i][j] = cast::<FMA>(edges[a][i]).mul_add(Lanes::splat(gradients[a][j]), jacobian[i][j]);
                }
            }
        }
        let (determinant, cofactor) = determinant_and_cofactor(&jacobian);
        let inverse = Lanes::splat(1.0) / determinant;
        let mut point = Point { gradients: [[Lanes::ZERO; D]; A], volume: determinant * weight };
        for i in 0..D {
            for j in 0..D {
                let slope = cofactor[i][j] * inverse;
                for a in 0..A - 1 {
                    point.gradients[a][i] = slope.mul_add(Lanes::splat(gradients[a][j]), point.gradients[a][i]);
                }
            }
        }
        point
    }

    /// Displacement gradient.
    #[inline(always)]
    pub(super) fn displacement_gradient(&self, u: &[[Lanes<FMA>; D]; A]) -> [[Lanes<FMA>; D]; D] {
        let mut h = [[Lanes::ZERO; D]; D];
        for i in 0..D {
            for j in 0..D {
                for a in 0..A - 1 {
                    h[i][j] = u[a][i].mul_add(self.gradients[a][j], h[i][j]);
                }
            }
        }
        h
    }
}

#[inline(always)]
pub(super) fn cast<const FMA: bool>(x: Lanes<false>) -> Lanes<FMA> {
    Lanes(x.0)
}

/// Determinant and cofactor matrix.
#[inline(always)]
pub(super) fn determinant_and_cofactor<const FMA: bool, const D: usize>(m: &[[Lanes<FMA>; D]; D]) -> (Lanes<FMA>, [[Lanes<FMA>; D]; D]) {
    let mut cofactor = [[Lanes::ZERO; D]; D];
    for i in 0..D {
        for j in 0..D {
            // Cyclic neighbors of the row and the column.
            let (r, s, c, d) = ((i + 1) % D, (i + 2) % D, (j + 1) % D, (j + 2) % D);
            cofactor[i][j] = match (D, i == j) {
                (2, true) => m[r][c],
                (2, false) => -m[r][c],
                _ => m[r][c] * m[s][d] - m[r][d] * m[s][c],
            };
        }
    }
    let mut determinant = m[0][0] * cofactor[0][0];
    for j in 1..D {
        determinant = m[0][j].mul_add(cofactor[0][j], determinant);
    }
    (determinant, cofactor)
}

/// `F = I + H`.
#[inline(always)]
pub(super) fn deformation_gradient<const FMA: bool, const D: usize>(h: &[[Lanes<FMA>; D]; D]) -> [[Lanes<FMA>; D]; D] {
    let mut f = *h;
    for (i, row) in f.iter_mut().enumerate() {
        row[i] = row[i] + 1.0;
    }
    f
}

/// `(H_0 + H_1) / 2`.
#[inline(always)]
pub(super) fn mean<const FMA: bool, const D: usize>(h_0: &[[Lanes<FMA>; D]; D], h_1: &[[Lanes<FMA>; D]; D]) -> [[Lanes<FMA>; D]; D] {
    let mut mean = *h_1;
    for i in 0..D {
        for j in 0..D {
            mean[i][j] = (h_0[i][j] + h_1[i][j]) * 0.5;
        }
    }
    mean
}

/// Green-Lagrange strain of `F = I + H` in Mandel components, with relative accuracy at small strain.
#[inline(always)]
pub(super) fn strain_of<const FMA: bool, const D: usize, const S: usize>(h: &[[Lanes<FMA>; D]; D]) -> Components<S> {
    let mut strain = [Lanes::ZERO; S];
    for i in 0..D {
        for j in i..D {
            let mut sum = h[i][j] + h[j][i];
            for row in h {
                sum = row[i].mul_add(row[j], sum);
            }
            strain[mandel_index::<D>(i, j)] = Lanes((sum * (0.5 / mandel_scale(i, j))).0);
        }
    }
    strain
}
