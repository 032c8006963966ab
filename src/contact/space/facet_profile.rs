//! Height profile of a facet: heights of second degree over its triangles, and those of fourth degree of primary facets (`profiles.rs`).

use std::sync::Arc;

use super::forms::{Form, derivatives, form, value};
use super::interior::Interior;
use super::quartic::{Closed, Quartic};
use super::stretch::{Stretch, Stretched};
use super::vectors::Vec3;
use crate::contact::faces::Vector;

/// Iterations for the point of a tilted triangle below a point of the curve; one iteration is exact to second order in the tilt.
const TILTS: usize = 3;

/// Height profile of a facet of three nodes, or of the four triangles about the mean point of a facet of four nodes `[length]`, outwards.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Profile {
    forms: [Form; 4],
    /// Heights of fourth degree over the triangles; `None`: those of second degree.
    quartics: Option<Arc<[Quartic; 4]>>,
    /// Polynomials of the closed gap over the triangles of a primary facet, with the first two corners exchanged.
    closed: Option<Arc<[Closed; 4]>>,
    is_curved: bool,
    /// Heights of the curve over the corners `[length]`.
    corners: [f64; 4],
    /// Factor of the height in deformed configurations.
    pub stretch: Stretch,
}

impl Profile {
    /// Profile from the heights of the curve over the corners and the sagittas of the sides, indexed by the corner at which the side
    /// starts. Inside a facet of four nodes: serendipity interpolation for a plane parallelogram.
    #[cfg(test)]
    pub fn new(corners: &[f64], sagittas: &[f64]) -> Self {
        match (corners.try_into(), sagittas.try_into()) {
            (Ok(corners), Ok(sagittas)) => Self::of_four(&corners, &sagittas, &Interior::of_sides(&corners, &sagittas)),
            _ => Self::of_three([corners[0], corners[1], corners[2]], [sagittas[0], sagittas[1], sagittas[2]]),
        }
    }

    /// Profile of a facet of three nodes.
    pub fn of_three(corners: [f64; 3], sagittas: [f64; 3]) -> Self {
        Self::of_form(form(corners, sagittas))
    }

    /// Profile of a facet of three nodes with this height.
    pub fn of_form(form: Form) -> Self {
        let mut profile = Profile { forms: [[0.0; 6]; 4], is_curved: true, ..Profile::default() };
        profile.forms[0] = form;
        profile.corners[..3].copy_from_slice(&form[..3]);
        profile
    }

    /// Profile of a facet of four nodes from the heights over its four triangles.
    pub fn of_four(corners: &[f64; 4], sagittas: &[f64; 4], interior: &Interior) -> Self {
        let Interior { middle, spokes, .. } = interior;
        let of = |k: usize| {
            let next = (k + 1) % 4;
            let mut form = form([corners[k], corners[next], *middle], [sagittas[k], spokes[next], spokes[k]]);
            let quartic = interior.quartic(k, &form);
            interior.even(k, &mut form);
            (form, quartic)
        };
        let [a, b, c, d] = [0, 1, 2, 3].map(of);
        Self::of_forms([a.0, b.0, c.0, d.0], *corners).with_quartics([a.1, b.1, c.1, d.1])
    }

    /// Heights along the normal of each triangle of a facet with these nodes, from heights along the unit normal of the facet. Triangles of
    /// warped facets are tilted against it.
    ///
    /// The curve at the height `H` along the facet's normal `n` over `x` has the height `H (n.t)` along the triangle's normal `t` over
    /// `x + H (n - (n.t) t)`.
    pub fn across_triangles(mut self, nodes: &[Vector], normal: Vector) -> Self {
        let &[a, b, c, d] = nodes else { return self };
        let middle = 0.25 * (a + b + c + d);
        let mut quartics = self.quartics.as_deref().copied();
        for (k, [a, b]) in [[a, b], [b, c], [c, d], [d, a]].into_iter().enumerate() {
            let form = &mut self.forms[k];
            let [first, second] = [b - a, middle - a];
            let area = first.cross(&second);
            let Some(own) = area.try_normalize(0.0) else { continue };
            let slope = normal.dot(&own);
            let shift = normal - own * slope;
            let [of_b, of_middle] = [shift.cross(&second), first.cross(&shift)].map(|part| part.dot(&area) / area.norm_squared());
            let by = [-of_b - of_middle, of_b, of_middle];
            let along = |height: &dyn Fn(&[f64; 3]) -> f64, at: [f64; 3]| {
                let mut found = height(&at);
                for _ in 0..TILTS {
                    found = height(&[0, 1, 2].map(|i| at[i] - found * by[i]));
                }
                found * slope
            };
            if let Some(quartic) = quartics.as_mut().map(|quartics| &mut quartics[k]) {
                let before = *quartic;
                *quartic = Quartic::projection(|[x, y]| along(&|l| before.at([l[1], l[2]]), [1.0 - x - y, x, y]));
            }
            let height = |at: [f64; 3]| along(&|l| value(&derivatives(form, l), l), at);
            let [a, b, c] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(height);
            let [ab, bc, ca] = [[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]].map(height);
            *form = self::form([a, b, c], [ab - 0.5 * (a + b), bc - 0.5 * (b + c), ca - 0.5 * (c + a)]);
        }
        self.quartics = quartics.map(Arc::new);
        self
    }

    /// Profile with these heights of fourth degree.
    pub fn with_quartics(mut self, quartics: [Quartic; 4]) -> Self {
        self.quartics = Some(Arc::new(quartics));
        self
    }

    /// Profile of a secondary facet, which has heights of second degree alone: those of fourth degree contribute nothing to the weighted
    /// gaps of a covered facet, because their difference is orthogonal to the shape functions.
    pub fn of_secondary(mut self) -> Self {
        self.quartics = None;
        self
    }

    /// Profile of a primary facet, with the polynomials that it needs as such.
    pub fn of_primary(mut self) -> Self {
        self.closed = self.is_curved.then(|| self.closing());
        self.quartics = None;
        self
    }

    /// Polynomials of the closed gap over the triangles, with the first two corners exchanged.
    pub fn closing(&self) -> Arc<[Closed; 4]> {
        let height = |k: usize| self.quartics.as_ref().map_or_else(|| Quartic::of_form(&self.forms[k]), |quartics| quartics[k]);
        let of = |k: usize| height(k).closed();
        self.closed.clone().unwrap_or_else(|| Arc::new([0, 1, 2, 3].map(of)))
    }

    /// True for a facet without curvature.
    #[inline(always)]
    pub fn is_flat(&self) -> bool {
        !self.is_curved
    }

    /// Height of the curve over corner `k` `[length]`.
    pub fn corner(&self, k: usize) -> f64 {
        self.corners[k]
    }

    /// Profile of a facet of four nodes with these heights over its four triangles, of a curve with the given heights over the corners.
    pub fn of_forms(forms: [Form; 4], corners: [f64; 4]) -> Self {
        Profile { forms, is_curved: true, corners, ..Profile::default() }
    }

    /// Profile that is multiplied by the stretch of its facet, whose nodes have these reference positions.
    pub fn on_facet(mut self, nodes: &[Vec3<f64>]) -> Self {
        if self.is_curved {
            self.stretch = Stretch::new(&self.forms, nodes);
        }
        self
    }

    /// Heights over the triangles in a deformed configuration, and the stretch of the facet there.
    #[inline(always)]
    pub fn stretched(&self, nodes: &[Vec3<f64>]) -> ([Form; 4], Stretched<f64>) {
        let (stretched, mut forms) = (self.stretch.at(nodes), self.forms);
        for form in &mut forms {
            for height in form {
                *height *= stretched.by;
            }
        }
        (forms, stretched)
    }

    /// Height as a function on triangle number `triangle` of the facet.
    #[inline(always)]
    pub fn form(&self, triangle: usize) -> &Form {
        &self.forms[triangle]
    }
}
