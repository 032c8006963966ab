//! Tests of binary Gmsh files, of input files of Abaqus, and of what is written.

use std::fmt::Write;

use super::read::read_mesh_bytes;
use crate::mesh::file_error::FileProblem::*;
use crate::mesh::file_error::{FileError, FilePosition, FileProblem};
use crate::mesh::{Boundary, Facet, MeshError, block, rectangle};

/// Two unit squares side by side with a boundary below, in binary.
struct Binary {
    bytes: Vec<u8>,
    is_little: bool,
}

impl Binary {
    fn text(&mut self, text: &str) {
        self.bytes.extend(text.as_bytes());
    }

    fn ints(&mut self, numbers: &[i32]) {
        for number in numbers {
            self.bytes.extend(if self.is_little { number.to_le_bytes() } else { number.to_be_bytes() });
        }
    }

    fn sizes(&mut self, numbers: &[u64]) {
        for number in numbers {
            self.bytes.extend(if self.is_little { number.to_le_bytes() } else { number.to_be_bytes() });
        }
    }

    fn reals(&mut self, numbers: &[f64]) {
        for number in numbers {
            self.bytes.extend(if self.is_little { number.to_le_bytes() } else { number.to_be_bytes() });
        }
    }
}

const POINTS: [[f64; 3]; 6] = [[0., 0., 0.], [1., 0., 0.], [2., 0., 0.], [0., 1., 0.], [1., 1., 0.], [2., 1., 0.]];

fn version_2(is_little: bool) -> Vec<u8> {
    let mut file = Binary { bytes: Vec::new(), is_little };
    file.text("$MeshFormat\n2.2 1 8\n");
    file.ints(&[1]);
    file.text("\n$EndMeshFormat\n$PhysicalNames\n2\n1 7 \"low\"\n2 1 \"body\"\n$EndPhysicalNames\n$Nodes\n6\n");
    for (number, point) in (1..).zip(POINTS) {
        file.ints(&[number]);
        file.reals(&point);
    }
    file.text("\n$EndNodes\n$Elements\n4\n");
    file.ints(&[1, 2, 2, 1, 7, 1, 1, 2, 2, 7, 1, 2, 3]);
    file.ints(&[3, 2, 2, 3, 1, 1, 1, 2, 5, 4, 4, 1, 1, 2, 3, 6, 5]);
    file.text("\n$EndElements\n");
    file.bytes
}

fn version_4(is_little: bool) -> Vec<u8> {
    let mut file = Binary { bytes: Vec::new(), is_little };
    file.text("$MeshFormat\n4.1 1 8\n");
    file.ints(&[1]);
    file.text("\n$EndMeshFormat\n$PhysicalNames\n2\n1 7 \"low\"\n2 1 \"body\"\n$EndPhysicalNames\n$Entities\n");
    file.sizes(&[0, 1, 1, 0]);
    for group in [7, 1] {
        file.ints(&[1]);
        file.reals(&[0., 0., 0., 2., 1., 0.]);
        file.sizes(&[1]);
        file.ints(&[group]);
        file.sizes(&[1]);
        file.ints(&[1]);
    }
    file.text("\n$EndEntities\n$Nodes\n");
    file.sizes(&[2, 6, 1, 6]);
    file.ints(&[1, 1, 1]);
    file.sizes(&[3, 1, 2, 3]);
    for point in &POINTS[..3] {
        file.reals(point);
        // A parametric node: coordinates, then its parameter on the curve.
        file.reals(&point[..1]);
    }
    file.ints(&[2, 1, 0]);
    file.sizes(&[3, 4, 5, 6]);
    file.reals(POINTS[3..].as_flattened());
    file.text("\n$EndNodes\n$Elements\n");
    file.sizes(&[2, 4, 1, 4]);
    file.ints(&[1, 1, 1]);
    file.sizes(&[2, 1, 1, 2, 2, 2, 3]);
    file.ints(&[2, 1, 3]);
    file.sizes(&[2, 3, 1, 2, 5, 4, 4, 2, 3, 6, 5]);
    file.text("\n$EndElements\n");
    file.bytes
}

fn files() -> [Vec<u8>; 4] {
    [version_2(true), version_2(false), version_4(true), version_4(false)]
}

#[test]
fn binary_files_of_both_versions_and_orders_of_bytes_are_one_mesh() {
    for (which, content) in files().iter().enumerate() {
        let mesh = read_mesh_bytes(content).unwrap_or_else(|error| panic!("{which}: {error} {:?}", error.place()));
        assert_eq!(mesh.points, POINTS, "{which}");
        assert_eq!(mesh.blocks[0].connectivity, [0, 1, 4, 3, 1, 2, 5, 4], "{which}");
        assert_eq!(mesh.parts, [("body".to_string(), vec![0, 1])]);
        let facets = vec![Facet { cell: 0, local: 0 }, Facet { cell: 1, local: 0 }];
        assert_eq!(mesh.boundaries, [Boundary::of_facets("low", facets)]);
    }
}

#[test]
fn every_cut_and_every_flipped_byte_of_a_binary_file_ends_well() {
    for content in files() {
        for end in 0..content.len() - 1 {
            let error = read_mesh_bytes(&content[..end]).expect_err("cut");
            let place = error.place().unwrap_or_else(|| panic!("{error}"));
            assert!(
                matches!(place, FilePosition::Line(_)) || matches!(place, FilePosition::Byte(byte) if byte <= end),
                "{error} {place:?} of {end}"
            );
            assert!(!error.hint().is_empty());
        }
        for place in 0..content.len() {
            for mask in [1, 0x80, 0xff] {
                let mut damaged = content.clone();
                damaged[place] ^= mask;
                if let Ok(mesh) = read_mesh_bytes(&damaged) {
                    assert_eq!(mesh.defects(), []);
                }
            }
        }
    }
}

#[test]
fn places_in_binary_files_are_bytes() {
    let content = version_2(true);
    let text = String::from_utf8_lossy(&content[..200]).into_owned();
    let nodes = text.find("$Nodes\n6\n").unwrap() + 9;
    let mut nan = content.clone();
    nan[nodes + 4..nodes + 12].copy_from_slice(&f64::NAN.to_le_bytes());
    assert_eq!(read_mesh_bytes(&nan).unwrap_err().offset(), Some(nodes));
    let mut twice = content.clone();
    twice[nodes + 28] = 1;
    let problem = DuplicateNode { node: 1, first: FilePosition::Byte(nodes) };
    assert_eq!(read_mesh_bytes(&twice).unwrap_err(), FileError { at: FilePosition::Byte(nodes + 28), problem }.into());
    assert_eq!(read_mesh_bytes(&twice).unwrap_err().to_string(), format!("node 1 occurs twice, first at byte {nodes}"));
}

/// Mesh of two squares as an Abaqus input file that uses every feature that is read.
const SQUARES: &str = "** two squares
*Heading
 a comment that is data, 1, 2
*Part, name=both
*NODE, NSET=all
1, 0., 0.
2, 1., 0., 0.
3, 2D0, 0.
4, 0., 1.
5, 1., 1.
6, 2., 1.e0,
*Element, type=CPE4R, elset=Left
10, 1, 2,
 5, 4
*ELEMENT, TYPE=cps4, ELSET=right
 20, 2, 3, 6, 5
*Elset, elset=both, generate
10, 20, 10
*ELSET, ELSET=again
left, RIGHT
*Elset, elset=_foot_S1, internal
10, 20
*NSET, NSET=low, GENERATE
1, 3
*SURFACE, NAME=foot, TYPE=ELEMENT
_foot_S1, S1
*Surface, name=sides
left, S4
20, S2
*Surface, name=outside
again,
*END PART
*INSTANCE, NAME=both-1, PART=both
*END INSTANCE
*NSET, NSET=\"corner\"
both-1.6
*MATERIAL, NAME=steel
*ELASTIC
1, 2
";

#[test]
fn sets_and_surfaces_of_an_input_file_are_parts_and_boundaries() {
    let mesh = read_mesh_bytes(SQUARES.as_bytes()).unwrap_or_else(|error| panic!("{error} {:?}", error.place()));
    assert_eq!((&mesh.points[..], &mesh.blocks[0].connectivity[..]), (&POINTS[..], &[0, 1, 4, 3, 1, 2, 5, 4][..]));
    let parts: Vec<(&str, &[u32])> = mesh.parts.iter().map(|(name, cells)| (name.as_str(), &cells[..])).collect();
    assert_eq!(parts, [("Left", &[0][..]), ("right", &[1]), ("both", &[0, 1]), ("again", &[0, 1])]);
    let facet = |cell, local| Facet { cell, local };
    let named = |name: &str| mesh.boundary(name).unwrap_or_else(|| panic!("no boundary {name}"));
    assert_eq!(named("foot").facets, [facet(0, 0), facet(1, 0)]);
    assert_eq!(named("sides").facets, [facet(0, 3), facet(1, 1)]);
    assert_eq!(named("outside").facets, mesh.hull());
    assert_eq!((&named("low").facets[..], &named("low").nodes[..]), (&[facet(0, 0), facet(1, 0)][..], &[][..]));
    assert_eq!((&named("corner").facets[..], &named("corner").nodes[..]), (&[][..], &[5][..]));
    assert_eq!(named("all").facets, mesh.hull());
    assert_eq!(mesh.boundaries.len(), 6);
    let dos = SQUARES.replace('\n', "\r\n");
    assert_eq!(read_mesh_bytes(dos.as_bytes()).unwrap().boundaries, mesh.boundaries);
}

#[test]
fn sides_of_solid_cells_have_the_order_of_the_format() {
    let mesh = block([2.0, 1.0, 1.0], [1, 1, 1], [0.0; 3]).unwrap();
    let mut text = String::from("*NODE\n");
    for (number, [x, y, z]) in (1..).zip(&mesh.points) {
        writeln!(text, "{number}, {x}, {y}, {z}").unwrap();
    }
    let nodes: Vec<String> = mesh.cell(0).iter().map(|node| (node + 1).to_string()).collect();
    writeln!(text, "*ELEMENT, TYPE=C3D8I\n1, {}", nodes.join(", ")).unwrap();
    for side in 1..=6 {
        writeln!(text, "*SURFACE, NAME=side{side}\n1, S{side}").unwrap();
    }
    let read = read_mesh_bytes(text.as_bytes()).unwrap();
    // S1 and S2 are the faces of the first and last four nodes, S3 to S6 follow in order from the face of the nodes 1, 5, 6, 2.
    for (side, place) in (1..).zip(["back", "front", "bottom", "right", "top", "left"]) {
        assert_eq!(read.boundary(&format!("side{side}")).unwrap().facets, mesh.boundary(place).unwrap().facets, "S{side}");
    }
}

#[test]
fn solid_files_have_their_surfaces_sets_and_parts_in_place() {
    // Two tetrahedra on both sides of the triangle 1, 2, 3.
    let tetrahedra = "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n5, 0, 0, -1\n9, 7, 7, 7\n*ELEMENT, TYPE=C3D4, ELSET=above\n\
         10, 1, 2, 3, 4\n*ELEMENT, TYPE=C3D4, ELSET=below\n20, 1, 3, 2, 5\n*SURFACE, NAME=s1\n10, S1\n*SURFACE, NAME=s2\n10, S2\n\
         *SURFACE, NAME=s3\n10, S3\n*SURFACE, NAME=s4\n10, S4\n*SURFACE, NAME=lower\nbelow, S3\nbelow, S2\n*SURFACE, NAME=skin\n\
         above,\n20,\n*NSET, NSET=wall\n1, 3, 4, 5\n*NSET, NSET=tip\n4, 9\n";
    let mesh = read_mesh_bytes(tetrahedra.as_bytes()).unwrap_or_else(|error| panic!("{error} {:?}", error.place()));
    let middles = |name: &str| -> Vec<[f64; 3]> {
        let facets = &mesh.boundary(name).unwrap_or_else(|| panic!("no boundary {name}")).facets;
        let middle = |&facet: &Facet| {
            let nodes: Vec<u32> = mesh.facet_nodes(facet).collect();
            [0, 1, 2].map(|i| nodes.iter().map(|&n| mesh.points[n as usize][i]).sum::<f64>() * 3.0 / nodes.len() as f64)
        };
        facets.iter().map(middle).collect()
    };
    // Sides S1 to S4 of a tetrahedron are the faces 123, 142, 243, 341; expected are the sums of their corners.
    assert_eq!(middles("s1"), [[1.0, 1.0, 0.0]]);
    assert_eq!(middles("s2"), [[1.0, 0.0, 1.0]]);
    assert_eq!(middles("s3"), [[1.0, 1.0, 1.0]]);
    assert_eq!(middles("s4"), [[0.0, 1.0, 1.0]]);
    assert_eq!(middles("lower"), [[1.0, 1.0, -1.0], [0.0, 1.0, -1.0]]);
    assert_eq!((middles("skin").len(), middles("wall").len()), (6, 2));
    assert_eq!(mesh.boundary("tip").map(|tip| (tip.facets.len(), &tip.nodes[..])), Some((0, &[3][..])));
    assert_eq!(mesh.parts, [("above".to_string(), vec![0]), ("below".to_string(), vec![1])]);
    let below = mesh.part("below").unwrap();
    assert_eq!((below.cell_count(), below.boundary("lower").unwrap().facets.len(), below.surface_defects()), (1, 2, Vec::new()));
    // Reversed node order in one of two cells, then in all cells.
    let mirrored = tetrahedra.replace("10, 1, 2, 3, 4", "10, 1, 3, 2, 4");
    let error = read_mesh_bytes(mirrored.as_bytes()).unwrap_err();
    assert_eq!(error.to_string(), "cell 10 at (0.25, 0.25, 0.25) is inside out: its Jacobian determinant is -1 (1 of 2 cells are)");
    assert!(error.line() == Some(9) && error.hint().contains("counter-clockwise as seen from the others: write"), "{}", error.hint());
    let all = mirrored.replace("20, 1, 3, 2, 5", "20, 1, 2, 3, 5");
    assert!(read_mesh_bytes(all.as_bytes()).unwrap_err().hint().contains("all cells are mirrored"));
    // Two hexahedra with a set of both as the top side: S2 is the face of the last four nodes.
    let hexahedra = "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 1, 0\n4, 0, 1, 0\n5, 0, 0, 1\n6, 1, 0, 1\n7, 1, 1, 1\n8, 0, 1, 1\n\
         11, 2, 0, 0\n12, 2, 1, 0\n13, 2, 0, 1\n14, 2, 1, 1\n*ELEMENT, TYPE=C3D8R, ELSET=all\n1, 1, 2, 3, 4, 5, 6, 7,\n8\n\
         2, 2, 11, 12, 3, 6, 13, 14, 7\n*SURFACE, NAME=top\nall, S2\n*SURFACE, NAME=ends\n1, S6\n2, S4\n*SURFACE, NAME=skin\nall,\n";
    let mesh = read_mesh_bytes(hexahedra.as_bytes()).unwrap_or_else(|error| panic!("{error} {:?}", error.place()));
    let at = |name: &str, i: usize| {
        let nodes = mesh.boundary_nodes(mesh.boundary(name).unwrap());
        nodes.into_iter().map(|n| mesh.points[n as usize][i]).collect::<Vec<f64>>()
    };
    assert_eq!((at("top", 2), at("ends", 0)), (vec![1.0; 6], vec![0.0, 0.0, 0.0, 0.0, 2.0, 2.0, 2.0, 2.0]));
    assert_eq!(mesh.boundary("skin").unwrap().facets, mesh.hull());
    let area = mesh.boundary_measure(mesh.boundary("skin").unwrap());
    assert!((area - 10.0).abs() < 1e-14 && (mesh.measure() - 2.0).abs() < 1e-14);
}

/// Line at which a damaged text is refused, and the problem.
fn refused(from: &str, to: &str) -> (String, FileProblem) {
    assert!(SQUARES.contains(from), "{from}");
    let text = SQUARES.replacen(from, to, 1);
    match read_mesh_bytes(text.as_bytes()).expect_err(to) {
        MeshError::File(FileError { at: FilePosition::Line(line), problem }) => {
            assert!(!problem.hint().is_empty());
            (text.lines().nth(line - 1).unwrap().to_string(), problem)
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_is_wrong_with_an_input_file_is_said_with_its_line() {
    let is_keyword = |from: &str, to: &str| {
        let (line, problem) = refused(from, to);
        assert!(to.starts_with(&line) && matches!(problem, Keyword { .. }), "{line}: {problem}");
    };
    is_keyword("*Heading", "*INCLUDE, INPUT=more.inp");
    is_keyword("*NODE, NSET=all", "*NODE, INPUT=nodes.txt");
    is_keyword("*NODE, NSET=all", "*NODE, SYSTEM=C");
    is_keyword("*END PART", "*INSTANCE, NAME=a, LIBRARY=old, INSTANCE=b");
    let is_malformed = |from: &str, to: &str| {
        let (line, problem) = refused(from, to);
        assert!(to.contains(line.trim()) && matches!(problem, Malformed { .. }), "{line}: {problem}");
    };
    is_malformed("4, 0., 1.", "4, 0., one");
    is_malformed(" 5, 4\n", " 5, 4, one\n");
    is_malformed("20, S2", "20, top");
    is_malformed("10, 20, 10", "10, 20, 0");
    let problem = |from: &str, to: &str, line: &str| {
        let (found, problem) = refused(from, to);
        assert_eq!(found.trim(), line, "{problem}");
        problem
    };
    let name = || String::from("C3D15V");
    assert_eq!(problem("CPE4R", "C3D15V", "*Element, type=C3D15V, elset=Left"), UnsupportedType { name: name() });
    let missing = |keyword: &str, parameter| MissingParameter { keyword: keyword.into(), parameter };
    assert_eq!(problem("type=CPE4R, ", "", "*Element, elset=Left"), missing("ELEMENT", "TYPE"));
    assert_eq!(problem(", ELSET=again", "", "*ELSET"), missing("ELSET", "ELSET"));
    assert!(matches!(problem("4, 0., 1.", "4, 0., nan", "4, 0., nan"), Coordinate { node: 4, .. }));
    assert!(matches!(problem("4, 0., 1.", "5, 0., 1.", "5, 1., 1."), DuplicateNode { node: 5, first: FilePosition::Line(_) }));
    for ended in [" 5,\n", " 5\n"] {
        assert_eq!(problem(" 5, 4\n", ended, "10, 1, 2,"), FewNodes { element: 10, found: 3, nodes: 4 });
    }
    assert!(matches!(problem(" 20, 2", " 10, 2", "10, 2, 3, 6, 5"), DuplicateElement { element: 10, first: FilePosition::Line(_) }));
    assert_eq!(problem(" 20, 2, 3,", " 20, 2, 9,", "20, 2, 9, 6, 5"), MissingNode { element: 20, node: 9 });
    let unknown = UnknownSet { kind: "element set", name: "wrong".into() };
    assert_eq!(problem("left, RIGHT", "left, wrong", "*ELSET, ELSET=again"), unknown);
    assert!(matches!(problem("left, RIGHT", "left, 21", "*ELSET, ELSET=again"), UnknownMember { number: 21, .. }));
    assert!(matches!(problem("both-1.6", "60", "*NSET, NSET=\"corner\""), UnknownMember { kind: "node", number: 60, .. }));
    assert!(matches!(problem("20, S2", "20, S5", "20, S5"), UnknownSide { .. }));
    assert!(matches!(problem("20, S2", "21, S2", "21, S2"), UnknownMember { number: 21, .. }));
    let nodes_only = "*NODE\n1, 0., 0.\n";
    let error = read_mesh_bytes(nodes_only.as_bytes()).unwrap_err();
    assert_eq!(error, FileError { at: FilePosition::Line(2), problem: MissingSection { section: "*ELEMENT" } }.into());
    // A set that contains itself has its other members only, and a range takes no memory for its numbers.
    let text = SQUARES.replace("left, RIGHT", "left, again").replace("1, 3\n", "1, 18446744073709551615\n");
    assert_eq!(read_mesh_bytes(text.as_bytes()).unwrap().parts[3].1, [0]);
}

#[test]
fn what_is_written_is_read_back() {
    let mut plate = rectangle([2.0 / 3.0, 1.0], [3, 2], [0.1, 0.0]).unwrap();
    plate.parts = vec![("a".into(), vec![0, 1, 4]), ("b \"c\"".into(), vec![1, 2])];
    let corner = Boundary::of_facets("bottom again", plate.boundary("bottom").unwrap().facets[1..].to_vec());
    plate.boundaries.push(Boundary { nodes: vec![11, 0], ..corner });
    plate.boundaries.push(Boundary { name: "points".into(), facets: Vec::new(), nodes: vec![3, 7] });
    for mesh in [plate, block([1.0, 2.0, 3.0], [2, 1, 2], [1.0 / 7.0; 3]).unwrap()] {
        let text = mesh.to_gmsh();
        let back = read_mesh_bytes(text.as_bytes()).unwrap_or_else(|error| panic!("{error} {:?}\n{text}", error.place()));
        assert_eq!((&mesh.points, &mesh.blocks), (&back.points, &back.blocks));
        assert_eq!((&mesh.boundaries, &mesh.parts), (&back.boundaries, &back.parts));
        assert_eq!(back.to_gmsh(), text);
    }
}
