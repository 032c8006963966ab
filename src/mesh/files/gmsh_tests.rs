//! Tests of the reader: two small meshes in both versions, all kinds of errors, and random damage.

use std::fmt::Write;

use proptest::prelude::*;
use proptest::sample::{Index, select};

use super::read::{read_mesh, read_mesh_bytes};
use crate::elements::CellKind;
use crate::mesh::file_error::FileProblem::*;
use crate::mesh::file_error::{FileError, FilePosition, FileProblem};
use crate::mesh::{Boundary, Facet, Mesh, MeshError, block};

/// Two unit squares side by side, named groups, a node and a point that no cell uses.
const SQUARES_2: &str = "$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
3
2 1 \"left body\"
1 7 \"low\"
0 9 \"a point\"
$EndPhysicalNames
$Nodes
7
1 0 0 0
2 1 0 0
3 2 0 0
14 0 1 0
15 1 1 0
16 2 1 0
99 5 5 0
$EndNodes
$Elements
7
1 15 2 9 1 99
2 1 2 7 1 2 1
3 1 2 7 1 2 3
4 1 2 8 2 15 2
5 1 2 0 3 1 14
6 3 2 1 1 1 2 15 14
7 3 2 2 2 2 3 16 15
$EndElements
";

/// Mesh of two squares in format version 4.1.
const SQUARES_4: &str = "$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
3
0 9 \"a point\"
1 7 \"low\"
2 1 \"left body\"
$EndPhysicalNames
$Entities
1 3 2 0
1 5 5 0 1 9
1 0 0 0 2 0 0 1 7 0
2 1 0 0 1 1 0 1 -8 2 1 -1
3 0 0 0 0 1 0 0 0
1 0 0 0 1 1 0 1 1 1 1
2 1 0 0 2 1 0 1 2 1 1
$EndEntities
$Nodes
3 7 1 99
0 1 0 1
99
5 5 0
1 1 1 3
1
2
3
0 0 0 0
1 0 0 0.5
2 0 0 1
2 1 0 3
14
15
16
0 1 0
1 1 0
2 1 0
$EndNodes
$Comments
anything
$EndComments
$Elements
6 7 1 7
0 1 15 1
1 99
1 1 1 2
2 2 1
3 2 3
1 2 1 1
4 15 2
1 3 1 1
5 1 14
2 1 3 1
6 1 2 15 14
2 2 3 1
7 2 3 16 15
$EndElements
";

/// A generated solid mesh as MSH 2.2 text, with its boundaries as physical groups 1, 2, ….
fn solid_text() -> String {
    let mesh = block([2.0, 1.0, 1.0], [2, 1, 1], [0.0; 3]).unwrap();
    let mut text = String::from("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n7\n3 1 \"block\"\n");
    for (i, boundary) in mesh.boundaries.iter().enumerate() {
        writeln!(text, "2 {} \"{}\"", i + 1, boundary.name).unwrap();
    }
    writeln!(text, "$EndPhysicalNames\n$Nodes\n{}", mesh.points.len()).unwrap();
    for (i, [x, y, z]) in mesh.points.iter().enumerate() {
        writeln!(text, "{} {x} {y} {z}", i + 1).unwrap();
    }
    let mut elements = vec!["1 1 2 1 1 1 2".to_string()];
    for (group, boundary) in mesh.boundaries.iter().enumerate() {
        for &facet in &boundary.facets {
            let nodes: Vec<String> = mesh.facet_nodes(facet).map(|n| (n + 1).to_string()).collect();
            elements.push(format!("{} 3 2 {} 1 {}", elements.len() + 1, group + 1, nodes.join(" ")));
        }
    }
    for cell in mesh.cells() {
        let nodes: Vec<String> = cell.iter().map(|n| (n + 1).to_string()).collect();
        elements.push(format!("{} 5 2 1 1 {}", elements.len() + 1, nodes.join(" ")));
    }
    writeln!(text, "$EndNodes\n$Elements\n{}\n{}\n$EndElements", elements.len(), elements.join("\n")).unwrap();
    text
}

fn read_gmsh(text: &str) -> Result<Mesh, MeshError> {
    read_mesh_bytes(text.as_bytes())
}

/// A problem in a line.
fn in_line(line: usize, problem: FileProblem) -> MeshError {
    FileError { at: FilePosition::Line(line), problem }.into()
}

/// The problem of an error.
fn problem(error: MeshError) -> FileProblem {
    match error {
        MeshError::File(error) => error.problem,
        other => panic!("{other:?}"),
    }
}

/// Error of a changed text.
fn refusal(text: &str, from: &str, to: &str) -> MeshError {
    assert!(text.contains(from), "{from}");
    read_gmsh(&text.replacen(from, to, 1)).expect_err(to)
}

/// Line, from 1, in which a part of the text begins.
fn line_of(text: &str, piece: &str) -> usize {
    text[..text.find(piece).unwrap()].matches('\n').count() + 1
}

#[test]
fn both_versions_give_the_same_mesh() {
    for text in [SQUARES_2, SQUARES_4] {
        let mesh = read_gmsh(text).unwrap();
        assert_eq!(mesh.only_kind(), Some(CellKind::Quad4));
        assert_eq!(mesh.points, [[0., 0., 0.], [1., 0., 0.], [2., 0., 0.], [0., 1., 0.], [1., 1., 0.], [2., 1., 0.]]);
        assert_eq!(mesh.blocks[0].connectivity, [0, 1, 4, 3, 1, 2, 5, 4]);
        // The name of an unnamed group is its number.
        assert_eq!(mesh.parts, [("left body".to_string(), vec![0]), ("2".to_string(), vec![1])]);
        let facet = |cell, local| Facet { cell, local };
        assert_eq!(
            mesh.boundaries,
            [
                Boundary::of_facets("low", vec![facet(0, 0), facet(1, 0)]),
                // A facet between two cells is listed for both cells.
                Boundary::of_facets("8", vec![facet(0, 1), facet(1, 3)]),
            ]
        );
        assert!((mesh.measure() - 2.0).abs() < 1e-15);
    }
}

#[test]
fn groups_of_points_are_boundaries_of_nodes() {
    let version_2 = SQUARES_2.replace("1 15 2 9 1 99", "1 15 2 9 1 16");
    let version_4 = SQUARES_4.replace("0 1 15 1\n1 99", "0 1 15 1\n1 16");
    for text in [version_2, version_4] {
        let mesh = read_gmsh(&text).unwrap();
        let corner = mesh.boundary("a point").unwrap();
        assert_eq!((&corner.nodes[..], mesh.boundary_nodes(corner)), (&[5][..], vec![5]));
        assert!(corner.facets.is_empty());
        let fine = mesh.refine().unwrap();
        assert_eq!(fine.points[fine.boundary("a point").unwrap().nodes[0] as usize], [2.0, 1.0, 0.0]);
        assert_eq!(mesh.part("2").unwrap().boundary("a point").unwrap().nodes, [3]);
    }
}

#[test]
fn line_ends_blank_lines_and_a_byte_order_mark_do_not_matter() {
    let reference = read_gmsh(SQUARES_4).unwrap();
    for text in
        [SQUARES_4.replace('\n', "\r\n"), SQUARES_4.replace('\n', "\n\n  "), format!("\u{feff}{SQUARES_4}"), SQUARES_4.trim().into()]
    {
        let mesh = read_gmsh(&text).unwrap();
        assert_eq!((mesh.points, mesh.blocks), (reference.points.clone(), reference.blocks.clone()));
    }
}

#[test]
fn a_solid_mesh_comes_back_as_it_was() {
    let expected = block([2.0, 1.0, 1.0], [2, 1, 1], [0.0; 3]).unwrap();
    let mesh = read_gmsh(&solid_text()).unwrap();
    assert_eq!((&mesh.points, &mesh.blocks), (&expected.points, &expected.blocks));
    // The nodes of a curve are a boundary of nodes.
    let curve = Boundary { name: "1".into(), facets: Vec::new(), nodes: vec![0, 1] };
    assert_eq!(mesh.boundaries, [&expected.boundaries[..], &[curve]].concat());
    assert_eq!(mesh.parts, [("block".to_string(), vec![0, 1])]);
}

#[test]
fn tetrahedra_have_their_physical_surfaces_of_triangles() {
    // Cube of five tetrahedra, with its sides at x = 0 and z = 1 as physical surfaces, and one tetrahedron as a separate volume.
    let text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n4\n2 1 \"wall\"\n2 2 \"roof\"\n\
         3 3 \"rest\"\n3 4 \"core\"\n$EndPhysicalNames\n$Nodes\n8\n1 0 0 0\n2 1 0 0\n3 1 1 0\n\
         4 0 1 0\n5 0 0 1\n6 1 0 1\n7 1 1 1\n8 0 1 1\n$EndNodes\n$Elements\n9\n\
         1 2 2 1 1 1 4 5\n2 2 2 1 1 8 4 5\n3 2 2 2 2 5 7 6\n4 2 2 2 2 5 7 8\n5 4 2 3 1 1 2 4 5\n6 4 2 3 1 3 4 2 7\n\
         7 4 2 3 1 6 5 7 2\n8 4 2 3 1 8 7 5 4\n9 4 2 4 1 2 4 5 7\n$EndElements\n";
    let mesh = read_gmsh(text).unwrap_or_else(|error| panic!("{error} {:?}", error.place()));
    assert_eq!((mesh.only_kind(), mesh.cell_count(), mesh.surface_defects()), (Some(CellKind::Tet4), 5, Vec::new()));
    assert!((mesh.measure() - 1.0).abs() < 1e-15);
    for (name, axis, value) in [("wall", 0, 0.0), ("roof", 2, 1.0)] {
        let boundary = mesh.boundary(name).unwrap();
        assert!((mesh.boundary_measure(boundary) - 1.0).abs() < 1e-15);
        assert!(mesh.boundary_nodes(boundary).iter().all(|&node| mesh.points[node as usize][axis] == value));
    }
    let core = mesh.part("core").unwrap();
    assert!((core.measure() - 1.0 / 3.0).abs() < 1e-15 && core.boundaries.is_empty());
    assert_eq!(mesh.part("rest").unwrap().cell_count(), 4);
    // The normal of a facet follows from its cell, independent of the node order of the triangle in the file.
    for facet in &mesh.boundary("roof").unwrap().facets {
        let [a, b, c] = <[u32; 3]>::try_from(mesh.facet_nodes(*facet).collect::<Vec<_>>()).unwrap().map(|node| mesh.points[node as usize]);
        assert!((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0);
    }
}

#[test]
fn a_cell_in_two_groups_is_one_cell() {
    let text = SQUARES_2.replace("$Elements\n7\n", "$Elements\n8\n").replace("$EndElements", "7 3 2 1 2 2 3 16 15\n$EndElements");
    let mesh = read_gmsh(&text).unwrap();
    assert_eq!(mesh.cell_count(), 2);
    assert_eq!(mesh.parts, [("left body".to_string(), vec![0, 1]), ("2".to_string(), vec![1])]);
    let entity = SQUARES_4.replace("2 1 0 0 2 1 0 1 2 1 1", "2 1 0 0 2 1 0 2 2 1 1 1");
    assert_eq!(read_gmsh(&entity).unwrap().parts, mesh.parts);
    // A cell listed twice in one group is an overlap.
    let twice = SQUARES_2.replace("$Elements\n7\n", "$Elements\n8\n").replace("$EndElements", "8 3 2 2 2 2 3 16 15\n$EndElements");
    assert_eq!(read_gmsh(&twice).unwrap_err(), in_line(line_of(&twice, "8 3 2 2 2"), DuplicateCell { cell: 8, first: 7 }));
}

#[test]
fn other_formats_are_recognized() {
    for (text, found) in [
        ("", "an empty file"),
        ("\n\n", "an empty file"),
        ("solid part\nfacet normal 0 0 1\n", "an STL file"),
        ("*KEYWORD\n", "an LS-DYNA input file"),
        ("lorem ipsum", "something that begins like no known mesh file"),
        ("SetFactory(\"OpenCASCADE\");", "a Gmsh geometry (`.geo`), which has to be meshed first"),
    ] {
        let error = read_gmsh(text).unwrap_err();
        assert_eq!(error.line(), Some(1), "{text:?}: {error:?}");
        assert_eq!(problem(error), OtherFormat { found });
    }
    assert_eq!(read_gmsh("$NOD\n1\n").unwrap_err(), in_line(1, Version { version: "1".into() }));
    assert_eq!(refusal(SQUARES_4, "4.1 0 8", "4 0 8"), in_line(2, Version { version: "4".into() }));
    assert_eq!(refusal(SQUARES_4, "4.1 0 8", "4.1 1 8"), FileError { at: FilePosition::Byte(20), problem: ByteOrder }.into());
    assert_eq!(refusal(SQUARES_4, "4.1 0 8", "4.1 1 7"), FileError { at: FilePosition::Byte(20), problem: NumberSize { bytes: 7 } }.into());
    let strange = read_mesh_bytes(b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n\xff").unwrap_err();
    assert_eq!(strange, in_line(4, NotText));
    assert!(read_mesh_bytes(SQUARES_2.as_bytes()).is_ok());
}

#[test]
fn every_truncation_is_an_error_with_a_line() {
    for text in [SQUARES_2, SQUARES_4, &solid_text()] {
        // Truncation at the last character is valid: the last line may have no line break.
        for end in 0..text.len() - 1 {
            let error = read_gmsh(&text[..end]).expect_err("truncated");
            let line = error.line().unwrap_or_else(|| panic!("{error}"));
            assert!(line <= text[..end].lines().count().max(1), "{error}");
            assert!(!error.hint().is_empty());
        }
    }
    let cut = &SQUARES_2[..SQUARES_2.find("15 1 1 0").unwrap() + 4];
    assert_eq!(
        read_gmsh(cut).unwrap_err().to_string(),
        "the file ends inside section $Nodes that began in line 10: 4 of 7 entries are there"
    );
}

#[test]
fn missing_and_repeated_sections_are_named() {
    let without = |text: &str, section: &str| {
        let (begin, end) = (text.find(&format!("${section}")).unwrap(), text.find(&format!("$End{section}")).unwrap());
        read_gmsh(&format!("{}{}", &text[..begin], &text[end + section.len() + 5..]))
    };
    for text in [SQUARES_2, SQUARES_4] {
        for name in ["Nodes", "Elements", "MeshFormat"] {
            let error = without(text, name).unwrap_err();
            assert!(matches!(problem(error), MissingSection { section } if section.strip_prefix('$') == Some(name)), "{name}");
        }
        // The name of a group without a name is its number.
        assert_eq!(without(text, "PhysicalNames").unwrap().parts[0].0, "1");
    }
    assert!(matches!(problem(without(SQUARES_4, "Entities").unwrap_err()), MissingSection { section: "$Entities" }));
    let twice = format!("{SQUARES_2}$Nodes\n0\n$EndNodes\n");
    assert_eq!(read_gmsh(&twice).unwrap_err(), in_line(30, RepeatedSection { section: "$Nodes".into() }));
    let stray = refusal(SQUARES_2, "$EndNodes\n", "$EndNodes\nstray\n");
    assert!(stray.line() == Some(20) && matches!(problem(stray), Malformed { .. }));
}

#[test]
fn absurd_counts_take_no_memory() {
    let huge = u64::MAX.to_string();
    for (text, from, to) in [
        (SQUARES_2, "$Nodes\n7", format!("$Nodes\n{huge}")),
        (SQUARES_2, "$Elements\n7", format!("$Elements\n{huge}")),
        (SQUARES_2, "$PhysicalNames\n3", format!("$PhysicalNames\n{huge}")),
        (SQUARES_2, "6 3 2 1 1 1 2 15 14", format!("6 3 {huge} 1 1 1 2 15 14")),
        (SQUARES_4, "1 3 2 0", format!("{huge} {huge} {huge} {huge}")),
        (SQUARES_4, "1 5 5 0 1 9", format!("1 5 5 0 {huge} 9")),
        (SQUARES_4, "3 7 1 99", format!("{huge} {huge} 1 99")),
        (SQUARES_4, "1 1 1 3\n", format!("1 1 1 {huge}\n")),
        (SQUARES_4, "6 7 1 7", format!("{huge} {huge} 1 7")),
        (SQUARES_4, "2 2 3 1", format!("2 2 3 {huge}")),
    ] {
        let error = refusal(text, from, &to);
        assert!(matches!(problem(error), Count { .. } | Malformed { .. }), "{to}");
    }
    // A node number so large that a dense table would have 2^64 entries.
    let text = SQUARES_2.replace("99", &huge);
    assert_eq!(read_gmsh(&text).unwrap().points.len(), 6);
    assert_eq!(refusal(SQUARES_2, "$Nodes\n7", "$Nodes\n8").to_string(), "section $Nodes announces 8 entries but has 7");
    assert_eq!(refusal(SQUARES_2, "$Nodes\n7", "$Nodes\n6").to_string(), "section $Nodes announces 6 entries but has more");
    assert_eq!(refusal(SQUARES_4, "3 7 1 99", "3 8 1 99").to_string(), "section $Nodes announces 8 entries but has 7");
}

#[test]
fn wrong_numbers_are_refused_in_their_line() {
    let nan = refusal(SQUARES_2, "15 1 1 0", "15 1 nan 0");
    assert_eq!(nan.line(), Some(16));
    assert!(matches!(problem(nan), Coordinate { node: 15, value } if value.is_nan()));
    assert_eq!(refusal(SQUARES_4, "\n2 1 0\n$End", "\n2 -inf 0\n$End"), in_line(37, Coordinate { node: 16, value: f64::NEG_INFINITY }));
    assert_eq!(refusal(SQUARES_2, "15 1 1 0", "14 1 1 0"), in_line(16, DuplicateNode { node: 14, first: FilePosition::Line(15) }));
    assert_eq!(refusal(SQUARES_2, "99 5 5", "16 5 5"), in_line(18, DuplicateNode { node: 16, first: FilePosition::Line(17) }));
    assert_eq!(refusal(SQUARES_2, "2 3 16 15", "2 3 17 15"), in_line(28, MissingNode { element: 7, node: 17 }));
    let bow = Collapsed { element: 7, kind: "quad4", node: 2, smaller: vec!["tri3"] };
    assert_eq!(refusal(SQUARES_2, "2 3 16 15", "2 3 2 15"), in_line(28, bow));
    assert_eq!(refusal(SQUARES_2, "1 1 0\n16", "1 1 1e-3\n16"), in_line(16, NotPlane { node: 15, z: 1e-3 }));
    // Only used nodes must lie in the plane z = 0.
    assert!(read_gmsh(&SQUARES_2.replace("99 5 5 0", "99 5 5 7")).is_ok());
    for (text, from, to) in [
        (SQUARES_2, "15 1 1 0", "15 1 1"),
        (SQUARES_2, "15 1 1 0", "15 1 1 0 0"),
        (SQUARES_2, "15 1 1 0", "15 1 one 0"),
        (SQUARES_2, "2 3 16 15", "2 3 16"),
        (SQUARES_2, "2 3 16 15", "2 3 16 15 1"),
        (SQUARES_2, "2 3 16 15", "2 3 -16 15"),
        (SQUARES_2, "2 1 \"left body\"", "2 1 left body"),
        (SQUARES_2, "2 1 \"left body\"", "2 1 \"left body"),
        (SQUARES_4, "0 1 0 1\n99", "0 1 0\n99"),
    ] {
        assert!(matches!(problem(refusal(text, from, to)), Malformed { .. }), "{to}");
    }
    assert_eq!(
        refusal(SQUARES_2, "15 1 1 0", "15 1 1").to_string(),
        "expected a node with its number and three coordinates, found \"15 1 1\""
    );
    assert_eq!(refusal(SQUARES_4, "2 2 3 1", "2 5 3 1"), in_line(line_of(SQUARES_4, "2 2 3 1"), UnknownEntity { dimension: 2, entity: 5 }));
    let names = refusal(SQUARES_2, "1 7 \"low\"", "2 2 \"left body\"");
    assert_eq!(names, in_line(7, AmbiguousName { dimension: 2, name: "left body".into(), first: 1, second: 2 }));
}

#[test]
fn clockwise_cells_are_reversed_and_crossed_ones_are_an_error_with_place_and_cure() {
    let text = SQUARES_2.replace("2 3 16 15", "2 15 16 3");
    let mesh = read_gmsh(&text).unwrap();
    // A reversed cell keeps its first node, and the boundary below keeps its facets.
    assert_eq!((mesh.cell(1), mesh.measure()), (&[1, 2, 5, 4][..], 2.0));
    assert_eq!(mesh.boundaries, read_gmsh(SQUARES_2).unwrap().boundaries);
    let one = refusal(SQUARES_2, "2 3 16 15", "2 3 15 16");
    assert_eq!((one.line(), one.hint().starts_with("mend the mesh there")), (Some(28), true));
    assert!(one.to_string().starts_with("cell 7 at (1.5, 0.5) is inside out: its Jacobian determinant is -"), "{one}");
    // A cell whose four nodes all lie on the line x = 1.
    let flat = refusal(&SQUARES_2.replace("3 2 0 0", "3 1 0.3 0"), "16 2 1 0", "16 1 0.6 0");
    assert!(matches!(flat, MeshError::DegenerateCell { at: Some(FilePosition::Line(28)), cell: 7, .. }), "{flat:?}");
}

#[test]
fn other_cells_are_refused_with_the_cure() {
    let third_order = refusal(SQUARES_4, "2 2 3 1", "2 2 29 1");
    assert!(third_order.to_string().contains("20-node tetrahedron (third order)"), "{third_order}");
    assert!(third_order.hint().contains("Mesh.ElementOrder = 2;"), "{}", third_order.hint());
    assert!(matches!(problem(refusal(SQUARES_2, "7 3 2 2 2", "7 1234 2 2 2")), UnsupportedCell { element: 7, .. }));
    let lines_only =
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n2\n1 0 0 0\n2 1 0 0\n$EndNodes\n$Elements\n1\n1 1 2 1 1 1 2\n$EndElements\n";
    assert_eq!(read_gmsh(lines_only).unwrap_err(), in_line(9, NoCells { lines: 1 }));
}

#[test]
fn facets_without_cells_and_mixed_kinds_are_refused() {
    let stray = refusal(SQUARES_2, "3 1 2 7 1 2 3", "3 1 2 7 1 2 16");
    assert_eq!(stray, in_line(24, StrayFacet { element: 3, boundary: "low".into() }));
    let text = solid_text();
    let mixed = text
        .replace("$Nodes\n12\n", "$Nodes\n16\n13 5 0 0\n14 6 0 0\n15 6 1 0\n16 5 1 0\n")
        .replace("$Elements\n13\n", "$Elements\n14\n99 3 2 1 1 13 14 15 16\n");
    assert!(matches!(problem(read_gmsh(&mixed).unwrap_err()), MixedDimensions { element: 99, .. }));
    let across = text.replace("$Elements\n13\n", "$Elements\n14\n99 3 2 1 1 1 2 11 10\n");
    assert!(matches!(problem(read_gmsh(&across).unwrap_err()), StrayFacet { element: 99, .. }));
}

#[test]
fn three_cells_on_one_facet_are_refused() {
    let text = SQUARES_2
        .replace("$Elements\n7\n", "$Elements\n8\n")
        .replace("$Nodes\n7\n", "$Nodes\n9\n20 3 -1 0\n21 3 3 0\n")
        .replace("$EndElements", "8 3 2 2 2 2 20 21 15\n$EndElements");
    let error = read_gmsh(&text).unwrap_err();
    assert_eq!(error, MeshError::CrowdedFacet { at: Some(FilePosition::Line(29)), cell: 6, sharing: 3 });
}

#[test]
fn a_file_that_is_not_there_says_so() {
    let error = read_mesh("no such folder/part.msh").unwrap_err();
    assert!(error.to_string().starts_with("the mesh file no such folder/part.msh cannot be read: "), "{error}");
}

/// Asserts that the reader returns either a mesh without defects or an error with a message and a hint.
fn survives(content: &[u8]) {
    match read_mesh_bytes(content) {
        Ok(mesh) => assert_eq!(mesh.defects(), []),
        Err(error) => assert!(!error.hint().is_empty() && !error.to_string().is_empty()),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn arbitrary_bytes_never_panic(content in proptest::collection::vec(any::<u8>(), 0..200)) {
        survives(&content);
        survives(&[SQUARES_4.as_bytes(), &content].concat());
    }

    /// Replaces bytes of a valid file at places and by characters that are significant for the format.
    #[test]
    fn damaged_bytes_never_panic(
        which in 0..3usize,
        damage in proptest::collection::vec((any::<Index>(), select(b"$0123456789-.e \n\"\xff".to_vec())), 1..6),
    ) {
        let mut content = [SQUARES_2.into(), SQUARES_4.into(), solid_text()][which].clone().into_bytes();
        for (place, byte) in damage {
            let place = place.index(content.len());
            content[place] = byte;
        }
        survives(&content);
    }

    /// Drops, duplicates and exchanges lines of a valid file, and replaces numbers by unusual ones.
    #[test]
    fn damaged_lines_never_panic(
        which in 0..3usize,
        damage in proptest::collection::vec((0..4u8, any::<Index>(), any::<Index>()), 1..5),
    ) {
        const STRANGE: [&str; 12] =
            ["-1", "0", "1", "3", "5", "15", "18446744073709551615", "-9223372036854775808", "1e308", "nan", "inf", "99999999999999999999"];
        let text: String = [SQUARES_2.into(), SQUARES_4.into(), solid_text()][which].clone();
        let mut lines: Vec<String> = text.lines().map(String::from).collect();
        for (what, first, second) in damage {
            let (a, b) = (first.index(lines.len()), second.index(lines.len()));
            match what {
                0 => drop(lines.remove(a)),
                1 => lines.insert(b, lines[a].clone()),
                2 => lines.swap(a, b),
                _ => {
                    let mut fields: Vec<&str> = lines[a].split(' ').collect();
                    let field = second.index(fields.len());
                    fields[field] = STRANGE[first.index(STRANGE.len())];
                    lines[a] = fields.join(" ");
                }
            }
        }
        survives(lines.join("\n").as_bytes());
    }
}
