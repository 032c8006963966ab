//! Gmsh mesh files, MSH 2.2 and 4.1, ASCII and binary (Gmsh reference manual, "MSH file format").

mod elements;
mod sections;
mod source;
mod version_2;
mod version_4;

pub(super) use elements::number_of;
pub(super) use sections::read;
