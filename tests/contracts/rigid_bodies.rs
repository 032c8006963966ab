//! Contract of rigid bodies: inertia, coordinates by masters, the mass of tied nodes.

use conserva::bodies::{BarycentricMap, ElementLoop, Formulation, Inertia, RigidMass};
use conserva::linear::{NodeMatrix, Pattern, Vertex};
use conserva::materials::NeoHookean;
use conserva::mesh::{block, rectangle};
use nalgebra::Vector3;

#[test]
fn inertia_of_a_box_is_the_closed_form_and_masters_reproduce_it() {
    let steel = NeoHookean { youngs_modulus: 1.0, poisson_ratio: 0.3, density: 2.0 }.material().unwrap();
    let mesh = block([1.0, 2.0, 3.0], [2, 1, 2], [0.5, 0.0, 0.0]).unwrap();
    let inertia = Inertia::of_mesh(&mesh, &steel, Formulation::default()).unwrap();
    assert!((inertia.mass - 12.0).abs() < 1e-12);
    let expected = [5.0, 10.0, 13.0];
    assert!(inertia.principal_moments().iter().zip(expected).all(|(moment, expected)| (moment - expected).abs() < 1e-12));
    let frame = BarycentricMap::new(&mesh).unwrap();
    let masses = frame.masses(&inertia);
    let points: Vec<Vector3<f64>> = frame.masters.iter().map(|&node| mesh.points[node as usize].into()).collect();
    let (total, first) = masses
        .iter()
        .flatten()
        .zip((0..4).flat_map(|_| &points))
        .fold((0.0, Vector3::zeros()), |(m, s), (value, x)| (m + value, s + x * *value));
    assert!((total - 12.0).abs() < 1e-12 && (first / total - Vector3::from(inertia.center)).norm() < 1e-12);
    let again = Inertia::of_moments(12.0, inertia.center, [[13.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 5.0]]);
    assert!((0..3).all(|i| (again.euler[i][i] - inertia.euler[i][i]).abs() < 1e-12));
}

#[test]
fn every_node_is_a_combination_of_the_masters() {
    let mesh = rectangle([2.0, 1.0], [3, 2], [1.0, -4.0]).unwrap();
    let frame = BarycentricMap::new(&mesh).unwrap();
    for point in &mesh.points {
        let shares = frame.shares(*point);
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-14);
        let sum: Vector3<f64> =
            frame.masters.iter().zip(&shares).map(|(&node, share)| Vector3::from(mesh.points[node as usize]) * *share).sum();
        assert!((sum - Vector3::from(*point)).norm() < 1e-13);
    }
}

#[test]
fn tied_nodes_take_their_mass_from_the_masters() {
    let steel = NeoHookean { youngs_modulus: 1.0, poisson_ratio: 0.3, density: 2.0 }.material().unwrap();
    let mesh = rectangle([2.0, 1.0], [3, 2], [1.0, -4.0]).unwrap();
    let (frame, inertia) = (BarycentricMap::new(&mesh).unwrap(), Inertia::of_mesh(&mesh, &steel, Formulation::default()).unwrap());
    let others = (0..mesh.points.len() as u32).filter(|node| !frame.masters.contains(node));
    let tied: Vec<(u32, Vec<f64>)> = others.map(|node| (node, frame.shares(mesh.points[node as usize]))).collect();
    let speeds = [0.3, -1.2, 2.0];
    let pattern = Pattern::new(&vec![Vertex::coordinates(2); mesh.points.len()], [&frame.masters[..]].into_iter());
    // Kinetic energy of all nodes, those tied with the velocity of their masters.
    let energy = |body: RigidMass| -> f64 {
        let mut mass = NodeMatrix::new(&pattern, mesh.points.len());
        ElementLoop::<2>::add_mass(&body, &mut mass);
        let speed = |node: u32| frame.shares(mesh.points[node as usize]).iter().zip(speeds).map(|(share, v)| share * v).sum::<f64>();
        mass.entries().map(|(row, column, mass)| mass * speed(row) * speed(column)).sum()
    };
    let [alone, tied_to] = [RigidMass::new(&mesh, &frame, &inertia, 0), RigidMass::new(&mesh, &frame, &inertia, 0).tied_to(tied.iter())];
    assert!((energy(alone) - energy(tied_to)).abs() < 1e-12);
}
