//! Names of element types: families and numbers of nodes.

use super::super::tables::Shape;
use crate::elements::CellKind;

/// Family of element types, by their use in a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Family {
    /// Plane or solid cells.
    Cell,
    /// Surfaces in space: shells, membranes, rigid and surface elements. On solid cells they are facets of boundaries.
    Surface,
    /// Trusses, which mesh generators write for lines of boundaries.
    Line,
    /// Beams.
    Beam,
}

/// Element type of a deck, as far as it is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ElementType {
    /// Elements with nodes in the shape of a cell or line.
    Shaped(Shape, Family),
    /// Springs, masses, beams and other elements that are no cells.
    Structural,
}

/// Element families with their dimension; if names have a common prefix, the longer one comes first.
const FAMILIES: &[(&str, usize, Family)] = &[
    ("CPEG", 2, Family::Cell),
    ("CPE", 2, Family::Cell),
    ("CPS", 2, Family::Cell),
    ("CGAX", 2, Family::Cell),
    ("CAX", 2, Family::Cell),
    ("DC2D", 2, Family::Cell),
    ("DCAX", 2, Family::Cell),
    ("AC2D", 2, Family::Cell),
    ("ACAX", 2, Family::Cell),
    ("STRI", 2, Family::Surface),
    ("SFM3D", 2, Family::Surface),
    ("M3D", 2, Family::Surface),
    ("R3D", 2, Family::Surface),
    ("DS", 2, Family::Surface),
    ("S", 2, Family::Surface),
    ("C3D", 3, Family::Cell),
    ("DC3D", 3, Family::Cell),
    ("AC3D", 3, Family::Cell),
    ("T2D", 1, Family::Line),
    ("T3D", 1, Family::Line),
    ("R2D", 1, Family::Line),
    ("RAX", 1, Family::Line),
    ("B2", 1, Family::Beam),
    ("B3", 1, Family::Beam),
];

/// Prefixes of the names of elements that are no cells: point elements, beams, pipes, trusses, connectors, axisymmetric surface elements,
/// elements of networks.
const STRUCTURAL: &[&str] = &[
    "SPRING", "DASHPOT", "MASS", "ROTARYI", "HEATCAP", "CONN", "DCOUP", "GAP", "ITS", "ITT", "IRS", "ISL", "JOINT", "DRAG", "TUBE", "PSI",
    "B2", "B3", "PIPE", "ELBOW", "FRAME", "T2D", "T3D", "R2D", "RAX", "RB", "SAX", "MAX", "MGAX", "MCL", "SFM", "M3D", "R3D", "STRI", "DS",
    "F2D", "F3D", "FAX", "ASI", "LS", "FLINK", "PC3D",
];

/// Returns the element type of a name, such as a quadrilateral of four nodes for `CPE4R`; `None` if the type is not read.
pub(super) fn type_of(name: &str) -> Option<ElementType> {
    let name = name.to_ascii_uppercase();
    if let Some((shape, family)) = shape_of(&name) {
        return Some(ElementType::Shaped(shape, family));
    }
    // Shells with unsupported numbers of nodes, user elements, and elements of networks count as structural.
    let is_numbered = |letter: char| name.strip_prefix(letter).is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
    let is_structural = name == "D" || is_numbered('U') || is_numbered('S') || STRUCTURAL.iter().any(|begin| name.starts_with(begin));
    is_structural.then_some(ElementType::Structural)
}

fn shape_of(name: &str) -> Option<(Shape, Family)> {
    let &(family, dimension, kind) = FAMILIES.iter().find(|(family, ..)| name.starts_with(family))?;
    let rest = &name[family.len()..];
    let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
    let (count, letters) = rest.split_at(digits);
    // `C3D15V` elements may have additional nodes in their faces and are not supported.
    if family == "C3D" && rest.starts_with("15V") {
        return None;
    }
    if !letters.bytes().all(|letter| letter.is_ascii_alphabetic()) {
        return None;
    }
    let nodes: usize = match (kind, count) {
        // The second digit of a beam type is its number of nodes minus one.
        (Family::Beam, "1") => 2,
        (Family::Beam, "2") => 3,
        (Family::Beam, _) => return None,
        _ => count.parse().ok()?,
    };
    let shape = match (dimension, nodes) {
        (1, 2 | 3) => Shape::Line(nodes),
        _ => Shape::Cell(*CellKind::ALL.iter().find(|kind| (kind.dimension(), kind.nodes()) == (dimension, nodes))?),
    };
    Some((shape, kind))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn families_and_numbers_of_nodes_say_the_shape() {
        let shaped = |kind, family| Some(ElementType::Shaped(Shape::Cell(kind), family));
        for name in ["CPS4", "CPE4R", "cpe4rh", "CAX4I", "CPEG4", "DC2D4"] {
            assert_eq!(type_of(name), shaped(CellKind::Quad4, Family::Cell), "{name}");
        }
        for name in ["S4", "S4R", "M3D4", "R3D4", "SFM3D4R", "DS4"] {
            assert_eq!(type_of(name), shaped(CellKind::Quad4, Family::Surface), "{name}");
        }
        for name in ["C3D8", "C3D8R", "C3D8I", "c3d8", "DC3D8"] {
            assert_eq!(type_of(name), shaped(CellKind::Hex8, Family::Cell), "{name}");
        }
        for (name, kind) in [
            ("CPS3", CellKind::Tri3),
            ("CPE6M", CellKind::Tri6),
            ("CAX8R", CellKind::Quad8),
            ("C3D4", CellKind::Tet4),
            ("C3D10M", CellKind::Tet10),
            ("C3D20R", CellKind::Hex20),
            ("C3D27", CellKind::Hex27),
            ("C3D6", CellKind::Wedge6),
            ("C3D15", CellKind::Wedge15),
            ("C3D5", CellKind::Pyr5),
        ] {
            assert_eq!(type_of(name), shaped(kind, Family::Cell), "{name}");
        }
        assert_eq!(type_of("STRI3"), shaped(CellKind::Tri3, Family::Surface));
        assert_eq!(type_of("S9"), shaped(CellKind::Quad9, Family::Surface));
        assert_eq!(type_of("T3D2"), Some(ElementType::Shaped(Shape::Line(2), Family::Line)));
        assert_eq!(type_of("B31"), Some(ElementType::Shaped(Shape::Line(2), Family::Beam)));
        assert_eq!(type_of("B22"), Some(ElementType::Shaped(Shape::Line(3), Family::Beam)));
        for name in ["B33H1", "B33", "SPRINGA", "MASS", "DCOUP3D", "STRI65", "SAX1", "S8R5", "D", "U1", "PIPE31", "CONN3D2"] {
            assert_eq!(type_of(name), Some(ElementType::Structural), "{name}");
        }
        for name in ["C3D7", "C3D15V", "SC8R", "COH3D8", "CIN3D8", "CPE", "", "C3D8-"] {
            assert_eq!(type_of(name), None, "{name}");
        }
    }
}
