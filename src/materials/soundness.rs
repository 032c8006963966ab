//! Weaknesses of a law: stress or energy at zero strain, nonpositive stiffness, loss of ellipticity.
//!
//! Ellipticity requires a positive definite acoustic tensor `Q_ik = A_iJkL N_J N_L`, `A = dP/dF`, for every direction `N` (Marsden and
//! Hughes, Mathematical Foundations of Elasticity, 1983, section 6.1). Without it deformation localizes in bands of mesh width. It is
//! checked along uniaxial, equibiaxial and pure-shear tension and compression with free faces, in many directions; other paths are not
//! checked.

use nalgebra::{Matrix3, Matrix6, Vector3};

use super::homogeneous::{Homogeneous, HomogeneousTest, path, response};
use super::laws::Kinematics;
use super::material::Material;
use crate::math::tensor::{mandel_index, mandel_scale};
use crate::math::tolerances::RESIDUAL_STRESS;

/// Weakness of a law.
#[derive(Clone, Debug, PartialEq)]
pub enum Weakness {
    /// Largest component of the stress at zero strain `[stress]`.
    StressAtRest(f64),
    /// Nonzero energy at zero strain `[energy/volume]`; it affects no result.
    EnergyAtRest(f64),
    /// Least stiffness at zero strain `[stress]`, an eigenvalue of the tangent, not positive.
    StiffnessAtRest(f64),
    /// The equations lose ellipticity.
    Ellipticity {
        /// Name of the test.
        test: &'static str,
        /// Stretch at which ellipticity is lost.
        stretch: f64,
    },
}

impl std::fmt::Display for Weakness {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Weakness::StressAtRest(stress) => {
                write!(out, "there is a stress of {stress:.6e} at rest: the undeformed body is not in equilibrium")
            }
            Weakness::EnergyAtRest(energy) => write!(out, "the energy at rest is {energy:.6e} instead of 0; results count from there"),
            Weakness::StiffnessAtRest(stiffness) => {
                write!(out, "the least stiffness at rest is {stiffness:.6e}, which is not positive: some strain meets no resistance")
            }
            Weakness::Ellipticity { test, stretch } => {
                write!(out, "ellipticity is lost in the {test} test at a stretch of {stretch:.3}: beyond, a body folds into bands of cells")
            }
        }
    }
}

/// Largest stretch that is checked; the smallest is its inverse.
const REACH: f64 = 4.0;
/// Ratio of successive stretches.
const STEP: f64 = 1.02;
/// Number of bisections of a step, which give the stretch to three digits.
const BISECTIONS: usize = 8;
/// Number of directions on a half sphere, four degrees apart.
const DIRECTIONS: usize = 1200;

impl Material {
    /// Returns the weaknesses of the law found by all checks; empty for a sound law.
    pub fn weaknesses(&self) -> Vec<Weakness> {
        let mut found = self.weaknesses_at_rest();
        let is_sound = !found.iter().any(|weakness| matches!(weakness, Weakness::StressAtRest(_) | Weakness::StiffnessAtRest(_)));
        // Plastic flow comes before any strain at which an elastic law could lose ellipticity.
        if self.kinematics() == Kinematics::GreenLagrange && is_sound && self.history().is_none() {
            found.extend(self.lost_ellipticity());
        }
        found
    }

    /// Returns the weaknesses of the law at zero strain.
    pub fn weaknesses_at_rest(&self) -> Vec<Weakness> {
        let mut found = Vec::new();
        let (stress, tangent) = response(&*self.space(), &[0.0; 6]);
        let residual = stress.iter().map(|x| x.abs()).fold(0.0, f64::max);
        if residual > RESIDUAL_STRESS * self.youngs_modulus() {
            found.push(Weakness::StressAtRest(residual));
        }
        let energy = self.energy().and_then(|energy| energy.at_rest().ok()).unwrap_or(0.0);
        if energy.abs() > RESIDUAL_STRESS * self.youngs_modulus() {
            found.push(Weakness::EnergyAtRest(energy));
        }
        let stiffness = Matrix6::from_fn(|i, j| tangent[i][j]).symmetric_eigenvalues().min();
        if stiffness <= RESIDUAL_STRESS * self.youngs_modulus() {
            found.push(Weakness::StiffnessAtRest(stiffness));
        }
        found
    }

    fn lost_ellipticity(&self) -> Vec<Weakness> {
        let directions = directions();
        let mut found = Vec::new();
        let is_elliptic = |state: &Homogeneous| self.least_acoustic(state, &directions) > 0.0;
        for (test, piece) in HomogeneousTest::ALL {
            for factor in [STEP, 1.0 / STEP] {
                let count = (REACH.ln() / STEP.ln()) as i32;
                let stretches: Vec<f64> = (1..=count).map(|k| factor.powi(k)).collect();
                let states = path(self, piece, &stretches);
                let Some(first) = states.iter().position(|state| !is_elliptic(state)) else { continue };
                let (mut sound, mut lost) = (if first == 0 { 1.0 } else { stretches[first - 1] }, stretches[first]);
                for _ in 0..BISECTIONS {
                    let middle = 0.5 * (sound + lost);
                    let way: Vec<f64> = stretches[..first].iter().copied().chain([middle]).collect();
                    match path(self, piece, &way).get(first) {
                        Some(state) if is_elliptic(state) => sound = middle,
                        _ => lost = middle,
                    }
                }
                found.push(Weakness::Ellipticity { test, stretch: lost });
            }
        }
        found
    }

    /// Least eigenvalue of the acoustic tensors over all directions, in a state.
    fn least_acoustic(&self, state: &Homogeneous, directions: &[Vector3<f64>]) -> f64 {
        let (stress, tangent) = response(&*self.space(), state.strain());
        let f = state.deformation_gradient();
        let entry = |i: usize, j: usize| stress[mandel_index::<3>(i, j)] * mandel_scale(i, j);
        let s = Matrix3::from_fn(entry);
        directions
            .iter()
            .map(|n| {
                // Q = F c F^T + (N.S.N) I with c_MN = C_MJNL N_J N_L.
                let mut c = Matrix3::zeros();
                for m in 0..3 {
                    for k in 0..3 {
                        for (j, l) in (0..3).flat_map(|j| (0..3).map(move |l| (j, l))) {
                            let scale = mandel_scale(m, j) * mandel_scale(k, l);
                            c[(m, k)] += tangent[mandel_index::<3>(m, j)][mandel_index::<3>(k, l)] * scale * n[j] * n[l];
                        }
                    }
                }
                (f * c * f.transpose() + Matrix3::identity() * n.dot(&(s * n))).symmetric_eigenvalues().min()
            })
            .fold(f64::INFINITY, f64::min)
    }
}

/// Directions that cover a half sphere evenly (golden-angle spiral), with the axes and diagonals.
fn directions() -> Vec<Vector3<f64>> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let spiral = (0..DIRECTIONS).map(|k| {
        let z = (k as f64 + 0.5) / DIRECTIONS as f64;
        let (sine, cosine) = (k as f64 * golden).sin_cos();
        Vector3::new((1.0 - z * z).sqrt() * cosine, (1.0 - z * z).sqrt() * sine, z)
    });
    let axes = (0..27).map(|k| Vector3::new(f64::from(k % 3) - 1.0, f64::from(k / 3 % 3) - 1.0, f64::from(k / 9) - 1.0));
    spiral.chain(axes.filter(|axis| axis.norm() > 0.0).map(|axis| axis.normalize())).collect()
}
