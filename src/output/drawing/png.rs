//! A drawing as PNG, painted by `tiny-skia` with the outlines of our own font (resvg would take 15 times as long to compile).

use std::rc::Rc;

use tiny_skia::{FillRule, LineCap, LineJoin, Mask, Paint, Path, PathBuilder, Pixmap, Stroke as Pen, StrokeDash, Transform};
use ttf_parser::OutlineBuilder;

use super::font::{advance, outline, text_width, unit};
use super::shapes::{Anchor, Color, Drawing, Ink, Item, Line, Point, Stroke};

/// Pixels of the file per pixel of the drawing: text stays sharp on fine screens and in print.
const FINENESS: f64 = 2.0;
/// Largest number of pixels of a file; a larger drawing gets fewer file pixels per pixel of the drawing.
const LARGEST: f64 = 4e7;
/// Coordinates beyond this are clipped: invisible, and inexact in the painter's numbers. `[pixel]`
const FAR: f64 = 1e5;
/// Text.
const TEXT: Color = [34; 3];

/// Encodes a drawing as a PNG file; `None` if memory is missing.
pub fn png(drawing: &Drawing) -> Option<Vec<u8>> {
    painted(drawing, FINENESS)?.encode_png().ok()
}

/// Paints a drawing with `fineness` pixels per pixel of the drawing, fewer for a very large drawing.
pub fn painted(drawing: &Drawing, fineness: f64) -> Option<Pixmap> {
    let [width, height] = drawing.size.map(f64::ceil);
    let fineness = fineness.min((LARGEST / (width * height)).sqrt());
    let mut pixels = Pixmap::new((width * fineness) as u32, (height * fineness) as u32)?;
    pixels.fill(tiny_skia::Color::WHITE);
    let whole = Transform::from_scale(fineness as f32, fineness as f32);
    let mut masks: Vec<Option<Rc<Mask>>> = Vec::new();
    for item in &drawing.items {
        let mask = masks.last().and_then(Option::as_deref);
        match item {
            Item::Shape { lines, ink } => {
                let Some(path) = path_of(lines) else { continue };
                match ink {
                    Ink::Fill(color) => pixels.fill_path(&path, &paint(*color, 1.0), FillRule::EvenOdd, whole, mask),
                    Ink::Stroke(stroke) => pixels.stroke_path(&path, &paint(stroke.color, stroke.opacity), &pen(stroke), whole, mask),
                }
            }
            Item::Text { at, text, size, anchor, is_upward } => {
                let Some(path) = text_path(text) else { continue };
                let width = text_width(text, *size);
                let shift = match anchor {
                    Anchor::Start => 0.0,
                    Anchor::Middle => -0.5 * width,
                    Anchor::End => -width,
                };
                let turn = if *is_upward { -90.0 } else { 0.0 };
                let place = Transform::from_scale(*size as f32, *size as f32)
                    .post_translate(shift as f32, 0.0)
                    .post_concat(Transform::from_rotate(turn))
                    .post_translate(at[0] as f32, at[1] as f32);
                pixels.fill_path(&path, &paint(TEXT, 1.0), FillRule::Winding, place.post_concat(whole), mask);
            }
            Item::Named(_) => {
                let same = masks.last().cloned().flatten();
                masks.push(same);
            }
            Item::Clipped { low, high } => {
                let mut mask = Mask::new(pixels.width(), pixels.height());
                let corners = [*low, [high[0], low[1]], *high, [low[0], high[1]]];
                if let (Some(mask), Some(path)) = (&mut mask, path_of(&[Line::closed(corners)])) {
                    mask.fill_path(&path, FillRule::Winding, true, whole);
                }
                masks.push(mask.map(Rc::new));
            }
            Item::End => drop(masks.pop()),
        }
    }
    Some(pixels)
}

fn paint([red, green, blue]: Color, opacity: f64) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(red, green, blue, (255.0 * opacity).round() as u8);
    paint
}

fn pen(stroke: &Stroke) -> Pen {
    let dash = stroke.dash.and_then(|length| StrokeDash::new(vec![length as f32; 2], 0.0));
    let line_cap = if dash.is_some() { LineCap::Butt } else { LineCap::Round };
    Pen { width: stroke.width as f32, line_cap, line_join: LineJoin::Round, dash, ..Pen::default() }
}

fn path_of(lines: &[Line]) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for line in lines {
        for (index, point) in line.points.iter().enumerate() {
            let [x, y] = near(*point);
            if index == 0 { builder.move_to(x, y) } else { builder.line_to(x, y) }
        }
        if let [point] = line.points[..] {
            let [x, y] = near(point);
            builder.line_to(x, y);
        }
        if line.is_closed && line.points.len() > 1 {
            builder.close();
        }
    }
    builder.finish()
}

fn near(point: Point) -> [f32; 2] {
    point.map(|x| if x.is_nan() { 0.0 } else { x.clamp(-FAR, FAR) as f32 })
}

/// Outlines of a text of size 1 from the origin to the right.
fn text_path(text: &str) -> Option<Path> {
    let mut letters = Letters { builder: PathBuilder::new(), at: 0.0, unit: unit() as f32 };
    for letter in text.chars() {
        outline(letter, &mut letters);
        letters.at += advance(letter) as f32;
    }
    letters.builder.finish()
}

/// Collects outlines of letters.
struct Letters {
    builder: PathBuilder,
    at: f32,
    unit: f32,
}

impl Letters {
    fn place(&self, x: f32, y: f32) -> (f32, f32) {
        (self.at + x * self.unit, -y * self.unit)
    }
}

impl OutlineBuilder for Letters {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.place(x, y);
        self.builder.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.place(x, y);
        self.builder.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.place(x1, y1), self.place(x, y));
        self.builder.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.place(x1, y1), self.place(x2, y2), self.place(x, y));
        self.builder.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.builder.close();
    }
}
