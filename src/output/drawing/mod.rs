//! Drawings: shapes and text in pixels, written as SVG or PNG. Plots and pictures consist of drawings, so that both formats show equal
//! content.

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
