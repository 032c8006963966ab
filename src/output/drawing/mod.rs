//! Drawings: shapes and text in pixels, written as SVG or PNG. Plots and pictures are made of them, so both formats show the same.

mod font;
mod png;
mod shapes;
mod svg;

pub(super) use font::{elided, text_width};
pub(super) use png::painted;
pub use png::png;
pub use shapes::Drawing;
pub(super) use shapes::{Anchor, Color, Ink, Line, Point, Stroke};
pub use svg::svg;
