//! Elements of a drawing: filled areas, strokes and text, painted one over the other.
//!
//! Lengths are pixels, `y` points down. Shapes may be grouped under a name, which SVG viewers show as a tool tip, and clipped to a box.

/// Point in pixels.
pub(in crate::output) type Point = [f64; 2];

/// Red, green and blue.
pub(in crate::output) type Color = [u8; 3];

/// Polyline or polygon.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::output) struct Line {
    /// Vertices.
    pub points: Vec<Point>,
    /// True if the last vertex is joined to the first.
    pub is_closed: bool,
}

impl Line {
    /// Returns an open polyline.
    pub fn open(points: impl Into<Vec<Point>>) -> Self {
        Line { points: points.into(), is_closed: false }
    }

    /// Returns a closed polygon.
    pub fn closed(points: impl Into<Vec<Point>>) -> Self {
        Line { points: points.into(), is_closed: true }
    }
}

/// Style of a stroked line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::output) struct Stroke {
    /// Color.
    pub color: Color,
    /// Width in pixels.
    pub width: f64,
    /// Opacity from 0 to 1.
    pub opacity: f64,
    /// Lengths of dashes and gaps `[pixel]`; `None` for a solid line.
    pub dash: Option<f64>,
}

impl Stroke {
    /// Returns a solid, opaque stroke.
    pub fn new(color: Color, width: f64) -> Self {
        Stroke { color, width, opacity: 1.0, dash: None }
    }
}

/// Alignment of a text with respect to its point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::output) enum Anchor {
    /// The start of the text.
    Start,
    /// The middle of the text.
    Middle,
    /// The end of the text.
    End,
}

/// Paint of a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::output) enum Ink {
    /// Fill of the inside by the even-odd rule.
    Fill(Color),
    /// Stroke along the line.
    Stroke(Stroke),
}

/// Element of a drawing.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Item {
    Shape { lines: Vec<Line>, ink: Ink },
    Text { at: Point, text: String, size: f64, anchor: Anchor, is_upward: bool },
    Named(String),
    Clipped { low: Point, high: Point },
    End,
}

/// Drawing with a size in pixels, on white.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    pub(super) size: Point,
    pub(super) items: Vec<Item>,
}

impl Drawing {
    /// Returns an empty drawing.
    pub(in crate::output) fn new(size: Point) -> Self {
        Drawing { size, items: Vec::new() }
    }

    /// Sets the height.
    pub(in crate::output) fn set_height(&mut self, height: f64) {
        self.size[1] = height;
    }

    /// Paints lines as one shape; nothing for an empty list.
    pub(in crate::output) fn paint(&mut self, lines: Vec<Line>, ink: Ink) {
        if !lines.is_empty() {
            self.items.push(Item::Shape { lines, ink });
        }
    }

    /// Paints lines one by one, since they may overlap.
    pub(in crate::output) fn paint_each(&mut self, lines: Vec<Line>, ink: Ink) {
        lines.into_iter().for_each(|line| self.paint(vec![line], ink));
    }

    /// Adds an open line.
    pub(in crate::output) fn line(&mut self, points: impl Into<Vec<Point>>, stroke: Stroke) {
        self.paint(vec![Line::open(points)], Ink::Stroke(stroke));
    }

    /// Adds a filled rectangle parallel to the axes.
    pub(in crate::output) fn filled_box(&mut self, low: Point, high: Point, color: Color) {
        self.paint(vec![upright(low, high)], Ink::Fill(color));
    }

    /// Adds the border of a rectangle parallel to the axes.
    pub(in crate::output) fn framed_box(&mut self, low: Point, high: Point, stroke: Stroke) {
        self.paint(vec![upright(low, high)], Ink::Stroke(stroke));
    }

    /// Adds a line of text on its base line.
    pub(in crate::output) fn text(&mut self, at: Point, text: impl Into<String>, size: f64, anchor: Anchor) {
        self.items.push(Item::Text { at, text: text.into(), size, anchor, is_upward: false });
    }

    /// Adds a text that reads upward (rotated by 90 degrees).
    pub(in crate::output) fn upward_text(&mut self, at: Point, text: impl Into<String>, size: f64, anchor: Anchor) {
        self.items.push(Item::Text { at, text: text.into(), size, anchor, is_upward: true });
    }

    /// Begins a named group.
    pub(in crate::output) fn begin_named(&mut self, name: &str) {
        self.items.push(Item::Named(name.into()));
    }

    /// Begins a group that is clipped to a box.
    pub(in crate::output) fn begin_clipped(&mut self, low: Point, high: Point) {
        self.items.push(Item::Clipped { low, high });
    }

    /// Ends the innermost group.
    pub(in crate::output) fn end(&mut self) {
        self.items.push(Item::End);
    }
}

fn upright([left, top]: Point, [right, bottom]: Point) -> Line {
    Line::closed([[left, top], [right, top], [right, bottom], [left, bottom]])
}
