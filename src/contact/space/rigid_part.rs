//! Removal of the rigid motion that vectors at the nodes of a contact element contain, `P` of `slip.rs`, with its derivatives.
//!
//! With the arms `r_i` of the nodes about their mean point, the inertia `J = sum |r_i|^2 1 - r_i r_i^T` and the rotation
//! `omega(v) = J^-1 sum r_i x v_i`,
//!
//! ```text
//! (P v)_i = v_i - mean v - omega(v) x r_i
//! ```

use super::vectors::{Vec3, cross, dot, sub};
use super::vertices::{NODES, UNKNOWNS};

/// Rigid motions of the nodes of a contact element.
pub struct RigidPart {
    /// Positions relative to the mean point.
    arms: [Vec3<f64>; NODES],
    /// Number of nodes.
    count: usize,
    /// Inverse of the inertia of unit masses at the nodes; symmetric.
    inverse: [Vec3<f64>; 3],
}

fn mean(vectors: &[Vec3<f64>]) -> Vec3<f64> {
    let mut mean = [0.0; 3];
    vectors.iter().for_each(|x| (0..3).for_each(|i| mean[i] += x[i] * (1.0 / vectors.len() as f64)));
    mean
}

impl RigidPart {
    /// Rigid motions of nodes at the points `z`.
    pub fn new(z: &[Vec3<f64>]) -> Self {
        let (center, mut arms, mut inertia) = (mean(z), [[0.0; 3]; NODES], [[0.0; 3]; 3]);
        for (arm, z) in arms.iter_mut().zip(z) {
            *arm = sub(*z, center);
            let square = dot(*arm, *arm);
            for i in 0..3 {
                inertia[i][i] += square;
                (0..3).for_each(|j| inertia[i][j] -= arm[i] * arm[j]);
            }
        }
        let cofactors: [Vec3<f64>; 3] = std::array::from_fn(|i| cross(inertia[(i + 1) % 3], inertia[(i + 2) % 3]));
        let determinant = dot(inertia[0], cofactors[0]);
        RigidPart { arms, count: z.len(), inverse: cofactors.map(|row| row.map(|x| x / determinant)) }
    }

    /// Rotation `omega` of the rigid motion that vectors contain.
    #[inline(always)]
    fn rotation(&self, vectors: &[Vec3<f64>]) -> Vec3<f64> {
        let mut moment = [0.0; 3];
        for (arm, vector) in self.arms.iter().zip(vectors) {
            let turn = cross(*arm, *vector);
            for i in 0..3 {
                moment[i] += turn[i];
            }
        }
        [dot(self.inverse[0], moment), dot(self.inverse[1], moment), dot(self.inverse[2], moment)]
    }

    /// Removes the rigid motion that vectors contain.
    pub fn remove_from(&self, vectors: &mut [Vec3<f64>]) {
        let (shift, rotation) = (mean(vectors), self.rotation(vectors));
        vectors.iter_mut().zip(&self.arms).for_each(|(v, arm)| *v = sub(sub(*v, shift), cross(rotation, *arm)));
    }

    /// Derivatives of `sum (P row)_i . v_i` with respect to the positions of the nodes, for constant vectors `row`, whose sum is zero, and
    /// `v`.
    pub fn gradient(&self, row: &[Vec3<f64>], v: &[Vec3<f64>]) -> Vec<Vec3<f64>> {
        let (of_row, of_v) = (self.rotation(row), self.rotation(v));
        let product = 2.0 * dot(of_row, of_v);
        let at = |((arm, row), v): ((&Vec3<f64>, &Vec3<f64>), &Vec3<f64>)| -> Vec3<f64> {
            let (first, second) = (cross(*row, of_v), cross(*v, of_row));
            let (along_row, along_v) = (dot(*arm, of_row), dot(*arm, of_v));
            std::array::from_fn(|i| product * arm[i] - first[i] - second[i] - of_row[i] * along_v - of_v[i] * along_row)
        };
        let mut gradient: Vec<Vec3<f64>> = self.arms.iter().zip(row).zip(v).map(at).collect();
        let mean = mean(&gradient);
        gradient.iter_mut().for_each(|gradient| *gradient = sub(*gradient, mean));
        gradient
    }

    /// Turns the derivatives `slopes` of `vectors`, whose sum is zero, into those of the vectors without their rigid motion.
    #[inline(always)]
    pub fn remove_from_slopes(&self, vectors: &[Vec3<f64>], slopes: &mut [[[f64; UNKNOWNS]; 3]; NODES]) {
        let (rotation, share) = (self.rotation(vectors), 1.0 / self.count as f64);
        let (mut shift, mut moment) = ([[0.0; UNKNOWNS]; 3], [[0.0; UNKNOWNS]; 3]);
        for node in 0..self.count {
            let (arm, slopes) = (self.arms[node], &slopes[node]);
            for i in 0..3 {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                for lane in 0..UNKNOWNS {
                    shift[i][lane] += share * slopes[i][lane];
                    moment[i][lane] += arm[j] * slopes[k][lane] - arm[k] * slopes[j][lane];
                }
            }
        }
        // Derivatives of the moment less those of the inertia times the rotation, for a node that moves along `a`.
        for node in 0..self.count {
            let (arm, vector) = (self.arms[node], vectors[node]);
            let along = dot(arm, rotation);
            for a in 0..3 {
                let (lane, b, c) = (3 * node + a, (a + 1) % 3, (a + 2) % 3);
                moment[b][lane] -= vector[c];
                moment[c][lane] += vector[b];
                moment[a][lane] += along;
                for i in 0..3 {
                    moment[i][lane] += arm[i] * rotation[a] - 2.0 * arm[a] * rotation[i];
                }
            }
        }
        let mut turn = [[0.0; UNKNOWNS]; 3];
        for i in 0..3 {
            for j in 0..3 {
                for lane in 0..UNKNOWNS {
                    turn[i][lane] += self.inverse[i][j] * moment[j][lane];
                }
            }
        }
        for node in 0..self.count {
            let arm = self.arms[node];
            for i in 0..3 {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                for lane in 0..UNKNOWNS {
                    slopes[node][i][lane] -= shift[i][lane] + turn[j][lane] * arm[k] - turn[k][lane] * arm[j];
                }
            }
            for moved in 0..self.count {
                let part = if moved == node { 1.0 - share } else { -share };
                for a in 0..3 {
                    let (lane, b, c) = (3 * moved + a, (a + 1) % 3, (a + 2) % 3);
                    slopes[node][b][lane] -= part * rotation[c];
                    slopes[node][c][lane] += part * rotation[b];
                }
            }
        }
    }
}
