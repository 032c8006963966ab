//! Mesh files made by other programs: the one that is shipped, and public contact tests where their folder is present.
//!
//! Expected numbers come from the geometry (closed forms for the shipped mesh) and from the element lists of the files themselves.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use conserva::mesh::{Facet, Mesh, read_mesh, read_mesh_bytes};

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The folder of meshes beside the repository, if it is there.
fn shared_meshes() -> Option<PathBuf> {
    let folder = std::env::var_os("CONSERVA_SHARED").map_or_else(|| repository().join("../shared"), PathBuf::from).join("meshes");
    folder.is_dir().then_some(folder)
}

fn part_names(mesh: &Mesh) -> Vec<&str> {
    mesh.parts.iter().map(|(name, _)| name.as_str()).collect()
}

fn boundary_names(mesh: &Mesh) -> Vec<&str> {
    mesh.boundaries.iter().map(|boundary| boundary.name.as_str()).collect()
}

fn length(mesh: &Mesh, boundary: &str) -> f64 {
    mesh.boundary_measure(mesh.boundary(boundary).unwrap())
}

#[test]
fn the_shipped_punch_is_what_its_geometry_says() {
    let mesh = read_mesh(repository().join("scripts/meshes/punch.msh")).unwrap();
    assert_eq!(part_names(&mesh), ["punch", "block"]);
    assert_eq!(boundary_names(&mesh), ["round", "flat", "surface", "left", "right", "base"]);
    let (punch, block) = (mesh.part("punch").unwrap(), mesh.part("block").unwrap());
    assert_eq!(punch.cell_count() + block.cell_count(), mesh.cell_count());
    assert_eq!(boundary_names(&punch), ["round", "flat"]);
    assert_eq!(boundary_names(&block), ["surface", "left", "right", "base"]);
    // every boundary facet of each body has a name
    for body in [&punch, &block] {
        let mut named: Vec<Facet> = body.boundaries.iter().flat_map(|b| b.facets.clone()).collect();
        named.sort_unstable();
        assert_eq!(body.hull(), named);
    }
    // a polygon with 15 facets of 4 degrees and 12 of 10 in the half circle: areas of its triangles and lengths of its chords
    let triangles = 15.0 * 4f64.to_radians().sin() / 2.0 + 12.0 * 10f64.to_radians().sin() / 2.0;
    let chords = 15.0 * 2.0 * 2f64.to_radians().sin() + 12.0 * 2.0 * 5f64.to_radians().sin();
    // Gmsh places nodes on curves to about 1e-11
    let placed = 1e-10;
    assert!((punch.measure() - triangles).abs() < placed && (punch.measure() - PI / 2.0).abs() < 0.01);
    assert!((length(&mesh, "round") - chords).abs() < placed);
    assert!((length(&mesh, "flat") - 2.0).abs() < placed);
    assert!((block.measure() - 6.0).abs() < placed);
    assert!((length(&mesh, "surface") - 4.0).abs() < placed && (length(&mesh, "left") - 1.5).abs() < placed);
    for node in punch.boundary_nodes(punch.boundary("round").unwrap()) {
        let [x, y, _] = punch.points[node as usize];
        assert!((x.hypot(y - 1.01) - 1.0).abs() < placed);
    }
    // good enough to compute with: no angle below 30 or above 150 degrees
    let quality = mesh.quality();
    assert!(quality.smallest_scaled_jacobian > 0.5, "{quality}");
}

#[test]
fn both_versions_of_the_punch_are_the_same_mesh() {
    let mesh = read_mesh(repository().join("scripts/meshes/punch.msh")).unwrap();
    let older = read_mesh(repository().join("tests/meshes/punch_22.msh")).unwrap();
    assert_eq!(mesh.points, older.points);
    assert_eq!(mesh.connectivity, older.connectivity);
    assert_eq!(mesh.parts, older.parts);
    assert_eq!(mesh.boundaries, older.boundaries);
}

#[test]
fn a_shipped_mesh_cut_short_is_refused() {
    let text = std::fs::read_to_string(repository().join("scripts/meshes/punch.msh")).unwrap();
    for share in 1..50 {
        assert!(read_mesh_bytes(&text.as_bytes()[..text.len() * share / 50]).is_err());
    }
}

#[test]
fn public_contact_meshes_are_read() {
    let Some(folder) = shared_meshes() else {
        eprintln!("skipped: there is no folder of shared meshes beside the repository");
        return;
    };
    // cells and areas: sums over the element lists of the files (shoelace formula); slave and master facets: their line elements
    for (file, cells, area, slave, master) in [
        ("patch.msh", [50, 25], 80.0, 5, 10),
        ("hertz.msh", [1000, 256], 116.45783960331688, 20, 64),
        ("rings.msh", [400, 400], 251.16205625908128, 50, 50),
        ("slide.msh", [32, 31], 12.545084971874738, 10, 16),
    ] {
        let mesh = read_mesh(folder.join(file)).unwrap_or_else(|error| panic!("{file}: {error} (line {:?})", error.line()));
        assert_eq!(part_names(&mesh), ["body_1", "body_2"], "{file}");
        let bodies = ["body_1", "body_2"].map(|name| mesh.part(name).unwrap());
        assert_eq!(bodies.each_ref().map(Mesh::cell_count), cells, "{file}");
        // round-off of a thousand terms
        assert!((mesh.measure() - area).abs() < 1e-12 * area, "{file}: {}", mesh.measure());
        assert!((bodies[0].measure() + bodies[1].measure() - area).abs() < 1e-12 * area, "{file}");
        for (name, facets) in [("slave", slave), ("master", master)] {
            let boundary = mesh.boundary(name).unwrap_or_else(|| panic!("{file} has no boundary {name}"));
            assert_eq!(boundary.facets.len(), facets, "{file} {name}");
            // all of it on the hull of one of the two bodies
            let counts = bodies.each_ref().map(|body| body.boundary(name).map_or(0, |b| b.facets.len()));
            assert!(counts.contains(&facets) && counts.contains(&0), "{file} {name}: {counts:?}");
            let body = &bodies[usize::from(counts[1] == facets)];
            let hull = body.hull();
            assert!(body.boundary(name).unwrap().facets.iter().all(|facet| hull.contains(facet)), "{file} {name}");
        }
    }
}
