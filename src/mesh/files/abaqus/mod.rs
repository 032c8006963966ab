//! Input files of Abaqus and CalculiX (`.inp`): keywords with a star, data lines (Abaqus Keywords Reference Guide).
//!
//! Nodes, elements, sets, surfaces, parts and their instances are read, including included files; materials, contact pairs and supports are
//! kept for decks; all other keywords are ignored. Element sets become parts or, if their elements are facets of the cells, boundaries;
//! surfaces and node sets become boundaries. Text before a dot in a name is an instance only if the file has an instance of this name. The
//! node order of every supported kind equals that of the cells here.

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
