//! The deformed bodies and the rigid obstacles that they touch, colored by nodal fields with a color bar each.

mod arrows;
mod boundaries;
mod draw;
mod field;
mod hull;
mod marks;
mod options;
mod plane;
mod scale;
mod section;
mod skin;
mod view;

#[cfg(test)]
mod tests;

pub use boundaries::picture_of_boundaries;
pub use draw::{picture, sight};
pub use field::{Field, Vectors};
pub use options::{Measure, Panel, PictureBounds, PictureOptions};
pub use section::CutPlane;
pub use view::{VIEWS, View};
