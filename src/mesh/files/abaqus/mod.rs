//! Input files of Abaqus and CalculiX (`.inp`): keywords with a star, lines of data (Abaqus Keywords Reference Guide).
//!
//! Nodes, elements, sets, surfaces, parts and their instances are read, with the files that are included; materials, pairs of surfaces and
//! supports are kept for decks; all other keywords are passed over. Sets of elements become parts or, where their elements are facets of
//! the cells, boundaries; surfaces and sets of nodes become boundaries. What stands before a dot in a name is an instance only where the
//! file has an instance of that name. The order of nodes is that of the cells here for every kind that is read.

mod contents;
mod deck;
mod definitions;
mod includes;
mod lines;
mod reader;
mod scope;
mod sets;
mod types;

pub use deck::{Deck, DeckBoundary, DeckPair, DeckPart};
pub(super) use deck::{read_deck, read_whole};
pub use definitions::{DeckMaterial, DeckProperty};
pub use includes::below_folder_of;
