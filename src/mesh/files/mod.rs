//! Mesh files: Gmsh (MSH 2.2 and 4.1, ASCII and binary), input files of Abaqus and CalculiX, VTU and legacy VTK, Medit, universal files,
//! bulk data of Nastran, SU2 are read; Gmsh 4.1 ASCII is written.
//!
//! The reader of a format fills tables of nodes, elements and groups; `assembly.rs` converts them to a mesh. Groups of cells become parts,
//! groups one dimension below become boundaries; their elements are matched to facets of cells by their node sets, so that orientation
//! always follows from the cell. Groups of points, and in space of lines, become boundaries of nodes. Nodes without cells are left out
//! (centers of circles, for instance). Boundary elements between two cells represent both sides. Changes to the content of a file are
//! returned as notes (`options.rs`); errors have their place in the file.

mod abaqus;
mod assembly;
mod collapse;
mod gmsh;
mod medit;
mod nastran;
mod numbering;
mod options;
mod read;
mod sets;
mod su2;
mod surfaces;
mod tables;
mod text;
mod universal;
mod vtk;
mod words;
mod write;

#[cfg(test)]
mod format_tests;
#[cfg(test)]
mod gmsh_tests;

pub use abaqus::{Deck, DeckBoundary, DeckMaterial, DeckPair, DeckPart, DeckProperty, below_folder_of};
pub use options::{FileNote, Includes, ReadOptions, Shells, Structural};
pub use read::{MESH_ENDINGS, read_deck, read_deck_bytes, read_mesh, read_mesh_bytes, read_mesh_with};
pub use surfaces::{Triangles, read_surface, read_surface_bytes};
