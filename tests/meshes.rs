//! Mesh files of other programs: the one in the repository, and public contact tests if their folder is present.
//!
//! Expected numbers come from the geometry (closed forms for the mesh of the repository) and from the element lists of the files.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use conserva::elements::CellKind;
use conserva::mesh::{Boundary, Facet, Mesh, read_mesh, read_mesh_bytes};

#[path = "meshes/collapsed.rs"]
mod collapsed;
#[path = "common/mesh_damage.rs"]
mod mesh_damage;
#[path = "meshes/refusals.rs"]
mod refusals;
#[path = "meshes/small.rs"]
mod small;
#[path = "meshes/surfaces.rs"]
mod surfaces;

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Folder of meshes beside the repository, if present.
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
    // sufficient quality for a computation: no angle below 30 or above 150 degrees
    let quality = mesh.quality();
    assert!(quality.smallest_scaled_jacobian > 0.5, "{quality}");
}

#[test]
fn both_versions_of_the_punch_are_the_same_mesh() {
    let mesh = read_mesh(repository().join("scripts/meshes/punch.msh")).unwrap();
    let older = read_mesh(repository().join("tests/meshes/punch_22.msh")).unwrap();
    assert_eq!(mesh.points, older.points);
    assert_eq!(mesh.blocks, older.blocks);
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
            // all facets on the hull of one of the two bodies
            let counts = bodies.each_ref().map(|body| body.boundary(name).map_or(0, |b| b.facets.len()));
            assert!(counts.contains(&facets) && counts.contains(&0), "{file} {name}: {counts:?}");
            let body = &bodies[usize::from(counts[1] == facets)];
            let hull = body.hull();
            assert!(body.boundary(name).unwrap().facets.iter().all(|facet| hull.contains(facet)), "{file} {name}");
        }
    }
}

#[test]
fn damaged_files_are_read_or_refused() {
    let (originals, mut random) = (mesh_damage::originals(), mesh_damage::SplitMix(2026));
    let read = (0..4000).filter(|_| mesh_damage::judged(&mesh_damage::damaged(&originals, &mut random))).count();
    // damage to a byte of a comment or a coordinate is harmless; other damage is detected
    assert!((100..3000).contains(&read), "{read}");
}

/// Name for all facets that belong to a single cell, in a file without boundaries.
const HULL: &str = "hull";

/// File of another program with its content and with quantities that follow from the geometry.
struct Made {
    file: &'static str,
    kind: CellKind,
    cells: usize,
    /// Area or volume, and its tolerance.
    measure: (f64, f64),
    /// A boundary with its length or area, or [`HULL`].
    boundary: (&'static str, f64),
}

#[test]
fn files_of_other_programs_are_what_their_geometry_says() {
    use CellKind::{Hex8, Hex20, Hex27, Quad4, Quad8, Quad9, Tet4, Tet10, Tri3, Tri6, Wedge6};
    let made = |file, kind, cells, measure, boundary| Made { file, kind, cells, measure, boundary };
    // a plate 2 x 1 with a hole of radius 0.3, a quarter of a ring of radii 1 and 2, a box 2 x 1 x 1; chords replace the circles, and the
    // areas were summed by another program (shoelace formula over the cells)
    let (plate, ring) = (2.0 - PI * 0.09, 0.75 * PI);
    // sums of a hundred terms of numbers that were written with 16 digits
    let written = 1e-12;
    for Made { file, kind, cells, measure: (measure, tolerance), boundary: (name, extent) } in [
        made("plate_tri3_41_binary.msh", Tri3, 84, (1.7454415587728431, written), ("left", 1.0)),
        made("plate_tri3_22.msh", Tri3, 88, (1.7454415587728431, written), ("hole", 0.6 * PI)),
        made("plate_quad4_partitioned_41.msh", Quad4, 112, (1.7244679286971352, written), ("hole", 0.6 * PI)),
        made("plate_tri3_meshio_22.msh", Tri3, 88, (1.7454415587728431, written), ("left", 1.0)),
        made("plate_tri3.inp", Tri3, 84, (1.7454415587728334, written), ("hole", 0.6 * PI)),
        made("plate_tri6_22_binary.msh", Tri6, 88, (plate, 1e-3), ("hole", 0.6 * PI)),
        made("plate_tri6_41.msh", Tri6, 88, (plate, 1e-3), ("top", 2.0)),
        made("plate_quad4_22_binary.msh", Quad4, 112, (1.7244679286971352, written), ("right", 1.0)),
        made("plate_quad4.inp", Quad4, 112, (1.7244679286971256, written), ("hole", 0.6 * PI)),
        made("ring_quad4_41.msh", Quad4, 32, (2.3410838641935414, written), ("outer", PI)),
        made("ring_quad4_41_parametric.msh", Quad4, 32, (2.3410838641935414, written), ("inner", 0.5 * PI)),
        made("ring_quad8_41.msh", Quad8, 32, (ring, 1e-4), ("outer", PI)),
        made("ring_quad8_meshio_binary.msh", Quad8, 32, (ring, 1e-4), ("start", 1.0)),
        made("ring_quad8.inp", Quad8, 32, (ring, 1e-4), ("outer", PI)),
        made("ring_quad9_22.msh", Quad9, 32, (ring, 1e-4), ("end", 1.0)),
        made("ring_quad9_41_binary.msh", Quad9, 32, (ring, 1e-4), ("inner", 0.5 * PI)),
        made("ring_tri6.inp", Tri6, 64, (ring, 1e-4), ("inner", 0.5 * PI)),
        made("box_tet4_41_binary.msh", Tet4, 144, (2.0, written), ("left", 1.0)),
        made("box_tet4.inp", Tet4, 144, (2.0, written), ("front", 2.0)),
        made("box_hex8_22_binary.msh", Hex8, 8, (2.0, written), ("front", 2.0)),
        made("box_prism6.msh", Wedge6, 12, (2.0, written), ("back", 2.0)),
        made("box_hex8.inp", Hex8, 8, (2.0, written), ("left", 1.0)),
        // a quarter of a tube of height 1
        made("box_tet10_41.msh", Tet10, 144, (2.0, written), ("left", 1.0)),
        made("tube_tet10.inp", Tet10, 54, (ring, 1e-3), ("outer", PI)),
        made("tube_hex20_41_binary.msh", Hex20, 8, (ring, 1e-3), ("inner", 0.5 * PI)),
        made("tube_hex20.inp", Hex20, 8, (ring, 1e-3), ("top", 0.75 * PI)),
        made("tube_hex27_22.msh", Hex27, 8, (ring, 1e-3), ("outer", PI)),
        made("tube_hex27.inp", Hex27, 8, (ring, 1e-3), ("bottom", 0.75 * PI)),
        // meshio writes no sets: the boundary is the whole edge or surface of the body
        made("plate_quad4_meshio.inp", Quad4, 112, (1.7244679286971352, written), (HULL, 6.0 + 0.6 * PI)),
        made("box_hex8_meshio.inp", Hex8, 8, (2.0, written), (HULL, 10.0)),
    ] {
        let path = repository().join("tests/meshes/made").join(file);
        let mesh = read_mesh(path).unwrap_or_else(|error| panic!("{file}: {error} ({:?})", error.place()));
        assert_eq!((mesh.only_kind(), mesh.cell_count()), (Some(kind), cells), "{file}");
        assert_eq!(mesh.defects(), [], "{file}");
        assert!((mesh.measure() - measure).abs() < tolerance, "{file}: {} for {measure}", mesh.measure());
        let found = if name == HULL {
            assert_eq!((boundary_names(&mesh), part_names(&mesh)), (Vec::new(), Vec::new()), "{file}");
            mesh.boundary_measure(&Boundary { name: HULL.into(), facets: mesh.hull(), nodes: Vec::new() })
        } else {
            length(&mesh, name)
        };
        assert!((found - extent).abs() < 0.03 * extent, "{file} {name}: {found}");
        let text = mesh.to_gmsh();
        let back = read_mesh_bytes(text.as_bytes()).unwrap_or_else(|error| panic!("{file}: {error}"));
        assert_eq!((&back.points, &back.blocks, &back.parts), (&mesh.points, &mesh.blocks, &mesh.parts), "{file}");
        assert_eq!(back.boundaries.len(), mesh.boundaries.len(), "{file}");
    }
}

#[test]
fn files_of_several_kinds_of_cells_are_read_block_by_block() {
    // Areas and volumes from the geometry, with chords of the hole for cells of first order (its 8 sides summed by hand).
    let hole = 2.0 - PI * 0.09;
    for (file, kinds, measure, tolerance, boundary) in [
        ("plate_mixed.msh", "16 tri3 and 76 quad4 cells", hole, 1.5e-2, ("hole", 0.6 * PI)),
        ("plate_hex8_wedge6_22.msh", "94 hex8 and 14 wedge6 cells", 0.5 * hole, 1.5e-2, ("top", hole)),
        ("plate_hex20_wedge15_41_binary.msh", "94 hex20 and 14 wedge15 cells", 0.5 * hole, 1e-3, ("top", hole)),
        ("plate_hex20_wedge15.inp", "94 hex20 and 14 wedge15 cells", 0.5 * hole, 1e-3, ("top", hole)),
        ("box_pyr5_41.msh", "370 tet4 and 8 hex8 and 4 pyr5 cells", 2.0, 1e-12, ("front", 2.0)),
        ("box_pyr5.inp", "370 tet4 and 8 hex8 and 4 pyr5 cells", 2.0, 1e-12, ("right", 1.0)),
        ("box_pyr13_41_binary.msh", "370 tet10 and 8 hex20 and 4 pyr13 cells", 2.0, 1e-12, ("front", 2.0)),
    ] {
        let path = repository().join("tests/meshes/made").join(file);
        let mesh = read_mesh(path).unwrap_or_else(|error| panic!("{file}: {error} ({:?})", error.place()));
        assert_eq!((mesh.counted_cells().as_str(), mesh.defects()), (kinds, Vec::new()), "{file}");
        assert!((mesh.measure() - measure).abs() < tolerance * measure, "{file}: {} for {measure}", mesh.measure());
        let found = length(&mesh, boundary.0);
        assert!((found - boundary.1).abs() < 0.03 * boundary.1, "{file} {}: {found}", boundary.0);
        let back = read_mesh_bytes(mesh.to_gmsh().as_bytes()).unwrap_or_else(|error| panic!("{file}: {error}"));
        assert_eq!((&back.points, &back.blocks, &back.parts), (&mesh.points, &mesh.blocks, &mesh.parts), "{file}");
        let areas = |mesh: &Mesh| mesh.boundaries.iter().map(|of| (of.name.clone(), mesh.boundary_measure(of))).collect::<Vec<_>>();
        for ((name, before), (same, after)) in areas(&mesh).into_iter().zip(areas(&back)) {
            assert!(name == same && (before - after).abs() < 1e-12, "{file} {name}: {before} {after}");
        }
    }
}

#[test]
fn files_of_further_formats_are_what_their_geometry_says() {
    use CellKind::{Hex20, Tet4, Tet10, Wedge6, Wedge15};
    // a box 2 x 1 x 1 with the side at x = 0 as boundary, under the name or number that the format has for it
    let of_vtk = "gmsh:physical 7";
    for (file, kind, cells, boundary) in [
        ("box_tet10.unv", Tet10, 24, "left"),
        ("box_wedge15.unv", Wedge15, 8, "left"),
        ("box_hex20.unv", Hex20, 1, "left"),
        ("box_tet10.bdf", Tet10, 24, "1"),
        ("box_wedge15.bdf", Wedge15, 8, "5"),
        ("box_hex20.bdf", Hex20, 1, "1"),
        ("box_tet10.vtk", Tet10, 24, "CellEntityIds 7"),
        ("box_wedge15.vtk", Wedge15, 8, "CellEntityIds 7"),
        ("box_hex20.vtk", Hex20, 1, "CellEntityIds 7"),
        ("box_wedge6.vtk", Wedge6, 8, "CellEntityIds 7"),
        ("box_tet4.mesh", Tet4, 24, "1"),
        ("box_wedge6_meshio.mesh", Wedge6, 8, "7"),
        ("box_tet4.su2", Tet4, 24, "left"),
        ("box_wedge6.su2", Wedge6, 8, "left"),
        ("box_hex20_meshio_ascii.vtu", Hex20, 1, of_vtk),
        ("box_hex20_meshio_zlib.vtu", Hex20, 1, of_vtk),
        ("box_hex20_meshio_plain.vtu", Hex20, 1, of_vtk),
        ("box_hex20_meshio_42.vtk", Hex20, 1, of_vtk),
        ("box_hex20_meshio_51.vtk", Hex20, 1, of_vtk),
        ("box_hex20_vtk_ascii_none_0.vtu", Hex20, 1, of_vtk),
        ("box_hex20_vtk_binary_none_0.vtu", Hex20, 1, of_vtk),
        ("box_hex20_vtk_binary_zlib_0.vtu", Hex20, 1, of_vtk),
        ("box_hex20_vtk_appended_none_0.vtu", Hex20, 1, of_vtk),
        ("box_hex20_vtk_appended_none_1.vtu", Hex20, 1, of_vtk),
        ("box_hex20_vtk_appended_zlib_0.vtu", Hex20, 1, of_vtk),
        ("box_hex20_vtk_appended_zlib_1.vtu", Hex20, 1, of_vtk),
        ("box_hex20_vtk_legacy_42_1.vtk", Hex20, 1, of_vtk),
        ("box_hex20_vtk_legacy_42_2.vtk", Hex20, 1, of_vtk),
        ("box_hex20_vtk_legacy_51_1.vtk", Hex20, 1, of_vtk),
        ("box_hex20_vtk_legacy_51_2.vtk", Hex20, 1, of_vtk),
    ] {
        let path = repository().join("tests/meshes/made").join(file);
        let mesh = read_mesh(path).unwrap_or_else(|error| panic!("{file}: {error} ({:?})", error.place()));
        assert_eq!((mesh.only_kind(), mesh.cell_count(), mesh.defects()), (Some(kind), cells, Vec::new()), "{file}");
        // files of Nastran and VTK have six digits
        assert!((mesh.measure() - 2.0).abs() < 1e-5, "{file}: {}", mesh.measure());
        assert!(mesh.boundary(boundary).is_some(), "{file}: {:?}", boundary_names(&mesh));
        assert!((length(&mesh, boundary) - 1.0).abs() < 1e-5, "{file}: {}", length(&mesh, boundary));
    }
}

#[test]
fn files_that_cannot_be_used_are_refused_with_place_and_cure() {
    let refusal = |file: &str, line: usize, text: &str, hint: &str| {
        let error = read_mesh(repository().join("tests/meshes/refused").join(file)).expect_err(file);
        assert_eq!((error.line(), error.to_string()), (Some(line), text.to_string()), "{file}");
        assert!(error.hint().contains(hint), "{file}: {}", error.hint());
    };
    let orders = "the file mixes cells of first and of second order: 2 quad4 and 1 tri6; the first tri6 is element 3";
    refusal("two_orders.msh", 21, orders, "`Mesh.ElementOrder = 1;`");
    let unmatched = "cell 1 at (0.5, 0.5, 0.5) does not match its neighbor: a facet of hex8 and one of tet4 have different nodes";
    refusal("hexahedron_on_tetrahedra.msh", 18, unmatched, "a layer of pyramids");
    let path = repository().join("tests/meshes/refused/plate_tri6_inverted.msh");
    let inverted = read_mesh(path).expect_err("cells inside out");
    assert_eq!(inverted.offset(), Some(5375));
    assert!(inverted.to_string().contains("is inside out") && inverted.to_string().ends_with("(34 of 56 cells are)"), "{inverted}");
}

#[test]
fn files_of_other_programs_run() {
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_conserva"))
        .args(["test", "tests/meshes/run.rhai"])
        .current_dir(repository())
        .output()
        .unwrap_or_else(|error| panic!("{error}"));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
}
