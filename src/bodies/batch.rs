//! Eight cells that are computed together, lane by lane: from nodal displacements to strains at the quadrature points.
//!
//! A batch stores only nodes and edges of the cells; gradients of shape functions, volumes and strains are recomputed in every pass, which
//! is faster than reading them from main memory. All quantities are relative to the last node of a cell: the gradients of the shape
//! functions sum to zero, so its contribution is the negative sum of the others.

use crate::elements::ReferenceCell;
use crate::integrators::discrete_gradient;
use crate::materials::{Components, IncrementResponse};
use crate::math::lanes::{Lanes, Real, WIDTH, relabel, relabel_rows};
use crate::math::tensor::{mandel_index, mandel_scale};
use crate::math::tolerances::STRAIN_INCREMENT;

/// Largest number of nodes or points for which loops are unrolled: that of first-order cells.
const FEW: usize = 4;

/// Largest number of quadrature points of a cell.
pub(super) const MOST_POINTS: usize = 27;

/// Numbers of nodes and quadrature points of a cell kind. What works on batches is compiled for room for `A` nodes and `Q` points, which
/// several kinds share: code for each kind took twice as long to compile and was no faster. Room for few nodes or points is filled, so that
/// loops over it are unrolled.
#[derive(Clone, Copy)]
pub(super) struct Counts<const A: usize, const Q: usize> {
    nodes: usize,
    points: usize,
}

impl<const A: usize, const Q: usize> Counts<A, Q> {
    /// Counts of a kind with `N` nodes and `P` points.
    pub(super) fn new<const N: usize, const P: usize>() -> Self {
        const { assert!(if A > FEW { N <= A } else { N == A } && if Q > FEW { P <= Q } else { P == Q }) };
        Counts { nodes: N, points: P }
    }

    /// Number of nodes of a cell.
    #[inline(always)]
    pub(super) fn nodes(self) -> usize {
        if A > FEW { self.nodes } else { A }
    }

    /// Number of quadrature points of a cell.
    #[inline(always)]
    pub(super) fn points(self) -> usize {
        if Q > FEW { self.points } else { Q }
    }
}

/// Array with the given first entries and copies of `rest`.
pub(super) fn filled<T: Copy, const M: usize>(first: impl IntoIterator<Item = T>, rest: T) -> [T; M] {
    let mut all = [rest; M];
    all.iter_mut().zip(first).for_each(|(entry, value)| *entry = value);
    all
}

/// Shape functions of a reference cell at its quadrature points; beyond the kind's nodes and points all entries are zero.
pub(super) struct Table<const D: usize, const A: usize, const Q: usize> {
    pub(super) counts: Counts<A, Q>,
    /// Values of the shape functions.
    pub(super) shapes: [[f64; A]; Q],
    /// Products of the shape functions, for the mass.
    pub(super) products: [[[f64; A]; A]; Q],
    /// Factors of the values at a point in the extrapolation to the nodes.
    pub(super) extrapolation: [[f64; A]; Q],
    pub(super) gradients: [[[f64; D]; A]; Q],
    pub(super) weights: [f64; Q],
}

impl<const D: usize, const A: usize, const Q: usize> Table<D, A, Q> {
    pub(super) fn new<C: ReferenceCell<D, N, P>, const N: usize, const P: usize>() -> Self {
        let points = C::quadrature();
        let rows = |row: [f64; N]| filled(row, 0.0);
        Table {
            counts: Counts::new::<N, P>(),
            shapes: filled(points.map(|(xi, _)| rows(C::shape(xi))), [0.0; A]),
            products: filled(C::products().map(|products| filled(products.map(rows), [0.0; A])), [[0.0; A]; A]),
            extrapolation: filled(C::extrapolation().map(rows), [0.0; A]),
            gradients: filled(points.map(|(xi, _)| filled(C::gradients(xi), [0.0; D])), [[0.0; D]; A]),
            weights: filled(points.map(|(_, w)| w), 0.0),
        }
    }

    /// Undeformed position of point `q` relative to the last node of each cell.
    #[inline(always)]
    pub(super) fn place(&self, batch: &Batch<D>, q: usize) -> [Lanes<false>; D] {
        let mut place = [Lanes::ZERO; D];
        for (edge, &shape) in batch.edges[..self.counts.nodes() - 1].iter().zip(&self.shapes[q]) {
            (0..D).for_each(|i| place[i] = place[i] + edge[i] * shape);
        }
        place
    }
}

/// Eight cells; in the last batch the first cell fills missing lanes.
pub(super) struct Batch<const D: usize> {
    /// Node numbers in the model, node by node of the cells.
    pub(super) nodes: Vec<[u32; WIDTH]>,
    /// Number of cells.
    pub(super) count: usize,
    /// Vectors from the last node to each node in the reference positions.
    pub(super) edges: Vec<[Lanes<false>; D]>,
    /// First coordinate of the last node in the reference positions `[length]`; in a body of revolution, its radius.
    pub(super) last: Lanes<false>,
    /// Ratio of stress-free to initial length at each point; empty if initial lengths are stress-free.
    pub(super) growth: Vec<Lanes<false>>,
    /// Integrals of the products of two shape functions, lower triangle row by row; empty if the stiffness quadrature gives them exactly.
    pub(super) mass: Vec<Lanes<false>>,
}

impl<const D: usize> Batch<D> {
    /// Batch of up to eight cells with the node positions `points`; model node numbers start at `first_node`.
    pub(super) fn new(cells: &[&[u32]], points: &[[f64; 3]], first_node: usize) -> Self {
        let count = cells[0].len();
        let mut batch = Batch {
            nodes: vec![[0; WIDTH]; count],
            count: cells.len(),
            edges: vec![[Lanes::ZERO; D]; count],
            last: Lanes::ZERO,
            growth: Vec::new(),
            mass: Vec::new(),
        };
        for lane in 0..WIDTH {
            let cell = cells.get(lane).unwrap_or(&cells[0]);
            let last = points[cell[count - 1] as usize];
            batch.last.0[lane] = last[0];
            for a in 0..count {
                batch.nodes[a][lane] = cell[a] + first_node as u32;
                for i in 0..D {
                    batch.edges[a][i].0[lane] = points[cell[a] as usize][i] - last[i];
                }
            }
        }
        batch
    }

    /// Displacements of the nodes relative to the last node of each cell, and of the last node itself.
    #[inline(always)]
    pub(super) fn displacements<const FMA: bool, const A: usize>(&self, count: usize, all: &[f64]) -> [[Lanes<FMA>; D]; A] {
        let (mut u, nodes) = ([[Lanes::ZERO; D]; A], &self.nodes[..count]);
        for a in 0..count {
            for lane in 0..WIDTH {
                let displacement = &all[nodes[a][lane] as usize * D..][..D];
                for i in 0..D {
                    u[a][i].0[lane] = displacement[i];
                }
            }
        }
        for a in 0..count - 1 {
            for i in 0..D {
                u[a][i] = u[a][i] - u[count - 1][i];
            }
        }
        u
    }
}

/// Quadrature point of eight cells.
#[derive(Clone, Copy)]
pub(super) struct Point<const FMA: bool, const D: usize, const A: usize> {
    /// Gradients of the shape functions except that of the last node.
    pub(super) gradients: [[Lanes<FMA>; D]; A],
    /// Volume of the point in the stress-free state (after swelling), the weight of the energy.
    pub(super) volume: Lanes<FMA>,
    /// Volume of the point in the initial mesh, the weight of the mass.
    pub(super) weighed: Lanes<FMA>,
    /// Stretch from the stress-free state to the initial mesh, minus 1.
    pub(super) slack: Lanes<FMA>,
    /// Inverse distance of the point from the axis of a body of revolution `[1/length]`.
    pub(super) curvature: Lanes<FMA>,
}

impl<const FMA: bool, const D: usize, const A: usize> Point<FMA, D, A> {
    pub(super) const ZERO: Self =
        Point { gradients: [[Lanes::ZERO; D]; A], volume: Lanes::ZERO, weighed: Lanes::ZERO, slack: Lanes::ZERO, curvature: Lanes::ZERO };

    /// Sets the point of cells with the given edges, one for each node; `gradients`: those of the shape functions on the reference cell.
    #[inline(always)]
    pub(super) fn set(&mut self, edges: &[[Lanes<false>; D]], gradients: &[[f64; D]; A], weight: f64) {
        let mut jacobian = [[Lanes::<FMA>::ZERO; D]; D];
        for i in 0..D {
            for j in 0..D {
                for a in 0..edges.len() - 1 {
                    jacobian[i][j] = cast::<FMA>(edges[a][i]).mul_add(Lanes::splat(gradients[a][j]), jacobian[i][j]);
                }
            }
        }
        let (determinant, cofactor) = determinant_and_cofactor(&jacobian);
        let inverse = Lanes::splat(1.0) / determinant;
        let volume = determinant * weight;
        (self.volume, self.weighed, self.slack, self.curvature) = (volume, volume, Lanes::ZERO, Lanes::ZERO);
        self.gradients[..edges.len()].fill([Lanes::ZERO; D]);
        for i in 0..D {
            for j in 0..D {
                let slope = cofactor[i][j] * inverse;
                for a in 0..edges.len() - 1 {
                    self.gradients[a][i] = slope.mul_add(Lanes::splat(gradients[a][j]), self.gradients[a][i]);
                }
            }
        }
    }

    /// Converts the point to one of a body of revolution, whose volume is that of the whole circumference; `last`: radii of the last nodes.
    #[inline(always)]
    pub(super) fn revolve(&mut self, last: Lanes<false>, edges: &[[Lanes<false>; D]], shapes: &[f64; A]) {
        let mut radius = cast::<FMA>(last);
        for a in 0..edges.len() - 1 {
            radius = cast::<FMA>(edges[a][0]).mul_add(Lanes::splat(shapes[a]), radius);
        }
        self.curvature = Lanes::splat(1.0) / radius;
        self.volume = self.volume * radius * std::f64::consts::TAU;
        self.weighed = self.volume;
    }

    /// Scales the stress-free lengths at the point by a factor; the volume grows by the factor in each of `directions` directions.
    #[inline(always)]
    pub(super) fn grow(&mut self, factor: Lanes<FMA>, directions: usize) {
        let inverse = Lanes::splat(1.0) / factor;
        self.slack = (Lanes::splat(1.0) - factor) * inverse;
        self.curvature = self.curvature * inverse;
        self.gradients.iter_mut().flatten().for_each(|slope| *slope = *slope * inverse);
        (0..directions).for_each(|_| self.volume = self.volume * factor);
    }

    /// Hoop stretch from the stress-free state minus 1; without swelling `u_r/R`.
    #[inline(always)]
    pub(super) fn hoop(&self, count: usize, u: &[[Lanes<FMA>; D]; A], shapes: &[f64; A]) -> Lanes<FMA> {
        let mut moved = u[count - 1][0];
        for a in 0..count - 1 {
            moved = u[a][0].mul_add(Lanes::splat(shapes[a]), moved);
        }
        moved * self.curvature + self.slack
    }

    /// Displacement gradient relative to the stress-free state.
    #[inline(always)]
    pub(super) fn displacement_gradient(&self, count: usize, u: &[[Lanes<FMA>; D]; A]) -> [[Lanes<FMA>; D]; D] {
        let mut h = [[Lanes::ZERO; D]; D];
        for i in 0..D {
            h[i][i] = self.slack;
            for j in 0..D {
                for a in 0..count - 1 {
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

/// Discrete gradient of a stored energy between two strains, and its derivative with respect to the second strain.
#[inline(always)]
pub(super) fn discrete_stress<const FMA: bool, const S: usize>(
    strains: [&Components<S>; 2],
    increment: &IncrementResponse<S>,
) -> ([Lanes<FMA>; S], [[Lanes<FMA>; S]; S]) {
    let mut d = [Lanes::<FMA>::ZERO; S];
    let mut size = Lanes::<FMA>::ZERO;
    for s in 0..S {
        let [start, end] = [cast::<FMA>(strains[0][s]), cast(strains[1][s])];
        d[s] = end - start;
        size = start.mul_add(start, end.mul_add(end, size));
    }
    let threshold = size * (STRAIN_INCREMENT * STRAIN_INCREMENT);
    let IncrementResponse { mean, stress_end, remainder } = increment;
    let (gradient, hessian) = (relabel(&mean.stress), relabel_rows(&mean.tangent));
    discrete_gradient(&d, &gradient, &hessian, &relabel(stress_end), cast(*remainder), threshold)
}

/// Determinant and cofactor matrix.
#[inline(always)]
pub(super) fn determinant_and_cofactor<const FMA: bool, const D: usize>(m: &[[Lanes<FMA>; D]; D]) -> (Lanes<FMA>, [[Lanes<FMA>; D]; D]) {
    let mut cofactor = [[Lanes::ZERO; D]; D];
    for i in 0..D {
        for j in 0..D {
            // Cyclically following rows and columns, as in the cofactor formula.
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

/// Deformation gradient `F = I + H`.
#[inline(always)]
pub(super) fn deformation_gradient<const FMA: bool, const D: usize>(h: &[[Lanes<FMA>; D]; D]) -> [[Lanes<FMA>; D]; D] {
    let mut f = *h;
    for (i, row) in f.iter_mut().enumerate() {
        row[i] = row[i] + 1.0;
    }
    f
}

/// Mean displacement gradient `(H_0 + H_1) / 2`.
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

/// Volume ratio less 1, `det(I + H) - 1`, with relative accuracy at small strain.
#[inline(always)]
pub(super) fn volume_change<const FMA: bool, const D: usize>(h: &[[Lanes<FMA>; D]; D]) -> Lanes<FMA> {
    let mut sum = determinant_and_cofactor(h).0;
    for i in 0..D {
        sum = sum + h[i][i];
        for j in i + 1..D {
            // Second invariant of `H`; in the plane it equals the determinant, which is already included.
            if D > 2 {
                sum = sum + (h[i][i] * h[j][j] - h[i][j] * h[j][i]);
            }
        }
    }
    sum
}

/// Strain measure computed from displacement gradients.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Strain {
    /// Green-Lagrange strain `(H + H^T + H^T H)/2`, with relative accuracy at small strain.
    Large,
    /// Linear part of the Green-Lagrange strain.
    Linear,
}

impl Strain {
    /// Strain in Mandel components; `hoop` is the displacement gradient of a stretched third direction.
    #[inline(always)]
    pub(super) fn of<const FMA: bool, const D: usize, const S: usize>(self, h: &[[Lanes<FMA>; D]; D], hoop: Lanes<FMA>) -> Components<S> {
        let mut strain = [Lanes::ZERO; S];
        for i in 0..D {
            for j in i..D {
                let mut sum = h[i][j] + h[j][i];
                if self == Strain::Large {
                    for row in h {
                        sum = row[i].mul_add(row[j], sum);
                    }
                }
                strain[if S == 4 && i != j { 3 } else { mandel_index::<D>(i, j) }] = Lanes((sum * (0.5 / mandel_scale(i, j))).0);
            }
        }
        if S == 4 {
            strain[2] = Lanes(self.around(hoop).0);
        }
        strain
    }

    /// Change of the strain between two displacement gradients, `sym(F_mid^T (H_1 - H_0))`, without the cancellation in a difference of
    /// strains.
    #[inline(always)]
    pub(super) fn change<const FMA: bool, const D: usize, const S: usize>(
        self,
        [h_0, h_1]: [&[[Lanes<FMA>; D]; D]; 2],
        hoop: [Lanes<FMA>; 2],
    ) -> Components<S> {
        let (middle, mut moved) = (mean(h_0, h_1), *h_1);
        moved.iter_mut().flatten().zip(h_0.iter().flatten()).for_each(|(end, start)| *end = *end - *start);
        let mut change = [Lanes::ZERO; S];
        for i in 0..D {
            for j in i..D {
                let mut sum = moved[i][j] + moved[j][i];
                if self == Strain::Large {
                    for (middle, moved) in middle.iter().zip(&moved) {
                        sum = middle[i].mul_add(moved[j], middle[j].mul_add(moved[i], sum));
                    }
                }
                change[if S == 4 && i != j { 3 } else { mandel_index::<D>(i, j) }] = Lanes((sum * (0.5 / mandel_scale(i, j))).0);
            }
        }
        if S == 4 {
            let moved = hoop[1] - hoop[0];
            let around = if self == Strain::Large { ((hoop[0] + hoop[1]) * 0.5).mul_add(moved, moved) } else { moved };
            change[2] = Lanes(around.0);
        }
        change
    }

    /// Hoop strain for a hoop displacement gradient `u_r/R`.
    #[inline(always)]
    pub(super) fn around<const FMA: bool>(self, hoop: Lanes<FMA>) -> Lanes<FMA> {
        if self == Strain::Large { hoop + hoop * hoop * 0.5 } else { hoop }
    }

    /// Deformation gradient for the push-forward of forces: `I + H`, or `I` for linear strains.
    #[inline(always)]
    pub(super) fn frame<const FMA: bool, const D: usize>(self, h: &[[Lanes<FMA>; D]; D]) -> [[Lanes<FMA>; D]; D] {
        match self {
            Strain::Large => deformation_gradient(h),
            Strain::Linear => deformation_gradient(&[[Lanes::ZERO; D]; D]),
        }
    }
    /// Deformation gradient in space of one lane, including the strain across the plane if any; the identity for linear strains.
    pub(super) fn spatial_frame<const D: usize>(
        self,
        h: &[[Lanes<false>; D]; D],
        strain: &Components<6>,
        lane: usize,
    ) -> nalgebra::Matrix3<f64> {
        let mut frame = nalgebra::Matrix3::identity();
        if self == Strain::Large {
            if D == 2 {
                frame.m33 = (1.0 + 2.0 * strain[2].0[lane]).sqrt();
            }
            for i in 0..D {
                for j in 0..D {
                    frame[(i, j)] += h[i][j].0[lane];
                }
            }
        }
        frame
    }
}
