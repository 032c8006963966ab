//! Homogeneous deformations of a material, as in the test piece of a testing machine.
//!
//! The prescribed stretches of a test are given; all other strain components follow from zero stresses (Newton's method on the components,
//! from the previous stretch of a path). Nominal stresses are forces per undeformed area.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector, Matrix3};

use super::batched::{BatchedLaw, Components, Response};
use super::history::{Heat, HistoryLaw, StrainStep};
use super::laws::Kinematics;
use super::material::Material;
use crate::math::lanes::Lanes;
use crate::math::tensor::{mandel_pairs, mandel_scale};
use crate::math::tolerances::FREE_STRESS;

/// Homogeneous test of a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HomogeneousTest {
    /// Pulled along the first axis, free across.
    Uniaxial,
    /// Equal stretches along the first two axes, zero stress along the third.
    Equibiaxial,
    /// Pulled along the first axis, held along the second, free along the third: a wide strip, also called planar tension.
    PureShear,
}

impl HomogeneousTest {
    /// All test pieces with their names.
    pub const ALL: [(&'static str, HomogeneousTest); 3] = [
        ("uniaxial", HomogeneousTest::Uniaxial),
        ("equibiaxial", HomogeneousTest::Equibiaxial),
        ("pure shear", HomogeneousTest::PureShear),
    ];

    /// Stretches of the three axes at constant volume.
    pub fn isochoric(self, stretch: f64) -> [f64; 3] {
        match self {
            HomogeneousTest::Uniaxial => [stretch, 1.0 / stretch.sqrt(), 1.0 / stretch.sqrt()],
            HomogeneousTest::Equibiaxial => [stretch, stretch, stretch.powi(-2)],
            HomogeneousTest::PureShear => [stretch, 1.0, 1.0 / stretch],
        }
    }

    /// Number of prescribed strains among the first two.
    fn given(self) -> usize {
        if self == HomogeneousTest::Uniaxial { 1 } else { 2 }
    }
}

/// A homogeneous state of a test piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Homogeneous {
    /// Stretch along the first axis.
    pub stretch: f64,
    /// Force along the first axis per undeformed area `[stress]`.
    pub nominal_stress: f64,
    /// Strain measure of the law, in Mandel components.
    strain: [f64; 6],
}

/// Largest number of iterations from one stretch to the next.
const ITERATIONS: usize = 30;
/// Largest number of halvings of the interval between two stretches.
const HALVINGS: u32 = 12;

/// States of a test piece at successive stretches, up to the first one without a solution. Paths of elastic laws lead away from stretch 1.
pub fn path(material: &Material, piece: HomogeneousTest, stretches: &[f64]) -> Vec<Homogeneous> {
    let law = &*material.space();
    if material.kinematics() == Kinematics::Linear {
        return stretches.iter().filter_map(|&stretch| linear(law, piece, stretch)).collect();
    }
    let mut kept = material.history().map(|history| AtHistory::new(history.space(true)));
    let mut states: Vec<Homogeneous> = Vec::new();
    let mut last = Homogeneous { stretch: 1.0, nominal_stress: 0.0, strain: [0.0; 6] };
    for &stretch in stretches {
        let respond = |strain: &[f64; 6]| kept.as_ref().map_or_else(|| response(law, strain), |kept| kept.respond(strain));
        let Some(state) = reach(&respond, piece, &last, stretch) else { break };
        states.push(state);
        kept.iter_mut().for_each(|kept| kept.advance(&state.strain));
        last = state;
    }
    states
}

/// Stress and tangent of a strain.
type Respond<'a> = &'a dyn Fn(&[f64; 6]) -> ([f64; 6], [[f64; 6]; 6]);

/// Law with history variables, evaluated at rest, and the history variables left by the strains so far.
struct AtHistory {
    law: Arc<dyn HistoryLaw<6>>,
    history: Vec<Lanes<false>>,
}

impl AtHistory {
    fn new(law: Arc<dyn HistoryLaw<6>>) -> Self {
        let history = vec![Lanes::ZERO; law.variables()];
        AtHistory { law, history }
    }

    fn step<'a>(&'a self, strain: &'a [Components<6>; 1]) -> StrainStep<'a, 6> {
        StrainStep::at_rest(strain, &[[Lanes::ZERO; 6]], &self.history)
    }

    /// Stress and tangent of the next strain.
    fn respond(&self, strain: &[f64; 6]) -> ([f64; 6], [[f64; 6]; 6]) {
        let mut response = [Response::ZERO];
        self.law.responses_into(&self.step(&[strain.map(|x| Lanes([x; 8]))]), &mut response);
        first_lane(&response[0])
    }

    /// Advances the history variables to a strain.
    fn advance(&mut self, strain: &[f64; 6]) {
        let (strain, mut after, mut heat) = ([strain.map(|x| Lanes([x; 8]))], self.history.clone(), [Heat::ZERO]);
        self.law.advance_into(&self.step(&strain), &mut after, &mut heat);
        self.history = after;
    }
}

/// State at a stretch, starting from another state; the interval is divided if one step fails.
fn reach(respond: Respond, piece: HomogeneousTest, from: &Homogeneous, stretch: f64) -> Option<Homogeneous> {
    let (mut state, mut part, mut done) = (*from, 1.0f64, 0.0f64);
    while done < 1.0 {
        let next = (done + part).min(1.0);
        let at = from.stretch + next * (stretch - from.stretch);
        match solve(respond, piece, &state, at) {
            Some(found) => (state, done) = (found, next),
            None if part > 0.5f64.powi(HALVINGS as i32) => part *= 0.5,
            None => return None,
        }
    }
    Some(state)
}

/// Stress and tangent at a strain.
pub(super) fn response(law: &dyn BatchedLaw<6>, strain: &[f64; 6]) -> ([f64; 6], [[f64; 6]; 6]) {
    let components: Components<6> = strain.map(|x| Lanes([x; 8]));
    let mut response = [Response::ZERO];
    law.responses_into(&[components], &mut response);
    first_lane(&response[0])
}

fn first_lane(response: &Response<6>) -> ([f64; 6], [[f64; 6]; 6]) {
    (response.stress.map(|x| x.0[0]), response.tangent.map(|row| row.map(|x| x.0[0])))
}

/// `C = I + 2 E` as a matrix.
fn metric(strain: &[f64; 6]) -> Matrix3<f64> {
    let mut c = Matrix3::identity();
    for (k, (i, j)) in mandel_pairs::<6>().into_iter().enumerate() {
        let entry = 2.0 * strain[k] * mandel_scale(i, j);
        c[(i, j)] += entry;
        if i != j {
            c[(j, i)] += entry;
        }
    }
    c
}

/// Indices of the strain components that a test leaves free; test pieces clamped along two axes do not shear in their plane.
fn free_components(piece: HomogeneousTest) -> Vec<usize> {
    if piece.given() == 1 { (1..6).collect() } else { vec![2, 4, 5] }
}

/// State of a law of small strains, with the strain `stretch - 1` along the first axis.
fn linear(law: &dyn BatchedLaw<6>, piece: HomogeneousTest, stretch: f64) -> Option<Homogeneous> {
    let mut strain = [0.0; 6];
    strain[..if piece == HomogeneousTest::Equibiaxial { 2 } else { 1 }].fill(stretch - 1.0);
    let free = free_components(piece);
    let (stress, tangent) = response(law, &strain);
    let residual = DVector::from_iterator(free.len(), free.iter().map(|&i| stress[i]));
    let change = DMatrix::from_fn(free.len(), free.len(), |a, b| tangent[free[a]][free[b]]).lu().solve(&residual)?;
    free.iter().zip(change.iter()).for_each(|(&i, change)| strain[i] -= change);
    Some(Homogeneous { stretch, nominal_stress: response(law, &strain).0[0], strain })
}

/// Newton's method for the components whose stress vanishes.
fn solve(respond: Respond, piece: HomogeneousTest, from: &Homogeneous, stretch: f64) -> Option<Homogeneous> {
    let given = piece.given();
    let free = free_components(piece);
    let mut strain = from.strain;
    // Initial guess: stretches scaled at constant volume.
    let (old, new) = (piece.isochoric(from.stretch), piece.isochoric(stretch));
    for k in 0..3 {
        let c = (1.0 + 2.0 * strain[k]) * (new[k] / old[k]).powi(2);
        strain[k] = 0.5 * (c - 1.0);
    }
    strain[0] = 0.5 * (stretch * stretch - 1.0);
    if given == 2 {
        strain[1] = if piece == HomogeneousTest::Equibiaxial { strain[0] } else { 0.0 };
    }
    for _ in 0..ITERATIONS {
        let (stress, tangent) = respond(&strain);
        let size = (0..6).map(|i| tangent[i][i].abs()).fold(0.0, f64::max);
        if !size.is_finite() || metric(&strain).cholesky().is_none() {
            return None;
        }
        let residual = DVector::from_iterator(free.len(), free.iter().map(|&i| stress[i]));
        if residual.amax() <= FREE_STRESS * size {
            return Some(Homogeneous { stretch, nominal_stress: stretch * stress[0], strain });
        }
        let matrix = DMatrix::from_fn(free.len(), free.len(), |a, b| tangent[free[a]][free[b]]);
        let change = matrix.lu().solve(&residual)?;
        // The increment is reduced until the volume ratio stays positive.
        let mut share = 1.0;
        let moved = |share: f64| {
            let mut moved = strain;
            free.iter().zip(change.iter()).for_each(|(&i, change)| moved[i] -= share * change);
            moved
        };
        while share > 0.5f64.powi(HALVINGS as i32) && metric(&moved(share)).cholesky().is_none() {
            share *= 0.5;
        }
        strain = moved(share);
    }
    None
}

impl Homogeneous {
    /// Deformation gradient without rotation of the first axis: `C = F^T F`, `F` upper triangular.
    pub fn deformation_gradient(&self) -> Matrix3<f64> {
        metric(&self.strain).cholesky().map_or(Matrix3::identity(), |factors| factors.l().transpose())
    }

    /// Strain measure of the law, in Mandel components.
    pub(super) fn strain(&self) -> &[f64; 6] {
        &self.strain
    }
}
