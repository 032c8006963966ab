//! A drawing as SVG. Text stays text: the reader's own sans-serif font is used.
//!
//! Coordinates are whole tenths of a pixel, each relative to the one before, which keeps the file small.

use std::fmt::Write as _;

use super::super::markup::escaped;
use super::shapes::{Anchor, Drawing, Ink, Item, Line, Point};

/// Units of the drawing per pixel.
const UNIT: f64 = 10.0;
/// Coordinates beyond this are clipped, in units of the drawing.
const FAR: f64 = 1e6;

/// A drawing as the text of an SVG file.
pub fn svg(drawing: &Drawing) -> String {
    let [width, height] = drawing.size.map(f64::ceil);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {} {}\" font-family=\"sans-serif\" \
         fill=\"#222\" fill-rule=\"evenodd\" stroke-linejoin=\"round\" stroke-linecap=\"round\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
        width * UNIT,
        height * UNIT
    );
    let mut clips = 0;
    for item in &drawing.items {
        let _ = match item {
            Item::Shape { lines, ink } => shape_into(&mut out, lines, ink),
            Item::Text { at, text, size, anchor, is_upward } => {
                let [x, y] = at.map(units);
                let anchor = match anchor {
                    Anchor::Start => "",
                    Anchor::Middle => " text-anchor=\"middle\"",
                    Anchor::End => " text-anchor=\"end\"",
                };
                let place =
                    if *is_upward { format!("transform=\"translate({x} {y}) rotate(-90)\"") } else { format!("x=\"{x}\" y=\"{y}\"") };
                writeln!(out, "<text {place} font-size=\"{}\"{anchor}>{}</text>", units(*size), escaped(text))
            }
            Item::Named(name) => writeln!(out, "<g><title>{}</title>", escaped(name)),
            Item::Clipped { low, high } => {
                clips += 1;
                let [x, y, width, height] = [low[0], low[1], high[0] - low[0], high[1] - low[1]].map(units);
                let shape = format!("<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"/>");
                writeln!(out, "<clipPath id=\"c{clips}\">{shape}</clipPath>\n<g clip-path=\"url(#c{clips})\">")
            }
            Item::End => writeln!(out, "</g>"),
        };
    }
    out + "</svg>\n"
}

fn units(pixels: f64) -> i64 {
    if pixels.is_nan() { 0 } else { (pixels.clamp(-FAR, FAR) * UNIT).round() as i64 }
}

fn shape_into(out: &mut String, lines: &[Line], ink: &Ink) -> std::fmt::Result {
    let mut path = String::new();
    for line in lines {
        line_into(&mut path, &line.points, if line.is_closed { "z" } else { "" });
    }
    match ink {
        Ink::Fill([red, green, blue]) => writeln!(out, "<path d=\"{path}\" fill=\"#{red:02x}{green:02x}{blue:02x}\"/>"),
        Ink::Stroke(stroke) => {
            let [red, green, blue] = stroke.color;
            let _ = write!(out, "<path d=\"{path}\" fill=\"none\" stroke=\"#{red:02x}{green:02x}{blue:02x}\"");
            if stroke.opacity < 1.0 {
                let _ = write!(out, " stroke-opacity=\"{:.2}\"", stroke.opacity);
            }
            if let Some(dash) = stroke.dash {
                let _ = write!(out, " stroke-dasharray=\"{}\" stroke-linecap=\"butt\"", units(dash));
            }
            writeln!(out, " stroke-width=\"{}\"/>", units(stroke.width))
        }
    }
}

/// Points as path data in whole units, each relative to the one before; `close` is `z` for a closed path.
fn line_into(path: &mut String, points: &[Point], close: &str) {
    let mut last = [0i64; 2];
    for (index, point) in points.iter().enumerate() {
        let now = point.map(units);
        let [x, y] = [now[0] - last[0], now[1] - last[1]];
        if index > 0 && [x, y] == [0, 0] {
            continue;
        }
        let between = |number: i64| if number < 0 { "" } else { " " };
        let _ = match index {
            0 => write!(path, "M{x}{}{y}l", between(y)),
            _ if path.ends_with('l') => write!(path, "{x}{}{y}", between(y)),
            _ => write!(path, "{}{x}{}{y}", between(x), between(y)),
        };
        last = now;
    }
    // A single point is a dot.
    if path.ends_with('l') {
        path.push_str("0 0");
    }
    path.push_str(close);
}
