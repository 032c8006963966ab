//! History variables of a quadrature point, and strains in the frame `P = F_p^-1` of the plastic deformation so far.

use super::constants::MOST_BACK_STRESSES;
use super::logarithm::{Matrix, applied, congruence, linked, place};
use crate::math::lanes::{Lanes, Real, relabel};
use crate::math::principal::{PrincipalAxes, matrix, principal};
use crate::math::tensor::{mandel_pairs, mandel_scale};

/// Number of entries of `P` for tensors of `S` components.
const fn frame_entries<const S: usize>() -> usize {
    if S == 6 { 9 } else { 5 }
}

/// Number of history variables for a number of back stresses.
pub(super) const fn variables<const S: usize>(back_stresses: usize) -> usize {
    frame_entries::<S>() + 2 + S * back_stresses
}

/// History variables of a quadrature point in eight elements.
#[derive(Clone, Copy)]
pub(super) struct PlasticPoint<const FMA: bool, const S: usize> {
    /// `P - I` with the inverse plastic deformation gradient `P = F_p^-1`.
    pub(super) frame: Matrix<FMA>,
    /// Equivalent plastic strain.
    pub(super) alpha: Lanes<FMA>,
    /// Heat so far `[energy/volume]`.
    pub(super) heat: Lanes<FMA>,
    /// Back strains in the frame.
    pub(super) back: [[Lanes<FMA>; S]; MOST_BACK_STRESSES],
}

/// Principal values of a strain in the frame.
pub(super) struct Stretches<const FMA: bool> {
    /// Squares of the stretches.
    pub(super) squares: [Lanes<FMA>; 3],
    /// Logarithms of the stretches.
    pub(super) logarithms: [Lanes<FMA>; 3],
    /// Directions, row by row.
    pub(super) directions: Matrix<FMA>,
}

impl<const FMA: bool> Stretches<FMA> {
    /// Placeholder of a loop.
    pub(super) const ZERO: Self = Stretches { squares: [Lanes::ZERO; 3], logarithms: [Lanes::ZERO; 3], directions: [[Lanes::ZERO; 3]; 3] };
}

impl<const FMA: bool, const S: usize> PlasticPoint<FMA, S> {
    /// Reads the history variables of a point.
    #[inline(always)]
    pub(super) fn read(history: &[Lanes<false>], back_stresses: usize) -> Self {
        let mut kept = PlasticPoint {
            frame: [[Lanes::ZERO; 3]; 3],
            alpha: Lanes(history[0].0),
            heat: Lanes(history[1].0),
            back: [[Lanes::ZERO; S]; MOST_BACK_STRESSES],
        };
        let mut next = 2;
        for i in 0..3 {
            for j in 0..3 {
                if linked::<S>(i, j) {
                    kept.frame[i][j] = Lanes(history[next].0);
                    next += 1;
                }
            }
        }
        for back in 0..back_stresses {
            for k in 0..S {
                kept.back[back][k] = Lanes(history[next].0);
                next += 1;
            }
        }
        kept
    }

    /// Writes the history variables of a point.
    #[inline(always)]
    pub(super) fn write(&self, history: &mut [Lanes<false>]) {
        let mut next = history.iter_mut();
        let mut write = |value: Lanes<FMA>| {
            if let Some(slot) = next.next() {
                *slot = Lanes(value.0);
            }
        };
        write(self.alpha);
        write(self.heat);
        for i in 0..3 {
            for j in 0..3 {
                if linked::<S>(i, j) {
                    write(self.frame[i][j]);
                }
            }
        }
        self.back.iter().flatten().for_each(|component| write(*component));
    }

    /// `P^T C P` of a Green-Lagrange strain, as the strain `(P^T C P - I)/2`.
    #[inline(always)]
    fn strain(&self, strain: &[Lanes<FMA>; S]) -> [Lanes<FMA>; S] {
        let (p, e) = (&self.frame, matrix::<FMA, S>(strain));
        // E P = E + E p; zero components are skipped.
        let mut right = e;
        for i in 0..3 {
            for j in 0..3 {
                for k in 0..3 {
                    if linked::<S>(i, k) && linked::<S>(k, j) {
                        right[i][j] = e[i][k].mul_add(p[k][j], right[i][j]);
                    }
                }
            }
        }
        let mut result = [Lanes::ZERO; S];
        for (row, &(i, j)) in mandel_pairs::<S>().iter().enumerate() {
            // sym p + p^T p/2 + E P + p^T E P.
            let mut sum = (p[i][j] + p[j][i]) * 0.5 + right[i][j];
            for k in 0..3 {
                if linked::<S>(i, k) && linked::<S>(k, j) {
                    sum = p[k][i].mul_add(p[k][j] * 0.5 + right[k][j], sum);
                }
            }
            result[row] = sum * (1.0 / mandel_scale(i, j));
        }
        result
    }

    /// Principal values and directions of a strain in the frame.
    #[inline(always)]
    pub(super) fn stretches(&self, strain: &[Lanes<false>; S]) -> Stretches<FMA> {
        let PrincipalAxes { values, directions } = principal(&self.strain(&relabel(strain)));
        let (mut squares, mut logarithms) = ([Lanes::ZERO; 3], [Lanes::ZERO; 3]);
        for i in 0..3 {
            squares[i] = values[i] * 2.0 + 1.0;
            logarithms[i] = (values[i] * 2.0).ln_1p() * 0.5;
        }
        Stretches { squares, logarithms, directions }
    }

    /// Back strains in principal directions, row by row.
    #[inline(always)]
    pub(super) fn turned_back(&self, directions: &Matrix<FMA>, back_stresses: usize) -> [[Lanes<FMA>; S]; MOST_BACK_STRESSES] {
        let mut turned = self.back;
        if back_stresses > 0 {
            let map = congruence(directions);
            turned.iter_mut().take(back_stresses).for_each(|back| *back = applied(&map, back));
        }
        turned
    }

    /// `W` with the columns `P n_i`, which maps tensors in principal directions to the reference: `W T W^T`.
    #[inline(always)]
    pub(super) fn reference_map(&self, directions: &Matrix<FMA>) -> Matrix<FMA> {
        let mut w = [[Lanes::ZERO; 3]; 3];
        for a in 0..3 {
            for i in 0..3 {
                if linked::<S>(a, i) {
                    w[a][i] = directions[i][a];
                    for b in 0..3 {
                        if linked::<S>(a, b) && linked::<S>(b, i) {
                            w[a][i] = self.frame[a][b].mul_add(directions[i][b], w[a][i]);
                        }
                    }
                }
            }
        }
        w
    }

    /// Frame after a step: `P G` with the symmetric `G` of `G Ch G = exp(2 elastic)`. `Ch` has the given stretches; the elastic strain
    /// `elastic` has the same principal directions.
    #[inline(always)]
    pub(super) fn moved_frame(&self, stretches: &Stretches<FMA>, elastic: &[Lanes<FMA>; S]) -> Matrix<FMA> {
        let mut root = [Lanes::ZERO; 3];
        for i in 0..3 {
            root[i] = stretches.squares[i].sqrt();
        }
        let grown = |value: Lanes<FMA>| (value * 2.0).exp_m1() + 1.0;
        let inner = function::<FMA, S>(elastic, grown);
        let mut product = [Lanes::ZERO; S];
        for (row, &(i, j)) in mandel_pairs::<S>().iter().enumerate() {
            product[row] = inner[row] * root[i] * root[j];
        }
        let middle = matrix(&function::<FMA, S>(&product, Lanes::sqrt));
        // `G - I` in the principal directions, then rotated back.
        let mut turned = [Lanes::ZERO; S];
        for (row, &(i, j)) in mandel_pairs::<S>().iter().enumerate() {
            let entry = middle[i][j] / (root[i] * root[j]);
            turned[row] = (if i == j { entry + -1.0 } else { entry }) * (1.0 / mandel_scale(i, j));
        }
        let mut back = [[Lanes::ZERO; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                back[i][j] = stretches.directions[j][i];
            }
        }
        let gain = matrix(&applied(&congruence::<FMA, S>(&back), &turned));
        let mut moved = self.frame;
        for i in 0..3 {
            for j in 0..3 {
                moved[i][j] = moved[i][j] + gain[i][j];
                for k in 0..3 {
                    if linked::<S>(i, k) && linked::<S>(k, j) {
                        moved[i][j] = self.frame[i][k].mul_add(gain[k][j], moved[i][j]);
                    }
                }
            }
        }
        moved
    }
}

/// Isotropic tensor function: applies `of` to the principal values of a symmetric tensor.
#[inline(always)]
fn function<const FMA: bool, const S: usize>(tensor: &[Lanes<FMA>; S], of: impl Fn(Lanes<FMA>) -> Lanes<FMA>) -> [Lanes<FMA>; S] {
    let PrincipalAxes { values, directions } = principal(tensor);
    let mut result = [Lanes::ZERO; S];
    for i in 0..3 {
        let value = of(values[i]);
        for j in 0..3 {
            for k in j..3 {
                if linked::<S>(j, k) {
                    let component = &mut result[place(j, k)];
                    *component = (value * directions[i][j] * directions[i][k]).mul_add(Lanes::splat(1.0 / mandel_scale(j, k)), *component);
                }
            }
        }
    }
    result
}
