//! A series of drawings as an animated PNG or GIF.
//!
//! Both formats have one palette for all pictures: the 255 most frequent colors of some of them, and one index for unchanged pixels. A
//! picture is written as the rectangle that differs from the previous one. Pictures have few flat colors with smoothed borders, so that the
//! palette is not visible; photographs would need another method.

use std::borrow::Cow;
use std::cmp::Reverse;
use std::collections::HashMap;

use super::drawing::{Drawing, painted};

/// File formats of a movie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MovieFormat {
    /// Animated PNG.
    Png,
    /// GIF.
    Gif,
}

/// Largest number of pictures whose colors determine the palette.
const SAMPLES: usize = 6;
/// Palette index of unchanged pixels.
const SAME: u8 = 255;
/// Shortest time of a picture that browsers keep, in hundredths of a second.
const SHORTEST: u16 = 2;

/// Palette, with cached indices of other colors.
struct Palette {
    colors: Vec<[u8; 3]>,
    known: HashMap<[u8; 3], u8>,
}

impl Palette {
    fn new(samples: impl Iterator<Item = Vec<[u8; 3]>>) -> Self {
        let mut counts: HashMap<[u8; 3], usize> = HashMap::new();
        samples.flatten().for_each(|color| *counts.entry(color).or_default() += 1);
        let mut colors: Vec<([u8; 3], usize)> = counts.into_iter().collect();
        colors.sort_unstable_by_key(|&(color, count)| (Reverse(count), color));
        colors.truncate(usize::from(SAME));
        let colors: Vec<[u8; 3]> = colors.into_iter().map(|(color, _)| color).collect();
        Palette { colors, known: HashMap::new() }
    }

    /// Index of the nearest color, the first of equally near ones.
    fn index(&mut self, color: [u8; 3]) -> u8 {
        let colors = &self.colors;
        *self.known.entry(color).or_insert_with(|| {
            let distance = |other: &[u8; 3]| (0..3).map(|i| (i32::from(other[i]) - i32::from(color[i])).pow(2)).sum::<i32>();
            (0..colors.len()).min_by_key(|&index| distance(&colors[index])).unwrap_or(0) as u8
        })
    }

    /// Bytes of all 256 palette entries.
    fn bytes(&self) -> Vec<u8> {
        let mut bytes: Vec<u8> = self.colors.iter().flatten().copied().collect();
        bytes.resize(3 * 256, 255);
        bytes
    }
}

/// Part of a picture that differs from the previous one.
struct Part {
    left: u32,
    top: u32,
    width: u32,
    height: u32,
    indices: Vec<u8>,
}

impl Part {
    fn new(before: Option<&[u8]>, now: &[u8], width: u32) -> Part {
        let wide = width as usize;
        let Some(before) = before else {
            return Part { left: 0, top: 0, width, height: (now.len() / wide) as u32, indices: now.to_vec() };
        };
        let changed = (0..now.len()).filter(|&at| before[at] != now[at]);
        let (mut left, mut right, mut top, mut bottom) = (wide, 0, usize::MAX, 0);
        for at in changed {
            (left, right) = (left.min(at % wide), right.max(at % wide));
            (top, bottom) = (top.min(at / wide), bottom.max(at / wide));
        }
        if left > right {
            return Part { left: 0, top: 0, width: 1, height: 1, indices: vec![SAME] };
        }
        let row = |y: usize| (left..=right).map(move |x| y * wide + x);
        let index = |at: usize| if before[at] == now[at] { SAME } else { now[at] };
        let indices = (top..=bottom).flat_map(row).map(index).collect();
        Part { left: left as u32, top: top as u32, width: (right - left + 1) as u32, height: (bottom - top + 1) as u32, indices }
    }
}

/// Returns a repeating movie of `count` drawings of equal size with a duration of `seconds`; `None` if memory for a picture is missing,
/// sizes differ, or `draw` fails.
pub fn movie(count: usize, draw: &dyn Fn(usize) -> Option<Drawing>, seconds: f64, format: MovieFormat) -> Option<Vec<u8>> {
    let pixels = |index: usize| -> Option<(u32, u32, Vec<[u8; 3]>)> {
        let picture = painted(&draw(index)?, 1.0)?;
        let colors = picture.data().chunks_exact(4).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
        Some((picture.width(), picture.height(), colors))
    };
    let (width, height, _) = pixels(0)?;
    let taken = count.min(SAMPLES);
    let samples = (0..taken).map(|k| k * (count - 1) / (taken - 1).max(1));
    let mut palette = Palette::new(samples.filter_map(&pixels).map(|(.., colors)| colors));
    let entries = palette.bytes();
    let mut before: Option<Vec<u8>> = None;
    let mut parts = (0..count).map(|index| {
        let (.., colors) = pixels(index).filter(|&(w, h, _)| (w, h) == (width, height))?;
        let now: Vec<u8> = colors.into_iter().map(|color| palette.index(color)).collect();
        let part = Part::new(before.as_deref(), &now, width);
        before = Some(now);
        Some(part)
    });
    match format {
        MovieFormat::Png => png(&mut parts, count, [width, height], entries, seconds),
        MovieFormat::Gif => gif(&mut parts, count, [width, height], &entries, seconds),
    }
}

fn png(parts: &mut dyn Iterator<Item = Option<Part>>, count: usize, size: [u32; 2], entries: Vec<u8>, seconds: f64) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut bytes, size[0], size[1]);
    encoder.set_color(::png::ColorType::Indexed);
    encoder.set_depth(::png::BitDepth::Eight);
    encoder.set_palette(entries);
    let mut opacity = vec![255; 256];
    opacity[usize::from(SAME)] = 0;
    encoder.set_trns(opacity);
    encoder.set_animated(count as u32, 0).ok()?;
    encoder.set_frame_delay((1000.0 * seconds / count as f64).round().clamp(1.0, 65535.0) as u16, 1000).ok()?;
    let mut writer = encoder.write_header().ok()?;
    for (index, part) in parts.enumerate() {
        let part = part?;
        if index > 0 {
            writer.reset_frame_position().ok()?;
            writer.set_frame_dimension(part.width, part.height).ok()?;
            writer.set_frame_position(part.left, part.top).ok()?;
            writer.set_blend_op(::png::BlendOp::Over).ok()?;
        }
        writer.write_image_data(&part.indices).ok()?;
    }
    writer.finish().ok()?;
    Some(bytes)
}

fn gif(parts: &mut dyn Iterator<Item = Option<Part>>, count: usize, size: [u32; 2], entries: &[u8], seconds: f64) -> Option<Vec<u8>> {
    let short = |x: u32| u16::try_from(x).ok();
    let delay = (100.0 * seconds / count as f64).round().clamp(f64::from(SHORTEST), 65535.0) as u16;
    let mut encoder = ::gif::Encoder::new(Vec::new(), short(size[0])?, short(size[1])?, entries).ok()?;
    encoder.set_repeat(::gif::Repeat::Infinite).ok()?;
    for part in parts {
        let Part { left, top, width, height, indices } = part?;
        let frame = ::gif::Frame {
            delay,
            dispose: ::gif::DisposalMethod::Keep,
            transparent: Some(SAME),
            left: short(left)?,
            top: short(top)?,
            width: short(width)?,
            height: short(height)?,
            buffer: Cow::Owned(indices),
            ..::gif::Frame::default()
        };
        encoder.write_frame(&frame).ok()?;
    }
    encoder.into_inner().ok()
}

#[cfg(test)]
mod tests {
    use super::super::drawing::{Ink, Line};
    use super::*;

    /// A square that moves to the right.
    fn square(index: usize) -> Drawing {
        let mut drawing = Drawing::new([60.0, 40.0]);
        let left = 5.0 + 10.0 * index as f64;
        let corners = [[left, 10.0], [left + 8.0, 10.0], [left + 8.0, 18.0], [left, 18.0]];
        drawing.paint(vec![Line::closed(corners)], Ink::Fill([68, 1, 84]));
        drawing
    }

    /// Pictures of an animated PNG, composed as by a viewer.
    fn played(bytes: &[u8]) -> Vec<Vec<[u8; 3]>> {
        let mut decoder = ::png::Decoder::new(std::io::Cursor::new(bytes));
        decoder.set_transformations(::png::Transformations::EXPAND | ::png::Transformations::ALPHA);
        let mut reader = decoder.read_info().unwrap();
        let (count, width) = (reader.info().animation_control.unwrap().num_frames, reader.info().width as usize);
        let mut canvas = vec![[0; 3]; width * reader.info().height as usize];
        let mut all = Vec::new();
        for _ in 0..count {
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut pixels).unwrap();
            let control = *reader.info().frame_control().unwrap();
            for (at, pixel) in pixels.chunks_exact(4).take((control.width * control.height) as usize).enumerate() {
                let (x, y) = (at % control.width as usize, at / control.width as usize);
                if pixel[3] > 0 {
                    canvas[(control.y_offset as usize + y) * width + control.x_offset as usize + x] = [pixel[0], pixel[1], pixel[2]];
                }
            }
            all.push(canvas.clone());
        }
        all
    }

    #[test]
    fn an_animated_png_plays_what_was_drawn() {
        let bytes = movie(4, &|index| Some(square(index)), 2.0, MovieFormat::Png).unwrap();
        let played = played(&bytes);
        assert_eq!(played.len(), 4);
        for (index, picture) in played.iter().enumerate() {
            let drawn: Vec<[u8; 3]> = painted(&square(index), 1.0).unwrap().data().chunks(4).map(|p| [p[0], p[1], p[2]]).collect();
            assert!(*picture == drawn, "picture {index}");
        }
    }

    #[test]
    fn a_gif_has_all_pictures_with_their_times() {
        let bytes = movie(4, &|index| Some(square(index)), 2.0, MovieFormat::Gif).unwrap();
        let mut options = ::gif::DecodeOptions::new();
        options.set_color_output(::gif::ColorOutput::Indexed);
        let mut decoder = options.read_info(&*bytes).unwrap();
        let (mut count, mut first) = (0, 0);
        while let Some(frame) = decoder.read_next_frame().unwrap() {
            assert_eq!((frame.delay, frame.dispose), (50, ::gif::DisposalMethod::Keep));
            first = first.max(usize::from(frame.width) * usize::from(frame.height));
            count += 1;
            assert!(count == 1 || frame.width == 18 && frame.height == 8, "only what has changed");
        }
        assert_eq!((count, first), (4, 60 * 40));
    }

    #[test]
    fn one_picture_and_pictures_that_stay_are_movies_too() {
        for format in [MovieFormat::Png, MovieFormat::Gif] {
            assert!(movie(1, &|index| Some(square(index)), 1.0, format).is_some());
            assert!(movie(3, &|_| Some(square(0)), 1.0, format).is_some());
        }
    }
}
