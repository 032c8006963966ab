//! Law whose discrete gradient starts from the mean stress over a strain increment (mean-value discrete gradient: Harten, Lax and van Leer,
//! SIAM Review 25, 1983; McLachlan, Quispel and Robidoux, Phil. Trans. R. Soc. A 357, 1999).
//!
//! ```text
//! g = m + a d,   m = (S(E_a) + S(E_b)) / 2,   a = (W(E_1) - W(E_0) - m.d) / d.d,   d = E_1 - E_0
//! ```
//!
//! with the strains `E_a`, `E_b` at the two Gauss points between `E_0` and `E_1`. The second term corrects the quadrature error of the
//! energy, of fourth order in `d`.

use std::sync::Arc;

use super::batched::{BatchedLaw, Components, IncrementResponse, Response};
use crate::math::lanes::Lanes;

/// A law with mean-value discrete gradients.
pub struct MeanValue<const S: usize>(pub Arc<dyn BatchedLaw<S>>);

/// Positions of the two Gauss points in an increment, from 0 to 1.
fn shares() -> [f64; 2] {
    let offset = 0.5 / 3.0_f64.sqrt();
    [0.5 - offset, 0.5 + offset]
}

/// Number of increments computed at a time.
const CHUNK: usize = 8;

macro_rules! averaged {
    ($size:literal) => {
        impl BatchedLaw<$size> for MeanValue<$size> {
            fn energies_into(&self, strain: &[Components<$size>], energy: &mut [Lanes<false>]) {
                self.0.energies_into(strain, energy);
            }
            fn stresses_into(&self, strain: &[Components<$size>], stress: &mut [Components<$size>]) {
                self.0.stresses_into(strain, stress);
            }
            fn responses_into(&self, strain: &[Components<$size>], responses: &mut [Response<$size>]) {
                self.0.responses_into(strain, responses);
            }
            /// Replaces values at the mean strain by averages over both Gauss points: stress `m`, tangent twice `dm/dE_1`, and the
            /// remainder `W(E_1) - W(E_0) - m.d`.
            fn increments_into(
                &self,
                strain_n: &[Components<$size>],
                strain_n1: &[Components<$size>],
                increments: &mut [IncrementResponse<$size>],
            ) {
                self.0.increments_into(strain_n, strain_n1, increments);
                for ((starts, ends), increments) in strain_n.chunks(CHUNK).zip(strain_n1.chunks(CHUNK)).zip(increments.chunks_mut(CHUNK)) {
                    let mut at_points = [[Response::ZERO; CHUNK]; 2];
                    for (share, responses) in shares().into_iter().zip(&mut at_points) {
                        let mut strain = [[Lanes::ZERO; $size]; CHUNK];
                        for (strain, (start, end)) in strain.iter_mut().zip(starts.iter().zip(ends)) {
                            *strain = std::array::from_fn(|k| start[k] * (1.0 - share) + end[k] * share);
                        }
                        self.0.responses_into(&strain[..starts.len()], &mut responses[..starts.len()]);
                    }
                    for (p, increment) in increments.iter_mut().enumerate() {
                        average(increment, at_points.each_ref().map(|responses| &responses[p]), &starts[p], &ends[p]);
                    }
                }
            }
            fn has_kinks(&self) -> bool {
                self.0.has_kinks()
            }
        }
    };
}

averaged!(3);
averaged!(4);
averaged!(6);

/// Replaces the response at the mean strain by averages of the responses `a` and `b` at both Gauss points, and adapts the remainder.
fn average<const S: usize>(increment: &mut IncrementResponse<S>, [a, b]: [&Response<S>; 2], start: &Components<S>, end: &Components<S>) {
    let [share_a, share_b] = shares();
    for k in 0..S {
        let stress = (a.stress[k] + b.stress[k]) * 0.5;
        increment.remainder = increment.remainder - (stress - increment.mean.stress[k]) * (end[k] - start[k]);
        increment.mean.stress[k] = stress;
        for l in 0..S {
            increment.mean.tangent[k][l] = a.tangent[k][l] * share_a + b.tangent[k][l] * share_b;
        }
    }
}
