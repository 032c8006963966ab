//! View of a picture: directions of the viewer, and the projection of points.

use crate::math::tolerances::{FLAT, PICTURE_THICKNESS};
use crate::output::drawing::Point;

/// Direction of view: orthonormal vectors to the right, up and toward the viewer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    pub(super) right: [f64; 3],
    pub(super) up: [f64; 3],
    pub(super) toward: [f64; 3],
}

/// Names of views.
pub const VIEWS: [&str; 7] = ["iso", "front", "back", "right", "left", "top", "bottom"];

impl View {
    /// View of a plane: `x` to the right, `y` up.
    pub const PLANE: View = View { right: [1.0, 0.0, 0.0], up: [0.0, 1.0, 0.0], toward: [0.0, 0.0, 1.0] };

    /// Returns the view in which the axis `axis` (0 to 2) points up. With `z` up the view is along `y` from the front, so that in the view
    /// from the top `y` points up.
    fn upright(axis: usize) -> View {
        let unit = |axis: usize| std::array::from_fn(|d| if d == axis { 1.0 } else { 0.0 });
        let (right, up) = (unit(usize::from(axis == 0)), unit(axis));
        View { right, up, toward: cross(right, up) }
    }

    /// Returns the view of that name (one of [`VIEWS`]) in which the axis `axis` points up.
    pub fn named(name: &str, axis: usize) -> Option<View> {
        let front @ View { right, up, toward } = View::upright(axis);
        let turned = |right: [f64; 3], up: [f64; 3]| View { right, up, toward: cross(right, up) };
        Some(match name {
            "iso" => View::from_direction([0, 1, 2].map(|d| right[d] + up[d] + toward[d]), axis)?,
            "front" => front,
            "back" => turned(negative(right), up),
            "right" => turned(negative(toward), up),
            "left" => turned(toward, up),
            "top" => turned(right, negative(toward)),
            "bottom" => turned(right, toward),
            _ => return None,
        })
    }

    /// Returns the view from a direction (from the bodies to the viewer) in which the axis `axis` points up; `None` for a zero direction.
    pub fn from_direction(direction: [f64; 3], axis: usize) -> Option<View> {
        let toward = unit(direction)?;
        let View { up: sky, toward: front, .. } = View::upright(axis);
        let level = |up: [f64; 3]| unit([0, 1, 2].map(|d| up[d] - dot(up, toward) * toward[d]));
        // In a view from straight above, the vertical axis has no direction in the picture.
        let up = if dot(sky, toward).abs() < 1.0 - FLAT { level(sky)? } else { level(negative(front))? };
        Some(View { right: cross(up, toward), up, toward })
    }

    /// Projects a point into the plane of the picture.
    pub(super) fn flat(&self, x: [f64; 3]) -> Point {
        [dot(self.right, x), dot(self.up, x)]
    }
}

impl Default for View {
    fn default() -> Self {
        View::named("iso", 2).unwrap_or(View::PLANE)
    }
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn negative(a: [f64; 3]) -> [f64; 3] {
    a.map(|x| 0.0 - x)
}

pub(super) fn unit(a: [f64; 3]) -> Option<[f64; 3]> {
    let length = a[0].hypot(a[1]).hypot(a[2]);
    (length > 0.0 && length.is_finite()).then(|| a.map(|x| x / length))
}

/// Bounding box of points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub low: Point,
    pub size: Point,
}

impl Bounds {
    pub fn of<'a>(points: impl Iterator<Item = &'a Point>) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in points.filter(|point| point.iter().all(|x| x.is_finite())) {
            for d in 0..2 {
                low[d] = low[d].min(point[d]);
                high[d] = high[d].max(point[d]);
            }
        }
        let size = [high[0] - low[0], high[1] - low[1]];
        let longest = size[0].max(size[1]);
        if longest > 0.0 && longest.is_finite() {
            Bounds { low, size: size.map(|side| side.max(PICTURE_THICKNESS * longest)) }
        } else {
            Bounds { low: [0.0; 2], size: [1.0; 2] }
        }
    }

    pub fn high(&self) -> Point {
        [self.low[0] + self.size[0], self.low[1] + self.size[1]]
    }
}

/// Mapping from points to pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Camera {
    pub view: View,
    /// Box of the visible region in the plane of the picture.
    pub bounds: Bounds,
    /// Lower left corner of the box in pixels.
    pub corner: Point,
    /// Pixels per length.
    pub zoom: f64,
}

impl Camera {
    /// Returns the pixels of a point in the plane of the picture.
    pub fn pixel(&self, [x, y]: Point) -> Point {
        [self.corner[0] + (x - self.bounds.low[0]) * self.zoom, self.corner[1] - (y - self.bounds.low[1]) * self.zoom]
    }

    /// Returns the pixels of a point in space.
    pub fn place(&self, x: [f64; 3]) -> Point {
        self.pixel(self.view.flat(x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: [f64; 3], b: [f64; 3]) -> bool {
        (0..3).all(|d| (a[d] - b[d]).abs() < 1e-12)
    }

    #[test]
    fn views_are_right_handed_and_upright() {
        for axis in 0..3 {
            for name in VIEWS {
                let View { right, up, toward } = View::named(name, axis).unwrap();
                assert!(near(cross(right, up), toward), "{name} {axis}");
                assert!(matches!(name, "top" | "bottom") || up[axis] > 0.5, "{name} {axis}: the sky is up");
            }
        }
        assert_eq!(View::named("above", 2), None);
    }

    #[test]
    fn from_the_top_y_is_up_and_from_a_direction_the_sky_is() {
        let top = View::named("top", 2).unwrap();
        assert!(near(top.up, [0.0, 1.0, 0.0]) && near(top.right, [1.0, 0.0, 0.0]));
        assert!(near(View::from_direction([0.0, 0.0, 5.0], 2).unwrap().up, [0.0, 1.0, 0.0]));
        assert!(near(View::from_direction([0.0, -2.0, 0.0], 2).unwrap().right, [1.0, 0.0, 0.0]));
        // With `y` up the view from the top is along -y, and the front is +z.
        assert!(near(View::named("top", 1).unwrap().toward, [0.0, 1.0, 0.0]));
        assert!(near(View::named("front", 1).unwrap().toward, [0.0, 0.0, 1.0]));
        let third = 1.0 / 3f64.sqrt();
        assert!(near(View::default().toward, [third, -third, third]));
        assert_eq!(View::from_direction([0.0; 3], 2), None);
    }
}
