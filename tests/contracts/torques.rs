//! Contract of the forces of a torque: no resultant, the given moment about any point.

use conserva::bodies::torque_forces;
use nalgebra::Vector3;

#[test]
fn torque_has_no_resultant_and_its_moment_about_any_point() {
    let weights = [(0u32, 0.3), (1, 0.5), (2, 0.4), (3, 0.2)];
    let q = [1.0, 0.2, -0.3, 0.9, 2.0, -1.0, 0.4, 0.4];
    let mut force = [0.0; 8];
    torque_forces::<2>(&weights, &q, [0.0, 0.0, 2.5], &mut force);
    let (mut sum, mut moment) = ([0.0; 2], 0.0);
    for node in 0..4 {
        sum[0] += force[2 * node];
        sum[1] += force[2 * node + 1];
        moment += (q[2 * node] - 7.0) * force[2 * node + 1] - (q[2 * node + 1] + 3.0) * force[2 * node];
    }
    assert!(sum[0].abs() < 1e-15 && sum[1].abs() < 1e-15);
    assert!((moment - 2.5).abs() < 1e-14);
}

#[test]
fn torque_in_space_has_the_moment_that_was_asked_for_about_any_axis() {
    let weights = [(0u32, 0.3), (1, 0.5), (2, 0.4), (3, 0.2)];
    let q = [1.0, 0.2, 0.7, -0.3, 0.9, -1.1, 2.0, -1.0, 0.4, 0.4, 0.4, 0.1];
    let (moment, mut force) = ([0.3, -1.2, 2.5], [0.0; 12]);
    torque_forces::<3>(&weights, &q, moment, &mut force);
    let (mut sum, mut about) = (Vector3::zeros(), Vector3::zeros());
    for node in 0..4 {
        let [x, f] = [&q[..], &force[..]].map(|all| Vector3::from_column_slice(&all[3 * node..3 * node + 3]));
        sum += f;
        about += (x - Vector3::new(7.0, -3.0, 1.0)).cross(&f);
    }
    assert!(sum.norm() < 1e-14 && (about - Vector3::from(moment)).norm() < 1e-13, "{sum} {about}");
}
