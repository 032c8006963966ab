//! Input files of Abaqus and CalculiX (`.inp`): keywords with a star, lines of data (Abaqus Keywords Reference Guide).
//!
//! Nodes, elements, sets and surfaces are read; materials, steps and all other keywords are passed over. Sets of elements become parts
//! or, where their elements are facets of the cells, boundaries; surfaces and sets of nodes become boundaries. The order of nodes is that
//! of the cells here for every kind that is read.

mod lines;
mod reader;
mod sets;
mod types;

pub(super) use reader::read;
