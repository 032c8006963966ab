//! What a drawing is made of: filled areas, strokes and text, painted one over the other.
//!
//! Lengths are pixels, `y` points down. Shapes may be grouped under a name, which SVG viewers show as a tool tip, and clipped to a box.

/// A place in pixels.
pub(in crate::output) type Point = [f64; 2];

/// Red, green and blue.
pub(in crate::output) type Color = [u8; 3];

/// A way through points.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::output) struct Line {
    /// Its points.
    pub points: Vec<Point>,
    /// Whether the last is joined to the first.
    pub is_closed: bool,
}

impl Line {
    /// A way that ends at its last point.
    pub fn open(points: impl Into<Vec<Point>>) -> Self {
        Line { points: points.into(), is_closed: false }
    }

    /// A way that ends where it began.
    pub fn closed(points: impl Into<Vec<Point>>) -> Self {
        Line { points: points.into(), is_closed: true }
    }
}

/// How a line is stroked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::output) struct Stroke {
    /// Its color.
    pub color: Color,
    /// Width in pixels.
    pub width: f64,
    /// From 0 to 1.
    pub opacity: f64,
    /// Lengths of dashes and gaps, if it is dashed.
    pub dash: Option<f64>,
}

impl Stroke {
    /// A solid one.
    pub fn new(color: Color, width: f64) -> Self {
        Stroke { color, width, opacity: 1.0, dash: None }
    }
}

/// Where a text stands with respect to its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::output) enum Anchor {
    /// It begins there.
    Start,
    /// Its middle is there.
    Middle,
    /// It ends there.
    End,
}

/// How a shape is painted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::output) enum Ink {
    /// Inside, by the even-odd rule.
    Fill(Color),
    /// Along.
    Stroke(Stroke),
}

/// One thing of a drawing.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Item {
    Shape { lines: Vec<Line>, ink: Ink },
    Text { at: Point, text: String, size: f64, anchor: Anchor, is_upward: bool },
    Named(String),
    Clipped { low: Point, high: Point },
    End,
}

/// A drawing of a size in pixels, on white.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    pub(super) size: Point,
    pub(super) items: Vec<Item>,
}

impl Drawing {
    /// An empty one.
    pub(in crate::output) fn new(size: Point) -> Self {
        Drawing { size, items: Vec::new() }
    }

    /// Makes it higher or lower.
    pub(in crate::output) fn set_height(&mut self, height: f64) {
        self.size[1] = height;
    }

    /// Paints lines; there may be none.
    pub(in crate::output) fn paint(&mut self, lines: Vec<Line>, ink: Ink) {
        if !lines.is_empty() {
            self.items.push(Item::Shape { lines, ink });
        }
    }

    /// Paints lines one by one, where they may lie over each other.
    pub(in crate::output) fn paint_each(&mut self, lines: Vec<Line>, ink: Ink) {
        lines.into_iter().for_each(|line| self.paint(vec![line], ink));
    }

    /// A line.
    pub(in crate::output) fn line(&mut self, points: impl Into<Vec<Point>>, stroke: Stroke) {
        self.paint(vec![Line::open(points)], Ink::Stroke(stroke));
    }

    /// An upright box, filled.
    pub(in crate::output) fn filled_box(&mut self, low: Point, high: Point, color: Color) {
        self.paint(vec![upright(low, high)], Ink::Fill(color));
    }

    /// An upright box, its border.
    pub(in crate::output) fn framed_box(&mut self, low: Point, high: Point, stroke: Stroke) {
        self.paint(vec![upright(low, high)], Ink::Stroke(stroke));
    }

    /// A line of text on its base line.
    pub(in crate::output) fn text(&mut self, at: Point, text: impl Into<String>, size: f64, anchor: Anchor) {
        self.items.push(Item::Text { at, text: text.into(), size, anchor, is_upward: false });
    }

    /// The same, read from below.
    pub(in crate::output) fn upward_text(&mut self, at: Point, text: impl Into<String>, size: f64, anchor: Anchor) {
        self.items.push(Item::Text { at, text: text.into(), size, anchor, is_upward: true });
    }

    /// Begins a group with a name.
    pub(in crate::output) fn begin_named(&mut self, name: &str) {
        self.items.push(Item::Named(name.into()));
    }

    /// Begins a group of which only what is inside of a box is seen.
    pub(in crate::output) fn begin_clipped(&mut self, low: Point, high: Point) {
        self.items.push(Item::Clipped { low, high });
    }

    /// Ends the group that began last.
    pub(in crate::output) fn end(&mut self) {
        self.items.push(Item::End);
    }
}

fn upright([left, top]: Point, [right, bottom]: Point) -> Line {
    Line::closed([[left, top], [right, top], [right, bottom], [left, bottom]])
}
