//! Selection of the rows of a long history that a report shows.

use crate::dynamics::{LedgerRow, Rows};

/// Largest number of rows in a report, besides those of its stills.
pub const ROWS: usize = 4000;
/// Number of measures whose peaks are kept.
pub const MEASURES: usize = 4;

/// Measures of a row: energy defect, iterations, halvings, contact force.
pub fn measures(row: &LedgerRow) -> [f64; MEASURES] {
    let force = row.contacts.iter().map(|contact| contact.normal_force).fold(0.0, f64::max);
    [row.energy_defect.abs(), row.newton_iterations as f64, row.halvings as f64, force]
}

/// Returns the indices of the rows in a report, ascending. Of a long history: those in `must`, the first and last, and in each interval the
/// last row and those with the largest energy defect, the most iterations, the most halvings and the largest contact force, so that no peak
/// is lost.
pub fn kept_rows<R: Rows + ?Sized>(rows: &R, must: &[usize]) -> Vec<usize> {
    thinned(rows, must, ROWS)
}

fn thinned<R: Rows + ?Sized>(rows: &R, must: &[usize], most: usize) -> Vec<usize> {
    let count = rows.count();
    if count <= most {
        return (0..count).collect();
    }
    let stretch = count.div_ceil(most / (MEASURES + 1)).max(1);
    let mut kept: Vec<usize> = must.iter().copied().filter(|&row| row < count).chain([0, count - 1]).collect();
    let (mut index, mut peaks) = (0usize, [(f64::NEG_INFINITY, 0); MEASURES]);
    rows.visit(0, &mut |row| {
        for ((largest, place), size) in peaks.iter_mut().zip(measures(row)) {
            // Of equal maxima, the first one is kept.
            if index.is_multiple_of(stretch) || size.total_cmp(largest).is_gt() {
                (*largest, *place) = (size, index);
            }
        }
        index += 1;
        if index.is_multiple_of(stretch) || index == count {
            kept.extend(peaks.iter().map(|(_, place)| *place).chain([index - 1]));
        }
    });
    kept.sort_unstable();
    kept.dedup();
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_history_is_whole_and_a_long_one_keeps_its_peaks() {
        let mut rows: Vec<LedgerRow> = (0..10_000).map(|step| LedgerRow { step, newton_iterations: 3, ..LedgerRow::default() }).collect();
        rows[1234].energy_defect = -1e-3;
        rows[777].newton_iterations = 17;
        rows[9_001].halvings = 2;
        assert_eq!(thinned(&rows[..100], &[], 100), (0..100).collect::<Vec<_>>());
        let kept = thinned(&rows, &[4321, 20_000], 1000);
        for row in [0, 777, 1234, 4321, 9_001, 9_999] {
            assert!(kept.contains(&row), "{row}");
        }
        assert!(kept.len() <= 1003 && kept.windows(2).all(|pair| pair[0] < pair[1]) && kept.len() >= 200, "{}", kept.len());
    }
}
