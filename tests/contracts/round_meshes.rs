//! Tests of solids and sweeps: closed forms of volume and area, and validity of the meshes.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use conserva::elements::CellKind;
use conserva::mesh::*;

/// Round-off of sums of some thousand terms.
const ROUND_OFF: f64 = 1e-12;

fn relative(value: f64, exact: f64) -> f64 {
    (value - exact).abs() / exact.abs()
}

fn area(mesh: &Mesh, names: &[&str]) -> f64 {
    names.iter().map(|name| mesh.boundary_measure(mesh.boundary(name).unwrap_or_else(|| panic!("no boundary {name}")))).sum()
}

/// Asserts that a mesh has no defects and no coincident nodes, that the boundaries cover the hull with each facet once, and that all cells
/// have at least this quality.
fn assert_sound(what: &str, mesh: &Mesh, names: &[&str], least: f64) {
    assert_eq!(mesh.defects(), [], "{what}");
    assert_eq!(mesh.boundaries.iter().map(|b| b.name.as_str()).collect::<Vec<_>>(), names, "{what}");
    let mut named: Vec<Facet> = mesh.boundaries.iter().flat_map(|b| b.facets.clone()).collect();
    named.sort_unstable();
    assert_eq!(mesh.hull(), named, "{what}");
    let shortest = mesh.quality().shortest_edge;
    let mut sorted = mesh.points.clone();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]));
    for (index, a) in sorted.iter().enumerate() {
        let near = sorted[index + 1..].iter().take_while(|b| b[0] - a[0] < 0.01 * shortest);
        assert!(near.clone().all(|b| (a[1] - b[1]).hypot(a[2] - b[2]) > 0.01 * shortest), "{what}: two nodes at {a:?}");
    }
    let worst = mesh.quality().smallest_scaled_jacobian;
    assert!(worst > least, "{what}: {worst}");
}

#[test]
fn round_solids_have_their_volume_and_area_to_second_order() {
    let (a, b, h, ring) = (0.5, 1.25, 2.0, 3.0);
    let at = [0.3, -1.0, 2.0];
    type Maker<'a> = &'a dyn Fn(usize) -> Mesh;
    // Name, generator, volume, area, names of all boundaries, and least scaled Jacobian.
    type Solid<'a> = (&'a str, Maker<'a>, f64, f64, &'a [&'a str], f64);
    let solids: [Solid; 5] = [
        (
            "tube",
            &|n| tube([a, b], h, [2 * n, 12 * n, 3 * n], at, [2.0, 0.5]).unwrap(),
            PI * (b * b - a * a) * h,
            TAU * (a + b) * h + TAU * (b * b - a * a),
            &["inner", "outer", "bottom", "top"],
            0.9,
        ),
        (
            "cylinder",
            &|n| cylinder(b, h, [n, 8 * n, 2 * n], at, 3.0).unwrap(),
            PI * b * b * h,
            TAU * b * (h + b),
            &["outer", "bottom", "top"],
            0.5,
        ),
        (
            "torus",
            &|n| torus(ring, b, [n, 8 * n, 16 * n], at).unwrap(),
            2.0 * PI * PI * ring * b * b,
            4.0 * PI * PI * ring * b,
            &["outer"],
            0.35,
        ),
        ("sphere", &|n| sphere(b, [n, 8 * n], at, 0.5).unwrap(), 4.0 / 3.0 * PI * b.powi(3), 4.0 * PI * b * b, &["outer"], 0.6),
        (
            "hollow sphere",
            &|n| hollow_sphere([a, b], [2 * n, 8 * n], at, 2.0).unwrap(),
            4.0 / 3.0 * PI * (b.powi(3) - a.powi(3)),
            4.0 * PI * (a * a + b * b),
            &["inner", "outer"],
            0.6,
        ),
    ];
    for (name, make, volume, surface, boundaries, least) in solids {
        let errors = [2, 4].map(|n| {
            let mesh = make(n);
            assert_sound(name, &mesh, boundaries, least);
            [relative(mesh.measure(), volume), relative(area(&mesh, boundaries), surface)]
        });
        for (which, (coarse, fine)) in ["volume", "area"].into_iter().zip(errors[0].into_iter().zip(errors[1])) {
            assert!(((coarse / fine).log2() - 2.0).abs() < 0.15, "{name}, {which}: {coarse}, {fine}");
        }
    }
}

#[test]
fn nodes_are_on_the_true_surface() {
    let at = [0.3, -1.0, 2.0];
    let arm = |mesh: &Mesh, node: u32| [0, 1, 2].map(|i| mesh.points[node as usize][i] - at[i]);
    let is_on = |mesh: &Mesh, boundary: &str, distance: &dyn Fn([f64; 3]) -> f64| {
        let nodes = mesh.boundary_nodes(mesh.boundary(boundary).unwrap());
        assert!(nodes.iter().all(|&node| distance(arm(mesh, node)).abs() < 1e-14), "{boundary}");
    };
    let from_axis = |[x, y, _]: [f64; 3]| x.hypot(y);
    let from_center = |[x, y, z]: [f64; 3]| x.hypot(y).hypot(z);
    is_on(&cylinder(1.25, 2.0, [2, 16, 3], at, 1.0).unwrap(), "outer", &|p| from_axis(p) - 1.25);
    is_on(&tube([0.5, 1.25], 2.0, [2, 16, 3], at, [1.0; 2]).unwrap(), "inner", &|p| from_axis(p) - 0.5);
    is_on(&torus(3.0, 1.25, [2, 16, 32], at).unwrap(), "outer", &|p| (from_axis(p) - 3.0).hypot(p[2]) - 1.25);
    is_on(&sphere(1.25, [2, 20], at, 1.0).unwrap(), "outer", &|p| from_center(p) - 1.25);
    let shell = hollow_sphere([0.5, 1.25], [2, 12], at, 1.0).unwrap();
    is_on(&shell, "inner", &|p| from_center(p) - 0.5);
    is_on(&shell, "outer", &|p| from_center(p) - 1.25);
    assert_eq!(sphere(1.0, [2, 12], [0.0; 3], 1.0).unwrap().cell_count(), 27 + 2 * 6 * 9);
    assert_eq!(shell.cell_count(), 2 * 6 * 9);
    // Sphere with the smallest admissible number of cells.
    assert_sound("least sphere", &sphere(1.0, [1, 4], [0.0; 3], 1.0).unwrap(), &["outer"], 0.4);
}

#[test]
fn a_rounded_block_is_a_block_and_a_sphere_rolled_over_it() {
    let (size, r, origin) = ([3.0, 2.0, 1.0], 0.3, [1.0, 2.0, -1.0]);
    let [a, b, c] = size.map(|length| length - 2.0 * r);
    // Steiner's formula (1840) for the volume of a box `a b c` widened by the distance `r`.
    let volume = a * b * c + 2.0 * (a * b + b * c + c * a) * r + PI * (a + b + c) * r * r + 4.0 / 3.0 * PI * r.powi(3);
    let round = TAU * (a + b + c) * r + 4.0 * PI * r * r;
    let names = ["left", "right", "bottom", "top", "back", "front", "edges"];
    let errors = [1, 2, 4].map(|n| {
        let mesh = rounded_block(size, r, [4 * n, 3 * n, 2 * n], [n, 4 * n], origin).unwrap();
        assert_sound("rounded block", &mesh, &names, 0.55);
        for (index, flat) in [b * c, b * c, a * c, a * c, a * b, a * b].into_iter().enumerate() {
            let boundary = &mesh.boundaries[index];
            assert!(relative(mesh.boundary_measure(boundary), flat) < ROUND_OFF, "{}", boundary.name);
            let (axis, value) = (index / 2, origin[index / 2] + if index % 2 == 0 { 0.0 } else { size[index / 2] });
            assert!(mesh.boundary_nodes(boundary).iter().all(|&n| (mesh.points[n as usize][axis] - value).abs() < 1e-14));
        }
        [relative(mesh.measure(), volume), relative(area(&mesh, &["edges"]), round)]
    });
    for k in 0..2 {
        assert!((errors[1][k] / errors[2][k]).log2() > 1.85, "{errors:?}");
    }
    let nodes = rounded_block(size, r, [1; 3], [1, 2], [0.0; 3]).unwrap();
    for node in nodes.boundary_nodes(nodes.boundary("edges").unwrap()) {
        let out = [0, 1, 2].map(|i| nodes.points[node as usize][i] - nodes.points[node as usize][i].clamp(r, size[i] - r));
        assert!((out[0].hypot(out[1]).hypot(out[2]) - r).abs() < 1e-14);
    }
}

#[test]
fn what_cannot_be_a_solid_is_refused() {
    let text = |result: Result<Mesh, MeshError>| result.unwrap_err().to_string();
    assert_eq!(
        text(rounded_block([3.0, 2.0, 1.0], 0.5, [1; 3], [1, 2], [0.0; 3])),
        "the radius 0.5 of the edges must be smaller than half the least size 1"
    );
    assert!(matches!(rounded_block([1.0; 3], 0.2, [1; 3], [1, 3], [0.0; 3]), Err(MeshError::NotMultiple { of: 2, .. })));
    assert!(matches!(sphere(1.0, [1, 6], [0.0; 3], 1.0), Err(MeshError::NotMultiple { of: 4, .. })));
    assert!(matches!(sphere(1.0, [0, 8], [0.0; 3], 1.0), Err(MeshError::TooFewCells { .. })));
    assert!(matches!(sphere(1.0, [usize::MAX, 8], [0.0; 3], 1.0), Err(MeshError::TooManyCells { .. })));
    assert!(matches!(sphere(f64::NAN, [1, 8], [0.0; 3], 1.0), Err(MeshError::NotPositive { .. })));
    assert!(matches!(sphere(1.0, [1, 8], [f64::INFINITY, 0.0, 0.0], 1.0), Err(MeshError::NotFinite { .. })));
    assert!(matches!(hollow_sphere([1.0, 0.5], [1, 8], [0.0; 3], 1.0), Err(MeshError::Radii { .. })));
    assert!(matches!(torus(1.0, 1.0, [1, 8, 12], [0.0; 3]), Err(MeshError::OnAxis { .. })));
    assert!(matches!(tube([0.5, 1.0], 0.0, [1, 8, 1], [0.0; 3], [1.0; 2]), Err(MeshError::NotPositive { .. })));
}

#[test]
fn a_section_that_is_scaled_and_twisted_keeps_what_it_should() {
    let plate = rectangle([2.0, 1.0], [4, 3], [-1.0, -0.5]).unwrap();
    // a frustum, whose sides are flat: h/3 (A + B + sqrt(A B))
    let frustum = plate.extruded(3.0, 5, 2.0, Change { scale: [0.5; 2], ..Change::NONE }).unwrap();
    assert!(relative(frustum.measure(), 2.0 + 0.5 + 1.0) < ROUND_OFF);
    let errors = [8, 16].map(|layers| {
        let twisted = plate.extruded(3.0, layers, 1.0, Change { twist: 1.0, ..Change::NONE }).unwrap();
        assert_sound("twisted", &twisted, &["left", "right", "bottom", "top", "bottom_", "top_"], 0.8);
        relative(twisted.measure(), 6.0)
    });
    assert!(((errors[0] / errors[1]).log2() - 2.0).abs() < 0.1, "{errors:?}");
    let corner = plate.extruded(3.0, 2, 1.0, Change { twist: FRAC_PI_2, scale: [2.0, 1.0], ..Change::NONE }).unwrap().points[40];
    assert!((corner[0] - 0.5).abs() < 1e-14 && (corner[1] + 2.0).abs() < 1e-14 && corner[2] == 3.0, "{corner:?}");
    let half_turn = Change { twist: -PI, ..Change::NONE };
    assert!(matches!(plate.extruded(3.0, 1, 1.0, half_turn), Err(MeshError::TooFewCells { least: 2, .. })));
    assert_eq!(plate.extruded(3.0, 2, 1.0, half_turn).unwrap().defects(), []);
    assert!(matches!(plate.extruded(3.0, 1, 1.0, Change { scale: [0.0, 1.0], ..Change::NONE }), Err(MeshError::NotPositive { .. })));
    assert!(matches!(plate.extruded(3.0, 1, 1.0, Change { twist: f64::NAN, ..Change::NONE }), Err(MeshError::NotFinite { .. })));
}

#[test]
fn a_loft_goes_from_one_section_to_the_other() {
    let square = rectangle([2.0, 2.0], [6, 6], [-1.0, -1.0]).unwrap();
    let round =
        square.clone().mapped(|[x, y, z]| Ok::<_, ()>([x * (1.0 - 0.5 * y * y).sqrt(), y * (1.0 - 0.5 * x * x).sqrt(), z])).unwrap();
    let loft = square.lofted(&round, 3.0, 4, 1.0, Prisms::Cut).unwrap();
    assert_sound("loft", &loft, &["left", "right", "bottom", "top", "bottom_", "top_"], 0.1);
    assert!(relative(area(&loft, &["top_"]), round.measure()) < ROUND_OFF && relative(area(&loft, &["bottom_"]), 4.0) < ROUND_OFF);
    // areas of sections between two plane meshes are quadratic in the height (J. Simpson)
    let middle = square.clone().mapped(|p| {
        let q = round.points[square.points.iter().position(|other| *other == p).unwrap()];
        Ok::<_, ()>([0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1]), 0.0])
    });
    let exact = 3.0 / 6.0 * (4.0 + 4.0 * middle.unwrap().measure() + round.measure());
    assert!(relative(loft.measure(), exact) < ROUND_OFF);
    let other = rectangle([2.0, 2.0], [6, 5], [-1.0, -1.0]).unwrap();
    let error = square.lofted(&other, 3.0, 4, 1.0, Prisms::Cut).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the cells of the two meshes do not name the same nodes: 36 quad4 cells and 49 nodes, and 30 quad4 cells and 42 nodes"
    );
}

#[test]
fn a_mesh_turned_about_an_axis_has_the_volume_of_pappus() {
    let plate = rectangle([1.0, 2.0], [2, 3], [2.0, 0.5]).unwrap();
    let names = ["left", "right", "bottom", "top"];
    for kind in [CellKind::Quad4, CellKind::Tri3] {
        let section = plate.with_cells(kind).unwrap();
        let least = if kind == CellKind::Quad4 { 0.9 } else { 0.05 };
        let hoop = section.revolved(TAU, 40, Axis::Y, 1.0, Prisms::Cut).unwrap();
        assert_sound("hoop", &hoop, &names, least);
        // 40 chords: the area of the polygon over that of the circle
        let chords = 20.0 * (TAU / 40.0).sin() / PI;
        assert!(relative(hoop.measure(), chords * TAU * 2.5 * 2.0) < ROUND_OFF);
        assert!((relative(area(&hoop, &["right"]), TAU * 3.0 * 2.0)) < 2e-3);
        for angle in [1.0, -1.0] {
            for (center, axis) in [([0.0, 0.0], [0.0, 2.0]), ([5.0, 1.0], [0.0, 1.0]), ([0.0, -2.0], [1.0, 0.0]), ([9.0, 0.0], [1.0, -1.0])]
            {
                let bend = section.revolved(angle, 12, Axis { center, along: axis }, 2.0, Prisms::Cut).unwrap();
                assert_sound("bend", &bend, &["left", "right", "bottom", "top", "start", "end"], least);
                let length: f64 = f64::hypot(axis[0], axis[1]);
                let reach = ((2.5 - center[0]) * axis[1] - (1.5 - center[1]) * axis[0]).abs() / length;
                assert!(relative(bend.measure(), reach * 2.0) < 2e-3, "{axis:?}");
                assert!(relative(area(&bend, &["end"]), 2.0) < ROUND_OFF);
                let start = bend.boundary_nodes(bend.boundary("start").unwrap());
                assert!(start.iter().all(|&node| bend.points[node as usize][2] == 0.0));
            }
        }
    }
    // by the right-hand rule about y: from x to -z
    let quarter = plate.revolved(FRAC_PI_2, 3, Axis::Y, 1.0, Prisms::Cut).unwrap();
    let last = quarter.points[3 * plate.points.len()];
    assert!(last[0].abs() < 1e-15 && last[1] == 0.5 && last[2] == -2.0, "{last:?}");
    assert!(matches!(plate.revolved(TAU, 2, Axis::Y, 1.0, Prisms::Cut), Err(MeshError::TooFewCells { least: 3, .. })));
    assert!(matches!(plate.revolved(7.0, 9, Axis::Y, 1.0, Prisms::Cut), Err(MeshError::Revolution { .. })));
    assert!(matches!(plate.revolved(0.0, 9, Axis::Y, 1.0, Prisms::Cut), Err(MeshError::Revolution { .. })));
    assert!(matches!(plate.revolved(1.0, 9, Axis { center: [0.0; 2], along: [0.0; 2] }, 1.0, Prisms::Cut), Err(MeshError::NoAxis { .. })));
    assert!(matches!(plate.revolved(TAU, 9, Axis::Y, 2.0, Prisms::Cut), Err(MeshError::ClosedChange)));
    for center in [2.0, 2.5, 3.0] {
        let error = plate.revolved(1.0, 9, Axis { center: [center, 0.0], along: [0.0, 1.0] }, 1.0, Prisms::Cut).unwrap_err();
        assert!(matches!(error, MeshError::OnAxis { .. }), "{error}");
    }
}

/// Points of a helix about z: radius, rise in each radian, turn and number of steps.
fn helix(radius: f64, rise: f64, turn: f64, steps: usize) -> Vec<[f64; 3]> {
    let at = |angle: f64| [radius * angle.cos(), radius * angle.sin(), rise * angle];
    (0..=steps).map(|k| at(turn * k as f64 / steps as f64)).collect()
}

#[test]
fn a_mesh_follows_a_path_across_it_and_without_turning() {
    let plate = rectangle([0.4, 0.2], [3, 2], [-0.2, -0.1]).unwrap();
    let names = ["left", "right", "bottom", "top", "bottom_", "top_"];
    // Extrusion along a straight path along z equals `extruded`.
    let straight: Vec<[f64; 3]> = (0..=4).map(|k| [0.0, 0.0, 0.5 * f64::from(k)]).collect();
    let [along, up] = [plate.extruded_along(&straight, Change::NONE), plate.extruded(2.0, 4, 1.0, Change::NONE)].map(Result::unwrap);
    assert_eq!((&along.blocks, &along.boundaries), (&up.blocks, &up.boundaries));
    assert!(along.points.iter().zip(&up.points).all(|(a, b)| (0..3).all(|i| (a[i] - b[i]).abs() < 1e-15)));
    // Straight paths downwards, along x, and oblique.
    for end in [[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [-1.0, 2.0, -0.5]] {
        let bar = plate.extruded_along(&[[0.0; 3], end], Change { twist: 0.1, ..Change::NONE }).unwrap();
        assert_sound("bar", &bar, &names, 0.5);
    }
    // a helix: its volume, and a frame that rotates relative to the normal by the torsion times the length (R. Bishop, 1975)
    let (radius, rise, turn) = (2.0, 0.5, 5.0);
    let speed = f64::hypot(radius, rise);
    let errors = [40, 80].map(|steps| {
        let path = helix(radius, rise, turn, steps);
        let spring = plate.extruded_along(&path, Change::NONE).unwrap();
        assert_sound("spring", &spring, &names, 0.9);
        // The first axis of a section, along its first row of four nodes.
        let first_axis = |k: usize, i: usize| {
            let start = k * plate.points.len();
            (spring.points[start + 3][i] - spring.points[start][i]) / 0.4
        };
        let angle = |k: usize| {
            let (sine, cosine) = (turn * k as f64 / steps as f64).sin_cos();
            let [normal, binormal] = [[-cosine, -sine, 0.0], [rise / speed * sine, -rise / speed * cosine, radius / speed]];
            let along = |v: [f64; 3]| (0..3).map(|i| first_axis(k, i) * v[i]).sum::<f64>();
            along(binormal).atan2(along(normal))
        };
        let turned = (angle(0) - angle(steps) - turn * rise / speed).rem_euclid(TAU);
        [relative(spring.measure(), 0.08 * turn * speed), turned.min(TAU - turned)]
    });
    for k in 0..2 {
        assert!((errors[0][k] / errors[1][k]).log2() > 1.8, "{errors:?}");
    }
}

#[test]
fn a_path_that_ends_at_its_start_closes() {
    let section = ring(0.1, 0.2, [1, 8], [0.0; 2], 0.1).unwrap();
    let circle = helix(1.5, 0.0, TAU, 24);
    let torus = section.extruded_along(&circle, Change::NONE).unwrap();
    assert_sound("circle", &torus, &["inner", "outer"], 0.7);
    // The torus as a solid of revolution.
    let turned = ring(0.1, 0.2, [1, 8], [1.5, 0.0], 0.1).unwrap().revolved(TAU, 24, Axis::Y, 1.0, Prisms::Cut).unwrap();
    assert!(relative(torus.measure(), turned.measure()) < ROUND_OFF);
    // Trefoil knot, a closed path: the angle by which its frame would not close is distributed over the length.
    let trefoil = |steps: usize| -> Vec<[f64; 3]> {
        let at = |t: f64| [t.sin() + 2.0 * (2.0 * t).sin(), t.cos() - 2.0 * (2.0 * t).cos(), -(3.0 * t).sin()];
        (0..=steps).map(|k| at(TAU * k as f64 / steps as f64)).collect()
    };
    let knot = section.extruded_along(&trefoil(120), Change::NONE).unwrap();
    assert_sound("knot", &knot, &["inner", "outer"], 0.7);
    assert_eq!(knot.cell_count(), 8 * 120);
    let change = Change { scale: [0.5; 2], ..Change::NONE };
    assert!(matches!(section.extruded_along(&circle, change), Err(MeshError::ClosedChange)));
}

#[test]
fn paths_that_cannot_be_followed_are_refused_where_they_fail() {
    let plate = rectangle([1.0, 1.0], [2, 2], [-0.5, -0.5]).unwrap();
    let error = |path: &[[f64; 3]]| plate.extruded_along(path, Change::NONE).unwrap_err();
    let [o, x, y] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    assert!(matches!(error(&[o]), MeshError::PathPoints { count: 1, least: 2 }));
    assert!(matches!(error(&[o, x, o]), MeshError::PathPoints { count: 3, least: 4 }));
    assert!(matches!(error(&[o, [f64::NAN, 0.0, 0.0]]), MeshError::NotFinite { .. }));
    assert_eq!(error(&[o, x, x, y]).to_string(), "the points 2 and 3 of the path are at the same place, (1, 0, 0)");
    assert_eq!(error(&[o, x, [0.5, 0.1, 0.0]]).to_string(), "the path turns by 169 degrees at its point 2, (1, 0, 0)");
    // a bend of the radius 0.3, too sharp for a section of the half width 0.5
    let bend = helix(0.3, 0.0, PI, 12);
    assert!(matches!(error(&bend), MeshError::SweptOver { .. }));
    for refused in [error(&[o]), error(&[o, x, x]), error(&bend)] {
        assert!(!refused.hint().is_empty());
    }
}
