//! Files of VTK: unstructured grids as XML (`.vtu`) and in the legacy format (`.vtk`).

mod data;
mod grid;
mod legacy;
mod xml;

pub(super) use grid::Content;
pub(super) use legacy::read as read_legacy;
pub(super) use xml::read as read_xml;
