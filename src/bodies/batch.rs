//! Eight cells that are computed together, lane by lane: from positions of their nodes to force and tangent.
//!
//! Kept per batch is only what it costs least to read again, the cells' nodes and edges; gradients of the shape functions, volumes and
//! strains are computed anew in every pass, because a processor does that faster than it fetches them from beyond its caches.
//! Everything is relative to the last node of a cell: the gradients of the shape functions sum to zero, so it takes what the others leave.

use crate::elements::ReferenceCell;
use crate::integrators::{Configuration, Integrator, Placement, discrete_gradient};
use crate::materials::{Batch as Law, IncrementResponse, Response, Strain};
use crate::math::lanes::{Lanes, Real, WIDTH, relabel, relabel_rows};
use crate::math::tensor::{mandel_index, mandel_scale};
use crate::math::tolerances::STRAIN_INCREMENT_SQUARED;

/// Shape functions of a reference cell at its quadrature points.
pub(super) struct Table<const D: usize, const A: usize, const Q: usize> {
    pub(super) shapes: [[f64; A]; Q],
    gradients: [[[f64; D]; A]; Q],
    weights: [f64; Q],
}

impl<const D: usize, const A: usize, const Q: usize> Table<D, A, Q> {
    pub(super) fn new<C: ReferenceCell<D, A, Q>>() -> Self {
        let points = C::quadrature();
        Table {
            shapes: points.map(|(xi, _)| C::shape(xi)),
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
    edges: [[Lanes<false>; D]; A],
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
    fn displacements<const FMA: bool>(&self, q: &[f64]) -> [[Lanes<FMA>; D]; A] {
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
    gradients: [[Lanes<FMA>; D]; A],
    /// Volume that belongs to the point.
    pub(super) volume: Lanes<FMA>,
}

impl<const FMA: bool, const D: usize, const A: usize> Point<FMA, D, A> {
    const ZERO: Self = Point { gradients: [[Lanes::ZERO; D]; A], volume: Lanes::ZERO };

    /// The point of cells with such edges, where the shape functions have these gradients on the reference cell.
    #[inline(always)]
    fn new(edges: &[[Lanes<false>; D]; A], gradients: &[[f64; D]; A], weight: f64) -> Self {
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
    fn displacement_gradient(&self, u: &[[Lanes<FMA>; D]; A]) -> [[Lanes<FMA>; D]; D] {
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
fn cast<const FMA: bool>(x: Lanes<false>) -> Lanes<FMA> {
    Lanes(x.0)
}

/// Determinant and cofactor matrix.
#[inline(always)]
fn determinant_and_cofactor<const FMA: bool, const D: usize>(m: &[[Lanes<FMA>; D]; D]) -> (Lanes<FMA>, [[Lanes<FMA>; D]; D]) {
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
fn deformation_gradient<const FMA: bool, const D: usize>(h: &[[Lanes<FMA>; D]; D]) -> [[Lanes<FMA>; D]; D] {
    let mut f = *h;
    for (i, row) in f.iter_mut().enumerate() {
        row[i] = row[i] + 1.0;
    }
    f
}

/// `(H_0 + H_1) / 2`.
#[inline(always)]
fn mean<const FMA: bool, const D: usize>(h_0: &[[Lanes<FMA>; D]; D], h_1: &[[Lanes<FMA>; D]; D]) -> [[Lanes<FMA>; D]; D] {
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
fn strain_of<const FMA: bool, const D: usize, const S: usize>(h: &[[Lanes<FMA>; D]; D]) -> Strain<S> {
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

/// What is known of a batch at its points while it is computed: strains and the law's answers, force and tangent.
pub(super) struct Workspace<const FMA: bool, const D: usize, const S: usize, const A: usize, const Q: usize> {
    pub(super) points: [Point<FMA, D, A>; Q],
    /// Displacement gradients at the start and at the end of the step.
    gradient_0: [[[Lanes<FMA>; D]; D]; Q],
    pub(super) gradient_1: [[[Lanes<FMA>; D]; D]; Q],
    pub(super) strain_0: [Strain<S>; Q],
    pub(super) strain_1: [Strain<S>; Q],
    increments: [IncrementResponse<S>; Q],
    responses: [Response<S>; Q],
    /// Forces on the nodes.
    pub(super) force: [[Lanes<FMA>; D]; A],
    /// Tangent, column by column of the nodes: `tangent[b][k][a][i]` is the derivative of `force[a][i]` with respect to `q[b][k]`.
    pub(super) tangent: [[[[Lanes<FMA>; D]; A]; D]; A],
}

impl<const FMA: bool, const D: usize, const S: usize, const A: usize, const Q: usize> Workspace<FMA, D, S, A, Q> {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Workspace {
            points: [Point::ZERO; Q],
            gradient_0: [[[Lanes::ZERO; D]; D]; Q],
            gradient_1: [[[Lanes::ZERO; D]; D]; Q],
            strain_0: [[Lanes::ZERO; S]; Q],
            strain_1: [[Lanes::ZERO; S]; Q],
            increments: [IncrementResponse::ZERO; Q],
            responses: [Response::ZERO; Q],
            force: [[Lanes::ZERO; D]; A],
            tangent: [[[[Lanes::ZERO; D]; A]; D]; A],
        }
    }

    /// The points of a batch.
    #[inline(always)]
    pub(super) fn set_points(&mut self, batch: &Batch<D, A>, table: &Table<D, A, Q>) {
        for q in 0..Q {
            self.points[q] = Point::new(&batch.edges, &table.gradients[q], table.weights[q]);
        }
    }

    /// Displacement gradients and strains at the end of the step.
    #[inline(always)]
    pub(super) fn set_end(&mut self, batch: &Batch<D, A>, q_1: &[f64]) {
        let u = batch.displacements(q_1);
        for q in 0..Q {
            self.gradient_1[q] = self.points[q].displacement_gradient(&u);
            self.strain_1[q] = strain_of(&self.gradient_1[q]);
        }
    }

    /// Displacement gradients and strains at the start of the step.
    #[inline(always)]
    pub(super) fn set_start(&mut self, batch: &Batch<D, A>, q_0: &[f64]) {
        let u = batch.displacements(q_0);
        for q in 0..Q {
            self.gradient_0[q] = self.points[q].displacement_gradient(&u);
            self.strain_0[q] = strain_of(&self.gradient_0[q]);
        }
    }

    /// Smallest determinant of the deformation gradient at the end of the step, not a number where one is not.
    #[inline(always)]
    pub(super) fn smallest_determinants(&self) -> Lanes<FMA> {
        let mut smallest = Lanes::splat(f64::INFINITY);
        for h in &self.gradient_1 {
            let determinant = determinant_and_cofactor(&deformation_gradient(h)).0;
            for lane in 0..WIDTH {
                // Also takes the new one where the comparison has no answer.
                let keep = smallest.0[lane] < determinant.0[lane] || smallest.0[lane].is_nan();
                smallest.0[lane] = if keep { smallest.0[lane] } else { determinant.0[lane] };
            }
        }
        smallest
    }

    /// Whether some cell is inside out at the end of the step.
    #[inline(always)]
    pub(super) fn is_inside_out(&self) -> bool {
        let mut sound = true;
        for h in &self.gradient_1 {
            let determinant = determinant_and_cofactor(&deformation_gradient(h)).0;
            for lane in 0..WIDTH {
                sound &= determinant.0[lane] > 0.0;
            }
        }
        !sound
    }

    /// Stresses and their derivatives as the integrator wants them, between [`Self::set_end`] and [`Self::integrate`].
    #[inline(always)]
    pub(super) fn respond(&mut self, law: &dyn Law<S>, integrator: Integrator) {
        match integrator {
            Integrator::EnergyMomentum => law.increments_into(&self.strain_0, &self.strain_1, &mut self.increments),
            Integrator::Midpoint => {
                let mut strain = [[Lanes::ZERO; S]; Q];
                for q in 0..Q {
                    strain[q] = strain_of(&mean(&self.gradient_0[q], &self.gradient_1[q]));
                }
                law.responses_into(&strain, &mut self.responses);
            }
            Integrator::Trapezoidal => law.responses_into(&self.strain_1, &mut self.responses),
        }
    }

    /// Algorithmic stress at a point and its derivative with respect to the strain at the end.
    #[inline(always)]
    fn stress_and_tangent(&self, q: usize, integrator: Integrator) -> ([Lanes<FMA>; S], [[Lanes<FMA>; S]; S]) {
        if integrator == Integrator::EnergyMomentum {
            let mut d = [Lanes::<FMA>::ZERO; S];
            for s in 0..S {
                d[s] = cast::<FMA>(self.strain_1[q][s]) - cast(self.strain_0[q][s]);
            }
            let IncrementResponse { mean, stress_end, remainder } = &self.increments[q];
            return discrete_gradient(
                &d,
                &relabel(&mean.stress),
                &relabel_rows(&mean.tangent),
                &relabel(stress_end),
                cast(*remainder),
                STRAIN_INCREMENT_SQUARED,
            );
        }
        let (stress, mut tangent) = (relabel(&self.responses[q].stress), relabel_rows(&self.responses[q].tangent));
        if integrator == Integrator::Midpoint {
            for component in tangent.iter_mut().flatten() {
                *component = *component * 0.5;
            }
        }
        (stress, tangent)
    }

    /// Deformation gradient at a point.
    #[inline(always)]
    fn deformation_gradient(&self, q: usize, configuration: Configuration) -> [[Lanes<FMA>; D]; D] {
        match configuration {
            Configuration::Middle => deformation_gradient(&mean(&self.gradient_0[q], &self.gradient_1[q])),
            Configuration::End => deformation_gradient(&self.gradient_1[q]),
        }
    }

    /// Sums the force alone over the points, to the same bytes as [`Self::integrate`].
    #[inline(always)]
    pub(super) fn integrate_force(&mut self, integrator: Integrator) {
        let Placement { test, weight, .. } = integrator.placement();
        self.force = [[Lanes::ZERO; D]; A];
        for q in 0..Q {
            let (stress, _) = self.stress_and_tangent(q, integrator);
            let test = self.deformation_gradient(q, test);
            add_force(&self.points[q].gradients, &test, &stress, self.points[q].volume * weight, &mut self.force);
        }
        self.finish_force();
    }

    /// Sums force and tangent over the points.
    #[inline(always)]
    pub(super) fn integrate(&mut self, integrator: Integrator) {
        let Placement { test, trial, share, weight } = integrator.placement();
        self.clear();
        for q in 0..Q {
            let (stress, tangent) = self.stress_and_tangent(q, integrator);
            let (test, trial) = (self.deformation_gradient(q, test), self.deformation_gradient(q, trial));
            let Point { gradients, volume } = &self.points[q];
            add_point(gradients, &test, &trial, &stress, &tangent, *volume * weight, share, &mut self.force, &mut self.tangent);
        }
        self.finish();
    }

    /// Sums the material stiffness `int B^T D B dV` over the points; the responses are those at the strains at the end.
    #[inline(always)]
    pub(super) fn integrate_material_stiffness(&mut self, factor: f64) {
        self.clear();
        for q in 0..Q {
            let (stress, tangent) = (relabel(&self.responses[q].stress), relabel_rows(&self.responses[q].tangent));
            let f = deformation_gradient(&self.gradient_1[q]);
            let Point { gradients, volume } = &self.points[q];
            add_point(gradients, &f, &f, &stress, &tangent, *volume * factor, 0.0, &mut self.force, &mut self.tangent);
        }
        self.finish();
    }

    /// Sums begin.
    #[inline(always)]
    fn clear(&mut self) {
        self.force = [[Lanes::ZERO; D]; A];
        self.tangent = [[[[Lanes::ZERO; D]; A]; D]; A];
    }

    /// The last node takes what the others leave.
    #[inline(always)]
    fn finish_force(&mut self) {
        for i in 0..D {
            let mut last = Lanes::ZERO;
            for a in 0..A - 1 {
                last = last - self.force[a][i];
            }
            self.force[A - 1][i] = last;
        }
    }

    /// The same for force and tangent.
    #[inline(always)]
    fn finish(&mut self) {
        self.finish_force();
        for k in 0..D {
            for i in 0..D {
                for b in 0..A - 1 {
                    let mut last = Lanes::ZERO;
                    for a in 0..A - 1 {
                        last = last - self.tangent[b][k][a][i];
                    }
                    self.tangent[b][k][A - 1][i] = last;
                }
                for a in 0..A {
                    let mut last = Lanes::ZERO;
                    for b in 0..A - 1 {
                        last = last - self.tangent[b][k][a][i];
                    }
                    self.tangent[A - 1][k][a][i] = last;
                }
            }
        }
    }

    /// Adds `factor` times the consistent mass to the tangent.
    #[inline(always)]
    pub(super) fn add_mass(&mut self, table: &Table<D, A, Q>, factor: f64) {
        for a in 0..A {
            for b in 0..=a {
                let mut mass = Lanes::ZERO;
                for q in 0..Q {
                    mass = self.points[q].volume.mul_add(Lanes::splat(factor * table.shapes[q][a] * table.shapes[q][b]), mass);
                }
                for i in 0..D {
                    self.tangent[b][i][a][i] = self.tangent[b][i][a][i] + mass;
                    if a != b {
                        self.tangent[a][i][b][i] = self.tangent[a][i][b][i] + mass;
                    }
                }
            }
        }
    }
}

/// Adds the force of a point, the last node left out: `f_a = P G_a` with the first Piola stress `P = w F_test S`.
#[inline(always)]
fn add_force<const FMA: bool, const D: usize, const S: usize, const A: usize>(
    gradients: &[[Lanes<FMA>; D]; A],
    test: &[[Lanes<FMA>; D]; D],
    stress: &[Lanes<FMA>; S],
    weight: Lanes<FMA>,
    force: &mut [[Lanes<FMA>; D]; A],
) {
    let mut piola = [[Lanes::<FMA>::ZERO; D]; D];
    for i in 0..D {
        for j in 0..D {
            for m in 0..D {
                let factor = test[i][m] * weight * mandel_scale(m, j);
                piola[i][j] = factor.mul_add(stress[mandel_index::<D>(m, j)], piola[i][j]);
            }
        }
    }
    for a in 0..A - 1 {
        for i in 0..D {
            for j in 0..D {
                force[a][i] = piola[i][j].mul_add(gradients[a][j], force[a][i]);
            }
        }
    }
}

/// Adds force and tangent of a point, the last node left out:
/// `K_ab = G_a . A . G_b` with `A_iJkL = w ((F_test)_iM T_MJNL (F_trial)_kN + share S_JL delta_ik)`.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "the names of the formula")]
fn add_point<const FMA: bool, const D: usize, const S: usize, const A: usize>(
    gradients: &[[Lanes<FMA>; D]; A],
    test: &[[Lanes<FMA>; D]; D],
    trial: &[[Lanes<FMA>; D]; D],
    stress: &[Lanes<FMA>; S],
    tangent: &[[Lanes<FMA>; S]; S],
    weight: Lanes<FMA>,
    share: f64,
    force: &mut [[Lanes<FMA>; D]; A],
    blocks: &mut [[[[Lanes<FMA>; D]; A]; D]; A],
) {
    add_force(gradients, test, stress, weight, force);
    // half[iJ][s] = w (F_test)_iM T_MJ,s
    let mut half = [[[Lanes::<FMA>::ZERO; S]; D]; D];
    for i in 0..D {
        for j in 0..D {
            for m in 0..D {
                let factor = test[i][m] * weight * mandel_scale(m, j);
                let component = mandel_index::<D>(m, j);
                for s in 0..S {
                    half[i][j][s] = factor.mul_add(tangent[component][s], half[i][j][s]);
                }
            }
        }
    }
    // moduli[i][J][k][L] = half[iJ][NL] (F_trial)_kN + share w S_JL delta_ik.
    let mut moduli = [[[[Lanes::<FMA>::ZERO; D]; D]; D]; D];
    for i in 0..D {
        for j in 0..D {
            for k in 0..D {
                for l in 0..D {
                    let mut sum = Lanes::<FMA>::ZERO;
                    for n in 0..D {
                        sum = (half[i][j][mandel_index::<D>(n, l)] * mandel_scale(n, l)).mul_add(trial[k][n], sum);
                    }
                    if i == k {
                        let geometric = stress[mandel_index::<D>(j, l)] * (mandel_scale(j, l) * share);
                        sum = geometric.mul_add(weight, sum);
                    }
                    moduli[i][j][k][l] = sum;
                }
            }
        }
    }
    for a in 0..A - 1 {
        for i in 0..D {
            let mut row = [[Lanes::<FMA>::ZERO; D]; D];
            for j in 0..D {
                for k in 0..D {
                    for l in 0..D {
                        row[k][l] = gradients[a][j].mul_add(moduli[i][j][k][l], row[k][l]);
                    }
                }
            }
            for b in 0..A - 1 {
                for k in 0..D {
                    for l in 0..D {
                        blocks[b][k][a][i] = row[k][l].mul_add(gradients[b][l], blocks[b][k][a][i]);
                    }
                }
            }
        }
    }
}
