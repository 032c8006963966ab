//! Convex corners of two surfaces that have slipped past each other: they cross, and no node is inside the other body.
//!
//! Two wedges are apart where the line of a side of one of them has the other one wholly in front of it, so of their four sides those count
//! beyond which the other wedge opens away, each by the distance of its tip. The largest of these distances is how far the wedges are
//! apart, or, negative, what it takes to part them (the separating axes of two convex sets). The distance of a tip from the body's own
//! corner, where the nearer of both sides counts, sees the tip outside again once it has come through.

/// A corner of a surface: its node, and those before and after it, the body on the left.
#[derive(Clone, Copy, Debug)]
pub struct Tip {
    pub before: [f64; 2],
    pub at: [f64; 2],
    pub after: [f64; 2],
}

/// A side of a tip: from where, and along what.
type Line = ([f64; 2], [f64; 2]);

fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

/// How far a direction leads out of the body behind a line, over the line's length.
fn outward(t: [f64; 2], d: [f64; 2]) -> f64 {
    (t[1] * d[0] - t[0] * d[1]) / t[0].hypot(t[1])
}

impl Tip {
    fn sides(&self) -> [Line; 2] {
        [(self.before, minus(self.at, self.before)), (self.at, minus(self.after, self.at))]
    }

    fn is_convex(&self) -> bool {
        let [(_, t), (_, u)] = self.sides();
        t[0] * u[1] - t[1] * u[0] > 0.0
    }

    /// Distance of a point from each side, negative behind it.
    fn gaps(&self, x: [f64; 2]) -> [f64; 2] {
        self.sides().map(|(from, along)| outward(along, minus(x, from)))
    }

    fn holds(&self, x: [f64; 2]) -> bool {
        self.gaps(x).iter().all(|gap| *gap < 0.0)
    }

    /// For each side the distance of another tip from it, where the other body opens away from it.
    fn apart(&self, other: &Tip) -> [Option<f64>; 2] {
        let gaps = self.gaps(other.at);
        [0, 1].map(|side| {
            let (_, along) = self.sides()[side];
            let opens = |end: [f64; 2]| outward(along, minus(end, other.at)) > 0.0;
            (opens(other.before) && opens(other.after)).then_some(gaps[side])
        })
    }

    /// Whether a side of one crosses a side of the other.
    fn crosses(&self, other: &Tip) -> bool {
        let is_cut = |(from, along): Line, (start, way): Line| {
            let side = |x: [f64; 2]| outward(along, minus(x, from));
            side(start) * side([start[0] + way[0], start[1] + way[1]]) < 0.0
        };
        self.sides().iter().any(|&own| other.sides().iter().any(|&side| is_cut(own, side) && is_cut(side, own)))
    }

    /// The side (0: before, 1: after the node) of another tip through which this one has come and out again, if it is the line of that side
    /// that parts them with the least motion.
    pub fn came_through(&self, other: &Tip) -> Option<usize> {
        let is_possible = self.is_convex() && other.is_convex() && !other.holds(self.at) && !self.holds(other.at);
        if !is_possible || !self.crosses(other) {
            return None;
        }
        let largest = |apart: [Option<f64>; 2]| {
            let known = apart.into_iter().enumerate().filter_map(|(side, gap)| Some((side, gap?)));
            known.max_by(|a, b| a.1.total_cmp(&b.1))
        };
        let (side, gap) = largest(other.apart(self))?;
        let back = largest(self.apart(other)).map_or(f64::NEG_INFINITY, |(_, gap)| gap);
        (gap < 0.0 && gap >= back).then_some(side)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A corner half as wide as it is long, its tip at `x`, that points to the right or up.
    fn tip(points_up: bool, x: [f64; 2]) -> Tip {
        let at = |[a, b]: [f64; 2]| if points_up { [x[0] - b, x[1] + a] } else { [x[0] + a, x[1] + b] };
        Tip { before: at([-1.0, -0.5]), at: x, after: at([-1.0, 0.5]) }
    }

    #[test]
    fn the_side_that_a_tip_has_come_through_parts_them() {
        let up = tip(true, [0.0, 0.0]);
        // Beside the other one, in it, through it, so far through that the other one's tip is nearer, above it.
        let places = [[-0.3, -0.3], [0.0, -0.3], [0.2, -0.3], [0.4, -0.3], [0.2, 0.4]];
        let found = places.map(|x| [tip(false, x).came_through(&up), up.came_through(&tip(false, x))]);
        assert_eq!(found, [[None; 2], [None; 2], [Some(1), None], [None, Some(0)], [None; 2]]);
    }
}
