//! Element types of meshes by name.

use super::handle::{MeshHandle, made};
use crate::elements::CellKind;
use crate::script::language::prelude::*;

/// Element types in the plane, the default first.
pub const PLANE: &[&str] = &["quad4", "tri3", "tri6", "quad8", "quad9"];
/// Element types in space, the default first.
pub const SOLID: &[&str] = &["hex8", "tet4", "tet10", "hex20", "hex27", "wedge6", "wedge15", "pyr5", "pyr13"];
const ALL: &[&str] =
    &["tri3", "quad4", "tri6", "quad8", "quad9", "tet4", "hex8", "tet10", "hex20", "hex27", "wedge6", "wedge15", "pyr5", "pyr13"];

/// Returns the option `element` with these choices, of which the first is the default.
pub fn element(kinds: &'static [&'static str]) -> Parameter {
    Parameter::new("element", Kind::Choice(kinds), "the kind of its cells").or(kinds[0])
}

/// Cell kind with the given name.
fn kind_named(name: &str) -> CellKind {
    CellKind::ALL.iter().copied().find(|kind| kind.name() == name).unwrap_or(CellKind::Quad4)
}

/// Reads the option `element`.
///
/// # Errors
/// The name is unknown.
pub fn kind_of(options: &Options) -> Result<CellKind, Failure> {
    options.text("element").map(|name| kind_named(&name))
}

/// `with_elements` of a mesh.
pub fn with_elements() -> Function {
    method_of::<MeshHandle>(Topic::Meshes, "with_elements")
        .summary(
            "the mesh with cells of another kind on the same corners: cells of first order as those of second order of their shape, \
             `quad4` as `tri3` or `tri6` as well, `hex8` as tetrahedra, wedges (two each, side by side through the thickness) or pyramids \
             (six each, about a node in the center) of either order; new nodes stand on straight edges (by the option `element` generators \
             put them on curves). In a mesh of several kinds the other cells become those of the same order",
        )
        .parameters(vec![Parameter::new("element", Kind::Choice(ALL), "the kind of its cells")])
        .see_also(&["refine", "rectangle", "extrude"])
        .example("let plate = rectangle(#{ size: [2.0, 1.0], cells: [8, 4] }).with_elements(\"quad8\");")
        .body(|call, handle| {
            let kind = kind_named(&call.text("element")?);
            let mesh = handle.mesh();
            made(call, move || mesh.with_cells(kind))
        })
}
