//! Histories drawn with characters: curves of braille dots between two axes, each named at its end.
//!
//! Implemented here because the crates for this purpose (`textplots`, `rasciigraph`) have one label per axis end and no names at the
//! curves. A character has two by four dots; with colors a character has that of the last curve through it.

use super::axis::Axis;
use crate::math::tolerances::PLOT_END;

/// Width of the drawing in characters.
const WIDTH: usize = 72;
const HEIGHT: usize = 16;
/// Colors of a terminal, one for each curve.
const COLORS: [u8; 6] = [34, 31, 32, 35, 33, 36];
/// Bits of the dots of a letter, by row and column.
const DOTS: [[u32; 2]; 4] = [[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]];

/// Columns over a variable as lines of text; values that are not finite leave a gap.
pub fn braille_plot(title: &str, variable: &str, x: &[f64], columns: &[(&str, &[f64])], is_colored: bool) -> String {
    let vertical = Axis::over(columns.iter().flat_map(|(_, values)| values.iter().copied()), 5).widened(0.02);
    let horizontal = Axis::over(x.iter().copied(), 6);
    let column = |value: f64| place(horizontal.scaled(value), horizontal.low, horizontal.high, 2 * WIDTH);
    let row = |value: f64| place(vertical.scaled(value), vertical.low, vertical.high, 4 * HEIGHT).map(|row| 4 * HEIGHT - 1 - row);
    let paint = |text: &str, curve: usize| match is_colored {
        true => format!("\x1b[{}m{text}\x1b[0m", COLORS[curve % COLORS.len()]),
        false => text.to_string(),
    };

    let mut letters = vec![[(0u32, 0usize); WIDTH]; HEIGHT];
    let mut names: Vec<Option<usize>> = vec![None; HEIGHT];
    for (curve, (_, values)) in columns.iter().enumerate() {
        let mut last: Option<(usize, usize)> = None;
        let mut end = None;
        for (x, value) in x.iter().zip(*values) {
            let Some(dot) = column(*x).zip(row(*value)) else {
                last = None;
                continue;
            };
            let (c_0, r_0) = last.unwrap_or(dot);
            let steps = c_0.abs_diff(dot.0).max(r_0.abs_diff(dot.1)).max(1);
            for step in 0..=steps {
                let between =
                    |from: usize, to: usize| (from as f64 + (to as f64 - from as f64) * step as f64 / steps as f64).round() as usize;
                let (c, r) = (between(c_0, dot.0), between(r_0, dot.1));
                let letter = &mut letters[r / 4][c / 2];
                *letter = (letter.0 | DOTS[r % 4][c % 2], curve);
            }
            (last, end) = (Some(dot), Some(dot.1 / 4));
        }
        // The name is printed at the end of the curve, or in the nearest free line.
        if let Some(end) = end {
            let free = (0..HEIGHT).filter(|&line| names[line].is_none()).min_by_key(|line| line.abs_diff(end));
            free.into_iter().for_each(|line| names[line] = Some(curve));
        }
    }

    let mut labels = vec![String::new(); HEIGHT];
    for &tick in &vertical.ticks {
        if let Some(row) = row(vertical.unscaled(tick)) {
            labels[row / 4] = vertical.label(tick);
        }
    }
    let margin = labels.iter().map(|label| label.chars().count()).max().unwrap_or(0);
    let mut lines = vec![format!("{:margin$} {}", "", vertical.name(title))];
    for (line, letters) in letters.iter().enumerate() {
        let mark = if labels[line].is_empty() { '│' } else { '┤' };
        let mut text = format!("{:>margin$} {mark}", labels[line]);
        for (bits, curve) in letters {
            match bits {
                0 => text.push(' '),
                _ => text += &paint(&char::from_u32(0x2800 + bits).unwrap_or(' ').to_string(), *curve),
            }
        }
        match names[line] {
            Some(curve) => text += &format!(" {}", paint(columns[curve].0, curve)),
            None => text.truncate(text.trim_end().len()),
        }
        lines.push(text);
    }
    let (mut rule, mut below) = (vec!['─'; WIDTH], String::new());
    for &tick in &horizontal.ticks {
        let Some(at) = column(horizontal.unscaled(tick)).map(|dot| dot / 2) else { continue };
        rule[at] = '┬';
        let label = horizontal.label(tick);
        let start = at.saturating_sub(label.chars().count() / 2);
        let length = below.chars().count();
        if length == 0 || start > length {
            below.extend(std::iter::repeat_n(' ', start - length));
            below += &label;
        }
    }
    lines.push(format!("{:margin$} └{}", "", rule.into_iter().collect::<String>()));
    lines.push(format!("{:margin$}  {below}  {}", "", horizontal.name(variable)));
    lines.join("\n")
}

/// Returns the index of the dot (of `count` between `low` and `high`) for a value.
fn place(value: f64, low: f64, high: f64, count: usize) -> Option<usize> {
    let share = (value - low) / (high - low);
    (share.is_finite() && (-PLOT_END..=1.0 + PLOT_END).contains(&share))
        .then(|| ((share * (count - 1) as f64).round() as usize).min(count - 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rising_line_goes_from_the_lower_left_to_the_upper_right() {
        let x: Vec<f64> = (0..50).map(f64::from).collect();
        let text = braille_plot("run", "time", &x, &[("y", &x)], false);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), HEIGHT + 3);
        let first = |line: usize| lines[line].chars().position(|letter| ('\u{2801}'..='\u{28ff}').contains(&letter)).unwrap();
        assert!((1..HEIGHT).all(|line| first(line) > first(line + 1)), "{text}");
        assert!(lines[1].ends_with(" y") && !text.contains('\x1b'), "{text}");
        assert!(lines[HEIGHT + 2].contains("0") && lines[HEIGHT + 2].ends_with("time"), "{text}");
    }

    #[test]
    fn nothing_a_constant_and_gaps_can_be_drawn() {
        braille_plot("empty", "time", &[], &[("y", &[])], true);
        let text = braille_plot("gap", "time", &[0.0, 1.0, 2.0], &[("a", &[1.0, f64::NAN, 1.0]), ("b", &[1.0; 3])], true);
        assert!(text.contains(" \x1b[34ma\x1b[0m") && text.contains("\x1b[31mb\x1b[0m"), "{text}");
    }
}
