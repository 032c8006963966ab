//! Sums over nodal vectors with `D` components per node, node by node.

/// Kinetic energy `1/2 v.p` from velocities and nodal momenta.
pub fn half_product(v: &[f64], p: &[f64]) -> f64 {
    0.5 * v.iter().zip(p).map(|(v, p)| v * p).sum::<f64>()
}

/// Sum of nodal vectors.
pub fn resultant<const D: usize>(force: &[f64]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    force.chunks_exact(D).for_each(|f| add_force(&mut sum, f));
    sum
}

/// Sum of moments `q x f` about the origin.
pub fn moment<const D: usize>(q: &[f64], force: &[f64]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    q.chunks_exact(D).zip(force.chunks_exact(D)).for_each(|(q, f)| add_moment(&mut sum, q, f));
    sum
}

/// Adds a nodal vector.
#[inline(always)]
pub fn add_force(sum: &mut [f64; 3], f: &[f64]) {
    sum.iter_mut().zip(f).for_each(|(sum, f)| *sum += f);
}

/// Adds a moment `q x f`.
#[inline(always)]
pub fn add_moment(sum: &mut [f64; 3], q: &[f64], f: &[f64]) {
    sum[2] += q[0] * f[1] - q[1] * f[0];
    if q.len() == 3 {
        sum[0] += q[1] * f[2] - q[2] * f[1];
        sum[1] += q[2] * f[0] - q[0] * f[2];
    }
}
