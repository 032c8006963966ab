//! Convex corners (tips) of two surfaces that cross: the side that separates them (separating axis; `node_to_segment.rs`).
//!
//! Two wedges are separated by the line of a side if the other wedge lies entirely in front of it. Candidates are those of the four sides
//! from which the other wedge opens away, each with the distance of the other tip. The largest of these distances is the separation of the
//! wedges; if negative, the least motion that separates them. The distance of a tip from the other body, defined by the nearer of its two
//! sides, would instead move the tip through the other wedge and count it as outside beyond.

/// Corner of a surface: positions of its node and of the nodes before and after it, with the body on the left.
#[derive(Clone, Copy, Debug)]
pub struct Tip {
    pub before: [f64; 2],
    pub at: [f64; 2],
    pub after: [f64; 2],
}

/// Sine of the smallest angle of a sharp corner, 20 degrees.
const SHARP: f64 = 0.342;

/// Side whose line separates two crossing tips with the least motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeparatingSide {
    /// Side of the other tip (0: before, 1: after its node).
    AtOther(usize),
    /// Side of the own tip; `misleading` marks sides of the other tip that do not separate them.
    AtOwn { misleading: [bool; 2] },
}

/// Side of a tip: start point and vector.
type Line = ([f64; 2], [f64; 2]);

fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

/// Component of a direction along the outward normal of a line.
fn outward(t: [f64; 2], d: [f64; 2]) -> f64 {
    (t[1] * d[0] - t[0] * d[1]) / t[0].hypot(t[1])
}

impl Tip {
    fn sides(&self) -> [Line; 2] {
        [(self.before, minus(self.at, self.before)), (self.at, minus(self.after, self.at))]
    }

    fn is_sharp(&self) -> bool {
        let [(_, t), (_, u)] = self.sides();
        t[0] * u[1] - t[1] * u[0] > SHARP * t[0].hypot(t[1]) * u[0].hypot(u[1])
    }

    /// Distance of a point from each side, negative behind it.
    fn gaps(&self, x: [f64; 2]) -> [f64; 2] {
        self.sides().map(|(from, along)| outward(along, minus(x, from)))
    }

    /// Distance of another tip from each side of this tip; `None` for sides from which the other body does not open away.
    fn apart(&self, other: &Tip) -> [Option<f64>; 2] {
        let gaps = self.gaps(other.at);
        [0, 1].map(|side| {
            let (_, along) = self.sides()[side];
            let opens = |end: [f64; 2]| outward(along, minus(end, other.at)) > 0.0;
            (opens(other.before) && opens(other.after)).then_some(gaps[side])
        })
    }

    /// True if a side of one tip crosses a side of the other.
    fn crosses(&self, other: &Tip) -> bool {
        let is_cut = |(from, along): Line, (start, way): Line| {
            let side = |x: [f64; 2]| outward(along, minus(x, from));
            side(start) * side([start[0] + way[0], start[1] + way[1]]) < 0.0
        };
        self.sides().iter().any(|&own| other.sides().iter().any(|&side| is_cut(own, side) && is_cut(side, own)))
    }

    /// Side that separates this tip from another one with the least motion; `None` unless both are sharp and cross.
    pub fn parting(&self, other: &Tip) -> Option<SeparatingSide> {
        if !self.is_sharp() || !other.is_sharp() || !self.crosses(other) {
            return None;
        }
        let largest = |apart: [Option<f64>; 2]| {
            let known = apart.into_iter().enumerate().filter_map(|(side, gap)| Some((gap?, side)));
            known.max_by(|a, b| a.0.total_cmp(&b.0))
        };
        let (others, own) = (other.apart(self), largest(self.apart(other)));
        let found = match (largest(others), own) {
            (Some((gap, side)), own) if own.is_none_or(|(own, _)| gap >= own) => (gap, SeparatingSide::AtOther(side)),
            (_, Some((gap, _))) => (gap, SeparatingSide::AtOwn { misleading: others.map(|gap| gap.is_none()) }),
            _ => return None,
        };
        (found.0 < 0.0).then_some(found.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Corner half as wide as long with its tip at `x`, pointing right or up.
    fn tip(points_up: bool, x: [f64; 2]) -> Tip {
        let at = |[a, b]: [f64; 2]| if points_up { [x[0] - b, x[1] + a] } else { [x[0] + a, x[1] + b] };
        Tip { before: at([-1.0, -0.5]), at: x, after: at([-1.0, 0.5]) }
    }

    #[test]
    fn what_parts_two_tips_is_the_least_motion_that_does() {
        let up = tip(true, [0.0, 0.0]);
        let parting = |x: [f64; 2]| [tip(false, x).parting(&up), up.parting(&tip(false, x))];
        // Tips beside each other, and one above the other: no crossing.
        assert_eq!([parting([-0.3, -0.3]), parting([0.2, 0.4])], [[None; 2]; 2]);
        // Slight penetration: the nearer side would move the tip through the other body; the other side separates them.
        for x in [[0.01, -0.3], [0.14, -0.3], [0.2, -0.3]] {
            let back = Some(SeparatingSide::AtOwn { misleading: [false, true] });
            assert_eq!(parting(x), [Some(SeparatingSide::AtOther(1)), back], "{x:?}");
        }
        // Deep penetration: one side of this tip is nearer to the other tip, but does not separate the bodies.
        let back = Some(SeparatingSide::AtOwn { misleading: [true, false] });
        assert_eq!(parting([0.4, -0.3]), [back, Some(SeparatingSide::AtOther(0))]);
    }
}
