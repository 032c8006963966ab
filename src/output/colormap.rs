//! Viridis: a color map with uniformly increasing lightness, so that equal steps of a value appear as equal steps.
//!
//! Every sixteenth of the 256 colors of N. Smith & S. van der Walt (matplotlib 2.0, released under CC0), linearly interpolated: the largest
//! error of a channel is 6 of 255.

const COLORS: [[f64; 3]; 17] = [
    [68.0, 1.0, 84.0],
    [72.0, 24.0, 106.0],
    [71.0, 45.0, 123.0],
    [66.0, 64.0, 134.0],
    [59.0, 82.0, 139.0],
    [51.0, 99.0, 141.0],
    [44.0, 114.0, 142.0],
    [38.0, 130.0, 142.0],
    [33.0, 145.0, 140.0],
    [31.0, 160.0, 136.0],
    [40.0, 174.0, 128.0],
    [63.0, 188.0, 115.0],
    [94.0, 201.0, 98.0],
    [132.0, 212.0, 75.0],
    [173.0, 220.0, 48.0],
    [216.0, 226.0, 25.0],
    [253.0, 231.0, 37.0],
];

/// Red, green and blue from 0 to 255 at a position from 0 (dark violet) to 1 (yellow); positions beyond are clamped, NaN counts as 0.
pub(super) fn viridis(place: f64) -> [f64; 3] {
    let place = if place.is_nan() { 0.0 } else { place.clamp(0.0, 1.0) } * (COLORS.len() - 1) as f64;
    let below = (place.floor() as usize).min(COLORS.len() - 2);
    let share = place - below as f64;
    [0, 1, 2].map(|channel| (1.0 - share) * COLORS[below][channel] + share * COLORS[below + 1][channel])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_the_middle_and_what_lies_outside() {
        assert_eq!(viridis(0.0), [68.0, 1.0, 84.0]);
        assert_eq!(viridis(0.5), [33.0, 145.0, 140.0]);
        assert_eq!(viridis(1.0), [253.0, 231.0, 37.0]);
        assert_eq!((viridis(-3.0), viridis(7.0)), (viridis(0.0), viridis(1.0)));
        assert_eq!(viridis(f64::NAN), viridis(0.0));
    }

    #[test]
    fn lightness_grows_all_the_way() {
        let lightness = |place: f64| {
            let [red, green, blue] = viridis(place).map(|channel| (channel / 255.0).powf(2.2));
            0.2126 * red + 0.7152 * green + 0.0722 * blue
        };
        assert!((0..100).all(|i| lightness(f64::from(i) / 100.0) < lightness(f64::from(i + 1) / 100.0)));
    }
}
