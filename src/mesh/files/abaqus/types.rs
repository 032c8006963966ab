//! Names of element types: families and what their numbers of nodes mean.

use super::super::tables::Shape;
use crate::elements::CellKind;

/// Families with the dimension of their elements; where one begins like another, the longer one first.
const FAMILIES: &[(&str, usize)] = &[
    ("CPEG", 2),
    ("CPE", 2),
    ("CPS", 2),
    ("CGAX", 2),
    ("CAX", 2),
    ("DC2D", 2),
    ("DCAX", 2),
    ("AC2D", 2),
    ("ACAX", 2),
    ("STRI", 2),
    ("SFM3D", 2),
    ("M3D", 2),
    ("R3D", 2),
    ("DS", 2),
    ("SC", 0),
    ("SAX", 0),
    ("S", 2),
    ("C3D", 3),
    ("DC3D", 3),
    ("AC3D", 3),
    ("T2D", 1),
    ("T3D", 1),
    ("R2D", 1),
    ("RAX", 1),
    ("B2", 1),
    ("B3", 1),
];

/// The shape of an element type, such as a quadrilateral of four nodes for `CPE4R`; nothing when it is not read.
pub(super) fn shape_of(name: &str) -> Option<Shape> {
    let name = name.to_ascii_uppercase();
    let (family, dimension) = FAMILIES.iter().find(|(family, _)| name.starts_with(family))?;
    let rest = &name[family.len()..];
    let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
    let (count, letters) = rest.split_at(digits);
    if !letters.bytes().all(|letter| letter.is_ascii_alphabetic()) {
        return None;
    }
    let nodes: usize = match (*family, count) {
        // the second digit of a beam's name counts its nodes less one
        ("B2" | "B3", "1") => 2,
        ("B2" | "B3", "2") => 3,
        ("B2" | "B3", _) => return None,
        _ => count.parse().ok()?,
    };
    match (*dimension, nodes) {
        (1, 2 | 3) => Some(Shape::Line(nodes)),
        (dimension, nodes) => {
            let kind = CellKind::ALL.iter().find(|kind| (kind.dimension(), kind.nodes()) == (dimension, nodes));
            kind.map(|&kind| Shape::Cell(kind))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn families_and_numbers_of_nodes_say_the_shape() {
        for name in ["CPS4", "CPE4R", "cpe4rh", "CAX4I", "S4", "S4R", "M3D4", "CPEG4", "DC2D4"] {
            assert_eq!(shape_of(name), Some(Shape::Cell(CellKind::Quad4)), "{name}");
        }
        for name in ["C3D8", "C3D8R", "C3D8I", "c3d8", "DC3D8"] {
            assert_eq!(shape_of(name), Some(Shape::Cell(CellKind::Hex8)), "{name}");
        }
        for (name, kind) in [
            ("CPS3", CellKind::Tri3),
            ("STRI3", CellKind::Tri3),
            ("CPE6M", CellKind::Tri6),
            ("CAX8R", CellKind::Quad8),
            ("S9", CellKind::Quad9),
            ("C3D4", CellKind::Tet4),
            ("C3D10M", CellKind::Tet10),
            ("C3D20R", CellKind::Hex20),
            ("C3D27", CellKind::Hex27),
        ] {
            assert_eq!(shape_of(name), Some(Shape::Cell(kind)), "{name}");
        }
        assert_eq!(shape_of("T3D2"), Some(Shape::Line(2)));
        assert_eq!(shape_of("B31"), Some(Shape::Line(2)));
        assert_eq!(shape_of("B22"), Some(Shape::Line(3)));
        for name in ["STRI65", "C3D15", "C3D6", "SC8R", "MASS", "SPRINGA", "CPE", "", "C3D8-", "SAX1", "B33H1"] {
            assert_eq!(shape_of(name), None, "{name}");
        }
    }
}
