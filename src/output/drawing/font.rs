//! The font of PNG pictures, and widths of text.
//!
//! An SVG is shown in the reader's sans-serif font. The font of PNG pictures is one of the widest, so text that fits in it fits in others.

use std::sync::OnceLock;

use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// Reduced DejaVu Sans; license in `sans-LICENSE.txt`.
const SANS: &[u8] = include_bytes!("sans.ttf");
/// Width of a letter missing in the font, relative to the text size.
const MISSING: f64 = 0.6;

fn face() -> Option<&'static Face<'static>> {
    static FACE: OnceLock<Option<Face>> = OnceLock::new();
    FACE.get_or_init(|| Face::parse(SANS, 0).ok()).as_ref()
}

/// Width of a text in pixels.
pub(in crate::output) fn text_width(text: &str, size: f64) -> f64 {
    text.chars().map(|letter| advance(letter) * size).sum()
}

/// Width of a letter relative to the text size.
pub(super) fn advance(letter: char) -> f64 {
    let of = |face: &Face| Some(f64::from(face.glyph_hor_advance(glyph(face, letter)?)?) / f64::from(face.units_per_em()));
    face().and_then(of).unwrap_or(MISSING)
}

/// Passes the outline of a letter to `builder`, `y` upwards, in units of [`unit`]; a letter missing in the font is a box.
pub(super) fn outline(letter: char, builder: &mut dyn OutlineBuilder) {
    if let Some(face) = face() {
        face.outline_glyph(glyph(face, letter).unwrap_or(GlyphId(0)), builder);
    }
}

/// Length of one unit of an outline relative to the text size.
pub(super) fn unit() -> f64 {
    face().map_or(1.0, |face| 1.0 / f64::from(face.units_per_em()))
}

fn glyph(face: &Face, letter: char) -> Option<GlyphId> {
    face.glyph_index(letter)
}

/// Returns a text not wider than `width`; the excess is cut off and replaced by `…`.
pub(in crate::output) fn elided(text: &str, size: f64, width: f64) -> String {
    if text_width(text, size) <= width {
        return text.into();
    }
    let mut left = width - text_width("…", size);
    let kept = text.chars().take_while(|&letter| {
        left -= advance(letter) * size;
        left >= 0.0
    });
    kept.collect::<String>().trim_end().to_string() + "…"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_add_up_and_long_text_is_cut() {
        assert!((text_width("nn", 10.0) - 2.0 * text_width("n", 10.0)).abs() < 1e-12 && text_width("n", 10.0) > 5.0);
        assert_eq!(elided("total energy", 16.0, 1000.0), "total energy");
        let cut = elided("total energy of the bearing", 16.0, 100.0);
        assert!(cut.starts_with("total") && cut.ends_with('…') && text_width(&cut, 16.0) <= 100.0, "{cut}");
        assert_eq!(elided("total", 16.0, 0.0), "…");
    }

    #[test]
    fn the_font_has_the_signs_of_axes_and_fields() {
        let face = face().unwrap();
        assert!("aZ09−×·⁰¹²³⁴⁵⁶⁷⁸⁹⁻σµ…äéЖω°→".chars().all(|letter| glyph(face, letter).is_some()));
    }
}
