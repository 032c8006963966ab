//! Constants of obstacles and friction laws.

/// Horizontal place, x and z, of the tops and tips of obstacles: away from nodes and planes of symmetry of the bodies, where round-off
/// would decide on which side a body slides off.
pub const TOP: [f64; 2] = [1.04, 0.53];

/// Constants of an obstacle at rest with its top at [`TOP`].
pub fn obstacle(name: &str) -> Option<&'static str> {
    Some(match name {
        "rigid_plane" => "point: [1.0, 0.0@], normal: [0.0, 1.0@]",
        "rigid_disk" => "center: [1.04, -0.5], radius: 0.5",
        "rigid_ring" => "center: [1.0, HIGH], radius: 1.5",
        "rigid_polyline" => "points: [[3.04, -0.2], [1.04, 0.0], [-0.96, -0.2]]",
        "rigid_sphere" => "center: [1.04, -0.5, 0.53], radius: 0.5",
        "rigid_cylinder" => "point: [1.04, -0.5, 0.53], axis: [0.0, 0.0, 1.0], radius: 0.5",
        "rigid_cone" => "tip: [1.04, 0.0, 0.53], axis: [0.0, -1.0, 0.0], half_angle: deg(70)",
        "rigid_torus" => "center: [1.04, -0.2, 0.53], axis: [0.0, 1.0, 0.0], radius: 0.3, tube_radius: 0.2",
        "rigid_box" => "size: [3.0, 0.5, 3.0], origin: [-0.5, -0.5, -1.0]",
        "rigid_surface" => "mesh: block(#{ size: [3.0, 0.5, 3.0], cells: [2, 1, 2], origin: [-0.5, -0.5, -1.0] })",
        _ => return None,
    })
}

/// A friction law with a coefficient.
pub fn friction_law(name: &str) -> Option<&'static str> {
    Some(match name {
        "coulomb" => "coulomb(#{ coefficient: MU, at_rest: 1.2, transition_speed: 0.01, viscosity: 0.1, most: 50.0 })",
        "friction_curve" => "friction_curve([[0.0, 1.5 * MU], [0.05, MU], [1.0, 0.9 * MU]])",
        "rough" => "rough()",
        _ => return None,
    })
}
