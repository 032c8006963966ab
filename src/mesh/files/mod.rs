//! Mesh files: Gmsh (MSH 2.2 and 4.1, ASCII and binary) and input files of Abaqus and CalculiX, read; Gmsh 4.1 ASCII, written.
//!
//! A reader of a format fills tables of nodes, elements and groups; `assembly.rs` makes a mesh of them. Groups of cells become parts,
//! groups one dimension below become boundaries; their elements are matched to facets of cells by their node sets, so that orientation
//! always comes from the cell. Nodes that no cell uses are left out (centers of circles, for instance), and in space so are lines. Elements
//! of a boundary that lies between two cells stand for both sides. Nothing is turned round or repaired: what is wrong is an error with its
//! place.

mod abaqus;
mod assembly;
mod gmsh;
mod numbering;
mod read;
mod sets;
mod surfaces;
mod tables;
mod text;
mod write;

#[cfg(test)]
mod format_tests;
#[cfg(test)]
mod gmsh_tests;

pub use read::{read_mesh, read_mesh_bytes};
pub use surfaces::{Triangles, read_surface, read_surface_bytes};
